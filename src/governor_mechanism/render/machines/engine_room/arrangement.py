"""Which parts of a scene are a governed engine: found from the couplings, not from names."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, Final

from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.coupling.couplings import RatioCoupling
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction

ENGINE_MACHINE: Final = "flywheel_engine"
THROTTLE: Final = "throttle"
CUT_OFF: Final = "cut_off"
TORQUE: Final = "torque"

_OPENING_READINGS: Final = {THROTTLE: "throttle_opening", CUT_OFF: "cut_off"}
"""Reading of an engine that a control moves."""


@dataclass(frozen=True, kw_only=True)
class EngineRoomParts:
    """An engine, the governor that it drives, and what the governor controls.

    Attributes
    ----------
    engine, governor
        The parts.
    drive
        Coupling between the shaft of the engine and the spindle of the governor.
    ratio
        Ratio of the speed of the spindle to that of the shaft.
    crank_angle
        Reading of the scene that is the angle of the shaft.
    shaft_body
        Body of the scene that the shaft turns.
    governor_reading
        Reading of the scene that moves the control.
    controlled
        What the governor controls: THROTTLE, CUT_OFF or TORQUE.
    """

    engine: Part
    governor: Part
    drive: RatioCoupling
    ratio: float
    crank_angle: str
    shaft_body: str
    governor_reading: str
    controlled: str

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
