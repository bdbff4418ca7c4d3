"""Frames of films, decoded and as painted, and the numbers of pages."""

import base64

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
    times = schedule_frames(*span, 25 * slow_factor)
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


def unpack_numbers(packed, count):
    """Return the integers of a channel of a page, decoded independently: bits of all groups of a number in a row."""
    if isinstance(packed, int):
        return np.full(count, packed)
    n_differences, width = {"a": (1, 8), "b": (2, 8), "c": (1, 4), "d": (2, 4)}[packed[0]]
    codes, bits = [], ""
    for byte in base64.b64decode(packed[1:]):
        for group in [f"{byte:08b}"] if width == 8 else [f"{byte % 16:04b}", f"{byte // 16:04b}"]:
            bits = group[1:] + bits
            if group[0] == "0":
                codes.append(int(bits, 2))
                bits = ""
    numbers = np.array([-(code // 2) - 1 if code % 2 else code // 2 for code in codes])
    for _ in range(n_differences):
        numbers = np.cumsum(numbers)
    return numbers
