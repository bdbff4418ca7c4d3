"""The digest of kernels: it changes with all that a kernel is made from, and with nothing else."""

import json
import os

import pytest

from governor_mechanism.numerics import kernel_library
from governor_mechanism.numerics.kernel_sources import KernelSources, read_texts

TEXTS = {
    "governor_mechanism.records": '''
"""Records."""
from typing import NamedTuple
from governor_mechanism.numerics.jit import record_dtype
BODY_DTYPE = record_dtype(("mass", "f8"), ("plane", "i8"))
"""A body."""
class Times(NamedTuple):
    """Times of a step."""
    start: float
    end: float
def make_bodies(masses):
    return [(mass, 0) for mass in masses]
''',
    "governor_mechanism.laws": '''
from dataclasses import dataclass
DENSITY = 1.2
WEIGHTS = [1.0, 2.0]
WEIGHTS[0] *= 0.5
@dataclass
class Drag(Law):
    """Drag."""
    area: float = quantity("area of the body")
    @staticmethod
    def force(coefficients, value):
        return WEIGHTS[0] * DENSITY * coefficients[0] * value
    @property
    def report(self):
        return "drag"
class Spring:
    @staticmethod
    def force(coefficients, value):
        return -coefficients[0] * value
''',
    "governor_mechanism.registry": """
from governor_mechanism.laws import Drag, Spring
LAWS = (Drag, Spring)
""",
    "governor_mechanism.forces": '''
import math
from enum import IntEnum
from math import sin
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.records import Times
from governor_mechanism.registry import LAWS
class Kind(IntEnum):
    FREE = 0
    HELD = 1
def make_caller(functions):
    first = jit(functions[0])
    def call(value):
        return first(value)
    return jit(call)
call_law = make_caller([law.force for law in LAWS])
@jit_in_place
def clamp(value: float) -> float:
    """Return a value below 1."""
    return min(value, 1.0)  # it is dimensionless
@jit_in_place
def evaluate(times: Times, kind: int) -> float:
    if kind == Kind.HELD:
        return 0.0
    return clamp(sin(times.end)) + call_law(times.start)
def report(times: Times) -> str:
    return f"{evaluate(times, Kind.FREE)}"
''',
}
CHANGES = {
    "body of a kernel": ("forces", "return 0.0", "return 1.0"),
    "called kernel": ("forces", "min(value, 1.0)", "min(value, 2.0)"),
    "function that makes a kernel": ("forces", "return first(value)", "return -first(value)"),
    "enum": ("forces", "HELD = 1", "HELD = 2"),
    "meaning of a name": ("forces", "from math import sin", "from math import cos as sin"),
    "decorator": ("forces", "@jit_in_place\ndef clamp", "@jit\ndef clamp"),
    "new kernel": ("forces", "def report", "@jit\ndef report"),
    "type of records": ("records", '("plane", "i8")', '("plane", "f8")'),
    "order of the fields of a named tuple": ("records", "start: float\n    end: float", "end: float\n    start: float"),
    "order of laws": ("registry", "(Drag, Spring)", "(Spring, Drag)"),
    "constant of another module": ("laws", "DENSITY = 1.2", "DENSITY = 1.3"),
    "change of a constant": ("laws", "*= 0.5", "*= 0.25"),
    "law": ("laws", "-coefficients[0] * value", "coefficients[0] * value"),
}
PLAIN_CHANGES = {
    "comment": ("forces", "  # it is dimensionless", ""),
    "docstring": ("forces", '"""Return a value below 1."""', '"""Return it."""'),
    "annotation": ("forces", "clamp(value: float) -> float", "clamp(value: complex) -> complex"),
    "empty line": ("forces", "@jit_in_place\ndef clamp", "\n\n@jit_in_place\ndef clamp"),
    "plain function that calls kernels": ("forces", 'f"{evaluate', 'f"result {evaluate'),
    "plain function that makes records": ("records", "(mass, 0)", "(mass, 1)"),
    "member of a law that no kernel names": ("laws", 'return "drag"', 'return "drag of air"'),
    "description of a field": ("laws", "area of the body", "area across the flow"),
    "docstring of a constant": ("records", '"""A body."""', '"""One body."""'),
}


def digest_with(change):
    module, old, new = change
    texts = dict(TEXTS)
    name = f"governor_mechanism.{module}"
    assert texts[name].count(old) == 1
    texts[name] = texts[name].replace(old, new)
    return KernelSources(texts).digest()


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_what_a_kernel_is_made_from_changes_the_digest(change):
    assert digest_with(change) != KernelSources(TEXTS).digest()


@pytest.mark.parametrize("change", PLAIN_CHANGES.values(), ids=PLAIN_CHANGES)
def test_what_no_kernel_is_made_from_does_not_change_the_digest(change):
    assert digest_with(change) == KernelSources(TEXTS).digest()


def test_the_kernels_of_the_package_are_found_with_what_they_use():
    found = KernelSources(read_texts(kernel_library.PACKAGE_ROOT)).definitions
    expected = [
        ("engines.multibody.integration", "integrate_multibody"),
        ("engines.reduced.contact", "change_contact_states"),
        ("effects.dashpot", "Dashpot"),
        ("effects.registry", "FORCE_LAWS"),
        ("integrators.dop853", "make_dop853"),
        ("integrators.tableau", "STAGES"),
        ("integrators.step_record", "IntegrationStatus"),
        ("mechanics.dynamics.lowering", "BODY_DTYPE"),
        ("mechanics.dynamics.arrays", "System"),
    ]
    assert {(f"governor_mechanism.{module}", name) for module, name in expected} <= found
    assert ("governor_mechanism.mechanics.dynamics.lowering", "make_body_records") not in found


def test_the_digest_is_kept_until_a_file_changes(tmp_path, monkeypatch):
    package, library = tmp_path / "package", tmp_path / "library"
    (package / "inner").mkdir(parents=True)
    library.mkdir()
    kernel = package / "inner" / "kernels.py"
    text = "from governor_mechanism.numerics.jit import jit\n@jit\ndef square(value):\n    return value * value\n"
    monkeypatch.setattr(kernel_library, "PACKAGE_ROOT", package)
    monkeypatch.setattr(kernel_library, "LIBRARY_FOLDER", library)

    def digest_of(new_text):
        kernel.write_text(new_text)
        os.utime(kernel, ns=(0, len(new_text)))
        return kernel_library.digest_sources.__wrapped__()

    before = digest_of(text)
    note = library / "sources.json"
    kept = json.loads(note.read_text())
    note.write_text(json.dumps(kept | {"digest": "kept"}))
    assert kernel_library.digest_sources.__wrapped__() == "kept"
    assert digest_of(f"{text}# a comment\n") == before
    assert digest_of(text.replace("value * value", "value ** 3.")) not in (before, "kept")
