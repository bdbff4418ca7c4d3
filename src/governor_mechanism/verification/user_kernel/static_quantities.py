"""Quantities of statics that a kernel may compute: equilibrium, stiffness, frequencies, insensitivity, controlling force."""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.engines.rotating_part import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
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
from governor_mechanism.verification.user_kernel.simulated import Column, Input, Quantity, Simulated, evaluate_with_rounding

SPEED = "spindle_speed"
SLEEVE = "sleeve_lift"
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


def _reading_columns(mechanism: Mechanism, results: Mapping[str, FloatArray]) -> dict[str, Column]:
    return {one.name: Column(results[one.name], READING_UNITS[one.quantity]) for one in mechanism.readings}


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
        arguments[SPEED] = Column(results[SPEED], "rad/s")
        arguments["spindle_inertia"] = Column(np.full(len(positions), reduction.free_spindle_inertia), "kg m^2")
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
        arguments={SPEED: Column(inputs[SPEED], "rad/s")},
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
    arguments = {**_reading_columns(mechanism, readings), RESISTANCE: Column(resistances, unit)}
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
    arguments = {**_reading_columns(mechanism, results), SPEED: Column(results[SPEED], "rad/s")}
    return Simulated(values=results[""], errors=errors, arguments=arguments)
