"""Random scenes of parts that touch: polygons, arcs, cams, rollers and points, which fall, bounce, slide and are driven."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from certificate_checks import LARGEST_STEP_RATIO, SHORTEST_STEP_RATIO, ReferenceSolutions, reference_engine
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.scenes.parser import parse_scene_document
from random_scenes import Document, RandomScene

MAX_DRAWS = 100
"""Draws after which a kind of scene has only been refused."""


def draw_polygon(random: np.random.Generator, size: float) -> list[list[float]]:
    """Return a convex polygon about the origin, some of whose edges bulge."""
    angles = np.sort(random.uniform(0, 2 * math.pi, random.integers(3, 8)))
    radii = np.full(len(angles), size)
    corners = [[float(r * math.cos(a)), float(r * math.sin(a))] for r, a in zip(radii, angles, strict=True)]
    if random.random() < 0.5:
        corners[0].append(float(random.uniform(1.5, 4.0) * size))
    return corners


def draw_cam(random: np.random.Generator, size: float) -> Document:
    """Return a convex curve: harmonics, or an eccentric by its law of lift."""
    if random.random() < 0.4:
        lift = float(random.uniform(0.05, 0.2) * size)
        lifts = [{"over": math.pi, "lift": lift, "law": "cycloidal"}, {"over": math.pi, "lift": -lift, "law": "harmonic"}]
        return {"curve": {"radius": size, "lifts": lifts, "follower": "flat"}}
    amplitudes = [random.uniform(0.0, 0.2) * size / order**3 for order in (1, 2, 3)]
    harmonics = [
        {"amplitude": float(amplitude), "order": order, "phase": float(random.uniform(0, 6))}
        for order, amplitude in enumerate(amplitudes, start=1)
    ]
    return {"curve": {"radius": size, "harmonics": harmonics}}


def make_document(bodies: list[Document], contacts: list[Document], start: Mapping[str, float], **tables: object) -> Document:
    """Return a scene of bodies and contacts under gravity, with the positions of bodies that no joint holds as readings."""
    held = {str(joint["second"]).split(".")[0] for joint in tables.get("joint", ())}  # type: ignore[attr-defined]
    free = [body for body in bodies if body["name"] not in held]
    readings = {f"{body['name']}_{axis}": {axis: f"{body['name']}.origin"} for body in free for axis in "xy"}
    readings |= {f"{body['name']}_turn": {"angle": body["name"]} for body in free if not body.get("point")}
    return {
        "machine": "custom",
        "size": 0.1,
        "ground": {"O": [0, 0]},
        "body": bodies,
        "contact": contacts,
        "readings": readings,
        "effects": {"gravity": True},
        "start": dict(start),
        "run": {"duration": 0.4, "output_interval": 0.02},
        **tables,
    }


def free_body(random: np.random.Generator, name: str, outline: object) -> tuple[Document, dict[str, float]]:
    """Return a body above the origin with an outline, and its start."""
    x, y, turn = float(random.uniform(-0.05, 0.05)), float(random.uniform(0.22, 0.3)), float(random.uniform(-3, 3))
    body = {"name": name, "mass": float(random.uniform(0.2, 2)), "inertia": float(random.uniform(2e-4, 2e-3)), "at": [x, y], "angle": turn}
    rates = {f"{name}_x_rate": float(random.uniform(-0.3, 0.3)), f"{name}_y_rate": float(random.uniform(-1, 0.3))}
    start = {f"{name}_x": x, f"{name}_y": y, f"{name}_turn": turn, **rates, f"{name}_turn_rate": float(random.uniform(-5, 5))}
    return body | ({"outline": outline} if outline else {}), start


def draw_restitution(random: np.random.Generator) -> float:
    return float(random.choice([0.0, 0.3, 0.7, 1.0]))


def block(outline: object, **values: object) -> Document:
    return {"name": "block", "mass": 1.0, "inertia": 1e-3, "outline": outline, **values}


WELD: Document = {"type": "weld", "first": "ground.O", "second": "block.origin"}


def draw_ball(random: np.random.Generator) -> Document:
    """A ball falls on a polygon that rests."""
    ball, start = free_body(random, "ball", None)
    radius = float(random.uniform(0.005, 0.03))
    contact = {"name": "c", "first": "ball.origin", "radius": radius, "second": "block", "restitution": draw_restitution(random)}
    return make_document([block(draw_polygon(random, 0.15)), ball], [contact], start, joint=[WELD])


def draw_roller(random: np.random.Generator) -> Document:
    """A body with a roller beside its mass centre falls on a block that is free, too."""
    ball, start = free_body(random, "ball", None)
    place = [float(random.uniform(-0.02, 0.02)), float(random.uniform(-0.02, 0.02))]
    contact = {"name": "c", "first": ["ball", *place], "radius": 0.02, "second": "block", "restitution": draw_restitution(random)}
    start |= {"block_x": 0.0, "block_y": 0.0, "block_turn": 0.0} | dict.fromkeys(("block_x_rate", "block_y_rate", "block_turn_rate"), 0.0)
    spring = {"type": "spring", "first": "ground.O", "second": "block.origin", "stiffness": float(random.uniform(1, 100))}
    return make_document([block(draw_polygon(random, 0.1)), ball], [contact], start, force=[spring])


def draw_pit(random: np.random.Generator) -> Document:
    """A ball falls into a pit with walls, or a bowl."""
    ball, start = free_body(random, "ball", None)
    wide = float(random.uniform(0.06, 0.12))
    inside = [[wide, 0.2], [wide, 0.0], [-wide, 0.0], [-wide, 0.2]]
    if random.random() < 0.5:
        inside = [[0.12, 0.2], [0.12, 0.12, -0.12], [-0.12, 0.12], [-0.12, 0.2]]
    outline = [[-0.3, -0.1], [0.3, -0.1], [0.3, 0.2], *inside, [-0.3, 0.2]]
    contact = {"name": "c", "first": "ball.origin", "radius": 0.02, "second": "block", "restitution": draw_restitution(random)}
    return make_document([block(outline), ball], [contact], start, joint=[WELD])


def draw_disc(random: np.random.Generator) -> Document:
    """A convex curve falls on a polygon that rests."""
    disc, start = free_body(random, "disc", draw_cam(random, 0.04))
    contact = {"name": "c", "first": "disc", "second": "block", "restitution": draw_restitution(random)}
    return make_document([block(draw_polygon(random, 0.15)), disc], [contact], start, joint=[WELD])


def draw_follower(random: np.random.Generator) -> Document:
    """A cam that turns lifts a follower on a spring: flat, with a roller, or pointed; fast ones lift off."""
    kind = random.choice(["flat", "roller", "point"])
    cam = {"name": "cam", "mass": 1.0, "inertia": 1e-3, "outline": draw_cam(random, 0.05)}
    radius = 0.01 if kind == "roller" else 0.0
    follower = {"name": "follower", "mass": float(random.uniform(0.1, 0.5)), "turns": False, "at": [0, 0.05 * 1.3 + radius]}
    if kind == "flat":
        follower["outline"] = [[-0.05, 0], [0.05, 0], [0.05, 0.01], [-0.05, 0.01]]
    contact = (
        {"name": "c", "first": "cam", "second": "follower"}
        if kind == "flat"
        else {"name": "c", "first": "follower.origin", "second": "cam"}
    )
    contact |= {"restitution": draw_restitution(random)} | ({"radius": radius} if radius else {})
    joints = [
        {"type": "pin", "first": "ground.O", "second": "cam.origin"},
        {"type": "slider", "name": "guide", "first": "ground.O", "second": "follower.origin", "angle": "90 deg"},
        {"type": "driven_turn", "name": "motor", "first": "ground", "second": "cam", "rate": float(random.uniform(-60, 60))},
    ]
    spring = {
        "type": "spring",
        "first": "ground.top",
        "second": "follower.origin",
        "stiffness": float(random.uniform(100, 2000)),
        "free_length": 0.2,
    }
    document = make_document([cam, follower], [contact], {}, joint=joints, force=[spring])
    return document | {"ground": {"O": [0, 0], "top": [0, 0.25]}, "readings": {"lift": {"y": "follower.origin"}, "angle": {"angle": "cam"}}}


def draw_cam_in_bowl(random: np.random.Generator) -> Document:
    """A convex curve falls into a hollow arc, in which it rolls to and fro."""
    disc, start = free_body(random, "disc", draw_cam(random, 0.04))
    outline = [[-0.3, -0.1], [0.3, -0.1], [0.3, 0.2], [0.15, 0.2], [0.15, 0.15, -0.15], [-0.15, 0.15], [-0.15, 0.2], [-0.3, 0.2]]
    contact = {"name": "c", "first": "disc", "second": "block", "restitution": draw_restitution(random)}
    return make_document([block(outline), disc], [contact], start, joint=[WELD])


def draw_disc_on_free_block(random: np.random.Generator) -> Document:
    """A convex curve falls on a polygon that is free on a spring."""
    disc, start = free_body(random, "disc", draw_cam(random, 0.04))
    contact = {"name": "c", "first": "disc", "second": "block", "restitution": draw_restitution(random)}
    start |= {"block_x": 0.0, "block_y": 0.0, "block_turn": 0.0} | dict.fromkeys(("block_x_rate", "block_y_rate", "block_turn_rate"), 0.0)
    spring = {"type": "spring", "first": "ground.O", "second": "block.origin", "stiffness": float(random.uniform(1, 100))}
    return make_document([block(draw_polygon(random, 0.1)), disc], [contact], start, force=[spring])


KINDS: Mapping[str, Callable[[np.random.Generator], Document]] = {
    "ball": draw_ball,
    "roller": draw_roller,
    "pit": draw_pit,
    "disc": draw_disc,
    "follower": draw_follower,
}
"""Kinds of scenes without friction."""

RUBBING_KINDS: Mapping[str, Callable[[np.random.Generator], Document]] = {
    "disc": draw_disc,
    "follower": draw_follower,
    "cam in a bowl": draw_cam_in_bowl,
    "disc on a free block": draw_disc_on_free_block,
    "roller": draw_roller,
}
"""Kinds of scenes with friction: curves, and for comparison rollers."""


def draw_contact_scene(number: int, seed: int, *, with_friction: bool = False) -> RandomScene:
    """Return the scene of a number; the kinds take turns, and what is refused, as what overlaps at the start, is drawn again."""
    random, refused = np.random.default_rng([seed, number]), list[str]()
    kinds = RUBBING_KINDS if with_friction else KINDS
    kind = list(kinds)[number % len(kinds)]
    while len(refused) < MAX_DRAWS:
        document = kinds[kind](random)
        if with_friction:
            document["contact"][0]["friction"] = float(random.uniform(0.05, 0.8))
        try:
            scene = parse_scene_document(document)
            initial_state(scene)
        except GovernorMechanismError as error:
            refused.append(str(error))
            continue
        return RandomScene(seed, number, kind, scene, tuple(refused), document)
    raise AssertionError(f"{kind}: nothing but refusals, the last: {refused[-1]}")


REFERENCE_TOLERANCES = (1e-13, 3e-14)
"""Tolerances of two solutions that confirm each other."""


@dataclass(eq=False)
class ContactReferences(ReferenceSolutions):
    """Reference solutions of a scene of parts that touch, which engine `multibody` alone runs: twice, with other steps."""

    def reference_pairs(self, engine: str) -> Iterator[tuple[Trajectory, Trajectory]]:
        """Yield a solution and the one that confirms it."""
        loose, tight = REFERENCE_TOLERANCES
        one = self._run_reference(reference_engine("multibody", loose, LARGEST_STEP_RATIO))
        other = self._run_reference(reference_engine("multibody", tight, SHORTEST_STEP_RATIO))
        if one is not None and other is not None:
            yield other, one
