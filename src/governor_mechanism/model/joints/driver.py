"""What both drivers share: a motion, or a constant rate from a start."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from governor_mechanism.model.joints.base import Joint
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.units.fields import Declaration, declare
from governor_mechanism.units.problems import Problem, ProblemCode


def motion_keys(rate: tuple[str, str], start: tuple[str, str], motion: tuple[str, str]) -> dict[str, Declaration]:
    """Return the keys of a driver in a scene file, each with its kind of quantity, or its form, and its meaning."""
    quantities = {
        name: declare("quantity", kind, sign="any", default=0.0, meaning=meaning)
        for name, (kind, meaning) in {"rate": rate, "start": start}.items()
    }
    return quantities | {"motion": Declaration(form=motion[0], default=None, meaning=motion[1])}


@dataclass(frozen=True, kw_only=True)
class Driver(Joint):
    """Base class of a joint that prescribes a motion.

    Attributes
    ----------
    motion
        What is prescribed over time, rad or m.
    """

    rate_example: ClassVar[str] = ""
    """How a scene file prescribes a motion, for messages."""

    motion: PrescribedMotion

    @classmethod
    def create(cls, **values: Any) -> Self:
        """Return a driver with a motion, by default at a constant rate from the start."""
        start, rate, motion = values.pop("start"), values.pop("rate", 0.0), values.pop("motion", None)
        return cls(motion=motion(start) if motion else PrescribedMotion.constant_rate(start, rate), **values)

    @classmethod
    def find_conflicts(cls, given: Mapping[str, Any]) -> Iterator[str]:
        """Yield a motion given twice or not at all."""
        others = [key for key in ("rate", "start") if key in given]
        if "motion" in given and others:
            yield f"{' and '.join(others)} cannot be combined with motion, which is complete"
        if "motion" not in given and "rate" not in given:
            yield Problem(f"rate or motion is missing; write {cls.rate_example}", ProblemCode.MISSING_KEY)
