"""Machines drawn at random, as documents that a file could hold: of every kind there is."""

from __future__ import annotations

import cmath
import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.closed_form.pendulum import dynamics as closed
from governor_mechanism.scenes.library import shipped

Random = np.random.Generator
Document = dict[str, Any]

G = 9.81


def between(random: Random, low: float, high: float) -> float:
    """A number, every one as likely as another."""
    return float(random.uniform(low, high))


def of_any_size(random: Random, low: float, high: float) -> float:
    """A positive number, every order of magnitude as likely as another."""
    return float(low * (high / low) ** random.uniform())


def chance(random: Random, share: float) -> bool:
    """Whether it happens."""
    return bool(random.uniform() < share)


def one_of(random: Random, things: Any) -> Any:
    """One of some things."""
    return things[int(random.integers(len(things)))]


def restitution(random: Random) -> float:
    """Of stops: dead ones as well as lively ones."""
    return 0.0 if chance(random, 0.3) else between(random, 0.05, 0.8)


# --- governors --------------------------------------------------------------------------------------------------------


def pendulum(random: Random, more: Mapping[str, float]) -> Document:
    """A pendulum governor with these dimensions beside arm and ball, near its rest at the mean spindle speed."""
    dimensions = {"ball_mass": of_any_size(random, 0.5, 10.0), **more}
    middle = between(random, 0.45, 0.95)
    named = {name: value for name, value in dimensions.items() if value is not None}
    speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**named), arm_angle=middle))
    effects: Document = {"gravity": True, "centrifugal": True}
    if chance(random, 0.3):
        effects["rods"] = rods(random, dimensions)
    start: Document = {"arm_angle": middle + between(random, -0.12, 0.12), "arm_rate": between(random, -0.4, 0.4)}
    if "sleeve_mass" in dimensions and "link_mass" not in effects.get("rods", {}) and chance(random, 0.2):
        width = of_any_size(random, 2e-4, 5e-3)
        effects["play"] = {"width": width, "restitution": restitution(random)}
        start["sleeve_play"] = width * between(random, -0.5, 0.5)
    elif chance(random, 0.1):
        start = {"arm_angle": "equilibrium"}
    return turning("pendulum_governor", dimensions, effects, start, speed, random)


def rods(random: Random, dimensions: Mapping[str, float]) -> Document:
    """Arms, links and balls that have mass and size, some of them."""
    ball = dimensions["ball_mass"]
    found = {"arm_mass": ball * of_any_size(random, 0.02, 0.5)}
    if "sleeve_mass" in dimensions and chance(random, 0.5):
        found["link_mass"] = ball * of_any_size(random, 0.02, 0.3)
    if chance(random, 0.5):
        found["ball_radius"] = dimensions["arm"] * between(random, 0.05, 0.25)
    return found


def turning(
    machine: str, dimensions: Document, effects: Document, start: Document, speed: float, random: Random
) -> Document:
    """A governor's document, for a few swings, which take about as long as turns."""
    duration = math.tau / speed * between(random, 1.0, 4.0)
    return {
        "machine": machine,
        "dimensions": dimensions,
        "effects": effects,
        "spindle": spindle(random, speed, duration),
        "start": start,
        "run": settings(random, duration),
    }


def settings(random: Random, duration: float) -> Document:
    """[run], reported as seldom as ten times and as often as two hundred."""
    return {"duration": duration, "every": duration / int(random.integers(10, 200))}


def spindle(random: Random, speed: float, duration: float) -> Document:
    """Steady, on a ramp, with a step, on a smooth curve, uneven, or left to itself."""
    kind = one_of(random, ("steady", "steady", "ramp", "step", "smooth", "uneven", "free", "free with a step of load"))
    first, second, third = (speed * between(random, 0.95, 1.06) for _ in range(3))
    early, late = duration * between(random, 0.0, 0.45), duration * between(random, 0.5, 1.1)
    if kind == "ramp":
        return {"speed": [[early, first], [late, second]]}
    if kind == "step":
        return {"speed": [[0.0, speed], [early, speed], [early, first], [late, first]]}
    if kind == "smooth":
        return {"speed": [[0.0, speed], [early + 0.02 * duration, first], [late, second], [1.3 * duration, third]]}
    if kind == "uneven":
        swing = {"unevenness": of_any_size(random, 0.005, 0.2), "waves": float(one_of(random, (1, 2, 4)))}
        return {"speed": speed, **swing}
    if kind.startswith("free"):
        inertia = of_any_size(random, 0.05, 5.0)
        found: Document = {"inertia": inertia, "start_speed": speed}
        if "load" in kind:
            torque = inertia * speed / duration * between(random, -0.1, 0.1)
            found["torque"] = [[0.0, 0.0], [early, 0.0], [early, torque], [late, torque]]
        return found
    return {"speed": speed}


def watt(random: Random) -> Document:
    """Without a loaded sleeve; its arms on the axis, off it, or a little crossed."""
    arm = of_any_size(random, 0.15, 0.6)
    return pendulum(random, {"arm": arm, "offset": arm * between(random, -0.12, 0.3)})


def porter(random: Random) -> Document:
    """A loaded sleeve on links as long as the arms, or on others."""
    arm = of_any_size(random, 0.15, 0.6)
    more = {"arm": arm, "offset": arm * between(random, 0.0, 0.3), "sleeve_mass": of_any_size(random, 0.5, 60.0)}
    if chance(random, 0.4):
        more["link"] = arm * between(random, 0.9, 1.3)
    return pendulum(random, more)


def extended(random: Random) -> Document:
    """Balls on arms that go on beyond the joints of the links."""
    arm = of_any_size(random, 0.2, 0.6)
    joint = arm * between(random, 0.5, 0.95)
    more = {"arm": arm, "arm_joint": joint, "offset": arm * between(random, -0.05, 0.2)}
    if chance(random, 0.5):
        more["link"] = joint * between(random, 0.9, 1.3)
    return pendulum(random, more | {"sleeve_mass": of_any_size(random, 0.5, 40.0)})


def crossed(random: Random) -> Document:
    """Arms that cross the axis, and links with them."""
    arm = of_any_size(random, 0.2, 0.6)
    more = {"arm": arm, "offset": -arm * between(random, 0.02, 0.15), "sleeve_mass": of_any_size(random, 0.5, 20.0)}
    return pendulum(random, more)


def uncrossed_links(random: Random) -> Document:
    """Arms that cross the axis, links that do not."""
    arm = of_any_size(random, 0.25, 0.6)
    joint = arm * between(random, 0.55, 0.8)
    more = {
        "arm": arm,
        "arm_joint": joint,
        "link": joint * between(random, 0.75, 1.1),
        "offset": -arm * between(random, 0.03, 0.12),
        "lug_offset": arm * between(random, 0.03, 0.1),
    }
    return pendulum(random, more | {"sleeve_mass": of_any_size(random, 0.5, 20.0)})


def parabolic(random: Random) -> Document:
    """Near the one speed at which the balls rest anywhere."""
    inner, outer = 0.05, between(random, 0.2, 0.4)
    ball, sleeve, parameter = 1.0, of_any_size(random, 0.5, 10.0), between(random, 0.3, 0.9)
    dimensions = {
        "double_parameter": parameter,
        "inner_radius": inner,
        "outer_radius": outer,
        "ball_mass": ball,
        "sleeve_mass": sleeve,
    }
    start = {
        "ball_radius": inner + (outer - inner) * between(random, 0.2, 0.8),
        "ball_rate": between(random, -0.05, 0.05),
    }
    speed = math.sqrt(2 * G * (1 + sleeve / ball) / parameter) * between(random, 0.97, 1.03)
    return turning("parabolic_governor", dimensions, {"gravity": True, "centrifugal": True}, start, speed, random)


def hartung(random: Random) -> Document:
    """Bell cranks at any angle, springs between two speeds that hold the ends of the stroke, or by a rate."""
    arm, radius = between(random, 0.08, 0.15), between(random, 0.1, 0.16)
    slow = between(random, 15.0, 30.0)
    fast = slow * between(random, 1.02, 1.2)
    dimensions: Document = {
        "weight_arm": arm,
        "sleeve_arm": arm * between(random, 1.0, 1.6),
        "bell_crank_angle": math.radians(between(random, 90.0, 135.0)),
        "fulcrum_radius": radius,
        "weight_mass": of_any_size(random, 5.0, 60.0),
        "sleeve_mass": of_any_size(random, 2.0, 40.0),
        "inner_angle": 0.26,
        "outer_angle": -0.26,
        "inner_speed": slow,
        "outer_speed": fast,
    }
    if chance(random, 0.5):
        dimensions |= {"hanger": between(random, 0.25, 0.5), "lug_offset": between(random, 0.03, 0.08)}
    effects: Document = {"gravity": True, "centrifugal": True}
    if chance(random, 0.4):
        sizes = {"weight_width": 0.15, "weight_height": between(random, 0.1, 0.25)}
        effects["bell_cranks"] = {"mass": of_any_size(random, 1.0, 8.0)} | (sizes if chance(random, 0.5) else {})
    start = {"lever_angle": between(random, -0.12, 0.12), "lever_rate": between(random, -0.3, 0.3)}
    return turning("hartung", dimensions, effects, start, between(random, slow, fast), random)


# --- cranks -----------------------------------------------------------------------------------------------------------


def slide_valve(random: Random) -> Document:
    """Driven steadily, with rods of any length or endless ones."""
    eccentric, speed = between(random, 0.03, 0.08), of_any_size(random, 2.0, 20.0)
    dimensions: Document = {
        "crank": between(random, 0.15, 0.4),
        "eccentric": eccentric,
        "advance": between(random, 0.2, 0.8),
        "outside_lap": eccentric * between(random, 0.2, 0.5),
        "inside_lap": eccentric * between(random, 0.0, 0.1),
        "crank_speed": speed,
        "crank_start": between(random, -3.0, 3.0),
        "setting": one_of(random, ("equal leads", "middle of extremes", "equal cut-offs")),
    }
    if chance(random, 0.7):
        dimensions["connecting_rod"] = dimensions["crank"] * between(random, 2.5, 6.0)
    if chance(random, 0.7):
        dimensions["eccentric_rod"] = eccentric * of_any_size(random, 4.0, 30.0)
    return driven("slide_valve", dimensions, {}, speed, random)


def slider_crank(random: Random) -> Document:
    """Driven steadily, with masses or without."""
    crank, speed = between(random, 0.1, 0.4), of_any_size(random, 2.0, 20.0)
    dimensions = {
        "crank": crank,
        "connecting_rod": crank * between(random, 2.0, 6.0),
        "crank_speed": speed,
        "crank_start": between(random, -3.0, 3.0),
    }
    effects: Document = {"gravity": True} if chance(random, 0.5) else {}
    if chance(random, 0.6):
        effects["masses"] = {
            "crank": of_any_size(random, 5.0, 100.0),
            "crank_centre": between(random, -0.1, 0.1),
            "rod": of_any_size(random, 5.0, 100.0),
            "crosshead": of_any_size(random, 5.0, 100.0),
        }
    return driven("slider_crank", dimensions, effects, speed, random)


def driven(machine: str, dimensions: Document, effects: Document, speed: float, random: Random) -> Document:
    """The document of a machine whose crank is driven for a turn or two."""
    run = settings(random, math.tau / speed * between(random, 0.5, 2.0))
    return {"machine": machine, "dimensions": dimensions, "effects": effects, "run": run}


# --- mechanisms of a user's own ---------------------------------------------------------------------------------------


def pin(first: str, second: str) -> Document:
    """A joint of a document."""
    return {"type": "pin", "first": first, "second": second}


def bar(random: Random, name: str, length: float, start: complex, end: complex) -> Document:
    """A rod of any weight between two places."""
    return {
        "name": name,
        "mass": of_any_size(random, 0.3, 5.0),
        "rod": {"length": length},
        "at": [start.real, start.imag],
        "angle": cmath.phase(end - start),
    }


def custom(random: Random, duration: float, **tables: Any) -> Document:
    """The document of a mechanism of a user's own, with weight as a rule."""
    effects = {"gravity": True} if chance(random, 0.8) else {}
    return {"machine": "custom", "effects": effects, "run": settings(random, duration), **tables}


def engine(random: Random) -> Document:
    """A free slider crank: a flywheel on its shaft, steam that pushes for a time, a brake."""
    crank, angle = between(random, 0.08, 0.3), between(random, -3.0, 3.0)
    rod = crank * between(random, 2.2, 5.0)
    knee = cmath.rect(crank, angle)
    foot = knee.real + math.sqrt(rod**2 - knee.imag**2)
    rate = between(random, 2.0, 12.0)
    duration = math.tau / rate * between(random, 0.5, 2.0)
    push = between(random, -20.0, 40.0)
    steam = [[0.0, push], [0.3 * duration, push], [0.3 * duration, 0.0], [0.6 * duration, 0.5 * push]]
    wheel = {"name": "crank", "mass": of_any_size(random, 2.0, 30.0), "disc": {"radius": between(random, 0.1, 0.5)}}
    return custom(
        random,
        duration,
        ground={"O": [0.0, 0.0]},
        body=[
            wheel | {"points": {"pin": [crank, 0.0]}, "at": [0.0, 0.0], "angle": angle},
            bar(random, "rod", rod, knee, complex(foot)),
            {"name": "piston", "mass": of_any_size(random, 0.5, 5.0), "turns": False, "at": [foot, 0.0]},
        ],
        joint=[
            pin("ground.O", "crank.origin"),
            pin("crank.pin", "rod.start"),
            pin("rod.end", "piston.centre"),
            {"type": "slider", "first": "ground.O", "second": "piston.centre", "angle": 0},
        ],
        force=[{"type": "force", "point": "piston.centre", "x": steam}] if chance(random, 0.6) else [],
        readings={"crank_angle": {"angle": "crank"}, "piston": {"x": "piston.centre"}},
        start={"crank_angle": angle, "crank_rate": rate},
    )


@dataclass(frozen=True)
class FourBar:
    """Where a four-bar linkage stands: the ends of crank and rocker, and how fast its crank turns."""

    knee: complex
    elbow: complex
    pivot: complex
    angle: float
    rate: float


def linkage(random: Random) -> FourBar:
    """Some four-bar linkage that can be put together."""
    while True:
        crank, ground = between(random, 0.08, 0.25), between(random, 0.25, 0.5)
        rod, rocker = (between(random, 0.2, 0.5) for _ in range(2))
        pivot = cmath.rect(ground, between(random, -3.0, 3.0))
        angle = between(random, -3.0, 3.0)
        knee = cmath.rect(crank, angle)
        far = abs(pivot - knee)
        cosine = (rod**2 + far**2 - rocker**2) / (2 * rod * far)
        # Not near a dead centre, where linkages may go either way: they are to be met on the way, not at the start.
        if abs(cosine) < 0.9:
            turn = math.acos(cosine) * one_of(random, (-1.0, 1.0))
            elbow = knee + cmath.rect(rod, cmath.phase(pivot - knee) + turn)
            return FourBar(knee, elbow, pivot, angle, one_of(random, (-1.0, 1.0)) * between(random, 1.0, 8.0))


def four_bar(random: Random) -> Document:
    """A crank, a coupler and a rocker with springs, dampers and torques; driven by a motor at times."""
    one = linkage(random)
    return chain(random, one, [], [], {})


def six_bar(random: Random) -> Document:
    """A four-bar linkage whose rocker moves a ram by a further rod."""
    one = linkage(random)
    length = between(random, 0.6, 0.9)
    foot = one.elbow.real + math.sqrt(length**2 - (0.6 * one.elbow.imag) ** 2)
    level = 0.4 * one.elbow.imag
    bodies = [
        bar(random, "second rod", length, one.elbow, complex(foot, level)),
        {"name": "ram", "mass": of_any_size(random, 0.5, 5.0), "turns": False, "at": [foot, level]},
    ]
    joints = [
        pin("rocker.end", "second rod.start"),
        pin("second rod.end", "ram.centre"),
        {"type": "slider", "first": ["ground", 0.0, level], "second": "ram.centre", "angle": 0},
    ]
    return chain(random, one, bodies, joints, {"ram": {"x": "ram.centre"}})


def chain(random: Random, one: FourBar, bodies: list[Document], joints: list[Document], more: Document) -> Document:
    """The document of a four-bar linkage and of what it moves."""
    parts = [
        bar(random, "crank", abs(one.knee), 0j, one.knee),
        bar(random, "coupler", abs(one.elbow - one.knee), one.knee, one.elbow),
        bar(random, "rocker", abs(one.elbow - one.pivot), one.pivot, one.elbow),
    ]
    pins = [
        pin("ground.A", "crank.start"),
        pin("crank.end", "coupler.start"),
        pin("coupler.end", "rocker.end"),
        pin("ground.D", "rocker.start"),
    ]
    start: Document = {"crank_angle": one.angle, "crank_rate": one.rate}
    duration = between(random, 0.4, 1.5)
    if chance(random, 0.25):
        drive = {"type": "driven_turn", "name": "motor", "first": "ground", "second": "crank", "angle": one.angle}
        if chance(random, 0.5):
            drive["rate"] = one.rate
        else:
            middle, last = (one.angle + one.rate * duration * between(random, 0.3, 1.0) * share for share in (0.5, 1.2))
            drive.pop("angle")
            drive["motion"] = [[0.0, one.angle], [0.5 * duration, middle], [1.2 * duration, last]]
        pins.append(drive)
        start = {}
    return custom(
        random,
        duration,
        ground={"A": [0.0, 0.0], "D": [one.pivot.real, one.pivot.imag], "S": [0.5, 0.6]},
        body=parts + bodies,
        joint=pins + joints,
        force=loads(random),
        readings={"crank_angle": {"angle": "crank"}, "rocker_angle": {"angle": "rocker"}, **more},
        start=start,
    )


def loads(random: Random) -> list[Document]:
    """What may pull at a four-bar linkage: none of these, or some."""
    every: list[Document] = [
        {
            "type": "spring",
            "first": "ground.S",
            "second": "rocker.end",
            "stiffness": of_any_size(random, 5.0, 300.0),
            "free_length": between(random, 0.1, 0.5),
        },
        {"type": "damper", "first": "ground.S", "second": "rocker.end", "damping": of_any_size(random, 0.1, 20.0)},
        {"type": "torque", "body": "crank", "moment": between(random, -2.0, 2.0)},
        {"type": "torsion_spring", "second": "rocker", "stiffness": of_any_size(random, 0.1, 10.0)},
        {"type": "torsion_damper", "second": "rocker", "damping": of_any_size(random, 0.001, 0.1)},
    ]
    return [load for load in every if chance(random, 0.3)]


def quick_return(random: Random) -> Document:
    """The shipped shaping machine with other dimensions."""
    found: Document = tomllib.loads(shipped()["quick_return"].read_text(encoding="utf-8"))
    crank, lever, ram = found["body"]
    crank["points"] = {"pin": [between(random, 0.04, 0.1), 0.0]}
    for body in (crank, lever, ram):
        body["mass"] = of_any_size(random, 1.0, 15.0)
    found["link"][0]["length"] = between(random, 0.14, 0.25)
    found["force"][0]["damping"] = of_any_size(random, 1.0, 500.0)
    rate = of_any_size(random, 2.0, 15.0)
    found["joint"][-1]["rate"] = rate
    return found | {"run": settings(random, math.tau / rate * between(random, 0.5, 2.0))}


def double_pendulum(random: Random) -> Document:
    """Two rods in a chain, which swing too little and too short to be chaotic."""
    lengths = [between(random, 0.2, 0.6) for _ in range(2)]
    angles = [-math.pi / 2 + between(random, -0.7, 0.7) for _ in range(2)]
    knee = cmath.rect(lengths[0], angles[0])
    return custom(
        random,
        between(random, 0.5, 2.0),
        ground={"O": [0.0, 0.0]},
        body=[
            bar(random, "upper", lengths[0], 0j, knee),
            bar(random, "lower", lengths[1], knee, knee + cmath.rect(lengths[1], angles[1])),
        ],
        joint=[pin("ground.O", "upper.start"), pin("upper.end", "lower.start")],
        readings={"upper": {"angle": "upper"}, "lower": {"angle": "lower"}},
        start={"upper": angles[0], "upper_rate": between(random, -1.0, 1.0), "lower": angles[1]},
    )


MACHINES: Mapping[str, Callable[[Random], Document]] = {
    "Watt": watt,
    "Porter": porter,
    "extended arms": extended,
    "crossed arms": crossed,
    "uncrossed links": uncrossed_links,
    "parabolic": parabolic,
    "Hartung": hartung,
    "slide valve": slide_valve,
    "slider crank": slider_crank,
    "free engine": engine,
    "four-bar": four_bar,
    "six-bar": six_bar,
    "quick return": quick_return,
    "double pendulum": double_pendulum,
}
