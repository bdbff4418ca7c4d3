"""The examples in public docstrings run, and show what they say."""

import doctest
import inspect

import pytest

import governor_mechanism as gm

SKIPPED = {"paper_rules": "simulates eight engines, which takes a minute"}
"""Functions whose example is not run, and why."""


def find_documented() -> dict[str, object]:
    """Public functions, types and their own methods by name, and the package itself."""
    found: dict[str, object] = {"governor_mechanism": gm}
    for name in gm.__all__:
        owner = getattr(gm, name)
        found[name] = owner
        if inspect.isclass(owner):
            methods = {key: getattr(owner, key) for key in vars(owner) if not key.startswith("_")}
            found |= {f"{name}.{key}": method for key, method in methods.items() if inspect.isroutine(method)}
    others = ("numpy", "typing")  # whose types the package hands on, with examples of their own
    return {name: owner for name, owner in found.items() if not (getattr(owner, "__module__", None) or "").startswith(others)}


DOCUMENTED = find_documented()
EXAMPLES = {name: doctest.DocTestParser().get_examples(inspect.getdoc(owner) or "") for name, owner in DOCUMENTED.items()}


def test_every_public_function_has_an_example():
    functions = {name for name in gm.__all__ if inspect.isfunction(getattr(gm, name))}
    assert {name for name in functions if not EXAMPLES[name]} == set()


def test_no_other_example_is_skipped():
    skipped = {name for name, examples in EXAMPLES.items() if any(doctest.SKIP in example.options for example in examples)}
    assert skipped <= set(SKIPPED)


@pytest.mark.parametrize("name", [name for name, examples in EXAMPLES.items() if examples and name not in SKIPPED])
def test_an_example_shows_what_it_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failures: list[str] = []
    example = doctest.DocTest(EXAMPLES[name], {}, name, None, None, None)
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=failures.append)
    assert not failures, "".join(failures)
