"""The quantities of a scene that a kernel may compute, with inputs, arguments and units, as a table."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.model.scene import Scene
from governor_mechanism.units.text_table import format_table
from governor_mechanism.verification.user_kernel.comparison import kernel_quantities
from governor_mechanism.verification.user_kernel.simulated import Quantity
from governor_mechanism.verification.user_kernel.units import constant_units


@dataclass(frozen=True, kw_only=True)
class QuantityListing(PrintedResult):
    """The quantities of a scene, and the constants (with their units) that every kernel may take."""

    title: str
    quantities: tuple[Quantity, ...]
    constants: Mapping[str, str]

    def as_json(self) -> dict[str, Any]:
        """Return the quantities as plain values."""
        quantities = [
            {
                "name": one.name,
                "unit": one.unit,
                "description": one.description,
                "over": {name: given.unit for name, given in one.inputs.items()},
                "optional": [name for name, given in one.inputs.items() if given.default is not None],
                "arguments": list(one.arguments),
            }
            for one in self.quantities
        ]
        return {"title": self.title, "quantities": quantities, "constants": dict(self.constants)}

    def __str__(self) -> str:
        """Return a table of the quantities, with the arguments that a kernel may have below it."""
        rows = [(one.name, one.unit, _format_inputs(one), one.description) for one in self.quantities if not _is_derivative(one)]
        if any(map(_is_derivative, self.quantities)):
            text = "first and second time derivative of a reading, at a position and a rate (1 in SI unless given), or over time"
            rows.append(("rate_of_READING, acceleration_of_READING", "", "", text))
        table = format_table(("quantity", "unit", "over", "what it is"), rows, "llll")
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


def _is_derivative(quantity: Quantity) -> bool:
    return quantity.name.startswith(("rate_of_", "acceleration_of_"))


def _format_inputs(quantity: Quantity) -> str:
    names = [f"{name} ({one.unit})" if one.default is None else f"[{name} ({one.unit})]" for name, one in quantity.inputs.items()]
    return ", ".join(names) or "-"


def list_quantities(scene: Scene) -> QuantityListing:
    """Return the quantities of a scene that a kernel may compute.

    Result: the quantities; it prints as a table.
    """
    return QuantityListing(title=scene.title, quantities=tuple(kernel_quantities(scene)), constants=constant_units(scene))
