"""Solved problems of textbooks: governors, slider cranks, four-bar linkages, flywheels and valve events.

Each has its data in the units of the book, the printed answers, and these recomputed with the book's own assumptions to full precision.
`remark` says in one phrase why a printed answer is not the recomputed one to its last digit, or what the book's formula neglects;
`neglected` is then the largest relative difference of the exact mechanism from that formula. Gravity is 9.81 m/s2 throughout.

Most printed answers are from the companion notebooks of the FOSSEE project (Python-Textbook-Companions, commit d34b2ae) to B. K. Sarkar,
Theory of Machines; Th. Bevan, The Theory of Machines; R. S. Khurmi and J. K. Gupta, Theory of Machines. Those
marked `from_memory` are quoted from the books without a copy at hand.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any


@dataclass(frozen=True)
class Answer:
    """An answer as it is printed (empty if none is), recomputed, in a unit."""

    printed: str
    recomputed: float
    unit: str
    remark: str = ""
    neglected: float = 0.0

    @property
    def half_digit(self) -> float:
        """Half a unit of the last printed digit."""
        exponent = Decimal(self.printed).as_tuple().exponent
        assert isinstance(exponent, int)
        return 0.5 * 10.0**exponent


@dataclass(frozen=True)
class Problem:
    """A problem with its source, data and answers."""

    kind: str
    source: str
    data: Mapping[str, Any]
    answers: Mapping[str, Answer]
    from_memory: bool = False


def read_off(printed: str, recomputed: float, unit: str, percent: float) -> Answer:
    """An answer that the book reads off a drawing, wrong by some per cent."""
    return Answer(printed, recomputed, unit, f"read off a drawing of the velocities and accelerations, {percent} % off")


CUT_FORMULA = "the book's formula cuts off the series of the rod after the second harmonic"
CUT_ACCELERATION = "the book's formula of the acceleration cuts off the series of the rod after the second harmonic"

PROBLEMS: Mapping[str, Problem] = {
    "gov01_porter_khurmi18.3": Problem(
        kind="Porter",
        source="scribd.com/document/702193907 (=Khurmi ex.18.3) ; expertsmind.com/topic/governors/estimate-speed-range-99014.aspx",
        data={"arm_mm": 250, "ball_kg": 5, "sleeve_kg": 30, "r_min_mm": 150, "r_max_mm": 200, "friction_N": 20},
        answers={
            "N1 no friction": Answer("176.9", 176.9456570906362, "rpm"),
            "N2 no friction": Answer("204.32", 204.31924550642808, "rpm"),
            "range": Answer("27.42", 27.373588415791886, "rpm", remark="printed as the difference of the exact 204.32 and a rounded 176.9"),
            "N1 with friction (falling)": Answer("172", 171.7148341223755, "rpm"),
            "N2 with friction (rising)": Answer("210", 210.18578089807156, "rpm"),
        },
    ),
    "gov02_watt_sarkar7.1": Problem(
        kind="Watt",
        source="Sarkar ch. 7 Ex1 p.196",
        data={"arm_m": 0.4, "angle_deg": 30, "sleeve_rise_m": 0.02, "rise_meaning": "governor height drops by 0.02 m"},
        answers={"speed increase %": Answer("3", 3.018085900478118, "%")},
    ),
    "gov03_porter_sarkar7.2": Problem(
        kind="Porter",
        source="Sarkar Ex2 p.197",
        data={"arm_m": 0.3, "ball_kg": 6, "sleeve_kg": 18, "r_min": 0.2, "r_max": 0.25},
        answers={
            "N_max": Answer("146.9", 146.89354367518698, "rpm"),
            "N_min": Answer("126.5", 126.5008315355888, "rpm"),
            "range": Answer("20.4", 20.392712139598174, "rpm"),
        },
    ),
    "gov04_porter_offset_sarkar7.3": Problem(
        kind="Porter, lower arms offset",
        source="Sarkar Ex3 p.197",
        data={"arm_m": 0.25, "lower_offset_m": 0.03, "ball_kg": 6, "sleeve_kg": 48, "r1": 0.2, "r2": 0.15},
        answers={
            "N_max": Answer("215.5", 215.4336945281915, "rpm", remark="rounded intermediate results"),
            "N_min": Answer("188.2", 188.19267601557672, "rpm"),
            "range": Answer("27.2", 27.241018512614772, "rpm"),
        },
    ),
    "gov06_porter_friction_sarkar7.6": Problem(
        kind="Porter",
        source="Sarkar Ex6 p.202",
        data={
            "arm_m": 0.3,
            "ball_kg": 5,
            "sleeve_kg": 25,
            "lift_m": 0.05,
            "angle_deg": 30,
            "condition": "friction such that rising speed at lowest sleeve = falling speed at highest sleeve",
        },
        answers={"friction at sleeve": Answer("14.9", 14.875198682158345, "N"), "range of speed": Answer("14.9", 14.91147937149853, "rpm")},
    ),
    "gov08_spring_bevan13.3": Problem(
        kind="spring-controlled (linear controlling force)",
        source="Bevan ch13 Ex3 p.466",
        data={"ball_lb": 3, "N2": 300, "r2_in": 3, "N1_over_N2": 1.06, "r1_in": 4.5, "r_in": 3.5},
        answers={"N at r=3.5 in": Answer("308", 307.8431882816779, "rpm")},
    ),
    "gov11_hartnell_sarkar7.8": Problem(
        kind="Hartnell",
        source="Sarkar Ex8 p.204 (also Anna Univ. question bank, coursehero p6rd1mq)",
        data={"ball_kg": 3, "r2": 0.2, "vertical_arm": 0.11, "horizontal_arm": 0.15, "lift": 0.004, "N2": 240, "dN_pct": 7.5},
        answers={
            "initial compressive force (pi=3.147)": Answer("557.8", 555.8561198693527, "N", remark="computed with pi = 3.147"),
            "stiffness (pi=3.147)": Answer("24.1", 23.981601668255056, "N/mm", remark="computed with pi = 3.147"),
        },
    ),
    "gov12_proell_sarkar7.10": Problem(
        kind="Proell",
        source="Sarkar Ex10 p.206",
        data={"arm": 0.25, "ext": 0.1, "r": 0.15, "ball_kg": 5, "sleeve_kg": 40, "ext_vertical": True},
        answers={"N": Answer("163.9", 163.81984590197249, "rpm", remark="rounded intermediate results")},
    ),
    "gov15_porter_khurmi18.2": Problem(
        kind="Porter",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.2",
        data={"arm_mm": 250, "ball_kg": 5, "sleeve_kg": 25, "r": [150, 200]},
        answers={
            "N1": Answer("164", 163.81984590197249, "rpm"),
            "N2": Answer("189", 189.1628642602137, "rpm"),
            "range": Answer("25", 25.34301835824121, "rpm"),
        },
        from_memory=True,
    ),
    "gov16_porter_khurmi18.5": Problem(
        kind="Porter, lower arms offset",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.5",
        data={"arm_mm": 250, "lower_offset_mm": 30, "ball_kg": 5, "sleeve_kg": 50, "r": [150, 200]},
        answers={
            "N1": Answer("208", 207.73155325902476, "rpm"),
            "N2": Answer("238", 237.7470393197057, "rpm"),
            "range": Answer("30", 30.015486060680928, "rpm"),
        },
        from_memory=True,
    ),
    "gov18_proell_khurmi18.9": Problem(
        kind="Proell",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.9",
        data={
            "arm_mm": 300,
            "ext_mm": 80,
            "ball_kg": 10,
            "sleeve_kg": 100,
            "r": [150, 200],
            "note": "extension vertical in both positions (as stated)",
        },
        answers={"N1": Answer("170", 170.17104696846596, "rpm"), "N2": Answer("180", 180.03066376216503, "rpm")},
        from_memory=True,
    ),
    "gov19_hartnell_khurmi18.13": Problem(
        kind="Hartnell",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.13 (question text also coursehero p6rd1mq)",
        data={"ball_kg": 2.5, "ball_arm_mm": 120, "sleeve_arm_mm": 80, "r2_mm": 120, "N": [290, 310], "lift_mm": 15},
        answers={
            "S at lowest": Answer("831", 830.0337301316148, "N", remark="computed with a centrifugal force rounded to 277 N"),
            "S at highest": Answer("1128", 1126.3069172468158, "N", remark="computed with a centrifugal force rounded to 376 N"),
            "stiffness": Answer("19.8", 19.75154580768007, "N/mm"),
        },
        from_memory=True,
    ),
    "gov20_hartnell_khurmi18.14": Problem(
        kind="Hartnell",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.14",
        data={"ball_kg": 2, "arms": "equal", "r": [80, 120], "N": [400, 420]},
        answers={"stiffness": Answer("9.2", 9.176538847590644, "N/mm"), "initial compression": Answer("61", 61.185468451242784, "mm")},
        from_memory=True,
    ),
    "gov21_hartnell_khurmi18.16": Problem(
        kind="Hartnell",
        source="R.S. Khurmi & J.K. Gupta, Theory of Machines, ch.18 ex.18.16 (printed values not recalled)",
        data={"ball_kg": 1, "ball_arm_mm": 100, "sleeve_arm_mm": 50, "r": [75, 112.5], "N2": 360, "N1": 378, "r_query": 100},
        answers={"initial compression": Answer("", 28.680688336520102, "mm"), "N at r=100 mm": Answer("", 373.5813164493107, "rpm")},
        from_memory=True,
    ),
    "sc01_khurmi8.1": Problem(
        kind="slider-crank kinematics (graphical answers)",
        source="Khurmi ch8 Ex8.1 p.177",
        data={"r": 0.15, "l": 0.6, "N": 300, "theta_deg": 45, "point": "mid rod"},
        answers={
            "v_D": read_off("4.1", 3.9953581078742952, "m/s", 2.6),
            "a_D": Answer("117", 117.31042577013004, "m/s2"),
            "omega_rod": read_off("5.67", 5.64246697393092, "rad/s", 0.5),
            "alpha_rod": read_off("171.67", 171.54515606539746, "rad/s2", 0.1),
        },
    ),
    "sc02_khurmi15.2_15.5": Problem(
        kind="slider-crank kinematics",
        source="Khurmi ch15 Ex15.2 p.522 (Klein) and Ex15.5 p.528 (approx. formulae)",
        data={"r": 0.15, "l": 0.6, "N": 450, "theta_deg": 60, "point": "0.15 m from crank pin"},
        answers={
            "v_P Klein": read_off("6.833", 6.905359942835751, "m/s", 1.0),
            "a_P Klein": read_off("124.4", 124.94934388520868, "m/s2", 0.4),
            "v_D Klein": read_off("6.833", 6.851084906402433, "m/s", 0.3),
            "a_D Klein": read_off("266.48", 266.8179720703542, "m/s2", 0.1),
            "omega_rod Klein": read_off("6.126", 6.033595820786168, "rad/s", 1.5),
            "alpha_rod Klein": read_off("481.14", 484.3947067578374, "rad/s2", 0.7),
            "a_P approx formula": Answer(
                "124.91",
                124.91218070128718,
                "m/s2",
                remark="the book's formula cuts off the series of the rod after the second harmonic, (r / l)^3 / 4 = 0.004 in it",
                neglected=0.001,
            ),
        },
    ),
    "sc03_bevan3.3": Problem(
        kind="slider-crank kinematics",
        source="Bevan ch3 Ex3 p.90",
        data={"r_in": 6, "l_in": 24, "N": 240, "theta_deg": 45},
        answers={"piston velocity (graphical)": read_off("10.57", 10.481696540271809, "ft/s", 0.8)},
    ),
    "sc04_bevan3.4": Problem(
        kind="slider-crank accelerations (graphical answers)",
        source="Bevan ch3 Ex4 p.93",
        data={"r_in": 9, "l_in": 36, "N": 240, "theta_deg": 40, "X_from_crankpin_in": 12, "case_b_crank_acc": 100},
        answers={
            "|a_P - a_C| case a": read_off("306", 305.36002005861957, "ft/s2", 0.2),
            "a_P case a (absolute)": Answer("", 385.6101186541389, "ft/s2"),
            "a_X case a": Answer("422", 422.45042859475444, "ft/s2"),
            "alpha_rod case a": read_off("98.7", 98.96964765662062, "rad/s2", 0.3),
            "a_X case b (acc)": read_off("452", 452.81918270763487, "ft/s2", 0.2),
            "alpha_rod case b (acc)": read_off("79.3", 79.56636771449882, "rad/s2", 0.3),
        },
    ),
    "fb01_bevan3.5": Problem(
        kind="four-bar accelerations (graphical answers)",
        source="Bevan ch3 Ex5 p.98",
        data={"AB": 2.5, "BC": 7, "CD": 4.5, "DA": 8, "unit": "in", "N": 100, "angle_BAD_deg": 60},
        answers={
            "alpha_CD": read_off("50.9", 50.60196610189126, "rad/s2", 0.6),
            "alpha_BC": read_off("24.7", 25.6254077973868, "rad/s2", 3.6),
            "v_C": read_off("1.47", 1.4871798315458296, "ft/s", 1.2),
        },
    ),
    "fb02_khurmi8.4": Problem(
        kind="four-bar accelerations (graphical answers)",
        source="Khurmi ch8 Ex8.4 p.184",
        data={"PQ": 62.5, "QR": 175, "RS": 112.5, "PS": 200, "unit": "mm", "omega": 10, "angle_QPS_deg": 60},
        answers={
            "omega_QR": read_off("1.9", 1.9800260174948643, "rad/s", 4.0),
            "omega_RS": Answer("3.79", 3.787072343313456, "rad/s"),
            "alpha_QR": read_off("23.43", 23.367569844139396, "rad/s2", 0.3),
            "alpha_RS": read_off("47.1", 46.14345990065767, "rad/s2", 2.1),
        },
    ),
    "sc05_khurmi15.3": Problem(
        kind="slider-crank max velocity (approx. formula)",
        source="Khurmi ch15 Ex15.3 p.527",
        data={"r": 0.3, "l": 1.0, "N": 200},
        answers={
            "theta at max v": Answer("75", 74.95526782395997, "deg", remark=CUT_FORMULA, neglected=0.02),
            "v max": Answer("6.54", 6.540329857603243, "m/s", remark=CUT_FORMULA, neglected=0.005),
            "v max EXACT kinematics": Answer("", 6.561732156131075, "m/s"),
        },
    ),
    "sc06_khurmi15.7": Problem(
        kind="engine forces (massless rod, approx. acceleration)",
        source="Khurmi ch15 Ex15.7 p.533",
        data={"r": 0.3, "l": 1.2, "bore": 0.5, "mR": 250, "theta_deg": 60, "dp_Nmm2": 0.35, "N": 250},
        answers={
            "F_N": Answer("10.97", 10.965409083949023, "kN", remark=CUT_ACCELERATION, neglected=0.0002),
            "F_Q": Answer("50.65", 50.64705509113869, "kN", remark=CUT_ACCELERATION, neglected=0.0002),
            "T": Answer("14.491", 14.491198774206865, "kNm", remark=CUT_ACCELERATION, neglected=0.0002),
            "T with EXACT acceleration": Answer("", 14.489517985606442, "kNm"),
        },
    ),
    "fw02_khurmi16.1": Problem(
        kind="flywheel speed limits",
        source="Khurmi ch16 Ex16.1 p.573",
        data={"m": 6500, "k": 1.8, "dE": 56000, "N": 120},
        answers={"N max": Answer("121", 121.01032519301476, "rpm"), "N min": Answer("119", 118.98967480698524, "rpm")},
    ),
    "fw03_khurmi16.11": Problem(
        kind="flywheel, T=20000+9500 sin2t-5700 cos2t",
        source="Khurmi ch16 Ex16.11 p.585",
        data={"T": "20000+9500 sin 2t - 5700 cos 2t", "N": 180, "Cs": 0.01},
        answers={
            "power": Answer("377", 376.99111843077515, "kW"),
            "dE": Answer("11078", 11078.80860020607, "Nm", remark="decimals cut off"),
            "I": Answer("3121", 3118.105557554973, "kg m2", remark="rounded intermediate results"),
            "alpha at 45 deg": Answer("3.044", 3.046721743265586, "rad/s2", remark="computed with the inertia of 3121 kg m2"),
        },
    ),
    "fw04_khurmi16.13": Problem(
        kind="flywheel, T=5000+1500 sin 3t",
        source="Khurmi ch16 Ex16.13 p.589",
        data={"T": "5000+1500 sin 3t", "I": 1000, "N": 300},
        answers={
            "power": Answer("157.1", 157.07963267948963, "kW"),
            "dE": Answer("", 1000.0, "Nm"),
            "C_s (constant load)": Answer("0.1", 0.1013211836423378, "%"),
        },
    ),
    "fw05_sarkar6.9": Problem(
        kind="press flywheel",
        source="Sarkar ch6 Ex9 p.182",
        data={"P": 5000, "N1": 360, "I": 60, "E_per_press_1s": 7500},
        answers={"speed drop": Answer("10.7", 10.713711653571117, "rpm")},
    ),
    "fw06_bevan12.10": Problem(
        kind="gas-engine flywheel (triangular torque)",
        source="Bevan ch12 Ex10 p.444",
        data={"ihp": 25, "N": 300, "Ks": 0.02, "ratio": 2.3},
        answers={"moment of inertia": Answer("13710", 13709.760834025916, "lb ft2")},
    ),
    "sc07_bevan12.3": Problem(
        kind="crank torque from piston force",
        source="Bevan ch12 Ex3 p.415",
        data={"bore_in": 9, "rod_in": 2, "stroke_in": 24, "l_in": 60, "theta_deg": 40, "p1": 160, "p2": 32},
        answers={
            "T (approx)": Answer(
                "6110",
                6110.674932304166,
                "lb ft",
                remark="three digits; the book's formula of the velocity cuts off the series of the rod after the second harmonic",
                neglected=0.002,
            ),
            "T EXACT": Answer("", 6117.467822013093, "lb ft"),
        },
    ),
    "vg01_bevan5.1": Problem(
        kind="slide valve events (harmonic valve motion)",
        source="Bevan ch5 Ex1 p.147",
        data={"eccentricity_in": 2.25, "steam_lap_in": 1.125, "exhaust_lap_in": 0.25, "angle_of_advance_deg": 35},
        answers={
            "admission": Answer("-5", -4.9999999999999964, "deg"),
            "cut-off": Answer("115", 115.0, "deg"),
            "release": Answer("151.38", 151.3793702084428, "deg"),
            "compression": Answer("318.62", 318.6206297915572, "deg"),
        },
    ),
}
