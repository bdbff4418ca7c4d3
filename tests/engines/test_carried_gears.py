"""Gears with a carrier in motion: Willis' equation, motions that scipy integrates, moments on all three bodies, and refusals."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from data_files import read_data
from joint_mechanisms import GRAVITY, integrate_one_coordinate, integrate_state
from scene_documents import between, custom_document, pin

SCENES = read_data(__file__)
SUN, PLANET = 0.12, 0.08
"""Pitch radii, m."""
ARM = SUN + PLANET
CENTRE, RUN = {"O": [0, 0]}, {"duration": 1.0, "output_interval": 0.1}
WEIGHTS = {"sun": (3.0, 0.02), "arm": (1.5, 0.01), "planet": (2.0, 0.008)}
"""Mass (kg) and moment of inertia about the mass centre (kg m2)."""


def epicyclic(*, sun_is_fixed: bool = False, offset: float = 0.0, **tables) -> gm.Scene:
    """An arm about the axis of the sun, and a planet on it whose mass centre is `offset` (m) from its axis; gravity acts."""
    bodies = [
        {"name": "arm", "mass": 1.5, "inertia": 0.01, "centre": [ARM / 2, 0], "points": {"end": [ARM, 0]}},
        {"name": "planet", "mass": 2.0, "inertia": 0.008, "centre": [offset, 0], "at": [ARM, 0]},
    ]
    sun = "ground.O" if sun_is_fixed else "sun"
    joints = [
        pin("ground.O", "arm.origin", name="shaft"),
        pin("arm.end", "planet.origin", name="axle"),
        between("gear", sun, "planet.origin", name="mesh", ratio=-SUN / PLANET, carrier="arm"),
    ]
    readings = {"arm": {"angle": "arm"}, "planet": {"angle": "planet"}}
    if not sun_is_fixed:
        bodies.append({"name": "sun", "mass": 3.0, "inertia": 0.02})
        joints.append(pin("ground.O", "sun.origin", name="sun shaft"))
        readings["sun"] = {"angle": "sun"}
    document = custom_document(ground=CENTRE, body=bodies, joint=joints, readings=readings, effects={"gravity": GRAVITY}, run=RUN)
    return gm.Scene.from_dict(document | tables)


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
def test_a_planet_with_an_eccentric_mass_rolls_round_a_fixed_sun(engine):
    offset, turns = 0.03, 1 + SUN / PLANET  # the planet turns by this multiple of the arm, by the length that rolls off
    (_, arm_inertia), (mass, planet_inertia) = WEIGHTS["arm"], WEIGHTS["planet"]
    constant = arm_inertia + 1.5 * (ARM / 2) ** 2 + mass * (ARM**2 + (turns * offset) ** 2) + planet_inertia * turns**2
    coupling = 2 * mass * ARM * turns * offset

    def inertia(q):
        return constant + coupling * math.cos((turns - 1) * q), -coupling * (turns - 1) * math.sin((turns - 1) * q)

    def force(q, _):
        return -GRAVITY * ((1.5 * ARM / 2 + mass * ARM) * math.cos(q) + mass * turns * offset * math.cos(turns * q))

    scene = epicyclic(sun_is_fixed=True, offset=offset, start={"arm": 0.4, "arm_rate": 9.0})
    run = gm.run(scene, engine=engine, accuracy=1e-9)
    exact = integrate_one_coordinate(inertia, force, (0.4, 9.0), run.times)
    # The requested accuracy, relative to 1 rad and the time scale; the arm goes round more than once.
    np.testing.assert_allclose(run.readings["arm"], exact[0], atol=1e-8)
    np.testing.assert_allclose(run.readings["planet"], turns * exact[0], atol=3e-8)
    np.testing.assert_allclose(run.rates["arm"], exact[1], atol=1e-7)
    assert np.ptp(run.readings["arm"]) > 2 * math.pi
    assert run.energy.drift < 1e-8


def test_three_bodies_share_the_motion_of_a_free_train_and_the_moments_of_its_mesh():
    """Sun under a torque, and an arm under gravity: Lagrange's equations in both angles, integrated by scipy."""
    ratio, torque = -SUN / PLANET, 0.6
    (_, sun_inertia), (_, arm_inertia), (mass, planet_inertia) = WEIGHTS.values()
    arm_inertia += 1.5 * (ARM / 2) ** 2 + mass * ARM**2
    shares = np.array([ratio, 1 - ratio])  # of the planet's angle: Willis' equation
    matrix = np.diag([sun_inertia, arm_inertia]) + planet_inertia * np.outer(shares, shares)
    weight = GRAVITY * (1.5 * ARM / 2 + mass * ARM)

    def state_rate(_, state):
        forces = [torque, -weight * math.cos(state[1])]
        return [*state[2:], *np.linalg.solve(matrix, forces)]

    start = (0.0, 0.4, 5.0, -3.0)
    scene = epicyclic(
        force=[{"type": "torque", "body": "sun", "moment": torque}], start={"sun": 0.0, "arm": 0.4, "sun_rate": 5.0, "arm_rate": -3.0}
    )
    run = gm.run(scene.replace({"run.readings": ["reaction.mesh"]}), engine="multibody", accuracy=1e-9)
    exact = integrate_state(state_rate, start, run.times)
    np.testing.assert_allclose([run.readings["sun"], run.readings["arm"]], exact[:2], atol=1e-8)
    # The planet starts at its angle of the file, 0; at the arm's 0.4 rad this is an angle between teeth, which stays.
    planet = shares @ exact[:2]
    np.testing.assert_allclose(run.readings["planet"] - run.readings["planet"][0], planet - planet[0], atol=1e-8)
    assert run.energy.drift < 1e-8
    # Virtual work of the mesh: planet 1, sun -ratio, arm ratio - 1, of which each equation of motion has its own.
    accelerations = np.linalg.solve(matrix, [np.full(len(run.times), torque), -weight * np.cos(exact[1])])
    moment = planet_inertia * (shares @ accelerations)
    np.testing.assert_allclose(run.readings["reaction.mesh.moment"], moment, atol=1e-7)
    np.testing.assert_allclose(sun_inertia * accelerations[0], torque - ratio * moment, atol=1e-9)
    np.testing.assert_allclose(arm_inertia * accelerations[1], (ratio - 1) * moment - weight * np.cos(exact[1]), atol=1e-9)
    assert np.abs(moment).max() > 0.1


def test_a_differential_shares_its_torque_equally_and_its_speed_in_the_mean():
    inertia, torque = 0.02, 0.3
    run = gm.run(gm.Scene.from_dict(SCENES["DIFFERENTIAL"]), engine="multibody", accuracy=1e-9)
    np.testing.assert_allclose(run.rates["cage"], (run.rates["left"] + run.rates["right"]) / 2, atol=1e-11)
    # Torque balances of both shafts, each with half of what the inertia of the cage leaves of the torque.
    right = inertia * _slope(run.times, run.rates["right"])
    np.testing.assert_allclose(run.readings["reaction.bevels.moment"][1:-1], right[1:-1], rtol=2e-5)  # of the slopes
    cage = inertia * _slope(run.times, run.rates["cage"])
    np.testing.assert_allclose(2 * right[1:-1], torque - cage[1:-1], rtol=2e-5)


def _slope(times, values):
    return np.gradient(values, times, edge_order=2)


def test_a_carrier_that_is_the_ground_leaves_the_gear_as_it_is():
    wheels = SCENES["TWO_WHEELS"]
    plain = gm.Scene.from_dict(wheels)
    *pins, gear = wheels["joint"]
    carried = gm.Scene.from_dict(wheels | {"joint": [*pins, {**gear, "carrier": "ground"}]})
    assert carried.mechanism.joints == plain.mechanism.joints


def test_the_builder_has_the_carrier_too():
    m = gm.Mechanism.build("Sun and planet")
    arm = m.rod("arm", mass="1 kg", length=ARM, angle=0.3)
    sun, planet = (m.disc(name, mass="1 kg", radius=radius, angle=0.0) for name, radius in (("sun", SUN), ("planet", PLANET)))
    centre = m.ground(0, 0)
    m.pin(centre, arm.start, sun.origin)
    m.pin(arm.end, planet.origin)
    m.gear(sun, planet, -SUN / PLANET, carrier=arm, name="mesh")
    scene = m.scene()
    gear = next(joint for joint in scene.mechanism.joints if joint.name == "mesh")
    assert gear.carrier == "arm"
    assert gear.offset == pytest.approx((-SUN / PLANET - 1) * 0.3)  # angles from the arm


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"carrier": "planet"}, "'planet' as a wheel and as its carrier"),
        ({"carrier": "amr"}, 'carrier names the unknown body "amr"'),
        ({"carrier": 3}, "carrier"),
    ],
)
def test_a_wrong_carrier_is_refused_by_name(change, words):
    scene = epicyclic()
    *others, gear = [table for table in scene.document["joint"] if table["type"] != "pin"]
    pins = [table for table in scene.document["joint"] if table["type"] == "pin"]
    with pytest.raises(gm.MechanismError, match=words):
        gm.Scene.from_dict(scene.document | {"joint": [*pins, *others, {**gear, **change}]})


def test_engine_impulse_refuses_a_carried_gear_by_name():
    with pytest.raises(gm.UnsupportedEffect, match=r"gear with a carrier, which joins three bodies, here 'mesh'; use engine 'multibody'"):
        gm.run(epicyclic(), engine="impulse")


def test_a_carrier_keeps_its_part_in_a_scene_of_several():
    scene = epicyclic(sun_is_fixed=True, offset=0.03, start={"arm": 0.4, "arm_rate": 9.0})
    part = {key: value for key, value in scene.document.items() if key != "run"}
    both = gm.Scene.from_dict({"part": {"a": part, "b": part}, "run": scene.document["run"]})
    alone, together = (gm.run(one, engine="multibody", accuracy=1e-8) for one in (scene, both))
    for name in ("a.planet", "b.planet"):
        np.testing.assert_allclose(together.readings[name], alone.readings["planet"], atol=1e-6)  # twice the accuracy, over 12 rad
