"""Closed forms and time-optimal feed beside other people's: the tables that `bench_peers.py` adds to that of the solvers."""

from __future__ import annotations

import subprocess
from pathlib import Path
from time import thread_time

import numpy as np

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.kinematics.arm import Arm
from camrob.kinematics.spherical_wrist import BRANCH_OK, SphericalArm, solve_arm_many
from camrob.se3 import inverse
from camrob.timing.path_spline import MotionBounds, interpolated, speed_caps, spline_at
from camrob.timing.reachability import fastest_squares

__all__ = ["CLOSED_FORMS", "FEEDS", "closed_form_table", "feed_table"]

CLOSED_FORMS, FEEDS = ("eaik", "ssik"), ("copp",)
_SAME = 1e-4  # rad: nearer postures are one
_EXACT = 1e-6  # m and rad: a posture that misses its pose by more is none
_SEED, _ANYWHERE = 0, 2000  # of postures drawn anywhere
_FINER = 10  # times finer: the grid that a profile is judged on
_SPANS = (200, 1000, 5000)
_REPEATS = 5


def told_by(python: Path, script: str, *arguments: object) -> dict[str, np.ndarray] | str:
    """What a script beside this one wrote to its last argument, or why there is nothing."""
    command = [python, Path(__file__).with_name(script), *arguments]
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600)
    if done.returncode:
        return "fails: " + (done.stderr.strip().splitlines() or ["no word"])[-1][:100]
    return dict(np.load(str(arguments[-1])))


def closed_form_table(cell: Cell, postures: np.ndarray, pythons: dict[str, Path | str], folder: Path) -> str:
    """Markdown: postures found and missed, errors, time; on the arm's own poses along a path (N, n), track, table and roll held
    as they stand there, and on poses of postures drawn anywhere within limits.
    """
    arm = Arm.of(cell)
    closed = arm.closed
    assert closed is not None
    rng = np.random.default_rng(_SEED)
    own = postures[:, cell.arm_slice]
    drawn = rng.uniform(arm.lower, arm.upper, (_ANYWHERE, 6))
    lines = [
        "| closed form | version | poses | postures found | missed | wrong | error um, urad | us a pose |",
        "|---" * 8 + "|",
    ]
    for where, made_from in (("along the path", own), ("anywhere", drawn)):
        poses = _poses(closed, made_from)
        found: dict[str, np.ndarray | str] = {}
        said: dict[str, tuple[str, float]] = {}
        Q, seconds = _ours(closed, poses)
        found["camrob"], said["camrob"] = Q, ("", seconds)
        file = folder / "arm.npz"
        R0 = _poses(closed, np.zeros((1, 6)))[0, :3, :3]
        bare = poses.copy()
        bare[:, :3, :3] = poses[:, :3, :3] @ R0.T
        ways = np.diff(np.vstack([np.zeros(3), closed.o, _poses(closed, np.zeros((1, 6)))[0, :3, 3]]), axis=0)
        np.savez(file, H=closed.h, P=ways, poses=bare)
        for peer, python in pythons.items():
            out = folder / f"{peer}.npz"
            told = python if isinstance(python, str) else told_by(python, "peer_closed_forms.py", peer, file, out)
            if isinstance(told, str):
                found[peer] = told
            else:
                found[peer], said[peer] = told["Q"], (str(told["version"]), float(told["seconds"]))
        exact = {name: _exact(closed, poses, Q) for name, Q in found.items() if not isinstance(Q, str)}
        for name, Q in found.items():
            if isinstance(Q, str):
                lines.append(f"| {name} | {Q} |" + " |" * 6)
                continue
            others = [exact[other][0] for other in exact if other != name]
            mine, error, wrong = exact[name]
            missed = sum(_missed(mine[k], [o[k] for o in others], made_from[k]) for k in range(len(poses)))
            count = sum(len(m) for m in mine)
            lines.append(
                f"| {name} | {said[name][0]} | {len(poses)} {where} | {count} | {missed} | {wrong} | {1e6 * error:.2g} | "
                f"{1e6 * said[name][1] / len(poses):.2f} |"
            )
    return "\n".join(lines) + "\n"


def _poses(arm: SphericalArm, q: np.ndarray) -> np.ndarray:
    """Of the tool (N, 4, 4), seen from the foot, by the product of exponentials: nobody's closed form."""
    T = np.tile(inverse(np.asarray(arm.tool_T_foot)), (len(q), 1, 1))
    for i in range(5, -1, -1):
        h, o = arm.h[i], arm.o[i]
        K = np.array([[0.0, -h[2], h[1]], [h[2], 0.0, -h[0]], [-h[1], h[0], 0.0]])
        s, c = np.sin(q[:, i])[:, None, None], np.cos(q[:, i])[:, None, None]
        R = np.eye(3) + s * K + (1.0 - c) * (K @ K)
        T[:, :3, 3] = np.einsum("nij,nj->ni", R, T[:, :3, 3] - o) + o
        T[:, :3, :3] = R @ T[:, :3, :3]
    return T


def _ours(arm: SphericalArm, poses: np.ndarray) -> tuple[np.ndarray, float]:
    near = np.zeros((len(poses), 6))
    least = np.inf
    for _again in range(_REPEATS):
        begin = thread_time()
        Q, why = solve_arm_many(arm, poses, near)
        least = min(least, thread_time() - begin)
    return np.where((why == BRANCH_OK)[..., None], Q, np.nan), least


def _exact(arm: SphericalArm, poses: np.ndarray, Q: np.ndarray) -> tuple[list[np.ndarray], float, int]:
    """Postures of each pose that meet it, each once; the largest error among them, m or rad; and how many don't meet it."""
    N, B, _six = Q.shape
    T = _poses(arm, np.nan_to_num(Q).reshape(-1, 6)).reshape(N, B, 4, 4)
    off = np.abs(T - poses[:, None]).max(axis=(2, 3))
    there = ~np.isnan(Q[..., 0])
    good = there & (off < _EXACT)
    kept = []
    for k in range(N):
        own: list[np.ndarray] = []
        for q in Q[k, good[k]]:
            if not _has(own, q):
                own.append(q)
        kept.append(np.array(own).reshape(-1, 6))
    return kept, float(off[good].max(initial=0.0)), int((there & ~good).sum())


def _has(some: list[np.ndarray] | np.ndarray, q: np.ndarray) -> bool:
    return any(np.abs((p - q + np.pi) % (2.0 * np.pi) - np.pi).max() < _SAME for p in some)


def _missed(mine: np.ndarray, others: list[np.ndarray], made_from: np.ndarray) -> int:
    """How many postures anybody else has, or the pose was made from, that are not among `mine`."""
    lost: list[np.ndarray] = []
    for q in [made_from, *(q for some in others for q in some)]:
        if not _has(mine, q) and not _has(lost, q):
            lost.append(q)
    return len(lost)


def feed_table(python: Path | str, folder: Path) -> str:
    """Markdown: the time of a profile by COPP and by camrob on the same spline, bounds and stations; how far it passes speed and
    acceleration on a ten times finer grid; and its time once slowed evenly until it passes neither.
    """
    lines = ["| feed | version | spans | time s | passes by % | slowed s | us a span |", "|---" * 7 + "|"]
    for spans in _SPANS:
        control, bounds, h = _wave(spans)
        least = np.inf
        for _again in range(_REPEATS):
            begin = thread_time()
            x = fastest_squares(control, h, speed_caps(control, h, np.full(spans, 10.0), bounds), bounds, 0.0, 0.0)
            least = min(least, thread_time() - begin)
        lines.append(_feed_row("camrob, speed and acceleration", "", control, h, x, bounds, least))
        if isinstance(python, str):
            lines.append(f"| copp | {python} |" + " |" * 5)
            continue
        knots = [_derivative(control, h, 1, order) for order in range(3)]
        names = dict(zip(("q", "dq", "ddq"), knots, strict=True))
        file, out = folder / "feed.npz", folder / "fed.npz"
        np.savez(file, s=h * np.arange(spans + 1), speed=bounds.speed, acceleration=bounds.acceleration, **names)
        told = told_by(python, "peer_feed.py", file, out)
        if isinstance(told, str):
            lines.append(f"| copp | {told} |" + " |" * 5)
        else:
            lines.append(_feed_row("copp", str(told["version"]), control, h, told["a"], bounds, float(told["seconds"])))
    return "\n".join(lines) + "\n"


def _wave(spans: int) -> tuple[np.ndarray, MotionBounds, float]:
    """The winding path of six axes of `bench_feed.py`, its bounds, and the length of a span."""
    s = np.linspace(0.0, 1.0, spans + 1)
    q = np.column_stack([0.5 * np.sin((3 + k) * s + k) + 0.2 * np.cos(7 * s * (k + 1)) for k in range(6)])
    bounds = MotionBounds(np.inf, np.inf, np.inf, np.full(6, 1.0), np.full(6, 2.0), np.full(6, np.inf))
    return interpolated(np.hstack([np.zeros((spans + 1, 6)), q]), 1.0 / spans), bounds, 1.0 / spans


@kernel
def _along(control: np.ndarray, h: float, parts: int, order: int, out: np.ndarray) -> None:
    for i in range(control.shape[0] - 3):
        for p in range(parts + (1 if i == control.shape[0] - 4 else 0)):
            spline_at(control, h, i, p / parts, order, out[i * parts + p])


def _derivative(control: np.ndarray, h: float, parts: int, order: int) -> np.ndarray:
    out = np.empty(((len(control) - 3) * parts + 1, control.shape[1]))
    _along(control, h, parts, order, out)
    return out[:, 6:]


def _feed_row(
    name: str, told: str, control: np.ndarray, h: float, x: np.ndarray, bounds: MotionBounds, seconds: float
) -> str:
    spans = len(x) - 1
    v = np.sqrt(np.maximum(x, 0.0))
    time = float(np.sum(2.0 * h / np.maximum(v[1:] + v[:-1], 1e-12)))
    share = np.arange(_FINER) / _FINER
    fine = np.append((x[:-1, None] * (1.0 - share) + x[1:, None] * share).ravel(), x[-1])
    push = np.append(np.repeat(np.diff(x) / (2.0 * h), _FINER), (x[-1] - x[-2]) / (2.0 * h))
    one, two = _derivative(control, h, _FINER, 1), _derivative(control, h, _FINER, 2)
    speed = np.max(np.abs(one) * np.sqrt(np.maximum(fine, 0.0))[:, None] / bounds.speed)
    acceleration = np.max(np.abs(one * push[:, None] + two * fine[:, None]) / bounds.acceleration)
    slower = max(1.0, speed, np.sqrt(acceleration))
    passes = max(speed, acceleration) - 1.0
    return (
        f"| {name} | {told} | {spans} | {time:.5f} | {100 * max(passes, 0.0):.4f} | {time * slower:.5f} | "
        f"{1e6 * seconds / spans:.2f} |"
    )
