"""Springs, dampers and loads of a mechanism that is being built."""

from __future__ import annotations

from governor_mechanism.building.handles import BuiltBody, BuiltPoint, Program, Quantity, body_reference, point_reference
from governor_mechanism.building.tables import DocumentTables, given_values, plain_list


class ForceBuilder(DocumentTables):
    """Methods that add springs, dampers, torques and forces."""

    def spring(
        self, first: BuiltPoint, second: BuiltPoint, *, stiffness: Quantity, free_length: Quantity | None = None, name: str = ""
    ) -> None:
        """Add a spring between two points.

        Parameters
        ----------
        first
            One end.
        second
            The other end, on another body.
        stiffness
            Stiffness, N/m or text with a unit.
        free_length
            Length without force, m or text with a unit; None for 0.
        name
            Name of the spring.
        """
        self._push("spring", first, second, name, stiffness=stiffness, free_length=free_length)

    def damper(self, first: BuiltPoint, second: BuiltPoint, *, damping: Quantity, name: str = "") -> None:
        """Add a linear damper between two points.

        Parameters
        ----------
        first
            One end.
        second
            The other end, on another body.
        damping
            Damping, N s/m or text with a unit.
        name
            Name of the damper.
        """
        self._push("damper", first, second, name, damping=damping)

    def torsion_spring(
        self, body: BuiltBody, *, stiffness: Quantity, free_angle: Quantity | None = None, against: BuiltBody | None = None, name: str = ""
    ) -> None:
        """Add a torsion spring.

        Parameters
        ----------
        body
            The body on which it acts.
        stiffness
            Stiffness, N m/rad or text with a unit.
        free_angle
            Angle without torque, rad or text with a unit; None for 0.
        against
            The other body; None for the ground.
        name
            Name of the spring.
        """
        ends = {"first": body_reference("torsion_spring", against), "second": body_reference("torsion_spring", body)}
        self._add(
            "force", "torsion_spring", name, type="torsion_spring", **ends, **given_values(stiffness=stiffness, free_angle=free_angle)
        )

    def torsion_damper(self, body: BuiltBody, *, damping: Quantity, against: BuiltBody | None = None, name: str = "") -> None:
        """Add a linear damper of a rotation.

        Parameters
        ----------
        body
            The body on which it acts.
        damping
            Damping, N m s/rad or text with a unit.
        against
            The other body; None for the ground.
        name
            Name of the damper.
        """
        ends = {"first": body_reference("torsion_damper", against), "second": body_reference("torsion_damper", body)}
        self._add("force", "torsion_damper", name, type="torsion_damper", **ends, damping=damping)

    def torque(self, body: BuiltBody, moment: Program, against: BuiltBody | None = None, name: str = "") -> None:
        """Add a torque on a body.

        Parameters
        ----------
        body
            The body on which it acts.
        moment
            Torque, N m or text with a unit; over time, or as a function of a reading, as in scene files.
        against
            The body that takes the opposite torque; None for the ground.
        name
            Name of the torque.
        """
        bodies = {
            "body": body_reference("torque", body),
            **given_values(against=None if against is None else body_reference("torque", against)),
        }
        self._add("force", "torque", name, type="torque", **bodies, moment=plain_list(moment))

    def force(self, point: BuiltPoint, *, x: Program | None = None, y: Program | None = None, name: str = "") -> None:
        """Add a force on a point, along the axes of the plane.

        Parameters
        ----------
        point
            The point at which it acts.
        x
            Component along x, N or text with a unit; over time, or as a function of a reading, as in scene files.
        y
            Component along y.
        name
            Name of the force.
        """
        self._add(
            "force", "force", name, type="force", point=point_reference("force", point), **given_values(x=plain_list(x), y=plain_list(y))
        )
