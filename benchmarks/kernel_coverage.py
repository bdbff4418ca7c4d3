"""Which lines and branches of the kernels short runs and tests reach: the kernels run as Python, and coverage.py watches them.

Usage: python benchmarks/kernel_coverage.py. It prints what of each kernel is not reached, and the share of all that is. A line with
`pragma: no cover` or `no branch` is left out; the comment says why nothing reaches it.
"""

from __future__ import annotations

import ast
import json
import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

os.environ["GOVERNOR_MECHANISM_JIT"] = "0"

import coverage
import numpy as np
import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "governor_mechanism"
FOLDERS = ("numerics", "effects", "mechanics", "integrators", "engines")
ENGINES = ("reduced", "multibody", "impulse")
SLOW = {("andrews_squeezer", "reduced"), ("andrews_squeezer", "impulse")}
"""Runs that take minutes without a compiler and reach nothing that others do not."""

LONGER_RUNS = [
    ("porter", "reduced", 0.5, True),
    ("porter_dry_friction", "reduced", 1.0, True),
    ("porter_dry_friction", "multibody", 1.0, False),
    ("hartung_corrected", "reduced", 7.0, False),
    ("hartung_corrected", "multibody", 7.0, False),
    ("stiff_flyball", "multibody", 10.0, False),
    ("four_bar_chain", "multibody", 0.5, True),
    ("air_engine", "reduced", 1.0, False),
    ("governed_engine_cut_off", "multibody", 0.5, False),
]
"""Scene, engine, duration (s), and whether the run is certified, for what short runs do not reach."""


GOVERNOR = {
    "machine": "pendulum_governor",
    "dimensions": {"arm": 0.3, "offset": 0.04, "ball_mass": 5, "sleeve_mass": 20},
    "spindle": {"speed": "120 rpm"},
    "run": {"duration": 0.2, "output_interval": 0.05, "accuracy": 1e-4},
}
WEIGHTS = {"gravity": True, "centrifugal": True}
SHORT_SCENES: tuple[tuple[dict[str, Any], dict[str, Any], tuple[str, ...]], ...] = (
    ({"spring": {"sleeve": {"rate": 2000, "preload": 0, "zero": 0.15, "one_sided": True}}, "dry_friction": {"sleeve": "5 N"}},
     {"arm_angle": "38 deg", "arm_rate": 1.0}, ("reduced", "multibody")),
    ({"dashpot": {"sleeve": "50 N s/m"}, "stops": {"arm_angle": ["25 deg", "32 deg"], "restitution": 0.5}},
     {"arm_angle": "30 deg", "arm_rate": 2.0}, ("reduced", "multibody")),
    ({}, {"arm_angle": "85 deg", "arm_rate": 5.0}, ("reduced",)),
)  # fmt: skip
"""Effects beside weights, start, and engines of governors: a spring that becomes taut, strikes, a motion beyond the travel."""

TESTS = (
    "numerics",
    "integrators",
    "mechanics/test_contact_rules.py",
    "mechanics/test_impacts.py",
    "mechanics/test_inputs.py",
    "mechanics/test_motion_table.py",
    "mechanics/test_two_formulations.py",
    "engines/test_start_on_a_stop.py",
    "engines/test_limit_excursions.py",
    "engines/test_table_ends.py",
)
"""Tests that call kernels by themselves, or runs that end in special ways."""


def run_scenes() -> None:
    """Run all shipped scenes shortly, and some longer."""
    import governor_mechanism as gm

    for name in gm.list_models():
        for engine in ENGINES:
            if (name, engine) not in SLOW:
                try:
                    gm.run(name, engine=engine, times=[0.0, 0.02], certify=False)
                except gm.UnsupportedEffect:
                    continue
    for name, engine, duration, is_certified in LONGER_RUNS:
        run = gm.run(name, engine=engine, times=np.linspace(0.0, duration, 5), certify=is_certified)
        print(f"{name:24s} {engine:10s} {run.outcome.name}, {run.cost.steps} steps", flush=True)
    for effects, start, engines in SHORT_SCENES:
        scene = gm.Scene.from_dict(GOVERNOR | {"effects": WEIGHTS | effects, "start": start})
        for engine in engines:
            gm.run(scene, engine=engine, certify=False)
    gm.kinematics("porter", "arm_angle", [0.5, 0.6])
    gm.linearise("haug_governor")


def run_tests() -> None:
    """Run the tests; those of `impulse`, which has few kernels, are left out."""
    options = ["-q", "-p", "no:cacheprovider", "-W", "ignore", "--hypothesis-profile=mutants", "--durations=10"]
    options += ["-m", "not long", "-k", "not impulse and not Impulse and not bounces and not turning_point and not uncompiled"]
    tests = Path(__file__).parents[1] / "tests"
    if pytest.main([*options, *(str(tests / name) for name in TESTS)]) != 0:
        print("a test fails without a compiler", flush=True)


def compiled_functions() -> set[str]:
    """Return the names of functions that are compiled where they are called by name: jit(function)."""
    names = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("jit", "jit_in_place"):
                names |= {ast.unparse(argument).rpartition(".")[2] for argument in node.args}
    return names


def kernels_of(tree: ast.Module, compiled: set[str]) -> Iterator[ast.FunctionDef]:
    """Yield the kernels of a file: decorated functions, those compiled by name, and what a function that makes kernels returns."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            decorators = {ast.unparse(decorator) for decorator in node.decorator_list}
            if decorators & {"jit", "jit_in_place"} or node.name in compiled:
                yield node
            elif node.name.lstrip("_").startswith("make_") and "Callable" in ast.unparse(node.returns or ast.Constant(0)):
                yield from (inner for inner in node.body if isinstance(inner, ast.FunctionDef))


def report(data: coverage.Coverage) -> None:
    """Print what of each kernel is not reached, and the share of all lines and branches."""
    with tempfile.TemporaryDirectory() as folder:
        data.json_report(outfile=f"{folder}/coverage.json")
        files = json.loads(Path(folder, "coverage.json").read_text(encoding="utf-8"))["files"]
    compiled, n_kernels, counts = compiled_functions(), 0, np.zeros((2, 2), dtype=int)
    for path in sorted(path for folder in FOLDERS for path in (PACKAGE / folder).rglob("*.py")):
        text, found = path.read_text(encoding="utf-8"), next((one for name, one in files.items() if Path(name).resolve() == path), None)
        if "numerics.jit import" not in text or found is None:
            continue
        for kernel in kernels_of(ast.parse(text), compiled):
            lines = range(kernel.body[0].lineno, (kernel.end_lineno or kernel.lineno) + 1)
            missing_lines = [line for line in found["missing_lines"] if line in lines]
            missing_branches = [f"{one}->{other}" for one, other in found["missing_branches"] if one in lines and one not in missing_lines]
            n_kernels += 1
            counts[0] += len(missing_lines), sum(line in lines for line in found["executed_lines"])
            counts[1] += len(missing_branches), sum(one in lines for one, _ in found["executed_branches"])
            if missing_lines or missing_branches:
                print(f"{path.relative_to(PACKAGE)}: {kernel.name}: {', '.join([*map(str, missing_lines), *missing_branches])}")
    lines_reached, branches_reached = 100 * counts[:, 1] / counts.sum(axis=1)
    print(f"{n_kernels} kernels, {counts[0].sum()} lines, {lines_reached:.1f} % reached; {branches_reached:.1f} % of the branches in them")


def main() -> None:
    """Run scenes and tests under observation and print the report."""
    data = coverage.Coverage(source=[str(PACKAGE / folder) for folder in FOLDERS], data_file=None, branch=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data.start()
        run_scenes()
        run_tests()
        data.stop()
    report(data)


if __name__ == "__main__":
    main()
