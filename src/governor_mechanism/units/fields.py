"""The one declaration of a field: what quantity it is, what a scene file may have in its place, and inputs that are given by name.

A class declares its fields by `quantity` and `entry`. The reader and the JSON schema of scene files, descriptions, templates, sliders and
the check of instances follow from the declarations.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, replace
from functools import cache, partial
from typing import Any, Final, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean, require_finite, require_not_negative, require_positive
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, display_unit, format_quantity, format_value, number_or_text, parse_quantity

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


MAX_INPUT = 1e30
"""Largest input, SI: its powers are still numbers."""

_Inputs = TypeVar("_Inputs", bound=Any)


def change_inputs(
    defaults: _Inputs,
    changes: Mapping[str, object],  # new values by name: numbers in SI, or texts with units
    prefix: str = "",  # what stands before the name of an input in messages
    # function of the name of an input that returns it as the user writes it, for messages
    spell: Callable[[str], str] = str,
) -> _Inputs:
    """Return inputs with some replaced; raise MechanismError with one sentence per change that is not valid."""
    known = fields_of(type(defaults))
    values: dict[str, float | str | None] = {}
    collector = ProblemCollector()
    for name, value in changes.items():
        with collector.at(""):
            if name not in known:
                names = [*map(spell, known)]
                hint = did_you_mean(spell(name), names)
                raise MechanismError(f"{prefix}{spell(name)} is not an input; inputs: {', '.join(names)}.{hint}")
            values[name] = _read_value(value, known[name], f"{prefix}{spell(name)}")
    collector.raise_if_failed()
    changed: _Inputs = replace(defaults, **values)
    return changed


def _read_value(value: object, declared: Declaration, what: str) -> float | str | None:
    """Return an allowed word, or a quantity in SI; raise MechanismError for one beyond all machines, with which no procedure calculates."""
    words = declared.words
    if value in words:
        return None if declared.kinds else str(value)
    if not declared.kinds:
        raise MechanismError(f"{what} must be one of {', '.join(words)}; found {format_value(value)}.{did_you_mean(str(value), words)}")
    number = parse_quantity(value, declared.kind, what)
    if abs(number) > MAX_INPUT:
        raise MechanismError(f"{what} must be at most {MAX_INPUT:g} in SI; found {format_value(value)}")
    return number


def option_of(name: str) -> str:
    """Return the option of the command line that gives an input."""
    return f"--{name.replace('_', '-')}"


def describe_inputs(defaults: Any) -> list[tuple[str, str]]:
    """Return for each input its option with the unit, and its meaning with the default."""
    return [
        (f"{option_of(name)} {_value_word(declared)}", _describe_input(declared, getattr(defaults, name)))
        for name, declared in fields_of(type(defaults)).items()
    ]


def _value_word(declared: Declaration) -> str:
    """Return what an input takes: a unit, or the words to choose from."""
    return f"<{display_unit(declared.unit)[1] or 'number'}>" if declared.kinds else "|".join(declared.words)


def _describe_input(declared: Declaration, default: object) -> str:
    """Return the meaning of an input and its default."""
    if default is None:
        return f"{declared.meaning}  [optional]"
    text = default if isinstance(default, str) else format_quantity(float(str(default)), declared.unit)
    return f"{declared.meaning}  [default: {text}]"


def parse_assignments(
    defaults: _Inputs,
    assignments: Iterable[str],  # texts such as "wire=14 mm"; a number without a unit is in SI
    # values by the names of inputs: the text "14 mm" by "wire" for the option --wire
    options: Mapping[str, str] | None = None,
) -> _Inputs:
    """Return inputs with the assignments of the option --with, and those given as options of their own, applied."""
    changes: dict[str, object] = {}
    given = options or {}
    collector = ProblemCollector()
    for assignment in assignments:
        name, sign, value = (part.strip() for part in assignment.partition("="))
        with collector.at(""):
            if not sign:
                raise MechanismError(f"--with {format_value(assignment)} is not an assignment to an input, such as NAME=14 mm")
            if name in given:
                raise MechanismError(f"{name} is given by --with {name} and by {option_of(name)}; give it once")
            if name in changes:
                raise MechanismError(f"--with {name} is given twice; give it once")
            changes[name] = number_or_text(value)
    inputs = defaults
    with collector.at(""):
        inputs = change_inputs(inputs, changes, "--with ")
    with collector.at(""):
        inputs = change_inputs(inputs, {name: number_or_text(value) for name, value in given.items()}, spell=option_of)
    collector.raise_if_failed()
    return inputs
