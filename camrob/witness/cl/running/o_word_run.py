"""LinuxCNC's O words: sub, call, return, if, while, do, repeat (LinuxCNC, "O codes").

#1 to #30 and names without an underscore belong to a call; a call hands its values to the first of them, the others keep the
caller's. A variable that is set changes behind its block.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from camrob.witness.cl.running.bracket_values import Style, whole
from camrob.witness.cl.running.ordered import Row
from camrob.witness.cl.running.running_blocks import Ask, Running, bracketed
from camrob.witness.cl.running.unread import UnreadError

__all__ = ["O_WORD", "OWordRun"]

_KEYS = "SUB ENDSUB CALL RETURN IF ELSEIF ELSE ENDIF WHILE ENDWHILE DO REPEAT ENDREPEAT BREAK CONTINUE".split()
O_WORD = re.compile(rf"O(\d+|<[^>]*>|\[.*?\])({'|'.join(sorted(_KEYS, key=len, reverse=True))})(?![A-Z])(.*)")
_CLOSES = {"ENDIF": "IF", "ENDWHILE": "WHILE", "ENDREPEAT": "REPEAT"}
_NESTED = 10  # calls in one another, as the manual has it
_LOCAL = range(1, 31)
_LAST = 5000  # of the numbered variables that are a program's
# names that the control sets ("G-code overview", predefined named parameters)
_TAKEN = frozenset(
    f"<_{name}>"
    for name in """VMAJOR VMINOR LINE MOTION_MODE PLANE CCOMP METRIC IMPERIAL ABSOLUTE INCREMENTAL INVERSE_TIME UNITS_PER_MINUTE
    UNITS_PER_REV COORD_SYSTEM TOOL_OFFSET RETRACT_R_PLANE RETRACT_OLD_Z SPINDLE_RPM_MODE SPINDLE_CSS_MODE IJK_ABSOLUTE_MODE
    LATHE_DIAMETER_MODE LATHE_RADIUS_MODE SPINDLE_ON SPINDLE_CW MIST FLOOD SPEED_OVERRIDE FEED_OVERRIDE ADAPTIVE_FEED FEED_HOLD
    FEED RPM X Y Z A B C U V W ABS_X ABS_Y ABS_Z ABS_A ABS_B ABS_C CURRENT_TOOL CURRENT_POCKET SELECTED_TOOL SELECTED_POCKET
    VALUE VALUE_RETURNED TASK CALL_LEVEL REMAP_LEVEL""".split()
)


class _Frame(NamedTuple):
    back: int
    local: dict[str, float | None]
    counts: dict[int, int]


class OWordRun(Running):
    """rows: without blanks and comments, upper case."""

    def __init__(self, rows: list[Row], styles: tuple[Style, ...], ask: Ask) -> None:
        super().__init__(rows, styles, ask)
        self._frames: list[_Frame] = []
        self._counts: dict[int, int] = {}  # runs of a repeat that are left, by its place
        self._defined: dict[str, int] = {}
        self._next: dict[int, int] = {}  # from an if to its else and on to its end
        self._last: dict[int, int] = {}  # the end of the if, loop or sub that a place belongs to
        self._first: dict[int, int] = {}  # from the end of a loop to its head

    def _start(self) -> int:
        self._link()
        return 0

    # -- what belongs together

    def _link(self) -> None:
        """Raises UnreadError where the words don't close what they open, or a label stands for two things."""
        opened: list[tuple[str, str, list[int]]] = []  # label, word, places
        used: set[tuple[str, str]] = set()
        scope = ""
        for i, (line, block) in enumerate(self.rows):
            found = O_WORD.match(block)
            if found is None:
                continue
            self.line = line
            label, word = self._label(found[1]), found[2]
            top = opened[-1] if opened else ("", "", [])
            if word in ("IF", "DO", "REPEAT", "SUB") or (word == "WHILE" and top[:2] != (label, "DO")):
                key = ("", label) if word == "SUB" else (scope, label)
                if key in used or (word == "SUB" and opened):
                    raise UnreadError(f"O{label}, twice")
                used.add(key)
                scope = label if word == "SUB" else scope
                opened.append((label, word, [i]))
            elif word in ("ELSEIF", "ELSE") and top[:2] == (label, "IF"):
                top[2].append(i)
            elif word == "WHILE" or (word in _CLOSES and top[:2] == (label, _CLOSES[word])):
                self._close(opened.pop()[2], i)
            elif word == "ENDSUB" and top[:2] == (label, "SUB"):
                self._close(opened.pop()[2], i)
                scope = ""
            elif word in ("BREAK", "CONTINUE"):
                heads = [place for name, kind, place in opened if name == label and kind in ("WHILE", "DO", "REPEAT")]
                if not heads:
                    raise UnreadError(f"O{label} {word} outside of its loop")
                self._first[i] = heads[-1][0]
            elif word == "RETURN" and scope == label:
                continue
            elif word != "CALL":
                raise UnreadError(f"O{label} {word} without its beginning")
        if opened:
            raise UnreadError(f"O{opened[-1][0]} {opened[-1][1]} without its end")
        self.line = self.rows[0][0] if self.rows else 1

    def _close(self, places: list[int], end: int) -> None:
        for place, after in zip(places, [*places[1:], end], strict=True):
            self._next[place], self._last[place] = after, end
        self._first[end] = places[0]

    @staticmethod
    def _label(text: str) -> str:
        if text.startswith("["):
            raise UnreadError("a computed O word")
        return text if text.startswith("<") else str(int(text))

    def _called(self) -> bool:
        return bool(self._frames)

    # -- variables

    def _is_local(self, name: str) -> bool:
        if name.startswith("<"):
            return not name.startswith("<_")
        if not 1 <= int(name) <= _LAST:
            raise UnreadError(f"#{name}, which the control keeps")
        return int(name) in _LOCAL

    # -- blocks

    def _step(self, at: int, block: str) -> tuple[int, str]:
        if found := O_WORD.match(block):
            return self._o_word(at, self._label(found[1]), found[2], found[3]), ""
        if re.fullmatch(r"[O:]\d+|O?<[\w.-]*>", block):
            return at + 1, ""
        if re.search(r"M0*9[89](?![\d.])|^(N\d+)?O[\d<\[]", block):
            raise UnreadError(f"{block[:24]}, beside O words")
        if not set(block) & set("#[=<"):
            return at + 1, block
        if block.startswith("/"):
            raise UnreadError(f"{block[:24]}, a block that may be skipped")
        return at + 1, self._mixed(block)

    def _mixed(self, block: str) -> str:
        """Words and variables that are set behind them, all by what the variables hold before the block."""
        words, later, at = "", list[tuple[str, float | None]](), 0
        while at < len(block):
            if block[at] == "#":
                name, place = self._assigned(block, at)
                value, at = self._formulas.part(block, place, single=True)
                self._is_local(name)
                if name in _TAKEN:
                    raise UnreadError(f"#{name}, which the control sets")
                later.append((name, None if value is None else float(value)))
            else:
                _, end = self._formulas.part(block, at + 1, single=True)
                words, at = words + block[at:end], end
        told = self._words(words)
        for name, value in later:
            self._keep(name, value)
        return told

    def _o_word(self, at: int, label: str, word: str, rest: str) -> int:
        if word in ("IF", "WHILE", "ELSEIF", "REPEAT") and (not rest or bracketed(rest, 0) != len(rest)):
            raise UnreadError(f"{word}{rest[:20]}, a condition")
        if word in ("SUB", "ELSE", "ENDIF", "DO", "ENDWHILE", "ENDREPEAT", "BREAK", "CONTINUE") and rest:
            raise UnreadError(f"{word}{rest[:20]}, words beside an O word")
        if word == "SUB":
            self._defined[label] = at
            return self._last[at] + 1
        if word in ("ENDSUB", "RETURN"):
            return self._return(rest)
        if word == "CALL":
            return self._call(at, label, rest)
        if word == "IF":
            return self._branch(at, rest)
        if word in ("ELSEIF", "ELSE"):  # behind a branch that was run
            return self._last[at] + 1
        if word in ("BREAK", "CONTINUE"):
            end = self._last[self._first[at]]
            return end + 1 if word == "BREAK" else end
        if word == "REPEAT":
            self._counts[at] = whole(self._formulas.value(rest), "a repeat")
            return at + 1 if self._counts[at] > 0 else self._last[at] + 1
        if word == "ENDREPEAT":
            head = self._first[at]
            self._counts[head] -= 1
            return head + 1 if self._counts[head] > 0 else at + 1
        if word == "ENDWHILE":
            return self._first[at]
        if word == "WHILE":
            held = self._formulas.truth(rest)
            if at in self._first:  # the end of a do
                return self._first[at] + 1 if held else at + 1
            return at + 1 if held else self._last[at] + 1
        return at + 1

    def _branch(self, at: int, rest: str) -> int:
        """Into the first branch whose condition holds."""
        end = self._last[at]
        while not self._formulas.truth(rest):
            at = self._next[at]
            if at == end:
                return end + 1
            self.line = self.rows[at][0]
            found = O_WORD.match(self.rows[at][1])
            if found is None or found[2] == "ELSE":
                return at + 1
            rest = found[3]
        return at + 1

    def _call(self, at: int, label: str, rest: str) -> int:
        if label not in self._defined or len(self._frames) >= _NESTED:
            raise UnreadError(f"O{label}, which isn't defined before, or nested too deep")
        given: list[float | None] = []
        place = 0
        while place < len(rest):
            end = bracketed(rest, place)
            given.append(self._formulas.value(rest[place:end]))
            place = end
        if len(given) > len(_LOCAL):
            raise UnreadError(f"O{label} of too many values")
        self._frames.append(_Frame(at, self._local, self._counts))
        # What isn't given is 0 (interp_read.cc, read_o), while the manual says that it is what the caller has there.
        rest_of = {str(i): 0.0 for i in _LOCAL if not self._local.get(str(i), 0.0)}
        self._local = {**rest_of, **{str(i): value for i, value in enumerate(given, 1)}}
        self._counts = {}
        self._global |= {"<_VALUE>": 0.0, "<_VALUE_RETURNED>": 0.0}
        return self._defined[label] + 1

    def _return(self, rest: str) -> int:
        if not self._frames:
            raise UnreadError("a return without a call")
        if rest:
            self._global |= {"<_VALUE>": self._formulas.value(rest), "<_VALUE_RETURNED>": 1.0}
        frame = self._frames.pop()
        self._local, self._counts = frame.local, frame.counts
        return frame.back + 1
