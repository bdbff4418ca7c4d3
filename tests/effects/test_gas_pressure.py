"""The force law of gas in a cylinder: Mariotte's law, its work is its integral, every stroke repeats the one before."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from governor_mechanism.effects import gas_pressure as laws
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate
from governor_mechanism.model.time_functions import InputFunction
from scene_parts import body_point

STROKE = 0.65
EXPANSION = (0.05, 4e5, 0.05, 1.0, 0.375, 1.0, 1.5e5, STROKE)
SUCTION = (0.05, 1e5, 0.05, 1.0, 0.15, 0.0, 0.0, STROKE)
DELIVERY = (-0.05, 4e5, 1.05, -1.0, 0.7875, 0.0, 0.0, STROKE)


@st.composite
def gases(draw):
    """Coefficients of any gas whose volume does not vanish in a stroke."""
    change, switch = draw(st.sampled_from([1.0, -1.0])), draw(st.floats(0.01, 0.99))
    volume = draw(st.floats(0.02, 2.0)) + (1.0 if change < 0 else 0.0)
    area = draw(st.sampled_from([-1.0, 1.0])) * draw(st.floats(1e-4, 1.0))
    pressure, back_pressure, stroke = draw(st.floats(1e3, 1e7)), draw(st.floats(0.0, 1e6)), draw(st.floats(0.01, 5.0))
    return area, pressure, volume, change, switch, float(draw(st.booleans())), back_pressure, stroke


def pressure_at(gas, place, *, is_isothermal: bool):
    """Return the absolute pressure at a travel since the dead centre by Mariotte's law: pressure times volume is that at the switch."""
    _, pressure, volume, change, switch, *_ = gas
    return pressure * (volume + change * switch) / (volume + change * place) if is_isothermal else pressure


NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)


def work_to(gas, place: float) -> float:
    """Return the work since the dead centre, the integral of the pressures over the swept volume.

    A Gauss rule of 64 points has no error beside rounding where the volume changes by less than a factor of fifty.
    """
    area, _, _, _, switch, begins_constant, back_pressure, stroke = gas
    work = -back_pressure * place
    for start, end, is_isothermal in ((0.0, min(place, switch), not begins_constant), (min(place, switch), place, bool(begins_constant))):
        places = start + (end - start) * (NODES + 1.0) / 2.0
        work += (end - start) / 2.0 * sum(WEIGHTS * pressure_at(gas, places, is_isothermal=is_isothermal))
    return area * stroke * work


STROKES = st.integers(0, 5)
PLACES = st.floats(0.0, 1.0)


@example(EXPANSION, 0, EXPANSION[4])
@example(DELIVERY, 1, DELIVERY[4])
@given(gases(), STROKES, PLACES)
def test_the_force_is_that_of_the_pressures_of_mariottes_law(gas, n_strokes, place):
    area, _, _, _, switch, begins_constant, back_pressure, stroke = gas
    angle, sense = n_strokes * math.pi + 1.0, (-1) ** n_strokes
    value = stroke * (place if sense > 0 else 1.0 - place)
    assert laws.travel_in_stroke(1.0 / stroke, value, angle) == pytest.approx(place, abs=1e-15)
    if abs(place - switch) > 1e-12:  # else rounding decides on which side of the switch it is, where the pressures are the same
        assert laws.gas_phase(gas, value, angle) == 2 * (n_strokes % 2) + (place > switch)
    expected = pressure_at(gas, place, is_isothermal=(place > switch) == bool(begins_constant))
    within = {"rel": 1e-12, "abs": 1e-12 * abs(area) * (expected + back_pressure)}  # volumes are at least 0.02: rounding times fifty
    assert laws.GasPressure.force(gas, value, angle) == pytest.approx(sense * area * (expected - back_pressure), **within)
    assert laws.gas_pressure(gas, value, angle) == pytest.approx(expected, rel=1e-12)


@given(gases(), st.integers(0, 3), PLACES)
def test_the_law_of_a_phase_holds_beyond_it(gas, phase, place):
    area, *_, begins_constant, back_pressure, stroke = gas
    sense, is_behind_switch = 1 - 2 * (phase // 2), bool(phase % 2)
    expected = pressure_at(gas, place, is_isothermal=is_behind_switch == bool(begins_constant))
    found = laws.GasPressure.force_in_phase(gas, stroke * (place if sense > 0 else 1.0 - place), float(phase))
    within = {"rel": 1e-12, "abs": 1e-12 * abs(area) * (expected + back_pressure)}
    assert found == pytest.approx(sense * area * (expected - back_pressure), **within)


def test_a_stroke_begins_at_its_dead_centre():
    angles = np.pi * np.arange(6)
    travels = STROKE * (np.arange(6) % 2)
    np.testing.assert_array_equal(laws.travel_in_stroke(1.0 / STROKE, travels, angles), np.zeros(6))
    np.testing.assert_array_equal(laws.gas_phase(EXPANSION, travels, angles), [0.0, 2.0] * 3)
    before = laws.travel_in_stroke(1.0 / STROKE, travels[1:], angles[1:] - 1e-9)
    np.testing.assert_allclose(before, np.ones(5), atol=1e-15)


@example(EXPANSION, 0, 1.0)
@example(SUCTION, 2, 0.15)
@given(gases(), STROKES, PLACES)
def test_the_work_is_the_integral_of_the_pressures(gas, n_strokes, place):
    stroke = gas[-1]
    value = stroke * (place if n_strokes % 2 == 0 else 1.0 - place)
    expected = n_strokes * work_to(gas, 1.0) + work_to(gas, place)
    scale = abs(gas[0]) * stroke * (max(gas[1] * (1 + 1 / gas[2]), gas[6])) * (n_strokes + 1)
    assert laws.gas_work(gas, value, n_strokes * math.pi + 1.0) == pytest.approx(expected, rel=1e-9, abs=1e-12 * scale)


def test_beyond_its_dead_centres_a_piston_does_no_work():
    for n_strokes in (0, 1):
        ends = [laws.gas_work(EXPANSION, value, n_strokes * math.pi + 1.0) for value in (0.0, STROKE)]
        beyond = [laws.gas_work(EXPANSION, value, n_strokes * math.pi + 1.0) for value in (-0.1 * STROKE, 1.1 * STROKE)]
        assert beyond == ends


def test_the_gas_does_not_dissipate_what_it_takes_it_gives_back():
    assert not laws.GasPressure.dissipates
    assert laws.GasPressure.force(EXPANSION, 0.1 * STROKE, 1.0) > 0.0  # in a forward stroke: it drives the piston
    assert laws.GasPressure.force(DELIVERY, 0.1 * STROKE, 1.0) < 0.0


def cylinder(gas, **changes) -> CylinderGas:
    """Return a gas on a piston."""
    names = ("area", "pressure", "volume", "change", "switch_travel", "begins_constant", "back_pressure", "stroke")
    travel = PointCoordinate(name="travel", quantity="length", point=body_point("piston"), direction_x=1.0, direction_y=0.0)
    angle = BodyAngle(name="crank_angle", quantity="angle", body="crank")
    return CylinderGas(name="gas", body="piston", travel=travel, crank_angle=angle, **dict(zip(names, gas, strict=True)) | changes)


def test_the_work_per_stroke_is_that_of_all_gases_with_their_throttles():
    assert cylinder(SUCTION).coefficients == SUCTION
    whole = [work_to(gas, 1.0) for gas in (EXPANSION, SUCTION, DELIVERY)]
    assert laws.work_per_stroke([cylinder(EXPANSION)]) == pytest.approx(whole[0], rel=1e-12)
    throttled = cylinder(SUCTION, throttle=InputFunction(values=(0.25,)))
    assert laws.work_per_stroke([cylinder(EXPANSION), throttled, cylinder(DELIVERY)]) == pytest.approx(
        whole[0] + 0.25 * whole[1] + whole[2], rel=1e-12
    )


@pytest.mark.parametrize("gas", [EXPANSION, SUCTION, DELIVERY])
def test_the_pressures_of_a_stroke_are_those_of_mariottes_law(gas):
    places = np.linspace(0.0, 1.0, 8)
    expected = [pressure_at(gas, place, is_isothermal=(place > gas[4]) == bool(gas[5])) for place in places]
    np.testing.assert_allclose(laws.pressure_in_stroke(cylinder(gas), places), expected, rtol=1e-12)


@given(gases())
def test_the_pressure_is_continuous_at_its_switch(gas):
    switch, stroke = gas[4], gas[-1]
    before, after = (laws.gas_pressure(gas, (switch + sign * 1e-12) * stroke, math.acos(1 - 2 * switch)) for sign in (-1, 1))
    assert before == pytest.approx(after, rel=1e-9)  # the volume is at least 0.02 of the stroke
    assert before == pytest.approx(gas[1], rel=1e-9)


@pytest.mark.parametrize(
    ("gas", "place", "expected"),
    [(EXPANSION, 0.2, 4e5), (EXPANSION, 1.0, 4e5 * 0.425 / 1.05), (SUCTION, 0.0, 4e5), (SUCTION, 0.5, 1e5),
     (DELIVERY, 0.0, 1e5), (DELIVERY, 0.5, 1e5 * 1.05 / 0.55), (DELIVERY, 0.9, 4e5)],
)  # fmt: skip
def test_the_pressures_of_the_air_engine(gas, place, expected):
    # Mariotte's law by hand, with the source's clearances of 0.05.
    assert float(laws.gas_pressure(gas, place * STROKE, np.float64(1.0))) == pytest.approx(expected, rel=1e-12)
