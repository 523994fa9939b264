"""What is true of a case: causes, places, sizes, what correcting each would remove, which names its logs can't tell apart."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from gap.ninth_author.arms import CELLS
from gap.ninth_author.case import PLACE, Case, size_mm
from gap.ninth_author.kinds import MOST, NAMED
from gap.ninth_author.shift import nominal, observed, rms, unabsorbed

__all__ = ["GENERATOR", "alike", "digest", "generator_digest", "label", "line"]

FOLDER = Path(__file__).parent
GENERATOR = (
    "arms",
    "body_causes",
    "case",
    "draws",
    "drive_causes",
    "kinds",
    "label",
    "looks",
    "machines",
    "paths",
    "plan",
    "shift",
)


def digest(text: str) -> str:
    """Its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


def generator_digest() -> str:
    """One digest of the modules that make cases and labels, and of the shipped cells that they read."""
    files = [FOLDER / f"{name}.py" for name in GENERATOR]
    files += [CELLS / name / "cell.toml" for name in ("kr15_track_table", "kr500_afp", "rx160_tracker")]
    return digest("".join(f"{file.name} {digest(file.read_text())}\n" for file in files))


def _short(x: float) -> float:
    return float(f"{x:.3g}")


def _pattern(case: Case, runs, shift, latency) -> np.ndarray:
    """What a log shows of a shift: at the tool, less what is fitted besides, and at the encoders as mm at the tool."""
    out = []
    for run in runs:
        tip, encoders, told = observed(run, [shift(run)], case.how["frame"], PLACE)
        q = run.q[run.pick]
        here = nominal(run, "world")[:, :3, 3]
        drive = nominal(run, "world", q + encoders - told)[:, :3, 3] - here
        out.append(drive.ravel())
        if run.kind != "drives":
            d = tip[:, :3, 3] - nominal(run, case.how["frame"], told)[:, :3, 3]
            out.append(unabsorbed(run, d, case.how, latency).ravel())
    return np.concatenate(out)


def _possible(case: Case, name: str) -> bool:
    """Whether a name can be said of such logs at all."""
    how, names, log = case.how, case.arm.names, case.plan["log"]
    kind = log if log in ("poses", "drives") else "path"
    rules = {
        "track": "E1" in names,
        "frame_table": how["frame"] == "base",
        "turntable": how["frame"] == "base",
        "frame_base": not how["unknown_frame"],
        "frame_tool": not how["unknown_target"],
        "cutting_force": any(run.force.any() for run in case.runs),
        "latency": kind == "path",
    }
    return rules.get(name, True) and kind in NAMED[name].logs


def alike(case: Case, cause) -> list:
    """Names whose patterns make the cause's own with a correlation above 0.99, after what is fitted besides."""
    runs = [replace(r, pick=r.pick if r.kind == "poses" else r.pick[::4]) for r in case.runs]
    latency = cause.name != "latency"
    v = _pattern(case, runs, cause.shift, latency)
    out = []
    for name, kind in NAMED.items():
        if name == cause.name or not _possible(case, name) or not np.linalg.norm(v):
            continue
        keys = kind.keys(case.arm, case.runs[-1].kind)
        makers = [partial(kind.make, key=key, s=0.1 * MOST[name]) for key in keys]
        columns = [_pattern(case, runs, make, latency) for make in makers]
        columns = [c / np.linalg.norm(c) for c in columns if np.linalg.norm(c) > 1e-9]
        if not columns:
            continue
        a = np.stack(columns, 1)
        left = v - a @ np.linalg.lstsq(a, v, rcond=1e-6)[0]
        if np.sqrt(max(0.0, 1 - (left @ left) / (v @ v))) > 0.99:
            out.append(name)
    return out


def label(case: Case, look=True) -> dict:
    """The label; without `look` what it is like is left out (that takes longest)."""
    last, noise = case.runs[-1], case.noise(len(case.runs) - 1)

    late = "latency" in case.plan["causes"]  # then it is a part of the gap, and not fitted besides

    def gap(shifts):
        return rms(unabsorbed(last, case.off(last, shifts, absorb=False) + noise, case.how, not late))

    whole, causes = gap(case.shifts(last)), {}
    for cause in case.causes:
        without = gap(case.shifts(last, cause.name))
        mm = size_mm(case, cause)
        causes[cause.name] = {
            "axes": cause.axes,
            "stage": cause.kind.stage,
            "follows": list(cause.kind.follows),
            "mm": _short(mm),
            "raw_mm": _short(rms(case.off(last, [cause.shift(last)], absorb=False))),
            "ratio": _short(mm / case.floor_mm),
            "removable": round(1 - without / whole, 3),
            "alike": alike(case, cause) if look and cause.name in NAMED else [],
            "deed": cause.kind.deed,
        }
    mended = gap([case.leftover(last)] if case.left else [])
    return {
        "number": case.number,
        **{k: case.plan[k] for k in ("kind", "machine", "log", "frame", "correlated")},
        "rows": [len(r.pick) for r in case.runs],
        "noise_mm": _short(case.noise_mm),
        "left_mm": _short(case.left_mm),
        "floor_mm": _short(case.floor_mm),
        "gap_mm": _short(whole),
        "removable": round(1 - mended / whole, 3),
        "causes": causes,
    }


def line(told: dict) -> str:
    """A label as the text that is sealed."""
    return json.dumps(told, sort_keys=True)
