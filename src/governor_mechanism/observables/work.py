"""Work of drivers, dampers, torques and forces in a motion known at discrete times, by Gauss quadrature of the power.

Energy dissipated by dashpots, friction and stops along outputs is not included.
"""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial.legendre import leggauss

from governor_mechanism.mechanics.dynamics.equations.inverse_dynamics import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of, output_forces_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.hermite import cubic_hermite, cubic_hermite_derivative, quintic_hermite
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

N_GAUSS_POINTS = 4
"""Gauss points in each interval: order 8."""


def integrate_work(
    scene: Scene,
    history: StateHistory,  # states at times that include every breakpoint of an input function; shape (n,)
    # contact mode at each time, or empty if the scene has no contacts
    contact_modes: Sequence[ContactMode] = (),
) -> FloatArray:
    """Return the cumulative work of drivers and force elements.

    Between the times of the history the path is a quintic Hermite interpolant. With contacts it is a cubic one, because
    accelerations jump; that is inaccurate in the intervals of impacts.

    Result: work done since the first time, J; shape (n,).
    """

    def evaluate_motion(times: FloatArray, poses: FloatArray, velocities: FloatArray) -> InverseDynamics:
        return compute_inverse_dynamics(scene, times, poses, velocities, history.lags[: len(times)], contact_modes[: len(times)])

    times, poses, velocities = history.times, history.poses, history.velocities
    durations = np.diff(times)
    h = durations[:, np.newaxis, np.newaxis]
    increments = np.zeros_like(durations)
    ends = (poses[:-1], poses[1:], velocities[:-1], velocities[1:])
    if not contact_modes:
        start_accelerations = evaluate_motion(times, poses, velocities).accelerations[:-1]
        # A jump at a monitor time belongs to the interval that starts there.
        end_accelerations = evaluate_motion(np.nextafter(times, -np.inf), poses, velocities).accelerations[1:]
    for node, weight in zip(*leggauss(N_GAUSS_POINTS), strict=True):
        fraction = 0.5 * (1.0 + node)
        if contact_modes:
            segment_poses, segment_velocities = cubic_hermite(*ends, h, fraction), cubic_hermite_derivative(*ends, h, fraction)
        else:
            segment_poses, segment_velocities = quintic_hermite(
                poses[:-1], velocities[:-1], start_accelerations, poses[1:], velocities[1:], end_accelerations, h, fraction
            )
        segment_times = times[:-1] + fraction * durations
        power = evaluate_motion(segment_times, segment_poses, segment_velocities).power + _compute_dissipated_power(
            scene, segment_times, segment_poses, segment_velocities, contact_modes
        )
        increments += 0.5 * weight * durations * power
    return np.concatenate([[0.0], np.cumsum(increments)])


def _compute_dissipated_power(
    scene: Scene, times: FloatArray, poses: FloatArray, velocities: FloatArray, contact_modes: Sequence[ContactMode]
) -> FloatArray:
    """Return the power (n,) W dissipated by dashpots and sliding friction."""
    dissipated_power = np.zeros(len(times))

    for effect in (effect for effect in output_forces_of(scene) if effect.dissipates):
        output = evaluate_output(scene.mechanism, effect.reading, poses)
        rate = output.rate(velocities)
        dissipated_power -= effect.evaluate(output.value, rate) * rate
    for k, contact in enumerate(contacts_of(scene) if contact_modes else ()):
        if contact.friction is not None:
            sliding_signs = np.array([mode.sliding_signs[k] for mode in contact_modes[: len(times)]])
            rate = evaluate_output(scene.mechanism, contact.output_name, poses).rate(velocities)
            dissipated_power += CubicTimeFunction(contact.friction)(times) * sliding_signs * rate
    return dissipated_power
