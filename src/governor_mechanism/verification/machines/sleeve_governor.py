"""Checks of governors whose closed forms follow from the paths of ball and sleeve: statics, equilibria, motion, energy."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.part import FreeSpindle
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
    angles = run.readings[ANGLE_READING]
    low, high = comparisons.travel_limits(scene, ANGLE_READING)
    half = max(0.5 * np.ptp(angles), 0.5 * MIN_RANGE)
    middle = 0.5 * (np.min(angles) + np.max(angles))
    margin = 1e-3 * (high - low)
    positions = np.linspace(max(middle - half, low + margin), min(middle + half, high - margin), N_POSITIONS)
    reduction = SingleDofReduction(scene)
    radii = evaluate_readings(reduction.mechanism, reduction.evaluate(positions))["ball_radius"]
    for angle, radius in zip(positions.tolist(), radii.tolist(), strict=True):
        label = f"at {math.degrees(angle):.4g} deg"
        yield comparisons.compare_algebraic(f"ball radius {label}", radius, formulas.ball_radius(arm_angle=angle), "m")
        speed = equilibrium_speed_at(scene, np.array([angle]))[0]
        expected = formulas.equilibrium_speed(arm_angle=angle)
        yield comparisons.compare_algebraic(f"equilibrium speed {label}", speed, expected, "rad/s")


def _check_equilibria(scene: Scene, formulas: GovernorFormulas) -> comparisons.Checks:
    """Yield the comparisons of the equilibria, where the closed form has no acceleration at rest."""

    def acceleration(angle: float, speed: float) -> float:
        return float(formulas.acceleration(arm_angle=angle, arm_rate=0.0, spindle_speed=speed))

    def squared_frequency(angle: float, speed: float) -> float:
        return float(formulas.squared_frequency(arm_angle=angle, spindle_speed=speed))

    refusal = None if isinstance(scene.spindle, FreeSpindle) else ImpulseEngine().refusal(scene)
    if refusal:
        yield f"relaxation is not checked: {refusal}"
    yield from comparisons.check_equilibria(scene, ANGLE_READING, acceleration, squared_frequency, relaxes=not refusal)


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
