"""A governor that stops or cannot carry the load: runaway and stall of the mean-torque engine against closed forms, and named events."""

import math
import re
from functools import cache
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.governed_engine import full_throttle_torque
from governor_mechanism.closed_form.pendulum import PendulumGovernor, spindle_inertia
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.changed_document import parse_scene_with
from reference import flywheel

GOVERNOR = PendulumGovernor(arm=0.3, offset=0.04, ball_mass=5.0, sleeve_mass=21.0)
FULL_TORQUE = full_throttle_torque(AirEngine(**flywheel.ENGINE))
FLYWHEEL_INERTIA = 800.0
HALF_LOAD = 150.0
SPINDLE_DRAG, SPINDLE_INERTIA = 0.3, 0.05
RPM = math.tau / 60

EVENTS = {
    "open": {"reading": "governor.sleeve_lift", "value": "80 mm", "direction": "down"},
    "slow": {"reading": "engine.shaft_speed", "value": "5 rpm", "direction": "down"},
}


@cache
def runaway() -> gm.Trajectory:
    """The shipped scene: the gear breaks at 5 s."""
    return gm.run("governed_engine_runaway")


def event_times(run: gm.Trajectory) -> dict[str, float]:
    """Return the first time of each kind of event of each reading or crossing."""
    times: dict[str, float] = {}
    for event in run.events:
        times.setdefault(f"{event.subject} {event.kind}", event.time)
    return times


def test_an_engine_whose_governor_stops_runs_away_with_the_torque_of_the_open_throttle() -> None:
    run = runaway()
    assert run.outcome is Outcome.DONE, run.message
    assert run.energy.drift < run.scene.run.accuracy
    times = event_times(run)
    opened, overspeed = times["throttle_fully_open crossing"], times["overspeed crossing"]
    assert 5.0 < opened < times["governor.sleeve_lift strikes its stop"] < times["governor_at_half_speed crossing"] < overspeed
    is_open = run.times > opened
    np.testing.assert_allclose(run.readings["engine.throttle_opening"][is_open], 1.0, rtol=0, atol=0)  # beyond the end of its table
    acceleration = (FULL_TORQUE - HALF_LOAD) / FLYWHEEL_INERTIA
    time, speed = run.times[is_open], run.readings["engine.shaft_speed"][is_open]
    # The integration of a constant acceleration leaves rounding.
    np.testing.assert_allclose(speed, speed[0] + acceleration * (time - time[0]), rtol=0, atol=1e-9)
    assert overspeed == pytest.approx(time[0] + (126 * RPM - speed[0]) / acceleration, abs=1e-9)
    # Before, the throttle took torque away: the engine cannot be faster than at full throttle since the gear broke.
    broken = int(np.argmin(np.abs(run.times - 5.0)))
    assert speed[-1] < run.readings["engine.shaft_speed"][broken] + acceleration * (run.times[-1] - 5.0)


def test_the_spindle_of_a_broken_gear_coasts_to_rest_by_its_drag() -> None:
    run = runaway()
    times = event_times(run)
    resting = run.times > times["governor.sleeve_lift rests on its stop"]
    angle = math.acos(1 - 0.07 / (2 * GOVERNOR.arm))  # of the sleeve at its stop
    np.testing.assert_allclose(run.readings["governor.arm_angle"][resting], angle, rtol=0, atol=1e-9)
    rate = SPINDLE_DRAG / (SPINDLE_INERTIA + float(spindle_inertia(GOVERNOR, arm_angle=angle)))
    time, speed = run.times[resting], run.readings["governor.spindle_speed"][resting]
    # The accuracy of 1e-8 is relative to a scale of about 10 rad/s.
    np.testing.assert_allclose(speed, speed[0] * np.exp(-rate * (time - time[0])), rtol=0, atol=1e-7)
    half = time[0] + math.log(speed[0] / (60 * RPM)) / rate
    assert times["governor_at_half_speed crossing"] == pytest.approx(half, abs=1e-8)  # the spindle slows down by 5 rad/s2


def test_without_drag_a_spindle_without_a_gear_keeps_its_speed_and_the_throttle_its_opening() -> None:
    document = gm.load("governed_engine_runaway").document
    scene = parse_scene_with(document, {"part.governor.spindle": {"inertia": SPINDLE_INERTIA}, "run.duration": 8.0}.items())
    run = gm.run(scene)
    coasting = run.times > 5.0
    inertia = SPINDLE_INERTIA + np.asarray(spindle_inertia(GOVERNOR, arm_angle=run.readings["governor.arm_angle"][coasting]))
    momentum = inertia * run.readings["governor.spindle_speed"][coasting]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-7)  # accuracy 1e-8 of the scale of speeds
    assert not run.events


def test_a_coasting_governor_without_stops_ends_at_its_dead_centre() -> None:
    scene = parse_scene_with(gm.load("governed_engine_runaway").document, {"part.governor.effects.stops": False}.items())
    run = gm.run(scene)
    assert run.outcome is Outcome.LEFT_RANGE
    assert "arms and links are in line" in run.message
    assert 6.0 < run.times[-1] < 8.0


@pytest.mark.parametrize("fraction", [2.0, [[0, 1.0], [6, 1.0], [6, 2.0]]], ids=["from the start", "from 6 s"])
def test_a_load_above_the_power_of_the_engine_stalls_it_when_its_momentum_is_used_up(fraction: Any) -> None:
    # A stop keeps the arms from their dead centre, which they reach when the engine stands still.
    changes = {
        "load.fraction": fraction,
        "events": EVENTS,
        "part.governor.effects.stops": {"sleeve": ["40 mm", "130 mm"], "restitution": 0},
    }
    scene = parse_scene_with(gm.load("governed_engine_mean_torque").document, changes.items())
    run = gm.run(scene, accuracy=1e-9)
    assert run.outcome is Outcome.SHAFT_STALLED
    # From the opening of the throttle on, the torque on all that turns is constant, whatever the governor does.
    opened = event_times(run)["open crossing"]
    k = int(np.searchsorted(run.times, opened, side="right"))
    inertia = FLYWHEEL_INERTIA + float(spindle_inertia(GOVERNOR, arm_angle=float(run.readings["governor.arm_angle"][k])))
    stalled = run.times[k] + inertia * run.readings["engine.shaft_speed"][k] / (600.0 - FULL_TORQUE)
    (found,) = re.findall(r"at t = (\d+\.\d+) s", run.message)
    # The message has nine digits; an error of the speed of 1e-9 times 10 rad/s costs 4e-8 s.
    assert float(found) == pytest.approx(stalled, abs=1e-7)
    speed_at_end = run.readings["engine.shaft_speed"][-1]
    assert 0 < speed_at_end < 0.02 * (600.0 - FULL_TORQUE) / FLYWHEEL_INERTIA  # within one output interval
    slow = event_times(run)["slow crossing"]
    angle = math.acos(1 - 0.04 / (2 * GOVERNOR.arm))  # of the sleeve at its stop
    momentum = (FLYWHEEL_INERTIA + float(spindle_inertia(GOVERNOR, arm_angle=angle))) * 5 * RPM
    assert slow == pytest.approx(stalled - momentum / (600.0 - FULL_TORQUE), abs=1e-7)  # as above
