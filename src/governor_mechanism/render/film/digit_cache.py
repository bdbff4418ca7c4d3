"""A number that changes with every frame: its digits are drawn once, and then only copied."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]


class Counter:
    """A right-aligned text with one wording a frame: `move` changes the artist; `stamp`, after `cut`, only pixels."""

    def __init__(self, artist: Text, texts: Sequence[str]) -> None:
        self.artist = artist
        # A minus sign is as wide as a digit, a hyphen is not.
        self._texts = [text.replace("-", "\N{MINUS SIGN}") for text in texts]
        self._letters: dict[str, Pixels] = {}
        self._right = self._top = 0

    def move(self, k: int) -> None:
        """Give the artist the text of frame k."""
        self.artist.set_text(self._texts[k])

    def cut(self, canvas: Any) -> None:
        """Keep the pixels of every character that occurs; the Agg canvas must show only what stands still."""
        text, renderer = self.artist, canvas.get_renderer()
        bare = canvas.copy_from_bbox(canvas.figure.bbox)
        buffer = np.asarray(canvas.buffer_rgba())
        place, to_pixels = text.get_position(), text.get_transform()
        right, middle = to_pixels.transform(place)
        half = round(0.8 * float(text.get_fontsize()) * canvas.figure.dpi / 72)
        self._right, self._top = round(right), int(buffer.shape[0] - middle) - half
        text.set_horizontalalignment("center")
        for letter in sorted(set("".join(self._texts))):
            width = self._advance(letter, renderer)
            left = self._right - 3 * width
            text.set(text=letter, position=to_pixels.inverted().transform((left + width / 2, middle)))
            canvas.restore_region(bare)
            text.draw(renderer)
            rows = slice(self._top, self._top + 2 * half)
            self._letters[letter] = buffer[rows, left : left + width].copy()
        text.set(position=place, horizontalalignment="right")
        canvas.restore_region(bare)

    def _advance(self, letter: str, renderer: RendererAgg) -> int:
        """Whole pixels that a letter takes up in a row of its like, and no less than its ink."""
        widths = []
        for count in (1, 11):
            self.artist.set_text(count * letter)
            widths.append(float(self.artist.get_window_extent(renderer).width))
        return max(round((widths[1] - widths[0]) / 10), math.ceil(widths[0]))

    def stamp(self, pixels: Pixels, k: int) -> None:
        """Copy the text of frame k into a picture (size, size, 4)."""
        right = self._right
        for letter in reversed(self._texts[k]):
            patch = self._letters[letter]
            height, width = patch.shape[:2]
            pixels[self._top : self._top + height, right - width : right] = patch
            right -= width
