"""Kernels that numba compiles are compiled ahead for exactly the types of arguments with which runs call them."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import StepPlan
from governor_mechanism.engines.multibody.engine import MultibodyRunner
from governor_mechanism.engines.multibody.integration import integrate_multibody
from governor_mechanism.engines.reduced.integration import integrate_reduced, make_integration_arguments
from governor_mechanism.scenes.library import load_scene

compiled_by_numba = pytest.mark.skipif(
    integrate_reduced._library_code is not None, reason="the library has one set of types, and the tests of the library call it with them"
)


@compiled_by_numba
@pytest.mark.parametrize("model", ["porter", "porter_dry_friction", "slider_crank_torque", "air_engine"])
def test_reduced_calls_the_integration_that_is_compiled_ahead(model):
    scene = load_scene(model)
    ReducedEngine().run(scene, times=[0.0, 0.01], certify=False)
    kernel = integrate_reduced
    assert kernel.signature_of(make_integration_arguments(scene)) in kernel._dispatcher.signatures


@compiled_by_numba
@pytest.mark.parametrize("model", ["porter", "porter_dry_friction", "air_engine"])
def test_multibody_calls_the_integration_that_is_compiled_ahead(model):
    scene = load_scene(model)
    integrator = MultibodyRunner(
        MultibodyEngine(), scene, RunRequest(times=np.array([0.0, 0.01]), accuracy=1e-6, certify=False, reason="")
    ).integrator
    integrator.integrate(1e-7, StepPlan(max_steps=1000))
    kernel = integrate_multibody
    assert kernel.signature_of(integrator._make_integration_arguments()) in kernel._dispatcher.signatures


@pytest.mark.long
def test_only_a_stiff_scene_loads_the_implicit_integration():
    code = (
        "import governor_mechanism as gm\n"
        "from governor_mechanism.engines.multibody.implicit import integrate_implicitly\n"
        "for model in ('porter_dashpot', 'stiff_flyball'):\n"
        "    gm.run(model, engine='multibody', times=[0.0, 10.0], certify=False)\n"
        "    print(integrate_implicitly.is_loaded)\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.split() == ["False", "True"]
