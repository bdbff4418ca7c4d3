"""Simulation against closed forms, and against kernels of the caller's own."""

from __future__ import annotations

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.verification import parabolic, pendulum, slide_valve, slider_crank
from governor_mechanism.verification.hartung import statics as hartung
from governor_mechanism.verification.report import CheckReport, Row

CHECKS = {
    "pendulum_governor": pendulum.findings,
    "parabolic_governor": parabolic.findings,
    "hartung": hartung.findings,
    "slide_valve": slide_valve.findings,
    "slider_crank": slider_crank.findings,
}
"""The closed-form checks of each machine: scene -> rows, and notes (strings) on what was left out."""


def check_against_closed_forms(scene: Scene) -> CheckReport:
    """Compare the simulation of a scene with every closed form that applies to its machine."""
    machine = scene.part.machine
    if machine not in CHECKS:
        raise MechanismError(f"no closed form is written for machine {machine!r}; those with one are {sorted(CHECKS)}")
    found = list(CHECKS[machine](scene))
    return CheckReport(
        title=scene.title,
        against="closed form",
        rows=tuple(row for row in found if isinstance(row, Row)),
        notes=tuple(note for note in found if isinstance(note, str)),
    )


__all__ = ["CheckReport", "Row", "check_against_closed_forms"]
