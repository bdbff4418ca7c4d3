"""The result of the design of a Hartnell governor, as text and as plain values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.hartnell.inputs import RPM, HartnellInputs, Travel
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table


@dataclass(frozen=True, kw_only=True)
class SleeveSpring:
    """A spring on the sleeve, and what it makes of the exact governor.

    Attributes
    ----------
    forces
        Its forces in the lowest and the highest position, N.
    rate
        Its rate, N/m.
    compression
        Its initial compression, in the lowest position, m.
    speeds
        Speeds at which the exact governor stands still in the lowest and the highest position under this spring, rad/s.
    """

    forces: tuple[float, float]
    rate: float
    compression: float
    speeds: tuple[float, float]

    @property
    def sensitiveness(self) -> float:
        """Range of speed over mean speed."""
        low, high = self.speeds
        return (high - low) / (0.5 * (low + high))


@dataclass(frozen=True, kw_only=True)
class HartnellDesign(PrintedResult):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs, with what follows from the others.
    travel
        The lowest and the highest position.
    textbook
        The spring by the textbooks' formula.
    exact
        The spring by exact statics.
    textbook_effort
        Mean force at the sleeve half way up for a change of speed of 1 %, by the textbooks' formula, N.
    effort
        The same by exact statics, N.
    warnings
        Warnings, one sentence each.
    scene_document
        The document of a scene file of the governor with the exact spring, a dashpot and stops, while its speed rises.
    """

    inputs: HartnellInputs
    travel: Travel
    textbook: SleeveSpring
    exact: SleeveSpring
    textbook_effort: float
    effort: float
    warnings: tuple[str, ...] = ()
    scene_document: Mapping[str, Any] = field(default_factory=dict, repr=False)

    __repr__ = short_repr

    @property
    def governor(self) -> closed.HartnellGovernor:
        """Dimensions and masses for the closed forms."""
        return build_governor(self.inputs)

    @property
    def power(self) -> float:
        """Effort times lift for a change of speed of 1 %, as the textbooks define it, J."""
        return self.effort * self.travel.lift

    @property
    def scene(self) -> Scene:
        """The scene of that document."""
        return parse_scene_document(self.scene_document)

    def summary_lines(self) -> list[str]:
        """Return the design as text in workshop units."""
        inputs, travel, springs = self.inputs, self.travel, (self.textbook, self.exact)
        weight = inputs.sleeve_mass * inputs.gravity
        powers = [1e3 * effort * travel.lift for effort in (self.textbook_effort, self.effort)]
        rows = [
            ("load of the sleeve, lowest", "N", *(f"{spring.forces[0] + weight:.6g}" for spring in springs)),
            ("load of the sleeve, highest", "N", *(f"{spring.forces[1] + weight:.6g}" for spring in springs)),
            ("spring force, lowest", "N", *(f"{spring.forces[0]:.6g}" for spring in springs)),
            ("spring force, highest", "N", *(f"{spring.forces[1]:.6g}" for spring in springs)),
            ("spring rate", "N/mm", *(f"{spring.rate / 1e3:.6g}" for spring in springs)),
            ("initial compression", "mm", *(f"{spring.compression * 1e3:.6g}" for spring in springs)),
            ("effort for 1 % of speed, half way up", "N", f"{self.textbook_effort:.6g}", f"{self.effort:.6g}"),
            ("power for 1 % of speed", "mJ", *(f"{power:.6g}" for power in powers)),
            ("then the exact speed, lowest", "rpm", *(f"{spring.speeds[0] / RPM:.6g}" for spring in springs)),
            ("then the exact speed, highest", "rpm", *(f"{spring.speeds[1] / RPM:.6g}" for spring in springs)),
            ("then the sensitiveness", "%", *(f"{100 * spring.sensitiveness:.5g}" for spring in springs)),
        ]
        angles, radii = [math.degrees(angle) for angle in travel.arm_angles], [1e3 * radius for radius in travel.radii]
        return [
            f"travel: lift {1e3 * travel.lift:.6g} mm, radii of the balls {radii[0]:.6g} to {radii[1]:.6g} mm, "
            f"arms {angles[0]:.4g} to {angles[1]:.4g} deg from the upright",
            format_table(("spring for the wanted speeds", "", "textbook", "exact"), rows, "llrr"),
            "textbook: weight of the balls and obliquity of the arms neglected; exact: neither.",
            *self.warnings,
        ]

    def __str__(self) -> str:
        """Return the design as text."""
        return "\n".join(self.summary_lines())

    def as_json(self) -> dict[str, Any]:
        """Return the design as plain values in SI."""
        springs = {name: plain_record(one, sensitiveness=one.sensitiveness) for name, one in self._springs.items()}
        return plain_record(self, "scene_document", **springs, power=self.power)

    @property
    def _springs(self) -> dict[str, SleeveSpring]:
        return {"textbook": self.textbook, "exact": self.exact}


def build_governor(inputs: HartnellInputs) -> closed.HartnellGovernor:
    """Return the governor of the closed forms.

    Parameters
    ----------
    inputs
        Inputs without None.

    Returns
    -------
    HartnellGovernor
        Dimensions and masses.
    """
    return closed.HartnellGovernor(
        ball_arm=inputs.ball_arm,
        sleeve_arm=inputs.sleeve_arm,
        pivot_radius=inputs.pivot_radius or 0.0,
        ball_mass=inputs.ball_mass,
        angle=inputs.bell_crank_angle,
        sleeve_mass=inputs.sleeve_mass,
        gravity=inputs.gravity,
    )
