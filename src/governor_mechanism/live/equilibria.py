"""The equilibria of what turns with a spindle, as a curve beside the drawing."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.engines.rotating_part import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.live.plot_svg import Plot, label_axis
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, SKY, VERMILLION
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import has_equilibrium_speed
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve, compute_speed_curve
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_quantity, format_reading_name

COLOUR: Final = re.compile(r'(fill|stroke)="#([0-9a-fA-F]{6})"')
"""A colour of a picture, which has a counterpart on a dark ground, or is the same there."""

CURVE_POINTS: Final = 150
"""Number of points of the speed curve: one for every other pixel of the plot."""

SHOWN_SHARE: Final = 0.1
"""Share of the travel at each end of the speed curve that does not decide which speeds are shown: it may tend to zero or infinity there."""

SPEED_MARGIN: Final = 0.15
"""Margin of the shown speeds, relative to the lowest and the highest one."""

GIVEN_NAME: Final = "as opened"
GIVEN_DASHES: Final = "2 3"
"""Name and dashes of the curve of the scene as it was opened."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Statics:
    """The equilibria of the part of a scene that turns with a spindle, at the speed with which it starts."""

    scene: Scene  # the part alone, at a constant speed
    curve: SpeedCurve
    speed: float  # rad/s
    equilibria: tuple[Equilibrium, ...]
    problem: str  # why there is none at this speed; empty if there is one


class EquilibriumPlot:
    """The speed curve of a scene, with that of the scene as it was opened behind it."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._first = scene, _analyse(scene)

    def draw(self, scene: Scene) -> dict[str, str] | None:
        """Return the curve as SVG, and sentences on the equilibria; None if no spindle speed balances the loads of the scene."""
        found = self._first if scene == self._scene else _analyse(scene)
        if found is None:
            return None
        picture = _plot(found, (self._first or found).curve)
        return {"picture": COLOUR.sub(r'\1="var(--c-\2, #\2)"', picture), "sentences": " ".join(_describe(found))}


def _analyse(scene: Scene) -> Statics | None:
    """Return the equilibria of a scene; None without a part that turns, or without a speed curve."""
    turns = any(part.turns for part in scene.parts)
    if not turns or (len(scene.parts) == 1 and not has_equilibrium_speed(scene)):
        return None
    try:
        alone = rotating_part_alone(scene)
        speed = abs(SpindleSpeedFunction(alone.spindle).start_speed)
        alone = alone.with_changes(spindle=Spindle(speeds=(speed,)))
        curve = compute_speed_curve(alone, CURVE_POINTS, **_friction_of(alone))
    except MechanismError:
        return None
    try:
        equilibria, problem = find_equilibria(alone, speed), ""
    except MechanismError as error:
        sentence = "; ".join(error.problems)
        equilibria, problem = (), f"{sentence[:1].upper()}{sentence[1:]}."
    return Statics(scene=alone, curve=curve, speed=speed, equilibria=equilibria, problem=problem)


def _friction_of(scene: Scene) -> dict[str, Any]:
    """Return resistance and reading of the constant dry friction of a scene; nothing unless there is just one."""
    frictions = [one for one in scene.output_effects if isinstance(one, DryFriction)]
    if len(frictions) != 1 or not frictions[0].force.is_constant:
        return {}
    return {"resistance": frictions[0].force.values[0], "against": frictions[0].reading}


def _describe(found: Statics) -> list[str]:
    """Return sentences on the equilibria: which the mechanism comes to rest in, how stable it is, which others there are, the friction."""
    if found.problem:
        return [found.problem, *_describe_band(found, None)]
    shown = _preferred(found)
    others = [f"{_place_of(found, one)} ({_kind_of(one)})" for one in found.equilibria if one is not shown]
    speed = format_quantity(found.speed, "rad/s", ".5g")
    sentence = f"At {speed}: {_kind_of(shown)} equilibrium at {_place_of(found, shown)}{_other_readings(found, shown)}."
    also = [f"Also in equilibrium at {', '.join(others)}."] if others else []
    return [sentence, _describe_stability(shown), *also, *_describe_band(found, shown)]


def _preferred(found: Statics) -> Equilibrium:
    """Return the equilibrium at which a mechanism comes to rest from its start: the nearest that is not unstable."""
    start = found.scene.start.values.get(found.curve.coordinate_name)
    position = start if isinstance(start, float) else 0.5 * sum(_travel_of(found.curve))
    return min(found.equilibria, key=lambda one: (not (one.stable or one.astatic), abs(one.coordinate - position)))


def _describe_band(found: Statics, shown: Equilibrium | None) -> list[str]:
    """Return a sentence on the speeds between which dry friction holds the mechanism where it is."""
    band = found.curve.insensitivity_band
    if band is None or not band.resistance or shown is None:
        return []
    falling, rising = (np.interp(shown.coordinate, found.curve.coordinate, one) for one in (band.falling_speed, band.rising_speed))
    low, high = (format_quantity(float(one), "rad/s", ".4g") for one in (falling, rising))
    share = f" (insensitivity {100 * float(rising - falling) / found.speed:.2g} %)" if found.speed and np.isfinite(rising) else ""
    return [f"Dry friction holds it there between {low} and {high}{share}."]


def _plot(found: Statics, given: SpeedCurve) -> str:
    """Return the speed curve with the speed of the scene and its equilibria."""
    curve, name = found.curve, found.curve.coordinate_name
    factor, unit = DISPLAY_UNITS[_unit_of(found, name)]
    x, y = curve.coordinate * factor, curve.speed / RPM
    ends = np.array([*_travel_of(given), *_travel_of(curve)]) * factor
    speeds = np.array([*_shown_speeds(given, found.speed), *_shown_speeds(curve, found.speed)]) / RPM
    limits = (ends.min(), ends.max()), (speeds.min(), speeds.max())
    plot = Plot(label_axis(name, unit), label_axis("equilibrium_speed", "rpm"), *limits)
    if not curve.has_equilibrium.any():
        plot.add_note("no spindle speed gives an equilibrium")
    _add_band(plot, curve, curve.insensitivity_band, x)
    if given is not curve:
        shown = given.coordinate * factor, given.speed / RPM, given.has_equilibrium
        plot.add_curve(*shown, colour=MUTED, dashes=GIVEN_DASHES, name=GIVEN_NAME)
    plot.add_level(found.speed / RPM, GREEN, format_quantity(found.speed, "rad/s", ".5g"))
    unstable = curve.has_equilibrium & ~curve.stable & ~curve.astatic
    plot.add_curve(x, y, _joined(curve.stable, curve), colour=BLUE, name="stable")
    plot.add_curve(x, y, _joined(unstable, curve), colour=BLUE, dashes="6 4", name="unstable")
    plot.add_curve(x, y, curve.astatic, colour=BLUE, dashes="1.5 2.5", name="neutral")
    if curve.folds:
        plot.name_points(VERMILLION, "jump")
    for value, speed in curve.folds:
        plot.add_point(value * factor, speed / RPM, VERMILLION)
    for one in found.equilibria:
        plot.add_point(one.coordinate * factor, found.speed / RPM, INK, is_filled=one.stable)
    return plot.to_svg(f"equilibrium speed over {format_reading_name(name)}")


def _add_band(plot: Plot, curve: SpeedCurve, band: InsensitivityBand | None, x: FloatArray) -> None:
    """Draw the speeds between which dry friction holds the mechanism."""
    if band is not None and band.resistance:
        plot.add_band(x, band.falling_speed / RPM, band.rising_speed / RPM, curve.has_equilibrium, colour=SKY, name="held by friction")


def _unit_of(found: Statics, reading: str) -> str:
    """Return the SI unit of a reading."""
    return READING_UNITS[found.scene.mechanism.reading(reading).quantity]


def _place_of(found: Statics, equilibrium: Equilibrium) -> str:
    """Return the leading coordinate of an equilibrium in words."""
    name = found.curve.coordinate_name
    unit = _unit_of(found, name)
    if equilibrium.astatic:
        low, high = (format_quantity(end, unit, ".4g") for end in equilibrium.extent)
        return f"{format_reading_name(name)} {low} to {high}"
    return f"{format_reading_name(name)} {format_quantity(equilibrium.coordinate, unit, '.4g')}"


def _other_readings(found: Statics, equilibrium: Equilibrium) -> str:
    """Return the other readings of an equilibrium in words."""
    names = [name for name in equilibrium.readings if name != found.curve.coordinate_name]
    texts = [f"{format_reading_name(name)} {format_quantity(equilibrium.readings[name], _unit_of(found, name), '.4g')}" for name in names]
    return f" ({', '.join(texts)})" if texts and not equilibrium.astatic else ""


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


def _travel_of(curve: SpeedCurve) -> Vec2:
    """Return both ends of the travel (SI)."""
    return float(curve.coordinate[0]), float(curve.coordinate[-1])


def _shown_speeds(curve: SpeedCurve, chosen: float) -> Sequence[float]:
    """Return the range of speeds (rad/s) in which most of a curve and the chosen speed lie, with a margin."""
    margin = int(SHOWN_SHARE * CURVE_POINTS)
    within = slice(margin, CURVE_POINTS - margin)
    speeds = np.append(curve.speed[within][curve.has_equilibrium[within]], chosen)
    return (1 - SPEED_MARGIN) * float(speeds.min()), (1 + SPEED_MARGIN) * float(speeds.max()) or 1.0


def _joined(kind: BoolArray, curve: SpeedCurve) -> BoolArray:
    """Return which points a kind of line covers: its own, and the first one after them, so that kinds meet without a gap."""
    following = np.concatenate([[False], kind[:-1]])
    covered: BoolArray = kind | (following & curve.has_equilibrium)
    return covered
