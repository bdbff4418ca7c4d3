"""Loads, cranks and readings in the drawing of any mechanism: arrows are the forces of the run, arcs the angles of its readings."""

import math
from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import data_of
from drawing_checks import Drawn, assert_shapes_keep, of_role
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.render.geometry.primitives import Circle, Polygon, TextShape, bounding_box
from governor_mechanism.render.machines.generic.drawing import make_letters
from governor_mechanism.render.plot_panels import choose_part_panels
from governor_mechanism.render.shown_readings import format_label, format_name

DURATIONS = {"slider_crank": "0.5 s", "andrews_squeezer": "0.01 s", "pendulum_iftomm": "2 s"}


@cache
def draw(name):
    return Drawn(gm.run(gm.load(name).replace({"run.duration": DURATIONS.get(name, "1 s")})))


def arrows_of(shapes, role):
    """Return tail and vector of each arrow of a role; NaN for one without length."""
    found, halves = [], of_role(shapes, role)
    for line, head in zip(halves[::2], halves[1::2], strict=True):
        tail = np.array(line.lines[0][0] if line.lines else (np.nan, np.nan))
        found.append((tail, np.array(head.points[0]) - tail if head.points else np.full(2, np.nan)))
    return found


@pytest.fixture(scope="module")
def slider_crank():
    return draw("slider_crank")


def test_the_arrows_of_a_slider_crank_accelerate_its_crosshead(slider_crank):
    """Newton's law in the scale of the key: the forces of gudgeon and guide and the weight of 110 kg against the known acceleration.

    The distance of the crosshead is r cos a + sqrt(l^2 - r^2 sin^2 a), at 120 rpm.
    """
    run, still = slider_crank.run, slider_crank.still
    ((_, key),) = arrows_of(still, "reaction key")
    number, unit = next(shape.text for shape in still if isinstance(shape, TextShape)).split()
    newton = math.hypot(*key) / (float(number) * {"N": 1.0, "kN": 1e3}[unit])
    r, rod, speed = 0.3, 1.5, 4 * math.pi

    def distance(time):
        return r * math.cos(speed * time) + math.sqrt(rod**2 - (r * math.sin(speed * time)) ** 2)

    for row in (3, 40, 77, 151):
        time, step = float(run.times[row]), 1e-4
        acceleration = (distance(time - step) - 2 * distance(time) + distance(time + step)) / step**2
        gudgeon, guide = (vector / newton for _, vector in arrows_of(slider_crank.at(row), "reaction")[2:])
        # The second difference is accurate to 1e-6 of some 50 m/s2, of which rounding is the larger part.
        assert gudgeon[0] + guide[0] == pytest.approx(110.0 * acceleration, rel=1e-5, abs=0.1)
        assert gudgeon[1] + guide[1] == pytest.approx(110.0 * 9.81, rel=1e-5)


def test_the_arrows_of_a_slider_crank_are_the_reactions_at_their_joints(slider_crank):
    run, scales = slider_crank.run, []
    for row in (0, 60, 200):
        arrows = arrows_of(slider_crank.at(row), "reaction")
        for (tail, vector), name in zip(arrows, ("shaft", "crank pin", "gudgeon", "crosshead guide"), strict=True):
            force = run.reactions[name].force[row]
            scales.append(math.hypot(*vector) / math.hypot(*force))
            assert vector @ force == pytest.approx(math.hypot(*vector) * math.hypot(*force), rel=1e-9)
            if name != "crosshead guide":
                joint = next(joint for joint in run.scene.mechanism.joints if joint.name == name)
                np.testing.assert_allclose(tail, point_path(run.scene.mechanism, run.poses[row : row + 1], joint.second)[0], atol=1e-12)
    assert np.ptp(scales) < 1e-9 * scales[0]


def test_a_massless_slider_crank_has_no_arrows():
    dimensions = {"crank": "0.3 m", "connecting_rod": "1.5 m", "crank_speed": "120 rpm"}
    settings = {"duration": "0.1 s", "engine": "multibody"}
    scene = gm.Scene.from_dict({"title": "Massless", "machine": "slider_crank", "dimensions": dimensions, "run": settings})
    assert "reaction" not in Drawn(gm.run(scene)).roles()


@pytest.fixture(scope="module")
def quick_return():
    return draw("quick_return")


def test_the_arrow_at_the_ram_opposes_its_motion_in_proportion(quick_return):
    run = quick_return.run
    ram, ratios = run.body_names.index("ram"), []
    for row in range(0, len(run.times), 7):
        ((_, vector),) = arrows_of(quick_return.at(row), "force")
        if np.isfinite(vector).all():
            assert vector[1] == pytest.approx(0.0, abs=1e-12)
            ratios.append(vector[0] / run.velocities[row, ram, 0])
    assert len(ratios) > 10
    assert max(ratios) < 0.0
    assert np.ptp(ratios) < 1e-9 * abs(ratios[0])
    texts = [shape.text for shape in quick_return.still if isinstance(shape, TextShape)]
    largest = 200.0 * np.abs(run.velocities[:, ram, 0]).max()
    assert texts == [f"cut: damper, both strokes, up to {largest:.3g} N"]
    assert "damper" not in quick_return.roles()


def test_the_lever_stays_clear_of_the_guide_of_the_ram(quick_return):
    guide = [wall for wall in of_role(quick_return.still, "wall") if bounding_box([wall])[2] > 0.35]
    _, _, lowest, _ = bounding_box(guide)
    for shapes in quick_return.moving[::5]:
        assert bounding_box(of_role(shapes, "plate"))[3] < lowest
    # The linings of the two walls mirror one another.
    lower, upper = sorted(guide, key=lambda wall: bounding_box([wall])[2])
    (x0, _), (x1, _) = upper.lines[-1]
    assert any(math.isclose(x0, start[0]) and math.isclose(x1, end[0]) for start, end in lower.lines[1:])


def test_a_crank_shows_its_disc_and_the_circle_of_its_pin_and_stands_before_the_lever(quick_return):
    (disc,) = of_role(quick_return.still, "crank web")
    assert (disc.x, disc.y, disc.radius) == pytest.approx((0.0, 0.2, 0.1))
    (circle,) = of_role(quick_return.still, "crank circle")
    np.testing.assert_allclose(np.hypot(*(np.array(circle.lines[0]) - (0.0, 0.2)).T), 0.08, rtol=1e-12)
    roles = [(shape.role, shape) for shape in quick_return.at(10)]
    slot = next(k for k, (role, _) in enumerate(roles) if role == "slot")
    crank = [k for k, (role, shape) in enumerate(roles) if role == "plate" and bounding_box([shape])[3] < 0.32 and k > slot]
    assert crank


def test_arcs_are_the_angles_of_the_readings_with_their_letters():
    drawn = draw("andrews_squeezer")
    run, drawing = drawn.run, drawn.drawing
    names = ["beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon"]
    for row in (0, 40, 100):
        arcs, rays, letters = (of_role(drawn.at(row), role) for role in ("angle arc", "angle ray", "letter"))
        assert len(arcs) == len(letters) == len(names)
        for name, arc, ray, letter in zip(names, arcs, rays, letters, strict=True):
            hinge = np.array(ray.lines[0][0])
            headings = np.unwrap([math.atan2(*(np.array(point) - hinge)[::-1]) for point in arc.lines[0]])
            turn = headings[-1] - headings[0] - run.readings[name][row]
            assert math.remainder(turn, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
            x0, x1, y0, y1 = bounding_box([letter])
            reference = bounding_box([make_letters((name,), (0.0, 0.0), 0.055 * drawing.length_scale)])
            assert (x1 - x0, y1 - y0) == pytest.approx((reference[1] - reference[0], reference[3] - reference[2]))
    order = [shape.role for shape in drawn.at(0)]
    assert order.index("force") < order.index("plate")  # the torque lies behind the bodies


def test_letters_of_angles_are_clear_of_bars():
    run = gm.run("andrews_squeezer")
    mechanism, drawn = run.scene.mechanism, Drawn(run)
    pins = {joint.name: point_path(mechanism, run.poses, joint.second) for joint in mechanism.joints}
    bars = [("O", "F"), ("F", "E of BDE"), ("B", "E of BDE"), ("A of AG", "G"), ("G", "E of BDE"), ("A of AH", "H"), ("H", "E of BDE")]
    for row in range(0, len(run.times), 10):
        for letter in of_role(drawn.at(row), "letter"):
            x0, x1, y0, y1 = bounding_box([letter])
            for first, second in bars:
                away, along = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)]) - pins[first][row], pins[second][row] - pins[first][row]
                share = np.clip(away @ along / (along @ along), 0.0, 1.0)
                # Half the height of a small letter, and half the width of a bar.
                assert np.linalg.norm(away - share * along) > 0.033 * drawn.drawing.length_scale, (first, second, row)


def test_the_point_with_the_coordinates_x_and_y_is_marked():
    run = draw("four_bar_chain").run
    for row in (0, -1):
        shapes = draw("four_bar_chain").at(row)
        (mark,) = of_role(shapes, "tracer", Circle)
        assert (mark.x, mark.y) == pytest.approx((run.readings["x"][row], run.readings["y"][row]), abs=1e-9)
        (letters,) = of_role(shapes, "letter")
        # They say that the coordinates are those of a point: P (x, y).
        assert len(letters.lines) == len(make_letters(["P", "(", "x", ",", "y", ")"], (0.0, 0.0), 1.0).lines)


def test_the_letters_of_a_pendulum_are_clear_of_its_bar():
    """The bar leads from the origin to the mass, whose centre has the coordinates: they are on its far side."""
    run = draw("pendulum_iftomm").run
    for row in range(0, len(run.times), 20):
        (letters,) = of_role(draw("pendulum_iftomm").at(row), "letter")
        x0, x1, y0, y1 = bounding_box([letters])
        mass = np.array([run.readings["x"][row], run.readings["y"][row]])
        assert np.array([(x0 + x1) / 2, (y0 + y1) / 2]) @ mass > mass @ mass


@pytest.mark.parametrize("name", ["slider_crank", "quick_return", "andrews_squeezer", "four_bar_chain"])
def test_nothing_leaves_the_picture(name):
    assert_shapes_keep(draw(name))


def test_greek_names_are_written_as_letters():
    names = {"beta": "β", "Theta": "Θ", "Omega": "Ω", "sigma": "σ", "part.delta": "part δ", "arm_angle": "arm angle"}
    assert {name: format_name(name) for name in names} == names
    # The capital of a letter is another symbol.
    assert [format_label(name, "°") for name in ("beta", "x", "arm_angle")] == ["β [deg]", "x [deg]", "Arm angle [deg]"]
    assert format_name("Beta") == "Beta"  # a capital like a Latin letter would not be read as Greek


def test_the_plot_of_an_angle_that_has_only_a_letter_names_the_body_that_turns():
    panels = choose_part_panels([data_of(draw("andrews_squeezer").run)], most=4, with_speed=False)
    assert [panel.name for panel in panels][:2] == ["β, crank OF", "Θ, coupler FE"]


def test_letters_stand_around_their_place():
    for name in ("alpha", "beta", "gamma", "delta", "epsilon", "theta", "phi", "psi", "omega", "Theta", "Phi", "Omega", "x", "y"):
        shape = make_letters((name,), (2.0, 3.0), 0.1)
        x0, x1, y0, y1 = bounding_box([shape])
        assert (x0 + x1) / 2 == pytest.approx(2.0, abs=0.01)
        assert 2.9 < y0 < 3.0 < y1 < 3.1
        assert not isinstance(shape, Polygon)
