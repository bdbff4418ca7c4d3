"""Random four-bar linkages, slider-cranks and inverted slider-cranks with loads, against their equation of motion."""

import cmath
import math
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
import pytest

from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.observables.evaluation import time_scale
from joint_mechanisms import GRAVITY, integrate_state, make_scene
from scene_parts import body_angle, body_point, constant, damper, ground_point, pin, slider, spring, x_reading

COUNT, SEED = 18, 20261121
KINDS = ("four-bar", "slider-crank", "inverted")

Derivatives = tuple[complex, complex, complex]
"""Position of a mass centre, or an angle, with first and second derivative with respect to the crank angle."""


@dataclass(frozen=True)
class Part:
    """A rigid part: mass, moment of inertia, and its ends relative to the mass centre in part axes (complex)."""

    name: str
    mass: float
    inertia: float
    start: complex
    end: complex

    @property
    def length(self) -> float:
        return abs(self.end - self.start)

    @property
    def axis_angle(self) -> float:
        """Angle of the line from start to end in the part's axes."""
        return cmath.phase(self.end - self.start)


@dataclass(frozen=True)
class Linkage:
    """A crank about the origin and the parts it moves; the crank angle determines all positions by loop closure.

    kind: 'four-bar' (rocker about `pivot`), 'slider-crank' (piston on a line at `line_angle`, at `line_offset` from the
    origin), 'inverted' (the crank's end slides along a line of the rocker through `pivot`). branch: assembly branch.
    """

    kind: str
    parts: tuple[Part, ...]
    loads: tuple[ForceElement, ...]
    start: float
    rate: float
    duration: float
    pivot: complex = 0.0
    line_angle: float = 0.0
    line_offset: float = 0.0
    branch: float = 1.0

    @property
    def names(self) -> list[str]:
        return [part.name for part in self.parts]

    @cached_property
    def angles(self) -> list[float]:
        """Return the angles of the parts at the start."""
        return [position[1][0] for position in self._close_loop(self.start)]

    def positions(self, q: float) -> list[tuple[Derivatives, Derivatives]]:
        """Return position and angle of each part with their derivatives; angles are within pi of those at the start.

        The crank angle itself is continuous.
        """
        crank, *others = self._close_loop(q)
        found = [crank]
        for first, (position, (a, a1, a2)) in zip(self.angles[1:], others, strict=True):
            found.append((position, (first + math.remainder(a - first, math.tau), a1, a2)))
        return found

    def _close_loop(self, q: float) -> list[tuple[Derivatives, Derivatives]]:
        """Return the same with angles as given by the loop closure."""
        crank, other, last = self.parts
        r = crank.length
        knee = r * cmath.exp(1j * q)
        scaled = _position_on_body(0.0, 0.0, 0.0, (q - crank.axis_angle, 1.0, 0.0), -crank.start)
        if self.kind == "inverted":
            w1 = 1j * knee / (knee - self.pivot)
            w2 = -knee / (knee - self.pivot) - w1**2
            turn = (cmath.phase(knee - self.pivot) - last.axis_angle, w1.imag, w2.imag)
            bead = ((knee, 1j * knee, -knee), (0.0, 0.0, 0.0))
            return [scaled, bead, _position_on_body(self.pivot, 0.0, 0.0, turn, -last.start)]
        length = other.length
        if self.kind == "slider-crank":
            sine, cosine = math.sin(q - self.line_angle), math.cos(q - self.line_angle)
            a = math.asin((self.line_offset - r * sine) / length)
            a1 = -r * cosine / (length * math.cos(a))
            a2 = (r * sine + length * math.sin(a) * a1**2) / (length * math.cos(a))
            unit = cmath.exp(1j * self.line_angle)
            piston = (
                (r * cosine + length * math.cos(a) + 1j * self.line_offset) * unit,
                (-r * sine - length * math.sin(a) * a1) * unit,
                (-r * cosine - length * (math.cos(a) * a1**2 + math.sin(a) * a2)) * unit,
            )
            turn = (a + self.line_angle - other.axis_angle, a1, a2)
            return [scaled, _position_on_body(knee, 1j * knee, -knee, turn, -other.start), (piston, (0.0, 0.0, 0.0))]
        across = self.pivot - knee
        far = abs(across)
        a = cmath.phase(across) + self.branch * math.acos((length**2 + far**2 - last.length**2) / (2 * length * far))
        one, two = length * cmath.exp(1j * a), knee + length * cmath.exp(1j * a) - self.pivot
        a1, b1 = _resolve(one, -two, -knee)
        a2, b2 = _resolve(one, -two, 1j * (-knee - a1**2 * one + b1**2 * two))
        turn = (cmath.phase(two) - last.axis_angle, b1, b2)
        rod = (a - other.axis_angle, a1, a2)
        return [
            scaled,
            _position_on_body(knee, 1j * knee, -knee, rod, -other.start),
            _position_on_body(self.pivot, 0.0, 0.0, turn, -last.start),
        ]

    def singularity_sine(self, q: float) -> float:
        """Return the sine of the angle between the last two directions of the loop: 0 at a dead centre."""
        if self.kind == "inverted":
            knee = self.parts[0].length * cmath.exp(1j * q)
            return abs(knee - self.pivot) / abs(self.pivot)
        (_, (a, *_)), (_, (b, *_)) = self.positions(q)[1:]
        if self.kind == "slider-crank":
            return abs(math.cos(a + self.parts[1].axis_angle - self.line_angle))
        return abs(math.sin(a + self.parts[1].axis_angle - b - self.parts[2].axis_angle))

    def acceleration(self, q: float, rate: float) -> float:
        """Return the angular acceleration of the crank by Lagrange's equation."""
        positions = dict(zip(self.names, self.positions(q), strict=True))
        inertia = velocity_term = force = 0.0
        for part in self.parts:
            (_, z1, z2), (_, a1, a2) = positions[part.name]
            inertia += part.mass * abs(z1) ** 2 + part.inertia * a1**2
            velocity_term += part.mass * (z1.conjugate() * z2).real + part.inertia * a1 * a2
            force -= part.mass * GRAVITY * z1.imag
        for load in self.loads:
            force += _generalised_force(load, positions, rate)
        return (force - velocity_term * rate**2) / inertia

    def motion(self, times):
        """Return crank angle and rate (2, n)."""
        return integrate_state(lambda _, y: [y[1], self.acceleration(*y)], (self.start, self.rate), times)

    def exact_readings(self, times):
        """Return values and rates of the readings by name."""
        angles, rates = self.motion(times)
        positions = [self.positions(float(q)) for q in angles]
        found = {}
        for k, part in enumerate(self.parts):
            if part.inertia:
                turn, speed = (np.array([position[k][1][order] for position in positions]) for order in range(2))
                found[part.name] = turn, speed * rates
            else:
                found["x"] = tuple(np.array([position[k][0][order].real for position in positions]) * rates**order for order in range(2))
        return found


def _position_on_body(base: complex, base1: complex, base2: complex, turn: Derivatives, arm: complex) -> tuple[Derivatives, Derivatives]:
    """Return a mass centre at `arm` (in part axes) from a moving base, and the angle of the part."""
    a, a1, a2 = turn
    out = arm * cmath.exp(1j * a)
    return (base + out, base1 + 1j * a1 * out, base2 + (1j * a2 - a1**2) * out), turn


def _resolve(one: complex, two: complex, right: complex) -> tuple[float, float]:
    """Return the components of a vector along two directions."""
    area = (one.conjugate() * two).imag
    return (right.conjugate() * two).imag / area, (one.conjugate() * right).imag / area


def _point(positions, point: Point) -> tuple[complex, complex]:
    """Return a point and its derivative with respect to the crank angle."""
    if point.body == GROUND:
        return complex(point.x, point.y), 0.0
    (z, z1, _), (a, a1, _) = positions[point.body]
    arm = complex(point.x, point.y) * cmath.exp(1j * a)
    return z + arm, z1 + 1j * a1 * arm


def _body_angle(positions, body: str) -> tuple[float, float]:
    return (0.0, 0.0) if body == GROUND else positions[body][1][:2]


def _generalised_force(load: ForceElement, positions, rate: float) -> float:
    """Return the generalised force of a force element along the crank angle."""
    if isinstance(load, Force):
        return (complex(load.x.values[0], -load.y.values[0]) * _point(positions, load.point)[1]).real
    if isinstance(load, Spring | Damper):
        (one, one1), (two, two1) = _point(positions, load.first), _point(positions, load.second)
        line = two - one
        growth = (line.conjugate() * (two1 - one1)).real / abs(line)
        if isinstance(load, Spring):
            return -load.stiffness * (abs(line) - load.free_length) * growth
        return -load.damping * growth**2 * rate
    (first, first1), (second, second1) = (_body_angle(positions, body) for body in load.bodies)
    growth = second1 - first1
    if isinstance(load, TorsionSpring):
        return -load.stiffness * (second - first - load.free_angle) * growth
    if isinstance(load, TorsionDamper):
        return -load.damping * growth**2 * rate
    return load.moment.values[0] * growth


# --- linkage as a scene --------------------------------------------------------------------------------------


def scene_of(linkage: Linkage, unit: float = 1.0) -> Scene:
    """Return the scene in another unit of length, `unit` of which make a metre (kg and s are kept)."""
    scaled = replace(
        linkage,
        parts=tuple(replace(part, inertia=part.inertia * unit**2, start=part.start * unit, end=part.end * unit) for part in linkage.parts),
        loads=tuple(_scale_load(load, unit) for load in linkage.loads),
        pivot=linkage.pivot * unit,
        line_offset=linkage.line_offset * unit,
    )
    crank, other, last = scaled.parts
    bodies, sketch = [], []
    for part, ((z, *_), (a, *_)) in zip(scaled.parts, scaled.positions(scaled.start), strict=True):
        moments = SecondMoments(xx=0.7 * part.inertia, yy=0.3 * part.inertia)
        bodies.append(Body(name=part.name, mass=part.mass, second_moments=moments, can_rotate=part.inertia > 0))
        sketch.append((z.real, z.imag, a))
    joints = [pin("shaft", ground_point(), _end(crank, crank.start))]
    if scaled.kind == "inverted":
        line = slider("line", _end(last, last.start), body_point(other.name), last.axis_angle)
        joints += [pin("knee", _end(crank, crank.end), body_point(other.name)), line]
    else:
        joints += [pin("knee", _end(crank, crank.end), _end(other, other.start)), pin("end", _end(other, other.end), _end(last, last.end))]
    if scaled.kind == "slider-crank":
        foot = scaled.line_offset * 1j * cmath.exp(1j * scaled.line_angle)
        joints.append(slider("guide", ground_point(foot.real, foot.imag), body_point(last.name), scaled.line_angle))
    else:
        pivot = ground_point(scaled.pivot.real, scaled.pivot.imag)
        joints.append(pin("pivot", _end(last, last.start), pivot))
    readings = [body_angle(part.name) for part in scaled.parts if part.inertia]
    readings += [x_reading(part.name) for part in scaled.parts if not part.inertia]
    return make_scene(
        bodies=bodies,
        joints=joints,
        readings=readings,
        sketch=sketch,
        loads=scaled.loads,
        rates={"crank": scaled.rate},
        gravity=GRAVITY * unit,
        size=crank.length + other.length + last.length,
        duration=scaled.duration,
        output_interval=scaled.duration / 20,
    )


def _end(part: Part, end: complex) -> Point:
    return body_point(part.name, end.real, end.imag)


def _scale_load(load: ForceElement, unit: float) -> ForceElement:
    """Return a force element in another unit of length: N/m and N s/m contain none, moments contain it squared."""

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


# --- random linkages --------------------------------------------------------------------------------------------------------


def random_linkage(random: np.random.Generator, kind: str) -> Linkage:
    """Return a random linkage that stays away from dead centres during its run."""
    while True:
        linkage = _draw_linkage(random, kind)
        if _is_well_conditioned(linkage):
            return linkage


def _is_well_conditioned(linkage: Linkage) -> bool:
    """Return whether the linkage can be assembled and stays away from dead centres, by 400 steps of Heun's method."""
    q, rate, h = linkage.start, linkage.rate, linkage.duration / 400
    for _ in range(400):
        try:
            # 0.3: a smaller sine makes forces large and errors grow, independently of the joints.
            # At most 15 rad/s, so that errors grow at most about a hundredfold within a run.
            if linkage.singularity_sine(q) < 0.3 or abs(rate) > 15:
                return False
            # Angles by loop closure are unique only within half a turn of the start.
            turns = zip(linkage.positions(q)[1:], linkage.angles[1:], strict=True)
            if any(abs(position[1][0] - first) > 3.0 for position, first in turns):
                return False
            acceleration = linkage.acceleration(q, rate)
            end_acceleration = linkage.acceleration(q + h * rate, rate + h * acceleration)
        except ValueError:  # it cannot be assembled, or reaches the end of its range
            return False
        q, rate = q + h * rate + h**2 / 2 * acceleration, rate + h / 2 * (acceleration + end_acceleration)
    return True


def _draw_linkage(random: np.random.Generator, kind: str) -> Linkage:
    crank = _part(random, "crank", random.uniform(0.08, 0.3))
    pivot = random.uniform(0.25, 0.5) * cmath.exp(1j * random.uniform(-math.pi, math.pi))
    if kind == "four-bar":  # any type: crank-rockers, double cranks, double rockers
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
        line_angle=random.uniform(-math.pi, math.pi),
        line_offset=random.uniform(-0.08, 0.08),
        branch=random.choice([-1.0, 1.0]),
    )


def _part(random: np.random.Generator, name: str, length: float) -> Part:
    """Return a bar with its mass centre close to it, in rotated axes."""
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
        return spring(name, first, somewhere(body, 0.1), 10 ** random.uniform(1, 2.5), random.uniform(0.05, 0.4))
    if kind == 1:
        return damper(name, first, somewhere(body, 0.1), 10 ** random.uniform(-1, 1))
    if kind == 2:
        return TorsionSpring(
            name=name, first=turning, second=body, stiffness=10 ** random.uniform(-1, 1), free_angle=random.uniform(-2.0, 2.0)
        )
    if kind == 3:
        return TorsionDamper(name=name, first=turning, second=body, damping=10 ** random.uniform(-3, -1))
    if kind == 4:
        return Torque(name=name, first=turning, second=body, moment=constant(random.uniform(-2.0, 2.0)))
    force = [constant(value) for value in random.uniform(-8.0, 8.0, 2).tolist()]
    return Force(name=name, point=somewhere(body, 0.2), x=force[0], y=force[1])


@cache
def linkages() -> list[Linkage]:
    random = np.random.default_rng(SEED)
    return [random_linkage(random, KINDS[k % len(KINDS)]) for k in range(COUNT)]


@cache
def exact_readings(linkage: Linkage, times: tuple[float, ...]):
    """Return values and rates of the readings of a linkage, for all engines."""
    return linkage.exact_readings(np.array(times))


def true_error(run, linkage: Linkage) -> float:
    """Return the largest error of any reading or rate relative to its scale."""
    scale, largest = time_scale(run.scene), 0.0
    for name, (values, rates) in exact_readings(linkage, tuple(run.times.tolist())).items():
        largest = max(largest, float(np.max(np.abs(run.readings[name] - values))) / run.scales[name])
        largest = max(largest, float(np.max(np.abs(run.rates[name] - rates))) / run.scales[name] * scale)
    return largest


def test_random_linkages_are_of_many_types():
    loads = {type(load) for linkage in linkages() for load in linkage.loads}
    assert loads == {Spring, Damper, TorsionSpring, TorsionDamper, Torque, Force}
    four_bars = [linkage for linkage in linkages() if linkage.kind == "four-bar"]
    lengths = [sorted([*(part.length for part in one.parts), abs(one.pivot)]) for one in four_bars]
    # Grashof's rule: in some a bar can rotate fully, others are double rockers.
    assert {shortest + longest < one + other for shortest, one, other, longest in lengths} == {True, False}


@pytest.mark.parametrize(
    ("engine", "seed", "lowest"),
    [
        (MultibodyEngine(), SEED + 1, -11),
        (ReducedEngine(), SEED + 1, -11),
        pytest.param(ImpulseEngine(), SEED + 2, -6, marks=pytest.mark.long),
    ],
    ids=["multibody", "reduced", "impulse"],
)
def test_errors_are_within_accuracy_and_estimate(engine, seed, lowest):
    random, fell_short = np.random.default_rng(seed), 0
    for linkage in linkages():
        scene, accuracy = scene_of(linkage), 10 ** random.uniform(lowest, -4)
        run = engine.run(scene, accuracy=accuracy)
        assert run.outcome is Outcome.DONE
        true = true_error(run, linkage)
        assert true <= accuracy
        if not isinstance(engine, ImpulseEngine):
            assert np.max(run.joint_gap) < 1e-12 * scene.part.mechanism.length_scale  # at every reported time
        fell_short += true > run.error_estimate
    assert fell_short <= 1  # it is for a ten times larger tolerance, or mainly the error of the less accurate of two extrapolated runs


@pytest.mark.parametrize(
    ("engine", "certify", "allowed"),
    [
        # All tolerances scale with the unit, so that both runs have the same steps and differ by rounding. If rounding made
        # one of them reject a step, both would still have the requested accuracy.
        (MultibodyEngine(), True, 2e-10),
        (ReducedEngine(), True, 2e-10),
        # With the same given steps only rounding differs, amplified by the motion and the solver over some hundred steps.
        (ImpulseEngine(step=2e-3, runs=1), False, 1e-11),
    ],
    ids=["multibody", "reduced", "impulse"],
)
def test_motion_is_the_same_in_millimetres(engine, certify, allowed):
    for linkage in linkages()[::2]:  # of all kinds
        runs = [engine.run(scene_of(linkage, unit), accuracy=1e-10, certify=certify) for unit in (1.0, 1000.0)]
        metres, millimetres = (run.readings for run in runs)
        for name, values in metres.items():
            unit = 1000.0 if name == "x" else 1.0
            np.testing.assert_allclose(millimetres[name] / unit, values, atol=allowed, rtol=0.0)
