"""Text that changes with every frame: its characters are drawn once and then copied."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text

from governor_mechanism.render.film.gif_encoder import RgbaPixels


class CachedNumber:
    """Right-aligned text with one value per frame.

    `update` changes the artist. After `cache_glyphs`, `blit` only copies pixels.
    """

    def __init__(self, artist: Text, texts: Sequence[str]) -> None:
        self.artist = artist
        # A minus sign is as wide as a digit; a hyphen is not.
        self._texts = [text.replace("-", "\N{MINUS SIGN}") for text in texts]
        self._glyphs: dict[str, RgbaPixels] = {}
        self._right_edge = self._top_edge = 0

    def update(self, k: int) -> None:
        """Set the text of frame k."""
        self.artist.set_text(self._texts[k])

    def cache_glyphs(self, canvas: Any) -> None:
        """Store the pixels of every character that occurs; the Agg canvas must show only the static background."""
        text, renderer = self.artist, canvas.get_renderer()
        background = canvas.copy_from_bbox(canvas.figure.bbox)
        buffer = np.asarray(canvas.buffer_rgba())
        position, to_pixels = text.get_position(), text.get_transform()
        right, middle = to_pixels.transform(position)
        half_height = round(0.8 * float(text.get_fontsize()) * canvas.figure.dpi / 72)
        self._right_edge, self._top_edge = round(right), int(buffer.shape[0] - middle) - half_height
        text.set_horizontalalignment("center")
        for character in sorted(set("".join(self._texts))):
            width = self._glyph_width(character, renderer)
            left = self._right_edge - 3 * width
            text.set(text=character, position=to_pixels.inverted().transform((left + width / 2, middle)))
            canvas.restore_region(background)
            text.draw(renderer)
            rows = slice(self._top_edge, self._top_edge + 2 * half_height)
            self._glyphs[character] = buffer[rows, left : left + width].copy()
        text.set(position=position, horizontalalignment="right")
        canvas.restore_region(background)

    def _glyph_width(self, character: str, renderer: RendererAgg) -> int:
        """Return the advance of a character in whole pixels, at least the width of its ink."""
        widths = []
        for count in (1, 11):
            self.artist.set_text(count * character)
            widths.append(float(self.artist.get_window_extent(renderer).width))
        return max(round((widths[1] - widths[0]) / 10), math.ceil(widths[0]))

    def blit(self, pixels: RgbaPixels, k: int) -> None:
        """Copy the text of frame k into a frame (size, size, 4)."""
        right = self._right_edge
        for character in reversed(self._texts[k]):
            patch = self._glyphs[character]
            height, width = patch.shape[:2]
            pixels[self._top_edge : self._top_edge + height, right - width : right] = patch
            right -= width
