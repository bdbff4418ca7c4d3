"""GIFs written frame by frame are read back by Pillow with the same colours and times."""

from __future__ import annotations

import io

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from render.decoding import decode_film


def make_frame(colour):
    frame = np.zeros((20, 30, 4), dtype=np.uint8)
    frame[..., 3] = 255
    frame[5:15, 10:20, :3] = colour
    return frame


def write_and_read(sequence):
    """Return frames and display times (s) that Pillow reads from a GIF of (frame, hundredths of a second) pairs."""
    palette = Palette([(0, 0, 0), (255, 0, 0)], [frame for frame, _ in sequence])
    file = io.BytesIO()
    writer = GifWriter(file, palette)
    for frame, delay in sequence:
        writer.add(frame, delay)
    writer.close()
    file.seek(0)
    return decode_film(file)


def test_equal_frames_are_merged_and_lengthened():
    red, green = make_frame((255, 0, 0)), make_frame((0, 200, 0))
    shown, durations = write_and_read([(red, 4), (red.copy(), 5), (green, 4), (red, 3), (red, 3)])
    assert durations == pytest.approx([0.09, 0.04, 0.06])
    assert_array_equal(shown[0], red[..., :3])
    assert_array_equal(shown[1], green[..., :3])
    assert_array_equal(shown[2], red[..., :3])


def test_a_frame_longer_than_the_gif_limit_is_split():
    red = make_frame((255, 0, 0))
    _, durations = write_and_read([(red, 40000)] * 3)
    assert sum(durations) == pytest.approx(1200.0)
