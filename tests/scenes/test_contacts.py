"""Outlines and contacts of scene files: what is refused, in which sentence, and the builder that writes them."""

import math

import pytest

import governor_mechanism as gm
from contact_scenes import CUP, DISC, ball_document


def refusal(outline=CUP, body=(), **contact):
    document = ball_document(outline, (0.0, 0.05), **contact)
    document["body"][0] |= dict(body)
    with pytest.raises(gm.MechanismError) as caught:
        gm.Scene.from_dict(document)
    return str(caught.value)


STEEP = [{"over": "60 deg", "lift": 0.05}, {"over": "60 deg", "lift": -0.05}, {"over": "240 deg"}]
CAM = {"radius": 0.04, "lifts": [{"over": "180 deg", "lift": 0.01}, {"over": "180 deg", "lift": -0.01}]}


@pytest.mark.parametrize(
    ("outline", "words"),
    [
        ([[0, 0], [1, 0]], "an outline needs three corners or more"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "edge 2 of an outline has no length: it begins and ends at (1 m, 0 m)"),
        ([[0, 0], [1, 0, 0.2], [1, 1]], "edge 2 of an outline is an arc with the radius 0.2 m, which must be at least half"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "the outline crosses itself between"),
        ([[0, 0], [1, 0], [1, 1, -0.6], [0, 1]], ""),
        ([[0, 0], [1, 0], [1, 0.3, -0.5], [0, 0.3]], "the outline crosses itself between"),
        ([[0, 0], [1, 0], [0.5, 0], [0.5, 1]], "the outline turns back on itself at (1 m, 0 m)"),
        ([[0, 0], [1, "x"], [1, 1]], "corner 2 y is a length"),
        ([[0, 0], [1], [1, 1]], "corner 2 must be [x, y], or [x, y, radius]"),
        (3, "must be a list of corners"),
        ({"curve": {"coefficients": [0, 1]}}, "curve must be closed"),
        ({"curve": CAM, "inset": -0.01}, "inset must not be negative"),
        ({"curve": {**CAM, "lifts": CAM["lifts"][:1]}}, "must add up to a turn; they are 180 deg"),
        ({"curve": {**CAM, "lifts": [CAM["lifts"][0]] * 2}}, "must add up to 0"),
        ({"curve": {"radius": 0.01, "lifts": CAM["lifts"][::-1]}}, "falls to a radius that is not positive"),
        ({"curve": {**CAM, "lifts": [{"over": 1, "law": "parabolic"}]}}, "lift 1"),
        ({"curve": {**CAM, "follower": "knife"}}, "follower"),
        ({"curve": {**CAM, "follower": "flat", "lifts": STEEP}}, "hollow at 45 deg, on which a flat follower does not rest"),
    ],
)
def test_an_outline_that_no_part_can_have_is_refused(outline, words):
    if words:
        assert words in refusal(outline)
    else:
        gm.Scene.from_dict(ball_document(outline, (0.5, 1.5)))


@pytest.mark.parametrize(
    ("outline", "contact", "words"),
    [
        (CUP, {"second": "ball"}, 'second names "ball", which has no outline'),
        (CUP, {"second": "wheel"}, "unknown body"),
        (CUP, {"first": "block.origin"}, 'both sides are of "block"; a body cannot touch itself'),
        (CUP, {"radius": 0.0}, "the roller needs a radius where the outline has corners"),
        (CUP, {"restitution": 1.5}, "restitution"),
        (CUP, {"name": "a b"}, "name consists of letters, digits and _"),
        (CUP, {"stiffness": 0.1}, "stiffness is unknown"),
        (CUP, {"friction": -0.1}, "friction"),
        (CUP, {"repeat": 0}, "must be a whole number from 1 to 500"),
        (CUP, {"at_once": 2.5}, "must be a whole number from 1 to 500"),
        ({"curve": CAM}, {"repeat": 3}, "repeat is for rollers of a body that touch an outline of corners"),
        ([[0, 0], [1, 0], [1, 1, -0.6], [0, 1]], {"radius": 0.6}, "hollow arc of radius 0.6 m, which a roller of 0.6 m cannot enter"),
        ([[0, 0], [1, 0], [1, 1], [0.5, 0.5], [0, 1]], {}, "a single hollow corner; round it"),
        ({"curve": CAM, "inset": 0.05}, {}, "the cam is undercut"),
        ({"curve": {"radius": 0.05, "harmonics": [{"amplitude": 0.02, "order": 3}]}}, {"radius": 0.03}, "touches two sides at once"),
    ],
)
def test_a_contact_that_a_roller_cannot_keep_is_refused(outline, contact, words):
    assert words in refusal(outline, **contact)


BOX = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]


def outlines_refusal(outline, touched, **contact):
    """Why the outlines of two bodies cannot touch; empty if they can."""
    document = ball_document(touched, (0.0, 2.0))
    document["body"][1] = {"name": "ball", "mass": 1.0, "inertia": 1.0, "at": [0.0, 2.0], "outline": outline}
    document["contact"] = [{"first": "ball", "second": "block", **contact}]
    try:
        gm.Scene.from_dict(document)
    except gm.MechanismError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("first", "second", "contact", "words"),
    [
        (BOX, BOX, {}, "both have corners; of two that touch one is a circle, or one a closed curve"),
        ({"curve": CAM}, {"curve": CAM}, {}, "both are curves"),
        ({"curve": CAM}, BOX, {"radius": 0.01}, "touches with its own outline; leave radius out"),
        ({"curve": CAM}, BOX, {"first": "block"}, 'both sides are of "block"'),
        ({"curve": CAM}, BOX, {"friction": 0.1}, ""),
        ({"curve": CAM}, BOX, {"repeat": 3}, "repeat is for rollers of a body"),
        ({"curve": CAM}, BOX, {"first": "wheel"}, "unknown body"),
        ({"curve": {"radius": 0.05, "harmonics": [{"amplitude": 0.02, "order": 3}]}}, BOX, {}, "hollow or flat somewhere"),
        ({"curve": CAM, "inset": 0.05}, BOX, {}, "the cam is undercut"),
        ({"curve": CAM}, [[0, 0], [1, 0], [1, 1, -0.6], [0, 1]], {}, ""),
        (
            {"curve": CAM},
            [[0, 0], [0.3, 0], [0.3, 0.2], [0.19, 0.2, -0.045], [0.11, 0.2], [0, 0.2]],
            {},
            "hollow arc of radius 0.045 m, and the curve bends with radii",
        ),
        ([*DISC, [0, -0.1, 0.1]], BOX, {}, ""),
        ([[0.1, 0, 0.1], [-0.1, 0, 0.1]], [[0, 0], [1, 0], [1, 1, -0.6], [0, 1]], {}, ""),
        ([[0.6, 0, 0.6], [-0.6, 0, 0.6]], [[0, 0], [1, 0], [1, 1, -0.6], [0, 1]], {}, "a roller of 0.6 m cannot enter"),
        ({"curve": {"radius": 0.05}}, {"curve": CAM}, {}, ""),
    ],
)
def test_two_outlines_that_do_not_touch_at_a_single_point_are_refused(first, second, contact, words):
    text = outlines_refusal(first, second, **contact)
    assert words in text if words else not text


def test_more_parts_between_hollow_corners_than_a_contact_can_look_at_are_refused():
    star = {"corners": [[0.1, 0], [0.09, 0.002]], "repeat": 120}
    assert "has 120 hollow corners, and at most 100 parts" in refusal(star)


def test_two_contacts_of_a_name_or_the_name_of_a_reading_are_refused():
    document = ball_document(DISC, (0.0, 0.2))
    document["contact"] = document["contact"] * 2
    with pytest.raises(gm.MechanismError, match="contact 'ball': there already is a reading 'ball_gap'"):
        gm.Scene.from_dict(document)
    document["contact"] = document["contact"][:1]
    document["readings"]["ball_gap"] = {"x": "ball.origin"}
    with pytest.raises(gm.MechanismError, match="give the contact another name"):
        gm.Scene.from_dict(document)


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
    with pytest.raises(gm.MechanismError, match="which has no outline"):
        m.contact(block.origin, ball)
    with pytest.raises(gm.MechanismError, match="crosses itself"):
        block.set_outline([[0, 0], [1, 1], [1, 0], [0, 1]])
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
