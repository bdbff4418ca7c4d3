"""Springs, dampers and loads of a mechanism that is being built."""

from __future__ import annotations

from governor_mechanism.building.handles import BuiltBody, BuiltPoint, Program, Quantity, body_reference, point_reference
from governor_mechanism.building.tables import DocumentTables, given_values, plain_list


class ForceBuilder(DocumentTables):
    """Methods that add springs, dampers, torques and forces."""

    def spring(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        *,
        stiffness: Quantity,  # stiffness, N/m or text with a unit
        free_length: Quantity | None = None,  # length without force, m or text with a unit; None for 0
        name: str = "",
    ) -> None:
        """Add a spring between two points."""
        self._push("spring", first, second, name, stiffness=stiffness, free_length=free_length)

    def damper(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        *,
        damping: Quantity,  # damping, N s/m or text with a unit
        name: str = "",
    ) -> None:
        """Add a linear damper between two points."""
        self._push("damper", first, second, name, damping=damping)

    def torsion_spring(
        self,
        body: BuiltBody,
        *,
        stiffness: Quantity,  # stiffness, N m/rad or text with a unit
        free_angle: Quantity | None = None,  # angle without torque, rad or text with a unit; None for 0
        against: BuiltBody | None = None,  # the other body; None for the ground
        name: str = "",
    ) -> None:
        """Add a torsion spring."""
        ends = {"first": body_reference("torsion_spring", against), "second": body_reference("torsion_spring", body)}
        self._add(
            "force", "torsion_spring", name, type="torsion_spring", **ends, **given_values(stiffness=stiffness, free_angle=free_angle)
        )

    def torsion_damper(
        self,
        body: BuiltBody,
        *,
        damping: Quantity,  # damping, N m s/rad or text with a unit
        against: BuiltBody | None = None,  # the other body; None for the ground
        name: str = "",
    ) -> None:
        """Add a linear damper of a rotation."""
        ends = {"first": body_reference("torsion_damper", against), "second": body_reference("torsion_damper", body)}
        self._add("force", "torsion_damper", name, type="torsion_damper", **ends, damping=damping)

    def torque(
        self,
        body: BuiltBody,
        # torque, N m or text with a unit; over time, or as a function of a reading, as in scene files
        moment: Program,
        against: BuiltBody | None = None,  # the body that takes the opposite torque; None for the ground
        name: str = "",
    ) -> None:
        """Add a torque on a body."""
        bodies = {
            "body": body_reference("torque", body),
            **given_values(against=None if against is None else body_reference("torque", against)),
        }
        self._add("force", "torque", name, type="torque", **bodies, moment=plain_list(moment))

    def force(
        self,
        point: BuiltPoint,
        *,
        # component along x, N or text with a unit; over time, or as a function of a reading, as in scene
        # files
        x: Program | None = None,
        y: Program | None = None,
        name: str = "",
    ) -> None:
        """Add a force on a point, along the axes of the plane."""
        self._add(
            "force", "force", name, type="force", point=point_reference("force", point), **given_values(x=plain_list(x), y=plain_list(y))
        )
