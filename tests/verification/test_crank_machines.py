"""Cross-checks of the driven crank machines: planted errors are found, and what is left out is said."""

import pytest

import governor_mechanism as gm
from crank_scenes import SLIDER_CRANK_MASSES, crank_scene, valve_scene
from governor_mechanism.machines.slide_valve import EQUAL_CUT_OFFS
from governor_mechanism.verification.machines import slide_valve, slider_crank

SETTINGS = {
    "equal cut-offs": {"setting": EQUAL_CUT_OFFS},
    "middle": {"setting": "middle of extremes"},
    "infinitely long rods": {"eccentric_rod": None, "connecting_rod": None},
    "from elsewhere": {"crank_start": "200 deg", "inside_lap": -0.003},
}


def failed(report):
    return [row.quantity.split(" (")[0] for row in report.rows if not row.passed]


@pytest.mark.long
@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("engine", ["impulse", "multibody"])
def test_every_setting_agrees_in_both_engines(name, engine):
    report = gm.crosscheck(valve_scene(SETTINGS[name], engine=engine, accuracy=1e-7, duration=0.65))  # a little more than one turn
    assert report.passed, str(report)
    assert len(report.rows) >= 20
    assert sum("in motion" in row.quantity for row in report.rows) == 10  # both ways, and all eight events


def test_a_wrong_law_of_cosines_is_found(monkeypatch):
    right = slide_valve.closed.event_angle
    monkeypatch.setattr(slide_valve.closed, "event_angle", lambda *a, **k: right(*a, **k) + 1e-9)
    assert len(failed(gm.crosscheck(valve_scene()))) == 8  # those in motion are promised to 1e-6 only


def test_a_wrong_centre_is_found(monkeypatch):
    right = slide_valve.closed.equal_lead_centre
    monkeypatch.setattr(slide_valve.closed, "equal_lead_centre", lambda one: right(one) + 1e-9)
    names = failed(gm.crosscheck(valve_scene()))
    assert {"valve position", "lead at the crank end", "lead at the head end", "centre of the swing for equal leads"} <= {*names}


def test_a_wrong_acceleration_of_the_piston_is_found(monkeypatch):
    right = slide_valve.crank.crosshead_acceleration
    monkeypatch.setattr(slide_valve.crank, "crosshead_acceleration", lambda *a, **k: right(*a, **k) * (1 + 1e-8))
    assert failed(gm.crosscheck(valve_scene())) == ["piston acceleration"]


def test_a_run_worse_than_asked_is_found(monkeypatch):
    monkeypatch.setattr(slide_valve, "crank_angles", lambda scene, run: 10.0 * run.times + 1e-4)
    assert {"valve displacement in motion", "head end travel in motion"} <= {*failed(gm.crosscheck(valve_scene()))}


def test_the_loads_are_checked_and_a_wrong_mass_is_found(monkeypatch):
    scene = crank_scene(effects={"gravity": True, "masses": SLIDER_CRANK_MASSES}, accuracy=1e-9)
    report = gm.crosscheck(scene)
    assert report.passed, str(report)
    assert len(report.rows) == 15
    right = slider_crank.closed.bearing_loads

    def heavier(train, **moving):
        return right(slider_crank.closed.CrankTrain(**(vars(train) | {"rod_inertia": 1.0001 * train.rod_inertia})), **moving)

    monkeypatch.setattr(slider_crank.closed, "bearing_loads", heavier)
    assert {"shaft, y", "crank pin, y", "gudgeon, y", "crosshead guide"} <= {*failed(gm.crosscheck(scene))}


@pytest.mark.parametrize(
    ("effects", "note"),
    [
        ({}, "no part has mass"),
        ({"masses": {"crank": 9.0, "rod": 3.0}}, "'gudgeon' does not join two parts with mass"),
        ({"masses": SLIDER_CRANK_MASSES, "spring": {"crosshead_distance": {"rate": 10.0}}}, "other forces act"),
    ],
)
def test_what_is_left_out_is_said(effects, note):
    report = gm.crosscheck(crank_scene(effects=effects, engine="multibody"))
    assert report.passed, str(report)
    assert any(note in one for one in report.notes)
