"""Machines that the study of certificates adds to those of `random_machines`: engines, chains, and governors at their limits."""

import cmath
import math
from collections.abc import Callable, Mapping
from itertools import pairwise

import random_machines as machines
from governor_mechanism.closed_form import pendulum as closed

N_LOAD_STEPS = (100, 300, 1000)
"""Numbers of steps of a load: their roundings add up."""


def draw_reports(random: machines.Random, duration: float) -> machines.Document:
    """Return the settings of a run with four to a hundred reports: with few of them a step goes as far as the motion allows."""
    return {"duration": duration, "output_interval": duration / round(machines.draw_log_uniform(random, 4.0, 100.0))}


# --- engines ----------------------------------------------------------------------------------------------------------


def draw_cylinder(random: machines.Random) -> machines.Document:
    """Return the dimensions of an expansion cylinder."""
    return {
        "area": machines.draw_log_uniform(random, 0.005, 0.06),
        "stroke": machines.draw_uniform(random, 0.25, 0.8),
        "cut_off": machines.draw_uniform(random, 0.15, 0.8),
        "clearance": machines.draw_uniform(random, 0.02, 0.1),
        "supply_pressure": machines.draw_uniform(random, 2e5, 7e5),
        "back_pressure": machines.draw_uniform(random, 0.9e5, 1.5e5),
        "atmospheric_pressure": 1e5,
    }


def mean_torque(cylinder: Mapping[str, float]) -> float:
    """Return the mean torque of the gas of a cylinder, N m."""
    supply, cut_off, clearance = cylinder["supply_pressure"], cylinder["cut_off"], cylinder["clearance"]
    pressure = supply * (cut_off + (clearance + cut_off) * math.log((clearance + 1) / (clearance + cut_off))) - cylinder["back_pressure"]
    return cylinder["area"] * cylinder["stroke"] * pressure / math.pi


def draw_air_engine(random: machines.Random) -> machines.Document:
    """Return an air engine with a constant load: rods of any length or endless, at times a pump."""
    dimensions = draw_cylinder(random)
    stroke_work = dimensions["area"] * dimensions["stroke"] * dimensions["supply_pressure"]
    if machines.draw_bool(random, 0.4):
        dimensions["connecting_rod"] = dimensions["stroke"] * machines.draw_uniform(random, 1.2, 4.0)
    dimensions["load_torque"] = mean_torque(dimensions) * machines.draw_uniform(random, 0.7, 1.2)
    if machines.draw_bool(random, 0.3):
        dimensions |= {"pump_area": 0.3 * dimensions["area"], "pump_clearance": machines.draw_uniform(random, 0.02, 0.1)}
    rate = machines.draw_log_uniform(random, 3.0, 30.0)
    # The work of a stroke changes the energy by a small or a large share.
    dimensions["inertia"] = stroke_work / rate**2 * machines.draw_log_uniform(random, 4.0, 100.0)
    start = {"crank_angle": machines.draw_uniform(random, 0.05, 6.0), "crank_rate": rate}
    run = {"duration": math.tau / rate * machines.draw_uniform(random, 0.6, 6.0)}
    return {"machine": "flywheel_engine", "dimensions": dimensions, "start": start, "run": run}


def draw_load_steps(random: machines.Random) -> machines.Document:
    """Return a flywheel or a governor on a free spindle, whose load changes up to a thousand times."""
    return draw_flywheel_with_load_steps(random) if machines.draw_bool(random, 0.5) else draw_spindle_with_load_steps(random)


def draw_steps(random: machines.Random, duration: float, low: float, high: float) -> list[list[float]]:
    """Return a load that changes many times within a duration (s), between two bounds, as points over time."""
    n_steps = machines.draw_choice(random, N_LOAD_STEPS)
    times = [duration * (k + machines.draw_uniform(random, 0.1, 0.9)) / n_steps for k in range(n_steps)]
    loads = [machines.draw_uniform(random, low, high) for _ in range(n_steps + 1)]
    steps = [[time, load] for time, pair in zip(times, pairwise(loads), strict=True) for load in pair]
    return [[0.0, loads[0]], *steps, [2 * duration, loads[-1]]]


def draw_flywheel_with_load_steps(random: machines.Random) -> machines.Document:
    """Return a flywheel under the mean torque of the gas, with steps of the load and a load that grows with the speed."""
    dimensions = draw_cylinder(random)
    rate, torque = machines.draw_log_uniform(random, 3.0, 30.0), mean_torque(dimensions)
    duration = math.tau / rate * machines.draw_uniform(random, 1.0, 4.0)
    dimensions["inertia"] = torque * duration / rate * machines.draw_log_uniform(random, 0.3, 10.0)
    dimensions["load_damping"] = 0.5 * torque / rate * machines.draw_uniform(random, 0.5, 1.5)
    dimensions |= {"gas_torque": "mean", "load_torque": draw_steps(random, duration, 0.1 * torque, 0.9 * torque)}
    start = {"crank_angle": machines.draw_uniform(random, 0.0, 6.0), "crank_rate": rate}
    run = {"duration": duration}
    return {"machine": "flywheel_engine", "dimensions": dimensions, "start": start, "run": run}


def draw_spindle_with_load_steps(random: machines.Random) -> machines.Document:
    """Return a Porter governor on a free spindle whose torque changes in steps."""
    dimensions, angle, speed = draw_governor(random)
    inertia, duration = machines.draw_log_uniform(random, 0.05, 5.0), math.tau / speed * machines.draw_uniform(random, 1.0, 4.0)
    torque = inertia * speed / duration
    return {
        "machine": "pendulum_governor",
        "dimensions": dimensions,
        "effects": {"gravity": True, "centrifugal": True},
        "start": {"arm_angle": angle, "arm_rate": machines.draw_uniform(random, -0.2, 0.2)},
        "spindle": {"inertia": inertia, "start_speed": speed, "torque": draw_steps(random, duration, -0.2 * torque, 0.2 * torque)},
        "run": {"duration": duration},
    }


def draw_governed_engine(random: machines.Random) -> machines.Document:
    """Return an engine with mean or cyclic torque of the gas, whose load steps and whose governor moves the throttle."""
    engine = draw_cylinder(random) | {"throttle": 1.0, "load_torque": 0}
    if machines.draw_bool(random, 0.5):
        engine["gas_torque"] = "mean"
    if machines.draw_bool(random, 0.3):
        engine |= {"pump_area": 0.3 * engine["area"], "pump_clearance": machines.draw_uniform(random, 0.02, 0.06)}
    arm = machines.draw_uniform(random, 0.15, 0.35)
    governor: machines.Document = {
        "arm": arm,
        "offset": arm * machines.draw_uniform(random, 0.0, 0.2),
        "ball_mass": machines.draw_uniform(random, 2.0, 6.0),
        "sleeve_mass": machines.draw_uniform(random, 5.0, 30.0),
    }
    angle = machines.draw_uniform(random, 0.5, 0.8)
    spindle_speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**governor), arm_angle=angle))
    ratio = machines.draw_choice(random, (0.5, 1.0, 2.0))
    crank_rate = spindle_speed / ratio
    torque = mean_torque(engine)
    engine["inertia"] = math.pi * torque / crank_rate**2 * machines.draw_log_uniform(random, 4.0, 30.0)
    lift = 2 * arm * (1 - math.cos(angle))
    duration = math.tau / spindle_speed * machines.draw_uniform(random, 1.0, 4.0)
    step_time, step = duration * machines.draw_uniform(random, 0.1, 0.7), machines.draw_uniform(random, 0.6, 1.2)
    effects: machines.Document = {"gravity": machines.G, "centrifugal": True}
    if machines.draw_bool(random, 0.5):
        effects["dashpot"] = {"sleeve_lift": governor["sleeve_mass"] * spindle_speed * machines.draw_uniform(random, 0.2, 1.0)}
    if machines.draw_bool(random, 0.2):
        effects["stops"] = {"arm_angle": [angle - 0.05, angle + 0.05]}
    engine_start = {"crank_angle": machines.draw_uniform(random, 0.0, 6.0), "crank_rate": crank_rate}
    start = {"arm_angle": angle, "arm_rate": machines.draw_uniform(random, -0.2, 0.2)}
    rod = {"type": "control", "reading": "governor.sleeve_lift", "scales": "engine.throttle"}
    rod["table"] = [[0.3 * lift, 1.0], [2.0 * lift, machines.draw_uniform(random, 0.4, 0.8)]]
    fraction = [[0.0, 1.0], [step_time, 1.0], [step_time, step]]
    return {
        "part": {
            "engine": {"machine": "flywheel_engine", "dimensions": engine, "start": engine_start},
            "governor": {"machine": "pendulum_governor", "dimensions": governor, "effects": effects, "start": start},
        },
        "coupling": {
            "gear": {"type": "gear", "first": "engine.crank_angle", "second": "governor.spindle_angle", "ratio": ratio},
            "rod": rod,
        },
        "load": {"angle": "engine.crank_angle", "rated_torque": 0.8 * torque, "fraction": fraction},
        "run": {"duration": duration},
    }


# --- linkages ----------------------------------------------------------------------------------------------------------


def draw_chain(random: machines.Random) -> machines.Document:
    """Return a chain of 2 to 10 parallelograms (IFToMM A02) that passes the line of all its bars, most of them once or twice."""
    loops, angle, rate = int(random.integers(2, 11)), 0.5 * math.pi, -1.0
    length, crank_mass, coupler_mass = 1.0, 1.0, 1.0
    if machines.draw_bool(random, 0.6):  # else the published dimensions
        length, angle, rate = (
            machines.draw_uniform(random, 0.5, 1.5),
            machines.draw_uniform(random, 0.35, math.pi - 0.35),
            -machines.draw_uniform(random, 1.0, 4.0),
        )
        crank_mass, coupler_mass = (machines.draw_log_uniform(random, 0.3, 3.0) for _ in range(2))
    tip = (length * math.cos(angle), length * math.sin(angle))
    bodies = [
        {"name": f"crank {k}", "mass": crank_mass, "rod": {"length": length}, "at": [k * length, 0.0], "angle": angle}
        for k in range(loops + 1)
    ]
    bodies += [
        {"name": f"coupler {k}", "mass": coupler_mass, "rod": {"length": length}, "at": [(k - 1) * length + tip[0], tip[1]]}
        for k in range(1, loops + 1)
    ]
    joints = [machines.pin_table(f"ground.A{k}", f"crank {k}.start") for k in range(loops + 1)]
    for k in range(1, loops + 1):
        joints += [machines.pin_table(f"crank {k - 1}.end", f"coupler {k}.start"), machines.pin_table(f"coupler {k}.end", f"crank {k}.end")]
    return {
        "machine": "custom",
        "ground": {f"A{k}": [k * length, 0.0] for k in range(loops + 1)},
        "body": bodies,
        "joint": joints,
        "readings": {
            "crank_angle": {"angle": "crank 0"},
            "last_angle": {"angle": f"crank {loops}"},
            "x": {"x": "crank 0.end"},
            "y": {"y": "crank 0.end"},
        },
        "effects": {"gravity": machines.G},
        "start": {"crank_angle": angle, "crank_rate": rate},
        "run": {"duration": machines.draw_log_uniform(random, 0.6, 2.5)},
    }


def draw_moving_ground(random: machines.Random) -> machines.Document:
    """Return a four-bar linkage, rods in a chain, or rods on a curve whose first bearing is shaken."""
    frequency = machines.draw_log_uniform(random, 2.0, 15.0)
    swing = {"start": 0.0, "harmonics": [{"amplitude": machines.draw_log_uniform(random, 0.003, 0.03), "frequency": frequency, "phase": 0}]}
    place = [0.0, swing] if machines.draw_bool(random, 0.5) else [swing, 0.0]
    found = machines.draw_choice(random, (draw_shaken_four_bar, draw_shaken_chain, draw_shaken_rods_on_a_curve))(random)
    found["ground"]["A"] = place
    return found


def draw_shaken_four_bar(random: machines.Random) -> machines.Document:
    """Return a four-bar linkage."""
    return machines.four_bar_document(random, machines.draw_four_bar_pose(random), [], [], {})


def draw_rod_line(
    random: machines.Random, angles: list[float], start: complex = 0j, first: int = 0
) -> tuple[list[machines.Document], complex]:
    """Return rods end to end at angles (rad), and the end of the last one."""
    bodies = []
    for k, angle in enumerate(angles, first):
        length = machines.draw_uniform(random, 0.2, 0.6)
        end = start + cmath.rect(length, angle)
        bodies.append(machines.draw_rod_body(random, f"rod {k}", length, start, end))
        start = end
    return bodies, start


def draw_shaken_chain(random: machines.Random) -> machines.Document:
    """Return one or two hanging rods."""
    angles = [-math.pi / 2 + machines.draw_uniform(random, -0.7, 0.7) for _ in range(machines.draw_choice(random, (1, 2)))]
    bodies, _ = draw_rod_line(random, angles)
    joints = [machines.pin_table("ground.A", "rod 0.start"), machines.pin_table("rod 0.end", "rod 1.start")][: len(bodies)]
    return shaken_document(random, bodies, joints, {})


def draw_shaken_rods_on_a_curve(random: machines.Random) -> machines.Document:
    """Return two rods whose end moves on a parabola, with one or two rods that hang from it."""
    knee_angle, sense = machines.draw_uniform(random, 0.4, 1.2), machines.draw_choice(random, (-1.0, 1.0))
    leading, end = draw_rod_line(random, [knee_angle, knee_angle - sense * machines.draw_uniform(random, 0.8, 2.0)])
    hanging = [
        draw_rod_line(random, [-math.pi / 2 + machines.draw_uniform(random, -1.0, 1.0)], end, first=k)[0][0]
        for k in range(2, machines.draw_choice(random, (3, 4)))
    ]
    bend = machines.draw_uniform(random, -0.4, 0.4)
    curve = {"coefficients": [end.imag - bend * end.real**2, 0.0, bend]}
    joints = [
        machines.pin_table("ground.A", "rod 0.start"),
        machines.pin_table("rod 0.end", "rod 1.start"),
        *(machines.pin_table("rod 1.end", f"{rod['name']}.start") for rod in hanging),
        {"type": "curve", "first": "ground.C", "second": "rod 1.end", "curve": curve, "angle": 0},
    ]
    return shaken_document(random, leading + hanging, joints, {"C": [0.0, 0.0]})


def shaken_document(
    random: machines.Random, bodies: list[machines.Document], joints: list[machines.Document], more_ground: machines.Document
) -> machines.Document:
    """Return the document of rods on a bearing that is placed later."""
    last = bodies[-1]["name"]
    return machines.custom_document(
        random,
        machines.draw_uniform(random, 0.5, 1.5),
        ground={"A": [0.0, 0.0], **more_ground},
        body=bodies,
        joint=joints,
        readings={"first": {"angle": "rod 0"}, "x": {"x": f"{last}.end"}, "y": {"y": f"{last}.end"}},
        start={"first": bodies[0]["angle"], "first_rate": machines.draw_uniform(random, -1.5, 1.5)},
    )


# --- governors at their limits -------------------------------------------------------------------------------------------


def draw_governor(random: machines.Random) -> tuple[machines.Document, float, float]:
    """Return the dimensions of a Porter governor, an arm angle (rad), and the spindle speed (rad/s) that holds it there."""
    arm = machines.draw_log_uniform(random, 0.15, 0.6)
    dimensions = {
        "arm": arm,
        "offset": arm * machines.draw_uniform(random, 0.0, 0.3),
        "ball_mass": machines.draw_log_uniform(random, 0.5, 10.0),
        "sleeve_mass": machines.draw_log_uniform(random, 0.5, 60.0),
    }
    angle = machines.draw_uniform(random, 0.45, 0.95)
    return dimensions, angle, float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=angle))


def draw_clearance(random: machines.Random) -> machines.Document:
    """Return a Porter governor with clearance at its sleeve, on a spindle with a speed fluctuation or a ramp."""
    dimensions, angle, speed = draw_governor(random)
    width = machines.draw_log_uniform(random, 2e-4, 5e-3)
    duration = math.tau / speed * machines.draw_uniform(random, 0.5, 2.0)
    effects = {"gravity": True, "centrifugal": True, "clearance": {"width": width, "restitution": machines.draw_restitution(random)}}
    start = {
        "arm_angle": angle + machines.draw_uniform(random, -0.1, 0.1),
        "arm_rate": machines.draw_uniform(random, -0.3, 0.3),
        "sleeve_clearance": width * machines.draw_uniform(random, -0.5, 0.5),
    }
    return {
        "machine": "pendulum_governor", "dimensions": dimensions, "effects": effects, "start": start,
        "spindle": draw_moving_spindle(random, speed, duration), "run": {"duration": duration},
    }  # fmt: skip


def draw_moving_spindle(random: machines.Random, speed: float, duration: float) -> machines.Document:
    """Return a spindle with a speed fluctuation or a ramp."""
    if machines.draw_bool(random, 0.5):
        return {"speed": speed, "speed_fluctuation": machines.draw_log_uniform(random, 0.01, 0.2), "cycles_per_turn": 2.0}
    return {"speed": [[0.0, speed], [duration, speed * machines.draw_uniform(random, 0.9, 1.1)]]}


def draw_sticking_governor(random: machines.Random) -> machines.Document:
    """Return a Porter governor that friction holds at first, or again and again, on a spindle whose speed changes."""
    dimensions, angle, speed = draw_governor(random)
    duration = math.tau / speed * machines.draw_uniform(random, 1.0, 4.0)
    weight = machines.G * (dimensions["sleeve_mass"] + dimensions["ball_mass"])
    friction = weight * machines.draw_log_uniform(random, 0.01, 0.2)
    return {
        "machine": "pendulum_governor",
        "dimensions": dimensions,
        "effects": {"gravity": True, "centrifugal": True, "dry_friction": {"sleeve": friction}},
        "start": {"arm_angle": angle, "arm_rate": machines.draw_choice(random, (0.0, machines.draw_uniform(random, -0.3, 0.3)))},
        "spindle": draw_moving_spindle(random, speed, duration),
        "run": {"duration": duration},
    }


STUDY_MACHINES: Mapping[str, Callable[[machines.Random], machines.Document]] = {
    **machines.MACHINES,
    "link motion": machines.draw_link_gear,
    "air engine": draw_air_engine,
    "load steps": draw_load_steps,
    "governed engine": draw_governed_engine,
    "four-bar chain": draw_chain,
    "moving ground": draw_moving_ground,
    "clearance": draw_clearance,
    "sticking governor": draw_sticking_governor,
}
"""All machines of the study. Those of `random_machines` have effects along their readings besides."""
