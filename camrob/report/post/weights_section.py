"""The weights of the published method along the path, and where its postures lag behind its own equilibrium."""

from __future__ import annotations

import numpy as np

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.equilibrium import Equilibrium, equilibrium
from camrob.redundancy.solution import Solution
from camrob.report.page.html import number
from camrob.report.page.path_charts import Along, Chart

__all__ = ["weights_along", "weights_chart"]

_COLORS = ("#2f7fd1", "#e08a1e", "#2f9e77", "#d64545", "#8a63d2", "#6b7785", "#b5651d", "#0aa3a3")
_LONGEST = 20_000  # points up to which a report works this out: as its comparison with other ways
_BOUNDED = -0.06  # of the greatest weight: where the marks of bounded self-motion lie, under the curves


def weights_along(cell: Cell, path: ToolPathInBase, solution: Solution) -> Equilibrium | None:
    """The weights along a path by the published method; None for other methods, several tools, and very long paths."""
    if solution.method != "vjm" or len(path.stretches) != 1 or not 1 < len(path) <= _LONGEST:
        return None
    return equilibrium(cell, path, solution)


def weights_chart(cell: Cell, along: Along, path: ToolPathInBase, found: Equilibrium) -> tuple[Chart, str]:
    """The chart, and the sentence under it."""
    engine = cell.resolve.joint_engine
    cutting = np.asarray(path.cutting)
    traces = [
        along.curve(
            np.where(cutting, np.asarray(found.weights)[:, cell.index(joint)], np.nan),
            joint,
            template=f"{joint}: %{{y:.3f}}<extra></extra>",
            color=_COLORS[k % len(_COLORS)],
        )
        for k, joint in enumerate(engine.weights)
    ]
    bounded = np.asarray(found.bounded) & cutting
    top = float(np.max(np.asarray(found.weights), initial=0.0))
    if bounded.any():
        mark = np.where(bounded, _BOUNDED * top, np.nan)
        traces.append(
            along.curve(mark, "self-motion bounded", template="<extra></extra>", color="#d64545", line={"width": 4})
        )
    end = float(along.s_mm[-1]) if len(along.s_mm) else 0.0
    layout = {
        "height": 330,
        "margin": {"l": 64, "r": 16, "t": 54, "b": 46},
        "hovermode": "x unified",
        "xaxis": {
            "range": [0.0, end or 1.0],
            "title": {"text": "path length of the tool tip [mm]"},
            "tickformat": ",~f",
        },
        "yaxis": {"title": {"text": "weight in h_jnt [–]"}},
        "legend": {"orientation": "h", "y": -0.25, "yanchor": "top", "x": 0},
        "shapes": along.bands([""]),
        "annotations": along.band_names(),
    }
    text = _caption(
        100.0 * bounded.sum() / max(1, cutting.sum()),
        100.0 * (np.asarray(found.acting) & cutting).sum() / max(1, cutting.sum()),
        100.0 * (path.along_axis & cutting).sum() / max(1, cutting.sum()),
    )
    return {"traces": traces, "layout": layout}, text


def _caption(bounded: float, acting: float, alone: float) -> str:
    """What the chart shows. % of the cutting points where self-motion is bounded, h_cond pulls, the arm goes alone."""
    lag = (
        f"At {number(bounded, 1)} % of the cutting points (red) the posture lags behind the equilibrium of the published loop: "
        "there the loop's own posture folds over, and unbounded the external axes would jump; camrob bounds self-motion by the "
        "tool's own motion and half of the axes' speeds. "
        if bounded
        else "Nowhere does the posture lag behind the equilibrium of the published loop. "
    )
    if alone:
        lag += f"(Left out: {number(alone, 1)} %, ways along the tool's axis, which the arm goes alone.) "
    pull = f"pulls at {number(acting, 1)} % of the cutting points" if acting else "pulls nowhere"
    return (
        "How strongly the method pulls each axis to its reference posture while it cuts; the rest of the free motion goes to "
        f"the axes with the least weight. Look for the axes whose weights change: they give way there. {lag}h<sub>cond</sub>, "
        f"which pulls away from ill-conditioned postures, {pull}."
    )
