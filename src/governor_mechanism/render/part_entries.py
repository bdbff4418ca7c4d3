"""What belongs to one part of a run: its bodies, and entries by name."""

from collections.abc import Mapping
from typing import TypeVar

from governor_mechanism.model.part import Part
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray

T = TypeVar("T")


def part_prefix(run: Trajectory, part: Part) -> str:
    """Return the start of the names of a part: empty for the only part, or "part."."""
    return f"{part.name}." if len(run.scene.parts) > 1 else ""


def select_part_entries(run: Trajectory, part: Part, entries: Mapping[str, T]) -> dict[str, T]:
    """Return the entries of one part from a mapping by name, by plain names."""
    prefix = part_prefix(run, part)
    return {name.removeprefix(prefix): value for name, value in entries.items() if name.startswith(prefix)}


def part_poses_and_velocities(run: Trajectory, part: Part) -> tuple[FloatArray, FloatArray]:
    """Return poses and velocities (n, bodies, 3) of the bodies of one part, without the shaft of its spindle."""
    prefix = part_prefix(run, part)
    columns = [run.scene.mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies]
    return run.poses[:, columns, :], run.velocities[:, columns, :]
