"""The slider crank: positions, velocities, accelerations, Marks' error of the connecting rod, and bearing loads.

The crank angle t is zero at the outer dead centre, at which the crosshead is farthest from the shaft, and grows in the direction of
rotation, anticlockwise. The crosshead moves on the x axis through the shaft; y points up. SI and radians.

The crank train is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite. Parts are rigid, without friction and clearance.

References
----------
Müller-Melchiors, Dinglers Polytechnisches Journal 241 (1881), p. 161, for the error Z. The rest follows from the triangle of crank, rod and
line by differentiation, and from Newton's laws.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


@dataclass(frozen=True, kw_only=True)
class CrankTrain:
    """A crank, its connecting rod and, for bearing loads, their masses.

    MechanismError is raised unless the rod is longer than the crank and masses are not negative.

    Attributes
    ----------
    crank
        Length R of the crank, m.
    rod
        Length L of the rod, m; may be infinite.
    crank_mass
        Mass of the crank, kg.
    crank_centre
        Position of the crank's mass centre from the shaft toward the pin, m; negative for a counterweight.
    rod_mass
        Mass of the rod, kg.
    rod_centre
        Position of the rod's mass centre from the crank pin, m.
    rod_inertia
        Moment of inertia of the rod about its mass centre, kg m2.
    crosshead_mass
        Mass of the crosshead, kg.
    """

    crank: float
    rod: float
    crank_mass: float = 0.0
    crank_centre: float = 0.0
    rod_mass: float = 0.0
    rod_centre: float = 0.0
    rod_inertia: float = 0.0
    crosshead_mass: float = 0.0

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_argument(self.crank, "crank", "m", greater_than=0.0)
        if not self.rod > self.crank:  # refuses nan too
            raise MechanismError(f"rod must be longer than the crank ({self.crank:.12g} m); got {self.rod:.12g} m")
        validate_fields(self, {"crank_mass": "kg", "rod_mass": "kg", "rod_inertia": "kg m2", "crosshead_mass": "kg"}, minimum=0.0)
        validate_fields(self, {"crank_centre": "m", "rod_centre": "m"})

    @classmethod
    def from_dimensions(cls, dimensions: Mapping[str, float], **masses: float) -> CrankTrain:
        """Return the crank train of a machine's dimensions crank and connecting_rod (m), with the given masses (SI).

        Parameters
        ----------
        dimensions
            Dimensions by name, SI.

        Returns
        -------
        CrankTrain
            The crank train.
        """
        return cls(crank=dimensions["crank"], rod=dimensions["connecting_rod"], **masses)

    @property
    def crank_to_rod_ratio(self) -> float:
        """R / L; 0 for an infinitely long rod."""
        return self.crank / self.rod


def _validate_crank_angle(crank_angle: FloatOrArray) -> FloatArray:
    """Return the crank angle (rad)."""
    return validate_argument(crank_angle, "crank_angle", "rad")


def _cos_rod_angle(train: CrankTrain, angle: FloatArray) -> FloatArray:
    """Return cos f of the rod angle f."""
    return np.asarray(np.sqrt(1 - (train.crank_to_rod_ratio * np.sin(angle)) ** 2))


def crosshead_distance(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance of the crosshead from the shaft, X = R cos t + sqrt(L^2 - R^2 sin^2 t).

    Parameters
    ----------
    train
        The crank train, with a rod of finite length.
    crank_angle
        Crank angle t, rad.

    Returns
    -------
    FloatOrArray
        Distance, m.

    Raises
    ------
    MechanismError
        If the rod is infinitely long.
    """
    if math.isinf(train.rod):
        raise MechanismError("with an infinitely long rod the crosshead has no distance from the shaft; use its travel")
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * np.cos(angle) + train.rod * _cos_rod_angle(train, angle))


def rod_error(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return how much nearer to the shaft (m) the crosshead is than on an infinite rod, Z = L - sqrt(L^2 - R^2 sin^2 t)."""
    # It is the sagitta of Marks' circle of radius L over R sin t, and exact.
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * np.sin(angle) * train.crank_to_rod_ratio * np.sin(angle) / (1 + _cos_rod_angle(train, angle)))


def travel_from_outer_dead_centre(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the travel of the crosshead from its outer dead centre, R (1 - cos t) + Z.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.

    Returns
    -------
    FloatOrArray
        Travel, m; from 0 to 2 R.
    """
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * (1 - np.cos(angle)) + np.asarray(rod_error(train, crank_angle=angle)))


def rod_angle(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the angle f of the rod against the line of the crosshead, sin f = (R / L) sin t.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.

    Returns
    -------
    FloatOrArray
        Rod angle, rad; positive with the crank pin above the line.
    """
    return as_scalar_or_array(np.arcsin(train.crank_to_rod_ratio * np.sin(_validate_crank_angle(crank_angle))))


def rod_angular_velocity(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the angular velocity of the rod at a steady crank rate, W (R / L) cos t / cos f.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Angular velocity, rad/s.
    """
    angle = _validate_crank_angle(crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    return as_scalar_or_array(train.crank_to_rod_ratio * rate * np.cos(angle) / _cos_rod_angle(train, angle))


def rod_angular_acceleration(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the angular acceleration of the rod at a steady crank rate, -W^2 n (1 - n^2) sin t / cos^3 f with n = R / L.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Angular acceleration, rad/s2.
    """
    angle = _validate_crank_angle(crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    n = train.crank_to_rod_ratio
    return as_scalar_or_array(-n * rate**2 * (1 - n**2) * np.sin(angle) / _cos_rod_angle(train, angle) ** 3)


def crosshead_velocity(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the velocity of the crosshead away from the shaft, -R W sin t (1 + n cos t / cos f) with n = R / L.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Velocity, m/s.
    """
    angle = _validate_crank_angle(crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    rod_term = train.crank_to_rod_ratio * np.cos(angle) / _cos_rod_angle(train, angle)
    return as_scalar_or_array(-train.crank * rate * np.sin(angle) * (1 + rod_term))


def crosshead_acceleration(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Return the acceleration of the crosshead at a steady crank rate.

    -R W^2 (cos t + n cos 2t / cos f + n^3 sin^2 2t / 4 cos^3 f) with n = R / L.

    Parameters
    ----------
    train
        The crank train.
    crank_angle
        Crank angle t, rad.
    crank_rate
        Angular velocity W of the crank, rad/s.

    Returns
    -------
    FloatOrArray
        Acceleration, m/s2.
    """
    angle = _validate_crank_angle(crank_angle)
    rate = validate_argument(crank_rate, "crank_rate", "rad/s")
    n, cos_phi = train.crank_to_rod_ratio, _cos_rod_angle(train, angle)
    rod_term = n * np.cos(2 * angle) / cos_phi + n**3 * np.sin(2 * angle) ** 2 / (4 * cos_phi**3)
    return as_scalar_or_array(-train.crank * rate**2 * (np.cos(angle) + rod_term))


@dataclass(frozen=True, kw_only=True, eq=False)
class BearingLoads:
    """Loads of the bearings; forces along x and y have the shape (..., 2).

    Attributes
    ----------
    main
        Force of the frame on the crank, N.
    crank_pin
        Force of the crank on the rod, N.
    gudgeon
        Force of the rod on the crosshead, N.
    guide
        Force of the guide on the crosshead along y, N; shape (...).
    torque
        Torque of the drive on the crank, N m, anticlockwise; shape (...).
    """

    main: FloatArray
    crank_pin: FloatArray
    gudgeon: FloatArray
    guide: FloatArray
    torque: FloatArray


def bearing_loads(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray, gravity: float = 0.0) -> BearingLoads:
    """Return the loads of the bearings due to inertia and weight at a steady crank rate.

    Newton's laws are applied part by part, from the crosshead inward. Along its line the rod gives the crosshead its inertia force m X'';
    the transverse force follows from the rod's moments about the crank pin. The crank's own inertia causes no load at a steady rate.

    Parameters
    ----------
    train
        The crank train with its masses and a rod of finite length.
    crank_angle
        Crank angle t, rad.
    crank_rate
        Angular velocity of the crank, rad/s.
    gravity
        Gravitational acceleration along -y, m/s2.

    Returns
    -------
    BearingLoads
        Forces and torque of the bearings.

    Raises
    ------
    MechanismError
        If the rod is infinitely long.
    """
    t, rate = np.broadcast_arrays(_validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s"))
    if math.isinf(train.rod):
        raise MechanismError("bearing loads need a rod of finite length")
    phi = np.asarray(rod_angle(train, crank_angle=t))
    phi_rate = np.asarray(rod_angular_velocity(train, crank_angle=t, crank_rate=rate))
    phi_acceleration = np.asarray(rod_angular_acceleration(train, crank_angle=t, crank_rate=rate))
    weight = np.array([0.0, gravity])
    crank_direction = _stack_xy(np.cos(t), np.sin(t))
    rod_direction = _stack_xy(np.cos(phi), -np.sin(phi))
    rod_normal = _stack_xy(-np.sin(phi), -np.cos(phi))
    pin_acceleration = -train.crank * rate[..., None] ** 2 * crank_direction
    swing_acceleration = phi_acceleration[..., None] * rod_normal - phi_rate[..., None] ** 2 * rod_direction
    rod_centre_acceleration = pin_acceleration + train.rod_centre * swing_acceleration
    # What the crosshead gives the rod, along its line and across.
    axial_force = -train.crosshead_mass * np.asarray(crosshead_acceleration(train, crank_angle=t, crank_rate=rate))
    rod_inertia_force = train.rod_mass * (rod_centre_acceleration + weight)
    # The slope grows clockwise.
    transverse_moment = train.rod_centre * _cross_z(rod_direction, rod_inertia_force) - train.rod_inertia * phi_acceleration
    transverse_force = (transverse_moment / train.rod + np.sin(phi) * -axial_force) / np.cos(phi)
    force_on_rod = _stack_xy(axial_force, transverse_force)
    pin = rod_inertia_force - force_on_rod
    main = train.crank_mass * (weight - train.crank_centre * rate[..., None] ** 2 * crank_direction) + pin
    torque = train.crank * _cross_z(crank_direction, pin) + train.crank_mass * train.crank_centre * gravity * np.cos(t)
    guide = transverse_force + train.crosshead_mass * gravity
    return BearingLoads(main=main, crank_pin=pin, gudgeon=-force_on_rod, guide=guide, torque=torque)


def _stack_xy(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the vectors (..., 2) of two components."""
    return np.stack([x, y], axis=-1)


def _cross_z(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the z component of the cross product of vectors (..., 2)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
