"""The equilibria of a scene at one speed, with speed curve, controlling force and insensitivity, as one result that prints as text."""

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ParamSpec, TypeVar

from governor_mechanism.engines.initial_state import initial_state, rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.results import record_rows
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.result import Column, Recorded, Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import DEFAULT_SPEED_CHANGE, ControllingForce, compute_controlling_force
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria, has_damping
from governor_mechanism.statics.equilibrium_speed import format_coordinate, has_equilibrium_speed, require_equilibrium_speed
from governor_mechanism.statics.linearisation import (
    Linearisation,
    StabilityLimit,
    last_spindle_speed,
    linearise_from_start,
    linearise_scene,
    poses_at,
)
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve, compute_insensitivity_band, compute_speed_curve
from governor_mechanism.units.quantities import format_quantity, format_reading_name
from governor_mechanism.units.text_table import short_repr

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")

DEFAULT_SLEEVE = "sleeve_lift"
"""The reading of the sleeve of most governors."""

NEARLY_ASTATIC_SENSITIVITY = 10.0
"""Displacement per relative speed change, rad or machine sizes, above which an equilibrium is nearly astatic."""


@dataclass(frozen=True, kw_only=True)
class PlacedEquilibrium:
    """An equilibrium with its insensitivity band: the reason why there is none, or None if no resistance is given."""

    equilibrium: Equilibrium
    band: InsensitivityBand | str | None

    @property
    def band_values(self) -> object:
        """Speeds of the band, or the reason why there is none."""
        if not isinstance(self.band, InsensitivityBand):
            return self.band
        return {name: getattr(self.band, name)[0] for name in ("falling_speed", "rising_speed", "insensitivity")}


@dataclass(frozen=True, kw_only=True)
class GovernorForces(Recorded):
    """Controlling force over the travel and at the equilibria of a scene."""

    curve: ControllingForce
    at_equilibria: ControllingForce | None

    about = ("radius=curve.radius_name", "balls=curve.n_balls", "against=curve.against", "speed_change=curve.effort.speed_change")
    record = (*about, "at_equilibria=point_values", "working_range=curve.working_range")

    @property
    def point_values(self) -> list[dict[str, Any]]:
        """Effort and power at the equilibria, in SI."""
        points = self.at_equilibria
        return [] if points is None else record_rows(_point_columns(points), range(len(points.coordinate)))


def _point_columns(points: ControllingForce) -> Iterator[Column]:
    """Yield the columns of positions by their index; lift and power only where the sleeve comes to a new equilibrium."""
    names = ("coordinate", "radius", "force", "force_slope", "speed_line_slope", "equivalent_mass", "speed", "sleeve", "stable")
    for name in names:
        yield Column(name, value=partial(operator.getitem, getattr(points, name)))
    effort = points.effort
    yield Column("effort", value=partial(operator.getitem, effort.effort))
    yield Column("lift", value=lambda k: effort.lift[k] if effort.has_lift[k] else None)
    yield Column("power", value=lambda k: effort.power[k] if effort.has_lift[k] else None)


@dataclass(frozen=True, kw_only=True)
class EquilibriumReport(Result):
    """The equilibria of a scene at one speed."""

    scene: Scene  # the scene of the part that turns with a spindle
    rows: tuple[PlacedEquilibrium, ...]  # the equilibria with their insensitivity bands
    curve: SpeedCurve | None  # the speed curve; None without an equilibrium speed
    # the controlling force, or the reason why there is none; None without an equilibrium speed
    forces: GovernorForces | str | None

    __repr__ = short_repr

    figure_set = "render.figures.controlling_force.equilibrium_figures"

    @property
    def columns(self) -> tuple[Column, ...]:
        """What is reported of the equilibria, and of their bands if a resistance is given."""
        names = ["coordinate", "extent", "stable", "stiffness", "frequency", "divergence_rate", "uncertainty", "sensitivity", "readings"]
        names += ["contact", "push"] if any(row.equilibrium.contact for row in self.rows) else []
        band = [Column("insensitivity_band", value="band_values")] if any(row.band is not None for row in self.rows) else []
        return *(Column(name, value=f"equilibrium.{name}") for name in names), *band

    @property
    def equilibria(self) -> tuple[Equilibrium, ...]:
        """The equilibria."""
        return tuple(row.equilibrium for row in self.rows)

    @property
    def record(self) -> tuple[str, ...]:
        """Equilibria, speed curve and controlling force; instead of what is missing, the reason."""
        names = ("coordinate=scene.part.mechanism.coordinate", "undamped", "equilibria=rows")
        curve = ("folds", "poles=curve.poles", "low_end=curve.low_end_message", "high_end=curve.high_end_message")
        return names if self.curve is None else (*names, *curve, "controlling_force=forces")

    @property
    def undamped(self) -> bool:
        """Whether frequencies and rates are those without the dampers that the scene has."""
        return has_damping(self.scene)

    @property
    def folds(self) -> list[dict[str, float]]:
        """Where the sleeve jumps, and at what speed."""
        return [{"coordinate": value, "speed": at} for value, at in self.curve.folds] if self.curve else []

    def __str__(self) -> str:
        """Return a line for each equilibrium, each followed by its band, one for each jump, and those on the controlling force."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        scene = self.scene
        name = format_reading_name(scene.part.mechanism.coordinate)
        yield scene.title
        for row in self.rows:
            yield f"{name} {_format_position(scene, row.equilibrium)}: {_format_stability(scene, row.equilibrium)}"
            if row.band is not None:
                yield f"  {_format_band(scene, row.band)}"
        for at, speed in self.curve.folds if self.curve else ():
            yield f"jumps at {format_coordinate(scene, at)}, {format_quantity(speed, 'rad/s')}"
        if isinstance(self.forces, GovernorForces):
            points = self.forces.at_equilibria
            if points is not None:
                yield from (_format_effort(scene, points, k) for k in range(len(points.coordinate)))
            yield _format_working_range(scene, self.forces.curve)


def report_equilibria(
    scene: Scene,
    spindle_speed: float | None,  # speed of the spindle, rad/s; the first of the scene if None
    *,
    resistance: float | None = None,  # resistance at the reading of the sleeve, N or N m; None for none
    against: str | None = None,  # reading of the sleeve; DEFAULT_SLEEVE if None
    # working range for the sensitiveness: both values of a reading; None for the stops or the travel
    between: Mapping[str, tuple[float | str, float | str]] | None = None,
    speed_change: float | None = None,  # relative change of speed for effort and power; that of statics if None
) -> EquilibriumReport:
    """Return the equilibria of the part that turns with a spindle, with speed curve, controlling force and insensitivity.

    What is given and cannot be used is refused; without it, a scene may have no controlling force, as that of a mechanism without balls.

    Raises MechanismError if there is no equilibrium, or an argument is wrong or cannot be used.
    """
    scene = rotating_part_alone(scene)
    sleeve = DEFAULT_SLEEVE if against is None else against
    is_force_wanted = between is not None or speed_change is not None or (against is not None and resistance is None)
    equilibria = find_equilibria(scene, spindle_speed)
    if is_force_wanted:
        require_equilibrium_speed(scene)
    curve: SpeedCurve | None = None
    forces: GovernorForces | str | None = None
    if has_equilibrium_speed(scene):
        curve = compute_speed_curve(scene, resistance=resistance, against=sleeve)
        change = DEFAULT_SPEED_CHANGE if speed_change is None else speed_change
        options = {"between": between, "speed_change": change, "resistance": resistance, "against": sleeve}
        forces = _find_forces(scene, equilibria, options) if is_force_wanted else result_or_reason(_find_forces, scene, equilibria, options)
    rows = [
        PlacedEquilibrium(
            equilibrium=one,
            band=None if resistance is None else result_or_reason(compute_insensitivity_band, scene, [one.coordinate], resistance, sleeve),
        )
        for one in equilibria
    ]
    return EquilibriumReport(scene=scene, rows=tuple(rows), curve=curve, forces=forces)


def _find_forces(scene: Scene, equilibria: Sequence[Equilibrium], options: Mapping[str, Any]) -> GovernorForces:
    """Return the controlling force of a scene, with the options of `compute_controlling_force`."""
    places = [one.coordinate for one in equilibria]
    curve = compute_controlling_force(scene, **options)
    return GovernorForces(curve=curve, at_equilibria=compute_controlling_force(scene, places, **options) if places else None)


def result_or_reason(function: Callable[_Arguments, _Result], *arguments: _Arguments.args, **options: _Arguments.kwargs) -> _Result | str:
    """Return the result of a function, or the reason why there is none."""
    try:
        return function(*arguments, **options)
    except MechanismError as error:
        return error.problems[0]


@dataclass(frozen=True, kw_only=True)
class LinearisationReport(Recorded):
    """Linearised equations of a scene: about each equilibrium, or why there are none, or at a limit of stability."""

    title: str  # title of the scene
    linearisations: tuple[Linearisation | str, ...]
    limit: StabilityLimit[Linearisation] | None = None

    record = ("limit=limit_values", "linearisations=values")
    optional = ("limit",)

    @property
    def limit_values(self) -> dict[str, Any]:
        """The limit without its linearised equations, which stand beside it."""
        return {} if self.limit is None else {name: value for name, value in self.limit.as_json().items() if name != "linearisation"}

    @property
    def values(self) -> list[object]:
        """What is reported of the linearisations; instead of a missing one, the reason."""
        return [*map(_linearisation_values, self.linearisations)]

    def __str__(self) -> str:
        """Return title, limit and linearisations."""
        return "\n".join([self.title, *([self.limit.sentence] if self.limit else []), *map(str, self.linearisations)])


def _linearisation_values(linearisation: Linearisation | str) -> object:
    """Return what is reported of linearised equations, whose eigenvalues stand with the modes, or the reason why there are none."""
    if isinstance(linearisation, str):
        return linearisation
    record = dict(linearisation.as_json())
    del record["eigenvalues"]
    return {"states": record.pop("state_names"), **record}


def report_linearisations(
    scene: Scene,
    spindle_speed: float | None,  # speed of the spindle, rad/s; that of the scene if None
) -> LinearisationReport:
    """Linearise about each equilibrium, or about the state nearest to the start if no equilibria are known."""
    poses, velocities = initial_state(scene)
    points: Sequence[Equilibrium] | str = ""
    if len(scene.parts) == 1 and isinstance(scene.spindle, Spindle):
        speed = last_spindle_speed(scene) if spindle_speed is None else spindle_speed
        points = result_or_reason(find_equilibria, rotating_part_alone(scene), speed)
    if isinstance(points, str):
        return LinearisationReport(title=scene.title, linearisations=(linearise_from_start(scene, poses, velocities, spindle_speed),))
    starts = (poses_at(scene, point) for point in points)
    results = [result_or_reason(linearise_scene, scene, start, velocities, spindle_speed) for start in starts]
    if all(isinstance(one, str) for one in results):
        raise MechanismError(*dict.fromkeys(map(str, results)))
    return LinearisationReport(title=scene.title, linearisations=tuple(results))


def _format_band(scene: Scene, band: InsensitivityBand | str) -> str:
    if isinstance(band, str):
        return band
    unit = "N m" if scene.part.mechanism.reading(band.against).quantity == "angle" else "N"
    falling_speed, rising_speed = (format_quantity(float(speed[0]), "rad/s") for speed in (band.falling_speed, band.rising_speed))
    sentence = f"{band.resistance:g} {unit} at {band.against}: in equilibrium between {falling_speed} and {rising_speed}"
    if math.isinf(band.insensitivity[0]):
        return f"{sentence}; without resistance it is in equilibrium at zero speed"
    return f"{sentence}, insensitivity {band.insensitivity[0]:.6g}"


def _format_position(scene: Scene, equilibrium: Equilibrium) -> str:
    if equilibrium.astatic:
        return " to ".join(format_coordinate(scene, end) for end in equilibrium.extent)
    return format_coordinate(scene, equilibrium.coordinate)


def _format_stability(scene: Scene, equilibrium: Equilibrium) -> str:
    if equilibrium.astatic:
        return "astatic, in equilibrium anywhere between"
    if equilibrium.contact:
        return f"at rest on contact {equilibrium.contact!r}, which bears {equilibrium.push:.6g} N"
    is_angle = scene.part.mechanism.reading(scene.part.mechanism.coordinate).quantity == "angle"
    stiffness = f"stiffness {equilibrium.stiffness:.6g} {'N m/rad' if is_angle else 'N/m'}"
    undamped = "undamped " if has_damping(scene) else ""
    stability = (
        f"stable, {undamped}natural frequency {equilibrium.frequency:.6g} rad/s"
        if equilibrium.stable
        else f"unstable, {undamped}divergence rate {equilibrium.divergence_rate:.6g} 1/s"
    )
    if not equilibrium.sensitivity:
        return f"{stability}; {stiffness}"
    sensitivity_clause = f"sensitivity {format_coordinate(scene, 0.01 * equilibrium.sensitivity)} per 1 % of speed"
    mechanism = scene.part.mechanism
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    qualifier = "nearly astatic, " if equilibrium.sensitivity > NEARLY_ASTATIC_SENSITIVITY * coordinate_scale else ""
    return f"{stability}; {stiffness}; {qualifier}{sensitivity_clause}"


def _format_effort(scene: Scene, points: ControllingForce, index: int) -> str:
    """Return controlling force, effort and power at a position in a sentence."""
    is_angle = scene.part.mechanism.reading(points.against).quantity == "angle"
    effort = points.effort
    place = format_coordinate(scene, float(points.coordinate[index]))
    force = f"at {place}: controlling force of a ball {points.force[index]:.6g} N"
    change = f"{100 * effort.speed_change:g} % of speed"
    unit = "N m" if is_angle else "N"
    mean_force = f"effort {effort.effort[index]:.6g} {unit} at {points.against} for {change}"
    if effort.has_lift[index]:
        lift = format_quantity(float(effort.lift[index]), "rad" if is_angle else "m")
        return f"{force}; {mean_force}, power {effort.power[index]:.6g} J over {lift}"
    cause = "it is astatic" if points.astatic[index] else "it ends its travel before" if points.stable[index] else "it is unstable"
    return f"{force}; {mean_force}, no power: {cause}"


def _format_working_range(scene: Scene, curve: ControllingForce) -> str:
    """Return the sensitiveness over the working range in a sentence."""
    ends = curve.working_range
    if ends is None:
        return 'for the sensitiveness give a working range, as in --range "sleeve_lift=20 mm:60 mm": the scene has no stops'
    places = " to ".join(format_coordinate(scene, float(value)) for value in ends.coordinate)
    low, high = (format_quantity(float(speed), "rad/s") for speed in ends.speed)
    text = f"working range {places}: {low} to {high}"
    if curve.astatic.all():
        return f"{text}, sensitiveness 0: isochronous"
    if not ends.stable:
        return f"{text}, unstable in part, so that it has no sensitiveness"
    text += f", sensitiveness {ends.sensitiveness:.6g} of the mean speed, work capacity {ends.work_capacity:.6g} J"
    if not curve.resistance:
        return text
    falling, rising = (format_quantity(float(speed), "rad/s") for speed in (ends.falling_speed[0], ends.rising_speed[1]))
    return f"{text}; with resistance {falling} to {rising}"
