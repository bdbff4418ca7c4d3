"""The first zero of event functions in a step, and the first kink: functions that are polynomials of the fraction of the step."""

from typing import NamedTuple

import numpy as np
import pytest

from governor_mechanism.integrators.equation import EVENT_SAMPLE_FRACTIONS, EventStep, make_step_buffers
from governor_mechanism.integrators.event_location import NO_EVENT, make_event_location
from governor_mechanism.integrators.step_ends import MAX_STRETCH, make_kink_prediction
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

TOLERANCE = 1e-12

pytestmark = pytest.mark.long  # a compiler takes seconds for a search of its own; runs of engines with contacts hold the same laws


class Polynomials(NamedTuple):
    """Coefficients of the event functions, highest power first; shape (event functions, terms)."""

    coefficients: FloatArray


@jit_in_place
def evaluate_after_fraction(equation: Polynomials, step: EventStep, fraction: float, values: FloatArray) -> None:
    for i in range(values.size):
        total = 0.0
        for k in range(equation.coefficients.shape[1]):
            total = total * fraction + equation.coefficients[i, k]
        values[i] = total


class Jump(NamedTuple):
    """An event function that jumps from -1 to 1 at a fraction of the step."""

    fraction: float


@jit_in_place
def evaluate_jump(equation: Jump, step: EventStep, fraction: float, values: FloatArray) -> None:
    values[0] = 1.0 if fraction > equation.fraction else -1.0


_locate = jit_in_place(make_event_location(evaluate_after_fraction))
_locate_jump = jit_in_place(make_event_location(evaluate_jump))
_predict_kink = jit_in_place(make_kink_prediction(evaluate_after_fraction))


def make_step(n, n_kinks):
    """Return a step of n event functions, of which the last ones are kinks, with buffers."""
    buffers = make_step_buffers(1, 1, np.ones(1), np.full(n, TOLERANCE), np.zeros(4, dtype=np.int64), n_kinks)
    return EventStep(0.0, 1.0, np.zeros(1), buffers)


def prepare(functions, n_kinks):
    """Return the event functions, of which each is given by its coefficients, and a step with their values at the samples."""
    n_terms = max(map(len, functions))
    equation = Polynomials(np.array([[0.0] * (n_terms - len(one)) + list(one) for one in functions]))
    step = make_step(len(functions), n_kinks)
    for fraction, values in zip(EVENT_SAMPLE_FRACTIONS, step.buffers.event_values, strict=True):
        evaluate_after_fraction(equation, step, fraction, values)
    return equation, step


def locate(*functions, interpolated=None):
    """Return where the first function rises through zero, and the functions there; `interpolated` are other values at samples."""
    equation, step = prepare(functions, 0)
    for index, values in (interpolated or {}).items():
        step.buffers.event_values[index] = values
    return float(_locate(equation, step)), step.buffers.event_values[-1]


def from_roots(*roots, sign=1.0):
    return sign * np.poly(roots)


@pytest.mark.parametrize(
    ("functions", "expected"),
    [
        ([from_roots(0.6)], 0.6),
        ([from_roots(0.3), from_roots(0.6)], 0.3),
        ([from_roots(0.6), from_roots(0.3)], 0.3),
        ([from_roots(0.65), from_roots(0.55)], 0.55),
        ([from_roots(0.55), from_roots(0.65)], 0.55),
        ([from_roots(0.34, 0.41, sign=-1.0)], 0.34),  # positive between two samples only
        ([from_roots(0.0, 0.4)], 0.4),  # zero at the start, then negative
        ([from_roots(0.0, 0.1)], 0.1),
        ([from_roots(0.0, 0.03)], 0.03),
    ],
)
def test_the_first_rise_through_zero_is_located_to_rounding(functions, expected):
    fraction, values = locate(*functions)
    assert fraction == pytest.approx(expected, abs=1e-12)
    assert fraction >= expected - 1e-15
    assert np.max(values) > 0.0  # it is just behind the zero


@pytest.mark.parametrize(
    "functions",
    [
        [from_roots(1.5)],
        [from_roots(0.0, sign=-1.0)],  # falls
        [[-1.0, 0.75, -(0.375**2) - 1e-4]],  # its maximum between two samples is just below zero
        [[0.0]],
    ],
)
def test_without_a_rise_there_is_no_event(functions):
    assert locate(*functions)[0] == NO_EVENT


def test_a_function_that_rises_from_zero_at_once_is_an_event_at_the_start():
    fraction, values = locate([1.0, 0.0], from_roots(0.9))
    assert 0.0 < fraction < 1e-9
    assert values[0] > 0.0 > values[1]


@pytest.mark.parametrize("jump", [1e-40, 1e-3, 0.6])
def test_a_jump_is_located_also_next_to_the_start(jump):
    step = make_step(1, 0)
    step.buffers.event_values[:, 0] = np.where(jump < EVENT_SAMPLE_FRACTIONS, 1.0, -1.0)
    fraction = float(_locate_jump(Jump(jump), step))
    assert jump < fraction
    assert fraction == pytest.approx(jump, rel=1e-15, abs=1e-29)  # 100 bisections
    assert step.buffers.event_values[-1, 0] == 1.0


def test_the_steps_integrated_again_decide_and_not_the_interpolated_samples():
    middle = {2: [1e-3]}  # positive by an error of the interpolation
    assert locate(from_roots(0.9), interpolated=middle)[0] == pytest.approx(0.9, abs=1e-12)
    assert locate(from_roots(1.2), interpolated=middle)[0] == NO_EVENT


def predict(*functions):
    return float(_predict_kink(*prepare(functions, len(functions))))


PREDICTION_TOLERANCE = 1e-14
"""Secant steps end at rounding."""


def test_the_first_kink_is_predicted_also_a_little_behind_the_step():
    behind = 1.0 + 0.5 * MAX_STRETCH
    assert predict(from_roots(0.6, 3.0, sign=-1.0)) == pytest.approx(0.6, abs=PREDICTION_TOLERANCE)
    assert predict(from_roots(0.8), from_roots(0.2)) == pytest.approx(0.2, abs=PREDICTION_TOLERANCE)
    assert predict(from_roots(behind)) == pytest.approx(behind, abs=1e-14)
    assert predict(from_roots(1.0 + 1.5 * MAX_STRETCH)) == predict(from_roots(2.0)) == NO_EVENT
    assert predict(from_roots(0.5)) == 0.5  # a sample: the zero is an end of the bracket
    # The first function falls, and the one at zero has its kink behind it.
    for other in (from_roots(0.5, sign=-1.0), from_roots(0.0)):
        assert predict(other, from_roots(0.7)) == pytest.approx(0.7, abs=PREDICTION_TOLERANCE)
    assert predict([-1.0]) == NO_EVENT


def test_a_kink_of_a_flat_function_is_predicted_within_its_samples():
    """Secant steps come only slowly nearer to a zero of high order: their number is bounded."""
    assert 0.5 <= predict(from_roots(*[0.6] * 9)) <= 0.75
