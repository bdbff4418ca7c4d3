"""Build one shared library with all kernels that Python calls.

Usage: python kernel_build/build.py [--again] [--checked] [PLATFORM ...]. Without names: for machines like this one, into the package.
With names: for every machine of these platforms, into kernel_build/built/, for wheels of the package index. It does nothing if the
library of the present kernels exists, and only links if their machine code does. It ends with status 1 and one sentence if it cannot.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))  # the package may not be installed

from compiler import compile_sources, find_compiler, link
from governor_mechanism.numerics import kernel_library
from governor_mechanism.numerics.kernel_sources import KernelSources, read_texts
from platforms import PLATFORMS
from recipe import Target


def main() -> None:
    """Build the libraries that do not exist."""
    if os.environ.get("PYTHONHASHSEED") != "0":  # numba's code follows the order of sets of names: equal kernels give equal libraries
        sys.exit(subprocess.call([sys.executable, *sys.argv], env={**os.environ, "PYTHONHASHSEED": "0"}))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", action="store_true", help="also where no kernel has changed, but the types with which Python calls one")
    parser.add_argument("--checked", action="store_true", help="a library that ends the process at a negative index, for tests")
    parser.add_argument("platforms", nargs="*", metavar="PLATFORM", help=", ".join(PLATFORMS))
    options = parser.parse_args()
    names = options.platforms
    if unknown := set(names) - set(PLATFORMS):
        parser.error(f"no platform {', '.join(sorted(unknown))}; there are {', '.join(PLATFORMS)}")
    wanted = [Target(name, for_index=True) for name in names] or [Target.of_this_machine()]
    try:
        is_again = options.again or options.checked
        build([target for target in wanted if is_again or not target.is_current], is_again, options.checked)
    except Exception as error:
        reason = next(iter(str(error).splitlines()), type(error).__name__)
        tell(f"the library could not be built: {reason}")
        sys.exit(1)


def tell(text: str) -> None:
    """Print a line on standard error."""
    print(f"kernels: {text}", file=sys.stderr, flush=True)


def build(targets: list[Target], is_again: bool, is_checked: bool) -> None:
    """Build libraries and their indices, from machine code that exists unless it is made again; the types are found once for all."""
    commands = [find_compiler(target) for target in targets]  # first: there may be none
    translate_all([target for target in targets if is_again or not target.has_objects], is_checked)
    for target, command in zip(targets, commands, strict=True):
        target.library_folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.library_folder) as temporary:
            parts = compile_sources(command, target.platform, Path(temporary))
            objects = [*parts, str(target.object_file)]
            size = keep(link(command, target.platform, objects, Path(temporary)), target)
        tell(f"one library of {size / 1e6:.2f} MB for {target.platform}; the processor took {processor_time():.0f} s")


def processor_time() -> float:
    """Return the processor time of this process and of those that it has started, s."""
    return sum(os.times()[:4])


def keep(library: Path, target: Target) -> int:
    """Put a library and its index into their folder, and return the size of the library."""
    folder, content = target.library_folder, library.read_bytes()
    name = f"kernels-{hashlib.sha256(content).hexdigest()[:16]}{target.suffix}"
    index_file = library.with_name("index.json")
    index_file.write_text(json.dumps(target.read_objects() | {"library": name}, indent=1), encoding="utf-8")
    for path in folder.glob("kernels-*"):
        path.unlink()
    os.replace(library, folder / name)
    os.replace(index_file, folder / "index.json")
    return len(content)


def translate_all(targets: list[Target], is_checked: bool) -> None:
    """Make the machine code of the kernels for several platforms."""
    if not targets:
        return
    described, text = translate()
    from translation import count_from_start, optimise

    text = count_from_start(text, is_checked)

    for target in targets:
        tell(f"3 of 3: machine code for {target.platform} ...")
        target.object_file.parent.mkdir(parents=True, exist_ok=True)
        target.object_file.write_bytes(optimise(text, PLATFORMS.get(target.platform)))
        target.write_objects(described)


def translate() -> tuple[dict[str, dict[str, Any]], str]:
    """Return the kernels as the index has them, and one module of LLVM with all, as text."""
    import recording

    tell("all into one library, once until one of them changes; 1 of 3: calls of each, as Python ...")
    recording.observe_kernels()
    from uses import USES

    signatures = recording.record_signatures(USES)
    from translation import as_text, link_kernels, type_kernels

    tell(f"2 of 3: types of {len(signatures)} kernels and all that they call ...")
    kernels = list(type_kernels(signatures))
    if missed := recording.definitions_in_use() - KernelSources(read_texts(kernel_library.PACKAGE_ROOT)).definitions:
        names = ", ".join(f"{module}:{name}" for module, name in sorted(missed))
        raise ValueError(f"numerics/kernel_sources.py does not find what a kernel is made from: {names}")
    return {kernel.name: describe(kernel) for kernel in kernels}, as_text(link_kernels(kernels))


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


if __name__ == "__main__":
    main()
