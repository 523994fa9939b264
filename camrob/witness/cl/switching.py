"""What the M, S and T words of a block switch: spindle, coolant, tool, stops, and the tool centre point of M128."""

from __future__ import annotations

import re

from camrob.witness.cl.standing import Standing, Words
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Kind
from camrob.witness.units import ms_to_s

__all__ = ["Switching"]

_CHANGE = re.compile(r"M\s*0*6(?![\d.])")
_QUIET = frozenset("10 11 29 48 49".split())  # M codes that move and switch nothing of ours


class Switching:
    """The process of one program, as its blocks switch it."""

    def __init__(self, tell: Teller, stand: Standing) -> None:
        self._tell, self._stand = tell, stand
        self._next_tool, self._spinning = 0.0, False
        self._ended = False
        self._numbered = False  # the file begins with % and a number, as NUM's and Siemens' older ones do
        self._by_t = False  # T alone changes the tool (Siemens' MD 22550, and controls without a changer)
        self._clamps = False  # M10 to M14 clamp rotary axes (Haas), and the spindle is switched by M3 or M4

    def _forget(self) -> None:
        """Where the tool stands is not known."""
        self._stand.forget()
        self._tell.lose()

    def _whose(self, bare: str) -> None:
        """What a file of ISO's words shows of its control."""
        self._whose_change(bare)
        self._numbered = bool(re.match(r"\s*%\s*\d+\s*\n(?!\s*[O:]\d)", bare))

    def _whose_change(self, bare: str) -> None:
        """Whether T or M6 changes tools, by the program without its comments, upper case."""
        self._by_t = not _CHANGE.search(bare)

    def _gap(self, line: int, text: str, last: int = 0) -> None:
        self._tell.gap(line, text, last=last)
        self._forget()

    def _process(self, g: list[str], m: list[str], words: Words, line: int, moves: bool) -> None:
        """What comes before the block's motion."""
        tell = self._tell
        if "96" in g:
            tell.gap(line, "G96: the spindle's speed is not known", lost=False)
        if "T" in words:
            self._next_tool = float(words["T"])
        if "6" in m or (self._by_t and "T" in words):
            self._change(m, line)
        senses = [{"3": "CLW", "4": "CCLW"}[code] for code in m if code in ("3", "4")]
        rpm = float(words["S"]) if "S" in words and "4" not in g else None
        if senses or (rpm is not None and self._spinning):
            tell.spindle(line, rpm, senses[-1] if senses else None)
            self._spinning = True
        elif rpm is not None:
            tell.speed_alone(line, rpm)
        for code in m:
            if code in ("7", "8"):
                tell.coolant(line, "MIST" if code == "7" else "FLOOD")
            elif code in ("128", "428", "129", "429"):
                self._stand.switch("M", code.endswith("28"))
            elif code in ("97", "98"):
                self._gap(line, f"M{code}: a subprogram")
            elif code in ("12", "13", "14") and self._clamps:
                continue
            elif code not in _QUIET and code not in ("0", "1", "2", "3", "4", "5", "6", "9", "30", "60", "99"):
                tell.gap(line, f"M{code}: not known", lost=False)
        if not moves:
            self._switch_off(m, line)

    def _change(self, m: list[str], line: int) -> None:
        """Another tool, behind what the block switches off; the spindle stands for it. T0: the tool is put away."""
        if self._tell.mounted(self._next_tool):
            return
        if self._tell.cutting:  # the machine takes the tool up first: how high is not known
            self._stand.rise()
            self._tell.lose()
        self._switch_off(m, line)
        m[:] = [code for code in m if code not in ("5", "9")]
        self._spinning = False
        if self._next_tool:
            self._tell.tool(line, self._next_tool)
        else:
            self._tell.unload(line)

    def _switch_off(self, m: list[str], line: int) -> None:
        if "5" in m:
            self._tell.spindle_off(line)
            self._spinning = False
        if "9" in m:
            self._tell.coolant(line, None)

    def _process_after(self, m: list[str], line: int, moves: bool) -> None:
        if moves:  # ISO 6983: M5 and M9 act behind the block's motion
            self._switch_off(m, line)
        if {"0", "1", "60"} & set(m):
            self._tell.event(Kind.STOP, line)
        self._ended = bool({"2", "30", "99"} & set(m))

    def _seconds(self, text: str, line: int) -> float:
        """A dwell. Fanuc counts P in ms and without a point, LinuxCNC in seconds."""
        value = float(text)
        if "." in text:
            return value
        self._tell.note(f"a dwell of P{text} is taken as {'milliseconds' if value >= 100.0 else 'seconds'}")
        return ms_to_s(value) if value >= 100.0 else value
