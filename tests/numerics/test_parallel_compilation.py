"""Kernels compiled in a second process, and the line on the terminal meanwhile."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import threading

import pytest

from governor_mechanism.numerics import compilation_progress, parallel_compilation
from governor_mechanism.numerics.compilation_progress import CLEAR_LINE, show_compilation

COMPILE_BESIDE = """
import json, sys
import numpy as np
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_curve
from governor_mechanism.numerics import parallel_compilation
from governor_mechanism.numerics.parallel_compilation import compiled_beside

parallel_compilation._has_free_processor = lambda: True
arguments = np.array([[0.0, 1.0, 0.0, 0.0, 0.0]]), 0, 1, 2.0
if "broken" in sys.argv:
    sys.executable = "/no/such/python"
with compiled_beside(evaluate_curve, lambda: arguments):
    pass
result = evaluate_curve(*arguments)
stats = evaluate_curve._dispatcher.stats
print(json.dumps([result, sum(stats.cache_hits.values()), sum(stats.cache_misses.values())]))
"""


@pytest.mark.long
@pytest.mark.parametrize(("option", "hits", "misses"), [("", 1, 0), ("broken", 0, 1)])
def test_a_second_process_compiles_for_this_one_or_this_one_compiles_itself(tmp_path, monkeypatch, option, hits, misses):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    answer = subprocess.run([sys.executable, "-c", COMPILE_BESIDE, option], capture_output=True, text=True, check=True)
    assert json.loads(answer.stdout) == [[8.0, 12.0, 12.0], hits, misses]


class _Kernel:
    __name__ = "kernel"
    is_compiled = False


def test_an_interrupt_ends_the_second_process(monkeypatch):
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    monkeypatch.setattr(parallel_compilation, "_has_free_processor", lambda: True)
    monkeypatch.setattr(parallel_compilation, "_start_compilation", lambda kernel, arguments: process)
    with pytest.raises(KeyboardInterrupt), parallel_compilation.compiled_beside(_Kernel(), tuple):
        raise KeyboardInterrupt
    assert process.poll() is not None


@pytest.mark.parametrize(("is_compiled", "has_processor"), [(True, True), (False, False)])
def test_no_second_process_for_a_compiled_kernel_or_on_one_processor(monkeypatch, is_compiled, has_processor):
    started = []
    monkeypatch.setattr(parallel_compilation, "_has_free_processor", lambda: has_processor)
    monkeypatch.setattr(parallel_compilation, "_start_compilation", lambda kernel, arguments: started.append(kernel))
    kernel = _Kernel()
    kernel.is_compiled = is_compiled
    with parallel_compilation.compiled_beside(kernel, tuple):
        pass
    assert started == []


class _Stream(io.StringIO):
    """A stream that knows whether it is a terminal, and tells when a moving line has changed."""

    def __init__(self, is_terminal):
        super().__init__()
        self.is_terminal, self.has_moved, self.lines = is_terminal, threading.Event(), set()

    def isatty(self):
        return self.is_terminal

    def write(self, text):
        self.lines.add(text)
        if len(self.lines) > 1:
            self.has_moved.set()
        return super().write(text)


def test_the_line_on_a_terminal_moves_and_disappears(monkeypatch):
    stream = _Stream(is_terminal=True)
    for name in ("stderr", "__stderr__"):
        monkeypatch.setattr(sys, name, stream)
    monkeypatch.setattr(compilation_progress, "FIRST_SHOWN", 0.0)
    with show_compilation("integrate"):
        assert stream.has_moved.wait(30.0)
    shown = stream.getvalue().split(CLEAR_LINE)
    assert len(set(shown[1:-1])) > 1
    assert all(line.startswith("compiling kernels, once for this version: integrate, ") for line in shown[1:-1])
    assert shown[-1] == ""


@pytest.mark.parametrize("is_replaced", [False, True])
def test_no_line_in_a_pipe_or_where_another_display_writes(monkeypatch, is_replaced):
    stream = _Stream(is_terminal=is_replaced)
    monkeypatch.setattr(sys, "stderr", stream)
    if not is_replaced:
        monkeypatch.setattr(sys, "__stderr__", stream)
    monkeypatch.setattr(compilation_progress, "FIRST_SHOWN", 0.0)
    monkeypatch.setattr(compilation_progress, "REFRESH_INTERVAL", 0.001)
    with show_compilation("integrate"):
        assert not stream.has_moved.wait(0.1)
    assert stream.getvalue() == ""
