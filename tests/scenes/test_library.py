"""Shipped scenes are found by name, files by path, and a wrong name is told with the nearest right one."""

import math
import shutil
from pathlib import Path

import pytest

from governor_mechanism.closed_form import pendulum
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes import library
from refusing import refuses

NAMES = ["porter", "porter_extended_arms", "porter_uncrossed_links", "watt", "watt_crossed"]


def test_a_shipped_scene_is_read_again_only_if_its_file_has_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy = tmp_path / "porter.toml"
    shutil.copy(library.shipped_scenes()["porter"], copy)
    monkeypatch.setattr(library, "models_folder", lambda: tmp_path)
    first = library.load_scene("porter")
    assert library.load_scene("porter") is first
    copy.write_text(copy.read_text().replace("title =", "# changed\ntitle ="))
    assert library.load_scene("porter") == first
    assert library.load_scene("porter") is not first


def closed_form_of(scene: Scene) -> pendulum.PendulumGovernor:
    return pendulum.PendulumGovernor(**scene.part.dimensions)


def test_the_shipped_scenes_are_found_sorted() -> None:
    known = library.shipped_scenes()
    assert list(known) == sorted(known)
    assert set(NAMES) <= set(known)
    assert all(path.is_file() and path.parent == library.models_folder() for path in known.values())


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_scene_is_the_same_by_name_and_by_path(name: str) -> None:
    path = library.shipped_scenes()[name]
    assert library.load_scene(name) == library.load_scene(path) == library.load_scene(str(path))


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_scene_opens_with_a_comment_that_names_its_source(name: str) -> None:
    lines = library.shipped_scenes()[name].read_text(encoding="utf-8").splitlines()
    schema, *comment = lines[: lines.index(next(line for line in lines if not line.startswith("#")))]
    assert schema == "#:schema ./scene.schema.json"
    assert 1 <= len(comment) <= 3
    assert "Zehnder" in " ".join(comment)
    assert library.load_scene(name).title != name


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_scene_starts_beside_a_stable_equilibrium(name: str) -> None:
    scene = library.load_scene(name)
    governor = closed_form_of(scene)
    angles = pendulum.equilibrium_angles(governor, spindle_speed=scene.spindle.speeds[0])
    nearest = min(angles, key=lambda angle: abs(angle - scene.start.values["arm_angle"]))
    assert pendulum.stiffness(governor, arm_angle=float(nearest)) > 0
    # Near enough to swing within the travel, far enough to be seen swinging.
    assert math.radians(1) < abs(nearest - scene.start.values["arm_angle"]) < math.radians(8)


@pytest.mark.parametrize("name", ["porter_extended_arms", "porter_uncrossed_links"])
def test_the_scenes_made_for_thirty_degrees_rest_there(name: str) -> None:
    scene = library.load_scene(name)
    (angle,) = pendulum.equilibrium_angles(closed_form_of(scene), spindle_speed=scene.spindle.speeds[0])
    # The speed is given to 12 digits.
    assert math.degrees(angle) == pytest.approx(30.0, abs=1e-8)


def test_a_relative_path_is_a_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(library.shipped_scenes()["watt"], tmp_path / "mine.toml")
    shutil.copy(library.shipped_scenes()["watt"], tmp_path / "mine")
    monkeypatch.chdir(tmp_path)
    assert library.load_scene("mine.toml").source == "mine.toml"
    assert library.load_scene("./mine").source == "./mine"
    assert library.load_scene(Path("mine")).source == "mine"
    (tmp_path / "mine.txt").write_bytes((tmp_path / "mine").read_bytes())
    assert library.load_scene("mine.txt").source == "mine.txt"
    refuses(r"no scene \"mine\".* file of that name in this folder write '\./mine'", library.load_scene, "mine")


def test_a_folder_of_results_does_not_hide_the_shipped_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "porter").mkdir()
    monkeypatch.chdir(tmp_path)
    assert library.load_scene("porter").title == "Porter governor, open arms"


def test_a_plain_file_does_not_hide_the_shipped_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(library.shipped_scenes()["watt"], tmp_path / "porter")
    monkeypatch.chdir(tmp_path)
    assert library.load_scene("porter") == library.load_scene(library.shipped_scenes()["porter"])
    assert library.load_scene("./porter").title == library.load_scene("watt").title


@pytest.mark.parametrize("scene", ["nothere.toml", "nothere", "lathe.toml", "folder/other.toml"])
def test_a_name_like_none_gets_no_suggestion(scene: str) -> None:
    with pytest.raises(MechanismError) as caught:
        library.load_scene(scene)
    assert "Did you mean" not in str(caught.value)
    assert ("init MACHINE" in str(caught.value)) == scene.endswith(".toml")  # what a file begins with


def test_a_name_that_is_too_long_is_told() -> None:
    refuses(r"cannot be read \(File name too long\)", library.load_scene, "x" * 5000 + ".toml")


def test_a_package_without_its_models_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "PACKAGE_ROOT", tmp_path / "lib" / "governor_mechanism")
    refuses("shipped scenes are missing", library.models_folder)
    (tmp_path / "lib" / "governor_mechanism" / "models").mkdir(parents=True)
    assert library.models_folder() == tmp_path / "lib" / "governor_mechanism" / "models"
