"""The stock as the page shows it: its mesh, and within the box that is cut six sides of heights that change with time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.seen import SeenSide, SeenStock
from camrob.report.page.pack import packed_floats, packed_integers
from camrob.report.page.triangles import joined, thinned
from camrob.units import m_to_mm

__all__ = ["StockOnPage"]

Array = NDArray[np.float64]

_VERTEX = 0.002  # mm: what corners of bodies are rounded to
_FACES = 20_000  # of the stock's own mesh, what a page stays small with
_NONE = 65_535  # a ray without material
_STEPS = 65_534  # across the box, or the time


@dataclass(frozen=True, slots=True)
class StockOnPage:
    """Triangles (T, 3, 3), m, of the stock in the part's frame, and what is seen of it while it is cut, or why it is not."""

    triangles: Array
    seen: SeenStock | str

    def data(self, base_T_part: Array) -> dict[str, Any]:
        """For player.js: lengths in mm, in `part`, whose pose in `base` goes with it."""
        mesh = thinned(joined(self.triangles), _FACES)
        pose = np.array(base_T_part, float)[:3]
        pose[:, 3] = m_to_mm(pose[:, 3])
        out: dict[str, Any] = {
            "pose": [float(v) for v in pose.ravel()],
            "vertices": packed_floats(m_to_mm(np.asarray(mesh.vertices, float)), _VERTEX),
            "faces": packed_integers(mesh.faces),
        }
        if isinstance(self.seen, SeenStock):
            end = max(float(np.nanmax(s.since, initial=0.0)) for s in self.seen.sides if np.isfinite(s.since).any())
            out["lower"] = [float(v) for v in m_to_mm(self.seen.lower)]
            out["upper"] = [float(v) for v in m_to_mm(self.seen.upper)]
            out["pitch"] = float(m_to_mm(self.seen.pitch))
            out["end"] = end
            out["sides"] = [_side(self.seen, s, end) for s in self.seen.sides if np.isfinite(s.height).any()]
        else:
            out["uncut"] = self.seen
        return out


def _side(seen: SeenStock, side: SeenSide, end: float) -> dict[str, Any]:
    """Heights as steps across the box, times as steps of the cut's end; each stage's as what differs from the one before."""
    low, high = seen.lower[side.axis], seen.upper[side.axis]
    height, far = (_stepped((x - low) / (high - low)) for x in (side.height, side.far))
    return {
        "axis": side.axis,
        "facing": side.facing,
        "first": [float(v) for v in m_to_mm(side.first)],
        "size": list(height.shape[1:]),
        "stages": len(side.since),
        "height": packed_integers(_differences(height)),
        "far": packed_integers(_differences(far)),
        "since": packed_integers(_stepped(side.since / max(end, 1e-9))),
    }


def _stepped(share: Array) -> NDArray[np.int64]:
    """Shares of 0 to 1 as whole steps, `_NONE` for NaN."""
    none = np.isnan(share)
    return np.where(none, _NONE, np.rint(np.clip(np.where(none, 0.0, share), 0.0, 1.0) * _STEPS)).astype(np.int64)


def _differences(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """The first as it is, each further one less the one before, modulo 65 536: mostly zeros, which pack to nothing."""
    out = values.copy()
    out[1:] -= values[:-1]
    return out % 65_536
