"""What stands against a program as a person reads it: files that are not those of the post in one line, with one advice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

from camrob.summaries.remarks import JudgedRemark

__all__ = ["grouped"]

_OF_FILES = ("manifest-missing", "manifest-further", "manifest-differs")


def grouped(remarks: Sequence[JudgedRemark]) -> list[JudgedRemark]:
    """The remarks in their order, those on files that have one and the same advice as one."""
    out: list[JudgedRemark] = []
    for advice, together in groupby(remarks, _advice):
        alike = list(together)
        if not advice or len(alike) < 2:
            out += alike
            continue
        said = ", ".join(r.text.partition("; ")[0] for r in alike)
        out.append(replace(alike[0], code="manifest", text=f"{said}; {advice}"))
    return out


def _advice(remark: JudgedRemark) -> str:
    """What is to be done about a file; "" where a remark is on something else."""
    return remark.text.partition("; ")[2] if remark.code in _OF_FILES else ""
