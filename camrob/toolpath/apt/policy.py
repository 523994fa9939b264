"""Words without a handler: which of them may be skipped, which would make a wrong part if they were."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Statement, number_of
from camrob.toolpath.apt.word_checks import source_refusal

__all__ = ["IGNORED", "Strangers", "is_off"]

IGNORED = frozenset(
    "PAINT SEQNO PPFUN MOVE_ATTRIB BOX SWITCH REWIND SELECT INTOL OUTTOL TOLER MAXDPM AUTOPS WPLANE "
    "REMARK LETTER OPFEATEND CLEARP AUTOPOS TOOLPATH_TYPE TOOLPATH NOPOST PRINT CLRSRF "
    "DISPLY PLABEL LPRINT OVPLOT TLSPEC CHECK LINTOL MCHTOL LEADER TITLES IDENT PARTID".split()
)
_SOURCE_WORDS = re.compile(
    r"(TLLFT|TLRGT|GOLFT|GORGT|GOBACK|GOUP|GODOWN|GO|GOFWD|GOFWDA|MACRO|TERMAC|CALL|LOOPST|LOOPND|JUMPTO|DO|REFSYS|PSIS|IF *\(.*|"
    r"PARTSURF|CLPRNT|CUT|DNTCUT|POCKET|GOFWD.*|TL(LFT|RGT|ON),.*)"
)
# words that move the tool, or the frame of all points behind them; some of them may say that they change nothing
_MOVING = {
    "TRANS": "shifts the points behind it",
    "ORIGIN": "shifts the points behind it",
    "ROTATE": "turns the machine or the points behind it",
    "ROTHED": "turns the head",
    "ROTABL": "turns the table",
    "MATRIX": "transforms the points behind it",
    "MIRROR": "mirrors the points behind it",
    "SCALE": "scales the points behind it",
    "MODIFY": "exchanges axes or signs of the points behind it",
    "REPEAT": "repeats what stands behind it",
    "CALLSUB": "calls a subprogram",
    "SUBPRG": "calls a subprogram",
    "THREAD": "cuts a thread",
    "PREFUN": "writes a G code of the machine's",
    "PROBE": "measures with a probe on the way of the points behind it",
    "INSPEC": "measures with a probe on the way of the points behind it",
    "INCR": "makes steps of the points behind it",
    "INCREMENTAL": "makes steps of the points behind it",
    "TURN": "turns the part against the tool",
    "COUPLE": "couples the feed to the spindle",
    "OPSKIP": "lets the machine's operator leave out what stands behind it",
    "PITCH": "cuts a thread",
    "OP": "is an operation of a lathe's",
    "PLUNGE": "takes the tool back down to where it was",
    "ZERO": "shifts the points behind it",
    "RESET": "takes back what nobody here knows",
}
# of some of them, why it can't be known, and what to do instead
_OPEN = {
    "MIRROR": (
        "no standard of CL data has the word, and posts differ in the plane, the centre and what else they mirror",
        "mirror the operations in the CAM system, or write the matrix: TRACUT/-1,0,0,0, 0,1,0,0, 0,0,1,0 mirrors X",
    ),
    "ROTATE": (
        "posts differ in whether it turns a table, a head or the points, and in whether the points behind it are printed turned",
        "output the points in the part's frame with i, j, k and without it; of points, TRACUT or COPY/n,XYROT says it",
    ),
}
_MODES = frozenset(("SET", "MODE"))
_MAY_BE_ZERO = frozenset(("ORIGIN", "ROTATE", "ROTHED", "ROTABL"))
# G codes that say again what holds anyway: the plane of X and Y, no compensation, modes of the path, absolute, feed by the minute
_HARMLESS_PREFUN = frozenset((17, 40, 49, 61, 64, 80, 90, 94))
_MOST_STRANGERS = 50  # kinds of unknown words that are listed by name


def is_off(s: Statement) -> bool:
    """Whether a statement ends what its word has begun."""
    return bool({"NOMORE", "OFF"} & set(s.words))


class Strangers:
    """Counts the words that are skipped, for one finding each; `seen` is name: (count, first line)."""

    def __init__(self) -> None:
        self.seen: dict[str, tuple[int, int]] = {}

    def take(self, s: Statement) -> None:
        """A word without a handler. Raises ToolpathError where it may move something; counts it otherwise."""
        if not s.word and not s.slash:
            return
        if not s.word:
            hint = "delete the line, or the slash in front of it"
            raise ToolpathError("a statement behind a slash, which may be left out", hint=hint, line=s.line)
        if "=" in s.word or _SOURCE_WORDS.fullmatch(s.word):
            raise source_refusal(s.line)
        if s.word in _MOVING:
            self._moving(s)
            return
        if s.word in _MODES and (mode := next((w for w in s.words if w in _MOVING), "")):
            self._moving(Statement(mode, s.text, s.line))
            return
        numbers = s.numbers if s.slash else [v for t in s.word.split(",") if (v := number_of(t.strip())) is not None]
        if len(numbers) >= 3 or s.word.startswith("GO"):
            raise ToolpathError(
                f"{s.word[:40]} is not known and its {'numbers' if numbers else 'name'} may mean motion",
                hint="output it as GOTO from the CAM system, or delete the line where it means nothing",
                line=s.line,
            )
        name = s.word[:40]
        if len(self.seen) >= _MOST_STRANGERS and name not in self.seen:
            name = "(other words)"
        count, line = self.seen.get(name, (0, s.line))
        self.seen[name] = count + 1, line

    @staticmethod
    def _moving(s: Statement) -> None:
        """A word that would move something: let pass where it says that it does not."""
        if is_off(s) or (s.word in _MAY_BE_ZERO and s.numbers and not any(s.numbers)):
            return
        if s.word == "PREFUN" and s.numbers and s.numbers[0] in _HARMLESS_PREFUN:
            return
        usual = "that may mean motion elsewhere", "output the points as they are to be cut from the CAM system"
        why, hint = _OPEN.get(s.word, usual)
        raise ToolpathError(f"{s.word} {_MOVING[s.word]}: {why}, and is not done", hint=hint, line=s.line)
