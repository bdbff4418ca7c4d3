"""Designing a pendulum governor by Zehnder's procedure: the worked example, his laws, the simulated machine, refusals, command line."""

import math
from pathlib import Path

import pytest

import governor_mechanism as gm
from command_line import json_of, succeed
from governor_mechanism.closed_form import pendulum
from governor_mechanism.studies.design.simulated import simulate_pendulum
from reference import zehnder

DESIGN = gm.design_pendulum()

VARIANTS = {
    "porter": {},
    "shortened": {"arm": "300 mm"},
    "watt": {"kind": "watt"},
    "improved watt on extended arms": {"kind": "improved-watt", "joint_ratio": 0.6},
    "given start": {"start_radius": "20 cm", "offset": "30 mm", "mass_ratio": 6, "resistance": "20 N", "gravity": 9.80665},
}


def step_values(design):
    return {step.quantity.split(",")[0]: step.value for step in design.steps}


def test_the_worked_example_of_the_procedure():
    """The paper prints none: `reference.zehnder` has it for 120 and 126 rpm, m = 4; with delta = 4 %, W = 6 kgf the weights are round."""
    start, reference = DESIGN.start, zehnder.DESIGN
    found = (start.double_parameter, start.abscissa, start.ordinate, math.tan(start.arm_angle), start.radius_of_curvature)
    names = ("double_parameter", "start_abscissa", "start_height", "start_tangent", "radius_of_curvature")
    # Twelve digits of the reference.
    assert found == pytest.approx([reference[name] for name in names], rel=1e-11)
    assert step_values(DESIGN)["weight of a ball"] == pytest.approx(30.0, rel=1e-14)
    assert step_values(DESIGN)["weight of the sleeve"] == pytest.approx(120.0, rel=1e-14)
    limits = DESIGN.checks[0].lowest, DESIGN.checks[0].highest
    assert limits == pytest.approx(reference["mass_ratio_limits"], rel=1e-6)
    trials = {round(math.degrees(trial.angle_change)): trial.speed for trial in DESIGN.trials}
    assert [trials[change] for change, _ in reference["trial_speeds"]] == pytest.approx(
        [speed for _, speed in reference["trial_speeds"]],
        abs=1e-7,  # nine digits
    )
    # (VII) and (VIII) with epsilon = 2.5 %: 0.75 % to each side.
    assert [speed * 30 / math.pi for speed in DESIGN.speed_limits] == pytest.approx([119.1, 126.945], rel=1e-13)


@pytest.mark.parametrize("inputs", VARIANTS.values(), ids=VARIANTS)
def test_the_rule_of_the_start_radius_compares_with_arms_at_45_deg(inputs):
    """The tangent of the parabola has the slope 2 y / x, which is that of the arm."""
    design = gm.design_pendulum(**inputs)
    (rule,) = (one for one in design.checks if "45 deg" in one.rule)
    assert rule.found == pytest.approx(math.tan(design.start.arm_angle), rel=1e-12)
    assert rule.ok == (design.start.arm_angle <= math.pi / 4)


@pytest.mark.parametrize("row", zehnder.DESIGN["upper_positions"], ids=["radius of curvature", "shortened", "on the axis"])
def test_shorter_arms_keep_the_start_and_swing_less(row):
    arm, offset, angle, radius, lift = row
    design = gm.design_pendulum(**({"offset": 0} if offset == 0 else {} if arm == "radius of curvature" else {"arm": arm}))
    assert design.governor.offset == pytest.approx(offset, rel=1e-10)  # a difference of lengths, which loses a digit
    found = (math.degrees(design.arm_angles[1]), design.ball_radii[1], design.sleeve_lift)
    assert found == pytest.approx((angle, radius, lift), rel=1e-10)  # an angle to twelve digits, and cosines that differ little
    assert design.arm_angles[0] == DESIGN.arm_angles[0]


@pytest.mark.parametrize("inputs", VARIANTS.values(), ids=VARIANTS)
def test_both_positions_hold_at_their_speeds_and_the_masses_give_the_insensitivity(inputs):
    design = gm.design_pendulum(**inputs)
    governor, wanted = design.governor, design.requirement
    weight_at_joint = governor.ball_mass / design.inputs.joint_ratio
    ratio = governor.sleeve_mass / weight_at_joint
    assert ratio == pytest.approx(wanted.mass_ratio, abs=1e-15)
    for angle, speed in zip(design.arm_angles, (wanted.lowest_speed, wanted.highest_speed), strict=True):
        # Zehnder's (3), written out; the arm and its offset are differences of lengths of the same size.
        radius = governor.offset + governor.arm * math.sin(angle)
        assert math.sqrt(governor.gravity * (1 + ratio) * math.tan(angle) / radius) == pytest.approx(speed, rel=1e-12)
    held_by = design.inputs.insensitivity * governor.gravity * (weight_at_joint + governor.sleeve_mass)
    assert held_by == pytest.approx(wanted.resistance, rel=1e-14)
    assert design.trials[-1].speed == pytest.approx(wanted.highest_speed, rel=1e-12)


@pytest.mark.parametrize("inputs", VARIANTS.values(), ids=VARIANTS)
def test_the_simulated_machine_does_what_the_design_wants(inputs):
    design = gm.design_pendulum(**inputs)
    simulated = simulate_pendulum(design)
    assert simulated.ok, str(simulated)
    assert len(simulated.numbers) == 12
    assert simulated.run.scene.title == design.scene.title


def test_an_osculating_path_is_neutral_at_its_start_and_a_longer_arm_snaps():
    governor = DESIGN.governor
    assert -governor.offset == pytest.approx(DESIGN.ball_radii[0] * math.tan(DESIGN.arm_angles[0]) ** 2, rel=1e-12)
    longer = gm.design_pendulum(arm=1.1 * DESIGN.start.radius_of_curvature)
    assert not all(check.ok for check in longer.checks)
    assert "unstable in the lowest position" in longer.warnings[0]
    curve = gm.speed_curve(longer.scene)
    (fold_angle, fold_speed), *_ = curve.folds
    # sin^3 a = -e / l; the fold is located on the curve to about 1e-10.
    assert fold_angle == pytest.approx(math.asin(math.cbrt(-longer.governor.offset / longer.governor.arm)), rel=1e-8)
    assert fold_speed < longer.requirement.lowest_speed


@pytest.mark.parametrize("ratio", [1.02, 1.3, 2.5])
@pytest.mark.parametrize("highest", ["120.001 rpm", "126 rpm"])
def test_too_long_an_arm_is_still_stable_half_way_up(ratio, highest):
    design = gm.design_pendulum(arm=ratio * DESIGN.start.radius_of_curvature, highest_speed=highest)
    assert pendulum.stiffness(design.governor, arm_angle=design.middle_angle) > 0


def test_extended_arms_change_ball_and_lift_alone():
    extended = gm.design_pendulum(joint_ratio=0.6)
    assert extended.arm_angles == pytest.approx(DESIGN.arm_angles, rel=1e-14)
    assert extended.governor.ball_mass == pytest.approx(0.6 * DESIGN.governor.ball_mass, rel=1e-14)  # (Ia)
    assert extended.governor.sleeve_mass == DESIGN.governor.sleeve_mass
    assert extended.sleeve_lift == pytest.approx(0.6 * DESIGN.sleeve_lift, rel=1e-13)


@pytest.mark.parametrize("rpm", [60.0, 120.0, 300.0])
@pytest.mark.parametrize(("constant", "start", "angle"), [(15, 26.0385245065, 21.709607), (80, 10.7080245517, 41.128547)])
def test_at_the_limits_of_m_the_start_does_not_depend_on_the_speed(rpm, constant, start, angle):
    ratio = (rpm * math.pi / 30) ** 2 / constant - 1
    if ratio <= 0:
        pytest.skip("no load on the sleeve")
    design = gm.design_pendulum(lowest_speed=f"{rpm} rpm", highest_speed=f"{1.03 * rpm} rpm", mass_ratio=ratio)
    assert 100 * design.start.abscissa == pytest.approx(start, rel=1e-11)
    assert math.degrees(design.start.arm_angle) == pytest.approx(angle, abs=5e-7)  # as many digits as the reference has


def test_rules_that_are_not_kept_are_told():
    design = gm.design_pendulum(mass_ratio=12, insensitivity=0.02)
    assert [check.ok for check in design.checks] == [False, False, True, True]
    # Where the machine overcomes the resistance in every turn, it does not widen the range of speed.
    assert design.speed_limits == (design.requirement.lowest_speed, design.requirement.highest_speed)
    assert "do not cross" in gm.design_pendulum(kind="watt", offset="-10 mm").warnings[-1]
    assert "with crossed arms" in gm.design_pendulum(kind="improved-watt", offset="-10 mm").warnings[-1]


@pytest.mark.long
def test_the_command_writes_scene_and_plates(tmp_path: Path):
    told = json_of("design", "pendulum", "--out", tmp_path)
    names = ["pendulum_design.toml", "pendulum_design.png", "pendulum_design_parabolas.png"]
    assert [Path(name).name for name in told["files"]] == names
    assert all((tmp_path / name).stat().st_size for name in names)
    assert told["simulated"]["ok"]
    assert gm.load(tmp_path / "pendulum_design.toml").part.dimensions["arm"] == pytest.approx(DESIGN.governor.arm, rel=1e-14)
    text = succeed("design", "pendulum", "--kind", "watt", "--offset", "10 mm", "--no-figure", "--out", tmp_path).stdout
    assert "governor: watt, arms of 275 mm at 10 mm from the axis" in text
    assert "kept: (V) arm l over the radius of curvature" in text
