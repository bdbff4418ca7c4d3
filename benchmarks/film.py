"""Frame time and file size of films, compared with FuncAnimation and PillowWriter for the same artists.

Both run in one process, so the ratio does not depend on the machine. Usage: python benchmarks/film.py [seconds of film]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from time import perf_counter

from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import governor_mechanism as gm
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.writer import schedule_frames
from governor_mechanism.render.frame_data import FrameData
from stub_run import GOVERNOR_DIMENSIONS, fake_run


def with_func_animation(run: Trajectory, path: Path) -> int:
    """Write the same film with FuncAnimation and return the number of frames."""
    times = schedule_frames(0.0, float(run.times[-1]), 25)
    picture = FramePainter(run, [FrameData(run, run.scene.part, (0.0, float(run.times[-1])), times)], animated=False)

    def update(k: int) -> list[Artist]:
        """Draw one frame."""
        picture.update(k)
        return []

    FuncAnimation(picture.figure, update, frames=len(times), cache_frame_data=False).save(path, writer=PillowWriter(fps=25))
    return len(times)


def main() -> None:
    """Print one row per case: milliseconds per frame and kilobytes, for both methods."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    print("| scene | usual, ms a frame | here, ms a frame | ratio (target 8) | usual, kB | here, kB |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        usual, ours = Path(folder) / "usual.gif", Path(folder) / "ours.gif"
        for name, dimensions in GOVERNOR_DIMENSIONS.items():
            run = fake_run(dimensions, duration=seconds)
            start = perf_counter()
            gm.film(run, ours, stop=seconds, frames_per_second=25)
            middle = perf_counter()
            count = with_func_animation(run, usual)
            slow, fast = (perf_counter() - middle) / count * 1e3, (middle - start) / count * 1e3
            sizes = [path.stat().st_size / 1e3 for path in (usual, ours)]
            print(f"| {name} | {slow:.1f} | {fast:.1f} | {slow / fast:.1f} | {sizes[0]:.0f} | {sizes[1]:.0f} |", flush=True)


if __name__ == "__main__":
    main()
