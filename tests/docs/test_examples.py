"""The examples of the documentation run as they stand, and what shows their pictures."""

import runpy
import shutil
from base64 import b64encode

import pytest
from PIL import Image

import governor_mechanism as gm
from documentation_pages import ROOT
from example_pictures import collect_pictures
from picture_sizes import complete_pictures

FOLDER = ROOT / "docs" / "examples"
EXAMPLES = sorted(FOLDER.rglob("*.py"))
LONGEST = 25
"""Largest number of lines with code: one sees at a glance what an example does."""
DEAR = {
    *("accuracy_and_time", "before_and_after", "cam", "clock", "crosscheck", "first_governor", "fit", "flywheel", "function"),
    "geneva_wheel",
    *("governed_engine", "heat_map", "optimise", "path", "sensitivities", "slide_valve", "stability_border", "stability_map"),
    *("straight_lines", "valve_gears", "valve_timing", "velocities", "walking_leg"),
}
"""Examples that take more than half a second; their functions are tested elsewhere too."""

cases = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.long] if path.stem in DEAR else []) for path in EXAMPLES if path.stem[:4] != "test"
]


@pytest.mark.parametrize("path", cases)
def test_examples_run(path, tmp_path, monkeypatch, capsys):
    """Their films have a few frames only."""
    film = gm.film
    reduced = {"stop": "0.2 s", "frames_per_second": 5.0, "slow_down": 1.0}
    monkeypatch.setattr(gm, "film", lambda run, path, **options: film(run, path, **{**options, **(reduced if path[-3:] == "gif" else {})}))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert "nan" not in capsys.readouterr().out.split()
    assert [one for one in tmp_path.iterdir() if one.suffix in (".png", ".gif", ".html", ".svg") or one.is_dir()]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:Unknown pytest.mark.governor")  # pytest has the plug-in when it collects the test
def test_the_example_under_pytest_passes(tmp_path, monkeypatch, capsys):
    shutil.copy(FOLDER / "trust" / "test_of_a_formula.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_ADDOPTS", f"--rootdir={tmp_path} -p no:xdist -p no:hypothesispytest -p no:cacheprovider")
    runpy.run_path("test_of_a_formula.py", run_name="__main__")
    assert "1 passed" in capsys.readouterr().out


def test_examples_are_short_and_have_a_title():
    assert len(EXAMPLES) >= 30
    for path in EXAMPLES:
        _, words, code = path.read_text(encoding="utf-8").split('"""', 2)
        title, line, *_ = words.strip().splitlines()
        assert line == "=" * len(title), path
        assert len([one for one in code.splitlines() if one.strip() and one[0] != "#"]) <= LONGEST, path
        assert "\n# %%\n# More: :doc:`" in code, path  # which also makes sphinx-gallery show the code above its output
        assert (path.parent / "GALLERY_HEADER.rst").is_file()


def test_what_an_example_writes_is_shown_and_taken_away(tmp_path):
    root, folder = tmp_path / "docs", tmp_path / "docs" / "examples"
    for made in (folder, root / "_generated" / "examples" / "images", folder / "results"):
        made.mkdir(parents=True)
    (folder / "leg.py").touch()
    (folder / "leg.csv").touch()
    (folder / "leg.html").touch()
    frames = [Image.new("RGB", (4, 3), (k, k, k)) for k in (0, 100, 200)]
    frames[0].save(folder / "leg.gif", save_all=True, append_images=frames[1:])
    paths = iter([root / "_generated" / "examples" / "images" / "leg_001.png"])
    shown = collect_pictures(None, {"src_file": str(folder / "leg.py"), "image_path_iterator": paths}, {"src_dir": str(root)})
    assert ".. image:: /_generated/examples/images/leg_001.gif" in shown
    assert 'src="../../../pages/example_leg.html"' in shown
    assert [path.name for path in folder.iterdir()] == ["leg.py"]
    with Image.open(root / "_generated" / "examples" / "images" / "leg_001.png") as still:
        assert still.getpixel((0, 0)) == (100, 100, 100)


def test_pictures_get_their_size_and_load_late(tmp_path):
    Image.new("RGB", (40, 30)).save(tmp_path / "a.png")
    (tmp_path / "b.svg").write_text('<svg viewBox="0 0 12.4 7"/>')
    page = '<p><img alt="a" src="x/a.png"/><img src="b.svg"><img width="5" src="a.png" loading="eager"><img src="http://b.org/c.png"></p>'
    inside = f'<img src="data:image/png;base64,{b64encode((tmp_path / "a.png").read_bytes()).decode()}">'
    assert complete_pictures(inside, {}.get).startswith('<img loading="lazy" width="40" height="30" src="data:')
    files = {"x/a.png": tmp_path / "a.png", "a.png": tmp_path / "a.png", "b.svg": tmp_path / "b.svg"}
    assert complete_pictures(page, files.get) == (
        '<p><img loading="lazy" width="40" height="30" alt="a" src="x/a.png"/><img loading="lazy" width="12" height="7" src="b.svg">'
        '<img width="5" src="a.png" loading="eager"><img loading="lazy" src="http://b.org/c.png"></p>'
    )
