"""The isochronous parabola: recomputed design numbers, the circle of curvature, the guide, and refusals."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp

from governor_mechanism.closed_form import parabolic as isochronous
from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from printed_numbers import half_unit_of_last_digit, is_printed
from reference import zehnder

DESIGN = zehnder.DESIGN
RATIO = DESIGN["mass_ratio"]
SPEEDS = tuple(math.tau * rpm / 60 for rpm in DESIGN["speeds_rpm"])
PARAMETER = isochronous.double_parameter(spindle_speed=SPEEDS[0], mass_ratio=RATIO)
START = (1000 * math.sqrt(1 + RATIO) / DESIGN["speeds_rpm"][0] - 1) / 100  # Zehnder's rule, in cm and rpm
START_ANGLE = math.atan(2 * START / PARAMETER)
RADIUS = isochronous.radius_of_curvature(abscissa=START, double_parameter=PARAMETER)


def design(arm: float) -> PendulumGovernor:
    """A governor through the start of the design, with its angle there."""
    return PendulumGovernor(arm=arm, ball_mass=30.0, sleeve_mass=120.0, offset=START - arm * math.sin(START_ANGLE))


def test_the_design_example_is_met_to_the_printed_digits() -> None:
    is_printed(SPEEDS[0], DESIGN["speeds"][0])
    is_printed(SPEEDS[1], DESIGN["speeds"][1])
    is_printed(SPEEDS[0] ** 2 / 80 - 1, DESIGN["mass_ratio_limits"][0], digits=6)
    is_printed(SPEEDS[0] ** 2 / 15 - 1, DESIGN["mass_ratio_limits"][1], digits=6)
    is_printed(PARAMETER, DESIGN["double_parameter"])
    is_printed(START, DESIGN["start_abscissa"])
    height = isochronous.parabola_height(abscissa=START, double_parameter=PARAMETER)
    is_printed(height, DESIGN["start_height"])
    is_printed(math.tan(START_ANGLE), DESIGN["start_tangent"])
    is_printed(math.degrees(START_ANGLE), DESIGN["start_angle_deg"], digits=10)
    is_printed(RADIUS, DESIGN["radius_of_curvature"])
    is_printed(1e4 * RADIUS**2, DESIGN["radius_squared_cm2"], digits=8)
    is_printed(1e4 * (PARAMETER + 4 * height) ** 3 / (4 * PARAMETER), DESIGN["radius_squared_cm2"], digits=8)
    is_printed(-START * math.tan(START_ANGLE) ** 2, DESIGN["osculating_offset"])


def test_the_trial_speeds_of_the_design_are_met() -> None:
    for degrees, speed in DESIGN["trial_speeds"]:
        angle = START_ANGLE + math.radians(degrees)
        is_printed(pendulum.equilibrium_speed(design(RADIUS), arm_angle=angle), speed, digits=9)


@pytest.mark.parametrize("row", DESIGN["upper_positions"], ids=["radius of curvature", "shorter", "on the axis"])
def test_the_upper_position_of_the_design_is_the_only_one_above_the_start(row: tuple[Any, ...]) -> None:
    arm, offset, degrees, abscissa, lift = row
    length = {"radius of curvature": RADIUS, 0.3: 0.3}.get(arm, START / math.sin(START_ANGLE))
    if arm != "radius of curvature":
        is_printed(length, arm)
    governor = design(length)
    assert abs(governor.offset - offset) <= max(half_unit_of_last_digit(offset), 1e-16)  # zero to rounding on the axis
    found = pendulum.equilibrium_angles(governor, spindle_speed=SPEEDS[1], lowest=START_ANGLE)
    assert found.size == 1
    is_printed(math.degrees(found[0]), degrees)
    is_printed(pendulum.ball_radius(governor, arm_angle=float(found[0])), abscissa)
    is_printed(2 * length * (math.cos(START_ANGLE) - math.cos(found[0])), lift)


@pytest.mark.parametrize("row", zehnder.OSCULATION, ids=lambda row: f"{row[0]}deg")
def test_the_speed_changes_on_leaving_the_osculation_point_as_recomputed(row: tuple[float, ...]) -> None:
    angle = START_ANGLE + math.radians(row[0])
    for share, change in zip(zehnder.OSCULATION_ARMS, row[1:], strict=True):
        speed = pendulum.equilibrium_speed(design(share * RADIUS), arm_angle=angle)
        # the change cancels from 1 to as little as 3e-4: 1e-15 of double precision on top of the printed digits
        assert abs(speed / SPEEDS[0] - 1 - change) <= half_unit_of_last_digit(change) + 1e-15


def test_the_speed_is_least_at_the_osculation_point() -> None:
    governor = design(RADIUS)
    # sin^3 a = -e / l there; rounding
    assert_allclose(pendulum.least_stable_angle(governor), START_ANGLE, rtol=1e-14)
    assert abs(pendulum.stiffness(governor, arm_angle=START_ANGLE)) < 1e-11  # N m/rad, of terms near 1e3


@given(st.floats(0.01, 0.5), st.floats(0.05, 3.0))
def test_the_osculating_arm_is_the_radius_of_curvature(abscissa: float, parameter: float) -> None:
    angle = math.atan(2 * abscissa / parameter)
    radius = isochronous.radius_of_curvature(abscissa=abscissa, double_parameter=parameter)
    # cos^2 of a steep angle loses up to three digits
    assert_allclose(abscissa / (math.sin(angle) * math.cos(angle) ** 2), radius, rtol=1e-12)
    assert_allclose(radius, (parameter**2 + 4 * abscissa**2) ** 1.5 / (2 * parameter**2), rtol=1e-13)


def test_the_parabola_rises_at_45_degrees_where_x_is_twice_y() -> None:
    x = isochronous.double_parameter(spindle_speed=SPEEDS[0], mass_ratio=RATIO) / 2
    assert_allclose(x, 2 * isochronous.parabola_height(abscissa=x, double_parameter=PARAMETER), rtol=1e-15)
    assert_allclose(2 * x / PARAMETER, 1.0, rtol=1e-15)


def test_neighbouring_parabolas_part_most_at_the_abscissa_of_45_degrees() -> None:
    low, high = SPEEDS

    def angle_between(abscissa: Any) -> Any:
        slopes = [2 * abscissa / isochronous.double_parameter(spindle_speed=speed, mass_ratio=RATIO) for speed in (low, high)]
        return np.arctan(slopes[1]) - np.arctan(slopes[0])

    best = isochronous.double_parameter(spindle_speed=math.sqrt(low * high), mass_ratio=RATIO) / 2
    angle = angle_between(best)
    assert_allclose(math.tan(angle), (high**2 - low**2) / (2 * low * high), rtol=1e-13)  # rounding
    assert np.all(angle_between(best * np.array([0.9, 0.99, 1.01, 1.1])) < angle)


GUIDE_CASE = zehnder.GUIDE
GUIDE: dict[str, Any] = {
    "start": GUIDE_CASE["start"],
    "start_rate": GUIDE_CASE["start_rate"],
    "mass_ratio": GUIDE_CASE["mass_ratio"],
    "double_parameter": isochronous.double_parameter(spindle_speed=GUIDE_CASE["spindle_speed"], mass_ratio=GUIDE_CASE["mass_ratio"]),
}


def test_the_transit_in_the_isochronous_guide_takes_the_recomputed_time() -> None:
    is_printed(GUIDE["double_parameter"], GUIDE_CASE["double_parameter"])
    is_printed(isochronous.guide_transit_time(end=GUIDE_CASE["end"], **GUIDE), GUIDE_CASE["time"])


def test_the_transit_time_is_the_integral_of_the_inverse_rate_also_across_the_axis() -> None:
    k = 2 * math.sqrt(1 + 2 * GUIDE["mass_ratio"]) / GUIDE["double_parameter"]  # x' sqrt(1 + k^2 x^2) is constant
    time, _ = quad(lambda x: math.hypot(1, k * x) / (GUIDE["start_rate"] * math.hypot(1, -0.1 * k)), -0.1, 0.2, epsabs=1e-13)
    assert_allclose(isochronous.guide_transit_time(end=0.2, **{**GUIDE, "start": -0.1}), time, rtol=1e-13)  # quadrature


def test_the_guide_is_neutral_at_the_speed_it_is_made_for() -> None:
    mass, load, c, speed = 1.0, 4.0, GUIDE["double_parameter"], GUIDE_CASE["spindle_speed"]

    def law(_: float, state: Any) -> list[float]:
        """Ball at height x^2 / c and sleeve at twice that: Lagrange's equation with every force written out."""
        x, rate = state
        slope = 2 * x / c
        inertia = 2 * mass * (1 + slope**2) + load * (2 * slope) ** 2
        change = 2 * mass * 2 * slope * 2 / c + load * 8 * slope * 2 / c
        force = 2 * mass * speed**2 * x - 9.81 * (2 * mass + 2 * load) * slope
        return [rate, (force - change * rate**2 / 2) / inertia]

    end = solve_ivp(law, (0, GUIDE_CASE["time"]), [0.1, 0.05], method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    # the time is given to 12 digits, the integrator leaves some 1e-12
    assert_allclose(end, [GUIDE_CASE["end"], GUIDE_CASE["end_rate"]], rtol=2e-11)


def test_a_guided_ball_that_need_not_move_arrives_at_once() -> None:
    assert isochronous.guide_transit_time(end=GUIDE["start"], **{**GUIDE, "start_rate": 0.0}) == 0.0


def test_numbers_give_floats_and_arrays_broadcast() -> None:
    assert type(PARAMETER) is float
    grid = isochronous.radius_of_curvature(abscissa=np.array([0.1, 0.2]), double_parameter=np.array([[0.5], [0.6]]))
    assert grid.shape == (2, 2)
    assert grid[1, 0] == isochronous.radius_of_curvature(abscissa=0.1, double_parameter=0.6)
