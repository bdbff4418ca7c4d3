"""Combined effects: redundant contacts, clearance at a dead centre, repeated certificates, very short runs."""

import itertools

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import governor_document

ENGINES = pytest.mark.parametrize("engine", ["multibody", "reduced"])
PORTER = {"arm": "300 mm", "offset": "40 mm", "ball_mass": "5 kg", "sleeve_mass": "20 kg"}
CROSSED = {"arm": "300 mm", "offset": "-20 mm", "arm_joint": "200 mm", "link": "180 mm", "ball_mass": "5 kg"}


def scene(effects, *, dimensions=PORTER, spindle=None, start=None, duration="2 s", output_interval="5 ms"):
    document = governor_document(
        dimensions,
        effects={"gravity": True, "centrifugal": True, **effects},
        spindle=spindle or {"speed": "120 rpm"},
        start=start or {"arm_angle": "30 deg"},
        run={"duration": duration, "output_interval": output_interval},
    )
    return parse_scene_document(document)


def run_scene(engine, effects, **options):
    return gm.run(scene(effects, **options), engine=engine)


def has_alternating_events(events, subject):
    """Return whether starts and ends of rest of a reading alternate."""
    begins = {"sticks": 1, "rests on its stop": 1, "slips": 0, "leaves its stop": 0}
    kinds = [begins[event.kind] for event in events if event.subject == subject and event.kind in begins]
    return all(one != other for one, other in itertools.pairwise(kinds))


@ENGINES
def test_two_frictions_on_one_degree_of_freedom_stick_and_slip_together(engine):
    """Either could hold alone; together they hold the sum of both limits and release at the same time."""
    relieved = [[0, "40 N"], [0.5, "40 N"], [0.5, "0 N"], [0.6, "0 N"], [0.6, "40 N"]]
    run = run_scene(
        engine,
        {"dry_friction": {"sleeve": relieved, "arm_angle": "5 N m"}},
        dimensions=PORTER | {"sleeve_mass": "50 kg", "arm_joint": "200 mm", "link": "200 mm"},
        spindle={"speed": "133.4 rpm", "speed_fluctuation": 0.2, "cycles_per_turn": 2},
        start={"arm_angle": "30.5 deg"},
    )
    assert run.outcome is gm.Outcome.DONE
    assert has_alternating_events(run.events, "sleeve_lift")
    assert has_alternating_events(run.events, "arm_angle")
    times = {name: [event.time for event in run.events if event.subject == name] for name in ("sleeve_lift", "arm_angle")}
    assert times["sleeve_lift"] == times["arm_angle"]
    # The dissipated energy is the work of both over their displacements while the first is not reduced.
    before = run.times <= 0.4
    lift, rotation = (np.sum(np.abs(np.diff(run.readings[name][before]))) for name in ("sleeve_lift", "arm_angle"))
    assert run.energy.dissipated_energy[before][-1] == pytest.approx(40 * lift + 5 * rotation, rel=1e-3)  # turning points between


@ENGINES
def test_stop_and_friction_on_one_degree_of_freedom_release_together(engine):
    effects = {
        "dry_friction": {"sleeve": "40 N"},
        "dashpot": {"sleeve": "120 N s/m"},
        "stops": {"arm_angle": ["25 deg", "48 deg"], "restitution": 0.3},
    }
    speed = [[0, "140 rpm"], [0.2, "260 rpm"], [1, "260 rpm"], [2, "120 rpm"], [3, "120 rpm"]]
    run = gm.run(scene(effects, spindle={"speed": speed}, duration="3 s"), engine=engine)
    assert run.outcome is gm.Outcome.DONE
    assert has_alternating_events(run.events, "arm_angle")
    assert has_alternating_events(run.events, "sleeve_lift")
    kinds = {event.kind for event in run.events}
    assert {"rests on its stop", "leaves its stop", "sticks", "slips"} <= kinds
    assert run.energy.drift < 1e-9
    # The arms leave the stop when the load exceeds the friction force: w^2 = 2 (V' - W s') / J'.
    left = next(event for event in run.events if event.kind == "leaves its stop")
    expected = gm.insensitivity_band(scene({}), [np.radians(48.0)], 40.0).falling_speed[0]
    speeds = run.readings["spindle_speed"]
    assert np.interp(left.time, run.times, speeds) == pytest.approx(expected, rel=1e-4)  # linear interpolation over 5 ms


@pytest.mark.parametrize(("engine", "clearance"), [("multibody", "3 mm"), ("multibody", False), ("reduced", False)])
def test_insufficient_certificate_is_repeated(engine, clearance):
    effects = {
        "clearance": clearance,
        "dashpot": {"sleeve": {"linear": "5 N s/m", "quadratic": "300 N s^2/m^2"}},
        "stops": {"arm_angle": ["25 deg", "45 deg"]},
        "dry_friction": {"arm_angle": "1 N m"},
    }
    run = run_scene(
        engine,
        effects,
        dimensions=PORTER | {"offset": "30 mm", "arm_joint": "200 mm", "link": "180 mm"},
        spindle={"speed": "103.7 rpm"},
        start={"arm_angle": "30 deg", "arm_rate": "0.15 rad/s"},
    )
    assert run.outcome is gm.Outcome.DONE


@pytest.mark.parametrize(("engine", "clearance"), [("multibody", "3 mm"), ("multibody", False), ("reduced", False)])
def test_dead_centre_of_the_link_ends_a_run_with_a_named_outcome(engine, clearance):
    run = run_scene(
        engine,
        {"clearance": clearance, "dry_friction": {"sleeve": "1 N"}},
        dimensions=CROSSED | {"sleeve_mass": "5 kg"},
        spindle={"speed": "121.7 rpm"},
        start={"arm_angle": "30.5 deg", "arm_rate": "-0.5 rad/s"},
    )
    assert run.outcome is gm.Outcome.LEFT_RANGE
    assert "the link is at 90 degrees to the spindle" in run.message


@pytest.mark.parametrize(("engine", "clearance"), [("multibody", "1 mm"), ("multibody", False), ("reduced", False)])
def test_very_short_run_completes(engine, clearance):
    effects = {"dry_friction": {"sleeve": "40 N"}, "clearance": clearance, "stops": {"arm_angle": ["29.9 deg", "45 deg"]}}
    assert gm.run(scene(effects, duration="1e-9 s", output_interval="1e-9 s"), engine=engine).outcome is gm.Outcome.DONE


def test_an_equilibrium_with_play_is_refused_because_of_the_play():
    with pytest.raises(gm.MechanismError, match="not determined with clearance"):
        gm.run(scene({"clearance": "1 mm"}, start={"arm_angle": "equilibrium"}))
