"""Additional figures of a run by machine. Those of other machines are not imported: together they are slow to import."""

from pathlib import Path

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.figures.joint_forces import joint_force_figure
from governor_mechanism.render.figures.page import Page, Plate
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine


def write_machine_figures(run: Trajectory, figure_files: FigureFiles, stem: str) -> list[Path]:
    """Write the additional figures of a run's machine as <stem>_<figure>.png.

    A mechanism with a valve has Zeuner's diagram, and one that is reversed the diagrams of all its gears. A slide valve with a finite
    eccentric rod has Marks' construction, too, and a link motion the paths of the die in the link. A slider crank with masses and no
    other loads has the bearing loads, and an engine with a flywheel forces, indicator diagrams and speed, if the run covers a whole turn.
    A governed engine has its engine room at the end of the run. A run that reports reactions has their polar plots.
    """
    plates: dict[str, Page] = {}
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
        from governor_mechanism.render.figures.plates import bearing_loads

        if not bearing_loads.bearing_loads_refusal(run):
            plates["bearings"] = bearing_loads.bearing_loads_figure(run)
    elif machine == "flywheel_engine":
        from governor_mechanism.render.figures.plates import flywheel

        if not flywheel.engine_plate_refusal(run):
            plates["engine"] = flywheel.draw_engine_plate(run)
    if run.scene.run.reactions and len(run.times):
        plates["reactions"] = joint_force_figure(run, run.scene.run.reactions)
    files = [path for name, plate in plates.items() for path in figure_files.save(plate, f"{stem}_{name}")]
    if part is None and len(run.times) > 1 and find_governed_engine(run.scene):
        from governor_mechanism.render.film.painters import write_still

        files.append(write_still(run, figure_files.folder / f"{stem}_engine_room.png"))
    return files


def _gear_plate(run: Trajectory) -> Plate:
    """Return the plate of a valve gear in all its gears."""
    from governor_mechanism.render.figures.plates.reversed_gear import PLATE_COUNT, draw_gear_plate
    from governor_mechanism.studies.valve_gears import compare_valve_gears

    return draw_gear_plate(compare_valve_gears([run.scene], PLATE_COUNT).gears[0])


def _die_path_plate(run: Trajectory) -> Plate:
    """Return the plate of the die's paths in the link."""
    from governor_mechanism.render.figures.plates.reversed_gear import draw_die_path_plate
    from governor_mechanism.studies.valve_gears import trace_die_paths

    return draw_die_path_plate(run.scene.title, trace_die_paths(run.scene), run.scene.document["dimensions"].get("suspension", ""))
