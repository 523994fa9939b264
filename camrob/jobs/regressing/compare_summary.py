"""What changed between two JSON summaries of one post."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ["comparable", "compare_summary"]

_LEFT_OUT = ("seconds", "collisions.sampled", "verified.by", "manifest")
_PRINTED = 2e-3  # mm and degrees: two units in the last printed decimal
_RELATIVE = 1e-5  # of every other number


def comparable(summary: Mapping[str, Any]) -> dict[str, Any]:
    """The summary without what differs from run to run, or says only how it was worked out."""
    out = {key: value for key, value in summary.items() if key not in _LEFT_OUT}
    for dotted in _LEFT_OUT:
        outer, _, inner = dotted.partition(".")
        if inner and isinstance(out.get(outer), Mapping):
            out[outer] = {key: value for key, value in out[outer].items() if key != inner}
    return out


def compare_summary(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """What differs, a line each: numbers beyond rounding, anything else at all; keys that came and went."""
    old, new = dict(_flat(comparable(before))), dict(_flat(comparable(after)))
    differences = []
    for key in [*old, *(k for k in new if k not in old)]:
        if key not in new:
            differences.append(f"{key} is gone (was {_shown(old[key])})")
        elif key not in old:
            differences.append(f"{key} is new: {_shown(new[key])}")
        elif not _alike(key, old[key], new[key]):
            differences.append(f"{key} was {_shown(old[key])}, is {_shown(new[key])}{_change(old[key], new[key])}")
    return differences


def _flat(value: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Plain values under dotted names; members of lists are numbered from 1."""
    members: Any = ()
    if isinstance(value, Mapping):
        members = value.items()
    elif isinstance(value, list | tuple):
        members = enumerate(value, start=1)
    else:
        yield prefix, value
    for key, below in members:
        yield from _flat(below, f"{prefix}.{key}" if prefix else str(key))


def _alike(key: str, was: Any, now: Any) -> bool:
    if not (_number(was) and _number(now)) or (isinstance(was, int) and isinstance(now, int)):
        return type(was) is type(now) and bool(was == now)
    edge = "_mm" in key or "_deg" in key or "margin_min" in key
    allowed = (_PRINTED if edge else 1e-9) + _RELATIVE * max(abs(float(was)), abs(float(now)))
    return abs(float(now) - float(was)) <= allowed


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else repr(value)


def _change(was: Any, now: Any) -> str:
    return f" ({now - was:+.4g})" if _number(was) and _number(now) else ""
