"""The dialects that a drawn job is written in, each by its own rules, with its whims: order of words, blanks, modal words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random

from legal.plan import Able, Step

INCH = 25.4
Writer = Callable[[Random, Sequence[Step]], str]


@dataclass(frozen=True)
class Written:
    """A dialect of the bench. plane: see `plan.told`."""

    suffix: str
    able: Able
    plane: bool
    write: Writer


def _number(rng: Random, value: float, unit: float = 1.0, digits: int = 3) -> str:
    """A coordinate as CAM systems print it: with all its digits, or without the last zeros."""
    text = f"{value / unit:.{digits}f}"
    if rng.random() < 0.4:
        text = text.rstrip("0")
    return "0.0" if text in ("-0.", "0.", "-0.000") else text


class _Apt:
    """What the APT family has in common: GOTO with or without the axis, FEDRAT where the feed changes, RAPID before each."""

    def __init__(self, rng: Random, unit: float = 1.0, digits: int = 3) -> None:
        self.rng, self.unit, self.digits = rng, unit, digits
        self.lines: list[str] = []
        self.axis: object = None
        self.feed = -1.0
        self.tool = 0

    def n(self, value: float) -> str:
        return _number(self.rng, value, self.unit, self.digits)

    def point(self, at: Sequence[float]) -> str:
        return ",".join(self.n(v) for v in at)

    def all(self, steps: Sequence[Step]) -> list[str]:
        for step in steps:
            getattr(self, "_" + step.kind.replace("-", "_"))(step)
        return self.lines

    def _operation(self, step: Step) -> None:
        pass

    def _change(self, step: Step) -> None:
        self.lines.append(f"LOADTL/{step.value:g}")

    def _spindle(self, step: Step, sense: str) -> None:
        self.lines.append(f"SPINDL/{step.value:g},RPM,{sense}")

    def _cw(self, step: Step) -> None:
        self._spindle(step, "CLW")

    def _ccw(self, step: Step) -> None:
        self._spindle(step, "CCLW")

    def _off(self, step: Step) -> None:
        self.lines.append("SPINDL/OFF")

    def _wet(self, step: Step) -> None:
        self.lines.append("COOLNT/ON")

    def _dry(self, step: Step) -> None:
        self.lines.append("COOLNT/OFF")

    def _dwell(self, step: Step) -> None:
        self.lines.append(f"DELAY/{step.value:g}")

    def _halt(self, step: Step) -> None:
        self.lines.append("STOP")

    def _goto(self, step: Step) -> None:
        says = step.axis is not None and step.axis != self.axis
        again = self.axis is not None and self.rng.random() < 0.1
        axis = "".join(f",{v:.9f}" for v in step.axis) if step.axis is not None and (says or again) else ""
        self.axis = step.axis or self.axis
        self.lines.append(f"GOTO/{self.point(step.at)}{axis}")

    def _rapid(self, step: Step) -> None:
        self.lines.append("RAPID")
        self._goto(step)

    def _feeds(self, feed: float) -> str:
        return f"FEDRAT/{feed / self.unit:.6g},{'MMPM' if self.unit == 1.0 else 'IPM'}"

    def _fed(self, step: Step) -> None:
        if step.feed != self.feed or self.rng.random() < 0.1:
            self.lines.append(self._feeds(step.feed))
            self.feed = step.feed

    def _cut(self, step: Step) -> None:
        self._fed(step)
        self._goto(step)

    def _circle(self, step: Step) -> str:
        sense = 1 if step.turn > 0 else -1
        radius = max(abs(step.center[0] - self.here(step)[0]), abs(step.center[1] - self.here(step)[1]))
        return f"CIRCLE/{self.point(step.center)},0,0,{sense},{self.n(radius)}"

    @staticmethod
    def here(step: Step) -> Sequence[float]:
        return step.at

    def _arc(self, step: Step) -> None:
        self._fed(step)
        self.lines.append(self._circle(step))
        self.lines.append(f"GOTO/{self.point(step.at)}")

    def _cycle(self, step: Step) -> str:
        more = step.more
        kind = f"DEEP,STEP,{self.n(more['peck'])}" if more["peck"] else "DRILL"
        dwell = f",DWELL,{more['dwell']:g}" if more["dwell"] else ""
        unit = "MMPM" if self.unit == 1.0 else "IPM"
        feed = f"{unit},{step.feed / self.unit:.6g}"
        down = f"RAPTO,{self.n(more['clear'])},FEDTO,{self.n(more['depth'])}"
        return f"CYCLE/{kind},{down},{feed},RTRCTO,{self.n(more['back'])}{dwell}"

    def _hole(self, step: Step) -> None:
        cycle = self._cycle(step)
        if cycle not in self.lines[-8:]:
            self.lines.append(cycle)
        self.lines.append(f"GOTO/{self.point(step.at)}")

    def _cycle_off(self, step: Step) -> None:
        self.lines.append("CYCLE/OFF")


class _Nx(_Apt):
    def _operation(self, step: Step) -> None:
        self._end()
        self.axis = None
        self.lines += [
            f"TOOL PATH/OP_{step.value:g},TOOL,MILL_{step.more['tool']}",
            "TLDATA/MILL,10.0000,0.0000,75.0000,0.0000,0.0000",
        ]
        self.lines += ["MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0", "PAINT/PATH"]

    def _end(self) -> None:
        if self.lines:
            self.lines.append("END-OF-PATH")

    def _change(self, step: Step) -> None:
        self.lines.append(f"LOAD/TOOL,{step.value:g}")

    def _spindle(self, step: Step, sense: str) -> None:
        self.lines.append(f"SPINDL/RPM,{step.value:g},{sense}")

    def _feeds(self, feed: float) -> str:
        return f"FEDRAT/MMPM,{feed:.4f}"

    def _circle(self, step: Step) -> str:
        """Left-handed about the axis that it prints, and the end's place twice."""
        sense = -1.0 if step.turn > 0 else 1.0
        radius = max(abs(step.center[0] - step.at[0]), abs(step.center[1] - step.at[1]))
        return f"CIRCLE/{self.point(step.center)},0.0,0.0,{sense},{self.n(radius)},0.06,0.5,10.0,0.0"

    def _cycle(self, step: Step) -> str:
        more = step.more
        peck = f"STEP,{self.n(more['peck'])}," if more["peck"] else ""
        dwell = f",DWELL,{more['dwell']:g}" if more["dwell"] else ""
        return (
            f"CYCLE/DRILL,{'DEEP,' if peck else ''}RAPTO,{self.n(more['clear'])},FEDTO,{self.n(-more['depth'])},{peck}"
            f"MMPM,{step.feed:g},RTRCTO,{self.n(more['back'])}{dwell}"
        )


class _Catia(_Apt):
    def _point(self, at: Sequence[float]) -> str:
        return ",".join(f"{v:12.5f}" for v in at)

    def _spindle(self, step: Step, sense: str) -> None:
        self.lines.append(f"SPINDL/ {step.value:.4f},RPM,{sense}")

    def _feeds(self, feed: float) -> str:
        return f"FEDRAT/ {feed:.4f},MMPM"

    def _goto(self, step: Step) -> None:
        axis = "" if step.axis is None else ",$\n" + ",".join(f"{v:9.6f}" for v in step.axis)
        self.lines.append(f"GOTO  / {self._point(step.at)}{axis}")


def _nx(rng: Random, steps: Sequence[Step]) -> str:
    writer = _Nx(rng)
    writer.all(steps)
    return "\n".join([*writer.lines, "END-OF-PATH", ""])


def _plain(rng: Random, steps: Sequence[Step]) -> str:
    return "\n".join(["PARTNO DRAWN", "UNITS/MM", "MULTAX/ON", *_Apt(rng).all(steps), "FINI", ""])


def _camworks(rng: Random, steps: Sequence[Step]) -> str:
    head = ["PARTNO DRAWN", "UNIT/INCH", "CUTTER/0.25,0,0.125,0,0,0,2.5"]
    return "\n".join([*head, *_Apt(rng, INCH, 4).all(steps), "FINI", ""])


class _Gcode:
    """Three axes; words and coordinates that are modal may be left out; arcs by centre or radius; N numbers, blanks, comments."""

    def __init__(self, rng: Random, unit: float, digits: int) -> None:
        self.rng, self.unit, self.digits = rng, unit, digits
        self.lines = ["%", "O1234 (DRAWN)", f"G90 G17 {'G21' if unit == 1.0 else 'G20'} G94"]
        self.numbers, self.tight = rng.random() < 0.5, rng.random() < 0.5
        self.at: tuple[str, str, str] | None = None
        self.here: Sequence[float] = (0.0, 0.0, 0.0)
        self.motion, self.feed, self.cycle = "", "", ""

    def n(self, value: float) -> str:
        return _number(self.rng, value, self.unit, self.digits)

    def block(self, *words: str) -> None:
        number = f"N{10 * len(self.lines)} " if self.numbers else ""
        text = ("" if self.tight else " ").join(w for w in words if w)
        self.lines.append(number + text + (" (ON)" if self.rng.random() < 0.05 else ""))

    def _move(self, code: str, step: Step, *more: str) -> None:
        texts = tuple(f"{v / self.unit:.{self.digits}f}" for v in step.at)
        moved = [self.at is None or a != b for a, b in zip(texts, self.at or texts, strict=True)]
        if self.rng.random() < 0.2 or not any(moved):
            moved = [True] * 3
        words = [c + self.n(v) for c, v, say in zip("XYZ", step.at, moved, strict=True) if say]
        said = code if code != self.motion or self.rng.random() < 0.3 else ""
        self.motion, self.at, self.here = code, texts, step.at
        self.block(said, *words, *more)

    def _fed(self, step: Step) -> str:
        text = f"F{step.feed / self.unit:.6g}"
        if text == self.feed and self.rng.random() < 0.8:
            return ""
        self.feed = text
        return text

    def all(self, steps: Sequence[Step]) -> list[str]:
        for step in steps:
            getattr(self, "_" + step.kind.replace("-", "_"))(step)
        return [*self.lines, "M30", "%", ""]

    def _operation(self, step: Step) -> None:
        self.lines.append(f"(OPERATION {step.value:g})")

    def _change(self, step: Step) -> None:
        self.block(f"T{step.value:g}", "M6")

    def _cw(self, step: Step) -> None:
        self.block(f"S{step.value:g}", "M3")

    def _ccw(self, step: Step) -> None:
        self.block(f"S{step.value:g}", "M4")

    def _off(self, step: Step) -> None:
        self.block("M5")

    def _wet(self, step: Step) -> None:
        self.block("M8")

    def _dry(self, step: Step) -> None:
        self.block("M9")

    def _dwell(self, step: Step) -> None:
        self.block("G4", f"P{step.value:.2f}")

    def _halt(self, step: Step) -> None:
        self.block("M0")

    def _rapid(self, step: Step) -> None:
        self._move("G0", step)

    def _cut(self, step: Step) -> None:
        self._move("G1", step, self._fed(step))

    def _arc(self, step: Step) -> None:
        code, center = ("G3" if step.turn > 0 else "G2"), step.center
        whole = abs(step.turn) == 360.0
        x, y = center[0] - self.here[0], center[1] - self.here[1]
        if not whole and abs(step.turn) < 180.0 and self.rng.random() < 0.4:
            how = ["R" + self.n(max(abs(x), abs(y)))]
        else:
            how = ["I" + self.n(x), "J" + self.n(y)]
        if whole:
            said = code if code != self.motion else ""
            self.motion = code
            self.block(said, *how, self._fed(step))
            return
        self._move(code, step, *how, self._fed(step))

    def _hole(self, step: Step) -> None:
        """G99 goes back to R; the way back to another height is the next block's."""
        (x, y, z), more = step.at, step.more
        place = ["X" + self.n(x), "Y" + self.n(y)]
        code = "G83" if more["peck"] else "G82" if more["dwell"] else "G81"
        if self.cycle != code:
            extra = [f"Q{self.n(more['peck'])}"] if more["peck"] else [f"P{more['dwell']:.2f}"] if more["dwell"] else []
            self.block(
                "G99",
                code,
                *place,
                "Z" + self.n(z - more["depth"]),
                "R" + self.n(z + more["clear"]),
                *extra,
                self._fed(step),
            )
        else:
            self.block(*place)
        self.cycle, self.here = code, (x, y, z + more["clear"])

    def _cycle_off(self, step: Step) -> None:
        self.block("G80")
        self.cycle, self.at, self.motion = "", None, ""


def _mm(rng: Random, steps: Sequence[Step]) -> str:
    return "\n".join(_Gcode(rng, 1.0, 3).all(steps))


def _inch(rng: Random, steps: Sequence[Step]) -> str:
    return "\n".join(_Gcode(rng, INCH, 4).all(steps))


_FINE = 1e-4 * INCH
DIALECTS = {
    "nx": Written(".cls", Able(), False, _nx),
    "plain": Written(".apt", Able(circles=False), False, _plain),
    "camworks": Written(".apt", Able(grid=_FINE, circles=False), False, _camworks),
    "gcode": Written(".nc", Able(tilts=False), True, _mm),
    "gcode-inch": Written(".nc", Able(grid=_FINE, tilts=False), True, _inch),
}
