"""What the README shows works as it stands there."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import governor_mechanism as gm
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.scenes.parser import parse_scene_document

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


@pytest.mark.parametrize("code", blocks("python"))
def test_python_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})  # our own words
    assert "nan" not in capsys.readouterr().out.lower()


def test_scenes_and_pictures_that_are_named_exist():
    root = Path(__file__).parents[1]
    for name in re.findall(r"governor-mechanism run (\w+)\s", TEXT):
        assert name in shipped_scenes()
    for path in re.findall(r"\]\(((?!http)[^)]+)\)", TEXT):
        assert (root / path).exists(), path
