"""The command `crosscheck` with a kernel of the user: what it prints, what it writes, how it ends."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image

from command_line import invoke, json_of, succeed

KERNELS = """
import math
from beside import LOAD

def speed(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    load = gravity * (1 + LOAD * sleeve_mass / ball_mass)
    return math.sqrt(load * math.tan(arm_angle) / (offset + arm * math.sin(arm_angle)))

def rpm(alpha, l):
    return 1.01 * 30 / math.pi * speed(math.radians(alpha), l, 0.04, 5.0, 20.0, 9.81)

def sometimes(arm_angle, arm):
    return 2 * arm * (1 - math.cos(arm_angle)) if arm_angle < 0.6 else math.sqrt(-arm)

nothing = 3
"""
OVER = ("--over", "arm_angle=15deg:45deg:5")


@pytest.fixture
def kernels(tmp_path: Path) -> Path:
    (tmp_path / "beside.py").write_text("LOAD = 1\n", encoding="utf-8")
    path = tmp_path / "mine.py"
    path.write_text(KERNELS, encoding="utf-8")
    return path


def test_a_right_kernel_ends_with_0_and_writes_record_figure_and_junit(kernels: Path, tmp_path: Path):
    junit = tmp_path / "junit.xml"
    result = succeed("crosscheck", "porter", "--kernel", f"{kernels}:speed", *OVER, "--out", tmp_path, "--junit", junit)
    assert "all 5 agree within 1e-06 of the simulation" in result.stdout
    record = json.loads((tmp_path / "porter_equilibrium_speed_speed.json").read_text(encoding="utf-8"))
    assert record["passed"]
    assert record["units_of_arguments"]["arm"] == "m"
    assert all(row["error_estimate"] > 0 for row in record["rows"])
    with Image.open(tmp_path / "porter_equilibrium_speed_speed.png") as image:
        assert image.size == (840, 600)
    suite = ElementTree.parse(junit).getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("5", "0")


def test_a_kernel_one_per_cent_off_ends_with_1_in_its_own_unit_and_names(kernels: Path, tmp_path: Path):
    junit = tmp_path / "junit.xml"
    words = (*OVER, "--map", "alpha=arm_angle in deg", "--map", "l=arm", "--unit", "rpm", "--junit", junit, "--out", tmp_path)
    result = invoke("crosscheck", "porter", "--kernel", f"{kernels}:rpm", *words, "--no-figure", "--json")
    assert result.exit_code == 1, result.output
    answer = json.loads(result.stdout)
    assert answer["unit"] == "rpm"
    assert answer["worst"]["relative_error"] == pytest.approx(0.01, abs=1e-12)  # rounding
    assert [Path(name).suffix for name in answer["files"]] == [".json", ".xml"]
    failures = ElementTree.parse(junit).getroot().findall("testsuite/testcase/failure")
    assert len(failures) == 5
    assert "+1 %" in failures[0].get("message")


def test_random_dimensions_are_drawn_by_the_command_too(kernels: Path, tmp_path: Path):
    words = ("--over", "arm_angle=15deg:45deg", "--vary", "dimensions.arm=200mm:400mm", "--random", "8", "--seed", "1", "--out", tmp_path)
    assert "all 8 agree" in succeed("crosscheck", "porter", "--kernel", f"{kernels}:speed", *words).stdout
    assert (tmp_path / "porter_equilibrium_speed_speed.png").is_file()


def test_a_kernel_that_raises_at_some_points_is_told_in_a_sentence(kernels: Path, tmp_path: Path):
    result = invoke("crosscheck", "porter", "--kernel", f"{kernels}:sometimes", "--quantity", "sleeve_lift", *OVER, "--out", tmp_path)
    assert result.exit_code == 1
    assert "the kernel raised ValueError: math domain error (line 13 of mine.py), called with arm_angle = 0.654" in result.stdout
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["{mine}:sped"], "has no function 'sped'; it has speed, rpm, sometimes. Did you mean 'speed'?"),
        (["{mine}:nothing"], "'nothing' in {mine} is no function"),
        (["{wrong}:speed"], "cannot be executed: SyntaxError"),
        (["{mine}:speed", "--map", "alpha"], "--map 'alpha' is not understood"),
        (["{mine}:speed", "--over", "arm_angle=1"], "--over gives 'arm_angle' twice"),
    ],
)
def test_what_cannot_be_compared_ends_with_2_and_a_sentence(words, sentence, kernels: Path, tmp_path: Path):
    wrong = tmp_path / "wrong.py"
    wrong.write_text("def speed(:\n", encoding="utf-8")
    places = {"mine": kernels, "wrong": wrong}
    result = invoke("crosscheck", "porter", "--kernel", *(word.format(**places) for word in words), *OVER, "--out", tmp_path)
    assert result.exit_code == 2
    assert sentence.format(**places) in result.stderr
    assert "Traceback" not in result.output


def test_the_quantities_are_listed():
    result = succeed("crosscheck", "slide_valve_marks", "--list")
    for words in ("crank_end_cut_off", "valve_displacement", "head_end_lead", "outside_lap (m)"):
        assert words in result.stdout
    listed = json_of("crosscheck", "porter", "--list")
    stiffness = next(one for one in listed["quantities"] if one["name"] == "stiffness")
    assert stiffness["over"] == {"arm_angle": "rad", "spindle_speed": "rad/s"}
    assert stiffness["optional"] == ["spindle_speed"]


def test_closed_forms_are_written_as_junit_too(tmp_path: Path):
    junit = tmp_path / "junit.xml"
    succeed("crosscheck", "watt_crossed", "--junit", junit)
    assert ElementTree.parse(junit).getroot().get("failures") == "0"
