"""A mechanism to be explored in a notebook: the live page in an output cell, and the same from Python."""

import dataclasses
import json
import math
import tempfile
from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import partial
from html import escape
from importlib import import_module, resources
from pathlib import Path
from threading import Event, Thread
from typing import Any, Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.live.conversation import attempt, describe_present, respond
from governor_mechanism.live.page import make_live_page
from governor_mechanism.live.quantities import find_quantities, split_quantity
from governor_mechanism.live.session import Session
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.pictures import PAGE_HEIGHT
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.film.painters import write_still
from governor_mechanism.scenes.changed_document import document_of, parse_scene_with
from governor_mechanism.studies.sweep.parameters import SweepAxis, find_scene_value, parse_axes
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, number_or_text, parse_quantity

PICTURE_SIZE: Final = 480
"""Height of the picture that stands where nothing can move, pixels."""

PROBED_VALUE: Final = 1.0
"""Value with which it is found out whether a key exists."""

EXTRA: Final = "pip install 'governor-mechanism[notebook]'"
"""What installs the package that shows widgets."""


class Exploration:
    """Result of `gm.explore`: a notebook shows it as the live page; in a script its methods do what a hand does there.

    Parameters
    ----------
    scene
        Scene with a document.

    Raises
    ------
    MechanismError
        If a key is wrong, or the scene cannot be run.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> view = gm.explore("porter", "arm")
    >>> view.set("arm", "320 mm")
    >>> view.scene.part.dimensions["arm"], view.quantities["dimensions.arm"]
    (0.32, '320 mm')
    """

    def __init__(self, scene: Scene, *keys: str) -> None:
        document = document_of(scene, "explore")
        part = next((part for part in scene.parts if part.turns), scene.parts[0])
        self._names = _Names(document, part)
        shown: dict[str, tuple[float, float] | None] = {}
        added: dict[str, float | str] = {}
        for request in keys:
            key, ends, value = self._names.read_request(request)
            shown[key] = ends
            if value is not None:
                added[key] = value
        self._session = Session(parse_scene_with(document, added.items()) if added else scene, shown)
        self._names = _Names(self._session.document, part)
        self._widget: Any = None

    @property
    def scene(self) -> Scene:
        """The scene with the present values; while they are impossible, the last possible one."""
        return self.run.scene

    @property
    def run(self) -> Trajectory:
        """The run of the scene."""
        return self._session.solve().run

    @property
    def problem(self) -> str:
        """Why the present values are impossible; empty if they are not."""
        return self._session.solve().problem

    @property
    def quantities(self) -> Mapping[str, str]:
        """What may be changed, by dotted key, as a scene file writes it."""
        return {one.key: f"{one.value:.12g} {one.unit}".rstrip() for one in self._session.find_quantities().values()}

    def set(self, name: str, value: float | str) -> None:
        """Change a quantity. Impossible values are no error: `problem` says why, and `scene` stays as it was.

        Parameters
        ----------
        name
            Name of a dimension, or dotted key.
        value
            Value, SI, or text with a unit.

        Raises
        ------
        MechanismError
            If there is no such quantity, or the value is none of its kind.
        """
        key = self._names.find_key(name)
        self._session.change({key: self._names.convert(value, key)})

    def undo(self) -> None:
        """Take the last change back, also one that a hand made on the page."""
        self._session.undo()

    def __repr__(self) -> str:
        """Return the title and the quantities that were asked for in a line."""
        values = ", ".join(f"{self._names.shorten(key)} {self.quantities[key]}" for key in self._session.shown)
        return f"Exploration({self.scene.title!r}{f'; {values}' if values else ''})"

    def _repr_html_(self) -> str:
        """Return the picture and a sentence, for a page without a kernel, or without widgets."""
        with tempfile.TemporaryDirectory() as folder:
            content = write_still(self.run, Path(folder) / "still.png", size=PICTURE_SIZE).read_bytes()
        picture = f'<img src="data:image/png;base64,{b64encode(content).decode()}" alt="{escape(self.scene.title)}">'
        cure = "run this cell in a notebook to" if _find_widgets() else f"install the extra ({EXTRA}) and run this cell again to"
        return f"<div>{picture}<p>{escape(f'A picture of the end of the run; {cure} drag points and change quantities.')}</p></div>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the page for a notebook, and a picture where there are no widgets."""
        static = {"text/html": self._repr_html_(), "text/plain": repr(self)}
        if (anywidget := _find_widgets()) is None:
            return static
        if self._widget is None:
            self._widget = make_widget(anywidget, self._session, self.scene.title)
        data = self._widget._repr_mimebundle_()
        return {**(data[0] if isinstance(data, tuple) else data), **static}


def explore_scene(
    scene: Scene,
    # keys or names of dimensions, also with a range; all quantities of the scene if empty
    keys: Sequence[str],
) -> Exploration:
    """Return the live page of a scene for a notebook, with sliders for these keys."""
    return Exploration(scene, *keys)


def _find_widgets() -> Any:
    """Return the module anywidget; None if it is not installed."""
    try:
        return import_module("anywidget")
    except ImportError:
        return None


def make_widget(anywidget: Any, session: Session, title: str) -> Any:
    """Return the widget that shows the page of a session, and carries its messages; anywidget is handed over since it is optional."""
    traits = import_module("traitlets")
    script = resources.files("governor_mechanism.notebook").joinpath("page_frame.js").read_text(encoding="utf-8")
    fields = {name: traits.Unicode().tag(sync=True) for name in ("page", "title", "height")}
    widget = type("LivePage", (anywidget.AnyWidget,), {"_esm": script, **fields})(
        page=make_live_page(session, "notebook"), title=title, height=f"{PAGE_HEIGHT}px"
    )
    changed = Event()
    session.listeners.add(changed.set)

    def hear(_: Any, text: Any, __: Any) -> None:
        answer = attempt(partial(respond, session, text)) if isinstance(text, str) else None
        if callable(answer):
            Thread(target=lambda: widget.send(json.dumps(attempt(answer), allow_nan=False)), daemon=True).start()
        elif answer is not None:
            widget.send(json.dumps(answer, allow_nan=False))

    def tell() -> None:
        """Send the state whenever it has changed; what changes while one is computed is answered by the next."""
        while changed.wait():
            changed.clear()
            widget.send(json.dumps(attempt(partial(describe_present, session)), allow_nan=False))

    widget.on_msg(hear)
    Thread(target=tell, daemon=True).start()  # the kernel goes on meanwhile
    return widget


class _Names:
    """Short names of the quantities of a scene: dimensions of a machine, and rods of a custom one for their lengths."""

    def __init__(self, document: Mapping[str, Any], part: Part) -> None:
        self._document, self._part = document, part
        self._quantities = find_quantities(document, 1.0)
        self._prefix = f"part.{part.name}." if "part" in document else ""
        own: Mapping[str, Any] = document["part"][part.name] if self._prefix else document
        machine = MACHINES.get(part.machine)
        dimensions = [field.name for field in dataclasses.fields(machine)] if machine else list(own.get("dimensions", {}))
        rods = [] if machine else [str(one.get("name")) for one in own.get("body", ()) if "length" in one.get("rod", {})]
        keys = {name: f"body.{name}.rod.length" for name in rods} | {name: f"dimensions.{name}" for name in dimensions}
        self._keys = {name: f"{self._prefix}{key}" for name, key in keys.items()}

    def find_key(self, name: object) -> str:
        """Return the dotted key for a name; raise MechanismError if it means nothing here."""
        if not isinstance(name, str):
            raise MechanismError(f'explore takes names of dimensions, as "arm" or "dimensions.arm"; found {format_value(name)}')
        if name in self._keys:
            return self._keys[name]
        if "." not in name:
            raise MechanismError(
                f"{format_value(name)} is no dimension of this scene; its dimensions are {', '.join(self._keys) or 'none'}, and other "
                f'quantities have dotted keys, as "effects.spring.sleeve.rate".{did_you_mean(name, self._keys)}'
            )
        return name if name.startswith(("part.", "coupling.", "load.")) else f"{self._prefix}{name}"

    def shorten(self, key: str) -> str:
        """Return the short name for a dotted key, if it has one."""
        return next((name for name, one in self._keys.items() if one == key), key)

    def read_request(self, request: object) -> tuple[str, tuple[float, float] | None, float | str | None]:
        """Return key, range in the unit of its quantity, and the value to add if the scene does not give it."""
        name, _, values = request.partition("=") if isinstance(request, str) else (request, "", "")
        key = self.find_key(name.strip() if isinstance(name, str) else name)
        ends = _split_range(key, values) if values else []
        if key in self._quantities:
            numbers = sorted(self.convert(end, key) for end in ends)
            return key, (numbers[0], numbers[1]) if numbers else None, None
        value = self._value_of(key)
        axis = _read_axis(self._document, key, ends or ([] if value is None else [value]))
        factor, unit = axis.display_unit
        low, high = sorted(float(one) * factor for one in axis.values) if ends else (0.0, 0.0)
        number = factor * value if isinstance(value, float) else 0.5 * (low + high)
        return key, (low, high) if ends else None, f"{number:.12g} {unit}" if unit else number

    def convert(self, value: float | str, key: str) -> float:
        """Return a value, SI or text with a unit, in the unit of a quantity; raise MechanismError if it is of another kind."""
        if key not in self._quantities:
            raise MechanismError(f"{key} is no quantity of this scene.{did_you_mean(key, self._quantities)}")
        quantity = self._quantities[key]
        axis = _read_axis(self._document, key, [quantity.write(quantity.value)])
        # A dimension of a custom machine says by its unit alone what it is.
        kinds = [axis.kind] if axis.kind else [kind for kind, one in QUANTITY_KINDS.items() if quantity.unit in one.units]
        if not kinds:
            return parse_quantity(value, "ratio", key)
        factor = parse_quantity(f"1 {quantity.unit}", kinds[0], key) if quantity.unit else 1.0
        return parse_quantity(value, kinds[0], key) / factor

    def _value_of(self, key: str) -> float | str | None:
        """Return the value that a scene gives for a key, or that of a dimension which it leaves out; None without one."""
        written = find_scene_value(self._document, key, None)
        if isinstance(written, str | float):
            return written
        value = self._part.dimensions.get(key.rpartition(".")[2], math.inf) if key in self._keys.values() else math.inf
        return value if value and math.isfinite(value) else None


def _read_axis(document: Mapping[str, Any], key: str, values: Sequence[float | str]) -> SweepAxis:
    """Return values of a key as numbers in SI; raise MechanismError for a key of words, without a value, or a value of another kind."""
    try:
        (axis,) = parse_axes(document, {key: [*dict.fromkeys(values or [PROBED_VALUE])]})
    except MechanismError as error:
        problems = [problem.removeprefix("vary: ") for problem in error.problems]
        if values or any(" is unknown" in problem for problem in problems):
            raise MechanismError(*problems) from None
        axis = None
    if axis is None or not values:
        raise MechanismError(f"{key} has no number in this scene; give a range, as explore(scene, '{key}=first:last')")
    if not axis.is_numeric and (axis.kind or split_quantity(values[0]) is None):
        raise MechanismError(f"{key} takes words, and a slider moves numbers; choose another key")
    return axis


def _split_range(key: str, text: str) -> list[float | str]:
    """Return both ends of "first:last", as numbers or texts."""
    ends = [end.strip() for end in text.split(":")]
    if len(ends) != 2 or not all(ends):
        raise MechanismError(f"{key}={text} is not a range; write first:last, as in {key}=200 mm:400 mm")
    return [number_or_text(end) for end in ends]
