"""Figures hold every reading and leave nothing half written."""

import dataclasses
import itertools
import re
import zlib

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

import governor_mechanism as gm
from decoding import words_of
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.render.figures.page import format_power
from governor_mechanism.render.figures.time_series import diagnostics_figure, readings_figure
from governor_mechanism.render.shown_readings import choose_multiple, format_numbers, format_rounded_up
from governor_mechanism.render.style import PAPER, parse_rgb
from stub_effects import ListedEvents
from stub_run import GOVERNOR_DIMENSIONS, fake_run


def with_readings(run, **readings):
    return dataclasses.replace(run, readings={**run.readings, **readings})


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0)


def test_a_figure_is_a_png_and_equal_for_equal_runs(tmp_path, porter):
    first, second = (readings_figure(porter).save(tmp_path / name) for name in ("a.png", "b.png"))
    with Image.open(first) as image:
        assert image.format == "PNG"
        assert image.size[0] == 960
    assert first.read_bytes() == second.read_bytes()


def test_every_reading_stands_in_everyday_units(porter):
    expected = {"Arm angle [deg]", "Ball radius [mm]", "Sleeve lift [mm]", "Spindle torque [N m]"}
    assert expected <= set(words_of(readings_figure(porter)))


def test_a_constant_reading_has_a_line_instead_of_a_panel_unless_it_is_chosen(porter):
    steady = with_readings(porter, spindle_speed=np.full(len(porter.times), 4 * np.pi))
    figure = readings_figure(steady)
    assert len(figure.axes) == len(porter.readings) - 1
    assert "constant: spindle speed 120 rpm" in words_of(figure)
    assert len(readings_figure(steady, ["spindle_speed"]).axes) == 1


def test_a_constant_below_the_rounding_of_its_scale_is_zero(porter):
    rest = with_readings(porter, sleeve_lift=np.full(len(porter.times), -7.6e-17))
    assert "constant: sleeve lift 0 mm" in words_of(readings_figure(rest))


def test_an_angle_that_turns_evenly_is_stated_with_its_speed():
    run = gm.run("astroid", times=np.linspace(0.0, 2.1, 43))
    overview, asked = readings_figure(run), readings_figure(run, ["arm_angle"])
    assert "turning evenly: arm angle at 30 rpm" in words_of(overview)
    assert [len(page.axes) for page in (overview, asked)] == [2, 1]
    slow = gm.run("astroid", times=np.linspace(0.0, 1.9, 39))  # less than a turn
    assert len(readings_figure(slow).axes) == 3


@pytest.mark.long
@pytest.mark.parametrize("theme", ["light", "dark", "transparent"])
@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_every_theme_and_format_is_written_and_equal_figures_give_equal_files(tmp_path, porter, theme, ending):
    figure = readings_figure(porter, ["arm_angle"])
    before = tmp_path / "before.png", tmp_path / "after.png"
    figure.save(before[0])
    first, second = (figure.save(tmp_path / f"{name}.{ending}", theme=theme).read_bytes() for name in ("a", "b"))
    figure.save(before[1])  # a theme leaves the figure as it was
    assert first == second
    assert before[0].read_bytes() == before[1].read_bytes()
    assert first.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending])


def test_a_dark_figure_has_a_dark_ground_and_a_transparent_one_none(tmp_path, porter):
    figure = readings_figure(porter, ["arm_angle"])
    for theme, is_as_expected in {
        "light": lambda pixel: min(pixel[:3]) > 240 and pixel[3] == 255,
        "dark": lambda pixel: max(pixel[:3]) < 40 and pixel[3] == 255,
        "transparent": lambda pixel: pixel[3] == 0,
    }.items():
        with Image.open(figure.save(tmp_path / f"{theme}.png", theme=theme)) as image:
            assert is_as_expected(image.convert("RGBA").getpixel((2, 2))), theme


def test_curves_hold_the_readings(porter):
    curve = readings_figure(porter).axes[0].lines[0]
    np.testing.assert_allclose(curve.get_ydata(), np.degrees(porter.readings["arm_angle"]))


def test_an_exact_run_can_be_drawn_on_logarithmic_axes(tmp_path, porter):
    nothing = np.zeros(len(porter.times))
    exact = dataclasses.replace(porter, joint_gap=nothing, energy=dataclasses.replace(porter.energy, jacobi=nothing))
    figure = diagnostics_figure(exact)
    assert figure.save(tmp_path / "a.png").exists()
    assert len(figure.axes) == 2
    assert all("zero to rounding" in [text.get_text() for text in axes.texts] for axes in figure.axes)
    assert {"Widest joint gap [mm]", "Energy drift, relative to the energy scale"} <= set(words_of(diagnostics_figure(porter)))


def test_rounding_noise_is_a_flat_line_and_no_factor_is_printed_over_a_heading(porter):
    noise = 1e-17 * np.sin(50 * porter.times)
    figure = readings_figure(with_readings(porter, spindle_torque=noise), ["spindle_torque"])
    FigureCanvasAgg(figure).draw()
    (torque,) = figure.axes
    low, high = torque.get_ylim()
    assert high - low > 1e6 * np.ptp(noise)
    assert all(axes.yaxis.get_offset_text().get_text() == "" for axes in figure.axes)


def test_the_cause_of_an_early_end_comes_first_and_stays_within_the_figure(porter):
    for detail in ("arm_angle: the arms are at 90 degrees", 30 * "a cause told at length, "):
        figure = readings_figure(dataclasses.replace(porter, outcome=gm.Outcome.LEFT_RANGE, detail=detail))
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
    one = dataclasses.replace(run, times=run.times[:1], joint_gap=run.joint_gap[:1], energy=energy)
    one = with_readings(one, **{name: values[:1] for name, values in run.readings.items()})
    assert readings_figure(one).save(tmp_path / "a.png").exists()


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


def test_many_events_stand_in_a_strip_with_a_row_for_each_kind(porter):
    figure = readings_figure(happening(porter, 90))
    assert not any(marks_of(axes) for axes in figure.axes[:-1])
    strip = figure.axes[-1]
    assert {kind: len(lines) for kind, lines in marks_of(strip).items()} == {"sticks": 30, "slips": 30, "strikes its stop": 30}
    assert [label.get_text() for label in strip.get_yticklabels()] == ["sticks (30)", "slips (30)", "strikes its stop (30)"]
    assert not figure.legends


def test_turning_points_are_not_marked(porter):
    events = tuple(Event(time=0.1 * k, kind=EventKind.TURNING_POINT, subject="arm_angle") for k in range(1, 6))
    assert not readings_figure(dataclasses.replace(porter, deferred_results=ListedEvents(events))).legends


def test_a_run_without_events_has_no_line_on_them(porter):
    figure = readings_figure(porter)
    assert not figure.legends
    assert figure.get_figheight() < readings_figure(happening(porter, 1)).get_figheight()


def test_an_exception_leaves_no_file(tmp_path, porter, monkeypatch):
    def fail(figure, path, **options):
        with open(path, "wb") as file:
            file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(KeyboardInterrupt):
        readings_figure(porter).save(tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_wrong_names_and_empty_runs_are_refused(tmp_path, porter):
    for path, theme, message in (
        (tmp_path / "a.jpg", "light", r"must end in one of \.png, \.svg, \.pdf; got 'a\.jpg'"),
        (tmp_path / "a.png", "sepia", "theme must be one of light, dark, transparent; got 'sepia'"),
        (None, "light", "path must be a path; found None"),
    ):
        with pytest.raises(gm.MechanismError, match=message):
            readings_figure(porter).save(path, theme=theme)
    with pytest.raises(gm.MechanismError, match="a reading is given by its name"):
        porter.plot(["arm_angle"])
    with pytest.raises(gm.MechanismError, match=r"'crank pin' is a joint: plot_reactions\('crank pin'\) draws its force"):
        gm.run("slider_crank", times=[0.0, 0.01]).plot("crank pin")
    with pytest.raises(gm.MechanismError, match="no reported time"):
        readings_figure(dataclasses.replace(porter, times=porter.times[:0])).save(tmp_path / "a.png")


@pytest.mark.parametrize(("error", "words"), [(3e-7, "3e-07"), (3.01e-7, "4e-07"), (9.9e-4, "1e-03"), (0.0, "0e+00")])
def test_errors_are_never_rounded_down(error, words):
    assert format_rounded_up(error) == words


def test_numerals_have_decimals_for_their_range_but_none_for_noise():
    assert format_numbers(np.array([40.0, 48.25])) == ["40.00", "48.25"]
    assert format_numbers(np.array([120.0, 120.0 + 1e-9])) == ["120.0", "120.0"]
    assert format_numbers(np.array([-0.001, 10.0])) == ["0.0", "10.0"]


@pytest.mark.parametrize("ending", ["svg", "pdf"])
def test_files_for_print_have_a_white_ground_and_nothing_of_the_colour_of_paper(tmp_path, porter, ending):
    figure = readings_figure(porter, ["arm_angle"])
    ground = "fill: #ffffff" if ending == "svg" else "1 g"
    paper = PAPER if ending == "svg" else " ".join(f"{one / 255:.3f}" for one in parse_rgb(PAPER))
    content = figure.save(tmp_path / f"a.{ending}").read_bytes()
    if ending == "pdf":
        streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, re.DOTALL)
        content = b"\n".join(zlib.decompress(one) for one in streams if one[:1] == b"x")
    text = content.decode("latin-1")
    assert ground in text
    assert paper not in text


@pytest.mark.parametrize("largest", [0.0, 3.7, 9.9e3, 1e4, 6.1e6, 2e7])
def test_a_force_has_at_most_four_digits_before_the_point(largest):
    unit, factor = choose_multiple("N", np.array([-largest, 0.3 * largest]))
    assert largest * factor < 1e4
    assert factor == {"N": 1.0, "kN": 1e-3, "MN": 1e-6}[unit]
    assert choose_multiple("m", np.array([largest])) == ("mm", 1e3)


@pytest.mark.parametrize(("value", "words"), [(-5e6, "−5×10⁶"), (2.5e-5, "2.5×10⁻⁵"), (0.0, "0"), (-0.0, "0"), (12.0, "12")])
def test_powers_of_ten_are_printed_not_typed(value, words):
    assert format_power(value) == words


def test_a_polar_plot_stays_on_its_sheet_and_states_how_coarse_it_is():
    """At 3000 rpm a report each 2 ms gives 10 points a turn, and one each 0.5 ms gives 40."""
    scene = gm.load("slider_crank").replace({"dimensions.crank_speed": "3000 rpm", "run.duration": "0.06 s"})
    for interval, is_coarse in (("2 ms", True), ("0.5 ms", False)):
        page = gm.run(scene.replace({"run.output_interval": interval}), certify=False).plot_reactions("crank pin", axes="body")
        words = " ".join(words_of(page))
        assert ("only 10 points a turn" in words) == is_coarse
        assert "e+0" not in words
        page.draw_without_rendering()
        (panel,) = page.axes
        assert panel.yaxis.label.get_window_extent().x0 > 0.0
        assert panel.bbox.width > 0.7 * page.bbox.width
        numbers = sorted((label.get_window_extent() for label in panel.get_xticklabels()), key=lambda box: box.x0)
        assert all(left.x1 < right.x0 for left, right in itertools.pairwise(numbers))
