"""How far a computation has come, as it tells whoever shows that."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "Share", "part_of", "silent", "stage_of"]

Progress = Callable[[str, float], None]
"""What a verb tells: the stage that runs, and the share of it that is done, 0 to 1."""

Share = Callable[[float], None]
"""What one computation tells: the share of it that is done, 0 to 1."""


def silent(stage: str, share: float) -> None:
    """A Progress for when nobody listens."""


def stage_of(progress: Progress | None, name: str) -> Share:
    """What the computation of one stage of a verb tells."""
    return lambda done: (progress or silent)(name, done)


def part_of(share: Share, part: int, parts: int) -> Share:
    """What one of several parts of a computation tells, all alike in size, the first being 0."""
    return lambda done: share((part + done) / parts)
