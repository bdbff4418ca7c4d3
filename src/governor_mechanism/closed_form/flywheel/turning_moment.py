"""Work that a flywheel stores under a given turning moment and a constant load: of one harmonic, or of straight lines.

References
----------
R. S. Khurmi and J. K. Gupta, Theory of Machines, and T. Bevan, The Theory of Machines, chapters on turning-moment diagrams.
"""

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


def harmonic_energy(*, amplitude: FloatOrArray, order: FloatOrArray) -> FloatOrArray:
    """Return the work stored between lowest and highest speed by a torque of one harmonic, 2 A / n.

    Parameters
    ----------
    amplitude
        Amplitude A of the torque, N m.
    order
        Its number n of periods in a turn.

    Returns
    -------
    FloatOrArray
        Work, J.
    """
    torque = validate_argument(amplitude, "amplitude", "N m", greater_than=0.0)
    return as_scalar_or_array(2 * torque / validate_argument(order, "order", "", greater_than=0.0))


def table_energy(*, angles: FloatArray, torques: FloatArray) -> float:
    """Return the work stored between lowest and highest speed by a torque of straight lines, under a constant load.

    Parameters
    ----------
    angles
        Angles (n,) of the corners, rad, ascending; the last one is a period after the first.
    torques
        Torques (n,) at the corners, N m; a step has two corners at one angle.

    Returns
    -------
    float
        Work, J.

    Raises
    ------
    MechanismError
        If the angles do not ascend, or the two arrays do not fit.
    """
    corners, values = validate_argument(angles, "angles", "rad"), validate_argument(torques, "torques", "N m")
    steps = np.diff(corners)
    if corners.ndim != 1 or corners.shape != values.shape or corners.size < 2 or np.any(steps < 0) or not corners[-1] > corners[0]:
        raise MechanismError("angles and torques must be lists of equal length, with at least two ascending angles")
    areas = steps * (values[1:] + values[:-1]) / 2
    surplus = values - float(areas.sum()) / (corners[-1] - corners[0])
    stored = np.concatenate([[0.0], np.cumsum(steps * (surplus[1:] + surplus[:-1]) / 2)])
    crossing = np.flatnonzero(surplus[1:] * surplus[:-1] < 0)  # an extremum lies inside these lines
    inside = surplus[crossing] ** 2 * steps[crossing] / (2 * (surplus[crossing] - surplus[crossing + 1]))
    return float(np.ptp(np.concatenate([stored, stored[crossing] + inside])))
