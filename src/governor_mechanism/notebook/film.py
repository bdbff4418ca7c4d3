"""A film that a notebook shows."""

import os
from typing import Unpack

from governor_mechanism.model.results.film_options import FilmKeywords, FilmOptions
from governor_mechanism.model.results.pictures import Film
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.writer import write_film
from governor_mechanism.types import Progress


def film_run(
    run: Trajectory,
    path: str | os.PathLike[str],  # path of the file: .gif or .mp4, or .html for an interactive page
    *,
    progress: Progress | None = None,  # called with the number of frames done and in total
    **options: Unpack[FilmKeywords],
) -> Film:
    """Write a run as a film and return its file, which a notebook shows.

    Raises MechanismError as `write_film`.
    """
    return Film(write_film(run, path, FilmOptions(**options), progress=progress))
