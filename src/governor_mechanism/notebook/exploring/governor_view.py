"""View of a governor: its equilibria at a spindle speed, on its speed curve."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from governor_mechanism.engines.rotating_part import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.plot_svg import GIVEN_DASHES, GIVEN_NAME, Plot, label_axis
from governor_mechanism.notebook.exploring.pose_drawing import PoseDrawing
from governor_mechanism.notebook.exploring.sliders import Slider, ViewState, travel_within_stops
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, VERMILLION
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria, find_equilibria_or_empty
from governor_mechanism.statics.equilibrium_speed import evaluate_readings
from governor_mechanism.statics.speed_curve import SpeedCurve, compute_speed_curve
from governor_mechanism.types import BoolArray
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_quantity, format_reading_name

CURVE_POINTS = 150
"""Number of points of the speed curve: one for every other pixel of the plot."""
SLIDER_RATIO = math.sqrt(2)
"""Factor by which the slider goes beyond the shown speeds: a dimension of half or double its value moves them by about so much."""
N_POSES = 13
"""Number of poses that decide how large the drawing is: one for some 2 degrees of an arm. They take most of the time of a drawing."""
WORKING_SHARE = 0.25
"""Share of the travel for which a machine is drawn: some 20 degrees of an arm, over which governors regulate. For the whole travel a
throttle lever would have to pass through arms and links."""
SPEED = "spindle_speed"
"""Name of the variable."""
SHOWN_SHARE = 0.1
"""Share of the travel at each end of the speed curve that does not decide which speeds are shown: it may tend to zero or infinity there."""
SPEED_MARGIN = 0.15
"""Margin of the shown speeds, relative to the lowest and the highest one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorView:
    """A governor, or another mechanism that the spindle speed holds in equilibrium."""

    scene: Scene  # scene of the rotating part alone, at a given speed
    reduction: SingleDofReduction  # the scene reduced to its leading coordinate
    speed_curve: SpeedCurve
    variable: Slider  # slider of the spindle speed; its range is that of the plot
    given: SpeedCurve  # the speed curve of the first scene, which the plot shows beside it
    # lowest and highest speed of the first scene, rad/s: the drawing has room for the equilibria between
    # them
    film_speeds: Vec2
    kinematics: None = None

    @property
    def reading_choices(self) -> Mapping[str, str]:
        """No choice: the plot shows the speed curve."""
        return {}

    def drawing_at(self, position: float) -> PoseDrawing:
        """Return the drawing for a range of the travel around a position: the working range, or one beside it by whole halves of it."""
        low, high = self._working_range
        half = 0.5 * (high - low)
        steps = math.ceil(max(low - position, position - high, 0.0) / half)
        first, last = _travel_of(self.speed_curve)
        start = min(max(low + math.copysign(steps * half, position - low), first), last - 2 * half)
        if start not in self._drawings:
            self._drawings[start] = self._draw_over(start, start + 2 * half)
        return self._drawings[start]

    @cached_property
    def _drawings(self) -> dict[float, PoseDrawing]:
        """The drawings so far, by the start of their range."""
        return {}

    @cached_property
    def _working_range(self) -> Vec2:
        """The part of the travel that a film shows, with a margin: from the start to the equilibria, within the stops."""
        start = self._start_position()
        found = [find_equilibria_or_empty(self.scene, speed) for speed in self.film_speeds]
        reached = [_preferred(equilibria, start).coordinate for equilibria in found if equilibria]
        if self._given_start is not None or not reached:
            reached.append(start)
        low, high = travel_within_stops(self.scene, self.speed_curve.coordinate, self.speed_curve.readings)
        first, last = np.clip([min(reached), max(reached)], low, high).tolist()
        width = min(max(WORKING_SHARE * float(np.ptp(self.speed_curve.coordinate)), last - first), high - low)
        first = min(max(0.5 * (first + last - width), low), high - width)
        return first, first + width

    def _draw_over(self, low: float, high: float) -> PoseDrawing:
        """Return the drawing for a range of the travel."""
        coefficients = self.reduction.evaluate(np.linspace(low, high, N_POSES))
        readings = evaluate_readings(self.reduction.mechanism, coefficients)
        return PoseDrawing(scene=self.scene, poses=coefficients.poses, readings=readings)

    def with_scene(self, scene: Scene) -> "GovernorView":
        """Return the view of a changed scene, with the same range of speeds."""
        return replace(_analyse(scene), variable=self.variable, given=self.given, film_speeds=self.film_speeds)

    def check_geometry(self, scene: Scene) -> object:
        """Raise MechanismError if a changed scene has no travel."""
        return SingleDofReduction(_at_given_speed(scene)).range_of_motion

    def solve(self, value: float, last: ViewState | None) -> ViewState:
        """Return the state at a spindle speed (rad/s): the stable equilibrium nearest to the last pose, which jumps at a fold."""
        position = self._start_position() if last is None else last.position
        speed = format_quantity(value, "rad/s", ".5g")
        try:
            equilibria = find_equilibria(self.scene, value)
        except MechanismError as error:
            travel = self.reduction.range_of_motion
            position = min(max(position, travel.low), travel.high)
            pose = self.reduction.evaluate([position]).poses[0]
            sentence = "; ".join(error.problems)
            problem = f"{sentence[:1].upper()}{sentence[1:]}. The drawing keeps its last pose."
            return ViewState(value=value, position=position, pose=pose, sentences=(), problem=problem)
        shown = _preferred(equilibria, position)
        others = [f"{self._place_of(one)} ({_kind_of(one)})" for one in equilibria if one is not shown]
        sentence = f"At {speed}: {_kind_of(shown)} equilibrium at {self._place_of(shown)}{self._other_readings(shown)}."
        also = (f"Also in equilibrium at {', '.join(others)}.",) if others else ()
        sentences = (sentence, _describe_stability(shown), *also)
        return ViewState(
            value=value, position=shown.coordinate, pose=shown.poses, sentences=sentences, equilibria=equilibria, equilibrium=shown
        )

    def plot(self, state: ViewState, reading: str, *, is_faded: bool) -> str:
        """Return the speed curve with the chosen speed and its equilibria; `reading` is not used."""
        curve, name = self.speed_curve, self.speed_curve.coordinate_name
        factor, unit = DISPLAY_UNITS[self._unit_of(name)]
        rpm, _ = self.variable.display
        x, y = curve.coordinate * factor, curve.speed * rpm
        values = np.array([*_travel_of(self.given), *_travel_of(curve)]) * factor
        speeds = np.array([*_shown_speeds(self.given, state.value), *_shown_speeds(curve, state.value)]) * rpm
        limits = (values.min(), values.max()), (speeds.min(), speeds.max())
        plot = Plot(label_axis(name, unit), label_axis("equilibrium_speed", "rpm"), *limits)
        if not curve.has_equilibrium.any():
            plot.add_note("no spindle speed gives an equilibrium")
        if self.given is not curve:
            given = self.given.coordinate * factor, self.given.speed * rpm
            plot.add_curve(*given, self.given.has_equilibrium, colour=MUTED, dashes=GIVEN_DASHES, name=GIVEN_NAME)
        plot.add_level(state.value * rpm, GREEN, format_quantity(state.value, "rad/s", ".5g"))
        unstable = curve.has_equilibrium & ~curve.stable & ~curve.astatic
        plot.add_curve(x, y, _joined(curve.stable, curve), colour=BLUE, name="stable")
        plot.add_curve(x, y, _joined(unstable, curve), colour=BLUE, dashes="6 4", name="unstable")
        plot.add_curve(x, y, curve.astatic, colour=BLUE, dashes="1.5 2.5", name="neutral")
        if curve.folds:
            plot.name_points(VERMILLION, "jump")
        for value, speed in curve.folds:
            plot.add_point(value * factor, speed * rpm, VERMILLION)
        for one in state.equilibria:
            plot.add_point(one.coordinate * factor, state.value * rpm, INK, is_filled=one.stable)
        return plot.to_svg(f"equilibrium speed over {name}", is_faded=is_faded)

    def _start_position(self) -> float:
        """Return the leading coordinate at the start of the scene; the middle of the travel if it starts in equilibrium."""
        start = self._given_start
        return 0.5 * sum(_travel_of(self.speed_curve)) if start is None else start

    @property
    def _given_start(self) -> float | None:
        """The leading coordinate at the start of the scene; None if it starts in equilibrium."""
        start = self.scene.start.values.get(self.reduction.mechanism.coordinate)
        return start if isinstance(start, float) else None

    def _unit_of(self, reading: str) -> str:
        return READING_UNITS[self.reduction.mechanism.reading(reading).quantity]

    def _place_of(self, equilibrium: Equilibrium) -> str:
        """Return the leading coordinate of an equilibrium in words."""
        name = self.reduction.mechanism.coordinate
        if equilibrium.astatic:
            low, high = (format_quantity(end, self._unit_of(name), ".4g") for end in equilibrium.extent)
            return f"{format_reading_name(name)} {low} to {high}"
        return f"{format_reading_name(name)} {format_quantity(equilibrium.coordinate, self._unit_of(name), '.4g')}"

    def _other_readings(self, equilibrium: Equilibrium) -> str:
        """Return the other readings of an equilibrium in words."""
        names = [name for name in equilibrium.readings if name != self.reduction.mechanism.coordinate]
        texts = [f"{format_reading_name(name)} {format_quantity(equilibrium.readings[name], self._unit_of(name), '.4g')}" for name in names]
        return f" ({', '.join(texts)})" if texts and not equilibrium.astatic else ""


def make_governor_view(
    scene: Scene,
    key: str,  # key of its spindle speed in the document; empty if the speed is not a number there
) -> GovernorView:
    """Return the view of a governor; the slider of the speed begins at that of the scene."""
    view = _analyse(scene)
    start = abs(SpindleSpeedFunction(view.scene.spindle).start_speed)
    speeds = _shown_speeds(view.speed_curve, start)
    variable = replace(view.variable, key=key, value=start, low=speeds[0] / SLIDER_RATIO, high=speeds[1] * SLIDER_RATIO)
    return replace(view, variable=variable)


def _analyse(scene: Scene) -> GovernorView:
    """Return the view of a scene; the range of its speeds is not known."""
    alone = _at_given_speed(scene)
    curve = compute_speed_curve(alone, CURVE_POINTS)
    variable = Slider(name=SPEED, words="spindle speed", key="", kind="angular_speed", unit="rad/s", value=0.0, low=0.0, high=1.0)
    return GovernorView(
        scene=alone,
        reduction=SingleDofReduction(alone),
        speed_curve=curve,
        variable=variable,
        given=curve,
        film_speeds=_speed_range(rotating_part_alone(scene).spindle),
    )


def _speed_range(spindle: Spindle | FreeSpindle) -> Vec2:
    """Return the lowest and the highest speed (rad/s) that is given for a spindle."""
    speeds = spindle.speeds if isinstance(spindle, Spindle) else (SpindleSpeedFunction(spindle).start_speed,)
    return min(map(abs, speeds)), max(map(abs, speeds))


def _preferred(equilibria: Sequence[Equilibrium], position: float) -> Equilibrium:
    """Return the equilibrium at which a mechanism comes to rest from a position: the nearest that is not unstable."""
    return min(equilibria, key=lambda one: (not (one.stable or one.astatic), abs(one.coordinate - position)))


def _travel_of(curve: SpeedCurve) -> Vec2:
    """Return both ends of the travel (SI)."""
    return float(curve.coordinate[0]), float(curve.coordinate[-1])


def _shown_speeds(curve: SpeedCurve, chosen: float) -> Vec2:
    """Return the range of speeds (rad/s) in which most of a curve and the chosen speed lie, with a margin."""
    margin = int(SHOWN_SHARE * CURVE_POINTS)
    within = slice(margin, CURVE_POINTS - margin)
    speeds = np.append(curve.speed[within][curve.has_equilibrium[within]], chosen)
    return (1 - SPEED_MARGIN) * float(speeds.min()), (1 + SPEED_MARGIN) * float(speeds.max()) or 1.0


def _at_given_speed(scene: Scene) -> Scene:
    """Return the rotating part of a scene alone, its spindle at the constant speed of the start: the slider replaces what drives it."""
    alone = rotating_part_alone(scene)
    speed = SpindleSpeedFunction(alone.spindle).start_speed
    return alone.with_changes(title=scene.title, spindle=Spindle(speeds=(speed,)))


def _joined(kind: BoolArray, curve: SpeedCurve) -> BoolArray:
    """Return which points a kind of line covers: its own, and the first one after them, so that kinds meet without a gap."""
    following = np.concatenate([[False], kind[:-1]])
    covered: BoolArray = kind | (following & curve.has_equilibrium)
    return covered


def _kind_of(equilibrium: Equilibrium) -> str:
    """Return whether an equilibrium is stable, unstable or neutral."""
    return "neutral" if equilibrium.astatic else "stable" if equilibrium.stable else "unstable"


def _describe_stability(equilibrium: Equilibrium) -> str:
    """Return a sentence on the motion near an equilibrium."""
    if equilibrium.stable:
        return f"Without damping it swings about it with {equilibrium.frequency / (2 * math.pi):.3g} Hz."
    if equilibrium.astatic:
        return "It stays wherever it is put."
    return f"Without damping a disturbance grows at the rate {equilibrium.divergence_rate:.3g} 1/s."
