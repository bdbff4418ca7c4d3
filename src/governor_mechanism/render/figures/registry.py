"""Additional figures of a run by machine."""

import math
from pathlib import Path

from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.slide_valve.marks_plate import marks_figure
from governor_mechanism.render.figures.slide_valve.zeuner_plate import zeuner_figure
from governor_mechanism.render.figures.slider_crank.bearing_loads import bearing_loads_figure, bearing_loads_refusal


def write_machine_figures(run: Trajectory, folder: Path, stem: str) -> list[Path]:
    """Write the additional figures of a run's machine as <stem>_<figure>.png.

    A slide valve has Zeuner's diagram and, for a finite eccentric rod, Marks' construction. A slider crank with masses and no other
    loads has the bearing loads, if the run covers a whole turn. Other machines have none.

    Parameters
    ----------
    run
        Finished run.
    folder
        Folder of the files.
    stem
        Start of the file names.

    Returns
    -------
    list[Path]
        The paths of the files.
    """
    scene = run.scene
    if len(scene.parts) != 1:
        return []
    if scene.part.machine == "slide_valve":
        files = [zeuner_figure(scene, folder / f"{stem}_zeuner.png")]
        if math.isfinite(scene.part.dimensions["eccentric_rod"]):
            files.append(marks_figure(scene, folder / f"{stem}_marks.png"))
        return files
    return [] if bearing_loads_refusal(run) else [bearing_loads_figure(run, folder / f"{stem}_bearings.png")]
