"""The slide valve against Marks, Zeuner and the law of cosines: displacement, motion, leads and the events of steam."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form import slider_crank as crank
from governor_mechanism.machines.slide_valve import EQUAL_CUT_OFFS, EQUAL_LEADS
from governor_mechanism.mechanics.kinematics.kinematic_analysis import follow
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import ENDS, PORTS, at_angles, event_angles, reading_of, setting_of
from governor_mechanism.verification.report import Row
from governor_mechanism.verification.slider_crank import TURN, compared, crank_angles, ended, in_motion, running

FOUND = 1e-10
"""rad: to that the events are promised; the two ways to find them part by about 1e-15."""


def findings(scene: Scene) -> Iterator[Row | str]:
    """Every comparison that applies to the scene."""
    eccentric = closed.Eccentric.of(scene.part.dimensions)
    centre = None if setting_of(scene) == EQUAL_LEADS else scene.part.dimensions["centre"]
    yield from _moving(scene, eccentric, centre)
    found = event_angles(scene)
    sizes = scene.part.dimensions
    laws = partial(
        closed.event_angle, eccentric, outside_lap=sizes["outside_lap"], inside_lap=sizes["inside_lap"], centre=centre
    )
    exact = {name: laws(event=name) for name in found}
    for name, angle in found.items():
        yield Row(
            quantity=name,
            simulated=angle,
            expected=exact[name],
            allowed=FOUND,
            unit="rad",
            reason="the mechanism's port against the law of cosines; rounding leaves about 1e-15",
        )
    yield from _set(scene, found, eccentric, centre)
    run = running(scene)
    yield from ended(run)
    if len(run.times) < 2:
        return
    angles = crank_angles(scene, run)
    yield in_motion(
        run, "valve_displacement", np.asarray(closed.displacement(eccentric, crank_angle=angles, centre=centre))
    )
    ways = np.asarray(
        crank.travel_from_outer_end(crank.CrankTrain.of(scene.part.dimensions), crank_angle=angles + math.pi)
    )
    yield in_motion(run, "head_end_travel", ways)
    yield from _events_in_motion(scene, exact)


def _moving(scene: Scene, eccentric: closed.Eccentric, centre: float | None) -> Iterator[Row]:
    """Valve and piston over a turn."""
    speed, train = scene.part.dimensions["crank_speed"], crank.CrankTrain.of(scene.part.dimensions)
    at, going = {"crank_angle": TURN}, {"crank_angle": TURN, "crank_rate": speed}
    beyond, running_on = {"crank_angle": TURN + math.pi}, {"crank_angle": TURN + math.pi, "crank_rate": speed}
    yield from compared(
        follow(scene, "crank_angle", TURN, speed),
        {"valve_displacement": "valve", "head_end_travel": "piston"},
        {
            "valve_displacement": (
                closed.displacement(eccentric, **at, centre=centre),
                closed.velocity(eccentric, **going),
                closed.acceleration(eccentric, **going),
            ),
            "head_end_travel": (
                crank.travel_from_outer_end(train, **beyond),
                -np.asarray(crank.crosshead_velocity(train, **running_on)),
                -np.asarray(crank.crosshead_acceleration(train, **running_on)),
            ),
        },
        speed,
        {"valve_displacement": eccentric.radius, "head_end_travel": train.crank},
    )


def _set(
    scene: Scene, found: Mapping[str, float], eccentric: closed.Eccentric, centre: float | None
) -> Iterator[Row | str]:
    """Leads, and what the setting promises."""
    exact = closed.leads(eccentric, outside_lap=scene.part.dimensions["outside_lap"], centre=centre)
    dead = at_angles(scene, np.array([0.0, math.pi])).readings
    for k, (end, wanted) in enumerate(zip(ENDS, exact, strict=True)):
        yield Row(
            quantity=f"lead at the {end}",
            simulated=float(dead[reading_of(end, "steam")][k]),
            expected=wanted,
            allowed=1e-10 * eccentric.radius,
            unit="m",
            reason="of the eccentric's radius; both are algebra",
        )
    if setting_of(scene) == EQUAL_LEADS and not eccentric.endless:
        yield Row(
            quantity="centre of the swing for equal leads",
            simulated=scene.part.dimensions["centre"],
            expected=closed.equal_lead_centre(eccentric),
            allowed=1e-10 * eccentric.radius,
            unit="m",
            reason="of the eccentric's radius; both are algebra",
        )
    if setting_of(scene) == EQUAL_CUT_OFFS:
        stroke = 2 * scene.part.dimensions["crank"]
        ways = at_angles(scene, np.array([found[f"{end} cut-off"] for end in ENDS])).readings
        yield Row(
            quantity="cut-off at the crank end, against the head end's",
            simulated=float(ways["crank_end_travel"][0]) / stroke,
            expected=float(ways["head_end_travel"][1]) / stroke,
            allowed=FOUND,
            unit="1",
            reason="the setting makes the two strokes equal",
        )
    if eccentric.endless:
        yield "the eccentric rod is endless: there is no error term"


def _events_in_motion(scene: Scene, exact: Mapping[str, float]) -> Iterator[Row]:
    """The events as a run passes them for the first time: the run reports those very moments, and how far it is off."""
    speed, start = scene.part.dimensions["crank_speed"], scene.part.dimensions["crank_start"]
    moments = {name: (angle - start) % math.tau / speed for name, angle in exact.items()}
    passed = {name: time for name, time in moments.items() if time <= scene.run.duration}
    if not passed:
        return
    times = np.unique(list(passed.values()))
    run = running(scene, times)
    if len(run.times) < len(times):
        return  # it ended early, as the scene's own run did, of which there is a note
    for end in ENDS:
        for port, names in PORTS.items():
            reading = reading_of(end, port)
            for name in (f"{end} {what}" for what in names):
                if name not in passed:
                    continue
                k = int(np.searchsorted(times, passed[name]))
                rate = float(run.rates[reading][k])
                yield Row(
                    quantity=f"{name} in motion",
                    simulated=exact[name] - float(run.readings[reading][k]) / rate * speed,
                    expected=exact[name],
                    allowed=scene.run.accuracy * run.scales[reading] * speed / abs(rate),
                    unit="rad",
                    reason="the accuracy asked of the run, at the speed with which the port's edge passes",
                )
