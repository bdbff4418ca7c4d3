"""A film that a notebook shows."""

import os
from typing import Any

from governor_mechanism.model.results.pictures import Film
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.writer import write_film


def film_run(run: Trajectory, path: str | os.PathLike[str], **options: Any) -> Film:
    """Write a run as a film and return its file, which a notebook shows.

    Parameters
    ----------
    run
        The run.
    path
        Path of the file: .gif or .mp4, or .html for an interactive page.

    Returns
    -------
    Film
        The file.

    Raises
    ------
    MechanismError
        As `write_film`.
    """
    return Film(write_film(run, path, **options))
