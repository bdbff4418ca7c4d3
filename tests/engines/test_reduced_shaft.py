"""Engine reduced with a shaft: free, geared or followed, with controlled loads, against multibody and published equations."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines.selection import select_engine
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.time_functions import InputFunction, LinearFunction
from shaft_scenes import GEAR, LIFT, LOADS, SPRING, STEADY, STEAM, TABLES, changed

MODELS = ["haug_governor", "watt_engine_hunting", "watt_engine_stable"]


def assert_engines_agree(scene, accuracy, allowed=None):
    """Compare all readings and rates of reduced and multibody; by default within the sum of their error estimates."""
    runs = [gm.run(scene, engine=engine, accuracy=accuracy) for engine in ("reduced", "multibody")]
    reduced, multibody = runs
    limit = sum(run.error_estimate for run in runs) if allowed is None else allowed
    assert reduced.body_names == multibody.body_names
    for name, values in reduced.readings.items():
        np.testing.assert_allclose(values, multibody.readings[name], rtol=0, atol=limit * reduced.scales[name], err_msg=name)
    # The energies follow from readings and rates, whose errors they add.
    np.testing.assert_allclose(reduced.energy.jacobi, multibody.energy.jacobi, rtol=0, atol=100 * limit * reduced.energy.scale)
    assert reduced.energy.drift < 100 * limit
    return reduced, multibody


@pytest.mark.long
@pytest.mark.parametrize("name", MODELS)
def test_shipped_engines_agree_with_multibody(name):
    for accuracy in (1e-8, 1e-10):
        for run in assert_engines_agree(gm.load(name), accuracy):
            assert run.outcome is Outcome.DONE
    assert_engines_agree(gm.load(name), 1e-12, allowed=1e-11)  # rounding, which the hunting engine amplifies over 30 s


@pytest.mark.parametrize("name", MODELS)
def test_auto_chooses_reduced(name):
    assert select_engine("auto", gm.load(name))[0].name == "reduced"


@pytest.mark.parametrize("changes", [*LOADS.values(), *TABLES.values()], ids=[*LOADS, *TABLES])
def test_shafts_and_their_loads_agree_with_multibody(changes):
    reduced, multibody = assert_engines_agree(changed("watt_engine_hunting", changes), 1e-9)
    assert [(event.kind, event.subject) for event in reduced.events] == [(event.kind, event.subject) for event in multibody.events]
    np.testing.assert_allclose([event.time for event in reduced.events], [event.time for event in multibody.events], rtol=0, atol=1e-7)


def test_friction_and_stops_act_in_the_scenes_above():
    for name, kind in (("friction", EventKind.STICK), ("friction of the crank angle", EventKind.STICK), ("stops", EventKind.IMPACT)):
        run = gm.run(changed("watt_engine_hunting", LOADS[name]), engine="reduced")
        assert kind in {event.kind for event in run.events}, name


def test_a_controlled_load_on_the_governor_itself_agrees_with_multibody():
    """The spindle speed is given: no shaft, but forces that depend on readings."""
    scene = gm.load("porter_dry_friction")
    governor, name = scene.part, scene.part.mechanism.coordinate
    friction = DryFriction(reading="sleeve_lift", force=InputFunction(values=(30.0,), functions=(LinearFunction(reading=name, gain=5.0),)))
    effects = tuple(friction if isinstance(effect, DryFriction) else effect for effect in governor.effects)
    assert_engines_agree(scene.with_changes(effects=effects), 1e-9)


def test_a_geared_engine_without_torque_keeps_momentum_and_energy():
    run = gm.run(
        changed("watt_engine_hunting", {**GEAR, "part.engine.force": [], "part.governor.effects.dashpot": None}),
        engine="reduced",
        accuracy=1e-11,
    )
    speed = run.rates["engine.crank_angle"]
    momentum = (100.0 + 2**2 * (0.3 + 2 * 5.0 * (0.3 * np.sin(run.readings["governor.arm_angle"])) ** 2)) * speed
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-11)  # the requested accuracy
    assert run.energy.drift < 1e-10
    assert np.ptp(speed) > 1e-4


REFUSALS = {
    "breaks": {**GEAR, "coupling.belt.until": "1 s"},
    "with a lag": {"part.engine.force": [{**STEAM, "moment": [{**LIFT, "lag": "0.1 s"}]}]},
    "the effect Dashpot on 'engine.crank_angle'": {"part.engine.effects": {"dashpot": {"crank_angle": "1 N m s/rad"}}},
    "neither a torque, nor a torsion damper, nor gas": {"part.engine.force": [STEADY, SPRING]},
    "2 are more than a shaft": {
        "part.engine.body.1.at": ["0.1 m", 0],
        "part.engine.body.1.points": {"pin": ["-0.1 m", 0]},
        "part.engine.joint.1.second": "flywheel.pin",
    },
}
"""Changes of the scene watt_engine_hunting, by the words of the refusal."""


@pytest.mark.parametrize("reason", REFUSALS)
def test_what_it_cannot_model_is_refused_by_name(reason):
    scene = changed("watt_engine_hunting", REFUSALS[reason])
    with pytest.raises(gm.UnsupportedEffect, match=f"{reason}.*choose engine 'multibody'"):
        gm.run(scene, engine="reduced")
    assert select_engine("auto", scene)[0].name == "multibody"
