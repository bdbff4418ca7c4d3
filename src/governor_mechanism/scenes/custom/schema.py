"""What the tables of a user's own mechanism may hold: one pydantic model per kind of table.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import ConfigDict, Field, PlainValidator, create_model

from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.scene import FIXED_PLANE, TURNING_PLANE
from governor_mechanism.scenes.custom.values import (
    PointReference,
    motion_validator,
    nested_table_validator,
    validate_body_name,
    validate_curve,
    validate_named_points,
    validate_point,
    validate_point_or_body,
    validate_table_list,
    validate_two_points,
)
from governor_mechanism.scenes.quantities import (
    FloatPair,
    bounded_quantity_validator,
    choice_validator,
    join_names,
    program_validator,
    quantity_validator,
    table_validator,
    validate_bool,
    validate_label,
    validate_position,
)
from governor_mechanism.scenes.schema import SceneFileTable, SceneTable

PositionField = Annotated[FloatPair, PlainValidator(validate_position)]
PointField = Annotated[PointReference, PlainValidator(validate_point)]
PointOrBodyField = Annotated[PointReference, PlainValidator(validate_point_or_body)]
BodyNameField = Annotated[str, PlainValidator(validate_label)]
BoolField = Annotated[bool, PlainValidator(validate_bool)]
LabelField = Annotated[str | None, PlainValidator(validate_label)]
AngleField = Annotated[float, quantity_validator("angle")]
OptionalAngleField = Annotated[float | None, quantity_validator("angle")]
TableListField = Annotated[list[Any] | None, PlainValidator(validate_table_list)]

FIRST_POINT_FIELD = Field(description='where the first body is held, as "ground.O" or ["crank", "10 mm", 0]')
SECOND_POINT_FIELD = Field(description='where the second body is held, as "crank.origin" or ["crank", "10 mm", 0]')


def _make_custom_scene_table() -> type[SceneFileTable]:
    """A mechanism of one's own has all that other scenes have, but dimensions."""
    fields = SceneTable.model_fields
    keys: dict[str, Any] = {key: (fields[key].annotation, fields[key]) for key in fields if key != "dimensions"}
    keys |= {
        "size": (Annotated[float, bounded_quantity_validator("length")], 0.0),
        "plane": (Annotated[str, choice_validator((FIXED_PLANE, TURNING_PLANE))], ""),
        "ground": (Annotated[Any, table_validator()], None),
        "body": (TableListField, Field(description="the moving parts, one table [[body]] for each")),
        "joint": (TableListField, None),
        "link": (TableListField, None),
        "force": (TableListField, None),
        "readings": (Annotated[Any, table_validator()], None),
    }
    return create_model("CustomSceneTable", __base__=SceneFileTable, **keys)


CustomSceneTable: Final = _make_custom_scene_table()
"""The top of a file with a mechanism of the user's own."""


class MomentsTable(SceneFileTable):
    """The arguments of SecondMoments."""

    xx: Annotated[float, bounded_quantity_validator("moment_of_inertia", sign="not negative")] = 0.0
    yy: Annotated[float, bounded_quantity_validator("moment_of_inertia", sign="not negative")] = 0.0
    xy: Annotated[float, bounded_quantity_validator("moment_of_inertia", sign="any")] = 0.0
    zz: Annotated[float, bounded_quantity_validator("moment_of_inertia", sign="not negative")] = 0.0


class RodTable(SceneFileTable):
    """A slender rod."""

    length: Annotated[float, bounded_quantity_validator("length")] = Field(description='the length of the rod, as "100 mm"')


class DiscTable(SceneFileTable):
    """A disc in the plane."""

    radius: Annotated[float, bounded_quantity_validator("length")] = Field(description='the radius of the disc, as "100 mm"')
    thickness: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0


class PlateTable(SceneFileTable):
    """A plate in the plane."""

    width: Annotated[float, bounded_quantity_validator("length")] = Field(description='the width along x, as "100 mm"')
    height: Annotated[float, bounded_quantity_validator("length")] = Field(description='the height along y, as "100 mm"')
    thickness: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0


class BodyTable(SceneFileTable):
    """[[body]]."""

    name: Annotated[str, PlainValidator(validate_body_name)] = Field(description='what other tables call it, as "crank"')
    mass: Annotated[float, bounded_quantity_validator("mass", hint="; a bar without mass is a [[link]]")] = Field(
        description='the mass, as "0.2 kg"; a bar without mass is a [[link]]'
    )
    inertia: Annotated[float, bounded_quantity_validator("moment_of_inertia", hint="; a body that never turns has turns = false")] = 0.0
    centre: PositionField = (0.0, 0.0)
    moments: Annotated[Any, nested_table_validator(MomentsTable, 'xx = "0.5 kg m^2"')] = None
    rod: Annotated[Any, nested_table_validator(RodTable, 'length = "100 mm"')] = None
    disc: Annotated[Any, nested_table_validator(DiscTable, 'radius = "100 mm"')] = None
    plate: Annotated[Any, nested_table_validator(PlateTable, 'width = "100 mm", height = "50 mm"')] = None
    point: BoolField = False
    turns: BoolField = True
    points: Annotated[dict[str, FloatPair] | None, PlainValidator(validate_named_points)] = None
    at: PositionField = (0.0, 0.0)
    angle: AngleField = 0.0


class NamedTable(SceneFileTable):
    """What every joint and force may have."""

    name: LabelField = None


class _JointTable(NamedTable):
    first: PointField = FIRST_POINT_FIELD
    second: PointField = SECOND_POINT_FIELD


class LinkTable(NamedTable):
    """[[link]]."""

    first: PointField = FIRST_POINT_FIELD
    second: PointField = SECOND_POINT_FIELD
    length: Annotated[float, bounded_quantity_validator("length")] = 0.0


class _PinTable(_JointTable):
    pass


class _WeldTable(_JointTable):
    turn: OptionalAngleField = None


class _SliderTable(_JointTable):
    angle: AngleField = Field(description='the direction of the line in the axes of the first body, as "0 deg"')


class _PrismaticTable(_SliderTable):
    turn: OptionalAngleField = None


class _ArcTable(_JointTable):
    radius: Annotated[float, bounded_quantity_validator("length")] = Field(description='the radius of the slot, as "100 mm"')


class _CurveSlotTable(_JointTable):
    curve: Annotated[Any, PlainValidator(validate_curve)] = Field(
        description="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }"
    )
    angle: AngleField = 0.0


class _GearTable(NamedTable):
    first: PointOrBodyField = FIRST_POINT_FIELD
    second: PointOrBodyField = SECOND_POINT_FIELD
    ratio: Annotated[float, bounded_quantity_validator("ratio", sign="not zero")] = Field(
        description="how far the second body turns for one turn of the first; negative for teeth that mesh outside"
    )
    offset: OptionalAngleField = None


class _RackTable(NamedTable):
    first: PointOrBodyField = FIRST_POINT_FIELD
    second: PointOrBodyField = SECOND_POINT_FIELD
    radius: Annotated[float, bounded_quantity_validator("length", sign="not zero")] = Field(
        description='the radius of the pinion, as "20 mm"; negative drives the other way'
    )
    angle: AngleField = 0.0
    offset: Annotated[float | None, quantity_validator("length")] = None


class _DrivenTurnTable(NamedTable):
    first: PointOrBodyField = FIRST_POINT_FIELD
    second: PointOrBodyField = SECOND_POINT_FIELD
    rate: Annotated[float | None, quantity_validator("angular_speed")] = None
    start: OptionalAngleField = None
    motion: Annotated[Any, motion_validator("angle", "angle")] = None


class _DrivenSlideTable(_SliderTable):
    rate: Annotated[float | None, quantity_validator("speed")] = None
    start: Annotated[float | None, quantity_validator("length")] = None
    motion: Annotated[Any, motion_validator("length", "way")] = None


class _TwoPointTable(NamedTable):
    first: PointField = FIRST_POINT_FIELD
    second: PointField = SECOND_POINT_FIELD


class _SpringTable(_TwoPointTable):
    stiffness: Annotated[float, bounded_quantity_validator("stiffness")] = Field(description='the stiffness, as "2 N/mm"')
    free_length: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0


class _DamperTable(_TwoPointTable):
    damping: Annotated[float, bounded_quantity_validator("damping")] = Field(description='the damping, as "120 N s/m"')


class _TwoBodyTable(NamedTable):
    second: BodyNameField = Field(description='the body it turns, as "crank"')
    first: BodyNameField = GROUND


class _TorsionSpringTable(_TwoBodyTable):
    stiffness: Annotated[float, bounded_quantity_validator("torsion_stiffness")] = Field(description='the stiffness, as "3 N m/rad"')
    free_angle: AngleField = 0.0


class _TorsionDamperTable(_TwoBodyTable):
    damping: Annotated[float, bounded_quantity_validator("torsion_damping")] = Field(description='the damping, as "0.1 N m s/rad"')


class _TorqueTable(NamedTable):
    body: BodyNameField = Field(description='the body it turns, as "crank"')
    against: BodyNameField = GROUND
    moment: Annotated[Any, program_validator("torque", "moment")] = Field(
        description='the moment, as "5 N m", or a program, as [[0, "5 N m"], [2, "6 N m"]]'
    )


class _ForceTable(NamedTable):
    point: PointField = Field(description='where it acts, as "slider.centre"')
    x: Annotated[Any, program_validator("force", "force")] = None
    y: Annotated[Any, program_validator("force", "force")] = None


def _add_type_key(models: Mapping[str, type[NamedTable]]) -> dict[str, type[SceneFileTable]]:
    """The models with a first key `type`, which is one of their names."""
    type_field: Any = (Annotated[str, choice_validator(models)], Field(description=f"one of {join_names(models)}"))
    tables: dict[str, type[NamedTable]] = {"": _UntypedTable, **models}
    return {key: create_model(model.__name__, __base__=model, type=type_field) for key, model in tables.items()}


class _UntypedTable(NamedTable):
    """What can be checked of a joint or force whose type is not known."""

    model_config = ConfigDict(extra="ignore")


JOINT_TABLES: Final = _add_type_key(
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

FORCE_TABLES: Final = _add_type_key(
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


class _AngleReadingTable(SceneFileTable):
    angle: BodyNameField
    against: BodyNameField = GROUND


class _LineReadingTable(SceneFileTable):
    line: Annotated[tuple[PointReference, PointReference], PlainValidator(validate_two_points)]


class _DistanceReadingTable(SceneFileTable):
    distance: Annotated[tuple[PointReference, PointReference], PlainValidator(validate_two_points)]


def _make_position_reading_table(axis: str) -> type[SceneFileTable]:
    # Built by hand because `from` is no name in Python.
    keys: dict[str, Any] = {axis: (PointField, ...), "from": (PointField, None)}
    return create_model("PositionReading", __base__=SceneFileTable, **keys)


READING_TABLES: Final[dict[str, type[SceneFileTable]]] = {
    "angle": _AngleReadingTable,
    "line": _LineReadingTable,
    "x": _make_position_reading_table("x"),
    "y": _make_position_reading_table("y"),
    "distance": _DistanceReadingTable,
}
"""The kinds of readings by the key that tells them."""
