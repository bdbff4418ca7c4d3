"""Zehnder's plate: the osculation point, its circle, the true and the misread speeds, a picture without collisions."""

import dataclasses
import math
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.render.figures.plates import isochronous as parabolas
from governor_mechanism.render.figures.plates.isochronous import IsochronousPlateData, has_isochronous_parabolas, isochronous_figure
from governor_mechanism.scenes.library import load_scene, shipped_scenes
from reference import zehnder
from stub_run import governor_scene_of

RHOMBUSES = ("porter", "watt", "watt_crossed", "watt_improved")


@pytest.fixture(scope="module", params=RHOMBUSES)
def scene(request):
    return load_scene(request.param)


@pytest.fixture(scope="module")
def figure(scene):
    return isochronous_figure(scene)


def upright_words(figure):
    """All that is written level, but for tick labels beyond the ends of their axes."""
    labels = []
    for axes in figure.axes:
        labels += [*axes.texts, axes.xaxis.label, *(axes.get_legend().get_texts() if axes.get_legend() else ())]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = axis.get_view_interval()
            labels += [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [text for text in [*figure.texts, *labels] if text.get_rotation() % 180 == 0]


@pytest.mark.long
def test_the_plate_is_a_png_and_equal_for_equal_scenes(tmp_path):
    first, second = (isochronous_figure(load_scene("watt_improved")).save(tmp_path / file) for file in ("a.png", "b.png"))
    with Image.open(first) as image:
        assert image.format == "PNG"
        assert image.size == (1637, 1157)  # A4 on its side at 140 dots an inch
    assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png"]


def is_rhombus(part):
    given = part.dimensions
    equal = part.machine == "pendulum_governor" and given["arm"] == given["arm_joint"] == given["link"]
    return equal and given["lug_offset"] == given["offset"]


def test_only_a_loaded_or_unloaded_rhombus_has_parabolas():
    scenes = {name: load_scene(name) for name in shipped_scenes()}
    shown = {name for name, scene in scenes.items() if has_isochronous_parabolas(scene)}
    assert shown >= {*RHOMBUSES, "porter_free_spindle"}
    assert shown == {name for name, scene in scenes.items() if is_rhombus(scene.parts[0])}
    porter = load_scene("porter")
    for effects in ((Gravity(),), (Centrifugal(),)):
        assert not has_isochronous_parabolas(porter.with_changes(effects=effects))


@pytest.mark.parametrize("name", ["porter_extended_arms", "porter_uncrossed_links", "parabolic", "quick_return"])
def test_other_scenes_are_refused(name):
    with pytest.raises(MechanismError, match=r"isochronous parabolas need .* differs"):
        isochronous_figure(load_scene(name))


def test_crossed_arms_osculate_at_the_angle_of_least_speed():
    plate = IsochronousPlateData(load_scene("watt_improved"))
    # the scene's offset and the reference are given to 12 digits
    assert math.degrees(plate.start_angle) == pytest.approx(zehnder.FOLD_JUMP["least_stable_deg"], abs=1e-9)
    assert plate.start_speed == pytest.approx(zehnder.FOLD_JUMP["lowest_speed"], rel=1e-11)
    assert plate.starts_at_osculation
    assert plate.radius_of_curvature == pytest.approx(plate.governor.arm, rel=1e-12)  # rounding
    assert plate.centre_of_curvature == pytest.approx(plate.suspension, abs=1e-12)


def test_the_circle_of_curvature_clings_to_the_parabola_at_the_start(scene):
    plate = IsochronousPlateData(scene)
    (x, y), (across, up) = plate.start_point, plate.centre_of_curvature
    assert math.hypot(x - across, y - up) == pytest.approx(plate.radius_of_curvature, rel=1e-14)
    # the ball's circle touches there: both centres lie on the normal
    assert (x - plate.governor.offset) / plate.governor.arm == pytest.approx((x - across) / plate.radius_of_curvature, rel=1e-12)
    assert math.tan(plate.start_angle) == pytest.approx(2 * x / plate.double_parameter(plate.start_speed), rel=1e-12)
    near = x + np.array([0.02, 0.01]) * x
    gaps = up - np.sqrt(plate.radius_of_curvature**2 - (near - across) ** 2) - near**2 / plate.double_parameter(plate.start_speed)
    assert gaps[0] / gaps[1] == pytest.approx(8, rel=0.03)  # contact of second order: the gap grows with the cube


def test_open_arms_start_where_they_rest_at_the_scenes_speed():
    scene = load_scene("porter")
    plate = IsochronousPlateData(scene)
    assert not plate.starts_at_osculation
    assert plate.start_speed == pytest.approx(scene.spindle.speeds[0], rel=1e-12)
    assert plate.radius_of_curvature > plate.governor.arm


@pytest.mark.parametrize("speed", [0.0, 2.0, 30.0])
def test_open_arms_without_a_fitting_point_of_rest_start_in_the_middle_of_the_travel(speed):
    governor = PendulumGovernor(arm=0.3, offset=0.04, ball_mass=5.0, sleeve_mass=20.0)
    plate = IsochronousPlateData(governor_scene_of(governor, "Porter", speed, RunSettings(), 0.5))
    assert plate.start_angle == pytest.approx(math.pi / 4)


def test_a_spindle_that_turns_backwards_rests_like_one_that_turns_forwards():
    scene = load_scene("porter")
    back = scene.with_changes(spindle=Spindle(speeds=(-scene.spindle.speeds[0],)))
    assert vars(IsochronousPlateData(back)) == vars(IsochronousPlateData(scene))


def test_a_free_spindle_starts_at_its_start_speed():
    assert IsochronousPlateData(load_scene("porter_free_spindle")).start_angle == pytest.approx(math.radians(40), abs=1e-9)


def test_the_family_lies_about_the_speed_at_the_start(scene):
    plate = IsochronousPlateData(scene)
    assert len(plate.speeds) == 7
    assert plate.speeds[3] == plate.start_speed
    assert np.all(np.diff(plate.speeds) > 0)
    for speed in plate.speeds:
        x, y = plate.point_at_45_degrees(speed)
        assert x == pytest.approx(2 * y, rel=1e-14)
        assert 2 * x / plate.double_parameter(speed) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("name", RHOMBUSES)
def test_what_is_written_beneath_is_what_the_curves_show(name):
    assert parabolas.ZEHNDER_VERDICTS.keys() == parabolas.ARM_STYLES.keys()
    plate = IsochronousPlateData(load_scene(name))
    down, up = parabolas.MARKED_ANGLE_CHANGES < 0, parabolas.MARKED_ANGLE_CHANGES > 0

    def signs_of(share):
        at = plate.speed_deviations(share, parabolas.MARKED_ANGLE_CHANGES)
        curves = at.parabola_speed_changes, at.equilibrium_speed_changes
        return [np.unique(np.sign(values[side])).tolist() for values in curves for side in (down, up)]

    lower, higher = [-1.0], [1.0]
    assert {share: signs_of(share) for share in parabolas.ZEHNDER_VERDICTS} == {  # as read: down, up; in truth: down, up
        1.0: [lower, higher, higher, higher],
        1.3: [lower, lower, higher, lower],
        0.7: [higher, higher, lower, higher],
    }


def test_arms_that_would_hang_or_cross_the_axis_are_left_out_of_the_curves():
    governor = PendulumGovernor(arm=0.4, offset=-1e-4, ball_mass=1.0)
    plate = IsochronousPlateData(governor_scene_of(governor, "nearly on the axis", 6.0, RunSettings(), 0.5))
    curve = plate.speed_deviations(1.3)
    assert math.degrees(plate.start_angle) < 8
    assert np.all(curve.angle_changes > -plate.start_angle)
    assert np.all(np.isfinite(curve.equilibrium_speed_changes))
    assert np.all(np.isfinite(curve.parabola_speed_changes))


def test_no_words_collide_and_none_leaves_the_plate(figure):
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in upright_words(figure)]
    assert len(boxes) > 40
    frame = 6.5 / 25.4 * figure.dpi  # the inner line stands 6.5 mm inside the sheet
    for words, box in boxes:
        assert frame < box.x0 < box.x1 < figure.bbox.width - frame, words
        assert frame < box.y0 < box.y1 < figure.bbox.height - frame, words
    for (one, first), (other, second) in combinations(boxes, 2):
        apart = first.x1 <= second.x0 or second.x1 <= first.x0 or first.y1 <= second.y0 + 3 or second.y1 <= first.y0 + 3
        assert apart, (one, other)  # lines of one text block may touch within 3 pixels


def test_the_claim_and_the_correct_words_stand_in_a_row_under_their_headings(figure):
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = {text.get_text(): text.get_window_extent(renderer) for text in figure.texts}
    for wrong, right in parabolas.ZEHNDER_VERDICTS.values():
        assert boxes[wrong].x0 == pytest.approx(boxes["as Zehnder has it"].x0, abs=2)  # side bearings of letters
        assert boxes[right].x0 == pytest.approx(boxes["correct"].x0, abs=2)
        assert boxes[wrong].y1 == pytest.approx(boxes[right].y1, abs=4)  # letters of different heights
        assert boxes[wrong].x1 < boxes[right].x0


def test_a_title_with_signs_of_formulas_and_many_words_is_shown_as_far_as_it_fits(tmp_path):
    scene = dataclasses.replace(load_scene("watt"), title="Watt $ governor ^_{ " + 40 * "at length ")
    assert isochronous_figure(scene).save(tmp_path / "a.png").exists()
