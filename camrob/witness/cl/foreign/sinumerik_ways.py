"""Blocks of Siemens' that say in their own way where they lead to, as ISO's: `sinumerik_places`, from where the axes stand."""

from __future__ import annotations

from abc import ABC

from camrob.witness.cl.foreign.foreign_words import ForeignReader, UnreadError
from camrob.witness.cl.foreign.sinumerik_places import POLES, Places, axes_of

__all__ = ["WAYS", "OwnWays"]

WAYS = ("G0", "G1", "G2", "G3")


class OwnWays(ForeignReader, ABC):
    """A reader that follows poles, tangents and angles in `_places`."""

    def read(self, text: str) -> None:
        """Reads the text up to its end, or to the first statement that is not read."""
        self._places = Places()
        super().read(text)

    def _ends_of(
        self, words: list[str], own: dict[str, float], mode: str, hows: dict[str, str], *, odd: bool
    ) -> list[str]:
        """The block's words as ISO's; odd: it goes by the machine, or ends in a corner. Empties `hows` where it has used them."""
        if mode or any(word in WAYS for word in words):
            self._places.mode = mode
        if poles := [word for word in words if word[1:] in POLES]:
            return self._set_pole(poles[-1][1:], words, own)
        if not own and not (self._places.mode and any(word[0] in "XYZ" for word in words)):
            return words
        if odd:
            raise UnreadError("a place of Siemens' own kind, by the machine or with a corner")
        words = self._own_way(words, own, hows)
        hows.clear()
        return words

    def _at_plane(self, plane: str) -> complex:
        """Where the tool is in the plane, in the program's unit and frame; NaN where it isn't known."""
        at = self._now()
        return complex(*(at[axis] for axis in axes_of(plane)[:2]))

    def _now(self) -> dict[str, float]:
        """Where the tool is, by axis, in the program's unit and frame; NaN where it isn't known."""
        return {axis: float(v) / self._scale for axis, v in zip("XYZ", self._stand.named(self._stand.at), strict=True)}

    def _went(self, words: list[str], here: complex, *, sure: bool) -> None:
        """Take note of the way in which a motion of these words has ended."""
        centre = {word[0]: float(word[1:]) for word in words if word[0] in "IJ"}
        known = centre and not any(word[0] == "R" for word in words) and self._plane == "17"
        by = complex(centre.get("I", 0.0), centre.get("J", 0.0)) if known else None
        way = self._motion if sure and self._plane == "17" else "0"
        self._places.went(way, here, self._at_plane("17"), by)

    def _set_pole(self, code: str, words: list[str], own: dict[str, float]) -> list[str]:
        """G110, G111 or G112, which move nothing; what else the block says."""
        rest = [word for word in words if word[0] == "G" and word[1:] not in POLES]
        to = {word[0]: float(word[1:]) for word in words if word[0] != "G"}
        if not self._absolute or any(word in ("G90", "G91", "G17", "G18", "G19") for word in rest):
            raise UnreadError("a pole in G91, or beside a plane")
        self._places.set_pole(code, to, own, self._at_plane(self._plane), self._plane)
        return rest

    def _own_way(self, words: list[str], own: dict[str, float], hows: dict[str, str]) -> list[str]:
        """The words of a block that says in Siemens' own way where it leads to, as ISO's."""
        if any(word in ("G90", "G91", "G17", "G18", "G19", "G20", "G21") or word[0] in "RP" for word in words):
            raise UnreadError("a place of Siemens' own kind beside G17, G90, G70, CR or TURN")
        ways = [word[1:] for word in words if word in WAYS] or [self._motion]
        named = {word[0]: float(word[1:]) for word in words if word[0] in "XYZIJK"}
        here, steps = self._at_plane(self._plane), not self._absolute
        at, across = self._now(), axes_of(self._plane)[2]
        for letter, how in hows.items():
            if steps or letter not in "XYZIJK" or how not in ("IC", "AC"):
                raise UnreadError(f"{letter}={how} beside a place of Siemens' own kind")
            if letter in "XYZ" and how == "IC":
                named[letter] += at[letter]
            elif letter in "IJK" and how == "AC":
                named[letter] -= at["XYZ"["IJK".index(letter)]]
        way, ends = self._places.ends(ways[-1], own, named, here, self._plane, at[across], steps=steps)
        kept = [word for word in words if word not in WAYS and word[0] not in "XYZIJK"]
        kept += [f"{across}{named[across]:.9f}"] if across in named else []
        return [f"G{way}", *kept, *(f"{letter}{value:.9f}" for letter, value in ends.items())]
