"""One row for each answered frame, kept in memory while the loop runs and written afterwards."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.loop.rsi.session import Answer
from camrob.units import m_to_mm, rad_to_deg, s_to_ms

__all__ = ["CycleLog", "percentiles"]

Array = NDArray[np.float64]

_VECTORS = ("setpoint", "error", "total", "sent")
_SCALARS = ("t_s", "latency", "age", "interval")
_WIDTH = len(_SCALARS) + 6 * len(_VECTORS)  # a vector: three of place, three of turning
_CHUNK = 16384  # cycles: 65 s of them at 4 ms
_MOST_ROWS = 4_000_000  # more than four hours at 250 Hz; about 1 GB


class CycleLog:
    """Answers of a session with their times. Rows past the bound are counted in `dropped` and not kept."""

    def __init__(self) -> None:
        self._chunks: list[Array] = []
        self._ticks = array("q")
        self._sources = array("b")
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._ticks)

    def add(self, answer: Answer, at_s: float, latency_s: float) -> None:
        """An answer, when its frame arrived, and how long after that it was sent."""
        row = len(self)
        if row >= _MOST_ROWS:
            self.dropped += 1
            return
        if row % _CHUNK == 0:
            self._chunks.append(np.empty((_CHUNK, _WIDTH)))
        values = self._chunks[-1][row % _CHUNK]
        values[:4] = at_s, latency_s, answer.age_s, answer.interval_s
        values[4:10], values[10:16] = answer.setpoint, answer.error
        values[16:22], values[22:28] = answer.total, answer.sent
        self._ticks.append(answer.ticks)
        self._sources.append(answer.source)

    @property
    def rows(self) -> Array:
        """(n, 28): arrival, latency, the measurement's age, interval, s; set-point, error, total, sent, six each, m and rad."""
        return np.concatenate([*self._chunks, np.empty((0, _WIDTH))])[: len(self)]

    @property
    def ticks(self) -> NDArray[np.int64]:
        """The answered frames' IPOC (n,)."""
        return np.array(self._ticks, dtype=np.int64)

    def write(self, path: Path) -> None:
        """A CSV table in mm, degrees and ms, times from the first frame on; empty fields where there is no number."""
        rows, names = self.rows, ["t_s", "ipoc", "source", "latency_ms", "age_ms", "interval_ms"]
        for vector in _VECTORS:
            names += [f"{vector}_{axis}" for axis in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")]
        six = rows[:, 4:].reshape(len(rows), len(_VECTORS), 6)
        edge = np.concatenate([m_to_mm(six[..., :3]), rad_to_deg(six[..., 3:])], axis=-1)
        times = rows[:, 0] - (rows[0, 0] if len(rows) else 0.0)
        numbers = np.column_stack([times, s_to_ms(rows[:, 1:4]), edge.reshape(len(rows), 6 * len(_VECTORS))])
        with path.open("w", encoding="ascii", newline="\n") as file:
            file.write(",".join(names) + "\n")
            for ticks, source, values in zip(self._ticks, self._sources, numbers, strict=True):
                fields = ["" if v != v else f"{v:.6f}" for v in values.tolist()]
                file.write(",".join([fields[0], str(ticks), str(source), *fields[1:]]) + "\n")


def percentiles(times_s: Array) -> dict[str, float | None]:
    """p50, p95, p99 and max of times in s, as ms; None where there are none."""
    known = times_s[np.isfinite(times_s)]
    names = ("p50", "p95", "p99", "max")
    if known.size == 0:
        return dict.fromkeys(names, None)
    return {n: round(float(s_to_ms(np.percentile(known, q))), 4) for n, q in zip(names, (50, 95, 99, 100), strict=True)}
