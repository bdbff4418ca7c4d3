"""What sticks, strikes, brakes and goes slack in engines multibody and reduced, against closed answers and laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import lambertw

import governor_mechanism as gm
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.lowering import make_system, with_held_values
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.scene import FIXED_PLANE, FreeSpindle, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.model.trajectory import Outcome
from governor_scenes import PORTER, governor_scene
from reference.zehnder import FRICTION_BAND

ENGINES = pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=lambda engine: engine.name)
G = 9.81
LIFT = "sleeve_lift"


def constant(value):
    return InputFunction(values=(value,))


def with_effects(scene, *effects):
    return replace(scene, effects=(*scene.effects, *effects))


def porter(speed, *effects, angle=30.0, duration=10.0, output_interval=0.01):
    scene = governor_scene(PORTER, speed=speed, angle=math.radians(angle), duration=duration, output_interval=output_interval)
    return with_effects(scene, *effects)


def block(*effects, start=0.0, rate=0.0, duration=10.0, mass=2.0, upright=False):
    """A mass on a straight slide, level or upright, with the reading 'way'."""
    angle = math.pi / 2 if upright else 0.0
    mechanism = Mechanism(
        bodies=(Body(name="block", mass=mass, can_rotate=False),),
        joints=(Slider(name="slide", first=Point(body=GROUND), second=Point(body="block"), angle=angle),),
        readings=(
            PointCoordinate(
                name="way", quantity="length", point=Point(body="block"), direction_x=math.cos(angle), direction_y=math.sin(angle)
            ),
        ),
        coordinate="way",
        length_scale=1.0,
        initial_guess=((0.0, 0.0, 0.0),),
    )
    return Scene(
        title="block",
        parts=(Part(name="block", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE),),
        effects=effects,
        spindle=Spindle(),
        start=Start(values={"way": start}, rates={"way": rate}),
        run=RunSettings(duration=duration, output_interval=duration / 200, accuracy=1e-9),
    )


def run(engine, scene, accuracy=1e-10, **options):
    result = engine.run(scene, accuracy=accuracy, **options)
    assert result.outcome.ok, result.message
    return result


@ENGINES
@pytest.mark.parametrize(("towards", "name"), [(13.3, "rising_speed"), (11.0, "falling_speed")])
def test_the_sleeve_first_moves_at_the_ends_of_the_standing_band(engine, towards, name):
    scene = porter(
        Spindle(times=(0.0, 10.0), speeds=(12.2, towards)), DryFriction(reading=LIFT, force=constant(FRICTION_BAND["resistance"]))
    )
    result = run(engine, scene)
    first = result.events[0]
    assert (first.kind, first.subject) == ("slips", LIFT)
    speed = 12.2 + (towards - 12.2) * first.time / 10.0
    assert speed == pytest.approx(FRICTION_BAND[name], abs=1e-8)  # asked
    before = result.times < first.time
    assert np.ptp(result.readings[LIFT][before]) == 0.0


@ENGINES
def test_what_sticks_does_not_creep(engine):
    scene = porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)), duration=1000.0, output_interval=10.0)
    result = run(engine, scene, accuracy=1e-6)
    assert np.ptp(result.readings[LIFT]) == 0.0
    assert result.events == ()
    assert result.energy.dissipated_energy[-1] == 0.0


@ENGINES
def test_an_oscillator_with_friction_loses_the_same_at_every_swing_and_stops(engine):
    """Each half swing is a cosine about +-W / k; it ends where the spring can no longer overcome the friction."""
    k, mass, hold, start = 50.0, 2.0, 3.0, 0.5
    scene = block(OutputSpring(reading="way", rate=k), DryFriction(reading="way", force=constant(hold)), start=start)
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    swings, place = 0, start
    while k * abs(place) > hold:
        place, swings = -math.copysign(abs(place) - 2 * hold / k, place), swings + 1
    (stuck,) = result.events
    assert stuck.kind == "sticks"
    assert stuck.time == pytest.approx(swings * half, abs=1e-9)  # asked
    assert result.readings["way"][-1] == pytest.approx(place, abs=1e-11)
    spent = 0.5 * k * (start**2 - place**2)
    assert result.energy.dissipated_energy[-1] == pytest.approx(spent, rel=1e-10)
    way = sum(2 * (start - (2 * n + 1) * hold / k) for n in range(swings))
    assert result.energy.dissipated_energy[-1] == pytest.approx(hold * way, rel=1e-8)  # work of W, asked


@ENGINES
def test_friction_that_is_relieved_lets_go_at_once_and_holds_again_after_half_a_swing(engine):
    k, mass, start = 50.0, 2.0, 0.1
    times, forces = (0.0, 1.0, 1.0, 3.0, 3.0, 4.0), (10.0, 10.0, 2.0, 2.0, 0.5, 0.5)
    scene = block(
        OutputSpring(reading="way", rate=k),
        DryFriction(reading="way", force=InputFunction(times=times, values=forces)),
        start=start,
        duration=5.0,
    )
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    # 5 N of the spring are held by 10 N, not by 2; it swings to -(0.1 - 2 * 2 / 50) = -0.02, where 1 N is held by 2 N,
    # but not by 0.5 N: to 0.02 - 2 * 0.5 / 50 = 0.
    expected = [("slips", 1.0), ("sticks", 1.0 + half), ("slips", 3.0), ("sticks", 3.0 + half)]
    assert [event.kind for event in result.events] == [kind for kind, _ in expected]
    np.testing.assert_allclose([event.time for event in result.events], [time for _, time in expected], atol=1e-9)
    assert result.readings["way"][-1] == pytest.approx(0.0, abs=1e-11)


@ENGINES
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.5, 0.9])
def test_a_bouncing_body_comes_to_rest_when_it_should(engine, restitution):
    """Thrown up from its stop at v it bounces with v, e v, e^2 v...: it rests after (2 v / g) / (1 - e)."""
    speed, mass = 2.0, 2.0
    rest = 2 * speed / G / (1 - restitution)
    scene = block(Gravity(), Stops(reading="way", low=0.0, restitution=restitution), rate=speed, duration=1.1 * rest, upright=True)
    result = run(engine, scene)
    strikes = [event.time for event in result.events if event.kind == "strikes its stop"]
    expected = 2 * speed / G * np.cumsum(restitution ** np.arange(len(strikes)))
    np.testing.assert_allclose(strikes, expected, atol=1e-9)
    assert result.events[-1].kind == "rests on its stop"
    assert result.events[-1].time == pytest.approx(rest, abs=1e-9)  # asked
    assert len(result.events) < 200  # bounded: the bounces end where they are below rounding
    assert result.readings["way"].min() > -1e-12  # asked
    assert result.readings["way"][-1] == pytest.approx(0.0, abs=1e-13)
    assert result.energy.dissipated_energy[-1] == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    assert result.energy.drift < 1e-12


def rest_of_rubbed_bounces(speed, restitution, slowing):
    """When what is thrown up at a speed rests, friction slowing it by so much: up under g + f, down under g - f, and
    each bounce shorter than the last by one ratio; and when it strikes.
    """
    up, down = G + slowing, G - slowing
    ratio = restitution * math.sqrt(down / up)
    first = speed * (1 / up + 1 / math.sqrt(up * down))
    return first / (1 - ratio), lambda count: first * (1 - ratio ** np.arange(1, count + 1)) / (1 - ratio)


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
@pytest.mark.parametrize(
    ("engine", "within"), [(MultibodyEngine(), 1e-9), (ReducedEngine(), 1e-9), (ImpulseEngine(), 1e-6)],
    ids=lambda value: getattr(value, "name", ""),
)  # fmt: skip
def test_a_bouncing_body_that_is_rubbed_rests_when_it_should(engine, within, share, restitution):
    """At the top of a bounce friction does not hold it, however low that is; the bounces left have another ratio."""
    speed, mass = 2.0, 2.0
    rest, strikes_at = rest_of_rubbed_bounces(speed, restitution, share * G)
    rub = DryFriction(reading="way", force=constant(share * G * mass))
    stop = Stops(reading="way", low=0.0, restitution=restitution)
    scene = block(Gravity(), rub, stop, rate=speed, duration=1.1 * rest, upright=True)
    result = gm.run(scene, engine, accuracy=within)
    assert result.outcome is Outcome.DONE
    strikes = [event.time for event in result.events if event.kind == "strikes its stop"]
    np.testing.assert_allclose(strikes, strikes_at(len(strikes)), atol=within)
    assert [event.kind for event in result.events if "stop" not in event.kind] == []
    assert result.events[-1].kind == "rests on its stop"
    assert result.events[-1].time == pytest.approx(rest, abs=within)
    assert result.readings["way"][-1] == pytest.approx(0.0, abs=1e-12)


@ENGINES
def test_an_elastic_stop_loses_nothing(engine):
    scene = block(Gravity(), Stops(reading="way", low=0.0, restitution=1.0), start=0.3, upright=True, duration=5.0)
    result = run(engine, scene)
    period = 2 * math.sqrt(2 * 0.3 / G)
    strikes = [event.time for event in result.events]
    np.testing.assert_allclose(strikes, period * (np.arange(len(strikes)) + 0.5), atol=1e-9)
    assert len(strikes) == int(5.0 / period + 0.5)
    assert result.energy.dissipated_energy[-1] == pytest.approx(0.0, abs=1e-11)


@ENGINES
def test_stops_with_friction_hold_either_way(engine):
    """Pressed on its stop, a block leaves it only when it is drawn off harder than the friction holds."""
    ramp = InputFunction(times=(0.0, 10.0), values=(-20.0, 20.0))
    scene = block(DryFriction(reading="way", force=constant(4.0)), Stops(reading="way", low=0.0), duration=10.0, mass=2.0)
    body = Point(body="block")
    from governor_mechanism.model.force_elements import Force

    part = scene.part
    pull = Force(name="pull", point=body, x=ramp, y=constant(0.0))
    scene = replace(scene, parts=(replace(part, mechanism=replace(part.mechanism, force_elements=(pull,))),))
    result = run(engine, scene)
    (left,) = result.events
    assert left.kind == "leaves its stop"
    assert left.time == pytest.approx(6.0, abs=1e-9)  # -20 + 4 t = 4


@ENGINES
def test_a_one_sided_spring_pulls_only_where_it_is_stretched(engine):
    """A half oscillation on the spring, then flight at constant speed."""
    k, mass, speed = 50.0, 2.0, 1.0
    scene = block(OutputSpring(reading="way", rate=k, one_sided=True), start=0.0, rate=speed, duration=3.0)
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    (slack,) = result.events
    assert (slack.kind, slack.time) == ("goes slack", pytest.approx(half, abs=1e-9))
    after = result.times > half
    np.testing.assert_allclose(result.readings["way"][after], -speed * (result.times[after] - half), atol=1e-10)
    assert result.readings["way"].max() == pytest.approx(speed * math.sqrt(mass / k), rel=1e-3)


@ENGINES
@settings(max_examples=10, deadline=None)
@given(linear=st.floats(0.1, 5.0), speed=st.floats(0.1, 3.0))
def test_a_linear_brake_stops_a_body_after_a_finite_way(engine, linear, speed):
    result = run(engine, block(Dashpot(reading="way", linear=linear), rate=speed, duration=4.0))
    expected = speed * 2.0 / linear * -np.expm1(-linear / 2.0 * result.times)
    np.testing.assert_allclose(result.readings["way"], expected, atol=1e-9 * max(1.0, speed))
    lost = 0.5 * 2.0 * (speed**2 - result.rates["way"] ** 2)
    np.testing.assert_allclose(result.energy.dissipated_energy, lost, atol=1e-9 * max(1.0, speed**2))


@ENGINES
def test_a_quadratic_brake_lets_the_way_grow_as_a_logarithm(engine):
    quadratic, speed, mass = 3.0, 2.0, 2.0
    result = run(engine, block(Dashpot(reading="way", quadratic=quadratic), rate=speed, duration=4.0))
    expected = mass / quadratic * np.log1p(quadratic * speed / mass * result.times)
    np.testing.assert_allclose(result.readings["way"], expected, atol=1e-10)


@ENGINES
def test_both_kinds_of_brake_together(engine):
    """m v' = -(c + b v) v: v = c / ((c / v0 + b) exp(c t / m) - b)."""
    c, b, speed, mass = 1.5, 2.0, 2.0, 2.0
    result = run(engine, block(Dashpot(reading="way", linear=c, quadratic=b), rate=speed, duration=4.0))
    expected = c / ((c / speed + b) * np.exp(c * result.times / mass) - b)
    np.testing.assert_allclose(result.rates["way"], expected, atol=1e-10)
    # Thrown up under gravity with a linear brake it is back after the time that Lambert's function tells.
    brakes = Dashpot(reading="way", linear=c), Stops(reading="way", low=-1.0, high=9.0)
    up = run(engine, block(Gravity(), *brakes, rate=speed, upright=True, duration=0.7, mass=mass))
    a, fall = c / mass, mass * G / c
    back = float(np.real(lambertw(-(1 + speed / fall) * math.exp(-(1 + speed / fall))) / a + (1 + speed / fall) / a))
    place = np.interp(back, up.times, up.readings["way"])
    assert place == pytest.approx(0.0, abs=1e-4)  # between reported times by straight lines


@ENGINES
def test_a_brake_lets_a_small_swing_decay_as_the_closed_form_says(engine):
    """A linear brake adds c (ds/dq)^2 q' to the equation of a small swing: it decays at half of that over I."""
    rest = gm.equilibria(porter(12.2085))[0]
    along = 2 * PORTER["arm"] * math.sin(rest.coordinate)  # ds/dq of the rhombus
    inertia = rest.stiffness / rest.frequency**2
    damping = 15.0
    decay = damping * along**2 / (2 * inertia)
    swing = math.sqrt(rest.frequency**2 - decay**2)
    small = 1e-4
    brake = Dashpot(reading=LIFT, linear=damping)

    def released(offset):
        scene = governor_scene(PORTER, speed=12.2085, angle=rest.coordinate + offset, duration=3.0)
        return run(engine, with_effects(scene, brake), accuracy=1e-12)

    out, back = released(small), released(-small)
    # Half the difference of both swings has no part of second order; what is left is of the order of small^3 = 1e-12.
    off = 0.5 * (out.readings["arm_angle"] - back.readings["arm_angle"])
    t = out.times
    expected = small * np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t))
    np.testing.assert_allclose(off, expected, atol=1e-6 * small)  # asked


MEAN = 0.5 * (FRICTION_BAND["falling_speed"] + FRICTION_BAND["rising_speed"])
BAND = (FRICTION_BAND["rising_speed"] - FRICTION_BAND["falling_speed"]) / MEAN


@ENGINES
@pytest.mark.parametrize(("share", "moves"), [(0.5, False), (1 - 1e-4, False), (1 + 1e-4, True), (1.2, True)])
def test_the_sleeve_twitches_once_the_unevenness_exceeds_the_band(engine, share, moves):
    turns = 10 * 2 * math.pi / MEAN
    spindle = Spindle(speeds=(MEAN,), speed_fluctuation=share * BAND)
    result = run(engine, porter(spindle, DryFriction(reading=LIFT, force=constant(40.0)), duration=turns), accuracy=1e-9)
    moved = np.ptp(result.readings[LIFT])
    assert (moved > 0.0) == moves
    assert bool(result.events) == moves


@ENGINES
def test_about_the_speed_of_rest_itself_the_band_is_not_symmetric(engine):
    """There the sleeve moves at 0.959 of the insensitivity, as the nearer end of the band is met."""
    rest = FRICTION_BAND["equilibrium_speed"]
    nearer = 2 * min(rest - FRICTION_BAND["falling_speed"], FRICTION_BAND["rising_speed"] - rest) / rest
    assert nearer / FRICTION_BAND["insensitivity_exact"] == pytest.approx(0.959, abs=5e-4)
    for share, moves in ((1 - 1e-3, False), (1 + 1e-3, True)):
        spindle = Spindle(speeds=(rest,), speed_fluctuation=share * nearer)
        result = run(engine, porter(spindle, DryFriction(reading=LIFT, force=constant(40.0)), duration=5.0), accuracy=1e-9)
        assert (np.ptp(result.readings[LIFT]) > 0.0) == moves


@ENGINES
def test_an_uneven_spindle_swings_as_it_is_told(engine):
    scene = porter(
        Spindle(times=(0.0, 4.0), speeds=(12.0, 13.0), speed_fluctuation=0.1, cycles_per_turn=3.0), duration=5.0, output_interval=1e-3
    )
    result = run(engine, scene)
    t = result.times
    mean, turned = np.minimum(12.0 + t / 4, 13.0), np.where(t < 4, 12 * t + t**2 / 8, 50.0 + 13 * (t - 4))
    expected = mean * (1 + 0.05 * np.sin(3 * turned))
    np.testing.assert_allclose(result.readings["spindle_speed"], expected, rtol=1e-13)
    assert result.energy.drift < 1e-9
    # The drive's torque is the rate of the angular momentum: by differences of it, order 2 in the interval.
    momentum = 2 * result.energy.rotation / result.readings["spindle_speed"]
    rate = (momentum[2:] - momentum[:-2]) / (t[2:] - t[:-2])
    smooth = np.abs(t[1:-1] - 4.0) > 0.002
    torque = result.readings["spindle_torque"][1:-1]
    scale = np.max(np.abs(torque))
    # Of a wave of 40 rad/s differences 1 ms apart miss (0.04)^2 / 6 = 3e-4.
    np.testing.assert_allclose(rate[smooth], torque[smooth], atol=1e-3 * scale)


ALL = (
    DryFriction(reading=LIFT, force=InputFunction(times=(0.0, 2.0, 2.0, 4.0), values=(40.0, 40.0, 5.0, 30.0))),
    Dashpot(reading="arm_angle", linear=0.5, quadratic=0.3),
    OutputSpring(reading=LIFT, rate=200.0, zero=0.1, one_sided=True),
    Stops(reading="arm_angle", low=0.5, high=0.8, restitution=0.5),
)


@ENGINES
@pytest.mark.parametrize(
    "spindle",
    [
        Spindle(times=(0.0, 5.0), speeds=(12.0, 13.5), speed_fluctuation=0.2, cycles_per_turn=2.0),
        FreeSpindle(inertia=0.5, start_speed=12.0, torque=InputFunction(times=(0.0, 3.0, 3.0), values=(0.5, 0.5, -0.8))),
    ],
    ids=["uneven", "free"],
)
def test_the_ledger_closes_with_every_effect_on(engine, spindle):
    scene = replace(porter(12.0, *ALL, angle=35.0, duration=8.0), spindle=spindle)
    result = run(engine, scene)
    assert result.energy.drift < 1e-9  # asked
    assert result.energy.dissipated_energy[-1] > 0.1
    assert np.all(np.diff(result.energy.dissipated_energy) >= -1e-12)
    assert len(result.events) > 3
    # Forces in the joints are told in every mode, also where something sticks.
    assert all(np.all(np.isfinite(reaction.force)) for reaction in result.reactions.values())


@ENGINES
def test_a_stuck_governor_is_carried_by_its_friction(engine):
    """At rest gravity, links and friction balance on the sleeve; away from the equilibrium speed friction makes up."""
    speed = 12.9
    result = run(engine, porter(speed, DryFriction(reading=LIFT, force=constant(40.0)), duration=0.1), accuracy=1e-9)
    links = [result.reactions[f"{side} link"].force[-1] for side in ("right", "left")]
    pull = sum(float(force[1]) for force in links)  # on the sleeve, upward
    mass, arm, offset = PORTER["sleeve_mass"], PORTER["arm"], PORTER["offset"]
    angle = math.radians(30.0)
    lift = PORTER["ball_mass"] * (speed**2 * (offset + arm * math.sin(angle)) / math.tan(angle) - G)
    # What the balls' centrifugal force lifts, less the sleeve's weight, friction has to hold down.
    assert pull == pytest.approx(lift, rel=1e-9)
    assert 0 < lift - mass * G < 40.0


@ENGINES
def test_event_times_are_promised_and_samples_beside_them_left_out(engine):
    scene = block(Gravity(), Stops(reading="way", low=0.0, restitution=0.5), rate=2.0, duration=1.0, upright=True)
    strike = 2 * 2.0 / G
    times = [0.1, strike - 1e-12, strike, strike + 1e-12, 0.5]
    result = run(engine, scene, accuracy=1e-8, times=times)
    assert result.n_excluded == 3
    assert result.reading_errors["event times"] < 1e-9
    assert result.error_estimate < 1e-8


@ENGINES
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_loose_runs_are_as_accurate_as_they_say(engine, seed):
    """Random scenes with effects: the true error, by a run a thousand times tighter, is at most three estimates."""
    random = np.random.default_rng(seed)
    effects = [
        DryFriction(reading=LIFT, force=constant(random.uniform(1.0, 30.0))),
        Dashpot(reading=LIFT, linear=random.uniform(1.0, 50.0)),
        Stops(reading="arm_angle", low=0.45, high=0.62, restitution=random.uniform(0.0, 0.9)),
        OutputSpring(reading=LIFT, rate=random.uniform(50.0, 500.0), one_sided=True, zero=random.uniform(0.0, 0.1)),
    ]
    chosen = [effect for effect in effects if random.random() < 0.5]
    spindle = Spindle(speeds=(random.uniform(11.5, 13.0),), speed_fluctuation=random.uniform(0.0, 0.2))
    scene = porter(spindle, *chosen, duration=3.0)
    loose, tight = engine.run(scene, accuracy=1e-5), engine.run(scene, accuracy=1e-9)
    if not (loose.outcome is tight.outcome is Outcome.DONE):
        return
    times = np.array([event.time for event in tight.events] or [-1.0])
    near = np.min(np.abs(loose.times[:, np.newaxis] - times), axis=1) < 1e-5
    for name, values in loose.readings.items():
        error = np.max(np.abs(values - tight.readings[name])[~near])
        assert error <= 3 * loose.error_estimate * loose.scales[name] + 1e-12


@ENGINES
def test_nothing_is_assembled_that_is_not_listed(engine):
    bare = run(engine, porter(12.2, duration=0.1), accuracy=1e-8)
    assert set(bare.cost.model_size) == {"bodies", "joint equations"}
    # A reduced engine has what does not change in time in its pieces, springs that pull both ways among it.
    laid = engine.name == "reduced"
    always = {"equations of motion", "pieces laid"} if laid else {"equations of motion", "gravity", "centrifugal"}
    assert set(bare.cost.evaluations) == always
    for effect, part, law in (
        (DryFriction(reading=LIFT, force=constant(1.0)), "frictions", "dry friction"),
        (Dashpot(reading=LIFT, linear=1.0), "springs and brakes along readings", "dashpots"),
        (OutputSpring(reading=LIFT, rate=1.0), "springs and brakes along readings", None if laid else "springs on readings"),
        (OutputSpring(reading=LIFT, rate=1.0, one_sided=True), "springs and brakes along readings", "springs on readings"),
        (Stops(reading=LIFT, low=-1.0), "stops", None),
    ):
        result = run(engine, porter(12.2, effect, duration=0.1), accuracy=1e-8)
        assert set(result.cost.model_size) - set(bare.cost.model_size) == {part, "readings acted along"}
        assert result.cost.model_size[part] == result.cost.model_size["readings acted along"] == 1
        assert set(result.cost.evaluations) - set(bare.cost.evaluations) == ({law} if law else set())
    stuck = run(engine, porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)), duration=0.1), accuracy=1e-8)
    assert stuck.cost.evaluations["dry friction"] == 0  # what sticks is held, and rubs on nothing
    without = run(engine, replace(porter(12.2, duration=0.1), effects=(Gravity(),)), accuracy=1e-8)
    assert "centrifugal" not in without.cost.evaluations
    assert Centrifugal not in {type(effect) for effect in without.scene.effects}


def test_holding_at_other_values_leaves_no_rounding_behind():
    """A hold that is moved a thousand times is the hold that is made at the last value."""
    scene = porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)))
    system = make_system(scene, ContactMode(held_values=(0.1,), sliding_signs=(0,)))[0]
    values = np.random.default_rng(1).uniform(0.0, 0.2, 1000)
    for value in values:
        mode = ContactMode(held_values=(float(value),), sliding_signs=(0,))
        system = with_held_values(system, [0], mode)
    np.testing.assert_array_equal(system.constraint_rows.table, make_system(scene, mode)[0].constraint_rows.table)


@ENGINES
def test_a_start_beyond_the_stops_is_refused(engine):
    with pytest.raises(gm.MechanismError, match=r"beyond the stops of 'arm_angle', 34\.3775 deg to 45\.8366 deg"):
        engine.run(porter(12.2, Stops(reading="arm_angle", low=0.6, high=0.8)))
