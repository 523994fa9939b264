"""Figures of a diagnosis as text: sizes, shares, chances, and fitted values with what is known of them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from camrob.summaries.diagnosis_summary import FittedValue
from camrob.summaries.fitted.parameter_words import parameter_words

__all__ = [
    "beyond_ordinary",
    "fitted",
    "measure",
    "mm",
    "ordinary",
    "share",
    "sure",
    "to_mm",
    "values_of",
    "waves",
]

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_ORDINARY, _MANY = 2.0, 10.0  # times an ordinary size
_LEAST, _MOST = 1e-3, 1e5  # outside of these a power of ten stands behind


def mm(value: float | None, unit: str = " mm") -> str:
    """A distance in mm, to a micrometre at the finest and three digits or so."""
    if value is None or not math.isfinite(value):
        return "–"
    if 0.0 < abs(value) < 0.0005:
        return f"under 0.001{unit}"
    digits = 3 if abs(value) < 1.0 else 2 if abs(value) < 10.0 else 1 if abs(value) < 100.0 else 0
    return f"{value:.{digits}f}{unit}".replace("-", "−")


def to_mm(before: float, after: float) -> str:
    """Before and after, as "0.30 → 0.07 mm"."""
    return f"{mm(before, '')} → {mm(after)}"


def share(value: float) -> str:
    """A share in whole per cent."""
    if 0.0 < abs(value) < 0.005:
        return "under 1 %"
    return f"{100.0 * value:.0f} %".replace("-", "−")


def sure(probability: float) -> str:
    """A chance in whole per cent; neither 0 nor 100 of them are ever known."""
    if probability < 0.01:
        return "under 1 %"
    return "over 99 %" if probability > 0.99 else f"{100.0 * probability:.0f} %"


def measure(value: float, unit: str, digits: int = 3) -> str:
    """A value of any size with its unit, to some digits."""
    return _with_unit(_powered(value, None, digits), unit)


def fitted(value: float, std: float, unit: str) -> str:
    """A value with its standard deviation, both to the digits that the deviation leaves a meaning."""
    return _with_unit(_powered(value, std, 3), unit)


def values_of(parameters: Mapping[str, FittedValue], most: int) -> tuple[list[str], int]:
    """Fitted values of an effect, those that are known best first, and how many more there are."""
    values = {name: (v.value, v.std, *parameter_words(name)) for name, v in parameters.items()}
    for (axis, order), size in waves(parameters).items():
        pair = [f"{axis}_{part}{order}_deg" for part in ("cos", "sin")]
        stds = [values.pop(name)[1] for name in pair if name in values]
        values[pair[0]] = (size, max(stds), f"{axis}, {order} times a turn,", "degrees")
    known = sorted(values.values(), key=lambda x: -abs(x[0]) / max(x[1], 1e-30))
    texts = [f"{words} {fitted(value, std, unit)}" for value, std, words, unit in known[:most] if abs(value) >= std]
    if not texts and len(known) > 1:
        return [f"none of its {len(known)} values is beyond its own doubt"], 0
    texts = texts or [f"{words} {fitted(value, std, unit)}" for value, std, words, unit in known]
    return texts, len(known) - len(texts)


def beyond_ordinary(
    parameters: Mapping[str, FittedValue], times: float
) -> tuple[tuple[str, str], FittedValue, float] | None:
    """The first of an effect's values that is so many times an ordinary one and more: its words and unit, itself, how many times.
    None where none is, or nobody has said what is ordinary.
    """
    for name, value in parameters.items():
        if value.usual > 0.0 and abs(value.value) >= max(times * value.usual, value.std):
            return parameter_words(name), value, abs(value.value) / value.usual
    return None


def ordinary(parameters: Mapping[str, FittedValue]) -> str:
    """How the largest of an effect's values, for its kind, compares with what such machines have; "" where nobody has said."""
    known = {n: v for n, v in parameters.items() if v.usual > 0.0 and abs(v.value) >= v.std}
    if not known:
        return ""
    name = max(known, key=lambda n: abs(known[n].value) / known[n].usual)
    value, usual = abs(known[name].value), known[name].usual
    (words, unit), times = parameter_words(name), value / usual
    if times < _ORDINARY:
        how = "is an ordinary size: such machines have about"
    elif times < _MANY:
        how = f"is {times:.1f} times what such machines ordinarily have, about"
    else:
        how = f"is {_plain(times, None, 2)} times what such machines ordinarily have, about"
    return f"{words}, {measure(value, unit, 2)}, {how} {measure(usual, unit, 1)}"


def waves(parameters: Mapping[str, FittedValue]) -> dict[tuple[str, str], float]:
    """Degrees of each gear ripple among fitted values, by axis and waves a turn."""
    found: dict[tuple[str, str], float] = {}
    for name, fit in parameters.items():
        wave = re.fullmatch(r"(\w+)_(?:cos|sin)([\d.]+)_deg", name)
        if wave is not None:
            at = (str(wave[1]), str(wave[2]))
            found[at] = math.hypot(found.get(at, 0.0), fit.value)
    return found


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}".rstrip()


def _powered(value: float, std: float | None, digits: int) -> str:
    size = max(abs(value), std or 0.0)
    power = math.floor(math.log10(size)) if size > 0.0 else 0
    if size > 0.0 and not _LEAST <= size < _MOST:
        inner = _plain(value / 10.0**power, None if std is None else std / 10.0**power, digits)
        return f"{inner if std is None else f'({inner})'} × 10{str(power).translate(_RAISED)}"
    return _plain(value, std, digits)


def _plain(value: float, std: float | None, digits: int) -> str:
    finest = abs(value) if std is None else std
    if finest <= 0.0:
        return f"{value:.{digits}g}".replace("-", "−")
    power = math.floor(math.log10(finest))
    if std is None:
        decimals = digits - 1 - power
    else:  # a deviation's first digit, or two of them where that is a 1
        decimals = -power + (1 if finest / 10.0**power < 2.0 else 0)
    decimals = min(max(decimals, 0), 9)
    value = round(value, decimals) + 0.0  # no −0
    text = f"{value:.{decimals}f}" + ("" if std is None else f" ± {std:.{decimals}f}")
    return text.replace("-", "−")
