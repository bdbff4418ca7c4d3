"""What the checks of all machines share: runs, comparisons of algebraic results and of motions, notes."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form.arguments import FloatOrArray
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, SpindleSpeedFunction
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.report import ComparisonRow

ALGEBRAIC_TOLERANCE = 1e-10
"""Relative tolerance of results without time integration; rounding and position assembly leave about 1e-12."""


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
    return sum(effect.linear for effect in scene.effects if isinstance(effect, Dashpot))


def note_unsupported_effects(scene: Scene, *supported: type[OutputEffect]) -> str:
    """Return a note on the effects along outputs that the closed forms of the motion do not include; empty if there are none.

    They include a linear dashpot on the sleeve and the `supported` classes.
    """
    unsupported = [
        effect
        for effect in scene.effects
        if isinstance(effect, OutputEffect) and not isinstance(effect, supported) and not _is_linear_sleeve_dashpot(effect)
    ]
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
    return ComparisonRow(
        quantity=quantity,
        simulated=float(simulated),
        expected=float(expected),
        allowed=ALGEBRAIC_TOLERANCE * abs(float(expected) if scale is None else scale),
        unit=unit,
        reason="both are algebraic; rounding and position assembly leave about 1e-12",
    )


def compare_largest_deviation(
    quantity: str, simulated: FloatArray, expected: FloatArray, places: Sequence[str], *, allowed: float, unit: str, reason: str
) -> ComparisonRow:
    """Return the comparison of two arrays (n,) at the place where they deviate most."""
    worst_index = int(np.argmax(np.abs(simulated - expected)))
    return ComparisonRow(
        quantity=f"{quantity} (largest deviation, {places[worst_index]})",
        simulated=float(simulated[worst_index]),
        expected=float(expected[worst_index]),
        allowed=allowed,
        unit=unit,
        reason=reason,
    )


def compare_in_motion(
    run: Trajectory, quantity: str, simulated: FloatArray, expected: FloatArray, *, allowed: float, unit: str, reason: str
) -> ComparisonRow:
    """Return the comparison of a quantity at the reported times where it deviates most."""
    return compare_largest_deviation(
        quantity, simulated, expected, [f"t = {time:.4g} s" for time in run.times], allowed=allowed, unit=unit, reason=reason
    )


def compare_reading(run: Trajectory, name: str, expected: FloatArray) -> ComparisonRow:
    """Return the comparison of a reading where it deviates most, over the reported times that `expected` (n,) covers."""
    return compare_in_motion(
        run,
        f"{name.replace('_', ' ')} in motion",
        run.readings[name][: len(expected)],
        expected,
        allowed=run.scene.run.accuracy * run.scales[name],
        unit=run.units[name],
        reason="the requested accuracy times the scale of the reading",
    )


def compare_jacobi_integral(run: Trajectory) -> ComparisonRow:
    """Return the comparison of the drift of the Jacobi integral with zero."""
    return ComparisonRow(
        quantity="Jacobi integral, largest change",
        simulated=run.energy.drift,
        expected=0.0,
        allowed=run.scene.run.accuracy,
        unit="1",
        reason="relative to mass x length scale^2 / time scale^2, like the accuracy",
    )


def integrate_governor(
    run: Trajectory,
    n_times: int,
    angle: str,
    angular_acceleration: Callable[..., FloatOrArray],
    spindle_acceleration: Callable[..., FloatOrArray],
) -> FloatArray:
    """Integrate a governor of one coordinate from the initial state of a run.

    angular_acceleration is a function of the angle (rad), its rate and spindle_speed (rad/s), named as in the closed forms;
    spindle_acceleration, of a free spindle, takes constant_inertia (kg m2) and torque (N m) too. Returns angle, rate and spindle speed at
    the first n_times reported times, shape (3, n_times).
    """
    spindle, times = run.scene.spindle, run.times[:n_times]
    names = (angle, angle.replace("angle", "rate"), "spindle_speed")
    drive = CubicTimeFunction(spindle.torque) if isinstance(spindle, FreeSpindle) else SpindleSpeedFunction(spindle)

    def state_derivative(time: float, state: FloatArray) -> list[float]:
        """Return the rates of angle, rate and speed."""
        motion = dict(zip(names, state.tolist(), strict=True))
        driven = float(drive(np.array([time]), left_limit=time > start)[0])
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
        solution = solve_ivp(state_derivative, (start, end), state, method="DOP853", t_eval=evaluation_times, rtol=1e-13, atol=1e-14)
        segments.append(solution.y[:, : len(segment_times)])
        state = solution.y[:, -1]
    return np.concatenate(segments, axis=1)
