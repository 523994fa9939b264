"""Where Siemens' polar motions, circles through a point or by a tangent or an angle, and slanting lines lead to, in one plane.

840D sl, "Programming Manual Fundamentals": G110, G111, G112, AP=, RP=, AR=, CIP, CT, ANG=. Places are complex numbers, the
plane's first axis real, in the program's unit.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping

from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.foreign.klartext_places import smooth_arc
from camrob.witness.units import deg_to_rad

__all__ = ["OWN", "POLES", "Places", "axes_of"]

OWN = frozenset(("AR", "AP", "RP", "ANG", "I1", "J1", "K1"))
POLES = ("110", "111", "112")
_AXES = {"17": ("X", "Y", "Z"), "18": ("Z", "X", "Y"), "19": ("Y", "Z", "X")}  # the plane's two, and the tool's
_CENTRES = {"17": ("I", "J"), "18": ("K", "I"), "19": ("J", "K")}
_TURN = 2.0 * math.pi


def axes_of(plane: str) -> tuple[str, str, str]:
    """The plane's two axes, and the one across it."""
    return _AXES[plane]


class Places:
    """mode: CIP or CT, in force till one of G0 to G3. going: the way in which the last cut has ended, None: not known."""

    def __init__(self) -> None:
        self.mode = ""
        self.going: complex | None = None
        self._pole: tuple[complex, str] | None = None  # with its plane; None: nobody has set one
        self._lost = False
        self._radius: float | None = None

    def reframe(self) -> None:
        """Another frame: pole and way are not followed into it."""
        self.going, self._pole, self._radius, self._lost = None, None, None, True

    def set_pole(self, code: str, to: Mapping[str, float], own: Mapping[str, float], here: complex, plane: str) -> None:
        """G110: from where the tool is; G111: from the frame's zero; G112: from the pole before."""
        axes = _AXES[plane]
        if code == "111":
            base = 0j
        elif code == "110":
            base = here
        else:
            base = self._about(plane)
        if set(own) == {"AP", "RP"} and not to:
            off = own["RP"] * cmath.exp(1j * deg_to_rad(own["AP"]))
        elif not own and to and set(to) <= set(axes[:2]):
            off = complex(to.get(axes[0], 0.0), to.get(axes[1], 0.0))
        else:
            raise UnreadError("a pole beside other words")
        if cmath.isnan(base):
            raise UnreadError("a pole from where the tool isn't known to be")
        self._pole, self._radius, self._lost = (base + off, plane), None, False

    def _about(self, plane: str) -> complex:
        if self._lost or (self._pole is not None and self._pole[1] != plane):
            raise UnreadError("a pole of another frame or plane")
        return 0j if self._pole is None else self._pole[0]

    def ends(
        self,
        way: str,
        own: Mapping[str, float],
        named: Mapping[str, float],
        here: complex,
        plane: str,
        level: float,
        *,
        steps: bool,
    ) -> tuple[str, dict[str, float]]:
        """The motion (0 to 3) that the block makes, and its words; named: what it says of axes and centre.

        Raises UnreadError for what doesn't go together, or from a place that isn't known.
        """
        first, second, across = _AXES[plane]
        centre = _CENTRES[plane]
        if cmath.isnan(here):
            raise UnreadError("a place by angle, radius or tangent from where the tool isn't known to be")
        origin = here if steps else 0j
        to = complex(
            named[first] + origin.real if first in named else here.real,
            named[second] + origin.imag if second in named else here.imag,
        )
        middle: complex | None = None
        said = {first, second} & set(named)
        centred = set(centre) & set(named)
        if self.mode == "CIP":
            point = complex(own.get(f"{centre[0]}1", math.nan), own.get(f"{centre[1]}1", math.nan)) + origin
            flat = [v for k, v in own.items() if k not in (f"{centre[0]}1", f"{centre[1]}1")]
            flat += [named[across]] if across in named else []
            odd = centred or set(own) - {"I1", "J1", "K1"} or any(v != (0.0 if steps else level) for v in flat)
            if odd or cmath.isnan(point):
                raise UnreadError("CIP without its point, or out of the plane")
            middle, way = _through(here, point, to)
        elif self.mode == "CT" and not own:
            if across in named or plane != "17" or centred:
                raise UnreadError("CT in another plane than G17, or along the tool")
            off, sense = smooth_arc(self.going, to - here)
            middle, way = here + off, "3" if sense == "+" else "2"
        elif own.keys() <= {"AP", "RP"} and "AP" in own and not steps and not said and not centred:
            pole = self._about(plane)
            self._radius = own.get("RP", self._radius)
            if self._radius is None or self._radius < 0.0:
                raise UnreadError("a polar motion without its radius")
            to = pole + self._radius * cmath.exp(1j * deg_to_rad(own["AP"]))
            middle = pole if way in ("2", "3") else None
        elif own.keys() == {"AR"} and way in ("2", "3") and 0.0 < own["AR"] < 360.0 and bool(said) != bool(centred):
            by = complex(named.get(centre[0], 0.0), named.get(centre[1], 0.0)) if centred else None
            to, middle = _opened(deg_to_rad(own["AR"] if way == "3" else -own["AR"]), here, to, by)
        elif own.keys() == {"ANG"} and way in ("0", "1") and len(said) == 1 and plane == "17":
            to = _slanting(deg_to_rad(own["ANG"]), here, to, along_first=first in said)
        else:
            raise UnreadError(f"{', '.join(sorted(own)) or self.mode}, words of Siemens' that don't go together here")
        end = to - origin
        words = {first: end.real, second: end.imag}
        if middle is not None:
            words |= {centre[0]: (middle - here).real, centre[1]: (middle - here).imag}
        return way, words

    def went(self, way: str, here: complex, to: complex, centre: complex | None) -> None:
        """A motion in G17 has gone from `here` to `to`; centre: of its arc, from `here`, None: not known."""
        self.going = None
        if cmath.isnan(here) or cmath.isnan(to):
            return
        if way == "1" and to != here:
            self.going = to - here
        elif way in ("2", "3") and centre:
            self.going = (to - here - centre) * (1j if way == "3" else -1j) or None


def _through(here: complex, point: complex, to: complex) -> tuple[complex, str]:
    """The middle of the circle through three places, and 3 where it goes anticlockwise: what is as far from all of them."""
    p, q = point - here, to - here
    area = p.real * q.imag - p.imag * q.real
    if abs(area) <= 1e-6 * max(abs(p), abs(q), abs(p - q)) ** 2:
        raise UnreadError("CIP through three places on a line")
    p2, q2 = 0.5 * (p.real**2 + p.imag**2), 0.5 * (q.real**2 + q.imag**2)
    off = complex((p2 * q.imag - q2 * p.imag) / area, (q2 * p.real - p2 * q.real) / area)
    begin, half, end = (cmath.phase(place - off) for place in (0j, p, q))
    return here + off, "3" if (half - begin) % _TURN < (end - begin) % _TURN else "2"


def _opened(sweep: float, here: complex, to: complex, by: complex | None) -> tuple[complex, complex]:
    """End and middle of an arc of that angle (rad, anticlockwise), by its middle from `here`, or by its end."""
    if by is None:
        return to, here + 0.5 * (to - here) * (1.0 + 1j / math.tan(0.5 * sweep))
    radius, begin = cmath.polar(-by)
    return here + by + cmath.rect(radius, begin + sweep), here + by


def _slanting(angle: float, here: complex, to: complex, *, along_first: bool) -> complex:
    """The end of a line by its angle and one coordinate. Raises UnreadError where it doesn't lead there."""
    rise, run = math.sin(angle), math.cos(angle)
    by = (to - here).real / run if along_first and abs(run) >= 1e-6 else math.nan
    if not along_first and abs(rise) >= 1e-6:
        by = (to - here).imag / rise
    if not by > 0.0:
        raise UnreadError("ANG of a line that doesn't lead to its end")
    return here + by * complex(run, rise)
