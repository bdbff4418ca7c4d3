"""All files of a run in one folder. What draws is imported where it is needed: it is slow to import."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import write_all_or_none
from governor_mechanism.files.results import save_csv, save_netcdf, save_summary
from governor_mechanism.model.results.film_options import DEFAULT_OPTIONS, FilmFormat, FilmOptions
from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figure_files import FigureFiles, FigureFormat
from governor_mechanism.units.problems import FLAG, PATH, TEXT, Requirement, check_arguments
from governor_mechanism.units.quantities import format_value

DEFAULT_STEM = "scene"
"""Start of the file names of a scene without a file."""

_SAVERS = {"csv": save_csv, "nc": save_netcdf, "json": save_summary}
"""Functions that write the files without a picture, by the endings of their names."""


FILM_OPTIONS: Requirement = "a record, as gm.FilmOptions(size=720)", lambda value: isinstance(value, FilmOptions)
"""Options of a film as an argument."""


@check_arguments(folder=PATH, name=TEXT, figures=FLAG, theme=TEXT, film=TEXT, film_options=FILM_OPTIONS)
def save_run(
    run: Trajectory,
    folder: str | os.PathLike[str],
    *,
    name: str | None = None,
    figures: bool = True,
    figure_formats: Sequence[str] = (FigureFormat.PNG,),
    theme: str = Theme.LIGHT,
    film: str | None = None,
    film_options: FilmOptions | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Path, ...]:
    """Write all results of a run or none: if one cannot be written, the results of an earlier run stay unchanged.

    `Trajectory.save` documents the parameters, the result and the errors.
    """
    stem = name or Path(run.scene.source).stem or DEFAULT_STEM
    _check(run, stem, film)
    target = Path(folder)
    figure_files = FigureFiles(folder=target, formats=figure_formats, theme=theme)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MechanismError(f"cannot make the folder {target}: {error.strerror or error}") from error
    written: list[Path] = []
    with write_all_or_none():
        if film is not None and len(run.times) > 1:
            from governor_mechanism.render.film.writer import write_film

            written.append(write_film(run, target / f"{stem}.{film}", film_options or DEFAULT_OPTIONS, progress=progress))
        if figures:
            from governor_mechanism.render.figures.time_series import readings_figure
            from governor_mechanism.render.machine_figures import write_machine_figures

            written += write_machine_figures(run, figure_files, stem)
            written += figure_files.save(readings_figure(run), stem)
        for kind, save in _SAVERS.items():
            written.append(target / f"{stem}.{kind}")
            save(run, written[-1])
    return tuple(written)


def _check(run: Trajectory, stem: str, film: str | None) -> None:
    """Refuse what cannot be saved, before anything is drawn."""
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to save; its message: {run.message}")
    if Path(stem).name != stem:
        raise MechanismError(f"the name of the files must be no path; got {format_value(stem)}; give the folder as the first argument")
    if film is None:
        return
    if film not in set(FilmFormat):
        raise MechanismError(f'film must be "gif", "svg", "mp4", "webm", "html" or None; got {format_value(film)}')
    if film in ("mp4", "webm"):
        from governor_mechanism.render.film.options import require_video_writer

        require_video_writer(f".{film}")
