"""Kernels against the simulation: laws that agree, planted mistakes that are found with their size, and kernels that misbehave."""

import cmath
import functools
import math
import re

import numpy as np
import pytest
from scipy.optimize import brentq

import governor_mechanism as gm
from crank_scenes import air_engine_document, crank_scene, valve_scene
from governor_mechanism.closed_form import slide_valve
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.closed_form.flywheel_engine import gas_torque as closed_gas_torque
from governor_mechanism.closed_form.flywheel_equilibrium import bracket_terms, energy_fluctuation
from governor_mechanism.files.writing import format_json
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.design.flywheel import compare_with_paper
from governor_mechanism.studies.design.hartung import PRINTED_SPRING_FORCES
from governor_mechanism.verification.user_kernel_comparison import kernel_quantities, list_quantities
from governor_scenes import PORTER, governor_scene
from refusing import refuses

ANGLES = {"arm_angle": "15 deg:45 deg:7"}
KERNEL_ROUNDING = 2e-15
"""Rounding of a kernel of a dozen operations, relative."""

CONICAL = governor_scene({"arm": 0.4, "offset": 0.0, "ball_mass": 2.0}, speed=6.0, angle=0.7)
"""Watt's governor as two conical pendulums: massless links and sleeve."""


def porter():
    return governor_scene(PORTER, speed=13.0, angle=0.7)


def speed(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    load = gravity * (1 + sleeve_mass / ball_mass)
    return math.sqrt(load * math.tan(arm_angle) / (offset + arm * math.sin(arm_angle)))


def loaded_speed(resistance, arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    """Equilibrium speed with a force on the sleeve of a rhombus: it adds to the weight."""
    return speed(arm_angle, arm, offset, ball_mass, sleeve_mass + resistance / gravity, gravity)


def insensitivity(resistance, arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
    low, middle, high = (loaded_speed(sign * resistance, arm_angle, arm, offset, ball_mass, sleeve_mass, gravity) for sign in (-1, 0, 1))
    return (high - low) / middle


def equilibrium(spindle_speed, arm, offset, ball_mass, sleeve_mass, gravity):
    return brentq(lambda angle: speed(angle, arm, offset, ball_mass, sleeve_mass, gravity) - spindle_speed, 0.05, 1.4, xtol=1e-14)


def piston_velocity(crank_angle, rate, crank, connecting_rod):
    swing = np.sqrt(connecting_rod**2 - (crank * np.sin(crank_angle)) ** 2)
    return -rate * crank * np.sin(crank_angle) * (1 + crank * np.cos(crank_angle) / swing)


def piston(time, crank, connecting_rod, crank_speed):
    angle = crank_speed * time
    return crank * np.cos(angle) + np.sqrt(connecting_rod**2 - (crank * np.sin(angle)) ** 2)


def engine_of(dimensions):
    return AirEngine(**{name: dimensions[name] for name in AirEngine.__dataclass_fields__})


def gas_torque(crank_angle, area, stroke, cut_off, clearance, pump_area, pump_stroke, pump_clearance,
               atmospheric_pressure, supply_pressure, back_pressure, load_pressure):  # fmt: skip
    arguments = locals()
    arguments.pop("crank_angle")
    return closed_gas_torque(AirEngine(**arguments), crank_angle=crank_angle)


def cut_off(eccentric, eccentric_rod, advance, outside_lap, inside_lap):
    gear = slide_valve.Eccentric(radius=eccentric, rod=eccentric_rod, advance=advance)
    return slide_valve.event_angle(gear, event="head end cut-off", outside_lap=outside_lap, inside_lap=inside_lap) - 2 * math.tau


def drive_torque(arm_angle, rate_of_arm_angle, spindle_speed, arm, offset, ball_mass):
    radius = offset + arm * np.sin(arm_angle)
    return 4 * ball_mass * radius * arm * np.cos(arm_angle) * rate_of_arm_angle * spindle_speed


AIR_ENGINE = parse_scene_document(air_engine_document(duration=2.5))

# Laws of textbooks, written here; conical pendulums swing with w sin(a), and with w sqrt(1 + 3 cos2(a)) while they turn freely.
LAWS = {
    "equilibrium_speed": (porter, speed, ANGLES),
    "equilibrium_angle": (porter, equilibrium, {"spindle_speed": "110 rpm:130 rpm:3"}),
    "stiffness": (lambda: CONICAL, lambda arm_angle, arm, spindle_speed, ball_mass:
                  2 * ball_mass * (arm * spindle_speed * np.sin(arm_angle)) ** 2, ANGLES),
    "oscillation_frequency": (lambda: CONICAL, lambda arm_angle, spindle_speed: spindle_speed * np.sin(arm_angle), ANGLES),
    "oscillation_frequency_free_spindle": (lambda: CONICAL, lambda arm_angle, spindle_speed:
                                           spindle_speed * np.sqrt(1 + 3 * np.cos(arm_angle) ** 2), ANGLES),
    "insensitivity": (porter, insensitivity, {**ANGLES, "resistance": "20 N,40 N"}),
    "rising_speed": (porter, loaded_speed, {**ANGLES, "resistance": 40.0}),
    "falling_speed": (porter, lambda resistance, arm_angle, arm, offset, ball_mass, sleeve_mass, gravity: loaded_speed(
        -resistance, arm_angle, arm, offset, ball_mass, sleeve_mass, gravity), {**ANGLES, "resistance": [40.0]}),
    "controlling_force": (porter, lambda ball_mass, ball_radius, spindle_speed: ball_mass * spindle_speed**2 * ball_radius, ANGLES),
    "static_sleeve_force": (porter, lambda ball_mass, sleeve_mass, gravity: (ball_mass + sleeve_mass) * gravity, ANGLES),
    "sleeve_lift": (porter, lambda arm_angle, arm: 2 * arm * (1 - np.cos(arm_angle)), ANGLES),
    "rate of crosshead_distance": (crank_scene, piston_velocity, {"crank_angle": "10 deg:350 deg:9", "rate": 12.0}),
    "crosshead_distance": (crank_scene, piston, {"time": "0 s:0.5 s:6"}),
    "head end cut-off": (valve_scene, cut_off, {}),
    "gas_torque": (lambda: AIR_ENGINE, gas_torque, {"crank_angle": "10 deg:170 deg:9"}),
    "acceleration of sleeve_lift": (porter, lambda arm_angle, arm, rate: 2 * arm * np.cos(arm_angle) * rate**2,
                                    {**ANGLES, "rate": "2 rad/s"}),
    "valve travel": (valve_scene, lambda eccentric: 2 * eccentric, {}),
    "mean gas torque": (lambda: AIR_ENGINE, lambda area, stroke, load_pressure: area * stroke * load_pressure / math.pi, {}),
    "spindle_torque": (porter, drive_torque, {"time": [0.0, 0.3, 0.7]}),
}  # fmt: skip


@pytest.mark.parametrize("quantity", LAWS)
def test_a_right_kernel_differs_by_no_more_than_the_estimated_error(quantity):
    scene, kernel, over = LAWS[quantity]
    report = gm.crosscheck(scene(), kernel, quantity, over)
    assert report.passed, str(report)
    for row in report.rows:
        assert abs(row.difference) <= row.error_estimate + KERNEL_ROUNDING * max(abs(row.simulated), row.scale), str(report)
        assert row.error_estimate <= 0.2 * report.tolerance * row.scale  # of a run a tenth of the tolerance is asked


def test_stiffness_and_frequencies_take_a_given_speed_and_the_inertia_of_a_free_spindle():
    def stiffness(arm_angle, spindle_speed, arm, ball_mass, gravity):
        weight = gravity * arm * np.cos(arm_angle)
        return 2 * ball_mass * (weight - (arm * spindle_speed) ** 2 * np.cos(2 * arm_angle))

    grid = {**ANGLES, "spindle_speed": "40 rpm,60 rpm"}
    assert gm.crosscheck(CONICAL, stiffness, "stiffness", grid).passed

    def frequency(arm_angle, spindle_speed, spindle_inertia, arm, ball_mass):
        ball_inertia = 2 * ball_mass * arm**2
        total = spindle_inertia + ball_inertia * np.sin(arm_angle) ** 2
        return spindle_speed * np.sin(arm_angle) * np.sqrt(1 + 4 * ball_inertia * np.cos(arm_angle) ** 2 / total)

    document = gm.load("porter_free_spindle").document
    conical = parse_scene_document(document | {"dimensions": {"arm": 0.4, "offset": 0.0, "ball_mass": 2.0}})
    report = gm.crosscheck(conical, frequency, "oscillation_frequency_free_spindle", ANGLES)
    assert report.passed, str(report)
    assert report.worst.arguments["spindle_inertia"][0] > 0


@pytest.mark.parametrize("quantity", [name for name in LAWS if name != "head end cut-off"])  # it counts modulo a turn
def test_a_planted_mistake_of_one_per_cent_is_found_with_its_size(quantity):
    scene, kernel, over = LAWS[quantity]

    @functools.wraps(kernel)  # and so with its parameters
    def planted(**arguments):
        return 1.01 * kernel(**arguments)

    report = gm.crosscheck(scene(), planted, quantity, over)
    assert not report.passed
    assert all(row.relative_error == pytest.approx(0.01 * row.simulated / row.scale, abs=2e-7) for row in report.rows)  # a run to 1e-7
    assert {*report.worst.inputs} == {*over}
    assert "worst: " in str(report)


def test_a_long_table_keeps_the_order_of_the_inputs_and_a_constant_factor_is_named():
    def planted(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity):
        return 0.7746 * speed(arm_angle, arm, offset, ball_mass, sleeve_mass, gravity)

    over = {"arm_angle": "15 deg:44 deg:30"}
    text = str(gm.crosscheck(porter(), planted, "equilibrium_speed", over))
    assert "the kernel is 0.7746 times the simulation in every row" in text
    angles = [float(angle) for angle in re.findall(r"^arm_angle = (\S+) deg", text, re.MULTILINE)]
    assert len(angles) == 25
    assert angles == sorted(angles)
    assert "in every row" not in str(gm.crosscheck(porter(), speed, "equilibrium_speed", over))
    assert "in every row" not in str(gm.crosscheck(porter(), lambda arm_angle: arm_angle, "equilibrium_speed", over))


def redtenbacher(r_over_p):
    """The energy of the flywheel by the seven terms of (65) to (67), with r / p taken as given in the third."""

    def energy_fluctuation_of(area, stroke, cut_off, clearance, pump_area, pump_stroke, pump_clearance,
                              atmospheric_pressure, supply_pressure, back_pressure, load_pressure):  # fmt: skip
        engine = AirEngine(**{name: value for name, value in locals().items() if name != "r_over_p"})
        extremes = energy_fluctuation(engine)
        terms = list(bracket_terms(engine, slowest_angle=extremes.slowest_angle, fastest_angle=extremes.fastest_angle))
        if r_over_p is not None:
            terms[2] = -r_over_p * (math.cos(extremes.slowest_angle) - math.cos(extremes.fastest_angle)) / 2
        return engine.area * engine.supply_pressure * engine.stroke * sum(terms)

    return energy_fluctuation_of


def test_redtenbachers_flywheel_is_found_too_light_by_the_third_term():
    """He took r / p as 0.5 in place of 1.5 / 4, which makes the sum 28 % too small for his load."""
    right = gm.crosscheck(AIR_ENGINE, redtenbacher(None), "energy_fluctuation", allowed=1e-4)
    assert right.passed, str(right)
    wrong = gm.crosscheck(AIR_ENGINE, redtenbacher(0.5), "energy_fluctuation", allowed=1e-4)
    engine = engine_of(AIR_ENGINE.part.dimensions)
    extremes = energy_fluctuation(engine)
    slip = 0.125 * (math.cos(extremes.slowest_angle) - math.cos(extremes.fastest_angle)) / 2
    size = slip * engine.area * engine.supply_pressure * engine.stroke / extremes.energy
    assert wrong.worst.relative_error == pytest.approx(-size, abs=1e-4)
    assert slip == pytest.approx(-0.2035 - compare_with_paper().wrong_term.printed, abs=2e-3)  # he rounds the angles to 3 and 95 deg
    assert not wrong.passed


def test_redtenbachers_plus_for_a_minus_in_the_equation_of_balance_is_found():
    """(61) in numbers has 1.05 / (1.05 + u) for the pressure before the pump piston, where 1.05 / (1.05 - u) is meant."""

    def pressure(sign):
        def delivery_pressure(crank_angle, pump_clearance, atmospheric_pressure):
            travel = (1 - np.cos(crank_angle)) / 2
            return atmospheric_pressure * (1 + pump_clearance) / (1 + pump_clearance + sign * travel)

        return delivery_pressure

    over = {"crank_angle": "5 deg:120 deg:8"}  # before the delivery valve opens, at 125.1 deg
    assert gm.crosscheck(AIR_ENGINE, pressure(-1), "delivery_pressure", over).passed
    report = gm.crosscheck(AIR_ENGINE, pressure(1), "delivery_pressure", over)
    travel = (1 - math.cos(math.radians(120))) / 2
    assert report.worst.inputs["crank_angle"][0] == pytest.approx(math.radians(120))
    # Pressures are read relative to the largest, which is the right one there.
    assert report.worst.relative_error == pytest.approx((1.05 - travel) / (1.05 + travel) - 1, rel=1e-9)


def dubois_scene(**changes):
    document = dict(gm.load("hartung_dubois").document)
    dimensions = {name: value for name, value in document["dimensions"].items() if not name.startswith(("spring_", "preload_"))}
    return parse_scene_document(document | {"dimensions": dimensions | changes})


def test_the_misprint_in_duboiss_table_of_spring_forces_is_found():
    """Springs along the line of 212 rpm; he prints 199.8 kgf for 189.8 kgf at the radius of 92 mm."""
    radii, _, printed = (np.array(column) for column in zip(*PRINTED_SPRING_FORCES, strict=True))

    def table(weight_radius):
        return np.interp(1e3 * weight_radius, radii, printed)

    scene = dubois_scene(inner_speed="212 rpm", outer_speed="212 rpm")
    # The sines of his angles are those of his radii. The kilogram of the paper is a weight at 9.81 m/s2, pint's one at 9.80665.
    angles = [math.asin((122 - radius) / 115) for radius in radii[1:-1]]
    kilogram = 9.81 / 9.80665
    report = gm.crosscheck(scene, lambda weight_radius: kilogram * table(weight_radius), "spring_force",
                           {"lever_angle": [math.radians(14.99), *angles]}, unit="kgf", allowed=6e-3)  # fmt: skip
    failed = [row for row in report.rows if not row.passed]
    assert [row.inputs["lever_angle"][0] for row in failed] == [pytest.approx(math.radians(14.99))]
    assert -failed[0].difference / kilogram == pytest.approx(10.0, abs=0.7)  # his slide rule errs by up to 0.66 kgf


def test_duboiss_extra_digit_in_a_radius_and_his_truncated_mass_are_found():
    scene = dubois_scene(inner_speed="204 rpm", outer_speed="212 rpm")

    def radius(lever_angle, fulcrum_radius, weight_arm):
        """192 mm is printed for 92 mm at the inner end."""
        return fulcrum_radius - weight_arm * np.sin(lever_angle) + np.where(lever_angle > math.radians(14.9), 0.1, 0.0)

    report = gm.crosscheck(scene, radius, "weight_radius", {"lever_angle": "-14.99 deg:14.99 deg:3"})
    assert [row.passed for row in report.rows] == [True, True, False]
    assert -report.worst.difference == pytest.approx(0.1)
    # A mass of 4.58 for 45 / 9.81 = 4.587 (kgf s2/m), in the balance of the weight: C = m w2 x.
    slip = 4.58 * 9.81 / 45 - 1
    report = gm.crosscheck(scene, lambda weight_radius, spindle_speed: 4.58 * 9.81 * spindle_speed**2 * weight_radius,
                           "controlling_force", {"lever_angle": [0.0]})  # fmt: skip
    assert report.worst.relative_error == pytest.approx(slip, abs=1e-12)
    assert not report.passed


def test_units_and_names_of_the_kernels_own_are_converted():
    def rpm(alpha, l_mm, e, m, M):
        return 30 / math.pi * speed(math.radians(alpha), l_mm / 1e3, e, m, M, 9.81)

    names = {"alpha": "arm_angle in deg", "l_mm": "arm in mm", "e": "offset", "m": "ball_mass", "M": "sleeve_mass"}
    report = gm.crosscheck(porter(), rpm, over=ANGLES, names=names, unit="rpm")
    assert report.passed, str(report)
    assert report.worst.arguments["l_mm"] == (pytest.approx(300.0), "mm")
    assert gm.crosscheck(CONICAL, lambda arm_angle, spindle_speed: spindle_speed * np.sin(arm_angle) / math.tau,
                         "oscillation_frequency", ANGLES, unit="Hz").passed  # fmt: skip
    refuses("the unit of the kernel's result is an angular speed", gm.crosscheck, porter(), speed, over=ANGLES, unit="mm")
    with pytest.raises(gm.MechanismError, match="'beta', which is no parameter of the kernel; it has arm_angle"):
        gm.crosscheck(porter(), speed, over=ANGLES, names={"beta": "arm_angle"})


def test_arrays_are_used_where_the_kernel_takes_them():
    calls = []

    def vectorised(arm_angle, arm):
        calls.append(np.shape(arm_angle))
        return 2 * arm * (1 - np.cos(arm_angle))

    assert gm.crosscheck(porter(), vectorised, "sleeve_lift", ANGLES).is_vectorised
    assert calls == [(7,), (), ()]  # and the ends alone, which must agree
    assert not gm.crosscheck(porter(), speed, over=ANGLES).is_vectorised
    astatic = gm.crosscheck(porter(), lambda arm: 0.1, "sleeve_lift", ANGLES)  # one number for all points
    assert (astatic.is_vectorised, len(astatic.rows)) == (False, 7)


def test_a_kernel_that_depends_on_its_neighbours_or_changes_its_input_has_a_defect():
    def normalised(arm_angle, arm):
        return 2 * arm * (1 - np.cos(arm_angle)) * np.max(arm_angle) / math.radians(45)

    report = gm.crosscheck(porter(), normalised, "sleeve_lift", ANGLES)
    assert "its results must not depend on one another" in report.defects[0]

    def in_place(arm_angle, arm):
        lift = 2 * arm * (1 - np.cos(arm_angle))
        arm_angle *= 2
        return lift

    report = gm.crosscheck(porter(), in_place, "sleeve_lift", ANGLES)
    assert all(row.passed for row in report.rows)
    assert not report.passed
    assert "changes its argument 'arm_angle' in place, called with arm_angle = 0.26179938" in str(report)


def test_a_kernel_over_time_may_need_the_times_before():
    def accumulated(time, crank_speed):
        return np.append(0.0, np.cumsum(np.diff(time) * crank_speed))

    report = gm.crosscheck(crank_scene(), accumulated, "crank_angle", {"time": "0 s:0.5 s:6"})
    assert report.passed, str(report)
    assert report.is_vectorised


def test_a_tolerance_below_the_error_of_the_simulation_is_noted():
    report = gm.crosscheck(crank_scene(), piston, "crosshead_distance", {"time": [0.1, 0.2]}, allowed=1e-18)
    assert report.passed
    assert "in 2 of 2 points the error of the simulation exceeds the tolerance" in report.notes[0]


def test_a_record_has_no_infinite_numbers():
    report = gm.crosscheck(AIR_ENGINE, lambda connecting_rod, crank_angle: 0 * crank_angle, "gas_torque", {"crank_angle": [1.0, 2.0]})
    assert report.rows[0].arguments["connecting_rod"] == (math.inf, "m")
    assert '"connecting_rod": null' in format_json(report.as_json())


def test_a_valve_gear_moves_over_its_crank_angle():
    turn = {"crank_angle": "0 deg:360 deg:2"}
    crank_end, head_end = gm.crosscheck("walschaerts", lambda: 0.0, "piston", {"crank_angle": "0 deg:180 deg:2"}).rows
    assert gm.crosscheck("walschaerts", lambda: crank_end.simulated, "piston", turn).passed  # a turn later it is back
    assert head_end.simulated != pytest.approx(crank_end.simulated)


def raising(arm_angle, arm):
    return 1 / 0 if arm_angle > 0.6 else 2 * arm * (1 - math.cos(arm_angle))


@pytest.mark.parametrize(
    ("kernel", "sentence"),
    [
        (raising, r"raised ZeroDivisionError: division by zero \(line \d+ of test_user_kernel.py\), called with arm_angle = 0.6108"),
        (
            lambda arm_angle, arm: 2 * arm * (1 - math.cos(arm_angle)) if arm_angle < 0.6 else math.nan,
            "returned NaN, called with arm_angle",
        ),
        (lambda arm_angle, arm: 2 * arm * (1 - math.cos(arm_angle)) if arm_angle < 0.6 else math.inf, "returned inf, called with"),
        (lambda arm_angle, arm: 2 * arm * (1 - math.cos(arm_angle)) if arm_angle < 0.6 else cmath.sqrt(-arm), "the complex number 0"),
        (lambda arm_angle, arm: 2 * arm * (1 - np.cos(arm_angle)) if arm_angle < 0.6 else np.ones((2, 1)), r"an array of shape \(2, 1\)"),
        (lambda arm_angle, arm: 2 * arm * (1 - math.cos(arm_angle)) if arm_angle < 0.6 else None, "returned None, called with"),
    ],
)
def test_a_kernel_that_gives_no_number_somewhere_is_told_with_its_input(kernel, sentence):
    report = gm.crosscheck(porter(), kernel, "sleeve_lift", {"arm_angle": "20 deg:50 deg:3"})
    assert [row.passed for row in report.rows] == [True, False, False]
    assert re.search(sentence, report.rows[1].problem)
    assert report.worst.problem in str(report)
    assert report.as_json()["rows"][1]["expected"] is None


@pytest.mark.parametrize("kernel", [lambda arm: [arm, arm], lambda arm: 1j * arm, lambda arm: missing, lambda arm: math.nan * arm])  # noqa: F821
def test_a_kernel_that_gives_no_number_anywhere_is_refused(kernel):
    with pytest.raises(gm.MechanismError, match=r"<lambda> gave no number anywhere; at arm_angle = 20 deg: .* called with arm = 0.3 m"):
        gm.crosscheck(porter(), kernel, "sleeve_lift", {"arm_angle": ["20 deg", "30 deg"]})


def test_random_dimensions_are_those_of_the_seed_and_lie_within_their_limits():
    arguments = {"over": {"arm_angle": "15 deg:45 deg"}, "vary": {"dimensions.arm": "200 mm:400 mm"}, "random": 12, "seed": 3}
    first, second = gm.crosscheck("porter", speed, **arguments), gm.crosscheck("porter", speed, **arguments)
    assert first.passed
    assert first.rows == second.rows
    arms = [row.inputs["dimensions.arm"][0] for row in first.rows]
    assert len({*arms}) == 12
    assert all(0.2 <= arm <= 0.4 and row.arguments["arm"][0] == arm for arm, row in zip(arms, first.rows, strict=True))
    assert gm.crosscheck("porter", speed, **arguments | {"seed": 4}).rows != first.rows


def test_a_grid_of_dimensions_has_all_combinations_and_a_scene_that_cannot_be_simulated_is_noted():
    vary = {"dimensions.arm": ["100 mm", "300 mm"], "dimensions.offset": ["20 mm", "40 mm", "60 mm"]}
    report = gm.crosscheck("porter", speed, over={"arm_angle": [0.4, 0.5]}, vary=vary)
    assert len(report.rows) == 12
    assert report.passed
    # Crossed arms this long cannot reach the position in both scenes.
    report = gm.crosscheck("porter", speed, over={"arm_angle": [0.2]}, vary={"dimensions.offset": ["-100 mm", "40 mm"]})
    assert len(report.rows) == 1
    assert "1 of 2 scenes are left out" in report.notes[0]


def test_the_engine_and_the_governor_of_a_coupled_scene_are_both_reached():
    lift = lambda governor_arm, governor_arm_angle: 2 * governor_arm * (1 - np.cos(governor_arm_angle))  # noqa: E731
    names = {"governor_arm_angle": "governor.arm_angle"}
    report = gm.crosscheck("governed_engine_mean_torque", lift, "governor.sleeve_lift", {"time": [0.0, 0.2]}, names=names)
    assert report.passed, str(report)
    assert gm.crosscheck("governed_engine_mean_torque", speed, over=ANGLES).passed


def test_every_quantity_is_listed_with_unit_inputs_and_arguments():
    for name in ("porter", "parabolic", "slide_valve_marks", "air_engine", "quick_return"):
        scene = gm.load(name)
        text = str(list_quantities(scene))
        for one in kernel_quantities(scene):
            assert one.unit
            assert one.description
            assert one.name in text or one.name.startswith(("rate_of_", "acceleration_of_"))
