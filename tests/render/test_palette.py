"""The colours: contrast of text on its ground, and distances of curves for readers with and without colour vision."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from colour_vision import MIN_CONTRAST, VISIONS, contrast, lab
from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.artists import themed_colour
from governor_mechanism.render.style import INK, MUTED, PAPER, SERIES_COLOURS, darken

MIN_DISTANCE = 20.0
"""Smallest distance of two curves in CIELAB: ten times what the eye notices side by side (2.3), with a margin for thin lines."""

COLOURS = (PAPER, INK, MUTED, *SERIES_COLOURS)
GROUNDS = {
    "light": {colour: colour for colour in COLOURS},
    "dark figure": {colour: to_hex(themed_colour(colour, Theme.DARK)) for colour in COLOURS},
    "dark page": {colour: darken(colour) for colour in COLOURS},
}


def test_black_on_white_has_the_contrast_of_the_guidelines_and_lightness_100():
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    np.testing.assert_allclose(lab("#ffffff", np.eye(3)), [100, 0, 0], atol=0.01)


@pytest.mark.parametrize("ground", GROUNDS)
def test_every_text_has_contrast(ground):
    colours = GROUNDS[ground]
    for colour in (INK, MUTED, *SERIES_COLOURS):
        assert contrast(colours[colour], colours[PAPER]) >= MIN_CONTRAST, colour


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("vision", VISIONS)
def test_curves_differ_for_every_reader(ground, vision):
    seen = {colour: lab(GROUNDS[ground][colour], VISIONS[vision]) for colour in SERIES_COLOURS}
    for first, second in combinations(seen, 2):
        assert np.linalg.norm(seen[first] - seen[second]) >= MIN_DISTANCE, (first, second)
