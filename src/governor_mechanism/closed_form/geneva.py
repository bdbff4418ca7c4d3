"""An external Geneva wheel without clearance: angle, speed and acceleration of the wheel while the pin of the driver is in a slot.

The driver's angle is zero where the pin is on the line of centres, and the wheel's where that slot is. The pin enters and leaves along the
slot, so that the wheel starts and ends at rest. Radians.

The number of slots is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function
raises MechanismError for a value that is not finite or out of range.

References
----------
The law of the angle, tan(beta) = lam sin(alpha) / (1 - lam cos(alpha)) with lam = sin(pi / slots), follows from the
triangle of both shafts and the pin; the others are its derivatives.
"""

import math

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


def engaged_angle(slots: int) -> float:
    """Return the angle of the driver from the entry of the pin to the line of centres.

    Parameters
    ----------
    slots
        Number of slots, 3 or more.

    Returns
    -------
    float
        Angle, rad.

    Raises
    ------
    MechanismError
        If there are fewer than 3 slots.
    """
    if isinstance(slots, bool) or not isinstance(slots, int) or slots < 3:
        raise MechanismError(f"a Geneva wheel has 3 slots or more; got {slots!r}")
    return math.pi / 2 - math.pi / slots


def wheel_angle(slots: int, *, driver_angle: FloatOrArray) -> FloatOrArray:
    """Return the angle of the wheel while the pin is in a slot, against the sense of the driver.

    Parameters
    ----------
    slots
        Number of slots, 3 or more.
    driver_angle
        Angle of the driver, rad; at most `engaged_angle` on either side.

    Returns
    -------
    float or ndarray
        Angle, rad.

    Raises
    ------
    MechanismError
        If the pin is not in a slot at this angle, or there are fewer than 3 slots.
    """
    ratio, angle = _read(slots, driver_angle)
    return as_scalar_or_array(np.arctan2(ratio * np.sin(angle), 1 - ratio * np.cos(angle)))


def speed_ratio(slots: int, *, driver_angle: FloatOrArray) -> FloatOrArray:
    """Return the speed of the wheel relative to that of the driver.

    Parameters
    ----------
    slots
        Number of slots, 3 or more.
    driver_angle
        Angle of the driver, rad; at most `engaged_angle` on either side.

    Returns
    -------
    float or ndarray
        Ratio; largest on the line of centres.

    Raises
    ------
    MechanismError
        If the pin is not in a slot at this angle, or there are fewer than 3 slots.
    """
    ratio, angle = _read(slots, driver_angle)
    return as_scalar_or_array(ratio * (np.cos(angle) - ratio) / (1 - 2 * ratio * np.cos(angle) + ratio**2))


def acceleration_ratio(slots: int, *, driver_angle: FloatOrArray) -> FloatOrArray:
    """Return the acceleration of the wheel relative to the square of the driver's constant speed.

    Parameters
    ----------
    slots
        Number of slots, 3 or more.
    driver_angle
        Angle of the driver, rad; at most `engaged_angle` on either side.

    Returns
    -------
    float or ndarray
        Ratio; positive before the line of centres.

    Raises
    ------
    MechanismError
        If the pin is not in a slot at this angle, or there are fewer than 3 slots.
    """
    ratio, angle = _read(slots, driver_angle)
    return as_scalar_or_array(-ratio * (1 - ratio**2) * np.sin(angle) / (1 - 2 * ratio * np.cos(angle) + ratio**2) ** 2)


def _read(slots: int, driver_angle: FloatOrArray) -> tuple[float, FloatArray]:
    """Return the crank over the distance of the shafts, and the angle of the driver."""
    largest = engaged_angle(slots)
    angle = validate_argument(driver_angle, "driver_angle", "rad")
    is_free = np.abs(angle) > largest * (1 + 1e-12)
    raise_where(is_free, f"the pin is in a slot up to {largest:.9g} rad from the line of centres", ("driver_angle", angle, "rad"))
    return math.sin(math.pi / slots), angle
