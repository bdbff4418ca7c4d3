"""The live page in a browser: real mouse and keyboard change the scene, and its readings are those of the same scene in Python."""

import json
import random
import re
import time
from base64 import b64encode
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from chromium import Tab, open_browser
from governor_mechanism.live.describing import show_whole_run
from governor_mechanism.live.server import HOST, Workbench
from governor_mechanism.live.session import Session
from governor_mechanism.notebook.exploration import make_widget
from workbench_server import serve

SCENES = ("porter", "hartung_dubois", "stephenson_arc_middle", "jansen", "governed_engine")
N_CHANGES = 20
WAITING_TIME = 60.0


@pytest.fixture(scope="module")
def bench():
    """A server of the scenes, each for a short run."""
    shorter = {"run.duration": "0.5 s"}
    workbench = Workbench("token", {name: Session(gm.load(name).replace(shorter)) for name in (*SCENES, "scott_russell")})
    with serve(workbench) as port:
        yield workbench, f"http://{HOST}:{port}/token/"


@pytest.fixture(scope="module")
def tab():
    with open_browser() as one:
        one.allowed_addresses = ("http://127.0.0.1", "ws://127.0.0.1", "file:", "data:", "about:")
        yield one


def wait_for(tab: Tab, session: Session) -> None:
    """Wait until the page shows the newest state."""
    shown = "Number(document.documentElement?.dataset.number ?? -1)"
    tab.wait_until(lambda: tab.evaluate(shown) >= session.solve().number)


def open_scene(tab: Tab, bench, name: str, **options: Any) -> Session:
    """Open the page of a scene as it was, and wait for it."""
    workbench, address = bench
    session: Session = workbench.sessions[name]
    session.reset()
    tab.open(f"{address}{name}/", **{"width": 1366, **options})
    wait_for(tab, session)
    return session


def place_of(tab: Tab, selector: str) -> tuple[float, float]:
    """Middle of an element, which is scrolled into view."""
    script = (
        f"(() => {{ const one = document.querySelector({selector!r}); one.scrollIntoView({{ block: 'center' }});"
        " const box = one.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()"
    )
    x, y = tab.evaluate(script)
    return x, y


def click(tab: Tab, selector: str) -> None:
    tab.click(*place_of(tab, selector))


def type_text(tab: Tab, text: str) -> None:
    """Press the keys of a text."""
    for letter in text:
        tab.press(letter, letter)


def type_value(tab: Tab, key: str, value: float) -> None:
    """Type a number into the field of a quantity, and press Enter."""
    selector = f'[id="value of {key}"]'
    tab.evaluate(f"document.querySelector({selector!r}).closest('details').open = true")
    click(tab, selector)
    tab.evaluate(f"document.querySelector({selector!r}).select()")
    type_text(tab, f"{value:.6g}")
    tab.press("Enter", "\r")


def check_readings(tab: Tab, session: Session) -> None:
    """The readings on the page are those of the same scene."""
    run = gm.run(gm.Scene.from_dict(session.document))
    pairs = "[...document.querySelectorAll('#workbench td[data-reading]')].map((one) => [one.dataset.reading, Number(one.dataset.value)])"
    shown = tab.evaluate(f"Object.fromEntries({pairs})")
    assert shown
    for name, value in shown.items():
        assert value == pytest.approx(run.readings[name][-1], rel=1e-12, abs=1e-12)


def move_slider(tab: Tab, key: str, steps: int) -> None:
    """Press an arrow key on the slider of a quantity."""
    row = f"document.getElementById('value of {key}').closest('.quantity')"
    tab.evaluate(f"{row}.closest('details').open = true; {row}.querySelector('input[type=range]').focus()")
    for _ in range(abs(steps)):
        tab.press("ArrowRight" if steps > 0 else "ArrowLeft")


def drag_slider(tab: Tab, key: str, shift: float) -> None:
    """Drag the thumb of the slider of a quantity by some pixels."""
    row = f"document.getElementById('value of {key}').closest('.quantity')"
    script = (
        f"(() => {{ const row = {row}; row.closest('details').open = true; const one = row.querySelector('input[type=range]');"
        " one.scrollIntoView({ block: 'center' }); const box = one.getBoundingClientRect(), thumb = 16;"
        " const share = (one.value - one.min) / (one.max - one.min);"
        " return [box.x + thumb / 2 + share * (box.width - thumb), box.y + box.height / 2]; })()"
    )
    x, y = tab.evaluate(script)
    tab.drag((x, y), (x + shift, y))


@pytest.mark.parametrize("name", SCENES)
def test_random_changes_are_answered_by_the_run_of_the_same_scene(tab, bench, name):
    session = open_scene(tab, bench, name)
    choice = random.Random(name)
    quantities = [one for one in session.find_quantities().values() if re.search("dimensions|spindle", one.key) and one.value]
    n_possible = 0
    for k in range(N_CHANGES):
        quantity, before = choice.choice(quantities), session.document
        value = session.find_quantities()[quantity.key].value
        match k % 4:
            case 0:
                type_value(tab, quantity.key, value * choice.choice([0.997, 1.003]))
            case 1:
                move_slider(tab, quantity.key, choice.choice([-1, 1]))
            case 2:
                drag_slider(tab, quantity.key, choice.choice([-2.0, 2.0]))
            case 3:  # back to where two changes before led
                tab.command("Input.dispatchKeyEvent", type="keyDown", key="z", modifiers=2)
                tab.command("Input.dispatchKeyEvent", type="keyUp", key="z", modifiers=2)
        tab.wait_until(lambda before=before: session.document != before)
        time.sleep(0.05)  # the end of a drag is a message of its own
        wait_for(tab, session)
        if not session.solve().problem:
            check_readings(tab, session)
            n_possible += 1
    assert n_possible > N_CHANGES // 2
    heard = tab.evaluate("document.querySelector('#workbench .unseen[role=status]').textContent")
    assert all(one["text"] in heard for one in session.describe(session.solve())["readings"])
    assert not tab.problems


def test_the_keyboard_reaches_and_does_all(tab, bench):
    session = open_scene(tab, bench, "scott_russell", reduced_motion=True)
    tab.evaluate("document.querySelectorAll('#workbench details').forEach((one) => { one.open = true; })")
    wanted = (
        "[...document.querySelectorAll('button, input, select, a[href], summary, [tabindex]')]"
        ".filter((one) => one.checkVisibility() && !one.disabled)"
    )
    tab.evaluate(f"window.wanted = new Set({wanted}); window.reached = new Set()")
    for _ in range(3 * tab.evaluate("window.wanted.size")):
        tab.press("Tab")
        tab.evaluate("window.reached.add(document.activeElement)")
    assert tab.evaluate("[...window.wanted].filter((one) => !window.reached.has(one) && one.isConnected).map((one) => one.outerHTML)") == []
    before = session.document
    tab.evaluate("document.getElementById('value of dimensions.crank').focus()")
    tab.evaluate("document.activeElement.select()")
    type_text(tab, "-1.1")
    assert tab.evaluate("document.activeElement.value") == "-1.1"  # no key of the clock is taken from what is typed
    for kind in 4 * ("keyDown", "keyUp"):
        tab.command("Input.dispatchKeyEvent", type=kind, key="Backspace", windowsVirtualKeyCode=8)
    type_text(tab, "1.1")
    tab.press("Enter", "\r")
    tab.wait_until(lambda: session.document != before)
    wait_for(tab, session)
    assert session.find_quantities()["dimensions.crank"].value == 1.1
    tab.evaluate("[...document.querySelectorAll('#workbench button')].find((one) => one.textContent === 'Undo').focus()")
    tab.press("Enter", "\r")
    tab.wait_until(lambda: session.document == before)
    assert not tab.problems


def test_a_telephone_in_the_dark_shows_all(tab, bench):
    open_scene(tab, bench, "porter", width=390, height=844, dark=True)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    light = "getComputedStyle(document.documentElement).backgroundColor.match(/\\d+/g).map(Number)"
    assert max(tab.evaluate(light)) < 80
    assert not tab.problems


def test_the_address_holds_the_changes_and_a_link_to_it_makes_them(tab, bench):
    workbench, address = bench
    session = workbench.sessions["scott_russell"]
    session.reset()
    tab.open("about:blank")
    tab.open(f"{address}scott_russell/#dimensions.crank=1.05", width=1366)
    tab.wait_until(lambda: session.find_quantities()["dimensions.crank"].value == 1.05)
    wait_for(tab, session)
    assert tab.evaluate("document.querySelector('.ghost-layer') !== null")
    session.reset()
    tab.wait_until("!location.hash")
    assert not tab.problems


def test_a_dragged_pivot_moves_its_dimensions_and_an_arrow_key_too(tab, bench):
    session = open_scene(tab, bench, "jansen")
    values = {key: one.value for key, one in session.find_quantities().items()}
    x, y = place_of(tab, '[data-grip="pivot B"]')
    tab.drag(*((x - 2 * step, y + step) for step in range(6)), pause=0.05)
    tab.wait_until(lambda: session.find_quantities()["dimensions.down"].value != values["dimensions.down"])
    time.sleep(0.5)
    wait_for(tab, session)
    moved = {key: one.value for key, one in session.find_quantities().items()}
    assert {key for key in moved if moved[key] != values[key]} == {"dimensions.across", "dimensions.down"}
    across, down = (moved[f"dimensions.{key}"] - values[f"dimensions.{key}"] for key in ("across", "down"))
    assert across == pytest.approx(2 * down, rel=0.02)  # the hand moved by (-10, 5) pixels
    check_readings(tab, session)
    tab.evaluate("document.querySelector('[data-grip=\"pivot B\"]').focus()")
    tab.press("ArrowLeft")
    tab.wait_until(lambda: session.find_quantities()["dimensions.across"].value != moved["dimensions.across"])
    wait_for(tab, session)
    assert tab.evaluate("document.activeElement.dataset.grip") == "pivot B"  # also after the drawing was made again
    assert not tab.problems


def place_in_window(tab: Tab, place) -> tuple[float, float]:
    """Where a place of the first picture is in the window."""
    script = f"new DOMPoint({place[0]}, {place[1]}).matrixTransform(document.querySelector('.plane > svg').getScreenCTM())"
    x, y = tab.evaluate(f"(() => {{ const one = {script}; return [one.x, one.y]; }})()")
    return x, y


def test_a_dragged_coupler_point_turns_a_driven_mechanism_along_its_motion(tab, bench):
    session = open_scene(tab, bench, "jansen", reduced_motion=True)
    run = session.run
    picture = show_whole_run(run)[0].views[0].picture
    tab.drag(*(place_in_window(tab, picture.place(run.paths["foot"][k])) for k in range(16)))
    shown = float(tab.evaluate("document.getElementById('scrub').value"))
    assert shown == pytest.approx(run.times[15], abs=2e-3)  # the hand moves in pixels
    assert session.find_changes() == {}
    assert not tab.problems


def test_a_pulled_sleeve_becomes_the_start_and_ends_at_its_dead_centre(tab, bench):
    session = open_scene(tab, bench, "porter", reduced_motion=True)
    picture = show_whole_run(session.run)[0].views[0].picture
    study = gm.kinematics("porter", "arm_angle", ["40 deg", "30 deg"])
    sleeve = [body.name for body in session.run.scene.mechanism.bodies].index("sleeve")
    before, after = (np.array(place_in_window(tab, picture.place(study.poses[k, sleeve, :2]))) for k in range(2))
    before += [12.0, 8.0]  # anywhere on the sleeve
    places = [(before[0], before[1] + share * (after[1] - before[1] + 8.0)) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
    document = session.document
    tab.point("mouseMoved", *before)
    tab.wait_until("document.documentElement.dataset.travel === 'start.arm_angle'")
    tab.drag(*places)
    tab.wait_until(lambda: session.document != document)
    time.sleep(0.1)
    assert session.find_quantities()["start.arm_angle"].value == pytest.approx(30.0, abs=0.4)  # the hand moves in pixels
    session.undo()
    assert session.document == document
    assert not tab.problems


def test_an_impossible_length_is_a_sentence_that_a_reader_hears(tab, bench):
    open_scene(tab, bench, "jansen", width=390)
    type_value(tab, "dimensions.j", 300.0)
    tab.wait_until("/stays open/.test(document.querySelector('#workbench [role=status]').textContent)")
    assert tab.evaluate("document.getElementById('stage').classList.contains('is-past')")
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert not tab.problems


NOTEBOOK = """<!doctype html><meta charset="utf-8"><body><div id="cell"></div><script type="module">
const page = await (await import("data:text/javascript;base64,%s")).default;
window.outbox = [];
const model = {
  get: (name) => window.fields[name],
  send: (text) => window.outbox.push(text),
  on: (name, hear) => { window.tell = hear; },
  off: () => {},
};
window.start = (fields) => { window.fields = fields; page.render({ model, el: document.getElementById("cell") }); };
</script>"""
"""What a notebook does with a widget: the fields of its model, and messages both ways."""


class Widgets:
    """Stands for the module anywidget."""

    class AnyWidget:
        def __init__(self, **fields):
            self.fields, self.sent, self.hear = fields, [], None

        def on_msg(self, hear):
            self.hear = hear

        def send(self, text):
            self.sent.append(text)


def test_the_page_lives_in_an_output_cell(tab, tmp_path):
    session = Session(gm.load("scott_russell").replace({"run.duration": "0.5 s"}), {"dimensions.crank": None})
    widget = make_widget(Widgets, session, "Scott Russell")
    path = tmp_path / "notebook.html"
    path.write_text(NOTEBOOK % b64encode(type(widget)._esm.encode()).decode(), encoding="utf-8")
    tab.open(path, width=1366, height=900)
    tab.evaluate(f"window.start({json.dumps(widget.fields)})")
    before = session.document

    def walk():  # the keyboard walks through the frame until it meets the only slider
        for text in tab.evaluate("window.outbox.splice(0)"):
            widget.hear(widget, text, [])
        while widget.sent:
            tab.evaluate(f"window.tell({json.dumps(widget.sent.pop(0))})")
        tab.evaluate("document.activeElement === document.querySelector('iframe') || document.querySelector('iframe').focus()")
        tab.press("Tab")
        tab.press("ArrowRight")
        return session.document != before

    tab.wait_until(walk)
    assert 1.0 < session.find_quantities()["dimensions.crank"].value < 1.02
    assert not tab.problems


def test_a_motion_goes_on_from_what_is_shown_and_takes_a_change_at_once(tab, bench):
    open_scene(tab, bench, "porter")
    button = "[...document.querySelectorAll('#workbench button')].find((one) => /Let it move|Back to the run/.test(one.textContent))"
    end = "Number(document.getElementById('scrub').max)"
    stop = tab.evaluate(end)
    tab.evaluate("(() => { const one = document.getElementById('speed'); one.value = one.max; one.dispatchEvent(new Event('input')); })()")
    tab.evaluate(f"{button}.click()")
    tab.wait_until(f"{end} >= {stop} + 0.2")  # the run is over, and the motion goes on
    type_value(tab, "spindle.speed", 125.0)
    tab.wait_until("/125/.test(document.querySelector('#workbench td[data-reading=spindle_speed]').textContent)")
    assert re.search("pieces add up to", tab.evaluate("document.querySelector('#workbench [role=status]').textContent"))
    tab.evaluate(f"{button}.click()")
    assert tab.evaluate(end) == stop
    assert not tab.problems
