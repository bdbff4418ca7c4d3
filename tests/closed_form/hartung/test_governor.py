"""Hartung's governor: the rigid-body tables, identities between the formulas, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import approx_fprime

from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.closed_form.hartung import HartungGovernor
from governor_mechanism.errors import MechanismError
from hartung_scenes import sleeve_height_at
from printed_numbers import is_printed
from reference import hartung
from refusing import refuses

PAPERS = HartungGovernor(**hartung.GOVERNOR)
HUNG = HartungGovernor(**hartung.GOVERNOR, hanger=hartung.HANGER_LENGTH)


def spring_force(governor: HartungGovernor, angle: float) -> float:
    """Of the paper's spring (N)."""
    x = float(closed.weight_radius(governor, lever_angle=angle))
    return hartung.PRELOAD + hartung.SPRING_RATE * (x - hartung.PRELOAD_RADIUS)


def at_rest(governor: HartungGovernor, angle: float) -> dict[str, float]:
    """Everything that the rigid-body tables list."""
    force = spring_force(governor, angle)
    speed = float(closed.equilibrium_speed(governor, lever_angle=angle, spring_force=force))
    sprung: dict[str, Any] = {"lever_angle": angle, "spring_force": force, "spring_rate": hartung.SPRING_RATE}
    square = float(closed.squared_natural_frequency(governor, **sprung))
    x = float(closed.weight_radius(governor, lever_angle=angle))
    inertia_derivative = -4 * governor.weight_mass * x * governor.weight_arm * math.cos(angle)
    total_inertia = hartung.SPINDLE_INERTIA + 2 * governor.weight_mass * x**2
    inertia = float(closed.lever_inertia(governor, lever_angle=angle))
    # The angular momentum of a free spindle adds w^2 J'^2 / (J0 + J) to the stiffness.
    stiffness = float(closed.stiffness(governor, **sprung, spindle_speed=speed)) + (speed * inertia_derivative) ** 2 / total_inertia
    return {
        "radius": float(closed.weight_radius(governor, lever_angle=angle)),
        "force": force,
        "speed": speed,
        "rpm": speed * 30 / math.pi,
        "stiffness": float(closed.stiffness(governor, **sprung, spindle_speed=speed)),
        "inertia": float(closed.lever_inertia(governor, lever_angle=angle)),
        "frequency": math.sqrt(square),
        "free": stiffness / inertia,
        "static": float(closed.static_sleeve_force(governor, lever_angle=angle, spring_force=force)),
    }


@pytest.mark.parametrize("row", hartung.VERTICAL_HANGER, ids=lambda row: f"{row[0]} deg")
def test_the_table_of_vertical_hangers_is_met_to_its_twelve_digits(row: tuple[float, ...]) -> None:
    for value, printed in zip(at_rest(PAPERS, math.radians(row[0])).values(), row[1:], strict=True):
        is_printed(value, printed)


@pytest.mark.parametrize("row", hartung.INCLINED_HANGER, ids=lambda row: f"{row[0]} deg")
def test_the_table_of_short_hangers_is_met_to_its_twelve_digits(row: tuple[float, ...]) -> None:
    found = at_rest(HUNG, math.radians(row[0]))
    for name, printed in zip(("speed", "stiffness", "inertia", "frequency", "static"), row[1:], strict=True):
        is_printed(found[name], printed)


def test_table_2_is_met_within_slide_rule_work_but_for_one_misprint() -> None:
    off = []
    for radius, degrees, *forces in hartung.TABLE_2:
        angle = math.asin((122 - radius) / 115)
        is_printed(math.degrees(angle), degrees)
        for speed, printed, recomputed in zip(hartung.PRINTED_SPEEDS, forces[::2], forces[1::2], strict=True):
            force = closed.astatic_spring_force(PAPERS, lever_angle=angle, spindle_speed=speed)
            is_printed(float(force) / hartung.GRAVITY, recomputed)
            if abs(printed - recomputed) > hartung.SLIDE_RULE_TOLERANCE:
                off.append((radius, printed))
    radius, printed, meant = hartung.MISPRINT
    assert off == [(radius, printed)]
    assert abs(meant - hartung.TABLE_2[0][5]) < hartung.SLIDE_RULE_TOLERANCE


@pytest.mark.parametrize(
    ("angle_deg", "arm", "printed"), [(132.0, 0.17, hartung.STATIC_FORCES_132), (hartung.ANGLE_DEG, None, hartung.STATIC_FORCES_CORRECTED)]
)
def test_the_static_force_over_the_stroke(angle_deg: float, arm: float | None, printed: tuple[float, ...]) -> None:
    governor = of_angle(angle_deg, arm)
    for value, wanted in zip(static_forces(governor, 7) / hartung.GRAVITY, printed, strict=True):
        is_printed(float(value), wanted, digits=8)


@pytest.mark.parametrize(("angle_deg", "percent"), hartung.STATIC_FORCE_SPREADS)
def test_how_constant_the_static_force_is(angle_deg: float, percent: float) -> None:
    found = closed.relative_spread(static_forces(of_angle(angle_deg), 101))
    assert abs(100 * found - percent) < 0.0051  # printed with two decimals; the angles, too


def of_angle(degrees: float, arm: float | None = None) -> HartungGovernor:
    """The paper's governor with another bell crank; b from hangers symmetric about the axis."""
    even = hartung.GOVERNOR["fulcrum_radius"] / (math.sin(math.radians(degrees)) * math.cos(math.radians(15)))
    return HartungGovernor(**{**hartung.GOVERNOR, "angle": math.radians(degrees), "sleeve_arm": even if arm is None else arm})


def static_forces(governor: HartungGovernor, count: int) -> np.ndarray:
    """S (count,) N over the stroke, of the straight spring through both speeds."""
    ends = (math.radians(15), math.radians(-15))
    forces = [
        closed.astatic_spring_force(governor, lever_angle=end, spindle_speed=speed)
        for end, speed in zip(ends, hartung.PRINTED_SPEEDS, strict=True)
    ]
    angles = np.linspace(*ends, count)
    x = np.asarray(closed.weight_radius(governor, lever_angle=angles))
    line = np.interp(x, [x[0], x[-1]], forces)
    return np.asarray(closed.static_sleeve_force(governor, lever_angle=angles, spring_force=line))


@st.composite
def governors(draw: st.DrawFn) -> tuple[HartungGovernor, float]:
    """A governor, and a lever angle well within what it can do."""
    arm, other = draw(st.floats(0.05, 0.5)), draw(st.floats(0.05, 0.5))
    angle, lever = draw(st.floats(1.6, 2.5)), draw(st.floats(-0.3, 0.3))
    radius = arm * draw(st.floats(0.6, 2.0))
    hanger = draw(st.sampled_from([math.inf, 1.5 * (radius + other)]))
    governor = HartungGovernor(
        weight_arm=arm,
        sleeve_arm=other,
        angle=angle,
        fulcrum_radius=radius,
        weight_mass=draw(st.floats(1.0, 100.0)),
        sleeve_mass=draw(st.floats(0.5, 100.0)),
        hanger=hanger,
        lug_radius=draw(st.floats(0.0, 0.1)),
    )
    assume(float(closed.lift_derivative(governor, lever_angle=lever)) < -0.05 * other)  # away from its change point
    return governor, lever


@given(governors(), st.floats(5.0, 60.0))
def test_both_forms_of_the_static_force_agree_at_rest(found: tuple[HartungGovernor, float], speed: float) -> None:
    governor, angle = found
    # Both are sums of terms no larger than these, so that rounding stays below 1e-12 of them.
    force = float(closed.astatic_spring_force(governor, lever_angle=angle, spindle_speed=speed))
    full = float(closed.static_sleeve_force(governor, lever_angle=angle, spring_force=force))
    # S = 2 C (a / b) cos alpha / sin(g + alpha) of the centrifugal force C; z' replaces b sin for a hanger
    centrifugal = governor.weight_mass * speed**2 * float(closed.weight_radius(governor, lever_angle=angle))
    lever = governor.weight_arm * math.cos(angle) / -float(closed.lift_derivative(governor, lever_angle=angle))
    simple = 2 * centrifugal * lever
    load = 9.81 * (governor.sleeve_mass + governor.weight_mass * 20)  # 2 a / b is 20 at most
    assert full == pytest.approx(simple, rel=1e-12, abs=1e-12 * load)


@given(governors(), st.floats(5.0, 60.0))
def test_the_stiffness_is_the_slope_of_the_balance(found: tuple[HartungGovernor, float], speed: float) -> None:
    """Another route: the moment about the lever angle from the equation of motion, differentiated numerically."""
    governor, angle = found
    rate, preload = 3e4, 2000.0
    middle = float(closed.weight_radius(governor, lever_angle=angle))

    def moment(lever: np.ndarray) -> float:
        x = float(closed.weight_radius(governor, lever_angle=float(lever[0])))
        force = preload + rate * (x - middle)
        bend = closed.lever_acceleration(governor, lever_angle=float(lever[0]), lever_rate=0.0, spring_force=force, spindle_speed=speed)
        return -float(bend) * float(closed.lever_inertia(governor, lever_angle=float(lever[0])))

    stiff = float(closed.stiffness(governor, lever_angle=angle, spring_force=preload, spring_rate=rate, spindle_speed=speed))
    slope = float(approx_fprime(np.array([angle]), moment, 1e-7)[0])
    size = 2 * governor.weight_arm * (rate * governor.weight_arm + preload + governor.weight_mass * speed**2)
    assert abs(stiff - slope) < 1e-5 * size  # a one-sided difference over 1e-7 rad is right to about 1e-7 of the terms


@given(governors())
def test_the_lift_and_its_slope_belong_together(found: tuple[HartungGovernor, float]) -> None:
    governor, angle = found
    h = 1e-5
    ends = [float(sleeve_height_at(governor, angle + step)) for step in (-h, h)]
    slope = float(closed.lift_derivative(governor, lever_angle=angle))
    assert (ends[1] - ends[0]) / (2 * h) == pytest.approx(slope, abs=1e-8)  # h^2 of a third derivative, 1e-11 / h


def test_a_motion_keeps_its_energy() -> None:
    """Kinetic energy, spring and weights less the turning's share, along a solution of the equation of motion."""

    def slope(_: float, state: np.ndarray) -> list[float]:
        force = spring_force(HUNG, state[0])
        bend = closed.lever_acceleration(HUNG, lever_angle=state[0], lever_rate=state[1], spring_force=force, spindle_speed=21.9)
        return [state[1], float(bend)]

    found = solve_ivp(slope, (0.0, 1.0), [0.1, 0.3], method="DOP853", rtol=1e-12, atol=1e-14)
    angles, rates = found.y
    x = np.asarray(closed.weight_radius(HUNG, lever_angle=angles))
    pull = hartung.PRELOAD + hartung.SPRING_RATE * (x - hartung.PRELOAD_RADIUS)
    kinetic = 0.5 * np.asarray(closed.lever_inertia(HUNG, lever_angle=angles)) * rates**2
    potential = pull**2 / hartung.SPRING_RATE - 45 * 21.9**2 * x**2 + 2 * 45 * 9.81 * 0.115 * np.cos(angles)
    total = kinetic + potential + 15 * 9.81 * sleeve_height_at(HUNG, angles)
    np.testing.assert_allclose(total, total[0], rtol=1e-10)  # the integration's tolerance, over some hundred steps


def test_the_spindle_keeps_its_angular_momentum_but_for_the_torque():
    angle, rate, speed, torque, constant, step = 0.1, 0.7, 25.0, 12.0, 3.0, 1e-5
    rates = {"lever_rate": rate, "spindle_speed": speed, "constant_inertia": constant, "torque": torque}
    acceleration = float(closed.spindle_acceleration(PAPERS, lever_angle=angle, **rates))

    def momentum(time: float) -> float:
        radius = float(closed.weight_radius(PAPERS, lever_angle=angle + rate * time))
        return (constant + 2 * PAPERS.weight_mass * radius**2) * (speed + acceleration * time)

    # The error of the difference is of second order in the step, the rounding of the momentum is 1e-15 of it over the step.
    assert (momentum(step) - momentum(-step)) / (2 * step) == pytest.approx(torque, rel=1e-7)


def test_the_lever_at_its_change_point_lifts_nothing():
    governor = HartungGovernor(**{**hartung.GOVERNOR, "angle": 0.5, "gravity": 0.0})
    refuses("with a mean other than zero", closed.relative_spread, np.array([1.0, -1.0]))
    with pytest.raises(MechanismError, match="change point"):  # the arm of the sleeve points along the spindle: a sine of 0 exactly
        closed.static_sleeve_force(governor, lever_angle=-0.5, spring_force=1.0)
