"""The slider crank against its closed forms: positions, velocities, accelerations and bearing loads."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.engines import select_engine
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics, solve_kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.report import ComparisonRow

CHECKED_CRANK_ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))
"""Crank angles at which the kinematics is checked (rad)."""

KINEMATICS_REASON = "no integration; rounding and position assembly leave about 1e-14"
"""Reason for the tolerance of the kinematics."""

BEARING_LOAD_RELATIVE_TOLERANCE = 1e-9
"""Tolerance relative to the largest load: rounding of a system whose masses differ by a factor of a thousand."""


def check_slider_crank(scene: Scene) -> Iterator[ComparisonRow | str]:
    """Yield every comparison that applies to the scene."""
    train, speed = build_crank_train(scene), scene.part.dimensions["crank_speed"]
    kinematics = solve_kinematics(scene, "crank_angle", CHECKED_CRANK_ANGLES, speed)
    angle_arguments, rate_arguments = ({"crank_angle": CHECKED_CRANK_ANGLES}, {"crank_angle": CHECKED_CRANK_ANGLES, "crank_rate": speed})
    length_scale = train.crank
    yield from compare_kinematics(
        kinematics,
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
        speed,
        {"crosshead_distance": length_scale, "rod_angle": 1.0},
    )
    run = run_scene_at(scene)
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


def run_scene_at(scene: Scene, times: FloatArray | None = None) -> Trajectory:
    """Return a run by the scene's own engine, at the scene's own times or at the given ones (s)."""
    engine, reason = select_engine(scene.run.engine, scene)
    return engine.run(scene, times=times, reason=reason)


def note_early_end(run: Trajectory) -> Iterator[str]:
    """Yield a note on a run that ended early or missed its accuracy."""
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1] if len(run.times) else 0.0:.4g} s: {run.message}"


def compare_kinematics(
    kinematics: Kinematics,
    labels: Mapping[str, str],
    expected: Mapping[str, tuple[object, object, object]],
    speed: float,
    scales: Mapping[str, float],
) -> Iterator[ComparisonRow]:
    """Yield value, velocity and acceleration of each reading where it deviates most; the tolerance is 1e-10 of its scale."""
    derivatives = (
        ("", kinematics.readings, 1.0),
        (" speed", kinematics.rates, speed),
        (" acceleration", kinematics.reading_accelerations, speed**2),
    )
    for name, expected_values in expected.items():
        unit = "rad" if name.endswith("angle") else "m"
        for (suffix, simulated, scale), value, unit_suffix in zip(derivatives, expected_values, ("", "/s", "/s2"), strict=True):
            exact = np.asarray(value)
            worst_index = int(np.argmax(np.abs(simulated[name] - exact)))
            angle_label = f"{math.degrees(kinematics.values[worst_index]):.4g} deg"
            yield ComparisonRow(
                quantity=f"{labels[name]}{suffix or ' position'} (largest deviation, {angle_label})",
                simulated=float(simulated[name][worst_index]),
                expected=float(exact[worst_index]),
                allowed=1e-10 * scales[name] * scale,
                unit=unit + unit_suffix,
                reason=KINEMATICS_REASON,
            )


def compare_reading(run: Trajectory, name: str, expected: FloatArray) -> ComparisonRow:
    """Return the comparison of a reading of the run where it deviates most."""
    worst_index = int(np.argmax(np.abs(run.readings[name] - expected)))
    return ComparisonRow(
        quantity=f"{name.replace('_', ' ')} in motion (largest deviation, t = {run.times[worst_index]:.4g} s)",
        simulated=float(run.readings[name][worst_index]),
        expected=float(expected[worst_index]),
        allowed=run.scene.run.accuracy * run.scales[name],
        unit=run.units[name],
        reason="the requested accuracy",
    )


def _check_bearing_loads(
    scene: Scene, run: Trajectory, train: closed.CrankTrain, angles: FloatArray, speed: float
) -> Iterator[ComparisonRow | str]:
    """Yield the comparison of every bearing of the scene where its load deviates most."""
    exact = closed.bearing_loads(train, crank_angle=angles, crank_rate=speed, gravity=scene.gravity)
    largest = max(float(np.max(np.hypot(force[:, 0], force[:, 1]))) for force in (exact.main, exact.crank_pin))
    forces = {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}
    for name, force in forces.items():
        if name not in run.reactions:
            yield f"{name!r} does not join two parts with mass: it is not checked"
            continue
        for axis, letter in enumerate("xy"):
            yield _compare_load(run, f"{name}, {letter}", run.reactions[name].force[:, axis], force[:, axis], largest, "N")
    guide = run.reactions["crosshead guide"].force[:, 1]
    yield _compare_load(run, "crosshead guide", guide, exact.guide, largest, "N")
    yield _compare_load(run, "drive torque", run.reactions["drive"].moment, exact.torque, largest * train.crank, "N m")


def _compare_load(run: Trajectory, name: str, simulated: FloatArray, expected: FloatArray, largest: float, unit: str) -> ComparisonRow:
    """Return the comparison of one load where it deviates most."""
    worst_index = int(np.argmax(np.abs(simulated - expected)))
    return ComparisonRow(
        quantity=f"{name} (largest deviation, t = {run.times[worst_index]:.4g} s)",
        simulated=float(simulated[worst_index]),
        expected=float(expected[worst_index]),
        allowed=max(BEARING_LOAD_RELATIVE_TOLERANCE, run.scene.run.accuracy) * largest,
        unit=unit,
        reason="relative to the largest load: 1e-9, or the requested accuracy where that is coarser",
    )
