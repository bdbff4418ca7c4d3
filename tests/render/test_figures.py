"""Figures hold every reading and leave nothing half written."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.render.figures.time_series import readings_figure
from governor_mechanism.render.number_format import format_numbers, format_rounded_up
from render.stub_effects import ListedEvents
from render.stub_run import GOVERNOR_DIMENSIONS, fake_run


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0)


def test_a_figure_is_a_png_and_equal_for_equal_runs(tmp_path, porter):
    first, second = (readings_figure(porter).save_png(tmp_path / name) for name in ("a.png", "b.png"))
    with Image.open(first) as image:
        assert image.format == "PNG"
        assert image.size[0] == 960
    assert first.read_bytes() == second.read_bytes()


def test_every_reading_stands_in_everyday_units(porter):
    words = [text.get_text() for axes in readings_figure(porter).axes for text in axes.texts]
    for label in ("arm angle, deg", "ball radius, mm", "sleeve lift, mm", "spindle speed, rpm", "spindle torque, N m"):
        assert label in words
    assert "widest joint gap, mm" in words
    assert "energy drift, of the energy scale" in words


def test_curves_hold_the_readings(porter):
    curve = readings_figure(porter).axes[0].lines[0]
    np.testing.assert_allclose(curve.get_ydata(), np.degrees(porter.readings["arm_angle"]))


def test_an_exact_run_can_be_drawn_on_logarithmic_axes(tmp_path, porter):
    nothing = np.zeros(len(porter.times))
    exact = dataclasses.replace(porter, joint_gap=nothing, energy=dataclasses.replace(porter.energy, jacobi=nothing))
    assert readings_figure(exact).save_png(tmp_path / "a.png").exists()
    last = readings_figure(exact).axes[-2:]
    assert all("zero to rounding" in [text.get_text() for text in axes.texts] for axes in last)


def test_rounding_noise_is_a_flat_line_and_no_factor_is_printed_over_a_heading(porter):
    noise = 1e-17 * np.sin(50 * porter.times)
    rest = dataclasses.replace(porter, readings={**porter.readings, "spindle_torque": noise})
    figure = readings_figure(rest)
    FigureCanvasAgg(figure).draw()
    torque = figure.axes[list(rest.readings).index("spindle_torque")]
    low, high = torque.get_ylim()
    assert high - low > 1e6 * np.ptp(noise)
    assert all(axes.yaxis.get_offset_text().get_text() == "" for axes in figure.axes)


def test_the_cause_of_an_early_end_comes_first_and_stays_within_the_figure(porter):
    for detail in ("arm_angle: the arms are at 90 degrees", 30 * "a cause told at length, "):
        figure = readings_figure(dataclasses.replace(porter, outcome=Outcome.LEFT_RANGE, detail=detail))
        renderer = FigureCanvasAgg(figure).get_renderer()
        first, second = figure.texts[-2:]
        assert first.get_text().startswith(detail[:30])
        for line in (first, second):
            assert line.get_window_extent(renderer).x1 < 960
        assert first.get_window_extent(renderer).y0 > second.get_window_extent(renderer).y1 - 2
    assert second.get_text().endswith("…")


def test_a_run_of_one_report_can_be_drawn(tmp_path):
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0)
    names = ("kinetic", "potential", "rotation", "jacobi", "dissipated_energy")
    energy = dataclasses.replace(run.energy, **{name: getattr(run.energy, name)[:1] for name in names})
    one = dataclasses.replace(
        run,
        times=run.times[:1],
        readings={name: values[:1] for name, values in run.readings.items()},
        joint_gap=run.joint_gap[:1],
        energy=energy,
    )
    assert readings_figure(one).save_png(tmp_path / "a.png").exists()


def happening(run, count):
    kinds = (EventKind.STICK, EventKind.SLIP, EventKind.IMPACT)
    events = [Event(time=0.01 + 1.9 * k / count, kind=kinds[k % 3], subject="sleeve_lift") for k in range(count)]
    late = Event(time=99.0, kind=EventKind.SLACK, subject="sleeve_lift")
    return dataclasses.replace(run, deferred_results=ListedEvents((*events, late)))


def marks_of(axes):
    found = {lines.get_gid(): lines.get_segments() for lines in axes.collections}
    return {kind: np.array(segments) for kind, segments in found.items()}


def test_few_events_are_marked_by_a_line_each_and_named(porter):
    figure = readings_figure(happening(porter, 7))
    marks = marks_of(figure.axes[0])
    assert {kind: len(lines) for kind, lines in marks.items()} == {"sticks": 3, "slips": 2, "strikes its stop": 2}
    np.testing.assert_allclose(marks["slips"][:, 0, 0], 0.01 + 1.9 * np.array([1, 4]) / 7)
    assert np.ptp(marks["slips"][0][:, 1]) == 1.0
    assert not marks_of(figure.axes[-1])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["sticks (3)", "slips (2)", "strikes its stop (2)"]
    renderer = FigureCanvasAgg(figure).get_renderer()
    box = legend.get_window_extent(renderer)
    assert box.y1 < figure.texts[0].get_window_extent(renderer).y0
    assert box.y0 > max(text.get_window_extent(renderer).y1 for text in figure.axes[0].texts)


def test_named_crossings_are_marked_by_their_names(porter):
    events = [Event(time=0.1 * k, kind=EventKind.CROSSING, subject=("lifted", "lowered")[k % 2]) for k in range(1, 6)]
    run = dataclasses.replace(porter, deferred_results=ListedEvents(tuple(events)))
    figure = readings_figure(run)
    assert {name: len(lines) for name, lines in marks_of(figure.axes[0]).items()} == {"lifted": 2, "lowered": 3}
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["lowered (3)", "lifted (2)"]


def test_many_events_are_a_rug_of_ticks(porter):
    figure = readings_figure(happening(porter, 90))
    assert all(np.ptp(line[:, 1]) < 0.2 for lines in marks_of(figure.axes[2]).values() for line in lines)
    assert sum(len(lines) for lines in marks_of(figure.axes[2]).values()) == 90


def test_a_run_without_events_has_no_line_on_them(porter):
    figure = readings_figure(porter)
    assert not figure.legends
    assert figure.get_figheight() < readings_figure(happening(porter, 1)).get_figheight()


def test_an_exception_leaves_no_file(tmp_path, porter, monkeypatch):
    def fail(canvas, path, metadata):
        with open(path, "wb") as file:
            file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(FigureCanvasAgg, "print_png", fail)
    with pytest.raises(KeyboardInterrupt):
        readings_figure(porter).save_png(tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_wrong_names_and_empty_runs_are_refused(tmp_path, porter):
    with pytest.raises(MechanismError, match=r"must end in \.png"):
        readings_figure(porter).save_png(tmp_path / "a.jpg")
    with pytest.raises(MechanismError, match="no reported time"):
        readings_figure(dataclasses.replace(porter, times=porter.times[:0])).save_png(tmp_path / "a.png")


@pytest.mark.parametrize(("error", "words"), [(3e-7, "3e-07"), (3.01e-7, "4e-07"), (9.9e-4, "1e-03"), (0.0, "0e+00")])
def test_errors_are_never_rounded_down(error, words):
    assert format_rounded_up(error) == words


def test_numerals_have_decimals_for_their_range_but_none_for_noise():
    assert format_numbers(np.array([40.0, 48.25])) == ["40.00", "48.25"]
    assert format_numbers(np.array([120.0, 120.0 + 1e-9])) == ["120.0", "120.0"]
    assert format_numbers(np.array([-0.001, 10.0])) == ["0.0", "10.0"]
