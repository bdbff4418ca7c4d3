"""Designing the flywheel of the air-expansion engine: the paper's numbers recomputed, both directions, rim and arms, refusals."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.render.figures.designs.engines import draw_flywheel_plate
from governor_mechanism.studies.design.flywheel import FlywheelInputs, compare_with_paper, design_flywheel
from governor_mechanism.studies.design.simulated import simulate_wheels
from reference import flywheel as printed

PAPER = compare_with_paper()


def test_the_papers_terms_are_recomputed_and_the_third_is_marked():
    *terms, total, coefficient = PAPER.terms
    np.testing.assert_allclose([term.recomputed for term in terms], printed.TERMS_AT_PRINTED_ANGLES, atol=2e-12)
    np.testing.assert_allclose(PAPER.exact_terms, printed.TERMS_AT_EXACT_ANGLES, atol=2e-12)
    assert total.recomputed == pytest.approx(printed.SUM_AT_PRINTED_ANGLES, abs=2e-12)
    assert coefficient.recomputed == pytest.approx(printed.COEFFICIENT_AT_PRINTED_ANGLES, rel=1e-11)
    assert PAPER.exact_coefficient == pytest.approx(printed.COEFFICIENT_AT_EXACT_ANGLES, rel=1e-11)
    assert PAPER.wrong_term == terms[2]
    assert (terms[2].printed, round(terms[2].recomputed, 4)) == (-0.2714, -0.2036)
    # The printed terms add up to the printed sum, and give the printed coefficient.
    assert round(sum(term.printed for term in terms), 4) == total.printed == 0.1713
    assert round(2250 * 10 * 0.1713) == coefficient.printed == 3854


def test_a_number_without_a_mark_agrees_in_its_printed_digits():
    assert [number.quantity for number in PAPER.deviations] == [
        "end of the first interval",
        "end of the third interval",
        "expansion (66)",
        "back pressure (66)",
        "air before the pump piston (65)",
        "air left behind it (65)",
        "load (67)",
        "sum of the bracket",
        "coefficient of mu N / n",
    ]
    rounding = {"load constant 2 R / pi": 5.1e-3, "end of the second interval": 0.5, "root of (61)": 0.5, "root of (63)": 0.51}
    for number in (*PAPER.numbers, *PAPER.terms):
        is_close = abs(number.printed - number.recomputed) <= rounding.get(number.quantity, 5e-5)
        assert is_close != bool(number.cause), number


def test_flywheels_by_the_three_brackets_run_as_recomputed():
    as_printed, corrected, right = PAPER.wheels
    closed = printed.CASES["closed by the load"][4]
    for wheel, bracket in ((as_printed, 0.1713), (corrected, printed.SUM_AT_EXACT_ANGLES), (right, closed)):
        half = closed / bracket / (2 * printed.ENERGY_RATIO)  # E / J w^2
        coefficient = math.sqrt(1 + half) - math.sqrt(1 - half)
        assert wheel.coefficient == pytest.approx(coefficient, rel=1e-10)
        assert wheel.excess == pytest.approx(coefficient / printed.EXAMPLE_COEFFICIENT, rel=1e-7)
        assert wheel.inertia == pytest.approx(2 * 20 * 13000 * bracket / printed.MEAN_SPEED**2, rel=1e-10)
    assert [round(wheel.excess, 3) for wheel in PAPER.wheels] == [1.417, 1.022, 1.0]
    assert right.inertia == pytest.approx(printed.EXAMPLE_INERTIA, rel=1e-11)


def test_the_paper_prints_as_tables():
    text = str(PAPER)
    assert "ERROR: r/p was taken as 0.5 instead of 1.5 / 4 = 0.375; this makes the flywheel 28 % too light" in text
    assert "ROUNDING: it is 0.2625 ln 2.07, of the ratio 2.072" in text
    assert "MISPRINT" not in text  # no number of the paper has a wrong digit
    assert "governor-mechanism errata --paper redtenbacher" in text
    assert "times the allowed" in text


def test_the_design_of_the_paper_says_that_its_cycle_does_not_close():
    design = design_flywheel()
    assert design.bracket == pytest.approx(printed.SUM_AT_EXACT_ANGLES, abs=2e-12)
    assert design.net_work / 13000 == pytest.approx(printed.NET_WORK_RATIO, abs=2e-12)
    (warning,) = design.warnings
    assert "in each stroke the shaft loses 0.01019 of A p L; it closes with load_pressure=0.35922546 bar" in warning
    assert design.closing_area_ratio == pytest.approx(printed.CASES["closed by the pump"][1], abs=2e-12)
    assert design.closed_coefficient == pytest.approx(PAPER.wheels[1].coefficient, rel=1e-12)


def test_the_closed_cycle_is_the_example():
    design = gm.design_flywheel(load_pressure="closing")
    assert design.warnings == ()
    assert design.inertia == pytest.approx(printed.EXAMPLE_INERTIA, rel=1e-11)
    assert design.lowest_speed == pytest.approx(printed.EXAMPLE_LOWEST_SPEED, rel=1e-11)
    assert design.highest_speed == pytest.approx(printed.EXAMPLE_HIGHEST_SPEED, rel=1e-11)
    assert design.coefficient == pytest.approx(printed.EXAMPLE_COEFFICIENT, abs=6e-10)
    assert design.closed_coefficient == pytest.approx(design.coefficient, rel=1e-12)
    assert design.power == pytest.approx(printed.EXAMPLE_LOAD_TORQUE * printed.MEAN_SPEED, rel=1e-11)


def test_both_directions_return_to_the_same_wheel():
    wanted = gm.design_flywheel(load_pressure="closing", coefficient=0.02)
    assert wanted.coefficient == pytest.approx(0.02, rel=1e-13)
    given = gm.design_flywheel(load_pressure="closing", inertia=f"{wanted.inertia!r} kg m^2")
    assert given.coefficient == pytest.approx(0.02, rel=1e-12)
    assert (given.lowest_speed, given.highest_speed) == pytest.approx((wanted.lowest_speed, wanted.highest_speed), rel=1e-14)
    by_ratio = gm.design_flywheel(load_pressure="closing", energy_ratio=wanted.energy_ratio)
    assert by_ratio.energy_ratio == pytest.approx(wanted.energy_ratio, rel=1e-12)
    # The two means of the speed differ by c^2 / 8, and the inertia by twice that.
    assert by_ratio.inertia == pytest.approx(wanted.inertia, rel=1.1 * 0.02**2 / 4)


def test_rim_and_arms_of_a_design():
    design = gm.design_flywheel(load_pressure="closing", rim_radius="1.2 m", rim_share=0.9, arms=8)
    wheel = design.wheel
    assert wheel.rim_mass * 1.2**2 == pytest.approx(0.9 * design.inertia, rel=1e-14)
    assert wheel.rim_weight == pytest.approx(9.81 * wheel.rim_mass, rel=1e-15)
    assert wheel.rim_stress == pytest.approx(7200 * (1.2 * printed.MEAN_SPEED) ** 2, rel=1e-14)
    assert wheel.rim_width * wheel.rim_thickness * math.tau * 1.2 * 7200 == pytest.approx(wheel.rim_mass, rel=1e-14)
    assert wheel.arm_moment == pytest.approx(wheel.arm_torque * (1.2 - 0.15) / 1.2 / 8, rel=1e-14)
    assert wheel.arm_depth == 2 * wheel.arm_width


def test_a_rim_that_runs_too_fast_is_a_warning():
    (warning,) = gm.design_flywheel(load_pressure="closing", speed="240 rpm").warnings
    assert "the rim is overstressed: 10.2 MPa, and the limit is 6 MPa, at 28.9 m/s; reduce rim_radius to 1.15 m" in warning


def test_the_flywheels_of_the_paper_run_as_their_formulas_say():
    simulated = simulate_wheels(design_flywheel(), PAPER)
    closed = printed.CASES["closed by the load"][4]
    for wheel, bracket, excess in zip(simulated, (0.1713, printed.SUM_AT_EXACT_ANGLES, closed), (1.417, 1.022, 1.0), strict=True):
        half = closed / bracket / (2 * printed.ENERGY_RATIO)  # work stored over that of the mean speed, J w^2 / 2
        # The extreme speeds have errors of 1e-8 of a speed of 6 rad/s.
        assert wheel.lowest == pytest.approx(printed.MEAN_SPEED * math.sqrt(1 - half), abs=1e-7)
        assert wheel.highest == pytest.approx(printed.MEAN_SPEED * math.sqrt(1 + half), abs=1e-7)
        assert wheel.excess == pytest.approx(excess, abs=5e-4)  # digits of the statement
        assert wheel.crank_angles[-1] == pytest.approx(4 * math.pi, abs=0.05)  # the mean over time is not that of the energies


@pytest.mark.parametrize("requirement", [{"coefficient": 0.02}, {"energy_ratio": 12.0}, {"inertia": 2000.0}])
def test_a_designed_flywheel_keeps_its_promise(requirement):
    design = design_flywheel(FlywheelInputs(load_pressure=None, **requirement))
    (wheel,) = simulate_wheels(design)
    assert wheel.lowest == pytest.approx(design.lowest_speed, abs=1e-7)
    assert wheel.highest == pytest.approx(design.highest_speed, abs=1e-7)
    assert wheel.excess == pytest.approx(1.0, abs=1e-5)
    assert design.scene_document["dimensions"]["inertia"] == design.inertia


def test_a_design_is_plain_json():
    document = json.loads(json.dumps({**design_flywheel().as_json(), "paper": PAPER.as_json()}, allow_nan=False))
    assert document["engine"]["area"] == 0.05
    assert document["paper"]["exact_sum"] == pytest.approx(printed.SUM_AT_EXACT_ANGLES, abs=2e-12)
    assert "back pressure (66)" in document["paper"]["deviations"]


@pytest.mark.long
def test_the_plate_is_drawn_of_the_paper_and_of_other_engines(tmp_path: Path):
    paper = draw_flywheel_plate(design_flywheel(), simulate_wheels(design_flywheel(), PAPER), PAPER)
    texts = {text.get_text() for axes in paper.axes for text in axes.texts}
    assert {"−0.2714", "−0.203585", "0.1713", "0.237422", "3854", "5342"} <= texts
    assert "$\\alpha$ = 2.675°" in texts
    assert "$\\beta$ = 95.45°" in texts
    other = FlywheelInputs(load_pressure=None, cut_off=0.9, pump_clearance=0.01, pump_stroke=0.4, inertia=2000.0)
    other_plate = draw_flywheel_plate(design_flywheel(other), simulate_wheels(design_flywheel(other)))
    for name, plate in (("paper", paper), ("other", other_plate)):
        assert plate.save(tmp_path / f"{name}.png").read_bytes()[:4] == b"\x89PNG"
