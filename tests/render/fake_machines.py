"""Runs of many kinds of mechanisms, made by hand from geometry."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.model.curves import Polynomial, Table
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    DrivenSlide,
    DrivenTurn,
    Gear,
    Joint,
    Pin,
    Point,
    Prismatic,
    Rack,
    Slider,
    Weld,
)
from governor_mechanism.model.mechanism import Body, BodyAngle, Coordinate, Mechanism, Reading, SecondMoments
from governor_mechanism.model.scene import FIXED, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.model.time_functions import Motion, Program
from governor_mechanism.model.trajectory import Energy, Outcome, Trajectory
from governor_mechanism.types import FloatArray
from render.fake_run import COST

Described = tuple[list[Body], list[Joint], list[Load], Mapping[str, FloatArray]]

PLATE = SecondMoments(xx=0.002, yy=0.002)


def at(body: str, x: float = 0.0, y: float = 0.0) -> Point:
    """A point on a body."""
    return Point(body=body, x=x, y=y)


def ground(x: float = 0.0, y: float = 0.0) -> Point:
    """A point on the ground."""
    return at(GROUND, x, y)


def run_of(
    name: str, duration: float = 2.0, count: int = 201, *, readings: int = 1, title: str | None = None
) -> Trajectory:
    """The run of one of MACHINES: one turn or swing of it, `count` reports in `duration` (s)."""
    times = np.linspace(0.0, duration, count)
    bodies, joints, loads, columns = MACHINES[name](2 * np.pi * times / duration)
    poses = np.stack([np.stack(np.broadcast_arrays(*columns[body.name]), axis=-1) for body in bodies], axis=1)
    velocities = np.gradient(poses, times, axis=0, edge_order=2)
    angles = [BodyAngle(name=f"turn_of_{body.name}", quantity="angle", body=body.name) for body in bodies]
    wanted: list[Reading] = [*angles, *TRACED.get(name, ())]
    mechanism = Mechanism(
        bodies=tuple(bodies),
        joints=tuple(joints),
        readings=tuple(wanted),
        coordinate=wanted[0].name,
        size=0.3,
        sketch=tuple(map(tuple, poses[0].tolist())),
        loads=tuple(loads),
    )
    values = {f"reading_{k}_of_the_machine": (k + 1) * np.sin(5 * times / duration + k) for k in range(readings)}
    part = Part(name="part", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED)
    scene = Scene(
        title=name.capitalize() if title is None else title,
        parts=(part,),
        effects=(Gravity(),),
        spindle=Spindle(),
        start=Start(),
        run=RunSettings(duration=duration, every=duration / (count - 1)),
    )
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
        energy=Energy(kinetic=zero, potential=zero, rotation=zero, jacobi=zero, dissipated=zero, scale=1.0),
        outcome=Outcome.DONE,
        cost=COST,
        error_estimate=1e-7,
    )


def slider_crank(phase: FloatArray) -> Described:
    crank, rod, lag = 0.1, 0.3, 0.4
    angle = phase + lag
    pin = crank * np.cos(angle), crank * np.sin(angle)
    lean = -np.arcsin(pin[1] / rod)
    piston = pin[0] + rod * np.cos(lean)
    bodies = [
        Body(name="crank", mass=1.0, moments=PLATE),
        Body(name="rod", mass=1.0, moments=PLATE),
        Body(name="piston", mass=2.0, turns=False),
    ]
    joints: list[Joint] = [
        Pin(name="main", first=ground(), second=at("crank", -crank / 2)),
        Pin(name="crank pin", first=at("crank", crank / 2), second=at("rod", -rod / 2)),
        Pin(name="wrist pin", first=at("rod", rod / 2), second=at("piston")),
        Slider(name="guide", first=ground(), second=at("piston"), angle=0.0),
    ]
    loads: list[Load] = [
        Torque(name="drive", second="crank", moment=Program(times=(0.0, 1.0, 2.0), values=(0.0, 5.0, -2.0))),
        Spring(name="return", first=at("piston"), second=ground(0.62, 0.0), stiffness=100.0, free_length=0.2),
        Force(name="gas", point=at("piston"), x=Program(times=(0.0, 1.0), values=(-10.0, 0.0)), y=Program()),
    ]
    return (
        bodies,
        joints,
        loads,
        {
            "crank": (pin[0] / 2, pin[1] / 2, angle),
            "rod": ((pin[0] + piston) / 2, pin[1] / 2, lean),
            "piston": (piston, 0.0, 0.0),
        },
    )


def four_bar(phase: FloatArray) -> Described:
    crank, coupler, rocker, base = 0.1, 0.26, 0.2, 0.28
    x, y = crank * np.cos(phase), crank * np.sin(phase)
    far = np.hypot(base - x, y)
    lean = np.arctan2(-y, base - x)
    rise = np.arccos((coupler**2 + far**2 - rocker**2) / (2 * coupler * far))
    turn = lean + rise
    top = x + coupler * np.cos(turn), y + coupler * np.sin(turn)
    back = np.arctan2(top[1], top[0] - base)
    bodies = [Body(name=name, mass=1.0, moments=PLATE) for name in ("crank", "coupler", "rocker")]
    centre = (0.12, 0.03)
    joints: list[Joint] = [
        Pin(name="a", first=ground(), second=at("crank", -crank / 2)),
        DrivenTurn(name="motor", first=ground(), second=at("crank"), motion=Motion.steady(0.0, 3.0)),
        Pin(name="b", first=at("crank", crank / 2), second=at("coupler", -centre[0], -centre[1])),
        Pin(name="c", first=at("coupler", coupler - centre[0], -centre[1]), second=at("rocker", rocker / 2)),
        Pin(name="d", first=ground(base), second=at("rocker", -rocker / 2)),
    ]
    loads: list[Load] = [
        TorsionSpring(name="spiral", second="rocker", stiffness=1.0),
        TorsionDamper(name="drum", first="coupler", second="rocker", damping=1.0),
    ]
    c, s = np.cos(turn), np.sin(turn)
    return (
        bodies,
        joints,
        loads,
        {
            "crank": (x / 2, y / 2, phase),
            "coupler": (x + c * centre[0] - s * centre[1], y + s * centre[0] + c * centre[1], turn),
            "rocker": ((base + top[0]) / 2, top[1] / 2, back),
        },
    )


def two_gears(phase: FloatArray) -> Described:
    bodies = [Body(name=name, mass=1.0, moments=PLATE) for name in ("wheel", "pinion", "arm")]
    joints: list[Joint] = [
        Pin(name="a", first=ground(), second=at("wheel")),
        Pin(name="b", first=ground(0.24), second=at("pinion")),
        Gear(name="mesh", first=at("wheel"), second=at("pinion"), ratio=-2.0),
        Weld(name="weld", first=at("pinion"), second=at("arm", -0.1), turn=0.3),
    ]
    turn = -2 * phase + 0.3
    loads: list[Load] = [Torque(name="load", second="wheel", moment=Program(values=(3.0,)))]
    return (
        bodies,
        joints,
        loads,
        {
            "wheel": (0.0, 0.0, phase),
            "pinion": (0.24, 0.0, -2 * phase),
            "arm": (0.24 + 0.1 * np.cos(turn), 0.1 * np.sin(turn), turn),
        },
    )


def inside_gear(phase: FloatArray) -> Described:
    bodies = [Body(name=name, mass=1.0, moments=PLATE) for name in ("ring", "pinion")]
    joints: list[Joint] = [
        Pin(name="a", first=ground(), second=at("ring")),
        Pin(name="b", first=ground(0.1, 0.1), second=at("pinion")),
        Gear(name="mesh", first=at("ring"), second=at("pinion"), ratio=3.0),
    ]
    return bodies, joints, [], {"ring": (0.0, 0.0, phase), "pinion": (0.1, 0.1, 3 * phase)}


def rack(phase: FloatArray) -> Described:
    radius = 0.1
    angle = 1.2 * np.sin(phase)
    bodies = [Body(name="pinion", mass=1.0, moments=PLATE), Body(name="rack", mass=1.0, turns=False)]
    joints: list[Joint] = [
        Pin(name="a", first=ground(), second=at("pinion")),
        Prismatic(name="guide", first=ground(0.0, -radius), second=at("rack"), angle=0.0),
        Rack(name="mesh", first=at("pinion"), second=at("rack"), radius=radius),
    ]
    return bodies, joints, [], {"pinion": (0.0, 0.0, angle), "rack": (radius * angle, -radius, 0.0)}


def bead(phase: FloatArray) -> Described:
    x = 0.15 * np.sin(phase)
    bodies = [Body(name="bead", mass=0.2, turns=False)]
    joints: list[Joint] = [
        CurveSlot(name="wire", first=ground(), second=at("bead"), curve=Polynomial(coefficients=(0.0, 0.0, 4.0)))
    ]
    return bodies, joints, [], {"bead": (x, 4 * x**2, 0.0)}


def cam(phase: FloatArray) -> Described:
    curve = Table(x=(-0.2, -0.1, 0.0, 0.1, 0.2), y=(0.0, 0.05, 0.0, -0.05, 0.0))
    from scipy.interpolate import CubicSpline

    way = 0.15 * np.sin(phase)
    bodies = [Body(name="cam", mass=1.0, turns=False), Body(name="follower", mass=1.0, turns=False)]
    joints: list[Joint] = [
        Prismatic(name="bed", first=ground(0.0, -0.12), second=at("cam", 0.0, -0.12), angle=0.0),
        DrivenSlide(
            name="push",
            first=ground(0.0, -0.12),
            second=at("cam", 0.0, -0.12),
            angle=0.0,
            motion=Motion.steady(0.0, 1.0),
        ),
        CurveSlot(name="groove", first=at("cam"), second=at("follower"), curve=curve),
        Prismatic(name="stem", first=ground(), second=at("follower", 0.0, 0.25), angle=np.pi / 2),
    ]
    height = CubicSpline(curve.x, curve.y)(-way)
    return bodies, joints, [], {"cam": (way, 0.0, 0.0), "follower": (0.0, height, 0.0)}


def arc(phase: FloatArray) -> Described:
    angle = -np.pi / 2 + 0.6 * np.sin(phase)
    x, y = 0.2 * np.cos(angle), 0.2 * np.sin(angle)
    lean = 0.5 * np.sin(phase + 1)
    bodies = [Body(name="pendulum", mass=1.0, moments=PLATE)]
    joints: list[Joint] = [ArcSlot(name="slot", first=ground(), second=at("pendulum", 0.0, 0.15), radius=0.2)]
    return bodies, joints, [], {"pendulum": (x + 0.15 * np.sin(lean), y - 0.15 * np.cos(lean), lean)}


def hung(phase: FloatArray) -> Described:
    y = -0.35 + 0.08 * np.sin(phase)
    bodies = [Body(name="mass", mass=1.0, turns=False), Body(name="below", mass=1.0)]
    joints: list[Joint] = [Slider(name="guide", first=ground(), second=at("mass"), angle=np.pi / 2)]
    loads: list[Load] = [
        Spring(name="spring", first=ground(), second=at("mass"), stiffness=100.0),
        Damper(name="damper", first=ground(), second=at("mass"), damping=1.0),
        Spring(name="lower", first=at("mass"), second=at("below"), stiffness=100.0),
    ]
    return bodies, joints, loads, {"mass": (0.0, y, 0.0), "below": (0.05 * np.sin(phase), y - 0.2, 0.0)}


def quick_return(phase: FloatArray) -> Described:
    x, y = 0.08 * np.cos(phase), 0.2 + 0.08 * np.sin(phase)
    lean = np.arctan2(y, x)
    bodies = [
        Body(name="crank", mass=1.0, moments=PLATE),
        Body(name="lever", mass=1.0, moments=PLATE),
        Body(name="bob", mass=2.0, turns=False),
    ]
    joints: list[Joint] = [
        Pin(name="a", first=ground(0.0, 0.2), second=at("crank", -0.04)),
        Pin(name="o", first=ground(), second=at("lever", -0.2)),
        Slider(name="slot", first=at("lever", -0.2), second=at("crank", 0.04), angle=0.0),
        Distance(name="string", first=at("lever", 0.16), second=at("bob"), length=0.2),
    ]
    return (
        bodies,
        joints,
        [Force(name="wind", point=at("bob"), x=Program(values=(2.0,)), y=Program(values=(1.0,)))],
        {
            "crank": (x / 2, 0.1 + y / 2, phase),
            "lever": (0.2 * np.cos(lean), 0.2 * np.sin(lean), lean),
            "bob": (0.36 * np.cos(lean) + 0.2, 0.36 * np.sin(lean), 0.0),
        },
    )


MACHINES: dict[str, Callable[[FloatArray], Described]] = {
    "slider-crank": slider_crank,
    "four-bar": four_bar,
    "two gears": two_gears,
    "inside gear": inside_gear,
    "rack": rack,
    "bead": bead,
    "cam": cam,
    "arc": arc,
    "hung mass": hung,
    "quick return": quick_return,
}

TRACED: dict[str, tuple[Reading, ...]] = {
    "four-bar": (
        Coordinate(name="x", quantity="length", point=Point(body="coupler", x=-0.01, y=0.1), along_x=1.0, along_y=0.0),
    )
}
