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

from governor_mechanism.closed_form.arguments import Number, as_given, checked
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
        checked(self.crank, "crank", "m", above=0.0)
        if not self.rod > self.crank:  # refuses nan too
            raise MechanismError(f"rod must be longer than the crank ({self.crank:.12g} m); got {self.rod:.12g} m")
        for name in ("crank_mass", "rod_mass", "rod_inertia", "crosshead_mass"):
            checked(getattr(self, name), name, "", least=0.0)
        for name in ("crank_centre", "rod_centre"):
            checked(getattr(self, name), name, "m")

    @classmethod
    def of(cls, sizes: Mapping[str, float], **masses: float) -> CrankTrain:
        """From a machine's sizes by name: crank and connecting_rod (m), and what has mass."""
        return cls(crank=sizes["crank"], rod=sizes["connecting_rod"], **masses)

    @property
    def ratio(self) -> float:
        """R / L; 0 for an endless rod."""
        return self.crank / self.rod


def _angle(crank_angle: Number) -> FloatArray:
    return checked(crank_angle, "crank_angle", "rad")


def _cosine(train: CrankTrain, angle: FloatArray) -> FloatArray:
    """cos f, f the rod's slope."""
    return np.asarray(np.sqrt(1 - (train.ratio * np.sin(angle)) ** 2))


def crosshead_distance(train: CrankTrain, *, crank_angle: Number) -> Number:
    """Distance of the crosshead from the shaft (m), on a finite rod: X = R cos t + sqrt(L^2 - R^2 sin^2 t)."""
    if math.isinf(train.rod):
        raise MechanismError("a crosshead on an infinitely long rod has no distance from the shaft; ask for its travel")
    angle = _angle(crank_angle)
    return as_given(train.crank * np.cos(angle) + train.rod * _cosine(train, angle))


def rod_error(train: CrankTrain, *, crank_angle: Number) -> Number:
    """How much nearer to the shaft the crosshead stands than on an endless rod (m): Z = L - sqrt(L^2 - R^2 sin^2 t).

    It is the sagitta of Marks' circle of radius L over R sin t, and exact.
    """
    angle = _angle(crank_angle)
    return as_given(train.crank * np.sin(angle) * train.ratio * np.sin(angle) / (1 + _cosine(train, angle)))


def parabola_rod_error(train: CrankTrain, *, crank_angle: Number) -> Number:
    """The same by Marks' parabola (R sin t)^2 = 2 L Z (m)."""
    return as_given(train.crank * train.ratio / 2 * np.sin(_angle(crank_angle)) ** 2)


def travel_from_outer_end(train: CrankTrain, *, crank_angle: Number) -> Number:
    """How far the crosshead has come from its outer dead centre (m): R (1 - cos t) + Z, from 0 to 2 R."""
    angle = _angle(crank_angle)
    return as_given(train.crank * (1 - np.cos(angle)) + np.asarray(rod_error(train, crank_angle=angle)))


def rod_slope(train: CrankTrain, *, crank_angle: Number) -> Number:
    """Angle f of the rod against the line of the crosshead (rad), sin f = (R / L) sin t: positive, crank pin above."""
    return as_given(np.arcsin(train.ratio * np.sin(_angle(crank_angle))))


def rod_slope_rate(train: CrankTrain, *, crank_angle: Number, crank_rate: Number) -> Number:
    """Its rate (rad/s) at a steady crank_rate W (rad/s): W (R / L) cos t / cos f."""
    angle, rate = _angle(crank_angle), checked(crank_rate, "crank_rate", "rad/s")
    return as_given(train.ratio * rate * np.cos(angle) / _cosine(train, angle))


def rod_slope_acceleration(train: CrankTrain, *, crank_angle: Number, crank_rate: Number) -> Number:
    """Its acceleration (rad/s2) at a steady crank_rate: -W^2 n (1 - n^2) sin t / cos^3 f with n = R / L."""
    angle, rate = _angle(crank_angle), checked(crank_rate, "crank_rate", "rad/s")
    n = train.ratio
    return as_given(-n * rate**2 * (1 - n**2) * np.sin(angle) / _cosine(train, angle) ** 3)


def crosshead_velocity(train: CrankTrain, *, crank_angle: Number, crank_rate: Number) -> Number:
    """Speed of the crosshead away from the shaft (m/s): -R W sin t (1 + n cos t / cos f), n = R / L."""
    angle, rate = _angle(crank_angle), checked(crank_rate, "crank_rate", "rad/s")
    leaning = train.ratio * np.cos(angle) / _cosine(train, angle)
    return as_given(-train.crank * rate * np.sin(angle) * (1 + leaning))


def crosshead_acceleration(train: CrankTrain, *, crank_angle: Number, crank_rate: Number) -> Number:
    """Its acceleration (m/s2) at a steady crank_rate W (rad/s), n = R / L:

    -R W^2 (cos t + n cos 2t / cos f + n^3 sin^2 2t / 4 cos^3 f).
    """
    angle, rate = _angle(crank_angle), checked(crank_rate, "crank_rate", "rad/s")
    n, slope = train.ratio, _cosine(train, angle)
    swing = n * np.cos(2 * angle) / slope + n**3 * np.sin(2 * angle) ** 2 / (4 * slope**3)
    return as_given(-train.crank * rate**2 * (np.cos(angle) + swing))


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


def bearing_loads(train: CrankTrain, *, crank_angle: Number, crank_rate: Number, gravity: float = 0.0) -> BearingLoads:
    """Loads of the bearings by inertia and weight, the crank turning steadily at crank_rate (rad/s); gravity m/s2, -y.

    Newton's laws part by part from the crosshead inward: along its line the rod must give it m X''; about the crank
    pin the rod's moments settle what it gives across. The crank's own inertia loads nothing at a steady rate.
    """
    t, rate = np.broadcast_arrays(_angle(crank_angle), checked(crank_rate, "crank_rate", "rad/s"))
    if math.isinf(train.rod):
        raise MechanismError("loads of the bearings need a rod of finite length")
    slope = np.asarray(rod_slope(train, crank_angle=t))
    turning = np.asarray(rod_slope_rate(train, crank_angle=t, crank_rate=rate))
    bending = np.asarray(rod_slope_acceleration(train, crank_angle=t, crank_rate=rate))
    weight = np.array([0.0, gravity])
    outward = _pair(np.cos(t), np.sin(t))
    along, across = _pair(np.cos(slope), -np.sin(slope)), _pair(-np.sin(slope), -np.cos(slope))
    pin_pull = -train.crank * rate[..., None] ** 2 * outward
    centre_pull = pin_pull + train.rod_centre * (bending[..., None] * across - turning[..., None] ** 2 * along)
    # What the crosshead gives the rod, along its line and across.
    thrust = -train.crosshead_mass * np.asarray(crosshead_acceleration(train, crank_angle=t, crank_rate=rate))
    inertia = train.rod_mass * (centre_pull + weight)
    moment = train.rod_centre * _cross(along, inertia) - train.rod_inertia * bending  # the slope grows clockwise
    side = (moment / train.rod + np.sin(slope) * -thrust) / np.cos(slope)
    given = _pair(thrust, side)
    pin = inertia - given
    main = train.crank_mass * (weight - train.crank_centre * rate[..., None] ** 2 * outward) + pin
    torque = train.crank * _cross(outward, pin) + train.crank_mass * train.crank_centre * gravity * np.cos(t)
    return BearingLoads(
        main=main, crank_pin=pin, gudgeon=-given, guide=side + train.crosshead_mass * gravity, torque=torque
    )


def _pair(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.stack([x, y], axis=-1)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
