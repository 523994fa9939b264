"""How far a path of postures stays from limits and singularities, where it jumps, and what the externals travel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.findings import Finding, Severity
from camrob.frozen import locked
from camrob.kinematics.kernels import chain_arrays, forward_many
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["MarginReport", "check_margins", "joined_margins"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SINGULAR = 0.01
"""1/k_F of the bare arm below which a posture counts as singular: an axis moves a hundred times what the tool does."""
_NEAR_TURN = deg_to_rad(5.0)  # margins below which a remark is made
_NEAR_SLIDE = mm_to_m(20.0)
_JUMP_TURN = deg_to_rad(5.0)  # an axis step that may be a jump
_JUMP_RATIO = 20.0  # and is one where it is so many times the tool's own step
_CHUNK = 16_384  # motions whose poses are held at a time
_OVER = 1e-9  # rad or m: rounding, no violation


@dataclass(frozen=True, slots=True)
class MarginReport:
    """Margins of M postures; degrees and mm, as the controller counts its axes.

    margin_min: nearest distance of each real axis to a limit, below 0 where it is passed, None for an endless axis;
    margin_at: the point of it (-1 for an endless axis). violations: points outside some limit. inv_kf_min, inv_kf_mean
    of the bare arm, inv_kf_at the point of the least; singular: points below `SINGULAR`. jumps: points that are
    reached by a jump. axis_step_deg_max: the largest step of an arm axis between two points of cutting.
    midpoint_mm_max: how far at most the tip deviates from the middle of two points where all joints are half-way.
    external_travel: "E1_mm", "E2_deg", ...: what each external axis travels while the tool cuts.
    """

    margin_min: Mapping[str, float | None]
    margin_at: Mapping[str, int]
    violations: int
    inv_kf_min: float
    inv_kf_mean: float
    inv_kf_at: int
    singular: int
    jumps: NDArray[np.int64]
    axis_step_deg_max: float
    midpoint_mm_max: float
    external_travel: Mapping[str, float]
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        for name in ("margin_min", "margin_at", "external_travel"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        object.__setattr__(self, "jumps", locked(self.jumps, shape=(None,), dtype=np.int64, name="jumps"))


def joined_margins(reports: Sequence[MarginReport], points: Sequence[int]) -> MarginReport:
    """Reports of parts of a path, of so many points each, as one. 1/k_F's mean is weighted by the points."""
    begins = np.cumsum([0, *points[:-1]]).tolist()
    placed = list(zip(begins, reports, strict=True))
    least = {}
    for name in reports[0].margin_min:
        least[name] = min(((r.margin_min[name], begin + r.margin_at[name]) for begin, r in placed), key=_none_last)
    worst = min(range(len(reports)), key=lambda k: reports[k].inv_kf_min)
    travel = {name: sum(r.external_travel[name] for r in reports) for name in reports[0].external_travel}
    return MarginReport(
        margin_min={name: value for name, (value, _) in least.items()},
        margin_at={name: -1 if value is None else at for name, (value, at) in least.items()},
        violations=sum(r.violations for r in reports),
        inv_kf_min=reports[worst].inv_kf_min,
        inv_kf_mean=float(np.average([r.inv_kf_mean for r in reports], weights=points)),
        inv_kf_at=begins[worst] + reports[worst].inv_kf_at,
        singular=sum(r.singular for r in reports),
        jumps=np.concatenate([begin + np.asarray(r.jumps) for begin, r in placed]),
        axis_step_deg_max=max(r.axis_step_deg_max for r in reports),
        midpoint_mm_max=max(r.midpoint_mm_max for r in reports),
        external_travel=travel,
        findings=tuple(
            replace(f, point=f.point + begin if f.point >= 0 else -1) for begin, r in placed for f in r.findings
        ),
    )


def _none_last(entry: tuple[float | None, int]) -> float:
    return np.inf if entry[0] is None else entry[0]


@dataclass(frozen=True, slots=True)
class _Places:
    """Where points come from."""

    line: NDArray[np.int64]
    region: NDArray[np.int64]

    def finding(
        self,
        code: str,
        text: str,
        severity: Severity,
        point: int,
        *,
        axis: str = "",
        value: float,
        limit: float,
        unit: str = "",
        count: int = 1,
    ) -> Finding:
        """A finding at a point; camrob's own points take the last CL line before them."""
        named = self.line[: point + 1][self.line[: point + 1] > 0]
        line = int(named[-1]) if len(named) else 0
        return Finding(code, text, severity, line, int(self.region[point]), point, axis, value, limit, unit, count)


def check_margins(
    cell: Cell,
    q: Array,
    *,
    inv_kf: ArrayLike,
    cutting: ArrayLike,
    line: ArrayLike,
    region: ArrayLike,
) -> MarginReport:
    """Margins of postures q (M, n), M > 0, with 1/k_F (M,) of the bare arm.

    cutting (M,): True for points that the tool comes to while it cuts, where a jump of the axes is a fault; line (M,) CL lines,
    0 for camrob's own; region (M,). Raises ValueError for arrays that don't fit.
    """
    q, kf = np.ascontiguousarray(q, float), np.asarray(inv_kf, float)
    cut, places = np.asarray(cutting, bool), _Places(np.asarray(line, np.int64), np.asarray(region, np.int64))
    count = len(q)
    if not count or q.shape != (count, len(cell)) or not np.all(np.isfinite(q)):
        raise ValueError(f"postures are {q.shape} or not finite, expected (1 or more, {len(cell)}) finite numbers")
    if any(v.shape != (count,) for v in (kf, cut, places.line, places.region)):
        raise ValueError("inv_kf, cutting, line and region need one value a posture")
    findings: list[Finding] = []
    margins, at, outside = {}, {}, np.zeros(count, bool)
    for name in cell.axis_names:
        margins[name], at[name] = _limit(
            cell.joints[cell.index(name)], q[:, cell.index(name)], outside, places, findings
        )
    worst = int(np.argmin(kf))
    singular = kf < SINGULAR
    if singular.any():
        text = "the arm is singular or nearly so: an axis would have to race"
        first, times = int(np.argmax(singular)), int(singular.sum())
        findings.append(
            places.finding("singular", text, Severity.ERROR, first, value=float(kf[first]), limit=SINGULAR, count=times)
        )
    jumps, axis_step, middle = _jumps(cell, q, cut, places, findings)
    return MarginReport(
        margin_min=margins,
        margin_at=at,
        violations=int(outside.sum()),
        inv_kf_min=float(kf[worst]),
        inv_kf_mean=float(kf.mean()),
        inv_kf_at=worst,
        singular=int(singular.sum()),
        jumps=jumps,
        axis_step_deg_max=rad_to_deg(axis_step),
        midpoint_mm_max=m_to_mm(middle),
        external_travel=_travel(cell, q, cut),
        findings=tuple(findings),
    )


def _limit(joint: Joint, q: Array, outside: Mask, places: _Places, findings: list[Finding]) -> tuple[float | None, int]:
    """One axis against its limits: the least margin in degrees or mm and where; marks the points outside."""
    if joint.endless:
        return None, -1
    values = joint.axis_value(q)
    margin = np.minimum(values - joint.lower, joint.upper - values)
    point = int(np.argmin(margin))
    least = float(margin[point])
    near = _NEAR_SLIDE if joint.prismatic else _NEAR_TURN
    passed = margin < -_OVER
    outside |= passed
    limit = joint.to_edge(joint.lower if values[point] - joint.lower < joint.upper - values[point] else joint.upper)
    value = joint.to_edge(float(values[point]))
    if passed.any():
        said = "axis-limit", f"{joint.name} is past its limit", Severity.ERROR, passed
    elif least < near:
        said = "axis-margin", f"{joint.name} comes close to its limit", Severity.INFO, margin < near
    else:
        return joint.to_edge(least), point
    code, text, severity, where = said
    findings.append(
        places.finding(
            code,
            text,
            severity,
            point,
            axis=joint.name,
            value=value,
            limit=limit,
            unit=joint.unit_word,
            count=int(where.sum()),
        )
    )
    return joint.to_edge(least), point


def _jumps(
    cell: Cell, q: Array, cut: Mask, places: _Places, findings: list[Finding]
) -> tuple[NDArray[np.int64], float, float]:
    """Points reached by a jump of the arm, the largest step of an arm axis (rad), the largest midpoint deviation (m).

    Only cutting moves count. A jump: an arm axis turns by more than 5 degrees and by more than 20 times the tool's
    own step, its angle plus its length over the characteristic length.
    """
    into = np.flatnonzero(cut[1:]) + 1
    if not len(into):
        return into, 0.0, 0.0
    starts = range(0, len(q) - 1, _CHUNK)
    parts = [_steps(cell, q[k : k + _CHUNK + 1], cut[k + 1 : k + _CHUNK + 1]) for k in starts]
    steps, tool_step, off = (np.concatenate(found) for found in zip(*parts, strict=True))
    axis_step = steps.max(axis=1)
    found = (axis_step > _JUMP_TURN) & (axis_step > _JUMP_RATIO * tool_step)
    jumps = into[found]
    if len(jumps):
        which = int(np.argmax(found))
        name = cell.names[cell.arm_slice.start + int(np.argmax(steps[which]))]
        text = f"{name} jumps where the tool hardly moves"
        findings.append(
            places.finding(
                "jump",
                text,
                Severity.ERROR,
                int(jumps[0]),
                axis=name,
                unit="degrees",
                count=len(jumps),
                value=rad_to_deg(float(axis_step[which])),
                limit=rad_to_deg(max(_JUMP_TURN, _JUMP_RATIO * float(tool_step[which]))),
            )
        )
    return jumps, float(axis_step.max()), float(off.max())


def _steps(cell: Cell, q: Array, into: Mask) -> tuple[Array, Array, Array]:
    """Of the motions between postures q (K + 1, n) that `into` (K,) picks: the arm axes' steps (M, 6), the tool's own step (M,),
    rad, and how far the middle lies off the chord (M,), m.
    """
    real = q.copy()
    real[:, cell.indices(Role.ROLL)] = 0.0  # the tool's own spin is no motion of the cell
    start, stop = real[:-1][into], real[1:][into]
    chain = chain_arrays(cell)
    base_T_tool = forward_many(chain, real)
    base_T_start = base_T_tool[:-1][into]  # frames: tool is start
    base_T_stop = base_T_tool[1:][into]  # frames: tool is stop
    base_T_middle = forward_many(chain, 0.5 * (start + stop))
    chord = base_T_stop[:, :3, 3] - base_T_start[:, :3, 3]
    off = base_T_middle[:, :3, 3] - 0.5 * (base_T_start[:, :3, 3] + base_T_stop[:, :3, 3])
    cross = np.linalg.norm(np.cross(base_T_start[:, :3, 2], base_T_stop[:, :3, 2]), axis=1)
    angle = np.arctan2(cross, np.einsum("ij,ij->i", base_T_start[:, :3, 2], base_T_stop[:, :3, 2]))
    tool_step = angle + np.linalg.norm(chord, axis=1) / cell.condition_length
    return np.abs(stop - start)[:, cell.arm_slice], tool_step, np.linalg.norm(off, axis=1)


def _travel(cell: Cell, q: Array, cut: Mask) -> dict[str, float]:
    """What each external axis travels on the way to cutting points, mm or degrees."""
    out = {}
    for name in cell.external_names:
        index = cell.index(name)
        total = float(np.abs(np.diff(q[:, index]))[cut[1:]].sum())
        joint = cell.joints[index]
        out[f"{name}_{joint.unit}"] = joint.to_edge(total)
    return out
