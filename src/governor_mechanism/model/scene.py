"""A scene: parts, their couplings, and the settings of the run. Frozen values without mathematics."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.later_module import LaterModule
from governor_mechanism.model.coupling.coupled_system import CoupledSystem, check_crossings, couple_parts
from governor_mechanism.model.coupling.couplings import Coupling
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.motion_readings import with_run_readings
from governor_mechanism.model.motion_state import MotionState
from governor_mechanism.model.part import FreeSpindle, Part, Spindle, Start
from governor_mechanism.units.fields import entry, quantity
from governor_mechanism.units.quantities import require_plausible
from governor_mechanism.units.text_table import summarise

if TYPE_CHECKING:
    from governor_mechanism.scenes import described_scene
else:
    described_scene = LaterModule("scenes.described_scene")


ENGINE_CHOICES: Final = ("auto", "impulse", "multibody", "reduced")
"""Engines that a scene file may name."""


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """Settings of a run."""

    duration: float = quantity("time", default=10.0, meaning="the simulated time")  # duration, s
    # interval of the reported times, s; at most the duration
    output_interval: float = quantity("time", default=0.01, meaning="the interval of the reported times")
    # largest error, relative to the scale of each reading; below 1
    accuracy: float = quantity(
        "ratio",
        limits=(0, 1),
        open_ends="low high",
        reason=", relative to the scale of each reading, as 1e-6",
        default=1e-6,
        meaning="the largest error, relative to the scale of each reading",
    )
    # name of the engine, or "auto"
    engine: str = entry(
        "choice", words=ENGINE_CHOICES, default="auto", meaning="the engine; auto takes the cheapest that can model the scene"
    )
    # further readings: "velocity.POINT", "acceleration.POINT" and "reaction.JOINT" with components ".x",
    # ".y", ".magnitude" (and ".moment" of a joint unless it is a pin or a link), and
    # "transmission_angle.COUPLER"
    readings: tuple[str, ...] = entry(
        "names",
        default=(),
        meaning="further readings: velocity.POINT, acceleration.POINT, transmission_angle.COUPLER, and reaction.JOINT, the force "
        "of a joint on its second body",
    )
    # names of the points whose paths are shown, and whose coordinates are readings: "NAME.x", "NAME.y"
    paths: tuple[str, ...] = entry(
        "names", default=(), meaning="points whose paths films and figures show, and whose coordinates are readings, as foot.x and foot.y"
    )

    def __post_init__(self) -> None:
        require_positive(self.duration, "s", "duration of the run")
        require_positive(self.output_interval, "s", "reporting interval `output_interval`")
        require_positive(self.accuracy, "", "accuracy")
        require_plausible(self.duration, "time", "duration of the run")
        if self.output_interval > self.duration:
            raise MechanismError(f"`output_interval` ({self.output_interval:g} s) must not exceed `duration` ({self.duration:g} s)")
        if self.accuracy >= 1:
            raise MechanismError(f"accuracy must be below 1 (it is relative to each reading's scale); got {self.accuracy:g}")


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Complete description of a simulation.

    Attributes
    ----------
    title
        Title.
    parts
        Parts; at least one.
    run
        Settings of the run.
    couplings
        Couplings between parts.
    crossings
        Named crossings that the events of a run list.
    source
        Path or name of the scene file; empty for a scene without one. Equal scenes may have different ones.
    document
        Scene file as a dictionary.
    state
        State from which its runs go on; None for the start that the parts describe.
    """

    title: str
    parts: tuple[Part, ...]
    run: RunSettings = field(default_factory=RunSettings)
    couplings: tuple[Coupling, ...] = ()
    crossings: tuple[NamedCrossing, ...] = ()
    source: str = field(default="", compare=False)
    document: Mapping[str, Any] = field(default_factory=dict)
    state: MotionState | None = None

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> Scene:
        """Return the scene of a dictionary with the keys and tables of a scene file, checked like a file.

        Parameters
        ----------
        document
            Keys and tables; quantities are SI numbers, or text with a unit.

        Returns
        -------
        Scene
            The scene, with a copy of the document.

        Raises
        ------
        MechanismError
            With a sentence for each mistake.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> document = gm.load("porter").document
        >>> gm.Scene.from_dict({**document, "title": "Mine"}).title
        'Mine'
        """
        from governor_mechanism.scenes.changed_document import make_scene

        return make_scene(document)

    def replace(self, values: Mapping[str, Any]) -> Scene:
        """Return a copy with other values at dotted keys of the scene file, checked like a file.

        Parameters
        ----------
        values
            Values by key, as {"dimensions.arm": "320 mm", "effects.dashpot": {"sleeve": "120 N s/m"}}; None leaves a key out. An item of
            a list is named as in {"body.crank.mass": 2.0}, or numbered from 1.

        Returns
        -------
        Scene
            The changed scene, without source.

        Raises
        ------
        MechanismError
            With a sentence for each mistake, or if this scene was composed of objects and has no document.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> gm.load("porter").replace({"dimensions.arm": "320 mm"}).part.dimensions["arm"]
        0.32
        """
        from governor_mechanism.scenes.changed_document import replace_values

        return replace_values(self, values)

    def to_toml(self) -> str:
        """Return the scene as the text of a scene file, without comments; it is read back as an equal scene.

        Returns
        -------
        str
            Text in TOML.

        Raises
        ------
        MechanismError
            If this scene was composed of objects and has no document.
        """
        from governor_mechanism.scenes.changed_document import scene_to_toml

        return scene_to_toml(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the scene as a scene file, which `gm.load` reads.

        Parameters
        ----------
        path
            Path of the file, which ends in .toml as all scene files.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        MechanismError
            If the path does not end in .toml, or this scene was composed of objects and has no document.
        """
        from governor_mechanism.files.writing import save_scene_text

        return save_scene_text(self.to_toml(), path)

    def describe(self) -> described_scene.SceneDescription:
        """Describe the scene in words.

        Returns
        -------
        SceneDescription
            Dimensions, effects, readings, degrees of freedom, loads, couplings, events, and what each engine says about it; it prints as
            text, and `as_json` returns plain values.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> print(gm.load("porter").describe())
        Porter governor, open arms (porter)
        ...
        """
        from governor_mechanism.scenes.description import describe_scene

        return describe_scene(self)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: machines, dimensions, effects and readings."""
        from governor_mechanism.notebook.result_table import scene_html

        return scene_html(self)

    def __repr__(self) -> str:
        """Return title, machines, size and run settings in a line or two."""
        machines = ", ".join(part.machine if len(self.parts) == 1 else f"{part.name}: {part.machine}" for part in self.parts)
        effects = ", ".join(dict.fromkeys(effect.key for effect in self.effects)) or "none"
        run = f"{self.run.duration:g} s to {self.run.accuracy:g}"
        return f"Scene({summarise(self.title)}; {machines}; {len(self.mechanism.bodies)} bodies; effects {effects}; {run})"

    def __post_init__(self) -> None:
        if not self.parts:
            raise MechanismError("a scene needs at least one part")
        for what, items in (("part", self.parts), ("coupling", self.couplings), ("crossing", self.crossings)):
            names = [item.name for item in items]
            for name in names:
                if names.count(name) > 1:
                    raise MechanismError(f"{what} {name!r} is listed twice; names must differ")
        self.system  # noqa: B018  # raises for couplings that contradict one another, and for unknown readings
        check_crossings(self.system, self.crossings)

    def with_changes(self, **changes: Any) -> Scene:
        """Return a copy with new values of these fields of the scene or of its only part."""
        own_changes = {one.name: changes.pop(one.name) for one in fields(Scene) if one.name in changes}
        if changes:
            own_changes["parts"] = (replace(own_changes.get("parts", (self.part,))[0], **changes),)
        return replace(self, **own_changes)

    @property
    def part(self) -> Part:
        """The only part. Raise MechanismError if there are several."""
        if len(self.parts) != 1:
            found = f"this scene has the parts {', '.join(repr(part.name) for part in self.parts)}"
            cure = "write the part that is meant in a scene file of its own, with a given spindle.speed"
            raise MechanismError(f"this works on a scene of one part, and {found}; {cure}")
        return self.parts[0]

    def part_of(self, name: str) -> tuple[Part, str]:
        """Return the part that a reading of the whole scene belongs to, and the name of the reading there."""
        if len(self.parts) == 1:
            return self.parts[0], name
        part_name, _, own_name = name.partition(".")
        return next(part for part in self.parts if part.name == part_name), own_name

    @cached_property
    def system(self) -> CoupledSystem:
        """The coupled mechanism of all parts and free spindles, with the effects along its readings."""
        system = couple_parts(self.parts, self.couplings)
        if not (self.run.readings or self.run.paths):
            return system
        return replace(system, mechanism=with_run_readings(system.mechanism, self.run.readings, self.run.paths))

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the whole scene: all parts, free spindles and gears."""
        return self.system.mechanism

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects of all parts."""
        return tuple(effect for part in self.parts for effect in part.effects)

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Effects along readings of the whole scene."""
        return self.system.output_effects

    @property
    def start(self) -> Start:
        """Start values and rates of the whole scene."""
        return self.system.start

    @property
    def spindle(self) -> Spindle | FreeSpindle:
        """Spindle of the only part."""
        return self.part.spindle

    @property
    def gravity(self) -> float:
        """Gravitational acceleration of the only part, m/s2."""
        return self.part.gravity

    @property
    def has_centrifugal(self) -> bool:
        """Whether bodies of any part in a turning plane carry a centrifugal load."""
        return any(part.has_centrifugal for part in self.parts)
