"""A browser without a window, driven by the DevTools protocol over a web socket of the standard library alone."""

import base64
import json
import os
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

MISSING = "no Chromium on the PATH; install it (for example: apt install chromium)"

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
"""Names under which the browser is installed."""

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--remote-debugging-port=0"),
)
START_TIME = 60.0
"""Longest time (s) that the browser takes to start."""
ANSWER_TIME = 60.0
"""Longest time (s) that an answer takes."""


def find_browser() -> str | None:
    """Path of the browser, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class WebSocket:
    """A web socket to this machine that carries JSON (RFC 6455)."""

    def __init__(self, port: int, path: str) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=ANSWER_TIME)
        self._rest = b""
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade"]
        lines += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", "", ""]
        self._socket.sendall("\r\n".join(lines).encode())
        while b"\r\n\r\n" not in self._rest:
            self._receive_more()
        head, _, self._rest = self._rest.partition(b"\r\n\r\n")
        assert b" 101 " in head.splitlines()[0], head

    def send(self, message: dict[str, Any]) -> None:
        content, mask = json.dumps(message).encode(), os.urandom(4)
        size = len(content)
        head = bytes([0x81, 0x80 | (size if size < 126 else 126 if size < 65536 else 127)])
        head += b"" if size < 126 else struct.pack("!H", size) if size < 65536 else struct.pack("!Q", size)
        self._socket.sendall(head + mask + bytes(byte ^ mask[k % 4] for k, byte in enumerate(content)))

    def receive(self) -> dict[str, Any]:
        content, is_last = b"", False
        while not is_last:
            first, second = self._take(2)
            size = second & 0x7F
            if size >= 126:
                size = int.from_bytes(self._take(2 if size == 126 else 8), "big")
            part = self._take(size)
            if first & 0x0F in (0, 1):
                content, is_last = content + part, bool(first & 0x80)
        answer: dict[str, Any] = json.loads(content)
        return answer

    def close(self) -> None:
        self._socket.close()

    def _take(self, size: int) -> bytes:
        while len(self._rest) < size:
            self._receive_more()
        taken, self._rest = self._rest[:size], self._rest[size:]
        return taken

    def _receive_more(self) -> None:
        more = self._socket.recv(1 << 16)
        if not more:
            raise ConnectionError("the browser closed the connection")
        self._rest += more


class Tab:
    """One page of the browser; `problems` are the errors and warnings of its console, and its requests that leave the file.

    `allowed_addresses` are the beginnings of addresses that a page may ask for.
    """

    def __init__(self, port: int) -> None:
        request = urllib.request.Request(f"http://127.0.0.1:{port}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=ANSWER_TIME) as answer:
            address = json.load(answer)["webSocketDebuggerUrl"]
        self._socket = WebSocket(port, "/" + address.split("/", 3)[3])
        self._last_id = 0
        self._is_loaded = False
        self.problems: list[str] = []
        self.allowed_addresses = ("file:", "data:", "about:")
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.command(f"{domain}.enable")

    def command(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result."""
        self._last_id += 1
        self._socket.send({"id": self._last_id, "method": method, "params": parameters})
        while (answer := self._socket.receive()).get("id") != self._last_id:
            self._note(answer)
        assert "error" not in answer, answer
        return dict(answer["result"])

    def open(self, page: Path | str, *, width: int = 1280, height: int = 900, dark: bool = False, reduced_motion: bool = False) -> None:
        """Open a file, or an address, in a window of a size (CSS pixels)."""
        is_telephone = width < 600
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=is_telephone)
        self.command("Emulation.setTouchEmulationEnabled", enabled=is_telephone)
        features = {"prefers-color-scheme": "dark" if dark else "light", "prefers-reduced-motion": "reduce" if reduced_motion else ""}
        self.command("Emulation.setEmulatedMedia", features=[{"name": name, "value": value} for name, value in features.items()])
        self._is_loaded = False
        self.command("Page.navigate", url=page if isinstance(page, str) else page.as_uri())
        deadline = time.monotonic() + ANSWER_TIME
        while not self._is_loaded:
            assert time.monotonic() < deadline, "the page does not load"
            self._note(self._socket.receive())

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression of JavaScript."""
        answer = self.command("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def press(self, key: str, text: str = "") -> None:
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            extra = {"text": text} if text and kind == "keyDown" else {}
            self.command("Input.dispatchKeyEvent", type=kind, key=key, **extra)

    def point(self, kind: str, x: float, y: float) -> None:
        """Move, press or release the mouse at a place (CSS pixels)."""
        button = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
        self.command("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def wait_until(self, condition: Callable[[], Any] | str, waiting_time: float = ANSWER_TIME) -> None:
        """Wait until a function, or an expression of JavaScript, is true."""
        is_true = condition if callable(condition) else partial(self.evaluate, condition)
        deadline = time.monotonic() + waiting_time
        while not is_true():
            assert time.monotonic() < deadline, condition
            time.sleep(0.02)

    def click(self, x: float, y: float) -> None:
        """Press and release the mouse at a place (CSS pixels)."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.point(kind, x, y)

    def drag(self, *places: tuple[float, float], pause: float = 0.0) -> None:
        """Press the mouse at the first of places (CSS pixels), move along them, and release it at the last."""
        self.point("mouseMoved", *places[0])
        self.point("mousePressed", *places[0])
        for x, y in places[1:]:
            self.command("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="left", buttons=1)
            time.sleep(pause)
        self.point("mouseReleased", *places[-1])

    def save_picture(self, path: Path, *, full: bool = False) -> None:
        """Save what the window shows, or the whole page, as a PNG."""
        answer = self.command("Page.captureScreenshot", format="png", captureBeyondViewport=full)
        path.write_bytes(base64.b64decode(answer["data"]))

    def close(self) -> None:
        self._socket.close()

    def _note(self, event: dict[str, Any]) -> None:
        """Keep problems, and whether the page is loaded."""
        parameters = event.get("params", {})
        match event.get("method"):
            case "Page.loadEventFired":
                self._is_loaded = True
            case "Runtime.exceptionThrown":
                self.problems.append(str(parameters["exceptionDetails"]))
            case "Runtime.consoleAPICalled" if parameters["type"] in ("error", "warning", "assert"):
                self.problems.append(str(parameters["args"]))
            case "Log.entryAdded" if parameters["entry"]["level"] in ("error", "warning"):
                self.problems.append(str(parameters["entry"]))
            case "Network.requestWillBeSent" if not parameters["request"]["url"].startswith(self.allowed_addresses):
                self.problems.append(f"request of {parameters['request']['url']}")


@contextmanager
def open_browser() -> Iterator[Tab]:
    """A tab of a browser with a profile of its own, both gone afterwards."""
    program = find_browser()
    assert program is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        arguments = [program, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
        with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                tab = Tab(_wait_for_port(Path(profile) / "DevToolsActivePort"))
                yield tab
                tab.close()
            finally:
                process.terminate()


def _wait_for_port(path: Path) -> int:
    """Port that the browser writes into a file of its profile."""
    deadline = time.monotonic() + START_TIME
    while time.monotonic() < deadline:
        if path.is_file() and (lines := path.read_text().splitlines()):
            return int(lines[0])
        time.sleep(0.05)
    raise TimeoutError("the browser does not start")


if __name__ == "__main__":
    sys.exit(None if find_browser() else MISSING)
