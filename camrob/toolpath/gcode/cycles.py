"""Canned cycles (G73, G74, G81, G82, G83, G84, G85, G86, G89) as the moves that they stand for."""

from __future__ import annotations

from enum import StrEnum

from camrob.errors import ToolpathError
from camrob.units import mm_to_m

__all__ = ["CYCLES", "TAPS", "Step", "hole"]

TAPS = {740: "CCLW", 840: "CLW"}  # the sense in which the spindle turns on the way in
CYCLES = frozenset((730, 810, 820, 830, 850, 860, 890, *TAPS))
_MOST_PECKS = 2000  # of one hole: a slip of the decimal point has more
_SLIVER = 0.01  # of a bite: what is left of less joins the one before it
_PECK_CLEARANCE = mm_to_m(0.254)  # LinuxCNC's: ten thousandths of an inch


class Step(StrEnum):
    """What one step of a cycle is."""

    RAPID = "rapid"  # to a height
    CUT = "cut"  # to a height
    DWELL = "dwell"  # value: seconds
    SPINDLE_STOP = "spindle_stop"
    SPINDLE_START = "spindle_start"
    SPINDLE_REVERSE = "spindle_reverse"


def hole(code: int, retract: float, bottom: float, end: float, peck: float, dwell: float) -> list[tuple[Step, float]]:
    """The steps of one hole, starting at height `retract`: heights in m along the cycle's normal, dwell in s.

    `bottom` is the hole's depth, `end` the height in the end, `peck` the bite of G73 and G83.
    Raises ToolpathError for a bottom above the retract height and for a peck that is missing or absurd.
    """
    if bottom > retract:
        raise ToolpathError("a cycle's depth Z lies above its retract height R", hint="check Z, R and G90/G91")
    steps: list[tuple[Step, float]] = []
    if code in (730, 830):
        steps += _pecks(code, retract, bottom, peck)
    else:
        steps.append((Step.CUT, bottom))
    if code not in (810, 850) and dwell > 0.0:  # at the bottom, where the word stands; the two have none
        steps.append((Step.DWELL, dwell))
    if code in (850, 890):
        steps.append((Step.CUT, retract))
    elif code in TAPS:
        steps += [(Step.SPINDLE_REVERSE, 0.0), (Step.CUT, retract), (Step.SPINDLE_START, 0.0)]
    elif code == 860:
        steps += [(Step.SPINDLE_STOP, 0.0), (Step.RAPID, end), (Step.SPINDLE_START, 0.0)]
        return steps
    steps.append((Step.RAPID, end))
    return steps


def _pecks(code: int, retract: float, bottom: float, peck: float) -> list[tuple[Step, float]]:
    """Bites down to the bottom: G83 clears the hole between them, G73 only breaks the chip."""
    if not peck > 0.0 or (retract - bottom) / peck > _MOST_PECKS:
        raise ToolpathError("a peck cycle without a sensible bite Q", hint="give Q as a positive depth for each peck")
    steps: list[tuple[Step, float]] = []
    depth = retract - peck
    while depth > bottom + max(_SLIVER * peck, 1e-12):
        steps.append((Step.CUT, depth))
        if code == 830:
            steps += [(Step.RAPID, retract), (Step.RAPID, min(retract, depth + _PECK_CLEARANCE))]
        else:
            steps.append((Step.RAPID, min(retract, depth + _PECK_CLEARANCE)))
        depth -= peck
    steps.append((Step.CUT, bottom))
    return steps
