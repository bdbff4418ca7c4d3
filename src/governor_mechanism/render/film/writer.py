"""Films of runs, rendered off-screen: GIF, or MP4 if ffmpeg is available; or an interactive page.

A second of film is a second of the run, except for very short or long runs; the caption then states how much the film is slowed or sped up.
"""

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette, RgbaPixels
from governor_mechanism.render.film.painters import Painter, find_engine_room, make_painter
from governor_mechanism.render.geometry.primitives import Vec2, round_step
from governor_mechanism.render.machines.engine_room.settling import settled_time
from governor_mechanism.render.style import FILM_COLOURS, parse_rgb
from governor_mechanism.types import FloatArray
from governor_mechanism.units.arguments import NUMBER, PATH, TEXT, check_arguments
from governor_mechanism.units.quantities import format_value

FilmProgress = Callable[[int, int], None]
"""Called with the number of frames done and in total."""
FrameSchedule = tuple[FloatArray, list[int]]
"""Times of the frames (s) and the display time of each in hundredths of a second."""
AddFrame = Callable[[RgbaPixels, int], None]
"""Append a frame with its display time in hundredths of a second to a file."""

DEFAULT_FRAME_RATE = 25.0
"""Frames per second, 1/s."""
MAX_FRAME_RATE = 50
"""Largest frame rate (1/s): viewers show a GIF frame of less than 2 hundredths of a second far too long."""
N_PALETTE_SAMPLES = 5
"""Number of frames from which the palette is chosen."""
MIN_TRUE_TIME_DURATION, MAX_TRUE_TIME_DURATION = 1.0, 60.0
"""Range of run durations (s) that are shown in true time by default."""
MAX_TRUE_TIME_PAGE_DURATION = 100.0
"""Longest run (s) that a page shows in true time at first: one can go on in it at any time, and it keeps 30 moments a second."""
MIN_FILM_DURATION, MAX_FILM_DURATION = 4.0, 20.0
"""Range of film durations (s) for all other runs."""
MAX_SLOWED_FILM_DURATION = 3600.0
"""Longest film (s) with a requested slow-down."""
MAX_RUNS = 6
"""Largest number of runs side by side: six of one part are as wide as the widest screens."""


ENGINE_ROOM_FRAME_RATE, ENGINE_ROOM_FILM_DURATION = 12.5, 10.0
"""Frame rate (1/s) and longest default duration (s) of the film of an engine room: a file of less than 700 kB."""


@check_arguments(path=PATH, size=NUMBER, frames_per_second=NUMBER, part=TEXT, start=NUMBER, stop=NUMBER, slow_down=NUMBER)
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
    progress: FilmProgress | None = None,
) -> Path:
    """Write one run, or several side by side, as a film.

    Parameters
    ----------
    run
        A run, or a list of up to MAX_RUNS. Runs share the axes of their readings and, if their machines are of like kind and size, their
        scale. A run that ends before the others rests in its last position, and says when it ended.
    path
        File that ends in .gif, .mp4 or .html; .mp4 needs imageio-ffmpeg, and .html is an interactive page of one run.
    titles
        Titles of several runs. None takes the titles of their scenes.
    size
        Height of the film in pixels, and its width per run of one part; at least 320. A page fits its window.
    frames_per_second
        Frames per second of film, 1 to 50. None is 25, and 12.5 for an engine room. A page has none of its own.
    part
        Name of the part to show. None shows all parts, each in a panel of its own; an engine and the governor that it drives, and that
        controls it, are shown as one elevation of an engine room.
    start
        Start of the shown part of the runs, s. None is the first reported time.
    stop
        End of the shown part of the runs, s. None is the last reported time of any; without a start, the film of an engine room ends soon
        after the governor has settled, and says so. A page shows the whole run.
    slow_down
        Seconds of film per second of the run; 1 is true time. None is true time for runs of 1 to 60 s; shorter runs are slowed and longer
        ones sped up to a film of 4 to 20 s. The film of an engine room is sped up by a whole number to at most 10 s.
        A page begins so, but in true time up to 100 s.
    progress
        Called as ``progress(done, total)`` after each frame; once for a page.

    Returns
    -------
    Path
        Path of the film. No file is left behind if an exception is raised.

    Raises
    ------
    MechanismError
        If the path, the runs, the titles or a number is not valid, or ffmpeg is missing for .mp4.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in (*FILM_FORMATS, PAGE_SUFFIX):
        raise MechanismError(f"a film's name must end in .gif or .mp4, or in .html for a page; got {target.name!r}")
    if suffix == ".mp4":
        require_video_writer()
    runs = tuple(run) if isinstance(run, list | tuple) else (run,)
    if not all(isinstance(one, Trajectory) for one in runs):
        raise MechanismError(f"a film shows a run, as from gm.run, or a list of several; found {format_value(run)}")
    _check_runs(runs, titles)
    if suffix == PAGE_SUFFIX:
        _require_page_options(runs, frames_per_second)
    governed = find_engine_room(runs, part)
    is_engine_room = governed is not None
    if governed and start is None and stop is None and suffix in FILM_FORMATS:
        stop = settled_time(runs[0], governed)
    limits = min(float(one.times[0]) for one in runs), max(float(one.times[-1]) for one in runs)
    time_span = _select_time_span(limits, start, stop)
    if suffix == PAGE_SUFFIX:
        slow_factor = _select_slow_down(limits, time_span, slow_down, False, MAX_TRUE_TIME_PAGE_DURATION)
        return _write_page(runs[0], target, part, time_span, slow_factor, progress)
    slow_factor = _select_slow_down(limits, time_span, slow_down, is_engine_room)
    schedule, open_encoder = FILM_FORMATS[suffix]
    default_rate = ENGINE_ROOM_FRAME_RATE if is_engine_room else DEFAULT_FRAME_RATE
    frame_rate = default_rate if frames_per_second is None else frames_per_second
    with atomic_write(target) as temporary:
        times, delays = schedule(*time_span, frame_rate, slow_factor)
        painter = make_painter(runs, part, time_span, times, slow_factor, size, titles)
        with open_encoder(temporary, painter, len(delays), frame_rate) as add_frame:
            for k, delay in enumerate(delays):
                add_frame(painter.draw(k), delay)
                if progress is not None:
                    progress(k + 1, len(delays))
    return target


def _require_page_options(runs: Sequence[Trajectory], frames_per_second: float | None) -> None:
    """Raise MechanismError unless there is one run and no frame rate: what a page shows."""
    if len(runs) > 1:
        raise MechanismError(f"a page shows one run; got {len(runs)}; write a page for each, or a .gif of all")
    if frames_per_second is not None:
        raise MechanismError("a page draws as often as the screen does and takes no frames per second; leave them out")


def _write_page(run: Trajectory, target: Path, part: str | None, time_span: Vec2, slow_down: float, progress: FilmProgress | None) -> Path:
    """Write a run as an interactive page."""
    from governor_mechanism.render.page.writer import write_page

    write_page(run, target, part=part, time_span=time_span, slow_down=slow_down)
    if progress is not None:
        progress(1, 1)
    return target


def require_video_writer() -> None:
    """Check that films can be written as .mp4; call it before long work.

    Raises
    ------
    MechanismError
        If imageio-ffmpeg is not installed.
    """
    try:
        import_module("imageio_ffmpeg")
    except ImportError as missing:
        raise MechanismError("writing .mp4 needs ffmpeg: pip install imageio-ffmpeg, or write a .gif") from missing


def choose_slow_down(duration: float) -> float:
    """Return the slow-down factor for a duration (s): 1 from 1 to 60 s, else a factor that gives a film of 4 to 20 s.

    The factor or its reciprocal is 1, 2 or 5 x 10^n.
    """
    if MIN_TRUE_TIME_DURATION <= duration <= MAX_TRUE_TIME_DURATION or duration <= 0.0:
        return 1.0
    if duration < MIN_TRUE_TIME_DURATION:
        return round_step(MIN_FILM_DURATION / duration, 1)
    return 1.0 / round_step(duration / MAX_FILM_DURATION, 1)


def schedule_frames(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> FrameSchedule:
    """Return the frames of a film whose frames may last differently long.

    The display times add up to `slow_down` times the shown duration. Each frame is shown from half a step before its time to half a step
    after it, so the first and the last frame are shown half as long as the others.
    """
    if not 1 <= frames_per_second <= MAX_FRAME_RATE:
        raise MechanismError(f"frames_per_second must be 1..{MAX_FRAME_RATE}; got {frames_per_second:g}")
    hundredths = max(round((stop - start) * slow_down * 100), 1)
    steps = round(hundredths / 100 * frames_per_second)
    if steps < 1:
        return np.array([start]), [hundredths]
    times = np.linspace(start, stop, steps + 1)
    edges = [0, *(round(hundredths * (k + 0.5) / steps) for k in range(steps)), hundredths]
    return times, [end_edge - start_edge for start_edge, end_edge in pairwise(edges)]


def schedule_video_frames(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> FrameSchedule:
    """Return one frame at the middle of each step: every frame of a video lasts equally long."""
    duration = (stop - start) * slow_down
    count = max(round(duration * frames_per_second), 1)
    return start + (stop - start) * (np.arange(count) + 0.5) / count, [round(100 * duration / count)] * count


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


def _select_time_span(limits: Vec2, start: float | None, stop: float | None) -> Vec2:
    """Return the validated start and end (s) of the shown part within the times of the runs (s)."""
    first, last = limits
    begin, end = (first if start is None else start), (last if stop is None else stop)
    if not first <= begin <= end <= last:
        raise MechanismError(f"start and stop must lie within the run, {first:g}..{last:g} s, in this order; got {begin:g} and {end:g} s")
    return begin, end


def _select_slow_down(
    limits: Vec2, time_span: Vec2, requested: float | None, is_engine_room: bool, longest_true_time: float = MAX_TRUE_TIME_DURATION
) -> float:
    """Return the validated slow-down factor, as requested or chosen from the duration.

    `limits` are the times of the runs (s); runs of up to `longest_true_time` (s) are shown in true time.
    """
    begin, end = time_span
    if requested is None and is_engine_room and end - begin > ENGINE_ROOM_FILM_DURATION:
        return 1.0 / math.ceil((end - begin) / ENGINE_ROOM_FILM_DURATION)
    if requested is None:
        # If the whole run is shown in true time, so is any part of it, however short.
        return 1.0 if MIN_TRUE_TIME_DURATION <= limits[1] - limits[0] <= longest_true_time else choose_slow_down(end - begin)
    if not (math.isfinite(requested) and requested > 0.0):
        raise MechanismError(f"slow_down must be a number above 0; got {requested:g}")
    if (end - begin) * requested > MAX_SLOWED_FILM_DURATION:
        raise MechanismError(
            f"slow_down {requested:g} makes a film of {(end - begin) * requested:g} s; at most {MAX_SLOWED_FILM_DURATION:g} s"
        )
    return requested


@contextmanager
def _open_gif(path: Path, painter: Painter, n_frames: int, frame_rate: float) -> Iterator[AddFrame]:
    """Open a GIF; its palette is chosen from a few frames."""
    samples = [painter.paint(int(k)) for k in np.unique(np.linspace(0, n_frames - 1, N_PALETTE_SAMPLES).astype(int))]
    with path.open("wb") as file:
        writer = GifWriter(file, Palette([parse_rgb(colour) for colour in FILM_COLOURS], samples))
        yield writer.add
        writer.close()


@contextmanager
def _open_video(path: Path, painter: Painter, n_frames: int, frame_rate: float) -> Iterator[AddFrame]:
    """Open an MP4."""
    import imageio.v2 as imageio

    with cast(Any, imageio).get_writer(path, format="FFMPEG", fps=frame_rate, codec="libx264", quality=8, macro_block_size=2) as writer:

        def add_frame(pixels: RgbaPixels, delay: int) -> None:
            # The codec needs an even number of rows and columns.
            rows, columns = pixels.shape[0] % 2, pixels.shape[1] % 2
            writer.append_data(np.pad(pixels[..., :3], ((0, rows), (0, columns), (0, 0)), mode="edge"))

        yield add_frame


PAGE_SUFFIX = ".html"
"""Ending of the name of an interactive page."""
FILM_FORMATS = {".gif": (schedule_frames, _open_gif), ".mp4": (schedule_video_frames, _open_video)}
"""Schedule and encoder by the ending of the file's name."""
