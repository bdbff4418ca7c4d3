"""Kernels without reference counts: none returns an array or gets one from another function, and memory is freed."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys

from governor_mechanism.numerics.jit import PACKAGE_ROOT

UNCOUNTED = {"jit_internal", "jit_in_place"}
SCALAR = re.compile(r"None|float|int|bool|\w+Status|tuple\[(float|int|bool|\w+Status)(, (float|int|bool))*\]")
COUNT_ALLOCATIONS = """
import gc, json
import governor_mechanism as gm
from numba.core.runtime import rtsys

counts = {}
for model in ("porter_dry_friction", "slider_crank_torque", "four_bar_chain"):
    for engine in ("reduced", "multibody", "impulse"):
        gm.run(model, engine=engine, times=[0.02], certify=False)
        gc.collect()
        before = rtsys.get_allocation_stats()
        gm.run(model, engine=engine, times=[0.02], certify=False)
        gc.collect()
        after = rtsys.get_allocation_stats()
        counts[f"{model} {engine}"] = after.alloc - before.alloc, after.free - before.free
print(json.dumps(counts))
"""


def kernels():
    """Return file, name, decorator, return annotation and called names of every decorated kernel."""
    found = []
    for path in sorted(PACKAGE_ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                for decorator in map(ast.unparse, node.decorator_list):
                    if decorator.startswith("jit"):
                        calls = [call.func for call in ast.walk(node) if isinstance(call, ast.Call)]
                        names = {call.attr if isinstance(call, ast.Attribute) else getattr(call, "id", "") for call in calls}
                        found.append((path.name, node.name, decorator, ast.unparse(node.returns), names))
    return found


def test_kernels_without_reference_counts_neither_return_arrays_nor_get_any():
    found = kernels()
    returning = {name for _, name, decorator, returns, _ in found if decorator != "jit_inline" and not SCALAR.fullmatch(returns)}
    uncounted = [kernel for kernel in found if kernel[2] in UNCOUNTED]
    assert len(uncounted) > 50
    assert len(returning) > 5
    assert not [kernel[:2] for kernel in uncounted if kernel[1] in returning]
    inlined = [kernel for kernel in found if kernel[2] == "jit_inline"]  # they take over the setting of their callers
    assert not [(*kernel[:2], kernel[4] & returning) for kernel in uncounted + inlined if kernel[4] & returning]


def test_what_kernels_allocate_is_freed():
    """Kernels that count no references must neither keep nor free the arrays that they are given."""
    environment = os.environ | {"NUMBA_NRT_STATS": "1"}
    answer = subprocess.run([sys.executable, "-c", COUNT_ALLOCATIONS], capture_output=True, text=True, check=True, env=environment)
    counts = json.loads(answer.stdout)
    assert len(counts) == 9
    for case, (allocated, freed) in counts.items():
        assert allocated == freed > 0, case
