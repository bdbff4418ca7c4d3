"""Kernels as plain Python, for tests of single ones that the library does not hold: a compiler takes longer than the tests do."""

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

import pytest

from governor_mechanism.numerics.jit import Kernel


@contextmanager
def interpreted(*modules: ModuleType) -> Iterator[None]:
    """Let the kernels of modules run as Python."""
    with pytest.MonkeyPatch.context() as patch:
        for kernel in (value for module in modules for value in vars(module).values() if isinstance(value, Kernel)):
            patch.setitem(kernel.__dict__, "_machine_code", kernel.__wrapped__)
        yield
