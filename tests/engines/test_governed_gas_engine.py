"""A governor that throttles an engine with gas in its cylinder: engines against each other and against equations written out by hand."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.selection import select_engine
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.scenes.parser import parse_scene_document

AREA, STROKE, CUT_OFF, CLEARANCE = 0.05, 0.65, 0.375, 0.05
SUPPLY, BACK, LOAD, INERTIA = 4e5, 1.5e5, 900.0, 400.0
ARM, BALL, DAMPING, RATIO = 0.3, 5.0, 8.0, 0.6
LOW_LIFT, HIGH_LIFT, GRAVITY = 0.06, 0.14, 9.81
START_ANGLE, START_SPEED, TURNS = 0.7, 13.0, 10
CONTROL = {"type": "control", "reading": "governor.sleeve_lift", "scales": "engine.throttle", "table": [[LOW_LIFT, 1.0], [HIGH_LIFT, 0.0]]}


def governed_engine(coupling="follow", rod=None, control=CONTROL, accuracy=1e-8, **effects):
    """Return an engine with a throttle, closed by the sleeve of a Watt governor, for about ten turns."""
    dimensions = {
        "area": AREA, "stroke": STROKE, "cut_off": CUT_OFF, "clearance": CLEARANCE, "throttle": 1.0, "supply_pressure": SUPPLY,
        "back_pressure": BACK, "load_torque": LOAD, "inertia": INERTIA, "rim_radius": 1.5,
    }  # fmt: skip
    if rod:
        dimensions["connecting_rod"] = rod
    engine = {"machine": "flywheel_engine", "dimensions": dimensions, "start": {"crank_angle": 0.0, "crank_rate": START_SPEED}}
    governor = {
        "machine": "pendulum_governor",
        "dimensions": {"arm": ARM, "link": ARM, "offset": 0, "ball_mass": BALL},
        "effects": {"gravity": GRAVITY, "centrifugal": True, "dashpot": {"arm_angle": DAMPING}, **effects},
        "start": {"arm_angle": START_ANGLE},
    }
    belt = {"type": coupling, "first": "engine.crank_angle", "second": "governor.spindle_angle", "ratio": RATIO}
    return parse_scene_document(
        {
            "title": "Governed engine",
            "run": {"duration": f"{TURNS * math.tau / START_SPEED} s", "output_interval": "20 ms", "accuracy": accuracy},
            "part": {"engine": engine, "governor": governor},
            "coupling": {"belt": belt, "throttle": control},
        }
    )


def travel(angle, rod):
    """Return the travel of the piston and its derivative by the crank angle, m; an endless rod is None."""
    radius, sine, cosine = 0.5 * STROKE, math.sin(angle), math.cos(angle)
    if rod is None:
        return radius * (1 - cosine), radius * sine
    height = math.sqrt(rod**2 - (radius * sine) ** 2)
    return radius * (1 - cosine) - rod + height, radius * sine - radius**2 * sine * cosine / height


def lift(arm_angle):
    return 2 * ARM * (1 - math.cos(arm_angle))


def stroke_travel(angle, stroke, rod):
    """Return the travel since the last dead centre, relative to the stroke, in a stroke counted from 0."""
    relative = travel(angle, rod)[0] / STROKE
    return 1 - relative if stroke % 2 else relative


def equations(state, stroke, is_cut_off, segment, coupling, rod):
    """Return the rates of arm angle, its rate, crank angle and speed within one phase of the cycle and one segment of the throttle."""
    angle, rate, crank_angle, speed = state
    opening = (1.0, 1 - (lift(angle) - LOW_LIFT) / (HIGH_LIFT - LOW_LIFT), 0.0)[segment]
    pressure = BACK + opening * (SUPPLY - BACK)
    if is_cut_off:  # isotherm
        pressure *= (CLEARANCE + CUT_OFF) / (CLEARANCE + stroke_travel(crank_angle, stroke, rod))
    torque = AREA * (pressure - BACK) * (-1) ** stroke * travel(crank_angle, rod)[1] - LOAD
    sine, cosine, inertia = math.sin(angle), math.cos(angle), INERTIA
    if coupling == "gear":  # both balls turn with the shaft, and are moved out against their moment of momentum
        inertia += RATIO**2 * 2 * BALL * (ARM * sine) ** 2
        torque -= RATIO**2 * 4 * BALL * ARM**2 * sine * cosine * rate * speed
    acceleration = (RATIO * speed) ** 2 * sine * cosine - GRAVITY / ARM * sine - DAMPING / (2 * BALL * ARM**2) * rate
    return [rate, acceleration, speed, torque / inertia]


def reference(times, coupling, rod):
    """Return the states of an independent integration at times, (n, 4), from kink to kink."""
    time, state, rows = 0.0, [START_ANGLE, 0.0, 0.0, START_SPEED], []
    stroke, is_cut_off, segment = 0, False, int(np.searchsorted([LOW_LIFT, HIGH_LIFT], lift(START_ANGLE)))
    seen = set()
    while len(rows) < len(times):
        seen.add(segment)
        phase = stroke, is_cut_off, segment

        def dead_centre(_, y, stroke=stroke):
            return y[2] - (stroke + 1) * math.pi

        def cut_off(_, y, stroke=stroke, is_cut_off=is_cut_off):
            return 1.0 if is_cut_off else stroke_travel(y[2], stroke, rod) - CUT_OFF

        def upper(_, y, segment=segment):
            return lift(y[0]) - (LOW_LIFT, HIGH_LIFT, np.inf)[segment]

        def lower(_, y, segment=segment):
            return (-np.inf, LOW_LIFT, HIGH_LIFT)[segment] - lift(y[0])

        events = [dead_centre, cut_off, upper, lower]
        for event in events:
            event.terminal, event.direction = True, 1
        done = solve_ivp(
            lambda _, y, phase=phase: equations(y, *phase, coupling, rod),
            (time, times[-1] + 1e-9), state, method="DOP853", rtol=1e-12, atol=1e-13, events=events, dense_output=True,
        )  # fmt: skip
        end = done.t[-1]
        rows += [done.sol(one) for one in times[len(rows) :] if one <= end]
        time, state = end, done.y[:, -1]
        hit = [len(found) > 0 for found in done.t_events]
        if hit[0]:
            stroke, is_cut_off = stroke + 1, False
        is_cut_off, segment = is_cut_off or hit[1], segment + hit[2] - hit[3]
    assert seen == {0, 1, 2}  # the throttle is open, on the way and closed
    return np.array(rows)


@pytest.mark.parametrize(("coupling", "rod"), [("follow", None), ("gear", 1.6)])
def test_a_governed_engine_moves_as_its_equations_integrated_from_kink_to_kink(coupling, rod):
    run = gm.run(governed_engine(coupling, rod, accuracy=1e-10), engine="reduced")
    assert run.outcome.ok, run.message
    exact = reference(run.times, coupling, rod)
    found = [
        run.readings["governor.arm_angle"], run.rates["governor.arm_angle"], run.readings["engine.crank_angle"],
        run.rates["engine.crank_angle"],
    ]  # fmt: skip
    # Ten times the accuracy: rates have scales of several rad/s, and the reference adds its own error.
    np.testing.assert_allclose(np.transpose(found), exact, rtol=0, atol=1e-9)
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize("coupling", ["follow", "gear"])
@pytest.mark.parametrize("rod", [None, 1.3])
def test_reduced_and_multibody_agree_on_a_governed_engine(coupling, rod):
    scene = governed_engine(coupling, rod)
    reduced, multibody = (gm.run(scene, engine=engine) for engine in ("reduced", "multibody"))
    assert reduced.outcome.ok
    limit = reduced.error_estimate + multibody.error_estimate
    for name, values in reduced.readings.items():
        np.testing.assert_allclose(values, multibody.readings[name], rtol=0, atol=limit * reduced.scales[name], err_msg=name)
    for run in (reduced, multibody):
        assert run.energy.drift < 1e-9
    assert select_engine("auto", scene)[0].name == "reduced"


def test_stops_and_kinks_take_turns():
    """The sleeve strikes a stop while gas changes its phases: both engines log the same impacts."""
    scene = governed_engine(stops={"arm_angle": [0.5, 0.9], "restitution": 0.3})
    runs = [gm.run(scene, engine=engine) for engine in ("reduced", "multibody")]
    assert any(event.kind.name == "IMPACT" for event in runs[0].events)
    times = [[event.time for event in run.events if event.kind.name == "IMPACT"] for run in runs]
    np.testing.assert_allclose(*times, rtol=0, atol=1e-7)  # ten times the accuracy


def test_a_throttle_of_the_speed_and_of_the_travel_agrees_with_multibody():
    """Factors of readings of the shaft: the speed by a table, the travel of the piston by a line."""
    for function in (
        {"table": [[7.4, 1.0], [7.9, 0.2]], "reading": "governor.spindle_speed"},
        {"gain": 1.0, "reading": "engine.piston_travel"},
    ):
        control = {"type": "control", "scales": "engine.throttle", **function}
        scene = governed_engine("gear", control=control)
        reduced, multibody = (gm.run(scene, engine=engine) for engine in ("reduced", "multibody"))
        limit = reduced.error_estimate + multibody.error_estimate
        for name in ("engine.crank_angle", "governor.arm_angle"):
            np.testing.assert_allclose(reduced.readings[name], multibody.readings[name], rtol=0, atol=limit * reduced.scales[name])


@pytest.mark.parametrize("engine", [ReducedEngine, MultibodyEngine])
def test_a_kink_costs_few_steps_and_no_order(engine):
    """Each dead centre and cut-off ends a step, found after at most three others; the error falls as if there were none."""
    scene, n_kinks, angles = governed_engine("gear", 1.6), 4 * TURNS, []
    exact = reference(engine().run(scene).times[-1:], "gear", 1.6)[0, 2]
    for tolerance in (1e-10, 1e-12):
        run = engine(tolerance=tolerance).run(scene, certify=False)
        angles.append(run.readings["engine.crank_angle"][-1])
        assert run.cost.rejected < 3.5 * n_kinks + 20  # 20: other rejections, and the kinks of the table
    errors = np.abs(np.array(angles) - exact)
    assert errors[0] < 1e-8  # a hundred steps of such a tolerance
    assert errors[1] < 2e-10  # and not less than the error of the reference


def test_a_cut_off_that_moves_is_refused_by_name():
    control = {"type": "control", "reading": "governor.sleeve_lift", "sets": "engine.cut_off", "gain": -2.0, "about": 0.1}
    document_scene = governed_engine(control={**CONTROL, "table": [[0.06, 1.0], [0.14, 0.5]]})
    assert select_engine("auto", document_scene)[0].name == "reduced"
    document = dict(document_scene.document)
    part = {**document["part"], "engine": {**document["part"]["engine"], "dimensions": dict(document["part"]["engine"]["dimensions"])}}
    del part["engine"]["dimensions"]["throttle"]
    moving = parse_scene_document({**document, "part": part, "coupling": {**document["coupling"], "throttle": control}})
    with pytest.raises(gm.UnsupportedEffect, match=r"the cut-off of 'engine.expansion', which moves; choose engine"):
        gm.run(moving, engine="reduced")


@pytest.mark.long
@pytest.mark.parametrize("name", ["governed_engine", "governed_engine_mean_torque"])
def test_engines_agree_over_two_hundred_turns_and_impulse_refuses_by_name(name):
    changes = {"run.duration": 105.0, "run.output_interval": 0.1, "run.accuracy": 1e-6}
    scene = parse_scene_with(gm.load(name).document, changes.items())
    reduced, multibody = (gm.run(scene, engine=engine) for engine in ("reduced", "multibody"))
    assert reduced.outcome.ok
    assert multibody.outcome.ok
    assert reduced.readings["engine.crank_angle"][-1] > 200 * math.tau
    for reading in ("engine.crank_angle", "governor.arm_angle"):
        difference = np.abs(reduced.readings[reading] - multibody.readings[reading]).max() / reduced.scales[reading]
        assert difference <= reduced.error_estimate + multibody.error_estimate
    with pytest.raises(gm.UnsupportedEffect, match="one part and no couplings"):
        gm.run(scene, engine="impulse")
