"""The family that may be looked at."""

from __future__ import annotations

from gap.fifth_author import dev_moves
from gap.fifth_author.dev_causes import KNOWN
from gap.fifth_author.dev_cells import CELLS
from gap.fifth_author.dev_other import FOREIGN, drive_leftover, leftover
from gap.fifth_author.kind import Kind

__all__ = ["KIND"]

KIND = Kind(
    name="fifth dev", first=9001, cells=CELLS, known=KNOWN, foreign=FOREIGN, leftover=leftover, drive_leftover=drive_leftover,
    poses=dev_moves.POSES, paths=dev_moves.PATHS, warm="warm_up", on_track=("stations", "shuttle"),
    six=("cube", "grid", "ballbar"),
    mornings=True, sigma=(0.01, 0.04),
)  # fmt: skip
