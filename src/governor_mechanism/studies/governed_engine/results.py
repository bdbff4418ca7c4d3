"""The result of the design of a governed engine, as text and as plain values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from governor_mechanism.closed_form.flywheel.engine import AirEngine
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.governed_engine.dashpot import DashpotDesign
from governor_mechanism.studies.governed_engine.governor import GovernorDesign
from governor_mechanism.studies.governed_engine.inputs import GovernedEngineInputs
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

HORSEPOWER = 75 * 9.80665
"""One metric horsepower, W."""


@dataclass(frozen=True, kw_only=True)
class Flywheel:
    """The flywheel: moment of inertia (kg m2), work between its extreme speeds (J), and radius (m) and mass (kg) of a thin rim."""

    inertia: float
    energy: float
    rim_radius: float
    rim_mass: float


@dataclass(frozen=True, kw_only=True)
class ThrottleSetting:
    """A position of the throttle rod: load over the rated torque, lift of the sleeve (m), opening, and speed of the shaft (rad/s)."""

    load_fraction: float
    lift: float
    opening: float
    speed: float


@dataclass(frozen=True, kw_only=True)
class Check:
    """A rule that a design should keep.

    Attributes
    ----------
    rule
        The rule in words.
    found
        Value of the design.
    lowest, highest
        Limits of the rule; None if there is none.
    cure
        What to do if it is not kept.
    """

    rule: str
    found: float
    lowest: float | None = None
    highest: float | None = None
    cure: str = ""

    @property
    def ok(self) -> bool:
        """Whether the rule is kept."""
        return (self.lowest is None or self.found >= self.lowest) and (self.highest is None or self.found <= self.highest)

    def __str__(self) -> str:
        """Return the rule with its numbers, and the cure if it is not kept."""
        bounds = (("at least", self.lowest), ("at most", self.highest))
        limits = [f"{words} {limit:.4g}" for words, limit in bounds if limit is not None]
        text = f"{self.rule}: {self.found:.4g}, {' and '.join(limits)}"
        return f"kept: {text}" if self.ok else f"not kept: {text}; {self.cure}"


@dataclass(frozen=True, kw_only=True)
class GovernedEngineDesign(PrintedResult):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs.
    engine
        The engine under the rated torque.
    bore
        Diameter of the expansion piston, m.
    rated_torque
        Torque of the load at full load, N m.
    flywheel
        The flywheel.
    governor
        The governor and its gear.
    throttle
        Table of the throttle rod, from full load to no load.
    throttle_points
        Ends of the straight line of that table: lift (m) and opening, with the reserve of torque below full load and as much above no load.
    torque_slope
        Change of the mean torque with the lift of the sleeve, N m/m.
    dashpot
        The dashpot, and the motions of engine and governor.
    checks
        Rules that the design should keep.
    scene_document
        The document of a scene file of the engine, whose load falls from the rated torque to the half.
    """

    inputs: GovernedEngineInputs
    engine: AirEngine
    bore: float
    rated_torque: float
    flywheel: Flywheel
    governor: GovernorDesign
    throttle: tuple[ThrottleSetting, ...]
    throttle_points: tuple[tuple[float, float], tuple[float, float]]
    torque_slope: float
    dashpot: DashpotDesign
    checks: tuple[Check, ...]
    scene_document: Mapping[str, Any] = field(default_factory=dict, repr=False)

    __repr__ = short_repr

    @property
    def scene(self) -> Scene:
        """The scene of that document, to be run or linearised."""
        return parse_scene_document(self.scene_document)

    @property
    def droop(self) -> float:
        """Droop of the governor: speed without load less that at full load, over their mean."""
        low, high = self.governor.full_load_speed, self.governor.no_load_speed
        return (high - low) / ((high + low) / 2)

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each rule that is not kept."""
        return tuple(str(check) for check in self.checks if not check.ok)

    def summary_lines(self) -> list[str]:
        """Return the design as text in workshop units."""
        inputs, engine, flywheel = self.inputs, self.engine, self.flywheel
        governor = self.governor
        return [
            f"engine: {inputs.power / HORSEPOWER:.4g} PS at {_rpm(inputs.full_load_speed)} rpm, rated torque {self.rated_torque:.5g} N m; "
            f"bore {_mm(self.bore)} mm, area {1e4 * engine.area:.5g} cm2, stroke {_mm(engine.stroke)} mm; mean piston speed "
            f"{engine.stroke * inputs.speed / math.pi:.3g} m/s",
            f"speed: {_rpm(governor.full_load_speed)} rpm at full load, {_rpm(governor.no_load_speed)} rpm without load: droop "
            f"{self.droop:.4%} of their mean",
            f"flywheel: inertia {flywheel.inertia:.5g} kg m2 for a speed fluctuation of {inputs.speed_fluctuation:.4%}, storing "
            f"{flywheel.energy:.5g} J; rim {flywheel.rim_mass:.4g} kg at {flywheel.rim_radius:.4g} m",
            *self._governor_lines(),
            *self._dashpot_lines(),
            *(str(check) for check in self.checks),
            "",
            "throttle rod, a straight line:",
            self.throttle_table(),
        ]

    def _governor_lines(self) -> list[str]:
        """Return dimensions, masses and forces of the governor as text."""
        governor = self.governor
        parts, angles = governor.governor, (governor.full_load_angle, governor.no_load_angle)
        return [
            f"governor: Porter, arms {_mm(parts.arm)} mm at {_mm(parts.offset)} mm from the axis, {math.degrees(angles[0]):.5g} to "
            f"{math.degrees(angles[1]):.5g} deg; balls of {parts.ball_mass:.5g} kg, sleeve {parts.sleeve_mass:.5g} kg with a travel of "
            f"{_mm(governor.sleeve_travel)} mm; {governor.gear_ratio:.5g} turns of the spindle in one of the shaft",
            f"sleeve: held down by {governor.sleeve_force:.4g} N, effort {governor.effort:.4g} N against {self.inputs.resistance:.4g} N, "
            f"work capacity {governor.work_capacity:.4g} J; insensitivity {governor.insensitivity:.4%}: the mean speed may lie between "
            f"{_rpm(governor.speed_limits[0])} and {_rpm(governor.speed_limits[1])} rpm",
        ]

    def _dashpot_lines(self) -> list[str]:
        """Return the dashpot and the motions at each load as text."""
        dashpot = self.dashpot
        lines = [
            f"dashpot: {dashpot.damping:.5g} N s/m, {'given' if dashpot.is_given else 'with which all motions decay fastest'}: as "
            f"exp({-dashpot.decay_rate:.4g} t/s) at least; stable above {dashpot.smallest_stable_damping:.4g} N s/m (Vyshnegradskii's "
            "x y = 1)"
        ]
        for motion in dashpot.motions:
            roots = ", ".join(f"{root:.4g}" if root.imag else f"{root.real:.4g}" for root in motion.roots)
            plane = f"x = {motion.x:.4g}, y = {motion.y:.4g}, x y = {motion.x * motion.y:.4g}"
            lines.append(f"  at {motion.load_fraction:.0%} load: {plane}; roots {roots} 1/s")
        return lines

    def throttle_table(self) -> str:
        """Return the table of the throttle rod as text."""
        ends = [
            ("open", *self.throttle_points[0], None),
            *((f"{one.load_fraction:.0%}", one.lift, one.opening, one.speed) for one in self.throttle),
        ]
        rows = [(load, f"{1e3 * lift:.3f}", f"{opening:.5f}", "" if speed is None else _rpm(speed)) for load, lift, opening, speed in ends]
        return format_table(("load", "sleeve lift, mm", "throttle", "speed, rpm"), rows, "lrrr")

    def __str__(self) -> str:
        """Return the design as text."""
        return "\n".join(self.summary_lines())

    def as_json(self) -> dict[str, Any]:
        """Return the design as plain values."""
        checks = [plain_record(check, ok=check.ok) for check in self.checks]
        dashpot = plain_record(self.dashpot, decay_rate=self.dashpot.decay_rate, stability_margin=self.dashpot.stability_margin)
        return plain_record(
            self,
            "scene_document",
            droop=self.droop,
            governor=self.governor.as_json(),
            dashpot=dashpot,
            checks=checks,
            warnings=self.warnings,
        )


def _rpm(speed: float) -> str:
    return f"{speed * 30 / math.pi:.6g}"


def _mm(length: float) -> str:
    return f"{length * 1e3:.5g}"
