"""Cutter radius compensation (G41, G42, RL, RR, CUTCOM): a robot's control offsets no path by the tool's radius.

Where the programmed path is the contour, the part comes out wrong by that radius: such a file is refused. Where it is the path of
the tool's centre, and the offset holds no more than the tool's wear, the path is the one that is meant.
"""

from __future__ import annotations

from camrob.errors import ToolpathError

__all__ = ["WEAR", "offset_by_control"]

WEAR = "wear"
"""What `cutter_compensation` of a set-up says: the path is the tool centre's, and offsets hold wear only."""


def offset_by_control(word: str) -> ToolpathError:
    """That a path has to be offset by a radius that only the control knows, as an error to be raised; `word` asks for it."""
    return ToolpathError(
        f"cutter radius compensation ({word}): the control would offset the path by a radius of its tool table,"
        " which no robot does",
        hint="have the CAM system write the path of the tool's centre (compensation in the computer); where it is that already"
        f' and the offset is for wear, put cutter_compensation = "{WEAR}" into setup.toml',
    )
