"""Designed governors put to the test: statics and a run of the simulated machine beside what the design wants."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.result import Column, Recorded, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import ControllingForce, compute_controlling_force
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import compute_insensitivity_band, equilibrium_speed_at
from governor_mechanism.statics.working_range import WorkingRange
from governor_mechanism.studies.design.hartnell import HartnellDesign
from governor_mechanism.studies.design.pendulum import START_FRACTION, TARGET_FRACTION, PendulumDesign
from governor_mechanism.studies.design.skeleton import SPEED_CHANGE
from governor_mechanism.studies.regression import run_uncertified
from governor_mechanism.units.constants import RPM

STATICS_TOLERANCE = 1e-8
"""Largest relative difference of a wanted number and the statics of the machine: statics are exact to about 1e-12, and the numbers of the
scene file have 15 digits; a lift, or a range of speed, of some per cent loses two."""

BREAKAWAY_TOLERANCE = 1e-5
"""Largest relative difference of the speed at which the sleeve breaks away: the time of the event is accurate to 1e-6 time scales, and the
speed rises by some per cent within a few of them."""

HARTNELL_REST_TOLERANCE = 1e-3
"""Largest distance of the sleeve at the end of the run from its equilibrium, in lifts: it settles within a second by exp(-D w t), with
D = 0.7 and w of 20 rad/s and more by 1e-6."""

PENDULUM_REST_TOLERANCE = 0.02
"""Largest distance of the sleeve at the end from where it should come to rest, in lifts: it approaches that place as fast as the dashpot
lets it, exp(-D w t) with D = 0.7 over 2.5 periods is 1e-5, and an overshoot against the resistance leaves some thousandths."""


@dataclass(frozen=True)
class ComparedNumber(Recorded):
    """A number that the design wants, and what statics or the run of the simulated machine give; tolerance relative to `scale`."""

    quantity: str
    unit: str
    wanted: float
    found: float
    by: str
    tolerance: float
    scale: float

    derived = ("ok",)

    @property
    def ok(self) -> bool:
        """Whether the simulated machine gives the wanted number."""
        return abs(self.found - self.wanted) <= self.tolerance * self.scale

    @property
    def difference(self) -> float:
        """Difference over the scale."""
        return abs(self.found - self.wanted) / self.scale

    @property
    def verdict(self) -> str:
        """A word where the simulated machine does not give the wanted number."""
        return "" if self.ok else "DIFFERS"


COMPARED_COLUMNS = (
    Column("", "the simulated machine", "{quantity}, {unit}"),
    Column("wanted", "wanted", ".8g"),
    Column("found", "found", ".8g"),
    Column("by", "by"),
    Column("difference", "difference", ".1e"),
    Column("verdict", ""),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedMachine(Recorded):
    """What a designed machine does, and what was wanted: the numbers, and the run of its scene."""

    numbers: tuple[ComparedNumber, ...]
    run: Trajectory

    hidden = ("run",)
    derived = ("ok",)

    @property
    def ok(self) -> bool:
        """Whether all numbers are the wanted ones."""
        return all(number.ok for number in self.numbers)

    def __str__(self) -> str:
        """Return a table of the numbers."""
        return format_columns(COMPARED_COLUMNS, self.numbers)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedPendulum(SimulatedMachine):
    """What the simulated governor does, held by the resistance and then moved by the rise of the speed.

    Attributes
    ----------
    breakaway
        Time (s) and arm angle (rad) at which the sleeve breaks away.
    """

    breakaway: tuple[float, float]


def compare_statics(quantity: str, unit: str, wanted: float, found: float, by: str = "statics") -> ComparedNumber:
    """Return a number by statics beside the wanted one, with the tolerance of statics relative to the wanted number."""
    return ComparedNumber(quantity, unit, wanted, found, by, STATICS_TOLERANCE, abs(wanted))


def simulate_hartnell(design: HartnellDesign) -> SimulatedMachine:
    """Evaluate the statics of the designed machine, and run its scene.

    Result: the numbers beside the wanted ones, and the run. Raises MechanismError if the simulated machine
    has no working range between its stops.
    """
    scene = design.scene
    run = run_uncertified(scene)
    return SimulatedMachine(numbers=(*_hartnell_statics(design, scene), _hartnell_rest(design, scene, run)), run=run)


def _working_range(curve: ControllingForce) -> WorkingRange:
    if curve.working_range is None:
        raise MechanismError("the simulated machine has no working range between its stops; change the inputs of the design")
    return curve.working_range


def _hartnell_statics(design: HartnellDesign, scene: Scene) -> Iterator[ComparedNumber]:
    """Yield what statics give at the ends of the lift, with the exact spring, and with that of the textbooks."""
    middle = compute_controlling_force(scene, [design.travel.middle_angle], speed_change=SPEED_CHANGE)
    working = _working_range(middle)
    speeds = design.inputs.lowest_speed, design.inputs.highest_speed
    places = ("lowest position", "highest position")
    for place, speed, found in zip(places, speeds, working.speed.tolist(), strict=True):
        yield compare_statics(f"speed, {place}", "rpm", speed / RPM, found / RPM)
    yield compare_statics("lift of the sleeve", "mm", 1e3 * design.travel.lift, 1e3 * working.lift)
    yield replace(compare_statics("sensitiveness", "%", 100 * design.exact.sensitiveness, 100 * working.sensitiveness), scale=100.0)
    yield compare_statics("effort for 1 % of speed, half way up", "N", design.effort, float(middle.effort.effort[0]))
    others = tuple(effect for effect in scene.effects if not isinstance(effect, OutputSpring))
    spring = OutputSpring(reading="sleeve_lift", rate=design.textbook.rate, preload=design.textbook.forces[0])
    textbook_speeds = equilibrium_speed_at(scene.with_changes(effects=(*others, spring)), design.travel.arm_angles).tolist()
    for place, speed, found in zip(places, design.textbook.speeds, textbook_speeds, strict=True):
        yield compare_statics(f"textbook spring: speed, {place}", "rpm", speed / RPM, found / RPM)


def _hartnell_rest(design: HartnellDesign, scene: Scene, run: Trajectory) -> ComparedNumber:
    """Return where the sleeve comes to rest in the run, beside the equilibrium at its last speed."""
    speed = float(run.readings["spindle_speed"][-1])
    low, high = design.travel.arm_angles
    lifts = [one.readings["sleeve_lift"] for one in find_equilibria(scene, speed) if low <= one.coordinate <= high]
    wanted = lifts[-1] if lifts else design.travel.lift
    found = float(run.readings["sleeve_lift"][-1])
    name = f"lift at {speed / RPM:.6g} rpm"
    scale = 1e3 * design.travel.lift
    return ComparedNumber(name, "mm", 1e3 * wanted, 1e3 * found, "run", HARTNELL_REST_TOLERANCE, scale)


def simulate_pendulum(design: PendulumDesign) -> SimulatedPendulum:
    """Evaluate the statics of the designed machine, and run its scene.

    Result: the numbers beside the wanted ones, and the run. Raises MechanismError if the run does not reach
    its end, or the sleeve never moves.
    """
    scene = design.scene
    run = run_uncertified(scene)
    time = next((event.time for event in run.events if event.kind is EventKind.SLIP), None)
    if time is None:
        raise MechanismError(
            "in the simulation of the design the resistance holds the sleeve to the end; reduce resistance or insensitivity"
        )
    numbers = (*_pendulum_statics(design, scene), *_pendulum_run(design, run, time))
    return SimulatedPendulum(numbers=numbers, run=run, breakaway=(time, design.middle_angle))


def _pendulum_statics(design: PendulumDesign, scene: Scene) -> Iterator[ComparedNumber]:
    """Yield what statics give at the ends of the travel."""
    low = design.requirement.lowest_speed
    high = design.requirement.highest_speed
    resistance = design.requirement.resistance
    middle = [design.middle_angle]
    curve = compute_controlling_force(scene, middle, resistance=resistance)
    ends = _working_range(curve)
    yield compare_statics("speed of rest, lowest position", "rpm", low / RPM, float(ends.speed[0]) / RPM)
    yield compare_statics("speed of rest, highest position", "rpm", high / RPM, float(ends.speed[1]) / RPM)
    angles = [equilibrium.coordinate for equilibrium in find_equilibria(scene, high)]
    highest = min(angles, key=lambda angle: abs(angle - design.arm_angles[1]), default=math.inf)
    name = f"arm angle in equilibrium at {high / RPM:.6g} rpm"
    yield compare_statics(name, "deg", math.degrees(design.arm_angles[1]), math.degrees(highest), "equilibria")
    yield compare_statics("sensitiveness", "%", 100 * design.sensitiveness, 100 * ends.sensitiveness)
    yield compare_statics("lift of the sleeve", "mm", 1e3 * design.sleeve_lift, 1e3 * ends.lift)
    yield compare_statics("effort for 1 % of speed", "N", design.effort, float(curve.effort.effort[0]))
    yield compare_statics("work capacity", "J", design.work_capacity, ends.work_capacity)
    rising, falling = (math.sqrt(1 + sign * design.inputs.insensitivity) for sign in (1, -1))
    band = compute_insensitivity_band(scene, middle, resistance)
    yield compare_statics("insensitivity, by (1) and (2)", "%", 100 * (rising - falling), 100 * float(band.insensitivity[0]))
    yield compare_statics("(1) begins to rise, highest position", "rpm", high * rising / RPM, float(ends.rising_speed[1]) / RPM)
    yield compare_statics("(2) begins to fall, lowest position", "rpm", low * falling / RPM, float(ends.falling_speed[0]) / RPM)


def _pendulum_run(design: PendulumDesign, run: Trajectory, breakaway_time: float) -> Iterator[ComparedNumber]:
    """Yield what the run gives: the speed at which the sleeve breaks away, and where it comes to rest."""
    speed = float(SpindleSpeedFunction(run.scene.spindle)(np.array([breakaway_time]))[0]) / RPM
    wanted = design.equilibrium_speed(design.middle_angle) * math.sqrt(1 + design.inputs.insensitivity) / RPM
    yield ComparedNumber("(1) breaks away half way up", "rpm", wanted, speed, "run", BREAKAWAY_TOLERANCE, wanted)
    lift = run.readings["sleeve_lift"]
    risen = float(lift[-1] - lift[0]) / design.sleeve_lift
    name = "rises by the rest of the speed, of the lift"
    yield ComparedNumber(name, "%", 100 * (TARGET_FRACTION - START_FRACTION), 100 * risen, "run", PENDULUM_REST_TOLERANCE, 100.0)
