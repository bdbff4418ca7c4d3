"""The kinematics of a mechanism over its drive, and what holds of the whole linkage."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, Kinematics
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.joints import GROUND, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism, bodies_of_reading
from governor_mechanism.model.motion_readings import KINEMATIC_KINDS, MechanicalAdvantage, find_named_readings, find_transmissions
from governor_mechanism.model.output_variables import BodyAngle, DerivedReading
from governor_mechanism.model.results.result import Column, format_columns, item_column, path_column
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.observables.linkage import DeadCentre, DriveTravel, FourBar, Mobility, Toggle, find_four_bars, find_mobility
from governor_mechanism.observables.motion_readings import REST_RATIO, Motion, evaluate_motion_reading
from governor_mechanism.statics.equilibria import OVERLAP_TOLERANCE
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import display_unit
from governor_mechanism.units.text_table import short_repr

DEFAULT_COUNT = 361
"""Number of positions of a study that names none: one for each degree of a turn."""

MAX_DEFAULT_POINTS = 3
"""Number of points whose velocity and acceleration the command reports unless others are named."""


ROUNDING_RATIO = 1e-11
"""Value relative to the largest of its reading that the printed table shows as zero; rounding leaves less."""


SHOWN_DECIMALS: Final = 12
"""Decimals of a printed value in its unit; a position is located to 1e-10."""


@dataclass(frozen=True, kw_only=True)
class ReadingExtremes:
    """Lowest and highest value of a reading, SI, and the value of the drive at each."""

    reading: str
    lowest: float
    lowest_at: float
    highest: float
    highest_at: float


@dataclass(frozen=True, kw_only=True, eq=False)
class KinematicStudy(Kinematics):
    """Kinematics of a mechanism over its drive, with what holds of the whole linkage.

    Attributes
    ----------
    scene
        The scene.
    units
        SI units of the readings by name.
    """

    scene: Scene
    units: Mapping[str, str]

    __repr__ = short_repr
    figure = "render.figures.kinematics.kinematics_figure"
    data_files = ("csv", "json")
    record = ("title=scene.title", "over", "values", "readings", "rates", "reading_accelerations", "paths", "units")
    derived = ("extremes", "mobility", "four_bars", "dead_centres", "toggles", "time_ratios", "notes")

    @property
    def columns(self) -> tuple[Column, ...]:
        """Values of the driving reading or times, readings, rates and accelerations, and the paths of named points."""
        mechanism = _mechanism_of(self.scene)
        over = Column(self.over, value="values", unit=self.units.get(self.over, "s"))
        columns = [item_column(name, "readings", name, unit=self.units[name]) for name in self.readings if name != self.over]
        columns += [item_column(f"rate of {name}", "rates", name, unit=f"{self.units[name]}/s") for name in self.rates]
        columns += [
            item_column(f"acceleration of {name}", "reading_accelerations", name, unit=f"{self.units[name]}/s2")
            for name in self.reading_accelerations
        ]
        # Those whose paths the scene names are among the readings.
        points = [point.name for point in mechanism.points if f"{point.name}.x" not in self.readings]
        columns += [path_column(point, axis) for point in points for axis in "xy"]
        return over, *columns

    @cached_property
    def mobility(self) -> Mobility:
        """Mobility without the drives, with Grübler's count."""
        return find_mobility(_mechanism_of(self.scene), self.poses)

    @cached_property
    def four_bars(self) -> tuple[FourBar, ...]:
        """Loops of four links with the ground, with Grashof's class."""
        return find_four_bars(_mechanism_of(self.scene), "" if self.over == TIME_VARIABLE else self.over)

    @property
    def dead_centres(self) -> tuple[DeadCentre, ...]:
        """Positions at which readings turn back, over the whole travel of the drive; none over time."""
        return self._travel.dead_centres if self._travel else ()

    @property
    def toggles(self) -> tuple[Toggle, ...]:
        """Positions beyond which the drive cannot go; none if it turns fully, or over time."""
        return self._travel.toggles if self._travel else ()

    @property
    def time_ratios(self) -> Mapping[str, float]:
        """Time of the slower stroke over that of the faster one, at constant speed of the drive, of each reading that has two."""
        return self._travel.time_ratios if self._travel else {}

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Sentences on readings that are not defined at some values, and on parts that overlap there."""
        n_values = len(self.values)
        gaps = {name: int(np.isnan(values).sum()) for name, values in self.readings.items()}
        missing = {name: f"is not defined at {count} of {n_values} values" for name, count in gaps.items() if count}
        sentences = [f"{name} {what}, where {_reason_of_gap(name)}" for name, what in missing.items()]
        outlines = outline_gaps_of(self.scene)
        tolerance = OVERLAP_TOLERANCE * self.scene.mechanism.length_scale
        for contact in dict.fromkeys(gap.contact for gap in outlines):
            overlaps = np.any([self.readings[gap.name] < -tolerance for gap in outlines if gap.contact == contact], axis=0)
            if count := int(np.sum(overlaps)):
                sentences.append(f"the parts of contact {contact!r} overlap at {count} of {n_values} values, where the mechanism cannot be")
        return tuple(sentences)

    @cached_property
    def _travel(self) -> DriveTravel | None:
        """The whole travel of the drive."""
        if self.over == TIME_VARIABLE:
            return None
        try:
            return _make_travel(self.scene, self.over)
        except MechanismError:  # the start is a singular configuration; the motion has others
            return DriveTravel(_mechanism_of(self.scene), self.over, self.poses[len(self.poses) // 3])

    def __str__(self) -> str:
        """Return a table of the extremes of the readings, and the facts of the linkage."""
        first, last = (self._format(self.over, value) for value in (self.values[0], self.values[-1]))
        header = f"{self.scene.title}: {len(self.values)} positions over {self.over}, {first} to {last}; {self.drive_in_words}"
        return "\n".join([header, "", format_columns(self._extreme_columns(), self.extremes), "", *self._facts()])

    @property
    def drive_in_words(self) -> str:
        """How fast the mechanism is driven, in words."""
        if self.over == TIME_VARIABLE:
            return "driven as in the scene"
        return f"driven at {float(self.rates[self.over][0]):.6g} {self.units[self.over]}/s"

    @property
    def extremes(self) -> list[ReadingExtremes]:
        """Extremes of the readings that are defined somewhere."""
        found = []
        for name, values in self.readings.items():
            if name != self.over and not np.isnan(values).all():
                low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
                shown = np.where(np.abs(values) > ROUNDING_RATIO * float(np.nanmax(np.abs(values))), values, 0.0)
                ends = {"lowest": shown[low], "lowest_at": self.values[low], "highest": shown[high], "highest_at": self.values[high]}
                found.append(ReadingExtremes(reading=name, **{key: float(value) for key, value in ends.items()}))
        return found

    def _extreme_columns(self) -> Iterator[Column]:
        """Yield the columns of the extremes, in usual units."""
        yield Column("reading", "reading")
        yield Column("lowest", "lowest", lambda row: self._format(row.reading, row.lowest), side="r")
        yield Column("lowest_at", "at", lambda row: self._format(self.over, row.lowest_at), side="r")
        yield Column("highest", "highest", lambda row: self._format(row.reading, row.highest), side="r")
        yield Column("highest_at", "at", lambda row: self._format(self.over, row.highest_at), side="r")

    def _facts(self) -> Iterator[str]:
        """Yield mobility, four-bars, dead centres, toggles, time ratios and notes as sentences."""
        yield str(self.mobility)
        yield from map(str, self.four_bars)
        for name in dict.fromkeys(one.reading for one in self.dead_centres):
            centres = [one for one in self.dead_centres if one.reading == name]
            texts = [
                f"{self._format(self.over, one.drive, 12)} ({'highest' if one.is_highest else 'lowest'}, {self._format(name, one.value)})"
                for one in centres
            ]
            yield f"dead centres of {name} at {self.over} = {', '.join(texts)}"
        for name, ratio in self.time_ratios.items():
            yield f"time ratio of {name}: {ratio:.9g}"
        for toggle in self.toggles:
            aligned = f" (transmission angle of {', '.join(toggle.couplers)} is 0 or 180 deg)" if toggle.couplers else ""
            yield f"the drive ends at {self.over} = {self._format(self.over, toggle.drive, 12)}{aligned}: {toggle.reason}"
        yield from self.notes

    def _format(self, name: str, value: float, digits: int = 6) -> str:
        """Return a value of a reading, or of the drive, in its usual unit."""
        unit = self.units.get(name, "s")
        factor, shown = display_unit(unit)
        rounded = round(value * factor, SHOWN_DECIMALS) + 0.0  # what is zero but for rounding
        return f"{rounded:.{digits}g} {shown}".rstrip()


def _reason_of_gap(name: str) -> str:
    kind = name.partition(".")[0]
    reasons = {
        "instantaneous_centre": "the centre is at infinity: the bodies do not turn against each other",
        "mechanical_advantage": "it is infinite: the output stands still",
        "curvature": "the point stands still",
    }
    return reasons.get(kind, "it is infinite")


def _mechanism_of(scene: Scene) -> Mechanism:
    """Return the mechanism that is analysed: that of the only part, without the shaft of a free spindle, or that of all."""
    return scene.part.mechanism if len(scene.parts) == 1 else scene.mechanism


def study_kinematics(
    scene: Scene,
    over: str | None = None,
    values: Sequence[float | str] | FloatArray | None = None,
    rate: float | str = 1.0,
    acceleration: float | str = 0.0,
    readings: Sequence[str] = (),
) -> KinematicStudy:
    """Return the kinematics over values of a reading or over time, with further readings.

    Without a reading, the angle of the driven body leads, or the leading coordinate; without values, it goes through a whole turn, or
    through its travel. Raises MechanismError as `analyse_kinematics`, if there is no such reading, or if one of a mechanical advantage
    stands still.
    """
    mechanism = _mechanism_of(scene)
    over = over or find_drive(mechanism)
    if values is None:
        values = default_values(scene, over)
    motion = analyse_kinematics(scene, over, values, rate, acceleration)
    named = [*(name for name in scene.run.readings if not name.startswith("reaction.")), *readings]
    leading = _led_by(mechanism, over)
    found = find_named_readings(leading, named, KINEMATIC_KINDS, "readings")
    _refuse_resting(leading, motion, found)
    state = Motion(
        mechanism=leading, poses=motion.poses, velocities=motion.velocities, accelerations=motion.accelerations, rates=motion.rates
    )
    evaluated = {one.name: evaluate_motion_reading(state, one) for one in found}
    values_by_name = {name: one for name, one in evaluated.items() if one is not None}
    own = {one.name: getattr(motion, one.name) for one in fields(Kinematics)}
    units = {reading.name: READING_UNITS[reading.quantity] for reading in mechanism.readings}
    units |= {one.name: one.unit for one in scene.mechanism.derived_readings} | {one.name: _unit_of(one, units) for one in found}
    return KinematicStudy(**{**own, "readings": {**motion.readings, **values_by_name}}, scene=scene, units=units)


def _led_by(mechanism: Mechanism, over: str) -> Mechanism:
    """Return a mechanism that a reading drives in place of its drivers; over time it is as it is."""
    if over == TIME_VARIABLE:
        return mechanism
    undriven = tuple(joint for joint in mechanism.joints if not isinstance(joint, RotationalDriver | TranslationalDriver))
    return replace(mechanism, joints=undriven, coordinate=over)


def find_driven_angle(mechanism: Mechanism) -> str:
    """Return the angle of the body that a driver turns; empty if there is none."""
    driven = {joint.second.body for joint in mechanism.joints if isinstance(joint, RotationalDriver) and joint.first.body == GROUND}
    angles = [one for one in mechanism.readings if isinstance(one, BodyAngle) and one.reference_body == GROUND]
    return next((one.name for one in angles if one.body in driven), "")


def find_drive(mechanism: Mechanism) -> str:
    """Return the angle of the body that a driver turns, or else the leading coordinate. Raise MechanismError if there is neither."""
    drive = find_driven_angle(mechanism) or mechanism.coordinate
    if not drive:
        names = [reading.name for reading in mechanism.readings]
        raise MechanismError(f"no driver and no leading coordinate says what drives this mechanism; name it as over, one of {names}")
    return drive


def default_values(scene: Scene, over: str) -> FloatArray:
    """Return the values of a study that names none."""
    if over == TIME_VARIABLE:
        return np.linspace(0.0, scene.run.duration, DEFAULT_COUNT)
    _mechanism_of(scene).reading(over)  # raises for an unknown reading
    return _make_travel(scene, over).default_values(DEFAULT_COUNT)


def _make_travel(scene: Scene, over: str) -> DriveTravel:
    """Return the travel of a reading from the start of a scene."""
    mechanism = _mechanism_of(scene)
    given = {name: float(value) for name, value in scene.start.values.items() if isinstance(value, float | int)}
    return DriveTravel(mechanism, over, PositionSolver(mechanism).solve(given))


def _refuse_resting(mechanism: Mechanism, motion: Kinematics, found: Iterable[DerivedReading]) -> None:
    """Raise MechanismError if a reading of a mechanical advantage does not move."""
    speeds = {name: float(np.max(np.abs(rates))) / mechanism.output_scale(name) for name, rates in motion.rates.items()}
    largest = max(speeds.values(), default=0.0)
    resting = dict.fromkeys(
        f"{one.name} is not defined: {name!r} stands still while {motion.over} moves; choose a reading that moves"
        for one in found
        if isinstance(one, MechanicalAdvantage)
        for name in (one.input, one.output)
        if speeds[name] <= REST_RATIO * largest
    )
    if resting:
        raise MechanismError(*resting)


def _unit_of(reading: DerivedReading, units: Mapping[str, str]) -> str:
    """Return the unit of a reading; that of a mechanical advantage follows from both readings."""
    if not isinstance(reading, MechanicalAdvantage):
        return reading.unit
    first, second = units[reading.input], units[reading.output]
    return "1" if first == second else f"{first}/{second}"


def default_readings(scene: Scene, over: str | None = None) -> list[str]:
    """Return what the command reports unless readings are named: points, transmission angles, and mechanical advantages over the drive."""
    # Points are those with a name, or else the first that have paths; the output of an advantage is a
    # link that a coupler moves.
    mechanism = _mechanism_of(scene)
    drive = over or find_drive(mechanism)
    points = [point.name for point in mechanism.points] or list(mechanism.path_points)
    names = [f"{kind}.{point}.magnitude" for point in points[:MAX_DEFAULT_POINTS] for kind in ("velocity", "acceleration")]
    leading = _led_by(mechanism, drive)
    names += [f"transmission_angle.{coupler}" for coupler in find_transmissions(leading)]
    output = _find_output(leading, drive)
    return names + ([f"mechanical_advantage.{drive}.{output}"] if output and drive != TIME_VARIABLE else [])


def _find_output(mechanism: Mechanism, drive: str) -> str:
    """Return a reading of a link that a coupler moves, or else the first that does not drive; empty if there is none."""
    links = {angle.output for angle in find_transmissions(mechanism).values()}
    others = [reading for reading in mechanism.readings if reading.name != drive]
    outputs = [one.name for one in others if links.intersection(bodies_of_reading(one))]
    return next(iter(outputs or [one.name for one in others]), "")
