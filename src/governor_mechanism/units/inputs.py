"""Inputs that are given by name: fields of a dataclass, as declared, changed by texts with units, and their list for a command."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_quantity, format_value, number_or_text, parse_quantity

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
    return f"<{DISPLAY_UNITS.get(declared.unit, (1.0, declared.unit))[1] or 'number'}>" if declared.kinds else "|".join(declared.words)


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
