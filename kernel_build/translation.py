"""Translation of all kernels to one module of LLVM: each function typed once, and all optimised once, together."""

import gc
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys

from platforms import Platform

REFERENCE_COUNTS = """
declare void @release_block(ptr)

define void @NRT_incref(ptr %block) noinline {
  %is_none = icmp eq ptr %block, null
  br i1 %is_none, label %end, label %count
count:
  %before = load i64, ptr %block
  %after = add i64 %before, 1
  store i64 %after, ptr %block
  br label %end
end:
  ret void
}

define void @NRT_decref(ptr %block) noinline {
  %is_none = icmp eq ptr %block, null
  br i1 %is_none, label %end, label %count
count:
  %before = load i64, ptr %block
  %after = sub i64 %before, 1
  store i64 %after, ptr %block
  %is_last = icmp eq i64 %after, 0
  br i1 %is_last, label %release, label %end
release:
  call void @release_block(ptr %block)
  br label %end
end:
  ret void
}
"""
"""What counts the references to a block of memory. A block belongs to one call of a kernel, so that no other thread counts it."""

ADDRESS_PATTERN = re.compile(r"inttoptr \(i64 \d{6,} to ptr\)")
"""An address of this process, which only texts of errors use."""

EXCEPTION_PATTERN = re.compile(r'^(@\.const\.pickledata\.\S+ = internal constant) \[\d+ x i8\] c".*"', re.MULTILINE)
EXCEPTION_SIZE_PATTERN = re.compile(r"^(@\.const\.picklebuf\.\S+ = internal constant .*\{ ptr \S+ i32) \d+", re.MULTILINE)
"""Exceptions with the path of their source, and their sizes: the caller of a kernel reads only whether there is one."""

NUMBERED_PATTERN = re.compile(r"(__numba_array_expr_|numba\.dynamic\.globals\.|\.const\.pickle(?:data|buf)\.|@\.bytes\.)(-?\w+)")
"""Names with addresses of this process, or digests of what it has."""

INDEX_PATTERN = re.compile(
    r"^  (%\S+) = icmp slt i64 (%\S+), 0\n  (%\S+) = add i64 \2, %\S+\n  (%\S+) = select i1 \1, i64 \3, i64 \2$"
    r"(?!\n  %\S+ = getelementptr inbounds \{ i64, i64, i64 \})",
    re.MULTILINE,
)
"""An index that counts from the end if it is negative. Bounds of slices, which go on as `{ i64, i64, i64 }`, are none of these."""

CHECKED_INDEX = """
declare void @llvm.trap()

define internal i64 @checked_index(i64 %index) {
  %is_negative = icmp slt i64 %index, 0
  br i1 %is_negative, label %stop, label %end
stop:
  call void @llvm.trap()
  unreachable
end:
  ret i64 %index
}
"""
"""An index of a library that is checked: a negative one ends the process."""

HEADER_PATTERN = re.compile(r"^target (triple|datalayout) = .*$", re.MULTILINE)
"""What a module says of its platform."""


class _NoMachineCode:
    """Takes the place of the code generator of a function without machine code."""

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: only messages of errors need the environment of a function."""


class UnoptimisedLibrary(JITCodeLibrary):
    """Code of a function as numba translates it, neither optimised nor translated to machine code."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    @property
    def codegen(self) -> Any:
        """Code generator as far as numba asks for it after the translation."""
        return _NoMachineCode()

    def finalize(self) -> None:
        """Finish the code."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of the machine code: there is none."""
        self._ensure_finalized()
        return 0


@contextmanager
def paused_garbage_collection() -> Iterator[None]:
    """Keep Python from searching for cyclic garbage: the compiler makes millions of objects, and few are garbage before its end."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@dataclass(frozen=True)
class TypedKernel:
    """A kernel whose types are known.

    Attributes
    ----------
    name
        Module and name, by which it is found.
    symbol
        Name of its function in the intermediate representation.
    argument_types, result_type
        Types of numba.
    library
        Its code, without that of what it calls.
    """

    name: str
    symbol: str
    argument_types: tuple[Any, ...]
    result_type: Any
    library: UnoptimisedLibrary

    @property
    def entry(self) -> str:
        """Name of the function that the caller calls."""
        return f"kernel_{self.name.rpartition('.')[2].replace(':', '_')}"

    @property
    def slot_types(self) -> list[str]:
        """Types of the values into which the arguments are flattened."""
        values = [str(argument.type) for argument in self.library._final_module.get_function(self.symbol).arguments]
        return values[2:]  # the first two point to the result, and to what is raised


def type_kernels(signatures: Mapping[Any, tuple[Any, ...]]) -> Iterator[TypedKernel]:
    """Type kernels with all that they call, each function once."""
    context = cpu_target.target_context
    rtsys.initialize(context)  # translated to machine code here, while that is possible
    context.codegen()._library_class = UnoptimisedLibrary
    for kernel, signature in signatures.items():
        with paused_garbage_collection():
            kernel._dispatcher.compile(signature)
        result = kernel._dispatcher.overloads[signature]
        yield TypedKernel(_name_of(kernel), result.fndesc.llvm_func_name, signature, result.fndesc.restype, result.library)


def _name_of(kernel: Any) -> str:
    """Return module and name of a kernel that is a global of its module; others cannot be found again."""
    if getattr(import_module(kernel.__module__), kernel.__name__, None) is not kernel:
        raise ValueError(f"kernel {kernel.__qualname__} of {kernel.__module__} is called by Python, but no global of its module")
    return f"{kernel.__module__}:{kernel.__name__}"


def link_kernels(kernels: list[TypedKernel]) -> Any:
    """Return one module with the code of all kernels, each with an entry; nothing else can be called from outside."""
    module = llvm.parse_assembly("")
    for library in _all_libraries([kernel.library for kernel in kernels]):
        part = library._final_module.clone()
        for function in part.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "weak_odr"  # several libraries define the same
        module.link_in(part)
    header = f'target triple = "{module.triple}"\ntarget datalayout = "{module.data_layout}"\n'
    for text in (REFERENCE_COUNTS, *(_entry_of(kernel) for kernel in kernels)):
        module.link_in(llvm.parse_assembly(header + text))
    entries = {kernel.entry for kernel in kernels}
    for value in [*module.functions, *module.global_variables]:
        if not value.is_declaration and value.name not in entries:
            value.linkage = "internal"
    return module


def _all_libraries(libraries: list[Any]) -> list[Any]:
    """Return libraries and all that they need, each once; without that of numba's reference counts."""
    found = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if library is not rtsys.library and library not in found:
            found[library] = True
            waiting += library._linking_libraries
    return list(found)


def _entry_of(kernel: TypedKernel) -> str:
    """Return the entry of a kernel: it takes one slot of 8 bytes for each flattened argument, and the result after them."""
    values = kernel.slot_types
    types = ["ptr", "ptr", *values]
    lines = [f'declare i32 @"{kernel.symbol}"({", ".join(types)})', f"define i32 @{kernel.entry}(ptr %slots) {{"]
    lines += [f"  %result = getelementptr i64, ptr %slots, i64 {len(values)}", "  %error = alloca ptr", "  store ptr null, ptr %error"]
    for i, value in enumerate(values):
        lines += [f"  %slot{i} = getelementptr i64, ptr %slots, i64 {i}", f"  %value{i} = load {value}, ptr %slot{i}, align 8"]
    arguments = ["ptr %result", "ptr %error", *(f"{value} %value{i}" for i, value in enumerate(values))]
    lines += [f'  %status = call i32 @"{kernel.symbol}"({", ".join(arguments)})', "  ret i32 %status", "}"]
    return "\n".join(lines)


def as_text(module: Any) -> str:
    """Return a module without what no entry needs, and without what differs from one build to the next."""
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine()
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    text = ADDRESS_PATTERN.sub("null", str(module))
    text = EXCEPTION_PATTERN.sub(r"\1 [1 x i8] zeroinitializer", text)
    text = EXCEPTION_SIZE_PATTERN.sub(r"\1 1", text)
    numbers: dict[str, int] = {}
    return NUMBERED_PATTERN.sub(lambda found: f"{found[1]}{numbers.setdefault(found[2], len(numbers))}", text)


def count_from_start(text: str, is_checked: bool) -> str:
    """Return a module whose variable indices never count from the end: kernels have none that are negative."""
    # Numba compares each index with 0 and adds the size of the array, which takes a tenth of the time of
    # the equations of motion. Constant indices keep their meaning.
    if is_checked:
        return INDEX_PATTERN.sub(r"  \4 = call i64 @checked_index(i64 \2)", text) + CHECKED_INDEX
    return INDEX_PATTERN.sub(r"  \4 = add i64 \2, 0", text)


def optimise(text: str, platform: Platform | None) -> bytes:
    """Optimise a module for the least processor of a platform, or of this one, and return its machine code."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    triple, cpu = (platform.triple, platform.cpu) if platform else (llvm.get_process_triple(), "generic")
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu, opt=3, reloc="pic", codemodel="small")
    header = f'target triple = "{triple}"\ntarget datalayout = "{machine.target_data}"\n'
    module = llvm.parse_assembly(header + HEADER_PATTERN.sub("", text))
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    passes.add_refprune_pass()
    passes.run(module, builder)
    module.verify()
    return machine.emit_object(module)
