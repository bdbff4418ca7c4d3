"""Exact motions of scenes whose equation of motion can be integrated, in extended precision, apart from the package.

An engine with massless reciprocating parts under a constant load has an energy that is an elementary function of the crank angle; its
time is an integral over the angle. A flywheel under steps of load has exponentials. A chain of four-bar linkages turns as a pendulum.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Extended = np.longdouble
Array = NDArray[Any]

N_NODES = 20
"""Number of Gauss-Legendre nodes of a panel: with MAX_PANEL the integrals are exact to the last digit of extended precision."""

MAX_PANEL = 0.15
"""Largest width of a panel, rad: a clearance of 2 % makes the pressure singular at 0.28 rad from a dead centre, in the complex plane."""

NEWTON_STEPS = 6
"""Number of Newton steps from the middle of a panel to the angle of a time; three suffice for double precision."""

TAYLOR_ORDER, TAYLOR_STEP = 30, 0.02
"""Order of the Taylor series of a pendulum, and its longest step, s."""


@dataclass(frozen=True)
class ExactMotion:
    """Readings and their rates (n,) at the times (n,) s of a scene, in SI."""

    times: Array
    readings: Mapping[str, Array]
    rates: Mapping[str, Array]


def to_double(values: Mapping[str, Array]) -> dict[str, Array]:
    """Return arrays rounded to double precision."""
    return {name: np.asarray(value, dtype=float) for name, value in values.items()}


@cache
def gauss_legendre() -> tuple[Array, Array]:
    """Return nodes and weights on -1 to 1, in extended precision by Newton's method from those in double precision."""
    x = np.polynomial.legendre.leggauss(N_NODES)[0].astype(Extended)
    for _ in range(2):
        before, value = np.ones_like(x), x
        for n in range(1, N_NODES):
            following = ((2 * n + 1) * x * value - n * before) / (n + 1)
            before = value
            value = following
        slope = N_NODES * (x * value - before) / (x * x - 1)
        x = x - value / slope
    return x, 2 / ((1 - x * x) * slope * slope)


# --- engine whose energy is a function of the crank angle -----------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """A piston with the pressures on its faces: lengths in m, pressures in Pa, the rod infinite without a length."""

    area: float
    stroke: float
    rod: float | None = None

    def travel(self, angle: Array) -> Array:
        """Return the travel (m) from the dead centre at the angle zero."""
        crank = Extended(self.stroke) / 2
        travel = crank * (1 - np.cos(angle))
        if self.rod is None:
            return travel
        rod = Extended(self.rod)
        return travel - rod + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)

    def travel_slope(self, angle: Array) -> Array:
        """Return the derivative of the travel, m/rad."""
        crank = Extended(self.stroke) / 2
        slope = crank * np.sin(angle)
        if self.rod is None:
            return slope
        return slope - crank**2 * np.sin(angle) * np.cos(angle) / np.sqrt(Extended(self.rod) ** 2 - (crank * np.sin(angle)) ** 2)

    def angle_at(self, relative_travel: Extended) -> Extended:
        """Return the angle between 0 and pi at which the piston has a travel relative to the stroke."""
        crank = Extended(self.stroke) / 2
        if self.rod is None:
            return np.arccos(1 - 2 * relative_travel)
        rod = Extended(self.rod)
        height = crank - rod - relative_travel * self.stroke  # of the piston above the shaft
        return np.arccos((crank**2 + height**2 - rod**2) / (2 * crank * height))


@dataclass(frozen=True, kw_only=True)
class Face:
    """Gas on one face of a piston in a stroke: an isotherm after a constant pressure, or before one.

    Pressures in Pa; volumes and travels relative to the stroke. `sense` is 1 for a gas that drives the stroke, -1 for one that resists.
    """

    name: str
    cylinder: Cylinder
    pressure: float
    volume: float
    change: float
    switch: Extended
    constant_first: bool
    sense: float = 1.0
    back_pressure: float = 0.0

    def pressure_at(self, travel: Array) -> Array:
        """Return the pressure at a travel in the stroke."""
        at_switch = self.volume + self.change * self.switch
        isotherm = self.pressure * at_switch / (self.volume + self.change * travel)
        return np.where((travel < self.switch) == self.constant_first, Extended(self.pressure), isotherm)

    def work_at(self, travel: Array) -> Array:
        """Return the work since the beginning of the stroke, J."""
        at_switch = self.volume + self.change * self.switch
        below, above = np.minimum(travel, self.switch), np.maximum(travel, self.switch)
        if self.constant_first:
            constant, start, end = below, self.switch, above
        else:
            constant, start, end = above - self.switch, Extended(0), below
        expansion = self.change * at_switch * np.log((self.volume + self.change * end) / (self.volume + self.change * start))
        swept = Extended(self.cylinder.area) * self.cylinder.stroke
        return self.sense * swept * (self.pressure * (constant + expansion) - self.back_pressure * travel)

    def stroke_of(self, angle: Array) -> tuple[Array, Array]:
        """Return the number of whole strokes since the angle zero, and the travel in the present one."""
        n_strokes = np.floor(angle / PI)
        is_return = n_strokes % 2
        travel = self.cylinder.travel(angle) / self.cylinder.stroke
        return n_strokes, is_return + (1 - 2 * is_return) * travel

    def total_work(self, angle: Array) -> Array:
        """Return the work since the angle zero, J."""
        n_strokes, travel = self.stroke_of(angle)
        return n_strokes * self.work_at(Extended(1)) + self.work_at(travel)

    def torque(self, angle: Array) -> Array:
        """Return the torque on the shaft, N m."""
        n_strokes, travel = self.stroke_of(angle)
        force = self.sense * self.cylinder.area * (self.pressure_at(travel) - self.back_pressure)
        return (1 - 2 * (n_strokes % 2)) * force * self.cylinder.travel_slope(angle)


PI = Extended("3.14159265358979323846264338327950288")


@dataclass(frozen=True, kw_only=True)
class ExactEngine:
    """An engine on a flywheel under a constant load torque (N m), with cylinders without masses."""

    inertia: float
    load_torque: float
    start_angle: float
    start_rate: float
    cylinders: Mapping[str, Cylinder]
    faces: tuple[Face, ...]
    cut_off: float

    def energy(self, angle: Array) -> Array:
        """Return the kinetic energy of the flywheel, J."""
        gained = sum(face.total_work(angle) - face.total_work(Extended(self.start_angle)) for face in self.faces)
        load = self.load_torque * (angle - Extended(self.start_angle))
        return Extended(self.inertia) * Extended(self.start_rate) ** 2 / 2 + gained - load

    def speed(self, angle: Array) -> Array:
        """Return the speed of the shaft, rad/s."""
        return np.sqrt(2 * self.energy(angle) / self.inertia)

    def kinks(self, end: float) -> Array:
        """Return the angles between the start and an end at which a pressure jumps or bends, in order."""
        in_stroke = [Extended(0)]
        returning = [Extended(0)]
        for face in self.faces:
            if 0 < face.switch < 1:
                in_stroke.append(face.cylinder.angle_at(face.switch))
                returning.append(PI - face.cylinder.angle_at(1 - face.switch))
        found = []
        for stroke in range(math.floor(self.start_angle / math.pi) - 1, math.ceil(end / math.pi) + 1):
            for k in range(len(in_stroke)):
                # In a return stroke the travel counts from the far dead centre; the return is the mirror image of the way out.
                found.append(stroke * PI + (in_stroke[k] if stroke % 2 == 0 else returning[k]))
        return np.array(sorted(angle for angle in found if self.start_angle < angle < end), dtype=Extended)

    def angles_at(self, times: Array) -> Array:
        """Return the crank angles (n,) rad at times (n,) s, in extended precision."""
        panels, panel_times = self._panels(float(times[-1]))
        index = np.clip(np.searchsorted(panel_times, times.astype(Extended), side="right") - 1, 0, len(panels) - 2)
        low, start = panels[index], panel_times[index]
        width = panels[index + 1] - low
        angle = low + width * (times - start) / (panel_times[index + 1] - start)
        for _ in range(NEWTON_STEPS):
            angle = angle - (start + self._durations(low, angle) - times) * self.speed(angle)
        return angle

    def _panels(self, duration: float) -> tuple[Array, Array]:
        """Return the ends of panels between kinks, and the times at which the crank passes them, until after a duration (s)."""
        end = self.start_angle + 1.5 * self.start_rate * duration
        while True:
            knots = np.concatenate([[Extended(self.start_angle)], self.kinks(end), [Extended(end)]])
            panels = [knots[:1]]
            for low, high in pairwise(knots):
                n = max(1, math.ceil(float(high - low) / MAX_PANEL))
                panels.append(low + (high - low) * np.arange(1, n + 1).astype(Extended) / n)
            ends = np.concatenate(panels)
            times = np.concatenate([[Extended(0)], np.cumsum(self._durations(ends[:-1], ends[1:]))])
            if times[-1] > duration:
                return ends, times
            end += 0.5 * self.start_rate * duration

    def _durations(self, low: Array, high: Array) -> Array:
        """Return the times (n,) s from one angle to another in the same panel."""
        nodes, weights = gauss_legendre()
        middle, half = (low + high) / 2, (high - low) / 2
        return half * np.sum(weights / self.speed(middle[:, np.newaxis] + half[:, np.newaxis] * nodes), axis=1)

    def motion(self, times: Array) -> ExactMotion:
        """Return all readings and rates of the engine at times."""
        angle = self.angles_at(times)
        speed = self.speed(angle)
        readings: dict[str, Any] = {"crank_angle": angle, "shaft_speed": speed}
        rates = {"crank_angle": speed}
        for name, cylinder in self.cylinders.items():
            readings[f"{name}_travel"] = cylinder.travel(angle)
            rates[f"{name}_travel"] = cylinder.travel_slope(angle) * speed
        readings["gas_torque"] = sum(face.torque(angle) for face in self.faces)
        readings["load_torque"] = np.full(len(times), self.load_torque)
        readings |= {f"{face.name}_pressure": face.pressure_at(face.stroke_of(angle)[1]) for face in self.faces}
        readings["cut_off"] = np.full(len(times), self.cut_off)
        readings["stored_work"] = self.energy(angle) - Extended(self.inertia) * Extended(self.start_rate) ** 2 / 2
        return ExactMotion(times, to_double(readings), to_double(rates))


def exact_engine(document: Mapping[str, Any]) -> ExactEngine:
    """Return the engine of a document of a `flywheel_engine` with cyclic gas and a constant load torque, in SI without units."""
    given, start = document["dimensions"], document["start"]
    supply, back, atmosphere = given["supply_pressure"], given["back_pressure"], given["atmospheric_pressure"]
    cylinders = {"piston": Cylinder(area=given["area"], stroke=given["stroke"], rod=given.get("connecting_rod"))}
    faces = [
        Face(
            name="expansion", cylinder=cylinders["piston"], pressure=supply, volume=given["clearance"], change=1.0,
            switch=Extended(given["cut_off"]), constant_first=True, back_pressure=back,
        )
    ]  # fmt: skip
    if "pump_area" in given:
        stroke, clearance = given.get("pump_stroke", given["stroke"]), Extended(given["pump_clearance"])
        pump = cylinders["pump_piston"] = Cylinder(area=given["pump_area"], stroke=stroke, rod=given.get("pump_connecting_rod"))
        opening = clearance * (Extended(supply) / Extended(atmosphere) - 1)
        delivery = (1 + clearance) * (1 - Extended(atmosphere) / Extended(supply))
        faces += [
            Face(name="suction", cylinder=pump, pressure=atmosphere, volume=clearance, change=1.0, switch=opening, constant_first=False),
            Face(
                name="delivery", cylinder=pump, pressure=supply, volume=1 + clearance, change=-1.0, switch=delivery, constant_first=False,
                sense=-1.0,
            ),
        ]  # fmt: skip
    return ExactEngine(
        inertia=given["inertia"], load_torque=given["load_torque"], start_angle=start["crank_angle"], start_rate=start["crank_rate"],
        cylinders=cylinders, faces=tuple(faces), cut_off=given["cut_off"],
    )  # fmt: skip


# --- flywheel under steps of load -----------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class ExactFlywheel:
    """A flywheel under a constant torque (N m), a damping (N m s/rad) and a load that is constant between steps."""

    inertia: float
    gas_torque: Extended
    damping: float
    step_times: tuple[float, ...]
    loads: tuple[float, ...]
    start_angle: float
    start_rate: float

    def motion(self, times: Array, stroke: float) -> ExactMotion:
        """Return all readings and rates at times, none of which is that of a step."""
        starts = np.array([0.0, *self.step_times], dtype=Extended)
        states = [(Extended(self.start_angle), Extended(self.start_rate))]
        for k in range(len(self.step_times)):
            states.append(self._advance(*states[-1], starts[k + 1] - starts[k], self.loads[k]))
        index = np.searchsorted(starts, times.astype(Extended), side="right") - 1
        before, load = np.array(states, dtype=Extended)[index], np.array(self.loads, dtype=Extended)[index]
        angle, speed = self._advance(before[:, 0], before[:, 1], times - starts[index], load)
        crank = Extended(stroke) / 2
        readings = {
            "crank_angle": angle,
            "piston_travel": crank * (1 - np.cos(angle)),
            "shaft_speed": speed,
            "gas_torque": np.full(len(times), self.gas_torque),
            "load_torque": load + self.damping * speed,
            "stored_work": Extended(self.inertia) * (speed**2 - Extended(self.start_rate) ** 2) / 2,
        }
        rates = {"crank_angle": speed, "piston_travel": crank * np.sin(angle) * speed}
        return ExactMotion(times, to_double(readings), to_double(rates))

    def _advance(self, angle: Array, speed: Array, time: Array, load: Array) -> tuple[Array, Array]:
        """Return angle and speed after a time (s) under a constant load."""
        rate = Extended(self.damping) / Extended(self.inertia)
        final = (self.gas_torque - load) / Extended(self.damping)
        # The share of the approach to the final speed, and its integral.
        share = -np.expm1(-rate * time)
        return angle + final * time + (speed - final) * share / rate, speed + (final - speed) * share


def exact_flywheel(document: Mapping[str, Any]) -> ExactFlywheel:
    """Return the flywheel of a document of a `flywheel_engine` with mean gas torque, damping and a load in steps."""
    given, start = document["dimensions"], document["start"]
    points = given["load_torque"]
    cylinder = Cylinder(area=given["area"], stroke=given["stroke"])
    gas = Face(
        name="expansion", cylinder=cylinder, pressure=given["supply_pressure"], volume=given["clearance"], change=1.0,
        switch=Extended(given["cut_off"]), constant_first=True, back_pressure=given["back_pressure"],
    )  # fmt: skip
    return ExactFlywheel(
        inertia=given["inertia"], gas_torque=gas.work_at(Extended(1)) / PI, damping=given["load_damping"],
        step_times=tuple(time for time, _ in points[2::2]), loads=tuple(load for _, load in points[0::2]),
        start_angle=start["crank_angle"], start_rate=start["crank_rate"],
    )  # fmt: skip


# --- chain of four-bar linkages ------------------------------------------------------------------------------------------------


def exact_chain(document: Mapping[str, Any], times: Array) -> ExactMotion:
    """Return the motion of a chain of parallelogram linkages: all cranks turn alike, all couplers translate on a circle."""
    masses = {body["name"]: body["mass"] for body in document["body"]}
    crank = next(body["rod"]["length"] for body in document["body"] if body["name"] == "crank 0")
    cranks, couplers = (sum(Extended(mass) for name, mass in masses.items() if name.startswith(kind)) for kind in ("crank", "coupler"))
    stiffness = Extended(document["effects"]["gravity"]) * (cranks / 2 + couplers) / ((cranks / 3 + couplers) * Extended(crank))
    start = document["start"]
    angle, rate = pendulum_motion(stiffness, Extended(start["crank_angle"]), Extended(start["crank_rate"]), times)
    length = Extended(crank)
    readings = {"crank_angle": angle, "last_angle": angle, "x": length * np.cos(angle), "y": length * np.sin(angle)}
    rates = {"crank_angle": rate, "last_angle": rate, "x": -length * np.sin(angle) * rate, "y": length * np.cos(angle) * rate}
    return ExactMotion(times, to_double(readings), to_double(rates))


def pendulum_motion(stiffness: Extended, angle: Extended, rate: Extended, times: Array) -> tuple[Array, Array]:
    """Return angle and rate (n,) of angle'' = -stiffness cos(angle) at times (n,) s, by Taylor series in extended precision."""
    found, now = [], Extended(0)
    for time in times:
        n_steps = max(1, math.ceil(float(time - now) / TAYLOR_STEP))
        step = (Extended(time) - now) / n_steps
        for _ in range(n_steps if time > now else 0):
            angle, rate = _taylor_step(stiffness, angle, rate, step)
        now = Extended(time)
        found.append((angle, rate))
    angles, rates = np.array(found, dtype=Extended).T
    return angles, rates


def _taylor_step(stiffness: Extended, angle: Extended, rate: Extended, step: Extended) -> tuple[Extended, Extended]:
    """Return angle and rate after a step (s)."""
    angles, sines, cosines = (np.zeros(TAYLOR_ORDER + 1, dtype=Extended) for _ in range(3))
    angles[0], angles[1], sines[0], cosines[0] = angle, rate, np.sin(angle), np.cos(angle)
    derivatives = np.zeros(TAYLOR_ORDER + 1, dtype=Extended)  # k times the k-th coefficient of the angle
    derivatives[1] = rate
    for k in range(1, TAYLOR_ORDER):
        sines[k] = np.dot(derivatives[1 : k + 1], cosines[k - 1 :: -1][:k]) / k
        cosines[k] = -np.dot(derivatives[1 : k + 1], sines[k - 1 :: -1][:k]) / k
        angles[k + 1] = -stiffness * cosines[k - 1] / (k * (k + 1))
        derivatives[k + 1] = (k + 1) * angles[k + 1]
    powers = step ** np.arange(TAYLOR_ORDER + 1)
    return np.dot(angles, powers), np.dot(derivatives[1:], powers[:-1])


MOTIONS: Mapping[str, Callable[[Mapping[str, Any], Array], ExactMotion]] = {
    "air engine": lambda document, times: exact_engine(document).motion(times),
    "load steps": lambda document, times: exact_flywheel(document).motion(times, document["dimensions"]["stroke"]),
    "four-bar chain": exact_chain,
}
"""Exact motion of the scenes of a machine, from the document of the scene and the reported times."""
