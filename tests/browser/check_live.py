"""The live page in a browser: real mouse and keyboard change the scene, and its readings are those of the same scene in Python."""

import asyncio
import json
import re
import socket
import threading
import time
from base64 import b64encode

import pytest
import uvicorn

import governor_mechanism as gm
from chromium import Tab, open_browser
from governor_mechanism.live.server import HOST, Workbench
from governor_mechanism.live.session import Session
from governor_mechanism.notebook.exploration import make_widget

SCENES = ("porter", "hartung_dubois", "stephenson_arc_middle", "jansen", "scott_russell")
N_CHANGES = 4
WAITING_TIME = 60.0


@pytest.fixture(scope="module")
def bench():
    """A server of the scenes, each for a short run."""
    shorter = {"run.duration": "0.5 s"}
    workbench = Workbench("token", {name: Session(gm.load(name).replace(shorter)) for name in SCENES})
    with socket.socket() as listener:
        listener.bind((HOST, 0))
        port = listener.getsockname()[1]
        server = uvicorn.Server(uvicorn.Config(workbench.make_app(port), log_level="error", ws="websockets-sansio"))
        thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listener])))
        thread.start()
        yield workbench, f"http://{HOST}:{port}/token/"
        server.should_exit = True
        thread.join(WAITING_TIME)


@pytest.fixture(scope="module")
def tab():
    with open_browser() as one:
        one.allowed_addresses = ("http://127.0.0.1", "ws://127.0.0.1", "file:", "data:", "about:")
        yield one


def wait_for(tab: Tab, session: Session) -> None:
    """Wait until the page shows the newest state."""
    deadline = time.monotonic() + WAITING_TIME
    while tab.evaluate("Number(document.documentElement?.dataset.number ?? -1)") < session.solve().number:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def place_of(tab: Tab, selector: str) -> tuple[float, float]:
    """Middle of an element, which is scrolled into view."""
    script = (
        f"(() => {{ const one = document.querySelector({selector!r}); one.scrollIntoView({{ block: 'center' }});"
        " const box = one.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()"
    )
    x, y = tab.evaluate(script)
    return x, y


def click(tab: Tab, selector: str) -> None:
    x, y = place_of(tab, selector)
    for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
        tab.point(kind, x, y)


def type_value(tab: Tab, key: str, value: float) -> None:
    """Type a number into the field of a quantity, and press Enter."""
    selector = f'[id="value of {key}"]'
    tab.evaluate(f"document.querySelector({selector!r}).closest('details').open = true")
    click(tab, selector)
    tab.evaluate(f"document.querySelector({selector!r}).select()")
    for letter in f"{value:.6g}":
        tab.press(letter, letter)
    tab.press("Enter", "\r")


def check_readings(tab: Tab, session: Session) -> None:
    """The readings on the page are those of the same scene."""
    run = gm.run(gm.Scene.from_dict(session.document))
    pairs = "[...document.querySelectorAll('#workbench td[data-reading]')].map((one) => [one.dataset.reading, Number(one.dataset.value)])"
    shown = tab.evaluate(f"Object.fromEntries({pairs})")
    assert shown
    for name, value in shown.items():
        assert value == pytest.approx(run.readings[name][-1], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_typed_values_are_answered_by_the_run_of_the_same_scene(tab, bench, name):
    workbench, address = bench
    session = workbench.sessions[name]
    tab.open(f"{address}{name}/", width=1366)
    wait_for(tab, session)
    quantities = [one for one in session.find_quantities().values() if one.group in ("dimensions", "spindle") and one.value]
    before = session.document
    for k, quantity in enumerate(quantities[:N_CHANGES]):
        type_value(tab, quantity.key, quantity.value * (1.003 if k % 2 else 0.997))
        deadline = time.monotonic() + WAITING_TIME
        while session.document == before:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        before = session.document
        wait_for(tab, session)
        if not session.solve().problem:
            check_readings(tab, session)
    tab.command("Input.dispatchKeyEvent", type="keyDown", key="z", modifiers=2)
    tab.command("Input.dispatchKeyEvent", type="keyUp", key="z", modifiers=2)
    while session.document == before:
        time.sleep(0.02)
    wait_for(tab, session)
    check_readings(tab, session)
    assert not tab.problems


def test_a_dragged_pivot_moves_its_dimensions_and_an_arrow_key_too(tab, bench):
    workbench, address = bench
    session = workbench.sessions["jansen"]
    session.reset()
    tab.open(f"{address}jansen/", width=1366)
    wait_for(tab, session)
    values = {key: one.value for key, one in session.find_quantities().items()}
    x, y = place_of(tab, '[data-grip="pivot B"]')
    tab.point("mouseMoved", x, y)
    tab.point("mousePressed", x, y)
    for step in range(1, 6):
        tab.point("mouseMoved", x - 2 * step, y + step)
        time.sleep(0.05)
    tab.point("mouseReleased", x - 10, y + 5)
    deadline = time.monotonic() + WAITING_TIME
    while session.find_quantities()["dimensions.down"].value == values["dimensions.down"]:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    time.sleep(0.5)
    wait_for(tab, session)
    moved = {key: one.value for key, one in session.find_quantities().items()}
    assert {key for key in moved if moved[key] != values[key]} == {"dimensions.across", "dimensions.down"}
    across, down = (moved[f"dimensions.{key}"] - values[f"dimensions.{key}"] for key in ("across", "down"))
    assert across == pytest.approx(2 * down, rel=0.02)  # the hand moved by (-10, 5) pixels
    check_readings(tab, session)
    tab.evaluate("document.querySelector('[data-grip=\"pivot B\"]').focus()")
    tab.press("ArrowLeft")
    while session.find_quantities()["dimensions.across"].value == moved["dimensions.across"]:
        assert time.monotonic() < deadline + WAITING_TIME
        time.sleep(0.02)
    wait_for(tab, session)
    assert tab.evaluate("document.activeElement.dataset.grip") == "pivot B"  # also after the drawing was made again
    assert not tab.problems


def test_an_impossible_length_is_a_sentence_that_a_reader_hears(tab, bench):
    workbench, address = bench
    session = workbench.sessions["jansen"]
    session.reset()
    tab.open(f"{address}jansen/", width=390)
    wait_for(tab, session)
    type_value(tab, "dimensions.j", 300.0)
    deadline = time.monotonic() + WAITING_TIME
    while not re.search("stays open", tab.evaluate("document.querySelector('#workbench [role=status]').textContent")):
        assert time.monotonic() < deadline
        time.sleep(0.02)
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
    before, deadline = session.document, time.monotonic() + WAITING_TIME
    while session.document == before:  # the keyboard walks through the frame until it meets the only slider
        assert time.monotonic() < deadline
        for text in tab.evaluate("window.outbox.splice(0)"):
            widget.hear(widget, text, [])
        while widget.sent:
            tab.evaluate(f"window.tell({json.dumps(widget.sent.pop(0))})")
        tab.evaluate("document.activeElement === document.querySelector('iframe') || document.querySelector('iframe').focus()")
        tab.press("Tab")
        tab.press("ArrowRight")
        time.sleep(0.05)
    assert 1.0 < session.find_quantities()["dimensions.crank"].value < 1.02
    assert not tab.problems
