"""Generic drawing of what acts along readings: stops, brakes, springs and friction on the way of a point.

Readings that are no position of a point along the plane's own directions have nothing to hang these on, and are left
out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import OnReading
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.mechanism import Coordinate
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.body_points import put, where
from governor_mechanism.render.geometry.outlines import burst, wall
from governor_mechanism.render.geometry.primitives import Lines, Pair, Polygon, Pose, Shape, rectangle
from governor_mechanism.render.machines.generic.force_elements import damper_lines, spring_lines
from governor_mechanism.render.run_extents import Stage

# As fractions of the stage's unit.
CLEAR = 0.05
"""how far a stop stands beyond the point it stops"""
BESIDE = 0.17
"""how far brakes and springs stand beside the way"""
LEAST = 0.30
"""their least length"""


def fittings(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """What is listed for each reading that a point's way tells, in axes along that way; all move with the point."""
    shapes: list[Shape] = []
    for effect in stage.acting.effects:
        reading = part.mechanism.reading(effect.reading) if isinstance(effect, OnReading) else None
        if isinstance(effect, OnReading) and isinstance(reading, Coordinate) and reading.origin.body == GROUND:
            x, y = where(part.mechanism, poses, reading.point)
            value = reading.along_x * (x - reading.origin.x) + reading.along_y * (y - reading.origin.y) - reading.zero
            axes = (x, y, math.atan2(reading.along_y, reading.along_x))
            shapes += _fitting(effect, axes, value, stage)
    return shapes


def _fitting(effect: OnReading, axes: Pose, value: float, stage: Stage) -> list[Shape]:
    """Of one effect, at a value (m) of its reading; `axes` have the point as origin and its way as x."""
    u, acting = stage.unit, stage.acting
    low, high = acting.ranges.get(effect.reading, (value, value))
    match effect:
        case Stops():
            return _stops(effect, axes, value, stage)
        case DryFriction():
            held, shoe = (
                acting.sticks(effect.reading, stage.time),
                rectangle("shoe", -0.05 * u, 0.05 * u, 0.0, 0.04 * u),
            )
            points = tuple(put(axes, x, y - 0.085 * u) for x, y in shoe.points)
            return [Polygon("shoe", () if held else points), Polygon("held shoe", points if held else ())]
        case OilBrake():
            short = LEAST * u
            length = short + value - low
            lines = damper_lines(length, (short, short + high - low), u)
            return _beside("damper", lines, (*put(axes, -length, -BESIDE * u), axes[2]), length, u)
        case SpringOn():
            length = LEAST * u + high - value
            start = put(axes, length, -BESIDE * u)
            return _beside("spring", spring_lines(length, u), (*start, axes[2] + math.pi), length, u)
    return []


def _stops(stops: Stops, axes: Pose, value: float, stage: Stage) -> list[Shape]:
    u, shapes = stage.unit, list[Shape]()
    strike = stage.acting.struck(stops.reading, stage.time)
    for end, way in ((stops.low, -1.0), (stops.high, 1.0)):
        if math.isfinite(end):
            spot = put(axes, end - value + way * CLEAR * u, 0.0)
            struck = strike is not None and strike.high == (way > 0)
            shapes.append(wall(spot, axes[2] + (math.pi if way > 0 else 0.0), 0.07 * u, 0.035 * u))
            shapes.append(burst("burst", [spot] if struck else [], 0.07 * u))
    return shapes


def _beside(role: str, lines: Sequence[Sequence[Pair]], axes: Pose, length: float, u: float) -> list[Shape]:
    """A spring or damper from a wall at its own axes' origin, with a beam from its end to the point's way."""
    drawn = tuple(tuple(put(axes, *point) for point in line) for line in lines)
    across = BESIDE * u if role == "damper" else -BESIDE * u
    beam = (put(axes, length, 0.0), put(axes, length, across))
    return [Lines(role, (*drawn, beam)), wall((axes[0], axes[1]), axes[2], 0.05 * u, 0.035 * u)]
