"""The designs by name, and designed engines put to the test: a change of the load, and the engine with each of some flywheels."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.controlling_force import ControllingForce, compute_controlling_force
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.equilibrium_speed import WorkingRange
from governor_mechanism.statics.speed_curve import compute_insensitivity_band, equilibrium_speed_at
from governor_mechanism.studies.design import flywheel, governed_engine, hartnell, hartung, pendulum
from governor_mechanism.studies.design.engine_governor import DEFAULT_INPUTS as ENGINE_INPUTS
from governor_mechanism.studies.design.flywheel import FlywheelDesign, PaperComparison, compare_with_paper
from governor_mechanism.studies.design.governed_engine import LOAD_CHANGE, GovernedEngineDesign, change_times
from governor_mechanism.studies.design.hartnell import HartnellDesign
from governor_mechanism.studies.design.pendulum import START_FRACTION, TARGET_FRACTION, PendulumDesign
from governor_mechanism.studies.design.skeleton import SPEED_CHANGE, Design, fill_rows, format_rows, relative_range
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine
from governor_mechanism.studies.regulation.load_change import LoadChangeStudy, study_load_change
from governor_mechanism.types import FloatArray
from governor_mechanism.units.text_table import in_unit

STATICS_TOLERANCE = 1e-8
"""Largest relative difference of a wanted number and the statics of the machine: statics are exact to about 1e-12, and the numbers of the
scene file have 15 digits; a lift, or a range of speed, of some per cent loses two."""


@dataclass(frozen=True)
class ComparedNumber(Recorded):
    """A number that the design wants, and what statics or the run of the simulated machine give; tolerance relative to `scale`."""

    quantity: str
    unit: str
    wanted: float
    found: float
    by: str
    tolerance: float
    scale: float

    derived = ("ok",)

    @property
    def ok(self) -> bool:
        """Whether the simulated machine gives the wanted number."""
        return abs(self.found - self.wanted) <= self.tolerance * self.scale

    @property
    def difference(self) -> float:
        """Difference over the scale."""
        return abs(self.found - self.wanted) / self.scale

    @property
    def verdict(self) -> str:
        """A word where the simulated machine does not give the wanted number."""
        return "" if self.ok else "DIFFERS"


COMPARED_COLUMNS = (
    Column("", "the simulated machine", "{quantity}, {unit}"),
    Column("wanted", "wanted", ".8g"),
    Column("found", "found", ".8g"),
    Column("by", "by"),
    Column("difference", "difference", ".1e"),
    Column("verdict", ""),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedMachine(Recorded):
    """What a designed machine does, and what was wanted: the numbers, and the run of its scene."""

    numbers: tuple[ComparedNumber, ...]
    run: Trajectory

    hidden = ("run",)
    derived = ("ok",)

    @property
    def ok(self) -> bool:
        """Whether all numbers are the wanted ones."""
        return all(number.ok for number in self.numbers)

    def __str__(self) -> str:
        """Return a table of the numbers."""
        return format_columns(COMPARED_COLUMNS, self.numbers)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedPendulum(SimulatedMachine):
    """What the simulated governor does, held by the resistance and then moved by the rise of the speed."""

    breakaway: tuple[float, float]  # time (s) and arm angle (rad) at which the sleeve breaks away


def compare_numbers(design: Design, **values: object) -> tuple[ComparedNumber, ...]:
    """Return the numbers of the table "simulated" of a design, in its units of the workshop."""
    return tuple(_compare(*row) for row in fill_rows(design.machine, "simulated", design, **values))


def _compare(
    quantity: str,
    unit: str,
    wanted: float,  # SI, as what is found and the scale
    found: float,
    by: str = "statics",
    scale: float | None = None,  # what the tolerance is relative to; by default the wanted number
    tolerance: float = STATICS_TOLERANCE,
) -> ComparedNumber:
    """Return a number of the simulated machine beside the wanted one, in a unit of the workshop."""
    sizes = (wanted, found, abs(wanted) if scale is None else scale)
    wanted_number, found_number, size = (in_unit(float(one), unit) for one in sizes)
    return ComparedNumber(quantity, unit, wanted_number, found_number, by, tolerance, size)


def _working_range(curve: ControllingForce) -> WorkingRange:
    if curve.working_range is None:
        raise MechanismError("the simulated machine has no working range between its stops; change the inputs of the design")
    return curve.working_range


def simulate_hartnell(design: HartnellDesign) -> SimulatedMachine:
    """Evaluate the statics of the designed machine beside the wanted numbers, and run its scene."""
    scene = design.scene
    run = run_uncertified(scene)
    numbers = compare_numbers(design, **_hartnell_statics(design, scene), **_hartnell_rest(design, scene, run))
    return SimulatedMachine(numbers=numbers, run=run)


def _hartnell_statics(design: HartnellDesign, scene: Scene) -> dict[str, object]:
    """Return what statics give at the ends of the lift, with the exact spring, and with that of the textbooks."""
    middle = compute_controlling_force(scene, [design.travel.middle_angle], speed_change=SPEED_CHANGE)
    others = tuple(effect for effect in scene.effects if not isinstance(effect, OutputSpring))
    spring = OutputSpring(reading="sleeve_lift", rate=design.textbook.rate, preload=design.textbook.forces[0])
    speeds = equilibrium_speed_at(scene.with_changes(effects=(*others, spring)), design.travel.arm_angles)
    return {"working": _working_range(middle), "static_effort": middle.effort.effort[0], "textbook_speeds": speeds}


def _hartnell_rest(design: HartnellDesign, scene: Scene, run: Trajectory) -> dict[str, object]:
    """Return where the sleeve comes to rest in the run, beside the equilibrium at its last speed."""
    speed = float(run.readings["spindle_speed"][-1])
    low, high = design.travel.arm_angles
    lifts = [one.readings["sleeve_lift"] for one in find_equilibria(scene, speed) if low <= one.coordinate <= high]
    rest = lifts[-1] if lifts else design.travel.lift
    return {"last_speed": speed, "rest_lift": rest, "last_lift": run.readings["sleeve_lift"][-1]}


def simulate_pendulum(design: PendulumDesign) -> SimulatedPendulum:
    """Evaluate the statics of the designed machine beside the wanted numbers, and run its scene."""
    scene = design.scene
    run = run_uncertified(scene)
    time = next((event.time for event in run.events if event.kind is EventKind.SLIP), None)
    if time is None:
        raise MechanismError(
            "in the simulation of the design the resistance holds the sleeve to the end; reduce resistance or insensitivity"
        )
    speed = SpindleSpeedFunction(scene.spindle)(np.array([time]))[0]
    lift = run.readings["sleeve_lift"]
    moved = {"breakaway_speed": speed, "rise": TARGET_FRACTION - START_FRACTION, "risen": (lift[-1] - lift[0]) / design.sleeve_lift}
    numbers = compare_numbers(design, **_pendulum_statics(design, scene), **moved)
    return SimulatedPendulum(numbers=numbers, run=run, breakaway=(time, design.middle_angle))


def _pendulum_statics(design: PendulumDesign, scene: Scene) -> dict[str, object]:
    """Return what statics give at the ends of the travel."""
    high = design.requirement.highest_speed
    resistance = design.requirement.resistance
    middle = [design.middle_angle]
    curve = compute_controlling_force(scene, middle, resistance=resistance)
    angles = [equilibrium.coordinate for equilibrium in find_equilibria(scene, high)]
    rising, falling = (math.sqrt(1 + sign * design.inputs.insensitivity) for sign in (1, -1))
    return {
        "ends": _working_range(curve),
        "highest_angle": min(angles, key=lambda angle: abs(angle - design.arm_angles[1]), default=math.inf),
        "static_effort": curve.effort.effort[0],
        "static_insensitivity": compute_insensitivity_band(scene, middle, resistance).insensitivity[0],
        "insensitivity": rising - falling,
        "rising_speed": high * rising,
        "falling_speed": design.requirement.lowest_speed * falling,
        "middle_rising_speed": design.equilibrium_speed(design.middle_angle) * rising,
    }


END_RATIO = 1 - 1e-9
"""Last reported time over the duration above which a run has reached its end: rounding of the times."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedEngine(Recorded):
    """What the simulated engine does when its load falls to the half, and what was wanted; speeds rad/s."""

    wanted_speeds: tuple[float, ...]  # speeds of the shaft by design at full load, half load and no load
    static_speeds: tuple[float, ...]  # the same by the statics of the simulated machine
    wanted_fluctuation: float  # coefficient of speed fluctuation by design, at full load
    mean_torque: LoadChangeStudy  # response with the torque of the air averaged over a turn, as the theory takes it
    cyclic: LoadChangeStudy  # response with the torque that follows the crank
    resisted: LoadChangeStudy  # the same with the resistance as dry friction at the sleeve

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
        full, half, _ = self.wanted_speeds
        settling_times = [f"{study.settling_time:.4g}" if study.ok else "none" for study in self.studies]
        values = {"settling_times": settling_times, "change": half / full - 1}
        names = ("mean torque", "cyclic torque", "with resistance")
        lines = [f"{name}: {study.conclusion}" for name, study in zip(names, self.studies, strict=True) if not study.ok]
        return "\n".join([format_rows("governed_engine", "simulated", self, "lr", **values), *lines])


def _sleeve_motion(study: LoadChangeStudy) -> float:
    """Return the travel of the sleeve within the last turn before the change, m."""
    times = study.run.times
    begin = study.change_times[0]
    is_last_turn = (times >= begin - math.tau / study.mean_speeds[0]) & (times <= begin)
    return float(np.ptp(study.run.readings["governor.sleeve_lift"][is_last_turn]))


def simulate_governed_engine(design: GovernedEngineDesign) -> SimulatedEngine:
    """Simulate a fall of the load from the rated torque to the half."""
    begin, end = change_times(design)
    options: tuple[dict[str, bool], ...] = {"mean_torque": True}, {}, {"with_resistance": True}
    parsed = [parse_scene_document(design.fill_scene(design.scene_values(**one))) for one in options]
    scenes = [replace(scene, run=replace(scene.run, duration=end), document={}) for scene in parsed]
    statics = GovernedEngine(scenes[0])
    fractions = (*LOAD_CHANGE, 0.0)
    mean_torque, cyclic, resisted = (study_load_change(scene, LOAD_CHANGE, at=begin) for scene in scenes)
    for study in (mean_torque, cyclic, resisted):
        if study.run.times[-1] < END_RATIO * study.run.scene.run.duration:
            raise MechanismError(f"the simulation of the design ends at {study.run.times[-1]:.4g} s: {study.run.message}")
    return SimulatedEngine(
        wanted_speeds=tuple(map(design.governor.shaft_speed, fractions)),
        static_speeds=tuple(statics.operating_point(one * design.rated_torque).shaft_speed for one in fractions),
        wanted_fluctuation=design.inputs.speed_fluctuation,
        mean_torque=mean_torque,
        cyclic=cyclic,
        resisted=resisted,
    )


@dataclass(frozen=True, kw_only=True)
class SimulatedWheel(Recorded):
    """A flywheel as it ran."""

    sized_by: str  # how it was sized
    inertia: float  # its moment of inertia, kg m2
    # lowest, highest: lowest and highest speed in the last turn, rad/s
    lowest: float
    highest: float
    coefficient: float  # coefficient of speed fluctuation, (highest - lowest) / mean speed of the design
    allowed: float  # the coefficient that the design allows
    # crank_angles, speeds: crank angle (rad) and speed (rad/s) of the shaft at the reported times; shape
    # (n,)
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

    def __str__(self) -> str:
        """Return a table of the wheels."""
        return format_columns(WHEEL_COLUMNS, self)


def simulate_wheels(design: FlywheelDesign, comparison: PaperComparison | None = None) -> SimulatedWheels:
    """Simulate the engine over two turns with the flywheel of a design, or with those of a comparison, by each of the paper's sums."""
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


@dataclass(frozen=True)
class Procedure:
    """How a machine is designed."""

    inputs: Any  # its default inputs
    design: Callable[[Any], Design]  # function of the inputs that returns the design
    # function of the design and of the paper's numbers, or None, that returns how the machine runs; None:
    # it is not simulated
    simulate: Callable[[Any, Any], Any] | None = None
    # function that returns the paper's numbers beside the recomputed ones, if the default inputs are those
    # of a paper
    compare: Callable[[], Any] | None = None


@dataclass(frozen=True, kw_only=True)
class DesignReport(Result):
    """A design with what was simulated of it, and with the numbers of a paper."""

    machine: str  # name of the procedure
    design: Design
    simulated: Any = None  # how it runs; None if it is not simulated
    paper: Any = None  # the numbers of the paper, if the inputs are those of a paper, or None

    figure_set = "render.figures.designs.design_figures"
    optional = ("simulated", "paper")

    @property
    def ok(self) -> bool:
        """Whether the simulated machine does what was wanted."""
        return self.simulated.ok if self.simulated else True

    def __str__(self) -> str:
        """Return the numbers of the paper, the design, and how it runs."""
        paper = [f"{self.paper}\n"] if self.paper else []
        simulated = [f"\n{self.simulated}"] if self.simulated else []
        return "\n".join([*paper, f"{self.design}", *simulated])


PROCEDURES: Mapping[str, Procedure] = {
    "hartung": Procedure(hartung.PAPER_INPUTS, hartung.design_hartung, compare=hartung.compare_with_paper),
    "flywheel": Procedure(flywheel.PAPER_INPUTS, flywheel.design_flywheel, simulate_wheels, compare_with_paper),
    "governed-engine": Procedure(ENGINE_INPUTS, governed_engine.design_governed_engine, lambda design, _: simulate_governed_engine(design)),
    "pendulum": Procedure(pendulum.DEFAULT_INPUTS, pendulum.design_pendulum, lambda design, _: simulate_pendulum(design)),
    "hartnell": Procedure(hartnell.DEFAULT_INPUTS, hartnell.design_hartnell, lambda design, _: simulate_hartnell(design)),
}
"""The procedures by the names of the command line."""


def report_design(design: Design) -> DesignReport:
    """Simulate a design as its procedure does, and compare it with the paper if its inputs are those of the paper."""
    machine = design.machine.replace("_", "-")
    procedure = PROCEDURES[machine]
    paper = procedure.compare() if procedure.compare and design.inputs == procedure.inputs else None
    simulated = procedure.simulate(design, paper) if procedure.simulate else None
    return DesignReport(machine=machine, design=design, simulated=simulated, paper=paper)
