"""What is written frame by frame is read back by Pillow, colours and times."""

from __future__ import annotations

import io

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from governor_mechanism.render.film.gif_encoder import GifWriter, Palette
from render.decoding import decode_film


def painted(colour):
    frame = np.zeros((20, 30, 4), dtype=np.uint8)
    frame[..., 3] = 255
    frame[5:15, 10:20, :3] = colour
    return frame


def written(sequence):
    """What Pillow reads of a GIF written from (frame, hundredths of a second) pairs: frames and seconds."""
    palette = Palette([(0, 0, 0), (255, 0, 0)], [frame for frame, _ in sequence])
    file = io.BytesIO()
    writer = GifWriter(file, palette)
    for frame, delay in sequence:
        writer.add(frame, delay)
    writer.close()
    file.seek(0)
    return decode_film(file)


def test_equal_frames_are_merged_and_lengthened():
    red, green = painted((255, 0, 0)), painted((0, 200, 0))
    shown, durations = written([(red, 4), (red.copy(), 5), (green, 4), (red, 3), (red, 3)])
    assert durations == pytest.approx([0.09, 0.04, 0.06])
    assert_array_equal(shown[0], red[..., :3])
    assert_array_equal(shown[1], green[..., :3])
    assert_array_equal(shown[2], red[..., :3])


def test_a_frame_longer_than_gif_can_say_is_split():
    red = painted((255, 0, 0))
    _, durations = written([(red, 40000)] * 3)
    assert sum(durations) == pytest.approx(1200.0)
