"""Films of runs, rendered off-screen: GIF, animated SVG, or a video if ffmpeg is available; or an interactive page.

A second of film is a second of the run, except for very short or long runs; the caption then states how much the film is slowed or sped up.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figure_files import Theme
from governor_mechanism.render.film.encoders import FilmFrames, OpenEncoder, open_gif, open_svg, open_video, open_webm
from governor_mechanism.render.film.frame_data import find_parts
from governor_mechanism.render.film.frame_schedules import Schedule, schedule_equal_steps, schedule_frames, schedule_video_frames
from governor_mechanism.render.film.gif_frame_rate import choose_gif_settings
from governor_mechanism.render.film.options import (
    FilmLayout,
    FilmView,
    make_film_options,
    require_drawing_options,
    require_page_options,
    require_room_options,
    require_view,
)
from governor_mechanism.render.film.painters import find_engine_room, make_painter
from governor_mechanism.render.film.timing import Timing, select_room_timing, select_slow_down, select_time_span, select_timing
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.machines.engine_room.settling import settled_time
from governor_mechanism.render.shown_readings import chosen_readings
from governor_mechanism.units.arguments import FLAG, NUMBER, PATH, TEXT, check_arguments
from governor_mechanism.units.quantities import format_value

FilmProgress = Callable[[int, int], None]
"""Called with the number of frames done and in total."""

DEFAULT_FRAME_RATE = 25.0
"""Frames per second, 1/s."""
MAX_SMOOTH_GIF_DURATION, LONG_GIF_FRAME_RATE = 8.0, 12.5
"""Longest GIF (s) of the default frame rate, and the frame rate (1/s) of a longer one, for a file of less than 700 kB."""
MAX_TRUE_TIME_PAGE_DURATION = 100.0
"""Longest run (s) that a page shows in true time at first: one can go on in it at any time, and it keeps 30 moments a second."""
MAX_RUNS = 6
"""Largest number of runs side by side: six of one part are as wide as the widest screens."""
ENGINE_ROOM_FRAME_RATE = 12.5
"""Frame rate (1/s) of the film of an engine room, for a file of less than 700 kB."""


@check_arguments(
    path=PATH,
    size=NUMBER,
    frames_per_second=NUMBER,
    part=TEXT,
    start=NUMBER,
    stop=NUMBER,
    slow_down=NUMBER,
    layout=TEXT,
    theme=TEXT,
    footer=FLAG,
    labels=FLAG,
    forces=FLAG,
    traces=FLAG,
    view=TEXT,
    exaggerate=NUMBER,
)
def write_film(
    run: Trajectory | Sequence[Trajectory],
    path: str | os.PathLike[str],
    *,
    titles: Sequence[str] | None = None,
    size: int = 480,
    frames_per_second: float | None = None,
    part: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    slow_down: float | None = None,
    layout: str = FilmLayout.MACHINE_AND_PLOTS,
    readings: Sequence[str] | None = None,
    theme: str = Theme.LIGHT,
    footer: bool = True,
    labels: bool = False,
    forces: bool = False,
    traces: bool = False,
    view: str = FilmView.PLANE,
    exaggerate: float = 1.0,
    progress: FilmProgress | None = None,
) -> Path:
    """Write one run, or several side by side, as a film.

    Parameters
    ----------
    run
        A run, or a list of up to MAX_RUNS. Runs share the axes of their readings and, if their machines are of like kind and size, their
        scale. A run that ends before the others rests in its last position, and says when it ended.
    path
        File that ends in .gif, .mp4, .webm, .svg or .html; .mp4 and .webm need imageio-ffmpeg, .svg is an animated drawing, and .html is an
        interactive page of one run.
    titles
        Titles of several runs. None takes the titles of their scenes.
    size
        Height of the film in pixels, and its width per run of one part; at least 320. A page fits its window.
    frames_per_second
        Frames per second of film, 1 to 50. None is 25, and 12.5 for an engine room; a GIF that would exceed 700 kB (480 pixels high) takes
        a lower rate, down to 10. A page has none of its own.
    part
        Name of the part to show. None shows all parts, each in a panel of its own; an engine and the governor that it drives, and that
        controls it, are shown as one elevation of an engine room.
    start
        Start of the shown part of the runs, s. None is the first reported time.
    stop
        End of the shown part of the runs, s. None is the last reported time of any. By default, the film of a run that is periodic to its
        end closes on its last whole turn or period, so that it repeats without a jump; without a start, the film of an engine room ends
        soon after the governor has settled, and says so. A page shows the whole run.
    slow_down
        Seconds of film per second of the run; 1 is true time. None is true time for runs of 1 to 60 s; shorter runs are slowed and longer
        ones sped up to a film of 4 to 20 s. A crank that would make a turn in fewer than 20 frames is slowed further, and of a long run the
        first turns are shown. The film of an engine room is sped up by a whole number to at most 10 s.
        A page begins as its run is long, but in true time up to 100 s.
    layout
        "machine" alone, "machine+plots" in a square, or "wide": 16:9 with the plots beside.
    readings
        Names of up to 4 plotted readings, or "rate of ..."; None for those that suit the machine.
    theme
        Colours: "light" or "dark". A page follows the reader's screen.
    footer
        Whether the last line states accuracy and engine; an early end of the run is always stated.
    labels
        Whether the parts and the angle of the leading reading are named.
    forces
        Whether the forces on the bodies are drawn: weight, centrifugal force, springs and dampers.
    traces
        Whether the paths of the mass centres are drawn.
    view
        How parts that turn with a spindle are seen: "plane" for the turning plane, "outside" for the turning governor from the side, or
        "both". A spindle that would make a turn in fewer than 10 frames is then slowed as a crank is. A film closes on the motion in the
        plane; the rotation of the spindle may jump there.
    exaggerate
        Magnification of the motion about its mean position, at least 1, for motions too small to be seen; the plots stay true. The scene
        must have one part whose positions follow one free coordinate.
    progress
        Called as ``progress(done, total)`` after each frame; once for a page.

    Returns
    -------
    Path
        Path of the film. No file is left behind if an exception is raised.

    Raises
    ------
    MechanismError
        If the path, the runs, the titles or an option is not valid, or ffmpeg is missing for .mp4 or .webm.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in (*FILM_FORMATS, PAGE_SUFFIX):
        raise MechanismError(f"a film's name must end in .gif or .mp4, .webm or .svg, or in .html for a page; got {target.name!r}")
    if suffix in VIDEO_SUFFIXES:
        require_video_writer(suffix)
    options = make_film_options(
        layout, readings, theme, footer=footer, labels=labels, forces=forces, traces=traces, view=view, exaggerate=exaggerate
    )
    runs = tuple(run) if isinstance(run, list | tuple) else (run,)
    if not all(isinstance(one, Trajectory) for one in runs):
        raise MechanismError(f"a film shows a run, as from gm.run, or a list of several; found {format_value(run)}")
    _check_runs(runs, titles)
    for one in runs:
        chosen_readings(one, options.readings)
    if suffix == ".svg" and len(runs) > 1:
        raise MechanismError(f"an animated drawing shows one run; got {len(runs)}; write one for each, or a .gif of all")
    if suffix == PAGE_SUFFIX:
        if len(runs) > 1:
            raise MechanismError(f"a page shows one run; got {len(runs)}; write a page for each, or a .gif of all")
        require_page_options(frames_per_second, options)
        limits = float(runs[0].times[0]), float(runs[0].times[-1])
        time_span = select_time_span(limits, start, stop)
        slow_factor = select_slow_down(limits, time_span, slow_down, MAX_TRUE_TIME_PAGE_DURATION)
        return _write_page(runs[0], target, part, time_span, slow_factor, progress)
    shows_rotation = options.view is not FilmView.PLANE
    if suffix == ".svg":
        require_drawing_options(options)
    governed = find_engine_room(runs, part)
    schedule, open_encoder = FILM_FORMATS[suffix]
    if governed is None:
        require_view([shown for one in runs for shown in find_parts(one, part)], options.view)
        timing = select_timing(runs, part, start, stop, slow_down, DEFAULT_FRAME_RATE, shows_rotation=shows_rotation)
    else:
        require_room_options(options)
        settled = settled_time(runs[0], governed) if start is None and stop is None else stop
        timing = select_room_timing(runs[0], start, settled, slow_down)
    chosen_rate = _choose_frame_rate(suffix, timing, is_engine_room=governed is not None)
    frame_rate = chosen_rate if frames_per_second is None else frames_per_second
    with atomic_write(target) as temporary:
        times, delays = schedule(*timing.time_span, frame_rate, timing.slow_down)
        painter = make_painter(runs, part, timing.time_span, times, timing.slow_down, size, titles, options)
        film = FilmFrames(painter=painter, delays=delays, frame_rate=frame_rate, theme=options.theme)
        if suffix == ".gif" and frames_per_second is None:
            fitting_rate, few_colours = choose_gif_settings(film, timing.lowest_frame_rate if slow_down is None else 0.0)
            if fitting_rate < frame_rate:
                times, delays = schedule(*timing.time_span, fitting_rate, timing.slow_down)
                painter = make_painter(runs, part, timing.time_span, times, timing.slow_down, size, titles, options)
            film = replace(film, painter=painter, delays=delays, frame_rate=fitting_rate, few_colours=few_colours)
        with open_encoder(temporary, film) as add_frame:
            for k, delay in enumerate(delays):
                add_frame(k, delay)
                if progress is not None:
                    progress(k + 1, len(delays))
    return target


def _choose_frame_rate(suffix: str, timing: Timing, *, is_engine_room: bool) -> float:
    """Return the frame rate (1/s) of a film for which none is requested: a lower one for large files."""
    if is_engine_room:
        return ENGINE_ROOM_FRAME_RATE
    duration = (timing.time_span[1] - timing.time_span[0]) * timing.slow_down
    is_long = suffix == ".gif" and duration > MAX_SMOOTH_GIF_DURATION and not timing.has_whole_turns
    return LONG_GIF_FRAME_RATE if is_long else DEFAULT_FRAME_RATE


def _write_page(run: Trajectory, target: Path, part: str | None, time_span: Vec2, slow_down: float, progress: FilmProgress | None) -> Path:
    """Write a run as an interactive page."""
    from governor_mechanism.render.page.writer import write_page

    write_page(run, target, part=part, time_span=time_span, slow_down=slow_down)
    if progress is not None:
        progress(1, 1)
    return target


def require_video_writer(suffix: str = ".mp4") -> None:
    """Check that videos can be written; call it before long work.

    Parameters
    ----------
    suffix
        Ending of the file's name.

    Raises
    ------
    MechanismError
        If imageio-ffmpeg is not installed.
    """
    try:
        import_module("imageio_ffmpeg")
    except ImportError as missing:
        raise MechanismError(f"writing {suffix} needs ffmpeg: pip install imageio-ffmpeg, or write a .gif") from missing


def _check_runs(runs: Sequence[Trajectory], titles: Sequence[str] | None) -> None:
    """Raise MechanismError unless there are some runs with reported times, and as many titles if there are any."""
    if not 1 <= len(runs) <= MAX_RUNS:
        raise MechanismError(f"a film shows one run, or up to {MAX_RUNS} side by side; got {len(runs)}")
    if titles is not None and len(runs) == 1:
        raise MechanismError("titles are for a film of several runs; one run takes the title of its scene")
    if titles is not None and not (isinstance(titles, list | tuple) and list(map(type, titles)) == [str] * len(runs)):
        raise MechanismError(f"titles must be a list of {len(runs)} texts, one for each run; got {format_value(titles)}")
    for position, run in enumerate(runs, start=1):
        if not len(run.times):
            which = "the run" if len(runs) == 1 else f"run {position}, {run.scene.title!r},"
            raise MechanismError(f"{which} has no reported time, so there is nothing to show; its message: {run.message}")


PAGE_SUFFIX = ".html"
"""Ending of the name of an interactive page."""
VIDEO_SUFFIXES = (".mp4", ".webm")
"""Endings of the names of videos, which need ffmpeg."""
FILM_FORMATS: dict[str, tuple[Schedule, OpenEncoder]] = {
    ".gif": (schedule_frames, open_gif),
    ".mp4": (schedule_video_frames, open_video),
    ".webm": (schedule_video_frames, open_webm),
    ".svg": (schedule_equal_steps, open_svg),
}
"""Schedule and encoder by the ending of the file's name."""
