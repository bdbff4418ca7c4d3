"""Valve events of any mechanism with a slide valve; those of a valve that an eccentric drives also in closed form."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.machines.slide_valve import SlideValve, prescribed_centre
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, find_port_timings, valve_motion_of
from governor_mechanism.units.short_repr import short_repr


class ClosedFormEvent(NamedTuple):
    """A valve event in closed form: crank angles (rad) and strokes, exact and by Zeuner's law with infinitely long rods."""

    exact: float
    theory: float
    exact_stroke: float
    theory_stroke: float


def closed_form_event(scene: Scene, name: str) -> ClosedFormEvent:
    """Return a valve event of a slide valve scene in closed form.

    Result: crank angles and strokes, the fractions of the piston stroke from the event's own end.
    """
    dimensions = scene.part.dimensions
    eccentric, train = Eccentric.from_dimensions(dimensions), CrankTrain.from_dimensions(dimensions)
    angle_of = partial(event_angle, event=name, outside_lap=dimensions["outside_lap"], inside_lap=dimensions["inside_lap"])
    exact, theory = angle_of(eccentric, centre=prescribed_centre(scene)), angle_of(replace(eccentric, rod=math.inf))
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
    """One valve event: crank angles (rad, 0 to 2 pi), and strokes as fractions of the piston stroke from the event's own end.

    Attributes
    ----------
    name
        Name of the event.
    simulated
        Crank angle by the mechanism, rad.
    simulated_stroke
        Stroke by the mechanism; nan without a piston.
    exact
        Crank angle by the closed form, rad; nan for a machine without one, as all that follow.
    theory
        Crank angle by Zeuner's law with infinitely long rods, rad.
    exact_stroke
        Stroke by the closed form.
    theory_stroke
        Stroke by Zeuner's law.
    """

    name: str
    simulated: float
    simulated_stroke: float = math.nan
    exact: float = math.nan
    theory: float = math.nan
    exact_stroke: float = math.nan
    theory_stroke: float = math.nan

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
        Column("simulated", "simulated", ".6f/deg"),
        Column("exact", "exact", ".6f/deg"),
        Column("theory", "theory", ".6f/deg"),
        Column("shift", "shift", "+.6f/deg"),
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
    """Return the valve events of a scene, to about 1e-13 rad.

    It raises MechanismError for a scene without a valve or a crank that turns fully.
    """
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
