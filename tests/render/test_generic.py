"""The generic drawing follows joints and loads: ends stand at points, wheels touch, and all stays in the picture."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import assert_words_are_clear, boxes_of, decode_film, painter_of
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import Distance, Pin, RotationalDriver, TranslationalDriver, Weld
from governor_mechanism.render.film.timing import choose_slow_down
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.geometry.outlines import make_arrow, make_band, make_plate_outline
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon, bounding_box, convex_hull, wheel_radii
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.shown_readings import format_film_speed
from stub_machines import MACHINES, fake_machine_run


@pytest.fixture(scope="module", params=MACHINES)
def drawn(request):
    return Drawn(fake_machine_run(request.param, count=101))


def shapes_of(run):
    """Return the shapes that move, by report."""
    return Drawn(run).moving


def background_of(run):
    return Drawn(run).still


def points_of(shape):
    match shape:
        case Circle(_, x, y, radius):
            return [(x, y), (radius, radius)]
        case Polygon(_, points):
            return points
        case Lines(_, lines):
            return [point for line in lines for point in line]
    return []


def test_every_shape_stays_within_the_view_of_a_long_run(drawn):
    # Fewer reports than the run has are looked at for the box.
    assert_shapes_keep(Drawn(fake_machine_run(drawn.run.scene.title.lower(), count=1001)), every=10)


def test_shapes_are_finite_and_a_fixed_plane_has_no_axis(drawn):
    for shape in itertools.chain(drawn.still, *drawn.moving):
        assert np.isfinite(np.array(points_of(shape), dtype=float)).all(), shape
    assert not of_role(drawn.still, "axis")


@pytest.mark.parametrize("name", ["slider-crank", "hung mass"])
def test_springs_and_dampers_end_at_their_points_at_every_pose(name):
    run = fake_machine_run(name, count=41)
    mechanism = run.scene.part.mechanism
    loads = [load for load in mechanism.force_elements if isinstance(load, Spring | Damper)]
    for pose, shapes in zip(run.poses, shapes_of(run), strict=True):
        drawn = [shape for shape in shapes if shape.role in ("spring", "damper")]
        for load, shape in zip(loads, drawn, strict=True):
            ends = [point for line in shape.lines for point in (line[0], line[-1])]
            for point in (load.first, load.second):
                spot = tuple(point_path(mechanism, pose[None], point)[0])
                assert min(math.dist(spot, end) for end in ends) < 1e-12


def test_a_spring_stretches_but_keeps_its_coils_and_width():
    run = fake_machine_run("hung mass", count=41)
    zigzags = np.array([of_role(shapes, "spring")[0].lines[0] for shapes in shapes_of(run)])  # all of as many points
    widths, lengths = np.ptp(zigzags, axis=1).T
    assert np.ptp(widths) < 1e-12
    assert np.ptp(lengths) == pytest.approx(0.16, rel=0.01)


def test_a_piston_stays_in_its_cylinder_which_keeps_its_length():
    depths = []
    for shapes in shapes_of(fake_machine_run("hung mass", count=41)):
        _, cylinder, piston, _ = of_role(shapes, "damper")[0].lines[:4]
        rim, bottom = cylinder[0][1], cylinder[1][1]
        assert min(rim, bottom) < piston[0][1] < max(rim, bottom)
        depths.append(abs(rim - bottom))
    assert np.ptp(depths) < 1e-12


def rims_of(shapes):
    """The largest circle about each wheel's centre."""
    largest = {}
    for circle in of_role(shapes, "wheel"):
        centre = (round(circle.x, 9), round(circle.y, 9))
        largest[centre] = max(largest.get(centre, 0.0), circle.radius)
    return sorted(largest.items(), key=lambda item: -item[1])


@pytest.mark.parametrize(("name", "sign", "ratio"), [("two gears", 1, 2.0), ("inside gear", -1, 3.0)])
def test_wheels_touch_in_the_ratio_of_their_turning(name, sign, ratio):
    for shapes in shapes_of(fake_machine_run(name, count=11)):
        (big, first), (small, second) = rims_of(shapes)
        assert math.dist(big, small) == pytest.approx(first + sign * second)
        assert first / second == pytest.approx(ratio)


def test_wheels_of_any_ratio_have_a_size():
    for ratio in (-1.0, 1.0, 1.0000001, 0.5, -0.2, 7.0):
        assert all(0.0 < radius < 8.0 for (radius,) in wheel_radii(ratio, np.array([1.0])))


def test_a_rack_touches_its_pinion_where_it_goes_the_same_way():
    for shapes in shapes_of(fake_machine_run("rack", count=41)):
        bar = of_role(shapes, "rack")[0]
        x0, x1, _, top = bounding_box([bar])
        assert top == pytest.approx(-0.1)
        assert x0 < 0.0 < x1


def test_a_fixed_rack_stands_on_the_ground_over_its_whole_length():
    run = gm.run("rack_doubling", times=np.linspace(0.0, 2.0, 21))
    left, right, bottom, _ = bounding_box([of_role(shapes_of(run)[0], "rack")[0]])
    beds = [bounding_box([wall]) for wall in of_role(background_of(run), "wall")]
    assert any(bed[3] == pytest.approx(bottom) and bed[0] <= left + 1e-12 < right <= bed[1] + 1e-12 for bed in beds)


@pytest.mark.parametrize("name", ["bead", "arc"])
def test_what_runs_in_a_slot_is_seen_within_it(name):
    run = fake_machine_run(name, count=41)
    slot = np.array(of_role(background_of(run), "slot")[0].points)
    width = 2 * np.hypot(*(slot - slot.mean(axis=0)).T).max()
    for shapes in shapes_of(run):
        rider = of_role(shapes, "ball" if name == "bead" else "pivot")[0]
        gap = np.hypot(slot[:, 0] - rider.x, slot[:, 1] - rider.y).min()
        assert gap < 0.06 * width


def test_a_pin_has_a_circle_a_weld_has_none_and_a_drive_has_a_ring(drawn):
    mechanism, shown = drawn.run.scene.part.mechanism, drawn.moving
    for pose, shapes in zip(drawn.run.poses[::20], shown[::20], strict=True):
        spots = [(s.x, s.y) for s in of_role(shapes, "pivot")]
        for joint in mechanism.joints:
            near = min((math.dist(point_path(mechanism, pose[None], joint.second)[0], s) for s in spots), default=1.0)
            if isinstance(joint, Pin):
                assert near < 1e-12
        assert bool(of_role(shapes, "drive")) == any(
            isinstance(joint, RotationalDriver | TranslationalDriver) for joint in mechanism.joints
        )
    welds = sum(isinstance(joint, Weld) for joint in mechanism.joints)
    assert welds == 0 or len(of_role(shown[0], "pivot")) == sum(isinstance(j, Pin) for j in mechanism.joints)
    assert sum(isinstance(joint, RotationalDriver) for joint in mechanism.joints) <= len(of_role(shown[0], "drive"))


def test_bars_reach_their_pins_and_a_coupler_is_a_frame():
    run = fake_machine_run("four-bar", count=11)
    for shapes in shapes_of(run):
        plates = of_role(shapes, "plate")
        assert len(plates) == 2
        tracer = of_role(shapes, "tracer")[0]
        lengths = [max(math.dist(p, q) for p in plate.points for q in plate.points) for plate in plates]
        width = lengths[0] - 0.1
        assert lengths[1] == pytest.approx(0.2 + width)
        (edges,) = of_role(shapes, "plate edge")
        assert min(math.dist((tracer.x, tracer.y), p) for p in edges.lines[0]) == pytest.approx(width / 2, rel=1e-6)


def test_an_arrow_is_as_long_as_its_force_and_none_is_drawn_for_zero():
    run = fake_machine_run("slider-crank", count=101)
    shown = shapes_of(run)
    lengths = []
    for shapes in shown:
        head = of_role(shapes, "force")[-1]
        line = of_role(shapes, "force")[-2]
        assert isinstance(head, Polygon)
        assert bool(head.points) == bool(line.lines)
        lengths.append(math.dist(line.lines[0][0], head.points[0]) if head.points else 0.0)
    # The force falls straight from its largest to zero within the first half of the run.
    assert lengths[25] == pytest.approx(lengths[0] / 2, rel=1e-6)
    assert lengths[75] == 0.0
    torque = of_role(shown[0], "force")[0]
    assert torque.lines == ()
    assert of_role(shown[50], "force")[0].lines != ()


def test_links_are_drawn_in_their_true_length():
    run = fake_machine_run("quick return", count=11)
    part = run.scene.part
    (link,) = (joint for joint in part.mechanism.joints if isinstance(joint, Distance))
    for shapes in shapes_of(run):
        far = max(math.dist(p, q) for p, q in itertools.combinations(of_role(shapes, "link")[0].points, 2))
        assert far - link.length == pytest.approx(0.030 * drawing_of(run, part).length_scale, rel=1e-6)


def test_hulls_plates_and_bands():
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    assert set(convex_hull([*square, (0.5, 0.5), (0.5, 0.0)])) == set(square)
    assert len(convex_hull([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)])) == 2
    assert bounding_box([make_plate_outline("plate", square, 0.2)]) == pytest.approx((-0.1, 1.1, -0.1, 1.1))
    assert bounding_box([make_plate_outline("plate", square[:2], 0.2)]) == pytest.approx((-0.1, 1.1, -0.1, 0.1))
    assert bounding_box([make_plate_outline("plate", square[:1], 0.2)]) == pytest.approx((-0.1, 0.1, -0.1, 0.1), abs=0.01)
    assert bounding_box([make_band("slot", square[:2], 0.2)]) == pytest.approx((-0.1, 1.1, -0.1, 0.1))
    assert make_arrow("force", ((0.0, 0.0), (0.0, 0.0)), 0.1) == (Lines("force", ()), Polygon("force", ()))


@pytest.mark.parametrize("duration", [1e-6, 0.0003, 0.03, 0.5, 0.99, 60.1, 100.0, 3600.0, 1e9])
def test_a_film_of_a_run_too_short_or_too_long_lasts_2_to_20_s(duration):
    assert 2.0 <= duration * choose_slow_down(duration) <= 20.0
    slow_down = choose_slow_down(duration)
    assert len(schedule_frames(0.0, duration, 25 * slow_down)) / 25 == pytest.approx(duration * slow_down, abs=0.5001 / 25)


@pytest.mark.parametrize("duration", [0.0, 1.0, 10.0, 60.0])
def test_other_films_are_in_true_time(duration):
    assert choose_slow_down(duration) == 1.0


def test_short_runs_are_slowed_unless_told_otherwise(tmp_path):
    run = fake_machine_run("four-bar", duration=0.03)
    _, durations = decode_film(gm.film(run, tmp_path / "a.gif", frames_per_second=2))
    assert sum(durations) == pytest.approx(6.0)
    _, durations = decode_film(gm.film(run, tmp_path / "a.gif", slow_down=20))
    assert durations == pytest.approx(15 * [0.04])
    _, durations = decode_film(gm.film(run, tmp_path / "a.gif", slow_down=1))
    assert durations == pytest.approx([0.03])
    for wrong in (0.0, -1.0, math.nan, 1e9):
        with pytest.raises(gm.MechanismError, match="slow_down"):
            gm.film(run, tmp_path / "b.gif", slow_down=wrong)


@pytest.mark.parametrize(("title", "readings", "duration", "slow"), [
    ("", 4, 1e6, 1e-5), ("A title\nof two lines", 0, 2.0, 1.0), (40 * "a long title ", 7, 0.03, 200.0),
], ids=["no title", "two lines", "long title"])  # fmt: skip
def test_no_words_overlap_whatever_title_and_readings(title, readings, duration, slow):
    run = fake_machine_run("four-bar", duration=duration, readings=readings, title=title)
    picture = painter_of(run, 151, slow)
    picture.update(70)
    boxes = boxes_of(picture.figure)
    assert sum(words.startswith("reading") for words, _ in boxes) == min(readings, 4)
    assert slow == 1.0 or format_film_speed(slow) in [words for words, _ in boxes]
    assert_words_are_clear(boxes)


def test_the_pace_is_put_into_words():
    assert [format_film_speed(slow) for slow in (1.0, 200.0, 0.05)] == ["", "200 × slower than real", "20 × faster than real"]


def test_a_body_held_by_nothing_is_drawn():
    run = fake_machine_run("hung mass")
    part = run.scene.part
    free = dataclasses.replace(part, mechanism=dataclasses.replace(part.mechanism, joints=(), force_elements=()))
    shapes = list(drawing_of(run, free).moving_shapes(run.poses[0], 0.0))
    assert [(s.x, s.y) for s in of_role(shapes, "ball")] == [tuple(pose[:2]) for pose in run.poses[0].tolist()]


def test_a_bar_reaches_its_free_end_and_a_point_with_a_name_belongs_to_its_body():
    m = gm.Mechanism.build("lambda")
    crank, coupler = m.rod("crank", length=0.05, mass=0.1, angle="10 deg"), m.rod("coupler", length=0.25, mass=0.3)
    rocker = m.rod("rocker", length=0.125, mass=0.2)
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, coupler.start)
    m.pin(m.ground(0.1, 0), rocker.start)
    m.pin(coupler.point(0.125, 0, name="middle"), rocker.end)
    m.motor(crank, rate="60 rpm")
    rocker.point(0.06, 0.05, name="pen")
    run = gm.run(m.scene(duration="1 s"), times=np.linspace(0.0, 1.0, 7), certify=False)
    mechanism = run.scene.part.mechanism
    named = {one.name: one.point for one in (*mechanism.points, *mechanism.ends)}
    end, pen = (point_path(mechanism, run.poses, named[name]) for name in ("coupler.end", "pen"))
    for shapes, *points in zip(shapes_of(run), end, pen, strict=True):
        plates = [points_of(shape) for shape in shapes if shape.role.startswith("plate")]
        assert all(min(math.dist(point, one) for plate in plates for one in plate) < 0.01 for point in points)


def short_run(name):
    """A run of a scene of the catalogue, without certificate."""
    return gm.run(gm.load(name), times=np.linspace(0.0, 1.0, 7), certify=False)


def test_wheels_on_an_arm_touch_wherever_it_stands():
    run = short_run("epicyclic_gear")
    wheels = [dict(rims_of(shapes)) for shapes in shapes_of(run)]
    for rims in wheels:
        assert sorted(rims.values()) == pytest.approx([0.045, 0.045, 0.06])
        planets = [centre for centre, radius in rims.items() if radius < 0.05]
        assert [math.hypot(*centre) for centre in planets] == pytest.approx([0.105, 0.105])
        assert (0.0, 0.0) in rims
    first, last = (next(centre for centre, radius in rims.items() if radius < 0.05) for rims in (wheels[0], wheels[-1]))
    assert math.dist(first, last) > 0.05
    # The ring stands still, behind the foot of the pivot.
    still = background_of(run)
    assert dict(rims_of(still)) == pytest.approx({(0.0, 0.0): 0.15})
    roles = [shape.role for shape in still]
    assert roles.index("wheel") < roles.index("frame")


def test_a_gear_that_stands_for_a_wheel_that_is_no_body_draws_none():
    """The arm of Cardan's wheels drives the rolling wheel by a ratio: nothing says where the ring is."""
    scene = gm.load("cardan_line")
    *others, gear, motor = scene.document["joint"]
    without_ring = {key: value for key, value in gear.items() if key != "carrier"} | {"first": "arm", "ratio": -1}
    replaced = gm.Scene.from_dict({**scene.document, "joint": [*others, without_ring, motor]})
    for one, count in ((scene, 2), (replaced, 0)):
        run = gm.run(one, times=np.linspace(0.0, 1.0, 7), certify=False)
        (shapes, *_) = shapes_of(run)
        assert len({circle.radius for circle in of_role([*background_of(run), *shapes], "wheel web")}) == count


def test_the_whole_groove_of_a_cam_turns_with_it_and_holds_the_roller():
    run = short_run("grooved_cam")
    for shapes in shapes_of(run):
        (slot,) = of_role(shapes, "slot")
        inner = of_role(shapes, "plate")[-1]
        places = np.array([(circle.x, circle.y) for circle in of_role(shapes, "pivot")])
        follower = places[np.argmax(places[:, 1])]
        gaps = [np.hypot(*(np.array(outline.points) - follower).T).min() for outline in (slot, inner)]
        # The roller is as far from both edges, to the distance of the points of an edge.
        assert gaps[0] == pytest.approx(gaps[1], abs=2e-3)
        assert gaps[0] < 0.01


def test_a_cam_is_drawn_as_its_outline_and_the_roller_touches_it():
    run = gm.run("disc_cam", times=[0.0, 0.02, 0.05])
    for shapes, lift in zip(shapes_of(run), run.readings["lift"], strict=True):
        (roller,) = of_role(shapes, "wheel", Circle)
        (cam,) = (shape for shape in of_role(shapes, "plate", Polygon) if len(shape.points) > 200)
        assert (roller.x, roller.y) == pytest.approx((0.0, 0.04 + lift), abs=1e-12)
        nearest = min(math.dist(point, (roller.x, roller.y)) for point in cam.points)
        assert nearest == pytest.approx(roller.radius, abs=3e-5)  # points of the outline are a millimetre apart
    assert not [shape for shape in background_of(run) if shape.role == "crank web"]
