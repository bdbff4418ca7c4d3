"""Kernels that are named on the command line: a function in a Python file or in a module."""

import importlib
import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean

EXAMPLE = "mine.py:speed, or package.module:speed"


def load_kernel(name: str) -> Callable[..., Any]:
    """Return the function of a name, "FILE.py:FUNCTION" or "MODULE:FUNCTION".

    The file is executed. It may import what lies beside it.

    Raises MechanismError if there is no such file or function, or the file cannot be executed.
    """
    place, separator, function = name.rpartition(":")
    if not separator or not place.strip() or not function.strip():
        raise MechanismError(f"--kernel {name!r} is not understood; write {EXAMPLE}")
    module = _execute_file(Path(place)) if place.endswith(".py") else _import_module(place)
    found = getattr(module, function, None)
    functions = [key for key, value in vars(module).items() if callable(value) and not key.startswith("_")]
    if found is None:
        listed = ", ".join(functions) or "none"
        raise MechanismError(f"{place} has no function {function!r}; it has {listed}.{did_you_mean(function, functions)}")
    if not callable(found):
        raise MechanismError(f"{function!r} in {place} is no function; it is of type {type(found).__name__}")
    kernel: Callable[..., Any] = found
    return kernel


def _execute_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise MechanismError(f"--kernel: there is no file {path}; write {EXAMPLE}")
    folder, module_name = str(path.resolve().parent), f"_kernel_{path.stem}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise MechanismError(f"--kernel: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # as dataclasses in it need
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise MechanismError(f"--kernel: {path} cannot be executed: {_describe(error)}") from error
    finally:
        sys.path.remove(folder)
    return module


def _import_module(name: str) -> ModuleType:
    sys.path.insert(0, "")
    try:
        return importlib.import_module(name)
    except (Exception, SystemExit) as error:
        raise MechanismError(f"--kernel: module {name!r} cannot be imported: {_describe(error)}; for a file write {EXAMPLE}") from error
    finally:
        sys.path.remove("")


def _describe(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
