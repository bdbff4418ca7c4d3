"""Limit of stability along a key of a scene."""

from typing import Any

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.linearisation import Linearisation, linearise_from_start
from governor_mechanism.statics.stability_limit import StabilityLimit, find_stability_limit
from governor_mechanism.studies.sweep.parameters import parse_axes, parse_scene_with


def find_scene_stability_limit(scene: Scene, key: str, low: Any, high: Any) -> StabilityLimit[Linearisation]:
    """Return the value of a key at which the steady state of a scene becomes unstable.

    Parameters
    ----------
    scene
        Scene from a file or a document.
    key
        Dotted key of a quantity, as in a sweep.
    low
        One end of its range, SI, or text with a unit.
    high
        The other end.

    Returns
    -------
    StabilityLimit
        The limit.

    Raises
    ------
    MechanismError
        If the key or a value is wrong, or the stability does not change between the ends.
    """
    (axis,) = parse_axes(scene.document, {key: [low, high]})
    if not axis.is_numeric:
        raise MechanismError(f"{key} takes no quantity, so it has no limit of stability; name the key of a number")

    def linearise_at(value: float) -> Linearisation:
        changed_scene = parse_scene_with(scene.document, [(axis.key, f"{value!r} {axis.unit}" if axis.unit else value)])
        return linearise_from_start(changed_scene, *initial_state(changed_scene))

    first, last = (float(value) for value in axis.values)
    return find_stability_limit(linearise_at, first, last, key=key, unit=axis.unit)
