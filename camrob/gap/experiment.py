"""The next experiment: the motion that would separate the closest rivals best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.gap.effects.effect import Effect

__all__ = ["next_experiment"]

_MOTIONS: dict[str, dict[str, float]] = {
    "the same program backwards": {"direction": 2.0},
    "the same program at half speed": {"speed": 0.5, "acceleration": 0.75},
    "the same program with another payload": {"load": 1.0},
    "the same program in air": {"force": 1.0},
    "the same program after an hour of warming up": {"time": 1.0},
    "the same part with the track 0.5 m further and the table turned by 90 degrees": {"position": 1.0},
}
"""Motions, and by what share each changes what an effect of a regime causes."""


def next_experiment(
    claimed: Sequence[str], rivals: Mapping[str, float], sizes_mm: Mapping[str, float], library: Sequence[Effect],
    unknown: str,
) -> str:  # fmt: skip
    """What to run next, and what it would show. rivals: probability of the effects that are considered; unknown: where
    something unexplained sits, "" where nothing does.
    """
    by_name = {e.name: e for e in library}
    if unknown:
        text = "move that axis alone through its range, the others at rest, and measure"
        return f"Isolate what is unexplained ({unknown}): {text}."
    order = sorted((n for n in rivals if n in by_name and n not in claimed), key=lambda n: -rivals[n])
    pair = [*claimed, *order][:2] if len(claimed) < 2 or not order else [claimed[0], order[0]]
    if not pair:
        return "None needed: the gap is the instrument's noise. A larger work space would test more."
    if len(pair) == 1:
        only = by_name.get(pair[0])
        return f"To confirm {pair[0]}: {only.experiment}." if only is not None else ""
    first, second = (by_name[n] for n in pair if n in by_name)
    size = max(sizes_mm.get(first.name, 0.0), sizes_mm.get(second.name, 0.0))

    def apart(changes: Mapping[str, float]) -> float:
        return abs(max((changes.get(r, 0.0) for r in first.regimes), default=0.0)
                   - max((changes.get(r, 0.0) for r in second.regimes), default=0.0))  # fmt: skip

    best = max(_MOTIONS, key=lambda m: apart(_MOTIONS[m]))
    gain = apart(_MOTIONS[best])
    if gain <= 0.0:
        return f"To tell {first.name} from {second.name}: {first.experiment}."
    expected = f", expected to set them apart by about {gain * size:.2f} mm" if size > 0.0 else ""
    return f"To tell {first.name} from {second.name}, run {best}{expected}. Or: {first.experiment}."
