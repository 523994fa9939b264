"""Programs for Siemens' 840D (840D sl, "Fundamentals" and "Job planning")."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np

from camrob.witness.happenings import Kind
from drawn.turns import about
from drawn.writer import Point, Writer

__all__ = ["Siemens"]


class Siemens(Writer):
    """X=.., IC and AC, CR=, R parameters, structures, subprograms, frames, CYCLE800, TRAORI with vectors, drilling."""

    suffix = ".mpf"

    def __init__(self, rng: Random) -> None:
        super().__init__(rng)
        self.motion = ""
        self.said: Point = {}
        self.subs = 0
        self.r = 9
        self.zero = rng.choice((("A0", "C0"), ("B=0", "C0")))  # of the machine's two rotary axes

    def pieces(self) -> list[Callable[[], None]]:
        """Vectors, corners and a plane, too."""
        return [*super().pieces(), self.vectors, self.corners, self.swivelled, self.home, self.rows]

    def block(self, *words: str) -> None:
        """A line with a number or none."""
        self.count += 10
        self.lines.append(" ".join([*([f"N{self.count}"] if self.rng.random() < 0.4 else []), *words]))

    def value(self, letter: str, count: int) -> str:
        """A word: X12.5, X=12.5, X=R5, X=R5+2.5, X=IC(..)."""
        how, before = self.rng.random(), self.said.get(letter)
        if how < 0.5:
            return letter + self.plain(count)
        if how < 0.85:
            return f"{letter}={self.plain(count)}"
        if how < 0.92 and before is not None:
            return f"{letter}=IC({self.plain(count - before)})"
        part = self.grid(self.rng.uniform(-9, 9))
        self.r = 10 + (self.r - 9) % 40
        self.lines.append(f"R{self.r}={self.plain(count - part)}")
        return f"{letter}=R{self.r}+{self.plain(part)}" if part >= 0 else f"{letter}=R{self.r}-{self.plain(-part)}"

    def begin(self) -> None:
        self.lines += [self.rng.choice(("%_N_DRAWN_MPF", "; DRAWN")), "DEF INT CNT", "DEF REAL WAY"]
        self.block(*self.rng.sample(["G90", "G17", "G94", "G70" if self.inch else "G71", "G40"], 5))
        tool, rpm = self.rng.randint(1, 20), self.rng.choice((2000, 9000))
        self.block(f"T{tool}" if self.rng.random() < 0.5 else f"T={tool}", "M6")
        self.told.event(Kind.TOOL, tool)
        self.block(
            f"S{rpm}" if self.rng.random() < 0.5 else f"S1={rpm}", "M3", *(["D1"] if self.rng.random() < 0.5 else [])
        )
        self.told.event(Kind.SPINDLE_ON, rpm, "CLW")
        self.block(self.rng.choice(("G64", "SOFT", "G642 FFWON", "CYCLE832(0.01,_ROUGH,1)")))
        self.over(self.somewhere())

    def end(self) -> None:
        self.up()
        self.block("M5")
        self.told.event(Kind.SPINDLE_OFF)
        self.block("M30")

    def write_line(self, to: Point, rapid: bool) -> None:
        code = "G0" if rapid else "G1"
        named = [k for k in "XYZ" if self.said.get(k) != to[k] or self.rng.random() < 0.1]
        axes = [self.value(k, to[k]) for k in named]
        self.said = dict(to)
        if axes:
            words = [] if code == self.motion and self.rng.random() < 0.8 else [code]
            self.block(*words, *axes, *([] if rapid else self.fed_word()))
            self.motion = code

    def fed_word(self) -> list[str]:
        """F where the feed is another, and now and then again."""
        if self.fed and self.rng.random() < 0.9:
            return []
        self.fed = True
        return [f"F{self.feed:g}" if self.rng.random() < 0.6 else f"F={self.feed:g}"]

    def write_arc(self, center: Point, end: Point, turn: float) -> None:
        way = {k: center[k] - self.at[k] for k in "XY"}
        axes = [self.value(k, end[k]) for k in "XYZ" if end[k] != self.at[k] or (k != "Z" and self.rng.random() < 0.5)]
        self.said = dict(end)
        axes = [w for w in axes if "IC" not in w] if any("IC" in w for w in axes) else axes
        missing = [k for k in "XYZ" if end[k] != self.at[k] and not any(w.startswith(k) for w in axes)]
        axes += [f"{k}={self.plain(end[k])}" for k in missing]
        words, how = [], self.rng.random()
        if how < 0.3 and abs(turn) in (90.0, 270.0):
            words = [f"CR={'-' if abs(turn) > 180.0 else ''}{self.plain(max(abs(v) for v in way.values()))}"]
        elif how < 0.5:
            words = [f"{i}=AC({self.plain(center[k])})" for i, k in (("I", "X"), ("J", "Y"))]
        else:
            words = [f"{i}{self.plain(way[k])}" for i, k in (("I", "X"), ("J", "Y")) if way[k]]
        self.block("G3" if turn > 0 else "G2", *axes, *words, *self.fed_word())
        self.motion = "G3" if turn > 0 else "G2"

    def write_coolant(self, on: bool) -> None:
        self.block("M8" if on else "M9")

    def write_dwell(self, seconds: float) -> None:
        self.block(f"G4 F{seconds:g}")

    def write_speed(self, rpm: float) -> None:
        self.block(f"S{rpm:g}", *(["M3"] if self.rng.random() < 0.5 else []))

    def write_halt(self) -> None:
        self.block("M0")

    def again(self) -> None:
        self.over(self.somewhere())
        self.cut(self.near())
        steps, times = self.steps(), self.rng.randint(1, 4)
        steps = [s for s in steps if any(s)]
        body = ["G1 " + " ".join(f"{k}=IC({self.plain(v)})" for k, v in zip("XYZ", s, strict=True) if v) for s in steps]
        which = self.rng.choice(("for", "while", "loop", "goto", "sub", "repeat", "until"))
        self.subs += 1
        if which == "for":
            self.lines += [f"FOR CNT=1 TO {times}", *body, "ENDFOR"]
        elif which == "while":
            self.lines += [
                f"R1={times}",
                "WHILE R1>0",
                "G91",
                *(b.replace("=IC(", "").replace(")", "") for b in body),
                "G90",
                "R1=R1-1",
                "ENDWHILE",
            ]
        elif which == "loop":
            self.lines += [
                "CNT=0",
                "LOOP",
                *body,
                "CNT=CNT+1",
                f"IF CNT=={times} GOTOF OUT{self.subs}",
                "ENDLOOP",
                f"OUT{self.subs}:",
            ]
        elif which == "goto":
            self.lines += ["R2=0", f"AGAIN{self.subs}: R2=R2+1", *body, f"IF R2<{times} GOTOB AGAIN{self.subs}"]
        elif which == "until":
            self.lines += ["R3=0", "REPEAT", *body, "R3=R3+1", f"UNTIL R3>={times}"]
        elif which == "repeat" and times > 1:
            self.lines += [f"PART{self.subs}: {body[0]}", *body[1:], f"REPEAT PART{self.subs} P={times - 1}"]
        else:
            self.lines.append(f"WAY{self.subs}" + (f" P{times}" if times > 1 else ""))
            self.behind += [f"%_N_WAY{self.subs}_SPF", f"PROC WAY{self.subs}", *body, self.rng.choice(("M17", "RET"))]
        self.motion = "G1"
        self.walk(steps, times)
        self.said = {}
        self.up()

    def framed(self) -> None:
        """TRANS or ATRANS, ROT or AROT about the tool, MIRROR, SCALE: one or two on top of each other."""
        matrix, origin = np.eye(3), np.zeros(3)
        for n in range(self.rng.randint(1, 3)):
            kind = self.rng.choice(("TRANS", "TRANS", "ROT", "MIRROR", "SCALE"))
            turn, by, words = np.eye(3), np.zeros(3), ""
            if kind == "TRANS":
                steps = {k: self.grid(self.rng.uniform(-8, 8)) for k in self.rng.sample("XYZ", self.rng.randint(1, 3))}
                by = np.array([self.unit(steps.get(k, 0)) for k in "XYZ"]) * self.mm
                words = " ".join(f"{k}{self.plain(v)}" for k, v in steps.items())
            elif kind == "ROT":
                angle = self.rng.choice((30.0, -45.0, 90.0, 12.5))
                turn, words = about(2, math.radians(angle)), self.rng.choice((f"RPL={angle:g}", f"Z{angle:g}"))
            elif kind == "MIRROR":
                axes = self.rng.choice(("X", "Y", "XY"))
                turn, words = np.diag([-1.0 if k in axes else 1.0 for k in "XYZ"]), " ".join(f"{k}0" for k in axes)
            else:
                factor = self.rng.choice((0.5, 1.25, 2.0))
                turn, words = np.eye(3) * factor, f"X{factor:g} Y{factor:g} Z{factor:g}"
            if n == 0 and self.rng.random() < 0.7:
                matrix, origin = turn, by
                self.block(f"{kind} {words}")
            else:
                matrix, origin = matrix @ turn, origin + matrix @ by
                self.block(f"A{kind} {words}")
        self.use(matrix, origin)
        self.said = {}
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        self.block(self.rng.choice(("TRANS", "ROT", "MIRROR", "SCALE")))
        self.use(np.eye(3), np.zeros(3))
        self.said = {}
        self.over(self.somewhere())

    def swivelled(self) -> None:
        """CYCLE800 axis by axis, and the part's own plane again."""
        mode, order = self.rng.choice(((57, (0, 1, 2)), (39, (2, 1, 0)), (27, (2, 1, 0))))
        order = tuple(((mode >> s) & 3) - 1 for s in (0, 2, 4))
        angles = [self.rng.choice((0.0, 10.0, -15.0, 22.5)) for _ in range(3)]
        first, second = ([self.grid(self.rng.uniform(-9, 9)) for _ in "XYZ"] for _ in range(2))
        numbers = [*(self.plain(v) for v in first), *(f"{v:g}" for v in angles), *(self.plain(v) for v in second)]
        self.up()
        self.block(f'CYCLE800(0,"TC1",100000,{mode},{",".join(numbers)},-1)')
        matrix = np.eye(3)
        for axis, angle in zip(order, angles, strict=True):
            matrix = matrix @ about(axis, math.radians(angle))
        at = np.array([self.unit(v) for v in first]) + matrix @ np.array([self.unit(v) for v in second])
        self.use(matrix, at * self.mm)
        self._placed(matrix[:, 2])
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        if self.rng.random() < 0.7:
            self.block("CYCLE800()")
            self.block("G0", *self.zero)
        else:
            self.block('CYCLE800(0,"TC1",100000,57,0,0,0,0,0,0,0,0,0,-1)')
        self.use(np.eye(3), np.zeros(3))
        self._placed(np.array([0.0, 0.0, 1.0]))

    def _placed(self, axis: np.ndarray) -> None:
        self.told.lose()
        self.told.axis = axis
        self.at, self.said, self.motion = {}, {}, ""
        self.over(self.somewhere())

    def vectors(self) -> None:
        """TRAORI, the tool along vectors: the first one by a rapid, and cuts that keep it."""
        self.up()
        self.block("TRAORI")
        vector = [round(self.rng.uniform(-0.4, 0.4), 6), round(self.rng.uniform(-0.4, 0.4), 6), 1.0]
        spot = self.somewhere()
        self.block(
            "G0",
            *(f"{k}{self.plain(spot[k])}" for k in "XYZ"),
            *(f"{k}={v:g}" for k, v in zip(("A3", "B3", "C3"), vector, strict=True)),
        )
        self.told.axis = np.array(vector) / float(np.linalg.norm(vector))
        self.told.rapid(self.place(spot))
        self.at, self.said, self.motion = dict(spot), dict(spot), "G0"
        for _ in range(self.rng.randint(1, 4)):
            self.cut(self.near())
        self.up()
        self.block("TRAFOOF")
        self.block(self.rng.choice(("G0 SUPA Z300 D0", "SUPA G0 Z300")))
        self.block("G0", "D1", *self.zero)
        self._placed(np.array([0.0, 0.0, 1.0]))

    def home(self) -> None:
        """To a machine position, and back."""
        self.up()
        self.block(self.rng.choice(("G0 SUPA Z400", "G53 G0 Z400", "G0 G153 Z400")))
        self._placed(self.told.axis)

    def corners(self) -> None:
        """RND=, CHR= and CHF= between two straight cuts at right angles."""
        size, sx, sy, corner, end = self.before_corner()
        word = self.rng.choice(("RND", "CHR", "CHF"))
        side = size / math.sqrt(2.0) if word == "CHF" else size
        self.block("G1", f"X{self.plain(corner['X'])}", f"{word}={self.plain(size)}", *self.fed_word())
        self.block(f"Y{self.plain(end['Y'])}")
        self.motion, self.said = "G1", dict(end)
        self.tell_corner(corner, end, side, (sx, sy), word == "RND", self.feed * self.mm)
        self.at = end
        self.up()

    def _cycle(self) -> tuple[str, Callable[[Point], None]]:
        """A drilling cycle's call, and what notes one hole of it."""
        name = self.rng.choice(("CYCLE81", "CYCLE82", "CYCLE85", "CYCLE83"))
        if not self.feed:
            self.new_feed()
        if not self.fed:
            self.block(*self.fed_word())
        surface = self.at["Z"] - self.grid(self.rng.uniform(2, 3))
        gap, level, bottom = (
            self.grid(1),
            surface + self.grid(self.rng.uniform(4, 9)),
            surface - self.grid(self.rng.uniform(3, 9)),
        )
        dwell = 0.5 if name == "CYCLE82" else 0.0
        deep = [self.plain(bottom)] if self.rng.random() < 0.6 else ["", self.plain(surface - bottom)]
        values = [
            self.plain(level),
            self.plain(surface),
            self.plain(gap),
            *deep,
            *[""] * (2 - len(deep)),
            f"{dwell:g}" if dwell else "",
        ]
        into = out = self.feed
        if name == "CYCLE85":
            into, out = (4.0, 6.0) if self.inch else (60.0, 90.0)
            values += [f"{into:g}", f"{out:g}"]
        bite = 0
        if name == "CYCLE83":
            bite = self.grid(self.rng.uniform(1, 2)) if self.rng.random() < 0.6 else 0
            first = self.rng.choice(([self.plain(surface - bite)], ["", self.plain(bite)])) if bite else []
            values[5:] = [*first, *[""] * (2 - len(first)), "0", "", "", "1", "1"]

        def hole(spot: Point) -> None:
            clear = {**spot, "Z": surface + gap}
            self.told.rapid(self.place({**spot, "Z": self.at["Z"]}))
            self.told.rapid(self.place(clear))
            self.told.hole(self.place({**spot, "Z": bottom}), into * self.mm, self.unit(bite) * self.mm)
            if dwell:
                self.told.event(Kind.DWELL, dwell)
            if name == "CYCLE85":
                self.told.cut(self.place(clear), out * self.mm)
            self.told.rapid(self.place({**spot, "Z": level}))
            self.at = {**spot, "Z": level}

        while values and not values[-1]:
            values.pop()
        return f"{name}({','.join(values)})", hole

    def holes(self) -> None:
        """A cycle in each block, or MCALL and places."""
        self.over(self.somewhere())
        call, hole = self._cycle()
        modal = self.rng.random() < 0.5
        if modal:
            self.block("MCALL", call)
        for _ in range(self.rng.randint(1, 3)):
            spot = {**self.near(), "Z": self.at["Z"]}
            words = [f"{k}{self.plain(spot[k])}" for k in "XY"]
            self.block("G0", *words)
            self.motion = "G0"
            if not modal:
                self.block(call)
            hole(spot)
        if modal:
            self.block("MCALL")
        self.said = {}
        self.up()

    def rows(self) -> None:
        """HOLES1 and HOLES2 behind MCALL."""
        self.over(self.somewhere())
        call, hole = self._cycle()
        self.block("MCALL", call)
        x, y, n = self.grid(self.rng.uniform(-9, 9)), self.grid(self.rng.uniform(-9, 9)), self.rng.randint(1, 5)
        angle = self.rng.choice((0.0, 30.0, -75.0))
        a, b = self.grid(self.rng.uniform(3, 9)), self.grid(self.rng.uniform(3, 9))
        ray = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        if self.rng.random() < 0.5:
            self.block(f"HOLES1({self.plain(x)},{self.plain(y)},{angle:g},{self.plain(a)},{self.plain(b)},{n})")
            spots = [np.array([x, y]) + (a + b * k) * ray for k in range(n)]
        else:
            self.block(f"HOLES2({self.plain(x)},{self.plain(y)},{self.plain(a)},{angle:g},0,{n})")
            turns = [math.radians(angle) + math.tau * k / n for k in range(n)]
            spots = [np.array([x, y]) + a * np.array([math.cos(t), math.sin(t)]) for t in turns]
        for u, v in spots:
            hole({"X": float(u), "Y": float(v), "Z": self.at["Z"]})  # type: ignore[typeddict-item]
        self.block("MCALL")
        self.at, self.said = {}, {}
        self.over(self.somewhere())
