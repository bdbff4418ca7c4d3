"""The laws behind the papers' rules about governing, in the simulated engine; and verdicts that follow from the numbers."""

import json
import math
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.hartung import HartungGovernor, static_sleeve_force
from governor_mechanism.papers import damping, dead_band, droop
from governor_mechanism.papers import rules_study as paper_rules
from governor_mechanism.papers.damping import DashpotCheck, DryFrictionCheck
from governor_mechanism.papers.dead_band import DeadBandCheck, RegulatingForceCheck, measure_dead_band
from governor_mechanism.papers.droop import DroopCheck
from governor_mechanism.papers.rule import SteadyEngine, Verdict, build_cyclic_engine, find_steady_engine
from governor_mechanism.papers.rules_study import PaperRules, study_paper_rules
from governor_mechanism.papers.shaking import ClearanceCheck, OilBrakeCheck, ShakingCheck
from refusing import refuses
from result_checks import check_result

ARM, BALL, SLEEVE_MASS, GRAVITY, FLYWHEEL = 0.3, 5.0, 21.0, 9.81, 800.0
"""The shipped governor and flywheel, SI."""


@pytest.fixture(scope="module")
def steady():
    return find_steady_engine(gm.load("governed_engine_mean_torque"))


def band_of(relative_friction):
    """Zehnder's speeds w sqrt(1 +- W / (P + Q)): their difference over w."""
    return math.sqrt(1 + relative_friction) - math.sqrt(1 - relative_friction)


class Loop:
    """Vyshnegradskii's cubic Jt I s^3 + Jt c s^2 + (Jt K + r^2 w^2 J'^2) s + r w J' b = 0 from Zehnder's geometry, by hand.

    I, K and J' are those of a rhombus with two balls; r is the gear ratio, Jt the inertia of shaft, and b the slope of the torque.
    """

    def __init__(self, steady: SteadyEngine, offset: float) -> None:
        sine, cosine = math.sin(steady.coordinate), math.cos(steady.coordinate)
        radius = offset + ARM * sine
        speed = math.sqrt(GRAVITY * (1 + SLEEVE_MASS / BALL) * sine / cosine / radius)
        ratio = steady.governor_speed / steady.engine_speed
        self.lift_slope = 2 * ARM * sine
        self.inertia = 2 * BALL * ARM**2 + SLEEVE_MASS * self.lift_slope**2
        self.stiffness = 2 * ARM * (BALL + SLEEVE_MASS) * GRAVITY * (offset + ARM * sine**3) / (cosine * radius)
        self.gyration = ratio * speed * 4 * BALL * radius * ARM * cosine
        self.shaft = FLYWHEEL + ratio**2 * 2 * BALL * radius**2
        less, more = (find_steady_engine(steady.scene, {"load.fraction": fraction}) for fraction in (0.49, 0.51))
        self.torque_slope = 0.02 * 300.0 / (less.sleeve_lift - more.sleeve_lift) * self.lift_slope
        # Hurwitz: c (Jt K + r^2 w^2 J'^2) = I r w J' b, with the dashpot c on the sleeve seen from the arms.
        held = self.shaft * self.stiffness + self.gyration**2
        self.damping_limit = self.inertia * self.gyration * self.torque_slope / held / self.lift_slope**2
        self.frequency = math.sqrt(held / (self.shaft * self.inertia))


@pytest.fixture(scope="module")
def loop(steady):
    return Loop(steady, 0.04)


def test_the_sleeve_shakes_if_the_speed_fluctuates_more_than_the_governor_is_insensitive(steady):
    engine = build_cyclic_engine(gm.load("governed_engine"), steady, {})
    # The paper's delta of the friction that is taken is the fluctuation.
    weight = (BALL + SLEEVE_MASS) * GRAVITY
    assert band_of(engine.find_friction(1.0) / weight) == pytest.approx(engine.fluctuation, rel=1e-12)
    # The sampled extremes of the speed are 1e-4 of the fluctuation off at most, and the middle of the band 1e-3.
    assert engine.does_sleeve_move(0.998, {})
    assert not engine.does_sleeve_move(1.002, {})


def test_the_sleeve_breaks_away_at_the_ends_of_the_insensitivity_band(steady):
    # The speed at breakaway is interpolated in a run whose speed is linear in time, at an accuracy of 1e-8.
    assert measure_dead_band(steady, 10.0) == pytest.approx(band_of(10.0 / ((BALL + SLEEVE_MASS) * GRAVITY)), rel=1e-6)
    refuses("300 N hold the sleeve for 12 s at a load", measure_dead_band, steady, 300.0)


def test_the_dead_band_of_a_strong_governor_is_that_of_its_force(steady):
    hartung = gm.load("governed_engine_hartung")
    strong = find_steady_engine(dead_band._exchange_governor(gm.load("governed_engine_mean_torque"), hartung))
    dimensions = hartung.part_of("governor")[0].dimensions
    names = ("weight_arm", "sleeve_arm", "fulcrum_radius", "weight_mass", "sleeve_mass")
    governor = HartungGovernor(angle=dimensions["bell_crank_angle"], **{name: dimensions[name] for name in names})
    radius = dimensions["fulcrum_radius"] - dimensions["weight_arm"] * math.sin(strong.coordinate)
    spring = dimensions["spring_preload"] + dimensions["spring_rate"] * (radius - dimensions["preload_radius"])
    force = static_sleeve_force(governor, lever_angle=strong.coordinate, spring_force=spring)
    # The accuracy of the run, 1e-8 of the speed, is 3e-6 of this narrow band.
    assert measure_dead_band(strong, 20.0) == pytest.approx(band_of(20.0 / force), rel=1e-5)


def test_the_engine_hunts_below_the_dashpot_of_vyshnegradskii(steady, loop):
    limit = damping.find_damping_limit(steady)
    # The slope of the torque is a difference over 2 % of the load, which is linear in the throttle, and that in the lift.
    assert limit.value == pytest.approx(loop.damping_limit, rel=1e-4)
    assert limit.frequency == pytest.approx(loop.frequency, rel=1e-6)
    assert droop.find_growth_rate(steady, 0.0) > 0


def test_dry_friction_stops_hunting_up_to_the_displacement_of_harmonic_balance(steady, loop):
    # 4 W A per period against pi w (c0 - c) A^2; higher harmonics of the friction and the curved governor are worth 1 % here.
    limit = 4 * damping.FRICTION / (math.pi * loop.frequency * loop.damping_limit)
    for ratio, grows in ((0.9, False), (1.1, True)):
        assert damping.does_hunting_grow(damping.run_displaced(steady, 0.0, ratio * limit)[1]) is grows


def test_an_astatic_governor_hunts_until_its_reaction_on_the_shaft_damps_it(steady):
    mean_engine = gm.load("governed_engine_mean_torque")
    offset = droop.find_astatic_offset(mean_engine, steady)
    astatic = droop.govern_with_offset(mean_engine, steady, offset)
    # Zehnder's condition of the astatic position: the arm is as long as the radius of curvature of the parabola, e = -l sin^3 a.
    assert offset == pytest.approx(-ARM * math.sin(astatic.coordinate) ** 3, abs=1e-8)
    assert astatic.droop_over(0.04) == pytest.approx(0.0, abs=1e-8)  # tolerance of the search
    assert astatic.engine_speed == pytest.approx(steady.engine_speed, rel=1e-9)  # the gear keeps it
    limit = Loop(astatic, offset).damping_limit
    assert limit > 100 * Loop(steady, 0.04).damping_limit
    assert droop.find_growth_rate(astatic, 0.9 * limit) > 0 > droop.find_growth_rate(astatic, 1.1 * limit)


def test_droop_is_the_change_of_the_equilibrium_speed_over_the_travel(steady):
    angles = steady.coordinate + np.array([-1e-4, 1e-4])
    lifts = 2 * ARM * (1 - np.cos(angles))
    speeds = np.sqrt(GRAVITY * (1 + SLEEVE_MASS / BALL) * np.tan(angles) / (0.04 + ARM * np.sin(angles)))
    slope = float(np.diff(speeds)[0] / np.diff(lifts)[0]) / steady.governor_speed
    assert steady.droop_over(0.04) == pytest.approx(0.04 * slope, rel=1e-6)  # the difference is of second order
    assert droop.throttle_travel(steady.scene) == pytest.approx(0.04)


def test_settling_is_counted_to_the_last_time_outside_the_band():
    times = np.linspace(0.0, 20.0, 20001)
    lifts = 1.0 + np.exp(-np.maximum(times - damping.STEP_TIME, 0.0))
    assert damping._find_settling_time(times, lifts, 1.0) == pytest.approx(math.log(50.0), abs=2e-3)  # two samples
    assert damping._find_settling_time(times, 1.0 + np.cos(times), 1.0) == math.inf


def test_growth_is_fitted_to_the_extremes():
    times = np.linspace(0.0, 40.0, 4001)
    deviations = np.exp(0.05 * times) * np.sin(1.3 * times)
    assert droop._fit_growth_rate(times, deviations) == pytest.approx(0.05, abs=1e-4)  # extremes within half a sample


def made_up_rules() -> PaperRules:
    """Rules with numbers of a made-up engine."""
    times = np.linspace(0.0, 10.0, 50)
    band = np.array([0.008, 0.08])
    return PaperRules(
        shaking=ShakingCheck(
            ratios=np.array([0.5, 0.9, 1.1]), amplitudes=np.array([2e-4, 1e-5, 0.0]), fluctuation=0.02, thresholds={800.0: 1.0001}
        ),
        oil_brake=OilBrakeCheck(
            dampings=np.array([100.0, 1000.0]), amplitudes=np.array([2e-4, 2e-5]), decay_rates=np.array([1.0, 0.9]), thresholds=(1.0, 1.0)
        ),
        clearance=ClearanceCheck(clearances=np.array([0.0, 1e-3, 1e-2]), amplitudes={"loaded sleeve": np.array([1e-4, 1e-4, 1e-4])}),
        dead_band=DeadBandCheck(
            frictions=np.array([2.0, 20.0]),
            measured_widths=band,
            static_widths=band,
            paper_widths=band,
            loads_before=np.array([0.25, 0.75]),
            rest_deviations=np.array([-0.02, 0.01]),
            rest_friction=10.0,
            band=(-0.02, 0.02),
            histories=((times, -0.02 * times), (times, 0.01 * times)),
        ),
        force=RegulatingForceCheck(
            frictions=np.array([2.0, 20.0]), sleeve_forces=np.array([250.0, 5000.0]), widths=np.array([[0.008, 0.08], [0.0004, 0.004]])
        ),
        damping=DashpotCheck(
            dampings=np.array([10.0, 30.0, 300.0, 3000.0]),
            settling_times=np.array([math.inf, 20.0, 4.0, 30.0]),
            undamped_growth_rate=0.3,
            limit=20.0,
            limit_frequency=5.0,
            histories=(),
        ),
        dry_friction=DryFrictionCheck(
            friction=0.5,
            dampings=np.array([0.0]),
            growth_rates=np.array([0.3]),
            limits=np.array([6e-3]),
            predicted_limits=np.array([6e-3]),
            histories=tuple((ratio, times, 0.1 + 1e-3 * np.cos(times)) for ratio in (0.8, 1.2)),
        ),
        droop=DroopCheck(
            offsets=np.array([0.04, -0.06]),
            droops=np.array([0.05, 0.0]),
            dampings=np.array([30.0, 300.0]),
            growth_rates=np.array([[-0.1, 0.9], [-1.0, 0.1]]),
            astatic_growth_rates={300.0: 0.1, 3000.0: 0.01},
            histories=(),
            simulated_growth_rate=0.1,
            predicted_growth_rate=0.1,
        ),
    )


def test_verdicts_follow_from_the_numbers():
    rules = made_up_rules()
    holds = [Verdict.HOLDS, Verdict.HOLDS, Verdict.FAILS, *[Verdict.HOLDS] * 3, Verdict.CONDITIONAL, Verdict.HOLDS]
    assert [rule.verdict for rule in rules] == holds
    shaking, oil_brake, clearance, band = rules.shaking, rules.oil_brake, rules.clearance, rules.dead_band
    assert replace(shaking, thresholds={800.0: 1.2}).verdict is Verdict.CONDITIONAL
    assert replace(shaking, amplitudes=np.zeros(3)).verdict is Verdict.FAILS
    assert replace(oil_brake, decay_rates=np.array([1.0, 0.25])).verdict_text == "holds with a condition: 4 times slower"
    assert replace(oil_brake, thresholds=(1.0, 1.1)).verdict is Verdict.FAILS
    quiet = replace(clearance, amplitudes={"loaded sleeve": np.array([1e-4, 2e-4, 1e-5])})
    assert quiet.verdict is Verdict.CONDITIONAL
    assert quiet.finding == "loaded sleeve: 1 mm multiplies the motion by 2.0, from 10 mm on it is 0.1 times as large"
    assert replace(band, rest_deviations=np.array([-0.03, 0.01])).verdict is Verdict.FAILS
    assert replace(band, paper_widths=2 * band.paper_widths).verdict is Verdict.CONDITIONAL
    assert replace(rules.force, sleeve_forces=np.array([250.0, 4000.0])).verdict is Verdict.CONDITIONAL
    assert replace(rules.damping, undamped_growth_rate=-0.1).verdict is Verdict.FAILS
    assert replace(rules.damping, settling_times=np.array([math.inf, 20.0, 10.0, 4.0])).verdict is Verdict.CONDITIONAL
    assert replace(rules.dry_friction, limits=np.array([math.inf])).verdict is Verdict.HOLDS
    assert replace(rules.droop, astatic_growth_rates={300.0: 0.1, 3000.0: -1 / 7200}).condition == "decay takes 2 h"
    assert replace(rules.droop, astatic_growth_rates={300.0: -0.1}).verdict is Verdict.FAILS


def test_rules_are_written_as_text_json_and_figure(tmp_path):
    rules = made_up_rules()
    text = str(rules)
    for rule in rules:
        assert f"{rule.title}: {rule.verdict.value.upper()}" in text
    written = json.loads(rules.save_json(tmp_path / "rules.json").read_text())
    assert [one["verdict"] for one in written["rules"]] == [rule.verdict.value for rule in rules]
    assert written["rules"][5]["numbers"]["settling_times"][0] is None
    check_result(rules, tmp_path)


def test_the_study_tells_its_progress(monkeypatch):
    rules = made_up_rules()
    names = {"shaking": "shaking", "oil_brake": "oil_brake", "clearance": "clearance", "dead_band": "dead_band"}
    names |= {"force": "regulating_force", "damping": "dashpot", "dry_friction": "dry_friction", "droop": "droop"}
    for name, function in names.items():
        monkeypatch.setattr(paper_rules, f"check_{function}", Mock(return_value=getattr(rules, name)))
    told = []
    assert study_paper_rules(lambda *done: told.append(done)) == rules
    assert told == [(k, 8) for k in range(9)]
