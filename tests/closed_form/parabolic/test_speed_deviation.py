"""Leaving the osculation point: the recomputed table, where the speed is least, and what Zehnder read instead."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from governor_mechanism.closed_form import parabolic as isochronous
from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form.parabolic import equilibrium_speed_change, parabola_speed_change
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.errors import MechanismError
from reference import zehnder

ANGLE = math.atan(zehnder.DESIGN["start_tangent"])
START: dict[str, Any] = {"start_angle": ANGLE, "start_abscissa": zehnder.DESIGN["start_abscissa"]}
RADIUS = zehnder.DESIGN["radius_of_curvature"]
LONG, SHORT = 1.3 * RADIUS, 0.7 * RADIUS

UP = np.radians(np.linspace(0.05, 4.0, 80))
DOWN = -UP

ANGLES = st.floats(math.radians(10), math.radians(60))


def osculating_arm(abscissa: float, angle: float) -> float:
    """Return the radius of curvature of the parabola that has the slope angle (rad) at an abscissa (m)."""
    return float(isochronous.radius_of_curvature(abscissa=abscissa, double_parameter=2 * abscissa / math.tan(angle)))


@pytest.mark.parametrize("row", zehnder.OSCULATION, ids=lambda row: f"{row[0]}deg")
def test_the_speed_changes_as_recomputed(row: tuple[float, ...]) -> None:
    arms = RADIUS * np.array(zehnder.OSCULATION_ARMS)
    changes = equilibrium_speed_change(**START, arm=arms, angle_change=math.radians(row[0]))
    # the start is given to 12 digits, the changes to 12 of their own
    assert_allclose(changes, row[1:], rtol=0, atol=1e-11)


def test_on_the_circle_of_curvature_the_speed_is_least_at_the_start() -> None:
    for way in (UP, DOWN):
        changes = equilibrium_speed_change(**START, arm=RADIUS, angle_change=way)
        assert np.all(changes > 0)
        assert np.all(np.diff(changes) > 0)
    here = equilibrium_speed_change(**START, arm=RADIUS, angle_change=1e-4)
    assert 0 < here < 1e-7  # of second order: without slope at the start


def test_on_a_longer_arm_the_speed_falls_going_up_and_on_a_shorter_one_it_rises() -> None:
    both = np.concatenate([DOWN[::-1], [0.0], UP])
    assert np.all(np.diff(equilibrium_speed_change(**START, arm=LONG, angle_change=both)) < 0)
    assert np.all(np.diff(equilibrium_speed_change(**START, arm=SHORT, angle_change=both)) > 0)


def test_judged_by_the_parabola_under_the_ball_the_changes_have_the_signs_of_zehnders_text() -> None:
    def judged(arm: float, way: Any) -> Any:
        return parabola_speed_change(**START, arm=arm, angle_change=way)

    assert np.all(judged(RADIUS, UP) > 0)
    assert np.all(judged(RADIUS, DOWN) < 0)  # the truth is above 0
    assert np.all(judged(LONG, UP) < 0)
    assert np.all(judged(LONG, DOWN) < 0)  # the truth is above 0
    assert np.all(judged(SHORT, UP) > 0)
    assert np.all(judged(SHORT, DOWN) > 0)  # the truth is below 0


@given(ANGLES, st.floats(0.02, 2.0), st.floats(0.3, 1.6), st.floats(-4, 8).map(math.radians), st.floats(0, 8))
def test_the_change_is_that_of_the_governors_own_speed(angle: float, abscissa: float, share: float, turn: float, ratio: float) -> None:
    arm = share * osculating_arm(abscissa, angle)
    offset = abscissa - arm * math.sin(angle)
    governor = PendulumGovernor(arm=arm, offset=offset, ball_mass=1.0, sleeve_mass=ratio)
    if offset + arm * math.sin(angle + turn) < 0.05 * abscissa:
        return
    before, after = (pendulum.equilibrium_speed(governor, arm_angle=a) for a in (angle, angle + turn))
    change = equilibrium_speed_change(start_angle=angle, start_abscissa=abscissa, arm=arm, angle_change=turn)
    # offset + arm sin a cancels to as little as 1/200 of its terms
    assert_allclose(change, after / before - 1, rtol=1e-11, atol=1e-13)


@given(ANGLES, st.floats(0.02, 2.0), st.floats(0.3, 1.6), st.floats(-2, 8).map(math.radians))
def test_the_ball_sits_on_the_parabola_of_the_judged_speed(angle: float, abscissa: float, share: float, turn: float) -> None:
    arm = share * osculating_arm(abscissa, angle)
    change = parabola_speed_change(start_angle=angle, start_abscissa=abscissa, arm=arm, angle_change=turn)
    x = abscissa + arm * (math.sin(angle + turn) - math.sin(angle))
    y = abscissa * math.tan(angle) / 2 + arm * (math.cos(angle) - math.cos(angle + turn))
    c = 2 * abscissa / math.tan(angle) / (1 + change) ** 2
    # heights and abscissae cancel to as little as 1/100 of their terms
    assert_allclose(isochronous.parabola_height(abscissa=x, double_parameter=c), y, rtol=1e-11)


def test_the_change_next_to_the_start_keeps_its_digits() -> None:
    tiny = 1e-9
    slope = {share: equilibrium_speed_change(**START, arm=share * RADIUS, angle_change=tiny) / tiny for share in (0.7, 1.3)}
    # d ln w / da = (1 - l / rho) / (2 sin a cos a): from Zehnder (3); 1e-8 of second order, and of the given digits
    for share, found in slope.items():
        assert_allclose(found, (1 - share) / math.sin(2 * ANGLE), rtol=1e-7)


def test_numbers_give_floats_and_arrays_broadcast() -> None:
    assert type(equilibrium_speed_change(**START, arm=RADIUS, angle_change=0.1)) is float
    assert equilibrium_speed_change(**START, arm=RADIUS, angle_change=0.0) == 0.0
    grid = equilibrium_speed_change(**START, arm=np.array([[RADIUS], [SHORT]]), angle_change=np.array([0.0, 0.1, 0.2]))
    assert grid.shape == (2, 3)
    assert grid[1, 1] == equilibrium_speed_change(**START, arm=SHORT, angle_change=0.1)


def test_a_ball_below_the_vertex_sits_on_no_parabola() -> None:
    start = {"start_angle": 0.2, "start_abscissa": 1.0, "arm": 20.0}
    assert equilibrium_speed_change(**start, angle_change=-0.04) > 0
    with pytest.raises(MechanismError, match=r"at or below the height of the vertex: no parabola passes there; got angle_change = -2\.2"):
        parabola_speed_change(**start, angle_change=-0.04)
