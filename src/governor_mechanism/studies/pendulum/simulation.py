"""A designed pendulum governor put to the test: statics and a run of the simulated machine beside what the design wants."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.pendulum.inputs import RPM
from governor_mechanism.studies.pendulum.results import PendulumDesign
from governor_mechanism.studies.pendulum.scene_export import TARGET_FRACTION
from governor_mechanism.studies.regression import run_uncertified
from governor_mechanism.studies.simulated_design import ComparedNumber, SimulatedMachine, compare_statics

BREAKAWAY_TOLERANCE = 1e-5
"""Largest relative difference of the speed at which the sleeve breaks away: the time of the event is accurate to 1e-6 time scales, and the
speed rises by some per cent within a few of them."""

REST_TOLERANCE = 0.02
"""Largest distance of the sleeve at the end from where it should come to rest, in lifts: it approaches that place as fast as the dashpot
lets it, exp(-D w t) with D = 0.7 over 2.5 periods is 1e-5, and an overshoot against the resistance leaves some thousandths."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedDesign(SimulatedMachine):
    """What the simulated governor does, held by the resistance and then moved by the rise of the speed.

    Attributes
    ----------
    breakaway
        Time (s) and arm angle (rad) at which the sleeve breaks away.
    """

    breakaway: tuple[float, float]


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
    low, high = design.requirement.lowest_speed, design.requirement.highest_speed
    resistance = design.requirement.resistance
    curve = compute_controlling_force(scene, [design.middle_angle], resistance=resistance)
    ends = curve.working_range
    if ends is None:
        raise MechanismError("the simulated machine has no working range between its stops; change the inputs of the design")
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
    band = compute_insensitivity_band(scene, [design.middle_angle], resistance)
    yield compare_statics("insensitivity, by (1) and (2)", "%", 100 * (rising - falling), 100 * float(band.insensitivity[0]))
    yield compare_statics("(1) begins to rise, highest position", "rpm", high * rising / RPM, float(ends.rising_speed[1]) / RPM)
    yield compare_statics("(2) begins to fall, lowest position", "rpm", low * falling / RPM, float(ends.falling_speed[0]) / RPM)


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
