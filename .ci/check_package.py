"""Build wheel and sdist, and try them in a fresh environment of every Python found: `make package`.

The wheel is for every machine of this platform; the sdist builds its library with the compiler of the package index, since the
environments have no other.

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

from governor_mechanism.numerics.kernel_library import platform_name

ROOT = Path(__file__).parents[1]

PYTHONS = ("python3.11", "python3.12", "python3.13", "python3.14")

MAX_WHEEL_SIZE = 2_500_000
"""Bytes. The package is text, and a library of kernels of half a megabyte; a wheel above this holds what does not belong there."""

TRIAL = """
import importlib.util
import sys
import governor_mechanism as gm

assert importlib.util.find_spec("numba") is None
scenes, n_runs = gm.list_models(), 0
for name in scenes if "all" in sys.argv else ["porter"]:
    for engine in ("reduced", "multibody", "impulse"):
        try:
            run = gm.run(name, engine=engine, times=[0.0, 0.02], accuracy=1e-3)
        except gm.UnsupportedEffect:
            continue
        n_runs += 1
gm.film(gm.run("porter", times=[0.0, 0.5]), "porter.gif", stop=0.2)
print(n_runs, "runs of", len(scenes), "scenes without a compiler;", gm.run("porter", times=[0.0, 0.5]).message)
"""
"""Runs in an environment without numba: of all scenes in all engines, or of one."""


def main() -> None:
    """Build, install and try; end with status 1 at the first failure."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel, sdist = build(folder, "--wheel"), build(folder, "--sdist")
        for path in (wheel, sdist):
            print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
        kernels = [name for name in zipfile.ZipFile(wheel).namelist() if "/_kernels/" in name]
        if len(kernels) != 2 or "-py3-none-any" in wheel.name:
            raise SystemExit(f"the wheel of a platform has one library and its index, but {wheel.name} holds {kernels}")
        if wheel.stat().st_size > MAX_WHEEL_SIZE:
            raise SystemExit(f"the wheel is larger than {MAX_WHEEL_SIZE / 1000:.0f} kB")
        found = {name: python for name in PYTHONS if (python := find_python(name))} or {"python": sys.executable}
        for number, (name, python) in enumerate(found.items()):
            for archive in (wheel, sdist) if number == 0 else (wheel,):
                scope = "all" if number == 0 and archive is wheel else "one"
                try_archive(python, archive, folder / f"{name}-{archive.suffix[1:]}", environment, scope)
        if missing := [name for name in PYTHONS if name not in found]:
            print(f"not tried, because not found or without venv: {', '.join(missing)}")


def build(folder: Path, option: str) -> Path:
    """Build the wheel for all machines of this platform, or the sdist."""
    environment = {**os.environ, "GOVERNOR_MECHANISM_PLATFORM": platform_name()}
    command = [sys.executable, "-m", "build", option, "--outdir", folder, ROOT]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    (path,) = folder.glob("*.whl" if option == "--wheel" else "*.tar.gz")
    return path


def find_python(name: str) -> str | None:
    """Find the first interpreter of this name that starts and has the modules for a fresh environment."""
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    candidates = [shutil.which(name), *map(str, sorted(versions.glob(f"*/bin/{name}")))]
    check = ["-c", "import ensurepip, venv"]
    for python in filter(None, candidates):
        if subprocess.run([python, *check], capture_output=True, check=False).returncode == 0:
            return python
    return None


def try_archive(python: str, archive: Path, folder: Path, environment: dict[str, str], scope: str) -> None:
    """Install an archive with the extra `all` into a fresh environment without a compiler, away from the sources, and use it."""
    subprocess.run([python, "-m", "venv", folder], check=True, env=environment)
    scripts = folder / ("Scripts" if os.name == "nt" else "bin")
    environment = environment | {"PATH": str(scripts)}
    quiet = ["--quiet", "--disable-pip-version-check", "--constraint", str(ROOT / "constraints.txt")]
    subprocess.run([scripts / "python", "-m", "pip", "install", *quiet, f"{archive}[all]"], check=True, env=environment)
    for command in ([scripts / "python", "-c", TRIAL, scope], [scripts / "governor-mechanism", "crosscheck", "porter", "--no-figure"]):
        answer = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        if answer.returncode or "kernels:" in answer.stderr:
            raise SystemExit(f"{folder.name}: {answer.stdout}{answer.stderr}")
        print(f"{folder.name}: {answer.stdout.strip().splitlines()[-1]}")


if __name__ == "__main__":
    main()
