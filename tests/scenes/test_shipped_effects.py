"""Shipped scenes with friction, brakes, play, stops and rods: each runs as accurately as asked, and as it says."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.scenes.library import shipped_scenes
from printed_numbers import half_unit_of_last_digit
from reference import zehnder

MODELS = (
    "porter_dry_friction",
    "porter_heavy_rods",
    "porter_load_step",
    "porter_dashpot",
    "porter_clearance",
    "porter_ramp",
    "porter_cyclic",
    "porter_cyclic_damped",
    "watt_improved",
    "watt_clearance",
)


ENGINES = pytest.mark.parametrize("engine", ["multibody", "reduced"])
RUNS = [("multibody", name) for name in MODELS] + [("reduced", name) for name in MODELS if "clearance" not in name]


@cache
def run_of(name, engine):
    return gm.run(name, engine=engine)


def speed_at(run, time):
    """The given speed (rad/s) of the spindle at a time (s) on one of its straight ramps."""
    spindle = run.scene.spindle
    return float(np.interp(time, spindle.times, spindle.speeds))


@pytest.mark.parametrize(("engine", "name"), RUNS)
def test_each_runs_within_its_accuracy(engine, name):
    run = run_of(name, engine)
    assert run.outcome.ok, run.message
    assert run.error_estimate <= run.scene.run.accuracy
    assert run.times[-1] == run.scene.run.duration
    assert run.energy.drift < run.scene.run.accuracy
    assert np.all(np.diff(run.energy.dissipated_energy) > -1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_each_opens_with_a_comment_that_names_its_source(name):
    lines = shipped_scenes()[name].read_text(encoding="utf-8").splitlines()
    schema, *comment = lines[: next(k for k, line in enumerate(lines) if not line.startswith("#"))]
    assert schema == "#:schema ./scene.schema.json"
    assert 1 <= len(comment) <= 3
    assert "Zehnder" in " ".join(comment)
    assert all(len(line) <= 120 for line in lines)


@ENGINES
def test_dry_friction_lets_go_at_the_upper_end_of_the_band_and_holds_on_the_way_back(engine):
    run = run_of("porter_dry_friction", engine)
    kinds = [event.kind for event in run.events[:3]]
    assert kinds == ["slips", "sticks", "slips"]
    up, stuck, down = (event.time for event in run.events[:3])
    assert speed_at(run, up) == pytest.approx(zehnder.FRICTION_BAND["rising_speed"], abs=1e-6)  # asked
    held = run.readings["arm_angle"][(run.times > stuck) & (run.times < down)]
    assert np.ptp(held) < 1e-14  # rounding
    # It falls at the lower end of the band of the angle that it had reached.
    band = gm.insensitivity_band(run.scene, over=[held[0]], resistance=40.0)
    assert speed_at(run, down) == pytest.approx(band.falling_speed[0], abs=1e-6)
    assert run.energy.dissipated_energy[-1] > 0


@ENGINES
@pytest.mark.parametrize(("towards", "name"), [(13.4, "rising_speed"), (10.9, "falling_speed")])
def test_at_rest_at_thirty_degrees_it_slips_at_either_end_of_the_band(engine, towards, name):
    scene = gm.load("porter_dry_friction")
    slow = scene.with_changes(spindle=Spindle(times=(0.0, 12.0), speeds=(12.2, towards)), run=replace(scene.run, duration=12.0))
    first = gm.run(slow, engine=engine).events[0]
    assert first.kind == "slips"
    assert 12.2 + (towards - 12.2) * first.time / 12.0 == pytest.approx(zehnder.FRICTION_BAND[name], abs=1e-6)  # asked


@ENGINES
def test_the_twitch_comes_every_turn_and_not_below_the_band(engine):
    run = run_of("porter_cyclic", engine)
    spindle = run.scene.spindle
    assert spindle.speeds[0] == pytest.approx(zehnder.CYCLIC_MOTION["mean_speed"], abs=5e-9)  # printed
    assert spindle.speed_fluctuation == pytest.approx(1.2 * zehnder.CYCLIC_MOTION["band"], abs=5e-6)  # as written in the scene
    turns = run.scene.run.duration * spindle.speeds[0] / (2 * math.pi)
    assert abs(sum(event.kind == "slips" for event in run.events) - 2 * turns) <= 1
    still = run.scene.with_changes(spindle=replace(spindle, speed_fluctuation=0.16))
    calm = gm.run(still, engine=engine)
    assert calm.events == ()
    assert np.ptp(calm.readings["sleeve_lift"]) == 0.0


def last_turn(run):
    turn = 2 * math.pi / run.scene.spindle.speeds[0]
    return float(np.ptp(run.readings["sleeve_lift"][run.times > run.times[-1] - turn]))


@ENGINES
def test_the_oil_brake_holds_the_twitch_to_a_ninth(engine):
    free, braked = last_turn(run_of("porter_cyclic", engine)), last_turn(run_of("porter_cyclic_damped", engine))
    assert 8 < free / braked < 10
    assert any(event.kind == "slips" for event in run_of("porter_cyclic_damped", engine).events)


def test_the_weight_of_the_sleeve_keeps_the_play_closed():
    run, without = run_of("porter_clearance", "multibody"), run_of("porter_cyclic", "multibody")
    assert np.ptp(run.readings["sleeve_clearance"]) < 1e-12
    assert not any(event.subject == "sleeve_clearance" for event in run.events)
    shift = run.readings["sleeve_lift"] - without.readings["sleeve_lift"]
    np.testing.assert_allclose(shift, -0.25e-3, atol=2e-6 * run.scales["sleeve_lift"])  # both as asked


def test_the_arms_knock_on_the_ends_of_the_play():
    run = run_of("watt_clearance", "multibody")
    play = run.readings["sleeve_clearance"]
    assert play.min() == pytest.approx(-0.5e-3, abs=1e-9)
    assert play.max() == pytest.approx(0.5e-3, abs=1e-9)
    assert sum(event.kind == "strikes its stop" for event in run.events) > 20
    assert 1.4e-3 < last_turn(run) < 1.6e-3


@ENGINES
def test_the_oil_brake_takes_the_swing(engine):
    run = run_of("porter_dashpot", engine)
    off = np.abs(run.readings["arm_angle"] - math.radians(30.0))
    first, last = off[run.times < 1.0].max(), off[run.times > 7.0].max()
    assert last < 0.01 * first
    # All that it loses lies between the start, at rest, and the end, nearly so.
    start = run.energy.potential - run.energy.rotation
    lost = start[0] - start[-1] - run.energy.kinetic[-1]
    assert run.energy.dissipated_energy[-1] == pytest.approx(lost, abs=1e-5)


def test_heavy_rods_rest_at_their_own_speed():
    scene = gm.load("porter_heavy_rods")
    angle, speed, _, stiffness, inertia, square, _ = zehnder.PORTER_MASSIVE_RODS["rows"][0]
    assert scene.spindle.speeds[0] == speed
    (rest,) = gm.equilibria(scene)
    assert math.degrees(rest.coordinate) == pytest.approx(angle, abs=1e-8)  # the speed has 12 digits
    assert rest.stiffness == pytest.approx(stiffness, rel=1e-9)
    assert rest.frequency**2 == pytest.approx(square, rel=1e-9)
    assert rest.stiffness / rest.frequency**2 == pytest.approx(inertia, rel=1e-9)


@ENGINES
def test_the_ramp_lifts_the_arms_from_rest_to_rest(engine):
    run = run_of("porter_ramp", engine)
    first, last = (gm.equilibria(run.scene, spindle_speed=rpm * math.pi / 30)[0].coordinate for rpm in (115, 130))
    assert run.readings["arm_angle"][0] == pytest.approx(first, abs=1e-9)
    after = run.readings["arm_angle"][run.times > 4.0]
    assert after.min() < last < after.max()
    assert last - first > math.radians(10)


@ENGINES
def test_the_fall_of_load_brings_a_new_rest(engine):
    run = run_of("porter_load_step", engine)
    angles, times = run.readings["arm_angle"], run.times
    assert np.ptp(angles[times < 1.0]) < 1e-7  # the start is given to 12 digits
    assert angles.max() > angles[-1] + math.radians(0.5)  # it swings over
    (rest,) = gm.equilibria(run.scene, spindle_speed=float(run.readings["spindle_speed"][-1]))
    assert angles[-1] == pytest.approx(rest.coordinate, abs=1e-3)
    # Angular momentum rises by what the torque gives: 10 N m for half a second.
    momentum = 2 * run.energy.rotation / run.readings["spindle_speed"]
    assert momentum[-1] - momentum[0] == pytest.approx(5.0, abs=1e-4)


@ENGINES
def test_the_improved_governor_jumps_up_and_falls_back_at_a_lower_speed(engine):
    run = run_of("watt_improved", engine)
    kinds = ["leaves its stop", "strikes its stop", "rests on its stop"]
    assert [event.kind for event in run.events] == 2 * kinds
    times = [event.time for event in run.events]
    assert speed_at(run, times[0]) == pytest.approx(zehnder.FOLD_JUMP["stop_speed"], abs=1e-6)  # asked
    assert speed_at(run, times[3]) == pytest.approx(zehnder.FOLD_JUMP["stop_speed"], abs=1e-6)  # of the high stop, the same
    low, high = (math.radians(stop) for stop in zehnder.FOLD_JUMP["stops_deg"])
    between = run.readings["arm_angle"][(run.times > times[2]) & (run.times < times[3])]
    np.testing.assert_allclose(between, high, atol=1e-9)
    assert run.readings["arm_angle"][-1] == pytest.approx(low, abs=1e-9)
    assert speed_at(run, times[5]) < zehnder.FOLD_JUMP["lowest_speed"]
    assert run.energy.dissipated_energy[-1] > 0


def test_the_improved_governor_is_told_as_before():
    rests = gm.equilibria("watt_improved", spindle_speed=6.4)
    assert [rest.stable for rest in rests] == [False, True]
    ((fold, speed),) = gm.speed_curve("watt_improved").folds
    assert math.degrees(fold) == pytest.approx(zehnder.FOLD_JUMP["least_stable_deg"], abs=1e-8)
    assert speed == pytest.approx(zehnder.FOLD_JUMP["lowest_speed"], abs=half_unit_of_last_digit(zehnder.FOLD_JUMP["lowest_speed"]))


@ENGINES
@pytest.mark.parametrize(
    ("way", "start", "stop"), [("up", zehnder.FOLD_JUMP["stops_deg"][0], 1), ("down", zehnder.FOLD_JUMP["least_stable_deg"], 0)]
)
def test_without_its_brake_the_improved_governor_shoots_across_in_the_time_of_the_reference(engine, way, start, stop):
    scene, printed = gm.load("watt_improved"), zehnder.FOLD_JUMP[way]
    quick = scene.with_changes(
        effects=tuple(one for one in scene.effects if not isinstance(one, Dashpot)),
        spindle=Spindle(speeds=(printed["speed"],)),
        start=Start(values={"arm_angle": math.radians(start)}),
        run=RunSettings(duration=2.6, output_interval=0.01, accuracy=1e-11),
    )
    run = gm.run(quick, engine=engine)
    strike = next(event for event in run.events if event.kind == "strikes its stop")
    # Speeds and angles of 12 digits let the time, of an unstable start, be wrong by some 1e-10.
    assert strike.time == pytest.approx(printed["time"], abs=1e-9)
    assert run.readings["arm_angle"][-1] == pytest.approx(math.radians(zehnder.FOLD_JUMP["stops_deg"][stop]), abs=1e-10)
    # All of the arrival's energy is lost on the stop.
    inertia = 2 * zehnder.FOLD_JUMP["ball_mass"] * zehnder.FOLD_JUMP["arm"] ** 2
    assert run.energy.dissipated_energy[-1] == pytest.approx(0.5 * inertia * printed["arrival_rate"] ** 2, rel=1e-9)
