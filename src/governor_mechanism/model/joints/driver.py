"""What both drivers share: a motion, or a constant rate from a start."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from governor_mechanism.model.joints.base import Joint
from governor_mechanism.model.time_functions import PrescribedMotion


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
    def find_conflicts(cls, given: Mapping[str, Any]) -> Iterator[tuple[str, bool]]:
        """Yield a motion given twice or not at all."""
        others = [key for key in ("rate", "start") if key in given]
        if "motion" in given and others:
            yield f"{' and '.join(others)} cannot be combined with motion, which is complete", False
        if "motion" not in given and "rate" not in given:
            yield f"rate or motion is missing; write {cls.rate_example}", True
