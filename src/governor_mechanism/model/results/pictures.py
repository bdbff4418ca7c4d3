"""Pictures of a run: a figure, and the file of a film with its options."""

import inspect
import os
import re
import textwrap
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import StrEnum
from html import escape
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol, TypedDict, TypeVar, Unpack

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.units.problems import FLAG, NUMBER, QUANTITY, TEXT, Requirement
from governor_mechanism.units.quantities import convert_texts, format_value

PAGE_HEIGHT = 760
"""Height of an interactive page in a notebook, CSS pixels: drawing, plots and controls without scrolling."""


class Theme(StrEnum):
    """Colours of a figure: light (its ground is white in SVG and PDF), dark, or without a ground."""

    LIGHT = "light"
    DARK = "dark"
    TRANSPARENT = "transparent"


class CommandOption(NamedTuple):
    """The option of a command that stands for a field of a record of options."""

    help: str = ""
    """Its text; a field without one has no option."""
    flag: str = ""
    """Its name, if that is not the name of the field."""
    type: Any = None
    """The type in which it is read, if that is not the type of the field."""


class Figure(Protocol):
    """A figure, which a notebook shows."""

    def save(self, path: str | os.PathLike[str], theme: str = "light") -> Path:
        """Write the figure as PNG, SVG or PDF, in the theme "light", "dark" or "transparent", and return its path."""


@dataclass(frozen=True)
class Film(os.PathLike[str]):
    """The file of a film, which a notebook shows. Functions that take a path take it too.

    Attributes
    ----------
    path
        Path of the file, which ends in .gif, .svg, .mp4, .webm or .html.
    """

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        """Return the film as HTML that holds the file itself, so that the notebook can be sent to others."""
        if not self.path.is_file():
            return f"<p>{escape(str(self.path))} is no longer there</p>"
        if self.path.suffix.lower() == ".html":
            page = escape(self.path.read_text(encoding="utf-8"))
            style = "width:100%;border:0"
            return f'<iframe srcdoc="{page}" title="{escape(self.path.stem)}" height="{PAGE_HEIGHT}" style="{style}"></iframe>'
        content = b64encode(self.path.read_bytes()).decode()
        kind = self.path.suffix.lower().removeprefix(".")
        if kind in ("mp4", "webm"):
            return f'<video controls loop autoplay muted src="data:video/{kind};base64,{content}"></video>'
        media_type = "svg+xml" if kind == "svg" else kind
        return f'<img src="data:image/{media_type};base64,{content}" alt="{escape(self.path.stem)}">'


MIN_FRAME_SIZE, MAX_FRAME_SIZE = 320, 4320
"""Smallest frame (pixels) in which text is readable, and the largest that screens show."""
WIDE_RATIO: Final = 16 / 9
"""Width over height of a film of the layout "wide"."""
_SIZE = re.compile(r"\s*(?:(?P<width>\d{1,9})\s*[xX×]\s*)?(?P<height>\d{1,9})\s*")
"""Size of a film as text: its height in pixels, or its width and height."""
MAX_FRAME_RATE = 50
"""Largest frame rate (1/s): viewers show a GIF frame of less than 2 hundredths of a second far too long."""
MAX_PLOTS = 4
"""Largest number of plots: more would leave each less than an eighth of the frame's height for its curve."""

_Function = TypeVar("_Function", bound=Callable[..., Any])


class FilmFormat(StrEnum):
    """File format of a film: moving pictures, an animated drawing, or an interactive page."""

    GIF = "gif"
    MP4 = "mp4"
    WEBM = "webm"
    SVG = "svg"
    HTML = "html"


class FilmLayout(StrEnum):
    """Layout of a film: the machine without words, alone, with plots in a square, or with plots beside it in 16:9."""

    BARE = "bare"
    MACHINE = "machine"
    MACHINE_AND_PLOTS = "machine+plots"
    WIDE = "wide"


class FilmView(StrEnum):
    """View of a part that turns with a spindle: its plane, from outside, or both side by side."""

    PLANE = "plane"
    OUTSIDE = "outside"
    BOTH = "both"


class FilmLayer(StrEnum):
    """What may be drawn of the motion over a part."""

    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    POLES = "poles"


class FilmOptionError(MechanismError):
    """A mistake in an option of a film, in words for Python and, on the command line, with the names of its options.

    Parameters
    ----------
    template
        The message, with the names of options in braces, as in "{size} must be ...", and of other values, which follow by name.
    """

    def __init__(self, template: str, **values: object) -> None:
        self._template = template
        self._values = values
        super().__init__(template.format_map({**PYTHON_WORDS, **values}))

    def in_words(self, words: Mapping[str, str]) -> MechanismError:
        """Return the mistake in other words."""
        return MechanismError(self._template.format_map({**PYTHON_WORDS, **words, **self._values}))


def list_options(names: Sequence[str]) -> str:
    """Return a template that lists options: "{labels} and {forces}"."""
    return " and ".join(f"{{{name}}}" for name in names)


def _read_frame_rate(value: float | None) -> float | None:
    if value is not None and not 1 <= value <= MAX_FRAME_RATE:
        raise FilmOptionError("{frames_per_second} must be 1 to {most}; got {found:g}", most=MAX_FRAME_RATE, found=value)
    return value


def _read_size(value: int | str) -> int:
    """Return the height of a film in pixels, a number or text: "720", or with the width before it, "720x720" or "1280x720"."""
    height = _parse_size(value)[1] if isinstance(value, str) else value
    if not isinstance(height, int) or isinstance(height, bool):
        template = '{size} is the height of the film in pixels, as 720, or its width and height, as "1280x720"; got {found}'
        raise FilmOptionError(template, found=format_value(value))
    if not MIN_FRAME_SIZE <= height <= MAX_FRAME_SIZE:
        template = "{size} must be {least} to {most} pixels; got {found}"
        raise FilmOptionError(template, least=MIN_FRAME_SIZE, most=MAX_FRAME_SIZE, found=height)
    return height


def _parse_size(text: str) -> tuple[int, int]:
    """Return the width and height of a square film, or one of 16:9, from text; both are equal if the width is not given."""
    found = _SIZE.fullmatch(text)
    if not found:
        template = "{size} {found!r} is not understood; write the height of the film in pixels, as 720, or 1280x720"
        raise FilmOptionError(template, found=text)
    height = int(found["height"])
    width = int(found["width"] or height)
    if width != height and not _is_wide(width, height):
        hint = f"one of several parts is as wide as they need; give the height, as {height}"
        template = "{size} {found!r} has a width of its own: a film is square, or 16:9 as 1280x720, and {hint}"
        raise FilmOptionError(template, found=text, hint=hint)
    return width, height


def _is_wide(width: int, height: int) -> bool:
    """Return whether the width is 16/9 of the height, to a pixel."""
    return abs(width - WIDE_RATIO * height) <= 1.0


def _one_of(name: str, words: type[StrEnum]) -> Callable[[str], StrEnum]:
    """Return the function that reads one of some words."""

    def read(value: str) -> StrEnum:
        if value not in set(words):
            template = f"a film's {{{name}}} must be one of {', '.join(words)}; got {{found!r}}.{{hint}}"
            raise FilmOptionError(template, found=value, hint=did_you_mean(value, words))
        return words(value)

    return read


def _read_theme(value: str) -> Theme:
    if value not in (Theme.LIGHT, Theme.DARK):
        raise FilmOptionError("a film's {theme} must be light or dark, for its frames have a ground; got {found!r}", found=value)
    return Theme(value)


def _read_readings(value: Sequence[str] | None) -> tuple[str, ...]:
    names = () if value is None else value
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise FilmOptionError("{readings} of a film must be a list of names, as ['arm_angle']; got {found}", found=format_value(value))
    if len(names) > MAX_PLOTS:
        template = "a film plots at most {most} readings, and {readings} names {count}: {found}; leave some out"
        raise FilmOptionError(template, most=MAX_PLOTS, count=len(names), found=", ".join(names))
    return tuple(dict.fromkeys(names))


def _read_paths(value: Sequence[str]) -> tuple[str, ...]:
    names = value
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise FilmOptionError("{paths} of a film must be a list of names of points, as ['foot']; got {found}", found=format_value(value))
    return tuple(dict.fromkeys(names))


def _read_layers(value: Sequence[str] | None) -> tuple[FilmLayer, ...]:
    names = () if value is None else value
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise FilmOptionError("{layers} of a film must be a list, as ['velocity', 'poles']; got {found}", found=format_value(value))
    for name in names:
        if name not in set(FilmLayer):
            template = f"{{layers}} of a film are {', '.join(FilmLayer)}; got {{found!r}}.{{hint}}"
            raise FilmOptionError(template, found=name, hint=did_you_mean(name, FilmLayer))
    return tuple(dict.fromkeys(map(FilmLayer, names)))


def _read_exaggerate(value: float) -> float:
    if value < 1.0:
        raise FilmOptionError("{exaggerate} must be a number of at least 1, which is the true motion; got {found:g}", found=value)
    return float(value)


def _read_slow_down(value: float | None) -> float | None:
    if value is not None and value <= 0.0:
        raise FilmOptionError("{slow_down} must be a number above 0, seconds of film per second of the run; got {found:g}", found=value)
    return value


class FilmOption(NamedTuple):
    """How an option of films is read and described, beside the name, type and default of its field."""

    requirement: Requirement | None
    """What its value must be, in words and as a predicate; None if `read` checks this too."""
    meaning: str
    """What it is, in which unit, and what its default does."""
    read: Callable[[Any], Any] = lambda value: value
    """Returns the value that the record keeps, in SI and checked."""


def film_option(default: object, *described: Any, help: str = "", flag: str = "", **more: Any) -> Any:
    """Declare a field of FilmOptions, with what `FilmOption` and `CommandOption` take."""
    return field(default=default, metadata={"option": FilmOption(*described, **more), "command": CommandOption(help, flag)})


class FilmKeywords(TypedDict, total=False):
    """Options of a film as users write them: `gm.film(run, path, size=720, stop="2 s")`."""

    frames_per_second: float | None
    size: int | str
    layout: str
    readings: Sequence[str] | None
    footer: bool
    labels: bool
    forces: bool
    traces: bool
    paths: Sequence[str] | None
    layers: Sequence[str] | None
    view: str
    exaggerate: float
    part: str | None
    start: float | str | None
    stop: float | str | None
    slow_down: float | None
    theme: str


@dataclass(frozen=True, kw_only=True, init=False)
class FilmOptions:
    """What a film shows and how: the options of `gm.film` as one checked record, which `run.save` takes.

    An option that is not valid, or that does not go with another, raises a MechanismError.
    """

    frames_per_second: float | None = film_option(
        None,
        NUMBER,
        "Frames per second of film, 1 to 50. None is 25, and 12.5 for an engine room; a GIF that would exceed 700 kB (480 pixels high) "
        "takes a lower rate, down to 10. A page has none of its own.",
        read=_read_frame_rate,
        help="Frames per second of film, 1 to 50. [25; 12.5 for an engine room]",
        flag="--fps",
    )
    size: int = film_option(
        480,
        None,
        'Height of the film in pixels, and its width per run of one part; at least 320. Or width and height as text: "1280x720" is 720 in '
        'the layout "wide". A page fits its window.',
        read=_read_size,
        help="Size of the film in pixels: its height, as 720, or 1280x720 for a film of the layout wide. [480]",
    )
    layout: FilmLayout = film_option(
        FilmLayout.MACHINE_AND_PLOTS,
        TEXT,
        '"machine" alone, in a lower frame if it is wider than high, "bare": so and without any words, which small pictures would make '
        'illegible, "machine+plots" in a square, or "wide": 16:9 with the plots beside.',
        read=_one_of("layout", FilmLayout),
        help="Layout of the film: the machine alone, bare of words (for small pictures), or with plots in a square or in 16:9.",
    )
    readings: tuple[str, ...] = film_option(
        (),
        None,
        'Names of up to 4 plotted readings, or "rate of ..."; none for those that suit the machine.',
        read=_read_readings,
        help='Plotted readings, for example "arm_angle,rate of sleeve_lift"; by default those that suit the machine.',
    )
    footer: bool = film_option(
        True,
        FLAG,
        "Whether the last line states accuracy and engine; an early end of the run is always stated.",
        help="Leave out the line on accuracy and engine at the bottom of the film.",
        flag="--no-footer",
    )
    labels: bool = film_option(
        False,
        FLAG,
        "Whether the parts and the angle of the leading reading are named.",
        help="Name the parts and the main angle on the film.",
    )
    forces: bool = film_option(
        False,
        FLAG,
        "Whether the forces on the bodies are drawn: weight, centrifugal force, springs and dampers. Forces of joints that the scene names "
        "in `[run] readings` are drawn in any case; a bar states the scale.",
        help="Draw weights, centrifugal forces, springs and dampers as arrows on the film.",
    )
    traces: bool = film_option(
        False, FLAG, "Whether the paths of the mass centres are drawn.", help="Draw the paths of the mass centres on the film."
    )
    paths: tuple[str, ...] | None = film_option(
        None,
        None,
        "Names of points whose paths are drawn, as `run.paths` names them: the whole curve, and behind the point its last second of film. "
        "None is what the scene names in `[run] paths`.",
        read=_read_paths,
        help='Draw the paths of points, for example "foot,crank pin": named points, pins, bodies (their mass centres), or "crank.end"; '
        "their coordinates are readings, too. By default those that the scene names.",
    )
    layers: tuple[FilmLayer, ...] = film_option(
        (),
        None,
        'What is drawn of the motion: "velocity" and "acceleration" of named points (else of pins) as arrows, each on a scale of its own, '
        'and "poles", the instantaneous centres of bodies against the plane. Accelerations are differences of velocities at the reported '
        "times.",
        read=_read_layers,
        help='Draw of the motion, for example "velocity,poles": velocity, acceleration (arrows at points), poles (instantaneous centres).',
    )
    view: FilmView = film_option(
        FilmView.PLANE,
        TEXT,
        'How parts that turn with a spindle are seen: "plane" for the turning plane, "outside" for the turning governor from the side, or '
        '"both". A spindle that would make a turn in fewer than 10 frames is then slowed as a crank is. A film from outside closes on the '
        "last period after which the spindle has made whole turns to 2 % of a turn; where there is none, it closes on the motion in the "
        "plane alone, and the spindle jumps when the film repeats.",
        read=_one_of("view", FilmView),
        help="View of a governor on the film: in its turning plane, from outside while the spindle turns, or both.",
    )
    exaggerate: float = film_option(
        1.0,
        NUMBER,
        "Magnification of the motion about its mean position, at least 1, for motions too small to be seen; the plots stay true. The scene "
        "must have one part whose positions follow one free coordinate.",
        read=_read_exaggerate,
        help="Magnify the motion about its mean position on the film, for one that is too small to be seen.",
    )
    part: str | None = film_option(
        None,
        TEXT,
        "Name of the part to show. None shows all parts, each in a panel of its own; an engine and the governor that it drives, and that "
        "controls it, are shown as one elevation of an engine room.",
        help="Show this part of the scene on the film; by default all parts.",
    )
    start: float | None = film_option(
        None,
        QUANTITY,
        "Start of the shown part of the runs, s, or text with a unit. None is the first reported time.",
        read=lambda value: convert_texts(value, "time", "start"),
        help='Start of the film, for example "2 s"; by default that of the run.',
    )
    stop: float | None = film_option(
        None,
        QUANTITY,
        "End of the shown part of the runs, s, or text with a unit. None is the last reported time of any. By default, the film of a run "
        "that is periodic to its end closes on its last whole turn or period, so that it repeats without a jump; without a start, the film "
        "of an engine room ends soon after the governor has settled, and says so. A page shows the whole run.",
        read=lambda value: convert_texts(value, "time", "stop"),
        help="End of the film; by default that of the run, or of its last whole turn or period.",
    )
    slow_down: float | None = film_option(
        None,
        NUMBER,
        "Seconds of film per second of the run; 1 is true time. None is true time for runs of 1 to 60 s; shorter runs are slowed and "
        "longer ones sped up to a film of 4 to 20 s. A crank that would make a turn in fewer than 20 frames is slowed further, and of a "
        "long run the first turns are shown. The film of an engine room is sped up by a whole number to at most 10 s. A page begins as its "
        "run is long, but in true time up to 100 s.",
        read=_read_slow_down,
        help="Seconds of film per second of the run; by default 1, and more for short runs and fast cranks.",
    )
    theme: Theme = film_option(Theme.LIGHT, TEXT, 'Colours: "light" or "dark". A page follows the reader\'s screen.', read=_read_theme)

    def __init__(self, **options: Unpack[FilmKeywords]) -> None:
        for name in options:
            if name not in OPTIONS:
                known = ", ".join(OPTIONS)
                raise MechanismError(f"a film has no option {name!r}; its options are {known}.{did_you_mean(name, OPTIONS)}")
        chosen: Mapping[str, object] = {**options, **_find_wide_layout(options)}
        for one in fields(self):
            object.__setattr__(self, one.name, _read(one.name, chosen.get(one.name, one.default), one.default))
        self._require_combination()

    def _require_combination(self) -> None:
        """Raise FilmOptionError for options that do not go together."""
        if self.readings and self.layout in (FilmLayout.MACHINE, FilmLayout.BARE):
            template = "a film of the {layout} {found!r} plots no readings; leave {readings} out, or choose 'machine+plots' or 'wide'"
            raise FilmOptionError(template, found=str(self.layout))
        if self.labels and self.layout is FilmLayout.BARE:
            raise FilmOptionError("{labels} are words, which the {layout} 'bare' leaves out; leave one of the two out")
        overlays = [name for name in ("labels", "forces", "traces", "paths", "layers") if getattr(self, name)]
        if overlays and self.view is FilmView.OUTSIDE:
            raise FilmOptionError(
                f"{list_options(overlays)} are drawn on the turning plane, which the {{view}} 'outside' does not show; "
                "leave them out, or choose the {view} 'both'"
            )
        if self.forces and self.exaggerate > 1.0:
            raise FilmOptionError("{forces} are those of the true positions, which {exaggerate} does not show; leave one of the two out")
        if self.layers and self.exaggerate > 1.0:
            raise FilmOptionError("{layers} are those of the true motion, which {exaggerate} does not show; leave one of the two out")


def _find_wide_layout(options: FilmKeywords) -> FilmKeywords:
    """Return the layout of a film whose size is written as 16:9, nothing for another; raise FilmOptionError if another is chosen."""
    size, layout = options.get("size"), options.get("layout", FilmLayout.WIDE)
    if not isinstance(size, str) or not _is_wide(*_parse_size(size)):
        return {}
    if layout != FilmLayout.WIDE:
        raise FilmOptionError("{size} {found!r} is 16:9, and {layout} {other} is not; leave one of them out", found=size, other=layout)
    return {"layout": FilmLayout.WIDE}


def _read(name: str, value: object, default: object) -> object:
    """Return the value that the record keeps of an option; the default needs no check."""
    if value is default:
        return value
    option = OPTIONS[name]
    if option.requirement is not None:
        description, is_met = option.requirement
        if not is_met(value):
            raise MechanismError(f"{name} must be {description}; found {format_value(value)}")
    return option.read(value)


OPTIONS: Final[Mapping[str, FilmOption]] = {one.name: one.metadata["option"] for one in fields(FilmOptions)}
"""Options of films by their names."""
PYTHON_WORDS: Final[Mapping[str, str]] = {**{name: name for name in OPTIONS}, "use_gif": "write a .gif"}
"""Words of messages by the names that templates have for them: the arguments of `gm.film`, and how to choose a GIF."""
DEFAULT_OPTIONS: Final = FilmOptions()
"""Options of a film of which nothing is requested."""


def show_film_options(function: _Function) -> _Function:
    """Show the options of films in the signature of a function that takes them as `**options`, and in its docstring."""
    *own, _ = inspect.signature(function).parameters.values()
    types = FilmKeywords.__annotations__
    defaults = {one.name: one.default.value if isinstance(one.default, StrEnum) else one.default for one in fields(FilmOptions)}
    options = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=defaults[name], annotation=types[name]) for name in OPTIONS]
    hints = {name: hint for name, hint in function.__annotations__.items() if name != "options"}
    changed: Any = function
    changed.__signature__ = inspect.Signature([*own, *options], return_annotation=hints["return"])
    changed.__annotations__ = {**hints, **types}
    changed.__doc__ = inspect.cleandoc(function.__doc__ or "").replace("\n\nReturns\n---", f"\n{_DESCRIPTION}\n\nReturns\n---")
    return function


_DESCRIPTION: Final = "\n".join(f"{name}\n{textwrap.indent(textwrap.fill(one.meaning, 120), '    ')}" for name, one in OPTIONS.items())
"""The options in the form of a docstring."""
show_film_options(FilmOptions.__init__)
FilmOptions.__doc__ = f"{inspect.cleandoc(FilmOptions.__doc__ or '')}\n\nAttributes\n----------\n{_DESCRIPTION}"
