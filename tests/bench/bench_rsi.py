"""What the RSI loop's parts cost on one core: a frame answered, a hostile frame refused, and whether the reader goes quadratic.

Run: OMP_NUM_THREADS=1 python tests/bench/bench_rsi.py [CYCLES]

Times of the thread, since other work shares the machine. Over the wire, `camrob tracker --listen` says its own latencies.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import thread_time

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parents[1])]

from rsi_bench import CONTROLLER, LAW, POSE, TRACKER  # noqa: E402
from rsi_world import line, rob  # noqa: E402

from camrob.errors import InputError  # noqa: E402
from camrob.loop.rsi.link import LinkSettings  # noqa: E402
from camrob.loop.rsi.session import TrackerSession  # noqa: E402
from camrob.loop.rsi.xml_frames import read_rob  # noqa: E402

PARTS = ('a="1" ', "<a ", "<a>", " ", 'a = "', "<a b='", "&lt;", "</a>")


def timed(call) -> float:
    """Milliseconds of a call; what it refuses counts as done."""
    start = thread_time()
    try:
        call()
    except InputError:
        return (thread_time() - start) * 1e3
    return (thread_time() - start) * 1e3


def answers(cycles: int) -> tuple[np.ndarray, np.ndarray]:
    """Milliseconds for a measurement and for a frame, cycle by cycle, in a session that uses them all."""
    session, rng = TrackerSession(LinkSettings(LAW)), np.random.default_rng(0)
    angle = np.radians(POSE[3:])
    cz, sz, cy, sy, cx, sx = (f(a) for a in angle for f in (np.cos, np.sin))
    R = (
        np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
        @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    )
    spent = np.empty((2, cycles))
    for k in range(cycles):
        at_s = 0.004 * k
        data = line(at_s, np.array(POSE[:3]) + rng.normal(scale=0.025, size=3), R)
        spent[0, k] = timed(lambda: session.measure(data, TRACKER, at_s))  # noqa: B023
        frame = rob(4 * (k + 1), POSE)
        spent[1, k] = timed(lambda: session.answer(frame, CONTROLLER, at_s + 1e-3, at_s + 1e-3))  # noqa: B023
    if session.counts.answered != cycles:
        raise RuntimeError(f"{cycles - session.counts.answered} frames were not answered: {session.stopped}")
    return spent[0], spent[1]


def main(cycles: int = 5000) -> None:
    for name, spent in zip(("measurement", "frame"), answers(cycles), strict=True):
        p50, p99, most = np.percentile(spent, [50, 99, 100])
        print(f"{name:12} p50 {p50:6.3f} ms  p99 {p99:6.3f} ms  max {most:6.3f} ms of a cycle's 4 ms")
    good = rob("123456", POSE).decode()[:-6]
    for part in PARTS:
        short, long = (
            min(timed(lambda n=n: read_rob((good + part * (n // len(part))).encode())) for _ in range(7))  # noqa: B023
            for n in (3750, 15000)
        )
        print(
            f"hostile {part!r:8} {long:7.3f} ms for 15 kB, {long / max(short, 1e-6):5.1f} times a quarter of it (4: linear)"
        )
    print(f"70 kB       {timed(lambda: read_rob(b'<' * 70000)):6.3f} ms")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
