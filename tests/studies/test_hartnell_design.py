"""The design of a Hartnell governor: laws of its springs, the command with its files, and refusals. Printed examples: the textbook list."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import json_of
from governor_mechanism.scenes.parser import read_scene_file
from governor_mechanism.studies.design.simulated import simulate_hartnell

DESIGN = gm.design_hartnell()
OBLIQUE = {"sleeve_mass": "3 kg", "bell_crank_angle": "100 deg", "pivot_radius": "130 mm", "highest_speed": "295 rpm"}


@pytest.mark.parametrize("inputs", [{}, OBLIQUE, {"lift": None, "outer_radius": "150 mm"}], ids=["default", "oblique", "outer radius"])
def test_the_simulated_governor_has_the_wanted_speeds_at_both_ends_of_the_lift(inputs):
    design = gm.design_hartnell(**{name: value for name, value in inputs.items() if value is not None})
    simulated = simulate_hartnell(design)
    assert simulated.ok, str(simulated)
    ends = gm.controlling_force(design.scene, points=5).working_range
    np.testing.assert_allclose(ends.speed, [design.inputs.lowest_speed, design.inputs.highest_speed], rtol=1e-9)  # 15 digits in the scene
    assert ends.lift == pytest.approx(design.travel.lift, rel=1e-9)
    assert ends.stable


def test_the_textbook_spring_makes_the_governor_too_slow_at_the_top():
    """The weight of the balls drives them outward by m g a tan(beta); the speed falls by that over m w^2 r a."""
    angle, radius = DESIGN.travel.arm_angles[1], DESIGN.travel.radii[1]
    share = 9.81 * math.tan(angle) / (DESIGN.inputs.highest_speed**2 * radius)
    low, high = DESIGN.textbook.speeds
    assert low == pytest.approx(DESIGN.inputs.lowest_speed, rel=1e-12)  # the balls are upright there
    assert high == pytest.approx(DESIGN.inputs.highest_speed * math.sqrt(1 - share), rel=1e-12)
    assert DESIGN.exact.rate > DESIGN.textbook.rate


def test_effort_and_power_are_those_of_the_mean_load():
    """The load is proportional to the square of the speed: 1 % more gives (1.01^2 - 1) / 2 of it, with the weight of the balls."""
    governor, angle = DESIGN.governor, DESIGN.travel.middle_angle
    load = 0.5 * sum(DESIGN.exact.forces) - 2 * 2.5 * 9.81 * math.tan(angle) * governor.ball_arm / governor.sleeve_arm
    assert DESIGN.effort == pytest.approx((1.01**2 - 1) / 2 * load, rel=1e-11)
    assert DESIGN.textbook_effort == pytest.approx(0.01 * 0.5 * sum(DESIGN.textbook.forces), rel=1e-12)
    assert DESIGN.power == DESIGN.effort * DESIGN.travel.lift


def test_the_balls_carry_the_same_load_whether_the_sleeve_weighs_or_the_spring_presses():
    heavy = gm.design_hartnell(sleeve_mass="3 kg")
    load_rows = [[row for row in one.spring_table.splitlines() if row.startswith("load of the sleeve")] for one in (DESIGN, heavy)]
    assert len(load_rows[0]) == 2
    assert load_rows[0] == load_rows[1]
    assert np.subtract(DESIGN.exact.forces, heavy.exact.forces) == pytest.approx(3 * 9.81, rel=1e-10)


def test_lift_and_outer_radius_describe_one_travel():
    other = gm.design_hartnell(outer_radius=DESIGN.travel.radii[1])
    assert other.travel.lift == pytest.approx(DESIGN.travel.lift, rel=1e-12)
    assert other.exact.rate == pytest.approx(DESIGN.exact.rate, rel=1e-11)


def test_a_textbook_spring_that_makes_it_unstable_is_warned_of():
    design = gm.design_hartnell(highest_speed="290.5 rpm")
    assert design.textbook.speeds[1] < design.textbook.speeds[0]
    (warning,) = design.warnings
    assert "unstable" in warning
    assert warning in str(design)
    assert simulate_hartnell(design).ok


def test_the_spring_ratio_of_the_refusal_is_where_its_rate_vanishes():
    """S2 / S1 = (w2 / w1)^2 r2 / r1 by the textbooks, which is 1 at a ratio of sqrt(r1 / r2)."""
    assert math.sqrt(DESIGN.travel.radii[0] / DESIGN.travel.radii[1]) == pytest.approx(0.917663, abs=5e-7)


def test_the_command_writes_a_scene_that_runs_and_a_figure(tmp_path):
    values = json_of("design", "hartnell", "--ball-mass", "3 kg", "--with", "lift=10 mm", "--out", tmp_path)
    assert values["machine"] == "hartnell"
    assert values["design"]["inputs"]["ball_mass"] == 3.0
    assert values["simulated"]["ok"]
    assert (tmp_path / "hartnell_design.png").stat().st_size > 10_000
    run = gm.run(read_scene_file(tmp_path / "hartnell_design.toml"))
    assert run.outcome.ok
    assert 0.9 < run.readings["sleeve_lift"][-1] / 0.010 < 1.0  # 2 % of the range of speed below the top
    assert run.readings["sleeve_lift"][0] / 0.010 < 0.1
