"""The end of what is read of a program."""

from __future__ import annotations

__all__ = ["NOWHERE", "UnreadError"]

NOWHERE = "a jump or call to what isn't in the file"


class UnreadError(Exception):
    """A statement that is not read; its text says what it is. What lies behind it is not read either."""
