"""What the library is made by, and whether the present one is made by it; needs nothing that is not in Python."""

import hashlib
import json
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from governor_mechanism.numerics import kernel_library
from platforms import PLATFORMS

FOLDER = Path(__file__).parent
BUILT = FOLDER / "built"
"""Folder of the machine code of the kernels, and of libraries for the package index."""

REQUIREMENTS = ("numba>=0.68,<0.69", "numpy>=1.26,<3", "scipy>=1.11,<2", "pymunk>=7.0,<8", "pint>=0.24,<1")
"""Packages that the build imports: numba, which changes with every minor version, and what short runs of scenes need."""

COMPILER_REQUIREMENT = "ziglang>=0.13"
"""Package of a C compiler, where the system has none and for other platforms."""

OTHER_FILES = ("comparison.py", "hatch_hook.py")
"""Files here that do not change the library."""


@cache
def recipe_digest() -> str:
    """Return a digest of what the library is made by, other than the kernels."""
    digest = hashlib.sha256()
    for path in sorted(FOLDER.iterdir()):
        if path.suffix in (".py", ".c", ".h") and path.name not in OTHER_FILES:
            digest.update(path.read_bytes())
    return digest.hexdigest()


@dataclass(frozen=True)
class Target:
    """A library that is to be built.

    Attributes
    ----------
    platform
        Name of its platform, as in `kernel_library.platform_name`.
    for_index
        Whether it is for every machine of the platform, in a wheel of the package index; else for machines like this one.
    """

    platform: str
    for_index: bool = False

    @classmethod
    def of_this_machine(cls) -> "Target":
        """Return the target of an installation."""
        return cls(kernel_library.platform_name())

    @property
    def library_folder(self) -> Path:
        """Folder of the library and its index."""
        return BUILT / self.platform if self.for_index else kernel_library.LIBRARY_FOLDER

    @property
    def object_file(self) -> Path:
        """File of the machine code of the kernels, before it is linked."""
        return BUILT / self.platform / "kernels.o"

    @property
    def suffix(self) -> str:
        """Ending of the library."""
        return kernel_library.SUFFIXES.get(self.platform.partition("-")[0], ".so")

    @property
    def wheel_tag(self) -> str:
        """Tag of the wheel: the library needs no version of Python, but its platform."""
        own = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        return f"py3-none-{PLATFORMS[self.platform].wheel_tag if self.for_index else own}"

    @property
    def has_objects(self) -> bool:
        """Whether the machine code of the present kernels exists."""
        return self.object_file.is_file() and self._is_present(self.read_objects())

    @property
    def is_current(self) -> bool:
        """Whether the library of the present kernels exists."""
        index = kernel_library.read_index(self.library_folder) or {}
        return self._is_present(index) and (self.library_folder / str(index.get("library"))).is_file()

    def _is_present(self, index: Mapping[str, Any]) -> bool:
        return index.get("recipe") == recipe_digest() and not kernel_library.find_obstacle(index, self.platform)

    def read_objects(self) -> dict[str, Any]:
        """Return the description of the machine code, empty if there is none."""
        try:
            description: dict[str, Any] = json.loads(self.object_file.with_suffix(".json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return description

    def write_objects(self, kernels: Mapping[str, Any]) -> None:
        """Write the description of the machine code."""
        digests = {"sources": kernel_library.digest_sources(), "recipe": recipe_digest()}
        text = json.dumps({**digests, "platform": self.platform, "kernels": kernels})
        self.object_file.with_suffix(".json").write_text(text, encoding="utf-8")
