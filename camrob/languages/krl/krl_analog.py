"""Outputs that follow the speed of the tool: ANOUT ON in a cell's hooks, for extruders, lasers and the like."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from camrob.errors import CellError

__all__ = ["check_analog"]

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_ON = re.compile(
    rf"ANOUT\s+ON\s+(?P<signal>[A-Z_]\w*)\s*=\s*(?P<factor>{_NUMBER})\s*\*\s*\$VEL_ACT(?:\s*[-+]\s*{_NUMBER})?"
    rf"(?:\s+DELAY\s*=\s*(?P<delay>{_NUMBER}))?(?:\s+MINIMUM\s*=\s*(?P<least>{_NUMBER}))?"
    rf"(?:\s+MAXIMUM\s*=\s*(?P<most>{_NUMBER}))?",
    re.IGNORECASE,
)
_OFF = re.compile(r"ANOUT\s+OFF\s+(?P<signal>[A-Z_]\w*)", re.IGNORECASE)
_ANY = re.compile(r"\s*ANOUT\b", re.IGNORECASE)
_AT_ONCE = 4  # signals that a controller ties at the same time
_LATEST = 0.5  # s of DELAY: none was found in programs or manuals that goes farther
_SHARE = (-1.0, 1.0)  # of the output's range, which is what MINIMUM and MAXIMUM are given in


def check_analog(hooks: Mapping[str, Sequence[str]]) -> None:
    """Raise CellError where an output is tied to the tool's speed in a form that no controller takes, or is never let go.

    What switches off has to stand in `spindle_off` or `footer`: else the process would run on while the arm goes home.
    """
    tied: dict[str, str] = {}
    loose: set[str] = set()
    for name, lines in hooks.items():
        for line in lines:
            code = line.split(";")[0].strip()
            if not _ANY.match(code):
                continue
            on, off = _ON.fullmatch(code), _OFF.fullmatch(code)
            if off is not None:
                loose |= {off["signal"].upper()} if name in ("spindle_off", "footer") else set()
            elif on is None or not _sound(on):
                hint = "write ANOUT ON NAME = 0.5 * $VEL_ACT + 0.1 DELAY=-0.1 MINIMUM=0.0 MAXIMUM=1.0 of a SIGNAL NAME"
                raise CellError(
                    f"hook {name} ties an output in no form that a controller takes: {code[:60]!r}", hint=hint
                )
            else:
                tied[on["signal"].upper()] = name
    for signal, name in tied.items():
        if signal not in loose:
            what = f"hook {name} ties {signal} to the tool's speed, and nothing lets it go"
            raise CellError(what, hint=f"add ANOUT OFF {signal} to spindle_off, or to footer")
    if len(tied) > _AT_ONCE:
        raise CellError(f"{len(tied)} outputs are tied at once", hint=f"a controller takes {_AT_ONCE}")


def _sound(on: re.Match[str]) -> bool:
    """Whether the numbers are such as a controller takes."""
    least, most = float(on["least"] or _SHARE[0]), float(on["most"] or _SHARE[1])
    within = _SHARE[0] <= least < most <= _SHARE[1]
    return float(on["factor"]) > 0.0 and abs(float(on["delay"] or 0.0)) <= _LATEST and within
