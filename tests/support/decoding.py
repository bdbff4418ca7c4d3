"""Frames of films, decoded and as painted, and the numbers of pages."""

import base64
import json
from itertools import combinations

import numpy as np
from matplotlib.text import Text
from PIL import Image

from governor_mechanism.model.results.pictures import FilmOptions
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.painters import SideBySidePainter
from governor_mechanism.render.film.timing import choose_slow_down
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.page.page_data import collect_data
from governor_mechanism.render.page.views import show_run


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


def data_of(run, count=21, *options, **more):
    """Return what the frames of a film of a whole run of one part show, at a number of times from its start to its end."""
    span = float(run.times[0]), float(run.times[-1])
    return FrameData(run, run.scene.part, span, np.linspace(*span, count), *options, **more)


def painter_of(run, count=21, slow_down=1.0, **options):
    """Return the painter of these frames with options of films."""
    chosen = FilmOptions(**options)
    return FramePainter(run, [data_of(run, count, slow_down, chosen.readings, chosen.exaggerate)], options=chosen)


def pixel_of(view, x, y):
    """Return column and row of the point (x, y) (m) in a view; whole numbers are the middles of pixels, row 0 is the top."""
    left, top, right, bottom = view.rect
    column, row = (left + right) / 2 - 0.5, (top + bottom) / 2 - 0.5
    return column + (x - view.x) * view.scale, row - (y - view.y) * view.scale


def texts_of(figure):
    """Return every visible text of a figure that has letters."""
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]


def words_of(figure):
    """Return the words of a figure."""
    return [text.get_text() for text in texts_of(figure)]


def boxes_of(figure):
    """Return every visible text of a frame with its box in pixels."""
    renderer = figure.canvas.get_renderer()
    return [(text.get_text(), text.get_window_extent(renderer)) for text in texts_of(figure)]


def assert_words_are_clear(boxes):
    """Assert that all words are whole in a frame of 480 pixels, and none overlap: boxes without descenders reach beyond their ink."""
    for words, box in boxes:
        assert 0 <= box.x0 <= box.x1 <= 480, words
        assert 0 <= box.y0 <= box.y1 <= 480, words
    for (words, box), (others, other) in combinations(boxes, 2):
        assert not box.padded(-1.0).overlaps(other.padded(-1.0)), f"{words!r} overlaps {others!r}"


def page_data_of(run, times=None, span=None, **options):
    """Return what a page is told of a run, by default at its reported times."""
    limits = span or (float(run.times[0]), float(run.times[-1]))
    shown = show_run(run, None, limits, run.times if times is None else times, 1.0, **options)
    return json.loads(json.dumps(collect_data(shown, 1.0), allow_nan=False))


def curve_of(plot):
    """Return the values of the first curve of a plot of a page, and their quantum."""
    curve = plot["curves"][0]
    return plot["limits"][0] + curve["quantum"] * unpack_numbers(curve["values"], curve["count"]), curve["quantum"]


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
