"""Valve gears compared: lead, cut-off and travel of the valve over the range of what reverses each gear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import finite_or_none
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.files.table import make_data_frame
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, PORT_EVENTS, reverse_crank, valve_of
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.sweep.parameters import parse_axes
from governor_mechanism.studies.valve_timing import ValveTiming, tabulate_valve_timing
from governor_mechanism.types import DataFrame, FloatArray
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

SHIPPED_GEARS = ("stephenson_arc_middle", "gooch", "allan", "walschaerts", "joy")
"""Names of the shipped scenes that are compared by default."""

TABLE_POSITIONS = (1.0, 0.5, 0.0, -0.5, -1.0)
"""Positions of the reversing gear in tables."""

DEFAULT_COUNT = 41
"""Number of positions of the reversing gear; odd, so that mid gear is one of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ValveGear:
    """A valve gear in n positions from full forward to full back gear. In back gear the crank turns the other way.

    Attributes
    ----------
    title
        Title of the scene.
    scenes
        The scene in each position.
    timings
        Its valve events.
    positions
        Positions of the reversing gear, from 1 in full forward to -1 in full back gear; shape (n,).
    leads
        Leads of crank end and head end, m; shape (n, 2).
    cut_offs
        Strokes at cut-off of crank end and head end, as fractions; nan where a port does not open once in a turn; shape (n, 2).
    travel
        Travel of the valve, m; shape (n,).
    """

    title: str
    scenes: tuple[Scene, ...]
    timings: tuple[ValveTiming, ...]
    positions: FloatArray
    leads: FloatArray
    cut_offs: FloatArray
    travel: FloatArray

    @property
    def name(self) -> str:
        """Title up to its first colon or comma."""
        return self.title.partition(":")[0].partition(",")[0]

    def as_json(self) -> dict[str, Any]:
        """Return the curves as plain values in SI, with None for a cut-off that there is not."""
        cut_offs = [list(map(finite_or_none, pair)) for pair in self.cut_offs.tolist()]
        curves = {"positions": self.positions.tolist(), "leads": self.leads.tolist(), "travel": self.travel.tolist()}
        return {"title": self.title, **curves, "cut_offs": cut_offs}

    def format_events(self) -> str:
        """Return a table of the valve events in some positions: crank angles, and strokes where there is a piston."""
        columns = [self._event_column(self.nearest(position)) for position in TABLE_POSITIONS]
        header = ("event", *(f"gear {self.positions[self.nearest(position)]:+.2f}" for position in TABLE_POSITIONS))
        rows = [(name, *(column[name] for column in columns)) for name in columns[0]]
        footer = "crank angles in deg in the direction of rotation, which reverses with the gear; strokes from the event's own end"
        return "\n".join([self.title, format_table(header, rows, "lr"), footer])

    def nearest(self, position: float) -> int:
        """Return the index of the position nearest to one."""
        return int(np.argmin(np.abs(self.positions - position)))

    def _event_column(self, k: int) -> dict[str, str]:
        """Return the cells of a position by the names of their rows."""
        timing = self.timings[k]
        events = {row.name: row for row in timing.rows}
        cells = {}
        for name in (f"{end} {event}" for end in CYLINDER_ENDS for events_of_port in PORT_EVENTS.values() for event in events_of_port):
            event = events.get(name)
            stroke = f" {100 * event.simulated_stroke:5.2f} %" if event and event.has_stroke else ""
            cells[name] = f"{math.degrees(event.simulated):.3f}{stroke}" if event else "none"
        leads = zip(CYLINDER_ENDS, timing.leads, strict=True)
        return cells | {f"lead at the {end}, mm": f"{1e3 * lead:.3f}" for end, lead in leads} | {"travel, mm": f"{1e3 * timing.travel:.2f}"}


@dataclass(frozen=True, kw_only=True)
class ValveGears(PrintedResult):
    """Valve gears compared.

    Attributes
    ----------
    gears
        The gears.
    """

    gears: tuple[ValveGear, ...]

    __repr__ = short_repr

    def __str__(self) -> str:
        """Return a table of every gear in full forward, half forward, mid and full back gear."""
        header = ("gear", "position", "lead, mm", "cut-off, %", "travel, mm")
        return format_table(header, [row for gear in self.gears for row in _rows(gear)], "lr")

    def as_json(self) -> dict[str, Any]:
        """Return all curves as plain values in SI."""
        return {"gears": [gear.as_json() for gear in self.gears]}

    def to_dataframe(self) -> DataFrame:
        """Return a table of pandas with a row for each position of each gear: leads and travel, m, and cut-offs of both ends.

        Returns
        -------
        pandas.DataFrame
            The table, SI; NaN for a cut-off that there is not.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        curves = ("positions", "leads", "cut_offs", "travel")
        joined = {name: np.concatenate([getattr(gear, name) for gear in self.gears]) for name in curves}
        columns: dict[str, Any] = {"gear": [gear.name for gear in self.gears for _ in gear.positions], "position": joined["positions"]}
        for name, both_ends in (("lead", joined["leads"]), ("cut_off", joined["cut_offs"])):
            columns |= {f"{end}_{name}".replace(" ", "_"): both_ends[:, k] for k, end in enumerate(CYLINDER_ENDS)}
        return make_data_frame(columns | {"travel": joined["travel"]})


def _rows(gear: ValveGear) -> list[tuple[str, ...]]:
    """Return the rows of a gear in the table: mean values of both ends in some positions."""
    rows = list[tuple[str, ...]]()
    for position in TABLE_POSITIONS:
        k = gear.nearest(position)
        lead, cut_off = 1e3 * gear.leads[k].mean(), 100 * gear.cut_offs[k].mean()
        cells = (f"{gear.positions[k]:+.2f}", f"{lead:.3f}", "none" if np.isnan(cut_off) else f"{cut_off:.2f}")
        rows.append(("" if rows else gear.name, *cells, f"{1e3 * gear.travel[k]:.2f}"))
    return rows


def compare_valve_gears(
    scenes: Sequence[Scene],  # scenes of one part, from files, whose valves name their reverser
    count: int = DEFAULT_COUNT,
) -> ValveGears:
    """Return leads, cut-offs and travel of valve gears over the range of what reverses them.

    Raises MechanismError if a valve has no reverser, or if a gear cannot be assembled.
    """
    return ValveGears(gears=tuple(_follow_gear(scene, count) for scene in scenes))


def _follow_gear(scene: Scene, count: int) -> ValveGear:
    reverser = valve_of(scene).reverser
    if reverser is None:
        hint = 'write reverser = { key = "...", forward = ..., back = ... } in [valve]'
        raise MechanismError(f"{scene.title}: the valve names nothing that reverses it; {hint}")
    if not scene.document:
        raise MechanismError(f"{scene.title}: a gear is reversed by a key of its scene file, and this scene has none")
    (axis,) = parse_axes(scene.document, [f"{reverser.key}={reverser.forward}:{reverser.back}:{count}"])
    positions = np.linspace(1.0, -1.0, count)
    in_gear = [parse_scene_with(scene.document, [(axis.key, value)]) for value in axis.document_values]
    turning = [reverse_crank(one) if position < 0 else one for one, position in zip(in_gear, positions, strict=True)]
    timings = [tabulate_valve_timing(one) for one in turning]
    return ValveGear(
        title=scene.title,
        scenes=tuple(turning),
        timings=tuple(timings),
        positions=positions,
        leads=np.array([timing.leads for timing in timings]),
        cut_offs=np.array([_cut_offs(timing) for timing in timings]),
        travel=np.array([timing.travel for timing in timings]),
    )


def _cut_offs(timing: ValveTiming) -> list[float]:
    strokes = {event.name: event.simulated_stroke for event in timing.rows}
    return [strokes.get(f"{end} cut-off", np.nan) for end in CYLINDER_ENDS]
