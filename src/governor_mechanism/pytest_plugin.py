"""Plug-in for pytest: kernels of one's own are compared with the simulation.

A marked function that has no parameters returns the kernel; one with parameters is the kernel itself:

    @pytest.mark.governor(scene="porter", quantity="equilibrium_speed", over={"arm_angle": "15 deg:45 deg:25"})
    def test_speed():
        return mine.speed

The fixture `governor_crosscheck` is the same as a function. pytest loads this file at its start; the package itself is imported by the
first comparison.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import pytest

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene
    from governor_mechanism.verification.user_kernel_comparison import KernelReport

MARKER = "governor"
MARKER_LINE = (
    f"{MARKER}(scene, quantity='equilibrium_speed', over=None, allowed=None, *, names, unit, vary, random, seed): compare the kernel that "
    "the function returns, or that it is if it has parameters, with the simulation by governor_mechanism.crosscheck"
)


class Crosscheck(Protocol):
    """The fixture `governor_crosscheck`."""

    def __call__(self, scene: Scene | str | Path, kernel: Callable[..., Any], *arguments: Any, **options: Any) -> KernelReport:
        """Compare a kernel with the simulation as `governor_mechanism.crosscheck` does; fail the test if they disagree."""


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line("markers", MARKER_LINE)


@pytest.fixture(scope="session")
def governor_crosscheck() -> Crosscheck:
    """Return a function that compares a kernel with the simulation.

    Returns
    -------
    Crosscheck
        Function with the arguments of `governor_mechanism.crosscheck`; it returns the report, and fails the test if they disagree.
    """
    return compare_kernel


def compare_kernel(scene: Scene | str | Path, kernel: Callable[..., Any], *arguments: Any, **options: Any) -> KernelReport:
    """Compare a kernel with the simulation, and fail the test that calls it if they disagree.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene.
    kernel
        The kernel.

    Returns
    -------
    KernelReport
        The comparison.
    """
    __tracebackhide__ = True
    import governor_mechanism as gm

    report = None
    problem = _find_wrong_argument(inspect.signature(gm.crosscheck), scene, kernel, *arguments, **options)
    if not problem:
        try:
            report = gm.crosscheck(scene, kernel, *arguments, **options)
        except gm.MechanismError as error:
            problem = str(error)
    if report is None:
        pytest.fail(problem, pytrace=False)
    if not report.passed:
        pytest.fail(str(report), pytrace=False)
    return report


def _find_wrong_argument(signature: inspect.Signature, *arguments: Any, **options: Any) -> str:
    """Return a sentence on an argument that `crosscheck` does not have; empty if there is none."""
    try:
        signature.bind(*arguments, **options)
    except TypeError as error:
        return f"crosscheck: {error}; its arguments are {', '.join(signature.parameters)}"
    return ""


def pytest_pycollect_makeitem(collector: pytest.Module | pytest.Class, name: str, obj: object) -> pytest.Function | None:
    """Return the test of a marked function that is a kernel, since pytest would take its parameters for fixtures; None for others."""
    marks = getattr(obj, "pytestmark", ())
    if not callable(obj) or isinstance(obj, type) or not any(mark.name == MARKER for mark in marks) or not _has_parameters(obj):
        return None
    if not collector.funcnamefilter(name):
        return None

    def compare() -> object:
        return getattr(collector.obj(), name) if isinstance(collector, pytest.Class) else obj  # a method without its first parameter

    compare.pytestmark = list(marks)  # type: ignore[attr-defined]
    function: pytest.Function = pytest.Function.from_parent(collector, name=name, callobj=compare)
    return function


def _has_parameters(function: Callable[..., Any]) -> bool:
    return bool([name for name in inspect.signature(function).parameters if name != "self"])


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Call a marked test, and compare the kernel that it returns with the simulation; None for other tests."""
    mark = pyfuncitem.get_closest_marker(MARKER)
    if mark is None:
        return None
    kernel = pyfuncitem.obj()
    if not callable(kernel):
        pytest.fail(f"{pyfuncitem.name} must return the kernel, a function; it returned {type(kernel).__name__}", pytrace=False)
    options = dict(mark.kwargs)
    if not mark.args and "scene" not in options:
        pytest.fail(f'{pyfuncitem.name}: the marker names no scene; write @pytest.mark.{MARKER}(scene="porter", ...)', pytrace=False)
    scene, *others = mark.args or (options.pop("scene"),)
    compare_kernel(scene, kernel, *others, **options)
    return True
