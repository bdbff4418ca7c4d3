"""Free spindle: reference values, conserved quantities, a torque against time, and refused scenes."""

from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.model.part import FIXED_PLANE, FreeSpindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.time_functions import InputFunction
from governor_scenes import PORTER, porter_open
from reference import zehnder

REFERENCE, SPINDLE_INERTIA = zehnder.PORTER_OPEN_MOTION, zehnder.PORTER_OPEN["rest_inertia"]


def free_porter(torque=None, **options):
    scene = porter_open(**options)
    spindle = FreeSpindle(inertia=SPINDLE_INERTIA, start_speed=REFERENCE["spindle_speed"])
    return scene.with_changes(spindle=spindle if torque is None else replace(spindle, torque=torque))


def turning_inertia(run):
    return SPINDLE_INERTIA + 2 * PORTER["ball_mass"] * run.readings["ball_radius"] ** 2


@pytest.mark.parametrize(("engine", "accuracy", "allowed"), [("multibody", 1e-10, 1e-9), ("reduced", 1e-10, 1e-9), ("impulse", 1e-8, 1e-6)])
def test_runs_match_the_reference(engine, accuracy, allowed):
    run = gm.run(free_porter(), engine=engine, accuracy=accuracy)
    assert run.outcome is Outcome.DONE
    expected = REFERENCE["free_spindle"]
    found = {"arm_angle": run.readings["arm_angle"], "arm_rate": run.rates["arm_angle"], "turned": run.readings["spindle_angle"]}
    for name, values in {**found, "spindle_speed": run.readings["spindle_speed"]}.items():
        # The accuracy of rates, speeds and turns is relative to the spindle speed of 12 rad/s.
        assert values[-1] == pytest.approx(expected[name], abs=allowed * (1 if name == "arm_angle" else 12)), name


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_momentum_and_energy_are_conserved(engine):
    run = gm.run(free_porter(), engine=engine, accuracy=1e-11)
    momentum = turning_inertia(run) * run.readings["spindle_speed"]
    np.testing.assert_allclose(momentum, REFERENCE["angular_momentum"], rtol=1e-11)  # the requested accuracy
    assert run.energy.drift < 1e-10


@pytest.mark.parametrize(("engine", "accuracy", "allowed"), [("multibody", 1e-8, 1e-8), ("reduced", 1e-8, 1e-8), ("impulse", 1e-7, 1e-6)])
def test_a_torque_in_time_changes_the_momentum_by_its_integral(engine, accuracy, allowed):
    torque = InputFunction(times=(0.0, 0.5, 0.5, 1.5), values=(2.0, 2.0, -3.0, 1.0))
    run = gm.run(free_porter(torque), engine=engine, accuracy=accuracy)
    assert run.outcome is Outcome.DONE
    momentum = turning_inertia(run) * run.readings["spindle_speed"]
    t = run.times
    ramp = np.clip(t - 0.5, 0.0, 1.0)
    impulse = 2.0 * np.minimum(t, 0.5) - 3.0 * ramp + 2.0 * ramp**2 + np.maximum(t - 1.5, 0.0)
    # The allowed relative error, times the scale of 12 rad/s and 1.2 kg m2.
    np.testing.assert_allclose(momentum - momentum[0], impulse, atol=20 * allowed)
    assert run.energy.drift < 10 * allowed


@pytest.mark.long
def test_impulse_engine_is_of_second_order_with_a_free_spindle():
    scene = free_porter(duration=1.0)
    reference = gm.run(scene, engine="multibody", accuracy=1e-11)
    for name in ("arm_angle", "spindle_speed", "spindle_angle"):
        errors = []
        for step in (2e-3, 1e-3, 5e-4):
            run = ImpulseEngine(step=step, runs=1).run(scene, certify=False)
            errors.append(np.max(np.abs(run.readings[name] - reference.readings[name])))
        ratios = np.array(errors[:-1]) / errors[1:]
        assert np.all((ratios > 3.8) & (ratios < 4.2)), (name, ratios)  # 4, except for higher-order terms


def test_a_free_spindle_requires_a_turning_plane():
    with pytest.raises(gm.MechanismError, match="is in a fixed plane"):
        free_porter().with_changes(plane=FIXED_PLANE)


def test_a_free_spindle_requires_the_centrifugal_effect():
    scene = free_porter()
    with pytest.raises(gm.MechanismError, match=r"list effects\.centrifugal"):
        scene.with_changes(effects=scene.effects[:1])
