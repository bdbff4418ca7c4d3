"""Compilers that translate a kernel to machine code once, together with all that it calls.

By default numba optimises every function and generates its machine code, although the machine code of its callers contains it too.
Here a function that a compiled function calls stays in the intermediate representation of LLVM, and the kernel that Python calls is
optimised as a whole.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.environment import lookup_environment

from governor_mechanism.numerics.compilation_progress import show_compilation

ENVIRONMENT_PREFIX = "_ZN08NumbaEnv"
"""Beginning of the names of variables that point to the environment of a function: what its error messages need."""


@contextmanager
def paused_garbage_collection() -> Iterator[None]:
    """Keep Python from searching for cyclic garbage: the compiler makes millions of objects, and few of them are garbage before its end."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class _NoMachineCode:
    """Takes the place of the code generator of a function without machine code."""

    def set_env(self, name: str, environment: Any) -> None:
        """Leave the environment to the kernels that contain the function."""


class UnoptimisedLibrary(JITCodeLibrary):
    """Code that is not optimised function by function, because it is optimised as a whole."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout


class LinkedLibrary(UnoptimisedLibrary):
    """Code of a function that is only linked into kernels; neither optimised nor translated to machine code."""

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


class KernelLibrary(UnoptimisedLibrary):
    """Code of a kernel with all functions that it calls, directly or not."""

    def add_linking_library(self, library: Any) -> None:
        """Link a library and those on which it depends."""
        if library not in self._linking_libraries:
            super().add_linking_library(library)
            if isinstance(library, LinkedLibrary):
                for dependency in library._linking_libraries:
                    self.add_linking_library(dependency)

    def _optimize_final_module(self) -> None:
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)

    def finalize(self) -> None:
        """Translate the code, and set the environments of all functions in it."""
        super().finalize()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name) if variable.name.startswith(ENVIRONMENT_PREFIX) else None
            if environment is not None:
                self.codegen.set_env(variable.name, environment)


class LibraryCompiler(CompilerBase):
    """Compiler that adds code to a library of its own class."""

    library_class: type[JITCodeLibrary]

    def define_pipelines(self) -> list[Any]:
        """Return numba's pipeline, which adds code to a library of the class."""
        self.state.library = self.library_class(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]


class KernelCompiler(LibraryCompiler):
    """Compiler of functions that Python calls."""

    library_class = KernelLibrary

    def compile_extra(self, func: Any) -> Any:
        """Compile a function and all that it calls."""
        with paused_garbage_collection(), show_compilation(func.__name__):
            return super().compile_extra(func)


class LinkedFunctionCompiler(LibraryCompiler):
    """Compiler of functions that compiled functions call."""

    library_class = LinkedLibrary
