"""Shapes are plain, stand where the mechanism stands, and stay within the view."""

import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest

from decoding import painter_of, pixel_of
from drawing_checks import Drawn, assert_shapes_keep, assert_within, of_role
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.part import Part
from governor_mechanism.render.film.frame_painter import plan_parts
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import Attached, BodyAxes, Flexible, Moment, fixed, shapes_of
from governor_mechanism.render.geometry.outlines import first_free_position, make_bar, make_hatching
from governor_mechanism.render.geometry.primitives import (
    Circle,
    Lines,
    Polygon,
    TextShape,
    bounding_box,
    drawn_ball_radius,
    enclose_boxes,
    round_step,
)
from governor_mechanism.render.geometry.recording import enclose_recorded, horizontal_extents, record_parts
from governor_mechanism.render.machines import registry
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.registry import drawing_of
from stub_run import GOVERNOR_DIMENSIONS, fake_run, sleeve_height


def as_unknown(part: Part) -> Part:
    """The same mechanism under a name that no drawing is registered for."""
    return dataclasses.replace(part, machine="nobody's machine")


@pytest.fixture(scope="module", params=[(name, known) for name in GOVERNOR_DIMENSIONS for known in (True, False)], ids=str)
def drawn(request):
    name, known = request.param
    run = fake_run(GOVERNOR_DIMENSIONS[name], duration=2.0, output_interval=0.05, mean_angle=30.0)
    return Drawn(run, None if known else as_unknown(run.scene.part))


@pytest.fixture(scope="module")
def porter():
    return Drawn(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0))


def test_shapes_do_not_import_a_plotting_library():
    code = (
        "import sys; from governor_mechanism.render.machines import registry, valve_gear; list(registry.MACHINE_DRAWINGS.values());"
        "print([m for m in ('matplotlib', 'PIL') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_view_fits_the_extent_into_its_rectangle_without_distortion(porter):
    view = painter_of(porter.run, 101).view
    left, top, right, bottom = view.rect
    x0, x1, y0, y1 = porter.drawing.bounds
    corners = [pixel_of(view, x, y) for x in (x0, x1) for y in (y0, y1)]
    # Pixel numbers count middles of pixels, so the edge of a rectangle is half a pixel beyond the last one.
    assert all(left - 0.5 - 1e-9 <= column <= right - 0.5 + 1e-9 for column, _ in corners)
    assert all(top - 0.5 - 1e-9 <= row <= bottom - 0.5 + 1e-9 for _, row in corners)
    across, upward = pixel_of(view, 1.0, 0.0)[0] - pixel_of(view, 0.0, 0.0)[0], pixel_of(view, 0.0, 0.0)[1]
    assert across == pytest.approx(upward - pixel_of(view, 0.0, 1.0)[1])


def test_shapes_keep_their_kinds_and_roles_within_the_view(drawn):
    assert_shapes_keep(drawn)
    plans = {tuple((type(s), s.role) for s in drawn.drawing.dial_shapes(pose, 0.3, 1.0)) for pose in drawn.run.poses}
    assert len(plans) == 1


def test_balls_are_drawn_at_their_mass_centres_and_as_large_as_cast_iron(porter):
    left, right = of_role(porter.at(7), "ball", Circle)
    assert [(one.x, one.y) for one in (right, left)] == [tuple(pose[:2]) for pose in porter.run.poses[7, :2]]
    assert 4 / 3 * math.pi * right.radius**3 * 7200 == pytest.approx(5.0)


def test_a_ball_too_light_or_too_heavy_to_be_seen_well_is_drawn_at_the_limit():
    assert drawn_ball_radius(1e-6, 0.4) == pytest.approx(0.016)
    assert drawn_ball_radius(1e6, 0.4) == pytest.approx(0.08)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_links_are_drawn_in_their_true_length(name):
    drawn = Drawn(fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, mean_angle=30.0))
    governor = PendulumGovernor(**GOVERNOR_DIMENSIONS[name])
    far = [max(math.dist(p, q) for p in link.points for q in link.points) for link in of_role(drawn.at(3), "link", Polygon)]
    # A bar ends in half circles round the two pins.
    assert far == pytest.approx(2 * [governor.link_length + 0.042 * governor.arm], rel=1e-9)


def test_a_sleeve_without_mass_hangs_from_its_links():
    run = fake_run(GOVERNOR_DIMENSIONS["watt"], duration=1.0)
    governor = PendulumGovernor(**GOVERNOR_DIMENSIONS["watt"])
    lugs = min(pivot.y for pivot in of_role(Drawn(run).at(40), "pivot", Circle))
    assert lugs == pytest.approx(float(sleeve_height(governor, run.readings["arm_angle"][40:41])[0]), abs=1e-12)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_the_pointer_shows_the_lift_on_the_scale(name):
    drawn = Drawn(fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, mean_angle=30.0))
    for k in (0, 33, 77):
        assert drawn.shown_lift(k) == pytest.approx(drawn.run.readings["sleeve_lift"][k], abs=1e-9)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
@pytest.mark.parametrize(("middle", "swing"), [(30.0, 8.0), (58.0, 27.0)])
def test_nothing_passes_over_the_scale(name, middle, swing):
    dimensions = GOVERNOR_DIMENSIONS[name] | ({"link": 0.45} if "link" in GOVERNOR_DIMENSIONS[name] else {})
    drawn = Drawn(fake_run(dimensions, duration=2.0, output_interval=0.02, mean_angle=middle, amplitude=swing))
    scale = of_role(drawn.still, "scale", Lines)[0]
    left, right, bottom, top = bounding_box([scale, *(s for s in drawn.still if isinstance(s, TextShape))])
    moments = [Moment(pose, 0.0) for pose in drawn.run.poses]
    passing = [shape for shape in record_parts(drawn.drawing.moving, moments) if shape.role in ("arm", "link", "ball")]
    assert all(high <= left or low >= right for low, high in horizontal_extents(passing, bottom, top))


def test_widths_between_two_heights():
    ball, slope = Circle("ball", 1.0, 0.0, 0.5), Polygon("arm", ((0.0, 0.0), (4.0, 4.0), (4.0, 4.1)))
    balls, slopes = (record_parts([fixed([one])], [None]) for one in (ball, slope))
    assert horizontal_extents(balls, 0.3, 2.0) == [pytest.approx((0.6, 1.4))]
    assert horizontal_extents(balls, 0.5, 2.0) == []
    assert horizontal_extents(slopes, 1.0, 2.0) == [pytest.approx((1.0 / 1.025, 2.0))]


def test_the_box_around_recorded_shapes_is_that_of_the_shapes_at_each_moment():
    moments = [Moment(np.array([[0.3, 0.1, angle]]), 0.0) for angle in (0.0, 0.7, 2.0)]
    shapes = (Circle("ball", 1.0, 0.0, 0.5), Polygon("arm", ((0.0, 0.0), (4.0, 4.0), (4.0, 4.1))), TextShape("note", 0.0, 1.0, "a", 5.0))
    parts = [Attached(frame=BodyAxes(0), shapes=shapes), Flexible(shapes_at=lambda moment: [Circle("pin", 0.0, 9.0, moment.pose[0, 2])])]
    box = enclose_recorded(record_parts(parts, moments))
    assert box == pytest.approx(enclose_boxes(bounding_box(shapes_of(parts, moment)) for moment in moments))


def test_the_first_free_position():
    assert first_free_position([(1.0, 2.0), (0.0, 0.5), (2.2, 3.0)], 0.6, 0.3) == 0.6
    assert first_free_position([(1.0, 2.0), (0.0, 0.5), (2.2, 3.0)], 0.6, 0.5) == 3.0


def test_the_scale_covers_the_travel_and_its_numbers_stand_apart_even_at_rest():
    drawn = Drawn(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, amplitude=1e-6))
    low, high = (s for s in drawn.still if isinstance(s, TextShape))
    assert high.y - low.y >= 0.1 * 0.3 - 1e-12


def test_the_plan_turns_anticlockwise_with_the_spindle_and_stays_within_its_ring(porter):
    drawing, poses = porter.drawing, porter.run.poses
    ring = drawing.dial_ring_radius()
    (mark, *_) = of_role(drawing.dial_shapes(poses[0], math.pi / 2, ring), "mark")
    assert (mark.x, mark.y) == (pytest.approx(0.0, abs=1e-12), pytest.approx(poses[0, 0, 0]))
    balls = (ball for pose in poses for ball in of_role(drawing.dial_shapes(pose, 1.0, ring), "ball"))
    assert all(math.hypot(ball.x, ball.y) + ball.radius < ring for ball in balls)


def test_a_speed_beyond_the_frames_closes_the_ring(porter):
    data = FrameData(porter.run, porter.run.scene.part, (0.0, 1.0), np.array([0.0, 1.0]))
    assert np.ptp(data.spindle_angle) > 2 * math.pi
    arrow, head, *_ = shapes_of(plan_parts(data, 1.0), 1)
    assert isinstance(arrow, Lines)
    angles = np.unwrap([math.atan2(y, x) for x, y in arrow.lines[0]])
    # The head has the rest, up to where the line begins.
    assert 2 * math.pi - 0.26 < np.ptp(angles) < 2 * math.pi
    assert min(math.dist(arrow.lines[0][0], point) for point in head.points) == pytest.approx(0.0, abs=1e-12)


def test_a_machine_is_drawn_by_what_is_registered_for_it(monkeypatch):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)

    class Dot(GenericDrawing):
        def moving_shapes(self, pose, time):
            return (Circle("ball", 1.0, 2.0, 3.0),)

    monkeypatch.setattr(registry, "MACHINE_DRAWINGS", {"nobody's machine": Dot})
    drawing = drawing_of(run, as_unknown(run.scene.part))
    assert drawing.moving_shapes(run.poses[0], 0.0) == (Circle("ball", 1.0, 2.0, 3.0),)


def test_any_mechanism_is_drawn_with_all_its_bodies_and_links(porter):
    drawn = Drawn(porter.run, as_unknown(porter.run.scene.part))
    shapes = drawn.at(0)
    assert [(s.x, s.y) for s in of_role(shapes, "ball", Circle)] == [tuple(pose[:2]) for pose in porter.run.poses[0, :2]]
    assert [len(of_role(shapes, role)) for role in ("block", "link")] == [1, 4]
    assert of_role(drawn.still, "guide")


def test_hatching_stays_within_its_box():
    box = (-0.02, 0.03, 0.01, 0.04)
    assert_within([make_hatching("hatching", box, 0.004)], box, margin=1e-12)


def test_a_bar_without_length_is_a_disc():
    assert bounding_box([make_bar("arm", (1.0, 2.0), (1.0, 2.0), 0.4)]) == pytest.approx((0.8, 1.2, 1.8, 2.2))


@pytest.mark.parametrize(("span", "most", "step"), [(1.0, 5, 0.2), (0.11, 5, 0.05), (7.0, 8, 1.0), (0.3, 3, 0.1)])
def test_steps_are_one_two_or_five(span, most, step):
    assert round_step(span, most) == pytest.approx(step)
