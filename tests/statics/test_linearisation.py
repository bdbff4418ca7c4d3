"""Linearised equations against closed forms: eigenvalues, modes, transfer functions, limits of stability, and refusals."""

import json
import math
from collections.abc import Mapping

import numpy as np
import pytest
from scipy.optimize import brentq

import governor_mechanism as gm
from governor_mechanism.cli.regulation import report_linearisation
from governor_mechanism.closed_form import pendulum
from governor_mechanism.files.writing import format_json
from governor_mechanism.numerics.roots import directional_derivative, jacobian
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.first_order_system import FirstOrderSystem, Onset, Stability
from governor_mechanism.statics.linearisation import find_stability_limit
from governor_scenes import CROSSED, EXTENDED, PORTER
from reference import haug_governor
from reference import pendulum as linkage
from reference.scaled_watt_engine import WattEngine, damping_limit, equilibrium, first_lyapunov_coefficient, scale_engine, scaled_time_unit
from scene_documents import between, custom_document, governor_document, pin

RELATIVE_TOLERANCE = 1e-10
"""Nine-point differences are good to about 1e-12 of an eigenvalue; equilibria are known to 1e-14."""


def pontryagin(damping: float, alpha: float, beta: float) -> FirstOrderSystem:
    """Watt's governor with an engine, x'' = z^2 sin x cos x - sin x - eps x', z' = alpha (cos x - beta), at its steady state."""

    def derivative(states: np.ndarray) -> np.ndarray:
        x, rate, z = states.T
        return np.column_stack([rate, z * z * np.sin(x) * np.cos(x) - np.sin(x) - damping * rate, alpha * (np.cos(x) - beta)])

    return FirstOrderSystem(derivative, np.array([math.acos(beta), 0.0, beta**-0.5]), np.ones(3))


@pytest.mark.parametrize(("alpha", "beta"), [(0.4, 0.6), (1.0, 0.3), (0.2, 0.85)])
def test_limit_of_pontryagins_governor(alpha, beta):
    """Stable iff eps > 2 alpha beta^(3/2), with omega0^2 = (1 - beta^2) / beta (Pontryagin, Ordinary Differential Equations)."""
    limit = 2 * alpha * beta**1.5
    found = find_stability_limit(lambda eps: pontryagin(eps, alpha, beta), 0.5 * limit, 2 * limit, key="eps", unit="")
    assert found.value == pytest.approx(limit, rel=1e-11)  # the eigenvalue is good to 1e-13, its slope is of order one
    assert found.frequency**2 == pytest.approx((1 - beta**2) / beta, rel=1e-11)
    assert not found.stable_below
    assert pontryagin(0.9 * limit, alpha, beta).stability is Stability.UNSTABLE
    assert pontryagin(limit, alpha, beta).stability is Stability.UNDAMPED


@pytest.mark.parametrize("alpha", [0.2, 0.6])
def test_onset_of_pontryagins_governor(alpha):
    """The sign changes where 3 + (alpha^2 - 5) beta^2 + alpha^4 beta^6 = 0.

    J. Sotomayor, L. F. Mello, D. de C. Braga, Computational and Applied Mathematics 26 (2007), pp. 19-44.
    """

    def at_limit(beta: float) -> FirstOrderSystem:
        return pontryagin(2 * alpha * beta**1.5, alpha, beta)

    printed = brentq(lambda beta: 3 + (alpha**2 - 5) * beta**2 + alpha**4 * beta**6, 0.5, 0.95)
    found = brentq(lambda beta: at_limit(beta).first_lyapunov_coefficient(), 0.5, 0.95)
    assert found == pytest.approx(printed, abs=1e-7)  # third derivatives by differences are good to 1e-9
    assert at_limit(printed - 0.1).onset is Onset.SOFT
    assert at_limit(printed + 0.1).onset is Onset.HARD


def test_error_estimates_bound_the_errors():
    point = np.array([0.7, 1.3])
    found, errors = jacobian(lambda at: np.column_stack([np.exp(at[:, 0] * at[:, 1]), np.sin(at[:, 0]) / at[:, 1]]), point, np.ones(2))
    x, y = point
    exact = np.array([[y * np.exp(x * y), x * np.exp(x * y)], [np.cos(x) / y, -np.sin(x) / y**2]])
    assert np.all(np.max(np.abs(found - exact), axis=0) <= errors)
    assert np.all(errors < 1e-11)
    for order, value in ((1, np.cos(0.7)), (2, -np.sin(0.7)), (3, -np.cos(0.7))):
        derivative, error = directional_derivative(np.sin, np.array([0.7]), np.ones(1), order)
        assert abs(derivative[0] - value) <= max(error, 1e-15) < 1e-8


def speeds_and_rows(dimensions: dict[str, float], angle: float) -> tuple[pendulum.PendulumGovernor, float]:
    governor = pendulum.PendulumGovernor(**dimensions)
    return governor, float(pendulum.equilibrium_speed(governor, arm_angle=angle))


def scene_at_speed(dimensions: dict[str, float], *, speed: float, angle: float | str):
    return parse_scene_document(governor_document(dimensions, spindle={"speed": speed}, start={"arm_angle": angle}))


@pytest.mark.parametrize(("dimensions", "angle"), [(PORTER, 0.5), (EXTENDED, 0.6), (CROSSED, 0.9)])
def test_small_oscillations_at_a_given_speed(dimensions, angle):
    governor, speed = speeds_and_rows(dimensions, angle)
    found = gm.linearise(scene_at_speed(dimensions, speed=speed, angle=angle + 0.02))
    expected = math.sqrt(float(pendulum.squared_oscillation_frequency(governor, arm_angle=angle)))
    assert found.readings["arm_angle"] == pytest.approx(angle, rel=RELATIVE_TOLERANCE)
    assert found.modes[0].eigenvalue.imag == pytest.approx(expected, rel=RELATIVE_TOLERANCE)
    assert abs(found.modes[0].eigenvalue.imag - expected) < 10 * found.error_estimate + 1e-13  # the equilibrium adds a little
    assert found.stability is Stability.UNDAMPED
    assert not found.stable
    assert found.modes[0].damping_ratio == 0.0


def test_small_oscillations_with_a_free_spindle():
    """Omega_f^2 = Omega^2 + omega^2 J'^2 / ((J0 + J) I); the spindle keeps its start speed, and its momentum is conserved."""
    governor, speed = speeds_and_rows(PORTER, 0.6)
    spindle = {"inertia": 0.5, "start_speed": speed}
    found = gm.linearise(parse_scene_document(governor_document(spindle=spindle, start={"arm_angle": 0.55})))
    square = float(pendulum.squared_oscillation_frequency(governor, arm_angle=0.6))
    reaction = speed**2 * float(linkage.spindle_inertia_derivative(governor, arm_angle=0.6)) ** 2
    inertia = 0.5 + float(pendulum.spindle_inertia(governor, arm_angle=0.6))
    expected = math.sqrt(square + reaction / (inertia * float(linkage.in_plane_inertia(governor, arm_angle=0.6))))
    oscillation = next(mode for mode in found.modes if not mode.is_conserved)
    assert oscillation.eigenvalue.imag == pytest.approx(expected, rel=RELATIVE_TOLERANCE)
    assert found.rates["spindle_speed"] == pytest.approx(speed, rel=1e-14)
    assert [mode.is_conserved for mode in found.modes].count(True) == 1
    # Momentum (J0 + J) omega is constant in the oscillation.
    slope = float(linkage.spindle_inertia_derivative(governor, arm_angle=0.6))
    change = inertia * oscillation.amplitudes["spindle_speed"] + slope * speed * oscillation.amplitudes["arm_angle"]
    assert abs(change) < 1e-10 * abs(inertia * oscillation.amplitudes["spindle_speed"])


def test_dashpot_of_a_governor():
    """The damping ratio is c s'^2 / (2 sqrt(K I)); statics without the dashpot say so."""
    governor, speed = speeds_and_rows(PORTER, 0.5)
    effects = {"gravity": True, "centrifugal": True, "dashpot": {"sleeve": 40.0}}
    scene = parse_scene_document(governor_document(effects=effects, spindle={"speed": speed}))
    found = gm.linearise(scene)
    sleeve_slope = 2 * 0.3 * math.sin(0.5)  # sleeve lift of a rhombus, 2 l (1 - cos a)
    inertia = float(linkage.in_plane_inertia(governor, arm_angle=0.5))
    natural = math.sqrt(float(pendulum.squared_oscillation_frequency(governor, arm_angle=0.5)))
    assert found.modes[0].natural_frequency == pytest.approx(natural, rel=RELATIVE_TOLERANCE)
    assert found.modes[0].damping_ratio == pytest.approx(40.0 * sleeve_slope**2 / (2 * inertia * natural), rel=RELATIVE_TOLERANCE)
    assert found.stable
    (equilibrium,) = gm.equilibria(scene)
    assert gm.linearise(scene, at=equilibrium).eigenvalues == pytest.approx(found.eigenvalues, rel=RELATIVE_TOLERANCE)


def test_static_gain_of_the_spindle_speed():
    scene = scene_at_speed(PORTER, speed=12.2, angle=0.5)
    (equilibrium,) = gm.equilibria(scene)
    system = gm.linearise(scene).state_space(["spindle_speed"], ["arm_angle"])
    gain = system.frequency_response([0.0])[0, 0, 0]
    assert gain.imag == 0.0
    assert gain.real == pytest.approx(equilibrium.sensitivity / 12.2, rel=RELATIVE_TOLERANCE)


def test_inputs_that_vary_with_time_have_their_last_value():
    scene = scene_at_speed(PORTER, speed=12.2, angle="equilibrium")
    ramp = parse_scene_document(governor_document(spindle={"speed": [[0.0, 11.0], [1.0, 12.2]]}))
    assert gm.linearise(ramp).eigenvalues == pytest.approx(gm.linearise(scene).eigenvalues, rel=RELATIVE_TOLERANCE)
    assert gm.linearise(scene, "12.2 rad/s").readings == pytest.approx(gm.linearise(scene).readings)


def custom_scene(**tables):
    """A mechanism one metre large on two points of the ground, A and B."""
    return parse_scene_document(custom_document(ground={"A": [0, 0], "B": [1, 0]}, size="1 m", **tables))


def shaft_scene(moment="3 N m", *, offset=0.0, start: Mapping[str, float] = {"angle_rate": 1.0}, **tables):
    return custom_scene(
        body=[{"name": "shaft", "mass": "2 kg", "inertia": "0.5 kg m^2", "points": {"P": [offset, 0]}}],
        joint=[pin("ground.A", "shaft.P")],
        force=[
            between("torsion_damper", "ground", "shaft", damping=0.2),
            {"type": "torque", "name": "drive", "body": "shaft", "moment": moment},
        ],
        readings={"angle": {"angle": "shaft"}},
        start=start,
        **tables,
    )


@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_steady_rotation_of_a_shaft(offset):
    """Speed torque / damping and eigenvalue -damping / inertia about the pin, also if the mass centre turns about it."""
    found = gm.linearise(shaft_scene(offset=offset))
    assert found.rates["angle"] == pytest.approx(15.0, rel=1e-13)
    assert "angle" not in found.readings
    assert found.eigenvalues == pytest.approx([-0.2 / (0.5 + 2 * offset**2)], rel=RELATIVE_TOLERANCE)
    system = found.state_space(["drive", "force on angle"], ["rate of angle"])
    assert system.frequency_response([0.0])[0, 0] == pytest.approx([5.0, 5.0], rel=RELATIVE_TOLERANCE)
    with pytest.raises(gm.MechanismError, match="no output 'angle'"):
        found.state_space(["drive"], ["angle"])


def test_two_shafts_on_a_torsion_spring():
    """Their common rotation is removed; the twist oscillates with k (1/I1 + 1/I2), and the momentum stays."""
    shafts = {"one": (0.5, 0, "A"), "two": (0.3, 1, "B")}
    scene = custom_scene(
        body=[{"name": name, "mass": "2 kg", "inertia": inertia, "at": [x, 0]} for name, (inertia, x, _) in shafts.items()],
        joint=[pin(f"ground.{point}", f"{name}.centre") for name, (_, _, point) in shafts.items()],
        force=[between("torsion_spring", "one", "two", stiffness="30 N m/rad")],
        readings={"first": {"angle": "one"}, "twist": {"angle": "two", "against": "one"}},
        start={"first_rate": 4.0, "twist_rate": 0.0},
    )
    found = gm.linearise(scene)
    assert np.sort(found.eigenvalues.imag) == pytest.approx(
        math.sqrt(30 * (1 / 0.5 + 1 / 0.3)) * np.array([-1, 0, 1]), rel=RELATIVE_TOLERANCE
    )
    assert found.readings["twist"] == pytest.approx(0.0, abs=1e-14)
    assert found.rates["first"] == pytest.approx(4.0, rel=1e-14)
    assert found.stability is Stability.UNDAMPED


def oscillator(**effects):
    """A block of 2 kg on a slide, with a spring and a damper."""
    return custom_scene(
        body=[{"name": "block", "mass": "2 kg", "turns": False, "at": [0.4, 0]}],
        joint=[between("slider", "ground.A", "block.centre", angle=0.0)],
        force=[
            between("spring", "ground.A", "block.centre", stiffness=50.0, free_length=0.4),
            between("damper", "ground.A", "block.centre", damping=3.0),
        ],
        readings={"x": {"x": "block.centre"}},
        start={"x": 0.5},
        effects=effects,
    )


def test_oscillator():
    """m x'' + c x' + k x = F: eigenvalues and frequency response in closed form."""
    found = gm.linearise(oscillator())
    mass, damping, stiffness = 2.0, 3.0, 50.0
    assert found.modes[0].natural_frequency == pytest.approx(math.sqrt(stiffness / mass), rel=RELATIVE_TOLERANCE)
    assert found.modes[0].damping_ratio == pytest.approx(damping / (2 * math.sqrt(mass * stiffness)), rel=RELATIVE_TOLERANCE)
    frequencies = np.array([0.0, 3.0, 5.0, 40.0])
    expected = 1 / (stiffness - mass * frequencies**2 + 1j * damping * frequencies)
    response = found.state_space(["force on x"], ["x", "rate of x"]).frequency_response(frequencies)[:, :, 0]
    assert response[:, 0] == pytest.approx(expected, rel=RELATIVE_TOLERANCE)
    assert response[:, 1] == pytest.approx(1j * frequencies * expected, rel=RELATIVE_TOLERANCE)
    with pytest.raises(gm.MechanismError, match="no input 'force on y'"):
        found.state_space(["force on y"], ["x"])


def test_effects_without_a_linear_law_are_named():
    effects = {"dashpot": {"x": {"quadratic": 5.0}}, "dry_friction": {"x": 1.0}, "stops": {"x": [0.1, 0.9]}}
    found, bare = gm.linearise(oscillator(**effects)), gm.linearise(oscillator())
    assert found.eigenvalues == pytest.approx(bare.eigenvalues, rel=RELATIVE_TOLERANCE)
    assert any("dry friction on x is left out" in note for note in found.notes)
    assert any("quadratic damping" in note for note in found.notes)
    with pytest.raises(gm.MechanismError, match="at or beyond a stop"):
        gm.linearise(oscillator(stops={"x": [0.45, 0.9]}))


@pytest.mark.parametrize(("free_value", "stiffness"), [(0.3, 150.0), (0.45, 50.0)])
def test_a_spring_that_only_pulls(free_value, stiffness):
    """Beside the spring of 50 N/m it counts where it is taut."""
    found = gm.linearise(oscillator(spring={"x": {"rate": 100.0, "zero": free_value, "one_sided": True}}))
    assert found.modes[0].natural_frequency == pytest.approx(math.sqrt(stiffness / 2.0), rel=RELATIVE_TOLERANCE)


def test_a_spring_that_is_just_slack():
    with pytest.raises(gm.MechanismError, match="just slack at the equilibrium"):
        gm.linearise(oscillator(spring={"x": {"rate": 100.0, "zero": 0.4, "one_sided": True}}))


def test_a_load_that_follows_a_reading_with_a_lag():
    """I x'' + c x' + k / (1 + tau s) x = 0 has three eigenvalues; without damper the lag would make it grow."""
    moment = {"reading": "angle", "gain": "-30 N m/rad", "about": 0.0, "lag": "2 ms"}
    found = gm.linearise(shaft_scene(moment, start={"angle": 0.1}))
    expected = np.roots([0.5 * 0.002, 0.5 + 0.2 * 0.002, 0.2, 30.0])
    assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex(expected), rel=RELATIVE_TOLERANCE)
    assert found.readings["angle"] == pytest.approx(0.0, abs=1e-13)


def test_a_load_by_a_table_counts_with_its_slope():
    def moment(middle: str):
        return {"reading": "angle", "table": [["-1 rad", "40 N m"], ["-0.2 rad", middle], ["1 rad", "-4 N m"]]}

    found = gm.linearise(shaft_scene(moment("8 N m"), start={"angle": 0.1}))
    assert found.readings["angle"] == pytest.approx(0.6, rel=1e-13)
    assert found.modes[0].natural_frequency == pytest.approx(math.sqrt(10 / 0.5), rel=RELATIVE_TOLERANCE)
    with pytest.raises(gm.MechanismError, match="at a kink of a table"):
        gm.linearise(shaft_scene(moment("0 N m"), start={"angle": 0.1}))


def watt_engine(damping: float) -> WattEngine:
    """The shipped engine, scaled, in the steady state under its last load of 600 N m."""
    arm = {"arm": 0.3, "ball_mass": 5.0, "arm_damping": damping, "ratio": 2.0}
    return scale_engine(**arm, engine_inertia=100.0, torque_gain=2000.0, equilibrium_lift=0.54 - 600 / 2000)


def test_governed_engine():
    """Engine and governor turn steadily; eigenvalues and the limit of hunting are those of Pontryagin's equations."""
    scene = gm.load("watt_engine_hunting")
    found = gm.linearise(scene)
    engine = watt_engine(3.3)
    angle, speed = equilibrium(engine)
    unit = scaled_time_unit(arm=0.3)
    assert found.readings["governor.arm_angle"] == pytest.approx(angle, rel=RELATIVE_TOLERANCE)
    assert found.rates["governor.spindle_speed"] == pytest.approx(speed / unit, rel=RELATIVE_TOLERANCE)
    sine, alpha = math.sin(angle), engine.control
    cubic = [1.0, engine.damping, sine**2 / engine.cosine, 2 * alpha * math.sqrt(engine.cosine) * sine**2]
    assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex(np.roots(cubic) / unit), rel=RELATIVE_TOLERANCE)
    assert found.stability is Stability.UNSTABLE
    assert gm.linearise("watt_engine_stable").stable
    limit = gm.stability_limit(scene, "part.governor.effects.dashpot.arm_angle", 3.0, "4 N m s/rad")
    scaled_limit = watt_engine(limit.value)
    assert scaled_limit.damping == pytest.approx(damping_limit(engine), rel=RELATIVE_TOLERANCE)
    assert limit.frequency * unit == pytest.approx(math.sqrt((1 - engine.cosine**2) / engine.cosine), rel=RELATIVE_TOLERANCE)
    assert (limit.onset is Onset.SOFT) == (first_lyapunov_coefficient(engine) < 0)


def test_haugs_governor():
    """A free spindle with a reaction and a torque that falls with the collar; numbers computed with 40 digits."""
    document = dict(gm.load("haug_governor").document)
    document["spindle"] = {**document["spindle"], "torque": document["spindle"]["torque"][:1]}  # without the load
    scene = parse_scene_document(document)
    found = gm.linearise(scene)
    pair, real = haug_governor.EIGENVALUES
    # The rod's length is given to 5 digits, so that the height of the equilibrium is off by 4e-17; speeds follow to 1e-12.
    assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex([pair, np.conj(pair), real]), rel=1e-9)
    assert found.rates["spindle_speed"] == pytest.approx(haug_governor.EQUILIBRIUM_SPEEDS[9.81], rel=1e-11)
    assert abs(found.rates["spindle_speed"] - haug_governor.PUBLISHED_EQUILIBRIUM_SPEEDS[9.81]) <= 0.5e-6  # its last digit
    damping = gm.stability_limit(scene, "force.damper.damping", 10.0, 30.0)
    assert damping.value == pytest.approx(haug_governor.CRITICAL_DAMPING, rel=1e-9)
    assert damping.frequency == pytest.approx(haug_governor.CRITICAL_FREQUENCY, rel=1e-9)
    gain = gm.stability_limit(scene, "spindle.torque.1.gain", "-7500 N", "-15000 N")
    assert gain.value == pytest.approx(-haug_governor.CRITICAL_GAIN, rel=1e-9)
    assert not gain.stable_below


def pendulum_on_a_spring():
    return custom_scene(
        body=[{"name": "rod", "mass": "2 kg", "inertia": "0.1 kg m^2", "angle": "90 deg", "at": [0, 0.5], "points": {"foot": [-0.5, 0]}}],
        joint=[pin("ground.A", "rod.foot")],
        force=[
            between("torsion_spring", "ground", "rod", name="spring", stiffness=12.0, free_angle="90 deg"),
            between("torsion_damper", "ground", "rod", name="damper", damping=0.5),
        ],
        readings={"angle": {"angle": "rod"}},
        effects={"gravity": True},
        start={"angle": "90 deg"},
    )


def test_limit_of_an_inverted_pendulum():
    """It stands upright from a spring of m g l on, where it begins to fall without oscillation."""
    scene = pendulum_on_a_spring()
    limit = gm.stability_limit(scene, "force.spring.stiffness", 9.5, "12 N m/rad")
    assert limit.value == pytest.approx(2 * 9.81 * 0.5, rel=RELATIVE_TOLERANCE)
    assert limit.frequency == 0.0
    assert not limit.stable_below
    assert limit.onset is Onset.UNKNOWN
    with pytest.raises(gm.MechanismError, match=r"no limit of stability lies between .* stable at 11 .* stable at 12"):
        gm.stability_limit(scene, "force.spring.stiffness", 11.0, 12.0)
    with pytest.raises(gm.MechanismError, match="KEY=LOW:HIGH"):
        report_linearisation(scene, None, "force.spring.stiffness=9.5")


def test_report_of_a_limit():
    scene = pendulum_on_a_spring()
    result = report_linearisation(scene, None, "force.spring.stiffness=9.5:12 N m/rad")
    assert "stable above 9.81 N m/rad; at the limit the motion diverges without oscillation" in str(result.result)
    assert json.loads(format_json(result.result.as_json()))["limit"]["value"] == pytest.approx(9.81, rel=RELATIVE_TOLERANCE)


def test_report_of_all_equilibria():
    """Rising and falling branch at one speed: one equilibrium is stable, the other diverges."""
    scene = gm.load("watt_improved")
    result = report_linearisation(scene, 6.4, None)
    report = json.loads(format_json(result.result.as_json()))
    assert [row["stability"] for row in report["linearisations"]] == ["unstable", "stable"]
    assert "damping ratio" in str(result.result)
    for row, point in zip(report["linearisations"], gm.equilibria(scene, 6.4), strict=True):
        # The product of the eigenvalues does not depend on damping: K / I.
        product = np.prod([abs(complex(*mode["eigenvalue"])) ** (2 if mode["eigenvalue"][1] else 1) for mode in row["modes"]])
        assert product == pytest.approx(point.frequency**2 + point.divergence_rate**2, rel=RELATIVE_TOLERANCE)


def test_an_astatic_governor_is_neutral():
    assert gm.linearise("parabolic").stability is Stability.NEUTRAL


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("slider_crank", "a drive turns or moves the mechanism all the time"),
        ("porter_cyclic", "the spindle speed fluctuates"),
        ("car_axis_like", "a drive turns or moves the mechanism all the time"),
        ("slider_crank_torque", "no steady state was found near the start"),
        ("watt_improved", "it has equilibria at speeds from"),
    ],
)
def test_refusals(scene, message):
    with pytest.raises(gm.MechanismError, match=message):
        gm.linearise(scene)


def test_a_turning_crank_under_gravity_is_periodic():
    scene = shaft_scene(offset=0.3, start={"angle_rate": 20.0}, effects={"gravity": True})
    with pytest.raises(gm.MechanismError, match=r"the steady state is periodic: shaft\.angle turns"):
        gm.linearise(scene)


def test_a_free_spindle_under_a_constant_torque_has_no_steady_state():
    scene = parse_scene_document(governor_document(spindle={"inertia": 0.5, "start_speed": 12.0, "torque": 1.0}))
    with pytest.raises(gm.MechanismError, match="no steady state was found"):
        gm.linearise(scene)
