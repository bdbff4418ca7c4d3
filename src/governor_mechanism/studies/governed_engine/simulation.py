"""A designed engine put to the test: the simulated change of load beside what the design wants."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.governed_engine.results import GovernedEngineDesign
from governor_mechanism.studies.governed_engine.scene_export import LOAD_CHANGE, change_times, export_scene_document
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine
from governor_mechanism.studies.regulation.load_change import LoadChangeStudy, study_load_change
from governor_mechanism.units.text_table import format_table

END_RATIO = 1 - 1e-9
"""Last reported time over the duration above which a run has reached its end: rounding of the times."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedDesign:
    """What the simulated engine does when its load falls to the half, and what was wanted; speeds rad/s.

    Attributes
    ----------
    wanted_speeds
        Speeds of the shaft by design at full load, half load and no load.
    static_speeds
        The same by the statics of the simulated machine.
    wanted_fluctuation
        Coefficient of speed fluctuation by design, at full load.
    mean_torque
        Response with the torque of the air averaged over a turn, as the theory takes it.
    cyclic
        Response with the torque that follows the crank.
    resisted
        The same with the resistance as dry friction at the sleeve.
    """

    wanted_speeds: tuple[float, float, float]
    static_speeds: tuple[float, float, float]
    wanted_fluctuation: float
    mean_torque: LoadChangeStudy
    cyclic: LoadChangeStudy
    resisted: LoadChangeStudy

    @property
    def studies(self) -> tuple[LoadChangeStudy, LoadChangeStudy, LoadChangeStudy]:
        """The three responses."""
        return self.mean_torque, self.cyclic, self.resisted

    @property
    def sleeve_motions(self) -> tuple[float, float, float]:
        """Travel of the sleeve within the last turn before the change, in each of the responses, m."""
        first, second, third = (_sleeve_motion(study) for study in self.studies)
        return first, second, third

    @property
    def wanted_droop(self) -> float:
        """Droop by design, from full load to no load."""
        return _droop(self.wanted_speeds[0], self.wanted_speeds[-1])

    @property
    def static_droop(self) -> float:
        """Droop by the statics of the simulated machine, from full load to no load."""
        return _droop(self.static_speeds[0], self.static_speeds[-1])

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation that the simulation shows at full load."""
        return self.cyclic.fluctuations[0]

    @property
    def ok(self) -> bool:
        """Whether the speed settles in all responses."""
        return all(study.ok for study in self.studies)

    def as_json(self) -> dict[str, Any]:
        """Return all numbers, without the runs."""
        studies = {name: getattr(self, name).as_json() for name in ("mean_torque", "cyclic", "resisted")}
        derived = {name: getattr(self, name) for name in ("wanted_droop", "static_droop", "fluctuation", "sleeve_motions")}
        return plain_record(self, **studies, **derived)

    def __str__(self) -> str:
        """Return a table of the wanted and the simulated numbers."""
        header = ("load falls from the whole to the half", "wanted", "mean torque", "cyclic torque", "with resistance")
        lines = [format_table(header, list(self._rows()), "lrrrr")]
        lines += [f"{name}: {study.conclusion}" for name, study in zip(header[2:], self.studies, strict=True) if not study.ok]
        return "\n".join(lines)

    def _rows(self) -> Iterator[Sequence[str]]:
        """Yield the rows of the table: label, wanted, and what each run shows."""
        studies = self.studies
        full, half, _ = self.wanted_speeds
        for label, wanted, k in (("full", full, 0), ("half", half, 2)):
            speeds = (wanted, *(study.mean_speeds[k] for study in studies))
            yield f"mean speed at {label} load, rpm", *(f"{speed * 30 / math.pi:.4f}" for speed in speeds)
        yield "droop from full to no load, by statics", f"{self.wanted_droop:.6%}", f"{self.static_droop:.6%}", "", ""
        yield "change of speed", f"{half / full - 1:.4%}", *(f"{study.droop:.4%}" for study in studies)
        yield "overshoot, of the change", "", *(f"{study.overshoot:.2%}" for study in studies)
        yield "settling time (5 %), s", "", *(f"{study.settling_time:.4g}" if study.ok else "none" for study in studies)
        yield "speed fluctuation at full load", f"{self.wanted_fluctuation:.4%}", "", *(f"{one.fluctuations[0]:.4%}" for one in studies[1:])
        yield "sleeve motion in a turn at full load, mm", "", *(f"{1e3 * motion:.3f}" for motion in self.sleeve_motions)


def _sleeve_motion(study: LoadChangeStudy) -> float:
    """Return the travel of the sleeve within the last turn before the change, m."""
    times, begin = study.run.times, study.change_times[0]
    period = math.tau / study.mean_speeds[0]
    is_last_turn = (times >= begin - period) & (times <= begin)
    return float(np.ptp(study.run.readings["governor.sleeve_lift"][is_last_turn]))


def _droop(full_load_speed: float, no_load_speed: float) -> float:
    return 2 * (no_load_speed - full_load_speed) / (no_load_speed + full_load_speed)


def simulate_design(design: GovernedEngineDesign) -> SimulatedDesign:
    """Simulate a fall of the load from the rated torque to the half.

    Parameters
    ----------
    design
        The design.

    Returns
    -------
    SimulatedDesign
        The responses with the mean torque of the air, with its cyclic torque, and with the resistance at the sleeve too.

    Raises
    ------
    MechanismError
        If a run does not reach its end, or the machine has no equilibrium.
    """
    begin, end = change_times(design)
    options: tuple[dict[str, bool], ...] = {"mean_torque": True}, {}, {"with_resistance": True}
    parsed = [parse_scene_document(export_scene_document(design, **one)) for one in options]
    scenes = [replace(scene, run=replace(scene.run, duration=end), document={}) for scene in parsed]
    statics = GovernedEngine(scenes[0])
    fractions = (*LOAD_CHANGE, 0.0)
    full, half, none = (statics.operating_point(fraction * design.rated_torque).shaft_speed for fraction in fractions)
    wanted_full, wanted_half, wanted_none = (design.governor.shaft_speed(fraction) for fraction in fractions)
    mean_torque, cyclic, resisted = (study_load_change(scene, LOAD_CHANGE, at=begin) for scene in scenes)
    for study in (mean_torque, cyclic, resisted):
        if study.run.times[-1] < END_RATIO * study.run.scene.run.duration:
            raise MechanismError(f"the simulation of the design ends at {study.run.times[-1]:.4g} s: {study.run.message}")
    return SimulatedDesign(
        wanted_speeds=(wanted_full, wanted_half, wanted_none),
        static_speeds=(full, half, none),
        wanted_fluctuation=design.inputs.speed_fluctuation,
        mean_torque=mean_torque,
        cyclic=cyclic,
        resisted=resisted,
    )
