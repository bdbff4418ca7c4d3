"""Films and figures of scenes of several parts: every part in a panel, drawn where it is."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import governor_mechanism as gm
from coupled_scenes import coupled_scene, engine_part, porter_part
from decoding import decode_film, words_of
from drawing_checks import Drawn, of_role
from governor_mechanism.model.coupling.couplings import GearCoupling
from governor_mechanism.model.time_functions import InputFunction, LinearFunction
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import Circle, Lines
from governor_mechanism.render.machines.registry import drawing_of
from governor_mechanism.render.shown_readings import shown_readings

GAIN, LAG = -20.0, 0.3


@pytest.fixture(scope="module")
def run():
    """An engine, its torque a lagged function of the sleeve lift, geared to a Porter governor; the engine turns twice in a second."""
    torque = InputFunction(values=(2.0,), functions=(LinearFunction(reading="governor.sleeve_lift", gain=GAIN, lag=LAG),))
    scene = coupled_scene(
        engine_part(rate=13.0, torque=torque),
        porter_part(start_speed=None),
        couplings=(GearCoupling(name="belt", first="engine.crank_angle", second="governor.spindle_angle"),),
    )
    return gm.run(scene, accuracy=1e-8, certify=False)


def frame_data(run, name, times=(0.0, 0.7, 1.4)):
    part = next(part for part in run.scene.parts if part.name == name)
    return FrameData(run, part, (0.0, 2.0), np.array(times))


def test_shafts_are_not_drawn_and_poses_go_to_their_parts(run):
    assert run.body_names[-1] == "governor.spindle"
    engine, governor = frame_data(run, "engine", run.times), frame_data(run, "governor", run.times)
    assert_allclose(engine.poses[:, 0, 2], run.readings["engine.crank_angle"], rtol=0, atol=1e-12)
    assert [body.name for body in governor.part.mechanism.bodies] == ["right ball", "left ball", "sleeve"]
    assert_allclose(governor.poses[:, 0, 0], run.readings["governor.ball_radius"], rtol=0, atol=1e-12)


def test_a_flywheel_turns_with_its_angle_and_has_the_size_of_its_inertia(run):
    data = frame_data(run, "engine")
    radius = math.sqrt(2.0 / 1.0)  # of gyration: 2 kg m2 and 1 kg
    for k, time in enumerate(data.times):
        shapes = list(data.drawing.moving_shapes(data.poses[k], float(time)))
        assert max(shape.radius for shape in shapes if isinstance(shape, Circle)) == pytest.approx(radius)
        start, end = of_role(shapes, "marked spoke", Lines)[0].lines[0]
        drawn = math.atan2(end[1] - start[1], end[0] - start[0])
        angle = np.interp(time, run.times, run.readings["engine.crank_angle"])
        # Linear between reported times: h^2 / 8 times an acceleration of about 1 rad/s2.
        assert math.remainder(drawn - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-4)


def test_angles_of_many_turns_are_shown_by_their_rates(run):
    shown = shown_readings(run)
    assert "engine.crank_angle" not in shown
    assert "governor.spindle_angle" not in shown
    assert_array_equal(shown["engine.crank_rate"].values, run.rates["engine.crank_angle"])
    assert shown["engine.crank_rate"].unit == "rad/s"
    assert_array_equal(shown["governor.arm_angle"].values, run.readings["governor.arm_angle"])


def test_every_part_has_a_panel_and_its_first_reading_a_plot(run):
    data = [frame_data(run, name) for name in ("engine", "governor")]
    painter = FramePainter(run, data, 480)
    assert painter.draw(1).shape == (480, 766, 4)
    assert {"engine", "governor", "crank rate", "arm angle", "sleeve lift", "view turns with spindle"} <= set(words_of(painter.figure))


def test_a_film_of_one_part_is_as_wide_as_any_other(run, tmp_path):
    frames, _ = decode_film(gm.film(run, tmp_path / "one.gif", part="governor", stop=0.1, slow_down=1))
    assert frames.shape[1:] == (480, 480, 3)
    with pytest.raises(gm.MechanismError, match="Did you mean 'governor'"):
        gm.film(run, tmp_path / "none.gif", part="govenor")


@pytest.mark.long
def test_two_runs_of_several_parts_share_their_panels(run, tmp_path):
    path = gm.film([run, run], tmp_path / "two.gif", titles=("a", "b"), stop=0.1, slow_down=1)
    assert path.stat().st_size > 0
    alone = gm.run("porter", accuracy=1e-4, certify=False, times=run.times)
    frames, _ = decode_film(gm.film([run, alone], tmp_path / "mixed.gif", stop=0.1, slow_down=1))
    assert frames.shape[1:] == (480, 766 + 480, 3)  # 286 pixels for each further part


def test_loads_of_readings_are_drawn_with_their_lag(run):
    moment, zero = drawing_of(run, run.scene.parts[0]).load_functions["load"](run.times)
    assert not zero.any()
    lift = run.readings["governor.sleeve_lift"]
    # The exact response of the lag to the lift, linear between the reported times.
    expected, h = [GAIN * lift[0]], float(run.times[1])
    for before, after in zip(GAIN * lift[:-1], GAIN * lift[1:], strict=True):
        slope, decay = (after - before) / h, math.exp(-h / LAG)
        expected.append(decay * expected[-1] + (1 - decay) * (before - slope * LAG) + slope * h)
    # The drawing holds the input over a step of h = 20 ms: it leads by at most h / 2, about 0.1 m/s * GAIN * h / 2.
    assert_allclose(moment, 2.0 + np.array(expected), rtol=0, atol=0.02)


def test_the_ball_of_a_heavy_arm_is_drawn_at_its_mass_centre():
    run = gm.run("haug_governor", accuracy=1e-4, certify=False, times=[0.0, 0.5])
    drawn = Drawn(run)
    assert drawn.drawing.part.mechanism.bodies[0].name == "arm"
    assert [(ball.x, ball.y) for ball in of_role(drawn.at(0), "ball")] == [pytest.approx(tuple(run.poses[0, 0, :2]))]
    assert run.readings["arm_angle"][0] == pytest.approx(math.radians(45), abs=0.02)
