"""Scales of errors follow the motion, and an energy balance that drifts fails a certificate."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.observables import run_result
from scene_documents import between, custom_document


def run_with_stiffness(stiffness: float):
    """Return the run of a weight on a radial spring of a stiffness (N/m) and a free spindle: the stiffer, the less the weight moves."""
    document = custom_document(
        plane="turning",
        body=[{"name": "weight", "mass": 1, "at": [0.2, 0], "turns": False}],
        joint=[between("slider", "ground.A", "weight.origin", angle=0)],
        force=[between("spring", "ground.A", "weight.origin", stiffness=stiffness, free_length=0.2)],
        readings={"radius": {"x": "weight.origin"}},
        effects={"gravity": False, "centrifugal": True},
        spindle={"inertia": 0.1, "start_speed": 6.3},
        run={"duration": "0.02 s", "output_interval": "1 ms", "accuracy": 1e-8},
    )
    return gm.run(gm.Scene.from_dict(document), engine="multibody")


def test_the_stiffest_spring_does_not_set_the_scales_of_a_slow_motion():
    soft, stiff = (run_with_stiffness(stiffness) for stiffness in (1e2, 1e8))
    assert 1 / time_scale(stiff.scene) > 1e3 * stiff.scales["spindle_speed"]
    assert stiff.scales["spindle_speed"] == pytest.approx(6.3, rel=1e-9)
    assert soft.scales["spindle_speed"] == pytest.approx(6.3, rel=0.6)
    assert stiff.scales["rate of radius"] == pytest.approx(6.3 * stiff.scales["radius"], rel=1e-9)
    assert stiff.outcome is gm.Outcome.DONE
    # The spring keeps the weight at its free length to m r omega^2 / k: the spindle turns uniformly.
    np.testing.assert_allclose(stiff.readings["spindle_speed"], 6.3, rtol=1e-5)


def test_every_error_has_a_scale():
    run = run_with_stiffness(1e4)
    assert set(run.reading_errors) <= set(run.scales)
    largest = max(error / run.scales[name] for name, error in run.reading_errors.items())
    assert run.error_estimate == pytest.approx(max(largest, 1e-13))


@pytest.mark.long
@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_motion_and_energy_that_contradict_each_other_fail_the_certificate(engine, monkeypatch):
    honest = gm.run("porter", engine=engine, accuracy=1e-6)
    assert honest.outcome is gm.Outcome.DONE
    # As if the equations of motion had a weight that is wrong by one per mille.
    monkeypatch.setattr(run_result, "gravitational_energy", lambda *arguments: 1.001 * force_laws.gravitational_energy(*arguments))
    wrong = gm.run(honest.scene.with_changes(title="without what is kept with the scene"), engine=engine, accuracy=1e-6)
    assert wrong.outcome is gm.Outcome.ACCURACY_MISSED
    assert "the energy balance drifts" in wrong.message
    assert wrong.error_estimate > 1e-6


@pytest.mark.parametrize(("name", "engine"), [("jansen", "multibody"), ("pendulum_iftomm", "reduced")])
def test_no_reading_is_claimed_to_be_more_accurate_than_rounding(name, engine):
    """A prescribed angle is the same in both runs of a certificate, and still has the rounding error of its arithmetic."""
    run = gm.run(name, engine, accuracy=1e-9, times=[0.0, 0.1, 0.2])
    errors = {reading: run.reading_errors[reading] / run.scales[reading] for reading in run.readings}
    assert min(errors.values()) > 100 * np.finfo(float).eps
