"""Choice of the readings in the overview of a run: a figure of all of them would be too long to be read."""

from collections.abc import Iterator, Mapping

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import READING_NOISE_RATIO
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.render.machines.registry import find_drawing_class
from governor_mechanism.render.shown_readings import ShownReading

MAX_OVERVIEW_READINGS = 12
"""Largest number of readings in an overview: six rows of panels, which fill a page."""
FEW_READINGS = 8
"""Number of readings up to which all are shown: four rows of panels, which are seen at a glance."""
MIN_HEADLINES = 6
"""Number of headline readings from which on they make an overview without others."""

_ENGINE_READINGS = ("shaft_speed", "gas_torque", "load_torque", "throttle_opening", "cut_off")
"""Readings of a governed engine that show how it is regulated, by plain name; the governor's own reading comes first."""


def choose_overview(run: Trajectory, readings: Mapping[str, ShownReading]) -> dict[str, ShownReading]:
    """Return all readings if they are at most FEW_READINGS, or else an overview of at most MAX_OVERVIEW_READINGS, in their order.

    It has the headline readings: those that show how a governed engine is regulated, then those that films show beside each machine, and
    the coordinates of the machines. Less than MIN_HEADLINES are filled up by the other readings in their order. Of equal readings, such as
    the travels of two pistons on one rod, it has the first.
    """
    if len(readings) <= FEW_READINGS:
        return dict(readings)
    headlines = [name for name in dict.fromkeys(_headline_readings(run)) if name in readings]
    chosen: list[str] = []
    for name in headlines if len(headlines) >= MIN_HEADLINES else dict.fromkeys((*headlines, *readings)):
        if len(chosen) < MAX_OVERVIEW_READINGS and not any(_are_equal(readings[name], readings[one]) for one in chosen):
            chosen.append(name)
    return {name: one for name, one in readings.items() if name in chosen}


def _headline_readings(run: Trajectory) -> Iterator[str]:
    """Yield names of readings, the most telling first; not every run has all of them."""
    parts = run.scene.parts
    prefixes = [f"{part.name}." if len(parts) > 1 else "" for part in parts]
    if governed := find_governed_engine(run.scene):
        yield governed.governor_reading
        yield from (f"{governed.engine.name}.{name}" for name in _ENGINE_READINGS)
    for part, prefix in zip(parts, prefixes, strict=True):
        yield from (prefix + name for name in find_drawing_class(part).panel_readings)
    yield from (f"{prefix}{part.mechanism.coordinate}" for part, prefix in zip(parts, prefixes, strict=True))


def _are_equal(one: ShownReading, other: ShownReading) -> bool:
    """Return whether two readings would give the same panel."""
    noise = READING_NOISE_RATIO * max(one.scale, other.scale, float(np.ptp(one.values)))
    return one.unit == other.unit and bool(np.abs(one.values - other.values).max() <= noise)
