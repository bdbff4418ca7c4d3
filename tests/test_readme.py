"""What the README shows works as it stands there."""

from __future__ import annotations

import os
import re
import shlex
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

import governor_mechanism as gm
from governor_mechanism.cli.main import app
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep.rules import ENGINE_RULES, STATISTICS, VALVE_RULES

TEXT = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", TEXT, flags=re.DOTALL)


@pytest.mark.parametrize("text", blocks("toml"))
@pytest.mark.parametrize("engine", ["multibody", "impulse"])
def test_scenes_run(text, engine):
    scene = parse_scene_document(tomllib.loads(text))
    if scene.output_effects and engine == "impulse":
        pytest.skip("what sticks and strikes impulse steps too, but slowly: test_impulse_effects.py")
    run = gm.run(scene, engine=engine, accuracy=1e-5)
    assert run.outcome.ok
    assert run.error_estimate <= 1e-5


@pytest.mark.parametrize("code", [code for code in blocks("python") if "pytest.mark" not in code])
def test_python_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})  # our own words
    assert "nan" not in capsys.readouterr().out.lower()


def test_scenes_and_pictures_that_are_named_exist():
    root = Path(__file__).parents[1]
    for name in re.findall(r"governor-mechanism run (\w+)\s", TEXT):
        assert name in shipped_scenes()
    anchors = {"#" + heading.lower().replace(" ", "-") for heading in re.findall(r"^#+ (.+)$", TEXT, flags=re.MULTILINE)}
    for path in re.findall(r"\]\(((?!http)[^)]+)\)", TEXT):
        assert path in anchors or (root / path).exists(), path


def test_commands_of_tasks_run(tmp_path, monkeypatch):
    """Each as it stands, but for the duration: a tenth of a second of film shows as well that the options are understood."""
    monkeypatch.chdir(tmp_path)
    for line in "".join(blocks("sh")).splitlines():
        words, _, target = line.partition(" > ")
        command, *arguments = shlex.split(words)
        assert command == "governor-mechanism"
        result = CliRunner().invoke(app, [*arguments, *(["--seconds", "0.1"] if arguments[0] in ("run", "compare") else [])])
        assert result.exit_code == 0, result.output
        if target:
            Path(target).write_text(result.stdout, encoding="utf-8")
    assert {"mine.gif", "mine.csv"} <= {path.name for path in Path("results").iterdir()}


def test_the_guarded_kernel_passes(tmp_path, capsys):
    (code,) = [code for code in blocks("python") if "pytest.mark.governor" in code]
    assert len([line for line in code.splitlines() if line]) <= 6
    path = tmp_path / "test_of_readme.py"
    path.write_text(code, encoding="utf-8")
    alone = ["--import-mode=importlib", f"--rootdir={tmp_path}", f"--confcutdir={tmp_path}", "-c", os.devnull, "-p", "no:cacheprovider"]
    off = [word for name in ("xdist", "faulthandler", "hypothesispytest") for word in ("-p", f"no:{name}")]
    assert pytest.main(["-p", "governor_mechanism.pytest_plugin", *alone, *off, str(path)]) == 0
    assert "1 passed" in capsys.readouterr().out


def test_the_table_of_quantities_names_every_rule():
    rows = "".join(line for line in TEXT.splitlines() if line.startswith("| `"))
    for rule in (*STATISTICS, *ENGINE_RULES, "valve travel", "duration", "error_estimate"):
        assert rule in rows
    assert all(rule.split()[-1] in rows for rule in VALVE_RULES)
