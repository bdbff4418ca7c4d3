"""Encoders of films: GIF, MP4, WebM and animated SVG. Each is opened with a file and the frames, and takes these one after the other."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from governor_mechanism.render.film.moving_parts import pale_colour
from governor_mechanism.render.film.painters import Painter
from governor_mechanism.render.film.svg_animation import write_animation
from governor_mechanism.render.style import FILM_COLOURS, parse_rgb
from governor_mechanism.render.theme import themed_colour

AddFrame = Callable[[int, int], None]
"""Append the frame of a number, with its display time in hundredths of a second, to a file."""
N_PALETTE_SAMPLES = 5
"""Number of frames from which the palette is chosen."""


@dataclass(frozen=True, kw_only=True)
class FilmFrames:
    """The frames of a film: their painter, display times (hundredths of a second), rate (1/s), theme; a GIF of `few_colours` is smaller."""

    painter: Painter
    delays: Sequence[int]
    frame_rate: float
    theme: Theme
    few_colours: bool = False


OpenEncoder = Callable[[Path, FilmFrames], AbstractContextManager[AddFrame]]
"""Opens a file for the frames of a film."""


def choose_palette(film: FilmFrames) -> Palette:
    """Return the palette of a film: the colours of its artists, also of those that only show later, and blends from a few frames."""
    painter, n_frames = film.painter, len(film.delays)
    samples = [painter.paint(int(k)).copy() for k in np.unique(np.linspace(0, n_frames - 1, N_PALETTE_SAMPLES).astype(int))]
    shown = {to_hex(colour) for canvas in painter.canvases for colour in artist_colours(canvas.figure)}
    whole_curves = (pale_colour(colour) for colour in FILM_COLOURS)
    film_colours = (to_hex(themed_colour(colour, film.theme)) for colour in (*FILM_COLOURS, *whole_curves))
    return Palette([parse_rgb(colour) for colour in film_colours if colour in shown], samples, few_colours=film.few_colours)


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
    """Open a GIF; its palette is chosen from a few frames."""
    painter, palette = film.painter, choose_palette(film)
    with path.open("wb") as file:
        writer = GifWriter(file, palette)
        yield lambda k, delay: writer.add(painter.draw(k), delay)
        writer.close()


@contextmanager
def _open_codec(path: Path, film: FilmFrames, codec: str, options: Sequence[str] = ()) -> Iterator[AddFrame]:
    """Open a video with a codec and options of ffmpeg."""
    import imageio.v2 as imageio

    # The codecs need an even number of rows and columns.
    settings = {"format": "FFMPEG", "fps": film.frame_rate, "codec": codec, "quality": 8, "macro_block_size": 2}
    with cast(Any, imageio).get_writer(path, **settings, output_params=list(options)) as writer:

        def add_frame(k: int, delay: int) -> None:
            pixels = film.painter.draw(k)
            rows, columns = pixels.shape[0] % 2, pixels.shape[1] % 2
            writer.append_data(np.pad(pixels[..., :3], ((0, rows), (0, columns), (0, 0)), mode="edge"))

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
    yield lambda k, delay: None
    write_animation(path, film.painter.canvases[0], sum(film.delays) / 100, len(film.delays))
