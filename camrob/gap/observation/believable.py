"""Whether a gap can be one of this cell: whose log it is not, and whose axis was mastered wrong by degrees."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.errors import LogError
from camrob.gap.observation.mistakes.mistaken import mistaken
from camrob.gap.observation.mistakes.mistaken_drives import check_drives
from camrob.gap.observation.mistakes.mistaken_turns import mistaken_turns
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["check_believable", "check_poses", "check_reading", "lost_zero", "mixed_up"]

Array = NDArray[np.float64]

_STILL = 1e-4  # rad and m that some axis moves at the least
_SLOWEST = 5.0  # s between the rows of a path
_FARTHEST_MM, _FARTHEST_DEG = 30.0, 3.0  # no gap of a working cell is larger, unless an axis lost its zero
_LOST = deg_to_rad(10.0)  # the most that a zero is off: more is no mastering mark of that axis
_LEFT = 0.2  # of the gap that a lost zero may leave, to be its cause
_CARRIED, _STUCK = mm_to_m(0.5), 5  # from row to row; rows of which a reading that stays is no chance
_STEPS = 6
_SOME = 400


def check_believable(scenes: Sequence[Scene]) -> dict[str, float]:
    """Axes whose zeros are off by so much that they alone make the gap incredible, rad; {} for ordinary logs.

    Raises LogError for logs in which nothing happens, and those whose gap is no gap of this cell.
    """
    lost: dict[str, float] = {}
    for scene in scenes:
        _check_moves(scene)
        step = float(np.median(np.diff(scene.t)))
        if step > _SLOWEST and not scene.poses:
            what = f"its rows are {step:.3g} s apart"
            hint = "is t in milliseconds? give seconds; for single poses write poses = true into its .toml"
            raise scene.log.error(what, hint=hint, at=int(np.argmax(np.diff(scene.t) > _SLOWEST)) + 1)
        check_drives(scene)
        check_reading(scene)
        size, angle = _gap(scene)
        if not _beyond(size, angle):
            continue
        found = lost_zero(scene)
        if found is not None:
            lost[found[0]] = found[1]
            continue
        cause = _mistake(scene, size, again="diagnose")
        if cause is not None:
            raise cause
        if size > mm_to_m(_FARTHEST_MM):
            what = f"the measured TCP lies {m_to_mm(size):.0f} mm from where the axis values put it (median)"
            hint = "check the cell, the order and units of the axes, measured_frame and target in its .toml"
            raise scene.log.error(what, hint=hint, at=_first_far(scene, size))
        what = (
            f"the measured tool is turned by {rad_to_deg(angle):.1f} degrees from where the axis values put it (median)"
        )
        hint = "check a, b, c (R = Rz(A) Ry(B) Rx(C), degrees) and the tool"
        raise scene.log.error(what, hint=hint, at=_first_turned(scene))
    return lost


def check_poses(scene: Scene) -> None:
    """Raises LogError where no axis moves, and for readings that can't be of the poses beside them (`check_reading`)."""
    _check_moves(scene)
    check_reading(scene)


def mixed_up(scene: Scene, *, again: str) -> LogError | None:
    """What was mixed up in a log whose gap is no gap of this cell; None where it is one, or an axis lost its zero, or nothing
    that was tried mends it. again: the verb that is then to be asked again.
    """
    size, angle = _gap(scene)
    if not _beyond(size, angle) or lost_zero(scene) is not None:
        return None
    return _mistake(scene, size, again=again)


def _mistake(scene: Scene, size: float, *, again: str) -> LogError | None:
    """The one mistake of those tried that mends a gap that can't be this cell's, whose median is `size`, m; None without one."""
    far = size > mm_to_m(_FARTHEST_MM)
    words = mistaken(scene) if far else mistaken_turns(scene)
    if not words:
        return None
    hint = f"correct the log (or [table] in its .toml) or the cell, and {again} it again"
    return scene.log.error(words, hint=hint, at=_first_far(scene, size) if far else _first_turned(scene))


def _beyond(size: float, angle: float) -> bool:
    """Whether a gap of m and rad (medians) is none that a working cell has."""
    return size > mm_to_m(_FARTHEST_MM) or angle > deg_to_rad(_FARTHEST_DEG)


def _check_moves(scene: Scene) -> None:
    if float(np.ptp(scene.link, axis=0).max()) < _STILL:
        raise scene.log.error("no axis moves in it", hint="log a run, or poses that differ")


def _gap(scene: Scene) -> tuple[float, float]:
    """m and rad, the median gap; 0 rad where no orientation was measured."""
    turned = scene.seen[:, 3:].all(axis=1)
    angle = float(np.median(np.linalg.norm(scene.tcp_gap[turned, 3:], axis=1))) if turned.any() else 0.0
    return float(np.median(np.linalg.norm(scene.tcp_gap[:, :3], axis=1))), angle


def _first_far(scene: Scene, size: float) -> int:
    return int(np.argmax(np.linalg.norm(scene.tcp_gap[:, :3], axis=1) >= size))


def _first_turned(scene: Scene) -> int:
    return int(np.flatnonzero(scene.seen[:, 3:].all(axis=1))[0])


def check_reading(scene: Scene) -> None:
    """Raises LogError for positions that stay the very same while the axes carry the tool on, and those that are all zeros."""
    place = scene.log.matrix(scene.log.place_names)
    step = np.diff(scene.nominal[:, :3, 3], axis=0, append=scene.nominal[-1:, :3, 3])
    carried = np.linalg.norm(scene.told(step)[:-1], axis=1) > _CARRIED
    stuck = np.flatnonzero((np.diff(place, axis=0) == 0.0).all(axis=1) & carried)
    if scene.poses and _in_sockets(scene):
        return
    if scene.tracked and len(stuck) >= _STUCK:
        first = int(stuck[0]) + 1
        when = f"first at t = {scene.t[first]:g} s"
        names = ", ".join(scene.log.place_names)
        what = f"{names} stay the same to the last digit in {len(stuck)} rows while the axes move ({when})"
        raise scene.log.error(what, hint="leave cells empty where the instrument saw nothing new", at=first)
    off = np.linalg.norm(scene.tcp_gap[:, :3], axis=1) > mm_to_m(_FARTHEST_MM)
    lost = (place == 0.0).all(axis=1) & off & scene.log.has_position
    if lost.any():
        rows = np.flatnonzero(lost)
        what = f"{', '.join(scene.log.place_names)} are 0 to the last digit in {len(rows)} rows"
        raise scene.log.error(what, hint="leave cells empty where the instrument saw nothing", at=int(rows[0]))


def _in_sockets(scene: Scene) -> bool:
    """Whether a ball at the flange was put into a few sockets in many postures: every place was read again and again, and one
    point of the tool stays there. Under an instrument that hangs none does.
    """
    place, which, count = np.unique(scene.measured[:, :3, 3], axis=0, return_inverse=True, return_counts=True)
    if count.min() < _STUCK:
        return False
    frames = scene.nominal[:, :3]
    mean = np.zeros((len(place), 3, 4))
    np.add.at(mean, which.reshape(-1), frames)
    apart = frames - (mean / count[:, None, None])[which.reshape(-1)]
    turned, moved = apart[:, :, :3].reshape(-1, 3), apart[:, :, 3].reshape(-1)
    ball = np.linalg.lstsq(turned, -moved, rcond=None)[0]
    off = np.linalg.norm((turned @ ball + moved).reshape(-1, 3), axis=1)
    return float(np.median(off)) <= mm_to_m(_FARTHEST_MM)


def lost_zero(scene: Scene) -> tuple[str, float] | None:
    """The one axis of the arm, and by how many rad its zero is off, that explains nearly all of a log's gap; None without one.

    Gauss-Newton on the exact poses at some samples, axis by axis.
    """
    rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
    gap = np.where(scene.seen, scene.tcp_gap, 0.0)[rows]
    whole = float(np.sum(gap[:, :3] ** 2))
    best: tuple[float, str, float] | None = None
    for k, axis in enumerate(scene.axes):
        joint = scene.cell.joints[scene.cell.index(axis)]
        if joint.role is not Role.ARM or joint.prismatic or f"{axis}.zero" not in scene.places:
            continue
        J = scene.places[f"{axis}.zero"][rows, :3]
        value, left = 0.0, whole
        for _ in range(_STEPS):
            there = np.array(scene.link)
            there[:, k] += value
            rest = gap[:, :3] - scene.beyond(there)[rows, :3]
            left = float(np.sum(rest**2))
            step = float(np.sum(J * rest)) / max(float(np.sum(J**2)), 1e-30)
            value = float(np.clip(value + step, -_LOST, _LOST))
        if abs(value) < _LOST and (best is None or left < best[0]):
            best = left, axis, value
    if best is None or best[0] > _LEFT**2 * whole:
        return None
    return best[1], best[2]
