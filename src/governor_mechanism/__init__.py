"""Planar mechanisms of machine control: governors, valve gears and engines.

A scene is described once, simulated by several engines, and verified against closed forms.

Examples
--------
>>> import governor_mechanism as gm
>>> run = gm.run(gm.load("porter"), accuracy=1e-8)
>>> run.outcome.ok
True
"""

import re as _re
from importlib import import_module as _import_module
from pathlib import Path as _Path

__version__ = "0.1.0"

_PUBLIC_NAMES = _Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_MODULES = {name: module for module, name in _re.findall(r"^from (\S+) import (\w+) as \2$", _PUBLIC_NAMES, _re.MULTILINE)}
"""Modules of the public names, which `__init__.pyi` lists once for type checkers and for this package."""

__all__ = sorted({*_MODULES} - {"open"})  # it would hide the function of Python where all names are imported


def __getattr__(name: str) -> object:
    """Import a public name when it is first asked for, so that the package itself is imported quickly."""
    if name.startswith("_"):  # of Python's own protocols: tools ask a module for many
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name not in _MODULES:
        from governor_mechanism.errors import did_you_mean  # not before: it is slow to import

        raise AttributeError(f"module {__name__!r} has no attribute {name!r}.{did_you_mean(name, __all__)}")
    return globals().setdefault(name, getattr(_import_module(_MODULES[name]), name))


def __dir__() -> list[str]:
    return [*__all__, "open", "__version__"]
