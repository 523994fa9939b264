"""Blocks whose words are computed: each letter with a number, a variable, a function or an expression in brackets."""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.language.formulas import NOTHING, Reader
from camrob.toolpath.gcode.lexer import POLAR_WORDS, Word

__all__ = ["words_of"]


def words_of(reader: Reader, *, stops: str = "") -> list[Word]:
    """The words from where the reader stands to the end, or to one of the characters `stops`.

    A variable without a value takes its letter along (Fanuc's rule). Raises ToolpathError for what is no word.
    """
    found: list[Word] = []
    while reader.rest and reader.rest[0] not in stops:
        letter = reader.rest[0]
        if not ("A" <= letter <= "Z"):
            if letter in "@^":
                raise ToolpathError(POLAR_WORDS, hint="write the points out in X and Y")
            raise ToolpathError(f"{reader.rest[:16]!r} is not a G-code word", hint="every word is a letter and a value")
        reader.at += 1
        before = reader.at
        negative = False
        while reader.rest[:1] in ("+", "-") and reader.rest:
            negative ^= reader.rest[0] == "-"
            reader.at += 1
        value = reader.operand()
        if value is NOTHING:
            raise ToolpathError(
                f"no value follows {letter} in {reader.text[before - 1 :][:16]!r}", hint="check the block"
            )
        written = reader.text[before : reader.at]
        if "ROUND[" in written and letter not in "GMNT":
            raise ToolpathError(
                f"ROUND in the word {letter}: what it rounds to is the control's least increment",
                hint="round in an assignment, or write the value without ROUND",
            )
        if value is not None:
            plain = written.lstrip("+-")
            is_whole = plain.isdigit() or (letter == "P" and "." not in plain and value == int(value))
            found.append((letter, -value if negative else value, is_whole))
    return found
