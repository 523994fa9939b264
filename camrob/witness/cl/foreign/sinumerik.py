"""Siemens 840D: blocks of words, X=..., R parameters, TRAORI with A3 B3 C3, TRANS, SUPA, some cycles and planes.

Siemens, "Programming Manual Fundamentals" and "Job planning" (840D sl). Everything else ends what is read.
"""

from __future__ import annotations

import math
import re

import numpy as np

from camrob.witness.cl.circles import Wanted
from camrob.witness.cl.foreign.computed_values import Values
from camrob.witness.cl.foreign.foreign_cycles import ACROSS, Hole, drill_here, places, siemens_hole, swivelled_plane
from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.foreign.sinumerik_places import OWN, POLES
from camrob.witness.cl.foreign.sinumerik_ways import WAYS, OwnWays
from camrob.witness.cl.framing import mirror, scaling, shifting, turning
from camrob.witness.cl.running.ordered import Ordered, Row
from camrob.witness.cl.running.structure_run import StructureRun
from camrob.witness.units import m_to_mm

__all__ = ["SinumerikReader"]

_COMMENT = re.compile(r"(\"[^\"]*\")|;.*")
_HEADER = re.compile(r"%_N_\w+|%\w*|PROC \w+.*")
_TOKEN = re.compile(
    r"\s*(?:(?P<name>T)\s*=\s*\"(?P<text>[^\"]*)\"|(?P<key>[A-Z]+\d?)\s*=\s*(?P<set>[-+]?(?:\d+\.?\d*|\.\d+))(?![\d.*/+(A-Z-])"
    r"|(?P<of>[A-Z])\s*=\s*(?P<how>IC|AC|DC|ACP|ACN)\s*\(\s*(?P<given>[-+]?(?:\d+\.?\d*|\.\d+))\s*\)"
    r"|(?P<word>[A-Z])\s*(?P<value>[-+]?(?:\d+\.?\d*|\.\d+))(?![\w=])|(?P<said>[A-Z][A-Z_]{2,}\d*[A-Z]*|CT)(?:\(1\))?(?![\w=(]))"
)
# how fast and how smoothly the path is run, and who finds the rotary axes: not where it goes
_QUIET = frozenset(
    """SOFT BRISK DRIVE FFWON FFWOF COMPON COMPOF COMPCURV COMPCAD COMPSURF UPATH SPATH CUT2D CUT2DF STOPRE DYNNORM DYNPOS
    DYNROUGH DYNSEMIFIN DYNFINISH DYNPREC ORIWKS ORIMKS ORIAXES ORIVECT ORIPLANE ORISON ORISOF CDOF CDON WALIMON WALIMOF RTLION
    RTLIOF CFIN CFC CFTCP DIAMOF FNORM NORM KONT ADISPOS FIFOCTRL SBLON SBLOF SAVE DISPLOF""".split()
)
_QUIET_CALLS = re.compile(
    r"(CYCLE832|MSG|FGROUP|FGREF|WORKPIECE|GROUP_BEGIN|GROUP_END|GROUP_ADDEND|EXTERN|SETMS)\s*\(.*\)"
)
_SMOOTHING = re.compile(r"\b([CO]TOL|ADIS(POS)?)\s*=\s*[-+\d.]+")  # how near the path is kept to
_QUIET_G = frozenset("9 60 64 601 602 603 641 642 643 644 645 450 451 460 461 462".split())
_UNITS = {"70": "G20", "700": "G20", "71": "G21", "710": "G21"}
_PLAIN_G = frozenset("0 1 2 3 4 17 18 19 40 41 42 53 54 55 56 57 90 91 93 94 95 97".split())
_VECTOR = ("A3", "B3", "C3")
_CORNERS = {"RND": "radius", "CHR": "side", "CHF": "across"}


def _tight(body: str) -> str:
    """Without blanks beside operators; one that parts two words stays."""
    return re.sub(r"\s*([-+*/(=])\s*|\s+(?=\))", lambda found: found[1] or "", body)


class SinumerikReader(OwnWays):
    """Tells what the blocks of one file ask for."""

    def read(self, text: str) -> None:
        """Reads the text up to its end, or to the first statement that is not read."""
        names = {name.upper() for name in re.findall(r"\bT\s*=\s*\"([^\"]*)\"", re.sub(r";.*", "", text), re.I)}
        self._offsets.edges = True
        self._whose_change(re.sub(r";.*", "", text).upper())
        self._lone = len(names) == 1 and not any(
            name.isdigit() or name.strip().casefold() in self.numbers for name in names
        )
        self._called: Hole | None = None  # MCALL
        self._computed = Values()
        self._counts: frozenset[str] = frozenset()  # names for whole numbers (INT)
        self._swivelled = False  # by CYCLE800
        super().read(text)

    def _order(self, rows: list[Row]) -> Ordered:
        plain = [(i, " ".join(_COMMENT.sub(lambda found: found[1] or "", row).upper().split())) for i, row in rows]
        return StructureRun([(i, row) for i, row in plain if row], self._computed)

    def _line(self, row: str, line: int) -> None:
        body = _COMMENT.sub(lambda found: found[1] or "", row).upper().strip()
        if body.startswith("/"):
            self._tell.note("blocks that may be skipped (/) are taken as executed")
            body = re.sub(r"^/\d?\s*", "", body)
        body = re.sub(r"^[N:]\d+\s*", "", body)
        if body in ("CYCLE800", "CYCLE832"):
            body += "()"
        if _HEADER.fullmatch(body):
            if self._tell.n:
                raise UnreadError("another program in the same file")
            return
        if not body or _QUIET_CALLS.fullmatch(body) or self._kept(body):
            return
        body = self._written_out(_SMOOTHING.sub("", body).strip())
        if frame := re.fullmatch(r"(A?)(TRANS|ROT|MIRROR|SCALE)\b(.*)", body):
            self._framed(frame[2], frame[3], adds=bool(frame[1]))
            return
        if (call := re.fullmatch(r"(HOLES[12]|CYCLE802)\s*\((.*)\)", body)) and self._called is not None:
            motion, absolute = self._motion, self._absolute
            for x, y in places(call[1], self._values(call[2])):
                self._block(["G90", "G0", f"X{x:.9f}", f"Y{y:.9f}"], line)
                self._drill(self._called, line)
            self._motion, self._absolute = motion, absolute
        elif call := re.fullmatch(r"(MCALL\s+)?(CYCLE8\d+)\s*\((.*)\)", body):
            self._cycle_of(call[2], self._values(call[3]), line, modal=bool(call[1]))
        elif body == "MCALL":
            self._called = None
        elif re.search(r"\bG7[45](?!\d)", body):
            self._fixed_point(body, line)
        else:
            before = self._tell.n
            self._words(body, line)
            if self._called is not None and (
                self._tell.n > before or re.search(r"(?<![A-Z])[XYZ]\s*=?\s*[-+\d.]", body)
            ):
                self._drill(self._called, line)

    def _fixed_point(self, body: str, line: int) -> None:
        """G74, G75: in rapid to a place of the machine; the motion of before holds again behind it."""
        motion = self._motion
        rest = re.sub(r"\bG7[45]\b|\b(FP|POS)\s*=\s*\d+", "", body)
        self._words("G0 SUPA " + re.sub(r"\b([XYZABC])1\s*=", r"\1=", rest), line)
        if motion in ("1", "2", "3"):
            self._block([f"G{motion}"], line)

    def _kept(self, body: str) -> bool:
        """Whether the block only declares names or gives them values, which are kept."""
        if declared := re.fullmatch(r"DEF\s+(REAL|INT)\s+(.+)", body):
            for part in declared[2].split(","):
                name, _, text = part.partition("=")
                self._counts = (
                    (self._counts | {name.strip()}) if declared[1] == "INT" else self._counts - {name.strip()}
                )
                self._keep(name.strip(), text or "0")
            return True
        body = _tight(body)
        parts = body.split()
        found = [re.fullmatch(r"(R\d+|[A-Z_]\w*)=([^=<>]+)", part) for part in parts]
        names = [
            match[1] for match in found if match and (re.fullmatch(r"R\d+", match[1]) or match[1] in self._computed)
        ]
        if not parts or len(names) != len(parts):
            return False
        for match in found:
            if match:
                self._keep(match[1], match[2])
        return True

    def _keep(self, name: str, text: str) -> None:
        """Raises UnreadError where a name for whole numbers would be rounded."""
        self._computed.keep(name, text)
        if name in self._counts and self._computed.of(name) % 1.0:
            raise UnreadError(f"{name}={text[:16]}, a number that isn't whole")

    def _written_out(self, body: str) -> str:
        """The block with numbers where names or expressions stand behind an equals sign."""
        if not re.search(r"=\s*[-+]*\s*(?:\(|R\d|[A-Z_]{2,}|_)|=[^=]*\d\s*[-+*/]", body) or '"' in body:
            return body
        body = _tight(body)

        def number(match: re.Match[str]) -> str:
            how = re.fullmatch(r"(IC|AC|DC|ACP|ACN)\((.*)\)", match[2])
            if how:
                return f"{match[1]}={how[1]}({self._computed.of(how[2]):.9f})"
            return f"{match[1]}={self._computed.of(match[2]):.9f}"

        return re.sub(r"\b([A-Z]+\d?)=([^\s=]+)", number, body)

    def _values(self, text: str) -> list[float | None]:
        """Numbers between commas, None for texts and what is left out. Raises UnreadError for what is computed."""
        out: list[float | None] = []
        for part in (part.strip() for part in text.split(",")) if text.strip() else ():
            out.append(self._computed.of(part) if part and not part.startswith('"') else None)
        return out

    def _drill(self, hole: Hole, line: int) -> None:
        """The hole here. In G18 and G19 the control drills along Y and X, the plane's normal ("Job planning", cycles)."""
        if self._plane != "17":
            raise UnreadError(ACROSS)
        drill_here(self, hole, line)

    def _cycle_of(self, name: str, values: list[float | None], line: int, *, modal: bool) -> None:
        """CYCLE800, or a drilling cycle here or, behind MCALL, at every place from here on."""
        if name != "CYCLE800":
            hole = siemens_hole(name, values, m_to_mm(self.scale))
            if modal:
                self._called = hole
            else:
                self._drill(hole, line)
            return
        plane = swivelled_plane(values)
        self._places.reframe()
        if modal or self._stand.own is not None:
            raise UnreadError("CYCLE800 on top of a frame")
        upright = plane is not None and np.allclose(plane[0], np.eye(3)) and not plane[1].any()
        self._swivelled = plane is not None and not upright
        if plane is None:
            turned = [self._stand.at[letter] for letter in "ABC"]
            self._unswivel()
            if any(
                turn is None or turn for turn in turned
            ):  # the frames end, and the rotary axes stay as they are turned
                self._stand.at.update(A=None, B=None, C=None)
        elif upright:
            self._unswivel()
        else:
            self._swivel(plane[0], plane[1] * self._scale)

    def _framed(self, kind: str, rest: str, *, adds: bool) -> None:
        """TRANS, ROT, MIRROR, SCALE end all frames before them, and set their own; with A, theirs stands within."""
        number = r"[-+]?(?:\d+\.?\d*|\.\d+)"
        rest = _tight(rest).strip()
        if re.search(r"=[^\s]*[A-Z(*/]|=[^\s]*\d[-+]", rest):
            rest = re.sub(r"(\b[A-Z]+)=(\S+)", lambda m: f"{m[1]}={self._computed.of(m[2]):.9f}", rest)
        parts = re.findall(rf"(RPL|[XYZ])\s*=?\s*({number})(?![\w.*/+-])", rest)
        if re.sub(rf"(?:RPL|[XYZ])\s*=?\s*{number}", "", rest).strip():
            raise UnreadError("a frame that is computed, or of another axis")
        said = {name: float(value) for name, value in parts}
        if self._swivelled and not adds:
            raise UnreadError(f"{kind} on top of CYCLE800")
        inner: np.ndarray | None
        if kind == "TRANS":
            inner = None if "RPL" in said else shifting([said.get(k, 0.0) * self._scale for k in "XYZ"])
        elif kind == "ROT":
            inner = turning(sum(said.values())) if set(said) <= {"Z"} or set(said) <= {"RPL"} else None
            inner = inner if self._plane == "17" else None
        elif kind == "MIRROR":
            inner = mirror("".join(said)) if "RPL" not in said else None
        else:
            inner = scaling(*(said.get(k, 1.0) for k in "XYZ")) if "RPL" not in said else None
        if inner is None:
            raise UnreadError(f"{kind} about another axis, of Z, or by two factors")
        before = self._stand.own if adds and self._stand.own is not None else np.eye(4)
        own = before @ inner
        self._stand.frame(None if np.array_equal(own, np.eye(4)) else own)
        self._places.reframe()

    def _words(self, body: str, line: int) -> None:
        words: list[str] = []
        vector: dict[str, float] = {}
        hows: dict[str, str] = {}
        machine, at, corner = False, 0, None
        own, mode = dict[str, float](), ""
        while at < len(body):
            token = _TOKEN.match(body, at)
            if token is None:
                raise UnreadError(f"{body[at : at + 20].strip()}: computed, or a word of Siemens'")
            at = token.end()
            if token["name"]:
                words += self._tool(token["text"])
            elif token["of"]:
                hows[token["of"]] = token["how"]
                words += self._plain(token["of"], token["given"])
            elif token["said"] in ("CIP", "CT"):
                mode = token["said"]
            elif token["said"]:
                machine = machine or token["said"] == "SUPA"
                words += self._said(token["said"])
            elif token["key"] in _CORNERS:
                corner = Wanted(**{_CORNERS[token["key"]]: abs(float(token["set"])) * self._scale})
            elif token["key"] in _VECTOR:
                vector[token["key"]] = float(token["set"])
            elif token["key"] in OWN:
                own[token["key"]] = float(token["set"])
            elif (token["word"] or token["key"]) == "G":
                code = f"{float(token['value'] or token['set']):g}"
                machine = machine or code in ("53", "153")
                words += self._code(code)
            else:
                words += self._plain(token["word"] or token["key"], token["value"] or token["set"])
            while at < len(body) and body[at] == " ":
                at += 1
        if "G4" in words:
            words = self._dwell(words)
        words = self._ends_of(words, own, mode, hows, odd=machine or corner is not None)
        aims = tuple(vector.get(name, 0.0) for name in _VECTOR) if vector else None
        if machine and any(word[0] in "XYZABC" for word in words):
            words.append("G53")
        if self._lone:
            words = [word for word in words if not re.fullmatch(r"M0*6", word)]
        cuts = ([word for word in words if word in WAYS] or [f"G{self._motion}"])[-1] != "G0"
        for letter, how in hows.items():
            if how in ("DC", "ACP", "ACN"):
                to = next(float(word[1:]) for word in words if word[0] == letter)
                if letter not in "ABC" or (not self._stand.wind(letter, to, how) and cuts):
                    raise UnreadError(f"{letter}={how}, which may be either way round")
                hows[letter] = "AC"
        before, after = self._measured(hows, words)
        self._block(before, line)
        here = self._at_plane("17")
        self._bent = corner
        self._block(words, line, aims)
        if any(word[0] in "XYZIJK" for word in words):
            self._went(words, here, sure=corner is None and not machine and not before)
        self._block(after, line)

    def _measured(self, hows: dict[str, str], words: list[str]) -> tuple[list[str], list[str]]:
        """What stands before and behind a block whose axes or centre are IC or AC: G90, G91, G90.1, G91.1."""
        if not hows:
            return [], []
        named = {word[0] for word in words}
        axes, centre = named & set("XYZABC"), named & set("IJK")
        turned = {hows.get(letter) for letter in axes} - {None}
        if set(hows) - axes - centre:
            raise UnreadError("IC or AC of what is no axis")
        before, after = list[str](), list[str]()
        said = [word for word in words if word in ("G90", "G91")]
        plain = "IC" if (said[-1] == "G91" if said else not self._absolute) else "AC"
        steps = {letter for letter in axes if hows.get(letter, plain) == "IC"}
        if turned:
            turned = {"IC"} if steps == axes else {"AC"}
        if turned == {"AC"}:
            words[:] = [self._place_of(word) if word[0] in steps else word for word in words]
        if turned:
            modal = [word for word in words if word in ("G90", "G91")] or ["G90" if self._absolute else "G91"]
            words[:] = [word for word in words if word not in ("G90", "G91")]
            before, after = ["G91" if turned == {"IC"} else "G90"], modal
        if centre & set(hows):
            if {hows.get(letter) for letter in centre} != {"AC"}:
                raise UnreadError("a centre half absolute")
            before, after = [*before, "G90.1"], [*after, "G91.1"]
        return before, after

    def _place_of(self, step: str) -> str:
        """The place that a step of one axis leads to, in a block whose others name places."""
        letter = step[0]
        if letter in "ABC":
            at = self._stand.turn(letter)
        else:
            at = float(self._stand.named(self._stand.at)["XYZ".index(letter)]) / self._scale
        if math.isnan(at):
            raise UnreadError("IC from where the axis isn't known to be")
        return f"{letter}{at + float(step[1:]):.9f}"

    def _tool(self, name: str) -> list[str]:
        """A tool by its name: a number, or the only one of the file, which the set-up describes."""
        if (number := name if name.isdigit() else self.numbers.get(name.strip().casefold())) is not None:
            return [f"T{number}"]
        if not self._lone:
            raise UnreadError("several tools by their names")
        return []

    def _said(self, word: str) -> list[str]:
        known = {"TRAORI": ["M128"], "TRAFOOF": ["M129"], "RET": ["M30"], "SUPA": []}
        if word in known:
            return known[word]
        if word not in _QUIET:
            raise UnreadError(f"{word}, a word of Siemens'")
        return []

    def _code(self, code: str) -> list[str]:
        if code in _UNITS:
            return [_UNITS[code]]
        if code == "500" and not self._tell.n:  # no offset yet; behind motions it leaves the part's frame
            return []
        if code in _QUIET_G or code in ("53", "153"):
            return []
        if code in POLES:
            return [f"G{code}"]
        if code not in _PLAIN_G:
            raise UnreadError(f"G{code} of Siemens'")
        return [f"G{code}"]

    @staticmethod
    def _plain(name: str, value: str) -> list[str]:
        if name == "CR":
            return [f"R{value}"]
        if name == "TURN":
            return [f"P{float(value) + 1.0:g}"]
        if name == "M" and float(value) == 17.0:
            return ["M30"]
        if name in ("S1", "M1"):
            return [name[0] + value]
        if name in "XYZABCIJKFSTDM":
            return [name + value]
        if name == "H":
            return []
        raise UnreadError(f"{name}={value}, a word of Siemens'")

    @staticmethod
    def _dwell(words: list[str]) -> list[str]:
        """G4 F: seconds; G4 S would be turns of the spindle."""
        time = [word for word in words if word[0] == "F"]
        if len(time) != 1 or set(words) != {"G4", time[0]}:
            raise UnreadError("G4 of another time than seconds")
        return ["G4", f"P{float(time[0][1:]):.6f}"]
