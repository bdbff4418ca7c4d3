"""Named crossings of speeds: their times against closed forms and dense sampling, what counts as a crossing, and refusals."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import governor_mechanism as gm
from crank_scenes import air_engine_document
from governor_mechanism.closed_form.flywheel_engine import AirEngine, stored_work
from governor_mechanism.closed_form.pendulum import PendulumGovernor, spindle_inertia
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.coupling.coupled_system import AngleRate
from governor_mechanism.model.events import EventKind, NamedCrossing
from governor_mechanism.observables.crossings import CrossedSpeed
from governor_mechanism.observables.sampled_motion import SampledMotion
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.scenes.parser import parse_scene_document
from reference import flywheel

ENGINES = [("multibody", 1e-10), ("reduced", 1e-10), ("impulse", 1e-6)]
"""Engines with the accuracy that they reach in these scenes within seconds."""


def crossing_times(run: gm.Trajectory) -> dict[str, list[float]]:
    """Return the times of each named crossing."""
    times: dict[str, list[float]] = {crossing.name: [] for crossing in run.scene.crossings}
    for event in run.events:
        if event.kind == EventKind.CROSSING:
            times[event.subject].append(event.time)
    return times


def with_events(name: str, events: dict[str, Any], **run: float) -> gm.Scene:
    """Return a shipped scene with these events and settings of the run."""
    return parse_scene_with(gm.load(name).document, {"events": events, **{f"run.{key}": value for key, value in run.items()}}.items())


class FreeRunningEngine:
    """The closed cycle of the source's example: speed over crank angle by the work of gas and load, and time by quadrature."""

    def __init__(self) -> None:
        ratio, _, lowest, highest, *_ = flywheel.CASES["closed by the load"]
        self.engine = AirEngine(**(flywheel.ENGINE | {"load_pressure": ratio * flywheel.ENGINE["atmospheric_pressure"]}))
        self.lowest, self.highest = math.radians(lowest), math.radians(highest)

    def speed(self, angle: float) -> float:
        """Return the speed (rad/s) at a crank angle (rad); both strokes of a turn are alike."""
        work = float(stored_work(self.engine, crank_angle=angle % math.pi))
        return math.sqrt(flywheel.EXAMPLE_START_SPEED**2 + 2 * work / flywheel.EXAMPLE_INERTIA)

    def time(self, angle: float) -> float:
        """Return the time (s) at a crank angle within a stroke and a half, in which the gas changes at known angles."""
        changes = [0.0, *self.engine.interval_limits, math.pi, math.pi + self.engine.interval_limits[0]]
        limits = [change for change in changes if change < angle] + [angle]
        return sum(quad(lambda phi: 1 / self.speed(phi), *ends, epsabs=1e-13, epsrel=1e-13)[0] for ends in pairwise(limits))

    def passages(self, speed: float) -> dict[str, tuple[float, float]]:
        """Return when (s) in the first stroke, or soon after it, the speed rises and falls through a value, and how fast (rad/s2)."""
        limits = {"up": (self.lowest, self.highest), "down": (self.highest, math.pi + self.lowest)}
        found = {}
        for way, ends in limits.items():
            angle = brentq(lambda phi: self.speed(phi) - speed, *ends, xtol=1e-14)
            slope = speed * abs(self.speed(angle + 1e-4) - self.speed(angle - 1e-4)) / 2e-4
            found[way] = self.time(angle), slope
        return found


@pytest.mark.parametrize(("engine", "accuracy"), ENGINES)
def test_an_engine_passes_speeds_when_the_work_of_its_gas_says(engine: str, accuracy: float) -> None:
    closed, lowest, highest = FreeRunningEngine(), flywheel.EXAMPLE_LOWEST_SPEED, flywheel.EXAMPLE_HIGHEST_SPEED
    stroke, n_strokes = closed.time(math.pi), 4
    # The lowest speed lies near the kink at the dead centre.
    speeds = {"middle": 0.5 * (lowest + highest), "near_lowest": lowest + 1e-4, "near_highest": highest - 2e-4}
    ways = [(name, way) for name in speeds for way in ("up", "down")]
    events = {f"{name}_{way}": {"reading": "shaft_speed", "value": speeds[name], "direction": way} for name, way in ways}
    events |= {"touched": {"reading": "shaft_speed", "value": highest}, "beyond": {"reading": "shaft_speed", "value": highest + 1e-3}}
    document = air_engine_document(duration=n_strokes * stroke) | {"events": events}
    run = gm.run(parse_scene_document(document), engine=engine, accuracy=accuracy)
    found = crossing_times(run)
    assert found["touched"] == found["beyond"] == []
    for name, way in ways:
        time, slope = closed.passages(speeds[name])[way]
        exact = time + stroke * np.arange(-1, n_strokes)
        exact = exact[(exact > 0) & (exact < n_strokes * stroke)]
        # The error of the speed over its slope; the source prints its start speed with an error of 5e-12 rad/s.
        np.testing.assert_allclose(found[f"{name}_{way}"], exact, rtol=0, atol=(run.reading_errors["shaft_speed"] + 1e-11) / slope)


def test_no_crossing_of_a_governed_engine_is_missed_or_doubled() -> None:
    """Against the engine's dense output at ten points of each interval near the speed: the torque has kinks at each change of the gas."""
    events = {
        f"{name}_{way}": {"reading": reading, "value": "121 rpm", "direction": way}
        for name, reading in (("shaft", "engine.shaft_speed"), ("spindle", "governor.spindle_speed"))
        for way in ("up", "down")
    }
    run = gm.run(with_events("governed_engine", events, duration=2.0))
    value, angle, mechanism = run.scene.crossings[0].value, "engine.crank_angle", run.scene.mechanism
    motion = run.deferred_results.sample_motion()
    speeds = evaluate_output(mechanism, angle, motion.poses).rate(motion.velocities)
    points = dict(zip(motion.times.tolist(), speeds.tolist(), strict=True))
    reach = 1.5 * np.max(np.abs(np.diff(speeds)))
    for k in np.flatnonzero(np.minimum(np.abs(speeds[:-1] - value), np.abs(speeds[1:] - value)) < reach).tolist():
        for time in np.linspace(*motion.times[k : k + 2], 11)[1:-1].tolist():
            poses, velocities = motion.dense_output(k, time)
            points[time] = float(evaluate_output(mechanism, angle, poses).rate(velocities))
    times = np.array(sorted(points))
    deviations = np.array([points[time] for time in times]) - value
    passed = {
        "up": np.flatnonzero((deviations[:-1] < 0) & (deviations[1:] > 0)),
        "down": np.flatnonzero((deviations[:-1] > 0) & (deviations[1:] < 0)),
    }
    assert min(map(len, passed.values())) >= 7  # twice in a turn
    found = crossing_times(run)
    for way, indices in passed.items():
        for name in ("shaft", "spindle"):  # the gear has the ratio 1
            assert len(found[f"{name}_{way}"]) == len(indices)
            assert np.all((found[f"{name}_{way}"] >= times[indices]) & (found[f"{name}_{way}"] <= times[indices + 1]))


@pytest.mark.parametrize(("peak_time", "shift"), [(0.5, 0.0), (0.525, 0.05)], ids=["at a sample", "inside an interval"])
def test_samples_alone_show_each_passage_at_a_jump_of_the_slope_once(peak_time: float, shift: float) -> None:
    """A speed that rises and falls by 1 rad/s2, without a dense output: its slope jumps where an input does."""
    times = np.linspace(0.0, 1.0, 11)
    speeds, slopes = 1 + peak_time - np.abs(times - peak_time), np.where(times < peak_time, 1.0, -1.0)
    angles = (1 + peak_time) * times - 0.5 * (times - peak_time) * np.abs(times - peak_time)
    states = [np.zeros((11, 1, 3)) for _ in range(3)]
    for state, values in zip(states, (angles, speeds, slopes), strict=True):
        state[:, 0, 2] = values
    motion = SampledMotion(times, *states, np.ones(11), lambda k, time: None, np.zeros(0), np.array([peak_time]))
    speed = CrossedSpeed(gm.load("air_engine").mechanism, motion, AngleRate(angle="crank_angle"))
    assert speed.find_times(1 + peak_time, "both", 1e-9) == []  # touched, or not seen between the samples
    value = 1 + peak_time - 0.045
    # In an interval with a jump inside, the speed is taken to change evenly: half an interval.
    np.testing.assert_allclose(speed.find_times(value, "up", 1e-9), [peak_time - 0.045], rtol=0, atol=1e-12 + shift)
    np.testing.assert_allclose(speed.find_times(value, "down", 1e-9), [peak_time + 0.045], rtol=0, atol=1e-12 + shift)


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_a_free_spindle_passes_a_speed_at_the_arm_angle_that_its_angular_momentum_says(engine: str) -> None:
    scene = gm.load("porter_free_spindle")
    governor = PendulumGovernor(
        **{key: value for key, value in scene.part.dimensions.items() if key in ("arm", "offset", "ball_mass", "sleeve_mass")}
    )
    calm = gm.run(scene, engine=engine)
    speeds, angles = calm.readings["spindle_speed"], calm.readings["arm_angle"]
    momentum = (scene.spindle.inertia + spindle_inertia(governor, arm_angle=float(angles[0]))) * speeds[0]
    angle = 0.5 * float(angles.min() + angles.max())
    speed = momentum / (scene.spindle.inertia + spindle_inertia(governor, arm_angle=angle))
    events = {"slow": {"reading": "spindle_speed", "value": speed}, "wide": {"reading": "arm_angle", "value": angle}}
    found = crossing_times(gm.run(with_events("porter_free_spindle", events), engine=engine, accuracy=1e-10))
    assert len(found["slow"]) >= 4
    # Angle and speed change by more than 0.1 per second there, and both are accurate to 1e-10 of their scales of 1 rad and about 10 rad/s.
    np.testing.assert_allclose(found["slow"], found["wide"], rtol=0, atol=2e-8)


def test_a_spindle_that_follows_has_the_speed_of_its_leader() -> None:
    events = {"fast": {"reading": "governor.spindle_speed", "value": "66 rpm", "direction": "up"}}
    scene = with_events("watt_engine_stable", events, duration=3.0)
    (time,) = crossing_times(gm.run(scene))["fast"]
    run = gm.run(scene, times=[0.0, time], accuracy=1e-9)
    # The ratio of the belt is 2; the scale of the accuracy of 1e-6 is about 10 rad/s.
    assert 2 * run.rates["engine.crank_angle"][-1] == pytest.approx(66 * math.tau / 60, abs=1e-5)


def test_speeds_in_python_are_checked() -> None:
    def crossing(reading: str) -> NamedCrossing:
        return NamedCrossing(name="passed", reading=reading, value=13.0)

    scene = gm.load("governed_engine")
    assert replace(scene, crossings=(crossing("engine.shaft_speed"),)).crossings
    with pytest.raises(gm.MechanismError, match=r"no reading 'engine.shaft_sped'.*Did you mean 'engine.shaft_speed'"):
        replace(scene, crossings=(crossing("engine.shaft_sped"),))
    with pytest.raises(gm.MechanismError, match="crossing 'passed' watches 'spindle_speed', a speed that is given"):
        replace(gm.load("porter"), crossings=(crossing("spindle_speed"),))
