"""What the readers of Siemens' and Heidenhain's programs share: blocks as ISO has them, and the end of what is read."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.gcode import GcodeReader
from camrob.witness.cl.running.ordered import Ordered, Row
from camrob.witness.cl.running.unread import UnreadError
from camrob.witness.cl.standing import Standing
from camrob.witness.cl.teller import UNREAD, Teller

__all__ = ["ForeignReader", "UnreadError"]

_AXES = frozenset("XYZABC")


class ForeignReader(GcodeReader, ABC):
    """Reads a program of another control line by line (`_line`), each as the blocks of ISO 6983 that it stands for.

    numbers: of the set-up's tools, by their names in lower case.
    """

    numbers: Mapping[str, int] = MappingProxyType({})

    def read(self, text: str) -> None:
        """Reads the text up to its end, or to the first statement that is not read."""
        run = self._order(self._statements(text + self.beside))
        try:
            for i, row in run:
                self._line(row, i)
                if self._ended:
                    return
        except UnreadError as error:
            self._gap(run.line, f"{UNREAD}{error}", last=text.rstrip().count("\n") + 1)

    @property
    def tell(self) -> Teller:
        """Where the story is collected."""
        return self._tell

    @property
    def stand(self) -> Standing:
        """Where the axes stand."""
        return self._stand

    @property
    def scale(self) -> float:
        """Metres in one of the program's units."""
        return self._scale

    def _swivel(self, turned: NDArray[np.float64], origin: NDArray[np.float64]) -> None:
        """A plane of the part, (3, 3) and (3,) m, and the tool along its z axis; where the tip went meanwhile nobody knows."""
        self._stand.untilt()
        if not self._stand.swivel(turned, origin):
            raise UnreadError("a plane beside a tool centre point")
        self._tell.lose()

    def _unswivel(self) -> None:
        """No plane any more, and rotary axes at zero."""
        self._stand.untilt()
        self._stand.at.update(A=0.0, B=0.0, C=0.0)
        self._forget()

    def _statements(self, text: str) -> list[tuple[int, str]]:
        """The statements with their lines."""
        return [(i, row) for i, row in enumerate(text.split("\n"), 1) if row.strip()]

    @abstractmethod
    def _order(self, rows: list[Row]) -> Ordered:
        """The statements in the order in which they are run."""

    @abstractmethod
    def _line(self, row: str, line: int) -> None:
        """One statement. Raises UnreadError for one that is not read."""

    def _block(self, words: list[str], line: int, vector: tuple[float, ...] | None = None) -> None:
        """One block of ISO's words; vector: the tool's axis behind it, with or without a way of the tip."""
        if vector is None:
            if words:
                self._read("".join(words), line)
            return
        if "M128" in words:
            self._stand.switch("M", True)
        if not self._stand.aim(np.array(vector)):
            raise UnreadError("a tool axis without length or tool centre point")
        self._read("".join(words), line)
        if not any(word[0] in _AXES for word in words):
            self._line_or_arc(set(), {}, line)
