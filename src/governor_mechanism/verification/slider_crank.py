"""The slider crank against its closed forms: positions, velocities, accelerations and bearing loads."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.comparisons import (
    ALGEBRAIC_TOLERANCE,
    compare_in_motion,
    compare_largest_deviation,
    compare_reading,
    note_early_end,
    run_scene,
)
from governor_mechanism.verification.report import ComparisonRow

CHECKED_CRANK_ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))
"""Crank angles at which the kinematics is checked (rad)."""

BEARING_LOAD_RELATIVE_TOLERANCE = 1e-9
"""Tolerance relative to the largest load: rounding of a system whose masses differ by a factor of a thousand."""


def check_slider_crank(scene: Scene) -> Iterator[ComparisonRow | str]:
    """Yield every comparison that applies to the scene."""
    train, speed = build_crank_train(scene), scene.part.dimensions["crank_speed"]
    angle_arguments, rate_arguments = ({"crank_angle": CHECKED_CRANK_ANGLES}, {"crank_angle": CHECKED_CRANK_ANGLES, "crank_rate": speed})
    yield from compare_kinematics(
        scene,
        {"crosshead_distance": "crosshead", "rod_angle": "rod"},
        {
            "crosshead_distance": (
                closed.crosshead_distance(train, **angle_arguments),
                closed.crosshead_velocity(train, **rate_arguments),
                closed.crosshead_acceleration(train, **rate_arguments),
            ),
            "rod_angle": (
                -np.asarray(closed.rod_angle(train, **angle_arguments)),
                -np.asarray(closed.rod_angular_velocity(train, **rate_arguments)),
                -np.asarray(closed.rod_angular_acceleration(train, **rate_arguments)),
            ),
        },
        {"crosshead_distance": train.crank, "rod_angle": 1.0},
    )
    run = run_scene(scene)
    yield from note_early_end(run)
    if len(run.times) < 2:
        return
    angles = crank_angles(scene, run)
    yield compare_reading(run, "crosshead_distance", np.asarray(closed.crosshead_distance(train, crank_angle=angles)))
    if not any(isinstance(effect, CrankMasses) for effect in scene.effects):
        yield "no part has mass: bearing loads are not checked; add effects.masses"
    elif scene.part.mechanism.force_elements or scene.output_effects:
        yield "other forces act on the parts: bearing loads are not checked"
    else:
        yield from _check_bearing_loads(scene, run, train, angles, speed)


def build_crank_train(scene: Scene) -> closed.CrankTrain:
    """Return the closed form's crank train with the masses of the scene.

    Parameters
    ----------
    scene
        A scene of a slider crank.

    Returns
    -------
    CrankTrain
        Crank, rod and masses; a rod without rod_centre and rod_inertia is uniform.
    """
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


def compare_kinematics(
    scene: Scene, labels: Mapping[str, str], expected: Mapping[str, tuple[object, object, object]], scales: Mapping[str, float]
) -> Iterator[ComparisonRow]:
    """Yield value, velocity and acceleration of each reading where it deviates most; the tolerance is 1e-10 of its scale."""
    speed = scene.part.dimensions["crank_speed"]
    kinematics = solve_kinematics(scene, "crank_angle", CHECKED_CRANK_ANGLES, speed)
    places = [f"{math.degrees(angle):.4g} deg" for angle in kinematics.values]
    derivatives = (
        (" position", "", kinematics.readings, 1.0),
        (" speed", "/s", kinematics.rates, speed),
        (" acceleration", "/s2", kinematics.reading_accelerations, speed**2),
    )
    for name, expected_values in expected.items():
        unit = "rad" if name.endswith("angle") else "m"
        for (suffix, unit_suffix, simulated, scale), exact in zip(derivatives, expected_values, strict=True):
            yield compare_largest_deviation(
                labels[name] + suffix,
                simulated[name],
                np.asarray(exact),
                places,
                allowed=ALGEBRAIC_TOLERANCE * scales[name] * scale,
                unit=unit + unit_suffix,
                reason="no integration; rounding and position assembly leave about 1e-14",
            )


def _check_bearing_loads(
    scene: Scene, run: Trajectory, train: closed.CrankTrain, angles: FloatArray, speed: float
) -> Iterator[ComparisonRow | str]:
    """Yield the comparison of every bearing of the scene where its load deviates most."""
    exact = closed.bearing_loads(train, crank_angle=angles, crank_rate=speed, gravity=scene.gravity)
    largest = max(float(np.max(np.hypot(force[:, 0], force[:, 1]))) for force in (exact.main, exact.crank_pin))
    forces = {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}
    allowed = max(BEARING_LOAD_RELATIVE_TOLERANCE, run.scene.run.accuracy) * largest
    reason = "relative to the largest load: 1e-9, or the requested accuracy where that is coarser"

    def compare(name: str, simulated: FloatArray, expected: FloatArray) -> ComparisonRow:
        return compare_in_motion(run, name, simulated, expected, allowed=allowed, unit="N", reason=reason)

    for name, force in forces.items():
        if name not in run.reactions:
            yield f"{name!r} does not join two parts with mass: it is not checked"
            continue
        for axis, letter in enumerate("xy"):
            yield compare(f"{name}, {letter}", run.reactions[name].force[:, axis], force[:, axis])
    yield compare("crosshead guide", run.reactions["crosshead guide"].force[:, 1], exact.guide)
    yield compare_in_motion(
        run, "drive torque", run.reactions["drive"].moment, exact.torque, allowed=allowed * train.crank, unit="N m", reason=reason
    )
