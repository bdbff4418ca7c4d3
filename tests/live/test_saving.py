"""A scene is saved beside the file that was opened, and nothing else is touched unasked."""

import json
import shutil
import tomllib
from pathlib import Path

import pytest

import governor_mechanism as gm
from governor_mechanism.live.conversation import respond
from governor_mechanism.live.session import Session


@pytest.fixture
def path(tmp_path):
    copy = tmp_path / "mine" / "crank.toml"
    copy.parent.mkdir()
    shutil.copy(gm.load("scott_russell").source, copy)
    return copy


@pytest.fixture
def session(path):
    return Session(gm.load(path))


def save(session, name="", *, overwrites=False):
    answer = respond(session, json.dumps({"action": "save", "name": name, "overwrites": overwrites}))
    assert isinstance(answer, dict)
    return answer


def crank_of(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))["dimensions"]["crank"]


def test_the_opened_file_is_written_with_its_comments(session, path):
    before = path.read_text(encoding="utf-8").splitlines()
    session.change({"dimensions.crank": 1.25})
    assert save(session) == {"saved": f"Saved as {path}.", "question": "", "name": "crank.toml"}
    changed = [(old, new) for old, new in zip(before, path.read_text(encoding="utf-8").splitlines(), strict=True) if old != new]
    assert len(changed) == 1
    assert crank_of(path) == "1.25 m"
    session.change({"dimensions.crank": 1.5})
    assert save(session)["saved"]  # what was written is what is there
    assert crank_of(path) == "1.5 m"


def test_a_file_that_changed_on_disk_is_noticed(session, path):
    path.write_text(path.read_text(encoding="utf-8") + "# of another hand\n", encoding="utf-8")
    session.change({"dimensions.crank": 1.25})
    answer = save(session)
    assert "has changed on disk" in answer["question"]
    assert answer["saved"] == ""
    assert "another hand" in path.read_text(encoding="utf-8")
    assert save(session, overwrites=True)["saved"]
    assert crank_of(path) == "1.25 m"


def test_another_file_is_not_overwritten_unasked(session, path):
    other = path.with_name("other.toml")
    other.write_text("precious", encoding="utf-8")
    assert "is already there" in save(session, "other.toml")["question"]
    assert other.read_text(encoding="utf-8") == "precious"
    assert save(session, "new.toml")["saved"]
    assert gm.load(path.with_name("new.toml")).document == session.document
    assert save(session, "other.toml", overwrites=True)["saved"]
    assert gm.load(other).document == session.document


PATHS = ("../out.toml", "/tmp/out.toml", "sub/out.toml", "..\\out.toml", "C:out.toml")
OTHERS = ("out.py", ".toml", ".hidden.toml", "a\nb.toml", "a\0.toml")


@pytest.mark.parametrize("name", PATHS + OTHERS)
def test_paths_and_other_files_are_refused(session, path, name):
    before = sorted(path.parents[1].rglob("*"))
    assert "is no path" in save(session, name, overwrites=True)["refused"]
    assert sorted(path.parents[1].rglob("*")) == before


def test_a_link_out_of_the_folder_is_refused(session, path):
    outside = path.parents[1] / "outside.toml"
    outside.write_text("precious", encoding="utf-8")
    try:
        path.with_name("link.toml").symlink_to(outside)
    except OSError:
        pytest.skip("this system makes no links")
    assert "link to another place" in save(session, "link.toml", overwrites=True)["refused"]
    assert outside.read_text(encoding="utf-8") == "precious"


def test_a_shipped_scene_is_saved_in_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = Path(gm.load("scott_russell").source)
    before = source.read_bytes()
    session = Session(gm.load("scott_russell"))
    session.change({"dimensions.crank": 1.25})
    assert save(session)["saved"] == f"Saved as {tmp_path / 'scott_russell.toml'}."
    assert source.read_bytes() == before
    assert crank_of(tmp_path / "scott_russell.toml") == "1.25 m"
