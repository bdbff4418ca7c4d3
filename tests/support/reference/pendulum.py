"""Energies of a pendulum governor and the speeds of its friction band, from the position of its linkage.

Source of the speeds: L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14, equations (1) and (2).
"""

from typing import Any

import numpy as np

from governor_mechanism.closed_form.pendulum import LinkagePosition, PendulumGovernor


def potential_derivative(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return V' (N m/rad): the moment of the weights against the opening of the arms."""
    return LinkagePosition(governor, arm_angle).potential_derivatives()[0]


def potential_second_derivative(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return V'' (N m/rad^2)."""
    return LinkagePosition(governor, arm_angle).potential_derivatives()[1]


def spindle_inertia_derivative(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return J' (kg m2/rad)."""
    return LinkagePosition(governor, arm_angle).spindle_inertia_derivatives()[0]


def in_plane_inertia(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return the in-plane inertia I (kg m2)."""
    return LinkagePosition(governor, arm_angle).in_plane_inertia_and_derivative()[0]


def in_plane_inertia_derivative(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return I' (kg m2/rad)."""
    return LinkagePosition(governor, arm_angle).in_plane_inertia_and_derivative()[1]


def rising_speed(governor: PendulumGovernor, *, arm_angle: Any, resistance: Any) -> Any:
    """Return the spindle speed (rad/s) at which the arms are about to rise against a resistance (N) at the sleeve.

    Rhombus: w'^2 = (g tan a / x)(P + Q + W) / P; the falling speed is that of the opposite resistance.
    """
    position = LinkagePosition(governor, arm_angle)
    moment = position.potential_derivatives()[0] + resistance * np.abs(position.sleeve_derivative)
    return np.sqrt(2 * moment / position.spindle_inertia_derivatives()[0])
