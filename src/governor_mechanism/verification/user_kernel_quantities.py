"""Quantities of a run that a kernel may compute: readings over time, and the speed fluctuation of an engine."""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.effects.gas_pressure import work_per_stroke
from governor_mechanism.engines import select_engine
from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.kinematic_analysis import solve_kinematics
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.coupling.coupled_system import SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import AppliedTorque, CylinderPressure, SpringForce, StaticForce
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import compute_static_force, evaluate_derived_readings, mean_gas_torque
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.observables.valve_motion import ANGLE_TOLERANCE, CYLINDER_ENDS, find_event_angles, has_valve_events, valve_motion_of
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import (
    equilibrium_speed_squared,
    evaluate_readings,
    evaluate_stability,
    has_equilibrium_speed,
    validate_coordinate_values,
)
from governor_mechanism.statics.speed_curve import compute_insensitivity_band, equilibrium_speed_at
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.user_kernel_simulation import ROUNDING, Input, Quantity, Series, Simulated, evaluate_with_rounding

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
    arguments = {reading: Series(column, units[reading]) for reading, column in readings.items() if reading != name}
    arguments[RATE] = Series(rates, RATE_UNITS[units[leading]])
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


SPEED = "spindle_speed"
RESISTANCE = "resistance"

StaticFormula = Callable[[SingleDofReduction, PathCoefficients, FloatArray], FloatArray]
"""Function of the reduction, its coefficients and the squared spindle speed (n,), rad2/s2."""


def static_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield the quantities of statics that a scene of one part has."""
    if not has_equilibrium_speed(scene):
        return
    mechanism = scene.part.mechanism
    names = tuple(reading.name for reading in mechanism.readings)
    is_angle = mechanism.reading(mechanism.coordinate).quantity == "angle"
    place = {mechanism.coordinate: Input(_unit_of(mechanism, mechanism.coordinate))}
    at_speed = {**place, SPEED: Input("rad/s", math.nan)}
    yield Quantity(
        name="equilibrium_speed",
        unit="rad/s",
        description="spindle speed that holds the position",
        inputs=place,
        arguments=names,
        evaluate=partial(_evaluate_formula, formula=_speed),
    )
    yield Quantity(
        name="equilibrium_angle" if is_angle else "equilibrium_position",
        unit=_unit_of(mechanism, mechanism.coordinate),
        description=f"{mechanism.coordinate} of the stable equilibrium at a spindle speed",
        inputs={SPEED: Input("rad/s")},
        arguments=(),
        evaluate=_evaluate_equilibrium,
    )
    formulas: tuple[tuple[str, str, StaticFormula, str], ...] = (
        ("stiffness", "N m/rad" if is_angle else "N/m", _stiffness, "stiffness along the leading coordinate, at constant spindle speed"),
        ("oscillation_frequency", "rad/s", _frequency, "frequency of small oscillations without damping, at constant spindle speed"),
        ("oscillation_frequency_free_spindle", "rad/s", _free_frequency, "the same with a spindle that turns freely"),
    )
    for name, unit, formula, description in formulas:
        yield Quantity(
            name=name,
            unit=unit,
            description=description + "; at the equilibrium speed unless one is given",
            inputs=at_speed,
            arguments=(*names, SPEED, *(["spindle_inertia"] if formula is _free_frequency else [])),
            evaluate=partial(_evaluate_formula, formula=formula),
            is_frequency=formula is not _stiffness,
        )
    yield from _sleeve_quantities(mechanism, place, names)


def _sleeve_quantities(mechanism: Mechanism, place: Mapping[str, Input], names: tuple[str, ...]) -> Iterator[Quantity]:
    """Yield the quantities of friction at the sleeve, and the controlling force."""
    if SLEEVE in names:
        unit = "N m" if mechanism.reading(SLEEVE).quantity == "angle" else "N"
        bands = (
            ("insensitivity", "1", "range of speed within which the resistance holds the sleeve, over the equilibrium speed"),
            ("rising_speed", "rad/s", "speed above which the governor rises against the resistance"),
            ("falling_speed", "rad/s", "speed below which it falls"),
        )
        for name, result_unit, description in bands:
            yield Quantity(
                name=name,
                unit=result_unit,
                description=description,
                inputs={**place, RESISTANCE: Input(unit)},
                arguments=names,
                evaluate=partial(_evaluate_band, field=name),
            )
    yield Quantity(
        name="controlling_force",
        unit="N",
        description="controlling force of one ball: the centripetal force that the loads exert on it",
        inputs=place,
        arguments=(*names, SPEED),
        evaluate=_evaluate_controlling_force,
    )


def _unit_of(mechanism: Mechanism, name: str) -> str:
    return READING_UNITS[mechanism.reading(name).quantity]


def _reading_columns(mechanism: Mechanism, results: Mapping[str, FloatArray]) -> dict[str, Series]:
    return {one.name: Series(results[one.name], READING_UNITS[one.quantity]) for one in mechanism.readings}


def _evaluate_formula(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, formula: StaticFormula) -> Simulated:
    """Evaluate a formula of the Lagrangian coefficients at positions (n,), at the equilibrium speed where none is given."""
    reduction = SingleDofReduction(rotating_part_alone(scene))
    mechanism = reduction.mechanism
    positions = validate_coordinate_values(reduction, inputs[mechanism.coordinate])
    given_speed = inputs.get(SPEED, np.full(len(positions), np.nan))

    def evaluate(points: FloatArray) -> dict[str, FloatArray]:
        """Return readings, the result (as "") and the equilibrium speed, SI, at points (m,) of the coordinate."""
        coefficients = reduction.evaluate(points)
        speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
        given = np.repeat(given_speed, len(points) // len(positions))
        speed_squared = np.where(np.isnan(given), speed_squared, given**2)
        if not np.all(speed_squared >= 0.0):
            equilibrium_speed_at(reduction.scene, points)  # it raises with the reason
        results = evaluate_readings(mechanism, coefficients)
        return {**results, "": formula(reduction, coefficients, speed_squared), SPEED: np.sqrt(speed_squared)}

    results, errors = evaluate_with_rounding(evaluate, positions, "")
    arguments = _reading_columns(mechanism, results)
    if formula is not _speed:
        arguments[SPEED] = Series(results[SPEED], "rad/s")
        arguments["spindle_inertia"] = Series(np.full(len(positions), reduction.free_spindle_inertia), "kg m^2")
    return Simulated(values=results[""], errors=errors, arguments=arguments)


def _speed(reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: FloatArray) -> FloatArray:
    if not np.all(speed_squared > 0.0):
        equilibrium_speed_at(reduction.scene, coefficients.coordinate)
    return np.sqrt(speed_squared)


def _stiffness(reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: FloatArray) -> FloatArray:
    return evaluate_stability(coefficients, speed_squared)[0]


def _frequency(reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: FloatArray) -> FloatArray:
    return _root_of_stable(reduction, coefficients, evaluate_stability(coefficients, speed_squared)[0] / coefficients.inertia)


def _free_frequency(reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: FloatArray) -> FloatArray:
    squared = evaluate_stability(coefficients, speed_squared)[0] / coefficients.inertia
    product = (reduction.free_spindle_inertia + coefficients.spindle_inertia) * coefficients.inertia
    return _root_of_stable(reduction, coefficients, squared + speed_squared * coefficients.spindle_inertia_derivative**2 / product)


def _root_of_stable(reduction: SingleDofReduction, coefficients: PathCoefficients, squared: FloatArray) -> FloatArray:
    """Return the square roots (n,); raise MechanismError where a small motion does not oscillate."""
    if np.any(squared <= 0.0):
        place = float(coefficients.coordinate[np.argmax(squared <= 0.0)])
        name = reduction.mechanism.coordinate
        raise MechanismError(f"at {name} = {place:.6g} the equilibrium is not stable: a small motion has no frequency; leave it out")
    return np.sqrt(squared)


def _evaluate_equilibrium(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float) -> Simulated:
    """Return the position (n,) of the only stable equilibrium at each speed."""
    alone = rotating_part_alone(scene)
    found = [_only_stable(alone, float(speed)) for speed in inputs[SPEED]]
    return Simulated(
        values=np.array([one.coordinate for one in found]),
        errors=np.array([one.uncertainty for one in found]),
        arguments={SPEED: Series(inputs[SPEED], "rad/s")},
    )


def _only_stable(scene: Scene, speed: float) -> Equilibrium:
    stable = [one for one in find_equilibria(scene, speed) if one.stable]
    if len(stable) != 1:
        raise MechanismError(
            f"at {speed:.6g} rad/s the mechanism has {len(stable)} stable equilibria; a kernel needs one: change the speed"
        )
    return stable[0]


def _evaluate_band(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, field: str) -> Simulated:
    """Return a field of the insensitivity band (n,) at positions and resistances (n,)."""
    reduction = SingleDofReduction(rotating_part_alone(scene))
    mechanism, resistances = reduction.mechanism, inputs[RESISTANCE]
    positions = validate_coordinate_values(reduction, inputs[mechanism.coordinate])
    values, errors = np.empty_like(positions), np.empty_like(positions)
    readings = {one.name: np.empty_like(positions) for one in mechanism.readings}
    for resistance in np.unique(resistances):

        def evaluate(points: FloatArray, resistance: float = float(resistance)) -> dict[str, FloatArray]:
            band = compute_insensitivity_band(reduction.scene, points, resistance, SLEEVE)
            return {**evaluate_readings(mechanism, reduction.evaluate(points)), "": getattr(band, field)}

        rows = resistances == resistance
        results, row_errors = evaluate_with_rounding(evaluate, positions[rows], "")
        values[rows], errors[rows] = results[""], row_errors
        for name, column in readings.items():
            column[rows] = results[name]
    unit = "N m" if mechanism.reading(SLEEVE).quantity == "angle" else "N"
    arguments = {**_reading_columns(mechanism, readings), RESISTANCE: Series(resistances, unit)}
    return Simulated(values=values, errors=errors, arguments=arguments)


def _evaluate_controlling_force(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float) -> Simulated:
    """Return the controlling force (n,) of one ball at positions (n,)."""
    reduction = SingleDofReduction(rotating_part_alone(scene))
    mechanism = reduction.mechanism
    against = SLEEVE if any(one.name == SLEEVE for one in mechanism.readings) else mechanism.coordinate

    def evaluate(points: FloatArray) -> dict[str, FloatArray]:
        """Return readings, the result (as "") and the equilibrium speed, SI, at points (m,) of the coordinate."""
        force = compute_controlling_force(reduction.scene, points, against=against)
        return {**evaluate_readings(mechanism, reduction.evaluate(points)), "": force.force, SPEED: force.speed}

    positions = validate_coordinate_values(reduction, inputs[mechanism.coordinate])
    results, errors = evaluate_with_rounding(evaluate, positions, "")
    arguments = {**_reading_columns(mechanism, results), SPEED: Series(results[SPEED], "rad/s")}
    return Simulated(values=results[""], errors=errors, arguments=arguments)


TIME = "time"
RATE_PREFIX = "rate_of_"

MIN_ACCURACY = 1e-10
"""Accuracy of a run below which engines may not certify it."""


def run_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield every reading of a run, and its rate, over time."""
    units = {reading.name: READING_UNITS[reading.quantity] for reading in scene.mechanism.readings}
    rates = {RATE_PREFIX + name: "1/s" if unit == "1" else f"{unit}/s" for name, unit in units.items()}
    units |= {one.name: one.unit for one in scene.mechanism.derived_readings}
    for plane in scene.system.planes:
        units |= {plane.prefix + SPINDLE_SPEED: "rad/s", plane.prefix + SPINDLE_TORQUE: "N m"}
    for name, unit in (units | rates).items():
        yield Quantity(
            name=name,
            unit=unit,
            description=f"{name.replace('_', ' ')} in a run of the scene",
            inputs={TIME: Input("s")},
            arguments=tuple(other for other in units | rates if other != name),
            evaluate=partial(_evaluate_in_run, name=name),
        )


def engine_quantities(scene: Scene) -> Iterator[Quantity]:
    """Yield the mean gas torque and the fluctuation of speed and energy of an engine that gas drives; none for other scenes."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    if not gases or any(gas.strokes_differ for gas in gases):
        return
    yield Quantity(
        name="mean_gas_torque",
        unit="N m",
        description="mean torque of the gas over a stroke",
        inputs={},
        arguments=(),
        evaluate=_evaluate_mean_torque,
    )
    yield Quantity(
        name="speed_fluctuation",
        unit="1",
        description="coefficient of speed fluctuation in the last turn of a run, (highest - lowest) / mean",
        inputs={},
        arguments=(),
        evaluate=partial(_evaluate_fluctuation, is_energy=False),
    )
    if not scene.effects and len(scene.parts) == 1:  # reciprocating masses would store work too
        yield Quantity(
            name="energy_fluctuation",
            unit="J",
            description="work that the flywheel stores between lowest and highest speed in the last turn of a run",
            inputs={},
            arguments=(),
            evaluate=partial(_evaluate_fluctuation, is_energy=True),
        )


def _run(scene: Scene, times: FloatArray | None, accuracy: float) -> Trajectory:
    requested = max(MIN_ACCURACY, min(scene.run.accuracy, accuracy))
    engine, reason = select_engine(scene.run.engine, scene, requested)
    return engine.run(scene, times=times, accuracy=requested, reason=reason)


def _note_early_end(run: Trajectory) -> tuple[str, ...]:
    return () if run.outcome.ok else (f"the run is compared as far as it went: {run.message}",)


def _evaluate_in_run(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, name: str) -> Simulated:
    """Return a reading (n,) or its rate at times (n,); fewer if the run ends early."""
    run = _run(scene, inputs[TIME], accuracy)
    if not len(run.times):
        raise MechanismError(f"the run has no result to compare: {run.message}")
    columns = {TIME: Series(run.times, "s")}
    columns |= {reading: Series(values, run.units[reading]) for reading, values in run.readings.items()}
    for reading, values in run.rates.items():
        unit = run.units[reading]
        columns[RATE_PREFIX + reading] = Series(values, f"{unit}/s" if unit != "1" else "1/s")
    key = f"rate of {name.removeprefix(RATE_PREFIX)}" if name.startswith(RATE_PREFIX) else name
    values = columns.pop(name).values
    if key not in run.reading_errors:
        raise MechanismError(f"the run has no error estimate for {name}, and proves nothing: {run.message}")
    error = run.reading_errors[key]
    scale = float(run.scales.get(key, np.max(np.abs(values))))
    return Simulated(values=values, errors=np.full(len(values), error), arguments=columns, scale=scale, notes=_note_early_end(run))


def _evaluate_mean_torque(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float) -> Simulated:
    """Return the mean torque (1,) of the gas, N m; the works of the gases partly cancel, and their rounding stays."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    magnitude = sum(abs(work_per_stroke([gas])) for gas in gases)
    return Simulated(values=np.array([mean_gas_torque(scene)]), errors=np.array([ROUNDING * magnitude]), arguments={})


def _evaluate_fluctuation(scene: Scene, inputs: Mapping[str, FloatArray], accuracy: float, *, is_energy: bool) -> Simulated:
    """Return the fluctuation (1,) of speed, or of the kinetic energy of the flywheel, J, in the last turn of a run."""
    run = _run(scene, None, accuracy)
    if not run.outcome.ok or len(run.speed_fluctuations) != 1:
        cause = run.message if not run.outcome.ok else "the shaft makes no complete turn; make the run longer"
        raise MechanismError(f"there is no speed fluctuation to compare: {cause}")
    (extremes,) = run.speed_fluctuations.values()
    error = 2 * run.reading_errors["shaft_speed"]  # of either extreme
    if is_energy:
        inertia = scene.part.dimensions["inertia"]
        value = 0.5 * inertia * (extremes.highest**2 - extremes.lowest**2)
        error = inertia * extremes.mean * error
    else:
        value, error = extremes.coefficient, error / extremes.mean
    return Simulated(values=np.array([value]), errors=np.array([error]), arguments={})
