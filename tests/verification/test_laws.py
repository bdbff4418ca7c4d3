"""The catalogue: every classic mechanism proves its law, and each of its dimensions does to the law what the file says."""

import tomllib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import FAMILIES
from governor_mechanism.scenes.library import catalogue_scenes, list_catalogue_entries, shipped_scenes
from governor_mechanism.verification.laws import BrokenLaw, check_law
from refusing import refuses

NAMES = list(catalogue_scenes())
DOCUMENT = tomllib.loads(catalogue_scenes()["scotch_yoke"].read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", NAMES)
def test_every_law_holds_and_each_dimension_keeps_or_breaks_it(name: str):
    report = gm.crosscheck(name)
    assert report.passed, str(report)
    law = gm.load(name).part.law
    assert law is not None
    assert len(report.rows) == len(law.equations) + len(law.dimensions)
    assert sum(isinstance(row, BrokenLaw) for row in report.rows) == len(law.broken_by)


@pytest.mark.parametrize("name", NAMES)
def test_a_file_of_the_catalogue_is_a_page_with_its_source(name: str):
    text = catalogue_scenes()[name].read_text(encoding="utf-8")
    assert text.startswith("#:schema ../scene.schema.json\n# ")
    assert len(text.splitlines()) <= 60
    law = tomllib.loads(text)["law"]
    assert law["source"]
    assert law["family"] in FAMILIES


def test_the_catalogue_has_forty_mechanisms_and_no_name_twice():
    assert len(NAMES) >= 40
    assert not set(NAMES) & set(shipped_scenes())
    assert set(list_catalogue_entries()) == set(NAMES)
    assert {"peaucellier", "roberts"} < set(gm.list_catalogue("straight-lines")) < set(NAMES)
    refuses(r"no family 'walker'; families are .*Did you mean 'walkers'", gm.list_catalogue, "walker")


def _circles(first: complex, first_radius: float, second: complex, second_radius: float, side: int) -> complex:
    """Return where two circles meet, to the left (1) or right (-1) of the line between their centres."""
    distance = abs(second - first)
    along = (first_radius**2 - second_radius**2 + distance**2) / (2 * distance)
    return first + (second - first) / distance * (along + side * 1j * np.sqrt(first_radius**2 - along**2))


def _jansen(angle: float) -> complex:
    crank, pivot = 15 * np.exp(1j * angle), -38 - 7.8j
    top, bottom = _circles(crank, 50, pivot, 41.5, -1), _circles(crank, 61.9, pivot, 39.3, 1)
    knee = _circles(pivot, 40.1, top, 55.8, 1)
    ankle = _circles(knee, 39.4, bottom, 36.7, -1)
    return _circles(bottom, 49, ankle, 65.7, 1)


def _klann(angle: float) -> complex:
    crank = 17.5 * np.exp(1j * angle)
    elbow = _circles(-38.8 - 12.5j, 23.7, crank, 38.8, 1)
    knee = _circles(crank, 73.4, elbow, 35.2, 1)
    hip = _circles(-14.6 + 41.9j, 34.1, knee, 57.7, -1)
    return _circles(hip, 111.7, knee, 59, 1)


@pytest.mark.parametrize(("foot", "stride", "lift"), [(_jansen, 67.908, 22.457), (_klann, 74.106, 33.433)])
def test_strides_of_walkers_follow_from_intersections_of_circles(foot: Callable[[float], complex], stride: float, lift: float):
    path = np.array([foot(angle) for angle in np.linspace(0, 2 * np.pi, 20_001)])
    # 20,000 positions miss an extreme by less than 1e-6 of the lift; half a unit of the last printed digit
    assert np.ptp(path.real) == pytest.approx(stride, abs=5e-4)
    assert np.ptp(path.imag) == pytest.approx(lift, abs=5e-4)


def test_the_path_of_chebyshevs_linkage_is_half_of_its_cognate():
    crossed, turning = gm.load("chebyshev"), gm.load("chebyshev_lambda")
    scale = crossed.part.dimensions["base"] / (4 * turning.part.dimensions["crank"])
    path = gm.kinematics(turning, "crank_angle", np.linspace(0.5 * np.pi, 1.5 * np.pi, 41)).readings
    across = (path["pen_x"] - path["pen_x"][20]) * scale + crossed.part.dimensions["base"] / 2
    heights = gm.kinematics(crossed, "pen_x", np.sort(across)).readings["pen_y"]
    assert heights == pytest.approx(path["pen_y"][np.argsort(across)] * scale, abs=1e-12)


def _with_law(**changes: Any) -> dict[str, Any]:
    law = {key: value for key, value in {**DOCUMENT["law"], **changes}.items() if value is not None}
    return {**DOCUMENT, "law": law}


@pytest.mark.parametrize(
    "changes",
    [
        {"proves": [{"value": "yoke_x", "equals": "1.001 * crank * cos(crank_angle)", "within": "1e-12 m"}]},
        {"holds_under": ["crank", "slot"], "broken_by": []},
        {"holds_under": [], "broken_by": ["crank", "slot"]},
    ],
)
def test_a_wrong_law_and_a_dimension_in_the_wrong_list_fail(changes: dict[str, Any]):
    report = check_law(gm.Scene.from_dict(_with_law(**changes)))
    assert not report.passed
    assert "FAILED" in str(report)


def test_a_changed_mechanism_breaks_its_law():
    assert not check_law(gm.load("peaucellier").replace({"dimensions.ground": "1.05 m"})).passed


def test_a_scene_without_a_law_is_refused():
    with pytest.raises(MechanismError, match=r"states no law; a table \[law\] in its file does"):
        check_law(gm.Scene.from_dict({key: value for key, value in DOCUMENT.items() if key != "law"}))


def test_a_law_that_names_no_dimension_is_refused():
    document = {key: value for key, value in _with_law(holds_under=None, broken_by=None).items() if key != "dimensions"}
    plain = {**document, "body": [{"name": "crank", "mass": 1, "disc": {"radius": 1}}], "joint": DOCUMENT["joint"][:1]}
    plain |= {"readings": {"crank_angle": {"angle": "crank"}}}
    plain["law"] = {**plain["law"], "proves": [{"value": "rate(crank_angle)", "equals": 1, "within": 1e-12}]}
    refuses(r"law names no dimension; give the scene a table \[dimensions\]", gm.Scene.from_dict, plain)


def test_a_function_of_a_reading_takes_no_expression():
    equation = {"value": "spread(2 * yoke_x)", "equals": "4 * crank", "within": "1e-9 m"}
    with pytest.raises(MechanismError, match=r"spread in a law is of a reading, as spread\(pen_x\), not of an expression"):
        check_law(gm.Scene.from_dict(_with_law(proves=[equation])))
