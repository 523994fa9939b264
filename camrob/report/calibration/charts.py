"""The pictures of a calibration: how errors are spread before and after, pose by pose, and what the data tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.pose_by_pose import CalibrationEvidence, PoseErrors, explained_by_axis
from camrob.report.page.html import escape, plot_text
from camrob.report.page.pack import packed_floats
from camrob.report.page.parts import section
from camrob.summaries.calibration_summary import CalibrationFigures
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["STAGES", "calibration_charts", "correlation_section"]

Array = NDArray[np.float64]
Chart = dict[str, Any]

STAGES = {"nominal": "nominal robot", "frames": "base and tool alone", "calibrated": "calibrated"}
_COLORS = {"nominal": "#d1495b", "frames": "#e08a1e", "calibrated": "#2b7de9"}
_NOISE = "#8a93a0"
_MOST = 2500  # points of a cloud
_STEPS = 400  # of a distribution
_SQUARE = 16.0  # pixels of a correlation
_FAINT = 0.05  # of a correlation: weaker ones are not seen
_FEW = 200  # poses, below which bins of a dozen say nothing


def calibration_charts(evidence: CalibrationEvidence, summary: CalibrationFigures, axes: Sequence[str]) -> list[Chart]:
    """All charts, each with id, title, caption, traces, layout and ruler (charts of one ruler are zoomed together)."""
    judged = [p for p in evidence.poses if p.withheld] or list(evidence.poses)
    part = "withheld" if judged[0].withheld else "fitted"
    charts = [_spread(judged, part, angle=False)]
    if any(p.oriented for p in judged):
        charts.append(_spread([p for p in judged if p.oriented], part, angle=True))
    charts += [_pose_by_pose(p, k) for k, p in enumerate(evidence.poses[:8])]
    charts += [
        _parameters(summary),
        _singular(evidence),
        _remaining(_enough(judged, evidence), axes),
    ]
    return charts


def _layout(x: str, y: str, height: int = 340) -> Chart:
    return {
        "height": height,
        "margin": {"l": 70, "r": 16, "t": 8, "b": 50},
        "shapes": [],
        "hovermode": "closest",
        "xaxis": {"title": {"text": plot_text(x)}},
        "yaxis": {"title": {"text": plot_text(y)}},
        "legend": {"orientation": "h", "y": 1.14},
    }


def _chart(id_: str, title: str, caption: str, traces: list[Chart], layout: Chart) -> Chart:
    return {
        "id": id_,
        "title": title,
        "caption": caption,
        "traces": traces,
        "layout": layout,
        "ruler": id_,
    }


def _stages(poses: Sequence[PoseErrors]) -> list[str]:
    return [s for s in STAGES if all(s in p.residuals for p in poses)]


def _spread(poses: Sequence[PoseErrors], part: str, *, angle: bool) -> Chart:
    """The distribution of errors by stage: which share of the poses lies below."""
    traces = []
    for stage in _stages(poses):
        size = np.sort(
            np.concatenate([rad_to_deg(p.angle(stage)) if angle else m_to_mm(p.distance(stage)) for p in poses])
        )
        share = np.linspace(0.0, 100.0, min(len(size), _STEPS))
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": STAGES[stage],
                "x": packed_floats(np.quantile(size, share / 100.0)),
                "y": packed_floats(share),
                "line": {"color": _COLORS[stage], "width": 2},
                "hovertemplate": "%{y:.0f} % lie below %{x:.4f}<extra></extra>",
            }
        )
    unit, name = ("degrees", "orientation") if angle else ("mm", "position")
    layout = _layout(f"error of {name} [{unit}]", "share of the poses [%]")
    layout["xaxis"]["rangemode"] = "tozero"
    return _chart(
        f"spread-{name}",
        f"Errors of {name} on {part} poses",
        "Read upward: the share of the poses whose error lies below. The farther left, the better.",
        traces,
        layout,
    )


def _pose_by_pose(poses: PoseErrors, k: int) -> Chart:
    """Every pose's error of position before and after."""
    pick = np.unique(np.linspace(0, len(poses.rows) - 1, min(len(poses.rows), _MOST)).astype(np.int64))
    kept = np.unique(np.concatenate([pick, np.flatnonzero(poses.outlier)[:_MOST]]))
    number = poses.rows[kept] + 1
    first = _stages([poses])[0]
    traces = [
        {
            "type": "scatter",
            "mode": "markers",
            "name": STAGES[stage],
            "x": packed_floats(number.astype(float)),
            "y": packed_floats(m_to_mm(poses.distance(stage)[kept])),
            "marker": {"size": 4, "color": _COLORS[stage]},
            "hovertemplate": "pose %{x:.0f}: %{y:.4f} mm<extra></extra>",
        }
        for stage in dict.fromkeys((first, "calibrated"))
    ]
    far = np.flatnonzero(poses.outlier)
    if len(far):
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "outliers",
                "x": packed_floats(poses.rows[far] + 1.0),
                "y": packed_floats(m_to_mm(poses.distance("calibrated")[far])),
                "marker": {"size": 9, "symbol": "x", "color": _COLORS["nominal"]},
                "hovertemplate": "outlier, pose %{x:.0f}: %{y:.4f} mm<extra></extra>",
            }
        )
    layout = _layout("pose in the log", "error of position [mm]")
    layout["yaxis"]["rangemode"] = "tozero"
    if poses.sigma > 0.0:
        noise = float(m_to_mm(np.sqrt(3.0) * poses.sigma))
        layout["shapes"] = [
            {
                "type": "line",
                "xref": "paper",
                "x0": 0,
                "x1": 1,
                "y0": noise,
                "y1": noise,
                "line": {"color": _NOISE, "dash": "dash", "width": 1.2},
            }
        ]
    part = "withheld" if poses.withheld else "fitted"
    refitted = " Base and reflector were fitted to the other half of the log." if poses.refitted else ""
    caption = f"Dashed: the instrument's noise in 3-D. {len(far)} outliers of {len(poses.rows)} poses.{refitted}"
    return _chart(f"poses-{k}", f"{poses.log or 'Log'}: {part} poses, one by one", caption, traces, layout)


def _parameters(summary: CalibrationFigures) -> Chart:
    """The robot's own parameters with their standard errors."""
    traces = []
    for unit, name, axis, color in (("mm", "mm", "", "#2b7de9"), ("deg", "degrees", "2", "#1a9c6b")):
        own = [p for p in summary.parameters if p.unit == unit and not p.nuisance]
        if own:
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": name,
                    "x": [plot_text(p.name) for p in own],
                    "y": [p.value for p in own],
                    "xaxis": f"x{axis}",
                    "yaxis": f"y{axis}",
                    "marker": {"size": 7, "color": color},
                    "error_y": {"type": "data", "array": [2.0 * p.std for p in own], "thickness": 1.2, "width": 3},
                    "hovertemplate": f"%{{x}}: %{{y:.4f}} {name}<extra></extra>",
                }
            )
    layout = _layout("", "value [mm]", 380)
    layout["margin"] |= {"b": 90}
    layout["xaxis"] |= {"domain": [0.0, 0.36]}
    layout["xaxis2"] = {"domain": [0.44, 1.0], "anchor": "y2"}
    layout["yaxis2"] = {"title": {"text": "value [degrees]"}, "anchor": "x2"}
    return _chart(
        "parameters",
        "The parameters found",
        "Bars: two standard errors. Values in the table below, compliances too.",
        traces,
        layout,
    )


def _singular(evidence: CalibrationEvidence) -> Chart:
    """Singular values of the scaled Jacobian of the parameters that were fitted."""
    values = np.asarray(evidence.singular)
    trace = {
        "type": "scatter",
        "mode": "lines+markers",
        "x": list(range(1, len(values) + 1)),
        "y": packed_floats(values),
        "line": {"color": "#8a63d2"},
        "hovertemplate": "%{x}: %{y:.4g}<extra></extra>",
        "showlegend": False,
    }
    layout = _layout("singular value, the largest first", "size", 300)
    layout["yaxis"]["type"] = "log"
    return _chart(
        "singular",
        "What the poses show: singular values",
        "Of the Jacobian of the parameters that were fitted, each in its ordinary size and the measurements in their "
        "noise. The inverse of the last is the largest standard error of a mixture of parameters.",
        [trace],
        layout,
    )


def correlation_section(evidence: CalibrationEvidence) -> str:
    """All correlations at once, as a map in SVG: of each pair its square, red where they rise together, blue where not."""
    names, side = [escape(n) for n in evidence.names], _SQUARE
    left, top = 110.0, 4.0
    size = side * len(names)
    out = [
        f'<svg viewBox="0 0 {left + size + 4:.0f} {top + size + 104:.0f}" role="img" aria-label="correlations of the '
        f'parameters, each with each" style="width:100%;max-width:{1.4 * (left + size):.0f}px" font-size="10" '
        'fill="currentColor">'
    ]
    for k, name in enumerate(names):
        at = top + (k + 0.7) * side
        down = left + (k + 0.7) * side
        out.append(f'<text x="{left - 6:.0f}" y="{at:.1f}" text-anchor="end">{name}</text>')
        out.append(
            f'<text x="{down:.1f}" y="{top + size + 8:.0f}" transform="rotate(-90 {down:.1f} {top + size + 8:.0f})" '
            f'text-anchor="end">{name}</text>'
        )
    for i, row in enumerate(np.asarray(evidence.correlation)):
        for k, value in enumerate(row):
            if abs(value) < _FAINT:
                continue
            color = "#c8342f" if value > 0.0 else "#2f6fc4"
            out.append(
                f'<rect x="{left + k * side:.1f}" y="{top + i * side:.1f}" width="{side - 1:.0f}" height="{side - 1:.0f}" '
                f'fill="{color}" fill-opacity="{abs(value):.2f}"><title>{names[i]} and {names[k]}: {value:.3f}</title></rect>'
            )
    out.append(
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{size:.1f}" height="{size:.1f}" fill="none" stroke="currentColor" '
        'stroke-opacity="0.3"/></svg>'
    )
    caption = (
        '<p class="caption">Of the parameters\' estimates: red, they rise together; blue, one rises as the other falls; the '
        "stronger the colour, the more. Strong colours off the diagonal: only the mixture of the two is known well.</p>"
    )
    return section("Correlations", "".join(out), caption)


def _enough(judged: Sequence[PoseErrors], evidence: CalibrationEvidence) -> Sequence[PoseErrors]:
    """The poses to look for what stays in: the withheld ones, and where they are few, all of them."""
    return judged if sum(len(p.rows) for p in judged) >= _FEW else evidence.poses


def _remaining(poses: Sequence[PoseErrors], axes: Sequence[str]) -> Chart:
    """The share of the errors' energy that goes with each axis, before and after."""
    traces = []
    for stage in ("frames", "calibrated"):
        r = np.concatenate([p.residuals[stage][:, :3] for p in poses])
        values = np.concatenate([p.axis_values for p in poses])
        share = 100.0 * explained_by_axis(r, values)
        traces.append(
            {
                "type": "bar",
                "name": STAGES[stage],
                "x": [plot_text(a) for a in axes],
                "y": [float(v) for v in share],
                "marker": {"color": _COLORS[stage]},
                "hovertemplate": "%{x}: %{y:.1f} %<extra></extra>",
            }
        )
    layout = _layout("axis", "share of the energy [%]", 300)
    layout["yaxis"]["rangemode"] = "tozero"
    return _chart(
        "remaining",
        "What stays, by axis",
        "The share of the errors' energy that follows the value of one axis alone (means of 12 bins, less what chance "
        "gives). Blue bars that stand out: the model lacks something about that axis.",
        traces,
        layout,
    )
