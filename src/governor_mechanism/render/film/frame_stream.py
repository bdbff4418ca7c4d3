"""Frames of a film in order; those of a long film are drawn by a second process while this one encodes them."""

import mmap
import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Protocol

import numpy as np

from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.render.film.gif_encoder import RgbaPixels

MIN_FRAMES_FOR_TWO_PROCESSES = 200
"""Number of frames from which a second process pays: to begin it takes as long as it gains on some tens of them."""

MIN_SLOTS, MAX_SLOTS, MAX_SLOT_BYTES = 2, 32, 64_000_000
"""Number of frames that may be drawn and not yet encoded, at least and at most, and the memory that more than the least may take."""


class FrameSource(Protocol):
    """What draws the frames of a film."""

    def draw(self, k: int) -> RgbaPixels:
        """Return frame k in pixels that the next frame overwrites."""


@contextmanager
def stream_frames(source: FrameSource, n_frames: int) -> Iterator[Iterator[RgbaPixels]]:
    """Provide the frames of a film in order, each until the next one is taken.

    Parameters
    ----------
    source
        What draws the frames.
    n_frames
        Number of frames.

    Yields
    ------
    Iterator
        The frames.
    """
    if n_frames >= MIN_FRAMES_FOR_TWO_PROCESSES and _has_idle_processor():
        with draw_beside(source, n_frames) as frames:
            yield frames
    else:
        yield (source.draw(k) for k in range(n_frames))


def _has_idle_processor() -> bool:
    """Return whether a copy of this process may run on another processor that is idle.

    The copy needs no imports, but only Linux copies a process safely, and not one that may have no children.
    """
    if sys.platform != "linux" or multiprocessing.current_process().daemon:
        return False
    return os.getloadavg()[0] < len(os.sched_getaffinity(0)) and len(os.sched_getaffinity(0)) > 1


@contextmanager
def draw_beside(source: FrameSource, n_frames: int) -> Iterator[Iterator[RgbaPixels]]:
    """Provide the frames of a film in order, drawn by a copy of this process.

    The copy ends when this process has all frames, or needs no more, for whatever reason.

    Parameters
    ----------
    source
        What draws the frames.
    n_frames
        Number of frames, at least one.

    Yields
    ------
    Iterator
        The frames.
    """
    shape = source.draw(0).shape
    n_bytes = int(np.prod(shape))
    n_slots = max(min(MAX_SLOTS, MAX_SLOT_BYTES // n_bytes), MIN_SLOTS)
    slots = np.frombuffer(mmap.mmap(-1, n_slots * n_bytes), dtype=np.uint8).reshape(n_slots, *shape)
    context = multiprocessing.get_context("fork")
    # A pipe each way, and not one for both: what is written into a pipe can be read after its writer has ended.
    (finished, finish), (freed, free) = context.Pipe(duplex=False), context.Pipe(duplex=False)
    copy = context.Process(target=_draw_frames, args=(source, n_frames, slots, (finish, freed), (finished, free)), daemon=True)
    with warnings.catch_warnings():
        # Newer Pythons warn of locks that other threads may hold in the copy; it takes none of theirs: it only draws.
        warnings.simplefilter("ignore", DeprecationWarning)
        copy.start()
    try:
        finish.close()
        freed.close()
        yield _receive_frames(finished, free, slots, n_frames)
    finally:
        finished.close()
        free.close()
        copy.join()


def _receive_frames(finished: Connection, free: Connection, slots: RgbaPixels, n_frames: int) -> Iterator[RgbaPixels]:
    """Yield the frames as they are finished, and free their slots."""
    for k in range(n_frames):
        try:
            error = finished.recv()
        except EOFError:
            raise GovernorMechanismError(f"the process that draws the film ended before frame {k + 1} of {n_frames}") from None
        if error is not None:
            raise error
        yield slots[k % len(slots)]
        with suppress(BrokenPipeError):  # the copy has finished, or failed, which a later message tells
            free.send(k)


def _draw_frames(
    source: FrameSource,
    n_frames: int,
    slots: RgbaPixels,
    own_ends: tuple[Connection, Connection],
    other_ends: tuple[Connection, Connection],
) -> None:
    """Draw all frames, each as soon as a slot is free; end when nobody reads them."""
    for end in other_ends:
        end.close()
    # An interrupt ends the original process, which ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    finish, freed = own_ends
    with suppress(EOFError, BrokenPipeError):
        for k in range(n_frames):
            if k >= len(slots):
                freed.recv()
            try:
                slots[k % len(slots)] = source.draw(k)
            except Exception as error:
                finish.send(error)
                return
            finish.send(None)
