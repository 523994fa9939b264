"""The instrument as a suspect: what of the gap may be its own, which rows are gross, and what it can't be told from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.units import m_to_mm

__all__ = ["instrument_suspect"]

_OWN = ("measurement_scale", "measurement_drift", "measurement_frame")
_ROWS = 20  # that are named
_PPM = 1e6


def instrument_suspect(model: Model, effects: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """For JSON. suspect: probability that an error of the instrument is at work; scale_ppm, drift_mm (its size over a log): as
    fitted, null where not; gross: by log, how many rows are, and the first of them by number (from 1) and time.
    """
    claims = {e["effect"]: e for e in effects if e["effect"] in _OWN}
    scale, drift = (claims.get(n, {}).get("parameters", {}) for n in _OWN[:2])
    steady = [told["value"] for n, told in drift.items() if n.startswith("drift_") and n.endswith("_mm")]
    gross = [_gross(p) for p in model.panels]
    suspect = max((float(e["probability"]) for e in claims.values()), default=0.0)
    scale_ppm = _PPM * scale["scale"]["value"] if "scale" in scale else None
    return {
        "suspect": suspect, "scale_ppm": scale_ppm, "drift_mm": float(np.linalg.norm(steady)) if steady else None,
        "gross": [g for g in gross if g["rows"]], "text": _words(claims, scale_ppm, [g for g in gross if g["rows"]]),
    }  # fmt: skip


def _gross(panel: Panel) -> dict[str, Any]:
    """The rows of a log that stand far from all others and take no part."""
    rows = np.flatnonzero((panel.w_tcp[:, :3] == 0.0).any(axis=1) & panel.scene.seen[:, 0])
    size = np.linalg.norm(panel.scene.tcp_gap[rows, :3], axis=1)
    return {
        "log": panel.scene.name, "rows": len(rows), "share": len(rows) / len(panel.scene),
        "first": [
            {"sample": int(r) + 1, "t_s": float(panel.scene.t[r]), "off_mm": m_to_mm(float(s))}
            for r, s in list(zip(rows.tolist(), size.tolist(), strict=True))[:_ROWS]
        ],
    }  # fmt: skip


def _words(claims: Mapping[str, Mapping[str, Any]], scale_ppm: float | None, gross: Sequence[Mapping[str, Any]]) -> str:
    told = []
    for name, entry in claims.items():
        if entry["probability"] < 0.5:
            continue
        if name == "measurement_scale" and scale_ppm is not None:
            alike = ", ".join(entry["indistinguishable_from"])
            told.append(
                f"its lengths are {scale_ppm:+.0f} ppm off; a track's scale and longer links would look alike"
                + (f" (here: {alike})" if alike else "")
            )
        elif name == "measurement_drift":
            told.append("it moved, or its target slipped, while it measured")
        else:
            told.append("its frame is not where it was said to be")
    for one in gross:
        first = ", ".join(str(r["sample"]) for r in one["first"])
        told.append(f"{one['rows']} rows of {one['log']} are gross and take no part (samples {first})")
    return "; ".join(told)
