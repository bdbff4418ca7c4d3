"""The closed-form checks of each machine."""

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.verification.laws import check_law
from governor_mechanism.verification.machines import (
    flywheel_engine,
    hartnell,
    hartung,
    parabolic,
    pendulum,
    proell,
    slide_valve,
    slider_crank,
    stephenson,
)
from governor_mechanism.verification.report import CheckReport, ComparisonRow

CHECKS = {
    "pendulum_governor": pendulum.check_pendulum_governor,
    "parabolic_governor": parabolic.check_parabolic_governor,
    "proell": proell.check_proell_governor,
    "hartnell": hartnell.check_hartnell_governor,
    "hartung": hartung.check_hartung_governor,
    "slide_valve": slide_valve.check_slide_valve,
    "slider_crank": slider_crank.check_slider_crank,
    "stephenson": stephenson.check_stephenson_gear,
    "flywheel_engine": flywheel_engine.check_flywheel_engine,
}
"""Closed-form checks by machine; each maps a scene to comparison rows and notes on what is left out."""


def check_against_closed_forms(scene: Scene) -> CheckReport:
    """Compare the simulation of a scene with every closed form that applies to its machine, or with the law that its file states."""
    machine = scene.part.machine
    if scene.part.law is not None:
        return check_law(scene)
    if machine not in CHECKS:
        raise MechanismError(
            f"there is no closed form for machine {machine!r}; there is one for {', '.join(sorted(CHECKS))}. "
            "A custom machine may state a law of its own in [law]. "
            "A formula of your own is compared by --kernel on the command line, or the argument kernel in Python"
        )
    results = list(CHECKS[machine](scene))
    return CheckReport(
        title=scene.title,
        against="closed form",
        rows=tuple(row for row in results if isinstance(row, ComparisonRow)),
        notes=tuple(note for note in results if isinstance(note, str)),
    )
