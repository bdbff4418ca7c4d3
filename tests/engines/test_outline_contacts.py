"""Rollers on outlines: motions in closed form and by scipy, impacts, releases at edges, hard cases."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import governor_mechanism as gm
from contact_scenes import (
    BOWL,
    CUP,
    DISC,
    FLOOR,
    GRAVITY,
    READINGS,
    ROLLER,
    ball_document,
    bounce_on_disc,
    events_of,
    readings_of,
    run_ball,
    start_of,
)
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.model.events import EventKind
from governor_mechanism.studies.hard_cases.study import HARD_CASES


@pytest.mark.parametrize("outline", [DISC, {"curve": {"radius": 0.1}}], ids=["arc", "curve"])
def test_a_ball_that_bounces_on_a_disc_follows_the_motion_that_scipy_integrates(outline):
    place, rates = (0.013, 0.25), (0.0, 0.0)
    run = run_ball(outline, place, rates, restitution=0.5)
    states, impacts = bounce_on_disc(place, rates, 0.5, run.times)
    assert run.outcome is gm.Outcome.DONE
    assert len(impacts) == 2
    assert events_of(run, EventKind.IMPACT) == pytest.approx(impacts, abs=1e-12)
    for name, column in (("x", 0), ("y", 1)):
        np.testing.assert_allclose(run.readings[name], states[:, column], atol=1e-11)
        np.testing.assert_allclose(run.rates[name], states[:, column + 2], atol=1e-10)


@pytest.mark.parametrize("outline", [DISC, {"curve": {"radius": 0.1}}], ids=["arc", "curve"])
def test_a_ball_slides_off_a_disc_where_its_weight_no_longer_bends_its_path(outline):
    """Energy and Newton's law give cos(angle) = (2 + v^2 / (g R)) / 3."""
    speed, radius = 0.2, 0.1 + ROLLER
    document = ball_document(outline, (0.0, radius), (speed, 0.0))
    run = gm.run(gm.Scene.from_dict(document))
    (separation,) = events_of(run, EventKind.SEPARATION)
    place = gm.run(gm.Scene.from_dict(document), times=[0.0, separation])
    cosine = (2 + speed**2 / (GRAVITY * radius)) / 3
    assert place.readings["y"][-1] == pytest.approx(radius * cosine, abs=1e-10)
    assert np.hypot(place.rates["x"][-1], place.rates["y"][-1]) ** 2 == pytest.approx(GRAVITY * radius * cosine, rel=1e-8)


def test_a_drive_does_the_work_that_an_impact_asks_of_it():
    """A table that a drive swings strikes a ball: kinetic and potential energy change by its work and by the loss of the impacts alone."""
    ground = {"O": [0.0, {"harmonics": [{"amplitude": "2 mm", "frequency": "10 Hz"}]}]}
    document = ball_document(FLOOR, (0.0, 0.025), (0.0, 0.0), restitution=0.5)
    run = gm.run(gm.Scene.from_dict({**document, "ground": ground}), accuracy=1e-8)
    assert len(events_of(run, EventKind.IMPACT)) > 5
    assert run.energy.dissipated_energy[-1] > 0.01
    np.testing.assert_allclose(run.energy.jacobi, run.energy.jacobi[0], atol=1e-9)


def test_a_ball_in_a_bowl_is_a_pendulum():
    length, angle = 0.15 - ROLLER, 1.0
    run = run_ball(BOWL, (length * math.sin(angle), -length * math.cos(angle)))
    exact = solve_ivp(lambda t, y: [y[1], -GRAVITY / length * math.sin(y[0])], (0, 1), [angle, 0], rtol=1e-13, atol=1e-14, t_eval=run.times)
    assert not run.events
    np.testing.assert_allclose(run.readings["x"], length * np.sin(exact.y[0]), atol=1e-10)
    np.testing.assert_allclose(run.readings["y"], -length * np.cos(exact.y[0]), atol=1e-10)
    assert np.abs(run.readings["ball_gap"]).max() < 1e-15


def test_a_ball_leaves_a_slope_at_its_end_at_once():
    slope, top, way = math.radians(30), 0.3, 0.25
    along, normal = np.array([math.cos(slope), -math.sin(slope)]), np.array([math.sin(slope), math.cos(slope)])
    place = np.array([0, top * math.sin(slope)]) + ROLLER * normal + (top - way) * along
    run = run_ball([[0, 0], [top * math.cos(slope), 0], [0, top * math.sin(slope)]], place)
    (separation,) = events_of(run, EventKind.SEPARATION)
    assert separation == pytest.approx(math.sqrt(2 * way / (GRAVITY * math.sin(slope))), abs=1e-12)


@pytest.mark.parametrize("accuracy", [1e-4, 1e-8, 1e-11])
def test_a_ball_passes_the_joins_of_edges_at_any_accuracy_without_an_event(accuracy):
    case = HARD_CASES["fillet"]
    for radius in case.values:
        run = gm.run(gm.Scene.from_dict(case.make_document(radius)), accuracy=accuracy)
        assert run.outcome is gm.Outcome.DONE
        assert not run.events
        for name, (values, rates) in case.solve(radius, run.times).items():
            np.testing.assert_allclose(run.readings[name], values, atol=run.error_estimate * run.scales[name])
            np.testing.assert_allclose(run.rates[name], rates, atol=10 * run.error_estimate)
        assert run.cost.rejected < 100  # a step over a join would be tried again and again


def test_impulse_passes_an_arc_shorter_than_its_steps():
    """The steps of all runs of a certificate are shorter on the arc, else all would turn its corner in one step and agree."""
    case = HARD_CASES["fillet"]
    run = ImpulseEngine().run(gm.Scene.from_dict(case.make_document(0.021)))
    for name, (values, rates) in case.solve(0.021, run.times).items():
        np.testing.assert_allclose(run.readings[name], values, atol=run.error_estimate * run.scales[name])
        np.testing.assert_allclose(run.rates[name], rates, atol=10 * run.error_estimate)
    assert run.error_estimate < 1e-3


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_ball_that_climbs_over_a_fillet_comes_back_as_it_went(mirrored):
    """Up a floor, an arc and a slope and back: without losses the way back is the way up, whichever way round the outline runs."""
    radius, speed, way = 0.05, 1.5, 0.2
    document = HARD_CASES["fillet"].make_document(radius)
    sign = 1 if mirrored else -1
    outline = [[-sign * x, y, *rest] for x, y, *rest in document["body"][0]["outline"]]
    document["body"][0]["outline"] = outline
    document["body"][1]["at"] = [-sign * way, ROLLER]
    document["effects"]["gravity"] = GRAVITY
    document["start"] = {"x": -sign * way, "y": ROLLER, "x_rate": sign * speed, "y_rate": 0.0}
    document["run"] = {"duration": 3.0, "output_interval": 0.01, "accuracy": 1e-10}
    scene = gm.Scene.from_dict(document)
    slope, path = math.radians(30), radius - ROLLER
    after = math.sqrt(speed**2 - 2 * GRAVITY * path * (1 - math.cos(slope)))
    in_arc = quad(lambda at: path / math.sqrt(speed**2 - 2 * GRAVITY * path * (1 - math.cos(at))), 0, slope, epsabs=1e-14)[0]
    top = way / speed + in_arc + after / (GRAVITY * math.sin(slope))
    run = gm.run(scene, times=[0.0, top, 2 * top])
    height = ROLLER + speed**2 / (2 * GRAVITY)
    assert not run.events
    assert run.readings["y"][1] == pytest.approx(height, abs=1e-10)
    assert np.hypot(run.rates["x"][1], run.rates["y"][1]) < 1e-8
    assert run.readings["x"][2] == pytest.approx(-sign * way, abs=1e-9)
    assert run.rates["x"][2] == pytest.approx(-sign * speed, abs=1e-9)


def test_bounces_in_a_pit_end_when_the_geometric_series_of_their_times_does():
    height, restitution = 0.1, 0.5
    run = run_ball(CUP, (0.0, ROLLER + height), restitution=restitution)
    fall = math.sqrt(2 * height / GRAVITY)
    assert events_of(run, EventKind.REST) == pytest.approx([fall * (1 + restitution) / (1 - restitution)], abs=1e-9)
    impacts = events_of(run, EventKind.IMPACT)
    series = [fall * (1 + 2 * (1 - restitution**k) / (1 - restitution) * restitution) for k in range(4)]
    assert impacts[:4] == pytest.approx(series, abs=1e-12)
    assert run.readings["y"][-1] == pytest.approx(ROLLER, abs=1e-14)


def test_a_ball_that_hits_a_corner_exactly_jumps_back_on_its_way():
    box = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0], [-0.1, 0]]
    run = run_ball(box, (0.1, ROLLER + 0.1), restitution=1.0)
    fall = math.sqrt(2 * 0.1 / GRAVITY)
    assert events_of(run, EventKind.IMPACT) == pytest.approx([fall, 3 * fall, 5 * fall, 7 * fall][: len(run.events)], abs=1e-9)
    assert np.abs(run.readings["x"] - 0.1).max() < 1e-10  # it is not stable: rounding grows


def test_a_ball_that_hits_a_corner_beside_its_middle_is_turned_by_the_normal_there():
    box, offset, height = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0], [-0.1, 0]], 0.012, 0.1
    lift = math.sqrt(ROLLER**2 - offset**2)  # of the centre above the corner at the impact
    run = run_ball(box, (0.1 + offset, lift + height), restitution=1.0)
    (impact,) = events_of(run, EventKind.IMPACT)
    assert impact == pytest.approx(math.sqrt(2 * height / GRAVITY), abs=1e-12)
    normal, velocity = np.array([offset, lift]) / ROLLER, np.array([0.0, -GRAVITY * impact])
    after = velocity - 2 * (normal @ velocity) * normal
    np.testing.assert_allclose([run.rates["x"][-1], run.rates["y"][-1]], [after[0], after[1] - GRAVITY * (1 - impact)], atol=1e-9)


def test_a_gap_of_a_nanometre_closes_by_one_impact():
    run = run_ball(CUP, (0.0, ROLLER + 1e-9))
    assert events_of(run, EventKind.IMPACT) == pytest.approx([math.sqrt(2e-9 / GRAVITY)], rel=1e-7)  # rounding of 0.02 m + 1e-9 m
    assert len(events_of(run, EventKind.REST)) == 1


def test_momentum_and_energy_of_an_oblique_impact_of_two_free_bodies():
    restitution, mass, inertia, box_mass, box_inertia = 0.6, 0.5, 2e-4, 2.0, 3e-3
    side = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]
    starts = {"box": (0.0, 0.1, 1.0), "ball": (0.3, -2.0, 5.0)}
    document = {
        "machine": "custom",
        "size": 0.1,
        "body": [
            {"name": "box", "mass": box_mass, "inertia": box_inertia, "outline": side, "angle": 0.3},
            {"name": "ball", "mass": mass, "inertia": inertia, "at": [0.02, 0.2], "points": {"tip": [0.01, -0.02]}},
        ],
        "force": [{"type": "spring", "first": "ground.origin", "second": "box.origin", "stiffness": 1e-9}],
        "contact": [{"name": "hit", "first": "ball.tip", "radius": 0.01, "second": "box", "restitution": restitution}],
        "readings": {f"{name}_{key}": table for name in starts for key, table in readings_of(name).items()},
        "start": {f"{name}_{key}_rate": rate for name, rates in starts.items() for key, rate in zip(READINGS, rates, strict=True)},
        "run": {"duration": 0.2, "output_interval": 0.01, "accuracy": 1e-9},
    }
    run = gm.run(gm.Scene.from_dict(document))
    impact = events_of(run, EventKind.IMPACT)[0]
    around = gm.run(gm.Scene.from_dict(document), times=[0.0, impact - 1e-9, impact + 1e-9])
    x, y, turn = (np.array([around.rates[f"{name}_{part}"] for name in ("box", "ball")]) for part in ("x", "y", "turn"))
    px, py = (np.array([around.readings[f"{name}_{part}"] for name in ("box", "ball")]) for part in "xy")
    masses, inertias = np.array([[box_mass], [mass]]), np.array([[box_inertia], [inertia]])
    angular = (masses * (px * y - py * x) + inertias * turn).sum(axis=0)
    for kept in ((masses * x).sum(axis=0), (masses * y).sum(axis=0), angular):
        np.testing.assert_allclose(kept[1:], kept[0], atol=1e-8)
    gap_rates = around.rates["hit_gap"]
    assert gap_rates[2] == pytest.approx(-restitution * gap_rates[1], abs=1e-6)
    assert abs(x[0, 2] - x[0, 1]) > 0.01
    assert run.energy.drift < 1e-8


def test_what_overlaps_at_the_start_is_refused_with_depth_and_place():
    with pytest.raises(gm.MechanismError, match=r"contact 'ball', with its centre at \(0 mm, 15 mm\), overlaps .*'block' by 5 mm"):
        run_ball(CUP, (0.0, 0.015))
    with pytest.raises(gm.MechanismError, match=r"centre at \(0 mm, -5 mm\), overlaps the outline of 'block' by 25 mm"):
        run_ball(CUP, (0.0, -0.005))


@pytest.mark.parametrize(("place", "rates"), [((0.05, 0.01), (0.0, -20.0)), ((0.09, 0.01), (10.0, -10.0))], ids=["bottom", "hollow corner"])
def test_a_small_fast_roller_strikes_a_pit_through_which_a_step_would_lead(place, rates):
    """The roller is 0.1 mm wide, and moves by millimetres from one sample of a step to the next."""
    run = run_ball(CUP, place, rates, radius=5e-5)
    wait = rates[1] / GRAVITY
    strike = wait + math.sqrt(wait**2 + 2 * (0.01 - 5e-5) / GRAVITY)
    assert events_of(run, EventKind.IMPACT)[0] == pytest.approx(strike, rel=1e-9)
    assert min(run.readings[name].min() for name in ("ball_gap_1", "ball_gap_2")) > -1e-12


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("shift", [0.0, 1e-12, 1e-9])
def test_a_square_that_falls_corner_on_corner_bounces_by_its_restitution(shift, friction):
    """Rounded corners of each touch the outline of the other one: both contacts strike at once, and share the impulse."""
    side, tip, drop, restitution = 0.1, 1e-3, 0.1, 0.5
    square = [[-side, -side], [side, -side], [side, side], [-side, side]]
    place, centre = side - tip, 2 * math.sqrt(2) * side
    bodies = [
        {"name": name, "mass": 1.0, "inertia": 0.01, "at": at, "angle": math.pi / 4, "outline": square}
        for name, at in (("below", [0.0, 0.0]), ("above", [shift, centre + drop]))
    ]
    corner = {"radius": tip, "repeat": 4, "restitution": restitution, "friction": friction}
    pairs = (("below", "above"), ("above", "below"))
    contacts = [{"name": one, "first": [one, place, place], "second": other, **corner} for one, other in pairs]
    document = ball_document(square, (0.0, 0.0)) | {"body": bodies, "contact": contacts}
    document["joint"] = [{"type": "weld", "first": "ground.O", "second": "below.origin"}]
    document["readings"], document["start"] = readings_of("above"), start_of((shift, centre + drop, math.pi / 4), (0.0, 0.0, 0.0))
    scene = gm.Scene.from_dict(document)
    # A rounded corner, which ends below the sharp one, strikes a sharp one.
    fall = math.sqrt(2 * (drop + (math.sqrt(2) - 1) * tip) / GRAVITY)
    run = gm.run(scene, times=np.linspace(0.0, 2.2 * fall, 23), accuracy=1e-8)
    assert run.outcome is gm.Outcome.DONE
    impacts = sorted({round(time, 8) for time in events_of(run, EventKind.IMPACT)})
    assert impacts == pytest.approx([fall, 2 * fall], abs=1e-6)
    assert run.energy.drift < 1e-8
    assert min(values.min() for name, values in run.readings.items() if "gap" in name) > -1e-11
