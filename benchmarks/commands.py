"""Times of the commands, each in a new process; the shortest of several calls.

Usage: python benchmarks/commands.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time

COMMAND = [sys.executable, "-m", "governor_mechanism.cli.main"]
REPEATS = 5


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        cases = {
            "--help (target 0.15 s)": ["--help"],
            "models": ["models"],
            "crosscheck porter": ["crosscheck", "porter"],
            "run porter (target 4 s)": ["run", "porter", "--out", folder],
            "run porter --no-film (target 1.0 s)": ["run", "porter", "--no-film", "--out", folder],
            "run porter --no-film --no-figure": ["run", "porter", "--no-film", "--no-figure", "--out", folder],
        }
        print("| command | s |\n|---|---|")
        for name, words in cases.items():
            print(f"| {name} | {min(wall_time(words) for _ in range(REPEATS)):.2f} |")


def wall_time(words: list[str]) -> float:
    """Return the wall time of one call (s)."""
    started = time.perf_counter()
    subprocess.run([*COMMAND, *words], check=True, capture_output=True)
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
