"""Which parts of a scene are a governed engine, found from the couplings, not from names; its torques; and the places in its drawing."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.coupling.couplings import RatioCoupling
from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.interpolation import integrate_samples, interpolate_samples
from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2, round_step
from governor_mechanism.render.part_run import sample_input
from governor_mechanism.types import FloatArray

ENGINE_MACHINE: Final = "flywheel_engine"
THROTTLE: Final = "throttle"
CUT_OFF: Final = "cut_off"
TORQUE: Final = "torque"

_OPENING_READINGS: Final = {THROTTLE: "throttle_opening", CUT_OFF: "cut_off"}
"""Reading of an engine that a control moves."""


@dataclass(frozen=True, kw_only=True)
class EngineRoomParts:
    """An engine, the governor that it drives, and what the governor controls."""

    # engine, governor: the parts
    engine: Part
    governor: Part
    drive: RatioCoupling  # coupling between the shaft of the engine and the spindle of the governor
    ratio: float  # ratio of the speed of the spindle to that of the shaft
    crank_angle: str  # reading of the scene that is the angle of the shaft
    shaft_body: str  # body of the scene that the shaft turns
    governor_reading: str  # reading of the scene that moves the control
    controlled: str  # what the governor controls: THROTTLE, CUT_OFF or TORQUE

    @property
    def opening_reading(self) -> str | None:
        """Reading of the engine, by plain name, that is the opening of its throttle or its cut-off; None if its torque is controlled."""
        return _OPENING_READINGS.get(self.controlled)

    @property
    def break_time(self) -> float | None:
        """Time at which the belt to the governor breaks, s; None if it never does."""
        return getattr(self.drive, "until", None)


def find_governed_engine(scene: Scene) -> EngineRoomParts | None:
    """Return the governed engine that a scene consists of, or None.

    It has two parts. One turns with a spindle, which a gear or belt couples to a shaft of the other. A load of the other part follows a
    reading of the first. The other part is an engine with a flywheel, or a flywheel alone.
    """
    if len(scene.parts) != 2:
        return None
    for governor, engine in (scene.parts, scene.parts[::-1]):
        if governor.turns and not engine.turns and (governed := _find_drive(scene, engine, governor)):
            return governed
    return None


def _find_drive(scene: Scene, engine: Part, governor: Part) -> EngineRoomParts | None:
    """Return the governed engine of an engine and a governor, or None."""
    spindle = f"{governor.name}.{SPINDLE_ANGLE}"
    controls = dict(_controls(scene, engine, governor))
    for drive in scene.couplings:
        if not isinstance(drive, RatioCoupling) or spindle not in (drive.first, drive.second) or not controls:
            continue
        angle, ratio = (drive.first, drive.ratio) if drive.second == spindle else (drive.second, 1.0 / drive.ratio)
        shaft = next((one for one in scene.mechanism.readings if one.name == angle), None)
        is_engine = engine.machine == ENGINE_MACHINE or len(engine.mechanism.bodies) == 1
        if is_engine and isinstance(shaft, BodyAngle) and angle.startswith(f"{engine.name}."):
            # A throttle that acts on a torque is a throttle.
            controlled = next(one for one in (THROTTLE, CUT_OFF, TORQUE) if one in controls)
            return EngineRoomParts(
                engine=engine,
                governor=governor,
                drive=drive,
                ratio=ratio,
                crank_angle=angle,
                shaft_body=shaft.body,
                governor_reading=controls[controlled],
                controlled=controlled,
            )
    return None


def _controls(scene: Scene, engine: Part, governor: Part) -> Iterator[tuple[str, str]]:
    """Yield what each reading of the governor controls on the engine, with that reading."""
    for element in scene.mechanism.force_elements:
        if not element.name.startswith(f"{engine.name}."):
            continue
        for one in fields(element):
            load = getattr(element, one.name)
            if isinstance(load, InputFunction):
                followed = [function.reading for function in governor_functions(load, governor)]
                yield from ((_controlled_quantity(element, one.name), reading) for reading in followed)


def governor_functions(load: InputFunction, governor: Part) -> list[Any]:
    """Return the functions of readings of the governor in a load, added ones and factors."""
    return [function for function in (*load.functions, *load.factors) if function.reading.startswith(f"{governor.name}.")]


def _controlled_quantity(element: Any, field_name: str) -> str:
    """Return what a field of a force element is: THROTTLE, CUT_OFF or TORQUE."""
    own_name = element.name.rpartition(".")[2]
    parameters = {field: parameter for parameter, field in element.controlled_parameters.items()}
    quantity = parameters.get(field_name, own_name if field_name == THROTTLE else field_name)
    return quantity if quantity in _OPENING_READINGS else TORQUE


_TAIL_FRACTION, _BAND_FRACTION = 0.1, 0.03
"""Last part of a run that tells where a reading settles, and how far it may be outside that range, relative to the range of the run."""
_HUNTING_FRACTION = 0.3
"""Range of the last part of a run, relative to that of the run, above which the governor hunts."""
_MARGIN_FRACTION, _MIN_MARGIN = 0.3, 2.0
"""Time that is shown after the governor has settled: relative to the time before, and at least (s)."""


def settled_time(run: Trajectory, governed: EngineRoomParts) -> float:
    """Return a round time (s) soon after the governor has settled for the rest of the run, or the end of the run if it does not."""
    values, times = run.readings[governed.governor_reading], run.times
    tail = values[-max(round(_TAIL_FRACTION * len(values)), 1) :]
    band = _BAND_FRACTION * float(np.ptp(values))
    is_hunting = bool(np.ptp(tail) > _HUNTING_FRACTION * np.ptp(values))
    outside = np.flatnonzero((values < tail.min() - band) | (values > tail.max() + band))
    first, last = float(times[0]), float(times[-1])
    if is_hunting or not len(outside) or last - first < 2 * _MIN_MARGIN:
        return last
    settled = float(times[outside[-1]]) - first
    step = round_step(last - first, 20)
    return min(first + step * math.ceil((settled + max(_MARGIN_FRACTION * settled, _MIN_MARGIN)) / step), last)


MIN_SAMPLES_PER_TURN = 12
"""Reported times in a turn from which on the mean over a turn is good to some percent."""


def load_torque(run: Trajectory, governed: EngineRoomParts) -> FloatArray:
    """Return the torque (n,) with which the load resists the shaft, N m: that of the engine's reading, or what no governor moves."""
    reading = run.readings.get(f"{governed.engine.name}.load_torque")
    if reading is not None:
        return reading
    return -np.asarray(sum((sign * _given_torque(run, governed, load) for sign, load in _torques(run, governed)), np.zeros(len(run.times))))


def engine_torque(run: Trajectory, governed: EngineRoomParts) -> tuple[FloatArray, FloatArray]:
    """Return times (m,) s and the torque of the engine there, N m: the mean over a turn, and so without half a turn at both ends.

    The mean over a turn follows from the work of the load and the energy of the engine, which few reported times give well; the small
    torque that drives the governor is taken off. A torque that does not come from gas in cylinders is shown as it is, and so is one with
    few reported times in a turn.
    """
    torque, stored = (run.readings.get(f"{governed.engine.name}.{name}") for name in ("gas_torque", "stored_work"))
    if torque is None:
        whole = sum((sign * sample_input(run, load) for sign, load in _torques(run, governed)), np.zeros(len(run.times)))
        return run.times, whole + load_torque(run, governed)
    if stored is None:
        return run.times, torque
    work = stored + integrate_samples(run.readings[governed.crank_angle], load_torque(run, governed))
    changes = _changes_over_turns(run, governed, work, torque)
    return (run.times, torque) if changes is None else (changes[0], changes[1] / (2 * np.pi))


def mean_speed(run: Trajectory, governed: EngineRoomParts) -> tuple[FloatArray, FloatArray] | None:
    """Return times (m,) s and the mean speed of the turn around each, rad/s.

    None for a torque that does not come from gas in cylinders, for few turns, and for few reported times in a turn.
    """
    if f"{governed.engine.name}.gas_torque" not in run.readings or not bool(np.all(run.rates[governed.crank_angle] > 0)):
        return None
    durations = _changes_over_turns(run, governed, run.times, 1.0 / run.rates[governed.crank_angle])
    return None if durations is None else (durations[0], 2 * np.pi / durations[1])


def _changes_over_turns(
    run: Trajectory, governed: EngineRoomParts, values: FloatArray, slopes: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return times (m,) s, half a turn or more from both ends, and by how much values (n,) change over the turn around each."""
    # `slopes` (n,) are their derivatives with respect to the crank angle, 1/rad. Few turns, or few reported times in one, give None.
    angles = run.readings[governed.crank_angle]
    turns = float(np.ptp(angles)) / (2 * np.pi)
    if turns < 2 or len(angles) < MIN_SAMPLES_PER_TURN * turns or not bool(np.all(np.diff(angles) > 0)):
        return None
    inside = (angles >= angles[0] + np.pi) & (angles <= angles[-1] - np.pi)
    before, after = (interpolate_samples(angles, values, slopes, angles[inside] + half_turn) for half_turn in (-np.pi, np.pi))
    return run.times[inside], after - before


def load_steps(run: Trajectory, governed: EngineRoomParts) -> list[float]:
    """Return the times within the run at which the load jumps, s."""
    steps = {end for _, load in _torques(run, governed) for start, end in pairwise(load.times) if start == end}
    return sorted(time for time in steps if run.times[0] < time < run.times[-1])


def _torques(run: Trajectory, governed: EngineRoomParts) -> list[tuple[float, InputFunction]]:
    """Return the torques on the shaft, each with 1 if it acts on the shaft in its sense, and else -1."""
    elements = [element for element in run.scene.mechanism.force_elements if isinstance(element, Torque)]
    return [
        (1.0 if element.second == governed.shaft_body else -1.0, element.moment)
        for element in elements
        if governed.shaft_body in (element.first, element.second)
    ]


def _given_torque(run: Trajectory, governed: EngineRoomParts, load: InputFunction) -> FloatArray:
    """Return what is left of a torque (n,) without the functions of the governor, N m; nothing of one that the governor scales."""
    followed = governor_functions(load, governed.governor)
    if any(factor in followed for factor in load.factors):
        return np.zeros(len(run.times))
    own_functions = tuple(function for function in load.functions if function not in followed)
    if not own_functions and not load.factors:
        return np.asarray(CubicTimeFunction(load)(run.times))
    return sample_input(run, replace(load, functions=own_functions))


WIDTH: Final = 556.0
HEIGHT: Final = 392.0
FLOOR: Final = 14.0

CRANK_RADIUS: Final = 46.0
"""Length of the drawn crank, to which the scale of an engine refers."""
ENGINE_LEFT: Final = 8.0

GOVERNOR_AXIS: Final = 290.0
GOVERNOR_HALF_WIDTH: Final = 92.0
GOVERNOR_BASE: Final = 176.0
GOVERNOR_TOP: Final = HEIGHT - 3.0
LAYSHAFT: Final[Vec2] = (GOVERNOR_AXIS, 148.0)
"""Shaft of the pulley that turns the spindle through bevel gears."""
MIN_PULLEY, MAX_PULLEY = 7.0, 18.0
"""Radii between which the pulleys to the governor are drawn."""

CYLINDER_END, CYLINDER_BASE = 511.7, 78.4
"""Right end and lower edge of a horizontal cylinder."""
PIPE_AXIS: Final = 530.0
PIPE_HALF_WIDTH: Final = 12.0
PIPE_WALL: Final = 2.5

LINE_SHAFT: Final[Vec2] = (42.0, 334.0)
LOAD_PULLEY: Final = 20.0
"""Radius of the pulleys to the line shaft."""
BRAKE_ARM: Final = 104.0
"""Length of the lever of the brake."""
MAX_WEIGHT_HEIGHT, WEIGHT_WIDTH = 70.0, 36.0
"""Size of the weight on the brake at the largest load."""

SLIDE_SCALE: Final[BoundingBox] = (408.2, 500.2, 124.4, 138.4)
"""Left and right end of a scale, which is the stroke of a horizontal cylinder, and lower and upper edge of the slide on it."""
