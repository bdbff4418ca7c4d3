"""Stephenson's link motion against the closure of its rods: valve, die and link over a turn and in motion, valve events, lead."""

import math

import numpy as np

from governor_mechanism.closed_form import slider_crank as crank
from governor_mechanism.closed_form import stephenson as closed
from governor_mechanism.model.joints import TranslationalDriver
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables import valve_motion as timing
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.machines import comparisons
from governor_mechanism.verification.machines.slider_crank import CHECKED_CRANK_ANGLES, crank_angles

N_CHECKED_TIMES = 200
"""Largest number of reported times at which a run is compared; the closed form takes 0.2 ms each."""


def check_stephenson_gear(scene: Scene) -> comparisons.Checks:
    """Yield every comparison that applies to the scene."""
    link_gear = closed.LinkGear.from_dimensions(scene.part.dimensions)
    gears = gears_of(scene)
    for gear in gears:
        yield from _check_gear(scene if len(gears) == 1 else scene_in_gear(scene, gear), link_gear, gear)
    yield from _check_setting(scene, link_gear)
    run = comparisons.run_scene(scene)
    yield from comparisons.note_early_end(run)
    if len(run.times) > 1:
        yield from _check_motion(scene, run, link_gear)


def scene_in_gear(
    scene: Scene,
    gear: float,  # position of the lever, from 1, full forward, to -1
) -> Scene:
    """Return the scene with the reversing lever at rest."""
    return parse_scene_with(scene.document, [("dimensions.reverser", gear)])


def gears_of(scene: Scene) -> list[float]:
    """Return the gears between which the reversing lever moves, the most forward one first, or the only one (or one)."""
    mechanism = scene.part.mechanism
    motion = next((joint.motion for joint in mechanism.joints if isinstance(joint, TranslationalDriver)), None)
    if motion is None:
        return [scene.part.dimensions["reverser"]]
    reading = mechanism.reading("reverser")
    if not isinstance(reading, PointCoordinate):
        raise TypeError(f"the position of the lever is read from the lifting arm; found a {type(reading).__name__}")
    positions = [round(reading.direction_y * height - reading.zero, 12) for height in motion.values]
    return sorted({min(positions), max(positions)}, reverse=True)


def _check_gear(scene: Scene, link_gear: closed.LinkGear, gear: float) -> comparisons.Checks:
    """Yield the positions over a turn and the valve events in one gear."""
    label = f"gear {gear:.3g}: "
    readings = valve_motion_of(scene).evaluate(CHECKED_CRANK_ANGLES).readings
    exact = closed.link_position(link_gear, crank_angle=CHECKED_CRANK_ANGLES, gear=gear)
    centre = scene.part.dimensions["centre"]
    places = [f"{math.degrees(angle):.4g} deg" for angle in CHECKED_CRANK_ANGLES]
    reason = "no integration; rounding and position assembly leave about 1e-14"
    # The angle of the body is anticlockwise in a plane in which the valve line leads to the left.
    for name, expected, scale, unit in (
        ("valve_displacement", np.asarray(exact.valve) - centre, link_gear.radius, "m"),
        ("die_slip", exact.die_offset, link_gear.radius, "m"),
        ("link_angle", -np.asarray(exact.link_angle), 1.0, "rad"),
        ("reverser", np.full(len(CHECKED_CRANK_ANGLES), gear), 1.0, "1"),
    ):
        text = f"{label}{name.replace('_', ' ')}"
        allowed = comparisons.ALGEBRAIC_TOLERANCE * scale
        yield comparisons.compare_largest_deviation(text, readings[name], expected, places, allowed, unit, reason)
    yield from _check_events(scene, link_gear, gear)
    yield _describe_first_order_law(readings["valve_displacement"], exact, link_gear, label)


def _check_events(scene: Scene, link_gear: closed.LinkGear, gear: float) -> comparisons.Checks:
    """Yield the displacement of the valve, by the closed form, at each of its events: plus or minus a lap."""
    laps = {port: scene.part.dimensions[f"{lap}_lap"] for port, lap in (("steam", "outside"), ("exhaust", "inside"))}
    ports = {event: port for port, events in timing.PORT_EVENTS.items() for event in events}
    for name, angle in timing.find_event_angles(scene).items():
        end, event = name.rsplit(" ", 1)
        port = ports[event]
        sign = 1.0 if (end == "crank end") == (port == "steam") else -1.0
        position = closed.link_position(link_gear, crank_angle=angle, gear=gear)
        displacement = float(position.valve) - scene.part.dimensions["centre"]
        text = f"gear {gear:.3g}: displacement at {name}"
        yield comparisons.compare_algebraic(text, sign * laps[port], displacement, "m", scale=link_gear.radius)


def _describe_first_order_law(displacement: FloatArray, exact: closed.LinkPosition, link_gear: closed.LinkGear, label: str) -> str:
    """Return a note on the first harmonic of the displacement (n,) over a turn, m, and Zeuner's law for it."""
    harmonic = 2.0 * np.fft.rfft(displacement)[1] / len(displacement)
    ratio = float(np.mean(exact.die_offset)) / link_gear.half_link
    law = closed.first_order_amplitudes(link_gear, offset_ratio=ratio)
    true, expected = (f"{1e3 * a:.4g} cos w {1e3 * b:+.4g} sin w" for a, b in ((harmonic.real, -harmonic.imag), law))
    return f"{label}first harmonic {true} mm; Zeuner's first-order law gives {expected} mm: it takes the eccentrics for small"


def _check_setting(scene: Scene, link_gear: closed.LinkGear) -> comparisons.Checks:
    """Yield the centre of the valve's motion: the middle between its positions at the dead centres."""
    dimensions = scene.part.dimensions
    dead_centres = closed.link_position(link_gear, crank_angle=np.array([0.0, math.pi]), gear=dimensions["valve_set_at"])
    middle = float(np.mean(dead_centres.valve))
    yield comparisons.compare_algebraic("centre of the valve's motion", dimensions["centre"], middle, "m", scale=link_gear.radius)


def _check_motion(scene: Scene, run: Trajectory, link_gear: closed.LinkGear) -> comparisons.Checks:
    """Yield the readings of a run at some of its times; the lever is where the run reports it."""
    rows = np.unique(np.linspace(0, len(run.times) - 1, N_CHECKED_TIMES).astype(int))
    angles = crank_angles(scene, run)[rows]
    places = [f"t = {time:.4g} s" for time in run.times[rows]]
    exact = closed.link_position(link_gear, crank_angle=angles, gear=run.readings["reverser"][rows])
    train = crank.CrankTrain.from_dimensions(scene.part.dimensions)
    for name, expected in (
        ("valve_displacement", np.asarray(exact.valve) - scene.part.dimensions["centre"]),
        ("die_slip", exact.die_offset),
        ("head_end_travel", crank.travel_from_outer_dead_centre(train, crank_angle=angles + math.pi)),
    ):
        allowed = scene.run.accuracy * run.scales[name]
        reason = "the requested accuracy times the scale of the reading"
        text = f"{name.replace('_', ' ')} in motion"
        yield comparisons.compare_largest_deviation(text, run.readings[name][rows], expected, places, allowed, "m", reason)
