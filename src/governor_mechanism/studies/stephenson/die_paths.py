"""Paths of the die block in the link over the range of gears, for the four suspensions of the paper and that of the scene."""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.stephenson.dimensions import ANY_POINT, ARC_MIDDLE, CHORD_MIDDLE, HALF_WAY, LOWER_PIN
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.types import FloatArray

PAPER_SUSPENSIONS = {ARC_MIDDLE: "Fig. 2", CHORD_MIDDLE: "Fig. 3", LOWER_PIN: "Fig. 4", HALF_WAY: "Fig. 5"}
"""Suspensions of the paper with its figures, in their order."""

GEARS: FloatArray = np.linspace(1.0, -1.0, 9)
"""Positions of the reversing lever, from full forward to full back gear."""

N_ANGLES = 181
"""Number of crank angles of a closed turn."""


@dataclass(frozen=True, kw_only=True)
class DiePaths:
    """Paths of the die in the link for one suspension, in n gears at m crank angles of a turn.

    Attributes
    ----------
    suspension
        Point of the link from which it hangs.
    gears
        Positions of the reversing lever, from 1 to -1; shape (n,).
    displacements
        Displacement of the valve, m; shape (n, m).
    offsets
        Position of the die along the arc, from its middle toward the upper pin, m; shape (n, m).
    half_arc
        Half the length of the arc between the rod pins, m.
    """

    suspension: str
    gears: FloatArray
    displacements: FloatArray
    offsets: FloatArray
    half_arc: float

    @property
    def slips(self) -> FloatArray:
        """Range of the die's position over a turn in each gear, m; shape (n,)."""
        slips: FloatArray = np.ptp(self.offsets, axis=1)
        return slips


def trace_die_paths(
    scene: Scene,
    gears: FloatArray = GEARS,  # positions of the reversing lever; shape (n,)
) -> tuple[DiePaths, ...]:
    """Return the paths of the die for the four suspensions of the paper, with the other dimensions of a scene.

    A suspension at any other point of the scene's own comes last.

    Result: paths for each suspension; one at which the link cannot be assembled is left out. Raises
    MechanismError if the scene is not one of a link motion from a file.
    """
    if scene.part.machine != "stephenson" or not scene.document:
        raise MechanismError(f"die paths need a scene file with machine 'stephenson'; this scene has machine {scene.part.machine!r}")
    own = scene.document["dimensions"].get("suspension", ARC_MIDDLE)
    suspensions = [*PAPER_SUSPENSIONS, *([ANY_POINT] if own == ANY_POINT else [])]
    traced = (_trace_suspension(scene, suspension, gears) for suspension in suspensions)
    return tuple(paths for paths in traced if paths is not None)


def _trace_suspension(scene: Scene, suspension: str, gears: FloatArray) -> DiePaths | None:
    """Return the paths for one suspension, or None if the link cannot be assembled with it."""
    angles = np.linspace(0.0, math.tau, N_ANGLES)
    try:
        turns = [solve_kinematics(_with_suspension(scene, suspension, gear), "crank_angle", angles).readings for gear in gears.tolist()]
    except MechanismError:
        return None
    radius, half_link = (scene.part.dimensions[name] for name in ("link_radius", "half_link"))
    return DiePaths(
        suspension=suspension,
        gears=gears,
        displacements=np.array([turn["valve_displacement"] for turn in turns]),
        offsets=np.array([turn["die_slip"] for turn in turns]),
        half_arc=radius * math.asin(half_link / radius),
    )


def _with_suspension(scene: Scene, suspension: str, gear: float) -> Scene:
    """Return the scene with another suspension, and with its lever at rest."""
    dimensions = scene.document["dimensions"]
    kept = {name: value for name, value in dimensions.items() if suspension == ANY_POINT or not name.startswith("suspension_")}
    return parse_scene_with(scene.document, [("dimensions", {**kept, "suspension": suspension, "reverser": gear})])
