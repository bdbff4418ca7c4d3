"""The command `design` as a person uses it."""

import dataclasses
import json
from pathlib import Path

import pytest

import governor_mechanism as gm
from command_line import json_of, succeed
from governor_mechanism.cli.design import DESIGNS
from governor_mechanism.studies.design.simulated import PROCEDURES


def test_the_papers_governor_is_designed_with_what_is_not_right_marked(tmp_path: Path) -> None:
    told = json_of("design", "hartung", "--out", str(tmp_path))
    assert "spring force at 92 mm, 212 rpm" in told["paper"]["deviations"]
    assert [Path(name).name for name in told["files"]] == ["hartung_design.toml", "hartung_spring_lines.png", "hartung_sleeve_force.png"]
    assert all(Path(name).is_file() for name in told["files"])
    scene = gm.load(tmp_path / "hartung_design.toml")
    # The file gives twelve digits.
    assert scene.part.dimensions["bell_crank_angle"] == pytest.approx(told["design"]["angle"], rel=1e-11)


def test_inputs_of_ones_own_leave_the_paper_aside(tmp_path: Path) -> None:
    result = succeed("design", "hartung", "--with", "wire=10 mm", "--with", "weight_mass=50 kg", "--no-figure", "--out", str(tmp_path))
    assert "recomputed" not in result.stdout
    assert "bell crank: 137.197 deg" in result.stdout  # masses and wire do not enter it
    assert "warning: the springs are overstressed" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["hartung_design.toml"]


def test_the_flywheel_of_the_paper_is_designed_with_its_third_term_marked(tmp_path: Path) -> None:
    result = succeed("design", "flywheel", "--json", "--out", tmp_path)
    told = json.loads(result.stdout)
    assert "back pressure (66)" in told["paper"]["deviations"]
    assert [Path(name).name for name in told["files"]] == ["flywheel_design.toml", "flywheel_design.png"]
    assert "the cycle does not close" in result.stderr
    text = succeed("design", "flywheel", "--no-figure", "--out", str(tmp_path)).stdout
    assert "this makes the flywheel 28 % too light" in text


def test_a_given_flywheel_has_its_fluctuation_computed(tmp_path: Path) -> None:
    words = ("--with", "load_pressure=closing", "--with", "inertia=4000 kg m^2", "--no-figure", "--out", str(tmp_path))
    result = succeed("design", "flywheel", *words)
    assert "coefficient of speed fluctuation 0.0199793" in result.stdout  # 3155.01221546 J / (4000 kg m2 (2 pi / s)^2)
    assert "recomputed" not in result.stdout


@pytest.mark.parametrize("machine", DESIGNS)
def test_help_lists_every_input_with_unit_meaning_and_default(machine: str) -> None:
    text = succeed("design", machine, "--help").stdout
    for one in dataclasses.fields(PROCEDURES[machine].inputs):
        assert f"  --{one.name.replace('_', '-')} " in text
        assert " ".join(one.metadata["declared"].meaning.split()[:2]) in text
    if machine == "pendulum":
        assert "--arm <mm>" in text
        assert "[default: 9.81 m/s^2]" in " ".join(text.split())


def test_designs_are_commands_of_their_own() -> None:
    text = succeed("design", "--help").stdout
    assert list(DESIGNS) == list(PROCEDURES)
    assert all(f"  {name} " in text for name in DESIGNS)
