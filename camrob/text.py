"""Text from files: read as far as files go, and made fit to stand in a message."""

from __future__ import annotations

from math import floor, log10
from pathlib import Path

__all__ = ["bytes_of", "one_line", "printable", "short", "utf_16"]

_LOOK = 64  # bytes that show how a text is written
_TINY = 1e-6  # below which a number reads better with its power of ten


def bytes_of(path: Path, most: int) -> bytes:
    """A file's bytes, no more than `most` and one, which tells that there are too many: a device has no end. Raises OSError."""
    with path.open("rb") as file:
        return file.read(most + 1)


def short(value: float) -> str:
    """A small number in two figures that count, written out: 0.031 and not 3.1e-02, as a workshop reads it."""
    if abs(value) >= 10.0 or value == 0.0:
        return f"{value:.0f}"
    if abs(value) < _TINY:
        return f"{value:.1e}"
    return f"{value:.{1 - floor(log10(abs(value)))}f}"


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


def utf_16(data: bytes) -> bool:
    """Whether bytes begin as a text in UTF-16 does: with its mark, or with plain letters that have a zero each beside them."""
    head = data[:_LOOK] if len(data) % 2 == 0 else data[: min(_LOOK, len(data) - 1)]
    first, second = head[0::2], head[1::2]
    plain = any(len(a) > 1 and not any(a) and all(b) and b.isascii() for a, b in ((first, second), (second, first)))
    return data.startswith((b"\xff\xfe", b"\xfe\xff")) or plain
