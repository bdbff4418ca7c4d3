"""What the commands say: a run in a few lines, equilibrium positions and the speeds at which a governor jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from governor_mechanism.cli.console import finite_or_none
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.equilibrium_speed import format_coordinate
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
from governor_mechanism.units.quantities import format_quantity


def format_equilibria(
    scene: Scene, equilibria: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Sequence[InsensitivityBand | str] = ()
) -> list[str]:
    """A line for each equilibrium position, with the insensitivity band there (or why there is none), and for each jump."""
    lines = []
    for k, equilibrium in enumerate(equilibria):
        lines.append(
            f"{scene.part.mechanism.coordinate.replace('_', ' ')} {_format_position(scene, equilibrium)}: {_format_stability(scene, equilibrium)}"
        )
        lines += [f"  {_format_band(scene, band)}" for band in bands[k : k + 1]]
    folds = curve.folds if curve else ()
    return lines + [f"jumps at {format_coordinate(scene, at)}, {format_quantity(speed, 'rad/s')}" for at, speed in folds]


def equilibria_as_json(
    equilibria: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Sequence[InsensitivityBand | str] = ()
) -> dict[str, Any]:
    """The same as values in SI; where there is no insensitivity band, the sentence that says why."""
    field_names = ("coordinate", "extent", "stable", "stiffness", "frequency", "divergence_rate", "uncertainty")
    rows = []
    for k, equilibrium in enumerate(equilibria):
        row = {key: getattr(equilibrium, key) for key in field_names}
        row |= {"sensitivity": finite_or_none(equilibrium.sensitivity), "readings": dict(equilibrium.readings)}
        for band in bands[k : k + 1]:
            names = ("falling_speed", "rising_speed", "insensitivity")
            values = {} if isinstance(band, str) else {name: finite_or_none(float(getattr(band, name)[0])) for name in names}
            row["insensitivity_band"] = values or band
        rows.append(row)
    if curve is None:
        return {"equilibria": rows}
    return {
        "equilibria": rows,
        "folds": [{"coordinate": value, "speed": at} for value, at in curve.folds],
        "poles": list(curve.poles),
        "low_end": curve.low_end_message,
        "high_end": curve.high_end_message,
    }


def _format_band(scene: Scene, band: InsensitivityBand | str) -> str:
    if isinstance(band, str):
        return band
    unit = "N m" if scene.part.mechanism.reading(band.against).quantity == "angle" else "N"
    falling_speed, rising_speed = (format_quantity(float(speed[0]), "rad/s") for speed in (band.falling_speed, band.rising_speed))
    sentence = f"{band.resistance:g} {unit} at {band.against} hold it from {falling_speed} to {rising_speed}"
    if math.isinf(band.insensitivity[0]):
        return f"{sentence}; without resistance it rests on a spindle that stands"
    return f"{sentence}: insensitivity {band.insensitivity[0]:.6g}"


def _format_position(scene: Scene, equilibrium: Equilibrium) -> str:
    if equilibrium.astatic:
        return " to ".join(format_coordinate(scene, end) for end in equilibrium.extent)
    return format_coordinate(scene, equilibrium.coordinate)


NEARLY_ASTATIC_SENSITIVITY = 10.0
"""rad, or machine sizes, for the speed changed by its whole: softer than this the position says little."""


def _format_stability(scene: Scene, equilibrium: Equilibrium) -> str:
    if equilibrium.astatic:
        return "astatic, it rests anywhere between"
    stability = (
        f"stable, swings at {equilibrium.frequency:.6g} rad/s"
        if equilibrium.stable
        else f"unstable, grows at {equilibrium.divergence_rate:.6g} /s"
    )
    if not equilibrium.sensitivity:
        return f"{stability}; stiffness {equilibrium.stiffness:.6g}"
    sensitivity_clause = f"1 % of speed moves it {format_coordinate(scene, 0.01 * equilibrium.sensitivity)}"
    mechanism = scene.part.mechanism
    coordinate_scale = 1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.length_scale
    qualifier = "nearly astatic, " if equilibrium.sensitivity > NEARLY_ASTATIC_SENSITIVITY * coordinate_scale else ""
    return f"{stability}; stiffness {equilibrium.stiffness:.6g}; {qualifier}{sensitivity_clause}"


def format_run(result: Trajectory) -> str:
    """A run in a few lines: how it ended, how accurate, where it is, what it cost."""
    cost = result.cost
    requested_accuracy = result.settings["asked_accuracy"]
    estimate = result.error_estimate
    accuracy_clause = "" if estimate is None else f"accurate to {estimate:.1g} (asked {requested_accuracy:.1g}); "
    final = ", ".join(
        f"{name.replace('_', ' ')} {format_quantity(values[-1], result.units[name], '.4f')}"
        for name, values in result.readings.items()
        if len(values)
    )
    joint_gap = result.joint_gap.max(initial=0.0)
    evaluation_counts = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    setup_clause = f" beside {cost.setup_time:.1g} s for its tables" if cost.setup_time else ""
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
            f"law evaluations: {evaluation_counts or 'none'}",
        ]
    )


def _format_losses(result: Trajectory) -> list[str]:
    """What friction, brakes and stops have taken, and the samples that events leave in doubt, if there are any."""
    dissipated_energy = float(result.energy.dissipated_energy[-1]) if len(result.times) else 0.0
    lines = [f"friction, brakes and stops took {dissipated_energy:.4g} J"] * (dissipated_energy > 0.0)
    return lines + [f"{result.n_excluded} samples stand too near an event to be promised"] * (result.n_excluded > 0)


def _format_mobility(result: Trajectory) -> str:
    joints = [joint for part in result.scene.parts for joint in part.mechanism.joints]
    n_drivers = sum(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in joints)
    return f"mobility {result.mobility}" + (f" beside {n_drivers} driven" if n_drivers else "")


MAX_LISTED_EVENTS = 3
"""So many are told one by one."""


def _format_events(result: Trajectory) -> str:
    """What the motion passed, and the joint that carried most."""
    listed_events = [str(event) for event in result.events[:MAX_LISTED_EVENTS]]
    n_more = len(result.events) - len(listed_events)
    events = "; ".join(listed_events + [f"and {n_more} more events"] * (n_more > 0)) or "no dead centre or change point passed"
    forces = {name: reaction.magnitude for name, reaction in result.reactions.items()}
    largest = max(forces, key=lambda name: forces[name].max(initial=0.0), default=None)
    if largest is None or not len(result.times):
        return events
    index = int(forces[largest].argmax())
    indeterminate_joints = [name for name, reaction in result.reactions.items() if not reaction.determined.all()]
    largest_force_clause = f"largest joint force {forces[largest][index]:.4g} N in {largest!r} at {result.times[index]:.4g} s"
    redundancy_clause = (
        f"; not settled by rigid bodies: the forces of {', '.join(map(repr, indeterminate_joints))}" if indeterminate_joints else ""
    )
    return f"{events}\n{largest_force_clause}{redundancy_clause}"
