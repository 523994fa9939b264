"""How a program begins: cuts whose beginning it hasn't named."""

from __future__ import annotations

from camrob.witness.cl.standing import UNNAMED, Standing
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Gap

__all__ = ["Beginning"]

_FROM_NOWHERE = "a cut from where the tool is not known to be"


class Beginning:
    """Straight cuts that begin where the program has not said that the tool stands, and end where it has said it in part.

    A control begins from its present position. Where the next moves name what is missing, leave alone what has been named, and
    then go down along Z, or across in rapid, these were a way above the part to there: the gap that they are is taken back. Where
    they don't, something may have been cut in a place that nobody knows.
    """

    def __init__(self, tell: Teller, stand: Standing) -> None:
        self._tell, self._stand = tell, stand
        self._gap: Gap | None = None
        self._named: dict[str, float] = {}
        self._over = False  # the first place is reached, at a feed
        self._cuts = False  # something has been cut
        self._over_part: tuple[float | None, float | None] = (None, None)  # X and Y

    def cut(self, line: int, axes: set[str], *, straight: bool) -> None:
        """A cut in a place that is not known; axes: the letters of its block."""
        stand, tell, reason = self._stand, self._tell, self._stand.nowhere
        goes_on = bool(tell.gaps) and (tell.gaps[-1].text, tell.gaps[-1].before) == (reason, tell.n)
        own = not goes_on or tell.gaps[-1] is self._gap  # else one that is a cut has become a part of the gap
        tell.gap(line, reason)
        named = {k: v for k in "XYZ" if (v := stand.at[k]) is not None}
        if own and reason == UNNAMED and straight and self._plain and axes <= named.keys():
            self._gap, self._named, self._over = tell.gaps[-1], named, False
        else:
            self._gap = None

    def moved(self, line: int, *, rapid: bool, straight: bool) -> None:
        """The axes stand elsewhere than before."""
        self._checked(rapid=rapid)
        before, self._over_part = self._over_part, (self._stand.at["X"], self._stand.at["Y"])
        if rapid or self._stand.pose() is None:
            return
        across = before != self._over_part  # straight down from wherever it is cuts nothing else
        tell, risen = self._tell, self._stand.risen
        told = bool(tell.gaps) and tell.gaps[-1].before == tell.n  # that what is here isn't judged
        if across and straight and not told and tell.here is None and not self._cuts and self._stand.tcp and not risen:
            tell.gap(line, _FROM_NOWHERE)  # no way down is known by its letters
            self._gap = None
        elif across and straight and not told and tell.here is None and self._plain:
            tell.gap(line, _FROM_NOWHERE)
            self._gap, self._over = None if risen else tell.gaps[-1], True
            self._named = {letter: v for letter in "XYZ" if (v := self._stand.at[letter]) is not None}
        self._cuts, self._stand.risen = True, False

    @property
    def _plain(self) -> bool:
        stand = self._stand
        return not (stand.odd or stand.tilted or stand.used or self._tell.hidden) and stand.own is None

    def _checked(self, *, rapid: bool) -> None:
        """Whether what a gap is of was a way above the part."""
        if self._gap is None:
            return
        at = {letter: v for letter in "XYZ" if (v := self._stand.at[letter]) is not None}
        changed = {letter for letter, value in self._named.items() if at.get(letter) != value}
        down = changed == {"Z"} and at.get("Z", self._named["Z"]) < self._named["Z"]
        if self._over and (down or (rapid and "Z" not in changed)):
            self._tell.gaps = [gap for gap in self._tell.gaps if gap is not self._gap]
            self._tell.note("moves at a feed from where the machine happens to stand are the way to the first place")
            self._gap = None
        elif changed or self._over:
            self._gap = None
        elif len(at) == len("XYZ"):
            self._named, self._over = at, True
            if rapid:
                self._checked(rapid=True)
