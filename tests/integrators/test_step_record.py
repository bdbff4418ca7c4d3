"""The second run of a certificate takes at most half of every step of the first, whatever set the steps."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.certificate import CertifiedRunner, RecordedRun
from governor_mechanism.integrators import step_record
from governor_mechanism.integrators.equation import make_step_buffers, may_miss_events
from interpreted_kernels import interpret_kernels

REGULAR_QUALITY = 1.0
"""Quality of a step far from singular configurations."""

lengths = st.lists(st.floats(1e-6, 10.0), min_size=1, max_size=20)


kernels_as_python = interpret_kernels(step_record)


def record_of(step_lengths):
    record = step_record.make_step_record(len(step_lengths))
    for end, length in zip(np.cumsum(step_lengths), step_lengths, strict=True):
        step_record.record_step(record, end, length, REGULAR_QUALITY)
    return record


def largest_ratio(coarse_ends, fine_ends):
    """Return the largest ratio of a fine step to a coarse step that it overlaps by more than rounding."""
    worst, starts = 0.0, np.concatenate([[0.0], coarse_ends[:-1]])
    for start, end in itertools.pairwise([0.0, *fine_ends]):
        margin = 2 * step_record.INSIDE_STEP_TOLERANCE * (coarse_ends - starts) + 1e-12 * (end - start)
        overlapped = (starts < end - margin) & (coarse_ends > start + margin)
        worst = max([worst, *((end - start) / (coarse_ends - starts)[overlapped])])
    return worst


@given(lengths, st.floats(0.01, 20.0))
def test_steps_within_the_limit_are_half_as_long_as_those_that_they_overlap(step_lengths, wanted):
    record, t, k, ends = record_of(step_lengths), 0.0, 0, []
    duration = float(record.ends[-1])
    while t < duration * (1 - 1e-9):
        h, k = step_record.limit_to_half_steps(record, k, t, wanted)
        assert 0 < h <= wanted
        t += h
        ends.append(t)
        assert len(ends) < 100_000
    # A step that ends a hair before the end of another one may go on by half of the next.
    assert largest_ratio(record.ends, np.array(ends)) <= 0.5 * (1 + 1e-6)


@given(lengths, st.floats(0.0, 200.0))
def test_the_step_at_a_time_is_the_first_that_ends_after_it(step_lengths, t):
    record = record_of(step_lengths)
    assert step_record.find_step(record, t) == int(np.searchsorted(record.ends, t, side="right"))


def test_without_a_record_no_step_is_limited_and_a_full_record_keeps_what_it_has():
    assert step_record.limit_to_half_steps(step_record.NO_STEPS, 0, 1.0, 7.0) == (7.0, 0)
    record = step_record.make_step_record(1)
    step_record.record_step(record, 1.0, 1.0, REGULAR_QUALITY)
    step_record.record_step(record, 2.0, 1.0, REGULAR_QUALITY)
    assert record.n_steps[0] == 1


CASES = [  # what sets the steps: the tolerance; kinks of gas; stick and slip; a change point; a stiff damper (implicit steps)
    ("porter", ReducedEngine()),
    ("air_engine", ReducedEngine()),
    ("air_engine", MultibodyEngine()),
    ("porter_dry_friction", ReducedEngine()),
    ("four_bar_chain", MultibodyEngine()),
    ("stiff_flyball", MultibodyEngine()),
]


@pytest.mark.parametrize(("name", "engine"), CASES, ids=[f"{name}-{engine.name}" for name, engine in CASES])
def test_both_runs_of_a_certificate_differ_by_their_steps_everywhere(monkeypatch, name, engine):
    runs: list[RecordedRun] = []
    record = CertifiedRunner._record

    def keep(self, tolerance, plan):
        runs.append(record(self, tolerance, plan))
        return runs[-1]

    monkeypatch.setattr(CertifiedRunner, "_record", keep)
    engine.run(gm.load(name), accuracy=1e-5, times=[0.0, 1.0])
    coarse, fine = (one.plan.steps.ends[: one.plan.steps.n_steps[0]] for one in runs[:2])
    assert len(fine) >= 2 * len(coarse) - 1
    # A kink met by a stretched step, or an event a hair later, is within 5 % of a step (MAX_STRETCH).
    assert largest_ratio(coarse, fine) <= 0.5 * 1.05


@pytest.mark.long  # a compiler takes seconds for a kernel that no other test calls by itself
@pytest.mark.parametrize(("values", "is_too_long", "is_far"), [([-3, -2, -1, -2, -3], True, 0), ([-30, -29, -28, -29, -30], False, 1)])
def test_a_long_step_is_taken_again_where_an_event_is_not_far(values, is_too_long, is_far):
    """Its function changes by 1 in a quarter of the step of 0.5 s, and so by 4 in it and by 16 in the time in which none is expected."""
    buffers = make_step_buffers(1, 1, np.ones(1), np.full(1, 1e-12), np.zeros(4, dtype=np.int64), 0, 0.1, 2.0)
    buffers.event_values[:, 0], buffers.progress["h"], buffers.progress["step"] = values, 0.5, 0.5
    assert may_miss_events(buffers) == is_too_long
    assert buffers.progress["is_far"] == is_far
    assert buffers.progress["step"] == (0.1 if is_too_long else 0.5)
