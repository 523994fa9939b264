"""Where a cause sits that no library knows: `python tests/bench/gap/places.py --out DIR` draws them, asks the diagnosis, counts.

Each cause is written down from physics, on arms multiplied out by hand (`tests/gap/verdict/stranger_arms.py`), beside a smooth
rest of three to five times the noise that no name fits either. Nothing of camrob takes part in the drawing. A place is right
where stage, axis and what it follows all are; what counts as each stands beside the cause. DIR/places.md is the table,
DIR/places.jsonl what was said.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "gap" / "verdict"), str(ROOT / "tests" / "bench")]

from stranger_arms import DEG, KR, TICK, UR, Faults, Machine, columns_of, driven, scattered, text, true_poses  # noqa: E402

from gap.score import share  # noqa: E402

REST, SIGMA, SURE = 5e-5, 1e-5, 0.8
DRIVES, ARM = "setpoint_to_encoder", "encoder_to_tcp"


@dataclass(frozen=True)
class Cause:
    """drive, link (t, commands) -> (N, k) axes beyond their set-points and their encoders, tip (t, commands, poses) -> (N, 3) m;
    poses: measured at rest. rung, axes, follows: what is right; axes () where none may be named.
    """

    rung: str
    axes: tuple[str, ...]
    follows: tuple[str, ...]
    drive: Callable | None = None
    link: Callable | None = None
    tip: Callable | None = None
    poses: bool = False


def of_axis(k: int, value: Callable) -> Callable:
    """One axis's shift, (N,) of time and of all axes' values and speeds."""

    def shift(t, u):
        out = np.zeros_like(u)
        out[:, k] = value(t, u, np.gradient(u, t, axis=0) if t[1] - t[0] < 1.0 else np.zeros_like(u))
        return out

    return shift


def ringing(signal: np.ndarray, hertz: float, damping: float) -> np.ndarray:
    """What a spring with little damping makes of an acceleration, (N,)."""
    w, x, v, out = 2 * np.pi * hertz, 0.0, 0.0, np.empty_like(signal)
    for i, a in enumerate(signal):
        v += TICK * (-(w**2) * x - 2 * damping * w * v - a)
        x += TICK * v
        out[i] = x
    return out


def creeping(load: np.ndarray, seconds: float) -> np.ndarray:
    """What gives way slowly, (N,)."""
    out, at = np.empty_like(load), load[0]
    for i, x in enumerate(load):
        at += TICK / seconds * (x - at)
        out[i] = at
    return out


def causes(m: Machine) -> dict[str, Cause]:
    """All causes on an arm."""
    home, slide = m.home, np.array([0.0, 1.0, 0.0])
    found = {
        "a counterweight's spring at A2, poses": Cause(
            ARM,
            ("A2",),
            ("position", "load"),
            poses=True,
            link=of_axis(1, lambda t, u, v: 3e-3 * np.maximum(u[:, 1] - home[1], 0.0) ** 2),
        ),
        "a counterweight's spring at A2": Cause(
            ARM,
            ("A2",),
            ("position", "load"),
            link=of_axis(1, lambda t, u, v: 4e-3 * np.maximum(u[:, 1] - home[1], 0.0) ** 2),
        ),
        "A3 slips once, poses": Cause(
            ARM, ("A3",), ("time",), poses=True, link=of_axis(2, lambda t, u, v: 0.05 * DEG * (t > t[len(t) // 2]))
        ),
        "A3 slips once": Cause(ARM, ("A3",), ("time",), link=of_axis(2, lambda t, u, v: 0.04 * DEG * (t > 17.0))),
        "A2 creeps under its load": Cause(
            ARM,
            ("A2",),
            ("load", "position", "time"),
            link=of_axis(1, lambda t, u, v: 5e-4 * creeping(np.cos(u[:, 1]), 4.0)),
        ),
        "A1 lags in its gear as it turns": Cause(
            ARM, ("A1",), ("speed",), link=of_axis(0, lambda t, u, v: -1.5e-3 * v[:, 0])
        ),
        "A6 throws its tool out": Cause(
            ARM,
            ("A6", "A5", "A4"),
            ("speed", "acceleration"),
            link=of_axis(4, lambda t, u, v: 3e-4 * v[:, 5] ** 2),
        ),
        "A1 rings": Cause(
            ARM,
            ("A1",),
            ("acceleration", "speed", "direction", "time"),
            link=of_axis(
                0, lambda t, u, v: ringing(np.gradient(v[:, 0], t) * (1 + (np.abs(v[:, 0]) < 0.02) * 9), 3.0, 0.02)
            ),
        ),
        "a hose pulls at A5 as A4 turns": Cause(
            ARM,
            ("A5", "A4"),
            ("position",),
            link=of_axis(4, lambda t, u, v: 8e-4 * np.tanh(4 * (u[:, 3] - home[3])) ** 3),
        ),
        "the hall sways": Cause(
            ARM, (), ("time",), tip=lambda t, u, T: 2e-4 * np.sin(2 * np.pi * t / 1.7)[:, None] * (0.6, 0.8, 0.0)
        ),
        "the instrument's stand settles": Cause(
            ARM,
            (),
            ("time",),
            poses=True,
            tip=lambda t, u, T: 3e-4 * np.tanh((t - 300) / 60)[:, None] * (0.6, 0.0, 0.8),
        ),
        "A1's drive is short of voltage": Cause(
            DRIVES,
            ("A1",),
            ("speed",),
            drive=of_axis(0, lambda t, u, v: -4e-3 * v[:, 0] * np.abs(v[:, 0])),
        ),
        "A5's cable drags": Cause(
            DRIVES, ("A5",), ("position",), drive=of_axis(4, lambda t, u, v: 8e-4 * np.tanh(5 * (u[:, 4] - home[4])))
        ),
        "A3's brake drags from some time on": Cause(
            DRIVES,
            ("A3",),
            ("time", "direction", "speed"),
            drive=of_axis(2, lambda t, u, v: -5e-4 * np.tanh(v[:, 2] / 0.02) * (t > 15)),
        ),
    }
    if m.track is not None:
        found["a rack's pitch on E1"] = Cause(
            ARM,
            ("E1",),
            ("position",),
            tip=lambda t, u, T: 1.5e-4 * np.sin(2 * np.pi * u[:, 6] / 0.05)[:, None] * slide,
        )
        found["E1's carriage tips where it brakes"] = Cause(
            ARM,
            ("E1",),
            ("acceleration",),
            tip=lambda t, u, T: -8e-4 * np.gradient(np.gradient(u[:, 6], t), t)[:, None] * (0.0, 0.0, 1.0),
        )
    return found


def logged(m: Machine, cause: Cause, seed: int) -> tuple[str, str]:
    """A log's CSV and TOML."""
    if cause.poses:
        command, t = scattered(m, 70, seed), np.arange(70) * 12.0
    else:
        t, command = driven(m, 35.0, seed)
    reached = command if cause.drive is None else command + cause.drive(t, command)
    link = reached if cause.link is None else reached + cause.link(t, reached)
    T = true_poses(m, link, Faults(rest=REST), seed)
    if cause.tip is not None:
        T[:, :3, 3] += cause.tip(t, reached, T)
    rows = np.arange(len(t)) if cause.poses else np.arange(50, len(t) - 10, 8)
    setpoint = None if cause.poses else command[rows]
    columns = columns_of(m, t[rows], reached[rows], T[rows], setpoint=setpoint, sigma=SIGMA, seed=seed)
    return text(columns), "sigma_mm = 0.01\nsigma_deg = 0.002\n" + ("poses = true\n" if cause.poses else "")


def asked(m: Machine, cause: Cause, seed: int) -> dict:
    """What the diagnosis says."""
    from camrob.cell.read_cell import read_cell
    from camrob.gap.diagnose import diagnose
    from camrob.measurement.read_log import read_log

    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log.csv"
        csv, toml = logged(m, cause, seed)
        log.write_text(csv)
        log.with_suffix(".toml").write_text(toml)
        cell = ROOT / "cells" / "kr15_track_table"
        if m.cell:
            cell = Path(folder) / "cell"
            cell.mkdir()
            (cell / "cell.toml").write_text(m.cell)
        begin = time.process_time()
        found = diagnose([read_log(log)], read_cell(cell)).summary.to_json()
    claims = [e for e in found["effects"] if e["probability"] >= 0.5]
    where = found["unknown"]["where"]
    # as the page's charts have them: what is claimed first
    return {
        "status": found["status"],
        "unknown": found["unknown"]["probability"],
        "rung": where["rung"] or _stage(claims),
        "axes": [*(a for e in claims for a in e["axes"]), *where["axes"]],
        "follows": [*(r for e in claims for r in e["regimes"]), *where["regimes"]],
        "comes_back": where["comes_back"],
        "claims": {e["effect"]: e["probability"] for e in claims},
        "seconds": time.process_time() - begin,
    }


def _stage(claims: list[dict]) -> str | None:
    """The stage of what is claimed first."""
    return claims[0]["rungs"][0] if claims else None


def judged(cause: Cause, said: dict) -> dict[str, bool]:
    """What of it is right."""
    stage = said["rung"] == cause.rung
    axis = said["axes"][0] in cause.axes if cause.axes and said["axes"] else not cause.axes and not said["axes"]
    follows = bool(said["follows"]) and said["follows"][0] in cause.follows
    return {
        "flagged": said["unknown"] >= 0.5,
        "stage": stage,
        "axis": axis,
        "follows": follows,
        "place": stage and axis and follows,
        "sure name": any(p > SURE for p in said["claims"].values()),
    }


def main() -> None:
    """Ask, and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[3])
    parser.add_argument("--only", default="", help="words of the cases to run")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in arguments.seeds:
        for who, m in (("ur", UR), ("kr", KR)):
            for name, cause in causes(m).items():
                if arguments.only in f"{who}: {name}":
                    said = asked(m, cause, seed)
                    rows.append({"case": f"{who}: {name}", "seed": seed, **judged(cause, said), "said": said})
                    sys.stderr.write(json.dumps(rows[-1], default=float) + "\n")
    (arguments.out / "places.jsonl").write_text("".join(json.dumps(r, default=float) + "\n" for r in rows))
    (arguments.out / "places.md").write_text("\n".join(table(rows)) + "\n")


def table(rows: list[dict]) -> list[str]:
    """A row a case, and all, with 95 % intervals (Wilson)."""
    kinds = ("flagged", "stage", "axis", "follows", "place", "sure name")
    lines = ["| cause | " + " | ".join(kinds) + " | said |", "| --- |" + " --- |" * (len(kinds) + 1)]
    for r in rows:
        said = r["said"]
        told = ", ".join(filter(None, [*said["axes"], *said["follows"][:1], said["comes_back"]]))
        claims = ", ".join(f"{n} {p:.2f}" for n, p in said["claims"].items())
        marks = " | ".join("yes" if r[k] else "no" for k in kinds)
        lines.append(f"| {r['case']} | {marks} | {told}{'; ' + claims if claims else ''} |")
    totals = []
    for k in kinds:
        record = share(sum(r[k] for r in rows), len(rows))
        low, high = record["interval"]
        totals.append(f"{record['hits']} of {record['count']} ({100 * low:.0f} to {100 * high:.0f} %)")
    return [*lines, "| all | " + " | ".join(totals) + " | |"]


if __name__ == "__main__":
    main()
