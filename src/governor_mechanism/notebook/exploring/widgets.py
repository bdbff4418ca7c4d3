"""The widgets of a view in a notebook.

Only widgets of ipywidgets itself are used: JupyterLab, VS Code and Colab bring their scripts along, while a widget of our own (anywidget)
would have to be loaded by each of them, and in Colab be allowed first. The pictures are SVG, which needs no script at all.
"""

import math
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, Protocol

from governor_mechanism.errors import MechanismError
from governor_mechanism.notebook.exploring.sliders import Slider
from governor_mechanism.units.quantities import format_reading_name

SLIDER_WIDTH, LABEL_WIDTH = "390px", "150px"
"""Widths of a slider with its label and number, and of the label: two fit above the pictures."""
SENTENCES_HEIGHT = "4.5em"
"""Height that is kept for the sentences, so that the pictures do not move while a slider is dragged."""


ROUNDING_RATIO = 1e-6
"""Difference relative to a step below which two values of a slider are the same: its script works with the same numbers, but rounds."""


class Explored(Protocol):
    """What the widgets change and show."""

    @property
    def sliders(self) -> Sequence[Slider]:
        """The sliders, last that of the variable."""

    @property
    def values(self) -> Mapping[str, float]:
        """Their values by name, SI."""

    @property
    def readings(self) -> Sequence[str]:
        """Readings to choose from."""

    @property
    def reading(self) -> str:
        """The chosen reading."""

    @property
    def sentences_html(self) -> str:
        """Sentences about the pictures."""

    @property
    def pictures_html(self) -> str:
        """The pictures."""

    def set(self, name: str, value: float | str) -> None:
        """Change a value."""

    def show(self, reading: str) -> None:
        """Choose a reading."""


def require_widgets() -> Any:
    """Return the module ipywidgets; raise MechanismError with the command that installs it."""
    try:
        return import_module("ipywidgets")
    except ImportError:
        message = (
            "explore needs the package ipywidgets, which is not installed; install the extra: pip install 'governor-mechanism[notebook]'"
        )
        raise MechanismError(message) from None


class Panel:
    """Sliders, a choice of readings, sentences and pictures, connected with what they explore."""

    def __init__(self, explored: Explored) -> None:
        self._explored, self._widgets = explored, require_widgets()
        self._is_refreshing = False
        *dimensions, variable = explored.sliders
        self._sliders = {one.name: self._make_slider(one) for one in (variable, *dimensions)}
        self._choice = self._make_choice() if explored.readings else None
        controls = [*self._sliders.values(), *([self._choice] if self._choice else [])]
        self._sentences = self._widgets.HTML(layout={"min_height": SENTENCES_HEIGHT, "max_width": "780px"})
        self._pictures = self._widgets.HTML()
        self._box = self._widgets.VBox([self._widgets.Box(controls, layout={"flex_flow": "row wrap"}), self._sentences, self._pictures])
        self.refresh()

    def bundle(self) -> dict[str, Any]:
        """Return what a notebook needs to show the widgets."""
        return dict(self._box._repr_mimebundle_())

    def refresh(self) -> None:
        """Show the values and pictures of what is explored; a picture that has not changed is not sent again."""
        self._is_refreshing = True
        try:
            for one in self._explored.sliders:
                shown, number = self._sliders[one.name], self._explored.values[one.name] * one.display[0]
                if abs((number - shown.min) / one.step - round((number - shown.min) / one.step)) > ROUNDING_RATIO:
                    low, high = _align_ends(one, number)
                    # The order in which both ends and the value may be set: an end must not pass the other one.
                    shown.min, shown.max = min(low, shown.min), max(high, shown.max)
                    shown.min, shown.max = low, high
                shown.min, shown.max = min(shown.min, number), max(shown.max, number)
                shown.value = number
            if self._choice is not None:
                self._choice.options = _named(self._explored.readings)
                self._choice.value = self._explored.reading
            self._sentences.value, self._pictures.value = self._explored.sentences_html, self._explored.pictures_html
        finally:
            self._is_refreshing = False

    def _make_slider(self, slider: Slider) -> Any:
        """Return the widget of a slider, in the unit shown to users."""
        factor, _ = slider.display
        value = self._explored.values[slider.name] * factor
        low, high = _align_ends(slider, value)
        widget = self._widgets.FloatSlider(
            value=value,
            min=low,
            max=high,
            step=slider.step,
            description=slider.label,
            readout_format=".4g",
            style={"description_width": LABEL_WIDTH},
            layout={"width": SLIDER_WIDTH},
        )

        def change(event: Mapping[str, Any]) -> None:
            is_rounding = abs(event["new"] - self._explored.values[slider.name] * factor) < ROUNDING_RATIO * slider.step
            if not (self._is_refreshing or is_rounding):
                self._explored.set(slider.name, event["new"] / factor)

        widget.observe(change, names="value")
        return widget

    def _make_choice(self) -> Any:
        """Return the widget that chooses the reading of the plot."""
        widget = self._widgets.Dropdown(
            options=_named(self._explored.readings),
            value=self._explored.reading,
            description="shown",
            style={"description_width": LABEL_WIDTH},
            layout={"width": SLIDER_WIDTH},
        )

        def change(event: Mapping[str, Any]) -> None:
            if not self._is_refreshing:
                self._explored.show(event["new"])

        widget.observe(change, names="value")
        return widget


def _align_ends(slider: Slider, value: float) -> tuple[float, float]:
    """Return the ends of a slider that lie whole steps from a value, in the unit shown to users.

    The script of a slider moves a value that is not a whole number of steps from the lower end to the next one that is, and sends it back.
    """
    factor, step = slider.display[0], slider.step
    below, above = (math.floor(abs(value - end * factor) / step + ROUNDING_RATIO) for end in (slider.low, slider.high))
    return (value - below * step if value > slider.low * factor else value), (
        value + above * step if value < slider.high * factor else value
    )


def _named(readings: Sequence[str]) -> list[tuple[str, str]]:
    """Return the readings with their names in words."""
    return [(format_reading_name(name), name) for name in readings]
