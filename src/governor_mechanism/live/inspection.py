"""What a page asks for when somebody wants to see it: the events of a valve with Zeuner's diagram, and the assemblies of a mechanism."""

import tempfile
from base64 import b64encode
from pathlib import Path
from typing import Any

from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.valve_motion import has_valve_events
from governor_mechanism.studies.kinematics import list_scene_assemblies
from governor_mechanism.studies.valve_gears import tabulate_valve_timing


def describe_valve(run: Trajectory, theme: str) -> dict[str, Any]:
    """Return the events of the valve in words, and Zeuner's diagram as PNG in base64; raise MechanismError without such a valve."""
    from governor_mechanism.render.figures.plates import zeuner  # slow to import

    timing = tabulate_valve_timing(run.scene)
    with tempfile.TemporaryDirectory() as folder:
        path = zeuner.draw_zeuner_plate(zeuner.ValveDiagram(run.scene)).save(Path(folder) / "zeuner.png", theme)
        picture = b64encode(path.read_bytes()).decode()
    # The title stands at the head of the page.
    return {"timing": str(timing).partition("\n")[2], "picture": picture}


def describe_assemblies(run: Trajectory) -> dict[str, Any]:
    """Return how many ways there are in which the joints close, and which one is taken; raise MechanismError if they are not listed."""
    found = list_scene_assemblies(run.scene)
    return {"count": len(found), "taken": found.taken, "isComplete": found.complete, "text": str(found)}


def list_inspections(run: Trajectory) -> list[str]:
    """Return what can be asked for."""
    scene = run.scene
    has_assemblies = len(scene.parts) == 1 and scene.part.machine == CUSTOM_MACHINE
    return [name for name, has in (("valve", has_valve_events(scene)), ("assemblies", has_assemblies)) if has]
