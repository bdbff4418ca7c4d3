"""Build wheel and sdist, and try them in a fresh environment of every Python found: `make package`.

Looks on the PATH and among the versions that pyenv keeps. A name on the PATH counts only if it starts: pyenv leaves one
there for every version, whether it is switched on or not.

Usage: python .ci/check_package.py
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]

PYTHONS = ("python3.11", "python3.12", "python3.13", "python3.14")

MAX_WHEEL_SIZE = 2_000_000
"""Bytes. The package is text alone; a wheel above this holds what does not belong there."""

TRIAL = """
import governor_mechanism as gm

run = gm.run("porter", times=[0.0, 0.5])
run.raise_if_failed()
gm.film(run, "porter.gif", stop=0.2)
print(len(gm.list_models()), "scenes;", run.message)
"""


def main() -> None:
    """Build, install and try; end with status 1 at the first failure."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        subprocess.run([sys.executable, "-m", "build", "--outdir", folder, ROOT], check=True, stdout=subprocess.DEVNULL)
        (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
        for path in (wheel, sdist):
            print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
        if foreign := [name for name in zipfile.ZipFile(wheel).namelist() if "/_kernels/" in name]:
            raise SystemExit(f"the wheel is for all platforms, but holds {foreign}")
        if wheel.stat().st_size > MAX_WHEEL_SIZE:
            raise SystemExit(f"the wheel is larger than {MAX_WHEEL_SIZE / 1000:.0f} kB")
        found = {name: python for name in PYTHONS if (python := find_python(name))} or {"python": sys.executable}
        for number, (name, python) in enumerate(found.items()):
            for archive in (wheel, sdist) if number == 0 else (wheel,):
                try_archive(python, archive, folder / f"{name}-{archive.suffix[1:]}", environment)
        if missing := [name for name in PYTHONS if name not in found]:
            print(f"not tried, because not found or without venv: {', '.join(missing)}")


def find_python(name: str) -> str | None:
    """Find the first interpreter of this name that starts and has the modules for a fresh environment."""
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    candidates = [shutil.which(name), *map(str, sorted(versions.glob(f"*/bin/{name}")))]
    check = ["-c", "import ensurepip, venv"]
    for python in filter(None, candidates):
        if subprocess.run([python, *check], capture_output=True, check=False).returncode == 0:
            return python
    return None


def try_archive(python: str, archive: Path, folder: Path, environment: dict[str, str]) -> None:
    """Install an archive with the extra `all` into a fresh environment, away from the sources, and use it there."""
    subprocess.run([python, "-m", "venv", folder], check=True, env=environment)
    scripts = folder / ("Scripts" if os.name == "nt" else "bin")
    quiet = ["--quiet", "--disable-pip-version-check", "--constraint", str(ROOT / "constraints.txt")]
    subprocess.run([scripts / "python", "-m", "pip", "install", *quiet, f"{archive}[all]"], check=True, env=environment)
    for command in ([scripts / "python", "-c", TRIAL], [scripts / "governor-mechanism", "crosscheck", "porter", "--no-figure"]):
        answer = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        if answer.returncode:
            raise SystemExit(f"{folder.name}: {answer.stdout}{answer.stderr}")
        print(f"{folder.name}: {answer.stdout.strip().splitlines()[-1]}")


if __name__ == "__main__":
    main()
