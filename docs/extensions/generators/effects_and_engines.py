"""Table of what each engine can model: effects, joints and machines, from the registries."""

from __future__ import annotations

from generators.markdown import code, escape, sentence, table
from generators.scene_file import JOINTS_BY_TYPE
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.engines.selection import ENGINES
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.part import TURNING_PLANE

YES, NO = "yes", "no"


def effects_and_engines_page() -> str:
    """Return the sections of the page."""
    return "\n".join([_effects_section(), _machines_section(), _joints_section(), _engines_section()])


def _effects_section() -> str:
    heading = ("effect", "what it is", "acts on", *map(code, ENGINES))
    rows = (
        [
            f"[{code(effect.key)}](../_generated/scene_file/effects.md#{effect.key})",
            escape(_first_sentence(effect)),
            "one reading" if issubclass(effect, OutputEffect) else effect.changes_bodies_of or "all bodies",
            *(YES if effect in engine.effects else NO for engine in ENGINES.values()),
        ]
        for effect in EFFECTS
    )
    return f"## Effects\n\n{table(heading, rows)}"


def _machines_section() -> str:
    """Return which machines take the effects that change bodies."""
    changing = [effect for effect in EFFECTS if effect.changes_bodies_of]
    heading = ("machine", "plane", *(code(effect.key) for effect in changing))
    rows = (
        [
            code(name),
            "turns with the spindle" if machine.plane == TURNING_PLANE else "fixed",
            *(YES if effect in machine.supported_effects else NO for effect in changing),
        ]
        for name, machine in MACHINES.items()
    )
    text = "Effects that change bodies belong to their machines. All other effects suit every machine, and `custom` mechanisms too."
    centrifugal = "`centrifugal` and `[spindle]` belong to a plane that turns."
    return f"## Machines\n\n{text} {centrifugal}\n\n{table(heading, rows)}"


def _joints_section() -> str:
    heading = ("joint of a custom machine", *map(code, ENGINES))
    rows = ([code(name), *(YES if joint in engine.joints else NO for engine in ENGINES.values())] for name, joint in JOINTS_BY_TYPE.items())
    return f"## Joints\n\n{table(heading, rows)}"


def _engines_section() -> str:
    """Return what each engine is."""
    lines = [f"- {code(name)}: {sentence((engine.__doc__ or '').split(chr(10))[0])}" for name, engine in ENGINES.items()]
    text = (
        "`auto` takes the cheapest engine that can model the scene. An engine may refuse a scene for other reasons, as `reduced` does "
        "for more than one degree of freedom; `governor-mechanism describe SCENE` says what each engine answers."
    )
    return "\n".join(["## Engines", "", *lines, "", text, ""])


def _first_sentence(effect: type[Effect]) -> str:
    summary = " ".join((effect.__doc__ or "").split("\n\n")[0].split())
    first, stop, _ = summary.partition(". ")
    return first + (stop.strip() or "")
