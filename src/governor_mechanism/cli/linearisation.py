"""Text and JSON of linearised equations and of a limit of stability."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from governor_mechanism.api import equilibria, linearise, stability_limit
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.first_order_system import Onset
from governor_mechanism.statics.linearisation import Linearisation, last_spindle_speed
from governor_mechanism.statics.modes import Mode
from governor_mechanism.statics.stability_limit import StabilityLimit


def report_linearisation(scene: Scene, spindle_speed: float | None, limit: str | None) -> tuple[str, dict[str, Any]]:
    """Return what `equilibria --linearise` and `--limit` print, as text and as JSON values.

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
    text : str
        Lines for the terminal.
    report : dict[str, Any]
        The same in SI.

    Raises
    ------
    MechanismError
        If nothing can be linearised.
    """
    if limit is not None:
        key, low, high = _parse_limit(limit)
        result = stability_limit(scene, key, low, high)
        text = [scene.title, _format_limit(result), str(result.linearisation)]
        return "\n".join(text), {"limit": _limit_as_json(result), "linearisations": [_as_json(result.linearisation)]}
    linearisations = _linearise_all(scene, spindle_speed)
    return "\n".join([scene.title, *map(str, linearisations)]), {
        "linearisations": [one if isinstance(one, str) else _as_json(one) for one in linearisations]
    }


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


def _limit_as_json(limit: StabilityLimit[Linearisation]) -> dict[str, Any]:
    values = {name: getattr(limit, name) for name in ("key", "unit", "value", "frequency", "stable_below")}
    return {**values, "onset": str(limit.onset)}


def _as_json(linearisation: Linearisation) -> dict[str, Any]:
    return {
        "readings": dict(linearisation.readings),
        "rates": dict(linearisation.rates),
        "stability": str(linearisation.stability),
        "stable": linearisation.stable,
        "error_estimate": linearisation.error_estimate,
        "states": list(linearisation.state_names),
        "matrix": linearisation.matrix.tolist(),
        "modes": [_mode_as_json(mode) for mode in linearisation.modes],
        "notes": list(linearisation.notes),
    }


def _mode_as_json(mode: Mode) -> dict[str, Any]:
    return {
        "eigenvalue": [mode.eigenvalue.real, mode.eigenvalue.imag],
        "error_estimate": mode.error_estimate,
        "natural_frequency": mode.natural_frequency,
        "damping_ratio": mode.damping_ratio,
        "is_conserved": mode.is_conserved,
        "amplitudes": {name: [value.real, value.imag] for name, value in mode.amplitudes.items()},
    }
