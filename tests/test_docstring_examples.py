"""The examples in public docstrings run, and show what they say."""

import dataclasses
import doctest
import inspect
import typing

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.model.results.result import Result
from governor_mechanism.observables.derived_readings import analyse_kinematics
from result_checks import check_declarations, check_result, returned_results

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


FUNCTIONS = {name for name in gm.__all__ if inspect.isfunction(DOCUMENTED.get(name))}


def test_every_public_function_has_an_example():
    assert {name for name in FUNCTIONS if not EXAMPLES[name]} == set()


def test_no_other_example_is_skipped():
    skipped = {name for name, examples in EXAMPLES.items() if any(doctest.SKIP in example.options for example in examples)}
    assert skipped <= set(SKIPPED)


@pytest.mark.parametrize("name", [name for name, examples in EXAMPLES.items() if examples and name not in SKIPPED])
def test_an_example_shows_what_it_says(name, tmp_path, monkeypatch):
    """What a function returns there is checked as a result, too: this costs no further simulation."""
    monkeypatch.chdir(tmp_path)
    kinds = returned_results(DOCUMENTED[name]) if name in FUNCTIONS else set()
    returned: list[Result] = []
    if kinds:

        def watched(*arguments, **options):
            returned.append(DOCUMENTED[name](*arguments, **options))
            return returned[-1]

        monkeypatch.setattr(gm, name, watched)
    failures: list[str] = []
    example = doctest.DocTest(EXAMPLES[name], {}, name, None, None, None)
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=failures.append)
    assert not failures, "".join(failures)
    for answer in returned[:1]:
        result = answer[0] if isinstance(answer, tuple) else answer
        assert isinstance(result, tuple(kinds))
        check_result(result, tmp_path)
    assert len(returned) >= bool(kinds)


def test_every_public_class_of_results_declares_and_is_what_an_example_returns():
    public = {one for one in map(DOCUMENTED.get, gm.__all__) if inspect.isclass(one) and issubclass(one, Result)}
    for kind in public:
        check_declarations(kind)
    shown = set().union(*(returned_results(DOCUMENTED[name]) for name in FUNCTIONS if name not in SKIPPED))
    others = {gm.Kinematics, gm.KernelReport, gm.SceneDescription}
    assert public - shown == others | {gm.PaperRules}  # one of which is made up in `test_paper_rules`


def test_results_that_no_example_returns_are_results_too(tmp_path):
    scene = gm.load("porter")
    report = gm.crosscheck(scene, lambda arm_angle: 0.6 * (1.0 - np.cos(arm_angle)), "sleeve_lift", {"arm_angle": [0.5, 0.6]})
    assert isinstance(report, gm.KernelReport)
    for result in (report, scene.describe(), analyse_kinematics(scene, "arm_angle", [0.5, 0.6])):
        check_result(result, tmp_path)


def test_every_dataclass_that_a_public_function_returns_is_a_result_or_no_numbers():
    returned = {typing.get_type_hints(DOCUMENTED[name])["return"] for name in FUNCTIONS}
    others = {one for one in returned if dataclasses.is_dataclass(one) and not issubclass(one, Result)}
    assert others == {gm.Scene}
