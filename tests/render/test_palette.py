"""The colours: contrast of text on its ground, and distances of curves for readers with and without colour vision."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.page.colours import darken
from governor_mechanism.render.style import INK, MUTED, PAPER, SERIES_COLOURS, parse_rgb
from governor_mechanism.render.theme import themed_colour

MIN_CONTRAST = 4.5
"""Smallest contrast of small text by the Web Content Accessibility Guidelines 2.2, level AA."""

MIN_DISTANCE = 20.0
"""Smallest distance of two curves in CIELAB: ten times what the eye notices side by side (2.3), with a margin for thin lines."""

# Simulation of complete colour blindness in linear RGB: Machado, Oliveira and Fernandes (2009), table of severity 1.0.
VISIONS = {
    "normal": np.eye(3),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "tritanopia": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
}
XYZ_OF_LINEAR_RGB = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])
WHITE = np.array([0.95047, 1.0, 1.08883])


def linear_rgb(colour):
    """Return the linear parts of a colour (IEC 61966-2-1)."""
    parts = np.array(parse_rgb(colour)) / 255
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def contrast(first, second):
    """Return the contrast ratio of two colours by WCAG 2.2."""
    darker, lighter = sorted(float(linear_rgb(colour) @ XYZ_OF_LINEAR_RGB[1]) for colour in (first, second))
    return (lighter + 0.05) / (darker + 0.05)


def lab(colour, vision):
    """Return lightness, a and b (CIELAB, D65) of a colour as a reader sees it."""
    relative = XYZ_OF_LINEAR_RGB @ np.clip(vision @ linear_rgb(colour), 0, 1) / WHITE
    f = np.where(relative > 216 / 24389, np.cbrt(relative), (24389 / 27 * relative + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


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
