"""Parts that the drawings of all governors share: spindle, bearings, lift scale, dashpot, springs and friction shoes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.outlines import make_wall
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    DrawnShape,
    Lines,
    Polygon,
    TextShape,
    Vec2,
    make_bar,
    make_hatching,
    make_rectangle,
    round_step,
)

LIFT_READING = "sleeve_lift"
_N_COILS = 7

OutputEffectT = TypeVar("OutputEffectT", bound=OutputEffect)
LiftTicks = list[tuple[float, float]]
"""Lift (mm) and height (m) of each tick of a lift scale."""


@dataclass(frozen=True, kw_only=True)
class GovernorProportions:
    """Common dimensions of a governor drawing (m): its arm, and the lug height at zero lift; with the effects of the scene."""

    arm: float
    zero_lift_height: float
    effect_state: EffectState = NO_EFFECTS

    @property
    def lug_height_range(self) -> Vec2:
        """Lowest and highest lug height of the run (m)."""
        low, high = self.effect_state.reading_ranges.get(LIFT_READING, (0.0, 0.0))
        return self.zero_lift_height + low, self.zero_lift_height + high

    def find_lift_effect(self, kind: type[OutputEffectT]) -> OutputEffectT | None:
        """Return the effect of a kind on the sleeve lift, if the scene has one."""
        return self.effect_state.find_effect_on(kind, LIFT_READING)


def both_sides(inner: float, outer: float) -> tuple[Vec2, Vec2]:
    """Return left and right of an interval of radii (m) on both sides of the axis."""
    return (-outer, -inner), (inner, outer)


def mirror_outline(outline: Sequence[Vec2]) -> tuple[Vec2, ...]:
    """Return the closed outline of a right half (m)."""
    return (*outline, *((-x, y) for x, y in reversed(outline)))


def spindle_shapes(half_width: float, axis: Vec2, bottom: float, top: float) -> list[DrawnShape]:
    """Return the axis between two heights, and the shaded spindle from bottom to top (m)."""
    shade = (((0.45 * half_width, bottom), (0.45 * half_width, top)),)
    line = Lines("axis", (((0.0, axis[0]), (0.0, axis[1])),))
    return [line, make_rectangle("spindle", -half_width, half_width, bottom, top), Lines("spindle shade", shade)]


def bearing_shapes(inner: float, outer: float, bottom: float, top: float, spacing: float) -> list[DrawnShape]:
    """Return a bearing in section: two hatched blocks at the sides of the spindle, from bottom to top (m)."""
    shapes: list[DrawnShape] = []
    for left, right in both_sides(inner, outer):
        shapes += [make_rectangle("bearing", left, right, bottom, top), make_hatching("hatching", (left, right, bottom, top), spacing)]
    return shapes


def lift_ticks(lifts: Vec2, zero_height: float, min_range: float, min_length: float) -> LiftTicks:
    """Return ticks that cover the lifts (m), lowest and highest, on a scale long enough for two numbers without overlap."""
    low, high = lifts
    step = round_step(max(high - low, min_range), 5)
    first = math.floor(low / step + 1e-9)
    last = max(math.ceil(high / step - 1e-9), first + math.ceil(min_length / step))
    return [(k * step * 1e3, k * step + zero_height) for k in range(first, last + 1)]


def lift_scale_shapes(x: float, ticks: LiftTicks, sizes: tuple[float, float, float, float]) -> list[DrawnShape]:
    """Return a lift scale at x (m); `sizes` are the lengths of end ticks and other ticks, text distance and text width (m)."""
    end_length, length, text_distance, text_width = sizes
    ends = ticks[0], ticks[-1]
    lines = [((x, y), (x + (end_length if tick in ends else length), y)) for tick in ticks for y in tick[1:]]
    labels = [
        TextShape("scale", x + text_distance, y, f"{lift:.6g}{unit}", text_width) for (lift, y), unit in zip(ends, ("", " mm"), strict=True)
    ]
    return [Lines("scale", (((x, ends[0][1]), (x, ends[1][1])), *lines)), *labels]


def helical_spring_lines(start: Vec2, end: Vec2, half_width: float, hidden_half_width: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return a helical spring of a half width (m) from the side; its back is hidden within `hidden_half_width` (m) of the axis."""
    length, n_segments = math.dist(start, end), 16 * _N_COILS
    c, s = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0 else (0.0, 1.0)
    chains: list[list[Vec2]] = [[]]
    for k in range(n_segments + 1):
        angle = 2 * math.pi * _N_COILS * k / n_segments
        across, along = half_width * math.cos(angle), length * k / n_segments
        if math.sin(angle) >= -1e-9 or abs(across) >= hidden_half_width:
            chains[-1].append((start[0] + along * c + across * s, start[1] + along * s - across * c))
        elif chains[-1]:
            chains.append([])
    return tuple(tuple(chain) for chain in chains if len(chain) > 1)


def spindle_spring_shapes(low: float, high: float, half_width: float, spindle_half_width: float) -> list[DrawnShape]:
    """Return a helical spring around the spindle between two heights (m)."""
    return [Lines("spring", helical_spring_lines((0.0, low), (0.0, high), half_width, spindle_half_width))]


def friction_shoe_shapes(effect_state: EffectState, reading: str, time: float, shoes: Sequence[Polygon]) -> list[DrawnShape]:
    """Return the shoes once for sliding and once for sticking; the set that does not apply has no outline."""
    is_sticking = effect_state.is_held(reading, time)
    roles = (("shoe", not is_sticking), ("held shoe", is_sticking))
    return [Polygon(role, shoe.points if is_shown else ()) for role, is_shown in roles for shoe in shoes]


def spindle_shoe_shapes(governor: GovernorProportions, time: float, radii: Vec2, top: float, height: float) -> list[DrawnShape]:
    """Return friction shoes under the sleeve between two radii (m), with their top at a height (m); none without dry friction."""
    if not governor.find_lift_effect(DryFriction):
        return []
    shoes = [make_rectangle("shoe", left, right, top - height, top) for left, right in both_sides(*radii)]
    return friction_shoe_shapes(governor.effect_state, LIFT_READING, time, shoes)


@dataclass(frozen=True, kw_only=True)
class DashpotGeometry:
    """A dashpot next to the sleeve (m): left, right, bottom and top of its cylinder, and the sizes of its parts.

    `gap` is the free height above the oil and the depth of the hatched base. The piston has a clearance to the outside of the
    cylinder, a lowest height above the bottom, and a thickness. The bracket goes from the rod to `bracket_end`.
    """

    box: BoundingBox
    wall_thickness: float
    gap: float
    piston_clearance: float
    lowest_piston: float
    piston_thickness: float
    rod_half_width: float
    bracket_end: float
    bracket_width: float

    def cylinder_shapes(self) -> list[DrawnShape]:
        """Return an open cylinder filled with oil on a hatched base."""
        (left, right, bottom, top), t = self.box, self.wall_thickness
        return [
            make_rectangle("dashpot", left, right, bottom, top),
            make_rectangle("bore", left + t, right - t, bottom + t, top),
            make_rectangle("oil", left + t, right - t, bottom + t, top - self.gap),
            make_wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * (right - left) / 2, self.gap),
        ]

    def piston_shapes(self, lift: float, rod_top: float) -> list[DrawnShape]:
        """Return the piston at a lift above its lowest position, its rod, and the bracket at the top of the rod (m)."""
        left, right, bottom, _ = self.box
        x, piston = (left + right) / 2, bottom + self.lowest_piston + lift
        return [
            make_rectangle("piston rod", x - self.rod_half_width, x + self.rod_half_width, piston, rod_top),
            make_rectangle("piston", left + self.piston_clearance, right - self.piston_clearance, piston, piston + self.piston_thickness),
            make_bar("piston rod", (x, rod_top), (self.bracket_end, rod_top), self.bracket_width),
        ]
