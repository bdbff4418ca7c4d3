"""What all results that print as text have in common: a notebook shows the text, and a JSON file holds the numbers."""

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from governor_mechanism.files.plain_values import save_json


class PrintedResult(ABC):
    """A result that prints as text."""

    @abstractmethod
    def as_json(self) -> Mapping[str, Any]:
        """Return all numbers in the types of JSON."""

    def save_json(self, path: str | os.PathLike[str]) -> Path:
        """Write all numbers as a JSON file.

        Parameters
        ----------
        path
            Path of the file.

        Returns
        -------
        Path
            The path.
        """
        return save_json(self.as_json(), Path(path))

    def _repr_html_(self) -> str:
        """Return the text, which a notebook shows with its columns aligned."""
        return f"<pre>{escape(str(self))}</pre>"
