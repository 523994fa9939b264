"""What the paper of the published method states, beside what was found on the program at hand."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.equilibrium import Equilibrium
from camrob.redundancy.solution import Solution
from camrob.report.page.statements import Statement

__all__ = ["ALIKE", "UNREVISED", "paper_statements"]

Array = NDArray[np.float64]

ALIKE = "all weights alike"  # the other ways to resolve a path that the statements are held against
UNREVISED = "without revision"
_TERMS = {  # h_cond by the cell's setting of it
    "recorded": "is taken as printed: back to the posture recorded at the threshold",
    "gradient": "goes down k_F's own gradient instead",
    "off": "is switched off",
}
_CHANGED = 1e-3  # of a weight: less is no adjustment
_SAME = 5e-4  # of 1/k_F: less is no difference in the digits shown


def paper_statements(
    cell: Cell, path: ToolPathInBase, solution: Solution, found: Equilibrium | None, others: Mapping[str, Array]
) -> tuple[Statement, ...]:
    """Section 2.3 to 4 of the paper on this path; none where another method made the postures, or where nothing is cut.

    found: the weights along the path; None leaves out what rests on them. others: 1/k_F (N,) of the path resolved in other ways.
    """
    cutting = np.asarray(path.cutting)
    if solution.method != "vjm" or not cutting.any():
        return ()
    own = path.of_toolpath  # as in the summary, so that the page has one mean and one lowest
    kept = np.asarray(solution.inv_kf)[own]
    rivals = {name: np.asarray(kf)[own] for name, kf in others.items()}
    about = () if found is None else _about_weights(cell, path, found, kept)
    return (
        _reasonable(cell, kept),
        *about,
        *([_engines_against(kept, rivals[ALIKE])] if ALIKE in rivals and cell.resolve.joint_engine.weights else []),
        *_revision(solution, kept, rivals.get(UNREVISED)),
    )


def _reasonable(cell: Cell, kept: Array) -> Statement:
    threshold = cell.resolve.threshold
    below = 100.0 * float(np.mean(kept < threshold))
    return Statement(
        "1/k_F is maintained at reasonable values while all joints are between the allowable limits (section 4, Figure 10).",
        f"{_mean_and_lowest(kept)}; {below:.1f} % of the points lie below {threshold:g}. No joint passes a limit: "
        "else nothing would be released.",
        "holds" if below == 0.0 else "unclear",
    )


def _about_weights(
    cell: Cell, path: ToolPathInBase, found: Equilibrium, kept: Array
) -> tuple[Statement, Statement, Statement, Statement]:
    """Algorithm 1's equilibrium, the threshold, eq. 18, and the two engines."""
    cutting = np.asarray(path.cutting)
    acting = _percent(found.acting, cutting)
    engine, threshold = cell.resolve.joint_engine, cell.resolve.threshold
    weights = np.asarray(found.weights)[cutting]
    spans = {joint: weights[:, cell.index(joint)] for joint in engine.weights}
    ranges = ", ".join(f"{joint} {_span(values)}" for joint, values in spans.items()) or "none is an engine's here"
    adjusted = any(float(np.ptp(values)) > _CHANGED for values in spans.values())
    term, off = _TERMS[cell.resolve.condition_term], cell.resolve.condition_term == "off"
    acts = "is switched off in this cell" if off else f"acts on {acting:.1f} % of the cutting points"
    second = bool(acting) and not off
    return (
        Statement(
            "Each point's loop repeats until it moves no more: the posture is its equilibrium (Algorithm 1).",
            _equilibrium(path, found),
            "does not hold" if np.any(np.asarray(found.bounded) & cutting) else "holds",
        ),
        Statement(
            "h_cond is activated when k_F passes over a threshold, 0.5 (section 2.3).",
            f"By eq. 16 k_F is never below 1 (here {1.0 / kept.max():.3f} to {1.0 / kept.min():.3f}), so that it would always be "
            f"active; taken as 1/k_F below {threshold:g}, it {acts}.",
            "unclear",
        ),
        Statement(
            "h_cond is the negative gradient of p_cond (eq. 17, 18).",
            f"Eq. 18 leaves out that k_F and W_cond depend on the posture, too. Here h_cond {term}.",
            "does not hold",
        ),
        Statement(
            "Two engines adjust the weights for every situation of the robot (sections 3.1, 5).",
            f"The first gives, while cutting: {ranges}. The second adjusts h_cond alone, which {acts}.",
            "holds" if adjusted and second else "unclear" if adjusted or second else "does not hold",
        ),
    )


def _equilibrium(path: ToolPathInBase, found: Equilibrium) -> str:
    """How much of the cutting stands at the loop's own posture, and what the rest does."""
    cutting, acting, bounded = np.asarray(path.cutting), np.asarray(found.acting), np.asarray(found.bounded)
    alone = path.along_axis & ~acting
    there = f"It is on {_percent(~(acting | bounded | alone), cutting):.1f} % of the cutting points"
    parts = (
        (
            bounded,
            "the loop's own posture folds over, and table and track would jump: there self-motion is bounded, and it lags",
        ),
        (alone, "the tool goes along its own axis, which the arm does alone"),
        (acting, "h_cond pulls, too, and it can't be told"),
    )
    rest = [f"on {_percent(mask, cutting):.1f} % {what}" for mask, what in parts if np.any(mask & cutting)]
    return f"{'; '.join([there, *rest])}."


def _percent(mask: NDArray[np.bool_], cutting: NDArray[np.bool_]) -> float:
    """Of the cutting points."""
    return 100.0 * float(np.mean(np.asarray(mask)[cutting]))


def _engines_against(kept: Array, alike: Array) -> Statement:
    return Statement(
        "The engines' weights improve the robot's performance (section 5).",
        f"{_mean_and_lowest(kept)}; with all weights alike {_mean_and_lowest(alike)}. That is a weak rival: constant weights "
        "fitted to drawn paths do as well as rules (docs/explanation/method.md).",
        _better(kept, alike),
    )


def _revision(solution: Solution, kept: Array, without: Array | None) -> tuple[Statement, ...]:
    """What the revisions were worth; nothing where a path has none, or where it wasn't resolved without them."""
    count = len(solution.revisions)
    if without is None or not count:
        return ()
    done = sum(one.kept for one in solution.revisions)
    return (
        Statement(
            "Between regions, moving table and track radically improves the posture (section 3.2).",
            f"{done} of {count} revisions were kept. {_mean_and_lowest(kept)}; without any {_mean_and_lowest(without)}.",
            _better(kept, without) if done else "unclear",
        ),
    )


def _better(kept: Array, other: Array) -> str:
    """The verdict on a gain: holds where mean or lowest 1/k_F is higher and neither lower; else unclear, or doesn't hold."""
    gains = [_figure(kept) - _figure(other) for _figure in (np.nanmean, np.nanmin)]
    if min(gains) > -_SAME and max(gains) > _SAME:
        return "holds"
    return "unclear" if max(gains) > _SAME else "does not hold"


def _mean_and_lowest(kf: Array) -> str:
    return f"1/k_F is {np.nanmean(kf):.3f} in the mean, {np.nanmin(kf):.3f} at the lowest"


def _span(values: Array) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.3f}" if high - low <= _CHANGED else f"{low:.3f} to {high:.3f}"
