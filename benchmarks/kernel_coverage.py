"""Which lines and branches of the kernels short runs and tests reach: the kernels run as Python, and coverage.py watches them.

Usage: python benchmarks/kernel_coverage.py. It prints what of each kernel is not reached, the share of all that is, and what is left out
with the reason (`kernel_exclusions.py`). It fails if anything else is not reached, or if something that is left out is gone.
"""

from __future__ import annotations

import ast
import json
import math
import os
import sys
import tempfile
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

os.environ["GOVERNOR_MECHANISM_JIT"] = "0"

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

import coverage
import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines.multibody import implicit
from governor_mechanism.engines.multibody.integration import make_limit_rows
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.mechanics.dynamics.arrays import from_mass_centres, make_system_workspace
from governor_mechanism.mechanics.dynamics.constrained_solution import solve_constrained_system
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from kernel_exclusions import EXITS, STATEMENTS
from shaft_scenes import TABLES, changed

TEST_FOLDER = Path(__file__).parents[1] / "tests"
PACKAGE = Path(__file__).parents[1] / "src" / "governor_mechanism"
FOLDERS = ("numerics", "effects", "mechanics", "integrators", "engines")
SCENES = (
    "air_engine air_engine_finite_rods air_engine_heavy_pistons allan andrews_squeezer car_axis_like four_bar_chain governed_engine "
    "governed_engine_cut_off governed_engine_mean_torque governed_engine_runaway hartnell hartung_corrected haug_governor joy parabolic "
    "pendulum_iftomm porter porter_clearance porter_cyclic porter_dashpot porter_free_spindle porter_heavy_rods porter_load_step proell "
    "quick_return slide_valve_30 slider_crank_torque stephenson_arc_middle stiff_flyball walschaerts watt_clearance watt_engine_hunting"
)
"""Shipped scenes: of those that differ by numbers alone one is enough."""

SLOW = {("andrews_squeezer", "reduced")}
"""Runs that take minutes without a compiler and reach nothing that others do not."""

LONGER_RUNS = [
    ("porter", "reduced", 0.5, True),
    ("porter_dry_friction", "reduced", 1.0, True),
    ("porter_dry_friction", "multibody", 1.0, False),
    ("hartung_corrected", "reduced", 7.0, False),
    ("hartung_corrected", "multibody", 7.0, False),
    ("stiff_flyball", "multibody", 10.0, False),
    ("four_bar_chain", "multibody", 0.5, True),
    ("air_engine", "reduced", 1.0, False),
    ("governed_engine_cut_off", "multibody", 0.5, False),
    ("graham_escapement", "multibody", 0.4, False),
    ("geneva", "multibody", 0.2, False),
    ("ratchet", "multibody", 0.2, False),
]
"""Scene, engine, duration (s), and whether the run is certified, for what short runs do not reach."""


GOVERNOR_DIMENSIONS = {"arm": 0.3, "offset": 0.04, "ball_mass": 5, "sleeve_mass": 20}
GOVERNOR = {
    "machine": "pendulum_governor",
    "dimensions": GOVERNOR_DIMENSIONS,
    "spindle": {"speed": "120 rpm"},
    "run": {"duration": 0.2, "output_interval": 0.05, "accuracy": 1e-4},
}
WEIGHTS = {"gravity": True, "centrifugal": True}
SLACK_SPRING = {"spring": {"sleeve": {"rate": 2000, "preload": 0, "zero": 0.15, "one_sided": True}}}
ALL_ENGINES, EXACT_ENGINES = ("reduced", "multibody", "impulse"), ("reduced", "multibody")
GOVERNOR_RUNS: tuple[tuple[dict[str, Any], dict[str, Any], tuple[str, ...]], ...] = (
    (SLACK_SPRING | {"dry_friction": {"sleeve": "5 N"}}, {"arm_angle": "38 deg", "arm_rate": 1.0}, ALL_ENGINES),
    ({"dashpot": {"sleeve": "50 N s/m"}, "dry_friction": {"sleeve": "5 N"},
      "stops": {"arm_angle": ["25 deg", "32 deg"], "restitution": 0.5}}, {"arm_angle": "30 deg", "arm_rate": 2.0}, EXACT_ENGINES),
    ({"stops": {"arm_angle": ["25 deg", "32 deg"], "restitution": 0.01}}, {"arm_angle": "30 deg", "arm_rate": 2.0}, EXACT_ENGINES),
    ({"dashpot": {"sleeve": "50 N s/m"}}, {"arm_angle": "30 deg", "arm_rate": 2.0}, ("impulse",)),
    ({}, {"arm_angle": "85 deg", "arm_rate": 5.0}, ("reduced",)),
)  # fmt: skip
"""Effects beside weights, start, and engines of governors: a spring that becomes taut, strikes, bounces that end, a motion beyond the
travel."""

FLIGHT = """
machine = "custom"
size = 1.0
plane = "turning"
ground = { O = [0, 0] }
body = [{ name = "ball", mass = 1.0, point = true, at = [0.1, 0] }, { name = "light", mass = LIGHT, point = true, at = [0, 0.8] }]
joint = [
    { type = "slider", first = "ground.O", second = "ball.centre", angle = 0 },
    { type = "slider", first = "ground.O", second = "light.centre", angle = "90 deg" },
]
force = [
    { type = "spring", first = "ground.O", second = "light.centre", stiffness = 40, free_length = 0.2 },
    { type = "damper", first = "ground.O", second = "light.centre", damping = 4 },
]
readings = { x = { x = "ball.centre" } }
effects = { centrifugal = true }
spindle = { speed = "100 rad/s" }
run = { duration = 0.2, output_interval = 0.1, accuracy = 1e-4 }
"""
"""A ball that flies away along a guide, beside a body that a damper makes stiff if it is light."""

PARALLELOGRAM = """
machine = "custom"
ground = { A = [0, 0], D = [0.3, 0] }
body = [
    { name = "crank", mass = 0.5, inertia = 0.001, points = { end = [0.1, 0] }, angle = "-2 deg" },
    { name = "coupler", mass = 0.5, inertia = 0.001, points = { end = [0.3, 0] } },
    { name = "rocker", mass = 0.5, inertia = 0.001, points = { end = [0.1, 0] }, at = [0.3, 0], angle = "-2 deg" },
]
joint = [
    { type = "pin", first = "ground.A", second = "crank.origin" },
    { type = "pin", first = "crank.end", second = "coupler.origin" },
    { type = "pin", first = "coupler.end", second = "rocker.end" },
    { type = "pin", first = "rocker.origin", second = "ground.D" },
]
readings = { crank = { angle = "crank" }, rocker = { angle = "rocker" } }
start = { crank = "-2 deg", rocker = "-2 deg", crank_rate = 5.0 }
run = { duration = 0.02, output_interval = 0.02, accuracy = 1e-6 }
"""
"""Four links that pass their change point."""

COINCIDENT = """
machine = "custom"
size = 1.0
ground = { O = [0, 0] }
body = [{ name = "ball", mass = 1.0, turns = false, at = [0, 0] }]
joint = [{ type = "slider", first = "ground.O", second = "ball.centre", angle = "90 deg" }]
force = [{ type = "spring", first = "ground.O", second = "ball.centre", stiffness = 40, free_length = 0 }]
readings = { y = { y = "ball.centre" } }
effects = { gravity = true }
run = { duration = 0.02, output_interval = 0.02, accuracy = 1e-4 }
"""
"""A spring that starts without a length, and has no direction there."""

BALANCED = """
machine = "custom"
size = 1.0
plane = "turning"
ground = { O = [0, 0] }
body = [
    { name = "first", mass = 1.0, moments = { xx = 0.1 } },
    { name = "second", mass = 1.0, moments = { xx = 0.1 }, angle = "90 deg" },
]
joint = [
    { type = "pin", first = "ground.O", second = "first.centre" },
    { type = "pin", first = "ground.O", second = "second.centre" },
    { type = "gear", first = "first", second = "second", ratio = 1 },
]
readings = { angle = { angle = "first" } }
effects = { centrifugal = true }
spindle = { speed = "10 rad/s" }
start = { angle = "30 deg", angle_rate = 1.0 }
run = { duration = 0.02, output_interval = 0.02, accuracy = 1e-4 }
"""
"""Two rods, always perpendicular to each other: their moment of inertia about the spindle does not change."""

GEARED_CAM = """
machine = "custom"
size = 0.1
ground = { O = [0, 0] }
body = [
    { name = "cam", mass = 1.0, inertia = 0.002, points = { axle = [0.1, 0] } },
    { name = "follower", mass = 0.5, turns = false, at = [0, 0.05] },
    { name = "planet", mass = 0.2, inertia = 1e-4, at = [0.1, 0] },
]
joint = [
    { type = "pin", first = "ground.O", second = "cam.origin" },
    { type = "pin", first = "cam.axle", second = "planet.origin" },
    { type = "slider", first = "ground.O", second = "follower.centre", angle = "90 deg" },
    { type = "curve", first = "cam.origin", second = "follower.centre", curve = { radius = 0.05, harmonics = [
        { amplitude = 0.01, order = 2 } ] } },
    { type = "gear", first = "ground.O", second = "planet", ratio = -1, carrier = "cam" },
]
readings = { cam = { angle = "cam" } }
start = { cam = 0, cam_rate = 5.0 }
run = { duration = 0.2, output_interval = 0.1, accuracy = 1e-4 }
"""
"""A cam with a closed groove, which carries a planet round a wheel that stands still."""

ROCKERS = """
machine = "custom"
ground = { A = [0, 0], D = [0.3, 0] }
body = [
    { name = "first", mass = 0.5, inertia = 0.001, points = { end = [0.1, 0] }, angle = "60 deg" },
    { name = "coupler", mass = 0, points = { end = [0.25, 0] } },
    { name = "second", mass = 0.5, inertia = 0.001, points = { end = [0.1, 0] }, at = [0.3, 0], angle = "90 deg" },
]
joint = [
    { type = "pin", first = "ground.A", second = "first.origin" },
    { type = "pin", first = "first.end", second = "coupler.origin" },
    { type = "pin", first = "coupler.end", second = "second.end" },
    { type = "pin", first = "second.origin", second = "ground.D" },
]
readings = { angle = { angle = "first" } }
start = { angle = "60 deg" }
run = { duration = 0.02 }
"""
"""Four links, of which none can turn round, and the coupler has no mass."""

TESTS = (
    "numerics/test_banded_cholesky.py",
    "numerics/test_chebyshev.py",
    "numerics/test_dense_lu.py",
    "integrators/test_dop853.py",
    "integrators/test_event_location.py",
    "integrators/test_radau.py",
    "integrators/test_step_record.py",
    "mechanics/test_contact_rules.py",
    "mechanics/test_impacts.py",
    "mechanics/test_inputs.py",
    "mechanics/test_joint_residuals.py::test_slots_follow_their_curves_over_all_segments",
    "mechanics/test_motion_table.py",
    "mechanics/test_outlines.py::test_a_roller_that_keeps_no_edge_is_beyond_the_end_of_none",
    "mechanics/test_outlines.py::test_round_a_square_edges_and_corners_take_turns_both_ways",
    "mechanics/test_outlines.py::test_round_a_stadium_there_are_no_corners",
    "mechanics/test_outlines.py::test_the_way_ends_at_hollow_corners",
    "mechanics/test_outlines.py::test_the_distance_from_a_corner_is_that_of_two_points",
    "mechanics/test_outlines.py::test_gradient_and_quadratic_term_are_those_of_differences",
    "mechanics/test_profiles.py::test_gradient_and_quadratic_term_are_those_of_differences",
    "mechanics/test_profiles.py::test_the_slip_is_the_velocity_of_the_lowest_point_of_the_curve_along_the_outline",
    "mechanics/test_profiles.py::test_a_curve_whose_origin_is_behind_all_edges_overlaps_one_of_them",
    "mechanics/test_profiles.py::test_a_cam_in_a_hollow_touches_its_arcs_from_inside",
    "mechanics/test_outlines.py::test_the_slip_is_the_velocity_of_both_surfaces_along_each_other",
    "mechanics/test_outlines.py::test_of_rollers_that_repeat_the_nearest_one_counts",
    "engines/test_contact_friction.py::test_a_disc_with_back_spin_slides_and_then_rolls_without_losses",
    "engines/test_contact_friction.py::test_an_impact_with_friction_stops_the_sliding_or_is_limited_by_coulombs_law",
    "engines/test_contact_friction.py::test_a_ball_that_bounces_to_rest_loses_sliding_speed_in_all_its_strikes",
    "engines/test_contact_friction.py::test_balls_on_one_block_that_rests_do_not_disturb_each_other",
    "engines/test_contact_friction.py::test_a_rod_that_rubs_beyond_painleves_limit_ends_by_name",
    "numerics/test_dense_solution.py",
    "numerics/test_hermite_curve.py",
    "mechanics/test_two_formulations.py",
    "engines/test_random_contacts.py::test_parts_stay_apart_and_gain_no_energy[3-smooth]",
    "engines/test_random_contacts.py::test_parts_stay_apart_and_gain_no_energy[8-smooth]",
    "engines/test_certificates.py::test_rates_beside_a_singular_position_are_as_accurate_as_others[1e-06]",
    "engines/test_reduced_contacts.py::test_a_strut_rebounds_by_the_energy_that_friction_leaves_and_not_beyond_self_locking[0.65-reduced]",
    "engines/test_reduced_contacts.py::test_a_strut_rebounds_by_the_energy_that_friction_leaves_and_not_beyond_self_locking[3.0-reduced]",
    "engines/test_reduced_contacts.py::test_beyond_self_locking_a_strut_that_is_pulled_off_ends_by_name_in_both_engines[0.65--20.0]",
    "engines/test_start_on_a_stop.py",
    "engines/test_far_contacts.py",
)
"""Tests that call kernels by themselves, or runs that begin in special ways."""

SLOW_TESTS = "both_runs or order or at_any_stiffness or at_a_turning_point or shipped_scenes or impulse or change_point or whole_turn"
"""Tests that take long without a compiler and reach nothing that others do not."""


def run_shipped_scenes() -> None:
    """Run shipped scenes shortly, and some longer."""
    for name in SCENES.split():
        for engine in EXACT_ENGINES:
            if (name, engine) not in SLOW:
                with suppress(gm.UnsupportedEffect):
                    gm.run(name, engine=engine, times=[0.0, 0.02], certify=False)
    for name, engine, duration, is_certified in LONGER_RUNS:
        run = gm.run(name, engine=engine, times=np.linspace(0.0, duration, 5), certify=is_certified)
        print(f"{name:24s} {engine:10s} {run.outcome.name}, {run.cost.steps} steps", flush=True)
    gm.kinematics("porter", "arm_angle", [0.5, 0.6])
    gm.linearise("haug_governor")


def run_governors() -> None:
    """Run governors with springs, stops and friction."""
    for effects, start, engines in GOVERNOR_RUNS:
        scene = gm.Scene.from_dict(GOVERNOR | {"effects": WEIGHTS | effects, "start": start})
        for engine in engines:
            gm.run(scene, engine=engine, certify=False)
    effects = WEIGHTS | {"spring": {"sleeve": {"rate": 2000, "preload": 0, "zero": 0.5, "one_sided": True}}}
    gm.run(gm.Scene.from_dict(GOVERNOR | {"effects": effects, "start": {"arm_angle": "equilibrium"}}), engine="reduced", certify=False)
    long_links = GOVERNOR | {"dimensions": GOVERNOR_DIMENSIONS | {"link": 0.45}, "effects": WEIGHTS}
    for start in ({"arm_angle": "75 deg", "arm_rate": 9.0}, *({"arm_angle": "89 deg", "arm_rate": rate} for rate in (1.0, 1.1))):
        thrown = gm.Scene.from_dict(long_links | {"spindle": {"speed": 0}, "start": start})
        gm.run(thrown, engine="multibody", times=[0.0, 0.1], certify=False)
    crossed = GOVERNOR | {"dimensions": GOVERNOR_DIMENSIONS | {"offset": -0.06}, "spindle": {"speed": 0}}
    stiff = gm.Scene.from_dict(crossed | {"effects": WEIGHTS | {"dashpot": {"sleeve": 1e6}}, "start": {"arm_angle": "11.6 deg"}})
    gm.run(stiff, engine="multibody", times=[0.0, 0.5, 1.0], certify=False)


def run_linkages() -> None:
    """Run motions to where they end, through change points, and with forces without a direction."""
    for text, engine in (
        (FLIGHT.replace("LIGHT", "1e-7"), "multibody"),
        (FLIGHT.replace("LIGHT", "1"), "multibody"),
        (PARALLELOGRAM, "multibody"),
        (COINCIDENT, "reduced"),
        (COINCIDENT, "multibody"),
        (BALANCED, "reduced"),
        (GEARED_CAM, "reduced"),
        (GEARED_CAM, "multibody"),
    ):
        run = gm.run(gm.Scene.from_dict(tomllib.loads(text)), engine=engine, certify=False)
        if text is PARALLELOGRAM:
            print(len(run.reactions), "reactions")


def run_engines() -> None:
    """Run engines that turn back, cut-offs that move within the stroke, tables of the speed, and a throttle of one part."""
    backwards = {"start.crank_angle": 0, "start.crank_rate": "-6 rad/s"}
    for engine in EXACT_ENGINES:
        gm.run(gm.load("air_engine").replace(backwards), engine=engine, times=[0.0, 0.1], certify=False)
        gm.run(
            changed("watt_engine_hunting", TABLES["tables of the lift and of the speed"]), engine=engine, times=[0.0, 0.2], certify=False
        )
    within_stroke = gm.load("governed_engine_cut_off").replace({"part.engine.dimensions.cut_off_read": "within stroke"})
    gm.run(within_stroke, engine="multibody", times=[0.0, 0.3], certify=False)
    gm.run(within_stroke.replace({"coupling.eccentric.lag": "0.1 s"}), engine="multibody", times=[0.0, 0.01], certify=False)
    throttled = gm.load("air_engine_heavy_pistons").replace({"dimensions.throttle": 0.95})
    gm.run(throttled, engine="reduced", times=[0.0, 0.02], certify=False)


def call_kernels() -> None:
    """Call kernels with what no run leads to: joints that do not close, and a motion that moves nothing but stand-ins for masses."""
    scene = gm.Scene.from_dict(tomllib.loads(ROCKERS))
    system, inputs = make_system(scene)
    workspace, layout = make_system_workspace(system), system.state_layout
    centres = PositionSolver(scene.mechanism).solve({"angle": math.pi / 3})
    poses, velocities = from_mass_centres(system, centres, np.zeros_like(centres))
    state = np.concatenate([poses.ravel(), velocities.ravel(), np.zeros(layout.lags - layout.work)])
    cubics = stack_local_cubics(inputs, np.zeros(1))[0]
    integrator = implicit.ImplicitIntegrator(system, workspace, np.ones(state.size), 1e-9, 10.0, make_limit_rows(scene.mechanism))
    equation, buffers = integrator._make_arguments(cubics, state)
    beyond_reach = state[equation.components]
    beyond_reach[0] += math.pi / 2
    arguments = equation, 0.0, beyond_reach, buffers.start_derivative
    qualities = [evaluate(*arguments, buffers.jacobian) for evaluate in (implicit.evaluate_linearisation, implicit._evaluate_jacobian)]
    if {*qualities, implicit._evaluate(*arguments, 0)} != {implicit.OPEN_JOINT}:
        raise SystemExit("open joints are not noticed")
    if implicit._finish_step(*arguments) != IntegrationStatus.STALLED:
        raise SystemExit("a step ends although its joints are open")
    accelerations = np.zeros_like(poses)
    for inertia, is_possible in ((system.stand_in_inertia, True), (1.0 / system.inverse_mass, False)):
        evaluate_state_derivative(system, workspace, cubics, 0.0, state, np.zeros(state.size))
        solve_constrained_system(system._replace(stand_in_inertia=inertia), workspace, np.ones_like(poses), 1.0, accelerations)
        if np.isfinite(accelerations).all() != is_possible:
            raise SystemExit("accelerations of nothing but stand-ins for masses are numbers, or others are not")


def run_tests() -> None:
    """Run the tests, also long ones, of which a compiler makes short work here."""
    options = ["-q", "-p", "no:cacheprovider", "-W", "ignore", "--hypothesis-profile=mutants", "--durations=10"]
    if pytest.main([*options, "-k", f"not ({SLOW_TESTS})", *(str(TEST_FOLDER / name) for name in TESTS)]) != 0:
        raise SystemExit("a test fails without a compiler")


def compiled_functions() -> set[str]:
    """Return the names of functions that are compiled where they are called by name: jit(function)."""
    names = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("jit", "jit_in_place"):
                names |= {ast.unparse(argument).rpartition(".")[2] for argument in node.args}
    return names


def kernels_of(tree: ast.Module, compiled: set[str]) -> Iterator[ast.FunctionDef]:
    """Yield the kernels of a file: decorated functions, those compiled by name, and what a function that makes kernels returns."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            decorators = {ast.unparse(decorator) for decorator in node.decorator_list}
            is_method = bool(node.args.args) and node.args.args[0].arg == "self"
            if decorators & {"jit", "jit_in_place"} or (node.name in compiled and not is_method):
                yield node
            elif node.name.lstrip("_").startswith("make_") and "Callable" in ast.unparse(node.returns or ast.Constant(0)):
                yield from (inner for inner in node.body if isinstance(inner, ast.FunctionDef))


@dataclass
class LeftOut:
    """Lines of a kernel that nothing needs to reach, and lines of which all branches need not be taken, with the reasons printed."""

    lines: set[int] = field(default_factory=set)
    exits: set[int] = field(default_factory=set)
    reasons: list[str] = field(default_factory=list)

    def has_branch(self, start: int, end: int) -> bool:
        """Return whether a branch is left out."""
        return start in self.exits or bool({start, end} & self.lines)


def find_left_out(name: str, text: str, kernel: ast.FunctionDef) -> LeftOut:
    """Return what is left out in a kernel: the statements and exits whose first line stands in the list."""
    left_out, source, statements, exits = LeftOut(), text.split("\n"), dict(STATEMENTS.get(name, {})), dict(EXITS.get(name, {}))
    node: Any
    for node in ast.walk(kernel):
        first_line = source[node.lineno - 1].strip() if isinstance(node, ast.stmt) else ""
        if first_line in statements:
            left_out.lines |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
            left_out.reasons.append(f"{name}: {first_line}  # {STATEMENTS[name][first_line]}")
        if first_line in exits:
            left_out.exits.add(node.lineno)
            left_out.reasons.append(f"{name}: end of {first_line}  # {EXITS[name][first_line]}")
    n_found, n_listed = len({reason.split("  # ")[0] for reason in left_out.reasons}), len(statements) + len(exits)
    if n_found < n_listed:
        raise SystemExit(f"{name}: only {n_found} of {n_listed} places in kernel_exclusions.py are there")
    return left_out


def report(data: coverage.Coverage) -> bool:
    """Print what of each kernel is not reached, what is left out, and the share of all that is reached; return whether that is all."""
    with tempfile.TemporaryDirectory() as folder:
        data.json_report(outfile=f"{folder}/coverage.json")
        files = json.loads(Path(folder, "coverage.json").read_text(encoding="utf-8"))["files"]
    compiled, names, counts, reasons = compiled_functions(), set[str](), np.zeros((2, 2), dtype=int), list[str]()
    for path in sorted(path for folder in FOLDERS for path in (PACKAGE / folder).rglob("*.py")):
        text, found = path.read_text(encoding="utf-8"), next((one for name, one in files.items() if Path(name).resolve() == path), None)
        if "numerics.jit import" not in text or found is None:
            continue
        for kernel in kernels_of(ast.parse(text), compiled):
            name = f"{path.relative_to(PACKAGE).as_posix()}: {kernel.name}"
            left_out, lines = find_left_out(name, text, kernel), range(kernel.body[0].lineno, (kernel.end_lineno or kernel.lineno) + 1)
            missing_lines = [line for line in found["missing_lines"] if line in lines and line not in left_out.lines]
            unreached = {*found["missing_lines"]}
            branches = [(one, other) for one, other in found["missing_branches"] if one in lines and one not in unreached]
            missing_branches = [f"{one}->{other}" for one, other in branches if not left_out.has_branch(one, other)]
            names.add(name)
            reasons += left_out.reasons
            counts[0] += len(missing_lines), sum(line in lines for line in found["executed_lines"])
            counts[1] += len(missing_branches), sum(one in lines for one, _ in found["executed_branches"])
            if missing_lines or missing_branches:
                print(f"{name}: {', '.join([*map(str, missing_lines), *missing_branches])}")
    if gone := {*STATEMENTS, *EXITS} - names:
        raise SystemExit(f"kernel_exclusions.py names kernels that are gone: {', '.join(sorted(gone))}")
    lines_reached, branches_reached = 100 * counts[:, 1] / counts.sum(axis=1)
    print(f"{len(reasons)} places are left out:", *dict.fromkeys(reasons), sep="\n  ")
    print(f"{len(names)} kernels, {counts[0].sum()} lines, {lines_reached:.1f} % reached; {branches_reached:.1f} % of the branches in them")
    return not counts[:, 0].any()


def main() -> int:
    """Run scenes and tests under observation and print the report."""
    data = coverage.Coverage(source=[str(PACKAGE / folder) for folder in FOLDERS], data_file=None, branch=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data.start()
        run_governors()
        run_linkages()
        run_engines()
        run_shipped_scenes()
        call_kernels()
        run_tests()
        data.stop()
    return 0 if report(data) else 1


if __name__ == "__main__":
    sys.exit(main())
