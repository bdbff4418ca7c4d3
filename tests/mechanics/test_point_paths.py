"""Paths of points: circles of cranks, the foot of a walking leg, names, and what a film refuses."""

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import unpack_numbers
from governor_mechanism.render.figures.kinematics import _different_curves
from governor_mechanism.render.film.frame_canvas import FRAME_DPI
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.motion_layers import PointPaths
from governor_mechanism.render.page.page_data import collect_data, roles_of
from governor_mechanism.render.page.views import show_run
from governor_mechanism.render.style import ROLE_STYLES


@pytest.fixture(scope="module")
def leg():
    """Theo Jansen's leg over two turns of its crank."""
    return gm.run("jansen")


def test_the_path_of_a_named_point_is_what_its_readings_say(leg):
    np.testing.assert_allclose(leg.paths["foot"], np.stack([leg.readings["foot_x"], leg.readings["foot_y"]], axis=1), atol=1e-15)


def test_the_mass_centre_of_the_crank_stays_on_its_circle(leg):
    np.testing.assert_allclose(np.hypot(*leg.paths["crank"].T), 7.5e-3, rtol=1e-9)


def test_kinematics_has_the_same_paths_as_the_run(leg):
    motion = gm.kinematics("jansen", over="time", values=leg.times)
    np.testing.assert_allclose(motion.paths["foot"], leg.paths["foot"], atol=1e-9)


def test_points_of_the_same_name_have_that_of_their_body_in_front():
    m = gm.Mechanism.build("Two arms")
    for name in ("left", "right"):
        arm = m.rod(name, length=1.0, mass=1.0, angle="10 deg")
        arm.point(0.5, 0.0, "pen")
        m.pin(m.ground(0.0, 0.0), arm.start)
    assert {"left.pen", "right.pen"} <= set(m.scene().mechanism.path_points)


def test_an_unknown_point_is_refused_with_the_nearest(leg, tmp_path):
    with pytest.raises(gm.MechanismError, match=r"no point 'fot'.*Did you mean 'foot'"):
        leg.plot_paths("fot")
    with pytest.raises(gm.MechanismError, match=r"'fot', and no point has this name.*Did you mean 'foot'"):
        gm.film(leg, tmp_path / "leg.gif", paths=["fot"], stop=0.1)
    assert not list(tmp_path.iterdir())


def tails(run, part, names, count=9):
    """Return the last positions of the tails of a film at its frames, and the frame times."""
    times = np.linspace(float(run.times[0]), float(run.times[-1]), count)
    data = FrameData(run, part, (float(run.times[0]), float(run.times[-1])), times)
    paths = PointPaths(data, names)
    curves, *followers = paths.parts()
    assert curves.shapes == tuple(paths.shapes)
    ends = [[part.shapes_at(k)[0].lines[0][-1] for part in followers] for k in range(count)]
    return np.array(ends), times, paths


def test_the_tail_in_a_film_ends_at_the_point(leg):
    ends, times, paths = tails(leg, leg.scene.part, ["foot"])
    exact = np.stack([np.interp(times, leg.times, leg.paths["foot"][:, k]) for k in range(2)], axis=1)
    np.testing.assert_allclose(ends[:, 0], exact, atol=1e-5)
    low, high = leg.paths["foot"].min(axis=0), leg.paths["foot"].max(axis=0)
    left, right, bottom, top = paths.enclosing_box((0.0, 0.0, 0.0, 0.0))
    assert (left, bottom) == (min(low[0], 0.0), min(low[1], 0.0))
    assert (right, top) == (max(high[0], 0.0), max(high[1], 0.0))


def test_a_film_of_a_part_takes_the_names_of_the_run():
    run = gm.run("governed_engine", times=np.linspace(0.0, 0.2, 21))
    governor = next(part for part in run.scene.parts if part.name == "governor")
    ends, _, _ = tails(run, governor, ["governor.right ball"], count=3)
    np.testing.assert_allclose(ends[[0, 2], 0], run.paths["governor.right ball"][[0, 20]], atol=1e-9)


def test_ends_of_rods_and_points_of_the_ground_have_paths(leg):
    assert {"crank.start", "crank.end", "ground.O", "ground.B"} <= set(leg.paths)
    np.testing.assert_allclose(np.hypot(*leg.paths["crank.end"].T), 15e-3, rtol=1e-9)
    np.testing.assert_array_equal(leg.paths["ground.B"], np.tile([-38e-3, -7.8e-3], (len(leg.times), 1)))


def test_requested_paths_are_columns_of_run_table_and_kinematics(leg, tmp_path):
    assert leg.scene.run.paths == ("foot",)  # the shipped scene names it
    for axis, name in enumerate(("foot.x", "foot.y")):
        np.testing.assert_array_equal(leg.readings[name], leg.paths["foot"][:, axis])
        assert leg.units[name] == "m"
        assert leg.reading_errors[name] < 1e-9
    motion = gm.kinematics(leg.scene, over="time", values=leg.times[:3])
    table = motion.to_dataframe()
    np.testing.assert_allclose(table["foot.x"], leg.paths["foot"][:3, 0], atol=1e-12)
    keys = [column.key for column in motion.columns]
    assert [keys.count(key) for key in ("foot.x", "foot.y", "knee.x")] == [1, 1, 1]
    leg.save(tmp_path, figures=False)
    header, first = (tmp_path / "jansen.csv").read_text(encoding="utf-8").splitlines()[1:3]
    row = dict(zip(header.split(","), map(float, first.split(",")), strict=True))
    assert (row["foot.x"], row["foot.y"]) == pytest.approx(tuple(leg.paths["foot"][0]), rel=1e-12)
    assert gm.open_run(tmp_path).scene.run == leg.scene.run


def test_a_data_frame_takes_further_paths(leg):
    table = leg.to_dataframe(paths=["crank.end"])
    np.testing.assert_array_equal(table["crank.end.y"], leg.paths["crank.end"][:, 1])
    assert table.attrs["units"]["crank.end.y"] == "m"
    with pytest.raises(KeyError, match=r"no point 'crank.tip'.*Did you mean 'crank"):
        leg.to_dataframe(paths=["crank.tip"])


def test_a_scene_with_wrong_names_of_paths_and_readings_is_refused_with_both():
    scene = gm.load("jansen")
    with pytest.raises(gm.MechanismError) as refusal:
        scene.replace({"run.paths": ["fot"], "run.readings": ["reaction.moter"]})
    assert "run.paths: no point 'fot'; points are ['knee', 'foot', 'crank'" in str(refusal.value)
    assert "Did you mean 'foot'?" in str(refusal.value)
    assert "run.readings names 'reaction.moter': no joint 'moter'" in str(refusal.value)


def test_a_page_has_the_paths_of_the_run(leg):
    span = float(leg.times[0]), float(leg.times[-1])
    shown = show_run(leg, None, span, leg.times, 1.0)  # the samples are the reported times
    data = collect_data(shown, 1.0)
    view, picture = data["views"][0], shown.views[0].picture
    whole = picture.place(leg.paths["foot"])
    (curve,) = [shape for shape in view["shapes"] if shape["role"] == "path"]
    np.testing.assert_allclose(np.array(curve["points"]).reshape(-1, 2), whole, atol=0.5)
    (tail,) = view["trails"]
    assert tail["role"] == "tail"
    np.testing.assert_allclose(np.column_stack([unpack_numbers(tail[axis], len(leg.times)) for axis in "xy"]), whole, atol=0.5)
    assert {"path", "tail"} <= roles_of(data)


def test_a_page_draws_other_points_or_none_as_requested(leg, tmp_path):
    span = float(leg.times[0]), float(leg.times[-1])
    assert not show_run(leg, None, span, leg.times, 1.0, ()).views[0].trails
    assert len(show_run(leg, None, span, leg.times, 1.0, ("knee", "crank.end")).views[0].trails) == 2
    with pytest.raises(gm.MechanismError, match=r"'fot', and no point has this name.*Did you mean 'foot'"):
        gm.film(leg, tmp_path / "leg.html", paths=["fot"])


def test_an_animated_drawing_has_the_curve_and_its_tail(leg, tmp_path):
    tail = f'stroke="{ROLE_STYLES["tail"].stroke}" stroke-width="{ROLE_STYLES["tail"].width * 72 / FRAME_DPI:.2f}"'
    for names, is_shown in ((None, True), ([], False)):
        text = leg.film(tmp_path / "leg.svg", stop=1.0, layout="machine", paths=names).path.read_text(encoding="utf-8")
        assert (tail in text) == is_shown
        assert (ROLE_STYLES["path"].stroke in text) == is_shown


def test_the_figure_of_paths_shows_each_curve_once_and_no_point_that_rests(leg):
    moving = _different_curves(leg.paths)
    assert moving[:2] == ["knee", "foot"]
    assert not {"crank.start", "thigh.start", "ground.O", "ground.B"} & set(moving)


def test_the_point_whose_coordinates_are_x_and_y_has_its_path_unless_others_are_named():
    run = gm.run("pendulum_iftomm")
    *_, paths = tails(run, run.scene.part, None)
    (curve,) = paths.curves
    np.testing.assert_allclose(np.hypot(*curve.T), 1.0, rtol=1e-6)
    data = FrameData(run, run.scene.part, (0.0, 1.0), np.linspace(0.0, 1.0, 3))
    assert not PointPaths(data, ()).curves
