"""Kernels as machine code that was compiled ahead: where it lies, whether it is that of today's sources, and what it takes.

`camrob.warm` makes one library for each state of the sources and each level of processors. It lies in this package or, where
that can't be written to, in the cache; a wheel made beside it carries it. Its kernels check nothing of what they are called
with, so `Entry.takes` does.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.machinery
import importlib.util
import json
import os
import platform
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

__all__ = [
    "FURTHER",
    "LEVELS",
    "Entry",
    "cache_folder",
    "entries_of",
    "home",
    "keep_kernels_fresh",
    "level",
    "library_name",
    "module_name",
    "ready_library",
    "source_state",
]

Check = Callable[[Any], bool]

HERE = Path(__file__).parent
FURTHER = ("warm/kernels.json", "compiled.py", "compiler.py", "program/motion.py")
"""Files that say something of kernels without holding one: how they are compiled, and constants that stand in them."""
LEVELS = {"v3": "x86-64-v3", "any": ""}
"""Kinds of processors by their short name, as LLVM calls them ("": whatever the platform has at least)."""


def cache_folder() -> Path:
    """The user's folder for what camrob can make again."""
    root = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(root) / "camrob"


@functools.cache
def source_state() -> str:
    """What all files that hold kernels, and the list of what these are called with, say: sixteen letters of a hash.

    A kernel changes when one that it calls lies in another file and changes, and stale kernels would drive a robot.
    """
    sources = hashlib.sha256()
    for folder, below, files in os.walk(HERE):
        below.sort()
        for file in sorted(files):
            path = os.path.join(folder, file)
            name = os.path.relpath(path, HERE).replace(os.sep, "/")
            if file.endswith(".py") or name in FURTHER:
                with open(path, "rb") as source:
                    text = source.read()
                if name in FURTHER or b"camrob.compiled" in text:
                    sources.update(name.encode() + b"\0" + text)
    return sources.hexdigest()[:16]


@functools.cache
def level() -> str:
    """The short name of what this processor can do, of LEVELS."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return "any"
    try:
        features = import_module("numpy._core._multiarray_umath").__cpu_features__
    except (ImportError, AttributeError):
        return "any"
    has = features.get("X86_V3", all(features.get(name, False) for name in ("AVX2", "FMA3", "F16C")))
    return "v3" if has else "any"


def library_name() -> str:
    """What the library for this state of the sources, this processor and this Python is called."""
    return f"kernels-{source_state()}-{level()}{sysconfig.get_config_var('EXT_SUFFIX')}"


def _homes() -> tuple[Path, Path]:
    return HERE / "warm" / "compiled", cache_folder()


def home() -> Path | None:
    """The folder for a library that is being made: in this package, else in the cache; None where neither can be written to."""
    for folder in _homes():
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


def ready_library() -> Path | None:
    """The library for this state of the sources; None where it has not been made."""
    return next((folder / library_name() for folder in _homes() if (folder / library_name()).is_file()), None)


def module_name(kernel: str, way: int) -> str:
    """A kernel, module:name, as the library's module for the `way`-th kind of its arguments is called."""
    return kernel.replace("_", "_0").replace(".", "_1").replace(":", "_2") + f"_3{way}"


@dataclass(frozen=True, slots=True)
class Entry:
    """A kernel's machine code.

    Attributes: call, which must only be given what it was compiled for; checks, one an argument.
    """

    call: Callable[..., Any]
    checks: tuple[Check, ...]

    def takes(self, arguments: tuple[Any, ...]) -> bool:
        """Whether the machine code was made for such arguments."""
        return len(arguments) == len(self.checks) and all(map(_holds, self.checks, arguments))


def _holds(check: Check, argument: Any) -> bool:
    return check(argument)


def entries_of(kernel: str) -> tuple[Entry, ...]:
    """The machine code of a kernel, module:name, one a kind of arguments; () where there is none for today's sources, or none is
    wanted.
    """
    library = _library()
    if library is None:
        return ()
    found = []
    for way, arguments in enumerate(_signatures().get(kernel, ())):
        name = module_name(kernel, way)
        loader = importlib.machinery.ExtensionFileLoader(name, str(library))
        spec = importlib.util.spec_from_loader(name, loader)
        try:
            module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
            loader.exec_module(module)
        except ImportError:  # made by another Python, or cut off: Numba will do
            return ()
        found.append(Entry(getattr(module, name), tuple(map(_check, arguments))))
    return tuple(found)


@functools.cache
def _library() -> Path | None:
    if os.environ.get("CAMROB_JIT") or os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return None
    return ready_library()


@functools.cache
def _signatures() -> dict[str, list[list[Any]]]:
    ways: dict[str, list[list[Any]]] = {}
    for row in json.loads((HERE / "warm" / "kernels.json").read_text("utf-8")):
        ways.setdefault(row["kernel"], []).append(row["arguments"])
    return ways


def _check(spelling: Any) -> Check:
    """What tells whether a value is of the type that kernels.json spells so (`camrob.warm.signatures`)."""
    if isinstance(spelling, str):
        return _scalar_check(spelling)
    if "array" in spelling:
        return _array_check(spelling)
    kind: Any = tuple
    if "class" in spelling:
        module, _, name = spelling["class"].partition(":")
        kind = getattr(import_module(module), name)
    members = tuple(map(_check, spelling["tuple"]))

    def check(value: Any) -> bool:
        return type(value) is kind and len(value) == len(members) and all(map(_holds, members, value))

    return check


def _scalar_check(spelling: str) -> Check:
    import numpy as np

    if spelling == "none":
        return lambda value: value is None
    kinds = {"float64": (float, np.float64), "int64": (int, np.int64), "bool": (bool, np.bool_)}[spelling]
    return lambda value: type(value) in kinds


def _array_check(spelling: dict[str, Any]) -> Check:
    import numpy as np

    element, dimensions = np.dtype(spelling["array"]), spelling["dimensions"]
    if spelling["layout"] == "C" and spelling["mutable"]:
        return lambda a: type(a) is np.ndarray and a.dtype == element and a.ndim == dimensions and a.flags.carray
    if spelling["layout"] == "C":
        return lambda a: (
            type(a) is np.ndarray
            and a.dtype == element
            and a.ndim == dimensions
            and a.flags.c_contiguous
            and a.flags.aligned
        )
    return lambda a: (
        type(a) is np.ndarray
        and a.dtype == element
        and a.ndim == dimensions
        and a.flags.aligned
        and (a.flags.writeable or not spelling["mutable"])
    )


def keep_kernels_fresh() -> None:
    """Give what Numba compiles a cache folder of its own for every state of the sources.

    Numba recompiles a function when its own file changes, not when one that it calls lies in another file and changes.
    A folder that the user set (NUMBA_CACHE_DIR) is left alone. A process that has loaded Numba already has read its settings:
    they are set there too, since Numba would otherwise compile every kernel again into `__pycache__`.
    """
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    place = os.path.join(cache_folder(), "kernels-" + source_state())
    try:
        os.makedirs(place, exist_ok=True)
    except OSError:
        return  # nowhere to write: Numba's own places will do
    if os.access(place, os.W_OK):
        os.environ["NUMBA_CACHE_DIR"] = place
        loaded = sys.modules.get("numba.core.config")
        if loaded is not None:
            vars(loaded)["CACHE_DIR"] = place
