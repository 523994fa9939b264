"""The end of what is read of a program."""

from __future__ import annotations

__all__ = ["UnreadError"]


class UnreadError(Exception):
    """A statement that is not read; its text says what it is. What lies behind it is not read either."""
