"""Base classes of physical effects. Each effect has its own file in `effects/`."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar


@dataclass(frozen=True)
class Derivation:
    """A field that a function computes from other keys, along a length only."""

    field: str  # name of the field
    function: Callable[..., float]  # function of the keys; those with a default may be left out
    kinds: Mapping[str, str]  # kinds of quantity of the keys; all are positive
    meanings: Mapping[str, str]  # what each key is


@dataclass(frozen=True, kw_only=True)
class Effect:
    """A physical effect beyond the bare linkage. A scene asks each effect for its contribution.

    Attributes
    ----------
    key
        Key in [effects] of a scene file.
    value_fields
        Fields that a value gives that is no table: one field, or the two ends of a range.
    common_keys
        Fields that are given once for all readings.
    derivations
        Fields that may be computed from other keys.
    changes_bodies_of
        Machines whose bodies the effect changes; empty if it changes no bodies and suits every machine.
    loads_turning_bodies
        Whether bodies in a turning plane carry a centrifugal load.
    """

    key: ClassVar[str]
    value_fields: ClassVar[tuple[str, ...]] = ()
    common_keys: ClassVar[tuple[str, ...]] = ()
    derivations: ClassVar[tuple[Derivation, ...]] = ()
    changes_bodies_of: ClassVar[str] = ""
    loads_turning_bodies: ClassVar[bool] = False

    @property
    def gravity(self) -> float:
        """Gravitational acceleration that the effect adds along -y, m/s2."""
        return 0.0

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Effects along single readings that this effect consists of."""
        return ()


@dataclass(frozen=True, kw_only=True)
class OutputEffect(Effect):
    """An effect along one reading.

    A force (N) acts on a length and a moment (N m) on an angle. Both are positive toward larger values of the reading.

    Attributes
    ----------
    reading
        Name of the reading.
    """

    reading: str

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """The effect itself."""
        return (self,)

    @property
    def contact(self) -> Mapping[str, Any]:
        """What the effect adds to the contact of its reading: any of friction, low, high and restitution of `Contact`."""
        return {}


class ForceLaw(ABC):
    """A force along an output variable as a function of its value and rate.

    The law either has a potential and depends on the value alone, or it dissipates all its power.
    """

    law_name: ClassVar[str]  # name of the law in the counts of evaluations
    dissipates: ClassVar[bool]  # whether the force dissipates energy; without, it has a potential

    @staticmethod
    @abstractmethod
    def force(
        coefficients: Any,
        value: Any,  # value of the reading, m or rad
        # its rate, m/s or rad/s; 0 for a law with a potential. For a force element with an argument, the
        # value of that output instead
        rate: Any,
    ) -> Any:
        """Return the force along the reading, N or N m.

        The law is compiled for the engines and also called with arrays. It uses nothing but its arguments.

        Result: force, N, or moment, N m, positive toward larger values.
        """

    @staticmethod
    def potential(
        coefficients: Any,
        value: Any,  # value of the reading above `slack_below`, m or rad
    ) -> tuple[Any, Any, Any]:
        """Return the potential energy (J) and its first and second derivative by the reading; zeros for a law that dissipates.

        It is compiled and called with arrays, as `force` is.

        Result: energy and derivatives; the first is the negative force.
        """
        return 0.0 * value, 0.0 * value, 0.0 * value


@dataclass(frozen=True, kw_only=True)
class OutputForce(OutputEffect, ForceLaw):
    """An effect along one reading with a force law."""

    @property
    @abstractmethod
    def coefficients(self) -> tuple[float, ...]:
        """Coefficients of the force law, eight at most."""

    @property
    def linear_coefficients(self) -> tuple[float, ...]:
        """Coefficients of the law for small motions about a rest; those of terms of second order in the rate are zero."""
        return self.coefficients

    @property
    def slack_below(self) -> float:
        """Value of the reading below which the effect exerts no force, m or rad; the force is zero there."""
        return -math.inf

    def evaluate(
        self,
        value: Any,  # value of the reading, m or rad
        rate: Any,  # its rate, m/s or rad/s
    ) -> Any:
        """Return the force (N, N m), positive toward larger values, at values and rates of the reading; 0 where the effect is slack."""
        return self.force(self.coefficients, value, rate) * (value >= self.slack_below)
