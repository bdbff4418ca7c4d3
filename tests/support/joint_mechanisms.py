"""Small scenes, at least one for each joint and force element, with exact readings: closed forms, or integrated by scipy."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.special import ellipj, ellipk

from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Force, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import ArcSlot, CurveSlot, Gear, Prismatic, RackAndPinion, RotationalDriver, TranslationalDriver, Weld
from governor_mechanism.model.joints.base import Point
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.output_variables import PointCoordinate, PointDistance
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import Harmonic, InputFunction, PrescribedMotion
from governor_mechanism.types import FloatArray
from scene_parts import (
    body_angle,
    body_point,
    constant,
    damper,
    ground_point,
    link,
    make_mechanism,
    pin,
    point_mass,
    rod_body,
    rotating_body,
    scene_of,
    slider,
    spring,
    x_reading,
    y_reading,
)

ExactReadings = dict[str, tuple[FloatArray, FloatArray]]
"""Values (n,) and rates (n,) of each reading, by name."""

GRAVITY = 9.81
SECOND_ORDER, NO_ERROR = "second order", "no error"


@dataclass(frozen=True, kw_only=True)
class ExactCase:
    """A scene, its exact readings at times (n,) s, and the largest step (s) at which the impulse engine shows its order.

    impulse is False if the impulse engine does not support the joint.
    """

    scene: Scene
    exact: Callable[[FloatArray], ExactReadings]
    step: float = 0.005
    order: str = SECOND_ORDER
    impulse: bool = True


def make_scene(*, bodies, joints, readings, sketch, loads=(), gravity=GRAVITY, size=1.0, **options) -> Scene:
    """Return a scene of one mechanism in a fixed plane."""
    mechanism = make_mechanism(bodies, joints, readings, sketch, loads=loads, size=size)
    return scene_of(mechanism, *([Gravity(acceleration=gravity)] if gravity else []), **options)


# --- independent solutions ----------------------------------------------------------------------------------------------


def integrate_state(state_derivative: Callable, start, times: FloatArray, breaks=()) -> FloatArray:
    """Return a state (numbers, n) at the times, integrated by scipy at its smallest tolerance, restarted at breakpoints."""
    state, solution = np.array(start, dtype=np.float64), np.empty((len(start), len(times)))
    solution[:, times == 0.0] = state[:, np.newaxis]
    knots = [0.0, *(float(at) for at in breaks if 0 < at < times[-1]), float(times[-1])]
    for begin, end in pairwise(knots):
        in_segment = (times > begin) & (times <= end)
        output_times = np.unique(np.append(times[in_segment], end))
        segment = solve_ivp(state_derivative, (begin, end), state, method="DOP853", t_eval=output_times, rtol=1e-13, atol=1e-15)
        solution[:, in_segment] = segment.y[:, : int(in_segment.sum())]
        state = segment.y[:, -1]
    return solution


def released_pendulum(times: FloatArray, square: float, start: float) -> tuple[FloatArray, FloatArray]:
    """Return angle and rate of a pendulum released from rest at `start` (Jacobi's sn); `square` is its squared natural frequency."""
    modulus = math.sin(start / 2)
    frequency = math.sqrt(square)
    sn, cn, dn, _ = ellipj(ellipk(modulus**2) + frequency * times, modulus**2)
    return 2 * np.arcsin(modulus * sn), 2 * modulus * frequency * cn * dn / np.sqrt(1 - (modulus * sn) ** 2)


def integrate_one_coordinate(inertia: Callable, generalised_force: Callable, start, times: FloatArray) -> FloatArray:
    """Return coordinate and rate (2, n); inertia(q) gives J and dJ/dq, generalised_force(q, rate) the force."""

    def state_rate(_, state):
        total_inertia, inertia_derivative = inertia(state[0])
        return [state[1], (generalised_force(*state) - 0.5 * inertia_derivative * state[1] ** 2) / total_inertia]

    return integrate_state(state_rate, start, times)


def pendulum_on_trolley_solution(trolley: float, mass: float, length: float, inertia: float, start: float) -> Callable:
    """Return angle from the downward vertical and displacement of the trolley, for a pendulum on a free trolley."""

    def of_angle(q):
        off = mass * length * np.cos(q)
        total_inertia = inertia + mass * length**2 - off**2 / (trolley + mass)
        return total_inertia, 2 * off * mass * length * np.sin(q) / (trolley + mass)

    def exact(times):
        q, rate = integrate_one_coordinate(of_angle, lambda q, _: -mass * GRAVITY * length * np.sin(q), (start, 0.0), times)
        share = mass * length / (trolley + mass)
        displacement = -share * (np.sin(q) - math.sin(start))  # the common mass centre keeps its x coordinate
        return {"angle": (q, rate), "x": (displacement, -share * np.cos(q) * rate)}

    return exact


def mass_on_rotating_path_solution(inertia: float, mass: float, path: Callable, start) -> Callable:
    """Solve for a mass on a path of a body that rotates freely about its origin; path(s) gives position and two derivatives.

    start: the body's angle and rate, s and its rate. Lagrange's equations of T = (I + m p.p) w^2/2 + m p'.p' v^2/2
    + m (p x p') w v. The readings are 'turn' and 'way'.
    """

    def state_rate(_, state):
        _, w, s, v = state
        position, tangent, curvature = (np.array(vector) for vector in path(s))
        cross, cross_derivative = _cross(position, tangent), _cross(position, curvature)
        matrix = mass * np.array([[inertia / mass + position @ position, cross], [cross, tangent @ tangent]])
        rhs = -mass * np.array(
            [2 * (position @ tangent) * v * w + cross_derivative * v**2, (tangent @ curvature) * v**2 - (position @ tangent) * w**2]
        )
        accelerations = np.linalg.solve(matrix, rhs)
        return [w, accelerations[0], v, accelerations[1]]

    def exact(times):
        turn, w, displacement, v = integrate_state(state_rate, start, times)
        return {"turn": (turn, w), "way": (displacement, v)}

    return exact


def _cross(first, second):
    return first[0] * second[1] - first[1] * second[0]


def straight_path(angle: float, distance: float) -> Callable:
    """Return a straight path at `angle` whose nearest point is at `distance` from the origin."""
    u, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    return lambda s: (s * u + distance * n, u, 0 * u)


@dataclass(frozen=True)
class SliderCrankKinematics:
    """Slider-crank with its crank at the origin, a uniform connecting rod, and the piston on the x axis."""

    crank: float
    rod: float
    rod_mass: float
    piston_mass: float

    def piston(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the piston position and its two derivatives with respect to the crank angle."""
        inclination, inclination1, inclination2 = self.rod_angle(q)
        r, length = self.crank, self.rod
        return (
            r * np.cos(q) + length * np.cos(inclination),
            -r * np.sin(q) - length * np.sin(inclination) * inclination1,
            -r * np.cos(q) - length * (np.cos(inclination) * inclination1**2 + np.sin(inclination) * inclination2),
        )

    def rod_angle(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the angle of the rod and its two derivatives with respect to the crank angle."""
        sine, cosine = np.sin(q), np.cos(q)
        r, drop = self.crank, np.sqrt(self.rod**2 - self.crank**2 * np.sin(q) ** 2)
        return -np.arcsin(r * sine / self.rod), -r * cosine / drop, r * sine / drop - r**3 * sine * cosine**2 / drop**3

    def torque(self, q: FloatArray, rate: FloatArray, acceleration: FloatArray, crank_inertia: float) -> FloatArray:
        """Return the torque on the crank (N m) by virtual work of inertia forces and weights."""
        inclination, inclination1, inclination2 = self.rod_angle(q)
        half = self.rod / 2
        middle1 = self.crank * 1j * np.exp(1j * q) + half * 1j * inclination1 * np.exp(1j * inclination)
        middle2 = -self.crank * np.exp(1j * q) + half * (1j * inclination2 - inclination1**2) * np.exp(1j * inclination)
        middle = middle2 * rate**2 + middle1 * acceleration
        _, displacement1, displacement2 = self.piston(q)
        inertia = self.rod_mass * self.rod**2 / 12
        return (
            crank_inertia * acceleration
            + self.rod_mass * ((middle + 1j * GRAVITY) * middle1.conj()).real
            + inertia * (inclination2 * rate**2 + inclination1 * acceleration) * inclination1
            + self.piston_mass * (displacement2 * rate**2 + displacement1 * acceleration) * displacement1
        )


# --- pins, welds, links -----------------------------------------------------------------------------------------------


def hinged_rod(mass: float, length: float, start: float, pivot=(0.0, 0.0), loads=()) -> Scene:
    """Return a rod that hangs from its end, at an angle from the downward vertical."""
    return make_scene(
        bodies=[rod_body("rod", mass, length)],
        joints=[pin("hinge", ground_point(*pivot), body_point("rod", -length / 2))],
        readings=[body_angle("rod")],
        sketch=[(pivot[0] + length / 2, pivot[1], 0.0)],
        loads=loads,
        values={"rod": start - math.pi / 2},
        size=length,
    )


def pendulum_on_a_pin() -> ExactCase:
    """A rod that hangs from its end."""
    length, start = 0.8, 2.0

    def exact(times):
        angle, rate = released_pendulum(times, 1.5 * GRAVITY / length, start)
        return {"rod": (angle - math.pi / 2, rate)}

    return ExactCase(scene=hinged_rod(2.0, length, start, pivot=(0.1, 0.2)), exact=exact)


def pendulum_on_a_trolley() -> ExactCase:
    """A rod pinned to a free trolley: a pin between two moving bodies, with its ends in reverse order."""
    length, start = 0.6, 1.3
    scene = make_scene(
        bodies=[point_mass("trolley", 3.0), rod_body("rod", 2.0, length)],
        joints=[
            slider("rail", ground_point(), body_point("trolley")),
            pin("hinge", body_point("rod", y=length / 2), body_point("trolley")),
        ],
        readings=[body_angle("rod", "angle"), x_reading("trolley")],
        sketch=[(0.0, 0.0, 0.0), (0.0, -length / 2, 0.0)],
        values={"angle": start, "x": 0.0},
        size=length,
    )
    # The rod is along its y axis here, but has the second moments of a rod along x: only xx + yy matters.
    return ExactCase(scene=scene, exact=pendulum_on_trolley_solution(3.0, 2.0, length / 2, 2.0 * length**2 / 12, start))


def bent_pendulum(turn: float = 0.7) -> ExactCase:
    """Two rods welded at an angle are one pendulum."""
    first, second, lengths, start = 2.0, 1.5, (0.5, 0.4), 1.1
    # Mass times mass centre from the pin, in the axes of the first rod, and the inertia about the pin.
    tip = lengths[0] + np.exp(1j * turn) * lengths[1] / 2
    moment = first * lengths[0] / 2 + second * tip
    inertia = first * lengths[0] ** 2 / 3 + second * (lengths[1] ** 2 / 12 + abs(tip) ** 2)
    hanging = -math.pi / 2 - np.angle(moment)  # angle of the first rod at equilibrium
    scene = make_scene(
        bodies=[rod_body("first", first, lengths[0]), rod_body("second", second, lengths[1])],
        joints=[
            pin("hinge", ground_point(), body_point("first", -lengths[0] / 2)),
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
        joints=[slider("rail", ground_point(), body_point("trolley")), link("link", body_point("trolley"), body_point("bob"), length)],
        readings=[x_reading("trolley"), x_reading("bob", "bob_x"), y_reading("bob", "bob_y")],
        sketch=[(0.0, 0.0, 0.0), (length * math.sin(start), -length * math.cos(start), 0.0)],
        size=length,
    )
    inner = pendulum_on_trolley_solution(2.0, 1.5, length, 0.0, start)

    def exact(times):
        relative_motion = inner(times)
        (q, rate), (x, u) = relative_motion["angle"], relative_motion["x"]
        return {
            "x": (x, u),
            "bob_x": (x + length * np.sin(q), u + length * np.cos(q) * rate),
            "bob_y": (-length * np.cos(q), length * np.sin(q) * rate),
        }

    return ExactCase(scene=scene, exact=exact)


# --- guides -----------------------------------------------------------------------------------------------------------


def bead_on_a_turning_rod(angle: float = 0.3, aside: float = 0.1) -> ExactCase:
    """A mass on a straight guide of a rod that rotates freely about a pin; the guide passes the pin at a distance."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    n, direction = (-aside * math.sin(angle), aside * math.cos(angle)), (math.cos(angle), math.sin(angle))
    way = _along("way", body_point("bead"), body_point("rod", -length / 2), direction)
    scene = make_scene(
        bodies=[rod_body("rod", mass, length), point_mass("bead", 0.7)],
        joints=[
            pin("hinge", ground_point(), body_point("rod", -length / 2)),
            slider("bore", body_point("rod", n[0] - length / 2, n[1]), body_point("bead"), angle),
        ],
        readings=[body_angle("rod", "turn"), way],
        sketch=[(length / 2, 0.0, 0.0), (n[0] + 0.35 * math.cos(angle), n[1] + 0.35 * math.sin(angle), 0.0)],
        values={"turn": start[0], "way": start[2]},
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=length,
    )
    return ExactCase(scene=scene, exact=mass_on_rotating_path_solution(mass * length**2 / 3, 0.7, straight_path(angle, aside), start))


def collar_on_a_turning_rod(angle: float = 0.3, turn: float = 0.5) -> ExactCase:
    """A collar with a moment of inertia on such a rod, rotating with it; its mass centre is off the guide."""
    mass, length, start = 2.0, 1.0, (0.0, 2.0, 0.35, -0.3)
    collar, inertia, ahead, aside = 0.7, 0.02, 0.06, 0.09
    point = -np.exp(-1j * (turn - angle)) * (ahead + 1j * aside)  # the guided point in body axes of the collar
    position = np.exp(1j * angle) * (0.35 + ahead + 1j * aside)
    pivot, guided = body_point("rod", -length / 2), body_point("collar", point.real, point.imag)
    way = _along("way", body_point("collar"), pivot, (math.cos(angle), math.sin(angle)), ahead)
    scene = make_scene(
        bodies=[rod_body("rod", mass, length), rotating_body("collar", collar, inertia)],
        joints=[pin("hinge", ground_point(), pivot), Prismatic(name="bore", first=pivot, second=guided, angle=angle, relative_angle=turn)],
        readings=[body_angle("rod", "turn"), way, body_angle("collar")],
        sketch=[(length / 2, 0.0, 0.0), (position.real, position.imag, turn)],
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
        relative_motion = inner(times)
        return {**relative_motion, "collar": (relative_motion["turn"][0] + turn, relative_motion["turn"][1])}

    return ExactCase(scene=scene, exact=exact)


def _along(name: str, point: Point, origin: Point, direction: tuple[float, float], zero: float = 0.0) -> PointCoordinate:
    """Return a reading of a point along a direction of the body of its origin."""
    x, y = direction
    return PointCoordinate(name=name, quantity="length", point=point, origin=origin, direction_x=x, direction_y=y, zero=zero)


def rod_through_a_swivel() -> ExactCase:
    """A rod that slides through a fixed swivel: the guide line is on the rod, the guided point on the ground."""
    mass, inertia, start = 1.4, 0.06, (0.2, 0.5, -0.4, 1.5)
    scene = make_scene(
        bodies=[rotating_body("rod", mass, inertia)],
        joints=[slider("swivel", body_point("rod"), ground_point())],
        readings=[body_angle("rod", "turn"), _along("way", ground_point(), body_point("rod"), (-1.0, 0.0))],
        sketch=[(start[0] * math.cos(start[2]), start[0] * math.sin(start[2]), start[2])],
        rates={"turn": start[3], "way": start[1]},
        size=0.5,
        duration=0.6,
    )

    def state_rate(_, state):
        displacement, speed, turn, rate = state
        twist = -mass * displacement * (2 * speed * rate + GRAVITY * math.cos(turn)) / (inertia + mass * displacement**2)
        return [speed, displacement * rate**2 - GRAVITY * math.sin(turn), rate, twist]

    def exact(times):
        displacement, speed, turn, rate = integrate_state(state_rate, start, times)
        return {"turn": (turn, rate), "way": (displacement, speed)}

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
    """A slot in a plate that swings about a pin: a double pendulum, in its two angles from the downward vertical."""
    plate, mass, inertia, centre, slot, radius = 2.0, 0.8, 0.05, 0.25, 0.4, 0.2
    start = (0.6, 0.0, -0.5, 0.0)
    knee = slot * math.sin(start[0]), -slot * math.cos(start[0])
    hung = (centre * math.sin(start[0]), -centre * math.cos(start[0]), start[0])
    scene = make_scene(
        bodies=[rotating_body("plate", plate, inertia), point_mass("bead", mass)],
        joints=[
            pin("hinge", ground_point(), body_point("plate", y=centre)),
            ArcSlot(name="slot", first=body_point("plate", y=centre - slot), second=body_point("bead"), radius=radius),
        ],
        readings=[body_angle("plate"), x_reading("bead"), y_reading("bead")],
        sketch=[hung, (knee[0] + radius * math.sin(start[2]), knee[1] - radius * math.cos(start[2]), 0.0)],
        size=slot + radius,
        duration=0.8,
    )
    total_inertia = inertia + plate * centre**2 + mass * slot**2

    def state_rate(_, state):
        p, u, q, v = state
        coupling = mass * slot * radius * math.cos(p - q)
        twist = mass * slot * radius * math.sin(p - q)
        right = [
            -twist * v**2 - (plate * centre + mass * slot) * GRAVITY * math.sin(p),
            twist * u**2 - mass * GRAVITY * radius * math.sin(q),
        ]
        accelerations = np.linalg.solve([[total_inertia, coupling], [coupling, mass * radius**2]], right)
        return [u, accelerations[0], v, accelerations[1]]

    def exact(times):
        p, u, q, v = integrate_state(state_rate, start, times)
        return {
            "plate": (p, u),
            "x": (slot * np.sin(p) + radius * np.sin(q), slot * np.cos(p) * u + radius * np.cos(q) * v),
            "y": (-slot * np.cos(p) - radius * np.cos(q), slot * np.sin(p) * u + radius * np.sin(q) * v),
        }

    return ExactCase(scene=scene, exact=exact)


STEEPNESS = 1.5
PARABOLA = PolynomialCurve(coefficients=(0.0, 0.0, STEEPNESS))


def bead_on_a_parabola(curve: Curve | None = None) -> ExactCase:
    """A bead on y = a x^2, as a polynomial or as a table of points."""
    start = 0.6
    scene = make_scene(
        bodies=[point_mass("bead", 0.9)],
        joints=[CurveSlot(name="wire", first=ground_point(), second=body_point("bead"), curve=curve or PARABOLA)],
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
    """The same bead on a cubic spline through points of the parabola, which reproduces it: its third derivative is 0."""
    x = np.linspace(-0.8, 0.8, 33)
    return bead_on_a_parabola(SplineCurve(x=tuple(x.tolist()), y=tuple((STEEPNESS * x**2).tolist())))


def bead_on_a_turning_curve(coefficients: tuple[float, ...], angle: float = -0.4) -> ExactCase:
    """A bead on a polynomial curve of a body that rotates freely about a pin away from the origin of the curve."""
    inertia, mass, start, curve = 0.2, 0.5, (0.2, 3.0, 0.3, 0.5), np.polynomial.Polynomial(coefficients)
    x, y = 0.15, -0.1  # origin of the curve relative to the pin, in body axes
    turn, origin, groove = np.exp(1j * angle), body_point("cam", x, y), PolynomialCurve(coefficients=coefficients)

    def path(s):
        path_derivatives = (x + 1j * y + turn * (s + 1j * curve(s)), turn * (1 + 1j * curve.deriv()(s)), turn * 1j * curve.deriv(2)(s))
        return tuple((position.real, position.imag) for position in path_derivatives)

    first = np.exp(1j * start[0]) * complex(*path(start[2])[0])
    scene = make_scene(
        bodies=[rotating_body("cam", 2.0, inertia), point_mass("bead", mass)],
        joints=[
            pin("hinge", ground_point(), body_point("cam")),
            CurveSlot(name="groove", first=origin, second=body_point("bead"), curve=groove, angle=angle),
        ],
        readings=[body_angle("cam", "turn"), _along("way", body_point("bead"), origin, (math.cos(angle), math.sin(angle)))],
        sketch=[(0.0, 0.0, start[0]), (first.real, first.imag, 0.0)],
        rates={"turn": start[1], "way": start[3]},
        gravity=0.0,
        size=0.5,
    )
    return ExactCase(scene=scene, exact=mass_on_rotating_path_solution(inertia, mass, path, start))


# --- gears and racks --------------------------------------------------------------------------------------------------


def _geared_wheels_scene(off: float, values: Mapping[str, float], torque: float, ratio: float, offset: float) -> Scene:
    start = values["first"]
    turned = ratio * start + offset
    return make_scene(
        bodies=[rotating_body("first", 3.0, 0.04), rotating_body("second", 5.0, 0.3)],
        joints=[
            pin("shaft 1", ground_point(), body_point("first")),
            pin("shaft 2", ground_point(0.6), body_point("second", y=off)),
            Gear(name="teeth", first=body_point("first"), second=body_point("second"), ratio=ratio, offset=offset),
        ],
        readings=[body_angle("first"), body_angle("second")],
        sketch=[(0.0, 0.0, start), (0.6 + off * math.sin(turned), -off * math.cos(turned), turned)],
        loads=[Torque(name="motor", second="first", moment=constant(torque))] if torque else [],
        values=values,
        size=0.5,
    )


def geared_wheels() -> ExactCase:
    """Two gears with a torque on one: the inertia of the other counts times the squared ratio."""
    ratio, offset, torque = -0.5, 0.4, 0.6
    scene = _geared_wheels_scene(0.0, {"first": 0.1}, torque, ratio, offset)
    acceleration = torque / (0.04 + ratio**2 * 0.3)

    def exact(times):
        angle, rate = 0.1 + acceleration * times**2 / 2, acceleration * times
        return {"first": (angle, rate), "second": (ratio * angle + offset, ratio * rate)}

    return ExactCase(scene=scene, exact=exact, order=NO_ERROR)


def geared_pendulum() -> ExactCase:
    """Two gears; the mass centre of the second is off its shaft, so that it swings and drives the first."""
    ratio, offset, off, start = -0.5, 0.4, 0.15, 1.7
    scene = _geared_wheels_scene(off, {"first": (start - offset) / ratio}, 0.0, ratio, offset)
    inertia = 0.3 + 5.0 * off**2 + 0.04 / ratio**2

    def exact(times):
        angle, rate = released_pendulum(times, 5.0 * GRAVITY * off / inertia, start)
        return {"second": (angle, rate), "first": ((angle - offset) / ratio, rate / ratio)}

    return ExactCase(scene=scene, exact=exact)


def falling_rack(inclination: float = 1.2) -> ExactCase:
    """A rack slides down a steep guide and drives a pinion, whose inertia adds to its mass."""
    radius, inertia, mass, offset = -0.1, 0.03, 2.0, 0.05
    ahead = offset - 0.1 * math.cos(inclination)  # position on the guide at angle 0, where the rack coordinate is `offset`
    scene = make_scene(
        bodies=[rotating_body("pinion", 1.0, inertia), point_mass("rack", mass)],
        joints=[
            pin("shaft", ground_point(), body_point("pinion")),
            slider("guide", ground_point(0.1), body_point("rack"), inclination),
            RackAndPinion(
                name="teeth", first=body_point("pinion"), second=body_point("rack"), radius=radius, angle=inclination, offset=offset
            ),
        ],
        readings=[body_angle("pinion"), y_reading("rack")],
        sketch=[(0.0, 0.0, 0.0), (0.1 + ahead * math.cos(inclination), ahead * math.sin(inclination), 0.0)],
        values={"pinion": 0.0},
        size=0.2,
        duration=0.5,
    )
    acceleration = -GRAVITY * math.sin(inclination) / (1 + inertia / (mass * radius**2))  # along the guide

    def exact(times):
        displacement, speed = acceleration * times**2 / 2, acceleration * times
        return {
            "pinion": (displacement / radius, speed / radius),
            "y": ((ahead + displacement) * math.sin(inclination), speed * math.sin(inclination)),
        }

    return ExactCase(scene=scene, exact=exact, impulse=False)


# --- massless bodies --------------------------------------------------------------------------------------------------


def bob_on_a_massless_rod_of_a_trolley() -> ExactCase:
    """A rod without mass, pinned to a trolley, with a point mass at its end: it has no moment of inertia about its mass centre."""
    trolley, mass, length, start = 2.0, 0.7, 0.5, 1.1
    scene = make_scene(
        bodies=[point_mass("trolley", trolley), Body(name="rod", mass=mass)],
        joints=[slider("rail", ground_point(), body_point("trolley")), pin("hinge", body_point("trolley"), body_point("rod", y=length))],
        readings=[body_angle("rod", "turn"), x_reading("trolley")],
        sketch=[(0.0, 0.0, 0.0), (length * math.sin(start), -length * math.cos(start), start)],
        values={"turn": start, "x": 0.0},
        rates={"turn": 0.8, "x": 0.3},
        size=length,
    )

    def state_rate(_, state):
        _, angle, _, rate = state
        matrix = [[trolley + mass, mass * length * math.cos(angle)], [math.cos(angle), length]]
        acceleration = np.linalg.solve(matrix, [mass * length * rate**2 * math.sin(angle), -GRAVITY * math.sin(angle)])
        return [state[2], rate, *acceleration]

    def exact(times):
        x, turn, x_rate, turn_rate = integrate_state(state_rate, (0.0, start, 0.3, 0.8), times)
        return {"turn": (turn, turn_rate), "x": (x, x_rate)}

    return ExactCase(scene=scene, exact=exact, impulse=False)


def massless_bell_crank() -> ExactCase:
    """A bell crank without mass, between a mass that is pinned to one arm and a spring at the other."""
    mass, arm, other_arm, stiffness, free_length, start = 1.3, 0.4, 0.25, 60.0, 0.3, -0.4
    scene = make_scene(
        bodies=[Body(name="crank", mass=0.0), point_mass("weight", mass)],
        joints=[pin("hinge", ground_point(), body_point("crank")), pin("hook", body_point("crank", arm), body_point("weight"))],
        readings=[body_angle("crank", "turn"), y_reading("weight")],
        sketch=[(0.0, 0.0, start), (arm * math.cos(start), arm * math.sin(start), 0.0)],
        loads=[spring("spring", ground_point(-0.5, 0.25), body_point("crank", y=other_arm), 60.0, free_length)],
        values={"turn": start},
        rates={"turn": 1.5},
        size=arm,
    )

    def state_rate(_, state):
        upper_end = other_arm * 1j * np.exp(1j * state[0])
        line = complex(-0.5, 0.25) - upper_end
        pull = stiffness * (abs(line) - free_length) * line / abs(line)
        spring_moment = (upper_end.conjugate() * pull).imag
        return [state[1], (spring_moment - mass * GRAVITY * arm * math.cos(state[0])) / (mass * arm**2)]

    def exact(times):
        turn, rate = integrate_state(state_rate, (start, 1.5), times)
        return {"turn": (turn, rate), "y": (arm * np.sin(turn), arm * np.cos(turn) * rate)}

    return ExactCase(scene=scene, exact=exact, impulse=False)


# --- drives -----------------------------------------------------------------------------------------------------------

ENGINE_KINEMATICS = SliderCrankKinematics(crank=0.1, rod=0.35, rod_mass=1.2, piston_mass=2.0)
CRANK_INERTIA = 0.02


def _slider_crank(motion: PrescribedMotion, start: float, duration: float) -> Scene:
    knee = ENGINE_KINEMATICS.crank * np.exp(1j * start)
    inclination = float(ENGINE_KINEMATICS.rod_angle(np.array(start))[0])
    middle = knee + np.exp(1j * inclination) * ENGINE_KINEMATICS.rod / 2
    return make_scene(
        bodies=[
            rotating_body("crank", 4.0, CRANK_INERTIA),
            rod_body("rod", ENGINE_KINEMATICS.rod_mass, ENGINE_KINEMATICS.rod),
            point_mass("piston", ENGINE_KINEMATICS.piston_mass),
        ],
        joints=[
            pin("shaft", ground_point(), body_point("crank")),
            pin("crank pin", body_point("crank", ENGINE_KINEMATICS.crank), body_point("rod", -ENGINE_KINEMATICS.rod / 2)),
            pin("cross head", body_point("rod", ENGINE_KINEMATICS.rod / 2), body_point("piston")),
            slider("guide", ground_point(), body_point("piston")),
            RotationalDriver(name="drive", first=ground_point(), second=body_point("crank"), motion=motion),
        ],
        readings=[body_angle("crank"), x_reading("piston"), body_angle("rod")],
        sketch=[
            (0.0, 0.0, start),
            (middle.real, middle.imag, inclination),
            (float(ENGINE_KINEMATICS.piston(np.array(start))[0]), 0.0, 0.0),
        ],
        size=ENGINE_KINEMATICS.rod,
        duration=duration,
        output_interval=duration / 20,
    )


def _crank_readings(angle: FloatArray, rate: FloatArray) -> ExactReadings:
    displacement, displacement1, _ = ENGINE_KINEMATICS.piston(angle)
    inclination, inclination1, _ = ENGINE_KINEMATICS.rod_angle(angle)
    return {"crank": (angle, rate), "x": (displacement, displacement1 * rate), "rod": (inclination, inclination1 * rate)}


def driven_slider_crank() -> ExactCase:
    """A crank driven at a constant rate."""
    start, rate = 0.3, 12.0
    scene = _slider_crank(PrescribedMotion.constant_rate(start, rate), start, 0.6)
    return ExactCase(scene=scene, exact=lambda times: _crank_readings(start + rate * times, np.full_like(times, rate)), step=0.0025)


MOTION_TABLE = ((0.0, 0.15, 0.3, 0.5, 0.6), (0.3, 1.0, 2.4, 2.9, 2.2))


def crank_motion(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The not-a-knot spline through the table: values, rates, second derivatives; from the last point on its rate is constant."""
    spline = CubicSpline(*MOTION_TABLE)
    return spline(times), spline(times, 1), np.where(times < MOTION_TABLE[0][-1], spline(times, 2), 0.0)


def slider_crank_driven_by_a_table() -> ExactCase:
    """The same crank driven by a spline through a few points."""
    scene = _slider_crank(PrescribedMotion(times=MOTION_TABLE[0], values=MOTION_TABLE[1]), MOTION_TABLE[1][0], 0.6)
    return ExactCase(scene=scene, exact=lambda times: _crank_readings(*crank_motion(times)[:2]), step=0.0025)


WOBBLE = ((0.4, 7.0, 0.9), (-0.05, 31.0, 2.0))
"""Amplitude (rad), angular frequency (rad/s) and phase of two harmonics."""


def wobbling_crank_motion(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A constant rate with two harmonics: values, rates, second derivatives."""
    phases = [(a, w, w * times + phase) for a, w, phase in WOBBLE]
    return (
        0.3 + 5.0 * times + sum(a * np.sin(phase) for a, _, phase in phases),
        5.0 + sum(a * w * np.cos(phase) for a, w, phase in phases),
        -sum(a * w**2 * np.sin(phase) for a, w, phase in phases),
    )


def slider_crank_driven_by_a_formula() -> ExactCase:
    """The same crank driven at a constant rate with two harmonics."""
    harmonics = tuple(Harmonic(amplitude=a, frequency=w / (2 * math.pi), phase=phase) for a, w, phase in WOBBLE)
    start = float(wobbling_crank_motion(np.array(0.0))[0])
    scene = _slider_crank(PrescribedMotion.constant_rate(0.3, 5.0, harmonics), start, 0.6)
    return ExactCase(scene=scene, exact=lambda times: _crank_readings(*wobbling_crank_motion(times)[:2]), step=0.0025)


DISPLACEMENT_TIMES = np.linspace(0.0, 1.2, 25)


def pendulum_on_a_driven_support(*, by_table: bool) -> ExactCase:
    """A rod that hangs from a support driven to and fro, by a table of many points or as a harmonic."""
    length, mass, start = 0.6, 1.5, 0.4
    at, wave = DISPLACEMENT_TIMES, Harmonic(amplitude=0.05, frequency=9.0 / (2 * math.pi))
    displacement = 0.05 * np.sin(9.0 * at)
    table = PrescribedMotion(times=tuple(at.tolist()), values=tuple((0.2 + displacement).tolist()))
    motion = table if by_table else PrescribedMotion.constant_rate(0.2, 0.0, (wave,))
    scene = make_scene(
        bodies=[point_mass("support", 2.0), rod_body("rod", mass, length)],
        joints=[
            slider("rail", ground_point(), body_point("support")),
            TranslationalDriver(name="drive", first=ground_point(-0.2), second=body_point("support"), angle=0.0, motion=motion),
            pin("hinge", body_point("support"), body_point("rod", y=length / 2)),
        ],
        readings=[body_angle("rod"), x_reading("support")],
        sketch=[(0.0, 0.0, 0.0), (length / 2 * math.sin(start), -length / 2 * math.cos(start), start)],
        values={"rod": start},
        rates={"rod": 0.0},
        size=length,
        duration=1.2,
    )
    spline = CubicSpline(at, displacement)

    def support(times, order=0):
        return spline(times, order) if by_table else 0.05 * 9.0**order * np.sin(9.0 * times + order * np.pi / 2)

    def state_rate(time, state):
        inclination = GRAVITY * math.sin(state[0]) + float(support(time, 2)) * math.cos(state[0])
        return [state[1], -inclination / (2 * length / 3)]

    def exact(times):
        angle, rate = integrate_state(state_rate, (start, 0.0), times, breaks=at)
        return {"rod": (angle, rate), "x": (support(times), support(times, 1))}

    return ExactCase(scene=scene, exact=exact)


def counterweight_driven_backwards() -> ExactCase:
    """A drive from a wheel to the ground: it prescribes the ground angle minus the wheel angle, so the wheel turns backward."""
    speed = 4.0
    motion = PrescribedMotion.constant_rate(0.3, speed)
    scene = make_scene(
        bodies=[rotating_body("wheel", 3.0, 0.1), point_mass("bob", 1.0)],
        joints=[
            pin("shaft", body_point("wheel", y=0.1), ground_point()),
            RotationalDriver(name="drive", first=body_point("wheel"), second=ground_point(), motion=motion),
            slider("bore", body_point("wheel", y=0.1), body_point("bob")),
        ],
        readings=[body_angle("wheel"), PointDistance(name="way", quantity="length", first=ground_point(), second=body_point("bob"))],
        sketch=[(-0.1 * math.sin(0.3), -0.1 * math.cos(0.3), -0.3), (0.2 * math.cos(0.3), -0.2 * math.sin(0.3), 0.0)],
        rates={"way": 0.4},
        size=0.5,
        duration=0.4,
        output_interval=0.05,
    )

    def state_rate(time, state):
        return [state[1], state[0] * speed**2 + GRAVITY * math.sin(0.3 + speed * time)]

    def exact(times):
        displacement, rate = integrate_state(state_rate, (0.2, 0.4), times)
        return {"wheel": (-0.3 - speed * times, np.full_like(times, -speed)), "way": (displacement, rate)}

    return ExactCase(scene=scene, exact=exact)


def bead_driven_along_a_turning_rod() -> ExactCase:
    """A drive moves a bead outward on a freely rotating rod, which slows down as the moment of inertia grows."""
    inertia, mass, rate, first, speed = 0.5, 1.5, 3.0, 0.2, 0.6
    outward = PrescribedMotion.constant_rate(first, speed)
    scene = make_scene(
        bodies=[rotating_body("rod", 2.0, inertia), point_mass("bead", mass)],
        joints=[
            pin("hinge", ground_point(), body_point("rod")),
            slider("bore", body_point("rod"), body_point("bead")),
            TranslationalDriver(name="drive", first=body_point("rod"), second=body_point("bead"), angle=0.0, motion=outward),
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
        displacement = first + speed * times
        rotation = momentum / (inertia * unit * speed) * (np.arctan(unit * displacement) - math.atan(unit * first))
        return {"turn": (rotation, momentum / (inertia + mass * displacement**2)), "way": (displacement, np.full_like(times, speed))}

    return ExactCase(scene=scene, exact=exact)


# --- springs and dampers ----------------------------------------------------------------------------------------------


def hanging_spring() -> ExactCase:
    """A mass on a spring, guided straight down."""
    mass, stiffness, free, start = 1.2, 90.0, 0.3, -0.5
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[slider("guide", ground_point(0.1), body_point("mass"), math.pi / 2)],
        readings=[y_reading("mass")],
        sketch=[(0.1, start, 0.0)],
        loads=[spring("spring", ground_point(0.1), body_point("mass"), stiffness, free)],
        size=free,
    )
    rest, frequency = -free - mass * GRAVITY / stiffness, math.sqrt(stiffness / mass)

    def exact(times):
        swing = start - rest
        return {"y": (rest + swing * np.cos(frequency * times), -swing * frequency * np.sin(frequency * times))}

    return ExactCase(scene=scene, exact=exact)


def spring_between_two_masses() -> ExactCase:
    """Two bodies without rotation on one rail, with a spring between off-centre points: oscillation and drift."""
    masses, stiffness, free, speeds = (1.0, 2.5), 60.0, 0.3, (0.4, -0.3)
    scene = make_scene(
        bodies=[point_mass("left", masses[0]), point_mass("right", masses[1])],
        joints=[slider(f"rail {name}", ground_point(), body_point(name)) for name in ("left", "right")],
        readings=[x_reading("left", "left"), x_reading("right", "right")],
        sketch=[(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)],
        loads=[spring("spring", body_point("right", -0.05), body_point("left", 0.05), stiffness, free)],
        rates={"left": speeds[0], "right": speeds[1]},
        gravity=0.0,
        size=0.5,
    )
    total = sum(masses)
    frequency = math.sqrt(stiffness * total / (masses[0] * masses[1]))
    drift = (masses[0] * speeds[0] + masses[1] * speeds[1]) / total
    centre = masses[1] * 0.5 / total

    def exact(times):
        stretch, opening = 0.5 - 0.1 - free, speeds[1] - speeds[0]
        cosine, sine = np.cos(frequency * times), np.sin(frequency * times)
        apart = free + 0.1 + stretch * cosine + opening / frequency * sine
        rate = opening * cosine - stretch * frequency * sine
        middle = centre + drift * times
        return {
            "left": (middle - masses[1] / total * apart, drift - masses[1] / total * rate),
            "right": (middle + masses[0] / total * apart, drift + masses[0] / total * rate),
        }

    return ExactCase(scene=scene, exact=exact)


def loaded_pendulum(mass: float, length: float, start: float, load, moment: Callable) -> ExactCase:
    """A rod on a pin under a load with a moment about the pin, by its angle and rate."""

    def push(q, rate):
        return moment(q, rate) - mass * GRAVITY * length / 2 * math.cos(q)

    def exact(times):
        return {"rod": tuple(integrate_one_coordinate(lambda _: (mass * length**2 / 3, 0.0), push, (start - math.pi / 2, 0.0), times))}

    return ExactCase(scene=hinged_rod(mass, length, start, loads=[load]), exact=exact)


def spring_across_a_pendulum() -> ExactCase:
    """A rod on a pin, with a spring from a point off its axis to the ground: the direction of the spring varies."""
    length, stiffness, free = 0.7, 80.0, 0.25
    hook, anchor = 0.4 + 0.1j, 0.3 - 0.9j  # the hook relative to the pin, for the rod along x
    ends = body_point("rod", hook.real - length / 2, hook.imag), ground_point(anchor.real, anchor.imag)

    def moment(q, _):
        position = hook * np.exp(1j * q)
        line = anchor - position
        pull = stiffness * (abs(line) - free) * line / abs(line)
        return (pull * (1j * position).conjugate()).real

    return loaded_pendulum(1.5, length, 0.9, spring("spring", *ends, stiffness, free), moment)


def damped_oscillation(times: FloatArray, square: float, decay: float, start: float, speed: float) -> tuple[FloatArray, FloatArray]:
    """Return x and its rate for x'' + 2 decay x' + square x = 0, in all three damping regimes, by complex roots."""
    if math.isclose(decay**2, square):
        state_rate = speed + decay * start
        fall = np.exp(-decay * times)
        return (start + state_rate * times) * fall, (state_rate - decay * (start + state_rate * times)) * fall
    root = np.sqrt(complex(decay**2 - square))
    one, two = -decay + root, -decay - root
    a = (speed - two * start) / (one - two)
    first, second = a * np.exp(one * times), (start - a) * np.exp(two * times)
    return (first + second).real, (one * first + two * second).real


def damped_mass(ratio: float = 0.2) -> ExactCase:
    """A mass between a spring and a damper of damping ratio `ratio`, on an inclined rail."""
    mass, stiffness, free, inclination = 1.2, 90.0, 0.4, 0.5
    frequency = math.sqrt(stiffness / mass)
    decay = ratio * frequency
    # The anchor is at the upper end of the rail; spring length at equilibrium:
    rest = free + mass * GRAVITY * math.sin(inclination) / stiffness
    u = np.exp(1j * inclination)
    start, speed, anchor = 0.3, 1.0, 1.0 * u  # the mass is at (1 - displacement) along the rail
    position = (1.0 - start) * u
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[slider("rail", ground_point(), body_point("mass"), inclination)],
        readings=[PointDistance(name="way", quantity="length", first=ground_point(anchor.real, anchor.imag), second=body_point("mass"))],
        sketch=[(position.real, position.imag, 0.0)],
        loads=[
            spring("spring", ground_point(anchor.real, anchor.imag), body_point("mass"), stiffness, free),
            damper("damper", body_point("mass"), ground_point(-0.5 * u.real, -0.5 * u.imag), 2 * mass * decay),
        ],
        rates={"way": speed},
        size=free,
    )

    def exact(times):
        displacement, rate = damped_oscillation(times, stiffness / mass, decay, start - rest, speed)
        return {"way": (rest + displacement, rate)}

    return ExactCase(scene=scene, exact=exact)


def damper_across_a_pendulum() -> ExactCase:
    """A rod on a pin, with a damper from a point off its axis to the ground: the direction of the damper varies."""
    length, damping = 0.7, 6.0
    hook, anchor = 0.5 + 0.1j, 0.5 - 0.9j
    ends = ground_point(anchor.real, anchor.imag), body_point("rod", hook.real - length / 2, hook.imag)

    def moment(q, rate):
        position = hook * np.exp(1j * q)
        along = (position - anchor) / abs(position - anchor)
        return -damping * (1j * position * along.conjugate()).real ** 2 * rate

    return loaded_pendulum(1.5, length, 1.4, damper("damper", *ends, damping), moment)


def wheels_on_shafts(wheels: Mapping[str, tuple[float, float, float]], loads, **options) -> Scene:
    """Return wheels on shafts of their own, half a metre apart: mass, moment of inertia and first guess of the angle of each."""
    return make_scene(
        bodies=[rotating_body(name, mass, inertia) for name, (mass, inertia, _) in wheels.items()],
        joints=[pin(f"shaft {k}", ground_point(0.5 * k), body_point(name)) for k, name in enumerate(wheels)],
        readings=[body_angle(name) for name in wheels],
        sketch=[(0.5 * k, 0.0, angle) for k, (_, _, angle) in enumerate(wheels.values())],
        loads=loads,
        size=0.5,
        **options,
    )


def torsion_pendulum(damping: float = 0.0) -> ExactCase:
    """A wheel on a torsion spring, with or without a torsion damper."""
    inertia, stiffness, free, start, speed = 0.2, 8.0, 0.3, 2.0, -1.5
    loads = [TorsionSpring(name="wire", second="wheel", stiffness=stiffness, free_angle=free)]
    if damping:
        loads.append(TorsionDamper(name="vane", second="wheel", damping=damping))
    scene = wheels_on_shafts({"wheel": (2.0, inertia, 0.0)}, loads, values={"wheel": start}, rates={"wheel": speed})

    def exact(times):
        angle, rate = damped_oscillation(times, stiffness / inertia, damping / (2 * inertia), start - free, speed)
        return {"wheel": (free + angle, rate)}

    return ExactCase(scene=scene, exact=exact)


def two_wheels_on_one_wire() -> ExactCase:
    """Two free wheels with a torsion spring and a torsion damper between them."""
    inertias, stiffness, damping, free, start, rates = (0.2, 0.5), 8.0, 0.15, 0.3, (0.1, 1.4), (2.0, -0.5)
    loads = [
        TorsionSpring(name="wire", first="first", second="second", stiffness=stiffness, free_angle=free),
        TorsionDamper(name="vane", first="second", second="first", damping=damping),
    ]
    wheels = {"first": (2.0, inertias[0], start[0]), "second": (3.0, inertias[1], start[1])}
    scene = wheels_on_shafts(wheels, loads, rates={"first": rates[0], "second": rates[1]})
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
"""Smooth to 0.45 s, a jump there, smooth again, constant from 0.9 s on; its breakpoints are not all output times."""


def stepped_program_integrals(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the value of STEPPED_PROGRAM at times (n,), its integral from 0 s and the integral of that."""
    at, values = np.array(STEPPED_PROGRAM.times), np.array(STEPPED_PROGRAM.values)
    first, second = PchipInterpolator(at[:3], values[:3]), PchipInterpolator(at[3:], values[3:])
    early, late = np.minimum(times, 0.45), np.clip(times, 0.45, 0.9)
    beyond = np.maximum(times - 0.9, 0.0)
    once = first.antiderivative(), second.antiderivative()
    twice = first.antiderivative(2), second.antiderivative(2)
    # The antiderivatives are 0 at their first points.
    level = np.where(times < 0.45, first(early), np.where(times < 0.9, second(late), values[-1]))
    single = once[0](early) + once[1](late) + values[-1] * beyond
    late_way = np.maximum(times - 0.45, 0.0)
    at_end = once[1](0.9)
    double = twice[0](early) + once[0](0.45) * late_way + twice[1](late) + at_end * beyond + values[-1] * beyond**2 / 2
    return level, single, double


def wheel_under_a_torque(*, varies: bool) -> ExactCase:
    """A wheel under an applied torque, constant or with a jump in time."""
    inertia, start, rate = 0.2, 0.3, -1.0
    motor = Torque(name="motor", second="wheel", moment=STEPPED_PROGRAM if varies else constant(1.5))
    scene = wheels_on_shafts({"wheel": (2.0, inertia, start)}, [motor], rates={"wheel": rate})

    def exact(times):
        single, double = stepped_program_integrals(times)[1:] if varies else (1.5 * times, 0.75 * times**2)
        return {"wheel": (start + rate * times + double / inertia, rate + single / inertia)}

    return ExactCase(scene=scene, exact=exact, order=SECOND_ORDER if varies else NO_ERROR)


def torque_between_two_wheels() -> ExactCase:
    """A torque against time between two wheels."""
    inertias = 0.2, 0.5
    motor = Torque(name="motor", first="first", second="second", moment=STEPPED_PROGRAM)
    scene = wheels_on_shafts({"first": (2.0, inertias[0], 0.0), "second": (3.0, inertias[1], 0.0)}, [motor])

    def exact(times):
        _, single, double = stepped_program_integrals(times)
        return {"first": (-double / inertias[0], -single / inertias[0]), "second": (double / inertias[1], single / inertias[1])}

    return ExactCase(scene=scene, exact=exact)


def mass_under_a_force(*, varies: bool) -> ExactCase:
    """A mass on an inclined rail under a force with two components, constant or one of them with a jump in time."""
    mass, inclination, upward = 1.5, 0.4, 7.0
    along = STEPPED_PROGRAM if varies else constant(3.0)
    scene = make_scene(
        bodies=[point_mass("mass", mass)],
        joints=[slider("rail", ground_point(), body_point("mass"), inclination)],
        readings=[x_reading("mass"), y_reading("mass")],
        sketch=[(0.0, 0.0, 0.0)],
        loads=[Force(name="push", point=body_point("mass"), x=along, y=constant(upward))],
        size=0.5,
    )

    def exact(times):
        single, double = stepped_program_integrals(times)[1:] if varies else (3.0 * times, 1.5 * times**2)
        rising = (upward / mass - GRAVITY) * math.sin(inclination)
        displacement = math.cos(inclination) / mass * double + rising * times**2 / 2
        rate = math.cos(inclination) / mass * single + rising * times
        return {
            "x": (math.cos(inclination) * displacement, math.cos(inclination) * rate),
            "y": (math.sin(inclination) * displacement, math.sin(inclination) * rate),
        }

    return ExactCase(scene=scene, exact=exact, order=SECOND_ORDER if varies else NO_ERROR)


def pushed_plate(*, carried: bool) -> ExactCase:
    """A plate with an off-centre force of constant direction, on a trolley or without joints.

    The rail of the trolley takes the vertical force.
    """
    mass, inertia, trolley, hook, upward = 1.5, 0.05, 0.8, 0.2 + 0.1j, 4.0
    joints = [slider("rail", ground_point(0.0, 0.2), body_point("trolley")), pin("bearing", body_point("trolley"), body_point("plate"))]
    scene = make_scene(
        bodies=[rotating_body("plate", mass, inertia), *([point_mass("trolley", trolley)] if carried else [])],
        joints=joints if carried else [],
        readings=[body_angle("plate", "turn"), x_reading("plate"), y_reading("plate")],
        sketch=[(0.1, 0.2, 0.4), *([(0.1, 0.2, 0.0)] if carried else [])],
        loads=[Force(name="push", point=body_point("plate", hook.real, hook.imag), x=STEPPED_PROGRAM, y=constant(upward))],
        rates={"turn": 1.0, "x": 0.2, **({} if carried else {"y": -0.1})},
        size=0.5,
    )
    before, after = (PchipInterpolator(STEPPED_PROGRAM.times[side], STEPPED_PROGRAM.values[side]) for side in (slice(3), slice(3, 6)))

    def state_rate(time, state, push):
        arm = hook * np.exp(1j * state[0])
        return [state[1], (arm.real * upward - arm.imag * push(min(time, 0.9))) / inertia]

    def exact(times):
        early, late = times[times <= 0.45], times[times > 0.45]
        first = integrate_state(lambda t, y: state_rate(t, y, before), (0.4, 1.0), np.append(early, 0.45))
        kinks = [at - 0.45 for at in (0.7, 0.9)]
        second = integrate_state(lambda t, y: state_rate(t + 0.45, y, after), first[:, -1], late - 0.45, breaks=kinks)
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
    "curve on a turning body": lambda: bead_on_a_turning_curve((0.1, 0.3, -0.8, 0.9)),
    "curve of the seventh degree": lambda: bead_on_a_turning_curve((0.1, 0.3, -0.8, 0.9, 0.5, -1.1, 0.7, 2.0)),
    "point mass on a massless rod": bob_on_a_massless_rod_of_a_trolley,
    "massless bell crank": massless_bell_crank,
    "gear under a torque": geared_wheels,
    "gear with a pendulum": geared_pendulum,
    "rack": falling_rack,
    "driven turn": driven_slider_crank,
    "driven turn by a table": slider_crank_driven_by_a_table,
    "driven turn by a formula": slider_crank_driven_by_a_formula,
    "driven turn, the ground second": counterweight_driven_backwards,
    "driven slide by a table": lambda: pendulum_on_a_driven_support(by_table=True),
    "driven slide by a formula": lambda: pendulum_on_a_driven_support(by_table=False),
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
    "torque, constant": lambda: wheel_under_a_torque(varies=False),
    "torque in time": lambda: wheel_under_a_torque(varies=True),
    "torque between bodies": torque_between_two_wheels,
    "force, constant": lambda: mass_under_a_force(varies=False),
    "force in time": lambda: mass_under_a_force(varies=True),
    "force off centre": lambda: pushed_plate(carried=True),
    "force off centre, no joints": lambda: pushed_plate(carried=False),
}
"""Cases by the joint or force element under test."""
