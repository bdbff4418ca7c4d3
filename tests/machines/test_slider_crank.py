"""The slider crank as a mechanism: the table by kinematics, loads of the bearings, what may lack mass, refusals."""

import numpy as np
import pytest

import governor_mechanism as gm
from crank_scenes import SLIDER_CRANK_MASSES, crank_scene
from governor_mechanism.closed_form import slider_crank as closed
from governor_mechanism.effects.masses import CrankMasses
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.verification.machines.slider_crank import build_crank_train
from reference import marks
from refusing import refuses


def test_the_table_is_met_by_the_mechanism():
    rows = marks.SLIDER_CRANK_MOTION
    found = gm.kinematics(crank_scene(), over="crank_angle", values=np.radians([row[0] for row in rows]), rate=10.0)
    for name, sign, unit, columns, scale in (
        ("crosshead_distance", 1.0, 1.0, (1, 2, 3), 0.3),
        ("rod_angle", -1.0, np.pi / 180, (4, 5, 6), 1.0),  # counted anticlockwise; only the angle is printed in deg
    ):
        kinds = (found.readings, found.rates, found.reading_accelerations)
        for column, kind, factor, rate in zip(columns, kinds, (unit, 1.0, 1.0), (1.0, 10.0, 100.0), strict=True):
            printed = np.array([sign * row[column] * factor for row in rows])
            assert np.max(np.abs(kind[name] - printed)) < 1e-10 * scale * rate


@pytest.mark.parametrize("gravity", [True, False])
def test_the_bearings_carry_what_the_closed_form_says(gravity):
    scene = crank_scene({"crank_start": 0.7}, {"gravity": gravity, "masses": SLIDER_CRANK_MASSES}, accuracy=1e-10)
    run = MultibodyEngine().run(scene)
    assert run.outcome is Outcome.DONE
    angles = 0.7 + 10.0 * run.times
    exact = closed.bearing_loads(build_crank_train(scene), crank_angle=angles, crank_rate=10.0, gravity=scene.gravity)
    largest = float(np.hypot(*exact.main.T).max())
    found = run.reactions
    for name, force in {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}.items():
        assert np.max(np.abs(found[name].force - force)) < 1e-9 * largest
        assert found[name].determined.all()
    assert np.max(np.abs(found["crosshead guide"].force[:, 1] - exact.guide)) < 1e-9 * largest
    assert np.max(np.abs(found["drive"].moment - exact.torque)) < 1e-9 * largest * 0.3


@pytest.mark.parametrize(
    "more",
    [{}, {"crosshead": 110.0}, {"rod": 70.0}, {"rod": 70.0, "crosshead": 110.0}, {"rod": 0.01, "crosshead": 80.0}],
    ids=lambda more: " ".join(f"{name} {mass:g}" for name, mass in more.items()) or "crank alone",
)
@pytest.mark.parametrize("accuracy", [1e-6, 1e-10])
def test_rod_and_crosshead_may_lack_mass(more, accuracy):
    masses = {"crank": 80.0, "crank_centre": 0.1, **more}
    scene = crank_scene(effects={"gravity": True, "masses": masses}, accuracy=accuracy)
    run = MultibodyEngine().run(scene)
    assert run.outcome is Outcome.DONE
    exact = closed.bearing_loads(build_crank_train(scene), crank_angle=10.0 * run.times, crank_rate=10.0, gravity=9.81)
    largest = float(np.hypot(*exact.main.T).max())
    # a stand-in of a millionth of a kilogram weighs 1e-5 N and pulls as much as 4e-5 N
    room = 1e-9 * largest + 1e-4
    assert np.max(np.abs(run.reactions["shaft"].force - exact.main)) < room
    assert np.max(np.abs(run.reactions["drive"].moment - exact.torque)) < room
    expected = closed.crosshead_distance(build_crank_train(scene), crank_angle=10.0 * run.times)
    assert np.max(np.abs(run.readings["crosshead_distance"] - expected)) < accuracy * 0.3


def test_without_masses_impulse_follows_the_drive():
    run = ImpulseEngine().run(crank_scene())
    assert run.outcome is Outcome.DONE
    expected = closed.crosshead_distance(build_crank_train(run.scene), crank_angle=10.0 * run.times)
    assert np.max(np.abs(run.readings["crosshead_distance"] - expected)) < 1e-6 * 0.3


def test_the_slender_rod_is_what_is_left_out():
    slender, told = (
        crank_scene(effects={"masses": {"crank": 20.0, "rod": 12.0, **more}})
        for more in ({}, {"rod_centre": 0.75, "rod_inertia": 12.0 * 1.5**2 / 12})
    )
    assert slender.part.mechanism == told.part.mechanism


def test_negative_masses_are_refused_from_python_too():
    refuses(r"masses.crank must be positive", CrankMasses, crank=-1.0)
