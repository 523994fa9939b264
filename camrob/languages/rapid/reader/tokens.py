"""RAPID text to tokens, and to the statements that a semicolon or a word of structure ends."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from camrob.errors import ProgramError

__all__ = ["Row", "Statement", "Token", "canonical", "joined", "shown", "statements_of", "tokens_of"]

_TOKEN = re.compile(
    r"""(?P<blank>[\s\x00]+|!.*)
      | (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|0[xX][0-9A-Fa-f]+)
      | (?P<string>"(?:[^"]|"")*")
      | (?P<name>[A-Za-z_][A-Za-z0-9_]*)
      | (?P<sign>:=|<=|>=|<>|[-+*/=<>(){}\[\],.;:\\%?|])""",
    re.VERBOSE | re.ASCII,  # a no-break space is no blank
)
_NUMBERS = r"\[([-0-9.E,]+)\]"
_ROW = re.compile(
    rf"\s*MoveL \[{_NUMBERS},{_NUMBERS},{_NUMBERS},{_NUMBERS}\],{_NUMBERS},([A-Za-z]\w*),([A-Za-z]\w*)\\WObj:=([A-Za-z]\w*);\s*",
    re.ASCII,
)
_IN_ROW = (3, 4, 4, 6, 4)  # numbers of place, quaternion, configuration, external axes, speed
_LONGEST_STATEMENT = 100_000  # tokens: beyond any array that a person or a CAM system writes
# words that stand alone, or begin a line of structure that no semicolon ends
_ALONE = frozenset(
    "ENDPROC ENDMODULE ENDFUNC ENDTRAP ENDRECORD ENDIF ENDFOR ENDWHILE ENDTEST ELSE ERROR UNDO BACKWARD".split()
)
_UNTIL = {"THEN": ("IF", "ELSEIF"), "DO": ("FOR", "WHILE")}


@dataclass(frozen=True, slots=True)
class Token:
    """A token: `number`, `string`, `name` (upper case) or `sign`, and its text."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Row:
    """A MoveL on one line, all of it plain numbers and names: how long programs are written, read at one go.

    numbers: place, quaternion, configuration and speed; external: `9E9` among them; names: zone, tool and work object.
    """

    line: int
    numbers: tuple[float, ...]
    external: tuple[float, ...]
    speed: str
    names: tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement: the line that it begins in, and its tokens without the semicolon."""

    line: int
    tokens: tuple[Token, ...]

    @property
    def word(self) -> str:
        """Its first word, "" where it begins otherwise."""
        return self.tokens[0].text if self.tokens and self.tokens[0].kind == "name" else ""


def shown(text: str, longest: int = 60) -> str:
    """Text of a file, fit to stand in a message."""
    plain = "".join(c if c.isprintable() else "?" for c in text)
    return repr(plain if len(plain) <= longest else plain[:longest] + "...")


def tokens_of(text: str, line: int = 0) -> list[Token]:
    """The tokens of one line, comments left out. Raises ProgramError for what is none."""
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ProgramError(f"{shown(text[at:])} is no RAPID", hint="is the file damaged?", line=line)
        kind = str(match.lastgroup)
        if kind != "blank":
            found.append(Token(kind, match[0].upper() if kind == "name" else match[0]))
        at = match.end()
    return found


def canonical(statement: str) -> str:
    """A statement, written in the one way in which all that mean the same are written. Raises ProgramError."""
    return joined([t for t in tokens_of(statement) if t.text != ";" or t.kind == "string"])


def joined(tokens: list[Token] | tuple[Token, ...]) -> str:
    """Tokens as `canonical` writes them."""
    return " ".join(repr(float(t.text)) if t.kind == "number" and "x" not in t.text.lower() else t.text for t in tokens)


def _row(text: str, line: int) -> Row | None:
    """The line as a row; None where it has to be read token by token."""
    match = _ROW.fullmatch(text)
    if match is None:
        return None
    groups = [match[k].split(",") for k in range(1, 6)]  # the five records
    if tuple(len(group) for group in groups) != _IN_ROW:
        return None
    try:
        place, turn, conf, external, speed = ([float(v) for v in group] for group in groups)
    except ValueError:
        return None
    numbers = (*place, *turn, *conf, *speed)
    return Row(line, numbers, tuple(external), groups[4][0], (match[6].upper(), match[7].upper(), match[8].upper()))


def statements_of(lines: list[str]) -> Iterator[Statement | Row]:
    """The statements of a module's lines, counted from 1.

    Words of structure (MODULE NAME, PROC NAME(), IF .. THEN) end a statement as a semicolon does.
    """
    held: list[Token] = []
    begun = 1
    for number, text in enumerate(lines, 1):
        row = None if held else _row(text, number)
        if row is not None:
            yield row
            continue
        for token in tokens_of(text, number):
            begun = number if not held else begun
            if token.text == ";" and token.kind == "sign":
                if held:
                    yield Statement(begun, tuple(held))
                held = []
                continue
            if held and held[0].text == "TEST" and token.text in ("CASE", "DEFAULT"):
                yield Statement(begun, tuple(held))
                held, begun = [], number
            held.append(token)
            if len(held) > _LONGEST_STATEMENT:
                raise ProgramError("a statement without an end", hint="is the file damaged?", line=begun)
            if _complete(held):
                yield Statement(begun, tuple(held))
                held = []
    if held:
        raise ProgramError(f"{shown(joined(held[:8]))} has no end", hint="is the file damaged?", line=begun)


def _complete(held: list[Token]) -> bool:
    """Whether tokens are a piece of structure that needs no semicolon."""
    first, last = held[0], held[-1]
    if first.kind != "name":
        return first.text == "(" and last.text == ")" and _level(held) == 0
    if len(held) == 1:
        return first.text in _ALONE
    if last.kind == "name" and last.text in _UNTIL:
        return first.text in _UNTIL[last.text]
    if first.text in ("CASE", "DEFAULT"):
        return last.text == ":"
    if first.text == "TEST":
        return False
    if first.text in ("MODULE", "SYSMODULE", "RECORD", "TRAP"):
        return len(held) == 2  # the word and the name; what follows in brackets is a statement without a word
    head = [t.text for t in held[:2]]
    if "PROC" in head or "FUNC" in head:
        return last.text == ")" and _level(held) == 0
    return False


def _level(tokens: list[Token]) -> int:
    return sum((t.text == "(") - (t.text == ")") for t in tokens)
