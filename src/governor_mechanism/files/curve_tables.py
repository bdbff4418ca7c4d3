"""Curves over the travel of a mechanism, and its kinematics, as tables."""

from dataclasses import fields

import numpy as np

from governor_mechanism.files.table import make_data_frame
from governor_mechanism.mechanics.kinematics.kinematic_analysis import Kinematics
from governor_mechanism.statics.controlling_force import ControllingForce
from governor_mechanism.statics.linearisation import Linearisation
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.types import DataFrame

_CURVE_COLUMNS = ("speed", "has_equilibrium", "stiffness", "frequency_squared", "free_frequency_squared", "stable", "astatic")
_BAND_COLUMNS = ("falling_speed", "rising_speed", "insensitivity")


def tabulate_speed_curve(curve: SpeedCurve) -> DataFrame:
    """Return a speed curve as a table of pandas.

    Result: readings and quantities of the curve, and of the insensitivity band if it has one, SI, by the
    leading coordinate. Raises MechanismError if pandas is not installed.
    """
    columns = {curve.coordinate_name: curve.coordinate, **curve.readings}
    columns |= {name: getattr(curve, name) for name in _CURVE_COLUMNS}
    if curve.insensitivity_band is not None:
        columns |= {name: getattr(curve.insensitivity_band, name) for name in _BAND_COLUMNS}
    table = make_data_frame(columns, index=curve.coordinate_name)
    table.attrs |= {"folds": curve.folds, "poles": curve.poles}
    return table


def tabulate_modes(linearisation: Linearisation) -> DataFrame:
    """Return the modes of linearised equations as a table of pandas.

    Result: by row: growth rate and frequency, the real and imaginary part of the eigenvalue, with its error
    (1/s), natural frequency (rad/s) and damping ratio. Raises MechanismError if pandas is not installed.
    """
    modes = linearisation.modes
    columns: dict[str, list[float]] = {
        "growth_rate": [mode.eigenvalue.real for mode in modes],
        "frequency": [mode.eigenvalue.imag for mode in modes],
    }
    names = ("error_estimate", "natural_frequency", "damping_ratio", "is_conserved")
    return make_data_frame(columns | {name: [getattr(mode, name) for mode in modes] for name in names})


def tabulate_controlling_force(curve: ControllingForce) -> DataFrame:
    """Return a controlling force as a table of pandas.

    Result: all quantities along the travel, SI, by the leading coordinate. Raises MechanismError if pandas is
    not installed.
    """
    arrays = {field.name: value for field in fields(curve) if isinstance(value := getattr(curve, field.name), np.ndarray)}
    renamed = {"coordinate": curve.coordinate_name, "radius": curve.radius_name, "sleeve": curve.against}
    return make_data_frame({renamed.get(name, name): values for name, values in arrays.items()}, index=curve.coordinate_name)


def tabulate_kinematics(motion: Kinematics) -> DataFrame:
    """Return the kinematics of a mechanism as a table of pandas.

    Result: readings, their rates "rate of ..." and accelerations "acceleration of ...", SI, by the reading
    that drives the mechanism. Raises MechanismError if pandas is not installed.
    """
    columns = {motion.over: motion.values, **motion.readings}
    columns |= {f"rate of {name}": values for name, values in motion.rates.items()}
    columns |= {f"acceleration of {name}": values for name, values in motion.reading_accelerations.items()}
    return make_data_frame(columns, index=motion.over)
