"""Force laws of bodies in a turning plane, against a cloud of particles and against derivatives of the moment of inertia."""

import numpy as np
import pytest

from governor_mechanism.mechanics.dynamics import force_laws

STEP = 1e-5
"""Step of differences, m and rad: their error of second order, 1e-10, is about that of rounding, 1e-16 / 1e-5."""

ALLOWED = 1e-8


def particles(seed: int = 7):
    """Return masses (n,), kg, and places (n, 3), m, of particles in body axes, with their mass centre at the origin."""
    random = np.random.default_rng(seed)
    masses, places = random.uniform(0.1, 1.0, 9), random.normal(size=(9, 3)) * (0.3, 0.1, 0.2)
    return masses, places - masses @ places / masses.sum()


MASSES, PLACES = particles()
MASS = float(MASSES.sum())
XX, YY, XY, ZZ = (float(np.sum(MASSES * PLACES[:, i] * PLACES[:, k])) for i, k in ((0, 0), (1, 1), (0, 1), (2, 2)))
SPEED_SQUARED = 30.0


def inertia_of_particles(x: float, angle: float) -> float:
    """Return the moment of inertia about the spindle, the y axis of the plane, of the particles of a body."""
    out = x + PLACES[:, 0] * np.cos(angle) - PLACES[:, 1] * np.sin(angle)
    return float(np.sum(MASSES * (out**2 + PLACES[:, 2] ** 2)))


def inertia(x: float, angle: float) -> float:
    return float(force_laws.spindle_inertia(MASS, XX, YY, XY, ZZ, x, angle))


@pytest.mark.parametrize(("x", "angle"), [(0.4, 0.0), (0.4, 0.7), (-0.2, -2.1)])
def test_a_body_has_the_inertia_and_the_loads_of_its_particles(x, angle):
    assert inertia(x, angle) == pytest.approx(inertia_of_particles(x, angle), rel=1e-14)
    force = SPEED_SQUARED / 2 * (inertia_of_particles(x + STEP, angle) - inertia_of_particles(x - STEP, angle)) / (2 * STEP)
    moment = SPEED_SQUARED / 2 * (inertia_of_particles(x, angle + STEP) - inertia_of_particles(x, angle - STEP)) / (2 * STEP)
    assert force_laws.centrifugal_force(MASS, x, SPEED_SQUARED) == pytest.approx(force, rel=ALLOWED)
    assert force_laws.centrifugal_moment(XX, YY, XY, angle, SPEED_SQUARED) == pytest.approx(moment, rel=ALLOWED)


def test_rate_and_second_derivative_of_the_inertia_are_its_differences_along_a_path():
    def along(s: float) -> tuple[float, float]:
        return 0.4 + 0.3 * s - 0.5 * s**2, 0.7 + 1.1 * s + 0.4 * s**2

    (x, angle), step = along(0.0), 1e-4  # differences of second order: 1e-8, rounding 1e-16 / 1e-8
    before, here, after = (inertia(*along(s)) for s in (-step, 0.0, step))
    rate = force_laws.spindle_inertia_rate(MASS, XX, YY, XY, x, angle, 0.3, 1.1)
    assert rate == pytest.approx((after - before) / (2 * step), rel=1e-6)
    second = force_laws.spindle_inertia_second_derivative(MASS, (XX, YY, XY), x, angle, (0.3, 1.1), (-1.0, 0.8))
    assert second == pytest.approx((after - 2 * here + before) / step**2, rel=1e-6)


def test_weight_is_the_slope_of_its_energy():
    energies = [force_laws.gravitational_energy(2.0, 9.81, height) for height in (0.0, 1.0)]
    assert energies == [0.0, 2.0 * 9.81]
    assert force_laws.weight(2.0, 9.81) == -(energies[1] - energies[0])
