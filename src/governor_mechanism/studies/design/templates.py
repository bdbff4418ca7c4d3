"""Texts and scenes of designs from files with named places, and what their scenes have in common."""

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

from governor_mechanism.effects.gravity import DEFAULT_GRAVITY
from governor_mechanism.scenes.toml_text import format_toml_value
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.places import Places, fill_places

DAMPING_RATIO = 0.7
"""Damping ratio of the dashpots half way up: the sleeve follows the speed without much overshoot."""

SPEED_MARGIN_RATIO = 0.02
"""Distance of the simulated speeds from the wanted ones, relative to their difference; at these the sleeve would be at its stops."""


@cache
def read_file(name: str) -> str:
    """Return the text of a file beside this module."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


class _ScenePlaces(Places):
    """Places of a scene file: one without a format has the value as TOML writes it."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value as text."""
        return format_toml_value(value) if value is not None and not format_spec else super().format_field(value, format_spec)


def fill_template(
    machine: str,
    design: object,
    values: Mapping[str, object],  # values of the other places; the line of one that is None is left out
) -> dict[str, Any]:
    """Return the document of the scene of a machine from its template."""
    return tomllib.loads(fill_places(read_file(f"{machine}.toml"), design, _ScenePlaces(), **values))


def scene_comment(machine: str) -> str:
    """Return the comment with which the scene files of a machine begin."""
    lines = read_file(f"{machine}.toml").splitlines()
    return "\n".join(line.removeprefix("# ") for line in lines if line.startswith("#"))


def gravity_value(gravity: float) -> bool | str | None:
    """Return a gravity (m/s2) as a scene has it: true if it is the usual one, and no value if there is none."""
    if gravity == 0:
        return None
    return True if gravity == DEFAULT_GRAVITY else f"{gravity:.15g} m/s^2"


def speed_steps(times: Iterable[float], speeds: Iterable[float], digits: int = 15) -> list[tuple[float, str]]:
    """Return a program of the speed (rad/s) over times (s) as a scene has it."""
    return [(float(round(time, 6)), f"{speed / RPM:.{digits}g} rpm") for time, speed in zip(times, speeds, strict=True)]


def run_up_steps(times: Sequence[float], lowest: float, highest: float, digits: int = 15) -> list[tuple[float, str]]:
    """Return a program of the speed (rad/s) that is constant before, between and after two rises: six times (s)."""
    fractions = (SPEED_MARGIN_RATIO, SPEED_MARGIN_RATIO, 0.5, 0.5, 1 - SPEED_MARGIN_RATIO, 1 - SPEED_MARGIN_RATIO)
    return speed_steps(times, (lowest + fraction * (highest - lowest) for fraction in fractions), digits)


def sleeve_damping(
    inertia: float,  # inertia of the angle of the arms, kg m2
    frequency: float,  # frequency of small oscillations, rad/s
    lift_derivative: float,  # derivative of the lift of the sleeve by the angle, m/rad
) -> float:
    """Return the damping of the dashpot at a sleeve (N s/m).

    With the inertia I of the angle, the frequency w, and the derivative z' of the lift, a damping ratio D takes c z'^2 = 2 D I w.
    """
    return 2 * DAMPING_RATIO * inertia * frequency / lift_derivative**2


def limit(value: float, limits: tuple[float, float]) -> float:
    """Return a value, or the limit that it is beyond."""
    return min(max(limits[0], value), limits[1])
