"""Options of films on the command line, the same for every command that writes one. Nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any

import typer

from governor_mechanism.cli.given_options import refuse_idle_options
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film.options import (
    FilmLayout,
    FilmOptions,
    FilmView,
    make_film_options,
    require_drawing_options,
    require_page_options,
    require_room_options,
    require_view,
)
from governor_mechanism.render.film_option_error import PYTHON_WORDS, FilmOptionError
from governor_mechanism.units.quantities import number_or_text, parse_quantity

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene

LayoutOption = Annotated[FilmLayout, typer.Option(help="Layout of the film: the machine alone, or with plots in a square or in 16:9.")]
ReadingsOption = Annotated[
    str | None, typer.Option(help='Plotted readings, for example "arm_angle,rate of sleeve_lift"; by default those that suit the machine.')
]
NoFooterOption = Annotated[bool, typer.Option("--no-footer", help="Leave out the line on accuracy and engine at the bottom of the film.")]
LabelsOption = Annotated[bool, typer.Option("--labels", help="Name the parts and the main angle on the film.")]
ForcesOption = Annotated[
    bool, typer.Option("--forces", help="Draw weights, centrifugal forces, springs and dampers as arrows on the film.")
]
ViewOption = Annotated[
    FilmView, typer.Option(help="View of a governor on the film: in its turning plane, from outside while the spindle turns, or both.")
]
ExaggerateOption = Annotated[
    float, typer.Option(help="Magnify the motion about its mean position on the film, for one that is too small to be seen.")
]
PartOption = Annotated[str | None, typer.Option(help="Show this part of the scene on the film; by default all parts.")]
TracesOption = Annotated[bool, typer.Option("--traces", help="Draw the paths of the mass centres on the film.")]
StartOption = Annotated[str | None, typer.Option(help='Start of the film, for example "2 s"; by default that of the run.')]
StopOption = Annotated[str | None, typer.Option(help="End of the film; by default that of the run, or of its last whole turn or period.")]
SlowDownOption = Annotated[
    float | None, typer.Option(help="Seconds of film per second of the run; by default 1, and more for short runs and fast cranks.")
]


_OF_FILMS = (
    *("film", "fps", "size", "layout", "readings", "no_footer", "labels", "forces", "traces", "view", "exaggerate", "part"),
    *("start", "stop", "slow_down"),
)
"""Parameters of a command whose options say how its film looks."""


def refuse_without_film(*, no_film: bool, has_figure: bool) -> None:
    """Raise MechanismError if there is no film, and options of films are given; a figure has a theme too."""
    if no_film:
        refuse_idle_options(*_OF_FILMS, *(() if has_figure else ("theme",)), condition="with --no-film")


COMMAND_WORDS: Mapping[str, str] = {
    **{name: f"--{name.replace('_', '-')}" for name in PYTHON_WORDS},
    "frames_per_second": "--fps",
    "footer": "--no-footer",
    "use_gif": "choose --film gif",
}
"""Words of messages on the command line, by those of Python."""


@contextmanager
def in_command_words() -> Iterator[None]:
    """State mistakes in options of films with the names that these have on the command line: a context, or a decorator.

    Yields
    ------
    None
        Nothing.

    Raises
    ------
    MechanismError
        The mistake.
    """
    try:
        yield
    except FilmOptionError as error:
        raise error.in_words(COMMAND_WORDS) from None


@in_command_words()
def check_film_options(
    scenes: Sequence[Scene], chosen: Mapping[str, Any], frames_per_second: float | None = None, *, file_format: str = "gif"
) -> None:
    """Check before a simulation what its film will not take, so that no run is lost.

    Parameters
    ----------
    scenes
        The scenes whose runs the film shows.
    chosen
        The options by `gather_film_options`.
    frames_per_second
        The frame rate, or None.
    file_format
        Ending of the name of the file, without its dot.

    Raises
    ------
    MechanismError
        If there is no such reading or part, a time is outside of the runs, or the scenes or the format do not take an option.
    """
    timing = {name: chosen[name] for name in ("start", "stop", "slow_down") if name in chosen}
    part = chosen.get("part")
    frame_options = {name: value for name, value in chosen.items() if name not in (*timing, "part")}
    options = make_film_options(**{**_FRAME_DEFAULTS, **frame_options})
    if file_format == PAGE_FORMAT:
        require_page_options(frames_per_second, options)
    elif frames_per_second is not None:
        _check_frame_rate(frames_per_second)
    if file_format == DRAWING_FORMAT:
        require_drawing_options(options)
    for scene in scenes:
        _check_names(scene, part, options)
    require_view([one for scene in scenes for one in scene.parts if part in (None, one.name)], options.view)
    if len(scenes) == 1 and part is None and file_format != PAGE_FORMAT:
        _check_room(scenes[0], options)
    if options.exaggerate != 1.0:
        from governor_mechanism.render.magnified_motion import require_one_coordinate

        for scene in scenes:
            require_one_coordinate(scene)
    if timing:
        _check_timing(max(scene.run.duration for scene in scenes), **timing)


def _parse_names(text: str) -> list[str]:
    """Return the names of readings in a text with commas between, each once."""
    names = dict.fromkeys(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise MechanismError(f"--readings needs names with commas between, as in arm_angle,sleeve_lift; found {text!r}")
    return list(names)


_FRAME_DEFAULTS: Mapping[str, Any] = {"readings": None, **{one.name: one.default for one in fields(FilmOptions) if one.name != "readings"}}
"""Options of the frames of a film by name, of which nothing is chosen."""
PAGE_FORMAT, DRAWING_FORMAT = "html", "svg"
"""Formats of an interactive page and of an animated drawing."""


def _check_names(scene: Scene, part: str | None, options: FilmOptions) -> None:
    """Raise MechanismError if a scene has no such part, or no such reading."""
    parts = [one.name for one in scene.parts]
    if part is not None and part not in parts:
        raise MechanismError(f"--part: the scene has no part {part!r}; its parts are {', '.join(parts)}.{did_you_mean(part, parts)}")
    if not options.readings:
        return
    from governor_mechanism.render.shown_readings import RATE_START
    from governor_mechanism.render.valve_readings import valve_reading_names

    names = [one.name for one in scene.describe().readings]
    names += [f"{RATE_START}{name}" for name in names] + [name for name in valve_reading_names(scene) if name not in names]
    for name in options.readings:
        if name not in names:
            raise MechanismError(
                f"--readings: {scene.title!r} has no reading {name!r}; it has {', '.join(names)}.{did_you_mean(name, names)}"
            )


def _check_room(scene: Scene, options: FilmOptions) -> None:
    """Raise MechanismError if a scene is shown as an engine room, which does not take an option."""
    from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine

    if find_governed_engine(scene):
        require_room_options(options)


def _check_frame_rate(frames_per_second: float) -> None:
    """Raise MechanismError if a frame rate (1/s) is out of range."""
    from governor_mechanism.render.film.frame_schedules import require_frame_rate

    require_frame_rate(frames_per_second)


def _check_timing(duration: float, start: float | None = None, stop: float | None = None, slow_down: float | None = None) -> None:
    """Raise MechanismError if times (s) are outside of runs of a duration (s), or a slow-down is out of range."""
    from governor_mechanism.render.film.timing import select_slow_down, select_time_span

    limits = 0.0, duration
    select_slow_down(limits, select_time_span(limits, start, stop), slow_down)


def gather_film_options(
    *,
    layout: FilmLayout,
    readings: str | None,
    no_footer: bool,
    labels: bool,
    forces: bool,
    traces: bool,
    start: str | None,
    stop: str | None,
    slow_down: float | None,
    theme: Theme,
    view: FilmView = FilmView.PLANE,
    exaggerate: float = 1.0,
    part: str | None = None,
    is_page: bool = False,
) -> Mapping[str, Any]:
    """Return the options of `write_film` by name, without those at their defaults.

    Parameters
    ----------
    layout
        Layout of the film.
    readings
        Names of readings with commas between; None for those that suit the machine.
    no_footer
        Whether to leave out the line on accuracy and engine.
    labels
        Whether to name the parts.
    forces
        Whether to draw the forces.
    traces
        Whether to draw the paths of the mass centres.
    start
        Start of the film as text with a unit, or None.
    stop
        End of the film as text with a unit, or None.
    slow_down
        Seconds of film per second of the run, or None.
    theme
        Theme of the figures; a film takes it if it is dark.
    view
        View of what turns with a spindle.
    exaggerate
        Magnification of the motion.
    part
        Name of the part to show, or None.
    is_page
        Whether the film is an interactive page, which follows the theme of the reader's screen.

    Returns
    -------
    Mapping
        The options.

    Raises
    ------
    MechanismError
        If a time is not understood, or no reading is named.
    """
    times = {
        name: parse_quantity(number_or_text(text), "time", f"--{name}")
        for name, text in (("start", start), ("stop", stop))
        if text is not None
    }
    switches = {"labels": labels, "forces": forces, "traces": traces}
    return {
        **times,
        **{name: True for name, is_on in switches.items() if is_on},
        **({} if slow_down is None else {"slow_down": slow_down}),
        **({} if readings is None else {"readings": _parse_names(readings)}),
        **({"footer": False} if no_footer else {}),
        **({} if layout is FilmLayout.MACHINE_AND_PLOTS else {"layout": layout.value}),
        **({} if view is FilmView.PLANE else {"view": view.value}),
        **({} if exaggerate == 1.0 else {"exaggerate": exaggerate}),
        **({} if part is None else {"part": part}),
        **({"theme": theme.value} if theme is Theme.DARK and not is_page else {}),
    }
