"""Modes of loads: which segment of a table of a reading holds, and which gears have broken."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.forces.forced_outputs import forced_output_names
from governor_mechanism.mechanics.dynamics.forces.loads import reading_tables_of
from governor_mechanism.model.scene import Scene


class InputModes:
    """Tables of readings and breaking gears of a scene.

    Parameters
    ----------
    scene
        The scene.
    time_scale
        Its characteristic time, s.
    first_index
        Index of the first table among contacts, one-sided springs and tables.
    """

    def __init__(self, scene: Scene, time_scale: float, first_index: int) -> None:
        self._tables, self._first_index, self._breaking_gears = reading_tables_of(scene), first_index, scene.system.breaking_gears
        names, outputs = forced_output_names(scene), [(table.source, table.is_rate) for table in self._tables]
        self._outputs = [(names.index(name), is_rate) for name, is_rate in outputs]
        scales = [scene.mechanism.output_scale(name) / (time_scale if is_rate else 1.0) for name, is_rate in outputs]
        self._tolerances = [CONTACT_TOLERANCE * scale for scale in scales]

    @property
    def is_fixed(self) -> bool:
        """Whether there is nothing to update."""
        return not (self._tables or self._breaking_gears)

    def update(
        self,
        mode: ContactMode,
        time: float,  # time, s
        values: Sequence[float],  # values of the outputs; shape (outputs,)
        rates: Sequence[float],  # their rates; shape (outputs,)
        triggered: Collection[int],  # indices of the contacts, springs and tables whose events occur now
    ) -> ContactMode:
        """Return a mode with the segments at a state, and with the gears that have broken."""
        segments = [self._segment(k, mode.segments[k], values, rates, self._first_index + k in triggered) for k in range(len(self._tables))]
        broken = tuple(name for name, end in self._breaking_gears.items() if time >= end)
        return replace(mode, segments=tuple(segments), broken=broken)

    def _segment(self, k: int, current: int, values: Sequence[float], rates: Sequence[float], is_triggered: bool) -> int:
        """Return the segment of a table; at a kink it is the one that the motion enters."""
        index, is_rate = self._outputs[k]
        positions, value = self._tables[k].positions, rates[index] if is_rate else values[index]
        kinks = [i for i, position in enumerate(positions) if abs(value - position) <= self._tolerances[k]]
        if not kinks:
            return sum(value > position for position in positions)
        if is_triggered:
            return kinks[0] + (current <= kinks[0])
        if is_rate:
            return current if current - kinks[0] in (0, 1) else kinks[0]
        return kinks[0] + (rates[index] > 0.0)
