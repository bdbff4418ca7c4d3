"""What all results that print as text have in common: a notebook shows the text, and files hold the numbers."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from html import escape
from typing import Any

from governor_mechanism.model.results.exported_result import ExportedResult


class PrintedResult(ExportedResult, ABC):
    """A result that prints as text."""

    @abstractmethod
    def as_json(self) -> Mapping[str, Any]:
        """Return all numbers in the types of JSON."""

    def _repr_html_(self) -> str:
        """Return the text, which a notebook shows with its columns aligned."""
        return format_as_html(str(self))


def format_as_html(text: str) -> str:
    """Return a printed text for a notebook, with its columns aligned and a bar to scroll long lines."""
    # JupyterLab shows a plain <pre> of a result in a proportional font.
    style = "white-space:pre;overflow-x:auto;line-height:1.3;font-family:Menlo,'DejaVu Sans Mono',Consolas,'Courier New',monospace"
    return f'<pre style="{style}">{escape(text)}</pre>'
