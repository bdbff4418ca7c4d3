"""The worked notebook runs from its first to its last cell, shows what it says, and its numbers obey the laws of the linkage."""

import ast
import json
import math
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.pytest_plugin import compare_kernel

PATH = Path(__file__).parents[2] / "docs" / "notebooks" / "six_bar.ipynb"
CELLS = json.loads(PATH.read_text(encoding="utf-8"))["cells"]


def run_cell(source, names):
    """Run a cell as IPython does, and return the value of its last line if that is an expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, PATH.name, "exec"), names)  # our own words
    return None if last is None else eval(compile(ast.Expression(last.value), PATH.name, "eval"), names)


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    """Names of the notebook after all cells, the values that cells show, and the folder of its files."""
    folder, names, shown = tmp_path_factory.mktemp("notebook"), {}, []
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for cell in CELLS:
            if cell["cell_type"] == "code":
                shown.append(run_cell("".join(cell["source"]), names))
    return names, shown, folder


def ram_position(crank, angle):
    """The position of the ram for a length of the crank: the pin of the rods is the upper point that closes both triangles."""
    shaft_pin = crank * np.exp(1j * angle)
    base = 0.3 - shaft_pin
    # Law of cosines in the triangle of coupler, rocker and the line between their ends.
    opening = np.arccos((0.3**2 + abs(base) ** 2 - 0.25**2) / (2 * 0.3 * abs(base)))
    pin = shaft_pin + 0.3 * np.exp(1j * (np.angle(base) + opening))
    return pin.real + np.sqrt(0.35**2 - (pin.imag - 0.1) ** 2)


def test_it_is_stored_without_outputs():
    code = [cell for cell in CELLS if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)
    assert len({cell["id"] for cell in CELLS}) == len(CELLS)


def test_every_shown_value_has_a_page(notebook):
    _, shown, _ = notebook
    figures = [value._repr_png_() for value in shown if hasattr(value, "_repr_png_")]
    assert [figure[:4] for figure in figures] == [b"\x89PNG"]
    pages = [value._repr_html_() for value in shown if hasattr(value, "_repr_html_") and not hasattr(value, "_repr_png_")]
    assert len(pages) == 9  # scene, run, film, three tables of pandas, sweep, report and view
    assert not any("nan" in page.lower() for page in pages if "base64" not in page)


def test_the_motion_is_that_of_the_linkage(notebook):
    names, _, folder = notebook
    run = names["run"]
    angles = np.radians(60) + 3 * math.pi * run.times  # 90 rpm
    np.testing.assert_allclose(run.readings["ram_x"], ram_position(0.1, angles), atol=1e-9)  # its own estimate is 1e-10 of the size
    np.testing.assert_array_equal(names["table"]["ram_x"], run.readings["ram_x"])
    positions = ram_position(0.1, np.linspace(0.0, 2 * math.pi, 100_001))
    assert names["stroke"] == pytest.approx(np.ptp(positions), rel=1e-4)  # one sample each millisecond
    assert (folder / "six_bar.gif").read_bytes().startswith(b"GIF89a")


def test_the_sweep_has_the_strokes_of_the_closed_form(notebook):
    names, _, _ = notebook
    angles = np.linspace(0.0, 2 * math.pi, 100_001)
    strokes = [np.ptp(ram_position(length, angles)) for length in names["strokes"]["body.crank.rod.length"]]
    np.testing.assert_allclose(names["strokes"]["span ram_x"], strokes, rtol=1e-4)


def test_the_formula_and_the_lines_that_guard_it_hold(notebook, monkeypatch, pytestconfig):
    names, _, folder = notebook
    assert names["report"].passed
    (lines,) = (match[1] for cell in CELLS if (match := re.search(r"```python\n(.*?)```", "".join(cell["source"]), re.DOTALL)))
    formulas = ModuleType("formulas")
    formulas.ram_x = names["ram_x"]
    monkeypatch.setitem(sys.modules, "formulas", formulas)
    monkeypatch.chdir(folder)
    pytestconfig.addinivalue_line("markers", "governor: as the plugin of the package registers it, which a source tree does not load")
    module = {}
    exec(compile(lines, "test_formulas.py", "exec"), module)
    test = module["test_ram_position"]
    (mark,) = (mark for mark in test.pytestmark if mark.name == "governor")
    options = dict(mark.kwargs)
    scene = options.pop("scene")
    assert compare_kernel(scene, test(), **options).passed
    with pytest.raises(pytest.fail.Exception, match="do not agree"):
        compare_kernel(scene, lambda crank_angle: 1.001 * names["ram_x"](crank_angle), **options)


def test_the_explored_scene_is_the_changed_one(notebook):
    names, _, _ = notebook
    view = names["view"]
    assert view.scene == names["scene"].replace({"body.crank.rod.length": "120 mm"})
    motion = gm.kinematics(view.scene, over="crank_angle")
    np.testing.assert_allclose(motion.readings["ram_x"], ram_position(0.12, motion.values), atol=1e-9)
    assert isinstance(view.scene, gm.Scene)
