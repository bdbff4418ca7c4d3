"""The list of all ways in which the joints of a mechanism close."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from governor_mechanism.building.first_configuration import list_assemblies
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.block_equations import CLOSED_FORM
from governor_mechanism.observables.closed_configurations import (
    SAME_TOLERANCE,
    ClosedConfigurations,
    enumerate_configurations,
    largest_difference,
)
from governor_mechanism.observables.linkage import DriveTravel
from governor_mechanism.scenes.custom.parser import explain_no_assembly, hold_given_values, written_angles
from governor_mechanism.studies.kinematics import find_driven_angle
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value, parse_quantity
from governor_mechanism.units.text_table import short_repr

if TYPE_CHECKING:
    from governor_mechanism.building.mechanism_builder import MechanismBuilder


POSE_UNITS: Final = {"x": "m", "y": "m", "angle": "rad"}
"""Units of the numbers of a pose."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Assembly:
    """A way in which the joints close: its number from 1, poses of the bodies (m, rad), and how far the drive goes in words, if known."""

    number: int
    poses: dict[str, FloatArray]
    drive: str | None
    is_taken: bool

    @property
    def label(self) -> str:
        """Its number, with a star if the scene starts in it."""
        return f"{self.number}{' *' if self.is_taken else ''}"


def _within_half_a_turn(angles: FloatArray) -> FloatArray:
    """Return angles (rad) less their whole turns."""
    wrapped: FloatArray = np.remainder(angles + math.pi, math.tau) - math.pi
    return wrapped


def _pose_column(body: str, axis: str) -> Column:
    """Return the column of a number of the pose of a body, which JSON has with the others."""
    k = [*POSE_UNITS].index(axis)
    return Column(f"{body}.{axis}", value=lambda row: row.poses[body][k], unit=POSE_UNITS[axis], in_json=False)


def _angle_column(body: str) -> Column:
    """Return the column of the angle of a body within half a turn, which the text alone has."""
    return Column("", f"{body}, deg", lambda row: f"{np.degrees(_within_half_a_turn(row.poses[body][2])):.3f}", side="r")


@dataclass(frozen=True, kw_only=True, eq=False)
class Assemblies(Result):
    """All ways in which the joints of a mechanism close at given drives, numbered from 1.

    The order does not depend on the initial guess: it is that of the senses in which the loops close, and then of the angles.

    Attributes
    ----------
    scene
        The scene.
    poses
        Poses (x, y, angle) of the mass centres in each assembly, m and rad; shape (n, bodies, 3).
    methods
        How they were found, as "closed form", "homotopy of 6 paths" or "many starts".
    complete
        Whether there are certainly no others.
    taken
        Number of the assembly in which the scene starts; None if it starts in none of them.
    held_by
        What holds the mechanism beside its drives, in words.
    """

    scene: Scene
    poses: FloatArray
    methods: tuple[str, ...]
    complete: bool
    taken: int | None
    held_by: tuple[str, ...] = ()

    figure = "render.figures.kinematics.assemblies_figure"
    record = ("title=scene.title", "count", "complete", "methods", "held_by", "taken", "assemblies=rows")

    __repr__ = short_repr

    def __len__(self) -> int:
        """Return the number of assemblies."""
        return len(self.poses)

    @property
    def count(self) -> int:
        """Number of assemblies."""
        return len(self)

    @cached_property
    def rows(self) -> tuple[Assembly, ...]:
        """The assemblies in their order."""
        names = [body.name for body in self.scene.part.mechanism.bodies]
        return tuple(
            Assembly(number=k, poses=dict(zip(names, poses, strict=True)), drive=travel or None, is_taken=k == self.taken)
            for k, (poses, travel) in enumerate(zip(self.poses, self.travels, strict=True), start=1)
        )

    @property
    def columns(self) -> tuple[Column, ...]:
        """Number of the assembly and poses of the bodies, m and rad; in the text their angles, deg, and how far the drive goes."""
        bodies = self.scene.part.mechanism.bodies
        poses = (_pose_column(body.name, axis) for body in bodies for axis in POSE_UNITS)
        angles = map(_angle_column, self.angles)
        drive = Column("drive", "drive" if any(self.travels) else None, "{drive}", side="r", in_table=False)
        return Column("number", "number", "{label}"), Column("poses", in_table=False), *poses, *angles, drive

    @property
    def angles(self) -> dict[str, FloatArray]:
        """Angles of the bodies that rotate by name, rad, within half a turn; shape (n,)."""
        bodies = self.scene.part.mechanism.bodies
        wrapped = _within_half_a_turn(self.poses[..., 2])
        return {body.name: wrapped[:, k] for k, body in enumerate(bodies) if body.can_rotate}

    @cached_property
    def travels(self) -> tuple[str, ...]:
        """How far a motor turns in each assembly, in words; empty where it does not determine the motion, or turns nothing."""
        mechanism = self.scene.part.mechanism
        over = find_driven_angle(mechanism)
        found = []
        for poses in self.poses:
            words = ""
            with suppress(MechanismError):
                words = DriveTravel(mechanism, over, poses).words if over else ""
            found.append(words)
        return tuple(found)

    def nearest(self, angles: Mapping[str, float | str]) -> int:
        """Return the number of the assembly that is nearest to some angles.

        Parameters
        ----------
        angles
            Angles by body, rad or text with a unit, as {"rocker": "80 deg"}.

        Returns
        -------
        int
            The number, from 1.

        Raises
        ------
        MechanismError
            If there is no such body, or a value is no angle.
        """
        if not isinstance(angles, Mapping) or not angles:
            raise MechanismError(f'nearest takes angles by body, as {{"rocker": "80 deg"}}; found {format_value(angles)}')
        known, deviations = self.angles, np.zeros(len(self))
        for name, angle in angles.items():
            if name not in known:
                raise MechanismError(f"no body {format_value(name)} rotates here; those that do are {', '.join(known)}")
            difference = known[name] - parse_quantity(angle, "angle", f"angle of {name}")
            deviations += _within_half_a_turn(difference) ** 2
        return int(np.argmin(deviations)) + 1

    def __str__(self) -> str:
        """Return the count, how it was found, and a table of the angles, deg, and of how far the drive goes."""
        footer = [f"* is the one in which {self.scene.source or 'the scene'} starts"] if self.taken else []
        return "\n".join([self.summary, format_columns(self.columns, self.rows), *footer])

    @property
    def summary(self) -> str:
        """Their number in a sentence, with what holds the mechanism and whether there may be more."""
        ways = "one way" if len(self) == 1 else f"{len(self)} ways"
        where = f" with {' and '.join(self.held_by)}" if self.held_by else ""
        how = " and ".join("in closed form" if method == CLOSED_FORM else f"by {method}" for method in self.methods)
        are_all = f"these are all, found {how}" if how else "these are all"
        verdict = are_all if self.complete else "there may be more, which no start reached"
        return f"{self.scene.title}: the joints close in {ways}{where}; {verdict}"


def list_scene_assemblies(scene: Scene) -> Assemblies:
    """Return all assemblies of the only part of a scene, at its drives, start values and given angles."""
    mechanism, document = scene.part.mechanism, scene.document
    written = document.get("assembly")
    at = tuple(written.get("at", ())) if isinstance(written, Mapping) else ()
    held, held_by = hold_given_values(mechanism, scene.start, written_angles(document, mechanism), at)
    return _as_assemblies(scene, enumerate_configurations(PositionSolver(held)), held_by)


def list_builder_assemblies(builder: MechanismBuilder) -> Assemblies:
    """Return all assemblies of a mechanism that is composed in Python, at its given angles."""
    configurations, held_by = list_assemblies(builder.given_document)
    return _as_assemblies(builder.scene(), configurations, held_by)


def _as_assemblies(scene: Scene, configurations: ClosedConfigurations, held_by: list[str]) -> Assemblies:
    solver = configurations.solver
    if not len(configurations.poses):
        explain_no_assembly(solver)
    start = np.array(scene.part.mechanism.initial_guess)
    with suppress(MechanismError):  # a guess that does not close leads to none
        start = solver.solve({}, start)
    differences = [largest_difference(solver, poses, start, configurations.closing.tolist()) for poses in configurations.poses]
    nearest = int(np.argmin(differences))
    return Assemblies(
        scene=scene,
        poses=configurations.poses,
        methods=configurations.methods,
        complete=configurations.complete,
        taken=nearest + 1 if differences[nearest] < SAME_TOLERANCE else None,
        held_by=tuple(held_by),
    )
