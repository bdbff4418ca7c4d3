"""Films of wide mechanisms, of governors from outside, and of magnified motions."""

import dataclasses
import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

import governor_mechanism as gm
from decoding import data_of, painter_of, pixel_of, words_of
from drawing_checks import of_role
from governor_mechanism.effects.holding import Stops
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.pictures import FilmView
from governor_mechanism.render.film.layout import REFERENCE_SIZE, frame_layout
from governor_mechanism.render.film.moving_parts import CurvePanel
from governor_mechanism.render.film.outside_view import EYE_DISTANCE_RATIO, OutsideView, outside_box
from governor_mechanism.render.film.timing import MIN_FRAMES_PER_SPINDLE_TURN, SPINDLE_CLOSING_TOLERANCE, find_loop_end, select_timing
from governor_mechanism.render.geometry.primitives import Circle, Polygon, fit_view
from governor_mechanism.render.part_run import magnify_motion
from governor_mechanism.render.style import ROLE_STYLES, parse_rgb
from governor_mechanism.scenes.parser import parse_scene_document
from stub_run import GOVERNOR_DIMENSIONS, fake_run, governor_poses

PERIOD, MEAN, SWING = 1.7, 40.0, 8.0
"""Period (s), mean arm angle and amplitude (degrees) of the stub run."""


@pytest.fixture(scope="module")
def porter():
    """A run of two whole periods, so that the mean of its angle is that of the sine, with its rate."""
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2 * PERIOD, output_interval=PERIOD / 100)
    rate = 2 * np.pi / PERIOD
    return dataclasses.replace(run, rates={"arm_angle": np.radians(SWING) * rate * np.cos(rate * run.times)})


def overlaps(first, second):
    return first[0] < second[2] and second[0] < first[2] and first[1] < second[3] and second[1] < first[3]


@pytest.mark.parametrize("aspect_ratio", [0.4, 1.0, 1.6, 2.4, 6.0])
@pytest.mark.parametrize("n_plots", [0, 1, 3, 4])
@pytest.mark.parametrize("footer", [True, False])
def test_a_wide_machine_is_drawn_larger_and_all_places_are_apart(aspect_ratio, n_plots, footer):
    options = gm.FilmOptions(readings=tuple("abcd"[:n_plots]), footer=footer)
    places, beside = frame_layout(options, False, aspect_ratio), frame_layout(options, False)
    box = 0.0, aspect_ratio, 0.0, 1.0
    scales = [fit_view(box, one.elevation).scale for one in (places, beside)]
    # Twice as wide as high: the plots at its side leave it 278 pixels of 480.
    assert scales[0] > 1.4 * scales[1] if aspect_ratio >= 2.0 else scales[0] >= scales[1]
    rects = [places.elevation, places.caption, *places.reading_rects(n_plots or 3, False)]
    assert not any(overlaps(*pair) for pair in itertools.combinations(rects, 2))
    assert all(0 <= left < right <= REFERENCE_SIZE and 0 <= top < bottom <= REFERENCE_SIZE for left, top, right, bottom in rects)


def test_a_governor_keeps_its_place_beside_the_plots():
    assert frame_layout(gm.FilmOptions(), True, 3.0) == frame_layout(gm.FilmOptions(), True)


def test_balls_from_outside_are_where_the_turned_arms_hold_them(porter):
    data = data_of(porter)
    seen = OutsideView(data)
    left, right, bottom, top = data.drawing.bounds
    eye, middle = EYE_DISTANCE_RATIO * max(-left, right), 0.5 * (bottom + top)
    for k in (0, 3, 8):
        x, y, _ = data.poses[k, 0]
        expected = []
        for radius in (-x, x):
            # Anticlockwise from above: what was at the right goes behind first, away from the eye.
            across, toward = radius * np.cos(data.spindle_angle[k]), -radius * np.sin(data.spindle_angle[k])
            nearness = eye / (eye - toward)
            expected.append((across * nearness, middle + (y - middle) * nearness))
        # The record of the shapes rounds nothing; its map to a picture and back does, in the last digits.
        found = [(ball.x, ball.y) for ball in of_role(seen.shapes_at(k), "ball", Circle)]
        assert_allclose(sorted(found), sorted(expected), rtol=1e-9)


def test_the_nearer_ball_covers_the_spindle_and_the_spindle_the_further_one(porter):
    data = data_of(porter, count=200)
    seen = OutsideView(data)
    k = int(np.argmin(np.abs(data.spindle_angle - np.pi / 2)))
    shapes, order = seen.shapes_at(k), seen.order_at(k)
    assert sorted(order) == list(range(len(shapes)))
    behind, in_front = (number for number in order if isinstance(shapes[number], Circle) and shapes[number].role == "ball")
    spindle = shapes.index(of_role(shapes, "spindle", Polygon)[0])
    # A quarter of a turn after the plane was seen face on, the right ball is behind, seen smaller, and the left one in front.
    assert shapes[behind].radius < shapes[in_front].radius
    assert order.index(behind) < order.index(spindle) < order.index(in_front)


def test_both_views_stand_side_by_side_on_the_film(porter):
    painter = painter_of(porter, view=FilmView.BOTH)
    frame = painter.draw(0)[..., :3].astype(int)
    assert frame.shape[1] > 480
    blue = np.abs(frame - parse_rgb(ROLE_STYLES["ball"].fill)).max(axis=2) < 32
    x, y = porter.poses[0, 0, :2]
    for view in (painter.outside_view, painter.view):
        column, row = (round(one) for one in pixel_of(view, x, y + 0.02))  # beside the pin in the middle of the ball
        assert blue[row, column]


@pytest.mark.parametrize("options", [{}, {"labels": True}, {"labels": True, "forces": True}])
def test_both_views_have_one_scale_and_like_heights_side_by_side(porter, options):
    painter = painter_of(porter, 3, view=FilmView.BOTH, **options)
    assert painter.view.scale == painter.outside_view.scale
    rows = [pixel_of(view, 0.0, 0.123)[1] for view in (painter.view, painter.outside_view)]
    assert rows[1] == pytest.approx(rows[0])
    # Both fit: the machine, which reaches as far to all sides from outside, is within the places of both.
    left, right, bottom, top = outside_box(painter.frame_data.drawing.bounds)
    x0, x1, y0, y1 = painter.outside_view.box
    assert x0 <= left < right <= x1
    assert y0 <= bottom < top <= y1


def spinning(run, turns_per_second):
    return dataclasses.replace(run, readings={**run.readings, "spindle_speed": np.full(len(run.times), 2 * np.pi * turns_per_second)})


def timing_of(run, shows_rotation=True):
    return select_timing((run,), None, None, None, None, 25.0, shows_rotation=shows_rotation)


def test_a_film_from_outside_closes_on_whole_turns_of_the_spindle():
    """Of four periods, three are 4 turns: in the plane the film closes on the last, from outside on the third."""
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=4 * PERIOD + 0.1, output_interval=PERIOD / 100)
    run = spinning(run, 4 / (3 * PERIOD))
    ends = [timing_of(run, shown).time_span[1] for shown in (False, True)]
    # The motion passes its start within 1 % of its range, the spindle within 1/400 of a turn of a whole one.
    assert ends == pytest.approx([4 * PERIOD, 3 * PERIOD], abs=0.01)
    assert data_of(run, count=2).spindle_angle[-1] / (2 * np.pi) != pytest.approx(4.0, abs=SPINDLE_CLOSING_TOLERANCE)
    assert find_loop_end(run, (0.0, 4 * PERIOD), shows_rotation=True) == pytest.approx(3 * PERIOD, abs=0.01)


def test_a_film_from_outside_without_whole_turns_closes_on_the_motion_in_the_plane(porter):
    assert timing_of(spinning(porter, 1.3 / PERIOD)).time_span[1] == pytest.approx(2 * PERIOD, abs=1e-3)


def test_a_governor_at_rest_in_its_plane_closes_on_its_last_whole_turn(porter):
    resting = dataclasses.replace(porter, poses=np.broadcast_to(porter.poses[0], porter.poses.shape), velocities=0.0 * porter.velocities)
    end = timing_of(spinning(resting, 0.9)).time_span[1]
    assert end == pytest.approx(3 / 0.9, abs=0.5 / 0.9 / 200)  # of 3.06 turns; times are compared half a turn / 200 apart


def test_a_fast_spindle_seen_from_outside_is_slowed(porter):
    fast = spinning(porter, 7.0)
    assert 25.0 * timing_of(fast).slow_down / 7.0 >= MIN_FRAMES_PER_SPINDLE_TURN
    assert timing_of(fast, shows_rotation=False).slow_down == 1.0


def test_a_loop_ends_on_the_last_whole_period(porter):
    assert find_loop_end(porter, (0.0, 3.0)) == pytest.approx(PERIOD, abs=1e-3)
    assert find_loop_end(porter, (0.0, 1.0)) is None


@pytest.mark.parametrize("factor", [1.5, 3.0])
def test_a_magnified_motion_is_that_of_the_mechanism_at_the_magnified_coordinate(porter, factor):
    magnified = magnify_motion(porter, factor)
    mean = np.radians(MEAN)
    expected = governor_poses(PendulumGovernor(**GOVERNOR_DIMENSIONS["porter"]), mean + factor * (porter.readings["arm_angle"] - mean))
    # Joints are closed to 1e-12 of the size of the mechanism; velocities to the error of the central difference.
    assert_allclose(magnified.poses, expected, atol=1e-10)
    step = porter.times[1] - porter.times[0]
    assert_allclose(magnified.velocities[1:-1], (expected[2:] - expected[:-2]) / (2 * step), atol=3e-3)


def test_the_plots_of_a_magnified_film_stay_true(porter):
    painter = painter_of(porter, exaggerate=2.0)
    panel = next(panel for panel in painter.panels if isinstance(panel, CurvePanel))
    assert_allclose(panel.curves[0][:, 1], np.degrees(porter.readings["arm_angle"]))
    assert "motion magnified 2 ×" in words_of(painter.figure)
    # No lift can be read off where the motion is magnified.
    roles = [{shape.role for shape in data.drawing.static_shapes} for data in (data_of(porter), painter.frame_data)]
    assert ["scale" in shown for shown in roles] == [True, False]
    # Nor does a pointer stand alone.
    moving = [{shape.role for shape in data.drawing.moving_shapes(porter.poses[0], 0.0)} for data in (data_of(porter), painter.frame_data)]
    assert ["pointer" in shown for shown in moving] == [True, False]


def with_part(run, **changes):
    return dataclasses.replace(run, scene=dataclasses.replace(run.scene, parts=(dataclasses.replace(run.scene.part, **changes),)))


def test_the_largest_magnification_is_named(porter):
    stops = Stops(reading="arm_angle", low=np.radians(MEAN - 10.0), high=np.radians(MEAN + 14.0))
    stopped = with_part(porter, effects=(*porter.scene.part.effects, stops))
    # 10 degrees to the nearer stop, of a swing of 8.
    with pytest.raises(gm.MechanismError, match=r"magnified 3 times, .* at most 1\.25 is possible"):
        magnify_motion(stopped, 3.0)


def test_a_stop_is_kept_by_a_reading_that_turns_back_within_the_motion(porter):
    """A pendulum of 1 m, 1 m below its pin at 0 rad, which is between the ends of its magnified swing about 0.25 rad."""
    document = {
        "machine": "custom",
        "body": [{"name": "pendulum", "mass": "1 kg", "inertia": "1 kg m^2", "points": {"end": [0, "-1 m"]}}],
        "joint": [{"type": "pin", "first": "ground.origin", "second": "pendulum.origin"}],
        "readings": {"swing": {"angle": "pendulum"}, "height": {"y": "pendulum.end"}},
        "effects": {"gravity": True, "stops": {"height": ["-0.999 m", "1 m"]}},
        "start": {"swing": "0.25 rad"},
        "run": {"duration": "1 s"},
    }
    swing = 0.25 + 0.1 * np.sin(2 * np.pi / PERIOD * porter.times)
    run = dataclasses.replace(porter, scene=parse_scene_document(document), readings={"swing": swing}, rates={"swing": 0.0 * swing})
    largest = (0.25 - np.arccos(0.999)) / 0.1
    with pytest.raises(gm.MechanismError, match=rf"magnified 5 times, .* at most {largest:.2f} is possible"):
        magnify_motion(run, 5.0)


def test_an_animated_drawing_and_a_free_spindle_are_refused(tmp_path, porter):
    with pytest.raises(gm.MechanismError, match="turning plane only"):
        gm.film(porter, tmp_path / "a.svg", view="both")
    with pytest.raises(gm.MechanismError, match="its spindle is free"):
        magnify_motion(with_part(porter, spindle=FreeSpindle(inertia=1.0)), 2.0)
