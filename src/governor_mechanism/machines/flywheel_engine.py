"""Engine with expansion cylinder, pump and flywheel on one shaft.

Both cylinders are double acting and in phase. They stand below the shaft: the crank angle is measured anticlockwise from the dead centre at
which the pistons are nearest to it, and their travel counts downward from there. The gas keeps its temperature. Without masses the
reciprocating parts are no bodies: the gas acts on the crank through the travel of the piston. After F. Redtenbacher, Die
Luftexpansions-Maschine (1853), theory of the flywheel.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from governor_mechanism.effects.gas_pressure import work_per_stroke
from governor_mechanism.effects.masses import PistonMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, values_of
from governor_mechanism.machines.slide_valve import rod_field
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import CylinderGas, ForceElement, MeanGasTorque, Torque, TorsionDamper
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, FixedLoad, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import (
    AppliedTorque,
    BodyAngle,
    ControlledValue,
    CylinderPressure,
    DerivedReading,
    FollowerHeight,
    PointCoordinate,
    Reading,
    ShaftSpeed,
    StallLimit,
    StoredWork,
)
from governor_mechanism.model.part import FIXED_PLANE
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


FLYWHEEL = "flywheel"
SHAFT = "shaft"
LOAD = "load"
THROTTLE, EXPANSION, MEAN_GAS = "throttle", "expansion", "gas"
CRANK_ANGLE = BodyAngle(name="crank_angle", quantity="angle", body=FLYWHEEL)

MakeGas = Callable[..., CylinderGas]
"""Makes the gas on one face of a piston from its name, body, travel, crank angle and stroke."""

CLOSED_CYCLE_TOLERANCE = 1e-9
"""Work that a closed cycle may gain in a stroke, relative to that of the supply pressure over it: well above rounding."""

STALL_MESSAGE = "the shaft stalls: the load and the gas take more work than the flywheel has stored; reduce the load, or start it faster"


@dataclass(frozen=True, kw_only=True)
class FlywheelEngine(FlywheelEngineDimensions):
    """Engine with expansion cylinder, pump and flywheel."""

    name: ClassVar[str] = "flywheel_engine"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "crank_angle": "angle of the shaft from the dead centre where the piston_travel is 0, continuous over full turns",
        "piston_travel": "travel of the piston",
        "pump_piston_travel": "travel of the pump piston",
        "shaft_speed": "speed of the shaft",
        "gas_torque": "torque of the gas on the shaft",
        "load_torque": "torque of the load, positive against the motion",
        "expansion_pressure": "absolute pressure of the working gas on the driving face of the expansion piston",
        "suction_pressure": "absolute pressure on the suction face of the pump",
        "delivery_pressure": "absolute pressure on the delivery face of the pump",
        "throttle_opening": "opening of the throttle, 0 to 1",
        "cut_off": "travel at which the admission ends, relative to the stroke",
        "stored_work": "kinetic energy of the engine less that at the start",
    }
    plane: ClassVar[str] = FIXED_PLANE
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (PistonMasses,)
    default_start: ClassVar[float] = 0.0  # crank angle, rad

    @property
    def wheel_inertia(self) -> float:
        """Moment of inertia of shaft and flywheel, kg m2."""
        return self.inertia or (self.rim_mass or 0.0) * (self.rim_radius or 0.0) ** 2

    def mechanism(self, masses: PistonMasses | None = None) -> Mechanism:
        """Build flywheel and load, and pistons and rods that have mass. Raise MechanismError for a load that closes no cycle."""
        drives = tuple(self._drives(masses))
        gases = tuple(gas for drive in drives for gas in drive.gases())
        bodies = [(self._wheel(), (0.0, 0.0, 0.0)), *(body for drive in drives for body in drive.bodies())]
        ground, on_wheel = Point(body=GROUND), Point(body=FLYWHEEL)
        return Mechanism(
            bodies=tuple(body for body, _ in bodies),
            joints=(Pin(name=SHAFT, first=ground, second=on_wheel), *(joint for drive in drives for joint in drive.joints())),
            readings=(CRANK_ANGLE, *(drive.travel for drive in drives)),
            coordinate=CRANK_ANGLE.name,
            length_scale=0.5 * self.stroke,
            initial_guess=tuple(pose for _, pose in bodies),
            stall_limits=(StallLimit(reading=CRANK_ANGLE.name, body=FLYWHEEL, message=STALL_MESSAGE),),
            force_elements=(*self._loads(gases), *(self._mean_torques(gases) if self.gas_torque == MEAN else gases)),
            derived_readings=tuple(self._derived_readings(gases)),
            fixed_loads=(FixedLoad(name="cut_off", reason=MEAN_CUT_OFF_REASON),) if self.gas_torque == MEAN else (),
            notes=tuple(self._cycle_notes(gases)),
        )

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI; without a load_torque, load_pressure is that of the load, also where it closes the cycle."""
        values = super().dimensions() | {"inertia": self.wheel_inertia, "pump_stroke": self.pump_stroke or self.stroke}
        loads = self.mechanism().force_elements
        constant = next((element.moment.values[0] for element in loads if isinstance(element, Torque)), 0.0)
        return values | {"load_pressure": constant * math.pi / (self.area * self.stroke)}

    def _wheel(self) -> Body:
        """Return the flywheel; a given inertia is taken as that of a rim at the rim radius, or at the crank radius."""
        inertia = self.wheel_inertia
        mass = self.rim_mass or inertia / (self.rim_radius or 0.5 * self.stroke) ** 2
        return Body(name=FLYWHEEL, mass=mass, second_moments=SecondMoments(xx=0.5 * inertia, yy=0.5 * inertia))

    def _drives(self, masses: PistonMasses | None) -> Iterator["_PistonDrive"]:
        """Yield the drives of expansion piston and pump piston."""
        expansion = partial(
            CylinderGas,
            area=self.area,
            pressure=self.supply_pressure,
            volume=self.clearance,
            change=1.0,
            switch_travel=values_of(self.cut_off)[0],
            begins_constant=True,
            back_pressure=self.back_pressure,
            cut_off=self.cut_off if isinstance(self.cut_off, InputFunction) else None,
            reads_at_dead_centres=self.cut_off_read == AT_DEAD_CENTRE,
        )
        yield _PistonDrive(
            name="piston",
            stroke=self.stroke,
            rod=self.connecting_rod,
            piston_mass=masses.piston if masses else 0.0,
            rod_mass=masses.connecting_rod if masses else 0.0,
            cycles={EXPANSION: expansion} if self.throttle is None else self._throttled_cycles(expansion, self.throttle),
        )
        if self.pump_area is not None and self.pump_clearance is not None:
            yield _PistonDrive(
                name="pump_piston",
                stroke=self.pump_stroke or self.stroke,
                rod=self.pump_connecting_rod,
                piston_mass=masses.pump_piston if masses else 0.0,
                rod_mass=masses.pump_connecting_rod if masses else 0.0,
                cycles=self._pump_cycles(self.pump_area, self.pump_clearance),
            )

    def _throttled_cycles(self, expansion: MakeGas, throttle: float | InputFunction) -> dict[str, MakeGas]:
        """Return the gas that a closed throttle admits, at the pressure behind the piston, and what the throttle adds to it."""
        closed = partial(expansion, pressure=self.back_pressure)
        surplus = self.supply_pressure - self.back_pressure
        return {EXPANSION: closed, THROTTLE: partial(expansion, pressure=surplus, back_pressure=0.0, throttle=_as_input(throttle))}

    def _pump_cycles(self, area: float, clearance: float) -> dict[str, MakeGas]:
        """Return the gas behind the pump piston, which expands until air is taken in, and in front, which is compressed until delivery."""
        supply, atmosphere = self.supply_pressure, self.atmospheric_pressure
        gas = partial(CylinderGas, begins_constant=False)
        full, expanded = 1 + clearance, clearance * (supply / atmosphere - 1)
        delivered = (1 + clearance) * (1 - atmosphere / supply)
        return {
            "suction": partial(gas, area=area, pressure=atmosphere, volume=clearance, change=1.0, switch_travel=expanded),
            "delivery": partial(gas, area=-area, pressure=supply, volume=full, change=-1.0, switch_travel=delivered),
        }

    def _mean_torques(self, gases: tuple[CylinderGas, ...]) -> Iterator[ForceElement]:
        """Yield the mean torque of the gas over a turn, and what the throttle adds to it: the work in a stroke over the angle of one."""
        unthrottled = work_per_stroke(gas for gas in gases if gas.throttle is None) / math.pi
        yield Torque(name=MEAN_GAS, second=FLYWHEEL, moment=InputFunction(values=(unthrottled,)))
        for gas in (gas for gas in gases if gas.throttle is not None):
            full_torque = work_per_stroke([replace(gas, throttle=None)]) / math.pi
            moment = (gas.throttle or InputFunction()).scaled(full_torque)
            yield MeanGasTorque(name=gas.name, second=FLYWHEEL, moment=moment, full_torque=full_torque)

    def _loads(self, gases: tuple[CylinderGas, ...]) -> Iterator[ForceElement]:
        """Yield the torque of the load, with which the ground holds the flywheel back, and what grows with the speed."""
        if self.load_damping is not None:
            yield TorsionDamper(name="load damping", second=FLYWHEEL, damping=self.load_damping)
        if self.load_torque is not None:
            yield Torque(name=LOAD, first=FLYWHEEL, second=GROUND, moment=_as_input(self.load_torque))
        elif self.load_damping is None:
            work = _closing_work(gases) if self.load_pressure is None else self.area * self.load_pressure * self.stroke
            if self.load_pressure is None and not work > 0:
                raise MechanismError(
                    f"the engine can carry no load: in a stroke the gas does {work:.6g} J of work on the shaft; increase "
                    "supply_pressure or cut_off, or reduce back_pressure or pump_area; or give a load_pressure"
                )
            yield Torque(name=LOAD, first=FLYWHEEL, second=GROUND, moment=InputFunction(values=(work / math.pi,)))

    def _cycle_notes(self, gases: tuple[CylinderGas, ...]) -> Iterator[str]:
        """Yield a sentence about a cycle that a given load pressure does not close."""
        if self.load_pressure is None or any(gas.strokes_differ for gas in gases):
            return
        gained, full_work = work_per_stroke(gases) - self.area * self.load_pressure * self.stroke, self.area * self.stroke
        if abs(gained) > CLOSED_CYCLE_TOLERANCE * full_work * self.supply_pressure:
            closing = self.load_pressure + gained / full_work
            yield (
                f"the cycle does not close: in each stroke the shaft {'gains' if gained > 0 else 'loses'} {abs(gained):.6g} J, "
                f"{abs(gained) / (full_work * self.supply_pressure):.4%} of area x supply_pressure x stroke; it closes with "
                f'load_pressure = "{closing / 1e5:.10g} bar"'
            )

    def _derived_readings(self, gases: tuple[CylinderGas, ...]) -> Iterator[DerivedReading]:
        """Yield speed, torques, pressures and stored work."""
        angle = CRANK_ANGLE.name
        load_names = [name for name, given in (("load damping", self.load_damping), (LOAD, self.load_torque)) if given is not None]
        yield ShaftSpeed(name="shaft_speed", reading=angle)
        is_mean, throttles = self.gas_torque == MEAN, [gas.name for gas in gases if gas.throttle is not None]
        elements = (MEAN_GAS, *throttles) if is_mean else tuple(gas.name for gas in gases)
        yield AppliedTorque(name="gas_torque", reading=angle, elements=elements)
        yield AppliedTorque(name="load_torque", reading=angle, elements=tuple(load_names) or (LOAD,), sign=-1.0)
        for gas in () if is_mean else gases:
            if gas.throttle is None:
                elements = (gas.name,) if self.throttle is None or gas.name != EXPANSION else (gas.name, THROTTLE)
                yield CylinderPressure(name=f"{gas.name}_pressure", elements=elements, reading=angle, scale=self.supply_pressure)
        for name in throttles:
            yield ControlledValue(name="throttle_opening", element=name)
        if not is_mean:
            yield ControlledValue(name="cut_off", element=EXPANSION, is_switch=True)
        yield StoredWork(name="stored_work")


def _as_input(value: float | InputFunction) -> InputFunction:
    """Return a number as a constant function of time."""
    return value if isinstance(value, InputFunction) else InputFunction(values=(value,))


def _closing_work(gases: tuple[CylinderGas, ...]) -> float:
    """Return the work of gas on the shaft in a stroke, J. Raise MechanismError if throttle or cut-off moves."""
    if moving := next((gas for gas in gases if gas.strokes_differ), None):
        name = "cut-off" if moving.throttle is None else "throttle"
        raise MechanismError(f"the {name} moves, so that no load closes the cycle all the time; give load_pressure or load_torque")
    return work_per_stroke(gases)


@dataclass(frozen=True, kw_only=True)
class _PistonDrive:
    """A piston below the shaft with crank and connecting rod. Lengths in m, masses in kg; without mass the piston is no body."""

    name: str
    stroke: float
    rod: float | None
    piston_mass: float
    rod_mass: float
    cycles: dict[str, MakeGas]

    @property
    def _crank(self) -> float:
        return 0.5 * self.stroke

    @property
    def _rod_name(self) -> str:
        return f"{self.name} connecting rod"

    @property
    def _crank_pin(self) -> Point:
        """Crank pin on the flywheel."""
        return Point(body=FLYWHEEL, y=self._crank)

    @property
    def travel(self) -> Reading:
        """Travel of the piston from the dead centre nearest to the shaft, downward."""
        name, nearest = f"{self.name}_travel", self._crank - (self.rod or 0.0)
        if self.piston_mass or self.rod is None:
            point = Point(body=self.name) if self.piston_mass else self._crank_pin
            return PointCoordinate(name=name, quantity="length", point=point, direction_x=0.0, direction_y=-1.0, zero=-nearest)
        return FollowerHeight(
            name=name,
            quantity="length",
            top=Point(body=GROUND),
            knee=self._crank_pin,
            fraction=1.0,
            guide_x=0.0,
            length=self.rod,
            reference_point=Point(body=GROUND, y=nearest),
        )

    def gases(self) -> Iterator[CylinderGas]:
        """Yield the gas on each face of the piston."""
        body = self.name if self.piston_mass else FLYWHEEL
        for name, make_gas in self.cycles.items():
            yield make_gas(name=name, body=body, travel=self.travel, crank_angle=CRANK_ANGLE, stroke=self.stroke)

    def bodies(self) -> Iterator[tuple[Body, tuple[float, float, float]]]:
        """Yield piston and rod with mass, with their poses at the crank angle 0."""
        if not self.piston_mass:
            return
        length = self.rod or 0.0
        yield Body(name=self.name, mass=self.piston_mass, can_rotate=False), (0.0, self._crank - length, 0.0)
        if self.rod_mass:
            if self.rod is None:
                raise MechanismError(f"the {self._rod_name} has a mass but is endless; give its length, or leave its mass out")
            moments = SecondMoments(yy=self.rod_mass * self.rod**2 / 12)
            yield Body(name=self._rod_name, mass=self.rod_mass, second_moments=moments), (0.0, self._crank - 0.5 * length, 0.0)

    def joints(self) -> Iterator[Joint]:
        """Yield the guide of a piston with mass, and its rod; an endless one is a slot across the line of the piston."""
        if not self.piston_mass:
            return
        piston = Point(body=self.name)
        yield Slider(name=f"{self.name} guide", first=Point(body=GROUND), second=piston, angle=math.pi / 2)
        if self.rod is None:
            yield Slider(name=f"{self.name} yoke", first=piston, second=self._crank_pin, angle=0.0)
        elif not self.rod_mass:
            yield Distance(name=self._rod_name, first=self._crank_pin, second=piston, length=self.rod)
        else:
            top, bottom = (Point(body=self._rod_name, y=sign * 0.5 * self.rod) for sign in (1.0, -1.0))
            yield Pin(name=f"{self.name} crank pin", first=self._crank_pin, second=top)
            yield Pin(name=f"{self.name} gudgeon", first=bottom, second=piston)
