"""How a program moves besides its frames and its feed: speeds, ramps and roundings in force, held to the cell's at every motion.

What the cell states has to hold wherever a motion depends on it. What the cell does not state has to be left at the
controller's default: away from it nobody can say whether a cut keeps to its path and its feed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from camrob.witness.machine import Controller

__all__ = ["ACC_PTP", "INIT", "PTP", "Conduct", "unlike"]

PTP, ACC_PTP, INIT = "BAS(#VEL_PTP)", "BAS(#ACC_PTP)", "BAS(#INITMOV)"
_ACT_EX_AX, _ACC_CP = "$ACT_EX_AX", "$ACC.CP"
_ROUNDINGS = ("$APO.CDIS", "$APO.CVEL", "$APO.CORI")  # where a corner begins to be rounded; nothing where none is
_EQUAL = 1e-3  # share: what printing a setting leaves
_SLUGGISH = 0.5  # of the cell's acceleration: with less, short cuts never reach their feed
_DEFAULTS = {"$SINGUL_STRATEGY": 0.0, "$ACC_AXIS": 100.0, "$ACC_EXTAX": 100.0, "$GEAR_JERK": 100.0, ACC_PTP: 100.0}
_SHARES = ("$VEL_AXIS", "$VEL_EXTAX")  # percent of an axis in PTP, as BAS(#VEL_PTP) sets of all
_TURNING = ("$VEL.ORI1", "$VEL.ORI2", "$ACC.ORI1", "$ACC.ORI2")
_ROWS = {"$ACT_TOOL": "tool_number", "$ACT_BASE": "base_number"}  # rows of the controller's tables, and the cell's keys


def unlike(name: str, given: float, own: float) -> tuple[str, str, bool] | None:
    """Code, text, and whether it is grave, where a setting isn't the cell's: higher and corners or ramps are others, lower
    turning brakes the cuts. None where it is, or isn't known.
    """
    if not abs(given - own) > _EQUAL * own:
        return None
    higher = given > own
    grave = higher or name in _TURNING or (name == _ACC_CP and given < _SLUGGISH * own)
    return (
        "setting-higher" if higher else "setting-lower",
        f"{name} is set to {given:g}, where the cell has {own:g}",
        grave,
    )


@dataclass(slots=True)
class Conduct:
    """values: what has been set, by name, NaN where the text doesn't say to what; begun: BAS(#INITMOV) has been run."""

    controller: Controller
    values: dict[str, float] = field(default_factory=dict)
    begun: bool = False
    words: Mapping[str, str] = field(default_factory=dict)  # what another language calls a setting
    judged: set[tuple[bool, bool]] = field(default_factory=set)  # kinds of motion, since something was set last
    said: set[str] = field(default_factory=set)
    rows: dict[str, float] = field(default_factory=dict)  # of the controller's tables, by the name that _ROWS has

    def set(self, name: str, value: float) -> None:
        """A setting from here on."""
        self.values[name] = value
        self.judged.clear()

    def set_row(self, name: str, number: float) -> None:
        """The row of the controller's table of tools or bases that is in force from here on, by its variable."""
        self.rows[name] = number
        self.judged.clear()

    def begin(self) -> None:
        """BAS(#INITMOV): everything is at the controller's default, PTP at full speed among it."""
        kept = {name: value for name, value in self.values.items() if name == _ACT_EX_AX}
        self.values = {PTP: 100.0, **kept}
        self.begun = True
        self.judged.clear()

    def at_motion(self, ptp: bool, rounded: bool) -> Iterator[tuple[str, str]]:
        """What stands against a motion: code and text, each once; code "" for what isn't judged."""
        if (ptp, rounded) in self.judged:
            return
        self.judged.add((ptp, rounded))
        for code, said in (*self._stated(ptp, rounded), *self._others(), *self._numbered()):
            text = said
            for name, word in self.words.items():
                text = text.replace(name, word)
            if text not in self.said:
                self.said.add(text)
                yield code, text

    def _stated(self, ptp: bool, rounded: bool) -> Iterator[tuple[str, str]]:
        """What the cell states."""
        if not self.begun:
            yield "", f"no {INIT} before it: what the program doesn't set itself is what the one before it left"
        if self.controller.act_ex_ax and _ACT_EX_AX not in self.values:
            yield "", f"{_ACT_EX_AX} isn't set: how many external axes take part is what the program before it left"
        stated = {PTP: self.controller.ptp_percent} if ptp else dict(self.controller.settings)
        for name, own in stated.items():
            if own is None or (name in _ROUNDINGS and not rounded):
                continue
            given = self.values.get(name, float("nan"))
            found = unlike(name, given, own)
            if found is not None and found[2]:
                yield found[:2]
            elif not given > 0.0:
                yield "", f"{name} isn't set here to a number that is known, and the cell has {own:g}"

    def _others(self) -> Iterator[tuple[str, str]]:
        """What the cell doesn't state."""
        stated = {PTP, _ACT_EX_AX, *self.controller.settings}
        for name, given in self.values.items():
            family = name.split("[")[0].split(".")[0]
            default = (self.controller.ptp_percent or 100.0) if family in _SHARES else _DEFAULTS.get(family)
            if name not in stated and given != default:
                yield "", f"{name} is set away from the controller's default, and what it does to motions isn't judged"

    def _numbered(self) -> Iterator[tuple[str, str]]:
        """Rows of tools and bases: with another one, load data, hand guiding and an entry after a stop are another tool's."""
        for name, key in _ROWS.items():
            own, given = self.controller.own.get(key), self.rows.get(name)
            if isinstance(own, int) and given is not None and given != own:
                yield "other-number", f"{name} is {given:g} here, where the cell has {key} = {own}"
