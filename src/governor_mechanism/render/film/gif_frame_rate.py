"""Frame rate and colours of a GIF for which no rate is requested: the best with which the file stays small, by a few of its frames."""

import io
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from governor_mechanism.render.film.encoders import FilmFrames, choose_palette
from governor_mechanism.render.film.gif_encoder import GifWriter, Palette, RgbaPixels
from governor_mechanism.render.film.layout import REFERENCE_SIZE

MAX_GIF_SIZE = 700e3
"""Largest GIF (bytes) of the default height for which no frame rate is requested. Edges, of which a film consists, grow with the height."""
FRAME_RATES = (25.0, 20.0, 50 / 3, 100 / 7, 12.5, 100 / 9, 10.0)
"""Frame rates (1/s) to choose from: frames last 4 to 10 hundredths of a second."""
_N_PROBES = 12
"""Number of frames whose changes are measured."""
_SAFETY = 1.04
"""Factor of the estimated size: with 12 frames it is within 4 % of that of the films of the shipped scenes."""
_ROUNDING = 0.999
"""Factor of a lowest rate: a measured turn of 1 s allows 10 frames a second."""


def choose_gif_settings(
    film: FilmFrames,
    lowest_rate: float = 0.0,  # lowest frame rate (1/s) with which its motion is still understood
) -> tuple[float, bool]:
    """Return the highest rate (1/s) up to that of the film with which its file is small enough, or the lowest that is allowed.

    Results: float, the frame rate, 1/s; bool, whether the file is to have few colours; only if it would be
    too large at the frame rate of the film.
    """
    n_frames = len(film.delays)
    if n_frames < 2 * _N_PROBES:
        return film.frame_rate, False
    limit = MAX_GIF_SIZE * film.painter.paint(0).shape[0] / REFERENCE_SIZE
    if _estimate_size(film, _measure_changes(film), film.frame_rate) <= limit:
        return film.frame_rate, False
    changes = _measure_changes(replace(film, few_colours=True))
    rates = [
        film.frame_rate,
        *(rate for rate in FRAME_RATES if 0.999 * lowest_rate <= rate < film.frame_rate),
    ]  # 10 frames a turn at 1 turn/s
    return next((rate for rate in rates if _estimate_size(film, changes, rate) <= limit), rates[-1]), True


def _estimate_size(film: FilmFrames, changes: tuple[float, float, float], rate: float) -> float:
    """Return the bytes of a film at a frame rate (1/s), from the bytes of its first frame and of its changes."""
    (first, single, double), ratio = changes, film.frame_rate / rate
    return _SAFETY * (first + len(film.delays) / ratio * (single + (double - single) * (ratio - 1.0)))


def _measure_changes(film: FilmFrames) -> tuple[float, float, float]:
    """Return the bytes of the first frame, and the mean bytes of a frame after the one before, and after the one before that."""
    painter, n_frames = film.painter, len(film.delays)
    palette = choose_palette(film)
    changes = []
    for k in np.linspace(0, n_frames - 3, _N_PROBES).astype(int).tolist():
        frames = [painter.paint(k + step).copy() for step in range(3)]
        alone = _encoded_size(palette, frames[:1])
        changes.append([_encoded_size(palette, [frames[0], later]) - alone for later in frames[1:]])
    single, double = np.mean(changes, axis=0).tolist()
    return _encoded_size(palette, [painter.paint(0)]), single, double


def _encoded_size(palette: Palette, frames: Sequence[RgbaPixels]) -> int:
    """Return the bytes of a GIF of frames."""
    file = io.BytesIO()
    writer = GifWriter(file, palette)
    for frame in frames:
        writer.add(frame, 4)
    writer.close()
    return file.tell()
