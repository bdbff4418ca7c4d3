"""The work of drives, dampers, torques and forces in a motion known at stations, from their power in between.

What brakes, friction and stops along readings take is not in it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial.legendre import leggauss

from governor_mechanism.mechanics.dynamics.contacts import Mode, brakes_of, keepers_of
from governor_mechanism.mechanics.dynamics.force_laws import brake_force
from governor_mechanism.mechanics.dynamics.inverse_dynamics import Dynamics, dynamics
from governor_mechanism.mechanics.kinematics.output_variables import reading_gradient
from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.types import FloatArray

NODES = 4
"""Points of Gauss in each interval between stations: order 8."""

HERMITE = np.array(
    [
        [1.0, 0.0, 0.0, -10.0, 15.0, -6.0],
        [0.0, 1.0, 0.0, -6.0, 8.0, -3.0],
        [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
        [0.0, 0.0, 0.0, 10.0, -15.0, 6.0],
        [0.0, 0.0, 0.0, -4.0, 7.0, -3.0],
        [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
    ]
)
"""What value, slope and bend at either end of an interval contribute, by powers of the part of it that has passed."""


CUBIC = np.array([[1.0, 0.0, -3.0, 2.0], [0.0, 1.0, -2.0, 1.0], [0.0, 0.0, 3.0, -2.0], [0.0, 0.0, -1.0, 1.0]])
"""The same of value and slope."""


def work_between(
    scene: Scene, stations: State, speeds: Callable[[FloatArray, FloatArray], FloatArray], modes: Sequence[Mode] = ()
) -> FloatArray:
    """Work (n,) J done up to each of the stations; they include every break of a program.

    speeds(times, poses) is the spindle's. Between stations the path is one of order 5. Where something sticks or
    strikes, modes (n,) say how it stands at the stations: the path is then one of order 3, which no jump of an
    acceleration disturbs; in the intervals of impacts that is rough.
    """

    def implied(times: FloatArray, poses: FloatArray, velocities: FloatArray) -> Dynamics:
        return dynamics(scene, times, poses, velocities, speeds(times, poses), modes[: len(times)])

    times, poses, velocities = stations.times, stations.poses, stations.velocities
    lengths = np.diff(times)
    h = lengths[:, np.newaxis, np.newaxis]
    gains = np.zeros_like(lengths)
    ends, shape = [poses[:-1], h * velocities[:-1], poses[1:], h * velocities[1:]], CUBIC
    if not modes:
        ends, shape = _with_accelerations(implied, stations, h), HERMITE
    for node, weight in zip(*leggauss(NODES), strict=True):
        part = 0.5 * (1.0 + node)
        exponents = np.arange(shape.shape[1])
        powers = part**exponents
        slopes = exponents * part ** np.maximum(exponents - 1, 0)
        there = np.asarray(sum(share * end for share, end in zip(shape @ powers, ends, strict=True)))
        moving = np.asarray(sum(share * end for share, end in zip(shape @ slopes, ends, strict=True)) / h)
        now = times[:-1] + part * lengths
        power = implied(now, there, moving).power + _taken(scene, now, there, moving, modes)
        gains += 0.5 * weight * lengths * power
    return np.concatenate([[0.0], np.cumsum(gains)])


def _taken(
    scene: Scene, times: FloatArray, poses: FloatArray, velocities: FloatArray, modes: Sequence[Mode]
) -> FloatArray:
    """What brakes and sliding friction take (n,) W."""
    mechanism, taken = scene.part.mechanism, np.zeros(len(times))

    def rate(reading: str) -> FloatArray:
        found: FloatArray = np.sum(reading_gradient(mechanism, reading, poses) * velocities, axis=(-2, -1))
        return found

    for brake in brakes_of(scene):
        moving = rate(brake.reading)
        taken += brake_force(brake.linear, brake.quadratic, moving) * moving
    for k, keeper in enumerate(keepers_of(scene) if modes else ()):
        if keeper.friction is not None:
            signs = np.array([mode.sliding[k] for mode in modes[: len(times)]])
            taken += TimeCurve(keeper.friction)(times) * signs * rate(keeper.reading)
    return taken


def _with_accelerations(
    implied: Callable[[FloatArray, FloatArray, FloatArray], Dynamics], stations: State, h: FloatArray
) -> list[FloatArray]:
    """Value, slope and bend at both ends of every interval of h (s)."""
    times, poses, velocities = stations.times, stations.poses, stations.velocities
    after = implied(times, poses, velocities).accelerations[:-1]
    # What jumps at a station does so after the interval that ends there.
    before = implied(np.nextafter(times, -np.inf), poses, velocities).accelerations[1:]
    return [poses[:-1], h * velocities[:-1], h**2 * after, poses[1:], h * velocities[1:], h**2 * before]
