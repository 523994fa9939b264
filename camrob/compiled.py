"""How camrob's compiled functions are marked: kernels, which Python calls, and the parts that they are made of.

A kernel that was compiled ahead (`camrob.warm`) is machine code in a library beside this package, and needs no Numba: it is taken
where the sources are those that it was made from and the arguments those that it was made for. Every other call goes to
Numba, which is imported and compiles when that happens first (`camrob.compiler`). Environment: CAMROB_JIT, set to anything,
leaves what was compiled ahead aside.

Only a kernel has a face to Python and machine code of its own. A part is compiled into the kernels that call it and nowhere
else: what unpacks a hundred arrays that Python might hand over costs more than most parts themselves, and for a part nobody
would ever call it. Called from Python, a part is the plain function that its source says.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import import_module
from typing import Any

from camrob.machine_code import Entry, entries_of

__all__ = ["Kernel", "bare", "inlined", "kernel", "part", "take_parts"]

Decorator = Callable[..., Any]
Register = Callable[[Callable[..., Any], dict[str, Any]], None]


class Kernel:
    """A function that Python calls and a compiler has made fast.

    Attributes: name, module:name; py_func, the function as its source says; options, Numba's, beside those that all kernels have.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self.name = f"{function.__module__}:{function.__qualname__}"
        self.py_func = function
        self.options = options
        self._entries: tuple[Entry, ...] | None = None
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        """Run it: the machine code that was compiled ahead where it is made for such arguments, else Numba's."""
        if self._entries is None:
            self._entries = entries_of(self.name)
        for entry in self._entries:
            if entry.takes(arguments):
                return entry.call(*arguments)
        return self.dispatcher(*arguments)

    @functools.cached_property
    def dispatcher(self) -> Any:
        """Numba's object for it, which compiles for whatever it is called with."""
        return import_module("camrob.compiler").dispatcher(self.py_func, self.options)


def kernel(function: Callable[..., Any] | None = None, /, **options: Any) -> Any:
    """Mark a function that Python calls. Its arrays have one layout and are writable, so that it is compiled once."""
    return functools.partial(kernel, **options) if function is None else Kernel(function, options)


_parts: list[tuple[Callable[..., Any], dict[str, Any]]] = []
_register: Register = lambda function, options: _parts.append((function, options))  # noqa: E731  # until Numba is there


def take_parts(register: Register) -> None:
    """Hand all parts to a compiler: those that have been marked, and each that will be."""
    global _register
    _register = register
    for function, options in _parts:
        register(function, options)
    _parts.clear()


def _part(**options: Any) -> Decorator:
    def mark(function: Callable[..., Any]) -> Any:
        function.part_of_kernels = True  # type: ignore[attr-defined]  # for those who ask what stands in a kernel
        _register(function, options)
        return function

    return mark


part: Decorator = _part()
"""A function that only kernels call."""

inlined: Decorator = _part(forceinline=True)
"""A part that stands in its caller's code, wherever it is called."""

bare: Decorator = _part(forceinline=True, error_model="numpy", _nrt=False)
"""An inlined part that makes no arrays, counts no references, and divides by zero as NumPy does."""
