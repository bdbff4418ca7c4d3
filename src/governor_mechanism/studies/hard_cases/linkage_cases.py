"""Hard cases of rods and pins: dead centres, change points, redundant joints, mass ratios, long runs, torques that run away."""

import math
from functools import partial

import numpy as np

from governor_mechanism.model.results.records import Outcome
from governor_mechanism.studies.hard_cases.case import (
    GRAVITY,
    Document,
    HardCase,
    Solution,
    force_free_rotation,
    integrate,
    pendulum_period,
    pendulum_swing,
    pin,
    rod,
    run_table,
)
from governor_mechanism.types import FloatArray

BUDGET_END = "so long a run needs more steps than the engine allows"
BRANCH_ENDS = {
    Outcome.DEAD_CENTRE: "the coordinate of reduced does not determine the poses there",
    Outcome.BRANCH_UNRESOLVED: "the lengths decide between two branches more finely than the run resolves",
    Outcome.STEP_LIMIT: BUDGET_END,
}


def _equal_crank_and_rod(n_passes: float) -> Document:
    """Return a crank and a rod as long as each other; the slider passes the bearing of the crank at every half turn."""
    angle = math.radians(30)
    x, y = math.cos(angle), math.sin(angle)
    return {
        "machine": "custom",
        "ground": {"O": [0.0, 0.0]},
        "body": [
            rod("crank", 1.0, angle=angle),
            rod("coupler", 1.0, at=(x, y), angle=-angle),
            {"name": "slider", "mass": 1.0, "turns": False, "at": [2 * x, 0.0]},
        ],
        "joint": [
            pin("ground.O", "crank.start"),
            pin("crank.end", "coupler.start"),
            pin("coupler.end", "slider.origin"),
            {"type": "slider", "first": "ground.O", "second": "slider.origin", "angle": 0.0},
        ],
        "readings": {"crank_angle": {"angle": "crank"}, "slider": {"x": "slider.origin"}},
        "effects": {"gravity": False},
        "start": {"crank_angle": angle, "crank_rate": 1.0},
        # The crank starts between two passes; the mean rate is about 1 rad/s.
        "run": run_table(math.pi * n_passes),
    }


def _equal_crank_and_rod_inertia(angle: float) -> float:
    """Return the inertia of crank, coupler and slider about the crank's bearing, kg m2: all uniform, of 1 kg and 1 m."""
    sine, cosine = math.sin(angle), math.cos(angle)
    return 1 / 3 + (2.25 * sine**2 + 0.25 * cosine**2) + 1 / 12 + 4 * sine**2


def _solve_equal_crank_and_rod(n_passes: float, times: FloatArray) -> Solution:
    angle, rate = force_free_rotation(times, math.radians(30), _equal_crank_and_rod_inertia)
    return {"crank_angle": (angle, rate), "slider": (2 * np.cos(angle), -2 * np.sin(angle) * rate)}


def _parallel_cranks(
    *, angle: float, size: float = 1.0, n_cranks: int = 2, shortening: float = 0.0, start: Document, duration: float, gravity: float = 0.0
) -> Document:
    """Return cranks of one angle and half the length of their straight ground and coupler; the first may be a little shorter."""
    # Equal cranks all turn alike. More than two of them are redundant.
    lengths = [0.5 * size * (1 - shortening), *([0.5 * size] * (n_cranks - 1))]
    feet = [size * index / (n_cranks - 1) for index in range(n_cranks)]
    joints = [(rod(f"crank{i}", length, at=(feet[i], 0.0), angle=angle)) for i, length in enumerate(lengths)]
    end = (lengths[0] * math.cos(angle), lengths[0] * math.sin(angle))
    coupler = rod("coupler", size, at=end) | {"points": {f"p{i}": [foot, 0.0] for i, foot in enumerate(feet)}}
    return {
        "machine": "custom",
        "size": size,
        "ground": {f"G{i}": [foot, 0.0] for i, foot in enumerate(feet)},
        "body": [*joints, coupler],
        "joint": [
            *(pin(f"ground.G{i}", f"crank{i}.start") for i in range(n_cranks)),
            *(pin(f"crank{i}.end", f"coupler.p{i}") for i in range(n_cranks)),
        ],
        "readings": {f"angle{i}": {"angle": f"crank{i}"} for i in (0, 1)},
        "effects": {"gravity": gravity or False},
        "start": {"angle0": angle, **start},
        "run": run_table(duration),
    }


def _shorter_crank(shortening: float, n_passes: float = 10.0) -> Document:
    start = {"angle0_rate": 1.0}
    return _parallel_cranks(angle=0.5 * math.pi, shortening=shortening, start=start, duration=math.pi * n_passes)


def _second_crank(angle: float, shortening: float) -> tuple[float, float, float]:
    """Return the angle of the second crank, and its rate and that of the coupler relative to the first one's."""
    # The assembly does not change: with unequal cranks the linkage passes close to its straight
    # positions, and never through them.
    first, second = 0.5 * (1 - shortening), 0.5
    end = first * np.exp(1j * angle)
    diagonal = end - 1.0
    distance = abs(diagonal)
    # Twice the area of the triangle of diagonal, second crank and coupler, as a product: a difference of squares would lose digits.
    area = math.sqrt(max((distance + second + 1) * (distance + second - 1) * (1 + distance - second) * (1 - distance + second), 0.0)) / 2
    inner_angle = math.atan2(area, (distance**2 + second**2 - 1) / 2)
    other = float(np.angle(diagonal)) - inner_angle
    other_end = 1.0 + second * np.exp(1j * other)
    coupler = other_end - end
    # The velocity of the second end is that of the first plus that of a rotation of the coupler.
    velocity, direction = 1j * end, 1j * second * np.exp(1j * other)
    other_rate = (velocity * coupler.conjugate()).real / (direction * coupler.conjugate()).real
    coupler_rate = ((other_rate * direction - velocity) / (1j * coupler)).real
    return other, other_rate, coupler_rate


def _cranks_inertia(angle: float, shortening: float) -> float:
    """Return the inertia of both cranks and the coupler along the first crank's angle, kg m2: all uniform, of 1 kg."""
    _, other_rate, coupler_rate = _second_crank(angle, shortening)
    first, coupler_angle = 0.5 * (1 - shortening), _coupler_angle(angle, shortening)
    centre = 1j * first * np.exp(1j * angle) + 0.5j * coupler_rate * np.exp(1j * coupler_angle)
    return float(first**2 / 3 + 0.25 * other_rate**2 / 3 + abs(centre) ** 2 + coupler_rate**2 / 12)


def _coupler_angle(angle: float, shortening: float) -> float:
    other, _, _ = _second_crank(angle, shortening)
    return float(np.angle(1.0 + 0.5 * np.exp(1j * other) - 0.5 * (1 - shortening) * np.exp(1j * angle)))


def _solve_shorter_crank(shortening: float, times: FloatArray) -> Solution:
    angle, rate = force_free_rotation(times, 0.5 * math.pi, lambda at: _cranks_inertia(at, shortening))
    others = np.array([_second_crank(float(one), shortening) for one in angle])
    return {"angle0": (angle, rate), "angle1": (np.unwrap(others[:, 0]), others[:, 1] * rate)}


def _solve_uniform_rotation(start: float, times: FloatArray) -> Solution:
    return {name: (start + times, np.ones_like(times)) for name in ("angle0", "angle1")}


def _start_in_line(rate_ratio: float) -> Document:
    return _parallel_cranks(angle=0.0, start={"angle0_rate": 1.0, "angle1_rate": rate_ratio}, duration=2.0)


def _swinging_cranks(n_cranks: float, size: float) -> Document:
    duration = 4 * math.sqrt(size)
    start = {"angle0_rate": 0.0}
    return _parallel_cranks(angle=-0.5 * math.pi + 1.0, size=size, n_cranks=int(n_cranks), start=start, duration=duration, gravity=GRAVITY)


def _solve_swinging_cranks(n_cranks: float, times: FloatArray, size: float) -> Solution:
    inertia = (n_cranks / 3 + 1) * (0.5 * size) ** 2
    moment = (n_cranks / 2 + 1) * 0.5 * size
    angle, rate = pendulum_swing(times, 1.0, math.sqrt(GRAVITY * moment / inertia))
    return {name: (angle - 0.5 * math.pi, rate) for name in ("angle0", "angle1")}


DOUBLE_PENDULUM_START = (0.5, 1.0)
"""Angles of the inner and the outer bar from the vertical at the start, rad."""


def _double_pendulum(mass_ratio: float) -> Document:
    inner, outer = DOUBLE_PENDULUM_START
    first = (math.sin(inner), -math.cos(inner))
    second = (first[0] + math.sin(outer), first[1] - math.cos(outer))
    outer_mass = math.sqrt(mass_ratio)
    points = (("inner", 1 / outer_mass, first), ("outer", outer_mass, second))
    return {
        "machine": "custom",
        "ground": {"O": [0.0, 0.0]},
        "body": [{"name": name, "mass": mass, "point": True, "at": list(at)} for name, mass, at in points],
        "link": [
            {"name": "upper bar", "first": "ground.O", "second": "inner.centre", "length": 1.0},
            {"name": "lower bar", "first": "inner.centre", "second": "outer.centre", "length": 1.0},
        ],
        "readings": {f"{name}_{axis}": {axis: f"{name}.centre"} for name, *_ in points for axis in ("x", "y")},
        "effects": {"gravity": GRAVITY},
        "start": {"inner_x": first[0], "outer_x": second[0]},
        "run": run_table(2.0),
    }


def _solve_double_pendulum(mass_ratio: float, times: FloatArray) -> Solution:
    share = mass_ratio / (1 + mass_ratio)

    def slope(time: float, state: FloatArray) -> list[float]:
        inner, outer, inner_rate, outer_rate = state
        sine, cosine = math.sin(inner - outer), math.cos(inner - outer)
        # Two equations of Lagrange, divided by the total mass and by the outer one; their determinant is 1 - share cosine^2.
        first = -GRAVITY * math.sin(inner) - share * sine * outer_rate**2
        second = -GRAVITY * math.sin(outer) + sine * inner_rate**2
        determinant = 1 / (1 + mass_ratio) + share * sine**2
        return [inner_rate, outer_rate, (first - share * cosine * second) / determinant, (second - cosine * first) / determinant]

    inner, outer, inner_rate, outer_rate = integrate(slope, [*DOUBLE_PENDULUM_START, 0.0, 0.0], times)
    inner_x, inner_x_rate = np.sin(inner), np.cos(inner) * inner_rate
    inner_y, inner_y_rate = -np.cos(inner), np.sin(inner) * inner_rate
    return {
        "inner_x": (inner_x, inner_x_rate),
        "inner_y": (inner_y, inner_y_rate),
        "outer_x": (inner_x + np.sin(outer), inner_x_rate + np.cos(outer) * outer_rate),
        "outer_y": (inner_y - np.cos(outer), inner_y_rate + np.sin(outer) * outer_rate),
    }


LONG_RUN_AMPLITUDE = 1.0
"""Amplitude of the pendulum of the long runs, rad."""


def _swings(n_swings: float) -> Document:
    body = rod("rod", 1.0, angle=LONG_RUN_AMPLITUDE - 0.5 * math.pi)
    return {
        "machine": "custom",
        "ground": {"O": [0.0, 0.0]},
        "body": [body],
        "joint": [pin("ground.O", "rod.start")],
        "readings": {"rod_angle": {"angle": "rod"}},
        "effects": {"gravity": GRAVITY},
        "start": {"rod_angle": body["angle"]},
        "run": run_table(n_swings * pendulum_period(LONG_RUN_AMPLITUDE, math.sqrt(1.5 * GRAVITY))),
    }


def _solve_swings(n_swings: float, times: FloatArray) -> Solution:
    angle, rate = pendulum_swing(times, LONG_RUN_AMPLITUDE, math.sqrt(1.5 * GRAVITY))
    return {"rod_angle": (angle - 0.5 * math.pi, rate)}


def _driven_rod(torque: float) -> Document:
    document = _swings(1.0)
    torques = [{"type": "torque", "body": "rod", "moment": torque}]
    return document | {"force": torques, "effects": {"gravity": False}, "start": {"rod_angle": 0.0}, "run": run_table(10.0)}


def _solve_driven_rod(torque: float, times: FloatArray) -> Solution:
    return {"rod_angle": (1.5 * torque * times**2, 3 * torque * times)}


CASES = (
    HardCase(
        name="dead-centre",
        title="Crank and rod of one length: the slider passes the bearing",
        parameter="number of passes",
        values=(1.0, 10.0, 100.0, 1000.0),
        short_values=(1.0,),
        make_document=_equal_crank_and_rod,
        solve=_solve_equal_crank_and_rod,
        named_ends=BRANCH_ENDS,
    ),
    HardCase(
        name="change-point",
        title="Parallel cranks, one a little shorter than the other",
        parameter="shortening, relative to the crank",
        values=(1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
        short_values=(1e-12,),
        make_document=_shorter_crank,
        solve=_solve_shorter_crank,
        named_ends=BRANCH_ENDS,
    ),
    HardCase(
        name="change-point-passes",
        title="Parallel cranks that pass their change point",
        parameter="number of passes",
        values=(1.0, 10.0, 100.0, 1000.0),
        short_values=(10.0,),
        make_document=lambda n_passes: _shorter_crank(0.0, n_passes),
        solve=lambda n_passes, times: _solve_uniform_rotation(0.5 * math.pi, times),
        named_ends=BRANCH_ENDS,
    ),
    HardCase(
        name="change-point-start",
        title="Parallel cranks that start at their change point, at rates on a branch of the motion or on none",
        parameter="rate of the second crank relative to the first",
        values=(1.0, 0.999, 0.5, -1.0),
        short_values=(1.0, 0.5),
        make_document=_start_in_line,
        solve=lambda ratio, times: _solve_uniform_rotation(0.0, times),
        refused_values=(0.999, 0.5, -1.0),
    ),
    *(
        HardCase(
            name=f"redundant-joints{suffix}",
            title=f"Parallel cranks of 1 {unit}, all but two of them redundant",
            parameter="number of cranks",
            values=(2.0, 3.0, 5.0, 10.0),
            short_values=(5.0,),
            make_document=partial(_swinging_cranks, size=size),
            solve=partial(_solve_swinging_cranks, size=size),
        )
        for suffix, unit, size in (("", "m", 1.0), ("-millimetres", "mm", 1e-3))
    ),
    HardCase(
        name="light-bodies",
        title="Double pendulum with a light inner or outer mass",
        parameter="outer mass relative to the inner one",
        values=(1e-8, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8),
        short_values=(1e-6,),
        make_document=_double_pendulum,
        solve=_solve_double_pendulum,
        named_ends={
            Outcome.STEP_LIMIT: "the light mass oscillates fast",
            Outcome.JOINT_OPENED: "the joint solver of impulse converges the more slowly, the more the masses differ",
        },
    ),
    HardCase(
        name="long-run",
        title="Pendulum that swings for long",
        parameter="number of swings",
        values=(1.0, 1e1, 1e2, 1e3, 1e4, 1e5),
        short_values=(1e1,),
        make_document=_swings,
        solve=_solve_swings,
        named_ends={Outcome.STEP_LIMIT: BUDGET_END},
    ),
    HardCase(
        name="runaway-torque",
        title="Rod with a torque and no resistance",
        parameter="torque, N m",
        values=(1.0, 1e2, 1e4, 1e6, 1e8),
        short_values=(1.0,),
        make_document=_driven_rod,
        solve=_solve_driven_rod,
        named_ends={Outcome.STEP_LIMIT: "it turns ever faster", Outcome.LEFT_RANGE: "it turns ever faster"},
    ),
)
