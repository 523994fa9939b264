"""Programs that a program calls and that are files of their own in its folder: their text, to be read behind it.

Fanuc and alike call by a number (M98 P, G65 P), which a control finds by the O word and people keep as the file's name.
LinuxCNC's o<name> call runs name.ngc. Siemens' blocks that hold a name alone run NAME.SPF.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.witness.cl.source import COMMENT, read_text

__all__ = ["text_beside"]

_MOST = 100  # files
_NUMBERED = re.compile(r"(?:M\s*0*98|G\s*0*65)(?![\d.])[^P\n]*P\s*(\d+)(?![\d.])")
_LABELLED = re.compile(r"^\s*O\s*(<[^>\n]*>|\d+)\s*CALL\b", re.M)
_DEFINED = re.compile(r"^\s*O\s*(<[^>\n]*>|\d+)\s*SUB\b", re.M)
_OWN = re.compile(r"^\s*[O:]\s*0*(\d+)", re.M)
_ALONE = re.compile(r"^\s*(?:/\d?\s*)?(?:N\d+\s*)?([A-Z_][A-Z_]\w*|L\d+)\s*(?:\(\s*\))?(?:\s*P\s*=?\s*\d+)?\s*$", re.M)
_HEADS = re.compile(r"^\s*%_N_(\w+)_(?:MPF|SPF)", re.M)
_O_WORDS = re.compile(
    r"^[ \t]*O\s*(?:<[^>\n]*>|\d+)\s*SUB\b.*?^[ \t]*O\s*(?:<[^>\n]*>|\d+)\s*ENDSUB\b[^\n]*\n", re.M | re.S | re.I
)
_SHORT = 10_000  # M98 P51002: five times O1002
_ENDINGS = ("", ".nc", ".cnc", ".eia", ".tap", ".txt", ".ncp", ".prg", ".sub")


def text_beside(text: str, file: Path, *, siemens: bool) -> str:
    """What has to be read behind a program's text: each program that it calls and that one file in its folder holds."""
    behind, looked = "", set[str]()
    while len(looked) < _MOST:
        bare = re.sub(r";[^\n]*" if siemens else COMMENT, "", text + behind).upper()
        wanted = next((name for name in (_sections(bare) if siemens else _numbers(bare)) if name not in looked), None)
        if wanted is None:
            break
        looked.add(wanted)
        behind += _found(wanted, file, siemens=siemens)
    return behind


def _numbers(bare: str) -> Iterator[str]:
    own = {int(n) for n in _OWN.findall(bare)}
    for number in map(int, _NUMBERED.findall(bare)):
        if number not in own and number % _SHORT not in own:
            yield str(number % _SHORT)
    defined = set(_DEFINED.findall(bare))
    yield from (label for label in _LABELLED.findall(bare) if label not in defined)


def _sections(bare: str) -> Iterator[str]:
    heads = set(_HEADS.findall(bare))
    return (name for name in _ALONE.findall(bare) if name not in heads)


def _found(name: str, file: Path, *, siemens: bool) -> str:
    """The text of the one file that is the program of that name, with the line that names it; "" for none or several."""
    stem = re.escape(name.strip("<>").lower())
    ngc = re.compile(rf"{stem}\.ngc")
    if siemens:
        match = re.compile(rf"(?:{stem}|_n_{stem}_spf)\.spf")
    elif name[0] == "<":
        match = ngc
    else:
        endings = "|".join(re.escape(ending) for ending in _ENDINGS)
        match = re.compile(rf"o?0{{0,7}}{stem}(?:{endings})")
    try:
        there = [p for p in file.parent.iterdir() if p.name != file.name and match.fullmatch(p.name.lower())]
        if not (there or siemens) and name.isdigit():  # o100 call
            there = [p for p in file.parent.iterdir() if p.name != file.name and ngc.fullmatch(p.name.lower())]
        body = read_text(there[0]) if len(there) == 1 else ""
    except (OSError, ToolpathError):
        return ""
    if not body or name[0] == "<" or (not siemens and there[0].suffix.lower() == ".ngc"):
        return "".join(_O_WORDS.findall(body))
    named = (_HEADS if siemens else _OWN).findall(re.sub(COMMENT, "", body).upper() if not siemens else body.upper())
    own = named == [name]
    if named and not own:
        return ""  # other programs
    head = f"%_N_{name}_SPF\n" if siemens else f"O{name}\n"
    return body if own else head + body
