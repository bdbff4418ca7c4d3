"""A designed pendulum governor put to the test: statics and a run of the simulated machine beside what the design wants."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.pendulum.inputs import RPM
from governor_mechanism.studies.pendulum.results import PendulumDesign
from governor_mechanism.studies.pendulum.scene_export import TARGET_FRACTION
from governor_mechanism.studies.regression import run_uncertified
from governor_mechanism.units.text_table import format_table

STATICS_TOLERANCE = 1e-8
"""Largest relative difference of a wanted number and the statics of the machine: statics are exact to about 1e-12, and the angles of the
scene file have 15 digits; a sleeve lift of some per cent of the arm loses two."""

BREAKAWAY_TOLERANCE = 1e-5
"""Largest relative difference of the speed at which the sleeve breaks away: the time of the event is accurate to 1e-6 time scales, and the
speed rises by some per cent within a few of them."""

REST_TOLERANCE = 0.02
"""Largest distance of the sleeve at the end from where it should come to rest, in lifts: it approaches that place as fast as the dashpot
lets it, exp(-D w t) with D = 0.7 over 2.5 periods is 1e-5, and an overshoot against the resistance leaves some thousandths."""


@dataclass(frozen=True, kw_only=True)
class ComparedNumber:
    """A number that the design wants, and what statics or the run of the simulated machine give; tolerance relative to `scale`."""

    quantity: str
    unit: str
    wanted: float
    found: float
    by: str
    tolerance: float
    scale: float

    @property
    def ok(self) -> bool:
        """Whether the simulated machine gives the wanted number."""
        return abs(self.found - self.wanted) <= self.tolerance * self.scale

    @property
    def cells(self) -> tuple[str, ...]:
        """The number as a row of a table."""
        verdict = "" if self.ok else "DIFFERS"
        difference = abs(self.found - self.wanted) / self.scale
        return f"{self.quantity}, {self.unit}", f"{self.wanted:.8g}", f"{self.found:.8g}", self.by, f"{difference:.1e}", verdict


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedDesign:
    """What the simulated governor does, and what was wanted.

    Attributes
    ----------
    numbers
        The numbers.
    run
        The run of the scene: held by the resistance, then moved by the rise of the speed.
    breakaway
        Time (s) and arm angle (rad) at which the sleeve breaks away.
    """

    numbers: tuple[ComparedNumber, ...]
    run: Trajectory
    breakaway: tuple[float, float]

    @property
    def ok(self) -> bool:
        """Whether all numbers are the wanted ones."""
        return all(number.ok for number in self.numbers)

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as plain values, without the run."""
        return plain_record(self, "run", numbers=[plain_record(number, ok=number.ok) for number in self.numbers], ok=self.ok)

    def __str__(self) -> str:
        """Return a table of the numbers."""
        return format_table(
            ("the simulated machine", "wanted", "found", "by", "difference", ""), [one.cells for one in self.numbers], "lrrlrl"
        )


def simulate_design(design: PendulumDesign) -> SimulatedDesign:
    """Evaluate the statics of the designed machine, and run its scene.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    SimulatedDesign
        The numbers beside the wanted ones, and the run.

    Raises
    ------
    MechanismError
        If the run does not reach its end, or the sleeve never moves.
    """
    scene = design.scene
    run = run_uncertified(scene)
    time = next((event.time for event in run.events if event.kind is EventKind.SLIP), None)
    if time is None:
        raise MechanismError(
            "in the simulation of the design the resistance holds the sleeve to the end; reduce resistance or insensitivity"
        )
    numbers = (*_static_numbers(design, scene), *_run_numbers(design, run, time))
    return SimulatedDesign(numbers=numbers, run=run, breakaway=(time, design.middle_angle))


def _static_numbers(design: PendulumDesign, scene: Scene) -> Iterator[ComparedNumber]:
    """Yield what statics give at the ends of the travel."""

    def compare(quantity: str, unit: str, wanted: float, found: float, by: str = "statics") -> ComparedNumber:
        numbers = {"wanted": wanted, "found": found, "tolerance": STATICS_TOLERANCE, "scale": abs(wanted)}
        return ComparedNumber(quantity=quantity, unit=unit, by=by, **numbers)

    low, high = design.requirement.lowest_speed, design.requirement.highest_speed
    resistance = design.requirement.resistance
    curve = compute_controlling_force(scene, [design.middle_angle], resistance=resistance)
    ends = curve.working_range
    if ends is None:
        raise MechanismError("the simulated machine has no working range between its stops; change the inputs of the design")
    yield compare("speed of rest, lowest position", "rpm", low / RPM, float(ends.speed[0]) / RPM)
    yield compare("speed of rest, highest position", "rpm", high / RPM, float(ends.speed[1]) / RPM)
    angles = [equilibrium.coordinate for equilibrium in find_equilibria(scene, high)]
    highest = min(angles, key=lambda angle: abs(angle - design.arm_angles[1]), default=math.inf)
    name = f"arm angle in equilibrium at {high / RPM:.6g} rpm"
    yield compare(name, "deg", math.degrees(design.arm_angles[1]), math.degrees(highest), "equilibria")
    yield compare("sensitiveness", "%", 100 * design.sensitiveness, 100 * ends.sensitiveness)
    yield compare("lift of the sleeve", "mm", 1e3 * design.sleeve_lift, 1e3 * ends.lift)
    yield compare("effort for 1 % of speed", "N", design.effort, float(curve.effort.effort[0]))
    yield compare("work capacity", "J", design.work_capacity, ends.work_capacity)
    rising, falling = (math.sqrt(1 + sign * design.inputs.insensitivity) for sign in (1, -1))
    band = compute_insensitivity_band(scene, [design.middle_angle], resistance)
    yield compare("insensitivity, by (1) and (2)", "%", 100 * (rising - falling), 100 * float(band.insensitivity[0]))
    yield compare("(1) begins to rise, highest position", "rpm", high * rising / RPM, float(ends.rising_speed[1]) / RPM)
    yield compare("(2) begins to fall, lowest position", "rpm", low * falling / RPM, float(ends.falling_speed[0]) / RPM)


def _run_numbers(design: PendulumDesign, run: Trajectory, breakaway_time: float) -> Iterator[ComparedNumber]:
    """Yield what the run gives: the speed at which the sleeve breaks away, and where it comes to rest."""
    middle = design.equilibrium_speed(design.middle_angle)
    speed = float(SpindleSpeedFunction(run.scene.spindle)(np.array([breakaway_time]))[0])
    wanted = middle * math.sqrt(1 + design.inputs.insensitivity)
    yield ComparedNumber(
        quantity="(1) breaks away half way up",
        unit="rpm",
        wanted=wanted / RPM,
        found=speed / RPM,
        by="run",
        tolerance=BREAKAWAY_TOLERANCE,
        scale=wanted / RPM,
    )
    lift = run.readings["sleeve_lift"]
    risen = float(lift[-1] - lift[0]) / design.sleeve_lift
    yield ComparedNumber(
        quantity="rises by the rest of the speed, of the lift",
        unit="%",
        wanted=100 * (TARGET_FRACTION - 0.5),
        found=100 * risen,
        by="run",
        tolerance=REST_TOLERANCE,
        scale=100.0,
    )
