"""Settings of all tests. Kernels are compiled before parallel workers start: workers that need the same one would each compile it."""

from __future__ import annotations

import subprocess
import sys

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

COMPILE = """
import os

if hasattr(os, "sched_setaffinity"):  # with one processor, no further process helps, which would compile much of this again
    processors = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {{processors[{process} % len(processors)]}})

import governor_mechanism as gm

for engine in {engines}:
    run = gm.run("porter_cyclic", engine=engine, times=[0.3], certify=False)
    gm.run("air_engine", engine=engine, times=[0.01], certify=False)
    if engine == "reduced":
        gm.kinematics("porter", "arm_angle", [0.5, 0.6])
        gm.run("stiff_flyball", engine="multibody", times=[10.0], certify=False)  # the other process has compiled the explicit steps
    if engine == "impulse":
        gm.run("hartung_corrected", engine=engine, times=[5.0], certify=False)
        gm.linearise("haug_governor")
        run.reactions.items()
"""
"""Runs of some engines that slip and stick, and what else has kernels of its own: no contacts, gas in cylinders, stiff springs."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Run the engines in two processes that take about the same time; what fails there fails in a test too."""
    engines_of_processes = enumerate((["reduced"], ["multibody", "impulse"]))
    codes = [COMPILE.format(process=process, engines=engines) for process, engines in engines_of_processes]
    processes = [subprocess.Popen([sys.executable, "-c", code]) for code in codes]
    for process in processes:
        process.wait()
