"""Where a governed engine is stable: eigenvalues, Routh's criterion by hand, and the growth of simulated motions."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import governor_mechanism as gm
from command_line import json_of
from governor_mechanism.closed_form import governed_engine
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.pendulum import PendulumGovernor
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.regulation.stability_map import find_periodic_motion
from reference import flywheel as printed

DASHPOT, INERTIA = "part.governor.effects.dashpot.sleeve", "part.engine.dimensions.inertia"
LOAD = 150.0
"""Load after the step of the shipped scenes, N m."""


def coefficients(dashpot):
    """Return the characteristic polynomial of the shipped loop under half the load, by hand."""
    engine, governor = AirEngine(**printed.ENGINE), PendulumGovernor(arm=0.3, offset=0.04, ball_mass=5.0, sleeve_mass=21.0)
    closing = -0.2 / 0.04  # of the throttle, 1/m
    opening = 1 - (governed_engine.full_throttle_torque(engine) - LOAD) / governed_engine.throttle_torque(engine)
    angle = math.acos(1 - (0.08 + (opening - 1) / closing) / 0.6)  # z = 2 l (1 - cos a)
    slope = closing * governed_engine.throttle_torque(engine)
    return governed_engine.pendulum_coefficients(
        governor, arm_angle=angle, flywheel_inertia=800.0, torque_slope=slope, sleeve_damping=dashpot
    )


@pytest.fixture(scope="module")
def limit():
    """Return the limit of stability along the dashpot, by eigenvalues."""
    return gm.stability_limit("governed_engine_mean_torque", DASHPOT, 5.0, 100.0)


def test_the_limit_of_the_eigenvalues_is_that_of_routh(limit):
    def routh(dashpot):
        polynomial = coefficients(dashpot)
        return polynomial.a * polynomial.b - polynomial.c

    border = brentq(routh, 5.0, 100.0, xtol=1e-13)
    assert limit.value == pytest.approx(border, rel=1e-9)
    assert limit.frequency == pytest.approx(math.sqrt(coefficients(border).b), rel=1e-9)  # s^2 = -b where a b = c


def test_the_simulated_motion_changes_from_decay_to_growth_at_the_limit(limit):
    document = gm.load("governed_engine_mean_torque").document

    def motion(dashpot):
        return find_periodic_motion(parse_scene_with(document, [(DASHPOT, dashpot)]), LOAD)

    weaker, at_limit, stronger = (motion(limit.value * factor) for factor in (1 - 1e-4, 1.0, 1 + 1e-4))
    assert weaker.growth_rate > 0.0 > stronger.growth_rate
    assert at_limit.frequency == pytest.approx(limit.frequency, rel=1e-6)


def test_multipliers_are_exponentials_of_the_eigenvalues_times_the_period():
    motion = find_periodic_motion(gm.load("governed_engine_mean_torque"), LOAD)
    eigenvalues = gm.linearise("governed_engine_mean_torque").eigenvalues
    # Central differences with a step of 1e-5 of runs that are right to 1e-10.
    assert np.sort(np.abs(motion.multipliers)) == pytest.approx(np.sort(np.exp(eigenvalues.real * motion.period)), abs=1e-5)
    assert motion.return_error < 1e-9


@pytest.mark.long
def test_the_cyclic_torque_moves_the_growth_rate_less_with_a_heavier_flywheel():
    documents = [gm.load(name).document for name in ("governed_engine", "governed_engine_mean_torque")]

    def shift(inertia):
        rates = [find_periodic_motion(parse_scene_with(one, [(INERTIA, inertia), (DASHPOT, 60.0)]), LOAD).growth_rate for one in documents]
        return abs(rates[0] - rates[1])

    # The speed fluctuation falls with the inertia, and its effect on the mean with its square.
    assert shift(600.0) < 0.5 * shift(300.0)


@pytest.mark.long
def test_map_and_hyperbola_agree_and_the_border_is_the_limit(limit):
    study = gm.stability_map("governed_engine_mean_torque", [f"{INERTIA}=400:1200:3", f"{DASHPOT}=5:65:4"], border_points=3)
    assert study.growth_rates.shape == (4, 3)
    assert 0 < study.stable_share < 1
    assert np.isfinite(study.parameters).all()
    assert study.disagreements == 0
    middle = next(point for point in study.border if point.x == 800.0)
    assert middle.mean == pytest.approx(limit.value, rel=1e-9)
    assert middle.cyclic is None
    assert middle.frequency == pytest.approx(limit.frequency, rel=1e-9)


@pytest.mark.long
def test_the_command_writes_map_and_figure(tmp_path):
    options = ["--vary", f"{INERTIA}=400:1200:2", "--vary", f"{DASHPOT}=5:65:2", "--border-points", "1", "--workers", "1"]
    values = json_of("regulation", "map", "governed_engine_mean_torque", *options, "--out", tmp_path)
    assert np.shape(values["growth_rates"]) == (2, 2)
    assert (tmp_path / "governed_engine_mean_torque_map.png").exists()


def test_one_border_point_stands_where_there_is_a_border():
    """Of three columns, the last alone has stable and unstable points."""
    study = gm.stability_map("governed_engine_mean_torque", [f"{INERTIA}=800:8000:2", f"{DASHPOT}=5:65:2"], border_points=1)
    assert [point.x for point in study.border] == [800.0]
    assert gm.stability_map("governed_engine_mean_torque", [f"{INERTIA}=8000:9000:2", f"{DASHPOT}=50:65:2"], border_points=2).border == ()
