"""What a run leaves in the data lists, which outlive it, and whether another one after it does the same."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from camrob.witness.krl.columns import Motions
from camrob.witness.krl.scope import Scope
from camrob.witness.krl.state import State
from camrob.witness.krl.values import Value, Variables

__all__ = ["alike", "left_over"]

_REAL = ("pose", "middle", "sweep", "axes", "speed")  # of the motions' columns, those that may be NaN
_UNKNOWN = "#UNKNOWN"  # stands for a value that the text doesn't say: no number, no truth


def left_over(
    variables: Variables, data: Mapping[str, Scope], before: Mapping[str, Mapping[str, Value]]
) -> dict[str, dict[str, Value]]:
    """What a run leaves in the data lists (by file, "" those of all) other than it was; `before`: what the run before it left."""
    left = {key: dict(values) for key, values in before.items()}
    for key, place in (("", variables.common), *data.items()):
        for (owner, head), old in variables.kept.items():
            if owner == id(place) and place.get(head, _UNKNOWN) != old:
                left.setdefault(key, {})[head] = place.get(head, _UNKNOWN)
    return left


def alike(first: State, motions: Motions, second: State, again: Motions) -> bool:
    """Whether two runs do the same, and the second one leaves no more unjudged."""
    same = len(again) == len(motions) and all(
        np.array_equal(getattr(motions, part), getattr(again, part), equal_nan=part in _REAL)
        for part in Motions.__slots__
    )
    frames = (first.bases, first.tools, first.events) == (second.bases, second.tools, second.events)
    frames &= repr(first.loads) == repr(second.loads)  # NaN among them
    return same and frames and len(second.gaps) <= len(first.gaps)
