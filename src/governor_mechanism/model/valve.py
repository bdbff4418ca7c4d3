"""The slide valve that a mechanism moves: which readings say where valve and piston are, and its laps. Frozen values."""

from dataclasses import dataclass
from typing import Final

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative
from governor_mechanism.units.fields import entry, quantity, require_valid_fields

OUTSIDE_ADMISSION: Final = "outside"
"""Steam enters over the outer edges of the valve: to the crank end while the valve is displaced away from the shaft."""
INSIDE_ADMISSION: Final = "inside"
"""Steam enters over the inner edges, as with piston valves: to the crank end while the valve is displaced toward the shaft."""

ADMISSIONS: Final = (OUTSIDE_ADMISSION, INSIDE_ADMISSION)
"""Edges over which steam may enter."""

EQUAL_LEADS: Final = "equal leads"
"""Rule for the centre of the valve's motion: the mean of its positions at the two dead centres."""
MIDDLE: Final = "middle of extremes"
"""Rule for the centre of the valve's motion: the middle between its extremes."""

CENTRE_RULES: Final = (EQUAL_LEADS, MIDDLE)
"""Rules for the centre of the motion of any valve."""


@dataclass(frozen=True, kw_only=True)
class Reverser:
    """What reverses a valve gear: a key of the scene file, and its values at the ends of its range."""

    # dotted key of the scene document, as for a sweep
    key: str = entry("label", meaning='the key of this file that reverses the gear, as "joint.lever.motion.start"')
    # value in full forward gear: a number in SI, or text with a unit
    forward: float | str = entry("end", meaning='its value in full forward gear, as "20 deg"')
    back: float | str = entry("end", meaning='its value in full back gear, as "-20 deg"')  # value in full back gear


@dataclass(frozen=True, kw_only=True)
class Valve:
    """A slide valve of a mechanism with a driven crank.

    Attributes
    ----------
    displacement
        Name of the reading of the valve's position along its line, a length that grows away from the shaft.
    steam_lap
        Length by which the valve in the centre of its motion covers the edges that admit steam, m; negative leaves them open.
    exhaust_lap
        Length by which it covers the edges of the exhaust, m; negative leaves them open.
    piston_travel
        Name of the reading of the piston's position, a length that grows away from the shaft; empty if the mechanism has no piston.
    stroke
        Stroke of the piston, m; 0 if it follows from the range of the piston over a turn.
    centre
        Value of the reading in the centre of the valve's motion, m, or one of `CENTRE_RULES`.
    admission
        Edges that admit steam: one of `ADMISSIONS`.
    crank
        Name of the driver that turns the crank; empty if only one driver turns a body.
    reverser
        What reverses the gear; None if nothing does.
    """

    displacement: str = entry(
        "length reading", key="reading", meaning="the reading of the valve's position, which grows away from the shaft"
    )
    steam_lap: float = quantity(
        "length",
        sign="any",
        built=True,
        meaning='the length by which the valve in its centre covers the edges that admit steam, as "24 mm"',
    )
    exhaust_lap: float = quantity(
        "length",
        sign="any",
        built=True,
        default=0.0,
        meaning="the length by which the valve in its centre covers the edges of the exhaust; negative leaves them open",
    )
    stroke: float = 0.0
    centre: float | str = entry(
        "centre",
        "length",
        sign="any",
        words=CENTRE_RULES,
        default=EQUAL_LEADS,
        meaning=f"the reading in the centre of the valve's motion, or a rule: {', '.join(CENTRE_RULES)}",
    )
    piston_travel: str = entry(
        "length reading", key="piston", default="", meaning="the reading of the piston's position, which grows away from the shaft"
    )
    admission: str = entry("choice", words=ADMISSIONS, default=OUTSIDE_ADMISSION, meaning="the edges of the valve over which steam enters")
    crank: str = entry("driver", default="", meaning="the name of the driver that turns the crank; by default the only one")
    reverser: Reverser | None = entry(
        "reverser",
        default=None,
        meaning="what reverses the gear: { key, forward, back }, a key of the scene file and its values at the ends",
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, "the valve")
        require_not_negative(self.stroke, "m", "stroke of the piston")
        if self.admission not in ADMISSIONS:
            raise MechanismError(f"admission of the valve must be one of {', '.join(map(repr, ADMISSIONS))}; got {self.admission!r}")
        if not isinstance(self.centre, str):
            require_finite(self.centre, "m", "centre of the valve's motion")
        elif self.centre not in CENTRE_RULES:
            rules = ", ".join(map(repr, CENTRE_RULES))
            raise MechanismError(f"centre of the valve's motion must be a length or one of {rules}; got {self.centre!r}")

    @property
    def readings(self) -> tuple[str, ...]:
        """Names of the readings of valve and piston."""
        return (self.displacement, self.piston_travel) if self.piston_travel else (self.displacement,)

    @property
    def outward_sign(self) -> float:
        """1 if a displacement away from the shaft opens the steam port of the crank end, -1 if it opens that of the head end."""
        return 1.0 if self.admission == OUTSIDE_ADMISSION else -1.0
