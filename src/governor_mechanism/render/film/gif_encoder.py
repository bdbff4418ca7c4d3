"""Writes GIF frame by frame: one palette for all, each frame only the pixels that changed. Pillow does the compression.

Pillow's own writer keeps every frame in memory and looks for a palette per frame; neither is needed here.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

RgbaPixels = NDArray[np.uint8]
"""(height, width, 4) RGBA, opaque."""
PaletteIndices = NDArray[np.uint8]
"""(height, width) palette entries."""

BITS_PER_PIXEL = 5
"""Per pixel. 31 colours do for flat areas and their blended edges, and make the file a third smaller than 255."""
TRANSPARENT_INDEX = 2**BITS_PER_PIXEL - 1
"""The palette's last entry: let the frame before show through."""
BLEND_TOLERANCE = 40
"""Of 255: blends that differ by less in each channel pass for one another. Makes the file a tenth smaller."""
MAX_FRAME_DELAY = 65535
"""Centiseconds a GIF frame can last."""


class Palette:
    """At most 31 colours, and the nearest of them to any colour, looked up to five bits per channel."""

    def __init__(self, exact_colours: Sequence[tuple[int, int, int]], samples: Sequence[RgbaPixels]) -> None:
        """`fixed` colours are kept exactly; the others are chosen for what else is in the sample frames."""
        exact_table = np.unique(np.array(exact_colours, dtype=np.uint8).reshape(-1, 3), axis=0)
        # What is not a flat area is a blend of two of them at an edge: only these need the remaining entries.
        pixels = np.concatenate([sample.reshape(-1, 4)[:, :3] for sample in samples])
        blends = pixels[~np.isin(_pack_rgb(pixels), _pack_rgb(exact_table))]
        blend_table = np.empty((0, 3), dtype=np.uint8)
        if len(blends) and len(exact_table) < TRANSPARENT_INDEX:
            chosen = Image.fromarray(blends[None]).quantize(TRANSPARENT_INDEX - len(exact_table), kmeans=3, dither=Image.Dither.NONE)
            blend_table = np.array(chosen.getpalette(), dtype=np.uint8).reshape(-1, 3)[: TRANSPARENT_INDEX - len(exact_table)]
        self.colours: NDArray[np.uint8] = np.concatenate([exact_table, blend_table])
        self._nearest_index = self._build_lookup_table(len(exact_table))
        self.is_replaceable = self._find_replaceable(len(exact_table))

    def _build_lookup_table(self, n_exact: int) -> NDArray[np.uint8]:
        levels = (np.arange(32) * 8 + 4).astype(np.int32)
        cells = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)
        colours = self.colours.astype(np.int32)
        # |a - b|^2 without the term of the cell itself, which does not change which colour is nearest.
        distance = (colours**2).sum(axis=1)[None, :] - 2 * cells @ colours.T
        table: NDArray[np.uint8] = distance.argmin(axis=1).astype(np.uint8)
        # A flat area must come out in its own colour, not in the colour nearest to the middle of its cell.
        table[_colour_cell(self.colours[:n_exact])] = np.arange(n_exact)
        return table

    def _find_replaceable(self, n_exact: int) -> NDArray[np.bool_]:
        """Where an entry (first index) may stay on the screen instead of another (second index).

        Edges that move change from one blend to the next all the time: small changes are left out. A flat area is
        always shown as it is, so nothing stays behind what has moved away.
        """
        colours = self.colours.astype(np.int32)
        replaceable: NDArray[np.bool_] = np.abs(colours[:, None] - colours[None]).max(axis=2) < BLEND_TOLERANCE
        replaceable[:, :n_exact] = False
        np.fill_diagonal(replaceable, True)
        return replaceable

    def indices_of(self, colours: NDArray[np.uint8]) -> PaletteIndices:
        """Palette entries (...) of colours (..., 3 or 4)."""
        indices: PaletteIndices = self._nearest_index[_colour_cell(colours)]
        return indices


def _colour_cell(colours: NDArray[np.uint8]) -> NDArray[np.intp]:
    r, g, b = (colours[..., k].astype(np.intp) >> 3 for k in range(3))
    return r << 10 | g << 5 | b


def _pack_rgb(colours: NDArray[np.uint8]) -> NDArray[np.intp]:
    r, g, b = (colours[..., k].astype(np.intp) for k in range(3))
    return r << 16 | g << 8 | b


class GifWriter:
    """Streams frames into an open binary file; `close` must be called to finish it."""

    def __init__(self, file: BinaryIO, palette: Palette) -> None:
        self._file = file
        self._palette = palette
        self._last_colours: NDArray[np.uint32] | None = None
        self._shown_indices: PaletteIndices = np.empty((0, 0), dtype=np.uint8)
        self._pending_patch: tuple[int, int, PaletteIndices] | None = None
        self._delay = 0

    def add(self, frame: RgbaPixels, centiseconds: int) -> None:
        """Show a frame for so many hundredths of a second; an equal frame only makes the one before last longer."""
        colours = np.ascontiguousarray(frame).view(np.uint32)[..., 0]
        if self._last_colours is None:
            self._write_header(frame.shape[1], frame.shape[0])
            self._shown_indices = self._palette.indices_of(frame)
            self._pending_patch = (0, 0, self._shown_indices.copy())
        else:
            patch = self._changed_patch(frame, np.flatnonzero(colours != self._last_colours))
            if patch is not None or self._delay + centiseconds > MAX_FRAME_DELAY:
                self._flush()
                # A frame must have at least one pixel, even where nothing changed.
                self._pending_patch = patch or (0, 0, np.full((1, 1), TRANSPARENT_INDEX, dtype=np.uint8))
        self._last_colours = colours
        self._delay += centiseconds

    def close(self) -> None:
        """Write the last frame and the end mark."""
        self._flush()
        self._file.write(b";")

    def _changed_patch(self, frame: RgbaPixels, pixel_indices: NDArray[np.intp]) -> tuple[int, int, PaletteIndices] | None:
        """Left, top and entries of the smallest rectangle of pixels that changed, with UNCHANGED between them."""
        entries = self._palette.indices_of(frame.reshape(-1, 4)[pixel_indices])
        shown_indices = self._shown_indices.reshape(-1)
        differs = ~self._palette.is_replaceable[shown_indices[pixel_indices], entries]
        pixel_indices, entries = pixel_indices[differs], entries[differs]
        if not pixel_indices.size:
            return None
        shown_indices[pixel_indices] = entries
        patch = np.full(self._shown_indices.shape, TRANSPARENT_INDEX, dtype=np.uint8)
        patch.reshape(-1)[pixel_indices] = entries
        rows, columns = np.divmod(pixel_indices, self._shown_indices.shape[1])
        left, top = int(columns.min()), int(rows.min())
        return left, top, patch[top : int(rows.max()) + 1, left : int(columns.max()) + 1]

    def _write_header(self, width: int, height: int) -> None:
        table = np.zeros((2**BITS_PER_PIXEL, 3), dtype=np.uint8)
        table[: len(self._palette.colours)] = self._palette.colours
        # 0xF0: a palette for all frames, eight bits per channel; the low bits are its size.
        self._file.write(b"GIF89a" + struct.pack("<HHBBB", width, height, 0xF0 | BITS_PER_PIXEL - 1, 0, 0) + table.tobytes())
        # The loop count 0 means: for ever.
        self._file.write(b"\x21\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<H", 0) + b"\x00")

    def _flush(self) -> None:
        if self._pending_patch is None:
            return
        left, top, entries = self._pending_patch
        height, width = entries.shape
        # 0x05: the frame stays on the screen when the next one comes, and one entry is transparent.
        self._file.write(b"\x21\xf9\x04" + struct.pack("<BHBB", 0x05, self._delay, TRANSPARENT_INDEX, 0))
        self._file.write(b"\x2c" + struct.pack("<HHHHB", left, top, width, height, 0))
        packed = Image.fromarray(np.ascontiguousarray(entries)).tobytes("gif", ("L", BITS_PER_PIXEL))
        self._file.write(bytes([BITS_PER_PIXEL]) + packed + b"\x00")
        self._pending_patch, self._delay = None, 0
