"""Between program and set-point: whether the rounding of corners explains it, with which distance, on withheld samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.corner_rounding import DISTANCE, EFFECT
from camrob.gap.evidence.shrink import Shrinkage, figures
from camrob.gap.observation.program_track import ProgramTrack
from camrob.summaries.diagnosis_places import StageWithin
from camrob.summaries.diagnosis_summary import Alternative, CornerFigures, DiagnosisSummary, EffectFound, FittedValue
from camrob.units import m_to_mm, mm_to_m

__all__ = ["CornerVerdict", "judge_corners", "with_corners"]

Array = NDArray[np.float64]

_BLOCKS = 10  # a log
_MOST = 1500  # samples a log that distances are tried on
_TRIED = mm_to_m(np.geomspace(0.05, 50.0, 13))
_REFINED = 7  # times that the interval about the best distance is narrowed
_LEAST = mm_to_m(0.01)  # rms: what set-points deviate by less is printing
_PRINTED = 5.0 * _LEAST  # rms that is not worth a word
_LEAST_NOISE = 0.35  # of the instrument's noise: as for all effects
_LEAST_SHRINK = 0.25  # of the deviation, that rounding has to explain
_DRAWS = 400
_SURE = 0.98
_SAME = 1e-3  # share of a distance that is not looked at more closely
_MOST_SETS = 12
_UNTOLD = 0.9  # probability of something unknown, where much stays


@dataclass(frozen=True)
class CornerVerdict:
    """probability of corner_rounding; entry: what is said of it, None where nothing deviates; left: m rms that stays
    between program and set-point; unknown: words on it where that is too much, else ""; stage: what that is within.
    """

    probability: float
    entry: EffectFound | None
    left: float
    unknown: str
    stage: StageWithin


def judge_corners(
    tracks: Sequence[ProgramTrack], noise: float, *, known: bool = True, tolerance: float = 0.0
) -> CornerVerdict | None:
    """Judge the first stage of logs whose programs are known; None without any.

    One distance is fitted to all corners by the virtual controller, each stretch of the logs judged with the distance that
    the others ask for. noise: m, 3-D rms of the instrument; known: False where the effect is out of the library; tolerance: m
    that the logs' user lives with, 0 where nobody says.
    """
    if not tracks:
        return None
    least = max(_LEAST, _LEAST_NOISE * noise)
    rows = [np.unique(np.linspace(0, len(t.scene) - 1, min(len(t.scene), _MOST)).astype(np.int64)) for t in tracks]
    before = np.concatenate([t.offset(t.path(0.0))[r] for t, r in zip(tracks, rows, strict=True)])
    block = np.concatenate([k * _BLOCKS + (np.arange(len(r)) * _BLOCKS) // len(r) for k, r in enumerate(rows)])
    size = float(np.sqrt(np.mean(np.sum(before**2, axis=1))))
    stage = _stage(before, noise, tolerance)
    if size < least:
        return CornerVerdict(0.0, None, size, "", stage)
    thinned = [t.at(r) for t, r in zip(tracks, rows, strict=True)]

    def after(distance: float) -> Array:
        return np.concatenate([t.offset(t.path(distance)) for t in thinned])

    found = {0.0: before, **{float(d): after(float(d)) for d in _TRIED}}
    for _ in range(_REFINED):
        found |= {d: after(d) for d in _between(found)}
    names = np.array(sorted(found))
    numbers = np.unique(block)
    energy = np.array([[np.sum(found[d][block == b] ** 2) for b in numbers] for d in names])
    chosen = np.argmin(energy.sum(axis=1, keepdims=True) - energy, axis=0)
    rest = np.concatenate([found[names[k]][block == b] for k, b in zip(chosen, numbers, strict=True)])
    shrunk = Shrinkage(before, rest, block)
    best = int(np.argmin(energy.sum(axis=1)))
    probability = _probability(shrunk, float(names[best])) if known else 0.0
    if probability < 0.5:
        return CornerVerdict(probability, None, size, _beyond_text(size, noise, tolerance), stage)
    value, std = float(names[best]), _spread(names, energy.sum(axis=1), best, len(numbers))
    entry = _entry(shrunk, probability, value, std, _asked(tracks))
    return CornerVerdict(probability, entry, shrunk.rms_after, _beyond_text(shrunk.rms_after, noise, tolerance), stage)


def _between(found: dict[float, Array]) -> list[float]:
    """The distances half-way between the best one so far and its neighbours."""
    names = sorted(found)
    k = int(np.argmin([np.sum(found[d] ** 2) for d in names]))
    near = [names[i] for i in (k - 1, k + 1) if 0 <= i < len(names)]
    return [0.5 * (names[k] + d) for d in near if abs(d - names[k]) > _SAME * names[k]]


def _probability(shrunk: Shrinkage, distance: float) -> float:
    """From how often, stretches drawn anew, rounding explains a good part; little where the distance can't be true."""
    numbers = np.unique(shrunk.block)
    sums = np.array([[np.sum(e[shrunk.block == b] ** 2) for b in numbers] for e in (shrunk.before, shrunk.after)])
    draws = np.random.default_rng(0).integers(0, len(numbers), (_DRAWS, len(numbers)))
    before, after = sums[0][draws].sum(axis=1), sums[1][draws].sum(axis=1)
    often = float(np.mean(after < (1.0 - _LEAST_SHRINK) ** 2 * before))
    plausible = 0.0 < distance < 0.99 * DISTANCE.upper
    return _SURE * often if plausible else min(0.4, often)


def _spread(names: Array, energy: Array, best: int, blocks: int) -> float:
    """1-sigma of the distance from the energy's curvature at its least, stretches counting once each."""
    near = np.arange(max(best - 1, 0), min(best + 2, len(names)))
    if len(near) < 3 or energy[best] <= 0.0:
        return float(np.ptp(names[near]))
    curvature = float(np.polyfit(names[near] - names[best], energy[near], 2)[0])
    if curvature <= 0.0:
        return float(np.ptp(names[near]))
    return float(min(np.sqrt(energy[best] / blocks / curvature), np.ptp(_TRIED)))


def _asked(tracks: Sequence[ProgramTrack]) -> float | None:
    """mm, the one rounding distance of the programs; None where there are several."""
    values = np.concatenate([np.asarray(t.program.blend_mm) for t in tracks])
    radii = np.unique(np.round(values[np.isfinite(values)], 6))
    return float(radii[0]) if len(radii) == 1 else None


def _stage(before: Array, noise: float, tolerance: float) -> StageWithin:
    """What deviations (N, 3) from the program are within; what the instrument's noise would hide counts as none."""
    off = np.linalg.norm(before, axis=1)
    rms, p95, least = float(np.sqrt(np.mean(off**2))), float(np.quantile(off, 0.95)), max(noise, _PRINTED)
    return StageWithin(
        within="noise" if rms < least else "tolerance" if p95 < tolerance else "beyond",
        rms_mm=m_to_mm(rms),
        p95_mm=m_to_mm(p95),
        noise_mm=m_to_mm(least),
        noise_told=False,
        tolerance_mm=m_to_mm(tolerance) if tolerance > 0.0 else None,
        axis="",
    )


def _beyond_text(left: float, noise: float, tolerance: float) -> str:
    if left < max(noise, _PRINTED, tolerance):
        return ""
    return (
        f"between program and set-point, {m_to_mm(left):.3f} mm rms that the rounding of corners does not explain "
        "(targets that were changed, or another base or tool on the controller)"
    )


def _entry(shrunk: Shrinkage, probability: float, value: float, std: float, asked: float | None) -> EffectFound:
    sizes = figures(shrunk)
    return EffectFound(
        effect=EFFECT.name,
        axes=(),
        probability=probability,
        parameters={DISTANCE.name: FittedValue(value=m_to_mm(value), std=m_to_mm(std))},
        **sizes.to_json(),
        alone=sizes,
        added_last=sizes,
        moves_mm=sizes.rms_before_mm,
        indistinguishable_from=(),
        alike=(EFFECT.name,),
        class_probability=probability,
        evidence=probability,
        implausible="",
        compensable=EFFECT.compensable,
        stages=tuple(EFFECT.stages),
        regimes=tuple(EFFECT.regimes),
        corner=CornerFigures(programmed_cdis_mm=asked),
        unusual="",
        remedy=EFFECT.remedy,
        isolated_by=EFFECT.experiment,
    )


def with_corners(summary: DiagnosisSummary, verdict: CornerVerdict | None) -> DiagnosisSummary:
    """The summary with what lies between program and set-point: its own stage, so `gap` and `together` stay as they are."""
    if verdict is None:
        return summary
    out = replace(
        summary,
        within={"program_to_setpoint": verdict.stage.within, **summary.within},
        within_values={"program_to_setpoint": verdict.stage, **summary.within_values},
        where=replace(summary.where, program_left_mm=m_to_mm(verdict.left)),
    )
    if verdict.entry is not None:
        out = replace(
            out,
            effects=tuple(sorted([*summary.effects, verdict.entry], key=lambda e: (-e.probability, -e.shrink))),
            alternatives=_crossed(summary.alternatives, EFFECT.name, verdict.probability),
            status="explained" if summary.status == "no gap" else summary.status,
        )
    if verdict.unknown:
        unknown = summary.unknown
        text = "; ".join(w for w in (unknown.text, verdict.unknown) if w)
        where = replace(unknown.where, stage=unknown.where.stage or "program_to_setpoint")
        likely = max(unknown.probability, _UNTOLD)
        out = replace(
            out,
            unknown=replace(unknown, where=where, text=text, probability=likely),
            status="partly explained" if out.status in ("explained", "partly explained") else "unexplained",
        )
    return out


def _crossed(sets: Sequence[Alternative], name: str, probability: float) -> tuple[Alternative, ...]:
    """Sets of effects with and without another one, which is independent of them."""
    total: dict[tuple[str, ...], float] = {}
    for one in sets:
        for names, share in (({*one.effects, name}, probability), (set(one.effects), 1.0 - probability)):
            key = tuple(sorted(names))
            total[key] = total.get(key, 0.0) + share * one.probability
    kept = sorted(total.items(), key=lambda x: -x[1])[:_MOST_SETS]
    whole = sum(p for _, p in kept)
    return tuple(Alternative(effects=k, probability=p / whole) for k, p in kept)
