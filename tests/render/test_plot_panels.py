"""Panels of curves: films and pages plot the same readings, with the same units, axes and colours, over the shown time."""

import dataclasses
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import governor_mechanism as gm
from decoding import data_of, page_data_of, unpack_numbers
from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.film.moving_parts import CURVE_WIDTH, plot_panel
from governor_mechanism.render.film.painters import make_painter
from governor_mechanism.render.film.svg_animation import write_animation
from governor_mechanism.render.page.page_data import PLOT_SIZE, choose_panels, collect_data
from governor_mechanism.render.page.views import show_run
from governor_mechanism.render.plot_panels import choose_part_panels, choose_room_panels
from governor_mechanism.render.shown_readings import choose_ticks
from governor_mechanism.render.style import CURVE_COLOURS, SERIES_COLOURS
from stub_run import GOVERNOR_DIMENSIONS, fake_run

SPAN = (0.7131, 1.5373)
"""A part of a run, s, whose ends are not reported."""


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0)


@pytest.fixture(scope="module")
def engine():
    return gm.run(gm.load("governed_engine").replace({"run.duration": "3 s"}), accuracy=1e-5, certify=False)


@pytest.fixture(scope="module", params=["part", "room"])
def shown(request, porter, engine):
    run = porter if request.param == "part" else engine
    return show_run(run, None, SPAN, np.linspace(*SPAN, 50), 1.0)


def lines_of(shown):
    """The axes of the plots of a film, each with the colours of its lines."""
    painter = make_painter((shown.run,), SPAN, np.linspace(*SPAN, 3), 1.0, gm.FilmOptions())
    axes = [one.artists[0].artist.axes for canvas in painter.canvases for one in canvas.panels if hasattr(one, "curves")]
    return [(one.get_ylim(), [line.get_color() for line in one.lines]) for one in axes]


def test_film_and_page_have_the_same_axes_and_colours(shown):
    plots = [plot for plot in collect_data(shown, 1.0)["plots"] if plot["isFirst"]]
    drawn = lines_of(shown)
    by_limits = {tuple(plot["limits"]): plot["curves"][0]["series"] for plot in plots}
    assert len(drawn) >= 2
    for limits, colours in drawn:
        assert CURVE_COLOURS[by_limits[limits]] in colours


@pytest.fixture(scope="module")
def steady():
    """An engine of 2 turns a second, whose load falls at 6 s, over more turns than a plot can show."""
    run = gm.run(gm.load("governed_engine").replace({"run.duration": "25 s"}), accuracy=1e-4, certify=False)
    return show_run(run, None, (0.0, 25.0), np.linspace(0.0, 25.0, 200), 1.0)


def numbers_on_page(plot):
    """The bands of a plot of a page and their means, by curve: points (n, 2) around a band and along a mean, s and display units."""
    found = {}
    for curve in plot["curves"]:
        if band := curve.get("band"):

            def points(x, values, band=band, curve=curve):
                places = 1e-3 * unpack_numbers(band[x], 0)
                return np.column_stack([25.0 * places, plot["limits"][0] + curve["quantum"] * unpack_numbers(band[values], len(places))])

            low, high = points("x", "low"), points("x", "high")
            found[curve["name"]] = np.concatenate([low, high[::-1]]), points("meanX", "means") if "means" in band else None
    return found


def test_film_and_page_paint_the_same_bands_means_marks_and_limits_in_plots_of_one_size(steady):
    """The page rounds times to a thousandth of its width, and values to its quantum."""
    panels, _ = choose_panels(steady)
    plots = [plot for plot in collect_data(steady, 1.0)["plots"] if plot["isFirst"]]
    width, height, line_width = PLOT_SIZE
    shown = set()
    for panel, plot in zip(panels, plots, strict=True):
        axes = Page(width / 100, height / 100, dpi=100).add_panel((0.0, 0.0, 1.0, 1.0))
        painted = plot_panel(axes, panel, steady.parts[0], line_width / CURVE_WIDTH * 0.72, has_time_labels=False)
        on_page = numbers_on_page(plot)
        shown |= set(on_page)
        assert axes.get_ylim() == tuple(plot["limits"])
        assert_allclose(axes.get_yticks(), plot["ticks"], rtol=1e-5)
        marks = [line.get_xdata()[0] for line in axes.lines if list(line.get_ydata()) == [0, 1]]
        assert marks == plot["marks"] == [6.0]
        tolerance = np.array([0.5e-3 * 25.0, 0.51 * plot["curves"][0]["quantum"]])
        for patch, (outline, _) in zip(reversed(axes.patches), on_page.values(), strict=True):
            assert np.all(np.abs(patch.get_xy()[:-1] - outline) <= tolerance)
        assert len(painted.curves) == sum(not curve.has_own_mean for curve in panel.curves)
        means = [mean for _, mean in on_page.values() if mean is not None]
        lines = [points for points in painted.curves if any(len(points) == len(mean) for mean in means)]
        for points, mean in zip(reversed(lines), means, strict=True):
            assert np.all(np.abs(points - mean) <= tolerance)
    assert shown == {"actual", "sleeve lift", "throttle"}


@pytest.mark.parametrize("low", [-3.0, 0.0, 0.117, 199.9, 1e5])
@pytest.mark.parametrize("width", [1e-3, 0.7, 1.0, 3.3, 9.99, 4e4])
def test_an_axis_has_ticks_from_two_on_at_round_values_clear_of_its_lower_end(low, width):
    width = max(width, 0.04 * low)
    ticks = np.array(choose_ticks((low, low + width)))
    assert 2 <= len(ticks) <= 4
    assert low <= ticks[0] < ticks[-1] <= low + width * (1 + 1e-9)
    assert ticks[0] >= low + 0.06 * width or len(ticks) == 2
    step = ticks[1] - ticks[0]
    assert_allclose(np.diff(ticks), step, rtol=1e-6)
    assert_allclose(ticks / step, np.rint(ticks / step), atol=1e-6)
    digits = step / 10.0 ** np.floor(np.log10(step * (1 + 1e-9)))
    assert_allclose(2 * digits, np.rint(2 * digits), atol=1e-4)  # 1, 1.5, 2, ... times a power of ten


def test_a_page_has_bands_in_all_its_plots(porter):
    """A sine of 100 oscillations in two seconds, which the film of a part draws as it is: there it would have no space to say so."""
    times = np.linspace(0.0, 2.0, 2001)
    readings = {name: np.interp(times, porter.times, values) for name, values in porter.readings.items()}
    readings["arm_angle"] = 0.7 + 0.1 * np.sin(100 * np.pi * times)
    poses = np.broadcast_to(porter.poses[0], (len(times), *porter.poses.shape[1:]))
    run = dataclasses.replace(porter, times=times, readings=readings, poses=poses, velocities=0.0 * poses)
    plots = {plot["name"]: plot for plot in page_data_of(run, np.linspace(0.0, 2.0, 61))["plots"]}
    assert plots["arm angle"]["note"] == "band: range within an oscillation"
    (outline, mean) = numbers_on_page(plots["arm angle"])["arm angle"]
    assert_allclose(mean[:, 1], np.degrees(0.7), atol=0.02)
    assert (outline[:, 1].min(), outline[:, 1].max()) == pytest.approx(np.degrees((0.6, 0.8)), abs=0.05)
    assert not any(panel.may_have_bands for panel in panels_of(run))


def test_an_animated_drawing_has_the_bands_of_its_film(steady, tmp_path):
    """Outlines in the SVG, in points from the top, against the numbers of the record at the size of the plots."""
    painter = make_painter((steady.run,), (0.0, 25.0), np.linspace(0.0, 25.0, 3), 1.0, gm.FilmOptions())
    (canvas,) = painter.canvases
    write_animation(tmp_path / "film.svg", canvas, 1.0, 3)
    text = (tmp_path / "film.svg").read_text(encoding="utf-8")
    outlines = [np.array(re.findall(r"[-.\d]+", path), dtype=float).reshape(-1, 2) for path in re.findall(r'<path d="([^"]*)z', text)]
    all_axes = [one.artists[0].artist.axes for one in canvas.panels if hasattr(one, "bands")]
    n_bands = 0
    for panel, axes in zip(choose_panels(steady)[0], all_axes, strict=True):
        for band in filter(None, panel.find_bands(axes.bbox.width, axes.bbox.height, CURVE_WIDTH)):
            low, high = (np.column_stack([band.times, values]) for values in (band.low, band.high))
            pixels = axes.transData.transform(np.concatenate([low, high[::-1]]))
            place = 72 / 64 * (pixels * (1, -1) + (0, 480))
            closest = min(float(np.abs(one - place).max()) for one in outlines if one.shape == place.shape)
            assert closest < 1e-3
            n_bands += 1
    assert n_bands == 3


def test_curves_fill_the_shown_time_and_the_axis_just_holds_them(shown):
    first, others = choose_panels(shown)
    for panel in (*first, *others):
        values = np.concatenate([curve.values for curve in panel.curves])
        assert panel.limits[0] < values.min() <= values.max() < panel.limits[1]
        for curve in panel.curves:
            assert (curve.times[0], curve.times[-1]) == pytest.approx(SPAN, abs=1e-12)
            assert np.all(np.diff(curve.times) > 0.0)


def test_a_curve_has_at_the_ends_of_the_shown_time_the_values_of_the_run(engine):
    page = show_run(engine, None, SPAN, np.linspace(*SPAN, 50), 1.0)
    panel = next(one for one in choose_room_panels(engine, page.governed, page.room, SPAN) if one.name == "sleeve lift")
    (curve,) = panel.curves
    lift = 1e3 * np.interp(SPAN, engine.times, engine.readings["governor.sleeve_lift"])
    assert_allclose(curve.values[[0, -1]], lift, rtol=1e-12)
    assert (panel.part, panel.unit) == ("governor", "mm")


def panels_of(run, **options):
    return choose_part_panels([data_of(run, 5)], **{"most": 3, "with_speed": True, **options})


def test_a_constant_reading_comes_last_and_is_marked_unless_all_are_constant(porter):
    still = {name: np.full_like(values, values[0]) for name, values in porter.readings.items()}
    without_arm = dataclasses.replace(porter, readings={**porter.readings, "arm_angle": still["arm_angle"]})
    panels = panels_of(without_arm)
    assert panels[-1].name == "arm angle"
    assert [panel.is_stated for panel in panels] == [False, False, True]
    assert "arm angle" not in [panel.name for panel in panels_of(without_arm, in_row=True)]
    at_rest = panels_of(dataclasses.replace(porter, readings=still))
    assert len(at_rest) == 3
    assert not any(panel.is_stated for panel in at_rest)


def test_an_angle_that_turns_evenly_is_only_stated(porter):
    def with_angle(turns):
        run = dataclasses.replace(porter, readings={**porter.readings, "arm_angle": 2 * np.pi * turns(porter.times)})
        return {panel.name: panel.is_stated for panel in panels_of(run)}["arm angle"]

    assert with_angle(lambda times: 3.0 * times)
    assert not with_angle(lambda times: 3.0 * times + 0.01 * np.sin(times))
    assert not with_angle(lambda times: 0.1 * times)  # less than a turn, as a lever that is shifted


def test_chosen_readings_are_plotted_in_their_order_and_the_speed_keeps_its_colour(porter):
    names = ["spindle_speed", "ball_radius", "arm_angle"]
    panels = panels_of(porter, chosen=names)
    assert [panel.name for panel in panels] == ["spindle speed", "ball radius", "arm angle"]
    green = SERIES_COLOURS[2]
    assert [panel.curves[0].colour for panel in panels] == [green, SERIES_COLOURS[1], green]


def test_a_film_bridges_what_is_infinite(porter):
    force = np.where(np.arange(len(porter.times)) % 50 == 20, np.inf, 100.0 + porter.times)
    run = dataclasses.replace(porter, readings={**porter.readings, "force": force}, units={**porter.units, "force": "N"})
    (panel,) = panels_of(run, chosen=["force"])
    (curve,) = panel.curves
    assert_allclose(curve.values, 100.0 + curve.times, rtol=1e-12)
