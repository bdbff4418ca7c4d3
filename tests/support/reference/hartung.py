"""Reference numbers for the Hartung governor: plain data; forces in kgf where a name says so, with g = 9.81 m/s2.

Source: Fr. Dubois, Ueber eine wuenschenswerte Berichtigung am Hartung-Regulator, Dinglers Polyt. J. 327 (1912), pp.
618-620: printed values are from the paper, recomputed values from its formulas with the inputs it states,
in 12 significant digits unless a comment says otherwise. The rigid-body tables follow from the virtual work and from
Lagrange's equation of two point weights on massless bell cranks, and have 12 significant digits.
"""

import math

GRAVITY = 9.81
"""Gravity in m/s2, and newtons per kilogram-force in these numbers."""

GOVERNOR = {
    "weight_arm": 0.115,
    "sleeve_arm": 0.17,
    "angle": math.radians(132),
    "fulcrum_radius": 0.122,
    "weight_mass": 45.0,
    "sleeve_mass": 15.0,
}

SPRING_RATE = 172 * GRAVITY / 0.06
"""N/m of each weight's spring: 345.8 - 173.8 kgf over 60 mm."""
PRELOAD, PRELOAD_RADIUS = 173.8 * GRAVITY, 0.092
"""N of each spring with the weight 92 mm from the spindle axis."""

# Paper's preliminaries, recomputed.
OMEGA = (21.3628300444, 22.2005880854)  # rad/s, 204 and 212 rpm
OMEGA_SQUARED = (456.377769, 492.884401)  # 1/s2, 9 digits
MASS_KGF = 4.5871559633  # kgf s2/m
CENTRIFUGAL_KGF = (192.599792422, 343.662518128)  # at 92 mm and 204 rpm, at 152 mm and 212 rpm
RADII = (0.0922358098132, 0.151764190187)  # m, exact at 15 and -15 deg
SAGITTA_MM = 3.91853  # 115 (1 - cos 15 deg), 6 digits
ABSCISSAE_MM = (75.7894736842, 106.0)  # y1 = 60 * 192 / 152 of the printed forces, and y0
TANGENT = -0.921739130435
ANGLE_DEG = 137.332023682
SLEEVE_ARM_MM = 169.95838  # symmetric extremes of the hangers; 8 digits
HANGER_OFFSETS_MM = (29.411364, -4.3346203, -29.471109)  # inner, middle, outer; 8 digits
LIFT_MM = 65.39561159  # 10 digits

PRINTED_SPEEDS = (21.363, 22.201)
"""rad/s: as the paper rounds 204 and 212 rpm; its table and the constancy of S were recomputed with them."""

# x mm, lever angle deg, P(204 rpm) kgf printed and recomputed, P(212 rpm) kgf printed and recomputed.
TABLE_2 = [
    (92, 15.1216653149, 173.8, 174.205097197, 199.8, 189.611565747),
    (100, 11.0289142339, 193.4, 193.7836223, 210.4, 210.529783768),
    (106, 7.99753139117, 208.5, 208.389175054, 226.5, 226.14010621),
    (114, 3.98901513298, 227.2, 227.796344513, 247.2, 246.886968586),
    (122, 0, 246.8, 247.16485819, 267.8, 267.595175181),
    (130, -3.98901513298, 266.3, 266.533371868, 288.3, 288.303381776),
    (138, -7.99753139117, 286.0, 285.940541326, 309.0, 309.050244152),
    (144, -11.0289142339, 301.2, 300.546094081, 325.2, 324.660566594),
    (152, -15.1216653149, 319.8, 320.124619184, 345.8, 345.578784615),
]
SLIDE_RULE_TOLERANCE = 0.66
"""kgf: within this the paper's table agrees with its own formula, all but one entry."""
MISPRINT = (92, 199.8, 189.8)
"""x mm, the force printed for 212 rpm, and the one meant."""

SPRING = {
    "polar_moment_cm4": 0.203575203953,
    "wire_length_cm": 332.880965766,
    "turns": 13.2449127907,
    "rate_kgf_per_mm": 2.86666666667,
    "rate_of_13_turns_kgf_per_mm": 2.92067307692,
    "rise_of_13_turns_kgf": 175.24038,  # over 60 mm; 8 digits
    "preload_deflection_mm": 60.6279069767,
    "section_modulus_cm3": 0.339292006588,
    "stress_kgf_per_cm2": 4079.08224517,  # under 346 kgf, as the paper rounds
}
STATIC_FORCE_KGF = (460.95857442, 504.500393745)  # under 173.8 and 345.8 kgf; 11 and 12 digits
REGULATING_FORCE_KGF = (18.4383429768, 20.1800157498)
REGULATING_SPREAD_KGF = 1.74167277298
POHLHAUSEN = {"static": (189.0, 262.0, 335.0), "regulating": (7.56, 10.48, 13.4), "spread": 0.561904761905}

# Spread of S over +-15 deg relative to its mean, percent, two decimals: angle deg and spread.
STATIC_FORCE_SPREADS = [
    (90, 55.96),
    (125, 19.23),
    (130, 11.63),
    (132, 8.21),
    (133, 6.40),
    (135, 2.69),
    (136, 1.17),
    (136.25, 0.86),
    (137, 1.64),
    (137.33, 2.37),
    (138, 3.90),
    (140, 8.77),
    (142, 14.21),
]
# S in kgf at 15, 10, ... -15 deg, 8 digits, the spring being the line through both speeds for the same angle; the arm
# b is 170 mm in the first row, and that of symmetric hangers in the second, at 137.332023682 deg.
STATIC_FORCES_132 = (463.32046, 471.02934, 479.72555, 488.11343, 495.27629, 500.51604, 503.26844)
STATIC_FORCES_CORRECTED = (495.73448, 490.10976, 488.4092, 488.23294, 488.08725, 486.95889, 484.1105)
SLEEVE_ARM_CORRECTED_MM = 186.35768  # 8 digits

SPINDLE_INERTIA = 0.8
"""kg m2 of the spindle in the column of the free one."""

# lever angle deg, x m, P N, speed rad/s, rpm, stiffness N m/rad, inertia kg m2, frequency rad/s, squared frequency of
# the free spindle 1/s2, static sleeve force N; the hanger always vertical.
VERTICAL_HANGER = [
    (
        15,
        0.0922358098132,
        1711.60944357,
        21.3459358273,
        203.83867211,
        100.207285711,
        1.31883983261,
        8.71673055382,
        826.506950305,
        4537.9155138,
    ),
    (
        10,
        0.102030459568,
        1987.05458398,
        21.5532556735,
        205.818430809,
        99.0453517035,
        1.35456342913,
        8.55100924798,
        927.301067063,
        4615.90128988,
    ),
    (
        5,
        0.111977089584,
        2266.77371328,
        21.7322362165,
        207.527569098,
        95.1847620946,
        1.39188028432,
        8.2695670492,
        1006.5420681,
        4703.16627922,
    ),
    (0, 0.122, 2548.638, 21.8850478062, 208.98681229, 88.9554700531, 1.42965654441, 7.88806482679, 1060.83904936, 4787.1033118),
    (
        -5,
        0.132022910416,
        2830.50228672,
        22.0138257273,
        210.216550852,
        80.6341226603,
        1.46674439687,
        7.41450587379,
        1088.81527884,
        4858.78171558,
    ),
    (
        -10,
        0.141969540432,
        3110.22141602,
        22.1204263656,
        211.234511964,
        70.4513659026,
        1.50201694607,
        6.84868659134,
        1090.76774037,
        4911.39165095,
    ),
    (
        -15,
        0.151764190187,
        3385.66655643,
        22.2063035825,
        212.054578977,
        58.5951158336,
        1.53440245343,
        6.17960998794,
        1068.23593748,
        4939.42251278,
    ),
]

HANGER_LENGTH = 0.30
"""m, to a lug on the axis."""

# lever angle deg, speed rad/s, stiffness N m/rad, inertia kg m2, frequency rad/s, static sleeve force N.
INCLINED_HANGER = [
    (15, 21.2933706824, 114.70835596, 1.28278580347, 9.45628287471, 5323.08316603),
    (-15, 22.2229344398, 58.8391796611, 1.56989315871, 6.12206950795, 4709.92603829),
]
