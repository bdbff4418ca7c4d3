"""Random scenes of parts that touch: error estimates against true errors, energies, gaps that stay open, repeatability."""

import numpy as np
import pytest

from certificate_checks import CertificateCheck, check_certificate
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from random_contacts import KINDS, ContactReferences, draw_contact_scene

SEED, OTHER_SEED = 20261127, 777001
N_SCENES = 300
ACCURACIES = 10.0 ** -np.arange(3, 9)


def check_scene(number: int, seed: int, *, with_friction: bool = False) -> CertificateCheck:
    """Check the estimate of a run; each kind of scene comes with each accuracy."""
    drawn = draw_contact_scene(number, seed, with_friction=with_friction)
    accuracy = float(ACCURACIES[number // len(KINDS) % len(ACCURACIES)])
    return check_certificate(drawn, "multibody", accuracy, ContactReferences(drawn.scene))


@pytest.mark.parametrize(
    ("numbers", "seed", "with_friction"),
    [
        pytest.param(range(15), SEED, False, id="few"),
        pytest.param(range(15), SEED, True, id="few with friction"),
        *(
            pytest.param(range(N_SCENES), seed, with_friction, id=name + " with friction" * with_friction, marks=pytest.mark.long)
            for name, seed in (("all", SEED), ("others", OTHER_SEED))
            for with_friction in (False, True)
        ),
    ],
)
def test_errors_are_within_their_estimates(numbers, seed, with_friction):
    checks = [check_scene(number, seed, with_friction=with_friction) for number in numbers]
    judged = [check for check in checks if check.is_judged]
    assert len(judged) >= 0.9 * len(checks)  # the references disagree near rounding, and where an event comes and goes
    wrong = [check for check in judged if not check.is_within_estimate or check.claims_too_much]
    assert len(wrong) <= 0.01 * len(judged), wrong
    assert sum(check.outcome == Outcome.DONE.name for check in checks) >= 0.99 * len(checks)


@pytest.mark.parametrize("with_friction", [False, True], ids=["smooth", "with friction"])
@pytest.mark.parametrize("number", range(10))
def test_parts_stay_apart_and_gain_no_energy(number, with_friction):
    scene = draw_contact_scene(number, SEED, with_friction=with_friction).scene
    run, again = (MultibodyEngine().run(scene, accuracy=1e-7) for _ in range(2))
    gaps, repeated = ([values for name, values in one.readings.items() if name.startswith("c_gap")] for one in (run, again))
    assert min(values.min() for values in gaps) > -1e-11
    assert run.energy.drift < 1e-6
    assert np.all(np.diff(run.energy.dissipated_energy) >= -1e-12)
    np.testing.assert_array_equal(gaps, repeated)
    assert run.events == again.events


def test_the_scenes_have_every_kind_of_contact_event():
    drawn = [draw_contact_scene(number, SEED, with_friction=one) for number in range(15) for one in (False, True)]
    kinds = {event.kind for one in drawn for event in MultibodyEngine().run(one.scene, certify=False).events}
    assert {EventKind.IMPACT, EventKind.REST, EventKind.SEPARATION, EventKind.STICK, EventKind.SLIP} <= kinds
