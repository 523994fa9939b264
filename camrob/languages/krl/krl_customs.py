"""What a shop's programs look like beyond the language: the controller's generation, and customs that it takes or doesn't."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from camrob.errors import CellError

__all__ = ["Customs", "HomePoint", "take_customs"]

_GENERATIONS = ("KRC2", "KRC4", "KRC5")
_SPLINES_FROM = ("KRC4", "KRC5")  # SLIN and its kin as motions of their own came with KSS 8
_MOTIONS = ("LIN", "SLIN")
_BLENDINGS = {"C_DIS": "", "C_VEL": "apo_cvel_percent", "C_ORI": "apo_cori_deg"}
_NUMBERING = ("bas", "act", "tables")
_SAME = 1e-4  # degrees and mm: the last decimal that is printed
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,23}")  # as KRL takes it, 24 characters
_MOST = {
    "apo_cvel_percent": 100.0,
    "apo_cori_deg": 180.0,
}  # per cent of the speed; half a turn is as far as a tool can turn


@dataclass(frozen=True, slots=True)
class HomePoint:
    """HOME by the name that the shop's `$config.dat` has for it. axes: A1..A6, E1.. there, degrees and mm."""

    name: str
    axes: tuple[float, ...]

    def check(self, home: Sequence[float]) -> None:
        """Raise CellError where it isn't the cell's HOME (A1..A6, E1.., degrees and mm)."""
        if len(home) != len(self.axes) or any(abs(a - b) > _SAME for a, b in zip(home, self.axes, strict=True)):
            own = ", ".join(f"{v:g}" for v in home)
            raise CellError(
                f"home_point is not the cell's HOME, which is {own}",
                hint="make the two the same, as $config.dat has it",
            )


@dataclass(frozen=True, slots=True)
class Customs:
    """generation: of the controller, "" where nobody says. motions: LIN and CIRC, or SLIN and SCIRC. blending: how a target is
    rounded off, with `apo_cvel_percent` and `apo_cori_deg` its sizes (None: not written). numbering: how `tool_number` and
    `base_number` come into force: by BAS, by `$ACT_TOOL` and `$ACT_BASE`, or through TOOL_DATA and BASE_DATA. on_path: the
    initialisation stands in IF NOT $ON_PATH. folds: whether INI and operations are folded. home_point: None prints HOME's axes.
    """

    generation: str = ""
    motions: str = "LIN"
    blending: str = "C_DIS"
    apo_cvel_percent: float | None = None
    apo_cori_deg: float | None = None
    numbering: str = "bas"
    on_path: bool = False
    folds: bool = True
    home_point: HomePoint | None = None

    @property
    def splines(self) -> bool:
        """Whether motions along a path are those of the spline planner."""
        return self.motions == "SLIN"

    @property
    def blend_word(self) -> str:
        """What is written behind a target that is rounded off."""
        return "C_SPL" if self.splines else self.blending


def take_customs(own: dict[str, object], *, tool_number: int | None, base_number: int | None) -> Customs:
    """The customs that a cell states, taken out of `own`. Raises CellError for one that the controller doesn't take."""
    generation = _word(own, "generation", ("", *_GENERATIONS))
    customs = Customs(
        generation=generation,
        motions=_word(own, "motions", _MOTIONS),
        blending=_word(own, "blending", tuple(_BLENDINGS)),
        apo_cvel_percent=_size(own, "apo_cvel_percent"),
        apo_cori_deg=_size(own, "apo_cori_deg"),
        numbering=_word(own, "numbering", _NUMBERING),
        on_path=_truth(own, "on_path", False),
        folds=_truth(own, "folds", True),
        home_point=_home(own),
    )
    if customs.splines and generation not in _SPLINES_FROM:
        what = "motions are SLIN, which " + (
            f"a {generation} doesn't know" if generation else "not every controller knows"
        )
        raise CellError(what, hint='set generation = "KRC4" or "KRC5" where it is one, or leave motions out')
    if customs.splines and customs.blending != "C_DIS":
        what = f"blending is {customs.blending}, which SLIN passes over: it is rounded off by distance"
        raise CellError(what, hint="leave blending out, or motions")
    size = _BLENDINGS[customs.blending]
    if size and getattr(customs, size) is None:
        raise CellError(f"blending is {customs.blending} without its size", hint=f"add {size}")
    for key, of in _BLENDINGS.items():
        if of and of != size and getattr(customs, of) is not None:
            raise CellError(
                f"{of} is given, and targets are not rounded off by it", hint=f'set blending = "{key}", or leave it out'
            )
    if customs.numbering != "bas" and not (tool_number and base_number):
        what = f"numbering is {customs.numbering!r} without rows of the tables"
        raise CellError(what, hint="add tool_number and base_number, from 1")
    return customs


def _word(own: dict[str, object], key: str, words: tuple[str, ...]) -> str:
    """One of some words, the first of them where it is left out."""
    value = own.pop(key, words[0])
    if value not in words or (value == "" and not words[0] == value):
        raise CellError(f"{key} is {value!r}"[:80], hint="write one of " + ", ".join(w for w in words if w))
    return str(value)


def _size(own: dict[str, object], key: str) -> float | None:
    """A number above 0 that may be left out."""
    if key not in own:
        return None
    value = own.pop(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value <= _MOST[key]:
        raise CellError(f"{key} is {value!r}"[:80], hint=f"write a number above 0, {_MOST[key]:g} at most")
    return float(value)


def _truth(own: dict[str, object], key: str, usual: bool) -> bool:
    value = own.pop(key, usual)
    if not isinstance(value, bool):
        raise CellError(f"{key} is {value!r}"[:80], hint="write true or false")
    return value


def _home(own: dict[str, object]) -> HomePoint | None:
    """`home_point = { name = "XHOME", axes = [...] }`."""
    hint = 'write { name = "XHOME", axes = [A1, ..., A6, E1, ...] } as $config.dat has it, degrees and mm'
    if "home_point" not in own:
        return None
    value = own.pop("home_point")
    if not isinstance(value, dict) or set(value) != {"name", "axes"}:
        raise CellError(f"home_point is {value!r}"[:80], hint=hint)
    name, axes = value["name"], value["axes"]
    numbers = isinstance(axes, (list, tuple)) and all(
        isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in axes
    )
    if not isinstance(name, str) or _NAME.fullmatch(name) is None or not numbers:
        raise CellError(f"home_point is {value!r}"[:80], hint=hint)
    return HomePoint(name.upper(), tuple(float(v) for v in axes))
