"""Share of small faults in the program that the tests notice.

A mutant is the package with one small fault: an operator, a comparison, a number, a condition or a statement is changed. It is killed if
a test fails. Mutants are a random sample of all that a folder has; messages, docstrings, annotations and examples for schemas are not
changed. A mutant exists in memory alone: the loader of its module compiles the changed syntax tree. Kernels that contain the change are
interpreted, not compiled, so that a mutant costs seconds. Tests stop at the first failure; those that import the module of the mutant run
first. A mutant that takes longer than the limit is killed by its time: it loops.

Tools that write mutants to files (cosmic-ray) would compile all kernels for every mutant; mutmut changes no function with a decorator, and
every kernel has one.

Usage: python benchmarks/mutants.py [closed_form effects mechanics] [--count 200] [--seed 18] [--only NUMBER ...] [--table mutants.tsv]
"""

from __future__ import annotations

import argparse
import ast
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import random
import resource
import shutil
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import CodeType

from mutations import PACKAGE, SOURCE, Mutant, all_mutants, mutated_tree

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Tests:
    """Tests of a folder: files where kernels are compiled, files where they are interpreted, and which tests of these are short enough."""

    compiled: tuple[str, ...]
    interpreted: tuple[str, ...]
    short: str = ""


CONTACT_TESTS, IMPACT_TESTS = ("tests/engines/test_effects.py",), "tests/mechanics/test_impacts.py"

MECHANICS_TESTS = ("tests/mechanics", "tests/engines/test_joint_types.py")
SHORT_MECHANICS_TESTS = (
    "not impulse and not equilibria and not equilibrium_speed and not traced_range_of_a_governor and not period_ends "
    "and not agree_with_the_run and not torque_of_a_drive and not elliptic_integral and not table_of_a_parabola"
)

TESTS = {
    "closed_form": Tests(("tests/closed_form",), ("tests/closed_form",)),
    "effects": Tests(
        ("tests/effects", "tests/scenes/test_effect_tables.py"),
        ("tests/effects", *CONTACT_TESTS),
        "(linear_dashpot_stops and reduced) or (test_descriptions and not governor and not rods and not play and not row)",
    ),
    "mechanics/contact": Tests(
        (*CONTACT_TESTS, IMPACT_TESTS),
        (*CONTACT_TESTS, IMPACT_TESTS),
        "test_impacts or (not impulse and "
        "(reduced_friction or friction_oscillator or elastic_stop or stop_with_friction or one_sided or held_values))",
    ),
    "mechanics/reduction": Tests((*MECHANICS_TESTS, "tests/engines/test_reduced_shaft.py"), MECHANICS_TESTS, SHORT_MECHANICS_TESTS),
    "mechanics/dynamics": Tests(
        (*MECHANICS_TESTS, "tests/engines/test_reactions.py", *CONTACT_TESTS), MECHANICS_TESTS, SHORT_MECHANICS_TESTS
    ),
    "mechanics": Tests(MECHANICS_TESTS, MECHANICS_TESTS, SHORT_MECHANICS_TESTS),
}
"""Tests of each folder: its own, and those of the engines that test it directly; the first name that fits a file."""


LIBRARIES = ("hypothesis.strategies", "matplotlib.figure", "pint", "pydantic", "pymunk", "scipy.integrate", "scipy.optimize")
"""Imported once; the processes of the mutants share them."""

FOLDERS = ("closed_form", "effects", "mechanics")


def tests_of(mutant: Mutant) -> Tests:
    """Return the tests of a mutant."""
    place = str(mutant.path.relative_to(SOURCE / PACKAGE))
    return next(tests for folder, tests in TESTS.items() if place.startswith(folder))


SECONDS_LIMIT = 150
"""Limit of the CPU time of a mutant, s: more than twice what the tests of a folder take."""

MEMORY_LIMIT = 6 * 2**30
"""Limit of the memory of a mutant, bytes: a loop that grows an array ends."""

SEED = 18


# --- loading -----------------------------------------------------------------------------------------------------------


class _NamedRecords(ast.NodeTransformer):
    """Types of records give their elements attributes, as compiled kernels do."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if ast.unparse(node.func) == "np.dtype":
            node.args = [ast.Tuple(elts=[ast.parse("np.record", mode="eval").body, node.args[0]], ctx=ast.Load())]
        return node


def _compile(tree: ast.Module, path: str) -> CodeType:
    return compile(ast.fix_missing_locations(_NamedRecords().visit(tree)), path, "exec", dont_inherit=True)


class MutantLoader(importlib.machinery.SourceFileLoader):
    """Loads modules of the package; that of the mutant with its fault."""

    mutant: Mutant | None = None

    def get_code(self, fullname: str) -> CodeType:
        """Return the compiled module."""
        if self.mutant is not None and fullname == self.mutant.module:
            return _compile(mutated_tree(self.mutant), self.path)
        text = Path(self.path).read_text(encoding="utf-8")
        if "np.dtype(" in text:
            return _compile(ast.parse(text), self.path)
        code = super().get_code(fullname)
        assert code is not None
        return code


class MutantFinder(importlib.abc.MetaPathFinder):
    """Finds the modules of the package in the source folder."""

    def find_spec(self, fullname: str, path: object, target: object = None) -> importlib.machinery.ModuleSpec | None:
        """Return the place of a module of the package."""
        if fullname.split(".")[0] != PACKAGE:
            return None
        base = SOURCE.joinpath(*fullname.split("."))
        if base.is_dir():
            loader = MutantLoader(fullname, str(base / "__init__.py"))
            return importlib.util.spec_from_file_location(fullname, loader.path, loader=loader, submodule_search_locations=[str(base)])
        loader = MutantLoader(fullname, str(base.with_suffix(".py")))
        return importlib.util.spec_from_file_location(fullname, loader.path, loader=loader)


# --- runs --------------------------------------------------------------------------------------------------------------


def ordered_tests(places: Sequence[str], mutant: Mutant | None) -> list[str]:
    """Return test files, those that import the mutant's module first, then those that import its neighbours."""
    files = [file for place in places for file in _test_files(ROOT / place)]
    if mutant is None:
        return [str(file) for file in files]
    parent, _, stem = mutant.module.rpartition(".")

    def distance(file: Path) -> tuple[int, int]:
        text = file.read_text(encoding="utf-8")
        imports_it = mutant.module in text or f"from {parent} import {stem}" in text
        return (0 if imports_it else 1 if parent in text else 2), 0 if stem in file.stem else 1

    return [str(file) for file in sorted(files, key=distance)]


def _test_files(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("test_*.py"))


def run_tests(tests: Tests, mutant: Mutant | None, is_interpreted: bool, output: Path) -> str:
    """Return what the tests say of a mutant: killed, timeout or survived. A child process runs them; imports of libraries are shared."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os._exit(_run_in_child(tests, mutant, is_interpreted, output))
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    return "survived" if code == 0 else "timeout" if code == -signal.SIGXCPU else "killed"


def use_kernel_cache_copy(folder: Path) -> None:
    """Let compiled kernels come from a copy of the cache: one that a mutant compiles must not stay."""
    for cache in (SOURCE / PACKAGE / "__pycache__").glob("kernels-*"):
        shutil.copytree(cache, folder / "governor-mechanism" / cache.name, dirs_exist_ok=True)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)


def _run_in_child(tests: Tests, mutant: Mutant | None, is_interpreted: bool, output: Path) -> int:
    import numba.core.config
    import numpy as np
    import pytest

    numba.core.config.DISABLE_JIT = is_interpreted
    if is_interpreted:
        np.seterr(all="ignore")  # as in compiled kernels
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS_LIMIT, SECONDS_LIMIT + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    MutantLoader.mutant = mutant
    with output.open("w") as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)
        options = [
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
            "--rootdir",
            str(ROOT),
            "--assert=plain",
            "--durations=8",
            "--hypothesis-profile=mutants",
        ]
        if is_interpreted and tests.short:
            options += ["-k", tests.short]
        try:
            return int(pytest.main([*options, *ordered_tests(tests.interpreted if is_interpreted else tests.compiled, mutant)]))
        except BaseException as error:  # whatever a mutant does, the test run did not pass
            print(f"{type(error).__name__}: {error}", flush=True)
            return 1
        finally:
            sys.stdout.flush()


def main(arguments: Sequence[str] | None = None) -> int:
    """Sample, run, and write a table."""
    parser = argparse.ArgumentParser(description="Share of small faults that the tests notice.")
    parser.add_argument("folders", nargs="*", default=list(FOLDERS))
    parser.add_argument("--count", type=int, default=200, help="mutants of each folder")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", type=int, nargs="+", help="numbers of mutants of the sample")
    parser.add_argument("--trust", action="store_true", help="leave out the run without a mutant")
    parser.add_argument("--table", type=Path, default=Path("mutants.tsv"))
    asked = parser.parse_args(arguments)
    use_kernel_cache_copy(asked.table.with_suffix(".kernels"))
    for library in LIBRARIES:
        importlib.import_module(library)
    sys.meta_path.insert(0, MutantFinder())
    output = asked.table.with_suffix(".log")
    for folder in asked.folders:
        everything = all_mutants(folder)
        sample = random.Random(asked.seed).sample(everything, min(asked.count, len(everything)))
        print(f"{folder}: {len(everything)} mutants, sample of {len(sample)}", flush=True)
        for tests, is_interpreted in {(tests_of(mutant), mutant.is_in_kernels): None for mutant in sample} if not asked.trust else ():
            begin = time.monotonic()
            if run_tests(tests, None, is_interpreted, output) != "survived":
                print(output.read_text(), f"{folder}: the tests fail without a mutant")
                return 1
            seconds = time.monotonic() - begin
            print(f"tests {'with interpreted kernels ' * is_interpreted}take {seconds:.0f} s: {tests.compiled}", flush=True)
        counts = {"killed": 0, "timeout": 0, "survived": 0}
        for number, mutant in enumerate(sample):
            if asked.only and number not in asked.only:
                continue
            begin = time.monotonic()
            verdict = run_tests(tests_of(mutant), mutant, mutant.is_in_kernels, output)
            counts[verdict] += 1
            row = f"{folder}\t{number}\t{verdict}\t{mutant.place}\t{mutant.text}\t{time.monotonic() - begin:.1f}"
            with asked.table.open("a") as stream:
                stream.write(row + "\n")
            if verdict != "killed":
                print(row, flush=True)
        print(folder, counts, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
