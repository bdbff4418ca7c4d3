"""Quantities at given positions that a kernel may compute: readings, their rates, static forces, gas torque, valve events."""

import math
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import AppliedTorque, CylinderPressure, SpringForce, StaticForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import evaluate_derived_readings
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.observables.static_forces import compute_static_force
from governor_mechanism.observables.valve_motion import ANGLE_TOLERANCE, CYLINDER_ENDS, find_event_angles, has_valve_events, valve_motion_of
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.user_kernel.simulated import ROUNDING, Column, Input, Quantity, Simulated, evaluate_with_rounding

RATE = "rate"
STATIC_SLEEVE_FORCE = "static_sleeve_force"
SLEEVE = "sleeve_lift"
CRANK_ANGLE = "crank_angle"

RATE_UNITS = {"rad": "rad/s", "m": "m/s", "1": "1/s"}
ACCELERATION_UNITS = {"rad": "rad/s^2", "m": "m/s^2", "1": "1/s^2"}


def position_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield the readings and forces of a scene of one part over its leading reading, and the rates of its readings."""
    mechanism = scene.part.mechanism
    leading = _leading_reading(mechanism)
    if leading not in (reading.name for reading in mechanism.readings):
        return
    unit = READING_UNITS[mechanism.reading(leading).quantity]
    place = {leading: Input(unit)}
    moving = {**place, RATE: Input(RATE_UNITS[unit], 1.0)}
    names = tuple(reading.name for reading in mechanism.readings)
    for reading in mechanism.readings:
        others = tuple(name for name in names if name != reading.name)
        base = READING_UNITS[reading.quantity]
        if reading.name != leading:
            yield _make(reading.name, base, f"{_words(reading.name)} at a position", place, others)
            rate, acceleration = RATE_UNITS[base], ACCELERATION_UNITS[base]
            what = f"of {_words(reading.name)} while {leading} changes at a constant rate (1 in SI unless given)"
            yield _make(f"rate_of_{reading.name}", rate, f"first time derivative {what}", moving, names)
            yield _make(f"acceleration_of_{reading.name}", acceleration, f"second time derivative {what}", moving, names)
    for name, derived_unit in _derived_units(scene).items():
        yield _make(name, derived_unit, f"{_words(name)} at a position", place, names)


def _leading_reading(mechanism: Mechanism) -> str:
    """Return the name of the reading over which the mechanism moves: the angle of a driven crank, or the leading coordinate."""
    has_crank = any(reading.name == CRANK_ANGLE for reading in mechanism.readings)
    return CRANK_ANGLE if has_crank and mechanism.count_drivers() else mechanism.coordinate


def _make(name: str, unit: str, description: str, inputs: Mapping[str, Input], arguments: tuple[str, ...]) -> Quantity:
    evaluate = partial(_evaluate_at_positions, name=name)
    return Quantity(name=name, unit=unit, description=description, inputs=inputs, arguments=arguments, evaluate=evaluate)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _derived_units(scene: Scene) -> dict[str, str]:
    """Return the units of the derived readings that follow from the position alone, and of the static force at the sleeve."""
    units = {}
    for output in scene.part.mechanism.derived_readings:
        match output:
            case SpringForce() | StaticForce():
                units[output.name] = "N"
            case AppliedTorque():
                units[output.name] = "N m"
            case CylinderPressure():
                units[output.name] = "Pa"
    has_sleeve = any(reading.name == SLEEVE for reading in scene.part.mechanism.readings)
    if has_sleeve and not scene.part.mechanism.count_drivers():
        units.setdefault(STATIC_SLEEVE_FORCE, "N")
    return units


def _evaluate_at_positions(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, name: str) -> Simulated:
    """Assemble the mechanism at positions (n,) and return a reading, its rate or acceleration, or a force."""
    mechanism = scene.part.mechanism
    leading = _leading_reading(mechanism)
    positions = inputs[leading]
    rates = inputs.get(RATE, np.ones(len(positions)))
    values, errors = np.empty(len(positions)), np.empty(len(positions))
    readings = {one.name: np.empty(len(positions)) for one in mechanism.readings}
    for rate in np.unique(rates):
        rows = rates == rate
        results, row_errors = evaluate_with_rounding(partial(_solve, scene, name, float(rate)), positions[rows], name)
        values[rows], errors[rows] = results[name], row_errors
        for reading, column in readings.items():
            column[rows] = results[reading]
    units = {one.name: READING_UNITS[one.quantity] for one in mechanism.readings}
    arguments = {reading: Column(column, units[reading]) for reading, column in readings.items() if reading != name}
    arguments[RATE] = Column(rates, RATE_UNITS[units[leading]])
    # A reading that passes zero is as exact there as elsewhere, relative to the largest value.
    return Simulated(values=values, errors=errors, arguments=arguments, scale=float(np.max(np.abs(values))) or None)


def _solve(scene: Scene, name: str, rate: float, points: FloatArray) -> dict[str, FloatArray]:
    """Return all readings (n,) at positions (n,), and the quantity of a name."""
    mechanism: Mechanism = scene.part.mechanism
    motion = solve_kinematics(scene, _leading_reading(mechanism), points, rate)
    results = dict(motion.readings)
    derived = {one.name for one in mechanism.derived_readings}
    if name in derived:
        nothing = np.zeros(len(points))
        lags = np.zeros((len(points), 0))
        states = StateHistory(
            times=nothing, poses=motion.poses, velocities=motion.velocities, work=nothing, dissipated_energy=nothing, lags=lags
        )
        results[name] = evaluate_derived_readings(scene, states)[name]
    elif name == STATIC_SLEEVE_FORCE:
        results[name] = compute_static_force(scene, SLEEVE, motion.poses)
    elif name.startswith("rate_of_"):
        results[name] = motion.rates[name.removeprefix("rate_of_")]
    elif name.startswith("acceleration_of_"):
        results[name] = motion.reading_accelerations[name.removeprefix("acceleration_of_")]
    return results


def valve_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield the events, leads and the travel of the valve of a scene; none without a valve."""
    if not has_valve_events(scene):
        return
    for event in find_event_angles(scene):
        name = event.replace(" ", "_").replace("-", "_")
        description = f"crank angle of the {event}, from 0 to 360 deg; compared modulo a turn"
        yield Quantity(
            name=name,
            unit="rad",
            description=description,
            inputs={},
            arguments=(),
            evaluate=partial(_evaluate_event, event=event),
            period=math.tau,
        )
    for end in CYLINDER_ENDS:
        description = f"opening of the steam port of the {end} at its dead centre"
        lead_of = partial(_evaluate_valve, end=end)
        yield Quantity(name=f"{end.replace(' ', '_')}_lead", unit="m", description=description, inputs={}, arguments=(), evaluate=lead_of)
    description = "travel of the valve from one extreme to the other"
    yield Quantity(name="valve_travel", unit="m", description=description, inputs={}, arguments=(), evaluate=_evaluate_valve)


def _evaluate_event(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, event: str) -> Simulated:
    """Return the crank angle (1,) of an event; Newton's method ends within its tolerance."""
    angles = find_event_angles(scene)
    return Simulated(values=np.array([angles[event]]), errors=np.array([ANGLE_TOLERANCE]), arguments={}, scale=1.0)


def _evaluate_valve(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, end: str = "") -> Simulated:
    """Return the lead (1,) at an end of the cylinder, m, or the travel of the valve without one."""
    motion = valve_motion_of(scene)
    travel = motion.travel
    value = motion.leads[CYLINDER_ENDS.index(end)] if end else travel
    # The turn is interpolated to about 1e-11 of the travel, see `valve_motion.N_NODES`; leads are assembled themselves.
    error = ROUNDING * travel if end else 1e-11 * travel
    return Simulated(values=np.array([value]), errors=np.array([error]), arguments={}, scale=travel)
