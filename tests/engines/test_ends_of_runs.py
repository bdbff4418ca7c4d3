"""How runs end: the same end in all engines, at its exact time, also before the first report; and events that cannot be found."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from data_files import read_data
from governor_mechanism.engines.impulse import level_runs
from governor_mechanism.engines.impulse import run as impulse_run
from governor_mechanism.engines.impulse.records import FixedStepSolution
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.multibody.run import ExplicitRun
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.observables import run_result
from governor_mechanism.observables.sampled_motion import BoundedDenseOutput
from random_scenes import draw_study_scene
from scene_documents import Table

ENGINES = ("reduced", "multibody", "impulse")

SCENES = read_data(__file__)


def load(document: Table, **changes: Any) -> gm.Scene:
    return gm.Scene.from_dict(document).replace(changes)


def exit_time(run: gm.Trajectory) -> float:
    return float(run.detail.rsplit("at t = ", 1)[1].removesuffix(" s"))


@pytest.fixture(scope="module", params=ENGINES)
def backward_run(request: pytest.FixtureRequest) -> gm.Trajectory:
    return gm.run(load(SCENES["AIR_ENGINE"], **{"start.crank_angle": 0, "start.crank_rate": "-6 rad/s"}), engine=request.param)


def test_a_shaft_that_turns_back_at_the_start_stalls_there(backward_run: gm.Trajectory) -> None:
    assert backward_run.outcome is gm.Outcome.SHAFT_STALLED
    assert exit_time(backward_run) == 0.0
    assert len(backward_run.times) == 0


def test_a_run_without_reports_breaks_nothing(backward_run: gm.Trajectory, tmp_path: Path) -> None:
    assert backward_run.events == ()
    assert dict(backward_run.speed_fluctuations) == {}
    assert len(backward_run.to_dataframe()) == 0
    assert "no times" in repr(backward_run)
    assert "stalls" in backward_run._repr_html_()
    for draw in (backward_run.plot, backward_run.plot_diagnostics, lambda: backward_run.film(tmp_path / "film.gif")):
        with pytest.raises(gm.MechanismError, match="no reported time"):
            draw()


@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_a_control_out_of_range_at_the_start_ends_the_run_there(engine: str) -> None:
    rod = {"coupling.throttle_rod.table": None, "coupling.throttle_rod.gain": -1e6, "coupling.throttle_rod.about": "80 mm"}
    run = gm.run(gm.load("governed_engine").replace(rod), engine=engine)
    assert run.outcome is gm.Outcome.CONTROL_OUT_OF_RANGE
    assert exit_time(run) == 0.0
    assert len(run.times) == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_fast_arms_do_not_pass_a_dead_centre(engine: str) -> None:
    run = gm.run(load(SCENES["STIFF_SLEEVE"]), engine=engine)
    assert run.outcome is gm.Outcome.LEFT_RANGE
    assert "in line" in run.detail
    assert run.times.tolist() == [0.0]
    # The engines of order 8 agree to the accuracy of 1e-6 in swings of 10 ms, and better; impulse to that in time scales of 0.2 s.
    assert exit_time(run) == pytest.approx(0.00308404022, abs=1e-9 if engine != "impulse" else 2e-7)


def test_limits_are_checked_over_many_intervals_as_over_one(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = list[list[tuple[Any, ...]]]()
    integrate = level_runs.integrate_over_grid

    def record(*arguments: Any) -> FixedStepSolution:
        one = integrate(*arguments)
        ends[-1].append((len(one.states.times), one.first_exit, one.n_steps, one.reached_limit, one.has_chatter))
        return one

    monkeypatch.setattr(level_runs, "integrate_over_grid", record)
    for together in (1, 16):
        monkeypatch.setattr(impulse_run, "N_PATHS_TOGETHER", together)
        ends.append([])
        gm.run(load(SCENES["STIFF_SLEEVE"]), engine="impulse")
    assert ends[0] == ends[1]
    assert all(n_times == first_exit.time_index + 1 for n_times, first_exit, *_ in ends[1] if first_exit is not None)
    assert any(first_exit is not None for _, first_exit, *_ in ends[1])


def test_engines_end_at_the_same_time_with_the_same_reports() -> None:
    reduced, multibody = (gm.run(load(SCENES["FALLING_BALLS"]), engine=engine) for engine in ("reduced", "multibody"))
    assert reduced.outcome is multibody.outcome is gm.Outcome.LEFT_RANGE
    np.testing.assert_array_equal(reduced.times, multibody.times)
    assert exit_time(reduced) == pytest.approx(exit_time(multibody), abs=1e-8)  # time at which 0.28 rad/s cover 3e-9 rad
    for name, values in multibody.readings.items():
        np.testing.assert_allclose(reduced.readings[name], values, rtol=0, atol=1e-8 * multibody.scales[name], err_msg=name)


@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_events_are_found_where_an_interval_ends_at_a_kink(engine: str) -> None:
    run = gm.run(load(SCENES["AIR_ENGINE"]), engine=engine)
    assert run.outcome is gm.Outcome.DONE
    assert len(run.events) == 10
    assert run.event_notes == ()


def test_a_failed_search_costs_neither_the_run_nor_other_events(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> list[Any]:
        raise ValueError("no root there")

    crossing = {"past_dead_centre": {"reading": "crank_angle", "value": 0, "direction": "up"}}
    run = gm.run(load(SCENES["AIR_ENGINE"] | {"events": crossing}), engine="multibody")
    monkeypatch.setattr(run_result, "find_singular_configurations", fail)
    assert [event.subject for event in run.events] == ["past_dead_centre"]
    assert any("no root there" in note for note in run.event_notes)


def test_a_dense_output_that_ends_is_noted() -> None:
    dense_output = BoundedDenseOutput(lambda k, time: None if time > 1.0 else (np.zeros((1, 3)), np.zeros((1, 3))), max_states=2)
    assert dense_output(0, 0.5) is not None
    assert dense_output(0, 1.5) is None
    assert dense_output(0, 0.5) is None  # the bound is reached
    assert ["t = 1.5 s" in note for note in dense_output.notes()] == [True, False]


def test_the_search_for_events_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load(SCENES["AIR_ENGINE"])
    complete = gm.run(scene, engine="reduced").events
    monkeypatch.setattr(run_result, "MAX_EVENT_SAMPLES", 100)
    run = gm.run(scene, engine="reduced")
    assert 0 < len(run.events) < len(complete)
    assert [event.subject for event in run.events] == [event.subject for event in complete[: len(run.events)]]
    assert "are not searched for" in run.event_notes[0]


@pytest.mark.long
def test_impulse_follows_a_flight_as_multibody_does_and_says_where_it_ends() -> None:
    ball = SCENES["BALL_ON_A_TURNING_SLIDE"]
    multibody = gm.run(load(ball), engine="multibody")
    assert multibody.times[-1] == 0.75
    np.testing.assert_allclose(multibody.readings["x"], 0.1 * np.cosh(16.0 * multibody.times), rtol=1e-4)
    followed = gm.run(load(ball), engine="impulse", times=np.linspace(0.0, 0.7, 15))
    assert followed.outcome is gm.Outcome.DONE
    np.testing.assert_allclose(followed.readings["x"], 0.1 * np.cosh(16.0 * followed.times), rtol=1e-4)
    assert followed.readings["x"][-1] > 3000.0
    impulse = gm.run(load(ball), engine="impulse")
    assert impulse.outcome is gm.Outcome.LEFT_RANGE
    assert "farther than engine impulse follows it; choose engine multibody" in impulse.message


def test_a_flight_has_one_end_and_the_scale_of_its_torque_follows_it() -> None:
    scene = load(SCENES["SLIDING_RODS_THAT_FLY_AWAY"])
    impulse, multibody = (gm.run(scene, engine=engine) for engine in ("impulse", "multibody"))
    for run in (impulse, multibody):
        assert run.outcome is gm.Outcome.DONE
        assert run.times[-1] == 0.92
        assert run.scales["spindle_torque"] == pytest.approx(np.max(np.abs(run.readings["spindle_torque"])), rel=1e-12)
    for name, values in impulse.readings.items():
        allowed = (impulse.error_estimate + multibody.error_estimate) * impulse.scales[name]
        np.testing.assert_allclose(values, multibody.readings[name], rtol=0, atol=allowed, err_msg=name)


def test_a_stiff_motion_that_must_take_explicit_steps_names_its_cure() -> None:
    run = MultibodyEngine(max_steps=3000).run(load(SCENES["LIGHT_DAMPED_BALL"]))
    assert run.outcome is gm.Outcome.STEP_LIMIT
    assert "decays within 3e-08 s" in run.message  # 1e-7 kg / (4 N s/m)
    assert "give the body no mass" in run.message


@pytest.mark.long
def test_an_exit_beside_a_singular_configuration_is_found_in_a_few_steps(monkeypatch):
    """The search for the time of the exit tries times at which the links would be in line, where steps become as small as they can."""
    steps: list[int] = []
    integrate = ExplicitRun.integrate

    def count_steps(self, end):
        status = integrate(self, end)
        steps.append(int(self.counts[StepCounter.ACCEPTED] + self.counts[StepCounter.REJECTED]))
        return status

    monkeypatch.setattr(ExplicitRun, "integrate", count_steps)
    scene = draw_study_scene("uncrossed links", 5, 20261124).scene
    runs = [gm.run(scene, engine, accuracy=1e-8) for engine in ("reduced", "multibody")]
    assert [run.outcome for run in runs] == [gm.Outcome.LEFT_RANGE] * 2
    np.testing.assert_array_equal(runs[0].times, runs[1].times)
    assert exit_time(runs[0]) == pytest.approx(exit_time(runs[1]), abs=1e-5)
    assert max(steps) <= 500
