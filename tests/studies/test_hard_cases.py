"""The hard cases: the short form passes, the solutions solve their equations, and a wrong run fails."""

import dataclasses
import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import Engine, ReducedEngine
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.render.figures.errors import hard_case_figure
from governor_mechanism.studies.hard_cases import case as solutions
from governor_mechanism.studies.hard_cases import linkage_cases, study
from governor_mechanism.studies.hard_cases.study import HARD_CASES, Verdict


@pytest.fixture(scope="module")
def report():
    """Return the report of the short form."""
    return gm.hard_cases(short=True)


@pytest.mark.long
def test_every_row_of_the_short_form_passes(report):
    assert [f"{row.case} at {row.value:g}, {row.engine}: {row.verdict.value}" for row in report.rows if not row.verdict.passed] == []
    assert {row.case for row in report.rows} == set(HARD_CASES)
    assert {row.engine for row in report.rows} >= {"reduced", "multibody", "impulse"}
    # Without comparisons the study would show nothing.
    assert sum(row.verdict is Verdict.WITHIN_ESTIMATE for row in report.rows) > len(report.rows) / 2


@pytest.mark.long
def test_the_figure_of_a_case_shows_errors_estimates_and_ends(report, tmp_path):
    case = next(case for case in report.cases if case.name == "flight")
    page = hard_case_figure(report, case)
    assert page.save(tmp_path / "flight.png").stat().st_size > 10_000
    assert "left range" in " ".join(text.get_text() for axes in page.axes for text in axes.texts)


@pytest.mark.long
def test_the_report_as_text_table_and_record(report, tmp_path):
    text = str(report)
    assert f"{len(report.rows)} rows, 0 failed" in text
    assert "nearly-astatic: Spring that nearly balances the centrifugal load" in text
    assert len(report.save_csv(tmp_path / "cases.csv").read_text().splitlines()) == 1 + len(report.rows)
    pytest.importorskip("pandas")
    assert report.to_dataframe()["engine"].tolist() == [row.engine for row in report.rows]
    record = report.as_json()
    assert record["ok"] is True
    assert len(record["rows"]) == len(report.rows)


class WrongEngine(ReducedEngine):
    """The reduced engine, with an error in its readings that its estimate does not know."""

    def _run(self, scene, request):
        run = super()._run(scene, request)
        return dataclasses.replace(run, readings={name: values + self.error for name, values in run.readings.items()})


def run_case(monkeypatch, name, **changes):
    """Return the rows of a hard case with changes."""
    monkeypatch.setitem(HARD_CASES, name, dataclasses.replace(HARD_CASES[name], **changes))
    return gm.hard_cases([name]).rows


def run_reduced(monkeypatch):
    return run_case(monkeypatch, "redundant-joints", values=(2.0,), engines=lambda value: (ReducedEngine(),))


@pytest.mark.parametrize(("error", "verdict"), [(1e-5, Verdict.ERROR_EXCEEDS_ESTIMATE), (math.nan, Verdict.NOT_FINITE)])
def test_a_wrong_run_fails(monkeypatch, error, verdict):
    def wrong_engines(value: float) -> tuple[Engine, ...]:
        engine = WrongEngine()
        object.__setattr__(engine, "error", error)
        return (engine,)

    (row,) = run_case(monkeypatch, "redundant-joints", values=(2.0,), engines=wrong_engines)
    assert row.verdict is verdict
    assert not row.verdict.passed


def test_an_end_that_the_case_does_not_name_fails(monkeypatch):
    rows = run_case(monkeypatch, "step-limit", values=(10.0,), named_ends={})
    assert {row.verdict for row in rows} == {Verdict.UNEXPECTED_END}


def test_a_foreign_exception_fails(monkeypatch):
    def raise_error(self, scene, request):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(ReducedEngine, "_run", raise_error)
    (row,) = run_reduced(monkeypatch)
    assert (row.verdict, row.message) == (Verdict.CRASHED, "ZeroDivisionError: division by zero")


def test_a_slow_run_fails(monkeypatch):
    monkeypatch.setattr(study, "MAX_WALL_TIME", 0.0)
    (row,) = run_reduced(monkeypatch)
    assert row.verdict is Verdict.TOO_SLOW


@pytest.mark.parametrize(("stiffness", "damping"), [(4.0, 0.0), (4.0, 1.0), (4.0, 4.0), (100.0, 2e7)])
def test_a_linear_oscillation_solves_its_equation(stiffness, damping):
    # The slow root of strong damping is stiffness / damping to first order; elsewhere differences show the equation.
    times = np.linspace(0.0, 1.0, 2001)
    value, rate = solutions.linear_oscillation(times, 0.3, -0.2, stiffness=stiffness, damping=damping)
    assert (value[0], rate[0]) == pytest.approx((0.3, -0.2), abs=1e-9)
    if damping < 10:
        acceleration = np.gradient(rate, times)[1:-1]
        # Central differences have an error of h^2 / 6 times the third derivative of the rate, of order 10 here.
        np.testing.assert_allclose(acceleration, (-damping * rate - stiffness * value)[1:-1], atol=1e-5)
    else:
        assert value[-1] == pytest.approx((0.3 - 0.2 / damping) * math.exp(-stiffness / damping), rel=1e-9)


def test_a_swing_keeps_its_energy_and_its_period():
    amplitude, frequency = 1.0, 3.0
    period = solutions.pendulum_period(amplitude, frequency)
    times = np.linspace(0.0, 3 * period, 301)
    angle, rate = solutions.pendulum_swing(times, amplitude, frequency)
    np.testing.assert_allclose(0.5 * rate**2 - frequency**2 * np.cos(angle), -(frequency**2) * math.cos(amplitude), atol=1e-12)
    np.testing.assert_allclose(angle[[0, 100, 200, 300]], amplitude, atol=1e-12)


@pytest.mark.parametrize("shortening", [0.0, 1e-6, 1e-2])
def test_the_cranks_of_the_change_point_close(shortening):
    for angle in np.linspace(0.1, 6.2, 25).tolist():
        other, rate, coupler_rate = linkage_cases._second_crank(angle, shortening)

        def end(at: float) -> complex:
            return 0.5 * (1 - shortening) * np.exp(1j * at)

        coupler = 1.0 + 0.5 * np.exp(1j * other) - end(angle)
        assert abs(coupler) == pytest.approx(1.0, abs=1e-12)
        # The rates follow from differences, away from the change point at pi where they vary within sqrt(shortening).
        if abs(angle - math.pi) > 0.3 and shortening != 1e-6:
            step = 1e-6
            later, _, _ = linkage_cases._second_crank(angle + step, shortening)
            assert (math.remainder(later - other, 2 * math.pi)) / step == pytest.approx(rate, abs=1e-4)
            later_coupler = 1.0 + 0.5 * np.exp(1j * later) - end(angle + step)
            assert np.angle(later_coupler / coupler) / step == pytest.approx(coupler_rate, abs=1e-4)


@pytest.mark.parametrize("shortening", [0.0, 1e-2])
def test_the_inertia_of_the_cranks_is_the_energy_of_their_positions(shortening):
    first = 0.5 * (1 - shortening)

    def bodies(angle: float) -> list[tuple[complex, float, float]]:
        """Centre, direction and length of both cranks and the coupler, from positions alone."""
        other, _, _ = linkage_cases._second_crank(angle, shortening)
        start, end = first * np.exp(1j * angle), 1.0 + 0.5 * np.exp(1j * other)
        return [(start / 2, angle, first), ((1 + end) / 2, other, 0.5), ((start + end) / 2, float(np.angle(end - start)), 1.0)]

    step = 1e-5
    for angle in (0.4, 1.5, 2.6, 3.6, 4.7, 5.9):
        inertia = 0.0
        for (centre, turn, length), (later_centre, later_turn, _) in zip(bodies(angle - step), bodies(angle + step), strict=True):
            spin = math.remainder(later_turn - turn, 2 * math.pi) / (2 * step)
            inertia += abs(later_centre - centre) ** 2 / (2 * step) ** 2 + length**2 / 12 * spin**2
        # Central differences have an error of step^2 times third derivatives of order 10 to 1000 near the change point.
        assert linkage_cases._cranks_inertia(angle, shortening) == pytest.approx(inertia, rel=1e-6)


def test_a_run_ends_where_lengths_decide_between_branches_too_finely():
    case = HARD_CASES["change-point"]
    for engine in ("multibody", "impulse"):
        scene = study.parse_scene_document(case.make_document(1e-12))
        run = gm.run(scene, engine=engine, accuracy=1e-4, times=np.linspace(0.0, 6.0, 61))
        assert run.outcome is Outcome.BRANCH_UNRESOLVED
        # The first straight position lies a quarter turn after the start, at a rate of 1 rad/s.
        assert 0.8 * 0.5 * math.pi < run.times[-1] < 1.5 * math.pi
        solution = case.solve(1e-12, run.times)
        np.testing.assert_allclose(run.readings["angle1"], solution["angle1"][0], atol=3 * run.error_estimate)
