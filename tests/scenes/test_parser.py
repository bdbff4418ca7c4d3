"""A scene file becomes the scene it describes; a broken one is refused with every mistake told in a sentence."""

import copy
import datetime
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.part import EQUILIBRIUM, Spindle
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.scenes.parser import MAX_SCENE_FILE_SIZE, parse_scene_document, read_scene_file
from governor_mechanism.scenes.schema import rate_key, start_table
from governor_mechanism.units.problems import Problem
from invalid_scenes.cases import SCENE_HEADER, Case, each_case, format_dimensions, read_cases, scene_text
from refusing import refuses
from scene_documents import governor_document


def document(**changed: Any) -> dict[str, Any]:
    """The Porter scene as Python users write it, in bare SI."""
    whole = governor_document(spindle={"speed": 4 * math.pi}, start={"arm_angle": 0.7}, run={"duration": 10})
    return {key: value for key, value in {**whole, **changed}.items() if value is not None}


def errors_of(text: str, folder: Path) -> tuple[Problem, ...]:
    file = folder / "scene.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(gm.MechanismError) as caught:
        read_scene_file(file)
    assert all(problem.startswith(f"{file}: ") for problem in caught.value.problems)
    return tuple(Problem(problem) for problem in caught.value.problems)


def problems_of(text: str, folder: Path) -> tuple[str, ...]:
    return tuple(problem.removeprefix(f"{folder / 'scene.toml'}: ") for problem in errors_of(text, folder))


def test_a_scene_file_becomes_the_scene_it_describes(tmp_path: Path) -> None:
    file = tmp_path / "porter.toml"
    file.write_text(scene_text(), encoding="utf-8")
    scene = read_scene_file(file)
    assert scene.title == "A Porter governor"
    assert scene.source == str(file)
    assert scene.part.name == "governor"
    assert scene.part.machine == "pendulum_governor"
    assert scene.part.plane == "turning"
    written = {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0}
    assert {name: scene.part.dimensions[name] for name in written} == written
    assert scene.part.mechanism.coordinate == "arm_angle"
    assert scene.effects == (Gravity(acceleration=9.81), Centrifugal())
    assert scene.spindle.speeds == (pytest.approx(4 * math.pi, rel=1e-15),)
    assert scene.start.values == {"arm_angle": pytest.approx(math.radians(40), rel=1e-15)}
    assert scene.start.rates == {}
    assert scene.run == RunSettings(duration=10.0, output_interval=0.01, accuracy=1e-6, engine="auto")
    assert scene.document["dimensions"]["arm"] == "300 mm"


def test_what_is_left_out_takes_its_default(tmp_path: Path) -> None:
    file = tmp_path / "short.toml"
    file.write_text('machine = "pendulum_governor"\n[dimensions]\narm = 0.3\nball_mass = 5\n', encoding="utf-8")
    scene = read_scene_file(str(file))
    assert scene.title == "short"
    assert scene.effects == ()
    assert scene.gravity == 0.0
    assert not scene.has_centrifugal
    assert scene.spindle == Spindle()
    assert scene.start.values == {"arm_angle": EQUILIBRIUM}
    assert scene.run == RunSettings()
    assert scene.part.dimensions["offset"] == 0.0
    assert scene.part.mechanism == PendulumGovernor(arm=0.3, ball_mass=5.0).mechanism()
    assert parse_scene_document({key: scene.document[key] for key in ("machine", "dimensions")}).title == "pendulum_governor"


@pytest.mark.parametrize("start", [None, "", 'arm_angle = "equilibrium"'])
def test_a_start_left_out_is_the_equilibrium(start: str | None, tmp_path: Path) -> None:
    file = tmp_path / "still.toml"
    file.write_text(scene_text(start=start), encoding="utf-8")
    assert read_scene_file(file).start.values == {"arm_angle": EQUILIBRIUM}
    assert read_scene_file(file).start.rates == {}


def test_a_bare_number_within_what_is_built_is_si() -> None:
    heavy = {"arm": 50, "ball_mass": 1e6, "offset": -40, "sleeve_mass": 2}
    scene = parse_scene_document(document(dimensions=heavy, spindle={"speed": 1000}, start=None))
    assert {name: scene.part.dimensions[name] for name in heavy} == heavy
    assert scene.spindle.speeds == (1000.0,)


def test_text_with_its_unit_is_taken_at_its_word() -> None:
    huge = {"arm": "300 m", "ball_mass": "2000 t"}
    scene = parse_scene_document(document(dimensions=huge, spindle={"speed": "3000 rad/s"}, start=None))
    assert (scene.part.dimensions["arm"], scene.part.dimensions["ball_mass"]) == (300.0, 2e6)
    assert scene.spindle.speeds == (3000.0,)


@pytest.mark.parametrize("start", [EQUILIBRIUM, "0.1 m", 0.1])
def test_a_bare_length_at_the_start_is_checked_like_a_dimension(start: object) -> None:
    table = start_table((("lift", "length", "lift_rate"),))
    table.read({"lift": start})
    with pytest.raises(gm.MechanismError) as caught:
        table.read({"lift": 300})
    assert (
        Problem(caught.value.problems[0])
        .at("start")
        .startswith('start.lift = 300 is 300 m; write "300 mm" if that is meant, or "300 m"; or write')
    )


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ({"gravity": False, "centrifugal": False}, ()),
        ({"centrifugal": True, "gravity": "9.80665 m/s^2"}, (Gravity(acceleration=9.80665), Centrifugal())),
        ({"gravity": 1.62}, (Gravity(acceleration=1.62),)),
    ],
)
def test_only_the_effects_switched_on_exist(effects: dict[str, Any], expected: tuple[object, ...]) -> None:
    assert parse_scene_document(document(effects=effects)).effects == expected


def test_a_speed_without_centrifugal_is_allowed() -> None:
    scene = parse_scene_document(document(effects={"gravity": True}))
    assert scene.spindle.speeds == (4 * math.pi,)
    assert not scene.has_centrifugal


def test_a_speed_program_may_step() -> None:
    program = [[0, "60 rpm"], ["5 s", "60 rpm"], [5, "1/s"], ["0.1 min", 3]]
    program[2][1] = "4 1/s"
    spindle = parse_scene_document(document(spindle={"speed": program})).spindle
    assert spindle.times == (0.0, 5.0, 5.0, 6.0)
    assert spindle.speeds == pytest.approx((2 * math.pi, 2 * math.pi, 4.0, 3.0), rel=1e-15)


def test_events_name_crossings_in_the_unit_of_their_reading() -> None:
    events = {"lifted": {"reading": "sleeve", "value": "20 mm", "direction": "up"}, "wide": {"reading": "arm_angle", "value": "45 deg"}}
    assert parse_scene_document(document(events=events)).crossings == (
        NamedCrossing(name="lifted", reading="sleeve_lift", value=0.02, direction="up"),
        NamedCrossing(name="wide", reading="arm_angle", value=math.radians(45), direction="both"),
    )


def test_events_of_several_parts_stand_above_them() -> None:
    whole = dict(gm.load("watt_engine_stable").document)
    whole["events"] = {"fast": {"reading": "sleeve_lift", "value": "20 mm"}}
    refuses(r'events.fast.reading "sleeve_lift" is not a reading; .*governor.sleeve_lift', parse_scene_document, whole)
    whole["part"] = {**whole["part"], "governor": {**whole["part"]["governor"], "events": {}}}
    refuses(r"part\.governor: events stands once for the whole scene", parse_scene_document, whole)


def test_a_start_may_have_a_rate() -> None:
    start = parse_scene_document(document(start={"arm_angle": "equilibrium", "arm_rate": "90 deg/s"})).start
    assert start.values == {"arm_angle": EQUILIBRIUM}
    assert start.rates == {"arm_angle": pytest.approx(math.pi / 2, rel=1e-15)}
    assert parse_scene_document(document(start={"arm_rate": 1})).start.values == {"arm_angle": EQUILIBRIUM}


@pytest.mark.parametrize(("coordinate", "key"), [("arm_angle", "arm_rate"), ("big_arm_angle", "big_arm_rate"), ("lift", "lift_rate")])
def test_the_rate_is_named_after_its_coordinate(coordinate: str, key: str) -> None:
    assert rate_key(coordinate) == key


def test_the_document_kept_is_a_copy_of_any_mapping() -> None:
    given_document = document(dimensions=MappingProxyType({"arm": 0.3, "ball_mass": 5}), spindle={"speed": [[0, 1]]})
    scene = parse_scene_document(MappingProxyType(given_document))
    given_document["spindle"]["speed"][0][1] = 99
    assert scene.document["spindle"] == {"speed": [[0, 1]]}
    assert type(scene.document["dimensions"]) is dict


def test_a_file_with_a_byte_order_mark_and_windows_line_ends_is_read(tmp_path: Path) -> None:
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + scene_text().replace("\n", "\r\n").encode())
    assert read_scene_file(file).title == "A Porter governor"


@each_case("scenes")
def test_every_mistake_of_a_file_is_found_at_its_key_and_told_with_its_cure(case: Case, tmp_path: Path) -> None:
    assert [(problem.code, problem.key) for problem in errors_of(case.text, tmp_path)] == case.mistakes
    assert set(case.messages) <= set(problems_of(case.text, tmp_path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SCENE_HEADER + "title2 = " + "1" * 5000, "not valid TOML"),
        ("a = " + "[" * 100_000, "tables or lists are nested too deeply for a scene"),
        ("#" * MAX_SCENE_FILE_SIZE + "\n", "this file is larger than 1,000,000 bytes; a scene is a page of text"),
    ],
    ids=["a number of 5000 digits", "nested too deeply", "too large"],
)
def test_what_is_too_long_to_be_a_scene_is_refused(text: str, message: str, tmp_path: Path) -> None:
    assert [(problem.code, problem.key) for problem in errors_of(text, tmp_path)] == [("unreadable", "")]
    assert problems_of(text, tmp_path)[0].startswith(message)


@pytest.mark.parametrize(
    ("case", "count"),
    [("misspelt required key", 1), ("link too short", 1), ("missing dimensions", 1), ("several mistakes at once", 8)]
    + [(f"misspelt machine{where}, the rest wrong too", 7) for where in ("", "'s key")]
    + [("unrecognisable machine, the rest wrong too", 5), ("unknown machine", 1), ("bare millimetres", 2)],
)
def test_each_mistake_is_told_once(case: str, count: int, tmp_path: Path) -> None:
    assert len(problems_of(read_cases("scenes")[case].text, tmp_path)) == count


@pytest.mark.parametrize("machine", ['"pendulum_govenor"', '"xyzzy"', "3"])
def test_a_wrong_machine_is_the_first_mistake_told(machine: str, tmp_path: Path) -> None:
    text = scene_text(f"title = 3\nmachine = {machine}\n", format_dimensions(arm="0"), run="output_interval = 0")
    first, *others = problems_of(text, tmp_path)
    assert first.startswith(f"machine {machine} is unknown")
    assert len(others) == (3 if "pendulum" in machine else 2)


def test_every_scene_that_the_broken_ones_vary_is_itself_whole(tmp_path: Path) -> None:
    (tmp_path / "whole.toml").write_text(scene_text(SCENE_HEADER, format_dimensions()), encoding="utf-8")
    assert read_scene_file(tmp_path / "whole.toml").part.dimensions["arm"] == 0.3


def test_text_in_another_encoding_is_told_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "latin.toml"
    file.write_bytes('machine = "pendulum_governor"\ntitle = "Läufer"\n'.encode("latin-1"))
    refuses("line 2 is not UTF-8 text; save the file as UTF-8", read_scene_file, file)


def test_a_folder_is_no_scene(tmp_path: Path) -> None:
    refuses(r"this is a folder, not a scene file; it holds no \.toml files", read_scene_file, tmp_path)
    (tmp_path / "porter.toml").write_text("", encoding="utf-8")
    refuses(r"it holds porter\.toml", read_scene_file, tmp_path)


def test_a_missing_file_is_told_with_the_nearest_name(tmp_path: Path) -> None:
    (tmp_path / "porter.toml").write_text("", encoding="utf-8")
    refuses(r"portr\.toml: no such file\. Did you mean '.*porter\.toml'\?", read_scene_file, tmp_path / "portr.toml")
    refuses("there is no folder", read_scene_file, tmp_path / "nowhere" / "porter.toml")


def test_a_file_without_permission_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "locked.toml"
    file.write_text(scene_text(), encoding="utf-8")

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    # Rights on disk do not stop the superuser, who may be running these tests.
    monkeypatch.setattr(Path, "open", refuse)
    refuses(r"locked\.toml: no permission to read this file", read_scene_file, file)


@pytest.mark.parametrize("wrong", [None, 3, "text", [], [("machine", "pendulum_governor")]])
def test_a_document_that_is_no_table_is_refused(wrong: Any) -> None:
    refuses("a scene is a table of keys", parse_scene_document, wrong)


def test_messages_of_a_document_without_a_source_begin_with_the_key() -> None:
    with pytest.raises(gm.MechanismError) as caught:
        parse_scene_document(document(dimensions={"arm": 0.3, "ball_mass": None, 5: 1}))
    assert caught.value.problems[0].startswith("dimensions.ball_mass is a mass; found None")
    assert len(caught.value.problems) == 2


LENGTHS = st.integers(min_value=100, max_value=2000)  # in mm
MASSES = st.integers(min_value=1, max_value=50_000)  # in g


@given(arm=LENGTHS, offset=st.integers(min_value=-99, max_value=500), ball=MASSES, sleeve=MASSES)
def test_a_scene_is_the_same_in_millimetres_metres_and_bare_numbers(arm: int, offset: int, ball: int, sleeve: int) -> None:
    lengths, masses = {"arm": arm, "offset": offset}, {"ball_mass": ball, "sleeve_mass": sleeve}
    both = [(lengths, ("mm", "cm", "m"), (1, 10, 1000)), (masses, ("g", "kg", "t"), (1, 1000, 1_000_000))]
    read_dimensions = []
    for choice in range(3):
        written = {k: f"{v / per[choice]!r} {units[choice]}" for group, units, per in both for k, v in group.items()}
        read_dimensions.append(parse_scene_document(document(dimensions=written, start=None)).part.dimensions)
    bare = {k: v / 1000 for group, *_ in both for k, v in group.items()}
    read_dimensions.append(parse_scene_document(document(dimensions=bare, start=None)).part.dimensions)
    for other in read_dimensions:
        # Division before writing rounds once; the reading itself does not.
        assert {name: other[name] for name in bare} == pytest.approx(bare, rel=4e-16, abs=0)


LEAVES = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=12),
    st.datetimes(),
    st.just(datetime.date(1877, 1, 1)),
    st.sampled_from(["300 mm", "5 kg", "40 deg", "120 rpm", "10 s", "0.7 rad", "equilibrium", "auto", "-1 m", "2 Hz"]),
)
JUNK = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3))
KEYS = {
    "dimensions": ["arm", "offset", "ball_mass", "sleeve_mass", "arm_joint", "link", "lug_offset", "arms"],
    "effects": ["gravity", "centrifugal", "rods", "spring", "dry_friction", "dashpot", "stops", "clearance", "wind"],
    "spindle": ["speed", "inertia", "speed_fluctuation", "cycles_per_turn"],
    "start": ["arm_angle", "arm_rate", "arm_angel", "sleeve_clearance"],
    "run": ["duration", "output_interval", "accuracy", "engine", "step"],
}
JUNK_TABLES = {name: st.dictionaries(st.sampled_from(keys) | st.text(max_size=5), JUNK, max_size=4) | JUNK for name, keys in KEYS.items()}
JUNK_DOCUMENTS = st.fixed_dictionaries(
    {}, optional={"machine": st.just("pendulum_governor") | JUNK, "title": JUNK, "more": JUNK, **JUNK_TABLES}
)


def reads_or_refuses(junk: dict[str, Any]) -> None:
    problems: tuple[str, ...] = ("junk.toml: nothing",)
    try:
        parse_scene_document(junk, "junk.toml")
    except gm.MechanismError as error:
        problems = error.problems
    assert problems
    assert all(problem.startswith("junk.toml: ") for problem in problems)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(JUNK_DOCUMENTS)
def test_any_document_is_read_or_refused_in_sentences(junk: dict[str, Any]) -> None:
    reads_or_refuses(junk)


@given(st.sampled_from([(table, key) for table, keys in KEYS.items() for key in keys]), JUNK)
def test_any_value_in_an_otherwise_good_scene_is_read_or_refused(place: tuple[str, str], junk: Any) -> None:
    whole = copy.deepcopy(document())
    whole[place[0]][place[1]] = junk
    reads_or_refuses(whole)


ACTING = st.dictionaries(st.sampled_from(["sleeve", "arm_angle", "restitution"]) | st.text(max_size=5), JUNK, max_size=3)
PARTS = ["rate", "preload", "wire", "coil", "turns", "modulus", "linear", "quadratic", "piston", "hole", "screw", "oil"]
INNER = st.dictionaries(st.sampled_from([*PARTS, "width", "arm_mass", "ball_radius"]), LEAVES, max_size=5)


@given(st.sampled_from(KEYS["effects"][2:8]), ACTING | INNER | st.dictionaries(st.just("sleeve"), INNER))
def test_any_effect_in_an_otherwise_good_scene_is_read_or_refused(key: str, junk: Any) -> None:
    whole = copy.deepcopy(document())
    whole["effects"][key] = junk
    reads_or_refuses(whole)


@given(st.dictionaries(st.sampled_from(KEYS["dimensions"][:7]), st.floats(), max_size=7))
def test_any_numbers_for_dimensions_are_read_or_refused(numbers: dict[str, float]) -> None:
    reads_or_refuses(document(dimensions={"arm": 0.3, "ball_mass": 5.0, **numbers}))


@given(st.binary(max_size=200))
def test_any_bytes_are_refused_in_one_sentence(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    file = tmp_path_factory.getbasetemp() / "junk.toml"
    file.write_bytes(content)
    with pytest.raises(gm.MechanismError):
        read_scene_file(file)


def test_importing_the_reader_stays_light() -> None:
    code = (
        "import sys, governor_mechanism.scenes.parser, governor_mechanism.scenes.library; "
        "print([m for m in ('pint', 'pymunk', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a" + ".a" * 50_000 + " = 1", "a key has 100 dots or more"),
        ("[a" + ' . "a"' * 50_000 + "]\nx = 1", "a key has 100 dots or more"),
        ("a = " + "[" * 100_000 + "]" * 100_000, "nested too deeply"),
        ("a = " + "{a = " * 50_000 + "1" + "}" * 50_000, "nested too deeply"),
        ('title = "' + "x" * 100_000 + '"', "title must be one line of text, at most 200 characters; found"),
        ('title = "a\\nb"', "title must be one line of text"),
        ('title = "\\u001b[31m"', "title must be one line of text"),
        ('title = "\\u009b31m"', "title must be one line of text"),
        ("arm = 0x" + "f" * 5000, "arm is unknown"),
        ("[dimensions]\narm = 0x" + "f" * 5000, "an integer of more than 100 digits"),
    ],
    ids=lambda value: value[:12],
)
def test_texts_that_no_scene_has_are_refused_at_once(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "hard.toml").write_text('machine = "pendulum_governor"\n' + text, encoding="utf-8")
    with pytest.raises(gm.MechanismError) as caught:
        read_scene_file(tmp_path / "hard.toml")
    assert sentence in str(caught.value)
    assert all(len(problem) < 2000 for problem in caught.value.problems)


def test_messages_hold_no_control_characters(tmp_path: Path) -> None:
    text = '"a\\u001b[31m\\u009b\\nb" = 1\nmachine = "\\u001b]0;x\\u0007"\n["d\\u001b"]\n[dimensions]\n"\\u001barm" = "\\u009b3m"\n'
    (tmp_path / "coloured.toml").write_text(text, encoding="utf-8")
    with pytest.raises(gm.MechanismError) as caught:
        read_scene_file(tmp_path / "coloured.toml")
    assert len(caught.value.problems) == str(caught.value).count("\n") + 1
    assert str(caught.value).replace("\n", "").isprintable()
    assert "a\\x1b[31m\\x9b\\x0ab is unknown" in str(caught.value)


def test_a_pipe_a_device_and_a_large_file_are_refused_without_being_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    for path in (tmp_path / "pipe.toml", Path("/dev/zero")):
        refuses("this is not a file on disk but a pipe or a device", read_scene_file, path)
    with (tmp_path / "large.toml").open("wb") as stream:
        stream.truncate(100_000_000)
    refuses("larger than 1,000,000 bytes", read_scene_file, tmp_path / "large.toml")
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)) * 100)
    refuses("is not UTF-8 text", read_scene_file, tmp_path / "binary.toml")


def test_many_unknown_keys_are_summed_up_and_long_ones_shortened(tmp_path):
    long_key = "x" * 10_000
    lines = [*(f"k{number} = 1" for number in range(500)), f"{long_key} = 1", "[dimensions]", f"{long_key} = 1"]
    problems = problems_of('title = "t"\nmachine = "pendulum_governor"\n' + "\n".join(lines), tmp_path)
    unknown = [problem for problem in problems if "unknown" in problem]
    assert sum("is unknown" in problem for problem in unknown) == 11  # ten of the file, and that of [dimensions]
    assert any(problem.endswith("491 more keys are unknown") for problem in unknown)
    assert any(re.search(r"dimensions\.x{40,60}\.\.\.x{20} is unknown; known keys are arm", problem) for problem in unknown)
    assert max(map(len, problems)) < 400
