"""Numbers of many rows at once, followed through a calculation that is written for one row.

A calculation that is done with a `RowNumber` in place of a float is recorded: its arithmetic, its elementary functions and the outcome
of its comparisons, which are those of one row. The record is then evaluated for other rows, with the same operations in the same
order, so that their results are the same to the last digit. A row whose comparisons turn out otherwise needs a record of its own.

A `RowNumber` is a float whose bits are a label: a signalling NaN with the number of the recorded value. So it can be stored in arrays of
floats, in which the label tells where a number of each row belongs. Arithmetic that is not recorded, as that of numpy, leaves a quiet
NaN, by which it is found; the record is then of no use.
"""

import math
import operator
import struct
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import numpy as np

from governor_mechanism.types import BoolArray, FloatArray, IntArray

_LABEL = 0x7FF4_0000_0000_0000
"""Bits of a signalling NaN, to which the number of a recorded value is added."""

_FLOAT_BITS, _INTEGER_BITS = struct.Struct("<d"), struct.Struct("<q")

Operation = tuple[Callable[..., Any], tuple[int, ...]]
"""A function or comparison, and its operands as numbers of recorded values."""


class NotRecordable(Exception):  # noqa: N818 - not a mistake of anyone
    """A calculation does with a number of many rows what cannot be recorded, as to write it into a text."""


class Recorder:
    """The record of a calculation."""

    def __init__(self) -> None:
        self._row: list[float] = []
        self._n_arguments = 0
        self._constants: dict[int, tuple[int, float]] = {}
        self._operations: dict[Operation, int] = {}
        self._comparisons: dict[Operation, bool] = {}

    def add_argument(self, value: float) -> "RowNumber":
        """Return a number that differs among rows, with its value in the recorded row; all are added before the calculation."""
        self._n_arguments += 1
        return self._add(value)

    def record(self, function: Callable[..., float], operands: Sequence[float]) -> "RowNumber":
        """Return a function of numbers, at least one of which is a `RowNumber`."""
        operation = function, tuple(map(self._index_of, operands))
        if operation in self._operations:
            return RowNumber(self, self._operations[operation])
        number = self._add(function(*self._values(operation)))
        self._operations[operation] = number.index
        return number

    def compare(self, function: Callable[..., bool], operands: Sequence[float]) -> bool:
        """Return the outcome of a comparison in the recorded row, which is recorded."""
        comparison = function, tuple(map(self._index_of, operands))
        if comparison not in self._comparisons:
            self._comparisons[comparison] = function(*self._values(comparison))
        return self._comparisons[comparison]

    def evaluate(self, arguments: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return all recorded numbers in other rows, and in which of these the record holds.

        Parameters
        ----------
        arguments
            The arguments; shape (rows, arguments).

        Returns
        -------
        numbers : FloatArray
            Recorded numbers; shape (rows, numbers).
        is_valid : BoolArray
            Whether all comparisons have the recorded outcome, and all numbers exist; shape (rows,).
        """
        n_rows, columns = len(arguments), dict[int, list[float]](enumerate(arguments.T.tolist()))
        columns |= {index: [value] * n_rows for index, value in self._constants.values()}
        for (function, operands), index in self._operations.items():
            columns[index] = _map(function, *(columns[one] for one in operands))
        numbers = np.array([columns[index] for index in range(len(columns))]).reshape(-1, n_rows)
        is_valid: BoolArray = ~np.isnan(numbers).any(axis=0)
        for (compare, operands), outcome in self._comparisons.items():
            is_valid &= compare(*(numbers[one] for one in operands)) == outcome
        return numbers.T, is_valid

    def _add(self, value: float) -> "RowNumber":
        self._row.append(float(value))
        return RowNumber(self, len(self._row) - 1)

    def _index_of(self, value: float) -> int:
        """Return the number of a value in the record, to which a constant is added."""
        if isinstance(value, RowNumber):
            if value.recorder is not self:
                raise NotRecordable("numbers of two records")
            return value.index
        if math.isnan(value):
            raise NotRecordable("NaN, perhaps a label that has left its number")
        (bits,) = _INTEGER_BITS.unpack(_FLOAT_BITS.pack(value))
        if bits not in self._constants:
            self._constants[bits] = self._add(value).index, float(value)
        return self._constants[bits][0]

    def _values(self, operation: Operation) -> list[float]:
        """Return the operands of an operation in the recorded row."""
        return [self._row[index] for index in operation[1]]


def _map(function: Callable[..., float], *columns: list[float]) -> list[float]:
    """Return a function of columns of numbers, row by row; NaN where it does not exist."""
    try:
        return list(map(function, *columns))
    except (ValueError, ArithmeticError):
        return [_value_or_nan(function, *row) for row in zip(*columns, strict=True)]


def _value_or_nan(function: Callable[..., float], *arguments: float) -> float:
    try:
        return function(*arguments)
    except (ValueError, ArithmeticError):
        return math.nan


def _refuse(self: "RowNumber", *_: Any) -> Any:
    """Raise NotRecordable: the result would differ among rows, and is no number that can be recorded."""
    raise NotRecordable("a number of many rows has no text, no whole part and no hash")


def _operator(function: Callable[..., float], *, is_reflected: bool = False) -> Callable[..., Any]:
    """Return a method that records an operator."""

    def record(self: "RowNumber", *others: Any) -> Any:
        if not all(isinstance(other, float | int) for other in others):
            return NotImplemented
        return self.recorder.record(function, (*others, self) if is_reflected else (self, *others))

    return record


def _comparison(function: Callable[..., bool]) -> Callable[[Any, Any], bool]:
    """Return a method that records a comparison."""

    def compare(self: "RowNumber", other: Any) -> bool:
        return self.recorder.compare(function, (self, other)) if isinstance(other, float | int) else NotImplemented

    return compare


class RowNumber(float):
    """A number that differs among rows; its bits are a label.

    Attributes
    ----------
    recorder
        The record of the calculation.
    index
        Number of the value in the record.
    """

    __slots__ = ("index", "recorder")

    recorder: Recorder
    index: int

    def __new__(cls, recorder: Recorder, index: int) -> "RowNumber":
        """Return the label of a recorded value."""
        number = super().__new__(cls, _FLOAT_BITS.unpack(_INTEGER_BITS.pack(_LABEL + 1 + index))[0])
        number.recorder, number.index = recorder, index
        return number

    def __bool__(self) -> bool:
        return self.recorder.compare(operator.ne, (self, 0.0))

    def __pos__(self) -> "RowNumber":
        return self

    __add__, __radd__ = _operator(operator.add), _operator(operator.add, is_reflected=True)
    __sub__, __rsub__ = _operator(operator.sub), _operator(operator.sub, is_reflected=True)
    __mul__, __rmul__ = _operator(operator.mul), _operator(operator.mul, is_reflected=True)
    __truediv__, __rtruediv__ = _operator(operator.truediv), _operator(operator.truediv, is_reflected=True)
    __pow__, __rpow__ = _operator(operator.pow), _operator(operator.pow, is_reflected=True)
    __neg__, __abs__ = _operator(operator.neg), _operator(operator.abs)
    __lt__, __le__, __gt__, __ge__ = map(_comparison, (operator.lt, operator.le, operator.gt, operator.ge))
    __eq__, __ne__ = map(_comparison, (operator.eq, operator.ne))
    __hash__ = __str__ = __repr__ = __format__ = __int__ = __trunc__ = __floor__ = __ceil__ = __round__ = _refuse
    __mod__ = __rmod__ = __floordiv__ = __rfloordiv__ = __divmod__ = __rdivmod__ = __reduce_ex__ = _refuse
    is_integer = as_integer_ratio = hex = _refuse


def find_labels(words: IntArray) -> tuple[IntArray, IntArray]:
    """Return where labels are among the bits of numbers, and the recorded numbers that belong there.

    Parameters
    ----------
    words
        Bits of numbers; shape (n,).

    Returns
    -------
    places : IntArray
        Indices of the labels; shape (labels,).
    indices : IntArray
        Numbers of the recorded values; shape (labels,).
    """
    places = np.flatnonzero((words > _LABEL) & (words < _LABEL + (1 << 32)))
    return places, words[places] - _LABEL - 1


def is_number_or_label(values: FloatArray) -> BoolArray:
    """Return for each value (n,) whether it is a number or a label; neither is what arithmetic has made of a label."""
    words = values.view(np.int64)
    is_number: BoolArray = ~np.isnan(values) | ((words > _LABEL) & (words < _LABEL + (1 << 32)))
    return is_number


def elementary(function: Callable[..., float]) -> Callable[..., float]:
    """Return a function of the module `math` that is recorded where an argument is a `RowNumber`."""

    @wraps(function)
    def evaluate(*arguments: float) -> float:
        for argument in arguments:
            if isinstance(argument, RowNumber):
                return argument.recorder.record(function, arguments)
        return function(*arguments)

    return evaluate
