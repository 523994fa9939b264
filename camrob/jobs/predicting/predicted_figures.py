"""What is said of a predicted part: figures, places, regions of its surface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.setup import ToolSetup
from camrob.prediction.against_part import PartError
from camrob.prediction.deflection import CAUSE
from camrob.prediction.force_model import CuttingForce
from camrob.prediction.likely import LikelySizes
from camrob.prediction.surface import PredictedSurface
from camrob.prediction.true_path import TruePath
from camrob.program.program_text import ProgramText
from camrob.summaries.predict_summary import (
    DeviationSize,
    HeldToPart,
    HolderMeets,
    LikelySize,
    PartPlace,
    PredictedForce,
    PredictedPlace,
    PredictedRegion,
)
from camrob.units import m3_to_mm3, m_to_mm, mm_to_m

__all__ = ["causes_of", "force_of", "holder_of", "likely_of", "part_of", "places_of", "regions_of", "size_of"]

Array = NDArray[np.float64]

_PLACES = 10  # the worst ones, as the contract says
_APART, _APART_SHARE = 3.0, 0.05  # mm between two of them, and of the part's longest side: nearer ones are one place
_GRAZED = 1e-12  # m3: less than a thousandth of a mm3 is where two walls touch
_ROUNDING, _RUNOUT = "corner_rounding", "run-out"
# between the path that is meant and the corrected one, as the controller goes it
_CORRECTED = "correction and corner_rounding"


def force_of(pushes: Sequence[CuttingForce], tools: Sequence[ToolSetup], path: TruePath) -> PredictedForce:
    """What is said of the force on each of the tools and what yields under it."""
    bent = next(c.twist for c in path.causes if c.name == CAUSE)
    size = np.linalg.norm(bent[:, :3], axis=1)
    return PredictedForce(
        model=pushes[0].path.name,
        words="; ".join(_on_tool(push, tool, len(tools)) for push, tool in zip(pushes, tools, strict=True)),
        doubt=max(push.doubt for push in pushes),
        yields=path.yields,
        granted=path.granted,
        tool=any(bool(np.any(push.give > 0.0)) for push in pushes),
        deflection_p95_mm=m_to_mm(float(np.quantile(size, 0.95))),
    )


def _on_tool(push: CuttingForce, tool: ToolSetup, tools: int) -> str:
    """A force in words, with the tool that it is on where there are several."""
    return push.words if tools == 1 else f"on {tool.name or f'tool {tool.number}'} {push.words}"


def size_of(deviation: Array) -> DeviationSize:
    """Sizes of deviations (P,), m."""
    size = np.abs(deviation)
    return DeviationSize(
        points=len(size),
        rms_mm=m_to_mm(float(np.sqrt(np.mean(size**2)))),
        p95_mm=m_to_mm(float(np.quantile(size, 0.95))),
        worst_mm=m_to_mm(float(size.max())),
        mean_mm=m_to_mm(float(np.mean(deviation))),
    )


def likely_of(sizes: LikelySizes) -> LikelySize:
    """What is said of sizes on machines that are drawn."""
    (rms_low, rms, rms_high), (p95_low, p95, p95_high) = (m_to_mm(v).tolist() for v in sizes)
    return LikelySize(
        rms_mm=rms, rms_low_mm=rms_low, rms_high_mm=rms_high, p95_mm=p95, p95_low_mm=p95_low, p95_high_mm=p95_high
    )


def _named(surface: PredictedSurface, path: TruePath, corrected: bool) -> tuple[list[str], Array]:
    """Causes with the controller's rounding and the cutter's run-out, and their parts of the deviations (P, C + 2)."""
    names = [*(c.name for c in path.causes), _CORRECTED if corrected else _ROUNDING]
    if not np.any(surface.runout):
        return names, np.column_stack([surface.shares, surface.rounding])
    return [*names, _RUNOUT], np.column_stack([surface.shares, surface.rounding, surface.runout])


def causes_of(surface: PredictedSurface, path: TruePath, *, corrected: bool = False) -> dict[str, float]:
    """Rms (mm) of each cause's part of the deviations, the largest first; corrected: another program says what is meant."""
    names, parts = _named(surface, path, corrected)
    sizes = np.sqrt(np.mean(parts**2, axis=0))
    return {names[k]: m_to_mm(float(sizes[k])) for k in np.argsort(-sizes)}


def places_of(surface: PredictedSurface, path: TruePath, *, corrected: bool = False) -> tuple[PredictedPlace, ...]:
    """The worst places, each the worst within some mm."""
    names, parts = _named(surface, path, corrected)
    found = []
    for k in _worst(surface.point, np.abs(surface.deviation)):
        cause = int(np.argmax(np.abs(parts[k])))
        x, y, z = m_to_mm(surface.point[k]).tolist()
        found.append(
            PredictedPlace(
                x_mm=x,
                y_mm=y,
                z_mm=z,
                line=int(path.line[surface.row[k] + 1]),
                deviation_mm=m_to_mm(float(surface.deviation[k])),
                band_mm=m_to_mm(float(surface.band[k])),
                cause=names[cause],
                cause_mm=m_to_mm(float(parts[k, cause])),
                share=float(np.abs(parts[k, cause]) / max(float(np.abs(parts[k]).sum()), 1e-12)),
            )
        )
    return tuple(found)


def _worst(point: Array, size: Array) -> Iterator[int]:
    """Numbers of the points (P, 3) m with the largest sizes (P,) above 0, each the largest within some mm."""
    left = size.copy()
    apart = max(mm_to_m(_APART), _APART_SHARE * float(np.ptp(point, axis=0).max())) if len(point) else 0.0
    for _ in range(_PLACES):
        k = int(np.argmax(left)) if len(left) else 0
        if not len(left) or left[k] <= 0.0:
            return
        yield k
        left[np.linalg.norm(point - point[k], axis=1) < apart] = 0.0


def regions_of(
    surface: PredictedSurface, path: TruePath, text: ProgramText, motion: NDArray[np.int64]
) -> tuple[PredictedRegion, ...]:
    """What each file of the program cuts."""
    file, line = np.asarray(text.file)[motion[surface.row + 1]], path.line[surface.row + 1]
    return tuple(
        PredictedRegion(
            file=text.files[int(k)],
            first_line=int(line[file == k].min()),
            last_line=int(line[file == k].max()),
            size=size_of(surface.deviation[file == k]),
        )
        for k in np.unique(file)
    )


def part_of(held: PartError, mesh: str, path: TruePath) -> HeldToPart:
    """The cut surface held to the part's mesh, with the deepest gouges and the thickest rests."""

    def worst(side: float) -> tuple[PartPlace, ...]:
        found = []
        for k in _worst(held.point, np.maximum(side * held.deviation, 0.0)):
            x, y, z = m_to_mm(held.point[k]).tolist()
            line, off = int(path.line[held.row[k] + 1]), m_to_mm(float(held.deviation[k]))
            found.append(PartPlace(x_mm=x, y_mm=y, z_mm=z, line=line, deviation_mm=off))
        return tuple(found)

    return HeldToPart(
        mesh=mesh,
        size=size_of(held.deviation),
        gouged_mm3=m3_to_mm3(held.gouged),
        left_mm3=m3_to_mm3(held.left),
        gouges=worst(-1.0),
        rests=worst(1.0),
        elsewhere=held.elsewhere,
        beyond_stock_mm=m_to_mm(held.beyond),
    )


def holder_of(takes: Array, rows: NDArray[np.int64], path: TruePath) -> tuple[HolderMeets, ...]:
    """Where the holder goes through material, neighbouring lines together; takes: (K,) m3 between rows (K + 1,) of the run."""
    found: list[HolderMeets] = []
    for k in np.flatnonzero(takes > _GRAZED):
        line, taken = int(path.line[rows[k + 1]]), m3_to_mm3(float(takes[k]))
        if found and line - found[-1].last_line <= 1:
            last = found.pop()
            line, taken = max(line, last.last_line), taken + last.taken_mm3
            found.append(HolderMeets(first_line=last.first_line, last_line=line, taken_mm3=taken))
        else:
            found.append(HolderMeets(first_line=line, last_line=line, taken_mm3=taken))
    return tuple(found)
