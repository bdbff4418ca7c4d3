"""Every number on the pages that answer a question, computed again: by a formula written here, and by the package."""

import math
import re

import numpy as np
import pytest

import governor_mechanism as gm
from documentation_pages import ROOT, load_script
from governor_mechanism.scenes.library import shipped_scenes

FOLDER = ROOT / "docs" / "questions"
YEARS = {"1853", "1864", "1877"}
RPM = 30.0 / math.pi
GRAVITY = 9.81


scenes = load_script(FOLDER / "question_scenes.py")


def numbers_of(name):
    """All numbers that a reader sees on a page, without those of links, code and HTML."""
    text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    text = re.sub(r"`[^`]*`|<[^>]*>|\]\([^)]*\)", " ", text)
    return set(re.findall(r"(?<![\w.])\d+(?:\.\d+)?", text)) - YEARS


def check(name, shown):
    """Each number of the page is one of those that were computed, as it is rounded there, and each of these is there."""
    assert numbers_of(name) == set(shown)


@pytest.mark.long
def test_hunting():
    """The product of dashpot and flywheel is nearly the same at both borders; the characteristic polynomial is tested with the machine."""
    engine = gm.load("governed_engine_mean_torque")
    half = engine.replace({"part.engine.dimensions.inertia": "1600 kg m^2"})
    border = gm.stability_limit(engine, scenes.DASHPOT, "5 N s/m", "100 N s/m")
    lighter = gm.stability_limit(half, scenes.DASHPOT, "5 N s/m", "100 N s/m")
    assert engine.parts[0].dimensions["inertia"] == 800.0
    assert 2.0 * lighter.value == pytest.approx(border.value, rel=0.005)
    speeds = {name: gm.run(scenes.SCENES[name]()).readings["engine.shaft_speed"] for name in ("question_hunting", "question_settling")}
    assert np.ptp(speeds["question_hunting"][-60:]) > 4.0 * np.ptp(speeds["question_hunting"][-400:-340])
    assert np.ptp(speeds["question_settling"][-60:]) < 1e-6
    computed = {f"{border.value:.1f}", f"{lighter.value:.2f}", f"{border.frequency:.2f}", f"{math.tau / border.frequency:.2f}"}
    check("hunting", computed | {f"{speeds['question_settling'][-1] * RPM:.1f}", "800", "1600", "10", "60"})


def test_friction():
    """Equal arms and links: R adds to, or takes from, the weight of the sleeve and of a ball."""
    scene = gm.load("porter_dry_friction")
    size = scene.part.dimensions
    alpha = math.radians(30.0)
    weight = (size["ball_mass"] + size["sleeve_mass"]) * GRAVITY
    part = 40.0 / weight
    rest = math.sqrt(weight / size["ball_mass"] * math.tan(alpha) / (size["offset"] + size["arm"] * math.sin(alpha)))
    rising, falling = rest * math.sqrt(1.0 + part), rest * math.sqrt(1.0 - part)
    band = gm.insensitivity_band(scene, over=[alpha], resistance=40.0)
    assert (band.falling_speed[0], band.rising_speed[0]) == pytest.approx((falling, rising), rel=1e-10)
    share = (rising - falling) / rest
    computed = {f"{speed * RPM:.1f}" for speed in (rest, rising, falling)} | {f"{100 * share:.1f}", f"{100 * part:.1f}", f"{weight:.2f}"}
    check("friction", computed | {f"{size['ball_mass']:g}", f"{size['sleeve_mass']:g}", "30", "40"})


def test_jump():
    """The speed curve sqrt(g tan a / (l sin a - e)) is lowest where sin(a)^3 = e / l."""
    size = gm.load("watt_improved").part.dimensions
    offset, arm = -size["offset"], size["arm"]
    fold = math.asin(math.cbrt(offset / arm)) if hasattr(math, "cbrt") else math.asin((offset / arm) ** (1 / 3))

    def speed(angle):
        return math.sqrt(GRAVITY * math.tan(angle) / (arm * math.sin(angle) - offset))

    (found,) = gm.speed_curve("watt_improved").folds
    assert found == pytest.approx((fold, speed(fold)), rel=1e-9)
    low, high = math.radians(25.0), math.radians(40.0)
    assert speed(low) == pytest.approx(speed(high), rel=1e-10)  # so the sleeve rests on either stop at one speed
    run = gm.run("watt_improved")
    assert run.events[0].time == pytest.approx((speed(low) - 6.40) / 0.004, abs=1e-4)
    computed = {f"{math.degrees(fold):.2f}", f"{speed(fold) * RPM:.2f}", f"{speed(low) * RPM:.2f}", f"{offset / arm:.3f}"}
    check("jump", computed | {f"{1000 * offset:.1f}", f"{1000 * arm:g}", "25", "40"})


def test_lead():
    """The exact events of the crank end, from the triangle of eccentric and rod, and of crank and connecting rod."""
    rows = {}
    for lead in (0.0, 6.0, 12.0):
        advance = math.asin((24.0 + lead) / 60.0)

        def valve(angle, advance=advance):  # distance of the valve from the shaft, mm; the eccentric is 90 degrees and the advance ahead
            across = math.pi / 2 + angle + advance
            return 60.0 * -math.cos(across) + math.sqrt(240.0**2 - (60.0 * math.sin(across)) ** 2)

        def stroke(angle):
            return (math.sqrt(1500.0**2 - (300.0 * math.sin(angle)) ** 2) - 300.0 * math.cos(angle) - 1200.0) / 600.0

        timing = {row.name: row for row in gm.valve_timing(scenes.valve_with_lead(lead)).rows}
        edge = valve(0.0) - lead  # with equal leads the port is open by the lead at the dead centre
        for event in ("admission", "cut-off"):
            assert valve(timing[f"crank end {event}"].simulated) == pytest.approx(edge, abs=1e-6)
        rows[lead] = (
            math.degrees(advance),
            -math.degrees(math.remainder(timing["crank end admission"].simulated, math.tau)),
            100.0 * timing["crank end cut-off"].simulated_stroke,
            100.0 * timing["crank end compression"].simulated_stroke,
        )
        for event in ("cut-off", "compression"):
            found = timing[f"crank end {event}"]
            assert found.simulated_stroke == pytest.approx(stroke(found.simulated), abs=1e-9)
    computed = {f"{abs(early):.2f}" for _, early, _, _ in rows.values()} | {f"{part:.1f}" for row in rows.values() for part in row[2:]}
    advances = {f"{row[0]:.4g}" for row in rows.values()}
    check("lead", computed | advances | {"60", "24", "0", "6", "12"})


def test_line():
    """The pen in the middle of the coupler, from two circles."""

    def stray_and_rise(degrees):
        pen = np.array([_pen(angle) for angle in np.radians(np.linspace(-degrees, degrees, 401))])
        return 1000.0 * np.ptp(pen, axis=0)

    (stray, rise), (small, _) = stray_and_rise(20.0), stray_and_rise(10.0)
    pen = gm.kinematics("watt_linkage", values=np.radians(np.linspace(-20.0, 20.0, 41))).paths["pen"]
    assert 1000.0 * np.ptp(pen, axis=0) == pytest.approx((stray, rise), rel=1e-9)
    assert stray / small == pytest.approx(2.0**5, rel=0.03)
    check("line", {f"{stray:.2f}", f"{rise:.0f}", f"{small:.3f}", f"{stray / small:.0f}", f"{2**5}", "1", "10", "20"})


def _pen(angle):
    """The middle of the coupler: arms of 1 m about (0, 0) and (2, 1), coupler of 1 m."""
    end = np.array([math.cos(angle), math.sin(angle)])
    way = np.array([2.0, 1.0]) - end
    distance = math.hypot(*way)
    aside = np.array([-way[1], way[0]]) / distance * math.sqrt(1.0 - distance**2 / 4.0)
    return (end + end + way / 2.0 + aside) / 2.0


def test_flywheel():
    """Inertia = work / (coefficient of fluctuation times mean speed squared); the speeds are those of the run."""
    design = gm.design_flywheel(load_pressure="closing", coefficient=0.02)
    work, speed = design.fluctuation.energy, 60.0 / RPM
    inertia = work / (0.02 * speed**2)
    assert design.inertia == pytest.approx(inertia, rel=1e-3)  # of the mean of both ends, and of time
    shaft = gm.run(scenes.engine_with_flywheel()).readings["shaft_speed"] * RPM
    light = gm.run(scenes.engine_with_flywheel(0.08)).readings["shaft_speed"] * RPM
    quarter = gm.design_flywheel(load_pressure="closing", coefficient=0.08)
    assert quarter.inertia == pytest.approx(design.inertia / 4.0, rel=1e-9)
    assert np.ptp(light) / np.ptp(shaft) == pytest.approx(4.0, rel=0.01)
    errata = (ROOT / "docs" / "errata" / "index.md").read_text(encoding="utf-8")
    assert "the flywheel, comes out 28 % too small" in errata
    ends = {f"{shaft.min():.1f}", f"{shaft.max():.1f}"}
    wheel = {f"{design.inertia:.0f}", f"{2 * design.inertia:.0f}", f"{design.inertia / 1.5**2:.0f}"}
    check("flywheel", ends | wheel | {f"{work:.0f}", "2", "1", "60", "1.5", "28"})


@pytest.mark.long
def test_the_drawings_are_those_of_their_script(tmp_path, monkeypatch):
    """Up to a tenth of a pixel, by which processors may differ."""
    drawings = load_script(FOLDER / "drawings.py")
    monkeypatch.setattr(drawings, "FOLDER", tmp_path)
    for draw in drawings.DRAWINGS:
        path = draw()
        texts = [folder.joinpath(path.name).read_text(encoding="utf-8") for folder in (tmp_path, FOLDER / "drawings")]
        made, kept = ([float(number) for number in re.findall(r"-?\d+\.\d", text)] for text in texts)
        assert made == pytest.approx(kept, abs=0.2), path.name
        words = [re.sub(r"-?\d+\.\d", "", text) for text in texts]
        assert words[0] == words[1], path.name


def test_the_pages_under_the_pointer_exist_and_their_scenes_load():
    shown = {name for path in FOLDER.glob("*.md") for name in re.findall(r'src="\.\./pages/(\w+)\.html"', path.read_text(encoding="utf-8"))}
    assert set(scenes.SCENES) <= shown
    assert shown <= set(scenes.SCENES) | set(shipped_scenes())
    for make_scene in scenes.SCENES.values():
        assert gm.run(make_scene(), times=[0.0, 0.01]).outcome.ok
