"""NAME.path.npz, the solved path of a post."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.feed_outcome import FeedOutcome
from camrob.redundancy.solution import Solution
from camrob.units import m_to_mm

__all__ = ["save_path"]


def save_path(file: Path, inputs: JobInputs, solution: Solution, feed: FeedOutcome) -> None:
    """Write NAME.path.npz: postures, axis values and what the points come from, without the points that a plan put in."""
    own = inputs.path.of_toolpath
    q = np.asarray(solution.q)[own]
    columns: dict[str, Any] = {
        "q": q,
        "axes": np.array(inputs.cell.names),
        "axis_values": inputs.cell.to_axis_values(q),
        "axis_names": np.array(inputs.cell.axis_names),
        "line": inputs.path.line[own],
        "region": inputs.path.region[own],
        "inv_kf": np.asarray(solution.inv_kf)[own],
        "s": m_to_mm(inputs.path.length[own]),
        **feed.arrays(inputs.cell, own),
    }
    np.savez(file, **columns)
