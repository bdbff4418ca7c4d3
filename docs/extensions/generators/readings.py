"""Reference of the readings: those of every machine, with unit and meaning, and those that all runs may have."""

from __future__ import annotations

from collections.abc import Mapping

from generators.markdown import code, escape, table
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.scenes.library import load_scene, shipped_scenes

SPINDLE_READINGS = {
    SPINDLE_SPEED: ("rad/s", "speed of the spindle"),
    SPINDLE_TORQUE: ("N m", "torque that keeps the spindle at a given speed"),
    SPINDLE_ANGLE: ("rad", "angle of a free spindle, continuous over full turns"),
}
"""Unit and meaning of the readings of a turning plane by name."""

HEADING = ("reading", "unit", "meaning")


def readings_page() -> str:
    """Return the sections of the page."""
    text = (
        "A reading is what a user reads off a mechanism. `run.readings` holds it over time, and `run.rates` its rate. Effects, events, "
        "loads and sweeps refer to it by its name; in a scene of several parts the name of the part precedes it, as "
        "`governor.sleeve_lift`. All values are in SI."
    )
    units = find_reading_units()
    sections = [text, "", *(_section(name, units[name]) for name in MACHINES)]
    spindle = table(HEADING, ([code(name), unit, meaning] for name, (unit, meaning) in SPINDLE_READINGS.items()))
    custom = (
        "The readings of a `custom` machine are those of its table [`[readings]`](../_generated/scene_file/readings.md). Without that "
        "table they are the angle of each body that rotates, `NAME_angle`, and the position of each other one, `NAME_x` and `NAME_y`."
    )
    sections += ["## Planes that turn with a spindle", "", spindle, "## `custom`", "", custom, ""]
    return "\n".join(sections)


def find_reading_units() -> dict[str, dict[str, str]]:
    """Return the unit of each reading of each machine, from the shipped scenes."""
    units: dict[str, dict[str, str]] = {name: {} for name in MACHINES}
    for scene in map(load_scene, shipped_scenes()):
        for part in scene.parts:
            mechanism = part.mechanism
            known = units.get(part.machine, {})
            known.update({one.name: READING_UNITS[one.quantity] for one in mechanism.readings})
            known.update({one.name: one.unit for one in mechanism.derived_readings})
    return units


def _section(machine: str, units: Mapping[str, str]) -> str:
    meanings = MACHINES[machine].reading_meanings
    rows = ([code(name), units[name], escape(meaning)] for name, meaning in meanings.items())
    return f"## {code(machine)}\n\n{table(HEADING, rows)}"
