"""GIF encoder that streams frames: one palette for all, and only the changed pixels of each frame. Pillow does the compression.

Pillow's own writer keeps every frame in memory and searches a palette per frame.
"""

import struct
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

RgbaPixels = NDArray[np.uint8]
"""Opaque RGBA pixels (height, width, 4)."""
PaletteIndices = NDArray[np.uint8]
"""Palette indices (height, width)."""

BITS_PER_PIXEL = 5
"""Bits per pixel. 31 colours suffice for flat areas and their blended edges, and make the file a third smaller than 255 do."""
TRANSPARENT_INDEX = 2**BITS_PER_PIXEL - 1
"""Last palette index: the pixel of the frame before stays visible."""
BLEND_TOLERANCE = 40
"""Difference per channel, of 255, below which two blends count as equal. It makes the file a tenth smaller."""
MAX_FRAME_DELAY = 65535
"""Longest display time of a GIF frame, in hundredths of a second."""


class Palette:
    """At most 31 colours, with a table of the nearest colour for five bits per channel.

    `exact_colours` are kept exactly; the others are chosen for the remaining colours of the sample frames.
    """

    def __init__(self, exact_colours: Sequence[tuple[int, int, int]], samples: Sequence[RgbaPixels]) -> None:
        exact_table = np.unique(np.array(exact_colours, dtype=np.uint8).reshape(-1, 3), axis=0)
        # All colours outside flat areas are blends at edges; the remaining entries are chosen for them.
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
        """Return the index of the nearest palette colour for each cell of the colour cube."""
        levels = (np.arange(32) * 8 + 4).astype(np.int32)
        cells = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)
        colours = self.colours.astype(np.int32)
        # |a - b|^2 without the term of the cell itself, which is the same for all colours.
        distance = (colours**2).sum(axis=1)[None, :] - 2 * cells @ colours.T
        table: NDArray[np.uint8] = distance.argmin(axis=1).astype(np.uint8)
        # A flat area keeps its own colour, which need not be the nearest to the middle of its cell.
        table[_pack_rgb(self.colours[:n_exact], 5)] = np.arange(n_exact)
        return table

    def _find_replaceable(self, n_exact: int) -> NDArray[np.bool_]:
        """Return where an index (axis 0) may stay on the screen in place of another (axis 1).

        Moving edges change from one blend to the next all the time: small changes are omitted. A flat area is always shown exactly, so
        nothing stays behind a shape that has moved away.
        """
        colours = self.colours.astype(np.int32)
        replaceable: NDArray[np.bool_] = np.abs(colours[:, None] - colours[None]).max(axis=2) < BLEND_TOLERANCE
        replaceable[:, :n_exact] = False
        np.fill_diagonal(replaceable, True)
        return replaceable

    def indices_of(self, colours: NDArray[np.uint8]) -> PaletteIndices:
        """Return the palette indices (...) of colours (..., 3 or 4)."""
        return np.asarray(self._nearest_index[_pack_rgb(colours, 5)])


def _pack_rgb(colours: NDArray[np.uint8], bits: int = 8) -> NDArray[np.intp]:
    """Return colours (..., 3 or 4) as integers with a number of bits per channel: 0xRRGGBB for 8, cells of the colour cube for 5."""
    r, g, b = (colours[..., k].astype(np.intp) >> 8 - bits for k in range(3))
    return r << 2 * bits | g << bits | b


class GifWriter:
    """Streams frames into an open binary file; call `close` to finish it."""

    def __init__(self, file: BinaryIO, palette: Palette) -> None:
        self._file = file
        self._palette = palette
        self._last_colours: NDArray[np.uint32] | None = None
        self._shown_indices: PaletteIndices = np.empty((0, 0), dtype=np.uint8)
        self._pending_patch: tuple[int, int, PaletteIndices] | None = None
        self._delay = 0

    def add(self, frame: RgbaPixels, centiseconds: int) -> None:
        """Show a frame for a number of hundredths of a second; an equal frame only extends the one before."""
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
        """Write the last frame and the end marker."""
        self._flush()
        self._file.write(b";")

    def _changed_patch(self, frame: RgbaPixels, pixel_indices: NDArray[np.intp]) -> tuple[int, int, PaletteIndices] | None:
        """Return left, top and indices of the smallest rectangle of changed pixels; unchanged ones in it are transparent."""
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
        """Write the header with the palette and endless repetition."""
        table = self._palette.colours.tobytes().ljust(3 * 2**BITS_PER_PIXEL, b"\x00")
        # 0xF0: a palette for all frames, eight bits per channel; the low bits are its size.
        self._file.write(b"GIF89a" + struct.pack("<HHBBB", width, height, 0xF0 | BITS_PER_PIXEL - 1, 0, 0) + table)
        # Loop count 0: repeat for ever.
        self._file.write(b"\x21\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<H", 0) + b"\x00")

    def _flush(self) -> None:
        """Write the pending frame."""
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
