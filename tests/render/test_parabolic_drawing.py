"""The drawing of the parabolic governor: rods of constant length carry the sleeve, balls stay on their guides, and effects have shapes."""

import itertools
import math

import pytest

import governor_mechanism as gm
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.render.geometry.primitives import Circle
from governor_mechanism.render.machines.parabolic import N_CELLS, ParabolicDrawing

EFFECTS = {
    "effects.dry_friction": {"sleeve": "2 N"}, "effects.dashpot": {"sleeve": "20 N s/m"}, "effects.spring": {"sleeve": {"rate": "10 N/m"}},
    "effects.stops": {"ball_radius": ["60 mm", "240 mm"], "restitution": 0.3},
}  # fmt: skip


@pytest.fixture(scope="module")
def drawn():
    found = Drawn(gm.run(gm.load("parabolic").replace({"run.duration": "2 s", "run.output_interval": "50 ms"})))
    assert isinstance(found.drawing, ParabolicDrawing)
    return found


def test_the_lazy_tongs_have_bars_of_one_length_at_every_lift(drawn):
    """As accurate as the run, to which 1e-8 of a metre was promised, over bars of some 100 mm."""
    drawing = drawn.drawing
    for pose in drawn.run.poses:
        joints = drawing.tongs_joints(pose)
        assert len(joints) == 2 * N_CELLS + 1
        for (left, _, right), (next_left, _, next_right) in itertools.pairwise(joints):
            lengths = [math.dist(left, next_right), math.dist(right, next_left), math.dist(left, next_left)]
            assert max(abs(length - drawing.half_link) for length in lengths) < 1e-7
    # Two bars of full length cross at each inner joint on the axis; half ones end at the pivot and at the sleeve.
    assert len(of_role(drawn.at(0), "link")) == 2 * (N_CELLS - 1) + 4


def test_the_tongs_join_the_spindle_the_crosshead_and_the_sleeve(drawn):
    run, drawing = drawn.run, drawn.drawing
    for pose, lift in zip(run.poses, run.readings["sleeve_lift"], strict=True):
        joints = drawing.tongs_joints(pose)
        assert joints[0][1] == (0.0, pytest.approx(drawing.upper_pivot_height))
        assert joints[N_CELLS][1][1] == pytest.approx(pose[0, 1], abs=1e-7)
        assert joints[-1][1][1] == pytest.approx(drawing.zero_lift_height + lift, abs=1e-12)


def test_the_pointer_shows_the_lift_and_the_balls_their_guide(drawn):
    for row in (0, -1):
        assert drawn.shown_lift(row) == pytest.approx(drawn.run.readings["sleeve_lift"][row], abs=1e-9)
        for ball in of_role(drawn.at(row), "ball", Circle):
            assert ball.y == pytest.approx(ball.x**2 / 0.621225507207, abs=1e-7)


def test_the_plan_marks_one_ball_and_its_hub_is_not_a_ball(drawn):
    shapes = drawn.drawing.dial_shapes(drawn.run.poses[0], 0.3, drawn.drawing.dial_ring_radius())
    (mark,) = of_role(shapes, "mark")
    assert math.hypot(mark.x, mark.y) == pytest.approx(drawn.run.readings["ball_radius"][0])
    assert all(math.hypot(ball.x, ball.y) >= 0.01 for ball in of_role(shapes, "ball"))


@pytest.mark.parametrize("changes", [{}, EFFECTS], ids=["plain", "effects"])
def test_every_pose_has_the_same_shapes_within_the_view(changes):
    drawn = Drawn(gm.run(gm.load("parabolic").replace({"run.duration": "1 s", "run.output_interval": "50 ms", **changes})))
    assert_shapes_keep(drawn)
    assert {"stop", "wall"} & drawn.roles() == ({"wall"} if changes else set())
    assert ({"held shoe", "shoe", "piston", "spring"} <= drawn.roles()) == bool(changes)
