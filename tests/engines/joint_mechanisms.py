"""Small scenes, at least one for each joint and load, with what their readings must be: closed forms, or scipy's."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.special import ellipj, ellipk

from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    Gear,
    Pin,
    Point,
    Prismatic,
    RackAndPinion,
    RotationalDriver,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate, PointDistance
from governor_mechanism.model.scene import FIXED_PLANE, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.types import FloatArray

ExactReadings = dict[str, tuple[FloatArray, FloatArray]]
"""By the name of a reading: its values (n,) and rates (n,)."""

GRAVITY = 9.81
SECOND_ORDER, NO_ERROR = "second order", "no error"


@dataclass(frozen=True, kw_only=True)
class ExactCase:
    """A scene; what its readings are at times (n,) s; the longest step (s) at which an order shows, and which order.

    impulse is False where the impulse engine has no such joint.
    """

    scene: Scene
    exact: Callable[[FloatArray], ExactReadings]
    step: float = 0.005
    order: str = SECOND_ORDER
    impulse: bool = True


# --- the parts of a scene ---------------------------------------------------------------------------------------------


def make_scene(
    *, bodies, joints, readings, sketch, loads=(), values=None, rates=None, gravity=GRAVITY, size=1.0, duration=1.0, output_interval=0.1
) -> Scene:
    """A scene of one mechanism in a plane that stands still."""
    mechanism = Mechanism(
        bodies=tuple(bodies),
        joints=tuple(joints),
        readings=tuple(readings),
        coordinate=readings[0].name,
        length_scale=size,
        initial_guess=tuple(sketch),
        force_elements=tuple(loads),
    )
    return Scene(
        title="test",
        parts=(Part(name="mechanism", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE),),
        effects=(Gravity(acceleration=gravity),) if gravity else (),
        spindle=Spindle(),
        start=Start(values=values or {}, rates=rates or {}),
        run=RunSettings(duration=duration, output_interval=output_interval, accuracy=1e-6),
    )


def body_point(body: str, x: float = 0.0, y: float = 0.0) -> Point:
    """A point of a body."""
    return Point(body=body, x=x, y=y)


def ground_point(x: float = 0.0, y: float = 0.0) -> Point:
    """A point of the ground."""
    return Point(body=GROUND, x=x, y=y)


def rotating_body(name: str, mass: float, inertia: float) -> Body:
    """A body of this moment of inertia about its mass centre."""
    return Body(name=name, mass=mass, second_moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rod_body(name: str, mass: float, length: float) -> Body:
    """A uniform slender rod along its x axis."""
    return Body(name=name, mass=mass, second_moments=SecondMoments(xx=mass * length**2 / 12))


def point_mass(name: str, mass: float) -> Body:
    """A mass in one point."""
    return Body(name=name, mass=mass, can_rotate=False)


def body_angle(body: str, name: str = "") -> BodyAngle:
    """How far a body has turned, by its own name."""
    return BodyAngle(name=name or body, quantity="angle", body=body)


def x_reading(body: str, name: str = "x", zero: float = 0.0) -> PointCoordinate:
    """Where the mass centre of a body is, in x."""
    return PointCoordinate(name=name, quantity="length", point=body_point(body), direction_x=1.0, direction_y=0.0, zero=zero)


def y_reading(body: str, name: str = "y") -> PointCoordinate:
    """Where the mass centre of a body is, in y."""
    return PointCoordinate(name=name, quantity="length", point=body_point(body), direction_x=0.0, direction_y=1.0)


# --- independent answers ----------------------------------------------------------------------------------------------


def integrate_state(state_derivative: Callable, start, times: FloatArray, breaks=()) -> FloatArray:
    """A state (numbers, n) at the times, by scipy at its tightest, split where the right-hand side has breaks."""
    state, found = np.array(start, dtype=np.float64), np.empty((len(start), len(times)))
    found[:, times == 0.0] = state[:, np.newaxis]
    knots = [0.0, *(float(at) for at in breaks if 0 < at < times[-1]), float(times[-1])]
    for begin, end in pairwise(knots):
        mine = (times > begin) & (times <= end)
        wanted = np.unique(np.append(times[mine], end))
        piece = solve_ivp(state_derivative, (begin, end), state, method="DOP853", t_eval=wanted, rtol=1e-13, atol=1e-15)
        found[:, mine] = piece.y[:, : int(mine.sum())]
        state = piece.y[:, -1]
    return found


def released_pendulum(times: FloatArray, square: float, start: float) -> tuple[FloatArray, FloatArray]:
    """Angle and rate of a pendulum of small-swing frequency sqrt(square), let go at `start` from rest (Jacobi's sn)."""
    modulus = math.sin(start / 2)
    fast = math.sqrt(square)
    sn, cn, dn, _ = ellipj(ellipk(modulus**2) + fast * times, modulus**2)
    return 2 * np.arcsin(modulus * sn), 2 * modulus * fast * cn * dn / np.sqrt(1 - (modulus * sn) ** 2)


def integrate_one_coordinate(inertia: Callable, generalised_force: Callable, start, times: FloatArray) -> FloatArray:
    """Coordinate and rate (2, n): inertia(q) gives J and dJ/dq, push(q, rate) the generalised force."""

    def slope(_, state):
        whole, change = inertia(state[0])
        return [state[1], (generalised_force(*state) - 0.5 * change * state[1] ** 2) / whole]

    return integrate_state(slope, start, times)


def pendulum_on_trolley_solution(trolley: float, mass: float, length: float, inertia: float, start: float) -> Callable:
    """A pendulum on a free trolley: angle from below, and the trolley's way from where both centres balance."""

    def of_angle(q):
        off = mass * length * np.cos(q)
        whole = inertia + mass * length**2 - off**2 / (trolley + mass)
        return whole, 2 * off * mass * length * np.sin(q) / (trolley + mass)

    def exact(times):
        q, rate = integrate_one_coordinate(of_angle, lambda q, _: -mass * GRAVITY * length * np.sin(q), (start, 0.0), times)
        share = mass * length / (trolley + mass)
        way = -share * (np.sin(q) - math.sin(start))  # the common centre stays where it was in x
        return {"angle": (q, rate), "x": (way, -share * np.cos(q) * rate)}

    return exact


def mass_on_rotating_path_solution(inertia: float, mass: float, path: Callable, start) -> Callable:
    """A mass on a path(s) of a body that turns about its origin, free of loads: path gives place, slope and bend.

    start: the body's angle and rate, s and its rate. Lagrange's equations of T = (I + m p.p) w^2/2 + m p'.p' v^2/2
    + m (p x p') w v. The readings are 'turn' and 'way'.
    """

    def slope(_, state):
        _, w, s, v = state
        place, along, bend = (np.array(vector) for vector in path(s))
        cross, growth = _cross(place, along), _cross(place, bend)
        matrix = mass * np.array([[inertia / mass + place @ place, cross], [cross, along @ along]])
        right = -mass * np.array([2 * (place @ along) * v * w + growth * v**2, (along @ bend) * v**2 - (place @ along) * w**2])
        bends = np.linalg.solve(matrix, right)
        return [w, bends[0], v, bends[1]]

    def exact(times):
        turn, w, way, v = integrate_state(slope, start, times)
        return {"turn": (turn, w), "way": (way, v)}

    return exact


def _cross(first, second):
    return first[0] * second[1] - first[1] * second[0]


def straight_path(angle: float, distance: float) -> Callable:
    """A straight path at `angle`, whose nearest point to the origin lies `aside` of it."""
    u, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    return lambda s: (s * u + distance * n, u, 0 * u)


@dataclass(frozen=True)
class SliderCrankKinematics:
    """Crank at the origin, connecting rod of uniform mass, piston on the x axis: all of it by the crank's angle."""

    crank: float
    rod: float
    rod_mass: float
    piston_mass: float

    def piston(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Way of the piston and its two derivatives by the crank's angle."""
        lean, lean1, lean2 = self.rod_angle(q)
        r, length = self.crank, self.rod
        return (
            r * np.cos(q) + length * np.cos(lean),
            -r * np.sin(q) - length * np.sin(lean) * lean1,
            -r * np.cos(q) - length * (np.cos(lean) * lean1**2 + np.sin(lean) * lean2),
        )

    def rod_angle(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle of the rod, and its two derivatives."""
        sine, cosine = np.sin(q), np.cos(q)
        r, drop = self.crank, np.sqrt(self.rod**2 - self.crank**2 * np.sin(q) ** 2)
        return -np.arcsin(r * sine / self.rod), -r * cosine / drop, r * sine / drop - r**3 * sine * cosine**2 / drop**3

    def torque(self, q: FloatArray, rate: FloatArray, acceleration: FloatArray, crank_inertia: float) -> FloatArray:
        """What turns the crank (N m), by virtual work: mass times acceleration, and weight, along the motion."""
        lean, lean1, lean2 = self.rod_angle(q)
        half = self.rod / 2
        middle1 = self.crank * 1j * np.exp(1j * q) + half * 1j * lean1 * np.exp(1j * lean)
        middle2 = -self.crank * np.exp(1j * q) + half * (1j * lean2 - lean1**2) * np.exp(1j * lean)
        middle = middle2 * rate**2 + middle1 * acceleration
        _, way1, way2 = self.piston(q)
        inertia = self.rod_mass * self.rod**2 / 12
        return (
            crank_inertia * acceleration
            + self.rod_mass * ((middle + 1j * GRAVITY) * middle1.conj()).real
            + inertia * (lean2 * rate**2 + lean1 * acceleration) * lean1
            + self.piston_mass * (way2 * rate**2 + way1 * acceleration) * way1
        )


# --- pins, welds, links -----------------------------------------------------------------------------------------------


def pendulum_on_a_pin() -> ExactCase:
    """A rod hung from its end."""
    mass, length, start = 2.0, 0.8, 2.0
    scene = make_scene(
        bodies=[rod_body("rod", mass, length)],
        joints=[Pin(name="hinge", first=ground_point(0.1, 0.2), second=body_point("rod", -length / 2))],
        readings=[BodyAngle(name="rod", quantity="angle", body="rod")],
        sketch=[(0.1 + length / 2, 0.2, 0.0)],
        values={"rod": start - math.pi / 2},
        size=length,
    )

    def exact(times):
        angle, rate = released_pendulum(times, 1.5 * GRAVITY / length, start)
        return {"rod": (angle - math.pi / 2, rate)}

    return ExactCase(scene=scene, exact=exact)


def pendulum_on_a_trolley() -> ExactCase:
    """A rod pinned to a trolley that runs freely: a pin between bodies that both move, its ends named the other way."""
    length, start = 0.6, 1.3
    scene = make_scene(
        bodies=[point_mass("trolley", 3.0), rod_body("rod", 2.0, length)],
        joints=[
            Slider(name="rail", first=ground_point(), second=body_point("trolley"), angle=0.0),
            Pin(name="hinge", first=body_point("rod", y=length / 2), second=body_point("trolley")),
        ],
        readings=[body_angle("rod", "angle"), x_reading("trolley")],
        sketch=[(0.0, 0.0, 0.0), (0.0, -length / 2, 0.0)],
        values={"angle": start, "x": 0.0},
        size=length,
    )
    # The rod lies along its y axis here, hence the moment of a rod all the same: only xx + yy counts.
    return ExactCase(scene=scene, exact=pendulum_on_trolley_solution(3.0, 2.0, length / 2, 2.0 * length**2 / 12, start))


def bent_pendulum(turn: float = 0.7) -> ExactCase:
    """Two rods welded at an angle are one pendulum."""
    first, second, lengths, start = 2.0, 1.5, (0.5, 0.4), 1.1
    # Mass times mass centre from the pin, in the axes of the first rod, and the inertia about the pin.
    tip = lengths[0] + np.exp(1j * turn) * lengths[1] / 2
    moment = first * lengths[0] / 2 + second * tip
    inertia = first * lengths[0] ** 2 / 3 + second * (lengths[1] ** 2 / 12 + abs(tip) ** 2)
    hanging = -math.pi / 2 - np.angle(moment)  # angle of the first rod when the whole hangs straight
    scene = make_scene(
        bodies=[rod_body("first", first, lengths[0]), rod_body("second", second, lengths[1])],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("first", -lengths[0] / 2)),
            Weld(name="weld", first=body_point("first", lengths[0] / 2), second=body_point("second", -lengths[1] / 2), relative_angle=turn),
        ],
        readings=[body_angle("first"), body_angle("second")],
        sketch=[(lengths[0] / 2, 0.0, 0.0), (tip.real, tip.imag, turn)],
        values={"first": hanging + start},
        size=sum(lengths),
    )

    def exact(times):
        angle, rate = released_pendulum(times, abs(moment) * GRAVITY / inertia, start)
        return {"first": (hanging + angle, rate), "second": (hanging + angle + turn, rate)}

    return ExactCase(scene=scene, exact=exact)


def mass_on_a_link() -> ExactCase:
    """A mass on a massless link from a trolley that runs freely."""
    length, start = 0.5, 1.2
    scene = make_scene(
        bodies=[point_mass("trolley", 2.0), point_mass("bob", 1.5)],
        joints=[
            Slider(name="rail", first=ground_point(), second=body_point("trolley"), angle=0.0),
            Distance(name="link", first=body_point("trolley"), second=body_point("bob"), length=length),
        ],
        readings=[x_reading("trolley"), x_reading("bob", "bob_x"), y_reading("bob", "bob_y")],
        sketch=[(0.0, 0.0, 0.0), (length * math.sin(start), -length * math.cos(start), 0.0)],
        size=length,
    )
    inner = pendulum_on_trolley_solution(2.0, 1.5, length, 0.0, start)

    def exact(times):
        told = inner(times)
        (q, rate), (x, u) = told["angle"], told["x"]
        return {
            "x": (x, u),
            "bob_x": (x + length * np.sin(q), u + length * np.cos(q) * rate),
            "bob_y": (-length * np.cos(q), length * np.sin(q) * rate),
        }

    return ExactCase(scene=scene, exact=exact)


# --- guides -----------------------------------------------------------------------------------------------------------


def bead_on_a_turning_rod(angle: float = 0.3, aside: float = 0.1) -> ExactCase:
    """A mass on a straight line of a rod that turns freely about a pin; the line passes the pin at a distance."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    n = -aside * math.sin(angle), aside * math.cos(angle)
    scene = make_scene(
        bodies=[rod_body("rod", mass, length), point_mass("bead", 0.7)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("rod", -length / 2)),
            Slider(name="bore", first=body_point("rod", n[0] - length / 2, n[1]), second=body_point("bead"), angle=angle),
        ],
        readings=[body_angle("rod", "turn"), _along("way", "rod", "bead", -length / 2, angle)],
        sketch=[(length / 2, 0.0, 0.0), (n[0] + 0.35 * math.cos(angle), n[1] + 0.35 * math.sin(angle), 0.0)],
        values={"turn": start[0], "way": start[2]},
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=length,
    )
    return ExactCase(scene=scene, exact=mass_on_rotating_path_solution(mass * length**2 / 3, 0.7, straight_path(angle, aside), start))


def collar_on_a_turning_rod(angle: float = 0.3, turn: float = 0.5) -> ExactCase:
    """A collar with inertia of its own on such a rod, turning with it; its mass centre beside the line and ahead."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    collar, inertia, ahead, aside = 0.7, 0.02, 0.06, 0.09
    point = -np.exp(-1j * (turn - angle)) * (ahead + 1j * aside)  # the guided point in the collar's axes
    place = np.exp(1j * angle) * (0.35 + ahead + 1j * aside)
    scene = make_scene(
        bodies=[rod_body("rod", mass, length), rotating_body("collar", collar, inertia)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("rod", -length / 2)),
            Prismatic(
                name="bore",
                first=body_point("rod", -length / 2),
                second=body_point("collar", point.real, point.imag),
                angle=angle,
                relative_angle=turn,
            ),
        ],
        readings=[body_angle("rod", "turn"), _along("way", "rod", "collar", -length / 2, angle, ahead), body_angle("collar")],
        sketch=[(length / 2, 0.0, 0.0), (place.real, place.imag, turn)],
        values={"turn": start[0], "way": start[2]},
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=length,
    )
    u, d = np.array([math.cos(angle), math.sin(angle)]), np.exp(1j * angle) * (ahead + 1j * aside)

    def path(s):
        return s * u + np.array([d.real, d.imag]), u, 0 * u

    inner = mass_on_rotating_path_solution(mass * length**2 / 3 + inertia, collar, path, start)

    def exact(times):
        told = inner(times)
        return {**told, "collar": (told["turn"][0] + turn, told["turn"][1])}

    return ExactCase(scene=scene, exact=exact)


def _along(name: str, body: str, point_body: str, x: float, angle: float, zero: float = 0.0) -> PointCoordinate:
    """How far a body's mass centre is along a direction of another body, from its point (x, 0)."""
    return PointCoordinate(
        name=name,
        quantity="length",
        point=body_point(point_body),
        origin=body_point(body, x),
        direction_x=math.cos(angle),
        direction_y=math.sin(angle),
        zero=zero,
    )


def rod_through_a_swivel() -> ExactCase:
    """A rod that slides through a swivel which stands still: the line is the rod's, the point on it the ground's."""
    mass, inertia, start = 1.4, 0.06, (0.2, 0.5, -0.4, 1.5)
    scene = make_scene(
        bodies=[rotating_body("rod", mass, inertia)],
        joints=[Slider(name="swivel", first=body_point("rod"), second=ground_point(), angle=0.0)],
        readings=[
            body_angle("rod", "turn"),
            PointCoordinate(
                name="way", quantity="length", point=ground_point(), origin=body_point("rod"), direction_x=-1.0, direction_y=0.0
            ),
        ],
        sketch=[(start[0] * math.cos(start[2]), start[0] * math.sin(start[2]), start[2])],
        rates={"turn": start[3], "way": start[1]},
        size=0.5,
        duration=0.6,
    )

    def slope(_, state):
        way, speed, turn, rate = state
        twist = -mass * way * (2 * speed * rate + GRAVITY * math.cos(turn)) / (inertia + mass * way**2)
        return [speed, way * rate**2 - GRAVITY * math.sin(turn), rate, twist]

    def exact(times):
        way, speed, turn, rate = integrate_state(slope, start, times)
        return {"turn": (turn, rate), "way": (way, speed)}

    return ExactCase(scene=scene, exact=exact)


def bead_in_a_round_slot() -> ExactCase:
    """A mass in a slot of the ground, an arc about a point: a pendulum of that radius."""
    radius, start = 0.4, 2.2
    scene = make_scene(
        bodies=[point_mass("bead", 1.3)],
        joints=[ArcSlot(name="slot", first=ground_point(0.2, 0.1), second=body_point("bead"), radius=radius)],
        readings=[x_reading("bead"), y_reading("bead")],
        sketch=[(0.2 + radius * math.sin(start), 0.1 - radius * math.cos(start), 0.0)],
        size=radius,
    )

    def exact(times):
        q, rate = released_pendulum(times, GRAVITY / radius, start)
        return {"x": (0.2 + radius * np.sin(q), radius * np.cos(q) * rate), "y": (0.1 - radius * np.cos(q), radius * np.sin(q) * rate)}

    return ExactCase(scene=scene, exact=exact)


def bead_in_a_round_slot_of_a_pendulum() -> ExactCase:
    """The slot in a plate that swings about a pin: a double pendulum, in its two angles from below."""
    plate, mass, inertia, centre, slot, radius = 2.0, 0.8, 0.05, 0.25, 0.4, 0.2
    start = (0.6, 0.0, -0.5, 0.0)
    knee = slot * math.sin(start[0]), -slot * math.cos(start[0])
    hung = (centre * math.sin(start[0]), -centre * math.cos(start[0]), start[0])
    scene = make_scene(
        bodies=[rotating_body("plate", plate, inertia), point_mass("bead", mass)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("plate", y=centre)),
            ArcSlot(name="slot", first=body_point("plate", y=centre - slot), second=body_point("bead"), radius=radius),
        ],
        readings=[body_angle("plate"), x_reading("bead"), y_reading("bead")],
        sketch=[hung, (knee[0] + radius * math.sin(start[2]), knee[1] - radius * math.cos(start[2]), 0.0)],
        size=slot + radius,
        duration=0.8,
    )
    whole = inertia + plate * centre**2 + mass * slot**2

    def slope(_, state):
        p, u, q, v = state
        coupling = mass * slot * radius * math.cos(p - q)
        twist = mass * slot * radius * math.sin(p - q)
        right = [
            -twist * v**2 - (plate * centre + mass * slot) * GRAVITY * math.sin(p),
            twist * u**2 - mass * GRAVITY * radius * math.sin(q),
        ]
        bends = np.linalg.solve([[whole, coupling], [coupling, mass * radius**2]], right)
        return [u, bends[0], v, bends[1]]

    def exact(times):
        p, u, q, v = integrate_state(slope, start, times)
        return {
            "plate": (p, u),
            "x": (slot * np.sin(p) + radius * np.sin(q), slot * np.cos(p) * u + radius * np.cos(q) * v),
            "y": (-slot * np.cos(p) - radius * np.cos(q), slot * np.sin(p) * u + radius * np.sin(q) * v),
        }

    return ExactCase(scene=scene, exact=exact)


STEEPNESS = 1.5


def bead_on_a_parabola(curve: Curve | None = None) -> ExactCase:
    """A bead on y = a x^2, by the curve itself or by a table of its points."""
    start = 0.6
    scene = make_scene(
        bodies=[point_mass("bead", 0.9)],
        joints=[
            CurveSlot(
                name="wire",
                first=ground_point(),
                second=body_point("bead"),
                curve=curve or PolynomialCurve(coefficients=(0.0, 0.0, STEEPNESS)),
            )
        ],
        readings=[x_reading("bead"), y_reading("bead")],
        sketch=[(start, STEEPNESS * start**2, 0.0)],
        values={"x": start},
        size=0.5,
    )

    def inertia(x):
        return 1 + 4 * STEEPNESS**2 * x**2, 8 * STEEPNESS**2 * x

    def exact(times):
        x, rate = integrate_one_coordinate(inertia, lambda x, _: -2 * GRAVITY * STEEPNESS * x, (start, 0.0), times)
        return {"x": (x, rate), "y": (STEEPNESS * x**2, 2 * STEEPNESS * x * rate)}

    return ExactCase(scene=scene, exact=exact)


def bead_on_a_table_of_the_parabola() -> ExactCase:
    """A cubic spline through points of a parabola is that parabola: third differences vanish at its ends too."""
    x = np.linspace(-0.8, 0.8, 33)
    return bead_on_a_parabola(SplineCurve(x=tuple(x.tolist()), y=tuple((STEEPNESS * x**2).tolist())))


def bead_on_a_turning_curve(angle: float = -0.4) -> ExactCase:
    """A bead on a cubic curve of a body that turns freely about a pin beside the curve's origin."""
    coefficients, inertia, mass, start = (0.1, 0.3, -0.8, 0.9), 0.2, 0.5, (0.2, 3.0, 0.3, 0.5)
    x, y = 0.15, -0.1  # the curve's origin from the pin, in the body's axes
    turn = np.exp(1j * angle)

    def path(s):
        c = coefficients
        places = (
            x + 1j * y + turn * (s + 1j * (((c[3] * s + c[2]) * s + c[1]) * s + c[0])),
            turn * (1 + 1j * ((3 * c[3] * s + 2 * c[2]) * s + c[1])),
            turn * 1j * (6 * c[3] * s + 2 * c[2]),
        )
        return tuple((place.real, place.imag) for place in places)

    first = np.exp(1j * start[0]) * complex(*path(start[2])[0])
    scene = make_scene(
        bodies=[rotating_body("cam", 2.0, inertia), point_mass("bead", mass)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("cam")),
            CurveSlot(
                name="groove",
                first=body_point("cam", x, y),
                second=body_point("bead"),
                curve=PolynomialCurve(coefficients=coefficients),
                angle=angle,
            ),
        ],
        readings=[
            body_angle("cam", "turn"),
            PointCoordinate(
                name="way",
                quantity="length",
                point=body_point("bead"),
                origin=body_point("cam", x, y),
                direction_x=math.cos(angle),
                direction_y=math.sin(angle),
            ),
        ],
        sketch=[(0.0, 0.0, start[0]), (first.real, first.imag, 0.0)],
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=0.5,
    )
    return ExactCase(scene=scene, exact=mass_on_rotating_path_solution(inertia, mass, path, start))


# --- gears and racks --------------------------------------------------------------------------------------------------


def _wheels(off: float, values: Mapping[str, float], torque: float, ratio: float, offset: float) -> Scene:
    start = values["first"]
    turned = ratio * start + offset
    return make_scene(
        bodies=[rotating_body("first", 3.0, 0.04), rotating_body("second", 5.0, 0.3)],
        joints=[
            Pin(name="shaft 1", first=ground_point(), second=body_point("first")),
            Pin(name="shaft 2", first=ground_point(0.6), second=body_point("second", y=off)),
            Gear(name="teeth", first=body_point("first"), second=body_point("second"), ratio=ratio, offset=offset),
        ],
        readings=[body_angle("first"), body_angle("second")],
        sketch=[(0.0, 0.0, start), (0.6 + off * math.sin(turned), -off * math.cos(turned), turned)],
        loads=[Torque(name="motor", second="first", moment=InputFunction(values=(torque,)))] if torque else [],
        values=values,
        size=0.5,
    )


def geared_wheels() -> ExactCase:
    """Two wheels in mesh with a torque on one: its own inertia and the other's, times the ratio squared."""
    ratio, offset, torque = -0.5, 0.4, 0.6
    scene = _wheels(0.0, {"first": 0.1}, torque, ratio, offset)
    bend = torque / (0.04 + ratio**2 * 0.3)

    def exact(times):
        angle, rate = 0.1 + bend * times**2 / 2, bend * times
        return {"first": (angle, rate), "second": (ratio * angle + offset, ratio * rate)}

    return ExactCase(scene=scene, exact=exact, order=NO_ERROR)


def geared_pendulum() -> ExactCase:
    """The second wheel's mass centre lies off its shaft, so that it swings and takes the first one along."""
    ratio, offset, off, start = -0.5, 0.4, 0.15, 1.7
    scene = _wheels(off, {"first": (start - offset) / ratio}, 0.0, ratio, offset)
    inertia = 0.3 + 5.0 * off**2 + 0.04 / ratio**2

    def exact(times):
        angle, rate = released_pendulum(times, 5.0 * GRAVITY * off / inertia, start)
        return {"second": (angle, rate), "first": ((angle - offset) / ratio, rate / ratio)}

    return ExactCase(scene=scene, exact=exact)


def falling_rack(lean: float = 1.2) -> ExactCase:
    """A rack slides down a steep guide and turns a pinion, which is the heavier for it."""
    radius, inertia, mass, offset = -0.1, 0.03, 2.0, 0.05
    ahead = offset - 0.1 * math.cos(lean)  # of the guide's foot, at angle 0, where the way from the pinion is `offset`
    scene = make_scene(
        bodies=[rotating_body("pinion", 1.0, inertia), point_mass("rack", mass)],
        joints=[
            Pin(name="shaft", first=ground_point(), second=body_point("pinion")),
            Slider(name="guide", first=ground_point(0.1), second=body_point("rack"), angle=lean),
            RackAndPinion(name="teeth", first=body_point("pinion"), second=body_point("rack"), radius=radius, angle=lean, offset=offset),
        ],
        readings=[body_angle("pinion"), y_reading("rack")],
        sketch=[(0.0, 0.0, 0.0), (0.1 + ahead * math.cos(lean), ahead * math.sin(lean), 0.0)],
        values={"pinion": 0.0},
        size=0.2,
        duration=0.5,
    )
    bend = -GRAVITY * math.sin(lean) / (1 + inertia / (mass * radius**2))  # along the guide

    def exact(times):
        way, speed = bend * times**2 / 2, bend * times
        return {"pinion": (way / radius, speed / radius), "y": ((ahead + way) * math.sin(lean), speed * math.sin(lean))}

    return ExactCase(scene=scene, exact=exact, impulse=False)


# --- drives -----------------------------------------------------------------------------------------------------------

ENGINE_KINEMATICS = SliderCrankKinematics(crank=0.1, rod=0.35, rod_mass=1.2, piston_mass=2.0)
CRANK_INERTIA = 0.02


def _slider_crank(motion: PrescribedMotion, start: float, duration: float) -> Scene:
    pin = ENGINE_KINEMATICS.crank * np.exp(1j * start)
    lean = float(ENGINE_KINEMATICS.rod_angle(np.array(start))[0])
    middle = pin + np.exp(1j * lean) * ENGINE_KINEMATICS.rod / 2
    return make_scene(
        bodies=[
            rotating_body("crank", 4.0, CRANK_INERTIA),
            rod_body("rod", ENGINE_KINEMATICS.rod_mass, ENGINE_KINEMATICS.rod),
            point_mass("piston", ENGINE_KINEMATICS.piston_mass),
        ],
        joints=[
            Pin(name="shaft", first=ground_point(), second=body_point("crank")),
            Pin(name="crank pin", first=body_point("crank", ENGINE_KINEMATICS.crank), second=body_point("rod", -ENGINE_KINEMATICS.rod / 2)),
            Pin(name="cross head", first=body_point("rod", ENGINE_KINEMATICS.rod / 2), second=body_point("piston")),
            Slider(name="guide", first=ground_point(), second=body_point("piston"), angle=0.0),
            RotationalDriver(name="drive", first=ground_point(), second=body_point("crank"), motion=motion),
        ],
        readings=[body_angle("crank"), x_reading("piston"), body_angle("rod")],
        sketch=[(0.0, 0.0, start), (middle.real, middle.imag, lean), (float(ENGINE_KINEMATICS.piston(np.array(start))[0]), 0.0, 0.0)],
        size=ENGINE_KINEMATICS.rod,
        duration=duration,
        output_interval=duration / 20,
    )


def _crank_readings(angle: FloatArray, rate: FloatArray) -> ExactReadings:
    way, way1, _ = ENGINE_KINEMATICS.piston(angle)
    lean, lean1, _ = ENGINE_KINEMATICS.rod_angle(angle)
    return {"crank": (angle, rate), "x": (way, way1 * rate), "rod": (lean, lean1 * rate)}


def driven_slider_crank() -> ExactCase:
    """A crank driven at a constant rate."""
    start, rate = 0.3, 12.0
    scene = _slider_crank(PrescribedMotion.constant_rate(start, rate), start, 0.6)
    return ExactCase(scene=scene, exact=lambda times: _crank_readings(start + rate * times, np.full_like(times, rate)), step=0.0025)


MOTION_TABLE = ((0.0, 0.15, 0.3, 0.5, 0.6), (0.3, 1.0, 2.4, 2.9, 2.2))


def crank_motion(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The natural spline through the table: values, rates, second derivatives."""
    spline = CubicSpline(*MOTION_TABLE, bc_type="natural")
    return spline(times), spline(times, 1), spline(times, 2)


def slider_crank_driven_by_a_table() -> ExactCase:
    """The same crank driven through a few points, which a natural spline joins."""
    scene = _slider_crank(PrescribedMotion(times=MOTION_TABLE[0], values=MOTION_TABLE[1]), MOTION_TABLE[1][0], 0.6)
    return ExactCase(scene=scene, exact=lambda times: _crank_readings(*crank_motion(times)[:2]), step=0.0025)


def pendulum_on_a_driven_support() -> ExactCase:
    """A rod hung from a support that a drive moves to and fro, as a table of many points says."""
    length, mass, start = 0.6, 1.5, 0.4
    at = np.linspace(0.0, 1.2, 25)
    way = 0.05 * np.sin(9.0 * at)
    scene = make_scene(
        bodies=[point_mass("support", 2.0), rod_body("rod", mass, length)],
        joints=[
            Slider(name="rail", first=ground_point(), second=body_point("support"), angle=0.0),
            TranslationalDriver(
                name="drive",
                first=ground_point(-0.2),
                second=body_point("support"),
                angle=0.0,
                motion=PrescribedMotion(times=tuple(at.tolist()), values=tuple((0.2 + way).tolist())),
            ),
            Pin(name="hinge", first=body_point("support"), second=body_point("rod", y=length / 2)),
        ],
        readings=[body_angle("rod"), x_reading("support")],
        sketch=[(0.0, 0.0, 0.0), (length / 2 * math.sin(start), -length / 2 * math.cos(start), start)],
        values={"rod": start},
        rates={"rod": 0.0},
        size=length,
        duration=1.2,
    )
    spline = CubicSpline(at, way, bc_type="natural")

    def slope(time, state):
        lean = GRAVITY * math.sin(state[0]) + float(spline(time, 2)) * math.cos(state[0])
        return [state[1], -lean / (2 * length / 3)]

    def exact(times):
        angle, rate = integrate_state(slope, (start, 0.0), times, breaks=at)
        return {"rod": (angle, rate), "x": (spline(times), spline(times, 1))}

    return ExactCase(scene=scene, exact=exact)


def counterweight_driven_backwards() -> ExactCase:
    """A drive told from a wheel to the ground: the ground's angle less the wheel's, which therefore turns back."""
    speed = 4.0
    scene = make_scene(
        bodies=[rotating_body("wheel", 3.0, 0.1), point_mass("bob", 1.0)],
        joints=[
            Pin(name="shaft", first=body_point("wheel", y=0.1), second=ground_point()),
            RotationalDriver(
                name="drive", first=body_point("wheel"), second=ground_point(), motion=PrescribedMotion.constant_rate(0.3, speed)
            ),
            Slider(name="bore", first=body_point("wheel", y=0.1), second=body_point("bob"), angle=0.0),
        ],
        readings=[body_angle("wheel"), PointDistance(name="way", quantity="length", first=ground_point(), second=body_point("bob"))],
        sketch=[(-0.1 * math.sin(0.3), -0.1 * math.cos(0.3), -0.3), (0.2 * math.cos(0.3), -0.2 * math.sin(0.3), 0.0)],
        rates={"way": 0.4},
        size=0.5,
        duration=0.4,
        output_interval=0.05,
    )

    def slope(time, state):
        return [state[1], state[0] * speed**2 + GRAVITY * math.sin(0.3 + speed * time)]

    def exact(times):
        way, rate = integrate_state(slope, (0.2, 0.4), times)
        return {"wheel": (-0.3 - speed * times, np.full_like(times, -speed)), "way": (way, rate)}

    return ExactCase(scene=scene, exact=exact)


def bead_driven_along_a_turning_rod() -> ExactCase:
    """A drive moves a bead outward on a rod that turns freely: it slows as its moment of inertia grows."""
    inertia, mass, rate, first, speed = 0.5, 1.5, 3.0, 0.2, 0.6
    scene = make_scene(
        bodies=[rotating_body("rod", 2.0, inertia), point_mass("bead", mass)],
        joints=[
            Pin(name="hinge", first=ground_point(), second=body_point("rod")),
            Slider(name="bore", first=body_point("rod"), second=body_point("bead"), angle=0.0),
            TranslationalDriver(
                name="drive",
                first=body_point("rod"),
                second=body_point("bead"),
                angle=0.0,
                motion=PrescribedMotion.constant_rate(first, speed),
            ),
        ],
        readings=[body_angle("rod", "turn"), PointDistance(name="way", quantity="length", first=ground_point(), second=body_point("bead"))],
        sketch=[(0.0, 0.0, 0.0), (first, 0.0, 0.0)],
        rates={"turn": rate},
        gravity=0.0,
        size=1.0,
    )
    momentum = (inertia + mass * first**2) * rate
    unit = math.sqrt(mass / inertia)

    def exact(times):
        way = first + speed * times
        swept = momentum / (inertia * unit * speed) * (np.arctan(unit * way) - math.atan(unit * first))
        return {"turn": (swept, momentum / (inertia + mass * way**2)), "way": (way, np.full_like(times, speed))}

    return ExactCase(scene=scene, exact=exact)


# --- springs and dampers ----------------------------------------------------------------------------------------------


def hanging_spring() -> ExactCase:
    """A mass on a spring, guided straight down."""
    mass, stiffness, free, start = 1.2, 90.0, 0.3, -0.5
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[Slider(name="guide", first=ground_point(0.1), second=body_point("mass"), angle=math.pi / 2)],
        readings=[y_reading("mass")],
        sketch=[(0.1, start, 0.0)],
        loads=[Spring(name="spring", first=ground_point(0.1), second=body_point("mass"), stiffness=stiffness, free_length=free)],
        size=free,
    )
    rest, fast = -free - mass * GRAVITY / stiffness, math.sqrt(stiffness / mass)

    def exact(times):
        swing = start - rest
        return {"y": (rest + swing * np.cos(fast * times), -swing * fast * np.sin(fast * times))}

    return ExactCase(scene=scene, exact=exact)


def spring_between_two_masses() -> ExactCase:
    """Two bodies on one rail that do not turn, with a spring from off-centre points of each: swing and drift."""
    masses, stiffness, free, speeds = (1.0, 2.5), 60.0, 0.3, (0.4, -0.3)
    scene = make_scene(
        bodies=[point_mass("left", masses[0]), point_mass("right", masses[1])],
        joints=[Slider(name=f"rail {name}", first=ground_point(), second=body_point(name), angle=0.0) for name in ("left", "right")],
        readings=[x_reading("left", "left"), x_reading("right", "right")],
        sketch=[(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)],
        loads=[
            Spring(name="spring", first=body_point("right", -0.05), second=body_point("left", 0.05), stiffness=stiffness, free_length=free)
        ],
        rates={"left": speeds[0], "right": speeds[1]},
        gravity=0.0,
        size=0.5,
    )
    total = sum(masses)
    fast = math.sqrt(stiffness * total / (masses[0] * masses[1]))
    drift = (masses[0] * speeds[0] + masses[1] * speeds[1]) / total
    centre = masses[1] * 0.5 / total

    def exact(times):
        stretch, opening = 0.5 - 0.1 - free, speeds[1] - speeds[0]
        cosine, sine = np.cos(fast * times), np.sin(fast * times)
        apart = free + 0.1 + stretch * cosine + opening / fast * sine
        rate = opening * cosine - stretch * fast * sine
        middle = centre + drift * times
        return {
            "left": (middle - masses[1] / total * apart, drift - masses[1] / total * rate),
            "right": (middle + masses[0] / total * apart, drift + masses[0] / total * rate),
        }

    return ExactCase(scene=scene, exact=exact)


def spring_across_a_pendulum() -> ExactCase:
    """A rod on a pin, with a spring from off its axis to the ground: the spring's direction turns."""
    mass, length, stiffness, free, start = 1.5, 0.7, 80.0, 0.25, 0.9
    hook, anchor = 0.4 + 0.1j, 0.3 - 0.9j  # the hook from the pin, with the rod along x
    scene = make_scene(
        bodies=[rod_body("rod", mass, length)],
        joints=[Pin(name="hinge", first=ground_point(), second=body_point("rod", -length / 2))],
        readings=[body_angle("rod")],
        sketch=[(length / 2, 0.0, 0.0)],
        loads=[
            Spring(
                name="spring",
                first=body_point("rod", hook.real - length / 2, hook.imag),
                second=ground_point(anchor.real, anchor.imag),
                stiffness=stiffness,
                free_length=free,
            )
        ],
        values={"rod": start - math.pi / 2},
        size=length,
    )

    def push(q, _):
        place = hook * np.exp(1j * q)
        line = anchor - place
        pull = stiffness * (abs(line) - free) * line / abs(line)
        return (pull * (1j * place).conjugate()).real - mass * GRAVITY * length / 2 * math.cos(q)

    def exact(times):
        return {"rod": tuple(integrate_one_coordinate(lambda _: (mass * length**2 / 3, 0.0), push, (start - math.pi / 2, 0.0), times))}

    return ExactCase(scene=scene, exact=exact)


def damped_oscillation(times: FloatArray, square: float, decay: float, start: float, speed: float) -> tuple[FloatArray, FloatArray]:
    """The damped oscillator x'' + 2 decay x' + square x = 0, in its three regimes, by complex roots."""
    if math.isclose(decay**2, square):
        slope = speed + decay * start
        fall = np.exp(-decay * times)
        return (start + slope * times) * fall, (slope - decay * (start + slope * times)) * fall
    root = np.sqrt(complex(decay**2 - square))
    one, two = -decay + root, -decay - root
    a = (speed - two * start) / (one - two)
    first, second = a * np.exp(one * times), (start - a) * np.exp(two * times)
    return (first + second).real, (one * first + two * second).real


def damped_mass(ratio: float = 0.2) -> ExactCase:
    """A mass between a spring and a damper, `ratio` of the critical damping, on an inclined rail."""
    mass, stiffness, free, lean = 1.2, 90.0, 0.4, 0.5
    fast = math.sqrt(stiffness / mass)
    decay = ratio * fast
    rest = free + mass * GRAVITY * math.sin(lean) / stiffness  # up the rail, the anchor above
    u = np.exp(1j * lean)
    start, speed, anchor = 0.3, 1.0, 1.0 * u  # the mass at (1 - way) along the rail
    place = (1.0 - start) * u
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[Slider(name="rail", first=ground_point(), second=body_point("mass"), angle=lean)],
        readings=[PointDistance(name="way", quantity="length", first=ground_point(anchor.real, anchor.imag), second=body_point("mass"))],
        sketch=[(place.real, place.imag, 0.0)],
        loads=[
            Spring(
                name="spring",
                first=ground_point(anchor.real, anchor.imag),
                second=body_point("mass"),
                stiffness=stiffness,
                free_length=free,
            ),
            Damper(name="damper", first=body_point("mass"), second=ground_point(-0.5 * u.real, -0.5 * u.imag), damping=2 * mass * decay),
        ],
        rates={"way": speed},
        size=free,
    )

    def exact(times):
        way, rate = damped_oscillation(times, stiffness / mass, decay, start - rest, speed)
        return {"way": (rest + way, rate)}

    return ExactCase(scene=scene, exact=exact)


def damper_across_a_pendulum() -> ExactCase:
    """A rod on a pin, with a damper from off its axis to the ground: its direction turns."""
    mass, length, damping, start = 1.5, 0.7, 6.0, 1.4
    hook, anchor = 0.5 + 0.1j, 0.5 - 0.9j
    scene = make_scene(
        bodies=[rod_body("rod", mass, length)],
        joints=[Pin(name="hinge", first=ground_point(), second=body_point("rod", -length / 2))],
        readings=[body_angle("rod")],
        sketch=[(length / 2, 0.0, 0.0)],
        loads=[
            Damper(
                name="damper",
                first=ground_point(anchor.real, anchor.imag),
                second=body_point("rod", hook.real - length / 2, hook.imag),
                damping=damping,
            )
        ],
        values={"rod": start - math.pi / 2},
        size=length,
    )

    def push(q, rate):
        place = hook * np.exp(1j * q)
        along = (place - anchor) / abs(place - anchor)
        arm = (1j * place * along.conjugate()).real
        return -damping * arm**2 * rate - mass * GRAVITY * length / 2 * math.cos(q)

    def exact(times):
        return {"rod": tuple(integrate_one_coordinate(lambda _: (mass * length**2 / 3, 0.0), push, (start - math.pi / 2, 0.0), times))}

    return ExactCase(scene=scene, exact=exact)


def torsion_pendulum(damping: float = 0.0) -> ExactCase:
    """A wheel on a torsion spring, with or without a torsion damper."""
    inertia, stiffness, free, start, speed = 0.2, 8.0, 0.3, 2.0, -1.5
    loads = [TorsionSpring(name="wire", second="wheel", stiffness=stiffness, free_angle=free)]
    if damping:
        loads.append(TorsionDamper(name="vane", second="wheel", damping=damping))
    scene = make_scene(
        bodies=[rotating_body("wheel", 2.0, inertia)],
        joints=[Pin(name="shaft", first=ground_point(), second=body_point("wheel"))],
        readings=[body_angle("wheel")],
        sketch=[(0.0, 0.0, 0.0)],
        loads=loads,
        values={"wheel": start},
        rates={"wheel": speed},
        size=0.5,
    )

    def exact(times):
        angle, rate = damped_oscillation(times, stiffness / inertia, damping / (2 * inertia), start - free, speed)
        return {"wheel": (free + angle, rate)}

    return ExactCase(scene=scene, exact=exact)


def two_wheels_on_one_wire() -> ExactCase:
    """Two wheels, a torsion spring and a torsion damper between them, neither of them held."""
    inertias, stiffness, damping, free, start, rates = (0.2, 0.5), 8.0, 0.15, 0.3, (0.1, 1.4), (2.0, -0.5)
    scene = make_scene(
        bodies=[rotating_body("first", 2.0, inertias[0]), rotating_body("second", 3.0, inertias[1])],
        joints=[
            Pin(name="shaft 1", first=ground_point(), second=body_point("first")),
            Pin(name="shaft 2", first=ground_point(0.5), second=body_point("second")),
        ],
        readings=[body_angle("first"), body_angle("second")],
        sketch=[(0.0, 0.0, start[0]), (0.5, 0.0, start[1])],
        loads=[
            TorsionSpring(name="wire", first="first", second="second", stiffness=stiffness, free_angle=free),
            TorsionDamper(name="vane", first="second", second="first", damping=damping),
        ],
        rates={"first": rates[0], "second": rates[1]},
        size=0.5,
    )
    total, reduced = sum(inertias), inertias[0] * inertias[1] / sum(inertias)
    mean = (inertias[0] * start[0] + inertias[1] * start[1]) / total
    drift = (inertias[0] * rates[0] + inertias[1] * rates[1]) / total

    def exact(times):
        apart, rate = damped_oscillation(
            times, stiffness / reduced, damping / (2 * reduced), start[1] - start[0] - free, rates[1] - rates[0]
        )
        middle = mean + drift * times
        return {
            "first": (middle - inertias[1] / total * (apart + free), drift - inertias[1] / total * rate),
            "second": (middle + inertias[0] / total * (apart + free), drift + inertias[0] / total * rate),
        }

    return ExactCase(scene=scene, exact=exact)


# --- torques and forces -----------------------------------------------------------------------------------------------

STEPPED_PROGRAM = InputFunction(times=(0.0, 0.3, 0.45, 0.45, 0.7, 0.9), values=(0.5, 2.0, -0.4, 1.2, 0.3, 0.3))
"""Smooth to 0.45 s, a step there, smooth again, level from 0.9 s on; breaks off the reported tenths of a second."""


def stepped_program_integrals(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """STEPPED at times (n,), its integral from 0 and the integral of that: monotone cubics on either side."""
    at, values = np.array(STEPPED_PROGRAM.times), np.array(STEPPED_PROGRAM.values)
    first, second = PchipInterpolator(at[:3], values[:3]), PchipInterpolator(at[3:], values[3:])
    early, late = np.minimum(times, 0.45), np.clip(times, 0.45, 0.9)
    beyond = np.maximum(times - 0.9, 0.0)
    once = first.antiderivative(), second.antiderivative()
    twice = first.antiderivative(2), second.antiderivative(2)
    # The polynomials' integrals start at 0 at their first point.
    level = np.where(times < 0.45, first(early), np.where(times < 0.9, second(late), values[-1]))
    single = once[0](early) + once[1](late) + values[-1] * beyond
    late_way = np.maximum(times - 0.45, 0.0)
    at_end = once[1](0.9)
    double = twice[0](early) + once[0](0.45) * late_way + twice[1](late) + at_end * beyond + values[-1] * beyond**2 / 2
    return level, single, double


def wheel_under_a_torque(*, constant: bool) -> ExactCase:
    """A wheel under a given moment, constant or in time with a step."""
    inertia, start, rate = 0.2, 0.3, -1.0
    program = InputFunction(values=(1.5,)) if constant else STEPPED_PROGRAM
    scene = make_scene(
        bodies=[rotating_body("wheel", 2.0, inertia)],
        joints=[Pin(name="shaft", first=ground_point(), second=body_point("wheel"))],
        readings=[body_angle("wheel")],
        sketch=[(0.0, 0.0, start)],
        loads=[Torque(name="motor", second="wheel", moment=program)],
        rates={"wheel": rate},
        size=0.5,
    )

    def exact(times):
        single, double = (1.5 * times, 0.75 * times**2) if constant else stepped_program_integrals(times)[1:]
        return {"wheel": (start + rate * times + double / inertia, rate + single / inertia)}

    return ExactCase(scene=scene, exact=exact, order=NO_ERROR if constant else SECOND_ORDER)


def torque_between_two_wheels() -> ExactCase:
    """A moment in time that one wheel takes from the other."""
    inertias = 0.2, 0.5
    scene = make_scene(
        bodies=[rotating_body("first", 2.0, inertias[0]), rotating_body("second", 3.0, inertias[1])],
        joints=[
            Pin(name="shaft 1", first=ground_point(), second=body_point("first")),
            Pin(name="shaft 2", first=ground_point(0.5), second=body_point("second")),
        ],
        readings=[body_angle("first"), body_angle("second")],
        sketch=[(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)],
        loads=[Torque(name="motor", first="first", second="second", moment=STEPPED_PROGRAM)],
        size=0.5,
    )

    def exact(times):
        _, single, double = stepped_program_integrals(times)
        return {"first": (-double / inertias[0], -single / inertias[0]), "second": (double / inertias[1], single / inertias[1])}

    return ExactCase(scene=scene, exact=exact)


def mass_under_a_force(*, constant: bool) -> ExactCase:
    """A mass on an inclined rail under a force of two parts, constant or one of them in time with a step."""
    mass, lean, upward = 1.5, 0.4, 7.0
    along = InputFunction(values=(3.0,)) if constant else STEPPED_PROGRAM
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[Slider(name="rail", first=ground_point(), second=body_point("mass"), angle=lean)],
        readings=[x_reading("mass"), y_reading("mass")],
        sketch=[(0.0, 0.0, 0.0)],
        loads=[Force(name="push", point=body_point("mass"), x=along, y=InputFunction(values=(upward,)))],
        size=0.5,
    )

    def exact(times):
        single, double = (3.0 * times, 1.5 * times**2) if constant else stepped_program_integrals(times)[1:]
        rising = (upward / mass - GRAVITY) * math.sin(lean)
        way = math.cos(lean) / mass * double + rising * times**2 / 2
        rate = math.cos(lean) / mass * single + rising * times
        return {"x": (math.cos(lean) * way, math.cos(lean) * rate), "y": (math.sin(lean) * way, math.sin(lean) * rate)}

    return ExactCase(scene=scene, exact=exact, order=NO_ERROR if constant else SECOND_ORDER)


def pushed_plate(*, carried: bool) -> ExactCase:
    """A plate with a force off its centre that keeps its direction as the plate turns: on a trolley, or free of joints.

    The trolley takes up what moves the plate up or down.
    """
    mass, inertia, trolley, hook, upward = 1.5, 0.05, 0.8, 0.2 + 0.1j, 4.0
    joints = [
        Slider(name="rail", first=ground_point(0.0, 0.2), second=body_point("trolley"), angle=0.0),
        Pin(name="bearing", first=body_point("trolley"), second=body_point("plate")),
    ]
    scene = make_scene(
        bodies=[rotating_body("plate", mass, inertia), *([point_mass("trolley", trolley)] if carried else [])],
        joints=joints if carried else [],
        readings=[body_angle("plate", "turn"), x_reading("plate"), y_reading("plate")],
        sketch=[(0.1, 0.2, 0.4), *([(0.1, 0.2, 0.0)] if carried else [])],
        loads=[Force(name="push", point=body_point("plate", hook.real, hook.imag), x=STEPPED_PROGRAM, y=InputFunction(values=(upward,)))],
        rates={"turn": 1.0, "x": 0.2, **({} if carried else {"y": -0.1})},
        size=0.5,
    )
    before, after = (PchipInterpolator(STEPPED_PROGRAM.times[side], STEPPED_PROGRAM.values[side]) for side in (slice(3), slice(3, 6)))

    def slope(time, state, push):
        arm = hook * np.exp(1j * state[0])
        return [state[1], (arm.real * upward - arm.imag * push(min(time, 0.9))) / inertia]

    def exact(times):
        early, late = times[times <= 0.45], times[times > 0.45]
        first = integrate_state(lambda t, y: slope(t, y, before), (0.4, 1.0), np.append(early, 0.45))
        kinks = [at - 0.45 for at in (0.7, 0.9)]
        second = integrate_state(lambda t, y: slope(t + 0.45, y, after), first[:, -1], late - 0.45, breaks=kinks)
        turn, rate = np.concatenate([first[:, :-1], second], axis=1)
        _, single, double = stepped_program_integrals(times)
        moved = mass + trolley if carried else mass
        start, fall = (0.0, 0.0) if carried else (-0.1, upward / mass - GRAVITY)
        return {
            "turn": (turn, rate),
            "x": (0.1 + 0.2 * times + double / moved, 0.2 + single / moved),
            "y": (0.2 + start * times + fall * times**2 / 2, start + fall * times),
        }

    return ExactCase(scene=scene, exact=exact)


CASES: dict[str, Callable[[], ExactCase]] = {
    "pin to the ground": pendulum_on_a_pin,
    "pin between bodies": pendulum_on_a_trolley,
    "weld": bent_pendulum,
    "distance": mass_on_a_link,
    "slider on a turning body": bead_on_a_turning_rod,
    "slider with its point in the ground": rod_through_a_swivel,
    "prismatic on a turning body": collar_on_a_turning_rod,
    "arc slot in the ground": bead_in_a_round_slot,
    "arc slot in a moving body": bead_in_a_round_slot_of_a_pendulum,
    "parabola": bead_on_a_parabola,
    "table of a parabola": bead_on_a_table_of_the_parabola,
    "curve on a turning body": bead_on_a_turning_curve,
    "gear under a torque": geared_wheels,
    "gear with a pendulum": geared_pendulum,
    "rack": falling_rack,
    "driven turn": driven_slider_crank,
    "driven turn by a table": slider_crank_driven_by_a_table,
    "driven turn, the ground second": counterweight_driven_backwards,
    "driven slide by a table": pendulum_on_a_driven_support,
    "driven slide on a turning body": bead_driven_along_a_turning_rod,
    "spring": hanging_spring,
    "spring between bodies": spring_between_two_masses,
    "spring that turns": spring_across_a_pendulum,
    "damper, weak": lambda: damped_mass(0.2),
    "damper, critical": lambda: damped_mass(1.0),
    "damper, strong": lambda: damped_mass(1.7),
    "damper that turns": damper_across_a_pendulum,
    "torsion spring": torsion_pendulum,
    "torsion damper": lambda: torsion_pendulum(0.4),
    "torsion spring and damper between bodies": two_wheels_on_one_wire,
    "torque, constant": lambda: wheel_under_a_torque(constant=True),
    "torque in time": lambda: wheel_under_a_torque(constant=False),
    "torque between bodies": torque_between_two_wheels,
    "force, constant": lambda: mass_under_a_force(constant=True),
    "force in time": lambda: mass_under_a_force(constant=False),
    "force off centre": lambda: pushed_plate(carried=True),
    "force off centre, no joints": lambda: pushed_plate(carried=False),
}
"""By what they are about."""
