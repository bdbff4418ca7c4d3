"""A Hartung governor designed as Dubois does it: bell cranks, springs, their stress, the sleeve's force; a scene of it.

After Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), pp. 618-620; by the closed forms alone, and nothing is
rounded on the way. What the paper prints stands in `studies.dubois`.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from governor_mechanism.closed_form.hartung import design as formulas
from governor_mechanism.closed_form.hartung import governor as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import spoken

KGF = 9.81
"""N in a kilogram-force, as the paper reckons."""
AT = KGF * 1e4
"""Pa in one of them on a square centimetre."""
POINTS = 121
"""Of a curve over the stroke."""
APART = 0.05
"""Of the weights' way, which the paper rounds by 0.008: so far half_stroke may be from it."""
FEW = 3.0
"""Turns: with fewer a coil is hardly a spring."""
COARSE = math.radians(1.0)
"""rad between the angles among which the best one is looked for first."""


@dataclass(frozen=True, kw_only=True)
class HartungInputs:
    """What a design starts from, in SI; those left out are the paper's.

    swing is the lever's way from upright to each side, rest_radius the weights' radius at the inner end, half_stroke
    their radial way from there to upright. angle and sleeve_arm (of the bell crank) follow where they are left out.
    """

    weight_mass: float = 45.0
    sleeve_mass: float = 15.0
    weight_arm: float = 0.115
    rest_radius: float = 0.092
    half_stroke: float = 0.030
    fulcrum_height: float = -0.113
    swing: float = math.radians(15.0)
    slow_speed: float = 204 * math.pi / 30
    fast_speed: float = 212 * math.pi / 30
    wire: float = 0.012
    coil: float = 0.080
    modulus: float = 750_000 * AT
    stress_limit: float = 4500 * AT
    insensitivity: float = 0.04
    angle: float | None = None
    sleeve_arm: float | None = None

    @property
    def fulcrum_radius(self) -> float:
        """Of the fulcrum from the spindle axis (m)."""
        return self.rest_radius + self.half_stroke


PAPERS = HartungInputs()


@dataclass(frozen=True, kw_only=True)
class Layout:
    """A governor with springs along Doerfel's line, and what it comes to over the stroke, inner end first.

    levers (n,) rad and radii (n,) m of the weights; slow_forces and fast_forces (n,) N balance the slow and the fast
    speed, spring_forces are those of each spring; static_forces (n,) N hold down the sleeve at standstill.
    """

    governor: closed.HartungGovernor
    rate: float
    levers: FloatArray
    radii: FloatArray
    slow_forces: FloatArray
    fast_forces: FloatArray
    spring_forces: FloatArray
    static_forces: FloatArray

    @property
    def spread(self) -> float:
        """Largest less smallest static force, over their mean."""
        return closed.spread(self.static_forces)


@dataclass(frozen=True, kw_only=True)
class HartungDesign:
    """What comes of a design, in SI: lengths m, forces N, angles rad, stress Pa; warnings are sentences.

    angle and sleeve_arm are those of the bell crank taken, formula_angle what tan = -y0 / a asks for, best_angle what
    keeps the static sleeve force most even. regulating_forces and speed_limits (two speeds, rad/s) are at the inner and
    the outer end of the stroke.
    """

    inputs: HartungInputs
    layout: Layout
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
    regulating_forces: tuple[float, float]
    speed_limits: tuple[tuple[float, float], tuple[float, float]]
    warnings: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """The design in words, in the units of the drawing office."""
        layout, statics = self.layout, self.layout.static_forces / KGF
        limits = [[f"{speed * 30 / math.pi:.4g}" for speed in pair] for pair in self.speed_limits]
        held = [f"{force / KGF:.4g}" for force in self.regulating_forces]
        return [
            f"bell crank: {math.degrees(self.angle):.6g} deg, arms {self.inputs.weight_arm * 1e3:.6g} and "
            f"{self.sleeve_arm * 1e3:.6g} mm; tan = -y0 / a asks for {math.degrees(self.formula_angle):.6g} deg",
            f"springs: {self.spring_rate / KGF / 1e3:.5g} kgf/mm, {self.preload / KGF:.5g} kgf innermost; "
            f"{self.turns:.4g} turns of {self.wire_length:.4g} m wire, stressed to {self.stress / AT:.5g} kgf/cm^2",
            f"static sleeve force: {statics[0]:.5g} kgf inside, {statics[-1]:.5g} outside, changes by "
            f"{100 * layout.spread:.3g} %; the most even angle is {math.degrees(self.best_angle):.5g} deg, with "
            f"{100 * self.best_spread:.3g} %",
            f"regulating force: {held[0]} kgf inside, gives way at {' and '.join(limits[0])} rpm; {held[1]} kgf "
            f"outside, at {' and '.join(limits[1])} rpm",
            f"sleeve travel: {self.travel * 1e3:.5g} mm",
            *(f"warning: {sentence}" for sentence in self.warnings),
        ]

    def as_json(self) -> dict[str, Any]:
        """Everything as plain values, the curves as lists."""
        layout = self.layout
        numbers = {
            name: value
            for name, value in asdict(self).items()
            if name not in ("inputs", "layout") and value is not None
        }
        curves = {
            name: getattr(layout, name).tolist()
            for name in ("levers", "radii", "slow_forces", "fast_forces", "spring_forces", "static_forces")
        }
        return {"inputs": asdict(self.inputs), **numbers, "static_force_spread": layout.spread, "curves": curves}


def design_hartung(inputs: HartungInputs = PAPERS) -> HartungDesign:
    """The paper's way through a design. Raises MechanismError for inputs that no governor comes of."""
    _widest_angle(inputs)  # refuses a swing that is too wide
    if problems := _problems(inputs):
        raise MechanismError(*problems)
    first, last = inputs.rest_radius, inputs.rest_radius + 2 * inputs.half_stroke
    forces = (inputs.weight_mass * inputs.slow_speed**2 * first, inputs.weight_mass * inputs.fast_speed**2 * last)
    stroke = last - first
    rough = formulas.spring_abscissa(inner_force=forces[0], outer_force=forces[1], stroke=stroke)
    abscissa = float(rough) + inputs.half_stroke
    asked = float(formulas.crank_angle(weight_arm=inputs.weight_arm, middle_abscissa=abscissa))
    angle = asked if inputs.angle is None else inputs.angle
    layout = lay_out(inputs, angle, inputs.sleeve_arm)
    best, spread = best_angle(inputs)
    governor, ends = layout.governor, (0, -1)
    statics = [float(layout.static_forces[end]) for end in ends]
    held = [float(formulas.regulating_force(static_force=one, part=inputs.insensitivity)) for one in statics]
    limits = [
        _limits(speed, force, static)
        for speed, force, static in zip((inputs.slow_speed, inputs.fast_speed), held, statics, strict=True)
    ]
    coil = {"wire": inputs.wire, "coil": inputs.coil, "modulus": inputs.modulus}
    stress = float(formulas.coil_stress(wire=inputs.wire, coil=inputs.coil, force=layout.spring_forces[-1]))
    turns = float(formulas.coil_turns(**coil, rate=layout.rate))
    return HartungDesign(
        inputs=inputs,
        layout=layout,
        centrifugal_forces=forces,
        middle_abscissa=abscissa,
        formula_angle=asked,
        best_angle=best,
        best_spread=spread,
        angle=angle,
        sleeve_arm=governor.sleeve_arm,
        travel=float(formulas.sleeve_travel(sleeve_arm=governor.sleeve_arm, angle=angle, swing=inputs.swing)),
        spring_rate=layout.rate,
        preload=float(layout.spring_forces[0]),
        turns=turns,
        wire_length=float(formulas.wire_length(**coil, rate=layout.rate)),
        stress=stress,
        regulating_forces=(held[0], held[1]),
        speed_limits=(limits[0], limits[1]),
        warnings=_warnings(inputs, stress, turns),
    )


def lay_out(inputs: HartungInputs, angle: float, sleeve_arm: float | None = None) -> Layout:
    """A governor with a bell crank of this angle (rad); sleeve_arm (m) from hangers even about the axis if left out.

    Raises MechanismError where the lever would pass its dead centre, and where springs cannot follow the line.
    """
    if sleeve_arm is None:
        even = formulas.even_sleeve_arm(fulcrum_radius=inputs.fulcrum_radius, angle=angle, swing=inputs.swing)
        sleeve_arm = float(even)
    governor = closed.HartungGovernor(
        weight_arm=inputs.weight_arm,
        sleeve_arm=sleeve_arm,
        angle=angle,
        fulcrum_radius=inputs.fulcrum_radius,
        weight_mass=inputs.weight_mass,
        sleeve_mass=inputs.sleeve_mass,
        gravity=KGF,
    )
    levers = np.linspace(inputs.swing, -inputs.swing, POINTS)
    radii = np.asarray(closed.weight_radius(governor, lever_angle=levers))
    slow, fast = (
        np.asarray(closed.astatic_spring_force(governor, lever_angle=levers, spindle_speed=speed))
        for speed in (inputs.slow_speed, inputs.fast_speed)
    )
    if not 0 < slow[0] < fast[-1]:
        raise MechanismError(
            f"at slow_speed a weight at the inner end asks for a spring of {slow[0]:.4g} N, and at fast_speed one at "
            f"the outer end for {fast[-1]:.4g} N; springs press, and harder outside; enlarge rest_radius, weight_mass "
            "or the speeds, or lower swing"
        )
    rate = formulas.effective_rate(
        inner_force=float(slow[0]), outer_force=float(fast[-1]), stroke=float(radii[-1] - radii[0])
    )
    line = slow[0] + float(rate) * (radii - radii[0])
    return Layout(
        governor=governor,
        rate=float(rate),
        levers=levers,
        radii=radii,
        slow_forces=slow,
        fast_forces=fast,
        spring_forces=line,
        static_forces=np.asarray(closed.static_sleeve_force(governor, lever_angle=levers, spring_force=line)),
    )


def best_angle(inputs: HartungInputs = PAPERS) -> tuple[float, float]:
    """The angle (rad, from 90 deg on) that keeps the static sleeve force most even, and the spread it leaves."""

    def spread(angle: float) -> float:
        return lay_out(inputs, angle).spread

    last = _widest_angle(inputs)
    angles = np.arange(math.pi / 2, last, COARSE)
    coarse = float(angles[int(np.argmin([spread(float(angle)) for angle in angles]))])
    near = (max(coarse - COARSE, math.pi / 2), min(coarse + COARSE, last))
    # A spread has corners at its minimum: what is sure is the place, to the tolerance.
    found = minimize_scalar(spread, bounds=near, method="bounded", options={"xatol": 1e-8})
    return float(found.x), float(found.fun)


def _widest_angle(inputs: HartungInputs) -> float:
    """The widest angle (rad) of the bell crank that keeps its lever off the dead centre."""
    widest = math.pi - inputs.swing - COARSE
    if widest <= math.pi / 2:
        raise MechanismError(
            f"a swing of {math.degrees(inputs.swing):g} deg to each side leaves no angle of the bell crank from 90 deg "
            "on whose lever stays off its dead centre; it must be less than 89 deg"
        )
    return widest


def _problems(inputs: HartungInputs) -> list[str]:
    """Sentences about inputs that are no sizes, or that do not go together."""
    units = {"weight_mass": "kg", "sleeve_mass": "kg", "slow_speed": "rad/s", "fast_speed": "rad/s"}
    lengths = dict.fromkeys(("weight_arm", "rest_radius", "half_stroke", "wire", "coil", "sleeve_arm"), "m")
    others = {"modulus": "Pa", "stress_limit": "Pa", "insensitivity": "", "swing": "rad", "angle": "rad"}
    problems = [
        f"{name} must be positive; found {spoken(value, unit).strip()}"
        for name, unit in (units | lengths | others).items()
        if (value := getattr(inputs, name)) is not None and not value > 0
    ]
    if problems:
        return problems
    if inputs.slow_speed >= inputs.fast_speed:
        problems.append(
            f"slow_speed ({spoken(inputs.slow_speed, 'rad/s')}), at the inner end of the stroke, must be below "
            f"fast_speed ({spoken(inputs.fast_speed, 'rad/s')}), at the outer end"
        )
    if inputs.insensitivity >= 1:
        problems.append(
            f"insensitivity ({inputs.insensitivity:g}) must be below 1: it is a part of the static sleeve force; "
            "the paper's is 0.04"
        )
    way = inputs.weight_arm * math.sin(inputs.swing)
    if abs(inputs.half_stroke - way) > APART * way:
        problems.append(
            f"half_stroke ({spoken(inputs.half_stroke, 'm')}) does not go with weight_arm "
            f"({spoken(inputs.weight_arm, 'm')}) and swing ({spoken(inputs.swing, 'rad')}), which take a weight "
            f"{spoken(way, 'm', '.4g')} to each side; give half_stroke={spoken(way, 'm', '.4g')}, or change the others"
        )
    if inputs.coil <= inputs.wire:
        problems.append(f"coil ({spoken(inputs.coil, 'm')}) must be wider than wire ({spoken(inputs.wire, 'm')})")
    return problems


def _limits(speed: float, held: float, static: float) -> tuple[float, float]:
    low, high = formulas.speed_limits(spindle_speed=speed, regulating_force=held, static_force=static)
    return float(low), float(high)


def _warnings(inputs: HartungInputs, stress: float, turns: float) -> tuple[str, ...]:
    found = []
    if stress > inputs.stress_limit:
        found.append(
            f"the springs are stressed over their limit: {stress / AT:.4g} kgf/cm^2 at the outer end of the stroke, "
            f"allowed are {inputs.stress_limit / AT:.4g} kgf/cm^2; take a thicker wire or a narrower coil"
        )
    if turns < FEW:
        found.append(
            f"the springs have {turns:.3g} turns, and with fewer than {FEW:g} a coil is hardly one; take a "
            "thicker wire or a narrower coil"
        )
    return tuple(found)
