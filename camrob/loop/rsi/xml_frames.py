"""Frames of KUKA's RSI over UDP: a strict reader of what the controller sends, a writer of what it wants back.

The controller sends, every cycle, `<Rob Type="KUKA">` with `<RIst X Y Z A B C/>` (actual pose), `<RSol .../>` (set-point)
and `<IPOC>` (its clock); it wants `<Sen Type="...">` with `<RKorr X Y Z A B C/>` and the same IPOC, character by character.
Lengths are mm, angles degrees; A, B, C turn about Z, Y', X'': R = Rz(A) Ry(B) Rx(C). In memory all of it is m and rad.

What arrives is hostile until it is read. The reader knows elements, attributes and plain text, and nothing else of XML: no
`<!` (so no document type, entity, comment or CDATA), no `&`, no processing instruction but a leading `<?xml ...?>`. There is
nothing that could expand or reach outside, and the time it takes grows with the length, which is bounded. Each refusal is an
InputError with one of a few fixed texts, so that refusals can be counted by text, and no message repeats part of a frame.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.errors import InputError
from camrob.frozen import locked
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["LONGEST_FRAME", "RobFrame", "check_sen_type", "read_rob", "write_sen"]

Array = NDArray[np.float64]

LONGEST_FRAME = 16384
"""Bytes of the longest frame that is read; RSI's 64 channels and all its built-in values stay well below."""

_MOST_ELEMENTS, _MOST_ATTRIBUTES, _DEEPEST = 256, 64, 8  # more than any frame of RSI has
_FARTHEST_MM, _WIDEST_DEG = 1e5, 720.0  # no robot's pose lies beyond
_NAME = r"[A-Za-z_][A-Za-z0-9_.\-]{0,63}"
_VALUE = "\"[^<>&\"]*\"|'[^<>&']*'"
_ATTRIBUTE = re.compile(rf"[ \t\r\n]+({_NAME})[ \t\r\n]*=[ \t\r\n]*({_VALUE})")
_TOKEN = re.compile(
    rf"<({_NAME})((?:[ \t\r\n]+{_NAME}[ \t\r\n]*=[ \t\r\n]*(?:{_VALUE}))*)[ \t\r\n]*(/?)>"
    rf"|</({_NAME})[ \t\r\n]*>"
    r"|([^<>&]+)"
)
_DECLARATION = re.compile(r"<\?xml[ \t\r\n][A-Za-z0-9=\"'._ \t\r\n\-]{0,100}\?>")
_NUMBER = re.compile(r"[+-]?(?:[0-9]{1,20}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,3})?")
_COUNTER = re.compile(r"[0-9]{1,18}")
_SEN_TYPE = re.compile(r"[A-Za-z0-9_.\-]{1,32}")
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
_HINT = "check the controller's Ethernet configuration, and what else sends to this port"


class RobFrame(NamedTuple):
    """A frame: `ipoc` as written and as a number, `ticks`; `setpoint` (RSol), `actual` (RIst, or None), (6,), m and rad."""

    ipoc: str
    ticks: int
    setpoint: Array
    actual: Array | None


def read_rob(data: bytes) -> RobFrame:
    """One frame as the controller sends it. Raises InputError, with one of a few fixed texts, for anything else."""
    if len(data) > LONGEST_FRAME:
        raise _refused("a frame is too long")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        raise _refused("a frame isn't UTF-8") from None
    if _CONTROL.search(text):
        raise _refused("a frame holds control characters")
    if "<!" in text or "&" in text:
        raise _refused("a frame holds a declaration or an entity")
    children = _children(text)
    ipoc = _only(children, "IPOC", needed=True)
    counter = "" if ipoc is None else ipoc[1].strip(" \t\r\n")
    if ipoc is None or ipoc[0] or _COUNTER.fullmatch(counter) is None:
        raise _refused("a frame's IPOC is not a counter")
    setpoint = _only(children, "RSol", needed=True)
    actual = _only(children, "RIst", needed=False)
    if setpoint is None:
        raise _refused("a frame has no RSol")
    return RobFrame(counter, int(counter), _pose(setpoint[0]), None if actual is None else _pose(actual[0]))


def write_sen(ipoc: str, correction: ArrayLike, sen_type: str = "ImFree") -> bytes:
    """The answer to a frame: `ipoc` as it came, `correction` (6,) in m and rad, as mm and degrees with six decimals.

    Raises InputError for an IPOC that is none, or a correction that isn't six finite numbers within a pose's range.
    """
    values = np.asarray(correction, dtype=float)
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError("a correction isn't six finite numbers", hint="nothing is sent in its place")
    printed = [*m_to_mm(values[:3]), *rad_to_deg(values[3:])]
    if max(abs(v) for v in printed) > _WIDEST_DEG:
        raise InputError("a correction is beyond any correction's range", hint="nothing is sent in its place")
    if _COUNTER.fullmatch(ipoc) is None:
        raise InputError("an IPOC is not a counter", hint="answer with the one that came")
    # + 0.0 turns the -0.0 that rounding may leave into 0.0
    pairs = " ".join(f'{name}="{round(v, 6) + 0.0:.6f}"' for name, v in zip("XYZABC", printed, strict=True))
    return f'<Sen Type="{check_sen_type(sen_type)}"><RKorr {pairs} /><IPOC>{ipoc}</IPOC></Sen>'.encode("ascii")


def check_sen_type(sen_type: str) -> str:
    """The name itself, where it can be SENTYPE's. Raises InputError where it can't."""
    if _SEN_TYPE.fullmatch(sen_type) is None:
        raise InputError(f"{sen_type!r} can't be SENTYPE", hint="use letters, digits, - and _, as in the configuration")
    return sen_type


def _refused(what: str) -> InputError:
    return InputError(what, hint=_HINT)


def _children(text: str) -> list[tuple[str, dict[str, str], str]]:
    """Name, attributes and own text of the elements right below `<Rob Type="KUKA">`, the document held to be well-formed."""
    text = text.strip(" \t\r\n")
    declaration = _DECLARATION.match(text)
    at = 0 if declaration is None else declaration.end()
    open_names: list[str] = []
    children: list[tuple[str, dict[str, str], str]] = []
    texts: list[str] = []
    elements, ended = 0, False
    while at < len(text):
        token = _TOKEN.match(text, at)
        if token is None:
            raise _refused("a frame isn't well-formed")
        at = token.end()
        name, attributes, empty, closing, plain = token.groups()
        if plain is not None:
            if not open_names and plain.strip(" \t\r\n"):
                raise _refused("a frame isn't well-formed")
            if len(open_names) == 2:
                texts.append(plain)
            continue
        if name is not None:
            elements += 1
            if ended or elements > _MOST_ELEMENTS or len(open_names) >= _DEEPEST:
                raise _refused("a frame isn't well-formed" if ended else "a frame has too many elements")
            given = _attributes(attributes)
            if not open_names and (name != "Rob" or given.get("Type") != "KUKA"):
                raise _refused('a frame isn\'t <Rob Type="KUKA">')
            if len(open_names) == 1:
                children.append((name, given, ""))
                texts = []
            elif len(open_names) == 2:
                texts.append("<")  # what is apart in the frame doesn't become one number here
            open_names.append(name)
        elif not open_names or open_names[-1] != closing:
            raise _refused("a frame isn't well-formed")
        if empty or closing is not None:
            if len(open_names) == 2:
                children[-1] = (*children[-1][:2], "".join(texts))
            open_names.pop()
            ended = not open_names
    if open_names or not ended:
        raise _refused("a frame isn't well-formed")
    return children


def _attributes(text: str) -> dict[str, str]:
    pairs = _ATTRIBUTE.findall(text)
    given = {name: value[1:-1] for name, value in pairs}
    if len(given) != len(pairs) or len(pairs) > _MOST_ATTRIBUTES:
        raise _refused("a frame repeats an attribute or has too many")
    return given


def _only(
    children: list[tuple[str, dict[str, str], str]], name: str, *, needed: bool
) -> tuple[dict[str, str], str] | None:
    """Attributes and text of the one child of that name; None where there is none and none is `needed`."""
    found = [child[1:] for child in children if child[0] == name]
    if len(found) > 1:
        raise _refused(f"a frame has more than one {name}")
    if not found and needed:
        raise _refused(f"a frame has no {name}")
    return found[0] if found else None


def _pose(given: dict[str, str]) -> Array:
    """(X, Y, Z, A, B, C) of an element that has these attributes and no other."""
    if set(given) != set("XYZABC"):
        raise _refused("a frame's pose isn't X, Y, Z, A, B, C")
    texts = [given[name].strip(" ") for name in "XYZABC"]
    if any(_NUMBER.fullmatch(text) is None for text in texts):
        raise _refused("a frame's pose holds something that is not a finite number")
    values = np.array([float(text) for text in texts])
    if not (np.abs(values[:3]) <= _FARTHEST_MM).all() or not (np.abs(values[3:]) <= _WIDEST_DEG).all():
        raise _refused("a frame's pose lies beyond any robot's reach")
    return locked(np.concatenate([mm_to_m(values[:3]), deg_to_rad(values[3:])]), shape=(6,), name="pose")
