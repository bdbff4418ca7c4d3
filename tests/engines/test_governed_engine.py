"""Governors that control an engine: motions against independent integrations, and laws of couplings and loads of readings."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from reference import haug_governor as haug
from reference import watt_engine as watt

CONTROL = {"reading": "governor.sleeve_lift", "gain": -2000.0, "about": 0.54}
ENGINES = pytest.mark.parametrize("engine", ["multibody", "reduced"])


def engine_scene(moment, **changes):
    """Return the stable Watt engine with another torque, and with some entries changed (two underscores for dots)."""
    torque = {"part.engine.force.steam.moment": moment}
    return gm.load("watt_engine_stable").replace({**torque, **{path.replace("__", "."): value for path, value in changes.items()}})


def reference(derivative, times, start):
    """Return the states of an independent integration, shape (n, states)."""
    run = solve_ivp(derivative, (0.0, times[-1]), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times, max_step=0.01)
    return run.y.T


@ENGINES
def test_haugs_governor_settles_at_the_loaded_speed_as_an_independent_integration_says(engine):
    run = gm.run("haug_governor", engine=engine, accuracy=1e-9)
    exact = haug.trajectory(run.times)
    for reading, name in (("collar_height", "y"), ("spindle_speed", "omega"), ("spindle_angle", "spindle_angle")):
        # The estimate is relative to the scale of each reading; the start speed is given to double precision.
        bound = max(run.error_estimate, 1e-11) * run.scales[reading]
        np.testing.assert_allclose(run.readings[reading], exact[name], rtol=0, atol=bound)
        for row in haug.MOTION:
            if row[0] <= run.times[-1]:
                value = np.interp(row[0], run.times, run.readings[reading])
                assert value == pytest.approx(row[("theta", "omega", "spindle_angle", "y").index(name) + 1], abs=bound)
    assert run.outcome.ok


@ENGINES
@pytest.mark.parametrize(("name", "motion"), [("watt_engine_hunting", watt.HUNTING_MOTION), ("watt_engine_stable", watt.STABLE_MOTION)])
def test_an_engine_hunts_or_settles_as_an_integration_in_extended_precision_says(engine, name, motion):
    run = gm.run(name, engine=engine, accuracy=1e-10)
    rows = [row for row in motion if row[0] <= run.times[-1]]
    assert len(rows) >= 5
    for time, angle, rate, speed in rows:
        index = int(np.argmin(np.abs(run.times - time)))
        # 1e-10 relative to 1 rad, and to the scale of speeds; a hunting motion amplifies it by less than 10.
        assert run.readings["governor.arm_angle"][index] == pytest.approx(angle, abs=1e-10)
        assert run.rates["governor.arm_angle"][index] == pytest.approx(rate, abs=1e-9)
        assert run.rates["engine.crank_angle"][index] == pytest.approx(speed, abs=1e-9)


def test_a_following_spindle_returns_no_torque_and_a_gear_does():
    follow = gm.run("watt_engine_stable", accuracy=1e-9)
    gear = gm.run(gm.load("watt_engine_stable").replace({"coupling.belt.type": "gear"}), accuracy=1e-9)
    assert "belt" in gear.reactions
    assert "belt" not in follow.reactions
    ratio = gear.readings["governor.spindle_speed"] / gear.rates["engine.crank_angle"]
    np.testing.assert_allclose(ratio, 2.0, rtol=1e-12)  # a constraint, closed to rounding
    # The engine under a gear: J W' = torque + ratio * belt torque.
    engine = watt.GovernedEngine(arm_damping=6.0)
    acceleration = np.gradient(gear.rates["engine.crank_angle"], gear.times, edge_order=2)
    torque = 2000.0 * (0.54 - engine.lift(gear.readings["governor.arm_angle"])) - np.where(gear.times < 1.0, 800.0, 600.0)
    belt = gear.reactions["belt"].moment
    smooth = np.abs(gear.times - 1.0) > 0.1
    # Second-order differences over 20 ms of a motion of 1 Hz: about 0.5 % of the largest acceleration.
    np.testing.assert_allclose((100.0 * acceleration)[smooth], (torque - 2.0 * belt)[smooth], atol=0.01 * np.max(np.abs(torque)))


def test_a_saturated_table_is_a_gain_between_its_ends_and_constant_beyond():
    table = [[0.10, 880.0], [0.20, 680.0]]
    start = {"part__governor__start": {"arm_angle": 0.55}, "part__engine__start": {"crank_rate": 3.2}}
    made = engine_scene([{"reading": "governor.sleeve_lift", "table": table}, -780.0], run__duration=6.0, **start)
    run = gm.run(made, accuracy=1e-9)
    engine = watt.GovernedEngine(arm_damping=6.0)

    def derivative(_, state):
        result = engine.derivative(state, 0.0)
        result[2] = (np.interp(engine.lift(state[0]), *zip(*table, strict=True)) - 780.0) / engine.engine_inertia
        return result

    exact = reference(derivative, run.times, [0.55, 0.0, 3.2])
    lift = engine.lift(exact[:, 0])
    assert lift.min() < 0.2 < lift.max()
    # The independent integration steps over the kinks: its error is about the cube of its largest step of 10 ms.
    np.testing.assert_allclose(run.readings["governor.arm_angle"], exact[:, 0], rtol=0, atol=1e-7)
    np.testing.assert_allclose(run.rates["engine.crank_angle"], exact[:, 2], rtol=0, atol=1e-7)


def test_a_throttle_scales_a_load():
    control = {"type": "control", "scales": "engine.steam", "reading": "governor.sleeve_lift", "gain": -2.0, "about": 0.54}
    throttled = engine_scene(1000.0, run__duration=3.0, coupling__throttle=control)
    added = engine_scene([{**CONTROL}], run__duration=3.0)
    runs = [gm.run(one, accuracy=1e-9) for one in (throttled, added)]
    # 1000 N m * 2 (0.54 m - lift) / m is the same torque.
    for name in ("governor.arm_angle", "engine.crank_angle"):
        np.testing.assert_allclose(runs[0].readings[name], runs[1].readings[name], rtol=0, atol=2e-9)
