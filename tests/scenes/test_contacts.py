"""Outlines and contacts of scene files: what is refused, in which sentence, and the builder that writes them."""

import math

import pytest

import governor_mechanism as gm
from contact_scenes import CUP, DISC, ball_document, outlines_document
from refusing import refuses


def refusal(outline=CUP, body=(), **contact):
    document = ball_document(outline, (0.0, 0.05), **contact)
    document["body"][0] |= dict(body)
    with pytest.raises(gm.MechanismError) as caught:
        gm.Scene.from_dict(document)
    return str(caught.value)


CAM = {"radius": 0.04, "lifts": [{"over": "180 deg", "lift": 0.01}, {"over": "180 deg", "lift": -0.01}]}


ARCHED = [[0, 0], [1, 0], [1, 1, -0.6], [0, 1]]
BOX = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]


def test_a_hollow_arc_that_does_not_cross_its_block_is_an_outline():
    gm.Scene.from_dict(ball_document(ARCHED, (0.5, 1.5)))


@pytest.mark.parametrize(
    ("first", "second", "contact"),
    [
        ({"curve": CAM}, BOX, {"friction": 0.1}),
        ({"curve": CAM}, ARCHED, {}),
        ([*DISC, [0, -0.1, 0.1]], BOX, {}),
        (DISC, ARCHED, {}),
        ({"curve": {"radius": 0.05}}, {"curve": CAM}, {}),
    ],
)
def test_two_outlines_that_touch_at_a_single_point_are_taken(first, second, contact):
    gm.Scene.from_dict(outlines_document(first, second, **contact))


def test_more_parts_between_hollow_corners_than_a_contact_can_look_at_are_refused():
    star = {"corners": [[0.1, 0], [0.09, 0.002]], "repeat": 120}
    assert "has 120 hollow corners, and at most 100 parts" in refusal(star)


def test_two_contacts_of_a_name_or_the_name_of_a_reading_are_refused():
    document = ball_document(DISC, (0.0, 0.2))
    document["contact"] = document["contact"] * 2
    refuses("contact 'ball': there already is a reading 'ball_gap'", gm.Scene.from_dict, document)
    document["contact"] = document["contact"][:1]
    document["readings"]["ball_gap"] = {"x": "ball.origin"}
    refuses("give the contact another name", gm.Scene.from_dict, document)


def test_the_builder_writes_the_document_of_a_scene_file():
    m = gm.Mechanism.build("Ball on a disc", size=0.1)
    block = m.body("block", mass=1.0, inertia=1.0)
    block.set_outline(DISC)
    m.joint("weld", m.ground(0, 0), block.origin)
    ball = m.point_mass("ball", mass=1.0, at=[0.013, 0.25])
    m.contact(ball.origin, block, radius="20 mm", restitution=0.5, name="ball")
    m.gravity(10.0)
    times = [0.0, 0.1, 0.2, 0.3]
    built = gm.run(m.scene(), times=times)
    written = gm.run(gm.Scene.from_dict(ball_document(DISC, (0.013, 0.25), restitution=0.5)), times=times, accuracy=1e-6)
    assert len(built.events) == 1
    assert built.readings["ball_gap"] == pytest.approx(written.readings["ball_gap"], abs=1e-9)
    refuses("which has no outline", m.contact, block.origin, ball)
    refuses("crosses itself", block.set_outline, [[0, 0], [1, 1], [1, 0], [0, 1]])
    assert gm.Scene.from_dict(m.document()).to_toml()


def test_the_names_of_bodies_make_that_of_a_contact_without_one():
    document = ball_document(DISC, (0.0, 0.2))
    del document["contact"][0]["name"]
    assert gm.Scene.from_dict(document).mechanism.readings[-1].name == "ball_block_gap"


def test_the_lift_of_a_curve_is_its_law():
    scene = gm.Scene.from_dict(ball_document({"curve": CAM}, (0.0, 0.2), radius=0.0))
    curve = scene.mechanism.outlines[0].outline.curve
    assert curve.radii_at_starts == pytest.approx((0.04, 0.05))
    assert math.fsum(one.over for one in curve.lifts) == pytest.approx(2 * math.pi)
