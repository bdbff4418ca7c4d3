"""Paths of points: circles of cranks, the foot of a walking leg, names, and what a film refuses."""

import numpy as np
import pytest

import governor_mechanism as gm


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
