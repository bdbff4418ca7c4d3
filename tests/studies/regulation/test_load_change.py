"""A governed engine after a change of its load: droop, energies and motion against equations written out by hand, and refusals."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import governor_mechanism as gm
from command_line import json_of
from governor_mechanism.closed_form import governed_engine, slide_valve
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.regulation.load_change import Verdict
from reference import flywheel as printed
from refusing import refuses

ARM, OFFSET, BALL, SLEEVE, GRAVITY = 0.3, 0.04, 5.0, 21.0, 9.81
"""Governor of the shipped scenes: lengths in m, masses in kg."""

FLYWHEEL, DASHPOT, RATED = 800.0, 300.0, 300.0
"""kg m2, N s/m and N m of the shipped scenes."""

ENGINE = AirEngine(**printed.ENGINE)
MODEL = gm.load("governed_engine_mean_torque").document


def lift_at(angle):
    """Return the lift of the sleeve above hanging arms, m, from the rhombus of arms and links."""
    return 2 * ARM * (1 - math.cos(angle))


def engine_torque(angle):
    """Return the mean torque, N m, of the throttle that the sleeve closes from 80 mm to 120 mm by a fifth."""
    opening = 1 - 0.2 * np.clip((lift_at(angle) - 0.08) / 0.04, 0.0, 1.0)
    return governed_engine.full_throttle_torque(ENGINE) - (1 - opening) * governed_engine.throttle_torque(ENGINE)


def speed_at(angle):
    """Return the speed (rad/s) at which a Porter governor with equal arms and links rests: w^2 r = g (1 + M / m) tan a."""
    return math.sqrt(GRAVITY * (1 + SLEEVE / BALL) * math.tan(angle) / (OFFSET + ARM * math.sin(angle)))


def equilibrium(load):
    """Return arm angle (rad) and speed (rad/s) at a load, N m."""
    angle = brentq(lambda one: engine_torque(one) - load, 0.53, 0.64, xtol=1e-15)
    return angle, speed_at(angle)


def motion(_, state, load):
    """Lagrange's equations of arms and shaft, by hand: a'' and w' from T = I a'^2 / 2 + (J0 + 2 m r^2) w^2 / 2."""
    angle, rate, speed = state
    sine, cosine = math.sin(angle), math.cos(angle)
    radius = OFFSET + ARM * sine
    inertia = 2 * BALL * ARM**2 + SLEEVE * (2 * ARM * sine) ** 2
    inertia_slope = 8 * SLEEVE * ARM**2 * sine * cosine
    weight = 2 * (BALL + SLEEVE) * GRAVITY * ARM * sine
    centrifugal = 2 * BALL * radius * ARM * cosine * speed**2
    damping = DASHPOT * (2 * ARM * sine) ** 2 * rate
    arm_acceleration = (centrifugal - weight - damping - 0.5 * inertia_slope * rate**2) / inertia
    total = FLYWHEEL + 2 * BALL * radius**2
    torque = engine_torque(angle) - load - 4 * BALL * radius * ARM * cosine * rate * speed
    return [rate, arm_acceleration, torque / total]


@pytest.fixture(scope="module")
def response():
    """Return the response of the shipped loop with mean torque."""
    return gm.load_change_study("governed_engine_mean_torque", "100%:50%", accuracy=1e-9)


def test_the_droop_is_that_of_speed_curve_and_torque_curve(response):
    speeds = [equilibrium(fraction * RATED)[1] for fraction in (1.0, 0.5)]
    expected = speeds[1] / speeds[0] - 1
    assert response.static_droop == pytest.approx(expected, abs=1e-11)  # both by a root to rounding
    assert response.droop == pytest.approx(expected, abs=1e-8)  # 54 s after the step the slowest mode has decayed to exp(-61)
    assert response.verdict is Verdict.SETTLES


def test_the_motion_is_that_of_equations_by_hand(response):
    run, begin = response.run, response.change_times[0]
    angle, speed = equilibrium(RATED)
    times = run.times[(run.times > begin) & (run.times < begin + 10)]
    # Twice the tolerance of the comparison would show; the sleeve stays between the ends of its table.
    solution = solve_ivp(motion, (begin, times[-1]), [angle, 0.0, speed], "DOP853", times, args=(0.5 * RATED,), rtol=1e-12, atol=1e-13)
    rows = np.isin(run.times, times)
    assert np.abs(run.rates["engine.crank_angle"][rows] - solution.y[2]).max() < 1e-9
    assert np.abs(run.readings["governor.arm_angle"][rows] - solution.y[0]).max() < 1e-9


def test_settling_and_overshoot_are_those_of_the_motion_by_hand(response):
    angle, speed = equilibrium(RATED)
    last = equilibrium(0.5 * RATED)[1]
    times = np.linspace(0.0, 12.0, 4801)
    speeds = solve_ivp(motion, (0.0, 12.0), [angle, 0.0, speed], "DOP853", times, args=(0.5 * RATED,), rtol=1e-11).y[2]
    outside = np.flatnonzero(np.abs(speeds - last) > 0.05 * (last - speed))
    # The study averages over a turn, half a second: a linear approach is the same, and the curvature costs some hundredths of a second.
    assert response.settling_time == pytest.approx(times[outside[-1]], abs=0.05)
    assert response.overshoot == pytest.approx(max(speeds.max() - last, 0.0) / (last - speed), abs=0.01)
    assert response.speed_error_integral == pytest.approx(np.trapezoid(np.abs(speeds - last), times), rel=0.02)


def test_the_energy_of_the_whole_loop_balances(response):
    work = response.work
    assert abs(work["left"]) < 1e-9 * work["engine"]
    # The load takes its torque over the angle, and the dashpot c (dz/dt)^2 over time; by the trapezoidal rule on 20 ms.
    run = response.run
    lift_rate = run.rates["governor.sleeve_lift"]
    assert work["dissipated"] == pytest.approx(np.trapezoid(DASHPOT * lift_rate**2, run.times), rel=1e-3)
    angles, begin = run.readings["engine.crank_angle"], np.searchsorted(run.times, 6.0)
    expected = RATED * (angles[begin] - angles[0]) + 0.5 * RATED * (angles[-1] - angles[begin])
    assert work["load"] == pytest.approx(expected, rel=1e-9)


def test_the_work_of_the_engine_is_that_of_its_torque(response):
    run = response.run
    power = run.readings["engine.gas_torque"] * run.rates["engine.crank_angle"]
    # The torque changes by half within 3 s, smoothly: the trapezoidal rule on 20 ms is good to 1e-4 of a joule or so. The
    # governor alone stores 4 J, so that its sign shows.
    assert response.work["engine"] == pytest.approx(np.trapezoid(power, run.times), abs=0.02)


def test_the_free_force_at_the_sleeve_is_that_of_weights_and_centrifugal_forces(response):
    run, rows = response.run, response.run.times >= response.change_times[0]
    angles, speeds = run.readings["governor.arm_angle"][rows], run.rates["engine.crank_angle"][rows]
    moments = 2 * BALL * (OFFSET + ARM * np.sin(angles)) * ARM * np.cos(angles) * speeds**2
    moments -= 2 * (BALL + SLEEVE) * GRAVITY * ARM * np.sin(angles)
    # By virtual work, dz = 2 l sin a da; forces are interpolated between 201 points of the travel.
    assert response.sleeve_force == pytest.approx(np.abs(moments / (2 * ARM * np.sin(angles))).max(), rel=1e-4)


def test_a_load_that_grows_with_the_speed_enters_the_statics():
    scene = parse_scene_with(MODEL, [("part.engine.dimensions.load_damping", 3.0)])
    point = gm.load_change_study(scene).after
    steady = gm.linearise(scene)  # under the last load, half of the rated torque
    assert point.shaft_speed == pytest.approx(steady.rates["engine.crank_angle"], rel=1e-10)  # both by roots to rounding
    angle, speed = steady.readings["governor.arm_angle"], point.shaft_speed
    assert engine_torque(angle) == pytest.approx(0.5 * RATED + 3.0 * speed, rel=1e-9)


def test_a_cyclic_engine_balances_too_and_droops_as_its_mean_torque():
    scene = parse_scene_with(gm.load("governed_engine").document, [("run.duration", 14.0)])
    response = gm.load_change_study(scene, at=6.0, accuracy=1e-8)
    assert response.run.energy.drift < 1e-9
    # The speed at which the governor rests on average under a fluctuation delta of 2.3 % differs by some delta^2 / 8.
    assert response.droop == pytest.approx(response.static_droop, abs=2e-4)
    assert response.fluctuations[1] == pytest.approx(0.023, abs=1e-3)  # of the same order as the 1/40 that the wheel was sized for


def test_too_weak_a_dashpot_hunts():
    scene = parse_scene_with(MODEL, [("part.governor.effects.dashpot.sleeve", 8.0)])
    response = gm.load_change_study(scene)
    assert response.verdict is Verdict.HUNTS
    # Saturated at both ends of the table, the oscillation keeps near the frequency of the linear limit.
    assert response.hunting_period == pytest.approx(2 * math.pi / gm.linearise(scene).modes[0].natural_frequency, rel=0.1)


def test_a_ramp_ends_at_the_same_speed_as_a_step(response):
    ramp = gm.load_change_study("governed_engine_mean_torque", (1.0, 0.5), at="6 s", ramp="4 s")
    assert ramp.mean_speeds[2] == pytest.approx(response.mean_speeds[2], rel=1e-10)
    assert ramp.largest_deviation <= response.largest_deviation + 1e-9


def test_a_load_above_the_power_of_the_engine_is_named_before_the_run_and_stalls_with_its_time():
    response = gm.load_change_study("governed_engine_mean_torque", "100%:200%")
    assert response.verdict is Verdict.STALLS
    assert response.run.outcome is Outcome.SHAFT_STALLED
    assert response.messages[0].startswith("a load of 600 N m has no equilibrium: over the travel of the governor")
    assert "371.621 N m, so that the engine stalls" in response.messages[0]
    assert "t = " in response.messages[1]
    assert math.isnan(response.static_droop)
    shorter = parse_scene_with(MODEL, [("run.duration", 30.0)])
    assert gm.load_change_study(shorter, "100%:200%").verdict is Verdict.UNDECIDED  # it slows down all the time, and that is no hunting


def test_a_load_that_depends_on_a_reading_is_refused_by_the_study():
    scene = parse_scene_with(MODEL, [("load.fraction", {"reading": "engine.crank_angle", "gain": 0.01})])
    refuses(r"load\.fraction depends on a reading; write a number or a program of time", gm.load_change_study, scene)


def test_rare_reports_of_the_scene_do_not_blur_the_turns():
    """With a report every 3 s a turn of half a second would be averaged from none, and the engine would seem to hunt."""
    changes = [("run.duration", 14.0), ("run.output_interval", 3.0)]
    response = gm.load_change_study(parse_scene_with(gm.load("governed_engine").document, changes), at=6.0)
    assert response.verdict is Verdict.SETTLES
    assert len(response.run.times) > 20 * response.run.readings["engine.crank_angle"][-1] / (2 * math.pi)


def test_the_cut_off_gear_is_that_of_a_shifted_eccentric():
    table = gm.load("governed_engine_cut_off").document["coupling"]["eccentric"]["table"]
    for k, (lift, cut_off) in enumerate(table):
        assert lift == f"{80 + 5 * k} mm"
        along, across = 0.030, 0.028 - 0.0025 * k  # lap and lead along the crank stay, the other coordinate is shifted
        eccentric = slide_valve.Eccentric(radius=math.hypot(along, across), rod=math.inf, advance=math.atan2(along, across))
        angle = slide_valve.event_angle(eccentric, event="crank end cut-off", outside_lap=0.024, inside_lap=0.005)
        assert cut_off == pytest.approx(0.5 * (1 - math.cos(angle)), abs=1e-12)  # printed with twelve digits


def test_the_command_prints_the_response(tmp_path):
    values = json_of("regulation", "loop", "governed_engine_mean_torque", "--load-step", "100%:50%", "--out", tmp_path)
    assert values["verdict"] == "settles"
    assert values["droop"] == pytest.approx(0.022687, abs=1e-6)
    assert (tmp_path / "governed_engine_mean_torque_loop.png").exists()
