"""Stephenson's link motion: full-cycle results of two solvers that agree to 1e-11 m, with dimensions of our own.

The four suspensions are Figures 2 to 5 of Müller-Melchiors on Marks' model, Dinglers Polytechnisches Journal 241 (1881), p. 161, which
prints no dimensions. r = 60 mm, l = 1200 mm, advance 30 deg, link radius 1200 mm, half link 150 mm, hanger 500 mm; open rods. Extremes
and means are those at 720 equally spaced crank angles.
"""

import math

ROWS = [
    # suspension, gear, valve travel m, (x(0) - x(180 deg)) / 2 m, slip range mm, mean u m, cos amplitude, sin amplitude, second harmonic
    ("arc middle", 1, 0.122681769435, 0.0300792552328, 13.9301603731, 0.154088267978, 0.0296845080852,
     0.0540478384714, 0.00112360414077),
    ("arc middle", 0, 0.073110042184, 0.0365523543457, 1.42378591818, -0.000675124777605, 0.0364735550534,
     -0.000118804324473, 0.000580616192844),
    ("arc middle", -1, 0.12323498885, 0.0298228075989, 11.2838080663, -0.155682176815, 0.0295404698778,
     -0.0543399634945, 0.000916417102762),
    ("chord middle", 1, 0.123424636365, 0.0299762539157, 18.0395880354, 0.155353514081, 0.0295884550181,
     0.0544727649397, 0.00150832281656),
    ("chord middle", 0, 0.0731102712508, 0.0365523455807, 6.42402196033, -0.000680802145551, 0.0364861450106,
     -0.000119891224678, 0.00113938520393),
    ("chord middle", -1, 0.123979681092, 0.0297146801286, 15.6553858077, -0.156954683011, 0.0294426823993,
     -0.0547631794094, 0.00135978837843),
    ("lower pin", 1, 0.127009796385, 0.0299712318261, 30.127354841, 0.158919783335, 0.0296055965084,
     0.0562208880548, 0.00224900910436),
    ("lower pin", 0, 0.0731106635466, 0.0365523506576, 12.6415781554, 0.00226328387703, 0.036802068306,
     0.0014340287568, 0.00118215405984),
    ("lower pin", -1, 0.122142292283, 0.0298815748478, 5.017772757, -0.15273469391, 0.03011333335,
     -0.0528524596516, 0.000910787189055),
]  # fmt: skip

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
