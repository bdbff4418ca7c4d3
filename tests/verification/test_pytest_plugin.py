"""The plug-in for pytest: marked kernels, the fixture, and what it does not load."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field

import pytest

PLUGIN = "governor_mechanism.pytest_plugin"

KERNEL = """
import math
import pytest

def speed(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    load = gravity * (1 + sleeve_mass / ball_mass)
    return math.sqrt(load * math.tan(arm_angle) / (offset + arm * math.sin(arm_angle)))
"""


@dataclass
class Outcomes:
    """How the tests of a session ended, by name, and what pytest printed. It is a plug-in of that session."""

    by_name: dict[str, str] = field(default_factory=dict)
    text: str = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or report.skipped:
            self.by_name[report.nodeid.partition("::")[2]] = report.outcome


@pytest.fixture
def run_tests(tmp_path, capsys):
    """A function that runs a test file in this process, where the kernels are loaded.

    `pytester` would forget the modules that are imported meanwhile, which numba does not survive.
    """

    def run(text: str) -> Outcomes:
        path = tmp_path / f"test_{tmp_path.name}.py"
        path.write_text(KERNEL + text, encoding="utf-8")
        outcomes = Outcomes()
        alone = ["--strict-markers", "--import-mode=importlib", f"--rootdir={tmp_path}", f"--confcutdir={tmp_path}", "-c", os.devnull]
        off = [word for name in ("xdist", "cacheprovider", "faulthandler", "hypothesispytest") for word in ("-p", f"no:{name}")]
        pytest.main(["-p", PLUGIN, *alone, *off, str(path)], plugins=[outcomes])
        outcomes.text = capsys.readouterr().out
        return outcomes

    return run


def test_a_function_returns_the_kernel_in_six_lines(run_tests):
    guard = """
@pytest.mark.governor(scene="porter", quantity="equilibrium_speed", over={"arm_angle": "15 deg:45 deg:25"})
def test_speed():
    return speed
"""
    assert len(guard.strip().splitlines()) <= 6
    assert run_tests(guard).by_name == {"test_speed": "passed"}


def test_a_planted_mistake_fails_with_the_report(run_tests):
    result = run_tests("""
@pytest.mark.governor("porter", over={"arm_angle": "15 deg:45 deg:5"}, vary={"dimensions.arm": "200 mm:400 mm"}, random=4, seed=1)
def test_speed():
    return lambda arm_angle, arm, offset, ball_mass, sleeve_mass, gravity: 1.01 * speed(
        arm_angle, arm, offset, ball_mass, sleeve_mass, gravity)
""")
    assert result.by_name == {"test_speed": "failed"}
    assert re.search(r"^worst: \+1 % at arm_angle = .*, dimensions.arm = ", result.text, re.MULTILINE)
    assert "4 of 4 do not agree within 1e-06" in result.text
    assert "Traceback" not in result.text


def test_a_function_with_parameters_is_the_kernel_also_in_a_class(run_tests):
    result = run_tests("""
@pytest.mark.governor(scene="porter", quantity="sleeve_lift", over={"arm_angle": [0.4, 0.6]})
def test_lift(arm_angle, arm):
    return 2 * arm * (1 - math.cos(arm_angle))

class TestLift:
    @pytest.mark.governor(scene="porter", quantity="sleeve_lift", over={"arm_angle": [0.4, 0.6]})
    def test_lift(self, arm_angle, arm):
        return 2 * arm * (1 - math.cos(arm_angle))

    @pytest.mark.governor(scene="porter", quantity="sleeve_lift", over={"arm_angle": [0.4, 0.6]})
    def test_wrong(self, arm_angle, arm):
        return 2.02 * arm * (1 - math.cos(arm_angle))

@pytest.mark.skip(reason="not yet")
@pytest.mark.governor(scene="porter", quantity="sleeve_lift", over={"arm_angle": [0.4, 0.6]})
def test_skipped(arm_angle, arm):
    return 0.0
""")
    assert result.by_name == {
        "test_lift": "passed",
        "TestLift::test_lift": "passed",
        "TestLift::test_wrong": "failed",
        "test_skipped": "skipped",
    }
    assert "worst: +1 % at arm_angle" in result.text


def test_the_fixture_returns_the_report_and_leaves_other_tests_alone(run_tests):
    result = run_tests("""
@pytest.mark.parametrize("factor", [1.0, 1.01])
def test_speed(governor_crosscheck, factor):
    def kernel(arm_angle, arm):
        return factor * 2 * arm * (1 - math.cos(arm_angle))
    report = governor_crosscheck("porter", kernel, "sleeve_lift", {"arm_angle": [0.5]})
    assert report.largest_error_estimate < 1e-12

def test_other(tmp_path):
    assert tmp_path.is_dir()
""")
    assert result.by_name == {"test_speed[1.0]": "passed", "test_speed[1.01]": "failed", "test_other": "passed"}


def test_mistakes_of_the_marker_are_told_in_a_sentence(run_tests):
    result = run_tests("""
@pytest.mark.governor(quantity="sleeve_lift")
def test_no_scene():
    return speed

@pytest.mark.governor("porter", over={"arm_angle": [0.5]})
def test_no_kernel():
    pass

@pytest.mark.governor("porter", ovr={"arm_angle": [0.5]})
def test_no_such_argument():
    return speed

@pytest.mark.governor("porter", over={"arm_angel": [0.5]})
def test_no_such_input():
    return speed
""")
    assert [*result.by_name.values()] == ["failed"] * 4
    for sentence in (
        "the marker names no scene",
        "test_no_kernel must return the kernel, a function; it returned NoneType",
        "crosscheck: got an unexpected keyword argument 'ovr'",
        "Did you mean 'arm_angle'",
    ):
        assert sentence in result.text
    assert "During handling" not in result.text


def test_the_start_of_pytest_loads_nothing_heavy():
    code = f"import sys, {PLUGIN}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "scipy", "numba", "matplotlib", "typer"} & {*loaded}
