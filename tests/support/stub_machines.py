"""Runs of many kinds of mechanisms, made by hand from geometry."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    ArcSlot,
    CurveSlot,
    Gear,
    Joint,
    Prismatic,
    RackAndPinion,
    RotationalDriver,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate, Reading
from governor_mechanism.model.results.records import Energy, Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.types import FloatArray
from scene_parts import (
    body_point,
    constant,
    damper,
    ground_point,
    link,
    make_mechanism,
    pin,
    point_mass,
    rotating_body,
    scene_of,
    slider,
    spring,
)
from stub_run import FAKE_COST

MOTOR = PrescribedMotion.constant_rate(0.0, 3.0)

MachineDescription = tuple[list[Body], list[Joint], list[ForceElement], Mapping[str, FloatArray]]


def plate(name: str, mass: float) -> Body:
    """A body with a moment of inertia."""
    return rotating_body(name, mass, 0.004)


def fake_machine_run(name: str, duration: float = 2.0, count: int = 201, *, readings: int = 1, title: str | None = None) -> Trajectory:
    """The run of one of MACHINES: one turn or swing of it, `count` reports in `duration` (s)."""
    times = np.linspace(0.0, duration, count)
    bodies, joints, loads, columns = MACHINES[name](2 * np.pi * times / duration)
    poses = np.stack([np.stack(np.broadcast_arrays(*columns[body.name]), axis=-1) for body in bodies], axis=1)
    velocities = np.gradient(poses, times, axis=0, edge_order=2)
    angles = [BodyAngle(name=f"turn_of_{body.name}", quantity="angle", body=body.name) for body in bodies]
    wanted: list[Reading] = [*angles, *TRACED_READINGS.get(name, ())]
    mechanism = make_mechanism(bodies, joints, wanted, list(map(tuple, poses[0].tolist())), loads=loads, size=0.3)
    values = {f"reading_{k}_of_the_machine": (k + 1) * np.sin(5 * times / duration + k) for k in range(readings)}
    made = scene_of(mechanism, Gravity(), duration=duration, output_interval=duration / (count - 1))
    scene = replace(made, title=name.capitalize() if title is None else title)
    zero = np.zeros(count)
    return Trajectory(
        scene=scene,
        times=times,
        poses=poses,
        velocities=velocities,
        readings=values,
        rates={},
        units=dict.fromkeys(values, "rad"),
        scales=dict.fromkeys(values, 1.0),
        joint_gap=zero,
        energy=Energy(kinetic=zero, potential=zero, rotation=zero, jacobi=zero, dissipated_energy=zero, scale=1.0),
        outcome=Outcome.DONE,
        cost=FAKE_COST,
        error_estimate=1e-7,
    )


def slider_crank(phase: FloatArray) -> MachineDescription:
    crank, rod, lag = 0.1, 0.3, 0.4
    angle = phase + lag
    knee = crank * np.cos(angle), crank * np.sin(angle)
    lean = -np.arcsin(knee[1] / rod)
    piston = knee[0] + rod * np.cos(lean)
    bodies = [plate("crank", 1.0), plate("rod", 1.0), point_mass("piston", 2.0)]
    joints: list[Joint] = [
        pin("main", ground_point(), body_point("crank", -crank / 2)),
        pin("crank knee", body_point("crank", crank / 2), body_point("rod", -rod / 2)),
        pin("wrist knee", body_point("rod", rod / 2), body_point("piston")),
        slider("guide", ground_point(), body_point("piston")),
    ]
    loads: list[ForceElement] = [
        Torque(name="drive", second="crank", moment=InputFunction(times=(0.0, 1.0, 2.0), values=(0.0, 5.0, -2.0))),
        spring("return", body_point("piston"), ground_point(0.62, 0.0), 100.0, 0.2),
        Force(name="gas", point=body_point("piston"), x=InputFunction(times=(0.0, 1.0), values=(-10.0, 0.0)), y=InputFunction()),
    ]
    return (
        bodies,
        joints,
        loads,
        {"crank": (knee[0] / 2, knee[1] / 2, angle), "rod": ((knee[0] + piston) / 2, knee[1] / 2, lean), "piston": (piston, 0.0, 0.0)},
    )


def four_bar(phase: FloatArray) -> MachineDescription:
    crank, coupler, rocker, base = 0.1, 0.26, 0.2, 0.28
    x, y = crank * np.cos(phase), crank * np.sin(phase)
    far = np.hypot(base - x, y)
    lean = np.arctan2(-y, base - x)
    rise = np.arccos((coupler**2 + far**2 - rocker**2) / (2 * coupler * far))
    turn = lean + rise
    top = x + coupler * np.cos(turn), y + coupler * np.sin(turn)
    back = np.arctan2(top[1], top[0] - base)
    bodies = [plate(name, 1.0) for name in ("crank", "coupler", "rocker")]
    centre = (0.12, 0.03)
    joints: list[Joint] = [
        pin("a", ground_point(), body_point("crank", -crank / 2)),
        RotationalDriver(name="motor", first=ground_point(), second=body_point("crank"), motion=PrescribedMotion.constant_rate(0.0, 3.0)),
        pin("b", body_point("crank", crank / 2), body_point("coupler", -centre[0], -centre[1])),
        pin("c", body_point("coupler", coupler - centre[0], -centre[1]), body_point("rocker", rocker / 2)),
        pin("d", ground_point(base), body_point("rocker", -rocker / 2)),
    ]
    loads: list[ForceElement] = [
        TorsionSpring(name="spiral", second="rocker", stiffness=1.0),
        TorsionDamper(name="drum", first="coupler", second="rocker", damping=1.0),
    ]
    c, s = np.cos(turn), np.sin(turn)
    middle = x + c * centre[0] - s * centre[1], y + s * centre[0] + c * centre[1], turn
    places = {"crank": (x / 2, y / 2, phase), "coupler": middle, "rocker": ((base + top[0]) / 2, top[1] / 2, back)}
    return bodies, joints, loads, places


def two_gears(phase: FloatArray) -> MachineDescription:
    bodies = [plate(name, 1.0) for name in ("wheel", "pinion", "arm")]
    joints: list[Joint] = [
        pin("a", ground_point(), body_point("wheel")),
        pin("b", ground_point(0.24), body_point("pinion")),
        Gear(name="mesh", first=body_point("wheel"), second=body_point("pinion"), ratio=-2.0),
        Weld(name="weld", first=body_point("pinion"), second=body_point("arm", -0.1), relative_angle=0.3),
    ]
    turn = -2 * phase + 0.3
    loads: list[ForceElement] = [Torque(name="load", second="wheel", moment=constant(3.0))]
    arm = 0.24 + 0.1 * np.cos(turn), 0.1 * np.sin(turn), turn
    return bodies, joints, loads, {"wheel": (0.0, 0.0, phase), "pinion": (0.24, 0.0, -2 * phase), "arm": arm}


def inside_gear(phase: FloatArray) -> MachineDescription:
    bodies = [plate(name, 1.0) for name in ("ring", "pinion")]
    joints: list[Joint] = [
        pin("a", ground_point(), body_point("ring")),
        pin("b", ground_point(0.1, 0.1), body_point("pinion")),
        Gear(name="mesh", first=body_point("ring"), second=body_point("pinion"), ratio=3.0),
    ]
    return bodies, joints, [], {"ring": (0.0, 0.0, phase), "pinion": (0.1, 0.1, 3 * phase)}


def rack(phase: FloatArray) -> MachineDescription:
    radius = 0.1
    angle = 1.2 * np.sin(phase)
    bodies = [plate("pinion", 1.0), point_mass("rack", 1.0)]
    joints: list[Joint] = [
        pin("a", ground_point(), body_point("pinion")),
        Prismatic(name="guide", first=ground_point(0.0, -radius), second=body_point("rack"), angle=0.0),
        RackAndPinion(name="mesh", first=body_point("pinion"), second=body_point("rack"), radius=radius),
    ]
    return bodies, joints, [], {"pinion": (0.0, 0.0, angle), "rack": (radius * angle, -radius, 0.0)}


def bead(phase: FloatArray) -> MachineDescription:
    x = 0.15 * np.sin(phase)
    bodies = [point_mass("bead", 0.2)]
    joints: list[Joint] = [
        CurveSlot(name="wire", first=ground_point(), second=body_point("bead"), curve=PolynomialCurve(coefficients=(0.0, 0.0, 4.0)))
    ]
    return bodies, joints, [], {"bead": (x, 4 * x**2, 0.0)}


def cam(phase: FloatArray) -> MachineDescription:
    curve = SplineCurve(x=(-0.2, -0.1, 0.0, 0.1, 0.2), y=(0.0, 0.05, 0.0, -0.05, 0.0))
    from scipy.interpolate import CubicSpline

    way = 0.15 * np.sin(phase)
    bodies, bed, foot = [point_mass("cam", 1.0), point_mass("follower", 1.0)], ground_point(0.0, -0.12), body_point("cam", 0.0, -0.12)
    joints: list[Joint] = [
        Prismatic(name="bed", first=bed, second=foot, angle=0.0),
        TranslationalDriver(name="push", first=bed, second=foot, angle=0.0, motion=PrescribedMotion.constant_rate(0.0, 1.0)),
        CurveSlot(name="groove", first=body_point("cam"), second=body_point("follower"), curve=curve),
        Prismatic(name="stem", first=ground_point(), second=body_point("follower", 0.0, 0.25), angle=np.pi / 2),
    ]
    height = CubicSpline(curve.x, curve.y)(-way)
    return bodies, joints, [], {"cam": (way, 0.0, 0.0), "follower": (0.0, height, 0.0)}


def arc(phase: FloatArray) -> MachineDescription:
    angle = -np.pi / 2 + 0.6 * np.sin(phase)
    x, y = 0.2 * np.cos(angle), 0.2 * np.sin(angle)
    lean = 0.5 * np.sin(phase + 1)
    bodies = [plate("pendulum", 1.0)]
    joints: list[Joint] = [ArcSlot(name="slot", first=ground_point(), second=body_point("pendulum", 0.0, 0.15), radius=0.2)]
    return bodies, joints, [], {"pendulum": (x + 0.15 * np.sin(lean), y - 0.15 * np.cos(lean), lean)}


def hung_mass(phase: FloatArray) -> MachineDescription:
    y = -0.35 + 0.08 * np.sin(phase)
    bodies = [point_mass("mass", 1.0), Body(name="below", mass=1.0)]
    joints: list[Joint] = [slider("guide", ground_point(), body_point("mass"), np.pi / 2)]
    loads: list[ForceElement] = [
        Spring(name="spring", first=ground_point(), second=body_point("mass"), stiffness=100.0),
        damper("damper", ground_point(), body_point("mass"), 1.0),
        Spring(name="lower", first=body_point("mass"), second=body_point("below"), stiffness=100.0),
    ]
    return bodies, joints, loads, {"mass": (0.0, y, 0.0), "below": (0.05 * np.sin(phase), y - 0.2, 0.0)}


def quick_return(phase: FloatArray) -> MachineDescription:
    x, y = 0.08 * np.cos(phase), 0.2 + 0.08 * np.sin(phase)
    lean = np.arctan2(y, x)
    bodies = [plate("crank", 1.0), plate("lever", 1.0), point_mass("bob", 2.0)]
    joints: list[Joint] = [
        pin("a", ground_point(0.0, 0.2), body_point("crank", -0.04)),
        pin("o", ground_point(), body_point("lever", -0.2)),
        slider("slot", body_point("lever", -0.2), body_point("crank", 0.04)),
        link("string", body_point("lever", 0.16), body_point("bob"), 0.2),
    ]
    loads: list[ForceElement] = [Force(name="wind", point=body_point("bob"), x=constant(2.0), y=constant(1.0))]
    lever, bob = (0.2 * np.cos(lean), 0.2 * np.sin(lean), lean), (0.36 * np.cos(lean) + 0.2, 0.36 * np.sin(lean), 0.0)
    return bodies, joints, loads, {"crank": (x / 2, 0.1 + y / 2, phase), "lever": lever, "bob": bob}


MACHINES: dict[str, Callable[[FloatArray], MachineDescription]] = {
    "slider-crank": slider_crank,
    "four-bar": four_bar,
    "two gears": two_gears,
    "inside gear": inside_gear,
    "rack": rack,
    "bead": bead,
    "cam": cam,
    "arc": arc,
    "hung mass": hung_mass,
    "quick return": quick_return,
}

TRACED_READINGS: dict[str, tuple[Reading, ...]] = {
    "four-bar": (PointCoordinate(name="x", quantity="length", point=body_point("coupler", -0.01, 0.1), direction_x=1.0, direction_y=0.0),)
}
