"""A frame of a film as a picture."""

import os
from pathlib import Path

import numpy as np
from PIL import Image

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.model.results.film_options import FilmOptions
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.painters import make_painter


def write_still(
    run: Trajectory,
    path: str | os.PathLike[str],
    *,
    # time of the frame, s. None is the last reported time, at which the plots show the whole run
    time: float | None = None,
    size: int = 720,
    part: str | None = None,  # name of the part to show. None shows all parts, as in a film
) -> Path:
    """Write one frame of the film of a run as a picture.

    Result: path of the picture. No file is left behind if an exception is raised. Raises MechanismError if
    the name of the file, the time or the size is not valid, or nothing was reported.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a picture's name must end in .png; got {target.name!r}")
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to show; its message: {run.message}")
    first, last = float(run.times[0]), float(run.times[-1])
    moment = last if time is None else time
    if not first <= moment <= last:
        raise MechanismError(f"time of a picture must lie within the run, {first:g}..{last:g} s; got {moment:g} s")
    painter = make_painter((run,), (first, last), np.array([moment]), 1.0, FilmOptions(size=size, part=part))
    with atomic_write(target) as temporary:
        Image.fromarray(painter.paint(0)[..., :3].copy()).save(temporary, format="png")
    return target
