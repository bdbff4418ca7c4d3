"""Films of runs, rendered off-screen: GIF, animated SVG, or a video if ffmpeg is available; or an interactive page.

A second of film is a second of the run, except for very short or long runs; the caption then states how much the film is slowed or sped up.
"""

import io
import math
import os
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmOptions, FilmView, Theme
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.artists import themed_colour
from governor_mechanism.render.film.gif_encoder import RGB_MASK, GifWriter, Palette, RgbaPixels, pack_pixels
from governor_mechanism.render.film.layout import REFERENCE_SIZE
from governor_mechanism.render.film.moving_parts import pale_colour
from governor_mechanism.render.film.options import (
    PAGE_SUFFIX,
    VIDEO_SUFFIXES,
    find_engine_room,
    require_suitable_options,
    require_video_writer,
)
from governor_mechanism.render.film.painters import Painter, make_painter
from governor_mechanism.render.film.timing import Timing, select_room_timing, select_slow_down, select_time_span, select_timing
from governor_mechanism.render.frame_data import find_parts
from governor_mechanism.render.machines.engine_room.arrangement import settled_time
from governor_mechanism.render.shown_readings import chosen_readings
from governor_mechanism.render.style import FILM_COLOURS, PAPER, RULE, parse_rgb
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import PATH, check_arguments
from governor_mechanism.units.quantities import format_value

AddFrame = Callable[[int], int]
"""Append the frame of a number to a file, and return the bytes of what is finished, or 0 for a film without a largest size."""
N_PALETTE_SAMPLES = 5
"""Number of frames from which the palette is chosen."""
MIN_AREA = 100
"""Number of pixels of one colour from which on they are an area: fewer are the edges of other areas."""
Rgb = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""


@dataclass(frozen=True, kw_only=True)
class FilmFrames:
    """The frames of a film: their painter, number, rate (1/s) and duration (s); a GIF of `few_colours` is smaller."""

    painter: Painter
    n_frames: int
    frame_rate: float
    duration: float
    theme: Theme
    few_colours: bool = False

    @cached_property
    def palette(self) -> Palette:
        """The palette of its GIF."""
        return choose_palette(self)


OpenEncoder = Callable[[Path, FilmFrames], AbstractContextManager[AddFrame]]
"""Opens a file for the frames of a film."""


def choose_palette(film: FilmFrames) -> Palette:
    """Return the palette of a film: the colours of its artists, also of those that only show later, and blends from a few frames."""
    painter = film.painter
    samples = [painter.paint(int(k)) for k in np.unique(np.linspace(0, film.n_frames - 1, N_PALETTE_SAMPLES).astype(int))]
    shown = [to_rgba(colour) for canvas in painter.canvases for colour in artist_colours(canvas.figure)]
    names = {to_hex(colour) for colour in shown}
    whole_curves = (pale_colour(colour) for colour in FILM_COLOURS)
    film_colours = (to_hex(themed_colour(colour, film.theme)) for colour in (*FILM_COLOURS, *whole_curves))
    exact = [parse_rgb(colour) for colour in film_colours if colour in names]
    # Of the edges of the pale ring of a plan view, whose colour is near that of the paper: few pixels, but a ragged circle is seen.
    ground, rule = (parse_rgb(to_hex(themed_colour(colour, film.theme))) for colour in (PAPER, RULE))
    exact += [(red, green, blue) for red, green, blue in [tuple((np.add(ground, rule) // 2).tolist())] if rule in exact]
    translucent = {colour for colour in shown if 0.0 < colour[3] < 1.0}
    return Palette([*exact, *_find_areas(translucent, exact, samples)], samples, few_colours=film.few_colours)


def _find_areas(
    fills: Collection[tuple[float, float, float, float]],  # translucent colours, each part from 0 to 1
    grounds: Sequence[Rgb],
    samples: Sequence[RgbaPixels],
) -> Iterator[Rgb]:
    """Yield the colours of areas with a translucent fill, once or twice over one of the grounds, that are seen in one of the samples."""
    if not fills:
        return
    counts = [dict(zip(*np.unique(pack_pixels(sample) & RGB_MASK, return_counts=True), strict=True)) for sample in samples]
    for fill in fills:
        colour, opacity = 255 * np.array(fill[:3]), fill[3]
        once = [opacity * colour + (1.0 - opacity) * np.array(ground) for ground in grounds]
        twice = [opacity * colour + (1.0 - opacity) * ground for ground in once]
        for red, green, blue in np.rint([*once, *twice]).astype(int).tolist():
            # The renderer rounds in steps of its own: of colours that near, the one is taken that is seen.
            near = {(red + i, green + j, blue + k): 0 for i, j, k in product((-1, 0, 1), repeat=3)}
            for one in near:
                near[one] = max(count.get(one[0] | one[1] << 8 | one[2] << 16, 0) for count in counts)
            seen = max(near, key=near.__getitem__)
            if near[seen] > MIN_AREA:
                yield seen


def artist_colours(figure: Figure) -> Iterator[Any]:
    """Yield the colours of all lines, patches and texts of a figure."""
    for artist in figure.findobj():
        match artist:
            case Text():
                yield artist.get_color()
            case Line2D():
                yield from (artist.get_color(), artist.get_markeredgecolor(), artist.get_markerfacecolor())
            case Patch():
                yield from (artist.get_facecolor(), artist.get_edgecolor())


@contextmanager
def open_gif(path: Path, film: FilmFrames) -> Iterator[AddFrame]:
    """Open a GIF, all frames of which are shown for the same time, in whole hundredths of a second."""
    delay = max(round(100 * film.duration / film.n_frames), 1)
    with path.open("wb") as file, ThreadPoolExecutor(1) as compressor:
        writer = GifWriter(file, film.palette, compressor)

        def add_frame(k: int) -> int:
            writer.add(film.painter.draw(k), delay)
            return writer.size

        yield add_frame
        writer.close()


@contextmanager
def _open_codec(path: Path, film: FilmFrames, codec: str, options: Sequence[str] = ()) -> Iterator[AddFrame]:
    """Open a video with a codec and options of ffmpeg."""
    import imageio.v2 as imageio  # an optional package

    # The codecs need an even number of rows and columns.
    settings = {"format": "FFMPEG", "fps": film.frame_rate, "codec": codec, "quality": 8, "macro_block_size": 2}
    with cast(Any, imageio).get_writer(path, **settings, output_params=list(options)) as writer:

        def add_frame(k: int) -> int:
            pixels = film.painter.draw(k)
            rows, columns = pixels.shape[0] % 2, pixels.shape[1] % 2
            writer.append_data(np.pad(pixels[..., :3], ((0, rows), (0, columns), (0, 0)), mode="edge"))
            return 0

        yield add_frame


def open_video(path: Path, film: FilmFrames) -> AbstractContextManager[AddFrame]:
    """Open an MP4."""
    return _open_codec(path, film, "libx264")


def open_webm(path: Path, film: FilmFrames) -> AbstractContextManager[AddFrame]:
    """Open a WebM; without these options it takes a second per frame."""
    return _open_codec(path, film, "libvpx-vp9", ("-deadline", "realtime", "-cpu-used", "5"))


@contextmanager
def open_svg(path: Path, film: FilmFrames) -> Iterator[AddFrame]:
    """Open an animated drawing, which is written from all frames at once."""
    from governor_mechanism.render.film.svg_animation import write_animation  # slow to import, and only for drawings

    yield lambda k: 0
    write_animation(path, film.painter.canvases[0], film.duration, film.n_frames)


MAX_GIF_SIZE = 700e3
"""Largest GIF (bytes) of the default height for which no frame rate is requested. Edges, of which a film consists, grow with the height."""
FRAME_RATES = (25.0, 20.0, 50 / 3, 100 / 7, 12.5, 100 / 9, 10.0)
"""Frame rates (1/s) to choose from: frames last 4 to 10 hundredths of a second."""
_N_PROBES = 12
"""Number of frames whose changes are measured where a film is too large."""
_MAX_EXCESS, _MIN_JUDGED = 0.5, 24
"""Excess over the largest size that a film would have if it went on as it began, from which on it is given up at first, falling to none at
its end; and the number of frames after which this is judged."""
_SAFETY = 1.04
"""Factor of the estimated size: with 12 frames it is within 4 % of that of the films of the shipped scenes."""


def choose_gif_rate(
    film: FilmFrames,  # a film of few colours
    largest: float,  # largest size, bytes
    lowest_rate: float = 0.0,  # lowest frame rate (1/s) with which its motion is still understood
) -> float:
    """Return the highest rate (1/s) up to that of the film with which its file is small enough, or the lowest that is allowed."""
    changes = _measure_changes(film)
    # 10 frames a turn at 1 turn/s
    rates = [film.frame_rate, *(rate for rate in FRAME_RATES if 0.999 * lowest_rate <= rate < film.frame_rate)]
    return next((rate for rate in rates if _estimate_size(film, changes, rate) <= largest), rates[-1])


def _estimate_size(film: FilmFrames, changes: Sequence[float], rate: float) -> float:
    """Return the bytes of a film at a frame rate (1/s), from the bytes of its first frame and of its changes over one and two frames."""
    (first, single, double), ratio = changes, film.frame_rate / rate
    return _SAFETY * (first + film.n_frames / ratio * (single + (double - single) * (ratio - 1.0)))


def _measure_changes(film: FilmFrames) -> list[float]:
    """Return the bytes of the first frame, and the mean bytes of a frame after the one before, and after the one before that."""
    # One GIF has all probes, one after the other.
    file = io.BytesIO()
    writer = GifWriter(file, film.palette)

    def add(k: int) -> int:
        """Return the bytes of frame k after the one that was added before."""
        start = file.tell()
        writer.add(film.painter.draw(k), 4)
        writer.flush()
        return file.tell() - start

    first = add(0)
    changes = []
    for k in np.linspace(0, film.n_frames - 3, _N_PROBES).astype(int).tolist():
        sizes = []
        for step in (1, 2):
            add(k)
            sizes.append(add(k + step))
        changes.append(sizes)
    return [first, *np.mean(changes, axis=0).tolist()]


Schedule = Callable[[float, float, float], FloatArray]
"""Returns the times (s) of the frames from a start to a stop (s) at a frame rate, frames per second of the run."""


def schedule_frames(start: float, stop: float, frames_per_second: float) -> FloatArray:
    """Return one time at the middle of each step: every frame lasts equally long, also over the repetition of a periodic motion."""
    count = max(round((stop - start) * frames_per_second), 1)
    return start + (stop - start) * (np.arange(count) + 0.5) / count


def schedule_key_frames(start: float, stop: float, frames_per_second: float) -> FloatArray:
    """Return times from the start to the stop, between which a drawing moves evenly."""
    return np.linspace(start, stop, max(round((stop - start) * frames_per_second), 1) + 1)


FilmProgress = Callable[[int, int], None]
"""Called with the number of frames done and in total."""

DEFAULT_FRAME_RATE = 25.0
"""Frames per second, 1/s."""
MAX_SMOOTH_GIF_DURATION, LONG_GIF_FRAME_RATE = 8.0, 12.5
"""Longest GIF (s) of the default frame rate, and the frame rate (1/s) of a longer one, for a file of less than 700 kB."""
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
    """Write one run, or several side by side, as a film or nothing; `gm.film` documents the parameters, the result and the errors."""
    request = _Request(target=_require_target(path), runs=_require_runs(run, titles), titles=titles, options=options, progress=progress)
    request.require_names()
    require_suitable_options(options, request.scenes, request.suffix)
    if request.suffix == PAGE_SUFFIX:
        return _write_page(request)
    timing = _choose_timing(request)
    with atomic_write(request.target) as temporary:
        _write_frames(request, timing, temporary)
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
    from governor_mechanism.render.page.writer import MAX_TRUE_TIME_DURATION, write_page  # slow to import, and only for pages

    options = request.options
    (run,) = request.runs
    limits = float(run.times[0]), float(run.times[-1])
    time_span = select_time_span(limits, options.start, options.stop)
    slow_down = select_slow_down(limits, time_span, options.slow_down, MAX_TRUE_TIME_DURATION)
    write_page(run, request.target, part=options.part, paths=options.paths, layers=options.layers, time_span=time_span, slow_down=slow_down)
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


def _write_frames(request: _Request, timing: Timing, path: Path) -> None:
    """Write the film; a GIF for which no rate is requested again with fewer frames and colours if it is too large."""
    requested = request.options.frames_per_second
    film = _frames_at(request, timing, _choose_frame_rate(request, timing) if requested is None else requested)
    may_be_smaller = request.suffix == ".gif" and requested is None and film.n_frames >= 2 * _N_PROBES
    largest = MAX_GIF_SIZE * request.options.size / REFERENCE_SIZE if may_be_smaller else math.inf
    if _encode(film, path, request, largest):
        return
    small = replace(film, few_colours=True)
    rate = choose_gif_rate(small, largest, timing.lowest_frame_rate if request.options.slow_down is None else 0.0)
    _encode(small if rate == film.frame_rate else replace(_frames_at(request, timing, rate), few_colours=True), path, request)


def _frames_at(request: _Request, timing: Timing, frame_rate: float) -> FilmFrames:
    """Return the frames of the film at a rate, 1/s; those of a GIF last whole hundredths of a second."""
    schedule, _ = FILM_FORMATS[request.suffix]
    rate = 100.0 / round(100.0 / frame_rate) if request.suffix == ".gif" else frame_rate
    start, stop = timing.time_span
    times = schedule(start, stop, rate * timing.slow_down)
    painter = make_painter(request.runs, timing.time_span, times, timing.slow_down, request.options, request.titles)
    duration = (stop - start) * timing.slow_down
    return FilmFrames(painter=painter, n_frames=len(times), frame_rate=rate, duration=duration, theme=request.options.theme)


def _encode(film: FilmFrames, path: Path, request: _Request, largest: float = math.inf) -> bool:
    """Write frames into a file, and report progress; return whether it has at most the largest size (bytes), or else give up."""
    _, open_encoder = FILM_FORMATS[request.suffix]

    with open_encoder(path, film) as add_frame:
        for k in range(film.n_frames):
            size = add_frame(k)
            share = min(max(k + 1, _MIN_JUDGED) / film.n_frames, 1.0)
            if size > largest * share * (1.0 + _MAX_EXCESS * (1.0 - share)):
                return False
            if request.progress is not None:
                request.progress(k + 1, film.n_frames)
    return path.stat().st_size <= largest


def _choose_frame_rate(request: _Request, timing: Timing) -> float:
    """Return the frame rate (1/s) of a film for which none is requested: a lower one for large files."""
    if find_engine_room(request.scenes, request.options.part) is not None:
        return ENGINE_ROOM_FRAME_RATE
    duration = (timing.time_span[1] - timing.time_span[0]) * timing.slow_down
    is_long = request.suffix == ".gif" and duration > MAX_SMOOTH_GIF_DURATION and not timing.has_whole_turns
    return LONG_GIF_FRAME_RATE if is_long else DEFAULT_FRAME_RATE


FILM_FORMATS: dict[str, tuple[Schedule, OpenEncoder]] = {
    ".gif": (schedule_frames, open_gif),
    ".mp4": (schedule_frames, open_video),
    ".webm": (schedule_frames, open_webm),
    ".svg": (schedule_key_frames, open_svg),
}
"""Schedule and encoder by the ending of the file's name."""
