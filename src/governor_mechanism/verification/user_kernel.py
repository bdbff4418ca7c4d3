"""Comparison of the assembled mechanism with a user's function."""

import inspect
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.kinematic_analysis import validate_samples
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value
from governor_mechanism.verification.report import CheckReport, ComparisonRow

KERNEL_RELATIVE_TOLERANCE = 1e-6
"""Relative tolerance of a kernel: far above the error of the simulation (1e-11), far below that of a wrong formula."""


def check_kernel(
    scene: Scene,
    kernel: Callable[..., float],
    quantity: str,
    over: Mapping[str, Sequence[float] | FloatArray],
    allowed: float = KERNEL_RELATIVE_TOLERANCE,
) -> CheckReport:
    """Compare a function with the assembled mechanism over values of its leading coordinate.

    Parameters
    ----------
    scene
        The scene with the mechanism.
    kernel
        Function of floats in SI. Its parameters are matched by name: dimensions, `gravity`, and readings of the mechanism.
    quantity
        What the kernel returns: "equilibrium_speed" (rad/s) or the name of a position reading.
    over
        Values of the leading coordinate by its name, SI; shape (n,).
    allowed
        Tolerance relative to the mechanism's value, or to the largest value where that is zero.

    Returns
    -------
    CheckReport
        One row per value.
    """
    coordinate, values = _validate_coordinate_values(scene, over)
    poses = _assemble_poses(scene, values)
    mechanism_values, unit = _evaluate_quantity(scene, quantity, values, poses)
    kernel_arguments = _select_kernel_arguments(kernel, _available_arguments(scene, values, poses))
    largest_value = float(np.max(np.abs(mechanism_values)))
    rows = []
    for index, (value, mechanism_value) in enumerate(zip(values.tolist(), mechanism_values.tolist(), strict=True)):
        label, arguments = f"{coordinate} = {value:.6g}", {name: float(column[index]) for name, column in kernel_arguments.items()}
        kernel_value = _evaluate_kernel(kernel, arguments, label)
        tolerance = allowed * (abs(mechanism_value) or largest_value)
        reason = "the requested relative tolerance"
        rows.append(ComparisonRow(f"{quantity} at {label}", mechanism_value, kernel_value, tolerance, unit, reason))
    return CheckReport(title=scene.title, against=getattr(kernel, "__name__", "kernel"), rows=tuple(rows))


def _validate_coordinate_values(scene: Scene, over: Mapping[str, Sequence[float] | FloatArray]) -> tuple[str, FloatArray]:
    """Return the name and the values of the leading coordinate; raise MechanismError for values outside the travel."""
    coordinate = scene.part.mechanism.coordinate
    if list(over) != [coordinate]:
        raise MechanismError(f"`over` must give values of {coordinate!r}, the leading coordinate; got {list(over)}")
    values = validate_samples(coordinate, over[coordinate])
    for limit in scene.part.mechanism.limits:
        outside = values[(values <= limit.low) | (values >= limit.high)]
        if limit.reading == coordinate and outside.size:
            raise MechanismError(f"{coordinate} = {outside[0]:.6g} is outside the travel, {limit.low:.6g} to {limit.high:.6g} in SI")
    return coordinate, values


def _assemble_poses(scene: Scene, values: FloatArray) -> FloatArray:
    """Return the poses (n, bodies, 3) at the values of the leading coordinate."""
    assembler = PositionSolver(scene.part.mechanism)
    poses: list[FloatArray] = []
    for value in values:
        poses.append(assembler.solve_at_coordinate(float(value), guess=poses[-1] if poses else None))
    return np.array(poses)


def _evaluate_quantity(scene: Scene, quantity: str, values: FloatArray, poses: FloatArray) -> tuple[FloatArray, str]:
    """Return the quantity of the mechanism (n,) and its unit."""
    if quantity == "equilibrium_speed":
        return equilibrium_speed_at(scene, values), "rad/s"
    mechanism = scene.part.mechanism
    names = [reading.name for reading in mechanism.readings]
    if quantity not in names:
        known = ["equilibrium_speed", *names]
        raise MechanismError(f"unknown quantity {quantity!r}; available: {known}.{did_you_mean(quantity, known)}")
    return evaluate_output_value(mechanism, quantity, poses), "rad" if mechanism.reading(quantity).quantity == "angle" else "m"


def _available_arguments(scene: Scene, values: FloatArray, poses: FloatArray) -> dict[str, FloatArray]:
    """Return what a kernel may take, by name: dimensions, gravity and readings, each of shape (n,)."""
    mechanism, constants = scene.part.mechanism, {**scene.part.dimensions, "gravity": scene.gravity}
    columns = {name: np.full(values.shape, number) for name, number in constants.items()}
    return columns | {reading.name: evaluate_output_value(mechanism, reading.name, poses) for reading in mechanism.readings}


def _select_kernel_arguments(kernel: Callable[..., float], available: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return the arguments that the kernel's parameters name; raise MechanismError for a parameter without a value."""
    selected = {}
    for name, parameter in inspect.signature(kernel).parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
            raise MechanismError(f"the kernel's parameter {name!r} cannot be matched by name; use plain named parameters")
        if name in available:
            selected[name] = available[name]
        elif parameter.default is parameter.empty:
            known = sorted(available)
            raise MechanismError(f"the kernel has an unknown parameter {name!r}; available: {known}.{did_you_mean(name, known)}")
    return selected


def _evaluate_kernel(kernel: Callable[..., float], arguments: Mapping[str, float], label: str) -> float:
    """Return the kernel's value; NaN for a result that is not finite, so that only its row fails."""
    try:
        result = np.asarray(kernel(**arguments))
    except Exception as error:
        error.add_note(f"raised by the kernel at {label}, called with {dict(arguments)}")
        raise
    if result.size != 1 or result.dtype.kind not in "iuf":
        raise MechanismError(f"the kernel must return one real number; at {label} it returned {format_value(result.tolist())}")
    number = float(result.ravel()[0])
    return number if math.isfinite(number) else math.nan
