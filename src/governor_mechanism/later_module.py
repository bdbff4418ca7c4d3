"""What is imported when it is needed: a later folder, whose names annotations use, and classes of which a scene needs few."""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, TypeVar

PACKAGE = __name__.partition(".")[0]
"""Name of the package."""


class LaterModule:
    """Module that is imported when one of its attributes is needed, as by `typing.get_type_hints`."""

    def __init__(
        self,
        name: str,  # name of the module inside the package
    ) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the module."""
        return getattr(import_module(f"{PACKAGE}.{self._name}"), name)


Class = TypeVar("Class", bound=type[Any])


class LaterClasses(Mapping[str, Class]):
    """Classes by name; the module of one is imported when the class is asked for."""

    def __init__(
        self,
        folder: str | None,  # name of the folder of their modules, as `__package__`
        places: Mapping[str, str],  # module in that folder and class by name, as "pendulum.PendulumGovernor"
    ) -> None:
        self._folder, self._places = folder, places

    def __getitem__(self, name: str) -> Class:
        """Return a class."""
        module, _, class_name = self._places[name].partition(".")
        found: Class = getattr(import_module(f"{self._folder}.{module}"), class_name)
        return found

    def __contains__(self, name: object) -> bool:
        """Return whether there is a class of a name."""
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter(self._places)

    def __len__(self) -> int:
        """Return the number of classes."""
        return len(self._places)
