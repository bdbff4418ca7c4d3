"""Where a governed engine is stable: eigenvalues with mean torque over two parameters, and the border under the cyclic torque.

The state at a crank angle is carried over one period by the engine of the simulation. Newton's method finds the state that comes back
after a turn, and the period. The derivative of the state after a period by the state before it has the Floquet multipliers as
eigenvalues: small deviations grow if one of them is larger than 1 in magnitude. One is 1, for a shift in time.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.closed_form.governed_engine import CharacteristicCoefficients, pendulum_coefficients, vyshnegradskii_parameters
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Stops
from governor_mechanism.engines import select_engine
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines import pendulum
from governor_mechanism.machines.flywheel_engine import MEAN, FlywheelEngine
from governor_mechanism.model.coupling.couplings import ControlCoupling, FollowCoupling
from governor_mechanism.model.part import FreeSpindle, Start
from governor_mechanism.model.results.result import Column, Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with, replace_document_value
from governor_mechanism.scenes.schema import rate_key
from governor_mechanism.statics.linearisation import Linearisation, linearise_scene
from governor_mechanism.studies.plain_runs import SLEEVE_READING
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine, OperatingPoint
from governor_mechanism.studies.sweep.parameters import SweepAxis, parse_axes
from governor_mechanism.studies.sweep.workers import compute_in_parallel
from governor_mechanism.types import ComplexArray, FloatArray
from governor_mechanism.units.text_table import short_repr

RUN_ACCURACY = 1e-10
"""Accuracy of the runs of a turn, whose differences give derivatives."""

DIFFERENCE_STEP = 1e-5
"""Change of a state, relative to its scale, for its derivatives: rounding and curvature then cost about the same."""

RETURN_TOLERANCE = 1e-9
"""Largest distance between the states before and after a turn of a periodic motion, relative to their scales: ten times `RUN_ACCURACY`."""

MAX_ITERATIONS = 20
"""Largest number of Newton steps."""

SUFFICIENT_DECREASE = 0.1
"""Ratio of successive distances above which Newton's method computes its Jacobian again."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PeriodicMotion:
    """A periodic motion of a governed engine."""

    period: float  # time of a turn of the shaft, s
    # angle and speed of the shaft, coordinate and rate of the governor at the start of the turn, SI
    state: FloatArray
    multipliers: ComplexArray  # floquet multipliers of a turn without that of a shift in time, the largest first
    return_error: float  # distance between the states before and after the turn, relative to their scales
    turn_jacobian: FloatArray  # derivative of the state after the turn by that before, both relative to their scales; shape (4, 4)
    point: OperatingPoint  # equilibrium with mean torque, of this motion or of the one at which the search began

    @property
    def growth_rate(self) -> float:
        """Growth rate of the least damped small motion, 1/s; positive if the engine hunts."""
        return math.log(abs(self.multipliers[0])) / self.period

    @property
    def frequency(self) -> float:
        """Frequency of the least damped small motion, rad/s; up to a multiple of that of the shaft."""
        return abs(cmath.phase(self.multipliers[0])) / self.period


def find_periodic_motion(
    scene: Scene,  # scene of a governed engine without contacts on its governor
    torque: float,  # load, N m
    near: PeriodicMotion | None = None,  # motion of a similar scene, at which the search begins
) -> PeriodicMotion:
    """Return the periodic motion of a governed engine under a constant load."""
    governed = GovernedEngine(GovernedEngine(scene).with_constant_load(torque))
    return _TurnMap(governed, near.point if near else governed.operating_point(torque)).solve(near)


class _TurnMap:
    """The state of a governed engine after a time, as a function of that before."""

    def __init__(self, governed: GovernedEngine, point: OperatingPoint) -> None:
        self._governed, self._point = governed, point
        self._started = governed.started_at(point)
        start = self._started.system.start
        angle = start.values.get(governed.shaft_angle, 0.0)
        angle = angle if isinstance(angle, float) else 0.0
        speed = start.rates[governed.shaft_angle]
        self._state = np.array([angle, speed, point.coordinate, 0.0])
        self._period = math.tau / point.shaft_speed
        scale = governed.coordinate_scale
        self._scales = np.array([1.0, point.shaft_speed, scale, scale * point.shaft_speed])

    def solve(self, near: PeriodicMotion | None = None) -> PeriodicMotion:
        """Return the periodic motion near the operating point, or near another motion."""
        # A Jacobian costs eight runs, so that one is kept while the distance between the states
        # shrinks well.
        state, period = (near.state, near.period) if near else (self._state, self._period)
        jacobian = near.turn_jacobian if near else None
        matrix = None
        previous = math.inf
        shift = np.array([math.tau, 0.0, 0.0, 0.0])
        for _ in range(MAX_ITERATIONS):
            end = self._advance(state, period)
            residual = (end - state - shift) / self._scales
            size = float(np.abs(residual).max())
            if size <= RETURN_TOLERANCE:
                return self._motion(state, period, self._derivative_by_state(state, period), size)
            if matrix is None or size > SUFFICIENT_DECREASE * previous:
                if jacobian is None or matrix is not None:
                    jacobian = self._derivative_by_state(state, period)
                matrix = self._newton_matrix(jacobian, state, period, end)
            correction, previous = np.linalg.solve(matrix, -residual), size
            state = state + self._scales * np.append(0.0, correction[:3])
            period *= 1.0 + float(np.clip(correction[3], -0.5, 0.5))
        raise MechanismError(
            f"no periodic motion was found near the equilibrium at {self._state[1]:.6g} rad/s: after {MAX_ITERATIONS} steps the state "
            f"after a turn differs by {np.abs(residual).max():.3g} of its scale; increase the inertia of the flywheel"
        )

    def _newton_matrix(self, jacobian: FloatArray, state: FloatArray, period: float, end: FloatArray) -> FloatArray:
        """Return the derivatives of the residual by speed, coordinate and rate at a fixed angle, and by the period."""
        step = DIFFERENCE_STEP * period
        by_period = (self._advance(state, period + step) - end) / step * period / self._scales
        return np.column_stack([(jacobian - np.eye(4))[:, 1:], by_period])

    def _motion(self, state: FloatArray, period: float, jacobian: FloatArray, error: float) -> PeriodicMotion:
        """Return the periodic motion, without the multiplier nearest to 1, that of a shift in time."""
        multipliers = np.linalg.eigvals(jacobian)
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
        order = np.argsort(-np.abs(multipliers), kind="stable")
        return PeriodicMotion(
            period=period,
            state=state,
            multipliers=multipliers[order].astype(complex),
            return_error=error,
            turn_jacobian=jacobian,
            point=self._point,
        )

    def _derivative_by_state(self, state: FloatArray, period: float) -> FloatArray:
        """Return the derivative (4, 4) of the state after a period by that before, both relative to their scales."""
        columns = []
        for k in range(len(state)):
            change = np.zeros_like(state)
            change[k] = DIFFERENCE_STEP * self._scales[k]
            difference = self._advance(state + change, period) - self._advance(state - change, period)
            columns.append(difference / (2 * DIFFERENCE_STEP) / self._scales)
        return np.column_stack(columns)

    def _advance(self, state: FloatArray, duration: float) -> FloatArray:
        """Return the state after a time, s."""
        governed = self._governed
        scene = _with_start(self._started, governed, state, duration)
        engine, reason = select_engine("auto", scene)
        run = engine.run(scene, accuracy=RUN_ACCURACY, certify=False, reason=reason)
        run.raise_if_failed()
        shaft, coordinate = governed.shaft_angle, governed.coordinate
        return np.array([run.readings[shaft][-1], run.rates[shaft][-1], run.readings[coordinate][-1], run.rates[coordinate][-1]])


def _with_start(scene: Scene, governed: GovernedEngine, state: FloatArray, duration: float) -> Scene:
    """Return the scene with a start in a state, for a run of a duration (s) with reports at its ends."""
    angle, speed, position, rate = state.tolist()
    shaft_part, shaft_reading = scene.part_of(governed.shaft_angle)
    parts = []
    for part in scene.parts:
        start = part.start
        if part is shaft_part:
            start = Start(values={**start.values, shaft_reading: angle}, rates={**start.rates, shaft_reading: speed})
        elif part.name == governed.governor:
            coordinate = part.mechanism.coordinate
            start = Start(values={**start.values, coordinate: position}, rates={coordinate: rate})
        parts.append(replace(part, start=start))
    return replace(scene, parts=tuple(parts), run=replace(scene.run, duration=duration, output_interval=duration), document={})


def characteristic_coefficients_of(governed: GovernedEngine, point: OperatingPoint) -> CharacteristicCoefficients | None:
    """Return the polynomial of the loop with mean torque, by Vyshnegradskii's theory with the reaction of the governor."""
    part = next(one for one in governed.scene.parts if one.name == governed.governor)
    dashpots = [one for one in part.effects if isinstance(one, Dashpot)]
    others = [one for one in part.effects if not isinstance(one, Dashpot | Gravity | Centrifugal | Stops)]
    if part.machine != pendulum.PendulumGovernor.name or others:
        return None
    if any(one.reading != SLEEVE_READING or one.quadratic for one in dashpots):
        return None
    is_follower = any(isinstance(one, FollowCoupling) for one in governed.scene.couplings)
    return pendulum_coefficients(
        PendulumGovernor(**part.dimensions, gravity=part.gravity),
        arm_angle=point.coordinate,
        flywheel_inertia=governed.shaft_inertia,
        torque_slope=governed.torque_slope(point),
        sleeve_damping=sum(one.linear for one in dashpots),
        gear_ratio=abs(governed.ratio),
        spindle_inertia=part.spindle.inertia if isinstance(part.spindle, FreeSpindle) else 0.0,
        reacts=not is_follower,
    )


DEFAULT_COUNT = 40
"""Number of values of each parameter unless they are given."""

DEFAULT_RANGES = {"inertia": (0.2, 2.0), "sleeve": (0.005, 1.4)}
"""Range of a parameter unless it is given, relative to its value in the scene, by the last word of its key."""

N_BORDER_COLUMNS = 8
"""Values of the first parameter at which the border under the cyclic torque is located."""

FIRST_WIDTH = 0.01
"""Distance from the border with mean torque at which that under the cyclic torque is first looked for, relative to the range."""

BORDER_TOLERANCE = 1e-5
"""Tolerance of the border, relative to the range of the parameter: the multipliers are as accurate, see `periodic_motion`."""


@dataclass(frozen=True, kw_only=True)
class BorderPoint:
    """A point of the border between stability and hunting."""

    x: float  # value of the first parameter, SI
    mean: float  # value of the second parameter at the border with mean torque, SI
    cyclic: float | None  # the same under the cyclic torque; None if the scene has a mean torque
    frequency: float  # frequency of hunting with mean torque at the border, rad/s


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityMap(Result):
    """Stability of a governed engine over two parameters.

    Attributes
    ----------
    title
        Title of the scene.
    x, y
        The parameters; the growth rates have a row for each value of y.
    growth_rates
        Largest real part of the eigenvalues with mean torque, 1/s; not a number where there is no steady state; shape (ny, nx).
    frequencies
        Frequency of that mode, rad/s; shape (ny, nx).
    parameters
        Vyshnegradskii's x and y by hand; not a number where the closed form does not apply; shape (2, ny, nx).
    border
        Border by the simulation at some values of x.
    place
        Values of both parameters in the scene, SI; not a number for one that is no number there.
    load_fraction
        Load of the steady state, relative to the rated torque.
    """

    title: str
    x: SweepAxis
    y: SweepAxis
    growth_rates: FloatArray
    frequencies: FloatArray
    parameters: FloatArray
    border: tuple[BorderPoint, ...]
    place: tuple[float, float]
    load_fraction: float

    __repr__ = short_repr

    figure = "render.figures.regulation.stability_map_figure"
    data_files = ("json",)
    record = ("title", "x", "y", "growth_rates", "frequencies", "border", "load_fraction", "stable_share")

    @property
    def columns(self) -> tuple[Column, ...]:
        """Both parameters, growth rate and frequency, and Vyshnegradskii's x and y, of every point."""
        return (
            Column(self.x.key, unit=self.x.unit, value=lambda study: np.tile(study.x.values, len(study.y.values))),
            Column(self.y.key, unit=self.y.unit, value=lambda study: np.repeat(study.y.values, len(study.x.values))),
            Column("growth_rate", unit="1/s", value=lambda study: study.growth_rates.ravel()),
            Column("frequency", unit="rad/s", value=lambda study: study.frequencies.ravel()),
            Column("vyshnegradskii_x", value=lambda study: study.parameters[0].ravel()),
            Column("vyshnegradskii_y", value=lambda study: study.parameters[1].ravel()),
        )

    @property
    def stable_share(self) -> float:
        """Part of the points that are stable."""
        return float(np.mean(self.growth_rates < 0.0))

    @property
    def disagreements(self) -> int:
        """Number of points at which the sign of the growth rate differs from that of 1 - x y of the closed form."""
        excess = self.parameters[0] * self.parameters[1] - 1.0
        return int(np.sum(np.isfinite(excess) & ((excess > 0.0) != (self.growth_rates < 0.0))))

    def __str__(self) -> str:
        """Return how much is stable, and the border."""
        n = self.growth_rates.size
        lines = [f"{n} points, load {100 * self.load_fraction:.4g} %: {self.stable_share:.1%} stable with mean torque"]
        if np.isfinite(self.parameters).any():
            n_known = int(np.isfinite(self.parameters[0]).sum())
            lines.append(f"eigenvalues and Vyshnegradskii's limit x y = 1 agree in {n_known - self.disagreements} of {n_known} points")
        x_factor, x_unit = self.x.display_unit
        y_factor, y_unit = self.y.display_unit
        for point in self.border:
            cyclic = "" if point.cyclic is None else f", {point.cyclic * y_factor:.6g} {y_unit} under the cyclic torque"
            where = f"border at {point.x * x_factor:.5g} {x_unit}: {point.mean * y_factor:.6g} {y_unit} with mean torque"
            lines.append(f"{where}{cyclic}; hunting at {point.frequency:.5g} rad/s")
        return "\n".join(lines)


def map_stability(
    scene: Scene,
    # two texts "key=first:last:count"; inertia of the flywheel and dashpot on the sleeve if empty
    vary: Sequence[str] = (),
    *,
    # values of the first parameter at which the border is located by simulation
    n_border_columns: int = N_BORDER_COLUMNS,
    n_workers: int = 1,
    progress: Callable[[int, int], None] | None = None,  # called with the numbers of points done and of all
) -> StabilityMap:
    """Return the stability of a governed engine over two parameters, under its last load."""
    if not scene.document:
        raise MechanismError("a stability map needs a scene from a file or a document, whose keys can be varied")
    governed = GovernedEngine(scene)
    fraction = governed.load.fraction.values[-1]
    document = replace_document_value(scene.document, "load.fraction", fraction)
    axes = parse_axes(document, list(vary) or _default_axes(governed, document))
    if len(axes) != 2 or not all(axis.is_numeric and len(axis.values) > 1 for axis in axes):
        raise MechanismError("a stability map has two parameters, each key=first:last:count with two values or more")
    points = _MapPoints(_mean_torque_document(governed, document), axes)
    n_points = len(axes[0].values) * len(axes[1].values)
    grid = np.full((4, n_points), np.nan)
    n_done, n_all = 0, n_points + (n_border_columns if n_border_columns else 0)
    for rows in compute_in_parallel(points, range(n_points), n_workers):
        for index, *values in rows:
            grid[:, index] = values
        n_done += len(rows)
        if progress:
            progress(n_done, n_all)
    shape = len(axes[0].values), len(axes[1].values)
    growth, frequencies, first, second = (one.reshape(shape).T for one in grid)
    brackets = {k: pair for k in range(shape[0]) if (pair := _brackets(growth[:, k]))}
    chosen = np.linspace(0, len(brackets) - 1, min(n_border_columns, len(brackets))).round().astype(int).tolist()
    bracketed = [list(brackets)[k] for k in chosen]
    border_columns = _BorderColumns(points, None if governed.has_mean_torque else document, brackets)
    found = [point for rows in compute_in_parallel(border_columns, bracketed, n_workers) for point in rows]
    return StabilityMap(
        title=scene.title,
        x=axes[0],
        y=axes[1],
        growth_rates=growth,
        frequencies=frequencies,
        parameters=np.array([first, second]),
        border=tuple(sorted(found, key=lambda point: point.x)),
        place=(_value_at(scene, axes[0]), _value_at(scene, axes[1])),
        load_fraction=fraction,
    )


def _default_axes(governed: GovernedEngine, document: Mapping[str, Any]) -> list[str]:
    """Return ranges of the flywheel's inertia and of the dashpot on the sleeve about their values in the scene."""
    engine, _ = governed.shaft_angle.split(".", 1)
    keys = (f"part.{engine}.dimensions.inertia", f"part.{governed.governor}.effects.dashpot.sleeve")
    ranges = []
    for key in keys:
        value = _number_at(governed.scene, key)
        if not value > 0.0:
            raise MechanismError(f"{key} is no number above 0 in this scene; give both parameters, as {key}=first:last:count")
        low, high = DEFAULT_RANGES[key.rpartition(".")[2]]
        ranges.append(f"{key}={low * value:.6g}:{high * value:.6g}:{DEFAULT_COUNT}")
    return ranges


def _value_at(scene: Scene, axis: SweepAxis) -> float:
    return _number_at(scene, axis.key)


def _number_at(scene: Scene, key: str) -> float:
    """Return the value of a key of a scene in SI; not a number unless it is one."""
    value: Any = scene.document
    for name in key.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    if not isinstance(value, int | float | str) or isinstance(value, bool):
        return float("nan")
    axis = parse_axes(scene.document, {key: [value]})[0]
    return axis.values[0] if isinstance(axis.values[0], float) else float("nan")


def _mean_torque_document(governed: GovernedEngine, document: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the document of the loop with mean torque, started at the equilibrium by statics."""
    scene, engine = governed.scene, governed.shaft_angle.split(".", 1)[0]
    part = next(one for one in scene.parts if one.name == engine)
    if part.machine == FlywheelEngine.name:
        controls = (one for one in scene.couplings if isinstance(one, ControlCoupling))
        if moving := next((one for one in controls if one.target == f"{engine}.cut_off"), None):
            what = f"coupling {moving.name!r} moves the cut-off, and a map needs the mean torque, which takes a constant one"
            raise MechanismError(f"{what}; let the governor move a throttle, or use `regulation loop`")
        document = replace_document_value(document, f"part.{engine}.dimensions.gas_torque", MEAN)
    point = governed.operating_point(governed.load.fraction.values[-1] * governed.load.rated_torque)
    shaft, coordinate = governed.shaft_angle.split(".", 1)[1], governed.coordinate.split(".", 1)[1]
    document = replace_document_value(document, f"part.{engine}.start.{rate_key(shaft)}", point.shaft_speed)
    changed: Mapping[str, Any] = replace_document_value(document, f"part.{governed.governor}.start.{coordinate}", point.coordinate)
    return changed


@dataclass(frozen=True)
class _MapPoints:
    """Function of points of a grid, whose rows are independent: it can be sent to other processes."""

    document: Mapping[str, Any]
    axes: tuple[SweepAxis, ...]

    def __call__(self, index: int) -> tuple[int, float, float, float, float]:
        """Return index, growth rate, frequency and Vyshnegradskii's parameters of a point."""
        places = divmod(index, len(self.axes[1].values))
        x, y = (float(axis.values[place]) for axis, place in zip(self.axes, places, strict=True))
        return index, *self._evaluate(x, y)

    def scene_at(self, x: float, y: float, document: Mapping[str, Any] | None = None) -> Scene:
        """Return the scene at values of both parameters, SI."""
        return parse_scene_with(document or self.document, [(self.axes[0].key, x), (self.axes[1].key, y)])

    def linearise(self, x: float, y: float) -> Linearisation:
        """Return the linearised loop with mean torque."""
        scene = self.scene_at(x, y)
        return linearise_scene(scene, *initial_state(scene))

    def _evaluate(self, x: float, y: float) -> tuple[float, float, float, float]:
        """Return growth rate, frequency and Vyshnegradskii's parameters."""
        try:
            scene = self.scene_at(x, y)
            linearisation = linearise_scene(scene, *initial_state(scene))
        except MechanismError:
            return np.nan, np.nan, np.nan, np.nan
        governed = GovernedEngine(scene)
        point = governed.point_at(linearisation.readings[governed.coordinate])
        coefficients = characteristic_coefficients_of(governed, point)
        parameters = (np.nan, np.nan)
        if coefficients is not None and coefficients.c > 0:
            first, second = vyshnegradskii_parameters(coefficients)
            parameters = float(first), float(second)
        return linearisation.critical_real_part, linearisation.critical_frequency, *parameters


@dataclass(frozen=True)
class _BorderColumns:
    """Function of columns of a map, which locates the border in each: it can be sent to other processes."""

    points: _MapPoints
    cyclic_document: Mapping[str, Any] | None
    brackets: Mapping[int, tuple[int, int]]

    def __call__(self, index: int) -> BorderPoint:
        """Return the border at a value of the first parameter."""
        from scipy.optimize import brentq  # slow to import

        x_axis, y_axis = self.points.axes
        x, bracket = float(x_axis.values[index]), self.brackets[index]
        values = [float(value) for value in y_axis.values]
        low, high = (values[k] for k in bracket)
        mean = float(
            brentq(lambda y: self.points.linearise(x, y).critical_real_part, low, high, rtol=1e-12, xtol=1e-12 * max(abs(low), abs(high)))
        )
        frequency = self.points.linearise(x, mean).critical_frequency
        cyclic = None if self.cyclic_document is None else self._locate_cyclic(x, mean, (min(values), max(values)))
        return BorderPoint(x=x, mean=mean, cyclic=cyclic, frequency=frequency)

    def _locate_cyclic(self, x: float, mean: float, ends: tuple[float, float]) -> float | None:
        """Return the border under the cyclic torque near that with mean torque; None if it is not within the range."""
        from scipy.optimize import brentq  # slow to import

        near: PeriodicMotion | None = None

        def growth_rate(y: float) -> float:
            nonlocal near
            scene = self.points.scene_at(x, y, self.cyclic_document)
            governed = GovernedEngine(scene)
            near = find_periodic_motion(scene, governed.load.fraction.values[-1] * governed.load.rated_torque, near)
            return near.growth_rate

        width = FIRST_WIDTH * (ends[1] - ends[0])
        at_mean = growth_rate(mean)
        while width <= ends[1] - ends[0]:
            for other in (mean - width, mean + width):
                if ends[0] <= other <= ends[1] and growth_rate(other) * at_mean < 0.0:
                    return float(brentq(growth_rate, *sorted((mean, other)), xtol=BORDER_TOLERANCE * (ends[1] - ends[0])))
            width *= 4.0
        return None


def _brackets(growth_rates: FloatArray) -> tuple[int, int] | None:
    """Return the first neighbours in a column between which the growth rate changes its sign, or None."""
    changes = np.flatnonzero(growth_rates[:-1] * growth_rates[1:] < 0.0)
    return (int(changes[0]), int(changes[0]) + 1) if len(changes) else None
