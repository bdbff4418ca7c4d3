"""The built documentation in a browser, and its links: `make test-browser` runs these after `make docs`."""

import re
import threading
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote

import pytest

from chromium import open_browser

SITE = Path(__file__).parents[2] / "docs" / "_build" / "html"
INTERACTIVE = SITE / "pages"
"""Pages of runs, which check_page.py tries."""

PAGES = sorted(path for path in SITE.rglob("*.html") if INTERACTIVE not in path.parents and "_static" not in path.parts)
TELEPHONE = 360
"""Width of a small telephone (CSS pixels)."""
SEARCH_TIME = 10.0
"""Longest time (s) that a search takes."""
MAX_LAYOUT_SHIFT = 0.05
"""Largest sum of layout shifts of a page: half of what counts as good on the web."""
MAX_FIRST_LOAD = 1_500_000
"""Largest size (bytes) of what the gallery loads before one scrolls."""


class Links(HTMLParser):
    """Anchors of a page, and the targets of its links, pictures, scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors |= {values[name] for name in ("id", "name") if values.get(name)}
        self.targets += [values[name] for name in ("href", "src") if values.get(name)]


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files without a word."""

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(SITE))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()


@pytest.fixture(scope="module")
def tab(address):
    with open_browser() as browser:
        browser.allowed_addresses = (*browser.allowed_addresses, address)
        yield browser


@pytest.fixture(scope="module")
def links():
    return {path: Links(path.read_text(encoding="utf-8")) for path in PAGES}


def test_the_documentation_is_built():
    assert SITE / "index.html" in PAGES, "run make docs"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(SITE).as_posix())
def test_a_page_on_a_telephone(tab, address, path):
    """Without an error or a warning in the console, without a request that leaves the site, and no wider than the screen."""
    tab.problems.clear()
    tab.open(address + path.relative_to(SITE).as_posix(), width=TELEPHONE, height=740, reduced_motion=True)
    assert tab.evaluate("document.documentElement.scrollWidth") <= TELEPHONE
    assert tab.evaluate("[...document.images].filter((image) => image.complete && !image.naturalWidth).map((image) => image.src)") == []
    assert tab.problems == []


def test_every_link_leads_somewhere(links):
    broken = []
    for path, page in links.items():
        for target in page.targets:
            if ":" in target.partition("/")[0]:  # to another site, or data
                continue
            name, _, anchor = unquote(target).partition("#")
            goal = (path.parent / name.partition("?")[0]).resolve() if name else path
            goal = goal / "index.html" if goal.is_dir() else goal
            is_there = goal.is_file() and (not anchor or goal not in links or anchor in links[goal].anchors)
            broken += [] if is_there else [f"{path.relative_to(SITE)}: {target}"]
    assert broken == []


def test_nothing_comes_from_another_site(links):
    loaded = [target for page in links.values() for target in page.targets if target.startswith(("http:", "https:", "//"))]
    assert [target for target in loaded if target.endswith((".js", ".css", ".woff2", ".png", ".gif", ".svg"))] == []


@pytest.mark.parametrize(("word", "page"), [("Porter", "pendulum_governor"), ("Hartung", "hartung")])
def test_search_finds(tab, address, word, page):
    tab.open(f"{address}search.html?q={word}", reduced_motion=True)
    listed = "[...document.querySelectorAll('#search-results li a')].map((link) => link.getAttribute('href'))"
    tab.wait_until(f"{listed}.some((link) => link.includes('machines/{page}'))", SEARCH_TIME)


@pytest.mark.parametrize("dark", [False, True])
def test_formulas_are_drawn(tab, address, dark):
    """As elements of MathML with a size, in the colour of the text."""
    tab.open(f"{address}theory/statics.html", dark=dark, reduced_motion=True)
    assert tab.evaluate("[...document.querySelectorAll('math')].every((one) => one.getBoundingClientRect().width > 3)") is True
    colour = "getComputedStyle(document.querySelector('{}')).color"
    assert tab.evaluate(colour.format("math")) == tab.evaluate(colour.format("article p"))


def test_every_picture_has_its_size():
    """So that a page does not jump while they load."""
    without = []
    for path in PAGES:
        for picture in re.findall(r"<img [^>]*>", path.read_text(encoding="utf-8").partition("<article")[2].partition("</article>")[0]):
            without += [] if "width=" in picture else [f"{path.relative_to(SITE)}: {picture}"]
    assert without == []


SCROLL = """new Promise((done) => {
  const step = (y) => { scrollTo(0, y); y < 8000 ? setTimeout(step, 30, y + 400) : done(); };
  step(0);
})"""
SHIFTS = """new Promise((done) => {
  const add = (sum, one) => sum + (one.hadRecentInput ? 0 : one.value);
  new PerformanceObserver((list) => done(list.getEntries().reduce(add, 0))).observe({ type: "layout-shift", buffered: true });
  setTimeout(done, 300, 0);
})"""
"""Sum of the layout shifts so far; 0 if none was observed."""


@pytest.mark.parametrize("width", [390, 1366])
@pytest.mark.parametrize("page", ["gallery.html", "index.html", "_generated/examples/index.html", "machines/stephenson.html"])
def test_a_page_stands_still_while_it_loads_and_is_read(address, page, width):
    with open_browser() as tab:  # that has loaded nothing
        tab.allowed_addresses = (*tab.allowed_addresses, address)
        tab.open(address + page, width=width, height=800, reduced_motion=True)
        tab.evaluate(SCROLL)
        assert tab.evaluate(SHIFTS) < MAX_LAYOUT_SHIFT


def test_the_gallery_loads_little_at_first(tab, address):
    tab.open(address + "gallery.html", width=1366, height=800, reduced_motion=True)
    sizes = "performance.getEntries().filter((one) => one.encodedBodySize).map((one) => [one.name, one.encodedBodySize])"
    loaded = tab.evaluate(sizes)
    assert 100_000 < sum(size for _, size in loaded) < MAX_FIRST_LOAD, loaded
    assert not [name for name, _ in loaded if name.endswith(".gif")]


def test_a_film_runs_on_touch_and_the_choices_leave_what_fits(tab, address):
    tab.open(address + "gallery.html", width=390, height=800, reduced_motion=True)
    button = "document.querySelector('#scene-porter > button')"
    source = f"{button}.querySelector('img').getAttribute('src')"
    tab.evaluate(f"{button}.click()")
    assert tab.evaluate(source) == "pages/porter.gif"
    tab.evaluate(f"{button}.click()")
    assert tab.evaluate(source) == "pages/porter.webp"
    choose = """(() => {{
      const list = document.querySelector("[data-filter={}]");
      list.value = "{}";
      list.dispatchEvent(new Event("change", {{ bubbles: true }}));
    }})()"""
    tab.evaluate(choose.format("effect", "dry friction"))
    tab.evaluate(choose.format("machine", "pendulum governor"))
    shown = tab.evaluate("[...document.querySelectorAll('.scene')].filter((one) => one.offsetHeight).map((one) => one.id)")
    assert "scene-porter_dry_friction" in shown
    assert not {"scene-porter", "scene-geneva"} & set(shown)
    assert tab.evaluate("document.querySelector('.choices output').textContent") == f"{len(shown)} scenes"


def test_a_button_copies_a_command(tab, address):
    tab.open(address + "gallery.html", width=1366, height=800, reduced_motion=True)
    assert tab.evaluate("document.querySelector('#scene-porter pre + .copybtn, #scene-porter .copybtn') !== null") is True
    tab.open(address + "_generated/examples/linkages/four_bar.html", width=1366, height=800, reduced_motion=True)
    assert tab.evaluate("document.querySelector('article .highlight .copybtn') !== null") is True


SCRIPT = """
const controls = "button, input, select, textarea, a[href], summary, iframe, [tabindex='0']";
const isReached = (one) => one.tabIndex >= 0 && !one.disabled && one.checkVisibility({ visibilityProperty: true });
const inOrder = (page) => [...page.querySelectorAll(controls)].flatMap((one) =>
  one.localName === "iframe" ? inOrder(one.contentDocument) : isReached(one) ? [one] : []);

function focused() {
  let one = document.activeElement;
  while (one.localName === "iframe") one = one.contentDocument.activeElement;
  return one;
}

function hasRing(one) {
  const style = one.ownerDocument.defaultView.getComputedStyle(one);
  const isDrawn = (style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0) || style.boxShadow !== "none";
  return isDrawn && parseFloat(style.opacity) > 0.5;
}

function check(wanted) {
  const one = focused();
  if (one !== wanted) return "instead of " + wanted.outerHTML + " there is " + one.outerHTML;
  const ringed = one.localName === "summary" ? [one, ...one.children] : [one];
  return ringed.some(hasRing) ? "" : "no ring: " + one.outerHTML;
}

const runsFilm = () => focused().matches("article.scene > button") && focused().querySelector("img").getAttribute("src").endsWith(".gif");
"""
"""What the keyboard must reach, in the order of the page and of the interactive pages in it, and how the focus is seen."""
QUESTIONS = sorted(path.relative_to(SITE).as_posix() for path in (SITE / "questions").glob("*.html"))
LED_THROUGH = ["index.html", "gallery.html", *QUESTIONS, "_generated/examples/index.html", "_generated/examples/linkages/four_bar.html"]


@pytest.mark.parametrize(("width", "dark"), [(1366, False), (1366, True), (390, False), (390, True)])
@pytest.mark.parametrize("page", LED_THROUGH)
def test_the_keyboard_alone_leads_through_a_page(tab, address, page, width, dark):
    """In the order of the page, with a ring that is seen; in the gallery the film of the card on which the focus is runs."""
    is_gallery = page == "gallery.html"
    tab.open(address + page, width=width, height=800, dark=dark, reduced_motion=not is_gallery)
    tab.evaluate(SCROLL)
    tab.wait_until("[...document.querySelectorAll('iframe')].every((one) => one.contentDocument.readyState === 'complete')")
    tab.evaluate("scrollTo(0, 0)")
    count = tab.evaluate(SCRIPT + "window.wanted = inOrder(document); wanted.length")
    assert count > (200 if is_gallery else 10)
    faults, n_films = [], 0
    for k in range(count):
        tab.press("Tab")
        faults.append(tab.evaluate(f"check(wanted[{k}])"))
        n_films += tab.evaluate("runsFilm()")
    assert [fault for fault in faults if fault] == []
    assert n_films == tab.evaluate("document.querySelectorAll('article.scene > button').length")


def test_the_keyboard_alone_moves_the_time_of_a_page_in_a_question(tab, address):
    """By the arrows on its slider, and by the space bar on the button that plays and stops it."""
    tab.open(address + "questions/hunting.html", width=1366, height=800, reduced_motion=True)
    tab.evaluate("document.querySelector('iframe').scrollIntoView()")
    of_page = "document.querySelector('iframe').contentDocument.querySelector('#{}')".format
    tab.wait_until(f"({of_page('play')}?.ariaLabel ?? '') !== ''")
    tab.evaluate(f"{of_page('scrub')}.focus()")
    before = float(tab.evaluate(f"{of_page('scrub')}.value"))
    tab.press("ArrowRight")
    tab.press("ArrowRight")
    assert float(tab.evaluate(f"{of_page('scrub')}.value")) > before
    tab.evaluate(f"{of_page('play')}.focus()")
    words = tab.evaluate(f"{of_page('play')}.ariaLabel")
    tab.press(" ", " ")
    assert {words, tab.evaluate(f"{of_page('play')}.ariaLabel")} == {"play", "pause"}
