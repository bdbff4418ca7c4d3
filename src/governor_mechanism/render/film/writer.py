"""Films of runs, rendered off-screen: GIF, animated SVG, or a video if ffmpeg is available; or an interactive page.

A second of film is a second of the run, except for very short or long runs; the caption then states how much the film is slowed or sped up.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.results.film_options import DEFAULT_OPTIONS, FilmOptions, FilmView
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.film.encoders import FilmFrames, OpenEncoder, open_gif, open_svg, open_video, open_webm
from governor_mechanism.render.film.frame_data import find_parts
from governor_mechanism.render.film.frame_schedules import Schedule, schedule_equal_steps, schedule_frames, schedule_video_frames
from governor_mechanism.render.film.gif_frame_rate import choose_gif_settings
from governor_mechanism.render.film.options import (
    PAGE_SUFFIX,
    VIDEO_SUFFIXES,
    find_engine_room,
    require_suitable_options,
    require_video_writer,
)
from governor_mechanism.render.film.painters import make_painter
from governor_mechanism.render.film.timing import Timing, select_room_timing, select_slow_down, select_time_span, select_timing
from governor_mechanism.render.machines.engine_room.settling import settled_time
from governor_mechanism.render.shown_readings import chosen_readings
from governor_mechanism.units.arguments import PATH, check_arguments
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


@check_arguments(path=PATH)
def write_film(
    run: Trajectory | Sequence[Trajectory],
    path: str | os.PathLike[str],
    options: FilmOptions = DEFAULT_OPTIONS,
    *,
    titles: Sequence[str] | None = None,
    progress: FilmProgress | None = None,
) -> Path:
    """Write one run, or several side by side, as a film.

    `gm.film` documents the parameters, the result and the errors. No file is left behind if an exception is raised.
    """
    request = _Request(target=_require_target(path), runs=_require_runs(run, titles), titles=titles, options=options, progress=progress)
    request.require_names()
    require_suitable_options(options, request.scenes, request.suffix)
    if request.suffix == PAGE_SUFFIX:
        return _write_page(request)
    timing = _choose_timing(request)
    with atomic_write(request.target) as temporary:
        _encode(_make_frames(request, timing), temporary, request)
    return request.target


@dataclass(frozen=True, kw_only=True)
class _Request:
    """What is to be written, with the arguments of `write_film`; `target` has one of the known endings."""

    target: Path
    runs: Sequence[Trajectory]
    titles: Sequence[str] | None
    options: FilmOptions
    progress: FilmProgress | None

    @property
    def suffix(self) -> str:
        """Ending of the name of the file."""
        return self.target.suffix.lower()

    @property
    def scenes(self) -> Sequence[Scene]:
        """Scenes of the runs."""
        return [one.scene for one in self.runs]

    def require_names(self) -> None:
        """Check that all runs have the chosen readings and the chosen part."""
        for one in self.runs:
            chosen_readings(one, self.options.readings)
            find_parts(one, self.options.part)


def _require_target(path: str | os.PathLike[str]) -> Path:
    """Return the path of the file; raise MechanismError unless films of its ending can be written."""
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in (*FILM_FORMATS, PAGE_SUFFIX):
        raise MechanismError(f"a film's name must end in .gif or .mp4, .webm or .svg, or in .html for a page; got {target.name!r}")
    if suffix in VIDEO_SUFFIXES:
        require_video_writer(suffix)
    return target


def _require_runs(run: Trajectory | Sequence[Trajectory], titles: Sequence[str] | None) -> Sequence[Trajectory]:
    """Return the runs; raise MechanismError unless there are some with reported times, and as many titles if there are any."""
    runs = tuple(run) if isinstance(run, list | tuple) else (run,)
    if not all(isinstance(one, Trajectory) for one in runs):
        raise MechanismError(f"a film shows a run, as from gm.run, or a list of several; found {format_value(run)}")
    if not 1 <= len(runs) <= MAX_RUNS:
        raise MechanismError(f"a film shows one run, or up to {MAX_RUNS} side by side; got {len(runs)}")
    if titles is not None and len(runs) == 1:
        raise MechanismError("titles are for a film of several runs; one run takes the title of its scene")
    if titles is not None and not (isinstance(titles, list | tuple) and list(map(type, titles)) == [str] * len(runs)):
        raise MechanismError(f"titles must be a list of {len(runs)} texts, one for each run; got {format_value(titles)}")
    for position, one in enumerate(runs, start=1):
        if not len(one.times):
            which = "the run" if len(runs) == 1 else f"run {position}, {one.scene.title!r},"
            raise MechanismError(f"{which} has no reported time, so there is nothing to show; its message: {one.message}")
    return runs


def _write_page(request: _Request) -> Path:
    """Write a run as an interactive page."""
    from governor_mechanism.render.page.writer import write_page  # slow to import, and only for pages

    options = request.options
    (run,) = request.runs
    limits = float(run.times[0]), float(run.times[-1])
    time_span = select_time_span(limits, options.start, options.stop)
    slow_down = select_slow_down(limits, time_span, options.slow_down, MAX_TRUE_TIME_PAGE_DURATION)
    write_page(run, request.target, part=options.part, time_span=time_span, slow_down=slow_down)
    if request.progress is not None:
        request.progress(1, 1)
    return request.target


def _choose_timing(request: _Request) -> Timing:
    """Return which part of the runs is shown, and how fast."""
    runs, options = request.runs, request.options
    governed = find_engine_room(request.scenes, options.part)
    if governed is not None:
        settled = settled_time(runs[0], governed) if options.start is None and options.stop is None else options.stop
        return select_room_timing(runs[0], options.start, settled, options.slow_down)
    shows_rotation = options.view is not FilmView.PLANE
    timing = options.start, options.stop, options.slow_down
    return select_timing(runs, options.part, *timing, DEFAULT_FRAME_RATE, shows_rotation=shows_rotation)


def _make_frames(request: _Request, timing: Timing) -> FilmFrames:
    """Return the frames of the film; those of a GIF at the rate that keeps its file small if none is requested."""
    requested = request.options.frames_per_second
    film = _frames_at(request, timing, _choose_frame_rate(request, timing) if requested is None else requested)
    if request.suffix != ".gif" or requested is not None:
        return film
    rate, few_colours = choose_gif_settings(film, timing.lowest_frame_rate if request.options.slow_down is None else 0.0)
    return replace(film if rate == film.frame_rate else _frames_at(request, timing, rate), few_colours=few_colours)


def _frames_at(request: _Request, timing: Timing, frame_rate: float) -> FilmFrames:
    """Return the frames of the film at a rate, 1/s."""
    schedule, _ = FILM_FORMATS[request.suffix]
    times, delays = schedule(*timing.time_span, frame_rate, timing.slow_down)
    painter = make_painter(request.runs, timing.time_span, times, timing.slow_down, request.options, request.titles)
    return FilmFrames(painter=painter, delays=delays, frame_rate=frame_rate, theme=request.options.theme)


def _encode(film: FilmFrames, path: Path, request: _Request) -> None:
    """Write frames into a file, and report progress."""
    _, open_encoder = FILM_FORMATS[request.suffix]
    with open_encoder(path, film) as add_frame:
        for k, delay in enumerate(film.delays):
            add_frame(k, delay)
            if request.progress is not None:
                request.progress(k + 1, len(film.delays))


def _choose_frame_rate(request: _Request, timing: Timing) -> float:
    """Return the frame rate (1/s) of a film for which none is requested: a lower one for large files."""
    if find_engine_room(request.scenes, request.options.part) is not None:
        return ENGINE_ROOM_FRAME_RATE
    duration = (timing.time_span[1] - timing.time_span[0]) * timing.slow_down
    is_long = request.suffix == ".gif" and duration > MAX_SMOOTH_GIF_DURATION and not timing.has_whole_turns
    return LONG_GIF_FRAME_RATE if is_long else DEFAULT_FRAME_RATE


FILM_FORMATS: dict[str, tuple[Schedule, OpenEncoder]] = {
    ".gif": (schedule_frames, open_gif),
    ".mp4": (schedule_video_frames, open_video),
    ".webm": (schedule_video_frames, open_webm),
    ".svg": (schedule_equal_steps, open_svg),
}
"""Schedule and encoder by the ending of the file's name."""
