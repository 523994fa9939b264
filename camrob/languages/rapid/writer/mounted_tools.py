"""Tools as RAPID has them: frame and load in one, and each motion names its own."""

from __future__ import annotations

import numpy as np

from camrob.errors import JobError
from camrob.program.program import Program, ProgramEventKind

__all__ = ["MountedTools"]


class MountedTools:
    """The pairs of tool frame and load that a program moves with.

    frames: X..C of each pair. loads: mass, centre and moments, None where the program says nothing of it. of_motion: the pair of
    each motion. Raises JobError for a tool or a load that no motion follows: nothing in RAPID would say it.
    """

    def __init__(self, program: Program) -> None:
        tool, load = -1, -1
        pairs: dict[tuple[int, int], int] = {}
        self.of_motion: list[int] = []
        switches = (ProgramEventKind.TOOL, ProgramEventKind.LOAD)
        changes = sorted((e for e in program.events if e.kind in switches), key=lambda e: e.motion)
        at = 0
        for motion in range(len(program)):
            while at < len(changes) and changes[at].motion <= motion:
                if changes[at].kind is ProgramEventKind.TOOL:
                    tool = int(changes[at].value)
                else:
                    load = int(changes[at].value)
                at += 1
            self.of_motion.append(pairs.setdefault((tool, load), len(pairs)))
        if at < len(changes):
            raise JobError(
                "a tool or its load changes behind the last motion, which RAPID can't say; move with it, or leave it"
            )
        pairs = pairs or {(-1, -1): 0}
        self.frames = [np.asarray(program.tool if t < 0 else program.tools[t]) for t, _ in pairs]
        self.loads = [None if k < 0 else np.asarray(program.loads[k]) for _, k in pairs]
