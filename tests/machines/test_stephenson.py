"""Stephenson's link motion as a mechanism: table and second solver, engines, lever in motion, slot, refusals."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

import governor_mechanism as gm
from crank_scenes import link_gear_scene
from governor_mechanism.closed_form import stephenson as closed
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import thin_arc
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.observables.valve_motion import find_event_angles
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.results_folder import write_machine_figures
from governor_mechanism.scenes.parser import parse_scene_document
from reference import stephenson as printed
from refusing import refuses

TURN = np.linspace(0.0, math.tau, 720, endpoint=False)
"""Crank angles of the reference rows."""


@pytest.mark.parametrize("row", printed.ROWS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_travel_slip_and_harmonics_are_those_of_the_table(row):
    suspension, gear, travel, half_difference, slip_range, mean_offset, cosine, sine, second = row
    readings = gm.kinematics(link_gear_scene({"suspension": suspension, "reverser": gear}), "crank_angle", TURN).readings
    valve, offset = readings["valve_displacement"], readings["die_slip"]
    harmonics = 2 * np.fft.rfft(valve) / len(valve)
    found = (np.ptp(valve), (valve[0] - valve[360]) / 2, 1e3 * np.ptp(offset), np.mean(offset), harmonics[1].real, -harmonics[1].imag)
    expected = (travel, half_difference, slip_range, mean_offset, cosine, sine)
    # printed to twelve digits; the slip is in mm
    np.testing.assert_allclose([*found, abs(harmonics[2])], [*expected, second], rtol=1e-11, atol=2e-12)


SUSPENSIONS = {
    "arc middle": (0.0, 0.0),
    "chord middle": (-(1.2 - math.sqrt(1.2**2 - 0.15**2)), 0.0),
    "lower pin": (-(1.2 - math.sqrt(1.2**2 - 0.15**2)), -0.15),
    "half-way": (1.2 * math.cos(0.5 * math.asin(0.125)) - 1.2, -1.2 * math.sin(0.5 * math.asin(0.125))),
}


@pytest.mark.parametrize("crossed", [False, True], ids=["open", "crossed"])
@pytest.mark.parametrize("suspension", SUSPENSIONS)
def test_a_second_solver_finds_the_same_positions(suspension, crossed):
    scene = link_gear_scene({"suspension": suspension, "reverser": 0.6, "rods": "crossed" if crossed else "open"})
    angles = np.linspace(0.0, math.tau, 24, endpoint=False)
    readings = gm.kinematics(scene, "crank_angle", angles).readings
    sizes = {"eccentric": 0.06, "eccentric_rod": 1.2, "advance": math.radians(30), "link_radius": 1.2, "half_link": 0.15, "hanger": 0.5}
    sizes |= {"suspension": SUSPENSIONS[suspension], "crossed": crossed}
    centre = scene.part.dimensions["centre"]
    for k, angle in enumerate(angles):
        guess = (1.2, -0.09 if not crossed else 0.09, -float(readings["link_angle"][k]))
        valve, offset, link_angle = printed.solve_closure(angle, 0.6, sizes, guess)
        assert abs(readings["valve_displacement"][k] - (valve - centre)) < 1e-11  # scipy closes the rods to 1e-12 m
        assert abs(readings["die_slip"][k] - offset) < 1e-11
        assert abs(readings["link_angle"][k] + link_angle) < 1e-10  # 1e-12 m over half a link


def test_the_suspensions_in_the_order_of_their_slip():
    slips = [np.ptp(gm.kinematics(link_gear_scene({"suspension": one, "reverser": 0}), "crank_angle", TURN).readings["die_slip"])
             for one in printed.MID_GEAR_SLIPS]  # fmt: skip
    assert slips == sorted(slips)


SIZES = st.fixed_dictionaries(
    {
        "crank": st.floats(0.05, 1.0),
        "eccentric": st.floats(0.1, 0.45),
        "eccentric_rod": st.floats(5.0, 15.0),
        "link_radius": st.floats(4.0, 20.0),
        "pin_setback": st.floats(-0.3, 0.6),
        "hanger": st.floats(2.0, 6.0),
        "advance": st.floats(-0.2, 0.9),
        "reverser": st.floats(-1.0, 1.0),
        "suspension": st.sampled_from(["arc middle", "chord middle", "lower pin", "half-way"]),
        "rods": st.sampled_from(["open", "crossed"]),
    }
)
"""Dimensions relative to half the link, but for the crank, in m."""


@settings(max_examples=15)
@given(SIZES)
def test_any_gear_moves_as_the_closure_of_its_rods(sizes):
    half_link = 0.5 * sizes["crank"]
    lengths = {name: sizes[name] * half_link for name in ("eccentric", "eccentric_rod", "link_radius", "pin_setback", "hanger")}
    laps = {"outside_lap": 0.4 * lengths["eccentric"], "inside_lap": 0.1 * lengths["eccentric"], "connecting_rod": 5 * sizes["crank"]}
    try:
        scene = link_gear_scene(sizes | lengths | laps | {"half_link": half_link})
    except MechanismError:
        assume(False)  # no position at some crank angle
    angles = np.linspace(0.0, math.tau, 13)
    readings = gm.kinematics(scene, "crank_angle", angles).readings
    link_gear = closed.LinkGear.from_dimensions(scene.part.dimensions)
    exact = closed.link_position(link_gear, crank_angle=angles, gear=sizes["reverser"])
    # rounding of lengths of the rods, amplified by the link's lever and by a gear near its dead centre
    tolerance = 1e-12 * lengths["eccentric_rod"] / lengths["eccentric"]
    assert (
        np.max(np.abs(readings["valve_displacement"] + scene.part.dimensions["centre"] - exact.valve))
        < tolerance * lengths["eccentric_rod"]
    )
    assert np.max(np.abs(readings["die_slip"] - exact.die_offset)) < tolerance * lengths["link_radius"]
    assert np.max(np.abs(readings["reverser"] - sizes["reverser"])) < 1e-12


@pytest.mark.parametrize("engine", [ImpulseEngine(), MultibodyEngine()], ids=lambda engine: engine.name)
def test_both_engines_follow_the_lever_and_the_crank(engine):
    """The lever rests, goes from full forward to half back gear, and rests; its curve is monotone."""
    program = [[0.1, 1.0], [0.4, 0.2], [0.7, -0.5]]
    scene = link_gear_scene({"crank_start": "50 deg", "reverser": program}, accuracy=1e-7, duration=0.9)
    run = engine.run(scene)
    assert run.outcome is Outcome.DONE
    lever = PchipInterpolator([-0.2, 0.1, 0.4, 0.7, 1.0], [1.0, 1.0, 0.2, -0.5, -0.5])(run.times)
    assert np.max(np.abs(run.readings["reverser"] - lever)) < 1e-7
    assert np.ptp(run.readings["reverser"][run.times > 0.71]) < 1e-7
    angles = math.radians(50.0) + 10.0 * run.times
    exact = closed.link_position(closed.LinkGear.from_dimensions(scene.part.dimensions), crank_angle=angles, gear=lever)
    assert np.max(np.abs(run.readings["valve_displacement"] - (exact.valve - scene.part.dimensions["centre"]))) < 1e-7 * 0.3
    assert np.max(np.abs(run.readings["die_slip"] - exact.die_offset)) < 1e-7 * 0.3


def test_impulse_is_of_the_second_order_and_its_slot_gap_shrinks_with_the_square_of_the_step():
    scene = link_gear_scene(duration=0.6, output_interval=0.1)
    angles = 10.0 * np.arange(0.0, 0.65, 0.1)
    exact = closed.link_position(closed.LinkGear.from_dimensions(scene.part.dimensions), crank_angle=angles, gear=1.0)
    expected, steps, errors, gaps = exact.valve - scene.part.dimensions["centre"], np.array([4e-3, 2e-3, 1e-3]), [], []
    for step in steps:
        run = ImpulseEngine(step=step, runs=1).run(scene, certify=False)
        errors.append(np.max(np.abs(run.readings["valve_displacement"] - expected)))
        gaps.append(np.max(run.joint_gap))
    assert abs(np.polyfit(np.log(steps), np.log(errors), 1)[0] - 2.0) < 0.15
    assert abs(np.polyfit(np.log(steps), np.log(gaps), 1)[0] - 2.0) < 0.3


def test_driven_fast_the_die_presses_alike_in_both_engines():
    masses = {"link_masses": {"link": "25 kg", "eccentric_rod": "15 kg", "valve": "60 kg"}}
    scene = link_gear_scene({"crank_speed": "300 rpm", "reverser": 0.5}, masses, duration=0.2, output_interval=0.005, accuracy=1e-6)
    runs = [engine.run(scene) for engine in (MultibodyEngine(), ImpulseEngine())]
    assert all(run.outcome is Outcome.DONE for run in runs)
    forces = [run.reactions["link slot"].magnitude for run in runs]
    assert np.max(forces[0]) > 1e3  # 60 kg that move by 37 mm at 31 rad/s
    # Reactions follow from poses and velocities, which agree to the accuracy; the gear enlarges that by less than ten.
    assert np.max(np.abs(forces[1] - forces[0])) < 1e-5 * np.max(forces[0])


def test_the_link_is_a_thin_arc():
    angles = np.linspace(-0.4, 0.4, 200_001)
    x, y = -1.5 * np.cos(angles), 1.5 * np.sin(angles)
    element = thin_arc(3.0, 1.5, 0.4)
    assert element.centre[0] == pytest.approx(np.mean(x), abs=1e-5)  # a sum over 200,001 points
    assert element.moments.xx == pytest.approx(3.0 * np.var(x), rel=1e-4)
    assert element.moments.yy == pytest.approx(3.0 * np.mean(y**2), rel=1e-4)


def test_a_die_that_runs_out_of_its_slot_ends_the_run_by_name():
    run = gm.run(link_gear_scene({"slot_half_length": 0.158}))
    assert run.outcome is Outcome.LEFT_RANGE
    assert "die_slip: the die block runs out of the upper end of the slot at a crank angle of 57.97" in run.message
    assert math.degrees(10.0 * float(run.message.split("t = ")[1].split(" s")[0])) == pytest.approx(57.97, abs=0.01)  # as the driver turns
    assert abs(run.readings["die_slip"][-1]) <= 0.158
    assert gm.run(link_gear_scene({"slot_half_length": 0.17})).outcome is Outcome.DONE


def test_mid_gear_opens_the_ports_by_the_lead_alone():
    events = find_event_angles(link_gear_scene({"reverser": 0}))
    assert len(events) == 8
    cut_off, admission = (math.degrees(events[f"crank end {name}"]) for name in ("cut-off", "admission"))
    assert cut_off == pytest.approx(360 - admission, abs=1.0)  # symmetric about the dead centre, but for the hanger
    assert not find_event_angles(link_gear_scene({"reverser": 0, "outside_lap": 0.05})).keys() & {"crank end admission"}


def test_a_free_crank_swings_on_alike_in_all_engines(tmp_path):
    """With masses and without friction; the valve has no events, and plates that need them are left out."""
    masses = {"link_masses": {"link": "25 kg", "eccentric_rod": "15 kg", "valve": "60 kg", "shaft_inertia": "5 kg m^2"}}
    free = link_gear_scene({"crank_speed": None, "reverser": 0.5, "crank_start": "20 deg"}, masses, duration=0.3)
    scene = parse_scene_document({**free.document, "start": {"crank_rate": "300 rpm"}})
    runs = [engine.run(scene) for engine in (ReducedEngine(), MultibodyEngine(), ImpulseEngine())]
    for run in runs:
        assert run.outcome is Outcome.DONE
        for name in run.readings:
            difference = np.max(np.abs(run.readings[name] - runs[1].readings[name])) / run.scales[name]
            assert difference <= run.error_estimate + runs[1].error_estimate
    # The kinetic energy of the masses, about 100 J of 2.5 kJ, comes from the shaft and returns to it.
    speeds, energy = runs[1].rates["crank_angle"], runs[1].energy.kinetic
    assert 0.1 < np.ptp(speeds) < 2.0
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)
    assert write_machine_figures(runs[1], FigureFiles(folder=tmp_path), "free") == []
    refuses("the crank is not driven", gm.valve_timing, scene)


def test_a_die_block_that_runs_out_of_its_slot_is_refused_by_the_run():
    refuses("the die block runs out of the upper end of the slot", gm.run, link_gear_scene({"slot_half_length": 0.1}))
