"""[effects] and an uneven spindle become what they describe; what is wrong is told, and what is off does not exist."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from broken.custom_scenes import own_scene
from broken.effect_scenes import BROKEN_EFFECTS, with_effects
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.pendulum.machine import PendulumGovernor
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import EQUILIBRIUM, Scene, Spindle
from governor_mechanism.model.time_functions import Program
from governor_mechanism.scenes.parser import scene_from_document
from scenes import PORTER

ALL = ("gravity", "centrifugal", "rods", "spring", "dry_friction", "oil_brake", "stops", "play")


def scene_of(text: str) -> Scene:
    return scene_from_document(tomllib.loads(text))


def near(value: float) -> Any:
    return pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            'rods = { arm_mass = "0.6 kg", link_mass = 0.5, ball_radius = "50 mm" }',
            [Rods(arm_mass=0.6, link_mass=0.5, ball_radius=0.05)],
        ),
        (
            'spring = { sleeve = { rate = "2 N/mm", preload = "30 N", zero = "-5 mm", one_sided = true } }',
            [SpringOn(reading="sleeve_lift", rate=2000.0, preload=30.0, zero=-0.005, one_sided=True)],
        ),
        (
            'spring = { sleeve = { wire = "4 mm", coil = "40 mm", turns = 8, modulus = "80 GPa" } }',
            [SpringOn(reading="sleeve_lift", rate=5000.0)],
        ),
        ("spring = { arm_angle = { rate = 3 } }", [SpringOn(reading="arm_angle", rate=3.0)]),
        (
            'dry_friction = { sleeve_lift = "40 N" }',
            [DryFriction(reading="sleeve_lift", force=Program(values=(40.0,)))],
        ),
        (
            'dry_friction = { arm_angle = 2, ball_radius = [[0, "40 N"], [1, "40 N"], [1, "0 N"]] }',
            [
                DryFriction(reading="arm_angle", force=Program(values=(2.0,))),
                DryFriction(reading="ball_radius", force=Program(times=(0.0, 1.0, 1.0), values=(40.0, 40.0, 0.0))),
            ],
        ),
        ('oil_brake = { sleeve = "120 N s/m" }', [OilBrake(reading="sleeve_lift", linear=120.0)]),
        ("oil_brake = { sleeve = 120, arm_angle = false }", [OilBrake(reading="sleeve_lift", linear=120.0)]),
        (
            'oil_brake = { sleeve = { linear = 3, quadratic = "300 N s^2/m^2" } }',
            [OilBrake(reading="sleeve_lift", linear=3.0, quadratic=300.0)],
        ),
        (
            'oil_brake = { arm_angle = { linear = "0.1 N m s/rad", quadratic = "0.3 N m s^2/rad^2" } }',
            [OilBrake(reading="arm_angle", linear=0.1, quadratic=0.3)],
        ),
        (
            'stops = { arm_angle = [0.25, 0.75], sleeve = ["none", "70 mm"], restitution = 0.3 }',
            [
                Stops(reading="arm_angle", low=0.25, high=0.75, restitution=0.3),
                Stops(reading="sleeve_lift", high=0.07, restitution=0.3),
            ],
        ),
        ('play = "0.5 mm"', [Play(width=0.0005)]),
        ('play = { width = "0.5 mm", restitution = "20 %" }', [Play(width=0.0005, restitution=0.2)]),
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
    (_, _, brake) = scene_of(with_effects(f"oil_brake = {{ sleeve = {{ linear = 5, {sizes} }} }}")).effects
    assert isinstance(brake, OilBrake)
    assert (brake.reading, brake.linear) == ("sleeve_lift", 5.0)
    assert brake.quadratic == near(800 * 20e-4**3 / 2 / (0.62 * 0.5 * 12e-6) ** 2)


def test_effects_come_in_one_order() -> None:
    written = 'stops = { arm_angle = [0.1, 1.0] }\ndry_friction = { sleeve = 1 }\nplay = "1 mm"'
    assert [type(effect) for effect in scene_of(with_effects(written)).effects] == [
        Gravity,
        Centrifugal,
        DryFriction,
        Stops,
        Play,
    ]


def test_effects_act_on_the_readings_of_ones_own_mechanism() -> None:
    own = own_scene('[readings]\nsleeve = { x = "crank.end" }\n[effects]\ndry_friction = { sleeve = "4 N" }')
    assert scene_of(own).effects == (DryFriction(reading="sleeve", force=Program(values=(4.0,))),)


def test_a_spindle_may_turn_unevenly() -> None:
    spindle = scene_of(with_effects(spindle="speed = [[0, 12], [1, 13]]\nunevenness = 0.03\nwaves = 2")).spindle
    assert spindle == Spindle(times=(0.0, 1.0), speeds=(12.0, 13.0), unevenness=0.03, waves=2.0)
    assert scene_of(with_effects(spindle="speed = 12\nunevenness = 0")).spindle == Spindle(speeds=(12.0,))


def test_the_machine_is_built_with_its_rods_and_its_play() -> None:
    machine = PendulumGovernor(**PORTER)
    rods = scene_of(with_effects('rods = { arm_mass = "0.6 kg" }'))
    assert rods.part.mechanism == machine.mechanism(rods=Rods(arm_mass=0.6))
    play = scene_of(with_effects('play = "1 mm"', 'dry_friction = { sleeve_play = "1 N" }'))
    assert play.part.mechanism == machine.mechanism(play=Play(width=1e-3))
    assert [effect.reading for effect in play.acting] == [PLAY, PLAY]


@pytest.mark.parametrize(
    ("start", "values", "rates"),
    [
        ("", {"arm_angle": EQUILIBRIUM, PLAY: 0.0}, {}),
        ("arm_angle = 0.7\narm_rate = 0.1", {"arm_angle": 0.7, PLAY: 0.0}, {"arm_angle": 0.1, PLAY: 0.0}),
        ('arm_angle = 0.7\nsleeve_play = "-0.5 mm"', {"arm_angle": 0.7, PLAY: -5e-4}, {}),
        ("arm_angle = 0.7\nsleeve_play_rate = 0.2", {"arm_angle": 0.7, PLAY: 0.0}, {PLAY: 0.2}),
    ],
)
def test_a_sleeve_starts_in_the_middle_of_its_play(start: str, values: Any, rates: Any) -> None:
    found = scene_of(with_effects('play = "1 mm"', start=start)).start
    assert (found.values, found.rates) == (values, rates)


def test_a_start_on_a_stop_is_allowed() -> None:
    scene = scene_of(with_effects('stops = { arm_angle = ["15 deg", "40 deg"] }'))
    assert scene.start.values == {"arm_angle": near(math.radians(40))}


@pytest.mark.parametrize(
    ("text", "fragments"), [case[1:] for case in BROKEN_EFFECTS], ids=[case[0] for case in BROKEN_EFFECTS]
)
def test_a_broken_file_is_refused_with_its_sentences_alone(text: str, fragments: list[str]) -> None:
    with pytest.raises(MechanismError) as caught:
        scene_of(text)
    told = caught.value.problems
    assert len(told) == len(fragments), told
    for fragment, problem in zip(fragments, told, strict=True):
        assert fragment in problem


def run_of(effects: dict[str, bool], engine: str) -> gm.Trajectory:
    document = {
        "machine": "pendulum_governor",
        "dimensions": PORTER,
        "effects": effects,
        "spindle": {"speed": 12.0},
        "start": {"arm_angle": 0.9, "arm_rate": 0.3},
        "run": {"duration": 0.2},
    }
    return gm.run(scene_from_document(document), engine=engine)


@pytest.mark.parametrize("key", ALL)
def test_an_effect_switched_off_does_not_exist(key: str) -> None:
    others = {name: True for name in ALL[:2] if name != key}
    absent, off = ({"effects": others | more} for more in ({}, {key: False}))
    base = {"machine": "pendulum_governor", "dimensions": PORTER, "spindle": {"speed": 12.0}, "start": {"arm_angle": 1}}
    without, scene = scene_from_document(base | absent), scene_from_document(base | off)
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
