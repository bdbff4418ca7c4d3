"""The errata of the papers: every printed and every right number against an independent one, commands, figures, and the page."""

import importlib.util
import json
import math
import re
import shlex
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import json_of
from documentation_pages import ROOT, check_options
from governor_mechanism.cli.studies import PaperChoice
from governor_mechanism.errors import MechanismError
from governor_mechanism.papers.errata_drawings import DRAWINGS, draw_erratum
from governor_mechanism.papers.errata_results import SIMULATIONS, simulated_speeds
from governor_mechanism.papers.erratum import CAUSE_MEANINGS, CAUSE_NOUNS, PAPER_REFERENCES, Paper, make_number_erratum
from governor_mechanism.studies.design.pendulum import design_pendulum
from governor_mechanism.studies.design.skeleton import Cause, PrintedNumber
from reference import flywheel, hartung, marks, zehnder
from refusing import refuses

PAGE_FOLDER = ROOT / "docs" / "errata"
LARGEST_PICTURE = 200_000
"""Bytes of a picture of the page."""

SHIFTS = {row[0]: row[4] for row in marks.VALVE_EVENTS[4]}
"""Delay of the valve events by the finite eccentric rod, deg."""

# Printed, as in the paper, and right, recomputed apart from this package; tests/support/reference/ states how. Without a
# printed number a statement is wrong.
NUMBERS = {
    "redtenbacher": {
        "back-pressure": ("-0.2714", flywheel.TERMS_AT_PRINTED_ANGLES[2]),
        "bracket": ("0.1713", flywheel.SUM_AT_PRINTED_ANGLES),
        "flywheel": ("3854", flywheel.COEFFICIENT_AT_PRINTED_ANGLES),
        "third-limit": ("125.5", flywheel.INTERVAL_LIMITS_DEG[2]),
        "first-limit": ("45", flywheel.INTERVAL_LIMITS_DEG[0]),
        "first-term": ("0.1430", flywheel.TERMS_AT_PRINTED_ANGLES[0]),
        "fourth-term": ("-0.1910", flywheel.TERMS_AT_PRINTED_ANGLES[3]),
        "fifth-term": ("0.0693", flywheel.TERMS_AT_PRINTED_ANGLES[4]),
        "seventh-term": ("-0.0513", flywheel.TERMS_AT_PRINTED_ANGLES[6]),
    },
    "zehnder": {  # 2 deg beside the point of osculation, in percent
        "osculating-circle": ("", 100 * dict((row[0], row[1]) for row in zehnder.OSCULATION)[-2]),
        "longer-arm": ("", 100 * dict((row[0], row[2]) for row in zehnder.OSCULATION)[2]),
        "shorter-arm": ("", 100 * dict((row[0], row[3]) for row in zehnder.OSCULATION)[-2]),
    },
    "marks": {
        "cylinder-ends": ("", SHIFTS["crank end compression"]),
        "lost-square": ("", 60**2 * 0.75 / (2 * 240)),  # r^2 cos^2(30 deg) / 2 l in mm
    },
    "dubois": {
        "bell-crank-angle": ("133", hartung.ANGLE_DEG),
        "rest-radius": ("95", 92.0),
        "inner-radius": ("192", 1e3 * hartung.RADII[0]),
        "squared-speed": ("492.2", hartung.OMEGA_SQUARED[1]),
        "table-2": ("199.8", hartung.TABLE_2[0][5]),
        "outer-regulating-force": ("26.2", hartung.REGULATING_FORCE_KGF[1]),
        "mass": ("4.58", hartung.MASS_KGF),
        "wire-length": ("332", 6 * 0.2036 * 750_000 / (172 * 16)),  # the line that the paper prints
        "section-modulus": ("0.338", hartung.SPRING["section_modulus_cm3"]),
        "inner-force": ("460", hartung.STATIC_FORCE_KGF[0]),
        "outer-force": ("503", hartung.STATIC_FORCE_KGF[1]),
        "change": ("10", 200 * hartung.REGULATING_SPREAD_KGF / sum(hartung.REGULATING_FORCE_KGF)),
        "counter-example": ("7.5", hartung.POHLHAUSEN["regulating"][0]),
    },
}

REFERENCE_TOLERANCE = 1e-10
"""Relative: the references have 11 and 12 digits."""

# How each rounded number comes about: what is cut off, or the last of the paper's rounded steps.
ROUNDED_STEPS = {
    ("redtenbacher", "first-limit"): math.floor(flywheel.INTERVAL_LIMITS_DEG[0]),
    ("redtenbacher", "third-limit"): 180 - math.floor(2 * (180 - flywheel.INTERVAL_LIMITS_DEG[2])) / 2,
    ("redtenbacher", "first-term"): 0.425 * math.log(1.4),
    ("redtenbacher", "fourth-term"): -0.2625 * math.log(2.07),
    ("redtenbacher", "seventh-term"): -0.1 * (1.66 - 0.05) / 3.14,
    ("dubois", "mass"): math.floor(100 * 45 / 9.81) / 100,
    ("dubois", "wire-length"): math.floor(6 * 0.2036 * 750_000 / (172 * 16)),
    ("dubois", "inner-force"): 2 * 185.8 * 0.677 * 1.77 + 15,
    ("dubois", "outer-force"): 2 * 333.8 * 0.677 * 1.08 + 15,
    ("dubois", "change"): 100 * 2 / 20,
    ("dubois", "counter-example"): math.floor(10 * 0.04 * 189) / 10,
}


@cache
def all_errata():
    return gm.errata()


@cache
def simulated_errata():
    return {(one.paper.value, one.name): one.simulated for one in gm.errata(simulate=True)}


def one_of(paper: str, name: str):
    return next(one for one in all_errata() if (one.paper, one.name) == (paper, name))


def test_every_number_of_the_errata_has_an_independent_one():
    found = {(one.paper.value, one.name) for one in all_errata() if one.right_value is not None}
    assert found == {(paper, name) for paper, names in NUMBERS.items() for name in names}
    assert len({(one.paper, one.name) for one in all_errata()}) == len(all_errata())


@pytest.mark.parametrize(("paper", "name"), [(paper, name) for paper, names in NUMBERS.items() for name in names])
def test_printed_and_right_numbers_are_those_of_the_paper_and_of_the_reference(paper, name):
    erratum, (printed, right) = one_of(paper, name), NUMBERS[paper][name]
    assert erratum.right_value == pytest.approx(right, rel=REFERENCE_TOLERANCE)
    if not printed:
        assert erratum.printed_value is None
        return
    assert erratum.printed == f"{printed} {erratum.unit}".strip()
    assert erratum.printed_value == float(printed)
    # Within half of its last digit a printed number would be right.
    assert abs(erratum.printed_value - right) > 0.5 * 10.0 ** -len(printed.partition(".")[2])
    # The recomputed number has two digits more than the printed one; before it, in brackets then, may be the number that the paper means.
    meant, _, recomputed = re.fullmatch(r"(\S+)[^(]*(\((.*)\))?", erratum.right).groups()
    # The forces of the table are the work of a slide rule; else the number that is meant is the right one rounded.
    rounding = hartung.SLIDE_RULE_TOLERANCE if name == "table-2" else 0.5 * 10.0**-erratum.printed_digits
    assert abs(float(meant) - right) <= rounding
    assert float(recomputed or meant) == pytest.approx(right, abs=0.5 * 10.0 ** -(erratum.printed_digits + 2) * (1 + 1e-6))


def test_an_erratum_says_where_why_and_how_to_see_it():
    for erratum in all_errata():
        assert erratum.place
        assert erratum.printed != erratum.right
        assert erratum.proof.endswith(".")
        assert bool(erratum.quotation) == bool(erratum.translation)
        assert bool(erratum.consequence) or erratum.cause not in {Cause.ERROR, Cause.CONSEQUENCE}
        assert erratum.printed_value is not None or erratum.cause is not Cause.ROUNDING
        program, *arguments = shlex.split(erratum.command)
        assert program == "governor-mechanism"
        check_options(arguments)


def test_a_misprinted_number_shows_what_the_paper_means_and_what_is_right():
    assert one_of("dubois", "table-2").right == "189.8 kgf (189.612)"
    assert one_of("dubois", "rest-radius").right == "92 mm"  # 15 + 77, exactly
    assert one_of("redtenbacher", "third-limit").right == "125.100 deg"


def test_a_rounded_number_follows_from_its_steps_and_no_other_does():
    assert {(one.paper.value, one.name) for one in all_errata() if one.cause is Cause.ROUNDING} == set(ROUNDED_STEPS)
    for (paper, name), value in ROUNDED_STEPS.items():
        erratum = one_of(paper, name)
        assert round(value, erratum.printed_digits) == erratum.printed_value


def test_what_a_typeface_an_index_or_an_exponent_may_explain_is_undecided():
    undecided = {(one.paper.value, one.name) for one in all_errata() if one.cause is Cause.UNDECIDED}
    names = {
        "redtenbacher": ["balance-area", "fifth-term-ratio", "first-term-brackets"],
        "zehnder": ["difference-of-angles", "stray-index", "best-abscissa", "radius-squared"],
        "marks": ["symbol"],
        "dubois": ["unit-of-squared-speed", "polar-moment", "wire-length-units", "section-modulus-power"],
    }
    assert undecided == {(paper, name) for paper in names for name in names[paper]}


def test_every_paper_has_one_error_and_what_follows_is_no_second_one():
    assert [(one.paper, one.name) for one in all_errata() if one.cause is Cause.ERROR] == [
        (Paper.REDTENBACHER, "back-pressure"),
        (Paper.ZEHNDER, "osculating-circle"),
        (Paper.MARKS, "cylinder-ends"),
        (Paper.DUBOIS, "bell-crank-angle"),
    ]
    assert [one.name for one in all_errata() if one.cause is Cause.CONSEQUENCE] == ["bracket", "flywheel", "longer-arm", "shorter-arm"]
    # The lost square and the statement on the signs are one slip.
    slips = [one for one in all_errata().select("marks") if "z'" in one.subject]
    assert [one.cause for one in slips] == [Cause.SLIP]


def test_duboiss_arm_is_right_for_the_middle_between_the_end_positions():
    inner, middle, outer = hartung.HANGER_OFFSETS_MM
    off = abs(inner + outer) / 2
    assert round(off, 2) == 0.03
    page = " ".join((PAGE_FOLDER / "index.md").read_text(encoding="utf-8").split())
    assert f"positions, {inner:.2f} mm before and {-outer:.2f} mm beyond the axis, is {off:.2f} mm from it" in page
    assert f"the end is {-middle:.2f} mm beyond the axis" in page
    assert not [one.name for one in all_errata() if "arm b" in one.subject]


def test_readme_page_glossary_and_command_have_the_causes_and_counts_of_the_data():
    errata = all_errata()
    counts = {cause: sum(one.cause is cause for one in errata) for cause in Cause}
    assert errata.count_causes() == counts
    assert sum(counts.values()) == len(errata)
    words = [f"{number} {CAUSE_NOUNS[cause]}s" for cause, number in counts.items()]  # several of each
    sentence = f"{', '.join(words[:-1])} and {words[-1]}"
    assert errata.describe_counts() == sentence
    assert f"count by cause {sentence};" in (ROOT / "README.md").read_text(encoding="utf-8")
    page = (PAGE_FOLDER / "index.md").read_text(encoding="utf-8")
    assert f"There are {sentence}:" in page
    for cause, number in counts.items():
        assert f"| {cause} | {CAUSE_MEANINGS[cause]} | {number} |" in page
    entry = next(
        line for line in (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines() if line.startswith("| erratum |")
    )
    assert all(cause in entry for cause in Cause)
    assert str(errata).endswith(f"{len(errata)} errata: {sentence}")


def test_one_erratum_of_a_cause_is_counted_in_the_singular():
    assert gm.errata("marks").describe_counts() == "1 error, 1 small slip and 1 undecided place"


def test_a_number_that_is_right_makes_no_erratum():
    number = PrintedNumber("sagitta", "mm", 4, 3.9)
    with pytest.raises(ValueError, match="sagitta has no cause to deviate"):
        make_number_erratum(
            number, 0, paper=Paper.DUBOIS, name="sagitta", place="p. 618", proof="None.", command="governor-mechanism errata"
        )


def test_numbers_within_the_reasons_are_those_of_the_references():
    wrong_term = one_of("redtenbacher", "back-pressure").proof
    assert f"{flywheel.WRONG_THIRD_TERM:.4f}" in wrong_term
    lost = flywheel.TERMS_AT_PRINTED_ANGLES[2] + 0.2714
    added = 0.1713 + lost - flywheel.SUM_AT_PRINTED_ANGLES
    shares = one_of("redtenbacher", "back-pressure").consequence
    assert f"takes off {lost:.4f}" in shares
    assert f"add {added:.4f}" in shares
    wheel = one_of("redtenbacher", "flywheel").consequence
    assert f"{100 * (1 - 0.1713 / flywheel.SUM_AT_PRINTED_ANGLES):.0f} % too light" in wheel
    # A coefficient is inversely proportional to the inertia, to the order of its square, 1e-3.
    assert f"{flywheel.CASES['closed by the load'][4] / 0.1713:.2f} times" in wheel
    angle = one_of("dubois", "bell-crank-angle").consequence
    spreads = dict(hartung.STATIC_FORCE_SPREADS)
    assert f"{spreads[137.33]:.1f} %" in angle
    assert f"{spreads[132]:.1f} %" in angle
    sign = one_of("zehnder", "lowest-speed-sign").proof
    assert f"{120 * (1 - 0.0075):.4g} rpm" in sign
    assert f"{120 * (1 + 0.0075):.4g} rpm" in sign
    assert "2230.6 cm^2" in one_of("zehnder", "radius-squared").proof


def test_compression_shrinks_where_pre_release_grows():
    """The sentence on both ends of the cylinder, by the events of the reference: fill, pre-release, pre-admission, compression."""
    exact = {row[0]: row[6] - row[5] for row in marks.VALVE_EVENTS[4]}  # change of the way of the piston, infinite connecting rod
    for end, sense in (("crank end", 1), ("head end", -1)):
        fill, release, admission, compression = (
            sense * exact[f"{end} {event}"] for event in ("cut-off", "release", "admission", "compression")
        )
        assert fill < 0
        assert admission < 0
        assert release < 0  # earlier: more pre-release
        assert compression < 0  # what the paper says to grow
    assert math.copysign(1, one_of("marks", "cylinder-ends").right_value) == math.copysign(1, SHIFTS["crank end compression"])


@pytest.mark.parametrize(("ratio", "column"), [(1.0, 1), (1.3, 2), (0.7, 3)])
def test_the_simulated_governor_leaves_the_osculation_point_as_the_equilibrium_says(ratio, column):
    degrees = np.array([row[0] for row in zehnder.OSCULATION], dtype=float)
    speeds = simulated_speeds(design_pendulum(), ratio, np.append(degrees, 0.0))
    changes = speeds[:-1] / speeds[-1] - 1
    np.testing.assert_allclose(changes, [row[column] for row in zehnder.OSCULATION], rtol=0, atol=1e-11)  # 12 digits of about 0.01


def test_simulations_confirm_the_main_errors():
    found = simulated_errata()
    assert {key for key, sentence in found.items() if sentence} == {(paper.value, name) for paper, name in SIMULATIONS}
    forces = [row[-1] for row in hartung.VERTICAL_HANGER]
    spread = float(re.search(r"by ([\d.]+) % over the stroke with 132", found["dubois", "bell-crank-angle"])[1])
    # The mean of seven forces of the reference, or of 61, differs by a part in two hundred.
    assert spread == pytest.approx(100 * np.ptp(forces) / np.mean(forces), rel=5e-3)
    assert "1.42 times" in found["redtenbacher", "flywheel"]
    for event in ("crank end release", "crank end compression", "head end release", "head end compression"):
        assert f"{event.split()[-1]} {SHIFTS[event]:+.2f} deg" in found["marks", "cylinder-ends"]


def test_errata_are_a_result_like_others(tmp_path):
    dubois = gm.errata("dubois")
    assert {one.paper for one in dubois} == {Paper.DUBOIS}
    table = dubois.to_dataframe()
    assert len(table) == len(dubois) == len(json.loads(dubois.save_json(tmp_path / "errata.json").read_text(encoding="utf-8"))["errata"])
    assert table["right_value"][0] == pytest.approx(hartung.ANGLE_DEG, rel=1e-11)  # 12 digits
    assert dubois.save_csv(tmp_path / "errata.csv").stat().st_size > 0
    text = str(all_errata())
    assert all(reference in text for reference in PAPER_REFERENCES.values())


def test_the_command_takes_the_papers_of_the_study(tmp_path):
    assert [choice.value for choice in PaperChoice] == [paper.value for paper in Paper]
    answer = json_of("errata", "--paper", "marks", "--no-figure", "--out", tmp_path)
    assert [one["name"] for one in answer["errata"]] == [one.name for one in gm.errata("marks")]
    assert not list(tmp_path.iterdir())


def test_an_unknown_paper_is_refused_with_the_nearest():
    refuses(r"paper must be one of redtenbacher, .* got .dubios.\. Did you mean 'dubois'", gm.errata, "dubios")


def test_a_selection_of_an_unknown_paper_or_cause_is_refused_with_the_nearest():
    assert all_errata().select("dubois", "misprint") == all_errata().select(Paper.DUBOIS, Cause.MISPRINT) != ()
    refuses(r"paper must be one of .* got .dubios.\. Did you mean 'dubois'", all_errata().select, "dubios")
    with pytest.raises(MechanismError, match=r"cause must be one of error, .*, undecided; got .misprints.\. Did you mean 'misprint'"):
        all_errata().select("dubois", "misprints")
    assert all_errata().count("slip") == all_errata().count(Cause.SLIP) > 0
    refuses("cause must be one of", all_errata().count, "slips")


def test_the_printed_flywheel_leaves_its_band_and_the_right_one_keeps_to_it():
    """By the law of energy: between the extreme speeds the wheel stores the work of the reference."""
    panel = draw_erratum(Paper.REDTENBACHER).axes[0]
    light, right = (np.asarray(line.get_ydata()) * math.pi / 30 for line in panel.lines)
    mean, work = flywheel.MEAN_SPEED, flywheel.EXAMPLE_ENERGY
    bracket = {"printed": 0.1713, "right": flywheel.SUM_AT_EXACT_ANGLES}
    for speeds, value in zip((light, right), bracket.values(), strict=True):
        swing = work / (2 * flywheel.ENERGY_RATIO * value * 13_000 / mean**2)  # A p L = 13 kJ
        assert np.max(speeds) == pytest.approx(math.sqrt(mean**2 + swing), rel=1e-5)  # the curve has a point every half degree
        assert np.min(speeds) == pytest.approx(math.sqrt(mean**2 - swing), rel=1e-5)
    assert np.max(light) > flywheel.EXAMPLE_HIGHEST_SPEED + 0.03
    assert np.max(right) < flywheel.EXAMPLE_HIGHEST_SPEED + 0.002


def test_the_curves_beside_the_osculation_point_pass_through_the_reference():
    lines = draw_erratum(Paper.ZEHNDER).axes[0].lines
    for column, line in zip((2, 1, 3), lines[:6:2], strict=True):  # longer arm, osculating circle, shorter arm; the paper's beside each
        for row in zehnder.OSCULATION:
            index = np.flatnonzero(np.isclose(line.get_xdata(), row[0]))
            assert line.get_ydata()[index] == pytest.approx(100 * row[column], abs=1e-9)  # 12 digits of a few percent


@pytest.mark.parametrize("paper", DRAWINGS)
def test_pictures_are_drawn_and_those_of_the_page_are_small(paper, tmp_path):
    assert draw_erratum(paper).save(tmp_path / "picture.svg").stat().st_size > 0
    assert 0 < (PAGE_FOLDER / f"{paper}.png").stat().st_size < LARGEST_PICTURE


def test_the_page_is_current():
    """Else: make errata."""
    path = PAGE_FOLDER / "generate.py"
    specification = importlib.util.spec_from_file_location("errata_page", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert Path(PAGE_FOLDER / "index.md").read_text(encoding="utf-8") == module.write_page()
