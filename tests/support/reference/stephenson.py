"""Stephenson's link motion: full-cycle results of two solvers that agree to 1e-11 m, with dimensions of our own.

The four suspensions are Figures 2 to 5 of Müller-Melchiors on Marks' model, Dinglers Polytechnisches Journal 241 (1881), p. 161, which
prints no dimensions. r = 60 mm, l = 1200 mm, advance 30 deg, link radius 1200 mm, half link 150 mm, hanger 500 mm; open rods. Extremes
and means are those at 720 equally spaced crank angles.
"""

import math

from data_files import read_data

ROWS = read_data(__file__)["ROWS"]

FIRST_ORDER_AMPLITUDES = {1: (0.03, 0.0519615242271), 0.5: (0.0348713928963, 0.0259807621135), 0: (0.0364951905284, 0.0),
                          -0.5: (0.0348713928963, -0.0259807621135), -1: (0.03, -0.0519615242271)}  # fmt: skip
"""Amplitudes A and B (m) of Zeuner's law A cos w + B sin w, by the die offset relative to half the link."""

SMALL_ECCENTRIC_RATIOS = {1: (1.0011, 0.9973), -1: (1.0011, 0.9973), 0.5: (None, 1.0053), -0.5: (None, 1.0053), 0: (1.0014, None)}
"""Exact first harmonics relative to Zeuner's law in the limit of small eccentrics, by the gear; to four decimals."""

MID_GEAR_SLIPS = ("arc middle", "half-way", "chord middle", "lower pin")
"""Suspensions by the slip of the die in mid gear, the smallest first: 1.4, 6.2, 6.4 and 12.6 mm."""


def solve_closure(crank_angle: float, gear: float, sizes: dict, guess: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return distance of the valve, die offset and link angle, by scipy's root finder on the lengths of both rods and the hanger.

    `guess` is the position x, y, angle of the link.
    """
    from scipy.optimize import root

    r, rod, advance, radius, half = (sizes[name] for name in ("eccentric", "eccentric_rod", "advance", "link_radius", "half_link"))
    suspension, hanger, setback, crossed = sizes["suspension"], sizes["hanger"], sizes.get("pin_setback", 0.0), sizes.get("crossed", False)
    pin = math.sqrt(radius**2 - half**2) - radius - setback
    forward = complex(r * math.sin(crank_angle + advance), r * math.cos(crank_angle + advance))
    backward = complex(-r * math.sin(crank_angle - advance), -r * math.cos(crank_angle - advance))
    upper, lower = (backward, forward) if crossed else (forward, backward)
    offset = gear * radius * math.asin(half / radius) * (-1 if crossed else 1)
    top = complex(math.sqrt(rod**2 - half**2) - pin + suspension[0], suspension[1] - offset + hanger)

    def errors(position):
        origin, turn = complex(position[0], position[1]), complex(math.cos(position[2]), math.sin(position[2]))
        ends = ((complex(pin, half), upper, rod), (complex(pin, -half), lower, rod), (complex(*suspension), top, hanger))
        return [abs(origin + turn * point - end) - length for point, end, length in ends]

    x, y, angle = root(errors, guess, tol=1e-13).x
    assert max(map(abs, errors((x, y, angle)))) < 1e-12
    centre = complex(x, y) - radius * complex(math.cos(angle), math.sin(angle))
    valve = centre.real + math.sqrt(radius**2 - centre.imag**2)
    return valve, radius * (math.atan2(-centre.imag, valve - centre.real) - angle), angle
