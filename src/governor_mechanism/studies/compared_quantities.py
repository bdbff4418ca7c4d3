"""What a scene shows in a comparison: statics of a governor, or the reasons why not; readings and settling time of its run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from governor_mechanism.engines.initial_state import initial_state, rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import ControllingForce, compute_controlling_force
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import require_equilibrium_speed, validate_resistance
from governor_mechanism.statics.first_order_system import Mode
from governor_mechanism.statics.linearisation import linearise_scene, poses_at
from governor_mechanism.statics.speed_curve import SpeedCurve, compute_speed_curve

SETTLING_TOLERANCE = 0.02
"""Half-width of the settling band about the end, relative to the largest deviation from it."""

REST_SHARE = 0.2
"""Share of the run at its end in which the reading must stay in the band."""

MIN_CHANGE_RATIO = 1e-3
"""Smallest change of a reading, relative to its scale, that can be said to settle."""


def plain_names(run: Trajectory) -> dict[str, str]:
    """Return the readings of a run by their names without that of the part, where only one part has it."""
    names: dict[str, list[str]] = {}
    for name in run.readings:
        names.setdefault(name.rpartition(".")[2], []).append(name)
    return {plain if len(full) == 1 else name: name for plain, full in names.items() for name in full}


def find_shared_readings(runs: Sequence[Trajectory]) -> Mapping[str, tuple[str | None, ...]]:
    """Return the readings that at least two runs have, in one unit; those that most runs have first."""
    names = [plain_names(run) if len(run.times) else {} for run in runs]
    shared: dict[str, tuple[str | None, ...]] = {}
    for name in dict.fromkeys(name for one in names for name in one):
        full = tuple(one.get(name) for one in names)
        units = [run.units[one] for run, one in zip(runs, full, strict=True) if one is not None]
        if len(units) > 1 and len(set(units)) == 1:
            shared[name] = full
    return dict(sorted(shared.items(), key=lambda item: item[1].count(None)))


def leading_reading(run: Trajectory) -> str:
    """Return the name of the reading that shows a run best: of the part that turns with a spindle, or else of the first part."""
    part = max(run.scene.parts, key=lambda part: part.turns)
    name = part.mechanism.coordinate
    return name if name in run.readings else f"{part.name}.{name}"


def settling_time(run: Trajectory, name: str) -> float | None:
    """Return the time (s) from the last change of a given spindle speed, or the start, to a reading's rest; None without change or rest."""
    # It rests where it stays within SETTLING_TOLERANCE of its change about its last value.
    times, values = run.times, run.readings[name]
    if len(times) < 2:
        return None
    begin = max((_last_change(one.spindle) for one in run.scene.parts if isinstance(one.spindle, Spindle)), default=0.0)
    is_after = times >= begin
    if int(is_after.sum()) < 2:
        return None
    times, values = times[is_after], values[is_after]
    deviation = np.abs(values - values[-1])
    largest = float(deviation.max())
    outside = np.flatnonzero(deviation > SETTLING_TOLERANCE * largest)
    if largest <= MIN_CHANGE_RATIO * run.scales.get(name, 0.0) or not len(outside):
        return None
    last = int(outside[-1])
    if times[last] > times[-1] - REST_SHARE * (times[-1] - times[0]):
        return None
    # Between two reported times the deviation is taken for linear, so that the time changes smoothly with the dimensions.
    inside = (deviation[last] - SETTLING_TOLERANCE * largest) / (deviation[last] - deviation[last + 1])
    return float(times[last] + inside * (times[last + 1] - times[last]) - begin)


def _last_change(spindle: Spindle) -> float:
    """Return the time at which a given speed has changed for the last time, s; 0 for a constant speed."""
    changes = [time for time, before, after in zip(spindle.times[1:], spindle.speeds, spindle.speeds[1:], strict=False) if before != after]
    return float(changes[-1]) if changes else 0.0


_Result = TypeVar("_Result")


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorStatics:
    """Statics of the part of a scene that turns with a spindle, alone."""

    scene: Scene  # that part as a scene
    # last speed of the scene, or the first if nothing is in equilibrium at the last; of a free or geared
    # spindle the speed at which it starts, rad/s
    spindle_speed: float
    curve: SpeedCurve  # equilibrium speed over the travel, with the insensitivity band if a resistance is given
    # the equilibrium at that speed nearest to the end of the run, stable ones first; None if there is none
    equilibrium: Equilibrium | None
    mode: Mode | None  # the mode of small motions about it that decays most slowly; None if it cannot be linearised
    # controlling force over the travel with the working range; None if there is none, as without balls
    controlling_force: ControllingForce | None
    range_of: str  # what limits the working range: "values" that are given, "stops", "travel", or what the "run" covers
    at_equilibrium: ControllingForce | None  # controlling force at the equilibrium, with effort and power
    notes: tuple[str, ...]  # reasons why something is missing, one sentence each

    @property
    def is_beyond_stops(self) -> bool:
        """Whether the stops of the scene keep it from its equilibrium, so that it rests on one of them."""
        force = self.controlling_force
        if self.equilibrium is None or force is None or force.working_range is None or self.range_of != "stops":
            return False
        ends = force.working_range.coordinate
        return not float(ends.min()) <= self.equilibrium.coordinate <= float(ends.max())


@dataclass(frozen=True, kw_only=True)
class StaticsQuestion:
    """What is asked of each governor."""

    # resistance along the reading of the sleeve, N or N m, or text with a unit; None for none
    resistance: float | str | None = None
    against: str = "sleeve_lift"  # name of the reading of the sleeve
    # working range: two values of one reading; None for the stops of the scene, or else for what the run
    # covers
    between: Mapping[str, Sequence[float | str]] | None = None


def evaluate_statics(run: Trajectory, question: StaticsQuestion) -> GovernorStatics | str:
    """Return the statics of a scene, or the reason why it has none; raise MechanismError if the resistance is not valid."""
    notes: list[str] = []

    def attempt(function: Callable[[], _Result]) -> _Result | None:
        try:
            return function()
        except MechanismError as error:
            notes.append(error.problems[0])
            return None

    resistance, against = question.resistance, question.against
    try:
        alone = rotating_part_alone(run.scene)
        require_equilibrium_speed(alone)
    except MechanismError as error:
        return error.problems[0]
    if resistance is not None and against not in (reading.name for reading in alone.part.mechanism.readings):
        notes.append(f"no reading {against!r}, so that the resistance does not act")
        resistance = None
    if resistance is not None:
        validate_resistance(alone.part.mechanism, resistance, against)
    curve = attempt(lambda: compute_speed_curve(alone, resistance=resistance, against=against))
    if curve is None:
        return notes[-1]
    spindle = alone.spindle
    given = (spindle.start_speed or 0.0,) if isinstance(spindle, FreeSpindle) else spindle.speeds
    speed = given[-1]
    points = attempt(lambda: find_equilibria(alone, given[-1])) or ()
    if not points and given[0] != speed:
        speed = given[0]
        points = attempt(lambda: find_equilibria(alone, given[0])) or ()
    last = _last_value(run, alone.part.mechanism.coordinate)
    equilibrium = min(points, key=lambda one: (not one.stable, abs(one.coordinate - last)), default=None)
    force = attempt(lambda: compute_controlling_force(alone, resistance=resistance, against=against, between=question.between))
    covered, range_of = _covered_range(run, against), ""
    if force is not None and force.working_range is not None:
        range_of = force.working_range.limited_by
    elif force is not None and covered is not None:
        range_of = "run"
        force = attempt(lambda: compute_controlling_force(alone, resistance=resistance, against=against, between=covered)) or force
    at_equilibrium = mode = None
    if equilibrium is not None:
        place = equilibrium
        if force is not None:
            at_equilibrium = attempt(lambda: compute_controlling_force(alone, [place.coordinate], against=against))
        mode = attempt(lambda: _slowest_mode(alone, place, speed))
    return GovernorStatics(
        scene=alone,
        spindle_speed=speed,
        curve=curve,
        equilibrium=equilibrium,
        mode=mode,
        controlling_force=force,
        range_of=range_of,
        at_equilibrium=at_equilibrium,
        notes=tuple(dict.fromkeys(notes)),
    )


def _last_value(run: Trajectory, reading: str) -> float:
    """Return the last value of a reading of the turning part in a run, SI; 0 if there is none."""
    name = plain_names(run).get(reading)
    return float(run.readings[name][-1]) if name is not None and len(run.times) else 0.0


def _covered_range(run: Trajectory, reading: str) -> Mapping[str, Sequence[float]] | None:
    """Return the range of a reading that a run covers; None if it does not move."""
    name = plain_names(run).get(reading)
    if name is None or not len(run.times):
        return None
    low, high = float(run.readings[name].min()), float(run.readings[name].max())
    return {reading: (low, high)} if high - low > MIN_CHANGE_RATIO * run.scales.get(name, 0.0) else None


def _slowest_mode(scene: Scene, equilibrium: Equilibrium, speed: float) -> Mode | None:
    """Return the mode about an equilibrium that decays most slowly, apart from those of conserved quantities."""
    _, velocities = initial_state(scene)
    modes = linearise_scene(scene, poses_at(scene, equilibrium), velocities, speed).modes
    return next((mode for mode in modes if not mode.is_conserved), None)
