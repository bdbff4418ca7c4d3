"""What the commands say: a run in a few lines, positions of rest and the speeds at which a governor jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from governor_mechanism.cli.console import number
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.equilibrium_speed import spoken_coordinate
from governor_mechanism.statics.speed_curve import SpeedCurve, StandingBand
from governor_mechanism.units.quantities import spoken


def describe_rests(
    scene: Scene, rests: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Sequence[StandingBand | str] = ()
) -> list[str]:
    """A line for each position of rest, with the standing band there (or why there is none), and for each jump."""
    lines = []
    for k, rest in enumerate(rests):
        lines.append(f"{scene.part.mechanism.coordinate.replace('_', ' ')} {_where(scene, rest)}: {_how(scene, rest)}")
        lines += [f"  {_held(scene, band)}" for band in bands[k : k + 1]]
    folds = curve.folds if curve else ()
    return lines + [f"jumps at {spoken_coordinate(scene, at)}, {spoken(speed, 'rad/s')}" for at, speed in folds]


def rests_as_json(
    rests: Sequence[Equilibrium], curve: SpeedCurve | None, bands: Sequence[StandingBand | str] = ()
) -> dict[str, Any]:
    """The same as values in SI; where there is no standing band, the sentence that says why."""
    kept = ("coordinate", "extent", "stable", "stiffness", "frequency", "growth_rate", "uncertainty")
    found = []
    for k, rest in enumerate(rests):
        row = {key: getattr(rest, key) for key in kept}
        row |= {"sensitivity": number(rest.sensitivity), "readings": dict(rest.readings)}
        for band in bands[k : k + 1]:
            names = ("falling_speed", "rising_speed", "insensitivity")
            values = {} if isinstance(band, str) else {name: number(float(getattr(band, name)[0])) for name in names}
            row["standing_band"] = values or band
        found.append(row)
    if curve is None:
        return {"equilibria": found}
    return {
        "equilibria": found,
        "folds": [{"coordinate": value, "speed": at} for value, at in curve.folds],
        "poles": list(curve.poles),
        "low_end": curve.low_end,
        "high_end": curve.high_end,
    }


def _held(scene: Scene, band: StandingBand | str) -> str:
    if isinstance(band, str):
        return band
    unit = "N m" if scene.part.mechanism.reading(band.against).quantity == "angle" else "N"
    slow, fast = (spoken(float(speed[0]), "rad/s") for speed in (band.falling_speed, band.rising_speed))
    held = f"{band.resistance:g} {unit} at {band.against} hold it from {slow} to {fast}"
    if math.isinf(band.insensitivity[0]):
        return f"{held}; without resistance it rests on a spindle that stands"
    return f"{held}: insensitivity {band.insensitivity[0]:.6g}"


def _where(scene: Scene, rest: Equilibrium) -> str:
    if rest.astatic:
        return " to ".join(spoken_coordinate(scene, end) for end in rest.extent)
    return spoken_coordinate(scene, rest.coordinate)


NEARLY_ASTATIC = 10.0
"""rad, or machine sizes, for the speed changed by its whole: softer than this the position says little."""


def _how(scene: Scene, rest: Equilibrium) -> str:
    if rest.astatic:
        return "astatic, it rests anywhere between"
    held = (
        f"stable, swings at {rest.frequency:.6g} rad/s"
        if rest.stable
        else f"unstable, grows at {rest.growth_rate:.6g} /s"
    )
    if not rest.sensitivity:
        return f"{held}; stiffness {rest.stiffness:.6g}"
    moves = f"1 % of speed moves it {spoken_coordinate(scene, 0.01 * rest.sensitivity)}"
    mechanism = scene.part.mechanism
    unit = 1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.size
    soft = "nearly astatic, " if rest.sensitivity > NEARLY_ASTATIC * unit else ""
    return f"{held}; stiffness {rest.stiffness:.6g}; {soft}{moves}"


def describe(result: Trajectory) -> str:
    """A run in a few lines: how it ended, how accurate, where it is, what it cost."""
    cost = result.cost
    asked = result.settings["asked_accuracy"]
    estimate = result.error_estimate
    accurate = "" if estimate is None else f"accurate to {estimate:.1g} (asked {asked:.1g}); "
    final = ", ".join(
        f"{name.replace('_', ' ')} {spoken(values[-1], result.units[name], '.4f')}"
        for name, values in result.readings.items()
        if len(values)
    )
    gap = result.joint_gap.max(initial=0.0)
    laws = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    built = f" beside {cost.building:.1g} s for its tables" if cost.building else ""
    return "\n".join(
        [
            result.scene.title,
            result.message,
            *result.notes,
            f"{accurate}joints closed to {gap:.1e} m, energy drift {result.energy.drift:.1e}",
            f"at {result.times[-1] if len(result.times) else 0:g} s: {final}",
            f"{_mobility(result)}; {_passed(result)}",
            *_losses(result),
            f"engine {cost.engine} ({cost.reason}): {cost.runs} runs, {cost.steps:,} steps, simulated in "
            f"{cost.wall_time:.2g} s{built}{f', {cost.method}' if cost.method else ''}",
            f"law evaluations: {laws or 'none'}",
        ]
    )


def _losses(result: Trajectory) -> list[str]:
    """What friction, brakes and stops have taken, and the samples that events leave in doubt, if there are any."""
    lost = float(result.energy.dissipated[-1]) if len(result.times) else 0.0
    told = [f"friction, brakes and stops took {lost:.4g} J"] * (lost > 0.0)
    return told + [f"{result.excluded} samples stand too near an event to be promised"] * (result.excluded > 0)


def _mobility(result: Trajectory) -> str:
    joints = [joint for part in result.scene.parts for joint in part.mechanism.joints]
    drives = sum(isinstance(joint, DrivenTurn | DrivenSlide) for joint in joints)
    return f"mobility {result.mobility}" + (f" beside {drives} driven" if drives else "")


EVENTS = 3
"""So many are told one by one."""


def _passed(result: Trajectory) -> str:
    """What the motion passed, and the joint that carried most."""
    told = [str(event) for event in result.events[:EVENTS]]
    more = len(result.events) - len(told)
    events = "; ".join(told + [f"and {more} more events"] * (more > 0)) or "no dead centre or change point passed"
    forces = {name: reaction.size for name, reaction in result.reactions.items()}
    largest = max(forces, key=lambda name: forces[name].max(initial=0.0), default=None)
    if largest is None or not len(result.times):
        return events
    at = int(forces[largest].argmax())
    loose = [name for name, reaction in result.reactions.items() if not reaction.determined.all()]
    carried = f"largest joint force {forces[largest][at]:.4g} N in {largest!r} at {result.times[at]:.4g} s"
    redundant = f"; not settled by rigid bodies: the forces of {', '.join(map(repr, loose))}" if loose else ""
    return f"{events}\n{carried}{redundant}"
