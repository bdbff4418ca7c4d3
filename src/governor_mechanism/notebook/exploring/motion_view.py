"""View of a mechanism without a speed curve: its pose over the leading coordinate, or over the time of its drivers."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, Kinematics, release_drivers
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.range_of_motion import find_range_of_motion
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.plot_svg import GIVEN_DASHES, GIVEN_NAME, Plot, label_axis
from governor_mechanism.notebook.exploring.pose_drawing import PoseDrawing
from governor_mechanism.notebook.exploring.sliders import Slider, ViewState, travel_within_stops
from governor_mechanism.numerics.hermite import interpolate_samples
from governor_mechanism.observables.derived_readings import analyse_kinematics
from governor_mechanism.render.figures.page import axis_limits_for
from governor_mechanism.render.style import BLUE, INK, MUTED
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_quantity, format_reading_name

TURN_POINTS = 121
"""Number of positions over the coordinate: one for every 3 degrees of a turn."""
TIME_POINTS = 25
"""Number of times, of which each needs an assembly of its own, some milliseconds; one for every 15 degrees of a turn."""
MAX_NAMED_READINGS = 5
"""Number of readings whose values stand above the pictures."""
START_ANGLE = math.pi / 3
"""Angle at which the view begins if the scene gives none, rad: beside the dead centres."""
ROUNDING = 1e-9
"""Value below which a reading is zero but for rounding, m or rad."""
PLOT_POINTS = 200
"""Number of points of the plot, by cubic polynomials between the positions."""
END_MARGIN = 1e-3
"""Part of a travel without full turns that is left out at each end, where the coordinate may be at a turning point."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionView:
    """A mechanism whose pose follows a coordinate or time."""

    scene: Scene  # scene of one part
    kinematics: Kinematics  # its motion over the variable
    given: Kinematics  # the motion of the first scene, which the plot shows beside it
    variable: Slider  # slider of the variable
    turns_fully: bool  # whether the coordinate goes through a whole turn, whatever the dimensions are
    speed_curve: None = None

    @cached_property
    def reading_choices(self) -> Mapping[str, str]:
        """Readings of the plot with their units: first lengths, then the others, without those that do not change."""
        mechanism, motion = self.scene.mechanism, self.kinematics
        units = {one.name: READING_UNITS[one.quantity] for one in mechanism.readings}
        units |= {one.name: one.unit for one in mechanism.derived_readings}
        changing = [name for name, values in motion.readings.items() if name != motion.over and np.ptp(values) > 0.0]
        return {name: units[name] for name in sorted(changing, key=lambda name: units[name] != "m") if name in units}

    def drawing_at(self, position: float) -> PoseDrawing:
        """Return the drawing over the whole travel, through which a film goes too."""
        return self._drawing

    @cached_property
    def _drawing(self) -> PoseDrawing:
        return PoseDrawing(scene=self.scene, poses=self.kinematics.poses, readings=dict(self.kinematics.readings))

    def with_scene(self, scene: Scene) -> "MotionView":
        """Return the view of a changed scene over the same range of the variable, or over the changed travel."""
        if self.turns_fully or self.kinematics.over == TIME_VARIABLE:
            return self._over_same_values(scene)
        try:  # the travel of the last scene: to trace that of the changed one may take a second
            return self._over_same_values(scene)
        except MechanismError:
            return replace(make_motion_view(scene), given=self.given)

    def check_geometry(self, scene: Scene) -> object:
        """Raise MechanismError if a changed scene cannot be assembled: over a whole turn if it has turns, else at the start."""
        if self.turns_fully or self.kinematics.over == TIME_VARIABLE:
            return self._over_same_values(scene)
        return analyse_kinematics(_without_free_spindle(scene), self.kinematics.over, [self.variable.value])

    def solve(self, value: float, last: ViewState | None) -> ViewState:
        """Return the pose at a value of the variable, by cubic polynomials between the positions of the motion."""
        low, high = float(self.kinematics.values[0]), float(self.kinematics.values[-1])
        place = min(max(value, low), high)
        here = f"{format_reading_name(self.variable.name)} {_format_number(value, self.variable.unit)}"
        choices = list(self.reading_choices.items())[:MAX_NAMED_READINGS]
        values = [float(_reading_at(self.kinematics, name, place)) for name, _ in choices]
        numbers = [
            f"{format_reading_name(name)} {_format_number(value, unit)}" for (name, unit), value in zip(choices, values, strict=True)
        ]
        sentence = f"At {here}: {', '.join(numbers)}." if numbers else f"At {here}."
        return ViewState(value=place, position=place, pose=self._pose_at(place), sentences=(sentence,))

    def plot(self, state: ViewState, reading: str, *, is_faded: bool) -> str:
        """Return a reading over the variable with the state marked."""
        unit = self.reading_choices[reading]
        (x_factor, x_unit), (y_factor, y_unit) = self.variable.display, DISPLAY_UNITS.get(unit, (1.0, unit))
        motions = (self.kinematics,) if self.given is self.kinematics else (self.given, self.kinematics)
        curves = [(values * x_factor, _reading_at(one, reading, values) * y_factor) for one in motions for values in [_plot_values(one)]]
        xs, ys = (np.concatenate(column) for column in zip(*curves, strict=True))
        plot = Plot(label_axis(self.variable.name, x_unit), label_axis(reading, y_unit), (xs.min(), xs.max()), axis_limits_for(ys))
        for x, y in curves[:-1]:
            plot.add_curve(x, y, colour=MUTED, dashes=GIVEN_DASHES, name=GIVEN_NAME)
        plot.add_curve(*curves[-1], colour=BLUE)
        plot.add_point(state.value * x_factor, float(_reading_at(self.kinematics, reading, state.value)) * y_factor, INK)
        return plot.to_svg(f"{reading} over {self.variable.name}", is_faded=is_faded)

    def _over_same_values(self, scene: Scene) -> "MotionView":
        """Return the view of a changed scene at the same values. Raise MechanismError where it cannot be assembled."""
        alone = _without_free_spindle(scene)
        return replace(self, scene=alone, kinematics=analyse_kinematics(alone, self.kinematics.over, self.kinematics.values))

    def _pose_at(self, place: float) -> FloatArray:
        """Return the poses (bodies, 3) at a value of the variable."""
        return interpolate_samples(self.kinematics.values, self.kinematics.poses, self.kinematics.velocities, place)


def make_motion_view(scene: Scene) -> MotionView:
    """Return the view of a mechanism over its leading coordinate; if that does not describe a driven motion, over time."""
    alone = _without_free_spindle(scene)
    mechanism = alone.part.mechanism
    freedom = mobility_of(mechanism)
    if freedom > (0 if mechanism.count_drivers() else 1):
        cure = "gm.run(scene) shows how it moves under its loads"
        raise MechanismError(f"explore follows one motion, and this mechanism has {freedom} degrees of freedom; {cure}")
    coordinate, period = _find_turning_coordinate(mechanism)
    if period:
        start = float(alone.start.values[coordinate]) if _has_number(alone, coordinate) else START_ANGLE
        low = math.tau * math.floor(start / math.tau)
        values = np.linspace(low, low + period, TURN_POINTS)
        return _view_over(alone, coordinate, values, start, turns_fully=True)
    if mechanism.count_drivers():
        return _view_over(alone, TIME_VARIABLE, np.linspace(0.0, _time_of_turn(mechanism) or alone.run.duration, TIME_POINTS), 0.0)
    travel = find_range_of_motion(mechanism, rotates_with_spindle=alone.part.turns)
    margin = END_MARGIN * (travel.high - travel.low)
    values = np.linspace(travel.low + margin, travel.high - margin, TURN_POINTS)
    start = float(alone.start.values[mechanism.coordinate]) if _has_number(alone, mechanism.coordinate) else float(values.mean())
    readings = analyse_kinematics(alone, mechanism.coordinate, values).readings
    values = np.linspace(*travel_within_stops(alone, values, readings), TURN_POINTS)
    return _view_over(alone, mechanism.coordinate, values, min(max(start, float(values[0])), float(values[-1])))


def _view_over(scene: Scene, over: str, values: FloatArray, start: float, *, turns_fully: bool = False) -> MotionView:
    """Return the view over values of a reading or times, which starts at one of them."""
    kind, unit = "time", "s"
    if over != TIME_VARIABLE:
        kind = scene.part.mechanism.reading(over).quantity
        unit = READING_UNITS[scene.part.mechanism.reading(over).quantity]
    low, high = float(values[0]), float(values[-1])
    variable = Slider(
        name=over, words=format_reading_name(over), key="", kind=kind, unit="" if unit == "1" else unit, value=start, low=low, high=high
    )
    motion = analyse_kinematics(scene, over, values)
    return MotionView(scene=scene, kinematics=motion, given=motion, variable=variable, turns_fully=turns_fully)


def _find_turning_coordinate(mechanism: Mechanism) -> tuple[str, float]:
    """Return the leading coordinate, or else another angle, that goes through whole turns, with its period (rad); 0 if there is none."""
    angles = [one.name for one in mechanism.readings if one.quantity == "angle"]
    for name in dict.fromkeys([mechanism.coordinate, *angles]):
        try:
            released = replace(release_drivers(mechanism, name, {}), coordinate=name)
            period = find_range_of_motion(released, rotates_with_spindle=False).period
        except MechanismError:  # this reading does not describe the motion
            continue
        if period:
            return name, period
    return "", 0.0


def _time_of_turn(mechanism: Mechanism) -> float:
    """Return the time (s) in which the only driver turns once at its constant rate; 0 if there are several, or it is another one."""
    drivers = [joint for joint in mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
    if len(drivers) != 1 or not isinstance(drivers[0], RotationalDriver):
        return 0.0
    motion = CubicTimeFunction(drivers[0].motion)
    start, later = motion(np.array([0.0, 1.0])).tolist()
    period = math.tau / abs(later - start) if later != start else 0.0
    middle, end = motion(np.array([0.5 * period, period])).tolist()
    is_constant = math.isclose(abs(end - start), math.tau, rel_tol=1e-9) and math.isclose(abs(middle - start), math.pi, rel_tol=1e-9)
    return period if is_constant else 0.0


def _plot_values(motion: Kinematics) -> FloatArray:
    """Return the values (n,) of the variable at the points of a plot."""
    return np.linspace(motion.values[0], motion.values[-1], PLOT_POINTS)


def _reading_at(motion: Kinematics, name: str, values: float | FloatArray) -> FloatArray:
    """Return a reading (SI) at one or several values of the variable."""
    if name in motion.rates:
        return interpolate_samples(motion.values, motion.readings[name], motion.rates[name], values)
    return np.asarray(np.interp(values, motion.values, motion.readings[name]))


def _format_number(value: float, unit: str) -> str:
    """Return a value (SI) with a customary unit, without the rounding errors of zero."""
    return format_quantity(0.0 if abs(value) < ROUNDING else value, unit, ".5g")


def _has_number(scene: Scene, reading: str) -> bool:
    """Return whether the start of a scene gives a number for a reading."""
    return isinstance(scene.start.values.get(reading), float)


def _without_free_spindle(scene: Scene) -> Scene:
    """Return a scene without the shaft of a free spindle, which does not move in the plane."""
    if scene.part.turns and isinstance(scene.part.spindle, FreeSpindle):
        return scene.with_changes(spindle=Spindle(speeds=(0.0,)))
    return scene
