"""Compilation of all kernels into the cache on disk, by short calculations that use them; for images and clusters."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from governor_mechanism.engines import select_engine
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import kernel_cache_folder
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

MACHINE_CODE_PATTERN = "*.nbc"
"""Files of the cache that hold machine code."""

SHORT_RUN_TIMES, BOUNCING_RUN_TIMES, STIFF_RUN_TIMES = (0.0, 0.01), (0.0, 0.4), (0.0, 10.0)
"""Reported times of a run without contacts that needs all kernels of its engine, of one that strikes a stop, and of a stiff one, for which
explicit steps would take longer, s.
"""

BOUNCING_GOVERNOR: Mapping[str, Any] = {
    "machine": "pendulum_governor",
    "dimensions": {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0},
    "effects": {
        "gravity": True,
        "centrifugal": True,
        "dashpot": {"arm_angle": 0.5},
        "dry_friction": {"sleeve": 10.0},
        "stops": {"arm_angle": [0.5, 0.8], "restitution": 0.2},
    },
    "spindle": {"speed": 6.0},
    "start": {"arm_angle": 0.6},
    "run": {"duration": 0.4, "accuracy": 1e-4},
}
"""A governor that falls on its stop, bounces and comes to rest: its contacts need all rules."""


@dataclass(frozen=True)
class CompiledUse:
    """What kernels are for.

    Attributes
    ----------
    name
        Engine, and kind of scene or calculation.
    n_compiled
        Number of kernels that were compiled for it; 0 if all were in the cache.
    seconds
        Wall time, s.
    """

    name: str
    n_compiled: int
    seconds: float


@dataclass(frozen=True)
class KernelCompilation:
    """What was compiled; it prints as a table.

    Attributes
    ----------
    uses
        What kernels are for, in the order of their compilation: each one counts only the kernels that those before it do not need.
    folder
        Folder of the cache.
    """

    uses: tuple[CompiledUse, ...]
    folder: Path

    __repr__ = short_repr

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the text that is printed."""
        from governor_mechanism.notebook.result_table import printed_html

        return printed_html(self)

    @property
    def n_compiled(self) -> int:
        """Number of kernels that were compiled."""
        return sum(use.n_compiled for use in self.uses)

    def __str__(self) -> str:
        """Return a table, or one sentence if there was nothing to do."""
        if self.n_compiled == 0:
            return f"all kernels are compiled already, in {self.folder}"
        rows = [(use.name, str(use.n_compiled), f"{use.seconds:.1f}", str(self.folder)) for use in self.uses if use.n_compiled]
        return format_table(["compiled for", "kernels", "seconds", "folder"], rows, "lrrl")

    def as_json(self) -> Mapping[str, object]:
        """Return the values of the table.

        Returns
        -------
        Mapping[str, object]
            The folder, and of each use its name, the number of its compiled kernels and the seconds.
        """
        return {"folder": str(self.folder), "uses": [vars(use) for use in self.uses]}


def compile_all_kernels() -> KernelCompilation:
    """Compile the kernels that are not in the cache yet.

    Result: what was compiled, and where.
    """
    folder = kernel_cache_folder()
    return KernelCompilation(tuple(_compile_for(name, calculate, folder) for name, calculate in _KERNEL_USES.items()), folder)


def _compile_for(name: str, calculate: Callable[[], object], folder: Path) -> CompiledUse:
    """Do a calculation, and count the kernels that it adds to the cache."""
    n_before, start_time = _count_kernels(folder), time.perf_counter()
    calculate()
    return CompiledUse(name, _count_kernels(folder) - n_before, time.perf_counter() - start_time)


def _count_kernels(folder: Path) -> int:
    return sum(1 for _ in folder.rglob(MACHINE_CODE_PATTERN))


def _run_smoothly(engine_name: str) -> None:
    """Run a governor without contacts for a moment, with its certificate, events and bearing reactions."""
    _run(engine_name, load_scene("porter"), SHORT_RUN_TIMES)


def _run_with_contacts(engine_name: str) -> None:
    """Run a governor that falls on its stop."""
    _run(engine_name, parse_scene_document(BOUNCING_GOVERNOR), BOUNCING_RUN_TIMES)


def _run(engine_name: str, scene: Scene, times: Sequence[float]) -> tuple[object, ...]:
    """Run a scene, and return what is computed after a run only when it is read."""
    engine, reason = select_engine(engine_name, scene, None)
    trajectory = engine.run(scene, times=times, reason=reason)
    return trajectory.events, trajectory.reactions, trajectory.energy


_KERNEL_USES: Mapping[str, Callable[[], object]] = {
    "engine reduced": partial(_run_smoothly, "reduced"),
    "engine reduced, contacts": partial(_run_with_contacts, "reduced"),
    "engine multibody": partial(_run_smoothly, "multibody"),
    "engine multibody, contacts": partial(_run_with_contacts, "multibody"),
    "engine multibody, stiff": lambda: _run("multibody", load_scene("stiff_flyball"), STIFF_RUN_TIMES),
    "engine reduced, gas in cylinders": lambda: _run("reduced", load_scene("air_engine"), SHORT_RUN_TIMES),
    "engine multibody, gas in cylinders": lambda: _run("multibody", load_scene("air_engine"), SHORT_RUN_TIMES),
    "equilibrium with several coordinates": lambda: _run("multibody", load_scene("haug_governor"), SHORT_RUN_TIMES),
    "engine impulse": lambda: _run("impulse", load_scene("porter_dry_friction"), SHORT_RUN_TIMES),
    "equilibria": lambda: find_equilibria(load_scene("porter")),
}
"""Short calculations that together use all kernels."""
