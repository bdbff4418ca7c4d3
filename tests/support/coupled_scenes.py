"""Parts for coupled scenes: discs in fixed planes and a Porter governor on a free spindle."""

from dataclasses import replace
from typing import Any

from governor_mechanism.model.coupling.couplings import Coupling
from governor_mechanism.model.force_elements import ForceElement, Torque
from governor_mechanism.model.part import FreeSpindle, Part, Start
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_scenes import PORTER, governor_scene
from scene_parts import body_angle, body_point, fixed_part, ground_point, make_mechanism, pin, rotating_body


def discs_part(name: str, inertias: dict[str, float], *loads: ForceElement, rates: dict[str, float] | None = None) -> Part:
    """Discs of these inertias (kg m2) that turn about the origin of a fixed plane; the reading of "wheel" is "wheel_angle"."""
    bodies = [rotating_body(body, 1.0, inertia) for body, inertia in inertias.items()]
    bearings = [pin(f"bearing of {body}", ground_point(), body_point(body)) for body in inertias]
    readings = [body_angle(body, f"{body}_angle") for body in inertias]
    mechanism = make_mechanism(bodies, bearings, readings, [(0.0, 0.0, 0.0)] * len(inertias), loads=loads)
    start = Start(rates={f"{body}_angle": rate for body, rate in (rates or {}).items()})
    return replace(fixed_part(mechanism, start=start), name=name)


def engine_part(inertia: float = 2.0, rate: float | None = None, torque: InputFunction | None = None) -> Part:
    """The part "engine": a disc "crank" with the torque "load"."""
    loads = () if torque is None else (Torque(name="load", second="crank", moment=torque),)
    return discs_part("engine", {"crank": inertia}, *loads, rates=None if rate is None else {"crank": rate})


def porter_part(*, inertia: float = 0.2, start_speed: float | None = 13.0, **changes: Any) -> Part:
    """The part "governor": a Porter governor on a free spindle."""
    scene = governor_scene(PORTER, speed=0.0, angle=0.7, rate=0.1)
    return scene.with_changes(spindle=FreeSpindle(inertia=inertia, start_speed=start_speed), **changes).part


def coupled_scene(*parts: Part, couplings: tuple[Coupling, ...] = (), duration: float = 2.0) -> Scene:
    """A scene of several parts."""
    return Scene(title="test", parts=parts, couplings=couplings, run=RunSettings(duration=duration, output_interval=0.02))
