"""Studies of a link motion: events in every gear, the paths of its die, sweeps over the lever."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from crank_scenes import link_gear_scene, valve_scene
from governor_mechanism.closed_form import stephenson as closed
from governor_mechanism.studies.valve_gears import trace_die_paths
from reference import stephenson as printed
from refusing import refuses


@pytest.fixture(scope="module")
def gear():
    return gm.valve_gears([link_gear_scene()], 5).gears[0]


def test_leads_in_every_gear_are_those_of_the_closed_form(gear):
    """In back gear the crank turns the other way; its dead centres are the same."""
    scene = link_gear_scene()
    link_gear, centre = closed.LinkGear.from_dimensions(scene.part.dimensions), scene.part.dimensions["centre"]
    positions = closed.link_position(link_gear, crank_angle=np.array([[0.0], [math.pi]]), gear=gear.positions).valve - centre
    np.testing.assert_allclose(gear.leads, np.array([positions[0], -positions[1]]).T - 0.024, atol=1e-12)


def test_with_open_rods_the_lead_is_largest_in_mid_gear_and_the_travel_smallest(gear):
    leads, travel = gear.leads.mean(axis=1), gear.travel
    assert leads[0] < leads[1] < leads[2] > leads[3] > leads[4]
    assert travel[0] > travel[1] > travel[2] < travel[3] < travel[4]
    crossed = gm.valve_gears([link_gear_scene({"rods": "crossed"})], 5).gears[0].leads.mean(axis=1)
    assert crossed[0] > crossed[1] > crossed[2]


def test_the_table_of_events_has_a_column_for_each_gear(gear):
    lines = gear.format_events().splitlines()
    assert lines[1].split("gear ")[1:] == ["+1.00       ", "+0.50       ", "+0.00       ", "-0.50       ", "-1.00"]
    assert len({len(line) for line in lines[1:-1]}) == 1
    assert len(lines) == 14
    assert lines[3].startswith("crank end cut-off")


def test_die_paths_have_the_slips_of_the_table():
    paths = {one.suspension: one for one in trace_die_paths(link_gear_scene(), np.array([1.0, 0.0, -1.0]))}
    assert list(paths) == ["arc middle", "chord middle", "lower pin", "half-way"]
    for suspension, gear, _, _, slip_range, *_ in printed.ROWS:
        # 181 angles instead of 720 miss an extreme by up to (2 deg)^2 / 8 of the slip
        assert 1e3 * paths[suspension].slips[1 - gear] == pytest.approx(slip_range, rel=5e-4)


def test_a_suspension_of_the_scene_s_own_comes_last():
    scene = link_gear_scene({"suspension": "point", "suspension_x": -0.02, "suspension_y": -0.03})
    paths = trace_die_paths(scene, np.array([0.0]))
    assert [one.suspension for one in paths][-1] == "point"
    refuses("die paths need a scene file with machine 'stephenson'", trace_die_paths, valve_scene())


def test_a_sweep_over_the_lever_gives_travel_leads_cut_offs_and_slip():
    sweep = gm.sweep(link_gear_scene(duration=0.63, output_interval=0.0025), {"dimensions.reverser": [1.0, 0.0]})
    names = [one.name for one in sweep.quantities]
    assert names == ["valve travel", "crank end lead", "head end lead", "crank end cut-off", "head end cut-off", "span die_slip"]
    for k, position in ((0, 1.0), (1, 0.0)):
        timing = gm.valve_timing(link_gear_scene({"reverser": position}))
        strokes = {row.name: row.simulated_stroke for row in timing.rows}
        assert sweep.column("valve travel")[k] == pytest.approx(timing.travel, rel=1e-12)
        assert sweep.column("head end lead")[k] == pytest.approx(timing.leads[1], rel=1e-12)
        assert sweep.column("crank end cut-off")[k] == pytest.approx(strokes["crank end cut-off"], rel=1e-12)
    slips = {row[1]: row[4] for row in printed.ROWS if row[0] == "arc middle"}
    # a little more than a turn, reported every 0.025 rad: extremes of the first four harmonics are missed by (4 x 0.0125)^2 / 2 or less
    np.testing.assert_allclose(1e3 * sweep.column("span die_slip"), [slips[1], slips[0]], rtol=2e-3)


def test_a_cut_off_that_there_is_not_is_a_row_with_a_sentence():
    sweep = gm.sweep(link_gear_scene({"outside_lap": 0.05}, duration=0.05), {"dimensions.reverser": [1.0, 0.0]})
    assert sweep.rows[0].ok
    assert "there is no crank end cut-off: the steam port of the crank end does not open once in a turn" in sweep.rows[1].message
