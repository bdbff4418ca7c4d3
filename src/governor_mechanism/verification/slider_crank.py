"""The slider crank against its closed forms: positions, speeds and accelerations, and what the bearings carry."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.engines import choose
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics, follow
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.report import Row

TURN = np.radians(np.arange(0.0, 360.0, 10.0))

KINEMATICS = "nothing is integrated; rounding and the closing of the joints leave about 1e-14"

LOADS = 1e-9
"""Of the largest load: Newton's laws at poses closed to rounding, solved with masses that differ a thousandfold."""


def findings(scene: Scene) -> Iterator[Row | str]:
    """Every comparison that applies to the scene."""
    train, speed = train_of(scene), scene.part.dimensions["crank_speed"]
    moving = follow(scene, "crank_angle", TURN, speed)
    at, going = {"crank_angle": TURN}, {"crank_angle": TURN, "crank_rate": speed}
    size = train.crank
    yield from compared(
        moving,
        {"crosshead_distance": "crosshead", "rod_angle": "rod"},
        {
            "crosshead_distance": (
                closed.crosshead_distance(train, **at),
                closed.crosshead_velocity(train, **going),
                closed.crosshead_acceleration(train, **going),
            ),
            "rod_angle": (
                -np.asarray(closed.rod_slope(train, **at)),
                -np.asarray(closed.rod_slope_rate(train, **going)),
                -np.asarray(closed.rod_slope_acceleration(train, **going)),
            ),
        },
        speed,
        {"crosshead_distance": size, "rod_angle": 1.0},
    )
    run = running(scene)
    yield from ended(run)
    if len(run.times) < 2:
        return
    angles = crank_angles(scene, run)
    yield in_motion(run, "crosshead_distance", np.asarray(closed.crosshead_distance(train, crank_angle=angles)))
    if not any(isinstance(effect, Masses) for effect in scene.effects):
        yield "no part has mass: loads of the bearings are not checked; list effects.masses"
    elif scene.part.mechanism.loads or scene.acting:
        yield "something else acts on the parts: loads of the bearings are not checked"
    else:
        yield from _loads(scene, run, train, angles, speed)


def train_of(scene: Scene) -> closed.CrankTrain:
    """The closed form's crank, rod and masses."""
    sizes = scene.part.dimensions
    masses = next((effect for effect in scene.effects if isinstance(effect, Masses)), None)
    if masses is None:
        return closed.CrankTrain.of(sizes)
    rod = sizes["connecting_rod"]
    return closed.CrankTrain.of(
        sizes,
        crank_mass=masses.crank,
        crank_centre=masses.crank_centre,
        rod_mass=masses.rod,
        rod_centre=rod / 2 if masses.rod_centre is None else masses.rod_centre,
        rod_inertia=masses.rod * rod**2 / 12 if masses.rod_inertia is None else masses.rod_inertia,
        crosshead_mass=masses.crosshead,
    )


def crank_angles(scene: Scene, run: Trajectory) -> FloatArray:
    """Where the drive has the crank at the reported times (rad)."""
    sizes = scene.part.dimensions
    return sizes["crank_start"] + sizes["crank_speed"] * run.times


def running(scene: Scene, times: FloatArray | None = None) -> Trajectory:
    """A run of the scene's own engine, at the scene's own times or at others."""
    engine, reason = choose(scene.run.engine, scene)
    return engine.run(scene, times=times, reason=reason)


def ended(run: Trajectory) -> Iterator[str]:
    """A note on a run that ended early, or missed what was asked."""
    if not run.outcome.ok:
        yield f"the run reached {run.times[-1] if len(run.times) else 0.0:.4g} s: {run.message}"


def compared(
    moving: Kinematics,
    spoken: Mapping[str, str],
    expected: Mapping[str, tuple[object, object, object]],
    speed: float,
    scales: Mapping[str, float],
) -> Iterator[Row]:
    """Value, rate and acceleration of readings, each where it is farthest off; allowed are 1e-10 of their scales."""
    kinds = (
        ("", moving.readings, 1.0),
        (" speed", moving.rates, speed),
        (" acceleration", moving.accelerations_of, speed**2),
    )
    for name, wanted in expected.items():
        unit = "rad" if name.endswith("angle") else "m"
        for (kind, found, scale), value, per in zip(kinds, wanted, ("", "/s", "/s2"), strict=True):
            exact = np.asarray(value)
            worst = int(np.argmax(np.abs(found[name] - exact)))
            where = f"{math.degrees(moving.values[worst]):.4g} deg"
            yield Row(
                quantity=f"{spoken[name]}{kind or ' position'} (farthest, {where})",
                simulated=float(found[name][worst]),
                expected=float(exact[worst]),
                allowed=1e-10 * scales[name] * scale,
                unit=unit + per,
                reason=KINEMATICS,
            )


def in_motion(run: Trajectory, name: str, expected: FloatArray) -> Row:
    """A reading of the run where it is farthest off."""
    worst = int(np.argmax(np.abs(run.readings[name] - expected)))
    return Row(
        quantity=f"{name.replace('_', ' ')} in motion (farthest, t = {run.times[worst]:.4g} s)",
        simulated=float(run.readings[name][worst]),
        expected=float(expected[worst]),
        allowed=run.scene.run.accuracy * run.scales[name],
        unit=run.units[name],
        reason="the accuracy asked of the run",
    )


def _loads(
    scene: Scene, run: Trajectory, train: closed.CrankTrain, angles: FloatArray, speed: float
) -> Iterator[Row | str]:
    """Every bearing that the scene has, where it is farthest off."""
    exact = closed.bearing_loads(train, crank_angle=angles, crank_rate=speed, gravity=scene.gravity)
    largest = max(float(np.max(np.hypot(force[:, 0], force[:, 1]))) for force in (exact.main, exact.crank_pin))
    forces = {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}
    for name, force in forces.items():
        if name not in run.reactions:
            yield f"{name!r} joins nothing that has mass on both sides: it is not checked"
            continue
        for axis, letter in enumerate("xy"):
            yield _load(run, f"{name}, {letter}", run.reactions[name].force[:, axis], force[:, axis], largest, "N")
    guide = run.reactions["crosshead guide"].force[:, 1]
    yield _load(run, "crosshead guide", guide, exact.guide, largest, "N")
    yield _load(run, "torque of the drive", run.reactions["drive"].moment, exact.torque, largest * train.crank, "N m")


def _load(run: Trajectory, name: str, found: FloatArray, exact: FloatArray, largest: float, unit: str) -> Row:
    worst = int(np.argmax(np.abs(found - exact)))
    return Row(
        quantity=f"{name} (farthest, t = {run.times[worst]:.4g} s)",
        simulated=float(found[worst]),
        expected=float(exact[worst]),
        allowed=max(LOADS, run.scene.run.accuracy) * largest,
        unit=unit,
        reason="of the largest load: 1e-9, or the accuracy asked of the run where that is coarser",
    )
