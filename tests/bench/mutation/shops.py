"""A shop's customs in KRL: cells that have them, and their programs in the plain words that the bench's reader knows."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from mutation.krl import UnreadableError

__all__ = ["LINES", "SHOPS", "plain"]

_HOME = "A1 0.0000,A2 -90.0000,A3 90.0000,A4 0.0000,A5 90.0000,A6 0.0000,E1 0.0000,E2 0.0000"
_FRAME = re.compile(r"(BASE|TOOL)_DATA\[([0-9]+)\] = (\{[^{}]*\})")
_BEGIN = ["CONTINUE", "IF NOT $ON_PATH THEN"]

SHOPS = {
    "splines": (
        'generation = "KRC4"\nmotions = "SLIN"\nnumbering = "tables"\ntool_number = 5\nbase_number = 7\non_path = true\n'
        'folds = false\nhome_point = { name = "XHOME", axes = [0, -90, 90, 0, 90, 0, 0, 0] }\n'
    ),
    "by-speed": 'blending = "C_VEL"\napo_cvel_percent = 70\nnumbering = "act"\ntool_number = 5\nbase_number = 7\n',
    "by-turn": 'blending = "C_ORI"\napo_cori_deg = 1.5\ntool_number = 5\nbase_number = 7\n',
}
"""What stands in `[controller]` of each beside the rest."""
LINES = {
    "splines": ("$ACT_TOOL = 5", "$ACT_BASE = 7"),
    "by-speed": ("$ACT_TOOL = 5", "$ACT_BASE = 7", "$APO.CVEL = 70.000"),
    "by-turn": ("BAS (#TOOL,5 )", "BAS (#BASE,7 )", "$APO.CORI = 1.500"),
}
"""What each adds to the opening."""


def plain(files: Mapping[str, bytes], shop: str) -> Mapping[str, bytes]:
    """The files in plain words. Raises UnreadableError for what is not the shop's."""
    if not shop:
        return files
    rewrite = {"splines": _splines, "by-speed": _other("C_VEL"), "by-turn": _other("C_ORI")}[shop]
    sources = {name: text for name, text in files.items() if name.endswith(".src")}
    return {**files, **{name: rewrite(text.decode("ascii")).encode("ascii") for name, text in sources.items()}}


def _other(word: str) -> Callable[[str], str]:
    def rewrite(text: str) -> str:
        if "C_DIS" in text.replace("$APO.CDIS", ""):
            raise UnreadableError("rounded off in another way than the shop's")
        return text.replace(f"}} {word}\r\n", "} C_DIS\r\n")

    return rewrite


def _splines(text: str) -> str:
    """Spline words, HOME by name, rows of the tables, the initialisation in its IF."""
    if re.search(r"^(?:LIN|CIRC)\b|C_DIS|FOLD", text, re.MULTILINE):
        raise UnreadableError("a word that is not the shop's")
    lines = text.split("\r\n")
    if _BEGIN[0] in lines:
        at = lines.index(_BEGIN[0])
        if lines[at : at + 4] != [*_BEGIN, "BAS (#INITMOV,0 )", "ENDIF"]:
            raise UnreadableError("the initialisation is not the shop's")
        lines[at : at + 4] = ["BAS (#INITMOV,0 )"]
    out: list[str] = []
    rows: dict[str, str] = {}
    for line in lines:
        found = _FRAME.fullmatch(line)
        if found is not None:
            rows[f"{found[1]}_DATA[{found[2]}]"] = found[3]
            continue
        if line.startswith(("$BASE", "$TOOL")):
            named = next((row for row in rows if row in line), None)
            if named is None or named not in (f"{line[1:5]}_DATA[{7 if line[1] == 'B' else 5}]"):
                raise UnreadableError(f"{line!r} names no row that was written")
            line = line.replace(named, rows[named])
        line = line.replace("PTP XHOME", f"PTP {{E6AXIS: {_HOME}}}")
        out.append(re.sub(r"^S(LIN|CIRC)", r"\1", line).replace("} C_SPL", "} C_DIS"))
    return "\r\n".join(out)
