"""Studies of regulation: thresholds, exponents and minima against laws and reference numbers; and their figures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.effects.clearance import Play
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.render.figures.regulation import jump_figure, play_figure, settling_figure, twitch_figure
from governor_mechanism.studies.regulation.registry import Settling, jump, play_and_twitch, settling, twitch
from reference.zehnder import SLOW_SNAP, SNAP, TWITCHING, half_unit


def by_lagrange(rate, start, angle, way):
    """Where the improved Watt governor passes its fold, by its equation of motion with one coordinate."""
    arm, offset, mass = (SNAP[name] for name in ("arm", "offset", "ball_mass"))

    def slope(time, state):
        angle, turn = state
        speed = start + way * rate * time
        radius = offset + arm * math.sin(angle)
        moment = 2 * mass * arm * (speed**2 * radius * math.cos(angle) - 9.81 * math.sin(angle))
        return [turn, (moment - SLOW_SNAP["brake"] * turn) / (2 * mass * arm**2)]

    def through(time, state):
        return state[0] - math.radians(SNAP["least_stable_deg"])

    through.terminal = True
    found = solve_ivp(slope, (0, 1e3), [angle, 0.0], method="DOP853", events=through, rtol=1e-12, atol=1e-13)
    return start + way * rate * found.t[-1]


@pytest.fixture(scope="module")
def jumped():
    return jump(gm.load("watt_improved"), [4e-3, 1e-3, 2.5e-4, 1e-4])


@pytest.mark.parametrize(("rate", "up", "down"), SLOW_SNAP["passages"])
def test_the_jump_passes_where_the_reference_says(jumped, rate, up, down):
    k = list(jumped.rates).index(rate)
    for speed, printed, start in zip(
        (jumped.rising[k], jumped.falling[k]), (up, down), SLOW_SNAP["starts"], strict=True
    ):
        step = math.copysign(SLOW_SNAP["step"] * rate, speed - start)
        read = start + math.floor((speed - start) / step) * step
        assert read == pytest.approx(printed, abs=half_unit(printed, 7))


@pytest.mark.parametrize("rate", [4e-3, 1e-3])
def test_the_jump_agrees_with_the_equation_of_one_coordinate(jumped, rate):
    k = list(jumped.rates).index(rate)
    up = by_lagrange(rate, SNAP["stop_speed"], math.radians(25.0), 1)
    # The scene asks for 1e-6 of the arm, and its steps are held a hundred times tighter.
    assert jumped.rising[k] == pytest.approx(up, abs=1e-9)
    rest = gm.equilibria("watt_improved", spindle_speed=6.5)[-1].coordinate
    assert jumped.falling[k] == pytest.approx(by_lagrange(rate, 6.5, rest, -1), abs=1e-9)


def test_the_jump_leaves_its_stop_at_the_static_speed(jumped):
    assert jumped.stop_speed == pytest.approx(
        SNAP["stop_speed"], abs=half_unit(SNAP["stop_speed"])
    )  # half a printed digit, and rounding
    assert jumped.fold_speed == pytest.approx(SNAP["lowest_speed"], abs=half_unit(SNAP["lowest_speed"]))
    assert math.degrees(jumped.fold) == pytest.approx(SNAP["least_stable_deg"], abs=1e-8)  # where the curve is flat
    np.testing.assert_allclose(jumped.leaving, jumped.stop_speed, atol=1e-10)


def test_the_fall_is_late_by_the_two_thirds_power_of_the_rate(jumped):
    # What inertia adds is of the relative order rate^(1/3); with it fitted along, the law is met far nearer.
    assert jumped.falling_exponent.value == pytest.approx(2 / 3, abs=0.01)
    assert jumped.falling_limit.value == pytest.approx(2 / 3, abs=0.003)
    ratio = jumped.falling_delay / jumped.law
    assert np.all(np.diff(ratio) < 0)  # rates fall, and the law is approached
    assert ratio[-1] == pytest.approx(1.0, abs=0.02)


def test_the_jump_up_is_late_by_the_rate_and_a_logarithm(jumped):
    assert 0.8 < jumped.rising_exponent.value < 1.0
    assert jumped.growth == pytest.approx(-25 / 16 + math.sqrt((25 / 16) ** 2 + 7.04874672335), abs=1e-9)
    # The growth changes on the way to the fold, the less the smaller the first step off the stop: one per cent.
    assert jumped.rising_growth.value == pytest.approx(jumped.growth, rel=0.02)


def test_a_jump_needs_a_fold_and_a_stop():
    with pytest.raises(gm.MechanismError, match="needs a low stop of 'arm_angle'"):
        jump(gm.load("porter"), [1e-3])


@pytest.fixture(scope="module")
def twitched():
    return twitch(gm.load("porter_twitch"), [0.5, 1 - 1e-4, 1 + 1e-4, 1 + 3e-4, 1 + 1e-3, 1.2], turns=4)


def test_twitching_begins_where_the_unevenness_exceeds_the_band(twitched):
    assert twitched.band == pytest.approx(TWITCHING["band"], abs=1e-9)
    assert twitched.threshold == pytest.approx(1.0, abs=1e-4)
    assert np.array_equal(twitched.amplitudes > 0, twitched.shares > 1)
    assert np.all(np.diff(twitched.amplitudes[1:]) > 0)
    # The force exceeds the friction by the excess x for a time as sqrt(x): a way as x sqrt(x)^2.
    assert twitched.onset.value == pytest.approx(2.0, abs=0.02)


def test_twitching_needs_friction_and_one_mean_speed():
    scene = gm.load("porter_twitch")
    smooth = replace(scene, effects=tuple(one for one in scene.effects if not isinstance(one, DryFriction)))
    with pytest.raises(gm.MechanismError, match="twitches against dry friction"):
        twitch(smooth, [1.2])
    with pytest.raises(gm.MechanismError, match="about one mean speed"):
        twitch(gm.load("porter_dry_friction"), [1.2])


def test_play_under_a_loaded_sleeve_changes_nothing():
    study = play_and_twitch(gm.load("porter_play"), [1e-4, 1e-2], turns=2)
    assert not study.carried
    # The links never let go, so that the motion is the same but for the errors of its steps.
    np.testing.assert_allclose(study.amplitudes, study.without_play, rtol=1e-6)
    assert "changes nothing" in study.finding
    assert study.still_from == math.inf


@pytest.fixture(scope="module")
def played():
    return play_and_twitch(gm.load("watt_play"), [2e-4, 1e-3, 4e-2], turns=6)


def test_small_play_of_a_carried_sleeve_makes_twitching_worse_and_wide_play_ends_it(played):
    assert played.carried
    assert played.share == pytest.approx(1.2, abs=1e-3)
    assert played.amplitudes[0] > 5 * played.without_play
    assert played.amplitudes[1] > 10 * played.without_play
    assert played.amplitudes[2] == 0.0
    assert played.arm_amplitudes[2] > 1e-3  # it is the balls that swing, within their play
    assert played.still_from == 4e-2
    assert "times worse; from 40 mm on the sleeve stands still" in played.finding


def test_small_play_makes_a_carried_sleeve_twitch_within_its_band():
    scene = gm.load("watt_play")
    even = replace(scene, spindle=replace(scene.spindle, unevenness=0.8 / 1.2 * scene.spindle.unevenness))
    study = play_and_twitch(even, [1e-3], turns=6)
    assert study.without_play == 0.0
    assert study.amplitudes[0] > 0.0
    assert study.finding == "play of 1 mm makes it twitch"
    with pytest.raises(gm.MechanismError, match="nothing to compare with"):
        play_figure([study], "play.png")


@pytest.fixture(scope="module")
def settled():
    scene = gm.load("porter_load_step")
    return settling(replace(scene, run=replace(scene.run, accuracy=1e-4)), [60.0, 150.0, 250.0, 500.0, 900.0])


def test_settling_has_a_best_brake(settled):
    times = settled.times
    assert np.argmin(times) == 2
    assert times[0] > times[1] > times[2] < times[3] < times[4]
    brake, best = settled.best
    assert 200 < brake < 260
    assert best <= times[2]


def test_settling_is_counted_to_the_last_time_off_the_band(settled):
    scene = gm.load("porter_load_step")
    others = tuple(one for one in scene.effects if not isinstance(one, OilBrake))
    long = replace(
        scene,
        effects=(*others, OilBrake(reading="sleeve_lift", linear=500.0)),
        run=replace(scene.run, duration=30.0, every=1e-3),
    )
    run = gm.run(long, certify=False)
    angles = run.readings["arm_angle"]
    outside = np.abs(angles - angles[-1]) > 0.02 * abs(angles[-1] - angles[0])
    # Found by looking at every millisecond of a run long enough to end at rest.
    assert settled.times[3] == pytest.approx(run.times[np.flatnonzero(outside)[-1]] - 1.0, abs=2e-3)


def test_what_does_not_settle_says_so():
    scene = gm.load("porter_load_step")
    short = replace(scene, run=replace(scene.run, duration=2.0))
    with pytest.raises(gm.MechanismError, match="no brake settles it within 2 s"):
        settling(short, [10.0])
    with pytest.raises(gm.MechanismError, match="free spindle whose torque changes"):
        settling(gm.load("porter"), [10.0])


def test_figures_are_written_whole_or_not_at_all(tmp_path, twitched, played, settled, jumped):
    written = [
        twitch_figure(twitched, tmp_path / "twitch.png"),
        play_figure([played], tmp_path / "play.png"),
        settling_figure(settled, tmp_path / "settling.png"),
        jump_figure(jumped, tmp_path / "jump.png"),
    ]
    for path in written:
        assert path.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(gm.MechanismError, match=r"must end in \.png"):
        settling_figure(settled, tmp_path / "settling.pdf")
    hidden = replace(settled, times=np.full_like(settled.times, np.nan))
    assert isinstance(hidden, Settling)
    with pytest.raises(ValueError, match="zero-size array"):
        settling_figure(hidden, tmp_path / "none.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["jump.png", "play.png", "settling.png", "twitch.png"]


def test_a_scene_keeps_its_part_of_the_play():
    from governor_mechanism.studies.regulation.cyclic_irregularity import _with_play

    scene = gm.load("porter_play")
    wider = _with_play(scene, 2e-3)
    assert wider.start.values["sleeve_play"] == pytest.approx(-1e-3)
    assert Play(width=2e-3) in wider.effects
    bare = _with_play(scene, 0.0)
    assert "sleeve_play" not in bare.start.values
    assert not any(isinstance(one, Play) for one in bare.effects)
