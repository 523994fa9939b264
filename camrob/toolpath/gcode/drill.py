"""Canned cycles of a G-code program, hole by hole."""

from __future__ import annotations

import numpy as np

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.gcode.cycles import TAPS, Step, hole
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.moves import Motions
from camrob.toolpath.region import EventKind
from camrob.units import deg_to_rad

__all__ = ["Drill"]

_MOST_HOLES = 10_000  # of one block
_DEGREE = deg_to_rad(1.0)


class Drill:
    """Drills where a block of a canned cycle says."""

    def __init__(self, motions: Motions) -> None:
        self.motions = motions
        self.path = motions.path
        self.frame = motions.frame
        self.modal = motions.modal
        self.process = motions.process

    def run(self, block: Block, code: int) -> None:
        """Drill or tap where a block of the canned cycle `code` (tenths) says."""
        modal, frame, words = self.modal, self.frame, block.words
        self.begun(block, code)
        self._allowed(words)
        self._keep(block, code)
        count = words.get("L", words.get("K", 1.0))
        if count != int(count) or not 0 <= count <= _MOST_HOLES:
            raise ToolpathError(f"{count:g} repeats of a cycle", hint="a whole number up to 10000")
        if "Z" not in modal.cycle or "R" not in modal.cycle:
            raise ToolpathError("a cycle without depth Z or retract height R", hint="name both in its first block")
        self._same_mode(block.line)
        lateral = {k: words[k] for k in "XY" if k in words}
        retract, bottom = modal.cycle["R"], modal.cycle["Z"]
        for _ in range(int(count)):  # in G90 at the same place each time
            if frame.xyz[2] < retract:
                self.motions.to_height(retract, block, cut=False)
            frame.move(lateral, modal.scale, _DEGREE, modal.incremental)
            self.motions.to_height(frame.xyz[2], block, cut=False)
            self.motions.to_height(retract, block, cut=False)
            end = retract if modal.return_to_r else max(retract, modal.cycle_start)
            peck = modal.cycle.get("Q", 0.0) * modal.scale
            self._hole(code, block, hole(code, retract, bottom, end, peck, modal.cycle.get("dwell", 0.0)))

    def begun(self, block: Block, code: int) -> None:
        """Raises ToolpathError where a block that names a cycle, or drills by it, is another control's turn of the path."""
        if {"Z", "R"} & {*self.modal.cycle, *block.words}:
            return
        if code == 740:
            raise ToolpathError(
                "G74 without a depth Z and a height R: no tap, but a search for the machine's zero on some controls (Fagor)",
                hint="take it out, or name Z and R of the tap",
            )
        if code == 730 and block.words:
            raise ToolpathError(
                "G73 without a depth Z and a height R: no hole, but Fagor's turn of the path by an angle Q, which is not read",
                hint="have the CAM system turn the path; a hole broken in chips names Z and R",
            )

    def _keep(self, block: Block, code: int) -> None:
        """Keep the block's words for the holes that follow: R and Z as heights (m), which stay where they are.

        In G91 R is measured from the height at which the cycles began, and Z from R, as Fanuc's controls do it.
        """
        modal, words = self.modal, block.words
        modal.cycle_by.update({k: modal.incremental for k in "RZ" if k in words})
        if "R" in words:
            modal.cycle["R"] = words["R"] * modal.scale + (modal.cycle_start if modal.incremental else 0.0)
        if "Z" in words:
            modal.cycle["Z"] = words["Z"] * modal.scale + (modal.cycle.get("R", 0.0) if modal.incremental else 0.0)
        if "Q" in words:
            modal.cycle["Q"], modal.cycle["tap"] = words["Q"], float(code in TAPS)
        if "P" in words:
            modal.cycle["dwell"] = modal.seconds(block, self.path)

    def _same_mode(self, line: int) -> None:
        """What G90 and G91 make of heights named in the other one.

        Haas's and Fanuc's manuals keep them (G91 X10 L5 drills a row), LinuxCNC counts them anew. Raises ToolpathError where
        the program is LinuxCNC's, or only one of the two is named anew.
        """
        kept = [k for k in "RZ" if self.modal.cycle_by[k] != self.modal.incremental]
        if len(kept) == 1 or (kept and self.modal.rereads):
            was, now = ("G90", "G91") if self.modal.incremental else ("G91", "G90")
            raise ToolpathError(
                f"a drilling cycle goes on in {now} with {' and '.join(kept)} of {was}: some controls keep the height, "
                "LinuxCNC counts it anew",
                hint=f"name R and Z in {now}",
            )
        if kept:
            self.path.note(
                "cycle-heights-kept",
                "a drilling cycle goes on behind a change of G90 and G91: its heights R and Z stay, as Fanuc's and Haas's "
                "controls have it; LinuxCNC counts them anew",
                line,
                Severity.INFO,
            )

    def _hole(self, code: int, block: Block, steps: list[tuple[Step, float]]) -> None:
        """The steps of one hole as moves and events."""
        process, path, line = self.process, self.path, block.line
        started = code in TAPS and self._start_tap(code, line)
        sense = TAPS.get(code, self.modal.spindle)
        for step, value in steps:
            if step in (Step.RAPID, Step.CUT):
                self.motions.to_height(value, block, cut=step == Step.CUT)
            elif step == Step.DWELL:
                path.event(EventKind.DWELL, value, "", line)
            elif step == Step.SPINDLE_REVERSE:
                path.event(EventKind.SPINDLE_ON, process.rpm(), "CCLW" if sense == "CLW" else "CLW", line)
            elif step == Step.SPINDLE_START and started:
                path.event(EventKind.SPINDLE_OFF, 0.0, "", line)
            elif process.turning:
                on = step == Step.SPINDLE_START
                kind = EventKind.SPINDLE_ON if on else EventKind.SPINDLE_OFF
                path.event(kind, process.rpm() if on else 0.0, sense if on else "", line)

    def _start_tap(self, code: int, line: int) -> bool:
        """Before a tap: whether the cycle itself has to start the spindle (rigid tapping, S without M3).

        Raises ToolpathError where the spindle turns in the other sense, no speed is known, or the tap is to go in by pecks.
        """
        name, sense, process = f"G{code // 10}", TAPS[code], self.process
        if self.modal.cycle.get("Q", 0.0) > 0.0 and self.modal.cycle["tap"]:  # Q of G73 or G83 is none of a tap's
            raise ToolpathError(f"tapping ({name}) by pecks (Q) is not read", hint="tap in one go")
        if process.turning and self.modal.spindle != sense:
            raise ToolpathError(
                f"tapping ({name}) with the spindle turning {self.modal.spindle}",
                hint="a right-hand thread is G84 with M3, a left-hand one G74 with M4",
            )
        rpm = process.rpm()
        if not rpm > 0.0:
            raise ToolpathError(f"tapping ({name}) without a spindle speed", hint="program S before it")
        self.path.note(
            "tap-cycle",
            "tapping is written as feed in, spindle reversed, feed out: the robot's feed is not coupled to its spindle, "
            "so a floating tap holder is needed",
            line,
        )
        if not process.turning:
            self.path.event(EventKind.SPINDLE_ON, rpm, sense, line)
            return True
        return False

    def _allowed(self, words: dict[str, float]) -> None:
        """Refuse a cycle that isn't along the tool, in an unknown place or in inverse time."""
        modal, frame = self.modal, self.frame
        if not frame.placeable:
            self.motions.cuttable()  # raises: where the tip is only the machine knows
        if modal.framed == "G51":
            raise ToolpathError(
                "a drilling cycle while scaling is on (G51)", hint="drill with plain moves, or unscaled"
            )
        if any(letter in words for letter in "ABC"):
            raise ToolpathError("rotary words in a drilling cycle's block", hint="turn the tool in a block before it")
        if not frame.known and any(v != v and a not in words for a, v in zip("XY", frame.xyz, strict=False)):
            raise ToolpathError("a drilling cycle in an unknown place", hint="name X, Y and Z in a rapid before it")
        if frame.xyz[2] != frame.xyz[2] or modal.cycle_start != modal.cycle_start:
            raise ToolpathError("a drilling cycle from an unknown height", hint="name Z in a rapid move before it")
        tool_axis = np.array(frame.axis())
        if modal.plane != 170 or float(tool_axis @ frame.up()) < 1.0 - 1e-7:
            raise ToolpathError(
                "a drilling cycle that isn't along the tool", hint="use G17, and a tilted plane (G68.2, G53.1) for it"
            )
        if modal.feed_mode == 930:
            raise ToolpathError("a drilling cycle in inverse-time feed (G93)", hint="switch to G94 before it")
