"""The drawing of any valve gear shows valve, piston and steam as the run and the valve timing have them, and its engine stands clear."""

import math
from functools import cache

import numpy as np
import pytest
from matplotlib.path import Path

import governor_mechanism as gm
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.observables.valve_motion import find_event_angles, valve_motion_of
from governor_mechanism.render.figures.plates.reversed_gear import valve_gears_figure
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon, TextShape, bounding_box, drawn_point_paths
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.steam_distribution import STEAM_PHASES
from governor_mechanism.render.machines.valve_gear import ValveGearDrawing
from governor_mechanism.render.shown_readings import chosen_readings, shown_readings
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.valve_gears import compare_valve_gears

GEARS = ("gooch", "allan", "walschaerts", "joy")
ROUNDING = 1e-9
"""Metres: sums of lengths of some metres round at 1e-15, the assembly of the mechanism leaves 1e-11."""
REVERSER = {name: "joint.lever.motion.harmonics.1.amplitude" for name in GEARS} | {"joy": "joint.quadrant.motion.harmonics.1.amplitude"}


@cache
def draw(name: str, mid_gear: bool = False) -> Drawn:
    """A turn and a bit, in full gear that is being shifted, or in mid gear that stays."""
    changes = {"run.duration": 1.2, "run.output_interval": 0.02} | ({REVERSER[name]: 0.0} if mid_gear else {})
    return Drawn(gm.run(parse_scene_with(gm.load(name).document, changes.items()), certify=False))


def polygons_of(shapes):
    return [shape for shape in shapes if isinstance(shape, Polygon) and shape.points]


def centroids(shapes, role):
    return [np.mean(shape.points, axis=0) for shape in of_role(shapes, role, Polygon)]


@pytest.fixture(scope="module", params=GEARS)
def gear(request):
    return draw(request.param)


def test_a_valve_gear_has_a_drawing_whose_shapes_keep_their_kinds_and_stay_within_the_view(gear):
    assert isinstance(gear.drawing, ValveGearDrawing)
    assert_shapes_keep(gear, every=5)


def test_valve_and_piston_move_as_their_bodies_do(gear):
    """In the engine both keep their distance from the body that drives them; the valve of the section moves at the scale beside it."""
    run, mechanism = gear.run, gear.run.scene.part.mechanism
    valve_body, crosshead = (mechanism.body_index(name) for name in ("valve", "crosshead"))
    n_pieces = 2 if mechanism.valve.admission == "inside" else 1
    offsets, ways = [], []
    for k in range(0, len(run.times), 3):
        shapes = gear.at(k)
        pieces = centroids(shapes, "valve")
        assert len(pieces) == 2 * n_pieces  # in the engine, then in the section
        own, magnified = (np.mean(some, axis=0) for some in (pieces[:n_pieces], pieces[n_pieces:]))
        (piston,) = centroids(shapes, "piston")
        offsets.append([*(own - run.poses[k, valve_body, :2]), *(piston - run.poses[k, crosshead, :2])])
        ways.append(magnified[0])
    np.testing.assert_allclose(np.ptp(offsets, axis=0), 0.0, atol=ROUNDING)
    (note,) = (shape.text for shape in gear.still if isinstance(shape, TextShape) and shape.text.startswith("valve"))
    displacements = run.readings["valve"][::3] - valve_motion_of(run.scene).centre
    scale = np.polyfit(displacements, ways, 1)[0]  # of the picture, in which the shaft is at the left
    np.testing.assert_allclose(scale, float(note.split()[1]), rtol=0.05)  # written with two digits
    np.testing.assert_allclose(ways, scale * displacements + np.mean(ways - scale * displacements), atol=ROUNDING)


def test_the_valve_rod_moves_as_one_with_its_body_and_the_ports_lie_toward_the_cylinder(gear):
    run, valve_body = gear.run, gear.run.scene.part.mechanism.body_index("valve")
    offsets, pistons = [], []
    for k in range(0, len(run.times), 3):
        polygons = polygons_of(gear.at(k))
        _, rod, *_ = of_role(polygons, "piston rod")  # after the piston's
        offsets.append(np.array(rod.points) - run.poses[k, valve_body, :2])
        pistons.append(*centroids(polygons, "piston"))
    np.testing.assert_allclose(np.ptp(offsets, axis=0), 0.0, atol=ROUNDING)
    along = pistons[0] - pistons[len(pistons) // 2]
    normal = np.array([-along[1], along[0]]) / np.hypot(*along)
    # Pipe, space of the cylinder and port of the crank end.
    _, _, port = [np.mean(s.points, axis=0) for s in polygons if s.role in STEAM_PHASES][:3]
    of_port, of_valve = (abs((place - pistons[0]) @ normal) for place in (port, centroids(polygons, "valve")[0]))
    assert of_port < of_valve


@pytest.mark.parametrize("name", GEARS)
def test_the_steam_changes_its_state_at_the_events(name):
    """In mid gear, which stays, cylinder, pipe and ports of each end are painted as the valve timing says."""
    gear = draw(name, mid_gear=True)
    run, motion, events = gear.run, valve_motion_of(gear.run.scene), find_event_angles(gear.run.scene)
    turned = (run.readings["crank_angle"] - motion.crank_end_angle) % math.tau
    names = dict(zip(("admission", "cut-off", "release", "compression"), STEAM_PHASES, strict=True))
    seen = set()
    for k in range(0, len(run.times), 2):
        shown = [shape.role for shape in polygons_of(gear.at(k)) if shape.role in STEAM_PHASES]
        expected = []
        for end in ("crank end", "head end"):
            # The last event before the crank's angle.
            last = min(names, key=lambda event: (turned[k] - events[f"{end} {event}"]) % math.tau)
            expected += 4 * [names[last]]
        if gear.drawing.valve.admission == "inside":
            expected += 2 * ["live steam"]  # between the heads of the piston valve, in engine and section
        assert sorted(shown) == sorted(expected)
        seen |= set(shown)
    assert seen == set(STEAM_PHASES)


@pytest.mark.parametrize("name", ["gooch", "walschaerts"])
def test_the_drawn_port_is_open_by_the_opening(name):
    """From the edge of the valve to the edge of the port in the section, at its scale: positive where steam enters, else an overlap."""
    gear = draw(name)
    readings = chosen_readings(gear.run, ["crank_end_steam"])["crank_end_steam"].values
    _, _, section_bottom, _ = bounding_box(of_role(gear.at(0), "valve"))
    drawn = []
    for k in range(0, len(gear.run.times), 3):
        boxes = [(shape.role, *bounding_box([shape])) for shape in polygons_of(gear.at(k))]
        # The crank end lies at the left.
        left, right = min(box[1:3] for box in boxes if box[0] in STEAM_PHASES and math.isclose(box[4], section_bottom))
        low, high = min(box[1:3] for box in boxes if box[0] == "valve" and box[3] == section_bottom)
        drawn.append(right - high if name == "walschaerts" else low - left)
    scale = float(np.ptp(drawn) / np.ptp(readings[::3]))
    assert scale > 2.0  # larger than the engine
    np.testing.assert_allclose(drawn, scale * readings[::3], atol=ROUNDING)
    assert min(drawn) < 0.0 < max(drawn)


def test_nothing_of_the_gear_meets_cylinder_or_chest(gear):
    points = drawn_point_paths(gear.run.scene.part.mechanism, gear.run.poses).reshape(-1, 2)
    for shape in (*of_role(gear.still, "casting"), *of_role(gear.still, "bore")):
        assert not Path(shape.points).contains_points(points).any()


def test_the_crank_of_the_diagram_is_parallel_to_that_of_the_engine(gear):
    run, crank = gear.run, gear.run.scene.part.mechanism.body_index("crank")
    left, right, bottom, top = bounding_box([Lines("", shape.lines[:1]) for shape in of_role(gear.still, "rim")])
    for k in range(0, len(run.times), 9):
        marks = [shape for shape in gear.at(k) if isinstance(shape, Circle) and shape.role.endswith("mark") and shape.radius > 0.0]
        angle = run.poses[k, crank, 2] + math.pi  # the pin is at -x of the body
        for mark in marks:
            drawn = math.atan2(mark.y - 0.5 * (bottom + top), mark.x - 0.5 * (left + right))
            assert abs(math.remainder(drawn - angle, math.tau)) < 1e-6  # the dead centre's


def test_the_valve_is_read_from_its_centre(gear):
    """What is shown grows by what the valve moves, and is the same lead at both dead centres, up to the shift of the gear."""
    run = gear.run
    shown, motion = shown_readings(run), valve_motion_of(run.scene)
    np.testing.assert_allclose(np.diff(shown["valve_displacement"].values), np.diff(run.readings["valve"]), atol=1e-12)
    displacement = evaluate_output_value(run.scene.part.mechanism, "valve", run.poses) - motion.centre
    sign = 1.0 if run.scene.part.mechanism.valve.admission == "outside" else -1.0
    for side, name in ((sign, "crank_end_steam"), (-sign, "head_end_steam")):
        np.testing.assert_allclose(shown[name].values, np.maximum(side * displacement - 0.024, 0.0), atol=1e-12)  # the lap of the scene
        assert chosen_readings(run, [name])[name].values.min() < 0.0


def test_names_lead_to_valve_and_piston_in_the_engine(gear):
    places = gear.drawing.named_places(gear.run.poses[:1])
    shapes = gear.at(0)
    assert math.dist(places["piston"][0], centroids(shapes, "piston")[0]) < ROUNDING
    left, right, bottom, top = bounding_box(of_role(shapes, "valve")[: len(centroids(shapes, "valve")) // 2])
    assert left < places["valve"][0, 0] < right
    assert bottom < places["valve"][0, 1] < top
    assert set(places) == {*(body.name for body in gear.run.scene.part.mechanism.bodies), "piston"}


def test_what_is_no_engine_is_drawn_as_any_mechanism():
    """Without a reading of the piston there is no cylinder to draw."""
    document = dict(gm.load("gooch").document)
    document["valve"] = {key: value for key, value in document["valve"].items() if key != "piston"}
    run = gm.run(parse_scene_with(document, {"run.duration": 0.1}.items()), certify=False)
    assert type(Drawn(run).drawing) is GenericDrawing


def test_all_curves_of_compared_gears_lie_within_their_panels():
    """Also where all values are negative."""
    figure = valve_gears_figure(compare_valve_gears([gm.load("walschaerts")], count=5))
    for panel in figure.axes:
        low, high = panel.get_ylim()
        for line in panel.lines:
            values = np.asarray(line.get_ydata(), dtype=float)
            assert low <= values.min()
            assert values.max() <= high
