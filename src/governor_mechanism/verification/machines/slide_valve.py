"""The slide valve against Marks, Zeuner and the law of cosines: displacement, motion, leads and valve events."""

import math
from collections.abc import Mapping

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form import slider_crank as crank
from governor_mechanism.machines.slide_valve import EQUAL_CUT_OFFS, prescribed_centre, valve_setting
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import EQUAL_LEADS
from governor_mechanism.observables import valve_motion as timing
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.verification.machines.comparisons import Checks, compare_algebraic, compare_reading, note_early_end, run_scene
from governor_mechanism.verification.machines.slider_crank import CHECKED_CRANK_ANGLES, compare_kinematics, crank_angles
from governor_mechanism.verification.report import ComparisonRow

EVENT_READINGS = {
    f"{end} {event}": f"{end.replace(' ', '_')}_{port}"
    for end in timing.CYLINDER_ENDS
    for port, events in timing.PORT_EVENTS.items()
    for event in events
}
"""Reading of the port's opening, which is zero at the event, by event."""


def check_slide_valve(scene: Scene) -> Checks:
    """Yield every comparison that applies to the scene."""
    dimensions = scene.part.dimensions
    eccentric = closed.Eccentric.from_dimensions(dimensions)
    train = crank.CrankTrain.from_dimensions(dimensions)
    centre = prescribed_centre(scene)
    yield from _check_kinematics(scene, eccentric, train, centre)
    simulated_angles = timing.find_event_angles(scene)
    laps = {name: dimensions[name] for name in ("outside_lap", "inside_lap")}
    exact_angles = {name: closed.event_angle(eccentric, event=name, **laps, centre=centre) for name in simulated_angles}
    for name, angle in simulated_angles.items():
        yield compare_algebraic(name, angle, exact_angles[name], "rad", scale=1.0)
    yield from _check_setting(scene, simulated_angles, eccentric, centre)
    run = run_scene(scene)
    yield from note_early_end(run)
    if len(run.times) < 2:
        return
    angles = crank_angles(scene, run)
    yield compare_reading(run, "valve_displacement", closed.valve_displacement(eccentric, crank_angle=angles, centre=centre))
    yield compare_reading(run, "head_end_travel", crank.travel_from_outer_dead_centre(train, crank_angle=angles + math.pi))
    yield from _check_events_in_motion(scene, exact_angles)


def _check_kinematics(scene: Scene, eccentric: closed.Eccentric, train: crank.CrankTrain, centre: float | None) -> Checks:
    """Yield the kinematics of valve and piston over a revolution."""
    motion = {"crank_angle": CHECKED_CRANK_ANGLES, "crank_rate": scene.part.dimensions["crank_speed"]}
    opposite = motion | {"crank_angle": CHECKED_CRANK_ANGLES + math.pi}
    displacement = closed.valve_displacement(eccentric, crank_angle=CHECKED_CRANK_ANGLES, centre=centre)
    valve = (displacement, closed.valve_velocity(eccentric, **motion), closed.valve_acceleration(eccentric, **motion))
    travel = crank.travel_from_outer_dead_centre(train, crank_angle=opposite["crank_angle"])
    piston = (travel, -crank.crosshead_velocity(train, **opposite), -crank.crosshead_acceleration(train, **opposite))
    valve_motion = ("valve_displacement", "valve", eccentric.radius, valve)
    yield from compare_kinematics(scene, valve_motion, ("head_end_travel", "piston", train.crank, piston))


def _check_setting(scene: Scene, simulated_angles: Mapping[str, float], eccentric: closed.Eccentric, centre: float | None) -> Checks:
    """Yield the leads, and what the setting of the valve prescribes."""
    exact_leads = closed.leads(eccentric, outside_lap=scene.part.dimensions["outside_lap"], centre=centre)
    for end, simulated_lead, expected_lead in zip(timing.CYLINDER_ENDS, valve_motion_of(scene).leads, exact_leads, strict=True):
        yield compare_algebraic(f"lead at the {end}", simulated_lead, expected_lead, "m", scale=eccentric.radius)
    if valve_setting(scene) == EQUAL_LEADS and not eccentric.has_infinite_rod:
        centre = scene.part.dimensions["centre"]
        expected_centre = closed.equal_lead_centre(eccentric)
        yield compare_algebraic("centre of the swing for equal leads", centre, expected_centre, "m", scale=eccentric.radius)
    if valve_setting(scene) == EQUAL_CUT_OFFS:
        stroke = 2 * scene.part.dimensions["crank"]
        cut_off_angles = np.array([simulated_angles[f"{end} cut-off"] for end in timing.CYLINDER_ENDS])
        readings = valve_motion_of(scene).evaluate(cut_off_angles).readings
        crank_end = readings["crank_end_travel"][0] / stroke
        head_end = readings["head_end_travel"][1] / stroke
        yield compare_algebraic("cut-off at the crank end against the head end", crank_end, head_end, "1", scale=1.0)
    if eccentric.has_infinite_rod:
        yield "the eccentric rod is infinitely long: there is no error term"


def _check_events_in_motion(scene: Scene, exact_angles: Mapping[str, float]) -> Checks:
    """Yield the crank angles of the events in a run that reports at the exact event times."""
    speed = scene.part.dimensions["crank_speed"]
    start = scene.part.dimensions["crank_start"]
    event_times = {name: (angle - start) % math.tau / speed for name, angle in exact_angles.items()}
    times_in_run = {name: time for name, time in event_times.items() if time <= scene.run.duration}
    if not times_in_run:
        return
    times = np.unique(list(times_in_run.values()))
    run = run_scene(scene, times)
    if len(run.times) < len(times):
        return  # ended early like the scene's own run, which has a note
    for name, time in times_in_run.items():
        k, reading = int(np.searchsorted(times, time)), EVENT_READINGS[name]
        rate = float(run.rates[reading][k])
        simulated_angle = exact_angles[name] - float(run.readings[reading][k]) / rate * speed
        allowed = scene.run.accuracy * run.scales[reading] * speed / abs(rate)
        reason = "the requested accuracy, divided by the velocity of the port's edge"
        yield ComparisonRow(f"{name} in motion", simulated_angle, exact_angles[name], allowed, "rad", reason)
