"""Jobs for cells whose shops have customs of their own: an arc, corners, a dwell, another tool."""

from __future__ import annotations

from mutation.jobs import Job
from mutation.shops import SHOPS
from mutation.story import Story

__all__ = ["jobs"]

_TEXT = (
    "%\nO1\nG21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0. Y0. Z30.\nG1 Z1. F400.\nX20.\nG3 X20. Y20. I0. J10.\nG4 P1.5\n"
    "G1 X5. Y14. F300.\nG0 Z30.\nM5\nM30\n%\n"
)


def jobs() -> list[Job]:
    """A job for each shop."""
    return [_job(shop) for shop in SHOPS]


def _job(shop: str) -> Job:
    story = Story().event("change", 1).event("cw", 5000).rapid(0, 0, 30).cut(400, 0, 0, 1).cut(400, 20, 0, 1)
    story.arc(400, (20, 10, 1), (0, 0, 1), 180).event("dwell", 1.5).cut(300, 5, 14, 1).rapid(5, 14, 30)
    return Job(f"shop-{shop}", "shop.nc", _TEXT, story.event("off"), cell=shop)
