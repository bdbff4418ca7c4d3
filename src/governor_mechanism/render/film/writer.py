"""Makes films of runs, off-screen: GIF, or MP4 where ffmpeg is at hand.

A second of film is a second of the run, but for runs too short or too long to be watched: their caption says by how
much the film is slower or faster.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.effect_state import effect_state_of
from governor_mechanism.render.film.frame_data import find_part, interpolate_frame_data, part_poses_and_velocities
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from governor_mechanism.render.film.layout import ELEVATION_RECT, PixelView, fit_view
from governor_mechanism.render.film.side_by_side import check_run_pair, make_side_by_side
from governor_mechanism.render.geometry.primitives import round_step
from governor_mechanism.render.machines.registry import drawing_bounds
from governor_mechanism.render.style import FILM_COLOURS, parse_rgb
from governor_mechanism.types import FloatArray

FramePixels = NDArray[np.uint8]
FilmProgress = Callable[[int, int], None]
TimeSpan = tuple[float, float]
FilmTiming = tuple[TimeSpan, float, float]
"""The piece of the run (s), how many times slower it is shown, and the frames per second of film."""

MAX_FRAME_RATE = 50
"""Frames per second: viewers show a GIF frame of less than 2 hundredths of a second far too long."""
N_PALETTE_SAMPLES = 5
"""Frames from which the palette is chosen."""
MIN_TRUE_TIME_DURATION, MAX_TRUE_TIME_DURATION = 1.0, 60.0
"""Seconds; a run that lasts as long is shown in true time unless told otherwise."""
MIN_FILM_DURATION, MAX_FILM_DURATION = 4.0, 20.0
"""Seconds; a film of another run lasts at least, or at most, as long."""
MAX_SLOWED_FILM_DURATION = 3600.0
"""Seconds a film may last that is slowed on request."""


class Painter(Protocol):
    """Paints frame after frame."""

    def paint(self, k: int) -> FramePixels:
        """Frame k as RGBA, opaque."""


PainterFactory = Callable[[FloatArray], Painter]


def write_film(
    run: Trajectory | Sequence[Trajectory],
    path: str | os.PathLike[str],
    *,
    titles: Sequence[str] | None = None,
    size: int = 480,
    frames_per_second: float = 25,
    part: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    slow_down: float | None = None,
    progress: FilmProgress | None = None,
) -> Path:
    """Write the run as a film of size x size pixels; a path ending in .mp4 needs imageio-ffmpeg.

    Two runs that report the same times are shown side by side, 2 size x size, equal in scale and in the axes of their
    readings, under `titles`, or their scenes' own.

    A second of the run takes `slow_down` seconds of film: 1 is true time. None is true time for runs of 1 to 60 s;
    shorter ones are slowed and longer ones sped up, so that the film lasts 2 to 20 s. `start` and `stop` (s) cut a
    piece out of the run; `part` names the part shown where the scene has several;
    progress(done, total) is called after every frame. Returns the path. An exception leaves no file behind.
    """
    target = Path(path)
    writers = {".gif": _write_gif, ".mp4": _write_mp4}
    if target.suffix.lower() not in writers:
        raise MechanismError(f"a film's name must end in .gif or .mp4; got {target.name!r}")
    if target.suffix.lower() == ".mp4":
        require_video_writer()
    runs = (run,) if isinstance(run, Trajectory) else tuple(run)
    check_run_pair(runs, titles)
    write, time_span = writers[target.suffix.lower()], _select_time_span(runs[0], start, stop)
    slow_factor = _select_slow_down(runs[0], time_span, slow_down)
    with atomic_write(target) as temporary:
        make_painter = partial(_make_painter, runs, titles, size, part, time_span, slow_factor)
        write(temporary, make_painter, (time_span, slow_factor, frames_per_second), progress or _ignore_progress)
    return target


def require_video_writer() -> None:
    """Raise MechanismError where films cannot be written as .mp4; to be called before long work."""
    try:
        import_module("imageio_ffmpeg")
    except ImportError as missing:
        raise MechanismError("writing .mp4 needs ffmpeg: pip install imageio-ffmpeg, or write a .gif") from missing


def render_frames(
    run: Trajectory,
    *,
    size: int = 480,
    frames_per_second: float = 25,
    part: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    slow_down: float | None = None,
) -> Iterator[FramePixels]:
    """The pictures of a film, (size, size, 3) RGB each, at equal steps from start to stop (both shown)."""
    time_span = _select_time_span(run, start, stop)
    slow_factor = _select_slow_down(run, time_span, slow_down)
    times, _ = schedule_frames(*time_span, frames_per_second, slow_factor)
    painter = _make_frame_painter(run, size, part, time_span, slow_factor, times)
    for k in range(len(times)):
        yield painter.paint(k)[..., :3].copy()


def fit_film_view(run: Trajectory, *, size: int = 480, part: str | None = None) -> PixelView:
    """Where the machine stands in the pictures of a film: `film_view(run).pixel_of(x, y)` is a column and a row."""
    shown_part = find_part(run, part)
    return fit_view(
        drawing_bounds(shown_part, part_poses_and_velocities(run, shown_part)[0], run.times, effect_state_of(run)), ELEVATION_RECT, size
    )


def choose_slow_down(duration: float) -> float:
    """How many times slower to show what lasts so long (s): 1 from 1 to 60 s; else so that the film lasts 2 to 20 s.

    The factor, or what it divides by, is 1, 2 or 5 x 10^n.
    """
    if MIN_TRUE_TIME_DURATION <= duration <= MAX_TRUE_TIME_DURATION or duration <= 0.0:
        return 1.0
    if duration < MIN_TRUE_TIME_DURATION:
        return round_step(MIN_FILM_DURATION / duration, 1)
    return 1.0 / round_step(duration / MAX_FILM_DURATION, 1)


def schedule_frames(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> tuple[FloatArray, list[int]]:
    """When the frames are (s), and how long each is shown (hundredths of a second, together the whole time,
    `slow` times as long as what they show).

    The frames stand at equal steps from start to stop. Each is shown from half a step before its time to half a step
    after, so the first and the last one half as long as the others.
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


def _select_time_span(run: Trajectory, start: float | None, stop: float | None) -> TimeSpan:
    """The piece of the run to show (s), checked."""
    if not len(run.times):
        raise MechanismError(f"the run holds no reported time, so there is nothing to show; it says: {run.message}")
    first, last = float(run.times[0]), float(run.times[-1])
    begin, end = (first if start is None else start), (last if stop is None else stop)
    if not first <= begin <= end <= last:
        raise MechanismError(f"start and stop must lie within the run, {first:g}..{last:g} s, in this order; got {begin:g} and {end:g} s")
    return begin, end


def _select_slow_down(run: Trajectory, time_span: TimeSpan, requested: float | None) -> float:
    """How many times slower than the run the film is, as asked for or chosen, checked."""
    begin, end = time_span
    if requested is None:
        # A piece of a run in true time is shown in true time, however short.
        return 1.0 if MIN_TRUE_TIME_DURATION <= run.times[-1] - run.times[0] <= MAX_TRUE_TIME_DURATION else choose_slow_down(end - begin)
    if not (math.isfinite(requested) and requested > 0.0):
        raise MechanismError(f"slow_down must be a number above 0; got {requested:g}")
    if (end - begin) * requested > MAX_SLOWED_FILM_DURATION:
        raise MechanismError(
            f"slow_down {requested:g} makes a film of {(end - begin) * requested:g} s; at most {MAX_SLOWED_FILM_DURATION:g} s"
        )
    return requested


def _make_painter(
    runs: Sequence[Trajectory],
    titles: Sequence[str] | None,
    size: int,
    part: str | None,
    time_span: TimeSpan,
    slow_down: float,
    times: FloatArray,
) -> Painter:
    if len(runs) == 1:
        return _make_frame_painter(runs[0], size, part, time_span, slow_down, times)
    return make_side_by_side(runs, titles, lambda run: interpolate_frame_data(run, find_part(run, part), time_span, times, slow_down), size)


def _make_frame_painter(
    run: Trajectory, size: int, part: str | None, time_span: TimeSpan, slow_down: float, times: FloatArray
) -> FramePainter:
    return FramePainter(run, interpolate_frame_data(run, find_part(run, part), time_span, times, slow_down), size)


def _ignore_progress(done: int, total: int) -> None:
    pass


def _write_gif(path: Path, make_painter: PainterFactory, timing: FilmTiming, progress: FilmProgress) -> None:
    time_span, slow_down, frame_rate = timing
    times, delays = schedule_frames(*time_span, frame_rate, slow_down)
    painter = make_painter(times)
    samples = [painter.paint(int(k)) for k in np.unique(np.linspace(0, len(times) - 1, N_PALETTE_SAMPLES).astype(int))]
    palette = Palette([parse_rgb(colour) for colour in FILM_COLOURS], samples)
    with path.open("wb") as file:
        writer = GifWriter(file, palette)
        for k, delay in enumerate(delays):
            writer.add(painter.paint(k), delay)
            progress(k + 1, len(delays))
        writer.close()


def _write_mp4(path: Path, make_painter: PainterFactory, timing: FilmTiming, progress: FilmProgress) -> None:
    # Every frame of a video lasts equally long: one frame at the middle of each step makes up the whole time.
    (begin, end), slow_down, frame_rate = timing
    count = max(round((end - begin) * slow_down * frame_rate), 1)
    painter = make_painter(begin + (end - begin) * (np.arange(count) + 0.5) / count)
    with _open_video_writer(path, frame_rate) as writer:
        for k in range(count):
            # Video needs an even number of rows and columns.
            pixels = painter.paint(k)[..., :3]
            padding = (0, len(pixels) % 2)
            writer.append_data(np.pad(pixels, (padding, padding, (0, 0)), mode="edge"))
            progress(k + 1, count)


def _open_video_writer(path: Path, frame_rate: float) -> Any:
    import imageio.v2 as imageio

    return imageio.get_writer(path, format="FFMPEG", fps=frame_rate, codec="libx264", quality=8, macro_block_size=2)
