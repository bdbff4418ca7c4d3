"""Kernels as plain Python, for tests of single ones that the library does not hold: a compiler takes longer than the tests do."""

from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest

from governor_mechanism.numerics.jit import Kernel


def interpret_kernels(*modules: ModuleType) -> Any:
    """Return a fixture of a test module, in whose tests the kernels of modules run as Python."""

    @pytest.fixture(scope="module", autouse=True)
    def kernels_as_python() -> Iterator[None]:
        with pytest.MonkeyPatch.context() as patch:
            for kernel in (value for module in modules for value in vars(module).values() if isinstance(value, Kernel)):
                patch.setitem(kernel.__dict__, "_machine_code", kernel.__wrapped__)
            yield

    return kernels_as_python
