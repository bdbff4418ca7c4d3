"""A designed Hartnell governor put to the test: statics and a run of the simulated machine beside what the design wants."""

from collections.abc import Iterator
from dataclasses import replace

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.studies.hartnell.design import SPEED_CHANGE
from governor_mechanism.studies.hartnell.inputs import RPM
from governor_mechanism.studies.hartnell.results import HartnellDesign, SleeveSpring
from governor_mechanism.studies.regression import run_uncertified
from governor_mechanism.studies.simulated_design import ComparedNumber, SimulatedMachine, compare_statics

REST_TOLERANCE = 1e-3
"""Largest distance of the sleeve at the end of the run from its equilibrium, in lifts: it settles within a second by exp(-D w t), with
D = 0.7 and w of 20 rad/s and more by 1e-6."""


def simulate_design(design: HartnellDesign) -> SimulatedMachine:
    """Evaluate the statics of the designed machine, and run its scene.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    SimulatedMachine
        The numbers beside the wanted ones, and the run.

    Raises
    ------
    MechanismError
        If the simulated machine has no working range between its stops.
    """
    scene = design.scene
    run = run_uncertified(scene)
    return SimulatedMachine(numbers=(*_static_numbers(design, scene), *_run_numbers(design, scene, run)), run=run)


def _static_numbers(design: HartnellDesign, scene: Scene) -> Iterator[ComparedNumber]:
    """Yield what statics give at the ends of the lift, with the exact spring, and with that of the textbooks."""
    ends = compute_controlling_force(scene, [design.travel.middle_angle], speed_change=SPEED_CHANGE)
    working = ends.working_range
    if working is None:
        raise MechanismError("the simulated machine has no working range between its stops; change the inputs of the design")
    speeds = design.inputs.lowest_speed, design.inputs.highest_speed
    places = ("lowest position", "highest position")
    for place, speed, found in zip(places, speeds, working.speed.tolist(), strict=True):
        yield compare_statics(f"speed, {place}", "rpm", speed / RPM, found / RPM)
    yield compare_statics("lift of the sleeve", "mm", 1e3 * design.travel.lift, 1e3 * working.lift)
    yield replace(compare_statics("sensitiveness", "%", 100 * design.exact.sensitiveness, 100 * working.sensitiveness), scale=100.0)
    yield compare_statics("effort for 1 % of speed, half way up", "N", design.effort, float(ends.effort.effort[0]))
    textbook_speeds = equilibrium_speed_at(_with_spring(scene, design.textbook), design.travel.arm_angles).tolist()
    for place, speed, found in zip(places, design.textbook.speeds, textbook_speeds, strict=True):
        yield compare_statics(f"textbook spring: speed, {place}", "rpm", speed / RPM, found / RPM)


def _with_spring(scene: Scene, spring: SleeveSpring) -> Scene:
    """Return the scene with another spring on the sleeve."""
    others = tuple(effect for effect in scene.effects if not isinstance(effect, OutputSpring))
    return scene.with_changes(effects=(*others, OutputSpring(reading="sleeve_lift", rate=spring.rate, preload=spring.forces[0])))


def _run_numbers(design: HartnellDesign, scene: Scene, run: Trajectory) -> Iterator[ComparedNumber]:
    """Yield where the sleeve comes to rest in the run, beside the equilibrium at its last speed."""
    speed = float(run.readings["spindle_speed"][-1])
    low, high = design.travel.arm_angles
    lifts = [one.readings["sleeve_lift"] for one in find_equilibria(scene, speed) if low <= one.coordinate <= high]
    wanted, found = lifts[-1] if lifts else design.travel.lift, float(run.readings["sleeve_lift"][-1])
    yield ComparedNumber(
        quantity=f"lift at {speed / RPM:.6g} rpm",
        unit="mm",
        wanted=1e3 * wanted,
        found=1e3 * found,
        by="run",
        tolerance=REST_TOLERANCE,
        scale=1e3 * design.travel.lift,
    )
