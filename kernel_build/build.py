"""Build one shared library with all kernels that Python calls, for this platform.

Usage: python kernel_build/build.py. It does nothing if the library of the present kernels exists. Where no compiler is found, or the build
fails, it says so in one sentence and ends with status 0: numba compiles the kernels when they are first called.
"""

import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
SOURCE = FOLDER.parent / "src"
sys.path.insert(0, str(SOURCE))  # the package may not be installed

from governor_mechanism.numerics import kernel_library  # noqa: E402

C_SOURCES = ("caller.c", "runtime.c")
C_OPTIONS = ("-std=gnu11", "-O2", "-fPIC", "-fvisibility=hidden", "-Wall", "-Werror=implicit-function-declaration")
LINK_OPTIONS = {"linux": ["-s"], "darwin": ["-undefined", "dynamic_lookup"]}
"""Options of the linker by platform; Python itself has what the caller needs of it."""

NUMBA_INSTEAD = "so numba compiles the kernels when they are first called"


def main() -> None:
    """Build the library unless it exists."""
    recipe = recipe_digest()
    found = kernel_library.read_index()
    if found and found.get("recipe") == recipe and not kernel_library.find_obstacle(found):
        return
    compiler = find_compiler()
    if compiler is None:
        tell(f"no C compiler was found (cc, gcc, clang, or the package ziglang), {NUMBA_INSTEAD}")
        return
    try:
        build(compiler, recipe)
    except Exception as error:  # whatever happened, the package works without the library
        reason = next(iter(str(error).splitlines()), type(error).__name__)
        tell(f"the library could not be built ({reason}), {NUMBA_INSTEAD}")


def tell(text: str) -> None:
    """Print a line on standard error."""
    print(f"kernels: {text}", file=sys.stderr, flush=True)


def recipe_digest() -> str:
    """Return a digest of what the library is made by, other than the kernels."""
    digest = hashlib.sha256(f"numba {version('numba')}, llvmlite {version('llvmlite')}".encode())
    for path in sorted(FOLDER.iterdir()):
        if path.suffix in (".py", ".c", ".h") and path.name != "comparison.py":
            digest.update(path.read_bytes())
    return digest.hexdigest()


def find_compiler() -> list[str] | None:
    """Return the command of a C compiler, or None."""
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    return [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else None


def build(compiler: list[str], recipe: str) -> None:
    """Build the library and its index."""
    start_time = time.perf_counter()
    sources = kernel_library.digest_sources()
    folder = kernel_library.LIBRARY_FOLDER
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as name:
        temporary = Path(name)
        objects = [compile_c(compiler, FOLDER / source, temporary) for source in C_SOURCES]  # first: it may not be possible
        kernels, code = translate()
        (temporary / "kernels.o").write_bytes(code)
        library = link(compiler, [*objects, temporary / "kernels.o"], temporary)
        library_name = f"kernels-{hashlib.sha256(library.read_bytes()).hexdigest()[:16]}{kernel_library.SUFFIX}"
        index = {
            "sources": sources,
            "recipe": recipe,
            "platform": kernel_library.platform_name(),
            "library": library_name,
            "kernels": kernels,
        }
        (temporary / "index.json").write_text(json.dumps(index | {"kernels": kernels}, indent=1), encoding="utf-8")
        os.replace(library, folder / library_name)
        os.replace(temporary / "index.json", folder / "index.json")
    for path in folder.iterdir():
        if path.name not in (library_name, "index.json"):  # an older library, or what an interrupted build left
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    size = (folder / library_name).stat().st_size / 1e6
    elapsed_time = time.perf_counter() - start_time
    tell(
        f"{len(kernels)} kernels in one library of {size:.2f} MB; {elapsed_time:.0f} s, of which the processor {time.process_time():.0f} s"
    )


def translate() -> tuple[dict[str, dict[str, Any]], bytes]:
    """Return the kernels as the index has them, and their machine code."""
    import recording

    tell("compiling all into one library, once until one of them changes; 1 of 3: calls of each, as Python ...")
    recording.observe_kernels()
    from uses import USES

    signatures = recording.record_signatures(USES)
    from translation import link_kernels, optimise, type_kernels

    tell(f"2 of 3: types of {len(signatures)} kernels and all that they call ...")
    kernels = list(type_kernels(signatures))
    described = {kernel.name: describe(kernel) for kernel in kernels}
    tell("3 of 3: machine code ...")
    return described, optimise(link_kernels(kernels))


def describe(kernel: Any) -> dict[str, Any]:
    """Return what the caller of a kernel needs to know of it."""
    from formats import argument_format, result_format

    parts = [argument_format(kind) for kind in kernel.argument_types]
    n_slots = sum(n for _, n in parts)
    if n_slots != len(kernel.slot_types):
        raise ValueError(f"kernel {kernel.name} takes {len(kernel.slot_types)} values, but {n_slots} are described")
    result, classes = result_format(kernel.result_type)
    return {
        "entry": kernel.entry,
        "arguments": "".join(text for text, _ in parts),
        "slots": n_slots,
        "result": result,
        "classes": [f"{one.__module__}:{one.__qualname__}" for one in classes],
    }


def compile_c(compiler: list[str], source: Path, folder: Path) -> Path:
    """Compile a file of C."""
    target = folder / f"{source.stem}.o"
    call_compiler([*compiler, *C_OPTIONS, "-c", str(source), "-o", str(target)])
    return target


def link(compiler: list[str], objects: list[Path], folder: Path) -> Path:
    """Link object files into a shared library."""
    library = folder / f"library{kernel_library.SUFFIX}"
    call_compiler([*compiler, "-shared", *LINK_OPTIONS.get(sys.platform, []), "-o", str(library), *map(str, objects), "-lm"])
    return library


def call_compiler(command: list[str]) -> None:
    """Run the compiler; its message is the error."""
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        raise RuntimeError(f"{command[0]}: {' '.join(answer.stderr.split())[:200]}")


if __name__ == "__main__":
    main()
