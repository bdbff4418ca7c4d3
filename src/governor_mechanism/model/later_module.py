"""Names of a later folder in the annotations of the methods that hand on to it."""

from importlib import import_module
from typing import Any

PACKAGE = __name__.partition(".")[0]
"""Name of the package."""


class LaterModule:
    """Module that is imported when one of its attributes is needed, as by `typing.get_type_hints`.

    Parameters
    ----------
    name
        Name of the module inside the package.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the module."""
        return getattr(import_module(f"{PACKAGE}.{self._name}"), name)
