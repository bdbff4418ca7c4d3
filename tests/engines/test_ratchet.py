"""The shipped ratchet: its wheel goes on by as many whole teeth a stroke as fit into it, and never back."""

import math

import numpy as np
import pytest

import governor_mechanism as gm

PITCH = math.tau / 12


@pytest.mark.parametrize(("swing", "teeth"), [("12 deg", 0), ("20 deg", 1), ("35 deg", 2)])
def test_the_wheel_goes_on_by_the_whole_teeth_that_fit_into_a_stroke(swing, teeth):
    """A stroke is twice the swing; the rest of it is the free travel of the pawl behind the next tooth."""
    run = gm.run(gm.load("ratchet").replace({"dimensions.swing": swing}), certify=False, times=np.linspace(0.0, 2.0, 41))
    assert math.floor(2 * math.radians(float(swing.split()[0])) / PITCH) == teeth
    wheel = run.readings["wheel_angle"]
    assert np.diff(wheel[[20, 40]]) == pytest.approx([-teeth * PITCH], abs=0.002 * PITCH)
    backward = np.max(wheel - np.minimum.accumulate(wheel))
    assert backward < 0.1 * PITCH  # until the holding pawl stops it
    assert min(run.readings[name].min() for name in ("pawl_gap", "holding_pawl_gap")) > -1e-12


def test_the_shipped_ratchet_meets_its_accuracy():
    run = gm.run("ratchet", times=np.linspace(0.0, 1.0, 21))
    assert run.outcome is gm.Outcome.DONE
    assert run.error_estimate < 1e-5
    assert run.energy.drift < 1e-4
