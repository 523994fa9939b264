"""Damage to a text, by the piece: numbers, words, lines, bytes, of the kind that breaks readers."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence

__all__ = ["HOSTILE_NUMBERS", "HOSTILE_TEXTS", "mutated"]

HOSTILE_NUMBERS = [
    b"0", b"-0", b"1", b"-1", b"1e308", b"-1e308", b"1e309", b"1e-320", b"1e400", b"nan", b"inf", b"-inf", b"1e", b"1e+",
    b".", b"-", b"+", b"--1", b"1.2.3", b"1,5", b"0x10", b"1_000", b"9" * 30, b"9" * 400, b"-" + b"9" * 25, b"4294967296",
    b"9223372036854775808", b"2147483648", b"65536", b"1e15", b"1e7", b"1e9", b"0.0000000001", b"1e-12", b"360", b"-360", b"90",
    b"180", b"1e5", b"99999", b"1000000", b"\xd9\xa1", b"\xef\xbc\x91", b"True", b"1e999999999", b"0." + b"0" * 300 + b"1",
]  # fmt: skip
HOSTILE_TEXTS = [
    b"\n", b"\r", b"\r\n", b"\0", b"\x1a", b"\x1b[2J", b"\x85", b"\xe2\x80\xa8", b"\xe2\x80\xa9", b"\xe2\x80\xae",
    b"\xef\xbb\xbf", b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xf4\x90\x80\x80", b"\x0b\x0c", b"\t", b" ", b";", b"'", b'"',
    b'"""', b"'''",
    b"\\", b"(", b")", b"[", b"]", b"{", b"}", b"[[", b"=", b",", b"/", b"$", b"$$", b"%", b"&", b"#", b":", b"..",
    b"../../x", b"/etc/x", b"C:\\x", b"%s%n", b"{0}", b"${x}", b"</script><script>alert(1)</script>",
    b"=1+1", b"X" * 300, b"X" * 3000, b"(" * 200, b"[" * 600,
    b"0," * 300, b" " * 500, b"\n" * 50,
]  # fmt: skip
_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_$][A-Za-z0-9_$-]*")


def mutated(data: bytes, rng: random.Random, others: Sequence[bytes], most: int = 6000) -> bytes:
    """One to five pieces of damage, seldom more; `others` lend lines and words. At most `most` bytes."""
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5))):
        data = rng.choice(_WAYS)(data, rng, others)[:most]
    return data


def _number(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    places = [m.span() for m in _NUMBER.finditer(data)]
    if not places:
        return data
    first, last = rng.choice(places)
    kind = rng.randrange(4)
    if kind == 0:
        new = b"%d" % rng.randint(-1000, 1000)
    elif kind == 1:
        new = b"%.4f" % rng.uniform(-500, 500)
    elif kind == 2:
        a, b = rng.choice(places)
        new = data[a:b]
    else:
        new = rng.choice(HOSTILE_NUMBERS)
    return data[:first] + new + data[last:]


def _word(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    places = [m.span() for m in _WORD.finditer(data)]
    words = _WORD.findall(rng.choice(others))
    if not places or not words:
        return data
    first, last = rng.choice(places)
    return data[:first] + rng.choice(words) + data[last:]


def _line(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    at = rng.randrange(len(lines))
    kind = rng.randrange(7)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines[at:at] = [lines[at]] * rng.choice((1, 1, 2, 40))
    elif kind == 2:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    elif kind in (3, 4):
        lines.insert(at, rng.choice(rng.choice(others).split(b"\n")))
    elif kind == 5:
        lines[at] = rng.choice(rng.choice(others).split(b"\n"))
    else:
        borrowed = rng.choice(others).split(b"\n")
        first = rng.randrange(len(borrowed))
        lines[at:at] = borrowed[first : first + rng.randint(2, 8)]
    return b"\n".join(lines)


def _insert(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] + rng.choice(HOSTILE_TEXTS) + data[at:]


def _cut(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] + data[at + rng.choice((1, 1, 2, 5, 20, 200)) :]


def _end(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    return data[: rng.randint(0, len(data))]


def _byte(data: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    if not data:
        return data
    at = rng.randrange(len(data))
    new = rng.randrange(256) if rng.random() < 0.3 else data[at] ^ (1 << rng.randrange(8))
    return data[:at] + bytes([new]) + data[at + 1 :]


_WAYS = (_number, _number, _number, _word, _word, _line, _line, _line, _insert, _cut, _byte, _end)
