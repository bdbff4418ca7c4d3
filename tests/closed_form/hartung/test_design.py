"""The paper's design of a Hartung governor: its numbers recomputed, and what its formulas promise."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.closed_form import hartung as closed
from governor_mechanism.closed_form import hartung_design
from printed_numbers import is_printed
from reference import hartung

KGF = hartung.GRAVITY
SPRING = hartung.SPRING
# The printed inputs of the spring: kgf, cm, cm.
WIRE, COIL, SHEAR = 0.012, 0.08, 750_000 * KGF * 1e4
RATE = hartung.SPRING_RATE


def test_the_angle_follows_from_the_printed_forces() -> None:
    first = hartung_design.spring_abscissa(inner_force=192.0, outer_force=344.0, stroke=0.06)
    is_printed(1e3 * np.asarray(first), hartung.ABSCISSAE_MM[0])
    angle = float(hartung_design.bell_crank_angle(weight_arm=0.115, middle_abscissa=0.106))
    is_printed(math.tan(angle), hartung.TANGENT)
    is_printed(math.degrees(angle), hartung.ANGLE_DEG)


def test_the_sleeve_arm_and_its_travel() -> None:
    swing = math.radians(15)
    arm = hartung_design.symmetric_sleeve_arm(fulcrum_radius=0.122, angle=math.radians(132), swing=swing)
    is_printed(1e3 * np.asarray(arm), hartung.SLEEVE_ARM_MM, digits=8)
    even = hartung_design.symmetric_sleeve_arm(fulcrum_radius=0.122, angle=math.radians(hartung.ANGLE_DEG), swing=swing)
    is_printed(1e3 * np.asarray(even), hartung.SLEEVE_ARM_CORRECTED_MM, digits=8)
    lift = hartung_design.sleeve_travel(sleeve_arm=0.17, angle=math.radians(132), swing=swing)
    is_printed(1e3 * np.asarray(lift), hartung.LIFT_MM, digits=10)


def test_the_spring() -> None:
    coil = {"wire": WIRE, "coil": COIL, "modulus": SHEAR}
    is_printed(1e8 * np.asarray(hartung_design.polar_moment(wire=WIRE)), SPRING["polar_moment_cm4"])
    is_printed(1e6 * np.asarray(hartung_design.section_modulus(wire=WIRE)), SPRING["section_modulus_cm3"])
    is_printed(100 * np.asarray(hartung_design.wire_length(**coil, rate=RATE)), SPRING["wire_length_cm"])
    is_printed(hartung_design.coil_turns(**coil, rate=RATE), SPRING["turns"])
    thirteen = SHEAR * WIRE**4 / (8 * 13 * COIL**3) / KGF
    is_printed(thirteen / 1e3, SPRING["rate_of_13_turns_kgf_per_mm"])
    is_printed(thirteen * 0.06, SPRING["rise_of_13_turns_kgf"], digits=8)
    is_printed(1e3 * hartung.PRELOAD / RATE, SPRING["preload_deflection_mm"])
    stress = hartung_design.coil_stress(wire=WIRE, coil=COIL, force=346 * KGF)
    is_printed(np.asarray(stress) / KGF / 1e4, SPRING["stress_kgf_per_cm2"])
    rate = hartung_design.effective_spring_rate(inner_force=173.8, outer_force=345.8, stroke=60)
    is_printed(rate, SPRING["rate_kgf_per_mm"])


def test_the_regulating_force_of_both_governors() -> None:
    for static, wanted in zip(hartung.STATIC_FORCE_KGF, hartung.REGULATING_FORCE_KGF, strict=True):
        is_printed(hartung_design.regulating_force(static_force=static), wanted)
    forces = [float(hartung_design.regulating_force(static_force=force)) for force in hartung.POHLHAUSEN["static"]]
    # Rounded on the way: exactly 0.04 of whole numbers.
    np.testing.assert_allclose(forces, hartung.POHLHAUSEN["regulating"], rtol=1e-15)
    # The paper cuts 7.56 to 7.5 and rounds the others, then divides the change by the middle force: 56 %.
    first, middle, last = math.floor(10 * forces[0]) / 10, round(forces[1], 1), round(forces[2], 1)
    is_printed((last - first) / middle, hartung.POHLHAUSEN["spread"])


@given(st.floats(0.002, 0.05), st.floats(1.5, 20.0), st.floats(1.0, 40.0))
def test_the_turns_give_the_rate_of_a_helical_spring(wire: float, index: float, turns: float) -> None:
    coil: dict[str, float] = {"wire": wire, "coil": index * wire, "modulus": 8e10}
    rate = 8e10 * wire**4 / (8 * turns * (index * wire) ** 3)
    assert float(hartung_design.coil_turns(**coil, rate=rate)) == pytest.approx(turns, rel=1e-13)  # a few roundings


def sleeve_force_at(governor: closed.HartungGovernor, lever: float, speed: float) -> float:
    """Return the static sleeve force (N) of the spring force that balances a speed (rad/s)."""
    force = closed.astatic_spring_force(governor, lever_angle=lever, spindle_speed=speed)
    return float(closed.static_sleeve_force(governor, lever_angle=lever, spring_force=force))


@given(st.floats(0.05, 0.3), st.floats(0.3, 2.0))
def test_the_angle_makes_the_static_force_stationary(arm: float, part: float) -> None:
    """Its promise: with centrifugal forces on the spring's line, S does not change about the upright lever."""
    abscissa = part * arm
    angle = float(hartung_design.bell_crank_angle(weight_arm=arm, middle_abscissa=abscissa))
    governor = closed.HartungGovernor(
        weight_arm=arm, sleeve_arm=0.2, angle=angle, fulcrum_radius=2 * arm, weight_mass=10.0, sleeve_mass=10.0
    )
    h = 1e-5
    balanced = []
    for lever in (-h, h):
        # The spring's line through C at upright: C = c (y0 - a sin alpha), in the simplified S = 2 C (a / b) cos / sin.
        on_line = 1e4 * (abscissa - arm * math.sin(lever))
        x = float(closed.weight_radius(governor, lever_angle=lever))
        own = math.sqrt(on_line / (10.0 * x))
        balanced.append(sleeve_force_at(governor, lever, own))
    slope = (balanced[1] - balanced[0]) / (2 * h)
    # A central difference: rounding 1e-16 / h of S, h^2 of its third derivative.
    assert abs(slope) < 1e-8 * balanced[0]


@given(st.floats(5.0, 50.0), st.floats(0.0, 1.0))
def test_the_speed_limits_stand_apart_by_twice_the_part(speed: float, part: float) -> None:
    low, high = hartung_design.speed_limits(spindle_speed=speed, regulating_force=400.0 * part, static_force=400.0)
    # (w'^2 - w''^2) / w^2 = 2 K / S; squares of numbers of size 1 are right to a few 1e-16.
    assert (float(high) ** 2 - float(low) ** 2) / speed**2 == pytest.approx(2 * part, abs=1e-14)


def test_soft_wire_and_soft_springs_follow_the_same_formula():
    # L = f J_p G / (P r^2)
    stiff = float(hartung_design.wire_length(wire=WIRE, coil=COIL, rate=RATE, modulus=SHEAR))
    assert float(hartung_design.wire_length(wire=WIRE, coil=COIL, rate=0.5, modulus=SHEAR)) == pytest.approx(stiff * RATE / 0.5, rel=1e-14)
    assert float(hartung_design.wire_length(wire=WIRE, coil=COIL, rate=RATE, modulus=0.5)) == pytest.approx(stiff * 0.5 / SHEAR, rel=1e-14)
