"""What all results have in common that files and tables take: plain values, JSON and CSV files, and a table of pandas."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from governor_mechanism.types import DataFrame


class ExportedResult:
    """A result whose numbers can be written to files; a class with columns of its own overrides `to_dataframe`."""

    def as_json(self) -> Mapping[str, Any]:
        """Return all numbers in the types of JSON, in SI; those that are not finite are None.

        Result: numbers by name; complex numbers as pairs of real and imaginary part.
        """
        from governor_mechanism.files.exported_values import record_result

        return record_result(self)

    def to_dataframe(self) -> DataFrame:
        """Return a table of pandas: the arrays as columns, or in one row all numbers, as "exact.rate" for the rate in "exact" (SI).

        Raises MechanismError if pandas is not installed.
        """
        from governor_mechanism.files.exported_values import tabulate_record

        return tabulate_record(self)

    def save_json(self, path: str | os.PathLike[str]) -> Path:
        """Write all numbers as a JSON file."""
        from governor_mechanism.files.exported_values import save_record

        return save_record(self, path)

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write the table of `to_dataframe` as a CSV file.

        Raises MechanismError if pandas is not installed.
        """
        from governor_mechanism.files.exported_values import save_columns

        return save_columns(self, path)
