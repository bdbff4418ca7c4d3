"""Design of a flywheel after Redtenbacher: energy between the extreme speeds, inertia, rim and arms; or the fluctuation of a given wheel.

It uses the closed forms only and does not round intermediate results. The printed numbers of the paper are in `paper_comparison`.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array
from governor_mechanism.closed_form.flywheel import wheel as formulas
from governor_mechanism.closed_form.flywheel.engine import AirEngine, closing_area_ratio, gas_torque, net_work
from governor_mechanism.closed_form.flywheel.equilibrium import Equilibrium, Fluctuation, energy_fluctuation, find_equilibria
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.studies.flywheel.inputs import DEFAULT_ENERGY_RATIO, PAPER_INPUTS, FlywheelInputs, closed_cycle, validate_inputs
from governor_mechanism.units.short_repr import short_repr

GRAVITY = 9.81
"""Gravity for the weight of the rim, m/s2; the paper's 9.808 enters none of its numbers."""

HORSEPOWER = 75 * GRAVITY
"""One horsepower of the paper, 75 kgf m/s, in W."""

CLOSED_CYCLE_TOLERANCE = 1e-9
"""Work that a closed cycle may gain in a stroke, relative to A p L: well above rounding."""

N_TORQUE_POINTS = 2001
"""Points of a stroke at which the largest torque on the arms is sought; its error is of the square of their distance, 1e-6."""


@dataclass(frozen=True, kw_only=True)
class Wheel:
    """Rim and arms of a flywheel, SI.

    rim_weight is in N; rim_stress is the hoop stress of the free rim; arm_torque is the largest torque between rim and hub, arm_moment the
    bending moment of an arm at the hub, arm_depth and arm_width the axes of its elliptical section there.
    """

    rim_mass: float
    rim_weight: float
    rim_speed: float
    rim_stress: float
    rim_thickness: float
    rim_width: float
    arm_torque: float
    arm_moment: float
    arm_depth: float
    arm_width: float


@dataclass(frozen=True, kw_only=True)
class FlywheelDesign(PrintedResult):
    """Result of a design in SI: angles rad, work J, speeds rad/s.

    Attributes
    ----------
    inputs
        The inputs.
    engine
        The engine under its load.
    interval_limits
        Crank angles at which the laws of the pressures change.
    equilibria
        All equilibria of air and load in a stroke.
    fluctuation
        Angles of lowest and highest speed, and the work stored between them.
    bracket
        That work over A p L: the paper's bracket B.
    net_work
        Work that the shaft gains in a stroke; 0 if the cycle closes.
    closing_load_pressure
        Load pressure with which the cycle closes, Pa.
    closing_area_ratio
        Ratio of pump and piston area with which it closes; None if there is none.
    power
        Power of the load at mean speed, W.
    inertia
        Moment of inertia of the flywheel, kg m2.
    energy_ratio
        Ratio mu of the mean kinetic energy to the work stored.
    coefficient
        Coefficient of speed fluctuation, (highest - lowest) / mean speed.
    lowest_speed
        Lowest speed in a stroke.
    highest_speed
        Highest speed in a stroke.
    closed_coefficient
        The coefficient of this flywheel if the load is that with which the cycle closes.
    wheel
        Rim and arms.
    warnings
        Warnings, one sentence each.
    """

    inputs: FlywheelInputs
    engine: AirEngine
    interval_limits: tuple[float, float, float]
    equilibria: tuple[Equilibrium, ...]
    fluctuation: Fluctuation
    bracket: float
    net_work: float
    closing_load_pressure: float
    closing_area_ratio: float | None
    power: float
    inertia: float
    energy_ratio: float
    coefficient: float
    lowest_speed: float
    highest_speed: float
    closed_coefficient: float
    wheel: Wheel
    warnings: tuple[str, ...] = ()

    __repr__ = short_repr

    def summary_lines(self) -> list[str]:
        """Return the design as text."""
        extremes, wheel = self.fluctuation, self.wheel
        slowest, fastest = (f"{math.degrees(angle):.6g} deg" for angle in (extremes.slowest_angle, extremes.fastest_angle))
        limits = ", ".join(f"{math.degrees(angle):.6g}" for angle in self.interval_limits)
        return [
            f"engine: A p L = {self.engine.full_pressure_work:.6g} J; load {self.engine.load_torque:.6g} N m, "
            f"{self.power / 1e3:.5g} kW ({self.power / HORSEPOWER:.4g} PS); intervals end at {limits} deg",
            f"lowest speed at {slowest}, highest at {fastest}; between them the flywheel stores {extremes.energy:.6g} J, "
            f"{self.bracket:.10g} of A p L",
            f"flywheel: inertia {self.inertia:.6g} kg m2; mu = {self.energy_ratio:.6g}; speed from {self.lowest_speed:.6g} to "
            f"{self.highest_speed:.6g} rad/s, coefficient of speed fluctuation {self.coefficient:.6g}",
            f"rim: {wheel.rim_mass:.5g} kg at {self.inputs.rim_radius:.4g} m, section {1e3 * wheel.rim_thickness:.4g} x "
            f"{1e3 * wheel.rim_width:.4g} mm, {wheel.rim_speed:.4g} m/s, hoop stress {wheel.rim_stress / 1e6:.3g} MPa",
            f"arms: {self.inputs.arms:g} of {1e3 * wheel.arm_depth:.4g} x {1e3 * wheel.arm_width:.4g} mm at the hub, bent by "
            f"{wheel.arm_moment:.4g} N m each",
            *(f"warning: {sentence}" for sentence in self.warnings),
        ]

    def __str__(self) -> str:
        """Return the design as text."""
        return "\n".join(self.summary_lines())

    def as_json(self) -> dict[str, Any]:
        """Return the design as plain values."""
        return plain_record(self)


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_flywheel(inputs: FlywheelInputs = PAPER_INPUTS) -> FlywheelDesign:
    """Design a flywheel by the procedure of the paper, or find the fluctuation of a given one.

    Parameters
    ----------
    inputs
        The inputs; by default the paper's.

    Returns
    -------
    FlywheelDesign
        The design.

    Raises
    ------
    MechanismError
        If the inputs are not valid, or the engine cannot carry its load.
    """
    validate_inputs(inputs)
    engine = inputs.engine()
    extremes = energy_fluctuation(engine)
    closed = closed_cycle(engine)
    inertia, has_mean_energy = _inertia(inputs, extremes.energy)

    def limits(energy: float) -> tuple[float, float]:
        low, high = formulas.speed_limits(inertia=inertia, energy=energy, mean_speed=inputs.speed, mean_energy=has_mean_energy)
        return float(low), float(high)

    lowest, highest = limits(extremes.energy)
    closed_lowest, closed_highest = limits(energy_fluctuation(closed).energy)
    wheel = _wheel(inputs, engine, inertia)
    closed_coefficient = (closed_highest - closed_lowest) / inputs.speed
    return FlywheelDesign(
        inputs=inputs,
        engine=engine,
        interval_limits=engine.interval_limits,
        equilibria=find_equilibria(engine),
        fluctuation=extremes,
        bracket=extremes.energy / engine.full_pressure_work,
        net_work=net_work(engine),
        closing_load_pressure=closed.load_pressure,
        closing_area_ratio=_closing_area_ratio(engine),
        power=engine.load_torque * inputs.speed,
        inertia=inertia,
        energy_ratio=float(formulas.energy_ratio_of_speeds(inertia=inertia, energy=extremes.energy, lowest=lowest, highest=highest)),
        coefficient=(highest - lowest) / inputs.speed,
        lowest_speed=lowest,
        highest_speed=highest,
        closed_coefficient=closed_coefficient,
        wheel=wheel,
        warnings=_warnings(inputs, engine, closed, wheel, closed_coefficient),
    )


def _inertia(inputs: FlywheelInputs, energy: float) -> tuple[float, bool]:
    """Return the inertia (kg m2), and whether the mean speed is the paper's rather than the arithmetic mean."""
    if inputs.inertia is not None:
        return inputs.inertia, False
    if inputs.coefficient is not None:
        required = formulas.inertia_for_coefficient(energy=energy, mean_speed=inputs.speed, coefficient=inputs.coefficient)
        return float(required), False
    ratio = DEFAULT_ENERGY_RATIO if inputs.energy_ratio is None else inputs.energy_ratio
    return float(formulas.inertia_for_energy_ratio(energy=energy, mean_speed=inputs.speed, energy_ratio=ratio)), True


def _closing_area_ratio(engine: AirEngine) -> float | None:
    try:
        return closing_area_ratio(engine)
    except MechanismError:
        return None


def _wheel(inputs: FlywheelInputs, engine: AirEngine, inertia: float) -> Wheel:
    """Return rim and arms."""
    mass = float(formulas.rim_mass(inertia=inputs.rim_share * inertia, radius=inputs.rim_radius))
    rim_speed = inputs.speed * inputs.rim_radius
    section = {"mass": mass, "radius": inputs.rim_radius, "density": inputs.density, "width_ratio": inputs.width_ratio}
    thickness = float(formulas.rim_thickness(**section))
    torques = np.asarray(gas_torque(engine, crank_angle=np.linspace(0.0, math.pi, N_TORQUE_POINTS))) - engine.load_torque
    torque = float(np.max(np.abs(torques)))
    moment = float(formulas.arm_bending_moment(torque=torque, radius=inputs.rim_radius, hub_radius=inputs.hub_radius, arms=inputs.arms))
    depth = float(formulas.arm_major_axis(bending_moment=moment, stress=inputs.arm_stress))
    return Wheel(
        rim_mass=mass,
        rim_weight=float(as_scalar_or_array(mass * GRAVITY)),
        rim_speed=rim_speed,
        rim_stress=float(formulas.rim_stress(density=inputs.density, rim_speed=rim_speed)),
        rim_thickness=thickness,
        rim_width=inputs.width_ratio * thickness,
        arm_torque=torque,
        arm_moment=moment,
        arm_depth=depth,
        arm_width=depth / 2,
    )


def _warnings(inputs: FlywheelInputs, engine: AirEngine, closed: AirEngine, wheel: Wheel, closed_coefficient: float) -> tuple[str, ...]:
    warnings = []
    gained = net_work(engine) / engine.full_pressure_work
    if abs(gained) > CLOSED_CYCLE_TOLERANCE:
        verb = "gains" if gained > 0 else "loses"
        warnings.append(
            f"the cycle does not close: in each stroke the shaft {verb} {abs(gained):.4g} of A p L; it closes with "
            f"load_pressure={closed.load_pressure / 1e5:.8g} bar, where this flywheel has a coefficient of {closed_coefficient:.5g}"
        )
    if wheel.rim_stress > inputs.rim_stress:
        slowest = math.sqrt(inputs.rim_stress / inputs.density)
        warnings.append(
            f"the rim is overstressed: {wheel.rim_stress / 1e6:.3g} MPa, and the limit is {inputs.rim_stress / 1e6:.3g} MPa, at "
            f"{slowest:.3g} m/s; reduce rim_radius to {slowest / inputs.speed:.3g} m"
        )
    if wheel.rim_thickness >= 2 * (inputs.rim_radius - inputs.hub_radius):
        warnings.append("the rim reaches the hub; increase rim_radius")
    return tuple(warnings)
