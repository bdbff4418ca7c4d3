"""Loads that swing with the time, and loads that depend on the speed of a shaft, against their formulas in every engine."""

import numpy as np
import pytest

import governor_mechanism as gm
from scene_documents import custom_document, pin

INERTIA, TORQUE, FREQUENCY = 0.5, 3.0, 1.5
SWING = 2 * np.pi * FREQUENCY
PHASE = 0.7


def rotor(moment: object, *, rate: float = 0.0, engine: str = "auto", accuracy: float = 1e-7) -> gm.Scene:
    """Return a disc on a shaft under a torque."""
    document = custom_document(
        size=1.0,
        plane="fixed",
        body=[{"name": "rotor", "mass": 1.0, "inertia": INERTIA}],
        joint=[pin("ground.origin", "rotor.centre")],
        force=[{"type": "torque", "body": "rotor", "moment": moment}],
        readings={"angle": {"angle": "rotor"}},
        start={"angle": 0.0, "angle_rate": rate},
        run={"duration": 2.0, "output_interval": 0.05, "accuracy": accuracy, "engine": engine},
    )
    return gm.Scene.from_dict(document)


def forced_speed(times: np.ndarray) -> np.ndarray:
    """Return the speed (rad/s) of a rotor at rest under T sin(W t + phase): I w' = T sin(W t + phase)."""
    return TORQUE / (INERTIA * SWING) * (np.cos(PHASE) - np.cos(SWING * times + PHASE))


@pytest.mark.parametrize(("engine", "accuracy"), [("multibody", 1e-8), ("reduced", 1e-8), ("impulse", 1e-4)])
def test_a_rotor_under_a_torque_that_is_a_sine_of_the_time(engine, accuracy):
    sine = {"harmonics": [{"amplitude": "3 N m", "frequency": "1.5 Hz", "phase": PHASE}]}
    run = gm.run(rotor(sine, engine=engine, accuracy=accuracy))
    assert run.outcome.name == "DONE", run.message
    scale = TORQUE / (INERTIA * SWING)
    assert np.max(np.abs(run.rates["angle"] - forced_speed(run.times))) < 10 * accuracy * scale  # rates are not certified, but smooth
    drift = scale * np.cos(PHASE) * run.times
    swing = scale / SWING * (np.sin(SWING * run.times + PHASE) - np.sin(PHASE))
    assert np.max(np.abs(run.readings["angle"] - (drift - swing))) <= accuracy * np.max(np.abs(run.readings["angle"])) + accuracy


def engine(load: object, *, name: str = "auto", accuracy: float = 1e-8, **dimensions: object) -> gm.Scene:
    """Return an engine with the mean torque of its gas and a load, from 6 rad/s."""
    given = {
        **{"area": "500 cm^2", "stroke": "650 mm", "cut_off": 0.375, "clearance": 0.05, "inertia": "60 kg m^2"},
        **{"supply_pressure": "4 bar", "back_pressure": "1.5 bar", "gas_torque": "mean", "load_torque": load},
    }
    run = {"duration": 2.0, "output_interval": 0.05, "accuracy": accuracy, "engine": name}
    start = {"crank_angle": 0, "crank_rate": "6 rad/s"}
    return gm.Scene.from_dict({"machine": "flywheel_engine", "dimensions": given | dimensions, "start": start, "run": run})


@pytest.mark.parametrize("name", ["multibody", "reduced"])  # the impulse engine refuses loads that depend on readings
@pytest.mark.parametrize(
    "load",
    [
        {"reading": "shaft_speed", "gain": "10 N m s/rad"},
        {"reading": "shaft_speed", "table": [["0 rad/s", "0 N m"], ["1000 rad/s", "10000 N m"]]},
        [{"reading": "shaft_speed", "gain": "10 N m s/rad", "about": "2 rad/s"}, "20 N m"],
    ],
)
def test_a_load_that_grows_with_the_speed_of_the_shaft_lets_it_approach_its_end_exponentially(load, name):
    accuracy = 1e-8
    scene = engine(load, name=name, accuracy=accuracy)
    run = gm.run(scene)
    assert run.outcome.name == "DONE", run.message
    gas_torque = next(one.moment.values[0] for one in scene.mechanism.force_elements if one.name == "gas")
    end = gas_torque / 10.0
    expected = end + (6.0 - end) * np.exp(-10.0 / 60.0 * run.times)
    assert run.readings["shaft_speed"] == pytest.approx(expected, abs=10 * accuracy * max(end, 6.0))
    assert run.readings["load_torque"] == pytest.approx(10.0 * expected, abs=100 * accuracy * max(end, 6.0))


def test_a_cut_off_and_a_friction_may_swing_within_what_they_can_be():
    half = {"harmonics": [{"amplitude": 0.2, "frequency": "1 Hz"}]}
    with pytest.raises(gm.MechanismError, match="cut_off must lie between 0 and 1"):
        gm.load("air_engine").replace({"dimensions.cut_off": [0.9, half], "dimensions.load_torque": 300.0})
    rough = gm.load("porter_dry_friction")
    assert rough.replace({"effects.dry_friction.sleeve": ["40 N", {"harmonics": [{"amplitude": "39 N", "frequency": 2}]}]})
    with pytest.raises(gm.MechanismError, match=r"effects\.dry_friction\.sleeve.*it goes down to -1"):
        rough.replace({"effects.dry_friction.sleeve": ["40 N", {"harmonics": [{"amplitude": "41 N", "frequency": 2}]}]})


@pytest.mark.parametrize(
    ("load", "sentence"),
    [
        ({"harmonics": [[2, "90 N m", "40 N m"]]}, "harmonic 1 must be a table; found [2, "),
        ({"harmonics": [{"amplitude": "9 N", "frequency": 2}]}, 'amplitude is a torque; "9 N" is a force'),
        ({"harmonics": [{"amplitude": 9, "order": 2}]}, "harmonic 1: order is unknown; known keys are amplitude, frequency, phase"),
        ({"reading": "angle", "harmonics": [{"amplitude": 9, "frequency": 2}]}, "known keys are amplitude, order, phase"),
        ({"harmonics": 3}, "harmonics must be a list, as [{ amplitude"),
        ({"harmonics": [{"amplitude": 9, "frequency": 0}]}, "frequency must be positive"),
    ],
)
def test_wrong_harmonics_are_refused_in_a_sentence(load, sentence):
    with pytest.raises(gm.MechanismError) as caught:
        rotor(load)
    assert sentence in str(caught.value)


def test_a_free_spindle_under_a_torque_that_swings():
    """The angular momentum of a governor that its stops hold is the integral of the torque."""
    sine = ["2 N m", {"harmonics": [{"amplitude": "3 N m", "frequency": "1.5 Hz", "phase": PHASE}]}]
    changes = {"spindle.torque": sine, "effects.stops": {"arm_angle": ["29 deg", "29.000001 deg"]}, "start.arm_angle": "29 deg"}
    for name, accuracy in (("multibody", 1e-7), ("impulse", 1e-4)):
        scene = gm.load("porter_free_spindle").replace({**changes, "run.duration": 1.0, "run.accuracy": accuracy, "run.engine": name})
        run = gm.run(scene)
        assert run.outcome.name == "DONE", run.message
        inertia = 2 * run.energy.rotation / run.readings["spindle_speed"] ** 2
        momentum = inertia * run.readings["spindle_speed"]
        impulse = 2 * run.times + TORQUE / SWING * (np.cos(PHASE) - np.cos(SWING * run.times + PHASE))
        assert momentum - momentum[0] == pytest.approx(impulse, abs=1e2 * accuracy * momentum[0])
