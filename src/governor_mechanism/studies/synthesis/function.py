"""Function generation: Freudenstein's equation for three, four and five pairs of angles.

With lengths d of the ground, a, b and c of input, coupler and output, and angles phi and psi of input and output from the line of the
fixed pivots, K1 cos(psi) - K2 cos(phi) + K3 = cos(phi - psi), where K1 = d/a, K2 = d/c, K3 = (a^2 - b^2 + c^2 + d^2) / (2 a c).
Four pairs leave the angle at which the output starts unknown, five also the angle at which the input starts.

F. Freudenstein, Approximate synthesis of four-bar linkages, Transactions of the ASME 77 (1955), pp. 853-861.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column
from governor_mechanism.studies.synthesis.linkage import (
    CHECK_COLUMNS,
    DIMENSION_COLUMNS,
    Candidate,
    FourBarLinkage,
    Synthesis,
    SynthesisedLinkage,
    check_all,
    output_changes,
)
from governor_mechanism.studies.synthesis.tables import parse_pair, read_points, require_count
from governor_mechanism.types import FloatArray
from governor_mechanism.units.expressions import Expression, Function, Measured
from governor_mechanism.units.quantities import parse_quantity
from governor_mechanism.units.text_table import short_repr

KEYS: Final = ("function", "over", "input_angles", "output_angles", "count", "ground")
COLUMNS: Final = {"input_angle": "angle", "output_angle": "angle"}
RANK_TOLERANCE: Final = 1e-7
"""Residual of Freudenstein's equation below which angles are a root; rounding leaves 1e-12."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FunctionTask:
    """Pairs of angles, rad, shape (n, 2), and, where they come from a function, the angles wanted between them, shape (m, 2)."""

    pairs: FloatArray
    wanted: FloatArray | None = None
    text: str = ""
    arguments: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class FunctionSynthesis(Synthesis):
    """Four-bars that generate a function.

    Attributes
    ----------
    pairs
        Pairs of angles of input and output that were asked for, rad; shape (n, 2).
    arguments
        Arguments of the function at these pairs; shape (n,), None without a function.
    task
        The task.
    """

    pairs: FloatArray
    arguments: FloatArray | None
    task: FunctionTask

    __repr__ = short_repr
    figure = "render.figures.synthesis.function_figure"
    hidden = ("task",)
    columns = (*DIMENSION_COLUMNS, Column("error", "largest error, deg", ".4f/deg", "rad"), *CHECK_COLUMNS)

    def structural_error(self, number: int = 1) -> FloatArray:
        """Return input angles and what the output of a linkage has too much there, rad; shape (m, 2), at the pairs without a function."""
        return _structural_error(self.rows[number - 1], self.task)


def chebyshev_points(low: float, high: float, count: int) -> FloatArray:
    """Return the zeros of Chebyshev's polynomial over an interval, with which the largest error is near its least."""
    angles = math.pi * (np.arange(count) + 0.5) / count
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(angles)


def read_function_task(source: object, given: Mapping[str, Any]) -> tuple[FunctionTask, float]:
    """Return the task of a file, or of arguments, and the length of the ground, m."""
    pairs, keys = (None, {}) if source is None else read_points(source, COLUMNS, KEYS)
    keys = {**keys, **{name: value for name, value in given.items() if value is not None}}
    ground = parse_quantity(keys.pop("ground", 1.0), "length", "the length of the ground")
    if not ground > 0.0:
        raise MechanismError(f"the length of the ground must be positive; found {ground:g} m")
    function = keys.get("function")
    if (pairs is None) == (function is None):
        raise MechanismError(
            "a function is given by pairs of angles, or by 'function' with 'over', 'input_angles' and 'output_angles'; give one of both"
        )
    if pairs is None:
        return _task_of_function(keys), ground
    if keys:
        raise MechanismError(f"{', '.join(keys)} belong to a function, and pairs of angles are given; leave them out")
    require_count(pairs, (3, 4, 5), "the number of pairs of angles")
    return FunctionTask(pairs=pairs), ground


def _task_of_function(keys: Mapping[str, Any]) -> FunctionTask:
    """Return pairs of angles with Chebyshev's spacing; angles are proportional to the argument and to the value."""
    missing = [name for name in ("over", "input_angles", "output_angles") if name not in keys]
    if missing:
        raise MechanismError(f'a function also needs {", ".join(missing)}, as over = [1, 2] and input_angles = ["30 deg", "120 deg"]')
    count = keys.get("count", 3)
    if count not in (3, 4, 5):
        raise MechanismError(f"count, the number of pairs of angles, must be 3, 4 or 5; found {count}")
    low, high = parse_pair(keys["over"], "number", "over")
    inputs, outputs = (parse_pair(keys[name], "angle", name) for name in ("input_angles", "output_angles"))
    if low == high or inputs[0] == inputs[1] or outputs[0] == outputs[1]:
        raise MechanismError("over, input_angles and output_angles must each have two different values")
    function, text = read_function(keys["function"])
    start, end = function(np.array([low, high]))
    if start == end:
        raise MechanismError(f"{text} has the value {start:g} at both ends of over, so that no angles of the output follow from it")
    points = chebyshev_points(low, high, count)

    def angles_at(x: FloatArray) -> FloatArray:
        phi = inputs[0] + (x - low) / (high - low) * (inputs[1] - inputs[0])
        psi = outputs[0] + (function(x) - start) / (end - start) * (outputs[1] - outputs[0])
        return np.column_stack([phi, psi])

    return FunctionTask(pairs=angles_at(points), wanted=angles_at(np.linspace(low, high, 181)), text=text, arguments=points)


def read_function(function: object) -> tuple[Callable[[FloatArray], FloatArray], str]:
    """Return a function of x from a formula, as "log10(x)", or from Python, and its text; it refuses values that are not finite."""
    evaluate: Callable[[FloatArray], FloatArray]
    if callable(function):
        evaluate, text = partial(_apply, function), "the function"
    elif isinstance(function, str):
        text = function.strip().removeprefix("=").strip()
        expression = Expression(text)
        unknown = [name for name in expression.names if name != "x"]
        if unknown:
            raise MechanismError(f"the formula {text!r} may have the name x alone; found {', '.join(unknown)}")
        evaluate = partial(_evaluate, expression)
    else:
        raise MechanismError(f'function must be a formula of x, as "log10(x)", or a function; found {function!r}')

    def finite(x: FloatArray) -> FloatArray:
        values = evaluate(x)
        if not np.all(np.isfinite(values)):
            raise MechanismError(f"{text} has no finite value at x = {x[~np.isfinite(values)][0]:g}")
        return values

    return finite, text


def _apply(function: Callable[[float], float], x: FloatArray) -> FloatArray:
    return np.array([float(function(one)) for one in x.tolist()])


def _evaluate(expression: Expression, x: FloatArray) -> FloatArray:
    value = expression.evaluate(lambda _: Measured(x), FUNCTIONS).value
    return np.broadcast_to(np.asarray(value, dtype=np.float64), x.shape)


def _plain(function: Callable[[FloatArray], FloatArray]) -> Function:
    return Function(lambda argument: Measured(function(argument.value)))


FUNCTIONS: Final[Mapping[str, Function]] = {
    name: _plain(getattr(np, name)) for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "log10", "abs")
}
"""Functions of formulas; angles in rad, and `log` is the natural logarithm."""


def synthesise_function(task: FunctionTask, ground: float) -> FunctionSynthesis:
    """Return the four-bars through pairs of angles."""
    phi, psi = task.pairs.T
    starts = {3: lambda: [(0.0, 0.0)], 4: lambda: [(0.0, s) for s in _output_starts(phi, psi)], 5: lambda: _both_starts(phi, psi)}[
        len(phi)
    ]()
    found = [_linkage(phi + input_start, psi + output_start, ground) for input_start, output_start in starts]
    rows = [replace(row, error=_largest_error(row, task)) for row in check_all([one for one in found if one is not None])]
    notes = _notes(task, len(starts), len(rows), found.count(None))
    return FunctionSynthesis(pairs=task.pairs, arguments=task.arguments, rows=tuple(rows), notes=notes, task=task)


def _notes(task: FunctionTask, n_roots: int, n_rows: int, n_impossible: int) -> tuple[str, ...]:
    free = {3: "", 4: " with the start of the output free", 5: " with the starts of input and output free"}[len(task.pairs)]
    roots = f"{n_roots} real root{'s' * (n_roots != 1)}"
    notes = [f"{len(task.pairs)} pairs of angles{free}: Freudenstein's equation has {roots}; linkages found: {n_rows}"]
    if n_impossible:
        notes.append(f"{n_impossible} would need a coupler whose length squared is negative, or an infinite link")
    return tuple(notes)


def _matrix(phi: FloatArray, psi: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(psi), -np.cos(phi), np.ones(len(phi)), -np.cos(phi - psi)])


def _linkage(phi: FloatArray, psi: FloatArray, ground: float) -> Candidate | None:
    """Return the linkage of angles with its positions; None if the lengths are not real or not finite."""
    system = _matrix(phi, psi)
    k1, k2, k3 = np.linalg.lstsq(system[:, :3], -system[:, 3], rcond=None)[0]
    if min(abs(k1), abs(k2)) < 1e-9:
        return None
    a, c = 1.0 / k1, 1.0 / k2  # negative for a link on the other side of its pivot
    if a * a + c * c + 1.0 - 2.0 * a * c * k3 <= 0.0:
        return None
    moving = ground * np.column_stack([a * np.exp(1j * phi), 1.0 + c * np.exp(1j * psi)])
    positions = np.column_stack([moving, moving.mean(axis=1)])
    start, end, point = map(complex, positions[0])
    return FourBarLinkage(fixed=(0j, complex(ground)), moving=(start, end), point=point), positions


def _output_starts(phi: FloatArray, psi: FloatArray) -> list[float]:
    """Return the starts of the output for which four pairs agree; the determinant is a quadratic form in their cosine and sine."""
    form = _start_form(phi, psi)
    roots = np.roots(form[::-1]) if abs(form[2]) > RANK_TOLERANCE * np.abs(form).max() else np.append(np.roots(form[1::-1]), np.inf)
    real = roots[np.abs(np.imag(roots)) < RANK_TOLERANCE * (1.0 + np.abs(roots))]
    return sorted(float(one) for one in np.arctan(np.real(real)))


def _start_form(phi: FloatArray, psi: FloatArray) -> FloatArray:
    """Return the coefficients of 1, t and t^2 of the determinant of four pairs over cos^2 of the output's start, whose tangent is t."""
    at = {start: float(np.linalg.det(_matrix(phi, psi + start))) for start in (0.0, 0.25 * math.pi, 0.5 * math.pi)}
    first, middle, last = at.values()
    return np.array([first, 2.0 * middle - first - last, last])


def _both_starts(phi: FloatArray, psi: FloatArray) -> list[tuple[float, float]]:
    """Return the starts of input and output for which five pairs agree."""
    # The determinants of the first four pairs, and of the first three with the fifth, are quadratics in
    # the tangent of the output's start. Their resultant is a polynomial of the eighth degree in the
    # tangent of the input's start, a Fourier series with nine terms.
    subsets = [0, 1, 2, 3], [0, 1, 2, 4]
    samples = math.pi * np.arange(9) / 9
    series = np.fft.fft([_resultant(*(_start_form(phi[one] + t, psi[one]) for one in subsets)) for t in samples]) / 9
    roots = np.roots(np.concatenate([series[4::-1], series[:4:-1]]))  # powers 4 to -4 of exp(2it)
    found = list[tuple[float, float]]()
    for t in 0.5 * np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-4]):
        for s in _output_starts(phi[:4] + t, psi[:4]):
            start = _refine(phi, psi, float(t), s)
            if start is not None and not any(_same_turn(start, other) for other in found):
                found.append(start)
    return sorted(found)


def _resultant(first: FloatArray, second: FloatArray) -> float:
    """Return the resultant of two quadratics from their coefficients of 1, t and t^2."""
    (c, b, a), (f, e, d) = first, second
    return float((a * f - c * d) ** 2 - (a * e - b * d) * (b * f - c * e))


def _refine(phi: FloatArray, psi: FloatArray, t: float, s: float) -> tuple[float, float] | None:
    """Return starts corrected by Newton's iteration on both determinants; None if the five pairs do not agree there."""
    rows = [list(one) for one in combinations(range(5), 4)][:2]
    start = np.array([t, s])

    def residual(at: FloatArray) -> FloatArray:
        return np.array([np.linalg.det(_matrix(phi[one] + at[0], psi[one] + at[1])) for one in rows])

    for _ in range(20):
        value = residual(start)
        slope = np.column_stack([(residual(start + step) - residual(start - step)) / 2e-6 for step in 1e-6 * np.eye(2)])
        correction = np.linalg.lstsq(slope, value, rcond=None)[0]
        start = start - correction
        if np.abs(correction).max() < 1e-14:
            break
    system = _matrix(phi + start[0], psi + start[1])
    solution = np.linalg.lstsq(system[:, :3], -system[:, 3], rcond=None)[0]
    misfit = float(np.abs(system[:, :3] @ solution + system[:, 3]).max())
    near = np.abs(start - (t, s)).max() < 1e-2
    return (float(start[0]), float(start[1])) if misfit < RANK_TOLERANCE and near else None


def _same_turn(first: tuple[float, float], second: tuple[float, float]) -> bool:
    """Return whether two starts are the same apart from half turns, which change the sign of a length."""
    return all(abs(math.remainder(one - other, math.pi)) < 1e-6 for one, other in zip(first, second, strict=True))


def _largest_error(row: SynthesisedLinkage, task: FunctionTask) -> float:
    return float(np.abs(_structural_error(row, task)[:, 1]).max())


def _structural_error(row: SynthesisedLinkage, task: FunctionTask) -> FloatArray:
    """Return input angles of the task, and the generated output less that wanted, both from the first pair."""
    wanted = task.pairs if task.wanted is None else task.wanted
    origin, linkage = task.pairs[0], row.linkage
    inputs = cmath.phase(linkage.moving[0] - linkage.fixed[0]) + wanted[:, 0] - origin[0]
    return np.column_stack([wanted[:, 0], output_changes(linkage, inputs) - (wanted[:, 1] - origin[1])])
