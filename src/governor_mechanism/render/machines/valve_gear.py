"""Drawing of any valve gear with its engine; below it the valve on its ports at a larger scale and a key, beside it the diagram.

Both sections are to the scale of the mechanism. The lengths of piston rod and valve rod, which the mechanism leaves open, are such that
nothing meets cylinder or chest.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, Placement, axes_shifted, fixed, shapes_of
from governor_mechanism.render.geometry.outlines import find_free_corner, make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Polygon, Vec2, bounding_box, drawn_point_paths
from governor_mechanism.render.machines import steam_cylinder, steam_distribution
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.steam_cylinder import SteamChest
from governor_mechanism.render.machines.steam_distribution import (
    SteamDistribution,
    ValveGearPosition,
    changing_space_parts,
    key_shapes,
    phase_parts,
    scale_note_shapes,
)
from governor_mechanism.render.machines.valve_gear_proportions import StraightMotion, ValveGearExtents
from governor_mechanism.types import FloatArray

BLOCK_DEPTH = 0.95
"""Depth of the block, in eccentricities."""
_CHEST_HEIGHT = 1.06
_SIDE_WALL = 0.18
_LID = 0.20
_HATCHING_SPACING = 0.17
"""Sizes of the chest, in eccentricities."""


def make_chest(gear: SteamDistribution, eccentric: float) -> SteamChest:
    """Return the chest of a valve gear with a drawn eccentricity (m), its face at height 0."""
    return SteamChest(
        distribution=gear,
        eccentric=eccentric,
        face=0.0,
        height=_CHEST_HEIGHT * eccentric,
        side_wall=_SIDE_WALL * eccentric,
        lid=_LID * eccentric,
        hatching_spacing=_HATCHING_SPACING * eccentric,
        bowl_depth=0.62 * BLOCK_DEPTH * eccentric,
    )


def block_shapes(chest: SteamChest) -> Iterator[DrawnShape]:
    """Yield the block of the ports below the face of a chest."""
    half = chest.half_length + chest.side_wall
    box = (-half, half, chest.face - BLOCK_DEPTH * chest.eccentric, chest.face)
    yield make_rectangle("casting", *box)
    yield make_hatching("casting hatching", box, chest.hatching_spacing)


def port_parts(chest: SteamChest, phase_at: Callable[[Moment], str], side: float) -> Iterator[Attached]:
    """Yield the port of one end in the block, with its steam in the phase of a moment."""
    inner, outer = chest.port_edges
    left, right = sorted((side * inner, side * outer))
    port = make_rectangle("", left, right, chest.face - BLOCK_DEPTH * chest.eccentric, chest.face).points
    yield from phase_parts(phase_at, port)


_HALF_CROSSHEAD = 0.26
_CROSSHEAD_HALF_HEIGHT = 0.19
_BAR_THICKNESS = 0.07
_PIPE_WALL = 0.035
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
        """Yield the castings of cylinder and chest, and the slide bars."""
        u, chest = self._gear.crank, self.chest
        yield self._casting()
        top = (steam_cylinder.BORE_HALF_HEIGHT + steam_cylinder.WALL_THICKNESS) * u
        yield from self.bore_axes.place(steam_cylinder.bore_background_shapes(u, 0.0, top))
        yield from self.bore_axes.place(self._slide_bar_shapes())
        yield from self.chest_axes.place((*block_shapes(chest), *chest.background_shapes()))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield the steam in pipes and cylinder, piston and crosshead, and the valve with its rod."""
        gear = self._gear
        u = self._gear.crank
        chest = self.chest
        piston_rod, valve_rod = self._rod_lengths
        for side in (1.0, -1.0):
            phase_at = partial(gear.phase_at, side)
            pipe = _passage_outline(self._pipe(side), self._pipe_width)
            spaces = changing_space_parts(phase_at, partial(self._space_at, side))
            for pair in zip(phase_parts(phase_at, pipe), self.bore_axes.place_parts(spaces), strict=True):
                yield from pair
            yield from self.chest_axes.place_parts(port_parts(chest, phase_at, side))
        yield from self.bore_axes.place_parts(steam_cylinder.piston_parts(u, 0.0, self._piston_at, piston_rod, rod_moves=True))
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
        return steam_cylinder.steam_space(self._gear.crank, 0.0, self._piston_at(moment), side)

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
        cylinder_end = (steam_cylinder.BORE_HALF_LENGTH + steam_cylinder.END_THICKNESS + steam_cylinder.GLAND_LENGTH) * u
        half_height = (steam_cylinder.BORE_HALF_HEIGHT + steam_cylinder.WALL_THICKNESS) * u
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
        dx, dy = line.direction
        paths = drawn_point_paths(self._gear.part.mechanism, self._gear.poses) - np.array(origin)
        along, across = paths @ np.array([dx, dy]), paths @ np.array([-dy, dx])
        return float(np.max(along, where=np.abs(across) < half_width, initial=-math.inf))

    @property
    def _pipe_width(self) -> float:
        inner, outer = self.chest.port_edges
        return outer - inner

    def _pipe(self, side: float) -> tuple[Vec2, ...]:
        """Return the centre line of the steam passage of an end, from the block of the ports to the bore (m)."""
        u = self._gear.crank
        width = self._pipe_width
        depth = BLOCK_DEPTH * self.chest.eccentric
        port = side * 0.5 * sum(self.chest.port_edges)
        start = [self.chest_axes((port, y)) for y in (-0.5 * depth, -depth - 0.5 * width)]
        end = side * (steam_cylinder.BORE_HALF_LENGTH * u - 0.5 * width)
        # Down the neck, and in the wall along the bore to its end.
        neck = side * min(side * self.bore_axes.coordinates(start[-1])[0], side * end)
        level = self._passage_height
        below = [(neck, level), (end, level), (end, steam_cylinder.BORE_HALF_HEIGHT * u - 0.5 * width)]
        return *start, *map(self.bore_axes, below)

    @cached_property
    def _passage_height(self) -> float:
        """Height of the passages along the bore above its middle, m: in the wall, below the block of the ports."""
        ceiling = steam_cylinder.BORE_HALF_HEIGHT * self._gear.crank
        lowest = min(y for _, y in self._block_corners)
        return min(ceiling + 0.5 * self._pipe_width + 2 * _PIPE_WALL * self._gear.crank, 0.5 * (ceiling + lowest))

    @cached_property
    def _block_corners(self) -> list[Vec2]:
        """Lower corners of the block of the ports in the axes of the bore, m: that at the crank end, and that at the head end."""
        half = self.chest.half_length + self.chest.side_wall
        foot = self.chest.face - BLOCK_DEPTH * self.chest.eccentric
        return [self.bore_axes.coordinates(self.chest_axes((side * half, foot))) for side in (1.0, -1.0)]

    def _casting(self) -> Polygon:
        """Return the casting between the block of the ports and the cylinder, a neck on a thick wall: steam passages are cored in it."""
        u = self._gear.crank
        wall = (steam_cylinder.BORE_HALF_LENGTH + steam_cylinder.END_THICKNESS) * u
        top = self._passage_height + 0.5 * self._pipe_width + 2 * _PIPE_WALL * u
        halves = []
        for side, (x, y) in zip((1.0, -1.0), self._block_corners, strict=True):
            neck = side * min(side * x, wall)
            halves.append([(x, y), (neck, top), (side * wall, top), (side * wall, 0.0)])
        return Polygon("casting", tuple(map(self.bore_axes, (*halves[0], *reversed(halves[1])))))

    def _slide_bar_shapes(self) -> Iterator[DrawnShape]:
        """Yield the bars on both sides of the crosshead, from the cylinder to beyond its travel, in the axes of the bore."""
        u = self._gear.crank
        near = (steam_cylinder.BORE_HALF_LENGTH + steam_cylinder.END_THICKNESS) * u
        far = self._rod_lengths[0] + (1.0 + 1.3 * _HALF_CROSSHEAD) * u
        for side in (1.0, -1.0):
            low, high = sorted((side * _CROSSHEAD_HALF_HEIGHT * u, side * (_CROSSHEAD_HALF_HEIGHT + _BAR_THICKNESS) * u))
            yield make_rectangle("rod", near, far, low, high)


def _passage_outline(chain: Sequence[Vec2], width: float) -> tuple[Vec2, ...]:
    """Return the outline (m) of a passage of a width (m) along a chain of points, with sharp corners."""
    normals = [((a[1] - b[1]) / math.dist(a, b), (b[0] - a[0]) / math.dist(a, b)) for a, b in pairwise(chain)]
    left, right = list[Vec2](), list[Vec2]()
    for (x, y), (ax, ay), (bx, by) in zip(chain, (normals[0], *normals), (*normals, normals[-1]), strict=True):
        length = 0.5 * width / (1.0 + ax * bx + ay * by)
        left.append((x + length * (ax + bx), y + length * (ay + by)))
        right.append((x - length * (ax + bx), y - length * (ay + by)))
    return *left, *reversed(right)


# As fractions of the width of the picture.
_SECTION_WIDTH = 0.45
_KEY_PLACE = 0.48
_NOTE_PLACE = 0.71
_NOTE_WIDTH = 0.27
_KEY_SIZE = 0.20
_ROW_HEIGHT, _ROW_GAP = 0.17, 0.025
"""Height of the row below the engine with its gap, and the gap."""
_ASPECT_RATIO = 1.74
"""Least width of the picture over its height: that of the place above the plots of a film, which is then filled."""
_N_SAMPLES = 40
"""Number of times of the run at which the extent of the engine is taken."""
_DIAL_RADII = (0.07, 0.11)
"""Radius of the valve diagram beyond the row, and the largest one in a corner beside the engine."""
_DIAL_ROOM = 1.35
"""Half the side of the square that a diagram needs with its words, in radii."""
_MAX_THROW, _STRAP_RATIO = 0.4, 1.7
"""Largest eccentricity relative to the crank, and radius of a drawn eccentric relative to its eccentricity."""
_ROD_END = 1.25
"""Length of the drawn valve rod from the middle of the section, in half lengths of the chest."""


class ValveGearDrawing(GenericDrawing, ValveGearExtents):
    """Drawing of a valve gear whose valve and piston move along lines."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the engine and the ground of the gear, the section of the valve, the key and the divided circle."""
        note = self._row_place(_NOTE_PLACE, _NOTE_WIDTH)
        scales = {"engine": 1.0, "valve": self._section.scale}
        yield fixed(self._engine.background_shapes())
        yield from super().fixed_parts()
        yield fixed(self._section_axes.place((*block_shapes(self._section), *self._section.background_shapes())))
        yield fixed(key_shapes(self._row_place(_KEY_PLACE, _NOTE_PLACE - _KEY_PLACE), _KEY_SIZE * self._width))
        yield fixed(self._dial.background_shapes())
        yield fixed(scale_note_shapes(note, _KEY_SIZE * self._width, scales))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield steam, piston and valve, the gear, the section of the valve, and the diagram of the last turn."""
        yield from self._engine_parts
        yield from self._section_axes.place_parts(self._section_parts())
        yield Flexible(shapes_at=self._curve_shapes)
        yield from self._dial.crank_parts(self.position_at)

    @cached_property
    def _engine_parts(self) -> tuple[DrawnPart, ...]:
        """Steam, piston and valve, and the gear."""
        return *self._engine.moving_parts(), *self._eccentric_parts(), *super().moving_parts()

    def _eccentric_parts(self) -> Iterator[DrawnPart]:
        """Yield the eccentrics."""
        shaft = self._driver.second
        for point in sorted(self.points_without_pins, key=repr):
            radius = _STRAP_RATIO * math.hypot(point.x - shaft.x, point.y - shaft.y)
            yield Attached(frame=self.body_axes(point.body), shapes=(Circle("eccentric", point.x, point.y, radius),))

    @cached_property
    def points_without_pins(self) -> frozenset[Point]:
        """Centres of eccentrics: points of the crank that drive the gear from near the shaft, each around it with a strap."""
        mechanism, shaft = self.part.mechanism, self._driver.second
        points = {end for joint in mechanism.joints for end in (joint.first, joint.second) if end.body == shaft.body}
        return frozenset(one for one in points if 0.0 < math.hypot(one.x - shaft.x, one.y - shaft.y) < _MAX_THROW * self.crank)

    def named_places(self, poses: FloatArray) -> dict[str, FloatArray]:
        """Return the places (n, 2) m of the bodies, and of valve and piston where the engine has them, at poses (n, bodies, 3)."""
        positions = [self.position(pose, float(self.run.times[0])) for pose in poses]
        valve, piston = (np.array([place(one) for one in positions]) for place in (self._engine.valve_place, self._engine.piston_place))
        return super().named_places(poses) | {self.valve_line.point.body: valve, "piston": piston}

    def _section_parts(self) -> Iterator[DrawnPart]:
        """Yield the ports with their steam, and the valve."""
        for side in (1.0, -1.0):
            yield from port_parts(self._section, partial(self.phase_at, side), side)
        rod_end = _ROD_END * self._section.half_length
        yield from self._section.valve_parts(lambda moment: self.position_at(moment).valve_displacement, rod_end, rod_moves=False)

    def _curve_shapes(self, moment: Moment) -> Iterator[DrawnShape]:
        """Yield the displacements of the turn before."""
        position = self.position_at(moment)
        sense = position.sense
        angles, displacements = steam_distribution.turn_before(sense * self.crank_angles, self.displacements, sense * position.crank_angle)
        yield from self._dial.curve_shapes(sense * angles, displacements)

    @cached_property
    def _engine(self) -> EngineInPlace:
        return EngineInPlace(self)

    @cached_property
    def _engine_shapes(self) -> Sequence[DrawnShape]:
        """The shapes of the engine with its gear at times of the run."""
        shapes = [*self._engine.background_shapes(), *shapes_of(super().fixed_parts(), self.first_moment)]
        for k in range(0, len(self.poses), max(1, len(self.poses) // _N_SAMPLES)):
            shapes += shapes_of(self._engine_parts, Moment(self.poses[k], float(self.run.times[k])))
        return shapes

    @cached_property
    def _upper_box(self) -> BoundingBox:
        """Box (m) of the part of the picture with engine and gear, as wide as suits the height of the whole."""
        left, right, bottom, top = bounding_box(self._engine_shapes)
        filled_width = _ASPECT_RATIO * (top - bottom) / (1.0 - _ASPECT_RATIO * _ROW_HEIGHT)
        margin = max(0.5 * (filled_width - (right - left)), 0.0)
        return left - margin, right + margin, bottom, top

    @property
    def _width(self) -> float:
        left, right, _, _ = self._upper_box
        return right - left

    @property
    def _crank_side(self) -> float:
        """-1 if the crank end lies at the left."""
        return -1.0 if self.piston_line.direction[0] >= 0.0 else 1.0

    def _row_place(self, start: float, width: float) -> Vec2:
        """Return the upper left corner (m) of what begins in the row at a distance from the side of the shaft, in widths of the picture."""
        left, right, bottom, _ = self._upper_box
        x = left + start * self._width if self._crank_side < 0 else right - (start + width) * self._width
        return x, bottom - _ROW_GAP * self._width

    @cached_property
    def _section(self) -> SteamChest:
        """The chest at a larger scale."""
        unit = make_chest(self, 1.0)
        return make_chest(self, _SECTION_WIDTH * self._width / ((1.0 + _ROD_END) * unit.half_length))

    @cached_property
    def _section_axes(self) -> Placement:
        """Axes in the middle of the face of the section; x leads to the side of the picture where the shaft is."""
        left, top = self._row_place(0.0, _SECTION_WIDTH)
        side, chest = self._crank_side, self._section
        x = left + (_ROD_END if side < 0 else 1.0) * chest.half_length
        return Placement(origin=(x, top - chest.top), x_axis=(side, 0.0), y_axis=(0.0, 1.0))

    @cached_property
    def _dial(self) -> steam_distribution.ZeunerDial:
        """The valve diagram: in the largest free corner beside the engine, or else beyond the row below it."""
        left, right, bottom, top = box = self._upper_box
        smallest, largest = (radius * self._width for radius in _DIAL_RADII)
        (x, y), side = find_free_corner(self._engine_shapes, box)
        radius = min(0.5 * side / _DIAL_ROOM, largest)
        if radius < smallest:
            radius, y = smallest, bottom  # at the far end of the row
            x = right + 2 * _DIAL_ROOM * radius if self._crank_side < 0 else left - 2 * _DIAL_ROOM * radius
        inward = _DIAL_ROOM * radius
        place = x + math.copysign(inward, left + 0.5 * self._width - x), y + math.copysign(inward, 0.5 * (bottom + top) - y)
        return steam_distribution.ZeunerDial(self, place, radius, self.crank_end_angle)
