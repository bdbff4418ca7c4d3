"""Shapes are plain, stand where the mechanism stands, and stay within the view."""

import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest

from decoding import pixel_of
from drawing_checks import assert_shapes_keep
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.part import Part
from governor_mechanism.render.film.frame_painter import FramePainter
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
    part = run.scene.part
    return run, drawing_of(run, part if known else as_unknown(part))


def test_shapes_do_not_import_a_plotting_library():
    code = "import governor_mechanism.render.machines.registry, sys; print([m for m in ('matplotlib', 'PIL') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_view_fits_the_extent_into_its_rectangle_without_distortion():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    view = FramePainter(run, [FrameData(run, run.scene.part, (0.0, 1.0), run.times)]).view
    left, top, right, bottom = view.rect
    x0, x1, y0, y1 = drawing_of(run, run.scene.part).bounds
    corners = [pixel_of(view, x, y) for x in (x0, x1) for y in (y0, y1)]
    # Pixel numbers count middles of pixels, so the edge of a rectangle is half a pixel beyond the last one.
    assert all(left - 0.5 - 1e-9 <= column <= right - 0.5 + 1e-9 for column, _ in corners)
    assert all(top - 0.5 - 1e-9 <= row <= bottom - 0.5 + 1e-9 for _, row in corners)
    across, upward = pixel_of(view, 1.0, 0.0)[0] - pixel_of(view, 0.0, 0.0)[0], pixel_of(view, 0.0, 0.0)[1]
    assert across == pytest.approx(upward - pixel_of(view, 0.0, 1.0)[1])


def test_shapes_keep_their_kinds_and_roles_within_the_view(drawn):
    run, drawing = drawn
    assert_shapes_keep(drawing, run)
    plans = {tuple((type(s), s.role) for s in drawing.dial_shapes(pose, 0.3, 0.1, 1.0)) for pose in run.poses}
    assert len(plans) == 1


def test_balls_are_drawn_at_their_mass_centres_and_as_large_as_cast_iron():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    left, right = (
        s for s in drawing_of(run, run.scene.part).moving_shapes(run.poses[7], 0.0) if isinstance(s, Circle) and s.role == "ball"
    )
    assert (right.x, right.y) == tuple(run.poses[7, 0, :2])
    assert (left.x, left.y) == tuple(run.poses[7, 1, :2])
    assert 4 / 3 * math.pi * right.radius**3 * 7200 == pytest.approx(5.0)


def test_a_ball_too_light_or_too_heavy_to_be_seen_well_is_drawn_at_the_limit():
    assert drawn_ball_radius(1e-6, 0.4) == pytest.approx(0.016)
    assert drawn_ball_radius(1e6, 0.4) == pytest.approx(0.08)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_links_are_drawn_in_their_true_length(name):
    run = fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, mean_angle=30.0)
    governor = PendulumGovernor(**GOVERNOR_DIMENSIONS[name])
    width = 0.042 * governor.arm
    links = [s for s in drawing_of(run, run.scene.part).moving_shapes(run.poses[3], 0.0) if s.role == "link"]
    assert len(links) == 2
    for link in links:
        assert isinstance(link, Polygon)
        far = max(math.dist(p, q) for p in link.points for q in link.points)
        # A bar ends in half circles round the two pins.
        assert far == pytest.approx(governor.link_length + width, rel=1e-9)


def test_a_sleeve_without_mass_hangs_from_its_links():
    run = fake_run(GOVERNOR_DIMENSIONS["watt"], duration=1.0)
    governor = PendulumGovernor(**GOVERNOR_DIMENSIONS["watt"])
    shapes = list(drawing_of(run, run.scene.part).moving_shapes(run.poses[40], 0.0))
    lugs = min(s.y for s in shapes if isinstance(s, Circle) and s.role == "pivot")
    assert lugs == pytest.approx(float(sleeve_height(governor, run.readings["arm_angle"][40:41])[0]), abs=1e-12)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_the_pointer_shows_the_lift_on_the_scale(name):
    run = fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, mean_angle=30.0)
    drawing = drawing_of(run, run.scene.part)
    low, high = (s for s in drawing.background_shapes() if isinstance(s, TextShape))
    first, last = (float(mark.text.removesuffix(" mm")) / 1e3 for mark in (low, high))
    for k in (0, 33, 77):
        tip = next(s for s in drawing.moving_shapes(run.poses[k], 0.0) if s.role == "pointer").points[0][1]
        shown = first + (tip - low.y) / (high.y - low.y) * (last - first)
        assert shown == pytest.approx(run.readings["sleeve_lift"][k], abs=1e-9)


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
@pytest.mark.parametrize(("middle", "swing"), [(30.0, 8.0), (58.0, 27.0)])
def test_nothing_passes_over_the_scale(name, middle, swing):
    run = fake_run(
        GOVERNOR_DIMENSIONS[name] | ({"link": 0.45} if "link" in GOVERNOR_DIMENSIONS[name] else {}),
        duration=2.0,
        output_interval=0.02,
        mean_angle=middle,
        amplitude=swing,
    )
    drawing = drawing_of(run, run.scene.part)
    still = list(drawing.background_shapes())
    scale = next(s for s in still if isinstance(s, Lines) and s.role == "scale")
    left, right, bottom, top = bounding_box([scale, *(s for s in still if isinstance(s, TextShape))])
    moments = [Moment(pose, 0.0) for pose in run.poses]
    passing = [shape for shape in record_parts(drawing.moving, moments) if shape.role in ("arm", "link", "ball")]
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

    assert first_free_position([(1.0, 2.0), (0.0, 0.5), (2.2, 3.0)], 0.6, 0.3) == 0.6
    assert first_free_position([(1.0, 2.0), (0.0, 0.5), (2.2, 3.0)], 0.6, 0.5) == 3.0


def test_the_scale_covers_the_travel_and_its_numbers_stand_apart_even_at_rest():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, amplitude=1e-6)
    low, high = (s for s in drawing_of(run, run.scene.part).background_shapes() if isinstance(s, TextShape))
    assert high.y - low.y >= 0.1 * 0.3 - 1e-12


def test_the_plan_turns_anticlockwise_with_the_spindle_and_stays_within_its_ring():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    drawing, pose = drawing_of(run, run.scene.part), run.poses[0]
    ring = drawing.dial_ring_radius()
    mark = next(s for s in drawing.dial_shapes(pose, math.pi / 2, 0.2, ring) if s.role == "mark")
    assert mark.x == pytest.approx(0.0, abs=1e-12)
    assert mark.y == pytest.approx(pose[0, 0])
    balls = (s for pose in run.poses for s in drawing.dial_shapes(pose, 1.0, 0.2, ring) if s.role == "ball")
    assert all(math.hypot(ball.x, ball.y) + ball.radius < ring for ball in balls)


def test_a_speed_beyond_the_frames_closes_the_ring():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    arc = drawing_of(run, run.scene.part).dial_shapes(run.poses[0], 0.7, 40.0, 1.0)[0]
    assert isinstance(arc, Lines)
    angles = np.unwrap([math.atan2(y, x) for x, y in arc.lines[0]])
    assert np.ptp(angles) == pytest.approx(2 * math.pi)


def test_a_machine_is_drawn_by_what_is_registered_for_it(monkeypatch):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)

    class Dot(GenericDrawing):
        def moving_shapes(self, pose, time):
            return (Circle("ball", 1.0, 2.0, 3.0),)

    monkeypatch.setattr(registry, "MACHINE_DRAWINGS", {"nobody's machine": Dot})
    drawing = drawing_of(run, as_unknown(run.scene.part))
    assert drawing.moving_shapes(run.poses[0], 0.0) == (Circle("ball", 1.0, 2.0, 3.0),)


def test_any_mechanism_is_drawn_with_all_its_bodies_and_links():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    drawing = drawing_of(run, as_unknown(run.scene.part))
    shapes = list(drawing.moving_shapes(run.poses[0], 0.0))
    balls = [(s.x, s.y) for s in shapes if isinstance(s, Circle) and s.role == "ball"]
    assert balls == [tuple(pose[:2]) for pose in run.poses[0, :2]]
    assert sum(s.role == "block" for s in shapes) == 1
    assert sum(s.role == "link" for s in shapes) == 4
    assert any(s.role == "guide" for s in drawing.background_shapes())


def test_hatching_stays_within_its_box():
    box = (-0.02, 0.03, 0.01, 0.04)
    x0, x1, y0, y1 = bounding_box([make_hatching("hatching", box, 0.004)])
    assert box[0] - 1e-12 <= x0 < x1 <= box[1] + 1e-12
    assert box[2] - 1e-12 <= y0 < y1 <= box[3] + 1e-12


def test_a_bar_without_length_is_a_disc():
    x0, x1, y0, y1 = bounding_box([make_bar("arm", (1.0, 2.0), (1.0, 2.0), 0.4)])
    assert (x0, x1, y0, y1) == pytest.approx((0.8, 1.2, 1.8, 2.2))


@pytest.mark.parametrize(("span", "most", "step"), [(1.0, 5, 0.2), (0.11, 5, 0.05), (7.0, 8, 1.0), (0.3, 3, 0.1)])
def test_steps_are_one_two_or_five(span, most, step):
    assert round_step(span, most) == pytest.approx(step)
