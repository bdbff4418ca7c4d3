"""Unknown values of a scene: keys of its document with bounds, and the scene that has given values there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import document_of, parse_scene_with
from governor_mechanism.studies.sweep.parameters import find_kind, find_scene_value, parse_axes
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity, format_value, number_or_text

OVER_EXAMPLE = '{"dimensions.arm": ("280 mm", "320 mm")}, or dimensions.arm=280mm:320mm'
"""Example of bounds in messages."""


SCREENED_PER_UNKNOWN: Final = 8
"""Number of places per unknown among which further starts of a search are chosen."""


@dataclass(frozen=True, kw_only=True)
class Unknown(Recorded):
    """A key of a scene whose value is sought, in SI."""

    key: str  # dotted key of the scene document
    kind: str
    low: float  # bound
    high: float  # bound
    start: float  # value of the scene, or the usual dimension, or the middle of the bounds

    @property
    def unit(self) -> str:
        """SI unit; empty for a ratio."""
        return QUANTITY_KINDS[self.kind].si_unit

    def write(self, value: float) -> str | float:
        """Return a value, SI, as the document has it."""
        return write_value(value, self.unit)


def write_value(value: float, unit: str) -> str | float:
    """Return a value, SI, as a document has it: with its unit, since a large bare number may be taken for a slip."""
    return f"{value!r} {unit}" if unit else value


def parse_unknowns(scene: Scene, over: Mapping[str, Any] | Sequence[str], what: str = "over") -> tuple[Unknown, ...]:
    """Return the keys with their bounds, as {key: (low, high)} or "key=low:high"; raise MechanismError with all mistakes."""
    bounds, problems = _read_bounds(over, what)
    document = document_of(scene, what)
    unknowns = []
    for key, pair in bounds.items():
        try:
            unknowns.append(_make_unknown(document, key, pair, what, _default_of(scene, key)))
        except MechanismError as error:
            problems += [f"{what}{one.removeprefix('vary')}" if one.startswith("vary:") else one for one in error.problems]
    if problems:
        raise MechanismError(*problems)
    return tuple(unknowns)


def _read_bounds(over: Mapping[str, Any] | Sequence[str], what: str) -> tuple[dict[str, tuple[Any, Any]], list[str]]:
    """Return both bounds by key, and what is wrong with those that are not understood."""
    texts = [over] if isinstance(over, str) else over
    if not isinstance(texts, Mapping | Sequence) or not texts:
        raise MechanismError(f"{what} names no key; write {OVER_EXAMPLE}; found {format_value(over)}")
    requests = texts.items() if isinstance(texts, Mapping) else (_split(text) for text in texts)
    bounds: dict[str, tuple[Any, Any]] = {}
    problems = []
    for key, pair in requests:
        if isinstance(pair, str) or not isinstance(pair, Sequence | np.ndarray) or len(pair) != 2:
            problems.append(f"{what}: {key} needs a lower and an upper bound; write {OVER_EXAMPLE}; found {format_value(pair)}")
        elif key in bounds:
            problems.append(f"{what}: {key} is given twice; give it once")
        else:
            bounds[str(key)] = pair[0], pair[1]
    return bounds, problems


def _split(text: object) -> tuple[str, Any]:
    """Return key and bounds of "key=low:high"."""
    key, _, values = text.partition("=") if isinstance(text, str) else (format_value(text), "", "")
    low, colon, high = values.partition(":")
    return key.strip(), (number_or_text(low.strip()), number_or_text(high.strip())) if colon else values


def _default_of(scene: Scene, key: str) -> float | None:
    """Return the value, SI, of a dimension that a scene leaves out; None for one without, and for other keys."""
    part, _, name = key.rpartition("dimensions.")
    found = [one for one in scene.parts if part == (f"part.{one.name}." if len(scene.parts) > 1 else "")]
    return found[0].dimensions.get(name) if found and name != key else None


def _make_unknown(document: Mapping[str, Any], key: str, pair: tuple[Any, Any], what: str, default: float | None) -> Unknown:
    """Return an unknown; raise MechanismError for a key that takes no quantity, or crossed bounds."""
    axis = parse_axes(document, {key: list(pair)})[0]
    if not axis.kind or not axis.is_numeric:
        raise MechanismError(f"{what}: {key} takes words and no quantity; it cannot be an unknown")
    low, high = map(float, axis.values)
    if not low < high:
        raise MechanismError(f"{what}: the bounds of {key} are crossed: {format_value(pair[0])} to {format_value(pair[1])}; swap them")
    start = axis.scene_value if isinstance(axis.scene_value, float) else 0.5 * (low + high) if default is None else default
    if not low <= start <= high:
        shown = format_quantity(start, axis.unit)
        raise MechanismError(f"{what}: the scene has {key} = {shown}, outside its bounds; widen them, or begin with another value")
    return Unknown(key=key, kind=axis.kind, low=low, high=high, start=start)


def spread_places(n_unknowns: int, n_further: int, seed: int, per_unknown: int = SCREENED_PER_UNKNOWN) -> FloatArray:
    """Return random places between the bounds, 0 to 1, among which at least a number of further starts is chosen; shape (n, unknowns)."""
    from scipy.stats import qmc  # slow to import

    places: FloatArray = qmc.LatinHypercube(n_unknowns, rng=seed).random(max(per_unknown * n_unknowns, n_further))
    return places


def scene_with(scene: Scene, unknowns: Sequence[Unknown], values: Sequence[float] | FloatArray) -> Scene:
    """Return the scene with values, SI, of the unknowns; raise MechanismError if there is no such scene."""
    changes = [(one.key, one.write(float(value))) for one, value in zip(unknowns, values, strict=True)]
    return parse_scene_with(scene.document, changes)


def value_of_key(scene: Scene, key: str) -> tuple[float, str]:
    """Return the value, SI, of a scene at a key and its kind; MechanismError if the key takes no quantity, or is left out."""
    document = document_of(scene, "by")
    kind = find_kind(document, key)
    value = find_scene_value(document, key, kind)
    if not isinstance(value, float):
        found = "leaves it out" if value is None else f"has {format_value(value)}"
        raise MechanismError(f"by: {key} must have a number, at which the derivative is taken; this scene {found}; write a number into it")
    return value, kind
