"""The one declaration of a field: what quantity it is, and what a scene file may have in its place.

A class declares its fields by `quantity` and `entry`. The reader and the JSON schema of scene files, descriptions, templates, sliders and
the check of instances follow from the declarations.
"""

import dataclasses
import math
import re
from collections.abc import Callable
from dataclasses import MISSING, dataclass
from functools import cache, partial
from typing import Any, Final

from governor_mechanism.errors import require_finite, require_not_negative, require_positive
from governor_mechanism.units.quantities import QUANTITY_KINDS

REQUIRED: Final = object()
"""Default of a field that must be given."""


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """What a class declares of one of its fields.

    Attributes
    ----------
    form
        How a scene file writes the value: "quantity", or a key of the value types of the table's reader, as "load" or "flag".
    kinds
        Kinds of quantity, keys of QUANTITY_KINDS: of any value, or along a length and along an angle. None if other fields settle it.
    sign
        Condition on the sign: "positive", "not negative", "not zero" or "any".
    meaning
        What it is, for the message about a missing key and for the reference.
    reason
        End of the message about a value outside its limits, as ", because friction opposes the motion".
    hint
        End of the message about a wrong sign.
    noun
        Word for a value of a list in messages; the kind of quantity if empty.
    examples
        Valid values along a length and along an angle; those of the kinds if empty.
    words
        Words to choose from, or those that may stand in place of a quantity.
    limits
        Least and largest value.
    open_ends
        Which limits are excluded: "low", "high" or both.
    built
        Whether the magnitude must be that of something that can be built.
    key
        Key in a scene file; the name of the field if empty.
    content
        The table of a value that is a table, or a list of them.
    follows
        Whether a scene file may leave it out, though it has no default, because it follows from others.
    default
        Default of the field; REQUIRED if it must be given.
    """

    form: str = "quantity"
    kinds: tuple[str, ...] = ()
    sign: str = "positive"
    meaning: str = ""
    reason: str = ""
    hint: str = ""
    noun: str = ""
    examples: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    limits: tuple[float, float] | None = None
    open_ends: str = ""
    built: bool = False
    key: str = ""
    content: Any = None
    follows: bool = False
    default: Any = REQUIRED

    @property
    def is_required(self) -> bool:
        """Whether a scene file must give it."""
        return self.default is REQUIRED and not self.follows

    @property
    def kind(self) -> str:
        """Kind of quantity; empty for what is none, or where other fields settle it."""
        return self.kinds[0] if self.kinds else ""

    @property
    def unit(self) -> str:
        """SI unit; empty for what has none."""
        return QUANTITY_KINDS[self.kind].si_unit if self.kinds else ""

    @property
    def kind_and_meaning(self) -> str:
        """The kind of quantity and the meaning that continues it, as "length of the sleeve link"."""
        return f"{QUANTITY_KINDS[self.kind].name.partition(' ')[2]} {self.meaning}" if self.kinds else self.meaning

    def admits(self, number: float) -> bool:
        """Return whether a number is within the limits, if there are any."""
        low, high = self.limits or (-math.inf, math.inf)
        is_excluded = ("low" in self.open_ends and number == low) or ("high" in self.open_ends and number == high)
        return low <= number <= high and not is_excluded

    def along(self, quantity: str) -> "Declaration":
        """Return the declaration along a reading that is a "length" or an "angle"."""
        number = -1 if quantity == "angle" else 0
        return dataclasses.replace(self, kinds=self.kinds[number:][:1], examples=self.examples[number:][:1])


def declare(form: str, *kinds: str, default: Any = REQUIRED, examples: str | tuple[str, ...] = (), **properties: Any) -> Declaration:
    """Return a declaration; `examples` are valid values along a length and along an angle, or one."""
    shown = (examples,) if isinstance(examples, str) else examples
    return Declaration(form=form, kinds=kinds, default=default, examples=shown, **properties)


def entry(
    form: str,  # how a scene file writes the value, as "flag", "choice", "label" or "load"
    *kinds: str,
    default: Any = REQUIRED,  # default of the field; without one it must be given
    **properties: Any,
) -> Any:
    """Declare a dataclass field whose value is no plain quantity; kinds of quantity and other arguments are those of `declare`."""
    own_default = MISSING if default is REQUIRED else default
    declared = declare(form, *kinds, default=default, **properties)
    return dataclasses.field(default=own_default, metadata={"declared": declared})


def quantity(
    *kinds: str,
    default: Any = REQUIRED,  # default of the field; without one it must be given
    **properties: Any,
) -> Any:
    """Declare a dataclass field that is a quantity in SI; kinds of quantity and other arguments are those of `declare`."""
    return entry("quantity", *kinds, default=default, **properties)


optional = partial(quantity, default=None)
"""Declare a quantity that may be left out."""

optional_size = partial(quantity, sign="not negative", built=True, default=0.0)
"""Declare a quantity of something that is built, as a mass or a length; left out, it is 0."""


def fields_of(owner: Any) -> dict[str, Declaration]:
    """Return what the fields of a dataclass declare, by name and in their order; fields without one are left out."""
    return _fields_of(owner)


@cache
def _fields_of(owner: Any) -> dict[str, Declaration]:
    return {one.name: one.metadata["declared"] for one in dataclasses.fields(owner) if "declared" in one.metadata}


def require_valid_fields(instance: Any, owner: str) -> None:
    """Raise MechanismError unless quantities of a dataclass are finite, of declared sign; an owner with a last dot precedes names."""
    for name, unit, check in _checks_of(instance.__class__):
        value = getattr(instance, name)
        if value is not None:
            check(value, unit, f"{owner}{name}" if owner.endswith(".") else f"{name.replace('_', ' ')} of {owner}")


@cache
def _checks_of(owner: Any) -> list[tuple[str, str, Callable[[float, str, str], None]]]:
    """Return name, unit and check of each quantity of a dataclass."""
    checks = {"positive": require_positive, "not negative": require_not_negative}
    quantities = {name: one for name, one in fields_of(owner).items() if one.form == "quantity"}
    return [(name, one.unit.replace("^", ""), checks.get(one.sign, require_finite)) for name, one in quantities.items()]


def class_words(instance: object) -> str:
    """Return the name of a class in words, as "arc slot"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(instance).__name__).lower()
