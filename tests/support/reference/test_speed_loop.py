"""The loop of governor and engine in closed form: Haug's governor with its spindle, numerically linearised and integrated."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form import pendulum
from reference import haug_governor as haug
from reference import pendulum as linkage
from reference.speed_loop import (
    SpeedLoop,
    characteristic_polynomial,
    critical_damping,
    critical_torque_derivative,
    eigenvalues,
    limit_frequency,
)

GRAVITY = 9.81
GOVERNOR = pendulum.PendulumGovernor(
    arm=haug.ARM,
    arm_joint=haug.ROD_JOINT,
    link=haug.ROD,
    ball_mass=haug.BALL_MASS,
    sleeve_mass=haug.COLLAR_MASS,
    ball_inertia=haug.BALL_INERTIA,
    gravity=GRAVITY,
)


def collar_slope(angle: float) -> float:
    """Return the derivative (m/rad) of the collar's height by the arm angle, by the law of sines for arm and rod."""
    rod_angle = math.asin(haug.ROD_JOINT / haug.ROD * math.sin(angle))
    return haug.ROD_JOINT * math.sin(angle + rod_angle) / math.cos(rod_angle)


def haug_loop(gain: float = haug.GAIN, damping: float = haug.DAMPING) -> SpeedLoop:
    """Return Haug's loop by the closed forms of pendulum governors; the relaxed spring adds its rate to the stiffness."""
    angle = haug.EQUILIBRIUM_ANGLE
    speed = float(pendulum.equilibrium_speed(GOVERNOR, arm_angle=angle))
    slope = collar_slope(angle)
    return SpeedLoop(
        governor_inertia=float(linkage.in_plane_inertia(GOVERNOR, arm_angle=angle)),
        damping=damping * slope**2,
        stiffness=float(pendulum.stiffness(GOVERNOR, arm_angle=angle)) + haug.SPRING_RATE * slope**2,
        speed_moment=float(linkage.spindle_inertia_derivative(GOVERNOR, arm_angle=angle)) * speed,
        shaft_inertia=haug.CONSTANT_INERTIA + float(pendulum.spindle_inertia(GOVERNOR, arm_angle=angle)),
        torque_derivative=-gain * slope,
    )


@pytest.mark.parametrize("gravity", haug.EQUILIBRIUM_SPEEDS)
def test_the_equilibrium_of_haugs_governor(gravity: float) -> None:
    angle, _, speed = haug.equilibrium(gravity)
    # half a unit of the last published digit
    assert abs(speed - haug.PUBLISHED_EQUILIBRIUM_SPEEDS[gravity]) <= 0.5e-6
    # the derivation and the formula for any linkage, in double precision
    assert_allclose(speed, haug.EQUILIBRIUM_SPEEDS[gravity], rtol=1e-14)
    assert_allclose(angle, haug.EQUILIBRIUM_ANGLE, rtol=1e-14)
    assert_allclose(pendulum.equilibrium_speed(replace(GOVERNOR, gravity=gravity), arm_angle=angle), speed, rtol=1e-13)


def test_the_motion_of_haugs_governor() -> None:
    times = np.array([row[0] for row in haug.MOTION])
    motion = haug.trajectory(times)
    for column, name in enumerate(("theta", "omega", "spindle_angle", "y"), start=1):
        # rtol 1e-13 per step; two integrations of 60 s were seen to differ by 3e-13
        assert_allclose(motion[name], [row[column] for row in haug.MOTION], rtol=1e-12)


def test_the_eigenvalues_of_haugs_governor() -> None:
    expected = sorted([haug.EIGENVALUES[0], np.conj(haug.EIGENVALUES[0]), haug.EIGENVALUES[1]], key=np.imag)
    for values in (eigenvalues(haug_loop()), np.linalg.eigvals(haug.linearised())):
        # roots of a well-conditioned cubic in double precision
        assert_allclose(sorted(values, key=np.imag), expected, rtol=1e-12)


def test_the_limits_of_haugs_governor() -> None:
    loop, slope = haug_loop(), collar_slope(haug.EQUILIBRIUM_ANGLE)
    # one rounding or two for each factor
    assert_allclose(-critical_torque_derivative(loop) / slope, haug.CRITICAL_GAIN, rtol=1e-13)
    assert_allclose(critical_damping(loop) / slope**2, haug.CRITICAL_DAMPING, rtol=1e-13)
    assert_allclose(limit_frequency(loop), haug.CRITICAL_FREQUENCY, rtol=1e-13)


@pytest.mark.parametrize("limit", ["gain", "damping"])
@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_small_oscillations_grow_beyond_the_limit_and_decay_before_it(limit: str, factor: float) -> None:
    changed = {"gain": haug.CRITICAL_GAIN * factor} if limit == "gain" else {"damping": haug.CRITICAL_DAMPING * factor}
    is_unstable = (factor > 1) == (limit == "gain")
    pair = max(eigenvalues(haug_loop(**changed)), key=np.imag)
    assert (pair.real > 0) == is_unstable
    matrix = haug.linearised(**changed)
    vector = np.linalg.eig(matrix).eigenvectors[:, np.argmax(np.linalg.eigvals(matrix).imag)]
    # small enough that the square of the oscillation changes its rate by less than the tolerance
    equilibrium = haug.equilibrium(GRAVITY)
    start = np.append(equilibrium + 1e-6 * np.real(vector), 0.0)
    period = 2 * math.pi / pair.imag
    run = solve_ivp(
        lambda _, state: haug.derivative(state, 0.0, GRAVITY, **changed), (0, 20 * period), start, method="DOP853", rtol=1e-13, atol=1e-15
    )
    # after whole periods the deviation is the first one times exp(Re(s) t); 1e-15 of the integrator beside 1e-6 leaves some 1e-7
    growth = (run.y[:3, -1] - equilibrium)[1] / np.real(vector)[1] / 1e-6
    assert_allclose(math.log(growth), pair.real * 20 * period, rtol=1e-3)


def test_hurwitz_holds_for_every_loop() -> None:
    random = np.random.default_rng(5)
    for _ in range(200):
        loop = SpeedLoop(
            governor_inertia=random.uniform(0.1, 5),
            damping=random.uniform(0, 5),
            stiffness=random.uniform(0.1, 20),
            speed_moment=random.uniform(0.1, 5),
            shaft_inertia=random.uniform(0.1, 20),
            torque_derivative=-random.uniform(0.1, 50),
            ratio=random.uniform(0.2, 5),
            is_reacting=bool(random.integers(2)),
        )
        is_stable = bool(eigenvalues(loop).real.max() < 0)
        assert is_stable == (loop.damping > critical_damping(loop)) == (loop.torque_derivative > critical_torque_derivative(loop))
        at_limit = characteristic_polynomial(replace(loop, damping=critical_damping(loop)))
        # the polynomial vanishes at i w0: rounding of its terms
        assert abs(np.polyval(at_limit, 1j * limit_frequency(loop))) <= 1e-13 * np.abs(at_limit).max() * (1 + limit_frequency(loop)) ** 3
