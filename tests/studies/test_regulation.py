"""Studies of regulation: thresholds, exponents and minima against laws and reference numbers; and their figures."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Clearance, DryFriction
from governor_mechanism.render.figures.regulation import clearance_figure, cyclic_figure, fold_jump_figure, settling_figure
from governor_mechanism.studies.regulation.cyclic_irregularity import study_clearance, study_cyclic_motion
from governor_mechanism.studies.regulation.speed_changes import SettlingStudy, study_fold_jump, study_settling
from printed_numbers import half_unit_of_last_digit
from reference import zehnder
from refusing import refuses


def by_lagrange(rate, start, angle, way):
    """Where the improved Watt governor passes its fold, by its equation of motion with one coordinate."""
    arm, offset, mass = (zehnder.FOLD_JUMP[name] for name in ("arm", "offset", "ball_mass"))

    def slope(time, state):
        angle, turn = state
        speed = start + way * rate * time
        radius = offset + arm * math.sin(angle)
        moment = 2 * mass * arm * (speed**2 * radius * math.cos(angle) - 9.81 * math.sin(angle))
        return [turn, (moment - zehnder.SLOW_FOLD_JUMP["brake"] * turn) / (2 * mass * arm**2)]

    def through(time, state):
        return state[0] - math.radians(zehnder.FOLD_JUMP["least_stable_deg"])

    through.terminal = True
    found = solve_ivp(slope, (0, 1e3), [angle, 0.0], method="DOP853", events=through, rtol=1e-12, atol=1e-13)
    return start + way * rate * found.t[-1]


@pytest.fixture(scope="module")
def jumped():
    return study_fold_jump(gm.load("watt_improved"), [4e-3, 1e-3, 2.5e-4, 1e-4])


@pytest.mark.parametrize(("rate", "up", "down"), zehnder.SLOW_FOLD_JUMP["passages"])
def test_the_jump_passes_where_the_reference_says(jumped, rate, up, down):
    k = list(jumped.ramp_rates).index(rate)
    for speed, printed, start in zip(
        (jumped.rising_speeds[k], jumped.falling_speeds[k]), (up, down), zehnder.SLOW_FOLD_JUMP["starts"], strict=True
    ):
        step = math.copysign(zehnder.SLOW_FOLD_JUMP["step"] * rate, speed - start)
        read = start + math.floor((speed - start) / step) * step
        assert read == pytest.approx(printed, abs=half_unit_of_last_digit(printed, 7))


@pytest.mark.parametrize("rate", [4e-3, 1e-3])
def test_the_jump_agrees_with_the_equation_of_one_coordinate(jumped, rate):
    k = list(jumped.ramp_rates).index(rate)
    up = by_lagrange(rate, zehnder.FOLD_JUMP["stop_speed"], math.radians(25.0), 1)
    # The scene asks for 1e-6 of the arm, and its steps are held a hundred times tighter.
    assert jumped.rising_speeds[k] == pytest.approx(up, abs=1e-9)
    rest = gm.equilibria("watt_improved", spindle_speed=6.5)[-1].coordinate
    assert jumped.falling_speeds[k] == pytest.approx(by_lagrange(rate, 6.5, rest, -1), abs=1e-9)


def test_the_jump_leaves_its_stop_at_the_static_speed(jumped):
    assert jumped.stop_speed == pytest.approx(
        zehnder.FOLD_JUMP["stop_speed"], abs=half_unit_of_last_digit(zehnder.FOLD_JUMP["stop_speed"])
    )  # half a printed digit, and rounding
    assert jumped.fold_speed == pytest.approx(
        zehnder.FOLD_JUMP["lowest_speed"], abs=half_unit_of_last_digit(zehnder.FOLD_JUMP["lowest_speed"])
    )
    assert math.degrees(jumped.fold_position) == pytest.approx(zehnder.FOLD_JUMP["least_stable_deg"], abs=1e-8)  # where the curve is flat
    np.testing.assert_allclose(jumped.leaving_speeds, jumped.stop_speed, atol=1e-10)


def test_the_fall_is_late_by_the_two_thirds_power_of_the_rate(jumped):
    # What inertia adds is of the relative order rate^(1/3); with it fitted along, the law is met far nearer.
    assert jumped.falling_exponent.value == pytest.approx(2 / 3, abs=0.01)
    columns = np.column_stack([np.log(jumped.ramp_rates), np.ones_like(jumped.ramp_rates), np.cbrt(jumped.ramp_rates)])
    exponent = np.linalg.lstsq(columns, np.log(jumped.falling_delay), rcond=None)[0][0]
    assert exponent == pytest.approx(2 / 3, abs=0.003)
    ratio = jumped.falling_delay / jumped.asymptotic_delay
    assert np.all(np.diff(ratio) < 0)  # rates fall, and the law is approached
    assert ratio[-1] == pytest.approx(1.0, abs=0.02)


def test_the_jump_up_is_late_by_the_rate_and_a_logarithm(jumped):
    assert 0.8 < jumped.rising_exponent.value < 1.0
    assert jumped.divergence_rate == pytest.approx(-25 / 16 + math.sqrt((25 / 16) ** 2 + 7.04874672335), abs=1e-9)
    # The growth changes on the way to the fold, the less the smaller the first step off the stop: one per cent.
    assert jumped.rising_divergence_rate.value == pytest.approx(jumped.divergence_rate, rel=0.02)


def test_a_jump_needs_a_fold_and_a_stop():
    refuses("'arm_angle' has none", study_fold_jump, gm.load("porter"), [1e-3])


@pytest.fixture(scope="module")
def twitched():
    return study_cyclic_motion(gm.load("porter_cyclic"), [0.5, 1 - 1e-4, 1 + 1e-4, 1 + 3e-4, 1 + 1e-3, 1.2], n_turns=4)


def test_twitching_begins_where_the_unevenness_exceeds_the_band(twitched):
    assert twitched.insensitivity_band == pytest.approx(zehnder.CYCLIC_MOTION["band"], abs=1e-9)
    assert twitched.threshold == pytest.approx(1.0, abs=1e-4)
    assert np.array_equal(twitched.amplitudes > 0, twitched.fluctuation_ratios > 1)
    assert np.all(np.diff(twitched.amplitudes[1:]) > 0)
    # The force exceeds the friction by the excess x for a time as sqrt(x): a way as x sqrt(x)^2.
    assert twitched.onset_exponent.value == pytest.approx(2.0, abs=0.02)


def test_twitching_needs_friction_and_one_mean_speed():
    scene = gm.load("porter_cyclic")
    smooth = scene.with_changes(effects=tuple(one for one in scene.effects if not isinstance(one, DryFriction)))
    refuses("needs dry friction on the sleeve", study_cyclic_motion, smooth, [1.2])
    refuses("needs a constant mean speed", study_cyclic_motion, gm.load("porter_dry_friction"), [1.2])


def test_play_under_a_loaded_sleeve_changes_nothing():
    study = study_clearance(gm.load("porter_clearance"), [1e-4, 1e-2], n_turns=2)
    assert not study.friction_carries_sleeve
    # The links never let go, so that the motion is the same but for the errors of its steps.
    np.testing.assert_allclose(study.amplitudes, study.amplitude_without_clearance, rtol=1e-6)
    assert "changes nothing" in study.conclusion
    assert study.standstill_clearance == math.inf


@pytest.fixture(scope="module")
def played():
    return study_clearance(gm.load("watt_clearance"), [2e-4, 1e-3, 4e-2], n_turns=6)


def test_small_play_of_a_carried_sleeve_makes_twitching_worse_and_wide_play_ends_it(played):
    assert played.friction_carries_sleeve
    assert played.fluctuation_ratio == pytest.approx(1.2, abs=1e-3)
    assert played.amplitudes[0] > 5 * played.amplitude_without_clearance
    assert played.amplitudes[1] > 10 * played.amplitude_without_clearance
    assert played.amplitudes[2] == 0.0
    assert played.arm_amplitudes[2] > 1e-3  # it is the balls that swing, within their play
    assert played.standstill_clearance == 4e-2
    assert "; from 40 mm the sleeve is at rest" in played.conclusion


def test_small_play_makes_a_carried_sleeve_twitch_within_its_band():
    scene = gm.load("watt_clearance")
    even = scene.with_changes(spindle=replace(scene.spindle, speed_fluctuation=0.8 / 1.2 * scene.spindle.speed_fluctuation))
    study = study_clearance(even, [1e-3], n_turns=6)
    assert study.amplitude_without_clearance == 0.0
    assert study.amplitudes[0] > 0.0
    assert study.conclusion == f"{study.title}: a clearance of 1 mm causes cyclic motion"
    refuses("the reference of the figure", clearance_figure, study)


@pytest.fixture(scope="module")
def settled():
    scene = gm.load("porter_load_step")
    return study_settling(replace(scene, run=replace(scene.run, accuracy=1e-4)), [60.0, 150.0, 250.0, 500.0, 900.0])


def test_settling_has_a_best_brake(settled):
    times = settled.settling_times
    assert np.argmin(times) == 2
    assert times[0] > times[1] > times[2] < times[3] < times[4]
    brake, best = settled.best
    assert 200 < brake < 260
    assert best <= times[2]


def test_settling_is_counted_to_the_last_time_off_the_band(settled):
    scene = gm.load("porter_load_step")
    others = tuple(one for one in scene.effects if not isinstance(one, Dashpot))
    long = scene.with_changes(
        effects=(*others, Dashpot(reading="sleeve_lift", linear=500.0)), run=replace(scene.run, duration=30.0, output_interval=1e-3)
    )
    run = gm.run(long, certify=False)
    angles = run.readings["arm_angle"]
    outside = np.abs(angles - angles[-1]) > 0.02 * abs(angles[-1] - angles[0])
    # Found by looking at every millisecond of a run long enough to end at rest.
    assert settled.settling_times[3] == pytest.approx(run.times[np.flatnonzero(outside)[-1]] - 1.0, abs=2e-3)


def test_what_does_not_settle_says_so():
    scene = gm.load("porter_load_step")
    short = replace(scene, run=replace(scene.run, duration=2.0))
    refuses("with no dashpot does the governor settle within 2 s", study_settling, short, [10.0])
    refuses("free spindle with a torque that changes", study_settling, gm.load("porter"), [10.0])


@pytest.mark.long
def test_figures_are_written_whole_or_not_at_all(tmp_path, twitched, played, settled, jumped):
    written = [
        cyclic_figure(twitched).save(tmp_path / "cyclic.png"),
        clearance_figure(played).save(tmp_path / "clearance.png"),
        settling_figure(settled).save(tmp_path / "settling.png"),
        fold_jump_figure(jumped).save(tmp_path / "jump.png"),
    ]
    for path in written:
        assert path.read_bytes().startswith(b"\x89PNG")
    refuses(r"must end in one of \.png", settling_figure(settled).save, tmp_path / "settling.gif")
    hidden = replace(settled, settling_times=np.full_like(settled.settling_times, np.nan))
    assert isinstance(hidden, SettlingStudy)
    with pytest.raises(ValueError, match="zero-size array"):
        settling_figure(hidden).save(tmp_path / "none.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clearance.png", "cyclic.png", "jump.png", "settling.png"]


def test_a_scene_keeps_its_part_of_the_play():
    from governor_mechanism.studies.regulation.cyclic_irregularity import _make_scene_with_clearance

    scene = gm.load("porter_clearance")
    wider = _make_scene_with_clearance(scene, 2e-3)
    assert wider.start.values["sleeve_clearance"] == pytest.approx(-1e-3)
    assert Clearance(width=2e-3) in wider.effects
    bare = _make_scene_with_clearance(scene, 0.0)
    assert "sleeve_clearance" not in bare.start.values
    assert not any(isinstance(one, Clearance) for one in bare.effects)
