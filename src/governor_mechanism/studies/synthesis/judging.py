"""Defects of many linkages at once, by signs of angles between their links; those that are kept are run (`check_linkage`).

The joints at the ends of the shortest link of a Grashof linkage turn fully; the angles at the other two never pass a straight line, so
that their signs tell its two circuits apart.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from governor_mechanism.types import BoolArray, ComplexArray, FloatArray, IntArray

DEFECTS: Final = ("none", "order", "branch", "circuit")
"""Defects, by their codes."""


class Judgement(NamedTuple):
    """What holds of linkages; shape (n,)."""

    defect: IntArray  # code of the gravest defect
    turns_fully: BoolArray  # whether the input does
    transmission: FloatArray  # least absolute sine of the transmission angle at the positions


def judge(fixed: ComplexArray, moving: ComplexArray) -> Judgement:
    """Return the defects of linkages, whose first link drives, with fixed pivots (n, 2) and moving ones (n, positions, 2)."""
    ground = (fixed[:, 1] - fixed[:, 0])[:, None]
    crank = (moving[:, :, 0] - fixed[:, :1]) / ground  # in the axes of the ground
    link = moving[:, :, 1] - fixed[:, 1:]
    coupler = moving[:, :, 1] - moving[:, :, 0]
    lengths = np.abs(np.stack([ground, moving[:, :1, 0] - fixed[:, :1], coupler[:, :1], link[:, :1]]))[:, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = np.imag(coupler * np.conj(link)) / np.abs(coupler * link)
    is_grashof = 2.0 * (lengths.min(axis=0) + lengths.max(axis=0)) < lengths.sum(axis=0)
    turns_fully = is_grashof & (lengths[:2].min(axis=0) < lengths[2:].min(axis=0))
    side = np.sign(crank.imag)
    changes_circuit = is_grashof & ~_is_constant(np.where(turns_fully[:, None], np.sign(sine), side))
    d, a, b, c = lengths
    has_zero = (np.abs(b - c) < np.abs(d - a)) & (np.abs(d - a) < b + c)  # whether the input of a triple rocker passes the ground
    middle = np.where(is_grashof, 0.5 * math.pi * side[:, 0], np.where(has_zero, 0.0, math.pi))[:, None]
    steps = np.diff(np.where(turns_fully[:, None], np.angle(crank), np.angle(crank * np.exp(-1j * middle))), axis=1)
    cyclic = np.minimum((steps % math.tau).sum(axis=1), (-steps % math.tau).sum(axis=1)) < math.tau
    in_order = np.where(turns_fully, cyclic, _is_constant(np.sign(steps)))
    defect = np.select([changes_circuit, ~_is_constant(np.sign(sine)), ~in_order], [3, 2, 1], 0)
    return Judgement(defect, turns_fully, np.abs(sine).min(axis=1))


def _is_constant(signs: FloatArray) -> BoolArray:
    constant: BoolArray = np.abs(signs.sum(axis=1)) == signs.shape[1]
    return constant
