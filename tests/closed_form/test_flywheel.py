"""Closed forms of the air-expansion engine and its flywheel: Redtenbacher's numbers, other routes to them, textbook problems, refusals."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from governor_mechanism.closed_form import flywheel, flywheel_equilibrium
from governor_mechanism.closed_form import flywheel_engine as closed
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.errors import MechanismError
from reference import flywheel as printed
from refusing import refuses

ENGINE = AirEngine(**printed.ENGINE)
ROUNDED_ENGINE = replace(ENGINE, load_pressure=printed.ROUNDED_CONSTANT[0] * math.pi / 2 * 1e5)
CLOSED_ENGINE = replace(ENGINE, load_pressure=closed.closing_load_pressure(ENGINE))

OTHER_ENGINES = [
    replace(ENGINE, pump_area=0.03, pump_stroke=0.9, load_pressure=0.5e5),
    replace(ENGINE, cut_off=0.02, pump_clearance=0.1, back_pressure=0.2e5, load_pressure=0.1e5),  # cut off before suction opens
    replace(ENGINE, cut_off=0.95, pump_clearance=0.01, load_pressure=1.5e5),  # cut off after delivery opens
    replace(ENGINE, cut_off=1.0, clearance=0.0, load_pressure=1e5),
    replace(ENGINE, cut_off=0.0, clearance=0.3, back_pressure=0.0, load_pressure=0.2e5),
]

DIGITS = 2e-12
"""Twelve printed digits of numbers of the order of one."""


def test_the_limits_of_the_intervals():
    np.testing.assert_allclose(np.degrees(ENGINE.interval_limits), printed.INTERVAL_LIMITS_DEG, rtol=4e-12)


@pytest.mark.parametrize("case", printed.CASES)
def test_angles_bracket_and_coefficient(case):
    load, area_ratio, slowest, fastest, bracket, coefficient = printed.CASES[case]
    engine = replace(ENGINE, load_pressure=load * 1e5, pump_area=area_ratio * ENGINE.area)
    extremes = flywheel_equilibrium.energy_fluctuation(engine)
    # Where the torque is nearly flat, the load's twelve digits give eleven of an angle.
    np.testing.assert_allclose(np.degrees([extremes.slowest_angle, extremes.fastest_angle]), [slowest, fastest], rtol=1e-11)
    terms = flywheel_equilibrium.bracket_terms(engine, slowest_angle=extremes.slowest_angle, fastest_angle=extremes.fastest_angle)
    assert sum(terms) == pytest.approx(bracket, abs=DIGITS)
    assert extremes.energy / engine.full_pressure_work == pytest.approx(bracket, abs=DIGITS)
    assert 2250 * 4 / load * sum(terms) == pytest.approx(coefficient, rel=1e-11)


def test_the_roots_lie_in_the_first_and_third_interval_only():
    found = flywheel_equilibrium.find_equilibria(ROUNDED_ENGINE)
    assert [(one.interval, one.is_slowest) for one in found] == [(1, True), (3, False)]
    np.testing.assert_allclose(np.degrees([one.angle for one in found]), printed.ROUNDED_CONSTANT[1:3], rtol=DIGITS)
    for one in found:
        assert abs(flywheel_equilibrium.balance(ROUNDED_ENGINE, crank_angle=one.angle)) < 1e-12  # its slope there is below 100 per rad
    terms = flywheel_equilibrium.bracket_terms(ENGINE, slowest_angle=found[0].angle, fastest_angle=found[1].angle)
    assert sum(terms) == pytest.approx(printed.ROUNDED_CONSTANT[3], abs=DIGITS)


def test_the_second_and_fourth_equation_keep_their_sign():
    first, second, third = ENGINE.interval_limits
    inside = flywheel_equilibrium.balance(ENGINE, crank_angle=np.linspace(first, second, 2001))
    # The maximum is on a grid of 0.015 deg.
    assert np.min(inside) == pytest.approx(printed.BALANCE_62_RANGE[0], abs=6e-7)
    assert np.max(inside) == pytest.approx(printed.BALANCE_62_RANGE[1], abs=6e-7)
    fourth = np.asarray(flywheel_equilibrium.balance(ENGINE, crank_angle=np.linspace(third, math.pi - 1e-6, 500)))
    assert fourth[0] == pytest.approx(printed.BALANCE_64_START, abs=6e-7)
    assert np.all(np.diff(fourth) < 0)


def test_the_equations_of_the_four_intervals():
    """(61) to (64) as printed, with the minus sign of (61) in letters."""
    p, r, m, k = 4.0, 1.5, 0.05, 0.25
    for degrees in (2.0, 20.0, 60.0, 90.0, 120.0, 130.0, 170.0):
        phi = math.radians(degrees)
        u, cosine, load = (1 - math.cos(phi)) / 2, math.cos(phi), k / math.sin(phi)
        first, second, third = np.degrees(ENGINE.interval_limits)
        expansion = (0.05 + 0.375) / (0.05 + u) * p
        compression = (1 - cosine) / (2 * m + 1 + cosine)
        if degrees < first:
            expected = p - r - load + m / (m + u) * p - (m + 1) / (m + 1 - u)
        elif degrees < second:
            expected = p - r - compression - load
        elif degrees < third:
            expected = expansion - r - compression - load
        else:
            expected = expansion - r - (p - 1) - load
        assert flywheel_equilibrium.balance(ROUNDED_ENGINE, crank_angle=phi) == pytest.approx(expected, abs=1e-12)


def test_the_seven_terms():
    found = flywheel_equilibrium.bracket_terms(ENGINE, slowest_angle=math.radians(3), fastest_angle=math.radians(95))
    np.testing.assert_allclose(found, printed.TERMS_AT_PRINTED_ANGLES, atol=DIGITS)
    assert sum(found) == pytest.approx(printed.SUM_AT_PRINTED_ANGLES, abs=DIGITS)
    extremes = flywheel_equilibrium.energy_fluctuation(ENGINE)
    exact = flywheel_equilibrium.bracket_terms(ENGINE, slowest_angle=extremes.slowest_angle, fastest_angle=extremes.fastest_angle)
    np.testing.assert_allclose(exact, printed.TERMS_AT_EXACT_ANGLES, atol=DIGITS)
    wrong = flywheel_equilibrium.bracket_terms(
        replace(ENGINE, back_pressure=2e5), slowest_angle=math.radians(3), fastest_angle=math.radians(95)
    )
    assert wrong[2] == pytest.approx(printed.WRONG_THIRD_TERM, abs=DIGITS)


def test_the_bracket_is_the_difference_of_the_stored_work_also_for_unequal_cylinders():
    engine = OTHER_ENGINES[0]
    angles = math.radians(7), math.radians(101)
    work = np.diff(closed.stored_work(engine, crank_angle=np.array(angles)))[0]
    terms = flywheel_equilibrium.bracket_terms(engine, slowest_angle=angles[0], fastest_angle=angles[1])
    assert sum(terms) == pytest.approx(work / engine.full_pressure_work, abs=1e-14)


@pytest.mark.parametrize("valve", ["suction_travel", "delivery_travel"])
def test_the_bracket_holds_up_to_a_cut_off_at_which_a_valve_of_the_pump_opens(valve):
    engine = replace(ENGINE, cut_off=getattr(ENGINE, valve))
    first, second, third = engine.interval_limits
    angles = 0.5 * first, 0.5 * (second + third)
    work = np.diff(closed.stored_work(engine, crank_angle=np.array(angles)))[0]
    terms = flywheel_equilibrium.bracket_terms(engine, slowest_angle=angles[0], fastest_angle=angles[1])
    assert sum(terms) == pytest.approx(work / engine.full_pressure_work, abs=1e-14)
    for slowest, fastest in ((0.0, second), (first, third)):  # the ends of both intervals belong to them
        work = np.diff(closed.stored_work(engine, crank_angle=np.array([slowest, fastest])))[0]
        terms = flywheel_equilibrium.bracket_terms(engine, slowest_angle=slowest, fastest_angle=fastest)
        assert sum(terms) == pytest.approx(work / engine.full_pressure_work, abs=1e-14)


def test_stored_work_at_the_listed_angles():
    degrees = np.array(list(printed.STORED_WORK))
    found = np.asarray(closed.stored_work(ENGINE, crank_angle=np.radians(degrees))) / ENGINE.full_pressure_work
    np.testing.assert_allclose(found, list(printed.STORED_WORK.values()), atol=DIGITS)


@pytest.mark.parametrize("engine", [ENGINE, *OTHER_ENGINES])
def test_stored_work_is_the_integral_of_the_torques(engine):
    """By the pressures over the piston's travel, and by the torque over the crank angle, two turns on."""

    def torque(angle):
        return closed.gas_torque(engine, crank_angle=angle) - engine.load_torque

    limits = [limit for limit in engine.interval_limits if 0 < limit < math.pi]
    for end in (0.3, 1.2, 2.0, 3.0):
        inside = [limit for limit in limits if limit < end]
        integral, _ = quad(torque, 0.0, end, points=inside, epsabs=1e-8, epsrel=1e-12)
        assert closed.stored_work(engine, crank_angle=end) == pytest.approx(integral, abs=1e-10 * engine.full_pressure_work)
        later = 2 * math.tau + end
        expected = integral + 4 * closed.net_work(engine)
        assert closed.stored_work(engine, crank_angle=later) == pytest.approx(expected, abs=1e-10 * engine.full_pressure_work)


def test_work_of_a_stroke_and_the_loads_that_close_the_cycle():
    unit = ENGINE.area * ENGINE.stroke * ENGINE.atmospheric_pressure
    assert closed.gas_work(ENGINE) / unit == pytest.approx(printed.EXPANSION_WORK + printed.PUMP_WORK, abs=1e-11)
    assert closed.net_work(ENGINE) / ENGINE.full_pressure_work == pytest.approx(printed.NET_WORK_RATIO, abs=DIGITS)
    assert closed.closing_load_pressure(ENGINE) / 1e5 == pytest.approx(printed.CASES["closed by the load"][0], abs=DIGITS)
    assert closed.closing_area_ratio(ENGINE) == pytest.approx(printed.CASES["closed by the pump"][1], abs=DIGITS)
    engine = OTHER_ENGINES[0]
    closing = replace(engine, pump_area=closed.closing_area_ratio(engine) * engine.area)
    assert abs(closed.net_work(closing)) < 1e-12 * engine.full_pressure_work


def test_pressures_are_continuous_where_their_laws_change():
    for engine in (ENGINE, *OTHER_ENGINES[:3]):
        for limit in engine.interval_limits:
            sides = np.array([limit - 1e-9, limit + 1e-9])
            for pressure in (closed.expansion_pressure, closed.suction_pressure, closed.delivery_pressure):
                assert np.ptp(pressure(engine, crank_angle=sides)) < 1e-6 * engine.supply_pressure  # slopes are below 100 p per rad


SMALL_PUMP_CLEARANCE = {"clearance": 0.0, "atmospheric_pressure": 1e5}
ENGINES_WITH_TWO_MAXIMA = [
    AirEngine(area=0.05, stroke=1.06, cut_off=0.47, pump_area=0.395, pump_stroke=1.47, pump_clearance=8.75e-4, supply_pressure=3.73e5,
              back_pressure=1.68e5, load_pressure=5.85e4, **SMALL_PUMP_CLEARANCE),
    AirEngine(area=0.003, stroke=1.23, cut_off=1.0, pump_area=0.29, pump_stroke=0.786, pump_clearance=4.1e-5, supply_pressure=7.6e5,
              back_pressure=1.45e5, load_pressure=1.82e5, **SMALL_PUMP_CLEARANCE),
]  # fmt: skip


@pytest.mark.parametrize("engine", [CLOSED_ENGINE, ENGINE, *ENGINES_WITH_TWO_MAXIMA])
def test_the_energy_is_the_largest_rise_of_the_stored_work(engine):
    """Also of two maxima in a stroke, which the paper holds for impossible; cycles that close or lose work."""
    equilibria = flywheel_equilibrium.find_equilibria(engine)
    assert len(equilibria) == (4 if engine in ENGINES_WITH_TWO_MAXIMA else 2)
    assert [one.is_slowest for one in equilibria] == [True, False] * (len(equilibria) // 2)
    extremes = flywheel_equilibrium.energy_fluctuation(engine)
    grid = np.sort(np.concatenate([np.linspace(0.0, math.tau, 4001), [extremes.slowest_angle, extremes.fastest_angle]]))
    work = np.asarray(closed.stored_work(engine, crank_angle=grid))
    starts = np.flatnonzero(grid < math.pi)
    rises = [np.max(work[(grid >= grid[i]) & (grid <= grid[i] + math.pi)]) - work[i] for i in starts]
    assert extremes.energy == pytest.approx(max(rises), abs=1e-12 * engine.full_pressure_work)


def test_the_load_at_the_crank_pin():
    assert ENGINE.load_torque / (ENGINE.stroke / 2) == pytest.approx(2 / math.pi * 0.4e5 * 0.05, rel=1e-15)  # (60)
    assert CLOSED_ENGINE.load_torque == pytest.approx(printed.EXAMPLE_LOAD_TORQUE, rel=1e-11)


def test_the_flywheel_of_the_example():
    extremes = flywheel_equilibrium.energy_fluctuation(CLOSED_ENGINE)
    requirement = {"energy": extremes.energy, "energy_ratio": printed.ENERGY_RATIO}
    inertia = flywheel.inertia_for_energy_ratio(**requirement, mean_speed=printed.MEAN_SPEED)
    assert extremes.energy == pytest.approx(printed.EXAMPLE_ENERGY, rel=DIGITS)
    assert inertia == pytest.approx(printed.EXAMPLE_INERTIA, rel=DIGITS)
    angles = np.array([0.0, extremes.slowest_angle, extremes.fastest_angle, extremes.fastest_angle + 7 * math.pi])
    speeds = flywheel_equilibrium.shaft_speed(CLOSED_ENGINE, crank_angle=angles, inertia=inertia, mean_speed=printed.MEAN_SPEED)
    expected = [printed.EXAMPLE_START_SPEED, printed.EXAMPLE_LOWEST_SPEED, *[printed.EXAMPLE_HIGHEST_SPEED] * 2]
    np.testing.assert_allclose(speeds, expected, rtol=DIGITS)
    assert flywheel.coefficient_of_energy_ratio(energy_ratio=20.0) == pytest.approx(printed.EXAMPLE_COEFFICIENT, abs=6e-10)
    assert (speeds[2] - speeds[1]) / printed.MEAN_SPEED == pytest.approx(printed.EXAMPLE_COEFFICIENT, abs=6e-10)
    weight = flywheel.rim_weight(**requirement, rim_speed=1.5 * printed.MEAN_SPEED, gravity=9.81)
    assert weight / 9.81 * 1.5**2 == pytest.approx(inertia, rel=1e-14)


def test_the_speed_agrees_with_an_integrated_motion():
    inertia, limits = printed.EXAMPLE_INERTIA, [0.0, *CLOSED_ENGINE.interval_limits, math.pi]
    speed = printed.EXAMPLE_START_SPEED

    def slope(angle, state):
        return (closed.gas_torque(CLOSED_ENGINE, crank_angle=angle) - CLOSED_ENGINE.load_torque) / (inertia * state)

    for start, end in itertools.pairwise(limits):  # from one corner of the torque to the next
        run = solve_ivp(slope, (start, np.nextafter(end, 0)), [speed], method="DOP853", rtol=1e-12, atol=1e-12)
        speed = run.y[0, -1]
        expected = flywheel_equilibrium.shaft_speed(CLOSED_ENGINE, crank_angle=run.t[-1], inertia=inertia, mean_speed=printed.MEAN_SPEED)
        assert speed == pytest.approx(expected, abs=1e-10)


def test_the_paper_s_ratio_and_its_coefficient_agree_to_first_order():
    for ratio in (10.0, 100.0, 1000.0):
        coefficient = flywheel.coefficient_of_energy_ratio(energy_ratio=ratio)
        assert coefficient == pytest.approx(1 / (2 * ratio), rel=0.04 / ratio**2)  # the next term is 1 / 32 mu^2 of it
    # kinetic energies of 9 J and 25 J: their mean over their difference
    assert flywheel.energy_ratio_of_speeds(inertia=2.0, energy=16.0, lowest=3.0, highest=5.0) == pytest.approx(17 / 16, rel=1e-15)
    given = {"inertia": 3000.0, "energy": 3000.0, "mean_speed": 6.0}
    for has_mean_energy in (False, True):
        low, high = flywheel.speed_limits(**given, mean_energy=has_mean_energy)
        assert 1500 * (high**2 - low**2) == pytest.approx(3000.0, rel=1e-12)
    assert flywheel.inertia_for_coefficient(energy=3000.0, mean_speed=6.0, coefficient=1 / 36) == pytest.approx(3000.0, rel=1e-14)


@pytest.mark.parametrize("has_mean_energy", [True, False])
def test_a_flywheel_is_heavy_enough_until_its_lowest_speed_is_zero(has_mean_energy):
    largest = 6.0**2 if has_mean_energy else 2 * 6.0**2  # E / J at which the lowest speed is 0
    low, high = flywheel.speed_limits(inertia=1.0, energy=0.999 * largest, mean_speed=6.0, mean_energy=has_mean_energy)
    assert 0.0 < low < 0.2 * high
    assert (high**2 - low**2) / 2 == pytest.approx(0.999 * largest, rel=1e-12)
    with pytest.raises(MechanismError, match="flywheel is too light"):
        flywheel.speed_limits(inertia=1.0, energy=1.001 * largest, mean_speed=6.0, mean_energy=has_mean_energy)


def test_a_shaft_gives_all_its_energy_until_it_stands():
    assert flywheel.speed_after_work(inertia=2.0, start_speed=1.0, work=-0.75) == pytest.approx(0.5, rel=1e-15)
    assert flywheel.speed_after_work(inertia=2.0, start_speed=1.0, work=-1.0) == 0.0


def test_rim_and_arms_follow_their_rules():
    assert flywheel.rim_mass(inertia=8.0, radius=2.0) == 2.0  # all of it at the radius
    thickness = flywheel.rim_thickness(mass=1000.0, radius=1.5, density=7200.0, width_ratio=2.0)
    assert math.tau * 1.5 * 2 * thickness**2 * 7200 == pytest.approx(1000.0, rel=1e-14)
    assert flywheel.rim_stress(density=7200.0, rim_speed=20.0) == 2.88e6
    moment = flywheel.arm_bending_moment(torque=6000.0, radius=1.5, hub_radius=0.3, arms=6.0)
    assert moment == pytest.approx(800.0, rel=1e-14)
    depth = flywheel.arm_major_axis(bending_moment=moment, stress=15e6)
    second_moment = math.pi / 64 * depth**3 * (depth / 2)  # of an ellipse
    assert moment * (depth / 2) / second_moment == pytest.approx(15e6, rel=1e-13)


def test_textbook_limits_of_speed():
    """Khurmi, chapter 16, example 16.1: 6500 kg at 1.8 m, 56 kJ, 120 rpm; printed 121 and 119 rpm."""
    low, high = flywheel.speed_limits(inertia=6500 * 1.8**2, energy=56000.0, mean_speed=4 * math.pi)
    assert high * 30 / math.pi == pytest.approx(121.01032519301476, rel=1e-12)
    assert low * 30 / math.pi == pytest.approx(118.98967480698524, rel=1e-12)
    assert (round(high * 30 / math.pi), round(low * 30 / math.pi)) == (121, 119)


def test_textbook_torque_of_the_second_harmonic():
    """Khurmi, example 16.11: 20000 + 9500 sin 2t - 5700 cos 2t N m at 180 rpm, coefficient 0.01.

    Printed: 377 kW, 11078 N m (cut off), 3121 kg m2 and 3.044 rad/s2; the last two with a rounded pi, so that they differ by 1e-3.
    """
    energy = flywheel.harmonic_energy(amplitude=math.hypot(9500, 5700), order=2)
    inertia = flywheel.inertia_for_coefficient(energy=energy, mean_speed=6 * math.pi, coefficient=0.01)
    assert math.floor(energy) == 11078
    assert energy == pytest.approx(11078.80860020607, rel=1e-12)
    assert inertia == pytest.approx(3118.105557554973, rel=1e-12)
    assert inertia == pytest.approx(3121, rel=1e-3)
    assert 9500 / inertia == pytest.approx(3.044, rel=1e-3)  # the surplus at 45 deg
    assert round(20000 * 6 * math.pi / 1e3) == 377


def test_textbook_torque_of_the_third_harmonic():
    """Khurmi, example 16.13: 5000 + 1500 sin 3t N m, 1000 kg m2, 300 rpm; printed 157.1 kW and 0.1 %."""
    energy = flywheel.harmonic_energy(amplitude=1500.0, order=3)
    low, high = flywheel.speed_limits(inertia=1000.0, energy=energy, mean_speed=10 * math.pi)
    assert energy == pytest.approx(1000.0, rel=1e-15)
    assert 100 * (high - low) / (10 * math.pi) == pytest.approx(0.1013211836423378, rel=1e-11)
    assert round(100 * (high - low) / (10 * math.pi), 1) == 0.1


def test_textbook_press():
    """Sarkar, chapter 6, example 9: 60 kg m2 at 360 rpm gives 7500 J in a second, of which the motor gives 5000; printed 10.7 rpm."""
    drop = 360 - flywheel.speed_after_work(inertia=60.0, start_speed=12 * math.pi, work=-2500.0) * 30 / math.pi
    assert drop == pytest.approx(10.713711653571117, rel=1e-11)
    assert round(drop, 1) == 10.7


def test_textbook_gas_engine():
    """Bevan, chapter 12, example 10: 25 hp at 300 rpm, triangular torques, expansion 2.3 times compression, coefficient 0.02.

    Printed 13710 lb ft2. A four-stroke engine: 150 cycles in a minute; a triangle of work W has a height of 2 W / pi.
    """
    work = 25 * 33000 / 150  # ft lbf per cycle
    compression, expansion = work / 1.3, 2.3 * work / 1.3
    corners = math.pi * np.array([0, 1, 1.5, 2, 2.5, 3, 4])
    torques = 2 / math.pi * np.array([0, 0, -compression, 0, expansion, 0, 0])
    energy = flywheel.table_energy(angles=corners, torques=torques)
    inertia = 32.2 * flywheel.inertia_for_coefficient(energy=energy, mean_speed=10 * math.pi, coefficient=0.02)
    assert inertia == pytest.approx(13709.760834025916, rel=1e-12)
    assert round(inertia, -1) == 13710


def test_a_torque_that_is_the_load_stores_nothing():
    steps = {"angles": np.array([0.0, 1.0, 1.0, 2.0, 2.0, 3.0]), "torques": np.array([2.0, 2.0, 1.0, 1.0, 0.0, 0.0])}
    assert flywheel.table_energy(**steps) == pytest.approx(1.0, rel=1e-15)  # 1 N m above the mean over 1 rad
    assert flywheel.table_energy(angles=np.array([0.0, 2.0]), torques=np.full(2, 5.0)) == 0.0
    # a triangle that crosses its mean of 1 N m in the middle of both sides
    assert flywheel.table_energy(angles=np.array([0.0, 1.0, 2.0]), torques=np.array([0.0, 2.0, 0.0])) == pytest.approx(0.5, rel=1e-15)


def test_the_table_and_the_harmonic_agree():
    angles = np.linspace(0.0, math.tau, 20001)
    found = flywheel.table_energy(angles=angles, torques=50 + 7 * np.cos(3 * angles))
    assert found == pytest.approx(flywheel.harmonic_energy(amplitude=7.0, order=3), rel=1e-6)  # (3 h)^2 / 12 of a chord


def test_loads_and_wheels_that_cannot_be_are_refused():
    with pytest.raises(
        MechanismError, match=r"cannot carry the load: .* never exceeds .* the shaft stalls; reduce load_pressure"
    ) as refused:
        flywheel_equilibrium.energy_fluctuation(replace(ENGINE, load_pressure=5e5))
    stated = float(re.search(r"at most ([\d.]+) N m", str(refused.value))[1])
    assert stated == pytest.approx(np.max(closed.gas_torque(ENGINE, crank_angle=np.linspace(0.0, math.pi, 10001))), rel=1e-5)
    replace(ENGINE, pump_clearance=0.99 / (ENGINE.supply_pressure / ENGINE.atmospheric_pressure - 1))  # a hundredth below the largest
    assert flywheel_equilibrium.find_equilibria(replace(ENGINE, load_pressure=5e5)) == ()
    with pytest.raises(MechanismError, match=r"can carry no load: in a stroke the air does -"):
        closed.closing_load_pressure(replace(ENGINE, back_pressure=3e5))
    refuses("no pump closes the cycle", closed.closing_area_ratio, replace(ENGINE, load_pressure=3e5))
    with pytest.raises(MechanismError, match=r"slowest_angle must lie in its interval of the bracket, 0 to 45\.573 deg; got 50 deg"):
        flywheel_equilibrium.bracket_terms(ENGINE, slowest_angle=math.radians(50), fastest_angle=math.radians(95))
    with pytest.raises(MechanismError, match=r"fastest_angle must lie in its interval .* take differences of the stored work"):
        flywheel_equilibrium.bracket_terms(ENGINE, slowest_angle=0.05, fastest_angle=3.0)
    with pytest.raises(MechanismError, match="the bracket needs a suction valve that opens before the cut-off"):
        flywheel_equilibrium.bracket_terms(OTHER_ENGINES[1], slowest_angle=0.05, fastest_angle=1.6)
    for angle in (3.5, np.array([1.0, 3.5])):
        refuses("crank_angle must lie between two dead centres", flywheel_equilibrium.balance, ENGINE, crank_angle=angle)


def test_numbers_give_floats_and_arrays_broadcast():
    assert isinstance(closed.stored_work(ENGINE, crank_angle=1.0), float)
    assert closed.gas_torque(ENGINE, crank_angle=np.zeros((2, 3))).shape == (2, 3)
    found = flywheel.inertia_for_coefficient(energy=np.array([1.0, 2.0]), mean_speed=3.0, coefficient=np.array([[0.1], [0.2]]))
    assert found.shape == (2, 2)
