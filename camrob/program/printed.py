"""What all languages print alike: numbers with a fixed count of decimals, and text of any origin in 7-bit characters on one line.

What a controller or the editor on its pendant reads in such a text differs from language to language, and is the language's own.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["fixed_decimals", "plain_text", "rounded", "shortened"]

_SPELLED = {
    "ß": "ss",
    "æ": "ae",
    "Æ": "AE",
    "œ": "oe",
    "Œ": "OE",
    "ø": "o",
    "Ø": "O",
    "đ": "d",
    "Đ": "D",
    "ł": "l",
    "Ł": "L",
    "ä": "ae",
    "ö": "oe",
    "ü": "ue",
    "Ä": "Ae",
    "Ö": "Oe",
    "Ü": "Ue",
    "°": " deg",
    "µ": "u",
    "μ": "u",
    "×": "x",
    "·": ".",
    "–": "-",
    "—": "-",
    "−": "-",
    "‘": "'",
    "’": "'",
    "“": '"',
    "”": '"',
    "„": '"',
    "…": "...",
    "±": "+-",
}


def plain_text(text: str, instead: Mapping[str, str]) -> str:
    """The text in printable 7-bit characters on one line: letters are transliterated, line ends and control characters become
    blanks. instead: what stands for signs that mean something to the language.
    """
    spelled = _SPELLED | dict(instead)
    kept = []
    for c in unicodedata.normalize("NFKD", "".join(spelled.get(c, c) for c in unicodedata.normalize("NFC", text))):
        if c.isspace() or not c.isprintable():
            kept.append(" ")
        elif not unicodedata.combining(c):
            kept.append(spelled.get(c, c) if c.isascii() else "?")
    return " ".join("".join(kept).split())


def shortened(text: str, longest: int) -> str:
    """The text, or as much of it as `longest` characters hold, with two points behind it."""
    return text if len(text) <= longest else text[: longest - 2].rstrip() + ".."


def fixed_decimals(value: float, decimals: int) -> str:
    """A number with a fixed count of decimals; zero never has a sign. Raises ValueError where it is not finite."""
    if not math.isfinite(value):
        raise ValueError(f"{value} can't be printed")
    text = f"{value:.{decimals}f}"
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def rounded(values: ArrayLike, decimals: int) -> NDArray[np.float64]:
    """Rounded, without negative zeros. Each result is the double nearest to its decimal text."""
    return np.asarray(np.round(np.asarray(values, dtype=np.float64), decimals) + 0.0)
