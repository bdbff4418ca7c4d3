"""Parts that touch are drawn so that the contact is seen: what is fixed looks fixed, what rolls has a mark, nothing covers the outlines."""

import json
import math

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import curve_of
from drawing_checks import Drawn, of_role
from governor_mechanism.render.geometry.primitives import Polygon
from governor_mechanism.render.page.page_data import collect_data
from governor_mechanism.render.page.views import show_run
from governor_mechanism.render.page.writer import choose_sample_times

SLOPE = """
machine = "custom"
title = "A disc rolls down a slope"
body = [
  { name = "slope", mass = "1 kg", inertia = "1 kg m^2", outline = [
    ["-0.3 m", "-0.2 m"], ["0.5 m", "-0.2 m"], ["0.5 m", "-0.1 m"], ["-0.3 m", 0] ] },
  { name = "disc", mass = "0.2 kg", disc = { radius = "30 mm" }, at = ["-0.15 m", "12 mm"] },
]
joint = [{ type = "weld", first = "ground.origin", second = "slope.origin" }]
contact = [{ name = "disc", first = "disc.origin", radius = "30 mm", second = "slope", friction = 0.3 }]
readings = { x = { x = "disc.origin" }, y = { y = "disc.origin" } }
effects = { gravity = true }
start = { x = "-0.15 m", disc_gap = 0, x_rate = 0, y_rate = 0 }
run = { duration = "0.2 s", output_interval = "20 ms", readings = ["contact.disc"] }
"""


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    path = tmp_path_factory.mktemp("slope") / "slope.toml"
    path.write_text(SLOPE)
    return Drawn(gm.run(gm.load(path), certify=False))


def test_a_weld_is_a_floor_along_the_underside_and_no_pivot(slope):
    assert not of_role(slope.still, "frame")
    (floor,) = of_role(slope.still, "wall")
    line, *hatching = floor.lines
    assert sorted(x for x, _ in line) == pytest.approx([-0.3, 0.5])
    assert [y for _, y in line] == pytest.approx([-0.2, -0.2])
    assert max(y for stroke in hatching for _, y in stroke) <= -0.2 + 1e-12


def test_a_disc_that_rolls_has_a_radius_that_turns_with_it_and_no_letters_cover_it(slope):
    disc = slope.run.scene.part.mechanism.body_index("disc")
    for pose, shapes in zip(slope.run.poses, slope.moving, strict=True):
        (mark,) = of_role(shapes, "marked spoke")
        ((x0, y0), (x1, y1)) = mark.lines[0]
        x, y, angle = pose[disc]
        assert (x0, y0) == pytest.approx((x, y))
        assert (x1 - x0, y1 - y0) == pytest.approx((0.03 * math.cos(angle), 0.03 * math.sin(angle)))
        assert not {"letter", "ball"} & {shape.role for shape in shapes}
    assert abs(slope.run.poses[-1, disc, 2]) > 0.5


def test_a_cam_has_a_radius_that_turns_with_it_and_stays_within_it():
    """From the shaft as far as the base circle of 40 mm."""
    run = gm.run(gm.load("disc_cam_flat_follower").replace({"run.duration": "20 ms", "run.output_interval": "2 ms"}), certify=False)
    drawn, cam = Drawn(run), run.scene.part.mechanism.body_index("cam")
    for pose, shapes in zip(run.poses, drawn.moving, strict=True):
        (mark,) = of_role(shapes, "marked spoke")
        start, end = mark.lines[0]
        assert start == pytest.approx((0.0, 0.0), abs=1e-9)
        assert end == pytest.approx((0.04 * math.cos(pose[cam, 2]), 0.04 * math.sin(pose[cam, 2])), rel=1e-3, abs=1e-6)
    assert np.ptp(run.poses[:, cam, 2]) > 1.0


def test_the_outline_of_a_follower_stands_in_front_of_its_block():
    document = gm.load("disc_cam_flat_follower").document
    on_the_flat = {"type": "prismatic", "second": "follower.origin"}
    joints = [{**joint, **on_the_flat} if joint.get("name") == "guide" else joint for joint in document["joint"]]
    run = gm.run(gm.Scene.from_dict({**document, "joint": joints, "run": {"duration": "2 ms", "output_interval": "1 ms"}}), certify=False)
    shapes = Drawn(run).at(0)
    block = next(number for number, shape in enumerate(shapes) if shape.role == "block")
    outlines = [number for number, shape in enumerate(shapes) if isinstance(shape, Polygon) and shape.role == "plate"]
    assert block < min(outlines)


def test_a_page_has_the_profile_that_is_touched_and_the_forces_of_the_contact(slope):
    """A disc that rolls presses with m g cos(a), and a third of m g sin(a) keeps it from sliding; the film draws the same profile."""
    span = 0.0, float(slope.run.times[-1])
    shown = show_run(slope.run, None, span, choose_sample_times(slope.run, span, 1.0), 1.0)
    data = json.loads(json.dumps(collect_data(shown, 1.0)))
    corners = [(-0.3, -0.2), (0.5, -0.2), (0.5, -0.1), (-0.3, 0.0)]
    expected = {tuple(np.round(point)) for point in shown.views[0].picture.place(np.array(corners))}
    plates = [shape for shape in data["views"][0]["shapes"] if shape["role"] == "plate"]
    drawn = [{tuple(point) for point in np.array(shape["points"], dtype=float).reshape(-1, 2)} for shape in plates]
    assert any(all(min(math.dist(corner, point) for point in points) <= 1.5 for corner in expected) for points in drawn)
    slope_angle = math.atan(0.125)
    for name, force in (("force", 0.2 * 9.81 * math.cos(slope_angle)), ("friction", 0.2 * 9.81 * math.sin(slope_angle) / 3)):
        plot = next(plot for plot in data["plots"] if name in plot["name"])
        values, quantum = curve_of(plot)
        assert np.abs(values) == pytest.approx(force, abs=max(quantum, 1e-6))
