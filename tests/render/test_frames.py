"""Bodies with several pins are frames, which hide neither pins nor points."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import governor_mechanism as gm
from decoding import data_of, decode_film
from drawing_checks import Drawn
from governor_mechanism.render.artists import artist_paths, group_shapes
from governor_mechanism.render.film.moving_parts import PartPaths
from governor_mechanism.render.film.outside_view import area_of
from governor_mechanism.render.film.painters import make_painter
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.outlines import shrink_convex
from governor_mechanism.render.geometry.primitives import Circle, Polygon, TextShape
from governor_mechanism.render.machines.generic.bodies import body_outline_shapes
from governor_mechanism.render.part_run import motion_at_rest
from governor_mechanism.render.style import PAPER, ROLE_STYLES, parse_rgb


def _is_inside(point, outline):
    """Return whether a point is inside a closed outline, by the number of its edges that a ray to the right meets."""
    x, y = point
    edges = [(p, q) for p, q in itertools.pairwise((*outline, outline[0])) if (p[1] > y) != (q[1] > y)]
    return sum(x < x0 + (y - y0) * (x1 - x0) / (y1 - y0) for (x0, y0), (x1, y1) in edges) % 2 == 1


def _hides(shape, point):
    """Return whether a shape with an opaque fill covers a point."""
    style = ROLE_STYLES[shape.role]
    if style.fill == "none" or style.opacity < 1.0:
        return False
    if isinstance(shape, Circle):
        return math.dist(point, (shape.x, shape.y)) < shape.radius
    return isinstance(shape, Polygon) and bool(shape.points) and _is_inside(point, shape.points)


@pytest.mark.parametrize("name", ["jansen", "klann", "cognates", "quadruplane", "plagiograph", "roberts"])
def test_no_frame_hides_a_pin_or_a_point(name):
    scene = gm.load(name)
    motion = gm.kinematics(scene, over="time", values=np.linspace(0.0, scene.run.duration, 13))
    drawn = Drawn(motion_at_rest(scene, motion.poses, motion.readings))
    assert len(drawn.moving) == 13
    for shapes in drawn.moving:
        for k, shape in enumerate(shapes):
            if shape.role in ("pivot", "tracer"):
                assert not any(_hides(above, (shape.x, shape.y)) for above in shapes[k + 1 :] if above.role not in ("pivot", "tracer"))
        # The ground under a web stays visible, too: all webs are behind all bars, and let what is behind them show through.
        roles = [shape.role for shape in shapes]
        assert max(k for k, role in enumerate(roles) if role == "plate web") < roles.index("plate")


def test_a_frame_has_bars_along_its_edges_and_to_the_points_inside():
    width, corners, inside = 0.1, [(0.0, 0.0), (2.0, 0.0), (0.0, 1.5)], (0.6, 0.5)
    web, rib, rim, edge = body_outline_shapes([*corners, inside], width)
    assert [shape.role for shape in (web, rib, rim, edge)] == ["plate web", "plate", "plate rim", "plate edge"]
    outer, inner = edge.lines
    # The opening is the triangle whose edges are half a width inside: its inscribed circle is half a width smaller.
    radius = 0.5
    assert max(min(y, x, (6.0 - 3 * x - 4 * y) / 5) for x, y in inner) == pytest.approx(width / 2)
    assert area_of(np.array(inner[:-1])) == pytest.approx(1.5 * (1.0 - width / 2 / radius) ** 2)
    assert area_of(np.array(rim.points)) == pytest.approx(area_of(np.array(outer[:-1])) - area_of(np.array(inner[:-1])))
    assert all(_hides(rim, middle) for middle in [(1.0, 0.0), (0.0, 0.7), (1.0, 0.75), *corners])
    assert not _hides(rim, inside)
    assert _hides(rib, inside)
    assert _hides(rib, (0.3, 0.25))


def test_a_narrow_body_is_a_plate_without_an_opening():
    (plate,) = body_outline_shapes([(0.0, 0.0), (2.0, 0.0), (1.0, 0.1)], 0.1)
    assert plate.role == "plate"


@given(st.integers(3, 9), st.floats(0.05, 0.95), st.floats(0.0, 6.0))
def test_a_regular_polygon_shrinks_by_the_distance_of_its_edges(n_corners, share, turn):
    angles = turn + 2 * math.pi * np.arange(n_corners) / n_corners
    corners = list(zip(np.cos(angles).tolist(), np.sin(angles).tolist(), strict=True))
    apothem = math.cos(math.pi / n_corners)
    shrunk = shrink_convex(corners, share * apothem)
    assert area_of(np.array(shrunk)) == pytest.approx(area_of(np.array(corners)) * (1.0 - share) ** 2, rel=1e-9)
    assert shrink_convex(corners, 1.01 * apothem) == []


def test_a_gif_shows_webs_without_traces_of_earlier_ones(tmp_path):
    run = gm.run("jansen", certify=False)
    options = {"layout": "machine", "stop": 1.0, "slow_down": 1.0, "frames_per_second": 10, "paths": []}
    decoded, _ = decode_film(run.film(tmp_path / "leg.gif", **options))
    painter = make_painter((run,), (0.0, 1.0), schedule_frames(0.0, 1.0, 10.0), 1.0, gm.FilmOptions(**options))
    style, paper = ROLE_STYLES["plate web"], np.array(parse_rgb(PAPER))
    web = np.rint(style.opacity * np.array(parse_rgb(style.fill)) + (1.0 - style.opacity) * paper)
    for k, shown in enumerate(decoded):
        painted = painter.paint(k)[..., :3].astype(int)
        for colour in (web, paper):
            is_flat = np.abs(painted - colour).max(axis=2) <= 1
            assert is_flat.sum() > 1000
            assert np.abs(shown[is_flat] - colour).max() <= 1


@pytest.mark.parametrize("name", ["porter_clearance", "andrews_squeezer", "anchor_escapement", "ratchet"])
def test_paths_that_are_moved_are_those_of_the_shapes_that_are_drawn_anew(name):
    run = gm.run(gm.load(name).replace({"run.duration": "10 ms" if name == "andrews_squeezer" else "0.4 s"}), certify=False)
    data = data_of(run, 7)
    parts = data.moving_parts()
    paths_at = PartPaths(parts)
    for k in (0, 3, 6, 2):
        shapes = list(shapes_of(parts, k))
        for group, moved, drawn in zip(group_shapes(shapes), paths_at(k), artist_paths(shapes), strict=True):
            if isinstance(group[0], TextShape) or (isinstance(group[0], Circle) and any(one.radius == 0.0 for one in group)):
                continue  # words stay, and a circle that is not there has no points
            if not any(len(getattr(one, "points", getattr(one, "lines", "one"))) for one in group):
                assert not np.isfinite(moved.vertices).any()  # it is not there
                continue
            points, expected = (np.asarray(path.vertices).reshape(-1, 2) for path in (moved, drawn))
            assert points.shape == expected.shape
            if isinstance(group[0], Circle):  # it turns with its part
                points, expected = (
                    np.hypot(*(one.reshape(len(group), -1, 2) - [[(c.x, c.y)] for c in group]).T) for one in (points, expected)
                )
            scale = data.part.mechanism.length_scale
            np.testing.assert_allclose(points, expected, atol=1e-12 * scale)
