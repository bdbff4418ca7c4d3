"""GIF encoder that streams frames: one palette for all, and only the changed pixels of each frame; Pillow compresses."""
# Pillow's own writer keeps every frame in memory and searches a palette per frame.

import struct
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile

RgbaPixels = NDArray[np.uint8]
"""Opaque RGBA pixels (height, width, 4)."""
PackedPixels = NDArray[np.uint32]
"""Pixels (...) as integers 0xAABBGGRR."""
PaletteIndices = NDArray[np.uint8]
"""Palette indices (height, width)."""

MIN_BITS, MAX_BITS = 4, 5
"""Bits per pixel. 31 colours suffice for flat areas and their blended edges, and make the file a third smaller than 255 do; 15 colours, if
they suffice, save another tenth of large films."""
BLEND_STEP = 3
"""Every which pixel of the edges of the sample frames counts for the palette: there are tens of thousands of a few hundred colours."""
MIN_BLENDS = 3
"""Smallest number of palette colours for blended edges."""
RGB_MASK = 0xFFFFFF
"""The bits of a packed pixel that are its colour."""
BLEND_TOLERANCE = 64
"""Difference per channel, of 255, below which two blends count as equal: a quarter of an edge's contrast. It makes the file a sixth
smaller."""
RESTORED_TOLERANCE = 12
"""The same where a pixel comes back to its colour at rest, as edges that stand still do: less than the contrast of a pale line."""
MAX_CLOSED_GAP = 6
"""Longest row of unchanged pixels between changed ones that is written again. It makes large moving shapes some 4 % smaller."""
MAX_FRAME_DELAY = 65535
"""Longest display time of a GIF frame, in hundredths of a second."""


class Palette:
    """At most 31 colours, with a table of the nearest colour for five bits per channel.

    `exact_colours` are kept exactly; the others are chosen for the remaining colours of the sample frames. With `few_colours` there are at
    most 15 if the exact ones leave room for blends. `bits` are those per pixel, and `transparent_index` the last index, with which the
    pixel of the frame before stays visible.
    """

    def __init__(self, exact_colours: Sequence[tuple[int, int, int]], samples: Sequence[RgbaPixels], *, few_colours: bool = False) -> None:
        exact_table = np.unique(np.array(exact_colours, dtype=np.uint8).reshape(-1, 3), axis=0)
        self.bits = MIN_BITS if few_colours and len(exact_table) + MIN_BLENDS < 2**MIN_BITS else MAX_BITS
        self.transparent_index = 2**self.bits - 1
        # All colours outside flat areas are blends at edges; the remaining entries are chosen for them.
        is_exact = np.zeros(2**24, dtype=bool)
        is_exact[pack_pixels(_with_opacity(exact_table)) & RGB_MASK] = True
        blends = np.concatenate([sample[~is_exact[pack_pixels(sample) & RGB_MASK]][:, :3] for sample in samples])
        blend_table = np.empty((0, 3), dtype=np.uint8)
        if len(blends) and len(exact_table) < self.transparent_index:
            count = self.transparent_index - len(exact_table)
            chosen = Image.fromarray(blends[None, ::BLEND_STEP]).quantize(count, kmeans=3, dither=Image.Dither.NONE)
            blend_table = np.array(chosen.getpalette(), dtype=np.uint8).reshape(-1, 3)[:count]
        self.colours: NDArray[np.uint8] = np.concatenate([exact_table, blend_table])
        self._nearest_index = self._build_lookup_table(len(exact_table))
        tolerances = BLEND_TOLERANCE, RESTORED_TOLERANCE
        self.resting_indices = self.indices_of(_find_resting(samples).ravel())
        """Palette indices (pixels) of what most sample frames show, or else the first."""
        self._must_change = ~np.stack([self._find_replaceable(len(exact_table), one) for one in tolerances]).reshape(-1)

    def _build_lookup_table(self, n_exact: int) -> NDArray[np.uint8]:
        """Return the index of the nearest palette colour for each cell of the colour cube."""
        distances = ((np.arange(32)[:, None, None] * 8 + 4) - self.colours.astype(np.intp)) ** 2  # by level, colour and channel
        r, g, b = np.moveaxis(distances, -1, 0)
        # In the order of `_find_cells`, where red varies fastest.
        distance = (b[:, None, None] + g[None, :, None] + r[None, None, :]).reshape(32**3, -1)
        table: NDArray[np.uint8] = distance.argmin(axis=1).astype(np.uint8)
        # A flat area keeps its own colour, which need not be the nearest to the middle of its cell.
        table[_find_cells(pack_pixels(_with_opacity(self.colours[:n_exact])))] = np.arange(n_exact)
        return table

    def _find_replaceable(self, n_exact: int, tolerance: int) -> NDArray[np.bool_]:
        """Return where an index (axis 0) may stay on the screen in place of another (axis 1) that differs by less than a tolerance."""
        # Moving edges change from one blend to the next all the time: small changes are omitted. A flat area is always shown exactly, so
        # nothing stays behind a shape that has moved away.
        colours = self.colours.astype(np.int32)
        replaceable: NDArray[np.bool_] = np.abs(colours[:, None] - colours[None]).max(axis=2) < tolerance
        replaceable[:, :n_exact] = False
        np.fill_diagonal(replaceable, True)
        return replaceable

    def must_change(self, shown: PaletteIndices, entries: PaletteIndices, returns: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return where the shown indices (n,) may not stay in place of others, which come back to their colours at rest or not."""
        count = len(self.colours)
        # One look-up in a flat table, as those by several indices take several times as long.
        return self._must_change.take((returns * np.int32(count) + shown) * np.int32(count) + entries)

    def indices_of(self, pixels: PackedPixels) -> PaletteIndices:
        """Return the palette indices (...) of pixels (...)."""
        return self._nearest_index.take(_find_cells(pixels))


def pack_pixels(pixels: RgbaPixels) -> PackedPixels:
    """Return RGBA pixels (..., 4) as integers (...)."""
    return np.ascontiguousarray(pixels).view(np.dtype(np.uint32).newbyteorder("<"))[..., 0]


def _find_resting(samples: Sequence[RgbaPixels]) -> PackedPixels:
    """Return the pixels on which most sample frames agree; those of the first where none do."""
    packed = np.stack([pack_pixels(sample) for sample in samples])
    most = np.argmax([(packed == one).sum(axis=0) for one in packed], axis=0)
    resting: PackedPixels = np.take_along_axis(packed, most[None], axis=0)[0]
    return resting


def _with_opacity(colours: NDArray[np.uint8]) -> RgbaPixels:
    """Return colours (n, 3) as opaque pixels (n, 4)."""
    return np.pad(colours, ((0, 0), (0, 1)), constant_values=255)


def _find_cells(pixels: PackedPixels) -> PackedPixels:
    """Return the cells of the colour cube (...) of pixels (...), with five bits per channel."""
    return np.asarray(pixels >> 3 & 0x1F | pixels >> 6 & 0x3E0 | pixels >> 9 & 0x7C00, dtype=np.uint32)


class GifWriter:
    """Streams frames into an open binary file; call `close` to finish it."""

    # A compressor compresses a frame while the next is painted: Pillow leaves the interpreter to others while it writes into a true
    # file. `size` are the bytes of the frames that are finished when the last one is begun, the same in every run.

    def __init__(self, file: BinaryIO, palette: Palette, compressor: ThreadPoolExecutor | None = None) -> None:
        self._file = file
        self._palette = palette
        self._compressor = compressor
        self._writing: Future[None] | None = None
        self.size = 0
        self._last_pixels: PackedPixels | None = None
        self._shown_indices: PaletteIndices = np.empty((0, 0), dtype=np.uint8)
        self._pending_patch: tuple[int, int, PaletteIndices] | None = None
        self._delay = 0

    def add(self, frame: RgbaPixels, centiseconds: int) -> None:
        """Show a frame for a number of hundredths of a second; an equal frame only extends the one before."""
        pixels = pack_pixels(frame)
        if self._last_pixels is None:
            self._write_header(frame.shape[1], frame.shape[0])
            self._shown_indices = self._palette.indices_of(pixels)
            self._pending_patch = (0, 0, self._shown_indices.copy())
            self._last_pixels = pixels.copy()
        else:
            patch = self._changed_patch(pixels.ravel(), np.flatnonzero(pixels != self._last_pixels))
            if patch is not None or self._delay + centiseconds > MAX_FRAME_DELAY:
                self.flush()
                # A frame must have at least one pixel, even where nothing changed.
                self._pending_patch = patch or (0, 0, np.full((1, 1), self._palette.transparent_index, dtype=np.uint8))
            np.copyto(self._last_pixels, pixels)
        self._delay += centiseconds

    def close(self) -> None:
        """Write the last frame and the end marker."""
        self.flush()
        self._wait()
        self._file.write(b";")

    def _changed_patch(self, pixels: PackedPixels, pixel_indices: NDArray[np.intp]) -> tuple[int, int, PaletteIndices] | None:
        """Return left, top and indices of the smallest rectangle of changed pixels (n,); unchanged ones in it are transparent."""
        entries = self._palette.indices_of(pixels.take(pixel_indices))
        shown_indices = self._shown_indices.reshape(-1)
        # What comes back to its colour at rest is restored more exactly: else edges that stand still get ragged where something passed.
        returns = entries == self._palette.resting_indices[pixel_indices]
        differs = self._palette.must_change(shown_indices[pixel_indices], entries, returns)
        pixel_indices, entries = pixel_indices[differs], entries[differs]
        if not pixel_indices.size:
            return None
        shown_indices[pixel_indices] = entries
        rows = pixel_indices // self._shown_indices.shape[1]  # some times faster than with its remainders
        columns = pixel_indices - rows * self._shown_indices.shape[1]
        left, top = int(columns.min()), int(rows.min())
        box = slice(top, int(rows.max()) + 1), slice(left, int(columns.max()) + 1)
        patch = np.full(self._shown_indices.shape, self._palette.transparent_index, dtype=np.uint8)
        written = np.concatenate([pixel_indices, _find_short_gaps(pixel_indices, rows)])
        patch.reshape(-1)[written] = shown_indices[written]
        return left, top, patch[box]

    def _write_header(self, width: int, height: int) -> None:
        """Write the header with the palette and endless repetition."""
        table = self._palette.colours.tobytes().ljust(3 * 2**self._palette.bits, b"\x00")
        # 0xF0: a palette for all frames, eight bits per channel; the low bits are its size.
        self._file.write(b"GIF89a" + struct.pack("<HHBBB", width, height, 0xF0 | self._palette.bits - 1, 0, 0) + table)
        # Loop count 0: repeat for ever.
        self._file.write(b"\x21\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<H", 0) + b"\x00")

    def flush(self) -> None:
        """Write the pending frame, which is not extended any more."""
        if self._pending_patch is None:
            return
        self._wait()
        if self._compressor is None:
            self._write_frame(*self._pending_patch, self._delay)
        else:
            self._writing = self._compressor.submit(self._write_frame, *self._pending_patch, self._delay)
        self._pending_patch, self._delay = None, 0

    def _wait(self) -> None:
        """Wait until the frame before is written."""
        if self._writing is not None:
            self._writing.result()
        self.size = self._file.tell()

    def _write_frame(self, left: int, top: int, entries: PaletteIndices, delay: int) -> None:
        """Write a frame that changes a rectangle of the picture."""
        height, width = entries.shape
        # 0x05: the frame stays on the screen when the next one comes, and one entry is transparent.
        self._file.write(b"\x21\xf9\x04" + struct.pack("<BHBB", 0x05, delay, self._palette.transparent_index, 0))
        self._file.write(b"\x2c" + struct.pack("<HHHHBB", left, top, width, height, 0, self._palette.bits))
        part = "gif", (0, 0, width, height), 0, ("L", self._palette.bits)
        # As plug-ins of Pillow write; `tobytes` would hold the interpreter.
        cast(Any, ImageFile)._save(Image.fromarray(np.ascontiguousarray(entries)), self._file, [part])
        self._file.write(b"\x00")


def _find_short_gaps(pixel_indices: NDArray[np.intp], rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the unchanged pixels in short gaps between changed ones (n,) of a row, in ascending order: they compress better unhidden."""
    steps = np.diff(pixel_indices)
    before = np.flatnonzero((steps > 1) & (steps <= MAX_CLOSED_GAP + 1))
    before = before[rows[before] == rows[before + 1]]
    starts, steps = pixel_indices[before], steps[before]
    return np.concatenate([starts[steps > k] + k for k in range(1, MAX_CLOSED_GAP + 1)])
