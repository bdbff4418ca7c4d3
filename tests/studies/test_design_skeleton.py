"""What all designs share: units and places in texts, declared inputs, scenes from templates, and one description for all outputs."""

import inspect
import json
import math
import re
from dataclasses import dataclass, fields, replace

import pytest

from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design import engine_governor
from governor_mechanism.studies.design.simulated import PROCEDURES
from governor_mechanism.studies.design.skeleton import fill_rows, read_file, read_tables, scene_comment
from governor_mechanism.units import constants, text_table
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS, parse_quantity

DESIGNS = {name: procedure.design(procedure.inputs) for name, procedure in PROCEDURES.items()}


@dataclass(frozen=True)
class Sleeve:
    """A record with places."""

    lift: float = 0.015
    speeds: tuple[float, float] = (290 * constants.RPM, 310 * constants.RPM)
    load: float | None = None


@pytest.mark.parametrize(
    ("unit", "kind"),
    [
        *(("mm", "length"), ("cm", "length"), ("cm^2", "area"), ("deg", "angle"), ("rpm", "angular_speed"), ("kN", "force")),
        *(("kW", "power"), ("PS", "power"), ("N/mm", "stiffness"), ("bar", "pressure"), ("MPa", "pressure"), ("GPa", "modulus")),
    ],
)
def test_a_quantity_in_a_unit_of_the_workshop_is_read_back(unit, kind):
    """The reader of scene files has its units from another source, pint."""
    number = text_table.in_unit(0.7, unit)
    assert parse_quantity(f"{number!r} {unit}", kind, "x") == pytest.approx(0.7, rel=1e-15)


def test_the_papers_weigh_with_9_81_and_the_horsepower_of_1901_is_the_one_of_pint():
    assert parse_quantity("1 PS", "power", "x") == pytest.approx(constants.HORSEPOWER_1901, rel=1e-15)
    assert parse_quantity("1 kgf", "force", "x") == pytest.approx(constants.KILOGRAM_FORCE_1901, rel=1e-15)
    assert text_table.in_unit(9.81 * 30, "kgf") == pytest.approx(30.0, rel=1e-15)
    assert pytest.approx(1 + 1 / 2927, rel=1e-6) == constants.HORSEPOWER_1853 / constants.HORSEPOWER_1901  # 9.81 / 9.80665


def test_a_place_writes_a_unit_or_divides_by_it_and_a_line_without_a_value_is_left_out():
    text = "{lift:.6g mm} or {lift:.6g/mm}, {speeds[0]:.5g/rpm} to {speeds[1]:.5g rpm}\nload {load:.3g} N\n{share:.1%} of {lift:g}"
    assert text_table.fill_places(text, Sleeve(), share=0.25) == "15 mm or 15, 290 to 310 rpm\n25.0% of 0.015"
    with pytest.raises(AttributeError):
        text_table.fill_places("{left}", Sleeve())


def test_a_place_alone_in_a_row_is_the_value_itself_and_a_row_without_a_value_is_left_out():
    design = DESIGNS["pendulum"]
    weights = design.weights
    rows = {quantity: value for _, quantity, _, value, _ in fill_rows("pendulum", "steps", design)}
    assert weights[1] is None
    assert "weight on extended arms, P1" not in rows
    assert rows["weight of a ball, P"] == weights[0]
    assert fill_rows("pendulum", "no such table", design) == []


@pytest.mark.parametrize("name", PROCEDURES)
def test_every_input_is_declared_once_with_kind_and_meaning(name):
    declarations = fields_of(type(PROCEDURES[name].inputs))
    assert declarations.keys() == {one.name for one in fields(PROCEDURES[name].inputs)}
    for key, declared in declarations.items():
        assert declared.meaning
        assert declared.kind in QUANTITY_KINDS if declared.kinds else declared.words, key


@pytest.mark.parametrize("name", PROCEDURES)
def test_every_sentence_of_a_table_is_said_somewhere(name):
    module = inspect.getmodule(PROCEDURES[name].design)
    source = inspect.getsource(module) + (inspect.getsource(engine_governor) if name == "governed-engine" else "")
    assert [one for one in read_tables(name.replace("-", "_"))["sentences"] if f'"{one}"' not in source] == []


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_is_text_plain_values_and_a_scene(name):
    design = DESIGNS[name]
    assert "{" not in str(design)
    assert json.loads(json.dumps(design.as_json(), allow_nan=False))["inputs"].keys() == {one.name for one in fields(design.inputs)}
    assert not re.search(r"{\w", json.dumps(design.scene_document))  # no place is left
    assert design.scene.document == design.scene_document
    assert scene_comment(design.machine) in read_file(f"{design.machine}.toml").replace("# ", "")


def test_mistakes_of_sign_and_limits_are_named_at_once_and_relations_only_among_right_ones():
    inputs = replace(PROCEDURES["governed-engine"].inputs, droop=0.9, offset=-1.0, sleeve_travel=0.05)
    expected = (
        "droop must be at most 50%, where nothing is governed; got 90.0000%",
        "offset and sleeve_travel are given, but each follows from the other; give only one of them",
    )
    with pytest.raises(MechanismError) as caught:
        engine_governor.validate_inputs(replace(inputs, arm=-0.3))
    assert caught.value.problems == ("arm must be positive; got -300 mm", *expected)
    with pytest.raises(MechanismError) as caught:
        engine_governor.validate_inputs(inputs)
    relation = "offset must be above -150 mm, where the balls are on the axis at full load; got -1000 mm"
    assert caught.value.problems == (*expected, relation)


@pytest.mark.parametrize("name", PROCEDURES)
def test_every_input_with_limits_has_a_sentence_about_them(name):
    limited = {key for key, declared in fields_of(type(PROCEDURES[name].inputs)).items() if declared.limits}
    assert limited == read_tables(name.replace("-", "_")).get("limits", {}).keys()


def test_limits_are_admitted_unless_their_end_is_open():
    above = Declaration(limits=(0.5, math.inf), open_ends="low")
    assert not above.admits(0.5)
    assert above.admits(math.nextafter(0.5, 1.0))
    below = Declaration(limits=(0.0, 2.0), open_ends="high")
    assert below.admits(0.0)
    assert not below.admits(2.0)
