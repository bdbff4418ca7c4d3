"""Tests that reach a line of the package, and how long each takes: recorded once, so that a mutant runs only those that can notice it."""

from __future__ import annotations

import hashlib
import importlib
import json
import random
import signal
import sys
import time
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import coverage
import pytest

from mutations import PACKAGE, SOURCE, Mutant

SECONDS_OF_A_TEST = 10.0
"""Tests with more CPU time are left out, s: interpreted kernels are some hundred times slower than compiled ones."""

SECONDS_OF_A_FILE = 120.0
"""After this CPU time no further tests of a file are recorded, s."""


DELAY_OF_OTHERS = 10.0
"""Factor on the time of tests that do not reach the file of a mutant, where they take turns with those that do."""


class TooLong(BaseException):
    """A test exceeds its time."""


@dataclass(frozen=True)
class RecordedTest:
    """A test that passes: its name for pytest, its CPU time in s, and the lines of a folder that it reaches."""

    name: str
    seconds: float
    lines: frozenset[tuple[str, int]]

    def reaches(self, path: Path) -> bool:
        """Return whether a file is reached."""
        return any(name == str(path) for name, _ in self.lines)


@dataclass
class ReachRecorder:
    """Plugin of pytest that appends to a file, as lines of JSON, what each test that passes reaches in a folder."""

    folder: str
    output: Path
    coverage: coverage.Coverage = field(init=False)
    has_passed: bool = True

    def pytest_sessionstart(self) -> None:
        """Import the folder, lest the first test seem to reach what runs then."""
        self.coverage = coverage.Coverage(data_file=None, config_file=False, include=[f"{self.folder}/*"], messages=False)
        self.coverage.set_option("run:disable_warnings", ["no-data-collected"])
        for path in sorted(Path(self.folder).rglob("*.py")):
            importlib.import_module(".".join(path.relative_to(SOURCE).with_suffix("").parts))

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Mix the tests, so that the time of a file is spent on different ones."""
        random.Random(len(items)).shuffle(items)

    def pytest_runtest_setup(self) -> None:
        """Leave out tests when the time of the file is over."""
        if time.process_time() > SECONDS_OF_A_FILE:
            pytest.skip("the time of the file is over")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Trace one test, which finds nothing in caches that another one has filled."""
        _clear_caches()
        self.has_passed = True
        signal.signal(signal.SIGPROF, _end_test)
        begin = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, SECONDS_OF_A_TEST, 1.0)
        self.coverage.start()
        try:
            return (yield)
        finally:
            self.coverage.stop()
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            seconds, reached = time.process_time() - begin, self.coverage.get_data()
            lines = [(file, line) for file in reached.measured_files() for line in reached.lines(file) or ()]
            self.coverage.erase()
            if self.has_passed:
                with self.output.open("a") as stream:
                    stream.write(json.dumps([item.nodeid, seconds, lines]) + "\n")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a test that fails or is left out."""
        self.has_passed = self.has_passed and report.passed


def _clear_caches() -> None:
    for name, module in list(sys.modules.items()):
        for function in list(vars(module).values()) if name.split(".")[0] == PACKAGE else ():
            if hasattr(function, "cache_clear"):
                function.cache_clear()


def _end_test(number: int, frame: object) -> None:
    raise TooLong


def record_place(base: Path, folder: str, test_file: Path, is_interpreted: bool) -> Path:
    """Return the file of the record of a test file; it is another one when the folder of the package changes."""
    digest = hashlib.sha256()
    for path in sorted((SOURCE / PACKAGE / folder).rglob("*.py")):
        digest.update(path.read_bytes())
    kind = "interpreted" if is_interpreted else "compiled"
    return base / f"{folder}-{digest.hexdigest()[:12]}" / f"{test_file.parent.name}-{test_file.stem}-{kind}.jsonl"


def read_record(place: Path) -> tuple[RecordedTest, ...]:
    """Return the tests of a record."""
    return _read_record(place, place.stat().st_mtime)


@cache
def _read_record(place: Path, time_of_change: float) -> tuple[RecordedTest, ...]:
    rows = [json.loads(line) for line in place.read_text().splitlines()]
    return tuple(RecordedTest(name, seconds, frozenset((path, line) for path, line in lines)) for name, seconds, lines in rows)


def tests_that_reach(mutant: Mutant, tests: Iterable[RecordedTest], seconds_limit: float) -> list[RecordedTest]:
    """Return the tests that reach the line of a mutant, the shortest first, within a limit of their time in all, s.

    A line that runs when its module is imported is reached by none: there it is all tests, those that reach any line of the file
    before others of the same length.
    """
    reaching = [test for test in tests if (str(mutant.path), mutant.line) in test.lines]
    chosen: list[RecordedTest] = []
    for test in sorted(reaching or tests, key=lambda one: one.seconds * (1.0 if one.reaches(mutant.path) else DELAY_OF_OTHERS)):
        seconds_limit -= test.seconds
        if seconds_limit < 0.0 and chosen:
            break
        chosen.append(test)
    return chosen
