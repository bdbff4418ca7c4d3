"""The engine with a flywheel against Redtenbacher's closed forms: pressures, torque, stored work, speed, angles of extreme speed."""

import math
from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from governor_mechanism.closed_form import flywheel_engine as closed
from governor_mechanism.closed_form.flywheel import speed_after_work
from governor_mechanism.closed_form.flywheel_equilibrium import find_equilibria
from governor_mechanism.effects.gas_pressure import gas_work
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.verification.machines import comparisons
from governor_mechanism.verification.report import ComparisonRow

ANGLE_TOLERANCE = 1e-8
"""Tolerance of an angle of extreme speed, rad: at it the torque vanishes with a slope, so that rounding alone moves it."""


CLOSED_CYCLE_TOLERANCE = 1e-9
"""Work that a closed cycle may gain in a stroke, relative to that of the supply pressure over it: well above rounding."""


def check_flywheel_engine(scene: Scene) -> comparisons.Checks:
    """Yield every comparison that applies to the scene."""
    if reason := _refusal(scene):
        yield f"the closed forms of the engine are for {reason}: only the energy balance is checked"
        run = comparisons.run_scene(scene)
        yield from comparisons.note_early_end(run)
        yield comparisons.compare_jacobi_integral(run)
        return
    engine, run = build_air_engine(scene), comparisons.run_scene(scene)
    yield from comparisons.note_early_end(run)
    yield comparisons.compare_algebraic(
        "work of the gas in a stroke", _simulated_work_per_stroke(scene), closed.gas_work(engine), "J", engine.full_pressure_work
    )
    if len(run.times) < 2:
        return
    yield from _compare_motion(run, engine)
    if abs(closed.net_work(engine)) <= CLOSED_CYCLE_TOLERANCE * engine.full_pressure_work:
        yield from _compare_extreme_angles(run, engine)
    else:
        yield "the cycle does not close: the speeds of the last turn are not those of a periodic motion, and their angles are not checked"
    yield comparisons.compare_jacobi_integral(run)


def _refusal(scene: Scene) -> str:
    """Return what the closed forms need and the scene has not; empty if they apply."""
    dimensions = scene.part.dimensions
    if scene.effects:
        return "an engine without reciprocating masses and other effects"
    if not all(math.isinf(dimensions[rod]) for rod in ("connecting_rod", "pump_connecting_rod")):
        return "infinite connecting rods"
    if math.isinf(dimensions["pump_area"]):
        return "an engine with a pump"
    if not (math.isinf(dimensions["load_torque"]) and math.isinf(dimensions["load_damping"])):
        return "a constant load, given by load_pressure"
    return ""


def build_air_engine(scene: Scene) -> closed.AirEngine:
    """Return the closed form's engine."""
    return closed.AirEngine(**{field.name: scene.part.dimensions[field.name] for field in fields(closed.AirEngine)})


def _simulated_work_per_stroke(scene: Scene) -> float:
    """Return the work of the gas of the mechanism in a stroke, J."""
    gases = [element for element in scene.part.mechanism.force_elements if isinstance(element, CylinderGas)]
    return sum(float(gas_work(gas.coefficients, gas.stroke, math.pi)) for gas in gases)


def _compare_motion(run: Trajectory, engine: closed.AirEngine) -> Iterator[ComparisonRow]:
    """Yield torque, pressures, stored work and speed at the crank angles of the run."""
    angles = run.readings["crank_angle"]
    inertia = run.scene.part.dimensions["inertia"]
    yield comparisons.compare_reading(run, "gas_torque", closed.gas_torque(engine, crank_angle=angles))
    for name, pressure in (
        ("expansion_pressure", closed.expansion_pressure),
        ("suction_pressure", closed.suction_pressure),
        ("delivery_pressure", closed.delivery_pressure),
    ):
        yield comparisons.compare_reading(run, name, pressure(engine, crank_angle=angles))
    work = np.asarray(closed.stored_work(engine, crank_angle=angles)) - closed.stored_work(engine, crank_angle=float(angles[0]))
    yield comparisons.compare_reading(run, "stored_work", work)
    speed = speed_after_work(inertia=inertia, start_speed=float(run.readings["shaft_speed"][0]), work=work)
    yield comparisons.compare_reading(run, "shaft_speed", speed)


def _compare_extreme_angles(run: Trajectory, engine: closed.AirEngine) -> Iterator[ComparisonRow]:
    """Yield the angles of lowest and highest speed in the last turn, alpha and beta of the paper."""
    equilibria = find_equilibria(engine)
    reason = "the torque vanishes there with a slope, whatever the speed"
    for extremes in run.speed_fluctuations.values():
        for name, found, is_slowest in (("lowest", extremes.lowest_angle, True), ("highest", extremes.highest_angle, False)):
            expected = [one.angle for one in equilibria if one.is_slowest == is_slowest]
            simulated = found % math.pi
            nearest = min(expected, key=lambda angle: abs(angle - simulated))
            yield ComparisonRow(f"angle of {name} speed in a stroke", simulated, nearest, ANGLE_TOLERANCE, "rad", reason)
