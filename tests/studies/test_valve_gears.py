"""The shipped valve gears: their motion by another solver, events that an engine can use, and the classical laws of their leads."""

import json
import math
from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from closure_solver import ClosureEquations, si
from command_line import invoke
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.render.figures.plates.reversed_gear import valve_gears_figure
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.studies.valve_gears import ValveGears
from refusing import refuses

GEARS = ["gooch", "allan", "walschaerts", "joy"]


@cache
def gear(name: str):
    return gm.valve_gears([name], count=5).gears[0]


@pytest.mark.parametrize("name", GEARS)
def test_valve_and_piston_move_as_by_root_finding_on_the_closure_equations(name):
    closure, scene = ClosureEquations(shipped_scenes()[name]), gm.load(name)
    angles = np.linspace(0.0, math.tau, 25)
    drivers = [joint for joint in closure.document["joint"] if joint["type"] == "driven_turn" and joint["name"] != "engine"]
    # A harmonic of phase 90 deg begins at its amplitude.
    held = {one["name"]: si(one["motion"]["start"]) + si(one["motion"]["harmonics"][0]["amplitude"]) for one in drivers}
    poses = closure.turn("engine", angles, held)
    readings = valve_motion_of(scene).evaluate(angles).readings
    along = 1.0 if name in ("walschaerts", "joy") else np.exp(-1j * math.radians(20.0))
    valve = [(complex(*pose["valve"][:2]) * along).real for pose in poses]
    np.testing.assert_allclose(readings["valve"], valve, rtol=0, atol=1e-11)  # the tolerance of the root finding, over a few lengths
    np.testing.assert_allclose(readings["piston"], [pose["crosshead"][0] for pose in poses], rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", GEARS)
def test_events_in_full_gear_are_those_of_a_good_engine(name):
    timing = gm.valve_timing(name)
    assert len(timing.rows) == 8
    assert not timing.statements
    for end, dead_centre in (("crank end", 0.0), ("head end", math.pi)):
        row = {event.name.removeprefix(f"{end} "): event for event in timing.rows if event.name.startswith(end)}
        assert math.radians(-10) < math.remainder(row["admission"].simulated - dead_centre, math.tau) < 0  # shortly before the dead centre
        assert 0.75 < row["cut-off"].simulated_stroke < 0.85
        assert row["cut-off"].simulated_stroke < row["release"].simulated_stroke < 0.97
        assert 0.03 < row["compression"].simulated_stroke < 0.15
    assert abs(timing.leads[0] - timing.leads[1]) < 1.1e-3


@pytest.mark.parametrize("name", GEARS)
def test_travel_and_cut_off_shrink_toward_mid_gear_in_both_directions(name):
    found = gear(name)
    np.testing.assert_allclose(found.positions, [1.0, 0.5, 0.0, -0.5, -1.0], atol=1e-12)
    for values in (found.travel, found.cut_offs.mean(axis=1)):
        assert values[0] > values[1] > values[2] < values[3] < values[4]
    # In mid gear the crosshead or the eccentrics' advance alone move the valve: by lap and lead to each side.
    assert found.travel[2] == pytest.approx(2 * (0.024 + found.leads[2].mean()), rel=0.01)


@pytest.mark.parametrize(("name", "allowed"), [("gooch", 1e-5), ("walschaerts", 5e-5), ("joy", 1e-6)])
def test_the_lead_is_the_same_in_every_gear(name, allowed):
    """Exactly so where nothing leans at a dead centre; Gooch's hanger and the union link lean a little."""
    leads = gear(name).leads.mean(axis=1)
    assert np.ptp(leads) < allowed
    np.testing.assert_allclose(leads, 0.006, atol=1e-4)  # lengths in the files are rounded


def test_allans_lead_grows_toward_mid_gear_by_zeuners_law():
    """The lead changes by (u u1 / c l) r cos(advance), with the link shifted by u1 and the block by u in it."""
    leads = gear("allan").leads.mean(axis=1)
    advance, shift = math.radians(25.0), 0.14
    link_share = 1 - 1 / math.sqrt(1 + 1.2 / 0.9)  # of the shift, for a valve that keeps its centre
    expected = shift**2 * link_share / (0.15 * 1.2) * 0.06 * math.cos(advance)
    assert leads[2] - (leads[0] + leads[4]) / 2 == pytest.approx(expected, rel=0.1)  # a law of the first order
    assert leads[2] > leads[1] > leads[0]
    stephenson = shift**2 / (0.15 * 1.2) * 0.06 * math.cos(advance)
    assert 0 < expected < 0.5 * stephenson


def test_allans_arms_keep_the_centre_of_the_valve():
    """Zeuner: of the second order, the middle of both dead centres does not move; it does by 9 mm if the link alone is shifted."""
    centres = [gm.valve_timing(gear("allan").scenes[k]).leads for k in range(5)]
    assert max(abs(one - other) / 2 for one, other in centres) < 0.6e-3


def test_back_gear_is_forward_gear_of_an_engine_that_turns_backward():
    gooch = gear("gooch")
    assert gooch.cut_offs[4].mean() == pytest.approx(gooch.cut_offs[0].mean(), abs=0.02)
    assert not np.isnan(gooch.cut_offs).any()


def test_the_table_shows_both_ends_of_the_cylinder():
    (half,) = [line for line in str(gm.valve_gears(["stephenson_arc_middle"], count=5)).splitlines() if "+0.50" in line]
    timing = gm.valve_timing(gm.load("stephenson_arc_middle").replace({"dimensions.reverser": 0.5}))
    cut_offs = [row.simulated_stroke for row in timing.rows if row.name == "cut-off"]
    assert " / ".join(f"{100 * cut_off:.2f}" for cut_off in cut_offs) in half


def test_the_figure_shows_every_gear_in_both_directions():
    study = ValveGears(gears=tuple(map(gear, GEARS)))
    figure = valve_gears_figure(study)
    assert figure.texts[0].get_text() == "Four valve gears compared"
    leads, travels, _ = figure.axes
    for axes, ordinates in ((leads, "leads"), (travels, "travel")):
        curves = [line for line in axes.lines if len(line.get_xdata()) == 3]
        assert len(curves) == 2 * len(GEARS)
        for one, forward, back in zip(study.gears, curves[::2], curves[1::2], strict=True):
            values = 1e3 * (one.leads.mean(axis=1) if ordinates == "leads" else one.travel)
            np.testing.assert_allclose([*forward.get_ydata(), *back.get_ydata()[1:]], values, rtol=1e-12)
            np.testing.assert_allclose(forward.get_xdata(), 100 * one.cut_offs.mean(axis=1)[:3], rtol=1e-12)


def test_the_command_writes_figure_and_record(tmp_path):
    result = invoke("valve-gears", "gooch", "joy", "--count", "3", "--json", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    gears = json.loads(result.stdout)["gears"]
    assert [len(one["positions"]) for one in gears] == [3, 3]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["valve_gears.json", "valve_gears.png"]
    assert json.loads((tmp_path / "valve_gears.json").read_text())["gears"] == gears


@pytest.mark.parametrize("count", [1, 2.5])
def test_a_single_position_is_refused_and_part_of_one(count):
    refuses(f"a whole number of at least 2; found {count}", gm.valve_gears, "gooch", count=count)
