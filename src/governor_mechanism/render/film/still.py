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
    run: Trajectory, path: str | os.PathLike[str], *, time: float | None = None, size: int = 720, part: str | None = None
) -> Path:
    """Write one frame of the film of a run as a picture.

    Parameters
    ----------
    run
        Finished run.
    path
        File that ends in .png.
    time
        Time of the frame, s. None is the last reported time, at which the plots show the whole run.
    size
        Height of the picture in pixels; at least 320.
    part
        Name of the part to show. None shows all parts, as in a film.

    Returns
    -------
    Path
        Path of the picture. No file is left behind if an exception is raised.

    Raises
    ------
    MechanismError
        If the name of the file, the time or the size is not valid, or nothing was reported.
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
