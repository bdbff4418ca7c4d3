"""Pages show the shapes of the films where the run has them, at its times, and need nothing but their one file."""

import dataclasses
import html
import json
import re
import shutil
import subprocess
from importlib import resources

import numpy as np
import pytest
from numpy.testing import assert_allclose

import governor_mechanism as gm
from decoding import curve_of, page_data_of, unpack_numbers
from governor_mechanism.effects.holding import Clearance
from governor_mechanism.model.results.pictures import Film
from governor_mechanism.render.frame_data import find_forces
from governor_mechanism.render.geometry.attached import Attached, Flexible, axes_turned, fixed_axes
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon
from governor_mechanism.render.geometry.recording import move_points, record_parts
from governor_mechanism.render.page.page_data import ANGLE_QUANTUM, RELATIVE_QUANTUM, collect_data, pack_numbers
from governor_mechanism.render.page.part_names import MACHINE_NAMES, PART_NAMES, SAME_AS
from governor_mechanism.render.page.views import TOLERANCE, Picture, TrackTable, show_run
from governor_mechanism.render.page.writer import MAX_ROTATION, SAMPLE_RATE, SCRIPTS, choose_sample_times, make_page
from governor_mechanism.render.style import FILM_COLOURS, ROLE_STYLES, colour_rules, role_rules, series_rules
from stub_effects import fake_run_with_effects
from stub_run import GOVERNOR_DIMENSIONS, fake_run

MEAN_ANGLE, AMPLITUDE, RATE, SPEED = np.radians(40.0), np.radians(8.0), 2 * np.pi / 1.7, 4 * np.pi
"""Motion of `fake_run`: angles in rad, its circular frequency and the mean speed of the spindle in rad/s."""
MAX_PAGE_SIZE = 400_000


def ball_places(times):
    """Return the places (n, 2) of the right ball of `fake_run` at times, m."""
    angle = MEAN_ANGLE + AMPLITUDE * np.sin(RATE * times)
    return np.column_stack([0.04 + 0.3 * np.sin(angle), -0.3 * np.cos(angle)])


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0)


@pytest.fixture(scope="module")
def shown(porter):
    return show_run(porter, None, (0.0, 2.0), choose_sample_times(porter, (0.0, 2.0), 1.0), 1.0)


@pytest.fixture(scope="module")
def data(shown):
    return json.loads(json.dumps(collect_data(shown, 1.0)))


@pytest.fixture(scope="module")
def page(porter):
    return make_page(porter, part=None, time_span=(0.0, 2.0), slow_down=1.0)


def test_numbers_come_back_within_half_a_quantum():
    generator = np.random.default_rng(5)
    letters = set()
    for values in (*(scale * np.cumsum(generator.standard_normal(301)) for scale in (1e-3, 0.02, 1.0, 1e6)), 3.7 * np.arange(301.0)):
        packed = pack_numbers(values, 1e-2)
        letters.add(packed[0])
        restored = unpack_numbers(packed, 301)
        assert len(restored) == 301
        assert np.abs(1e-2 * restored - values).max() <= 0.5e-2 * (1 + 1e-9)
    assert letters >= {"a", "c", "d"}
    assert pack_numbers(np.full(7, 3.04), 0.1) == 30
    even = pack_numbers(1e4 * np.arange(500.0), 1.0)
    assert len(even) < 350  # an even motion takes half a byte a sample, in base 64
    assert list(unpack_numbers(even, 500)) == [10_000 * k for k in range(500)]
    assert list(unpack_numbers(pack_numbers(np.array([5.0, 5.0, -70.0]), 1.0), 3)) == [5, 5, -70]


def place(data, view, index, count):
    """Poses (samples, 3) of a track of the page."""
    track = data["views"][view]["tracks"][index]
    return np.column_stack([unpack_numbers(track[name], count) for name in ("x", "y", "angle")]) * [1.0, 1.0, ANGLE_QUANTUM]


def points_of(data, shape, k):
    """Points of a shape of the page at sample k, in units of the picture."""
    count = data["times"]["count"]
    if "frames" in shape:
        _, lengths, x, y = [frame for frame in shape["frames"] if frame[0] <= k][-1]
        return np.column_stack([unpack_numbers(x, sum(lengths)), unpack_numbers(y, sum(lengths))])
    points = np.array(shape["points"], dtype=float).reshape(-1, 2)
    for amplitudes, displacements in shape.get("modes", []):
        points = points + data["amplitudeQuantum"] * unpack_numbers(amplitudes, count)[k] * np.array(displacements).reshape(-1, 2)
    return move_points(place(data, 0, shape["track"], count)[k : k + 1], points)[0] if "track" in shape else points


def test_the_balls_stand_where_the_arms_hold_them(data, shown):
    """The positions follow from the angle alone; a page rounds them to a ten-thousandth of its picture."""
    times = np.linspace(0.0, 2.0, data["times"]["count"])
    expected = ball_places(times)
    picture = shown.views[0].picture
    balls = [shape for shape in data["views"][0]["shapes"] if shape["role"] == "ball"]
    assert len(balls) == 2
    for shape, side in zip(balls, (-1.0, 1.0), strict=True):
        drawn = np.array([points_of(data, shape, k)[0] for k in range(len(times))])
        # One unit of rounding, half for the track and half for the outline; the cubic between reported times is exact to 1e-8.
        assert_allclose(drawn, picture.place(expected * [side, 1.0]), atol=1.01)
        assert_allclose(unpack_numbers(shape["radius"], 1)[0] / picture.scale, shown.parts[0].drawing.ball_radius, atol=1 / picture.scale)


def test_every_shape_of_the_film_is_on_the_page(data, shown):
    """Nothing is drawn twice: at each sample every point is that of the film's primitive, within the rounding of outline and motion."""
    view, picture = shown.views[0], shown.views[0].picture
    n_static = len(view.static_shapes)
    for k in (0, 7, data["times"]["count"] - 1):
        primitives = [*view.static_shapes, *view.shapes_at(k)]
        assert len(primitives) == len(data["views"][0]["shapes"])
        for index, (primitive, shape) in enumerate(zip(primitives, data["views"][0]["shapes"], strict=True)):
            expected = picture.place(np.array(primitive_points(primitive)))
            # A turn of half a quantum of the angle moves the far end of the longest part by half a unit.
            assert_allclose(points_of(data, shape, k if index >= n_static else 0), expected, atol=TOLERANCE + 1.5, err_msg=shape["role"])
            assert shape["role"] == primitive.role


def primitive_points(primitive):
    match primitive:
        case Polygon(_, points):
            return points
        case Lines(_, lines):
            return [point for line in lines for point in line]
        case _:
            return [(primitive.x, primitive.y)]


def test_samples_are_equally_spaced_and_close_enough(porter):
    times = choose_sample_times(porter, (0.5, 1.5), 1.0)
    assert (times[0], times[-1]) == (0.5, 1.5)
    assert_allclose(np.diff(times), times[1] - times[0], rtol=1e-9)
    fastest = max(np.abs(porter.velocities[..., 2]).max(), porter.readings["spindle_speed"].max())
    assert times[1] - times[0] <= min(1 / SAMPLE_RATE, MAX_ROTATION / fastest)
    assert list(choose_sample_times(porter, (1.0, 1.0), 1.0)) == [1.0]


def test_the_spindle_has_turned_by_the_integral_of_its_speed(data):
    count = data["times"]["count"]
    times = np.linspace(0.0, 2.0, count)
    expected = SPEED * (times + 0.03 * (1 - np.cos(0.5 * RATE * times)) / (0.5 * RATE))
    # The trapezoids of `fake_run` every 10 ms are good to 1e-5 rad; half a quantum is 5e-5.
    assert_allclose(ANGLE_QUANTUM * unpack_numbers(data["views"][0]["spindle"], count), expected, atol=1e-4)


def test_forces_are_weight_and_centrifugal_force(data):
    forces, count = data["views"][0]["forces"], data["times"]["count"]
    times = np.linspace(0.0, 2.0, count)
    arrows = {arrow["name"]: [forces["quantum"] * unpack_numbers(arrow[axis], count) for axis in "xy"] for arrow in forces["arrows"]}
    radius = ball_places(times)[:, 0]
    speed = SPEED * (1 + 0.03 * np.sin(0.5 * RATE * times))
    tolerance = RELATIVE_QUANTUM * forces["largest"]
    # Between reported times, 10 ms apart, the force is a straight line: (RATE * 10 ms)^2 / 8 of its changes.
    for side, sign in (("right", 1.0), ("left", -1.0)):
        assert_allclose(arrows[f"centrifugal force on {side} ball"][0], sign * 5.0 * speed**2 * radius, atol=tolerance + 0.05)
    assert_allclose(arrows["weight of sleeve"], [[0.0] * count, [20.0 * 9.81] * count], atol=tolerance)
    assert "centrifugal force on sleeve" not in arrows


def test_from_outside_the_governor_turns_and_its_frame_does_not(data, shown):
    shapes = data["views"][0]["shapes"]
    turning = {shape["role"] for shape in shapes if "turns" in shape}
    assert turning == {"frame", "sleeve", "link", "arm", "ball", "pivot"}  # of the sleeve only the lugs, which are beside the axis
    assert {shape["role"] for shape in shapes if shape.get("isInPlaneOnly")} == {"ball shine"}
    ball = next(shape for shape in shapes if shape["role"] == "ball")
    assert ball["turns"] == pytest.approx(unpack_numbers(ball["radius"], 1)[0], abs=0.5)


def test_an_enlarged_detail_is_no_part_of_the_machine():
    run = fake_run_with_effects(GOVERNOR_DIMENSIONS["porter"], [Clearance(width=5e-4)], duration=1.0)
    (view,) = page_data_of(run)["views"]
    detail = [shape for shape in view["shapes"] if shape["role"] in ("lens", "eyelet")]
    assert detail
    assert all(shape["isInPlaneOnly"] and "turns" not in shape for shape in detail)
    corners = np.array(next(shape["points"] for shape in detail if shape["role"] == "lens")).reshape(-1, 2)

    def is_within(points):
        rows = np.array(points, dtype=float).reshape(-1, 2)
        return np.all((rows >= corners.min(axis=0)) & (rows <= corners.max(axis=0)))

    within = [shape["isInPlaneOnly"] for shape in view["shapes"] if "track" not in shape and is_within(shape["points"])]
    assert len(within) > 3
    assert all(within)


def test_a_reading_that_is_infinite_at_times_is_bridged(porter):
    """A static force is infinite at a turning point of its reading: such values would be no JSON."""
    force = np.where(np.arange(len(porter.times)) % 50 == 20, np.inf, 100.0 + porter.times)
    readings = {**porter.readings, "static_force": force, "never": np.full(len(force), np.nan)}
    run = dataclasses.replace(porter, readings=readings, units={**porter.units, "static_force": "N", "never": "N"})
    plots = {plot["name"]: plot for plot in page_data_of(run)["plots"]}
    values, quantum = curve_of(plots["static force"])
    assert_allclose(values, 100.0 + run.times, atol=quantum)
    assert "never" not in plots


def test_plots_are_marked_where_the_load_changes():
    """The load of the shipped engine falls at 6 s; before, there is nothing to mark."""
    scene = gm.load("governed_engine_mean_torque")
    for end, marks in ((4.0, []), (8.0, [6.0])):
        run = gm.run(scene.replace({"run.duration": end}), accuracy=1e-4)
        first = [plot["marks"] for plot in page_data_of(run)["plots"] if plot["isFirst"]]
        assert len(first) >= 3
        assert all(found == marks for found in first)


def test_a_spring_pulls_with_the_force_that_the_run_reports():
    run = gm.run(gm.load("hartung_dubois").replace({"run.duration": "1.5 s"}))
    forces = find_forces(show_run(run, None, (0.0, 1.5), run.times, 1.0).parts[0])
    springs = [force for force in forces if force.kind == "spring"]
    assert len(springs) == 2
    for force in springs:
        # Poses and readings are good to 1e-6 of their scales, which the stiffness turns into some thousandths of a newton.
        assert_allclose(np.hypot(*force.components.T), run.readings["spring_force"], atol=0.05)


def test_a_damper_pulls_with_the_rate_of_its_length():
    """A rod swings about one end; a damper goes from a fixed point to the other end, away from the mass centre."""
    builder = gm.Mechanism.build("damped rod")
    rod = builder.rod("rod", length=1.0, mass=1.0, angle="10 deg")
    builder.pin(builder.ground(0, 0), rod.start)
    builder.damper(builder.ground(0.3, 0.5), rod.end, damping=2.0, name="damper")
    builder.reading("rod_angle", angle=rod)
    run = gm.run(builder.scene(duration=1.0).replace({"effects.gravity": True}), times=np.linspace(0.0, 1.0, 101), accuracy=1e-10)
    (force,) = [one for one in find_forces(show_run(run, None, (0.0, 1.0), run.times, 1.0).parts[0]) if one.kind == "damping"]
    angle, rate = run.readings["rod_angle"], run.rates["rod_angle"]
    along = np.array([np.cos(angle) - 0.3, np.sin(angle) - 0.5])
    velocity = rate * np.array([-np.sin(angle), np.cos(angle)])
    direction = along / np.hypot(*along)
    pull = -2.0 * np.sum(velocity * direction, axis=0)  # on the rod, which the damper holds back
    assert np.ptp(pull) > 1.0
    # Poses, angles and rates are good to 1e-10 of their scales, some 10 rad/s at most.
    assert_allclose(force.components.T, pull * direction, atol=1e-7)


def test_readings_are_those_of_the_run(data, porter):
    plot = next(plot for plot in data["plots"] if plot["name"] == "arm angle")
    values, quantum = curve_of(plot)
    times = np.linspace(0.0, 2.0, data["times"]["count"])
    assert plot["unit"] == "°"
    assert_allclose(values, np.degrees(np.interp(times, porter.times, porter.readings["arm_angle"])), atol=quantum)
    assert quantum < 0.5 * 10.0 ** -plot["decimals"]
    assert {plot["name"] for plot in data["plots"]} >= {"sleeve lift", "spindle speed", "ball radius"}


def test_a_constant_reading_is_stated_without_a_curve(porter):
    run = dataclasses.replace(porter, readings={**porter.readings, "spindle_speed": np.full(len(porter.times), 12.0)})
    constant = {plot["name"]: plot for plot in page_data_of(run)["plots"] if plot.get("isStated")}
    assert "spindle speed" in constant
    assert not {"arm angle", "sleeve lift"} & set(constant)
    assert all(isinstance(curve["values"], int) for plot in constant.values() for curve in plot["curves"])


def parts_in_motion():
    """A crank, a spring between a fixed and a moving point, a lamp that goes out, and a curve that grows, at moments 0, 1, 2, ..."""
    square = ((0.1, -0.05), (0.3, -0.05), (0.3, 0.05), (0.1, 0.05))

    def spring(k):
        end = 0.5 + 0.2 * np.sin(0.3 * k)
        return (Lines("spring", (tuple((float(end * j / 6), 0.8 + 0.02 * (-1) ** j) for j in range(7)),)),)

    return (
        Attached(frame=axes_turned((0.0, 0.0), lambda k: 0.3 * k), shapes=(Polygon("arm", square),)),
        Flexible(shapes_at=spring),
        Attached(frame=fixed_axes, shapes=(Circle("mark", 0.0, 0.5, 0.02),), shown=lambda k: k < 10),
        Flexible(shapes_at=lambda k: (Lines("trace", (tuple((0.01 * j, 0.9) for j in range(k + 2)),)),)),
    )


def test_shapes_keep_the_motion_that_their_drawing_gives_them():
    picture, n_samples = Picture(box=(-1.0, 1.0, -1.0, 1.0)), 40
    shapes, table = record_parts(parts_in_motion(), range(n_samples)), TrackTable(Picture(box=(-1.0, 1.0, -1.0, 1.0)))
    crank, spring, lamp, curve = map(table.describe, shapes)
    assert crank.track == 0
    poses = np.column_stack([np.zeros((n_samples, 2)), 0.3 * np.arange(n_samples)])
    expected = picture.place(move_points(poses, shapes[0].points[0]))
    assert_allclose(move_points(table.tracks[0].poses, crank.points), expected, atol=1e-6)
    assert len(spring.modes) == 1
    assert lamp.track is None
    assert list(shapes[2].visible) == [k < 10 for k in range(n_samples)]
    assert curve.is_changing
    assert [sum(map(len, lines)) for lines in shapes[3].changing] == [k + 2 for k in range(n_samples)]


def test_axes_that_move_as_one_share_a_track():
    """A second bar on the crank, in axes of its own, and a bar on another shaft."""
    table = TrackTable(Picture(box=(-1.0, 1.0, -1.0, 1.0)))
    bar = (Polygon("arm", ((0.0, 0.0), (0.2, 0.0), (0.2, 0.05))),)
    frames = [
        axes_turned((0.0, 0.0), lambda k: 0.1 * k),
        lambda k: (0.3 * np.cos(0.1 * k), 0.3 * np.sin(0.1 * k), 0.1 * k + 1.0),
        axes_turned((0.5, 0.0), lambda k: 0.1 * k),
    ]
    shapes = record_parts([Attached(frame=frame, shapes=bar) for frame in frames], range(30))
    motions = [table.describe(shape) for shape in shapes]
    assert [motion.track for motion in motions] == [0, 0, 1]
    expected = table.picture.place(shapes[1].placed_points())
    assert_allclose(move_points(table.tracks[0].poses, motions[1].points), expected, atol=1e-6)


def test_a_page_is_one_file_that_asks_for_nothing(page):
    addresses = set(re.findall(r"https?://[^\s\"'<>)]*", page))
    assert addresses <= {"http://www.w3.org/2000/svg"}
    assert set(re.findall(r"(?:src|href)=\"([^\"]*)\"", page)) <= {"data:,"}
    assert "@import" not in page
    assert "url(" not in re.sub(r"url\(#", "", page)
    assert "default-src 'none'" in page
    assert len(page.encode()) < MAX_PAGE_SIZE


def test_a_title_cannot_break_out_of_the_page(porter):
    title = '</script><script>alert(1)</script> & "Co" <!--'
    run = dataclasses.replace(porter, scene=dataclasses.replace(porter.scene, title=title))
    text = make_page(run, part=None, time_span=(0.0, 0.1), slow_down=1.0)
    assert "alert(1)</script>" not in text
    assert html.escape(title) in text


def test_a_page_says_what_the_scene_lists(page):
    for word in ("gravity", "9.81 m/s²", "centrifugal", "ball mass", "5 kg", "reduced", "accurate to 4e-07"):
        assert word in page


def test_the_script_finds_every_element_of_the_page(page):
    script = "\n".join(read(f"script/{name}.js") for name in SCRIPTS)
    ids = set(re.findall(r'find\("([\w-]+)"\)', script))
    assert ids
    assert ids <= set(re.findall(r'id="([\w-]+)"', read("page.html")))


def test_every_colour_has_a_counterpart_on_a_dark_ground():
    declared = set(re.findall(r"--c-(\w{6})", colour_rules()))
    assert {colour[1:] for colour in FILM_COLOURS} <= declared
    used = set(re.findall(r"var\(--c-(\w{6})\)", role_rules(set(ROLE_STYLES)) + series_rules() + read("page.css") + read("gallery.css")))
    assert used <= declared


def test_names_are_those_of_roles():
    assert {*PART_NAMES, *SAME_AS, *(role for names in MACHINE_NAMES.values() for role in names)} <= set(ROLE_STYLES)
    assert set(SAME_AS.values()) <= set(PART_NAMES)


def test_two_runs_or_a_frame_rate_are_refused(porter, tmp_path):
    for arguments, message in (
        ({"run": [porter, porter]}, "a page shows one run"),
        ({"run": porter, "frames_per_second": 10}, "takes no frames_per_second"),
        ({"run": porter, "part": "engine"}, "no part 'engine'"),
        ({"run": porter, "start": 3.0}, "must lie within the run"),
    ):
        with pytest.raises(gm.MechanismError, match=message):
            gm.film(path=tmp_path / "a.html", **arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("duration", "requested", "slow_down"), [(0.5, None, 10.0), (70.0, None, 1.0), (2.0, 5.0, 5.0)])
def test_a_page_begins_in_true_time_or_as_asked(tmp_path, duration, requested, slow_down):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=duration, output_interval=duration / 400)
    text = gm.film(run, tmp_path / "a.html", stop=0.5, slow_down=requested).read_text(encoding="utf-8")
    assert json.loads(text.partition('id="run-data">')[2].partition("</script>")[0])["slowDown"] == slow_down


def test_a_film_that_ends_in_html_is_a_page_and_a_notebook_shows_it(porter, tmp_path):
    calls = []
    path = gm.film(porter, tmp_path / "a.html", stop=0.1, progress=lambda *call: calls.append(call))
    assert calls == [(1, 1)]
    frame = Film(path)._repr_html_()
    assert html.unescape(re.search('srcdoc="([^"]*)"', frame)[1]) == path.read_text(encoding="utf-8")


def read(name):
    return resources.files("governor_mechanism.render.page").joinpath(name).read_text(encoding="utf-8")


FOLLOW_BALL = """const view = data.views[0];
view.tracks = view.tracks.map((one) => decodeTrack(one, data.angleQuantum));
const ball = decodeShape(view.shapes.filter((one) => one.role === "ball")[1], data.amplitudeQuantum);
const at = (place) => placedPoints(ball, view.tracks.map((track) => poseAt(track, place)), place);
console.log(JSON.stringify([0, 0.123, 1.017, 1.99, 2].map((time) => at(placeOf(time, data.times)))));"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_the_script_decodes_and_follows_the_motion(page, data, shown, tmp_path):
    """Between samples, too, the script has the ball on its circle."""
    program = [read(f"script/{name}.js") for name in ("decoding", "geometry")] + [f"const data = {json.dumps(data)};", FOLLOW_BALL]
    (tmp_path / "a.js").write_text("\n".join(program), encoding="utf-8")
    (tmp_path / "b.js").write_text(page.rpartition("<script>")[2].partition("</script>")[0], encoding="utf-8")
    subprocess.run(["node", "--check", str(tmp_path / "b.js")], check=True, capture_output=True)
    answer = subprocess.run(["node", str(tmp_path / "a.js")], check=True, capture_output=True, text=True)
    expected = shown.views[0].picture.place(ball_places(np.array([0, 0.123, 1.017, 1.99, 2])))
    # The cubic through samples 30 ms apart is good to 1e-5 of the amplitude, and at the ends, without a neighbour, to a thousandth.
    assert_allclose(json.loads(answer.stdout), expected, atol=2.0)
