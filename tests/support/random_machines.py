"""Machines drawn at random, as documents that a file could hold: of every kind there is."""

import cmath
import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.scenes.library import shipped_scenes

Random = np.random.Generator
Document = dict[str, Any]

G = 9.81


def draw_uniform(random: Random, low: float, high: float) -> float:
    """A number, every one as likely as another."""
    return float(random.uniform(low, high))


def draw_log_uniform(random: Random, low: float, high: float) -> float:
    """A positive number, every order of magnitude as likely as another."""
    return float(low * (high / low) ** random.uniform())


def draw_bool(random: Random, probability: float) -> bool:
    """Whether it happens."""
    return bool(random.uniform() < probability)


def draw_choice(random: Random, choices: Any) -> Any:
    """One of some things."""
    return choices[int(random.integers(len(choices)))]


def draw_restitution(random: Random) -> float:
    """Of stops: dead ones as well as lively ones."""
    return 0.0 if draw_bool(random, 0.3) else draw_uniform(random, 0.05, 0.8)


# --- governors --------------------------------------------------------------------------------------------------------


def draw_pendulum_governor(random: Random, more_dimensions: Mapping[str, float]) -> Document:
    """Return a pendulum governor with further dimensions, near its equilibrium at the mean spindle speed."""
    dimensions = {"ball_mass": draw_log_uniform(random, 0.5, 10.0), **more_dimensions}
    middle = draw_uniform(random, 0.45, 0.95)
    named = {name: value for name, value in dimensions.items() if value is not None}
    speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**named), arm_angle=middle))
    effects: Document = {"gravity": True, "centrifugal": True}
    if draw_bool(random, 0.3):
        effects["rods"] = draw_rods(random, dimensions)
    start: Document = {"arm_angle": middle + draw_uniform(random, -0.12, 0.12), "arm_rate": draw_uniform(random, -0.4, 0.4)}
    if "sleeve_mass" in dimensions and "link_mass" not in effects.get("rods", {}) and draw_bool(random, 0.2):
        width = draw_log_uniform(random, 2e-4, 5e-3)
        effects["clearance"] = {"width": width, "restitution": draw_restitution(random)}
        start["sleeve_clearance"] = width * draw_uniform(random, -0.5, 0.5)
    elif draw_bool(random, 0.1):
        start = {"arm_angle": "equilibrium"}
    return governor_document("pendulum_governor", dimensions, effects, start, speed, random)


def draw_rods(random: Random, dimensions: Mapping[str, float]) -> Document:
    """Arms, links and balls that have mass and size, some of them."""
    ball = dimensions["ball_mass"]
    found = {"arm_mass": ball * draw_log_uniform(random, 0.02, 0.5)}
    if "sleeve_mass" in dimensions and draw_bool(random, 0.5):
        found["link_mass"] = ball * draw_log_uniform(random, 0.02, 0.3)
    if draw_bool(random, 0.5):
        found["ball_radius"] = dimensions["arm"] * draw_uniform(random, 0.05, 0.25)
    return found


def governor_document(machine: str, dimensions: Document, effects: Document, start: Document, speed: float, random: Random) -> Document:
    """A governor's document, for a few swings, which take about as long as turns."""
    duration = math.tau / speed * draw_uniform(random, 1.0, 4.0)
    return {
        "machine": machine,
        "dimensions": dimensions,
        "effects": effects,
        "spindle": draw_spindle(random, speed, duration),
        "start": start,
        "run": draw_run_settings(random, duration),
    }


def draw_run_settings(random: Random, duration: float) -> Document:
    """[run], reported as seldom as ten times and as often as two hundred."""
    return {"duration": duration, "output_interval": duration / int(random.integers(10, 200))}


def draw_spindle(random: Random, speed: float, duration: float) -> Document:
    """Return a spindle: steady, on a ramp, with a step, on a smooth curve, with speed fluctuation, or free."""
    kind = draw_choice(random, ("steady", "steady", "ramp", "step", "smooth", "fluctuating", "free", "free with a step of load"))
    first, second, third = (speed * draw_uniform(random, 0.95, 1.06) for _ in range(3))
    early, late = duration * draw_uniform(random, 0.0, 0.45), duration * draw_uniform(random, 0.5, 1.1)
    if kind == "ramp":
        return {"speed": [[early, first], [late, second]]}
    if kind == "step":
        return {"speed": [[0.0, speed], [early, speed], [early, first], [late, first]]}
    if kind == "smooth":
        return {"speed": [[0.0, speed], [early + 0.02 * duration, first], [late, second], [1.3 * duration, third]]}
    if kind == "fluctuating":
        swing = {"speed_fluctuation": draw_log_uniform(random, 0.005, 0.2), "cycles_per_turn": float(draw_choice(random, (1, 2, 4)))}
        return {"speed": speed, **swing}
    if kind.startswith("free"):
        inertia = draw_log_uniform(random, 0.05, 5.0)
        found: Document = {"inertia": inertia, "start_speed": speed}
        if "load" in kind:
            torque = inertia * speed / duration * draw_uniform(random, -0.1, 0.1)
            found["torque"] = [[0.0, 0.0], [early, 0.0], [early, torque], [late, torque]]
        return found
    return {"speed": speed}


def draw_watt(random: Random) -> Document:
    """Without a loaded sleeve; its arms on the axis, off it, or a little crossed."""
    arm = draw_log_uniform(random, 0.15, 0.6)
    return draw_pendulum_governor(random, {"arm": arm, "offset": arm * draw_uniform(random, -0.12, 0.3)})


def draw_porter(random: Random) -> Document:
    """A loaded sleeve on links as long as the arms, or on others."""
    arm = draw_log_uniform(random, 0.15, 0.6)
    more = {"arm": arm, "offset": arm * draw_uniform(random, 0.0, 0.3), "sleeve_mass": draw_log_uniform(random, 0.5, 60.0)}
    if draw_bool(random, 0.4):
        more["link"] = arm * draw_uniform(random, 0.9, 1.3)
    return draw_pendulum_governor(random, more)


def draw_extended_arms(random: Random) -> Document:
    """Balls on arms that go on beyond the joints of the links."""
    arm = draw_log_uniform(random, 0.2, 0.6)
    joint = arm * draw_uniform(random, 0.5, 0.95)
    more = {"arm": arm, "arm_joint": joint, "offset": arm * draw_uniform(random, -0.05, 0.2)}
    if draw_bool(random, 0.5):
        more["link"] = joint * draw_uniform(random, 0.9, 1.3)
    return draw_pendulum_governor(random, more | {"sleeve_mass": draw_log_uniform(random, 0.5, 40.0)})


def draw_crossed_arms(random: Random) -> Document:
    """Arms that cross the axis, and links with them."""
    arm = draw_log_uniform(random, 0.2, 0.6)
    more = {"arm": arm, "offset": -arm * draw_uniform(random, 0.02, 0.15), "sleeve_mass": draw_log_uniform(random, 0.5, 20.0)}
    return draw_pendulum_governor(random, more)


def draw_uncrossed_links(random: Random) -> Document:
    """Arms that cross the axis, links that do not."""
    arm = draw_log_uniform(random, 0.25, 0.6)
    joint = arm * draw_uniform(random, 0.55, 0.8)
    more = {
        "arm": arm,
        "arm_joint": joint,
        "link": joint * draw_uniform(random, 0.75, 1.1),
        "offset": -arm * draw_uniform(random, 0.03, 0.12),
        "lug_offset": arm * draw_uniform(random, 0.03, 0.1),
    }
    return draw_pendulum_governor(random, more | {"sleeve_mass": draw_log_uniform(random, 0.5, 20.0)})


def draw_parabolic(random: Random) -> Document:
    """Return a parabolic governor near its neutral speed."""
    inner, outer = 0.05, draw_uniform(random, 0.2, 0.4)
    ball, sleeve, parameter = 1.0, draw_log_uniform(random, 0.5, 10.0), draw_uniform(random, 0.3, 0.9)
    dimensions = {"double_parameter": parameter, "inner_radius": inner, "outer_radius": outer, "ball_mass": ball, "sleeve_mass": sleeve}
    start = {"ball_radius": inner + (outer - inner) * draw_uniform(random, 0.2, 0.8), "ball_rate": draw_uniform(random, -0.05, 0.05)}
    speed = math.sqrt(2 * G * (1 + sleeve / ball) / parameter) * draw_uniform(random, 0.97, 1.03)
    return governor_document("parabolic_governor", dimensions, {"gravity": True, "centrifugal": True}, start, speed, random)


def draw_hartung(random: Random) -> Document:
    """Bell cranks at any angle, springs between two speeds that hold the ends of the stroke, or by a rate."""
    arm, radius = draw_uniform(random, 0.08, 0.15), draw_uniform(random, 0.1, 0.16)
    slow = draw_uniform(random, 15.0, 30.0)
    fast = slow * draw_uniform(random, 1.02, 1.2)
    dimensions: Document = {
        "weight_arm": arm,
        "sleeve_arm": arm * draw_uniform(random, 1.0, 1.6),
        "bell_crank_angle": math.radians(draw_uniform(random, 90.0, 135.0)),
        "fulcrum_radius": radius,
        "weight_mass": draw_log_uniform(random, 5.0, 60.0),
        "sleeve_mass": draw_log_uniform(random, 2.0, 40.0),
        "inner_angle": 0.26,
        "outer_angle": -0.26,
        "inner_speed": slow,
        "outer_speed": fast,
    }
    if draw_bool(random, 0.5):
        dimensions |= {"hanger": draw_uniform(random, 0.25, 0.5), "lug_offset": draw_uniform(random, 0.03, 0.08)}
    effects: Document = {"gravity": True, "centrifugal": True}
    if draw_bool(random, 0.4):
        sizes = {"weight_width": 0.15, "weight_height": draw_uniform(random, 0.1, 0.25)}
        effects["bell_cranks"] = {"mass": draw_log_uniform(random, 1.0, 8.0)} | (sizes if draw_bool(random, 0.5) else {})
    start = {"lever_angle": draw_uniform(random, -0.12, 0.12), "lever_rate": draw_uniform(random, -0.3, 0.3)}
    return governor_document("hartung", dimensions, effects, start, draw_uniform(random, slow, fast), random)


# --- cranks -----------------------------------------------------------------------------------------------------------


def draw_slide_valve(random: Random) -> Document:
    """Return a slide valve driven at constant speed, with rods of any length or infinitely long ones."""
    eccentric, speed = draw_uniform(random, 0.03, 0.08), draw_log_uniform(random, 2.0, 20.0)
    dimensions: Document = {
        "crank": draw_uniform(random, 0.15, 0.4),
        "eccentric": eccentric,
        "advance": draw_uniform(random, 0.2, 0.8),
        "outside_lap": eccentric * draw_uniform(random, 0.2, 0.5),
        "inside_lap": eccentric * draw_uniform(random, 0.0, 0.1),
        "crank_speed": speed,
        "crank_start": draw_uniform(random, -3.0, 3.0),
        "setting": draw_choice(random, ("equal leads", "middle of extremes", "equal cut-offs")),
    }
    if draw_bool(random, 0.7):
        dimensions["connecting_rod"] = dimensions["crank"] * draw_uniform(random, 2.5, 6.0)
    if draw_bool(random, 0.7):
        dimensions["eccentric_rod"] = eccentric * draw_log_uniform(random, 4.0, 30.0)
    return driven_crank_document("slide_valve", dimensions, {}, speed, random)


def draw_link_gear(random: Random) -> Document:
    """Return Stephenson's link motion: open or crossed rods, any suspension, the lever at rest or moving, with masses or without."""
    half_link, speed = draw_uniform(random, 0.1, 0.2), draw_log_uniform(random, 2.0, 20.0)
    eccentric = half_link * draw_uniform(random, 0.2, 0.45)
    dimensions: Document = {
        "crank": draw_uniform(random, 0.2, 0.4),
        "connecting_rod": draw_uniform(random, 1.2, 2.0),
        "eccentric": eccentric,
        "eccentric_rod": half_link * draw_uniform(random, 6.0, 12.0),
        "advance": draw_uniform(random, 0.2, 0.8),
        "rods": draw_choice(random, ("open", "crossed")),
        "link_radius": half_link * draw_uniform(random, 6.0, 12.0),
        "half_link": half_link,
        "pin_setback": half_link * draw_uniform(random, 0.0, 0.5),
        "suspension": draw_choice(random, ("arc middle", "chord middle", "lower pin", "half-way")),
        "hanger": half_link * draw_uniform(random, 2.5, 5.0),
        "outside_lap": eccentric * draw_uniform(random, 0.2, 0.5),
        "crank_speed": speed,
        "crank_start": draw_uniform(random, -3.0, 3.0),
        "reverser": draw_uniform(random, -1.0, 1.0),
    }
    if draw_bool(random, 0.5):
        end = draw_uniform(random, -1.0, 1.0)
        dimensions["reverser"] = [[0.0, dimensions["reverser"]], [draw_uniform(random, 4.0, 8.0) / speed, end]]
    effects: Document = {"gravity": True} if draw_bool(random, 0.5) else {}
    if draw_bool(random, 0.5):
        effects["link_masses"] = {name: draw_log_uniform(random, 5.0, 60.0) for name in ("link", "eccentric_rod", "valve")}
    return driven_crank_document("stephenson", dimensions, effects, speed, random)


def draw_slider_crank(random: Random) -> Document:
    """Driven steadily, with masses or without."""
    crank, speed = draw_uniform(random, 0.1, 0.4), draw_log_uniform(random, 2.0, 20.0)
    dimensions = {
        "crank": crank,
        "connecting_rod": crank * draw_uniform(random, 2.0, 6.0),
        "crank_speed": speed,
        "crank_start": draw_uniform(random, -3.0, 3.0),
    }
    effects: Document = {"gravity": True} if draw_bool(random, 0.5) else {}
    if draw_bool(random, 0.6):
        effects["masses"] = {
            "crank": draw_log_uniform(random, 5.0, 100.0),
            "crank_centre": draw_uniform(random, -0.1, 0.1),
            "rod": draw_log_uniform(random, 5.0, 100.0),
            "crosshead": draw_log_uniform(random, 5.0, 100.0),
        }
    return driven_crank_document("slider_crank", dimensions, effects, speed, random)


def driven_crank_document(machine: str, dimensions: Document, effects: Document, speed: float, random: Random) -> Document:
    """The document of a machine whose crank is driven for a turn or two."""
    run = draw_run_settings(random, math.tau / speed * draw_uniform(random, 0.5, 2.0))
    return {"machine": machine, "dimensions": dimensions, "effects": effects, "run": run}


# --- mechanisms of a user's own ---------------------------------------------------------------------------------------


def pin_table(first: str, second: str) -> Document:
    """A joint of a document."""
    return {"type": "pin", "first": first, "second": second}


def draw_rod_body(random: Random, name: str, length: float, start: complex, end: complex) -> Document:
    """A rod of any weight between two places."""
    return {
        "name": name,
        "mass": draw_log_uniform(random, 0.3, 5.0),
        "rod": {"length": length},
        "at": [start.real, start.imag],
        "angle": cmath.phase(end - start),
    }


def custom_document(random: Random, duration: float, **tables: Any) -> Document:
    """The document of a mechanism of a user's own, with weight as a rule."""
    effects = {"gravity": True} if draw_bool(random, 0.8) else {}
    return {"machine": "custom", "effects": effects, "run": draw_run_settings(random, duration), **tables}


def draw_free_engine(random: Random) -> Document:
    """A free slider crank: a flywheel on its shaft, steam that pushes for a time, a brake."""
    crank, angle = draw_uniform(random, 0.08, 0.3), draw_uniform(random, -3.0, 3.0)
    rod = crank * draw_uniform(random, 2.2, 5.0)
    knee = cmath.rect(crank, angle)
    foot = knee.real + math.sqrt(rod**2 - knee.imag**2)
    rate = draw_uniform(random, 2.0, 12.0)
    duration = math.tau / rate * draw_uniform(random, 0.5, 2.0)
    push = draw_uniform(random, -20.0, 40.0)
    steam = [[0.0, push], [0.3 * duration, push], [0.3 * duration, 0.0], [0.6 * duration, 0.5 * push]]
    wheel = {"name": "crank", "mass": draw_log_uniform(random, 2.0, 30.0), "disc": {"radius": draw_uniform(random, 0.1, 0.5)}}
    return custom_document(
        random,
        duration,
        ground={"O": [0.0, 0.0]},
        body=[
            wheel | {"points": {"pin": [crank, 0.0]}, "at": [0.0, 0.0], "angle": angle},
            draw_rod_body(random, "rod", rod, knee, complex(foot)),
            {"name": "piston", "mass": draw_log_uniform(random, 0.5, 5.0), "turns": False, "at": [foot, 0.0]},
        ],
        joint=[
            pin_table("ground.O", "crank.origin"),
            pin_table("crank.pin", "rod.start"),
            pin_table("rod.end", "piston.centre"),
            {"type": "slider", "first": "ground.O", "second": "piston.centre", "angle": 0},
        ],
        force=[{"type": "force", "point": "piston.centre", "x": steam}] if draw_bool(random, 0.6) else [],
        readings={"crank_angle": {"angle": "crank"}, "piston": {"x": "piston.centre"}},
        start={"crank_angle": angle, "crank_rate": rate},
    )


@dataclass(frozen=True)
class FourBarPose:
    """Where a four-bar linkage stands: the ends of crank and rocker, and how fast its crank turns."""

    knee: complex
    elbow: complex
    pivot: complex
    angle: float
    rate: float


def draw_four_bar_pose(random: Random) -> FourBarPose:
    """Some four-bar linkage that can be put together."""
    while True:
        crank, ground = draw_uniform(random, 0.08, 0.25), draw_uniform(random, 0.25, 0.5)
        rod, rocker = (draw_uniform(random, 0.2, 0.5) for _ in range(2))
        pivot = cmath.rect(ground, draw_uniform(random, -3.0, 3.0))
        angle = draw_uniform(random, -3.0, 3.0)
        knee = cmath.rect(crank, angle)
        far = abs(pivot - knee)
        cosine = (rod**2 + far**2 - rocker**2) / (2 * rod * far)
        # Not near a change point, where the branch is ambiguous: it may occur in the motion, not at the start.
        if abs(cosine) < 0.9:
            turn = math.acos(cosine) * draw_choice(random, (-1.0, 1.0))
            elbow = knee + cmath.rect(rod, cmath.phase(pivot - knee) + turn)
            return FourBarPose(knee, elbow, pivot, angle, draw_choice(random, (-1.0, 1.0)) * draw_uniform(random, 1.0, 8.0))


def draw_four_bar(random: Random) -> Document:
    """A crank, a coupler and a rocker with springs, dampers and torques; driven by a motor at times."""
    one = draw_four_bar_pose(random)
    return four_bar_document(random, one, [], [], {})


def draw_six_bar(random: Random) -> Document:
    """A four-bar linkage whose rocker moves a ram by a further rod."""
    one = draw_four_bar_pose(random)
    length = draw_uniform(random, 0.6, 0.9)
    foot = one.elbow.real + math.sqrt(length**2 - (0.6 * one.elbow.imag) ** 2)
    level = 0.4 * one.elbow.imag
    bodies = [
        draw_rod_body(random, "second rod", length, one.elbow, complex(foot, level)),
        {"name": "ram", "mass": draw_log_uniform(random, 0.5, 5.0), "turns": False, "at": [foot, level]},
    ]
    joints = [
        pin_table("rocker.end", "second rod.start"),
        pin_table("second rod.end", "ram.centre"),
        {"type": "slider", "first": ["ground", 0.0, level], "second": "ram.centre", "angle": 0},
    ]
    return four_bar_document(random, one, bodies, joints, {"ram": {"x": "ram.centre"}})


def four_bar_document(
    random: Random, pose: FourBarPose, bodies: list[Document], joints: list[Document], more_readings: Document
) -> Document:
    """The document of a four-bar linkage and of what it moves."""
    parts = [
        draw_rod_body(random, "crank", abs(pose.knee), 0j, pose.knee),
        draw_rod_body(random, "coupler", abs(pose.elbow - pose.knee), pose.knee, pose.elbow),
        draw_rod_body(random, "rocker", abs(pose.elbow - pose.pivot), pose.pivot, pose.elbow),
    ]
    pins = [
        pin_table("ground.A", "crank.start"),
        pin_table("crank.end", "coupler.start"),
        pin_table("coupler.end", "rocker.end"),
        pin_table("ground.D", "rocker.start"),
    ]
    start: Document = {"crank_angle": pose.angle, "crank_rate": pose.rate}
    duration = draw_uniform(random, 0.4, 1.5)
    if draw_bool(random, 0.25):
        drive = {"type": "driven_turn", "name": "motor", "first": "ground", "second": "crank", "angle": pose.angle}
        if draw_bool(random, 0.5):
            drive["rate"] = pose.rate
        else:
            middle, last = (pose.angle + pose.rate * duration * draw_uniform(random, 0.3, 1.0) * share for share in (0.5, 1.2))
            drive.pop("angle")
            drive["motion"] = [[0.0, pose.angle], [0.5 * duration, middle], [1.2 * duration, last]]
        pins.append(drive)
        start = {}
    return custom_document(
        random,
        duration,
        ground={"A": [0.0, 0.0], "D": [pose.pivot.real, pose.pivot.imag], "S": [0.5, 0.6]},
        body=parts + bodies,
        joint=pins + joints,
        force=draw_force_elements(random),
        readings={"crank_angle": {"angle": "crank"}, "rocker_angle": {"angle": "rocker"}, **more_readings},
        start=start,
    )


def draw_force_elements(random: Random) -> list[Document]:
    """What may pull at a four-bar linkage: none of these, or some."""
    every: list[Document] = [
        {
            "type": "spring",
            "first": "ground.S",
            "second": "rocker.end",
            "stiffness": draw_log_uniform(random, 5.0, 300.0),
            "free_length": draw_uniform(random, 0.1, 0.5),
        },
        {"type": "damper", "first": "ground.S", "second": "rocker.end", "damping": draw_log_uniform(random, 0.1, 20.0)},
        {"type": "torque", "body": "crank", "moment": draw_uniform(random, -2.0, 2.0)},
        {"type": "torsion_spring", "second": "rocker", "stiffness": draw_log_uniform(random, 0.1, 10.0)},
        {"type": "torsion_damper", "second": "rocker", "damping": draw_log_uniform(random, 0.001, 0.1)},
    ]
    return [load for load in every if draw_bool(random, 0.3)]


def draw_quick_return(random: Random) -> Document:
    """The shipped shaping machine with other dimensions."""
    found: Document = tomllib.loads(shipped_scenes()["quick_return"].read_text(encoding="utf-8"))
    crank, lever, ram = found["body"]
    crank["points"] = {"pin": [draw_uniform(random, 0.04, 0.1), 0.0]}
    for body in (crank, lever, ram):
        body["mass"] = draw_log_uniform(random, 1.0, 15.0)
    found["link"][0]["length"] = draw_uniform(random, 0.14, 0.25)
    found["force"][0]["damping"] = draw_log_uniform(random, 1.0, 500.0)
    rate = draw_log_uniform(random, 2.0, 15.0)
    found["joint"][-1]["rate"] = rate
    return found | {"run": draw_run_settings(random, math.tau / rate * draw_uniform(random, 0.5, 2.0))}


def draw_double_pendulum(random: Random) -> Document:
    """Two rods in a chain, which swing too little and too short to be chaotic."""
    lengths = [draw_uniform(random, 0.2, 0.6) for _ in range(2)]
    angles = [-math.pi / 2 + draw_uniform(random, -0.7, 0.7) for _ in range(2)]
    knee = cmath.rect(lengths[0], angles[0])
    return custom_document(
        random,
        draw_uniform(random, 0.5, 2.0),
        ground={"O": [0.0, 0.0]},
        body=[
            draw_rod_body(random, "upper", lengths[0], 0j, knee),
            draw_rod_body(random, "lower", lengths[1], knee, knee + cmath.rect(lengths[1], angles[1])),
        ],
        joint=[pin_table("ground.O", "upper.start"), pin_table("upper.end", "lower.start")],
        readings={"upper": {"angle": "upper"}, "lower": {"angle": "lower"}},
        start={"upper": angles[0], "upper_rate": draw_uniform(random, -1.0, 1.0), "lower": angles[1]},
    )


MACHINES: Mapping[str, Callable[[Random], Document]] = {
    "Watt": draw_watt,
    "Porter": draw_porter,
    "extended arms": draw_extended_arms,
    "crossed arms": draw_crossed_arms,
    "uncrossed links": draw_uncrossed_links,
    "parabolic": draw_parabolic,
    "Hartung": draw_hartung,
    "slide valve": draw_slide_valve,
    "slider crank": draw_slider_crank,
    "free engine": draw_free_engine,
    "four-bar": draw_four_bar,
    "six-bar": draw_six_bar,
    "quick return": draw_quick_return,
    "double pendulum": draw_double_pendulum,
}
