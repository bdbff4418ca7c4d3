"""A disc that bounces, slides and rolls: states, times of events and losses of strikes against an integration of its own by scipy."""

import math
from itertools import pairwise

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import GRAVITY, ROLLER, disc_document, events_of
from governor_mechanism.engines.multibody.engine import MultibodyEngine, MultibodySettings
from governor_mechanism.model.events import EventKind
from rolling_disc import Arc, Disc, Line, simulate

MASS, INERTIA, BOWL_RADIUS, CYLINDER_RADIUS, SLOPE = 1.5, 4e-4, 0.3, 0.1, 0.2
BOWL = [[-0.4, -0.4], [0.4, -0.4], [0.4, 0], [BOWL_RADIUS, 0, -BOWL_RADIUS], [-BOWL_RADIUS, 0], [-0.4, 0]]
CYLINDER = [[CYLINDER_RADIUS, 0, CYLINDER_RADIUS], [-CYLINDER_RADIUS, 0, CYLINDER_RADIUS]]
END, TOP = [math.cos(SLOPE), -math.sin(SLOPE)], [-math.cos(SLOPE), math.sin(SLOPE)]
INCLINE = [[4 * TOP[0], -2.0], [4 * END[0], -2.0], [4 * END[0], 4 * END[1]], [4 * TOP[0], 4 * TOP[1]]]

OUTER_ARC = Arc(CYLINDER_RADIUS + ROLLER, is_hollow=False)
CASES = {
    "incline": (INCLINE, Line(SLOPE, ROLLER), (0.1, 0.08, 0.0, 0.5, 0.1, 200.0), {"friction": 0.25, "restitution": 0.5}, 1.2),
    "bowl": (BOWL, Arc(BOWL_RADIUS - ROLLER), (0.11, -0.15, 0.0, 0.2, 0.0, 80.0), {"friction": 0.12, "restitution": 0.3}, 1.5),
    "cylinder": (CYLINDER, OUTER_ARC, (0.02, 0.12, 0.0, 0.02, 0.0, 10.0), {"friction": 0.4, "restitution": 0.0}, 0.6),
}
"""Outline, path of the centre, start, contact and duration; inelastic on the cylinder, where rebounds leave it."""


def run_case(name, times=None, engine="multibody", **options):
    """Run a disc with the friction and restitution of a case."""
    outline, _, start, contact, duration = CASES[name]
    document = disc_document(outline, start[:2], start[3:], MASS, INERTIA, run=(duration, 0.01), **contact)
    document["run"]["accuracy"] = 1e-8
    return gm.run(gm.Scene.from_dict(document), times=times, engine=engine, **options)


def reference(name, times):
    """Return the motion of the same disc by scipy."""
    _, path, start, contact, _ = CASES[name]
    return simulate(Disc(mass=MASS, inertia=INERTIA, radius=ROLLER, gravity=GRAVITY, **contact), path, start, times)


def states_of(run):
    """Return x, y, angle and their rates, shape (n, 6)."""
    return np.array([*(run.readings[one] for one in ("x", "y", "turn")), *(run.rates[one] for one in ("x", "y", "turn"))]).T


KINDS = (EventKind.IMPACT, EventKind.REST, EventKind.STICK, EventKind.SLIP, EventKind.SEPARATION)


@pytest.mark.parametrize(
    ("name", "happens"), [("incline", "rest stick"), ("bowl", "rest stick slip"), ("cylinder", "stick slip separation")]
)
def test_a_disc_bounces_slides_and_rolls_as_scipy_integrates(name, happens):
    run = run_case(name)
    assert run.outcome is gm.Outcome.DONE
    motion = reference(name, run.times)
    difference = np.abs(states_of(run) - motion.states) / [1, 1, 1 / ROLLER, 1, 1, 1 / ROLLER]
    assert np.max(difference) < 1e-9
    for kind in KINDS:
        found, expected = events_of(run, kind), motion.events[kind.name.lower()]
        if kind is EventKind.IMPACT:  # the engine sums its last rebounds earlier
            expected = expected[: len(found)]
        assert found == pytest.approx(expected, abs=1e-9), kind
    assert all(motion.events[key] for key in happens.split())
    assert run.energy.drift < 1e-8


def fly(state, duration):
    """Return a state in flight a time later, or earlier."""
    later = np.array(state)
    later[:3] += duration * later[3:]
    later[1] -= GRAVITY * duration**2 / 2
    later[4] -= GRAVITY * duration
    return later


def test_every_strike_keeps_the_laws_of_momentum_and_energy():
    """The states before and after follow from those in the middle of the flights, which are exact parabolas."""
    impacts = events_of(run_case("bowl"), EventKind.IMPACT)[:6]
    times = np.array([0.0, *((start + end) / 2 for start, end in pairwise(impacts))])
    run = run_case("bowl", times=times)
    states, friction, restitution = states_of(run), CASES["bowl"][3]["friction"], CASES["bowl"][3]["restitution"]
    limited = []
    for k, impact in enumerate(impacts[:-1]):
        before, after = fly(states[k], impact - times[k]), fly(states[k + 1], impact - times[k + 1])
        assert before[:3] == pytest.approx(after[:3], abs=1e-12)
        assert math.hypot(*before[:2]) == pytest.approx(BOWL_RADIUS - ROLLER, abs=1e-12)
        normal = -before[:2] / math.hypot(*before[:2])
        tangent = np.array([normal[1], -normal[0]])
        change = after - before
        push, rub = MASS * float(normal @ change[3:5]), MASS * float(tangent @ change[3:5])
        slip = float(tangent @ after[3:5]) + ROLLER * after[5]
        assert float(normal @ after[3:5]) == pytest.approx(-restitution * float(normal @ before[3:5]), rel=1e-9)
        assert INERTIA * change[5] == pytest.approx(ROLLER * rub, rel=1e-7)  # about the point that touches
        limited.append(abs(slip) > 1e-9)
        assert rub == pytest.approx(-friction * push * math.copysign(1.0, slip), rel=1e-7) if limited[-1] else abs(rub) <= friction * push
        kinetic = [MASS / 2 * (one[3] ** 2 + one[4] ** 2) + INERTIA / 2 * one[5] ** 2 for one in (before, after)]
        lost = run.energy.dissipated_energy[k + 1] - run.energy.dissipated_energy[k]
        assert kinetic[0] - kinetic[1] == pytest.approx(lost, abs=1e-12)
    assert True in limited


def test_the_order_of_a_run_with_contacts_is_that_of_its_method():
    """With steps of one length between events the error falls by about 2^8 from one length to half of it; their rounding costs some."""
    errors, motion = [], reference("bowl", np.array([0.0, 1.5]))
    for ratio in (10.0, 5.0, 2.5):
        settings = MultibodySettings(max_step_ratio=ratio, event_step_ratio=1.0)
        run = run_case("bowl", times=motion.times, engine=MultibodyEngine(tolerance=0.5, settings=settings), certify=False)
        errors.append(np.max(np.abs(states_of(run)[-1, :2] - motion.states[-1, :2])))
    assert 1e-8 < errors[0] < 1e-6
    assert all(coarse > 2**7 * fine for coarse, fine in pairwise(errors))
