"""Registry of machine drawings: shapes in metres, without colours.

A machine registers its own drawing in `MACHINE_DRAWINGS`. Every other mechanism is drawn from its bodies and joints.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.free_space import select_extreme_rows
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, bounding_box
from governor_mechanism.render.machines.generic import drawing as generic
from governor_mechanism.render.machines.hartung import drawing as hartung
from governor_mechanism.render.machines.pendulum import drawing as pendulum
from governor_mechanism.render.machines.slide_valve import drawing as slide_valve
from governor_mechanism.render.run_extents import RunExtents, drawn_point_paths, measure_run_extents
from governor_mechanism.types import FloatArray

ShapesFunction = Callable[[Part, FloatArray, RunExtents], Iterable[DrawnShape]]
PlanFunction = Callable[[Part, FloatArray, float, EffectState], Iterable[DrawnShape]]

SWEEP_ARC_CAPTION = ("arc: turned", "since the", "last frame")
"""Caption of the arc on the ring of the plan view, line by line."""
_MARGIN_RATIO = 0.02
"""Free border around the shapes, as a fraction of the larger side."""


@dataclass(frozen=True, kw_only=True)
class MachineDrawing:
    """Drawing functions of one kind of machine.

    `background(part, poses (n, bodies, 3), extents)` returns the shapes that do not move during the run.
    `moving(part, pose (bodies, 3), extents)` returns the moving shapes at the time of `extents`.
    `plan_view(part, pose, spindle angle (rad), effect_state)` returns a rotating plane seen from above.
    Shapes are listed back to front. Every pose gives the same number of shapes, of the same kinds and roles.
    `traced_path(part, poses)` is the path (n, 2) (m) to draw. `panel_readings` are the readings of the side panel, most important first.
    `plan_caption` is the text at the plan view, line by line.
    """

    background: ShapesFunction
    moving: ShapesFunction
    plan_view: PlanFunction
    traced_path: Callable[[Part, FloatArray], FloatArray] | None = None
    panel_readings: tuple[str, ...] = ()
    plan_caption: tuple[str, ...] = ("from above",)


GENERIC_DRAWING = MachineDrawing(background=generic.background_shapes, moving=generic.moving_shapes, plan_view=generic.plan_shapes)

MACHINE_DRAWINGS: dict[str, MachineDrawing] = {
    "pendulum_governor": MachineDrawing(
        background=pendulum.background_shapes,
        moving=pendulum.moving_shapes,
        plan_view=pendulum.plan_shapes,
        traced_path=pendulum.ball_path,
        panel_readings=("arm_angle", "sleeve_lift", "spindle_speed"),
        plan_caption=("from above,", "marked: the", "right ball"),
    ),
    "hartung": MachineDrawing(
        background=hartung.background_shapes,
        moving=hartung.moving_shapes,
        plan_view=hartung.plan_shapes,
        traced_path=hartung.weight_path,
        panel_readings=("spring_force", "sleeve_lift", "spindle_speed", "lever_angle"),
        plan_caption=("from above,", "marked: the", "right weight"),
    ),
    "slide_valve": MachineDrawing(
        background=slide_valve.background_shapes,
        moving=slide_valve.moving_shapes,
        plan_view=generic.plan_shapes,
        panel_readings=("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel"),
    ),
}


def drawing_of(part: Part) -> MachineDrawing:
    """Return the drawing registered for the machine, or the generic drawing."""
    return MACHINE_DRAWINGS.get(part.machine, GENERIC_DRAWING)


def background_shapes(part: Part, poses: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return the shapes that do not move during a run with poses (n, bodies, 3)."""
    return tuple(drawing_of(part).background(part, poses, extents or measure_run_extents(part, poses, np.zeros(1))))


def moving_shapes(part: Part, pose: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return the moving shapes at one pose (bodies, 3) and the time of `extents`; without extents, the pose is the whole run."""
    return tuple(drawing_of(part).moving(part, pose, extents or measure_run_extents(part, pose[None], np.zeros(1))))


def plan_shapes(
    part: Part, pose: FloatArray, angle: float, angle_change: float, ring_radius: float, effect_state: EffectState = NO_EFFECTS
) -> tuple[DrawnShape, ...]:
    """Return the rotating plane seen from above, turned anticlockwise by `angle` (rad), inside a ring of radius `ring_radius` (m).

    `angle_change` (rad) is the rotation since the last frame. It is drawn as an arc on the ring, so that a speed too high for the
    frame rate shows as a closed ring and not as a false slow rotation.
    """
    sweep_angle = math.copysign(min(abs(angle_change), 2 * math.pi), angle_change)
    arc = tuple((ring_radius * math.cos(a), ring_radius * math.sin(a)) for a in (angle - sweep_angle * k / 32 for k in range(33)))
    pointer = ((0.0, 0.0), (ring_radius * math.cos(angle), ring_radius * math.sin(angle)))
    return (
        Lines("sweep", (arc,)),
        Lines("hand", (pointer,)),
        *drawing_of(part).plan_view(part, pose, angle, effect_state),
        Circle("hub", 0.0, 0.0, 0.05 * ring_radius),
    )


def plan_ring_radius(extents: RunExtents) -> float:
    """Return the radius (m) of a ring that contains the plan view at every pose of a run."""
    part, poses = extents.part, extents.poses[select_extreme_rows(extents.poses)]
    plans = (drawing_of(part).plan_view(part, pose, 0.0, extents.effect_state) for pose in poses)
    return 1.10 * max(max(map(abs, bounding_box(plan))) for plan in plans)


def drawing_bounds(extents: RunExtents) -> BoundingBox:
    """Return the box (m) that contains every shape of a run, with a margin."""
    part, poses = extents.part, extents.poses
    shapes = list(background_shapes(part, poses, extents))
    for k in select_extreme_rows(drawn_point_paths(part.mechanism, poses)):
        shapes += moving_shapes(part, poses[k], extents.at_time(float(extents.times[k])))
    left, right, bottom, top = bounding_box(shapes)
    margin = _MARGIN_RATIO * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - margin, top + margin
