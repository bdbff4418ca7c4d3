"""Description of a scene: what its parts are, what acts on them, what couples them, and which engines can run it."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.selection import ENGINES, select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver, mobility_of
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_readings
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.coupling.couplings import ControlCoupling, Coupling, GearCoupling, LoadCoupling, RatioCoupling
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.part import FreeSpindle, Part, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.custom.dimensions import dimensions_of, document_of_part, is_expression
from governor_mechanism.scenes.described_scene import (
    DescribedItem,
    DescribedPart,
    DescribedValue,
    EngineAnswer,
    SceneDescription,
    describe_input,
    describe_reading_function,
    describe_value,
    format_number,
)
from governor_mechanism.scenes.effect_tables import SLEEVE_ALIAS, resolve_reading_name
from governor_mechanism.units.fields import class_words, fields_of
from governor_mechanism.units.quantities import parse_quantity


def describe_scene(
    scene: Scene,  # the scene. One that cannot start is described too; `problem` says why
) -> SceneDescription:
    """Describe a scene: dimensions with units, effects, readings, degrees of freedom, loads, couplings, events, and its engines."""
    start_values, degrees_of_freedom, problem = _start_of(scene)
    settings = scene.run
    return SceneDescription(
        title=scene.title,
        source=Path(scene.source).stem,
        parts=tuple(_describe_part(scene, part) for part in scene.parts),
        force_elements=tuple(_describe_force_elements(scene)),
        couplings=tuple(map(_describe_coupling, scene.couplings)),
        events=tuple(_describe_crossing(scene, crossing) for crossing in scene.crossings),
        readings=tuple(_describe_readings(scene, start_values)),
        degrees_of_freedom=degrees_of_freedom,
        drivers=scene.mechanism.count_drivers(),
        run=(
            describe_value("duration", settings.duration, "s"),
            describe_value("output_interval", settings.output_interval, "s"),
            describe_value("accuracy", settings.accuracy, ""),
            describe_value("engine", settings.engine, ""),
        ),
        engines=_ask_engines(scene),
        problem=problem,
    )


def _start_of(scene: Scene) -> tuple[Mapping[str, float], int, str]:
    """Return the readings at the start, the degrees of freedom there, and why there is no start; without one those of the initial guess."""
    try:
        poses, velocities = initial_state(scene)
    except MechanismError as error:
        return {}, mobility_of(scene.mechanism), "; ".join(error.problems)
    values, _ = evaluate_readings(scene.mechanism, poses[np.newaxis], velocities[np.newaxis])
    readings = {one.name: _without_rounding(float(value[0])) for one, value in zip(scene.mechanism.readings, values, strict=True)}
    return readings, PositionSolver(scene.mechanism).count_degrees_of_freedom(poses), ""


ROUNDING = 1e-12
"""Start value below which a reading is zero but for the rounding of the assembly, m or rad."""


def _without_rounding(value: float) -> float:
    return 0.0 if abs(value) < ROUNDING else value


def _describe_part(scene: Scene, part: Part) -> DescribedPart:
    mechanism = part.mechanism
    return DescribedPart(
        name=part.name,
        machine=part.machine,
        plane=part.plane,
        spindle=_describe_spindle(scene, part),
        dimensions=tuple(_describe_dimensions(scene, part)),
        effects=tuple(_describe_effect(scene, part, effect) for effect in part.effects),
        law=part.law.statement if part.law else "",
        key=_key_of(scene, part),
        bodies=tuple(body.name for body in mechanism.bodies),
        joints=tuple(joint.name for joint in mechanism.joints),
        coordinate=mechanism.coordinate,
    )


def _describe_dimensions(scene: Scene, part: Part) -> Iterator[DescribedValue]:
    """Yield the dimensions in the order of the machine's class, or else of the file; a word or a program is that of the file."""
    machine_class = MACHINES.get(part.machine)
    given = document_of_part(scene, part).get("dimensions", {})
    for name, dimension in dimensions_of(scene, part).items() if machine_class is None else ():
        definition = str(given[name]) if is_expression(given[name]) else ""
        yield describe_value(name, part.dimensions[name], dimension.unit, definition)
    for name, declared in fields_of(machine_class).items() if machine_class else ():
        value, unit = given.get(name, declared.default), declared.unit
        if value not in declared.words:
            if name in given and name not in part.dimensions:  # one from which others follow, as the speeds of a spring
                value = parse_quantity(value, declared.kind, name)
            elif isinstance(value, list | dict):
                value, unit = f"changes, from {format_number(part.dimensions[name], unit)}", ""
            else:
                value = part.dimensions.get(name)
        yield describe_value(name, value, unit, declared.kind_and_meaning)


def _describe_spindle(scene: Scene, part: Part) -> str:
    spindle = part.spindle
    if not part.turns:
        return ""
    if isinstance(spindle, Spindle):
        speed = describe_input(spindle.speed_function, "rad/s")
        fluctuation = f", coefficient of fluctuation {spindle.speed_fluctuation:g}" if spindle.speed_fluctuation else ""
        return f"spindle at {speed}{fluctuation}"
    angle = f"{part.name}.{SPINDLE_ANGLE}"
    couplings = [one for one in scene.couplings if isinstance(one, RatioCoupling) and angle in (one.first, one.second)]
    if couplings:
        return f"spindle coupled by {', '.join(one.name for one in couplings)}"
    return f"free spindle{_free_spindle_clause(spindle)}"


def _free_spindle_clause(spindle: FreeSpindle) -> str:
    """Return inertia, start speed and torque of a free spindle."""
    start = "" if spindle.start_speed is None else f", started at {format_number(spindle.start_speed, 'rad/s')}"
    has_torque = spindle.torque.depends_on_readings or any(spindle.torque.values)
    torque = f", torque {describe_input(spindle.torque, 'N m')}" if has_torque else ""
    return f" of {format_number(spindle.inertia, 'kg m^2')}{start}{torque}"


def _describe_effect(scene: Scene, part: Part, effect: Effect) -> DescribedItem:
    reading = effect.reading if isinstance(effect, OutputEffect) else ""
    quantity = part.mechanism.reading(reading).quantity if reading else ""
    key, given = _find_effect(scene, part, effect.key, reading)
    own_keys = {name: f"{key}.{name}" for name in given} if isinstance(given, Mapping) else dict.fromkeys(effect.value_fields[:1], key)
    values = []
    for name, declared in fields_of(effect).items():
        value = describe_value(name, getattr(effect, name), declared.along(quantity).unit)
        is_alone = isinstance(given, Mapping) or len(effect.value_fields) == 1
        values.append(replace(value, key=own_keys.get(name, "") if is_alone else ""))
    shown = [value for value in values if not value.is_absent]
    text = ", ".join(value.text if len(values) == 1 else f"{value.name} {value.text}" for value in shown)
    name = f"{effect.key}.{reading}" if reading else effect.key
    return DescribedItem(name=name, kind=effect.key, text=text, values=tuple(values), key=key)


def _key_of(scene: Scene, part: Part) -> str:
    """Return the start of the dotted keys of the tables of a part."""
    return f"part.{part.name}." if "part" in scene.document else ""


def _find_effect(scene: Scene, part: Part, name: str, reading: str) -> tuple[str, Any]:
    """Return the dotted key of an effect as the document of a scene writes it, and its value there; nothing if it is composed."""
    table = document_of_part(scene, part).get("effects", {})
    key, given = f"{_key_of(scene, part)}effects.{name}", table.get(name)
    if not reading or given is None:
        return (key, given) if given is not None else ("", None)
    quantities = {one.name: one.quantity for one in part.mechanism.readings}
    written = next(one for one in given if one in quantities or one == SLEEVE_ALIAS if resolve_reading_name(one, quantities) == reading)
    return f"{key}.{written}", given[written]


def _describe_force_elements(scene: Scene) -> Iterator[DescribedItem]:
    """Yield the force elements; not the torques that are zero for want of a load or of a control."""
    for element in scene.mechanism.force_elements:
        values = list(_values_of(element))
        inputs = [value for value in vars(element).values() if isinstance(value, InputFunction)]
        if inputs and all(one.is_constant and not one.values[0] for one in inputs):
            continue
        first, second = element.bodies
        text = ", ".join([f"{first} to {second}", *(f"{value.name.replace('_', ' ')} {value.text}" for value in values)])
        yield DescribedItem(name=element.name, kind=class_words(element), text=text, values=tuple(values))


def _values_of(element: ForceElement) -> Iterator[DescribedValue]:
    """Yield the coefficients of a force element and what it depends on; the numbers of gas are dimensions of its engine."""
    for name, declared in fields_of(type(element)).items():
        value = getattr(element, name)
        is_number = declared.form == "quantity" and not isinstance(element, CylinderGas)
        if isinstance(value, InputFunction) or is_number:
            yield describe_value(name, value, declared.unit)


def _describe_coupling(coupling: Coupling) -> DescribedItem:
    kind = class_words(coupling).removesuffix(" coupling")
    if isinstance(coupling, RatioCoupling):
        until = f", until {coupling.until:g} s" if isinstance(coupling, GearCoupling) and coupling.until is not None else ""
        text = f"{coupling.second} turns {coupling.ratio:g} times as fast as {coupling.first}{until}"
    elif isinstance(coupling, LoadCoupling):
        fraction = coupling.fraction
        share = f"{fraction.values[0]:g}" if fraction.is_constant else describe_input(fraction, "")
        text = f"resists {coupling.angle} with {format_number(coupling.rated_torque, 'N m')} times {share}"
    elif isinstance(coupling, ControlCoupling):
        unit = {"torque": "N m", "force": "N"}.get(coupling.quantity, "")
        verb = "multiplies" if coupling.scales else "is added to"
        text = f"{verb} {coupling.target}: {describe_reading_function(coupling.function, unit)}"
    else:
        text = ""
    return DescribedItem(name=coupling.name, kind=kind, text=text)


_PASSES = {"up": "rises through", "down": "falls through", "both": "passes"}
"""Verb of a crossing by its direction."""


def _describe_crossing(scene: Scene, crossing: NamedCrossing) -> DescribedItem:
    units = {reading.name: READING_UNITS[reading.quantity] for reading in scene.mechanism.readings}
    unit = units.get(crossing.reading, "rad/s")
    text = f"{crossing.reading} {_PASSES[crossing.direction]} {format_number(crossing.value, unit)}"
    return DescribedItem(name=crossing.name, kind="crossing", text=text, values=(describe_value("value", crossing.value, unit),))


def _describe_readings(scene: Scene, start_values: Mapping[str, float]) -> Iterator[DescribedValue]:
    """Yield the readings of a run in their order."""
    mechanism = scene.mechanism
    for reading in mechanism.readings:
        unit = READING_UNITS[reading.quantity]
        yield DescribedValue(name=reading.name, value=start_values.get(reading.name), unit=unit)
    for output in mechanism.derived_readings:
        yield DescribedValue(name=output.name, value=None, unit=output.unit)
    for plane in scene.system.planes:
        yield DescribedValue(name=f"{plane.prefix}{SPINDLE_SPEED}", value=None, unit="rad/s")
        if plane.given_speed and plane.is_loaded:
            yield DescribedValue(name=f"{plane.prefix}{SPINDLE_TORQUE}", value=None, unit="N m")
        elif not plane.given_speed and not plane.has_reaction:
            yield DescribedValue(name=f"{plane.prefix}{SPINDLE_ANGLE}", value=None, unit="rad")


def _ask_engines(scene: Scene) -> tuple[EngineAnswer, ...]:
    refusals = {name: engine().refusal(scene) for name, engine in ENGINES.items()}
    chosen = select_engine("auto", scene)[0].name
    return tuple(
        EngineAnswer(name=name, supported=not refusal, reason=refusal, is_chosen=not refusal and name == chosen)
        for name, refusal in refusals.items()
    )
