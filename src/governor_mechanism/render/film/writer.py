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
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.effect_state import acting_of
from governor_mechanism.render.film.frame_data import moments, part_named, poses_of
from governor_mechanism.render.film.frame_painter import Picture
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from governor_mechanism.render.film.layout import ELEVATION, View, fit
from governor_mechanism.render.film.side_by_side import check_pair, pictures_beside
from governor_mechanism.render.geometry.primitives import nice_step
from governor_mechanism.render.machines.registry import extent
from governor_mechanism.render.style import COLOURS, rgb
from governor_mechanism.types import FloatArray

Pixels = NDArray[np.uint8]
Progress = Callable[[int, int], None]
Span = tuple[float, float]
Schedule = tuple[Span, float, float]
"""The piece of the run (s), how many times slower it is shown, and the frames per second of film."""

FASTEST = 50
"""Frames per second: viewers show a GIF frame of less than 2 hundredths of a second far too long."""
SAMPLES = 5
"""Frames from which the palette is chosen."""
LEAST, MOST = 1.0, 60.0
"""Seconds; a run that lasts as long is shown in true time unless told otherwise."""
SLOWED_TO, SPED_UP_TO = 4.0, 20.0
"""Seconds; a film of another run lasts at least, or at most, as long."""
LONGEST = 3600.0
"""Seconds a film may last that is slowed on request."""


class Painter(Protocol):
    """Paints frame after frame."""

    def paint(self, k: int) -> Pixels:
        """Frame k as RGBA, opaque."""


PainterAt = Callable[[FloatArray], Painter]


def film(
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
    progress: Progress | None = None,
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
    check_pair(runs, titles)
    write, span = writers[target.suffix.lower()], _span(runs[0], start, stop)
    slow = _slow(runs[0], span, slow_down)
    with written_beside(target) as temporary:
        painter_at = partial(_painter, runs, titles, size, part, span, slow)
        write(temporary, painter_at, (span, slow, frames_per_second), progress or _silent)
    return target


def require_video_writer() -> None:
    """Raise MechanismError where films cannot be written as .mp4; to be called before long work."""
    try:
        import_module("imageio_ffmpeg")
    except ImportError as missing:
        raise MechanismError("writing .mp4 needs ffmpeg: pip install imageio-ffmpeg, or write a .gif") from missing


def frames(
    run: Trajectory,
    *,
    size: int = 480,
    frames_per_second: float = 25,
    part: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    slow_down: float | None = None,
) -> Iterator[Pixels]:
    """The pictures of a film, (size, size, 3) RGB each, at equal steps from start to stop (both shown)."""
    span = _span(run, start, stop)
    slow = _slow(run, span, slow_down)
    times, _ = schedule(*span, frames_per_second, slow)
    picture = _picture(run, size, part, span, slow, times)
    for k in range(len(times)):
        yield picture.paint(k)[..., :3].copy()


def film_view(run: Trajectory, *, size: int = 480, part: str | None = None) -> View:
    """Where the machine stands in the pictures of a film: `film_view(run).pixel_of(x, y)` is a column and a row."""
    chosen = part_named(run, part)
    return fit(extent(chosen, poses_of(run, chosen)[0], run.times, acting_of(run)), ELEVATION, size)


def watchable(duration: float) -> float:
    """How many times slower to show what lasts so long (s): 1 from 1 to 60 s; else so that the film lasts 2 to 20 s.

    The factor, or what it divides by, is 1, 2 or 5 x 10^n.
    """
    if LEAST <= duration <= MOST or duration <= 0.0:
        return 1.0
    if duration < LEAST:
        return nice_step(SLOWED_TO / duration, 1)
    return 1.0 / nice_step(duration / SPED_UP_TO, 1)


def schedule(start: float, stop: float, frames_per_second: float, slow: float = 1.0) -> tuple[FloatArray, list[int]]:
    """When the frames are (s), and how long each is shown (hundredths of a second, together the whole time,
    `slow` times as long as what they show).

    The frames stand at equal steps from start to stop. Each is shown from half a step before its time to half a step
    after, so the first and the last one half as long as the others.
    """
    if not 1 <= frames_per_second <= FASTEST:
        raise MechanismError(f"frames_per_second must be 1..{FASTEST}; got {frames_per_second:g}")
    hundredths = max(round((stop - start) * slow * 100), 1)
    steps = round(hundredths / 100 * frames_per_second)
    if steps < 1:
        return np.array([start]), [hundredths]
    times = np.linspace(start, stop, steps + 1)
    edges = [0, *(round(hundredths * (k + 0.5) / steps) for k in range(steps)), hundredths]
    return times, [after - before for before, after in pairwise(edges)]


def _span(run: Trajectory, start: float | None, stop: float | None) -> Span:
    """The piece of the run to show (s), checked."""
    if not len(run.times):
        raise MechanismError(f"the run holds no reported time, so there is nothing to show; it says: {run.message}")
    first, last = float(run.times[0]), float(run.times[-1])
    begin, end = (first if start is None else start), (last if stop is None else stop)
    if not first <= begin <= end <= last:
        raise MechanismError(
            f"start and stop must lie within the run, {first:g}..{last:g} s, in this order; got {begin:g} and {end:g} s"
        )
    return begin, end


def _slow(run: Trajectory, span: Span, asked: float | None) -> float:
    """How many times slower than the run the film is, as asked for or chosen, checked."""
    begin, end = span
    if asked is None:
        # A piece of a run in true time is shown in true time, however short.
        return 1.0 if LEAST <= run.times[-1] - run.times[0] <= MOST else watchable(end - begin)
    if not (math.isfinite(asked) and asked > 0.0):
        raise MechanismError(f"slow_down must be a number above 0; got {asked:g}")
    if (end - begin) * asked > LONGEST:
        raise MechanismError(f"slow_down {asked:g} makes a film of {(end - begin) * asked:g} s; at most {LONGEST:g} s")
    return asked


def _painter(
    runs: Sequence[Trajectory],
    titles: Sequence[str] | None,
    size: int,
    part: str | None,
    span: Span,
    slow: float,
    times: FloatArray,
) -> Painter:
    if len(runs) == 1:
        return _picture(runs[0], size, part, span, slow, times)
    return pictures_beside(runs, titles, lambda run: moments(run, part_named(run, part), span, times, slow), size)


def _picture(run: Trajectory, size: int, part: str | None, span: Span, slow: float, times: FloatArray) -> Picture:
    return Picture(run, moments(run, part_named(run, part), span, times, slow), size)


def _silent(done: int, total: int) -> None:
    pass


def _write_gif(path: Path, painter_at: PainterAt, timing: Schedule, progress: Progress) -> None:
    span, slow, rate = timing
    times, delays = schedule(*span, rate, slow)
    painter = painter_at(times)
    samples = [painter.paint(int(k)) for k in np.unique(np.linspace(0, len(times) - 1, SAMPLES).astype(int))]
    palette = Palette([rgb(colour) for colour in COLOURS], samples)
    with path.open("wb") as file:
        writer = GifWriter(file, palette)
        for k, delay in enumerate(delays):
            writer.add(painter.paint(k), delay)
            progress(k + 1, len(delays))
        writer.close()


def _write_mp4(path: Path, painter_at: PainterAt, timing: Schedule, progress: Progress) -> None:
    # Every frame of a video lasts equally long: one frame at the middle of each step makes up the whole time.
    (begin, end), slow, rate = timing
    count = max(round((end - begin) * slow * rate), 1)
    painter = painter_at(begin + (end - begin) * (np.arange(count) + 0.5) / count)
    with _video(path, rate) as writer:
        for k in range(count):
            # Video needs an even number of rows and columns.
            pixels = painter.paint(k)[..., :3]
            odd = (0, len(pixels) % 2)
            writer.append_data(np.pad(pixels, (odd, odd, (0, 0)), mode="edge"))
            progress(k + 1, count)


def _video(path: Path, rate: float) -> Any:
    import imageio.v2 as imageio

    return imageio.get_writer(path, format="FFMPEG", fps=rate, codec="libx264", quality=8, macro_block_size=2)
