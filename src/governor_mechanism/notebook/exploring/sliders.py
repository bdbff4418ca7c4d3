"""Sliders of a view: which keys of a scene they move, from where to where; and what its pictures show at one moment."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.pose_drawing import PoseDrawing
from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.studies.sweep.parameters import SweepAxis, parse_axes
from governor_mechanism.types import FloatArray
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import DISPLAY_UNITS, QUANTITY_KINDS, format_value, number_or_text, parse_quantity

MAX_DEFAULT_SLIDERS = 4
"""Number of dimensions that have a slider if none is named: more do not fit beside the pictures."""

LEADING_DIMENSIONS = {"stephenson": ("reverser", "advance", "half_link", "hanger")}
"""Dimensions that come first by machine; of the other machines these are the first ones of their class."""

UNSPOKEN_WORDS = ("dimensions", "effects", "body")
"""Words of a dotted key that its label leaves out."""

SLIDER_STEPS = 400
"""Largest number of steps of a slider: about a step for each pixel."""

RANGE_BISECTIONS = 10
"""Number of bisections toward the end of what the geometry admits, which is found to 0.1 % of the range: less than a step."""

ZERO_ANGLE_RANGE = math.pi / 4
"""Range to either side of an angle that is zero, rad."""

PROBED_VALUE = 1.0
"""Value with which it is found out whether a key exists."""

Probe = Callable[[str, float | str], object]
"""Function of a key and a value of the document that raises MechanismError if the geometry does not admit it."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slider:
    """A number that is dragged.

    Attributes
    ----------
    name
        Name of a dimension, or of a rod for its length, or a dotted key without that of its part.
    words
        What it is, as in "crank length".
    key
        Dotted key of the scene document; empty for a value that is not in it.
    kind
        Kind of quantity.
    unit
        SI unit.
    value
        Value at the start, SI.
    low, high
        Ends of the range, SI.
    is_given
        Whether the scene gives the value; else the view adds it to the scene.
    """

    name: str
    words: str
    key: str
    kind: str
    unit: str
    value: float
    low: float
    high: float
    is_given: bool = True

    @property
    def display(self) -> tuple[float, str]:
        """Factor from SI to the unit shown to users, and that unit."""
        return DISPLAY_UNITS.get(self.unit, (1.0, self.unit))

    @property
    def label(self) -> str:
        """What it is, with the unit."""
        unit = self.display[1]
        return f"{self.words}, {unit}" if unit else self.words

    @property
    def step(self) -> float:
        """Round step in the unit shown to users."""
        return round_step((self.high - self.low) * self.display[0], SLIDER_STEPS)

    def parse(self, value: float | str) -> float:
        """Return a number in SI, or text with a unit, in SI. Raise MechanismError for anything else."""
        return parse_quantity(value, self.kind, self.name)

    def write(self, value: float) -> float | str:
        """Return a value as a scene file has it: text with the unit shown to users."""
        factor, unit = self.display
        return f"{value * factor:.12g} {unit}" if unit else value


def find_sliders(
    document: Mapping[str, Any],
    part: Part,  # the part that is shown, whose dimensions have short names
    # keys or names of dimensions, also with a range, as "arm=200 mm:400 mm"; empty for the first dimensions
    # of the machine
    requests: Sequence[str],
    # function of a key and a value of the document; it raises MechanismError if the geometry does not admit
    # it
    probe: Probe,
) -> list[Slider]:
    """Return the sliders of requested keys, or of the dimensions that matter most."""
    prefix = f"part.{part.name}." if "part" in document else ""
    own: Mapping[str, Any] = document.get("part", {}).get(part.name, {}) if prefix else document
    for request in requests:
        if not isinstance(request, str):
            raise MechanismError(f'explore takes names of dimensions, as "arm" or "dimensions.arm"; found {format_value(request)}')
    names = [*dict.fromkeys(requests)] or [prefix + key for key in _default_keys(own, part)]
    return [_make_slider(document, _full_key(name, prefix, own, part), part, prefix, probe) for name in names]


def _default_keys(own: Mapping[str, Any], part: Part) -> list[str]:
    """Return the keys of the first numeric dimensions that the document gives, or of the lengths of rods."""
    machine = MACHINES.get(part.machine)
    if machine is None:
        return list(_rod_keys(own).values())[:MAX_DEFAULT_SLIDERS]
    fields = [name for name, declared in fields_of(machine).items() if declared.form != "choice"]
    given = {name: value for name, value in own.get("dimensions", {}).items() if isinstance(value, int | float | str)}
    names = [*LEADING_DIMENSIONS.get(part.machine, ()), *(name for name in fields if name not in machine.driver_dimensions)]
    # A word such as "endless" stands for a dimension that is left out.
    numeric = [name for name in dict.fromkeys(names) if name in given and math.isfinite(part.dimensions.get(name, math.inf))]
    return [f"dimensions.{name}" for name in numeric[:MAX_DEFAULT_SLIDERS]]


def _rod_keys(own: Mapping[str, Any]) -> dict[str, str]:
    """Return the keys of the lengths of the rods of a custom mechanism by the names of the rods."""
    rods = [str(body.get("name")) for body in own.get("body", ()) if "length" in body.get("rod", {})]
    return {name: f"body.{name}.rod.length" for name in rods}


def _full_key(request: str, prefix: str, own: Mapping[str, Any], part: Part) -> str:
    """Return a request with the dotted key of the document in place of a short name."""
    name, equals, values = (piece.strip() for piece in request.partition("="))
    machine = MACHINES.get(part.machine)
    dimensions = [field.name for field in dataclasses.fields(machine)] if machine else []
    rods = {} if machine else _rod_keys(own)
    if name in dimensions:
        name = f"dimensions.{name}"
    elif name in rods:
        name = rods[name]
    elif "." not in name:
        known = [*dimensions, *rods]
        raise MechanismError(
            f"{format_value(name)} is no dimension of this scene; its dimensions are {', '.join(known) or 'none'}, and other numbers have "
            f'dotted keys, as "effects.spring.sleeve.rate".{did_you_mean(name, known)}'
        )
    key = name if name.startswith(("part.", "coupling.", "load.")) else f"{prefix}{name}"
    return f"{key}{equals}{values}"


def _make_slider(document: Mapping[str, Any], request: str, part: Part, prefix: str, probe: Probe) -> Slider:
    """Return the slider of a key, with its range if the request has one."""
    key, _, values = request.partition("=")
    name = key.removeprefix(prefix)
    field_name = name.removeprefix("dimensions.") if name.startswith("dimensions.") else ""
    current = _find_value(document, key)
    ends = _split_range(key, values) if values else ()
    is_given = not (current is None or isinstance(current, bool | list | dict))
    if not is_given:  # the value that stands for it, or the middle of its range
        current = math.inf if ends else part.dimensions.get(field_name, math.inf)
    given = [current] if isinstance(current, str) or math.isfinite(current) else []
    axis = _read_axis(document, key, [*given, *ends] if is_given or ends else [], given)
    numbers = [float(value) for value in axis.values]
    low, high = (min(numbers), max(numbers)) if ends else _default_range(numbers[0], axis.kind, part, field_name)
    value = numbers[0] if given else 0.5 * (low + high)
    rod = name.removeprefix("body.").removesuffix(".rod.length") if name.endswith(".rod.length") else ""
    words = f"{rod} length" if rod else " ".join(word for word in name.split(".") if word not in UNSPOKEN_WORDS).replace("_", " ")
    names = {"name": field_name or rod or name, "words": words, "key": key, "kind": axis.kind, "unit": axis.unit}
    return _shrink(Slider(**names, value=value, low=low, high=high, is_given=is_given), probe)


def _read_axis(document: Mapping[str, Any], key: str, values: Sequence[float | str], fallback: Sequence[float | str]) -> SweepAxis:
    """Return the values of a key as numbers in SI; of a key without a value and a range, those that stand for it."""
    axis: SweepAxis | None = None
    try:
        (axis,) = parse_axes(document, {key: [*dict.fromkeys(values or fallback or [PROBED_VALUE])]})
    except MechanismError as error:
        problems = [problem.removeprefix("vary: ") for problem in error.problems]
        if values or any(" is unknown" in problem for problem in problems):
            raise MechanismError(*problems) from None
    if axis is None or not (values or fallback):
        raise MechanismError(f"{key} has no number in this scene; give a range, as explore(scene, '{key}=first:last')")
    if not axis.is_numeric:
        raise MechanismError(f"{key} takes words, and a slider moves numbers; choose another key")
    return axis


def _find_value(document: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key of a document, or None."""
    found: Any = document
    for name in key.split("."):
        if isinstance(found, list | tuple):
            named = [item for item in found if item.get("name") == name]
            found = named[0] if named else found[int(name) - 1] if name.isdecimal() and 1 <= int(name) <= len(found) else None
        else:
            found = found.get(name) if isinstance(found, Mapping) else None
    return found


def _split_range(key: str, text: str) -> list[float | str]:
    """Return both ends of "first:last", as numbers or texts."""
    ends = [end.strip() for end in text.split(":")]
    if len(ends) != 2 or not all(ends):
        raise MechanismError(f"{key}={text} is not a range; write first:last, as in {key}=200 mm:400 mm")
    return [number_or_text(end) for end in ends]


def _default_range(value: float, kind: str, part: Part, dimension: str) -> tuple[float, float]:
    """Return half to double a value (SI) within the declared limit of a dimension; of a signed ratio both signs."""
    machine = MACHINES.get(part.machine)
    is_signed = bool(machine and dimension) and fields_of(machine)[dimension].sign == "any"
    if kind == "ratio" and is_signed:  # as a reversing lever, which goes from 1 to -1; other limits are found by trial
        return -2.0 * (abs(value) or 1.0), 2.0 * (abs(value) or 1.0)
    if value == 0.0:
        half = {"length": 0.5 * part.mechanism.length_scale, "angle": ZERO_ANGLE_RANGE}.get(kind, 1.0)
        return -half, half
    return min(0.5 * value, 2.0 * value), min(max(0.5 * value, 2.0 * value), QUANTITY_KINDS[kind].largest)


def _shrink(slider: Slider, probe: Probe) -> Slider:
    """Return a slider whose range has no impossible end, and round ends where it was shrunk."""
    ends = []
    for end, rounding in ((slider.low, math.ceil), (slider.high, math.floor)):
        possible, impossible = slider.value, end
        if _is_possible(slider, end, probe):
            ends.append(end)
            continue
        for _ in range(RANGE_BISECTIONS):
            middle = 0.5 * (possible + impossible)
            possible, impossible = (middle, impossible) if _is_possible(slider, middle, probe) else (possible, middle)
        factor, step = slider.display[0], slider.step
        nearest = round(possible * factor / step) * step / factor
        inner = rounding(possible * factor / step) * step / factor
        rounded = nearest if _is_possible(slider, nearest, probe) else inner
        ends.append(rounded if slider.low <= rounded <= slider.high else possible)
    low, high = min(ends[0], slider.value), max(ends[1], slider.value)
    if not low < high:
        raise MechanismError(f"{slider.key} cannot be changed: the mechanism allows no other value near {slider.write(slider.value)}")
    return dataclasses.replace(slider, low=low, high=high)


def _is_possible(slider: Slider, value: float, probe: Probe) -> bool:
    """Return whether the geometry admits a value."""
    try:
        probe(slider.key, slider.write(value))
    except MechanismError:
        return False
    return True


STOP_POINTS = 10_001
"""Number of positions at which it is found out whether stops allow them: in steps of less than 0.02 degrees of an arm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewState:
    """State at one value of the variable that is dragged."""

    value: float  # value of the variable, SI
    position: float  # leading coordinate of the shown pose, SI
    pose: FloatArray  # the shown pose; shape (bodies, 3)
    sentences: tuple[str, ...]  # what it is, one sentence each
    problem: str = ""  # why there is no equilibrium, so that the pose is an earlier one; empty if there is one
    equilibria: tuple[Equilibrium, ...] = ()  # equilibria, of which `equilibrium` is the shown one; None without any
    equilibrium: Equilibrium | None = None


class View(Protocol):
    """A mechanism whose pose follows one variable: the spindle speed, a coordinate, or time."""

    @property
    def scene(self) -> Scene:
        """The scene of one part that is shown."""

    @property
    def variable(self) -> Slider:
        """The slider of the variable."""

    def drawing_at(self, position: float) -> PoseDrawing:
        """Return the drawing whose layout leaves room for the motion around a position."""

    @property
    def speed_curve(self) -> SpeedCurve | None:
        """Equilibrium speed over the travel, if the pose follows the spindle speed."""

    @property
    def kinematics(self) -> Kinematics | None:
        """The motion over the variable, if that is a coordinate or time."""

    @property
    def reading_choices(self) -> Mapping[str, str]:
        """Readings that the plot can show over the variable, with their units; empty if it shows the speed curve."""

    def with_scene(self, scene: Scene) -> "View":
        """Return the view of a changed scene over the same range of the variable. Raise MechanismError if its geometry is impossible."""

    def check_geometry(self, scene: Scene) -> object:
        """Raise MechanismError if the geometry of a changed scene is impossible."""

    def solve(self, value: float, last: ViewState | None) -> ViewState:
        """Return the state at a value of the variable, near the last one."""

    def plot(self, state: ViewState, reading: str, *, is_faded: bool) -> str:
        """Return the picture of the curve with the state marked."""


def travel_within_stops(scene: Scene, coordinate: FloatArray, readings: Mapping[str, FloatArray]) -> Vec2:
    """Return the ends of a travel, given by the values (n,) of its coordinate and readings, as far as the stops of a scene allow."""
    positions = np.linspace(coordinate[0], coordinate[-1], STOP_POINTS)
    is_free = np.ones(STOP_POINTS, dtype=np.bool_)
    for stops in scene.effects:
        if isinstance(stops, Stops) and stops.reading in readings:
            values = np.interp(positions, coordinate, readings[stops.reading])
            is_free &= (values >= stops.low) & (values <= stops.high)
    free = positions[is_free] if is_free.sum() > 1 else positions
    return float(free[0]), float(free[-1])
