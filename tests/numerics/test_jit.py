"""Kernels without reference counts: none returns an array or gets one from another function, and memory is freed."""

from __future__ import annotations

import ast
import json
import math
import os
import re
import subprocess
import sys

import pytest

from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT

UNCOUNTED = {"jit_in_place"}
SCALAR = re.compile(r"None|float|int|bool|\w+Status|tuple\[(float|int|bool|\w+Status)(, (float|int|bool))*\]")
COUNT_ALLOCATIONS = """
import gc, json
import governor_mechanism as gm
from numba.core.runtime import rtsys

gc.freeze()  # what is loaded by now need not be searched
counts = {}
for model in ("porter_dry_friction", "slider_crank_torque", "four_bar_chain"):
    for engine in ("reduced", "multibody", "impulse"):
        gm.run(model, engine=engine, times=[0.02], certify=False)
        for duration in (0.02, 0.08):
            gc.collect()
            before = rtsys.get_allocation_stats()
            gm.run(model, engine=engine, times=[duration], certify=False)
            gc.collect()
            after = rtsys.get_allocation_stats()
            counts[f"{model} {engine} {duration}"] = after.alloc - before.alloc, after.free - before.free
print(json.dumps(counts))
"""


def scalar_records():
    """Return the names of the named tuples whose fields are all numbers."""
    names = set()
    for path in PACKAGE_ROOT.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if "NamedTuple" in text else ():
            if isinstance(node, ast.ClassDef) and "NamedTuple" in map(ast.unparse, node.bases):
                fields = [ast.unparse(field.annotation) for field in node.body if isinstance(field, ast.AnnAssign)]
                if set(fields) <= {"float", "int", "bool"}:
                    names.add(node.name)
    return names


def kernels():
    """Return file, name, decorator, return annotation and called names of every decorated kernel."""
    found = []
    for path in sorted(PACKAGE_ROOT.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if "@jit" in text else ():
            if isinstance(node, ast.FunctionDef):
                for decorator in map(ast.unparse, node.decorator_list):
                    if decorator.startswith("jit"):
                        calls = [call.func for call in ast.walk(node) if isinstance(call, ast.Call)]
                        names = {call.attr if isinstance(call, ast.Attribute) else getattr(call, "id", "") for call in calls}
                        found.append((path.name, node.name, decorator, ast.unparse(node.returns), names))
    return found


def test_kernels_without_reference_counts_neither_return_arrays_nor_get_any():
    found = kernels()
    records = scalar_records()
    returning = {name for _, name, _, returns, _ in found if not SCALAR.fullmatch(returns) and returns not in records}
    uncounted = [kernel for kernel in found if kernel[2] in UNCOUNTED]
    assert len(uncounted) > 50
    assert len(returning) > 5
    assert not [kernel[:2] for kernel in uncounted if kernel[1] in returning]
    assert not [(*kernel[:2], kernel[4] & returning) for kernel in uncounted if kernel[4] & returning]


def test_a_kernel_called_by_a_kernel_has_no_machine_code_of_its_own():
    @jit_in_place
    def square(value: float) -> float:
        return value * value

    @jit
    def fourth_power(value: float) -> float:
        return square(square(value))

    assert fourth_power(3.0) == 81.0
    assert fourth_power.is_loaded
    assert not square.is_loaded
    assert square(3.0) == 9.0


def test_an_error_in_a_called_kernel_reaches_python():
    @jit_in_place
    def root(value: float) -> float:
        if value < 0.0:
            raise ValueError("a negative number has no real root")
        return math.sqrt(value)

    @jit
    def fourth_root(value: float) -> float:
        return root(root(value))

    assert fourth_root(81.0) == pytest.approx(3.0)
    with pytest.raises(ValueError, match="a negative number has no real root"):
        fourth_root(-1.0)


@pytest.mark.long
def test_what_kernels_allocate_is_freed_and_steps_allocate_nothing():
    """Kernels that count no references must neither keep nor free the arrays that they are given."""
    environment = os.environ | {"NUMBA_NRT_STATS": "1", "GOVERNOR_MECHANISM_JIT": "1"}
    answer = subprocess.run([sys.executable, "-c", COUNT_ALLOCATIONS], capture_output=True, text=True, check=True, env=environment)
    counts = json.loads(answer.stdout)
    assert len(counts) == 18
    for case, (allocated, freed) in counts.items():
        assert allocated == freed, case
    assert max(allocated for allocated, _ in counts.values()) > 0
    for case in ("slider_crank_torque multibody", "four_bar_chain multibody", "slider_crank_torque impulse", "four_bar_chain impulse"):
        assert counts[f"{case} 0.02"] == counts[f"{case} 0.08"], case
