"""The witness's list of statements for this language: what each does to frames, outputs and motion."""

from __future__ import annotations

import numpy as np

from camrob.errors import ProgramError
from camrob.witness.krl.columns import AXES, CIRC, LIN, POSE
from camrob.witness.krl.conduct import PTP
from camrob.witness.krl.hooks import Hooks
from camrob.witness.krl.replay import replay
from camrob.witness.krl.state import Base, State
from camrob.witness.krl.text import Line

NAN = float("nan")
SETTINGS = {
    "ptp": (PTP,),
    "acc": ("$ACC.CP",),
    "blend": ("$APO.CDIS",),
    "turn": ("$VEL.ORI1", "$VEL.ORI2"),
    "turnacc": ("$ACC.ORI1", "$ACC.ORI2"),
}


def run_program(main, machine):
    """Runs a program with its parts."""
    state = State(machine, Hooks(machine.controller.hooks, "^DO"))
    state.conduct.begun = True
    run_file(main, state)
    state.close_steps()
    motions = state.columns.motions(None)
    stops = np.array([*state.stops, state.count - 1], dtype=np.int64)
    motions.exact[stops[(stops >= 0) & (stops < len(motions))]] = True
    return replay(state, motions)


def run_file(path, state):
    try:
        text = path.read_bytes().decode("ascii")
    except (OSError, UnicodeDecodeError) as error:
        raise ProgramError(f"can't be read: {error}", path=path) from None
    kept, state.file = state.file, len(state.files)
    state.files.append(str(path))
    lines = text.split("\n")
    state.written += len(lines)
    for number, raw in enumerate(lines, start=1):
        code = "" if raw.startswith("#") else " ".join(raw.split())
        if code == "end":
            break
        if code:
            statement(path, state, Line(number, code, "", raw), code.split())
    state.file = kept


def statement(path, state, line, words):
    word, rest = words[0], words[1:]
    state.tick(line)
    try:
        if word == "program":
            return
        if word == "part":
            run_file(path.with_name(rest[0] + ".lines"), state)
        elif word == "set":
            value = float(rest[1])
            if rest[0] == "advance":
                state.rounds = value >= 1.0
            for name in SETTINGS.get(rest[0], ()):
                state.conduct.set(name, value)
        elif word == "tool":
            state.set_tool(tuple(float(v) for v in rest))
        elif word == "load":
            state.set_load(line.number, (*(float(v) for v in rest), *[0.0] * 6))
        elif word == "base":
            state.set_base(Base(tuple(float(v) for v in rest[1:]), rest[0] == "follows"))
        elif word == "speed":
            state.speed = float(rest[0])
        elif word == "wait":
            state.waits(line)
            state.step(line, "wait", value=float(rest[0]))
        elif word == "do":
            state.waits(line)
            state.step(line, "output")
        elif word in ("axes", "pose", "line", "arc"):
            motion(state, line, word)
        else:
            state.unknown(line, "the statement isn't on the list of what is understood")
    except (ValueError, IndexError):
        state.unknown(line, "the statement isn't on the list of what is understood")


def motion(state, line, word):
    groups = [[float(v) for v in part.split()] for part in line.code[len(word) :].replace("~", "").split("|")]
    rounds = line.code.endswith("~") and state.rounds
    how = {"axes": AXES, "pose": POSE, "line": LIN, "arc": CIRC}[word]
    middle = groups[0][:3] if word == "arc" else [NAN] * 3
    six, external = (groups[2], groups[3]) if word == "arc" else (groups[0], groups[-1])
    status, turn = (int(v) for v in groups[1]) if word == "pose" else (-1, -1)
    pose, axes = ([NAN] * 6, [*six, *external]) if how == AXES else (six, [NAN] * 6 + external)
    state.room(1)
    state.close_steps()
    state.moves(line.number, how < LIN, rounds)
    speed = state.speed if how >= LIN else NAN
    single = (how, pose, middle, NAN, axes, status, turn, state.base, state.tool, False, speed, not rounds)
    state.columns.add((*single, line.number, state.file))
    state.external = list(external)
    state.arrived()
