"""Share of small faults in the program that the tests notice.

A mutant is the package with one small fault: an operator, a comparison, a number, a condition or a statement is changed. It is killed if
a test fails. Mutants are a random sample of all that a folder has; messages, docstrings, annotations and examples for schemas are not
changed. A mutant exists in memory alone: the loader of its module compiles the changed syntax tree. Where a kernel contains the change, all
kernels run as Python: those of the library have no fault. Only tests that reach its line run, the shortest first, up to a limit of their
time (see `mutant_tests`): those of its folder, and then wider ones if the first ones notice nothing. Tests stop at
the first failure. A mutant that takes much longer than its tests do is killed by its time: it loops. A test that starts a process of its
own does not notice a mutant.

Tools that write mutants to files (cosmic-ray) would compile all kernels for every mutant; mutmut changes no function with a decorator, and
every kernel has one.

Usage: python benchmarks/mutants.py [closed_form effects mechanics] [--count 200] [--seed 18] [--only NUMBER ...] [--own]
                                    [--within PART ...] [--table mutants.tsv] [--reach mutants.reach]
"""

from __future__ import annotations

import argparse
import ast
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import math
import os
import random
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import CodeType

from mutant_tests import ReachRecorder, RecordedTest, read_record, record_place, tests_that_reach
from mutations import PACKAGE, SOURCE, Mutant, all_mutants, mutated_tree

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Tests:
    """Test files of a folder: its own, and wider ones for what those do not notice."""

    own: tuple[str, ...]
    wider: tuple[str, ...] = ()


ENGINE_TESTS = tuple(
    f"tests/engines/test_{name}.py"
    for name in (
        "combined_effects",
        "couplings",
        "effects",
        "hard_scenes",
        "inputs_and_reports",
        "joint_types",
        "limit_excursions",
        "reactions",
        "reduced",
        "reduced_shaft",
        "singular_configurations",
        "start_on_a_stop",
    )
)

TESTS = {
    "closed_form": Tests(
        ("tests/closed_form", "tests/refusals", "tests/machines/test_hartnell.py", "tests/machines/test_proell.py"), ("tests/machines",)
    ),
    "effects": Tests(("tests/effects", "tests/refusals", "tests/scenes/test_effect_tables.py", "tests/engines/test_effects.py")),
    "mechanics": Tests(("tests/mechanics", "tests/refusals"), ENGINE_TESTS),
}
"""Tests of each folder."""


LIBRARIES = ("hypothesis.strategies", "matplotlib.figure", "pint", "pymunk", "scipy.integrate", "scipy.optimize")
"""Imported once; the processes of the mutants share them."""


TEST_SECONDS = 30.0
"""CPU time of the tests of a mutant, s, its own and the wider ones each."""

FIRST_SECONDS, SECONDS_RATIO = 15.0, 2.0
"""Limit of the CPU time of a mutant: seconds for imports, and a ratio to what its tests take without one."""

MEMORY_LIMIT = 6 * 2**30
"""Limit of the memory of a mutant, bytes: a loop that grows an array ends."""

SEED = 18


# --- loading -----------------------------------------------------------------------------------------------------------


class MutantLoader(importlib.machinery.SourceFileLoader):
    """Loads modules of the package; that of the mutant with its fault."""

    mutant: Mutant | None = None

    def get_code(self, fullname: str) -> CodeType:
        """Return the compiled module."""
        if self.mutant is not None and fullname == self.mutant.module:
            return compile(ast.fix_missing_locations(mutated_tree(self.mutant)), self.path, "exec", dont_inherit=True)
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


def recorded_tests(folder: str, places: Sequence[str], is_interpreted: bool, base: Path) -> list[RecordedTest]:
    """Return the tests of a folder that pass, and what they reach; what is not recorded, or older than its test file, is recorded."""
    found: list[RecordedTest] = []
    for file in (file for place in places for file in _test_files(ROOT / place)):
        place = record_place(base, folder, file, is_interpreted)
        if not place.is_file() or place.stat().st_mtime < file.stat().st_mtime:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text("")
            recorder = ReachRecorder(str(SOURCE / PACKAGE / folder), place)
            run_tests([str(file)], None, is_interpreted, place.with_suffix(".log"), [recorder])
            print(f"{place.stem}: {len(read_record(place))} tests recorded", flush=True)
        found += read_record(place)
    return found


def _test_files(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("test_*.py"))


def run_tests(
    tests: Sequence[str],
    mutant: Mutant | None,
    is_interpreted: bool,
    output: Path,
    plugins: Sequence[object] = (),
    seconds: float = math.inf,
) -> str:
    """Return what tests say of a mutant: killed, timeout or survived. A child process runs them; imports of libraries are shared."""
    if not tests:
        return "survived"
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os._exit(_run_in_child(tests, mutant, is_interpreted, output, plugins, seconds))
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    return "survived" if code == 0 else "timeout" if code == -signal.SIGXCPU else "killed"


def _run_in_child(
    tests: Sequence[str], mutant: Mutant | None, is_interpreted: bool, output: Path, plugins: Sequence[object], seconds: float
) -> int:
    import numpy as np
    import pytest

    if is_interpreted:
        os.environ["GOVERNOR_MECHANISM_JIT"] = "0"
        np.seterr(all="ignore")  # as in compiled kernels
    if math.isfinite(seconds):
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    MutantLoader.mutant = mutant
    with output.open("w") as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)
        options = [
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
            "--assert=plain",
            "--tb=native",
            "--hypothesis-profile=mutants",
            f"--rootdir={ROOT}",
        ]
        if mutant is not None:
            options.append("-x")
        try:
            return int(pytest.main([*options, *tests], plugins=list(plugins)))
        except BaseException as error:  # whatever a mutant does, the test run did not pass
            print(f"{type(error).__name__}: {error}", flush=True)
            return 1
        finally:
            sys.stdout.flush()


def main(arguments: Sequence[str] | None = None) -> int:
    """Sample, run, and write a table."""
    parser = argparse.ArgumentParser(description="Share of small faults that the tests notice.")
    parser.add_argument("folders", nargs="*", default=list(TESTS))
    parser.add_argument("--count", type=int, default=200, help="mutants of each folder")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", type=int, nargs="+", help="numbers of mutants of the sample")
    parser.add_argument("--within", nargs="+", default=[""], help="parts of the paths of the files in question, as curves/ or contacts.py")
    parser.add_argument("--own", action="store_true", help="leave out the wider tests")
    parser.add_argument("--table", type=Path, default=Path("mutants.tsv"))
    parser.add_argument("--reach", type=Path, default=Path("mutants.reach"), help="folder of the record of the lines that tests reach")
    asked = parser.parse_args(arguments)
    for library in LIBRARIES:
        importlib.import_module(library)
    records, output = asked.reach.resolve(), asked.table.with_suffix(".log").resolve()
    asked.table = asked.table.resolve()
    os.chdir(ROOT)
    sys.meta_path.insert(0, MutantFinder())
    for folder in asked.folders:
        everything = [one for one in all_mutants(folder) if any(part in str(one.path) for part in asked.within)]
        sample = random.Random(asked.seed).sample(everything, min(asked.count, len(everything)))
        print(f"{folder}: {len(everything)} mutants, sample of {len(sample)}", flush=True)
        for is_interpreted in {mutant.is_in_kernels for mutant in sample} if asked.only is None else ():
            tests = sorted(recorded_tests(folder, TESTS[folder].own, is_interpreted, records), key=lambda test: test.seconds)
            if run_tests([test.name for test in tests], None, is_interpreted, output) != "survived":
                print(output.read_text(), f"{folder}: tests that pass alone fail together, without a mutant")
                return 1
        counts: Counter[str] = Counter()
        for number, mutant in enumerate(sample):
            if asked.only and number not in asked.only:
                continue
            begin = time.monotonic()
            verdict = judge_mutant(mutant, folder, asked.own, records, output)
            counts[verdict] += 1
            row = f"{folder}\t{number}\t{verdict}\t{mutant.place}\t{mutant.text}\t{time.monotonic() - begin:.1f}"
            with asked.table.open("a") as stream:
                stream.write(row + "\n")
            print(row, flush=True)
        print(folder, dict(counts), flush=True)
    return 0


def judge_mutant(mutant: Mutant, folder: str, own_alone: bool, records: Path, output: Path) -> str:
    """Return killed or timeout (by the folder's own tests), killed wider or timeout wider, or survived."""
    for kind, places in (("", TESTS[folder].own), (" wider", () if own_alone else TESTS[folder].wider)):
        tests = recorded_tests(folder, places, mutant.is_in_kernels, records)
        chosen = tests_that_reach(mutant, tests, TEST_SECONDS)
        seconds = FIRST_SECONDS + SECONDS_RATIO * sum(test.seconds for test in chosen)
        verdict = run_tests([test.name for test in chosen], mutant, mutant.is_in_kernels, output, seconds=seconds)
        if verdict != "survived":
            return verdict + kind
    return "survived"


if __name__ == "__main__":
    sys.exit(main())
