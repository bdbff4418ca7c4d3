"""Valve gears compared: lead, cut-off and travel of the valve over the range of what reverses each gear."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slide_valve import SlideValve, prescribed_centre
from governor_mechanism.machines.stephenson_links import ANY_POINT, ARC_MIDDLE, CHORD_MIDDLE, HALF_WAY, LOWER_PIN
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import (
    CYLINDER_ENDS,
    PORT_EVENTS,
    find_port_timings,
    reverse_crank,
    valve_motion_of,
    valve_of,
)
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.sweep.parameters import parse_axes
from governor_mechanism.types import FloatArray
from governor_mechanism.units.text_table import short_repr


class ClosedFormEvent(NamedTuple):
    """A valve event in closed form: crank angles (rad) and strokes, exact and by Zeuner's law with infinitely long rods."""

    exact: float
    theory: float
    exact_stroke: float
    theory_stroke: float


def closed_form_event(scene: Scene, name: str) -> ClosedFormEvent:
    """Return a valve event of a slide valve scene in closed form."""
    dimensions = scene.part.dimensions
    eccentric = Eccentric.from_dimensions(dimensions)
    train = CrankTrain.from_dimensions(dimensions)
    angle_of = partial(event_angle, event=name, outside_lap=dimensions["outside_lap"], inside_lap=dimensions["inside_lap"])
    exact = angle_of(eccentric, centre=prescribed_centre(scene))
    theory = angle_of(replace(eccentric, rod=math.inf))
    end, ideal_train = name.rsplit(" ", 1)[0], replace(train, rod=math.inf)
    return ClosedFormEvent(exact, theory, _stroke_fraction(train, exact, end), _stroke_fraction(ideal_train, theory, end))


def _stroke_fraction(train: CrankTrain, angle: float, end: str) -> float:
    """Return the fraction of the stroke at a crank angle (rad), measured from one of the cylinder ends."""
    # The closed form counts from the outer dead centre, half a revolution later.
    fraction = float(travel_from_outer_dead_centre(train, crank_angle=angle + math.pi)) / (2 * train.crank)
    return fraction if end == "head end" else 1.0 - fraction


CLOSED_FORMS: dict[str, Callable[[Scene, str], ClosedFormEvent]] = {SlideValve.name: closed_form_event}
"""Function of a scene and the name of an event by machine, for machines whose events have a closed form."""


@dataclass(frozen=True, kw_only=True)
class ValveEvent:
    """One valve event: crank angles (rad, 0 to 2 pi), and strokes as fractions of the piston stroke from the event's own end."""

    name: str  # name of the event
    simulated: float  # crank angle by the mechanism, rad
    simulated_stroke: float = math.nan  # stroke by the mechanism; nan without a piston
    exact: float = math.nan  # crank angle by the closed form, rad; nan for a machine without one, as all that follow
    theory: float = math.nan  # crank angle by Zeuner's law with infinitely long rods, rad
    exact_stroke: float = math.nan  # stroke by the closed form
    theory_stroke: float = math.nan  # stroke by Zeuner's law

    @property
    def shift(self) -> float:
        """Delay against the theory (rad)."""
        return math.remainder(self.simulated - self.theory, math.tau)

    @property
    def has_theory(self) -> bool:
        """Whether the event has a closed form."""
        return not math.isnan(self.theory)

    @property
    def has_stroke(self) -> bool:
        """Whether the mechanism has a piston."""
        return not math.isnan(self.simulated_stroke)


@dataclass(frozen=True, kw_only=True)
class ValveTiming(Result):
    """The events of a valve, crank end first.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        The events; eight if every port opens once in a turn.
    leads
        Lead of crank end and head end, m: opening of the steam port at the dead centre.
    centre
        Centre of the valve's motion, m: its distance from the shaft where that is a dimension, else the reading of the valve there.
    travel
        Travel of the valve from one extreme to the other, m.
    largest_openings
        Largest opening of the steam ports of crank end and head end, m; negative for a port that never opens.
    statements
        A sentence on each port that does not open once in a turn.
    """

    title: str
    rows: tuple[ValveEvent, ...]
    leads: tuple[float, float]
    centre: float
    travel: float
    largest_openings: tuple[float, float]
    statements: tuple[str, ...] = ()

    __repr__ = short_repr

    hidden = ("rows",)
    derived = ("events=rows",)
    index = "name"
    columns = (
        Column("name", "event"),
        Column("simulated", "simulated", ".6f/deg", "rad"),
        Column("exact", "exact", ".6f/deg", "rad"),
        Column("theory", "theory", ".6f/deg", "rad"),
        Column("shift", "shift", "+.6f/deg", "rad"),
        Column("simulated_stroke", "stroke", ".6f"),
        Column("exact_stroke", "exact", ".6f"),
        Column("theory_stroke", "theory", ".6f"),
    )

    def __str__(self) -> str:
        """Return the timing as a table."""
        openings = ", ".join(
            f"{1e3 * length:.6g} mm at the {end}" if length > 0 else f"none at the {end}"
            for length, end in zip(self.largest_openings, CYLINDER_ENDS, strict=True)
        )
        leads = ", ".join(f"{1e3 * length:.6g} mm at the {end}" for length, end in zip(self.leads, CYLINDER_ENDS, strict=True))
        travel = f"travel {1e3 * self.travel:.6g} mm, largest steam openings {openings}"
        return "\n".join([self.title, *self._table_lines(), *self.statements, travel, f"lead {leads}"])

    def _table_lines(self) -> list[str]:
        if not self.rows:
            return []
        angles = "crank angles and shift" if self.rows[0].has_theory else "crank angles"
        strokes = "; strokes as fractions, from the event's own end" if self.rows[0].has_stroke else ""
        shown = [one for one in self.columns if isinstance(one.value_of(self.rows[0]), str) or math.isfinite(one.value_of(self.rows[0]))]
        return [format_columns(shown, self.rows), f"{angles} in deg from the crank end's dead centre{strokes}"]


def tabulate_valve_timing(
    scene: Scene,  # a scene of one part whose mechanism has a valve
) -> ValveTiming:
    """Return the valve events to about 1e-13 rad; MechanismError without a valve or a crank that turns fully."""
    motion, timings = valve_motion_of(scene), find_port_timings(scene)
    angles = {name: angle for timing in timings for name, angle in timing.events.items()}
    strokes = motion.stroke_fractions(np.array(list(angles.values())))
    closed_form = CLOSED_FORMS.get(scene.part.machine)
    rows = []
    for (name, angle), crank_end_stroke in zip(angles.items(), strokes.tolist(), strict=True):
        own_stroke = crank_end_stroke if name.startswith(CYLINDER_ENDS[0]) else 1.0 - crank_end_stroke
        columns = closed_form(scene, name)._asdict() if closed_form else {}
        rows.append(ValveEvent(name=name, simulated=angle, simulated_stroke=own_stroke, **columns))
    steam = [timing for timing in timings if timing.port == "steam"]
    return ValveTiming(
        title=scene.title,
        rows=tuple(rows),
        leads=motion.leads,
        centre=scene.part.dimensions.get("centre", motion.centre),
        travel=motion.travel,
        largest_openings=(steam[0].largest_opening, steam[1].largest_opening),
        statements=tuple(timing.statement for timing in timings if timing.statement),
    )


SHIPPED_GEARS = ("stephenson_arc_middle", "gooch", "allan", "walschaerts", "joy")
"""Names of the shipped scenes that are compared by default."""

TABLE_POSITIONS = (1.0, 0.5, 0.0, -0.5, -1.0)
"""Positions of the reversing gear in tables."""

DEFAULT_COUNT = 41
"""Number of positions of the reversing gear; odd, so that mid gear is one of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ValveGear(Recorded):
    """A valve gear in n positions from full forward to full back gear. In back gear the crank turns the other way."""

    title: str  # title of the scene
    scenes: tuple[Scene, ...]  # the scene in each position
    timings: tuple[ValveTiming, ...]  # its valve events
    positions: FloatArray  # positions of the reversing gear, from 1 in full forward to -1 in full back gear; shape (n,)
    leads: FloatArray  # leads of crank end and head end, m; shape (n, 2)
    # strokes at cut-off of crank end and head end, as fractions; nan where a port does not open once in a
    # turn; shape (n, 2)
    cut_offs: FloatArray
    travel: FloatArray  # travel of the valve, m; shape (n,)

    @property
    def name(self) -> str:
        """Title up to its first colon or comma."""
        return self.title.partition(":")[0].partition(",")[0]

    record = ("title", "positions", "leads", "travel", "cut_offs")

    def format_events(self) -> str:
        """Return a table of the valve events in some positions: crank angles, and strokes where there is a piston."""
        places = [self.nearest(position) for position in TABLE_POSITIONS]
        cells = [self._event_column(k) for k in places]
        gears = [Column("", f"gear {self.positions[k]:+.2f}", one.__getitem__, side="r") for k, one in zip(places, cells, strict=True)]
        footer = "crank angles in deg in the direction of rotation, which reverses with the gear; strokes from the event's own end"
        return "\n".join([self.title, format_columns((Column("", "event", str), *gears), cells[0]), footer])

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


def _curve(name: str, attribute: str, end: int | None = None) -> Column:
    """Return the column of a curve of all gears, one after the other; of one that both ends of the cylinder have, at one of them."""
    place = ... if end is None else (..., end)
    return Column(name, value=lambda study: np.concatenate([getattr(gear, attribute)[place] for gear in study.gears]))


@dataclass(frozen=True, kw_only=True)
class ValveGears(Result):
    """Valve gears compared.

    Attributes
    ----------
    gears
        The gears.
    """

    gears: tuple[ValveGear, ...]

    __repr__ = short_repr

    figure = "render.figures.plates.reversed_gear.valve_gears_figure"
    data_files = ("json",)
    columns = (
        Column("gear", value=lambda study: [gear.name for gear in study.gears for _ in gear.positions]),
        _curve("position", "positions"),
        *(_curve(f"{end}_{name}".replace(" ", "_"), f"{name}s", k) for name in ("lead", "cut_off") for k, end in enumerate(CYLINDER_ENDS)),
        _curve("travel", "travel"),
    )

    def __str__(self) -> str:
        """Return a table of every gear in full forward, half forward, mid and full back gear."""
        return format_columns(POSITION_COLUMNS, [row for gear in self.gears for row in _table_rows(gear)])


@dataclass(frozen=True)
class GearPosition:
    """A row of the printed table: values of both ends of the cylinder, m; a cut-off is nan where a port does not open once."""

    gear: str
    position: float
    leads: list[float]
    cut_offs: list[float]
    travel: float


POSITION_COLUMNS = (
    Column("gear", "gear"),
    Column("position", "position", "+.2f"),
    Column("leads", "lead of crank / head end, mm", lambda row: " / ".join(f"{1e3 * lead:.3f}" for lead in row.leads), side="r"),
    Column("cut_offs", "cut-off, %", lambda row: " / ".join(map(_format_cut_off, row.cut_offs)), side="r"),
    Column("travel", "travel, mm", ".2f/mm"),
)


def _format_cut_off(cut_off: float) -> str:
    """Return a cut-off in per cent."""
    return "none" if math.isnan(cut_off) else f"{100 * cut_off:.2f}"


def _table_rows(gear: ValveGear) -> Iterator[GearPosition]:
    """Yield the rows of a gear in the table; the first has its name."""
    for position in TABLE_POSITIONS:
        k = gear.nearest(position)
        ends = gear.leads[k].tolist(), gear.cut_offs[k].tolist()
        yield GearPosition(gear.name if position == TABLE_POSITIONS[0] else "", float(gear.positions[k]), *ends, float(gear.travel[k]))


def compare_valve_gears(
    scenes: Sequence[Scene],  # scenes of one part, from files, whose valves name their reverser
    count: int = DEFAULT_COUNT,
) -> ValveGears:
    """Return leads, cut-offs and travel of valve gears over the range of what reverses them."""
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


PAPER_SUSPENSIONS = {ARC_MIDDLE: "Fig. 2", CHORD_MIDDLE: "Fig. 3", LOWER_PIN: "Fig. 4", HALF_WAY: "Fig. 5"}
"""Suspensions of the paper with its figures, in their order."""

GEARS: FloatArray = np.linspace(1.0, -1.0, 9)
"""Positions of the reversing lever, from full forward to full back gear."""

N_ANGLES = 181
"""Number of crank angles of a closed turn."""


@dataclass(frozen=True, kw_only=True)
class DiePaths:
    """Paths of the die in the link for one suspension, in n gears at m crank angles of a turn."""

    suspension: str  # point of the link from which it hangs
    gears: FloatArray  # positions of the reversing lever, from 1 to -1; shape (n,)
    displacements: FloatArray  # displacement of the valve, m; shape (n, m)
    offsets: FloatArray  # position of the die along the arc, from its middle toward the upper pin, m; shape (n, m)
    half_arc: float  # half the length of the arc between the rod pins, m

    @property
    def slips(self) -> FloatArray:
        """Range of the die's position over a turn in each gear, m; shape (n,)."""
        slips: FloatArray = np.ptp(self.offsets, axis=1)
        return slips


def trace_die_paths(
    scene: Scene,
    gears: FloatArray = GEARS,  # positions of the reversing lever; shape (n,)
) -> tuple[DiePaths, ...]:
    """Return the paths of the die for the four suspensions of the paper, with the other dimensions of a scene.

    A suspension at any other point of the scene's own comes last.

    Result: paths for each suspension; one at which the link cannot be assembled is left out. Raises
    MechanismError if the scene is not one of a link motion from a file.
    """
    if scene.part.machine != "stephenson" or not scene.document:
        raise MechanismError(f"die paths need a scene file with machine 'stephenson'; this scene has machine {scene.part.machine!r}")
    own = scene.document["dimensions"].get("suspension", ARC_MIDDLE)
    suspensions = [*PAPER_SUSPENSIONS, *([ANY_POINT] if own == ANY_POINT else [])]
    traced = (_trace_suspension(scene, suspension, gears) for suspension in suspensions)
    return tuple(paths for paths in traced if paths is not None)


def _trace_suspension(scene: Scene, suspension: str, gears: FloatArray) -> DiePaths | None:
    """Return the paths for one suspension, or None if the link cannot be assembled with it."""
    angles = np.linspace(0.0, math.tau, N_ANGLES)
    try:
        turns = [solve_kinematics(_with_suspension(scene, suspension, gear), "crank_angle", angles).readings for gear in gears.tolist()]
    except MechanismError:
        return None
    radius, half_link = (scene.part.dimensions[name] for name in ("link_radius", "half_link"))
    return DiePaths(
        suspension=suspension,
        gears=gears,
        displacements=np.array([turn["valve_displacement"] for turn in turns]),
        offsets=np.array([turn["die_slip"] for turn in turns]),
        half_arc=radius * math.asin(half_link / radius),
    )


def _with_suspension(scene: Scene, suspension: str, gear: float) -> Scene:
    """Return the scene with another suspension, and with its lever at rest."""
    dimensions = scene.document["dimensions"]
    kept = {name: value for name, value in dimensions.items() if suspension == ANY_POINT or not name.startswith("suspension_")}
    return parse_scene_with(scene.document, [("dimensions", {**kept, "suspension": suspension, "reverser": gear})])
