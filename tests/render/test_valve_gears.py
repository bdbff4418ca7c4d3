"""The drawing of any valve gear shows valve, piston and steam as the run and the valve timing have them, and its engine stands clear."""

import math
from functools import cache

import numpy as np
import pytest
from matplotlib.path import Path

import governor_mechanism as gm
from drawing_checks import assert_shapes_keep
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.valve_motion import find_event_angles, valve_motion_of
from governor_mechanism.render.figures.plates.reversed_gear import valve_gears_figure
from governor_mechanism.render.geometry.primitives import Circle, Lines, Polygon, TextShape, bounding_box, drawn_point_paths
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.render.machines.registry import drawing_of
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
def run_of(name: str, mid_gear: bool = False) -> Trajectory:
    """A turn and a bit, in full gear that is being shifted, or in mid gear that stays."""
    changes = {"run.duration": 1.2, "run.output_interval": 0.02} | ({REVERSER[name]: 0.0} if mid_gear else {})
    return gm.run(parse_scene_with(gm.load(name).document, changes.items()), certify=False)


def drawing(run: Trajectory) -> MachineDrawing:
    return drawing_of(run, run.scene.part)


def middle_of(shapes):
    """The middle of the box around shapes."""
    left, right, bottom, top = bounding_box(shapes)
    return np.array([0.5 * (left + right), 0.5 * (bottom + top)])


def centroids(shapes, role):
    return [np.mean(shape.points, axis=0) for shape in shapes if shape.role == role and isinstance(shape, Polygon)]


@pytest.fixture(scope="module", params=GEARS)
def run(request):
    return run_of(request.param)


def test_a_valve_gear_has_a_drawing_whose_shapes_keep_their_kinds_and_stay_within_the_view(run):
    gear = drawing(run)
    assert isinstance(gear, ValveGearDrawing)
    assert_shapes_keep(gear, run, every=5)


def test_valve_and_piston_move_as_their_bodies_do(run):
    """In the engine both keep their distance from the body that drives them; the valve of the section moves at the scale beside it."""
    gear, mechanism = drawing(run), run.scene.part.mechanism
    valve_body, crosshead = (mechanism.body_index(name) for name in ("valve", "crosshead"))
    n_pieces = 2 if run.scene.part.mechanism.valve.admission == "inside" else 1
    offsets, ways = [], []
    for k in range(0, len(run.times), 3):
        shapes = list(gear.moving_shapes(run.poses[k], float(run.times[k])))
        pieces = centroids(shapes, "valve")
        assert len(pieces) == 2 * n_pieces  # in the engine, then in the section
        own, magnified = (np.mean(some, axis=0) for some in (pieces[:n_pieces], pieces[n_pieces:]))
        (piston,) = centroids(shapes, "piston")
        offsets.append([*(own - run.poses[k, valve_body, :2]), *(piston - run.poses[k, crosshead, :2])])
        ways.append(magnified[0])
    np.testing.assert_allclose(np.ptp(offsets, axis=0), 0.0, atol=ROUNDING)
    (note,) = (s.text for s in gear.background_shapes() if isinstance(s, TextShape) and s.text.startswith("valve"))
    displacements = run.readings["valve"][::3] - valve_motion_of(run.scene).centre
    scale = np.polyfit(displacements, ways, 1)[0]  # of the picture, in which the shaft is at the left
    np.testing.assert_allclose(scale, float(note.split()[1]), rtol=0.05)  # written with two digits
    np.testing.assert_allclose(ways, scale * displacements + np.mean(ways - scale * displacements), atol=ROUNDING)


def test_the_valve_rod_moves_as_one_with_its_body_and_the_ports_lie_toward_the_cylinder(run):
    gear, valve_body = drawing(run), run.scene.part.mechanism.body_index("valve")
    offsets, pistons = [], []
    for k in range(0, len(run.times), 3):
        polygons = [s for s in gear.moving_shapes(run.poses[k], float(run.times[k])) if isinstance(s, Polygon) and s.points]
        _, rod, *_ = (s for s in polygons if s.role == "piston rod")  # after the piston's
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
    run = run_of(name, mid_gear=True)
    gear, motion, events = drawing(run), valve_motion_of(run.scene), find_event_angles(run.scene)
    turned = (run.readings["crank_angle"] - motion.crank_end_angle) % math.tau
    names = dict(zip(("admission", "cut-off", "release", "compression"), STEAM_PHASES, strict=True))
    seen = set()
    for k in range(0, len(run.times), 2):
        shapes = gear.moving_shapes(run.poses[k], float(run.times[k]))
        shown = [s.role for s in shapes if isinstance(s, Polygon) and s.points and s.role in STEAM_PHASES]
        expected = []
        for end in ("crank end", "head end"):
            # The last event before the crank's angle.
            last = min(names, key=lambda event: (turned[k] - events[f"{end} {event}"]) % math.tau)
            expected += 4 * [names[last]]
        if gear.valve.admission == "inside":
            expected += 2 * ["live steam"]  # between the heads of the piston valve, in engine and section
        assert sorted(shown) == sorted(expected)
        seen |= set(shown)
    assert seen == set(STEAM_PHASES)


@pytest.mark.parametrize("name", ["gooch", "walschaerts"])
def test_the_drawn_port_is_open_by_the_opening(name):
    """From the edge of the valve to the edge of the port in the section, at its scale: positive where steam enters, else an overlap."""
    run = run_of(name)
    gear, readings = drawing(run), chosen_readings(run_of(name), ["crank_end_steam"])["crank_end_steam"].values
    section_bottom = min(y for s in gear.moving_shapes(run.poses[0], 0.0) if s.role == "valve" for _, y in s.points)
    drawn = []
    for k in range(0, len(run.times), 3):
        polygons = [s for s in gear.moving_shapes(run.poses[k], float(run.times[k])) if isinstance(s, Polygon) and s.points]
        ports = [s for s in polygons if s.role in STEAM_PHASES and math.isclose(max(y for _, y in s.points), section_bottom)]
        port = min(ports, key=lambda s: s.points[0][0])  # the crank end lies at the left
        head = min(
            (s for s in polygons if s.role == "valve" and min(y for _, y in s.points) == section_bottom), key=lambda s: s.points[0][0]
        )
        left, right = (extreme(x for x, _ in port.points) for extreme in (min, max))
        low, high = (extreme(x for x, _ in head.points) for extreme in (min, max))
        drawn.append(right - high if name == "walschaerts" else low - left)
    scale = float(np.ptp(drawn) / np.ptp(readings[::3]))
    assert scale > 2.0  # larger than the engine
    np.testing.assert_allclose(drawn, scale * readings[::3], atol=ROUNDING)
    assert min(drawn) < 0.0 < max(drawn)


def test_nothing_of_the_gear_meets_cylinder_or_chest(run):
    gear = drawing(run)
    points = drawn_point_paths(run.scene.part.mechanism, run.poses).reshape(-1, 2)
    for shape in gear.background_shapes():
        if shape.role in ("casting", "bore"):
            assert not Path(shape.points).contains_points(points).any()


def test_the_crank_of_the_diagram_is_parallel_to_that_of_the_engine(run):
    gear, crank = drawing(run), run.scene.part.mechanism.body_index("crank")
    (rim,) = (shape.lines[0] for shape in gear.background_shapes() if shape.role == "rim")
    centre = middle_of([Lines("", (rim,))])
    for k in range(0, len(run.times), 9):
        marks = [s for s in gear.moving_shapes(run.poses[k], float(run.times[k])) if isinstance(s, Circle) and s.role.endswith("mark")]
        angle = run.poses[k, crank, 2] + math.pi  # the pin is at -x of the body
        for mark in (one for one in marks if one.radius > 0.0):
            assert abs(math.remainder(math.atan2(mark.y - centre[1], mark.x - centre[0]) - angle, math.tau)) < 1e-6  # the dead centre's


def test_the_valve_is_read_from_its_centre(run):
    """What is shown grows by what the valve moves, and is the same lead at both dead centres, up to the shift of the gear."""
    shown, motion = shown_readings(run), valve_motion_of(run.scene)
    np.testing.assert_allclose(np.diff(shown["valve_displacement"].values), np.diff(run.readings["valve"]), atol=1e-12)
    displacement = evaluate_output_value(run.scene.part.mechanism, "valve", run.poses) - motion.centre
    sign = 1.0 if run.scene.part.mechanism.valve.admission == "outside" else -1.0
    for side, name in ((sign, "crank_end_steam"), (-sign, "head_end_steam")):
        np.testing.assert_allclose(shown[name].values, np.maximum(side * displacement - 0.024, 0.0), atol=1e-12)  # the lap of the scene
        assert chosen_readings(run, [name])[name].values.min() < 0.0


def test_names_lead_to_valve_and_piston_in_the_engine(run):
    gear = drawing(run)
    places = gear.named_places(run.poses[:1])
    shapes = list(gear.moving_shapes(run.poses[0], 0.0))
    assert math.dist(places["piston"][0], centroids(shapes, "piston")[0]) < ROUNDING
    left, right, bottom, top = bounding_box([shape for shape in shapes if shape.role == "valve"][: len(centroids(shapes, "valve")) // 2])
    assert left < places["valve"][0, 0] < right
    assert bottom < places["valve"][0, 1] < top
    assert set(places) == {*(body.name for body in run.scene.part.mechanism.bodies), "piston"}


def test_what_is_no_engine_is_drawn_as_any_mechanism():
    """Without a reading of the piston there is no cylinder to draw."""
    document = dict(gm.load("gooch").document)
    document["valve"] = {key: value for key, value in document["valve"].items() if key != "piston"}
    run = gm.run(parse_scene_with(document, {"run.duration": 0.1}.items()), certify=False)
    assert type(drawing(run)) is GenericDrawing


def test_all_curves_of_compared_gears_lie_within_their_panels():
    """Also where all values are negative."""
    figure = valve_gears_figure(compare_valve_gears([gm.load("walschaerts")], count=5))
    for panel in figure.axes:
        low, high = panel.get_ylim()
        for line in panel.lines:
            values = np.asarray(line.get_ydata(), dtype=float)
            assert low <= values.min()
            assert values.max() <= high
