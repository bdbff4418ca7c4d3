"""Engines multibody and reduced on published benchmark mechanisms, from the shipped scene files."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import governor_mechanism as gm
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from reference import mechanisms

ENGINES = pytest.mark.parametrize("engine", ["multibody", "reduced"])


@ENGINES
def test_andrews_squeezer_agrees_with_the_published_angles(engine):
    run = gm.run("andrews_squeezer", engine=engine, accuracy=1e-10)
    assert run.outcome is Outcome.DONE
    assert run.times[-1] == mechanisms.ANDREWS["time"]
    for name, published in zip(mechanisms.ANDREWS["names"], mechanisms.ANDREWS["published"], strict=True):
        # Required accuracy of this problem; an independent solution differs by 2.7e-10.
        assert run.readings[name][-1] == pytest.approx(published, rel=1e-8)


@ENGINES
def test_andrews_squeezer_starts_as_published(engine):
    run = gm.run("andrews_squeezer", engine=engine, accuracy=1e-10, times=np.linspace(0.0, 1e-5, 11))
    for name, start, acceleration in zip(
        mechanisms.ANDREWS["names"], mechanisms.ANDREWS["start"], mechanisms.ANDREWS["start_accelerations"], strict=False
    ):
        assert run.readings[name][0] == pytest.approx(start, abs=1e-14)  # rounding of the assembly
        # From rest a rate is acceleration * time; over 1e-5 s the acceleration changes by a relative 1e-7.
        assert run.rates[name][-1] == pytest.approx(acceleration * 1e-5, abs=1e-6)


@cache
def run_chain():
    return gm.run("four_bar_chain", engine="multibody", accuracy=1e-9)


def test_four_bar_chain_passes_its_singular_position():
    run = run_chain()
    # Where the joints are singular, a rounding error displaces the links by its square root at most, another one on another processor.
    assert run.error_estimate <= math.sqrt(np.finfo(float).eps)
    found = [run.readings["x"][-1], run.readings["y"][-1], run.rates["x"][-1], run.rates["y"][-1]]
    np.testing.assert_allclose(found, mechanisms.FOUR_BAR["own"], atol=1e-9)  # requirement; measured 3e-11
    for name, error in zip(("x", "y"), np.subtract(found[:2], mechanisms.FOUR_BAR["own"][:2]), strict=True):
        assert abs(error) <= run.reading_errors[name]
    np.testing.assert_allclose(found, mechanisms.FOUR_BAR["published"], atol=2e-6)  # its own error, 7e-7 m and 2e-6 m/s
    assert found[:2] == pytest.approx(mechanisms.FOUR_BAR["published"][:2], abs=1e-6)


def test_four_bar_chain_locates_its_change_points():
    run = run_chain()
    points = [event.time for event in run.events if event.kind == EventKind.CHANGE_POINT]
    level = np.flatnonzero(np.diff(np.sign(run.readings["y"])))  # the cranks are horizontal where their ends cross y = 0
    assert len(points) == len(level)
    for time, k in zip(points, level, strict=True):
        assert run.times[k] <= time <= run.times[k + 1]
    dead = [event.time for event in run.events if event.kind == EventKind.TURNING_POINT and event.subject == "x"]
    # At a change point of this chain its ends are at their extreme position: both are located separately and agree.
    np.testing.assert_allclose(dead, points, atol=1e-6)


@ENGINES
def test_phase_of_the_pendulum_over_a_hundred_seconds(engine):
    times = np.linspace(0.0, 100.0, 401)
    run = gm.run("pendulum_iftomm", engine=engine, accuracy=1e-10, times=times)
    m = mechanisms.PENDULUM["modulus_squared"]
    sn, _, _, _ = ellipj(ellipk(m) - math.sqrt(mechanisms.PENDULUM["gravity"] / mechanisms.PENDULUM["length"]) * times, m)
    angle = 2 * np.arcsin(math.sqrt(m) * sn)
    assert np.max(np.abs(run.readings["x"] + np.sin(angle))) < 1e-9  # requirement; 42 oscillations at 1e-10
    assert np.max(np.abs(run.readings["y"] + np.cos(angle))) < 1e-9


@ENGINES
def test_pendulum_agrees_with_the_official_file(engine):
    run = gm.run("pendulum_iftomm", engine=engine, times=[0.5, 1.0, 10.0])
    for k, (_, *published) in enumerate(mechanisms.PENDULUM["published"][:2]):
        found = [run.readings["x"][k], run.readings["y"][k]]
        assert found == pytest.approx(published, abs=7.1e-7)  # printed to six decimals
    assert (run.readings["x"][-1], run.readings["y"][-1]) == pytest.approx(mechanisms.PENDULUM["own"], abs=1e-8)


@ENGINES
def test_slider_crank_under_torque_from_its_dead_centre(engine):
    run = gm.run("slider_crank_torque", engine=engine, accuracy=1e-10, times=np.linspace(0.0, 3.0, 301))
    at = int(np.searchsorted(run.times, mechanisms.SLIDER_CRANK["time"]))
    found = run.readings["crank_angle"][at], run.rates["crank_angle"][at], run.readings["slider_x"][at]
    assert found == pytest.approx(mechanisms.SLIDER_CRANK["own"], abs=1e-8)
    # The published series was computed at 1e-6; its error at 3 s is about 5.7e-3 rad, 5e-5 of 19 revolutions.
    assert run.readings["crank_angle"][-1] == pytest.approx(mechanisms.SLIDER_CRANK["published"][0], rel=1e-4)
