"""What a run shows for a comparison: the readings that all runs share, and the settling time."""

from collections.abc import Mapping, Sequence

import numpy as np

from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.trajectory import Trajectory

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
    """Return the readings that at least two runs have, in one unit; those that most runs have first.

    Result: by plain name, the full name in each run; None where a run has none.
    """
    names = [plain_names(run) if len(run.times) else {} for run in runs]
    shared: dict[str, tuple[str | None, ...]] = {}
    for name in dict.fromkeys(name for one in names for name in one):
        full = tuple(one.get(name) for one in names)
        units = [run.units[one] for run, one in zip(runs, full, strict=True) if one is not None]
        if len(units) > 1 and len(set(units)) == 1:
            shared[name] = full
    return dict(sorted(shared.items(), key=lambda item: item[1].count(None)))


def leading_reading(run: Trajectory) -> str:
    """Return the name of the reading that shows a run best: of the part that turns with a spindle, or else of the first part.

    Result: full name of its leading coordinate.
    """
    part = max(run.scene.parts, key=lambda part: part.turns)
    name = part.mechanism.coordinate
    return name if name in run.readings else f"{part.name}.{name}"


def settling_time(run: Trajectory, name: str) -> float | None:
    """Return how long a reading takes to come to rest after the last change of a given spindle speed, or from the start.

    Result: time from which the reading stays within SETTLING_TOLERANCE of its change about its last value, s;
    None if it does not change, or is not at rest at the end.
    """
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
    return float(times[last + 1] - begin)


def _last_change(spindle: Spindle) -> float:
    """Return the time at which a given speed has changed for the last time, s; 0 for a constant speed."""
    changes = [time for time, before, after in zip(spindle.times[1:], spindle.speeds, spindle.speeds[1:], strict=False) if before != after]
    return float(changes[-1]) if changes else 0.0
