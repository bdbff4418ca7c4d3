"""A run that goes on from the state of another one: both together are the run of the whole time."""

import numpy as np
import pytest

import governor_mechanism as gm
from data_files import read_data
from governor_mechanism.engines.continuation import continue_scene

# What these states hold besides poses: sticking friction, stops, drives, programs of speed, a free shaft, lags, a belt that breaks.
CASES = read_data(__file__)["cases"]
# The estimates compare runs of two tolerances; the error of the first run may have grown until the end of the second.
GROWTH = 20.0
ROUNDING = 1e-9
SINCE_START = "stored_work"
"""End of the name of a reading that counts from the start of its run."""


@pytest.mark.parametrize(("name", "engine", "times"), CASES)
def test_two_runs_in_succession_are_the_run_of_the_whole_time(name, engine, times):
    middle, end = times
    first = gm.run(name, engine, times=[0.0, middle])
    second = gm.run(name, engine, times=[0.0, end - middle], start=first.state())
    whole = gm.run(name, engine, times=[0.0, middle, end])
    assert second.outcome.ok
    assert second.scene.state.time == middle
    for reading, values in second.readings.items():
        if reading.endswith(SINCE_START):
            values = values + first.readings[reading][-1]
        allowed = GROWTH * (first.reading_errors[reading] + second.reading_errors[reading] + whole.reading_errors[reading])
        allowed += ROUNDING * whole.scales[reading]
        assert values[0] == pytest.approx(first.readings[reading][-1], abs=allowed), reading
        assert values[-1] == pytest.approx(whole.readings[reading][-1], abs=allowed), reading
        assert allowed < 1e-2 * whole.scales[reading], reading


def test_a_state_goes_on_twice():
    """The time of a state is that of the first clock, also after several runs."""
    state = None
    for _ in range(3):
        run = gm.run("porter_ramp", times=[0.0, 0.5], start=state)
        state = run.state()
    assert state.time == 1.5
    whole = gm.run("porter_ramp", times=[0.0, 1.5])
    assert run.readings["spindle_speed"][-1] == pytest.approx(whole.readings["spindle_speed"][-1], rel=1e-12)
    assert run.readings["sleeve_lift"][-1] == pytest.approx(whole.readings["sleeve_lift"][-1], abs=1e-6)


def test_what_sticks_goes_on_sticking():
    first = gm.run("porter_dry_friction", "reduced", times=np.linspace(0.0, 4.0, 400))
    sticking = np.flatnonzero(first.rates["sleeve_lift"] == 0.0)[1:]
    state = first.state(float(first.times[sticking[0]]))
    second = gm.run("porter_dry_friction", "reduced", times=[0.0, 1e-4], start=state)
    assert second.rates["sleeve_lift"][-1] == 0.0


def test_a_changed_speed_acts_from_the_state_on():
    state = gm.run("porter", times=[0.0, 0.5]).state()
    changed = gm.load("porter").replace({"spindle.speed": "140 rpm"})
    run = gm.run(changed, times=[0.0, 0.1], start=state)
    assert run.poses[0] == pytest.approx(np.array(state.poses), abs=1e-12)
    assert run.velocities[0] == pytest.approx(np.array(state.velocities), abs=1e-12)
    assert run.readings["spindle_speed"][0] == pytest.approx(140 * np.pi / 30)


def test_a_drive_of_another_speed_goes_on_from_where_it_stands():
    state = gm.run("jansen", times=[0.0, 1.0]).state()
    faster = gm.load("jansen").replace({"joint.motor.rate": "60 rpm"})
    run = gm.run(faster, times=[0.0, 0.5], start=state)
    assert run.poses[0] == pytest.approx(np.array(state.poses), abs=1e-9)
    angles = run.poses[:, run.body_names.index("crank"), 2]
    assert abs(angles[1] - angles[0]) == pytest.approx(0.5 * 60 * np.pi / 30, abs=1e-9)


def test_other_dimensions_do_not_fit_a_state():
    state = gm.run("porter", times=[0.0, 0.5]).state()
    with pytest.raises(gm.MechanismError, match=r"does not fit the scene: joint .* is open by"):
        gm.run(gm.load("porter").replace({"dimensions.arm": "310 mm"}), start=state)


def test_a_state_of_another_mechanism_is_refused():
    with pytest.raises(gm.MechanismError, match="the state to start from is one of the bodies"):
        gm.run("porter", start=gm.run("jansen", times=[0.0, 0.1]).state())


def test_a_state_is_one_at_a_reported_time():
    run = gm.run("porter", times=[0.0, 0.5])
    with pytest.raises(gm.MechanismError, match=r"at a reported time; found 0.3, and the run reports 2 times from 0 s to 0.5 s"):
        run.state(0.3)
    with pytest.raises(gm.MechanismError, match=r"start is a state of a run, as run.state\(\); found"):
        gm.run("porter", start=0.5)


def test_a_scene_that_goes_on_has_no_file():
    scene = continue_scene(gm.load("porter"), gm.run("porter", times=[0.0, 0.5]).state())
    with pytest.raises(gm.MechanismError):
        scene.to_toml()
