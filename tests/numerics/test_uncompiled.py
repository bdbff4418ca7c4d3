"""Kernels run as plain Python, for a debugger, and return what the compiled ones return."""

import json
import os
import subprocess
import sys

import pytest

RUN_SCENES = """
import json
import sys
import governor_mechanism as gm
results = {}
for model, engine, time in json.loads(sys.argv[1]):
    run = gm.run(model, engine=engine, times=[0.0, time], certify=False)
    results[f"{model} {engine}"] = [{name: values.tolist() for name, values in run.readings.items()}, run.cost.steps, len(run.events)]
print(json.dumps([results, "numba" in sys.modules]))
"""
SHORT_CASES = [["porter", engine, 0.1] for engine in ("reduced", "multibody", "impulse")]
CASES = [
    *(["porter_dry_friction", engine, 0.4] for engine in ("reduced", "multibody", "impulse")),
    *(["air_engine", engine, 0.1] for engine in ("reduced", "multibody")),
    ["hartung_corrected", "reduced", 0.1],
    ["stiff_flyball", "multibody", 0.05],
    ["governed_engine", "multibody", 0.05],
    ["car_axis_like", "multibody", 0.05],
]


def run_scenes(cases, compiler):
    """Return readings, steps and events of cases in a process of its own, and whether it has loaded numba."""
    environment = os.environ | {"GOVERNOR_MECHANISM_JIT": compiler}
    command = [sys.executable, "-W", "ignore", "-c", RUN_SCENES, json.dumps(cases)]
    answer = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return json.loads(answer.stdout)


@pytest.mark.parametrize("cases", [SHORT_CASES, pytest.param(CASES, marks=pytest.mark.long)])
def test_kernels_without_a_compiler_return_the_same(cases):
    (compiled, _), (uncompiled, has_numba) = run_scenes(cases, ""), run_scenes(cases, "0")
    assert not has_numba
    assert compiled.keys() == uncompiled.keys()
    for case, (readings, steps, n_events) in compiled.items():
        other_readings, other_steps, other_n_events = uncompiled[case]
        assert (steps, n_events) == (other_steps, other_n_events), case
        for name, values in readings.items():
            # The compiler joins products and sums of a few functions, and the library of functions is another one.
            assert other_readings[name] == pytest.approx(values, rel=1e-11, abs=1e-11), (case, name)
