"""Builder of a mechanism of the user's own in Python; see `MechanismBuilder`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from governor_mechanism.building.first_configuration import place_bodies
from governor_mechanism.building.handles import (
    BuiltBody,
    BuiltPoint,
    Program,
    Quantity,
    body_or_point_reference,
    body_reference,
    given_values,
    name_of,
    point_reference,
)
from governor_mechanism.building.parts import BodyBuilder, ForceBuilder, JointBuilder
from governor_mechanism.errors import MechanismError
from governor_mechanism.later_module import LaterModule
from governor_mechanism.model.scene import Scene
from governor_mechanism.units.quantities import format_value

if TYPE_CHECKING:
    from governor_mechanism.studies import assemblies
else:
    assemblies = LaterModule("studies.assemblies")


class MechanismBuilder(BodyBuilder, JointBuilder, ForceBuilder):
    """A mechanism that is composed of bodies, joints and forces, and becomes a scene.

    Each method adds one table to the document that a scene file with `machine = "custom"` would hold, so that checks and messages are the
    same. Quantities are numbers in SI or texts with a unit; angles are anticlockwise from x, and y is up. Bodies need no positions: a
    first configuration in which the joints close is found from the angles that are given.

    Parameters
    ----------
    title
        Title of the scene.
    plane
        "fixed", or "turning" for a mechanism that turns with a spindle.
    size
        Characteristic length, to which accuracies are relative, m or text with a unit; None for the longest distance on a body.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> m = gm.Mechanism.build("Pendulum")
    >>> rod = m.rod("rod", length="1 m", mass=2.0, angle="-60 deg")
    >>> m.pin(m.ground(0, 0), rod.start)
    >>> m.gravity()
    >>> m.scene(duration="2 s").mechanism.bodies[0].mass
    2.0
    """

    def reading(
        self,
        name: str,
        *,
        angle: BuiltBody | None = None,
        against: BuiltBody | None = None,
        line: tuple[BuiltPoint, BuiltPoint] | None = None,
        distance: tuple[BuiltPoint, BuiltPoint] | None = None,
        x: BuiltPoint | None = None,
        y: BuiltPoint | None = None,
        origin: BuiltPoint | None = None,
    ) -> None:
        """Name what is read off the mechanism; without any, the angle or the position of each body is.

        Parameters
        ----------
        name
            Name of the reading.
        angle
            The body whose angle it is.
        against
            The body against which the angle is measured; None for the ground.
        line
            Two points: the angle of the line from the first to the second.
        distance
            Two points: their distance.
        x
            The point whose coordinate x it is.
        y
            The point whose coordinate y it is.
        origin
            The point from which the coordinate is measured; None for the origin of the plane.

        Raises
        ------
        MechanismError
            If there is a reading of this name, or a body or point is none.
        """
        _require_text("name", name)
        what = f"reading {name!r}"
        readings = self._tables.setdefault("readings", {})
        if name in readings:
            raise MechanismError(f"there already is a {what}; choose another name")
        pairs = {key: _pair_references(what, pair) for key, pair in given_values(line=line, distance=distance).items()}
        points = {key: point_reference(what, point) for key, point in given_values(x=x, y=y, **{"from": origin}).items()}
        bodies = {key: body_reference(what, body) for key, body in given_values(angle=angle, against=against).items()}
        table = bodies | pairs | points
        self._checks.check_reading(name, table)
        readings[name] = table

    def contact(
        self,
        first: BuiltPoint | BuiltBody,
        body: BuiltBody,
        *,
        radius: Quantity | None = None,
        restitution: float | None = None,
        friction: float | None = None,
        name: str = "",
    ) -> None:
        """Let a roller, a point or an outline touch the outline of another body; it may leave it and strike it again.

        Parameters
        ----------
        first
            Centre of the roller, or a body whose own outline touches.
        body
            The body with an outline.
        radius
            Radius of the roller, m or text with a unit; None for a point.
        restitution
            Coefficient of restitution, 0 to 1; None for 0.
        friction
            Coefficient of Coulomb friction; None for 0.
        name
            Name; the gap is the reading NAME_gap. Made of both bodies if empty.

        Raises
        ------
        MechanismError
            If the body has no outline, the roller cannot follow it, or a value is wrong.
        """
        label = f"contact {name!r}" if isinstance(name, str) and name else "contact"
        ends = {"first": body_or_point_reference(label, first), "second": body_reference(label, body)}
        table = {**name_of(name), **ends, **given_values(radius=radius, restitution=restitution, friction=friction)}
        self._checks.check_contact(label, table)
        self._lists.setdefault("contact", []).append(table)

    def gravity(self, value: bool | Quantity = True) -> None:
        """Let gravity act along -y.

        Parameters
        ----------
        value
            True for 9.81 m/s2, or another acceleration.
        """
        self.effect("gravity", value)

    def effect(self, key: str, value: bool | Program = True) -> None:
        """List an effect, as in the table [effects] of a scene file.

        Parameters
        ----------
        key
            Key of the effect, as "dry_friction" or "centrifugal".
        value
            Its value or table, as {"rocker_angle": "2 N m"}.

        Raises
        ------
        MechanismError
            If the key is no text.
        """
        _require_text("key", key)
        self._tables.setdefault("effects", {})[key] = value

    def spindle(
        self,
        speed: Program | None = None,
        *,
        inertia: Quantity | None = None,
        start_speed: Quantity | None = None,
        torque: Program | None = None,
    ) -> None:
        """Describe the spindle of a turning plane: its speed is given, or it is free.

        Parameters
        ----------
        speed
            Given speed, rad/s or text with a unit, or [[time, speed], ...].
        inertia
            Moment of inertia of a free spindle.
        start_speed
            Speed at which a free spindle starts.
        torque
            Torque on a free spindle.
        """
        self._tables["spindle"] = given_values(speed=speed, inertia=inertia, start_speed=start_speed, torque=torque)

    def start(self, values: Mapping[str, Quantity]) -> None:
        """Give start values of readings and their rates, as in the table [start] of a scene file.

        Parameters
        ----------
        values
            Values by key, as {"rocker_angle": "30 deg", "rocker_rate": 0.0}.

        Raises
        ------
        MechanismError
            If it is no mapping.
        """
        if not isinstance(values, Mapping):
            raise MechanismError(f'start takes values by reading, as {{"rocker_angle": "30 deg"}}; found {format_value(values)}')
        self._tables.setdefault("start", {}).update(values)

    def event(self, name: str, reading: str, value: Quantity, direction: str | None = None) -> None:
        """Name a crossing of a reading, which the events of a run list.

        Parameters
        ----------
        name
            Name of the crossing.
        reading
            Name of the reading.
        value
            Value that it passes, SI or text with a unit.
        direction
            "up" or "down"; None for both.

        Raises
        ------
        MechanismError
            If the name or the reading is no text, or the direction is another.
        """
        for argument, text in (("name", name), ("reading", reading)):
            _require_text(argument, text)
        if direction not in (None, "up", "down"):
            raise MechanismError(f'direction must be "up" or "down"; found {format_value(direction)}')
        self._tables.setdefault("events", {})[name] = {"reading": reading, "value": value, **given_values(direction=direction)}

    def choose_assembly(self, take: int | str) -> None:
        """Choose one of the ways in which the joints close; see `assemblies`.

        Parameters
        ----------
        take
            Number of the assembly, from 1, or "highest", or "nearest" to the given positions and angles.

        Raises
        ------
        MechanismError
            If it is neither.
        """
        self._checks.check_assembly(take)
        self._keys["assembly"] = take

    def assemblies(self) -> assemblies.Assemblies:
        """Return all ways in which the joints close at the given angles, with numbers for `choose_assembly`.

        Returns
        -------
        Assemblies
            The list; it prints as a table, and its method `plot` draws a sheet.

        Raises
        ------
        MechanismError
            If the given angles leave a motion, with the number of values that must be given; or if the joints cannot close.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> m = gm.Mechanism.build("Four-bar")
        >>> crank, coupler = m.rod("crank", length=1.0, mass=1.0, angle="60 deg"), m.rod("coupler", length=3.0, mass=1.0)
        >>> rocker = m.rod("rocker", length=2.5, mass=1.0)
        >>> m.pin(m.ground(0, 0), crank.start)
        >>> m.pin(m.ground(3, 0), rocker.start)
        >>> m.pin(crank.end, coupler.start)
        >>> m.pin(coupler.end, rocker.end)
        >>> len(m.assemblies())
        2
        """
        from governor_mechanism.studies.assemblies import list_builder_assemblies

        return list_builder_assemblies(self)

    def document(self) -> dict[str, Any]:
        """Return the document as it stands, with the first configuration that the joints determine.

        Returns
        -------
        dict
            Keys and tables of a scene file.

        Raises
        ------
        MechanismError
            If a value is wrong, or the mechanism cannot be assembled; the message names the joint that stays open, its gap and direction.
        """
        return place_bodies(self.given_document)

    def scene(
        self,
        *,
        duration: Quantity | None = None,
        accuracy: float | None = None,
        output_interval: Quantity | None = None,
        engine: str | None = None,
    ) -> Scene:
        """Return the scene.

        Parameters
        ----------
        duration
            Duration of a run, s or text with a unit; None for that of a scene file without it.
        accuracy
            Largest error relative to the scale of each reading.
        output_interval
            Interval of the reported times, s or text with a unit.
        engine
            Name of an engine, or "auto".

        Returns
        -------
        Scene
            The scene, checked like a file.

        Raises
        ------
        MechanismError
            With a sentence for each mistake.
        """
        run = given_values(duration=duration, accuracy=accuracy, output_interval=output_interval, engine=engine)
        document = self.document()
        return Scene.from_dict({**document, "run": run} if run else document)


def _require_text(argument: str, value: object) -> None:
    """Raise MechanismError for an argument that is no text."""
    if not isinstance(value, str) or not value.strip():
        raise MechanismError(f"{argument} must be text; found {format_value(value)}")


def _pair_references(what: str, pair: object) -> list[Any]:
    """Return two points as the document writes them."""
    if not isinstance(pair, list | tuple) or len(pair) != 2:
        raise MechanismError(f"{what} takes two points, as (crank.start, crank.end); found {format_value(pair)}")
    return [point_reference(what, point) for point in pair]
