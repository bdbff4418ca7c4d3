"""Design of an engine under a governor: cylinder, flywheel, governor, throttle and dashpot for a power, a speed and a droop.

It uses the closed forms only and does not round intermediate results. The droop is the speed without load less that at full load, over
their mean.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), for engine and flywheel. L. Zehnder, Dinglers Polytechnisches Journal 225
(1877), pp. 1-14, for the governor. I. A. Wischnegradsky (Vyshnegradskii), Civilingenieur 23 (1877), pp. 95-132, for the dashpot.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form import flywheel as wheel
from governor_mechanism.closed_form import governed_engine as throttling
from governor_mechanism.closed_form.flywheel_engine import AirEngine, gas_work
from governor_mechanism.machines.flywheel_engine import MEAN
from governor_mechanism.studies.design.engine_governor import (
    DEFAULT_INPUTS,
    DashpotDesign,
    GovernedEngineInputs,
    GovernorDesign,
    design_dashpot,
    design_governor,
    validate_inputs,
)
from governor_mechanism.studies.design.skeleton import (
    Check,
    CheckedDesign,
    find_checks,
    format_rows,
    mass_ratio_limits,
    refuse,
    relative_range,
)

THROTTLE_FRACTIONS = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Loads of the table of the throttle rod, relative to the rated torque."""

LOAD_CHANGE = (1.0, 0.5)
"""Load of the scene before and after its change, relative to the rated torque."""

N_DECAYS_BEFORE, N_DECAYS_AFTER = 8.0, 16.0
"""Decay times of the slowest motion before and after the change: the start has faded to exp(-8), 3e-4. With friction it takes longer."""

MIN_TURNS, MAX_TURNS = 8, 300
"""Turns of the shaft before and after the change: enough to judge the mean speed, and no more than take a minute."""

MIN_SCENE_TURNS = 45
"""Turns of the run of a scene file, at least: the study of a change of load at a tenth of the run then has turns enough before it."""

POINTS_PER_TURN = 100
"""Reported times in a turn."""

# In some hundred turns, each with kinks of the torque, errors of the angle add up to some 1e-5 rad. An
# accuracy of 1e-4 is one of 1e-5 of the speed at 120 rpm, below a thousandth of droop and speed fluctuation.
# The mean torque has no kinks.
ACCURACY, MEAN_TORQUE_ACCURACY = 1e-4, 1e-8
"""Accuracy of the runs with the torque of every instant and with the mean torque."""


@dataclass(frozen=True, kw_only=True)
class Flywheel:
    """The flywheel: moment of inertia (kg m2), work between its extreme speeds (J), and radius (m) and mass (kg) of a thin rim."""

    inertia: float
    energy: float
    rim_radius: float
    rim_mass: float


@dataclass(frozen=True, kw_only=True)
class ThrottleSetting:
    """A position of the throttle rod: load over the rated torque, lift of the sleeve (m), opening, and speed of the shaft (rad/s)."""

    load_fraction: float
    lift: float
    opening: float
    speed: float


@dataclass(frozen=True, kw_only=True, repr=False)
class GovernedEngineDesign(CheckedDesign):
    """Result of a design in SI.

    Attributes
    ----------
    inputs
        The inputs.
    engine
        The engine under the rated torque.
    bore
        Diameter of the expansion piston, m.
    rated_torque
        Torque of the load at full load, N m.
    flywheel
        The flywheel.
    governor
        The governor and its gear.
    throttle
        Table of the throttle rod, from full load to no load.
    throttle_points
        Ends of the straight line of that table: lift (m) and opening, with the reserve of torque below full load and as much above no load.
    torque_slope
        Change of the mean torque with the lift of the sleeve, N m/m.
    dashpot
        The dashpot, and the motions of engine and governor.
    checks
        Rules that the design should keep.
    """

    inputs: GovernedEngineInputs
    engine: AirEngine
    bore: float
    rated_torque: float
    flywheel: Flywheel
    governor: GovernorDesign
    throttle: tuple[ThrottleSetting, ...]
    throttle_points: tuple[tuple[float, float], tuple[float, float]]
    torque_slope: float
    dashpot: DashpotDesign
    checks: tuple[Check, ...]

    machine = "governed_engine"
    derived = ("droop", "warnings")

    @property
    def droop(self) -> float:
        """Droop of the governor: speed without load less that at full load, over their mean."""
        return relative_range((self.governor.full_load_speed, self.governor.no_load_speed))

    @property
    def piston_speed(self) -> float:
        """Mean speed of the pistons, m/s."""
        return self.engine.stroke * self.inputs.speed / math.pi

    @property
    def motions_text(self) -> str:
        """The motions of engine and governor at each load, a line each."""
        return "\n".join(map(str, self.dashpot.motions))

    @property
    def throttle_rod(self) -> str:
        """The table of the throttle rod as text."""
        return format_rows(self.machine, "throttle", self, "lr")

    def scene_values(self, *, mean_torque: bool = False, with_resistance: bool = False) -> Mapping[str, object]:
        """Return what the scene adds: its load falls to the half; with the mean torque, as in the theory, or dry friction at the sleeve."""
        begin, end = change_times(self)
        return {
            "kind": "mean torque" if mean_torque else "designed",
            "duration": max(end, MIN_SCENE_TURNS * math.tau / self.inputs.full_load_speed),
            "output_interval": math.tau / self.inputs.speed / POINTS_PER_TURN,
            "accuracy": MEAN_TORQUE_ACCURACY if mean_torque else ACCURACY,
            "loads": LOAD_CHANGE,
            "change_time": begin,
            "gas_torque": MEAN if mean_torque else None,
            "crank_rate": self.governor.full_load_speed if mean_torque else self._start_speed(),
            "resistance": self.inputs.resistance if with_resistance else None,
        }

    def _start_speed(self) -> float:
        """Return the speed (rad/s) at the dead centre of the periodic motion at full load."""
        stored = throttling.find_stored_work_range(self.engine, throttle=self.throttle[0].opening)
        inertia = self.flywheel.inertia
        mean_speed = self.governor.full_load_speed
        lowest, _ = wheel.speed_limits(inertia=inertia, energy=stored.energy, mean_speed=mean_speed)
        return float(wheel.speed_after_work(inertia=inertia, start_speed=lowest, work=-stored.lowest))


def change_times(design: GovernedEngineDesign) -> tuple[float, float]:
    """Return the time of the change of load and that at which it is over, s: tenths of a second, by the slowest motion of the design."""
    period = math.tau / design.inputs.full_load_speed
    rate = design.dashpot.decay_rate

    def limited(duration: float) -> float:
        return math.ceil(10 * min(max(MIN_TURNS * period, duration), MAX_TURNS * period)) / 10

    # A motion that grows needs time after the change only.
    begin = limited(N_DECAYS_BEFORE / rate if rate > 0 else 0.0)
    after = limited(N_DECAYS_AFTER / abs(rate) if rate else math.inf)
    return begin, begin + after


@np.errstate(all="ignore")  # results that are not finite are refused in a sentence
def design_governed_engine(inputs: GovernedEngineInputs = DEFAULT_INPUTS) -> GovernedEngineDesign:
    """Design an engine with its flywheel, governor, throttle rod and dashpot."""
    validate_inputs(inputs)
    engine, bore = _size_cylinders(inputs)
    governor = design_governor(inputs)
    full_load, no_load = (_throttle_opening(engine, inputs, fraction) for fraction in (1.0, 0.0))
    flywheel = _size_flywheel(inputs, engine, full_load)
    torque_slope = -inputs.rated_torque / governor.sleeve_travel
    dashpot = design_dashpot(governor, flywheel.inertia, torque_slope, inputs.dashpot)
    settings = (
        ThrottleSetting(
            load_fraction=fraction,
            lift=governor.lift(fraction),
            opening=_throttle_opening(engine, inputs, fraction),
            speed=governor.shaft_speed(fraction),
        )
        for fraction in THROTTLE_FRACTIONS
    )
    return GovernedEngineDesign(
        inputs=inputs,
        engine=engine,
        bore=bore,
        rated_torque=inputs.rated_torque,
        flywheel=flywheel,
        governor=governor,
        throttle=tuple(settings),
        throttle_points=_throttle_points(governor, full_load, no_load, inputs.torque_reserve),
        torque_slope=torque_slope,
        dashpot=dashpot,
        checks=_checks(inputs, governor, dashpot),
    )


def _size_cylinders(inputs: GovernedEngineInputs) -> tuple[AirEngine, float]:
    """Return the engine that gives the rated torque and its reserve with an open throttle, and its bore (m)."""
    unit = inputs.engine(area=1.0, stroke=1.0)
    work = gas_work(unit)
    refuse("governed_engine", inputs, {"work": not work > 0}, work=work)
    volume = inputs.rated_torque * (1 + inputs.torque_reserve) / throttling.full_throttle_torque(unit)
    bore = math.cbrt(4 * volume / (math.pi * inputs.stroke_ratio))
    return inputs.engine(area=math.pi * bore**2 / 4, stroke=inputs.stroke_ratio * bore), bore


def _size_flywheel(inputs: GovernedEngineInputs, engine: AirEngine, opening: float) -> Flywheel:
    """Return the flywheel that keeps the fluctuation of speed at full load; the inertia of the governor comes on top."""
    energy = throttling.find_stored_work_range(engine, throttle=opening).energy
    full_load = {"mean_speed": inputs.full_load_speed, "coefficient": inputs.speed_fluctuation}
    inertia = float(wheel.inertia_for_coefficient(energy=energy, **full_load))
    radius = inputs.rim_speed / inputs.speed
    return Flywheel(inertia=inertia, energy=energy, rim_radius=radius, rim_mass=float(wheel.rim_mass(inertia=inertia, radius=radius)))


def _throttle_opening(engine: AirEngine, inputs: GovernedEngineInputs, fraction: float) -> float:
    return float(throttling.throttle_for_torque(engine, torque=fraction * inputs.rated_torque))


def _throttle_points(
    governor: GovernorDesign, full_load: float, no_load: float, reserve: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends (lift in m, opening) of the line through full load and no load: open, and closed as far as the reserve."""
    per_opening = governor.sleeve_travel / (full_load - no_load)
    closed = max(0.0, no_load - reserve * (full_load - no_load))
    return (
        (governor.full_load_lift - (1 - full_load) * per_opening, 1.0),
        (governor.no_load_lift + (no_load - closed) * per_opening, closed),
    )


def _checks(inputs: GovernedEngineInputs, governor: GovernorDesign, dashpot: DashpotDesign) -> tuple[Check, ...]:
    """Return the rules of the design with their numbers."""
    values = {
        "inputs": inputs,
        "dashpot": dashpot,
        "effort_ratio": governor.effort / inputs.resistance,
        "mass_ratios": mass_ratio_limits(governor.gear_ratio * governor.full_load_speed),
        "force_cure": "reduce insensitivity" if inputs.ball_mass is None else "reduce resistance, or increase ball_mass",
    }
    return find_checks("governed_engine", governor, "checks", **values)
