"""Parts that touch on one coordinate: `reduced` against `multibody`, closed forms, and what it refuses."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import GRAVITY
from governor_mechanism.model.events import EventKind
from governor_mechanism.observables.error_scales import EVENT_TIMES
from scene_documents import between, custom_document, pin

WALL = [[0.1, -2], [0.5, -2], [0.5, 2], [0.1, 2]]
BLOCK = [[0.1, -0.7], [0.3, -0.7], [0.3, -0.49], [0.1, -0.49]]
"""A block with a corner at x = 0.1 m, y = -0.49 m, round which a bob comes before its face is the nearest."""
LENGTH, BOB = 0.5, 0.02
RIGHT, LEFT = [0.25, -0.06], [-0.25, -0.06]


def document(bodies, joints, contacts, angle, turn_rate=0.0, obstacles=()):
    """A scene whose coordinate is the angle of its first body, with obstacles welded to the ground."""
    fixed = [{"name": name, "mass": 1.0, "inertia": 1.0, "at": place, **shape} for name, place, shape in obstacles]
    welds = [between("weld", ["ground", *place], f"{name}.origin") for name, place, _ in obstacles]
    return custom_document(
        size=LENGTH,
        ground={"O": [0, 0]},
        body=[*bodies, *fixed],
        joint=[pin("ground.O", f"{bodies[0]['name']}.origin"), *joints, *welds],
        contact=contacts,
        readings={"angle": {"angle": bodies[0]["name"]}},
        effects={"gravity": GRAVITY},
        start={"angle": angle, "angle_rate": turn_rate},
        run={"duration": 2.0, "output_interval": 0.02, "accuracy": 1e-9},
    )


def pendulum(outline, restitution, start=-0.8):
    """A pendulum with a round bob that strikes an obstacle."""
    arm = {"name": "arm", "mass": 1.0, "inertia": 0.01, "at": [0, 0], "centre": [0, -LENGTH], "points": {"bob": [0, -LENGTH]}}
    contact = {"name": "c", "first": "arm.bob", "radius": BOB, "second": "wall", "restitution": restitution}
    return document([arm], [], [contact], start, obstacles=[("wall", [0, 0], {"outline": outline})])


def slider_crank(restitution):
    """A crank that falls from above, and whose slider strikes a block before the dead centre."""
    angle, radius, length = 1.2, 0.1, 0.3
    slope, knee = -math.asin(radius * math.sin(angle) / length), [radius * math.cos(angle), radius * math.sin(angle)]
    crank = {
        "name": "crank",
        "mass": 2.0,
        "inertia": 0.02,
        "at": [0, 0],
        "angle": angle,
        "centre": [0.05, 0],
        "points": {"pin": [radius, 0]},
    }
    rod = {"name": "rod", "mass": 0.5, "inertia": 0.01, "at": knee, "angle": slope, "centre": [0.15, 0], "points": {"small": [length, 0]}}
    end = [knee[0] + length * math.cos(slope), 0]
    slider = {"name": "slider", "mass": 1.0, "inertia": 0.01, "at": end, "points": {"nose": [0.01, 0]}}
    guide = between("prismatic", "ground.O", "slider.origin", angle=0)
    joints = [pin("crank.pin", "rod.origin"), pin("rod.small", "slider.origin"), guide]
    contact = {"name": "c", "first": "slider.nose", "radius": 0.01, "second": "block", "restitution": restitution}
    block = {"outline": [[0.41, -0.1], [0.6, -0.1], [0.6, 0.1], [0.41, 0.1]]}
    return document([crank, rod, slider], joints, [contact], angle, obstacles=[("block", [0, 0], block)])


def lever(restitution):
    """A lever with a heavy end that falls from one pin onto another, and bounces until it rests."""
    bar = [[-0.3, -0.01], [0.3, -0.01], [0.3, 0.01], [-0.3, 0.01]]
    arm = {"name": "arm", "mass": 1.0, "inertia": 0.02, "at": [0, 0], "centre": [0.1, 0], "outline": bar}
    pins, common = [("right", RIGHT, {}), ("left", LEFT, {})], {"radius": 0.01, "second": "arm", "restitution": restitution}
    contacts = [{"name": name, "first": f"{name}.origin", **common} for name, *_ in pins]
    return document([arm], [], contacts, 0.1, 2.0, obstacles=pins)


def with_friction(scene, friction):
    """The scene with friction of its contacts."""
    return {**scene, "contact": [{**contact, "friction": friction} for contact in scene["contact"]]}


@pytest.mark.parametrize(("restitution", "friction"), [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.3, 1.5)])
@pytest.mark.parametrize(
    "make",
    [lambda e: pendulum(WALL, e), lambda e: pendulum(BLOCK, e), lever, slider_crank],
    ids=["wall", "round a corner", "lever between pins", "slider crank"],
)
def test_along_one_coordinate_parts_touch_as_in_multibody(make, restitution, friction):
    """The gap is a function of the coordinate, and the contact a stop along it; both agree within their estimates."""
    scene = gm.Scene.from_dict(with_friction(make(restitution), friction))
    reduced, multibody = (gm.run(scene, engine) for engine in ("reduced", "multibody"))
    assert reduced.outcome is multibody.outcome is gm.Outcome.DONE
    assert [(one.kind, one.subject) for one in reduced.events] == [(one.kind, one.subject) for one in multibody.events]
    assert reduced.events
    for name, values in multibody.readings.items():
        bound = reduced.reading_errors[name] + multibody.reading_errors[name]
        assert np.abs(reduced.readings[name] - values).max() <= bound, name
    bound = sum(run.reading_errors[EVENT_TIMES] for run in (reduced, multibody))
    times = [[one.time for one in run.events] for run in (reduced, multibody)]
    np.testing.assert_allclose(*times, atol=max(bound, 1e-12))


@pytest.mark.parametrize("shift", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize("is_above", [False, True])
def test_a_bob_that_strikes_where_a_corner_and_its_face_are_equally_near_moves_as_in_multibody(is_above, shift):
    """The gap has a kink exactly at the impact: the corner stands at the height at which the bob touches the face."""
    level = -math.sqrt(LENGTH**2 - (0.1 - BOB) ** 2) + shift
    low, high = (level, level + 1.0) if is_above else (level - 1.0, level)
    scene = gm.Scene.from_dict(pendulum([[0.1, low], [0.4, low], [0.4, high], [0.1, high]], 0.5))
    reduced, multibody = (gm.run(scene, engine, times=np.linspace(0.0, 2.0, 21)) for engine in ("reduced", "multibody"))
    assert reduced.outcome is multibody.outcome is gm.Outcome.DONE
    assert len(reduced.events) == len(multibody.events) > 1
    for name in ("angle", "c_gap"):
        bound = reduced.reading_errors[name] + multibody.reading_errors[name]
        assert np.abs(reduced.readings[name] - multibody.readings[name]).max() <= bound, name


def test_a_pendulum_leaves_a_wall_with_the_share_of_its_speed_that_restitution_gives():
    """It strikes at the angle at which its bob touches; the height to which it swings back has the square of the restitution."""
    start, restitution = -0.8, 0.6
    run = gm.run(gm.Scene.from_dict(pendulum(WALL, restitution, start)), "reduced", times=np.linspace(0.0, 1.0, 4001))
    touch = math.asin((0.1 - BOB) / LENGTH)
    fallen = math.cos(touch) - math.cos(start)
    lowest = math.acos(math.cos(touch) - restitution**2 * fallen)
    assert run.readings["c_gap"].min() > -1e-12
    assert run.readings["angle"].max() == pytest.approx(touch, abs=1e-3)
    after = run.times > run.events[0].time
    assert run.readings["angle"][after].min() == pytest.approx(-lowest, abs=1e-6)
    assert run.energy.drift < 1e-9


def test_auto_takes_multibody_for_parts_that_touch():
    run = gm.run(gm.Scene.from_dict(pendulum(WALL, 0.5)), times=[0.0, 0.1])
    assert run.cost.engine == "multibody"


def wheel(restitution, turn_rate, **contact):
    """A heavy wheel with twelve pins that swings below its axle, and whose pins strike an anvil."""
    arm = {"name": "arm", "mass": 1.0, "inertia": 0.05, "at": [0, 0], "centre": [0, -0.2], "points": {"pin": [0, -0.3]}}
    pins = {"name": "c", "first": "arm.pin", "radius": BOB, "second": "anvil", "restitution": restitution, "repeat": 12, **contact}
    anvil = {"outline": [[0.1, -0.7], [0.3, -0.7], [0.3, -0.3], [0.1, -0.3]]}
    return document([arm], [], [pins], 0.1, turn_rate, obstacles=[("anvil", [0, 0], anvil)])


def test_one_gap_of_several_rollers_is_refused():
    match = r"one gap of several rollers.*contact 'c'; give it at_once, as large as repeat.*choose engine 'multibody'"
    with pytest.raises(gm.UnsupportedEffect, match=match):
        gm.run(gm.Scene.from_dict(wheel(0.5, 5.0)), "reduced")


@pytest.mark.parametrize(("restitution", "turn_rate", "friction"), [(0.7, -2.0, 0.0), (0.3, 5.0, 0.0), (0.7, -2.0, 0.2)])
def test_repeated_rollers_with_a_gap_of_each_touch_as_in_multibody(restitution, turn_rate, friction):
    scene = gm.Scene.from_dict(wheel(restitution, turn_rate, friction=friction, at_once=12))
    reduced, multibody = (gm.run(scene, engine) for engine in ("reduced", "multibody"))
    assert reduced.outcome is multibody.outcome is gm.Outcome.DONE
    assert [(one.kind, one.subject) for one in reduced.events] == [(one.kind, one.subject) for one in multibody.events]
    assert len(reduced.events) > 1
    for name, values in multibody.readings.items():
        bound = reduced.reading_errors[name] + multibody.reading_errors[name]
        assert np.abs(reduced.readings[name] - values).max() <= bound, name


FLOOR = [[-1, -1], [1, -1], [1, -0.45], [-1, -0.45]]
"""A floor that a bob strikes on an inclined way."""
TOUCH = math.acos((0.45 - BOB) / LENGTH)
SELF_LOCKING = LENGTH * math.sin(TOUCH) / 0.45
"""Angle of the rod where it touches, and the speed at which its bob comes nearer there, relative to that of the slip: 0.567."""


@pytest.mark.parametrize("engine", ["reduced", "multibody"])
@pytest.mark.parametrize("friction", [0.2, 0.55, 0.65, 3.0])
def test_a_strut_rebounds_by_the_energy_that_friction_leaves_and_not_beyond_self_locking(engine, friction):
    """Rates are proportional, and friction turns with them: Stronge's rebound is e sqrt((1 - r) / (1 + r)) of the speed, none for r > 1."""
    restitution, ratio = 0.5, friction / SELF_LOCKING
    scene = gm.Scene.from_dict(with_friction(pendulum(FLOOR, restitution, -1.2), friction))
    run = gm.run(scene, engine, times=np.linspace(0.0, 0.5, 2001))
    assert run.outcome is gm.Outcome.DONE
    after = (run.times > run.events[0].time) & (run.times < 0.34)
    if ratio >= 1.0:
        assert [event.kind for event in run.events] == [EventKind.IMPACT, EventKind.REST]
        assert np.abs(run.rates["angle"][after]).max() < 1e-9
        assert run.energy.drift < 1e-9
        return
    before = float(run.rates["angle"][run.times < run.events[0].time][-1])
    rebound = restitution * math.sqrt((1.0 - ratio) / (1.0 + ratio)) * before
    assert -float(run.rates["angle"][after][0]) == pytest.approx(rebound, abs=0.005)  # gravity changes it by as much between reports
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize(("friction", "moment"), [(0.55, -20.0), (0.65, -20.0), (0.65, 20.0)])
def test_beyond_self_locking_a_strut_that_is_pulled_off_ends_by_name_in_both_engines(friction, moment):
    """Where friction could hold it by itself, rigid bodies do not determine whether it leaves; pressed on, it stays."""
    document = with_friction(pendulum(FLOOR, 0.0, -TOUCH), friction) | {"force": [{"type": "torque", "body": "arm", "moment": moment}]}
    runs = [gm.run(gm.Scene.from_dict(document), engine, times=[0.0, 0.1]) for engine in ("reduced", "multibody")]
    is_undetermined = moment < 0.0 and friction > SELF_LOCKING
    for run in runs:
        assert run.outcome is (gm.Outcome.STALLED if is_undetermined else gm.Outcome.DONE)
        assert ("friction jams" in run.detail) == is_undetermined
    if moment > 0.0:
        assert runs[0].readings["angle"] == pytest.approx([-TOUCH, -TOUCH], abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("has_friction", [False, True])
def test_pendulums_and_random_blocks_touch_as_in_multibody(has_friction):
    """Polygons of three to five corners, round which the bob comes: the gap has kinks where another edge is the nearest."""
    rng, count = np.random.default_rng(5), 0
    for number in range(60):
        angles = np.sort(rng.uniform(0.0, math.tau, rng.integers(3, 6)))
        centre = rng.uniform([0.1, -0.7], [0.5, -0.3])
        start, restitution = rng.uniform(-2.5, -0.3), rng.choice([0.0, 0.3, 0.8])
        if max(np.diff([*angles, angles[0] + math.tau])) > 3.0:
            continue
        block = (centre + 0.08 * np.column_stack([np.cos(angles), np.sin(angles)])).tolist()
        scene = gm.Scene.from_dict(with_friction(pendulum(block, float(restitution), float(start)), 0.025 * number * has_friction))
        runs = [gm.run(scene, engine) for engine in ("reduced", "multibody")]
        count += 1
        assert runs[0].outcome is runs[1].outcome
        if runs[0].outcome is gm.Outcome.STALLED:
            assert "friction jams" in runs[0].detail
            assert len(runs[0].times) == len(runs[1].times)
            continue
        assert runs[0].outcome is gm.Outcome.DONE
        events = [[(event.kind, event.subject) for event in run.events] for run in runs]
        assert events[0] == events[1]
        for name in ("angle", "c_gap"):
            bound = sum(run.reading_errors[name] for run in runs)
            assert np.abs(runs[0].readings[name] - runs[1].readings[name]).max() <= bound
    assert count > 25


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("friction_governor", "mobility 3, and contacts take none of them away, as parts that touch may leave; choose engine 'multibody'"),
        ("graham_escapement", "mobility 2, and contacts take none of them away, as parts that touch may leave; choose engine 'multibody'"),
        ("geneva", "one free coordinate, but drives move this mechanism; choose engine 'multibody'"),
    ],
)
def test_more_than_one_free_coordinate_is_refused(name, sentence):
    with pytest.raises(gm.UnsupportedEffect, match=sentence):
        gm.run(name, engine="reduced")
