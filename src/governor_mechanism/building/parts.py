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
        self, name: str, *, length: Quantity, mass: Quantity, angle: Quantity | None = None, at: Sequence[Quantity] | None = None
    ) -> BuiltRod:
        """Add a slender uniform rod along the x axis of the body, with the points `start` and `end`.

        `length` is in m, `mass` in kg (0 for a massless lever), or both are texts with a unit. `angle` (rad or
        text) and the position `at` [x, y] of the start hold in the first configuration; left out, they follow from
        the joints.
        """
        return BuiltRod(name, *self._add_body("rod", name, mass, angle, at, rod={"length": length}))

    def disc(
        self,
        name: str,
        *,
        radius: Quantity,
        mass: Quantity,
        thickness: Quantity | None = None,
        angle: Quantity | None = None,
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a uniform disc in the plane with its origin at its centre.

        `radius` is in m, `mass` in kg, or texts with a unit; `thickness` matters in a turning plane alone. `angle`
        and the position `at` [x, y] of the origin hold in the first configuration; left out, they follow from the
        joints.
        """
        return BuiltBody(name, *self._add_body("disc", name, mass, angle, at, disc={"radius": radius, **given_values(thickness=thickness)}))

    def plate(
        self,
        name: str,
        *,
        width: Quantity,
        height: Quantity,
        mass: Quantity,
        thickness: Quantity | None = None,
        angle: Quantity | None = None,
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a uniform rectangular plate in the plane with its origin at its centre.

        `width` along x and `height` are in m, `mass` in kg, or texts with a unit; `thickness` matters in a turning
        plane alone. `angle` and the position `at` [x, y] of the origin hold in the first configuration; left out,
        they follow from the joints. A plate of another shape is a `body` or a `rod` with further points.
        """
        plate = {"width": width, "height": height, **given_values(thickness=thickness)}
        return BuiltBody(name, *self._add_body("plate", name, mass, angle, at, plate=plate))

    def body(
        self,
        name: str,
        *,
        mass: Quantity,
        inertia: Quantity | None = None,
        moments: Mapping[str, Quantity] | None = None,
        centre: Sequence[Quantity] | None = None,
        angle: Quantity | None = None,
        at: Sequence[Quantity] | None = None,
    ) -> BuiltBody:
        """Add a rigid body of any shape: `mass`, kg, and `inertia` about the mass centre, kg m2, or texts with a unit.

        In a turning plane `moments`, the second moments xx, yy, xy and zz, take the place of `inertia`. `centre` is
        the mass centre [x, y] in the axes of the body, or the origin. `angle` and the position `at` [x, y] of the
        origin hold in the first configuration; left out, they follow from the joints.
        """
        shape = given_values(inertia=inertia, moments=moments, centre=plain_list(centre))
        return BuiltBody(name, *self._add_body("body", name, mass, angle, at, **shape))

    def point_mass(self, name: str, *, mass: Quantity, at: Sequence[Quantity] | None = None) -> BuiltBody:
        """Add a mass in a point, kg or text; its position `at` [x, y] in the first configuration may follow from the joints."""
        return BuiltBody(name, *self._add_body("point_mass", name, mass, None, at, point=True))

    def block(self, name: str, *, mass: Quantity, at: Sequence[Quantity] | None = None) -> BuiltBody:
        """Add a body that never rotates, as a crosshead in its guide or a sleeve.

        `mass` is in kg or a text with a unit; the position `at` [x, y] in the first configuration may follow from
        the joints.
        """
        return BuiltBody(name, *self._add_body("block", name, mass, None, at, turns=False))

    def ground(self, x: Program, y: Program, name: str = "") -> BuiltPoint:
        """Add a point of the ground; raise MechanismError if there is a point of this name, or a coordinate is wrong.

        `x` and `y` are in m or texts with a unit, or motions, as [[time, value], ...]; without a name it is called
        A, B and so on.
        """
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
        self, kind: str, first: BuiltBody | BuiltPoint, second: BuiltBody | BuiltPoint, name: str = "", **keys: Program | None
    ) -> None:
        """Add a joint of any type that a scene file knows; further arguments are the keys of its table.

        It joins points of two bodies, or the bodies where the type takes these; without a name it is named after
        them.
        """
        self._checks.check_joint_type(kind)
        self._couple(kind, first, second, name, **{key: plain_list(value) for key, value in keys.items()})

    def pin(self, first: BuiltPoint, *others: BuiltPoint, name: str = "") -> None:
        """Join points of two or more bodies, so that they coincide: each further point is pinned to the first by a joint of its own.

        These are numbered in results from the second on, and named after their bodies without a name.
        """
        if not others:
            raise MechanismError("pin joins points of two or more bodies, as pin(crank.end, coupler.start); found one point")
        for number, second in enumerate(others, start=1):
            self._join("pin", first, second, f"{name} {number}" if name and number > 1 else name)

    def weld(self, first: BuiltPoint, second: BuiltPoint, turn: Quantity | None = None, name: str = "") -> None:
        """Fix two bodies to each other at two points.

        `turn` is the angle of the second minus that of the first, if it is not that of the given angles.
        """
        self._join("weld", first, second, name, turn=turn)

    def slider(self, first: BuiltPoint, second: BuiltPoint, angle: Quantity = 0.0, name: str = "") -> None:
        """Guide the second point on a straight line through the first.

        `angle` is that of the line in the axes of the first body, rad or text with a unit. The second body may
        rotate, as a block that is pinned in it: a slotted lever is `slider(lever.start, crank.end)`, with the slot
        along it, a guide on the ground `slider(ground(0, 0), ram.centre)`.
        """
        self._join("slider", first, second, name, angle=angle)

    def prismatic(self, first: BuiltPoint, second: BuiltPoint, angle: Quantity = 0.0, turn: Quantity | None = None, name: str = "") -> None:
        """Guide the second point on a straight line through the first, without rotation of one body against the other.

        `angle` is that of the line in the axes of the first body, `turn` that of the second body minus that of the
        first, if it is not that of the given ones; rad or text with a unit.
        """
        self._join("prismatic", first, second, name, angle=angle, turn=turn)

    def arc(self, centre: BuiltPoint, second: BuiltPoint, radius: Quantity, name: str = "") -> None:
        """Guide a point in a circular slot about a centre on the body that carries it, of a radius in m or a text with a unit."""
        self._join("arc", centre, second, name, radius=radius)

    def curve(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        *,
        coefficients: Sequence[Quantity] | None = None,
        points: Sequence[Sequence[Quantity]] | None = None,
        closed: Sequence[Sequence[Quantity]] | None = None,
        polar: Sequence[Sequence[Quantity]] | None = None,
        radius: Quantity | None = None,
        harmonics: Sequence[Mapping[str, Quantity]] | None = None,
        angle: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Guide the second point on a curve y(x) of the first body about the first point, or on a closed curve round it.

        One of these: `coefficients` of a polynomial, ascending, SI; `points` [x, y] of a spline; `closed`, points
        [x, y], or `polar`, points [angle, radius], of a closed spline; or a mean `radius` with `harmonics`, each
        {"amplitude": ..., "order": ..., "phase": ...}. `angle` is the direction of x, or of angle 0, in the axes of
        the first body.
        """
        lists = {"coefficients": coefficients, "points": points, "closed": closed, "polar": polar, "harmonics": harmonics}
        curve = given_values(radius=radius, **{key: plain_list(value) for key, value in lists.items()})
        self._join("curve", first, second, name, curve=curve, angle=angle)

    def link(self, first: BuiltPoint, second: BuiltPoint, length: Quantity | None = None, name: str = "") -> None:
        """Join two points by a massless bar of a length (m or text with a unit), or of their distance in the first configuration."""
        ends = {"first": point_reference("link", first), "second": point_reference("link", second)}
        self._add("link", "link", name, **ends, **given_values(length=length))

    def gear(
        self,
        first: BuiltBody | BuiltPoint,
        second: BuiltBody | BuiltPoint,
        ratio: float,
        offset: Quantity | None = None,
        name: str = "",
        carrier: BuiltBody | None = None,
    ) -> None:
        """Couple the angles of two bodies, as seen from the `carrier`, the body that carries both, or from the ground.

        `ratio` counts rotations of the second in one of the first; it is negative for external teeth. `offset` is
        the angle of the second at zero angle of the first, if it is not that of the first configuration. A point of
        a wheel is its centre.
        """
        carried = {} if carrier is None else {"carrier": body_reference("gear", carrier)}
        self._couple("gear", first, second, name, ratio=ratio, offset=offset, **carried)

    def rack(
        self, pinion: BuiltBody | BuiltPoint, rack: BuiltBody | BuiltPoint, radius: Quantity, angle: Quantity | None = None, name: str = ""
    ) -> None:
        """Couple the angle of a pinion and the displacement of a rack, or of a point of it.

        The pitch `radius` is in m or a text with a unit, negative for the opposite direction; `angle` is the
        direction of the rack, or x.
        """
        self._couple("rack", pinion, rack, name, radius=radius, angle=angle)

    def motor(
        self,
        body: BuiltBody | BuiltPoint,
        *,
        rate: Quantity | None = None,
        motion: Program | None = None,
        start: Quantity | None = None,
        against: BuiltBody | BuiltPoint | None = None,
        name: str = "",
    ) -> None:
        """Prescribe the rotation of a body against another one, or the ground.

        `rate` is a constant angular speed (rad/s or text, as "90 rpm"). In its place `motion` gives the angle over
        time: [[0, "0 deg"], [1, "90 deg"], ...], or {"start": "20 deg", "harmonics": [{"amplitude": "40 deg",
        "frequency": "0.5 Hz"}]} for a swing. `start` is the angle at 0 s, if it is not that of the first
        configuration.
        """
        self._couple("driven_turn", against, body, name, rate=rate, motion=plain_list(motion), start=start)

    def actuator(
        self,
        first: BuiltPoint,
        second: BuiltPoint,
        *,
        angle: Quantity = 0.0,
        rate: Quantity | None = None,
        motion: Program | None = None,
        start: Quantity | None = None,
        name: str = "",
    ) -> None:
        """Prescribe the displacement of the second point from the first, along an `angle` in the axes of the first body (rad or text).

        `rate` is a constant speed (m/s or text); in its place `motion` gives the displacement over time, as for
        `motor`. `start` is the displacement at 0 s, if it is not that of the first configuration.
        """
        self._join("driven_slide", first, second, name, angle=angle, rate=rate, motion=plain_list(motion), start=start)


class ForceBuilder(DocumentTables):
    """Methods that add springs, dampers, torques and forces."""

    def spring(
        self, first: BuiltPoint, second: BuiltPoint, *, stiffness: Quantity, free_length: Quantity | None = None, name: str = ""
    ) -> None:
        """Add a spring between two points: `stiffness`, N/m, and `free_length`, the length without force, m, or 0; or texts with a unit."""
        self._push("spring", first, second, name, stiffness=stiffness, free_length=free_length)

    def damper(self, first: BuiltPoint, second: BuiltPoint, *, damping: Quantity, name: str = "") -> None:
        """Add a linear damper between two points; `damping` is in N s/m or a text with a unit."""
        self._push("damper", first, second, name, damping=damping)

    def torsion_spring(
        self, body: BuiltBody, *, stiffness: Quantity, free_angle: Quantity | None = None, against: BuiltBody | None = None, name: str = ""
    ) -> None:
        """Add a torsion spring between a body and another one, or the ground.

        `stiffness` is in N m/rad, `free_angle`, the angle without torque, in rad, or 0; or texts with a unit.
        """
        ends = {"first": body_reference("torsion_spring", against), "second": body_reference("torsion_spring", body)}
        self._add(
            "force", "torsion_spring", name, type="torsion_spring", **ends, **given_values(stiffness=stiffness, free_angle=free_angle)
        )

    def torsion_damper(self, body: BuiltBody, *, damping: Quantity, against: BuiltBody | None = None, name: str = "") -> None:
        """Add a linear damper of the rotation of a body against another one, or the ground; `damping` is in N m s/rad."""
        ends = {"first": body_reference("torsion_damper", against), "second": body_reference("torsion_damper", body)}
        self._add("force", "torsion_damper", name, type="torsion_damper", **ends, damping=damping)

    def torque(self, body: BuiltBody, moment: Program, against: BuiltBody | None = None, name: str = "") -> None:
        """Add a torque on a body, N m or text with a unit; another body, or the ground, takes the opposite one.

        `moment` may be a table over time, [[time, value], ...], a formula with harmonics, or a function of a
        reading, as in scene files.
        """
        bodies = {
            "body": body_reference("torque", body),
            **given_values(against=None if against is None else body_reference("torque", against)),
        }
        self._add("force", "torque", name, type="torque", **bodies, moment=plain_list(moment))

    def force(self, point: BuiltPoint, *, x: Program | None = None, y: Program | None = None, name: str = "") -> None:
        """Add a force on a point: `x` and `y` along the axes of the plane, N or texts with a unit, or as a `moment` of `torque`."""
        self._add(
            "force", "force", name, type="force", point=point_reference("force", point), **given_values(x=plain_list(x), y=plain_list(y))
        )
