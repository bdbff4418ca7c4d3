"""What the pictures of a view show at one moment, and what a kind of view computes for them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from governor_mechanism.effects.stops import Stops
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.exploring.pose_drawing import PoseDrawing
from governor_mechanism.notebook.exploring.sliders import Slider
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.types import FloatArray

STOP_POINTS = 10_001
"""Number of positions at which it is found out whether stops allow them: in steps of less than 0.02 degrees of an arm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewState:
    """State at one value of the variable that is dragged.

    Attributes
    ----------
    value
        Value of the variable, SI.
    position
        Leading coordinate of the shown pose, SI.
    pose
        The shown pose; shape (bodies, 3).
    sentences
        What it is, one sentence each.
    problem
        Why there is no equilibrium, so that the pose is an earlier one; empty if there is one.
    equilibria
        Equilibria, of which `equilibrium` is the shown one; None without any.
    """

    value: float
    position: float
    pose: FloatArray
    sentences: tuple[str, ...]
    problem: str = ""
    equilibria: tuple[Equilibrium, ...] = ()
    equilibrium: Equilibrium | None = None


class View(Protocol):
    """A mechanism whose pose follows one variable: the spindle speed, a coordinate, or time."""

    @property
    def scene(self) -> Scene:
        """The scene of one part that is shown."""

    @property
    def variable(self) -> Slider:
        """The slider of the variable."""

    def drawing_at(self, position: float) -> PoseDrawing:
        """Return the drawing whose layout leaves room for the motion around a position."""

    @property
    def speed_curve(self) -> SpeedCurve | None:
        """Equilibrium speed over the travel, if the pose follows the spindle speed."""

    @property
    def kinematics(self) -> Kinematics | None:
        """The motion over the variable, if that is a coordinate or time."""

    @property
    def reading_choices(self) -> Mapping[str, str]:
        """Readings that the plot can show over the variable, with their units; empty if it shows the speed curve."""

    def with_scene(self, scene: Scene) -> "View":
        """Return the view of a changed scene over the same range of the variable. Raise MechanismError if its geometry is impossible."""

    def check_geometry(self, scene: Scene) -> object:
        """Raise MechanismError if the geometry of a changed scene is impossible."""

    def solve(self, value: float, last: ViewState | None) -> ViewState:
        """Return the state at a value of the variable, near the last one."""

    def plot(self, state: ViewState, reading: str, *, is_faded: bool) -> str:
        """Return the picture of the curve with the state marked."""


def travel_within_stops(scene: Scene, coordinate: FloatArray, readings: Mapping[str, FloatArray]) -> Vec2:
    """Return the ends of a travel, given by the values (n,) of its coordinate and readings, as far as the stops of a scene allow."""
    positions = np.linspace(coordinate[0], coordinate[-1], STOP_POINTS)
    is_free = np.ones(STOP_POINTS, dtype=np.bool_)
    for stops in scene.effects:
        if isinstance(stops, Stops) and stops.reading in readings:
            values = np.interp(positions, coordinate, readings[stops.reading])
            is_free &= (values >= stops.low) & (values <= stops.high)
    free = positions[is_free] if is_free.sum() > 1 else positions
    return float(free[0]), float(free[-1])
