"""Motion of a valve and of the piston over a turn of the crank, and its timing; other drivers stand still where they start."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.continuation import PathInterpolant, build_path
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.kinematic_analysis import hold_driver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_reading_motions
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import RotationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import EQUAL_LEADS, MIDDLE, Valve
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.numerics.roots import find_root, find_roots
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

CRANK_COORDINATE = "angle of the crank"
"""Name of the internal output variable that is the leading coordinate: the angle of the crank against the body that bears it."""

N_NODES = 72
"""Number of intervals of a turn between which readings are interpolated; the error is about 1e-11 of the valve travel."""

ANGLE_TOLERANCE = 1e-13
"""Tolerance of the crank angle of a dead centre or an event, rad; rounding is about 1e-15."""

REPETITION_TOLERANCE = 1e-6
"""Largest change of a pose over a turn besides whole turns, in length scales and rad; what does not repeat differs by far more."""


class ValveKinematics(NamedTuple):
    """Readings and their first two derivatives (n,) with respect to the crank angle, by name, SI and rad."""

    readings: Mapping[str, FloatArray]
    derivatives: Mapping[str, FloatArray]
    second_derivatives: Mapping[str, FloatArray]


def has_valve_events(scene: Scene) -> bool:
    """Return whether a scene has one part, whose mechanism has a valve and a driver that turns a body: a free crank has no events."""
    if len(scene.parts) > 1 or scene.part.mechanism.valve is None:
        return False
    return any(isinstance(joint, RotationalDriver) for joint in scene.part.mechanism.joints)


def valve_of(scene: Scene) -> Valve:
    """Return the valve of a scene; raise MechanismError if the mechanism has no valve."""
    valve = scene.part.mechanism.valve
    if valve is None:
        raise MechanismError(
            f"valve timing needs a mechanism with a slide valve; machine {scene.part.machine!r} of this scene has none. "
            "A custom machine gets one from a table [valve] with reading and steam_lap"
        )
    return valve


def crank_driver_of(mechanism: Mechanism, valve: Valve) -> RotationalDriver:
    """Return the driver of the crank."""
    drivers = [joint for joint in mechanism.joints if isinstance(joint, RotationalDriver)]
    names = [driver.name for driver in drivers]
    if valve.crank and valve.crank not in names:
        raise MechanismError(f"the valve names {valve.crank!r} as the driver of the crank; drivers that turn a body are {names}")
    found = [driver for driver in drivers if driver.name == valve.crank or not valve.crank]
    if not found:
        raise MechanismError("the crank is not driven: valve events need a driver that turns it")
    if len(found) > 1:
        raise MechanismError(f"several drivers turn bodies, {', '.join(map(repr, names))}; name the one of the crank in the valve")
    return found[0]


class ValveMotion:
    """Kinematics of a mechanism with a valve, over the crank angle in the direction of rotation from the crank end's dead centre.

    Without a piston the crank angle counts from where the angle of the crank is zero, and half a turn lies between the dead centres.

    Parameters
    ----------
    scene
        Scene of one part whose mechanism has a valve.

    Attributes
    ----------
    valve
        The valve.
    dead_centres
        Crank angles of the dead centres of the crank end, which is 0, and of the head end, rad.
    centre
        Position of the valve in the centre of its motion, m.
    stroke
        Stroke of the piston, m; 0 without a piston.

    Raises
    ------
    MechanismError
        If the scene has no valve, if no driven crank determines its position, or if the crank cannot turn fully.
    """

    def __init__(self, scene: Scene) -> None:
        self.valve = valve_of(scene)
        self._mechanism, self._direction = _free_crank(scene, self.valve)
        self._solver = CoordinateSolver(self._mechanism)
        if self._solver.mobility != 1:
            found = f"degrees of freedom besides that of the crank: {self._solver.mobility - 1}"
            raise MechanismError(f"valve events need a crank whose angle determines the position of the whole mechanism; {found}")
        self._path, self._pose_increment = _follow_turn(self._mechanism, self._solver)
        self._origin, self.dead_centres = 0.0, (0.0, math.pi)
        if self.valve.piston_travel:
            crank_end, head_end = self._find_extremes(self.valve.piston_travel)
            self._origin = math.remainder(self._origin + self._direction * crank_end, math.tau)
            self.dead_centres = (0.0, (head_end - crank_end) % math.tau)
            del self.turn  # from this origin it is interpolated again, where it is needed
        self.centre, self._crank_end_position, self.stroke = self._find_centre(), *self._find_stroke()

    def evaluate(
        self,
        angles: FloatArray,  # crank angles, rad; shape (n,)
    ) -> ValveKinematics:
        """Return the readings and their derivatives at crank angles, with the mechanism assembled at all of them at once."""
        values = self._origin + self._direction * angles
        turns = np.floor((values - self._path.values[0]) / math.tau)
        guesses = self._path.predict_poses(values - math.tau * turns) + np.multiply.outer(turns, self._pose_increment)
        poses, tangents, curvatures = self._solver.solve_nodes(guesses, values).swapaxes(0, 1)
        tangents = self._direction * tangents
        motions = evaluate_reading_motions(self._mechanism, poses, tangents, curvatures)
        return ValveKinematics(*({name: motion[order] for name, motion in motions.items()} for order in range(3)))

    def displacements(self, angles: FloatArray) -> FloatArray:
        """Return the displacements of the valve from the centre of its motion at crank angles (n,), interpolated, m."""
        positions: FloatArray = self.turn[self.valve.displacement](angles)
        return positions - self.centre

    def stroke_fractions(self, angles: FloatArray) -> FloatArray:
        """Return the travels of the piston from the crank end at crank angles (n,), as fractions of the stroke; nan without a piston."""
        if not self.valve.piston_travel or not len(angles):
            return np.full(len(angles), math.nan)
        return (self.evaluate(angles).readings[self.valve.piston_travel] - self._crank_end_position) / self.stroke

    @property
    def crank_end_angle(self) -> float:
        """Angle of the crank against the body that bears it, at the dead centre of the crank end, rad."""
        return self._origin

    @property
    def leads(self) -> tuple[float, float]:
        """Openings of the steam ports of crank end and head end at their dead centres, m."""
        positions = self.evaluate(np.array(self.dead_centres)).readings[self.valve.displacement]
        crank_end, head_end = (self.valve.outward_sign * (positions - self.centre)).tolist()
        return crank_end - self.valve.steam_lap, -head_end - self.valve.steam_lap

    @property
    def travel(self) -> float:
        """Travel of the valve from one extreme to the other, m."""
        position = self.turn[self.valve.displacement]
        return float(np.ptp(position(find_turning_angles(position))))

    @cached_property
    def turn(self) -> "dict[str, BPoly]":
        """Piecewise polynomials of the fifth degree of the crank angle by reading, exact at `N_NODES` equal angles, and periodic."""
        nodes = np.linspace(0.0, math.tau, N_NODES + 1)
        motions = self.evaluate(nodes)
        return {name: _interpolate_periodic(nodes, *(motion[name] for motion in motions)) for name in motions.readings}

    def _find_extremes(self, reading: str) -> tuple[float, float]:
        """Return the crank angles (rad) at which a reading with one minimum and one maximum in a turn is at these."""
        nodes, values = self.turn[reading].x, self.turn[reading](self.turn[reading].x)
        middle = nodes[[np.argmin(values), np.argmax(values)]]

        def slopes(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
            motion = self.evaluate(angles)
            return motion.derivatives[reading], motion.second_derivatives[reading]

        lowest, highest = find_roots(slopes, middle - nodes[1], middle + nodes[1], ANGLE_TOLERANCE)
        return float(lowest), float(highest)

    def _find_centre(self) -> float:
        """Return the position of the valve in the centre of its motion, m."""
        rule, reading = self.valve.centre, self.valve.displacement
        if not isinstance(rule, str):
            return rule
        angles = {EQUAL_LEADS: self.dead_centres, MIDDLE: self._find_extremes(reading)}[rule]
        return float(np.mean(self.evaluate(np.array(angles)).readings[reading]))

    def _find_stroke(self) -> tuple[float, float]:
        """Return the position of the piston at the crank end, and its stroke, m."""
        if not self.valve.piston_travel:
            return 0.0, 0.0
        crank_end, head_end = self.evaluate(np.array(self.dead_centres)).readings[self.valve.piston_travel].tolist()
        return crank_end, self.valve.stroke or head_end - crank_end


@once_per_object
def valve_motion_of(scene: Scene) -> ValveMotion:
    """Return the motion of a scene's valve over a turn of the crank."""
    return ValveMotion(scene)


def reverse_crank(scene: Scene) -> Scene:
    """Return a scene whose crank turns the other way from where it starts."""
    mechanism = scene.part.mechanism
    crank = crank_driver_of(mechanism, valve_of(scene))
    start = float(CubicTimeFunction(crank.motion)(np.zeros(1))[0])
    harmonics = tuple(replace(one, amplitude=-one.amplitude) for one in crank.motion.harmonics)
    motion = replace(crank.motion, values=tuple(2 * start - value for value in crank.motion.values), harmonics=harmonics)
    joints = tuple(replace(crank, motion=motion) if joint is crank else joint for joint in mechanism.joints)
    return scene.with_changes(mechanism=replace(mechanism, joints=joints))


def find_turning_angles(
    position: "BPoly",  # the reading as a periodic function of the crank angle
) -> FloatArray:
    """Return the ascending crank angles (n,), rad, of the extremes of a reading over a turn; the last is the first of the next turn."""
    from scipy.interpolate import PPoly  # slow to import

    roots = PPoly.from_bernstein_basis(position.derivative()).roots(extrapolate=False)
    angles = np.unique(roots[np.isfinite(roots)] % math.tau)
    first = angles[:1] if len(angles) else np.zeros(1)  # without extremes the valve is at rest
    return np.concatenate([angles if len(angles) else first, first + math.tau])


def _free_crank(scene: Scene, valve: Valve) -> tuple[Mechanism, float]:
    """Return the mechanism without the driver of its crank, whose angle is the coordinate, and the sign of the crank's rotation."""
    # Its initial guess is the configuration at 0 s; other drivers stand still there.
    driven = scene.part.mechanism
    crank = crank_driver_of(driven, valve)
    start_values = {name: float(value) for name, value in scene.part.start.values.items() if isinstance(value, float | int)}
    poses = PositionSolver(driven).solve(start_values)
    angle = BodyAngle(name=CRANK_COORDINATE, quantity="angle", body=crank.second.body, reference_body=crank.first.body)
    rate = float(CubicTimeFunction(crank.motion).derivative(np.zeros(1))[0])
    free = replace(
        driven,
        joints=tuple(hold_driver(joint) for joint in driven.joints if joint is not crank),
        coordinate=CRANK_COORDINATE,
        internal_outputs=(*driven.internal_outputs, angle),
        initial_guess=tuple((x, y, turn) for x, y, turn in poses.tolist()),
    )
    return free, math.copysign(1.0, rate)


def _follow_turn(mechanism: Mechanism, solver: CoordinateSolver) -> tuple[PathInterpolant, FloatArray]:
    """Return the path over a turn of the crank from its start, and the change of the poses (bodies, 3) in it: whole turns of bodies."""
    start = solver.initial_coordinate
    try:
        path = build_path(mechanism, start, start + math.tau)
    except MechanismError as error:
        raise MechanismError(f"valve events need a crank that turns fully: {error}") from error
    increment = path.poses[-1] - path.poses[0]
    whole_turns = np.zeros_like(increment)
    whole_turns[:, 2] = math.tau * np.round(increment[:, 2] / math.tau)
    if np.max(np.abs(increment - whole_turns) / solver.pose_scales) > REPETITION_TOLERANCE:
        raise MechanismError(
            "valve events need a motion that repeats in every turn of the crank; after a turn of this one bodies are elsewhere"
        )
    nodes = start + np.linspace(0.0, math.tau, N_NODES + 1)
    poses, tangents, _ = solver.solve_nodes(path.predict_poses(nodes), nodes).swapaxes(0, 1)
    return PathInterpolant(nodes, nodes, np.ones_like(nodes), poses, tangents), whole_turns


def _interpolate_periodic(nodes: FloatArray, values: FloatArray, slopes: FloatArray, curvatures: FloatArray) -> "BPoly":
    """Return polynomials of the fifth degree with values and two derivatives (n,) at equal nodes (n,), in the Bernstein basis."""
    from scipy.interpolate import BPoly  # slow to import

    h = nodes[1] - nodes[0]
    first, last = slice(None, -1), slice(1, None)
    ends = ((values[side], sign * h * slopes[side] / 5, h**2 * curvatures[side] / 20) for side, sign in ((first, 1.0), (last, -1.0)))
    rising, falling = ([value, value + slope, value + 2 * slope + curvature] for value, slope, curvature in ends)
    return BPoly(np.array([*rising, *falling[::-1]]), nodes, extrapolate="periodic")


CYLINDER_ENDS = ("crank end", "head end")

PORT_EVENTS = {"steam": ("admission", "cut-off"), "exhaust": ("release", "compression")}
"""Names of the opening and the closing event of each port."""


@dataclass(frozen=True, kw_only=True)
class PortTiming:
    """Openings and closings of a port in a turn of the crank."""

    end: str  # end of the cylinder: one of CYLINDER_ENDS
    port: str  # one of PORT_EVENTS
    openings: tuple[float, ...]  # crank angles at which the port opens, rad, from 0 to 2 pi, ascending
    closings: tuple[float, ...]  # crank angles at which it closes
    # displacement of the valve less the lap where it is largest, m; negative if the port never opens
    largest_opening: float

    @property
    def events(self) -> dict[str, float]:
        """Crank angles of the opening and the closing by name, such as "crank end cut-off"; none unless the port opens once in a turn."""
        if len(self.openings) != 1:
            return {}
        names = (f"{self.end} {event}" for event in PORT_EVENTS[self.port])
        return dict(zip(names, (*self.openings, *self.closings), strict=True))

    @property
    def statement(self) -> str:
        """A sentence on a port that does not open once in a turn; empty for one that does."""
        if len(self.openings) == 1:
            return ""
        name = f"the {self.port} port of the {self.end}"
        if not self.openings:
            if self.largest_opening > 0:
                return f"{name} never closes"
            return f"{name} never opens: it stays covered by {-1e3 * self.largest_opening:.4g} mm or more"
        opens, closes = (", ".join(f"{math.degrees(angle):.6g}" for angle in angles) for angles in (self.openings, self.closings))
        return f"{name} opens {len(self.openings)} times in a turn, at {opens} deg, and closes at {closes} deg"


class _Crossing(NamedTuple):
    """A zero of sign * position - threshold between two crank angles (rad), upward or downward; port is an index of the timings."""

    port: int
    opens: bool
    sign: float
    threshold: float
    low: float
    high: float


def find_port_timings(scene: Scene) -> tuple[PortTiming, ...]:
    """Return openings and closings of steam port and exhaust, crank end first, to about 1e-13 rad."""
    motion = valve_motion_of(scene)
    position = motion.turn[motion.valve.displacement]
    turning_angles = find_turning_angles(position)
    extremes = position(turning_angles)
    ports = [(end, port, *_port_edge(motion.valve, end, port)) for end in CYLINDER_ENDS for port in PORT_EVENTS]
    crossings, largest_openings = list[_Crossing](), list[float]()
    for k, (_, _, sign, lap) in enumerate(ports):
        threshold = sign * motion.centre + lap
        openings = sign * extremes - threshold
        largest_openings.append(float(np.max(openings)))
        for (low, before), (high, after) in pairwise(zip(turning_angles.tolist(), openings.tolist(), strict=True)):
            if (before > 0) != (after > 0):
                crossings.append(_Crossing(k, after > 0, sign, threshold, low, high))
    angles = _locate_crossings(motion, crossings) if crossings else []
    return tuple(
        PortTiming(
            end=end,
            port=port,
            openings=_angles_of(crossings, angles, k, opens=True),
            closings=_angles_of(crossings, angles, k, opens=False),
            largest_opening=largest_openings[k],
        )
        for k, (end, port, _, _) in enumerate(ports)
    )


def find_event_angles(scene: Scene) -> dict[str, float]:
    """Return the crank angles (0 to 2 pi) of the valve events by names as "crank end cut-off", to about 1e-13 rad."""
    return {name: angle for timing in find_port_timings(scene) for name, angle in timing.events.items()}


def _port_edge(valve: Valve, end: str, port: str) -> tuple[float, float]:
    """Return the sign of the displacement that opens a port, and the lap over it, m."""
    steam_sign = valve.outward_sign if end == CYLINDER_ENDS[0] else -valve.outward_sign
    return (steam_sign, valve.steam_lap) if port == "steam" else (-steam_sign, valve.exhaust_lap)


def _angles_of(crossings: list[_Crossing], angles: list[float], port: int, *, opens: bool) -> tuple[float, ...]:
    pairs = zip(crossings, angles, strict=True)
    return tuple(sorted(angle for crossing, angle in pairs if crossing.port == port and crossing.opens == opens))


def _locate_crossings(motion: ValveMotion, crossings: list[_Crossing]) -> list[float]:
    """Return the crank angles of crossings, rad, from 0 to 2 pi."""
    position = motion.turn[motion.valve.displacement]
    signs, thresholds, low, high = (np.array([getattr(one, name) for one in crossings]) for name in ("sign", "threshold", "low", "high"))

    def openings(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        positions, derivatives = (arrays[motion.valve.displacement] for arrays in motion.evaluate(angles % math.tau)[:2])
        return signs * positions - thresholds, signs * derivatives

    def interpolated_root(crossing: _Crossing) -> float:
        return find_root(lambda angle: float(crossing.sign * position(angle) - crossing.threshold), crossing.low, crossing.high)

    angles = np.array([interpolated_root(one) for one in crossings])
    steps = np.zeros(len(crossings))
    for _ in range(2):  # Newton's method, from angles that are almost right
        values, derivatives = openings(angles)
        steps = -values / derivatives
        angles = angles + steps
    if not np.all((np.abs(steps) < ANGLE_TOLERANCE) & (low < angles) & (angles < high)):
        angles = find_roots(openings, low, high, ANGLE_TOLERANCE)
    located: list[float] = (angles % math.tau).tolist()
    return located
