"""Designed engines put to the test: a change of the load under the governor, and the engine with each of some flywheels."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column, Recorded, format_columns
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.design.flywheel import FlywheelDesign
from governor_mechanism.studies.design.flywheel_paper import PaperComparison
from governor_mechanism.studies.design.governed_engine import LOAD_CHANGE, GovernedEngineDesign, change_times
from governor_mechanism.studies.design.skeleton import relative_range
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine
from governor_mechanism.studies.regulation.load_change import LoadChangeStudy, study_load_change
from governor_mechanism.types import FloatArray
from governor_mechanism.units.places import in_unit
from governor_mechanism.units.text_table import format_table

END_RATIO = 1 - 1e-9
"""Last reported time over the duration above which a run has reached its end: rounding of the times."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedEngine(Recorded):
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

    derived = ("wanted_droop", "static_droop", "fluctuation", "sleeve_motions")

    @property
    def studies(self) -> tuple[LoadChangeStudy, LoadChangeStudy, LoadChangeStudy]:
        """The three responses."""
        return self.mean_torque, self.cyclic, self.resisted

    @property
    def sleeve_motions(self) -> tuple[float, ...]:
        """Travel of the sleeve within the last turn before the change, in each of the responses, m."""
        return tuple(map(_sleeve_motion, self.studies))

    @property
    def wanted_droop(self) -> float:
        """Droop by design, from full load to no load."""
        return relative_range((self.wanted_speeds[0], self.wanted_speeds[-1]))

    @property
    def static_droop(self) -> float:
        """Droop by the statics of the simulated machine, from full load to no load."""
        return relative_range((self.static_speeds[0], self.static_speeds[-1]))

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation that the simulation shows at full load."""
        return self.cyclic.fluctuations[0]

    @property
    def ok(self) -> bool:
        """Whether the speed settles in all responses."""
        return all(study.ok for study in self.studies)

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
            yield f"mean speed at {label} load, rpm", *(f"{in_unit(speed, 'rpm'):.4f}" for speed in speeds)
        yield "droop from full to no load, by statics", f"{self.wanted_droop:.6%}", f"{self.static_droop:.6%}", "", ""
        yield "change of speed", f"{half / full - 1:.4%}", *(f"{study.droop:.4%}" for study in studies)
        yield "overshoot, of the change", "", *(f"{study.overshoot:.2%}" for study in studies)
        yield "settling time (5 %), s", "", *(f"{study.settling_time:.4g}" if study.ok else "none" for study in studies)
        yield "speed fluctuation at full load", f"{self.wanted_fluctuation:.4%}", "", *(f"{one.fluctuations[0]:.4%}" for one in studies[1:])
        yield "sleeve motion in a turn at full load, mm", "", *(f"{1e3 * motion:.3f}" for motion in self.sleeve_motions)


def _sleeve_motion(study: LoadChangeStudy) -> float:
    """Return the travel of the sleeve within the last turn before the change, m."""
    times = study.run.times
    begin = study.change_times[0]
    is_last_turn = (times >= begin - math.tau / study.mean_speeds[0]) & (times <= begin)
    return float(np.ptp(study.run.readings["governor.sleeve_lift"][is_last_turn]))


def simulate_governed_engine(design: GovernedEngineDesign) -> SimulatedEngine:
    """Simulate a fall of the load from the rated torque to the half.

    Result: the responses with the mean torque of the air, with its cyclic torque, and with the resistance at
    the sleeve too. Raises MechanismError if a run does not reach its end, or the machine has no equilibrium.
    """
    begin, end = change_times(design)
    options: tuple[dict[str, bool], ...] = {"mean_torque": True}, {}, {"with_resistance": True}
    parsed = [parse_scene_document(design.fill_scene(design.scene_values(**one))) for one in options]
    scenes = [replace(scene, run=replace(scene.run, duration=end), document={}) for scene in parsed]
    statics = GovernedEngine(scenes[0])
    fractions = (*LOAD_CHANGE, 0.0)
    static_full, static_half, static_none = (statics.operating_point(one * design.rated_torque).shaft_speed for one in fractions)
    full, half, none = (design.governor.shaft_speed(fraction) for fraction in fractions)
    mean_torque, cyclic, resisted = (study_load_change(scene, LOAD_CHANGE, at=begin) for scene in scenes)
    for study in (mean_torque, cyclic, resisted):
        if study.run.times[-1] < END_RATIO * study.run.scene.run.duration:
            raise MechanismError(f"the simulation of the design ends at {study.run.times[-1]:.4g} s: {study.run.message}")
    return SimulatedEngine(
        wanted_speeds=(full, half, none),
        static_speeds=(static_full, static_half, static_none),
        wanted_fluctuation=design.inputs.speed_fluctuation,
        mean_torque=mean_torque,
        cyclic=cyclic,
        resisted=resisted,
    )


@dataclass(frozen=True, kw_only=True)
class SimulatedWheel(Recorded):
    """A flywheel as it ran.

    Attributes
    ----------
    sized_by
        How it was sized.
    inertia
        Its moment of inertia, kg m2.
    lowest, highest
        Lowest and highest speed in the last turn, rad/s.
    coefficient
        Coefficient of speed fluctuation, (highest - lowest) / mean speed of the design.
    allowed
        The coefficient that the design allows.
    crank_angles, speeds
        Crank angle (rad) and speed (rad/s) of the shaft at the reported times; shape (n,).
    """

    sized_by: str
    inertia: float
    lowest: float
    highest: float
    coefficient: float
    allowed: float
    crank_angles: FloatArray
    speeds: FloatArray

    derived = ("excess",)

    @property
    def excess(self) -> float:
        """Coefficient relative to the allowed one."""
        return self.coefficient / self.allowed


WHEEL_COLUMNS = (
    Column("sized_by", "simulated over two turns"),
    Column("inertia", "kg m2", ".6g"),
    Column("lowest", "lowest, rad/s", ".6g"),
    Column("highest", "highest, rad/s", ".6g"),
    Column("coefficient", "fluctuation", ".6g"),
    Column("excess", "times the allowed", ".5g"),
)


class SimulatedWheels(tuple[SimulatedWheel, ...]):
    """Flywheels as they ran."""

    ok = True

    def as_json(self) -> list[Mapping[str, Any]]:
        """Return the wheels as plain values."""
        return [wheel.as_json() for wheel in self]

    def __str__(self) -> str:
        """Return a table of the wheels."""
        return format_columns(WHEEL_COLUMNS, self)


def simulate_wheels(
    design: FlywheelDesign,
    comparison: PaperComparison | None = None,  # the paper's numbers, if the design is that of the paper
) -> SimulatedWheels:
    """Simulate the engine over two turns with the flywheel of a design, or with those by each of the paper's sums.

    Result: how the flywheels ran. Raises MechanismError if a run does not reach its end, or the shaft makes
    no complete turn.
    """
    wheels = [(wheel.sized_by, wheel.inertia) for wheel in comparison.wheels] if comparison else [("design", design.inertia)]
    return SimulatedWheels(_simulate_wheel(design, sized_by, inertia) for sized_by, inertia in wheels)


def _simulate_wheel(design: FlywheelDesign, sized_by: str, inertia: float) -> SimulatedWheel:
    scene = parse_scene_document(design.fill_scene(design.scene_values(inertia)))
    engine, reason = select_engine(scene.run.engine, scene)
    run = engine.run(scene, reason=reason)
    extremes = run.speed_fluctuations.get("crank_angle")
    if not run.outcome.ok or extremes is None:
        raise MechanismError(f"the simulation of the flywheel of {inertia:.6g} kg m2 failed: {run.message}")
    return SimulatedWheel(
        sized_by=sized_by,
        inertia=inertia,
        lowest=extremes.lowest,
        highest=extremes.highest,
        coefficient=(extremes.highest - extremes.lowest) / design.inputs.speed,
        allowed=design.coefficient,
        crank_angles=np.asarray(run.readings["crank_angle"]),
        speeds=np.asarray(run.readings["shaft_speed"]),
    )
