"""Scenes and options on the command line: `--set`, options of films, options that do nothing. Nothing heavy is imported here."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import fields
from functools import partial
from inspect import Parameter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_args, get_type_hints

import typer

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.results.pictures import CommandOption, FilmFormat, FilmOptionError, FilmOptions, Theme
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.units.quantities import number_or_text

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene


_typed_options: ContextVar[Mapping[str, str]] = ContextVar("typed_options")
"""Options of the command that is parsed, as typed, by the names of their parameters."""

_NONE: Final[Mapping[str, str]] = {}
"""The options of a function that is called without a command line."""

_ARGUMENT_WORDS: Final = {"seconds": "run.duration", "case": "names"}
"""How messages name what an option gives, where that is not the name of its parameter."""


def remember_options(options: Mapping[str, str]) -> None:
    """Remember how options are typed, by the names of their parameters."""
    _typed_options.set(dict(options))


def is_given(name: str) -> bool:
    """Return whether the option of a parameter stands on the command line."""
    return name in _typed_options.get(_NONE)


def refuse_idle_options(*names: str, condition: str) -> None:
    """Raise MechanismError if options, by the names of their parameters, are given that do nothing; call it where they have no effect."""
    idle = [_typed_options.get(_NONE)[name] for name in names if is_given(name)]
    if not idle:
        return
    verb, pronoun = ("does", "it") if len(idle) == 1 else ("do", "them")
    needed = condition.removeprefix("without ")
    cure = f"give {needed} too, or leave {pronoun} out" if needed != condition else f"leave {pronoun} out"
    raise MechanismError(f"{' and '.join(idle)} {verb} nothing {condition}; {cure}")


def in_typed_words(problem: str) -> str:
    """Return a sentence with options, as typed, in the place of the names of arguments."""
    # A name of one word stands for an argument where the sentence begins; elsewhere it may be a word
    # like others.
    for name, option in _typed_options.get(_NONE).items():
        word = _ARGUMENT_WORDS.get(name, name)
        start = "^" if "_" not in word else r"(?<![\w.-])"
        problem = re.sub(rf"{start}{re.escape(word)}(?![\w.])", option, problem)
    return problem


def _flag(field: dataclasses.Field[Any]) -> str:
    """Return the name of the option that stands for a field of a record of options."""
    flag: str = field.metadata["command"].flag or f"--{field.name.replace('_', '-')}"
    return flag


COMMAND_WORDS: Final[Mapping[str, str]] = {**{one.name: _flag(one) for one in fields(FilmOptions)}, "use_gif": "choose --film gif"}
"""Words of messages on the command line, by those of Python."""


def _parse_names(option: str, example: str, text: str) -> list[str]:
    """Return the names in the text of an option with commas between, each once."""
    names = dict.fromkeys(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise MechanismError(f"{option} needs names with commas between, as in {example}; found {text!r}")
    return list(names)


_PARSERS: Final[Mapping[str, Callable[[str], object]]] = {
    "size": str,
    "readings": partial(_parse_names, "--readings", "arm_angle,sleeve_lift"),
    "paths": partial(_parse_names, "--paths", "foot,crank pin"),
    "layers": partial(_parse_names, "--layers", "velocity,poles"),
    "start": number_or_text,
    "stop": number_or_text,
}
"""Functions that read the options whose text is not simply their value."""


def _declare_options(record: type[Any]) -> Iterator[Parameter]:
    """Yield the parameters of a command that stand for the fields of a record of options."""
    types = get_type_hints(record)
    for one in fields(record):
        option: CommandOption = one.metadata["command"]
        if not option.help:
            continue
        kind = option.type or (str | None if one.name in _PARSERS else types[one.name])
        flags = [_flag(one)] if kind is bool or option.flag else []
        # A switch that is on by default has an option that turns it off.
        default = False if kind is bool else None if type(None) in get_args(kind) else one.default
        declared = typer.Option(*flags, help=option.help)
        yield Parameter(one.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, declared])


FILM_PARAMETERS: Final = tuple(_declare_options(FilmOptions))
"""Parameters of a command with films, from which its options are made."""

FIGURE_PARAMETERS: Final = tuple(_declare_options(FigureFiles))
"""Parameters of a command with figures, from which its options are made."""


def gather_figure_files(options: Mapping[str, Any]) -> FigureFiles:
    """Return where and how a command writes its figures."""
    chosen = {one.name: options[one.name] for one in FIGURE_PARAMETERS if options[one.name] is not None}
    if is_given("drawn"):
        draws_film = "no_film" in options and not options["no_film"]
        refuse_idle_options("formats", *(() if draws_film else ("theme",)), condition="with --no-figure")
    return FigureFiles(**chosen | {"drawn": not options["drawn"]})


@contextmanager
def in_command_words() -> Iterator[None]:
    """State mistakes in options of films with the names that these have on the command line: a context, or a decorator."""
    try:
        yield
    except FilmOptionError as error:
        raise error.in_words(COMMAND_WORDS) from None


@in_command_words()
def gather_film_options(
    # values of the parameters of the command by name; also `film`, its format, `no_film` and `theme`
    given: Mapping[str, Any],
) -> FilmOptions:
    """Return the options of the film of a command, in the colours of its figures if these are dark."""
    names = [one.name for one in FILM_PARAMETERS]
    if given["no_film"]:
        refuse_idle_options("film", *names, condition="with --no-film")
    chosen = {one.name: given[one.name] for one in FILM_PARAMETERS if given[one.name] != one.default}
    chosen |= {name: _PARSERS[name](text) for name, text in chosen.items() if name in _PARSERS}
    if "footer" in chosen:
        chosen["footer"] = False
    if given["theme"] is Theme.DARK and given["film"] != FilmFormat.HTML:
        chosen["theme"] = Theme.DARK
    return FilmOptions(**chosen)


@in_command_words()
def check_film(
    scenes: Sequence[Scene],
    options: FilmOptions,
    file_format: str,  # ending of the name of the file, without its dot
) -> None:
    """Check before a simulation what its film will not take, so that no run is lost."""
    from governor_mechanism.render.film.options import VIDEO_SUFFIXES, require_suitable_options, require_video_writer
    from governor_mechanism.render.film.timing import select_slow_down, select_time_span

    suffix = f".{file_format}"
    if suffix in VIDEO_SUFFIXES:
        require_video_writer(suffix)
    for scene in scenes:
        _check_names(scene, options)
    require_suitable_options(options, scenes, suffix)
    limits = 0.0, max(scene.run.duration for scene in scenes)
    select_slow_down(limits, select_time_span(limits, options.start, options.stop), options.slow_down)


def _check_names(scene: Scene, options: FilmOptions) -> None:
    """Raise MechanismError if a scene has no such part, or no such reading."""
    part = options.part
    parts = [one.name for one in scene.parts]
    if part is not None and part not in parts:
        raise MechanismError(f"--part: the scene has no part {part!r}; its parts are {', '.join(parts)}.{did_you_mean(part, parts)}")
    if not options.readings:
        return
    from governor_mechanism.render.shown_readings import RATE_START, valve_reading_names

    names = [one.name for one in scene.describe().readings]
    names += [f"{RATE_START}{name}" for name in names] + [name for name in valve_reading_names(scene) if name not in names]
    for name in options.readings:
        if name not in names:
            raise MechanismError(
                f"--readings: {scene.title!r} has no reading {name!r}; it has {', '.join(names)}.{did_you_mean(name, names)}"
            )


TEMPLATES = (
    "custom",
    "flywheel_engine",
    "governed-engine",
    "hartnell",
    "hartung",
    "parabolic_governor",
    "pendulum_governor",
    "proell",
    "slide_valve",
    "slider_crank",
    "stephenson",
)
"""What `init` writes; a test compares it with the registry of machines, which is slow to import."""


def complete_scene(incomplete: str) -> list[str]:
    """Return the shipped scenes, and the scene files and folders of the file system, that begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes, shipped_scenes

    names = [name for name in (*shipped_scenes(), *catalogue_scenes()) if name.startswith(incomplete)]
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") else typed.parent
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return names
    paths = [f"{entry}/" if entry.is_dir() else str(entry) for entry in entries if entry.is_dir() or entry.suffix == ".toml"]
    return names + [path for path in paths if path.startswith(incomplete)]


def complete_machine(incomplete: str) -> list[str]:
    """Return machines and classic mechanisms for which there is a scene file to begin with, and whose names begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes

    return [name for name in (*TEMPLATES, *catalogue_scenes()) if name.startswith(incomplete)]


SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.", autocompletion=complete_scene)
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help='Another value of a key of the scene, as "dimensions.arm=320 mm"; nothing after = leaves the key out. Repeatable.',
    ),
]


def load_changed(
    scene: str,
    changes: Sequence[str] | None,  # texts "KEY=VALUE" with dotted keys; an empty value leaves the key out
    **values: Any,
) -> Scene:
    """Load a scene and put other values at some of its keys.

    Further arguments are values at keys that have options of their own, with "__" for the dot, as `run__duration`; None for no change.

    Result: the scene. It keeps the name of its file. Raises MechanismError if a text is no assignment, a key
    is given twice, or the changed scene has mistakes.
    """
    assigned = parse_changes(changes or ())
    assigned |= {name.replace("__", "."): value for name, value in values.items() if value is not None}
    loaded = gm.load(scene)
    return dataclasses.replace(loaded.replace(assigned), source=loaded.source) if assigned else loaded


def parse_changes(
    # texts "KEY=VALUE". A value is written as in a scene file; text needs no quotation marks
    changes: Sequence[str],
) -> dict[str, Any]:
    """Return the values of assignments by dotted key; None for an empty one."""
    from governor_mechanism.errors import MechanismError

    values: dict[str, Any] = {}
    for change in changes:
        key, equals, text = (word.strip() for word in change.partition("="))
        if not equals or not all(key.split(".")):
            raise MechanismError(f'--set {change!r} is not understood; write KEY=VALUE, as in --set "dimensions.arm=320 mm"')
        if key in values:
            raise MechanismError(f"--set {key} is given twice; give it once")
        values[key] = parse_value(text) if text else None
    return values


def parse_value(text: str) -> Any:
    """Return a value as a scene file has it, or the text itself where that is no value of TOML, as 320mm."""
    try:
        document: Mapping[str, Any] = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # text without quotation marks
        return text
    return document["value"] if len(document) == 1 else text


def parse_range(text: str) -> Mapping[str, tuple[float | str, float | str]]:
    """Return both values of a working range "READING=LOW:HIGH" by its reading; raise MechanismError for another text."""
    from governor_mechanism.errors import MechanismError
    from governor_mechanism.units.quantities import number_or_text

    name, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and name.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--range {text!r} is not understood; write "READING=LOW:HIGH", as in "sleeve_lift=20 mm:60 mm"')
    return {name.strip(): (number_or_text(low), number_or_text(high))}


def stem_of(scene: Scene) -> str:
    """Return the start of the names of files about a scene."""
    return Path(scene.source).stem or "scene"
