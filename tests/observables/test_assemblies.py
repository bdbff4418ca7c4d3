"""All ways in which linkages close: their number, their order, and which of them is taken."""

import json
import math
import sys

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.observables.block_equations import count_paths, solve_bilinear_system
from governor_mechanism.observables.closed_configurations import enumerate_configurations
from refusing import refuses

MAX_GAP = 1e-10
"""Largest gap of a joint that counts as closed, length scales."""

JANSEN = {"b": 41.5, "c": 39.3, "f": 39.4, "g": 36.7, "j": 50.0, "k": 61.9, "m": 15.0}
"""Jansen's bars, mm; b and g carry triangles with the sides d, e and h, i."""


def triangle_point(base: float, left: float, right: float) -> tuple[str, str]:
    """Third corner of a triangle whose base lies along x, mm."""
    x = (base**2 + left**2 - right**2) / (2 * base)
    return f"{x} mm", f"{math.sqrt(left**2 - x**2)} mm"


def jansen(has_pen: bool = False, **angles: str) -> gm.MechanismBuilder:
    m = gm.Mechanism.build("Jansen leg")
    rods = {name: m.rod(name, length=f"{length} mm", mass=0.1, angle=angles.get(name)) for name, length in JANSEN.items()}
    left = rods["b"].point(*triangle_point(41.5, 40.1, 55.8), "left")
    foot = rods["g"].point(*triangle_point(36.7, 49.0, 65.7), "foot")
    m.pin(m.ground(0, 0), rods["m"].start)
    m.pin(m.ground("-38 mm", "-7.8 mm"), rods["b"].start, rods["c"].start)
    m.pin(rods["m"].end, rods["j"].start, rods["k"].start)
    m.pin(rods["j"].end, rods["b"].end)
    m.pin(left, rods["f"].start)
    m.pin(rods["k"].end, rods["c"].end, rods["g"].start)
    m.pin(rods["f"].end, rods["g"].end)
    m.reading("foot_y", y=foot)
    m.motor(rods["m"], rate="60 rpm")
    if has_pen:
        m.weld(foot, m.rod("pen", length="5 mm", mass=1e-3).start)
    return m


def six_bar() -> gm.MechanismBuilder:
    """Stephenson six-bar that is driven at a pin in its loop of five links."""
    m = gm.Mechanism.build("Stephenson six-bar")
    crank, rocker, link = (m.rod(name, length=length, mass=1.0) for name, length in (("crank", 2.2), ("rocker", 2.9), ("link", 2.5)))
    coupler = m.body("coupler", mass=1.0, inertia=0.1)
    m.pin(m.ground(0, 0), crank.start)
    m.pin(m.ground(2.9, 0), rocker.start)
    m.pin(m.ground([[0.0, -1.5], [1.0, -1.4]], 1.6), link.start)
    m.pin(crank.end, coupler.origin)
    m.pin(rocker.end, coupler.point(2.3, 0))
    m.pin(link.end, coupler.point(1.4, 2.9))
    return m


def four_bar() -> gm.MechanismBuilder:
    m = gm.Mechanism.build("Four-bar")
    crank, coupler, rocker = (m.rod(name, length=length, mass=1.0) for name, length in (("crank", 0.1), ("coupler", 0.3), ("rocker", 0.25)))
    m.pin(m.ground(0, 0), crank.start)
    m.pin(m.ground(0.3, 0), rocker.start)
    m.pin(crank.end, coupler.start)
    m.pin(coupler.end, rocker.end)
    m.motor(crank, rate="60 rpm")
    return m


def slider_crank() -> gm.MechanismBuilder:
    m = gm.Mechanism.build("Slider-crank")
    crank, rod = m.rod("crank", length=0.1, mass=1.0, angle="40 deg"), m.rod("rod", length=0.4, mass=1.0)
    piston = m.block("piston", mass=1.0)
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, rod.start)
    m.pin(rod.end, piston.centre)
    m.slider(m.ground(0, 0), piston.centre)
    m.motor(crank, rate="60 rpm")
    return m


def find_all(mechanism: gm.Mechanism, guess: np.ndarray | None = None):
    """All configurations of a mechanism whose drives hold it, from its own guess or another."""
    solver = PositionSolver(mechanism)
    solver.initial_guess = solver.initial_guess if guess is None else guess
    return enumerate_configurations(solver)


def driven(m: gm.MechanismBuilder) -> gm.Mechanism:
    return m.scene().mechanism


def random_poses(mechanism: gm.Mechanism, generator: np.random.Generator) -> np.ndarray:
    size = np.array([mechanism.length_scale, mechanism.length_scale, math.pi])
    return size * generator.uniform(-1.0, 1.0, size=(len(mechanism.bodies), 3)) * [body.moves for body in mechanism.bodies]


LINKAGES = {
    "four-bar": (four_bar, 2),
    "slider-crank": (slider_crank, 2),
    "six-bar": (six_bar, 6),
    "Jansen's leg": (lambda: jansen(m="0 deg"), 8),
}


@pytest.mark.parametrize("name", LINKAGES)
def test_all_ways_are_found_with_the_same_numbers_from_any_guess(name):
    build, count = LINKAGES[name]
    mechanism = driven(build())
    solver, found = PositionSolver(mechanism), find_all(mechanism)
    assert len(found.poses) == count
    assert found.complete
    for poses in found.poses:
        assert np.max(np.abs(solver.equations.residuals(poses))) < MAX_GAP * mechanism.length_scale
    differences = np.abs(found.poses[:, np.newaxis] - found.poses[np.newaxis]).max(axis=(2, 3)) + np.eye(count)
    assert np.min(differences) > 1e-3
    generator = np.random.default_rng(1)
    for _ in range(10):  # a hundred give the same
        other = find_all(mechanism, random_poses(mechanism, generator))
        assert np.allclose(other.poses, found.poses, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", LINKAGES)
def test_no_start_leads_to_a_way_that_is_not_listed(name):
    mechanism = driven(LINKAGES[name][0]())
    solver, found, generator, n_closed = PositionSolver(mechanism), find_all(mechanism), np.random.default_rng(2), 0
    for _ in range(40):
        try:
            poses = solver.solve({}, random_poses(mechanism, generator))
        except gm.MechanismError:
            continue
        n_closed += 1
        difference = found.poses - poses
        difference[..., 2] -= np.round(difference[..., 2] / math.tau) * math.tau
        assert np.min(np.abs(difference).max(axis=(1, 2))) < 1e-6
    assert n_closed > 10


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_bilinear_equations_have_all_their_solutions(n):
    """2n general equations in two groups of n unknowns have binomial(2n, n) solutions."""
    generator = np.random.default_rng(n)
    matrices = generator.normal(size=(2 * n, n + 1, n + 1)) + 1j * generator.normal(size=(2 * n, n + 1, n + 1))
    found = solve_bilinear_system(matrices)
    assert found.complete
    assert len(found.first) == count_paths(n)
    for first, second in zip(found.first, found.second, strict=True):
        values = np.einsum("kij,i,j->k", matrices, np.append(1.0, first), np.append(1.0, second))
        assert np.max(np.abs(values)) < 1e-8 * (1 + np.max(np.abs(first))) * (1 + np.max(np.abs(second)))


def mean_heights(poses: np.ndarray) -> np.ndarray:
    """Mean heights of the mass centres of the leg without its pen, m."""
    return poses[:, : len(JANSEN), 1].mean(axis=1)


@pytest.mark.parametrize("has_pen", [False, True])
def test_the_highest_of_several_ways_is_taken_and_the_run_says_so(has_pen):
    scene = jansen(has_pen, m="0 deg").scene(duration="0.1 s")
    found = find_all(scene.mechanism).poses
    highest = int(np.argmax(mean_heights(found)))
    assert np.allclose(found[highest], scene.mechanism.initial_guess, rtol=0, atol=1e-9)
    (note,) = gm.run(scene, times=[0.0], certify=False).notes
    assert note.startswith(f"the joints close in 8 ways: assembly {highest + 1}, the highest, is taken; assembly = 1 to 8 chooses another")
    assert gm.Scene.from_dict(scene.document) == scene


def test_the_highest_is_taken_of_several_ways_that_given_angles_leave():
    """The angle of the coupler decides between two of four ways; the dyad on it is above or below."""
    m = gm.Mechanism.build("Six-bar")
    crank = m.rod("crank", length=0.08, mass=0.5, angle="40 deg")
    coupler, rocker = m.rod("coupler", length=0.25, mass=1.0, angle="30 deg"), m.rod("rocker", length=0.2, mass=1.0)
    link, lever = m.rod("link", length=0.18, mass=0.5), m.rod("lever", length=0.15, mass=0.5)
    m.pin(m.ground(0, 0), crank.start)
    m.pin(crank.end, coupler.start)
    m.pin(coupler.end, rocker.end)
    m.pin(m.ground(0.26, 0), rocker.start)
    m.pin(coupler.point(0.12, 0.09), link.start)
    m.pin(link.end, lever.end)
    m.pin(m.ground(0.3, 0.2), lever.start)
    m.motor(crank, rate="60 rpm")
    ways = [way for way in m.assemblies().rows if abs(math.degrees(way.poses["coupler"][2]) - 36.459) < 1e-3]
    heights = [way.poses["link"][1] + way.poses["lever"][1] for way in ways]
    assert len(ways) == 2
    assert ways[int(np.argmax(heights))].is_taken


@pytest.mark.long  # a second for each list
@pytest.mark.parametrize("angles", [{}, {"long 1": "20 deg", "long 2": "-20 deg"}])
def test_of_several_ways_that_are_equally_near_none_that_is_folded_is_taken(angles):
    """The cell of Peaucellier's linkage also closes with both long bars, or its pen and its crank, on each other."""
    m = gm.Mechanism.build("Peaucellier")
    crank = m.rod("crank", length=0.1, mass=1.0, angle="20 deg")
    one, other = (m.rod(name, length=0.3, mass=1.0, angle=angles.get(name)) for name in ("long 1", "long 2"))
    short = [m.rod(f"short {k}", length=0.12, mass=0.5) for k in range(4)]
    short[2].point(0.12, name="pen")
    m.pin(m.ground(0, 0), one.start, other.start)
    m.pin(m.ground(0.1, 0), crank.start)
    m.pin(crank.end, short[0].start, short[1].start)
    m.pin(short[0].end, one.end, short[2].start)
    m.pin(short[1].end, other.end, short[3].start)
    m.pin(short[2].end, short[3].end)
    m.motor(crank, motion={"start": 0, "harmonics": [{"amplitude": "40 deg", "frequency": "1 Hz"}]})
    pen = gm.kinematics(m.scene()).paths["pen"]
    np.testing.assert_allclose(pen[:, 0], (0.3**2 - 0.12**2) / 0.2, rtol=1e-12)  # (long^2 - short^2) / (2 crank)
    assert np.ptp(pen[:, 1]) > 0.1


def test_a_chosen_way_is_taken_without_a_note_whatever_is_fixed_to_the_leg():
    for number in (1, 4, 7):
        poses = []
        for has_pen in (False, True):
            m = jansen(has_pen, m="0 deg")
            m.choose_assembly(number)
            scene = m.scene()
            assert not scene.mechanism.notes
            poses.append(np.array(scene.mechanism.initial_guess)[: len(JANSEN)])
        assert np.allclose(*poses, rtol=0, atol=1e-9)
        angles = {name: f"{math.degrees(pose[2])} deg" for name, pose in zip(JANSEN, poses[0].tolist(), strict=True)}
        given = jansen(**{name: angles[name] for name in ("m", "b", "c", "g")}).scene()  # what is given decides
        assert not given.mechanism.notes
        assert "assembly" not in given.document
        assert np.allclose(given.mechanism.initial_guess, poses[0], rtol=0, atol=1e-9)


def test_given_angles_that_no_way_has_take_the_nearest_and_a_part_of_them_leaves_several():
    rough = jansen(m="0 deg", b="80 deg", c="-80 deg", g="170 deg").scene()
    (note,) = rough.mechanism.notes
    assert ", the nearest to what is given, is taken" in note
    exact = math.degrees(rough.mechanism.initial_guess[list(JANSEN).index("b")][2])
    assert "8 ways" in jansen(m="0 deg", b=f"{exact} deg").scene().mechanism.notes[0]


def test_a_free_mechanism_says_at_which_angle_it_closes_in_several_ways():
    m = gm.Mechanism.build("Four-bar")
    crank, coupler = m.rod("crank", length=0.1, mass=1.0), m.rod("coupler", length=0.3, mass=1.0)
    rocker = m.rod("rocker", length=0.25, mass=1.0, angle="100 deg")
    m.pin(m.ground(0, 0), crank.start)
    m.pin(m.ground(0.3, 0), rocker.start)
    m.pin(crank.end, coupler.start)
    m.pin(coupler.end, rocker.end)
    scene = m.scene()
    assert scene.document["assembly"] == {"take": "highest", "at": ["rocker"]}
    (note,) = scene.mechanism.notes
    assert note.startswith("the joints close in 2 ways with rocker at 100 deg: ")
    assert gm.Scene.from_dict(scene.document) == scene


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"assembly": 7}, "there is no assembly 7 of 2: the joints close in 2 ways at the start; give 1 to 2"),
        ({"assembly": 0}, 'assembly must be a number from 1, "highest", or "nearest" to the given positions and angles; found 0'),
        (
            {"assembly": {"take": 1, "at": ["crnk"]}},
            "assembly.at names the unknown body 'crnk'; bodies are crank, coupler, rocker. Did you mean 'crank'?",
        ),
        ({"assembly": 1, "body.coupler.rod.length": 5.0}, "joint 'pin of coupler and rocker' stays open by"),
    ],
    ids=["too large", "zero", "body", "length"],
)
def test_a_wrong_choice_is_refused(changes, message):
    scene = four_bar().scene()
    with pytest.raises(gm.MechanismError) as refusal:
        scene.replace(changes)
    assert message in str(refusal.value)


def test_a_mechanism_that_is_free_is_refused_with_the_number_of_values_that_must_be_given():
    m = four_bar()
    document = {**m.document(), "assembly": 1}
    document["joint"] = [joint for joint in document["joint"] if joint["type"] != "driven_turn"]
    document["body"] = [{key: value for key, value in body.items() if key != "angle"} for body in document["body"]]
    refuses("leave 1 degree of freedom: one value more must be given", gm.Scene.from_dict, document)


def test_the_list_of_a_builder_that_of_its_file_and_the_command_agree(tmp_path, capsys):
    from governor_mechanism.cli.main import main

    m = jansen(m="0 deg")
    m.choose_assembly(4)
    listed, file = m.assemblies(), tmp_path / "leg.toml"
    file.write_text(m.scene().to_toml())
    read = gm.assemblies(file)
    assert np.allclose(listed.poses, read.poses, rtol=0, atol=1e-9)
    assert (listed.taken, read.taken, len(read), read.complete, read.methods) == (4, 4, 8, True, ("closed form",))
    assert read.nearest({name: angles[3] for name, angles in read.angles.items()}) == 4
    assert "the joints close in 8 ways; these are all, found in closed form" in str(read)
    sys.argv = ["governor-mechanism", "assemblies", str(file), "--set", "assembly=2", "--json", "--out", str(tmp_path)]
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    answer = json.loads(capsys.readouterr().out)
    assert (answer["count"], answer["taken"], answer["complete"]) == (8, 2, True)
    poses = [[one["poses"][name] for name in JANSEN] for one in answer["assemblies"]]
    assert np.allclose(poses, read.poses, rtol=0, atol=1e-9)
    assert [path.split("/")[-1] for path in answer["files"]] == ["leg_assemblies.png"]
    assert (tmp_path / "leg_assemblies.png").read_bytes().startswith(b"\x89PNG")


def test_a_sheet_has_a_drawing_for_each_assembly_and_names_the_one_that_is_taken():
    assemblies = driven_list()
    figure = assemblies.plot()
    assert len(figure.axes) == 2
    assert [panel.texts[0].get_text() for panel in figure.axes] == ["1", "2"]
    assert all(panel.patches and panel.lines for panel in figure.axes)
    assert f"the scene starts in {assemblies.taken}; assembly = number chooses one" in [text.get_text() for text in figure.texts]


def driven_list() -> gm.Assemblies:
    return gm.assemblies(slider_crank().scene())


def test_larger_groups_of_a_valve_gear_are_solved_by_homotopy():
    """Walschaerts' gear: radius rod, combination lever and valve rod form a group of 20 paths, of which few end in real ways."""
    found = gm.assemblies("walschaerts")
    assert found.complete
    assert found.methods == ("closed form", "homotopy of 20 paths")
    solver = PositionSolver(found.scene.mechanism)
    assert max(np.max(np.abs(solver.equations.residuals(poses))) for poses in found.poses) < MAX_GAP


def test_what_leaves_a_motion_is_refused_with_the_number_of_values():
    four = gm.Mechanism.build("Five-bar")
    first, second, third, fourth = (four.rod(name, length=1.0, mass=1.0) for name in ("first", "second", "third", "fourth"))
    four.pin(four.ground(0, 0), first.start)
    four.pin(four.ground(1, 0), fourth.start)
    four.pin(first.end, second.start)
    four.pin(second.end, third.start)
    four.pin(third.end, fourth.end)
    refuses("leave 2 degrees of freedom: 2 values more must be given", four.assemblies)
    refuses('no body "rockr" rotates here; those that do are crank, rod', driven_list().nearest, {"rockr": 1.0})
    refuses("'equilibrium' are not listed; give a number", gm.assemblies, "haug_governor")


def test_a_number_follows_its_branch_where_a_dimension_changes_the_order():
    m = six_bar()
    m.choose_assembly(4)
    first = m.scene()
    crank = [body.name for body in first.mechanism.bodies].index("crank")
    angles = []
    for height, number in ((0.0, 4), (0.1, 4), (0.2, 6)):  # the angle of the crank passes 0, the start of the order
        scene = first.replace({"ground.A": [0, height]})
        assert scene.document["assembly"] == number
        assert any("assembly 4 has the number 6" in note for note in scene.mechanism.notes) == (number == 6)
        assert gm.Scene.from_dict(scene.document) == scene
        angles.append(scene.mechanism.initial_guess[crank][2])
    assert np.all(np.abs(np.diff(angles)) < 0.06)
    assert first.replace({"ground.A": [0, 0.2], "assembly": 4}).document["assembly"] == 4


def test_a_carried_gear_takes_its_angle_from_the_arm_and_the_rod_in_every_assembly():
    scene = gm.load("sun_and_planet")
    found = gm.assemblies(scene)
    assert (len(found.poses), found.complete) == (2, True)
    names = [body.name for body in scene.mechanism.bodies]
    sun, arm, rod = (found.poses[:, names.index(name), 2] for name in ("sun", "arm", "rod"))
    # Equal wheels: sun - arm = arm - rod, up to the constant of the teeth and whole turns.
    tooth = math.remainder(sun[1] - 2 * arm[1] + rod[1] - (sun[0] - 2 * arm[0] + rod[0]), math.tau)
    assert abs(tooth) < 1e-9
    assert abs(math.remainder(rod[1] - rod[0], math.tau)) > 0.5


@pytest.mark.parametrize(("crank", "coupler", "rocker", "ground"), [(1.0, 3.0, 2.5, 3.2), (2.5, 1.0, 2.2, 3.2), (3.0, 1.5, 1.2, 3.2)])
def test_an_assembly_says_how_far_the_motor_turns(crank, coupler, rocker, ground):
    """By Grashof's rule a full turn, or as far as coupler and rocker reach when they lie in line."""
    lengths = (crank, coupler, rocker, ground)
    m = gm.Mechanism.build("Four-bar")
    rods = [m.rod(name, length=length, mass=1.0) for name, length in zip(("crank", "coupler", "rocker"), lengths[:3], strict=True)]
    m.pin(m.ground(0, 0), rods[0].start)
    m.pin(rods[0].end, rods[1].start)
    m.pin(rods[1].end, rods[2].end)
    m.pin(m.ground(ground, 0), rods[2].start)
    m.motor(rods[0], rate="10 rpm")
    is_crank = crank == min(lengths) and crank + max(lengths) < sum(lengths) - crank - max(lengths)
    cosine = (crank**2 + ground**2 - (coupler + rocker) ** 2) / (2 * crank * ground)
    m.given_document["body"][0]["angle"] = 0.9 * math.acos(max(cosine, 0.0))
    found = m.assemblies()
    assert len(found) == 2
    for words in found.travels:
        if is_crank:
            assert words == "full turns"
            continue
        ends = [float(word) for word in words.removesuffix(" deg").split(" to ")]
        assert max(ends) == pytest.approx(math.degrees(math.acos(cosine)), abs=0.06)
    assert "drive" in str(found)
    assert [one["drive"] for one in found.as_json()["assemblies"]] == list(found.travels)
