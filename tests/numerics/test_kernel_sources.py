"""The digest of kernels: it changes with all that a kernel is made from, and with nothing else."""

import json
import os

import pytest

from data_files import read_data
from governor_mechanism.numerics import kernel_library
from governor_mechanism.numerics.kernel_sources import KernelSources, read_texts

DATA = read_data(__file__)
TEXTS, CHANGES, PLAIN_CHANGES = (DATA[name] for name in ("TEXTS", "CHANGES", "PLAIN_CHANGES"))


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


def test_members_are_followed_to_the_last_whatever_the_order():
    """Each of a row of classes has a member that names that of the next one, and the last member a definition."""
    number = 12
    classes = [f"class Class{k}:\n    def member{k}(self):\n        return self.member{k + 1}\n" for k in range(number)]
    last = f"class Class{number}:\n    def member{number}(self):\n        return LAST\nLAST = 1.0\n"
    kernel = f"KERNEL = jit([{', '.join(f'Class{k}' for k in range(number + 1))}], one.member0)\n"
    text = "".join(["from governor_mechanism.numerics.jit import jit\n", *classes, last, kernel])
    assert ("governor_mechanism.row", "LAST") in KernelSources({"governor_mechanism.row": text}).definitions


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
