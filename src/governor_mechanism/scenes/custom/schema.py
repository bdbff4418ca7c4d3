"""What the tables of a user's own mechanism may hold: one pydantic model per kind of table.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import ConfigDict, Field, PlainValidator, create_model

from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.scene import FIXED, TURNING
from governor_mechanism.scenes.custom.values import (
    End,
    body_name,
    curve_value,
    end_or_body_value,
    end_value,
    list_of_tables,
    motion_value,
    nested,
    points_value,
    two_ends_value,
)
from governor_mechanism.scenes.quantities import (
    Pair,
    any_table,
    built,
    label,
    listed,
    one_of,
    place_value,
    program,
    quantity,
    truth,
)
from governor_mechanism.scenes.schema import SceneTable, Table

Place = Annotated[Pair, PlainValidator(place_value)]
Point = Annotated[End, PlainValidator(end_value)]
PointOrBody = Annotated[End, PlainValidator(end_or_body_value)]
BodyName = Annotated[str, PlainValidator(label)]
Truth = Annotated[bool, PlainValidator(truth)]
Label = Annotated[str | None, PlainValidator(label)]
Angle = Annotated[float, quantity("angle")]
Maybe = Annotated[float | None, quantity("angle")]
Tables = Annotated[list[Any] | None, PlainValidator(list_of_tables)]

FIRST = Field(description='where the first body is held, as "ground.O" or ["crank", "10 mm", 0]')
SECOND = Field(description='where the second body is held, as "crank.origin" or ["crank", "10 mm", 0]')


def _scene_table() -> type[Table]:
    """A mechanism of one's own has all that other scenes have, but dimensions."""
    fields = SceneTable.model_fields
    keys: dict[str, Any] = {key: (fields[key].annotation, fields[key]) for key in fields if key != "dimensions"}
    keys |= {
        "size": (Annotated[float, built("length")], 0.0),
        "plane": (Annotated[str, one_of((FIXED, TURNING))], ""),
        "ground": (Annotated[Any, any_table()], None),
        "body": (Tables, Field(description="the moving parts, one table [[body]] for each")),
        "joint": (Tables, None),
        "link": (Tables, None),
        "force": (Tables, None),
        "readings": (Annotated[Any, any_table()], None),
    }
    return create_model("CustomSceneTable", __base__=Table, **keys)


CustomSceneTable: Final = _scene_table()
"""The top of a file with a mechanism of the user's own."""


class MomentsTable(Table):
    """The arguments of SecondMoments."""

    xx: Annotated[float, built("moment_of_inertia", sign="not negative")] = 0.0
    yy: Annotated[float, built("moment_of_inertia", sign="not negative")] = 0.0
    xy: Annotated[float, built("moment_of_inertia", sign="any")] = 0.0
    zz: Annotated[float, built("moment_of_inertia", sign="not negative")] = 0.0


class RodTable(Table):
    """A slender rod."""

    length: Annotated[float, built("length")] = Field(description='the length of the rod, as "100 mm"')


class DiscTable(Table):
    """A disc in the plane."""

    radius: Annotated[float, built("length")] = Field(description='the radius of the disc, as "100 mm"')
    thickness: Annotated[float, built("length", sign="not negative")] = 0.0


class PlateTable(Table):
    """A plate in the plane."""

    width: Annotated[float, built("length")] = Field(description='the width along x, as "100 mm"')
    height: Annotated[float, built("length")] = Field(description='the height along y, as "100 mm"')
    thickness: Annotated[float, built("length", sign="not negative")] = 0.0


class BodyTable(Table):
    """[[body]]."""

    name: Annotated[str, PlainValidator(body_name)] = Field(description='what other tables call it, as "crank"')
    mass: Annotated[float, built("mass", cure="; a bar without mass is a [[link]]")] = Field(
        description='the mass, as "0.2 kg"; a bar without mass is a [[link]]'
    )
    inertia: Annotated[float, built("moment_of_inertia", cure="; a body that never turns has turns = false")] = 0.0
    centre: Place = (0.0, 0.0)
    moments: Annotated[Any, nested(MomentsTable, 'xx = "0.5 kg m^2"')] = None
    rod: Annotated[Any, nested(RodTable, 'length = "100 mm"')] = None
    disc: Annotated[Any, nested(DiscTable, 'radius = "100 mm"')] = None
    plate: Annotated[Any, nested(PlateTable, 'width = "100 mm", height = "50 mm"')] = None
    point: Truth = False
    turns: Truth = True
    points: Annotated[dict[str, Pair] | None, PlainValidator(points_value)] = None
    at: Place = (0.0, 0.0)
    angle: Angle = 0.0


class HeldTable(Table):
    """What every joint and force may have."""

    name: Label = None


class _JointTable(HeldTable):
    first: Point = FIRST
    second: Point = SECOND


class LinkTable(HeldTable):
    """[[link]]."""

    first: Point = FIRST
    second: Point = SECOND
    length: Annotated[float, built("length")] = 0.0


class _PinTable(_JointTable):
    pass


class _WeldTable(_JointTable):
    turn: Maybe = None


class _SliderTable(_JointTable):
    angle: Angle = Field(description='the direction of the line in the axes of the first body, as "0 deg"')


class _PrismaticTable(_SliderTable):
    turn: Maybe = None


class _ArcTable(_JointTable):
    radius: Annotated[float, built("length")] = Field(description='the radius of the slot, as "100 mm"')


class _CurveSlotTable(_JointTable):
    curve: Annotated[Any, PlainValidator(curve_value)] = Field(
        description="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }"
    )
    angle: Angle = 0.0


class _GearTable(HeldTable):
    first: PointOrBody = FIRST
    second: PointOrBody = SECOND
    ratio: Annotated[float, built("ratio", sign="not zero")] = Field(
        description="how far the second body turns for one turn of the first; negative for teeth that mesh outside"
    )
    offset: Maybe = None


class _RackTable(HeldTable):
    first: PointOrBody = FIRST
    second: PointOrBody = SECOND
    radius: Annotated[float, built("length", sign="not zero")] = Field(
        description='the radius of the pinion, as "20 mm"; negative drives the other way'
    )
    angle: Angle = 0.0
    offset: Annotated[float | None, quantity("length")] = None


class _DrivenTurnTable(HeldTable):
    first: PointOrBody = FIRST
    second: PointOrBody = SECOND
    rate: Annotated[float | None, quantity("angular_speed")] = None
    start: Maybe = None
    motion: Annotated[Any, motion_value("angle", "angle")] = None


class _DrivenSlideTable(_SliderTable):
    rate: Annotated[float | None, quantity("speed")] = None
    start: Annotated[float | None, quantity("length")] = None
    motion: Annotated[Any, motion_value("length", "way")] = None


class _BetweenTable(HeldTable):
    first: Point = FIRST
    second: Point = SECOND


class _SpringTable(_BetweenTable):
    stiffness: Annotated[float, built("stiffness")] = Field(description='the stiffness, as "2 N/mm"')
    free_length: Annotated[float, built("length", sign="not negative")] = 0.0


class _DamperTable(_BetweenTable):
    damping: Annotated[float, built("damping")] = Field(description='the damping, as "120 N s/m"')


class _TurningTable(HeldTable):
    second: BodyName = Field(description='the body it turns, as "crank"')
    first: BodyName = GROUND


class _TorsionSpringTable(_TurningTable):
    stiffness: Annotated[float, built("torsion_stiffness")] = Field(description='the stiffness, as "3 N m/rad"')
    free_angle: Angle = 0.0


class _TorsionDamperTable(_TurningTable):
    damping: Annotated[float, built("torsion_damping")] = Field(description='the damping, as "0.1 N m s/rad"')


class _TorqueTable(HeldTable):
    body: BodyName = Field(description='the body it turns, as "crank"')
    against: BodyName = GROUND
    moment: Annotated[Any, program("torque", "moment")] = Field(
        description='the moment, as "5 N m", or a program, as [[0, "5 N m"], [2, "6 N m"]]'
    )


class _ForceTable(HeldTable):
    point: Point = Field(description='where it acts, as "slider.centre"')
    x: Annotated[Any, program("force", "force")] = None
    y: Annotated[Any, program("force", "force")] = None


def _typed(models: Mapping[str, type[HeldTable]]) -> dict[str, type[Table]]:
    """The models with a first key `type`, which is one of their names."""
    kind: Any = (Annotated[str, one_of(models)], Field(description=f"one of {listed(models)}"))
    made: dict[str, type[HeldTable]] = {"": _AnyTable, **models}
    return {key: create_model(model.__name__, __base__=model, type=kind) for key, model in made.items()}


class _AnyTable(HeldTable):
    """What can be checked of a joint or force whose type is not known."""

    model_config = ConfigDict(extra="ignore")


JOINTS: Final = _typed(
    {
        "pin": _PinTable,
        "weld": _WeldTable,
        "prismatic": _PrismaticTable,
        "slider": _SliderTable,
        "arc": _ArcTable,
        "curve": _CurveSlotTable,
        "gear": _GearTable,
        "rack": _RackTable,
        "driven_turn": _DrivenTurnTable,
        "driven_slide": _DrivenSlideTable,
    }
)
"""The tables [[joint]] by type; "" where it is not known."""

FORCES: Final = _typed(
    {
        "spring": _SpringTable,
        "damper": _DamperTable,
        "torsion_spring": _TorsionSpringTable,
        "torsion_damper": _TorsionDamperTable,
        "torque": _TorqueTable,
        "force": _ForceTable,
    }
)
"""The tables [[force]] by type; "" where it is not known."""


class _AngleReading(Table):
    angle: BodyName
    against: BodyName = GROUND


class _LineReading(Table):
    line: Annotated[tuple[End, End], PlainValidator(two_ends_value)]


class _DistanceReading(Table):
    distance: Annotated[tuple[End, End], PlainValidator(two_ends_value)]


def _position(axis: str) -> type[Table]:
    # Built by hand because `from` is no name in Python.
    keys: dict[str, Any] = {axis: (Point, ...), "from": (Point, None)}
    return create_model("PositionReading", __base__=Table, **keys)


READINGS: Final[dict[str, type[Table]]] = {
    "angle": _AngleReading,
    "line": _LineReading,
    "x": _position("x"),
    "y": _position("y"),
    "distance": _DistanceReading,
}
"""The kinds of readings by the key that tells them."""
