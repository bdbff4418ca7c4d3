"""Design of a Hartung governor after Dubois: bell cranks, springs and their stress, sleeve force.

It uses the closed forms only and does not round intermediate results. Each number of the paper is recomputed from what the paper states
just before it, so that an error is located where it was made.

References
----------
Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.closed_form import hartung_design as formulas
from governor_mechanism.model.results.result import format_columns
from governor_mechanism.studies.design.skeleton import (
    PRINTED_COLUMNS,
    Cause,
    Design,
    PrintedNumber,
    PrintedNumbers,
    printed_numbers,
    read_tables,
    refuse,
    require_valid,
    run_up_steps,
    select_deviations,
    sentences,
    sleeve_damping,
)
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM, TECHNICAL_ATMOSPHERE
from governor_mechanism.units.fields import optional, quantity
from governor_mechanism.units.text_table import in_unit

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

    weight_mass: float = quantity("mass", default=45.0, meaning="mass of a weight")
    sleeve_mass: float = quantity("mass", default=15.0, meaning="mass of the sleeve")
    weight_arm: float = quantity("length", default=0.115, meaning="arm of a bell crank to the weight")
    rest_radius: float = quantity("length", default=0.092, meaning="distance of the weights from the axis at the inner end")
    half_stroke: float = quantity("length", default=0.030, meaning="radial travel of the weights from the inner end to the vertical lever")
    fulcrum_height: float = quantity("length", default=-0.113, meaning="height of the fulcrum", sign="any")
    swing: float = quantity("angle", default=math.radians(15.0), meaning="angle of the lever from the vertical to each side")
    slow_speed: float = quantity("angular_speed", default=204 * RPM, meaning="speed at the inner end")
    fast_speed: float = quantity("angular_speed", default=212 * RPM, meaning="speed at the outer end")
    wire: float = quantity("length", default=0.012, meaning="diameter of the wire of a spring")
    coil: float = quantity("length", default=0.080, meaning="mean diameter of a coil")
    modulus: float = quantity("modulus", default=750_000 * TECHNICAL_ATMOSPHERE, meaning="modulus of shear of the wire")
    stress_limit: float = quantity("pressure", default=4500 * TECHNICAL_ATMOSPHERE, meaning="allowed shear stress of the wire")
    insensitivity: float = quantity("ratio", default=0.04, meaning="regulating force over the static sleeve force")
    angle: float | None = optional("angle", meaning="angle of the bell crank")
    sleeve_arm: float | None = optional("length", meaning="arm of the bell crank to the sleeve")

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
    """Result of a design in SI: lengths m, forces N, angles rad, stress Pa."""

    inputs: HartungInputs
    layout: HartungLayout  # the governor and its forces over the stroke
    # centrifugal force at the inner end and slow speed, and at the outer end and fast speed
    centrifugal_forces: tuple[float, float]
    middle_abscissa: float  # deflection y0 of the spring at mid stroke
    formula_angle: float  # angle of the bell crank by tan = -y0 / a
    best_angle: float  # angle with the smallest spread of the static sleeve force
    best_spread: float  # spread at that angle
    angle: float  # angle of the bell crank used
    sleeve_arm: float  # sleeve arm of the bell crank used
    travel: float  # travel of the sleeve
    spring_rate: float  # rate of each spring, N/m
    preload: float  # force of each spring at the inner end
    turns: float  # number of turns of the spring
    wire_length: float  # length of the spring wire
    stress: float  # shear stress of the spring at the outer end
    regulating_forces: tuple[float, ...]  # regulating force at the inner and the outer end
    # lower and upper speed (rad/s) at which the sleeve moves, at the inner and the outer end
    speed_limits: tuple[tuple[float, ...], ...]
    warnings: tuple[str, ...] = ()  # warnings, one sentence each

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


def design_hartung(inputs: HartungInputs = PAPER_INPUTS) -> HartungDesign:
    """Design a Hartung governor by the procedure of the paper; raise MechanismError if no governor can be built from the inputs."""
    _max_bell_crank_angle(inputs)  # raises for a swing that is too large
    require_valid("hartung", inputs, _contradictions)
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
    unsound = {"stress": stress > inputs.stress_limit, "turns": turns < MIN_COIL_TURNS}
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
        warnings=tuple(sentences("hartung", inputs, unsound, stress=stress, turns=turns, least=MIN_COIL_TURNS)),
    )


def _contradictions(inputs: HartungInputs) -> list[str]:
    """Return sentences about inputs that are not consistent."""
    travel = inputs.weight_arm * math.sin(inputs.swing)
    cases = {
        "speeds": inputs.slow_speed >= inputs.fast_speed,
        "insensitivity": inputs.insensitivity >= 1,
        "half_stroke": abs(inputs.half_stroke - travel) > HALF_STROKE_TOLERANCE_RATIO * travel,
        "coil": inputs.coil <= inputs.wire,
    }
    return sentences("hartung", inputs, cases, travel=travel)


def build_hartung_layout(inputs: HartungInputs, angle: float, sleeve_arm: float | None = None) -> HartungLayout:
    """Return the governor with bell cranks of an angle (rad), hangers symmetric unless a sleeve arm (m) is given, and its forces."""
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
    refuse("hartung", inputs, {"spring_force": not 0 < inner < outer}, inner=inner, outer=outer)
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
    refuse("hartung", inputs, {"swing": max_angle <= math.pi / 2})
    return max_angle


PAPER_SPEEDS = (21.363, 22.201)
"""204 and 212 rpm as the paper rounds them (rad/s)."""

PAPER_ANGLES = (math.radians(15), math.radians(-15))
"""Angles of the lever at the inner and the outer end, rad."""

SLIDE_RULE_TOLERANCE = 1.0
"""Tolerance of the table (kgf); the errors of the slide rule are within 0.66, the misprint is larger."""

WRONG_DIGIT = (Cause.MISPRINT, "not on the curve of its neighbours; one digit wrong, 189.8 is meant")
"""The misprint of the table."""

PAPER_GOVERNOR = PAPER_INPUTS.governor(angle=math.radians(132), sleeve_arm=0.170)
"""The governor of the paper's calculations, with bell cranks of 132 deg."""

PRINTED_SPRING_FORCES: Sequence[Sequence[float]] = read_tables("hartung")["spring_forces"]
"""Table 2 of the paper: radius (mm), and the astatic spring force (kgf) at each of the two speeds."""

COUNTER_EXAMPLE_FORCES = (189.0, 262.0, 335.0)
"""Static sleeve force (kgf) at low, middle and high position of Pohlhausen's no. 97, a Hartung governor with right angles."""


@dataclass(frozen=True, kw_only=True)
class PaperComparison(PrintedNumbers):
    """The paper's numbers in order, its table of spring forces and the governor of its counter-example (forces in kgf)."""

    table: tuple[PrintedNumber, ...]
    counter_example: tuple[PrintedNumber, ...]

    def __str__(self) -> str:
        """Return a table of the numbers, with the causes of the differences."""
        deviating = select_deviations(self.table)
        numbers = format_columns(PRINTED_COLUMNS, (*self.numbers, *deviating, *self.counter_example))
        agreement = f"table 2: {len(self.table) - len(deviating)} of {len(self.table)} spring forces agree with their formula"
        return f"{numbers}\n{agreement}\nproofs, and formulas that are not right: governor-mechanism errata --paper dubois"


def compare_with_paper() -> PaperComparison:
    """Return all numbers of the paper, recomputed."""
    kinematics = {
        "sagitta": 115 * (1 - math.cos(math.radians(15))),
        "radii": [1e3 * float(closed.weight_radius(PAPER_GOVERNOR, lever_angle=angle)) for angle in PAPER_ANGLES],
        "squares": [speed**2 for speed in PAPER_SPEEDS],
    }
    counter_example = [float(formulas.regulating_force(static_force=force)) for force in COUNTER_EXAMPLE_FORCES]
    return PaperComparison(
        numbers=printed_numbers("hartung", "numbers", **kinematics, **_spring_values(), **_sleeve_forces()),
        table=tuple(_spring_force_table()),
        counter_example=printed_numbers("hartung", "counter_example", forces=counter_example, change=100 * (13.4 - 7.5) / 10.5),
    )


def _spring_values() -> dict[str, float]:
    """Return the numbers of centrifugal forces, bell crank and spring, recomputed."""
    mass = 45 / KILOGRAM_FORCE_1853
    angle = float(formulas.bell_crank_angle(weight_arm=115.0, middle_abscissa=106.0))
    return {
        "mass": mass,
        "slow_force": mass * PAPER_SPEEDS[0] ** 2 * 0.092,
        "fast_force": mass * PAPER_SPEEDS[1] ** 2 * 0.152,
        "abscissa": float(formulas.spring_abscissa(inner_force=192.0, outer_force=344.0, stroke=60.0)),
        "tangent": math.tan(angle),
        "angle": math.degrees(angle),
        "arm": float(formulas.symmetric_sleeve_arm(fulcrum_radius=122.0, angle=math.radians(132), swing=math.radians(15))),
        "rise": 345.8 - 173.8,
        "polar_moment": 1e8 * float(formulas.polar_moment(wire=PAPER_INPUTS.wire)),
        "wire_length": 6 * 0.2036 * 750_000 / (172 * 4**2),
        "turns": 332 / (math.pi * 8),
        "section_modulus": 1e6 * float(formulas.section_modulus(wire=PAPER_INPUTS.wire)),
        "stress": 346 * 4 / 0.338,
    }


def _sleeve_forces() -> dict[str, object]:
    """Return the forces at the sleeve (kgf) at the inner and the outer end, recomputed."""
    static_force = closed.static_sleeve_force
    static = [
        float(static_force(PAPER_GOVERNOR, lever_angle=angle, spring_force=force * KILOGRAM_FORCE_1853)) / KILOGRAM_FORCE_1853
        for angle, force in zip(PAPER_ANGLES, (173.8, 345.8), strict=True)
    ]
    low, high = (float(formulas.regulating_force(static_force=force)) for force in static)
    return {"static": static, "regulating": (low, high), "regulating_change": 100 * (high - low) / (0.5 * (low + high))}


def _spring_force_table() -> Iterator[PrintedNumber]:
    """Yield the forces of table 2 beside those of their formula."""
    for radius, *printed in PRINTED_SPRING_FORCES:
        lever_angle = math.asin((122 - radius) / 115)
        for rpm, speed, force in zip((204, 212), PAPER_SPEEDS, printed, strict=True):
            found = in_unit(float(closed.astatic_spring_force(PAPER_GOVERNOR, lever_angle=lever_angle, spindle_speed=speed)), "kgf")
            mark = WRONG_DIGIT if abs(force - found) > SLIDE_RULE_TOLERANCE else ()
            yield PrintedNumber(f"spring force at {radius:g} mm, {rpm} rpm", "kgf", force, found, *mark)
