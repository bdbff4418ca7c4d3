"""Hartung's governor against Dubois' formulas: spring force, equilibrium speed, sleeve force, stability, motion, energy."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.effects.holding import Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import compute_static_force
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.types import FloatArray, FloatOrArray
from governor_mechanism.verification.machines import comparisons

LEVER_ANGLE_READING = "lever_angle"

STROKE_FRACTIONS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Checked positions as fractions of the stroke."""


def check_hartung_governor(scene: Scene) -> comparisons.Checks:
    """Yield every comparison that applies: over the stroke, at equilibria of the first and last speed, in motion to the first impact."""
    # Equilibria are checked without output effects.
    comparisons.require_gravity_and_centrifugal(scene)
    run = comparisons.run_scene(scene)
    if any(isinstance(effect, BellCrankMasses) for effect in scene.effects):
        yield "the closed forms assume point weights on massless bell cranks: only the energy is checked"
    else:
        governor = build_hartung_closed_form(scene)
        yield from _check_statics_over_stroke(comparisons.without_output_effects(scene), governor, _lever_stroke(scene))
        yield from _check_equilibria(comparisons.without_output_effects(scene), governor, _lever_stroke(scene))
        yield from _check_motion(scene, governor, run)
    yield from comparisons.note_early_end(run)
    yield comparisons.compare_jacobi_integral(run)


def build_hartung_closed_form(scene: Scene) -> closed.HartungGovernor:
    """Return the closed form's governor of a scene."""
    dimensions = scene.part.dimensions
    names = ("weight_arm", "sleeve_arm", "fulcrum_radius", "weight_mass", "sleeve_mass", "hanger")
    return closed.HartungGovernor(
        **{name: dimensions[name] for name in names},
        angle=dimensions["bell_crank_angle"],
        lug_radius=dimensions["lug_offset"],
        gravity=scene.gravity,
    )


def _lever_stroke(scene: Scene) -> tuple[float, float]:
    """Return the lever angles (rad) of the stops; without stops, the middle half of the travel."""
    low, high = comparisons.travel_limits(scene, LEVER_ANGLE_READING)
    outer, inner = 0.25 * high + 0.75 * low, 0.75 * high + 0.25 * low
    for stops in scene.effects:
        if isinstance(stops, Stops) and stops.reading == LEVER_ANGLE_READING:
            return stops.low if math.isfinite(stops.low) else outer, stops.high if math.isfinite(stops.high) else inner
    return outer, inner


def _check_statics_over_stroke(scene: Scene, governor: closed.HartungGovernor, stroke: tuple[float, float]) -> comparisons.Checks:
    """Yield the comparisons of equilibrium speed and static sleeve force over the stroke."""
    outer, inner = stroke
    lever_angles = np.array([inner + fraction * (outer - inner) for fraction in STROKE_FRACTIONS])
    sleeve_forces = compute_static_force(scene, "sleeve_lift", SingleDofReduction(scene).evaluate(lever_angles).poses)
    for lever_angle, sleeve_force in zip(lever_angles.tolist(), sleeve_forces.tolist(), strict=True):
        label = f"at {math.degrees(lever_angle):.4g} deg"
        state = {"lever_angle": lever_angle, "spring_force": _spring_force(scene, lever_angle)}
        speed = equilibrium_speed_at(scene, np.array([lever_angle]))[0]
        exact_speed = closed.equilibrium_speed(governor, **state)
        yield comparisons.compare_algebraic(f"equilibrium speed {label}", speed, exact_speed, "rad/s")
        exact_force = closed.static_sleeve_force(governor, **state)
        yield comparisons.compare_algebraic(f"static sleeve force {label}", sleeve_force, exact_force, "N")
    yield from _check_astatic_spring_force(scene, governor, lever_angles)


def _check_astatic_spring_force(scene: Scene, governor: closed.HartungGovernor, lever_angles: FloatArray) -> comparisons.Checks:
    """Yield the spring force that balances the weights at one speed, from the reduction of a governor without springs."""
    reduction = SingleDofReduction(scene.with_changes(mechanism=replace(scene.part.mechanism, force_elements=(), derived_readings=())))
    coefficients = reduction.evaluate(lever_angles)
    speed = SpindleSpeedFunction(scene.spindle).start_speed
    # Virtual work: both springs against weights and centrifugal load.
    forces = (0.5 * coefficients.spindle_inertia_derivative * speed**2 - coefficients.potential_derivative) / (
        2 * reduction.output_derivative(coefficients, "weight_radius")
    )
    for lever_angle, force in zip(lever_angles.tolist(), forces.tolist(), strict=True):
        expected = float(closed.astatic_spring_force(governor, lever_angle=lever_angle, spindle_speed=speed))
        quantity = f"spring force that balances {math.degrees(lever_angle):.4g} deg at {comparisons.format_rpm(speed)}"
        yield comparisons.compare_algebraic(quantity, force, expected, "N", scale=max(abs(expected), governor.weight_mass * scene.gravity))


def _check_equilibria(scene: Scene, governor: closed.HartungGovernor, stroke: tuple[float, float]) -> comparisons.Checks:
    """Yield the comparisons of the equilibria, where the spring force balances the speed."""
    rate = scene.part.dimensions["spring_rate"]

    def force_excess(angle: float, speed: float) -> float:
        return _spring_force(scene, angle) - float(closed.astatic_spring_force(governor, lever_angle=angle, spindle_speed=abs(speed)))

    def squared_frequency(angle: float, _: float) -> float:
        force = _spring_force(scene, angle)
        return float(closed.squared_natural_frequency(governor, lever_angle=angle, spring_force=force, spring_rate=rate))

    yield from comparisons.check_equilibria(scene, LEVER_ANGLE_READING, force_excess, squared_frequency, stroke)


def _spring_force(scene: Scene, lever_angle: float) -> float:
    """Return the force (N) of each spring at a lever angle (rad), from the scene's dimensions."""
    dimensions = scene.part.dimensions
    weight_radius = dimensions["fulcrum_radius"] - dimensions["weight_arm"] * math.sin(lever_angle)
    return dimensions["spring_preload"] + dimensions["spring_rate"] * (weight_radius - dimensions["preload_radius"])


def _check_motion(scene: Scene, governor: closed.HartungGovernor, run: Trajectory) -> comparisons.Checks:
    """Yield the comparison of a run with the equation of motion until the first impact; a note if an effect is not included."""
    if note := comparisons.note_unsupported_effects(scene, Stops):
        yield note
        return
    impact_time = next((event.time for event in run.events if event.kind is EventKind.IMPACT), None)
    if impact_time is not None:
        yield f"motion is checked until {impact_time:.4g} s, when the lever strikes its stop"
    n_compared = len(run.times) if impact_time is None else int(np.searchsorted(run.times, impact_time))
    if n_compared < 2:
        return
    damping = comparisons.sleeve_damping(scene)

    def lever_acceleration(**motion: float) -> FloatOrArray:
        spring_force = _spring_force(scene, motion[LEVER_ANGLE_READING])
        return closed.lever_acceleration(governor, **motion, spring_force=spring_force, damping=damping)

    spindle_acceleration = partial(closed.spindle_acceleration, governor)
    angles, _, speeds = comparisons.integrate_governor(run, n_compared, LEVER_ANGLE_READING, lever_acceleration, spindle_acceleration)
    yield comparisons.compare_reading(run, LEVER_ANGLE_READING, angles)
    if isinstance(scene.spindle, FreeSpindle):
        yield comparisons.compare_reading(run, "spindle_speed", speeds)
