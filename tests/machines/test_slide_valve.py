"""The slide valve as a mechanism: tables by kinematics, settings, events, both engines, stand-in masses, refusals."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import governor_mechanism as gm
from crank_scenes import SLIDE_VALVE_DIMENSIONS, valve_scene
from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slide_valve import Eccentric
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.slide_valve import EQUAL_CUT_OFFS, SlideValve
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.valve import EQUAL_LEADS, MIDDLE
from governor_mechanism.observables.valve_motion import find_event_angles, valve_motion_of
from governor_mechanism.studies.valve_gears import tabulate_valve_timing
from reference import marks
from refusing import refuses

SIZES = {**SLIDE_VALVE_DIMENSIONS, "advance": math.radians(30.0)}
RATIOS = {4: 0.24, 30: 1.8}


def of_ratio(ratio: int):
    return valve_scene({"eccentric_rod": RATIOS[ratio]})


def machine(**changes) -> SlideValve:
    return SlideValve(**(SIZES | changes))


@cache
def timing_of(**changes):
    return tabulate_valve_timing(valve_scene(changes))


@pytest.mark.parametrize("ratio", RATIOS)
def test_every_event_of_the_tables_is_met_by_the_mechanism(ratio):
    found = timing_of(eccentric_rod=RATIOS[ratio])
    for row, printed in zip(found.rows, marks.VALVE_EVENTS[ratio], strict=True):
        assert row.name == printed[0]
        assert abs(row.simulated - math.radians(printed[2])) < 1e-10  # promised
        assert abs(row.simulated_stroke - printed[8]) < 1e-10
        assert abs(row.shift - math.radians(printed[4])) < 1e-10
        assert abs(row.theory - math.radians(printed[1])) < 1e-10


def test_the_events_without_rods_and_with_one_are_met():
    """The other columns of the table: strokes with an endless rod on one side or on both."""
    columns = {(None, None): 5, ("finite", None): 6, (None, "finite"): 7}
    for (eccentric, connecting), column in columns.items():
        rods = {"eccentric_rod": RATIOS[4] if eccentric else None} | ({} if connecting else {"connecting_rod": None})
        found = timing_of(**rods)
        for row, printed in zip(found.rows, marks.VALVE_EVENTS[4], strict=True):
            assert abs(row.simulated_stroke - printed[column]) < 1e-10


def test_the_error_table_is_met_by_the_mechanism():
    angles = np.radians([row[0] for row in marks.ERROR_TERMS])
    found = gm.kinematics(of_ratio(4), over="crank_angle", values=angles).readings["valve_displacement"]
    for value, row in zip(found, marks.ERROR_TERMS, strict=True):
        assert abs(value - row[2]) < 1e-10 * 0.06
        assert abs(value - row[1] - row[3]) < 1e-10 * 0.06


def test_the_motion_of_the_eccentric_is_met_by_the_mechanism():
    rows = marks.ECCENTRIC_MOTION
    found = gm.kinematics(of_ratio(4), over="crank_angle", values=np.radians([row[0] for row in rows]), rate=10.0)
    centre = marks.ERROR_TERM_SIZES[4]["centre"]
    for k, (_, place, speed, bend) in enumerate(rows):
        assert abs(found.readings["valve_displacement"][k] + centre - place) < 1e-10 * 0.06
        assert abs(found.rates["valve_displacement"][k] - speed) < 1e-10 * 0.6
        assert abs(found.reading_accelerations["valve_displacement"][k] - bend) < 1e-10 * 6.0


def test_both_ways_of_the_piston_make_up_the_stroke_and_ports_open_by_displacement_less_lap():
    found = gm.kinematics(of_ratio(4), over="crank_angle", values=np.linspace(0, 6, 25)).readings
    moved = found["valve_displacement"]
    np.testing.assert_allclose(found["crank_end_travel"] + found["head_end_travel"], 0.6, atol=1e-14)  # rounding
    for name, opening in {
        "crank_end_steam": moved - 0.024,
        "crank_end_exhaust": -moved - 0.005,
        "head_end_steam": -moved - 0.024,
        "head_end_exhaust": moved - 0.005,
    }.items():
        np.testing.assert_allclose(found[name], opening, atol=1e-15)


def test_the_settings_do_what_they_say():
    first, second = timing_of(setting=EQUAL_LEADS).leads
    assert abs(first - 0.006) < 1e-14
    assert abs(second - 0.006) < 1e-14
    for lead, printed in zip(timing_of(setting=MIDDLE).leads, marks.ERROR_TERM_SIZES[4]["leads_from_middle"], strict=True):
        # the table is by the binomial law, which neglects r^4 / 8 l^3
        assert abs(lead - printed) < marks.ERROR_TERM_SIZES[4]["largest_neglected"]
    rows = {row.name: row for row in timing_of(setting=EQUAL_CUT_OFFS, eccentric_rod=RATIOS[4]).rows}
    fills = [rows[f"{end} cut-off"].simulated_stroke for end in ("crank end", "head end")]
    assert abs(fills[0] - fills[1]) < 1e-12  # bisected to rounding
    assert 0.7 < fills[0] < 0.9


@pytest.mark.parametrize("ratio", RATIOS)
def test_equal_cut_offs_are_those_of_the_closed_form_and_cost_equal_leads(ratio):
    changes = {"setting": EQUAL_CUT_OFFS, "eccentric_rod": RATIOS[ratio]}
    scene = valve_scene(changes)
    eccentric, train = (Eccentric.from_dimensions(scene.part.dimensions), CrankTrain.from_dimensions(scene.part.dimensions))
    laps = {"outside_lap": 0.024, "inside_lap": 0.005}

    def fills_part(centre):
        first, second = (closed.event_angle(eccentric, event=f"{end} cut-off", centre=centre, **laps) for end in ("crank end", "head end"))
        return (
            0.6
            - travel_from_outer_dead_centre(train, crank_angle=first + math.pi)
            - travel_from_outer_dead_centre(train, crank_angle=second + math.pi)
        )

    centre = brentq(fills_part, eccentric.rod - 0.02, eccentric.rod + 0.02, xtol=1e-15)
    # where the fills part by nothing: 1e-16 of lengths near 2 m
    assert abs(scene.part.dimensions["centre"] - centre) < 1e-13
    # The shorter fill, at the crank end, is made longer by opening its port sooner.
    first, second = timing_of(**changes).leads
    assert first > second


def test_the_two_ends_answer_as_the_formula_and_not_as_the_sentence():
    """On the mechanism: compression goes the way of fill and pre-admission, against displacement and pre-release."""
    found = {row.name: row.shift for row in timing_of(eccentric_rod=RATIOS[4], connecting_rod=None).rows}
    for end, sign in (("crank end", 1), ("head end", -1)):
        assert sign * found[f"{end} cut-off"] < 0  # fill shrinks at the crank end
        assert sign * found[f"{end} admission"] > 0  # later: pre-admission shrinks
        assert sign * found[f"{end} release"] < 0  # earlier: pre-release grows
        assert sign * found[f"{end} compression"] > 0  # later: compression shrinks, where the text has it grow


dimensions = st.fixed_dictionaries(
    {
        "crank": st.floats(0.05, 1.0),
        "connecting_rod": st.floats(1.5, 8.0),
        "eccentric_rod": st.floats(1.5, 40.0),
        "advance": st.floats(-0.3, 1.2),
        "outside_lap": st.floats(0.05, 0.6),
        "inside_lap": st.floats(-0.2, 0.3),
        "setting": st.sampled_from([EQUAL_LEADS, MIDDLE, EQUAL_CUT_OFFS]),
    }
)


HARDLY_LONGER = {"crank": 0.3, "connecting_rod": 5.0, "eccentric_rod": 1.0004, "advance": math.radians(60.0), "outside_lap": 0.32,
                 "inside_lap": 0.02, "setting": MIDDLE}  # fmt: skip
"""A rod hardly longer than the eccentric: the valve all but jumps at its dead centres."""


@settings(max_examples=8)
@example(HARDLY_LONGER)
@example(HARDLY_LONGER | {"outside_lap": 0.9})
@given(dimensions)
def test_events_and_displacement_of_any_valve_are_those_of_the_closed_form(sizes):
    radius = 0.2 * sizes["crank"]
    given_sizes = {
        **sizes,
        "connecting_rod": sizes["connecting_rod"] * sizes["crank"],
        "eccentric": radius,
        "eccentric_rod": sizes["eccentric_rod"] * radius,
        "outside_lap": sizes["outside_lap"] * radius,
        "inside_lap": sizes["inside_lap"] * radius,
    }
    try:
        scene = valve_scene(given_sizes)
    except MechanismError:
        assume(False)  # a port that never opens
    part = scene.part.dimensions
    eccentric = Eccentric.from_dimensions(part)
    laps = {name: part[name] for name in ("outside_lap", "inside_lap")}
    for name, angle in find_event_angles(scene).items():
        exact = closed.event_angle(eccentric, event=name, **laps, centre=part["centre"])
        speed = abs(closed.valve_velocity(eccentric, crank_angle=exact, crank_rate=1.0)) / radius
        # rounding of lengths near l, over the speed of the port's edge there
        assert abs(math.remainder(angle - exact, math.tau)) < 1e-14 * (1 + eccentric.rod / radius) ** 2 / speed + 1e-12


@pytest.mark.parametrize("engine", [ImpulseEngine(), MultibodyEngine()], ids=lambda engine: engine.name)
def test_both_engines_follow_the_drive_within_the_accuracy(engine):
    scene = valve_scene({"crank_start": "50 deg"}, accuracy=1e-7, duration=0.65)  # a little more than one turn
    run = engine.run(scene)
    assert run.outcome is Outcome.DONE
    angles = math.radians(50.0) + 10.0 * run.times
    expected = closed.valve_displacement(Eccentric.from_dimensions(scene.part.dimensions), crank_angle=angles)
    assert np.max(np.abs(run.readings["crank_angle"] - angles)) < 1e-7
    assert np.max(np.abs(run.readings["valve_displacement"] - expected)) < 1e-7 * 0.3


def test_impulse_is_of_the_second_order():
    scene = valve_scene(duration=1.0, output_interval=0.1)
    angles = 10.0 * np.arange(0.0, 1.05, 0.1)
    expected = closed.valve_displacement(Eccentric.from_dimensions(scene.part.dimensions), crank_angle=angles)
    steps = np.array([4e-3, 2e-3, 1e-3])
    errors = [
        np.max(np.abs(ImpulseEngine(step=step, runs=1).run(scene, certify=False).readings["valve_displacement"] - expected))
        for step in steps
    ]
    assert abs(np.polyfit(np.log(steps), np.log(errors), 1)[0] - 2.0) < 0.1


@pytest.fixture(scope="module")
def short_run():
    return ImpulseEngine().run(valve_scene(duration=0.35))  # more than half a turn


@pytest.mark.parametrize("times", [0.1, 10.0])
def test_stand_in_masses_change_no_reading_beyond_the_accuracy(short_run, times):
    run, scene = short_run, short_run.scene
    for which in range(3):
        bodies = list(scene.part.mechanism.bodies)
        body = bodies[which]
        moments = replace(body.second_moments, xx=times * body.second_moments.xx, yy=times * body.second_moments.yy)
        bodies[which] = replace(body, mass=times * body.mass, second_moments=moments)
        mechanism = replace(scene.part.mechanism, bodies=tuple(bodies))
        other = ImpulseEngine().run(scene.with_changes(mechanism=mechanism))
        for name, values in run.readings.items():
            assert np.max(np.abs(values - other.readings[name])) < scene.run.accuracy * run.scales[name]


def test_parts_without_mass_load_no_bearing():
    run = MultibodyEngine().run(valve_scene())
    assert run.outcome is Outcome.DONE
    # a millionth of a kilogram at 30 m/s2: less than any instrument shows
    assert max(reaction.magnitude.max() for reaction in run.reactions.values()) < 1e-3


def test_all_that_cannot_be_built_is_told_at_once():
    wrong = {"connecting_rod": 0.2, "eccentric_rod": 0.05, "advance": "90 deg", "outside_lap": 0.07, "inside_lap": -0.08}
    with pytest.raises(MechanismError) as caught:
        valve_scene(wrong)
    assert [next(name for name in wrong if f" {name} (" in sentence) for sentence in caught.value.problems] == list(wrong)


def test_a_setting_given_from_python_is_checked_too():
    refuses("setting must be one of 'equal leads'", machine, setting="equal laps")


def test_events_of_another_machine_are_refused():
    with pytest.raises(MechanismError, match="valve timing needs a mechanism with a slide valve; machine 'pendulum_governor'"):
        tabulate_valve_timing(gm.load("porter"))


def test_the_table_of_events_reads_well_and_is_plain_as_json():
    found = tabulate_valve_timing(gm.load("slide_valve_marks"))
    lines = str(found).splitlines()
    assert lines[0] == found.title
    assert len({len(line) for line in lines[1:10]}) == 1
    assert lines[3].split()[:3] == ["crank", "end", "cut-off"]
    assert "125.766727" in lines[3]
    assert lines[-1] == "lead 6 mm at the crank end, 6 mm at the head end"
    plain = found.as_json()
    assert len(plain["events"]) == 8
    assert plain["events"][1]["simulated"] == found.rows[1].simulated


def test_readings_over_a_turn_are_those_of_the_kinematic_analysis():
    """With derivatives by the crank angle, in any order and beyond a turn."""
    angles = np.array([3.0, -0.4, 1.1, 9.0])
    order = np.argsort(angles)
    found, expected = (
        valve_motion_of(gm.load("slide_valve_30")).evaluate(angles),
        gm.kinematics("slide_valve_30", "crank_angle", angles[order]),
    )
    for ours, theirs in zip(found, (expected.readings, expected.rates, expected.reading_accelerations), strict=True):
        for name, values in theirs.items():
            np.testing.assert_allclose(ours[name][order], values, rtol=1e-11, atol=1e-13)
