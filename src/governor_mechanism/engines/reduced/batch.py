"""Batch of runs of scenes that differ only in numbers, without certificate and observables.

Only for conservative scenes, whose table holds all forces: constant spindle speed, gravity, centrifugal forces. The table of a run is as
accurate as its steps, so that it has few pieces.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.engines.reduced.passage import describe_passage_end
from governor_mechanism.engines.reduced.row_arrays import RecordedRows, RowArrays, RowTemplate, lower_row
from governor_mechanism.engines.reduced.row_integration import NOT_STARTED, RowEnd, RowRequest, integrate_rows, make_row_buffers
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.engines.reduced.table_end import make_table_end_limits
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.step_record import NO_STEPS
from governor_mechanism.mechanics.kinematics.output_variables import unwrap_output
from governor_mechanism.mechanics.reduction.motion_table import INITIAL_TABLE_CAPACITY, TableEnd
from governor_mechanism.mechanics.reduction.node_evaluation import MIN_FIT_TOLERANCE
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.types import FloatArray, IntArray

FIT_TOLERANCE_RATIO = 0.1
"""Truncation error of a table relative to the error of a step."""

MAX_FIT_TOLERANCE = 1e-10
"""Largest truncation error of a table. Its pieces are then 1.8 times as wide as those of the most accurate one; wider ones save little."""

MAX_ROWS_AT_ONCE = 256
"""Largest number of rows that are run at once: what they share then costs less than a hundredth of them."""

MAX_NUMBERS_AT_ONCE = 1_000_000
"""Largest number of values and rates of readings of the rows that are run at once."""


@dataclass(frozen=True)
class UncertifiedResult:
    """Readings and rates of one run without certificate, at the times that it reached.

    Attributes
    ----------
    times
        Reported times, s; shape (n,).
    readings
        Values by name, SI; shape (n,).
    rates
        Their rates by name, SI per second; shape (n,).
    outcome
        How the run ended.
    detail
        Cause of an end before the last time; else empty.
    error_estimate
        None: the run is not certified.
    """

    times: FloatArray
    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    outcome: Outcome
    detail: str
    error_estimate: None = None

    @property
    def message(self) -> str:
        """Outcome as a sentence, after its cause if there is one."""
        return self.outcome.describe(self.detail)


class ReducedBatch:
    """Run scenes like a template, each from a value and rate of its coordinate. Threads may share a batch.

    Parameters
    ----------
    template
        A scene of the batch.
    names
        The readings to return.
    tolerance
        Error of one step, as in `ReducedEngine`.
    max_steps
        Largest number of steps of one run.
    """

    def __init__(self, template: Scene, names: Sequence[str], tolerance: float, max_steps: int) -> None:
        warn_before_compiling(integrate_rows, 40)
        mechanism, settings = template.part.mechanism, ReducedSettings()
        self._names = list(names)
        self.names = [name for name in names if name != mechanism.coordinate]
        """The readings other than the coordinate."""
        self._request = RowRequest(
            times=make_reported_times(template),
            tolerance=tolerance,
            max_steps=max_steps,
            max_step_ratio=settings.max_step_ratio,
            first_step_ratio=settings.first_step_ratio,
            table_end_limits=make_table_end_limits(settings),
            no_steps=NO_STEPS,
        )
        self._fit_tolerance = min(max(FIT_TOLERANCE_RATIO * tolerance, MIN_FIT_TOLERANCE), MAX_FIT_TOLERANCE)

    @property
    def rows_at_once(self) -> int:
        """Number of rows to run at once: enough to share what is common to all, few enough to keep their readings in little memory."""
        n_numbers = 2 * len(self._request.times) * (1 + len(self.names))
        return max(1, min(MAX_ROWS_AT_ONCE, MAX_NUMBERS_AT_ONCE // n_numbers))

    def run(self, scene: Scene) -> UncertifiedResult | None:
        """Run a scene.

        Parameters
        ----------
        scene
            The scene.

        Returns
        -------
        UncertifiedResult | None
            The result, or None if the scene is not conservative or cannot be assembled at its start.
        """
        arrays = self.lower(scene)
        if arrays is None:
            return None
        return self._integrate(scene, RowTemplate(arrays), np.zeros(0, dtype=np.int64), np.zeros((1, 0)))[0]

    def lower(self, scene: Scene) -> RowArrays | None:
        """Return the arrays of a scene, or None if it is not conservative or does not start at a value of its coordinate."""
        if not isinstance(scene.start.values.get(scene.part.mechanism.coordinate), float):
            return None
        arrays = lower_row(scene, self.names)
        return arrays if arrays.reduction.is_conservative else None

    def run_recorded(self, rows: RecordedRows, numbers: FloatArray) -> list[UncertifiedResult | None]:
        """Run rows of one record.

        Parameters
        ----------
        rows
            The record, for the readings `names`.
        numbers
            Numbers of the rows, as `RecordedRows.evaluate` returns them; shape (rows, places).

        Returns
        -------
        list
            The results, or None for a row that cannot be assembled at its start.
        """
        return self._integrate(rows.scene, rows.template.copy(), rows.places, numbers)

    def _integrate(self, scene: Scene, template: RowTemplate, places: IntArray, numbers: FloatArray) -> list[UncertifiedResult | None]:
        """Return the results of rows with numbers (rows, places) in a template, which is changed."""
        reduction = template.arrays.reduction._replace(fit_tolerance=self._fit_tolerance)
        arrays, n_rows = template.arrays._replace(reduction=reduction), len(numbers)
        readings, ends = np.zeros((n_rows, 1 + len(self.names), 2, len(self._request.times))), np.empty((n_rows, len(RowEnd)))
        template.buffer[places] = numbers[0]  # the buffers below are made from numbers, not from labels
        n_done, capacity = 0, INITIAL_TABLE_CAPACITY
        while n_done < n_rows:
            buffers = make_row_buffers(arrays, len(self._request.times), capacity)
            n_done = integrate_rows(arrays, template.buffer, places, numbers, n_done, self._request, buffers, readings, ends)
            capacity *= 2
        for k, name in enumerate(self.names, start=1):
            readings[:, k, 0] = unwrap_output(scene.part.mechanism.reading(name), readings[:, k, 0])
        return [self._make_result(scene, *row) for row in zip(readings, ends.tolist(), strict=True)]

    def _make_result(self, scene: Scene, readings: FloatArray, end: Sequence[float]) -> UncertifiedResult | None:
        """Return the result of a row with readings (1 + readings, 2, times) and an end, indexed by `RowEnd`."""
        if end[RowEnd.STATUS] == NOT_STARTED:
            return None
        mechanism, n_reached, status = scene.part.mechanism, int(end[RowEnd.REACHED_COUNT]), IntegrationStatus(int(end[RowEnd.STATUS]))
        outcome, detail = None, ""
        if status != IntegrationStatus.DONE:
            side, reason, is_at_bound = int(end[RowEnd.SIDE]), int(end[RowEnd.END_REASON]), bool(end[RowEnd.IS_AT_BOUND])
            table_end = TableEnd(side, reason, end[RowEnd.END_COORDINATE], is_at_bound)
            outcome, detail = describe_passage_end(scene, table_end, status, end[RowEnd.TIME], self._request.max_steps)
        motions = dict(zip([mechanism.coordinate, *self.names], readings[:, :, :n_reached], strict=True))
        return UncertifiedResult(
            times=self._request.times[:n_reached],
            readings={name: motions[name][0] for name in self._names},
            rates={name: motions[name][1] for name in self._names},
            outcome=outcome or Outcome.NOT_CERTIFIED,
            detail=detail,
        )
