"""Settings of all tests. Kernels are compiled before parallel workers start: workers that need the same one would each compile it."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import settings

settings.register_profile("suite", deadline=None)  # no test looks at the clock
settings.load_profile("suite")

COMPILE = "import governor_mechanism as gm; gm.run('porter_dry_friction', engine={!r}, times=[0.1], certify=False)"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Run one engine in each of two processes; what fails there fails in a test too."""
    processes = [subprocess.Popen([sys.executable, "-c", COMPILE.format(engine)]) for engine in ("reduced", "multibody")]
    for process in processes:
        process.wait()
