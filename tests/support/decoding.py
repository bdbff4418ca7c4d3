"""Frames of films, decoded and as painted."""

from __future__ import annotations

import numpy as np
from PIL import Image

from governor_mechanism.render.film.painters import SideBySidePainter
from governor_mechanism.render.film.timing import choose_slow_down
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.frame_data import FrameData


def decode_film(path):
    """Return the frames (n, height, width, 3) and their display times (s)."""
    with Image.open(path) as image:
        shown, durations = [], []
        for k in range(image.n_frames):
            image.seek(k)
            shown.append(np.array(image.convert("RGB")))
            durations.append(image.info["duration"] / 1000)
    return np.array(shown), durations


def paint_frames(run, slow_down=None):
    """Return the frames (height, width, 3) of a film of a whole run."""
    span = float(run.times[0]), float(run.times[-1])
    slow_factor = slow_down or choose_slow_down(span[1] - span[0])
    times, _ = schedule_frames(*span, 25, slow_factor)
    data = [FrameData(run, part, span, times, slow_factor) for part in run.scene.parts]
    painter = SideBySidePainter([run], None, [data])
    return [painter.paint(k)[..., :3] for k in range(len(times))]


def pixel_of(view, x, y):
    """Return column and row of the point (x, y) (m) in a view; whole numbers are the middles of pixels, row 0 is the top."""
    left, top, right, bottom = view.rect
    column, row = (left + right) / 2 - 0.5, (top + bottom) / 2 - 0.5
    return column + (x - view.x) * view.scale, row - (y - view.y) * view.scale


def words_of(picture):
    """Return every visible text of a frame with its box in pixels."""
    renderer = picture.figure.canvas.get_renderer()
    texts = (text for text in picture.figure.findobj(lambda artist: hasattr(artist, "get_text")) if text.get_visible())
    return [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text().strip()]
