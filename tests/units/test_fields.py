"""What classes declare of their fields, and the customary units in SI."""

from dataclasses import dataclass

import pytest

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.scenes.custom.parts import FORCE_TABLES, JOINT_TABLES
from governor_mechanism.scenes.loads import COUPLING_TABLES, LOAD_TYPES
from governor_mechanism.scenes.quantities import SIGNS
from governor_mechanism.units.constants import HORSEPOWER_1901, KILOGRAM_FORCE_1901, RPM
from governor_mechanism.units.fields import entry, fields_of, optional, optional_size, quantity, require_valid_fields
from governor_mechanism.units.quantities import QUANTITY_KINDS, parse_quantity


@dataclass(frozen=True, kw_only=True)
class Sample:
    """One field of each way to declare it."""

    rate: float = quantity("stiffness", "torsion_stiffness", examples=("2 N/mm", "3 N m/deg"))
    offset: float = quantity("length", sign="any", default=0.0)
    radius: float | None = optional("length", meaning="of the wheel")
    mass: float = optional_size("mass")
    is_free: bool = entry("flag", default=False)
    undeclared: str = ""


def test_only_a_field_without_a_default_must_be_given():
    declared = fields_of(Sample)
    assert [name for name, one in declared.items() if one.is_required] == ["rate"]
    assert list(declared) == ["rate", "offset", "radius", "mass", "is_free"]
    sample = Sample(rate=1.0)
    assert (sample.offset, sample.radius, sample.mass, sample.is_free) == (0.0, None, 0.0, False)
    with pytest.raises(TypeError):
        Sample()


def test_a_kind_of_quantity_follows_the_reading():
    declared = fields_of(Sample)["rate"]
    along_length, along_angle = declared.along("length"), declared.along("angle")
    assert (along_length.kind, along_length.unit, along_length.examples) == ("stiffness", "N/m", ("2 N/mm",))
    assert (along_angle.kind, along_angle.unit, along_angle.examples) == ("torsion_stiffness", "N m/rad", ("3 N m/deg",))
    assert fields_of(Sample)["offset"].along("angle").kind == "length"
    assert fields_of(Sample)["radius"].kind_and_meaning == "length of the wheel"


@dataclass(frozen=True, kw_only=True)
class Wheel:
    """A wheel."""

    radius: float = quantity("length")
    offset: float = quantity("length", sign="any", default=0.0)

    def __post_init__(self) -> None:
        require_valid_fields(self, "a wheel")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"radius": 0.0}, "radius of a wheel must be positive; got 0 m"),
        ({"radius": float("nan")}, "radius of a wheel must be positive; got nan m"),
        ({"radius": 1.0, "offset": float("inf")}, "offset of a wheel must be a finite number; got inf m"),
    ],
)
def test_instances_are_checked_as_their_fields_are_declared(values: dict[str, float], message: str):
    with pytest.raises(MechanismError) as caught:
        Wheel(**values)
    assert caught.value.problems == (message,)
    assert Wheel(radius=1.0, offset=-1.0).offset == -1.0


def test_declarations_name_known_kinds_signs_and_forms():
    tables = {**JOINT_TABLES, **FORCE_TABLES, **COUPLING_TABLES}
    declared = {(name, key): (one, table.types) for name, table in tables.items() for key, one in table.fields.items()}
    for owner in (*MACHINES.values(), *EFFECTS):
        declared |= {(owner.__name__, key): (one, LOAD_TYPES) for key, one in fields_of(owner).items()}
    wrong = [
        where
        for where, (one, types) in declared.items()
        if not {*one.kinds} <= {*QUANTITY_KINDS} or one.sign not in SIGNS or one.form not in types
    ]
    assert not wrong
    assert len(declared) > 100


@pytest.mark.parametrize(("text", "kind", "value"), [("1 rpm", "angular_speed", RPM), ("1 kgf", "force", KILOGRAM_FORCE_1901)])
def test_customary_units_are_those_of_scene_files(text: str, kind: str, value: float):
    assert parse_quantity(text, kind, text) == pytest.approx(value, rel=1e-15)  # but for one rounding


def test_a_metric_horsepower_raises_75_kilograms_by_a_metre_in_a_second():
    read = parse_quantity("1 PS", "power", "power")
    assert (read, read) == pytest.approx((HORSEPOWER_1901, 735.49875), rel=1e-15)
