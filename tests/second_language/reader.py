"""Reads programs line by line; shares nothing with the writer."""

from __future__ import annotations

import math

import numpy as np

from camrob.errors import ProgramError
from camrob.findings import Finding
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import FrameKind, ProgramAction, ProgramFrame, ProgramText, Setting

NAN = float("nan")


def read(path):
    return _Reader().whole(path)


class _Reader:
    def __init__(self):
        self.rows, self.actions, self.findings, self.files = [], [], [], []
        self.frames = {"tool": [ProgramFrame(FrameKind.UNKNOWN, np.full(6, NAN), "")], "base": []}
        self.frames["base"] = list(self.frames["tool"])
        self.now = {"tool": 0, "base": 0, "speed": NAN, "wait": 0.0, "acc": NAN, "blend": NAN}
        self.settings, self.words = {}, {}
        self.axes = 0

    def whole(self, path):
        self.file(path, 0)
        columns = list(zip(*self.rows, strict=True)) if self.rows else [[]] * 16
        fit = [np.array(c).reshape(len(self.rows), -1) for c in columns[1:4]]
        one = [np.array(c) for c in columns]
        return ProgramText(
            name=path.stem,
            files=tuple(self.files),
            kind=one[0],
            pose=fit[0],
            axes=fit[1],
            external=fit[2],
            external_names=tuple(f"E{k + 1}" for k in range(self.axes)),
            status=one[4],
            turn=one[5],
            circular_angle_deg=np.full(len(self.rows), NAN),
            speed=one[6],
            acceleration=one[7],
            blend_mm=one[8],
            blend=one[9],
            wait=one[10],
            final_wait=self.now["wait"],
            file=one[11],
            line=one[12],
            tool=one[13],
            base=one[14],
            tools=tuple(self.frames["tool"]),
            bases=tuple(self.frames["base"]),
            actions=tuple(self.actions),
            statements=self.words,
            settings=self.settings,
            findings=tuple(self.findings),
            language="lines",
        )

    def file(self, path, depth):
        try:
            lines = path.read_bytes().decode("ascii").split("\n")
        except (OSError, UnicodeDecodeError) as error:
            raise ProgramError(f"can't be read: {error}", path=path) from None
        index = len(self.files)
        self.files.append(path.name)
        words = [line.split() for line in lines]
        if not words[0][:1] == ["program"] or ["end"] not in words:
            raise ProgramError("has no program and end", hint="the file is damaged", path=path)
        for number, line in enumerate(lines, start=1):
            try:
                if self.line(path, index, number, line, depth):
                    return
            except (ValueError, IndexError):
                raise ProgramError(f"{line[:60]!r} is no Lines", path=path, line=number) from None

    def line(self, path, index, number, line, depth):
        words = line.split()
        if not words or words[0] in ("#", "program") or line.startswith("#"):
            return False
        word, rest = words[0], line.strip()[len(words[0]) :]
        self.words[word] = self.words.get(word, 0) + 1
        if word == "end":
            return True
        if word == "part" and depth < 3:
            beside = path.with_name(words[1] + ".lines")
            self.file(beside, depth + 1)
        elif word == "set":
            self.set(words[1], float(words[2]))
            self.actions.append(ProgramAction(len(self.rows), " ".join(words)))
        elif word in ("tool", "base"):
            follows = word == "base" and words[1] == "follows"
            values = np.array([float(w) for w in words[1 if word == "tool" else 2 :]])
            kind = FrameKind.MECHANISM if follows else FrameKind.LITERAL
            self.frames[word].append(ProgramFrame(kind, values, rest.strip()))
            self.now[word] = len(self.frames[word]) - 1
        elif word == "speed":
            self.now["speed"] = float(words[1])
        elif word in ("axes", "pose", "line", "arc"):
            self.motion(word, rest, index, number)
        elif word == "wait":
            self.now["wait"] += float(words[1])
            self.actions.append(ProgramAction(len(self.rows), " ".join(words)))
        elif word in ("do", "load"):
            self.actions.append(ProgramAction(len(self.rows), " ".join(words)))
        else:
            self.findings.append(Finding("not-understood", f"{line[:60]!r} is not understood", line=number))
        return False

    def set(self, name, value):
        names = {"advance": "advance", "turn": "turn_speed", "turnacc": "turn_acceleration"}
        if name in names:
            self.settings[names[name]] = Setting(name, value)
        elif name in ("acc", "blend"):
            self.now[name] = value

    def motion(self, word, rest, index, number):
        blended = rest.rstrip().endswith("~")
        groups = [[float(w) for w in part.split()] for part in rest.replace("~", "").split("|")]
        if not all(math.isfinite(v) for group in groups for v in group):
            raise ValueError
        status, turn = (int(v) for v in groups[1]) if word == "pose" else (-1, -1)
        kinds = {"axes": [Motion.PTP_AXES], "pose": [Motion.PTP_POSE], "line": [Motion.LIN]}
        targets = [groups[:2]] if word in ("axes", "line") else [[groups[0], groups[-1]]]
        if word == "arc":
            targets = [groups[:2], groups[2:4]]
        for kind, (six, external) in zip(kinds.get(word, [Motion.CIRC_VIA, Motion.CIRC_END]), targets, strict=True):
            if len(six) != 6 or (self.rows and len(external) != self.axes):
                raise ValueError
            self.axes = len(external)
            axes = kind is Motion.PTP_AXES
            blend = Blend.DISTANCE if blended and kind is not Motion.CIRC_VIA else Blend.EXACT
            now = self.now
            speed = now["speed"] if kind >= Motion.LIN else 0.0
            self.rows.append(
                (
                    int(kind),
                    [NAN] * 6 if axes else six,
                    six if axes else [NAN] * 6,
                    external,
                    status,
                    turn,
                    speed,
                    now["acc"],
                    now["blend"],
                    int(blend),
                    now["wait"],
                    index,
                    number,
                    now["tool"],
                    now["base"],
                    0,
                )
            )
            now["wait"] = 0.0
