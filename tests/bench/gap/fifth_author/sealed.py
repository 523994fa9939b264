"""The family that nobody looks at before it is opened."""

from __future__ import annotations

from gap.fifth_author import sealed_moves
from gap.fifth_author.kind import Kind
from gap.fifth_author.sealed_causes import KNOWN
from gap.fifth_author.sealed_cells import CELLS
from gap.fifth_author.sealed_other import FOREIGN, drive_leftover, leftover

__all__ = ["KIND"]

KIND = Kind(
    name="fifth sealed", first=9501, cells=CELLS, known=KNOWN, foreign=FOREIGN, leftover=leftover, drive_leftover=drive_leftover,
    poses=sealed_moves.POSES, paths=sealed_moves.PATHS, warm="homing", on_track=("legs", "rides"), six=("straights",),
    mornings=False, sigma=(0.015, 0.08),
)  # fmt: skip
