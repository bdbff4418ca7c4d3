"""Reference numbers for slide valve and slider crank: plain data, SI unless a name or a comment says otherwise.

Source of all: the formulas of Müller-Melchiors on Marks' construction, Dinglers Polyt. J. 241 (1881), p. 161, and the
exact triangle behind them, recomputed with 25-40 digit arithmetic and printed to 12 significant digits with trailing
zeros left out. The paper prints no dimensions but the ratio l : r = 4; these are chosen.
"""

import csv
from pathlib import Path

ECCENTRIC, ADVANCE_DEG = 0.06, 30.0
OUTSIDE_LAP, INSIDE_LAP = 0.024, 0.005
CRANK, CONNECTING_ROD = 0.3, 1.5

# Columns of valve_events.csv: l : r, event, crank angle (deg) by theory, exactly and by the binomial error term, the exact one's shift from
# theory (deg), and the way of the piston as a part of the stroke: by theory (both rods infinite), exact eccentric and infinite connecting
# rod, theory of the eccentric and exact connecting rod, both exact.
with Path(__file__).with_name("valve_events.csv").open(encoding="utf-8") as stream:
    EVENT_ROWS = list(csv.reader(stream))[1:]
VALVE_EVENTS = {ratio: [(row[1], *map(float, row[2:])) for row in EVENT_ROWS if int(row[0]) == ratio] for ratio in (4, 30)}
"""By l : r."""

ERROR_TERM_SIZES = {
    4: {
        "centre": 0.234307490277,
        "binomial_centre": 0.234375,
        "binomial_extremes": (0.005625, -0.001875),
        "exact_extremes": (0.0056925097228, -0.00192848950475),
        "displacements": (0.0656925097228, -0.0543074902772),
        "neglected": 0.0001171875,
        "largest_neglected": 0.000120999227555,
        "parabola_constant": 0.0009,
        "vertex": -0.001875,
        "leads_from_middle": (0.000375, 0.011625),
    },
    30: {
        "centre": 1.79924984368,
        "binomial_centre": 1.79925,
        "binomial_extremes": (0.00075, -0.00025),
        "exact_extremes": (0.000750156315138, -0.000250121617068),
        "displacements": (0.0607501563151, -0.0592498436849),
        "neglected": 2.77777777778e-07,
        "largest_neglected": 2.77932206016e-07,
        "parabola_constant": 0.0009,
        "vertex": -0.00025,
        "leads_from_middle": (0.00525, 0.00675),
    },
}
"""By l : r, in m: centre of the swing for equal leads, extremes of the error term and of the displacement, r^4 / 8 l^3
and the largest that is really neglected, Marks' C (m2) and vertex, leads (crank end, head end) from the middle."""

# l : r = 4: crank angle (deg), theoretical displacement, exact displacement, exact error, parabola, circle (m).
ERROR_TERMS = [
    (0, 0.03, 0.03, 0, 0, 0),
    (30, 0.0519615242271, 0.0557716519457, 0.00381012771861, 0.00375, 0.00381012771861),
    (60, 0.06, 0.0656925097228, 0.0056925097228, 0.005625, 0.00573861722337),
    (90, 0.0519615242271, 0.0557716519457, 0.00381012771861, 0.00375, 0.00381012771861),
    (120, 0.03, 0.03, 0, 0, 0),
    (150, 0, -0.00192848950475, -0.00192848950475, -0.001875, -0.00188238200419),
    (180, -0.03, -0.03, 0, 0, 0),
    (210, -0.0519615242271, -0.0481513965085, 0.00381012771861, 0.00375, 0.00381012771861),
    (240, -0.06, -0.0543074902772, 0.0056925097228, 0.005625, 0.00573861722337),
    (270, -0.0519615242271, -0.0481513965085, 0.00381012771861, 0.00375, 0.00381012771861),
    (300, -0.03, -0.03, 0, 0, 0),
    (330, 0, -0.00192848950475, -0.00192848950475, -0.001875, -0.00188238200419),
]

# Slider crank, R = 0.3 m, L = 1.5 m, 10 rad/s: angle from the outer dead centre (deg), distance X (m), speed (m/s),
# acceleration (m/s2), slope of the rod (deg), its rate (rad/s) and acceleration (rad/s2), exact error Z (m).
SLIDER_CRANK_MOTION = [
    (0, 1.8, 0, -36, 0, 2, 0, 0),
    (30, 1.7522887768, -1.76111648393, -29.0415590964, 5.73917047727, 1.74077655956, -9.74582123888, 0.00751884434007),
    (45, 1.69705627485, -2.42436610693, -21.2750495098, 8.13010235416, 1.42857142857, -13.9941690962, 0.0150757595083),
    (60, 1.62732867027, -2.86187088315, -12.0010651927, 9.9742217944, 1.01534616513, -17.4050092729, 0.0226713297306),
    (79, 1.52805088684, -3.05949402557, -0.0596844052635, 11.322162321, 0.389192139881, -19.9918721315, 0.0291918117768),
    (90, 1.46969384567, -3, 6.12372435696, 11.5369590328, 0, -20.4124145232, 0.0303061543301),
    (120, 1.32732867027, -2.33428153956, 17.9989348073, 9.9742217944, -1.01534616513, -17.4050092729, 0.0226713297306),
    (150, 1.23267353452, -1.23888351607, 22.9199651307, 5.73917047727, -1.74077655956, -9.74582123888, 0.00751884434007),
    (180, 1.2, 0, 24, 0, -2, 0, 0),
    (270, 1.46969384567, 3, 6.12372435696, -11.5369590328, 0, 20.4124145232, 0.0303061543301),
]

# Eccentric, r = 0.06 m, l = 0.24 m, advance 30 deg, 10 rad/s: crank angle (deg), s (m), s' (m/s), s'' (m/s2).
ECCENTRIC_MOTION = [
    (0, 0.264307490277, 0.586145156657, -2.25066940761),
    (30, 0.290079142223, 0.365465367071, -5.97007967696),
    (60, 0.3, 0, -7.5),
    (90, 0.290079142223, -0.365465367071, -5.97007967696),
    (120, 0.264307490277, -0.586145156657, -2.25066940761),
    (150, 0.232379000772, -0.6, 1.54919333848),
    (180, 0.204307490277, -0.453085327885, 3.74933059239),
    (240, 0.18, 0, 4.5),
    (300, 0.204307490277, 0.453085327885, 3.74933059239),
]
