"""A varied key of a sweep on an axis of a figure."""

from typing import Literal

import numpy as np
from matplotlib.ticker import MaxNLocator

from governor_mechanism.render.figures.page import Panel, format_plain_ticks
from governor_mechanism.render.number_format import format_label
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.types import FloatArray

_MAX_TICKS = 24
"""Largest number of text labels on an axis."""

_MAX_TICKED_VALUES = 5
"""Largest number of numbers of a key that all have a tick of their own."""

_AXIS_MARGIN_RATIO = 0.02
"""Margin of an axis of curves beyond its outer values, as a fraction of its length."""

_MIN_LOGARITHMIC_RATIO = 100.0
"""Ratio of the largest to the smallest positive value from which an axis is logarithmic."""

ROUND_STEPS = (1, 2, 2.5, 5, 10)
"""Distances of ticks and contours, times a power of ten."""


class SweepAxisScale:
    """Axis of a sweep on an axis of a figure: positions of its values in ascending order.

    Numbers are in everyday units; text values are at integer positions in the given order.
    """

    def __init__(self, axis: SweepAxis) -> None:
        self.axis = axis
        factor, _ = axis.display_unit
        values = np.array(axis.values, dtype=float) * factor if axis.is_numeric else np.arange(float(len(axis.values)))
        self.order = np.argsort(values, kind="stable")
        self.positions: FloatArray = values[self.order]
        first, last = self.positions[[0, -1]]
        self.is_logarithmic = axis.is_numeric and first > 0 and last >= _MIN_LOGARITHMIC_RATIO * first

    @property
    def label(self) -> str:
        """Label of the axis."""
        return label_with_unit(self.axis.key, self.axis.display_unit[1] if self.axis.is_numeric else "")

    @property
    def scene_position(self) -> float | None:
        """Position of the value that the scene itself has; None if it has none within the range."""
        value = self.axis.scene_value
        if self.axis.is_numeric:
            position = value * self.axis.display_unit[0] if isinstance(value, float) else None
        else:
            position = float(self.axis.values.index(value)) if value in self.axis.values else None
        edges = self.cell_edges()
        return position if position is not None and edges[0] <= position <= edges[-1] else None

    def cell_edges(self) -> FloatArray:
        """Return the edges of the cells around the positions."""
        transformed = np.log(self.positions) if self.is_logarithmic else self.positions
        midpoints = (transformed[1:] + transformed[:-1]) / 2
        outer_half_widths = (midpoints[0] - transformed[0], transformed[-1] - midpoints[-1]) if len(transformed) > 1 else (0.5, 0.5)
        edges = np.concatenate([[transformed[0] - outer_half_widths[0]], midpoints, [transformed[-1] + outer_half_widths[1]]])
        return np.exp(edges) if self.is_logarithmic else edges

    def format_value(self, value: float | str | bool | None) -> str:
        """Return a value of the axis as text."""
        if isinstance(value, bool):
            return "on" if value else "off"
        factor, unit = self.axis.display_unit
        return f"{value * factor:.5g} {unit}".strip() if isinstance(value, float) else str(value)

    def apply_to(self, panel: Panel, axis_name: Literal["x", "y"], *, cells: bool = False) -> None:
        """Set scale, limits and ticks of a figure axis; the limits are those of the cells, or the outer values with a margin."""
        if self.is_logarithmic:
            panel.set(**{f"{axis_name}scale": "log"})
        panel.set(**{f"{axis_name}lim": self._limits(cells=cells)})
        axis = panel.xaxis if axis_name == "x" else panel.yaxis
        if not self.axis.is_numeric:
            indices = range(0, len(self.positions), -(-len(self.positions) // _MAX_TICKS))
            axis.set_ticks([self.positions[k] for k in indices], labels=[self.format_value(self.axis.values[k]) for k in indices])
        elif len(self.positions) <= _MAX_TICKED_VALUES:
            axis.set_ticks(self.positions.tolist(), labels=[f"{one:.5g}" for one in self.positions.tolist()], minor=False)
            axis.set_ticks([], minor=True)
        elif not self.is_logarithmic:
            axis.set_major_locator(MaxNLocator(6, min_n_ticks=2, steps=ROUND_STEPS))
            format_plain_ticks(axis, (self.positions[0], self.positions[-1]))

    def _limits(self, *, cells: bool) -> tuple[float, float]:
        low, high = self.positions[0], self.positions[-1]
        if cells or len(self.positions) == 1 or not self.axis.is_numeric:
            edges = self.cell_edges()
            return edges[0], edges[-1]
        if self.is_logarithmic:
            factor = (high / low) ** _AXIS_MARGIN_RATIO
            return low / factor, high * factor
        margin = _AXIS_MARGIN_RATIO * (high - low)
        return low - margin, high + margin


def label_with_unit(name: str, unit: str) -> str:
    """Return the label of a key or a quantity with its unit."""
    return format_label(name.removeprefix("dimensions.").removeprefix("effects."), unit)
