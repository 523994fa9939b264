"""Text from files, made fit to stand in a message."""

from __future__ import annotations

__all__ = ["one_line", "printable"]


def printable(value: object) -> str:
    """Anything as text that can be shown: control characters, line ends of any kind and direction marks become blanks."""
    text = str(value)
    return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)


def one_line(text: str, longest: int) -> str:
    """Text as one printable line of at most `longest` characters, whatever a file held; what is cut off is marked.

    Control characters, line separators of any kind and direction marks become blanks.
    """
    plain = printable(text).strip()
    return plain if len(plain) <= longest else plain[: longest - 4] + " ..."
