"""The lexical layer of CL text: every trap of real files, with the answers written down by hand."""

from __future__ import annotations

import random
import struct

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Lexer, Statement, number_of


def statements(text: str | bytes) -> list[Statement]:
    lexer = Lexer(text.encode() if isinstance(text, str) else text)
    found = []
    while (s := lexer.next()) is not None:
        found.append(s)
    return found


def test_blanks_are_free_and_words_may_hold_them() -> None:
    a, b, c, d = statements("GOTO  /   1.0,  2.0 , -.5\nTOOL  PATH/OP 1,TOOL,T1\nEND-OF-PATH\nRAPID \n")
    assert a.word == "GOTO" and a.args == [1.0, 2.0, -0.5]
    assert b.word == "TOOL PATH" and b.text == "OP 1,TOOL,T1"
    assert c.word == "END-OF-PATH" and d.word == "RAPID"


def test_continuation_through_the_middle_of_a_number() -> None:
    (s,) = statements("GOTO/0$\n.000000,12$\n5.5,-3\n")
    assert s.args == [0.0, 125.5, -3.0] and s.line == 1


def test_continuation_of_text_keeps_the_left_blanks_and_joins_without_one() -> None:
    a, b = statements("PPRINT OPERA$\nTION  NAME $\n  : x\nFINI\n")
    assert a.word == "PPRINT" and a.text == "OPERATION  NAME   : x"
    assert b.word == "FINI" and b.line == 4


def test_creo_continuation_and_what_follows_the_dollar_is_ignored() -> None:
    a, b = statements("CYCLE / DEEP, DEPTH, 3.5, CLEAR,$ junk here\n 1.000000\nRAPID\n")
    assert a.args == ["DEEP", "DEPTH", 3.5, "CLEAR", 1.0] and b.line == 3


def test_comments_are_kept_and_creo_ones_go_on() -> None:
    a, b, c = statements("$$*CATIA0\n$$-> CSYS / 1,0,  $\n   0, 1\nGOTO/1,2,3 $$ here\n")
    assert a == Statement("$$", "*CATIA0", 1)
    assert b.word == "$$" and b.text.split("/")[1].replace(" ", "") == "1,0,0,1"
    assert c.args == [1.0, 2.0, 3.0] and c.line == 4


def test_dollars_in_quotes_are_no_comment() -> None:
    (s,) = statements("SYN/'TLAXIS','$$*TLAXIS'\n")
    assert s.text == "'TLAXIS','$$*TLAXIS'"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends(end: str) -> None:
    found = statements(end.join(["RAPID", "GOTO/1,2,3", "FINI"]))
    assert [s.word for s in found] == ["RAPID", "GOTO", "FINI"] and [s.line for s in found] == [1, 2, 3]


def test_a_stray_line_feed_in_a_crlf_file() -> None:
    assert [s.line for s in statements(b"RAPID\r\nGOTO/1,\nFINI\r\n")] == [1, 2, 3]


def test_utf8_and_latin1() -> None:
    assert statements("PPRINT fräsen\n".encode())[0].text == "fräsen"
    assert statements("PPRINT fräsen\n".encode("latin-1"))[0].text == "fräsen"
    assert statements(b"\xef\xbb\xbfRAPID\n")[0].word == "RAPID"


def test_numbers() -> None:
    assert number_of("6.") == 6.0 and number_of(".9625") == 0.9625 and number_of("- 1.5") == -1.5
    assert number_of("1D-2") == 0.01 and number_of("1e3") == 1000.0
    for no in ("1STPECK", "NAN", "", "1.2.3", "--1", "0x10", "1_0", "٣"):
        assert number_of(no) is None, no


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "empty"),
        (b"\n \r\n", "empty"),
        (b"GOTO/1,2\x00\x01\x02", "binary"),
        (b"\xff\xfeG\x00O\x00", "UTF-16"),
        (b"GOTO/1,2,$\n", "middle of a statement"),
        (b"A" * 100_000_000, "65536 bytes"),
    ],
)
def test_no_text(data: bytes, what: str) -> None:
    with pytest.raises(ToolpathError, match=what):
        statements(data)


def _bits(value: float) -> bytes:
    return struct.pack("<d", value)


def test_the_fast_path_reads_numbers_bit_for_bit_as_float_does() -> None:
    rng = random.Random(7)
    tokens = ["-0.0000000", "0", "+1.5", ".5", "6.", "-.25", "9007199254740992", "0.1", "123456789.123456"]
    tokens += [f"{rng.uniform(-1, 1) * 10 ** rng.randint(-6, 6):.{rng.randint(0, 12)}f}" for _ in range(20_000)]
    tokens = [
        t for t in tokens if sum(c.isdigit() for c in t) <= 16 and float("0" + t.strip("+-").replace(".", "")) <= 2**53
    ]
    tokens = tokens[: len(tokens) // 3 * 3]
    assert len(tokens) > 12_000
    lines = ["GOTO/" + ",".join(tokens[n : n + 3]) for n in range(0, len(tokens), 3)]
    lexer = Lexer(("\n".join(lines) + "\n").encode())
    rows, rapid = lexer.gotos(False)
    assert rows is not None and len(rows.lines) == len(lines) and not rapid
    for token, value in zip(tokens, rows.values[:, :3].ravel(), strict=True):
        assert _bits(float(token)) == _bits(value), token


def _twin(text: str) -> list[tuple[int, bool, list[float]]]:
    """The same run by the general lexer alone."""
    rows, rapid = [], False
    for s in statements(text):
        if s.word == "RAPID":
            rapid = True
        elif s.word == "GOTO" and not s.words and len(s.numbers) in (3, 6):
            rows.append((s.line, rapid, s.numbers))
            rapid = False
        else:
            break
    return rows


@pytest.mark.parametrize(
    "text",
    [
        "GOTO/1,2,3\nGOTO/4,5,6,0,0,1\nRAPID\nGOTO / 7 , 8 , 9 \r\nRAPID/\r\nRAPID \n"
        "goto/1,1,1\nFEDRAT/3\nGOTO/1,2,3\n",
        "GOTO / 1, 2, 3,  $\n  0, 0, 1\nGOTO/1,$\n2,$\n3\nGOTO/1,2,3\n",
        "GOTO/1,2,3\nGOTO/1,2,P4\nGOTO/1,2,3\n",
        "GOTO/1,2,3\nGOTO/1,2\nGOTO/1,2,3\n",
    ],
)
def test_fast_and_slow_agree(text: str) -> None:
    rows, _ = Lexer(text.encode()).gotos(False)
    want = _twin(text)
    assert rows is not None
    got = [
        (int(rows.lines[n]), bool(rows.rapids[n]), rows.values[n, : rows.counts[n]].tolist())
        for n in range(len(rows.lines))
    ]
    assert got == want


@pytest.mark.parametrize(
    "line", ["GOTO/1e3,2,3", "GOTO/0$\n.5,2,3", "GOTO/nan,1,2", "GOTO/1,2,3,4", "GOTO/1,,3", "GOTOX/1,2,3"]
)
def test_the_fast_path_leaves_the_rest_alone(line: str) -> None:
    lexer = Lexer((line + "\n").encode())
    assert lexer.gotos(False)[0] is None and lexer.pos == 0 and lexer.line == 1


def test_more_digits_than_a_float_has_go_the_slow_way() -> None:
    lexer = Lexer(b"GOTO/0.12345678901234567890,1,2\n")
    assert lexer.gotos(False)[0] is None
    s = lexer.next()
    assert s is not None and s.numbers[0] == 0.12345678901234567890
    assert np.isfinite(s.numbers).all()
