"""A view with sliders: equilibria, poses and sentences follow the values, mistakes are sentences, and the result is a scene."""

import math
import re
import sys
import tomllib
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.path import Path

import governor_mechanism as gm
from governor_mechanism.notebook.exploring.plot_svg import BOTTOM, LEFT, RIGHT, TOP, Plot
from governor_mechanism.render.geometry.primitives import Polygon
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.style import GREEN, INK

SVG = "{http://www.w3.org/2000/svg}"


def pictures(view):
    """The drawing and the curve of a view, parsed."""
    return [picture for (picture,) in ElementTree.fromstring(view.pictures_html)]


def group_by_role(shapes):
    """Outlines by what they show."""
    groups = {}
    for shape in shapes:
        if isinstance(shape, Polygon):
            groups.setdefault(shape.role, []).append(shape)
    return groups


def text_of(view):
    return "".join(ElementTree.fromstring(f"<page>{view.html}</page>").itertext())


def porter_speed(arm_angle, arm, offset=0.04, ball_mass=5.0, sleeve_mass=20.0):
    """Zehnder's equilibrium speed of a Porter governor with links as long as its arms, rad/s."""
    return math.sqrt(9.81 * (1 + sleeve_mass / ball_mass) * math.tan(arm_angle) / (offset + arm * math.sin(arm_angle)))


@pytest.mark.parametrize(("arm", "sleeve_mass", "speed"), [(0.3, 20.0, "120 rpm"), (0.36, 20.0, "130 rpm"), (0.25, 12.0, "110 rpm")])
def test_the_equilibrium_follows_dimensions_and_speed(arm, sleeve_mass, speed):
    view = gm.explore("porter", "arm", "sleeve_mass")
    for name, value in (("arm", arm), ("sleeve_mass", sleeve_mass), ("spindle_speed", speed)):
        view.set(name, value)
    found = porter_speed(view.equilibrium.coordinate, arm, sleeve_mass=sleeve_mass)
    assert found == pytest.approx(float(speed.split()[0]) * math.pi / 30, rel=1e-10)  # Newton's method ends at rounding
    assert view.equilibrium.stable
    assert view.problem == ""
    np.testing.assert_allclose(
        view.speed_curve.speed, [porter_speed(one, arm, sleeve_mass=sleeve_mass) for one in view.speed_curve.coordinate]
    )


def test_the_drawing_shows_the_pose_to_scale():
    view = gm.explore("porter", "arm")
    view.set("arm", "400 mm")
    drawing = pictures(view)[0]
    circles = [(float(one.get("cx")), float(one.get("r"))) for one in drawing.iter(f"{SVG}circle")]
    largest = max(radius for _, radius in circles)
    left, right = sorted(x for x, radius in circles if radius == largest)
    (bar_text,) = [one for one in drawing.iter(f"{SVG}text") if one.get("font-size") == "10"]
    bar = next(one.get("d") for one in drawing.iter(f"{SVG}path") if re.fullmatch(r"M[\d.]+ [\d.]+H[\d.]+M.*v6M.*v6", one.get("d")))
    start, end = (float(number) for number in re.match(r"M([\d.]+) [\d.]+H([\d.]+)", bar).groups())
    scale = (end - start) / float(bar_text.text.removesuffix(" mm"))
    # The bar is written to 0.1 pixels of some 80.
    assert 0.5 * (right - left) / scale == pytest.approx(1e3 * view.equilibrium.readings["ball_radius"], rel=3e-3)


@pytest.mark.parametrize("scene", ["porter", "watt"])
def test_the_throttle_lever_passes_beside_arms_and_links_at_every_speed(scene):
    view = gm.explore(scene)
    (low, high), first = view.ranges["spindle_speed"], view.values["spindle_speed"]
    for speed in (low, first, 0.5 * (first + high), high):
        view.set("spindle_speed", speed)
        shapes = view._view.drawing_at(view._state.position)._drawing.moving_shapes(view._state.pose, 0.0)
        outlines = {role: [Path(shape.points) for shape in group] for role, group in group_by_role(shapes).items()}
        (lever,) = outlines["throttle lever"]
        assert len(outlines["arm"]) == len(outlines["link"]) == 2
        assert not any(lever.intersects_path(other) for other in outlines["arm"] + outlines["link"])


@pytest.mark.parametrize("scene", ["porter", "hartnell"])
def test_the_machine_is_as_high_as_in_its_film(scene):
    run = gm.run(scene)
    *_, film_bottom, film_top = drawing_of(run, run.scene.part).bounds
    view = gm.explore(scene)
    *_, bottom, top = view._view.drawing_at(view._state.position).box
    # The drawing leaves room for a quarter of the whole travel, the film for what the run reaches: a tenth of it in the Hartnell governor.
    assert 1.0 <= (top - bottom) / (film_top - film_bottom) < 1.2


def test_a_drawing_does_not_change_while_the_pose_stays_in_its_range():
    """Bearings and lever do not jump while a slider is dragged a little, but for a far pose they move."""
    view = gm.explore("porter", "arm")
    first = view._view.drawing_at(view._state.position)
    view.set("spindle_speed", "117 rpm")
    assert view._view.drawing_at(view._state.position) is first
    view.set("spindle_speed", "200 rpm")
    assert view._view.drawing_at(view._state.position) is not first
    view.set("spindle_speed", "120 rpm")
    assert view._view.drawing_at(view._state.position) is first


def test_stops_end_the_range_of_a_motion():
    scene = gm.load("four_bar_chain").replace({"effects.stops.crank_angle": ["40 deg", "140 deg"]})
    # To a step of the positions at which stops are examined.
    assert gm.explore(scene).ranges["crank_angle"] == pytest.approx(np.radians([40.0, 140.0]), abs=math.pi / 1e4)


def test_stops_end_the_travel_of_a_drawing():
    view = gm.explore("hartung_dubois")
    angles = view._view.drawing_at(view._state.position).readings["lever_angle"]
    assert np.degrees(angles).min() >= -15.0
    assert np.degrees(angles).max() <= 15.0


def test_the_chosen_speed_is_marked_where_it_meets_the_curve():
    view = gm.explore("watt_improved", "arm")
    curve = pictures(view)[1]
    marks = [(float(one.get("cx")), float(one.get("cy"))) for one in curve.iter(f"{SVG}circle") if one.get("stroke") == INK]
    levels = [float(one.get("d").split()[1].partition("H")[0]) for one in curve.iter(f"{SVG}path") if one.get("stroke") == GREEN]
    assert [height for _, height in marks] == pytest.approx(levels * len(view.equilibria))
    assert len(marks) == 2
    assert [one.stable for one in view.equilibria] == [False, True]


@pytest.mark.parametrize(("scene", "key"), [("porter", "arm"), ("slider_crank", "crank")])
def test_a_changed_curve_stands_beside_the_given_one(scene, key):
    view = gm.explore(scene, key)
    (given,) = [one.get("d") for one in pictures(view)[1].iter(f"{SVG}path") if one.get("stroke-width") == "1.8" and "L" in one.get("d")]
    assert "as given" not in text_of(view)
    view.set(key, 0.31)
    curves = [one.get("d") for one in pictures(view)[1].iter(f"{SVG}path") if one.get("stroke-width") == "1.8" and "L" in one.get("d")]
    assert "as given" in text_of(view)
    assert len(curves) == 2
    assert curves[1] != given


def test_beyond_a_fold_there_is_no_equilibrium_and_the_pose_stays():
    view = gm.explore("watt_improved", "arm")
    ((_, fold_speed),) = view.speed_curve.folds
    view.set("spindle_speed", 1.001 * fold_speed)
    assert view.equilibrium.stable
    before = view.equilibrium.poses
    view.set("spindle_speed", 0.9 * fold_speed)
    assert view.equilibrium is None
    assert "no equilibrium" in view.problem
    assert "keeps its last pose" in text_of(view)
    np.testing.assert_allclose(view._state.pose, before, atol=1e-9)  # assembled again at the same coordinate
    view.set("spindle_speed", "70 rpm")
    assert view.equilibrium.stable
    assert view.problem == ""


def test_impossible_geometry_is_a_sentence_and_the_scene_stays():
    view = gm.explore("slider_crank", "connecting_rod")
    before = view.scene
    view.set("connecting_rod", "200 mm")
    assert "connecting_rod (200 mm) must be longer than crank (300 mm)" in view.problem
    assert view.problem in text_of(view)
    assert view.scene is before
    assert view.values["connecting_rod"] == 0.2
    view.set("crank_angle", 1.0)
    assert view.problem
    view.set("connecting_rod", "900 mm")
    assert view.problem == ""
    assert view.scene.part.dimensions["connecting_rod"] == 0.9


@pytest.mark.parametrize("angle", [0.4, 2.0, 5.5])
def test_the_pose_follows_the_leading_coordinate(angle):
    view = gm.explore("slider_crank")
    for name, value in (("crank", 0.25), ("crank_angle", angle)):
        view.set(name, value)
    distance = 0.25 * math.cos(angle) + math.sqrt(1.5**2 - (0.25 * math.sin(angle)) ** 2)
    shown = float(re.search(r"crosshead distance ([\d.]+) mm", text_of(view))[1])
    assert shown == pytest.approx(1e3 * distance, abs=0.06)  # five digits are shown
    view.show("rod_angle")
    assert view.reading == "rod_angle"
    values = view.kinematics.readings["crosshead_distance"]
    theta = view.kinematics.values
    np.testing.assert_allclose(values, 0.25 * np.cos(theta) + np.sqrt(1.5**2 - (0.25 * np.sin(theta)) ** 2), atol=1e-9)


def test_drivers_without_a_reading_that_turns_are_followed_over_one_turn():
    view = gm.explore("quick_return", "lever=390 mm:410 mm")
    assert view.ranges["time"] == (0.0, 1.0)  # 60 rpm
    assert view.readings == ("ram_position", "lever_angle")
    positions = view.kinematics.readings["ram_position"]
    assert positions[-1] == pytest.approx(positions[0], abs=1e-9)


def test_ranges_are_half_to_double_as_far_as_the_geometry_allows():
    scene = gm.load("slider_crank").replace({"dimensions.connecting_rod": "500 mm", "effects": {}})
    ranges = gm.explore(scene, "crank", "connecting_rod").ranges
    assert ranges["crank"][0] == pytest.approx(0.15)
    # Bisection finds the end to 1 % of half the range, rounded to a step.
    assert 0.49 < ranges["crank"][1] < 0.5
    assert 0.3 < ranges["connecting_rod"][0] < 0.31
    view = gm.explore("porter", "arm=200 mm:400 mm", "effects.dashpot.sleeve=10 N s/m:50 N s/m")
    assert view.ranges["arm"] == pytest.approx((0.2, 0.4))
    assert view.ranges["effects.dashpot.sleeve"] == pytest.approx((10.0, 50.0))
    assert view.scene.effects[-1].linear == view.values["effects.dashpot.sleeve"] == 30.0  # the middle of what is not given
    assert gm.explore("stephenson_arc_middle", "reverser").ranges["reverser"] == pytest.approx((-1.0, 1.0))


def test_the_result_is_a_scene():
    view = gm.explore("porter", "arm")
    view.set("arm", 0.32)
    view.set("spindle_speed", "125 rpm")
    text = view.scene.to_toml()
    assert 'arm = "320 mm"' in text
    assert 'speed = "125 rpm"' in text
    assert gm.Scene.from_dict(tomllib.loads(text)) == view.scene
    assert view.scene == gm.load("porter").replace({"dimensions.arm": "320 mm", "spindle.speed": "125 rpm"})
    view.set("arm", "300 mm")
    view.set("spindle_speed", "120 rpm")
    assert view.scene == gm.load("porter")


def test_only_what_the_sliders_change_is_changed():
    """A spindle speed that is a program, or that an engine gives, is not replaced by that of the slider."""
    view = gm.explore("porter_ramp", "arm")
    view.set("spindle_speed", "121 rpm")
    assert view.scene == gm.load("porter_ramp")
    view = gm.explore("governed_engine", "arm")
    view.set("arm", "310 mm")
    assert view.scene == gm.load("governed_engine").replace({"part.governor.dimensions.arm": "310 mm"})
    assert view.equilibrium.stable


@pytest.mark.parametrize(
    ("scene", "keys", "sentence"),
    [
        ("porter", ["amr"], "\"amr\" is no dimension of this scene; .*Did you mean 'arm'"),
        ("porter", ["dimensions.amr"], "dimensions.amr is unknown; .*Did you mean 'arm'"),
        ("porter", ["effects.dashpot.sleeve"], "effects.dashpot.sleeve has no number in this scene; give a range"),
        ("watt", ["sleeve_mass"], "dimensions.sleeve_mass has no number in this scene; give a range"),
        ("porter", ["arm=200 mm"], "is not a range; write first:last"),
        ("porter", ["arm=200 kg:300 kg"], "is a length"),
        ("slide_valve_30", ["setting"], "words"),
        ("car_axis_like", [], "2 degrees of freedom"),
        ("porter", [3], "names of dimensions"),
        ("quick_return", ["levre"], "its dimensions are lever, .*Did you mean 'lever'"),
    ],
)
def test_wrong_keys_and_scenes_are_refused(scene, keys, sentence):
    with pytest.raises(gm.MechanismError, match=sentence):
        gm.explore(scene, *keys)


def test_a_dimension_that_is_left_out_has_the_value_that_stands_for_it():
    view = gm.explore("porter", "link", "arm")
    assert view.values["link"] == 0.3
    view.set("arm", "320 mm")
    assert view.scene.part.dimensions["link"] == 0.3  # as its slider shows
    assert gm.explore("watt", "sleeve_mass=2 kg:4 kg").scene.part.dimensions["sleeve_mass"] == 3.0


def test_wrong_values_are_refused():
    view = gm.explore("porter", "arm")
    with pytest.raises(gm.MechanismError, match="Did you mean 'arm'"):
        view.set("arn", 0.3)
    with pytest.raises(gm.MechanismError, match="is a length"):
        view.set("arm", "3 kg")
    with pytest.raises(gm.MechanismError, match="this scene shows its speed curve"):
        view.show("arm_angle")
    assert view.values["arm"] == 0.3


def test_without_the_extra_the_command_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with pytest.raises(gm.MechanismError, match=r"pip install 'governor-mechanism\[notebook\]'"):
        gm.explore("porter")


def test_sliders_and_methods_change_the_same_values():
    view = gm.explore("slider_crank", "crank")
    bundle = view._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert bundle["text/html"] == view.html
    panel = view._panel
    panel._sliders["crank"].value = 240.0
    assert view.values["crank"] == pytest.approx(0.24)
    assert view.scene.part.dimensions["crank"] == pytest.approx(0.24)
    view.set("crank_angle", "90 deg")
    assert panel._sliders["crank_angle"].value == pytest.approx(90.0)
    assert panel._pictures.value == view.pictures_html
    panel._choice.value = "rod_angle"
    assert view.reading == "rod_angle"
    panel._sliders["crank"].max = 2000.0  # as where another slider has made the geometry impossible
    panel._sliders["crank"].value = 1600.0
    assert panel._sentences.value == view.sentences_html
    assert "must be longer" in panel._sentences.value


def test_values_lie_whole_steps_from_the_ends():
    """The script of a slider moves any other value to the next step, and thereby changes the scene."""
    view = gm.explore("watt_improved")
    view._repr_mimebundle_()
    assert view.scene == gm.load("watt_improved")
    view.set("arm", "401.2345 mm")
    view.set("offset", "-40 mm")
    for slider in view.sliders:
        shown = view._panel._sliders[slider.name]
        assert shown.value == pytest.approx(view.values[slider.name] * slider.display[0])
        for end in (shown.min, shown.max):
            steps = (shown.value - end) / shown.step
            assert steps == pytest.approx(round(steps), abs=1e-6)
    shown = view._panel._sliders["arm"]
    shown.value += 1e-9 * shown.step  # as the script rounds
    assert view.values["arm"] == 0.4012345


@pytest.mark.parametrize("scene", ["hartung_dubois", "parabolic", "air_engine", "slide_valve_30", "pendulum_iftomm"])
def test_every_kind_of_machine_is_shown(scene):
    view = gm.explore(scene)
    *dimensions, variable = view.sliders
    for slider in dimensions:
        view.set(slider.name, 0.5 * (slider.low + slider.high))
    view.set(variable.name, variable.value)
    assert len(pictures(view)) == 2
    assert "nan" not in view.html
    assert view.problem == "" or "it is astatic, with equilibria at" in view.problem


def test_a_plot_joins_only_neighbours_and_cuts_off_what_is_outside():
    plot = Plot("x", "y", (0.0, 4.0), (0.0, 1.0))
    plot.add_curve(np.arange(5.0), np.array([0.0, 1.0, np.nan, 0.0, 1e9]), colour="#000000")
    (path,) = [one for one in ElementTree.fromstring(plot.to_svg("")).iter(f"{SVG}path") if one.get("stroke") == "#000000"]
    points = [[[float(number) for number in pair.split()] for pair in run.split("L")] for run in path.get("d").split("M")[1:]]
    step = (RIGHT - LEFT) / 4
    assert points[0] == [[LEFT, BOTTOM], [LEFT + step, TOP]]
    assert points[1][0] == [LEFT + 3 * step, BOTTOM]
    assert points[1][1][1] < TOP
