"""The slider crank against its closed forms: positions, velocities, accelerations and bearing loads."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.effects.masses import CrankMasses
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray, FloatOrArray
from governor_mechanism.verification.machines import comparisons

CHECKED_CRANK_ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))
"""Crank angles at which the kinematics is checked (rad)."""

BEARING_LOAD_RELATIVE_TOLERANCE = 1e-9
"""Tolerance relative to the largest load: rounding of a system whose masses differ by a factor of a thousand."""


def check_slider_crank(scene: Scene) -> comparisons.Checks:
    """Yield every comparison that applies to the scene."""
    train, speed = build_crank_train(scene), scene.part.dimensions["crank_speed"]
    angle = {"crank_angle": CHECKED_CRANK_ANGLES}
    motion = {"crank_angle": CHECKED_CRANK_ANGLES, "crank_rate": speed}
    velocity = closed.crosshead_velocity(train, **motion)
    acceleration = closed.crosshead_acceleration(train, **motion)
    crosshead = ("crosshead_distance", "crosshead", train.crank, (closed.crosshead_distance(train, **angle), velocity, acceleration))
    velocity = closed.rod_angular_velocity(train, **motion)
    acceleration = closed.rod_angular_acceleration(train, **motion)
    rod = ("rod_angle", "rod", 1.0, [-value for value in (closed.rod_angle(train, **angle), velocity, acceleration)])
    yield from compare_kinematics(scene, crosshead, rod)
    run = comparisons.run_scene(scene)
    yield from comparisons.note_early_end(run)
    if len(run.times) < 2:
        return
    angles = crank_angles(scene, run)
    yield comparisons.compare_reading(run, "crosshead_distance", closed.crosshead_distance(train, crank_angle=angles))
    if not any(isinstance(effect, CrankMasses) for effect in scene.effects):
        yield "no part has mass: bearing loads are not checked; add effects.masses"
    elif scene.part.mechanism.force_elements or scene.output_effects:
        yield "other forces act on the parts: bearing loads are not checked"
    else:
        yield from _check_bearing_loads(scene, run, train, angles, speed)


def build_crank_train(scene: Scene) -> closed.CrankTrain:
    """Return the closed form's crank train with the masses of the scene."""
    dimensions = scene.part.dimensions
    masses = next((effect for effect in scene.effects if isinstance(effect, CrankMasses)), None)
    if masses is None:
        return closed.CrankTrain.from_dimensions(dimensions)
    rod_length = dimensions["connecting_rod"]
    return closed.CrankTrain.from_dimensions(
        dimensions,
        crank_mass=masses.crank,
        crank_centre=masses.crank_centre,
        rod_mass=masses.rod,
        rod_centre=rod_length / 2 if masses.rod_centre is None else masses.rod_centre,
        rod_inertia=masses.rod * rod_length**2 / 12 if masses.rod_inertia is None else masses.rod_inertia,
        crosshead_mass=masses.crosshead,
    )


def crank_angles(scene: Scene, run: Trajectory) -> FloatArray:
    """Return the crank angle that the drive prescribes at the reported times (rad); shape (n,)."""
    dimensions = scene.part.dimensions
    return dimensions["crank_start"] + dimensions["crank_speed"] * run.times


def compare_kinematics(scene: Scene, *expected_motions: tuple[str, str, float, Sequence[FloatOrArray]]) -> comparisons.Checks:
    """Yield value, velocity and acceleration of readings where they deviate most; the tolerance is 1e-10 of their scales."""
    # An expected motion is a reading, its label and scale (SI), and its value and two time derivatives
    # at the checked angles.
    speed = scene.part.dimensions["crank_speed"]
    reason = "no integration; rounding and position assembly leave about 1e-14"
    kinematics = solve_kinematics(scene, "crank_angle", CHECKED_CRANK_ANGLES, speed)
    places = [f"{math.degrees(angle):.4g} deg" for angle in kinematics.values]
    derivatives = (
        ("position", "", kinematics.readings),
        ("speed", "/s", kinematics.rates),
        ("acceleration", "/s2", kinematics.reading_accelerations),
    )
    for reading, label, scale, expected in expected_motions:
        for order, ((name, per_time, simulated), exact) in enumerate(zip(derivatives, expected, strict=True)):
            allowed = comparisons.ALGEBRAIC_TOLERANCE * scale * speed**order
            unit = ("rad" if reading.endswith("angle") else "m") + per_time
            yield comparisons.compare_largest_deviation(f"{label} {name}", simulated[reading], exact, places, allowed, unit, reason)


def _check_bearing_loads(scene: Scene, run: Trajectory, train: closed.CrankTrain, angles: FloatArray, speed: float) -> comparisons.Checks:
    """Yield the comparison of every bearing of the scene where its load deviates most."""
    exact = closed.bearing_loads(train, crank_angle=angles, crank_rate=speed, gravity=scene.gravity)
    largest = max(float(np.max(np.hypot(force[:, 0], force[:, 1]))) for force in (exact.main, exact.crank_pin))
    allowed = max(BEARING_LOAD_RELATIVE_TOLERANCE, run.scene.run.accuracy) * largest
    reason = "relative to the largest load: 1e-9, or the requested accuracy where that is coarser"
    for name, force in {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}.items():
        if name not in run.reactions:
            yield f"{name!r} does not join two parts with mass: it is not checked"
            continue
        for axis, letter in enumerate("xy"):
            simulated = run.reactions[name].force[:, axis]
            yield comparisons.compare_in_motion(run, f"{name}, {letter}", simulated, force[:, axis], allowed, "N", reason)
    guide, drive = run.reactions["crosshead guide"], run.reactions["drive"]
    yield comparisons.compare_in_motion(run, "crosshead guide", guide.force[:, 1], exact.guide, allowed, "N", reason)
    yield comparisons.compare_in_motion(run, "drive torque", drive.moment, exact.torque, allowed * train.crank, "N m", reason)
