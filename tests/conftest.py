"""Settings of all tests."""

import gc

import pytest
from hypothesis import Phase, settings

settings.register_profile("suite", deadline=None, max_examples=50)  # no test looks at the clock
settings.register_profile(
    "mutants", deadline=None, max_examples=12, derandomize=True, database=None, phases=[Phase.explicit, Phase.generate]
)
"""For benchmarks/mutants.py: few examples, the same for every mutant, and none is simplified."""
settings.register_profile("quick", parent=settings.get_profile("suite"), max_examples=20)
"""For `make test`; `make test-all` tries more examples."""
settings.load_profile("suite")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Search for no garbage while modules and tests are collected, which all stay, and leave them out of every later search."""
    gc.disable()
    result = yield
    gc.freeze()
    gc.enable()
    return result
