"""Who hears of it when kernels compile: Numba says nothing itself, and on a machine's first run it takes long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Listener", "report_compile", "reporting_compiles"]

Listener = Callable[[str], None]
"""Takes the name of the kernel that begins to compile."""

_listeners: list[Listener] = []


@contextmanager
def reporting_compiles(listener: Listener) -> Iterator[None]:
    """While it lasts, the listener is called with each kernel that begins to compile (and is not in the cache)."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def report_compile(kernel: str) -> None:
    """Say that a kernel begins to compile."""
    for listener in tuple(_listeners):
        listener(kernel)
