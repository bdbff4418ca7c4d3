"""Builds the library of kernels when a clone or an sdist is installed, and puts it into the wheel of its platform.

The environment variable GOVERNOR_MECHANISM_PLATFORM names a platform of `platforms.py`: the wheel is then for every machine
of that platform, and may be put into the package index. Without it the wheel is for machines like this one.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FOLDER = Path(__file__).parent
sys.path[:0] = [str(FOLDER), str(FOLDER.parent / "src")]

from compiler import find_system_compiler  # noqa: E402
from governor_mechanism.numerics import kernel_library  # noqa: E402
from recipe import COMPILER_REQUIREMENT, REQUIREMENTS, Target  # noqa: E402


class KernelLibraryHook(BuildHookInterface[Any]):
    """Hook of hatch."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        name = os.environ.get("GOVERNOR_MECHANISM_PLATFORM")
        self.target = Target(name, for_index=True) if name else Target.of_this_machine()

    def dependencies(self) -> list[str]:
        """Return what the build of the library needs: nothing if it exists."""
        if self.target_name != "wheel" or self.target.is_current:
            return []
        has_compiler = not self.target.for_index and bool(find_system_compiler())
        requirements = [] if self.target.has_objects else REQUIREMENTS
        return [*requirements, *([] if has_compiler else [COMPILER_REQUIREMENT])]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library unless it exists, and add it to the wheel."""
        if self.target_name != "wheel":
            return
        if not self.target.is_current:
            _build([self.target.platform] if self.target.for_index else [])
        if version != "editable":
            build_data["pure_python"] = False
            build_data["tag"] = self.target.wheel_tag
            build_data["force_include"].update(self._files())

    def _files(self) -> dict[str, str]:
        """Return the files of the library and their places in the wheel."""
        folder = self.target.library_folder
        index = kernel_library.read_index(folder) or {}
        del index["sources"]  # nobody changes the sources of an installed wheel, and a digest takes time
        self._temporary = tempfile.TemporaryDirectory()
        path = Path(self._temporary.name, "index.json")
        path.write_text(json.dumps(index), encoding="utf-8")
        places = {path: "index.json", folder / index["library"]: index["library"]}
        return {str(source): f"governor_mechanism/_kernels/{name}" for source, name in places.items()}


def _build(platforms: list[str]) -> None:
    """Build the library in a process of its own; a terminal shows its progress, which installers would hide."""
    try:
        stream = open("/dev/tty", "w")  # noqa: SIM115 -- standard error is not ours to close
    except OSError:
        stream = sys.stderr
    command = [sys.executable, str(FOLDER / "build.py"), *platforms]
    if subprocess.run(command, stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, check=False).returncode:
        raise SystemExit("the library of kernels could not be built; the lines above say why")
