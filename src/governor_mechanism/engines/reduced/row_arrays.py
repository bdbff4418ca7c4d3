"""Arrays of the rows of a batch: lowered scenes of one structure, whose numbers are written into one template row by row."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.mechanics.reduction.lowering import lower_reduced_scene
from governor_mechanism.mechanics.reduction.node_evaluation import ReductionArrays
from governor_mechanism.mechanics.reduction.reduced_forces import ReducedForces
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.row_numbers import NotRecordable, Recorder, find_labels, is_number_or_label
from governor_mechanism.types import BoolArray, FloatArray, IntArray


class RowScalar(IntEnum):
    """Indices of `RowArrays.scalars`."""

    START = 0
    """Coordinate at the start, SI."""
    START_RATE = 1
    """Its rate, SI/s."""
    LOW = 2
    """As in `ReductionArrays`, like the next ones."""
    HIGH = 3
    STEADY_SPEED = 4
    TIME_SCALE = 5
    COORDINATE_SCALE = 6
    """As in `AssemblyArrays`."""
    MAX_STEP_SCALE = 7
    """Time that bounds the steps, s."""


class RowArrays(NamedTuple):
    """A lowered scene; in a template `scalars` replaces the scalars of the other fields.

    Attributes
    ----------
    reduction
        What is tabulated along the coordinate.
    forces
        The forces along it.
    reading_rows
        Rows of the readings to report, other than the coordinate.
    scalars
        Indexed by `RowScalar`.
    initial_guess
        Poses from which those at the start are reached by continuation; shape (bodies, 3).
    """

    reduction: ReductionArrays
    forces: ReducedForces
    reading_rows: ConstraintRows
    scalars: FloatArray
    initial_guess: FloatArray


def lower_row(scene: Scene, names: Sequence[str]) -> RowArrays:
    """Lower a scene with readings (other than the coordinate) to report.

    Parameters
    ----------
    scene
        Scene of one part, whose coordinate has a number as start value.
    names
        Names of the readings.

    Returns
    -------
    RowArrays
        The arrays.
    """
    reduction, forces, _ = lower_reduced_scene(scene)
    mechanism = scene.part.mechanism
    scalars = {
        RowScalar.START: scene.start.values[mechanism.coordinate],
        RowScalar.START_RATE: scene.start.rates.get(mechanism.coordinate, 0.0),
        RowScalar.LOW: reduction.low,
        RowScalar.HIGH: reduction.high,
        RowScalar.STEADY_SPEED: reduction.steady_speed,
        RowScalar.TIME_SCALE: reduction.time_scale,
        RowScalar.COORDINATE_SCALE: reduction.lagrangian.assembly.coordinate_scale,
        RowScalar.MAX_STEP_SCALE: max_step_scale(scene),
    }
    return RowArrays(
        reduction=reduction,
        forces=forces,
        reading_rows=make_output_rows(mechanism, names, {}),
        scalars=np.array([scalars[one] for one in RowScalar]),
        initial_guess=np.array(mechanism.initial_guess, dtype=np.float64),
    )


class RowTemplate:
    """Arrays whose numbers share one buffer.

    Parameters
    ----------
    arrays
        Arrays of one row; they are copied.

    Attributes
    ----------
    arrays
        The copies.
    buffer
        All their numbers, of 8 bytes each, as floats; shape (n,).
    """

    def __init__(self, arrays: RowArrays) -> None:
        self.buffer = np.zeros(_count_words(arrays))
        self.arrays: RowArrays = _copy_into(arrays, self.buffer, [0])

    def copy(self) -> "RowTemplate":
        """Return a template that shares nothing with this one."""
        return RowTemplate(self.arrays)


def _count_words(item: Any) -> int:
    """Return the size of all arrays in a tuple of arrays and tuples, in words of 8 bytes."""
    if isinstance(item, np.ndarray):
        return item.nbytes // 8
    return sum(map(_count_words, item)) if isinstance(item, tuple) else 0


def _copy_into(item: Any, buffer: FloatArray, position: list[int]) -> Any:
    """Return a tuple of arrays and tuples, with copies of its arrays in a buffer from a position (1,) on, which is moved."""
    if isinstance(item, np.ndarray):
        words = buffer[position[0] : position[0] + item.nbytes // 8]
        position[0] += len(words)
        copy = words.view(item.dtype).reshape(item.shape) if item.size else item.copy()
        copy[...] = item
        return copy
    if isinstance(item, tuple):
        copies = [_copy_into(one, buffer, position) for one in item]
        return type(item)(*copies) if hasattr(item, "_fields") else tuple(copies)
    return float(item) if isinstance(item, float) else item


def _has_only_numbers(item: Any) -> bool:
    """Return whether the floats in a tuple of arrays and tuples are all numbers or labels."""
    if isinstance(item, tuple):
        return all(map(_has_only_numbers, item))
    if not isinstance(item, np.ndarray):
        return True
    if item.dtype.names:
        return all(_has_only_numbers(np.ascontiguousarray(item[name])) for name in item.dtype.names)
    return item.dtype != np.float64 or bool(is_number_or_label(item.ravel()).all())


SceneMaker = Callable[[Mapping[str, float]], Scene]
"""Function that makes the scene of a row from the values of its keys; it raises an exception where there is none."""


@dataclass(frozen=True)
class RecordedRows:
    """The description and lowering of one row, recorded so that their numbers follow for other rows.

    Attributes
    ----------
    scene
        The scene, with labels instead of the numbers that differ among rows.
    template
        Its arrays, with labels.
    places
        Where the labels are in the buffer of the template; shape (labels,).
    """

    scene: Scene
    template: RowTemplate
    places: IntArray
    _recorder: Recorder
    _indices: IntArray

    @classmethod
    def record(cls, make_scene: SceneMaker, values: Mapping[str, float], names: Sequence[str]) -> "RecordedRows":
        """Record a row.

        Parameters
        ----------
        make_scene
            Function that makes the scene of a row.
        values
            Values of the keys of the recorded row.
        names
            Names of the readings to report, other than the coordinate.

        Returns
        -------
        RecordedRows
            The record.

        Raises
        ------
        NotRecordable
            If the description or the lowering does what cannot be recorded.
        """
        recorder = Recorder()
        with np.errstate(all="ignore"):  # arithmetic with a label, which is found below
            scene = make_scene({key: recorder.add_argument(value) for key, value in values.items()})
            arrays = lower_row(scene, names)
        if not _has_only_numbers(arrays):
            raise NotRecordable("arithmetic that is not recorded")
        template = RowTemplate(arrays)
        places, indices = find_labels(template.buffer.view(np.int64))
        return cls(scene, template, places, recorder, indices)

    def evaluate(self, values: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the numbers of rows.

        Parameters
        ----------
        values
            Values of the keys; shape (rows, keys).

        Returns
        -------
        numbers : FloatArray
            What belongs in the places; shape (rows, places).
        is_valid : BoolArray
            Whether the record holds for each row; shape (rows,).
        """
        numbers, is_valid = self._recorder.evaluate(values)
        return np.ascontiguousarray(numbers[:, self._indices]), is_valid

    def reproduces(self, values: FloatArray, arrays: RowArrays) -> bool:
        """Return whether the record gives the arrays of a row with values (keys,) to the last digit."""
        numbers, is_valid = self.evaluate(values[np.newaxis])
        found, expected = self.template.buffer.copy(), RowTemplate(arrays).buffer
        found[self.places] = numbers[0]
        return bool(is_valid[0]) and found.tobytes() == expected.tobytes()
