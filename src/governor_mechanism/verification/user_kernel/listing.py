"""The quantities of a scene that a kernel may compute, with inputs, arguments and units, as a table."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace

from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.verification.user_kernel.comparison import kernel_quantities
from governor_mechanism.verification.user_kernel.simulated import Quantity, constant_units

_DERIVATIVES = SimpleNamespace(
    name="rate_of_READING, acceleration_of_READING",
    unit="",
    inputs=None,
    description="first and second time derivative of a reading, at a position and a rate (1 in SI unless given), or over time",
)
"""The row that stands for all derivatives of readings."""


def _is_derivative(quantity: Quantity) -> bool:
    return quantity.name.startswith(("rate_of_", "acceleration_of_"))


def _format_inputs(quantity: Quantity) -> str:
    if quantity.inputs is None:
        return ""
    names = [f"{name} ({one.unit})" if one.default is None else f"[{name} ({one.unit})]" for name, one in quantity.inputs.items()]
    return ", ".join(names) or "-"


@dataclass(frozen=True, kw_only=True)
class QuantityListing(Result):
    """The quantities of a scene, and the constants (with their units) that every kernel may take."""

    title: str
    quantities: tuple[Quantity, ...]
    constants: Mapping[str, str]

    record = ("title", "quantities=rows", "constants")
    columns = (
        Column("name", "quantity"),
        Column("unit", "unit"),
        Column("over", "over", _format_inputs, value=lambda one: {name: given.unit for name, given in one.inputs.items()}, in_table=False),
        Column("optional", value=lambda one: [n for n, given in one.inputs.items() if given.default is not None], in_table=False),
        Column("description", "what it is"),
        Column("arguments", in_table=False),
    )

    @property
    def rows(self) -> tuple[Quantity, ...]:
        """The quantities, which are the rows of tables."""
        return self.quantities

    def __str__(self) -> str:
        """Return a table of the quantities, with the arguments that a kernel may have below it."""
        rows: list[object] = [one for one in self.quantities if not _is_derivative(one)]
        if any(map(_is_derivative, self.quantities)):
            rows.append(_DERIVATIVES)
        table = format_columns(self.columns, rows)
        units = ", ".join(f"{name} ({unit or '1'})" for name, unit in self.constants.items())
        of_positions = [one for one in self.quantities if "time" not in one.inputs]
        others = sorted({name for one in of_positions for name in one.arguments} - self.constants.keys())
        lines = [
            f"arguments of every kernel, in SI: {units}; infinite where they are left out",
            *([] if "gravity" in self.constants else ["at a position those of the rotating part have no part in front of their names"]),
            "and what stands under `over`, optional in brackets",
            *([f"at a position also: {', '.join(others)}, besides the quantity itself"] if others else []),
            "over time also: all other readings of the run",
        ]
        return "\n".join([self.title, table, "", *lines])


def list_quantities(scene: Scene) -> QuantityListing:
    """Return the quantities of a scene that a kernel may compute.

    Result: the quantities; it prints as a table.
    """
    return QuantityListing(title=scene.title, quantities=tuple(kernel_quantities(scene)), constants=constant_units(scene))
