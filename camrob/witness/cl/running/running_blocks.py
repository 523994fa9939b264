"""Runs the blocks of a G-code program in the control's order, each with numbers where it had computed something."""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Callable

from camrob.witness.cl.running.bracket_values import Formulas, Style, whole
from camrob.witness.cl.running.ordered import Ordered, Row
from camrob.witness.cl.running.unread import UnreadError

__all__ = ["Ask", "Running", "bracketed"]

Ask = Callable[[int], float | None]  # what a system variable of the control holds, None where nobody knows

_COUNTING = frozenset("GMTDHNOLK")  # letters whose numbers are whole
_SET = re.compile(r"#(?:(\d+)|(<[A-Z0-9_.-]+>)|(?=\[|#))")
_SEQUENCE = re.compile(r"N\d+")


def bracketed(text: str, at: int) -> int:
    """Where the bracket that opens at a place has closed. Raises UnreadError where it doesn't."""
    deep = 0
    for i in range(at, len(text)):
        deep += (text[i] == "[") - (text[i] == "]")
        if not deep:
            return i + 1
    raise UnreadError(f"{text[at : at + 20]}, a bracket that doesn't close")


class Running(Ordered):
    """rows: blocks without blanks and comments, upper case."""

    def __init__(self, rows: list[Row], styles: tuple[Style, ...], ask: Ask) -> None:
        super().__init__(rows)
        self.styles = styles
        self._ask = ask
        self._global: dict[str, float | None] = {}
        self._local: dict[str, float | None] = {}
        self._formulas = Formulas(styles, self._held, self._has)

    @abstractmethod
    def _is_local(self, name: str) -> bool:
        """Whether a variable belongs to the call that runs. Raises UnreadError for one that is the control's own."""

    def _null(self, name: str) -> bool:
        """Whether a variable that nothing has set is known to hold nothing."""
        return False

    # -- variables

    def _held(self, name: str) -> float | None:
        if name == "0" and self.styles == (Style.MACRO,):
            return None
        if self.styles == (Style.MACRO,) and (value := self._ask(int(name))) is not None:
            return value
        place = self._local if self._is_local(name) else self._global
        if name not in place:
            if self._null(name):
                return None
            raise UnreadError(f"#{name}, which the program hasn't set")
        return place[name]

    def _has(self, name: str) -> bool:
        found = name in (self._local if self._is_local(name) else self._global)
        if not found and not self._is_local(name):
            raise UnreadError(f"#{name}, which may be the control's")
        return found

    def _keep(self, name: str, value: float | None) -> None:
        (self._local if self._is_local(name) else self._global)[name] = value

    # -- blocks

    def _assigned(self, block: str, at: int) -> tuple[str, int]:
        """The variable that is set from a place on, and where its value begins."""
        found = _SET.match(block, at)
        if found is None:
            raise UnreadError(f"{block[at : at + 20]}, computed")
        if name := found[1] or found[2]:
            end, name = found.end(), name if name.startswith("<") else str(int(name))
        else:
            value, end = self._formulas.part(block, at + 1, single=True)
            name = str(whole(value, block[:24]))
        if not block.startswith("=", end):
            raise UnreadError(f"{block[at : at + 20]}, computed")
        return name, end + 1

    def _words(self, block: str) -> str:
        """A block of words with numbers for what they compute."""
        skip = _SEQUENCE.match(block)
        out, at = "", 0
        if skip:
            out, at = skip[0], skip.end()
        computed = dict[str, float]()
        plain = dict[str, str]()
        while at < len(block):
            letter = block[at]
            if not "A" <= letter <= "Z":
                raise UnreadError(f"{block[:24]}, computed")
            value, end = self._formulas.part(block, at + 1, single=True)
            text, at = block[at + 1 : end], end
            if not (set(text) & set("#[")):
                out += letter + text
                plain[letter] = text
                continue
            if "ROUND" in text or "RND" in text:
                raise UnreadError(f"{block[:24]}, rounded to what the control counts in")
            if isinstance(value, bool):
                raise UnreadError(f"{block[:24]}, a condition as a number")
            if value is None:
                if letter in _COUNTING or letter in "SF":
                    raise UnreadError(f"{letter} of a variable without a value")
                continue
            computed[letter] = value
            out += letter + self._printed(letter, value, block)
        if "P" in computed and self.styles != (Style.O_WORDS,):
            raise UnreadError(f"{block[:24]}, a computed P")
        if {"X", "U", "F"} & computed.keys() and re.search(r"G0*4(?![\d.])", block):
            raise UnreadError(f"{block[:24]}, a computed dwell")
        return out

    def _printed(self, letter: str, value: float, block: str) -> str:
        if letter == "G" and abs(value) < 1e5 and value * 10.0 == round(value * 10.0):
            return f"{value:g}"
        if letter in _COUNTING or (letter == "S" and Style.MACRO in self.styles):
            return str(whole(value, block[:24]))
        return f"{value:.9f}"
