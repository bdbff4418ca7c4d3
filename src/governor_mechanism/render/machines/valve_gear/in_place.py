"""The engine of a valve gear where it stands: cylinder and piston on the line of the crosshead, steam chest and valve on the valve line.

Both are sections to the scale of the mechanism. The lengths of piston rod and valve rod, which the mechanism leaves open, are such that
nothing meets cylinder or chest.
"""

import math
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Moment, axes_shifted
from governor_mechanism.render.geometry.outlines import make_band, make_rectangle
from governor_mechanism.render.geometry.placement import Placement
from governor_mechanism.render.geometry.points import drawn_point_paths
from governor_mechanism.render.geometry.primitives import DrawnShape, Vec2
from governor_mechanism.render.machines.slide_valve import bore
from governor_mechanism.render.machines.slide_valve.steam_distribution import (
    STEAM_PHASES,
    ValveGearPosition,
    changing_space_parts,
    phase_parts,
)
from governor_mechanism.render.machines.valve_gear.ports import BLOCK_DEPTH, block_shapes, make_chest, port_parts
from governor_mechanism.render.machines.valve_gear.proportions import ValveGearExtents
from governor_mechanism.render.machines.valve_gear.straight_motion import StraightMotion

_HALF_CROSSHEAD, _CROSSHEAD_HALF_HEIGHT, _BAR_THICKNESS, _PIPE_WALL = 0.26, 0.19, 0.07, 0.035
"""Sizes of the crosshead and its slide bars, and the wall of a steam pipe, in crank radii."""
_GAP = 0.06
"""Smallest distance from a drawn point to cylinder or chest, as a fraction of the length scale: half a bar, and some air."""
_PARALLEL_TOLERANCE = 1e-3
"""Angle (rad) below which valve line and cylinder count as parallel, with the chest over the middle of the cylinder."""


class EngineInPlace:
    """Cylinder, chest and steam pipes of a valve gear."""

    def __init__(self, gear: ValveGearExtents) -> None:
        self._gear = gear
        self.chest = make_chest(gear, gear.eccentric)

    @cached_property
    def bore_axes(self) -> Placement:
        """Axes in the middle of the bore; x leads toward the shaft, and y to the side of the steam chest."""
        middle, (px, py) = self._mid_stroke, self._gear.piston_line.direction
        length, normal = self._rod_lengths[0], self._normal
        return Placement(origin=(middle[0] + length * px, middle[1] + length * py), x_axis=(-px, -py), y_axis=normal)

    @cached_property
    def chest_axes(self) -> Placement:
        """Axes in the middle of the face of the ports; x leads toward the shaft, and y away from the cylinder."""
        line, length = self._gear.valve_line, self._rod_lengths[1]
        (qx, qy), (x, y) = line.direction, line.place_at(self._gear.centre + length)
        nx, ny = -qy, qx
        cx, cy = self._mid_stroke
        if nx * (cx - x) + ny * (cy - y) > 0.0:
            nx, ny = -nx, -ny
        stem = self.chest.stem_height
        return Placement(origin=(x - stem * nx, y - stem * ny), x_axis=(-qx, -qy), y_axis=(nx, ny))

    def valve_place(self, position: ValveGearPosition) -> Vec2:
        """Return the middle of the valve (m)."""
        return self.chest_axes((-position.valve_displacement, self.chest.stem_height))

    def piston_place(self, position: ValveGearPosition) -> Vec2:
        """Return the middle of the piston (m)."""
        return self.bore_axes((position.piston_position, 0.0))

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the centre lines, pipes, castings of cylinder and chest, and the slide bars."""
        u, chest = self._gear.crank, self.chest
        yield from (make_band("casting", self._pipe(side), self._pipe_width + 2 * _PIPE_WALL * u) for side in (1.0, -1.0))
        top = (bore.BORE_HALF_HEIGHT + bore.WALL_THICKNESS) * u
        yield from self.bore_axes.place(bore.bore_background_shapes(u, 0.0, top))
        yield from self.bore_axes.place(self._slide_bar_shapes())
        yield from self.chest_axes.place((*block_shapes(chest), *chest.background_shapes()))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield the steam in pipes and cylinder, piston and crosshead, and the valve with its rod."""
        gear, u, chest, (piston_rod, valve_rod) = self._gear, self._gear.crank, self.chest, self._rod_lengths
        for side in (1.0, -1.0):
            phase_at = partial(gear.phase_at, side)
            pipe = make_band("", self._pipe(side), self._pipe_width).points
            spaces = changing_space_parts(STEAM_PHASES, phase_at, partial(self._space_at, side))
            for pair in zip(phase_parts(phase_at, pipe), self.bore_axes.place_parts(spaces), strict=True):
                yield from pair
            yield from self.chest_axes.place_parts(port_parts(chest, phase_at, side))
        yield from self.bore_axes.place_parts(bore.piston_parts(u, 0.0, self._piston_at, piston_rod, rod_moves=True))
        half, height = _HALF_CROSSHEAD * u, _CROSSHEAD_HALF_HEIGHT * u
        crosshead = make_rectangle("block", piston_rod - half, piston_rod + half, -height, height)
        crosshead_axes = axes_shifted(lambda moment: (self._piston_at(moment), 0.0))
        yield from self.bore_axes.place_parts([Attached(frame=crosshead_axes, shapes=(crosshead,))])
        valve = chest.valve_parts(lambda moment: gear.position_at(moment).valve_displacement, valve_rod, rod_moves=True)
        yield from self.chest_axes.place_parts(valve)

    def _piston_at(self, moment: Moment) -> float:
        return self._gear.position_at(moment).piston_position

    def _space_at(self, side: float, moment: Moment) -> tuple[Vec2, ...]:
        """Return the outline of the space between the piston and an end of the bore, in the axes of the bore."""
        return bore.steam_space("", self._gear.crank, 0.0, self._piston_at(moment), side).points

    @property
    def _mid_stroke(self) -> Vec2:
        """Place of the crosshead in the middle of the stroke, m."""
        return self._gear.piston_line.place_at(0.5 * sum(self._gear.piston_ends))

    @cached_property
    def _normal(self) -> Vec2:
        """Unit vector across the line of the piston, toward the valve."""
        (px, py), (x, y) = self._gear.piston_line.direction, self._mid_stroke
        vx, vy = self._gear.valve_line.place_at(self._gear.centre)
        side = math.copysign(1.0, -py * (vx - x) + px * (vy - y))
        return -side * py, side * px

    @cached_property
    def _rod_lengths(self) -> Vec2:
        """Lengths of the piston rod and of the valve rod, m."""
        gear, u = self._gear, self._gear.crank
        gap = _GAP * gear.length_scale
        cylinder_end = (bore.BORE_HALF_LENGTH + bore.END_THICKNESS + bore.GLAND_LENGTH) * u
        half_height = (bore.BORE_HALF_HEIGHT + bore.WALL_THICKNESS) * u
        piston_rod = cylinder_end + gap + max(u + _HALF_CROSSHEAD * u, self._reach(gear.piston_line, self._mid_stroke, half_height + gap))
        chest_end = self.chest.half_length + 2 * self.chest.side_wall
        valve_middle = gear.valve_line.place_at(gear.centre)
        valve_rod = chest_end + gap + max(gear.eccentric, self._reach(gear.valve_line, valve_middle, self.chest.top + gap))
        (px, py), (qx, qy) = gear.piston_line.direction, gear.valve_line.direction
        if abs(px * qy - py * qx) < _PARALLEL_TOLERANCE and px * qx + py * qy > 0.0:
            # The chest stands over the middle of the cylinder.
            ahead = (valve_middle[0] - self._mid_stroke[0]) * px + (valve_middle[1] - self._mid_stroke[1]) * py
            piston_rod = max(piston_rod, ahead + valve_rod)
            valve_rod = piston_rod - ahead
        return piston_rod, valve_rod

    def _reach(self, line: StraightMotion, origin: Vec2, half_width: float) -> float:
        """Return how far (m) drawn points that come near a line reach along it beyond an origin on it."""
        (dx, dy), paths = line.direction, drawn_point_paths(self._gear.part.mechanism, self._gear.poses) - np.array(origin)
        along, across = paths @ np.array([dx, dy]), paths @ np.array([-dy, dx])
        return float(np.max(along, where=np.abs(across) < half_width, initial=-math.inf))

    @property
    def _pipe_width(self) -> float:
        inner, outer = self.chest.port_edges
        return outer - inner

    def _pipe(self, side: float) -> tuple[Vec2, ...]:
        """Return the centre line of the steam pipe of an end, from the block of the ports to the bore (m)."""
        u, width = self._gear.crank, self._pipe_width
        x = side * 0.5 * sum(self.chest.port_edges)
        end, ceiling = side * (bore.BORE_HALF_LENGTH * u - 0.5 * width), bore.BORE_HALF_HEIGHT * u
        start = [
            self.chest_axes((x, y)) for y in (-0.5 * BLOCK_DEPTH * self.chest.eccentric, -BLOCK_DEPTH * self.chest.eccentric - 0.5 * width)
        ]
        return *start, *(self.bore_axes((end, y)) for y in (ceiling + 0.6 * width, ceiling - 0.5 * width))

    def _slide_bar_shapes(self) -> Iterator[DrawnShape]:
        """Yield the bars on both sides of the crosshead, from the cylinder to beyond its travel, in the axes of the bore."""
        u = self._gear.crank
        near, far = (bore.BORE_HALF_LENGTH + bore.END_THICKNESS) * u, self._rod_lengths[0] + (1.0 + 1.3 * _HALF_CROSSHEAD) * u
        for side in (1.0, -1.0):
            low, high = sorted((side * _CROSSHEAD_HALF_HEIGHT * u, side * (_CROSSHEAD_HALF_HEIGHT + _BAR_THICKNESS) * u))
            yield make_rectangle("rod", near, far, low, high)
