"""Where mechanisms of one's own rest, over their whole travel: turns, seams, narrow springs, places that let go."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import governor_mechanism as gm
from command_line import invoke
from data_files import read_data
from governor_mechanism.mechanics.kinematics import continuation as walking
from governor_mechanism.mechanics.kinematics import range_of_motion as travels
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from scene_documents import between, custom_document, pin, rod

TURNING = {"plane": "turning", "effects": {"gravity": True, "centrifugal": True}}
"""Tables of a mechanism that turns with its spindle."""


SCENES = read_data(__file__)


def pendulum(angle, load=None, *, gravity=True, **tables):
    return custom_document(
        body=[rod("arm", "1 m", "1 kg", angle=f"{angle} deg")],
        joint=[pin("ground.A", "arm.start")],
        readings={"q": {"angle": "arm"}},
        effects={"gravity": gravity},
        **({"force": [load]} if load else {}),
        **tables,
    )


def geared(ratio):
    return custom_document(
        ground={"O": [0, 0], "C": ["0.3 m", 0]},
        body=[
            {"name": "a", "mass": "1 kg", "disc": {"radius": "0.1 m"}, "at": [0, 0]},
            rod("b", "0.2 m", "1 kg", at=["0.3 m", 0], angle="-70 deg"),
        ],
        joint=[pin("ground.O", "a.origin"), pin("ground.C", "b.start"), between("gear", "a", "b", ratio=ratio)],
        readings={"q": {"angle": "a"}},
        effects={"gravity": True},
    )


def slide(height, spring=None, *, speed="5 rad/s", **tables):
    """A mass on a slide, with a spring of a stiffness and a free length to a point at a height."""
    keys = dict(zip(("stiffness", "free_length"), spring or (), strict=False))
    return custom_document(
        **TURNING,
        ground={"O": [0, 0], "A": [0.2, height]},
        body=[{"name": "m", "mass": "1 kg", "point": True, "turns": False, "at": [0.15, 0]}],
        joint=[between("slider", "ground.O", "m.origin", angle="0 deg")],
        readings={"x": {"x": "m.origin"}},
        spindle={"speed": speed},
        **({"force": [between("spring", "ground.A", "m.origin", **keys)]} if spring else {}),
        **tables,
    )


DUMB_BELL = SCENES["DUMB_BELL"]

scene = gm.Scene.from_dict


def stabilities(rests):
    return [rest.stable for rest in rests]


def test_rests_more_than_half_a_turn_from_the_sketch_are_found_on_the_way_there():
    linkage = scene(SCENES["FOUR_BAR"])
    rests = gm.equilibria(linkage)
    # By an integration of the joint's equation from the sketch in steps of 1e-3, worked out apart.
    assert [rest.coordinate for rest in rests] == pytest.approx([-5.6202, -5.2574, -0.59477], abs=1e-4)
    assert stabilities(rests) == [False, True, False]
    for rest in rests:
        assert rest.readings["q"] == rest.coordinate  # the line's own angle is the same but for a turn
        band = gm.insensitivity_band(linkage, [rest.coordinate], 0.0, "q")
        assert band.falling_speed[0] == band.rising_speed[0]
        assert band.rising_speed[0] == pytest.approx(linkage.spindle.speeds[0], rel=1e-9)
        again = gm.insensitivity_band(linkage, [rest.coordinate + 2 * math.pi], 0.0, "q")
        assert again.rising_speed == pytest.approx(band.rising_speed, rel=1e-9)
    curve = gm.speed_curve(linkage, 31)
    np.testing.assert_array_equal(curve.readings["q"], curve.coordinate)


@pytest.mark.parametrize("angle", [-90, 90, -60, 17])
def test_a_pendulum_rests_hanging_and_upright_wherever_it_is_sketched(angle):
    rests = gm.equilibria(scene(pendulum(angle)))
    kinds = {round(math.degrees(rest.coordinate)) % 360: rest.stable for rest in rests}
    assert len(rests) == 2
    assert kinds == {270: True, 90: False}


@pytest.mark.parametrize("ratio", [-0.5, 0.25, 1.5])
def test_a_heavy_rod_geared_to_the_coordinate_rests_once_upright_and_once_hanging_a_turn(ratio):
    mechanism = scene(geared(ratio))
    turns = next(n for n in (1, 2, 3, 4) if (n * ratio) % 1 == 0)
    curve = travels.find_range_of_motion(mechanism.part.mechanism, rotates_with_spindle=False)
    assert curve.high - curve.low == pytest.approx(2 * math.pi * turns, abs=1e-12)
    rests = gm.equilibria(mechanism)
    rod = [math.degrees(ratio * rest.coordinate) - 70 for rest in rests]
    assert sorted(round(angle) % 360 for angle in rod) == sorted([90, 270] * round(abs(turns * ratio)))
    np.testing.assert_allclose(np.array(rod) % 180, 90, atol=1e-9)


@pytest.mark.parametrize(("height", "free_length", "stiffness"), [(0.002, 0.003, 1e5), (0.02, 0.03, 1e3)])
def test_a_narrow_spring_on_a_long_slide_keeps_its_three_rests(height, free_length, stiffness):
    """k (1 - L0 / L) (x - a) = 0 where x = a and where L = L0."""
    aside = math.sqrt(free_length**2 - height**2)
    rests = gm.equilibria(scene(slide(height, (stiffness, free_length))), 0.0)
    assert [rest.coordinate for rest in rests] == pytest.approx([0.2 - aside, 0.2, 0.2 + aside], abs=1e-12)
    assert stabilities(rests) == [True, False, True]


@pytest.mark.parametrize(
    ("height", "free_length", "stiffness"), [(0.002, 0.003, 1e5), (0.005, 0.02, 1e3), (0.02, 0.025, 1e3), (0.02, 0.03, 1e3)]
)
def test_a_narrow_spring_on_a_long_slide_keeps_its_fold(height, free_length, stiffness):
    """w^2 = k (1 - L0 / L) (x - a) / (m x): its slope vanishes there; the same for few points as for many."""

    def slope(x):
        length = math.hypot(x - 0.2, height)
        pull, bend = (1 - free_length / length) * (x - 0.2), 1 - free_length * height**2 / length**3
        return bend * x - pull

    low = 0.2 - math.sqrt(free_length**2 - height**2)
    expected = brentq(slope, low, 0.2 - 1e-4 * height, xtol=1e-14)
    curve = gm.speed_curve(scene(slide(height, (stiffness, free_length))), 5)
    ((at, speed),) = curve.folds
    assert at == pytest.approx(expected, abs=1e-9)
    pull = stiffness * (1 - free_length / math.hypot(at - 0.2, height)) * (at - 0.2)
    assert speed == pytest.approx(math.sqrt(pull / at), rel=1e-9)


@settings(max_examples=15)
@given(height=st.floats(-4.0, -0.7), slack=st.floats(0.3, 6.0), share=st.floats(0.0, 0.5))
def test_stable_and_unstable_rests_take_turns_however_narrow_the_spring(height, slack, share):
    speed = share * math.sqrt(1000.0)
    rests = gm.equilibria(scene(slide(10**height, (1000, slack * 10**height), size="1 m")), speed)
    x = np.concatenate([np.linspace(1e-3, 49.0, 20001), 0.2 + 10**height * np.linspace(-30, 30, 20001)])
    x = np.sort(x[x > 1e-3])
    force = 1000 * (1 - slack * 10**height / np.hypot(x - 0.2, 10**height)) * (x - 0.2) - speed**2 * x
    signs = np.sign(force[force != 0.0])
    assert stabilities(rests) == (np.diff(signs)[np.diff(signs) != 0] > 0).tolist()


def test_a_torque_and_a_force_act_as_they_do_at_the_start():
    step = {"type": "torque", "body": "arm", "moment": [[0, "0 N m"], [0, "2 N m"]]}
    hanging = next(rest for rest in gm.equilibria(scene(pendulum(-90, step))) if rest.stable)
    assert hanging.coordinate == pytest.approx(-math.acos(2 / (9.81 * 0.5)), abs=1e-12)
    ramp = {"type": "force", "point": "arm.end", "x": [[-1, "0 N"], [1, "4 N"]]}
    hanging = next(rest for rest in gm.equilibria(scene(pendulum(-90, ramp))) if rest.stable)
    assert math.tan(hanging.coordinate + math.pi / 2) == pytest.approx(2 / (9.81 / 2), rel=1e-9)


def test_where_spring_and_turning_both_let_go_the_curve_is_smooth():
    """w^2 = 2 c (q - 90 deg) / (I sin 2(q - 90 deg)) has its least value c / I in the middle."""
    dumb_bell, inertia = scene(DUMB_BELL), 2 * 0.4**2 / 12
    least = math.sqrt(0.3 / inertia)
    curve = gm.speed_curve(dumb_bell)
    assert curve.poles == pytest.approx((-math.pi / 2, 0.0, math.pi), abs=1e-9)
    ((at, speed),) = curve.folds
    assert (at, speed) == pytest.approx((math.pi / 2, least), rel=1e-9)
    assert equilibrium_speed_at(dumb_bell, [math.pi / 2, math.pi / 2 + 1e-9]) == pytest.approx([least, least], rel=1e-7)
    middle = gm.equilibria(dumb_bell)[1]
    assert middle.coordinate == pytest.approx(math.pi / 2, abs=1e-12)
    assert middle.sensitivity == 0.0  # no speed moves it
    with pytest.raises(gm.MechanismError, match=r"is in equilibrium at q = 90 deg at every spindle speed"):
        gm.insensitivity_band(dumb_bell, [math.pi / 2], 0.0, "q")
    with pytest.raises(gm.MechanismError, match=r"at q = 0 deg: the centrifugal forces have no effect there, and the loads act"):
        gm.insensitivity_band(dumb_bell, [0.0], 0.0, "q")


@pytest.mark.parametrize("value", [1.7, 2.0, 3.5, -0.5, 0.0, 1e9])
def test_no_answer_is_made_up_outside_the_travel(value):
    for ask in (lambda: gm.insensitivity_band("porter", [0.5, value], 40.0), lambda: speed_of("porter", [value])):
        with pytest.raises(gm.MechanismError, match=r"lies outside the travel, 0 deg to 90 deg \(0 to 1\.5708\): "):
            ask()


def speed_of(name, values):
    return equilibrium_speed_at(gm.load(name), values)


@pytest.mark.parametrize("over", [[math.nan], [math.inf], [], ["a"], "abc", [[0.5, 0.6]], [[0.5], [0.6, 0.7]], None])
def test_values_that_are_none_are_refused(over):
    with pytest.raises(
        gm.MechanismError, match=r"arm_angle' must be a list of finite numbers in SI; got|arm_angle is an angle; .* has no number"
    ):
        gm.insensitivity_band("porter", over, 40.0)


@pytest.mark.parametrize("resistance", [True, None, [40.0], np.array([40.0]), 10**400, 1e308, "40 kg", -1.0])
def test_resistances_that_are_none_are_refused(resistance):
    with pytest.raises(gm.MechanismError, match="the resistance"):
        gm.insensitivity_band("porter", [0.5], resistance)


def test_what_is_meant_as_a_number_is_taken():
    plain = gm.insensitivity_band("porter", [0.5], 40.0)
    for over, resistance in ((0.5, "40 N"), (np.float32([0.5]), np.int64(40))):
        assert gm.insensitivity_band("porter", over, resistance).rising_speed == pytest.approx(plain.rising_speed)
    assert len(gm.speed_curve("porter", np.int64(9)).speed) == 9
    expected = gm.equilibria("porter", 13.0)[0].coordinate
    for speed in (np.int64(13), np.float32(13.0), "13 rad/s"):
        assert gm.equilibria("porter", speed)[0].coordinate == pytest.approx(expected)


@pytest.mark.parametrize("speed", [1e200, 10**200, -1e7, True, np.array(6.4), [6.4]])
def test_spindle_speeds_that_are_none_are_refused(speed):
    with pytest.raises(gm.MechanismError, match="the spindle's speed"):
        gm.equilibria("porter", speed)


@pytest.mark.parametrize("against", [None, 3, "sleve_lift"])
def test_what_is_no_reading_is_refused(against):
    with pytest.raises(gm.MechanismError, match=r"readings are \['arm_angle', 'ball_radius', 'sleeve_lift'\]"):
        gm.insensitivity_band("porter", [0.5], 40.0, against)


def test_no_speed_is_spoken_of_where_nothing_turns():
    torque = {"type": "torque", "body": "arm", "moment": "2 N m"}
    mechanism = scene(pendulum(-90, torque, gravity=False))
    with pytest.raises(gm.MechanismError, match=r"^the mechanism has no equilibrium in its travel, q from -270 deg to 90 deg$"):
        gm.equilibria(mechanism)
    with pytest.raises(gm.MechanismError, match="has no effect on the loads"):
        gm.equilibria(mechanism, 2.0)
    with pytest.raises(gm.MechanismError, match=r"'equilibrium': the mechanism has no equilibrium .*; give a number$"):
        scene(pendulum(-90, torque, gravity=False, start={"q": "equilibrium"}))


def test_one_question_follows_a_motion_once(monkeypatch):
    walks = []
    monkeypatch.setattr(travels, "PathContinuation", lambda *args, **words: walks.append(args) or walking.PathContinuation(*args, **words))
    sliding = scene(slide(0.05, size="1.05 m"))  # a travel that no other test has followed
    with pytest.raises(gm.MechanismError, match="no spindle speed balances it anywhere"):
        gm.equilibria(sliding, 2.0)
    assert len(walks) == 1
    walk = walking.PathContinuation(sliding.part.mechanism, rotates_with_spindle=True)
    assert len(walk.find_end(1.0).points) < 100  # nothing curves on fifty metres


def command(*words, document, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(scene(document).to_toml())
    return invoke("equilibria", str(path), "--out", str(tmp_path), *words)


def test_a_curve_that_is_held_nowhere_is_drawn(tmp_path):
    """Without warnings, which pytest makes errors."""
    answer = command(document=slide(0, size="1 m", speed=0), tmp_path=tmp_path)
    assert answer.exit_code == 0, answer.stderr
    assert "astatic, in equilibrium anywhere between" in answer.stdout
    assert (tmp_path / "scene_characteristic.png").exists()


def test_a_resistance_without_a_reading_to_act_at_names_the_option(tmp_path):
    answer = command("--resistance", "1 N m", document=DUMB_BELL, tmp_path=tmp_path)
    assert answer.exit_code == 2
    assert "choose one with --against: ['q']" in answer.stderr
    answer = command("--resistance", "1 N m", "--against", "q", document=DUMB_BELL, tmp_path=tmp_path)
    assert "1 N m at q: in equilibrium between 0 rpm and 99.18" in answer.stdout
    assert "is in equilibrium at q = 90 deg at every spindle speed" in answer.stdout
    assert "e-1" not in answer.stdout  # no speed moves the middle one: rounding shows no small number


def test_a_speed_where_nothing_turns_is_refused(tmp_path):
    answer = command("--speed", "20 rpm", document=pendulum(-90), tmp_path=tmp_path)
    assert answer.exit_code == 2
    assert "has no effect on the loads" in answer.stderr
    answer = command("--speed", "1e200 rad/s", document=DUMB_BELL, tmp_path=tmp_path)
    assert "must lie within 1e+06 rad/s" in answer.stderr


@pytest.mark.parametrize(
    ("name", "cure"),
    [
        ("jansen", "this one is moved by 'motor', so that no load decides its position: leave that out and give a load in its place"),
        ("friction_governor", "this one has mobility 3: add what holds its bodies until one coordinate is left"),
    ],
)
def test_a_mechanism_without_a_free_coordinate_of_its_own_is_refused_with_a_cure(name, cure):
    with pytest.raises(gm.MechanismError, match=re.escape(cure)):
        gm.equilibria(name)
