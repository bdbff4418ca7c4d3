"""The result of the design of a pendulum governor, as text and as plain values."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from governor_mechanism.closed_form.pendulum import dynamics
from governor_mechanism.closed_form.pendulum.kinematics import PendulumGovernor
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.governed_engine.results import Check
from governor_mechanism.studies.pendulum.inputs import KILOGRAM_FORCE, RPM, PendulumInputs, Requirement
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

SPEED_CHANGE = 0.01
"""Relative change of speed for which the effort is stated, as textbooks do."""


@dataclass(frozen=True, kw_only=True)
class ParabolaStart:
    """The lowest position on the parabola x^2 = c y of the lowest speed; lengths m, angle rad.

    Attributes
    ----------
    double_parameter
        c.
    empirical_abscissa
        Distance from the axis by the empirical rule.
    abscissa, ordinate
        Distance x1 from the axis that is taken, and height y1 above the vertex.
    arm_angle
        Angle a1 of the arm from the vertical, the slope of the parabola.
    radius_of_curvature
        Radius of curvature there.
    """

    double_parameter: float
    empirical_abscissa: float
    abscissa: float
    ordinate: float
    arm_angle: float
    radius_of_curvature: float


@dataclass(frozen=True, kw_only=True)
class TrialPosition:
    """A position of step VI: change of the arm angle from the lowest position and arm angle (rad), ball radius (m), speed (rad/s)."""

    angle_change: float
    arm_angle: float
    ball_radius: float
    speed: float


@dataclass(frozen=True, kw_only=True)
class DesignStep:
    """A step of the procedure: its number in the paper, the quantity, its formula, its value and the unit of the value."""

    number: str
    quantity: str
    formula: str
    value: float
    unit: str

    @property
    def cells(self) -> tuple[str, ...]:
        """The step as a row of a table."""
        return self.number, self.quantity, self.formula, f"{self.value:.7g}", self.unit


@dataclass(frozen=True, kw_only=True)
class PendulumDesign(PrintedResult):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs, with the values of their kind.
    requirement
        Kind, speeds, mass ratio and resistance.
    governor
        Dimensions and masses.
    start
        The lowest position and its parabola.
    arm_angles
        Arm angles at the lowest and the highest speed, rad.
    ball_radii
        Distances of the balls from the axis there, m.
    trials
        Positions and speeds on the way, the table of step VI.
    sleeve_lift
        Travel of the sleeve, m.
    sleeve_force
        Force P + Q that holds down the sleeve at standstill, N.
    speed_limits
        Lowest and highest speed that the governor allows with its resistance, steps VII and VIII, rad/s.
    checks
        Zehnder's rules.
    scene_document
        The document of a scene file of the governor with its resistance, a dashpot and stops, while its speed rises.
    """

    inputs: PendulumInputs
    requirement: Requirement
    governor: PendulumGovernor
    start: ParabolaStart
    arm_angles: tuple[float, float]
    ball_radii: tuple[float, float]
    trials: tuple[TrialPosition, ...]
    sleeve_lift: float
    sleeve_force: float
    speed_limits: tuple[float, float]
    checks: tuple[Check, ...]
    scene_document: Mapping[str, Any] = field(default_factory=dict, repr=False)

    __repr__ = short_repr

    @property
    def sensitiveness(self) -> float:
        """Range of speed over mean speed, without resistance (German Ungleichförmigkeitsgrad)."""
        low, high = self.requirement.lowest_speed, self.requirement.highest_speed
        return (high - low) / ((high + low) / 2)

    @property
    def is_osculating(self) -> bool:
        """Whether the arm is the radius of curvature of the parabola at the lowest position."""
        return math.isclose(self.governor.arm, self.start.radius_of_curvature, rel_tol=1e-9)  # both come from the same numbers

    @property
    def effort(self) -> float:
        """Mean force at the sleeve while it yields to a change of speed of 1 %, N."""
        return self.sleeve_force * ((1 + SPEED_CHANGE) ** 2 - 1) / 2

    @property
    def work_capacity(self) -> float:
        """Work that raises balls and sleeve from the lowest to the highest position, J."""
        return self.sleeve_force * self.sleeve_lift

    @property
    def middle_angle(self) -> float:
        """Arm angle at which the sleeve is half way up, rad."""
        return self.angle_at(0.5)

    def angle_at(self, fraction: float) -> float:
        """Return the arm angle (rad) at a fraction of the lift of the sleeve."""
        low, high = (math.cos(angle) for angle in self.arm_angles)
        return math.acos(low + fraction * (high - low))

    def equilibrium_speed(self, arm_angle: float) -> float:
        """Return the speed of rest (rad/s) at an arm angle (rad)."""
        return float(dynamics.equilibrium_speed(self.governor, arm_angle=arm_angle))

    @property
    def scene(self) -> Scene:
        """The scene of that document."""
        return parse_scene_document(self.scene_document)

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each rule that is not kept."""
        return tuple(str(check) for check in self.checks if not check.ok)

    @property
    def steps(self) -> tuple[DesignStep, ...]:
        """The steps I to VIII with their numbers."""
        return tuple(_steps(self))

    def summary_lines(self) -> list[str]:
        """Return the design as text in workshop units."""
        governor, requirement = self.governor, self.requirement
        rows = [step.cells for step in self.steps]
        angles, lift = [math.degrees(angle) for angle in self.arm_angles], 1e3 * self.sleeve_lift
        hung = f"at {_mm(governor.offset)} mm from the axis" if governor.offset else "on the axis"
        arms = "crossed arms" if governor.offset < 0 else "arms"
        force = self.sleeve_force
        return [
            format_table(("step", "quantity", "formula", "value", ""), rows, "lllrl"),
            "",
            f"governor: {requirement.kind}, {arms} of {_mm(governor.arm)} mm {hung}, {angles[0]:.5g} to "
            f"{angles[1]:.5g} deg; balls of {governor.ball_mass:.5g} kg, sleeve {governor.sleeve_mass:.5g} kg with a lift of {lift:.5g} mm",
            f"speed: {_rpm(requirement.lowest_speed)} to {_rpm(requirement.highest_speed)} rpm at rest, sensitiveness "
            f"{self.sensitiveness:.4%}; insensitivity {self.inputs.insensitivity:.4%} with {requirement.resistance:.4g} N at the sleeve",
            f"sleeve: held down by {force:.5g} N, effort {self.effort:.4g} N for 1 % of speed, work capacity {self.work_capacity:.4g} J",
            *(str(check) for check in self.checks),
        ]

    def trial_table(self) -> str:
        """Return the table of step VI as text."""
        columns = ("a2 - a1, deg", "a2, deg", "x2, mm", "w2, rad/s", "n2, rpm")
        rows = [
            (
                f"{math.degrees(trial.angle_change):.6g}",
                f"{math.degrees(trial.arm_angle):.6f}",
                f"{1e3 * trial.ball_radius:.4f}",
                f"{trial.speed:.7f}",
                f"{trial.speed / RPM:.5f}",
            )
            for trial in self.trials
        ]
        return format_table(columns, rows, "r")

    def __str__(self) -> str:
        """Return the design as text."""
        return "\n".join([*self.summary_lines(), "", "step VI, tried:", self.trial_table()])

    def as_json(self) -> dict[str, Any]:
        """Return the design as plain values in SI; the steps in their own units."""
        names = ("sensitiveness", "effort", "work_capacity", "middle_angle", "steps", "warnings")
        checks = [plain_record(check, ok=check.ok) for check in self.checks]
        return plain_record(self, "scene_document", checks=checks, **{name: getattr(self, name) for name in names})


def _steps(design: PendulumDesign) -> Iterator[DesignStep]:
    """Yield the steps in the units of the paper: kgf, cm, rpm."""
    governor, start, inputs = design.governor, design.start, design.inputs
    kgf, cm = KILOGRAM_FORCE, 0.01

    def step(number: str, quantity: str, formula: str, value: float, unit: str) -> DesignStep:
        return DesignStep(number=number, quantity=quantity, formula=formula, value=value, unit=unit)

    weight = inputs.gravity * governor.ball_mass / inputs.joint_ratio
    yield step("I", "weight of a ball, P", "W / ((1 + m) delta)", weight / kgf, "kgf")
    if inputs.joint_ratio < 1:
        yield step("Ia", "weight on extended arms, P1", "(l1 / l) P", inputs.gravity * governor.ball_mass / kgf, "kgf")
    yield step("II", "weight of the sleeve, Q", "m P", inputs.gravity * governor.sleeve_mass / kgf, "kgf")
    yield step("III", "parameter, c1 / 2", "g (1 + m) / w1^2", start.double_parameter / 2 / cm, "cm")
    rule = "1000 sqrt(1 + m) / n1 - 1" if inputs.start_radius is None else "given"
    yield step("", "start radius, x1", rule, start.abscissa / cm, "cm")
    yield step("IV", "ordinate, y1", "x1^2 / c1", start.ordinate / cm, "cm")
    yield step("", "lowest arm angle, a1", "tan a1 = 2 y1 / x1", math.degrees(start.arm_angle), "deg")
    yield step("V", "radius of curvature", "rho^2 = (c1 + 4 y1)^3 / (4 c1)", start.radius_of_curvature / cm, "cm")
    yield step(
        "",
        "arm, l",
        "given" if inputs.arm is not None else "(x1 - e) / sin a1" if governor.arm != start.radius_of_curvature else "rho",
        governor.arm / cm,
        "cm",
    )
    yield step("", "offset, e", "x1 - l sin a1", governor.offset / cm, "cm")
    yield step("VI", "highest arm angle, a2", "w2^2 = g (1 + m) tan a2 / x2", math.degrees(design.arm_angles[1]), "deg")
    yield step("", "ball radius there, x2", "e + l sin a2", design.ball_radii[1] / cm, "cm")
    yield step("", "lift of the sleeve", "2 l1 (cos a1 - cos a2)", design.sleeve_lift / cm, "cm")
    limits = ("n1 (1 - (delta - epsilon) / 2)", "n2 (1 + (delta - epsilon) / 2)")
    if inputs.insensitivity < inputs.speed_fluctuation:
        limits = ("n1: the machine overcomes W", "n2: the machine overcomes W")
    yield step("VII", "lowest speed allowed, n1''", limits[0], design.speed_limits[0] / RPM, "rpm")
    yield step("VIII", "highest speed allowed, n2'", limits[1], design.speed_limits[1] / RPM, "rpm")


def _rpm(speed: float) -> str:
    return f"{speed / RPM:.6g}"


def _mm(length: float) -> str:
    return f"{length * 1e3:.5g}"
