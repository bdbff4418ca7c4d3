"""Words on films: headings of plots are whole, and the lines of labels keep clear of the words and scales of the drawing."""

import dataclasses
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from decoding import data_of, painter_of, texts_of, words_of
from governor_mechanism.model.results.pictures import FilmLayout, FilmOptions
from governor_mechanism.render.film.frame_canvas import NAME_HEIGHTS, FrameCanvas, HeadingRow, PlotHeading
from governor_mechanism.render.film.frame_painter import ElevationOverlay
from governor_mechanism.render.film.labels import (
    LABEL_PITCH,
    Label,
    break_lines,
    find_labels,
    place_labels,
    shares_within,
    thin_out_numbers,
)
from governor_mechanism.render.film.moving_parts import CurvePanel
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.primitives import SMALL_TEXT, Lines, TextShape, bounding_box, fit_view
from stub_run import GOVERNOR_DIMENSIONS, fake_run

COLUMN = 143.0
"""Width (pixels) of one of three plots side by side, the narrowest place of a heading."""
SHIPPED_NAMES = ("valve displacement", "crank end steam", "head end exhaust", "crosshead distance", "crank end travel")
"""Longest names of readings above three plots side by side."""


@pytest.fixture(scope="module")
def canvases():
    return {size: FrameCanvas(size, 0.0) for size in (320, 480, 1000)}


def fitted_height(heading, canvas, width):
    return HeadingRow.fit(canvas, [heading], width).height


def words_above(heading, canvas, width, height):
    """Write a heading, and return its words with their boxes (left, bottom, right, top; pixels of the frame)."""
    before = len(canvas.figure.artists)
    heading.write(canvas, (10.0, 10.0 + width), 300.0, height)
    added = canvas.figure.artists[before:]
    found = [(text.get_text(), text.get_window_extent().extents, float(text.get_fontsize())) for text in added]
    for text in list(added):
        text.remove()
    return found


def are_apart(first, second):
    return first[2] <= second[0] or second[2] <= first[0] or first[3] <= second[1] or second[3] <= first[1]


@pytest.mark.parametrize("size", [320, 480, 1000])
@pytest.mark.parametrize("name", SHIPPED_NAMES)
@pytest.mark.parametrize(("number", "unit"), [("-1234.5", "mm"), ("0.0", "°"), ("-0.123", "N m")])
def test_names_above_plots_are_whole_and_beside_nothing(canvases, size, name, number, unit):
    canvas = canvases[size]
    heading = PlotHeading(names=(name,), numbers=[number], unit=unit, colour="#000000")
    words = words_above(heading, canvas, COLUMN, fitted_height(heading, canvas, COLUMN))
    assert " ".join(text for text, *_ in words[2:]) == name
    boxes = [box for _, box, _ in words]
    # A blank of a pixel: boxes of lines reach as far as ascenders and descenders, which no two lines have at one place.
    shrunk = [(box[0], box[1] + 0.25 * (box[3] - box[1]), box[2], box[3]) for box in boxes]
    assert all(are_apart(one, other) for k, one in enumerate(shrunk) for other in shrunk[:k])
    scale = size / 480
    assert all(box[0] >= (10.0 - 1.0) * scale and box[2] <= (11.0 + COLUMN) * scale for box in boxes)
    points_per_pixel = scale * 72 / 64
    assert all(height >= 0.99 * NAME_HEIGHTS[-1] * points_per_pixel for *_, height in words[2:])


def test_short_names_stay_beside_their_numbers(canvases):
    heading = PlotHeading(names=("arm angle",), numbers=["40.0"], unit="°", colour="#000000")
    assert fitted_height(heading, canvases[480], COLUMN) == NAME_HEIGHTS[0]


@pytest.mark.parametrize("width", [300.0, 360.0, 400.0, 460.0, 700.0])
def test_columns_are_as_wide_as_their_headings_need_and_else_equal(canvases, width):
    canvas, names = canvases[480], ("crosshead distance", "crank angle", "rod angle")
    headings = [PlotHeading(names=(name,), numbers=["1797"], unit="mm", colour="#000000") for name in names]
    row = HeadingRow.fit(canvas, headings, width)
    assert sum(row.widths) == pytest.approx(width)
    needs = [one.width_in_one_line(canvas, row.height or NAME_HEIGHTS[-1]) for one in headings]
    assert (row.height is None) == (sum(needs) > width)
    if row.height is not None:
        assert all(given >= need - 1e-9 for given, need in zip(row.widths, needs, strict=True))
        # A column is wider than another only because its heading needs it.
        least = min(row.widths)
        assert all(given == pytest.approx(max(least, need)) for given, need in zip(row.widths, needs, strict=True))


def test_a_name_too_long_for_a_line_goes_on_beside_the_number(canvases):
    name = "rate of displacement of the upper end of the lever"
    heading = PlotHeading(names=(name,), numbers=["1.0"], unit="m/s", colour="#000000")
    words = [text for text, *_ in words_above(heading, canvases[480], 170.0, None)]
    assert len(words) == 4  # unit, number, and two lines
    assert f"{words[2]} {words[3]}" == name


def test_several_names_have_their_colours(canvases):
    heading = PlotHeading(names=("torque", "load"), numbers=["150"], unit="N m", colour="#1371d5", name_colours=("#1371d5", "#b9500a"))
    words = [text for text, *_ in words_above(heading, canvases[480], 170.0, NAME_HEIGHTS[0])]
    assert words[2:] == ["torque,", "load"]


@pytest.fixture(scope="module")
def porter():
    return fake_run(GOVERNOR_DIMENSIONS["porter"], duration=3.4, output_interval=0.02)


@pytest.mark.parametrize("options", [{}, {"labels": True, "forces": True, "view": "both"}])
def test_all_words_of_a_film_are_large_enough_to_be_read(porter, options):
    heights = {text.get_text(): text.get_fontsize() * 64 / 72 for text in texts_of(painter_of(porter, 11, 5.0, **options).figure)}
    assert len(heights) > 20
    assert min(heights.values()) >= 0.99 * SMALL_TEXT, min(heights, key=heights.get)


def test_a_constant_reading_is_stated_without_a_plot():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=2.0, output_interval=0.02)
    run = dataclasses.replace(run, readings={**run.readings, "spindle_speed": np.full(len(run.times), 12.0)})
    for readings, count in ((None, 2), (["arm_angle", "spindle_speed"], 2), (["spindle_speed"], 1)):
        painter = painter_of(run, 11, readings=readings)
        assert sum(isinstance(panel, CurvePanel) for panel in painter.panels) == count
        assert "spindle speed" in words_of(painter.figure)


def test_no_label_line_crosses_the_lift_scale_or_a_word(porter):
    """At each frame, whatever the height of the sleeve."""
    painter = painter_of(porter, 41, labels=True)
    data = painter.frame_data
    overlay = ElevationOverlay(data, data.drawing.bounds, FilmOptions(labels=True))
    overlay.place_labels(painter.view, lambda *_, **__: None, 0.0)
    obstacles = [shape for shape in data.drawing.static_shapes if isinstance(shape, TextShape) or shape.role == "scale"]
    assert len(obstacles) > 1
    boxes = np.array([bounding_box([shape]) for shape in obstacles])
    # Words have no height in metres; a line through their middle would cross them.
    boxes[:, 2:] += np.array([-1e-4, 1e-4])
    boxes[:, 1] += 1e-4
    for k in range(41):
        (lines,) = (shape for shape in shapes_of(overlay.parts(), k) if isinstance(shape, Lines) and shape.role == "label line")
        starts, ends = np.moveaxis(np.array(lines.lines), 1, 0)
        is_drawn = np.hypot(*(ends - starts).T) > 0.0
        enters, leaves = shares_within(starts[is_drawn, None], ends[is_drawn, None], boxes[None])
        assert not (enters < leaves).any()


def test_labels_stand_one_below_the_other(porter):
    painter = painter_of(porter, 11, labels=True)
    data = painter.frame_data
    placed = place_labels(data, find_labels(data), painter.view, data.drawing.static_shapes)
    assert len(placed) > 5
    assert np.diff([label.height for label in placed]).min() >= LABEL_PITCH - 1e-9
    assert {label.name for label in placed} >= {"arm", "ball", "link", "sleeve"}


def cross(first, second):
    """Return whether two pieces of lines cross, from the sides of each on which the ends of the other are."""
    (a, b), (c, d) = np.array(first), np.array(second)

    def side(start, end, point):
        (x, y), (u, v) = end - start, point - start
        return x * v - y * u

    return side(a, b, c) * side(a, b, d) < -1e-12 and side(c, d, a) * side(c, d, b) < -1e-12


PLACES = st.tuples(st.integers(-30, 25), st.integers(-30, 30))
"""A point of a drawing, cm."""


@given(st.lists(PLACES, min_size=2, max_size=8, unique=True))
def test_lines_to_parts_at_rest_do_not_cross(porter, places):
    data = data_of(porter, 3)
    view = fit_view((-0.3, 0.3, -0.35, 0.35), (12.0, 40.0, 180.0, 400.0))
    labels = [Label(name=str(k), points=np.tile(place, (3, 1)) / 100) for k, place in enumerate(places)]
    placed = place_labels(data, labels, view, [])
    assert sorted(label.name for label in placed) == sorted(label.name for label in labels)
    assert np.diff([label.height for label in placed]).min() >= LABEL_PITCH - 1e-9
    assert not any(cross(a, b) for first, second in combinations(placed, 2) for a in first.lines[0] for b in second.lines[0])


def test_a_line_has_a_gap_where_another_crosses_it():
    """Two points that change places, at one distance from the names: their lines cross in one of two frames."""
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, output_interval=0.02)
    data = FrameData(run, run.scene.part, (0.0, 1.0), np.array([0.25, 0.75]))
    view = fit_view((-0.3, 0.3, -0.35, 0.35), (12.0, 40.0, 180.0, 400.0))
    high, low = (-0.2, 0.2), (-0.2, -0.2)
    labels = [Label(name=name, points=np.array(points)) for name, points in (("a", [high, low]), ("b", [low, high]))]
    upper, lower = (label.lines for label in place_labels(data, labels, view, []))
    drawn = [[sum(start != end for start, end in lines[k]) for k in range(2)] for lines in (upper, lower)]
    assert sorted(drawn[1]) == [1, 2]  # pieces of the lower line without and with a crossing
    assert drawn[0] == [1, 1]
    assert not any(cross(a, b) for k in range(2) for a in upper[k] for b in lower[k])


@pytest.mark.parametrize("layout", [layout for layout in FilmLayout if layout is not FilmLayout.BARE])
def test_names_take_no_room_from_the_machine_nor_from_a_frame_in_16_9(porter, layout):
    plain, named = (painter_of(porter, 3, layout=layout, labels=labels) for labels in (False, True))
    assert named.view.scale == pytest.approx(plain.view.scale)
    widths = [painter.draw(0).shape[1] for painter in (plain, named)]
    assert widths[0] == widths[1] if layout is FilmLayout.WIDE else widths[1] > widths[0] + 50


def test_numbers_of_a_scale_do_not_touch():
    scale = [TextShape("scale", 0.0, 0.01 * k, f"{k} bar" if k == 4 else str(k), 0.1) for k in range(5)]
    roomy, small, tiny = (fit_view((0.0, 0.2, -0.1, 0.1), (0.0, 0.0, size, size)) for size in (240.0, 120.0, 60.0))
    assert thin_out_numbers(scale, roomy) == scale
    assert [word.text for word in thin_out_numbers(scale, small)] == ["0", "2", "4 bar"]
    assert [word.text for word in thin_out_numbers(scale, tiny)] == ["0", "4 bar"]


def test_a_line_is_broken_at_boxes():
    boxes = np.array([[1.0, 2.0, -1.0, 1.0], [1.5, 3.0, -1.0, 1.0], [5.0, 6.0, 2.0, 3.0]])
    straight, steep = break_lines((0.0, 0.0), np.array([[4.0, 0.0], [0.0, 4.0]]), boxes)
    # Two boxes that overlap make one gap; the third is never met, and a line that meets none is whole.
    assert [piece for piece in straight if piece[0] != piece[1]] == [((0.0, 0.0), (1.0, 0.0)), ((3.0, 0.0), (4.0, 0.0))]
    assert [piece for piece in steep if piece[0] != piece[1]] == [((0.0, 0.0), (0.0, 4.0))]
    assert len(straight) == len(steep)  # so that an animated drawing moves them evenly
