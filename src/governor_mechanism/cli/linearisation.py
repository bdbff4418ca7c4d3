"""Text and JSON of linearised equations and of a limit of stability."""

from collections.abc import Iterable, Sequence

from governor_mechanism.api import equilibria, linearise, stability_limit
from governor_mechanism.cli.console import CommandResult
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.first_order_system import Onset
from governor_mechanism.statics.linearisation import Linearisation, last_spindle_speed
from governor_mechanism.statics.stability_limit import StabilityLimit


def report_linearisation(scene: Scene, spindle_speed: float | None, limit: str | None) -> CommandResult:
    """Return what `equilibria --linearise` and `--limit` print.

    Parameters
    ----------
    scene
        The scene.
    spindle_speed
        Speed of the spindle, rad/s; that of the scene if None.
    limit
        Key and range as "KEY=LOW:HIGH" for a limit of stability, or None.

    Returns
    -------
    CommandResult
        Lines for the terminal, and the same in SI.

    Raises
    ------
    MechanismError
        If nothing can be linearised.
    """
    if limit is not None:
        key, low, high = _parse_limit(limit)
        result = stability_limit(scene, key, low, high)
        values = {"limit": _select_attributes(result, LIMIT_KEYS), "linearisations": [_values_of(result.linearisation)]}
        return CommandResult(text=[scene.title, _format_limit(result), result.linearisation], values=values)
    linearisations = _linearise_all(scene, spindle_speed)
    return CommandResult(text=[scene.title, *linearisations], values={"linearisations": [*map(_values_of, linearisations)]})


def _linearise_all(scene: Scene, spindle_speed: float | None) -> Sequence[Linearisation | str]:
    """Linearise about each equilibrium, or give the reason why not; about the state nearest to the start if no equilibria are known."""
    if len(scene.parts) > 1 or not isinstance(scene.spindle, Spindle):
        return [linearise(scene, spindle_speed)]
    try:
        points = equilibria(scene, last_spindle_speed(scene) if spindle_speed is None else spindle_speed)
    except MechanismError:
        return [linearise(scene, spindle_speed)]
    results: list[Linearisation | str] = []
    for point in points:
        try:
            results.append(linearise(scene, spindle_speed, at=point))
        except MechanismError as error:
            results.append(error.problems[0])
    if all(isinstance(one, str) for one in results):
        raise MechanismError(*dict.fromkeys(map(str, results)))
    return results


def _parse_limit(text: str) -> tuple[str, str | float, str | float]:
    key, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and key.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--limit {text!r} is not understood; write "KEY=LOW:HIGH", as in "effects.dashpot.sleeve=0:100"')
    return key.strip(), _parse_number(low), _parse_number(high)


def _parse_number(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text.strip()


def _format_limit(limit: StabilityLimit[Linearisation]) -> str:
    value = f"{limit.value:.10g} {limit.unit}".strip()
    side = "below" if limit.stable_below else "above"
    if not limit.frequency:
        return f"{limit.key}: stable {side} {value}; at the limit the motion diverges without oscillation"
    onset = {
        Onset.SOFT: "soft (their amplitude grows from zero)",
        Onset.HARD: "hard (large disturbances lead to large oscillations on the stable side too)",
        Onset.UNKNOWN: "not determined",
    }[limit.onset]
    return f"{limit.key}: stable {side} {value}; oscillations of {limit.frequency:.6g} rad/s begin there, onset {onset}"


LIMIT_KEYS = ("key", "unit", "value", "frequency", "stable_below", "onset")
MODE_KEYS = ("eigenvalue", "error_estimate", "natural_frequency", "damping_ratio", "is_conserved", "amplitudes")
"""What is printed of a limit of stability and of a mode."""


def _values_of(linearisation: Linearisation | str) -> object:
    """Return what is printed of linearised equations, or the reason why there are none."""
    if isinstance(linearisation, str):
        return linearisation
    return {
        **_select_attributes(linearisation, ("readings", "rates", "stability", "stable", "error_estimate")),
        "states": linearisation.state_names,
        "matrix": linearisation.matrix,
        "modes": [_select_attributes(mode, MODE_KEYS) for mode in linearisation.modes],
        "notes": linearisation.notes,
    }


def _select_attributes(value: object, names: Iterable[str]) -> dict[str, object]:
    return {name: getattr(value, name) for name in names}
