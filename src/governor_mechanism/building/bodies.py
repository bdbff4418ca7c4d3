"""Bodies of a mechanism that is being built, and points of the ground."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from governor_mechanism.building.call_checks import check_name
from governor_mechanism.building.handles import BuiltBody, BuiltPoint, BuiltRod, Program, Quantity
from governor_mechanism.building.tables import DocumentTables, given_values, plain_list
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
        """Add a point of the ground.

        Raises MechanismError if there is a point of this name, or a coordinate is wrong.
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
