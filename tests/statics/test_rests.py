"""Equilibria with parts that touch: where they rest, with which force; positions in which they overlap are none."""

import math

import pytest

import governor_mechanism as gm
from command_line import invoke
from contact_scenes import GRAVITY, ROLLER, ball_document
from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.equilibrium_report import report_equilibria

FLOOR = [[-2, -2], [2, -2], [2, 0], [-2, 0]]
PIVOT, LENGTH, MASS = 0.1, 0.5, 2.0
REST = -math.asin((PIVOT - ROLLER) / LENGTH)
"""Angle of the lever at which the roller at its end touches the floor."""


def lever_document(**start):
    """A uniform rod on a pin above a floor, with a roller at its end."""
    document = ball_document(FLOOR, (0.0, 0.0))
    document["body"][1] = {"name": "lever", "mass": MASS, "rod": {"length": LENGTH}, "at": [0.0, PIVOT], "angle": 0.3}
    document["joint"].append({"type": "pin", "first": ["ground", 0.0, PIVOT], "second": "lever.start"})
    document["contact"] = [{"name": "tip", "first": "lever.end", "radius": ROLLER, "second": "block"}]
    return document | {"readings": {"angle": {"angle": "lever"}}, "start": start or {"angle": 0.3}}


def test_a_lever_rests_on_the_floor_at_the_force_of_statics_on_either_side():
    """It hangs down nowhere, since the floor is in its way; the moment of its weight is that of the force at its end."""
    found = gm.equilibria(gm.Scene.from_dict(lever_document()))
    resting, upright = [one for one in found if one.contact], [one for one in found if not one.contact]
    assert [math.sin(one.coordinate) for one in resting] == pytest.approx([math.sin(REST)] * 2, abs=1e-12)
    assert {round(math.cos(one.coordinate), 12) for one in resting} == {round(math.cos(REST), 12), -round(math.cos(REST), 12)}
    assert [one.push for one in resting] == pytest.approx([MASS * GRAVITY / 2] * 2, rel=1e-12)
    assert all(one.stable and one.stiffness == math.inf and one.contact == "tip" for one in resting)
    assert [(one.coordinate, one.stable) for one in upright] == [(pytest.approx(math.pi / 2, abs=1e-12), False)]


def test_a_run_comes_to_rest_where_statics_says_with_the_same_force():
    document = lever_document()
    document["run"] |= {"duration": 2.0, "readings": ["contact.tip"]}
    run = gm.run(gm.Scene.from_dict(document))
    rest = next(one for one in gm.equilibria(gm.Scene.from_dict(document)) if one.contact and math.cos(one.coordinate) > 0)
    assert run.readings["angle"][-1] == pytest.approx(rest.coordinate, abs=1e-9)
    assert run.readings["contact.tip.force"][-1] == pytest.approx(rest.push, rel=1e-9)


def test_loads_that_lift_a_contact_leave_no_rest_on_it():
    document = lever_document()
    spring = {"type": "torsion_spring", "name": "spring", "first": "ground", "second": "lever", "stiffness": 20.0, "free_angle": 0.6}
    found = gm.equilibria(gm.Scene.from_dict(document | {"force": [spring]}))
    near = [one for one in found if -0.5 < one.coordinate < 0.6]
    assert [one.contact for one in near] == [""]
    assert 20 * (0.6 - near[0].coordinate) == pytest.approx(MASS * GRAVITY * LENGTH / 2 * math.cos(near[0].coordinate), rel=1e-9)


def test_a_scene_may_start_at_rest_on_a_contact_and_has_no_linear_equations_there():
    wall = [[0.3, -2], [2, -2], [2, 2], [0.3, 2]]
    document = lever_document(angle="equilibrium")
    document["body"][0]["outline"] = wall
    document["body"][1]["angle"] = -1.0
    document["force"] = [{"type": "torque", "name": "push", "body": "lever", "moment": 8.0}]  # more than the weight resists
    scene = gm.Scene.from_dict(document)
    (leaning,) = [one for one in gm.equilibria(scene) if one.stable]
    assert leaning.contact == "tip"
    assert LENGTH * math.cos(leaning.coordinate) == pytest.approx(0.3 - ROLLER, abs=1e-12)
    run = gm.run(scene)
    assert run.readings["angle"] == pytest.approx(leaning.coordinate, abs=1e-9)
    with pytest.raises(MechanismError, match="parts touch, the motion has no linear equations: contacts are 'tip'"):
        gm.linearise(scene)


def test_the_command_names_the_contact_and_a_range_of_motion_the_overlap(tmp_path):
    scene = gm.Scene.from_dict(lever_document())
    assert f"at rest on contact 'tip', which bears {MASS * GRAVITY / 2:g} N" in str(report_equilibria(scene, None))
    kinematics = gm.kinematics(scene, "angle")
    (note,) = [one for one in kinematics.notes if "contact" in one]
    assert "the parts of contact 'tip' overlap at" in note
    refused = invoke("equilibria", "disc_cam", "--out", tmp_path)
    assert refused.exit_code == 2
    assert "one degree of freedom and without drives" in refused.stderr
