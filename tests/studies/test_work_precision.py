"""The study of accuracy: its reference is confirmed, errors fall as settings are tightened, and orders are as known."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.render.figures.work_precision import work_precision_figure
from governor_mechanism.studies.work_precision import confirm_by_impulse, fit_order, run_accuracy_study
from refusing import refuses

SECONDS_PER_EVALUATION = 2e-5
NAMES = ["reduced", "multibody", "impulse extrapolated", "impulse staggered", "impulse plain"]


def shortened(name, duration):
    scene = gm.load(name)
    return replace(scene, run=replace(scene.run, duration=duration))


class WorkTimer:
    """A clock that advances with the work of the engines: SECONDS_PER_EVALUATION per evaluation and default solver effort.

    Repeats of a run, which are equal, take their time on the clock only.
    """

    def __init__(self):
        self.now, self._last_call, self._last_result = 0.0, None, None

    def __call__(self):
        return self.now

    def count(self, run):
        """Return a method `run` of an engine that advances the clock."""

        def counted(engine, scene, times, **options):
            call = engine, scene, times.tobytes(), tuple(options.items())
            if call != self._last_call:
                self._last_call, self._last_result = call, run(engine, scene, times=times, **options)
            result = self._last_result
            effort = max(1.0, result.cost.iterations / ImpulseEngine.iterations)
            self.now += SECONDS_PER_EVALUATION * effort * result.cost.evaluations.get("equations of motion", result.cost.steps)
            return result

        return counted


@pytest.fixture(scope="module")
def timer():
    clock = WorkTimer()
    with pytest.MonkeyPatch.context() as patch:
        for engine in (ReducedEngine, MultibodyEngine, ImpulseEngine):
            patch.setattr(engine, "run", clock.count(engine.run))
        yield clock


@pytest.fixture(scope="module")
def study(timer):
    return run_accuracy_study(shortened("porter", 1.0), max_time=0.08, timer=timer)


@pytest.fixture(scope="module")
def frictional(timer):
    return run_accuracy_study(shortened("porter_dry_friction", 1.0), max_time=0.08, timer=timer)


def test_every_variant_of_every_engine_is_measured_with_errors_and_times(study):
    assert [variant.name for variant in study.variants] == NAMES
    for variant in study.variants:
        assert variant.points
        assert not variant.refusal
    for point in study.points:
        assert np.isfinite(point.error)
        assert point.error == point.max_error == max(point.errors.values())
        assert {"arm_angle", "rate of arm_angle", "sleeve_lift", "spindle_torque"} <= set(point.errors)
        assert point.evaluations > 0
        assert point.wall_time == pytest.approx(SECONDS_PER_EVALUATION * point.evaluations)
        assert 3 <= point.n_repeats <= 7


def test_the_reference_is_two_decades_better_and_another_engine_confirms_it(study):
    reference = study.reference
    assert (reference.engine, reference.confirmed_by) == ("multibody", "reduced")
    assert reference.confirmation_error < 1e-11
    assert reference.error == max(reference.estimate / 10, reference.confirmation_error) < 1e-11
    assert reference.resolvable_error == pytest.approx(100 * reference.error)


def test_an_engine_that_is_far_off_confirms_nothing(study):
    alone = replace(study.reference, confirmation_error=None, confirmed_by="")
    variant = study.variant("impulse extrapolated")
    assert confirm_by_impulse(alone, [variant]).confirmation_error == variant.best_point.max_error
    rough = replace(variant, points=tuple(replace(point, max_error=0.04) for point in variant.points))
    assert confirm_by_impulse(alone, [rough]) == alone
    assert "no other engine confirms it" in str(confirm_by_impulse(alone, [rough]))


def test_errors_fall_along_a_ladder(study):
    for variant in study.variants:
        errors = [point.error for point in variant.points]
        assert errors[-1] < 0.5 * errors[0], variant.name
    for name in ("impulse staggered", "impulse extrapolated"):
        errors = np.array([point.error for point in study.variant(name).points])
        assert np.all(np.diff(errors) < 0)
    for name in ("reduced", "multibody"):
        assert study.variant(name).best_point.error < study.reference.resolvable_error
        runs = [(point.evaluations, point.error) for point in study.variant(name).points]
        assert len(set(runs)) == len(runs)  # tolerances that give the same run are listed once


def test_the_orders_are_those_of_the_schemes(study):
    assert study.variant("impulse plain").order.value == pytest.approx(1.0, abs=0.15)
    assert study.variant("impulse staggered").order.value == pytest.approx(2.0, abs=0.1)
    assert study.variant("impulse extrapolated").order.value == pytest.approx(4.0, abs=0.5)
    assert study.variant("impulse staggered").order.standard_error < 0.1
    assert study.variant("multibody").order is None


def test_an_order_is_fitted_to_decreasing_errors_above_the_resolution(study):
    point = study.points[0]
    points = [replace(point, step=step, error=3.0 * step**2) for step in (0.2, 0.1, 0.05, 0.025, 0.0125)]
    assert fit_order(points, 0.0).value == pytest.approx(2.0)
    stuck = [replace(points[-1], step=0.006), replace(points[-1], step=0.003)]
    assert fit_order([*points, *stuck], 0.0).value == pytest.approx(2.0)
    assert fit_order(points[:3], 0.0) is None  # the first of them is too large


def test_a_measured_error_is_that_of_a_repeated_run(study):
    """The engine of a point, run as anyone runs it, against multibody at its own tight tolerance."""
    point = study.variant("impulse staggered").points[0]
    times = np.linspace(0.0, 1.0, study.n_samples)
    scene = study.scene
    again = gm.run(scene, point.engine, times=times, certify=False)
    true = MultibodyEngine(tolerance=1e-13).run(scene, times=times, certify=False)
    apart = np.max(np.abs(again.readings["arm_angle"] - true.readings["arm_angle"]))
    assert point.errors["arm_angle"] == pytest.approx(apart, rel=1e-6)


def test_the_cheapest_setting_has_the_fewest_evaluations_and_unreached_errors_are_reported(study):
    chosen = study.cheapest_for(1e-6)
    assert chosen.max_error <= 1e-6
    assert all(point.evaluations >= chosen.evaluations for point in study.points if point.max_error <= 1e-6)
    advice = study.advice(1e-6)
    assert advice.startswith(f"for 1e-06: use {chosen.variant} ")
    assert "impulse plain never within " in advice
    none = replace(study, variants=(study.variant("impulse plain"),))
    assert none.cheapest_for(1e-6) is None
    assert none.advice(1e-6).startswith("for 1e-06: no engine reaches it; impulse plain never within ")


@pytest.mark.parametrize("error", [0, 1, 2.0, -1e-3, float("nan"), "1e-6"])
def test_an_invalid_error_is_refused(study, error):
    for cheapest in (study.cheapest_for, study.variant("reduced").cheapest_for, study.variant("reduced").describe_cost):
        refuses("must be between 0 and 1", cheapest, error)
    assert study.cheapest_for(np.float32(1e-4)) == study.cheapest_for(1e-4)


def test_an_error_below_the_resolution_of_the_reference_is_refused(study):
    refuses("the reference has an error of", study.advice, 1e-16)


def test_other_invalid_arguments_are_refused(study):
    refuses("positive number of seconds", gm.accuracy_study, study.scene, longest=0.0)
    refuses("unknown variant 'impulse'", study.variant, "impulse")


def test_the_report_names_every_variant_and_is_written_to_files(study, tmp_path):
    text = str(study)
    assert all(f"\n{name}" in text for name in NAMES)
    assert "reduced confirms it to" in text
    assert "order" in text
    document = json.loads(study.save_json(tmp_path / "study.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in document["variants"]] == NAMES
    assert document["variants"][3]["order"]["value"] == pytest.approx(2.0, abs=0.1)
    assert document["variants"][0]["points"][0]["settings"]["engine"] == "reduced"
    with study.save_csv(tmp_path / "study.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    assert rows[0][:3] == ["variant", "setting", "step [s]"]
    assert {"event_time_error [s]", "max_error", "wall_time [s]"} <= set(rows[0])
    assert len(rows) == 1 + len(study.points)
    columns = [name.partition(" ")[0] for name in rows[0]]
    first = dict(zip(columns, rows[1], strict=True))
    assert float(first["wall_time"]) == study.points[0].wall_time
    assert float(first["error"]) == study.points[0].error
    pytest.importorskip("pandas")
    assert study.to_dataframe()["error"].tolist() == [point.error for point in study.points]


@pytest.mark.long
def test_the_figure_is_written_and_refuses_other_names(study, tmp_path):
    assert work_precision_figure(study, 1e-6).save(tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")
    refuses(r"end in one of \.png", work_precision_figure(study).save, tmp_path / "study.gif")
    assert [file.name for file in tmp_path.iterdir()] == ["study.png"]


def test_points_stand_at_the_median_of_their_times_with_bars_over_all(study):
    (panel,) = work_precision_figure(study).axes
    for point in study.points:
        assert point.wall_time == point.wall_times[0] == min(point.wall_times)
        assert len(point.wall_times) == point.n_repeats
    curves = [line.get_xdata() for line in panel.lines]
    for variant in study.variants:
        if variant.points:
            times = [1e3 * np.median(point.wall_times) for point in variant.points]
            assert any(len(x) == len(times) and np.allclose(x, times) for x in curves)
            first = variant.points[0].wall_times
            assert any(len(x) == 2 and np.allclose(x, [1e3 * first[0], 1e3 * first[-1]]) for x in curves)


def test_with_contacts_event_time_errors_are_listed_too(frictional):
    assert frictional.reference.confirmed_by == "reduced"
    assert frictional.points
    assert all(point.event_time_error is not None for point in frictional.points)
    assert all(point.max_error >= point.event_time_error / frictional.time_scale for point in frictional.points)
    assert "events, s" in str(frictional)
    assert "plain=True has no friction" in frictional.variant("impulse plain").refusal
    assert "impulse plain cannot run this scene" in frictional.advice(1e-4)
    assert frictional.variant("impulse staggered").best_point.max_error < 1e-3


def test_a_driven_mechanism_is_confirmed_by_impulse(timer, tmp_path):
    driven = run_accuracy_study(shortened("quick_return", 0.5), max_time=0.03, timer=timer)
    assert "drives move this mechanism" in driven.variant("reduced").refusal
    assert driven.reference.confirmed_by == "impulse extrapolated"
    assert driven.reference.confirmation_error == driven.variant("impulse extrapolated").best_point.max_error < 1e-4
    assert "only its own estimate holds" in str(driven)
    assert driven.cheapest_for(1e-6).variant == "multibody"
    work_precision_figure(driven).save(tmp_path / "driven.png")


def test_a_scene_that_no_other_engine_supports_has_no_confirmation(timer):
    played = run_accuracy_study(shortened("porter_clearance", 0.3), max_time=0.2, timer=timer)
    assert played.reference.confirmation_error is None
    assert "no other engine confirms it" in str(played)
    assert [variant.name for variant in played.variants if variant.points] == ["multibody"]


def test_progress_is_reported_to_the_end(timer):
    reports = []
    run_accuracy_study(shortened("porter", 0.1), 0.02, lambda done, total: reports.append((done, total)), timer)
    assert reports[-1][0] == reports[-1][1]
    assert [done for done, _ in reports] == sorted(done for done, _ in reports)


@pytest.mark.long
def test_a_scene_that_ends_early_is_compared_as_closely_as_any(timer):
    """A governor that opens fully after a fortieth of its time."""
    scene = gm.load("porter")
    fast = replace(scene.spindle, speeds=tuple(2 * speed for speed in scene.spindle.speeds))
    early = run_accuracy_study(scene.with_changes(spindle=fast), 0.05, timer=timer)
    assert early.early_end_message
    assert early.n_samples > 100
    assert early.cheapest_for(1e-5).variant in ("reduced", "multibody")


@pytest.mark.long
def test_a_stiff_joint_solver_gets_more_iterations_before_it_is_given_up(timer):
    """Seven bodies and ten pins: twenty iterations never close them, whatever the step."""
    squeezer = run_accuracy_study(gm.load("andrews_squeezer"), 0.08, timer=timer)
    staggered = squeezer.variant("impulse staggered")
    assert staggered.best_point.max_error < 0.1
    assert "iterations" in staggered.best_point.setting
    assert all(point.joint_gap < 1 for point in squeezer.points)
    assert squeezer.variant("multibody").best_point.max_error < squeezer.reference.resolvable_error
