"""The slide valve in closed form: recomputed tables, Marks' curves, the size of what is neglected, events, refusals."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slide_valve import VALVE_EVENTS, Eccentric
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from printed_numbers import half_unit_of_last_digit
from reference import marks

LAPS = {"outside_lap": marks.OUTSIDE_LAP, "inside_lap": marks.INSIDE_LAP}
RATIOS = (4, 30)
TURN = np.radians(np.arange(0.0, 360.0, 1.0))

# Dimensions of eccentrics as they may be built; advances as far as they are allowed.
advances = st.floats(-1.5, 1.5)
eccentrics = st.builds(
    lambda radius, ratio, advance: Eccentric(radius=radius, rod=ratio * radius, advance=advance),
    st.floats(0.01, 0.2),
    st.floats(1.2, 60.0),
    advances,
)


def of_ratio(ratio: float, advance: float = math.radians(marks.ADVANCE_DEG)) -> Eccentric:
    return Eccentric(radius=marks.ECCENTRIC, rod=ratio * marks.ECCENTRIC, advance=advance)


def error_by(curve: Callable[..., Any], eccentric: Eccentric, angle: Any) -> Any:
    """Return the error term (m) at crank angles (rad) by one of Marks' curves over the theoretical displacement."""
    return np.asarray(curve(eccentric, theoretical=closed.first_order_displacement(eccentric, crank_angle=angle)))


def is_printed(value: float, printed: float, digits: int = 12) -> None:
    """The value rounds to the printed one, zeros to the rounding of metres and radians."""
    assert abs(value - printed) <= max(half_unit_of_last_digit(printed, digits), 1e-16), (value, printed)


def stroke(train: CrankTrain, angle: float, end: str) -> float:
    gone = float(travel_from_outer_dead_centre(train, crank_angle=angle + math.pi)) / (2 * train.crank)
    return 1 - gone if end == "crank" else gone


@pytest.mark.parametrize(
    ("ratio", "row"), [(ratio, row) for ratio in RATIOS for row in marks.VALVE_EVENTS[ratio]], ids=lambda value: str(value)[:28]
)
def test_the_events_are_met_to_the_printed_digits(ratio: int, row: tuple[object, ...]) -> None:
    name = str(row[0])
    theory, exact, _, shift, *strokes = (float(value) for value in row[1:])  # type: ignore[arg-type]
    angles = [closed.event_angle(of_ratio(rod_ratio), event=name, **LAPS) for rod_ratio in (math.inf, ratio)]
    for angle, printed in zip(angles, (theory, exact), strict=True):
        is_printed(math.degrees(angle), printed)
    # the shift cancels from some 360 deg to as little as 0.09: four digits of double precision
    assert abs(math.degrees(angles[1] - angles[0]) - shift) <= half_unit_of_last_digit(shift) + 2e-13
    finite, infinite = (CrankTrain(crank=marks.CRANK, rod=rod) for rod in (marks.CONNECTING_ROD, math.inf))
    end = name.split()[0]
    cases = [(infinite, angles[0]), (infinite, angles[1]), (finite, angles[0]), (finite, angles[1])]
    for (train, angle), printed in zip(cases, strokes, strict=True):
        # 1 less a part that is nearly 1: 1e-16 of rounding on top of the printed digits
        assert abs(stroke(train, angle, end) - printed) <= half_unit_of_last_digit(printed) + 2e-16


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_sizes_of_the_error_are_met(ratio: int) -> None:
    eccentric, sizes = of_ratio(ratio), marks.ERROR_TERM_SIZES[ratio]
    is_printed(closed.equal_lead_centre(eccentric), sizes["centre"])
    is_printed(closed.parabola_constant(eccentric), sizes["parabola_constant"])
    is_printed(-closed.parabola_constant(eccentric) / (2 * eccentric.rod), sizes["vertex"])
    is_printed(eccentric.radius**4 / (8 * eccentric.rod**3), sizes["neglected"])
    extremes = np.array([math.pi / 2, math.pi]) - eccentric.advance
    for law, name in ((closed.parabola_error, "binomial_extremes"), (closed.hyperbola_error, "exact_extremes")):
        for value, printed in zip(error_by(law, eccentric, extremes), sizes[name], strict=True):
            # differences of lengths near l: 1e-16 of rounding
            assert abs(value - printed) <= half_unit_of_last_digit(printed) + 4e-16 * ratio
    dead = np.array([math.pi / 2, 3 * math.pi / 2]) - eccentric.advance
    for value, printed in zip(closed.valve_displacement(eccentric, crank_angle=dead), sizes["displacements"], strict=True):
        is_printed(value, printed)
    left = np.abs(error_by(closed.hyperbola_error, eccentric, TURN) - error_by(closed.parabola_error, eccentric, TURN))
    assert left.max() <= sizes["largest_neglected"]
    leads = closed.leads(eccentric, outside_lap=marks.OUTSIDE_LAP, centre=eccentric.rod)
    for value, printed in zip(leads, sizes["leads_from_middle"], strict=True):
        # by the binomial law, as the table is; the exact ones differ by r^4 / 8 l^3
        assert abs(value - printed) <= sizes["largest_neglected"]


@pytest.mark.parametrize("row", marks.ERROR_TERMS, ids=lambda row: f"{row[0]}deg")
def test_the_error_table_is_met(row: tuple[float, ...]) -> None:
    eccentric, angle = of_ratio(4), math.radians(row[0])
    theory = closed.first_order_displacement(eccentric, crank_angle=angle)
    is_printed(theory, row[1])
    is_printed(closed.valve_displacement(eccentric, crank_angle=angle), row[2])
    # differences of lengths near l = 0.24 m: 1e-16 of rounding
    for value, printed in zip(
        (
            closed.hyperbola_error(eccentric, theoretical=theory),
            closed.parabola_error(eccentric, theoretical=theory),
            closed.circle_error(eccentric, theoretical=theory),
        ),
        row[3:],
        strict=True,
    ):
        assert abs(value - printed) <= half_unit_of_last_digit(printed) + 1e-16


@pytest.mark.parametrize("row", marks.ECCENTRIC_MOTION, ids=lambda row: f"{row[0]}deg")
def test_the_motion_of_the_eccentric_is_met(row: tuple[float, ...]) -> None:
    eccentric, moving = of_ratio(4), {"crank_angle": math.radians(row[0]), "crank_rate": 10.0}
    is_printed(closed.valve_distance(eccentric, crank_angle=moving["crank_angle"]), row[1])
    # speeds and accelerations pass through zero: 1e-15 of their size, r W and r W^2
    assert abs(closed.valve_velocity(eccentric, **moving) - row[2]) <= half_unit_of_last_digit(row[2]) + 1e-15
    assert abs(closed.valve_acceleration(eccentric, **moving) - row[3]) <= half_unit_of_last_digit(row[3]) + 2e-14


@given(eccentrics, st.floats(0.0, math.tau))
def test_the_valve_stands_at_the_rods_length_from_the_eccentric(eccentric: Eccentric, angle: float) -> None:
    theta = angle + eccentric.advance
    x, y = eccentric.radius * math.sin(theta), eccentric.radius * math.cos(theta)
    s = closed.valve_distance(eccentric, crank_angle=angle)
    assert_allclose(math.hypot(s - x, y), eccentric.rod, rtol=1e-14)  # rounding


@given(eccentrics, st.floats(0.0, math.tau))
def test_speed_and_acceleration_are_derivatives(eccentric: Eccentric, angle: float) -> None:
    assume(eccentric.rod > 1.5 * eccentric.radius)  # nearer to equal lengths the valve jerks, and steps must be finer
    step, unit = 1e-3, eccentric.radius
    places = np.asarray(closed.valve_distance(eccentric, crank_angle=angle + step * np.arange(-3, 4)))
    first = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 @ places / step
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180 @ places / step**2
    # differences of the sixth order with steps of 1e-3 rad: 1e-14 of s over the step, 1e-9 after twice
    room = eccentric.rod / unit
    assert abs(closed.valve_velocity(eccentric, crank_angle=angle, crank_rate=1.0) - first) < 1e-12 * unit * (10 + room)
    assert abs(closed.valve_acceleration(eccentric, crank_angle=angle, crank_rate=1.0) - second) < 1e-9 * unit * (10 + room)


@given(eccentrics, st.floats(0.0, math.tau))
def test_the_exact_error_lies_on_the_hyperbola(eccentric: Eccentric, angle: float) -> None:
    theory = closed.first_order_displacement(eccentric, crank_angle=angle)
    z = closed.valve_displacement(eccentric, crank_angle=angle) - theory
    d, scale = closed.equal_lead_centre(eccentric), eccentric.rod**2
    assert abs((z + d) ** 2 - theory**2 - (eccentric.rod**2 - eccentric.radius**2)) < 1e-14 * scale  # rounding
    assert abs(z - closed.hyperbola_error(eccentric, theoretical=theory)) < 1e-14 * eccentric.rod


@given(eccentrics)
def test_the_error_term_vanishes_and_is_extreme_where_the_paper_says(eccentric: Eccentric) -> None:
    advance, unit = eccentric.advance, eccentric.radius**2 / (2 * eccentric.rod)
    zeros = np.array([0.0, math.pi, math.pi - 2 * advance, math.tau - 2 * advance])
    for law in (closed.parabola_error, closed.hyperbola_error):
        assert np.max(np.abs(error_by(law, eccentric, zeros))) < 1e-14 * max(unit, eccentric.rod)  # rounding
    high, low = np.array([0.5, 1.5]) * math.pi - advance, np.array([1.0, 2.0]) * math.pi - advance
    assert_allclose(error_by(closed.parabola_error, eccentric, high), unit * math.cos(advance) ** 2, atol=1e-15 * unit)
    assert_allclose(error_by(closed.parabola_error, eccentric, low), -unit * math.sin(advance) ** 2, atol=1e-15 * unit)
    for law in (closed.parabola_error, closed.hyperbola_error):
        every = error_by(law, eccentric, TURN)
        room = 1e-15 * eccentric.rod  # rounding
        assert every.max() <= max(error_by(law, eccentric, high)) + room
        assert every.min() >= min(error_by(law, eccentric, low)) - room


@given(eccentrics)
def test_half_the_sum_of_the_dead_centres_is_the_centre_and_both_leads_are_equal(eccentric: Eccentric) -> None:
    dead = np.asarray(closed.valve_distance(eccentric, crank_angle=np.array([0.0, math.pi])))
    assert_allclose(closed.equal_lead_centre(eccentric), dead.mean(), rtol=1e-14)  # rounding
    first, second = closed.leads(eccentric, outside_lap=0.1 * eccentric.radius)
    assert abs(first - second) < 1e-14 * eccentric.rod
    # Halfway between the extremes lies the rod's own length, whatever the advance.
    ends = np.array([0.5, 1.5]) * math.pi - eccentric.advance
    assert_allclose(np.mean(closed.valve_distance(eccentric, crank_angle=ends)), eccentric.rod, rtol=1e-14)


def test_what_is_neglected_falls_with_the_fourth_power_of_the_radius() -> None:
    radii = np.array([0.08, 0.04, 0.02, 0.01])
    sizes = []
    for radius in radii:
        eccentric = Eccentric(radius=radius, rod=0.3, advance=0.5)
        left = error_by(closed.hyperbola_error, eccentric, TURN) - error_by(closed.parabola_error, eccentric, TURN)
        sizes.append(np.max(np.abs(left)))
    slope = np.polyfit(np.log(radii), np.log(sizes), 1)[0]
    assert abs(slope - 4) < 0.03  # the next term has (r / l)^2 / 2 of it, at most 0.036


@given(advances, st.floats(4.0, 100.0))
def test_the_circle_never_errs_more_than_the_parabola(advance: float, ratio: float) -> None:
    eccentric = of_ratio(ratio, advance)
    theory = np.linspace(-eccentric.radius, eccentric.radius, 801)
    true = np.asarray(closed.hyperbola_error(eccentric, theoretical=theory))
    circle, parabola = (
        np.max(np.abs(curve(eccentric, theoretical=theory) - true)) for curve in (closed.circle_error, closed.parabola_error)
    )
    room = 1e-15 * eccentric.rod  # rounding
    limit = eccentric.radius**4 / (16 * eccentric.rod**3)
    assert circle <= parabola + room
    # To leading order r^4 / 16 l^3 is between them; the next terms are about (r / l)^2 of it.
    assert circle <= limit * (1 + 1.5 / ratio**2) + room
    assert parabola >= limit * (1 - 1.5 / ratio**2) - room


@given(eccentrics, st.sampled_from(sorted(VALVE_EVENTS)), st.floats(0.0, 0.9), st.floats(-0.4, 0.4))
def test_at_an_event_the_valve_stands_at_its_lap_and_passes_the_right_way(
    eccentric: Eccentric, event: str, part: float, shift: float
) -> None:
    radius = eccentric.radius
    centre = eccentric.rod + shift * 0.2 * radius
    laps = {"outside_lap": part * radius, "inside_lap": 0.5 * part * radius}
    threshold = closed.event_threshold(event, **laps)
    assume(abs(threshold + centre - eccentric.rod) < 0.95 * radius)
    angle = closed.event_angle(eccentric, event=event, centre=centre, **laps)
    there = closed.valve_displacement(eccentric, crank_angle=angle, centre=centre)
    # The law of cosines loses l / r digits where the valve moves, more near its dead centres: 0.3 r of speed is left.
    assert abs(there - threshold) < 1e-14 * eccentric.rod * (1 + eccentric.rod / radius)
    assert (closed.valve_velocity(eccentric, crank_angle=angle, crank_rate=1.0) > 0) == VALVE_EVENTS[event][2]


def test_an_infinitely_long_rod_is_the_limit_of_long_ones() -> None:
    long, infinite = of_ratio(1e6), of_ratio(math.inf)
    assert_allclose(
        closed.valve_displacement(long, crank_angle=TURN),
        closed.valve_displacement(infinite, crank_angle=TURN),
        atol=0.51e-6 * infinite.radius,  # z is at most r^2 / 2 l
    )
    for event in VALVE_EVENTS:
        one, other = (closed.event_angle(eccentric, event=event, **LAPS) for eccentric in (long, infinite))
        assert abs(math.remainder(one - other, math.tau)) < 2e-6
    assert_allclose(
        closed.valve_acceleration(infinite, crank_angle=TURN, crank_rate=3.0),
        -9.0 * np.asarray(closed.first_order_displacement(infinite, crank_angle=TURN)),
        rtol=1e-14,
    )


def changes(ratio: float) -> dict[str, float]:
    """What the error term does to each end, of its own: of what the text compares, the change from theory."""
    exact, change = of_ratio(ratio), {}
    for end, side in (("crank end", 1.0), ("head end", -1.0)):
        at = {
            (law, event): math.remainder(
                closed.event_angle(eccentric, event=f"{end} {event}", **LAPS) - (0 if side > 0 else math.pi), math.tau
            )
            for law, eccentric in (("exact", exact), ("theory", of_ratio(math.inf)))
            for event in ("admission", "cut-off", "release", "compression")
        }
        later = {event: at["exact", event] - at["theory", event] for _, event in at}
        change[f"{end} fill"] = later["cut-off"]
        change[f"{end} pre-admission"] = -later["admission"]
        change[f"{end} pre-release"] = -later["release"]
        change[f"{end} compression"] = -later["compression"]
        every = np.asarray(closed.valve_displacement(exact, crank_angle=TURN)) * side
        change[f"{end} displacement"] = every.max() - exact.radius
    return change


@pytest.mark.parametrize("ratio", [4, 10, 30])
def test_the_papers_sentence_on_the_two_ends_is_not_borne_out_by_its_formula(ratio: float) -> None:
    """The text lets compression grow with displacement and pre-release where pre-admission and fill shrink.

    Its formula pairs compression with pre-admission and fill: where they shrink, it shrinks. The other end is the
    opposite in every point, as the text says.
    """
    change = changes(ratio)
    away = {name.removeprefix("crank end "): value > 0 for name, value in change.items() if name.startswith("crank")}
    near = {name.removeprefix("head end "): value > 0 for name, value in change.items() if name.startswith("head")}
    text = {"displacement": True, "compression": True, "pre-release": True, "pre-admission": False, "fill": False}
    assert {name for name, grows in text.items() if away[name] != grows} == {"compression"}
    assert near == {name: not grows for name, grows in away.items()}


def test_an_infinitely_long_rod_swings_about_any_centre():
    eccentric = Eccentric(radius=marks.ECCENTRIC, rod=math.inf, advance=0.4)
    about_shaft = np.asarray(closed.valve_displacement(eccentric, crank_angle=TURN))
    about_centre = np.asarray(closed.valve_displacement(eccentric, crank_angle=TURN, centre=0.003))
    assert_allclose(about_centre, about_shaft - 0.003, atol=1e-16)
