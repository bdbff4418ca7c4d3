"""Contrast of colours, and how readers with and without colour vision see them."""

import numpy as np

from governor_mechanism.render.style import parse_rgb

MIN_CONTRAST = 4.5
"""Smallest contrast of small text by the Web Content Accessibility Guidelines 2.2, level AA."""

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
