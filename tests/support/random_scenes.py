"""Scenes drawn at random: every machine, with effects along its readings.

A scene follows from a seed and a number. What the package refuses is drawn again, and kept count of.
"""

import copy
import math
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import CLEARANCE_READING, DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines.initial_state import initial_state, part_initial_state
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.parser import parse_scene_document
from random_machines import MACHINES, Document, G, Random, draw_bool, draw_choice, draw_log_uniform, draw_restitution, draw_uniform
from study_machines import STUDY_MACHINES, draw_reports

MAX_DRAWS = 200
"""So many refusals in a row mean that the generator is wrong, not its luck."""


@dataclass(frozen=True)
class EffectSite:
    """A reading that effects may act along: where it starts, how it follows the coordinate, what is much for it.

    span is what the coordinate moves in a swing; weight, inertia and unit are those of the coordinate.
    """

    name: str
    value: float
    derivative: float
    span: float
    weight: float
    inertia: float
    coordinate_scale: float
    rate: float


def effect_sites(scene: Scene) -> list[EffectSite]:
    """The readings of a scene that its coordinate moves."""
    mechanism = scene.part.mechanism
    poses, velocities = part_initial_state(scene)
    assembler = PositionSolver(mechanism)
    coordinate = mechanism.reading(mechanism.coordinate)
    unit = 1.0 if coordinate.quantity == "angle" else mechanism.length_scale
    plays = CLEARANCE_READING in [reading.name for reading in mechanism.readings]
    try:
        ways = assembler.solve_velocities(poses, {coordinate.name: 1.0} | ({CLEARANCE_READING: 0.0} if plays else {}))
    except MechanismError:  # driven, so that its rate is not for anyone to say
        ways = velocities * time_scale(scene)
    mass = sum(body.mass for body in mechanism.bodies)
    reach = mechanism.length_scale / unit
    found = []
    for reading in mechanism.readings:
        here = evaluate_output(mechanism, reading.name, poses)
        slope = float(np.sum(here.gradient * ways))
        if reading.name != CLEARANCE_READING and abs(slope) > 0.1 * (1.0 if reading.quantity == "angle" else mechanism.length_scale) / unit:
            value = float(here.value)
            found.append(EffectSite(reading.name, value, slope, 0.1 * unit, mass * G * reach, mass * reach**2, unit, 1 / time_scale(scene)))
    return found


def draw_friction(random: Random, site: EffectSite, duration: float) -> Effect:
    """A force that holds little or much, steady or relieved for a time."""
    force = site.weight / abs(site.derivative) * draw_log_uniform(random, 5e-4, 0.1)
    if draw_bool(random, 0.7):
        return DryFriction(reading=site.name, force=InputFunction(values=(force,)))
    times = tuple(duration * share for share in (0.0, 0.4, 0.4, 0.5, 0.5))
    return DryFriction(reading=site.name, force=InputFunction(times=times, values=(force, force, 0.0, 0.0, force)))


def draw_dashpot(random: Random, site: EffectSite, _: float) -> Effect:
    """Linear, quadratic, or both."""
    linear = site.inertia * site.rate / site.derivative**2 * draw_log_uniform(random, 0.003, 0.6)
    quadratic = site.inertia / site.coordinate_scale / abs(site.derivative) ** 3 * draw_log_uniform(random, 0.02, 2.0)
    kind = int(random.integers(3))
    return Dashpot(reading=site.name, linear=linear if kind != 1 else 0.0, quadratic=quadratic if kind != 0 else 0.0)


def draw_spring(random: Random, site: EffectSite, _: float) -> Effect:
    """Of any stiffness; some one-sided, and then slack or taut in turns."""
    rate = site.inertia * site.rate**2 / site.derivative**2 * draw_log_uniform(random, 0.01, 1.0)
    zero = site.value + site.span * abs(site.derivative) * draw_uniform(random, -0.8, 0.8)
    return OutputSpring(reading=site.name, rate=rate, zero=zero, one_sided=draw_bool(random, 0.5))


def draw_stops(random: Random, site: EffectSite, _: float) -> Effect:
    """On one side or on both, near enough to be struck."""
    low, high = (site.value + side * site.span * abs(site.derivative) * draw_uniform(random, 0.1, 1.5) for side in (-1.0, 1.0))
    kind = int(random.integers(4))
    return Stops(
        reading=site.name, low=low if kind != 1 else -math.inf, high=high if kind != 2 else math.inf, restitution=draw_restitution(random)
    )


READINGS_OF_NO_LINE = ("rod_angle",)
"""Readings along which one engine cannot hold friction: the force does not act along one line between two bodies."""

EFFECT_GENERATORS = (draw_friction, draw_dashpot, draw_spring, draw_stops)
EFFECT_COUNTS = (0, 0, 1, 1, 2, 3)
"""Of effects along readings: a third of the scenes have none."""


def add_random_effects(random: Random, scene: Scene) -> Scene:
    """A scene with some effects along its readings."""
    where = effect_sites(scene)
    if not where:
        return scene
    # A stop against a drive is no motion: the run ends there.
    kinds = EFFECT_GENERATORS[:-1] if PositionSolver(scene.part.mechanism).equations.is_driven.any() else EFFECT_GENERATORS
    order = random.permutation(len(kinds))
    held = [site for site in where if site.name not in READINGS_OF_NO_LINE] or where
    sites = {draw_friction: held}
    made = [kinds[k](random, draw_choice(random, sites.get(kinds[k], where)), scene.run.duration) for k in order]
    return scene.with_changes(effects=(*scene.effects, *made[: draw_choice(random, EFFECT_COUNTS)]))


@dataclass(frozen=True)
class RandomScene:
    """A random scene, and the refusals that came before it."""

    seed: int
    number: int
    machine: str
    scene: Scene
    refused: tuple[str, ...] = ()
    document: Document = field(default_factory=dict, compare=False)

    @property
    def kind(self) -> str:
        """Smooth, or with events: contacts, the valves of gas in a cylinder, or a program that jumps or bends."""
        return "events" if has_contacts(self.scene) or has_kinks(self.document) else "smooth"

    @property
    def group(self) -> str:
        """Plain, with smooth effects, or with what sticks, strikes or goes slack."""
        if has_contacts(self.scene):
            return "events"
        return "smooth effects" if self.scene.output_effects else "plain"

    @property
    def description(self) -> str:
        """What is in it."""
        names = [f"{type(one).__name__} on {one.reading}" for one in self.scene.output_effects]
        has_one_spindle = len(self.scene.parts) == 1 and self.scene.has_centrifugal
        turned = type(self.scene.spindle).__name__ if has_one_spindle else ""
        return ", ".join(filter(None, [self.machine, turned, *names]))


def has_kinks(document: Document) -> bool:
    """Return whether a document has gas in cylinders or a value over time, which is a list of pairs."""
    if document.get("machine") == "flywheel_engine":
        return True
    tables = [value for value in document.values() if isinstance(value, dict)]
    for value in document.values():
        if isinstance(value, list):
            tables += [one for one in value if isinstance(one, dict)]
            if value and all(isinstance(one, list) and len(one) == 2 for one in value):
                return True
    return any(has_kinks(table) for table in tables)


def draw_study_scene(machine: str, number: int, seed: int) -> RandomScene:
    """Return the scene of a machine and a number in the study of certificates."""
    random = np.random.default_rng([seed, number, zlib.crc32(machine.encode())])
    draw, refused = STUDY_MACHINES[machine], list[str]()
    while len(refused) < MAX_DRAWS:
        document = draw(random)
        document["run"] = draw_reports(random, document["run"]["duration"])
        try:
            if machine in MACHINES:
                scene = assemble_scene(random, document)
            else:
                scene = parse_scene_document(document)
                initial_state(scene)
        except GovernorMechanismError as error:
            refused.append(str(error))
            continue
        return RandomScene(seed, number, machine, scene, tuple(refused), document)
    raise AssertionError(f"{machine}: nothing but refusals, the last: {refused[-1]}")


def draw_scene(number: int, seed: int) -> RandomScene:
    """The scene of that number; machines take turns, all else is drawn."""
    random = np.random.default_rng([seed, number])
    machine = list(MACHINES)[number % len(MACHINES)]
    refused: list[str] = []
    while len(refused) < MAX_DRAWS:
        try:
            scene = assemble_scene(random, MACHINES[machine](random))
        except GovernorMechanismError as error:
            refused.append(str(error))
            continue
        return RandomScene(seed, number, machine, scene, tuple(refused))
    raise AssertionError(f"{machine}: nothing but refusals, the last: {refused[-1]}")


def assemble_scene(random: Random, document: Document) -> Scene:
    """Return the scene of a document with some effects along its readings. Raise an error if it cannot be assembled."""
    scene = add_random_effects(random, parse_scene_document(document))
    initial_state(scene)
    return scene


# --- wild scenes ------------------------------------------------------------------------------------------------------

MAX_CHANGED_NUMBERS = 2
"""Largest number of numbers of a document that are changed: with more nearly all documents are refused."""

Path = tuple[str | int, ...]
"""Keys and indices that lead to a number of a document."""


def draw_wild_scene(number: int, seed: int) -> Scene | None:
    """Return a random scene with a number or two far from what is usual, or None if the package refuses it."""
    random = np.random.default_rng([seed, number])
    document = draw_choice(random, list(MACHINES.values()))(random)
    try:
        return assemble_scene(random, change_numbers(random, document))
    except GovernorMechanismError:
        return None


def change_numbers(random: Random, document: Document) -> Document:
    """Return a copy of a document with some numbers scaled by up to four decades, negated, zero or nearly the same."""
    found = copy.deepcopy(document)
    changes: tuple[Callable[[float], float], ...] = (
        lambda value: value * draw_log_uniform(random, 1e-4, 1e4),
        lambda value: value * draw_log_uniform(random, 0.1, 10.0),
        lambda value: -value,
        lambda value: 0.0,
        lambda value: value * (1 + 1e-9),
    )
    paths = [path for path in paths_to_numbers(found) if path[0] != "run"]
    for _ in range(int(random.integers(MAX_CHANGED_NUMBERS + 1))):
        *path, last = draw_choice(random, paths)
        table: Any = found
        for key in path:
            table = table[key]
        table[last] = draw_choice(random, changes)(float(table[last]))
    return found


def paths_to_numbers(table: Any, path: Path = ()) -> Iterator[Path]:
    """Yield where the numbers of a document stand."""
    items = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in items:
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield (*path, key)
        yield from paths_to_numbers(value, (*path, key))
