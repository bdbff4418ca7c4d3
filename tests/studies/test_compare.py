"""Comparing scenes: statics against closed forms and against the functions of one scene, readings against the runs, and the figure."""

import dataclasses
import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.render.figures.comparison import comparison_figure
from governor_mechanism.studies.compared_quantities import find_shared_readings, plain_names, settling_time
from reference import zehnder
from refusing import refuses

RESISTANCE = 40.0


def short(name, duration, **changes):
    """Return a shipped scene with another duration, under its own name."""
    scene = gm.load(name)
    return dataclasses.replace(scene.replace({"run.duration": f"{duration} s", **changes}), source=scene.source)


@pytest.fixture(scope="module")
def governors():
    scenes = short("porter", 1.4), short("porter_dashpot", 2.0), short("watt_improved", 0.5)
    return gm.compare(*scenes, resistance=RESISTANCE, accuracy=1e-6)


@pytest.fixture(scope="module")
def mixed():
    return gm.compare(short("porter", 0.2), short("slider_crank", 0.1))


def test_statics_are_those_of_the_closed_form(governors):
    value = governors.value
    dimensions = gm.load("porter").part.dimensions
    arm, offset, ball, sleeve = (dimensions[name] for name in ("arm", "offset", "ball_mass", "sleeve_mass"))
    angle = gm.equilibria("porter")[0].coordinate
    # Zehnder (3) holds at the equilibrium that statics find to rounding.
    speed = math.sqrt(9.81 * (1 + sleeve / ball) * math.tan(angle) / (offset + arm * math.sin(angle)))
    assert speed == pytest.approx(value("speed of the spindle", "porter"), rel=1e-12)
    weight = 9.81 * (ball + sleeve)
    assert value("effort there, for 1 % of speed", "porter") == pytest.approx(weight * (1.01**2 - 1) / 2, rel=1e-12)
    share = RESISTANCE / weight
    # Read between the points of the curve, along which it is constant.
    assert value("insensitivity there", "porter") == pytest.approx(math.sqrt(1 + share) - math.sqrt(1 - share), rel=1e-12)
    ratio = sleeve / ball
    sine = math.sin(angle)
    squared = speed**2 * (offset + arm * sine**3) / (arm * sine * (1 + 2 * ratio * sine**2))
    # Eigenvalues are found from derivatives of the accelerations, to about 1e-9.
    assert value("natural frequency there", "porter") == pytest.approx(math.sqrt(squared), rel=1e-7)
    assert value("damping ratio there", "porter") == 0.0
    assert value("damping ratio there", "porter_dashpot") > 0.1
    assert value("jumps at", "watt_improved") == pytest.approx(zehnder.FOLD_JUMP["lowest_speed"], rel=1e-10)


def test_without_stops_the_working_range_is_what_the_run_covers_unless_it_is_given(governors):
    lift = governors.runs[0].readings["sleeve_lift"]
    assert governors.value("working range of", "porter") == "the run"
    assert governors.value("working range of", "watt_improved") == "the stops"
    # The range of a reading is located to rounding.
    assert governors.value("working range from", "porter") == pytest.approx(lift.min(), rel=1e-9)
    assert governors.value("working range to", "porter") == pytest.approx(lift.max(), rel=1e-9)
    given = gm.compare(short("porter", 0.1), short("porter_dashpot", 0.1), between={"sleeve_lift": ("80 mm", "120 mm")})
    alone = gm.controlling_force("porter", between={"sleeve_lift": ("80 mm", "120 mm")}).working_range
    for name in given.names:
        assert given.value("working range of", name) == "given values"
        assert given.value("sensitiveness", name) == pytest.approx(alone.sensitiveness, rel=1e-12)
        # Weights do the work: that of balls and sleeve raised by half the lift and by the lift.
        assert given.value("work capacity", name) == pytest.approx(9.81 * 25.0 * 0.04, rel=1e-10)


def test_an_equilibrium_beyond_a_stop_is_called_so():
    # At 213 rpm this governor, made for 212 rpm, rests on its outer stop.
    scene = short("hartung_corrected", 0.05, **{"spindle.speed": "213 rpm", "start.lever_angle": "0 deg"})
    found = gm.compare(scene, short("porter", 0.05))
    assert found.value("equilibrium", "hartung_corrected") == "beyond a stop"
    assert found.value("equilibrium", "porter") == "stable"
    assert found.value("working range of", "hartung_corrected") == "the stops"


def test_readings_are_those_of_the_runs(governors):
    for name, run in zip(governors.names, governors.runs, strict=True):
        assert governors.value("sleeve lift, last", name) == run.readings["sleeve_lift"][-1]
        assert governors.value("sleeve lift, lowest", name) == run.readings["sleeve_lift"].min()
        assert governors.value("sleeve lift, highest", name) == run.readings["sleeve_lift"].max()
        assert governors.value("run: end", name) == run.times[-1]
    assert [run.times[-1] for run in governors.runs] == [1.4, 2.0, 0.5]


def test_names_tell_equal_scenes_apart_and_the_order_does_not_matter(governors):
    assert governors.title == "porter vs porter_dashpot vs watt_improved"
    scene = short("porter", 0.1)
    assert len(set(gm.compare(scene, scene.replace({"dimensions.arm": "320 mm"}), scene).names)) == 3
    reverse = gm.compare(scene, short("watt", 0.1)), gm.compare(short("watt", 0.1), scene)
    for row, other in zip(*(sorted(one.rows, key=lambda row: row.quantity) for one in reverse), strict=True):
        assert (row.quantity, row.values) == (other.quantity, other.values[::-1])


def test_scenes_without_statics_or_shared_readings_say_why(mixed):
    assert mixed.governors[0][0] == 0
    assert len(mixed.governors) == 1
    assert not mixed.shared_readings
    assert mixed.value("sensitiveness", "slider_crank") is None
    text = str(mixed)
    assert "slider_crank: no statics: an equilibrium speed needs" in text
    assert "no reading in common" in text
    refuses("no quantity 'speed'; it has speed of the spindle", mixed.value, "speed", "porter")
    refuses("no scene 'watt'", mixed.value, "run: end", "watt")


def test_readings_of_a_part_are_shared_by_their_plain_names(governors):
    run = governors.runs[0]
    renamed = dataclasses.replace(
        run,
        readings={f"governor.{name}": values for name, values in run.readings.items()} | {"a.x": run.times, "b.x": run.times},
        units={f"governor.{name}": unit for name, unit in run.units.items()} | {"a.x": "m", "b.x": "m"},
    )
    assert plain_names(renamed)["sleeve_lift"] == "governor.sleeve_lift"
    assert "x" not in plain_names(renamed)
    assert find_shared_readings([run, renamed])["arm_angle"] == ("arm_angle", "governor.arm_angle")


def test_three_scenes_of_which_two_share_a_reading(governors, mixed):
    runs = (mixed.runs[1], governors.runs[0], governors.runs[1])
    shared = find_shared_readings(runs)
    assert shared["sleeve_lift"] == (None, "sleeve_lift", "sleeve_lift")
    assert "crank_angle" not in shared


def test_settling_counts_from_the_last_change_of_the_speed(governors):
    run = governors.runs[0]
    times = np.linspace(0.0, 5.0, 2001)
    program = "spindle.speed", [[0, "120 rpm"], [1, "120 rpm"], [2, "121 rpm"], [5, "121 rpm"]]
    changed = dataclasses.replace(
        run, scene=gm.load("porter").replace(dict([program])), times=times, readings={"sleeve_lift": np.exp(-4 * times)}
    )
    # exp(-4 t) after 2 s falls to 0.02 of what it is then in the same time, to the step of 2.5 ms.
    assert settling_time(changed, "sleeve_lift") == pytest.approx(math.log(50) / 4, abs=2.6e-3)


@pytest.mark.parametrize(("rate", "settles"), [(4.0, True), (0.1, False), (0.0, False)])
def test_the_settling_time_of_a_decaying_reading(governors, rate, settles):
    run = governors.runs[0]
    times = np.linspace(0.0, 5.0, 2001)
    decaying = dataclasses.replace(run, times=times, readings={"sleeve_lift": np.exp(-rate * times)})
    found = settling_time(decaying, "sleeve_lift")
    if settles:
        # exp(-r t) = 0.02, to the step of 2.5 ms.
        assert found == pytest.approx(math.log(50) / rate, abs=2.6e-3)
    else:
        assert found is None


def test_too_few_and_too_many_scenes_are_refused():
    scene = short("porter", 0.1)
    for scenes in ([], [scene], [scene] * 7):
        refuses(f"2 to 6 scenes; got {len(scenes)}", gm.compare, *scenes)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"resistance": "40 mm"}, "resistance"),
        ({"resistance": "40 N", "against": "collar"}, "no governor here has it"),
        ({"between": {"sleeve": (0.08, 0.12)}}, "holds for none of the scenes"),
        ({"between": 5}, "between must be values by name"),
        ({"accuracy": "fine"}, "accuracy must be a finite number"),
    ],
)
def test_questions_that_no_scene_can_answer_are_refused(options, sentence):
    refuses(sentence, gm.compare, short("porter", 0.05), short("slider_crank", 0.05), **options)


def test_the_figure_overlays_curves_in_styles_of_their_own(governors, mixed, tmp_path):
    page = comparison_figure(governors)
    assert len(page.axes) == 4
    speed, force, *plots = page.axes
    styles = {repr(line._unscaled_dash_pattern) for line in speed.get_legend_handles_labels()[0]}
    assert len(styles) == 3
    assert len({line.get_color() for line in plots[0].lines if len(line.get_xdata()) > 2}) == 3
    assert force.get_xlim()[0] < 1.0 < force.get_xlim()[1]
    # A shorter run ends with a dot at its last value.
    dots = [line for line in plots[0].lines if line.get_marker() == "o"]
    assert sorted(float(dot.get_xdata()[0]) for dot in dots) == [0.5, 1.4]
    assert [axes.get_ylabel() for axes in comparison_figure(mixed).axes[2:]] == ["Arm angle [deg]", "Crank angle [deg]"]
    assert page.save(tmp_path / "a.png").stat().st_size > 0


def test_its_film_is_that_of_its_runs_side_by_side_without_one_that_has_a_single_moment(mixed, tmp_path):
    options = {"size": 320, "stop": "50 ms", "slow_down": 2.0, "footer": False}
    film = mixed.film(tmp_path / "film.gif", **options)
    assert "<img" in film._repr_html_()
    assert film.path.read_bytes() == gm.film(mixed.runs, tmp_path / "runs.gif", **options).read_bytes()
    at_once = dataclasses.replace(mixed.runs[0], times=mixed.runs[0].times[:1])
    film = dataclasses.replace(mixed, runs=(at_once, mixed.runs[1])).film(tmp_path / "film.gif", **options)
    assert film.path.read_bytes() == gm.film(mixed.runs[1], tmp_path / "run.gif", **options).read_bytes()
    refuses("a film's name must end in", mixed.film, tmp_path / "film.avi")
