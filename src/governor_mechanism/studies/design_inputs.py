"""Inputs of a design: a frozen dataclass whose fields have kinds of quantity, and its changes by text such as "wire=14 mm"."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, fields, replace
from typing import Any, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.scenes.problems import ProblemCollector
from governor_mechanism.units.quantities import format_value, number_or_text, parse_quantity

MAX_INPUT = 1e30
"""Largest input of a design, SI: its powers are still numbers."""

_Value = TypeVar("_Value")
_Inputs = TypeVar("_Inputs", bound=Any)


def design_input(kind: str, default: _Value, *, word_for_none: str = "") -> _Value:
    """Return the field of an input.

    Parameters
    ----------
    kind
        Its kind of quantity, a key of `units.quantities.QUANTITY_KINDS`.
    default
        Its default in SI; None: it follows from the others.
    word_for_none
        What a user writes for None, if that is not the default.

    Returns
    -------
    _Value
        The field, for a dataclass.
    """
    return field(default=default, metadata={"kind": kind, "word_for_none": word_for_none})


def design_word(default: str, words: Sequence[str]) -> str:
    """Return the field of an input that is one of some words, for a dataclass.

    Parameters
    ----------
    default
        Its default.
    words
        The words that are allowed.

    Returns
    -------
    str
        The field.
    """
    word: str = field(default=default, metadata={"kind": "", "words": tuple(map(str, words)), "word_for_none": ""})
    return word


def input_kinds(inputs: Any) -> dict[str, str]:
    """Return the kind of quantity of each input that is a quantity.

    Parameters
    ----------
    inputs
        The dataclass or an instance of it.

    Returns
    -------
    dict[str, str]
        Kinds by name.
    """
    return {one.name: one.metadata["kind"] for one in fields(inputs) if one.metadata["kind"]}


def change_inputs(defaults: _Inputs, changes: Mapping[str, object], prefix: str = "", spell: Callable[[str], str] = str) -> _Inputs:
    """Return inputs with some replaced.

    Parameters
    ----------
    defaults
        The inputs to change, an instance of the dataclass.
    changes
        New values by name: numbers in SI, or texts with units.
    prefix
        What stands before the name of an input in messages.
    spell
        Function of the name of an input that returns it as the user writes it, for messages.

    Returns
    -------
    _Inputs
        The inputs.

    Raises
    ------
    MechanismError
        With one sentence per change that is not valid.
    """
    known = {one.name: one.metadata for one in fields(defaults)}
    values: dict[str, float | str | None] = {}
    collector = ProblemCollector()
    for name, value in changes.items():
        with collector.at(""):
            if name not in known:
                names = [*map(spell, known)]
                hint = did_you_mean(spell(name), names)
                raise MechanismError(f"{prefix}{spell(name)} is not an input; inputs: {', '.join(names)}.{hint}")
            if "words" in known[name]:
                values[name] = _choose_word(value, known[name]["words"], f"{prefix}{spell(name)}")
                continue
            is_none = isinstance(value, str) and bool(value) and value == known[name]["word_for_none"]
            values[name] = None if is_none else _parse_input(value, known[name]["kind"], f"{prefix}{spell(name)}")
    collector.raise_if_failed()
    changed: _Inputs = replace(defaults, **values)
    return changed


def _parse_input(value: object, kind: str, what: str) -> float:
    """Return a quantity in SI; raise MechanismError for one beyond all machines, with which a procedure cannot calculate."""
    number = parse_quantity(value, kind, what)
    if abs(number) > MAX_INPUT:
        raise MechanismError(f"{what} must be at most {MAX_INPUT:g} in SI; found {format_value(value)}")
    return number


def option_of(name: str) -> str:
    """Return the option of the command line that gives an input."""
    return f"--{name.replace('_', '-')}"


def _choose_word(value: object, words: Sequence[str], what: str) -> str:
    """Return a value that is one of some words; raise MechanismError for any other."""
    if value in words:
        return str(value)
    raise MechanismError(f"{what} must be one of {', '.join(words)}; found {format_value(value)}.{did_you_mean(str(value), words)}")


def parse_assignments(defaults: _Inputs, assignments: Iterable[str], options: Mapping[str, str] | None = None) -> _Inputs:
    """Return inputs with the assignments of the option --with, and those given as options of their own, applied.

    Parameters
    ----------
    defaults
        The inputs to change, an instance of the dataclass.
    assignments
        Texts such as "wire=14 mm"; a number without a unit is in SI.
    options
        Values by the names of inputs: the text "14 mm" by "wire" for the option --wire.

    Returns
    -------
    _Inputs
        The inputs.

    Raises
    ------
    MechanismError
        With one sentence per assignment that is not valid.
    """
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
