"""A motion that passes a limit and comes back before the next reported time has ended at the limit."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.exit_location import is_searched_between_samples
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import governor_document

ARM, LINK, BALL, SLEEVE, START = 0.3, 0.45, 5.0, 20.0, math.radians(75)


def sleeve_depth(angle: float) -> float:
    """Depth (m) of the sleeve below the suspension; the arms hang as far from the axis as the links."""
    return ARM * math.cos(angle) + math.sqrt(LINK**2 - (ARM * math.sin(angle)) ** 2)


def potential(angle: float) -> float:
    """Potential energy (J)."""
    return -9.81 * (2 * BALL * ARM * math.cos(angle) + SLEEVE * sleeve_depth(angle))


def thrown_governor(peak: float, effects: dict | None = None) -> gm.Scene:
    """A governor at rest, without rotation, whose arms are thrown up so that they turn back at an angle `peak` (rad)."""
    depth_slope = (sleeve_depth(START + 1e-6) - sleeve_depth(START - 1e-6)) / 2e-6
    inertia = 2 * BALL * ARM**2 + SLEEVE * depth_slope**2
    rate = math.sqrt(2 * (potential(peak) - potential(START)) / inertia)
    document = governor_document(
        {"arm": ARM, "link": LINK, "offset": 0.04, "ball_mass": BALL, "sleeve_mass": SLEEVE},
        effects={"gravity": True, "centrifugal": True} | (effects or {}),
        spindle={"speed": 0.0},
        start={"arm_angle": START, "arm_rate": rate},
        run={"duration": 0.4, "output_interval": 0.02, "accuracy": 1e-6},
    )
    return parse_scene_document(document)


@pytest.mark.parametrize("engine", ["reduced", "multibody", "impulse"])
@pytest.mark.parametrize(("excess", "has_left"), [(2e-5, True), (1e-3, True), (-2e-5, False), (-1e-2, False)])
def test_a_short_excursion_beyond_the_travel_ends_the_run(engine, excess, has_left):
    run = gm.run(thrown_governor(math.pi / 2 + excess), engine=engine)
    assert np.max(run.readings["arm_angle"]) < math.pi / 2  # no sample shows the excursion
    if not has_left:
        assert run.outcome is gm.Outcome.DONE
        return
    assert run.outcome is gm.Outcome.LEFT_RANGE
    assert "the arms are at 90 degrees" in run.message
    assert np.all(np.diff(run.readings["arm_angle"]) > 0.0)  # no sample after the turning point


def swinging_crossed_arms(lowest: float) -> gm.Scene:
    """A spring without gravity or rotation: the arms swing harmonically about 30 degrees and turn back at an angle `lowest` (rad)."""
    arm, ball_mass, rate, middle = 0.4, 2.0, 20.0, math.radians(30)
    frequency = math.sqrt(rate / (2 * ball_mass * arm**2))
    document = governor_document(
        {"arm": arm, "offset": -0.06, "ball_mass": ball_mass},
        effects={"gravity": False, "spring": {"arm_angle": {"rate": rate, "zero": middle}}},
        spindle={"speed": 0.0},
        start={"arm_angle": middle, "arm_rate": (lowest - middle) * frequency},
        # The arms turn back after a quarter of their period, 0.281 s: not next to a reported time, which would show it.
        run={"duration": 0.8, "output_interval": 0.025, "accuracy": 1e-6},
    )
    return parse_scene_document(document)


@pytest.mark.parametrize("engine", ["reduced", "multibody", "impulse"])
@pytest.mark.parametrize(("excess", "has_left"), [(2e-5, True), (-2e-5, False)])
def test_a_short_excursion_below_the_travel_ends_the_run(engine, excess, has_left):
    meeting = math.asin(0.06 / 0.4)
    run = gm.run(swinging_crossed_arms(meeting - excess), engine=engine)
    assert np.min(run.readings["arm_angle"]) > meeting  # no sample shows the excursion
    assert run.outcome is (gm.Outcome.LEFT_RANGE if has_left else gm.Outcome.DONE)
    assert np.all(np.diff(run.readings["arm_angle"]) < 0.0) == has_left  # no sample after the turning point


@pytest.mark.parametrize("engine", [ReducedEngine(), MultibodyEngine(), ImpulseEngine(max_steps=20_000)], ids=lambda engine: engine.name)
def test_bounces_just_before_the_limit_do_not_end_the_run(engine):
    meeting = math.asin(0.06 / 0.4)  # the balls of crossed arms meet on the axis
    stops = {"arm_angle": [meeting + 1e-6, "60 deg"], "restitution": 0.9}
    document = governor_document(
        {"arm": 0.4, "offset": -0.06, "ball_mass": 2.0, "sleeve_mass": 8.0},
        effects={"gravity": True, "centrifugal": True, "stops": stops},
        spindle={"speed": 0.0},
        start={"arm_angle": meeting + 1e-3},
        run={"duration": 0.2, "output_interval": 0.02, "accuracy": 1e-6},
    )
    scene = parse_scene_document(document)
    run = gm.run(scene, engine=engine)
    assert run.outcome in (gm.Outcome.DONE, gm.Outcome.ACCURACY_MISSED)
    assert sum(event.kind == "strikes its stop" for event in run.events) > 5


@pytest.mark.parametrize("name", ["porter", "geneva", "governed_engine_hartung"])
def test_between_samples_change_points_and_controls_are_searched_for(name):
    assert is_searched_between_samples(gm.load(name))


def test_between_samples_of_contacts_alone_only_crossings_are_searched_for():
    rubbing = gm.load("porter_dry_friction")
    assert not is_searched_between_samples(rubbing)
    assert is_searched_between_samples(rubbing.replace({"events": {"high": {"reading": "arm_angle", "value": "40 deg"}}}))
