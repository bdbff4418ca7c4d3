"""A moving line on the terminal while kernels are compiled."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

FIRST_SHOWN, REFRESH_INTERVAL = 0.5, 0.2
"""Time after which the line appears, and time between two of its states, s."""

CLEAR_LINE = "\r\x1b[K"
"""Return to the start of the line and delete it."""


def has_moving_line() -> bool:
    """Return whether standard error is a terminal that nothing else writes to, such as the progress bar of a command.

    Returns
    -------
    bool
        False in a pipe, in a notebook, and while another display has replaced standard error.
    """
    stream = sys.__stderr__
    return stream is not None and sys.stderr is stream and stream.isatty()


@contextmanager
def show_compilation(name: str) -> Iterator[None]:
    """Show the name of a kernel that is being compiled and the seconds since then; only on a terminal, on standard error.

    Parameters
    ----------
    name
        Name of the kernel.

    Yields
    ------
    None
        While the body of the with statement runs.
    """
    if not has_moving_line():
        yield
        return
    is_finished = threading.Event()
    thread = threading.Thread(target=_move_line, args=(sys.stderr, name, is_finished), daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_finished.set()
        thread.join()


def _move_line(stream: TextIO, name: str, is_finished: threading.Event) -> None:
    """Rewrite the line until the compilation is finished, then delete it."""
    start_time, is_shown = time.monotonic(), False
    is_finished.wait(FIRST_SHOWN)
    while not is_finished.wait(REFRESH_INTERVAL):
        stream.write(f"{CLEAR_LINE}compiling kernels, once for this version: {name}, {time.monotonic() - start_time:.0f} s")
        stream.flush()
        is_shown = True
    if is_shown:
        stream.write(CLEAR_LINE)
        stream.flush()
