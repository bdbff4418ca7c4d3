"""Design of a Hartung governor after Dubois: bell cranks, springs and their stress, sleeve force.

It uses the closed forms only and does not round intermediate results. The printed numbers of the paper are in `paper_comparison`.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form.hartung import design as formulas
from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.studies.hartung.inputs import KILOGRAM_FORCE, PAPER_INPUTS, TECHNICAL_ATMOSPHERE, HartungInputs, find_input_problems
from governor_mechanism.types import FloatArray

N_STROKE_POINTS = 121
"""Number of points of a curve over the stroke."""
MIN_COIL_TURNS = 3.0
"""Minimum number of turns of a useful coil spring."""
ANGLE_SEARCH_STEP = math.radians(1.0)
"""Step of the initial search for the best angle (rad)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HartungLayout:
    """A governor with springs along Doerfel's line and its forces over the stroke, inner end first.

    levers (n,) rad and radii (n,) m describe the position of the weights; slow_forces and fast_forces (n,) N balance the slow and the fast
    speed; spring_forces (n,) N are those of each spring; static_forces (n,) N hold down the sleeve at standstill; spring_rate is in N/m.
    """

    governor: closed.HartungGovernor
    spring_rate: float
    levers: FloatArray
    radii: FloatArray
    slow_forces: FloatArray
    fast_forces: FloatArray
    spring_forces: FloatArray
    static_forces: FloatArray

    @property
    def spread(self) -> float:
        """Range of the static force relative to its mean."""
        return closed.relative_spread(self.static_forces)


@dataclass(frozen=True, kw_only=True)
class HartungDesign:
    """Result of a design in SI: lengths m, forces N, angles rad, stress Pa.

    Attributes
    ----------
    inputs
        The inputs.
    layout
        The governor and its forces over the stroke.
    centrifugal_forces
        Centrifugal force at the inner end and slow speed, and at the outer end and fast speed.
    middle_abscissa
        Deflection y0 of the spring at mid stroke.
    formula_angle
        Angle of the bell crank by tan = -y0 / a.
    best_angle
        Angle with the smallest spread of the static sleeve force.
    best_spread
        Spread at that angle.
    angle
        Angle of the bell crank used.
    sleeve_arm
        Sleeve arm of the bell crank used.
    travel
        Travel of the sleeve.
    spring_rate
        Rate of each spring, N/m.
    preload
        Force of each spring at the inner end.
    turns
        Number of turns of the spring.
    wire_length
        Length of the spring wire.
    stress
        Shear stress of the spring at the outer end.
    regulating_forces
        Regulating force at the inner and the outer end.
    speed_limits
        Lower and upper speed (rad/s) at which the sleeve moves, at the inner and the outer end.
    warnings
        Warnings, one sentence each.
    """

    inputs: HartungInputs
    layout: HartungLayout
    centrifugal_forces: tuple[float, float]
    middle_abscissa: float
    formula_angle: float
    best_angle: float
    best_spread: float
    angle: float
    sleeve_arm: float
    travel: float
    spring_rate: float
    preload: float
    turns: float
    wire_length: float
    stress: float
    regulating_forces: tuple[float, ...]
    speed_limits: tuple[tuple[float, ...], ...]
    warnings: tuple[str, ...] = ()

    def summary_lines(self) -> list[str]:
        """Return the design as text in workshop units."""
        layout, static_forces = self.layout, self.layout.static_forces / KILOGRAM_FORCE
        inner_speeds, outer_speeds = (" and ".join(f"{speed * 30 / math.pi:.4g}" for speed in pair) for pair in self.speed_limits)
        inner_force, outer_force = (f"{force / KILOGRAM_FORCE:.4g}" for force in self.regulating_forces)
        return [
            f"bell crank: {math.degrees(self.angle):.6g} deg, arms {self.inputs.weight_arm * 1e3:.6g} and "
            f"{self.sleeve_arm * 1e3:.6g} mm; tan = -y0 / a gives {math.degrees(self.formula_angle):.6g} deg",
            f"springs: {self.spring_rate / KILOGRAM_FORCE / 1e3:.5g} kgf/mm, {self.preload / KILOGRAM_FORCE:.5g} kgf innermost; "
            f"{self.turns:.4g} turns of {self.wire_length:.4g} m wire, stressed to {self.stress / TECHNICAL_ATMOSPHERE:.5g} kgf/cm^2",
            f"static sleeve force: {static_forces[0]:.5g} kgf inside, {static_forces[-1]:.5g} outside, changes by "
            f"{100 * layout.spread:.3g} %; the smallest spread is at {math.degrees(self.best_angle):.5g} deg, with "
            f"{100 * self.best_spread:.3g} %",
            f"regulating force: {inner_force} kgf inside, overcome at {inner_speeds} rpm; {outer_force} kgf outside, at {outer_speeds} rpm",
            f"sleeve travel: {self.travel * 1e3:.5g} mm",
            *(f"warning: {sentence}" for sentence in self.warnings),
        ]

    def as_json(self) -> dict[str, Any]:
        """Return the design as plain values, the curves as lists."""
        curves = plain_record(self.layout, "governor", "spring_rate")
        return plain_record(self, "layout", static_force_spread=self.layout.spread, curves=curves)


def design_hartung(inputs: HartungInputs = PAPER_INPUTS) -> HartungDesign:
    """Design a Hartung governor by the procedure of the paper.

    Parameters
    ----------
    inputs
        The inputs; by default the paper's.

    Returns
    -------
    HartungDesign
        The design.

    Raises
    ------
    MechanismError
        If no governor can be built from the inputs.
    """
    _max_bell_crank_angle(inputs)  # raises for a swing that is too large
    if problems := find_input_problems(inputs):
        raise MechanismError(*problems)
    inner_radius, outer_radius = inputs.rest_radius, inputs.rest_radius + 2 * inputs.half_stroke
    forces = (inputs.weight_mass * inputs.slow_speed**2 * inner_radius, inputs.weight_mass * inputs.fast_speed**2 * outer_radius)
    inner_abscissa = formulas.spring_abscissa(inner_force=forces[0], outer_force=forces[1], stroke=outer_radius - inner_radius)
    middle_abscissa = float(inner_abscissa) + inputs.half_stroke
    formula_angle = float(formulas.bell_crank_angle(weight_arm=inputs.weight_arm, middle_abscissa=middle_abscissa))
    angle = formula_angle if inputs.angle is None else inputs.angle
    layout = build_hartung_layout(inputs, angle, inputs.sleeve_arm)
    optimal_angle, spread = find_best_angle(inputs)
    governor, end_forces = layout.governor, layout.static_forces[[0, -1]]
    speeds = np.array([inputs.slow_speed, inputs.fast_speed])
    regulating_forces = np.asarray(formulas.regulating_force(static_force=end_forces, insensitivity=inputs.insensitivity))
    speed_limits = formulas.speed_limits(spindle_speed=speeds, regulating_force=regulating_forces, static_force=end_forces)
    coil_arguments = {"wire": inputs.wire, "coil": inputs.coil, "modulus": inputs.modulus}
    stress = float(formulas.coil_stress(wire=inputs.wire, coil=inputs.coil, force=layout.spring_forces[-1]))
    turns = float(formulas.coil_turns(**coil_arguments, rate=layout.spring_rate))
    return HartungDesign(
        inputs=inputs,
        layout=layout,
        centrifugal_forces=forces,
        middle_abscissa=middle_abscissa,
        formula_angle=formula_angle,
        best_angle=optimal_angle,
        best_spread=spread,
        angle=angle,
        sleeve_arm=governor.sleeve_arm,
        travel=float(formulas.sleeve_travel(sleeve_arm=governor.sleeve_arm, angle=angle, swing=inputs.swing)),
        spring_rate=layout.spring_rate,
        preload=float(layout.spring_forces[0]),
        turns=turns,
        wire_length=float(formulas.wire_length(**coil_arguments, rate=layout.spring_rate)),
        stress=stress,
        regulating_forces=tuple(regulating_forces.tolist()),
        speed_limits=tuple(zip(*(np.asarray(limits).tolist() for limits in speed_limits), strict=True)),
        warnings=_warnings(inputs, stress, turns),
    )


def build_hartung_layout(inputs: HartungInputs, angle: float, sleeve_arm: float | None = None) -> HartungLayout:
    """Return the governor with a given bell crank and its forces over the stroke.

    Parameters
    ----------
    inputs
        The inputs.
    angle
        Angle of the bell crank, rad.
    sleeve_arm
        Sleeve arm of the bell crank, m; None: hangers symmetric about the axis.

    Returns
    -------
    HartungLayout
        Governor and forces.

    Raises
    ------
    MechanismError
        If the lever would pass its change point, or springs cannot follow the line.
    """
    if sleeve_arm is None:
        sleeve_arm = float(formulas.symmetric_sleeve_arm(fulcrum_radius=inputs.fulcrum_radius, angle=angle, swing=inputs.swing))
    governor = inputs.governor(angle, sleeve_arm)
    levers = np.linspace(inputs.swing, -inputs.swing, N_STROKE_POINTS)
    radii = np.asarray(closed.weight_radius(governor, lever_angle=levers))
    slow_forces, fast_forces = (
        np.asarray(closed.astatic_spring_force(governor, lever_angle=levers, spindle_speed=speed))
        for speed in (inputs.slow_speed, inputs.fast_speed)
    )
    if not 0 < slow_forces[0] < fast_forces[-1]:
        raise MechanismError(
            f"a weight needs a spring force of {slow_forces[0]:.4g} N at slow_speed and the inner end, and of "
            f"{fast_forces[-1]:.4g} N at fast_speed and the outer end;"
            " it must be positive and rise outward; increase rest_radius, weight_mass or the speeds, or reduce swing"
        )
    end_forces = {"inner_force": float(slow_forces[0]), "outer_force": float(fast_forces[-1])}
    spring_rate = float(formulas.effective_spring_rate(**end_forces, stroke=float(radii[-1] - radii[0])))
    spring_forces = slow_forces[0] + spring_rate * (radii - radii[0])
    return HartungLayout(
        governor=governor,
        spring_rate=spring_rate,
        levers=levers,
        radii=radii,
        slow_forces=slow_forces,
        fast_forces=fast_forces,
        spring_forces=spring_forces,
        static_forces=np.asarray(closed.static_sleeve_force(governor, lever_angle=levers, spring_force=spring_forces)),
    )


def find_best_angle(inputs: HartungInputs) -> tuple[float, float]:
    """Return the angle (rad, at least 90 deg) with the smallest spread of the static sleeve force, and that spread."""

    def spread(angle: float) -> float:
        return build_hartung_layout(inputs, angle).spread

    max_angle = _max_bell_crank_angle(inputs)
    angles = np.arange(math.pi / 2, max_angle, ANGLE_SEARCH_STEP)
    coarse = float(angles[int(np.argmin([spread(float(angle)) for angle in angles]))])
    bounds = (max(coarse - ANGLE_SEARCH_STEP, math.pi / 2), min(coarse + ANGLE_SEARCH_STEP, max_angle))
    # The spread has a corner at its minimum: its position is known to the tolerance.
    minimum = minimize_scalar(spread, bounds=bounds, method="bounded", options={"xatol": 1e-8})
    return float(minimum.x), float(minimum.fun)


def _max_bell_crank_angle(inputs: HartungInputs) -> float:
    """Return the largest angle (rad) of the bell crank at which the lever does not reach its change point."""
    max_angle = math.pi - inputs.swing - ANGLE_SEARCH_STEP
    if max_angle <= math.pi / 2:
        raise MechanismError(
            f"with a swing of {math.degrees(inputs.swing):g} deg to each side the lever reaches its change point at "
            "every angle of the bell crank from 90 deg up; the swing must be less than 89 deg"
        )
    return max_angle


def _warnings(inputs: HartungInputs, stress: float, turns: float) -> tuple[str, ...]:
    warnings = []
    if stress > inputs.stress_limit:
        warnings.append(
            f"the springs are overstressed: {stress / TECHNICAL_ATMOSPHERE:.4g} kgf/cm^2 at the outer end of the stroke, "
            f"the limit is {inputs.stress_limit / TECHNICAL_ATMOSPHERE:.4g} kgf/cm^2; use a thicker wire or a smaller coil"
        )
    if turns < MIN_COIL_TURNS:
        warnings.append(
            f"the springs have {turns:.3g} turns, fewer than the {MIN_COIL_TURNS:g} of a useful coil; use a thicker wire or a smaller coil"
        )
    return tuple(warnings)
