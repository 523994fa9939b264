"""Is a text KRL? A judge of form alone, by the rules of the language: it knows no reader, no writer and no meaning."""

from __future__ import annotations

import re

_N = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NAME = r"\$?[A-Za-z_]\w{0,23}"
_VARIABLE = rf"{_NAME}(?:\[\d+\])?(?:\.{_NAME}(?:\[\d+\])?)*"
_FIELDS = rf"[A-Z]\w* {_N}(?:,[A-Z]\w* {_N})*"
_AGGREGATE = rf"\{{(?:[A-Z0-9]+: )?{_FIELDS}\}}"
_LOAD = rf"\{{M {_N},CM {_AGGREGATE},J {_AGGREGATE}\}}"
_VALUE = rf"(?:{_N}|TRUE|FALSE|#\w+|{_VARIABLE}|{_AGGREGATE}|{_LOAD}|{_N} [-+*/] {_N})"
_TARGET = rf"(?:{_AGGREGATE}|{_NAME})"
_STATEMENTS = [
    rf"PTP {_TARGET}(?: C_PTP)?",
    rf"LIN {_TARGET}(?: C_(?:DIS|VEL|ORI))?",
    rf"CIRC {_TARGET},{_TARGET}(?: C_(?:DIS|VEL|ORI))?",
    rf"SLIN {_TARGET}(?: C_SPL)?",
    rf"SCIRC {_TARGET},{_TARGET}(?: C_SPL)?",
    rf"{_VARIABLE} = {_VALUE}",
    rf"\$BASE = EK\({_VARIABLE}, {_VARIABLE}, (?:{_AGGREGATE}|{_VARIABLE})\)",
    rf"BAS \(#\w+,{_N} \)",
    r"GLOBAL INTERRUPT DECL \d+ WHEN \$\w+==TRUE DO \w+ \( \)",
    r"INTERRUPT ON \d+",
    rf"WAIT SEC {_N}",
    r"HALT|CONTINUE",
    rf"{_NAME} \((?: ?{_N} ?| )\)",
    r"IF NOT \$\w+ THEN|ENDIF",
]
_STATEMENT = re.compile("|".join(f"(?:{one})" for one in _STATEMENTS))
_HEADER = re.compile(r"&(?:ACCESS|REL|PARAM|COMMENT) .+")
_OPENS = re.compile(r"DEF (?P<name>[A-Za-z]\w{0,23}) \( \)")


def faults(text: str) -> list[str]:
    """What is no KRL in a .src file, by line; empty where all of it is."""
    found, lines = [], text.split("\r\n")
    body = [k for k, line in enumerate(lines) if _OPENS.fullmatch(line)]
    if len(body) != 1 or lines[-2:] != ["END", ""]:
        return ["not one DEF that is closed by the last line"]
    start = body[0]
    found += [f"{k + 1}: {line}" for k, line in enumerate(lines[:start]) if not _HEADER.fullmatch(line)]
    folds = blocks = 0
    declaring = True
    for number, line in enumerate(lines[start + 1 : -2], start=start + 2):
        code, _, comment = line.partition(";")
        code = code.rstrip()
        folds += comment.startswith("FOLD") - comment.startswith("ENDFOLD")
        blocks += code.startswith("IF ") - (code == "ENDIF")
        external = re.fullmatch(rf"EXT {_NAME} \( \)", code) is not None
        declaring &= external or not code
        if min(folds, blocks) < 0 or (external and not declaring):
            found.append(f"{number}: {line} (out of place)")
        if code and not external and _STATEMENT.fullmatch(code) is None:
            found.append(f"{number}: {line}")
    return found + ["a fold or a block is left open"] * bool(folds or blocks)
