"""The library of kernels: the bits of numba, threads and processes, no memory kept, and one sentence where it cannot be used."""

import json
import multiprocessing
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from types import CodeType, ModuleType

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.contact.rules import find_active_stop
from governor_mechanism.mechanics.curves.segments import evaluate_curve, make_curve_segments
from governor_mechanism.mechanics.dynamics.body_forces import inertia_of_plane
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.numerics import jit as jit_module
from governor_mechanism.numerics import kernel_library
from governor_mechanism.numerics.jit import Kernel, jit
from governor_mechanism.numerics.kernel_library import count_live_blocks, find_kernel, read_index

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "governor_mechanism"
CALLERS = {"mechanics", "engines", "statics", "observables", "studies"}
"""Folders whose functions may call kernels; functions inside functions of `integrators` are kernels."""
CALLED_BY_TESTS = {
    "governor_mechanism.mechanics.dynamics.equations_of_motion:evaluate_state_derivative",
    "governor_mechanism.mechanics.dynamics.event_functions:evaluate_event_functions",
    "governor_mechanism.mechanics.reduction.equation_of_motion:evaluate_state_rates",
}
"""Kernels that only tests call from Python."""
SMALL_KERNELS = ["inertia_of_plane", "find_active_stop", "is_locked", "record_event"]

has_library = (index := read_index()) is not None and not kernel_library.find_obstacle(index, kernel_library.platform_name())
needs_library = pytest.mark.skipif(not has_library, reason="make kernels has not built the library")


@needs_library
def test_the_library_returns_the_bits_of_numba():
    command = [sys.executable, ROOT / "kernel_build" / "comparison.py", "--duration", "0.1"]
    options = ["--scenes", "porter_dry_friction", "--kernels", *SMALL_KERNELS]
    answer = subprocess.run([*command, *options], capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert " 0 different; 0 blocks of memory kept" in answer.stdout
    assert all(f"{name} " in answer.stdout for name in SMALL_KERNELS[:2]), answer.stdout


def bits_of_run(engine):
    run = gm.run("porter_dry_friction", engine=engine, times=[0.0, 0.05], accuracy=1e-4)
    return run.poses.tobytes() + run.velocities.tobytes()


@needs_library
def test_threads_call_kernels_at_once_and_no_memory_is_kept():
    engines = ["reduced", "multibody", "impulse"] * 4
    expected = {engine: bits_of_run(engine) for engine in set(engines)}
    with ThreadPoolExecutor(6) as threads:
        found = list(threads.map(bits_of_run, engines))
    assert found == [expected[engine] for engine in engines]
    assert count_live_blocks() == 0


@needs_library
def test_worker_processes_call_kernels():
    arms = {"dimensions.arm": [0.28, 0.29, 0.3, 0.31]}
    alone, together = (gm.sweep("porter", arms, ["final arm_angle"], workers=workers) for workers in (1, 2))
    assert str(alone) == str(together)


WORKERS = """
import multiprocessing
import sys

import governor_mechanism as gm


def bits_of_run(engine):
    run = gm.run("porter_dry_friction", engine=engine, times=[0.0, 0.05], accuracy=1e-4)
    return run.poses.tobytes() + run.velocities.tobytes()


if __name__ == "__main__":
    expected = [bits_of_run("reduced"), bits_of_run("multibody")]
    with multiprocessing.get_context(sys.argv[1]).Pool(2) as pool:
        assert pool.map(bits_of_run, ["reduced", "multibody"]) == expected
"""
"""A script that calls kernels in a process, and then in two that it starts."""


@needs_library
@pytest.mark.parametrize("start", [name for name in ("fork", "spawn") if name in multiprocessing.get_all_start_methods()])
def test_forked_and_spawned_processes_get_the_bits_of_their_parent(start, tmp_path):
    script = tmp_path / "workers.py"
    script.write_text(WORKERS)
    answer = subprocess.run([sys.executable, script, start], capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr


@needs_library
def test_numbers_of_numpy_fit_and_other_types_go_to_the_fallback():
    refused = []
    call = find_kernel(inertia_of_plane.__wrapped__, lambda *arguments: refused.append(arguments))
    bodies = make_system(gm.load("porter"))[0].bodies
    poses = np.linspace(0.1, 0.5, 3 * len(bodies)).reshape(-1, 3)
    expected = call(bodies, 0, poses, poses)
    assert expected[0] > 0.0
    assert call(bodies, np.int64(0), poses, poses) == expected
    assert not refused
    cases = [
        (),
        (bodies, 0, poses),
        (bodies, 0, poses, poses, poses),
        (bodies, 0.0, poses, poses),
        (bodies, True, poses, poses),
        (bodies, 2**70, poses, poses),
        (bodies, 0, poses.astype(int), poses),
        (bodies, 0, poses.astype(np.float32), poses),
        (bodies, 0, poses[:, 0], poses),
        (bodies, 0, np.asfortranarray(poses), poses),
        (poses, 0, poses, poses),
        (bodies[["mass", "plane"]].astype([("mass", float), ("plane", int)]), 0, poses, poses),
        (None, 0, [1.0], "text"),
    ]
    for arguments in cases:
        assert call(*arguments) is None
        assert len(refused.pop()) == len(arguments)
    assert not refused


@needs_library
@pytest.mark.parametrize("curve", [SplineCurve(x=(0.0, 0.1, 0.3), y=(0.0, 0.02, 0.05)), PolynomialCurve(coefficients=(0.1, 0.5))])
def test_segments_of_curves_are_in_the_order_that_the_library_takes(curve):
    refused = []
    call = find_kernel(evaluate_curve.__wrapped__, lambda *arguments: refused.append(arguments))
    segments = make_curve_segments(curve)
    assert call(segments, 0, len(segments), 0.1) is not None
    assert not refused


def codes_in(code):
    """Yield the code of a module and of all functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes_in(constant)


def kernels_called_by_python(module):
    """Yield the kernels that functions of a module use, other than kernels."""
    names = vars(module)
    own_kernels = {value.__wrapped__.__code__.co_qualname for value in names.values() if isinstance(value, Kernel)}
    text = Path(module.__file__).read_text(encoding="utf-8")
    for code in codes_in(compile(text, module.__file__, "exec")):
        if code.co_name != "<module>" and code.co_qualname not in own_kernels:
            places = [names, *(vars(names[name]) for name in code.co_names if isinstance(names.get(name), ModuleType))]
            yield from (place[name] for place in places for name in code.co_names if isinstance(place.get(name), Kernel))


@needs_library
def test_every_kernel_that_python_calls_is_in_the_library():
    called = set()
    for path in sorted(SOURCE.rglob("*.py")):
        folder = path.relative_to(SOURCE).parts[0]
        if (folder != "integrators" and "numerics.jit" in path.read_text(encoding="utf-8")) or folder in CALLERS:
            name = ".".join(("governor_mechanism", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__")
            called |= {f"{kernel.__module__}:{kernel.__name__}" for kernel in kernels_called_by_python(import_module(name))}
    assert called | CALLED_BY_TESTS == set(index["kernels"])


@needs_library
def test_only_globals_of_their_module_are_found():
    @jit
    def find_active_stop(value):
        return value

    assert isinstance(find_active_stop, Kernel)
    assert find_kernel(find_active_stop.__wrapped__, print) is None


@needs_library
def test_what_kernels_allocate_is_freed():
    for model in ("porter_dry_friction", "slider_crank_torque", "four_bar_chain"):
        for engine in ("reduced", "multibody", "impulse"):
            gm.run(model, engine=engine, times=[0.02], certify=False)
    assert count_live_blocks() == 0


@pytest.fixture
def library_folder(tmp_path, monkeypatch):
    """Let the library be searched in an empty folder."""
    monkeypatch.setattr(kernel_library, "LIBRARY_FOLDER", tmp_path)
    caches = kernel_library._open_library, jit_module._import_numba
    for one in caches:
        one.cache_clear()
    yield tmp_path
    for one in caches:
        one.cache_clear()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"sources": "0"}, "its kernels were changed since"),
        ({"platform": "another"}, "it is for another"),
        ({"library": "missing.so"}, "missing.so"),
        ({"library": "index.json"}, "index.json"),
        (None, "there is none"),
        ("{", "there is none"),
    ],
)
def test_a_library_that_cannot_be_used_is_said_in_one_sentence(library_folder, monkeypatch, capsys, change, reason):
    index = {"sources": kernel_library.digest_sources(), "platform": kernel_library.platform_name(), "library": "", "kernels": {}}
    if change:
        text = change if isinstance(change, str) else json.dumps(index | change)
        (library_folder / "index.json").write_text(text)
    for kernel in (find_active_stop, inertia_of_plane):
        assert find_kernel(kernel.__wrapped__, print) is None
        assert callable(Kernel(kernel.__wrapped__)._machine_code)
    message = capsys.readouterr().err
    assert message.startswith("kernels: the library is not used (")
    assert reason in message
    assert message.count("\n") == 1
    assert "make kernels" in message
    jit_module._import_numba.cache_clear()
    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(gm.GovernorMechanismError, match=r"make kernels.*pip install 'governor-mechanism\[jit\]'") as caught:
        Kernel(find_active_stop.__wrapped__)(1)
    assert reason in str(caught.value)


def test_a_command_says_in_one_sentence_that_numba_is_missing(tmp_path):
    code = (
        "import sys\n"
        "sys.modules['numba'] = None\n"
        "sys.argv = ['governor-mechanism', 'run', 'porter', '--no-film']\n"
        "from governor_mechanism.cli.main import main\n"
        "main()\n"
    )
    environment = os.environ | {"GOVERNOR_MECHANISM_JIT": "1"}
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    assert answer.returncode == 2
    assert "GOVERNOR_MECHANISM_JIT=1" in answer.stderr
    assert "pip install 'governor-mechanism[jit]'" in answer.stderr
    assert "Traceback" not in answer.stderr
