"""Text summaries of the commands: a run in a few lines, equilibria, and the speeds at which a governor jumps."""

import math
from collections.abc import Sequence

from governor_mechanism.files.plain_values import finite_or_none
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.equilibria import Equilibrium, has_damping
from governor_mechanism.statics.equilibrium_speed import format_coordinate
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
from governor_mechanism.units.quantities import format_quantity, format_reading_name

Bands = Sequence[InsensitivityBand | str | None]
"""For each equilibrium: its insensitivity band, the reason why there is none, or None if no resistance is given."""


def format_equilibria(scene: Scene, equilibria: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Bands) -> list[str]:
    """Return one line per equilibrium, each followed by its insensitivity band, and one per jump."""
    name = format_reading_name(scene.part.mechanism.coordinate)
    lines = []
    for equilibrium, band in zip(equilibria, bands, strict=True):
        lines.append(f"{name} {_format_position(scene, equilibrium)}: {_format_stability(scene, equilibrium)}")
        if band is not None:
            lines.append(f"  {_format_band(scene, band)}")
    folds = curve.folds if curve else ()
    return lines + [f"jumps at {format_coordinate(scene, at)}, {format_quantity(speed, 'rad/s')}" for at, speed in folds]


EQUILIBRIUM_KEYS = ("coordinate", "extent", "stable", "stiffness", "frequency", "divergence_rate", "uncertainty", "sensitivity", "readings")
BAND_KEYS = ("falling_speed", "rising_speed", "insensitivity")
"""What is printed of an equilibrium and of an insensitivity band."""


def equilibria_as_json(scene: Scene, equilibria: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Bands) -> dict[str, object]:
    """Return equilibria and speed curve in SI; instead of a missing insensitivity band, the reason."""
    rows: list[dict[str, object]] = []
    for equilibrium, band in zip(equilibria, bands, strict=True):
        values = {name: getattr(equilibrium, name) for name in EQUILIBRIUM_KEYS}
        rows.append(values | {"sensitivity": finite_or_none(equilibrium.sensitivity)})
        if band is not None:
            numbers = {} if isinstance(band, str) else {name: finite_or_none(getattr(band, name)[0]) for name in BAND_KEYS}
            rows[-1]["insensitivity_band"] = numbers or band
    values = {"coordinate": scene.part.mechanism.coordinate, "undamped": has_damping(scene), "equilibria": rows}
    if curve is None:
        return values
    folds = [{"coordinate": value, "speed": at} for value, at in curve.folds]
    return {**values, "folds": folds, "poles": curve.poles, "low_end": curve.low_end_message, "high_end": curve.high_end_message}


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
    undamped = "undamped " if has_damping(scene) else ""
    stability = (
        f"stable, {undamped}natural frequency {equilibrium.frequency:.6g} rad/s"
        if equilibrium.stable
        else f"unstable, {undamped}divergence rate {equilibrium.divergence_rate:.6g} 1/s"
    )
    if not equilibrium.sensitivity:
        return f"{stability}; stiffness {equilibrium.stiffness:.6g}"
    sensitivity_clause = f"sensitivity {format_coordinate(scene, 0.01 * equilibrium.sensitivity)} per 1 % of speed"
    mechanism = scene.part.mechanism
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    qualifier = "nearly astatic, " if equilibrium.sensitivity > NEARLY_ASTATIC_SENSITIVITY * coordinate_scale else ""
    return f"{stability}; stiffness {equilibrium.stiffness:.6g}; {qualifier}{sensitivity_clause}"


def format_run(result: Trajectory) -> str:
    """Return a run in a few lines: outcome, accuracy, final readings, events and cost."""
    cost = result.cost
    requested_accuracy = result.settings["asked_accuracy"]
    estimate = result.error_estimate
    accuracy_clause = "" if estimate is None else f"accurate to {estimate:.1g} (requested {requested_accuracy:.1g}); "
    final = ", ".join(
        f"{format_reading_name(name)} {format_quantity(values[-1], result.units[name], '.4f')}"
        for name, values in result.readings.items()
        if len(values)
    )
    joint_gap = result.joint_gap.max(initial=0.0)
    evaluation_counts = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    setup_clause = f" plus {cost.setup_time:.1g} s for its tables" if cost.setup_time else ""
    return "\n".join(
        [
            result.scene.title,
            result.message,
            *result.notes,
            f"{accuracy_clause}joints closed to {joint_gap:.1e} m, energy drift {result.energy.drift:.1e}",
            f"at {result.times[-1] if len(result.times) else 0:g} s: {final}",
            f"{_format_mobility(result)}; {_format_events(result)}",
            *_format_losses(result),
            f"engine {cost.engine} ({cost.reason}): {cost.runs} runs, {cost.steps:,} steps, simulated in "
            f"{cost.wall_time:.2g} s{setup_clause}{f', {cost.method}' if cost.method else ''}",
            f"force law evaluations: {evaluation_counts or 'none'}",
        ]
    )


def _format_losses(result: Trajectory) -> list[str]:
    """Return the dissipated energy and the number of samples too close to an event, each only if it is positive."""
    dissipated_energy = float(result.energy.dissipated_energy[-1]) if len(result.times) else 0.0
    lines = [f"friction, dashpots and stops dissipated {dissipated_energy:.4g} J"] * (dissipated_energy > 0.0)
    return lines + [f"{result.n_excluded} samples are too close to an event for the promised accuracy"] * (result.n_excluded > 0)


def _format_mobility(result: Trajectory) -> str:
    joints = [joint for part in result.scene.parts for joint in part.mechanism.joints]
    n_drivers = sum(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in joints)
    return f"mobility {result.mobility}" + (f", {n_drivers} driver{'s' * (n_drivers > 1)}" if n_drivers else "")


MAX_LISTED_EVENTS = 3
"""Maximum number of events listed one by one, those that the scene names first."""


def _format_events(result: Trajectory) -> str:
    """Return the events and the largest joint force with the time at which it acts."""
    named_first = sorted(result.events, key=lambda event: event.kind is not EventKind.CROSSING)  # stable: in order of time otherwise
    listed_events = [str(event) for event in named_first[:MAX_LISTED_EVENTS]]
    n_more = len(result.events) - len(listed_events)
    events = "; ".join(listed_events + [f"and {n_more} more events"] * (n_more > 0)) or "no events"
    forces = {name: reaction.magnitude for name, reaction in result.reactions.items()}
    largest = max(forces, key=lambda name: forces[name].max(initial=0.0), default=None)
    if largest is None or not len(result.times):
        return events
    index = int(forces[largest].argmax())
    indeterminate_joints = [name for name, reaction in result.reactions.items() if not reaction.determined.all()]
    largest_force_clause = f"largest joint force {forces[largest][index]:.4g} N in {largest!r} at {result.times[index]:.4g} s"
    redundancy_clause = (
        f"; statically indeterminate joint forces: {', '.join(map(repr, indeterminate_joints))}" if indeterminate_joints else ""
    )
    return f"{events}\n{largest_force_clause}{redundancy_clause}"
