"""The command as a person uses it: what it prints, what it writes, how it ends."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import governor_mechanism
from command_line import invoke, json_of, succeed
from governor_mechanism.cli.console import InterruptHandler
from governor_mechanism.cli.main import main
from governor_mechanism.files.results import format_run
from governor_mechanism.scenes.library import shipped_scenes

MODELS = Path(__file__).parents[2] / "models"
COMMAND = [sys.executable, "-m", "governor_mechanism.cli.main"]

EAGER_COMMAND = [
    *(sys.executable, "-c"),
    """from governor_mechanism.cli.main import main
from governor_mechanism.studies.sweep import workers
workers.TRIAL_TIME = workers.PROCESS_START_TIME = 0.0
main()""",
]
"""The command, which here starts processes for a sweep even where they do not pay."""


def call_main(monkeypatch, capfd, *words: str) -> tuple[int, str, str]:
    """Return exit status, output and messages of the whole command, also what is not written by Python."""
    monkeypatch.setattr(sys, "argv", ["governor-mechanism", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    return stop.value.code, *capfd.readouterr()


@pytest.fixture
def one_timing(monkeypatch):
    """Let studies time everything once, not until a quiet machine shows the shortest time."""
    monkeypatch.setattr("governor_mechanism.studies.work_precision.MIN_REPEATS", 1)
    monkeypatch.setattr("governor_mechanism.studies.work_precision.MIN_TIMING_DURATION", 0.0)
    monkeypatch.setattr("governor_mechanism.studies.effect_ablation.N_TIMED_RUNS", 1)


def short_scene(folder: Path, **changes: str) -> Path:
    """The shipped Porter scene, a second long."""
    text = (MODELS / "porter.toml").read_text(encoding="utf-8").replace('duration = "10 s"', 'duration = "1 s"')
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / "short.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_models_lists_every_shipped_scene_in_its_family():
    lines = succeed("models").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    groups = {}
    for line in lines:
        if line.endswith(":") and not line.startswith(" "):
            groups[line.removesuffix(":")] = names = []
        elif line[2:3].strip():  # other lines go on with a title
            names.append(line.split()[0])
    assert sorted(name for names in groups.values() for name in names) == list(shipped_scenes())
    families = {"porter": "governors", "watt_engine_stable": "governed engines", "air_engine": "engines", "andrews_squeezer": "linkages"}
    for name, family in (families | dict.fromkeys(("walschaerts", "stephenson_reversing"), "valve gears")).items():
        assert name in groups[family]
    rows = {row["name"]: row for row in json_of("models")["models"]}
    assert list(rows) == list(shipped_scenes())
    machines, dimensions, effects = (rows["porter"][key] for key in ("machines", "dimensions", "effects"))
    assert (machines, dimensions["arm"], effects) == (["pendulum_governor"], "300 mm", ["gravity", "centrifugal"])


def test_lists_and_help_fit_a_terminal():
    assert max(map(len, succeed("catalogue").stdout.splitlines())) <= 80
    text = succeed("--help").stdout
    headings = ("Find and write scenes", "Make", "Study a mechanism", "Study many runs", "Find dimensions", "Verify")
    assert [text.count(f"\n{heading}:\n") for heading in headings] == [1] * len(headings)
    commands = {line.split()[0] for line in text.splitlines() if line.startswith("  ") and line[2:3].isalpha()}
    assert {"models", "run", "open", "sweep", "design", "synthesise", "errata"} <= commands


@pytest.mark.long
def test_run_writes_film_figure_readings_arrays_and_record(tmp_path):
    result = succeed("run", str(short_scene(tmp_path, **{"10 ms": "100 ms"})), "--out", str(tmp_path / "out"))
    assert "accurate to" in result.stdout
    assert "(requested 1e-06)" in result.stdout
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [f"short.{kind}" for kind in ("csv", "gif", "json", "nc", "png")]


def told(stderr):
    """What was said, but for the news that kernels are compiled, which the first command of all gives."""
    return [line for line in stderr.splitlines() if not line.startswith("compiling kernels")]


def test_a_run_lists_the_events_that_the_scene_names_before_others():
    """The valve passes many turning points before the second of its two turns."""
    listed, _ = format_run(governor_mechanism.run("slide_valve_30")).split("more events")
    assert listed.count("crossing") == 3


def test_run_as_json_prints_one_object_and_nothing_else(tmp_path, monkeypatch, capfd):
    words = ["run", str(short_scene(tmp_path)), "--no-film", "--json", "--accuracy", "1e-7", "--out", str(tmp_path / "out")]
    status, printed, said = call_main(monkeypatch, capfd, *words)
    summary = json.loads(printed)
    assert status == 0
    assert summary["outcome"] == "done"
    assert summary["error_estimate"] <= 1e-7 == summary["settings"]["asked_accuracy"]
    assert summary["document"]["dimensions"]["arm"] == "300 mm"
    assert all(Path(path).is_file() for path in summary["files"])
    assert not told(said)


@pytest.mark.parametrize("scene", ["watt_crossed", "parabolic"])  # this one with flags of numpy
def test_crosscheck_ends_with_0_where_all_agree_and_tells_it_as_json(scene):
    answer = json_of("crosscheck", scene)
    assert answer["passed"] is True
    assert {type(row["passed"]) for row in answer["rows"]} == {bool}
    assert all(abs(row["difference"]) <= row["allowed"] for row in answer["rows"])


def test_a_run_that_leaves_its_range_ends_with_1_and_keeps_what_it_has(tmp_path):
    scene = short_scene(tmp_path, **{'"120 rpm"': '"2000 rpm"'})
    result = invoke("run", str(scene), "--no-film", "--out", str(tmp_path / "out"))
    assert result.exit_code == 1
    assert "90 degrees" in result.stderr
    assert json.loads((tmp_path / "out" / "short.json").read_text(encoding="utf-8"))["outcome"] == "left_range"
    assert (tmp_path / "out" / "short.csv").stat().st_size > 0


@pytest.mark.parametrize("command", ["run", "crosscheck"])
def test_every_mistake_of_a_file_is_told_at_once(command, tmp_path):
    scene = short_scene(tmp_path, **{'"300 mm"': '"300 kg"', "ball_mass": "bal_mass", '"40 deg"': '"95 deg"'})
    result = invoke(command, str(scene))
    assert result.exit_code == 2
    assert result.stdout == ""
    told = result.stderr.splitlines()
    assert len(told) >= 2
    assert any("dimensions.arm is a length" in line for line in told)
    assert any("Did you mean 'ball_mass'" in line for line in told)
    assert "Traceback" not in result.stderr


def test_mistakes_as_json_are_one_object_too(tmp_path):
    result = invoke("run", str(short_scene(tmp_path, **{'"300 mm"': '"300 kg"'})), "--json")
    assert result.exit_code == 2
    assert json.loads(result.stdout)["outcome"] == "bad_input"


def test_the_version_is_told():
    assert succeed("--version").stdout.strip() == governor_mechanism.__version__


def test_usage_errors_are_one_object_too_where_json_is_asked_for(monkeypatch, capfd):
    status, printed, _ = call_main(monkeypatch, capfd, "run", "--json")
    assert status == 2
    assert json.loads(printed)["outcome"] == "bad_input"


def test_an_interrupt_that_a_finaliser_swallows_is_not_reported(monkeypatch):
    class Finalised:
        def __init__(self, error):
            self.error = error

        def __del__(self):
            raise self.error

    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda unraisable: reported.append(unraisable.exc_type))
    previous_hook = sys.unraisablehook
    with InterruptHandler():
        Finalised(KeyboardInterrupt())
        Finalised(ValueError())
    assert reported == [ValueError]
    assert sys.unraisablehook is previous_hook


def test_a_command_without_standard_output_prints_nothing():
    words = f"{sys.executable} -m governor_mechanism.cli.main models >&-"
    answer = subprocess.run(["bash", "-c", words], capture_output=True, text=True, check=False)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_who_has_seen_enough_is_no_failure(unbuffered):
    """The pipe is closed before anything is printed, so that printing is certain to fail."""
    settings = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    with subprocess.Popen([*COMMAND, "models"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=settings) as process:
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 0


def test_out_must_be_a_folder(tmp_path):
    (tmp_path / "taken").write_text("", encoding="utf-8")
    result = invoke("run", str(short_scene(tmp_path)), "--out", str(tmp_path / "taken"))
    assert result.exit_code == 2
    assert "is a file; give the name of a folder" in result.stderr
    result = invoke("run", str(short_scene(tmp_path)), "--out", str(tmp_path / "taken" / "deeper"))
    assert result.exit_code == 2
    assert "taken/deeper cannot be made: Not a directory; choose another folder" in result.stderr


def test_out_must_be_a_folder_in_which_one_may_write(tmp_path, monkeypatch):
    """Found before the work; the superuser may write everywhere, so the system is asked in his place."""
    monkeypatch.setattr("governor_mechanism.cli.console.os.access", lambda path, mode: mode != os.W_OK)
    result = invoke("run", str(short_scene(tmp_path)), "--out", str(tmp_path))
    assert result.exit_code == 2
    assert "is a folder in which you may not write; choose another one" in result.stderr


def test_a_folder_stays_only_if_something_was_written_into_it(tmp_path):
    new, old = tmp_path / "deep" / "new", tmp_path / "old"
    old.mkdir()
    for folder in (new, old):
        assert invoke("effects", "porter", "--set", "run.duration=-1 s", "--out", folder).exit_code == 2
    assert (new.exists(), old.exists()) == (False, True)
    succeed("kinematics", "slider_crank", "--no-figure", "--out", new)
    assert {one.suffix for one in new.iterdir()} == {".csv", ".json"}


MARK_FIRST_STEP = """
import sys
from pathlib import Path
from governor_mechanism.cli.main import main
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel

marker, step = Path(sys.argv.pop(1)), PymunkModel.step

def step_and_mark(*arguments):
    marker.touch()
    PymunkModel.step = step
    return step(*arguments)

PymunkModel.step = step_and_mark
main()
"""
"""The command, which creates a file when the run takes its first step."""


@pytest.mark.parametrize(
    "words", ["models", "run portr --json", *(pytest.param(one, marks=pytest.mark.long) for one in ("--help", "describe porter --json"))]
)
def test_an_output_that_is_full_is_told_in_a_sentence(words):
    answer = subprocess.run(["bash", "-c", f"{' '.join(COMMAND)} {words} >/dev/full"], capture_output=True, text=True, check=False)
    assert answer.returncode == 2
    assert answer.stderr.splitlines()[-1] == "cannot write to standard output: No space left on device"
    assert "Traceback" not in answer.stderr


@pytest.mark.long
@pytest.mark.parametrize("closing", ["2>&-", "2>/dev/full"])
@pytest.mark.parametrize(("words", "status"), [("crosscheck slider_crank --json", 0), ("run portr --json", 2)])
def test_messages_that_nobody_can_read_do_not_reach_the_output(closing, words, status):
    answer = subprocess.run(["bash", "-c", f"{' '.join(COMMAND)} {words} {closing}"], capture_output=True, text=True, check=False)
    assert (answer.returncode, answer.stderr) == (status, "")
    assert json.loads(answer.stdout)


@pytest.mark.long
def test_a_full_disk_leaves_the_results_of_an_earlier_run(tmp_path):
    """A limit on the size of files acts as a full disk does; the film and the readings are smaller than it, the figure is larger."""
    words = [*COMMAND, "run", str(short_scene(tmp_path, **{"10 ms": "500 ms"})), "--no-film", "--out", str(tmp_path)]
    (tmp_path / "short.csv").write_text("old", encoding="utf-8")
    answer = subprocess.run(["bash", "-c", 'ulimit -f 16; "$@"', "bash", *words], capture_output=True, text=True, check=False)
    assert answer.returncode == 2
    assert answer.stderr.splitlines() == [f"cannot write {tmp_path / 'short.png'}: File too large"]
    assert sorted(listing(tmp_path)) == ["short.csv", "short.toml"]
    assert (tmp_path / "short.csv").read_text(encoding="utf-8") == "old"


@pytest.mark.long
@pytest.mark.parametrize(("stage", "signal_sent"), [("run", signal.SIGTERM), ("film", signal.SIGINT), ("film", signal.SIGKILL)])
def test_an_interrupt_leaves_no_partial_file_and_says_one_line(stage, signal_sent, tmp_path):
    scene = short_scene(tmp_path, **{'"1 s"': '"3000 s"' if stage == "run" else '"60 s"', '"10 ms"': '"50 ms"'})
    out, stepping = tmp_path / "out", tmp_path / "stepping"
    command = [sys.executable, "-c", MARK_FIRST_STEP, str(stepping)] if stage == "run" else COMMAND
    engine = ["--engine", "impulse"] if stage == "run" else []  # the slowest engine: minutes
    words = [*command, "run", str(scene), "--out", str(out), "--accuracy", "1e-3", "--no-figure", *engine]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            wait_until(stepping.exists if stage == "run" else lambda: any(name.endswith(".gif") for name in listing(out)))
            process.send_signal(signal_sent)
            printed, said = process.communicate(timeout=60)
        finally:
            process.kill()
    if signal_sent == signal.SIGKILL:  # nothing can be removed, but nothing has a final name
        assert all(name.startswith(".short.") for name in listing(out))
        return
    assert process.returncode == 128 + signal_sent
    assert said.splitlines() == ["interrupted; complete files are kept, and no half-written file is left"]
    assert printed == ""
    assert not [name for name in listing(out) if name.startswith(".") or name.endswith((".gif", ".json"))]


def listing(folder: Path) -> list[str]:
    return os.listdir(folder) if folder.is_dir() else []


def wait_until(happened, patience: float = 60.0) -> None:
    for _ in range(int(patience / 0.02)):
        if happened():
            return
        time.sleep(0.02)
    raise AssertionError("it did not happen")


def test_equilibria_are_told_drawn_and_given_as_json(tmp_path):
    words = ["equilibria", "watt_improved", "--speed", "6.4 rad/s", "--out", str(tmp_path)]
    result = succeed(*words)
    lines = result.stdout.splitlines()
    assert "unstable, undamped divergence rate" in lines[1]
    assert "stable, undamped natural frequency" in lines[2]
    assert lines[3].startswith("jumps at 31.8721 deg, 60.42")
    assert (tmp_path / "watt_improved_characteristic.png").read_bytes().startswith(b"\x89PNG")
    found = json_of(*words, "--no-figure")
    assert [rest["stable"] for rest in found["equilibria"]] == [False, True]
    assert found["files"] == []


@pytest.mark.parametrize(("scene", "unit"), [("porter", "N m/rad"), ("haug_governor", "N/m")])
def test_a_stiffness_has_the_unit_of_its_coordinate(scene, unit):
    assert re.search(rf"stiffness [\d.]+ {unit}(;|$)", invoke("equilibria", scene, "--no-figure").stdout, re.MULTILINE)


def test_the_bill_of_the_effects_is_told_drawn_and_given_as_json(tmp_path, one_timing):
    answer = json_of("effects", "porter_dry_friction", "--out", tmp_path)
    assert {row["effect"]: row["listed"] for row in answer["effects"]} == {"gravity": True, "centrifugal": True, "dry_friction": True}
    assert answer["leave_out"] == []
    assert [path.name for path in tmp_path.iterdir()] == ["porter_dry_friction_effects.png"]
    plain = invoke("effects", "porter_dry_friction", "--no-figure")
    assert "dry_friction" in plain.stdout
    assert "not tried, because they need parameters: rods, spring, dashpot, stops, clearance" in plain.stdout


def test_accuracy_is_measured_told_drawn_and_given_as_json(tmp_path, one_timing):
    scene, out = str(short_scene(tmp_path)), tmp_path / "out"
    result = succeed("accuracy", scene, "--for", "1e-6", "--longest", "0.02", "--out", str(out))
    assert "for 1e-06: use " in result.stdout
    assert "impulse plain never within " in result.stdout
    assert sorted(path.name for path in out.iterdir()) == [f"short_accuracy.{kind}" for kind in ("csv", "json", "png")]
    answer = json_of("accuracy", scene, "--for", "1e-6", "--longest", "0.02", "--out", out, "--no-figure")
    assert answer["reached"]
    assert answer["advice"].startswith("for 1e-06: use ")
    assert [Path(path).suffix for path in answer["files"]] == [".csv", ".json"]


def test_an_error_less_than_can_be_told_is_answered_after_all_that_was_found(tmp_path, one_timing):
    """A scene whose name has a point in it keeps all of its name."""
    scene = short_scene(tmp_path).rename(tmp_path / "my.v1.toml")
    result = invoke("accuracy", str(scene), "--for", "1e-15", "--longest", "0.02", "--out", str(tmp_path / "out"))
    assert result.exit_code == 1
    assert re.search("multibody +tolerance", result.stdout)
    assert "the reference has an error of" in result.stdout
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == [f"my.v1_accuracy.{kind}" for kind in ("csv", "json", "png")]


def test_how_a_governor_regulates_is_asked_from_the_command_line(tmp_path, monkeypatch):
    monkeypatch.setattr("governor_mechanism.studies.regulation.speed_changes.RAMP_RATES", [4e-3, 1e-3, 2.5e-4])
    result = succeed("regulation", "jump", "--out", str(tmp_path))
    assert "falls below 6.32801 rad/s" in result.stdout
    assert "jumps above 6.44406 rad/s" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["jump.png"]


SHORT = {"10 ms": "50 ms", "accuracy = 1e-6": 'accuracy = 1e-4\nengine = "multibody"'}


def test_a_sweep_is_told_drawn_kept_and_given_as_json(tmp_path):
    words = ["sweep", str(short_scene(tmp_path, **SHORT)), "--vary", "dimensions.arm=290mm:310mm:3"]
    words += ["--vary", "dimensions.sleeve_mass=19kg,21kg", "--quantity", "max arm_angle"]
    plain = succeed(*words, "--out", str(tmp_path / "plain"))
    assert "6 rows, 3 of dimensions.arm x 2 of dimensions.sleeve_mass" in plain.stdout
    assert sorted(listing(tmp_path / "plain")) == [f"short_sweep.{kind}" for kind in ("csv", "json", "png")]
    heads = (tmp_path / "plain" / "short_sweep.csv").read_text(encoding="utf-8").splitlines()[0]
    assert heads == "dimensions.arm [m],dimensions.sleeve_mass [kg],max arm_angle [rad],outcome,message"
    answer = json_of(*words, "--out", tmp_path / "json", "--no-figure")
    assert [row["outcome"] for row in answer["rows"]] == ["ok"] * 6
    assert [Path(path).name for path in answer["files"]] == ["short_sweep.csv", "short_sweep.json"]
    assert sorted(listing(tmp_path / "json")) == ["short_sweep.csv", "short_sweep.json"]


def test_a_sweep_with_rows_that_ended_otherwise_ends_with_1(tmp_path):
    words = ["sweep", str(short_scene(tmp_path, **SHORT)), "--vary", "dimensions.link=100mm,300mm", "--certify"]
    result = invoke(*words, "--out", str(tmp_path / "out"), "--no-figure")
    assert result.exit_code == 1
    assert "1 of 2 rows could not be run: start.arm_angle" in result.stdout


def test_a_sweep_whose_rows_leave_the_range_ends_with_0(tmp_path):
    words = ["sweep", str(short_scene(tmp_path, **SHORT)), "--vary", "spindle.speed=120rpm,300rpm", "--quantity", "duration"]
    result = succeed(*words, "--out", str(tmp_path / "out"), "--no-figure")
    # Arm and link are equally long and reach their limits together: rounding decides which is first.
    assert "1 of 2 rows reached the end of the range of " in result.stdout
    assert "at 90 degrees" in result.stdout


SWEEP = ["--vary", "dimensions.arm=290mm:310mm:60", "--no-figure"]


@pytest.fixture(scope="module")
def whole_sweep(tmp_path_factory):
    """Return the folder of a sweep that was not interrupted."""
    folder = tmp_path_factory.mktemp("whole")
    succeed("sweep", short_scene(folder, **SHORT), *SWEEP, "--out", folder)
    return folder


def interrupt_process(happened, *words: str) -> tuple[int, str]:
    """Return exit status and messages of a command with processes of its own that is interrupted when something has happened."""
    # The signal reaches the processes of the command too, as a terminal's Ctrl-C does.
    return end_process(happened, words, lambda group: os.killpg(group, signal.SIGINT))


def terminate_process(happened, *words: str) -> tuple[int, str]:
    """Return exit status and messages of a command with processes of its own that is asked to terminate when something has happened."""
    # The signal reaches the command alone, as from a batch system.
    return end_process(happened, words, lambda process: os.kill(process, signal.SIGTERM))


def end_process(happened, words: tuple[str, ...], send_signal) -> tuple[int, str]:
    """Return exit status and messages of a command that gets a signal; its processes end with it."""
    with subprocess.Popen([*EAGER_COMMAND, *words], stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        try:
            wait_until(happened)
            send_signal(process.pid)
            _, said = process.communicate(timeout=60)
            wait_until(lambda: not has_processes(process.pid))
        finally:
            process.kill()
    return process.returncode, said


def has_processes(group: int) -> bool:
    """Return whether a group has processes."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def interrupt_call(happened, *words: str) -> tuple[int, str]:
    """Return exit status and messages of a command that is interrupted in this process when something has happened."""
    has_ended = threading.Event()

    def interrupt():
        wait_until(lambda: happened() or has_ended.is_set())
        if not has_ended.is_set():
            os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    result = invoke(*words)
    has_ended.set()
    thread.join()
    return result.exit_code, result.stderr


@pytest.mark.long
@pytest.mark.parametrize(
    ("workers", "interrupt", "expected"),
    [("1", interrupt_call, 130), ("2", interrupt_process, 130), ("2", terminate_process, 143)],
    ids=["1", "2", "2, terminated"],
)
def test_an_interrupted_sweep_goes_on_where_it_was(workers, interrupt, expected, tmp_path, whole_sweep):
    scene, out = short_scene(tmp_path, **SHORT), tmp_path / "out"
    words = ["sweep", str(scene), *SWEEP, "--out", str(out)]
    journal = out / "short_sweep.part"
    status, said = interrupt(lambda: journal.exists() and journal.read_bytes().count(b"\n") > 3, *words, "--workers", workers)
    assert status == expected
    kept = journal.read_bytes().count(b"\n") - 1
    assert 3 <= kept < 60
    assert said.splitlines()[0] == f"{kept} of 60 rows are in {journal}; the same command continues from there"
    assert len(told(said)) == 2
    assert listing(out) == [journal.name]
    succeed(*words)  # it goes on with one worker, however many it had
    for name in ("short_sweep.csv", "short_sweep.json"):
        assert (out / name).read_bytes() == (whole_sweep / name).read_bytes()


def test_hard_cases_are_printed_drawn_and_given_as_json(tmp_path):
    result = succeed("hard-cases", "--case", "not-a-number", "--case", "breakaway", "--short", "--out", str(tmp_path))
    assert "breakaway: Friction that holds until late in the run" in result.output
    assert "0 failed" in result.output
    names = {"hard_cases.csv", "hard_cases.json", "hard_case_breakaway.png", "hard_case_not-a-number.png"}
    assert {path.name for path in tmp_path.iterdir()} == names
    answer = json_of("hard-cases", "--case", "not-a-number", "--no-figure", "--out", str(tmp_path))
    assert answer["ok"] is True
    assert [row["verdict"] for row in answer["rows"]] == ["refused", "refused"]
