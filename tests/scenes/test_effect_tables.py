"""[effects] and an uneven spindle become what they describe; what is wrong is told, and what is off does not exist."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance, DryFriction, Stops
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import EQUILIBRIUM, Spindle
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.problems import Problem
from governor_scenes import PORTER
from invalid_scenes.cases import Case, custom_scene, each_case, with_effects
from scene_documents import governor_document

ALL = ("gravity", "centrifugal", "rods", "spring", "dry_friction", "dashpot", "stops", "clearance")


def scene_of(text: str) -> gm.Scene:
    return parse_scene_document(tomllib.loads(text))


def near(value: float) -> Any:
    return pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            'rods = { arm_mass = "0.6 kg", link_mass = 0.5, ball_radius = "50 mm" }',
            [RodMasses(arm_mass=0.6, link_mass=0.5, ball_radius=0.05)],
        ),
        (
            'spring = { sleeve = { rate = "2 N/mm", preload = "30 N", zero = "-5 mm", one_sided = true } }',
            [OutputSpring(reading="sleeve_lift", rate=2000.0, preload=30.0, zero=-0.005, one_sided=True)],
        ),
        (
            'spring = { sleeve = { wire = "4 mm", coil = "40 mm", turns = 8, modulus = "80 GPa" } }',
            [OutputSpring(reading="sleeve_lift", rate=5000.0)],
        ),
        ("spring = { arm_angle = { rate = 3 } }", [OutputSpring(reading="arm_angle", rate=3.0)]),
        ('dry_friction = { sleeve_lift = "40 N" }', [DryFriction(reading="sleeve_lift", force=InputFunction(values=(40.0,)))]),
        (
            'dry_friction = { arm_angle = 2, ball_radius = [[0, "40 N"], [1, "40 N"], [1, "0 N"]] }',
            [
                DryFriction(reading="arm_angle", force=InputFunction(values=(2.0,))),
                DryFriction(reading="ball_radius", force=InputFunction(times=(0.0, 1.0, 1.0), values=(40.0, 40.0, 0.0))),
            ],
        ),
        ('dashpot = { sleeve = "120 N s/m" }', [Dashpot(reading="sleeve_lift", linear=120.0)]),
        ("dashpot = { sleeve = 120, arm_angle = false }", [Dashpot(reading="sleeve_lift", linear=120.0)]),
        (
            'dashpot = { sleeve = { linear = 3, quadratic = "300 N s^2/m^2" } }',
            [Dashpot(reading="sleeve_lift", linear=3.0, quadratic=300.0)],
        ),
        (
            'dashpot = { arm_angle = { linear = "0.1 N m s/rad", quadratic = "0.3 N m s^2/rad^2" } }',
            [Dashpot(reading="arm_angle", linear=0.1, quadratic=0.3)],
        ),
        (
            'stops = { arm_angle = [0.25, 0.75], sleeve = ["none", "70 mm"], restitution = 0.3 }',
            [Stops(reading="arm_angle", low=0.25, high=0.75, restitution=0.3), Stops(reading="sleeve_lift", high=0.07, restitution=0.3)],
        ),
        ('clearance = "0.5 mm"', [Clearance(width=0.0005)]),
        ('clearance = { width = "0.5 mm", restitution = "20 %" }', [Clearance(width=0.0005, restitution=0.2)]),
    ],
)
def test_an_effect_becomes_what_it_describes(line: str, expected: list[Effect]) -> None:
    found = scene_of(with_effects(line)).effects[2:]
    assert [type(effect) for effect in found] == [type(effect) for effect in expected]
    for one, other in zip(found, expected, strict=True):
        numbers = {name: near(value) if isinstance(value, float) else value for name, value in vars(other).items()}
        assert vars(one) == numbers


def test_a_piston_and_its_hole_are_a_quadratic_brake() -> None:
    sizes = 'piston = "20 cm^2", hole = "12 mm^2", screw = 0.5, oil = "800 kg/m^3"'
    (_, _, brake) = scene_of(with_effects(f"dashpot = {{ sleeve = {{ linear = 5, {sizes} }} }}")).effects
    assert isinstance(brake, Dashpot)
    assert (brake.reading, brake.linear) == ("sleeve_lift", 5.0)
    assert brake.quadratic == near(800 * 20e-4**3 / 2 / (0.62 * 0.5 * 12e-6) ** 2)


def test_effects_come_in_one_order() -> None:
    written = 'stops = { arm_angle = [0.1, 1.0] }\ndry_friction = { sleeve = 1 }\nclearance = "1 mm"'
    assert [type(effect) for effect in scene_of(with_effects(written)).effects] == [Gravity, Centrifugal, DryFriction, Stops, Clearance]


def test_effects_act_on_the_readings_of_ones_own_mechanism() -> None:
    own = custom_scene('[readings]\nsleeve = { x = "crank.end" }\n[effects]\ndry_friction = { sleeve = "4 N" }')
    assert scene_of(own).effects == (DryFriction(reading="sleeve", force=InputFunction(values=(4.0,))),)


def test_gravity_and_the_places_of_stops_may_be_small() -> None:
    assert scene_of(custom_scene('[effects]\ngravity = "1e-14 m/s^2"')).effects == (Gravity(acceleration=1e-14),)
    (_, _, small, large) = scene_of(with_effects('stops = { arm_angle = ["1e-14 rad", 1], sleeve = ["-1e-14 m", "1e8 m"] }')).effects
    assert small == Stops(reading="arm_angle", low=1e-14, high=1.0)
    assert large == Stops(reading="sleeve_lift", low=-1e-14, high=1e8)


def test_a_spindle_may_turn_unevenly() -> None:
    spindle = scene_of(with_effects(spindle="speed = [[0, 12], [1, 13]]\nspeed_fluctuation = 0.03\ncycles_per_turn = 2")).spindle
    assert spindle == Spindle(times=(0.0, 1.0), speeds=(12.0, 13.0), speed_fluctuation=0.03, cycles_per_turn=2.0)
    assert scene_of(with_effects(spindle="speed = 12\nspeed_fluctuation = 0")).spindle == Spindle(speeds=(12.0,))


def test_the_machine_is_built_with_its_rods_and_its_play() -> None:
    machine = PendulumGovernor(**PORTER)
    rods = scene_of(with_effects('rods = { arm_mass = "0.6 kg" }'))
    assert rods.part.mechanism == machine.mechanism(rod_masses=RodMasses(arm_mass=0.6))
    play = scene_of(with_effects('clearance = "1 mm"', 'dry_friction = { sleeve_clearance = "1 N" }'))
    assert play.part.mechanism == machine.mechanism(clearance=Clearance(width=1e-3))
    assert [effect.reading for effect in play.output_effects] == [CLEARANCE_READING, CLEARANCE_READING]


@pytest.mark.parametrize(
    ("start", "values", "rates"),
    [
        ("", {"arm_angle": EQUILIBRIUM, CLEARANCE_READING: 0.0}, {}),
        ("arm_angle = 0.7\narm_rate = 0.1", {"arm_angle": 0.7, CLEARANCE_READING: 0.0}, {"arm_angle": 0.1, CLEARANCE_READING: 0.0}),
        ('arm_angle = 0.7\nsleeve_clearance = "-0.5 mm"', {"arm_angle": 0.7, CLEARANCE_READING: -5e-4}, {}),
        ("arm_angle = 0.7\nsleeve_clearance_rate = 0.2", {"arm_angle": 0.7, CLEARANCE_READING: 0.0}, {CLEARANCE_READING: 0.2}),
    ],
)
def test_a_sleeve_starts_in_the_middle_of_its_play(start: str, values: Any, rates: Any) -> None:
    found = scene_of(with_effects('clearance = "1 mm"', start=start)).start
    assert (found.values, found.rates) == (values, rates)


def test_a_start_on_a_stop_is_allowed() -> None:
    scene = scene_of(with_effects('stops = { arm_angle = ["15 deg", "40 deg"] }'))
    assert scene.start.values == {"arm_angle": near(math.radians(40))}


@each_case("effects")
def test_every_mistake_of_a_scene_is_found_at_its_key_and_told_with_its_cure(case: Case) -> None:
    with pytest.raises(gm.MechanismError) as caught:
        scene_of(case.text)
    assert [(problem.code, problem.key) for problem in map(Problem, caught.value.problems)] == case.mistakes
    assert set(case.messages) <= set(caught.value.problems)


def run_of(effects: dict[str, bool], engine: str) -> gm.Trajectory:
    start, run = {"arm_angle": 0.9, "arm_rate": 0.3}, {"duration": 0.2}
    document = governor_document(effects=effects, spindle={"speed": 12.0}, start=start, run=run)
    return gm.run(parse_scene_document(document), engine=engine)


@pytest.mark.parametrize("key", ALL)
def test_an_effect_switched_off_does_not_exist(key: str) -> None:
    others = {name: True for name in ALL[:2] if name != key}
    absent, off = ({"effects": others | more} for more in ({}, {key: False}))
    base = {"machine": "pendulum_governor", "dimensions": PORTER, "spindle": {"speed": 12.0}, "start": {"arm_angle": 1}}
    without, scene = parse_scene_document(base | absent), parse_scene_document(base | off)
    assert scene.effects == without.effects
    assert scene.part == without.part


@pytest.mark.parametrize("engine", ["multibody", "impulse"])
@pytest.mark.parametrize("key", ALL)
def test_a_run_with_an_effect_switched_off_is_the_run_without_it_to_the_last_bit(key: str, engine: str) -> None:
    others = {name: True for name in ALL[:2] if name != key}
    without, off = run_of(others, engine), run_of(others | {key: False}, engine)
    assert without.outcome.ok
    assert list(off.readings) == list(without.readings)
    for found, expected in ((off.readings, without.readings), (off.rates, without.rates)):
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name].view(np.int64), values.view(np.int64))
