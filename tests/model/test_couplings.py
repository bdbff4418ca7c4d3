"""Couplings that are impossible are refused in sentences that name the coupling and the cure."""

from dataclasses import replace

import pytest

from coupled_scenes import coupled_scene, discs_part, engine_part, porter_part
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.coupling.couplings import ControlCoupling, FollowCoupling, GearCoupling
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction, LinearFunction
from refusing import refuses

CRANK, SPINDLE = "engine.crank_angle", "governor.spindle_angle"
GIVEN, FOLLOWER = {"spindle": Spindle(speeds=(13.0,))}, {"spindle": FreeSpindle()}


def gear(name="belt", first=CRANK, second=SPINDLE, ratio=2.0):
    return GearCoupling(name=name, first=first, second=second, ratio=ratio)


def follow(name="belt", first=CRANK, second=SPINDLE):
    return FollowCoupling(name=name, first=first, second=second, ratio=2.0)


def control(reading="governor.sleeve_lift", target="engine.load"):
    return ControlCoupling(name="linkage", target=target, function=LinearFunction(reading=reading, gain=-100.0))


@pytest.mark.parametrize(
    ("couplings", "changes", "message"),
    [
        (
            [follow()],
            GIVEN,
            r"'belt' drives 'governor.spindle_angle', whose speed is given.*two drives.*leave the speed or the coupling out",
        ),
        ([follow("a"), follow("b")], {}, "'a' and 'b' both drive 'governor.spindle_angle'; leave one of them out"),
        ([follow(second="governor.spindle_angel")], {}, r"'governor.spindle_angel', which is no spindle; .*\['governor.spindle_angle'\]"),
        (
            [follow(first="engine.cranck_angle")],
            FOLLOWER,
            "'engine.cranck_angle' in coupling 'belt' is unknown; .*mean 'engine.crank_angle'",
        ),
        ([gear()], GIVEN, "'belt' couples 'governor.spindle_angle', whose speed is given.*use type follow, or leave spindle.speed out"),
        ([follow()], {}, "'belt' gives the speed of 'governor.spindle_angle'; inertia, start speed and torque .* leave them out"),
        ([follow(), gear("chain")], FOLLOWER, "'chain' couples 'governor.spindle_angle', whose speed is given or follows another part"),
        ([gear("a"), gear("b", ratio=3.0)], {}, "'b' closes a loop of gears and contradicts the others: .* is 2, and here it is 3"),
        ([gear("a"), gear("b", SPINDLE, CRANK, 0.5)], {}, "'b' closes a loop of gears and is superfluous"),
        ([gear(first="engine.crank")], {}, r"'engine.crank' in coupling 'belt' is unknown; such angles are \['engine.crank_angle', .*\]"),
        ([gear(second="governor.arm_angle")], {}, "'governor.arm_angle' in coupling 'belt' is not the angle of a body"),
        ([gear(), gear(first=SPINDLE, second=CRANK)], {}, "coupling 'belt' is listed twice; names must differ"),
        ([control(target="engine.laod")], {}, r"'linkage' sets 'engine.laod', which is no load; .*did you mean 'engine.load'"),
        (
            [control(target="governor.spindle_torque")],
            GIVEN,
            r"'governor.spindle_torque', which is no load; the loads are \['engine.load'\]",
        ),
        ([control("belt"), gear()], {}, "depends on 'belt', a force, .* algebraic loop; use a position or a speed"),
        ([control("governor.spindle_torque")], {}, "spindle_torque', a force, which follows from the loads: this is an algebraic loop"),
        ([control("governor.spindle_speed")], GIVEN, "depends on 'governor.spindle_speed', but that speed is given"),
        ([control("governor.sleeve_left")], {}, "depends on 'governor.sleeve_left', which is no reading; .*mean 'governor.sleeve_lift'"),
    ],
)
def test_impossible_couplings_are_refused(couplings, changes, message):
    engine, governor = engine_part(torque=InputFunction()), replace(porter_part(), **changes)
    refuses(f"(?is){message}", coupled_scene, engine, governor, couplings=tuple(couplings))


def test_a_spindle_follows_no_follower():
    parts = (engine_part(), replace(porter_part(), name="a", **FOLLOWER), replace(porter_part(), name="b", **FOLLOWER))
    couplings = (follow("belt", second="a.spindle_angle"), follow("chain", "a.spindle_angle", "b.spindle_angle"))
    with pytest.raises(MechanismError, match=r"'chain' follows 'a.spindle_angle', which follows 'engine.crank_angle' itself; follow that"):
        coupled_scene(*parts, couplings=couplings)


def test_a_loop_of_gears_over_three_parts_is_refused():
    parts = [discs_part(name, {"wheel": 1.0}) for name in ("a", "b", "c")]
    loop = [
        gear(f"{i}{j}", f"{i}.wheel_angle", f"{j}.wheel_angle", ratio)
        for i, j, ratio in (("a", "b", 2.0), ("c", "b", 4.0), ("c", "a", 3.0))
    ]
    coupled_scene(*parts, couplings=tuple(loop[:2]))
    with pytest.raises(MechanismError, match=r"'ca' closes a loop of gears and contradicts the others: .* is 2, and here it is 3"):
        coupled_scene(*parts, couplings=tuple(loop))


@pytest.mark.parametrize(
    ("values", "message"),
    [({"ratio": 0.0}, "must not be 0"), ({"ratio": float("nan")}, "ratio of coupling 'belt'"), ({"second": CRANK}, "couples .* to itself")],
)
def test_impossible_ratios_are_refused(values, message):
    refuses(message, gear, **values)


def test_parts_of_one_name_are_refused():
    refuses("part 'engine' is listed twice", coupled_scene, engine_part(), engine_part())


def test_names_of_several_parts_begin_with_the_part():
    scene = coupled_scene(engine_part(), porter_part(), couplings=(gear(),))
    assert scene.mechanism.reading(CRANK).body == "engine.crank"
    assert [body.name for body in scene.mechanism.bodies][-1] == "governor.spindle"
    assert scene.mechanism.joints[-1].name == "belt"
    assert scene.part_of(SPINDLE) == (scene.parts[1], "spindle_angle")
    assert scene.start.rates[SPINDLE] == 13.0
    with pytest.raises(MechanismError, match=r"this scene has the parts 'engine', 'governor'"):
        _ = scene.part
