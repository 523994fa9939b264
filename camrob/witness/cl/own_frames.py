"""G68, G51.1 and G51 of Fanuc's and alike: frames of the program's own, one at a time, each about a point that it names."""

from __future__ import annotations

import numpy as np

from camrob.witness.cl.framing import at_place, mirror, scaling, turning
from camrob.witness.cl.standing import Standing, Words

__all__ = ["OwnFrames"]

_ENDS = {"69": "68", "50": "51", "50.1": "51.1"}


class OwnFrames:
    """Which one is in force. by: its code, "" for none."""

    def __init__(self, stand: Standing) -> None:
        self.by = ""
        self._stand = stand
        self._mirrors: dict[str, float] = {}  # where G51.1 mirrors, m

    def take(self, code: str, words: Words, scale: float, *, odd: bool) -> bool:
        """A code that sets or ends one; odd: this is no place for it. False where it does neither, or isn't understood."""
        if code in _ENDS.values():
            return not odd and self._begin(code, words, scale)
        if not self.by or _ENDS.get(code) != self.by:
            return False
        if code == "50.1":
            self._mirrors = {letter: v for letter, v in self._mirrors.items() if letter not in words}
        if code == "50.1" and self._mirrors:
            self._reflect()
            return True
        self._stand.frame(None, "XYZ" if self.by == "51" else "XY")
        self.by = ""
        return True

    def _begin(self, code: str, words: Words, scale: float) -> bool:
        stand = self._stand
        plain = not self.by and stand.own is None
        if set(words) & set("ABCIJK") or not (plain or code == self.by == "51.1"):
            return False
        said = {letter: float(words[letter]) * scale for letter in "XYZ" if letter in words}
        if code == "51.1":
            if not said or mirror("".join(said)) is None:
                return False
            self.by, self._mirrors = code, self._mirrors | said
            self._reflect()
            return True
        place = stand.named(stand.at)
        for i, letter in enumerate("XYZ"):
            place[i] = said.get(letter, place[i])
        if code == "68":
            place[2] = 0.0
            inner = turning(float(words["R"])) if "R" in words else None
        else:
            inner = scaling(*[float(words["P"])] * 3) if "." in words.get("P", "") else None
        if inner is None or np.isnan(place).any():
            return False
        self.by = code
        stand.frame(at_place(place, inner), "XYZ" if code == "51" else "XY")
        return True

    def _reflect(self) -> None:
        inner = mirror("".join(self._mirrors))
        place = np.array([self._mirrors.get(letter, 0.0) for letter in "XYZ"])
        self._stand.frame(None if inner is None else at_place(place, inner), "XY")
