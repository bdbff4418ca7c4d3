"""Impulse engine with springs, dashpots, friction and stops along readings: order, accuracy, stiction, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Clearance, DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.engines.impulse.richardson import extrapolate_events
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.events import Event
from governor_mechanism.model.joints import Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.observables.error_scales import EVENT_TIMES
from governor_scenes import PORTER, governor_scene, random_governor
from random_scenes import draw_scene, draw_study_scene
from scene_parts import body_angle, body_point, ground_point, make_mechanism, point_mass, scene_of, x_reading

SPRING = OutputSpring(reading="sleeve_lift", rate=800.0, preload=20.0, zero=0.1)
ARM_SPRING = OutputSpring(reading="arm_angle", rate=20.0, zero=0.6)
SLACK = OutputSpring(reading="sleeve_lift", rate=800.0, zero=0.12, one_sided=True)
BRAKE = Dashpot(reading="sleeve_lift", linear=60.0, quadratic=300.0)
ARM_BRAKE = Dashpot(reading="arm_angle", linear=2.0, quadratic=4.0)
STOPS = Stops(reading="arm_angle", low=0.5, high=0.75, restitution=0.5)


def dry_friction(force: float | InputFunction, reading: str = "sleeve_lift") -> DryFriction:
    return DryFriction(reading=reading, force=force if isinstance(force, InputFunction) else InputFunction(values=(force,)))


def porter(*effects, **options) -> Scene:
    scene = governor_scene(PORTER, **{"speed": 12.0, "angle": 0.7, "rate": 0.3, "duration": 1.0, **options})
    return scene.with_changes(effects=(*scene.effects, *effects))


def slider(*effects, rate: float = 1.0, duration: float = 1.0) -> Scene:
    """A block of 2 kg on a level guide."""
    guide = Slider(name="guide", first=ground_point(), second=body_point("block"), angle=0.0)
    reading = x_reading("block", "displacement")
    mechanism = make_mechanism([point_mass("block", 2.0)], [guide], [reading], [(0.0, 0.0, 0.0)], size=0.2)
    state = {"values": {"displacement": 0.0}, "rates": {"displacement": rate}}
    return scene_of(mechanism, *effects, **state, duration=duration, output_interval=0.01)


def wheel(*effects, rate: float = 5.0) -> Scene:
    """A disc on a fixed pin through its centre."""
    disc = Body(name="disc", mass=1.0, second_moments=SecondMoments(xx=0.01, yy=0.01, zz=0.02))
    axle = Pin(name="axle", first=ground_point(), second=body_point("disc"))
    mechanism = make_mechanism([disc], [axle], [body_angle("disc", "rotation")], [(0.0, 0.0, 0.0)], size=0.1)
    return scene_of(mechanism, *effects, values={"rotation": 0.0}, rates={"rotation": rate}, output_interval=0.01)


def errors_of(run, true) -> float:
    """Return the largest error of readings and rates in units of their scales, away from events."""
    assert len(run.times) == len(true.times)
    time_scale = 1 / 12.0
    is_far = np.ones(len(run.times), dtype=np.bool_)
    for event in true.events:
        is_far &= np.abs(run.times - event.time) > run.settings["asked_accuracy"] * time_scale
    readings = [np.max(np.abs(run.readings[k] - true.readings[k])[is_far]) / run.scales[k] for k in run.readings]
    rates = [np.max(np.abs(run.rates[k] - true.rates[k])[is_far]) / run.scales[k] * time_scale for k in run.rates]
    return float(max(readings + rates))


def error_ratios(scene, name: str, steps=(2e-3, 1e-3, 5e-4)):
    """Return the ratios of the errors of a reading at successive steps."""
    true = gm.run(scene, engine="multibody", accuracy=1e-11)
    errors = []
    for step in steps:
        run = ImpulseEngine(step=step, runs=1).run(scene, certify=False)
        errors.append(np.max(np.abs(run.readings[name] - true.readings[name])))
    return np.array(errors[:-1]) / errors[1:]


@pytest.mark.long
@pytest.mark.parametrize(
    "scene",
    [
        porter(SPRING),
        porter(ARM_SPRING),
        porter(BRAKE),
        porter(ARM_BRAKE),
        porter(dry_friction(10.0)),
        porter(dry_friction(2.0, "arm_angle"), BRAKE),
        porter(dry_friction(10.0), duration=1.5),
        porter(STOPS),
        porter(SLACK),
        porter(dry_friction(6.0), SPRING, BRAKE, replace(STOPS, low=0.55, high=0.72), duration=0.5),
    ],
    ids=lambda scene: "+".join(f"{type(effect).__name__} on {effect.reading}" for effect in scene.output_effects),
)
def test_two_engines_agree_within_the_accuracy(scene):
    true = gm.run(scene, engine="multibody", accuracy=1e-10)
    run = ImpulseEngine().run(scene, accuracy=1e-6)
    assert run.outcome is gm.Outcome.DONE
    assert errors_of(run, true) < 1e-6  # the requested accuracy
    # The number of final bounces depends on the smallest bounce that an engine still follows.
    assert len(run.events) == len(true.events) or len(true.events) > 10
    for event, expected in list(zip(run.events, true.events, strict=False))[:8]:
        assert (event.kind, event.subject) == (expected.kind, expected.subject)
        assert event.time == pytest.approx(expected.time, abs=1e-6 / 12)  # requested accuracy times the time scale
    assert run.energy.drift < 1e-5  # not a reading, but of the same order
    assert run.energy.dissipated_energy[-1] == pytest.approx(true.energy.dissipated_energy[-1], abs=1e-6 * run.energy.scale)


@pytest.mark.parametrize(
    "scene",
    [porter(SPRING), porter(ARM_SPRING), porter(BRAKE), porter(ARM_BRAKE), porter(dry_friction(10.0)), porter(SLACK)],
    ids=lambda scene: "+".join(f"{type(effect).__name__} on {effect.reading}" for effect in scene.output_effects),
)
def test_the_order_is_two(scene):
    ratios = error_ratios(scene, "arm_angle")
    assert np.all((ratios > 3.7) & (ratios < 4.3)), ratios  # 4 plus higher-order terms


def test_a_fluctuating_spindle_speed_keeps_order_two():
    scene = porter().with_changes(spindle=Spindle(speeds=(12.0,), speed_fluctuation=0.05, cycles_per_turn=2.0))
    ratios = error_ratios(scene, "arm_angle")
    assert np.all((ratios > 3.7) & (ratios < 4.3)), ratios  # 4 plus higher-order terms


def test_the_order_is_two_after_impacts():
    ratios = error_ratios(porter(STOPS, duration=2.0), "arm_angle", steps=(4e-3, 1e-3, 2.5e-4))
    assert np.all(ratios > 10.0), ratios  # 16, scattered by the position of the impact within a step


def test_a_sticking_contact_does_not_creep():
    scene = porter(dry_friction(40.0), angle=math.radians(30.0), rate=0.0, duration=20.0, output_interval=1.0)
    run = ImpulseEngine(step=0.02, runs=1).run(scene, certify=False)
    assert run.readings["sleeve_lift"][-1] == pytest.approx(run.readings["sleeve_lift"][0], abs=2e-13)  # rounding
    assert run.energy.dissipated_energy[-1] < 2e-11


def test_a_block_slides_to_rest_where_its_energy_ends():
    run = ImpulseEngine().run(slider(dry_friction(4.0, "displacement")), accuracy=1e-8)
    assert run.outcome is gm.Outcome.DONE
    assert run.readings["displacement"][-1] == pytest.approx(0.25, abs=1e-9)  # m v^2 / (2 W)
    assert run.events[0].time == pytest.approx(0.5, abs=1e-9)  # m v / W
    assert run.energy.dissipated_energy[-1] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.long
def test_a_spring_and_friction_stop_the_block_after_the_analytical_half_swings():
    # From 0.2 m each half swing loses 2 W / k and changes side: -0.14, 0.08, -0.02, where 2 N do not overcome friction.
    spring = OutputSpring(reading="displacement", rate=100.0)
    scene = slider(spring, dry_friction(3.0, "displacement"), rate=0.0, duration=2.0)
    scene = scene.with_changes(start=Start(values={"displacement": 0.2}, rates={"displacement": 0.0}))
    run = ImpulseEngine().run(scene, accuracy=1e-7)
    assert run.outcome is gm.Outcome.DONE
    half = math.pi / math.sqrt(100.0 / 2.0)
    turning_values = np.interp([half, 2 * half], run.times, run.readings["displacement"])
    np.testing.assert_allclose(turning_values, [-0.14, 0.08], atol=2e-4)  # interpolation at the turning point
    assert run.readings["displacement"][-1] == pytest.approx(-0.02, abs=1e-7 * 0.2)  # the requested accuracy
    assert run.events[0].time == pytest.approx(3 * half, abs=1e-7)
    assert run.energy.drift < 1e-6


@pytest.mark.long
def test_a_block_on_a_spring_sticks_and_slips_with_the_friction_limit():
    spring = OutputSpring(reading="displacement", rate=100.0)
    relieved = InputFunction(times=(0.0, 0.8, 0.8, 1.0, 1.0), values=(6.0, 6.0, 0.5, 0.5, 6.0))
    scene = slider(spring, dry_friction(relieved, "displacement"), duration=2.0).with_changes(start=Start(values={"displacement": 0.05}))
    true = gm.run(scene, engine="multibody", accuracy=1e-10)
    run = ImpulseEngine().run(scene, accuracy=1e-6)
    assert run.outcome is gm.Outcome.DONE
    assert [event.kind for event in run.events] == [event.kind for event in true.events]
    assert np.max(np.abs(run.readings["displacement"] - true.readings["displacement"])) < 1e-6 * 0.2


def test_friction_on_a_rotating_body_brings_it_to_rest():
    run = ImpulseEngine().run(wheel(dry_friction(0.1, "rotation")), accuracy=1e-8)
    assert run.readings["rotation"][-1] == pytest.approx(0.02 * 25.0 / (2 * 0.1), abs=1e-7)  # I w^2 / (2 M)


@pytest.mark.long
def test_a_rotating_body_bounces_between_its_stops():
    run = ImpulseEngine().run(wheel(Stops(reading="rotation", low=-0.5, high=0.5, restitution=0.8)), accuracy=1e-8)
    times = [event.time for event in run.events]
    assert times[:3] == pytest.approx([0.1, 0.1 + 1 / 4.0, 0.1 + 1 / 4.0 + 1 / 3.2], abs=1e-9)


@pytest.mark.long
def test_a_governor_comes_to_rest_on_its_stop_and_leaves_it():
    stops = Stops(reading="sleeve_lift", low=0.06, high=0.12, restitution=0.2)
    ramp = Spindle(times=(0.0, 2.0), speeds=(11.0, 15.0))
    scene = porter(stops, speed=ramp, angle=math.acos(0.9) + 0.01, rate=0.0)
    true = gm.run(scene, engine="multibody", accuracy=1e-9)
    run = ImpulseEngine().run(scene, accuracy=1e-5)
    assert run.outcome is gm.Outcome.DONE
    assert errors_of(run, true) < 1e-5
    resting = [event.kind for event in run.events if event.kind != "strikes its stop"]
    assert resting[:2] == ["rests on its stop", "leaves its stop"]
    leaves = next(event.time for event in run.events if event.kind == "leaves its stop")
    speed = math.sqrt(9.81 * 5 * math.tan(math.acos(0.9)) / (0.04 + 0.3 * math.sin(math.acos(0.9))))
    assert 11.0 + 2.0 * leaves == pytest.approx(speed, abs=1e-5)


@pytest.mark.long
def test_the_estimate_of_random_governors_with_friction_holds():
    random = np.random.default_rng(5)
    is_honest = []
    while len(is_honest) < 8:
        dimensions, angle = random_governor(random)
        masses = dimensions["ball_mass"], dimensions.get("sleeve_mass", 0.0)
        speed = math.sqrt(9.81 * (1 + masses[1] / masses[0]) / (dimensions["arm"] * math.cos(angle)))
        force = 9.81 * (2 * masses[0] + masses[1]) * 10 ** random.uniform(-2.0, -0.7)
        scene = governor_scene(dimensions, speed=speed, angle=angle, rate=random.uniform(-0.5, 0.5), duration=1.0)
        scene = scene.with_changes(effects=(*scene.effects, dry_friction(force)))
        true = gm.run(scene, engine="multibody", accuracy=1e-9)
        run = ImpulseEngine().run(scene, accuracy=1e-5)
        if true.outcome is not gm.Outcome.DONE or run.outcome is not gm.Outcome.DONE:
            continue
        is_honest.append(errors_of(run, true) <= 3 * run.error_estimate)
    assert sum(is_honest) >= 7


@pytest.mark.long
def test_a_slip_with_a_small_excess_force_is_followed():
    # At its turning point the force exceeds the friction limit by one per cent: a regression held the contact again in every step.
    dimensions = {
        "arm": 0.26374590507860535,
        "offset": -0.010060218847206717,
        "ball_mass": 2.281281676381682,
        "sleeve_mass": 0.8632778426833488,
        "arm_joint": 0.20194352468659163,
        "link": 0.19515912317138856,
    }
    scene = governor_scene(dimensions, speed=8.121696165553649, angle=0.7889368542836547, rate=0.43834128686461393)
    scene = scene.with_changes(effects=(*scene.effects, dry_friction(0.35568296660805304, "arm_angle")))
    true = gm.run(scene, engine="multibody", accuracy=1e-8)
    run = ImpulseEngine().run(scene, accuracy=1e-5)
    assert run.outcome is gm.Outcome.DONE
    assert errors_of(run, true) < 3 * run.error_estimate


def test_only_the_force_laws_of_the_scene_are_counted():
    run = ImpulseEngine(step=1e-3).run(porter(SPRING, BRAKE, dry_friction(10.0), duration=0.2))
    assert run.cost.evaluations["springs on readings"] == run.cost.steps
    assert run.cost.evaluations["dashpots"] == run.cost.steps
    assert run.cost.evaluations["dry friction"] == run.cost.steps
    assert run.cost.method
    bare = ImpulseEngine(step=1e-3).run(porter(duration=0.2))
    assert bare.cost.evaluations.keys() == {"gravity", "centrifugal"}
    assert np.all(bare.energy.dissipated_energy == 0.0)


def test_clearance_is_refused_by_name():
    clearance = Clearance(width=1e-3)
    machine = MACHINES["pendulum_governor"](**PORTER)
    scene = porter().with_changes(mechanism=machine.mechanism_with_effects([clearance]), effects=(Gravity(), clearance))
    with pytest.raises(gm.UnsupportedEffect, match=r"'impulse' cannot model \['Clearance'\]"):
        ImpulseEngine().run(scene)


def test_friction_on_a_line_between_two_bodies_is_refused():
    line = LineAngle(name="link", quantity="angle", start=Point(body="right ball"), end=Point(body="sleeve"))
    scene = porter()
    mechanism = replace(scene.mechanism, readings=(*scene.mechanism.readings, line))
    scene = scene.with_changes(mechanism=mechanism, effects=(*scene.effects, dry_friction(1.0, "link")))
    with pytest.raises(gm.UnsupportedEffect, match=r"cannot model dry friction on 'link'.*engine 'multibody'"):
        ImpulseEngine().run(scene)


def test_the_plain_scheme_has_no_friction():
    with pytest.raises(gm.UnsupportedEffect, match="leave plain=True out"):
        ImpulseEngine(step=1e-3, plain=True).run(porter(dry_friction(10.0)))


def test_a_time_between_the_last_impact_and_the_extrapolated_one_is_on_the_wrong_side():
    """Runs with impacts at 1 - h^2 extrapolate to 1; the last run is past its impact just before that time."""
    event_logs = [[Event(time=1 - h**2, kind="strikes its stop", subject="displacement")] for h in (0.04, 0.02, 0.01)]
    extrapolated = extrapolate_events(event_logs, 2.0, first_step=0.0)
    assert extrapolated.events[0].time == pytest.approx(1.0, abs=1e-12)
    assert extrapolated.wrong_side_error(np.array([0.9998, 1.1])) == 0.0
    assert extrapolated.wrong_side_error(np.array([0.9998, 0.99995, 1.1])) == pytest.approx(1e-4)


def test_runs_that_reach_an_event_by_the_same_first_step_do_not_confirm_it():
    event_logs = [[Event(time=0.5, kind="strikes its stop", subject="displacement")]] * 3
    assert extrapolate_events(event_logs, 2.0, first_step=1.0).time_error == pytest.approx(0.005)
    assert extrapolate_events(event_logs, 2.0, first_step=0.4).time_error == 0.0  # reached by steps of different length


def test_an_impact_within_the_first_step_is_within_its_estimate():
    """A crank that starts 1e-4 rad before its stop: the runs of every level reach it by one step of the same length."""
    scene = draw_study_scene("four-bar", 5, 20261124).scene
    (expected,) = [event.time for event in gm.run(scene, "reduced", accuracy=1e-11).events if event.kind == "strikes its stop"]
    run = ImpulseEngine(max_steps=20_000).run(scene, accuracy=1e-2)
    (found,) = [event.time for event in run.events if event.kind == "strikes its stop"]
    assert 1e-6 < abs(found - expected) <= run.reading_errors[EVENT_TIMES]


def test_a_driven_reversal_is_not_reported_as_stick():
    """A crosshead driven by a crank is stationary only for an instant."""
    scene = gm.load("slider_crank")
    with_friction = scene.with_changes(effects=(*scene.effects, dry_friction(20.0, "crosshead_distance")))
    assert gm.run(with_friction, "multibody", accuracy=1e-6).events == ()
    assert gm.run(with_friction, "impulse", accuracy=1e-4).events == ()


def test_the_slip_time_of_a_held_rod_converges_with_order_two():
    """The lower of two rods is held by friction while the upper one continues to swing."""
    scene = draw_scene(167, 20261124).scene
    times = [event.time for event in gm.run(scene, "multibody", accuracy=1e-10).events if event.kind == "slips"]
    errors = []
    for step in (5e-3, 2.5e-3, 6.25e-4):
        run = ImpulseEngine(step=step, runs=1).run(scene, certify=False)
        slips = [event.time for event in run.events if event.kind == "slips"]
        assert len(slips) == len(times) == 1
        errors.append(abs(slips[0] - times[0]))
    assert errors[0] / errors[-1] > 4**2.5  # three halvings of order two give 64; the first steps are coarse
    assert errors[-1] < 1e-6


@pytest.mark.long
def test_friction_elsewhere_reverses_with_a_bounce():
    """One degree of freedom: friction of the arms shortens the bounces of the sleeve as friction on the sleeve would."""
    scene = porter(dry_friction(12.0, "arm_angle"), Stops(reading="sleeve_lift", low=0.08, restitution=0.6), speed=10.0, rate=0.0)
    true, run = gm.run(scene, "multibody", accuracy=1e-10), ImpulseEngine().run(scene, accuracy=1e-5)
    rests = [[event.time for event in one.events if event.kind == "rests on its stop"] for one in (true, run)]
    assert len(rests[0]) == len(rests[1]) == 1
    assert rests[1] == pytest.approx(rests[0], abs=1e-8)  # the remaining bounces last some microseconds


@pytest.mark.long
def test_a_sample_just_before_an_impact_is_on_the_right_side():
    """It lies some microseconds before an impact that all three runs have already passed."""
    drawn = draw_scene(62, 7)
    run = ImpulseEngine().run(drawn.scene, accuracy=5.7e-5)
    true = gm.run(drawn.scene, "multibody", accuracy=1e-10)
    assert run.outcome is gm.Outcome.DONE
    for name, rates in true.rates.items():
        assert np.max(np.abs(run.rates[name] - rates)) < 1e-4  # the lever rebounds at 0.5 rad/s


@pytest.mark.long
@pytest.mark.parametrize(
    ("machine", "number", "kind", "accuracy"),
    [
        # Up to the end of a step the gap of the joints hides that the spring has gone slack.
        ("slide valve", 26, "goes slack", 1e-5),
        # The force that holds the arms grows slowly: a force that has not converged releases them 0.6 ms early, at every step size.
        ("crossed arms", 18, "slips", 3e-3),
        # With the longest steps the governor never sticks for the 6 ms that it does.
        ("crossed arms", 25, "slips", 3e-3),
    ],
)
def test_what_all_step_sizes_could_get_wrong_alike_is_within_the_estimate(machine, number, kind, accuracy):
    scene = draw_study_scene(machine, number, 20261124).scene
    true, run = gm.run(scene, "multibody", accuracy=1e-10), ImpulseEngine().run(scene, accuracy=accuracy)
    times, true_times = ([event.time for event in one.events if event.kind == kind] for one in (run, true))
    assert run.outcome is gm.Outcome.DONE
    assert len(times) == len(true_times) > 0
    assert np.max(np.abs(np.subtract(times, true_times))) <= run.reading_errors[EVENT_TIMES]
    assert run.reading_errors[EVENT_TIMES] < 3e-3 * scene.run.duration
