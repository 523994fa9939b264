"""How camrob's compiled functions are compiled: kernels, which Python calls, and the parts that they are made of.

Only a kernel has a face to Python, machine code and a place in the cache of its own. A part is compiled into the kernels that
call it and nowhere else: what unpacks a hundred arrays that Python might hand over costs more than most parts themselves,
and for a part nobody would ever call it. Called from Python, a part is the plain function that its source says.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import partial
from typing import Any

import numba
from numba.core import event
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import register_jitable

from camrob.compiling import report_compile

__all__ = ["bare", "inlined", "kernel", "part"]

Decorator = Callable[..., Any]

kernel: Decorator = partial(numba.njit, cache=True, no_cfunc_wrapper=True)
"""A function that Python calls. Its arrays have one layout and are writable, so that it is compiled once."""


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


_PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": _PartCompiler}


def _part(**options: Any) -> Decorator:
    register = register_jitable(**_PART, **options)

    def mark(function: Callable[..., Any]) -> Any:
        function.part_of_kernels = True  # type: ignore[attr-defined]  # for those who ask what stands in a kernel
        return register(function)

    return mark


part: Decorator = _part()
"""A function that only kernels call."""

inlined: Decorator = _part(forceinline=True)
"""A part that stands in its caller's code, wherever it is called."""

bare: Decorator = _part(forceinline=True, error_model="numpy", _nrt=False)
"""An inlined part that makes no arrays, counts no references, and divides by zero as NumPy does."""


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


event.register("numba:compile", _Watch())
