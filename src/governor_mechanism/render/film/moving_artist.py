"""An artist whose path changes with every frame: matplotlib draws it once, and its calls of the renderer are repeated for other paths."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path

DrawCall = Callable[[Path], None]
"""One call of a renderer, with any path."""


class MovingArtist:
    """A line, a patch or a text; what it draws besides its path stays the same.

    Parameters
    ----------
    artist
        Line or patch with affine transforms, or any artist that does not change.
    """

    def __init__(self, artist: Artist) -> None:
        self.artist = artist
        self._draw_calls: list[DrawCall] = []

    def move(self, path: Path | None) -> None:
        """Set the path of the artist; None for an artist without one."""
        if isinstance(self.artist, PathPatch) and path is not None:
            self.artist.set_path(path)
        elif isinstance(self.artist, Line2D) and path is not None:
            self.artist.set_data(*np.asarray(path.vertices).T)

    def draw(self, renderer: Any, path: Path | None) -> None:
        """Draw the artist with a path."""
        if path is None or not self._draw_calls:
            self.move(path)
            self._draw_calls = []
            recorder: Any = _RecordingRenderer(renderer, self._draw_calls)
            self.artist.draw(recorder)
        else:
            for draw_call in self._draw_calls:
                draw_call(path)


class _RecordingRenderer:
    """Hands everything on to a renderer, and keeps the calls that draw a path."""

    def __init__(self, renderer: Any, draw_calls: list[DrawCall]) -> None:
        self._renderer, self._draw_calls = renderer, draw_calls

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the renderer."""
        return getattr(self._renderer, name)

    def draw_path(self, context: Any, path: Path, transform: Any, face: Any = None) -> None:
        """Draw a path, and keep the call."""
        self._record(lambda one: self._renderer.draw_path(context, one, transform, face), path)

    def draw_markers(self, context: Any, marker: Path, marker_transform: Any, path: Path, transform: Any, face: Any = None) -> None:
        """Draw a marker at each point of a path, and keep the call."""
        self._record(lambda one: self._renderer.draw_markers(context, marker, marker_transform, one, transform, face), path)

    def _record(self, draw_call: DrawCall, path: Path) -> None:
        draw_call(path)
        self._draw_calls.append(draw_call)
