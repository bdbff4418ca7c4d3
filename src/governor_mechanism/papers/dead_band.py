"""The dead band of speed: Zehnder's degree of insensitivity W / (P + Q), and Dubois' regulating force K = epsilon S."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rule import (
    DURATION,
    ENGINE_SPEED,
    GOVERNOR_SPEED,
    HALF_LOAD,
    SLEEVE,
    RuleCheck,
    SteadyEngine,
    Verdict,
    find_steady_engine,
    friction_on_sleeve,
    load_step,
    with_values,
)
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.types import FloatArray

FRICTIONS = (2.0, 5.0, 10.0, 20.0)
"""Friction on the sleeve, N."""

SHOWN_FRICTION = 10.0
"""Friction of the runs that come to rest, N."""

LOADS_BEFORE = (0.25, 0.4, 0.45, 0.55, 0.6, 0.75)
"""Loads from which the engine goes to half load, over the rated torque."""

BREAKAWAY_LOAD_CHANGE = 0.3
"""Change of the load that drives the speed to the end of the band, over the rated torque."""

REST_TIME, BREAKAWAY_TIME = 40.0, 12.0
"""Duration of a run until the sleeve rests, and until it breaks away, s: some times what is needed."""

WIDTH_TOLERANCE = 1e-5
"""Relative deviation of a measured width from the static one that counts as none: ten times the accuracy of the runs."""

FIRST_ORDER_TOLERANCE = 2e-3
"""Relative deviation of a width from W / (P + Q) that counts as none: its formula neglects its square over 8, 8e-4 at most here."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DeadBandCheck(RuleCheck):
    """Speeds at which the sleeve breaks away and at which it comes to rest, under dry friction."""

    title: ClassVar[str] = "dead band of speed"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = (
        "Under a resistance W the speeds at which the sleeve rises and falls lie delta = W / (P + Q) apart, over the mean speed."
    )

    frictions: FloatArray  # friction on the sleeve, N; shape (n,)
    measured_widths: FloatArray  # difference of the speeds at which it rises and falls, over the equilibrium speed; shape (n,)
    static_widths: FloatArray  # insensitivity of the governor alone, from its equilibria; shape (n,)
    paper_widths: FloatArray  # w / (P + Q); shape (n,)
    loads_before: FloatArray  # loads from which the engine goes to half load; shape (m,)
    rest_deviations: FloatArray  # speed at rest over the equilibrium speed, minus 1; shape (m,)
    rest_friction: float  # friction of these runs, N
    band: tuple[float, float]  # ends of the insensitivity band over the equilibrium speed, minus 1, with that friction
    # times, s, and speeds over the equilibrium speed, minus 1, of the runs from the lowest and the highest
    # load
    histories: tuple[tuple[FloatArray, FloatArray], ...]

    @property
    def verdict(self) -> Verdict:
        """Holds if the widths are those of the paper and every run rests within the band."""
        static_deviation = np.abs(self.measured_widths / self.static_widths - 1).max()
        paper_deviation = np.abs(self.measured_widths / self.paper_widths - 1).max()
        is_within = (self.rest_deviations > self.band[0] - WIDTH_TOLERANCE) & (self.rest_deviations < self.band[1] + WIDTH_TOLERANCE)
        if static_deviation > WIDTH_TOLERANCE or not is_within.all():
            return Verdict.FAILS
        return Verdict.HOLDS if paper_deviation < FIRST_ORDER_TOLERANCE else Verdict.CONDITIONAL

    @property
    def finding(self) -> str:
        """Widths against the formula, and the speeds at rest."""
        deviation = np.abs(self.measured_widths / self.paper_widths - 1).max()
        widths = f"breakaway speeds with {self.frictions[0]:g} to {self.frictions[-1]:g} N are W / (P + Q) apart, within {deviation:.1g}"
        exact = np.abs(self.measured_widths / self.static_widths - 1).max()
        spread = float(np.ptp(self.rest_deviations)) / (self.band[1] - self.band[0])
        rests = (
            f"the engine rests within the band after {len(self.rest_deviations)} changes to half load, whose speeds span {spread:.0%} of it"
        )
        return f"{widths} (the exact band: within {exact:.0e}); {rests}"

    def numbers(self) -> dict[str, Any]:
        """Return widths and speeds at rest."""
        names = ("frictions", "measured_widths", "static_widths", "paper_widths", "loads_before", "rest_deviations")
        return {**{name: getattr(self, name).tolist() for name in names}, "rest_friction": self.rest_friction, "band": list(self.band)}


@dataclass(frozen=True, kw_only=True, eq=False)
class RegulatingForceCheck(RuleCheck):
    """Dead bands of a weak and a strong governor under the same friction."""

    title: ClassVar[str] = "force of the governor"
    source: ClassVar[str] = "Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), p. 618"
    statement: ClassVar[str] = (
        "A governor moves against K = epsilon S: to answer to small changes of speed it needs a large force S on its sleeve."
    )

    frictions: FloatArray  # friction on the sleeve, N; shape (n,)
    sleeve_forces: FloatArray  # static force of the governor on its sleeve, N: weak and strong governor; shape (2,)
    widths: FloatArray  # difference of the speeds at which the sleeve rises and falls, over the equilibrium speed; shape (2, n)

    @property
    def relative_widths(self) -> FloatArray:
        """Widths over K / S; shape (2, n)."""
        return np.asarray(self.widths * self.sleeve_forces[:, np.newaxis] / self.frictions)

    @property
    def verdict(self) -> Verdict:
        """Holds if all widths are K / S."""
        deviation = np.abs(self.relative_widths - 1)
        if np.all(deviation < FIRST_ORDER_TOLERANCE):
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if np.all(self.widths[1] < self.widths[0]) else Verdict.FAILS

    @property
    def finding(self) -> str:
        """Forces and widths of both governors."""
        weak, strong = self.sleeve_forces
        k = -1
        bands = f"under {self.frictions[k]:g} N the bands are {self.widths[0, k]:.2%} and {self.widths[1, k]:.2%}"
        return f"S = {weak:.0f} N (Porter) and {strong:.0f} N (Hartung): {bands}; epsilon S / K = {self._range()}"

    def _range(self) -> str:
        return f"{self.relative_widths.min():.4f} to {self.relative_widths.max():.4f}"

    def numbers(self) -> dict[str, Any]:
        """Return frictions, forces and widths."""
        return {name: getattr(self, name).tolist() for name in ("frictions", "sleeve_forces", "widths")}


def check_dead_band(
    point: SteadyEngine,  # steady state of an engine under a governor whose sleeve carries a weight
) -> DeadBandCheck:
    """Run the engine with mean torque under dry friction on its sleeve: out of the band, and to rest."""
    bands = [point.find_insensitivity_band(friction) for friction in FRICTIONS]
    shown_band = point.find_insensitivity_band(SHOWN_FRICTION)
    runs = [_run_to_rest(point, load) for load in LOADS_BEFORE]
    return DeadBandCheck(
        frictions=np.array(FRICTIONS),
        measured_widths=np.array([measure_dead_band(point, friction) for friction in FRICTIONS]),
        static_widths=np.array([float(band.insensitivity[0]) for band in bands]),
        paper_widths=np.array(FRICTIONS) / _weight_of_sleeve_and_ball(point.scene),
        loads_before=np.array(LOADS_BEFORE),
        rest_deviations=np.array([deviations[-1] for _, deviations in runs]),
        rest_friction=SHOWN_FRICTION,
        band=(float(shown_band.falling_speed[0]) / point.governor_speed - 1, float(shown_band.rising_speed[0]) / point.governor_speed - 1),
        histories=(runs[0], runs[-1]),
    )


def check_regulating_force(
    weak: SteadyEngine,
    mean_engine: Scene,
    strong_engine: Scene,  # scene of the same engine under Hartung's governor
) -> RegulatingForceCheck:
    """Measure the dead bands of a weak and a strong governor on the same engine under the same friction."""
    strong = find_steady_engine(_exchange_governor(mean_engine, strong_engine))
    strong_force = float(run_uncertified(with_values(strong.scene, {DURATION: 0.1})).readings["governor.static_sleeve_force"][0])
    return RegulatingForceCheck(
        frictions=np.array(FRICTIONS),
        sleeve_forces=np.array([_weight_of_sleeve_and_ball(weak.scene), strong_force]),
        widths=np.array([[measure_dead_band(point, friction) for friction in FRICTIONS] for point in (weak, strong)]),
    )


def measure_dead_band(
    point: SteadyEngine,  # steady state from which a change of the load drives the speed away
    friction: float,  # friction on the sleeve, N
) -> float:
    """Return the difference of the speeds at which the sleeve breaks away upwards and downwards, over the equilibrium speed."""
    changes = (-BREAKAWAY_LOAD_CHANGE, BREAKAWAY_LOAD_CHANGE)
    rising, falling = (_find_breakaway_speed(point, friction, HALF_LOAD + change) for change in changes)
    return (rising - falling) / point.governor_speed


def _find_breakaway_speed(point: SteadyEngine, friction: float, load: float) -> float:
    """Return the speed of the governor, rad/s, at which its sleeve first slips after a change of the load."""
    values = {**friction_on_sleeve(friction), **load_step(HALF_LOAD, load, 1.0), DURATION: BREAKAWAY_TIME}
    run = run_uncertified(with_values(point.scene, values))
    time = next((event.time for event in run.events if event.kind is EventKind.SLIP and event.subject == SLEEVE), None)
    if time is None:
        raise MechanismError(
            f"{point.scene.title}: {friction:g} N hold the sleeve for {BREAKAWAY_TIME:g} s at a load of {load:g}; take less friction"
        )
    # While the sleeve rests, throttle and mean torque are constant, and the speed is linear in time.
    return float(np.interp(time, run.times, run.readings[GOVERNOR_SPEED]))


def _run_to_rest(point: SteadyEngine, load_before: float) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and relative deviations of the speed of a run from a load to half load under friction."""
    before = find_steady_engine(with_values(point.scene, {"load.fraction": load_before}), {"load.fraction": load_before})
    values = {**before.start, **friction_on_sleeve(SHOWN_FRICTION), **load_step(load_before, HALF_LOAD, 1.0), DURATION: REST_TIME}
    run = run_uncertified(with_values(point.scene, values))
    return run.times, run.readings[ENGINE_SPEED] / point.engine_speed - 1


def _weight_of_sleeve_and_ball(scene: Scene) -> float:
    """Return P + Q of Zehnder's governors, N: the weight of a ball and that of the sleeve."""
    governor = scene.part_of("governor")[0]
    return float(governor.dimensions["ball_mass"] + governor.dimensions["sleeve_mass"]) * governor.gravity


def _exchange_governor(scene: Scene, other: Scene) -> Scene:
    """Return a scene with the governor and the couplings of another."""
    document = {**scene.document, "coupling": other.document["coupling"]}
    return parse_scene_document({**document, "part": {**scene.document["part"], "governor": other.document["part"]["governor"]}})
