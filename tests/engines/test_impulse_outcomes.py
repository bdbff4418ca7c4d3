"""Scenes that cannot be run are refused; runs that cannot continue end with a named outcome and keep their samples."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.engines import ImpulseEngine, select_engine
from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.errors import MechanismError, RunFailed, UnsupportedEffect
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import Damper
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, RackAndPinion
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.part import EQUILIBRIUM
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.hard_cases.case import slider_document
from governor_mechanism.verification.machines.comparisons import RelaxationSettings, relax_to_equilibrium
from governor_scenes import CROSSED, EXTENDED, PORTER, WATT, governor_scene
from one_coordinate_reference import integrate_one_coordinate


@dataclass(frozen=True, kw_only=True)
class Magnetism(Effect):
    """An effect that no engine has."""


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """A joint that no engine has."""


def porter(**options) -> Scene:
    return governor_scene(PORTER, **{"speed": 13.0, "angle": 0.7, **options})


def with_mechanism(scene: Scene, **changes) -> Scene:
    return scene.with_changes(mechanism=replace(scene.mechanism, **changes))


def test_an_effect_the_engine_lacks_is_refused_by_name():
    scene = porter().with_changes(effects=(Gravity(), Magnetism()))
    with pytest.raises(UnsupportedEffect, match=r"'impulse' cannot model \['Magnetism'\]"):
        ImpulseEngine().run(scene)


def test_a_joint_the_engine_lacks_is_refused_by_name():
    weld = Weld(name="weld", first=Point(body=GROUND), second=Point(body="sleeve"))
    scene = porter()
    scene = with_mechanism(scene, joints=(*scene.part.mechanism.joints, weld))
    with pytest.raises(UnsupportedEffect, match=r"\['Weld'\]"):
        ImpulseEngine().run(scene)


def test_a_rack_is_refused():
    scene = governor_scene(EXTENDED, speed=8.4, angle=0.6)
    rack = RackAndPinion(name="rack", first=Point(body="right ball"), second=Point(body="sleeve"), radius=0.1)
    scene = with_mechanism(scene, joints=(*scene.part.mechanism.joints[:-1], rack))
    with pytest.raises(UnsupportedEffect, match="Rack"):
        ImpulseEngine(step=1e-3).run(scene, certify=False)


def test_a_rotating_point_mass_without_a_pin_is_refused():
    mechanism = porter().part.mechanism
    bodies = (Body(name="right ball", mass=5.0), *mechanism.bodies[1:])
    with pytest.raises(UnsupportedEffect, match=r"cannot rotate point masses .* here right ball"):
        ImpulseEngine().run(with_mechanism(porter(), bodies=bodies))


def test_several_parts_are_refused():
    part = porter().part
    scene = Scene(title="test", parts=(replace(part, name="left"), replace(part, name="right")))
    with pytest.raises(UnsupportedEffect, match=r"scenes with one part .* the parts .'left', 'right'.: choose engine multibody"):
        ImpulseEngine().run(scene)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accuracy": 0.0}, "between 0 and 1"),
        ({"accuracy": math.nan}, "between 0 and 1"),
        ({"times": np.array([0.0, 1.0, 0.5])}, "strictly increasing"),
        ({"times": np.array([-1.0, 1.0])}, "start at 0"),
        ({"times": np.array([])}, "one-dimensional"),
        ({"times": np.array([0.0, math.nan])}, "finite"),
    ],
)
def test_invalid_run_options_are_refused(options, message):
    with pytest.raises(MechanismError, match=message):
        ImpulseEngine().run(porter(), **options)


def test_an_unknown_engine_is_refused_with_the_nearest_name():
    with pytest.raises(MechanismError, match="Did you mean 'impulse'"):
        select_engine("impuls", porter())


def test_too_many_reported_times_are_refused():
    with pytest.raises(MechanismError, match="reported times are too many"):
        make_reported_times(porter(duration=1e4, output_interval=1e-5))


def test_a_start_outside_the_travel_is_refused():
    with pytest.raises(MechanismError, match="outside the travel"):
        ImpulseEngine().run(porter(angle=1.7))


@pytest.mark.parametrize(
    ("dimensions", "speed", "message"),
    [({**PORTER, "offset": 0.0}, 5.0, r"at 47\.7465 rpm .* has no equilibrium"), (CROSSED, 14.0, "has no equilibrium in its travel")],
)
def test_a_start_in_an_equilibrium_that_does_not_exist_is_refused(dimensions, speed, message):
    with pytest.raises(MechanismError, match=message):
        ImpulseEngine().run(governor_scene(dimensions, speed=speed, angle=EQUILIBRIUM))


def test_a_start_in_equilibrium_stays_there():
    run = ImpulseEngine().run(porter(angle=EQUILIBRIUM))
    assert run.outcome is Outcome.DONE
    # 1e-11: the step causes no error at rest; the root of the equilibrium is found to 1e-15, the joints close to 1e-13.
    np.testing.assert_allclose(run.readings["arm_angle"], run.readings["arm_angle"][0], atol=1e-11)


def test_leaving_the_travel_ends_the_run_and_keeps_its_samples():
    # Crossed arms below their lowest speed fall until the balls meet.
    scene = governor_scene(CROSSED, speed=13.0, angle=0.6, duration=5.0)
    run = ImpulseEngine().run(scene)
    assert run.outcome is Outcome.LEFT_RANGE
    assert "the balls meet on the spindle axis" in run.message
    assert 0.1 < run.times[-1] < 5.0
    assert len(run.times) == len(run.readings["arm_angle"]) == len(run.poses)
    angles, _ = integrate_one_coordinate(scene, run.times)
    assert np.max(np.abs(run.readings["arm_angle"] - angles)) < 1e-6
    with pytest.raises(RunFailed, match="the balls meet"):
        run.raise_if_failed()


def test_an_excessive_speed_leaves_the_range():
    run = ImpulseEngine().run(governor_scene(PORTER, speed=1e5, angle=0.7, duration=10.0))
    assert run.outcome is Outcome.LEFT_RANGE
    assert "90 degrees" in run.message


def test_a_run_of_too_many_steps_ends_at_the_step_limit():
    run = ImpulseEngine(max_steps=1000).run(porter(duration=100.0, output_interval=0.1))
    assert run.outcome is Outcome.STEP_LIMIT
    assert 0 < run.times[-1] < 100.0
    assert "max_steps = 1000" in run.message


def test_joints_that_do_not_close_end_the_run():
    # Five iterations are too few for a sleeve lighter than the balls: its joints open within the run.
    scene = governor_scene({**PORTER, "sleeve_mass": 1.0}, speed=6.3, angle=0.9, rate=1.5)
    run = ImpulseEngine(iterations=5, max_iterations=5).run(scene, accuracy=1e-7)
    assert run.outcome is Outcome.JOINT_OPENED
    assert "5 solver iterations" in run.message


def test_an_accuracy_out_of_reach_is_not_claimed():
    run = ImpulseEngine(max_steps=20_000).run(porter(), accuracy=1e-15)
    assert run.outcome is Outcome.ACCURACY_MISSED
    assert run.error_estimate > 1e-15


def test_a_single_run_is_not_certified():
    run = ImpulseEngine(step=1e-3, plain=True).run(porter())
    assert run.outcome is Outcome.NOT_CERTIFIED
    assert run.error_estimate is None
    run.raise_if_failed()


def test_without_effects_no_force_acts():
    scene = governor_scene(WATT, speed=5.0, angle=0.5, rate=0.2, duration=1.0).with_changes(effects=())
    run = ImpulseEngine().run(scene)
    # An unloaded ball on a massless arm rotates at a constant rate.
    np.testing.assert_allclose(run.readings["arm_angle"], 0.5 + 0.2 * run.times, atol=1e-6)
    assert run.cost.evaluations == {}
    assert "spindle_torque" not in run.readings


def test_relaxation_fails_without_an_equilibrium_or_enough_steps():
    with pytest.raises(RunFailed, match="did not come to rest"):
        relax_to_equilibrium(governor_scene(CROSSED, speed=13.0, angle=0.6), 0.6)
    with pytest.raises(RunFailed, match="did not come to rest"):
        relax_to_equilibrium(porter(), 0.7, RelaxationSettings(max_steps=10))


def test_a_pin_does_not_depend_on_the_order_of_its_bodies():
    scene = governor_scene(EXTENDED, speed=8.4, angle=0.6, duration=0.5)
    swapped = tuple(
        Pin(name=joint.name, first=joint.second, second=joint.first) if isinstance(joint, Pin) else joint
        for joint in scene.part.mechanism.joints
    )
    one, other = ImpulseEngine().run(scene), ImpulseEngine().run(with_mechanism(scene, joints=swapped))
    np.testing.assert_allclose(one.poses, other.poses, atol=1e-13)


@pytest.mark.parametrize("step", [1e-300, 1e300])
def test_an_absurd_step_does_not_crash(step):
    run = ImpulseEngine(step=step, runs=1, max_steps=1000).run(porter())
    assert run.outcome in (Outcome.STEP_LIMIT, Outcome.NOT_CERTIFIED, Outcome.JOINT_OPENED, Outcome.LEFT_RANGE)


def test_a_very_long_run_is_truncated_before_it_fills_the_memory():
    run = ImpulseEngine(max_steps=10_000).run(porter(duration=1e9, output_interval=1e3))
    assert run.outcome is Outcome.STEP_LIMIT
    assert len(run.times) == 1


def test_a_damper_too_stiff_for_the_steps_ends_with_a_named_outcome():
    scene = porter()
    ground, ball = Point(body=GROUND, x=1.0), Point(body="right ball")
    damper = Damper(name="damper", first=ground, second=ball, damping=1e9)
    run = ImpulseEngine().run(with_mechanism(scene, force_elements=(damper,)), accuracy=1e-4)
    assert not run.outcome.ok
    assert all(np.all(np.isfinite(values)) for values in run.readings.values())


def test_steps_too_long_for_a_dashpot_are_no_flight():
    effects = {"spring": {"position": {"rate": 100.0}}, "dashpot": {"position": 2e5}}
    scene = parse_scene_document(slider_document(start=0.1, rate=1.0, duration=1.0, effects=effects))
    run = ImpulseEngine().run(scene)
    assert run.outcome is Outcome.JOINT_OPENED
    assert np.max(np.abs(run.poses)) < 1.0
