"""Studies of single governors by name: each of one scene, or of some to compare, with one figure of all."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.studies.regulation import cyclic_irregularity, speed_changes

STUDIES: Mapping[str, tuple[tuple[str, ...], Callable[[Scene], Any]]] = {
    "cyclic": (("porter_cyclic",), lambda scene: cyclic_irregularity.study_cyclic_motion(scene, cyclic_irregularity.FLUCTUATION_RATIOS)),
    "clearance": (
        ("porter_clearance", "watt_clearance"),
        lambda scene: cyclic_irregularity.study_clearance(scene, cyclic_irregularity.CLEARANCES),
    ),
    "settling": (("porter_load_step",), lambda scene: speed_changes.study_settling(scene, speed_changes.DAMPING_COEFFICIENTS)),
    "jump": (("watt_improved",), lambda scene: speed_changes.study_fold_jump(scene, speed_changes.RAMP_RATES)),
}
"""Shipped scenes and function of each study, by its name."""


@dataclass(frozen=True, eq=False)
class GovernorStudies(Result):
    """The same study of the governors of some scenes."""

    study: str  # name of the study
    results: tuple[Any, ...]  # what it gives for each governor

    record = ("study", "conclusions", "results")
    figure = "render.figures.regulation.governor_studies_figure"

    @property
    def conclusions(self) -> tuple[str, ...]:
        """A sentence on each governor."""
        return tuple(result.conclusion for result in self.results)

    def __str__(self) -> str:
        """Return the conclusions."""
        return "\n".join(self.conclusions)


def study_governors(
    name: str,  # name of the study
    scenes: Sequence[Scene] | None,  # the scenes; the shipped ones of the study if None
) -> GovernorStudies:
    """Make a study of the governor of each scene."""
    shipped, make_study = STUDIES[name]
    studied = [load_scene(one) for one in shipped] if scenes is None else scenes
    return GovernorStudies(name, tuple(make_study(rotating_part_alone(scene)) for scene in studied))
