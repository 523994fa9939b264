"""Small stories of a CL file and of a program, by hand: both sides of the witness's rules, in mm, degrees and mm/min."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camrob.units import deg_to_rad, mm_min_to_m_s, mm_to_m
from camrob.witness.happenings import Event, Gap, Kind, Load, Path, Pecks, Run, Story, Way
from camrob.witness.rules.rules import Comparison, Terms, compare

__all__ = ["FEED", "HOME", "RAPID", "circ", "feed", "file", "hole", "judged", "lin", "load", "program", "ptp", "rapid"]

UP = (0.0, 0.0, 1.0)
FEED, RAPID = 600.0, 6000.0
HOME = (500.0, 0.0, 900.0)
ON, OFF = (Kind.SPINDLE_ON, 3000.0, "CLW"), (Kind.SPINDLE_OFF, 0.0, "")


def rapid(*tip, axis=UP, joined=True, begins=False):
    """begins: another operation."""
    return {"tip": tip, "axis": axis, "way": Way.RAPID, "feed": math.nan, "joined": joined, "begins": begins}


def feed(*tip, axis=UP, at=FEED, center=None, turn=0.0, normal=UP, joined=True):
    """A cut; with `center`, an arc of `turn` degrees about `normal`."""
    arc = {"center": center, "turn": turn, "normal": normal} if center else {}
    return {"tip": tip, "axis": axis, "way": Way.FEED, "feed": at, "joined": joined, **arc}


def hole(*tip, at=FEED, pecks=None):
    """pecks: how far the first may go from where the motion starts, and every other one, mm; out of the hole between them?"""
    return {"tip": tip, "axis": UP, "way": Way.HOLE, "feed": at, "joined": True, "pecks": pecks}


def lin(*tip, axis=UP, at=FEED, tool=0):
    return {"tip": tip, "axis": axis, "speed": at, "tool": tool}


def circ(*tip, center, turn, normal=UP, axis=UP, at=FEED):
    return {"tip": tip, "axis": axis, "speed": at, "center": center, "turn": turn, "normal": normal}


def ptp(*tip, axis=UP):
    """Point to point; to HOME where no place is given."""
    return {"tip": tip or HOME, "axis": axis, "speed": math.nan, "ptp": True, "home": not tip}


def _split(rows: Sequence) -> tuple[list[dict], list[Event], list[Gap]]:
    """Motions, the events between them as (kind, value, text), and "gap"."""
    motions: list[dict] = []
    events: list[Event] = []
    gaps: list[Gap] = []
    for line, row in enumerate(rows, start=1):
        if isinstance(row, dict):
            motions.append({**row, "line": line})
        elif row == "gap":
            gaps.append(Gap(len(motions), line, line, "NURBS"))
        else:
            events.append(Event(len(motions), row[0], *row[1:], line=line))
    return motions, events, gaps


def _path(motions: list[dict]) -> Path:
    zero = (0.0, 0.0, 0.0)
    axes = np.array([m["axis"] for m in motions], dtype=float)
    return Path(
        mm_to_m(np.array([m["tip"] for m in motions], dtype=float)),
        axes / np.linalg.norm(axes, axis=1)[:, None],
        mm_to_m(np.array([m.get("center", zero) for m in motions], dtype=float)),
        np.array([m.get("normal", UP) for m in motions], dtype=float),
        np.array([deg_to_rad(m["turn"]) if m.get("center") else math.nan for m in motions]),
        np.array([m["line"] for m in motions]),
    )


def file(*rows) -> Story:
    motions, events, gaps = _split(rows)
    joined = np.array([m["joined"] for m in motions])
    joined[[0, *(gap.before for gap in gaps if gap.before < len(motions))]] = False
    return Story(
        _path(motions),
        np.array([m["way"] for m in motions], dtype=np.int8),
        mm_min_to_m_s(np.array([m["feed"] for m in motions])),
        joined,
        np.cumsum([m.get("begins", False) for m in motions], dtype=np.int32),
        tuple(events),
        tuple(gaps),
        pecks={
            k: Pecks(*mm_to_m(np.array(m["pecks"][:2])).tolist(), m["pecks"][2])
            for k, m in enumerate(motions)
            if m.get("pecks")
        },
    )


def load(mass, *center, more=(0.0,) * 6):
    """`$LOAD`; of no mass, the controller's own again."""
    return {"load": None if mass is None else (mass, *center, *more)}


def program(*rows) -> Run:
    """The rows as they are; no HOME is added."""
    loads, kept = [], []
    for line, row in enumerate(rows, start=1):
        if isinstance(row, dict) and "load" in row:
            loads.append(Load(sum(isinstance(one, dict) for one in kept), row["load"], line))
        else:
            kept.append(row)
    motions, events, gaps = _split(kept)
    return Run(
        _path(motions),
        np.array([m.get("ptp", False) for m in motions]),
        mm_min_to_m_s(np.array([m["speed"] for m in motions])),
        np.array([m.get("exact", True) for m in motions]),
        np.array([m.get("tool", 0) for m in motions], dtype=np.int32),
        (TOOL, OTHER_TOOL),
        np.array([[0.0 if m.get("home") else m.get("a1", 50.0), 0.0] for m in motions]),
        ("A1", "E1"),
        np.zeros(len(motions), np.int32),
        ("part.src",),
        tuple(events),
        tuple(gaps),
        loads=tuple(loads),
    )


TOOL, OTHER_TOOL = np.eye(4), np.eye(4)
TOOL[2, 3], OTHER_TOOL[2, 3] = 0.1, 0.2


def judged(story: Story, run: Run, **terms) -> Comparison:
    """Compared with the part's frame in `base`, one tool, HOME at A1 = 0."""
    known = {
        "base_T_part": np.eye(4),
        "tools": {0: TOOL},
        "home": np.zeros(2),
        "endless": np.zeros(2, bool),
        "rapid": float(mm_min_to_m_s(RAPID)),
    }
    return compare(story, run, Terms(**{**known, **terms}))
