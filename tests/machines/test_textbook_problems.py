"""Every problem of the textbook list is answered by statics, kinematics, a run or a design, to its printed digits.

Where the printed answer is rounded early or read off a drawing, the recomputed one counts, and the list says so.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import flywheel
from reference.textbook_problems import PROBLEMS, Problem
from scene_documents import governor_document

RPM = math.pi / 30
INCH, FOOT, POUND = 0.0254, 0.3048, 0.45359237
EXACT = 1e-9
"""Relative difference of two exact results; the assembly leaves some 1e-12, differences of neighbouring numbers lose two digits."""
GRAPHICAL = 0.05
"""Largest relative error of an answer that is read off a drawing."""

Answers = Mapping[str, float]


# Governors.


def ends_of(scene: gm.Scene, radii: Sequence[float], **options: Any) -> Any:
    """The working range between two radii of the balls, inner end first."""
    working = gm.controlling_force(scene, points=5, between={"ball_radius": sorted(radii)}, **options).working_range
    assert working is not None
    return working


def governor(machine: str, dimensions: Mapping[str, Any]) -> gm.Scene:
    """A governor at a position whose speed does not matter here."""
    tables = {"spindle": {"speed": "100 rpm"}, "start": {"arm_angle": "40 deg"}, "run": {"duration": "1 s"}}
    return gm.Scene.from_dict(governor_document(dimensions, machine=machine, **tables))


def porter(arm: float, ball_mass: float, sleeve_mass: float, **more: float) -> gm.Scene:
    return governor("pendulum_governor", {"arm": arm, "ball_mass": ball_mass, "sleeve_mass": sleeve_mass, **more})


def answer_gov01(data: Mapping[str, Any]) -> Answers:
    scene = porter(data["arm_mm"] / 1e3, data["ball_kg"], data["sleeve_kg"])
    ends = ends_of(scene, (data["r_min_mm"] / 1e3, data["r_max_mm"] / 1e3), resistance=data["friction_N"])
    low, high = ends.speed / RPM
    return {
        "N1 no friction": low,
        "N2 no friction": high,
        "range": high - low,
        "N1 with friction (falling)": ends.falling_speed[0] / RPM,
        "N2 with friction (rising)": ends.rising_speed[1] / RPM,
    }


def answer_gov02(data: Mapping[str, Any]) -> Answers:
    scene, low = governor("pendulum_governor", {"arm": data["arm_m"], "ball_mass": 1.0}), math.radians(data["angle_deg"])
    high = math.acos(math.cos(low) - data["sleeve_rise_m"] / data["arm_m"])  # the height of the cone falls by the rise
    speeds = gm.controlling_force(scene, over=[low, high]).speed
    return {"speed increase %": 100 * (speeds[1] / speeds[0] - 1)}


def answer_gov03(data: Mapping[str, Any]) -> Answers:
    ends = ends_of(porter(data["arm_m"], data["ball_kg"], data["sleeve_kg"]), (data["r_min"], data["r_max"]))
    return {"N_max": ends.speed[1] / RPM, "N_min": ends.speed[0] / RPM, "range": ends.range_of_speed / RPM}


def answer_gov04(data: Mapping[str, Any]) -> Answers:
    scene = porter(data["arm_m"], data["ball_kg"], data["sleeve_kg"], lug_offset=data["lower_offset_m"])
    ends = ends_of(scene, (data["r2"], data["r1"]))
    return {"N_max": ends.speed[1] / RPM, "N_min": ends.speed[0] / RPM, "range": ends.range_of_speed / RPM}


def answer_gov06(data: Mapping[str, Any]) -> Answers:
    """The squares of rising and falling speed are linear in the friction, so that two evaluations give the one where they meet."""
    scene, low = porter(data["arm_m"], data["ball_kg"], data["sleeve_kg"]), math.radians(data["angle_deg"])
    high = math.acos(math.cos(low) - data["lift_m"] / (2 * data["arm_m"]))

    def ends(friction: float) -> Any:
        return gm.controlling_force(scene, points=5, between={"arm_angle": (low, high)}, resistance=friction).working_range

    def excess(friction: float) -> float:
        return float(ends(friction).rising_speed[0] ** 2 - ends(friction).falling_speed[1] ** 2)

    first, second = excess(5.0), excess(10.0)
    friction = 5.0 - 5.0 * first / (second - first)
    return {"friction at sleeve": friction, "range of speed": ends(friction).range_of_speed_with_resistance / RPM}


def answer_gov15(data: Mapping[str, Any]) -> Answers:
    ends = ends_of(porter(data["arm_mm"] / 1e3, data["ball_kg"], data["sleeve_kg"]), [radius / 1e3 for radius in data["r"]])
    return {"N1": ends.speed[0] / RPM, "N2": ends.speed[1] / RPM, "range": ends.range_of_speed / RPM}


def answer_gov16(data: Mapping[str, Any]) -> Answers:
    scene = porter(data["arm_mm"] / 1e3, data["ball_kg"], data["sleeve_kg"], lug_offset=data["lower_offset_mm"] / 1e3)
    ends = ends_of(scene, [radius / 1e3 for radius in data["r"]])
    return {"N1": ends.speed[0] / RPM, "N2": ends.speed[1] / RPM, "range": ends.range_of_speed / RPM}


def proell_speed(arm: float, extension: float, radius: float, ball_mass: float, sleeve_mass: float) -> float:
    """The speed (rpm) where the extensions are upright."""
    dimensions = {"arm": arm, "extension": extension, "upright_radius": radius, "ball_mass": ball_mass, "sleeve_mass": sleeve_mass}
    scene = governor("proell", dimensions)
    found = gm.controlling_force(scene, over=[math.asin(radius / arm)])
    assert found.radius[0] == pytest.approx(radius, rel=EXACT)
    return float(found.speed[0]) / RPM


def answer_gov12(data: Mapping[str, Any]) -> Answers:
    return {"N": proell_speed(data["arm"], data["ext"], data["r"], data["ball_kg"], data["sleeve_kg"])}


def answer_gov18(data: Mapping[str, Any]) -> Answers:
    """The book takes the extensions as upright at both radii: two governors."""
    lengths = [data["arm_mm"] / 1e3, data["ext_mm"] / 1e3]
    low, high = (proell_speed(*lengths, radius / 1e3, data["ball_kg"], data["sleeve_kg"]) for radius in data["r"])
    return {"N1": low, "N2": high}


def design_weightless(**inputs: Any) -> gm.HartnellDesign:
    """A Hartnell governor as the books take it; its simulated speeds at the ends of the lift are then the given ones."""
    design = gm.design_hartnell(gravity=0, **inputs)
    ends = gm.controlling_force(design.scene, points=5).working_range
    np.testing.assert_allclose(ends.speed, [design.inputs.lowest_speed, design.inputs.highest_speed], rtol=EXACT)
    np.testing.assert_allclose(design.exact.forces, design.textbook.forces, rtol=EXACT)  # the obliquity cancels
    return design


def speed_at_radius(design: gm.HartnellDesign, radius: float) -> float:
    """The simulated speed (rpm) with the balls at a radius (m)."""
    angle = math.asin((radius - design.inputs.pivot_radius) / design.inputs.ball_arm)
    return float(gm.controlling_force(design.scene, over=[angle]).speed[0]) / RPM


def answer_gov08(data: Mapping[str, Any]) -> Answers:
    radii = {"inner_radius": data["r2_in"] * INCH, "outer_radius": data["r1_in"] * INCH, "pivot_radius": 3.75 * INCH}
    speeds = {"lowest_speed": data["N2"] * RPM, "highest_speed": data["N1_over_N2"] * data["N2"] * RPM}
    arms = {"ball_arm": 4 * INCH, "sleeve_arm": 3 * INCH}  # of any length: the law is linear
    design = design_weightless(ball_mass=data["ball_lb"] * POUND, **radii, **speeds, **arms)
    return {"N at r=3.5 in": speed_at_radius(design, data["r_in"] * INCH)}


def answer_gov11(data: Mapping[str, Any]) -> Answers:
    design = design_weightless(
        ball_mass=data["ball_kg"],
        inner_radius=data["r2"],
        ball_arm=data["vertical_arm"],
        sleeve_arm=data["horizontal_arm"],
        lift=data["lift"],
        lowest_speed=data["N2"] * RPM,
        highest_speed=(1 + data["dN_pct"] / 100) * data["N2"] * RPM,
    )
    return {"initial compressive force (pi=3.147)": design.textbook.forces[0], "stiffness (pi=3.147)": design.textbook.rate / 1e3}


def answer_gov19(data: Mapping[str, Any]) -> Answers:
    design = design_weightless(
        ball_mass=data["ball_kg"],
        ball_arm=data["ball_arm_mm"] / 1e3,
        sleeve_arm=data["sleeve_arm_mm"] / 1e3,
        inner_radius=data["r2_mm"] / 1e3,
        lift=data["lift_mm"] / 1e3,
        lowest_speed=data["N"][0] * RPM,
        highest_speed=data["N"][1] * RPM,
    )
    spring = design.textbook
    return {"S at lowest": spring.forces[0], "S at highest": spring.forces[1], "stiffness": spring.rate / 1e3}


def answer_gov20(data: Mapping[str, Any]) -> Answers:
    low, high = (radius / 1e3 for radius in data["r"])
    speeds = {"lowest_speed": data["N"][0] * RPM, "highest_speed": data["N"][1] * RPM}
    arms = {"ball_arm": 0.09, "sleeve_arm": 0.09, "pivot_radius": 0.1}  # equal arms of any length
    design = design_weightless(ball_mass=data["ball_kg"], inner_radius=low, outer_radius=high, **arms, **speeds)
    return {"stiffness": design.textbook.rate / 1e3, "initial compression": 1e3 * design.textbook.compression}


def answer_gov21(data: Mapping[str, Any]) -> Answers:
    low, high = (radius / 1e3 for radius in data["r"])
    design = design_weightless(
        ball_mass=data["ball_kg"],
        ball_arm=data["ball_arm_mm"] / 1e3,
        sleeve_arm=data["sleeve_arm_mm"] / 1e3,
        inner_radius=low,
        outer_radius=high,
        lowest_speed=data["N2"] * RPM,
        highest_speed=data["N1"] * RPM,
    )
    return {"initial compression": 1e3 * design.textbook.compression, "N at r=100 mm": speed_at_radius(design, data["r_query"] / 1e3)}


# Slider cranks.


def slider_crank(crank: float, rod: float, point: float) -> gm.Scene:
    """A slider crank whose rod has its mass centre at a distance from the crank pin, so that its pose is that of this point."""
    masses = {"crank": 1.0, "rod": 1.0, "rod_centre": point, "crosshead": 1.0}
    dimensions = {"crank": crank, "connecting_rod": rod, "crank_speed": 1.0}
    return gm.Scene.from_dict({"machine": "slider_crank", "dimensions": dimensions, "effects": {"masses": masses}})


class RodMotion:
    """Motion of a rod, of a point of it and of the piston at one crank angle (deg) and speed (rad/s)."""

    def __init__(self, lengths: tuple[float, float, float], angle: float, speed: float, acceleration: float = 0.0) -> None:
        scene = slider_crank(*lengths)
        values = [math.radians(angle)]
        motion = gm.kinematics(scene, over="crank_angle", values=values, rate=speed, acceleration=acceleration)
        rod, crosshead = (scene.part.mechanism.body_index(name) for name in ("connecting rod", "crosshead"))
        self.velocity, self.acceleration = motion.velocities[0, rod, :2], motion.accelerations[0, rod, :2]
        self.angular_velocity, self.angular_acceleration = abs(motion.velocities[0, rod, 2]), abs(motion.accelerations[0, rod, 2])
        self.piston_velocity = float(motion.velocities[0, crosshead, 0])
        self.piston_acceleration = float(motion.accelerations[0, crosshead, 0])
        self.rod_angle = float(motion.readings["rod_angle"][0])


def answer_sc01(data: Mapping[str, Any]) -> Answers:
    motion = RodMotion((data["r"], data["l"], data["l"] / 2), data["theta_deg"], data["N"] * RPM)
    return {
        "v_D": math.hypot(*motion.velocity),
        "a_D": math.hypot(*motion.acceleration),
        "omega_rod": motion.angular_velocity,
        "alpha_rod": motion.angular_acceleration,
    }


def answer_sc02(data: Mapping[str, Any]) -> Answers:
    motion = RodMotion((data["r"], data["l"], 0.15), data["theta_deg"], data["N"] * RPM)
    return {
        "v_P Klein": abs(motion.piston_velocity),
        "a_P Klein": abs(motion.piston_acceleration),
        "v_D Klein": math.hypot(*motion.velocity),
        "a_D Klein": math.hypot(*motion.acceleration),
        "omega_rod Klein": motion.angular_velocity,
        "alpha_rod Klein": motion.angular_acceleration,
        "a_P approx formula": abs(motion.piston_acceleration),
    }


def answer_sc03(data: Mapping[str, Any]) -> Answers:
    lengths = data["r_in"] * INCH, data["l_in"] * INCH
    motion = RodMotion((*lengths, lengths[1] / 2), data["theta_deg"], data["N"] * RPM)
    return {"piston velocity (graphical)": abs(motion.piston_velocity) / FOOT}


def answer_sc04(data: Mapping[str, Any]) -> Answers:
    crank, speed, angle = data["r_in"] * INCH, data["N"] * RPM, data["theta_deg"]
    lengths = crank, data["l_in"] * INCH, data["X_from_crankpin_in"] * INCH
    uniform, accelerated = RodMotion(lengths, angle, speed), RodMotion(lengths, angle, speed, data["case_b_crank_acc"])
    pin = -crank * speed**2 * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    relative = np.array([uniform.piston_acceleration, 0.0]) - pin
    return {
        "|a_P - a_C| case a": math.hypot(*relative) / FOOT,
        "a_P case a (absolute)": abs(uniform.piston_acceleration) / FOOT,
        "a_X case a": math.hypot(*uniform.acceleration) / FOOT,
        "alpha_rod case a": uniform.angular_acceleration,
        "a_X case b (acc)": math.hypot(*accelerated.acceleration) / FOOT,
        "alpha_rod case b (acc)": accelerated.angular_acceleration,
    }


def answer_sc05(data: Mapping[str, Any]) -> Answers:
    """The largest velocity is where the acceleration changes its sign; between samples 0.1 deg apart it is linear to 1e-6."""
    scene, angles = slider_crank(data["r"], data["l"], data["l"] / 2), np.radians(np.linspace(70.0, 80.0, 101))
    motion = gm.kinematics(scene, over="crank_angle", values=angles, rate=data["N"] * RPM)
    angle = float(np.interp(0.0, motion.reading_accelerations["crosshead_distance"], angles))
    (speed,) = gm.kinematics(scene, over="crank_angle", values=[angle], rate=data["N"] * RPM).rates["crosshead_distance"]
    return {"theta at max v": math.degrees(angle), "v max": abs(speed), "v max EXACT kinematics": abs(speed)}


def answer_sc06(data: Mapping[str, Any]) -> Answers:
    """The piston carries the pressure less its inertia force; by virtual work of it at the crank."""
    motion = RodMotion((data["r"], data["l"], data["l"] / 2), data["theta_deg"], data["N"] * RPM)
    gas = data["dp_Nmm2"] * 1e6 * math.pi / 4 * data["bore"] ** 2
    force = gas - data["mR"] * abs(motion.piston_acceleration)
    torque = force * abs(motion.piston_velocity) / (data["N"] * RPM) / 1e3
    rod_angle = abs(motion.rod_angle)
    return {
        "F_N": force * math.tan(rod_angle) / 1e3,
        "F_Q": force / math.cos(rod_angle) / 1e3,
        "T": torque,
        "T with EXACT acceleration": torque,
    }


def answer_sc07(data: Mapping[str, Any]) -> Answers:
    lengths = data["stroke_in"] / 2 * INCH, data["l_in"] * INCH, data["l_in"] / 2 * INCH
    bore, rod = (math.pi / 4 * data[name] ** 2 for name in ("bore_in", "rod_in"))
    force = data["p1"] * bore - data["p2"] * (bore - rod)  # pounds, on both faces
    torque = force * abs(RodMotion(lengths, data["theta_deg"], 1.0).piston_velocity) / FOOT
    return {"T (approx)": torque, "T EXACT": torque}


# Four-bar linkages.


def four_bar(lengths: Sequence[float], angle: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and accelerations of crank, coupler and rocker, open, at a crank angle (deg); lengths with the frame last."""
    m = gm.Mechanism.build("Four-bar")
    crank = m.rod("crank", length=lengths[0], mass=1.0, angle=math.radians(angle))
    coupler, rocker = m.rod("coupler", length=lengths[1], mass=1.0), m.rod("rocker", length=lengths[2], mass=1.0)
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, coupler.start)
    m.pin(coupler.end, rocker.end)
    m.pin(m.ground(lengths[3], 0), rocker.start)
    m.motor(crank, rate=speed)
    motion = gm.kinematics(m.scene(), over="time", values=[0.0])
    return np.abs(motion.velocities[0, :, 2]), np.abs(motion.accelerations[0, :, 2])


def answer_fb01(data: Mapping[str, Any]) -> Answers:
    lengths = [data[name] * INCH for name in ("AB", "BC", "CD", "DA")]
    rates, accelerations = four_bar(lengths, data["angle_BAD_deg"], data["N"] * RPM)
    return {"alpha_CD": accelerations[2], "alpha_BC": accelerations[1], "v_C": rates[2] * lengths[2] / FOOT}


def answer_fb02(data: Mapping[str, Any]) -> Answers:
    lengths = [data[name] / 1e3 for name in ("PQ", "QR", "RS", "PS")]
    rates, accelerations = four_bar(lengths, data["angle_QPS_deg"], data["omega"])
    return {"omega_QR": rates[1], "omega_RS": rates[2], "alpha_QR": accelerations[1], "alpha_RS": accelerations[2]}


# Flywheels and valve events.


def turning_wheel(inertia: float, speed: float, mean: float, harmonics: Sequence[Sequence[float]]) -> gm.Trajectory:
    """A turn of a flywheel under a mean torque with harmonics [n, cos, sin] of its angle, and a constant load."""
    sines = [{"order": n, "amplitude": math.hypot(cos, sin), "phase": math.atan2(cos, sin)} for n, cos, sin in harmonics]
    moment = [{"reading": "angle", "harmonics": sines}, mean, -mean]
    period = math.tau / speed
    scene = gm.Scene.from_dict(
        {
            "machine": "custom",
            "size": 1.0,
            "ground": {"shaft": [0, 0]},
            "body": [{"name": "wheel", "mass": 1.0, "moments": {"xx": inertia / 2, "yy": inertia / 2}}],
            "joint": [{"type": "pin", "first": "ground.shaft", "second": "wheel.centre"}],
            "force": [{"type": "torque", "name": "engine", "body": "wheel", "moment": moment}],
            "readings": {"angle": {"angle": "wheel"}},
            "start": {"angle": 0.0, "angle_rate": speed},
            "run": {"duration": period, "output_interval": period / 720, "accuracy": 1e-8},
        }
    )
    return gm.run(scene)


def fluctuation(run: gm.Trajectory) -> float:
    """Range of speed over mean speed."""
    speeds = run.rates["angle"]
    return float(np.ptp(speeds) / (0.5 * (speeds.max() + speeds.min())))


def answer_fw02(data: Mapping[str, Any]) -> Answers:
    low, high = flywheel.speed_limits(inertia=data["m"] * data["k"] ** 2, energy=float(data["dE"]), mean_speed=data["N"] * RPM)
    return {"N max": float(high) / RPM, "N min": float(low) / RPM}


def answer_fw03(data: Mapping[str, Any]) -> Answers:
    speed = data["N"] * RPM
    energy = float(flywheel.harmonic_energy(amplitude=math.hypot(9500.0, 5700.0), order=2.0))
    inertia = float(flywheel.inertia_for_coefficient(energy=energy, mean_speed=speed, coefficient=data["Cs"]))
    run = turning_wheel(inertia, speed, 20000.0, [[2, -5700.0, 9500.0]])
    # The rule holds for the mean of lowest and highest speed; that of the start differs from it by Cs / 2 at most.
    assert fluctuation(run) == pytest.approx(data["Cs"], rel=data["Cs"])
    angles, rates = run.readings["angle"], run.rates["angle"]
    slopes = np.gradient(rates, run.times)
    # central differences over half a degree: (2 h)^2 / 6 of the second harmonic is 5e-5
    assert np.interp(math.pi / 4, angles, slopes) == pytest.approx(9500.0 / inertia, rel=1e-4)
    return {"power": 20000.0 * speed / 1e3, "dE": energy, "I": inertia, "alpha at 45 deg": 9500.0 / inertia}


def answer_fw04(data: Mapping[str, Any]) -> Answers:
    speed = data["N"] * RPM
    energy = float(flywheel.harmonic_energy(amplitude=1500.0, order=3.0))
    low, high = flywheel.speed_limits(inertia=float(data["I"]), energy=energy, mean_speed=speed)
    coefficient = float(high - low) / speed
    run = turning_wheel(data["I"], speed, 5000.0, [[3, 0.0, 1500.0]])
    assert fluctuation(run) == pytest.approx(coefficient, rel=coefficient)  # the mean speed differs by half of it
    return {"power": 5000.0 * speed / 1e3, "dE": energy, "C_s (constant load)": 100 * coefficient}


def answer_fw05(data: Mapping[str, Any]) -> Answers:
    work = float(data["P"] - data["E_per_press_1s"])  # in the second of a stroke
    speed = flywheel.speed_after_work(inertia=float(data["I"]), start_speed=data["N1"] * RPM, work=work)
    return {"speed drop": data["N1"] - float(speed) / RPM}


def answer_fw06(data: Mapping[str, Any]) -> Answers:
    """A four-stroke engine with triangular torques of expansion and compression; a triangle of work W has a height of 2 W / pi."""
    work = data["ihp"] * 33000 / (data["N"] / 2)  # ft lbf in a cycle
    compression = work / (data["ratio"] - 1)
    corners = math.pi * np.array([0, 1, 1.5, 2, 2.5, 3, 4])
    torques = 2 / math.pi * np.array([0, 0, -compression, 0, data["ratio"] * compression, 0, 0])
    energy = flywheel.table_energy(angles=corners, torques=torques)
    inertia = flywheel.inertia_for_coefficient(energy=energy, mean_speed=data["N"] * RPM, coefficient=data["Ks"])
    return {"moment of inertia": 32.2 * float(inertia)}  # the book's gravity, ft/s2


def answer_vg01(data: Mapping[str, Any]) -> Answers:
    """Angles of the crank end from its dead centre; the printed admission is that before it."""
    dimensions = {
        "crank": 1.0,
        "crank_speed": 1.0,
        "eccentric": data["eccentricity_in"] * INCH,
        "outside_lap": data["steam_lap_in"] * INCH,
        "inside_lap": data["exhaust_lap_in"] * INCH,
        "advance": math.radians(data["angle_of_advance_deg"]),
    }
    timing = gm.valve_timing(gm.Scene.from_dict({"machine": "slide_valve", "dimensions": dimensions}))
    angles = {event.name: math.degrees(event.simulated) for event in timing.rows}
    found = {name: angles[f"crank end {name}"] for name in ("admission", "cut-off", "release", "compression")}
    return found | {"admission": found["admission"] - 360.0}


ANSWERS = {name.removeprefix("answer_"): function for name, function in globals().items() if name.startswith("answer_")}
"""By the number with which the name of a problem begins, as gov01."""


def test_every_problem_has_an_answer():
    assert sorted(ANSWERS) == sorted(name.partition("_")[0] for name in PROBLEMS)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_answers_are_those_of_the_book(name):
    problem: Problem = PROBLEMS[name]
    found = ANSWERS[name.partition("_")[0]](problem.data)
    assert found.keys() == problem.answers.keys()
    for quantity, answer in problem.answers.items():
        # What the book's formula neglects, if anything, is stated; else both are exact.
        assert found[quantity] == pytest.approx(answer.recomputed, rel=max(EXACT, answer.neglected)), quantity
        if answer.printed and not answer.remark:
            assert abs(found[quantity] - float(answer.printed)) <= answer.half_digit, quantity
        elif answer.printed:  # the remark explains the difference
            assert found[quantity] == pytest.approx(float(answer.printed), rel=GRAPHICAL), quantity


def test_a_wrong_pi_explains_sarkars_hartnell_governor():
    """Its printed force and stiffness, 557.8 N and 24.1 N/mm, are those with pi = 3.147: squares of the speed are larger by its ratio."""
    for answer in PROBLEMS["gov11_hartnell_sarkar7.8"].answers.values():
        assert answer.recomputed * (3.147 / math.pi) ** 2 == pytest.approx(float(answer.printed), abs=answer.half_digit)


@pytest.mark.parametrize(("speed", "radius"), [("240 rpm", 0.125), ("250 rpm", 0.175)])
def test_wilson_and_hartnells_governor_balances_at_the_radii_of_the_problem(speed, radius):
    """Balls of 2 kg, arms of 150 and 100 mm, 0.2 kN/m between the balls: the textbook formula gives 5.58 kN/m at the sleeve."""
    angular_speeds = [240 * math.pi / 30, 250 * math.pi / 30]
    first, second = (
        2 * (2.0 * w**2 * r - 200.0 * (2 * r - 0.2)) * 0.15 / 0.1 for w, r in zip(angular_speeds, (0.125, 0.175), strict=True)
    )  # S = 2 (F_c - P) x / y
    assert (second - first) / (0.05 * 0.1 / 0.15) == pytest.approx(5580, rel=1e-3)
    (equilibrium,) = gm.equilibria(gm.load("wilson_hartnell").replace({"spindle.speed": speed}))
    assert equilibrium.stable
    assert equilibrium.readings["ball_radius"] == pytest.approx(radius, rel=1e-3)  # 5.58 is rounded
