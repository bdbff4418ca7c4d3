"""Named crossings of readings: their times against motions known in closed form, and what counts as a crossing."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import governor_mechanism as gm
from governor_mechanism.model.events import EventKind, NamedCrossing
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from reference import marks
from refusing import refuses

ENGINES = [("reduced", 1e-10), ("multibody", 1e-10), ("impulse", 1e-6)]
"""Engines with the accuracy that they reach in these scenes within seconds."""


def crossing_times(run: gm.Trajectory) -> dict[str, list[float]]:
    """Return the times of each named crossing."""
    times: dict[str, list[float]] = {name.name: [] for name in run.scene.crossings}
    for event in run.events:
        if event.kind == EventKind.CROSSING:
            times[event.subject].append(event.time)
    return times


@pytest.mark.parametrize("engine", ["multibody", "impulse"])
def test_valve_events_are_those_of_the_closed_form(engine: str) -> None:
    run = gm.run("slide_valve_30", engine=engine)
    times = crossing_times(run)
    for name, _, exact, *_ in marks.VALVE_EVENTS[30][:4]:
        found = np.array(times[name.removeprefix("crank end ").replace("-", "_")])
        # 30 rpm are 180 deg/s, for 4 s. The steam edge passes at no less than 0.1 m/s, so that an error of the reading of
        # 1e-6 x 3 m (accuracy, length scale) is one of 3e-5 s at most.
        np.testing.assert_allclose(found, np.array([exact, exact + 360]) / 180, rtol=0, atol=3e-5 if engine == "impulse" else 1e-9)


def bouncing_weight(**events: dict[str, Any]) -> Scene:
    """A weight that falls from 1 m onto a stop at 0 m and loses half of its speed there."""
    return parse_scene_document(
        {
            "machine": "custom",
            "body": [{"name": "weight", "mass": 1.0, "at": [0, 1], "turns": False}],
            "joint": [{"type": "slider", "first": "ground.origin", "second": "weight.origin", "angle": "90 deg"}],
            "readings": {"height": {"y": "weight.origin"}},
            "effects": {"gravity": True, "stops": {"height": [0, "none"], "restitution": 0.5}},
            "start": {"height": 1},
            "run": {"duration": 1.4, "output_interval": 0.05},
            "events": events,
        }
    )


def times_at_height(height: float, end: float = 1.4, gravity: float = 9.81) -> NDArray[np.float64]:
    """Return when the bouncing weight passes a height, s."""
    times, time, speed = [math.sqrt(2 * (1 - height) / gravity)], math.sqrt(2 / gravity), 0.5 * math.sqrt(2 * gravity)
    while speed**2 > 2 * gravity * height:
        root = math.sqrt(speed**2 - 2 * gravity * height)
        times += [time + (speed - root) / gravity, time + (speed + root) / gravity]
        time, speed = time + 2 * speed / gravity, 0.5 * speed
    return np.array([time for time in times if time <= end])


@pytest.mark.parametrize(("engine", "accuracy"), ENGINES)
def test_crossings_between_impacts(engine: str, accuracy: float) -> None:
    # 1 mm is passed before and after an impact within one interval of the samples.
    heights = {"high": 0.1, "low": 0.001}
    scene = bouncing_weight(**{name: {"reading": "height", "value": height} for name, height in heights.items()})
    times = crossing_times(gm.run(scene, engine=engine, accuracy=accuracy))
    for name, height in heights.items():
        # The weight passes both heights with more than 0.1 m/s; the scale of heights is 1 m.
        np.testing.assert_allclose(times[name], times_at_height(height), rtol=0, atol=10 * accuracy)


@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_crossings_of_small_bounces_within_one_interval(engine: str) -> None:
    scene = bouncing_weight(near={"reading": "height", "value": 1e-5})
    found = crossing_times(gm.run(scene, engine=engine, accuracy=1e-10))["near"]
    expected = times_at_height(1e-5)
    assert len(expected) == 17  # the seventh bounce is the last one that is as high
    # The weight passes this height with more than 0.01 m/s.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_an_engine_that_may_miss_crossings_says_so() -> None:
    """Between two samples without contact events `impulse` knows the motion; between quick bounces it does not."""
    note = "crossings named in [events]"
    scene = bouncing_weight(near={"reading": "height", "value": 1e-5})
    assert any(note in text for text in gm.run(scene, engine="impulse", accuracy=1e-4).notes)
    assert not any(note in text for text in gm.run(scene, engine="multibody").notes)
    assert not any(note in text for text in gm.run(bouncing_weight(), engine="impulse", accuracy=1e-4).notes)


@pytest.mark.parametrize(("engine", "accuracy"), ENGINES)
def test_reaching_a_stop_is_no_crossing_of_its_position(engine: str, accuracy: float) -> None:
    scene = bouncing_weight(stop={"reading": "height", "value": 0}, start={"reading": "height", "value": 1})
    run = gm.run(scene, engine=engine, accuracy=accuracy)
    assert crossing_times(run) == {"stop": [], "start": []}
    assert any(event.kind == EventKind.IMPACT for event in run.events)


def turning_wheel(**events: dict[str, Any]) -> Scene:
    """A wheel that turns once a second for 3 s, with the height of a point of its rim, 100 mm from its centre."""
    return parse_scene_document(
        {
            "machine": "custom",
            "body": [{"name": "wheel", "mass": 1.0, "inertia": 1.0, "points": {"rim": [0.1, 0]}}],
            "joint": [{"type": "pin", "first": "ground.origin", "second": "wheel.origin"}],
            "readings": {"turn": {"angle": "wheel"}, "line": {"line": ["wheel.origin", "wheel.rim"]}, "height": {"y": "wheel.rim"}},
            "start": {"turn": 0, "turn_rate": math.tau},
            "run": {"duration": 3, "output_interval": 0.1, "accuracy": 1e-6},
            "events": events,
        }
    )


@pytest.mark.parametrize("engine", [engine for engine, _ in ENGINES])
def test_what_counts_as_a_crossing(engine: str) -> None:
    near_top = 0.1 * math.cos(0.05)
    scene = turning_wheel(
        top={"reading": "height", "value": 0.1},  # touched
        near_top={"reading": "height", "value": near_top},  # passed twice within a fiftieth of a turn
        rising={"reading": "height", "value": 0, "direction": "up"},  # where it starts, and again after each turn
        falling={"reading": "height", "value": 0, "direction": "down"},
        start={"reading": "turn", "value": 0},
        turns={"reading": "line", "value": "800 deg", "direction": "up"},  # a wrapped angle counts its turns
        backward={"reading": "line", "value": "800 deg", "direction": "down"},
        beyond={"reading": "turn", "value": "1081 deg"},
    )
    expected = {
        "top": [],
        "near_top": [0.25 + k + sign * 0.05 / math.tau for k in range(3) for sign in (-1, 1)],
        "rising": [1.0, 2.0],
        "falling": [0.5, 1.5, 2.5],
        "start": [],
        "turns": [800 / 360],
        "backward": [],
        "beyond": [],
    }
    found = crossing_times(gm.run(scene, engine=engine))
    assert {name: len(times) for name, times in found.items()} == {name: len(times) for name, times in expected.items()}
    for name, times in expected.items():
        # The slowest crossing, near the top, is one at 0.03 m/s; the accuracy of 1e-6 is relative to a scale of 0.1 m.
        np.testing.assert_allclose(found[name], times, rtol=0, atol=4e-6)


def test_an_angle_counts_turns_from_the_first_reported_time() -> None:
    scene = turning_wheel(turns={"reading": "line", "value": "100 deg"})
    times = np.linspace(1.5, 3.0, 31)
    run = gm.run(scene, engine="multibody", times=times)
    # At 1.5 s the line points left, and the run reports an angle within half a turn.
    turns = run.readings["line"][0] / math.tau - 1.5
    np.testing.assert_allclose(crossing_times(run)["turns"], [100 / 360 - turns], rtol=0, atol=1e-6)


def test_readings_of_several_parts_and_of_a_free_spindle() -> None:
    events = {"passed": {"reading": "engine.crank_angle", "value": 2}, "still": {"reading": "governor.sleeve_lift", "value": "500 mm"}}
    scene = parse_scene_document({**gm.load("watt_engine_stable").document, "events": events})
    run = gm.run(scene, times=np.linspace(0.0, 0.9, 10))
    # Up to 1 s the engine turns at its steady speed, and the sleeve rests at 542 mm.
    assert crossing_times(run) == {"passed": [pytest.approx(2 / 3.2654315914226206, abs=1e-7)], "still": []}
    free = parse_scene_document(
        {**gm.load("porter_free_spindle").document, "events": {"turned": {"reading": "spindle_angle", "value": 20}}}
    )
    times = [crossing_times(gm.run(free, engine=engine))["turned"] for engine in ("reduced", "multibody")]
    assert len(times[0]) == 1
    # The spindle turns at more than 10 rad/s, and both runs are accurate to 1e-6 rad.
    np.testing.assert_allclose(times[0], times[1], rtol=0, atol=2e-7)


def test_a_crossing_as_text_and_in_the_order_of_time() -> None:
    run = gm.run("slide_valve_30", engine="impulse", times=np.linspace(0.0, 1.0, 51))
    assert [event.time for event in run.events] == sorted(event.time for event in run.events)
    assert [str(event)[:16] for event in run.events if event.kind == EventKind.CROSSING] == ["crossing cut_off", "crossing release"]


def test_crossings_in_python_are_checked() -> None:
    scene, crossing = bouncing_weight(), NamedCrossing(name="passed", reading="height", value=0.5)
    refuses("crossing 'passed' is listed twice", dataclasses.replace, scene, crossings=(crossing, crossing))
    with pytest.raises(gm.MechanismError, match=r"no reading 'hight'.*Did you mean 'height'"):
        dataclasses.replace(scene, crossings=(dataclasses.replace(crossing, reading="hight"),))
    refuses("must be one of up, down, both; got 'sideways'", dataclasses.replace, crossing, direction="sideways")
    refuses("must be a finite number", dataclasses.replace, crossing, value=math.nan)
