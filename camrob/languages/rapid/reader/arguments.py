"""The arguments of a RAPID instruction: those by place, and the optional ones by name."""

from __future__ import annotations

from dataclasses import dataclass, field

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.tokens import Statement, Token, joined, shown

__all__ = ["Arguments", "arguments_of"]

_OPENS, _CLOSES = ("[", "(", "{"), ("]", ")", "}")


@dataclass(slots=True)
class Arguments:
    """places: expressions in their order. options: by name, an empty expression for a switch."""

    places: list[tuple[Token, ...]] = field(default_factory=list)
    options: dict[str, tuple[Token, ...]] = field(default_factory=dict)


def arguments_of(statement: Statement) -> Arguments:
    """What stands behind an instruction's word. Raises ProgramError for what is no list of arguments."""
    out = Arguments()
    for option, tokens in _split(statement.tokens[1:]):
        if not option:
            out.places.append(tokens)
            continue
        named = tokens[0].text if tokens and tokens[0].kind == "name" else ""
        plain = len(tokens) == 1 or (len(tokens) > 2 and tokens[1].text == ":=")
        if not named or not plain or named in out.options:
            raise ProgramError(
                f"{shown(joined(statement.tokens))} is no instruction",
                hint="write WORD and its arguments, a semicolon behind them",
                line=statement.line,
            )
        out.options[named] = tokens[2:]
    return out


def _split(tokens: tuple[Token, ...]) -> list[tuple[bool, tuple[Token, ...]]]:
    """The arguments, and whether each is an optional one: commas and backslashes outside of brackets divide them."""
    out: list[tuple[bool, tuple[Token, ...]]] = []
    held: list[Token] = []
    option, depth, due = False, 0, False
    for token in tokens:
        sign = token.text if token.kind == "sign" else ""
        depth += (sign in _OPENS) - (sign in _CLOSES)
        if depth == 0 and sign in (",", "\\"):
            if held or (due and not option):
                out.append((option, tuple(held)))
            held, option, due = [], sign == "\\", sign == ","
            continue
        held.append(token)
    if held:
        out.append((option, tuple(held)))
    return [(o, t) for o, t in out if t]
