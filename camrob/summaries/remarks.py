"""Findings as summaries have them, and the figures that several verbs tell alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.findings import Finding
from camrob.summaries.base import Summary, left_out

__all__ = ["Approximated", "AxisLimits", "JudgedRemark", "Remark"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Remark(Summary):
    """A finding: the line it is about (0 for none), a stable code, a sentence, how often it was met, and its axis."""

    line: int
    code: str
    text: str
    count: int | None = left_out()
    axis: str = left_out("")


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedRemark(Summary):
    """A finding with how far a value is off: `value` and `limit` in `unit`, None where there is nothing to measure.

    line, cl_line: of the program that is judged, and of its CL file; 0 for none. file: the program's, where `line` is none of
    the main file.
    """

    line: int
    file: str = left_out("")
    cl_line: int
    code: str
    text: str
    axis: str
    value: float | None
    limit: float | None
    unit: str
    count: int

    @classmethod
    def of(cls, finding: Finding) -> JudgedRemark:
        """A finding as it stands."""
        return cls(
            line=finding.line,
            file=finding.file,
            cl_line=finding.cl_line,
            code=finding.code,
            text=finding.text,
            axis=finding.axis,
            value=finding.value,
            limit=finding.limit,
            unit=finding.unit,
            count=finding.count,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Approximated(Summary):
    """What approximate positioning takes off corners, and the line of the worst; None where no corner is left."""

    corners: int
    deviation_mm_max: float
    line: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisLimits(Summary):
    """The least margin of each axis to a limit, degrees or mm (None for an endless one), and how often a limit is passed."""

    margin_min: Mapping[str, float | None]
    violations: int
