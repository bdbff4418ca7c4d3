"""Kernels without reference counts: none returns an array or gets one from another function."""

import ast
import math
import re

import pytest

from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT

UNCOUNTED = {"jit_in_place", "jit_inlined"}
SCALAR = re.compile(r"None|float|int|bool|\w+Status|tuple\[(float|int|bool|\w+Status)(, (float|int|bool))*\]")


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
