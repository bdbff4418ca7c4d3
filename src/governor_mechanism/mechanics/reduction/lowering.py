"""A scene of mobility one as what is sampled along its coordinate, and what acts on the motion along it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import brakes_of, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.force_elements import SPRING, TORSION_SPRING, load_table
from governor_mechanism.mechanics.dynamics.lowering import BODY, acted_on, body_record
from governor_mechanism.mechanics.dynamics.output_forces import ACT, PULL
from governor_mechanism.mechanics.kinematics.constraint_equations import ends_of, joint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import Rows
from governor_mechanism.mechanics.kinematics.output_rows import gauge_table
from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.mechanics.reduction.node_evaluation import Plan
from governor_mechanism.model.mechanism import LineAngle, Mechanism
from governor_mechanism.model.scene import TURNING, FreeSpindle, Scene, Spindle
from governor_mechanism.types import FloatArray, RecordArray

BOUNDLESS = 1e9
"""Of the coordinate's unit: where the description bounds it nowhere."""


class Acts(NamedTuple):
    """What acts on a motion along the columns of a Plan, whose gauges it counts; few arrays, for each costs time.

    numbers: see TURNS and those after it; springs (n, 4) that are slack where they would push: gauge, rate, free value,
    size; brakes (n, 3): gauge, linear, quadratic; keepers (n, 6): gauge, program of friction or -1, low, high,
    restitution, size. A size is what the reading is relative to.
    """

    numbers: FloatArray
    springs: FloatArray
    brakes: FloatArray
    keepers: FloatArray


TURNS, FREE, SPINDLE_INERTIA, UNEVEN, WAVES, FORCE, PLAIN, PROGRAMS, UNIT, SECOND, ENERGY = range(11)
"""Numbers of Acts: whether the spindle's changing speed loads the bodies; whether it is free, and its own inertia; the
part by which a given speed swings, and how often a turn; the size of forces; whether the first two columns are all that
acts; how many programs loads have; what the coordinate, times
and energies are relative to."""


def curves_of(scene: Scene) -> tuple[TimeCurve, ...]:
    """The programs of a scene: of the spindle's speed, or the torque on it, of loads, and of frictions."""
    spindle, programs = scene.spindle, load_table(scene.part.mechanism, {}, 1)[1]
    first = spindle.torque if isinstance(spindle, FreeSpindle) else spindle.program
    frictions = [keeper.friction for keeper in keepers_of(scene) if keeper.friction is not None]
    return tuple(map(TimeCurve, [first, *programs, *frictions]))


def make_plan(scene: Scene) -> tuple[Plan, Acts]:
    """What there is to sample of a scene of one part, and what acts on it.

    The mechanism's joints must leave it one freedom and drive nothing.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    named = acted_on(scene)
    limits = [limit for limit in mechanism.limits if limit.reading != mechanism.coordinate]
    names = list(dict.fromkeys([*named, *(limit.reading for limit in limits)]))
    gauges = gauge_table(mechanism, [*names, mechanism.coordinate], {})
    joints = joint_table(mechanism).rows
    rows = np.concatenate([joints.table, gauges.table[-1:]])
    loads, programs = load_table(mechanism, {}, 1)
    springs, dampers, driven = _apart(loads)
    low, high = _bounds(mechanism)
    second = time_scale(scene)
    turning = scene.centrifugal and scene.part.plane == TURNING
    given = isinstance(spindle, Spindle) and spindle.program.constant and not spindle.unevenness
    sizes = np.array([_size(mechanism, name) for name in names])
    plan = Plan(
        rows=Rows(rows, ends_of(rows), joints.pieces),
        wraps=isinstance(mechanism.reading(mechanism.coordinate), LineAngle),
        free=np.array([3 * k + c for k, body in enumerate(mechanism.bodies) for c in range(3 if body.turns else 2)]),
        units=np.array([mechanism.size, mechanism.size, 1.0] * len(mechanism.bodies)),
        scales=np.array([*(1 / mechanism.size,) * len(joints.table), 1 / _size(mechanism, mechanism.coordinate)]),
        mass=np.array([m for b in mechanism.bodies for m in (b.mass, b.mass, b.moments.xx + b.moments.yy)]),
        bodies=np.array([body_record(body) for body in mechanism.bodies], dtype=BODY),
        gravity=scene.gravity,
        centrifugal=turning,
        springs=springs,
        dampers=dampers,
        driven=driven,
        programs=np.arange(1, 1 + len(programs)),
        gauges=Rows(gauges.table[:-1], gauges.ends[:-1], gauges.pieces),
        sizes=sizes,
        pulls=_pulls(scene, names),
        limits=np.array([(names.index(one.reading), one.low, one.high) for one in limits]).reshape(-1, 3),
        squared=spindle.speeds[0] ** 2 if given and isinstance(spindle, Spindle) else -1.0,
        unit=_size(mechanism, mechanism.coordinate),
        second=second,
        size=mechanism.size,
        low=low,
        high=high,
        turn=math.tau if mechanism.reading(mechanism.coordinate).quantity == "angle" else 0.0,
        plain=given and not mechanism.loads and not scene.acting,
    )
    return plan, _acts(scene, plan, names)


def _apart(loads: RecordArray) -> tuple[RecordArray, RecordArray, RecordArray]:
    """The loads with a potential, those that damp, and those with a program."""
    if not len(loads):
        return loads, loads, loads
    stores = (loads["kind"] == SPRING) | (loads["kind"] == TORSION_SPRING)
    return loads[stores], loads[~stores & (loads["program"] < 0)], loads[loads["program"] >= 0]


def _bounds(mechanism: Mechanism) -> tuple[float, float]:
    unit = _size(mechanism, mechanism.coordinate)
    own = [limit for limit in mechanism.limits if limit.reading == mechanism.coordinate]
    low = max((limit.low for limit in own), default=-BOUNDLESS * unit)
    return low, min((limit.high for limit in own), default=BOUNDLESS * unit)


def _size(mechanism: Mechanism, name: str) -> float:
    return 1.0 if mechanism.reading(name).quantity == "angle" else mechanism.size


def _pulls(scene: Scene, names: list[str]) -> FloatArray:
    """Springs along readings that pull both ways."""
    found = [(PULL, names.index(one.reading), one.rate, one.free, -1) for one in springs_of(scene) if not one.one_sided]
    return np.array(found, dtype=ACT)


def _acts(scene: Scene, plan: Plan, names: list[str]) -> Acts:
    mechanism, spindle, program = scene.part.mechanism, scene.spindle, 1 + len(plan.programs)
    keepers = []
    for keeper in keepers_of(scene):
        rubs = keeper.friction is not None
        keepers.append((names.index(keeper.reading), program if rubs else -1, keeper.low, keeper.high,
                        keeper.restitution, _size(mechanism, keeper.reading)))  # fmt: skip
        program += rubs
    one_sided = [
        (names.index(one.reading), one.rate, one.free, _size(mechanism, one.reading))
        for one in springs_of(scene)
        if one.one_sided
    ]
    brakes = [(names.index(one.reading), one.linear, one.quadratic) for one in brakes_of(scene)]
    mass = sum(body.mass for body in mechanism.bodies)
    numbers = np.zeros(11)
    numbers[TURNS] = plan.centrifugal
    numbers[FREE] = isinstance(spindle, FreeSpindle)
    numbers[SPINDLE_INERTIA] = spindle.inertia if isinstance(spindle, FreeSpindle) else 0.0
    numbers[UNEVEN] = 0.5 * spindle.unevenness if isinstance(spindle, Spindle) else 0.0
    numbers[WAVES] = spindle.waves if isinstance(spindle, Spindle) else 1.0
    numbers[FORCE] = mass * (mechanism.size / plan.second) ** 2 / plan.unit
    numbers[PLAIN], numbers[PROGRAMS] = plan.plain, len(plan.programs)
    numbers[UNIT], numbers[SECOND] = plan.unit, plan.second
    numbers[ENERGY] = mass * (mechanism.size / plan.second) ** 2
    return Acts(
        numbers=numbers,
        springs=np.array(one_sided).reshape(-1, 4),
        brakes=np.array(brakes).reshape(-1, 3),
        keepers=np.array(keepers).reshape(-1, 6),
    )
