"""A scene as arrays for the compiled kernels: bodies, rows, loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.constraint_solver import narrow_order, neighbours
from governor_mechanism.mechanics.dynamics.contacts import Mode, brakes_of, first_mode, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.force_elements import load_table
from governor_mechanism.mechanics.dynamics.output_forces import ACT, BRAKE, FORCE, PULL, RATE, RUB, VALUE, WATCH
from governor_mechanism.mechanics.kinematics.constraint_equations import ends_of, joint_table
from governor_mechanism.mechanics.kinematics.constraint_kernels import Rows
from governor_mechanism.mechanics.kinematics.output_rows import CONSTANT, gauge_table, held_at
from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.scene import TURNING, FreeSpindle, Scene, Spindle
from governor_mechanism.model.time_functions import Motion, Program
from governor_mechanism.types import FloatArray, IntArray, RecordArray

BODY = np.dtype([(name, "f8") for name in ("mass", "x", "y", "xx", "yy", "xy", "zz")])
"""One body: mass; where the mass centre is from the origin, in body axes; second moments about the mass centre."""


ROUNDING = 1e-12
"""Of a size, a speed or a force: less is rounding."""


class System(NamedTuple):
    """Rows, loads and pairs as in `rows`, `applied` and `schur`; bodies (bodies,) of BODY, inverse_mass (bodies, 3).

    Coordinates are counted from a body's origin, its mass centre but for a lever. A free spindle has spindle_inertia
    (kg m2) of its own. The last rows hold readings that stick or rest; gauges, acts and watch as in `acting`; a given
    speed swings by `uneven` of itself, `waves` times a turn.
    """

    rows: Rows
    loads: RecordArray
    pairs: IntArray
    width: int
    bodies: RecordArray
    inverse_mass: FloatArray
    gravity: float
    centrifugal: bool
    free: bool
    spindle_inertia: float
    gauges: Rows
    acts: RecordArray
    watch: RecordArray
    uneven: float
    waves: float


class Workspace(NamedTuple):
    """Room for one evaluation, so that none is allocated in the loop."""

    line: FloatArray
    gradient: FloatArray
    band: FloatArray
    factor: FloatArray
    vector: FloatArray
    load: FloatArray
    seen: FloatArray
    leaning: FloatArray


def make_system(scene: Scene, mode: Mode | None = None) -> tuple[System, tuple[TimeCurve, ...]]:
    """The arrays of a scene of one part, and its programs: the spindle's speed or torque, the drives', the loads'.

    mode says what sticks, rests and pulls; left out, nothing does. Raises MechanismError for a body that has no inertia
    of its own to turn.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    mode = first_mode(scene) if mode is None else mode
    origins = {body.name: lever_origin(mechanism, body) for body in mechanism.bodies}
    table = joint_table(mechanism, origins)
    gauges = gauge_table(mechanism, acted_on(scene), origins)
    holding = _holding(scene, mode, gauges)
    order = _order(table.rows, holding)
    every = np.concatenate([table.rows.table, holding])[order]
    rows = Rows(every, ends_of(every), table.rows.pieces)
    rows.table["drive"] += rows.table["drive"] >= 0  # program 0 is the spindle's
    pairs = neighbours(rows.ends)
    loads, programs = load_table(mechanism, origins, 1 + len(table.motions))
    frictions = [keeper.friction for keeper in keepers_of(scene) if keeper.friction is not None]
    first_friction = 1 + len(table.motions) + len(programs)
    inertia = [_inertia(body, origins[body.name]) for body in mechanism.bodies]
    inverse = [
        [1 / body.mass, 1 / body.mass, 1 / moment if body.turns else 0.0]
        for body, moment in zip(mechanism.bodies, inertia, strict=True)
    ]
    free = spindle if isinstance(spindle, FreeSpindle) else None
    system = System(
        rows=rows,
        loads=loads,
        pairs=pairs,
        width=int(np.max(pairs[:, 0] - pairs[:, 1], initial=0)),
        bodies=np.array([body_record(body, origins[body.name]) for body in mechanism.bodies], dtype=BODY),
        inverse_mass=np.array(inverse),
        gravity=scene.gravity,
        centrifugal=scene.centrifugal and scene.part.plane == TURNING,
        free=free is not None,
        spindle_inertia=free.inertia if free else 0.0,
        gauges=gauges,
        acts=_acts(scene, mode, first_friction),
        watch=_watch(scene, mode, first_friction, np.argsort(order)[len(table.owner) :]),
        uneven=0.5 * spindle.unevenness if isinstance(spindle, Spindle) else 0.0,
        waves=spindle.waves if isinstance(spindle, Spindle) else 1.0,
    )
    timed: list[Program | Motion] = [spindle.torque if isinstance(spindle, FreeSpindle) else spindle.program]
    timed += [*table.motions, *programs, *frictions]
    return system, tuple(map(TimeCurve, timed))


def acted_on(scene: Scene) -> list[str]:
    """The readings along which something acts, in the order of a system's gauges."""
    return list(dict.fromkeys(effect.reading for effect in scene.acting))


def acts_of(system: System) -> IntArray:
    """(3,) how many loads along readings there are of each kind: springs, brakes, frictions that slide."""
    return np.bincount(system.acts["kind"], minlength=3)


def rows_in_order(scene: Scene, mode: Mode | None = None) -> IntArray:
    """(rows,) where each row of a system stands among the joints' rows as `joint_table` lists them, then those held."""
    mechanism = scene.part.mechanism
    gauges = gauge_table(mechanism, acted_on(scene), {})
    return _order(joint_table(mechanism).rows, _holding(scene, mode or first_mode(scene), gauges))


def _order(rows: Rows, holding: RecordArray) -> IntArray:
    return narrow_order(np.concatenate([rows.ends, ends_of(holding)]))


def _holding(scene: Scene, mode: Mode, gauges: Rows) -> RecordArray:
    """The rows of what sticks or rests."""
    names = acted_on(scene)
    held = [
        (names.index(keeper.reading), value)
        for keeper, value in zip(keepers_of(scene), mode.held, strict=True)
        if value is not None
    ]
    return held_at(gauges.table, [at for at, _ in held], [value for _, value in held])


def _acts(scene: Scene, mode: Mode, program: int) -> RecordArray:
    """The loads along gauges; the program of the first friction is given."""
    names, taut, found = acted_on(scene), iter(mode.taut), []
    for spring in springs_of(scene):
        if not spring.one_sided or next(taut):
            found.append((PULL, names.index(spring.reading), spring.rate, spring.free, -1))
    for brake in brakes_of(scene):
        found.append((BRAKE, names.index(brake.reading), brake.linear, brake.quadratic, -1))
    for keeper, sign in zip(keepers_of(scene), mode.sliding, strict=True):
        if sign:
            found.append((RUB, names.index(keeper.reading), float(sign), 0.0, program))
        program += keeper.friction is not None
    return np.array(found, dtype=ACT)


def _watch(scene: Scene, mode: Mode, program: int, held_rows: IntArray) -> RecordArray:
    """What has to be watched in a mode; `about` counts keepers, then one-sided springs."""
    names, rows, found = acted_on(scene), iter(held_rows.tolist()), []
    scales = _Scales(scene)
    keepers = keepers_of(scene)
    for about, (keeper, held, sign) in enumerate(zip(keepers, mode.held, mode.sliding, strict=True)):
        gauge = names.index(keeper.reading)
        rubs = program if keeper.friction is not None else -1
        program += keeper.friction is not None
        if held is not None:
            row = next(rows)
            # A stop pushes off its own side without bound; friction holds either way.
            bounds = ((1.0, held <= keeper.low), (-1.0, held >= keeper.high))
            found += [(FORCE, row, way, 0.0, scales.force, rubs, about) for way, unbounded in bounds if not unbounded]
            continue
        if mode.still:
            continue
        if sign:
            found.append((RATE, gauge, -float(sign), 0.0, scales.rate(keeper.reading), -1, about))
        for way, end in ((1.0, keeper.high), (-1.0, -keeper.low)):
            if np.isfinite(end):
                found.append((VALUE, gauge, way, end, scales.value(keeper.reading), -1, about))
    one_sided = [] if mode.still else [spring for spring in springs_of(scene) if spring.one_sided]
    for about, (spring, taut) in enumerate(zip(one_sided, mode.taut, strict=False), start=len(keepers)):
        way, gauge = (-1.0 if taut else 1.0), names.index(spring.reading)
        found.append((VALUE, gauge, way, way * spring.free, scales.value(spring.reading), -1, about))
    return np.array(found, dtype=WATCH)


def moved_hold(system: System, gauges: Sequence[int], mode: Mode) -> System:
    """The system of a mode that holds the same readings as this one's, but at values of its own.

    gauges are those of the keepers. A value is set anew, not moved on from the last, so that rounding does not add up.
    """
    table = system.rows.table.copy()
    for k, value in enumerate(mode.held):
        if value is not None:
            holds = (system.watch["kind"] == FORCE) & (system.watch["about"] == k)
            row, gauge = int(system.watch["at"][holds][0]), system.gauges.table[gauges[k]]
            constant = CONSTANT[int(gauge["kind"])]
            table[row][constant] = gauge[constant] + value
    return system._replace(rows=system.rows._replace(table=table))


class _Scales:
    """What is rounding in readings, their rates, and forces along them."""

    def __init__(self, scene: Scene) -> None:
        self._mechanism = scene.part.mechanism
        self._second = time_scale(scene)
        mass = sum(body.mass for body in self._mechanism.bodies)
        self.force = ROUNDING * mass * self._mechanism.size / self._second**2

    def value(self, name: str) -> float:
        length = self._mechanism.reading(name).quantity == "length"
        return ROUNDING * (self._mechanism.size if length else 1.0)

    def rate(self, name: str) -> float:
        return self.value(name) / self._second


def make_workspace(system: System) -> Workspace:
    """Room for evaluations of this system."""
    rows, bodies = len(system.rows.table), len(system.bodies)
    band = (rows, system.width + 1)
    return Workspace(
        line=np.zeros((rows, 5)),
        gradient=np.zeros((rows, 2, 3)),
        band=np.zeros(band),
        factor=np.zeros(band),
        vector=np.zeros(rows),
        load=np.zeros((bodies, 3)),
        seen=np.zeros((len(system.gauges.table), 5)),
        leaning=np.zeros((len(system.gauges.table), 2, 3)),
    )


def to_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and velocities (..., bodies, 3) of mass centres from those of the origins."""
    return _moved(_centre(system), poses, velocities)


def from_centres(system: System, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and velocities (..., bodies, 3) of the origins from those of mass centres."""
    return _moved(-_centre(system), poses, velocities)


def _moved(by: FloatArray, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    poses, velocities = poses.copy(), velocities.copy()
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    arm_x, arm_y = cosine * by[:, 0] - sine * by[:, 1], sine * by[:, 0] + cosine * by[:, 1]
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def lever_origin(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """From where a body's coordinates are counted, in its own axes (m): the pin of a lever, else the mass centre."""
    pin = lever_pin(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own = pin.first if pin.first.body == body.name else pin.second
    return own.x, own.y


def lever_pin(mechanism: Mechanism, body: Body) -> Pin | None:
    """The pin of a lever; None for other bodies. Raises MechanismError for a body that has no inertia to turn with.

    A lever is a body whose mass is in one point and that a pin holds to the ground: about that pin it has inertia. The
    pin stands still, so the mass's coupling between turning and moving never acts on the motion.
    """
    if not body.turns or body.moments.xx + body.moments.yy > 0:
        return None
    for joint in mechanism.joints:
        ends = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(ends) == {GROUND, body.name}:
            own = ends[body.name]
            if own.x != 0.0 or own.y != 0.0:
                return joint
    raise MechanismError(
        f"body {body.name!r} cannot turn: its mass is in one point, and no pin beside that point joins it to ground; "
        "give it second moments, or turns=False"
    )


def _centre(system: System) -> FloatArray:
    """(bodies, 2) m: where mass centres are from the origins, in body axes."""
    return np.stack([system.bodies["x"], system.bodies["y"]], axis=-1)


def body_record(body: Body, origin: tuple[float, float] = (0.0, 0.0)) -> tuple[float, ...]:
    """A body as a record of BODY, its coordinates counted from an origin (body axes, m)."""
    moments = body.moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz)


def _inertia(body: Body, origin: tuple[float, float]) -> float:
    return body.moments.xx + body.moments.yy + body.mass * (origin[0] ** 2 + origin[1] ** 2)
