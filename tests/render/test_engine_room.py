"""Film of a governed engine: what the engine room shows is what the run says, at every frame."""

import math
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import governor_mechanism as gm
from decoding import decode_film, words_of
from drawing_checks import assert_within, of_role
from governor_mechanism.render.figures.time_series import choose_overview
from governor_mechanism.render.film.engine_room_painter import EngineRoomPainter
from governor_mechanism.render.film.painters import write_still
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import shapes_of as placed_shapes
from governor_mechanism.render.geometry.primitives import Circle, Lines, bounding_box
from governor_mechanism.render.machines.engine_room import arrangement as room
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.render.machines.engine_room.controls import BeltDrive, disc_angle, make_governor_belt
from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.shown_readings import shown_readings

STEP = 1.0
"""Time at which the load falls to the half, s."""


def short_run(model: str, duration: float, step: float = STEP, *, until: float | None = None, **dimensions: str):
    """Run a shipped governed engine for a short time, with a rough accuracy that a drawing cannot show."""
    changes = {"run.duration": duration, "load.fraction": [[0, 1.0], [step, 1.0], [step, 0.5]]}
    changes |= {f"part.engine.dimensions.{name}": value for name, value in dimensions.items()}
    changes |= {"coupling.gear.until": until} if until else {}
    return gm.run(gm.load(model).replace(changes), accuracy=1e-5, certify=False)


@pytest.fixture(scope="module")
def throttled():
    return short_run("governed_engine", 2.0, until=1.5, connecting_rod="1.6 m", pump_connecting_rod="1.3 m")


@pytest.fixture(scope="module")
def mean_torque():
    return short_run("governed_engine_mean_torque", 15.0, step=6.0)


def room_of(run):
    governed = find_governed_engine(run.scene)
    return EngineRoomDrawing(run, governed, drawing_of(run, governed.engine), drawing_of(run, governed.governor))


def states_of(run, times):
    """The room, and its states at these times."""
    drawing = room_of(run)
    poses = FrameData(run, drawing.governed.governor, (0.0, float(run.times[-1])), times).poses
    state_at = drawing.states(times, poses)
    return drawing, [state_at(k) for k in range(len(times))]


@pytest.mark.parametrize(("model", "expected"), [
    ("governed_engine", (1.0, "throttle")), ("governed_engine_mean_torque", (1.0, "throttle")),
    ("governed_engine_cut_off", (1.0, "cut_off")), ("governed_engine_hartung", (52 / 30, "throttle")),
    ("watt_engine_hunting", (2.0, "torque")), ("porter", None), ("air_engine", None),
])  # fmt: skip
def test_the_couplings_of_a_scene_tell_what_is_governed(model, expected):
    governed = find_governed_engine(gm.load(model))
    assert (governed and (governed.ratio, governed.controlled)) == expected
    if governed:
        assert (governed.engine.name, governed.governor.name, governed.governor_reading) == ("engine", "governor", "governor.sleeve_lift")


def test_an_engine_that_its_governor_does_not_control_is_no_governed_engine():
    document = gm.load("governed_engine").document
    couplings = {name: one for name, one in document["coupling"].items() if name != "throttle_rod"}
    assert find_governed_engine(gm.Scene.from_dict({**document, "coupling": couplings})) is None


@pytest.mark.parametrize("rows", [slice(0, 90, 30), slice(75, 100, 12)])  # before the belt breaks, and around it
def test_balls_piston_and_wheel_stand_where_the_run_says(throttled, rows):
    times = throttled.times[rows]
    fine = np.linspace(times[0], times[-1], 200)  # enough frames that no rotation is slowed
    drawing, _ = states_of(throttled, fine)
    assert drawing.rotation_slowing(fine) == 1
    scale = drawing.governor.pixels_per_metre
    for time, state in zip(fine, states_of(throttled, fine)[1], strict=True):
        if not np.any(np.isclose(time, times, rtol=0, atol=1e-12)):
            continue
        row = int(np.argmin(np.abs(throttled.times - time)))
        reading = {name: float(values[row]) for name, values in throttled.readings.items()}
        shapes = list(drawing.moving_shapes(state))
        balls = [shape.x for shape in of_role(shapes, "ball")]
        expected = [room.GOVERNOR_AXIS + sign * scale * reading["governor.ball_radius"] for sign in (1, -1)]
        assert sorted(balls) == pytest.approx(sorted(expected), abs=1e-9)
        wheel = of_role(shapes, "marked spoke")[0].lines[0]
        angle = math.atan2(wheel[1][1] - wheel[0][1], wheel[1][0] - wheel[0][0])
        assert math.remainder(angle - reading["engine.crank_angle"], math.tau) == pytest.approx(0.0, abs=1e-9)
        left, right, _, _ = bounding_box(of_role(shapes, "piston")[:1])  # the second one is that of the dashpot
        travel = reading["engine.piston_travel"] / 0.65  # of the stroke
        assert 0.5 * (left + right) == pytest.approx(drawing.engine.piston_position(travel), abs=1e-6 * room.WIDTH)


def test_rotations_too_fast_for_the_frames_are_slowed_by_a_whole_number(throttled):
    times = np.arange(0.0, 2.01, 0.1)  # 72 degrees from frame to frame
    drawing, states = states_of(throttled, times)
    slowing = drawing.rotation_slowing(times)
    assert slowing == 4  # up to 74 degrees: to less than 24
    angles = np.interp(times, throttled.times, throttled.readings["engine.crank_angle"])
    assert [state.crank_angle for state in states] == pytest.approx(angles / slowing, abs=1e-12)
    assert max(b.crank_angle - a.crank_angle for a, b in pairwise(states)) < math.radians(24)


def test_the_butterfly_leaves_the_opening_of_the_throttle_free(throttled):
    drawing, states = states_of(throttled, throttled.times[::20])
    for state, opening in zip(states, throttled.readings["engine.throttle_opening"][::20], strict=True):
        disc = of_role(drawing.moving_shapes(state), "butterfly")[0].lines[0]
        free = 2 * room.PIPE_HALF_WIDTH - abs(disc[1][0] - disc[0][0])
        assert free / (2 * room.PIPE_HALF_WIDTH) == pytest.approx(float(opening), abs=1e-12)
        assert math.dist(*disc) == pytest.approx(2 * room.PIPE_HALF_WIDTH)
    assert [disc_angle(one) for one in (-0.1, 0.0, 0.5, 1.0, 1.2)] == pytest.approx(np.radians([0, 0, 60, 90, 90]))


def test_the_rod_to_the_throttle_keeps_its_length(throttled):
    drawing = room_of(throttled)
    ends = [
        (drawing.control.crank.arm_end(height), drawing.control.rod_end(value))
        for height, value in zip(drawing.fork_heights, drawing.control_values, strict=True)
    ]
    lengths = [math.dist(*pair) for pair in ends]
    assert max(lengths) - min(lengths) < 0.5  # pixels: no one sees it
    # The sleeve rises where the rod goes to the right.
    assert np.corrcoef(drawing.fork_heights, [end[0] for _, end in ends])[0, 1] > 0.99


def test_the_weight_shows_the_load(throttled):
    drawing, states = states_of(throttled, np.array([STEP - 0.1, STEP + 0.1]))
    boxes = [bounding_box(of_role(drawing.moving_shapes(state), "weight")) for state in states]
    assert [top - bottom for _, _, bottom, top in boxes] == pytest.approx([room.MAX_WEIGHT_HEIGHT, 0.5 * room.MAX_WEIGHT_HEIGHT])
    assert room.load_steps(throttled, drawing.governed) == [STEP]


def test_the_slide_stands_at_the_cut_off_over_the_piston():
    run = short_run("governed_engine_cut_off", 1.2)
    drawing, states = states_of(run, run.times[::15])
    for state, cut_off in zip(states, run.readings["engine.cut_off"][::15], strict=True):
        left, right, _, _ = bounding_box(of_role(drawing.moving_shapes(state), "valve"))
        assert 0.5 * (left + right) == pytest.approx(drawing.engine.piston_position(float(cut_off)), abs=1e-9)


@pytest.mark.parametrize("model", ["throttled", "mean_torque", "hartung", "watt_engine_hunting"])
def test_every_frame_has_the_same_shapes_within_the_room(model, request):
    if model == "hartung":
        run = short_run("governed_engine_hartung", 1.2)
    else:
        run = gm.run(model, accuracy=1e-4, certify=False) if model in gm.list_models() else request.getfixturevalue(model)
    drawing, states = states_of(run, np.linspace(0.0, float(run.times[-1]), 25))
    frames = [list(drawing.moving_shapes(state)) for state in states]
    assert len({tuple((type(shape), shape.role) for shape in frame) for frame in frames}) == 1
    for shapes in (*frames, list(drawing.background_shapes())):
        assert_within(shapes, (0.0, room.WIDTH, 0.0, room.HEIGHT), margin=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 52 / 30, 0.51, -0.8])
def test_belts_touch_pulleys_whose_radii_have_the_ratio(ratio):
    belt = make_governor_belt((100.0, 100.0), ratio)
    assert belt.first_radius / belt.second_radius == pytest.approx(abs(ratio))
    assert belt.is_crossed == (ratio < 0)
    for start, end in belt.strands:
        along = np.subtract(end, start)
        for point, centre, radius in ((start, belt.first, belt.first_radius), (end, belt.second, belt.second_radius)):
            assert math.dist(point, centre) == pytest.approx(radius)
            assert float(along @ np.subtract(point, centre)) == pytest.approx(0.0, abs=1e-9 * float(along @ along))


def test_a_broken_belt_hangs_down_and_the_film_goes_on(throttled, tmp_path):
    drawing, states = states_of(throttled, np.array([1.4, 1.6]))
    strands = [of_role(drawing.moving_shapes(state), "belt")[-1].lines for state in states]
    assert strands[0] == make_governor_belt(drawing.engine.view.shaft, 1.0).strands
    assert min(y for line in strands[1] for _, y in line) == pytest.approx(room.FLOOR + 2.0)
    film = gm.film(throttled, tmp_path / "broken.gif", start=1.2, stop=1.8, frames_per_second=10)
    frames, durations = decode_film(film)
    assert frames.shape[1:] == (480, 766, 3)
    assert sum(durations) == pytest.approx(0.6)  # true time


@pytest.mark.long
def test_a_long_run_is_shown_in_time_lapse_that_the_frame_names(mean_torque, tmp_path):
    governed = find_governed_engine(mean_torque.scene)
    stop = room.settled_time(mean_torque, governed)
    film = gm.film(mean_torque, tmp_path / "long.gif")
    assert sum(decode_film(film)[1]) == pytest.approx(0.5 * stop, abs=0.041)  # longer than the longest film, two times as fast
    assert film.stat().st_size < 700e3
    data = [FrameData(mean_torque, part, (0.0, 14.0), np.arange(0.0, 14.0, 0.16), 0.5) for part in (governed.engine, governed.governor)]
    painter = EngineRoomPainter(mean_torque, governed, *data)
    plotted = {"mean speed", "sleeve lift", "throttle", "torque,", "load", "supply 4 bar"}
    assert {"first 14 of 15 s", "2 × faster than real, 5 turns drawn as 1", *plotted} <= set(words_of(painter.figure))


def test_mean_torque_and_speed_of_a_turn_are_those_of_the_run(mean_torque, throttled):
    """The mean is taken from the energy; in this run the torque is given, and almost constant over a turn."""
    governed = find_governed_engine(mean_torque.scene)
    times, torque = room.engine_torque(mean_torque, governed)
    settled = (times < 5.7) | (times > 8.0)  # the step of the load lies within a turn around 6 s
    given = np.interp(times, mean_torque.times, mean_torque.readings["engine.gas_torque"])
    assert torque[settled] == pytest.approx(given[settled], abs=0.5)  # N m of 300: what the governor takes, and curvature over a turn
    times, speed = room.mean_speed(mean_torque, governed)
    expected = np.interp(times, mean_torque.times, mean_torque.rates["engine.crank_angle"])
    assert speed[times < 5.5] == pytest.approx(expected[times < 5.5], rel=1e-4)  # it changes little in a turn
    assert room.mean_speed(short_run("governed_engine_mean_torque", 0.6, step=0.5), governed) is None
    # The gas turns the shaft by fits and starts; the mean lies between its extremes.
    torque = room.engine_torque(throttled, find_governed_engine(throttled.scene))[1]
    assert np.ptp(torque) < 0.1 * np.ptp(throttled.readings["engine.gas_torque"])


def test_a_film_ends_after_the_governor_has_settled(mean_torque):
    governed = find_governed_engine(mean_torque.scene)
    stop, lift = room.settled_time(mean_torque, governed), mean_torque.readings["governor.sleeve_lift"]
    assert 8.0 < stop < 15.0  # the load falls at 6 s
    assert np.ptp(lift[mean_torque.times > stop]) < 0.03 * np.ptp(lift)
    hunting = gm.run("watt_engine_hunting", accuracy=1e-4, certify=False)
    assert room.settled_time(hunting, find_governed_engine(hunting.scene)) == 30.0


def test_a_still_shows_the_room_at_a_time(mean_torque, tmp_path):
    with Image.open(write_still(mean_torque, tmp_path / "still.png", size=480)) as picture:
        assert picture.size == (766, 480)
    with pytest.raises(gm.MechanismError, match=r"within the run, 0\.\.15 s"):
        write_still(mean_torque, tmp_path / "late.png", time=16.0)
    with pytest.raises(gm.MechanismError, match=r"end in \.png"):
        write_still(mean_torque, tmp_path / "still.jpg")


def test_shapes_of_a_belt_are_lines_and_a_pulley_turns_with_its_angle():
    belt = BeltDrive(first=(0.0, 0.0), second=(100.0, 0.0), first_radius=10.0, second_radius=10.0)
    assert all(isinstance(shape, Lines) for shape in belt.belt_shapes())
    wheel, mark, _ = placed_shapes(belt.second_pulley_parts(lambda angle: angle), 0.5 * math.pi)
    assert isinstance(wheel, Circle)
    assert mark.lines[0][1] == pytest.approx((100.0, 8.0))


def test_an_overview_of_a_governed_engine_shows_how_it_is_regulated(mean_torque):
    readings = shown_readings(mean_torque)
    shown = list(choose_overview(mean_torque, readings))
    governor, engine = ("sleeve_lift", "arm_angle"), ("shaft_speed", "gas_torque", "load_torque", "throttle_opening", "stored_work")
    assert set(shown) == {*(f"governor.{name}" for name in governor), *(f"engine.{name}" for name in engine)}
    assert shown == [name for name in readings if name in shown]
    # The shaft turns the spindle at its own speed: one of both says all, and so for the crank, whose rate is the speed of the shaft.
    assert "governor.spindle_speed" in readings
    assert "engine.crank_rate" not in readings
