"""Words of a block that move nothing, or that a control writes in its own way, as plain words."""

from __future__ import annotations

import re

from camrob.witness.cl.circles import Wanted

__all__ = ["ASIDE", "COMPUTED", "SKIPPED", "astray", "corner_of", "plain_words", "shown"]

Pairs = list[tuple[str, str]]

COMPUTED = "loops, branches, subprograms and variables"  # what stands in a gap of such blocks
ASIDE = "G101: not known"  # what stands in the gap of a mirror that is none of Haas's about the work zero
SKIPPED = frozenset(
    "9 15 17.1 28.1 30.1 40 41 42 43.1 50 50.1 61 61.1 61.2 61.3 64 69 80 92.1 92.2 97 22 23 25 26 62 103 187 255".split()
)  # G codes by which nothing moves, or which end what hides motions
_SLOWING = re.compile(r"(G61\.1),K\d+\.?\d*")  # Mazak, at corners, per cent
_CORNER = re.compile(r",([RC])(\d+\.?\d*|\.\d+)")
_LOOK_AHEAD = {"5": "P", "5.1": "Q", "8": "P"}  # Fanuc's: how fast the path is run; X0 Y0 Z0 names the axes
_HAAS = {"101": "51.1", "100": "50.1"}  # mirrored at the work zero
_UNITS = {"70": "20", "71": "21"}  # Mach3, Fagor; with words of their own they are cycles elsewhere
_TAKE_NONE = frozenset(
    "0 1 2 3 17 18 19 20 21 43 44 49 54 55 56 57 58 59 90 91 94 95 98 99".split()
)  # of R, Q, I, J, K
_HOLES = frozenset("73 74 76 81 82 83 84 85 86 87 88 89".split())
_ANALOG = {67.0, 68.0}  # LinuxCNC: M67 E0 Q40, an output's number and its value


def shown(block: str) -> bool:
    """Whether a block is a message to the operator: MSG (Siemens), M117 and M118 with a text (Marlin, RepRapFirmware)."""
    found = re.fullmatch(r"(?:N\d+)?(?:MSG|M11[78](?![\d.])(.*))", block)
    return found is not None and (found[1] is None or not re.fullmatch(r"(?:[A-Z][-+]?(?:\d+\.?\d*|\.\d+))*", found[1]))


def astray(pairs: Pairs, motion: str, vectors: bool, numbered: bool) -> str:
    """What a block says that another control moves, jumps or limits the spindle by, and none of its codes takes; "" if nothing.

    motion: the G code in force before the block. vectors: I, J, K may be the tool's axis (G43.5). numbered: the file begins with
    % and a number, as NUM's do.
    """
    letters = [letter for letter, _ in pairs]
    if ("N" in letters and set(letters[: letters.index("N")]) - {"O", "N"}) or letters.count("N") > 1:
        return "N behind other words, which may be a jump or a repeat"
    codes, named = {f"{float(value):g}" for letter, value in pairs if letter == "G"}, set(letters)
    motion = next((code for code in codes if code in {*_HOLES, "0", "1", "2", "3"}), motion)
    outputs = {float(value) for letter, value in pairs if letter == "M"} & _ANALOG
    if "E" in named and "187" not in codes and not outputs:
        return "E, an offset of Fadal's or an exponent"
    if "S" in named and codes & {"25", "26", "50", "92"}:
        return "S as a limit of the spindle's speed"
    if codes & {"22", "25", "26"} and named & set("XYZABCIJKUVW"):
        return "G22, G25 or G26 with axes, which fence an area"
    if numbered and codes & {"52", "59"} and named & set("XYZABC"):
        return "G52 or G59 with axes, which may be the machine's places, or a shift"
    if "49" in codes and named >= set("XYZ") and not codes & {"0", "1", "2", "3"}:
        return "G49 with X, Y, Z, which may be an inclined plane"
    if "8" in codes and "P" not in named and named & set("XYZ"):
        return "G8 with axes, which may be an arc"
    if "62" in codes and named & set("XYZ"):
        return "G62 with axes, which may be a mirror"
    if "16" in codes and "H" in named:
        return "G16 H, which may be a machine's coordinates"
    if codes == {"74"} and not named & set("XYZR"):
        return "G74 alone, which may be a search for the machine's zero"
    if motion in _HOLES and named & {"I", "J"}:
        return "I or J in a drilling cycle"
    if "M" in named or codes - _TAKE_NONE or vectors or motion in _HOLES:
        return ""
    odd = named & set("QL" if motion in ("2", "3") else "RQIJKL")
    if "P" in named and named <= {"P", "N"}:
        return "P alone, which may be a call or a repeat"
    return f"{', '.join(sorted(odd))} in a block that has no use for it" if odd else ""


def plain_words(pairs: Pairs) -> tuple[Pairs, float | None]:
    """The block's words without look-ahead modes, with G70 and G71 as units, with one T; and the tool that a second T of a change
    makes ready (Mazak's T01 T02 M6), None without.
    """
    letters = [letter for letter, _ in pairs]
    codes = {f"{float(value):g}" for letter, value in pairs if letter == "G"}
    words = dict(pairs)
    if codes & _UNITS.keys() and set(letters) <= set("GMFSTDHN"):
        pairs = [(k, _UNITS.get(f"{float(v):g}", v)) if k == "G" else (k, v) for k, v in pairs]
    if codes & _HAAS.keys() and set(letters) <= set("GXYN") and not any(float(words.get(k, "0")) for k in "XY"):
        pairs = [(k, _HAAS.get(f"{float(v):g}", v)) if k == "G" else (k, v) for k, v in pairs]
    if {float(v) for k, v in pairs if k == "M"} & _ANALOG:
        pairs = [pair for pair in pairs if pair[0] not in "EQ"]
    if "187" in codes:
        pairs = [pair for pair in pairs if pair[0] not in "EP"]
    if any(k in words and code in codes for code, k in _LOOK_AHEAD.items()) and not any(
        float(words.get(axis, "0")) for axis in "XYZABCIJK"
    ):
        gone = {code for code, k in _LOOK_AHEAD.items() if k in words}
        pairs = [p for p in pairs if p[0] in "MFST" or (p[0] == "G" and f"{float(p[1]):g}" not in gone)]
    if letters.count("T") == 2 and ("M", 6.0) in [(k, float(v)) for k, v in pairs]:
        second = len(pairs) - 1 - [k for k, _ in reversed(pairs)].index("T")
        return [*pairs[:second], *pairs[second + 1 :]], float(pairs[second][1])
    return pairs, None


def corner_of(block: str, scale: float) -> tuple[str, Wanted | None]:
    """A block without Fanuc's ,R or ,C (a chamfer's sides), and what they ask for. scale: metres in one of its units."""
    block = _SLOWING.sub(r"\1", block)
    found = _CORNER.search(block)
    if not found or not float(found[2]):
        return _CORNER.sub("", block, count=1), None
    size = float(found[2]) * scale
    want = Wanted(radius=size) if found[1] == "R" else Wanted(side=size)
    return block[: found.start()] + block[found.end() :], want
