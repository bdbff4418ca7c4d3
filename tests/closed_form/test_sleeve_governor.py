"""Hartnell's and Proell's governors against Lagrange's equation of the places of balls and sleeve, by complex numbers."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from governor_mechanism.closed_form import hartnell, proell
from governor_mechanism.errors import MechanismError
from refusing import refuses

Governor = hartnell.HartnellGovernor | proell.ProellGovernor


class Places(NamedTuple):
    """Distance of a ball from the axis, its height and that of the sleeve, m."""

    x: Any
    y: Any
    z: Any


def places_of(governor: Governor, angle: Any) -> Places:
    """Return the places by complex numbers, with the upright as imaginary axis."""
    if isinstance(governor, hartnell.HartnellGovernor):
        ball = governor.pivot_radius + 1j * governor.ball_arm * np.exp(-1j * angle)
        roller = 1j * governor.sleeve_arm * np.exp(1j * (governor.angle - angle))
        return Places(ball.real, ball.imag, roller.imag)
    joint = governor.offset - 1j * governor.arm * np.exp(1j * angle)
    lug = governor.lug_offset + 1j * (joint.imag - np.sqrt(governor.link**2 - (joint.real - governor.lug_offset) ** 2))
    ball = joint + governor.extension / governor.link * (joint - lug) * np.exp(-1j * governor.bend)
    return Places(ball.real, ball.imag, lug.imag)


def slope_of(function: Callable[[Any], Any], at: Any, step: float = 2e-3) -> Any:
    """First derivative by central differences over nine points: error of order step^8, rounding about eps / step."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return sum(weight * function(at + step * k) for k, weight in zip(range(-4, 5), weights, strict=True)) / step


def slopes_of(governor: Governor, angle: Any) -> Places:
    return Places(*(slope_of(lambda at, k=k: places_of(governor, at)[k], angle) for k in range(3)))


def inertia_of(governor: Governor, angle: Any) -> Any:
    slope = slopes_of(governor, angle)
    return 2 * governor.ball_mass * (slope.x**2 + slope.y**2) + governor.sleeve_mass * slope.z**2


def spindle_inertia_slope(governor: Governor, angle: Any) -> Any:
    return slope_of(lambda at: 2 * governor.ball_mass * places_of(governor, at).x ** 2, angle)


def moment_of(governor: Governor, angle: Any, speed: float, sleeve_force: Any = 0.0) -> Any:
    """Return the moment of centrifugal load, weights and a force on the sleeve (N, downward) along the arm angle."""
    slope, g = slopes_of(governor, angle), governor.gravity
    weights = 2 * governor.ball_mass * g * slope.y + (governor.sleeve_mass * g + sleeve_force) * slope.z
    return speed**2 * spindle_inertia_slope(governor, angle) / 2 - weights


def acceleration_of(governor: Governor, angle: float, rate: float, speed: float, sleeve_force: float = 0.0) -> float:
    """Return the angular acceleration from I q'' + I' q'^2 / 2 = moment."""
    turning = slope_of(lambda at: inertia_of(governor, at), angle) * rate**2 / 2
    return (moment_of(governor, angle, speed, sleeve_force) - turning) / inertia_of(governor, angle)


lengths, masses = st.floats(0.05, 0.3), st.floats(0.5, 10.0)
HARTNELL = st.builds(
    hartnell.HartnellGovernor,
    ball_arm=lengths,
    sleeve_arm=lengths,
    pivot_radius=st.floats(0.2, 0.4),
    ball_mass=masses,
    angle=st.floats(1.2, 2.0),
    sleeve_mass=st.floats(0.0, 5.0),
    gravity=st.floats(1.0, 20.0),
)
PROELL = st.builds(
    proell.ProellGovernor,
    arm=st.floats(0.2, 0.3),
    link=st.floats(0.3, 0.4),
    extension=lengths,
    bend=st.floats(-0.8, 0.3),
    ball_mass=masses,
    sleeve_mass=st.floats(0.0, 50.0),
    offset=st.floats(-0.05, 0.05),
    lug_offset=st.floats(-0.03, 0.05),
    gravity=st.floats(1.0, 20.0),
)
# Angles at which the links lean by less than 65 deg: steps of 2e-3 rad then leave some eleven digits of a slope, nine of a second one.
CASES = st.one_of(st.tuples(HARTNELL, st.floats(-0.6, 0.6)), st.tuples(PROELL, st.floats(0.35, 0.9)))
rates, speeds, forces = st.floats(-3.0, 3.0), st.floats(0.0, 40.0), st.floats(-50.0, 500.0)


def near(value: float, scale: float) -> Any:
    return pytest.approx(value, rel=1e-7, abs=1e-7 * scale)


@given(CASES, rates, speeds, forces, st.floats(0.0, 200.0))
def test_the_arms_move_as_lagranges_equation_says(case, rate, speed, force, damping) -> None:
    governor, angle = case
    closed = hartnell if isinstance(governor, hartnell.HartnellGovernor) else proell
    load = {"spring_force": force} if closed is hartnell else {}
    braking = (load.get("spring_force", 0.0)) + damping * slopes_of(governor, angle).z * rate
    expected = acceleration_of(governor, angle, rate, speed, braking)
    found = closed.arm_acceleration(governor, arm_angle=angle, arm_rate=rate, spindle_speed=speed, damping=damping, **load)
    lever = max(map(abs, slopes_of(governor, angle)))
    inertia = inertia_of(governor, angle)
    scale = (governor.ball_mass * lever * (speed**2 + governor.gravity + rate**2) + abs(braking) * lever) / inertia
    assert found == near(expected, scale)
    assert closed.ball_radius(governor, arm_angle=angle) == pytest.approx(places_of(governor, angle).x, rel=1e-13)
    if closed is hartnell:
        assert hartnell.sleeve_height(governor, arm_angle=angle) == pytest.approx(places_of(governor, angle).z, abs=1e-15)


@given(CASES)
def test_what_is_not_given_is_not_there(case) -> None:
    governor, angle = case
    state = {"arm_angle": angle, "arm_rate": 1.5, "spindle_speed": 12.0}
    if isinstance(governor, hartnell.HartnellGovernor):
        nothing = hartnell.arm_acceleration(governor, **state, spring_force=0.0, damping=0.0)
        assert hartnell.arm_acceleration(governor, **state) == nothing
        return
    assert proell.arm_acceleration(governor, **state) == proell.arm_acceleration(governor, **state, damping=0.0)
    if moment_of(governor, angle, 0.0) * spindle_inertia_slope(governor, angle) < 0.0:
        nothing = proell.equilibrium_speed(governor, arm_angle=angle, sleeve_force=0.0)
        assert proell.equilibrium_speed(governor, arm_angle=angle) == nothing


@given(CASES, rates, speeds, st.floats(0.01, 2.0), st.floats(-5.0, 5.0))
def test_the_torque_changes_the_angular_momentum_of_the_spindle(case, rate, speed, constant_inertia, torque) -> None:
    governor, angle = case
    closed = hartnell if isinstance(governor, hartnell.HartnellGovernor) else proell
    state = {"arm_angle": angle, "arm_rate": rate, "spindle_speed": speed}
    found = closed.spindle_acceleration(governor, **state, constant_inertia=constant_inertia, torque=torque)
    taken = spindle_inertia_slope(governor, angle) * rate * speed
    whole = constant_inertia + 2 * governor.ball_mass * places_of(governor, angle).x ** 2
    resolved = np.finfo(np.float64).tiny  # a torque of 5e-324 N m has no digits
    assert found * whole == pytest.approx(torque - taken, rel=1e-9, abs=max(resolved, 1e-10 * (abs(torque) + abs(taken))))


@given(CASES, forces)
def test_in_equilibrium_no_moment_is_left(case, force) -> None:
    governor, angle = case
    closed = hartnell if isinstance(governor, hartnell.HartnellGovernor) else proell
    load = {"spring_force" if closed is hartnell else "sleeve_force": force}
    outward = moment_of(governor, angle, 0.0, force)
    assume(abs(outward) > 1e-9)  # N m: the sign of a smaller one is that of rounding
    if outward * spindle_inertia_slope(governor, angle) > 0.0:
        refuses("no speed holds the balls there", closed.equilibrium_speed, governor, arm_angle=angle, **load)
        return
    speed = closed.equilibrium_speed(governor, arm_angle=angle, **load)
    assert moment_of(governor, angle, speed, force) == pytest.approx(0.0, abs=1e-9 * abs(outward) + 1e-11)
    if closed is hartnell:
        assert hartnell.spring_force(governor, arm_angle=angle, spindle_speed=speed) == pytest.approx(force, rel=1e-9, abs=1e-8)


@given(CASES, speeds, forces, st.floats(0.0, 2e4))
def test_the_frequency_is_the_slope_of_the_moment_over_the_inertia(case, speed, force, spring_rate) -> None:
    governor, angle = case
    if isinstance(governor, hartnell.HartnellGovernor):
        load = {"spring_force": force, "spring_rate": spring_rate}
        found = hartnell.squared_natural_frequency(governor, arm_angle=angle, spindle_speed=speed, **load)
    else:
        force = spring_rate = 0.0
        found = proell.squared_natural_frequency(governor, arm_angle=angle, spindle_speed=speed)
    height = places_of(governor, angle).z

    def moment(at: Any) -> Any:
        return moment_of(governor, at, speed, force + spring_rate * (places_of(governor, at).z - height))

    inertia = inertia_of(governor, angle)
    scale = governor.ball_mass * (speed**2 + governor.gravity) + abs(force) + spring_rate
    assert found * inertia == near(-slope_of(moment, angle), 0.1 * scale)


@given(HARTNELL, st.floats(0.01, 0.5), st.floats(0.0, 40.0))
def test_the_textbooks_balance_the_moments_of_upright_arms(governor, radius, speed) -> None:
    load = hartnell.textbook_sleeve_force(governor, ball_radius=radius, spindle_speed=speed)
    centrifugal = governor.ball_mass * speed**2 * radius
    assert load / 2 * governor.sleeve_arm == pytest.approx(centrifugal * governor.ball_arm, rel=1e-14)
    assert hartnell.textbook_speed(governor, ball_radius=radius, sleeve_force=load) == pytest.approx(speed, rel=1e-14)


@given(st.floats(-0.9, 0.9), st.floats(0.1, 1.0), st.floats(-0.1, 0.1))
def test_an_upright_bend_is_the_lean_of_the_lower_arm(share, link, lug_offset) -> None:
    bend = proell.upright_bend(joint_radius=lug_offset + share * link, link=link, lug_offset=lug_offset)
    assert math.sin(-bend) == pytest.approx(share, abs=1e-12)
    with pytest.raises(MechanismError, match="the link is too short to reach the joint"):
        proell.upright_bend(joint_radius=lug_offset + math.copysign(1.001, share) * link, link=link, lug_offset=lug_offset)
