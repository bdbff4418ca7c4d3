"""Random four-bar linkages, slider-cranks and inverted sliders with loads, against one equation of motion each."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
import pytest

from engines.joint_mechanisms import GRAVITY, body_angle, body_point, ground_point, integrate_state, make_scene
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.observables.evaluation import time_scale

COUNT, SEED = 30, 20261121
KINDS = ("four-bar", "slider-crank", "inverted")

Way = tuple[complex, complex, complex]
"""Where a mass centre is, and its two derivatives by the crank's angle; so too for an angle."""


@dataclass(frozen=True)
class Part:
    """A rigid part: its mass, its inertia, and where its ends are from its mass centre in its own axes (complex)."""

    name: str
    mass: float
    inertia: float
    start: complex
    end: complex

    @property
    def length(self) -> float:
        return abs(self.end - self.start)

    @property
    def turned(self) -> float:
        """Angle of the line from start to end in the part's axes."""
        return cmath.phase(self.end - self.start)


@dataclass(frozen=True)
class Linkage:
    """A crank about the origin and what it moves; all of it follows from the crank's angle by loop closure.

    kind: 'four-bar' (rocker about `pivot`), 'slider-crank' (piston on a line at `lean`, `aside` of the origin),
    'inverted' (the crank's end runs along a line of the rocker that passes `pivot`). branch: which way it is put
    together.
    """

    kind: str
    parts: tuple[Part, ...]
    loads: tuple[ForceElement, ...]
    start: float
    rate: float
    duration: float
    pivot: complex = 0.0
    lean: float = 0.0
    aside: float = 0.0
    branch: float = 1.0

    @property
    def names(self) -> list[str]:
        return [part.name for part in self.parts]

    @cached_property
    def angles(self) -> list[float]:
        """Angles of the parts at the start."""
        return [way[1][0] for way in self._closed(self.start)]

    def ways(self, q: float) -> list[tuple[Way, Way]]:
        """Place and angle of each part, with their derivatives by the crank's angle; angles within pi of the start's.

        The crank's own is counted on.
        """
        crank, *others = self._closed(q)
        found = [crank]
        for first, (way, (a, a1, a2)) in zip(self.angles[1:], others, strict=True):
            found.append((way, (first + math.remainder(a - first, math.tau), a1, a2)))
        return found

    def _closed(self, q: float) -> list[tuple[Way, Way]]:
        """The same with angles as the loop gives them."""
        crank, other, last = self.parts
        r = crank.length
        knee = r * cmath.exp(1j * q)
        own = _about(0.0, 0.0, 0.0, (q - crank.turned, 1.0, 0.0), -crank.start)
        if self.kind == "inverted":
            w1 = 1j * knee / (knee - self.pivot)
            w2 = -knee / (knee - self.pivot) - w1**2
            turn = (cmath.phase(knee - self.pivot) - last.turned, w1.imag, w2.imag)
            bead = ((knee, 1j * knee, -knee), (0.0, 0.0, 0.0))
            return [own, bead, _about(self.pivot, 0.0, 0.0, turn, -last.start)]
        length = other.length
        if self.kind == "slider-crank":
            sine, cosine = math.sin(q - self.lean), math.cos(q - self.lean)
            a = math.asin((self.aside - r * sine) / length)
            a1 = -r * cosine / (length * math.cos(a))
            a2 = (r * sine + length * math.sin(a) * a1**2) / (length * math.cos(a))
            unit = cmath.exp(1j * self.lean)
            piston = (
                (r * cosine + length * math.cos(a) + 1j * self.aside) * unit,
                (-r * sine - length * math.sin(a) * a1) * unit,
                (-r * cosine - length * (math.cos(a) * a1**2 + math.sin(a) * a2)) * unit,
            )
            turn = (a + self.lean - other.turned, a1, a2)
            return [own, _about(knee, 1j * knee, -knee, turn, -other.start), (piston, (0.0, 0.0, 0.0))]
        across = self.pivot - knee
        far = abs(across)
        a = cmath.phase(across) + self.branch * math.acos((length**2 + far**2 - last.length**2) / (2 * length * far))
        one, two = length * cmath.exp(1j * a), knee + length * cmath.exp(1j * a) - self.pivot
        a1, b1 = _along(one, -two, -knee)
        a2, b2 = _along(one, -two, 1j * (-knee - a1**2 * one + b1**2 * two))
        turn = (cmath.phase(two) - last.turned, b1, b2)
        rod = (a - other.turned, a1, a2)
        return [own, _about(knee, 1j * knee, -knee, rod, -other.start), _about(self.pivot, 0.0, 0.0, turn, -last.start)]

    def margin(self, q: float) -> float:
        """How far from a dead centre: the sine of the angle at which the loop's last two directions meet."""
        if self.kind == "inverted":
            knee = self.parts[0].length * cmath.exp(1j * q)
            return abs(knee - self.pivot) / abs(self.pivot)
        (_, (a, *_)), (_, (b, *_)) = self.ways(q)[1:]
        if self.kind == "slider-crank":
            return abs(math.cos(a + self.parts[1].turned - self.lean))
        return abs(math.sin(a + self.parts[1].turned - b - self.parts[2].turned))

    def bend(self, q: float, rate: float) -> float:
        """The crank's angular acceleration, by Lagrange's equation of the one coordinate."""
        ways = dict(zip(self.names, self.ways(q), strict=True))
        inertia = curving = push = 0.0
        for part in self.parts:
            (_, z1, z2), (_, a1, a2) = ways[part.name]
            inertia += part.mass * abs(z1) ** 2 + part.inertia * a1**2
            curving += part.mass * (z1.conjugate() * z2).real + part.inertia * a1 * a2
            push -= part.mass * GRAVITY * z1.imag
        for load in self.loads:
            push += _push(load, ways, rate)
        return (push - curving * rate**2) / inertia

    def motion(self, times):
        """Crank's angle and rate (2, n)."""
        return integrate_state(lambda _, y: [y[1], self.bend(*y)], (self.start, self.rate), times)

    def told(self, times):
        """Readings by name, values and rates."""
        angles, rates = self.motion(times)
        ways = [self.ways(float(q)) for q in angles]
        found = {}
        for k, part in enumerate(self.parts):
            if part.inertia:
                turn, speed = (np.array([way[k][1][order] for way in ways]) for order in range(2))
                found[part.name] = turn, speed * rates
            else:
                found["x"] = tuple(np.array([way[k][0][order].real for way in ways]) * rates**order for order in range(2))
        return found


def _about(base: complex, base1: complex, base2: complex, turn: Way, arm: complex) -> tuple[Way, Way]:
    """A mass centre at `arm` (in the part's axes) from a moving base, and the part's angle."""
    a, a1, a2 = turn
    out = arm * cmath.exp(1j * a)
    return (base + out, base1 + 1j * a1 * out, base2 + (1j * a2 - a1**2) * out), turn


def _along(one: complex, two: complex, right: complex) -> tuple[float, float]:
    """Real factors with which two directions make up a third."""
    area = (one.conjugate() * two).imag
    return (right.conjugate() * two).imag / area, (one.conjugate() * right).imag / area


def _point(ways, point: Point) -> tuple[complex, complex]:
    """A point and its derivative by the crank's angle."""
    if point.body == GROUND:
        return complex(point.x, point.y), 0.0
    (z, z1, _), (a, a1, _) = ways[point.body]
    arm = complex(point.x, point.y) * cmath.exp(1j * a)
    return z + arm, z1 + 1j * a1 * arm


def _turn(ways, body: str) -> tuple[float, float]:
    return (0.0, 0.0) if body == GROUND else ways[body][1][:2]


def _push(load: ForceElement, ways, rate: float) -> float:
    """The generalised force of a load along the crank's angle."""
    if isinstance(load, Force):
        return (complex(load.x.values[0], -load.y.values[0]) * _point(ways, load.point)[1]).real
    if isinstance(load, Spring | Damper):
        (one, one1), (two, two1) = _point(ways, load.first), _point(ways, load.second)
        line = two - one
        growth = (line.conjugate() * (two1 - one1)).real / abs(line)
        if isinstance(load, Spring):
            return -load.stiffness * (abs(line) - load.free_length) * growth
        return -load.damping * growth**2 * rate
    (first, first1), (second, second1) = (_turn(ways, body) for body in load.bodies)
    growth = second1 - first1
    if isinstance(load, TorsionSpring):
        return -load.stiffness * (second - first - load.free_angle) * growth
    if isinstance(load, TorsionDamper):
        return -load.damping * growth**2 * rate
    return load.moment.values[0] * growth


# --- the same linkage as a scene --------------------------------------------------------------------------------------


def scene_of(linkage: Linkage, unit: float = 1.0) -> Scene:
    """The scene; in a unit of length of which a metre has so many (with kg and s kept)."""
    own = replace(
        linkage,
        parts=tuple(replace(part, inertia=part.inertia * unit**2, start=part.start * unit, end=part.end * unit) for part in linkage.parts),
        loads=tuple(_scaled(load, unit) for load in linkage.loads),
        pivot=linkage.pivot * unit,
        aside=linkage.aside * unit,
    )
    crank, other, last = own.parts
    bodies, sketch = [], []
    for part, ((z, *_), (a, *_)) in zip(own.parts, own.ways(own.start), strict=True):
        moments = SecondMoments(xx=0.7 * part.inertia, yy=0.3 * part.inertia)
        bodies.append(Body(name=part.name, mass=part.mass, second_moments=moments, can_rotate=part.inertia > 0))
        sketch.append((z.real, z.imag, a))
    joints = [Pin(name="shaft", first=ground_point(), second=_end(crank, crank.start))]
    if own.kind == "inverted":
        line = Slider(name="line", first=_end(last, last.start), second=body_point(other.name), angle=last.turned)
        joints += [Pin(name="knee", first=_end(crank, crank.end), second=body_point(other.name)), line]
    else:
        joints += [
            Pin(name="knee", first=_end(crank, crank.end), second=_end(other, other.start)),
            Pin(name="end", first=_end(other, other.end), second=_end(last, last.end)),
        ]
    if own.kind == "slider-crank":
        foot = own.aside * 1j * cmath.exp(1j * own.lean)
        joints.append(Slider(name="guide", first=ground_point(foot.real, foot.imag), second=body_point(last.name), angle=own.lean))
    else:
        pivot = ground_point(own.pivot.real, own.pivot.imag)
        joints.append(Pin(name="pivot", first=_end(last, last.start), second=pivot))
    readings = [body_angle(part.name) for part in own.parts if part.inertia]
    readings += [
        PointCoordinate(name="x", quantity="length", point=body_point(part.name), direction_x=1.0, direction_y=0.0)
        for part in own.parts
        if not part.inertia
    ]
    return make_scene(
        bodies=bodies,
        joints=joints,
        readings=readings,
        sketch=sketch,
        loads=own.loads,
        rates={"crank": own.rate},
        gravity=GRAVITY * unit,
        size=crank.length + other.length + last.length,
        duration=own.duration,
        output_interval=own.duration / 20,
    )


def _end(part: Part, end: complex) -> Point:
    return body_point(part.name, end.real, end.imag)


def _scaled(load: ForceElement, unit: float) -> ForceElement:
    """A load in another unit of length: N/m and N s/m have none; moments have two."""

    def moved(point: Point) -> Point:
        return replace(point, x=point.x * unit, y=point.y * unit)

    def times(program: InputFunction, power: int) -> InputFunction:
        return replace(program, values=tuple(value * unit**power for value in program.values))

    if isinstance(load, Spring):
        return replace(load, first=moved(load.first), second=moved(load.second), free_length=load.free_length * unit)
    if isinstance(load, Damper):
        return replace(load, first=moved(load.first), second=moved(load.second))
    if isinstance(load, TorsionSpring):
        return replace(load, stiffness=load.stiffness * unit**2)
    if isinstance(load, TorsionDamper):
        return replace(load, damping=load.damping * unit**2)
    if isinstance(load, Torque):
        return replace(load, moment=times(load.moment, 2))
    assert isinstance(load, Force)
    return replace(load, point=moved(load.point), x=times(load.x, 1), y=times(load.y, 1))


# --- at random --------------------------------------------------------------------------------------------------------


def random_linkage(random: np.random.Generator, kind: str) -> Linkage:
    """Some linkage that moves well clear of its dead centres for the time of its run."""
    while True:
        linkage = _drawn(random, kind)
        if _stays_clear(linkage):
            return linkage


def _stays_clear(linkage: Linkage) -> bool:
    """Whether it can be put together and stays clear of dead centres, looked at with 400 plain steps of Heun."""
    q, rate, h = linkage.start, linkage.rate, linkage.duration / 400
    for _ in range(400):
        try:
            # 0.3: a sine nearer to zero makes forces large and errors grow, which is no matter of joints.
            # Not faster than 15 rad/s, so that errors grow no more than some hundredfold within a run.
            if linkage.margin(q) < 0.3 or abs(rate) > 15:
                return False
            # Beyond half a turn from the start, angles by loop closure would begin again.
            turns = zip(linkage.ways(q)[1:], linkage.angles[1:], strict=True)
            if any(abs(way[1][0] - first) > 3.0 for way, first in turns):
                return False
            bend = linkage.bend(q, rate)
            ahead = linkage.bend(q + h * rate, rate + h * bend)
        except ValueError:  # it cannot be put together, or comes to where it ends
            return False
        q, rate = q + h * rate + h**2 / 2 * bend, rate + h / 2 * (bend + ahead)
    return True


def _drawn(random: np.random.Generator, kind: str) -> Linkage:
    crank = _part(random, "crank", random.uniform(0.08, 0.3))
    pivot = random.uniform(0.25, 0.5) * cmath.exp(1j * random.uniform(-math.pi, math.pi))
    if kind == "four-bar":  # of any proportions: crank-rockers, double cranks, double rockers
        parts = (crank, _part(random, "rod", random.uniform(0.15, 0.5)), _part(random, "rocker", random.uniform(0.15, 0.5)))
    elif kind == "slider-crank":
        parts = crank, _part(random, "rod", random.uniform(0.2, 0.6)), _point_mass(random, "piston")
    else:
        parts = crank, _point_mass(random, "block"), _part(random, "rocker", random.uniform(0.3, 0.6))
    names = [part.name for part in parts if part.inertia]
    loads = [_load(random, k, names) for k in random.permutation(6)[: random.integers(1, 5)]]
    return Linkage(
        kind=kind,
        parts=parts,
        loads=tuple(loads),
        start=random.uniform(-math.pi, math.pi),
        rate=random.uniform(-4.0, 4.0),
        duration=random.uniform(0.4, 1.0),
        pivot=pivot,
        lean=random.uniform(-math.pi, math.pi),
        aside=random.uniform(-0.08, 0.08),
        branch=random.choice([-1.0, 1.0]),
    )


def _part(random: np.random.Generator, name: str, length: float) -> Part:
    """A bar whose mass centre lies anywhere near it, in axes turned anyhow."""
    mass = random.uniform(0.3, 3.0)
    turn = cmath.exp(1j * random.uniform(-math.pi, math.pi))
    start = -length * complex(random.uniform(0.2, 0.8), random.uniform(-0.2, 0.2))
    return Part(name, mass, mass * length**2 * random.uniform(0.04, 0.12), start * turn, (start + length) * turn)


def _point_mass(random: np.random.Generator, name: str) -> Part:
    return Part(name, random.uniform(0.3, 3.0), 0.0, 0.0, 0.0)


def _load(random: np.random.Generator, kind: int, names: list[str]) -> ForceElement:
    def somewhere(body: str, reach: float) -> Point:
        return body_point(body, *random.uniform(-reach, reach, 2))

    body, other = random.permutation(names)[:2].tolist()
    first = somewhere(GROUND, 0.6) if random.integers(2) else somewhere(other, 0.1)
    turning = GROUND if random.integers(2) else other
    name = f"load {kind}"
    if kind == 0:
        return Spring(
            name=name,
            first=first,
            second=somewhere(body, 0.1),
            stiffness=10 ** random.uniform(1, 2.5),
            free_length=random.uniform(0.05, 0.4),
        )
    if kind == 1:
        return Damper(name=name, first=first, second=somewhere(body, 0.1), damping=10 ** random.uniform(-1, 1))
    if kind == 2:
        return TorsionSpring(
            name=name, first=turning, second=body, stiffness=10 ** random.uniform(-1, 1), free_angle=random.uniform(-2.0, 2.0)
        )
    if kind == 3:
        return TorsionDamper(name=name, first=turning, second=body, damping=10 ** random.uniform(-3, -1))
    if kind == 4:
        return Torque(name=name, first=turning, second=body, moment=InputFunction(values=(random.uniform(-2.0, 2.0),)))
    push = [InputFunction(values=(value,)) for value in random.uniform(-8.0, 8.0, 2).tolist()]
    return Force(name=name, point=somewhere(body, 0.2), x=push[0], y=push[1])


@cache
def linkages() -> list[Linkage]:
    random = np.random.default_rng(SEED)
    return [random_linkage(random, KINDS[k % len(KINDS)]) for k in range(COUNT)]


def true_error(run, linkage: Linkage) -> float:
    """The largest error of any reading or rate, in its scale."""
    second, found = time_scale(run.scene), 0.0
    for name, (values, rates) in linkage.told(run.times).items():
        found = max(found, float(np.max(np.abs(run.readings[name] - values))) / run.scales[name])
        found = max(found, float(np.max(np.abs(run.rates[name] - rates))) / run.scales[name] * second)
    return found


def test_what_is_drawn_is_of_many_kinds():
    loads = {type(load) for linkage in linkages() for load in linkage.loads}
    assert loads == {Spring, Damper, TorsionSpring, TorsionDamper, Torque, Force}
    four_bars = [linkage for linkage in linkages() if linkage.kind == "four-bar"]
    lengths = [sorted([*(part.length for part in one.parts), abs(one.pivot)]) for one in four_bars]
    # Grashof's rule: in some a bar can turn right round, others are double rockers.
    assert {shortest + longest < one + other for shortest, one, other, longest in lengths} == {True, False}


@pytest.mark.parametrize("engine", [MultibodyEngine(), ReducedEngine()], ids=["multibody", "reduced"])
def test_fine_engines_are_as_accurate_as_asked_and_know_it(engine):
    random, fell_short = np.random.default_rng(SEED + 1), 0
    for linkage in linkages():
        scene, accuracy = scene_of(linkage), 10 ** random.uniform(-11, -4)
        run = engine.run(scene, accuracy=accuracy)
        assert run.outcome is Outcome.DONE
        true = true_error(run, linkage)
        assert true <= accuracy
        assert np.max(run.joint_gap) < 1e-12 * scene.part.mechanism.length_scale  # closed at every reported time
        fell_short += true > run.error_estimate
    assert fell_short <= 1  # the estimate is of a run ten times looser


def test_impulse_is_as_accurate_as_asked_and_knows_it():
    random, fell_short = np.random.default_rng(SEED + 2), 0
    for linkage in linkages():
        accuracy = 10 ** random.uniform(-6, -4)
        run = ImpulseEngine().run(scene_of(linkage), accuracy=accuracy)
        assert run.outcome is Outcome.DONE
        true = true_error(run, linkage)
        assert true <= accuracy
        fell_short += true > run.error_estimate
    assert fell_short <= 1  # the difference of two extrapolated runs is mostly the worse one's error


@pytest.mark.parametrize(
    ("engine", "certify", "allowed"),
    [
        # Every number that is compared with another is scaled with it, so that both runs take the same steps and differ
        # by rounding; were a step refused for rounding in one of them alone, both would still be as accurate as asked.
        (MultibodyEngine(), True, 2e-10),
        (ReducedEngine(), True, 2e-10),
        # The same given steps: rounding only, of some hundred steps, which the motion and the solver make more of.
        (ImpulseEngine(step=2e-3, runs=1), False, 1e-11),
    ],
    ids=["multibody", "reduced", "impulse"],
)
def test_in_millimetres_it_moves_the_same(engine, certify, allowed):
    for linkage in linkages():
        runs = [engine.run(scene_of(linkage, unit), accuracy=1e-10, certify=certify) for unit in (1.0, 1000.0)]
        metres, millimetres = (run.readings for run in runs)
        for name, values in metres.items():
            unit = 1000.0 if name == "x" else 1.0
            np.testing.assert_allclose(millimetres[name] / unit, values, atol=allowed, rtol=0.0)
