"""Kinematic readings, mobility, four-bars, dead centres, toggles and time ratios against closed forms, and refusals."""

import csv
import json
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import governor_mechanism as gm
from command_line import succeed
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import MechanismError
from refusing import refuses

ENGINES = pytest.mark.parametrize(
    ("engine", "accuracy"), [(MultibodyEngine(), 1e-9), (ImpulseEngine(), 1e-5)], ids=["multibody", "impulse"]
)
LENGTHS = (0.4, 0.12, 0.35, 0.3)
"""Ground, crank, coupler and rocker of a crank-rocker, m."""
SPEED = 3.0
"""Rate of the drive, rad/s."""


def four_bar(lengths=LENGTHS, *, is_driven=True, **changes) -> gm.Scene:
    """A four-bar whose crank turns at SPEED, or is free; it starts at 60 degrees, above the ground."""
    ground, crank, coupler, rocker = lengths
    tip = crank * np.exp(1j * math.pi / 3)
    joint = circle_intersection(tip, coupler, ground, rocker)
    bodies = [
        ("crank", crank, 0.0, 60.0),
        ("coupler", coupler, tip, math.degrees(np.angle(joint - tip))),
        ("rocker", rocker, ground, math.degrees(np.angle(joint - ground))),
    ]
    tables = [
        {"name": name, "mass": 1.0, "rod": {"length": length}, "at": [float(np.real(at)), float(np.imag(at))], "angle": f"{angle} deg"}
        for name, length, at, angle in bodies
    ]
    pins = [("ground.O", "crank.start"), ("crank.end", "coupler.start"), ("coupler.end", "rocker.end"), ("ground.C", "rocker.start")]
    joints = [{"type": "pin", "name": f"pin {k + 1}", "first": first, "second": second} for k, (first, second) in enumerate(pins)]
    motor = {"type": "driven_turn", "name": "motor", "first": "ground", "second": "crank", "rate": SPEED}
    joints += [motor] if is_driven else []
    document = {
        "title": "Four-bar",
        "machine": "custom",
        "ground": {"O": [0, 0], "C": [ground, 0]},
        "body": tables,
        "joint": joints,
        "readings": {f"{name}_angle": {"angle": name} for name in ("crank", "coupler", "rocker")},
        "run": {"duration": 1.0, "output_interval": 0.05},
    }
    document["body"][1]["points"] = {"pen": [0.1, 0.08]}
    return gm.Scene.from_dict({**document, **changes})


def circle_intersection(first, first_radius, second, second_radius):
    """The intersection of two circles to the left of the line from the first to the second centre, as complex numbers."""
    line = second - first
    distance = abs(line)
    along = (distance**2 + first_radius**2 - second_radius**2) / (2 * distance)
    return first + line / distance * (along + 1j * np.sqrt(first_radius**2 - along**2))


def exact_four_bar(angles, lengths=LENGTHS):
    """Angles and angular speeds of coupler and rocker by Freudenstein's equations; pins A and B as complex numbers."""
    ground, crank, coupler, rocker = lengths
    first = crank * np.exp(1j * angles)
    second = circle_intersection(first, coupler, ground, rocker)
    coupler_angle, rocker_angle = np.angle(second - first), np.angle(second - ground)
    coupler_speed = SPEED * crank * np.sin(rocker_angle - angles) / (coupler * np.sin(coupler_angle - rocker_angle))
    rocker_speed = SPEED * crank * np.sin(angles - coupler_angle) / (rocker * np.sin(rocker_angle - coupler_angle))
    return first, second, coupler_angle, rocker_angle, coupler_speed, rocker_speed


def exact_pen(angles):
    """Position, velocity and acceleration of the pen of the coupler, as complex numbers; the last by central differences."""

    def motion(at):
        first, _, coupler_angle, _, coupler_speed, _ = exact_four_bar(at)
        arm = (0.1 + 0.08j) * np.exp(1j * coupler_angle)
        return first + arm, 1j * SPEED * first + 1j * coupler_speed * arm

    step = 1e-5
    ahead, behind = motion(angles + step)[1], motion(angles - step)[1]
    return *motion(angles), SPEED * (ahead - behind) / (2 * step)


def as_complex(study, kind):
    return study.readings[f"{kind}.x"] + 1j * study.readings[f"{kind}.y"]


ANGLES = np.radians(np.arange(5.0, 365.0, 7.0))


# --- points and couplers ----------------------------------------------------------------------------------------------


def test_a_crosshead_moves_as_the_closed_form():
    crank, rod = 0.1, 0.3
    study = gm.kinematics("slider_crank_torque", "crank_angle", ANGLES, rate=SPEED, readings=["velocity.B", "acceleration.B"])
    sine, cosine = np.sin(ANGLES), np.cos(ANGLES)
    root = np.sqrt(rod**2 - crank**2 * sine**2)
    velocity = SPEED * (-crank * sine - crank**2 * sine * cosine / root)
    second = -crank * cosine - crank**2 * (cosine**2 - sine**2) / root - crank**4 * (sine * cosine) ** 2 / root**3
    assert_allclose(as_complex(study, "velocity.B"), velocity, atol=1e-13)
    assert_allclose(as_complex(study, "acceleration.B"), SPEED**2 * second, atol=1e-11)
    assert_allclose(study.readings["velocity.B.magnitude"], np.abs(velocity), atol=1e-13)
    angle, lowest = ANGLES[np.argmin(np.abs(velocity))], np.abs(velocity).min()
    extremes = {one["reading"]: one for one in study.as_json()["extremes"]}["velocity.B.magnitude"]
    assert (extremes["lowest_at"], extremes["highest"]) == pytest.approx((angle, np.abs(velocity).max()), abs=1e-12)
    assert extremes["lowest"] == pytest.approx(lowest, abs=1e-12)
    # The crosshead is an output link whose line is normal to its guide.
    assert_allclose(
        gm.kinematics("slider_crank_torque", "crank_angle", ANGLES, readings=["transmission_angle.rod"])["transmission_angle.rod"],
        np.arccos(crank * sine / rod),
        atol=1e-12,
    )


def test_a_coupler_point_moves_by_freudensteins_angular_speeds():
    study = gm.kinematics(four_bar(), "crank_angle", ANGLES, rate=SPEED, readings=["velocity.pen", "acceleration.pen", "curvature.pen"])
    _, velocity, acceleration = exact_pen(ANGLES)
    assert_allclose(as_complex(study, "velocity.pen"), velocity, atol=1e-12)
    assert_allclose(as_complex(study, "acceleration.pen"), acceleration, atol=1e-8)  # the error of the differences
    curvature = (velocity.conj() * acceleration).imag / np.abs(velocity) ** 3
    assert_allclose(study.readings["curvature.pen"], curvature, rtol=1e-7)


def test_the_transmission_angle_follows_from_the_law_of_cosines():
    ground, crank, coupler, rocker = LENGTHS
    study = gm.kinematics(four_bar(), "crank_angle", ANGLES, readings=["transmission_angle.coupler"])
    diagonal = ground**2 + crank**2 - 2 * ground * crank * np.cos(ANGLES)
    assert_allclose(
        study.readings["transmission_angle.coupler"], np.arccos((coupler**2 + rocker**2 - diagonal) / (2 * coupler * rocker)), atol=1e-12
    )


def test_driven_at_the_rocker_the_crank_is_the_output():
    ground, crank, coupler, rocker = LENGTHS
    start = float(exact_four_bar(math.pi / 3)[3])
    study = gm.kinematics(four_bar(), "rocker_angle", start + np.radians([-2.0, 0.0, 2.0]), readings=["transmission_angle.coupler"])
    diagonal = ground**2 + rocker**2 + 2 * ground * rocker * np.cos(study.values)
    expected = np.arccos((coupler**2 + crank**2 - diagonal) / (2 * coupler * crank))
    assert_allclose(study.readings["transmission_angle.coupler"], expected, atol=1e-12)


def test_the_curvature_of_a_cardioid_beside_its_cusp():
    """3 / (8 a sin(t / 2)) of a wheel of radius a; only in the cusp itself, where the pen stands still, it has no value."""
    angles = np.array([0.0, 1e-4, 1e-3, 0.1, 1.0, math.pi])
    study = gm.kinematics("cardioid", "arm_angle", angles, readings=["curvature.pen"])
    assert np.isnan(study.readings["curvature.pen"][0])
    assert_allclose(study.readings["curvature.pen"][1:], 3 / (8 * 0.25 * np.sin(angles[1:] / 2)), rtol=1e-6)


def test_the_curvature_of_a_trammels_ellipse():
    drawing = gm.load("trammel").replace({"body.bar.points.pen": ["1.6 m", 0]})
    study = gm.kinematics(drawing, "bar_angle", np.radians(np.arange(-50.0, 300.0, 10.0)), readings=["curvature.pen"])
    x, y = study.paths["pen"].T
    along, across = 1.6, 0.6
    expected = (x**2 / along**4 + y**2 / across**4) ** -1.5 / (along * across) ** 2
    assert_allclose(study.readings["curvature.pen"], expected, rtol=1e-11)  # the pen runs round the ellipse anticlockwise


def test_the_mechanical_advantage_of_a_four_bar_is_the_ratio_of_the_arms():
    _, crank, _, rocker = LENGTHS
    study = gm.kinematics(four_bar(), "crank_angle", ANGLES, readings=["mechanical_advantage.crank_angle.rocker_angle"])
    _, _, coupler_angle, rocker_angle, *_ = exact_four_bar(ANGLES)
    crank_arm = crank * np.sin(ANGLES - coupler_angle)
    rocker_arm = rocker * np.sin(rocker_angle - coupler_angle)
    advantage = study.readings["mechanical_advantage.crank_angle.rocker_angle"]
    assert_allclose(1 / advantage, crank_arm / rocker_arm, atol=1e-12)
    assert_allclose(advantage * study.rates["rocker_angle"], study.rates["crank_angle"], rtol=1e-12)
    assert study.units["mechanical_advantage.crank_angle.rocker_angle"] == "1"


# --- instantaneous centres --------------------------------------------------------------------------------------------


def test_the_pole_of_a_coupler_is_where_crank_and_rocker_meet():
    study = gm.kinematics(four_bar(), "crank_angle", ANGLES, readings=["instantaneous_centre.coupler.ground"])
    first, second, *_ = exact_four_bar(ANGLES)
    rocker = second - LENGTHS[0]
    # O + s A = C + t (B - C), crossed with B - C.
    factor = LENGTHS[0] * rocker.imag / (first.conj() * rocker).imag
    assert_allclose(as_complex(study, "instantaneous_centre.coupler.ground"), factor * first, rtol=1e-9)


@pytest.mark.parametrize("bodies", [("ground", "crank", "rocker"), ("crank", "coupler", "rocker"), ("ground", "coupler", "crank")])
def test_three_centres_of_three_bodies_lie_on_a_line(bodies):
    pairs = [f"{bodies[k]}.{bodies[k - 1]}" for k in range(3)]
    study = gm.kinematics(four_bar(), "crank_angle", ANGLES, readings=[f"instantaneous_centre.{pair}" for pair in pairs])
    one, two, three = (as_complex(study, f"instantaneous_centre.{pair}") for pair in pairs)
    area = ((two - one).conj() * (three - one)).imag
    assert np.max(np.abs(two - one)) > 0.1
    # Centres may be far away: the area is relative to their distances, and to the size of the linkage.
    assert_allclose(area / (0.1 + np.abs(two - one)) / (0.1 + np.abs(three - one)), 0.0, atol=1e-12)


def test_a_centre_at_infinity_is_an_empty_value_with_a_reason(tmp_path):
    study = gm.kinematics("parallelogram", "crank_angle", np.radians([20.0, 40.0]), readings=["instantaneous_centre.coupler.ground"])
    assert len(study.notes) == 2
    assert study.notes[0].endswith(
        "is not defined at 2 of 2 values, where the centre is at infinity: the bodies do not turn against each other"
    )
    assert np.isnan(study.readings["instantaneous_centre.coupler.ground.x"]).all()
    rows = list(csv.DictReader(line for line in study.save_csv(tmp_path / "k.csv").read_text().splitlines() if line[0] != "#"))
    assert {row["instantaneous_centre.coupler.ground.x"] for row in rows} == {""}
    record = json.loads(study.save_json(tmp_path / "k.json").read_text())
    assert record["readings"]["instantaneous_centre.coupler.ground.y"] == [None, None]
    assert "nan" not in str(study)


# --- the whole linkage ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lengths", "expected"),
    [
        ((0.4, 0.12, 0.35, 0.3), "crank-rocker"),
        ((0.1, 0.25, 0.3, 0.28), "double crank"),
        ((0.4, 0.3, 0.15, 0.35), "double rocker"),
        ((0.5, 0.3, 0.25, 0.35), "triple rocker"),
        ((0.4, 0.2, 0.35, 0.25), "change point"),
    ],
)
def test_grashofs_classes(lengths, expected):
    (found,) = gm.kinematics(four_bar(lengths), values=["60 deg"]).four_bars
    assert found.grashof == expected
    assert_allclose(found.lengths, lengths, rtol=1e-14)
    assert found.links == ("crank", "coupler", "rocker")


def test_jansens_leg_has_two_four_bars_with_bars_as_links():
    found = gm.kinematics("jansen", values=["10 deg"]).four_bars
    assert [(one.links, str(one.grashof)) for one in found] == [
        (("crank", "j", "thigh"), "crank-rocker"),
        (("crank", "k", "c"), "crank-rocker"),
    ]
    assert_allclose(found[0].lengths, [math.hypot(0.038, 0.0078), 0.015, 0.05, 0.0415], rtol=1e-14)


def test_mobility_by_count_and_by_rank():
    one = gm.kinematics("peaucellier", values=["10 deg"]).mobility
    assert (one.gruebler, one.true, one.redundant) == (1, 1, 0)
    bar = {"name": "third", "first": "ground.M", "second": "coupler.M"}
    plain = gm.load("parallelogram")
    base, side = plain.part.dimensions["base"], plain.part.dimensions["crank"]
    redundant = plain.replace(
        {"ground.M": [base / 2, 0.0], "body.coupler.points": {"M": [base / 2, 0.0]}, "link": [{**bar, "length": side}]}
    )
    three = gm.kinematics(redundant, values=["60 deg"]).mobility
    assert (three.gruebler, three.true, three.redundant) == (0, 1, 1)
    assert str(three) == ("mobility 1; Grübler's count is 3 x 3 bodies - 2 x 4 pins - 1 x 1 link = 0, but 1 constraint is redundant")


def test_dead_centres_lie_where_crank_and_coupler_are_in_line():
    ground, crank, coupler, rocker = LENGTHS

    def angle_at_crank(side):
        return math.acos((side**2 + ground**2 - rocker**2) / (2 * side * ground))

    study = gm.kinematics(four_bar(), values=["60 deg"])
    found = [one for one in study.dead_centres if one.reading == "rocker_angle"]
    outer, inner = angle_at_crank(coupler + crank), math.pi + angle_at_crank(coupler - crank)
    assert [(one.is_highest) for one in found] == [False, True]
    assert_allclose([one.drive for one in found], [outer, inner], atol=1e-10)
    way = inner - outer
    assert_allclose(study.time_ratios["rocker_angle"], max(way, math.tau - way) / min(way, math.tau - way), rtol=1e-10)
    assert study.toggles == ()


def test_toggles_lie_where_coupler_and_rocker_are_in_line():
    lengths = ground, crank, coupler, rocker = (0.5, 0.3, 0.25, 0.35)
    study = gm.kinematics(four_bar(lengths), values=["60 deg"])
    limit = math.acos((ground**2 + crank**2 - (coupler + rocker) ** 2) / (2 * ground * crank))
    assert_allclose([one.drive for one in study.toggles], [-limit, limit], atol=1e-10)
    assert {one.couplers for one in study.toggles} == {("coupler",)}


def test_a_press_is_at_its_toggle_where_both_bars_are_in_line():
    study = gm.kinematics("toggle_press", readings=["mechanical_advantage.bar_angle.ram_y"])
    (lowest,) = (one for one in study.dead_centres if one.reading == "ram_y")
    assert_allclose(lowest.drive, -math.pi / 2, atol=1e-10)
    assert_allclose([one.drive for one in study.toggles], [-math.pi, 0.0], atol=1e-10)  # folded bars
    assert "mechanical_advantage.bar_angle.ram_y is not defined at 1 of 361 values, where it is infinite" in study.notes[0]


@pytest.mark.parametrize(
    ("scene", "reading", "sine"), [("whitworth", "end_x", "offset / crank"), ("crank_shaper", "end_x", "crank / distance")]
)
def test_time_ratios_of_quick_returns(scene, reading, sine):
    loaded = gm.load(scene)
    first, _, second = sine.partition(" / ")
    angle = math.asin(loaded.part.dimensions[first] / loaded.part.dimensions[second])
    ratio = gm.kinematics(loaded).time_ratios[reading]
    assert_allclose(ratio, (math.pi + 2 * angle) / (math.pi - 2 * angle), rtol=1e-10)


# --- runs -------------------------------------------------------------------------------------------------------------


@ENGINES
def test_readings_of_a_run_lie_within_their_error_estimates(engine, accuracy):
    names = ["velocity.pen", "acceleration.pen.magnitude", "transmission_angle.coupler"]
    run = engine.run(four_bar(run={"duration": 1.0, "output_interval": 0.05, "readings": names}), accuracy=accuracy)
    angles = math.pi / 3 + SPEED * run.times
    _, velocity, acceleration = exact_pen(angles)
    ground, crank, coupler, rocker = LENGTHS
    diagonal = ground**2 + crank**2 - 2 * ground * crank * np.cos(angles)
    exact = {
        "velocity.pen.x": (velocity.real, "m/s", 0.0),
        "velocity.pen.y": (velocity.imag, "m/s", 0.0),
        "velocity.pen.magnitude": (np.abs(velocity), "m/s", 0.0),
        "acceleration.pen.magnitude": (np.abs(acceleration), "m/s2", 1e-8),  # the error of the differences
        "transmission_angle.coupler": (np.arccos((coupler**2 + rocker**2 - diagonal) / (2 * coupler * rocker)), "rad", 0.0),
    }
    assert [name for name in run.readings if "." in name] == list(exact)
    for name, (values, unit, slack) in exact.items():
        assert run.units[name] == unit
        assert np.max(np.abs(run.readings[name] - values)) <= run.reading_errors[name] + slack + 1e-12 * run.scales[name]
        assert run.reading_errors[name] <= run.error_estimate * run.scales[name] * (1 + 1e-12)


def test_readings_of_a_free_four_bar_follow_its_crank():
    names = ["velocity.pen", "transmission_angle.coupler"]
    start, settings = {"crank_angle": "60 deg", "crank_rate": SPEED}, {"duration": 1.0, "output_interval": 0.05, "readings": names}
    free = four_bar(is_driven=False, start=start, run=settings)
    run = ReducedEngine().run(free, accuracy=1e-9)
    _, velocity, _ = exact_pen(run.readings["crank_angle"])
    velocity = velocity * run.rates["crank_angle"] / SPEED
    assert np.ptp(run.rates["crank_angle"]) > 0.5
    assert_allclose(run.readings["velocity.pen.x"], velocity.real, atol=1e-11)
    assert_allclose(run.readings["velocity.pen.y"], velocity.imag, atol=1e-11)
    assert run.reading_errors["transmission_angle.coupler"] < 1e-9


def test_a_saved_run_with_kinematic_readings_opens_again(tmp_path):
    scene = four_bar(run={"duration": 0.2, "output_interval": 0.1, "readings": ["velocity.pen.x", "transmission_angle.coupler"]})
    run = gm.run(scene)
    run.save(tmp_path, figures=False)
    opened = gm.open_run(tmp_path)
    assert opened.scene.run == run.scene.run
    assert [one.name for one in opened.scene.mechanism.derived_readings] == ["velocity.pen.x", "transmission_angle.coupler"]
    np.testing.assert_array_equal(opened.readings["velocity.pen.x"], run.readings["velocity.pen.x"])


# --- command and figure -----------------------------------------------------------------------------------------------


def test_the_command_prints_facts_and_writes_table_record_and_figure(tmp_path):
    result = succeed("kinematics", "slider_crank_torque", "--rate", "60 rpm", "--out", tmp_path)
    for words in (
        "361 positions over crank_angle, 0 deg to 360 deg; driven at 6.28319 rad/s",
        "mobility 1: by Grübler's count 3 x 3 bodies - 1 for bodies that do not turn - 2 x 3 pins - 1 x 1 slider = 1",
        "time ratio of slider_x: 1",
        "mechanical_advantage.crank_angle.slider_x is not defined at 3 of 361 values",
    ):
        assert words in result.stdout
    stem = "slider_crank_torque_kinematics"
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{stem}.{kind}" for kind in ("csv", "json", "png")]
    record = json.loads((tmp_path / f"{stem}.json").read_text())
    assert record["mobility"]["gruebler"] == 1
    assert [one["reading"] for one in record["dead_centres"]] == ["slider_x", "slider_x"]
    assert len(record["readings"]["transmission_angle.rod"]) == 361


def test_the_figure_draws_paths_to_one_scale_and_a_panel_for_each_kind():
    names = ["velocity.pen", "transmission_angle.coupler", "instantaneous_centre.coupler.ground"]
    paths, *panels = gm.kinematics(four_bar(), "crank_angle", ANGLES, readings=names).plot().axes
    width, height = np.ptp(paths.get_xlim()), np.ptp(paths.get_ylim())
    assert_allclose(width / height, paths.bbox.width / paths.bbox.height, rtol=1e-9)
    curve = next(line.get_xydata() for line in paths.lines if line.get_label() == "pen")
    assert_allclose(curve @ [1, 1j], 1e3 * exact_pen(ANGLES)[0], atol=1e-8)
    assert [panel.texts[0].get_text() for panel in panels] == ["Transmission angle [deg]", "Velocity [m/s]"]


# --- refusals ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("velocity.pan", r"names 'velocity\.pan': no point 'pan'; points are .*Did you mean 'pen'"),
        ("velocity", "it names no point, as velocity.NAME does; points are"),
        ("transmission_angle.rocker", r"no coupler 'rocker'; couplers are \['coupler'\]"),
        ("instantaneous_centre.crank", r"needs two different names of bodies, as instantaneous_centre\.FIRST\.SECOND"),
        ("speed.pen", "there is no such kind of reading; there are velocity.NAME"),
        ("reaction.pin 1", "forces need a run"),
    ],
)
def test_a_reading_that_the_mechanism_does_not_have_is_refused(name, message):
    refuses(message, gm.kinematics, four_bar(), values=["60 deg"], readings=[name])


def test_a_run_refuses_what_has_no_value_at_some_times_and_all_mistakes_at_once():
    names = ["curvature.pen", "acceleration.pan"]
    with pytest.raises(MechanismError) as refusal:
        four_bar(run={"duration": 1.0, "output_interval": 0.1, "readings": names})
    first, second = refusal.value.problems
    assert "a run has no curvature, which is not defined at every time; gm.kinematics and the command kinematics have it" in str(first)
    assert "no point 'pan'" in str(second)


def test_a_velocity_among_the_readings_of_the_mechanism_is_sent_to_the_run():
    with pytest.raises(MechanismError, match=r'a velocity is named under \[run\], as readings = \["velocity\.NAME"\]'):
        four_bar().replace({"readings.pen_speed": {"velocity": "coupler.pen"}})


def test_an_advantage_of_what_stands_still_is_refused():
    scene = four_bar().replace({"readings.post_x": {"x": "ground.C"}})
    with pytest.raises(MechanismError, match=r"mechanical_advantage\.crank_angle\.post_x is not defined: 'post_x' stands still"):
        gm.kinematics(scene, values=["60 deg"], readings=["mechanical_advantage.crank_angle.post_x"])


def test_a_mechanism_with_two_degrees_of_freedom_is_refused():
    loose = four_bar().replace({"joint.pin 4": None})
    refuses("one reading must determine the motion; this mechanism has 3", gm.kinematics, loose, values=["60 deg"])
