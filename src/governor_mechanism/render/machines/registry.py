"""What to draw for a mechanism: shapes in metres, without colours.

Machines register drawings of their own in `DRAWINGS`; any other mechanism is drawn from its bodies and joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.free_space import telling_poses, telling_rows
from governor_mechanism.render.geometry.primitives import Box, Circle, Lines, Shape, bounds
from governor_mechanism.render.machines.generic import drawing as generic
from governor_mechanism.render.machines.hartung import drawing as hartung
from governor_mechanism.render.machines.pendulum import drawing as pendulum
from governor_mechanism.render.machines.slide_valve import drawing as slide_valve
from governor_mechanism.render.run_extents import Stage, stage_of, tracks
from governor_mechanism.types import FloatArray

Background = Callable[[Part, FloatArray, Stage], tuple[Shape, ...]]
Moving = Callable[[Part, FloatArray, Stage], tuple[Shape, ...]]
Plan = Callable[[Part, FloatArray, float, Acting], tuple[Shape, ...]]
Path = Callable[[Part, FloatArray], FloatArray]

ARC_WORDS = ("arc: turned", "since the", "last frame")
"""What the arc on the plan's ring means, line by line."""
MARGIN = 0.02
"""Free border round the shapes, as a fraction of the larger side."""


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """How one kind of machine is drawn.

    background(part, poses (n, bodies, 3), stage) gives what stands still over the whole run; moving(part, pose (bodies,
    3), stage) what moves, with the stage at its moment; plan(part, pose, spindle angle (rad), what acts) a turning
    plane seen from above. Shapes are listed back to front, at every pose as many, of the same kinds and roles.
    traced(part, poses) is the path (n, 2) (m) that is shown; `readings` what the side panel shows, most important
    first; `plan_words` stand beside the plan, line by line.
    """

    background: Background
    moving: Moving
    plan: Plan
    traced: Path | None = None
    readings: tuple[str, ...] = ()
    plan_words: tuple[str, ...] = ("from above",)


GENERIC = Drawing(background=generic.background, moving=generic.moving, plan=generic.plan)

DRAWINGS: dict[str, Drawing] = {
    "pendulum_governor": Drawing(
        background=pendulum.background,
        moving=pendulum.moving,
        plan=pendulum.plan,
        traced=pendulum.traced,
        readings=("arm_angle", "sleeve_lift", "spindle_speed"),
        plan_words=("from above,", "marked: the", "right ball"),
    ),
    "hartung": Drawing(
        background=hartung.background,
        moving=hartung.moving,
        plan=hartung.plan,
        traced=hartung.traced,
        readings=("spring_force", "sleeve_lift", "spindle_speed", "lever_angle"),
        plan_words=("from above,", "marked: the", "right weight"),
    ),
    "slide_valve": Drawing(
        background=slide_valve.background,
        moving=slide_valve.moving,
        plan=slide_valve.plan,
        readings=("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel"),
    ),
}


def drawing_of(part: Part) -> Drawing:
    """The machine's own drawing, or the one that fits every mechanism."""
    return DRAWINGS.get(part.machine, GENERIC)


def background_shapes(part: Part, poses: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """What stands still over a run with poses (n, bodies, 3)."""
    return drawing_of(part).background(part, poses, stage or stage_of(part, poses, np.zeros(1)))


def moving_shapes(part: Part, pose: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """What moves, at one pose (bodies, 3) and the moment of the stage; without a stage, as if the pose were a run."""
    return drawing_of(part).moving(part, pose, stage or stage_of(part, pose[None], np.zeros(1)))


def plan_shapes(
    part: Part, pose: FloatArray, angle: float, sweep: float, ring: float, acting: Acting = NOTHING
) -> tuple[Shape, ...]:
    """The turning plane seen from above, turned anticlockwise by `angle` (rad), inside a ring of radius `ring` (m).

    `sweep` (rad) is the angle turned since the frame before. It is drawn as an arc on the ring: a speed too fast for
    the frames then shows as a closed ring, not as a false slow turning.
    """
    turned = math.copysign(min(abs(sweep), 2 * math.pi), sweep)
    arc = tuple((ring * math.cos(a), ring * math.sin(a)) for a in (angle - turned * k / 32 for k in range(33)))
    hand = ((0.0, 0.0), (ring * math.cos(angle), ring * math.sin(angle)))
    return (
        Lines("sweep", (arc,)),
        Lines("hand", (hand,)),
        *drawing_of(part).plan(part, pose, angle, acting),
        Circle("hub", 0.0, 0.0, 0.05 * ring),
    )


def plan_ring(part: Part, poses: FloatArray, acting: Acting = NOTHING) -> float:
    """Radius (m) of a ring that holds the plan at every pose of a run (n, bodies, 3)."""
    plan = drawing_of(part).plan
    reach = max(max(map(abs, bounds(plan(part, pose, 0.0, acting)))) for pose in telling_poses(poses))
    return 1.10 * reach


def extent(part: Part, poses: FloatArray, times: FloatArray, acting: Acting = NOTHING) -> Box:
    """The box (m) that holds every shape over a run with poses (n, bodies, 3) at times (n,) s, with a margin."""
    stage = stage_of(part, poses, times, acting)
    shapes = list(background_shapes(part, poses, stage))
    for k in telling_rows(tracks(part.mechanism, poses)):
        shapes += moving_shapes(part, poses[k], stage.at(float(times[k])))
    left, right, bottom, top = bounds(shapes)
    margin = MARGIN * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - margin, top + margin
