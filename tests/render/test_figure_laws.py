"""What every figure keeps to: contrast of texts in both themes, quantities with units, curves that differ in grey, sheets A4."""

import re

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

import governor_mechanism as gm
from colour_vision import MIN_CONTRAST, contrast
from decoding import texts_of
from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.artists import OVER_COLOUR_MAP, themed, themed_colour
from governor_mechanism.render.figures.designs.governors import sleeve_force_figure, spring_lines_figure
from governor_mechanism.render.figures.page import SERIES_LINE_STYLES, SERIES_MARKERS, Page
from governor_mechanism.render.figures.plates.isochronous import isochronous_figure
from governor_mechanism.render.figures.plates.marks import EccentricDiagram, draw_marks_plate
from governor_mechanism.render.figures.plates.zeuner import draw_zeuner_plate
from governor_mechanism.render.style import BLUE, INK, PAPER, SERIES_COLOURS
from governor_mechanism.studies.design.hartung import design_hartung

FIGURES = {
    "Zeuner's plate": lambda: draw_zeuner_plate(EccentricDiagram(gm.load("slide_valve_marks"))),
    "Marks' plate": lambda: draw_marks_plate(EccentricDiagram(gm.load("slide_valve_marks"))),
    "Zehnder's plate": lambda: isochronous_figure(gm.load("watt_improved")),
    "sleeve force": lambda: sleeve_force_figure(design_hartung()),
}
PLATES = ("Zeuner's plate", "Marks' plate", "Zehnder's plate")


@pytest.fixture(scope="module", params=FIGURES)
def figure(request):
    return FIGURES[request.param]()


def pixels_of(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[::-1, :, :3], canvas.get_renderer()


def ground_colours(figure, texts):
    """Return the most frequent colour within the box of each text, in a picture without any text."""
    renderer = pixels_of(figure)[1]
    boxes = [text.get_window_extent(renderer) for text in texts]
    for text in texts:
        text.set_visible(False)
    picture = pixels_of(figure)[0]
    for text in texts:
        text.set_visible(True)
    for box in boxes:
        (left, bottom), (right, top) = np.floor(box.min).astype(int).clip(0), np.ceil(box.max).astype(int)
        colours, counts = np.unique(picture[bottom:top, left:right].reshape(-1, 3), axis=0, return_counts=True)
        yield None if not len(counts) else to_hex(colours[np.argmax(counts)] / 255)


@pytest.mark.long
@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
def test_every_text_has_contrast_to_its_ground(figure, theme):
    with themed(figure, theme):
        figure.draw_without_rendering()  # creates the ticks and their labels
        texts = texts_of(figure)
        assert len(texts) > 20
        for text, ground in zip(texts, ground_colours(figure, texts), strict=True):
            if ground is None:
                continue  # a tick label beyond the limits of its axis
            halo = to_hex(themed_colour(PAPER, theme)) if text.get_path_effects() else ground
            assert contrast(to_hex(text.get_color()), halo) >= MIN_CONTRAST, (text.get_text(), text.get_color(), halo)


def test_every_axis_has_a_quantity_with_its_unit(figure):
    labels = [label for axes in figure.axes if axes.axison for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    for label in labels:
        assert re.fullmatch(r"[A-Z].* \[[^\]]+\]", label), label


def test_styles_of_curves_differ_without_colours():
    assert len(SERIES_COLOURS) == len(set(map(str, SERIES_LINE_STYLES))) == len(set(SERIES_MARKERS))
    for drawn in (sleeve_force_figure(design_hartung()), spring_lines_figure(design_hartung())):
        for axes in drawn.axes:
            curves = [line for line in axes.lines if len(line.get_xdata()) > 2]
            styles = [str((line._unscaled_dash_pattern, line.get_marker())) for line in curves]
            assert len(styles) == len(set(styles))


@pytest.mark.long
@pytest.mark.parametrize("name", PLATES)
def test_a_plate_is_a_sheet_a4_of_vectors(tmp_path, name):
    content = FIGURES[name]().save(tmp_path / "plate.pdf").read_bytes()
    (box,) = re.findall(rb"/MediaBox \[ ?([^\]]+?) ?\]", content)
    # 297 mm by 210 mm in points of 1/72 inch
    np.testing.assert_allclose([float(one) for one in box.split()], [0, 0, 297 / 25.4 * 72, 210 / 25.4 * 72], atol=0.01)
    assert b"/Subtype /Image" not in content
    assert b"/Type3" not in content  # journals refuse fonts of Type 3


def test_arrows_change_with_the_theme_and_what_stands_on_a_colour_map_does_not():
    page = Page(4, 3)
    panel = page.add_panel((0.2, 0.2, 0.7, 0.7))
    arrow = panel.annotate("", (1, 1), (0, 0), arrowprops={"arrowstyle": "-|>", "color": INK}).arrow_patch
    (kept,) = panel.plot([0, 1], [1, 0], color=BLUE, gid=OVER_COLOUR_MAP)
    with themed(page, Theme.DARK):
        assert to_hex(arrow.get_edgecolor()) == to_hex(themed_colour(INK, Theme.DARK))
        assert to_hex(kept.get_color()) == BLUE
    assert to_hex(arrow.get_edgecolor()) == INK
