"""A recorded calculation gives for other rows what the calculation itself gives, to the last digit, or says that it does not hold."""

from __future__ import annotations

import math

import numpy as np
import pytest

from governor_mechanism.numerics import elementary
from governor_mechanism.numerics.row_numbers import NotRecordable, Recorder, find_labels, is_number_or_label


def calculate(a: float, b: float) -> list[float]:
    """Return numbers by all kinds of arithmetic, with branches."""
    reach = elementary.sqrt(elementary.hypot(a, b)) - elementary.atan2(a, -b) if a < b else elementary.asin(a / 9.0)
    sums = [sum([a, b, 1.0]), 2.0 - a, 3 / b, a**2, 2.0**b, -a, +b, abs(a - b), a * 0.0 + -0.0, 1 - -0.0 * b]
    return [
        reach,
        *sums,
        max(a, b, 1.0),
        min(a, 0.5),
        elementary.copysign(a, -1.0),
        elementary.cos(a) * elementary.sin(b),
        elementary.tan(a),
    ]


def record(a: float, b: float) -> tuple[Recorder, np.ndarray]:
    """Return the record of `calculate` at a row, and its results as labels."""
    recorder = Recorder()
    return recorder, np.array(calculate(recorder.add_argument(a), recorder.add_argument(b)))


def test_a_record_gives_the_numbers_of_other_rows_to_the_last_digit():
    recorder, labels = record(0.7, 2.0)
    rows = np.random.default_rng(0).uniform(0.1, 3.0, (200, 2))
    numbers, is_valid = recorder.evaluate(rows)
    places, indices = find_labels(labels.view(np.int64))
    found = np.tile(labels, (len(rows), 1))
    found[:, places] = numbers[:, indices]
    assert 20 < is_valid.sum() < 180  # those that branch as the recorded row does
    for row, values, holds in zip(rows, found, is_valid, strict=True):
        if holds:
            assert np.array(calculate(*row.tolist())).tobytes() == values.tobytes()


def test_a_row_that_branches_otherwise_or_has_no_result_is_not_valid():
    recorder = Recorder()
    a = recorder.add_argument(0.5)
    assert elementary.asin(a) > 0.5
    assert a != 1.0
    assert a
    _, is_valid = recorder.evaluate(np.array([[0.6], [0.4], [1.0], [2.0], [0.0]]))
    assert is_valid.tolist() == [True, False, False, False, False]


def test_constants_are_told_apart_from_numbers_of_the_record_and_zeros_by_their_sign():
    recorder = Recorder()
    a, b = recorder.add_argument(2.0), recorder.add_argument(3.0)
    labels = np.array([a * 0.0, a * 1.0, a * -0.0, a * a, a * b, a * 1])
    numbers, _ = recorder.evaluate(np.array([[5.0, 7.0]]))
    found = numbers[0][find_labels(labels.view(np.int64))[1]]
    assert found.tolist() == [0.0, 5.0, 0.0, 25.0, 35.0, 5.0]
    assert np.signbit(found).tolist() == [False, False, True, False, False, False]


@pytest.mark.parametrize(
    "use", [str, repr, hash, int, round, math.floor, "{:g}".format, lambda a: a % 2.0, lambda a: f"{a:.3g}", lambda a: {a}]
)
def test_what_cannot_be_recorded_is_refused(use):
    with pytest.raises(NotRecordable):
        use(Recorder().add_argument(0.5))


@pytest.mark.parametrize(
    "use", [math.sin, math.sqrt, lambda a: float(a) + 1.0, lambda a: np.array([a]).sum() * 2.0, lambda a: np.float64(2.0) * a]
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_arithmetic_that_is_not_recorded_shows(use):
    a = Recorder().add_argument(0.5)
    assert is_number_or_label(np.array([a, 1.0, -math.inf])).all()
    assert not is_number_or_label(np.array([use(a)])).any()


def test_a_label_that_has_left_its_number_enters_no_record():
    a = Recorder().add_argument(0.5)
    with pytest.raises(NotRecordable):
        a + float(a)


def test_numbers_of_two_records_do_not_mix():
    with pytest.raises(NotRecordable):
        Recorder().add_argument(1.0) + Recorder().add_argument(2.0)
