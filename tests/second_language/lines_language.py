"""The language behind the protocol."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from camrob.errors import CellError, ProgramError
from camrob.program.language import MeantActions
from camrob.program.motion import Turning
from camrob.program.program import ProgramEventKind
from camrob.program.program_text import ProgramAction
from second_language import reader, writer

__all__ = ["LANGUAGE", "Lines"]


def rounded(values, decimals):
    return np.round(np.asarray(values, float), decimals) + 0.0


class _Rounding:
    def axes(self, axes):
        return rounded(axes, 5)

    def external(self, external):
        return rounded(external, 5)

    def frame(self, xyzabc):
        return rounded(xyzabc, 5)

    def load(self, load):
        return rounded(load, 4)

    def pose(self, pose, external):
        return rounded(pose, 5), rounded(external, 5)

    def speed(self, speed):
        return rounded(speed, 7)


def said(lines):
    """What lines of a hook say, one statement each."""
    return [" ".join(line.split()) for line in lines if line.split()]


@dataclass(frozen=True)
class Lines:
    name: str = "lines"
    title: str = "Lines"
    suffixes: tuple = (".lines",)
    turning: Turning = Turning.SIGNS
    stops: bool = True
    naming: str = "letters and digits, 40 at most"
    round: _Rounding = field(default_factory=_Rounding)

    def program_name(self, text):
        return re.sub(r"[^A-Za-z0-9]+", "", text.encode("ascii", "ignore").decode())[:40] or "program"

    def settings(self, controller, *, follows_table, home=None):
        if set(controller.own) - {"remark"}:
            raise CellError(f"controller.{min(controller.own)} is nothing that Lines takes", hint="leave it out")
        for name, lines in controller.hooks.items():
            for line in lines:
                if not re.match(r"(do|wait) ", line):
                    raise CellError(f"hook {name} is no `do` or `wait`", hint="write `do ...`")

    def check(self, program, controller):
        writer.check(program, controller)

    def write(self, program, controller, *, max_lines, findings=None):
        return writer.write(program, self.program_name(program.name), controller, max_lines, findings)

    def upload(self, name, files, controller):
        return ()

    def read(self, path, controller=None):
        return reader.read(path)

    def meant(self, program, controller):
        opening = [
            f"set {name} {value:.6f}"
            for name, value in (
                ("advance", controller.advance),
                ("ptp", controller.ptp_velocity_percent),
                ("acc", controller.acc_cp),
                ("blend", controller.apo_cdis_mm),
                ("turn", controller.vel_ori_deg_s),
                ("turnacc", controller.acc_ori_deg_s2),
            )
        ]
        rest = [(0, line) for line in said(controller.hook_lines("header"))]
        for event in program.events:
            if event.kind is ProgramEventKind.HOOK:
                rest += [(event.motion, line) for line in said(controller.hook_lines(event.text, event.value))]
            elif event.kind is ProgramEventKind.DWELL:
                rest.append((event.motion, f"wait {event.value:.4f}"))
            elif event.kind is ProgramEventKind.LOAD:
                values = " ".join(f"{v:.4f}" for v in program.loads[int(event.value)])
                rest.append((event.motion, f"load {values}"))
        rest += [(len(program), line) for line in said(controller.hook_lines("footer"))]
        return MeantActions(tuple(opening), tuple(ProgramAction(*one) for one in rest))

    def patch(self, text, targets):
        lines = text.split("\n")
        for number, wanted in targets.items():
            parts = lines[number - 1].split("|")
            word, at = parts[0].split()[0], 0
            if self.targets(lines[number - 1]) != len(wanted):
                raise ProgramError("is no motion with a target", line=number)
            for target in wanted:
                values = " ".join(f"{v:.6f}" for v in target.values)
                parts[at] = f"{word} {values} " if at == 0 else f" {values} "
                at += 2
            lines[number - 1] = "|".join(parts)
        return "\n".join(lines)

    def divide(self, text, targets):
        lines = []
        for number, line in enumerate(text.split("\n"), 1):
            for target in targets.get(number, ()):
                word, said = line.split()[0], line.split("|")[1].split()
                if word != "line":
                    raise ProgramError("is no line that could be divided", line=number)
                values = " ".join(f"{v:.6f}" for v in target.values)
                carried = [f"{v:.5f}" for v in target.external.values()]
                lines.append(f"{word} {values} | {' '.join([*carried, *said[len(carried) :]])}")
            lines.append(line)
        return "\n".join(lines)

    def headed(self, text, comments):
        return text

    def targets(self, statement):
        word = statement.split()[:1]
        return {"axes": 1, "pose": 1, "line": 1, "arc": 2}.get(word[0], 0) if word else 0


LANGUAGE = Lines()
