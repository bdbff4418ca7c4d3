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
from governor_mechanism.model.curves import Curve, Polynomial, Table
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    DrivenSlide,
    DrivenTurn,
    Gear,
    Pin,
    Point,
    Prismatic,
    Rack,
    Slider,
    Weld,
)
from governor_mechanism.model.mechanism import Body, BodyAngle, Coordinate, Mechanism, SecondMoments, Separation
from governor_mechanism.model.scene import FIXED, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.model.time_functions import Motion, Program
from governor_mechanism.types import FloatArray

Told = dict[str, tuple[FloatArray, FloatArray]]
"""By the name of a reading: its values (n,) and rates (n,)."""

G = 9.81
SECOND_ORDER, NO_ERROR = "second order", "no error"


@dataclass(frozen=True, kw_only=True)
class Case:
    """A scene; what its readings are at times (n,) s; the longest step (s) at which an order shows, and which order.

    impulse is False where the impulse engine has no such joint.
    """

    scene: Scene
    exact: Callable[[FloatArray], Told]
    step: float = 0.005
    order: str = SECOND_ORDER
    impulse: bool = True


# --- the parts of a scene ---------------------------------------------------------------------------------------------


def make_scene(
    *, bodies, joints, readings, sketch, loads=(), values=None, rates=None, gravity=G, size=1.0, duration=1.0, every=0.1
) -> Scene:
    """A scene of one mechanism in a plane that stands still."""
    mechanism = Mechanism(
        bodies=tuple(bodies),
        joints=tuple(joints),
        readings=tuple(readings),
        coordinate=readings[0].name,
        size=size,
        sketch=tuple(sketch),
        loads=tuple(loads),
    )
    return Scene(
        title="test",
        parts=(Part(name="mechanism", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED),),
        effects=(Gravity(acceleration=gravity),) if gravity else (),
        spindle=Spindle(),
        start=Start(values=values or {}, rates=rates or {}),
        run=RunSettings(duration=duration, every=every, accuracy=1e-6),
    )


def on(body: str, x: float = 0.0, y: float = 0.0) -> Point:
    """A point of a body."""
    return Point(body=body, x=x, y=y)


def fixed(x: float = 0.0, y: float = 0.0) -> Point:
    """A point of the ground."""
    return Point(body=GROUND, x=x, y=y)


def turning(name: str, mass: float, inertia: float) -> Body:
    """A body of this moment of inertia about its mass centre."""
    return Body(name=name, mass=mass, moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rod(name: str, mass: float, length: float) -> Body:
    """A uniform slender rod along its x axis."""
    return Body(name=name, mass=mass, moments=SecondMoments(xx=mass * length**2 / 12))


def bead(name: str, mass: float) -> Body:
    """A mass in one point."""
    return Body(name=name, mass=mass, turns=False)


def angle_of(body: str, name: str = "") -> BodyAngle:
    """How far a body has turned, by its own name."""
    return BodyAngle(name=name or body, quantity="angle", body=body)


def x_of(body: str, name: str = "x", zero: float = 0.0) -> Coordinate:
    """Where the mass centre of a body is, in x."""
    return Coordinate(name=name, quantity="length", point=on(body), along_x=1.0, along_y=0.0, zero=zero)


def y_of(body: str, name: str = "y") -> Coordinate:
    """Where the mass centre of a body is, in y."""
    return Coordinate(name=name, quantity="length", point=on(body), along_x=0.0, along_y=1.0)


# --- independent answers ----------------------------------------------------------------------------------------------


def follow(slope: Callable, start, times: FloatArray, breaks=()) -> FloatArray:
    """A state (numbers, n) at the times, by scipy at its tightest, split where the right-hand side has breaks."""
    state, found = np.array(start, dtype=np.float64), np.empty((len(start), len(times)))
    found[:, times == 0.0] = state[:, np.newaxis]
    knots = [0.0, *(float(at) for at in breaks if 0 < at < times[-1]), float(times[-1])]
    for begin, end in pairwise(knots):
        mine = (times > begin) & (times <= end)
        wanted = np.unique(np.append(times[mine], end))
        piece = solve_ivp(slope, (begin, end), state, method="DOP853", t_eval=wanted, rtol=1e-13, atol=1e-15)
        found[:, mine] = piece.y[:, : int(mine.sum())]
        state = piece.y[:, -1]
    return found


def released(times: FloatArray, square: float, start: float) -> tuple[FloatArray, FloatArray]:
    """Angle and rate of a pendulum of small-swing frequency sqrt(square), let go at `start` from rest (Jacobi's sn)."""
    modulus = math.sin(start / 2)
    fast = math.sqrt(square)
    sn, cn, dn, _ = ellipj(ellipk(modulus**2) + fast * times, modulus**2)
    return 2 * np.arcsin(modulus * sn), 2 * modulus * fast * cn * dn / np.sqrt(1 - (modulus * sn) ** 2)


def of_one_coordinate(inertia: Callable, push: Callable, start, times: FloatArray) -> FloatArray:
    """Coordinate and rate (2, n): inertia(q) gives J and dJ/dq, push(q, rate) the generalised force."""

    def slope(_, state):
        whole, change = inertia(state[0])
        return [state[1], (push(*state) - 0.5 * change * state[1] ** 2) / whole]

    return follow(slope, start, times)


def hung_on_a_trolley(trolley: float, mass: float, length: float, inertia: float, start: float) -> Callable:
    """A pendulum on a free trolley: angle from below, and the trolley's way from where both centres balance."""

    def of_angle(q):
        off = mass * length * np.cos(q)
        whole = inertia + mass * length**2 - off**2 / (trolley + mass)
        return whole, 2 * off * mass * length * np.sin(q) / (trolley + mass)

    def exact(times):
        q, rate = of_one_coordinate(of_angle, lambda q, _: -mass * G * length * np.sin(q), (start, 0.0), times)
        share = mass * length / (trolley + mass)
        way = -share * (np.sin(q) - math.sin(start))  # the common centre stays where it was in x
        return {"angle": (q, rate), "x": (way, -share * np.cos(q) * rate)}

    return exact


def on_a_turning_path(inertia: float, mass: float, path: Callable, start) -> Callable:
    """A mass on a path(s) of a body that turns about its origin, free of loads: path gives place, slope and bend.

    start: the body's angle and rate, s and its rate. Lagrange's equations of T = (I + m p.p) w^2/2 + m p'.p' v^2/2
    + m (p x p') w v. The readings are 'turn' and 'way'.
    """

    def slope(_, state):
        _, w, s, v = state
        place, along, bend = (np.array(vector) for vector in path(s))
        cross, growth = _cross(place, along), _cross(place, bend)
        matrix = mass * np.array([[inertia / mass + place @ place, cross], [cross, along @ along]])
        right = -mass * np.array(
            [2 * (place @ along) * v * w + growth * v**2, (along @ bend) * v**2 - (place @ along) * w**2]
        )
        bends = np.linalg.solve(matrix, right)
        return [w, bends[0], v, bends[1]]

    def exact(times):
        turn, w, way, v = follow(slope, start, times)
        return {"turn": (turn, w), "way": (way, v)}

    return exact


def _cross(first, second):
    return first[0] * second[1] - first[1] * second[0]


def straight(angle: float, aside: float) -> Callable:
    """A straight path at `angle`, whose nearest point to the origin lies `aside` of it."""
    u, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    return lambda s: (s * u + aside * n, u, 0 * u)


@dataclass(frozen=True)
class SliderCrank:
    """Crank at the origin, connecting rod of uniform mass, piston on the x axis: all of it by the crank's angle."""

    crank: float
    rod: float
    rod_mass: float
    piston_mass: float

    def piston(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Way of the piston and its two derivatives by the crank's angle."""
        lean, lean1, lean2 = self.lean(q)
        r, length = self.crank, self.rod
        return (
            r * np.cos(q) + length * np.cos(lean),
            -r * np.sin(q) - length * np.sin(lean) * lean1,
            -r * np.cos(q) - length * (np.cos(lean) * lean1**2 + np.sin(lean) * lean2),
        )

    def lean(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle of the rod, and its two derivatives."""
        sine, cosine = np.sin(q), np.cos(q)
        r, drop = self.crank, np.sqrt(self.rod**2 - self.crank**2 * np.sin(q) ** 2)
        return -np.arcsin(r * sine / self.rod), -r * cosine / drop, r * sine / drop - r**3 * sine * cosine**2 / drop**3

    def torque(self, q: FloatArray, rate: FloatArray, bend: FloatArray, crank_inertia: float) -> FloatArray:
        """What turns the crank (N m), by virtual work: mass times acceleration, and weight, along the motion."""
        lean, lean1, lean2 = self.lean(q)
        half = self.rod / 2
        middle1 = self.crank * 1j * np.exp(1j * q) + half * 1j * lean1 * np.exp(1j * lean)
        middle2 = -self.crank * np.exp(1j * q) + half * (1j * lean2 - lean1**2) * np.exp(1j * lean)
        middle = middle2 * rate**2 + middle1 * bend
        _, way1, way2 = self.piston(q)
        inertia = self.rod_mass * self.rod**2 / 12
        return (
            crank_inertia * bend
            + self.rod_mass * ((middle + 1j * G) * middle1.conj()).real
            + inertia * (lean2 * rate**2 + lean1 * bend) * lean1
            + self.piston_mass * (way2 * rate**2 + way1 * bend) * way1
        )


# --- pins, welds, links -----------------------------------------------------------------------------------------------


def pendulum_on_a_pin() -> Case:
    """A rod hung from its end."""
    mass, length, start = 2.0, 0.8, 2.0
    scene = make_scene(
        bodies=[rod("rod", mass, length)],
        joints=[Pin(name="hinge", first=fixed(0.1, 0.2), second=on("rod", -length / 2))],
        readings=[BodyAngle(name="rod", quantity="angle", body="rod")],
        sketch=[(0.1 + length / 2, 0.2, 0.0)],
        values={"rod": start - math.pi / 2},
        size=length,
    )

    def exact(times):
        angle, rate = released(times, 1.5 * G / length, start)
        return {"rod": (angle - math.pi / 2, rate)}

    return Case(scene=scene, exact=exact)


def pendulum_on_a_trolley() -> Case:
    """A rod pinned to a trolley that runs freely: a pin between bodies that both move, its ends named the other way."""
    length, start = 0.6, 1.3
    scene = make_scene(
        bodies=[bead("trolley", 3.0), rod("rod", 2.0, length)],
        joints=[
            Slider(name="rail", first=fixed(), second=on("trolley"), angle=0.0),
            Pin(name="hinge", first=on("rod", y=length / 2), second=on("trolley")),
        ],
        readings=[angle_of("rod", "angle"), x_of("trolley")],
        sketch=[(0.0, 0.0, 0.0), (0.0, -length / 2, 0.0)],
        values={"angle": start, "x": 0.0},
        size=length,
    )
    # The rod lies along its y axis here, hence the moment of a rod all the same: only xx + yy counts.
    return Case(scene=scene, exact=hung_on_a_trolley(3.0, 2.0, length / 2, 2.0 * length**2 / 12, start))


def bent_pendulum(turn: float = 0.7) -> Case:
    """Two rods welded at an angle are one pendulum."""
    first, second, lengths, start = 2.0, 1.5, (0.5, 0.4), 1.1
    # Mass times mass centre from the pin, in the axes of the first rod, and the inertia about the pin.
    tip = lengths[0] + np.exp(1j * turn) * lengths[1] / 2
    moment = first * lengths[0] / 2 + second * tip
    inertia = first * lengths[0] ** 2 / 3 + second * (lengths[1] ** 2 / 12 + abs(tip) ** 2)
    hanging = -math.pi / 2 - np.angle(moment)  # angle of the first rod when the whole hangs straight
    scene = make_scene(
        bodies=[rod("first", first, lengths[0]), rod("second", second, lengths[1])],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("first", -lengths[0] / 2)),
            Weld(name="weld", first=on("first", lengths[0] / 2), second=on("second", -lengths[1] / 2), turn=turn),
        ],
        readings=[angle_of("first"), angle_of("second")],
        sketch=[(lengths[0] / 2, 0.0, 0.0), (tip.real, tip.imag, turn)],
        values={"first": hanging + start},
        size=sum(lengths),
    )

    def exact(times):
        angle, rate = released(times, abs(moment) * G / inertia, start)
        return {"first": (hanging + angle, rate), "second": (hanging + angle + turn, rate)}

    return Case(scene=scene, exact=exact)


def mass_on_a_link() -> Case:
    """A mass on a massless link from a trolley that runs freely."""
    length, start = 0.5, 1.2
    scene = make_scene(
        bodies=[bead("trolley", 2.0), bead("bob", 1.5)],
        joints=[
            Slider(name="rail", first=fixed(), second=on("trolley"), angle=0.0),
            Distance(name="link", first=on("trolley"), second=on("bob"), length=length),
        ],
        readings=[x_of("trolley"), x_of("bob", "bob_x"), y_of("bob", "bob_y")],
        sketch=[(0.0, 0.0, 0.0), (length * math.sin(start), -length * math.cos(start), 0.0)],
        size=length,
    )
    inner = hung_on_a_trolley(2.0, 1.5, length, 0.0, start)

    def exact(times):
        told = inner(times)
        (q, rate), (x, u) = told["angle"], told["x"]
        return {
            "x": (x, u),
            "bob_x": (x + length * np.sin(q), u + length * np.cos(q) * rate),
            "bob_y": (-length * np.cos(q), length * np.sin(q) * rate),
        }

    return Case(scene=scene, exact=exact)


# --- guides -----------------------------------------------------------------------------------------------------------


def bead_on_a_turning_rod(angle: float = 0.3, aside: float = 0.1) -> Case:
    """A mass on a straight line of a rod that turns freely about a pin; the line passes the pin at a distance."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    n = -aside * math.sin(angle), aside * math.cos(angle)
    scene = make_scene(
        bodies=[rod("rod", mass, length), bead("bead", 0.7)],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("rod", -length / 2)),
            Slider(name="bore", first=on("rod", n[0] - length / 2, n[1]), second=on("bead"), angle=angle),
        ],
        readings=[angle_of("rod", "turn"), _along("way", "rod", "bead", -length / 2, angle)],
        sketch=[(length / 2, 0.0, 0.0), (n[0] + 0.35 * math.cos(angle), n[1] + 0.35 * math.sin(angle), 0.0)],
        values={"turn": start[0], "way": start[2]},
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=length,
    )
    return Case(scene=scene, exact=on_a_turning_path(mass * length**2 / 3, 0.7, straight(angle, aside), start))


def collar_on_a_turning_rod(angle: float = 0.3, turn: float = 0.5) -> Case:
    """A collar with inertia of its own on such a rod, turning with it; its mass centre beside the line and ahead."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    collar, inertia, ahead, aside = 0.7, 0.02, 0.06, 0.09
    point = -np.exp(-1j * (turn - angle)) * (ahead + 1j * aside)  # the guided point in the collar's axes
    place = np.exp(1j * angle) * (0.35 + ahead + 1j * aside)
    scene = make_scene(
        bodies=[rod("rod", mass, length), turning("collar", collar, inertia)],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("rod", -length / 2)),
            Prismatic(
                name="bore",
                first=on("rod", -length / 2),
                second=on("collar", point.real, point.imag),
                angle=angle,
                turn=turn,
            ),
        ],
        readings=[
            angle_of("rod", "turn"),
            _along("way", "rod", "collar", -length / 2, angle, ahead),
            angle_of("collar"),
        ],
        sketch=[(length / 2, 0.0, 0.0), (place.real, place.imag, turn)],
        values={"turn": start[0], "way": start[2]},
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=length,
    )
    u, d = np.array([math.cos(angle), math.sin(angle)]), np.exp(1j * angle) * (ahead + 1j * aside)

    def path(s):
        return s * u + np.array([d.real, d.imag]), u, 0 * u

    inner = on_a_turning_path(mass * length**2 / 3 + inertia, collar, path, start)

    def exact(times):
        told = inner(times)
        return {**told, "collar": (told["turn"][0] + turn, told["turn"][1])}

    return Case(scene=scene, exact=exact)


def _along(name: str, body: str, point: str, x: float, angle: float, zero: float = 0.0) -> Coordinate:
    """How far a body's mass centre is along a direction of another body, from its point (x, 0)."""
    return Coordinate(
        name=name,
        quantity="length",
        point=on(point),
        origin=on(body, x),
        along_x=math.cos(angle),
        along_y=math.sin(angle),
        zero=zero,
    )


def rod_through_a_swivel() -> Case:
    """A rod that slides through a swivel which stands still: the line is the rod's, the point on it the ground's."""
    mass, inertia, start = 1.4, 0.06, (0.2, 0.5, -0.4, 1.5)
    scene = make_scene(
        bodies=[turning("rod", mass, inertia)],
        joints=[Slider(name="swivel", first=on("rod"), second=fixed(), angle=0.0)],
        readings=[
            angle_of("rod", "turn"),
            Coordinate(name="way", quantity="length", point=fixed(), origin=on("rod"), along_x=-1.0, along_y=0.0),
        ],
        sketch=[(start[0] * math.cos(start[2]), start[0] * math.sin(start[2]), start[2])],
        rates={"turn": start[3], "way": start[1]},
        size=0.5,
        duration=0.6,
    )

    def slope(_, state):
        way, speed, turn, rate = state
        twist = -mass * way * (2 * speed * rate + G * math.cos(turn)) / (inertia + mass * way**2)
        return [speed, way * rate**2 - G * math.sin(turn), rate, twist]

    def exact(times):
        way, speed, turn, rate = follow(slope, start, times)
        return {"turn": (turn, rate), "way": (way, speed)}

    return Case(scene=scene, exact=exact)


def bead_in_a_round_slot() -> Case:
    """A mass in a slot of the ground, an arc about a point: a pendulum of that radius."""
    radius, start = 0.4, 2.2
    scene = make_scene(
        bodies=[bead("bead", 1.3)],
        joints=[ArcSlot(name="slot", first=fixed(0.2, 0.1), second=on("bead"), radius=radius)],
        readings=[x_of("bead"), y_of("bead")],
        sketch=[(0.2 + radius * math.sin(start), 0.1 - radius * math.cos(start), 0.0)],
        size=radius,
    )

    def exact(times):
        q, rate = released(times, G / radius, start)
        return {
            "x": (0.2 + radius * np.sin(q), radius * np.cos(q) * rate),
            "y": (0.1 - radius * np.cos(q), radius * np.sin(q) * rate),
        }

    return Case(scene=scene, exact=exact)


def bead_in_a_round_slot_of_a_pendulum() -> Case:
    """The slot in a plate that swings about a pin: a double pendulum, in its two angles from below."""
    plate, mass, inertia, centre, slot, radius = 2.0, 0.8, 0.05, 0.25, 0.4, 0.2
    start = (0.6, 0.0, -0.5, 0.0)
    knee = slot * math.sin(start[0]), -slot * math.cos(start[0])
    hung = (centre * math.sin(start[0]), -centre * math.cos(start[0]), start[0])
    scene = make_scene(
        bodies=[turning("plate", plate, inertia), bead("bead", mass)],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("plate", y=centre)),
            ArcSlot(name="slot", first=on("plate", y=centre - slot), second=on("bead"), radius=radius),
        ],
        readings=[angle_of("plate"), x_of("bead"), y_of("bead")],
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
            -twist * v**2 - (plate * centre + mass * slot) * G * math.sin(p),
            twist * u**2 - mass * G * radius * math.sin(q),
        ]
        bends = np.linalg.solve([[whole, coupling], [coupling, mass * radius**2]], right)
        return [u, bends[0], v, bends[1]]

    def exact(times):
        p, u, q, v = follow(slope, start, times)
        return {
            "plate": (p, u),
            "x": (slot * np.sin(p) + radius * np.sin(q), slot * np.cos(p) * u + radius * np.cos(q) * v),
            "y": (-slot * np.cos(p) - radius * np.cos(q), slot * np.sin(p) * u + radius * np.sin(q) * v),
        }

    return Case(scene=scene, exact=exact)


STEEPNESS = 1.5


def bead_on_a_parabola(curve: Curve | None = None) -> Case:
    """A bead on y = a x^2, by the curve itself or by a table of its points."""
    start = 0.6
    scene = make_scene(
        bodies=[bead("bead", 0.9)],
        joints=[
            CurveSlot(
                name="wire",
                first=fixed(),
                second=on("bead"),
                curve=curve or Polynomial(coefficients=(0.0, 0.0, STEEPNESS)),
            )
        ],
        readings=[x_of("bead"), y_of("bead")],
        sketch=[(start, STEEPNESS * start**2, 0.0)],
        values={"x": start},
        size=0.5,
    )

    def inertia(x):
        return 1 + 4 * STEEPNESS**2 * x**2, 8 * STEEPNESS**2 * x

    def exact(times):
        x, rate = of_one_coordinate(inertia, lambda x, _: -2 * G * STEEPNESS * x, (start, 0.0), times)
        return {"x": (x, rate), "y": (STEEPNESS * x**2, 2 * STEEPNESS * x * rate)}

    return Case(scene=scene, exact=exact)


def bead_on_a_table_of_the_parabola() -> Case:
    """A cubic spline through points of a parabola is that parabola: third differences vanish at its ends too."""
    x = np.linspace(-0.8, 0.8, 33)
    return bead_on_a_parabola(Table(x=tuple(x.tolist()), y=tuple((STEEPNESS * x**2).tolist())))


def bead_on_a_turning_curve(angle: float = -0.4) -> Case:
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
        bodies=[turning("cam", 2.0, inertia), bead("bead", mass)],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("cam")),
            CurveSlot(
                name="groove",
                first=on("cam", x, y),
                second=on("bead"),
                curve=Polynomial(coefficients=coefficients),
                angle=angle,
            ),
        ],
        readings=[
            angle_of("cam", "turn"),
            Coordinate(
                name="way",
                quantity="length",
                point=on("bead"),
                origin=on("cam", x, y),
                along_x=math.cos(angle),
                along_y=math.sin(angle),
            ),
        ],
        sketch=[(0.0, 0.0, start[0]), (first.real, first.imag, 0.0)],
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=0.5,
    )
    return Case(scene=scene, exact=on_a_turning_path(inertia, mass, path, start))


# --- gears and racks --------------------------------------------------------------------------------------------------


def _wheels(off: float, values: Mapping[str, float], torque: float, ratio: float, offset: float) -> Scene:
    start = values["first"]
    turned = ratio * start + offset
    return make_scene(
        bodies=[turning("first", 3.0, 0.04), turning("second", 5.0, 0.3)],
        joints=[
            Pin(name="shaft 1", first=fixed(), second=on("first")),
            Pin(name="shaft 2", first=fixed(0.6), second=on("second", y=off)),
            Gear(name="teeth", first=on("first"), second=on("second"), ratio=ratio, offset=offset),
        ],
        readings=[angle_of("first"), angle_of("second")],
        sketch=[(0.0, 0.0, start), (0.6 + off * math.sin(turned), -off * math.cos(turned), turned)],
        loads=[Torque(name="motor", second="first", moment=Program(values=(torque,)))] if torque else [],
        values=values,
        size=0.5,
    )


def geared_wheels() -> Case:
    """Two wheels in mesh with a torque on one: its own inertia and the other's, times the ratio squared."""
    ratio, offset, torque = -0.5, 0.4, 0.6
    scene = _wheels(0.0, {"first": 0.1}, torque, ratio, offset)
    bend = torque / (0.04 + ratio**2 * 0.3)

    def exact(times):
        angle, rate = 0.1 + bend * times**2 / 2, bend * times
        return {"first": (angle, rate), "second": (ratio * angle + offset, ratio * rate)}

    return Case(scene=scene, exact=exact, order=NO_ERROR)


def geared_pendulum() -> Case:
    """The second wheel's mass centre lies off its shaft, so that it swings and takes the first one along."""
    ratio, offset, off, start = -0.5, 0.4, 0.15, 1.7
    scene = _wheels(off, {"first": (start - offset) / ratio}, 0.0, ratio, offset)
    inertia = 0.3 + 5.0 * off**2 + 0.04 / ratio**2

    def exact(times):
        angle, rate = released(times, 5.0 * G * off / inertia, start)
        return {"second": (angle, rate), "first": ((angle - offset) / ratio, rate / ratio)}

    return Case(scene=scene, exact=exact)


def falling_rack(lean: float = 1.2) -> Case:
    """A rack slides down a steep guide and turns a pinion, which is the heavier for it."""
    radius, inertia, mass, offset = -0.1, 0.03, 2.0, 0.05
    ahead = offset - 0.1 * math.cos(lean)  # of the guide's foot, at angle 0, where the way from the pinion is `offset`
    scene = make_scene(
        bodies=[turning("pinion", 1.0, inertia), bead("rack", mass)],
        joints=[
            Pin(name="shaft", first=fixed(), second=on("pinion")),
            Slider(name="guide", first=fixed(0.1), second=on("rack"), angle=lean),
            Rack(name="teeth", first=on("pinion"), second=on("rack"), radius=radius, angle=lean, offset=offset),
        ],
        readings=[angle_of("pinion"), y_of("rack")],
        sketch=[(0.0, 0.0, 0.0), (0.1 + ahead * math.cos(lean), ahead * math.sin(lean), 0.0)],
        values={"pinion": 0.0},
        size=0.2,
        duration=0.5,
    )
    bend = -G * math.sin(lean) / (1 + inertia / (mass * radius**2))  # along the guide

    def exact(times):
        way, speed = bend * times**2 / 2, bend * times
        return {"pinion": (way / radius, speed / radius), "y": ((ahead + way) * math.sin(lean), speed * math.sin(lean))}

    return Case(scene=scene, exact=exact, impulse=False)


# --- drives -----------------------------------------------------------------------------------------------------------

ENGINE = SliderCrank(crank=0.1, rod=0.35, rod_mass=1.2, piston_mass=2.0)
CRANK_INERTIA = 0.02


def _slider_crank(motion: Motion, start: float, duration: float) -> Scene:
    pin = ENGINE.crank * np.exp(1j * start)
    lean = float(ENGINE.lean(np.array(start))[0])
    middle = pin + np.exp(1j * lean) * ENGINE.rod / 2
    return make_scene(
        bodies=[
            turning("crank", 4.0, CRANK_INERTIA),
            rod("rod", ENGINE.rod_mass, ENGINE.rod),
            bead("piston", ENGINE.piston_mass),
        ],
        joints=[
            Pin(name="shaft", first=fixed(), second=on("crank")),
            Pin(name="crank pin", first=on("crank", ENGINE.crank), second=on("rod", -ENGINE.rod / 2)),
            Pin(name="cross head", first=on("rod", ENGINE.rod / 2), second=on("piston")),
            Slider(name="guide", first=fixed(), second=on("piston"), angle=0.0),
            DrivenTurn(name="drive", first=fixed(), second=on("crank"), motion=motion),
        ],
        readings=[angle_of("crank"), x_of("piston"), angle_of("rod")],
        sketch=[
            (0.0, 0.0, start),
            (middle.real, middle.imag, lean),
            (float(ENGINE.piston(np.array(start))[0]), 0.0, 0.0),
        ],
        size=ENGINE.rod,
        duration=duration,
        every=duration / 20,
    )


def _told_of_crank(angle: FloatArray, rate: FloatArray) -> Told:
    way, way1, _ = ENGINE.piston(angle)
    lean, lean1, _ = ENGINE.lean(angle)
    return {"crank": (angle, rate), "x": (way, way1 * rate), "rod": (lean, lean1 * rate)}


def driven_slider_crank() -> Case:
    """A crank driven at a constant rate."""
    start, rate = 0.3, 12.0
    scene = _slider_crank(Motion.steady(start, rate), start, 0.6)
    return Case(
        scene=scene, exact=lambda times: _told_of_crank(start + rate * times, np.full_like(times, rate)), step=0.0025
    )


TABLE = ((0.0, 0.15, 0.3, 0.5, 0.6), (0.3, 1.0, 2.4, 2.9, 2.2))


def crank_motion(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The natural spline through the table: values, rates, second derivatives."""
    spline = CubicSpline(*TABLE, bc_type="natural")
    return spline(times), spline(times, 1), spline(times, 2)


def slider_crank_driven_by_a_table() -> Case:
    """The same crank driven through a few points, which a natural spline joins."""
    scene = _slider_crank(Motion(times=TABLE[0], values=TABLE[1]), TABLE[1][0], 0.6)
    return Case(scene=scene, exact=lambda times: _told_of_crank(*crank_motion(times)[:2]), step=0.0025)


def pendulum_on_a_driven_support() -> Case:
    """A rod hung from a support that a drive moves to and fro, as a table of many points says."""
    length, mass, start = 0.6, 1.5, 0.4
    at = np.linspace(0.0, 1.2, 25)
    way = 0.05 * np.sin(9.0 * at)
    scene = make_scene(
        bodies=[bead("support", 2.0), rod("rod", mass, length)],
        joints=[
            Slider(name="rail", first=fixed(), second=on("support"), angle=0.0),
            DrivenSlide(
                name="drive",
                first=fixed(-0.2),
                second=on("support"),
                angle=0.0,
                motion=Motion(times=tuple(at.tolist()), values=tuple((0.2 + way).tolist())),
            ),
            Pin(name="hinge", first=on("support"), second=on("rod", y=length / 2)),
        ],
        readings=[angle_of("rod"), x_of("support")],
        sketch=[(0.0, 0.0, 0.0), (length / 2 * math.sin(start), -length / 2 * math.cos(start), start)],
        values={"rod": start},
        rates={"rod": 0.0},
        size=length,
        duration=1.2,
    )
    spline = CubicSpline(at, way, bc_type="natural")

    def slope(time, state):
        lean = G * math.sin(state[0]) + float(spline(time, 2)) * math.cos(state[0])
        return [state[1], -lean / (2 * length / 3)]

    def exact(times):
        angle, rate = follow(slope, (start, 0.0), times, breaks=at)
        return {"rod": (angle, rate), "x": (spline(times), spline(times, 1))}

    return Case(scene=scene, exact=exact)


def counterweight_driven_backwards() -> Case:
    """A drive told from a wheel to the ground: the ground's angle less the wheel's, which therefore turns back."""
    speed = 4.0
    scene = make_scene(
        bodies=[turning("wheel", 3.0, 0.1), bead("bob", 1.0)],
        joints=[
            Pin(name="shaft", first=on("wheel", y=0.1), second=fixed()),
            DrivenTurn(name="drive", first=on("wheel"), second=fixed(), motion=Motion.steady(0.3, speed)),
            Slider(name="bore", first=on("wheel", y=0.1), second=on("bob"), angle=0.0),
        ],
        readings=[angle_of("wheel"), Separation(name="way", quantity="length", first=fixed(), second=on("bob"))],
        sketch=[(-0.1 * math.sin(0.3), -0.1 * math.cos(0.3), -0.3), (0.2 * math.cos(0.3), -0.2 * math.sin(0.3), 0.0)],
        rates={"way": 0.4},
        size=0.5,
        duration=0.4,
        every=0.05,
    )

    def slope(time, state):
        return [state[1], state[0] * speed**2 + G * math.sin(0.3 + speed * time)]

    def exact(times):
        way, rate = follow(slope, (0.2, 0.4), times)
        return {"wheel": (-0.3 - speed * times, np.full_like(times, -speed)), "way": (way, rate)}

    return Case(scene=scene, exact=exact)


def bead_driven_along_a_turning_rod() -> Case:
    """A drive moves a bead outward on a rod that turns freely: it slows as its moment of inertia grows."""
    inertia, mass, rate, first, speed = 0.5, 1.5, 3.0, 0.2, 0.6
    scene = make_scene(
        bodies=[turning("rod", 2.0, inertia), bead("bead", mass)],
        joints=[
            Pin(name="hinge", first=fixed(), second=on("rod")),
            Slider(name="bore", first=on("rod"), second=on("bead"), angle=0.0),
            DrivenSlide(
                name="drive", first=on("rod"), second=on("bead"), angle=0.0, motion=Motion.steady(first, speed)
            ),
        ],
        readings=[angle_of("rod", "turn"), Separation(name="way", quantity="length", first=fixed(), second=on("bead"))],
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

    return Case(scene=scene, exact=exact)


# --- springs and dampers ----------------------------------------------------------------------------------------------


def hanging_spring() -> Case:
    """A mass on a spring, guided straight down."""
    mass, stiffness, free, start = 1.2, 90.0, 0.3, -0.5
    scene = make_scene(
        bodies=[bead("mass", mass)],
        joints=[Slider(name="guide", first=fixed(0.1), second=on("mass"), angle=math.pi / 2)],
        readings=[y_of("mass")],
        sketch=[(0.1, start, 0.0)],
        loads=[Spring(name="spring", first=fixed(0.1), second=on("mass"), stiffness=stiffness, free_length=free)],
        size=free,
    )
    rest, fast = -free - mass * G / stiffness, math.sqrt(stiffness / mass)

    def exact(times):
        swing = start - rest
        return {"y": (rest + swing * np.cos(fast * times), -swing * fast * np.sin(fast * times))}

    return Case(scene=scene, exact=exact)


def spring_between_two_masses() -> Case:
    """Two bodies on one rail that do not turn, with a spring from off-centre points of each: swing and drift."""
    masses, stiffness, free, speeds = (1.0, 2.5), 60.0, 0.3, (0.4, -0.3)
    scene = make_scene(
        bodies=[bead("left", masses[0]), bead("right", masses[1])],
        joints=[Slider(name=f"rail {name}", first=fixed(), second=on(name), angle=0.0) for name in ("left", "right")],
        readings=[x_of("left", "left"), x_of("right", "right")],
        sketch=[(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)],
        loads=[
            Spring(
                name="spring", first=on("right", -0.05), second=on("left", 0.05), stiffness=stiffness, free_length=free
            )
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

    return Case(scene=scene, exact=exact)


def spring_across_a_pendulum() -> Case:
    """A rod on a pin, with a spring from off its axis to the ground: the spring's direction turns."""
    mass, length, stiffness, free, start = 1.5, 0.7, 80.0, 0.25, 0.9
    hook, anchor = 0.4 + 0.1j, 0.3 - 0.9j  # the hook from the pin, with the rod along x
    scene = make_scene(
        bodies=[rod("rod", mass, length)],
        joints=[Pin(name="hinge", first=fixed(), second=on("rod", -length / 2))],
        readings=[angle_of("rod")],
        sketch=[(length / 2, 0.0, 0.0)],
        loads=[
            Spring(
                name="spring",
                first=on("rod", hook.real - length / 2, hook.imag),
                second=fixed(anchor.real, anchor.imag),
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
        return (pull * (1j * place).conjugate()).real - mass * G * length / 2 * math.cos(q)

    def exact(times):
        return {
            "rod": tuple(
                of_one_coordinate(lambda _: (mass * length**2 / 3, 0.0), push, (start - math.pi / 2, 0.0), times)
            )
        }

    return Case(scene=scene, exact=exact)


def damped(times: FloatArray, square: float, decay: float, start: float, speed: float) -> tuple[FloatArray, FloatArray]:
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


def damped_mass(ratio: float = 0.2) -> Case:
    """A mass between a spring and a damper, `ratio` of the critical damping, on an inclined rail."""
    mass, stiffness, free, lean = 1.2, 90.0, 0.4, 0.5
    fast = math.sqrt(stiffness / mass)
    decay = ratio * fast
    rest = free + mass * G * math.sin(lean) / stiffness  # up the rail, the anchor above
    u = np.exp(1j * lean)
    start, speed, anchor = 0.3, 1.0, 1.0 * u  # the mass at (1 - way) along the rail
    place = (1.0 - start) * u
    scene = make_scene(
        bodies=[bead("mass", mass)],
        joints=[Slider(name="rail", first=fixed(), second=on("mass"), angle=lean)],
        readings=[Separation(name="way", quantity="length", first=fixed(anchor.real, anchor.imag), second=on("mass"))],
        sketch=[(place.real, place.imag, 0.0)],
        loads=[
            Spring(
                name="spring",
                first=fixed(anchor.real, anchor.imag),
                second=on("mass"),
                stiffness=stiffness,
                free_length=free,
            ),
            Damper(
                name="damper", first=on("mass"), second=fixed(-0.5 * u.real, -0.5 * u.imag), damping=2 * mass * decay
            ),
        ],
        rates={"way": speed},
        size=free,
    )

    def exact(times):
        way, rate = damped(times, stiffness / mass, decay, start - rest, speed)
        return {"way": (rest + way, rate)}

    return Case(scene=scene, exact=exact)


def damper_across_a_pendulum() -> Case:
    """A rod on a pin, with a damper from off its axis to the ground: its direction turns."""
    mass, length, damping, start = 1.5, 0.7, 6.0, 1.4
    hook, anchor = 0.5 + 0.1j, 0.5 - 0.9j
    scene = make_scene(
        bodies=[rod("rod", mass, length)],
        joints=[Pin(name="hinge", first=fixed(), second=on("rod", -length / 2))],
        readings=[angle_of("rod")],
        sketch=[(length / 2, 0.0, 0.0)],
        loads=[
            Damper(
                name="damper",
                first=fixed(anchor.real, anchor.imag),
                second=on("rod", hook.real - length / 2, hook.imag),
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
        return -damping * arm**2 * rate - mass * G * length / 2 * math.cos(q)

    def exact(times):
        return {
            "rod": tuple(
                of_one_coordinate(lambda _: (mass * length**2 / 3, 0.0), push, (start - math.pi / 2, 0.0), times)
            )
        }

    return Case(scene=scene, exact=exact)


def torsion_pendulum(damping: float = 0.0) -> Case:
    """A wheel on a torsion spring, with or without a torsion damper."""
    inertia, stiffness, free, start, speed = 0.2, 8.0, 0.3, 2.0, -1.5
    loads = [TorsionSpring(name="wire", second="wheel", stiffness=stiffness, free_angle=free)]
    if damping:
        loads.append(TorsionDamper(name="vane", second="wheel", damping=damping))
    scene = make_scene(
        bodies=[turning("wheel", 2.0, inertia)],
        joints=[Pin(name="shaft", first=fixed(), second=on("wheel"))],
        readings=[angle_of("wheel")],
        sketch=[(0.0, 0.0, 0.0)],
        loads=loads,
        values={"wheel": start},
        rates={"wheel": speed},
        size=0.5,
    )

    def exact(times):
        angle, rate = damped(times, stiffness / inertia, damping / (2 * inertia), start - free, speed)
        return {"wheel": (free + angle, rate)}

    return Case(scene=scene, exact=exact)


def two_wheels_on_one_wire() -> Case:
    """Two wheels, a torsion spring and a torsion damper between them, neither of them held."""
    inertias, stiffness, damping, free, start, rates = (0.2, 0.5), 8.0, 0.15, 0.3, (0.1, 1.4), (2.0, -0.5)
    scene = make_scene(
        bodies=[turning("first", 2.0, inertias[0]), turning("second", 3.0, inertias[1])],
        joints=[
            Pin(name="shaft 1", first=fixed(), second=on("first")),
            Pin(name="shaft 2", first=fixed(0.5), second=on("second")),
        ],
        readings=[angle_of("first"), angle_of("second")],
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
        apart, rate = damped(
            times, stiffness / reduced, damping / (2 * reduced), start[1] - start[0] - free, rates[1] - rates[0]
        )
        middle = mean + drift * times
        return {
            "first": (middle - inertias[1] / total * (apart + free), drift - inertias[1] / total * rate),
            "second": (middle + inertias[0] / total * (apart + free), drift + inertias[0] / total * rate),
        }

    return Case(scene=scene, exact=exact)


# --- torques and forces -----------------------------------------------------------------------------------------------

STEPPED = Program(times=(0.0, 0.3, 0.45, 0.45, 0.7, 0.9), values=(0.5, 2.0, -0.4, 1.2, 0.3, 0.3))
"""Smooth to 0.45 s, a step there, smooth again, level from 0.9 s on; breaks off the reported tenths of a second."""


def of_program(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """STEPPED at times (n,), its integral from 0 and the integral of that: monotone cubics on either side."""
    at, values = np.array(STEPPED.times), np.array(STEPPED.values)
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


def wheel_under_a_torque(*, constant: bool) -> Case:
    """A wheel under a given moment, constant or in time with a step."""
    inertia, start, rate = 0.2, 0.3, -1.0
    program = Program(values=(1.5,)) if constant else STEPPED
    scene = make_scene(
        bodies=[turning("wheel", 2.0, inertia)],
        joints=[Pin(name="shaft", first=fixed(), second=on("wheel"))],
        readings=[angle_of("wheel")],
        sketch=[(0.0, 0.0, start)],
        loads=[Torque(name="motor", second="wheel", moment=program)],
        rates={"wheel": rate},
        size=0.5,
    )

    def exact(times):
        single, double = (1.5 * times, 0.75 * times**2) if constant else of_program(times)[1:]
        return {"wheel": (start + rate * times + double / inertia, rate + single / inertia)}

    return Case(scene=scene, exact=exact, order=NO_ERROR if constant else SECOND_ORDER)


def torque_between_two_wheels() -> Case:
    """A moment in time that one wheel takes from the other."""
    inertias = 0.2, 0.5
    scene = make_scene(
        bodies=[turning("first", 2.0, inertias[0]), turning("second", 3.0, inertias[1])],
        joints=[
            Pin(name="shaft 1", first=fixed(), second=on("first")),
            Pin(name="shaft 2", first=fixed(0.5), second=on("second")),
        ],
        readings=[angle_of("first"), angle_of("second")],
        sketch=[(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)],
        loads=[Torque(name="motor", first="first", second="second", moment=STEPPED)],
        size=0.5,
    )

    def exact(times):
        _, single, double = of_program(times)
        return {
            "first": (-double / inertias[0], -single / inertias[0]),
            "second": (double / inertias[1], single / inertias[1]),
        }

    return Case(scene=scene, exact=exact)


def mass_under_a_force(*, constant: bool) -> Case:
    """A mass on an inclined rail under a force of two parts, constant or one of them in time with a step."""
    mass, lean, upward = 1.5, 0.4, 7.0
    along = Program(values=(3.0,)) if constant else STEPPED
    scene = make_scene(
        bodies=[bead("mass", mass)],
        joints=[Slider(name="rail", first=fixed(), second=on("mass"), angle=lean)],
        readings=[x_of("mass"), y_of("mass")],
        sketch=[(0.0, 0.0, 0.0)],
        loads=[Force(name="push", point=on("mass"), x=along, y=Program(values=(upward,)))],
        size=0.5,
    )

    def exact(times):
        single, double = (3.0 * times, 1.5 * times**2) if constant else of_program(times)[1:]
        rising = (upward / mass - G) * math.sin(lean)
        way = math.cos(lean) / mass * double + rising * times**2 / 2
        rate = math.cos(lean) / mass * single + rising * times
        return {"x": (math.cos(lean) * way, math.cos(lean) * rate), "y": (math.sin(lean) * way, math.sin(lean) * rate)}

    return Case(scene=scene, exact=exact, order=NO_ERROR if constant else SECOND_ORDER)


def pushed_plate(*, carried: bool) -> Case:
    """A plate with a force off its centre that keeps its direction as the plate turns: on a trolley, or free of joints.

    The trolley takes up what moves the plate up or down.
    """
    mass, inertia, trolley, hook, upward = 1.5, 0.05, 0.8, 0.2 + 0.1j, 4.0
    joints = [
        Slider(name="rail", first=fixed(0.0, 0.2), second=on("trolley"), angle=0.0),
        Pin(name="bearing", first=on("trolley"), second=on("plate")),
    ]
    scene = make_scene(
        bodies=[turning("plate", mass, inertia), *([bead("trolley", trolley)] if carried else [])],
        joints=joints if carried else [],
        readings=[angle_of("plate", "turn"), x_of("plate"), y_of("plate")],
        sketch=[(0.1, 0.2, 0.4), *([(0.1, 0.2, 0.0)] if carried else [])],
        loads=[Force(name="push", point=on("plate", hook.real, hook.imag), x=STEPPED, y=Program(values=(upward,)))],
        rates={"turn": 1.0, "x": 0.2, **({} if carried else {"y": -0.1})},
        size=0.5,
    )
    before, after = (PchipInterpolator(STEPPED.times[side], STEPPED.values[side]) for side in (slice(3), slice(3, 6)))

    def slope(time, state, push):
        arm = hook * np.exp(1j * state[0])
        return [state[1], (arm.real * upward - arm.imag * push(min(time, 0.9))) / inertia]

    def exact(times):
        early, late = times[times <= 0.45], times[times > 0.45]
        first = follow(lambda t, y: slope(t, y, before), (0.4, 1.0), np.append(early, 0.45))
        kinks = [at - 0.45 for at in (0.7, 0.9)]
        second = follow(lambda t, y: slope(t + 0.45, y, after), first[:, -1], late - 0.45, breaks=kinks)
        turn, rate = np.concatenate([first[:, :-1], second], axis=1)
        _, single, double = of_program(times)
        moved = mass + trolley if carried else mass
        start, fall = (0.0, 0.0) if carried else (-0.1, upward / mass - G)
        return {
            "turn": (turn, rate),
            "x": (0.1 + 0.2 * times + double / moved, 0.2 + single / moved),
            "y": (0.2 + start * times + fall * times**2 / 2, start + fall * times),
        }

    return Case(scene=scene, exact=exact)


CASES: dict[str, Callable[[], Case]] = {
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
