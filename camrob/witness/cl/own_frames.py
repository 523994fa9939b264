"""G68, G51.1 and G51 of Fanuc's and alike: frames of the program's own, one at a time, each about a point that it names."""

from __future__ import annotations

import math

import numpy as np

from camrob.witness.cl.framing import at_place, mirror, scaling, turning
from camrob.witness.cl.standing import Standing, Words
from camrob.witness.units import deg_to_rad

__all__ = ["OwnFrames", "Polar"]

_ENDS = {"69": "68", "50": "51", "50.1": "51.1"}


class Polar:
    """G16: X is a radius about the program's zero, Y an angle, which adds up in G91; G15 ends it (Fanuc B-64484, 6.2)."""

    def __init__(self) -> None:
        self._on = False
        self._radius = self._angle = math.nan

    def take(self, code: str, *, odd: bool) -> bool:
        """G15 or G16; odd: this is no place for it. False for another code, or where it isn't understood."""
        if code == "15" and self._on:
            self._on = False
            return True
        if code != "16" or odd:
            return False
        self._on, self._radius, self._angle = True, math.nan, math.nan
        return True

    def plain(self, g: list[str], words: Words, at: tuple[float, float], absolute: bool) -> Words | None:
        """The block's words with X and Y as G15 has them, steps in G91; None where they aren't known. at: where the tool is."""
        if not self._on or not {"X", "Y"} & set(words) or {"4", "10", "52", "92", "53"} & set(g):
            return words
        if {"I", "J", "K", "L"} & set(words) or {"18", "19", "28", "30"} & set(g) or (not absolute and "X" in words):
            return None
        self._radius = float(words.get("X", self._radius))
        angle = float(words.get("Y", "0" if not absolute else self._angle))
        self._angle = angle if absolute else self._angle + angle
        ray = deg_to_rad(self._angle)
        x, y = self._radius * math.cos(ray), self._radius * math.sin(ray)
        if not absolute:
            x, y = x - at[0], y - at[1]
        return None if math.isnan(x + y) else {**words, "X": f"{x:.9f}", "Y": f"{y:.9f}"}


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
