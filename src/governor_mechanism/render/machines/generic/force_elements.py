"""Generic drawing of loads: springs, dampers, spirals, drums, and the arrows of given forces and torques."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Distance, DrivenSlide, DrivenTurn, Pin, Weld
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.body_points import hinge, pose_of, put, where
from governor_mechanism.render.geometry.outlines import arrow, wall
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Pose, Shape
from governor_mechanism.render.run_extents import Stage

COILS = 6
WIDTH = 0.075
"""Of a zigzag or a cylinder; this and the following as fractions of the stage's unit."""
BESIDE = 0.065
"""How far loads between the same two points stand off the line."""
ARROW, HEAD, TURN_RADIUS = 0.30, 0.06, 0.13
LEAD = 0.14
"""Straight ends of a zigzag, as a fraction of its length."""


def spans(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Springs and dampers between their points; side by side where they share them."""
    mechanism, u = part.mechanism, stage.unit
    loads = [load for load in mechanism.loads if isinstance(load, Spring | Damper)]
    ends = [tuple(where(mechanism, poses, point) for point in (load.first, load.second)) for load in loads]
    pairs = [frozenset((load.first, load.second)) for load in loads]
    shapes: list[Shape] = []
    for k, (load, (start, end)) in enumerate(zip(loads, ends, strict=True)):
        count, number = pairs.count(pairs[k]), pairs[:k].count(pairs[k])
        off = (2 * number - (count - 1)) * BESIDE * u
        if load.first != loads[pairs.index(pairs[k])].first:
            off = -off
        length = math.dist(start, end)
        axes = (*start, math.atan2(end[1] - start[1], end[0] - start[0]))
        spring, reach = isinstance(load, Spring), stage.reaches[load.name]
        drawn = spring_lines(length, u) if spring else damper_lines(length, reach, u)
        role = "spring" if spring else "damper"
        lines = [tuple(put(axes, x, y + off) for x, y in line) for line in drawn]
        if off:
            # Beams carry what stands off the line.
            lines += [(start, put(axes, 0.0, off)), (end, put(axes, length, off))]
        shapes.append(Lines(role, tuple(lines)))
        shapes.append(Circle("eye", *start, 0.011 * u))
        shapes.append(Circle("eye", *end, 0.011 * u))
    return shapes


def spring_lines(length: float, u: float) -> list[tuple[Pair, ...]]:
    """A zigzag along x from the origin."""
    lead, half = LEAD * length, 0.5 * WIDTH * u
    step = (length - 2 * lead) / (2 * COILS)
    coils = [(lead + (k + 0.5) * step, half if k % 2 else -half) for k in range(2 * COILS)]
    return [((0.0, 0.0), (lead, 0.0), *coils, (length - lead, 0.0), (length, 0.0))]


def damper_lines(length: float, reach: Pair, u: float) -> list[tuple[Pair, ...]]:
    """A cylinder along x from the origin, open toward its end, with a piston from there; true in size where it fits."""
    short, long = reach
    gap, stroke, half = 0.03 * u, long - short, 0.5 * WIDTH * u
    if stroke < short - 3 * gap:
        # The piston runs from `gap` over the bottom to `gap` under the rim, which never reaches the second point.
        rod = (stroke + short) / 2
        bottom, piston, rim = short - rod - gap, length - rod, long - rod + gap
    else:
        bottom, piston, rim = 0.2 * length, 0.5 * length, 0.75 * length
    return [
        ((0.0, 0.0), (bottom, 0.0)),
        ((rim, half), (bottom, half), (bottom, -half), (rim, -half)),
        ((piston, 0.82 * half), (piston, -0.82 * half)),
        ((piston, 0.0), (length, 0.0)),
    ]


def walls(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Small hatched walls where springs and dampers are fixed to the ground, but for places with a foot."""
    mechanism, u = part.mechanism, stage.unit
    feet = [
        (point.x, point.y)
        for joint in mechanism.joints
        if isinstance(joint, Pin | Distance | Weld)
        for point in (joint.first, joint.second)
        if point.body == GROUND
    ]
    shapes: list[Shape] = []
    for load in mechanism.loads:
        if not isinstance(load, Spring | Damper):
            continue
        for mine, other in ((load.first, load.second), (load.second, load.first)):
            spot = (mine.x, mine.y)
            if mine.body == GROUND and spot not in feet:
                feet.append(spot)
                far = where(mechanism, poses, other)
                shapes.append(wall(spot, math.atan2(far[1] - spot[1], far[0] - spot[0]), 0.10 * u, 0.035 * u))
    return shapes


def spirals(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Torsion springs as spirals that wind up, torsion dampers as drums with a vane."""
    mechanism, u = part.mechanism, stage.unit
    shapes: list[Shape] = []
    for load in mechanism.loads:
        if not isinstance(load, TorsionSpring | TorsionDamper):
            continue
        centre = where(mechanism, poses, hinge(mechanism, load.first, load.second))
        outer, inner = (pose_of(mechanism, poses, body)[2] for body in (load.first, load.second))
        if isinstance(load, TorsionSpring):
            # Past one and a half turns a spiral would come loose or close up.
            wound = max(min(inner - outer, 3 * math.pi), -3 * math.pi)
            sweep = 5 * math.pi - wound
            spots = (
                put((*centre, outer + 2.2 - sweep * (1 - k / 72)), (0.03 + 0.07 * k / 72) * u, 0.0) for k in range(73)
            )
            shapes.append(Lines("spring", (tuple(spots),)))
        else:
            shapes.append(Circle("drum", *centre, 0.055 * u))
            vane = tuple(put((*centre, inner), side * 0.055 * u, 0.0) for side in (-1, 1))
            shapes.append(Lines("damper", (vane,)))
    return shapes


def arrows(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Forces as arrows from their points, torques as curved ones, as long as they are large; none for zero."""
    mechanism, u = part.mechanism, stage.unit
    shapes: list[Shape] = []
    for load in mechanism.loads:
        if isinstance(load, Force):
            x, y = where(mechanism, poses, load.point)
            across, up = stage.push(load)
            shapes += arrow("force", ((x, y), (x + ARROW * u * across, y + ARROW * u * up)), HEAD * u)
        elif isinstance(load, Torque):
            centre = where(mechanism, poses, hinge(mechanism, load.first, load.second))
            sweep = 1.5 * math.pi * stage.push(load)[0]
            start = 0.25 * math.pi if sweep > 0 else 0.75 * math.pi
            chain = [put((*centre, start + sweep * k / 32), TURN_RADIUS * u, 0.0) for k in range(33)]
            shapes += arrow("force", chain, HEAD * u)
    return shapes


def drives(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """A ring round the pin that a drive turns, or round the point that it moves."""
    mechanism, u = part.mechanism, stage.unit
    shapes: list[Shape] = []
    for joint in mechanism.joints:
        if isinstance(joint, DrivenTurn):
            point = hinge(mechanism, joint.first.body, joint.second.body, joint.second)
        elif isinstance(joint, DrivenSlide):
            point = joint.second
        else:
            continue
        shapes.append(Circle("drive", *where(mechanism, poses, point), 0.036 * u))
    return shapes
