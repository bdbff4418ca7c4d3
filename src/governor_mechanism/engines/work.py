"""The work of drives, dampers, torques and forces in a motion known at stations, from their power in between."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import leggauss

from governor_mechanism.engines.state import State
from governor_mechanism.equations.dynamics import Dynamics, dynamics
from governor_mechanism.equations.points import Array
from governor_mechanism.scene import Scene

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


def work_between(scene: Scene, stations: State, speeds: Callable[[Array, Array], Array]) -> Array:
    """Work (n,) J done up to each of the stations; they include every break of a program.

    speeds(times, poses) is the spindle's. Between stations the path is one of order 5.
    """

    def implied(times: Array, poses: Array, velocities: Array) -> Dynamics:
        return dynamics(scene, times, poses, velocities, speeds(times, poses))

    times, poses, velocities = stations.times, stations.poses, stations.velocities
    lengths = np.diff(times)
    after = implied(times, poses, velocities).accelerations[:-1]
    # What jumps at a station does so after the interval that ends there.
    before = implied(np.nextafter(times, -np.inf), poses, velocities).accelerations[1:]
    h = lengths[:, np.newaxis, np.newaxis]
    ends = [poses[:-1], h * velocities[:-1], h**2 * after, poses[1:], h * velocities[1:], h**2 * before]
    gains = np.zeros_like(lengths)
    for node, weight in zip(*leggauss(NODES), strict=True):
        part = 0.5 * (1.0 + node)
        powers = part ** np.arange(6)
        slopes = np.arange(6) * part ** np.maximum(np.arange(6) - 1, 0)
        there = sum(share * end for share, end in zip(HERMITE @ powers, ends, strict=True))
        moving = sum(share * end for share, end in zip(HERMITE @ slopes, ends, strict=True)) / h
        found = implied(times[:-1] + part * lengths, np.asarray(there), np.asarray(moving))
        gains += 0.5 * weight * lengths * found.power
    return np.concatenate([[0.0], np.cumsum(gains)])
