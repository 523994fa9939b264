"""The end of what is read of a program."""

from __future__ import annotations

__all__ = ["MOST_STEPS", "UnreadError"]

MOST_STEPS = 200_000  # blocks that one program runs: what goes on longer has no end that is waited for


class UnreadError(Exception):
    """A statement that is not read; its text says what it is. What lies behind it is not read either."""
