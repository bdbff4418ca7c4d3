"""Which lines of the kernels some short runs reach: the kernels run as plain Python, and coverage.py watches them.

Usage: python benchmarks/kernel_coverage.py. It prints the lines of each kernel that are not reached, and the share of all that are.
"""

from __future__ import annotations

import ast
import os
import warnings
from collections.abc import Iterator
from pathlib import Path

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


UNIT_TESTS = (
    "numerics/test_banded_cholesky.py",
    "numerics/test_dense_lu.py",
    "mechanics/test_contact_rules.py",
    "mechanics/test_impacts.py",
    "mechanics/test_inputs.py",
)
"""Tests that call kernels by themselves."""


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
    gm.kinematics("porter", "arm_angle", [0.5, 0.6])
    gm.linearise("haug_governor")


def run_unit_tests() -> None:
    """Run tests that call kernels by themselves."""
    options = ["-q", "-p", "no:cacheprovider", "-W", "ignore", "--hypothesis-profile=mutants"]
    tests = Path(__file__).parents[1] / "tests"
    if pytest.main([*options, *(str(tests / name) for name in UNIT_TESTS)]) != 0:
        raise SystemExit("a test of kernels fails without a compiler")


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
    """Print what of each kernel is not reached, and the share of all."""
    compiled, n_kernels, n_lines, n_missing = compiled_functions(), 0, 0, 0
    for path in sorted(path for folder in FOLDERS for path in (PACKAGE / folder).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "numerics.jit import" not in text:
            continue
        _, statements, _, missing, _ = data.analysis2(str(path))
        for kernel in kernels_of(ast.parse(text), compiled):
            lines = range(kernel.body[0].lineno, (kernel.end_lineno or kernel.lineno) + 1)
            n_kernels += 1
            n_lines += sum(line in lines for line in statements)
            not_reached = [line for line in missing if line in lines]
            n_missing += len(not_reached)
            if not_reached:
                print(f"{path.relative_to(PACKAGE)}: {kernel.name}: lines {', '.join(map(str, not_reached))}")
    print(f"{n_kernels} kernels, {n_lines} lines, {100 * (1 - n_missing / n_lines):.1f} % reached")


def main() -> None:
    """Run the scenes under observation and print the report."""
    data = coverage.Coverage(source=[str(PACKAGE / folder) for folder in FOLDERS], data_file=None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data.start()
        run_scenes()
        run_unit_tests()
        data.stop()
    report(data)


if __name__ == "__main__":
    main()
