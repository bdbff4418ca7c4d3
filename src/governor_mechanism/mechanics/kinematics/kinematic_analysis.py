"""Kinematic analysis: positions, velocities and accelerations of a driven mechanism without integration."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_rows import point_paths
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_reading_motions
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import Gear, Joint, RotationalDriver, Slider, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Column, Result, item_column, name_values
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray
from governor_mechanism.units.text_table import short_repr

MOVED_RATE_RATIO = 1e-9
"""Rate of a reading, relative to the largest that a driver gives it, below which a driver does not move it."""


def hold_driver(joint: Joint) -> Joint:
    """Return a joint as it is; instead of a driver, a joint that keeps its value at 0 s."""
    if not isinstance(joint, RotationalDriver | TranslationalDriver):
        return joint
    value = float(CubicTimeFunction(joint.motion)(np.zeros(1))[0])
    if isinstance(joint, RotationalDriver):
        return Gear(name=joint.name, first=joint.first, second=joint.second, ratio=1.0, offset=value)
    along_x, along_y = value * math.cos(joint.angle), value * math.sin(joint.angle)
    start = replace(joint.first, x=joint.first.x + along_x, y=joint.first.y + along_y)
    return Slider(name=joint.name, first=start, second=joint.second, angle=joint.angle + math.pi / 2)


def release_drivers(
    mechanism: Mechanism,
    reading: str,
    start_values: dict[str, float],  # values of readings at the start, SI
) -> Mechanism:
    """Return a mechanism whose drivers do not move a reading: those that did are left out, the others stand still."""
    drivers = [joint for joint in mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
    if len(drivers) < 2:
        return replace(mechanism, joints=tuple(joint for joint in mechanism.joints if joint not in drivers))
    solver = PositionSolver(mechanism)
    poses = solver.solve(start_values)
    rates = np.abs(_rates_of_reading(solver, poses, reading))
    moving = [driver for driver, rate in zip(drivers, rates, strict=True) if rate > MOVED_RATE_RATIO * np.max(rates)]
    held = tuple(hold_driver(joint) for joint in mechanism.joints if joint not in moving)
    return replace(mechanism, joints=held, initial_guess=tuple((x, y, angle) for x, y, angle in poses.tolist()))


def _rates_of_reading(solver: PositionSolver, poses: FloatArray, reading: str) -> FloatArray:
    """Return the rate of a reading at unit rate of each driver, at poses (bodies, 3)."""
    mechanism = solver.mechanism
    gradient = evaluate_output(mechanism, reading, poses).gradient
    rates = np.zeros(len(mechanism.joints))
    for row in np.flatnonzero(solver.equations.is_driven):
        unit_rate = np.eye(len(solver.equations.joint_indices))[row]
        velocities = solver.expand_free(np.linalg.lstsq(solver.jacobian(poses, []), unit_rate, rcond=None)[0])
        rates[solver.equations.joint_indices[row]] = float(np.sum(gradient * velocities))
    is_driver = [isinstance(joint, RotationalDriver | TranslationalDriver) for joint in mechanism.joints]
    return rates[is_driver]


TIME_VARIABLE = "time"
"""Name of the independent variable of drivers."""


RATE_PREFIX, ACCELERATION_PREFIX = "rate_of_", "acceleration_of_"
"""What stands before a reading in the names of its time derivatives."""

KEPT_STARTS = 16
"""Number of mechanisms whose start is kept: studies follow one of them again and again."""

MAX_REGULAR_SLOPE = 1e6
"""Largest derivative of a pose by the reading, in scales of both, of a configuration that is not almost singular."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Kinematics(Result):
    """Kinematics of a mechanism at n values of a reading, or at n times.

    Attributes
    ----------
    over
        Name of the reading, or "time".
    values
        Values of the reading, SI, or times, s; shape (n,).
    poses
        Poses of the mass centres, m and rad; shape (n, bodies, 3).
    velocities
        Velocities, m/s and rad/s; shape (n, bodies, 3).
    accelerations
        Accelerations, m/s2 and rad/s2; shape (n, bodies, 3).
    readings
        Readings by name, SI; shape (n,).
    rates
        First time derivatives of the readings; shape (n,).
    reading_accelerations
        Second time derivatives of the readings; shape (n,).
    paths
        Paths of named points, of pins that move (by the name of the joint) and of mass centres (by that of the body), m; shape (n, 2).
    """

    over: str
    values: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    readings: Mapping[str, FloatArray]
    rates: Mapping[str, FloatArray]
    reading_accelerations: Mapping[str, FloatArray]
    paths: Mapping[str, FloatArray]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", name_values("reading", self.readings))
        object.__setattr__(self, "rates", name_values("rate", self.rates))
        object.__setattr__(self, "reading_accelerations", name_values("reading", self.reading_accelerations))
        object.__setattr__(self, "paths", name_values("point", self.paths))

    def __getitem__(self, name: str) -> FloatArray:
        """Return a reading, "rate_of_" or "acceleration_of_" one, by the names that `crosscheck` lists; shape (n,), SI."""
        for prefix, values in ((RATE_PREFIX, self.rates), (ACCELERATION_PREFIX, self.reading_accelerations)):
            if name.startswith(prefix) and name not in self.readings:
                return values[name.removeprefix(prefix)]
        return self.readings[name]

    def __iter__(self) -> Iterator[str]:
        """Yield these names."""
        yield from self.readings
        yield from (f"{RATE_PREFIX}{name}" for name in self.rates)
        yield from (f"{ACCELERATION_PREFIX}{name}" for name in self.reading_accelerations)

    def __contains__(self, name: object) -> bool:
        """Return whether this is one of the names."""
        return any(name == known for known in self)

    @property
    def index(self) -> str:
        """Name of the reading that drives the mechanism, or "time"."""
        return self.over

    @property
    def columns(self) -> tuple[Column, ...]:
        """Values of the driving reading or times, readings, rates and accelerations."""
        kinds = {"": "readings", "rate of ": "rates", "acceleration of ": "reading_accelerations"}
        columns = [item_column(f"{start}{name}", kind, name) for start, kind in kinds.items() for name in getattr(self, kind)]
        return Column(self.over, value="values"), *columns

    def plot_paths(self, *points: str) -> Figure:
        """Draw the paths of points to one scale on both axes; `save` writes the figure.

        The arguments are names of `paths`; without any, the first eight are drawn: named points stand before pins and mass centres.

        Returns
        -------
        Figure
            The figure.

        Raises
        ------
        MechanismError
            If there is no such point.
        """
        from governor_mechanism.render.figures.kinematics import path_figure

        return path_figure(f"over {self.over}", self.paths, points)


def solve_kinematics(
    scene: Scene,
    over: str,
    values: Sequence[float] | FloatArray,  # values of the reading, SI, or times, s; shape (n,)
    rate: float = 1.0,  # first time derivative of the reading at each value, SI/s
    acceleration: float = 0.0,  # second time derivative of the reading at each value, SI/s2
) -> Kinematics:
    """Return positions, velocities and accelerations over values of a reading or over time.

    Over a reading, it drives the mechanism in place of the drivers that move it in the scene; others stand still where they start. Over
    "time", the drivers move the mechanism.

    Raises MechanismError if degrees of freedom remain, if the mechanism cannot be assembled, or at a singular
    configuration.
    """
    samples = validate_samples(over, values, rate, acceleration)
    # Alone, a part is studied without the shaft of a free spindle.
    mechanism = scene.part.mechanism if len(scene.parts) == 1 else scene.mechanism
    driving_readings = [] if over == TIME_VARIABLE else [over]
    given = {name: float(value) for name, value in scene.start.values.items() if isinstance(value, float | int)}
    mechanism, poses = _find_start(mechanism, over, tuple(given.items()) if driving_readings else ())
    position_solver = PositionSolver(mechanism)
    followed = None if over == TIME_VARIABLE else _follow_reading(replace(mechanism, coordinate=over), poses, samples, rate, acceleration)
    if followed is None:
        states = list[tuple[FloatArray, FloatArray, FloatArray]]()
        for value in samples.tolist():  # each assembly starts from the previous one
            position_solver.time = 0.0 if driving_readings else value
            states.append(_solve_motion(position_solver, driving_readings, value, (rate, acceleration), states[-1][0] if states else poses))
        poses, velocities, accelerations = (np.array(column) for column in zip(*states, strict=True))
    else:
        poses, velocities, accelerations = followed
    motions = evaluate_reading_motions(mechanism, poses, velocities, accelerations)
    return Kinematics(
        over=over,
        values=samples,
        poses=poses,
        velocities=velocities,
        accelerations=accelerations,
        readings={name: values for name, (values, _, _) in motions.items()},
        rates={name: rates for name, (_, rates, _) in motions.items()},
        reading_accelerations={name: second for name, (_, _, second) in motions.items()},
        paths=point_paths(mechanism, poses),
    )


@lru_cache(maxsize=KEPT_STARTS)
def _find_start(mechanism: Mechanism, over: str, start_values: tuple[tuple[str, float], ...]) -> tuple[Mechanism, FloatArray]:
    """Return the mechanism without drivers that move a reading, and its first poses (bodies, 3); raise if they stay free."""
    # Over "time" all drivers stay.
    required, reason = 0, "over 'time' the drivers must determine the motion"
    if over != TIME_VARIABLE:
        mechanism.reading(over)
        required, reason = 1, f"over {over!r} one reading must determine the motion"
        mechanism = release_drivers(mechanism, over, dict(start_values))
    position_solver = PositionSolver(mechanism)
    poses = position_solver.solve(dict(start_values))
    degrees_of_freedom = position_solver.count_degrees_of_freedom(poses)
    if degrees_of_freedom != required:
        raise MechanismError(f"a kinematic analysis needs {required} degrees of freedom: {reason}; this mechanism has {degrees_of_freedom}")
    poses.flags.writeable = False
    return mechanism, poses


def _follow_reading(
    mechanism: Mechanism, poses: FloatArray, samples: FloatArray, rate: float, acceleration: float
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return poses, velocities and accelerations (n, bodies, 3) at values of the coordinate; None near a singular configuration."""
    nodes = CoordinateSolver(mechanism).follow(poses, samples)
    scales = mechanism.output_scale(mechanism.coordinate) / np.array([mechanism.length_scale, mechanism.length_scale, 1.0])
    if len(nodes) < len(samples) or np.max(np.abs(nodes[:, 1] * scales)) > MAX_REGULAR_SLOPE:
        return None  # step by step, the first value that is not reached is found and named
    tangents, curvatures = nodes[:, 1], nodes[:, 2]
    return nodes[:, 0], rate * tangents, acceleration * tangents + rate**2 * curvatures


def _solve_motion(
    position_solver: PositionSolver, driving_readings: list[str], value: float, rates: tuple[float, float], guess: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return poses, velocities and accelerations (bodies, 3) at a value of the driving reading or at the time of the solver."""
    mechanism = position_solver.mechanism
    equations = position_solver.equations
    time = position_solver.time
    try:
        poses = position_solver.solve(dict.fromkeys(driving_readings, value), guess)
    except MechanismError as error:
        time_clause = "" if driving_readings else f"at t = {value:.6g} s, at the positions of its drivers: "
        raise MechanismError(f"{time_clause}{error}") from error
    jacobian = position_solver.jacobian(poses, driving_readings)
    _require_nonsingular(position_solver, jacobian, driving_readings, value)

    def solve_free_coordinates(joint_terms: FloatArray, output_terms: list[float]) -> FloatArray:
        return position_solver.expand_free(np.linalg.lstsq(jacobian, np.append(joint_terms, output_terms), rcond=None)[0])

    velocities = solve_free_coordinates(equations.prescribed_motion(np.array(time))[:, 1], [rates[0]] * len(driving_readings))
    quadratic_terms = [evaluate_output(mechanism, name, poses, velocities).quadratic_velocity_term for name in driving_readings]
    accelerations = solve_free_coordinates(equations.gamma(poses, velocities, time), [rates[1] - float(term) for term in quadratic_terms])
    return poses, velocities, accelerations


def _require_nonsingular(position_solver: PositionSolver, jacobian: FloatArray, driving_readings: list[str], value: float) -> None:
    scaled_jacobian = jacobian * position_solver.free_coordinate_scales
    row_norms = np.linalg.norm(scaled_jacobian, axis=1, keepdims=True)
    singular_values = np.linalg.svd(scaled_jacobian / np.where(row_norms > 0, row_norms, 1.0), compute_uv=False)
    if np.sum(singular_values > RANK_TOLERANCE * singular_values[0]) < jacobian.shape[1]:
        location = f"{driving_readings[0]} = {value:.6g}" if driving_readings else f"t = {value:.6g} s"
        raise MechanismError(
            f"at {location} the configuration is singular: the drivers do not determine the motion; "
            "leave this value out, or drive the mechanism elsewhere"
        )


def validate_samples(over: str, values: Sequence[float] | FloatArray, rate: float = 0.0, acceleration: float = 0.0) -> FloatArray:
    """Return the values (n,) of a reading or of time; refuse values, a rate or an acceleration that are not finite."""
    for what, number in (("rate", rate), ("acceleration", acceleration)):
        if not isinstance(number, int | float):
            raise MechanismError(f"{what} of {over!r} must be a number in SI; got {number!r}")
        require_finite(number, "", f"{what} of {over!r}")
    try:
        samples = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        samples = np.array([np.nan])
    if samples.ndim != 1 or not samples.size or not np.all(np.isfinite(samples)):
        raise MechanismError(f"values of {over!r} must be a list of finite numbers in SI; got {values!r}")
    return samples
