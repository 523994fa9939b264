"""The instrument as a suspect: what of the gap may be its own, which rows are gross, and what it can't be told from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from camrob.gap.effects.common import PPM
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.gap.observation.few_decimals import rounding_of
from camrob.gap.observation.noise import local_of
from camrob.gap.verdict.belief import BELIEF
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound
from camrob.summaries.fitted.instrument_figures import GrossRow, GrossRows, InstrumentSuspect
from camrob.units import m_to_mm

__all__ = ["also_said", "instrument_suspect"]

_ROWS = 20  # that are named
_MOVED = (
    'it stood elsewhere from log to log, though all say measured_frame = "world": each was given a frame of its own, beside '
    "which the robot's foot can't be judged"
)
_PART, _MOST = (
    0.3,
    2.0,
)  # of what stays, that coarse steps have to leave to be said: places that were commanded may be whole degrees


def instrument_suspect(
    model: Model,
    effects: Sequence[EffectFound],
    late: Mapping[str, float] | None = None,
    stays: float = 0.0,
    *,
    moved: bool = False,
) -> InstrumentSuspect:
    """suspect: probability that an error of the instrument is at work; scale_ppm, drift_mm (its size over a log): as
    fitted, None where not; gross: by log, how many rows are, and the first of them by number (from 1) and time.

    late: s by which readings came late, by log, taken off before; stays: m (rms) that nothing explains, which values of too few
    decimals may be; moved: logs that all say world were given frames of their own, as it stood elsewhere from one to the next.
    """
    accuses = {e.name: e.of_instrument for e in model.effects if e.of_instrument is not None}
    claims = {e.effect: e for e in effects if e.effect in accuses}
    values = {n: fit.value for e in claims.values() for n, fit in e.parameters.items()}
    steady = [v for n, v in values.items() if n.startswith("drift_") and n.endswith("_mm")]
    gross = [one for p in model.panels if (one := _gross(p)).rows]
    keys = {n: [u.key for i, u in enumerate(model.units) if u.effect == n and i in model.best.members] for n in claims}
    accusations = [
        words
        for n, e in claims.items()
        if e.claimed
        and (words := accuses[n]({k: v.value for k, v in e.parameters.items()}, e.indistinguishable_from, keys[n]))
    ]
    return InstrumentSuspect(
        suspect=max([*(e.probability for e in claims.values()), BELIEF.likely if moved else 0.0]),
        scale_ppm=PPM * values["scale"] if "scale" in values else None,
        drift_mm=float(np.linalg.norm(steady)) if steady else None,
        gross=tuple(gross),
        text=_words([*([_MOVED] if moved else []), *accusations, *_coarse(model, stays)], gross, late or {}),
    )


def also_said(summary: DiagnosisSummary, words: Sequence[str]) -> DiagnosisSummary:
    """The same, and of the instrument first what was put right before anything was compared."""
    said = [*words, *([summary.instrument.text] if summary.instrument.text else [])]
    return replace(summary, instrument=replace(summary.instrument, text="; ".join(said)))


def _coarse(model: Model, stays: float) -> list[str]:
    """Of each log, values in steps that alone leave a good part of what stays, and more than the noise that was told."""
    said = []
    for scene in model.scenes:
        told = float(np.nan_to_num(scene.sigma[0])) * float(np.sqrt(3.0))
        for words, rms in rounding_of(scene):
            if max(told, _PART * stays) < rms < _MOST * stays:
                size = f"{m_to_mm(rms):.2g} mm rms at the tool"
                said.append(f"{scene.name}: {words}, which alone leaves {size}: log more decimals")
    return said


def _gross(panel: Panel) -> GrossRows:
    """The rows of a log that stand far from all others and take no part, and share no place."""
    shared = local_of(panel.scene)
    alone = True if shared is None else ~shared.rows
    rows = np.flatnonzero((panel.w_tcp[:, :3] == 0.0).any(axis=1) & panel.scene.seen[:, 0] & alone)
    size = np.linalg.norm(panel.scene.tcp_gap[rows, :3], axis=1)
    return GrossRows(
        log=panel.scene.name,
        rows=len(rows),
        share=len(rows) / len(panel.scene),
        first=tuple(
            GrossRow(sample=int(r) + 1, t_s=float(panel.scene.t[r]), off_mm=m_to_mm(float(s)))
            for r, s in list(zip(rows.tolist(), size.tolist(), strict=True))[:_ROWS]
        ),
    )


def _words(accusations: Sequence[str], gross: Sequence[GrossRows], late: Mapping[str, float]) -> str:
    """What is said of the instrument: of its clock, by the effects that accuse it, and of gross rows."""
    said = []
    for log, seconds in late.items():
        when = f"{abs(seconds):.3f} s {'after' if seconds > 0.0 else 'before'} the axis values that they belong to"
        said.append(
            f"the readings of {log} came {when}, and were brought to them first: give both recordings one clock"
        )
    said += accusations
    for one in gross:
        first = ", ".join(str(r.sample) for r in one.first)
        first += f" and {one.rows - len(one.first)} more" if one.rows > len(one.first) else ""
        said.append(f"{one.rows} rows of {one.log} are gross and take no part (samples {first})")
    return "; ".join(said)
