"""Places in the drawing of an engine room, in pixels of a 480-pixel frame, from its lower left corner; y is up."""

from typing import Final

from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2

WIDTH: Final = 556.0
HEIGHT: Final = 392.0
FLOOR: Final = 14.0

CRANK_RADIUS: Final = 46.0
"""Length of the drawn crank, to which the scale of an engine refers."""
ENGINE_LEFT: Final = 8.0

GOVERNOR_AXIS: Final = 290.0
GOVERNOR_HALF_WIDTH: Final = 92.0
GOVERNOR_BASE: Final = 176.0
GOVERNOR_TOP: Final = HEIGHT - 3.0
LAYSHAFT: Final[Vec2] = (GOVERNOR_AXIS, 148.0)
"""Shaft of the pulley that turns the spindle through bevel gears."""
MIN_PULLEY, MAX_PULLEY = 7.0, 18.0
"""Radii between which the pulleys to the governor are drawn."""

CYLINDER_END, CYLINDER_BASE = 511.7, 78.4
"""Right end and lower edge of a horizontal cylinder."""
PIPE_AXIS: Final = 530.0
PIPE_HALF_WIDTH: Final = 12.0
PIPE_WALL: Final = 2.5

LINE_SHAFT: Final[Vec2] = (42.0, 334.0)
LOAD_PULLEY: Final = 20.0
"""Radius of the pulleys to the line shaft."""
BRAKE_ARM: Final = 104.0
"""Length of the lever of the brake."""
MAX_WEIGHT_HEIGHT, WEIGHT_WIDTH = 70.0, 36.0
"""Size of the weight on the brake at the largest load."""

SLIDE_SCALE: Final[BoundingBox] = (408.2, 500.2, 124.4, 138.4)
"""Left and right end of a scale, which is the stroke of a horizontal cylinder, and lower and upper edge of the slide on it."""
