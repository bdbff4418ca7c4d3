"""Checks of governors whose closed forms follow from the paths of ball and sleeve: statics, equilibria, motion, energy."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.equilibrium_speed import evaluate_readings
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.types import FloatOrArray
from governor_mechanism.verification.machines import comparisons

ANGLE_READING, LIFT_READING = "arm_angle", "sleeve_lift"

N_POSITIONS = 5
"""Number of positions over the range of the run at which the statics are checked."""
MIN_RANGE = 0.1
"""Smallest range of the checked positions (rad), for a run that hardly moves."""
N_SEARCH_POINTS = 400
"""Number of points of the travel between which equilibria are sought."""
RELAXATION_OFFSET = 0.05
"""Largest start offset of the relaxation (rad), to each side of an equilibrium; smaller where another equilibrium is near."""


@dataclass(frozen=True, kw_only=True)
class GovernorFormulas:
    """Closed forms of a governor as functions of keywords: arm_angle (rad), arm_rate and spindle_speed (rad/s), in SI.

    `acceleration` takes damping (N s/m) too; `spindle_acceleration` constant_inertia (kg m2) and torque (N m).
    """

    ball_radius: Callable[..., FloatOrArray]
    equilibrium_speed: Callable[..., FloatOrArray]
    squared_frequency: Callable[..., FloatOrArray]
    acceleration: Callable[..., FloatOrArray]
    spindle_acceleration: Callable[..., FloatOrArray]


def check_sleeve_governor(scene: Scene, formulas: GovernorFormulas, *supported: type[OutputEffect]) -> comparisons.Checks:
    """Yield every comparison that applies; statics have no effects along readings but those of a `supported` class, as the formulas."""
    if not scene.has_centrifugal:
        raise MechanismError(f"the closed forms of machine {scene.part.machine!r} need the effect centrifugal")
    run = comparisons.run_scene(scene)
    kept = tuple(one for one in scene.effects if not isinstance(one, OutputEffect) or isinstance(one, supported))
    static_scene = scene.with_changes(effects=kept)
    if any(isinstance(one, OutputSpring) and (one.reading != LIFT_READING or one.one_sided) for one in kept):
        yield "the closed forms include springs on the sleeve that act both ways: only the energy is checked"
    else:
        yield from _check_statics(static_scene, formulas, run)
        yield from _check_equilibria(static_scene, formulas)
        yield from _check_motion(scene, formulas, run, supported)
    yield from comparisons.note_early_end(run)
    yield comparisons.compare_jacobi_integral(run)


def _check_statics(scene: Scene, formulas: GovernorFormulas, run: Trajectory) -> comparisons.Checks:
    """Yield the comparisons of ball radius and equilibrium speed over the range of the run."""
    angles, (low, high) = run.readings[ANGLE_READING], comparisons.travel_limits(scene, ANGLE_READING)
    half, middle = max(0.5 * np.ptp(angles), 0.5 * MIN_RANGE), 0.5 * (np.min(angles) + np.max(angles))
    margin = 1e-3 * (high - low)
    positions = np.linspace(max(middle - half, low + margin), min(middle + half, high - margin), N_POSITIONS)
    reduction = SingleDofReduction(scene)
    radii = evaluate_readings(reduction.mechanism, reduction.evaluate(positions))["ball_radius"]
    for angle, radius in zip(positions.tolist(), radii.tolist(), strict=True):
        label = f"at {math.degrees(angle):.4g} deg"
        yield comparisons.compare_algebraic(f"ball radius {label}", radius, formulas.ball_radius(arm_angle=angle), "m")
        speed, expected = equilibrium_speed_at(scene, np.array([angle]))[0], formulas.equilibrium_speed(arm_angle=angle)
        yield comparisons.compare_algebraic(f"equilibrium speed {label}", speed, expected, "rad/s")


def _check_equilibria(scene: Scene, formulas: GovernorFormulas) -> comparisons.Checks:
    """Yield the comparisons of the equilibria at the spindle's first and last speed."""
    if isinstance(scene.spindle, FreeSpindle):
        yield "the spindle is free: equilibria at a given speed are not checked"
        return
    if refusal := ImpulseEngine().refusal(scene):
        yield f"relaxation is not checked: {refusal}"
    for speed in dict.fromkeys((scene.spindle.speeds[0], scene.spindle.speeds[-1])):
        angles = _equilibrium_angles(scene, formulas, speed)
        if not angles:
            yield f"at {comparisons.format_rpm(speed)} there is no equilibrium within the travel: nothing is checked there"
        for angle in angles:
            offset = min([RELAXATION_OFFSET, *(0.3 * abs(angle - other) for other in angles if other != angle)])
            squared_frequency = float(formulas.squared_frequency(arm_angle=angle, spindle_speed=speed))
            label = f"{math.degrees(angle):.4g} deg, {comparisons.format_rpm(speed)}"
            held_scene = scene.with_changes(spindle=Spindle(speeds=(speed,)))
            starts = (angle - offset, angle + offset) if not refusal else ()
            yield from comparisons.check_stability(held_scene, ANGLE_READING, angle, squared_frequency, starts, label)


def _equilibrium_angles(scene: Scene, formulas: GovernorFormulas, speed: float) -> list[float]:
    """Return the arm angles (rad) at which the closed form has no acceleration at rest."""
    low, high = comparisons.travel_limits(scene, ANGLE_READING)
    margin = 1e-3 * (high - low)

    def acceleration(angle: float) -> float:
        return float(formulas.acceleration(arm_angle=angle, arm_rate=0.0, spindle_speed=speed))

    grid = np.linspace(low + margin, high - margin, N_SEARCH_POINTS).tolist()
    values = [acceleration(angle) for angle in grid]
    return [
        float(brentq(acceleration, start, end, xtol=1e-15, rtol=1e-14))
        for (start, end), (before, after) in zip(pairwise(grid), pairwise(values), strict=True)
        if before * after < 0
    ]


def _check_motion(
    scene: Scene, formulas: GovernorFormulas, run: Trajectory, supported: tuple[type[OutputEffect], ...]
) -> comparisons.Checks:
    """Yield the comparison of a run with the equation of motion; a note if an effect is not included."""
    if note := comparisons.note_unsupported_effects(scene, *supported):
        yield note
        return
    if len(run.times) < 2:
        return
    acceleration = partial(formulas.acceleration, damping=comparisons.sleeve_damping(scene))
    angles, _, speeds = comparisons.integrate_governor(run, len(run.times), ANGLE_READING, acceleration, formulas.spindle_acceleration)
    yield comparisons.compare_reading(run, ANGLE_READING, angles)
    if isinstance(scene.spindle, FreeSpindle):
        yield comparisons.compare_reading(run, "spindle_speed", speeds)
