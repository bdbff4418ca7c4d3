"""A start on a stop with a velocity into it: every engine lists the strike, begins after it, and accounts for its energy."""

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.model.events import EventKind
from governor_mechanism.scenes.parser import parse_scene_document
from scene_documents import governor_document

RESTITUTION, RATE = 0.5, 1.0


def start_on_a_stop(spindle: dict, restitution: float = RESTITUTION, rate: float = RATE):
    """A Porter governor whose arm strikes its upper stop at the start."""
    document = governor_document(
        effects={"gravity": True, "centrifugal": True, "stops": {"arm_angle": ["15 deg", "40 deg"], "restitution": restitution}},
        spindle=spindle,
        start={"arm_angle": "40 deg", "arm_rate": rate},
        run={"duration": 0.1, "output_interval": 0.01, "accuracy": 1e-6},
    )
    return parse_scene_document(document)


def struck_energy() -> float:
    """Kinetic energy (J) in the plane before the strike, of two balls and the sleeve."""
    angle, speed = np.radians(40), 0.3 * RATE
    return 0.5 * 2 * 5 * speed**2 + 0.5 * 20 * (2 * speed * np.sin(angle)) ** 2


@pytest.mark.parametrize("spindle", [{"speed": "120 rpm"}, {"inertia": 0.5, "start_speed": "120 rpm"}], ids=["given speed", "free spindle"])
@pytest.mark.parametrize("engine", ["reduced", "multibody", "impulse"])
def test_a_strike_at_the_start_is_in_the_energy_account(engine, spindle):
    run = gm.run(start_on_a_stop(spindle), engine=engine)
    assert run.outcome is gm.Outcome.DONE
    energy = run.energy
    assert energy.kinetic[0] == pytest.approx(RESTITUTION**2 * struck_energy(), rel=1e-9)
    assert energy.dissipated_energy[0] == pytest.approx((1 - RESTITUTION**2) * struck_energy(), rel=1e-9)
    assert run.velocities[0, 0, 0] < 0.0  # the ball moves inward: the arm falls
    # 3e-7: the energy of a motion that is exact to the accuracy.
    np.testing.assert_allclose(energy.jacobi, energy.jacobi[0], atol=3e-7 * energy.scale)


@pytest.mark.parametrize(
    ("speed", "restitution", "rate", "kinds"),
    [
        ("120 rpm", RESTITUTION, RATE, [EventKind.IMPACT]),
        ("300 rpm", 0.0, RATE, [EventKind.IMPACT, EventKind.REST]),
        ("300 rpm", RESTITUTION, 0.0, []),
        ("120 rpm", RESTITUTION, 0.0, []),
        ("120 rpm", RESTITUTION, -RATE, []),
    ],
    ids=["rebound", "strike and rest", "rest", "fall", "thrown inward"],
)
@pytest.mark.parametrize("engine", ["reduced", "multibody", "impulse"])
def test_the_events_of_a_start_are_its_strikes(engine, speed, restitution, rate, kinds):
    run = gm.run(start_on_a_stop({"speed": speed}, restitution, rate), engine=engine)
    assert run.outcome is gm.Outcome.DONE
    assert [(event.subject, event.kind) for event in run.events] == [("arm_angle", kind) for kind in kinds]
    assert all(event.time < 1e-12 for event in run.events)
