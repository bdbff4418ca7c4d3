"""Pages in a browser: they play, scrub and show the run, with pointer, keys and touch, by day and on a dark ground.

`make test-browser` runs these; the default run of the tests does not collect them, because they need a browser.
"""

import time

import numpy as np
import pytest

import governor_mechanism as gm
from chromium import open_browser
from governor_mechanism.render.page.page_data import PLOT_SIZE, choose_panels
from governor_mechanism.render.page.views import Picture, show_run
from governor_mechanism.render.style import PAPER, darken, parse_rgb

SCENES = ("porter", "andrews_squeezer", "stephenson_arc_middle", "hartung_dubois", "stephenson_reversing", "slider_crank_torque")


@pytest.fixture(scope="module")
def runs():
    return {name: gm.run(name) for name in SCENES}


@pytest.fixture(scope="module")
def pages(runs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    return {name: gm.film(run, folder / f"{name}.html") for name, run in runs.items()}


@pytest.fixture(scope="module")
def browser():
    with open_browser() as tab:
        yield tab


@pytest.fixture
def tab(browser):
    """The browser, whose console has to stay empty and which must not ask anyone for anything."""
    browser.problems.clear()
    yield browser
    browser.evaluate("0")
    assert browser.problems == []


@pytest.fixture
def still(tab, pages):
    """The page of a Porter governor, which waits."""
    tab.open(pages["porter"], reduced_motion=True)
    return tab


def seek(tab, time):
    """Move the slider of time as a pointer does."""
    tab.evaluate(f"(() => {{ const s = document.getElementById('scrub'); s.value = {time}; s.dispatchEvent(new Event('input')); }})()")


def text_of(tab, name):
    return tab.evaluate(f"document.getElementById('{name}').textContent")


def shown_time(tab):
    return float(text_of(tab, "time").removesuffix(" s").replace("−", "-"))


def box_of(tab, selector):
    """Left, right, top and bottom of an element (CSS pixels)."""
    script = f"document.querySelector({selector!r}).getBoundingClientRect()"
    return tab.evaluate(f"(() => {{ const box = {script}; return [box.left, box.right, box.top, box.bottom]; }})()")


def middle_of(tab, selector):
    left, right, top, bottom = box_of(tab, selector)
    return (left + right) / 2, (top + bottom) / 2


def balls(tab, figure):
    """Centres (units of the picture) and radii of the balls of a figure, in the order in which they are drawn."""
    return tab.evaluate(
        f"[...document.querySelectorAll('.{figure} circle.role-ball')].map((ball) => {{"
        " const centre = new DOMPoint(ball.cx.baseVal.value, ball.cy.baseVal.value);"
        " const picture = ball.ownerSVGElement.getScreenCTM().inverse();"
        " const { x, y } = centre.matrixTransform(ball.getScreenCTM()).matrixTransform(picture);"
        " return [x, y, ball.r.baseVal.value]; })"
    )


def test_a_part_that_is_taken_turns_the_clock_along_its_path(tab, pages, runs):
    run = runs["slider_crank_torque"]
    first, last = 50, 70
    tab.open(pages["slider_crank_torque"], reduced_motion=True)
    seek(tab, run.times[first])
    limits = float(run.times[0]), float(run.times[-1])
    picture = show_run(run, None, limits, run.times[:1], 1.0).views[0].picture
    matrix = "document.querySelector('.plane > svg').getScreenCTM()"
    places = []
    for k in range(first, last + 1):
        x, y = picture.place(run.paths["crank pin"][k])
        places.append(tab.evaluate(f"(() => {{ const one = new DOMPoint({x}, {y}).matrixTransform({matrix}); return [one.x, one.y]; }})()"))
    tab.drag(*places)
    clock = "Number(document.getElementById('scrub').value)"
    assert tab.evaluate(clock) == pytest.approx(run.times[last], abs=3e-3)  # the hand moves in pixels
    tab.point("mouseMoved", places[-1][0] + 50.0, places[-1][1])  # it was let go
    assert tab.evaluate(clock) == pytest.approx(run.times[last], abs=3e-3)


def test_it_plays_in_true_time(tab, pages):
    tab.open(pages["porter"])
    first, began = shown_time(tab), time.monotonic()
    time.sleep(1.0)
    passed, elapsed = shown_time(tab) - first, time.monotonic() - began
    # A busy machine may leave out frames, and the clock of the page then waits; it never runs ahead.
    assert 0.3 < passed < elapsed + 0.1
    assert text_of(tab, "rate") == "true time"


def test_it_waits_where_motion_is_unwelcome(still):
    time.sleep(0.3)
    assert shown_time(still) == 0.0
    still.press(" ", " ")
    time.sleep(0.5)
    assert shown_time(still) > 0.0


@pytest.mark.parametrize("moment", [0.0, 1.237, 10.0])
def test_the_drawn_balls_stand_where_the_run_says(still, runs, moment):
    run = runs["porter"]
    seek(still, moment)
    drawing = show_run(run, None, (0.0, 10.0), np.array([moment]), 1.0)
    poses = drawing.parts[0].poses[0]
    picture = Picture(box=drawing.views[0].box)
    expected = sorted(picture.place(poses[:2, :2]).tolist())
    # Rounding to a unit for outline and track, and to a tenth of a unit for the attribute.
    np.testing.assert_allclose([ball[:2] for ball in sorted(balls(still, "plane"))], expected, atol=1.5)


def test_from_outside_the_ball_in_front_covers_the_spindle(still, runs):
    """The poses projected at the spindle angle, 120 rpm times the time, as seen from twelve times the reach of the machine."""
    run, moment = runs["porter"], 0.1
    seek(still, moment)
    view = show_run(run, None, (0.0, 10.0), np.array([moment]), 1.0).views[0]
    picture = Picture(box=view.box)
    angle, axis = 4 * np.pi * moment, float(picture.place(np.zeros(2))[0])
    radius = view.data.poses[0, 0, 0] * picture.scale
    width, height = picture.size
    eye = 12 * max(axis, width - axis)
    expected = []
    for side in (1.0, -1.0):
        depth = -side * radius * np.sin(angle)  # anticlockwise from above
        size = 1 / (1 - depth / eye)
        y = float(picture.place(view.data.poses[0, 0, :2])[1])
        expected.append([axis + side * radius * np.cos(angle) * size, height / 2 + (y - height / 2) * size])
    drawn = balls(still, "outside")
    # The ball behind is drawn first. Rounding of axis, track and spindle angle: a few units.
    np.testing.assert_allclose([ball[:2] for ball in drawn], expected, atol=4.0)
    assert drawn[0][2] < drawn[1][2]
    order = still.evaluate("[...document.querySelectorAll('.outside .role-ball, .outside .role-spindle')].map((e) => e.classList[0])")
    assert order[0] == order[-1] == "role-ball"
    assert "role-spindle" in order


def test_keys(still):
    still.press("End")
    assert shown_time(still) == 10.0
    still.press("ArrowLeft")
    assert 9.9 < shown_time(still) < 10.0
    still.press("Home")
    assert shown_time(still) == 0.0
    still.press("+", "+")
    assert text_of(still, "rate") == "sped up 2×"
    still.press("-", "-")
    still.press("-", "-")
    assert text_of(still, "rate") == "slowed 2×"
    still.press("f", "f")
    assert still.evaluate("document.getElementById('forces').checked") is True


def is_playing(tab):
    return tab.evaluate("document.getElementById('play').classList.contains('is-playing')")


def is_dark(tab):
    return tab.evaluate("document.getElementById('theme').getAttribute('aria-pressed')") == "true"


def test_the_space_bar_presses_a_button_reached_by_keys_and_else_plays(still):
    still.press("Tab")
    assert still.evaluate("document.activeElement.id") == "theme"
    still.press(" ", " ")
    assert (is_dark(still), is_playing(still)) == (True, False)
    still.click(*middle_of(still, "#theme"))
    assert (is_dark(still), is_playing(still)) == (False, False)
    still.press(" ", " ")  # the pointer has pressed that button: the space bar is for the film
    assert (is_dark(still), is_playing(still)) == (False, True)
    still.press(" ", " ")
    assert (is_dark(still), is_playing(still)) == (False, False)
    still.evaluate("document.getElementById('play').focus()")
    still.press("Tab")
    still.evaluate("document.getElementById('forces').focus()")
    was_checked = still.evaluate("document.getElementById('forces').checked")
    still.press(" ", " ")
    assert still.evaluate("document.getElementById('forces').checked") is not was_checked
    assert not is_playing(still)


def test_a_click_in_a_plot_goes_there_and_a_pointer_reads_it(still, runs):
    x, y = middle_of(still, ".plot .frame")
    still.point("mouseMoved", x, y)
    assert shown_time(still) == 0.0
    value = float(still.evaluate("document.querySelector('.plot .value').textContent").rstrip("°"))
    assert value == pytest.approx(np.degrees(np.interp(5.0, runs["porter"].times, runs["porter"].readings["arm_angle"])), abs=0.2)
    still.click(x, y)
    # A pixel of the plot is 10 s / 300.
    assert shown_time(still) == pytest.approx(5.0, abs=0.05)


@pytest.mark.parametrize("is_dark", [False, True])
def test_oscillations_too_narrow_for_a_plot_are_a_band_with_its_mean(tab, tmp_path, is_dark):
    """As the record of the panel has them: of speed (its mean is a curve), sleeve lift and throttle, not of the torque."""
    run = gm.run(gm.load("governed_engine").replace({"run.duration": "25 s"}), accuracy=1e-4, certify=False)
    panels, _ = choose_panels(show_run(run, None, (0.0, 25.0), run.times, 1.0))
    tab.open(gm.film(run, tmp_path / "engine.html"), width=1366, dark=is_dark, reduced_motion=True)
    script = "[...document.querySelectorAll('#plots .plot')].map((plot) => [...plot.querySelectorAll('.band, .curve')].map((path) => ["
    drawn = tab.evaluate(
        script + "path.getAttribute('class').split(' series')[0], path.getAttribute('d'), getComputedStyle(path).opacity]))"
    )
    assert [[kind for kind, *_ in paths] for paths in drawn] == [["band", "curve"], *2 * [["pale band", "curve"]], ["curve", "curve"]]
    assert [[float(opacity) for *_, opacity in paths] for paths in drawn] == [[1, 1], [0.35, 1], [0.35, 1], [1, 1]]
    for panel, paths in zip(panels[:3], drawn, strict=False):
        band = next(filter(None, panel.find_bands(*PLOT_SIZE)))
        values = np.concatenate([band.low, band.high[::-1]])
        expected = np.column_stack(
            [40.0 * np.concatenate([band.times, band.times[::-1]]), 300 * (panel.limits[1] - values) / np.ptp(panel.limits)]
        )
        points = np.array([point.split() for point in paths[0][1].strip("MZ").split("L")], dtype=float)
        np.testing.assert_allclose(points, expected, atol=0.6)  # of 1000 by 300, rounded to one
    assert tab.evaluate("document.querySelector('.time-axis').innerText").split("\n")[1] == "band: range within a turn"


def test_parts_have_names(still):
    still.point("mouseMoved", *middle_of(still, ".plane .role-pointer"))
    assert still.evaluate("document.getElementById('part-name').textContent") == "pointer"
    still.evaluate("[...document.querySelectorAll('#parts button')].find((b) => b.textContent === 'link').click()")
    assert still.evaluate("document.querySelectorAll('.plane .marked').length") == 2


def test_forces_are_drawn_to_scale(still, runs):
    assert still.evaluate("getComputedStyle(document.querySelector('.forces')).display") == "none"
    still.evaluate("document.getElementById('forces').click()")
    lengths = still.evaluate(
        "Object.fromEntries([...document.querySelectorAll('.forces g')].map((g) => {"
        " const [shaft, head] = g.querySelectorAll('path'); const a = shaft.getPointAtLength(0), b = head.getPointAtLength(0);"
        " return [g.dataset.name, Math.hypot(a.x - b.x, a.y - b.y)]; }))"
    )
    radius = runs["porter"].poses[0, 0, 0]
    expected = 20 * 9.81 / (5 * (4 * np.pi) ** 2 * radius)
    assert lengths["weight of sleeve"] / lengths["centrifugal force on right ball"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("width", [360, 768, 1280])
def test_nothing_sticks_out(tab, pages, name, width):
    tab.open(pages[name], width=width, height=740, reduced_motion=True)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    for left, right, top, bottom in (box_of(tab, selector) for selector in ("#play", "#scrub", "#speed")):
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= 740
        assert bottom - top >= 24  # the smallest target that the guidelines allow (WCAG 2.2, 2.5.8)
    left, right, _, _ = box_of(tab, ".plane svg")
    assert right - left > 180  # half the width of a telephone


def test_light_and_dark(tab, pages):
    for is_dark, paper in ((False, PAPER), (True, darken(PAPER))):
        tab.open(pages["porter"], dark=is_dark, reduced_motion=True)
        assert tab.evaluate("getComputedStyle(document.documentElement).backgroundColor") == f"rgb{parse_rgb(paper)}"
        tab.evaluate("document.getElementById('theme').click()")
        other = PAPER if is_dark else darken(PAPER)
        assert tab.evaluate("getComputedStyle(document.documentElement).backgroundColor") == f"rgb{parse_rgb(other)}"


def test_a_short_run_is_slowed_and_says_so(tab, pages):
    tab.open(pages["andrews_squeezer"], reduced_motion=True)
    assert text_of(tab, "rate") == "slowed 200×"
    seek(tab, 0.03)
    assert shown_time(tab) == 0.03
