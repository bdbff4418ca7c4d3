"""Optimisation: closed-form optima, conditions of optimality, conditions that a new run meets, what lies outside, mistakes."""

import json

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum
from governor_mechanism.studies.optimisation.question import Question
from governor_mechanism.studies.sweep import workers
from governor_mechanism.studies.unknowns import parse_unknowns
from interruptions import interrupt_at_call

SPEED = 130.0 * np.pi / 30.0
"""Highest speed that is wanted, rad/s."""

MASSES = {"dimensions.ball_mass": ("2 kg", "8 kg"), "dimensions.sleeve_mass": ("10 kg", "24 kg")}
OUTER = np.radians(45.0)


@pytest.fixture(scope="module")
def governor():
    """The Porter governor with stops and friction at its sleeve."""
    return gm.load("porter").replace(
        {"effects.stops": {"arm_angle": ["20 deg", "45 deg"]}, "effects.dry_friction": {"sleeve_lift": "20 N"}}
    )


def closed_form(ball_mass, sleeve_mass, offset=0.04):
    return pendulum.PendulumGovernor(arm=0.3, offset=offset, ball_mass=ball_mass, sleeve_mass=sleeve_mass)


@pytest.fixture(scope="module")
def found(governor):
    return gm.optimise(governor, MASSES, minimise="insensitivity", subject_to=["highest equilibrium speed = 130 rpm"])


def test_the_masses_of_a_wanted_speed_are_those_of_the_closed_form(found):
    """Friction is felt least under the heaviest sleeve, and w^2 = g (1 + m) tan a / x then gives the balls."""
    ratio = SPEED**2 * (0.04 + 0.3 * np.sin(OUTER)) / (9.81 * np.tan(OUTER)) - 1.0
    assert found.converged
    assert found.values["dimensions.sleeve_mass"] == pytest.approx(24.0, rel=1e-9)
    assert found.values["dimensions.ball_mass"] == pytest.approx(24.0 / ratio, rel=1e-8)
    assert [row.at_bound for row in found.rows] == [False, True]
    assert found.quantities[1].active
    # The insensitivity of a rhombus is W / (M + m) g, to the square of itself.
    weights = (found.values["dimensions.ball_mass"] + 24.0) * 9.81
    assert found.objective.after[0] == pytest.approx(20.0 / weights, rel=1e-2)


def test_the_picture_shows_the_value_before_and_what_was_reached(found):
    course = found.plot().axes[1]
    before = next(line for line in course.lines if line.get_label() == "before")
    low, high = course.get_ylim()
    assert list(before.get_ydata()) == [found.objective.before[0]] * 2
    assert low < found.objective.after[0] < high
    assert low < found.objective.before[0] < high


def test_a_new_run_of_the_scene_has_what_was_found(found):
    assert pendulum.equilibrium_speed(closed_form(*found.values.values()), arm_angle=OUTER) == pytest.approx(SPEED, rel=1e-8)
    assert gm.controlling_force(found.scene).working_range.speed.max() == pytest.approx(SPEED, rel=1e-8)
    assert found.before == gm.load("porter").replace(
        {"effects.stops": {"arm_angle": ["20 deg", "45 deg"]}, "effects.dry_friction": {"sleeve_lift": "20 N"}}
    )


def test_the_conditions_of_karush_kuhn_and_tucker_hold(governor):
    """At the optimum the gradient of the objective is one of the active conditions, with the right signs; by the closed form."""
    over = MASSES | {"dimensions.offset": ("20 mm", "60 mm")}
    conditions = ["highest equilibrium speed = 130 rpm", "sensitiveness >= 0.2"]
    optimum = gm.optimise(governor, over, minimise="insensitivity", subject_to=conditions)
    place = np.array(list(optimum.values.values()))

    def quantities(values):
        speeds = pendulum.equilibrium_speed(closed_form(*values), arm_angle=np.array([np.radians(20.0), OUTER]))
        return np.array([20.0 / ((values[0] + values[1]) * 9.81), speeds[1], 2 * (speeds[1] - speeds[0]) / speeds.sum()])

    steps = 1e-5 * np.diag(place)
    slopes = np.array([(quantities(place + step) - quantities(place - step)) / (2 * step.sum()) for step in steps]) * place[:, None]
    sleeve_at_bound = np.array([0.0, 1.0, 0.0])
    factors, rest, *_ = np.linalg.lstsq(np.column_stack([slopes[:, 1], slopes[:, 2], sleeve_at_bound]), -slopes[:, 0], rcond=None)
    assert optimum.converged
    assert not rest.size or rest[0] < 1e-12
    assert factors[1] <= 0.0  # of the condition >=
    assert factors[2] >= 0.0  # of the upper bound
    assert 0.2 <= quantities(place)[2] < 0.2 * (1.0 + 1e-5)


def test_conditions_on_runs_are_met_by_a_new_run():
    over = ["spindle.speed=110rpm:125rpm"]
    optimum = gm.optimise("porter", over, minimise="amplitude of sleeve_lift", subject_to=["frequency of sleeve_lift >= 0.8 Hz"])
    table = gm.sweep(optimum.scene, {"spindle.speed": [optimum.values["spindle.speed"]]}, ["frequency of sleeve_lift"], accuracy=1e-8)
    assert optimum.converged
    assert optimum.quantities[1].active
    assert table.column("frequency of sleeve_lift")[0] >= 0.8
    assert 0.0 <= optimum.quantities[1].margin < 1e-5


def test_of_several_values_the_largest_counts():
    """Two lines cross where both are equal: there the largest of both is least, and it has a kink."""

    def lines(scene):
        arm = scene.part.dimensions["arm"]
        return np.array([arm - 0.31, 2.0 * (0.34 - arm)])

    optimum = gm.optimise("porter", ["dimensions.arm=0.28m:0.4m"], minimise=lines)
    assert optimum.values["dimensions.arm"] == pytest.approx(0.33, abs=1e-8)
    assert optimum.converged
    assert max(optimum.objective.after) == pytest.approx(0.02, abs=1e-8)


def test_an_impossible_geometry_lies_outside():
    """The mass centre of the rod, 600 mm from the crank pin, must lie on the rod: the best is beside that, and the search says so."""

    def ratio(scene):
        return scene.part.dimensions["crank"] / scene.part.dimensions["connecting_rod"]

    over = ["dimensions.crank=50mm:500mm", "dimensions.connecting_rod=200mm:1600mm"]
    optimum = gm.optimise("slider_crank", over, maximise=ratio, method="global", seed=3)
    assert optimum.objective.after[0] == pytest.approx(500.0 / 600.0, rel=1e-3)
    assert not optimum.converged
    assert "beside values that are impossible, [effects] masses.rod_centre" in optimum.outcome


def test_an_objective_that_does_not_change_is_a_named_end():
    """The greatest angle is that of the start, whatever the arm."""
    optimum = gm.optimise("porter", ["dimensions.arm=280mm:320mm"], minimise="max arm_angle")
    assert not optimum.converged
    assert "max arm_angle does not change with any of the values there" in optimum.outcome
    flat_at_start = gm.optimise("porter", ["dimensions.arm=280mm:320mm"], minimise=lambda scene: (scene.part.dimensions["arm"] - 0.3) ** 2)
    assert flat_at_start.converged


def test_the_settling_time_changes_smoothly():
    """It lies between two reported times, and by linear interpolation changes with the dashpot in much smaller steps."""
    values = [f"{200 + 0.5 * k} N s/m" for k in range(9)]
    table = gm.sweep("porter_dashpot", {"effects.dashpot.sleeve": values}, ["settling time of sleeve_lift"])
    times = table.column("settling time of sleeve_lift")
    assert np.all(np.isfinite(times))
    assert 0.0 < np.max(np.abs(np.diff(times))) < 0.5 * gm.load("porter_dashpot").run.output_interval


def test_conditions_that_exclude_each_other_are_a_named_end(governor):
    conditions = ["highest equilibrium speed >= 130 rpm", "highest equilibrium speed <= 129 rpm"]
    optimum = gm.optimise(governor, MASSES, minimise="insensitivity", subject_to=conditions)
    assert not optimum.ok
    assert "no values were found that meet all conditions" in str(optimum)
    assert min(row.margin for row in optimum.quantities[1:]) < 0.0


def bowl(scene):
    return (scene.part.dimensions["arm"] - 0.31) ** 2 + (scene.part.dimensions["offset"] - 0.05) ** 2 + 1.0


@pytest.mark.parametrize("options", [{"method": "global"}, {"starts": 3}])
def test_the_same_seed_gives_the_same_optimum(options):
    over = ["dimensions.arm=280mm:400mm", "dimensions.offset=20mm:60mm"]
    first, again = (gm.optimise("porter", over, minimise=bowl, seed=5, **options) for _ in range(2))
    assert first.as_json() == again.as_json()
    assert first.values == pytest.approx({"dimensions.arm": 0.31, "dimensions.offset": 0.05}, abs=1e-5)


@pytest.mark.long
@pytest.mark.parametrize("options", [{"method": "global"}, {"starts": 4}])
def test_the_optimum_does_not_depend_on_the_number_of_processes(options, governor, monkeypatch):
    for name in ("TRIAL_TIME", "PROCESS_START_TIME", "LONG_ROW_TIME"):  # processes start at once
        monkeypatch.setattr(workers, name, 1e-3)
    condition = ["highest equilibrium speed = 130 rpm"]
    found = [gm.optimise(governor, MASSES, minimise="insensitivity", subject_to=condition, workers=n, **options) for n in (1, 2)]
    assert found[1].values == pytest.approx(found[0].values, rel=1e-12)
    assert found[1].n_evaluations == found[0].n_evaluations


def test_an_interrupted_search_keeps_the_best_and_continues(tmp_path, monkeypatch):
    journal, over = tmp_path / "folder" / "optimum.part", ["dimensions.arm=280mm:400mm", "dimensions.offset=20mm:60mm"]
    calls = interrupt_at_call(monkeypatch, Question, "evaluate", 5)
    stopped = gm.optimise("porter", over, minimise=bowl, out=journal)
    assert not stopped.converged
    assert "interrupted" in stopped.outcome
    before = len(calls)
    journal.write_text(journal.read_text() + "[[0.1, 0")  # a line that was cut off
    continued = gm.optimise("porter", over, minimise=bowl, out=journal)
    whole = gm.optimise("porter", over, minimise=bowl)
    assert continued.as_json() == whole.as_json()
    assert len(calls) - before == 2 * whole.n_evaluations - 4
    assert not journal.exists()


def test_a_trade_off_is_that_of_two_parabolas(tmp_path):
    """Where the second may be at most c, the arm is 0.35 - sqrt(c), and the first grows with its distance from 0.29."""

    def short(scene):
        return (scene.part.dimensions["arm"] - 0.29) ** 2

    def long(scene):
        return -((scene.part.dimensions["arm"] - 0.35) ** 2)

    curve = gm.trade_off("porter", ["dimensions.arm=280mm:400mm"], minimise=[short], maximise=[long], points=4)
    arms = np.array([row.values["dimensions.arm"] for row in curve.rows])
    limits = np.linspace(0.06**2, 0.0, 4)
    assert curve.ok
    assert arms == pytest.approx(0.35 - np.sqrt(limits), abs=1e-3)
    assert [row.first for row in curve.rows] == pytest.approx((arms - 0.29) ** 2, abs=1e-9)
    assert curve.start == pytest.approx((0.01**2, -(0.05**2)))
    assert curve.to_dataframe().shape == (4, 4)
    assert curve.plot().axes
    assert [scene.part.dimensions["arm"] for scene in curve.scenes] == arms.tolist()
    assert json.loads(curve.save_json(tmp_path / "curve.json").read_text())["names"] == ["short", "long"]


@pytest.mark.parametrize(("name", "sentence"), [("", "is a folder"), ("notes.txt", "is not the file of an optimisation")])
def test_no_other_file_is_overwritten(name, sentence, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(gm.MechanismError, match=sentence):
        gm.optimise("porter", ["dimensions.arm=280mm:400mm"], minimise="max arm_angle", out=tmp_path / name)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_leads_in_gears_are_those_of_the_study_of_gears():
    study = gm.valve_gears("stephenson_arc_middle", count=7).gears[0]
    table = gm.sweep("stephenson_arc_middle", {"dimensions.crank": ["300 mm"]}, ["lead difference", "lead change"])
    assert table.column("lead difference")[0] == pytest.approx(np.max(np.abs(np.diff(study.leads))), abs=1e-12)
    assert table.column("lead change")[0] == pytest.approx(np.ptp(study.leads.mean(axis=1)), abs=1e-12)


@pytest.mark.long
def test_the_leads_of_a_link_motion_become_equal_in_all_gears():
    over = {
        "dimensions.eccentric_rod": ("1100 mm", "1300 mm"),
        "dimensions.link_radius": ("1100 mm", "1300 mm"),
        "dimensions.hanger": ("300 mm", "700 mm"),
        "dimensions.pin_setback": ("-50 mm", "100 mm"),
        "dimensions.valve_set_at": (-1, 1),
    }
    optimum = gm.optimise("stephenson_arc_middle", over, minimise="lead change", subject_to=["lead difference <= 0.1 mm"])
    leads = gm.valve_gears(optimum.scene, count=7).gears[0].leads
    assert optimum.converged
    assert np.max(np.abs(np.diff(leads))) <= 1e-4
    assert len(optimum.quantities[1].after) == 7
    assert np.ptp(leads.mean(axis=1)) < optimum.objective.before[0]


def test_rules_about_a_governor_are_those_of_its_statics(governor):
    names = ["lowest equilibrium speed", "highest equilibrium speed", "sensitiveness", "work capacity", "insensitivity"]
    table = gm.sweep(governor, {"dimensions.arm": ["300 mm"]}, names)
    found = gm.controlling_force(governor).working_range
    band = gm.insensitivity_band(governor, found.coordinate, "20 N").insensitivity
    expected = [found.speed[0], found.speed[1], found.sensitiveness, found.work_capacity, band.max()]
    assert [table.column(name)[0] for name in names] == pytest.approx(expected, rel=1e-9)
    plain = gm.sweep("porter", {"dimensions.arm": ["300 mm"]}, ["sensitiveness", "insensitivity"])
    assert "has no working range" in plain.rows[0].message


def test_a_dimension_of_any_kind_is_an_unknown():
    """The law of the lambda linkage holds at the rocker that its file has, as an expression of the crank."""
    table = gm.sweep("chebyshev_lambda", ["dimensions.rocker=2.49m:2.51m:3"], ["law difference"])
    assert table.column("law difference")[1] <= 1.0
    assert min(table.column("law difference")[::2]) > 1.0
    optimum = gm.optimise("chebyshev_lambda", ["dimensions.rocker=2.2m:2.8m"], minimise=lambda scene: scene.part.dimensions["rocker"])
    assert optimum.rows[0].before == 2.5
    assert optimum.values["dimensions.rocker"] == pytest.approx(2.2, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"minimise": lambda run: 1.0, "workers": 2}, "define the function with def at module level"),
        ({"minimise": lambda run: 1.0, "out": "x.part"}, "define the function with def at module level"),
        ({"minimise": lambda scene: np.nan}, "the search cannot begin"),
        ({"minimise": lambda scene: 1 / 0}, "the function failed with ZeroDivisionError: division by zero"),
    ],
)
def test_mistakes_are_sentences(changes, sentence):
    arguments = {"over": ["dimensions.arm=280mm:320mm"], "minimise": "max arm_angle"} | changes
    with pytest.raises(gm.MechanismError) as caught:
        gm.optimise("porter", **arguments)
    assert sentence in str(caught.value)


def test_all_mistakes_are_named_at_once():
    with pytest.raises(gm.MechanismError) as caught:
        gm.optimise("porter", ["dimensions.arm=3m:2m"], minimise="x", subject_to=["y <= 1", "z"], method="?")
    assert len(caught.value.problems) == 5


def test_bounds_as_text_may_be_bare_numbers():
    read = parse_unknowns(gm.load("stephenson_arc_middle"), ["dimensions.valve_set_at=-1:1", "dimensions.hanger=300mm:0.7"])
    assert [(one.low, one.high) for one in read] == [(-1.0, 1.0), (0.3, 0.7)]
