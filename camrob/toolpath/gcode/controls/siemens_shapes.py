"""Siemens' other ways to say where a motion ends: polar coordinates, CIP, CT, AR=, ANG=, as ends and centres of ISO's blocks.

Siemens, "Programming Manual Fundamentals" (840D sl, 4.8): 8.4 (G110 to G112, AP, RP), 8.7 (CIP, CT, AR), 8.9 (ANG).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import State
from camrob.toolpath.gcode.controls.heidenhain_tangent import Heading
from camrob.toolpath.gcode.lexer import Word
from camrob.units import deg_to_rad

__all__ = ["KEYS", "POLES", "Shapes"]

KEYS = ("AR", "AP", "RP", "ANG", "I1", "J1", "K1")
"""Addresses with an equals sign."""
POLES = (110.0, 111.0, 112.0)  # G110 to G112
_PLANES: dict[float, tuple[tuple[str, str], tuple[str, str], str]] = {
    17.0: (("X", "Y"), ("I", "J"), "Z"),
    18.0: (("Z", "X"), ("K", "I"), "Y"),
    19.0: (("Y", "Z"), ("J", "K"), "X"),
}
_FLAT_PLANE = ("X", "Y")
_WAYS = (0.0, 1.0, 2.0, 3.0)
_UNITS = frozenset((20.0, 21.0))  # G20 and G21
_FLAT = 1e-6  # of a triangle's longest side: three points nearer to a line than this have no circle
_STEEP = 1e-6  # of a line's angle to an axis: what names its end there leaves it open


def _refused(text: str, hint: str = "have the CAM system write the path with I and J") -> ToolpathError:
    return ToolpathError(text, hint=hint)


class Shapes:
    """Pole, tangent and circles by CIP and CT of one program. Lengths in the program's unit, angles in degrees."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._pole: complex | None = None  # None: the zero of the frame in force
        self._plane = 17.0  # of the pole
        self._radius: float | None = None  # RP, which stays until it is named anew
        self._mode = ""  # CIP or CT: of the group of G0 to G3
        self._heading = Heading()
        self._begun: complex | None = None

    def reframed(self) -> None:
        """Another frame is in force: what the pole and the way mean in it isn't followed."""
        self._pole, self._radius = complex(math.nan), None
        self._heading.lost()

    def said(self, found: Sequence[Word], mode: str) -> bool:
        """Take note of the block's words of the group of G0 to G3; whether CIP or CT is in force."""
        if mode:
            self._mode = mode
        elif any(letter == "G" and value in _WAYS for letter, value, _ in found):
            self._mode = ""
        return bool(self._mode)

    def pole(self, found: Sequence[Word], own: dict[str, float]) -> list[Word] | None:
        """Take a pole from a block of G110, G111 or G112, which moves nothing: what else it says; None for another block."""
        kinds = [value for letter, value, _ in found if letter == "G" and value in POLES]
        if not kinds:
            return None
        first, second = self._letters(found)[0]
        rest = [(k, v, w) for k, v, w in found if k not in (first, second) and not (k == "G" and v in POLES)]
        if any(k != "G" for k, _, _ in rest) or self._state("distance") == 91.0:
            raise _refused("a pole (G110 to G112) beside other words, or in G91")
        if kinds[0] == 111.0:
            about: complex | None = 0j
        else:
            about = self._here(first, second) if kinds[0] == 110.0 else (0j if self._pole is None else self._pole)
        if about is None or cmath.isnan(about):
            raise _refused(f"a pole by G{kinds[0]:g} from a place that is not known", "set it by G111")
        to = {k: v for k, v, _ in found}
        off = complex(to.get(first, 0.0), to.get(second, 0.0))
        if set(own) == {"AP", "RP"}:
            off = cmath.rect(own["RP"], deg_to_rad(own["AP"]))
        elif own or not {first, second} & set(to):
            raise _refused("a pole of which no place is named")
        self._pole, self._plane, self._radius = about + off, self._of_plane(found), None
        return rest

    def shaped(self, found: list[Word], own: dict[str, float], *, steps: bool) -> list[Word]:
        """The block's words, with the end and the centre that `own` (of `KEYS`) or CIP or CT leads to.

        steps: in G91. Raises ToolpathError where that doesn't follow from what the program says.
        """
        letters, centre, along = self._letters(found)
        first, second = letters
        values = {letter: value for letter, value, _ in found if letter != "G"}
        moves = {first, second, along} & set(values)
        if not own and not (self._mode and moves):
            return found
        if any(k == "G" and v in _UNITS for k, v, _ in found) or "P" in values or "R" in values:
            raise _refused("AP, RP, AR, ANG, CIP or CT beside a unit, TURN or CR in one block")
        begun = self._here(first, second)
        if begun is None:
            raise _refused(
                "AP, RP, AR, ANG, CIP or CT from a place that is not known", "name both axes of its plane before it"
            )
        to = complex(
            (begun.real if steps else 0.0) + values.get(first, 0.0 if steps else begun.real),
            (begun.imag if steps else 0.0) + values.get(second, 0.0 if steps else begun.imag),
        )
        way = next((v for k, v, _ in reversed(found) if k == "G" and v in _WAYS), self._state("motion"))
        middle: complex | None = None
        if self._mode == "CT" and not own:
            middle, way = self._tangent(begun, to, {along} & set(values), letters)
        elif self._mode == "CIP":
            middle, way = self._through(begun, to, own, values, (centre, along), steps=steps)
        elif {"AP", "RP"} & set(own):
            if steps or moves - {along} or set(own) - {"AP", "RP"} or set(centre) & set(values):
                raise _refused("AP= and RP= in G91, or beside an end or a centre")
            to, middle = self._polar(own, begun, self._of_plane(found), round_=way in (2.0, 3.0))
        elif set(own) == {"AR"} and way in (2.0, 3.0):
            to, middle = self._opened(own["AR"], begun, to, values, letters, centre, left=way == 3.0)
        elif set(own) == {"ANG"} and way in (0.0, 1.0):
            to = self._slanted(own["ANG"], begun, to, {first, second} & set(values), letters)
        else:
            raise _refused(f"{', '.join(sorted(own))} that don't go together, or with this motion")
        kept = [w for w in found if w[0] not in (*letters, *centre) and not (w[0] == "G" and w[1] in _WAYS)]
        end = to - begun if steps else to
        kept += [("G", float(way or 0.0), True), (first, end.real, False), (second, end.imag, False)]
        if middle is not None:
            off = middle - begun
            kept += [(centre[0], off.real, False), (centre[1], off.imag, False)]
        return kept

    # -- where it goes -----------------------------------------------------------------------------------------

    def _tangent(self, begun: complex, to: complex, along: set[str], letters: tuple[str, str]) -> tuple[complex, float]:
        if along or letters != _FLAT_PLANE:
            raise _refused("CT along the tool, or in another plane than G17")
        (u, v), left = self._heading.arc((begun.real, begun.imag), (to.real, to.imag))
        return begun + complex(u, v), 3.0 if left else 2.0

    def _through(
        self,
        begun: complex,
        to: complex,
        own: dict[str, float],
        values: dict[str, float],
        axes: tuple[tuple[str, str], str],
        *,
        steps: bool,
    ) -> tuple[complex, float]:
        """CIP: the circle through where it begins, I1, J1 (K1), and its end."""
        centre, along = axes
        names = (f"{centre[0]}1", f"{centre[1]}1")
        across = own.get(f"{'IJK'['XYZ'.index(along)]}1")
        level = 0.0 if steps else self._state(f"at {along}")
        flat = all(v is None or (level is not None and abs(v - level) < 1e-9) for v in (across, values.get(along)))
        if not set(names) <= set(own) or not flat or set(own) - {"I1", "J1", "K1"} or set(centre) & set(values):
            raise _refused("a circle through a point (CIP) out of its plane, or without its point")
        point = complex(own[names[0]], own[names[1]]) + (begun if steps else 0.0)
        a, b = point - begun, to - begun
        turn = (a.conjugate() * b).imag  # twice the triangle's area, to the left where the point lies to the right
        if abs(turn) <= _FLAT * max(abs(a), abs(b), abs(b - a)) ** 2:
            raise _refused("a circle through a point (CIP) whose three places lie on a line")
        off = 1j * (a * abs(b) ** 2 - b * abs(a) ** 2) / (2.0 * turn)
        return begun + off, 3.0 if turn > 0.0 else 2.0

    def _polar(
        self, own: dict[str, float], begun: complex, plane: float, *, round_: bool
    ) -> tuple[complex, complex | None]:
        pole = 0j if self._pole is None else self._pole
        if cmath.isnan(pole) or (self._pole is not None and plane != self._plane):
            raise _refused("AP= or RP= about a pole that was set in another frame or plane", "set it by G111 anew")
        self._radius = radius = own.get("RP", self._radius)
        if "AP" not in own or radius is None or radius < 0.0:
            raise _refused("a polar motion whose angle (AP=) or radius (RP=) is not known", "name both of them")
        return pole + cmath.rect(radius, deg_to_rad(own["AP"])), pole if round_ else None

    @staticmethod
    def _opened(
        angle: float,
        begun: complex,
        to: complex,
        values: dict[str, float],
        letters: tuple[str, str],
        centre: tuple[str, str],
        *,
        left: bool,
    ) -> tuple[complex, complex]:
        """AR: an arc of that angle, by its centre or by its end."""
        ends, centred = set(letters) & set(values), set(centre) & set(values)
        if not 0.0 < angle < 360.0 or bool(ends) == bool(centred):
            raise _refused("AR= without a centre or an end, or with both of them")
        turn = cmath.rect(1.0, deg_to_rad(angle if left else -angle))
        if centred:
            middle = begun + complex(values.get(centre[0], 0.0), values.get(centre[1], 0.0))
            return middle + (begun - middle) * turn, middle
        if to == begun:
            raise _refused("AR= to where the arc begins")
        return to, (to - begun * turn) / (1.0 - turn)

    @staticmethod
    def _slanted(angle: float, begun: complex, to: complex, named: set[str], letters: tuple[str, str]) -> complex:
        """ANG: a straight line by its angle to the plane's first axis and one of its end's coordinates."""
        ray = cmath.rect(1.0, deg_to_rad(angle))
        if len(named) != 1 or letters != _FLAT_PLANE:
            raise _refused("ANG= without one coordinate of the end, or with both, or in another plane than G17")
        way, share = ((to - begun).real, ray.real) if letters[0] in named else ((to - begun).imag, ray.imag)
        if abs(share) < _STEEP or way / share <= 0.0:
            raise _refused("ANG= of a line that doesn't lead to its end")
        return begun + ray * (way / share)

    # -- what is in force --------------------------------------------------------------------------------------

    def begins(self) -> None:
        """A motion is about to be carried out."""
        self._begun = self._here("X", "Y")

    def ends(self, words: dict[str, float], *, sure: bool) -> None:
        """A motion has been: the way in which it ends. words: of its block as ISO has them; sure: it ends as they say."""
        begun, to, motion = self._begun, self._here("X", "Y"), self._state("motion")
        self._heading.lost()
        if not sure or begun is None or to is None or self._state("plane") != 17.0:
            return
        if motion == 1.0:
            self._heading.straight({"X": begun.real, "Y": begun.imag}, {"X": to.real, "Y": to.imag}, sure=True)
        elif motion in (2.0, 3.0) and "R" not in words:
            centre = {k: words.get(k, 0.0) for k in "IJ"}
            self._heading.round((begun.real, begun.imag), (to.real, to.imag), centre, left=motion == 3.0)

    def _of_plane(self, found: Sequence[Word]) -> float:
        said = [v for k, v, _ in found if k == "G" and v in _PLANES]
        return said[-1] if said else (self._state("plane") or 17.0)

    def _letters(self, found: Sequence[Word]) -> tuple[tuple[str, str], tuple[str, str], str]:
        return _PLANES[self._of_plane(found)]

    def _here(self, first: str, second: str) -> complex | None:
        u, v = self._state(f"at {first}"), self._state(f"at {second}")
        return None if u is None or v is None else complex(u, v)
