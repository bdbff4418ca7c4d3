"""What the README and the documentation show works as it stands there."""

import os
import tomllib
from pathlib import Path

import pytest

import governor_mechanism as gm
from command_line import invoke
from documentation_pages import PAGES, ROOT, check_options, commands, named_scenes, snippets, snippets_of
from governor_mechanism.model.joints import Gear
from governor_mechanism.scenes.library import catalogue_scenes, shipped_scenes
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep.quantities import SCENE_RULES
from governor_mechanism.studies.sweep.rules import ENGINE_RULES, STATISTICS, VALVE_RULES

SHORT, SHORT_FILMED = "0.1", "1"
"""Durations (s) of runs of commands: they show as well that the options are understood. Films of shorter runs are slowed, and longer."""

FILM_OPTIONS = {
    *("--film", "--fps", "--size", "--layout", "--labels", "--forces", "--traces", "--readings", "--theme", "--title"),
    *("--view", "--exaggerate", "--paths", "--layers", "--part", "--start", "--stop", "--slow-down", "--no-footer"),
}


def cases(language):
    return [pytest.param(snippet.code, id=snippet.place) for snippet in snippets(language)]


@pytest.mark.parametrize("text", cases("toml"))
@pytest.mark.parametrize("engine", ["multibody", "impulse"])
def test_scenes_run(text, engine):
    scene = parse_scene_document(tomllib.loads(text))
    if scene.output_effects and engine == "impulse":
        pytest.skip("what sticks and strikes impulse steps too, but slowly: test_impulse_effects.py")
    if engine == "impulse" and any(isinstance(joint, Gear) and joint.is_carried for joint in scene.mechanism.joints):
        pytest.skip("impulse refuses a gear on a carrier: test_carried_gears.py")
    if engine == "impulse" and scene.mechanism.outlines:
        pytest.skip("impulse refuses rollers that touch outlines: test_outline_contacts.py")
    run = gm.run(scene, engine=engine, accuracy=1e-5)
    assert run.outcome.ok
    assert run.error_estimate <= 1e-5


@pytest.mark.parametrize("code", [case for case in cases("python") if "pytest.mark" not in case.values[0]])
def test_python_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "snippet", "exec"), {})  # our own words
    assert "nan" not in capsys.readouterr().out.lower()


@pytest.mark.long
@pytest.mark.parametrize("page", [pytest.param(page, id=str(page.relative_to(ROOT))) for page in PAGES if commands(page, "sh")])
def test_commands_run(page, tmp_path, monkeypatch):
    """In the order of the page, without what other tests draw. A run of a shipped scene as it stands is left to the tests of the scenes."""
    monkeypatch.chdir(tmp_path)
    for arguments, target in commands(page, "sh"):
        check_options(arguments)
        command, *rest = arguments
        if command == "run" and rest[0] in shipped_scenes() and len(rest) == 1:
            continue
        if command in ("run", "compare") and "--seconds" not in rest:
            arguments += ["--seconds", SHORT_FILMED if command == "compare" or FILM_OPTIONS & set(rest) else SHORT]
        if command == "run" and not FILM_OPTIONS & set(rest) and "--no-film" not in rest:
            arguments.append("--no-film")
        if command in ("run", "compare", "equilibria", "crosscheck", "design") and not {"--format", "--no-figure"} & set(rest):
            arguments.append("--no-figure")
        result = invoke(*arguments)
        assert result.exit_code == 0, f"{' '.join(arguments)}: {result.output}"
        if target:
            Path(target).write_text(named_scenes(page).get(target, result.stdout), encoding="utf-8")


def test_long_commands_have_known_options():
    for page in PAGES:
        for arguments, _ in commands(page, "sh long"):
            check_options(arguments)


def test_shipped_scenes_that_are_run_exist():
    known = {**shipped_scenes(), **catalogue_scenes()}
    for page in PAGES:
        for (command, *rest), _ in commands(page, "sh") + commands(page, "sh long"):
            if command in ("run", "describe", "crosscheck", "equilibria", "accuracy", "effects", "sweep"):
                assert rest[0] in known or rest[0].endswith(".toml"), f"{page.name}: {rest[0]}"


@pytest.mark.parametrize("page", ["README.md", "docs/how_to/kernel_in_ci.md"])
def test_the_guarded_kernel_passes(page, tmp_path, capsys):
    (code,) = [snippet.code for snippet in snippets_of(ROOT / page, "python") if "pytest.mark.governor" in snippet.code]
    assert len([line for line in code.splitlines() if line]) <= 6
    path = tmp_path / "test_of_documentation.py"
    path.write_text(code, encoding="utf-8")
    alone = ["--import-mode=importlib", f"--rootdir={tmp_path}", f"--confcutdir={tmp_path}", "-c", os.devnull, "-p", "no:cacheprovider"]
    off = [word for name in ("xdist", "faulthandler", "hypothesispytest") for word in ("-p", f"no:{name}")]
    assert pytest.main(["-p", "governor_mechanism.pytest_plugin", *alone, *off, str(path)]) == 0
    assert "1 passed" in capsys.readouterr().out


def test_the_table_of_quantities_names_every_rule():
    text = (ROOT / "docs" / "how_to" / "sweep.md").read_text(encoding="utf-8")
    rows = "".join(line for line in text.splitlines() if line.startswith("| `"))
    for rule in (*STATISTICS, *ENGINE_RULES, *SCENE_RULES, "valve travel", "duration", "error_estimate"):
        assert rule in rows
    assert all(rule.split()[-1] in rows for rule in VALVE_RULES)
