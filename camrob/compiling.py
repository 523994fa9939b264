"""Who is told when kernels compile: Numba says nothing itself, and on a machine's first run it takes long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Told", "tell", "told_of_compiling"]

Told = Callable[[str], None]
"""Takes the name of the kernel that begins to compile."""

_listeners: list[Told] = []


@contextmanager
def told_of_compiling(listener: Told) -> Iterator[None]:
    """While it lasts, the listener is told of each kernel that begins to compile (and is not in the cache)."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def tell(kernel: str) -> None:
    """Say that a kernel begins to compile."""
    for listener in tuple(_listeners):
        listener(kernel)
