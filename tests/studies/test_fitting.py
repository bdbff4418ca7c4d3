"""Fits: intervals hold the truth, what the data cannot tell is named, mistakes get sentences."""

import json
from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.fitting import search
from governor_mechanism.studies.sweep import workers
from interruptions import interrupt_at_call
from reference import mechanisms

NOISE = 1e-4
"""Standard deviation of a measured lift, m."""

NOISES = {"sleeve_lift": NOISE, "arm_angle": 0.02}
TIMES = 0.01 * np.arange(501)
UNKNOWNS = {
    "dimensions.ball_mass": ("4 kg", "6 kg", 5.0, "4.5 kg"),
    "effects.dry_friction.sleeve_lift": ("0.5 N", "5 N", 2.0, "3 N"),
    "effects.dashpot.sleeve_lift": ("3 N s/m", "30 N s/m", 10.0, "20 N s/m"),
    "dimensions.offset": ("20 mm", "60 mm", 0.04, "50 mm"),
    "start.arm_angle": ("50 deg", "60 deg", np.radians(55.0), "53 deg"),
    "spindle.speed": ("110 rpm", "130 rpm", 120.0 * np.pi / 30.0, "125 rpm"),
}
"""Bounds, truth and first value of each."""

OVER = {key: (low, high) for key, (low, high, _, _) in UNKNOWNS.items()}
TRUTH = {key: truth for key, (_, _, truth, _) in UNKNOWNS.items()}
FIRST = {key: first for key, (_, _, _, first) in UNKNOWNS.items()}
TWO = {key: OVER[key] for key in ("spindle.speed", "start.arm_angle")}


@pytest.fixture(scope="module")
def worn():
    """The Porter governor with friction and a dashpot at its sleeve."""
    effects = {"effects.dry_friction": {"sleeve_lift": "2 N"}, "effects.dashpot": {"sleeve_lift": "10 N s/m"}}
    return gm.load("porter").replace(effects | {"start.arm_angle": "55 deg", "run.duration": "5 s"})


@pytest.fixture(scope="module")
def exact(worn):
    """The exact readings by the other engine than the fit's."""
    return gm.run(worn, engine="multibody", times=TIMES, accuracy=1e-8).readings


@pytest.fixture(scope="module")
def lift(exact):
    return exact["sleeve_lift"]


@pytest.fixture(scope="module")
def fit_of(worn, lift):
    """The fit of all unknowns to the measurements of a seed; each is made once."""
    return cache(lambda seed: gm.fit(worn, measure(lift, seed), OVER, noise=NOISE, starts=1, engine="reduced"))


def measure(lift, seed):
    return {"time": TIMES, "sleeve_lift": lift + np.random.default_rng(seed).normal(0.0, NOISE, len(lift))}


def count_hits(fits):
    hits = dict.fromkeys(OVER, 0)
    for fit in fits:
        assert fit.converged
        assert fit.not_identifiable == ()
        for key, (low, high) in fit.intervals.items():
            hits[key] += low <= TRUTH[key] <= high
    return hits


def test_intervals_of_six_unknowns_hold_the_truth(fit_of):
    """With a probability of 95 % fewer than 6 of 8 would hold it once in 170."""
    hits = count_hits(map(fit_of, range(8)))
    assert min(hits.values()) >= 6, hits


@pytest.mark.long
def test_intervals_hold_the_truth_in_95_percent(fit_of):
    hits = count_hits(map(fit_of, range(1000, 1400)))
    assert min(hits.values()) >= 368, hits
    assert max(hits.values()) <= 392, hits


def test_a_far_start_ends_at_the_same_values(worn, lift, fit_of):
    near, far = fit_of(7), gm.fit(worn.replace(FIRST), measure(lift, 7), OVER, noise=NOISE, starts=1)
    for key, value in near.values.items():
        assert far.values[key] == pytest.approx(value, abs=0.05 * near.standard_errors[key])


def test_common_scale_of_masses_and_forces_is_named(worn, lift):
    over = {**OVER, "dimensions.sleeve_mass": ("15 kg", "25 kg")}
    fit = gm.fit(worn, measure(lift, 1), over, noise=NOISE, starts=1)
    (sentence,) = fit.not_identifiable
    scaled = ["dimensions.ball_mass", "effects.dry_friction.sleeve_lift", "effects.dashpot.sleeve_lift", "dimensions.sleeve_mass"]
    for key in scaled:
        assert f"{key} by +1.00 %" in sentence
        assert fit.standard_errors[key] is None
        assert fit.intervals[key] is None
    for key in set(over) - set(scaled):
        assert key not in sentence
        assert fit.standard_errors[key] > 0.0


def test_common_scale_of_both_masses_is_named_without_other_forces():
    run = gm.run("porter", times=TIMES, accuracy=1e-8)
    over = {"dimensions.ball_mass": (4.0, 6.0), "dimensions.sleeve_mass": (15.0, 25.0), "spindle.speed": ("110 rpm", "130 rpm")}
    fit = gm.fit("porter", measure(run.readings["sleeve_lift"], 2), over, noise="0.1 mm", starts=1)
    (sentence,) = fit.not_identifiable
    assert "dimensions.ball_mass by +1.00 % and dimensions.sleeve_mass by +1.00 %" in sentence
    assert fit.standard_errors["spindle.speed"] > 0.0


def test_noise_that_is_not_given_is_estimated(worn, lift):
    fit = gm.fit(worn, measure(lift, 3), TWO, starts=1)
    assert fit.noise["sleeve_lift"] == pytest.approx(NOISE, rel=0.1)
    assert not fit.is_noise_given
    given = gm.fit(worn, measure(lift, 3), TWO, noise=NOISE, starts=1)
    assert fit.values == pytest.approx(given.values, rel=1e-7)
    assert fit.standard_errors["spindle.speed"] == pytest.approx(given.standard_errors["spindle.speed"], rel=0.1)


def test_two_readings_have_each_their_own_noise(worn, exact):
    """A precise and a rough reading: both levels are estimated, and the precise one decides."""
    noise = np.random.default_rng(8).normal(size=(2, len(TIMES)))
    data = {"time": TIMES} | {name: exact[name] + size * n for (name, size), n in zip(NOISES.items(), noise, strict=True)}
    fit = gm.fit(worn, data, TWO, starts=1)
    assert fit.noise == pytest.approx(NOISES, rel=0.1)
    for key, (low, high) in fit.intervals.items():
        assert low <= TRUTH[key] <= high
        assert high - low < 1e-3 * TRUTH[key]


def test_profile_of_a_nearly_linear_unknown_is_its_interval(worn, lift):
    plain = gm.fit(worn, measure(lift, 4), TWO, noise=NOISE, starts=1)
    profiled = gm.fit(worn, measure(lift, 4), TWO, noise=NOISE, starts=1, profile=["spindle.speed"])
    assert profiled.rows[1].by_profile or profiled.rows[0].by_profile
    half_width = np.ptp(plain.intervals["spindle.speed"]) / 2
    assert profiled.intervals["spindle.speed"] == pytest.approx(plain.intervals["spindle.speed"], abs=0.03 * half_width)


def test_intervals_and_empty_cells_do_not_count(worn, lift, tmp_path):
    """An outlier in an interval that does not count changes nothing; units, empty cells and comments are read."""
    values = 1e3 * lift.copy()
    values[100:120] += 50.0
    cells = [f"{time:.2f},{'' if k % 7 == 3 else value}" for k, (time, value) in enumerate(zip(TIMES, values.tolist(), strict=True))]
    path = tmp_path / "lift.csv"
    path.write_text("# measured by hand\ntime [s],sleeve_lift [mm]\n" + "\n".join(cells) + "\n")
    fit = gm.fit(worn, path, {"spindle.speed": ("110 rpm", "130 rpm")}, noise="0.1 mm", without=[("0.99 s", "1.2 s")], starts=1)
    assert fit.values["spindle.speed"] == pytest.approx(TRUTH["spindle.speed"], rel=1e-7)
    assert len(fit.measurements[0].values) == sum(k % 7 != 3 for k in range(501) if not 0.99 <= TIMES[k] <= 1.2)


def test_results_of_a_run_are_data(worn, tmp_path):
    run = gm.run(worn, times=TIMES)
    run.save(tmp_path, name="worn", figures=False)
    pytest.importorskip("pandas")
    for data in (tmp_path / "worn.csv", run.to_dataframe()[["arm_angle"]]):
        fit = gm.fit(worn, data, ["spindle.speed=110rpm:130rpm"], starts=1)
        assert fit.values["spindle.speed"] == pytest.approx(TRUTH["spindle.speed"], rel=1e-6)
    assert fit.run.outcome.ok
    assert fit.scene.to_toml().count("rad/s") == 1


def test_an_interrupted_fit_keeps_the_best_values(worn, lift, monkeypatch):
    interrupt_at_call(monkeypatch, search.Misfit, "residuals", 20)
    fit = gm.fit(worn.replace(FIRST), measure(lift, 5), OVER, noise=NOISE, starts=1)
    assert not fit.ok
    assert "interrupted; these are the best values so far" in str(fit)


def test_a_fit_of_one_unknown_descends_from_as_many_starts_as_are_wanted(worn, lift, monkeypatch):
    starts = []

    def descend(_, start):
        starts.append(start)
        return start, True, "the search converged"

    monkeypatch.setattr(search, "_descend", descend)
    key = next(iter(OVER))
    gm.fit(worn.replace(FIRST), measure(lift, 5), {key: OVER[key]}, noise=NOISE, starts=12)
    assert len(starts) == 12


def test_a_geometry_that_cannot_be_assembled_lies_outside():
    """Half of the bounds of the angle lies beyond the travel; the search ends inside."""
    run = gm.run("porter", times=TIMES[:100], accuracy=1e-8)
    over = {"start.arm_angle": ("10 deg", "85 deg"), "dimensions.offset": ("1 mm", "250 mm")}
    fit = gm.fit("porter", {"time": run.times, "sleeve_lift": run.readings["sleeve_lift"]}, over, noise=NOISE)
    assert fit.values["start.arm_angle"] == pytest.approx(np.radians(40.0), abs=1e-6)


def test_data_that_no_run_reaches_end_without_convergence():
    """Under a sleeve that is too heavy for the speed the arms fall in line with the links before the last measured time."""
    scene = gm.load("porter").replace({"dimensions.sleeve_mass": "200 kg"})
    data = {"time": TIMES, "sleeve_lift": np.full(len(TIMES), 0.1)}
    fit = gm.fit(scene, data, {"dimensions.ball_mass": ("4.5 kg", "5.5 kg")}, noise=NOISE, starts=1)
    assert not fit.converged
    assert "no values were found with which the run reaches all times of the data" in fit.outcome
    assert 0 < len(fit.residuals["sleeve_lift"]) < len(TIMES)
    assert np.isfinite(fit.residuals["sleeve_lift"]).all()


def test_all_mistakes_are_found_at_once():
    with pytest.raises(gm.MechanismError) as caught:
        gm.fit("porter", {"time": [0.0, 0.1], "lift": [1.0, 2.0]}, {"spindle.sped": (1, 2)})
    assert len(caught.value.problems) >= 2


def test_json_has_all_values(worn, lift, tmp_path):
    fit = gm.fit(worn, measure(lift, 6), {"spindle.speed": ("110 rpm", "130 rpm")}, noise=NOISE, starts=1)
    record = json.loads(fit.save_json(tmp_path / "fit.json").read_text())
    assert record["rows"][0]["value"] == fit.values["spindle.speed"]
    assert record["converged"] is True
    assert fit.plot().save(tmp_path / "fit.png").stat().st_size > 5000


def test_printed_angles_determine_the_torque_of_the_motor():
    """The Test Set of Bari and CWI prints the angles of Andrews' mechanism at 0.03 s under 0.033 N m."""
    angles = zip(mechanisms.ANDREWS["names"], mechanisms.ANDREWS["published"], strict=True)
    printed = {name: [value] for name, value in angles if name in ("beta", "gamma", "Phi")}
    guess = gm.load("andrews_squeezer").replace({"force.motor.moment": "0.0325 N m"})
    bounds = {"force.motor.moment": ("0.032 N m", "0.034 N m")}
    fit = gm.fit(guess, {"time": [mechanisms.ANDREWS["time"]], **printed}, bounds, noise=1e-8, starts=1)
    assert fit.values["force.motor.moment"] == pytest.approx(0.033, rel=1e-8)


@pytest.mark.long
def test_the_fit_does_not_depend_on_the_number_of_processes(worn, lift, monkeypatch):
    for name in ("TRIAL_TIME", "PROCESS_START_TIME", "LONG_ROW_TIME"):  # processes start at once
        monkeypatch.setattr(workers, name, 1e-3)
    over = {key: OVER[key] for key in ("dimensions.ball_mass", "spindle.speed")}
    first, second = (gm.fit(worn, measure(lift, 1), over, noise=NOISE, starts=4, workers=n) for n in (1, 2))
    assert second.values == pytest.approx(first.values, rel=1e-9)
    assert second.n_runs == first.n_runs


def test_a_forgotten_unit_is_asked_for(worn, lift):
    data = {"time": TIMES, "sleeve_lift": 1e3 * lift}  # millimetres, of which the heading says nothing
    fit = gm.fit(worn, data, {"spindle.speed": ("115 rpm", "128 rpm")}, starts=1)
    assert any('write another unit in the heading, as "sleeve_lift [mm]"' in note for note in fit.notes)
