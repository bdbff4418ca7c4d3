"""The view of a plane from metres to pixels: of a machine in its rectangle of a film, a page or a notebook."""

from dataclasses import dataclass, replace

from governor_mechanism.render.geometry.primitives import BoundingBox

PixelRect = tuple[float, float, float, float]
"""left, top, right, bottom (pixels) from the upper left corner of the frame."""

ELEVATION_RECT: PixelRect = (8.0, 42.0, 286.0, 436.0)
"""Rectangle of the machine in a film of 480 pixels."""


@dataclass(frozen=True, kw_only=True)
class PixelView:
    """View of a plane in `rect` (pixels): `scale` pixels per metre, with the point (x, y) (m) in the middle."""

    rect: PixelRect
    scale: float
    x: float
    y: float

    @property
    def box(self) -> BoundingBox:
        """Return the bounding box (m) that the whole rectangle shows: left, right, bottom, top."""
        left, top, right, bottom = self.rect
        half_width, half_height = (right - left) / 2 / self.scale, (bottom - top) / 2 / self.scale
        return self.x - half_width, self.x + half_width, self.y - half_height, self.y + half_height

    def row_of(self, y: float) -> float:
        """Return the row (pixels from the top) of a height (m)."""
        return (self.rect[1] + self.rect[3]) / 2 - (y - self.y) * self.scale

    def height_of(self, row: float) -> float:
        """Return the height (m) of a row (pixels from the top)."""
        return self.y - (row - (self.rect[1] + self.rect[3]) / 2) / self.scale

    def line_x(self, distance: float) -> float:
        """Return the place (m) at a distance (pixels) right of the rectangle."""
        return self.box[1] + distance / self.scale


def fit_view(box: BoundingBox, rect: PixelRect) -> PixelView:
    """Return the view that shows a box (m) as large as possible and centred in `rect`."""
    left, top, right, bottom = rect
    x0, x1, y0, y1 = box
    scale = min((right - left) / (x1 - x0), (bottom - top) / (y1 - y0))
    return PixelView(rect=rect, scale=scale, x=(x0 + x1) / 2, y=(y0 + y1) / 2)


def share_scale(first: PixelView, second: PixelView) -> tuple[PixelView, PixelView]:
    """Return two views of one machine on the smaller of their scales; the second shows like heights at the heights of the first."""
    scale = min(first.scale, second.scale)
    middles = [(view.rect[1] + view.rect[3]) / 2 for view in (first, second)]
    return replace(first, scale=scale), replace(second, scale=scale, y=first.y + (middles[0] - middles[1]) / scale)
