"""Results declare columns and figures once: texts, JSON, files and data frames say the same."""

import csv
import inspect
import math
from dataclasses import dataclass
from importlib import import_module
from pkgutil import walk_packages

import pytest

import governor_mechanism as gm
from governor_mechanism.later_module import PACKAGE
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.render.figure_files import FigureFiles
from refusing import refuses


@dataclass(frozen=True)
class Swing:
    """A row."""

    name: str
    angle: float
    period: float | None


@dataclass(frozen=True)
class Swings(Result):
    """A result of rows."""

    title: str
    rows: tuple[Swing, ...]

    columns = (
        Column("name", "swing"),
        Column("angle", "angle, deg", ".1f/deg", unit="rad"),
        Column("period", "period", "{period:.2f} s", unit="s"),
        Column("", "at", "{name}: {angle:.3f}"),
        Column("is_long", value=lambda row: row.angle > 1.0),
    )

    def __str__(self) -> str:
        return format_columns(self.columns, self.rows)


SWINGS = Swings("pendulum", (Swing("short", math.radians(10.0), 2.0), Swing("long", math.radians(90.0), None)))


def test_one_declaration_is_text_and_json(tmp_path):
    assert str(SWINGS).splitlines() == [
        "swing  angle, deg  period  at",
        "short        10.0  2.00 s  short: 0.175",
        "long         90.0          long: 1.571",
    ]
    record = SWINGS.as_json()
    assert list(record) == ["title", "rows"]
    assert record["rows"][1] == {"name": "long", "angle": math.radians(90.0), "period": None, "is_long": True}


def test_one_declaration_is_a_file_with_units_that_needs_no_package(tmp_path):
    comment, *lines = SWINGS.save_csv(tmp_path / "swings.csv").read_text(encoding="utf-8").splitlines()
    assert comment == "# units: angle rad; period s"
    rows = list(csv.DictReader(lines))
    assert [float(row["angle"]) for row in rows] == [row.angle for row in SWINGS.rows]
    assert [row["period"] for row in rows] == ["2.0", ""]


def test_one_declaration_is_a_data_frame():
    pytest.importorskip("pandas")
    table = SWINGS.to_dataframe()
    assert list(table.columns) == ["name", "angle", "period", "is_long"]
    assert table["angle"].tolist() == [row.angle for row in SWINGS.rows]
    assert table.attrs["units"] == {"angle": "rad", "period": "s"}


def result_classes() -> list[type[Result]]:
    """Every class of results of the package."""
    for folder in ("statics", "mechanics.kinematics", "studies", "papers", "verification"):
        package = import_module(f"governor_mechanism.{folder}")
        for module in walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    found = [Result]
    for one in found:
        found += [each for each in one.__subclasses__() if each not in found]
    return [one for one in found if one.__module__.startswith("governor_mechanism")]


def test_every_figure_that_a_result_declares_is_a_function_of_it():
    names = {name for one in result_classes() for name in (one.figure, one.figure_set) if name}
    assert {f"render.figures.{name}_figure" for name in ("sweep.sweep", "comparison.comparison", "controlling_force.speed_curve")} <= names
    for name in names:
        module, _, function = name.rpartition(".")
        assert len(inspect.signature(getattr(import_module(f"{PACKAGE}.{module}"), function)).parameters) >= 1


def test_a_result_draws_itself_and_one_without_a_figure_says_so(tmp_path):
    curve = gm.speed_curve("watt_improved", points=20)
    (path,) = FigureFiles(folder=tmp_path, formats=["svg"]).save_all(curve, "curve")
    assert path.name == "curve.svg"
    assert curve.plot(gm.equilibria("watt_improved", 6.4)).save(tmp_path / "marked.svg").stat().st_size > path.stat().st_size
    assert len(SWINGS.plot().axes) == 2  # its columns of numbers
    refuses(r"Equilibrium has no column of numbers to draw.*to_dataframe", gm.equilibria("porter")[0].plot)


def test_a_comparison_is_a_table_of_its_quantities():
    pytest.importorskip("pandas")
    short = [gm.load(name).replace({"run.duration": "0.1 s"}) for name in ("porter", "watt")]
    comparison = gm.compare(*short)
    table = comparison.to_dataframe()
    assert table.columns.tolist() == ["quantity", "unit", *comparison.names]
    assert len(table) == len(comparison.rows)
    for row in comparison.rows:
        assert table.set_index("quantity").at[row.quantity, comparison.names[1]] == comparison.value(row.quantity, comparison.names[1])
