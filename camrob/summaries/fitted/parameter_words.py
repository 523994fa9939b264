"""What the name of a fitted parameter says: its unit stands behind it."""

from __future__ import annotations

__all__ = ["parameter_words"]

_UNITS = {
    "_rad_nm": "rad/Nm",
    "_rad_m": "rad/m",
    "_m_nm": "m/Nm",
    "_kg_m": "kg m",
    "_deg": "degrees",
    "_mm": "mm",
    "_kg": "kg",
    "_s2": "s²",
    "_s": "s",
}
_WORDS = {"cdis": "rounding distance", "tau": "time constant"}


def parameter_words(name: str) -> tuple[str, str]:
    """A parameter's name as people read it, and its unit: both stand in the name."""
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return _in_words(name.removesuffix(ending)), unit
    return _in_words(name), "degrees a degree" if "_by_" in name else ""


def _in_words(name: str) -> str:
    return " ".join(_WORDS.get(word, word) for word in name.split("_"))
