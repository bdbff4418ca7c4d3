"""Events of a run: what happened when, and to which output variable."""

from __future__ import annotations

from dataclasses import dataclass

STICKS, SLIPS, STRIKES, RESTS, LEAVES = "sticks", "slips", "strikes its stop", "rests on its stop", "leaves its stop"
SLACKENS, PULLS = "goes slack", "pulls again"


@dataclass(frozen=True, kw_only=True)
class Event:
    """Something a run passed: `kind` is 'dead centre', 'change point', or what something that may be held did, as
    'sticks', 'slips', 'strikes its stop'; `subject` is the reading."""

    time: float
    kind: str
    subject: str

    def __str__(self) -> str:
        if self.kind not in ("dead centre", "change point"):
            return f"{self.subject} {self.kind} at t = {self.time:.9g} s"
        return f"{self.kind} of {self.subject} at t = {self.time:.6g} s"
