"""Time from a change on the live page to the new picture, and the pace of a motion that goes on, measured in the page.

Beside it stands the processor time that the server takes for one change, which other work on the machine lengthens less.

    python benchmarks/live_latency.py [SCENE ...]

It needs Chromium and the extra `live`. A slider gets input events as from a hand; a picture counts when its elements have changed.
"""

import asyncio
import json
import os
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import uvicorn

import governor_mechanism as gm
from governor_mechanism.live.server import HOST, Workbench
from governor_mechanism.live.session import Session

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from chromium import Tab, open_browser

SCENES = ("jansen", "scott_russell", "stephenson_arc_middle", "porter", "hartung_dubois", "governed_engine")
N_CHANGES = 40

CHANGES = """
(async (count) => {
  const slider = [...document.querySelectorAll("#workbench details .quantity input[type=range]")].find((one) => Number(one.value) !== 0);
  const root = document.documentElement;
  const first = Number(slider.value);
  const seen = [];
  for (let k = 0; k < count; k += 1) {
    const before = root.dataset.picture;
    const changed = new Promise((resolve) => {
      const observer = new MutationObserver(() => {
        if (root.dataset.picture === before) return;
        observer.disconnect();
        resolve();
      });
      observer.observe(root, { attributes: true });
    });
    const start = performance.now();
    slider.value = first * (1 + 0.001 * (1 + (k % 5)));
    slider.dispatchEvent(new Event("input"));
    await changed;
    seen.push(performance.now() - start);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  slider.dispatchEvent(new Event("change"));
  return JSON.stringify(seen);
})(COUNT)
"""

FRAMES = """
(async () => {
  const frames = [];
  await new Promise((resolve) => {
    const start = performance.now();
    const look = (now) => {
      frames.push(now);
      if (now - start < 3000) requestAnimationFrame(look);
      else resolve();
    };
    requestAnimationFrame(look);
  });
  return JSON.stringify(frames.slice(1).map((one, k) => one - frames[k]));
})()
"""


@contextmanager
def serve(names: tuple[str, ...]) -> Iterator[str]:
    """Serve scenes, and yield the beginning of their addresses."""
    workbench = Workbench("token", {name: Session(gm.load(name)) for name in names})
    with socket.socket() as listener:
        listener.bind((HOST, 0))
        port = listener.getsockname()[1]
        server = uvicorn.Server(uvicorn.Config(workbench.make_app(port), log_level="error", ws="websockets-sansio"))
        thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listener])))
        thread.start()
        yield f"http://{HOST}:{port}/token/"
        server.should_exit = True
        thread.join()


def measure(tab: Tab, script: str) -> np.ndarray:
    """Return the times, ms, that a script in the page measures."""
    answer = tab.command("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
    if "exceptionDetails" in answer:
        raise RuntimeError(str(answer["exceptionDetails"]))
    return np.array(json.loads(answer["result"]["value"]))


def main(names: tuple[str, ...]) -> None:
    """Print the times of all scenes."""
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    with serve(names) as address, open_browser() as tab:
        tab.allowed_addresses = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "about:")
        for name in names:
            tab.open(f"{address}{name}/", width=1366)
            while not tab.evaluate("document.querySelector('#workbench .quantity') !== null"):
                time.sleep(0.05)
            measure(tab, CHANGES.replace("COUNT", "3"))
            started = time.process_time()
            times = measure(tab, CHANGES.replace("COUNT", str(N_CHANGES)))
            work = 1e3 * (time.process_time() - started) / N_CHANGES
            tab.evaluate("[...document.querySelectorAll('#workbench button')].find((one) => one.textContent === 'Let it move').click()")
            frames = measure(tab, FRAMES)
            low, middle, high = np.percentile(times, [5, 50, 95])
            pace = f"a frame while it moves takes {np.median(frames):.1f} ms, 95 % within {np.percentile(frames, 95):.1f} ms"
            change = f"change to picture: 5 % {low:.0f} ms, half {middle:.0f} ms, 95 % {high:.0f} ms (server {work:.0f} ms)"
            print(f"{name:22} {change}; {pace}", *tab.problems, flush=True)


if __name__ == "__main__":
    main(tuple(sys.argv[1:]) or SCENES)
