"""The slider crank in closed form: the recomputed table, derivatives, Marks' circle, momentum and energy of loads."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain
from printed_numbers import half_unit_of_last_digit
from reference import marks

TRAIN = CrankTrain(crank=marks.CRANK, rod=marks.CONNECTING_ROD)

masses = st.floats(0.0, 200.0)
trains = st.builds(
    lambda crank, ratio, crank_mass, off, rod_mass, part, inertia, crosshead: CrankTrain(
        crank=crank,
        rod=ratio * crank,
        crank_mass=crank_mass,
        crank_centre=off * crank,
        rod_mass=rod_mass,
        rod_centre=part * ratio * crank,
        rod_inertia=inertia * rod_mass * (ratio * crank) ** 2,
        crosshead_mass=crosshead,
    ),
    st.floats(0.05, 1.0),
    st.floats(1.5, 12.0),
    masses,
    st.floats(-1.0, 1.0),
    masses,
    st.floats(0.0, 1.0),
    st.floats(0.01, 0.3),
    masses,
)


def is_printed(value: float, printed: float, room: float) -> None:
    """The value rounds to the printed one, and `room` of rounding."""
    assert abs(value - printed) <= half_unit_of_last_digit(printed) + room, (value, printed)


@pytest.mark.parametrize("row", marks.SLIDER_CRANK_MOTION, ids=lambda row: f"{row[0]}deg")
def test_the_table_is_met_to_the_printed_digits(row: tuple[float, ...]) -> None:
    at = {"crank_angle": math.radians(row[0])}
    going = {**at, "crank_rate": 10.0}
    # rounding where a number passes through zero: 1e-15 of the speeds R W, R W^2 and so on
    is_printed(closed.crosshead_distance(TRAIN, **at), row[1], 1e-15)
    is_printed(closed.crosshead_velocity(TRAIN, **going), row[2], 1e-15)
    is_printed(closed.crosshead_acceleration(TRAIN, **going), row[3], 1e-14)
    is_printed(math.degrees(closed.rod_angle(TRAIN, **at)), row[4], 1e-14)
    is_printed(closed.rod_angular_velocity(TRAIN, **going), row[5], 1e-15)
    is_printed(closed.rod_angular_acceleration(TRAIN, **going), row[6], 1e-14)
    is_printed(closed.rod_error(TRAIN, **at), row[7], 1e-16)


@given(trains, st.floats(0.0, math.tau))
def test_marks_circle_of_the_connecting_rod_is_exact(train: CrankTrain, angle: float) -> None:
    z = closed.rod_error(train, crank_angle=angle)
    height = train.crank * math.sin(angle)
    assert abs((train.rod - z) ** 2 + height**2 - train.rod**2) < 1e-14 * train.rod**2  # rounding
    nearer = train.rod + train.crank * math.cos(angle) - closed.crosshead_distance(train, crank_angle=angle)
    assert abs(nearer - z) < 1e-14 * train.rod
    # his parabola (R sin t)^2 = 2 L Z is short by Z^2 / 2 L
    assert_allclose(z - height**2 / (2 * train.rod), z**2 / (2 * train.rod), atol=1e-15 * train.rod)


@given(trains, st.floats(0.0, math.tau))
def test_speeds_and_accelerations_are_derivatives(train: CrankTrain, angle: float) -> None:
    step = 2e-3
    angles = angle + step * np.arange(-3, 4)
    for place, speed, bend, unit in (
        (closed.crosshead_distance, closed.crosshead_velocity, closed.crosshead_acceleration, train.rod),
        (closed.rod_angle, closed.rod_angular_velocity, closed.rod_angular_acceleration, 1.0),
    ):
        values = np.asarray(place(train, crank_angle=angles))
        first = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 @ values / step
        second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180 @ values / step**2
        # differences of the sixth order: rounding over the step, once and twice, and step^6 of a rod 1.5 cranks long
        assert abs(speed(train, crank_angle=angle, crank_rate=1.0) - first) < 1e-11 * unit
        assert abs(bend(train, crank_angle=angle, crank_rate=1.0) - second) < 1e-8 * unit


def places(train: CrankTrain, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Mass centres of crank, rod and crosshead (n, 2), and the rod's angle (n,), from the triangle alone."""
    out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    lean = -np.arcsin(train.crank / train.rod * np.sin(angle))
    along = np.stack([np.cos(lean), np.sin(lean)], axis=-1)
    end = train.crank * out + train.rod * along
    return train.crank_centre * out, train.crank * out + train.rod_centre * along, end, lean


@given(trains, st.floats(0.0, math.tau), st.floats(-9.0, 9.0), st.floats(0.0, 12.0))
def test_the_loads_give_all_parts_their_momentum_and_the_drive_their_energy(
    train: CrankTrain, angle: float, rate: float, gravity: float
) -> None:
    """Newton's law for the whole and the theorem of energy, from positions alone: other routes than part by part."""
    step = 2e-3
    angles = angle + step * np.arange(-3, 4)
    crank, rod, crosshead, lean = places(train, angles)
    heavy = [(train.crank_mass, crank), (train.rod_mass, rod), (train.crosshead_mass, crosshead)]
    first, second = (np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / step, np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / step**2)
    pulls = sum(mass * (second @ path * rate**2 + np.array([0.0, gravity])) for mass, path in heavy)
    found = closed.bearing_loads(train, crank_angle=angle, crank_rate=rate, gravity=gravity)
    whole = sum(mass for mass, _ in heavy) * (train.rod * rate**2 + gravity) + 1e-9
    # numerical differences, as above
    assert_allclose(found.main + np.array([0.0, 1.0]) * found.guide, pulls, atol=1e-7 * whole)
    power = rate * gravity * sum(mass * (first @ path[:, 1]) for mass, path in heavy)
    power += rate**3 * sum(mass * (first @ path) @ (second @ path) for mass, path in heavy)
    power += rate**3 * train.rod_inertia * (first @ lean) * (second @ lean)
    assert abs(found.torque * rate - power) < 1e-7 * whole * train.rod * abs(rate) + 1e-12


@given(trains, st.floats(0.0, math.tau), st.floats(-9.0, 9.0))
def test_the_rod_keeps_its_turning_balance_about_the_crosshead(train: CrankTrain, angle: float, rate: float) -> None:
    step = 2e-3
    _, rod, crosshead, lean = places(train, angle + step * np.arange(-3, 4))
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / step**2
    found = closed.bearing_loads(train, crank_angle=angle, crank_rate=rate, gravity=9.81)
    arm = train.crank * np.array([math.cos(angle), math.sin(angle)]) - crosshead[3]
    off = rod[3] - crosshead[3]
    pull = train.rod_mass * (second @ rod * rate**2 + np.array([0.0, 9.81]))
    turning = train.rod_inertia * (second @ lean) * rate**2 + off[0] * pull[1] - off[1] * pull[0]
    given_moment = arm[0] * found.crank_pin[1] - arm[1] * found.crank_pin[0]
    whole = (train.rod_mass + train.crosshead_mass) * (train.rod * rate**2 + 9.81) * train.rod + 1e-9
    assert abs(given_moment - turning) < 1e-7 * whole


def test_a_balanced_crank_that_moves_nothing_loads_nothing() -> None:
    train = CrankTrain(crank=0.3, rod=1.5, crank_mass=50.0)
    found = closed.bearing_loads(train, crank_angle=np.linspace(0, 6, 7), crank_rate=20.0)
    for load in (found.main, found.crank_pin, found.gudgeon, found.guide, found.torque):
        assert np.all(load == 0.0)


def test_at_a_dead_centre_the_crosshead_pulls_with_its_own_inertia() -> None:
    train = CrankTrain(crank=0.3, rod=1.5, crosshead_mass=100.0)
    found = closed.bearing_loads(train, crank_angle=0.0, crank_rate=10.0)
    # R W^2 (1 + R / L) m, by hand
    assert_allclose(found.gudgeon, [-3600.0, 0.0], atol=1e-10)
    assert_allclose(found.main, [-3600.0, 0.0], atol=1e-10)


@pytest.mark.parametrize("name", ["crank_centre", "rod_centre"])
def test_mass_centres_are_on_either_side(name):
    assert getattr(CrankTrain(crank=0.3, rod=1.0, **{name: -0.1}), name) == -0.1
