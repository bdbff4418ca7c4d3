"""The wheel carries the scenes, and so does a source tree that is installed to be edited."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
LIST = (
    "from governor_mechanism.scenes.library import load_scene, shipped_scenes\nprint(*shipped_scenes())\nprint(load_scene('porter').source)"
)


def test_the_wheel_holds_the_scenes_and_finds_them(tmp_path):
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
        assert "governor_mechanism/py.typed" in archive.namelist()
    names, source = listed(tmp_path / "installed")
    assert names == sorted(path.stem for path in (ROOT / "models").glob("*.toml"))
    assert "porter" in source


def test_the_source_tree_finds_its_scenes():
    names, _ = listed(ROOT / "src")
    assert names == sorted(path.stem for path in (ROOT / "models").glob("*.toml"))


def listed(path: Path) -> tuple[list[str], str]:
    environment = {**os.environ, "PYTHONPATH": str(path)}
    answer = subprocess.run([sys.executable, "-c", LIST], env=environment, cwd=path, capture_output=True, text=True, check=True)
    names, source = answer.stdout.splitlines()
    return names.split(), source
