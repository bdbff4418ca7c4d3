"""Decoding of films."""

from __future__ import annotations

import numpy as np
from PIL import Image


def decode_film(path):
    """Return the frames (n, height, width, 3) and their display times (s)."""
    with Image.open(path) as image:
        shown, durations = [], []
        for k in range(image.n_frames):
            image.seek(k)
            shown.append(np.array(image.convert("RGB")))
            durations.append(image.info["duration"] / 1000)
    return np.array(shown), durations
