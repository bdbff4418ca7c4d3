"""Reference numbers for mechanisms of other people's benchmarks, and for the Porter governor in space: plain data, SI.

Angles in rad unless a name says otherwise. `own` numbers were computed apart from this project's engines, to all the
digits printed here; `published` ones have the digits that their authors print.
"""

from reference.zehnder import PORTER_OPEN, PORTER_OPEN_MOTION

# Andrews' squeezing mechanism, IVP Test Set of Bari and CWI (Ex_andrews.f of CRAN's deTestSet, after andrews.f): from
# rest, constant torque 0.033 N m on the crank. Angles in the Test Set's order. Published ones are PSIDE's at
# rtol = atol = 1e-14; an independent derivation reproduces them to 2.7e-10 of each.
ANDREWS = {
    "names": ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon"),
    "start": (
        -0.06171389001427645,
        0.0,
        0.45527981916307037,
        0.22266839016588588,
        0.48736497954384256,
        -0.22266839016588588,
        1.2305474445498212,
    ),
    # angular accelerations at the start (rad/s2); the other five are zero
    "start_accelerations": (14222.443919954114, -10666.832939965585, 0.0, 0.0, 0.0, 0.0, 0.0),
    "time": 0.03,
    "published": (
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        -0.5347301163226948,
        0.5244099658805303,
        0.5347301163226948,
        1.048080741042263,
    ),
}

# N-four-bar mechanism with N = 2, case A02 of the MBS Benchmark (Univ. A Coruna), now of the IFToMM Library of
# Computational Benchmark Problems: five uniform links of 1 m and 1 kg, g = 9.81 m/s2, cranks upright at the start,
# speed 1 m/s of the first crank's upper end. x (m), y (m), vx (m/s), vy (m/s) of that end at 10 s.
FOUR_BAR = {
    "length": 1.0,
    "mass": 1.0,
    "gravity": 9.81,
    "start_speed": 1.0,
    "time": 10.0,
    # reduced to one angle from the vertical: theta'' = g ((N + 1)/2 + N) / ((N + 1)/3 + N) sin(theta) / L
    "own": (0.328458111536937, 0.94451853817995, 1.42305147019824, -0.494868845477466),
    # Exudyn (J. Gerstmayr), fourBarMechanismIftomm.py, step 1.25e-4 s; the limit of its series of steps is `own` to
    # 1.3e-8 in position, this member of it lies 7.4e-7 off
    "published_step": 1.25e-4,
    "published": (0.3284573768, 0.9445187937, 1.423050003, -0.4948670827),
}

# Slider-crank under a constant torque of 0.1 N m, from rest, stretched; no gravity. Model and MATLAB reference of
# Exudyn's tests (J. Gerstmayr, sliderCrankFloatingTest.py, slidercrankRefSolM0.1_tol1e-6.txt); uniform crank and rod.
SLIDER_CRANK = {
    "crank": 0.1,
    "rod": 0.3,
    "crank_mass": 0.2,
    "rod_mass": 0.2,
    "slider_mass": 0.4,
    "torque": 0.1,
    "time": 1.0,
    # crank angle (rad), its rate (rad/s), place of the slider (m) at 1 s: DOP853 at 1e-13, which Radau at 1e-11 meets
    # to 3.7e-8
    "own": (14.1278922177503, 20.5374828514107, 0.283771692112295),
    # crank angle and rate at 3 s by ode45 at 1e-6, which by then is 5.7e-3 rad off
    "published_time": 3.0,
    "published": (121.89082, 101.69399),
}

# Simple pendulum, case A01 of the same library: 1 kg on a massless bar of 1 m, from rest at (-1 m, 0), g = 9.81 m/s2
# along -y. sin(phi / 2) = sin(45 deg) sn(K - sqrt(g / L) t | m = 0.5), phi the angle from the downward vertical on the
# side of -x, K = K(m = 0.5); period 4 K sqrt(L / g).
PENDULUM = {
    "length": 1.0,
    "mass": 1.0,
    "gravity": 9.81,
    "start": (-1.0, 0.0),
    "modulus_squared": 0.5,
    "period": 2.3678419475762373,
    "own_time": 10.0,
    "own": (-0.275087462577133, -0.961419205098834),
    # time (s): x (m), y (m) from the official file of 4001 points, printed to six decimals; the closed form meets all
    # of them to 7.1e-7 m
    "published": {0.5: (-0.391049, -0.92037), 1.0: (0.986292, -0.165011), 2000.0: (0.814603, -0.580019)},
}

# The governor PORTER_OPEN from one start on two spindles: one at constant speed, one free. Lagrange's
# equations by Taylor series, as for PORTER_OPEN_MOTION, with g = 9.81 m/s2; angular_momentum is
# (J0 + 2 M x^2) omega at the start, x the balls' distance from the axis. Numbers named cartesian are of a redundant
# model of points in space, the torque read from its multiplier, in as many digits as it is sure of.
PORTER_IN_SPACE = {
    "dimensions": PORTER_OPEN["dimensions"],
    "spindle_inertia": PORTER_OPEN["rest_inertia"],
    "gravity": 9.81,
    "start": {name: PORTER_OPEN_MOTION[name] for name in ("arm_angle", "arm_rate", "spindle_speed")},
    "angular_momentum": 14.9962433346011,
    "time": PORTER_OPEN_MOTION["time"],
    "constant_speed": PORTER_OPEN_MOTION["constant_speed"],
    "free_spindle": PORTER_OPEN_MOTION["free_spindle"],
    "cartesian_drive_torque": 2.041506201,
    "cartesian_free_arm_angle": 0.724794206368,
}
