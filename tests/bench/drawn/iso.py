"""Programs for Fanuc's controls and those alike (B-63944EN), and for LinuxCNC (its manual, "G-Codes", "O-Codes")."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np

from camrob.witness.happenings import Kind
from drawn.turns import about
from drawn.writer import Point, Writer

__all__ = ["Fanuc", "LinuxCnc"]

_ROTARY = {  # of a reading: its tilting axis, and the tool's axis for that angle and C, radians (docs/reference/controls.md)
    "xyzac-iso": ("A", lambda a, c: (math.sin(a) * math.sin(c), -math.sin(a) * math.cos(c), math.cos(a))),
    "xyzbc-iso": ("B", lambda b, c: (math.sin(b) * math.cos(c), math.sin(b) * math.sin(c), math.cos(b))),
    "xyzac": ("A", lambda a, c: (math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a))),
    "xyzbc": ("B", lambda b, c: (-math.sin(b) * math.cos(c), math.sin(b) * math.sin(c), math.cos(b))),
}


class _Iso(Writer):
    """What both have in common: words of ISO 6983."""

    def __init__(self, rng: Random) -> None:
        super().__init__(rng)
        self.motion = ""
        self.said: Point = {}
        self.incremental = False
        self.variables = 100
        self.subs = 1000

    def pieces(self) -> list[Callable[[], None]]:
        """Increments, corners and turned planes, too."""
        return [*super().pieces(), self.increments, self.planes, self.home]

    def block(self, *words: str) -> None:
        """A line, its words apart or not."""
        self.count += 5
        number = f"N{self.count}" if self.rng.random() < 0.3 else ""
        self.lines.append((" " if self.rng.random() < 0.8 else "").join([*([number] if number else []), *words]))

    def value(self, count: int) -> str:
        """A number behind a letter: plain, a variable's, or a sum's."""
        if self.rng.random() > 0.08:
            return self.plain(count)
        self.variables = 100 + (self.variables - 99) % 60
        which, part = self.rng.choice("vse"), self.grid(self.rng.uniform(-9, 9))
        name = self.variable(self.variables, self.plain(count if which == "v" else count - part))
        return (
            name if which == "v" else f"[{name}+{self.plain(part)}]" if which == "s" else f"[{self.plain(part)}+{name}]"
        )

    def variable(self, number: int, value: str) -> str:
        """A variable that is given this value before the block."""
        self.lines.append(f"#{number}={value}")
        return f"#{number}"

    def begin(self) -> None:
        """Heading, tool, spindle, first place."""
        self.heading()
        self.block(*self.rng.sample(["G90", "G17", "G94", "G20" if self.inch else "G21", "G40", "G80"], 6))
        if self.rng.random() < 0.5:
            self.block("G54")
        tool, rpm = self.rng.randint(1, 20), self.rng.choice((2000, 9000))
        self.block(*([f"T{tool}", "M6"] if self.rng.random() < 0.7 else ["M6", f"T{tool}"]))
        self.told.event(Kind.TOOL, tool)
        self.block(f"S{rpm}", "M3")
        self.told.event(Kind.SPINDLE_ON, rpm, "CLW")
        self.lengthen()
        self.over(self.somewhere())

    def heading(self) -> None:
        """What stands before all."""

    def lengthen(self) -> None:
        """The tool's length."""

    def end(self) -> None:
        """M5, M30."""
        self.up()
        self.block("M5")
        self.told.event(Kind.SPINDLE_OFF)
        self.block("M30")

    def write_line(self, to: Point, rapid: bool) -> None:
        code = "G0" if rapid else "G1"
        words = (
            []
            if code == self.motion and self.rng.random() < 0.8
            else [self.rng.choice((code, code, code[0] + "0" + code[1]))]
        )
        axes = self.axes(to)
        if not axes:
            return
        self.block(*words, *axes, *([] if rapid else self.fed_word()))
        self.motion = code

    def axes(self, to: Point) -> list[str]:
        """Words of what changes, or of all."""
        named = [k for k in "XYZ" if self.said.get(k) != to[k] or self.rng.random() < 0.1]
        if self.incremental:
            named = [k for k in named if to[k] != self.said[k]]
            out = [k + self.value(to[k] - self.said[k]) for k in named]
        else:
            out = [k + self.value(to[k]) for k in named]
        self.said = dict(to)
        return out

    def fed_word(self) -> list[str]:
        """F where the feed is another, and now and then again."""
        if self.fed and self.rng.random() < 0.9:
            return []
        self.fed = True
        return [f"F{self.feed:g}" + ("." if self.feed % 1 == 0 and self.rng.random() < 0.5 else "")]

    def write_arc(self, center: Point, end: Point, turn: float) -> None:
        code = "G3" if turn > 0 else "G2"
        whole = abs(turn) == 360.0
        words = self.axes(end)
        words = [w for w in words if w[0] in "XYZ"]
        if self.rng.random() < 0.4 and abs(turn) in (90.0, 270.0):
            radius = max(abs(center["X"] - self.at["X"]), abs(center["Y"] - self.at["Y"]))
            words.append(f"R{'-' if abs(turn) > 180.0 else ''}{self.plain(radius)}")
        else:
            words += [
                f"{i}{self.plain(center[k] - self.at[k])}"
                for i, k in zip("IJ", "XY", strict=True)
                if center[k] != self.at[k]
            ]
        if whole and not any(w[0] in "IJ" for w in words):
            raise AssertionError("a full circle needs its centre")
        self.block(code, *words, *self.fed_word())
        self.motion = code

    def write_coolant(self, on: bool) -> None:
        self.block("M8" if on else "M9")

    def write_dwell(self, seconds: float) -> None:
        self.block("G4", f"P{seconds:g}" if "." in f"{seconds:g}" else f"P{seconds:g}.")

    def write_speed(self, rpm: float) -> None:
        self.block(f"S{rpm:g}", *(["M3"] if self.rng.random() < 0.5 else []))

    def write_halt(self) -> None:
        self.block("M0")

    def increments(self) -> None:
        """Cuts in G91."""
        self.over(self.somewhere())
        self.cut(self.near())
        self.block("G91")
        self.incremental = True
        for _ in range(self.rng.randint(1, 4)):
            self.cut(self.near())
        self.block("G90")
        self.incremental = False
        self.up()

    def home(self) -> None:
        """To a machine position, and back."""
        self.up()
        self.lines.append(self.rng.choice(("G91 G28 Z0.\nG90", "G53 G0 Z0.")))
        self.motion = "" if "G28" in self.lines[-1] else "G0"
        self.told.lose()
        self.at, self.said = {}, {}
        self.over(self.somewhere())

    def planes(self) -> None:
        """An arc in the ZX or YZ plane."""
        self.over(self.somewhere())
        self.cut(self.near())
        code, a, b, i, normal = self.rng.choice((("G18", "Z", "X", "K", (0, 1, 0)), ("G19", "Y", "Z", "J", (1, 0, 0))))
        r, sense = self.grid(self.rng.uniform(2, 9)), self.rng.choice((1, -1))
        # from the centre's side along the plane's first axis, a quarter of a turn
        center = {**self.at, a: self.at[a] - r}
        end = {**center, b: center[b] + sense * r}
        self.block(code)
        self.said = dict(end)
        words = [f"{a}{self.plain(end[a])}", f"{b}{self.plain(end[b])}", f"{i}{self.plain(-r)}"]
        self.block("G3" if sense > 0 else "G2", *words, *self.fed_word())
        self.motion = "G3"
        matrix = self.matrix / float(np.cbrt(abs(np.linalg.det(self.matrix))))
        self.told.arc(
            self.place(end), self.place(center), matrix @ np.array(normal, float), 90.0 * sense, self.feed * self.mm
        )
        self.at = end
        self.block("G17")
        self.up()

    def holes(self) -> None:
        """G73, G81 to G83, G85, G89 at some places."""
        top = self.somewhere()
        self.over(top)
        if not self.feed:
            self.new_feed()
        code = self.rng.choice(("G81", "G81", "G82", "G83", "G73", "G85", "G89"))
        start, back = self.at["Z"], self.rng.choice(("G98", "G99"))
        r, bottom = start - self.grid(1), start - self.grid(self.rng.uniform(4, 12))
        bite = self.grid(self.rng.uniform(1, 4)) if code in ("G83", "G73") else 0
        dwell = 0.5 if code in ("G82", "G89") else 0.0
        words = [f"Z{self.plain(bottom)}", f"R{self.plain(r)}"]
        words += [f"Q{self.plain(bite)}"] * bool(bite) + ["P0.5"] * bool(dwell)
        for n in range(self.rng.randint(1, 4)):
            spot = self.near() if n else dict(self.at)
            axes = [
                f"{k}{self.plain(spot[k])}"
                for k in "XY"
                if spot[k] != self.at[k] or (n == 0 and self.rng.random() < 0.5)
            ]
            if n and not axes:
                continue
            self.block(
                *([back, code] if n == 0 else []),
                *axes,
                *(words if n == 0 else []),
                *(self.fed_word() if n == 0 else []),
            )
            self.drilled(spot, r, bottom, start if back == "G98" else r, (code, dwell, bite))
        self.block("G80")
        self.motion, self.said = "", {}

    def drilled(self, spot: Point, r: int, bottom: int, level: int, how: tuple[str, float, int]) -> None:
        """Note one hole."""
        code, dwell, bite = how
        for z in (self.at["Z"], r):
            self.told.rapid(self.place({**spot, "Z": z}))
        self.told.hole(self.place({**spot, "Z": bottom}), self.feed * self.mm, self.unit(bite) * self.mm, code == "G83")
        if dwell:
            self.told.event(Kind.DWELL, dwell)
        if code in ("G85", "G89"):
            self.told.cut(self.place({**spot, "Z": r}), self.feed * self.mm)
        self.told.rapid(self.place({**spot, "Z": level}))
        self.at = {**spot, "Z": level}

    def shift(self) -> None:
        """Cuts in a frame that G52 has shifted."""
        by = [self.grid(self.rng.uniform(-8, 8)) for _ in "XYZ"]
        self.block("G52", *(f"{k}{self.plain(v)}" for k, v in zip("XYZ", by, strict=True)))
        self.use(np.eye(3), np.array([self.unit(v) for v in by]) * self.mm)
        self.said = {}
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        self.block("G52 X0. Y0. Z0.")
        self.use(np.eye(3), np.zeros(3))
        self.said = {}
        self.over(self.somewhere())


class Fanuc(_Iso):
    """Custom macros, G52, G68.2 with G53.1, G43.4 with ISO's signs."""

    def __init__(self, rng: Random) -> None:
        super().__init__(rng)
        self.kinematics = rng.choice(("xyzac-iso", "xyzbc-iso", "xyzac", "xyzbc"))
        self.reading = {"kinematics": self.kinematics}

    def heading(self) -> None:
        self.lines += ["%", f"O{self.rng.randint(1, 999)} (DRAWN)"]

    def lengthen(self) -> None:
        self.block("G43", "H1")

    def pieces(self) -> list[Callable[[], None]]:
        return [*super().pieces(), self.corners, self.turned, self.rotated]

    def draw(self) -> str:
        return super().draw().rstrip("\n") + "\n%\n"

    def again(self) -> None:
        self.over(self.somewhere())
        self.cut(self.near())
        steps, times = self.steps(), self.rng.randint(1, 4)
        body = ["G1 " + " ".join(f"{k}{self.plain(v)}" for k, v in zip("XYZ", s, strict=True) if v) for s in steps]
        steps = [s for s in steps if any(s)]
        self.motion = "G1"
        which = self.rng.choice(("while", "goto", "sub", "macro"))
        if which == "while":
            self.lines += [f"#1={times}", "WHILE[#1 GT 0]DO1", "G91", *body, "G90", "#1=#1-1", "END1"]
        elif which == "goto":
            self.subs += 1
            self.lines += ["#2=0", f"N{self.subs} #2=#2+1", "G91", *body, "G90", f"IF[#2 LT {times}]GOTO{self.subs}"]
        elif which == "sub":
            self.subs += 1
            self.lines.append(f"M98 P{self.subs}" + (f" L{times}" if times > 1 else ""))
            self.behind += [f"O{self.subs}", "G91", *body, "G90", "M99"]
        else:
            self.subs += 1
            x, y, _ = steps[0]
            steps = [(x, y, 0)]
            self.lines.append(f"G65 P{self.subs} A{self.plain(x)} B{self.plain(y)} C{times}.")
            self.behind += [f"O{self.subs}", "WHILE[#3 GT 0]DO2", "G91 G1 X#1 Y#2", "G90", "#3=#3-1", "END2", "M99"]
        self.walk(steps, times)
        self.said = {}
        self.up()

    def framed(self) -> None:
        if self.rng.random() < 0.4:
            self.shift()
            return
        angles = [self.rng.choice((0.0, 15.0, 30.0, -40.0, 90.0)) for _ in range(2)] + [self.rng.choice((0.0, 20.0))]
        angles[1] = self.rng.choice((10.0, -12.0))
        at = [self.grid(self.rng.uniform(-10, 10)) for _ in "XYZ"]
        words = [f"{k}{self.plain(v)}" for k, v in zip("XYZ", at, strict=True)]
        words += [f"{k}{v:g}." if v % 1 == 0 else f"{k}{v:g}" for k, v in zip("IJK", angles, strict=True)]
        self.block("G68.2", *words)
        self.block("G53.1")
        z1, x, z2 = (math.radians(v) for v in angles)
        self.use(about(2, z1) @ about(0, x) @ about(2, z2), np.array([self.unit(v) for v in at]) * self.mm)
        self.told.lose()
        self.told.axis = self.matrix[:, 2]
        self.said = {}
        self.over(self.somewhere())
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        self.block("G69")
        tilt = _ROTARY[self.kinematics][0]
        self.block("G0", f"{tilt}0.", "C0.")
        self.motion = "G0"
        self.use(np.eye(3), np.zeros(3))
        self.told.lose()
        self.told.axis = np.array([0.0, 0.0, 1.0])
        self.said = {}
        self.over(self.somewhere())

    def rotated(self) -> None:
        """Cuts in a frame that is turned (G68) or mirrored (G51.1)."""
        at = [self.grid(self.rng.uniform(-8, 8)) for _ in "XY"]
        center = np.array([*(self.unit(v) for v in at), 0.0]) * self.mm
        if self.rng.random() < 0.6:
            angle = self.rng.choice((30.0, -45.0, 90.0, 12.5))
            self.block(
                "G68",
                *(f"{k}{self.plain(v)}" for k, v in zip("XY", at, strict=True)),
                f"R{angle:g}" + "." * (angle % 1 == 0),
            )
            matrix, ends = about(2, math.radians(angle)), "G69"
        else:
            axes = self.rng.choice(("X", "Y", "XY"))
            self.block("G51.1", *(f"{k}{self.plain(at['XY'.index(k)])}" for k in axes))
            matrix = np.diag([-1.0 if k in axes else 1.0 for k in "XYZ"])
            ends = "G50.1 " + " ".join(f"{k}0." for k in axes)
        self.use(matrix, center - matrix @ center)
        self.said = {}
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        self.block(ends)
        self.use(np.eye(3), np.zeros(3))
        self.said = {}
        self.over(self.somewhere())

    def turned(self) -> None:
        """Cuts with the tool centre point on, the tool turned in a rapid before them and within them."""
        tilt, axis = _ROTARY[self.kinematics]
        self.up()
        self.block("G43.4", "H1")
        angles = [self.rng.uniform(-30, 30), self.rng.uniform(-80, 80)]
        spot = self.somewhere()
        at = [round(v, 3) for v in angles]
        self.told.axis = np.array(axis(*(math.radians(v) for v in at)))
        self.said, self.at = dict(spot), dict(spot)
        words = [f"{k}{self.plain(spot[k])}" for k in "XYZ"]
        self.block("G0", *words, f"{tilt}{at[0]:.3f}", f"C{at[1]:.3f}")
        self.told.rapid(self.place(spot))
        self.motion = "G0"
        if not self.feed:
            self.new_feed()
        for _ in range(self.rng.randint(1, 3)):
            self.cut(self.near())
        self.up()
        self.block("G49")
        self.block("G0", f"{tilt}0.", "C0.")
        self.lengthen()
        self.told.lose()
        self.told.axis = np.array([0.0, 0.0, 1.0])
        self.at, self.said = {}, {}
        self.over(self.somewhere())

    def corners(self) -> None:
        """,R and ,C between two straight cuts at right angles."""
        self.over(self.somewhere())
        self.cut({**self.at, "Z": self.at["Z"] - self.grid(2)})
        size = self.grid(self.rng.uniform(1, 4))
        corner = {**self.at, "X": self.at["X"] + self.rng.choice((1, -1)) * self.grid(12)}
        sx = 1 if corner["X"] > self.at["X"] else -1
        sy = self.rng.choice((1, -1))
        end = {**corner, "Y": corner["Y"] + sy * self.grid(12)}
        rounded = self.rng.random() < 0.5
        self.block(
            "G1", f"X{self.plain(corner['X'])}", f"{',R' if rounded else ',C'}{self.plain(size)}", *self.fed_word()
        )
        self.block(f"Y{self.plain(end['Y'])}")
        self.motion, self.said = "G1", dict(end)
        first, last = {**corner, "X": corner["X"] - sx * size}, {**corner, "Y": corner["Y"] + sy * size}
        feed = self.feed * self.mm
        self.told.cut(self.place(first), feed)
        if rounded:
            center = {**first, "Y": last["Y"]}
            self.told.arc(self.place(last), self.place(center), (0, 0, 1), 90.0 * sx * sy, feed)
        else:
            self.told.cut(self.place(last), feed)
        self.told.cut(self.place(end), feed)
        self.at = end
        self.up()


class LinuxCnc(_Iso):
    """O words with named parameters, G52 left out, TCP by M428."""

    suffix = ".ngc"

    def variable(self, number: int, value: str) -> str:
        name = self.rng.choice((f"#{number}", f"#<v{number}>"))
        self.lines.append(f"{name}={value if self.rng.random() < 0.5 else f'[{value}]'}")
        return name

    def again(self) -> None:
        self.over(self.somewhere())
        self.cut(self.near())
        steps, times = self.steps(), self.rng.randint(1, 4)
        self.subs += 1
        name = self.subs
        body = ["G1 " + " ".join(f"{k}{self.plain(v)}" for k, v in zip("XYZ", s, strict=True) if v) for s in steps]
        which = self.rng.choice(("repeat", "while", "do", "sub"))
        if which == "repeat":
            self.lines += [f"o{name} repeat [{times}]", "G91", *body, "G90", f"o{name} endrepeat"]
        elif which == "while":
            self.lines += [
                "#1=0",
                f"o{name} while [#1 LT {times}]",
                "G91",
                *body,
                "G90",
                "#1=[#1+1]",
                f"o{name} endwhile",
            ]
        elif which == "do":
            self.lines += [
                "#<n>=0",
                f"o{name} do",
                "G91",
                *body,
                "G90",
                "#<n>=[#<n>+1]",
                f"o{name} while [#<n> LT {times}]",
            ]
        else:
            x, y, _ = steps[0]
            steps = [(x, y, 0)]
            at = len(self.lines)
            while not self.lines[at - 1].startswith("("):
                at -= 1
            self.lines[at:at] = [
                f"o<s{name}> sub",
                f"o{name} repeat [#3]",
                "G91 G1 X#1 Y#2",
                "G90",
                f"o{name} endrepeat",
                f"o<s{name}> endsub",
            ]
            self.lines.append(f"o<s{name}> call [{self.plain(x)}] [{self.plain(y)}] [{times}]")
        self.motion = "G1"
        self.walk(steps, times)
        self.said = {}
        self.up()

    def heading(self) -> None:
        self.lines.append("(drawn)")

    def framed(self) -> None:
        self.cuts()
