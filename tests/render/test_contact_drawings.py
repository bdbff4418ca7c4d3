"""Parts that touch are drawn so that the contact is seen: what is fixed looks fixed, what rolls has a mark, nothing covers the outlines."""

import math

import pytest

import governor_mechanism as gm
from governor_mechanism.render.geometry.primitives import Polygon
from governor_mechanism.render.machines.registry import drawing_of

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
run = { duration = "0.2 s", output_interval = "20 ms" }
"""


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    path = tmp_path_factory.mktemp("slope") / "slope.toml"
    path.write_text(SLOPE)
    run = gm.run(gm.load(path), certify=False)
    return run, drawing_of(run, run.scene.part)


def of_role(shapes, role):
    return [shape for shape in shapes if shape.role == role]


def test_a_weld_is_a_floor_along_the_underside_and_no_pivot(slope):
    _, drawing = slope
    still = list(drawing.background_shapes())
    assert not of_role(still, "frame")
    (floor,) = of_role(still, "wall")
    line, *hatching = floor.lines
    assert sorted(x for x, _ in line) == pytest.approx([-0.3, 0.5])
    assert [y for _, y in line] == pytest.approx([-0.2, -0.2])
    assert max(y for stroke in hatching for _, y in stroke) <= -0.2 + 1e-12


def test_a_disc_that_rolls_has_a_radius_that_turns_with_it_and_no_letters_cover_it(slope):
    run, drawing = slope
    disc = run.scene.part.mechanism.body_index("disc")
    for pose, time in zip(run.poses, run.times, strict=True):
        shapes = list(drawing.moving_shapes(pose, float(time)))
        (mark,) = of_role(shapes, "marked spoke")
        ((x0, y0), (x1, y1)) = mark.lines[0]
        x, y, angle = pose[disc]
        assert (x0, y0) == pytest.approx((x, y))
        assert (x1 - x0, y1 - y0) == pytest.approx((0.03 * math.cos(angle), 0.03 * math.sin(angle)))
        assert not of_role(shapes, "letter")
        assert not of_role(shapes, "ball")
    assert abs(run.poses[-1, disc, 2]) > 0.5


def test_the_outline_of_a_follower_stands_in_front_of_its_block():
    document = gm.load("disc_cam_flat_follower").document
    on_the_flat = {"type": "prismatic", "second": "follower.origin"}
    joints = [{**joint, **on_the_flat} if joint.get("name") == "guide" else joint for joint in document["joint"]]
    run = gm.run(gm.Scene.from_dict({**document, "joint": joints, "run": {"duration": "2 ms", "output_interval": "1 ms"}}), certify=False)
    drawing = drawing_of(run, run.scene.part)
    shapes = list(drawing.moving_shapes(run.poses[0], 0.0))
    block = next(number for number, shape in enumerate(shapes) if shape.role == "block")
    outlines = [number for number, shape in enumerate(shapes) if isinstance(shape, Polygon) and shape.role == "plate"]
    assert outlines
    assert block < min(outlines)
