"""Names that move the tool by far more than the gap: they stand only with what cancels them, and are no surer than that."""

from __future__ import annotations

from collections.abc import Mapping

from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import settled_rms

__all__ = ["no_surer_than_partners"]

_FAR_MORE = 1.5  # times the gap (rms), that a name moves the tool by which others cancel


def no_surer_than_partners(model: Model, probability: Mapping[str, float]) -> dict[str, float]:
    """Probabilities of effects, of which a claim that moves the tool by far more than the gap is no surer than the least sure of
    the others: without that one it would have another size, or not be there. A hose that pulls a wrist was a zero at 97 %, of
    twice the gap, with a ripple and a coupling that took it back.
    """
    claimed = {n: p for n, p in probability.items() if p >= 0.5}
    most = _FAR_MORE * model.gap
    large = [n for n in claimed if len(claimed) > 1 and settled_rms(model, model.panels, [n]) > most]
    return {**probability, **{n: min(claimed[n], *(p for m, p in claimed.items() if m != n)) for n in large}}
