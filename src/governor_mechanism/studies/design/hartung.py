"""Design of a Hartung governor after Dubois: bell cranks, springs and their stress, sleeve force.

It uses the closed forms only and does not round intermediate results. The printed numbers of the paper are in `hartung_paper`.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form.hartung import design as formulas
from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design.inputs import design_input, require_valid
from governor_mechanism.studies.design.skeleton import Design
from governor_mechanism.studies.design.templates import run_up_steps, sleeve_damping
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM, TECHNICAL_ATMOSPHERE
from governor_mechanism.units.places import fill_places

HALF_STROKE_TOLERANCE_RATIO = 0.05
"""Tolerance of half_stroke relative to the geometric value; the paper's rounding is 0.008."""
N_STROKE_POINTS = 121
"""Number of points of a curve over the stroke."""
MIN_COIL_TURNS = 3.0
"""Minimum number of turns of a useful coil spring."""
ANGLE_SEARCH_STEP = math.radians(1.0)
"""Step of the initial search for the best angle (rad)."""
RUN_UP_TIMES = (0.0, 1.0, 2.0, 4.0, 5.0, 7.0)
"""Times (s) of the run-up of the scene in two steps, each with time to settle."""


@dataclass(frozen=True, kw_only=True)
class HartungInputs:
    """Inputs of a design in SI; the defaults are the paper's. angle and sleeve_arm follow from the design if they are None."""

    weight_mass: float = design_input("mass", 45.0, "mass of a weight")
    sleeve_mass: float = design_input("mass", 15.0, "mass of the sleeve")
    weight_arm: float = design_input("length", 0.115, "arm of a bell crank to the weight")
    rest_radius: float = design_input("length", 0.092, "distance of the weights from the axis at the inner end")
    half_stroke: float = design_input("length", 0.030, "radial travel of the weights from the inner end to the vertical lever")
    fulcrum_height: float = design_input("length", -0.113, "height of the fulcrum", sign="any")
    swing: float = design_input("angle", math.radians(15.0), "angle of the lever from the vertical to each side")
    slow_speed: float = design_input("angular_speed", 204 * RPM, "speed at the inner end")
    fast_speed: float = design_input("angular_speed", 212 * RPM, "speed at the outer end")
    wire: float = design_input("length", 0.012, "diameter of the wire of a spring")
    coil: float = design_input("length", 0.080, "mean diameter of a coil")
    modulus: float = design_input("modulus", 750_000 * TECHNICAL_ATMOSPHERE, "modulus of shear of the wire")
    stress_limit: float = design_input("pressure", 4500 * TECHNICAL_ATMOSPHERE, "allowed shear stress of the wire")
    insensitivity: float = design_input("ratio", 0.04, "regulating force over the static sleeve force")
    angle: float | None = design_input("angle", None, "angle of the bell crank")
    sleeve_arm: float | None = design_input("length", None, "arm of the bell crank to the sleeve")

    @property
    def fulcrum_radius(self) -> float:
        """Distance of the fulcrum from the spindle axis (m)."""
        return self.rest_radius + self.half_stroke

    def governor(self, angle: float, sleeve_arm: float) -> closed.HartungGovernor:
        """Return the governor with bell cranks of an angle (rad) and a sleeve arm (m)."""
        values = {name: getattr(self, name) for name in ("weight_arm", "fulcrum_radius", "weight_mass", "sleeve_mass")}
        return closed.HartungGovernor(**values, sleeve_arm=sleeve_arm, angle=angle, gravity=KILOGRAM_FORCE_1853)


PAPER_INPUTS = HartungInputs()
"""The inputs of the paper."""


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


@dataclass(frozen=True, kw_only=True, repr=False)
class HartungDesign(Design):
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

    machine = "hartung"
    warning_start = "warning: "
    hidden = ("layout",)
    derived = ("static_force_spread", "curves")

    @property
    def static_force_spread(self) -> float:
        """Range of the static sleeve force relative to its mean."""
        return self.layout.spread

    @property
    def curves(self) -> dict[str, Any]:
        """The forces over the stroke, by name."""
        return {name: curve for name, curve in vars(self.layout).items() if name not in ("governor", "spring_rate")}

    @property
    def end_forces(self) -> tuple[float, float]:
        """Static sleeve force at the inner and the outer end, N."""
        return float(self.layout.static_forces[0]), float(self.layout.static_forces[-1])

    def scene_values(self) -> Mapping[str, object]:
        """Return what the scene adds: a run-up from the slow to the fast speed, with stops and a dashpot."""
        inputs = self.inputs
        governor = self.layout.governor
        forces = self.layout.spring_forces
        spring = {"spring_force": float(forces[len(forces) // 2]), "spring_rate": self.spring_rate}
        frequency = math.sqrt(abs(float(closed.squared_natural_frequency(governor, lever_angle=0.0, **spring))))
        inertia, lift_derivative = (float(of(governor, lever_angle=0.0)) for of in (closed.lever_inertia, closed.lift_derivative))
        return {
            "spring_turns": float(f"{self.turns:.12g}"),
            "damping": sleeve_damping(inertia, frequency, lift_derivative),
            "speed": run_up_steps(RUN_UP_TIMES, inputs.slow_speed, inputs.fast_speed, digits=12),
        }


def design_hartung(
    inputs: HartungInputs = PAPER_INPUTS,  # the inputs; by default the paper's
) -> HartungDesign:
    """Design a Hartung governor by the procedure of the paper.

    Raises MechanismError if no governor can be built from the inputs.
    """
    _max_bell_crank_angle(inputs)  # raises for a swing that is too large
    require_valid(inputs, _contradictions)
    inner_radius = inputs.rest_radius
    outer_radius = inputs.rest_radius + 2 * inputs.half_stroke
    forces = (inputs.weight_mass * inputs.slow_speed**2 * inner_radius, inputs.weight_mass * inputs.fast_speed**2 * outer_radius)
    inner_abscissa = formulas.spring_abscissa(inner_force=forces[0], outer_force=forces[1], stroke=outer_radius - inner_radius)
    middle_abscissa = float(inner_abscissa) + inputs.half_stroke
    formula_angle = float(formulas.bell_crank_angle(weight_arm=inputs.weight_arm, middle_abscissa=middle_abscissa))
    angle = formula_angle if inputs.angle is None else inputs.angle
    layout = build_hartung_layout(inputs, angle, inputs.sleeve_arm)
    optimal_angle, spread = find_best_angle(inputs)
    sleeve_arm = layout.governor.sleeve_arm
    end_forces = layout.static_forces[[0, -1]]
    speeds = np.array([inputs.slow_speed, inputs.fast_speed])
    regulating_forces = np.asarray(formulas.regulating_force(static_force=end_forces, insensitivity=inputs.insensitivity))
    speed_limits = formulas.speed_limits(spindle_speed=speeds, regulating_force=regulating_forces, static_force=end_forces)
    spring = {"wire": inputs.wire, "coil": inputs.coil, "modulus": inputs.modulus, "rate": layout.spring_rate}
    stress = float(formulas.coil_stress(wire=inputs.wire, coil=inputs.coil, force=layout.spring_forces[-1]))
    turns = float(formulas.coil_turns(**spring))
    return HartungDesign(
        inputs=inputs,
        layout=layout,
        centrifugal_forces=forces,
        middle_abscissa=middle_abscissa,
        formula_angle=formula_angle,
        best_angle=optimal_angle,
        best_spread=spread,
        angle=angle,
        sleeve_arm=sleeve_arm,
        travel=float(formulas.sleeve_travel(sleeve_arm=sleeve_arm, angle=angle, swing=inputs.swing)),
        spring_rate=layout.spring_rate,
        preload=float(layout.spring_forces[0]),
        turns=turns,
        wire_length=float(formulas.wire_length(**spring)),
        stress=stress,
        regulating_forces=tuple(regulating_forces.tolist()),
        speed_limits=tuple(zip(*(np.asarray(limits).tolist() for limits in speed_limits), strict=True)),
        warnings=tuple(_warnings(inputs, stress, turns)),
    )


def _contradictions(inputs: HartungInputs) -> Iterator[str]:
    """Yield sentences about inputs that are not consistent."""
    if inputs.slow_speed >= inputs.fast_speed:
        text = "slow_speed ({slow_speed:.6g rpm}), at the inner end of the stroke, must be below fast_speed ({fast_speed:.6g rpm})"
        yield fill_places(f"{text}, at the outer end", inputs)
    if inputs.insensitivity >= 1:
        text = "insensitivity ({insensitivity:g}) must be below 1: it is a fraction of the static sleeve force; the paper's value is 0.04"
        yield fill_places(text, inputs)
    travel = inputs.weight_arm * math.sin(inputs.swing)
    if abs(inputs.half_stroke - travel) > HALF_STROKE_TOLERANCE_RATIO * travel:
        text = (
            "half_stroke ({half_stroke:.6g mm}) is not consistent with weight_arm ({weight_arm:.6g mm}) and swing ({swing:.6g deg}), which "
            "move a weight by {travel:.4g mm} to each side; give half_stroke={travel:.4g mm}, or change the others"
        )
        yield fill_places(text, inputs, travel=travel)
    if inputs.coil <= inputs.wire:
        yield fill_places("coil ({coil:.6g mm}) must exceed wire ({wire:.6g mm})", inputs)


def build_hartung_layout(
    inputs: HartungInputs,
    angle: float,  # angle of the bell crank, rad
    # sleeve arm of the bell crank, m; None: hangers symmetric about the axis
    sleeve_arm: float | None = None,
) -> HartungLayout:
    """Return the governor with a given bell crank and its forces over the stroke.

    Raises MechanismError if the lever would pass its change point, or springs cannot follow the line.
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
    inner = float(slow_forces[0])
    outer = float(fast_forces[-1])
    if not 0 < inner < outer:
        raise MechanismError(
            f"a weight needs a spring force of {inner:.4g} N at slow_speed and the inner end, and of {outer:.4g} N at fast_speed and the "
            "outer end; it must be positive and rise outward; increase rest_radius, weight_mass or the speeds, or reduce swing"
        )
    spring_rate = float(formulas.effective_spring_rate(inner_force=inner, outer_force=outer, stroke=float(radii[-1] - radii[0])))
    spring_forces = inner + spring_rate * (radii - radii[0])
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


def _warnings(inputs: HartungInputs, stress: float, turns: float) -> Iterator[str]:
    if stress > inputs.stress_limit:
        text = (
            "the springs are overstressed: {stress:.4g kgf/cm^2} at the outer end of the stroke, the limit is {stress_limit:.4g kgf/cm^2}; "
            "use a thicker wire or a smaller coil"
        )
        yield fill_places(text, inputs, stress=stress)
    if turns < MIN_COIL_TURNS:
        least = f"fewer than the {MIN_COIL_TURNS:g} of a useful coil"
        yield f"the springs have {turns:.3g} turns, {least}; use a thicker wire or a smaller coil"
