"""What the closed forms take and refuse: bounds, kinds of values, and where in an array the first wrong one stands."""

import inspect
import math
import re

import numpy as np
import pytest

from governor_mechanism.closed_form import pendulum_sizing
from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument
from governor_mechanism.errors import MechanismError
from refusing import refuses


def says(sentence):
    return pytest.raises(MechanismError, match=f"^{re.escape(sentence)}$")


@pytest.mark.parametrize("kind", [float, int, np.float64, lambda value: np.array([1.0, value])])
def test_bounds_are_kept_for_numbers_and_arrays_alike(kind):
    place = "[1]" if isinstance(kind(0), np.ndarray) else ""
    assert np.all(validate_argument(kind(-2), "load", "N") == kind(-2))
    assert np.all(validate_argument(kind(0), "load", "N", minimum=0.0) == kind(0))
    assert np.all(validate_argument(kind(1), "load", "N", greater_than=0.0) == kind(1))
    assert validate_argument(kind(1), "load", "N").dtype == np.float64
    with says(f"load must be 0 N or more; got load{place} = -1 N"):
        validate_argument(kind(-1), "load", "N", minimum=0.0)
    for number in (0, -1):
        with says(f"load must be above 0 N; got load{place} = {number} N"):
            validate_argument(kind(number), "load", "N", greater_than=0.0)
    with says(f"ratio must be above 0; got ratio{place} = 0"):
        validate_argument(kind(0), "ratio", "", greater_than=0.0)


@pytest.mark.parametrize("bounds", [{}, {"minimum": 0.0}, {"greater_than": 0.0}], ids=str)
def test_what_is_no_finite_number_is_refused(bounds):
    for number, text in ((math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf")):
        with says(f"load must be finite; got load = {text} N"):
            validate_argument(number, "load", "N", **bounds)
        with says(f"load must be finite; got load[2] = {text} N"):
            validate_argument([1.0, 2.0, number], "load", "N", **bounds)
    for value in (True, "1", None, 1j, [[1.0], [1.0, 2.0]], [True]):
        with says(f"load must be a number or an array of numbers in N; got {value!r}"):
            validate_argument(value, "load", "N", **bounds)
    with says("ratio must be a number or an array of numbers; got 'half'"):
        validate_argument("half", "ratio", "", **bounds)


def test_the_first_wrong_value_of_every_argument_is_shown():
    rows, columns = np.array([[1.0], [2.0]]), np.array([3.0, 4.0, 5.0])
    shown = (("rows", rows, "m"), ("columns", columns, "kg"), ("ratio", 0.5, ""))
    with says("too large; got rows[1, 0] = 2 m and columns[1] = 4 kg and ratio = 0.5; write less"):
        raise_where(rows * columns > 6.0, "too large", *shown, hint="write less")
    raise_where(rows * columns > 10.0, "too large", ("rows", rows, "m"))


def test_angles_are_below_their_bound_in_both_senses():
    below = math.radians(90) * (1 - 1e-15)
    for angle in (below, -below, 0.0):
        assert validate_angle(angle, "arm_angle", 90.0) == angle
    for sign in ("", "-"):
        with says(f"arm_angle must be below 90 deg and above -90 deg; got arm_angle = {sign}90 deg"):
            validate_angle(float(f"{sign}1") * math.pi / 2, "arm_angle", 90.0)
    with says("angle must be below 180 deg; got angle = 180 deg"):
        validate_angle(math.pi, "angle", 180.0, positive=True)
    with says("angle must be above 0 rad; got angle = 0 rad"):
        validate_angle(0.0, "angle", 180.0, positive=True)


SIZES = {"arm": 0.3, "lift": 0.08, "arm_angle": 0.5, "inner_angle": 0.4, "outer_angle": 0.6, "offset": 0.05, "ratio": 1.05}
WEIGHTS = {"resistance": 9.0, "mass_ratio": 3.0, "insensitivity": 0.02, "ball_mass": 2.0, "sleeve_mass": 6.0, "gravity": 9.81}
SIZING = [
    (function, name)
    for _, function in inspect.getmembers(pendulum_sizing, inspect.isfunction)
    if function.__module__ == pendulum_sizing.__name__ and not function.__name__.startswith("_")
    for name in inspect.signature(function).parameters
]


@pytest.mark.parametrize(("function", "name"), SIZING, ids=lambda value: getattr(value, "__name__", value))
def test_every_size_of_a_governor_is_finite_and_its_angles_are_acute(function, name):
    given = {one: (SIZES | WEIGHTS)[one] for one in inspect.signature(function).parameters}
    assert math.isfinite(function(**given))
    wrong = [math.nan, math.inf]
    wrong += [math.pi / 2, 2.0] if name.endswith("angle") else [-1.0] if name != "offset" else []
    wrong += [0.0] if name in ("arm", "inner_angle", "outer_angle", "ratio", "ball_mass", "gravity") else []
    for number in wrong:
        refuses(name, function, **given | {name: number})


def test_a_number_comes_back_as_a_number_and_an_array_as_an_array():
    assert type(as_scalar_or_array(np.float64(2.0))) is float
    np.testing.assert_array_equal(as_scalar_or_array([1, 2]), np.array([1.0, 2.0]))
    for value in (math.inf, math.nan, np.array([1.0, math.inf])):
        refuses("too large or too small for double precision", as_scalar_or_array, value)
