"""What the checks of all machines share: runs, notes, comparisons of algebraic results, motions, equilibria and their oscillations.

An equilibrium is found by kinetic damping of a simulation, which uses no equilibrium equation.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.engines import select_engine
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import initial_mode
from governor_mechanism.mechanics.dynamics.contacts import one_sided_forces_of
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.part import FreeSpindle, Spindle, Start
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.types import FloatArray, FloatOrArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.verification.report import ComparisonRow

N_JOINT_RECOVERY_STEPS = 3
"""Number of steps after a stop in which the joints recover from it; the kinetic energy there is not that of the oscillation."""


@dataclass(frozen=True, kw_only=True)
class RelaxationSettings:
    """Settings of a relaxation to equilibrium.

    `iterations` is the number of iterations of the joint solver. `step_ratio` is the step in time scales: it causes no error at rest, so
    it only has to be stable. `max_rest_speed_ratio` is the largest speed of the whole mass that counts as rest, in length scales per time
    scale. `max_steps` is the largest number of steps.
    """

    iterations: int = 60
    step_ratio: float = 0.05
    max_rest_speed_ratio: float = 1e-12
    max_steps: int = 400_000


def relax_to_equilibrium(
    scene: Scene,
    start: float,  # leading coordinate at which the mechanism is released, SI
    # step, solver iterations and what counts as rest; None takes the defaults
    settings: RelaxationSettings | None = None,
) -> float:
    """Return the equilibrium that a mechanism reaches from rest with its kinetic energy removed at each maximum.

    From one maximum to the next it swings from rest toward the equilibrium, which reduces the distance about a hundredfold. The spindle
    keeps its start speed. Friction and stops do not act.

    Raises RunFailed if the mechanism leaves its range or does not come to rest.
    """
    settings = settings or RelaxationSettings()
    mechanism, scale = scene.part.mechanism, time_scale(scene)
    mass = sum(body.mass for body in mechanism.bodies)
    max_rest_energy = 0.5 * mass * (settings.max_rest_speed_ratio * mechanism.length_scale / scale) ** 2
    model = PymunkModel(scene, iterations=settings.iterations)
    time_inputs = TimeInputs(scene)
    h = settings.step_ratio * scale
    one_sided, mode = one_sided_forces_of(scene), initial_mode(scene)

    def present_poses() -> FloatArray:
        return model.to_mass_centres(*model.state())[0]

    def present_value(reading: str) -> float:
        return float(evaluate_output_value(mechanism, reading, present_poses()))

    def follow_springs(poses: FloatArray) -> None:
        """Let the one-sided springs act that are taut at the poses."""
        nonlocal mode
        taut = tuple(float(evaluate_output_value(mechanism, spring.reading, poses)) > spring.slack_below for spring in one_sided)
        if taut != mode.taut:
            mode = replace(mode, taut=taut)
            model.forces.output_forces = make_system(scene, mode)[0].output_forces

    poses = PositionSolver(mechanism).solve_at_coordinate(start)
    follow_springs(poses)
    model.start(poses, np.zeros_like(poses), time_inputs.start_inputs(h))
    inputs = time_inputs.constant_inputs(h)
    max_energy = 0.0
    steps_since_stop = 0
    for _ in range(settings.max_steps):
        energy = model.kinetic_energy()
        if steps_since_stop > N_JOINT_RECOVERY_STEPS and energy < max_energy:  # just past the maximum, which is at the equilibrium
            value = present_value(mechanism.coordinate)
            if max_energy < max_rest_energy and np.isfinite(value):
                return value
            model.zero_velocities()
            max_energy, steps_since_stop = 0.0, 0
            if not all(limit.low < present_value(limit.reading) < limit.high for limit in mechanism.limits):
                break
        if steps_since_stop >= N_JOINT_RECOVERY_STEPS:
            max_energy = max(max_energy, energy)
        steps_since_stop += 1
        if one_sided:
            follow_springs(present_poses())
        model.step(inputs)
    raise RunFailed(
        f"released at {mechanism.coordinate} = {start:.6g}, the mechanism did not come to rest; "
        f"its last value is {present_value(mechanism.coordinate):.6g}"
    )


Checks = Iterator[ComparisonRow | str]
"""Comparisons, and notes on what is not checked."""

Acceleration = Callable[..., FloatOrArray]
"""Closed form of an acceleration; see `integrate_governor`."""

ALGEBRAIC_TOLERANCE = 1e-10
"""Relative tolerance of results without time integration; rounding and position assembly leave about 1e-12."""

REFERENCE_ERROR_RATIO = 1e-5
"""Tolerance of an integrated closed form relative to the accuracy of the run, for which its own error does not count."""

SMALL_AMPLITUDE = 1e-3
"""Amplitude of the small oscillation (rad); a second one has twice the amplitude."""


def run_scene(scene: Scene, times: FloatArray | None = None) -> Trajectory:
    """Return a run by the scene's own engine, at the scene's own times or at the given ones (s)."""
    engine, reason = select_engine(scene.run.engine, scene)
    return engine.run(scene, times=times, reason=reason)


def require_gravity_and_centrifugal(scene: Scene) -> None:
    """Raise MechanismError unless the scene has both effects that the closed forms of governors include."""
    if not (scene.gravity and scene.has_centrifugal):
        raise MechanismError(f"the closed forms of machine {scene.part.machine!r} need the effects gravity and centrifugal")


def without_output_effects(scene: Scene) -> Scene:
    """Return the scene without the effects along outputs."""
    return scene.with_changes(effects=tuple(effect for effect in scene.effects if not isinstance(effect, OutputEffect)))


def sleeve_damping(scene: Scene) -> float:
    """Return the damping of the dashpots of the scene (N s/m)."""
    return sum((effect.linear for effect in scene.effects if isinstance(effect, Dashpot)), 0.0)


def note_unsupported_effects(scene: Scene, *supported: type[OutputEffect]) -> str:
    """Return a note on effects along outputs, but for `supported` ones and linear dashpots, that the closed forms leave out, or ""."""
    effects = [effect for effect in scene.effects if isinstance(effect, OutputEffect) and not isinstance(effect, supported)]
    unsupported = [effect for effect in effects if not _is_linear_sleeve_dashpot(effect)]
    return f"motion is not checked: the closed form does not include {name_effects(unsupported)}" if unsupported else ""


def _is_linear_sleeve_dashpot(effect: Effect) -> bool:
    return isinstance(effect, Dashpot) and effect.reading == "sleeve_lift" and not effect.quadratic


def name_effects(effects: Iterable[Effect]) -> str:
    """Return the kinds of the effects as a phrase, such as "dashpot and dry friction"."""
    *names, last = dict.fromkeys(re.sub("(?<!^)([A-Z])", r" \1", type(effect).__name__).lower() for effect in effects)
    return f"{', '.join(names)} and {last}" if names else last


def travel_limits(scene: Scene, reading: str) -> tuple[float, float]:
    """Return the limits of a reading (SI)."""
    limit = next(limit for limit in scene.part.mechanism.limits if limit.reading == reading)
    return limit.low, limit.high


def note_early_end(run: Trajectory) -> Iterator[str]:
    """Yield a note on a run that ended early or missed its accuracy."""
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1] if len(run.times) else 0.0:.4g} of {run.scene.run.duration:.4g} s: {run.message}"


def compare_algebraic(
    quantity: str, simulated: FloatOrArray, expected: FloatOrArray, unit: str, scale: float | None = None
) -> ComparisonRow:
    """Return the comparison of two algebraic results; the tolerance is relative to the scale, or to the expected value."""
    allowed = ALGEBRAIC_TOLERANCE * abs(float(expected) if scale is None else scale)
    reason = "both are algebraic; rounding and position assembly leave about 1e-12"
    return ComparisonRow(quantity, float(simulated), float(expected), allowed, unit, reason)


def compare_largest_deviation(
    quantity: str, simulated: FloatArray, expected: FloatOrArray, places: Sequence[str], allowed: float, unit: str, reason: str
) -> ComparisonRow:
    """Return the comparison of two arrays (n,) at the place where they deviate most."""
    exact = np.asarray(expected)
    k = int(np.argmax(np.abs(simulated - exact)))
    return ComparisonRow(f"{quantity} (largest deviation, {places[k]})", float(simulated[k]), float(exact[k]), allowed, unit, reason)


def compare_in_motion(
    run: Trajectory, quantity: str, simulated: FloatArray, expected: FloatOrArray, allowed: float, unit: str, reason: str
) -> ComparisonRow:
    """Return the comparison of a quantity at the reported times where it deviates most."""
    return compare_largest_deviation(quantity, simulated, expected, [f"t = {time:.4g} s" for time in run.times], allowed, unit, reason)


def compare_reading(run: Trajectory, name: str, expected: FloatOrArray) -> ComparisonRow:
    """Return the comparison of a reading where it deviates most, over the reported times that `expected` (n,) covers."""
    simulated = run.readings[name][: np.size(expected)]
    allowed = run.scene.run.accuracy * run.scales[name]
    reason = "the requested accuracy times the scale of the reading"
    return compare_in_motion(run, f"{name.replace('_', ' ')} in motion", simulated, expected, allowed, run.units[name], reason)


def compare_jacobi_integral(run: Trajectory) -> ComparisonRow:
    """Return the comparison of the drift of the Jacobi integral with zero."""
    reason = "relative to mass x length scale^2 / time scale^2, like the accuracy"
    return ComparisonRow("Jacobi integral, largest change", run.energy.drift, 0.0, run.scene.run.accuracy, "1", reason)


def integrate_governor(
    run: Trajectory, n_times: int, angle: str, angular_acceleration: Acceleration, spindle_acceleration: Acceleration
) -> FloatArray:
    """Integrate a governor of one coordinate from the initial state of a run.

    angular_acceleration is a function of the angle (rad), its rate and spindle_speed (rad/s), named as in the closed forms;
    spindle_acceleration, of a free spindle, takes constant_inertia (kg m2) and torque (N m) too. Returns angle, rate and spindle speed at
    the first n_times reported times, shape (3, n_times).
    """
    spindle, times = run.scene.spindle, run.times[:n_times]
    names = (angle, angle.replace("angle", "rate"), "spindle_speed")
    drive = CubicTimeFunction(spindle.torque) if isinstance(spindle, FreeSpindle) else SpindleSpeedFunction(spindle)
    rtol = max(1e-13, REFERENCE_ERROR_RATIO * run.scene.run.accuracy)
    first_drive = float(drive(times[:1])[0])

    def state_derivative(time: float, state: FloatArray) -> list[float]:
        """Return the rates of angle, rate and speed."""
        motion = dict(zip(names, state.tolist(), strict=True))
        driven = first_drive if drive.is_constant else float(drive(np.array([time]), left_limit=time > start)[0])
        if isinstance(spindle, FreeSpindle):
            acceleration = float(spindle_acceleration(**motion, constant_inertia=spindle.inertia, torque=driven))
        else:
            motion["spindle_speed"], acceleration = driven, 0.0
        return [motion[names[1]], float(angular_acceleration(**motion)), acceleration]

    breaks = drive.breakpoints[(drive.breakpoints > times[0]) & (drive.breakpoints < times[-1])]
    state = np.array([run.readings[angle][0], run.rates[angle][0], run.readings["spindle_speed"][0]])
    segments = [state[:, np.newaxis]]
    for start, end in pairwise(np.concatenate([times[:1], breaks, times[-1:]]).tolist()):
        segment_times = times[(times > start) & (times <= end)]
        evaluation_times = segment_times if segment_times.size and segment_times[-1] == end else np.append(segment_times, end)
        solution = solve_ivp(state_derivative, (start, end), state, method="DOP853", t_eval=evaluation_times, rtol=rtol, atol=0.1 * rtol)
        segments.append(solution.y[:, : len(segment_times)])
        state = solution.y[:, -1]
    return np.concatenate(segments, axis=1)


def format_rpm(speed: float) -> str:
    """Return a speed (rad/s) as text in rpm."""
    return f"{speed / RPM:.6g} rpm"


RELAXATION_OFFSET = 0.05
"""Largest start offset of the relaxation (rad), to each side of an equilibrium; smaller where another equilibrium is near."""
N_SEARCH_POINTS = 400
"""Number of points of the travel between which equilibria are sought."""


def check_equilibria(
    scene: Scene,
    reading: str,
    excess: Callable[..., float],  # what vanishes at an equilibrium, of an angle (rad) and the speed (rad/s)
    squared_frequency: Callable[[float, float], float],  # of small oscillations, 1/s2, of the same
    stroke: tuple[float, float] | None = None,  # angles within which equilibria are checked, rad; the travel if None
    *,
    relaxes: bool = True,
) -> Checks:
    """Yield relaxation and small oscillations at the equilibria of the spindle's first and last speed."""
    if isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: equilibria at a given speed are not checked"
        return
    low, high = stroke or travel_limits(scene, reading)
    for speed in dict.fromkeys((scene.spindle.speeds[0], scene.spindle.speeds[-1])):
        angles = _find_zeros(scene, reading, partial(excess, speed=speed))
        checked = [angle for angle in angles if low <= angle <= high]
        if not checked:
            yield f"at {format_rpm(speed)} there is no equilibrium within the {'stroke' if stroke else 'travel'}: nothing is checked there"
        held_scene = scene.with_changes(spindle=Spindle(speeds=(speed,)))
        for angle in checked:
            offset = min([RELAXATION_OFFSET, *(0.3 * abs(angle - other) for other in angles if other != angle)])
            starts = (angle - offset, angle + offset) if relaxes else ()
            label = f"{math.degrees(angle):.4g} deg, {format_rpm(speed)}"
            yield from check_stability(held_scene, reading, angle, squared_frequency(angle, speed), starts, label)


def _find_zeros(scene: Scene, reading: str, excess: Callable[[float], float]) -> list[float]:
    """Return the angles (rad) in the travel of a reading at which a function of it changes its sign."""
    low, high = travel_limits(scene, reading)
    margin = 1e-3 * (high - low)
    grid = np.linspace(low + margin, high - margin, N_SEARCH_POINTS).tolist()
    return [
        float(brentq(excess, start, end, xtol=1e-15, rtol=1e-14))
        for (start, end), (before, after) in zip(pairwise(grid), pairwise(map(excess, grid)), strict=True)
        if before * after < 0
    ]


def check_stability(scene: Scene, reading: str, angle: float, squared_frequency: float, starts: Iterable[float], label: str) -> Checks:
    """Yield relaxation from each start and small-oscillation period of an equilibrium (rad); a note if it is unstable."""
    if squared_frequency <= 0:
        yield f"the equilibrium at {label} is unstable: relaxation and oscillation are not checked"
        return
    for start in starts:
        yield check_relaxation(scene, f"relaxation from {math.degrees(start):.4g} deg to {label}", start=start, expected=angle)
    yield check_oscillation_period(scene, reading, angle=angle, period=2 * math.pi / math.sqrt(squared_frequency), label=label)


def check_relaxation(scene: Scene, quantity: str, *, start: float, expected: float) -> ComparisonRow:
    """Return the comparison of the position (rad) to which the scene relaxes; NaN, which fails the row, if it does not."""
    try:
        rest_position = relax_to_equilibrium(scene, start)
    except RunFailed:
        rest_position = math.nan
    reason = "at equilibrium the time integration has no error; the joint solver leaves about 1e-11"
    return ComparisonRow(quantity, rest_position, expected, 1e-8, "rad", reason)


def check_oscillation_period(scene: Scene, reading: str, *, angle: float, period: float, label: str) -> ComparisonRow:
    """Return the comparison of the period (s) of a reading about an equilibrium (rad), extrapolated to amplitude zero."""
    small_amplitude_period, double_amplitude_period = (
        (_simulate_period(scene, reading, angle, amplitude, period) + _simulate_period(scene, reading, angle, -amplitude, period)) / 2
        for amplitude in (SMALL_AMPLITUDE, 2 * SMALL_AMPLITUDE)
    )
    simulated_period = (4 * small_amplitude_period - double_amplitude_period) / 3
    reason = "two amplitudes to both sides, extrapolated to zero; the accuracy of the runs remains"
    return ComparisonRow(f"small-oscillation period at {label}", simulated_period, period, 1e-7 * period, "s", reason)


def _simulate_period(scene: Scene, reading: str, angle: float, amplitude: float, period: float) -> float:
    """Return the period (s) of an oscillation of the given amplitude (rad)."""
    oscillating_scene = scene.with_changes(
        start=Start(values={reading: angle + amplitude}), run=RunSettings(duration=2.2 * period, output_interval=period / 50, accuracy=1e-9)
    )
    return measure_period(run_scene(oscillating_scene), reading, angle)


def measure_period(run: Trajectory, reading: str, level: float) -> float:
    """Return the time (s) per cycle between the first and the last upward crossing of `level` by a reading."""
    curve = CubicHermiteSpline(run.times, run.readings[reading] - level, run.rates[reading])
    crossings = np.asarray(curve.roots(extrapolate=False))
    upward_crossings = crossings[curve(crossings, 1) > 0]
    if len(upward_crossings) < 2:
        raise MechanismError(f"{reading} completes no cycle about {level:.6g} in {run.times[-1]:.6g} s: there is no period")
    return float((upward_crossings[-1] - upward_crossings[0]) / (len(upward_crossings) - 1))
