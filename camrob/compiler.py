"""Numba, as camrob uses it: imported when a kernel has to be compiled, and not before.

Parts are translated with the kernels that call them, and optimised and made machine code of only there.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import numba
from numba.core import event, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import register_jitable, typeof_impl

from camrob.compiled import Kernel, take_parts
from camrob.compiling import report_compile

__all__ = ["dispatcher"]


def dispatcher(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Numba's object for a kernel's function; what it compiles is kept (`NUMBA_CACHE_DIR`)."""
    return numba.njit(**{"cache": True, "no_cfunc_wrapper": True, **options})(function)


@typeof_impl.register(Kernel)
def _type_of_kernel(kernel: Kernel, _context: object) -> Any:
    """A kernel that another one calls."""
    return types.Dispatcher(kernel.dispatcher)


class _Ingredient(JITCodeLibrary):  # type: ignore[misc]
    """A part's code, as it stands when it has been translated: its callers alone optimise it and make machine code of it.

    Numba does both for every function by itself, and again for each that calls it.
    """

    def finalize(self) -> None:
        """Take in the code of the parts that this one calls."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None: there is no machine code."""
        return 0

    @property
    def codegen(self) -> Any:
        """The code generator, which can't tell the part's environment to machine code that isn't there."""
        return _Silent(self._codegen)


class _Silent:
    """A code generator that sets no environments. Only what parts of camrob never do, such as printing, asks for one."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: object) -> None:
        """Nothing."""


class _PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, for parts."""

    def __init__(self, typing: Any, target: Any, library: Any, *further: Any) -> None:
        super().__init__(typing, target, library or _Ingredient(target.codegen(), "part"), *further)


def _register(function: Callable[..., Any], options: dict[str, Any]) -> None:
    own = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _PartCompiler}
    register_jitable(**own, **options)(function)


class _Watch(event.Listener):  # type: ignore[misc]
    """Tells of each kernel that begins to compile, and has the garbage collector rest until it is done.

    The compiler makes millions of objects that all live as long as it works on a kernel, and nothing is gained by looking
    through them again and again.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._collects = True

    def on_start(self, happening: Any) -> None:
        """A kernel, or a part of one, begins to compile. Numba's lock has been taken."""
        if self._depth == 0:
            self._collects = gc.isenabled()
            gc.disable()
            report_compile(happening.data["dispatcher"].py_func.__name__.strip("_"))
        self._depth += 1

    def on_end(self, happening: Any) -> None:
        """It is done, or has failed."""
        self._depth -= 1
        if self._depth == 0 and self._collects:
            gc.enable()


take_parts(_register)
event.register("numba:compile", _Watch())
