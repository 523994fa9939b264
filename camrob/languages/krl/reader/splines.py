"""Motions of the spline kind, their WITH, blocks of them, and the initialisation that a program on its path passes over."""

from __future__ import annotations

from camrob.errors import KrlError
from camrob.languages.krl.reader.machine import KrlMachine
from camrob.languages.krl.reader.module import Block, Module
from camrob.languages.krl.reader.tokens import Token, tokens_of
from camrob.languages.krl.reader.with_words import take_with, with_words

__all__ = ["SPLINES", "begin_block", "only_begins", "spline_motion"]

SPLINES = {"SPTP": "PTP", "SLIN": "LIN", "SCIRC": "CIRC", "SPL": "LIN", "SPTP_REL": "PTP_REL", "SLIN_REL": "LIN_REL"}
"""Motions of the spline kind: to the same points on the same ways; SPL, a curve through its points, as their chords."""
_BLENDS = ("C_SPL", "C_DIS", "C_VEL", "C_ORI", "C_PTP")


def spline_motion(machine: KrlMachine, tokens: tuple[Token, ...], file: int, line: int) -> None:
    """A motion of the spline kind, as its plain twin; WITH may set its own speed. Raises KrlError, without a place."""
    word = tokens[0].text
    if word == "SPL":
        text = "SPL is taken for a straight line: the curve between its points is not known"
        machine.find("spline-as-line", text, line)
    at = next((k for k, token in enumerate(tokens) if token.text == "WITH"), 0)
    with with_words(machine):
        if at:
            end = next((k for k in range(at, len(tokens)) if tokens[k].text in _BLENDS), len(tokens) - 1)
            take_with(machine, (*tokens[at + 1 : end], tokens[-1]), line)
            tokens = (*tokens[:at], *tokens[end:])
        machine.motion(tokens, file, line, plain=SPLINES[word])


def begin_block(machine: KrlMachine, module: Module, block: Block, tokens: tuple[Token, ...]) -> None:
    """`SPLINE` or `SPLINE WITH ...`: what its motions have in force. Raises KrlError for more of it."""
    if module.statements.get(block.end, "").upper() != "ENDSPLINE":
        raise KrlError("a rounding behind ENDSPLINE is not read here", hint="end the block exactly")
    if tokens[1].kind == "end":
        return
    if tokens[1].text != "WITH":
        raise KrlError(f"SPLINE {tokens[1].text} is not read here", hint="open the block by SPLINE alone")
    take_with(machine, tokens[2:], block.start + 1)


def only_begins(module: Module, block: Block, tokens: tuple[Token, ...]) -> bool:
    """Whether a block is `IF NOT $ON_PATH THEN` round BAS(#INITMOV,0) and the usual interrupt: run where a program begins."""
    if [t.text for t in tokens[:3]] != ["IF", "NOT", "$ON_PATH"] or block.middle >= 0:
        return False
    inside = [module.statements[k] for k in range(block.start + 1, block.end) if module.statements.get(k)]
    usual = {
        tuple(tokens_of(text))
        for text in (
            "BAS (#INITMOV,0)",
            "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
            "INTERRUPT ON 3",
        )
    }
    scan = module.scan
    plain = [lines.searchsorted([block.start, block.end]) for lines in (scan.lin_line, scan.speed_line)]
    return all(a == b for a, b in plain) and all(tuple(tokens_of(text)) in usual for text in inside)
