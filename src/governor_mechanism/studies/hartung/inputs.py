"""Design inputs from text, such as "wire=14 mm" on the command line."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.studies.hartung.design import HartungInputs
from governor_mechanism.units.quantities import format_value, parse_quantity

INPUT_DIMENSIONS = {
    "weight_mass": "mass",
    "sleeve_mass": "mass",
    "weight_arm": "length",
    "rest_radius": "length",
    "half_stroke": "length",
    "fulcrum_height": "length",
    "swing": "angle",
    "slow_speed": "angular_speed",
    "fast_speed": "angular_speed",
    "wire": "length",
    "coil": "length",
    "modulus": "modulus",
    "stress_limit": "pressure",
    "insensitivity": "ratio",
    "angle": "angle",
    "sleeve_arm": "length",
}
"""Physical dimension of each input."""


def parse_inputs(assignments: Iterable[str]) -> HartungInputs:
    """Return the paper's inputs with the given assignments applied.

    Parameters
    ----------
    assignments
        Texts such as "wire=14 mm"; a number without a unit is in SI.

    Returns
    -------
    HartungInputs
        The inputs.

    Raises
    ------
    MechanismError
        With one sentence per assignment that is not valid.
    """
    values: dict[str, float] = {}
    problems: list[str] = []
    for assignment in assignments:
        name, sign, value = (part.strip() for part in assignment.partition("="))
        if not sign or name not in INPUT_DIMENSIONS:
            known = ", ".join(INPUT_DIMENSIONS)
            problems.append(
                f"--with {format_value(assignment)} is not an assignment to an input, such as wire=14 mm; inputs: {known}."
                f"{did_you_mean(name, INPUT_DIMENSIONS)}"
            )
            continue
        try:
            values[name] = parse_quantity(_parse_number(value), INPUT_DIMENSIONS[name], f"--with {name}")
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return dataclasses.replace(HartungInputs(), **values)


def _parse_number(text: str) -> str | float:
    """Return a number in SI as a float, as in a scene file; a text with a unit unchanged."""
    try:
        return float(text)
    except ValueError:
        return text
