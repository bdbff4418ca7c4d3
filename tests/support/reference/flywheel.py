"""Reference numbers for the flywheel of the air-expansion engine: plain data, SI unless a name or a comment says otherwise.

Source: F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, recomputed with 25-40 digit arithmetic and
printed to 12 significant digits. Ratios are the paper's; the sizes of the example are chosen. The textbook problems are from the
solutions of FOSSEE/Python-Textbook-Companions (commit d34b2ae); each recomputed with the formulas of its book.
"""

RATIOS = {"cut_off": 0.375, "clearance": 0.05, "pump_clearance": 0.05}
PRESSURES = {"atmospheric_pressure": 1e5, "supply_pressure": 4e5, "back_pressure": 1.5e5}
SIZES = {"area": 0.05, "stroke": 0.65, "pump_area": 0.05, "pump_stroke": 0.65}
LOAD_PRESSURE = 0.4e5
ENGINE = {**RATIOS, **PRESSURES, **SIZES, "load_pressure": LOAD_PRESSURE}

INTERVAL_LIMITS_DEG = (45.5729959992, 75.5224878141, 125.099632195)

# Case: R over the atmospheric pressure, a / A, alpha and beta in deg, the bracket B and 2250 (p / R) B.
CASES = {
    "exact constant": (0.4, 1.0, 2.67495871811, 95.4491534156, 0.237422006013, 5341.99513529),
    "closed by the load": (0.359225459234, 1.0, 2.39838369281, 95.7840017408, 0.242693247343, 6080.41320552),
    "closed by the pump": (0.4, 0.965396924849, 2.72694010898, 95.9409265506, 0.238313019725, 5362.04294381),
}
ROUNDED_CONSTANT = (0.25, 2.62533583627, 95.5090824236, 0.237421450604)
"""2 R / pi over the atmospheric pressure as printed, its roots (deg), and the bracket between them with the exact load."""

BALANCE_62_RANGE = (1.681445, 1.976755)
"""Smallest and largest value of (62) on its interval, with the exact constant, to six decimals."""
BALANCE_64_START = -2.781396
"""Value of (64) at its left limit, with the exact constant, to six decimals."""

TERMS_AT_PRINTED_ANGLES = (0.141983678509, 0.374314767377, -0.203584739532, -0.191237040703, 0.0686341384074, 0.0983944678435,
                           -0.0511111111111)  # fmt: skip
TERMS_AT_EXACT_ANGLES = (0.144769287068, 0.374455183783, -0.205101136453, -0.193303252831, 0.0687728486992, 0.0993702950229,
                         -0.0515412192764)  # fmt: skip
SUM_AT_PRINTED_ANGLES, COEFFICIENT_AT_PRINTED_ANGLES = 0.237394160791, 5341.3686178
SUM_AT_EXACT_ANGLES, COEFFICIENT_AT_EXACT_ANGLES = 0.237422006013, 5341.99513529
WRONG_THIRD_TERM = -0.271446319376
"""The third term at 3 and 95 deg with r / p = 0.5; printed as -0.2714."""

EXPANSION_WORK, PUMP_WORK = 1.53757566619, -1.17835020695
"""Work of a stroke over A L times the atmospheric pressure."""
NET_WORK_RATIO = -0.0101936351914
"""Work that the shaft gains in a stroke with the paper's data, over A p L."""

STORED_WORK = {
    0: 0.0, 1: -0.000450904599085, 3: -0.000729180706909, 10: 0.0043577012444, 30: 0.050397619764, 45: 0.0955173264647,
    60: 0.145848784408, 75: 0.200142859163, 90: 0.234152458717, 95: 0.236664980084, 105: 0.229030000213, 125: 0.163760079079,
    140: 0.0934291070375, 160: 0.0224566313953, 175: -0.00604619430658, 180: -0.0101936351914,
}  # fmt: skip
"""Stored work since the dead centre over A p L, by the crank angle in deg."""

MEAN_SPEED, ENERGY_RATIO = 6.283185307179586, 20.0
EXAMPLE_ENERGY, EXAMPLE_INERTIA, EXAMPLE_LOAD_TORQUE = 3155.01221546, 3196.69572076, 371.62129889
EXAMPLE_START_SPEED, EXAMPLE_LOWEST_SPEED, EXAMPLE_HIGHEST_SPEED = 6.20453923393, 6.20414838348, 6.36124029136
EXAMPLE_COEFFICIENT = 0.025001954
"""The closed cycle by the load, with the mean speed that has the mean of the extreme energies."""
