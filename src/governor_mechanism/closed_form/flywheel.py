"""Work that a flywheel stores under a given turning moment and a constant load: of one harmonic, or of straight lines.

Two means of the speed are in use. The paper's is that whose kinetic energy is the mean of the highest and the lowest (`mean_energy`); the
textbooks' is the arithmetic mean of the highest and the lowest speed. They differ by the square of the coefficient of fluctuation over 8.
All arguments are keywords, floats or arrays that broadcast; floats give a float. SI and radians. Every function raises MechanismError for
a value that is not finite, or not positive where it must be.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equation (68). The rules of coefficient, rim and arms
are those of the textbooks, such as R. S. Khurmi and J. K. Gupta, Theory of Machines, and A Textbook of Machine Design, chapters on
flywheels and, as T. Bevan, The Theory of Machines, on turning-moment diagrams.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


def _positive(value: FloatOrArray, name: str, unit: str) -> FloatArray:
    return validate_argument(value, name, unit, greater_than=0.0)


def inertia_for_energy_ratio(*, energy: FloatOrArray, mean_speed: FloatOrArray, energy_ratio: FloatOrArray) -> FloatOrArray:
    """Return the inertia by the paper's rule (68), J w^2 / 2 = mu E.

    Parameters
    ----------
    energy
        Work E that the flywheel stores between lowest and highest speed, J.
    mean_speed
        Mean speed w by the paper's mean, rad/s.
    energy_ratio
        Ratio mu of the kinetic energy at mean speed to E.

    Returns
    -------
    FloatOrArray
        Moment of inertia, kg m2.
    """
    stored = _positive(energy, "energy", "J") * _positive(energy_ratio, "energy_ratio", "")
    return as_scalar_or_array(2 * stored / _positive(mean_speed, "mean_speed", "rad/s") ** 2)


def inertia_for_coefficient(*, energy: FloatOrArray, mean_speed: FloatOrArray, coefficient: FloatOrArray) -> FloatOrArray:
    """Return the inertia by the textbooks' rule, J = E / (c w^2), exact with the arithmetic mean.

    Parameters
    ----------
    energy
        Work E that the flywheel stores between lowest and highest speed, J.
    mean_speed
        Arithmetic mean w of lowest and highest speed, rad/s.
    coefficient
        Coefficient of speed fluctuation c, (highest - lowest) / mean.

    Returns
    -------
    FloatOrArray
        Moment of inertia, kg m2.
    """
    fluctuation = _positive(coefficient, "coefficient", "")
    return as_scalar_or_array(_positive(energy, "energy", "J") / (fluctuation * _positive(mean_speed, "mean_speed", "rad/s") ** 2))


def coefficient_of_energy_ratio(*, energy_ratio: FloatOrArray) -> FloatOrArray:
    """Return the coefficient of speed fluctuation for the paper's ratio mu: sqrt(1 + 1/2 mu) - sqrt(1 - 1/2 mu), about 1/2 mu.

    Parameters
    ----------
    energy_ratio
        Ratio mu, at least 1/2, where the lowest speed is 0.

    Returns
    -------
    FloatOrArray
        (highest - lowest) / mean speed, by the paper's mean.
    """
    half = 0.5 / validate_argument(energy_ratio, "energy_ratio", "", minimum=0.5)
    return as_scalar_or_array(np.sqrt(1 + half) - np.sqrt(1 - half))


def energy_ratio_of_speeds(*, inertia: FloatOrArray, energy: FloatOrArray, lowest: FloatOrArray, highest: FloatOrArray) -> FloatOrArray:
    """Return the paper's ratio mu of a given flywheel: the mean of its extreme kinetic energies over the work stored between them.

    Parameters
    ----------
    inertia
        Moment of inertia J, kg m2.
    energy
        Work E that the flywheel stores between lowest and highest speed, J.
    lowest
        Lowest speed, rad/s.
    highest
        Highest speed, rad/s.

    Returns
    -------
    FloatOrArray
        The ratio mu.
    """
    squares = validate_argument(lowest, "lowest", "rad/s", minimum=0.0) ** 2 + _positive(highest, "highest", "rad/s") ** 2
    return as_scalar_or_array(_positive(inertia, "inertia", "kg m2") * squares / 4 / _positive(energy, "energy", "J"))


def speed_limits(
    *, inertia: FloatOrArray, energy: FloatOrArray, mean_speed: FloatOrArray, mean_energy: bool = False
) -> tuple[FloatOrArray, FloatOrArray]:
    """Return the lowest and the highest speed of a given flywheel.

    Parameters
    ----------
    inertia
        Moment of inertia J, kg m2.
    energy
        Work that the flywheel stores between lowest and highest speed, J.
    mean_speed
        Mean speed, rad/s.
    mean_energy
        Whether the mean is the paper's; by default it is the arithmetic mean.

    Returns
    -------
    tuple[FloatOrArray, FloatOrArray]
        Lowest and highest speed, rad/s.

    Raises
    ------
    MechanismError
        If the flywheel is too light: it would come to rest.
    """
    mean = _positive(mean_speed, "mean_speed", "rad/s")
    swing = _positive(energy, "energy", "J") / _positive(inertia, "inertia", "kg m2")
    largest = mean**2 if mean_energy else 2 * mean**2
    sentence = "the flywheel is too light: it would come to rest in each stroke"
    raise_where(swing > largest, sentence, ("inertia", inertia, "kg m2"), hint="increase inertia or mean_speed")
    if mean_energy:
        return as_scalar_or_array(np.sqrt(mean**2 - swing)), as_scalar_or_array(np.sqrt(mean**2 + swing))
    return as_scalar_or_array(mean - swing / (2 * mean)), as_scalar_or_array(mean + swing / (2 * mean))


def speed_after_work(*, inertia: FloatOrArray, start_speed: FloatOrArray, work: FloatOrArray) -> FloatOrArray:
    """Return the speed of a shaft after work on it, sqrt(w0^2 + 2 W / J).

    Parameters
    ----------
    inertia
        Moment of inertia J, kg m2.
    start_speed
        Speed w0 before, rad/s.
    work
        Work W on the shaft, J; negative if it gives work.

    Returns
    -------
    FloatOrArray
        Speed, rad/s.

    Raises
    ------
    MechanismError
        If the shaft has not as much energy as it should give.
    """
    start = _positive(start_speed, "start_speed", "rad/s")
    done = validate_argument(work, "work", "J")
    square = start**2 + 2 * done / _positive(inertia, "inertia", "kg m2")
    raise_where(square < 0, "the shaft stalls: its energy is less than the work it should give", ("work", done, "J"))
    return as_scalar_or_array(np.sqrt(square))


def rim_weight(*, energy: FloatOrArray, energy_ratio: FloatOrArray, rim_speed: FloatOrArray, gravity: float) -> FloatOrArray:
    """Return the weight of the rim by (68), G = 2 g mu E / v^2, all inertia being in the rim.

    Parameters
    ----------
    energy
        Work E that the flywheel stores between lowest and highest speed, J.
    energy_ratio
        Ratio mu of the kinetic energy at mean speed to E.
    rim_speed
        Mean speed v of the rim, m/s.
    gravity
        Gravity g, m/s2.

    Returns
    -------
    FloatOrArray
        Weight, N.
    """
    stored = _positive(energy, "energy", "J") * _positive(energy_ratio, "energy_ratio", "")
    return as_scalar_or_array(2 * gravity * stored / _positive(rim_speed, "rim_speed", "m/s") ** 2)


def rim_mass(*, inertia: FloatOrArray, radius: FloatOrArray) -> FloatOrArray:
    """Return the mass of a thin rim, J / R^2.

    Parameters
    ----------
    inertia
        Moment of inertia J of the rim, kg m2.
    radius
        Mean radius R of the rim, m.

    Returns
    -------
    FloatOrArray
        Mass, kg.
    """
    return as_scalar_or_array(_positive(inertia, "inertia", "kg m2") / _positive(radius, "radius", "m") ** 2)


def rim_stress(*, density: FloatOrArray, rim_speed: FloatOrArray) -> FloatOrArray:
    """Return the hoop stress of a thin free rim, rho v^2.

    Parameters
    ----------
    density
        Density rho, kg/m3.
    rim_speed
        Speed v of the middle of the rim, m/s.

    Returns
    -------
    FloatOrArray
        Stress, Pa.
    """
    return as_scalar_or_array(_positive(density, "density", "kg/m3") * _positive(rim_speed, "rim_speed", "m/s") ** 2)


def rim_thickness(*, mass: FloatOrArray, radius: FloatOrArray, density: FloatOrArray, width_ratio: FloatOrArray) -> FloatOrArray:
    """Return the radial thickness of a rim of rectangular section, m = 2 pi R rho b t with the width b in a given ratio to it.

    Parameters
    ----------
    mass
        Mass of the rim, kg.
    radius
        Mean radius R of the rim, m.
    density
        Density rho, kg/m3.
    width_ratio
        Width over thickness, b / t.

    Returns
    -------
    FloatOrArray
        Thickness t, m.
    """
    volume = _positive(mass, "mass", "kg") / _positive(density, "density", "kg/m3")
    section = volume / (math.tau * _positive(radius, "radius", "m"))
    return as_scalar_or_array(np.sqrt(section / _positive(width_ratio, "width_ratio", "")))


def arm_bending_moment(*, torque: FloatOrArray, radius: FloatOrArray, hub_radius: FloatOrArray, arms: FloatOrArray) -> FloatOrArray:
    """Return the bending moment of an arm at the hub, T (R - r) / (R n): a beam fixed in the hub that carries its share of the rim's force.

    Parameters
    ----------
    torque
        Largest torque T between rim and hub, N m.
    radius
        Mean radius R of the rim, m.
    hub_radius
        Radius r of the hub, m.
    arms
        Number n of arms.

    Returns
    -------
    FloatOrArray
        Bending moment, N m.

    Raises
    ------
    MechanismError
        If the hub is not inside the rim.
    """
    rim = _positive(radius, "radius", "m")
    hub = _positive(hub_radius, "hub_radius", "m")
    raise_where(hub >= rim, "hub_radius must be below radius, that of the rim", ("hub_radius", hub, "m"), ("radius", rim, "m"))
    return as_scalar_or_array(_positive(torque, "torque", "N m") * (rim - hub) / (rim * _positive(arms, "arms", "")))


def arm_major_axis(*, bending_moment: FloatOrArray, stress: FloatOrArray) -> FloatOrArray:
    """Return the major axis of an elliptical arm twice as deep as wide, from M = stress pi a^3 / 64.

    Parameters
    ----------
    bending_moment
        Bending moment M, N m.
    stress
        Allowed bending stress, Pa.

    Returns
    -------
    FloatOrArray
        Major axis a, m, in the plane of the wheel; the minor one is a / 2.
    """
    moment = _positive(bending_moment, "bending_moment", "N m")
    allowed = _positive(stress, "stress", "Pa")
    return as_scalar_or_array(np.cbrt(64 * moment / (math.pi * allowed)))


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
    corners = validate_argument(angles, "angles", "rad")
    values = validate_argument(torques, "torques", "N m")
    steps = np.diff(corners)
    if corners.ndim != 1 or corners.shape != values.shape or corners.size < 2 or np.any(steps < 0) or not corners[-1] > corners[0]:
        raise MechanismError("angles and torques must be lists of equal length, with at least two ascending angles")
    areas = steps * (values[1:] + values[:-1]) / 2
    surplus = values - float(areas.sum()) / (corners[-1] - corners[0])
    stored = np.concatenate([[0.0], np.cumsum(steps * (surplus[1:] + surplus[:-1]) / 2)])
    crossing = np.flatnonzero(surplus[1:] * surplus[:-1] < 0)  # an extremum lies inside these lines
    inside = surplus[crossing] ** 2 * steps[crossing] / (2 * (surplus[crossing] - surplus[crossing + 1]))
    return float(np.ptp(np.concatenate([stored, stored[crossing] + inside])))
