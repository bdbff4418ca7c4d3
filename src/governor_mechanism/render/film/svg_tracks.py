"""Motions of outlines as key frames: which frames suffice, and which outlines only move and turn."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path

from governor_mechanism.types import FloatArray

TOLERANCE = 0.3
"""Largest distance of an outline from its place, in points: below a third of a pixel."""


_LETTERS = {int(Path.MOVETO): "M", int(Path.LINETO): "L", int(Path.CURVE3): "Q", int(Path.CURVE4): "C"}
"""Letters of SVG by the codes of paths."""


@dataclass(frozen=True, kw_only=True)
class RigidMotion:
    """Motion of an outline (n, 2) around its centre: that of the centre (f, 2), and the angle (f,) in degrees; y points down."""

    outline: FloatArray
    centres: FloatArray
    angles: FloatArray


def find_rigid_motion(frames: FloatArray) -> RigidMotion | None:
    """Return the motion of an outline with points (f, n, 2), or None if it changes its shape."""
    centres = frames.mean(axis=1)
    points = (frames - centres[:, None]) @ np.array([1.0, 1j])  # by frame and point
    turns = (points * points[0].conj()).sum(axis=1)
    angles = np.unwrap(np.angle(turns)) if np.abs(turns).min() > 0.0 else np.zeros(len(turns))
    if float(np.abs(points - np.exp(1j * angles)[:, None] * points[0]).max()) > TOLERANCE:
        return None
    outline = np.column_stack([points[0].real, points[0].imag])
    return RigidMotion(outline=outline, centres=centres, angles=np.degrees(angles))


def key_frames(track: FloatArray) -> list[int]:
    """Return the frames between which a track (f, m), in points, is straight within the tolerance."""
    kept, pending = {0, len(track) - 1}, [(0, len(track) - 1)]
    while pending:
        first, last = pending.pop()
        if last - first < 2:
            continue
        share = (np.arange(first + 1, last) - first)[:, None] / (last - first)
        straight = track[first] + share * (track[last] - track[first])
        distances = np.abs(track[first + 1 : last] - straight).max(axis=1)
        worst = int(distances.argmax())
        if distances[worst] > TOLERANCE:
            middle = first + 1 + worst
            kept.add(middle)
            pending += [(first, middle), (middle, last)]
    return sorted(kept)


def split_path(path: Path) -> Iterator[Path]:
    """Yield the outlines of a path: those of its moves, or of what NaN separates."""
    vertices = np.asarray(path.vertices, dtype=float)
    if not len(vertices):
        return
    if path.codes is None:
        is_gap = ~np.isfinite(vertices).all(axis=1)
        for run in np.split(np.arange(len(vertices)), np.flatnonzero(is_gap)):
            kept = run[~is_gap[run]]
            if len(kept):
                yield Path(vertices[kept])
        return
    codes = np.asarray(path.codes)
    for part in np.split(np.arange(len(vertices)), np.flatnonzero(codes == Path.MOVETO)[1:]):
        yield Path(vertices[part], codes[part])


def describe_path(vertices: FloatArray, codes: FloatArray | None) -> str:
    """Return an outline (n, 2) as the data of an SVG path, with one decimal."""
    words: list[str] = []
    previous = ""
    for k, (x, y) in enumerate(np.round(vertices, 1).tolist()):
        code = (Path.MOVETO if k == 0 else Path.LINETO) if codes is None else codes[k]
        if code == Path.CLOSEPOLY:
            words.append("Z")
            continue
        letter = _LETTERS[int(code)]
        words.append(("" if letter == previous else letter) + f"{x:g} {y:g}")
        previous = letter
    return " ".join(words)
