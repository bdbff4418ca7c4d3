"""Description of a hard case: a family of scenes over a hard parameter, and what may happen."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.types import FloatArray

Document = dict[str, Any]
"""A scene as read from a scene file."""

Solution = Mapping[str, tuple[FloatArray, FloatArray]]
"""Values and rates (n,) of readings, SI."""


def default_engines(value: float) -> tuple[Engine, ...]:
    """Return every engine with its default settings; the value of the hard parameter does not matter."""
    return ReducedEngine(), MultibodyEngine(), ImpulseEngine()


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """A family of scenes over a hard parameter.

    Attributes
    ----------
    name
        Name on the command line, such as "dead-centre".
    title
        What is hard, as a line of text.
    parameter
        The hard parameter with its unit, as a label.
    values
        Values of the hard parameter.
    make_document
        The scene at a value.
    solve
        The solution at a value and times (n,), s, independent of the engines; None: another engine is the reference.
    named_ends
        Outcomes, apart from the end of the duration, with which a run may end, and why.
    refused_values
        Values at which the scene itself must be refused.
    short_values
        Values of the short form of the study.
    engines
        The engines at a value.
    """

    name: str
    title: str
    parameter: str
    values: tuple[float, ...]
    make_document: Callable[[float], Document]
    solve: Callable[[float, FloatArray], Solution] | None = None
    named_ends: Mapping[Outcome, str] = field(default_factory=dict)
    refused_values: tuple[float, ...] = ()
    short_values: tuple[float, ...] = ()
    engines: Callable[[float], tuple[Engine, ...]] = default_engines
