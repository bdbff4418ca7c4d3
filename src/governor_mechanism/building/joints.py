"""Joints and drivers of a mechanism that is being built."""

from __future__ import annotations

from collections.abc import Sequence

from governor_mechanism.building.handles import BuiltBody, BuiltPoint, Program, Quantity, point_reference
from governor_mechanism.building.tables import DocumentTables, given_values, plain_list
from governor_mechanism.errors import MechanismError


class JointBuilder(DocumentTables):
    """Methods that add joints, links and drivers."""

    def joint(
        self,
        kind: str,
        first: BuiltBody | BuiltPoint,  # a point of the first body, or the body where the type takes bodies
        second: BuiltBody | BuiltPoint,
        name: str = "",  # name of the joint in results; made of its bodies if empty
        **keys: Program | None,
    ) -> None:
        """Add a joint of any type that a scene file knows; further arguments are the keys of its table.

        Raises MechanismError if the type is unknown, or a key is wrong.
        """
        self._checks.check_joint_type(kind)
        self._couple(kind, first, second, name, **{key: plain_list(value) for key, value in keys.items()})

    def pin(
        self,
        first: BuiltPoint,
        *others: BuiltPoint,
        # name of the joint in results, numbered from the second on; made of its bodies if empty
        name: str = "",
    ) -> None:
        """Join points of two or more bodies, so that they coincide: each further point is pinned to the first by a joint of its own.

        Raises MechanismError if there is no second point.
        """
        if not others:
            raise MechanismError("pin joins points of two or more bodies, as pin(crank.end, coupler.start); found one point")
        for number, second in enumerate(others, start=1):
            self._join("pin", first, second, f"{name} {number}" if name and number > 1 else name)

    def weld(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        # angle of the second body minus that of the first; None for that of the angles given, or 0
        turn: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Fix two bodies to each other at two points."""
        self._join("weld", first, second, name, turn=turn)

    def slider(
        self,
        first: BuiltPoint,  # a point of the line, on the body that carries it
        second: BuiltPoint,
        angle: Quantity = 0.0,  # direction of the line in the axes of the first body, rad or text with a unit
        name: str = "",
    ) -> None:
        """Guide the second point on a straight line through the first."""
        self._join("slider", first, second, name, angle=angle)

    def prismatic(
        self,
        first: BuiltPoint,  # a point of the line, on the body that carries it
        second: BuiltPoint,
        angle: Quantity = 0.0,  # direction of the line in the axes of the first body, rad or text with a unit
        # angle of the second body minus that of the first; None for that of the angles given, or 0
        turn: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Guide the second point on a straight line through the first, without rotation of one body against the other."""
        self._join("prismatic", first, second, name, angle=angle, turn=turn)

    def arc(
        self,
        centre: BuiltPoint,  # centre of the slot, on the body that carries it
        second: BuiltPoint,
        radius: Quantity,  # radius, m or text with a unit
        name: str = "",
    ) -> None:
        """Guide a point in a circular slot."""
        self._join("arc", centre, second, name, radius=radius)

    def curve(
        self,
        first: BuiltPoint,  # origin of x and y, on the body that carries the curve
        second: BuiltPoint,
        *,
        # coefficients of a polynomial, in ascending order, SI
        coefficients: Sequence[Quantity] | None = None,
        # points [x, y] of a spline, in place of the coefficients
        points: Sequence[Sequence[Quantity]] | None = None,
        angle: Quantity | None = None,  # direction of x in the axes of the first body; None for 0
        name: str = "",
    ) -> None:
        """Guide the second point on a curve y(x) of the first body."""
        curve = given_values(coefficients=plain_list(coefficients), points=plain_list(points))
        self._join("curve", first, second, name, curve=curve, angle=angle)

    def link(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        # length, m or text with a unit; None for the distance of the points in the first configuration
        length: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Join two points by a massless bar."""
        ends = {"first": point_reference("link", first), "second": point_reference("link", second)}
        self._add("link", "link", name, **ends, **given_values(length=length))

    def gear(
        self,
        first: BuiltBody | BuiltPoint,  # a wheel, or the point of it that is its centre
        second: BuiltBody | BuiltPoint,
        ratio: float,  # rotation of the second body per rotation of the first; negative for external teeth
        # angle of the second body at zero angle of the first; None for that of the first configuration
        offset: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Couple the angles of two bodies."""
        self._couple("gear", first, second, name, ratio=ratio, offset=offset)

    def rack(
        self,
        pinion: BuiltBody | BuiltPoint,
        rack: BuiltBody | BuiltPoint,  # the body that is displaced, or a point of it
        radius: Quantity,  # pitch radius, m or text with a unit; negative for the opposite direction
        angle: Quantity | None = None,  # direction of the rack, rad or text with a unit; None for x
        name: str = "",
    ) -> None:
        """Couple the angle of a pinion and the displacement of a rack."""
        self._couple("rack", pinion, rack, name, radius=radius, angle=angle)

    def motor(
        self,
        body: BuiltBody | BuiltPoint,
        *,
        rate: Quantity | None = None,  # constant angular speed, rad/s or text with a unit
        motion: Program | None = None,  # angle over time in place of `rate`, as [[0, "0 deg"], [1, "90 deg"]]
        start: Quantity | None = None,  # angle at 0 s; None for that of the first configuration
        against: BuiltBody | BuiltPoint | None = None,  # the body against which it turns; None for the ground
        name: str = "",
    ) -> None:
        """Prescribe the rotation of a body."""
        self._couple("driven_turn", against, body, name, rate=rate, motion=plain_list(motion), start=start)

    def actuator(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        *,
        angle: Quantity = 0.0,  # direction in the axes of the first body, rad or text with a unit
        rate: Quantity | None = None,  # constant speed, m/s or text with a unit
        # displacement over time in place of `rate`, as [[0, "0 mm"], [1, "50 mm"]]
        motion: Program | None = None,
        start: Quantity | None = None,  # displacement at 0 s; None for that of the first configuration
        name: str = "",
    ) -> None:
        """Prescribe the displacement of a point along a direction."""
        self._join("driven_slide", first, second, name, angle=angle, rate=rate, motion=plain_list(motion), start=start)
