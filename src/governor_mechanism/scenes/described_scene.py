"""A scene in words: the values that describe it, as text and as JSON."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from governor_mechanism.scenes.described_values import NEAT_UNITS, DescribedValue
from governor_mechanism.units.text_table import format_table


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedItem:
    """Something that a scene lists: an effect, a force element, a coupling, an event.

    Attributes
    ----------
    name
        Name in messages and results.
    kind
        What it is, as "gear".
    text
        The rest in words.
    values
        Its numbers, if it has any.
    """

    name: str
    kind: str
    text: str
    values: tuple[DescribedValue, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return name, kind, text and values."""
        values = {"values": [value.as_json() for value in self.values]} if self.values else {}
        return {"name": self.name, "kind": self.kind, "text": self.text, **values}


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedPart:
    """One part of a scene in words.

    Attributes
    ----------
    name
        Name of the part.
    machine
        Name of the machine in scene files.
    plane
        "turning" or "fixed".
    spindle
        How its spindle turns, in words; empty in a fixed plane.
    dimensions
        Dimensions in SI.
    effects
        Effects.
    bodies, joints
        Names of the bodies, and of the joints of the mechanism.
    coordinate
        Name of the leading coordinate.
    law
        The law that it proves, in words; empty without one.
    """

    name: str
    machine: str
    plane: str
    spindle: str
    dimensions: tuple[DescribedValue, ...]
    effects: tuple[DescribedItem, ...]
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    coordinate: str
    law: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return all fields by name."""
        listed = {"dimensions": [one.as_json() for one in self.dimensions], "effects": [one.as_json() for one in self.effects]}
        return dataclasses.asdict(self) | listed


@dataclasses.dataclass(frozen=True, kw_only=True)
class EngineAnswer:
    """What an engine says about a scene.

    Attributes
    ----------
    name
        Name of the engine.
    supported
        Whether it can run the scene.
    reason
        Why not, or why "auto" takes it; empty for the others.
    is_chosen
        Whether "auto" takes it.
    """

    name: str
    supported: bool
    reason: str
    is_chosen: bool

    def __str__(self) -> str:
        if self.is_chosen:
            return f'runs it with engine = "auto"{f": {self.reason}" if self.reason else ""}'
        return "can run it" if self.supported else f"refuses: {self.reason}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class SceneDescription:
    """A scene in words; it prints as text.

    Attributes
    ----------
    title
        Title of the scene.
    source
        Name of the scene file; empty without one.
    parts
        Its parts.
    force_elements
        Springs, dampers, forces, torques and gas, with what they depend on.
    couplings
        Couplings of parts, and the load.
    events
        Crossings that the events of a run name.
    readings
        Readings of a run with their units; the value is that at the start, or None where it is not known before a run.
    degrees_of_freedom
        Degrees of freedom that joints and drivers leave.
    drivers
        Number of drivers.
    run
        Settings of a run.
    engines
        What each engine says.
    problem
        Why the scene has no start; empty if it has one.
    """

    title: str
    source: str
    parts: tuple[DescribedPart, ...]
    force_elements: tuple[DescribedItem, ...]
    couplings: tuple[DescribedItem, ...]
    events: tuple[DescribedItem, ...]
    readings: tuple[DescribedValue, ...]
    degrees_of_freedom: int
    drivers: int
    run: tuple[DescribedValue, ...]
    engines: tuple[EngineAnswer, ...]
    problem: str = ""

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the text that is printed."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    def __repr__(self) -> str:
        """Return the text, which an interactive session shows."""
        return str(self)

    def __str__(self) -> str:
        drivers = f", {self.drivers} driver{'s' * (self.drivers > 1)}" if self.drivers else ""
        lines = [f"{self.title}{f' ({self.source})' if self.source else ''}"]
        for part in self.parts:
            lines += _part_lines(part, has_name=len(self.parts) > 1)
        start = "value at the start" if not self.problem else ""
        lines += _section("Force elements", [(one.name, one.kind, one.text) for one in self.force_elements])
        lines += _section("Couplings and loads", [(one.name, one.kind, one.text) for one in self.couplings])
        lines += _section("Events", [(one.name, one.text) for one in self.events])
        readings = [(one.name, NEAT_UNITS.get(one.unit, one.unit) or "-", "" if one.value is None else one.text) for one in self.readings]
        lines += _section(f"Readings, SI unit{f', {start}' if start else ''}", readings)
        lines += ["", f"Degrees of freedom: {self.degrees_of_freedom}{drivers}"]
        lines += _section("Run", [(one.name, one.text) for one in self.run])
        lines += _section("Engines", [(one.name, str(one)) for one in self.engines])
        return "\n".join([*lines, *(["", f"No run is possible: {self.problem}"] if self.problem else [])])

    def as_json(self) -> dict[str, Any]:
        """Return the description as plain values.

        Returns
        -------
        dict
            The fields by name, values in SI.
        """
        lists = ("parts", "force_elements", "couplings", "events", "readings", "run")
        rows = {name: [one.as_json() for one in getattr(self, name)] for name in lists}
        return dataclasses.asdict(self) | rows


def _part_lines(part: DescribedPart, *, has_name: bool) -> list[str]:
    """Return the lines of a part: machine, spindle, dimensions, effects, bodies and joints."""
    name = f"Part {part.name}: " if has_name else ""
    lines = [
        "",
        f"{name}{'machine' if name else 'Machine'} {part.machine}, {part.spindle or 'in a fixed plane'}; coordinate {part.coordinate}",
    ]
    lines += _section("Dimensions", [(one.name, one.text, one.meaning) for one in part.dimensions])
    lines += _section("Effects", [(one.name, one.text) for one in part.effects]) or ["", "Effects: none"]
    lines += ["", f"Law: {part.law}"] if part.law else []
    return [*lines, "", f"Bodies: {'; '.join(part.bodies)}", f"Joints: {'; '.join(part.joints) or 'none'}"]


def _section(heading: str, rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return a heading with a table under it; nothing without rows."""
    return ["", heading, *(f"  {line}" for line in format_table([], rows).splitlines())] if rows else []
