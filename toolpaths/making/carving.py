"""A frog on a plinth: expanded polystyrene, carved from above and, turned by 90 degrees, from the front (3+2)."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from making.clsf import APPROACH, ENGAGE, RAPID, STEP, Clsf
from making.drop_cutter import drop, thin
from making.mesh import rounded_slab, stl, surface_net

__all__ = ["frog", "make", "part"]

Array = NDArray[np.float64]
PLINTH = (240.0, 160.0, 90.0)  # mm
PLINTH_CORNER = 16.0
SCALE = 0.74  # of the frog: no higher than the spindle's nose stands off the ball, 80 mm
RADIUS = 5.0  # of the ball
TLDATA = (10.0, 5.0, 75.0, 0.0, 0.0)
TOP_MSYS = (0, 0, 0, 1, 0, 0, 0, 1, 0)
FRONT_MSYS = (0, -80, 0, 1, 0, 0, 0, 0, 1)  # Z looks out of the plinth's front: part's -y
STEPOVER = 3.2
CHORD = 0.03  # what thinning may leave
ARC = 10.0  # radius of leads
TOP_CLEAR, FRONT_CLEAR = 190.0, 30.0
TOP_AWAY, FRONT_AWAY = 300.0, 150.0  # where the tool may turn between the regions
DEEPEST = -70.0  # front region: the spindle's nose stays in front of the plinth
FEED, FEED_STEP, FEED_ENGAGE = 6000.0, 4500.0, 3000.0


def _ellipsoid(p: Array, center: tuple[float, ...], radii: tuple[float, ...]) -> Array:
    q = (p - np.array(center)) / np.array(radii)
    k0 = np.linalg.norm(q, axis=-1)
    k1 = np.linalg.norm(q / np.array(radii), axis=-1)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def _capsule(p: Array, a: tuple[float, ...], b: tuple[float, ...], radius: float) -> Array:
    start, along = np.array(a), np.array(b) - np.array(a)
    t = np.clip((p - start) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(p - start - t[..., None] * along, axis=-1) - radius


def _blend(a: Array, b: Array, width: float) -> Array:
    h = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - 0.25 * width * h * h


def frog(p: Array) -> Array:
    """Signed field of the frog at points (n, 3), negative inside. It looks along -y; left mirrors right."""
    foot = np.array([0.0, 0.0, PLINTH[2]])
    return SCALE * _full_size((p - foot) / SCALE + foot)


def _full_size(p: Array) -> Array:
    p = np.concatenate([np.abs(p[:, :1]), p[:, 1:]], axis=1)
    x, y, z = p.T
    body = _ellipsoid(p, (0, 26, 124), (62, 68, 42))
    head = _ellipsoid(p, (0, -34, 140), (57, 42, 31))
    d = _blend(body, head, 26.0)
    haunch = _ellipsoid(p, (68, 42, 114), (27, 42, 31))
    d = _blend(d, haunch, 10.0)
    foot = _capsule(p, (82, 34, 96), (98, -8, 96), 9.0)
    for end in ((86, -40, 94), (103, -42, 94), (119, -34, 94)):
        foot = _blend(foot, _capsule(p, (97, -6, 95), end, 5.5), 5.0)
        foot = _blend(foot, np.linalg.norm(p - np.array(end), axis=-1) - 7.5, 3.0)
    d = _blend(d, foot, 6.0)
    arm = _blend(
        _capsule(p, (44, -28, 122), (60, -46, 104), 13.0), _capsule(p, (60, -46, 104), (57, -58, 96), 9.0), 8.0
    )
    for end in ((42, -78, 94), (57, -82, 94), (72, -77, 94)):
        arm = _blend(arm, _capsule(p, (57, -58, 95), end, 5.5), 5.0)
        arm = _blend(arm, np.linalg.norm(p - np.array(end), axis=-1) - 7.0, 3.0)
    d = _blend(d, arm, 8.0)
    smile = 130.0 + 12.0 * (x / 55.0) ** 2
    d = d + 3.2 * np.exp(-(((z - smile) / 3.4) ** 2)) * (y < 0) * np.clip(-(y + 12) / 14, 0, 1)
    eye = np.linalg.norm(p - np.array((33, -40, 170)), axis=-1) - 20.0
    d = _blend(d, eye, 7.0)
    # a pupil on the eye's front, a nostril, and two ridges down the back
    d = d + 3.0 * np.exp(-((((x - 36) / 7.0) ** 2 + ((z - 171) / 4.2) ** 2) ** 2)) * (y < -48)
    d = d + 2.5 * np.exp(-(((x - 11) / 4.0) ** 2 + ((z - 154) / 4.0) ** 2)) * (y < -55)
    ridge = 24.0 - 0.06 * (y - 20)
    return d - 2.6 * np.exp(-(((x - ridge) / 5.0) ** 2)) * np.clip((y + 5) / 25, 0, 1) * np.clip((z - 135) / 15, 0, 1)


def part() -> trimesh.Trimesh:
    """Plinth and frog, two closed shells that overlap by a few millimetres."""
    low, high = np.array([-99.0, -72.0, 82.0]), np.array([99.0, 75.0, 171.0])

    def cut_off(p: Array) -> Array:
        return np.maximum(frog(p), 86.0 - p[:, 2])

    body = surface_net(cut_off, low, high, 3.95)
    return trimesh.util.concatenate([rounded_slab(PLINTH, PLINTH_CORNER), body])


def _in_msys(triangles: Array, msys: tuple[float, ...]) -> Array:
    m = np.array(msys, dtype=float)
    axes = np.stack([m[3:6], m[6:9], np.cross(m[3:6], m[6:9])])
    return (triangles - m[:3]) @ axes.T


def _engage(out: Clsf, tip: Array, sign: float, clear: float) -> None:
    """From above onto a pass that runs along sign * x: a quarter circle in the upright plane of the pass."""
    x, y, z = np.round(tip, 4)
    out.rapid((x - sign * ARC, y, clear))
    if clear - z - ARC > 5.0:
        out.rapid((x - sign * ARC, y, z + ARC + 3.0), color=APPROACH)
    out.cut((x - sign * ARC, y, z + ARC), FEED_ENGAGE, color=ENGAGE)
    out.arc((x, y, z + ARC), (0, -sign, 0), ARC, (x, y, z), FEED_ENGAGE, color=ENGAGE)


def _depart(out: Clsf, tip: Array, sign: float, clear: float) -> None:
    x, y, z = np.round(tip, 4)
    out.arc((x, y, z + ARC), (0, -sign, 0), ARC, (x + sign * ARC, y, z + ARC), FEED_ENGAGE, color=STEP)
    out.rapid((x + sign * ARC, y, clear), color=RAPID)


def _profile(triangles: Array, a: Array, b: Array, floor: float) -> Array:
    """Tips (n, 3) from over a to over b (xy): steps of 1 mm, finer where the ball falls or climbs steeply."""
    length = float(np.linalg.norm(b - a))
    share = np.linspace(0.0, 1.0, max(2, int(np.ceil(length)) + 1))
    z = drop(triangles, a + share[:, None] * (b - a), RADIUS, floor) - RADIUS
    for _ in range(8):
        steep = np.flatnonzero((np.abs(np.diff(z)) > 0.4) & (np.diff(share) * length > 0.005))
        if not len(steep):
            break
        middle = 0.5 * (share[steep] + share[steep + 1])
        between = drop(triangles, a + middle[:, None] * (b - a), RADIUS, floor) - RADIUS
        share, z = np.insert(share, steep + 1, middle), np.insert(z, steep + 1, between)
    return np.column_stack([a + share[:, None] * (b - a), z])


def _link(out: Clsf, triangles: Array, a: Array, b: Array, floor: float) -> None:
    """From the end of a pass to the start of the next one, over whatever stands between."""
    tip = _profile(triangles, a[:2], b[:2], floor)
    out.cut(tip[thin(tip, CHORD)][1:], FEED_STEP, color=STEP)


def _top(out: Clsf, triangles: Array) -> None:
    t = _in_msys(triangles, TOP_MSYS)
    out.operation("ZIGZAG_TOP", "BALL_10", TLDATA, TOP_MSYS, 9000)
    rows = np.arange(-78.4, 78.5, STEPOVER)
    side = PLINTH[0] / 2
    out.rapid((-side - ARC, rows[0], TOP_AWAY))
    for band in np.array_split(np.arange(len(rows)), 5):
        tip = np.empty((0, 3))
        for n, row in enumerate(rows[band]):
            before = tip
            sign = 1.0 if n % 2 == 0 else -1.0
            tip = _profile(t, np.array([-sign * side, row]), np.array([sign * side, row]), PLINTH[2] + RADIUS)
            tip = tip[thin(tip, CHORD)]
            if n == 0:
                _engage(out, tip[0], sign, TOP_CLEAR)
            else:
                _link(out, t, before[-1], tip[0], PLINTH[2] + RADIUS)
            out.cut(tip[1:], FEED)
        _depart(out, tip[-1], sign, TOP_CLEAR)
    _frame(out, (116.0, 76.0), (0.0, 0.0), 12.0, PLINTH[2], TOP_CLEAR)
    out.rapid((ARC, -76.0, TOP_AWAY))
    out.end()


def _frame(
    out: Clsf, half: tuple[float, float], at: tuple[float, float], corner: float, z: float, clear: float
) -> None:
    """A rounded rectangle, anticlockwise from the middle of its lower side, with true corner arcs."""
    (hx, hy), (cx, cy), r = half, at, corner
    _engage(out, np.array([cx, cy - hy, z]), 1.0, clear)
    for sx, sy, quarter in ((1, -1, 0), (1, 1, 1), (-1, 1, 2), (-1, -1, 3)):
        middle = np.array([cx + sx * (hx - r), cy + sy * (hy - r), z])
        before, after = [np.array(v) * r for v in (((0, -1, 0), (1, 0, 0)), ((1, 0, 0), (0, 1, 0)))[quarter % 2]]
        turn = 1.0 if quarter < 2 else -1.0
        out.cut(middle + turn * before, FEED)
        out.arc(middle, (0, 0, 1), r, middle + turn * after, FEED)
    out.cut((cx, cy - hy, z), FEED)
    _depart(out, np.array([cx, cy - hy, z]), 1.0, clear)


def _tracks(t: Array) -> list[list[Array]]:
    """Zig-zags of the front: runs of neighbouring rows that follow one another, where the ball touches the frog."""
    tracks: list[list[Array]] = []
    for row in np.arange(PLINTH[2] + RADIUS, 170.0, STEPOVER):
        tip = _profile(t, np.array([-100.0, row]), np.array([100.0, row]), DEEPEST)
        solid = np.flatnonzero(tip[:, 2] > DEEPEST)
        for run in np.split(solid, np.flatnonzero(np.diff(solid) > 1) + 1):
            here = tip[run]
            if np.ptp(here[:, 0]) < 8.0:
                continue
            for track in tracks:
                last = track[-1]
                joins = np.linalg.norm(here[-1 if len(track) % 2 else 0] - last[-1]) < 14.0
                if joins and abs(here[0, 1] - last[0, 1] - STEPOVER) < 1e-6:
                    track.append(here[::-1] if len(track) % 2 else here)
                    break
            else:
                tracks.append([here])
    return tracks


def _front(out: Clsf, triangles: Array) -> None:
    t = _in_msys(triangles, FRONT_MSYS)
    out.operation("ZIGZAG_FRONT", "BALL_10", TLDATA, FRONT_MSYS, 9000)
    tracks = _tracks(t)
    out.rapid((*tracks[0][0][0][:2], FRONT_AWAY))
    for track in tracks:
        start = track[0][0]
        out.rapid((*start[:2], FRONT_CLEAR))
        out.rapid((*start[:2], start[2] + 12.0), color=APPROACH)
        out.cut(start, FEED_ENGAGE, color=ENGAGE)
        for n, run in enumerate(track):
            if n:
                _link(out, t, track[n - 1][-1], run[0], DEEPEST)
            out.cut(run[thin(run, CHORD)][1:], FEED)
        end = track[-1][-1]
        out.cut(end + np.array([0, 0, 12.0]), FEED_ENGAGE, color=STEP)
        out.rapid((*end[:2], FRONT_CLEAR))
    for inset in (0.0, 3.0, 6.0):
        _frame(out, (96.0 - inset, 35.0 - inset), (0.0, 45.0), 20.0 - inset, 0.0, FRONT_CLEAR)
    out.rapid((ARC, 16.0, FRONT_AWAY))
    out.end()


def make() -> tuple[Clsf, bytes]:
    """The CL file and the part's STL."""
    data, triangles = stl(part())
    out = Clsf()
    _top(out, triangles)
    _front(out, triangles)
    return out, data
