"""Paths of points: circles of cranks, the foot of a walking leg, names, and what a film refuses."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.render.film.frame_painter import PointPaths
from governor_mechanism.render.frame_data import FrameData


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
    ends = [[part.shapes_at(k)[0].lines[0][-1] for part in paths.parts()] for k in range(count)]
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
