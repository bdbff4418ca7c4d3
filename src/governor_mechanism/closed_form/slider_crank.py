"""The slider crank: positions, speeds, accelerations, Marks' error of the connecting rod, and loads of the bearings.

The crank angle t counts from the outer dead centre, in which the crosshead stands farthest from the shaft, in the
direction of rotation, anticlockwise; the crosshead runs on the x axis through the shaft, y is up. SI and radians.

Every function takes the crank train first and the rest by keyword, floats or arrays that broadcast; floats give a
float. Every function raises MechanismError, naming the value, for numbers that are not finite.

Sources: Müller-Melchiors, Dinglers Polyt. J. 241 (1881), p. 161, for the error Z; the rest follows from the triangle
crank, rod, line by differentiation, and from Newton's laws. Limits: rigid parts, no friction, no play, line of the
crosshead through the shaft.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, validate_argument
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class CrankTrain:
    """Crank R and rod L (m, longer than R; math.inf), with masses (kg) where loads are asked for.

    crank_centre (m) is where the crank's mass lies, from the shaft toward the pin, negative for a counterweight;
    rod_centre (m) where the rod's does, from the crank pin; rod_inertia (kg m2) is about that centre.
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
        validate_argument(self.crank, "crank", "m", greater_than=0.0)
        if not self.rod > self.crank:  # refuses nan too
            raise MechanismError(f"rod must be longer than the crank ({self.crank:.12g} m); got {self.rod:.12g} m")
        for name in ("crank_mass", "rod_mass", "rod_inertia", "crosshead_mass"):
            validate_argument(getattr(self, name), name, "", minimum=0.0)
        for name in ("crank_centre", "rod_centre"):
            validate_argument(getattr(self, name), name, "m")

    @classmethod
    def from_dimensions(cls, dimensions: Mapping[str, float], **masses: float) -> CrankTrain:
        """From a machine's sizes by name: crank and connecting_rod (m), and what has mass."""
        return cls(crank=dimensions["crank"], rod=dimensions["connecting_rod"], **masses)

    @property
    def crank_to_rod_ratio(self) -> float:
        """R / L; 0 for an endless rod."""
        return self.crank / self.rod


def _validate_crank_angle(crank_angle: FloatOrArray) -> FloatArray:
    return validate_argument(crank_angle, "crank_angle", "rad")


def _cos_rod_angle(train: CrankTrain, angle: FloatArray) -> FloatArray:
    """cos f, f the rod's slope."""
    return np.asarray(np.sqrt(1 - (train.crank_to_rod_ratio * np.sin(angle)) ** 2))


def crosshead_distance(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Distance of the crosshead from the shaft (m), on a finite rod: X = R cos t + sqrt(L^2 - R^2 sin^2 t)."""
    if math.isinf(train.rod):
        raise MechanismError("a crosshead on an infinitely long rod has no distance from the shaft; ask for its travel")
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * np.cos(angle) + train.rod * _cos_rod_angle(train, angle))


def rod_error(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """How much nearer to the shaft the crosshead stands than on an endless rod (m): Z = L - sqrt(L^2 - R^2 sin^2 t).

    It is the sagitta of Marks' circle of radius L over R sin t, and exact.
    """
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * np.sin(angle) * train.crank_to_rod_ratio * np.sin(angle) / (1 + _cos_rod_angle(train, angle)))


def parabola_rod_error(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """The same by Marks' parabola (R sin t)^2 = 2 L Z (m)."""
    return as_scalar_or_array(train.crank * train.crank_to_rod_ratio / 2 * np.sin(_validate_crank_angle(crank_angle)) ** 2)


def travel_from_outer_dead_centre(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """How far the crosshead has come from its outer dead centre (m): R (1 - cos t) + Z, from 0 to 2 R."""
    angle = _validate_crank_angle(crank_angle)
    return as_scalar_or_array(train.crank * (1 - np.cos(angle)) + np.asarray(rod_error(train, crank_angle=angle)))


def rod_angle(train: CrankTrain, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Angle f of the rod against the line of the crosshead (rad), sin f = (R / L) sin t: positive, crank pin above."""
    return as_scalar_or_array(np.arcsin(train.crank_to_rod_ratio * np.sin(_validate_crank_angle(crank_angle))))


def rod_angular_velocity(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Its rate (rad/s) at a steady crank_rate W (rad/s): W (R / L) cos t / cos f."""
    angle, rate = _validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    return as_scalar_or_array(train.crank_to_rod_ratio * rate * np.cos(angle) / _cos_rod_angle(train, angle))


def rod_angular_acceleration(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Its acceleration (rad/s2) at a steady crank_rate: -W^2 n (1 - n^2) sin t / cos^3 f with n = R / L."""
    angle, rate = _validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    n = train.crank_to_rod_ratio
    return as_scalar_or_array(-n * rate**2 * (1 - n**2) * np.sin(angle) / _cos_rod_angle(train, angle) ** 3)


def crosshead_velocity(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Speed of the crosshead away from the shaft (m/s): -R W sin t (1 + n cos t / cos f), n = R / L."""
    angle, rate = _validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    rod_term = train.crank_to_rod_ratio * np.cos(angle) / _cos_rod_angle(train, angle)
    return as_scalar_or_array(-train.crank * rate * np.sin(angle) * (1 + rod_term))


def crosshead_acceleration(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray) -> FloatOrArray:
    """Its acceleration (m/s2) at a steady crank_rate W (rad/s), n = R / L:

    -R W^2 (cos t + n cos 2t / cos f + n^3 sin^2 2t / 4 cos^3 f).
    """
    angle, rate = _validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s")
    n, cos_phi = train.crank_to_rod_ratio, _cos_rod_angle(train, angle)
    rod_term = n * np.cos(2 * angle) / cos_phi + n**3 * np.sin(2 * angle) ** 2 / (4 * cos_phi**3)
    return as_scalar_or_array(-train.crank * rate**2 * (np.cos(angle) + rod_term))


@dataclass(frozen=True, kw_only=True)
class BearingLoads:
    """Forces (..., 2) N along x and y: of the frame on the crank, of the crank on the rod, of the rod on the crosshead.

    guide (...) N along y is that of the guide on the crosshead; torque (...) N m that of the drive on the crank,
    anticlockwise.
    """

    main: FloatArray
    crank_pin: FloatArray
    gudgeon: FloatArray
    guide: FloatArray
    torque: FloatArray


def bearing_loads(train: CrankTrain, *, crank_angle: FloatOrArray, crank_rate: FloatOrArray, gravity: float = 0.0) -> BearingLoads:
    """Loads of the bearings by inertia and weight, the crank turning steadily at crank_rate (rad/s); gravity m/s2, -y.

    Newton's laws part by part from the crosshead inward: along its line the rod must give it m X''; about the crank
    pin the rod's moments settle what it gives across. The crank's own inertia loads nothing at a steady rate.
    """
    t, rate = np.broadcast_arrays(_validate_crank_angle(crank_angle), validate_argument(crank_rate, "crank_rate", "rad/s"))
    if math.isinf(train.rod):
        raise MechanismError("loads of the bearings need a rod of finite length")
    phi = np.asarray(rod_angle(train, crank_angle=t))
    phi_rate = np.asarray(rod_angular_velocity(train, crank_angle=t, crank_rate=rate))
    phi_acceleration = np.asarray(rod_angular_acceleration(train, crank_angle=t, crank_rate=rate))
    weight = np.array([0.0, gravity])
    crank_direction = _stack_xy(np.cos(t), np.sin(t))
    rod_direction, rod_normal = _stack_xy(np.cos(phi), -np.sin(phi)), _stack_xy(-np.sin(phi), -np.cos(phi))
    pin_acceleration = -train.crank * rate[..., None] ** 2 * crank_direction
    rod_centre_acceleration = pin_acceleration + train.rod_centre * (
        phi_acceleration[..., None] * rod_normal - phi_rate[..., None] ** 2 * rod_direction
    )
    # What the crosshead gives the rod, along its line and across.
    axial_force = -train.crosshead_mass * np.asarray(crosshead_acceleration(train, crank_angle=t, crank_rate=rate))
    rod_inertia_force = train.rod_mass * (rod_centre_acceleration + weight)
    transverse_moment = (
        train.rod_centre * _cross_z(rod_direction, rod_inertia_force) - train.rod_inertia * phi_acceleration
    )  # the slope grows clockwise
    transverse_force = (transverse_moment / train.rod + np.sin(phi) * -axial_force) / np.cos(phi)
    force_on_rod = _stack_xy(axial_force, transverse_force)
    pin = rod_inertia_force - force_on_rod
    main = train.crank_mass * (weight - train.crank_centre * rate[..., None] ** 2 * crank_direction) + pin
    torque = train.crank * _cross_z(crank_direction, pin) + train.crank_mass * train.crank_centre * gravity * np.cos(t)
    return BearingLoads(
        main=main, crank_pin=pin, gudgeon=-force_on_rod, guide=transverse_force + train.crosshead_mass * gravity, torque=torque
    )


def _stack_xy(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.stack([x, y], axis=-1)


def _cross_z(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
