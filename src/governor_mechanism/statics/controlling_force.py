"""Controlling force of a governor: the centripetal force that its loads exert on a ball, against the ball's distance from the spindle.

With the coordinate q, potential V, moment of inertia J about the spindle, distance r of a ball from the spindle axis and n balls, virtual
work defines the controlling force of one ball by n C dr = dV,

    C = V' / (n r').

It is balanced by the centrifugal force of the spindle speed w, referred to the ball by n F dr = w^2 dJ / 2, F = w^2 J' / (2 n r') = m w^2 r
with the equivalent mass m = J' / (2 n r r'). If only the balls move away from the spindle and they are points, m is the mass of a ball and
the *speed lines* F(r) are rays through the origin; masses of arms, links and extended balls make m vary a little. Both definitions are
exact for any mechanism. The equilibrium is stable where the controlling force is steeper than the speed line through the same point,

    dC/dr - dF/dr = K / (n r'^2),

with the stiffness K = V'' - w^2 J'' / 2. A resistance W along a reading s separates the controlling forces of the rising and of the falling
governor by 2 W |s'| / (n |r'|).

References: M. Tolle, Regelung der Kraftmaschinen (C-Kurven); Th. Bevan, The Theory of Machines, chapter on governors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from numbers import Integral, Real
from typing import cast

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Column, Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics import equilibrium_speed
from governor_mechanism.statics.effort import GovernorEffort, evaluate_effort
from governor_mechanism.statics.equilibrium_speed import WorkingRange, equilibrium_speed_squared, evaluate_stability, locate_working_range
from governor_mechanism.statics.speed_curve import MAX_CURVE_POINTS, compute_insensitivity_band
from governor_mechanism.types import FloatArray, QuantityValues
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import short_repr

USUAL_NAMES = ("ball_radius", "weight_radius")
"""Names of the reading in the machines of the package; a mechanism with other distances from the axis, too, may use them."""

MIRROR_TOLERANCE = 1e-9
"""Distance from the mirror image, in length scales, within which two bodies are mirror images: rounding of the assembly, with room."""

MAX_BALLS = 100
"""Largest number of balls; a larger one is a mistake."""


@dataclass(frozen=True, kw_only=True)
class BallRadius:
    """Reading of a ball's distance from the spindle axis."""

    name: str  # name of the reading
    sign: float  # 1, or -1 if the reading is negative because the ball is to the left of the spindle
    n_balls: int  # number of balls that share the load


def find_ball_radius(
    reduction: SingleDofReduction,
    # name of the reading; None for `ball_radius`, `weight_radius`, or the only distance from the axis
    name: str | None,
    # number of balls; None for two if another body of equal mass is the mirror image of the ball, and else
    # one
    balls: int | None,
) -> BallRadius:
    """Return the reading of the ball's distance from the spindle axis."""
    mechanism = reduction.mechanism
    reading = _choose_reading(mechanism) if name is None else _validate_reading(mechanism, name)
    if balls is not None and (not isinstance(balls, Integral) or isinstance(balls, bool) or not 1 <= balls <= MAX_BALLS):
        raise MechanismError(f"balls must be a number of balls from 1 to {MAX_BALLS}; got {format_value(balls)}")
    travel = reduction.range_of_motion
    poses = reduction.evaluate(np.linspace(travel.low, travel.high, 5)).poses
    middle = float(evaluate_output_value(mechanism, reading.name, poses)[2])
    number = (2 if _has_mirror_image(mechanism, reading.point.body, poses) else 1) if balls is None else int(balls)
    return BallRadius(name=reading.name, sign=-1.0 if middle < 0.0 else 1.0, n_balls=number)


def _distances_from_axis(mechanism: Mechanism) -> dict[str, PointCoordinate]:
    """Return the readings that are x coordinates of points of bodies, by name."""
    return {one.name: one for one in mechanism.readings if isinstance(one, PointCoordinate) and _is_distance_from_axis(one)}


def _is_distance_from_axis(reading: PointCoordinate) -> bool:
    return (
        abs(reading.direction_x) == 1.0
        and reading.direction_y == 0.0
        and reading.zero == 0.0
        and (reading.origin.body, reading.origin.x) == (GROUND, 0.0)
        and reading.point.body != GROUND
    )


def _choose_reading(mechanism: Mechanism) -> PointCoordinate:
    candidates = _distances_from_axis(mechanism)
    names = [name for name in USUAL_NAMES if name in candidates] or list(candidates)
    if not names:
        raise MechanismError(
            "a controlling force needs a reading that is the distance of a ball from the spindle axis, and this mechanism has none; "
            'add one to [readings], such as ball_radius = { x = "ball.centre" }'
        )
    if len(names) > 1:
        raise MechanismError(f"several readings are distances from the spindle axis: {names}; give one of them as `radius`")
    return candidates[names[0]]


def _validate_reading(mechanism: Mechanism, name: object) -> PointCoordinate:
    if not isinstance(name, str):
        raise MechanismError(f"`radius` must be the name of a reading; got {format_value(name)}")
    mechanism.reading(name)  # raises for an unknown name
    candidates = _distances_from_axis(mechanism)
    if name not in candidates:
        raise MechanismError(f"{name!r} is not the distance of a ball from the spindle axis; such readings are {[*candidates]}")
    return candidates[name]


def _has_mirror_image(mechanism: Mechanism, ball: str, poses: FloatArray) -> bool:
    """Return whether another body of equal mass moves as the mirror image of the ball in the spindle axis."""
    index = mechanism.body_index(ball)
    images = np.abs(poses[:, :, :2] - poses[:, [index], :2] * [-1.0, 1.0]).max(axis=(0, 2)) <= MIRROR_TOLERANCE * mechanism.length_scale
    masses = np.array([body.mass for body in mechanism.bodies])
    is_same_mass = np.abs(masses - masses[index]) <= 1e-12 * masses[index]  # rounding of joined masses
    return bool(np.any(np.delete(images & is_same_mass, index)))


DEFAULT_SPEED_CHANGE = 0.01
"""Relative change of speed for effort and power that textbooks use."""

MAX_SPEED_CHANGE = 1.0
"""Largest relative change of speed; a larger one is a percentage without its sign."""

N_QUADRATURE_NODES = 64
"""Number of Gauss-Legendre nodes of the work capacity; V' is smooth between stops, so that the error is rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllingForce(Result):
    """Controlling force of one ball at positions of a governor; arrays of shape (n,).

    Attributes
    ----------
    coordinate_name
        Name of the leading coordinate.
    coordinate
        Its values, SI.
    radius_name
        Name of the reading that is the distance of a ball from the spindle axis.
    radius
        That distance, m.
    n_balls
        Number of balls that share the force.
    sleeve
        Reading of the sleeve, SI.
    force
        Controlling force C of one ball, N, positive toward the spindle; 0 where the radius has a turning point.
    force_slope
        dC/dr, N/m; 0 where the radius has a turning point.
    speed_line_slope
        dF/dr of the speed line through the point, N/m; 0 where there is no equilibrium speed.
    equivalent_mass
        Mass m with C = m w^2 r in equilibrium, kg; 0 where the radius is zero or has a turning point.
    speed
        Equilibrium speed w, rad/s; 0 where none exists.
    has_equilibrium
        Whether an equilibrium speed exists.
    stable
        Whether the equilibrium is stable: the controlling force is steeper than the speed line.
    astatic
        Whether the equilibrium is neutral: both are equally steep.
    falling_force
        Controlling force while the governor falls against the resistance, N; without resistance that of equilibrium.
    rising_force
        Controlling force while it rises against the resistance, N.
    resistance
        Resistance along the reading of the sleeve, N or N m; 0 for none.
    effort
        Effort, lift and power for a relative change of speed.
    working_range
        Working range with its sensitiveness; None if none is given and the stops, or else the ends of the travel, are no place to work at:
        there is no equilibrium speed, or it is a dead centre.
    low_end_message, high_end_message
        Sentences on what happens at the ends of the travel.
    scene
        The scene.
    """

    coordinate_name: str
    coordinate: FloatArray
    radius_name: str
    radius: FloatArray
    n_balls: int
    sleeve: FloatArray
    force: FloatArray
    force_slope: FloatArray
    speed_line_slope: FloatArray
    equivalent_mass: FloatArray
    speed: FloatArray
    has_equilibrium: NDArray[np.bool_]
    stable: NDArray[np.bool_]
    astatic: NDArray[np.bool_]
    falling_force: FloatArray
    rising_force: FloatArray
    resistance: float
    effort: GovernorEffort
    working_range: WorkingRange | None
    low_end_message: str
    high_end_message: str
    scene: Scene = field(repr=False)

    __repr__ = short_repr

    figure = "render.figures.controlling_force.controlling_force_figure"

    @property
    def index(self) -> str:
        """Name of the leading coordinate."""
        return self.coordinate_name

    @property
    def columns(self) -> tuple[Column, ...]:
        """All quantities along the travel; coordinate, radius and sleeve have the names of their readings."""
        names = {"coordinate": self.coordinate_name, "radius": self.radius_name, "sleeve": self.against}
        arrays = [one.name for one in fields(self) if isinstance(getattr(self, one.name), np.ndarray)]
        return tuple(Column(names.get(name, name), value=name) for name in arrays)

    def plot(self, equilibria: Sequence[Result] = ()) -> Figure:
        """Draw the controlling force over the radius, with speed lines and the working range.

        Parameters
        ----------
        equilibria
            Equilibria to mark, as from `gm.equilibria`.

        Returns
        -------
        Figure
            The figure.
        """
        return self._draw(equilibria)

    @property
    def against(self) -> str:
        """Name of the reading of the sleeve."""
        return self.effort.against


def compute_controlling_force(
    scene: Scene,
    # values of the leading coordinate, SI; shape (n,). None for the whole travel
    over: QuantityValues | None = None,
    *,
    points: int = 500,  # number of points over the whole travel; at least 2
    # working range: two values of one reading, SI numbers or text with a unit. None for the stops of the
    # scene, or for the travel
    between: Mapping[str, Sequence[float | str]] | None = None,
    # relative change of speed for effort and power; above 0 and at most 1
    speed_change: float = DEFAULT_SPEED_CHANGE,
    # resistance along the reading of the sleeve, N or N m, or text with a unit; None for none
    resistance: float | str | None = None,
    against: str = "sleeve_lift",
    # name of the reading that is the distance of a ball from the spindle axis; None if the mechanism has only
    # one
    radius: str | None = None,
    # number of balls that share the force; None for two if the mechanism has a mirror image of the ball, and
    # else one
    balls: int | None = None,
) -> ControllingForce:
    """Return the controlling force of a governor, with effort, power and sensitiveness."""
    equilibrium_speed.require_equilibrium_speed(scene)
    change = _validate_speed_change(speed_change)
    if not isinstance(points, Integral) or isinstance(points, bool) or not 2 <= points <= MAX_CURVE_POINTS:
        raise MechanismError(f"the controlling force needs 2 to {MAX_CURVE_POINTS:,} points; got {format_value(points)}")
    reduction = SingleDofReduction(scene)
    ball = find_ball_radius(reduction, radius, balls)
    friction, _ = equilibrium_speed.validate_resistance(reduction.mechanism, 0.0 if resistance is None else resistance, against)
    travel = reduction.range_of_motion
    if over is None:
        values = np.linspace(travel.low, travel.high, int(points))
    else:
        values = equilibrium_speed.validate_coordinate_values(reduction, over)
    limits = locate_working_range(reduction, between)
    coefficients = reduction.evaluate(values)
    forces = _BallForces(reduction, coefficients, ball)
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    has_equilibrium = speed_squared > 0.0
    speed_squared = np.where(has_equilibrium, speed_squared, 0.0)
    stiffness, astatic = evaluate_stability(coefficients, speed_squared)
    stable = has_equilibrium & (stiffness > 0.0) & ~astatic
    friction_force = np.abs(forces.refer_to_ball(friction * reduction.output_derivative(coefficients, against)))
    return ControllingForce(
        scene=scene,
        coordinate_name=reduction.mechanism.coordinate,
        coordinate=coefficients.coordinate,
        radius_name=ball.name,
        radius=forces.radius,
        n_balls=ball.n_balls,
        sleeve=equilibrium_speed.evaluate_readings(reduction.mechanism, coefficients)[against],
        force=forces.controlling_force,
        force_slope=forces.slope_of(coefficients.potential_derivative, coefficients.potential_second_derivative),
        speed_line_slope=0.5
        * speed_squared
        * forces.slope_of(coefficients.spindle_inertia_derivative, coefficients.spindle_inertia_second_derivative),
        equivalent_mass=forces.equivalent_mass,
        speed=np.sqrt(speed_squared),
        has_equilibrium=has_equilibrium,
        stable=stable,
        astatic=has_equilibrium & astatic,
        falling_force=forces.controlling_force - friction_force,
        rising_force=forces.controlling_force + friction_force,
        resistance=friction,
        effort=evaluate_effort(reduction, coefficients, stable, change, against),
        working_range=None if limits is None else _evaluate_working_range(reduction, ball, *limits, friction, against),
        low_end_message=travel.low_message,
        high_end_message=travel.high_message,
    )


class _BallForces:
    """Generalised forces referred to a ball, at the positions of some coefficients; 0 where its radius has a turning point."""

    def __init__(self, reduction: SingleDofReduction, coefficients: PathCoefficients, ball: BallRadius) -> None:
        output = evaluate_output(reduction.mechanism, ball.name, coefficients.poses, coefficients.tangents)
        self.n_balls, self.coefficients = ball.n_balls, coefficients
        self.radius = ball.sign * output.value
        self.slope = ball.sign * output.rate(coefficients.tangents)
        self.curvature = ball.sign * output.acceleration(coefficients.curvatures)

    @property
    def controlling_force(self) -> FloatArray:
        """C, N."""
        return self.refer_to_ball(self.coefficients.potential_derivative)

    @property
    def equivalent_mass(self) -> FloatArray:
        """Mass m with F = m w^2 r, kg."""
        return _divide(self.refer_to_ball(0.5 * self.coefficients.spindle_inertia_derivative), self.radius)

    def refer_to_ball(self, generalised_force: FloatArray) -> FloatArray:
        """Return the force on one ball along its radius that does the same work."""
        return _divide(generalised_force, self.n_balls * self.slope)

    def slope_of(self, generalised_force: FloatArray, derivative: FloatArray) -> FloatArray:
        """Return the derivative by the radius of a generalised force, of given derivative by the coordinate, referred to the ball."""
        return _divide(derivative * self.slope - generalised_force * self.curvature, self.n_balls * self.slope**3)


def _divide(dividend: FloatArray, divisor: FloatArray) -> FloatArray:
    quotient: FloatArray = np.divide(dividend, divisor, out=np.zeros_like(divisor), where=divisor != 0.0)
    return quotient


def _evaluate_working_range(
    reduction: SingleDofReduction, ball: BallRadius, limited_by: str, ends: tuple[float, float], friction: float, against: str
) -> WorkingRange:
    """Return the working range between two coordinates. Raise MechanismError if no speed balances the loads at one of them."""
    radius = _BallForces(reduction, reduction.evaluate(ends), ball).radius
    coordinate = np.array(ends if radius[0] <= radius[1] else ends[::-1])
    coefficients = reduction.evaluate(coordinate)
    forces = _BallForces(reduction, coefficients, ball)
    band = compute_insensitivity_band(reduction.scene, coordinate, friction, against)
    nodes, weights = np.polynomial.legendre.leggauss(N_QUADRATURE_NODES)
    middle = 0.5 * coordinate.sum()
    half_width = 0.5 * (coordinate[1] - coordinate[0])
    between = reduction.evaluate(middle + half_width * nodes)
    speed_squared = equilibrium_speed_squared(between, reduction.coordinate_scale)
    stiffness, astatic = evaluate_stability(between, speed_squared)
    return WorkingRange(
        limited_by=limited_by,
        coordinate=coordinate,
        radius=forces.radius,
        sleeve=equilibrium_speed.evaluate_readings(reduction.mechanism, coefficients)[against],
        force=forces.controlling_force,
        speed=np.sqrt(equilibrium_speed_squared(coefficients, reduction.coordinate_scale)),
        falling_speed=band.falling_speed,
        rising_speed=band.rising_speed,
        stable=bool(np.all((speed_squared > 0.0) & (stiffness > 0.0) & ~astatic)),
        work_capacity=float(half_width * (weights @ between.potential_derivative)),
    )


def _validate_speed_change(value: object) -> float:
    if not (isinstance(value, Real) and not isinstance(value, bool) and 0.0 < cast("float", value) <= MAX_SPEED_CHANGE):
        raise MechanismError(
            f"speed_change is a relative change of speed above 0 and at most {MAX_SPEED_CHANGE:g}, such as 0.01 for 1 %; "
            f"got {format_value(value)}"
        )
    return float(value)
