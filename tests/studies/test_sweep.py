"""Sweeps: rows that depend on nothing but their values, files that do not tell how they came about, refusals."""

import json
import math
import signal
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.render.figures.sweep import sweep_figure
from governor_mechanism.scenes.changed_document import replace_document_value
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep import workers
from governor_mechanism.studies.sweep.parameters import MAX_SWEEP_ROWS, parse_axes
from governor_mechanism.studies.sweep.quantities import find_reading_units
from governor_mechanism.studies.sweep.run import compute_row
from governor_mechanism.units.quantities import QUANTITY_KINDS
from refusing import refuses
from scene_documents import governor_document

DOCUMENT = governor_document(
    title="Porter",
    spindle={"speed": "120 rpm"},
    start={"arm_angle": "40 deg"},
    run={"duration": "0.2 s", "output_interval": "20 ms", "accuracy": 1e-5, "engine": "multibody"},
)

ARMS, MASSES = "dimensions.arm=250mm:350mm:3", "dimensions.sleeve_mass=15kg,20kg,25kg"

EXTREMES = ["final arm_angle", "min arm_angle", "max arm_angle"]

REFUSED = "dimensions.link=100mm,300mm"
"""With arms of 300 mm the shorter link cannot reach where the governor starts."""


@pytest.fixture(scope="module")
def scene():
    return parse_scene_document(DOCUMENT, "porter.toml")


@pytest.fixture(scope="module")
def grid(scene):
    return gm.sweep(scene, [ARMS, MASSES], ["max arm_angle", "rate of sleeve_lift", "duration"])


def problems_of(*words, **options):
    with pytest.raises(gm.MechanismError) as caught:
        gm.sweep(*words, **options)
    return caught.value.problems


def test_rows_are_those_of_single_runs(scene, grid):
    assert grid.shape == (3, 3)
    assert grid.ok
    assert grid.outcomes == {"ok": 9}
    assert [axis.unit for axis in grid.axes] == ["m", "kg"]
    for row in grid.rows:
        arm, mass = grid.values_at(row.index)
        dimensions = DOCUMENT["dimensions"] | {"arm": arm, "sleeve_mass": mass}
        run = gm.run(parse_scene_document(DOCUMENT | {"dimensions": dimensions}), certify=False)
        assert row.numbers == (np.max(run.readings["arm_angle"]), run.rates["sleeve_lift"][-1], 0.2)


def test_columns_and_grids_have_the_shape_of_the_axes(grid):
    assert grid.column("dimensions.arm").tolist() == [0.25] * 3 + [0.3] * 3 + [0.35] * 3
    assert grid.grid("dimensions.sleeve_mass")[0].tolist() == [15.0, 20.0, 25.0]
    largest = grid.grid("max arm_angle")
    assert largest.shape == (3, 3)
    assert largest[2, 1] == grid.rows[7].numbers[0]
    refuses("Did you mean 'max arm_angle'", grid.column, "max arm_angel")
    told = json.loads(json.dumps(grid.as_json(), allow_nan=False))
    assert told["rows"][7]["values"] == [0.35, 20.0]
    assert told["quantities"][1] == {"name": "rate of sleeve_lift", "unit": "m/s"}
    assert "dimensions.arm" in str(grid)


def test_the_scene_itself_stays_as_it_was(scene):
    before = json.dumps(scene.document)
    gm.sweep(scene, {"dimensions.link": ["310 mm"], "effects.dashpot.sleeve": [20.0]}, ["duration"])
    assert json.dumps(scene.document) == before


def listing(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


class StopError(Exception):
    """An interruption."""


def stop_after(rows):
    def progress(done, total):
        if done >= rows:
            raise StopError

    return progress


@pytest.mark.long
def test_files_are_the_same_by_one_worker_by_two_and_interrupted(scene, tmp_path, monkeypatch):
    vary = [ARMS, MASSES, REFUSED]
    whole = gm.sweep(scene, vary, out=tmp_path / "one")
    with monkeypatch.context() as eager:
        eager.setattr(workers, "TRIAL_TIME", 0.0)
        eager.setattr(workers, "PROCESS_START_TIME", 0.0)
        gm.sweep(scene, vary, out=tmp_path / "two", workers=2)
    for rows in (1, 7):
        with pytest.raises(StopError):
            gm.sweep(scene, vary, out=tmp_path / "parts", progress=stop_after(rows))
        journal = tmp_path / "parts" / "porter_sweep.part"
        assert list(listing(tmp_path / "parts")) == [journal.name]
        with journal.open("a", encoding="utf-8") as stream:
            stream.write("[17, [0.1, 0.")  # a line half written
    seen = []
    resumed = gm.sweep(scene, vary, out=tmp_path / "parts", progress=lambda done, total: seen.append((done, total)))
    assert seen[0][0] >= 7
    assert seen[-1] == (18, 18)
    assert sorted(listing(tmp_path / "one")) == ["porter_sweep.csv", "porter_sweep.json"]
    assert listing(tmp_path / "one") == listing(tmp_path / "two") == listing(tmp_path / "parts")
    assert str(resumed) == str(whole)


def test_processes_start_only_where_they_save_more_than_their_start(scene, monkeypatch):
    shared = []
    rows_of = workers.compute_chunk
    monkeypatch.setattr(
        workers, "_share_with_processes", lambda function, chunks, n: shared.append(n) or (rows_of(function, one) for one in chunks)
    )
    found = gm.sweep(scene, [ARMS, MASSES], EXTREMES, workers=2)
    assert shared == []  # nine rows of some milliseconds
    monkeypatch.setattr(workers, "TRIAL_TIME", 0.0)
    monkeypatch.setattr(workers, "PROCESS_START_TIME", 0.0)
    assert list(gm.sweep(scene, [ARMS, MASSES], EXTREMES, workers=2).rows) == list(found.rows)
    assert shared == [1]  # beside this one


def test_chunks_hold_every_index_once_and_keep_all_workers_busy():
    for n_rows, n_workers in ((1, 2), (17, 2), (400, 2), (100_000, 3)):
        chunks = list(workers.make_chunks(range(n_rows), n_workers))
        assert [index for chunk in chunks for index in chunk] == list(range(n_rows))
        assert len(chunks) >= min(n_rows, workers.CHUNKS_PER_WORKER * n_workers)
        assert max(map(len, chunks)) <= workers.MAX_CHUNK_ROWS


def test_a_sweep_that_is_done_is_read_back(scene, tmp_path, monkeypatch):
    vary = [MASSES, REFUSED]
    first = gm.sweep(scene, vary, EXTREMES, out=tmp_path)
    files = listing(tmp_path)
    monkeypatch.setattr("governor_mechanism.studies.sweep.run.compute_row", None)
    second = gm.sweep(scene, vary, EXTREMES, out=tmp_path)
    assert listing(tmp_path) == files
    np.testing.assert_array_equal(first.column("min arm_angle"), second.column("min arm_angle"))
    assert [row.message for row in first.rows] == [row.message for row in second.rows]


def test_a_folder_with_another_sweep_is_refused(scene, tmp_path):
    gm.sweep(scene, [MASSES], ["duration"], out=tmp_path)
    told = problems_of(scene, ["dimensions.sleeve_mass=15kg,20kg"], ["duration"], out=tmp_path)
    assert "belongs to another sweep (different values of the keys)" in told[0]
    other = parse_scene_document(DOCUMENT | {"spindle": {"speed": "121 rpm"}}, "porter.toml")
    assert "different scene" in problems_of(other, [MASSES], ["duration"], out=tmp_path)[0]
    assert "different quantities, accuracy" in problems_of(scene, [MASSES], accuracy=1e-4, out=tmp_path)[0]
    (tmp_path / "porter_sweep.json").write_text("[]", encoding="utf-8")
    assert "is not the file of a sweep" in problems_of(scene, [MASSES], ["duration"], out=tmp_path)[0]
    (tmp_path / "porter_sweep.json").unlink()
    assert "the record of its sweep is missing" in problems_of(scene, [MASSES], ["duration"], out=tmp_path)[0]
    assert "is a file" in problems_of(scene, [MASSES], ["duration"], out=tmp_path / "porter_sweep.csv")[0]


def test_a_journal_of_another_sweep_is_refused(scene, tmp_path):
    with pytest.raises(StopError):
        gm.sweep(scene, [MASSES], ["duration"], out=tmp_path, progress=stop_after(1))
    assert "porter_sweep.part belongs to another" in problems_of(scene, [ARMS], ["duration"], out=tmp_path)[0]


def test_rows_that_cannot_be_made_or_end_early_say_so_and_stop_no_other(scene):
    speeds = "spindle.speed=120rpm,300rpm"
    found = gm.sweep(scene, [REFUSED, speeds], ["final arm_angle", "duration"])
    assert [row.outcome for row in found.rows] == ["refused", "refused", "ok", "left_range"]
    refused, _, fine, early = found.rows
    assert "it is too short" in refused.message
    assert all(map(math.isnan, refused.numbers))
    assert fine.message == ""
    assert "90 degrees" in early.message
    assert math.isnan(early.numbers[0])  # its last value is not the final one
    assert 0 < early.numbers[1] < 0.2
    assert not found.ok
    assert found.as_json()["rows"][0]["numbers"] == [None, None]
    assert "2 of 4 rows could not be run: start.arm_angle (40 deg) lies outside the travel" in str(found)
    # Arm and link are equally long and reach their limits together: rounding decides which is first.
    ends = "arm_angle: the arms are", "link_angle: the link is"
    assert any(
        f"1 of 4 rows reached the end of the range of {end} at 90 degrees to the spindle (dead centre)" in str(found) for end in ends
    )


def faulty(run):
    return 1.0 / (run.scene.part.dimensions["sleeve_mass"] - 20.0)


def endless(run):
    return math.inf


def test_a_fault_in_one_row_is_told_there(scene):
    found = gm.sweep(scene, [MASSES], {"mine": faulty})
    assert [row.outcome for row in found.rows] == ["ok", "failed", "ok"]
    assert found.rows[1].message == "ZeroDivisionError: float division by zero"
    assert found.column("mine")[[0, 2]].tolist() == [-0.2, 0.2]
    assert "is not a finite number: inf" in gm.sweep(scene, [MASSES], {"mine": endless}).rows[0].message


def swallowing(run):
    """As libraries do that an interrupt strikes in a callback."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ValueError("something went wrong") from None


def test_an_interrupt_that_a_row_swallowed_still_ends_the_sweep_and_leaves_no_row(scene, tmp_path):
    inherited = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell starts jobs in the background with the signal ignored
    try:
        with pytest.raises(KeyboardInterrupt):
            gm.sweep(scene, [MASSES], {"mine": swallowing}, out=tmp_path)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, inherited)
    assert (tmp_path / "porter_sweep.part").read_text(encoding="utf-8").count("\n") == 1


def test_quantities_are_taken_as_their_names_say(scene):
    names = {
        "final": "arm_angle",
        "low": "min arm_angle",
        "span": "span arm_angle",
        "rise": "max rate of sleeve_lift",
        "torque": "min spindle_torque",
        "error": "error_estimate",
    }
    found = gm.sweep(scene, {"dimensions.arm": [0.3]}, names, certify=True)
    run = gm.run(scene)
    arm = run.readings["arm_angle"]
    expected = [arm[-1], arm.min(), np.ptp(arm), run.rates["sleeve_lift"].max(), run.readings["spindle_torque"].min()]
    assert found.rows[0].numbers == (*expected, run.error_estimate)
    assert list(found.units.values()) == ["m", "rad", "rad", "rad", "m/s", "N m", ""]
    assert found.outcomes == {"done": 1}


@pytest.mark.parametrize("name", ["porter", "porter_free_spindle", "quick_return"])
def test_readings_are_known_before_the_run(name):
    scene = gm.load(name)
    run = gm.run(scene, engine="multibody", accuracy=1e-3, times=[0.0, 0.01], certify=False)
    assert find_reading_units(scene) == dict(run.units)


def test_a_key_that_changes_no_quantity_is_noted():
    """The balls of a governor without a loaded sleeve swing alike, whatever their mass."""
    dimensions = {key: value for key, value in DOCUMENT["dimensions"].items() if key != "sleeve_mass"}
    watt = parse_scene_document(DOCUMENT | {"dimensions": dimensions, "spindle": {"speed": "65 rpm"}})
    found = gm.sweep(watt, ["dimensions.ball_mass=1kg:9kg:3", "dimensions.arm=290mm,300mm"], ["final arm_angle"])
    assert found.notes == ("dimensions.ball_mass changes final arm_angle by less than the accuracy",)
    assert found.notes[0] in str(found)


def test_what_is_no_key_is_refused(scene):
    assert "3 is not a key of a scene" in problems_of(scene, {3: [1.0]})[0]


def test_all_mistakes_are_told_at_once(scene):
    told = problems_of(
        scene,
        ["dimensions.amr=1,2", "run.accuracy=1e-3,1e-4", "dimensions.arm=0.2,0.3", "dimensions.arm=0.4"],
        ["fnal arm_angle", "rate of spindle_speed", "error_estimate", "duration", "duration"],
        engine="multibdy",
        accuracy=2.0,
        workers=0,
    )
    for sentence in (
        "dimensions.amr is unknown",
        "dimensions.arm is given 2 times",
        "Did you mean 'final arm_angle'",
        'quantity "rate of spindle_speed" is unknown',
        "'error_estimate' needs certified runs",
        "quantity 'duration' is listed twice",
        "Did you mean 'multibody'",
        "accuracy must lie between 0 and 1",
        "workers must be a whole number",
    ):
        assert sum(sentence in line for line in told) == 1, sentence
    assert len(told) == 9


def test_a_key_and_an_option_that_replaces_it_are_refused(scene):
    told = problems_of(scene, ["run.engine=multibody,impulse"], engine="multibody")
    assert told == ("vary: run.engine has no effect if it is also given for all rows; leave one of the two out",)


def test_of_many_wrong_values_a_few_are_told(scene):
    told = problems_of(scene, [f"dimensions.arm={','.join(f'{k} kg' for k in range(1, 100))}"])
    assert len(told) == 4
    assert told[3] == "vary: dimensions.arm has more values; they are not checked"


def test_too_many_rows_are_refused_before_they_are_made(scene):
    told = problems_of(scene, ["dimensions.arm=200mm:300mm:10000", "dimensions.sleeve_mass=5kg:9kg:10000"])
    assert told == (f"vary: 100,000,000 rows are too many (at most {MAX_SWEEP_ROWS:,}); take fewer values of a key",)


def test_functions_that_no_process_could_have_are_refused(scene):
    assert "define the function with def" in problems_of(scene, [ARMS], {"mine": lambda run: 1.0})[0]


def test_a_scene_that_is_not_what_its_document_says_is_refused(scene):
    assert "was not loaded from a file" in problems_of(replace(scene, document={}), [ARMS])[0]
    changed = scene.with_changes(spindle=replace(scene.spindle, speeds=(13.0,)))
    assert "was changed after loading" in problems_of(changed, [ARMS])[0]
    shorter = replace(scene, run=replace(scene.run, duration=0.1))  # a run's settings are taken over
    assert gm.sweep(shorter, [MASSES], ["duration"]).column("duration").tolist() == [0.1] * 3


@pytest.mark.parametrize(
    ("name", "key", "kind"),
    [
        ("porter", "dimensions.link", "length"),
        ("porter", "effects.gravity", "acceleration"),
        ("porter", "effects.dashpot.sleeve", "damping"),
        ("porter", "effects.dry_friction.arm_angle", "torque"),
        ("porter", "effects.spring.sleeve.rate", "stiffness"),
        ("porter", "effects.rods.arm_mass", "mass"),
        ("porter", "effects.clearance", "length"),
        ("porter", "spindle.speed", "angular_speed"),
        ("porter", "spindle.speed_fluctuation", "ratio"),
        ("porter", "start.arm_rate", "angular_rate"),
        ("porter", "run.duration", "time"),
        ("porter_free_spindle", "spindle.inertia", "moment_of_inertia"),
        ("quick_return", "body.crank.mass", "mass"),
        ("quick_return", "body.1.disc.radius", "length"),
        ("quick_return", "force.cut.damping", "damping"),
    ],
)
def test_keys_take_values_of_their_kind(name, key, kind):
    """Whether or not they stand in the file; what carries the wrong unit is refused by that kind's name."""
    document = gm.load(name).document
    example = QUANTITY_KINDS[kind].example
    (axis,) = parse_axes(document, {key: [example if QUANTITY_KINDS[kind].units else float(example)]})
    assert axis.kind == kind
    assert axis.unit == QUANTITY_KINDS[kind].si_unit
    refuses(f"is {QUANTITY_KINDS[kind].name};", parse_axes, document, {key: ["3 K"]})


def test_words_and_switches_may_be_varied(scene):
    found = gm.sweep(scene, ["run.engine=multibody,impulse", "effects.dashpot.sleeve=false,20 N s/m"], ["arm_angle"])
    assert found.column("run.engine").tolist() == ["multibody"] * 2 + ["impulse"] * 2
    assert found.grid("arm_angle")[0] == pytest.approx(found.grid("arm_angle")[1], abs=1e-5)
    (axis,) = parse_axes(scene.document, ["start.arm_angle=equilibrium,30deg"])
    assert axis.values == ("equilibrium", pytest.approx(math.radians(30), rel=1e-15))


def test_items_of_lists_are_meant_by_name_or_number():
    document = {"body": [{"name": "crank", "mass": 1.0}, {"name": "rod", "mass": 2.0}]}
    assert replace_document_value(document, "body.rod.mass", 3.0)["body"][1] == {"name": "rod", "mass": 3.0}
    assert replace_document_value(document, "body.1.mass", 3.0)["body"][0]["mass"] == 3.0
    assert document["body"][1]["mass"] == 2.0
    refuses(r'body has no "crnk"; .* Did you mean .crank.', replace_document_value, document, "body.crnk.mass", 3.0)


def test_values_of_a_grid_are_those_a_person_would_write():
    scene = gm.load("porter")
    (axis,) = parse_axes(scene.document, ["dimensions.arm=280 mm:360 mm:5"])
    assert axis.values == (0.28, 0.3, 0.32, 0.34, 0.36)


def test_large_numbers_with_a_unit_are_taken_at_their_word(scene):
    """60 m is beyond what a bare number is believed, but it stands there with its unit."""
    (axis,) = parse_axes(scene.document, ["dimensions.link=40 m:60 m:3"])
    assert axis.values == (40.0, 50.0, 60.0)
    assert axis.document_values == (40.0, 50.0, "60.0 m")


def test_rows_do_not_depend_on_their_company(scene, monkeypatch):
    tasks = []
    monkeypatch.setattr("governor_mechanism.studies.sweep.run.compute_row", lambda task, index: _noted(tasks, task, index))
    whole = gm.sweep(scene, [ARMS, MASSES], EXTREMES)
    assert [compute_row(tasks[0], index) for index in (7, 2)] == [whole.rows[7], whole.rows[2]]


def _noted(tasks, task, index):
    tasks.append(task)
    return compute_row(task, index)


@pytest.mark.long
@pytest.mark.parametrize(
    "vary",
    [
        ["dimensions.arm=250mm:350mm:4"],
        ["effects.dashpot.sleeve=1 N s/m,1000 N s/m"],
        ["run.engine=multibody,impulse"],
        [REFUSED, MASSES],
        [ARMS, "run.engine=multibody"],
        [REFUSED, "spindle.speed=120rpm,300rpm", "dimensions.sleeve_mass=20kg,25kg"],
    ],
)
def test_figures_are_written(scene, vary, tmp_path):
    found = gm.sweep(scene, vary, ["max arm_angle", "max sleeve_lift", "duration"])
    first = sweep_figure(found).save(tmp_path / "sweep.png").read_bytes()
    assert first.startswith(b"\x89PNG")
    if len(found.axes) == 2:  # a map with everything that a curve has
        assert sweep_figure(found).save(tmp_path / "again.png").read_bytes() == first


@pytest.mark.long
def test_a_map_tells_how_rows_ended_and_marks_the_scene(scene):
    found = gm.sweep(scene, ["spindle.speed=110rpm:300rpm:5", "dimensions.sleeve_mass=15kg:25kg:5"], ["max sleeve_lift"])
    page = sweep_figure(found)
    key = " ".join(text.get_text() for text in page.legends[0].get_texts()).replace("\n", " ")
    # Arm and link are equally long and reach their limits together: rounding decides which is first.
    for ending in found.endings:
        assert f"{ending.count} of 25 rows reached the end of the range of" in key
        assert "at 90 degrees" in key
    assert "the scene itself: 120 rpm, 20 kg" in key
    ended = sorted(index for ending in found.endings for index in ending.rows.tolist())
    assert ended == [row.index for row in found.rows if row.outcome == "left_range"] != []


def test_a_key_knows_the_value_of_the_scene(scene):
    keys = {
        "dimensions.arm": [0.2, 0.3],
        "spindle.speed": ["110 rpm"],
        "dimensions.link": [0.31],
        "start.arm_angle": ["equilibrium", "40 deg"],
    }
    found = {axis.key: axis.scene_value for axis in parse_axes(scene.document, keys)}
    assert found == {
        "dimensions.arm": 0.3,
        "spindle.speed": pytest.approx(4 * math.pi, rel=1e-15),
        "dimensions.link": None,
        "start.arm_angle": pytest.approx(math.radians(40), rel=1e-15),
    }
    (axis,) = parse_axes(gm.load("quick_return").document, {"body.crank.mass": [1.0, 2.0]})
    assert isinstance(axis.scene_value, float)


def test_figures_of_nothing_and_of_too_many_keys(scene, tmp_path):
    empty = gm.sweep(scene, ["dimensions.link=100mm,110mm", MASSES])
    assert empty.outcomes == {"refused": 6}
    assert sweep_figure(empty).save(tmp_path / "empty.png").stat().st_size > 0
    four = gm.sweep(scene, [REFUSED, "run.output_interval=20ms", "run.duration=0.2", "start.arm_angle=0.7"])
    refuses("at most 3 keys, and this sweep varies 4", sweep_figure, four)
    refuses("must end in", sweep_figure(empty).save, tmp_path / "empty.gif")


def test_every_row_is_the_run_of_its_scene_without_certificate():
    """To the last digit, also of rows that end early."""
    document = DOCUMENT | {"run": {"duration": "0.5 s", "output_interval": "10 ms", "accuracy": 1e-8, "engine": "reduced"}}
    vary = {"dimensions.arm": [0.29, 0.33], "dimensions.sleeve_mass": [12.0, 45.0, 90.0], "spindle.speed": ["120 rpm", "-13 rad/s"]}
    taken = ["final arm_angle", "min sleeve_lift", "max rate of ball_radius", "max spindle_torque", "duration"]
    found = gm.sweep(parse_scene_document(document, "porter.toml"), vary, taken)
    assert set(found.outcomes) == {"ok", "left_range"}  # a heavy sleeve falls to where arms and links stand in line
    for row in found.rows:
        arm, mass, speed = found.values_at(row.index)
        dimensions = document["dimensions"] | {"arm": arm, "sleeve_mass": mass}
        run = gm.run(parse_scene_document(document | {"dimensions": dimensions, "spindle": {"speed": speed}}), certify=False)
        angle, lift, torque = (run.readings[name] for name in ("arm_angle", "sleeve_lift", "spindle_torque"))
        numbers = [angle[-1], lift.min(), run.rates["ball_radius"].max(), torque.max()]
        has_final_values = run.outcome is gm.Outcome.NOT_CERTIFIED
        assert row.outcome == ("ok" if has_final_values else run.outcome.name.lower())
        assert row.message == ("" if has_final_values else run.message)
        np.testing.assert_array_equal(row.numbers, [*(numbers if has_final_values else [math.nan] * 4), run.times[-1]])
