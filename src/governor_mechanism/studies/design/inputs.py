"""Inputs of a design: a frozen dataclass of declared quantities, what makes them invalid, and its changes by text as "wire=14 mm"."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.units.places import fill_places
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity, format_value, number_or_text, parse_quantity

MAX_INPUT = 1e30
"""Largest input of a design, SI: its powers are still numbers."""

MAX_RATIO = 0.5
"""Largest droop, speed fluctuation and insensitivity: what changes its speed by more is not governed."""

Sign = Literal["positive", "not negative", "any", "checked elsewhere"]
"""Sign of an input; one whose sign is checked elsewhere belongs to a machine that refuses it itself."""

_Value = TypeVar("_Value")
_Inputs = TypeVar("_Inputs", bound=Any)


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Smallest and largest value of an input, SI.

    Attributes
    ----------
    lowest, highest
        The limits; infinite where there is none.
    are_allowed
        Whether the limits themselves are allowed.
    rule
        What follows "must be" in messages, with places for the limits.
    found
        Place of the value in messages.
    """

    lowest: float = -float("inf")
    highest: float = float("inf")
    are_allowed: bool = True
    rule: str
    found: str = "{value:.6g}"

    def problem(self, name: str, value: float) -> str:
        """Return a sentence about an input that is out of bounds; empty if it is not."""
        is_within = self.lowest <= value <= self.highest if self.are_allowed else self.lowest < value < self.highest
        return "" if is_within else fill_places(f"{name} must be {self.rule}; got {self.found}", self, value=value)


GOVERNED = Bounds(highest=MAX_RATIO, rule="at most {highest:.0%}, where nothing is governed", found="{value:.4%}")
"""Bounds of ratios of speeds that a governor keeps."""


def design_input(
    kind: str,
    default: _Value,  # its default in SI; None: it follows from the others
    meaning: str,
    *,
    sign: Sign = "positive",
    sign_rule: str = "",  # what follows "must be" in the message about a wrong sign, if that needs a reason
    bounds: Bounds | None = None,
    word_for_none: str = "",  # what a user writes for None, if that is not the default
) -> _Value:
    """Return the field of an input."""
    rule = sign_rule or {"positive": "be positive", "not negative": "not be negative"}.get(sign, "")
    declared = {"kind": kind, "meaning": meaning, "sign": sign, "sign_rule": rule, "bounds": bounds, "word_for_none": word_for_none}
    return field(default=default, metadata=declared)


def design_word(default: str, words: Sequence[str], meaning: str) -> str:
    """Return the field of an input that is one of some words, for a dataclass."""
    word: str = field(default=default, metadata={"kind": "", "words": tuple(map(str, words)), "meaning": meaning, "word_for_none": ""})
    return word


def require_valid(
    inputs: Any,
    # function that yields sentences about inputs at odds with each other; it is called if each has its sign
    relations: Callable[[Any], Iterable[str]] = lambda _: (),
    *,
    # function that yields sentences about inputs of which one follows from the other, whatever their signs
    alternatives: Callable[[Any], Iterable[str]] = lambda _: (),
) -> None:
    """Raise MechanismError, with a sentence per mistake, for inputs that are not valid."""
    quantities = [(one.name, getattr(inputs, one.name), one.metadata) for one in fields(inputs) if one.metadata["kind"]]
    given = [(name, value, declared) for name, value, declared in quantities if value is not None]
    wrong_signs = {name: problem for name, value, declared in given if (problem := _sign_problem(name, value, declared))}
    bounds = (declared["bounds"].problem(name, value) for name, value, declared in given if declared["bounds"] and name not in wrong_signs)
    problems = [*wrong_signs.values(), *filter(None, bounds), *alternatives(inputs), *(() if wrong_signs else relations(inputs))]
    if problems:
        raise MechanismError(*problems)


def _sign_problem(name: str, value: float, declared: Mapping[str, Any]) -> str:
    """Return a sentence about an input with a wrong sign; empty if it is right."""
    if not declared["sign_rule"] or value > 0 or (value == 0 and declared["sign"] == "not negative"):
        return ""
    found = format_quantity(value, QUANTITY_KINDS[declared["kind"]].si_unit).strip()
    return f"{name} must {declared['sign_rule']}; got {found}"


def change_inputs(
    defaults: _Inputs,
    changes: Mapping[str, object],  # new values by name: numbers in SI, or texts with units
    prefix: str = "",  # what stands before the name of an input in messages
    # function of the name of an input that returns it as the user writes it, for messages
    spell: Callable[[str], str] = str,
) -> _Inputs:
    """Return inputs with some replaced.

    Raises MechanismError with one sentence per change that is not valid.
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
            values[name] = _read_value(value, known[name], f"{prefix}{spell(name)}")
    collector.raise_if_failed()
    changed: _Inputs = replace(defaults, **values)
    return changed


def _read_value(value: object, declared: Mapping[str, Any], what: str) -> float | str | None:
    """Return an allowed word, or a quantity in SI; raise MechanismError for one beyond all machines, with which no procedure calculates."""
    if words := declared.get("words"):
        if value in words:
            return str(value)
        raise MechanismError(f"{what} must be one of {', '.join(words)}; found {format_value(value)}.{did_you_mean(str(value), words)}")
    if isinstance(value, str) and value and value == declared["word_for_none"]:
        return None
    number = parse_quantity(value, declared["kind"], what)
    if abs(number) > MAX_INPUT:
        raise MechanismError(f"{what} must be at most {MAX_INPUT:g} in SI; found {format_value(value)}")
    return number


def option_of(name: str) -> str:
    """Return the option of the command line that gives an input."""
    return f"--{name.replace('_', '-')}"


def parse_assignments(
    defaults: _Inputs,
    assignments: Iterable[str],  # texts such as "wire=14 mm"; a number without a unit is in SI
    # values by the names of inputs: the text "14 mm" by "wire" for the option --wire
    options: Mapping[str, str] | None = None,
) -> _Inputs:
    """Return inputs with the assignments of the option --with, and those given as options of their own, applied.

    Raises MechanismError with one sentence per assignment that is not valid.
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
