"""A mechanism to be explored: numbers are changed one by one, and pose, curve and sentences follow."""

import math
from collections.abc import Mapping, Sequence
from html import escape
from importlib import import_module
from typing import Any, Protocol

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.governor_view import make_governor_view
from governor_mechanism.notebook.exploring.motion_view import make_motion_view
from governor_mechanism.notebook.exploring.sliders import Slider, View, find_sliders
from governor_mechanism.render.geometry.primitives import enclose_boxes
from governor_mechanism.render.style import VERMILLION
from governor_mechanism.scenes.changed_document import document_of, parse_scene_with
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.equilibrium_speed import has_equilibrium_speed
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.units.quantities import format_quantity, format_reading_name

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


PROGRAM = (list, dict)
"""Types of a spindle speed in a document that changes with time."""


class Exploration:
    """Result of `gm.explore`: a notebook shows it with a slider for each of `values`; in a script its methods do the same.

    Parameters
    ----------
    scene
        Scene with a document.

    Raises
    ------
    MechanismError
        If a key is wrong, or the scene has neither a speed curve nor one degree of freedom.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> view = gm.explore("porter", "arm")
    >>> view.set("arm", "320 mm")
    >>> view.equilibrium.stable, view.scene.part.dimensions["arm"]
    (True, 0.32)
    """

    def __init__(self, scene: Scene, *keys: str) -> None:
        self._document = document_of(scene, "explore")
        self._first_scene = self._scene = scene
        self._view = _make_view(scene)
        self._reading = next(iter(self._view.reading_choices), "")
        self._sliders = {one.name: one for one in find_sliders(self._document, _shown_part(scene, self._view), keys, self._check_key)}
        self._variable = self._view.variable
        self._values = {name: one.value for name, one in self._sliders.items()} | {self._variable.name: self._variable.value}
        self._problem = ""
        self._panel: Panel | None = None
        self._state = self._view.solve(self._variable.value, None)
        self._box = self._view.drawing_at(self._state.position).box
        self._update(is_geometry_new=not all(one.is_given for one in self._sliders.values()))

    @property
    def sliders(self) -> tuple[Slider, ...]:
        """The sliders: of the keys of the scene, and last that of the spindle speed, the leading coordinate or time."""
        return *self._sliders.values(), self._variable

    @property
    def values(self) -> Mapping[str, float]:
        """Values of the sliders by name, SI."""
        return dict(self._values)

    @property
    def ranges(self) -> Mapping[str, tuple[float, float]]:
        """Ends of the sliders by name, SI."""
        return {one.name: (one.low, one.high) for one in self.sliders}

    @property
    def scene(self) -> Scene:
        """The scene with the values of the sliders; while their geometry is impossible, the last possible one."""
        return self._scene

    @property
    def speed_curve(self) -> SpeedCurve | None:
        """Equilibrium speed over the travel; None if no spindle speed can balance the loads of the scene."""
        return self._view.speed_curve

    @property
    def kinematics(self) -> Kinematics | None:
        """Motion over the leading coordinate or time; None for a scene with a speed curve."""
        return self._view.kinematics

    @property
    def equilibria(self) -> tuple[Equilibrium, ...]:
        """All equilibria at the spindle speed."""
        return self._state.equilibria

    @property
    def equilibrium(self) -> Equilibrium | None:
        """The shown equilibrium: the stable one nearest to the last pose. None if there is none."""
        return self._state.equilibrium

    @property
    def problem(self) -> str:
        """Why the pictures show an earlier state: the geometry is impossible, or there is no equilibrium; empty if they do not."""
        return self._problem or self._state.problem

    @property
    def readings(self) -> tuple[str, ...]:
        """Readings that the plot can show; empty for a scene with a speed curve."""
        return tuple(self._view.reading_choices)

    @property
    def reading(self) -> str:
        """The reading in the plot; empty for a scene with a speed curve."""
        return self._reading

    @property
    def html(self) -> str:
        """Sentences and pictures as HTML."""
        return f"{self.sentences_html}{self.pictures_html}"

    @property
    def sentences_html(self) -> str:
        """What the pictures show, or why they show an earlier state."""
        colour = f"color:{VERMILLION};" if self.problem else ""
        return f'<div style="{colour}line-height:1.4">{escape(self.problem or " ".join(self._state.sentences))}</div>'

    @property
    def pictures_html(self) -> str:
        """Drawing and curve side by side."""
        # Each shrinks with a narrow notebook; the one beside the other, since a slider moves both.
        pictures = "".join(f'<div style="flex:0 1 auto;min-width:0">{picture}</div>' for picture in (self._drawing, self._plot))
        return f'<div style="display:flex;gap:8px">{pictures}</div>'

    def set(self, name: str, value: float | str) -> None:
        """Change a value, as its slider does. An impossible geometry is no error: `problem` says why, and the scene stays as it was.

        Parameters
        ----------
        name
            Name of a slider, or its key in the scene.
        value
            Value, SI, or text with a unit.

        Raises
        ------
        MechanismError
            If there is no such slider, or the value is no quantity of its kind.
        """
        slider = next((one for one in self.sliders if name in (one.name, one.key)), None)
        if slider is None or not name:
            names = [one.name for one in self.sliders]
            raise MechanismError(f"there is no slider {name!r}; the sliders are {', '.join(names)}.{did_you_mean(str(name), names)}")
        self._values[slider.name] = slider.parse(value)
        self._update(is_geometry_new=slider is not self._variable)

    def show(self, reading: str) -> None:
        """Choose the reading in the plot.

        Parameters
        ----------
        reading
            Name of one of `readings`.

        Raises
        ------
        MechanismError
            If there is no such reading to choose.
        """
        if reading not in self.readings:
            known = f"the readings are {', '.join(self.readings)}" if self.readings else "this scene shows its speed curve"
            raise MechanismError(f"the plot cannot show {reading!r}: {known}.{did_you_mean(str(reading), self.readings)}")
        self._reading = reading
        self._draw()

    def __repr__(self) -> str:
        """Return the title and the values of the sliders in a line."""
        values = ", ".join(f"{one.name} {format_quantity(self._values[one.name], one.unit)}" for one in self.sliders)
        return f"Exploration({self._scene.title!r}; {values})"

    def _repr_html_(self) -> str:
        """Return sentences and pictures, for a page without sliders."""
        return self.html

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the sliders and pictures for a notebook, and the pictures alone for a page without sliders."""
        if self._panel is None:
            self._panel = Panel(self)
        return {**self._panel.bundle(), "text/html": self.html, "text/plain": repr(self)}

    def _update(self, *, is_geometry_new: bool) -> None:
        """Compute what the changed values change, and draw it."""
        try:
            changed = self._document_values()
            scene = parse_scene_with(self._document, changed) if changed else self._first_scene
            if is_geometry_new or self._problem:
                self._view = self._view.with_scene(scene)
            self._scene, self._problem = scene, ""
        except MechanismError as error:
            sentence = "; ".join(error.problems)
            self._problem = f"{sentence[:1].upper()}{sentence[1:]}. The pictures show the last possible geometry."
        else:
            self._state = self._view.solve(self._values[self._variable.name], self._state)
        self._draw()

    def _document_values(self) -> list[tuple[str, float | str]]:
        """Return the keys of the document whose values are new or have changed, with these values."""
        changed = [one for one in self.sliders if one.key and not (one.is_given and self._values[one.name] == one.value)]
        return [(one.key, one.write(self._values[one.name])) for one in changed]

    def _check_key(self, key: str, value: float | str) -> object:
        """Raise MechanismError if a value at a key makes the geometry impossible."""
        return self._view.check_geometry(parse_scene_with(self._document, [(key, value)]))

    def _draw(self) -> None:
        """Draw the pictures, and hand them to the notebook."""
        # The view stays where it is, so that what is made longer looks longer.
        drawing = self._view.drawing_at(self._state.position)
        box = enclose_boxes([self._box, drawing.box])
        is_impossible = bool(self._problem)
        self._drawing = drawing.draw(self._state.pose, box, is_faded=bool(self.problem))
        self._plot = self._view.plot(self._state, self._reading, is_faded=is_impossible) if self._reading or self.speed_curve else ""
        if self._panel is not None:
            self._panel.refresh()


def explore_scene(
    scene: Scene,
    # keys or names of dimensions, also with a range; the first dimensions of the machine if empty
    keys: Sequence[str],
) -> Exploration:
    """Return a view of a scene with a slider for each key."""
    require_widgets()
    return Exploration(scene, *keys)


def _make_view(scene: Scene) -> View:
    """Return the view of the part that turns with a spindle over the spindle speed, or of the only part over its coordinate."""
    rotating = [part for part in scene.parts if part.turns]
    if len(scene.parts) == 1 and not has_equilibrium_speed(scene):
        return make_motion_view(scene)
    document: Mapping[str, Any] = scene.document
    key = "spindle.speed"
    if len(scene.parts) > 1 and rotating:
        key = f"part.{rotating[0].name}.spindle.speed"
        document = document["part"][rotating[0].name]
    speed = document.get("spindle", {}).get("speed")
    return make_governor_view(scene, "" if speed is None or isinstance(speed, PROGRAM) else key)


def _shown_part(scene: Scene, view: View) -> Any:
    """Return the part of a scene that a view shows."""
    return next(part for part in scene.parts if part.name == view.scene.part.name)
