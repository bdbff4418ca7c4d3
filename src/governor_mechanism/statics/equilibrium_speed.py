"""At what speed a mechanism rests at a place: where one holds it at all, where it jumps, and what a caller may ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import springs_of
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.mechanics.reduction.lagrangian import Along, Reduction
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import TURNING, Scene
from governor_mechanism.statics.adaptive_grid import NEUTRAL, rise
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import parse, shown, spoken

NEAR = 1e-8
"""rad, or machine sizes: so near a place where loads and spindle both let go, the curve is its limit there."""

MET = 1e-8
"""Of what the loads' force is beside it: so little of it is none."""

APART = 2e-5
"""rad, or machine sizes: so near a place where loads and spindle both let go a fold is at it: rounding's cube root."""

SEAM = 1e-7
"""rad, or machine sizes: what lies so near an end of a motion that comes round lies at it."""

BETWEEN = 2
"""So many values on which nothing rises or falls may be a fold; more are a stretch of it."""

HARDEST = 1e12
"""N, or N m: harder resists nothing; beyond it lies a slip of units."""


def balances(scene: Scene) -> bool:
    """Whether there are both, loads and a spindle's turning that could balance them."""
    return bool(turns(scene) and (scene.gravity or scene.part.mechanism.loads or springs_of(scene)))


def turns(scene: Scene) -> bool:
    """Whether a spindle's turning loads the mechanism."""
    return bool(scene.centrifugal and scene.part.plane == TURNING)


def require_turning(scene: Scene) -> None:
    """Refuse a scene whose loads a spindle's speed cannot balance."""
    if not balances(scene):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity), and a "
            "plane that turns with the spindle; list them in the scene"
        )


def square_of_rest(along: Along, unit: float, more: FloatArray | float = 0.0) -> FloatArray:
    """The square (n,) of the speed of rest under `more` force along the coordinate; -1 where turning does nothing.

    Where the loads let go together with the spindle, the limit: there it rests at every speed. unit is what a rad, or a
    machine size, of the coordinate is in SI.
    """
    pull, slope = along.potential_slope + more, along.spindle_slope
    both = (np.abs(pull) <= NEAR * unit * np.abs(along.potential_bend)) & (
        np.abs(slope) <= NEAR * unit * np.abs(along.spindle_bend)
    )
    pull, slope = np.where(both, along.potential_bend, pull), np.where(both, along.spindle_bend, slope)
    return np.where(slope != 0.0, 2 * pull / np.where(slope != 0.0, slope, 1.0), -1.0)


def folds_of(reduction: Reduction, along: Along) -> tuple[tuple[float, float], ...]:
    """Coordinates and speeds where the speed of rest turns back: where V'' J' - V' J'' changes its sign."""
    rising, size = rise(along)
    held = square_of_rest(along, reduction.unit) > 0.0
    meets = [place for place, met in _loose(reduction, along) if met]
    found = []
    for low, high in _changes(np.where(np.abs(rising) <= NEUTRAL * size, 0.0, rising)):
        if not held[low : high + 1].all():
            continue
        value = _root(lambda value: rise(reduction.at([value]))[0], along.coordinate[low], along.coordinate[high])
        value = next((place for place in meets if abs(place - value) < APART * reduction.unit), value)
        here = reduction.at([value])
        square = float(square_of_rest(here, reduction.unit)[0])
        if square > 0.0 and not _pole(along, here, low, high, reduction.unit):
            found.append((value, float(np.sqrt(square))))
    return tuple(found[k] for k in _once(reduction, [value for value, _ in found]))


def poles_of(reduction: Reduction, along: Along) -> tuple[float, ...]:
    """Coordinates where J' changes its sign while the loads pull: toward them the speed of rest grows without end."""
    found = [place for place, met in _loose(reduction, along) if not met]
    return tuple(found[k] for k in _once(reduction, found))


def _loose(reduction: Reduction, along: Along) -> Iterator[tuple[float, bool]]:
    """Coordinates where J' changes its sign, and whether the loads let go there too."""
    for low, high in _changes(along.spindle_slope):
        place = _root(lambda value: reduction.at([value]).spindle_slope, along.coordinate[low], along.coordinate[high])
        beside = max(abs(along.potential_slope[low]), abs(along.potential_slope[high]))
        yield place, bool(abs(reduction.at([place]).potential_slope[0]) <= MET * beside)


def _pole(along: Along, here: Along, low: int, high: int, unit: float) -> bool:
    """Whether J' only touches zero between two values while the loads pull: the curve goes up to no end and back."""
    beside = max(abs(along.spindle_slope[low]), abs(along.spindle_slope[high]))
    pulls = abs(here.potential_slope[0]) > NEAR * unit * abs(here.potential_bend[0])
    return bool(abs(here.spindle_slope[0]) <= MET * beside and pulls)


def _changes(values: FloatArray) -> Iterator[tuple[int, int]]:
    """Indices of neighbours of opposite sign, or of those around a zero or two."""
    significant = np.flatnonzero(values)
    for low, high in zip(significant[:-1].tolist(), significant[1:].tolist(), strict=True):
        if values[low] * values[high] < 0.0 and high - low - 1 <= BETWEEN:
            yield low, high


def _root(value: Callable[[float], FloatArray], low: float, high: float) -> float:
    return float(brentq(lambda at: float(value(at)[0]), low, high, xtol=1e-14, rtol=1e-14))


def _once(reduction: Reduction, places: Sequence[float]) -> list[int]:
    """Which places lie in the travel; of a motion that comes round, what lies at both its ends once."""
    travel, same = reduction.travel, SEAM * reduction.unit
    inside = [k for k, place in enumerate(places) if travel.low - same < place < travel.high + same]
    return [k for k in inside if not (travel.period and _again(places[k] + travel.period, places, same))]


def _again(place: float, places: Sequence[float], same: float) -> bool:
    return any(abs(place - other) < same for other in places)


def asked_values(reduction: Reduction, values: object) -> FloatArray:
    """Values (n,) of the leading coordinate as numbers in its travel. Raises MechanismError for anything else."""
    mechanism, travel = reduction.mechanism, reduction.travel
    try:
        given = np.asarray(values)
    except ValueError:  # rows of different lengths
        given = np.array([], dtype=object)
    wanted = np.atleast_1d(given).astype(np.float64) if given.dtype.kind in "iuf" else np.array([np.nan])
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted)):
        raise MechanismError(
            f"values of {mechanism.coordinate!r} must be a list of finite numbers in SI; got {shown(values)}"
        )
    counted = travel.counted(wanted)
    outside = counted[~travel.holds(counted)]
    if outside.size:
        low, high = (spoken_coordinate(reduction.scene, end) for end in travel.ends)
        where = f"{spoken_coordinate(reduction.scene, float(outside[0]))} ({outside[0]:.6g})"
        beyond = travel.below if outside[0] <= travel.ends[0] else travel.above
        raise MechanismError(
            f"{mechanism.coordinate} = {where} lies outside the travel, {low} to {high} ({travel.ends[0]:.6g} to "
            f"{travel.ends[1]:.6g}): {beyond}"
        )
    return counted


def asked_resistance(mechanism: Mechanism, resistance: object, against: object) -> tuple[float, str]:
    """A resistance (N, or N m) at a reading, as a number and the reading's name. Raises MechanismError for others."""
    names = [reading.name for reading in mechanism.readings]
    if not isinstance(against, str):
        raise MechanismError(f"`against` must be the name of a reading; got {shown(against)}; readings are {names}")
    angle = mechanism.reading(against).quantity == "angle"
    number = parse(resistance, "torque" if angle else "force", "the resistance")
    if number < 0:
        raise MechanismError(f"the resistance must not be negative; got {number:g}")
    if number > HARDEST:
        raise MechanismError(f"the resistance must be at most {HARDEST:g}; got {number:g}")
    return number, against


def spoken_coordinate(scene: Scene, value: float) -> str:
    """A value (SI) of the leading coordinate in everyday units."""
    mechanism = scene.part.mechanism
    return spoken(value, "rad" if mechanism.reading(mechanism.coordinate).quantity == "angle" else "m")


def readings_at(mechanism: Mechanism, along: Along) -> dict[str, FloatArray]:
    """All readings (n,) SI; the leading coordinate counted on over turns, as the travel counts it."""
    found = {one.name: reading_value(mechanism, one.name, along.poses) for one in mechanism.readings}
    return found | {mechanism.coordinate: along.coordinate} if mechanism.coordinate in found else found
