"""Hard cases of governors: mass ratio, clearance, jump, spindle speeds, fast inputs, scale, limits of the travel, step limit."""

import math

import numpy as np

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.hard_cases.case import GRAVITY, Document, HardCase, Solution, governor_document, run_table, shipped_document
from governor_mechanism.types import FloatArray

MEAN_SPEED = 4 * math.pi
"""Speed of 120 rpm, rad/s."""

START = {"arm_angle": math.radians(40), "arm_rate": 0.15}
"""Start of a swing."""

FAST_END = "so fast a motion needs more steps than the engine allows"


def _heavy_sleeve(mass_ratio: float) -> Document:
    # The balls carry a heavier sleeve at a higher speed only: w^2 r = g (1 + ratio) tan(angle), here with an equilibrium at 30 degrees.
    speed = math.sqrt(GRAVITY * (1 + mass_ratio) * math.tan(math.radians(30)) / 0.19)
    return governor_document(ball_mass=20.0 / mass_ratio, spindle={"speed": f"{speed!r} rad/s"}, start=START, duration=1.0)


def _clearance(width: float) -> Document:
    return shipped_document("watt_clearance", {"effects.clearance": width, "run.duration": 1.0, "run.output_interval": 0.01})


def _jump(ramp_rate: float) -> Document:
    first, last = 6.44, 6.5  # rad/s; the governor leaves its stop and jumps in between
    duration = (last - first) / ramp_rate
    return shipped_document("watt_improved", {"spindle.speed": [[0.0, first], [duration, last]]}) | {"run": run_table(1.5 * duration)}


def _steady_spindle(speed: float) -> Document:
    # At high speed the arms stand level, and a start far below would throw them over: near the equilibrium
    # w^2 r = g (1 + ratio) tan(angle), here with level arms, r = 0.34 m, and a sleeve of four balls.
    level = min(math.atan(speed**2 * 0.34 / (5 * GRAVITY)), math.radians(89.99))
    start = {"arm_angle": math.radians(40) if speed < 20 else level}
    return governor_document(spindle={"speed": f"{speed!r} rad/s"}, start=start, duration=1.0)


def _spindle_to_zero(speed: float) -> Document:
    program = [[0.0, speed], [1.0, 0.0], [1.0, 0.0], [2.0, speed]]
    return governor_document(spindle={"speed": program}, start={"arm_angle": math.radians(40)}, duration=2.0)


def _speed_step(step: float) -> Document:
    program = [[0.5, MEAN_SPEED], [0.5, MEAN_SPEED + step]]
    return governor_document(spindle={"speed": program}, start=START, duration=1.0)


def _fast_fluctuation(cycles_per_turn: float) -> Document:
    spindle = {"speed": MEAN_SPEED, "speed_fluctuation": 0.5, "cycles_per_turn": cycles_per_turn}
    return governor_document(spindle=spindle, start=START, duration=1.0)


def _speed_program(n_points: float) -> Document:
    times = np.linspace(0.0, 2.0, int(n_points))
    program = np.column_stack([times, MEAN_SPEED + np.sin(5 * times)]).tolist()
    return governor_document(spindle={"speed": program}, start=START, duration=2.0)


def _scaled(size: float) -> Document:
    """Return a governor whose lengths are scaled, and its times such that gravity is the same."""
    time = math.sqrt(size)
    start = {"arm_angle": START["arm_angle"], "arm_rate": START["arm_rate"] / time}
    return governor_document(size=size, spindle={"speed": f"{MEAN_SPEED / time!r} rad/s"}, start=start, duration=2.0 * time)


def _solve_scaled(size: float, times: FloatArray) -> Solution:
    """Return the motion of the governor of full size at similar times."""
    time = math.sqrt(size)
    run = ReducedEngine(tolerance=1e-13).run(parse_scene_document(_scaled(1.0)), times=times / time, certify=False)
    factors = {"arm_angle": 1.0, "ball_radius": size, "sleeve_lift": size}
    return {name: (run.readings[name] * factor, run.rates[name] * factor / time) for name, factor in factors.items()}


def _thrown_outwards(rate: float) -> Document:
    start = {"arm_angle": math.radians(40), "arm_rate": rate}
    return governor_document(spindle={"speed": MEAN_SPEED}, start=start, duration=1.0)


def _swing(max_steps: float) -> Document:
    return governor_document(spindle={"speed": MEAN_SPEED}, start=START, duration=10.0)


def _engines_with_step_limit(max_steps: float) -> tuple[Engine, ...]:
    limit = int(max_steps)
    return ReducedEngine(max_steps=limit), MultibodyEngine(max_steps=limit), ImpulseEngine(max_steps=limit)


CASES = (
    HardCase(
        name="mass-ratio",
        title="Heavy sleeve on light balls",
        parameter="sleeve relative to a ball",
        values=(1.0, 1e2, 1e4, 1e6, 1e8),
        short_values=(1e4,),
        make_document=_heavy_sleeve,
        named_ends={Outcome.STEP_LIMIT: FAST_END},
    ),
    HardCase(
        name="clearance",
        title="Light sleeve that strikes the ends of its clearance",
        parameter="clearance, m",
        values=(1e-2, 1e-3, 1e-4, 1e-5),
        short_values=(1e-3,),
        make_document=_clearance,
        named_ends={Outcome.STEP_LIMIT: "strikes in quick succession need more steps than the engine allows"},
    ),
    HardCase(
        name="jump",
        title="Ramp of the speed through the jump of an astatic governor",
        parameter="ramp, rad/s2",
        values=(1e-4, 1e-3, 1e-2, 1e-1),
        short_values=(1e-2,),
        make_document=_jump,
        named_ends={Outcome.STEP_LIMIT: "so slow a ramp needs more steps than the engine allows"},
    ),
    HardCase(
        name="spindle-speed",
        title="Spindle from standstill to absurd speed",
        parameter="spindle speed, rad/s",
        values=(1e-3, 1e-1, 1e1, 1e2, 1e3, 1e4),
        short_values=(1e-3, 1e2),
        make_document=_steady_spindle,
        named_ends={
            Outcome.STEP_LIMIT: FAST_END,
            Outcome.LEFT_RANGE: "the arms go beyond the travel",
            Outcome.JOINT_OPENED: "the joints of impulse do not hold loads that are thousands of times the weights",
            Outcome.DEAD_CENTRE: "the arms turn back nearer to the horizontal than the table of reduced reaches",
        },
    ),
    HardCase(
        name="spindle-to-zero",
        title="Spindle that stops and starts again",
        parameter="first and last speed, rad/s",
        values=(1.0, 1e1, 1e2),
        short_values=(1e1,),
        make_document=_spindle_to_zero,
        named_ends={Outcome.LEFT_RANGE: "the arms go beyond the travel"},
    ),
    HardCase(
        name="speed-step",
        title="Step of the spindle speed",
        parameter="step, rad/s",
        values=(1e-9, 1e-6, 1e-3, 1.0, 1e2),
        short_values=(1.0,),
        make_document=_speed_step,
        named_ends={Outcome.LEFT_RANGE: "the arms go beyond the travel"},
    ),
    HardCase(
        name="fast-fluctuation",
        title="Fast fluctuation of the spindle speed",
        parameter="cycles per turn",
        values=(1.0, 10.0, 100.0, 200.0, 1000.0),
        short_values=(100.0,),
        make_document=_fast_fluctuation,
        named_ends={Outcome.STEP_LIMIT: FAST_END},
    ),
    HardCase(
        name="speed-program",
        title="Program of the speed with many points",
        parameter="number of points",
        values=(10.0, 100.0, 1000.0, 5000.0),
        short_values=(100.0,),
        make_document=_speed_program,
        named_ends={Outcome.STEP_LIMIT: "every point of the program ends a step"},
    ),
    HardCase(
        name="scale",
        title="Governors of all sizes, against the law of similarity",
        parameter="size relative to an arm of 0.3 m",
        values=(1e-4, 1e-2, 1.0, 1e2, 1e4),
        short_values=(1e-4,),
        make_document=_scaled,
        solve=_solve_scaled,
    ),
    HardCase(
        name="limits",
        title="Arms thrown towards the ends of their travel",
        parameter="rate at the start, rad/s",
        values=(1.0, 1e1, 1e2, 1e3),
        short_values=(1e2,),
        make_document=_thrown_outwards,
        named_ends={Outcome.LEFT_RANGE: "the arms go beyond the travel"},
    ),
    HardCase(
        name="step-limit",
        title="Limit of the number of steps",
        parameter="max_steps",
        values=(1.0, 10.0, 100.0),
        short_values=(10.0,),
        make_document=_swing,
        engines=_engines_with_step_limit,
        named_ends={Outcome.STEP_LIMIT: "the limit is low on purpose"},
    ),
)
