"""Okuma's OSP, as far as its words are ISO's: G15 H a datum, G56 H the tool's length along Z till G53 (manual of the OSP-P300M).

G81 to G86, G73 and G74 without a dwell return to R by M54, to the level of G71 by M53. What else OSP has for itself
is a gap: other cycles, M52, lengths along other axes by G54 to G59, a frame by G11, variables, calls.
"""

from __future__ import annotations

import re

from camrob.witness.cl.gcode import GcodeReader

__all__ = ["OSP", "OspReader"]

OSP = re.compile(
    r"\A\s*\$[\w.-]+\.(?:MIN|SSB|SUB|LIB|SDF)%?\s*$|^[ \t]*(?:N\d+[ \t]*)?G0*15[ \t]*H[ \t]*\d", re.I | re.M
)
"""What only its programs hold."""

_CODE = re.compile(r"([GM])0*(\d+\.?\d*)")
_KEPT = frozenset("0 1 2 3 9 17 18 19 20 21 30 40 41 42 61 64 80 90 91 94 95 99".split())
_HOLES = {"82": "81"} | {code: code for code in "81 83 73 74 84 85 86".split()}
_WORD = re.compile(r"([A-Z])([-+]?(?:\d+\.?\d*|\.\d+))")
_NOT_KEPT = frozenset("13 14 97 98 99".split())  # M codes that are a spindle or a call elsewhere


class OspReader(GcodeReader):
    """Reads a program of OSP block by block, in ISO's words."""

    _level = ""  # of G71
    _hole: dict[str, str] | None = None  # Z, R, Q, F of the cycle in force
    _drilled, _risen, _stepping = "", False, False

    def read(self, text: str) -> None:
        """Without the line that names the program."""
        super().read(re.sub(r"\A\s*\$[\w.-]+%?[^\n]*", "", text))

    def _read(self, block: str, line: int) -> None:
        said = _WORD.findall(re.sub(r"^/?(?:N\d+)?", "", block))
        codes = {kind + f"{float(number):g}" for kind, number in said if kind in "GM"}
        values = {kind: number for kind, number in said if kind not in "GMN"}
        self._stepping = (self._stepping or "G91" in codes) and "G90" not in codes
        if codes & {"G0", "G1", "G2", "G3", "G80"}:
            self._hole = None
        if codes == {"G71"} and values.keys() == {"Z"} and not self._stepping:
            self._level = values["Z"]
            return
        cycle = next((code[1:] for code in sorted(codes) if code[1:] in _HOLES and code[0] == "G"), "")
        if cycle or (self._hole is not None and values.keys() & set("XYZRQF")):
            self._bore(cycle, block, codes, values, line)
            return
        self._as_iso(block, line)

    def _bore(self, cycle: str, block: str, codes: set[str], values: dict[str, str], line: int) -> None:
        """One hole: the cycle up to R, and from there to G71's level."""
        if cycle:
            self._hole, self._drilled, self._risen = {}, _HOLES[cycle], "M53" in codes
            known = ("M53" in codes and self._level) or "M54" in codes
            below = self._risen and self._level and "R" in values and float(self._level) < float(values["R"])
            height = self._stand.at["Z"]
            low = (
                self._risen and self._level and height is not None and height < float(self._level) * self._scale - 1e-9
            )
            if not known or below or low:
                self._hole = None
        if self._hole is None or self._stepping or values.keys() - set("XYZRQF"):
            self._hole = None
            self._gap(line, f"{block[:30]}: OSP's own")
            return
        self._hole |= {key: value for key, value in values.items() if key not in "XY"}
        place = {key: value for key, value in values.items() if key in "XY"}
        rest = "".join(sorted(codes - {f"G{cycle}", "M53", "M54"}))
        text = "".join(key + value for key, value in (self._hole | place).items())
        self._as_iso(f"G99{rest}", line)
        super()._read(f"G{self._drilled}{text}", line)
        if self._risen:
            super()._read(f"G0Z{self._level}", line)

    def _as_iso(self, block: str, line: int) -> None:
        words = [(kind, number) for kind, number in _CODE.findall(block)]
        g = [number for kind, number in words if kind == "G"]
        kept = [number for number in g if number in _KEPT or number in ("15", "53", "56")]
        odd = kept != g or any(kind == "M" and number in _NOT_KEPT for kind, number in words)
        named = re.search(r"H0*([1-9]\d*)", block)
        ends = "53" in g and re.search(r"[XYZABC][-+.\d]", block)
        lacks = ("15" in g and not named) or ("56" in g and not (named or "HA" in block)) or {"15", "56"} <= set(g)
        if odd or ends or lacks:
            self._gap(line, f"{block[:30]}: OSP's own")
            return
        if "56" in g:
            block = re.sub(r"G0*56(?!\d)", "G43", block.replace("HA", ""))
        super()._read(re.sub(r"G0*53(?!\d)", "G49", block), line)
