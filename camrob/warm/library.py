"""Kernels compiled ahead into one library that Python loads without Numba (`camrob.machine_code`), made by Numba's `pycc`.

Each kernel becomes an object file with a Python module of its own, so that as many processes as there are cores can work; the
platform's C compiler translates what they share and links them.
"""

from __future__ import annotations

import tempfile
import warnings
from pathlib import Path
from typing import Any
from unittest.mock import patch

from llvmlite.binding import Linkage
from numba.core.compiler import Flags
from numba.core.errors import NumbaPendingDeprecationWarning
from numba.core.registry import cpu_target
from numba.core.typing import signature

from camrob.machine_code import LEVELS, level, library_name, module_name, source_state
from camrob.warm.signatures import Known

with warnings.catch_warnings():  # pending since Numba 0.57, until it has something else that does this
    warnings.simplefilter("ignore", NumbaPendingDeprecationWarning)
    from numba.pycc import compiler as pycc
    from numba.pycc.cc import CC

__all__ = ["compile_object", "compile_shared_part", "link"]

_SHARED = "kernels"  # what is in the library once, whose beginning each kernel's module calls


def compile_object(kernel: Known, folder: Path) -> Path:
    """The object file in `folder` of a kernel for one kind of arguments, for the processors that this one is among."""
    dispatcher, name = kernel.dispatcher(), module_name(kernel.kernel, kernel.way)
    entry = pycc.ExportEntry(name, signature(None, *kernel.types()), dispatcher.py_func)
    compiler = pycc.ModuleCompiler([entry], name, use_nrt=True, cpu_name=LEVELS[level()])
    compiler.external_init_function = f"pycc_init_{_SHARED}"

    def flags() -> Flags:
        """The kernel's own options: pycc would take the same for all."""
        own = Flags()
        cpu_target.options.parse_as_flags(own, dispatcher.targetoptions)
        return own

    compiler.export_python_wrap = True
    with patch.object(pycc, "Flags", flags):
        code = compiler._cull_exports()
    for function in code.get_defined_functions():
        if function.name not in compiler.dll_exports:  # the same part may stand in another kernel's file
            function.visibility, function.linkage = "default", Linkage.internal
    target = folder / f"{name}.o"
    target.write_bytes(code.emit_native_object())
    return target


def compile_shared_part(folder: Path) -> list[str]:
    """The object files that all kernels need, by the platform's C compiler. Raises what pycc and the compiler raise."""
    shared: Any = CC(_SHARED, __name__)
    return list(shared._compile_mixins(str(folder)))


def link(objects: list[str], names: list[str], folder: Path) -> Path:
    """The library of all objects, put in its place in one go; libraries of other states of the sources go.

    Raises RuntimeError where the sources are not those any more that they were, and what the platform's linker raises.
    """
    if source_state.__wrapped__() != source_state():
        raise RuntimeError("the sources changed while their kernels were compiled")
    shared: Any = CC(_SHARED, __name__)
    tools = shared._toolchain
    target = folder / library_name()
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        made = Path(scratch) / target.name
        tools.link_shared(
            str(made),
            objects,
            tools.get_python_libraries(),
            tools.get_python_library_dirs(),
            export_symbols=[f"PyInit_{name}" for name in names],
            extra_ldflags=shared._get_extra_ldflags(),
        )
        made.replace(target)
    for other in folder.glob(target.name.replace(target.name.split("-")[1], "*")):
        if other != target:
            other.unlink(missing_ok=True)
    return target
