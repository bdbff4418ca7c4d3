"""Scales of errors follow the motion, and an energy balance that drifts fails a certificate."""

from __future__ import annotations

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces import force_laws
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.observables import evaluation

SPINDLE_WITH_SPRUNG_WEIGHT = """
machine = "custom"
plane = "turning"
[ground]
A = [0, 0]
[[body]]
name = "weight"
mass = 1
at = [0.2, 0]
turns = false
[[joint]]
type = "slider"
first = "ground.A"
second = "weight.origin"
angle = 0
[[force]]
type = "spring"
first = "ground.A"
second = "weight.origin"
stiffness = {stiffness}
free_length = 0.2
[readings]
radius = {{ x = "weight.origin" }}
[effects]
gravity = false
centrifugal = true
[spindle]
inertia = 0.1
start_speed = 6.3
[run]
duration = "0.02 s"
output_interval = "1 ms"
accuracy = 1e-8
"""
"""A weight on a radial spring and a free spindle: the stiffer the spring, the less the weight moves."""


def run_with_stiffness(folder, stiffness: float):
    """Return the run of the sprung weight with a stiffness (N/m)."""
    path = folder / "scene.toml"
    path.write_text(SPINDLE_WITH_SPRUNG_WEIGHT.format(stiffness=stiffness))
    return gm.run(path, engine="multibody")


def test_the_stiffest_spring_does_not_set_the_scales_of_a_slow_motion(tmp_path):
    soft, stiff = (run_with_stiffness(tmp_path, stiffness) for stiffness in (1e2, 1e8))
    assert 1 / time_scale(stiff.scene) > 1e3 * stiff.scales["spindle_speed"]
    assert stiff.scales["spindle_speed"] == pytest.approx(6.3, rel=1e-9)
    assert soft.scales["spindle_speed"] == pytest.approx(6.3, rel=0.6)
    assert stiff.scales["rate of radius"] == pytest.approx(6.3 * stiff.scales["radius"], rel=1e-9)
    assert stiff.outcome is Outcome.DONE
    # The spring keeps the weight at its free length to m r omega^2 / k: the spindle turns uniformly.
    np.testing.assert_allclose(stiff.readings["spindle_speed"], 6.3, rtol=1e-5)


def test_every_error_has_a_scale(tmp_path):
    run = run_with_stiffness(tmp_path, 1e4)
    assert set(run.reading_errors) <= set(run.scales)
    largest = max(error / run.scales[name] for name, error in run.reading_errors.items())
    assert run.error_estimate == pytest.approx(max(largest, 1e-13))


@pytest.mark.long
@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_motion_and_energy_that_contradict_each_other_fail_the_certificate(engine, monkeypatch):
    honest = gm.run("porter", engine=engine, accuracy=1e-6)
    assert honest.outcome is Outcome.DONE
    # As if the equations of motion had a weight that is wrong by one per mille.
    monkeypatch.setattr(evaluation, "gravitational_energy", lambda *arguments: 1.001 * force_laws.gravitational_energy(*arguments))
    wrong = gm.run("porter", engine=engine, accuracy=1e-6)
    assert wrong.outcome is Outcome.ACCURACY_MISSED
    assert "the energy balance drifts" in wrong.message
    assert wrong.error_estimate > 1e-6
