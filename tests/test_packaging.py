"""The wheel carries the scenes, and so does a source tree that is installed to be edited; the repository stays small."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from documentation_pages import PAGES
from governor_mechanism.numerics.kernel_library import platform_name

ROOT = Path(__file__).parents[1]
LIST = (
    "from governor_mechanism.scenes.library import load_scene, shipped_scenes\nprint(*shipped_scenes())\nprint(load_scene('porter').source)"
)

MAX_FILE_SIZE = 1_000_000
"""Largest size of a tracked file, bytes: every clone has every version of it, for ever."""
MAX_PICTURE_SIZE, MAX_PICTURES_SIZE, MAX_PICTURES = 400_000, 12_000_000, 70
"""Largest size of a picture of renders/ and of all, bytes, and largest number of them."""


def test_the_wheel_holds_the_scenes_and_finds_them(tmp_path):
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
        assert "governor_mechanism/py.typed" in archive.namelist()
        source = ROOT / "src"
        templates = {path.relative_to(source).as_posix() for ending in ("toml", "txt") for path in source.rglob(f"*.{ending}")}
        assert templates
        assert templates <= set(archive.namelist())
        index = json.loads(archive.read("governor_mechanism/_kernels/index.json"))
        assert index["platform"] == platform_name()
        assert "sources" not in index
        kernels = {name for name in archive.namelist() if "/_kernels/" in name}
        assert kernels == {f"governor_mechanism/_kernels/{name}" for name in ("index.json", index["library"])}
    assert re.search(r"-py3-none-(?!any)\w+\.whl$", wheel.name)
    names, scene = listed(tmp_path / "installed")
    assert names == sorted(path.stem for path in (ROOT / "models").glob("*.toml"))
    assert "porter" in scene


def test_the_source_tree_finds_its_scenes():
    names, _ = listed(ROOT / "src")
    assert names == sorted(path.stem for path in (ROOT / "models").glob("*.toml"))


def listed(path: Path) -> tuple[list[str], str]:
    environment = {**os.environ, "PYTHONPATH": str(path)}
    answer = subprocess.run([sys.executable, "-c", LIST], env=environment, cwd=path, capture_output=True, text=True, check=True)
    names, source = answer.stdout.splitlines()
    return names.split(), source


@pytest.fixture(scope="module")
def tracked():
    """Return the size of each tracked file that is there."""
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("this is no clone, or there is no git")
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
    return {name: (ROOT / name).stat().st_size for name in names if (ROOT / name).is_file()}


def test_no_tracked_file_is_large(tracked):
    assert len(tracked) > 100
    assert {name: size for name, size in tracked.items() if size > MAX_FILE_SIZE} == {}


def test_renders_holds_what_the_pages_show_and_nothing_else(tracked):
    pages = [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "benchmarks" / "RESULTS.md"]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    shown = set(re.findall(r"\((?:\.\./)*(renders/[^)]+)\)", text))
    pictures = {name: size for name, size in tracked.items() if name.startswith("renders/")}
    assert set(pictures) == shown, "`make pictures` writes what is shown"
    assert {name: size for name, size in pictures.items() if size > MAX_PICTURE_SIZE} == {}
    assert len(pictures) <= MAX_PICTURES
    assert sum(pictures.values()) <= MAX_PICTURES_SIZE
