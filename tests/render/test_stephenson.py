"""The drawing of a link motion and its plates: they show what the mechanism does, stay in their frames, and have all gears."""

import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.path import Path
from PIL import Image

import governor_mechanism as gm
from crank_scenes import link_gear_scene
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.figures.plates.reversed_gear import draw_gear_plate
from governor_mechanism.render.frame_data import FrameData, find_parts
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.machines.steam_distribution import steam_phase
from governor_mechanism.render.results_folder import write_machine_figures
from governor_mechanism.studies.valve_gears import compare_valve_gears

CASES = {
    "moving lever": {"reverser": [[0.1, 1.0], [0.6, -1.0]]},
    "fixed lever, crossed": {"reverser": 0.4, "rods": "crossed", "suspension": "lower pin"},
    "slot with ends, endless rod": {"slot_half_length": 0.19, "connecting_rod": None, "pin_setback": 0.075},
}


@pytest.fixture(scope="module", params=CASES)
def drawn(request):
    return Drawn(MultibodyEngine().run(link_gear_scene(CASES[request.param], duration=0.7, output_interval=0.01)))


def test_shapes_keep_their_kinds_and_roles_and_stay_within_the_view(drawn):
    assert set(drawn.drawing.panel_readings) - {"crank_rate"} <= set(drawn.run.readings)  # which only a scene of several parts shows
    assert_shapes_keep(drawn)
    assert drawn.still


def test_the_die_is_drawn_on_the_valve_line_within_its_slot(drawn):
    dies = []
    for k in range(0, len(drawn.run.times), 7):
        (slot,), (die,) = (of_role(drawn.at(k), role) for role in ("slot", "block"))
        middle = np.mean(die.points, axis=0)
        dies.append((middle[1], middle[0], drawn.run.readings["valve_displacement"][k]))
        assert np.min(np.hypot(*(np.array(slot.points) - middle).T)) < 0.05 * drawn.drawing.crank  # in the slot, which is narrow
    heights, positions, displacements = np.transpose(dies)
    assert np.ptp(heights) < 1e-12  # on a level line
    slope = np.polyfit(displacements, positions, 1)[0]
    np.testing.assert_allclose(positions - slope * displacements, np.mean(positions - slope * displacements), atol=1e-12)
    assert slope < 0  # away from the shaft is to the left


def test_the_lever_points_where_the_reading_says(drawn):
    for k in (0, len(drawn.run.times) // 2, -1):
        shapes = drawn.at(k)
        (knob,) = of_role(shapes, "ball", Circle)
        pivot = next(shape for shape in shapes[shapes.index(knob) :] if shape.role == "pivot")
        angle = math.atan2(knob.y - pivot.y, knob.x - pivot.x)
        assert (angle - math.pi / 2) / math.radians(34.0) == pytest.approx(drawn.run.readings["reverser"][k], abs=1e-9)


def test_the_curve_of_the_last_turn_ends_at_the_crank(drawn):
    shapes = drawn.at(-1)
    curves = [shape for shape in shapes if isinstance(shape, Lines) and shape.role.endswith("end curve")]
    assert all(np.isfinite(point).all() for curve in curves for line in curve.lines for point in line)
    assert not any(isinstance(shape, Polygon) and not np.isfinite(shape.points).all() for shape in shapes if getattr(shape, "points", ()))


def test_no_pin_of_the_link_is_beside_it(drawn):
    """Also of rods whose pins are behind the arc."""
    for shapes in drawn.moving[::7]:
        plates = [Path(shape.points) for shape in of_role(shapes, "plate")]
        on_link = [any(plate.contains_point((pin.x, pin.y)) for plate in plates) for pin in of_role(shapes, "pivot")]
        assert sum(on_link) >= 4  # of two rods, of the hanger, of the die


@pytest.mark.long
def test_the_plates_of_a_link_motion_are_written(tmp_path):
    run = gm.run(link_gear_scene({"suspension": "lower pin", "reverser": [[0.0, 1.0], [0.1, 0.5]]}, duration=0.1))
    files = write_machine_figures(run, FigureFiles(folder=tmp_path), "gear")
    assert [file.name for file in files] == ["gear_zeuner.png", "gear_gears.png", "gear_die_paths.png"]
    for file in files:
        with Image.open(file) as image:
            assert image.size == (1637, 1157)  # A4 on its side at 140 dots an inch
            assert len(image.convert("RGB").getcolors(1 << 20)) > 100


def test_the_plate_of_all_gears_shows_their_leads_and_crests():
    gear = compare_valve_gears([link_gear_scene()], 5).gears[0]
    plate = draw_gear_plate(gear)
    FigureCanvasAgg(plate).draw()
    polar, *curves = plate.axes
    drawn = [line for line in curves[0].lines if len(line.get_xdata()) == 5]
    np.testing.assert_allclose([line.get_ydata() for line in drawn], 1e3 * gear.leads.T)
    crest_line = next(line for line in polar.lines if line.get_linestyle() == "--" or len(line.get_xdata()) == 5)
    largest = [timing.largest_openings[0] + 0.024 for timing in gear.timings]
    np.testing.assert_allclose(np.hypot(*crest_line.get_data()), 1e3 * np.array(largest), rtol=1e-4)  # at the nearest of 361 angles


def test_the_steam_of_a_crank_that_turns_back_expands_where_the_piston_recedes():
    """In the same position of crank and valve, expansion and compression change places with the sense of rotation."""
    drawing = drawing_of(MultibodyEngine().run(link_gear_scene({"reverser": 0.5}, duration=0.7)), link_gear_scene({"reverser": 0.5}).part)
    ahead = drawing.position(drawing.poses[0])
    closed = replace(ahead, crank_angle=2.0, valve_displacement=0.01)  # within the steam lap, beyond the exhaust lap of the head end
    phases = [steam_phase(drawing, replace(closed, sense=sense), 1.0) for sense in (1.0, -1.0)]
    assert phases == ["expanding steam", "pressed steam"]


def test_a_flywheel_on_the_shaft_is_drawn_with_the_gear_and_turns_with_its_crank():
    run = gm.run(gm.load("stephenson_reversing").replace({"run.duration": "0.3 s"}), certify=False)
    (part,) = find_parts(run, None)
    assert part.machine == "stephenson"
    assert [one.name for one in find_parts(run, "engine")] == ["engine"]
    data = FrameData(run, part, (0.0, 0.3), np.array([0.0, 0.2]))
    angles = []
    for k in range(2):
        (spoke,) = of_role(shapes_of(data.moving_parts(), k), "marked spoke")
        (x, y), (end_x, end_y) = spoke.lines[0]
        angles.append(math.atan2(end_y - y, end_x - x))
    turned = np.interp(0.2, run.times, run.readings["gear.crank_angle"]) - run.readings["gear.crank_angle"][0]
    assert math.remainder(angles[1] - angles[0] - turned, math.tau) == pytest.approx(0.0, abs=1e-3)
