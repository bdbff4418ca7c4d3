"""First configuration of a mechanism in which the joints close, from the angles that are given."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import rotate_point
from governor_mechanism.machines.custom import MechanismSketch, SketchedBody
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.curves import PolarCurve
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    Joint,
    Pin,
    Point,
    Prismatic,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.observables.closed_configurations import ClosedConfigurations, enumerate_configurations
from governor_mechanism.observables.constraint_blocks import angle_driver, count_undetermined, hold_needed_angles
from governor_mechanism.scenes.custom.parser import HIGHEST, NEAREST, CustomMachineParser, choose_configuration
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import format_quantity

N_SEARCHES: Final = 6
"""Number of guesses from which the smallest gap is sought; the search of one takes about 10 ms."""

CLOSED_JOINT_WEIGHT: Final = 1e3
"""Weight of a joint that is to close, relative to one that may open: what it leaves open is less than a thousandth of the gap."""


def explain_unclosed_joint(
    solver: PositionSolver,
    guesses: Sequence[FloatArray],  # guessed poses; shape (bodies, 3) each
    held: Sequence[str],  # names of the bodies that keep the angles of the guesses
    # poses (bodies, 3) in which the joints close at other angles of these bodies; None if there are none
    possible: FloatArray | None,
) -> str:
    """Return a sentence on the joint that stays open where all joints together are nearest to closing."""
    indices = [solver.mechanism.body_index(name) for name in held]
    evenly = [minimise_gaps(solver, guess, indices) for guess in guesses[:N_SEARCHES]]
    nearest = min(evenly, key=lambda poses: _sum_of_squares(solver, poses))
    opened = _last_open_joint(solver, nearest)
    poses = minimise_gaps(solver, nearest, indices, opened)  # with the whole gap at one joint, it is what a length must make up for
    joint, gap = solver.equations.largest_gap(poses)
    ends = [_placed_position(solver, poses, point) for point in (joint.first, joint.second)]
    dx, dy = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
    at_angles = f" at the given angle of {' and '.join(map(repr, held))}" if held else ""
    text = f"the mechanism cannot be assembled{at_angles}: at best joint {joint.name!r} stays open by {abs(gap):.4g} m"
    places = [
        f"its point on {point.body!r} is at [{x:.4g}, {y:.4g}] m" for point, (x, y) in zip((joint.first, joint.second), ends, strict=True)
    ]
    if isinstance(joint, Pin | Weld):
        places[1] += f", {math.degrees(math.atan2(dy, dx)):.1f} deg from there"
    cure = "change a length or a point of the ground"
    if isinstance(joint, Distance):
        cure = f"a length near {math.hypot(dx, dy):.4g} m instead of {joint.length:.4g} m would close it"
    if possible is not None and held:
        angles = [
            f"{name!r} at {math.degrees(math.remainder(possible[k, 2], math.tau)):.3g} deg" for name, k in zip(held, indices, strict=True)
        ]
        cure += f", or begin with {' and '.join(angles)}"
    return f"{text}: {' and '.join(places)}; {cure}"


def minimise_gaps(
    solver: PositionSolver,
    guess: FloatArray,  # poses; shape (bodies, 3)
    held: Sequence[int],
    opened: int | None = None,  # number of the joint that may open; None for any joint
) -> FloatArray:
    """Return the poses near a guess with the least sum of squared gaps; shape (bodies, 3)."""
    from scipy.optimize import least_squares  # slow to import, and few mechanisms need it

    scales, length = solver.free_coordinate_scales, solver.mechanism.length_scale
    is_held = np.zeros((len(solver.mechanism.bodies), 3), dtype=np.bool_)
    is_held[list(held), 2] = True
    columns = np.flatnonzero(~is_held.ravel()[solver.free_mask])
    weights = np.ones(len(solver.equations.joint_indices))
    if opened is not None:
        weights[solver.equations.joint_indices != opened] = CLOSED_JOINT_WEIGHT

    def poses_at(change: FloatArray) -> FloatArray:
        free_change = np.zeros(len(scales))
        free_change[columns] = change
        return guess + solver.expand_free(scales * free_change)

    result = least_squares(
        lambda change: weights * solver.equations.residuals(poses_at(change), 0.0) / length,
        np.zeros(len(columns)),
        jac=lambda change: weights[:, np.newaxis] * solver.scaled_joint_jacobian(poses_at(change))[:, columns],
        max_nfev=200,
    )
    return poses_at(result.x)


def _last_open_joint(solver: PositionSolver, poses: FloatArray) -> int:
    """Return the number of the last joint that is open: the user added it last, to close what was there."""
    gaps = np.abs(solver.equations.residuals(poses, 0.0))
    return int(solver.equations.joint_indices[np.flatnonzero(gaps > 0.1 * np.max(gaps))[-1]])


def _sum_of_squares(solver: PositionSolver, poses: FloatArray) -> float:
    return float(np.sum(solver.equations.residuals(poses, 0.0) ** 2))


def _placed_position(solver: PositionSolver, poses: FloatArray, point: Point) -> tuple[float, float]:
    """Return the position of a point, m, rounded to three decimals of the length scale for the message."""
    x, y, angle = (0.0, 0.0, 0.0) if point.body == GROUND else poses[solver.mechanism.body_index(point.body)].tolist()
    dx, dy = rotate_point(point.x, point.y, angle)
    decimals = 3 - math.floor(math.log10(solver.mechanism.length_scale))
    return round(x + dx, decimals) + 0.0, round(y + dy, decimals) + 0.0


_Pose = tuple[float, float, float]


def chain_bodies(
    sketch: MechanismSketch,
    angles: Mapping[str, float],  # angles of the bodies that rotate, rad
    placed: Collection[str],
    # for each body, its position along a slot or its direction from the centre of an arc or link, from -1 to
    # 1; shape (bodies,)
    offsets: FloatArray,
) -> FloatArray:
    """Return guessed poses of the mass centres (m, rad; shape (bodies, 3)); a loop of joints is open at one of them."""
    scale = sketch.length_scale
    poses: dict[str, _Pose] = {GROUND: (0.0, 0.0, 0.0)}
    offset_of = {body.name: float(offset) for body, offset in zip(sketch.bodies, offsets, strict=True)}
    for body in sketch.bodies:
        if body.name in placed:
            x, y = rotate_point(*body.shape.element.centre, angles.get(body.name, 0.0))
            poses[body.name] = body.origin[0] + x, body.origin[1] + y, angles.get(body.name, 0.0)
    while len(poses) <= len(sketch.bodies):
        joint = _next_joint(sketch, poses)
        if joint is None:  # nothing that is placed holds the others
            name = next(body.name for body in sketch.bodies if body.name not in poses)
            poses[name] = 0.0, 0.0, angles.get(name, 0.0)
            continue
        is_first = joint.first.body in poses
        known, own = (joint.first, joint.second) if is_first else (joint.second, joint.first)
        angle = _angle_of(joint, poses, angles, is_first)
        x, y = _position(poses[known.body], known)
        shift_x, shift_y = _shift(joint, poses[known.body][2] if is_first else angle, offset_of[own.body], scale)
        sign = 1.0 if is_first else -1.0
        point_x, point_y = rotate_point(own.x, own.y, angle)
        poses[own.body] = x + sign * shift_x - point_x, y + sign * shift_y - point_y, angle
    return np.array([poses[body.name] for body in sketch.bodies])


def _next_joint(sketch: MechanismSketch, poses: Mapping[str, _Pose]) -> Joint | None:
    """Return a joint of a placed body and one that is not; joints that leave no choice of the position come first."""
    borders = [joint for joint in sketch.joints if (joint.first.body in poses) != (joint.second.body in poses)]
    located = [joint for joint in borders if isinstance(joint, Pin | Weld | Slider | CurveSlot | ArcSlot | Distance | TranslationalDriver)]
    return min(located, key=lambda joint: not isinstance(joint, Pin | Weld), default=None)


def _angle_of(joint: Joint, poses: Mapping[str, _Pose], angles: Mapping[str, float], is_first: bool) -> float:
    """Return the angle of the body that a joint places: that of the other body if they do not rotate against each other."""
    name, other = (joint.second.body, joint.first.body) if is_first else (joint.first.body, joint.second.body)
    if not isinstance(joint, Weld | Prismatic) or name not in angles:
        return angles.get(name, 0.0)
    return poses[other][2] + (joint.relative_angle if is_first else -joint.relative_angle)


def _position(pose: _Pose, point: Point) -> tuple[float, float]:
    x, y = rotate_point(point.x, point.y, pose[2])
    return pose[0] + x, pose[1] + y


def _shift(joint: Joint, first_angle: float, offset: float, scale: float) -> tuple[float, float]:
    """Return the vector from the first to the second point of a joint, m."""
    if isinstance(joint, Pin | Weld):
        return 0.0, 0.0
    if isinstance(joint, Distance | ArcSlot):
        length = joint.length if isinstance(joint, Distance) else joint.radius
        return rotate_point(length, 0.0, math.pi * (offset - 0.5))
    if isinstance(joint, CurveSlot) and isinstance(joint.curve, PolarCurve):
        return rotate_point(joint.curve.typical_radius, 0.0, math.pi * (offset - 0.5))
    direction = joint.angle if isinstance(joint, Slider | CurveSlot | TranslationalDriver) else 0.0
    return rotate_point(offset * scale, 0.0, first_angle + direction)


N_TRIES: Final = 24
"""Number of guesses: with these, and the slower search, all of 70 random linkages of two and three loops were assembled."""

HEIGHT_TOLERANCE: Final = 1e-6
"""Difference of mean heights, relative to the length scale, below which two configurations are equally high; rounding leaves 1e-13."""

DECIDING_DEVIATION: Final = math.radians(1.0)
"""Deviation of given angles from those of a configuration, rad, below which they mean it: they are rounded, or measured in a drawing."""

KEPT_TOLERANCE: Final = 1e-9
"""Change of a given position (length scales) or angle (rad) below which the document keeps what the user wrote."""

N_DECIMALS: Final = 14
"""Decimals of found positions (m) and angles (rad): a hundred times the rounding of numbers near 1."""


def place_bodies(
    document: Mapping[str, Any],  # keys and tables of a scene file with a custom machine
) -> dict[str, Any]:
    """Return a document in which each body has a position and an angle with which the joints close.

    Given angles are kept in their order, as many as the mechanism has degrees of freedom; further ones tell which configuration is meant.
    Without these, and of several equally near, it is the one whose mass centres lie highest, and then the one
    farthest right. Where the joints leave a motion, the bodies that were added first take an angle near 0.

    Raises MechanismError if the document has mistakes, or no configuration is found; the message names a
    joint that stays open, its gap and direction.
    """
    tables = document.get("body", [])
    collector = ProblemCollector()
    sketch = CustomMachineParser(_without_open_values(document), None, collector).parse_sketch()
    names = [body.name for body in sketch.bodies]
    if collector.problems or len(set(names)) < len(names):
        parse_scene_document(document)  # reports the mistakes of the whole document
        raise MechanismError(*collector.problems)
    if not tables:
        return dict(document)
    given_angles = {body.name: body.angle for body, table in zip(sketch.bodies, tables, strict=False) if "angle" in table}
    placed = {body.name for body in sketch.bodies[len(tables) :]} | {table["name"] for table in tables if "at" in table}
    first = _find_first(sketch, given_angles, placed, document.get("assembly"))
    scale = _length_scale(sketch)
    bodies = [_with_pose(table, body, pose, scale) for body, pose, table in zip(sketch.bodies, first.poses.tolist(), tables, strict=False)]
    return _with_choice({**document, "body": bodies}, first)


def list_assemblies(
    document: Mapping[str, Any],  # keys and tables of a scene file with a custom machine
) -> tuple[ClosedConfigurations, list[str]]:
    """Return all configurations at the given angles, and in words what holds them."""
    sketch = CustomMachineParser(_without_open_values(document), None, ProblemCollector()).parse_sketch()
    tables = document.get("body", [])
    given_angles = {body.name: body.angle for body, table in zip(sketch.bodies, tables, strict=False) if "angle" in table}
    held, bodies = hold_needed_angles(_build(sketch), given_angles.items())
    return enumerate_configurations(PositionSolver(held)), [f"{name} at {format_quantity(given_angles[name], 'rad')}" for name in bodies]


@dataclass(frozen=True, eq=False)
class _First:
    """First configuration: poses (bodies, 3), the bodies whose angles hold it, and what the key `assembly` must be to take it again."""

    poses: FloatArray
    held: tuple[str, ...] = ()
    take: int | str | None = None


def _with_choice(document: dict[str, Any], first: _First) -> dict[str, Any]:
    """Return a document with the key that takes the same assembly again, if several exist and what is given does not decide."""
    plain = {key: value for key, value in document.items() if key != "assembly"}
    if first.take is None:
        return plain
    sketch = CustomMachineParser(plain, None, ProblemCollector()).parse_sketch()
    if count_undetermined(PositionSolver(_build(sketch))):
        return {**plain, "assembly": {"take": first.take, "at": list(first.held)}}
    return {**plain, "assembly": first.take}


def _with_pose(table: dict[str, Any], body: SketchedBody, pose: Sequence[float], scale: float) -> dict[str, Any]:
    """Return the table of a body with the pose of its axes; what is given stays as it is written where it is that of the pose."""
    centre_x, centre_y = rotate_point(*body.shape.element.centre, pose[2])
    x = pose[0] - centre_x
    y = pose[1] - centre_y
    angle = pose[2]
    keeps_position = "at" in table and math.dist((x, y), body.origin) < KEPT_TOLERANCE * scale
    keeps_angle = not body.can_rotate or ("angle" in table and abs(angle - body.angle) < KEPT_TOLERANCE)
    position = {} if keeps_position else {"at": [round(x, N_DECIMALS) + 0.0, round(y, N_DECIMALS) + 0.0]}
    return table | position | ({} if keeps_angle else {"angle": round(math.remainder(angle, math.tau), N_DECIMALS) + 0.0})


def _without_open_values(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document without the joints and links that take a value from the first configuration, which they do not determine."""
    angles = {table["name"]: table.get("angle") for table in document.get("body", ())}
    joints = [_with_turn(joint, angles) for joint in document.get("joint", ()) if not _takes_value(joint)]
    links = [link for link in document.get("link", ()) if "length" in link]
    return {**document, "joint": joints, "link": links}


def _takes_value(joint: Mapping[str, Any]) -> bool:
    """Return whether a gear, rack or driver begins where the first configuration is."""
    motion = joint.get("motion")
    begins_anywhere = motion is None or (isinstance(motion, Mapping) and "start" not in motion)
    is_driver = joint["type"] in ("driven_turn", "driven_slide")
    return (is_driver and begins_anywhere and "start" not in joint) or (joint["type"] in ("gear", "rack") and "offset" not in joint)


def _with_turn(joint: dict[str, Any], angles: Mapping[str, Any]) -> dict[str, Any]:
    """Return a weld or prismatic joint with a relative angle: 0, unless the angles of its bodies are given."""
    if joint["type"] not in ("weld", "prismatic") or "turn" in joint:
        return joint
    bodies = [end.partition(".")[0] if isinstance(end, str) else end[0] for end in (joint["first"], joint["second"])]
    are_given = all(angles.get(body) is not None for body in bodies if body in angles)
    return joint if are_given else {**joint, "turn": 0.0}


@dataclass(frozen=True, eq=False)
class _Configuration:
    """Closed poses (bodies, 3), degrees of freedom beside the given angles, and the sums of the heights and of x of the mass centres, m."""

    poses: FloatArray
    mobility: int
    height: float
    reach: float


def _length_scale(sketch: MechanismSketch) -> float:
    return sketch.length_scale or 1.0


def _build(sketch: MechanismSketch) -> Mechanism:
    return sketch.build([], "", _length_scale(sketch))


def _find_first(sketch: MechanismSketch, given_angles: Mapping[str, float], placed: set[str], take: int | str | None) -> _First:
    """Return the first configuration: the chosen assembly, or the one nearest to the given angles, or the highest."""
    guesses = list(_make_guesses(sketch, given_angles, placed))
    is_drawn = len(guesses) == 1 and take is None
    if not is_drawn:
        held, names = hold_needed_angles(_build(sketch), given_angles.items())
        if configurations := _enumerate(PositionSolver(held)):
            return _choose_first(sketch, configurations, names, given_angles, take)
    poses, angles = _find_poses(sketch, given_angles, placed, guesses)
    if is_drawn or not (configurations := _enumerate(_hold_angles(sketch, angles))):
        return _First(poses)
    return _choose_first(sketch, configurations, list(angles), given_angles, take)


def _enumerate(solver: PositionSolver) -> ClosedConfigurations | None:
    """Return all configurations; None if there are none, or a motion is left."""
    with suppress(MechanismError):
        configurations = enumerate_configurations(solver)
        return configurations if len(configurations.poses) else None
    return None


def _choose_first(
    sketch: MechanismSketch,
    configurations: ClosedConfigurations,
    held: list[str],
    given_angles: Mapping[str, float],
    take: int | str | None,
) -> _First:
    """Return the configuration that is taken of all at some held angles; further given angles choose the one nearest to them."""
    names = [sketch.bodies[k].name for k in configurations.closing]
    further = {name: angle for name, angle in given_angles.items() if name in names and name not in held}
    if take is None and further:
        deviations = [_largest_deviation(sketch, poses, further) for poses in configurations.poses]
        is_decided = sum(deviation < DECIDING_DEVIATION for deviation in deviations) == 1
        squares = [_sum_of_squared_deviations(sketch, poses, further) for poses in configurations.poses]
        index = configurations.find_highest(k for k, square in enumerate(squares) if square < min(squares) + DECIDING_DEVIATION**2)
        chosen: int | str | None = None if is_decided else NEAREST
    else:
        chosen = take or HIGHEST
        index = choose_configuration(configurations, take or HIGHEST, configurations.solver.initial_guess)
    is_only = take is None and len(configurations.poses) == 1
    return _First(configurations.poses[index], tuple(held), None if is_only else chosen)


def _find_poses(
    sketch: MechanismSketch, given_angles: Mapping[str, float], placed: set[str], guesses: list[FloatArray]
) -> tuple[FloatArray, dict[str, float]]:
    """Return poses (bodies, 3) in which the joints close, and the angles (rad) that hold them, given ones first."""
    scale = _length_scale(sketch)
    if found := _search(sketch, given_angles, guesses):
        chosen = _choose(found, scale)
        free_names = [body.name for body in sketch.bodies if body.can_rotate and body.name not in given_angles]
        held = _find_independent(sketch, free_names, given_angles, chosen) if len(guesses) > 1 else {}
        held |= given_angles
        if len(held) == len(given_angles):
            return chosen.poses, held
        return _choose(_close_all(_hold_angles(sketch, held), [chosen.poses, *_make_guesses(sketch, held, placed)]), scale).poses, held

    def distance(one: _Configuration) -> float:
        return _sum_of_squared_deviations(sketch, one.poses, given_angles)

    starts = [*_close_at_best(sketch, given_angles, guesses), *guesses]
    near = min(_search(sketch, {}, starts), key=distance, default=None)
    held_names = list[str]()
    if near is not None:
        held_names = list(_find_independent(sketch, given_angles, {}, near))
    is_overdetermined = near is not None and len(held_names) < len(given_angles)
    held = {name: given_angles[name] for name in held_names}
    if is_overdetermined and (found := _search(sketch, held, starts)):
        return min(found, key=distance).poses, held
    raise MechanismError(explain_unclosed_joint(_hold_angles(sketch, {}), guesses, held_names, None if near is None else near.poses))


def _hold_angles(sketch: MechanismSketch, angles: Mapping[str, float]) -> PositionSolver:
    """Return a solver of the mechanism whose bodies have these angles, rad, as if they were driven."""
    drivers = [angle_driver(name, angle) for name, angle in angles.items()]
    return PositionSolver(_build(replace(sketch, joints=[*sketch.joints, *drivers])))


def _find_independent(sketch: MechanismSketch, names: Iterable[str], fixed: Mapping[str, float], found: _Configuration) -> dict[str, float]:
    """Return the angles (rad) of the first of some bodies that are independent, as many as a configuration leaves beside fixed angles."""
    held: dict[str, float] = {}
    angles = {body.name: float(pose[2]) for body, pose in zip(sketch.bodies, found.poses, strict=True)}
    mobility = _hold_angles(sketch, fixed).count_degrees_of_freedom(found.poses)
    for name in names:
        if mobility:
            trial = {**held, name: angles[name]}
            if (remaining := _hold_angles(sketch, {**fixed, **trial}).count_degrees_of_freedom(found.poses)) < mobility:
                held, mobility = trial, remaining
    return held


def _sum_of_squared_deviations(sketch: MechanismSketch, poses: FloatArray, angles: Mapping[str, float]) -> float:
    """Return the sum of the squared deviations of poses (bodies, 3) from angles, rad2."""
    found = {body.name: float(pose[2]) for body, pose in zip(sketch.bodies, poses, strict=True)}
    return sum(math.remainder(found[name] - angle, math.tau) ** 2 for name, angle in angles.items())


def _largest_deviation(sketch: MechanismSketch, poses: FloatArray, angles: Mapping[str, float]) -> float:
    """Return the largest deviation of poses (bodies, 3) from angles, rad."""
    found = {body.name: float(pose[2]) for body, pose in zip(sketch.bodies, poses, strict=True)}
    return max(abs(math.remainder(found[name] - angle, math.tau)) for name, angle in angles.items())


def _make_guesses(sketch: MechanismSketch, given_angles: Mapping[str, float], placed: set[str]) -> Iterator[FloatArray]:
    """Yield guesses: bodies put together from the ground, with free angles of 0 at first and then with varied ones."""
    free = [body.name for body in sketch.bodies if body.can_rotate and body.name not in given_angles]
    generator = np.random.default_rng(0)  # the same guesses each time
    is_drawn = not free and all(body.name in placed for body in sketch.bodies)
    for k in range(1 if is_drawn else N_TRIES):
        steps = generator.integers(12, size=len(free)) if k else np.zeros(len(free))
        angles = dict(given_angles) | {name: math.radians(30.0) * float(step) for name, step in zip(free, steps, strict=True)}
        offsets = generator.uniform(-1.0, 1.0, size=len(sketch.bodies)) if k else np.full(len(sketch.bodies), 0.5)
        yield chain_bodies(sketch, angles, placed, offsets)


def _close_at_best(sketch: MechanismSketch, angles: Mapping[str, float], guesses: Sequence[FloatArray]) -> list[FloatArray]:
    """Return poses in which bodies have their angles and the gaps are least: the closest configuration is near them."""
    solver = _hold_angles(sketch, {})
    held = [solver.mechanism.body_index(name) for name in angles]
    return [minimise_gaps(solver, guess, held) for guess in guesses[:N_SEARCHES]]


def _search(sketch: MechanismSketch, angles: Mapping[str, float], guesses: Sequence[FloatArray]) -> list[_Configuration]:
    """Return the configurations nearest to guesses in which bodies have their angles; if none closes at once, after a slower search."""
    solver = _hold_angles(sketch, angles)
    if found := _close_all(solver, guesses):
        return found
    return _close_all(solver, _close_at_best(sketch, angles, guesses))


def _close_all(solver: PositionSolver, guesses: Iterable[FloatArray]) -> list[_Configuration]:
    """Return the configurations nearest to guesses, of those that close."""
    found = []
    for guess in guesses:
        with suppress(MechanismError):
            poses = solver.solve({}, guess)
            mobility = solver.count_degrees_of_freedom(poses)
            found.append(_Configuration(poses, mobility, float(np.sum(poses[:, 1])), float(np.sum(poses[:, 0]))))
    return found


def _choose(found: list[_Configuration], scale: float) -> _Configuration:
    """Return the configuration that `place_bodies` describes; one that is singular has more freedom, and is the last choice."""
    mobility = min(one.mobility for one in found)
    regular = [one for one in found if one.mobility == mobility]
    if mobility:
        return regular[0]
    highest = max(one.height for one in regular)
    return max((one for one in regular if one.height > highest - HEIGHT_TOLERANCE * scale), key=lambda one: one.reach)
