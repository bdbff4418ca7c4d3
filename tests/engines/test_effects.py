"""Friction, stops, dashpots and one-sided springs in the engines multibody and reduced, against closed forms and balances."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import lambertw

import governor_mechanism as gm
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.impulse import level_runs
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.lowering import make_system, with_held_values
from governor_mechanism.model.force_elements import Force
from governor_mechanism.model.joints import Point, Slider
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction, LinearFunction
from governor_scenes import PORTER, governor_scene
from reference import zehnder
from scene_parts import body_point, constant, ground_point, make_mechanism, point_mass, scene_of


def engine_name(value):
    """Return the name of an engine as the name of a case."""
    return getattr(value, "name", None)


ENGINES = pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=engine_name)
G = 9.81
LIFT = "sleeve_lift"


def with_effects(scene, *effects):
    return scene.with_changes(effects=(*scene.effects, *effects))


def porter(speed, *effects, angle=30.0, duration=10.0, output_interval=0.01):
    scene = governor_scene(PORTER, speed=speed, angle=math.radians(angle), duration=duration, output_interval=output_interval)
    return with_effects(scene, *effects)


def block(*effects, start=0.0, rate=0.0, duration=10.0, mass=2.0, upright=False):
    """Return a mass on a straight slide, horizontal or vertical, with the reading 'displacement'."""
    angle = math.pi / 2 if upright else 0.0
    direction = {"direction_x": math.cos(angle), "direction_y": math.sin(angle)}
    slide = Slider(name="slide", first=ground_point(), second=body_point("block"), angle=angle)
    reading = PointCoordinate(name="displacement", quantity="length", point=body_point("block"), **direction)
    mechanism = make_mechanism([point_mass("block", mass)], [slide], [reading], [(0.0, 0.0, 0.0)])
    state = {"values": {"displacement": start}, "rates": {"displacement": rate}}
    return scene_of(mechanism, *effects, **state, duration=duration, output_interval=duration / 200, accuracy=1e-9)


def run(engine, scene, accuracy=1e-10, **options):
    result = engine.run(scene, accuracy=accuracy, **options)
    assert result.outcome.ok, result.message
    return result


@pytest.mark.parametrize(
    ("engine", "within"), [(MultibodyEngine(), 1e-8), (ReducedEngine(), 1e-8), (ImpulseEngine(step=1e-3, runs=1), 1e-6)], ids=engine_name
)
@pytest.mark.parametrize(("towards", "name"), [(14.2, "rising_speed"), (10.2, "falling_speed")])
def test_sleeve_starts_to_move_at_the_ends_of_the_insensitivity_band(engine, within, towards, name):
    scene = porter(
        Spindle(times=(0.0, 1.0), speeds=(12.2, towards)),
        DryFriction(reading=LIFT, force=constant(zehnder.FRICTION_BAND["resistance"])),
        duration=1.0,
    )
    result = run(engine, scene, certify=engine.name != "impulse")
    first = next(event for event in result.events if event.kind == "slips")
    assert first.subject == LIFT
    assert 12.2 + (towards - 12.2) * first.time == pytest.approx(zehnder.FRICTION_BAND[name], abs=within)  # requirement
    lift = result.readings[LIFT]
    assert np.ptp(lift[result.times < first.time]) <= (1e-13 if engine.name == "impulse" else 0.0)  # rounding
    assert (towards - 12.2) * (lift[-1] - lift[0]) > 0.0


@ENGINES
def test_sticking_contact_does_not_creep(engine):
    scene = porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)), duration=200.0, output_interval=10.0)
    result = run(engine, scene, accuracy=1e-6)
    assert np.ptp(result.readings[LIFT]) == 0.0
    assert result.events == ()
    assert result.energy.dissipated_energy[-1] == 0.0


@ENGINES
def test_friction_oscillator_loses_a_constant_amplitude_and_stops(engine):
    """Every half oscillation is a cosine about +-W / k; the last one ends where the spring force is below the friction force."""
    k, mass, hold, start = 50.0, 2.0, 3.0, 0.5
    scene = block(OutputSpring(reading="displacement", rate=k), DryFriction(reading="displacement", force=constant(hold)), start=start)
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    swings, place = 0, start
    while k * abs(place) > hold:
        place, swings = -math.copysign(abs(place) - 2 * hold / k, place), swings + 1
    (stuck,) = result.events
    assert stuck.kind == "sticks"
    assert stuck.time == pytest.approx(swings * half, abs=1e-9)  # requirement
    assert result.readings["displacement"][-1] == pytest.approx(place, abs=1e-11)
    spent = 0.5 * k * (start**2 - place**2)
    assert result.energy.dissipated_energy[-1] == pytest.approx(spent, rel=1e-10)
    way = sum(2 * (start - (2 * n + 1) * hold / k) for n in range(swings))
    assert result.energy.dissipated_energy[-1] == pytest.approx(hold * way, rel=1e-8)  # work of W, requirement


@ENGINES
def test_reduced_friction_releases_at_once_and_sticks_after_half_an_oscillation(engine):
    k, mass, start = 50.0, 2.0, 0.1
    times, forces = (0.0, 1.0, 1.0, 3.0, 3.0, 4.0), (10.0, 10.0, 2.0, 2.0, 0.5, 0.5)
    scene = block(
        OutputSpring(reading="displacement", rate=k),
        DryFriction(reading="displacement", force=InputFunction(times=times, values=forces)),
        start=start,
        duration=5.0,
    )
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    # 10 N of friction hold 5 N of the spring, 2 N do not. It moves to -(0.1 - 2 * 2 / 50) = -0.02, where 2 N hold 1 N,
    # but 0.5 N do not: to 0.02 - 2 * 0.5 / 50 = 0.
    expected = [("slips", 1.0), ("sticks", 1.0 + half), ("slips", 3.0), ("sticks", 3.0 + half)]
    assert [event.kind for event in result.events] == [kind for kind, _ in expected]
    np.testing.assert_allclose([event.time for event in result.events], [time for _, time in expected], atol=1e-9)
    assert result.readings["displacement"][-1] == pytest.approx(0.0, abs=1e-11)


@ENGINES
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.5, 0.9])
def test_bouncing_body_comes_to_rest_at_the_predicted_time(engine, restitution):
    """Bounces start with rates v, e v, e^2 v, ...; the sum of their times is (2 v / g) / (1 - e)."""
    speed, mass = 2.0, 2.0
    rest = 2 * speed / G / (1 - restitution)
    scene = block(Gravity(), Stops(reading="displacement", low=0.0, restitution=restitution), rate=speed, duration=1.1 * rest, upright=True)
    result = run(engine, scene)
    strikes = [event.time for event in result.events if event.kind == "strikes its stop"]
    expected = 2 * speed / G * np.cumsum(restitution ** np.arange(len(strikes)))
    np.testing.assert_allclose(strikes, expected, atol=1e-9)
    assert result.events[-1].kind == "rests on its stop"
    assert result.events[-1].time == pytest.approx(rest, abs=1e-9)  # requirement
    assert len(result.events) < 200  # the bounces end where they are below rounding
    assert result.readings["displacement"].min() > -1e-12  # requirement
    assert result.readings["displacement"][-1] == pytest.approx(0.0, abs=1e-13)
    assert result.energy.dissipated_energy[-1] == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    assert result.energy.drift < 1e-12


def bouncing_time_with_friction(speed, restitution, slowing):
    """When what is thrown up at a speed rests, friction slowing it by so much: up under g + f, down under g - f, and
    each bounce shorter than the last by one ratio; and when it strikes.
    """
    up, down = G + slowing, G - slowing
    ratio = restitution * math.sqrt(down / up)
    first = speed * (1 / up + 1 / math.sqrt(up * down))
    return first / (1 - ratio), lambda count: first * (1 - ratio ** np.arange(1, count + 1)) / (1 - ratio)


FEW_AND_MANY_BOUNCES = [(share, restitution) for share in (0.1, 0.5, 0.95) for restitution in (0.3, 0.6, 0.9)]


@pytest.mark.parametrize(
    ("engine", "within", "share", "restitution"),
    [
        *((engine, 1e-9, *case) for engine in (MultibodyEngine(), ReducedEngine()) for case in FEW_AND_MANY_BOUNCES),
        *((ImpulseEngine(), 1e-6, *case) for case in FEW_AND_MANY_BOUNCES[::4]),
        pytest.param(ImpulseEngine(), 1e-6, 0.1, 0.9, marks=pytest.mark.long),  # here more iterations would be tried
    ],
    ids=engine_name,
)
def test_bouncing_body_with_friction_comes_to_rest_at_the_predicted_time(engine, within, share, restitution, monkeypatch):
    """Friction does not hold the body at the top of a bounce, and it changes the ratio of successive bounces.

    Shorter steps, not more iterations of the joint solver, resolve many bounces in a step.
    """
    tried, integrate = set(), level_runs.integrate_over_grid
    monkeypatch.setattr(level_runs, "integrate_over_grid", lambda *arguments: tried.add(arguments[2]) or integrate(*arguments))
    speed, mass = 2.0, 2.0
    rest, strikes_at = bouncing_time_with_friction(speed, restitution, share * G)
    rub = DryFriction(reading="displacement", force=constant(share * G * mass))
    stop = Stops(reading="displacement", low=0.0, restitution=restitution)
    scene = block(Gravity(), rub, stop, rate=speed, duration=1.1 * rest, upright=True)
    result = gm.run(scene, engine, accuracy=within)
    assert result.outcome is gm.Outcome.DONE
    assert tried == ({engine.iterations} if isinstance(engine, ImpulseEngine) else set())
    strikes = [event.time for event in result.events if event.kind == "strikes its stop"]
    np.testing.assert_allclose(strikes, strikes_at(len(strikes)), atol=within)
    assert [event.kind for event in result.events if "stop" not in event.kind] == []
    assert result.events[-1].kind == "rests on its stop"
    assert result.events[-1].time == pytest.approx(rest, abs=within)
    assert result.readings["displacement"][-1] == pytest.approx(0.0, abs=1e-12)


@ENGINES
def test_elastic_stop_dissipates_no_energy(engine):
    scene = block(Gravity(), Stops(reading="displacement", low=0.0, restitution=1.0), start=0.3, upright=True, duration=5.0)
    result = run(engine, scene)
    period = 2 * math.sqrt(2 * 0.3 / G)
    strikes = [event.time for event in result.events]
    np.testing.assert_allclose(strikes, period * (np.arange(len(strikes)) + 0.5), atol=1e-9)
    assert len(strikes) == int(5.0 / period + 0.5)
    assert result.energy.dissipated_energy[-1] == pytest.approx(0.0, abs=1e-11)


@ENGINES
def test_stop_with_friction_holds_in_both_directions(engine):
    """A block on its stop leaves it only when the force away from it exceeds the friction force."""
    ramp = InputFunction(times=(0.0, 10.0), values=(-20.0, 20.0))
    scene = block(DryFriction(reading="displacement", force=constant(4.0)), Stops(reading="displacement", low=0.0), duration=10.0, mass=2.0)
    pull = Force(name="pull", point=Point(body="block"), x=ramp, y=constant(0.0))
    scene = scene.with_changes(mechanism=replace(scene.mechanism, force_elements=(pull,)))
    result = run(engine, scene)
    (left,) = result.events
    assert left.kind == "leaves its stop"
    assert left.time == pytest.approx(6.0, abs=1e-9)  # -20 + 4 t = 4


@ENGINES
def test_one_sided_spring_pulls_only_when_stretched(engine):
    """Half an oscillation on the spring, then motion at constant speed."""
    k, mass, speed = 50.0, 2.0, 1.0
    scene = block(OutputSpring(reading="displacement", rate=k, one_sided=True), start=0.0, rate=speed, duration=3.0)
    result = run(engine, scene)
    half = math.pi * math.sqrt(mass / k)
    (slack,) = result.events
    assert (slack.kind, slack.time) == ("goes slack", pytest.approx(half, abs=1e-9))
    after = result.times > half
    np.testing.assert_allclose(result.readings["displacement"][after], -speed * (result.times[after] - half), atol=1e-10)
    assert result.readings["displacement"].max() == pytest.approx(speed * math.sqrt(mass / k), rel=1e-3)


@ENGINES
@settings(max_examples=10)
@given(linear=st.floats(0.1, 5.0), speed=st.floats(0.1, 3.0))
def test_linear_dashpot_stops_a_body_after_a_finite_distance(engine, linear, speed):
    result = run(engine, block(Dashpot(reading="displacement", linear=linear), rate=speed, duration=4.0))
    expected = speed * 2.0 / linear * -np.expm1(-linear / 2.0 * result.times)
    np.testing.assert_allclose(result.readings["displacement"], expected, atol=1e-9 * max(1.0, speed))
    lost = 0.5 * 2.0 * (speed**2 - result.rates["displacement"] ** 2)
    np.testing.assert_allclose(result.energy.dissipated_energy, lost, atol=1e-9 * max(1.0, speed**2))


@ENGINES
def test_distance_grows_logarithmically_with_a_quadratic_dashpot(engine):
    quadratic, speed, mass = 3.0, 2.0, 2.0
    result = run(engine, block(Dashpot(reading="displacement", quadratic=quadratic), rate=speed, duration=4.0))
    expected = mass / quadratic * np.log1p(quadratic * speed / mass * result.times)
    np.testing.assert_allclose(result.readings["displacement"], expected, atol=1e-10)


@ENGINES
def test_linear_and_quadratic_dashpot_together(engine):
    """m v' = -(c + b v) v: v = c / ((c / v0 + b) exp(c t / m) - b)."""
    c, b, speed, mass = 1.5, 2.0, 2.0, 2.0
    result = run(engine, block(Dashpot(reading="displacement", linear=c, quadratic=b), rate=speed, duration=4.0))
    expected = c / ((c / speed + b) * np.exp(c * result.times / mass) - b)
    np.testing.assert_allclose(result.rates["displacement"], expected, atol=1e-10)
    # The flight time under gravity with a linear dashpot follows from Lambert's W function.
    brakes = Dashpot(reading="displacement", linear=c), Stops(reading="displacement", low=-1.0, high=9.0)
    up = run(engine, block(Gravity(), *brakes, rate=speed, upright=True, duration=0.7, mass=mass))
    a, fall = c / mass, mass * G / c
    back = float(np.real(lambertw(-(1 + speed / fall) * math.exp(-(1 + speed / fall))) / a + (1 + speed / fall) / a))
    place = np.interp(back, up.times, up.readings["displacement"])
    assert place == pytest.approx(0.0, abs=1e-4)  # linear interpolation between reported times


@ENGINES
def test_small_oscillation_with_a_dashpot_decays_as_the_closed_form(engine):
    """A linear dashpot adds c (ds/dq)^2 q' to the linearised equation: the decay rate is c (ds/dq)^2 / (2 I)."""
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
    # Half the difference of both oscillations has no second-order term; the remainder is of order small^3 = 1e-12.
    off = 0.5 * (out.readings["arm_angle"] - back.readings["arm_angle"])
    t = out.times
    expected = small * np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t))
    np.testing.assert_allclose(off, expected, atol=1e-6 * small)  # requirement


MEAN = 0.5 * (zehnder.FRICTION_BAND["falling_speed"] + zehnder.FRICTION_BAND["rising_speed"])
BAND = (zehnder.FRICTION_BAND["rising_speed"] - zehnder.FRICTION_BAND["falling_speed"]) / MEAN


@ENGINES
@pytest.mark.parametrize(("share", "moves"), [(0.5, False), (1 - 1e-4, False), (1 + 1e-4, True), (1.2, True)])
def test_sleeve_moves_cyclically_once_the_speed_fluctuation_exceeds_the_band(engine, share, moves):
    turns = 10 * 2 * math.pi / MEAN
    spindle = Spindle(speeds=(MEAN,), speed_fluctuation=share * BAND)
    result = run(engine, porter(spindle, DryFriction(reading=LIFT, force=constant(40.0)), duration=turns), accuracy=1e-9)
    moved = np.ptp(result.readings[LIFT])
    assert (moved > 0.0) == moves
    assert bool(result.events) == moves


@ENGINES
def test_insensitivity_band_is_not_symmetric_about_the_equilibrium_speed(engine):
    """The sleeve moves at 0.959 of the insensitivity, because the closer end of the band is reached first."""
    rest = zehnder.FRICTION_BAND["equilibrium_speed"]
    nearer = 2 * min(rest - zehnder.FRICTION_BAND["falling_speed"], zehnder.FRICTION_BAND["rising_speed"] - rest) / rest
    assert nearer / zehnder.FRICTION_BAND["insensitivity_exact"] == pytest.approx(0.959, abs=5e-4)
    for share, moves in ((1 - 1e-3, False), (1 + 1e-3, True)):
        spindle = Spindle(speeds=(rest,), speed_fluctuation=share * nearer)
        result = run(engine, porter(spindle, DryFriction(reading=LIFT, force=constant(40.0)), duration=5.0), accuracy=1e-9)
        assert (np.ptp(result.readings[LIFT]) > 0.0) == moves


@ENGINES
def test_fluctuating_spindle_speed_follows_its_definition(engine):
    scene = porter(
        Spindle(times=(0.0, 1.6), speeds=(12.0, 13.0), speed_fluctuation=0.1, cycles_per_turn=3.0), duration=2.0, output_interval=1e-3
    )
    result = run(engine, scene)
    t = result.times
    mean, turned = np.minimum(12.0 + t / 1.6, 13.0), np.where(t < 1.6, 12 * t + t**2 / 3.2, 20.0 + 13 * (t - 1.6))
    expected = mean * (1 + 0.05 * np.sin(3 * turned))
    np.testing.assert_allclose(result.readings["spindle_speed"], expected, rtol=1e-13)
    assert result.energy.drift < 1e-9
    # The driving torque is the rate of the angular momentum, here by differences of order 2 in the interval.
    momentum = 2 * result.energy.rotation / result.readings["spindle_speed"]
    rate = (momentum[2:] - momentum[:-2]) / (t[2:] - t[:-2])
    smooth = np.abs(t[1:-1] - 1.6) > 0.002
    torque = result.readings["spindle_torque"][1:-1]
    scale = np.max(np.abs(torque))
    # Differences over 1 ms of a fluctuation at 40 rad/s have a relative error of (0.04)^2 / 6 = 3e-4.
    np.testing.assert_allclose(rate[smooth], torque[smooth], atol=1e-3 * scale)


ALL = (
    DryFriction(reading=LIFT, force=InputFunction(times=(0.0, 2.0, 2.0, 4.0), values=(40.0, 40.0, 5.0, 30.0))),
    Dashpot(reading="arm_angle", linear=0.5, quadratic=0.3),
    OutputSpring(reading=LIFT, rate=200.0, zero=0.1, one_sided=True),
    Stops(reading="arm_angle", low=0.5, high=0.8, restitution=0.5),
)


@ENGINES
@pytest.mark.parametrize(
    ("spindle", "duration"),
    [
        (Spindle(times=(0.0, 5.0), speeds=(12.0, 13.5), speed_fluctuation=0.2, cycles_per_turn=2.0), 5.0),
        (FreeSpindle(inertia=0.5, start_speed=12.0, torque=InputFunction(times=(0.0, 3.0, 3.0), values=(0.5, 0.5, -0.8))), 8.0),
    ],
    ids=["uneven", "free"],
)
def test_energy_balance_closes_with_all_effects(engine, spindle, duration):
    scene = porter(12.0, *ALL, angle=35.0, duration=duration).with_changes(spindle=spindle)
    result = run(engine, scene, accuracy=1e-9)  # the last bounces have times that rounding moves by 5e-10
    assert result.energy.drift < 1e-9  # requirement
    assert result.energy.dissipated_energy[-1] > 0.1
    assert np.all(np.diff(result.energy.dissipated_energy) >= -1e-12)
    assert len(result.events) > 3
    # Joint reactions exist in every contact mode.
    assert all(np.all(np.isfinite(reaction.force)) for reaction in result.reactions.values())


@ENGINES
def test_friction_carries_a_sticking_governor(engine):
    """At rest gravity, link forces and friction balance on the sleeve away from the equilibrium speed."""
    speed = 12.9
    result = run(engine, porter(speed, DryFriction(reading=LIFT, force=constant(40.0)), duration=0.1), accuracy=1e-9)
    links = [result.reactions[f"{side} link"].force[-1] for side in ("right", "left")]
    pull = sum(float(force[1]) for force in links)  # on the sleeve, upward
    mass, arm, offset = PORTER["sleeve_mass"], PORTER["arm"], PORTER["offset"]
    angle = math.radians(30.0)
    lift = PORTER["ball_mass"] * (speed**2 * (offset + arm * math.sin(angle)) / math.tan(angle) - G)
    # Friction holds the lift of the centrifugal force less the weight of the sleeve.
    assert pull == pytest.approx(lift, rel=1e-9)
    assert 0 < lift - mass * G < 40.0


@ENGINES
def test_estimate_covers_event_times_and_excludes_samples_close_to_events(engine):
    scene = block(Gravity(), Stops(reading="displacement", low=0.0, restitution=0.5), rate=2.0, duration=1.0, upright=True)
    strike = 2 * 2.0 / G
    times = [0.1, strike - 1e-12, strike, strike + 1e-12, 0.5]
    result = run(engine, scene, accuracy=1e-8, times=times)
    assert result.n_excluded == 3
    assert result.reading_errors["event times"] < 1e-9
    assert result.error_estimate < 1e-8


@ENGINES
@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1))
def test_error_of_inaccurate_runs_is_within_their_estimate(engine, seed):
    """The error of random scenes with effects, against a 10 000 times more accurate run, is at most three estimates."""
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
    if not (loose.outcome is tight.outcome is gm.Outcome.DONE):
        return
    times = np.array([event.time for event in tight.events] or [-1.0])
    near = np.min(np.abs(loose.times[:, np.newaxis] - times), axis=1) < 1e-5
    for name, values in loose.readings.items():
        error = np.max(np.abs(values - tight.readings[name])[~near])
        assert error <= 3 * loose.error_estimate * loose.scales[name] + 1e-12


@ENGINES
def test_model_size_lists_every_element(engine):
    bare = run(engine, porter(12.2, duration=0.1), accuracy=1e-8)
    assert set(bare.cost.model_size) == {"bodies", "joint equations"}
    # The tables of the reduced engine contain everything independent of time, two-sided springs included.
    has_tables = engine.name == "reduced"
    always = {"equations of motion", "table pieces"} if has_tables else {"equations of motion", "gravity", "centrifugal"}
    assert set(bare.cost.evaluations) == always
    for effect, part, law in (
        (DryFriction(reading=LIFT, force=constant(1.0)), "frictions", "dry friction"),
        (Dashpot(reading=LIFT, linear=1.0), "springs and dashpots along readings", "dashpots"),
        (OutputSpring(reading=LIFT, rate=1.0), "springs and dashpots along readings", None if has_tables else "springs on readings"),
        (OutputSpring(reading=LIFT, rate=1.0, one_sided=True), "springs and dashpots along readings", "springs on readings"),
        (Stops(reading=LIFT, low=-1.0), "stops", None),
    ):
        result = run(engine, porter(12.2, effect, duration=0.1), accuracy=1e-8)
        assert set(result.cost.model_size) - set(bare.cost.model_size) == {part, "readings with forces"}
        assert result.cost.model_size[part] == result.cost.model_size["readings with forces"] == 1
        assert set(result.cost.evaluations) - set(bare.cost.evaluations) == ({law} if law else set())
    stuck = run(engine, porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)), duration=0.1), accuracy=1e-8)
    assert stuck.cost.evaluations["dry friction"] == 0  # sticking friction is a constraint
    without = run(engine, porter(12.2, duration=0.1).with_changes(effects=(Gravity(),)), accuracy=1e-8)
    assert "centrifugal" not in without.cost.evaluations
    assert Centrifugal not in {type(effect) for effect in without.scene.effects}


def test_changed_held_values_accumulate_no_rounding():
    """A system updated a thousand times equals the system made with the last value."""
    scene = porter(12.2, DryFriction(reading=LIFT, force=constant(40.0)))
    system = make_system(scene, ContactMode(held_values=(0.1,), sliding_signs=(0,)))[0]
    values = np.random.default_rng(1).uniform(0.0, 0.2, 1000)
    for value in values:
        mode = ContactMode(held_values=(float(value),), sliding_signs=(0,))
        system = with_held_values(system, [0], mode)
    np.testing.assert_array_equal(system.constraint_rows.table, make_system(scene, mode)[0].constraint_rows.table)


@ENGINES
def test_start_beyond_the_stops_is_refused(engine):
    with pytest.raises(gm.MechanismError, match=r"beyond the stops of 'arm_angle', 34\.3775 deg to 45\.8366 deg"):
        engine.run(porter(12.2, Stops(reading="arm_angle", low=0.6, high=0.8)))


@ENGINES
def test_friction_that_depends_on_a_reading_never_drives(engine):
    """The function is negative beyond 0.1 m; there the friction is 0, and the block keeps its speed."""
    force = InputFunction(values=(1.0,), functions=(LinearFunction(reading="displacement", gain=-10.0),))
    result = run(engine, block(DryFriction(reading="displacement", force=force), rate=1.0, duration=1.0, mass=2.0))
    # The friction does the work 0.05 J, of 1 J. The scale of the speed is 1 m/s, and its error ten times the accuracy at most.
    assert result.readings["displacement"][-1] > 0.5
    np.testing.assert_allclose(result.rates["displacement"][-1], math.sqrt(0.95), rtol=0, atol=1e-9)


def test_a_governor_that_stands_takes_few_steps_and_slips_when_the_force_on_it_has_grown():
    """With a spindle that slowly speeds up, the sleeve slips where the unbalanced force of statics reaches the friction."""
    stuck = gm.load("porter").replace({"effects.dry_friction": {"sleeve_lift": "10 N"}, "start.arm_angle": "45 deg"})
    short, long = (gm.run(stuck.replace({"run.duration": duration}), engine="multibody", accuracy=1e-8) for duration in ("10 s", "40 s"))
    assert [event.kind.name for event in short.events] == [event.kind.name for event in long.events] == ["STICK"]
    assert long.cost.steps <= short.cost.steps + 8
    arm = float(long.readings["arm_angle"][-1])
    ramp = {"spindle.speed": [[0, "120 rpm"], ["400 s", "140 rpm"]], "run.duration": "400 s", "start.arm_angle": arm}
    slipping = gm.run(stuck.replace(ramp), engine="multibody", accuracy=1e-8)
    slip = next(event for event in slipping.events if event.kind.name == "SLIP")
    band = gm.insensitivity_band(stuck, [arm], "10 N")
    speed = 120 + 20 * slip.time / 400
    assert speed == pytest.approx(float(band.rising_speed[0]) * 30 / math.pi, rel=1e-7)
