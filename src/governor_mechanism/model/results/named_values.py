"""Results by name. A name that is not known is answered with the nearest one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from governor_mechanism.errors import UnknownName, did_you_mean
from governor_mechanism.units.short_repr import summarise

_Value = TypeVar("_Value")


class NamedValues(dict[str, _Value]):
    """Values by name; only the error of a missing name differs from a dictionary."""

    def __init__(
        self,
        noun: str,  # what a name stands for, in the singular, as "reading"
        values: Mapping[str, _Value],  # the values by name
    ) -> None:
        super().__init__(values)
        self.noun = noun

    def __repr__(self) -> str:
        """Return the names with the range of each array."""
        return f"{{{', '.join(f'{name!r}: {summarise(value)}' for name, value in self.items())}}}"

    def __missing__(self, name: object) -> _Value:
        """Raise UnknownName, which is a KeyError, with the nearest name."""
        known = ", ".join(self) if self else "none"
        raise UnknownName(f"no {self.noun} {name!r}; known are {known}.{did_you_mean(name, self)}")


def name_values(noun: str, values: Mapping[str, _Value]) -> NamedValues[_Value]:
    """Return values by name that answer an unknown name with the nearest one."""
    return values if isinstance(values, NamedValues) else NamedValues(noun, values)
