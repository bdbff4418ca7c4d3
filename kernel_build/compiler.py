"""The C compiler: compiles what stands around the kernels, and links all into one shared library."""

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

from platforms import PLATFORMS
from recipe import FOLDER, Target

C_SOURCES = ("caller.c", "runtime.c")
C_OPTIONS = ("-std=gnu11", "-O2", "-fvisibility=hidden", "-Wall", "-Werror=implicit-function-declaration")
LINK_OPTIONS = {"linux": ["-s", "-lm"], "darwin": ["-undefined", "dynamic_lookup"], "win32": ["-s"]}
"""Options of the linker by system; Python itself has what the caller needs of it."""

TRIAL = "#include <stdint.h>\n#include <stdlib.h>\n#include <string.h>\nint trial(void) { return 0; }\n"
"""A file of C with all headers that the library needs."""


def find_system_compiler() -> list[str]:
    """Return the command of a C compiler of the system that makes libraries; empty if there is none."""
    for name in ("cc", "gcc", "clang"):
        command = [name, "-fPIC", "-shared", "-x", "c", "-", "-o", "/dev/null"]
        if shutil.which(name) and not subprocess.run(command, input=TRIAL.encode(), capture_output=True, check=False).returncode:
            return [name]
    return []


def find_compiler(target: Target) -> list[str]:
    """Return the command of a C compiler: the system's, or zig for other systems and older ones."""
    if not target.for_index and (command := find_system_compiler()):
        return command
    if not importlib.util.find_spec("ziglang"):
        cure = "" if target.for_index else "a C compiler (cc, gcc or clang), or "
        raise RuntimeError(f"no C compiler for {target.platform} was found; install {cure}the package ziglang")
    options = [f"--target={PLATFORMS[target.platform].zig_target}"] if target.for_index else []
    return [sys.executable, "-m", "ziglang", "cc", *options]


def compile_sources(command: list[str], platform: str, folder: Path) -> list[str]:
    """Compile the files of C, and return the names of what has to be linked."""
    is_windows = platform.startswith("win32")
    objects = [str(folder / f"{Path(source).stem}.o") for source in C_SOURCES]
    for source, target in zip(C_SOURCES, objects, strict=True):
        position = [] if is_windows else ["-fPIC"]
        _call([*command, *C_OPTIONS, *position, "-c", str(FOLDER / source), "-o", target])
    return [*objects, *([_import_library_of_python(folder)] if is_windows else [])]


def _import_library_of_python(folder: Path) -> str:
    """Make what Windows needs to find the functions of Python: those that the header declares."""
    header = (FOLDER / "python_abi.h").read_text(encoding="utf-8")
    functions = re.findall(r"^(?!typedef|IN_PYTHON)[\w ]+?[ *]+(Py\w+)\(.*\);$", header, re.MULTILINE)
    data = re.findall(r"\b(_?Py\w+)(?=[,;])", " ".join(re.findall(r"^IN_PYTHON .*;$", header, re.MULTILINE)))
    definition, library = folder / "python3.def", folder / "python3.lib"
    names = [*functions, *(f"{name} DATA" for name in data)]
    definition.write_text("\n".join(["LIBRARY python3.dll", "EXPORTS", *names, ""]), encoding="utf-8")
    tool = [sys.executable, "-m", "ziglang", "dlltool", "-m", "i386:x86-64"]
    _call([*tool, "-D", "python3.dll", "-d", str(definition), "-l", str(library)])
    return str(library)


def link(command: list[str], platform: str, objects: list[str], folder: Path) -> Path:
    """Link object files into a shared library."""
    library = folder / "library"
    options = LINK_OPTIONS.get(platform.partition("-")[0], ["-lm"])
    _call([*command, "-shared", "-o", str(library), *objects, *options])
    return library


def _call(command: list[str]) -> None:
    """Run the compiler; its message is the error."""
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        raise RuntimeError(f"{Path(command[0]).name}: {' '.join(answer.stderr.split())[:300]}")
