"""Dimensions of an engine with a flywheel, and what contradicts them."""

from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.machines.base import Machine, values_of
from governor_mechanism.machines.slide_valve import rod_field
from governor_mechanism.model.time_functions import InputFunction, TableFunction
from governor_mechanism.units.fields import entry, optional, quantity

AT_DEAD_CENTRE, WITHIN_STROKE = "at dead centre", "within stroke"
CYCLIC, MEAN = "cyclic", "mean"
MEAN_CUT_OFF_REASON = 'gas_torque = "mean" takes a constant one; leave gas_torque out, or let a throttle move'
"""Why a cut-off cannot move where the torque of the gas is averaged, and the cure."""
PUMP_DIMENSIONS = ("pump_area", "pump_stroke", "pump_clearance", "pump_connecting_rod")


@dataclass(frozen=True, kw_only=True)
class FlywheelEngineDimensions(Machine):
    """Dimensions of the engine in SI.

    Attributes
    ----------
    area
        Area of the expansion piston, m2.
    stroke
        Its stroke, m.
    connecting_rod
        Length of its connecting rod, m; None if infinite.
    cut_off
        Travel at which the supply is cut off, relative to the stroke, 0 to 1, or over time and readings.
    cut_off_read
        When a cut-off that follows a reading takes its value: "at dead centre", for the whole stroke, or "within stroke", at once.
    clearance
        Clearance of the expansion cylinder, relative to the volume of its stroke.
    pump_area
        Area of the pump piston, m2; None without a pump.
    pump_stroke
        Its stroke, m; that of the expansion piston if None.
    pump_connecting_rod
        Length of its connecting rod, m; None if infinite.
    pump_clearance
        Clearance of the pump, relative to the volume of its stroke.
    supply_pressure
        Absolute pressure of the supply, at which the pump delivers, Pa.
    back_pressure
        Absolute pressure behind the expansion piston, Pa.
    throttle
        Opening of a throttle, 0 to 1, or over time and readings: the pressure of admission is back_pressure + throttle * (supply_pressure -
        back_pressure). The pump delivers at supply_pressure. None without a throttle.
    atmospheric_pressure
        Absolute pressure at which the pump takes in air, Pa.
    inertia
        Moment of inertia of shaft and flywheel, kg m2; None if rim_mass gives it.
    rim_mass
        Mass of the rim of the flywheel, kg.
    rim_radius
        Mean radius of the rim, m; without rim_mass it only sets the size of the drawing.
    gas_torque
        Whether the gas acts with its pressure at every crank angle, "cyclic", or with its torque averaged over a turn, "mean".
    load_pressure
        Mean useful pressure of a constant load torque, referred to the expansion piston, Pa; None for that with which the cycle closes.
    load_torque
        Torque of the load, N m, in place of load_pressure.
    load_damping
        Torque of the load over the speed of the shaft, N m s/rad, in place of or beside load_torque.
    """

    area: float = quantity("area", meaning="of the expansion piston")
    stroke: float = quantity("length", meaning="of the expansion piston: twice its crank")
    connecting_rod: float | None = rod_field(meaning="of the connecting rod of the expansion piston; endless if left out")
    cut_off: float | InputFunction = entry("number or load", "ratio", sign="any", meaning="of the stroke at which the supply is cut off")
    cut_off_read: str = entry(
        "choice",
        words=(AT_DEAD_CENTRE, WITHIN_STROKE),
        default=AT_DEAD_CENTRE,
        meaning="when a cut-off that follows a reading takes its value",
    )
    clearance: float = quantity("ratio", sign="any", meaning="of the clearance to the volume of the stroke")
    pump_area: float | None = optional("area", words=("none",), meaning="of the pump piston; no pump if left out")
    pump_stroke: float | None = optional("length", meaning="of the pump piston; that of the expansion piston if left out")
    pump_connecting_rod: float | None = rod_field(meaning="of the connecting rod of the pump; endless if left out")
    pump_clearance: float | None = optional("ratio", sign="any", meaning="of the clearance of the pump to the volume of its stroke")
    supply_pressure: float = quantity("pressure", sign="any", meaning="of the supply, absolute")
    back_pressure: float = quantity("pressure", sign="any", meaning="behind the expansion piston, absolute")
    throttle: float | InputFunction | None = entry(
        "number or load",
        "ratio",
        sign="any",
        default=None,
        meaning="of the opening of a throttle before the expansion cylinder; none if left out",
    )
    atmospheric_pressure: float = quantity("pressure", default=1e5, meaning="at which the pump takes in air, absolute")
    inertia: float | None = optional("moment_of_inertia", meaning="of shaft and flywheel")
    rim_mass: float | None = optional("mass", meaning="of the rim of the flywheel, in place of inertia")
    rim_radius: float | None = optional("length", meaning="from the shaft to the middle of the rim")
    gas_torque: str = entry(
        "choice",
        words=(CYCLIC, MEAN),
        default=CYCLIC,
        meaning="whether the torque of the gas follows its pressure, or is averaged over a turn",
    )
    load_pressure: float | None = optional("pressure", sign="any", words=("closing",), meaning="of the load; closing if left out")
    load_torque: float | InputFunction | None = entry(
        "number or load", "torque", sign="any", default=None, meaning="of the load, in place of load_pressure"
    )
    load_damping: float | None = optional("torsion_damping", meaning="of a load that grows with the speed of the shaft")

    def dimension_problems(self) -> list[str]:
        """Return sentences about cylinders, pressures, wheel and load."""
        problems = [*self._cylinder_problems(), *self._pump_problems(), *self._wheel_problems(), *self._load_problems()]
        # Valves can only be judged for possible pressures.
        return problems or [*self._valve_problems(), *self._mean_torque_problems()]

    def _cylinder_problems(self) -> Iterator[str]:
        """Yield sentences about cut-off, clearance, pressures and rods."""
        cut_offs = _values_of_control(self.cut_off)
        outside = [value for value in cut_offs if not 0 <= value <= 1]
        if outside:
            yield f"cut_off must lie between 0 and 1, the end of the stroke; got {outside[0]:.6g}"
        if self.clearance < 0:
            yield f"clearance must not be negative; got {self.clearance:.6g}"
        elif self.clearance == 0 and 0 in cut_offs:
            yield (
                "clearance and cut_off are both 0: the gas would expand from no volume, where its pressure is infinite; "
                "give a small clearance, such as 0.02"
            )
        if self.throttle is not None and not all(0 <= value <= 1 for value in _values_of_control(self.throttle)):
            yield "throttle must lie between 0, closed, and 1, open, at all times and readings"
        for name in ("supply_pressure", "back_pressure"):
            if getattr(self, name) < 0:
                yield f"{name} ({getattr(self, name):.6g} Pa) is negative; it is an absolute pressure, 0 in a vacuum"
        if self.supply_pressure < self.atmospheric_pressure:
            yield (
                f"supply_pressure ({self.supply_pressure:.6g} Pa) is below the atmosphere ({self.atmospheric_pressure:.6g} Pa); "
                "it is an absolute pressure: add that of the atmosphere to the reading of a gauge"
            )
        for rod, stroke in (("connecting_rod", self.stroke), ("pump_connecting_rod", self.pump_stroke or self.stroke)):
            length = getattr(self, rod)
            if length is not None and not length > 0.5 * stroke:
                crank = f"{0.5e3 * stroke:.6g} mm"
                yield f"{rod} ({length * 1e3:.6g} mm) must be longer than its crank ({crank}), or it cannot turn over; make it longer"

    def _pump_problems(self) -> Iterator[str]:
        """Yield sentences about a pump that is incomplete or has no clearance."""
        if self.pump_area is None:
            given = [name for name in PUMP_DIMENSIONS[1:] if getattr(self, name) is not None]
            if given:
                yield f"{' and '.join(given)} belong to a pump; give pump_area, or leave {'them' if given[1:] else 'it'} out"
        elif self.pump_clearance is None:
            yield "pump_clearance is missing; it is the clearance of the pump over the volume of its stroke, as 0.05"
        elif self.pump_clearance <= 0:
            yield (
                f"pump_clearance must be above 0; got {self.pump_clearance:.6g}: the air left in the pump would expand from no volume, "
                "where its pressure is infinite; give a small clearance, such as 0.02"
            )

    def _wheel_problems(self) -> Iterator[str]:
        """Yield a sentence about a moment of inertia that is missing or given twice."""
        if (self.inertia is None) == (self.rim_mass is None):
            found = "both are given" if self.inertia is not None else "both are missing"
            yield f'the flywheel has inertia, as "3000 kg m^2", or rim_mass and rim_radius; {found}'
        elif self.rim_mass is not None and self.rim_radius is None:
            yield "rim_mass needs rim_radius, the mean radius of the rim"

    def _load_problems(self) -> Iterator[str]:
        """Yield sentences about a load that is given twice or drives."""
        others = [name for name in ("load_torque", "load_damping") if getattr(self, name) is not None]
        if self.load_pressure is not None and others:
            yield f"load_pressure and {' and '.join(others)} are both given; give one of them"
        if self.load_pressure is not None and self.load_pressure < 0:
            yield f"load_pressure ({self.load_pressure:.6g} Pa) is negative; the load resists"

    def _valve_problems(self) -> Iterator[str]:
        """Yield a sentence about a pump whose valves never open."""
        if self.pump_clearance is None:
            return
        excess = self.supply_pressure / self.atmospheric_pressure - 1
        if self.pump_clearance * excess >= 1:
            yield (
                f"pump_clearance must be below {1 / excess:.6g} at these pressures, or the valves of the pump never open; "
                f"got {self.pump_clearance:.6g}"
            )

    def _mean_torque_problems(self) -> Iterator[str]:
        """Yield sentences about what an average over a turn cannot show."""
        if self.gas_torque != MEAN:
            return
        if isinstance(self.cut_off, InputFunction) and not self.cut_off.is_constant:
            yield f"the cut-off moves, and {MEAN_CUT_OFF_REASON}"
        if self.throttle is not None and not self.supply_pressure > self.back_pressure:
            yield "the throttle has no effect, because supply_pressure is not above back_pressure; leave throttle out"


def _values_of_control(control: float | InputFunction) -> list[float]:
    """Return the values of a throttle or cut-off over time, or those of the tables of readings that it follows."""
    if not isinstance(control, InputFunction) or not control.functions:
        return [*values_of(control), *(control.range_in_time if isinstance(control, InputFunction) else ())]
    return [value for function in control.functions if isinstance(function, TableFunction) for value in function.values]
