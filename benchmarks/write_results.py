"""Run the benchmarks and write what they print into RESULTS.md, between the comments that name them.

Usage: python benchmarks/write_results.py                    # all that RESULTS.md names
       python benchmarks/write_results.py impulse reduced
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "RESULTS.md"
TABLES = re.compile(r"(?<=^<!-- table: )(\w+) -->\n.*?\n(?=<!-- end -->$)", flags=re.DOTALL | re.MULTILINE)
"""The name of a script, with what stands up to the end of its tables."""


def main() -> None:
    """Write the tables of the scripts of the command line, or all, each as soon as it is there."""
    names = TABLES.findall(RESULTS.read_text(encoding="utf-8"))
    if unknown := set(sys.argv[1:]) - set(names):
        raise SystemExit(f"RESULTS.md has no tables of {', '.join(sorted(unknown))}; it has those of {', '.join(names)}")
    for name in sys.argv[1:] or names:
        print(f"python benchmarks/{name}.py", flush=True)
        done = subprocess.run([sys.executable, FOLDER / f"{name}.py"], stdout=subprocess.PIPE, text=True, encoding="utf-8", check=True)
        if "|---" not in done.stdout:
            print(f"  its tables stay as they are, since it made none: {done.stdout.strip()}")
            continue
        text = RESULTS.read_text(encoding="utf-8")  # read again: a benchmark takes minutes, and findings are written meanwhile
        RESULTS.write_text(replace_tables(text, name, done.stdout), encoding="utf-8")


def replace_tables(text: str, name: str, printed: str) -> str:
    """Return the text of RESULTS.md with what a script has printed in place of its tables."""
    return TABLES.sub(lambda found: f"{name} -->\n\n{printed.strip()}\n\n" if found[1] == name else found[0], text)


if __name__ == "__main__":
    main()
