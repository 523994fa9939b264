"""What a person should know before trusting a calibration, in sentences; and an instrument that was moved while it measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from camrob.calibration.fit import Fit
from camrob.calibration.folds import FEW
from camrob.calibration.measurements import Measurements
from camrob.calibration.pose_by_pose import PoseErrors
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import LogError
from camrob.units import m_to_mm

__all__ = [
    "carries_badly",
    "cautions",
    "check_moved",
    "far_off",
    "move_words",
    "moved_while_measured",
    "stand_still",
    "step_of",
]

Array = NDArray[np.float64]

_GROSS, _NAMED = 4.0, 5  # times the median that a gross pose is off, and how many are named
_EACH_SIDE = 4  # poses before a move of the instrument, and behind it
_NEIGHBOURS = 3  # rows to either side, from whose middle a gross one is far
_OF_MOVE = 0.9  # of the energy of what remains, that one move takes where it is what remains
_MANY, _OF_ORDER = 20, 0.5  # poses, and the energy of what remains that the order of rows takes, where that is said
_STILL = 0.02  # rad: an axis that moves by less tells nothing of itself


def check_moved(data: Measurements, left: Array) -> None:
    """Raise LogError where nearly all that base and tool leave of a log (N, 3), m, is one shift, from some row on: whatever is
    fitted then is little but the move.
    """
    step = step_of(left) if data.sight is None else None
    if step is not None:
        what, hint = move_words(step[1])
        raise LogError(
            f"from this row on its {what}", hint=hint, path=data.name, line=int(np.asarray(data.lines)[step[0]])
        )


def step_of(left: Array) -> tuple[int, Array] | None:
    """The row, and the shift (3,), m, from which on what is left (N, 3) lies elsewhere, where that is nearly all of it."""
    near = sliding_window_view(np.pad(left, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), "edge"), 2 * _NEIGHBOURS + 1, axis=0)
    off = np.linalg.norm(left - np.median(near, axis=2), axis=1)  # of a row alone, not of all from one on
    sound = np.flatnonzero(off <= _GROSS * np.median(off))
    step = _one_step(left[sound])
    return None if step is None else (int(sound[step[0]]), step[1])


def moved_while_measured(found: Sequence[tuple[Measurements, PoseErrors]]) -> tuple[str, ...]:
    """A sentence for each log of which nearly all that a calibration leaves is one shift, from some row on. found: the poses
    of each log, fitted and left out, with what is left of them.
    """
    said = []
    for name in dict.fromkeys(data.name for data, _ in found):
        own = [(data, errors) for data, errors in found if data.name == name and data.sight is None]
        if not own:
            continue
        rows = np.concatenate([errors.rows[~errors.outlier] for _, errors in own])
        order = np.argsort(rows)
        lines = np.concatenate([np.asarray(data.lines)[~errors.outlier] for data, errors in own])[order]
        left = np.concatenate([errors.residuals["calibrated"][~errors.outlier, :3] for _, errors in own])[order]
        step = _one_step(left)
        if step is not None:
            what, hint = move_words(step[1])
            said.append(f"from line {lines[step[0]]} of {name or 'the log'} on, {what}; {hint}")
        elif len(left) >= _MANY:
            said += _by_order(left, np.sort(rows), name or "the log")
    return tuple(said)


def _by_order(left: Array, rows: NDArray[np.int64], name: str) -> list[str]:
    """A sentence where most of what is left (N, 3) turns with every row, or grows from the first to the last."""
    centred = left - left.mean(axis=0)
    said = []
    beside = "every second reading of {} lies {:.2f} mm beside those between: two targets or faces?"
    drift = "readings of {} drift by {:.2f} mm from the first row to the last"
    along = 2.0 * (rows - rows.mean()) / np.ptp(rows)
    for shape, words in ((np.where(rows % 2 == 0, 1.0, -1.0), beside), (along, drift)):
        part = shape - shape.mean()
        by = part @ centred / float(part @ part)
        if float(part @ part) * float(by @ by) > _OF_ORDER * float(np.sum(centred**2)):
            said.append(words.format(name, 2.0 * m_to_mm(float(np.linalg.norm(by)))))
    return said


def move_words(shift: Array) -> tuple[str, str]:
    """What happened, and what to do, in words."""
    by = ", ".join(f"{m_to_mm(v):.2f}" for v in shift)
    what = f"readings lie ({by}) mm off those before: the instrument or its target was moved"
    hint = 'give what is before and what is behind as two logs, with measured_frame = "unknown" where the frame isn\'t known'
    return what, hint


def _one_step(left: Array) -> tuple[int, Array] | None:
    """The row, and the shift (3,), from which on what is left (N, 3) lies elsewhere, where that is nearly all of it."""
    left = left - left.mean(axis=0)
    if len(left) < 2 * _EACH_SIDE:
        return None
    before = np.arange(1, len(left))
    ahead = np.cumsum(left, axis=0)[:-1]  # what is behind sums to as much with the other sign
    apart = 1.0 / before + 1.0 / (len(left) - before)
    taken = (np.sum(ahead**2, axis=1) * apart)[_EACH_SIDE - 1 : len(left) - _EACH_SIDE]
    if taken.max() < _OF_MOVE * np.sum(left**2):
        return None
    k = int(np.argmax(taken)) + _EACH_SIDE - 1
    return k + 1, -ahead[k] * apart[k]


def stand_still(cell: Cell, sets: Sequence[Measurements]) -> tuple[str, ...]:
    """A sentence for axes that stand still while others move."""
    way = np.ptp(np.concatenate([np.asarray(part.q) for part in sets]), axis=0)
    arm = [(k, j.name) for k, j in enumerate(cell.joints) if j.role is Role.ARM]
    still = [name for k, name in arm if way[k] < _STILL]
    if not still or len(still) == len(arm):
        return ()
    one = len(still) == 1
    told = f"{', '.join(still)} {'stands' if one else 'stand'} still in these poses"
    where = "its zero and link" if one else "their zeros and links"
    return (f"{told}: {where} can't be told from base and tool, which took them up; move {'it' if one else 'them'}",)


def far_off(poses: Sequence[PoseErrors]) -> tuple[str, ...]:
    """A sentence for every log with gross poses, which the fit gives little weight and the mean errors all of theirs."""
    said = []
    for log in poses:
        off = m_to_mm(log.distance("calibrated"))
        gross = log.outlier & (off > _GROSS * np.median(off))
        if not gross.any() or gross.all():
            continue
        named = [f"{row + 1}" for row in log.rows[gross][:_NAMED].tolist()]
        more = f" and {gross.sum() - _NAMED} more" if gross.sum() > _NAMED else ""
        one, file = gross.sum() == 1, log.log or "the log"
        which = f"{'pose' if one else 'poses'} {', '.join(named)}{more} of {file} {'lies' if one else 'lie up to'}"
        said.append(
            f"{which} {off[gross].max():.2f} mm off, the others {off[~gross].mean():.2f} in the mean: look how "
            f"{'it was measured; the errors below count it' if one else 'they were measured; the errors below count them'}"
        )
    return tuple(said)


def carries_badly(poses: Sequence[PoseErrors]) -> tuple[str, ...]:
    """A sentence for every withheld log that the calibrated robot predicts worse than base and tool alone do."""
    worse = [p for p in poses if p.withheld and np.mean(p.distance("calibrated")) > np.mean(p.distance("frames"))]
    return tuple(
        f"the poses of {p.log or 'the withheld set'} come out worse than with base and tool alone: these parameters don't "
        "carry over to such poses; fit fewer, or measure poses like them"
        for p in worse
    )


def cautions(fit: Fit, sets: Sequence[Measurements]) -> tuple[str, ...]:
    """What a person should know before trusting the numbers."""
    said = []
    if fit.against > 0.0 and fit.rows < FEW:
        what = f"{fit.rows} poses are few for {len(fit.names)} parameters: each is held to its ordinary size (1 mm, 0.06 degrees)"
        said.append(
            f"{what} against {m_to_mm(fit.against):.3f} mm, as says most of poses left out; measure 50 to know them"
        )
    elif fit.against > 0.0:
        what = "the instrument's frame is unknown, and poses hardly tell it from where the first axes stand"
        held = "each parameter is held to its ordinary size (1 mm, 0.06 degrees)"
        said.append(f"{what}: {held}; set the base up anew where a part's place counts")
    if fit.strongest(1) and abs(fit.strongest(1)[0][2]) > 0.98:
        a, b, r = fit.strongest(1)[0]
        said.append(f"{a} and {b} are nearly one parameter in these poses (correlation {r:.3f})")
    sigma = max(part.sigma_position for part in sets)
    if sigma > 0.0 and fit.scatter_position > 3.0 * sigma:
        ratio = fit.scatter_position / sigma
        said.append(
            f"what remains is {ratio:.0f} times the instrument's noise: something else is at work that was not fitted"
        )
    return tuple(said)
