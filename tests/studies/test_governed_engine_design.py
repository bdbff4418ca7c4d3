"""Designing an engine under its governor: speeds and droop by independent formulas, eigenvalues, simulation, refusals, command line."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import json_of
from governor_mechanism.closed_form.governed_engine import pendulum_coefficients
from governor_mechanism.scenes.changed_document import replace_document_value
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.design.governed_engine import change_times

DESIGN = gm.design_governed_engine()

VARIANTS = {
    "default": {},
    "crossed arms": {"offset": "-20 mm"},
    "given travel and gear": {"droop": "3%", "sleeve_travel": "40 mm", "gear_ratio": 2, "ball_mass": "4 kg"},
    "slow and heavy": {"power": "100 kW", "speed": "60 rpm", "droop": 0.06, "mass_ratio": 8, "torque_reserve": 0.2},
}


def spindle_speed(governor, arm_angle):
    """Return Zehnder's (3), w^2 = g (1 + Q / P) tan a / (e + l sin a), written out here."""
    radius = governor.offset + governor.arm * math.sin(arm_angle)
    return math.sqrt(9.81 * (1 + governor.sleeve_mass / governor.ball_mass) * math.tan(arm_angle) / radius)


@pytest.mark.parametrize("inputs", VARIANTS.values(), ids=VARIANTS)
def test_the_equilibrium_speeds_are_the_wanted_ones(inputs):
    design = gm.design_governed_engine(**inputs)
    wanted, found = design.inputs, design.governor
    full, none = (spindle_speed(found.governor, angle) / found.gear_ratio for angle in (found.full_load_angle, found.no_load_angle))
    # The offset or the angle is found to rounding, and a droop of some per cent is a difference of the speeds.
    assert (none + full) / 2 == pytest.approx(wanted.speed, rel=1e-12)
    assert (none - full) / wanted.speed == pytest.approx(wanted.droop, rel=1e-10)
    assert design.rated_torque * full == pytest.approx(wanted.power, rel=1e-12)
    lifts = [2 * found.governor.arm * (1 - math.cos(angle)) for angle in (found.full_load_angle, found.no_load_angle)]
    assert (found.full_load_lift, found.no_load_lift) == pytest.approx(lifts, rel=1e-12)
    weight = 9.81 * (found.governor.ball_mass + found.governor.sleeve_mass)
    assert found.insensitivity == pytest.approx(wanted.resistance / weight, rel=1e-14)


def test_offset_and_travel_mass_ratio_and_gear_ratio_give_each_other():
    governor = DESIGN.governor
    other = gm.design_governed_engine(sleeve_travel=governor.sleeve_travel, gear_ratio=governor.gear_ratio).governor
    assert other.governor.offset == pytest.approx(governor.governor.offset, rel=1e-10)
    assert other.mass_ratio == pytest.approx(governor.mass_ratio, rel=1e-12)
    assert gm.design_governed_engine(ball_mass=governor.governor.ball_mass).governor.insensitivity == pytest.approx(0.01, rel=1e-13)


def test_the_cylinders_give_the_torque_and_its_reserve():
    # Work of a stroke over A L p_atm of the paper's engine, 0.359225459234: reference.flywheel.CASES["closed by the load"].
    engine = DESIGN.engine
    open_torque = 0.359225459234e5 * engine.area * engine.stroke / math.pi
    assert open_torque == pytest.approx(1.1 * DESIGN.rated_torque, rel=1e-11)
    assert engine.area == pytest.approx(math.pi * DESIGN.bore**2 / 4, rel=1e-14)
    assert engine.stroke == pytest.approx(2 * DESIGN.bore, rel=1e-14)


@pytest.mark.parametrize("fraction", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("inputs", [{}, VARIANTS["slow and heavy"]], ids=["default", "slow and heavy"])
def test_the_scene_has_the_speeds_and_the_eigenvalues_of_the_design(inputs, fraction):
    design = gm.design_governed_engine(**inputs)
    document = replace_document_value(design.fill_scene(design.scene_values(mean_torque=True)), "load.fraction", fraction)
    linear = gm.linearise(parse_scene_document(document))
    setting = next(one for one in design.throttle if one.load_fraction == fraction)
    # The scene file has fifteen digits; the linearisation states errors of 1e-11.
    assert linear.rates["engine.crank_angle"] == pytest.approx(setting.speed, rel=1e-9)
    wanted = design.inputs.speed * (1 + {1.0: -0.5, 0.0: 0.5}.get(fraction, math.nan) * design.inputs.droop)
    assert fraction == 0.5 or linear.rates["engine.crank_angle"] == pytest.approx(wanted, rel=1e-10)  # the droop to 1e-8
    motion = next(one for one in design.dashpot.motions if one.load_fraction == fraction)
    # Two nearly equal roots are known to the root of what the coefficients are known to.
    polynomial = np.poly(linear.eigenvalues).real
    coefficients = motion.coefficients
    np.testing.assert_allclose(polynomial[1:], [coefficients.a, coefficients.b, coefficients.c], rtol=1e-9)
    np.testing.assert_allclose(np.sort_complex(linear.eigenvalues), np.sort_complex(motion.roots), rtol=1e-7)


def test_the_dashpot_is_the_best_one_and_its_limit_is_where_two_roots_are_imaginary():
    governor, dashpot = DESIGN.governor, DESIGN.dashpot
    shaft = {"flywheel_inertia": DESIGN.flywheel.inertia, "torque_slope": DESIGN.torque_slope, "gear_ratio": governor.gear_ratio}

    def roots(fraction: float, damping: float) -> list[complex]:
        found = pendulum_coefficients(governor.governor, arm_angle=governor.arm_angle(fraction), sleeve_damping=damping, **shaft)
        return np.roots([1.0, found.a, found.b, found.c]).tolist()

    def decay_rate(damping: float) -> float:
        return -max(root.real for fraction in (1.0, 0.5, 0.0) for root in roots(fraction, damping))

    assert dashpot.decay_rate == pytest.approx(decay_rate(dashpot.damping), rel=1e-12)
    assert all(decay_rate(factor * dashpot.damping) < dashpot.decay_rate for factor in (0.3, 0.9, 0.99, 1.01, 1.1, 3.0))
    assert decay_rate(dashpot.smallest_stable_damping) == pytest.approx(0.0, abs=1e-12)


def test_the_rules_are_checked():
    # A quarter of the droop is less than the speed fluctuation: both rules about the insensitivity need a droop well above it.
    assert [check.ok for check in DESIGN.checks] == [True, False, True, True, True]
    assert gm.design_governed_engine(speed_fluctuation="0.9%").warnings == ()
    stiff = gm.design_governed_engine(resistance="100 N", ball_mass="5 kg")
    assert [check.ok for check in stiff.checks] == [False, True, False, True, True]
    assert "reduce resistance, or increase ball_mass" in stiff.warnings[0]
    (*_, unstable) = gm.design_governed_engine(dashpot=0.9 * DESIGN.dashpot.smallest_stable_damping).checks
    assert not unstable.ok
    low, high = gm.design_governed_engine(insensitivity="3%").governor.speed_limits
    full, none = DESIGN.governor.full_load_speed, DESIGN.governor.no_load_speed
    assert (low, high) == pytest.approx((full * (1 - 0.0025), none * (1 + 0.0025)), rel=1e-14)  # Zehnder's (VII) and (VIII)


def test_the_limits_of_the_droop_are_those_of_the_geometry():
    inner, outer = math.radians(30), math.acos(math.cos(math.radians(30)) - 0.04 / 0.6)
    lowest = math.acos(math.cos(inner) + 0.1 * 0.04 / 0.6)  # with an open throttle
    for offset, limit in ((-0.3 * math.sin(lowest) ** 3, 0.015211), (0.3, 0.099306)):
        ratio = math.sqrt(math.tan(outer) / math.tan(inner) * (offset + 0.3 * math.sin(inner)) / (offset + 0.3 * math.sin(outer)))
        assert 2 * (ratio - 1) / (ratio + 1) == pytest.approx(limit, abs=5e-7)  # the digits of the message


def test_a_slow_design_is_not_simulated_for_ever():
    # Decay times of 8 and 10 times 40 s, and 300 turns of half a second.
    slow = replace(DESIGN, dashpot=replace(DESIGN.dashpot, motions=(gm.design_governed_engine(droop="50%").dashpot.motions[2],)))
    begin, duration = change_times(slow)
    assert duration <= 2 * (300 * math.tau / DESIGN.governor.full_load_speed + 0.1)
    assert begin <= duration


@pytest.mark.long
def test_the_command_designs_and_simulates(tmp_path: Path):
    words = ("--power", "20 PS", "--speed=120rpm", "--droop", "4%")
    simulated = json_of("design", "governed-engine", *words, "--out", tmp_path)["simulated"]
    assert simulated["static_droop"] == pytest.approx(0.04, abs=1e-8)
    # The flywheel is sized without the inertia of the governor, 2e-4 of its own, and with a throttle that stands still, which it does not
    # quite: the sleeve follows the speed in every turn by some tenths of a millimetre, which changes the torque by some thousandths.
    assert simulated["fluctuation"] == pytest.approx(1 / 40, rel=4e-3)
    for name, tolerance in (("mean_torque", 1e-4), ("cyclic", 2e-3)):  # settled to exp(-16), and the square of the fluctuation
        change = DESIGN.throttle[2].speed / DESIGN.throttle[0].speed - 1
        assert simulated[name]["droop"] == pytest.approx(change, rel=tolerance)
        assert simulated[name]["overshoot"] < 0.01
    # Friction holds the sleeve until the speed has changed; it settles, within the band of insensitivity.
    assert simulated["resisted"]["verdict"] == "settles"
    assert 0.01 < simulated["resisted"]["overshoot"] < 0.5
    assert simulated["resisted"]["droop"] == pytest.approx(change, abs=DESIGN.governor.insensitivity / 2)
    scene = gm.load(tmp_path / "governed_engine_design.toml")
    assert [part.name for part in scene.parts] == ["engine", "governor"]
    assert scene.parts[1].dimensions["ball_mass"] == pytest.approx(DESIGN.governor.governor.ball_mass, rel=1e-14)
    assert (tmp_path / "governed_engine_design.png").is_file()


def test_options_of_inputs_are_those_of_with(tmp_path: Path):
    common = ("design", "hartung", "--no-figure", "--out", tmp_path)
    by_option = json_of(*common, "--wire", "10 mm", "--weight-mass=50 kg")
    assert by_option["design"] == json_of(*common, "--with", "wire=10 mm", "--with", "weight_mass=50 kg")["design"]
