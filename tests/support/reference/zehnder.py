"""Reference numbers for pendulum governors: plain data, SI unless a name or a comment says otherwise.

Source of all: the formulas of L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14, and what follows from them by
Lagrange's equation, recomputed with 25-40 digit arithmetic and g = 9.81 m/s2, printed to 12 significant digits with
trailing zeros left out; other numbers of digits are noted at the number. `dimensions` are keywords of the closed forms'
PendulumGovernor; mass is per ball, per arm, per link.
"""

import math

# Columns of every table of rows: arm angle (deg), spindle speed (rad/s), the same in rpm, stiffness K (N m/rad),
# in-plane inertia I (kg m2), squared frequency at constant speed (1/s2), squared frequency of the free spindle (1/s2).

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: Watt, suspended on the axis.
WATT_ON_AXIS = {
    "dimensions": {"arm": 0.4, "ball_mass": 1.0},
    "rest_inertia": 0.0,
    "rows": [
        (10, 4.99032440393, 47.6540877911, 0.24029680444, 0.32, 0.750927513873, 97.3605680844),
        (20, 5.1087141112, 48.7846262184, 0.976959470463, 0.32, 3.0529983452, 95.2368444443),
        (30, 5.32156280652, 50.8171815379, 2.2655224563, 0.32, 7.07975767594, 92.0368497872),
        (40, 5.65818997303, 54.0317341896, 4.23291961708, 0.32, 13.2278738034, 88.3768336734),
        (45, 5.88927734253, 56.2384560181, 5.54937401875, 0.32, 17.3417938086, 86.708969043),
        (50, 6.17690269097, 58.985075776, 7.16472343238, 0.32, 22.3897607262, 85.4472252364),
        (60, 7.00357051796, 66.8791720335, 11.772, 0.32, 36.7875, 85.8375),
    ],
}

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: Watt, open.
WATT_OPEN = {
    "dimensions": {"arm": 0.4, "offset": 0.05, "ball_mass": 2.0},
    "rest_inertia": 0.3,
    "rows": [
        (10, 3.80525669753, 36.3375247888, 6.95038969638, 0.64, 10.8599839006, 19.839697718),
        (20, 4.37189412221, 41.7485136134, 5.90166498214, 0.64, 9.2213515346, 30.6589078246),
        (30, 4.75975047277, 45.4522689375, 7.24967186016, 0.64, 11.3276122815, 42.221100322),
        (40, 5.17714970529, 49.4381380034, 10.4233847564, 0.64, 16.2865386819, 51.3330013601),
        (50, 5.72727530635, 54.6914505272, 15.7448075686, 0.64, 24.601261826, 58.6880552203),
        (60, 6.54700131383, 62.5192572915, 24.5338838075, 0.64, 38.3341934492, 67.3491905952),
    ],
}

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: Porter, open.
PORTER_OPEN = {
    "dimensions": {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0},
    "rest_inertia": 0.5,
    "rows": [
        (15, 10.5695787298, 100.932042075, 58.5316922402, 1.38230854638, 42.3434351134, 101.194762359),
        (20, 11.1887990827, 106.845160876, 57.1033784718, 1.74224000477, 32.7758393307, 98.8190699621),
        (25, 11.7105329974, 111.827352767, 60.9832349893, 2.18596460513, 27.8976314832, 94.2114291705),
        (30, 12.208502366, 116.582609958, 69.3071014592, 2.7, 25.6692968367, 88.1619313746),
        (35, 12.7259519049, 121.523889073, 81.8339971883, 3.26872748403, 25.0354297164, 81.7108675667),
        (40, 13.2953857456, 126.961581704, 98.7325132838, 3.8748665604, 25.4802357049, 75.6146666328),
        (45, 13.9477929519, 133.191611611, 120.558108, 4.5, 26.7906906667, 70.3480209673),
    ],
}

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: Porter on the axis.
PORTER_ON_AXIS = {
    "dimensions": {"arm": 0.3, "ball_mass": 5.0, "sleeve_mass": 20.0},
    "rest_inertia": 0.5,
    "rows": [
        (15, 13.0102903694, 124.239121401, 10.2049046089, 1.38230854638, 7.38250851133, 51.6395370668),
        (30, 13.7402160836, 131.209398532, 42.4785460556, 2.7, 15.7327948354, 74.3238928432),
        (45, 15.2060487125, 145.20706905, 104.050762852, 4.5, 23.1223917448, 66.9332392613),
    ],
}

# As PORTER_OPEN, with slender uniform rods and solid balls of radius 0.05 m (Lagrange, 25-40 digits).
PORTER_MASSIVE_RODS = {
    "dimensions": {
        "arm": 0.3,
        "offset": 0.04,
        "ball_mass": 5.0,
        "sleeve_mass": 20.0,
        "arm_mass": 0.6,
        "link_mass": 0.5,
        "ball_inertia": 0.005,
    },
    "rest_inertia": 0.5,
    "rows": [(30, 11.9859602211, 114.457489013, 72.9665608257, 2.821, 25.8654947982, 90.0208792497)],
}

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: crossed arms.
CROSSED = {
    "dimensions": {"arm": 0.4, "offset": -0.06, "ball_mass": 2.0, "sleeve_mass": 8.0},
    "rest_inertia": 0.3,
    "rows": [
        (15, 17.3765390678, 165.933725188, -99.0508468774, 0.982974966312, -100.766398201, -82.6886103499),
        (20, 15.2457589731, 145.586274106, -47.8392651801, 1.23892622562, -38.6134898035, -7.68689565034),
        (25, 14.4826592275, 138.29920831, -23.6694481023, 1.5544637192, -15.2267613646, 23.6026605844),
        (30, 14.2224748459, 135.814630483, -6.47292130371, 1.92, -3.37131317902, 38.5384574185),
        (35, 14.2376071343, 135.959133194, 8.75353391256, 2.32442843309, 3.76588661021, 45.2329714313),
        (40, 14.4499513677, 137.986871257, 24.0294763582, 2.75546066517, 8.72067479021, 47.5693670084),
        (50, 15.401985949, 147.078131833, 59.3641988614, 3.64453933483, 16.2885329002, 47.0906435371),
    ],
}

EQUILIBRIUM_TABLES = {
    "Watt on the axis": WATT_ON_AXIS,
    "Watt open": WATT_OPEN,
    "Porter open": PORTER_OPEN,
    "Porter on the axis": PORTER_ON_AXIS,
    "Porter with massive rods": PORTER_MASSIVE_RODS,
    "crossed arms": CROSSED,
}

# Zehnder (3), recomputed with 25-40 digit arithmetic: marks of the governor CROSSED.
CROSSED_MARKS = {
    "ball_on_axis_deg": 8.62692655868,
    "least_stable_deg": 32.0953133016,
    "lowest_speed": 14.2015977026,
    "lowest_speed_rpm": 135.61526845,
    "growth_rates": [(15, 10.0382467693), (20, 6.21397536232), (25, 3.90214830121), (30, 1.83611360733)],  # deg, 1/s
}

# Zehnder (1), (2), recomputed with 25-40 digit arithmetic: friction band of PORTER_OPEN.
FRICTION_BAND = {
    "arm_angle_deg": 30,
    "resistance": 40.0,
    "falling_speed": 11.1686187598,
    "equilibrium_speed": 12.208502366,
    "rising_speed": 13.1665111187,
    "insensitivity_exact": 0.163647620241,
}

# Zehnder, Dinglers Polyt. J. 225 (1877), recomputed with 25-40 digit arithmetic: the jump of the pseudo-parabolic
# governor, Watt with crossed arms and the same speed at both stops; the mass of the balls cancels in the speeds,
# energies are for 1 kg each.
FOLD_JUMP = {
    "arm": 0.4,
    "ball_mass": 1.0,
    "stops_deg": (25, 40),
    "offset": -0.0588875797367,
    "offset_over_arm": -0.147218949342,
    "least_stable_deg": 31.8721159686,
    "stop_speed": 6.4440567467,
    "stop_speed_rpm": 61.5362090881,
    "lowest_speed": 6.3280145164,
    "lowest_speed_rpm": 60.4280874145,
    "hysteresis": 0.018337858,  # of lowest_speed; 8 digits
    "growth_rate_lower_stop": 2.65494759333,  # 1/s
    "frequency_upper_stop": 2.7652729517,  # rad/s
    "effective_energy_drop": 0.0270127526693,  # J, effective potential at the lower stop less that at the upper one
    "arrival_rate": 0.410888919519,  # rad/s at the upper stop, from rest at the lower one
    "up": {"speed_ratio": 1.001, "speed": 6.45050080345, "time": 2.09463989548, "arrival_rate": 0.427708132231},
    "down": {"speed_ratio": 0.999, "speed": 6.32168650188, "time": 2.45996347147, "arrival_rate": 0.188397903555},
    "mass_ratio_4": {"stop_speed": 14.4093489365, "lowest_speed": 14.1498706213},
    "rows": [  # arm angle (deg), spindle speed (rad/s), rpm, squared frequency at constant speed (1/s2)
        (20, 6.76926685355, 64.641736851, -14.3637441956),
        (25, 6.4440567467, 61.5362090881, -7.04874672335),
        (28, 6.36126467821, 60.7456030712, -3.77062652743),
        (30, 6.33536395985, 60.4982694297, -1.78359667404),
        (32, 6.32804720773, 60.4283995938, 0.120152735646),
        (34, 6.33670292212, 60.5110555776, 1.98465337527),
        (36, 6.35959398648, 60.7296491404, 3.84334033632),
        (38, 6.39559962279, 61.0734776402, 5.72307479764),
        (40, 6.4440567467, 61.5362090881, 7.64673449743),
        (45, 6.61841496838, 63.201207459, 12.7818792704),
    ],
}

# Where the governor SNAP passes its least stable angle on slow ramps of speed, with a linear brake on the arm angle
# for both balls together (I = 2 M l^2). All four are the last of steps of 2 ms before the arms are through, counted
# from the speeds `starts` up and down (inferred: it gives every digit), and so early by less than such a step.
SLOW_FOLD_JUMP = {
    "brake": 1.0,  # N m s
    "step": 2e-3,
    "starts": (6.40, 6.50),
    "passages": [(0.004, 6.457616, 6.316144), (0.001, 6.448374, 6.32336)],  # rate (rad/s2), up, down (rad/s; 7 digits)
}

# Virtual work after Zehnder (3), 25-40 digit arithmetic: crossed arms with uncrossed links.
CROSSED_ARMS_OPEN_LINKS = {
    "dimensions": {"arm": 0.4, "offset": -0.04, "arm_joint": 0.25, "lug_offset": 0.03, "link": 0.2, "ball_mass": 1.0, "sleeve_mass": 4.0},
    "rows": [  # arm angle (deg), link angle (deg, 6 decimals), spindle speed (rad/s)
        (20, 4.446327, 9.63513458191),
        (30, 15.962014, 10.0781268599),
        (40, 26.967467, 10.6790623375),
    ],
}

# Zehnder (Ia), recomputed with 25-40 digit arithmetic: ball on an extended arm, Q / P1 = 3 with P1 the weight of the
# real ball.
EXTENDED_ARM = {
    "dimensions": {"arm": 0.4, "arm_joint": 0.25, "offset": 0.03, "ball_mass": 1.0, "sleeve_mass": 3.0},
    "arm_angle_deg": 30,
    "spindle_speed": 8.41412959012,
}

# Zehnder's design procedure I-VII (his paper prints no example), recomputed with 25-40 digit arithmetic.
DESIGN = {
    "speeds_rpm": (120, 126),
    "speeds": (12.5663706144, 13.1946891451),
    "mass_ratio": 4.0,
    "mass_ratio_limits": (0.973921, 9.52758),  # 6 digits
    "double_parameter": 0.621225507207,
    "start_abscissa": 0.176338998125,
    "start_height": 0.0500549991895,
    "start_tangent": 0.567713321746,
    "start_angle_deg": 29.58415467,  # 10 digits
    "radius_of_curvature": 0.472295165467,
    "radius_squared_cm2": 2230.6272,  # 8 digits; the right side of (V), (c + 4 y)^3 / (4 c) in cm2
    "osculating_offset": -0.0568337797197,
    # arm angle above the start (deg), spindle speed (rad/s; 9 digits), arm = radius of curvature
    "trial_speeds": [(2, 12.5809011), (4, 12.6223476), (6, 12.688365), (8, 12.7775186), (10, 12.8890711), (12, 13.022851)],
    # for the arm of each row: arm (m; None = radius of curvature), offset (m), upper angle (deg), upper abscissa (m),
    # sleeve lift (m)
    "upper_positions": [
        (None, -0.0568337797197, 43.7678478109, 0.269870752728, 0.139310995815),
        (0.3, 0.0282285822917, 35.9608054126, 0.204398088341, 0.0361275620616),
        (0.357177441842, 0.0, 37.9282228421, 0.219547620379, 0.0577556594002),
    ],
}

# Zehnder (3) on his circle of curvature, recomputed with 25-40 digit arithmetic: relative change of speed on leaving
# the start of DESIGN by an angle (deg), for arms of 1, 1.3 and 0.7 times the radius of curvature. (His text judges by
# the height of the ball over the parabola and comes to other signs; equilibrium depends on the slope.)
OSCULATION_ARMS = (1.0, 1.3, 0.7)
OSCULATION = [
    (-4, 0.0054049663385, 0.0367649581564, -0.0232712716462),
    (-2, 0.00127225140424, 0.0149809078069, -0.0118955387363),
    (-1, 0.000309666273924, 0.00676216690199, -0.00602033837649),
    (1, 0.000295258832961, -0.00548728729164, 0.00617985932501),
    (2, 0.00115629779891, -0.00984554294987, 0.0125332137148),
    (4, 0.00445450776254, -0.0156250884881, 0.0258152325345),
]

# Isochronous guide at 120 rpm (Zehnder, motion by Lagrange's equation, 25-40 digits).
GUIDE = {
    "mass_ratio": 4.0,
    "spindle_speed": 4 * math.pi,
    "double_parameter": 0.621225507207,
    "start": 0.10,
    "end": 0.20,
    "start_rate": 0.05,
    "time": 2.54294404015,
    "end_rate": 0.0319576953357,
}

# Motion of PORTER_OPEN at t = 2 s, started at 40 deg + 0.08 rad with the equilibrium speed of 40 deg (Lagrange's
# equations by Taylor series, checked to 2e-10 by a redundant Cartesian model); angles and speeds to 14 digits, arm
# rates to 13, torque to 11.
PORTER_OPEN_MOTION = {
    "arm_angle": 0.7781317007977319,
    "arm_rate": 0.15,
    "spindle_speed": 13.29538574560537,
    "time": 2.0,
    "constant_speed": {"arm_angle": 0.61078971367203, "arm_rate": 0.1473207083002, "drive_torque": 2.0415061999},
    "free_spindle": {
        "arm_angle": 0.72479420636736,
        "arm_rate": 0.1982048169713,
        "turned": 27.335519335612,  # rad
        "spindle_speed": 14.005946868127,
    },
}

# Porter, open, with W = 40 N at 30 degrees (Zehnder (1) and (2), 25-40 digits): the middle of the band, and its width
# over that.
CYCLIC_MOTION = {"mean_speed": 12.16756494, "band": 0.164198208}  # 10 and 9 digits
