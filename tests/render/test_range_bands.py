"""Bands and means that stand for curves with many oscillations: laws of means and ranges, and the figures that draw them."""

import dataclasses
import math

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex

from decoding import data_of, words_of
from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.figures.time_series import MAX_OVERVIEW_READINGS, readings_figure
from governor_mechanism.render.film.moving_parts import pale_colour, plot_panel
from governor_mechanism.render.plot_panels import PanelCurve, PlotPanel
from governor_mechanism.render.range_bands import PlotSize, count_turns, find_range_band, make_range_band
from governor_mechanism.render.style import BLUE, CURVE_COLOURS, GREEN
from stub_run import GOVERNOR_DIMENSIONS, fake_run

SIZE = PlotSize(width=400.0, height=100.0, line_width=2.0, limits=(-2.0, 2.0))
"""A plot in which an oscillation needs 9 pixels: at most 44 are seen."""
TIMES = np.linspace(0.0, 10.0, 5001)
MANY, FEW = 90, 40


def test_a_sine_on_a_slope_has_the_slope_as_its_mean_and_its_amplitude_as_its_range():
    band = find_range_band(TIMES, 0.1 * TIMES + np.sin(math.tau * MANY / 10 * TIMES), SIZE)
    period = 10 / MANY
    # Over a whole period a sine has no mean; the minima of cubics between samples, 0.11 apart as angles, are found to 0.11^2 of that.
    np.testing.assert_allclose(band.means, 0.1 * band.mean_times, atol=0.002)
    inside = slice(2, -2)
    # The slope rises by 0.1 times half a period within half a period; peaks lie between samples, whose angles are 0.11 apart.
    np.testing.assert_allclose(band.high[inside] - 0.1 * band.times[inside], 1.0, atol=0.1 * period + 0.11**2 / 8)
    np.testing.assert_allclose(band.low[inside] - 0.1 * band.times[inside], -1.0, atol=0.1 * period + 0.11**2 / 8)


def test_no_mean_stands_within_half_a_cycle_of_the_ends():
    band = make_range_band(TIMES, np.sin(math.tau * TIMES), TIMES, 200)
    assert (band.times[0], band.times[-1]) == (0.0, 10.0)
    assert band.mean_times[0] == pytest.approx(0.5)
    assert band.mean_times[-1] == pytest.approx(9.5)


@pytest.mark.parametrize(("n_samples", "n_cycles"), [(50, 300), (2000, 90), (2000, 5), (3, 100)])
def test_all_samples_lie_in_the_band(n_samples, n_cycles):
    generator = np.random.default_rng(n_samples)
    times = np.sort(generator.uniform(0.0, 1.0, n_samples))
    values = generator.normal(size=n_samples)
    band = make_range_band(times, values, n_cycles * times, 40)
    # Also between its points, where the edges are straight.
    assert np.all(np.interp(times, band.times, band.low) <= values + 1e-12)
    assert np.all(np.interp(times, band.times, band.high) >= values - 1e-12)


def test_the_mean_speed_over_a_turn_is_a_turn_over_its_duration():
    """Of a shaft that speeds up unevenly; both ends of each turn by a search on the angle as a function of time."""
    angle = 20.0 * TIMES + 1.5 * TIMES**2 + 0.2 * np.sin(20.0 * TIMES)
    speed = 20.0 + 3.0 * TIMES + 4.0 * np.cos(20.0 * TIMES)
    band = make_range_band(TIMES, speed, angle / math.tau, 100)
    middles = np.interp(band.mean_times, TIMES, angle)
    durations = np.interp(middles + math.pi, angle, TIMES) - np.interp(middles - math.pi, angle, TIMES)
    # Straight lines between samples: h^2/8 times the second derivative, 80 rad/s2 and 1600 rad/s3, relative to a turn and to the speed.
    np.testing.assert_allclose(band.means, math.tau / durations, rtol=1e-4)


def test_a_jump_of_the_mean_is_a_slope_over_one_cycle_without_overshoot():
    values = np.where(TIMES < 5.0, 0.0, 1.0) + 0.5 * np.sin(math.tau * 9 * TIMES)
    band = make_range_band(TIMES, values, 9 * TIMES, 400)
    half_cycle = 0.5 / 9 + 0.002  # a sample more
    near = np.abs(band.mean_times - 5.0) < half_cycle
    # Over a whole number of periods the sine has no mean; the ends are cut between samples.
    np.testing.assert_allclose(band.means[~near], band.mean_times[~near] > 5.0, atol=1e-4)
    assert np.all((band.means > -1e-4) & (band.means < 1 + 1e-4))
    assert np.all(np.diff(band.means) > -1e-4)


def test_only_curves_with_too_many_oscillations_have_a_band():
    def band_of(values, **changes):
        return find_range_band(TIMES, values, dataclasses.replace(SIZE, **changes))

    many, few = (np.sin(math.tau * n / 10 * TIMES) for n in (MANY, FEW))
    assert band_of(many) is not None
    assert band_of(few) is None
    assert band_of(few, width=300.0) is not None
    assert band_of(many, width=1000.0) is None
    # An angle that rises, however unevenly its shaft turns.
    assert band_of(50.0 * TIMES + 0.4 * many, limits=(0.0, 500.0)) is None
    # What is lower than the line is wide.
    assert band_of(0.03 * many) is None
    assert band_of(np.where(TIMES == 5.0, np.inf, many)) is None
    # Oscillations in the first third alone.
    assert band_of(np.where(TIMES < 3.3, np.sin(math.tau * 20 * TIMES), 0.0)) is None


@pytest.mark.parametrize(("n_turns", "is_of_turns"), [(MANY, True), (MANY / 2, True), (MANY / 3, True), (0.7 * MANY, False), (5, False)])
def test_a_cycle_is_a_turn_of_a_shaft_in_step_with_the_curve(n_turns, is_of_turns):
    band = find_range_band(TIMES, np.sin(math.tau * MANY / 10 * TIMES), SIZE, n_turns / 10 * TIMES)
    assert band.is_of_turns is is_of_turns


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=10.0)


def with_readings(run, **readings):
    units = {name: run.units.get(name, "m") for name in (*run.readings, *readings)}
    return dataclasses.replace(run, readings={**run.readings, **readings}, units=units)


def legend_words(figure):
    return [words for legend in figure.legends for words in words_of(legend)]


def test_the_shaft_of_a_run_is_its_first_angle_of_several_turns(porter):
    assert count_turns(porter) is None
    angle = 30.0 * porter.times
    turning = dataclasses.replace(with_readings(porter, crank_angle=-angle), units={**porter.units, "crank_angle": "rad"})
    np.testing.assert_allclose(count_turns(turning), angle / math.tau)


def test_a_figure_has_bands_where_they_are_needed_and_one_key(porter):
    fast = with_readings(porter, sleeve_lift=0.05 * np.sin(math.tau * 8 * porter.times), ball_radius=0.2 + 0.01 * np.cos(50 * porter.times))
    figure = readings_figure(fast)
    bands = {axes.texts[0].get_text(): [one for one in axes.collections if isinstance(one, PolyCollection)] for axes in figure.axes}
    assert [name for name, shown in bands.items() if shown] == ["Ball radius [mm]", "Sleeve lift [mm]"]
    assert legend_words(figure) == ["range within an oscillation", "mean over an oscillation"]
    box = bands["Sleeve lift [mm]"][0].get_paths()[0].get_extents()
    assert (box.y0, box.y1) == pytest.approx((-50.0, 50.0), rel=0.01)  # peaks between samples, 0.5 apart: 0.5^2 / 8 at most, here less
    lift = figure.axes[2]
    # Straight lines between samples that are 0.5 apart as angles cut off 0.5^2 / 12 of each half, and of the mean what is left at the ends.
    np.testing.assert_allclose(lift.lines[0].get_ydata(), 0.0, atol=0.02 * 50.0)
    assert lift.get_xlim() == (0.0, 10.0)
    assert not legend_words(readings_figure(porter))
    renderer = FigureCanvasAgg(figure).get_renderer()
    assert figure.legends[0].get_window_extent(renderer).y0 > max(text.get_window_extent(renderer).y1 for text in figure.axes[0].texts)


def test_a_drawing_with_bands_does_not_grow_with_the_number_of_oscillations(tmp_path):
    def size_of(duration):
        run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=duration)
        run = with_readings(run, sleeve_lift=0.05 * np.sin(50 * run.times))
        return readings_figure(run, ["sleeve_lift"]).save(tmp_path / "a.svg").stat().st_size

    # Ten times as many, with other labels on the axis of time.
    assert size_of(150.0) == pytest.approx(size_of(15.0), rel=0.1)


def test_an_overview_of_many_readings_names_those_that_it_leaves_out(porter):
    others = {f"other_{k}": np.sin(k + porter.times) for k in range(12)}
    many = with_readings(porter, same=porter.readings["ball_radius"], **others)
    figure = readings_figure(many)
    labels = [axes.texts[0].get_text() for axes in figure.axes]
    assert len(labels) == MAX_OVERVIEW_READINGS
    # Those that films show of a governor, and others; the same one twice is no news.
    assert {"Arm angle [deg]", "Sleeve lift [mm]", "Spindle speed [rpm]", "Other 0 [mm]"} <= set(labels)
    assert "Same [mm]" not in labels
    words = " ".join(words_of(figure))
    left_out = [name for name in many.readings if f"{name.capitalize().replace('_', ' ')} [" not in " ".join(labels)]
    assert f'run.plot("{left_out[0]}") draws one of {len(left_out)} more readings: {", ".join(left_out)}' in words
    assert len(readings_figure(many, list(many.readings)).axes) == len(many.readings)


def test_a_film_shows_the_band_from_its_first_frame_and_draws_the_mean_to_the_last(porter):
    data = data_of(porter, 11)
    values = 5.0 + np.sin(math.tau * 5 * porter.times)

    def panel_of(**options):
        axes = Page(1.5, 1.0, dpi=100).add_panel((0.05, 0.05, 0.9, 0.9))
        curve = PanelCurve(name="sine", times=porter.times, values=values, series=CURVE_COLOURS.index(GREEN))
        panel = PlotPanel(name="sine", unit="", curves=(curve,), limits=(3.0, 7.0), **options)
        return axes, plot_panel(axes, panel, data, 0.72, has_time_labels=False)

    axes, panel = panel_of(may_have_bands=True)
    (outline,) = axes.patches
    assert to_hex(outline.get_facecolor()) == pale_colour(GREEN)
    assert (outline.get_xy()[:, 1].min(), outline.get_xy()[:, 1].max()) == pytest.approx((4.0, 6.0), abs=0.01)
    line, dot = panel.paths_at(5)
    np.testing.assert_allclose(line.vertices[:, 1], 5.0, atol=0.01)  # samples are 0.31 apart as angles
    assert line.vertices[-1, 0] == 5.0
    np.testing.assert_allclose(dot.vertices, [[5.0, values[500]]])  # the dot is what the number says
    axes, panel = panel_of()
    assert not axes.patches
    assert not panel.bands
    assert np.ptp(panel.curves[0][:, 1]) == pytest.approx(2.0, abs=0.02)
    assert to_hex(axes.lines[0].get_color()) == pale_colour(GREEN) != pale_colour(BLUE)
