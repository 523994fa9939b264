"""Statements of KRL to tokens."""

from __future__ import annotations

import re
import string
from dataclasses import dataclass
from functools import lru_cache

from camrob.errors import KrlError

__all__ = ["Token", "TokenKind", "canonical", "handed", "mark_of", "shown", "statement_of", "tokens_of"]

TokenKind = str
"""`number`, `string`, `bits`, `name` (upper case), `enum` (with its #), `sign` (an operator or a bracket), `end`."""

_TOKEN = re.compile(
    r"""\s*(?:
      (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    | (?P<string>"[^"]*")
    | (?P<bits>'(?:[hH][0-9A-Fa-f]{1,8}|[bB][01]{1,32})')
    | (?P<name>[$A-Za-z_][$A-Za-z0-9_]*)
    | (?P<enum>\#[A-Za-z0-9_$]+)
    | (?P<sign><=|>=|==|<>|[-+*/:=<>(){}\[\],.?])
    )""",
    re.VERBOSE | re.ASCII,  # a no-break space is no blank
)
_CODE = re.compile(r"""(?:[^;"]|"[^"]*"|")*""")
_LONGEST_STATEMENT = 100_000  # characters: a thousand times a controller's own limit


@dataclass(frozen=True, slots=True)
class Token:
    """A token: its kind, and its text (names and enumeration values in upper case)."""

    kind: TokenKind
    text: str


def shown(text: str, longest: int = 60) -> str:
    """Text of a file, fit to stand in a message."""
    plain = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return plain if len(plain) <= longest else plain[: longest - 3] + "..."


def statement_of(line: str) -> str:
    """The line without its comment and the blanks around it."""
    found = _CODE.match(line)
    return (line if found is None else found[0]).strip(string.whitespace)


@lru_cache(maxsize=1024)
def tokens_of(statement: str) -> tuple[Token, ...]:
    """Tokens of a statement, an `end` behind them. Raises KrlError (without a place) for what is no KRL."""
    if len(statement) > _LONGEST_STATEMENT:
        raise KrlError(f"a statement of {len(statement)} characters", hint="this is not a KRL program")
    tokens: list[Token] = []
    at = 0
    while at < len(statement):
        found = _TOKEN.match(statement, at)
        if found is None:
            raise KrlError(
                f"{shown(statement[at:], 20)!r} is not KRL", hint="see the statement " + repr(shown(statement))
            )
        kind = found.lastgroup or "sign"
        text = found[kind]
        tokens.append(Token(kind, text.upper() if kind in ("name", "enum", "bits") else text))
        at = found.end()
    tokens.append(Token("end", ""))
    return tuple(tokens)


def canonical(statement: str) -> str:
    """A statement, written in the one way in which all that mean the same are written. Raises KrlError as `tokens_of`."""
    parts = (repr(float(t.text)) if t.kind == "number" else t.text for t in tokens_of(statement)[:-1])
    return " ".join(parts)


def mark_of(text: str) -> str:
    """The name of the mark that a statement is, in capitals; empty for any other."""
    name, colon, rest = text.upper().partition(":")
    return name.strip() if colon and not rest.strip() else ""


def handed(tokens: tuple[Token, ...], at: int) -> list[tuple[Token, ...]]:
    """A call's arguments, each with an `end` behind it; `at`: the opening bracket."""
    parts, depth = [list[Token]()], 0
    for token in tokens[at + 1 : -1]:
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(token.text, 0) if token.kind == "sign" else 0
        if depth < 0:
            break
        if token.text == "," and depth == 0:
            parts.append([])
        else:
            parts[-1].append(token)
    return [(*part, Token("end", "")) for part in parts]
