"""The report of the welding robot's study: the paper's figures our way, and its statements beside what was found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
from camrob.report.page.parts import TABLE, TABLE_END, page_body
from camrob.report.page.statements import Statement, statements_section, statements_verdict
from camrob.studies.weld_study import Scheme, WeldStudy
from camrob.units import m_to_mm

__all__ = ["weld_report", "weld_statements"]

Array = NDArray[np.float64]


def weld_statements(cell: Cell, study: WeldStudy) -> tuple[Statement, ...]:
    """The paper's statements beside what was found, as plain text."""
    low, high = study.schemes[0], study.schemes[-1]
    error = float(m_to_mm(float(study.points.error.max())))
    largest = np.abs(study.torques.total).max(axis=0)
    first = int(np.argmax(largest))
    constant = study.bound.min(axis=0)
    names = ("speed", "acceleration", "jerk")
    least = f"{constant.min():.3f} m/s ({names[int(np.argmin(constant))]})"
    varies = float(np.ptp(low.published.feed)) > 1e-9
    marched = max(low.marched_use.max(), high.marched_use.max())
    inside = np.all((study.fine.joints.q >= cell.q_lower) & (study.fine.joints.q <= cell.q_upper))
    return (
        Statement(
            "The increments of the generalised vector, adjusted, follow the seam (Figure 10).",
            f"They do: {error:.1e} mm at most over {len(study.points.u)} points.",
            "holds",
        ),
        Statement(
            "Positions, speeds, accelerations and jerks of the joints are within the limits (Figures 6 to 9).",
            f"At {low.top:g} m/s they take {100 * low.use[0]:.0f} %, {100 * low.use[1]:.0f} % and {100 * low.use[2]:.0f} % of "
            f"the limits; positions stay {'within' if inside else 'outside'} the assumed ranges.",
            "holds" if inside and low.use.max() <= 1.0 else "does not hold",
        ),
        Statement(
            "The optimal feed varies along the seam (printed as Figure 11's caption, shown in the other figure).",
            f"It depends on how the scheme is read. At each point by itself: no limit binds below {least} at a constant feed, so "
            f"that it is {_span(low.published.feed)} at f_max {low.top:g} and {_span(high.published.feed)} at {high.top:g}. As a "
            f"march, a step of the feed a point: {_span(low.marched)} at f_max {low.top:g}, climbing along "
            f"{100 * np.mean(low.marched < low.marched.max() - 1e-9):.0f} % of the points, and {_span(high.marched)} at "
            f"{high.top:g}; no limit is met on the way (at most {100 * marched:.0f} % of one), so that it varies by its steps, "
            "and not by the seam.",
            "holds" if varies else "unclear" if np.ptp(low.marched) > 1e-9 else "does not hold",
        ),
        Statement(
            "The feed that is raised point by point keeps every limit.",
            f"At f_max {high.top:g} m/s, with the profile's own df/dt and d2f/dt2, it takes {high.use[1]:.2f} times the "
            f"acceleration and {high.use[2]:.0f} times the jerk limit; the scheme looks at each point as if its feed "
            "were constant.",
            "holds" if high.use.max() <= 1.0 else "does not hold",
        ),
        Statement(
            "f_optimal = max f(u): the feed so found is the optimum (eq. 18).",
            f"At f_max {low.top:g} m/s the scheme's profile keeps all limits, and with the same end speeds the optimum takes "
            f"{low.moving.grid.at[-1] / low.at[-1] - 1.0:+.0e} of its time more: they are one. At f_max {high.top:g} m/s the "
            f"optimum keeps all limits and takes {high.moving.grid.at[-1]:.4f} s where the scheme's profile, were it possible, "
            f"would take {high.at[-1]:.4f} s: a point by itself doesn't know that the feed may fall and rise between points.",
            "holds" if abs(high.moving.grid.at[-1] / high.at[-1] - 1.0) < 1e-3 else "does not hold",
        ),
        Statement(
            "Joint 2 carries the largest torque.",
            f"Joint {first + 1} does: {largest[first]:.0f} Nm, of which gravity takes up to "
            f"{np.abs(study.torques.gravity).max(axis=0)[first]:.0f} Nm; under every assumption about the masses that was tried.",
            "holds" if all(int(np.argmax(c.largest)) == 1 for c in study.loads) else "does not hold",
        ),
        *_equations(study),
    )


def _span(feed: Array) -> str:
    low, high = float(feed.min()), float(feed.max())
    return f"{low:.3f} m/s throughout" if high - low < 1e-9 else f"{low:.3f} to {high:.3f} m/s"


def _equations(study: WeldStudy) -> tuple[Statement, ...]:
    """What the equations and captions state."""
    return (
        Statement(
            "Eq. 9 and 15: q'' = J+ (x'' - J' q').",
            f"A term is missing: (I - J+ J) J'^T (J J^T)^-1 x'. Without it the second derivative is off by up to "
            f"{100 * study.slip[0]:.1f} % of its size; with it, numeric differentiation agrees within "
            f"{100 * study.numeric[0]:.3f} %.",
            "does not hold",
        ),
        Statement(
            "Eq. 10 and 16: q''' = J+ (x''' - 2 J' q'' - J'' q').",
            f"Terms are missing likewise: off by up to {100 * study.slip[1]:.1f} %; ours agrees with numeric differentiation "
            f"within {100 * study.numeric[1]:.3f} %.",
            "does not hold",
        ),
        Statement(
            "Eq. 15: x'' over s adds the projection x'(x'^T x'') / |x'|^4.",
            f"It has to be taken off: as printed, the second derivative of the seam is off by {100 * study.slip[2]:.0f} % of its "
            "size.",
            "does not hold",
        ),
        Statement(
            "Figure 11 shows torques, Figure 12 the optimal feed (captions).",
            "The text refers to them the other way round; the two captions are swapped.",
            "unclear",
        ),
        Statement(
            "f_max is 1.2 m/s, later 0.3 m/s.",
            "Both were run: 0.3 m/s as the scheme's, 1.2 m/s as the robot's.",
            "unclear",
        ),
    )


def weld_report(cell: Cell, study: WeldStudy) -> str:
    """The page as text."""
    charts, said = _charts(cell, study), weld_statements(cell, study)
    body = page_body(
        "Feed, time and torque on the weld seam",
        f"{escape(cell.title)}; seam, limits and lengths as printed by Duong and others (2020); centres of mass, inertias and "
        "the torch's frame are assumed.",
        statements_verdict(said),
        statements_section(said),
        _schemes(study.schemes),
        *(chart_section(chart) for chart in charts),
        _loads(cell, study),
        _tools(cell, study),
    )
    return page("Feed, time and torque on the weld seam", body, {"names": {}, "charts": chart_data(charts)})


def _schemes(schemes: Sequence[Scheme]) -> str:
    rows = []
    for s in schemes:
        for name, seconds, use in (
            ("published scheme, each point by itself", float(s.at[-1]), s.use),
            ("published scheme, a step a point", float(s.marched_at[-1]), s.marched_use),
            ("optimum, ends moving", float(s.moving.grid.at[-1]), s.moving.use),
            ("optimum, from rest to rest", float(s.resting.grid.at[-1]), s.resting.use),
        ):
            cells = "".join(
                f'<td class="n{" low" if u > 1.0 + 1e-6 else ""}">{number(100 * float(u), 1, "%")}</td>' for u in use
            )
            rows.append(
                f'<tr><td>{s.top:g} m/s</td><td>{name}</td><td class="n">{number(seconds, 4, "s")}</td>{cells}</tr>'
            )
    return (
        f"<section><h2>Times, and how far the limits are used</h2>{TABLE}<thead><tr><th>top feed</th><th>profile</th>"
        '<th class="n">time</th><th class="n">speed</th><th class="n">acceleration</th><th class="n">jerk</th></tr></thead>'
        f'<tbody>{"".join(rows)}</tbody>{TABLE_END}<p class="caption">The published profile with its own df/dt and '
        "d2f/dt2, at its own points; the optima on a 10 times finer grid. Speed counts the programmed feed, too.</p></section>"
    )


def _loads(cell: Cell, study: WeldStudy) -> str:
    head = "".join(f'<th class="n">{escape(name)}</th>' for name in cell.names)
    rows = "".join(
        f"<tr><td>{escape(c.name)}</td>"
        + "".join(f'<td class="n">{number(float(v) if v > 1e-9 else 0.0, 1)}</td>' for v in c.largest)
        + "</tr>"
        for c in study.loads
    )
    return (
        f"<section><h2>What the assumed masses do to the torques</h2>{TABLE}<thead><tr><th>largest torque, Nm</th>"
        f"{head}</tr></thead><tbody>{rows}</tbody>{TABLE_END}</section>"
    )


def _tools(cell: Cell, study: WeldStudy) -> str:
    head = "".join(f'<th class="n">{escape(name)}</th>' for name in cell.names)
    rows = "".join(
        f'<tr><td>{escape(c.name)}</td><td class="n">{number(c.feed, 3, "m/s")}</td>'
        + "".join(f'<td class="n">{number(float(v) if v > 1e-9 else 0.0, 1)}</td>' for v in c.largest)
        + "</tr>"
        for c in study.tools
    )
    return (
        f'<section><h2>What the assumed torch does</h2>{TABLE}<thead><tr><th>the torch\'s tip</th><th class="n">least constant '
        f'feed that the limits admit</th>{head}</tr></thead><tbody>{rows}</tbody>{TABLE_END}<p class="caption">Largest torques, '
        f"Nm, at a constant {study.schemes[0].top:g} m/s with the masses as assumed.</p></section>"
    )


def _charts(cell: Cell, study: WeldStudy) -> tuple[LineChart, ...]:
    low = study.schemes[0]
    motion, length = low.resting, m_to_mm(low.resting.grid.s)
    fine, names = m_to_mm(study.fine.s), cell.names

    def joints(values: Array, x: Array) -> tuple[Curve, ...]:
        return tuple(Curve(name, x, values[:, k]) for k, name in enumerate(names))

    along = "length along the seam [mm]"
    feeds = []
    for s in study.schemes:
        feeds += [
            Curve(f"published scheme, f_max {s.top:g}", m_to_mm(study.points.s), s.published.feed, "dot"),
            Curve(f"a step a point, {s.top:g}", m_to_mm(study.points.s), s.marched, "dot"),
            Curve(f"optimum, ends moving, {s.top:g}", m_to_mm(s.moving.grid.s), s.moving.grid.v),
            Curve(f"optimum, rest to rest, {s.top:g}", m_to_mm(s.resting.grid.s), s.resting.grid.v, "dash"),
        ]
    bound = tuple(Curve(n, fine, study.bound[:, k]) for k, n in enumerate(("speed", "acceleration", "jerk")))
    rest = f"Along the optimum from rest to rest at {low.top:g} m/s."
    return (
        LineChart("position", "Joint positions (Figure 6)", "Radians, from the printed q0 adjusted to the seam's first point.",
                  along, "angle [rad]", joints(study.fine.joints.q, fine)),
        LineChart("speed", "Joint speeds (Figure 7)", rest, along, "speed [rad/s]", joints(motion.speed, length)),
        LineChart("acceleration", "Joint accelerations (Figure 8)", rest, along, "acceleration [rad/s²]",
                  joints(motion.acceleration, length)),
        LineChart("jerk", "Joint jerks (Figure 9)", rest, along, "jerk [rad/s³]", joints(motion.jerk, length)),
        LineChart("error", "Position error of the torch's tip (Figure 10)", "At the paper's own points.", along, "error [mm]",
                  (Curve("error", m_to_mm(study.points.s), m_to_mm(study.points.error)),)),
        LineChart("feed", "Feed (Figure 12 by its caption, 11 by the text)",
                  "The published scheme takes each point by itself, or a step a point; the optimum slows in time.", along,
                  "feed [m/s]", tuple(feeds)),
        LineChart("bound", "Constant feed that each limit admits", "The published scheme stops at the lowest of the three, or "
                  "at f_max.", along, "feed [m/s]", bound, True),
        LineChart("torque", "Joint torques (Figure 11 by its caption, 12 by the text)", rest, along, "torque [Nm]",
                  joints(study.torques.total, length)),
        LineChart("gravity", "Gravity's part of the torques", rest, along, "torque [Nm]", joints(study.torques.gravity, length)),
    )  # fmt: skip
