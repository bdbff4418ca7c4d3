"""What holds of every result: its class declares columns and figures, from which text, JSON, CSV file, data frame and figure follow."""

import csv
import inspect
import json
import math
import typing
from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Result
from governor_mechanism.studies.design.skeleton import Design

WITHOUT_FIGURE = (gm.Equilibrium, gm.SceneDescription)
"""Results without anything to draw: one state, and values of different units."""


def returned_results(function: object) -> set[type]:
    """The classes of what a public function returns that are results."""
    hint = typing.get_type_hints(function)["return"]
    classes = [typing.get_origin(one) or one for one in (hint, *typing.get_args(hint))]
    return {one for one in classes if inspect.isclass(one) and issubclass(one, Result)}


def check_declarations(kind: type[Result]) -> None:
    """A class declares; what follows from it is written once, for all classes."""
    written_once = {"to_dataframe", "save_csv", "save_json", "figures"} - ({"to_dataframe"} if kind is gm.Trajectory else set())
    assert all(getattr(kind, name) is getattr(Result, name) for name in written_once)
    assert kind is gm.Trajectory or kind.as_json is Result.as_json
    assert kind.columns is not Result.columns or kind is gm.Equilibrium or issubclass(kind, Design)


def check_result(result: Result, folder: Path) -> None:
    """Text, JSON, CSV file, data frame and figure of a result say the same."""
    pandas = pytest.importorskip("pandas")
    assert str(result).strip()
    assert len(str(result)) < 20_000
    record = json.loads(result.save_json(folder / "result.json").read_text(encoding="utf-8"))
    assert record == json.loads(json.dumps(result.as_json(), default=str))
    table = result.to_dataframe()
    path = result.save_csv(folder / "result.csv")
    if not isinstance(result, gm.Trajectory):  # whose files name the time and have further columns on request
        written = pandas.read_csv(path, comment="#", index_col=0 if table.index.name else None, quoting=csv.QUOTE_MINIMAL)
        assert [name.partition(" [")[0] for name in written.columns] == list(table.columns)
        assert len(written) == len(table) > 0
        for name, own in zip(table.columns, written.columns, strict=True):
            if table[name].dtype.kind == "f":
                finite = np.where(np.isfinite(table[name]), table[name], math.nan)
                np.testing.assert_array_equal(np.where(np.isfinite(written[own]), written[own], math.nan), finite)  # to the last digit
    if isinstance(result, WITHOUT_FIGURE):
        with pytest.raises(MechanismError, match="no column of numbers to draw"):
            result.plot()
    elif not isinstance(result, Design) and not (result.figure_set and not result.figure):  # several figures, or a simulation before them
        assert result.plot().axes
