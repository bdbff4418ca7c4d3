"""Text and JSON of the command `equilibria`: equilibria, linearised equations, limits of stability."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import ParamSpec, TypeVar

import governor_mechanism as gm
from governor_mechanism.cli.console import CommandResult
from governor_mechanism.cli.controlling_force import ControllingForceReport, report_controlling_force
from governor_mechanism.engines.rotating_part import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import finite_or_none, plain_record
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.equilibria import Equilibrium, has_damping
from governor_mechanism.statics.equilibrium_speed import format_coordinate, has_equilibrium_speed, require_equilibrium_speed
from governor_mechanism.statics.first_order_system import Onset
from governor_mechanism.statics.linearisation import Linearisation
from governor_mechanism.statics.scene_linearisation import last_spindle_speed
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
from governor_mechanism.statics.stability_limit import StabilityLimit
from governor_mechanism.units.quantities import format_quantity, format_reading_name, number_or_text, parse_quantity

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


@dataclass(frozen=True, kw_only=True)
class EquilibriaReport:
    """The equilibria of a scene, and its speed curve and controlling force if it has an equilibrium speed.

    With each equilibrium goes its insensitivity band, the reason why there is none, or None if no resistance is given.
    """

    scene: Scene
    points: Sequence[tuple[Equilibrium, InsensitivityBand | str | None]]
    curve: SpeedCurve | None
    controlling_force: ControllingForceReport | None

    def lines(self) -> list[str]:
        """Return one line per equilibrium, each followed by its insensitivity band, one per jump, and those on the controlling force."""
        scene, lines = self.scene, []
        name = format_reading_name(scene.part.mechanism.coordinate)
        for equilibrium, band in self.points:
            lines.append(f"{name} {_format_position(scene, equilibrium)}: {_format_stability(scene, equilibrium)}")
            lines += [] if band is None else [f"  {_format_band(scene, band)}"]
        folds = self.curve.folds if self.curve else ()
        lines += [f"jumps at {format_coordinate(scene, at)}, {format_quantity(speed, 'rad/s')}" for at, speed in folds]
        return lines + (self.controlling_force.lines() if self.controlling_force else [])

    def as_json(self) -> dict[str, object]:
        """Return equilibria, speed curve and controlling force in SI; instead of what is missing, the reason."""
        rows = [_equilibrium_values(*point) for point in self.points]
        values = {"coordinate": self.scene.part.mechanism.coordinate, "undamped": has_damping(self.scene), "equilibria": rows}
        curve = self.curve
        if curve is None:
            return values
        folds = [{"coordinate": value, "speed": at} for value, at in curve.folds]
        values |= {"folds": folds, "poles": curve.poles, "low_end": curve.low_end_message, "high_end": curve.high_end_message}
        return values | ({} if self.controlling_force is None else {"controlling_force": self.controlling_force.as_json()})


def report_equilibria(
    scene: Scene,
    spindle_speed: float | None,
    resistance: str | None,
    against: str | None,
    working_range: str | None = None,
    speed_change: float | None = None,
) -> EquilibriaReport:
    """Find the equilibria of the part that turns with a spindle, and their insensitivity bands with a resistance at a reading.

    A working range "READING=LOW:HIGH" and a relative change of speed are those of sensitiveness, effort and power, which act along the
    reading `against`, by default the lift of the sleeve. What is given and cannot be used is refused.
    """
    scene = rotating_part_alone(scene)
    sleeve = DEFAULT_SLEEVE if against is None else against
    force = None if resistance is None else _parse_resistance(scene, resistance, sleeve)
    points = gm.equilibria(scene, spindle_speed)
    curve, controlling_force = None, None
    is_force_wanted = working_range is not None or speed_change is not None or (against is not None and resistance is None)
    if is_force_wanted:
        require_equilibrium_speed(scene)
    if has_equilibrium_speed(scene):
        curve = gm.speed_curve(scene, resistance=force, against=sleeve)
        controlling_force = report_controlling_force(
            scene,
            points,
            working_range=working_range,
            speed_change=speed_change,
            resistance=force,
            against=sleeve,
            is_wanted=is_force_wanted,
        )
    bands = [
        None if force is None else _result_or_reason(gm.insensitivity_band, scene, [point.coordinate], force, sleeve) for point in points
    ]
    rows = list(zip(points, bands, strict=True))
    return EquilibriaReport(scene=scene, points=rows, curve=curve, controlling_force=controlling_force)


def _parse_resistance(scene: Scene, text: str, against: str) -> float:
    require_equilibrium_speed(scene)
    quantities = {reading.name: reading.quantity for reading in scene.part.mechanism.readings}
    if against not in quantities:
        raise MechanismError(
            f"--resistance acts along a reading, and there is no reading {against!r}; choose one with --against: {list(quantities)}"
        )
    return parse_quantity(text, "torque" if quantities[against] == "angle" else "force", "--resistance")


def _result_or_reason(function: Callable[_Arguments, _Result], *arguments: _Arguments.args, **options: _Arguments.kwargs) -> _Result | str:
    """Return the result of a function, or the reason why there is none."""
    try:
        return function(*arguments, **options)
    except MechanismError as error:
        return error.problems[0]


DEFAULT_SLEEVE = "sleeve_lift"
"""The reading of the sleeve of most governors."""

EQUILIBRIUM_KEYS = ("coordinate", "extent", "stable", "stiffness", "frequency", "divergence_rate", "uncertainty", "sensitivity", "readings")
BAND_KEYS = ("falling_speed", "rising_speed", "insensitivity")
"""What is printed of an equilibrium and of an insensitivity band."""


def _equilibrium_values(equilibrium: Equilibrium, band: InsensitivityBand | str | None) -> dict[str, object]:
    values = _select_attributes(equilibrium, EQUILIBRIUM_KEYS) | {"sensitivity": finite_or_none(equilibrium.sensitivity)}
    if isinstance(band, InsensitivityBand):
        return values | {"insensitivity_band": {name: finite_or_none(getattr(band, name)[0]) for name in BAND_KEYS}}
    return values | ({} if band is None else {"insensitivity_band": band})


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


NEARLY_ASTATIC_SENSITIVITY = 10.0
"""Displacement per relative speed change, rad or machine sizes, above which an equilibrium is nearly astatic."""


def _format_stability(scene: Scene, equilibrium: Equilibrium) -> str:
    if equilibrium.astatic:
        return "astatic, in equilibrium anywhere between"
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


def report_linearisation(
    scene: Scene,
    spindle_speed: float | None,  # speed of the spindle, rad/s; that of the scene if None
    limit: str | None,  # key and range as "KEY=LOW:HIGH" for a limit of stability, or None
) -> CommandResult:
    """Return what `equilibria --linearise` and `--limit` print.

    Result: lines for the terminal, and the same in SI. Raises MechanismError if nothing can be linearised.
    """
    if limit is not None:
        key, low, high = _parse_limit(limit)
        result = gm.stability_limit(scene, key, low, high)
        values = {"limit": plain_record(result, "linearisation"), "linearisations": [_values_of(result.linearisation)]}
        return CommandResult(text=[scene.title, _format_limit(result), result.linearisation], values=values)
    linearisations = _linearise_all(scene, spindle_speed)
    return CommandResult(text=[scene.title, *linearisations], values={"linearisations": [*map(_values_of, linearisations)]})


def _linearise_all(scene: Scene, spindle_speed: float | None) -> Sequence[Linearisation | str]:
    """Linearise about each equilibrium, or give the reason why not; about the state nearest to the start if no equilibria are known."""
    if len(scene.parts) > 1 or not isinstance(scene.spindle, Spindle):
        return [gm.linearise(scene, spindle_speed)]
    points = _result_or_reason(gm.equilibria, scene, last_spindle_speed(scene) if spindle_speed is None else spindle_speed)
    if isinstance(points, str):
        return [gm.linearise(scene, spindle_speed)]
    results = [_result_or_reason(gm.linearise, scene, spindle_speed, at=point) for point in points]
    if all(isinstance(one, str) for one in results):
        raise MechanismError(*dict.fromkeys(map(str, results)))
    return results


def _parse_limit(text: str) -> tuple[str, str | float, str | float]:
    key, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and key.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--limit {text!r} is not understood; write "KEY=LOW:HIGH", as in "effects.dashpot.sleeve=0:100"')
    return key.strip(), number_or_text(low), number_or_text(high)


def _format_limit(limit: StabilityLimit[Linearisation]) -> str:
    value = f"{limit.value:.10g} {limit.unit}".strip()
    side = "below" if limit.stable_below else "above"
    if not limit.frequency:
        return f"{limit.key}: stable {side} {value}; at the limit the motion diverges without oscillation"
    onset = {
        Onset.SOFT: "soft (their amplitude grows from zero)",
        Onset.HARD: "hard (large disturbances lead to large oscillations on the stable side too)",
        Onset.UNKNOWN: "not determined",
    }[limit.onset]
    return f"{limit.key}: stable {side} {value}; oscillations of {limit.frequency:.6g} rad/s begin there, onset {onset}"


MODE_KEYS = ("eigenvalue", "error_estimate", "natural_frequency", "damping_ratio", "is_conserved", "amplitudes")
"""What is printed of a mode."""


def _values_of(linearisation: Linearisation | str) -> object:
    """Return what is printed of linearised equations, or the reason why there are none."""
    if isinstance(linearisation, str):
        return linearisation
    values = _select_attributes(linearisation, ("readings", "rates", "stability", "stable", "error_estimate"))
    modes = [_select_attributes(mode, MODE_KEYS) for mode in linearisation.modes]
    return {**values, "states": linearisation.state_names, "matrix": linearisation.matrix, "modes": modes, "notes": linearisation.notes}


def _select_attributes(value: object, names: Iterable[str]) -> dict[str, object]:
    return {name: getattr(value, name) for name in names}
