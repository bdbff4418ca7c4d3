"""Pendulum governors: the closed forms against recomputed numbers, against each other, and their refusals."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.errors import MechanismError
from printed_numbers import is_printed
from reference import EQUILIBRIUM_TABLES, zehnder
from reference import pendulum as linkage
from refusing import refuses

RPM = math.tau / 60
ROWS = [(name, row) for name, table in EQUILIBRIUM_TABLES.items() for row in table["rows"]]


def governor_of(table: dict[str, Any]) -> PendulumGovernor:
    return PendulumGovernor(**table["dimensions"])


def equal_speed_offset(arm: float, low: float, high: float) -> float:
    """Return the offset at which two arm angles (rad) have the same equilibrium speed in a rhombus."""
    return -arm * math.sin(low) * math.sin(high) * math.sin((low + high) / 2) / math.cos((high - low) / 2)


def link_angle(governor: PendulumGovernor, angle: Any) -> Any:
    return np.arcsin((governor.offset + governor.joint_length * np.sin(angle) - governor.lug_radius) / governor.link_length)


def sleeve_height(governor: PendulumGovernor, angle: Any) -> Any:
    return -governor.joint_length * np.cos(angle) - governor.link_length * np.cos(link_angle(governor, angle))


def sleeve_derivative(governor: PendulumGovernor, angle: float) -> float:
    return governor.joint_length * (math.sin(angle) + math.cos(angle) * math.tan(link_angle(governor, angle)))


def potential(governor: PendulumGovernor, *, arm_angle: Any) -> Any:
    """Return the potential energy of all weights (J), zero at the suspension."""
    arms = (2 * governor.ball_mass + governor.arm_mass) * governor.arm + governor.link_mass * governor.joint_length
    lifted = (governor.sleeve_mass + governor.link_mass) * sleeve_height(governor, arm_angle)
    return governor.gravity * (lifted - arms * np.cos(arm_angle))


def jacobi_integral(governor: PendulumGovernor, angle: Any, rate: Any, speed: float) -> Any:
    kinetic = linkage.in_plane_inertia(governor, arm_angle=angle) * rate**2 / 2
    return kinetic + potential(governor, arm_angle=angle) - speed**2 * pendulum.spindle_inertia(governor, arm_angle=angle) / 2


def free_spindle_frequency_squared(governor: PendulumGovernor, angle: Any, constant_inertia: float) -> Any:
    speed = pendulum.equilibrium_speed(governor, arm_angle=angle)
    coupling = (speed * linkage.spindle_inertia_derivative(governor, arm_angle=angle)) ** 2
    total = constant_inertia + pendulum.spindle_inertia(governor, arm_angle=angle)
    stiffness = pendulum.stiffness(governor, arm_angle=angle) + coupling / total
    return stiffness / linkage.in_plane_inertia(governor, arm_angle=angle)


PORTER = governor_of(zehnder.PORTER_OPEN)
CROSSED = governor_of(zehnder.CROSSED)
UNCROSSED_LINKS = governor_of(zehnder.CROSSED_ARMS_OPEN_LINKS)
SHORT_LINKS = dataclasses.replace(UNCROSSED_LINKS, link=0.15)  # end of reach where sin a = 0.88, at 61.6 deg
SNAP_STOPS = np.radians(zehnder.FOLD_JUMP["stops_deg"])
SNAP = PendulumGovernor(
    arm=zehnder.FOLD_JUMP["arm"],
    ball_mass=zehnder.FOLD_JUMP["ball_mass"],
    offset=equal_speed_offset(zehnder.FOLD_JUMP["arm"], float(SNAP_STOPS[0]), float(SNAP_STOPS[1])),
)
GENERAL = PendulumGovernor(
    arm=0.4,
    ball_mass=3.0,
    offset=0.03,
    arm_joint=0.28,
    link=0.33,
    lug_offset=0.06,
    sleeve_mass=12.0,
    arm_mass=0.7,
    link_mass=0.4,
    ball_inertia=0.003,
)


@st.composite
def linkages(draw: Callable[..., Any]) -> PendulumGovernor:
    """Governors of every make: off the axis, crossed, extended arms, links of their own, rods with mass."""
    arm = draw(st.floats(0.2, 0.6))
    joint = draw(st.floats(0.4, 1.0)) * arm
    offset = draw(st.floats(-0.1, 0.15))
    return PendulumGovernor(
        arm=arm,
        ball_mass=draw(st.floats(0.5, 10.0)),
        offset=offset,
        arm_joint=joint,
        link=joint * draw(st.floats(0.8, 1.4)),
        lug_offset=offset + draw(st.floats(-0.05, 0.05)),
        sleeve_mass=draw(st.floats(0.0, 40.0)),
        arm_mass=draw(st.floats(0.0, 1.0)),
        link_mass=draw(st.floats(0.0, 1.0)),
        ball_inertia=draw(st.floats(0.0, 0.01)),
    )


angles = st.floats(math.radians(25), math.radians(50))


def slope_of(function: Callable[[Any], Any], at: float, step: float = 1e-3) -> float:
    """First derivative by central differences over nine points: error of order step^8, rounding about eps / step."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    values = function(at + step * np.arange(-4, 5))
    return float(weights @ values / step)


# --- equilibrium, stability, oscillation: the tables -----------------------------------------------------------------


@pytest.mark.parametrize(("name", "row"), ROWS, ids=lambda value: value if isinstance(value, str) else f"{value[0]}deg")
def test_every_row_of_the_tables_is_met_to_the_printed_digits(name: str, row: tuple[float, ...]) -> None:
    table = EQUILIBRIUM_TABLES[name]
    governor, angle = governor_of(table), math.radians(row[0])
    speed = pendulum.equilibrium_speed(governor, arm_angle=angle)
    is_printed(speed, row[1])
    is_printed(speed / RPM, row[2])
    is_printed(pendulum.stiffness(governor, arm_angle=angle), row[3])
    is_printed(linkage.in_plane_inertia(governor, arm_angle=angle), row[4])
    is_printed(pendulum.squared_oscillation_frequency(governor, arm_angle=angle), row[5])
    is_printed(free_spindle_frequency_squared(governor, angle, table["rest_inertia"]), row[6])


@pytest.mark.parametrize("row", zehnder.FOLD_JUMP["rows"], ids=lambda row: f"{row[0]}deg")
def test_every_row_of_the_jumping_governor_is_met(row: tuple[float, ...]) -> None:
    speed = pendulum.equilibrium_speed(SNAP, arm_angle=math.radians(row[0]))
    is_printed(speed, row[1])
    is_printed(speed / RPM, row[2])
    is_printed(pendulum.squared_oscillation_frequency(SNAP, arm_angle=math.radians(row[0])), row[3])


def test_the_equilibrium_speed_of_a_rhombus_is_zehnders_third_equation() -> None:
    angle = np.radians(np.linspace(12, 80, 18))
    for governor in (PORTER, CROSSED, SNAP):
        x = governor.offset + governor.arm * np.sin(angle)
        load = governor.gravity * (1 + governor.sleeve_mass / governor.ball_mass)
        # 1e-14: some forty roundings, the two formulas being the same
        assert_allclose(pendulum.equilibrium_speed(governor, arm_angle=angle) ** 2, load * np.tan(angle) / x, rtol=1e-14)


def test_the_equilibrium_speed_of_a_general_linkage_is_that_of_virtual_work() -> None:
    governor = dataclasses.replace(GENERAL, arm_mass=0.0, link_mass=0.0, ball_inertia=0.0)
    angle = np.radians(np.linspace(-5, 60, 14))[2:]
    link = np.arcsin((0.03 + 0.28 * np.sin(angle) - 0.06) / 0.33)
    x = 0.03 + 0.4 * np.sin(angle)
    squared = (np.tan(angle) + (4 * 0.28 / 0.8) * (np.tan(angle) + np.tan(link))) * 9.81 / x
    possible = squared > 0
    speed = pendulum.equilibrium_speed(governor, arm_angle=angle[possible])
    assert possible.sum() > 8
    assert_allclose(speed**2, squared[possible], rtol=1e-13)  # rounding; the sum cancels near the least angle


def test_crossed_arms_with_uncrossed_links_meet_the_exact_numbers() -> None:
    for degrees, link, speed in zehnder.CROSSED_ARMS_OPEN_LINKS["rows"]:
        is_printed(pendulum.equilibrium_speed(UNCROSSED_LINKS, arm_angle=math.radians(degrees)), speed)
        found = math.degrees(link_angle(UNCROSSED_LINKS, math.radians(degrees)))
        assert abs(found - link) <= 0.505e-6  # printed to six decimals


def test_an_extended_arm_counts_as_a_heavier_ball_at_the_joint() -> None:
    extended = governor_of(zehnder.EXTENDED_ARM)
    angle = math.radians(zehnder.EXTENDED_ARM["arm_angle_deg"])
    is_printed(pendulum.equilibrium_speed(extended, arm_angle=angle), zehnder.EXTENDED_ARM["spindle_speed"])
    # (Ia): P = P1 l / l1 is the ball at the joint with the same ratio of falling and rising speed
    reduced = PendulumGovernor(arm=0.25, offset=0.03, ball_mass=0.4 / 0.25, sleeve_mass=3.0)
    ratios = [
        linkage.rising_speed(governor, arm_angle=angle, resistance=-2.0) / linkage.rising_speed(governor, arm_angle=angle, resistance=2.0)
        for governor in (extended, reduced)
    ]
    assert_allclose(*ratios, rtol=1e-14)  # rounding


def test_the_least_speed_of_crossed_arms_stands_at_the_least_stable_angle() -> None:
    marks = zehnder.CROSSED_MARKS
    angle = pendulum.least_stable_angle(CROSSED)
    is_printed(math.degrees(angle), marks["least_stable_deg"])
    speed = pendulum.equilibrium_speed(CROSSED, arm_angle=angle)
    is_printed(speed, marks["lowest_speed"])
    is_printed(speed / RPM, marks["lowest_speed_rpm"])
    assert abs(pendulum.stiffness(CROSSED, arm_angle=angle)) < 1e-12  # N m/rad, of terms near 100: rounding
    assert abs(pendulum.ball_radius(CROSSED, arm_angle=math.radians(marks["ball_on_axis_deg"]))) < 1e-14
    for degrees, growth in marks["growth_rates"]:
        squared = pendulum.squared_oscillation_frequency(CROSSED, arm_angle=math.radians(degrees))
        is_printed(math.sqrt(-squared), growth)


def test_the_marks_of_the_jumping_governor_are_met() -> None:
    snap = zehnder.FOLD_JUMP
    low, high = (float(angle) for angle in SNAP_STOPS)
    is_printed(SNAP.offset, snap["offset"])
    is_printed(SNAP.offset / SNAP.arm, snap["offset_over_arm"])
    turn = pendulum.least_stable_angle(SNAP)
    is_printed(math.degrees(turn), snap["least_stable_deg"])
    speed, least = (pendulum.equilibrium_speed(SNAP, arm_angle=angle) for angle in (low, turn))
    is_printed(speed, snap["stop_speed"])
    is_printed(pendulum.equilibrium_speed(SNAP, arm_angle=high), snap["stop_speed"])
    is_printed(speed / RPM, snap["stop_speed_rpm"])
    is_printed(least, snap["lowest_speed"])
    is_printed(least / RPM, snap["lowest_speed_rpm"])
    is_printed(speed / least - 1, snap["hysteresis"], digits=8)
    is_printed(math.sqrt(-pendulum.squared_oscillation_frequency(SNAP, arm_angle=low)), snap["growth_rate_lower_stop"])
    is_printed(math.sqrt(pendulum.squared_oscillation_frequency(SNAP, arm_angle=high)), snap["frequency_upper_stop"])
    drop = jacobi_integral(SNAP, low, 0.0, speed)
    drop -= jacobi_integral(SNAP, high, 0.0, speed)
    is_printed(drop, snap["effective_energy_drop"])
    is_printed(math.sqrt(2 * drop / linkage.in_plane_inertia(SNAP, arm_angle=high)), snap["arrival_rate"])
    loaded = dataclasses.replace(SNAP, sleeve_mass=4.0)
    is_printed(pendulum.equilibrium_speed(loaded, arm_angle=low), snap["mass_ratio_4"]["stop_speed"])
    is_printed(pendulum.equilibrium_speed(loaded, arm_angle=turn), snap["mass_ratio_4"]["lowest_speed"])


def test_a_spherical_pendulum_oscillates_at_the_textbook_frequency() -> None:
    governor = PendulumGovernor(arm=0.7, ball_mass=1.3)
    angle = np.radians([5.0, 30.0, 60.0, 85.0])
    speed = pendulum.equilibrium_speed(governor, arm_angle=angle)
    free = free_spindle_frequency_squared(governor, angle, 0.0)
    assert_allclose(free, speed**2 * (1 + 3 * np.cos(angle) ** 2), rtol=1e-13)  # rounding
    forced = pendulum.squared_oscillation_frequency(governor, arm_angle=angle)
    assert_allclose(forced, (speed * np.sin(angle)) ** 2, rtol=1e-12)  # rounding; K cancels to sin^2 of its terms


# --- friction --------------------------------------------------------------------------------------------------------


def test_the_friction_band_meets_the_recomputed_numbers() -> None:
    band = zehnder.FRICTION_BAND
    angle, resistance = math.radians(band["arm_angle_deg"]), band["resistance"]
    is_printed(linkage.rising_speed(PORTER, arm_angle=angle, resistance=resistance), band["rising_speed"])
    is_printed(linkage.rising_speed(PORTER, arm_angle=angle, resistance=-resistance), band["falling_speed"])
    is_printed(pendulum.equilibrium_speed(PORTER, arm_angle=angle), band["equilibrium_speed"])


@given(linkages(), angles, st.floats(0.0, 0.99))
def test_the_friction_band_is_the_insensitivity_in_every_linkage(governor: PendulumGovernor, angle: float, share: float) -> None:
    try:
        speed = pendulum.equilibrium_speed(governor, arm_angle=angle)
        resistance = share * linkage.potential_derivative(governor, arm_angle=angle) / sleeve_derivative(governor, angle)
        up = linkage.rising_speed(governor, arm_angle=angle, resistance=resistance)
        down = linkage.rising_speed(governor, arm_angle=angle, resistance=-resistance)
    except MechanismError:
        assume(False)
    # rounding (some 1e-15), a hundredfold in the falling speed where the resistance comes near the load
    assert_allclose((up**2 - down**2) / (2 * speed**2), share, rtol=1e-12, atol=1e-14)


# --- geometry and derivatives ----------------------------------------------------------------------------------------


PAIRS = [
    (potential, linkage.potential_derivative),
    (linkage.potential_derivative, linkage.potential_second_derivative),
    (pendulum.spindle_inertia, linkage.spindle_inertia_derivative),
    (linkage.in_plane_inertia, linkage.in_plane_inertia_derivative),
]


@pytest.mark.parametrize(("function", "slope"), PAIRS, ids=lambda function: function.__name__)
@pytest.mark.parametrize("governor", [PORTER, CROSSED, UNCROSSED_LINKS, GENERAL], ids=["porter", "crossed", "links", "rods"])
def test_every_slope_is_the_derivative_of_its_function(
    function: Callable[..., Any], slope: Callable[..., Any], governor: PendulumGovernor
) -> None:
    for degrees in (12.0, 25.0, 40.0):
        angle = math.radians(degrees)
        difference = slope_of(lambda at: function(governor, arm_angle=at), angle)
        size = abs(function(governor, arm_angle=angle))
        # nine points at 1e-3 rad: rounding of the function over the step, 1e-16 / 1e-3, leaves twelve digits
        assert_allclose(slope(governor, arm_angle=angle), difference, rtol=1e-11, atol=2e-12 * size)


@given(linkages(), angles)
def test_stiffness_is_half_the_slope_of_inertia_times_the_slope_of_squared_speed(governor: PendulumGovernor, angle: float) -> None:
    step = 1e-4
    try:
        squared = pendulum.equilibrium_speed(governor, arm_angle=angle + step * np.arange(-4, 5)) ** 2
    except MechanismError:
        assume(False)
    link = link_angle(governor, angle)
    assume(abs(link) < math.radians(70) and pendulum.ball_radius(governor, arm_angle=angle) > 0.02)
    change = slope_of(lambda at: pendulum.equilibrium_speed(governor, arm_angle=at) ** 2, angle, step)
    lever = linkage.spindle_inertia_derivative(governor, arm_angle=angle)
    # rounding of w^2 (some 1e-15 of it) over the step of 1e-4 rad; K itself may cancel to nothing
    noise = 3e-11 * abs(lever) * float(np.max(squared))
    assert_allclose(pendulum.stiffness(governor, arm_angle=angle), lever * change / 2, rtol=1e-8, atol=noise)


@given(linkages(), angles, st.floats(0.0, 30.0))
def test_the_stiffness_at_any_speed_is_the_slope_of_the_moment(governor: PendulumGovernor, angle: float, speed: float) -> None:
    def moment(at: Any) -> Any:
        centrifugal = speed**2 * linkage.spindle_inertia_derivative(governor, arm_angle=at) / 2
        return linkage.potential_derivative(governor, arm_angle=at) - centrifugal

    try:
        slope = slope_of(moment, angle)
    except MechanismError:
        assume(False)
    assume(abs(link_angle(governor, angle)) < math.radians(70))  # as above
    # rounding of the moments over the step of 1e-3 rad leaves some twelve digits of them
    noise = 1e-9 * (float(np.max(np.abs(linkage.potential_derivative(governor, arm_angle=angle)))) + speed**2)
    assert_allclose(pendulum.stiffness(governor, arm_angle=angle, spindle_speed=speed), slope, rtol=1e-8, atol=noise)


def test_the_rod_masses_are_the_sum_over_their_particles() -> None:
    angle, parts = 0.6, 4000
    link = link_angle(GENERAL, angle)
    share = (np.arange(parts) + 0.5) / parts
    turn = 0.28 * math.cos(angle) / (0.33 * math.cos(link))  # db/da
    slope = sleeve_derivative(GENERAL, angle)
    arm_x, arm_y = 0.03 + 0.4 * share * math.sin(angle), -0.4 * share * math.cos(angle)
    link_x = 0.06 + 0.33 * share * math.sin(link)
    link_y = sleeve_height(GENERAL, angle) + 0.33 * share * math.cos(link)
    link_rate = np.hypot(0.33 * share * math.cos(link) * turn, slope - 0.33 * share * math.sin(link) * turn)
    bare = dataclasses.replace(GENERAL, arm_mass=0.0, link_mass=0.0)

    def of_rods(function: Callable[..., Any]) -> float:
        return function(GENERAL, arm_angle=angle) - function(bare, arm_angle=angle)

    arms, links = 2 * 0.7 / parts, 2 * 0.4 / parts
    # 1e-7: the midpoint sum over 4000 particles errs by 1 / (4 parts^2) = 1.6e-8
    assert_allclose(of_rods(potential), 9.81 * (arms * arm_y.sum() + links * link_y.sum()), rtol=1e-7)
    inertia = arms * (arm_x**2).sum() + links * (link_x**2).sum()
    assert_allclose(of_rods(pendulum.spindle_inertia), inertia, rtol=1e-7)
    moving = arms * ((0.4 * share) ** 2).sum() + links * (link_rate**2).sum()
    assert_allclose(of_rods(linkage.in_plane_inertia), moving, rtol=1e-7)


# --- all equilibria at a speed ---------------------------------------------------------------------------------------


def test_crossed_arms_have_two_equilibria_above_the_least_speed_one_at_it_none_below() -> None:
    turn = pendulum.least_stable_angle(CROSSED)
    least = pendulum.equilibrium_speed(CROSSED, arm_angle=turn)
    assert pendulum.equilibrium_angles(CROSSED, spindle_speed=0.9999 * least).size == 0
    # a double root: w to 1e-16 fixes the angle to about 1e-8 only
    assert_allclose(pendulum.equilibrium_angles(CROSSED, spindle_speed=least), [turn], atol=1e-7)
    for ratio in (1 + 1e-10, 1.001, 1.2, 50.0):
        pair = pendulum.equilibrium_angles(CROSSED, spindle_speed=ratio * least)
        assert pair.size == 2
        assert pair[0] < turn < pair[1]
        assert_allclose(pendulum.equilibrium_speed(CROSSED, arm_angle=pair), ratio * least, rtol=1e-12)


def test_equilibria_on_the_stops_count() -> None:
    low, high = (float(angle) for angle in SNAP_STOPS)
    speed = pendulum.equilibrium_speed(SNAP, arm_angle=low)
    found = pendulum.equilibrium_angles(SNAP, spindle_speed=speed, lowest=low, highest=high)
    assert_allclose(found, SNAP_STOPS, rtol=1e-14)  # rounding of w and of the angles
    assert pendulum.equilibrium_angles(SNAP, spindle_speed=1.0001 * speed, lowest=low, highest=high).size == 0


@given(linkages(), st.floats(math.radians(5), math.radians(80)))
def test_the_angle_of_an_equilibrium_speed_is_found_again(governor: PendulumGovernor, angle: float) -> None:
    try:
        speed = pendulum.equilibrium_speed(governor, arm_angle=angle)
        stiffness = pendulum.stiffness(governor, arm_angle=angle)
    except MechanismError:
        assume(False)
    found = pendulum.equilibrium_angles(governor, spindle_speed=speed)
    weight_stiffness = linkage.potential_second_derivative(governor, arm_angle=angle)
    terms = abs(weight_stiffness) + 2 * abs(weight_stiffness - stiffness)  # |V''| + |w^2 J''|
    assume(abs(stiffness) > 1e-4 * terms)  # next to a turning point the speed does not fix the angle
    assert np.all(np.diff(found) > 0)
    assert np.min(np.abs(found - angle)) < 1e-11  # rounding of the moments (1e-15) over K (1e-4 of its terms)


def test_a_watt_governor_leaves_the_axis_only_above_its_critical_speed() -> None:
    governor = PendulumGovernor(arm=0.4, ball_mass=1.0)
    critical = math.sqrt(9.81 / 0.4)
    assert pendulum.equilibrium_angles(governor, spindle_speed=0.999 * critical).size == 0
    for ratio in (1.0000001, 1.5, 20.0):
        found = pendulum.equilibrium_angles(governor, spindle_speed=ratio * critical)
        # cos a = (w0 / w)^2, to the rounding of the angle
        assert_allclose(np.cos(found), [1 / ratio**2], rtol=0, atol=1e-15)


def test_an_open_governor_at_rest_hangs_straight_down() -> None:
    assert_allclose(pendulum.equilibrium_angles(PORTER, spindle_speed=0.0), [0.0], atol=1e-15)


def test_a_travel_out_of_reach_has_no_equilibrium() -> None:
    far = pendulum.equilibrium_angles(SHORT_LINKS, spindle_speed=10.0, lowest=1.1, highest=1.5)
    assert far.size == 0
    assert far.dtype == np.float64
    for speed in (12.0, 20.0, 200.0):
        within = pendulum.equilibrium_angles(SHORT_LINKS, spindle_speed=speed)
        assert within.size >= 1
        # at 200 rad/s the link is 5e-7 short of its reach, so that rounding weighs 1e-16 / 5e-7 in the speed
        assert_allclose(pendulum.equilibrium_speed(SHORT_LINKS, arm_angle=within), speed, rtol=1e-9)


# --- motion ----------------------------------------------------------------------------------------------------------


def motion(governor: PendulumGovernor, speed: float, start: list[float], time: float, **options: Any) -> Any:
    """Arm angle and rate at constant spindle speed; DOP853 at rtol 1e-13, so errors of some 1e-12 over seconds."""

    def law(_: float, state: Any) -> list[float]:
        angle, rate = float(state[0]), float(state[1])
        return [rate, pendulum.arm_acceleration(governor, arm_angle=angle, arm_rate=rate, spindle_speed=speed)]

    return solve_ivp(law, (0, time), start, method="DOP853", rtol=1e-13, atol=1e-14, **options)


def test_the_motion_at_constant_speed_ends_where_the_taylor_series_does() -> None:
    case = zehnder.PORTER_OPEN_MOTION
    speed, end = case["spindle_speed"], case["constant_speed"]
    is_printed(pendulum.equilibrium_speed(PORTER, arm_angle=math.radians(40)), speed, digits=15)
    angle, rate = motion(PORTER, speed, [case["arm_angle"], case["arm_rate"]], case["time"]).y[:, -1]
    # rtol 1e-13 per step leaves 1e-14 in the angle and 1e-13 in the rate here; the reference has 14 and 13 digits
    assert_allclose(angle, end["arm_angle"], rtol=1e-12)
    assert_allclose(rate, end["arm_rate"], rtol=2e-12)
    torque = pendulum.drive_torque(PORTER, arm_angle=float(angle), arm_rate=float(rate), spindle_speed=speed)
    is_printed(torque, end["drive_torque"], digits=11)


def test_the_motion_of_a_free_spindle_ends_where_the_taylor_series_does() -> None:
    case, rest = zehnder.PORTER_OPEN_MOTION, zehnder.PORTER_OPEN["rest_inertia"]

    def law(_: float, state: Any) -> list[float]:
        now = {"arm_angle": float(state[0]), "arm_rate": float(state[1]), "spindle_speed": float(state[3])}
        arms = pendulum.arm_acceleration(PORTER, **now)
        return [now["arm_rate"], arms, now["spindle_speed"], pendulum.spindle_acceleration(PORTER, constant_inertia=rest, **now)]

    start = [case["arm_angle"], case["arm_rate"], 0.0, case["spindle_speed"]]
    end = solve_ivp(law, (0, case["time"]), start, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    expected = [case["free_spindle"][key] for key in ("arm_angle", "arm_rate", "turned", "spindle_speed")]
    assert_allclose(end, expected, rtol=1e-12)  # what the integrator leaves at rtol 1e-13, as above


@pytest.mark.parametrize("governor", [PORTER, UNCROSSED_LINKS, GENERAL], ids=["porter", "links", "rods"])
def test_the_jacobi_integral_keeps_its_value_along_the_motion(governor: PendulumGovernor) -> None:
    speed = pendulum.equilibrium_speed(governor, arm_angle=math.radians(30))
    run = motion(governor, speed, [math.radians(32), 0.3], 3.0)
    value = jacobi_integral(governor, run.y[0], run.y[1], speed)
    swing = linkage.in_plane_inertia(governor, arm_angle=math.radians(32)) * 0.3**2 / 2
    assert np.ptp(run.y[0]) > math.radians(1.5)
    # rtol 1e-13 per step over some two hundred steps, measured on the terms, which outweigh the energy of the swing
    scale = abs(potential(governor, arm_angle=math.radians(32))) + swing
    assert np.ptp(value) < 2e-12 * scale


@pytest.mark.parametrize("way", ["up", "down"])
def test_the_jump_between_the_stops_takes_the_recomputed_time(way: str) -> None:
    case, low, high = zehnder.FOLD_JUMP[way], *(float(angle) for angle in SNAP_STOPS)
    turn = pendulum.least_stable_angle(SNAP)
    start, end = (low, high) if way == "up" else (turn, low)
    speed = case["speed_ratio"] * pendulum.equilibrium_speed(SNAP, arm_angle=start)
    is_printed(speed, case["speed"])

    def arrival(_: float, state: Any) -> float:
        return float(state[0]) - end

    arrival.terminal = True  # type: ignore[attr-defined]
    run = motion(SNAP, speed, [start, 0.0], 5.0, events=arrival)
    # the start is close to an unstable equilibrium: rounding grows e^(2.65 * 2) to e^6 fold, and the event search adds its own
    assert_allclose(run.t_events[0][0], case["time"], rtol=1e-10)
    assert_allclose(abs(run.y_events[0][0][1]), case["arrival_rate"], rtol=1e-10)
    energy = jacobi_integral(SNAP, start, 0.0, speed)
    energy -= jacobi_integral(SNAP, end, 0.0, speed)
    is_printed(math.sqrt(2 * energy / linkage.in_plane_inertia(SNAP, arm_angle=end)), case["arrival_rate"])


def test_an_oil_brake_takes_the_power_of_its_force_at_the_sleeve() -> None:
    state = {"arm_angle": 0.5, "arm_rate": 0.4, "spindle_speed": 9.0}
    free, braked = (pendulum.arm_acceleration(GENERAL, damping=c, **state) for c in (0.0, 120.0))
    lost = linkage.in_plane_inertia(GENERAL, arm_angle=0.5) * (free - braked) * 0.4
    sleeve_speed = sleeve_derivative(GENERAL, 0.5) * 0.4
    assert_allclose(lost, 120.0 * sleeve_speed**2, rtol=1e-12)  # rounding of the difference


def test_the_drive_torque_supplies_what_the_arms_take_in_angular_momentum() -> None:
    state = {"arm_angle": 0.5, "arm_rate": 0.4, "spindle_speed": 9.0}
    torque = pendulum.drive_torque(GENERAL, **state)
    assert_allclose(torque, slope_of(lambda a: pendulum.spindle_inertia(GENERAL, arm_angle=a), 0.5) * 9.0 * 0.4, rtol=1e-10)
    held = pendulum.spindle_acceleration(GENERAL, constant_inertia=0.2, torque=torque, **state)
    assert abs(held) < 1e-14  # rad/s2: the same torque keeps a free spindle at its speed


# --- design ----------------------------------------------------------------------------------------------------------


@given(st.floats(0.1, 1.0), st.floats(0.05, 1.4), st.floats(0.01, 0.1), st.floats(0.0, 10.0))
def test_the_equal_speed_offset_gives_equal_speeds(arm: float, low: float, apart: float, load: float) -> None:
    offset = equal_speed_offset(arm, low, low + apart)
    governor = PendulumGovernor(arm=arm, ball_mass=1.0, sleeve_mass=load, offset=offset)
    first, second = pendulum.equilibrium_speed(governor, arm_angle=np.array([low, low + apart]))
    assert_allclose(first, second, rtol=1e-12)  # x = e + l sin a cancels by up to three digits


def test_numbers_give_floats_and_arrays_broadcast() -> None:
    assert type(pendulum.equilibrium_speed(PORTER, arm_angle=0.5)) is float
    rates = np.array([0.0, 0.1, 0.2])
    grid = pendulum.arm_acceleration(PORTER, arm_angle=np.array([[0.3], [0.5]]), arm_rate=rates, spindle_speed=10.0)
    assert grid.shape == (2, 3)
    assert grid[1, 2] == pendulum.arm_acceleration(PORTER, arm_angle=0.5, arm_rate=0.2, spindle_speed=10.0)
    whole = pendulum.stiffness(PORTER, arm_angle=[1, 0.5])
    assert_allclose(whole, [pendulum.stiffness(PORTER, arm_angle=a) for a in (1.0, 0.5)], rtol=1e-15)


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:overflow")
def test_what_no_table_holds_is_refused_with_the_value() -> None:
    refuses("arm_angle must be a number or an array", linkage.potential_derivative, PORTER, arm_angle=1j)
    refuses("too large or too small for double", pendulum.stiffness, PORTER, arm_angle=0.5, spindle_speed=1e160)


def test_heavy_arms_that_reach_over_the_axis_are_closed_by_the_centrifugal_load():
    # The arms are rods from -0.05 m to the ball at 0.01 m: the moment of their near parts is larger than that of the light balls.
    governor = PendulumGovernor(arm=0.3, offset=-0.05, ball_mass=1e-3, arm_mass=50.0)
    with pytest.raises(MechanismError, match="the centrifugal load does not raise the arms"):
        pendulum.equilibrium_speed(governor, arm_angle=math.asin(0.06 / 0.3))


@pytest.mark.parametrize(
    ("dimensions", "degrees"),
    [
        ({"arm": 0.3}, 89.0),
        ({"arm": 0.2, "offset": 0.466, "link": 0.3, "lug_offset": 0.0, "sleeve_mass": 50.0}, -65.0),  # nearly level links lift the balls
    ],
)
def test_the_search_for_equilibria_covers_arms_that_are_nearly_level(dimensions, degrees):
    governor = PendulumGovernor(ball_mass=0.1, **dimensions)
    angle = math.radians(degrees)
    speed = float(pendulum.equilibrium_speed(governor, arm_angle=angle))
    assert np.min(np.abs(pendulum.equilibrium_angles(governor, spindle_speed=speed) - angle)) < 1e-9


def test_arms_off_the_axis_hang_exactly_down_at_rest():
    governor = PendulumGovernor(arm=0.3, ball_mass=5.0, offset=0.1)
    for lowest in (-0.7, -0.123, -0.01):
        assert pendulum.equilibrium_angles(governor, spindle_speed=0.0, lowest=lowest).tolist() == [0.0]


def test_a_level_link_is_out_of_reach():
    lengths = {"arm": 0.5, "link": 0.25, "offset": 0.5, "lug_offset": 0.25}  # binary fractions: the link is level exactly
    governor = PendulumGovernor(ball_mass=1.0, sleeve_mass=1.0, **lengths)
    refuses(r"the link of 0.25 m cannot reach", pendulum.equilibrium_speed, governor, arm_angle=0.0)


def test_a_link_that_reaches_in_no_more_than_one_position_is_refused():
    with pytest.raises(MechanismError, match="the link cannot reach at any arm angle"):
        PendulumGovernor(arm=0.25, link=0.5, offset=0.75, lug_offset=0.0, ball_mass=1.0, sleeve_mass=1.0)
