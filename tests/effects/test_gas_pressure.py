"""The force law of gas in a cylinder: its work is its integral, every stroke repeats the one before, pressures meet at the switch."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.effects.gas_pressure import GasPressure, gas_pressure, gas_work

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


def travel(stroke: float, angle: float) -> float:
    """Travel of a piston with an infinite rod."""
    return stroke * math.sin(0.5 * angle) ** 2


@given(gases(), st.floats(0.05, 12.0))
def test_the_work_is_the_integral_of_the_force(gas, angle):
    # Between the switch and the dead centres the force is smooth: a step that straddles one of them is left out.
    step, stroke = 1e-5, gas[-1]
    since_dead_centre = (1 - math.cos(angle % math.pi)) / 2
    if abs(since_dead_centre - gas[4]) < 1e-3 or min(angle % math.pi, math.pi - angle % math.pi) < 0.05:
        return
    before, after = (travel(stroke, angle + sign * step) for sign in (-1, 1))
    done = gas_work(gas, after, angle + step) - gas_work(gas, before, angle - step)
    force = GasPressure.force(gas, travel(stroke, angle), angle)
    scale = abs(gas[0]) * stroke * max(gas[1], gas[6]) * 100  # the pressure may rise to fifty times the constant one
    assert done == pytest.approx(force * (after - before), abs=1e-9 * scale)  # rounding of the difference, and the square of the step


@given(gases(), st.floats(0.01, math.pi - 0.01), st.integers(0, 6))
def test_every_stroke_repeats_the_one_before_on_the_other_face(gas, angle, strokes):
    stroke = gas[-1]
    first = GasPressure.force(gas, travel(stroke, angle), angle)
    later = GasPressure.force(gas, travel(stroke, angle + strokes * math.pi), angle + strokes * math.pi)
    assert later == pytest.approx((-1) ** strokes * first, rel=1e-9, abs=1e-9 * abs(gas[0]) * gas[1])
    works = gas_work(gas, travel(stroke, angle + strokes * math.pi), angle + strokes * math.pi)
    whole = gas_work(gas, travel(stroke, math.pi), math.pi)
    assert works == pytest.approx(strokes * whole + gas_work(gas, travel(stroke, angle), angle), rel=1e-9, abs=1e-9 * stroke * gas[1])


@given(gases())
def test_the_pressure_is_continuous_at_its_switch(gas):
    switch, stroke = gas[4], gas[-1]
    before, after = (gas_pressure(gas, (switch + sign * 1e-12) * stroke, math.acos(1 - 2 * switch)) for sign in (-1, 1))
    assert before == pytest.approx(after, rel=1e-9)  # the volume is at least 0.02 of the stroke
    assert before == pytest.approx(gas[1], rel=1e-9)


@pytest.mark.parametrize(
    ("gas", "place", "expected"),
    [(EXPANSION, 0.2, 4e5), (EXPANSION, 1.0, 4e5 * 0.425 / 1.05), (SUCTION, 0.0, 4e5), (SUCTION, 0.5, 1e5),
     (DELIVERY, 0.0, 1e5), (DELIVERY, 0.5, 1e5 * 1.05 / 0.55), (DELIVERY, 0.9, 4e5)],
)  # fmt: skip
def test_the_pressures_of_the_air_engine(gas, place, expected):
    # Mariotte's law by hand, with the source's clearances of 0.05.
    assert float(gas_pressure(gas, place * STROKE, np.float64(1.0))) == pytest.approx(expected, rel=1e-12)
