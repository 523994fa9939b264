"""verify.json and verify.html of a judgement; apart, because charts and pictures are heavy and few judgements ask for them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camrob.controller.replay import Replay
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.report.verify.page import PICTURES, VerifiedMotions, verify_report
from camrob.summaries.remarks import JudgedRemark
from camrob.summaries.verify_summary import VerifySummary

__all__ = ["write_page"]


def write_page(out: Path, summary: VerifySummary, done: tuple[ProgramText, Replay] | None) -> None:
    """Both files appear in `out`, or none. done: the program as it was replayed, None where it could not be."""
    motions = None if done is None else _motions(*done)
    pictures = {} if done is None else _pictures(*done, [*summary.errors, *summary.warnings])
    with staged_output(out) as folder:
        write_summary(folder / "verify.json", summary, indent=1)
        (folder / "verify.html").write_text(verify_report(summary, motions, pictures), encoding="utf-8")


def _motions(text: ProgramText, replayed: Replay) -> VerifiedMotions:
    """The replay, motion by motion, for the page."""
    cell = replayed.cell
    return VerifiedMotions(
        line=np.asarray(text.line),
        margin=np.asarray(replayed.margin)[:, cell.arm_slice].min(axis=1),
        inv_kf=np.asarray(replayed.inv_kf),
        threshold=None if cell.resolve_section is None else cell.resolve.threshold,
    )


def _pictures(text: ProgramText, replayed: Replay, remarks: Sequence[JudgedRemark]) -> dict[int, bytes]:
    """The cell at the first places that findings name, by their lines of the program's main file."""
    base_p = np.asarray(replayed.base_T_tool)[:, :3, 3]
    shown = np.isfinite(base_p).all(axis=1) & (np.asarray(text.kind) >= Motion.LIN)
    known = np.isfinite(replayed.q).all(axis=1) & (np.asarray(text.file) == 0)
    out: dict[int, bytes] = {}
    for line in dict.fromkeys(r.line for r in remarks if r.line and not r.file):
        rows = np.flatnonzero((np.asarray(text.line) == line) & known)
        if len(rows) and len(out) < PICTURES:
            from camrob.report.page.figures import (
                place_picture,
            )  # brings matplotlib: only where there is something to show

            at = int(rows[0])
            cell = replayed.cells[int(replayed.mounted[at])]
            out[line] = place_picture(cell, np.asarray(replayed.q)[at], np.nan_to_num(base_p), shown)
    return out
