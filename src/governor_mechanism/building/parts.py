"""Springs, dampers and loads of a mechanism that is being built."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from governor_mechanism.building.handles import (
    BuiltBody,
    BuiltPoint,
    BuiltRod,
    DocumentTables,
    Program,
    Quantity,
    body_reference,
    check_name,
    given_values,
    plain_list,
    point_reference,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import GROUND


class BodyBuilder(DocumentTables):
    """Methods that add bodies and points of the ground."""

    def rod(
        self,
        name: str,
        *,
        length: Quantity,  # length, m or text with a unit
        mass: Quantity,  # mass, kg or text with a unit; 0 for a massless lever
        # angle in the first configuration, rad or text with a unit; None if it follows from the joints
        angle: Quantity | None = None,
        # position [x, y] of the start there; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltRod:
        """Add a slender uniform rod along the x axis of the body, with the points `start` and `end`."""
        return BuiltRod(name, *self._add_body("rod", name, mass, angle, at, rod={"length": length}))

    def disc(
        self,
        name: str,
        *,
        radius: Quantity,  # radius, m or text with a unit
        mass: Quantity,  # mass, kg or text with a unit
        # thickness, m or text with a unit; it matters in a turning plane alone
        thickness: Quantity | None = None,
        # angle in the first configuration, rad or text with a unit; None if it follows from the joints
        angle: Quantity | None = None,
        # position [x, y] of the origin there; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a uniform disc in the plane with its origin at its centre."""
        return BuiltBody(name, *self._add_body("disc", name, mass, angle, at, disc={"radius": radius, **given_values(thickness=thickness)}))

    def plate(
        self,
        name: str,
        *,
        width: Quantity,  # size along x, m or text with a unit
        height: Quantity,
        mass: Quantity,  # mass, kg or text with a unit
        # thickness, m or text with a unit; it matters in a turning plane alone
        thickness: Quantity | None = None,
        # angle in the first configuration, rad or text with a unit; None if it follows from the joints
        angle: Quantity | None = None,
        # position [x, y] of the origin there; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a uniform rectangular plate in the plane with its origin at its centre."""
        plate = {"width": width, "height": height, **given_values(thickness=thickness)}
        return BuiltBody(name, *self._add_body("plate", name, mass, angle, at, plate=plate))

    def body(
        self,
        name: str,
        *,
        mass: Quantity,  # mass, kg or text with a unit
        inertia: Quantity | None = None,  # moment of inertia about the mass centre, kg m2 or text with a unit
        # second moments xx, yy, xy and zz in place of `inertia`, as needed in a turning plane
        moments: Mapping[str, Quantity] | None = None,
        # position [x, y] of the mass centre in the axes of the body; None for the origin
        centre: Sequence[Quantity] | None = None,
        # angle in the first configuration, rad or text with a unit; None if it follows from the joints
        angle: Quantity | None = None,
        # position [x, y] of the origin there; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a rigid body of any shape."""
        shape = given_values(inertia=inertia, moments=moments, centre=plain_list(centre))
        return BuiltBody(name, *self._add_body("body", name, mass, angle, at, **shape))

    def point_mass(
        self,
        name: str,
        *,
        mass: Quantity,  # mass, kg or text with a unit
        # position [x, y] in the first configuration; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a mass in a point."""
        return BuiltBody(name, *self._add_body("point_mass", name, mass, None, at, point=True))

    def block(
        self,
        name: str,
        *,
        mass: Quantity,  # mass, kg or text with a unit
        # position [x, y] in the first configuration; None if it follows from the joints
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a body that never rotates, as a crosshead in its guide or a sleeve."""
        return BuiltBody(name, *self._add_body("block", name, mass, None, at, turns=False))

    def ground(
        self,
        x: Program,  # coordinate x, m or text with a unit; or a motion, as [[time, value], ...]
        y: Program,
        name: str = "",  # name of the point; "A", "B" and so on if empty
    ) -> BuiltPoint:
        """Add a point of the ground; raise MechanismError if there is a point of this name, or a coordinate is wrong."""
        points = self._tables.setdefault(GROUND, {})
        if isinstance(name, str) and not name:
            name = next(letter for letter in _letters() if letter not in points)
        check_name("a point of the ground", name)
        if name in points:
            raise MechanismError(f"the ground already has a point {name!r}; choose another name")
        position = [plain_list(x), plain_list(y)]
        self._checks.check_ground(name, position)
        points[name] = position
        return BuiltPoint(GROUND, f"{GROUND}.{name}")


def _letters() -> Sequence[str]:
    """Return names of points: A to Z, and then A2 and so on."""
    letters = [chr(code) for code in range(ord("A"), ord("Z") + 1)]
    return [*letters, *(f"{letter}{number}" for number in range(2, 1000) for letter in letters)]


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
        """Add a joint of any type that a scene file knows; further arguments are the keys of its table."""
        self._checks.check_joint_type(kind)
        self._couple(kind, first, second, name, **{key: plain_list(value) for key, value in keys.items()})

    def pin(
        self,
        first: BuiltPoint,
        *others: BuiltPoint,
        # name of the joint in results, numbered from the second on; made of its bodies if empty
        name: str = "",
    ) -> None:
        """Join points of two or more bodies, so that they coincide: each further point is pinned to the first by a joint of its own."""
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
        # points [x, y] of a closed spline about the first point, in place of the others
        closed: Sequence[Sequence[Quantity]] | None = None,
        # points [angle, radius] of a closed spline, in place of the others
        polar: Sequence[Sequence[Quantity]] | None = None,
        radius: Quantity | None = None,  # mean radius of a closed curve of harmonics, in place of the others
        # of the radius, each { "amplitude": ..., "order": ..., "phase": ... }
        harmonics: Sequence[Mapping[str, Quantity]] | None = None,
        angle: Quantity | None = None,  # direction of x, or of angle 0, in the axes of the first body; None for 0
        name: str = "",
    ) -> None:
        """Guide the second point on a curve y(x) of the first body, or on a closed curve about the first point."""
        lists = {"coefficients": coefficients, "points": points, "closed": closed, "polar": polar, "harmonics": harmonics}
        curve = given_values(radius=radius, **{key: plain_list(value) for key, value in lists.items()})
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
        carrier: BuiltBody | None = None,  # the body that carries both wheels, from which the angles count; None for the ground
    ) -> None:
        """Couple the angles of two bodies, as seen from the body that carries them."""
        carried = {} if carrier is None else {"carrier": body_reference("gear", carrier)}
        self._couple("gear", first, second, name, ratio=ratio, offset=offset, **carried)

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
