"""Text from files, made fit to stand in a message."""

from __future__ import annotations

__all__ = ["one_line"]


def one_line(text: str, longest: int) -> str:
    """Text as one printable line of at most `longest` characters, whatever a file held; what is cut off is marked.

    Control characters, line separators of any kind and direction marks become blanks.
    """
    plain = (text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)).strip()
    return plain if len(plain) <= longest else plain[: longest - 4] + " ..."
