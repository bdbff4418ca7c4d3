"""All files of a run in one folder. What draws is imported where it is needed: it is slow to import."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.results import save_netcdf
from governor_mechanism.files.writing import write_all_or_none
from governor_mechanism.model.motion_readings import joints_of_reactions
from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, Figure, FilmFormat, FilmOptions, Theme
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.render.figure_files import FigureFiles, FigureFormat
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.units.problems import FLAG, PATH, TEXT, Requirement, check_arguments
from governor_mechanism.units.quantities import format_value


def write_machine_figures(run: Trajectory, figure_files: FigureFiles, stem: str) -> list[Path]:
    """Write the additional figures of a run's machine as <stem>_<figure>.png.

    A mechanism with a valve has Zeuner's diagram, and one that is reversed the diagrams of all its gears. A slide valve with a finite
    eccentric rod has Marks' construction, too, and a link motion the paths of the die in the link. A slider crank with masses and no
    other loads has the bearing loads, and an engine with a flywheel forces, indicator diagrams and speed, if the run covers a whole turn.
    A governed engine has its engine room at the end of the run. A run that reports reactions has their polar plots,
    and one that reports paths their curves.
    """
    plates: dict[str, Figure] = {}
    part = run.scene.parts[0] if len(run.scene.parts) == 1 else None
    machine = part.machine if part else ""
    if machine == "slide_valve":
        from governor_mechanism.render.figures.plates import marks, zeuner

        diagram = marks.EccentricDiagram(run.scene)
        plates["zeuner"] = zeuner.draw_zeuner_plate(diagram)
        if not diagram.eccentric.has_infinite_rod:
            plates["marks"] = marks.draw_marks_plate(diagram)
    elif part and part.mechanism.valve and has_valve_events(run.scene):
        from governor_mechanism.render.figures.plates import zeuner

        plates["zeuner"] = zeuner.draw_zeuner_plate(zeuner.ValveDiagram(run.scene))
        if part.mechanism.valve.reverser and run.scene.document:
            plates["gears"] = _gear_plate(run)
        if machine == "stephenson" and run.scene.document:
            plates["die_paths"] = _die_path_plate(run)
    elif machine == "slider_crank":
        from governor_mechanism.render.figures.plates import engines

        if not engines.bearing_loads_refusal(run):
            plates["bearings"] = engines.bearing_loads_figure(run)
    elif machine == "flywheel_engine":
        from governor_mechanism.render.figures.plates import engines

        if not engines.engine_plate_refusal(run):
            plates["engine"] = engines.draw_engine_plate(run)
    joints = joints_of_reactions(run.scene.mechanism)
    if joints and len(run.times):
        from governor_mechanism.render.figures.kinematics import joint_force_figure

        plates["reactions"] = joint_force_figure(run, joints)
    if run.scene.run.paths and len(run.times):
        from governor_mechanism.render.figures.kinematics import path_figure

        plates["paths"] = path_figure(run.scene.title, run.paths, run.scene.run.paths)
    files = [path for name, plate in plates.items() for path in figure_files.save(plate, f"{stem}_{name}")]
    if part is None and len(run.times) > 1 and find_governed_engine(run.scene):
        from governor_mechanism.render.film.painters import write_still

        files.append(write_still(run, figure_files.folder / f"{stem}_engine_room.png"))
    return files


def _gear_plate(run: Trajectory) -> Figure:
    """Return the plate of a valve gear in all its gears."""
    from governor_mechanism.render.figures.plates.reversed_gear import PLATE_COUNT, draw_gear_plate
    from governor_mechanism.studies.valve_gears import compare_valve_gears

    return draw_gear_plate(compare_valve_gears([run.scene], PLATE_COUNT).gears[0])


def _die_path_plate(run: Trajectory) -> Figure:
    """Return the plate of the die's paths in the link."""
    from governor_mechanism.render.figures.plates.reversed_gear import draw_die_path_plate
    from governor_mechanism.studies.valve_gears import trace_die_paths

    return draw_die_path_plate(run.scene.title, trace_die_paths(run.scene), run.scene.document["dimensions"].get("suspension", ""))


DEFAULT_STEM = "scene"
"""Start of the file names of a scene without a file."""

_SAVERS: Mapping[str, Callable[[Trajectory, Path], object]] = {"csv": Trajectory.save_csv, "nc": save_netcdf, "json": Trajectory.save_json}
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
    """Write all results of a run or none, which leaves earlier ones as they were; `Trajectory.save` documents the parameters."""
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
