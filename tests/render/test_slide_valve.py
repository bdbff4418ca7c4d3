"""The drawing of a slide valve and its plates: they show what the mechanism does, stay in their frames, and repeat."""

import math
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

import governor_mechanism as gm
from colour_vision import VISIONS, lab
from crank_scenes import SLIDER_CRANK_MASSES, crank_scene, valve_scene
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.observables.valve_motion import find_event_angles
from governor_mechanism.render.figure_files import FigureFiles
from governor_mechanism.render.figures.plates import engines as bearings
from governor_mechanism.render.figures.plates import marks as marks_construction
from governor_mechanism.render.figures.plates import zeuner
from governor_mechanism.render.figures.plates.marks import EccentricDiagram
from governor_mechanism.render.figures.plates.zeuner import ValveDiagram
from governor_mechanism.render.geometry.primitives import Circle, Polygon, TextShape, bounding_box
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.machines.steam_cylinder import valve_magnification
from governor_mechanism.render.machines.steam_distribution import PHASE_NAMES, STEAM_PHASES, steam_phase
from governor_mechanism.render.results_folder import write_machine_figures
from governor_mechanism.render.shown_readings import chosen_readings, shown_readings
from governor_mechanism.render.style import ROLE_STYLES
from governor_mechanism.scenes.changed_document import parse_scene_with

CASES = {
    "marks": {},
    "thirty": {"eccentric_rod": 1.8},
    "endless": {"eccentric_rod": None, "connecting_rod": None},
    "middle": {"setting": "middle of extremes"},
    "long lap": {"outside_lap": 0.05, "setting": "middle of extremes", "eccentric_rod": 1.8},
    "no lap": {"outside_lap": 0.0, "inside_lap": -0.004, "advance": "5 deg"},
}

CROWDED = {
    "short rods": {"eccentric": 0.25, "eccentric_rod": 0.26, "connecting_rod": None, "outside_lap": 0.08,
                   "advance": "60 deg", "setting": "middle of extremes"},
    "behind": {"advance": "-60 deg", "eccentric_rod": 20.0, "outside_lap": -0.010, "inside_lap": -0.005},
    "hardly open": {"eccentric": 0.006, "eccentric_rod": 2.0, "outside_lap": 0.0058, "inside_lap": 0.0059},
}  # fmt: skip
"""Events so near to each other that their names have to give way."""


@pytest.fixture(scope="module", params=CASES)
def drawn(request):
    return Drawn(MultibodyEngine().run(valve_scene(CASES[request.param], duration=0.7, output_interval=0.01)))


def test_shapes_of_a_drawing_of_its_own_keep_their_kinds_and_roles_and_stay_within_the_view(drawn):
    assert set(drawn.drawing.panel_readings) <= set(drawn.run.readings)
    assert_shapes_keep(drawn)
    assert drawn.still


def test_piston_and_valve_are_drawn_where_they_stand(drawn):
    run, gear = drawn.run, drawn.drawing
    (engine_bore, *_), notes = of_role(drawn.still, "bore"), [s.text for s in drawn.still if isinstance(s, TextShape)]
    (note,) = (text for text in notes if text.startswith("engine"))
    assert note.endswith("× smaller")
    for k in range(0, len(run.times), 7):
        shapes = drawn.at(k)
        engine_piston, piston = (np.mean(shape.points, axis=0)[0] for shape in of_role(shapes, "piston"))
        # the crank end lies at the right
        way = run.readings["crank_end_travel"][k]
        assert abs(piston - (gear.crank - way)) < 1e-12
        # in the engine to the scale that is written below the cylinder
        offset = engine_piston - np.mean(engine_bore.points, axis=0)[0]
        np.testing.assert_allclose(offset, piston / float(note.split()[1]), atol=0.02 * gear.crank)  # written with two digits
        (valve,) = of_role(shapes, "valve")
        middle = sum(x for x, _ in valve.points) / len(valve.points)
        assert abs(middle + valve_magnification(gear) * run.readings["valve_displacement"][k]) < 1e-12


def test_the_valve_stays_within_its_chest(drawn):
    boxes = [bounding_box([shape])[:2] for shape in of_role(drawn.still, "live steam")]
    low, high = max(boxes, key=np.ptp)  # the chest; the others are small: that of the whole engine, and the key
    for shapes in drawn.moving:
        (valve,) = of_role(shapes, "valve")
        xs = [x for x, _ in valve.points]
        assert low < min(xs) < max(xs) < high


def test_the_steam_changes_its_state_at_the_events():
    scene = valve_scene()
    angles = find_event_angles(scene)
    instants = sorted(angle + change for angle in angles.values() for change in (-1e-6, 1e-6))
    motion = gm.kinematics(scene, over="crank_angle", values=instants)
    poses, gear = dict(zip(instants, motion.poses, strict=True)), drawing_of(motion, scene.part)
    names = {"admission": "live steam", "cut-off": "expanding steam", "release": "spent steam", "compression": "pressed steam"}
    for name, angle in angles.items():
        end, event = name.rsplit(" ", 1)
        side = 1.0 if end == "crank end" else -1.0
        after, before = (steam_phase(gear, gear.position(poses[angle + change]), side) for change in (1e-6, -1e-6))
        assert after == names[event]
        assert before != after


def test_only_the_steam_that_is_there_is_painted(drawn):
    gear = drawn.drawing
    for pose, shapes in zip(drawn.run.poses[::9], drawn.moving[::9], strict=True):
        shown = [shape.role for shape in shapes if isinstance(shape, Polygon) and shape.points and "steam" in shape.role]
        at = gear.position(pose)
        assert sorted(shown) == sorted(3 * [steam_phase(gear, at, 1.0)] + 3 * [steam_phase(gear, at, -1.0)])  # cylinder, passage, engine


def test_the_key_has_the_colour_of_each_phase_beside_its_name(drawn):
    words = {shape.text: shape for shape in drawn.still if isinstance(shape, TextShape)}
    for role, name in PHASE_NAMES.items():
        word, boxes = words[name], [bounding_box([shape]) for shape in of_role(drawn.still, f"{role} key", Polygon)]
        assert any(left < right < word.x and low < word.y < high for left, right, low, high in boxes)


def test_shown_ports_are_open_or_shut_unless_they_are_chosen(drawn):
    run, shown = drawn.run, shown_readings(drawn.run)
    for name in ("crank_end_steam", "crank_end_exhaust", "head_end_steam", "head_end_exhaust"):
        np.testing.assert_array_equal(shown[name].values, np.maximum(run.readings[name], 0.0))
        np.testing.assert_array_equal(chosen_readings(run, [name])[name].values, run.readings[name])
        assert np.min(run.readings[name]) < 0.0 < np.max(run.readings[name])


def test_the_crank_pin_and_the_displacement_lie_on_one_ray(drawn):
    gear = drawn.drawing
    (rim,) = (shape.lines[0] for shape in of_role(drawn.still, "rim"))
    centre = np.mean(rim[:-1], axis=0)
    radius = math.dist(centre, rim[0])
    for pose, shapes in zip(drawn.run.poses[::9], drawn.moving[::9], strict=True):
        at = gear.position(pose)
        marks = [shape for shape in shapes if isinstance(shape, Circle) and shape.role.endswith("mark") and shape.radius > 0]
        assert len(marks) == 1 or abs(at.valve_displacement) < 1e-12
        for mark in marks:
            x, y = mark.x - centre[0], mark.y - centre[1]
            assert abs(math.remainder(math.atan2(y, x) - at.crank_angle, math.tau)) < 1e-9
            # an eccentric's radius reaches to 0.8 of the circle
            np.testing.assert_allclose(math.hypot(x, y), 0.8 * radius * abs(at.valve_displacement) / gear.eccentric, atol=1e-12)


@pytest.mark.parametrize("vision", VISIONS)
def test_the_colours_of_the_steam_differ_for_every_reader(vision):
    """By 8 in CIELAB, three to four times what the eye notices side by side (2.3); frames and names say the same without colours."""
    seen = [lab(ROLE_STYLES[phase].fill, VISIONS[vision]) for phase in STEAM_PHASES]
    assert min(np.linalg.norm(one - other) for one, other in combinations(seen, 2)) > 8.0


def level_words(figure):
    found = [*figure.texts]
    for axes in figure.axes:
        found += [*axes.texts, *(axes.get_legend().get_texts() if axes.get_legend() else ())]
    return [text for text in found if text.get_text() and text.get_rotation() == 0]


def overlaps(figure):
    """Pairs of words on each other, and words outside the inner frame."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)  # legends find their places
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in level_words(figure)]
    width, height = figure.get_size_inches() * figure.dpi
    frame = 6.5 / 25.4 * figure.dpi  # the inner line stands 6.5 mm inside the sheet
    out = [words for words, box in boxes if box.x0 < frame or box.x1 > width - frame or box.y0 < frame or box.y1 > height - frame]

    def overlap(a, b):
        return min(a.x1, b.x1) - max(a.x0, b.x0) > 1 and min(a.y1, b.y1) - max(a.y0, b.y0) > 2

    return out, [(one, other) for (one, a), (other, b) in combinations(boxes, 2) if overlap(a, b)]


@cache
def diagram(name: str) -> EccentricDiagram:
    return EccentricDiagram(valve_scene((CASES | CROWDED)[name]))


PLATES = {"zeuner": zeuner.draw_zeuner_plate, "marks": marks_construction.draw_marks_plate}


@pytest.mark.parametrize(
    ("plate", "name"), [("zeuner", "marks"), ("zeuner", "thirty"), ("zeuner", "endless"), ("marks", "marks"), ("marks", "thirty")]
)
def test_the_words_of_a_plate_stand_clear_within_the_frame(plate, name):
    assert overlaps(PLATES[plate](diagram(name))) == ([], [])


def test_the_letter_of_the_lap_stands_clear_of_the_steam_at_half_gear():
    scene = gm.load("stephenson_arc_middle").replace({"dimensions.reverser": 0.5})
    _, near = overlaps(zeuner.draw_zeuner_plate(ValveDiagram(scene)))
    assert not [pair for pair in near if "$e$" in pair]


@pytest.mark.long
@pytest.mark.parametrize("name", CROWDED)
@pytest.mark.parametrize(("plate", "panel"), [("zeuner", 0), ("marks", 3)])
def test_the_names_of_crowded_events_stand_clear_of_each_other(name, plate, panel):
    figure = PLATES[plate](diagram(name))
    events = {"admission", "cut-off", "release", "compression"}
    key = [text.get_text() for legend in [figure.axes[panel].get_legend()] if legend for text in legend.get_texts()]
    out, near = overlaps(figure)
    assert [words for words in out if words in events] == []
    assert [pair for pair in near if set(pair) & events and set(pair) <= events.union(key)] == []
    assert sum(text.get_text() in events for text in figure.axes[panel].texts) == 8


REVERSER = "joint.lever.motion.harmonics.1.amplitude"


@pytest.mark.parametrize("changes", [
    {}, {REVERSER: 0.0, "valve.steam_lap": "32 mm"}, {REVERSER: "-20 deg"},
], ids=["full gear", "mid gear, never open", "against its rotation"])  # fmt: skip
def test_the_words_of_the_plate_of_any_valve_stand_clear_within_the_frame(changes):
    data = ValveDiagram(parse_scene_with(gm.load("gooch").document, changes.items()))
    plate = zeuner.draw_zeuner_plate(data)
    out, near = overlaps(plate)
    assert out == []
    assert [pair for pair in near if not {"$e$", "$i$"} & set(pair)] == []  # the laps stand on their circles, wherever these are
    words = [text.get_text() for text in level_words(plate)]
    assert not any("theory" in word for word in words)
    assert words.count("cut-off") == 2 * sum(row.name.endswith("cut-off") for row in data.timing.rows)


@pytest.mark.long
def test_plates_are_png_and_equal_for_equal_scenes(tmp_path):
    runs = [MultibodyEngine().run(valve_scene(duration=0.1)) for _ in range(2)]
    plates = [write_machine_figures(run, FigureFiles(folder=tmp_path), stem) for run, stem in zip(runs, ("one", "two"), strict=True)]
    assert [path.name for path in plates[0]] == ["one_zeuner.png", "one_marks.png"]
    for first, second in zip(*plates, strict=True):
        with Image.open(first) as image:
            assert image.format == "PNG"
            assert image.size == (1637, 1157)  # A4 on its side at 140 dots an inch
        assert first.read_bytes() == second.read_bytes()
    assert sorted(tmp_path.iterdir()) == sorted([*plates[0], *plates[1]])


def test_what_a_plate_cannot_show_is_refused():
    with pytest.raises(gm.MechanismError, match="needs a mechanism with a slide valve"):
        EccentricDiagram(gm.load("porter"))
    with pytest.raises(gm.MechanismError, match="an infinite one has no error"):
        marks_construction.draw_marks_plate(diagram("endless"))


def test_the_points_of_the_mechanism_lie_on_the_hyperbola():
    axes = marks_construction.draw_marks_plate(diagram("marks")).axes[1]
    (points,) = (line for line in axes.lines if line.get_marker() == "o")
    assert np.max(np.abs(points.get_ydata())) < 1e-6  # um; the curves beside it err by 46 and 67


@cache
def run_with_masses():
    return crank_run()


def crank_run(effects=None, **settings):
    loaded = {"gravity": True, "masses": SLIDER_CRANK_MASSES}
    return MultibodyEngine().run(crank_scene(effects=loaded if effects is None else effects, **settings))


def test_the_words_of_the_bearings_plate_stand_clear_within_the_frame():
    figure = bearings.bearing_loads_figure(run_with_masses())
    out, near = overlaps(figure)
    assert out == []
    # degrees may come close where the shaft's curve is narrow
    assert [pair for pair in near if not all("°" in words for words in pair)] == []


def test_numbers_of_many_figures_push_no_label_of_the_bearings_plate_over_its_frame():
    masses = {name: 1000.0 * mass for name, mass in SLIDER_CRANK_MASSES.items() if "centre" not in name}
    figure = bearings.bearing_loads_figure(crank_run({"gravity": True, "masses": masses}))
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    assert figure.axes[0].yaxis.label.get_window_extent(renderer).x0 > 0.21 * figure.dpi


@pytest.mark.parametrize("masses", [{"crank": 80.0}, {"crank": 80.0, "rod": 70.0}, {"crank": 80.0, "crosshead": 110.0}])
def test_bearings_between_massless_parts_are_left_out(masses):
    assert bearings.bearing_loads_figure(crank_run({"masses": masses}))


def test_runs_whose_bearings_have_nothing_to_show_are_refused():
    with pytest.raises(gm.MechanismError, match=r"with effects\.masses"):
        bearings.bearing_loads_figure(crank_run({}))
    with pytest.raises(gm.MechanismError, match="a whole turn"):
        bearings.bearing_loads_figure(crank_run(duration=0.5))


def test_a_machine_brings_its_plates(tmp_path):
    def brought(run):
        return [path.name for path in write_machine_figures(run, FigureFiles(folder=tmp_path), "mine") if path.exists()]

    engine = MultibodyEngine()
    assert brought(engine.run(valve_scene(CASES["endless"], duration=0.1))) == ["mine_zeuner.png"]
    assert brought(run_with_masses()) == ["mine_bearings.png"]
    assert brought(crank_run({})) == brought(crank_run(duration=0.5)) == []
