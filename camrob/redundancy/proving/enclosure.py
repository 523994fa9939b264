"""An upper bound of 1/k_F over boxes of the freedoms and bundles of poses, compiled.

All postures of a box at once, without an angle but the freedoms' own: the tool's frame is carried to the arm's shoulder in affine
forms, axis 1 and the elbow are a square root each (whose signs are the branches), and the homogeneous Jacobian and its inverse
follow from the blocks that the spherical wrist leaves (`camrob/kinematics/spherical_inverse`). The wrist's two flips share 1/k_F.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare, part
from camrob.redundancy.proving.affine import (
    SLACK,
    Form,
    cosine_sine,
    highest,
    inverse,
    lowest,
    minus,
    mixed,
    plus,
    root,
    scaled,
    shifted,
    square,
    times,
)
from camrob.redundancy.proving.arm_shape import ArmShape
from camrob.redundancy.proving.jacobian_norms import THIN, bound_of_way, flat_form, near_singular

__all__ = ["WAYS", "Vector", "bounds_of_arm", "bounds_of_box", "moved", "unturned"]

Array = NDArray[np.float64]
Vector = tuple[Form, Form, Form]
Turns = tuple[tuple[Form, Form], tuple[Form, Form], tuple[Form, Form], tuple[Form, Form]]

STRETCHED = 0.03  # share that the smallest squared area of shoulder, elbow and wrist in a box has of the largest
WAYS = 4
"""Of an arm to reach a pose, the wrist's two apart: 2 * (axis 1) + (elbow)."""


@part
def _turned(M: Array, v: Vector) -> Vector:
    return (
        mixed(M[0, 0], v[0], M[0, 1], v[1], M[0, 2], v[2], 0.0),
        mixed(M[1, 0], v[0], M[1, 1], v[1], M[1, 2], v[2], 0.0),
        mixed(M[2, 0], v[0], M[2, 1], v[1], M[2, 2], v[2], 0.0),
    )


@part
def moved(M: Array, v: Vector) -> Vector:
    """A point v seen from the frame that M (4, 4) leads to."""
    return (
        mixed(M[0, 0], v[0], M[0, 1], v[1], M[0, 2], v[2], M[0, 3]),
        mixed(M[1, 0], v[0], M[1, 1], v[1], M[1, 2], v[2], M[1, 3]),
        mixed(M[2, 0], v[0], M[2, 1], v[1], M[2, 2], v[2], M[2, 3]),
    )


@part
def unturned(c: Form, s: Form, v: Vector) -> Vector:
    """v seen from axes that are turned about z."""
    return plus(times(c, v[0]), times(s, v[1])), minus(times(c, v[1]), times(s, v[0])), v[2]


@bare
def _symbol(middle: float, half: float, i: int) -> Form:
    """A freedom's symbol, spread out to what it stands for."""
    e = SLACK * (abs(middle) + half)
    return middle, half if i == 0 else 0.0, half if i == 1 else 0.0, half if i == 2 else 0.0, 0.0, 0.0, e


@bare
def _within(middle: float, one: float, other: float, off: float) -> Form:
    """What changes with the two symbols of a bundle, and lies `off` from that at most."""
    return middle, 0.0, 0.0, 0.0, one, other, off + SLACK * (abs(middle) + abs(one) + abs(other))


@part
def _axes(shape: ArmShape, pose: Array) -> tuple[Vector, Vector, Vector]:
    """The tool's axes x, y, z, roll taken off, seen from the frame in which the turning freedom turns.

    Where z moves by d, x and y are carried along by the least rotation: x - (x . d) z, off by |d|^2 / 2 at most.
    """
    x, y, z, a, b, off = pose[0], pose[1], pose[2], pose[4], pose[6], pose[8, 0]
    far = np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) + np.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) + off
    beside = off + 0.5 * far * far
    xa, xb = -(x[0] * a[0] + x[1] * a[1] + x[2] * a[2]), -(x[0] * b[0] + x[1] * b[1] + x[2] * b[2])
    ya, yb = -(y[0] * a[0] + y[1] * a[1] + y[2] * a[2]), -(y[0] * b[0] + y[1] * b[1] + y[2] * b[2])
    return (
        _turned(
            shape.before,
            (
                _within(x[0], xa * z[0], xb * z[0], beside),
                _within(x[1], xa * z[1], xb * z[1], beside),
                _within(x[2], xa * z[2], xb * z[2], beside),
            ),
        ),
        _turned(
            shape.before,
            (
                _within(y[0], ya * z[0], yb * z[0], beside),
                _within(y[1], ya * z[1], yb * z[1], beside),
                _within(y[2], ya * z[2], yb * z[2], beside),
            ),
        ),
        _turned(
            shape.before,
            (_within(z[0], a[0], b[0], off), _within(z[1], a[1], b[1], off), _within(z[2], a[2], b[2], off)),
        ),
    )


@part
def _origin(shape: ArmShape, pose: Array, box: Array) -> Vector:
    """The tool's origin seen from the shoulder."""
    o, a, b, off = pose[3], pose[5], pose[7], pose[8, 1]
    p = moved(
        shape.first, (_within(o[0], a[0], b[0], off), _within(o[1], a[1], b[1], off), _within(o[2], a[2], b[2], off))
    )
    for i in range(shape.after.shape[0]):
        u = _symbol(box[0, i], box[1, i], i)
        if shape.prismatic[i]:
            p = p[0], p[1], minus(p[2], u)
        else:
            c, s = cosine_sine(u)
            p = unturned(c, s, p)
        p = moved(shape.after[i], p)
    whole: Vector = p
    return whole


@part
def _of_tool(shape: ArmShape, k: Array, axes: tuple[Vector, Vector, Vector], turns: Turns) -> Vector:
    """A vector (3,) of the tool seen from the shoulder.

    Across the turning axis it is a complex number: e^-ia ((p + iq) k e^ib + (r + is) conj(k e^ib) + n kz), with a the turn, b the
    roll, p + iq and r + is the turning and the mirroring part of the axes' block. The angles b - a and b + a are taken as wholes.
    """
    (x, y, z), (less, more, turn, roll) = axes, turns
    p, q = scaled(plus(x[0], y[1]), 0.5), scaled(minus(x[1], y[0]), 0.5)
    r, s = scaled(minus(x[0], y[1]), 0.5), scaled(plus(x[1], y[0]), 0.5)
    # k e^i(b - a), and conj(k) e^-i(b + a)
    e, f = mixed(k[0], less[0], -k[1], less[1], 0.0, p, 0.0), mixed(k[1], less[0], k[0], less[1], 0.0, p, 0.0)
    g, h = mixed(k[0], more[0], -k[1], more[1], 0.0, p, 0.0), mixed(-k[1], more[0], -k[0], more[1], 0.0, p, 0.0)
    real = plus(minus(times(p, e), times(q, f)), minus(times(r, g), times(s, h)))
    imag = plus(plus(times(p, f), times(q, e)), plus(times(r, h), times(s, g)))
    real = plus(real, scaled(plus(times(z[0], turn[0]), times(z[1], turn[1])), k[2]))
    imag = plus(imag, scaled(minus(times(z[1], turn[0]), times(z[0], turn[1])), k[2]))
    m, n = mixed(k[0], roll[0], -k[1], roll[1], 0.0, p, 0.0), mixed(k[1], roll[0], k[0], roll[1], 0.0, p, 0.0)
    up = plus(plus(times(x[2], m), times(y[2], n)), scaled(z[2], k[2]))
    whole: Vector = _turned(shape.behind, (real, imag, up))
    return whole


@part
def _turns_of(shape: ArmShape, box: Array) -> Turns:
    """Cosine and sine of roll - turn, roll + turn, turn and roll; the last freedom of a box is roll - mix * turn."""
    last = shape.lower.shape[0] - 1
    free = _symbol(box[0, last], box[1, last], last)
    turn = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if shape.turning >= 0:
        turn = _symbol(box[0, shape.turning], box[1, shape.turning], shape.turning)
    roll = plus(free, scaled(turn, shape.mix))
    less, more = plus(free, scaled(turn, shape.mix - 1.0)), plus(free, scaled(turn, shape.mix + 1.0))
    return cosine_sine(less), cosine_sine(more), cosine_sine(turn), cosine_sine(roll)


@part
def _angle_misses(c: Form, s: Form, zero: float, low: float, high: float) -> bool:
    """Whether no angle along (c, s), plus `zero`, lies in [low, high], turns apart."""
    far = np.sqrt((highest(c) - c[0]) ** 2 + (highest(s) - s[0]) ** 2) * 1.0001
    near = np.sqrt(c[0] * c[0] + s[0] * s[0])
    if far >= 0.7 * near:
        return False
    half = np.arcsin(far / near) * 1.0001 + 1e-12
    return bool(_misses(np.arctan2(s[0], c[0]) + zero, half, low, high))


@part
def _misses(middle: float, half: float, low: float, high: float) -> bool:
    """Whether [middle - half, middle + half] and [low, high] have nothing in common, turns apart."""
    center, room = 0.5 * (low + high), 0.5 * (high - low) + half + 1e-9
    d = middle - center
    d -= 2.0 * np.pi * np.round(d / (2.0 * np.pi))
    return bool(abs(d) > room)


@part
def bounds_of_box(shape: ArmShape, pose: Array, box: Array, alive: int, best: Array, below: Array) -> int:
    """Upper bounds of 1/k_F over a box.

    alive: the ways (bits) that are looked at. best (WAYS,) <- their bounds, 1 where nothing is known; below (WAYS, 7) <- forms
    that k_F^2 is nowhere below.
    Returns the ways that have postures, maybe.
    """
    axes, turns, p = _axes(shape, pose), _turns_of(shape, box), _origin(shape, pose, box)
    w, h6 = _of_tool(shape, shape.wrist, axes, turns), _of_tool(shape, shape.sixth, axes, turns)
    r = h6
    if shape.bent:
        r = _of_tool(shape, shape.lever, axes, turns)
    w = plus(w[0], p[0]), plus(w[1], p[1]), plus(w[2], p[2])
    left: int = bounds_of_arm(shape, w, h6, r, alive, best, below)
    return left


@part
def bounds_of_arm(shape: ArmShape, w: Vector, h6: Vector, r: Vector, alive: int, best: Array, below: Array) -> int:
    """`bounds_of_box` for a wrist, a sixth axis and (of an arm that is bent there) its lever, seen from the shoulder."""
    away = plus(square(w[0]), square(w[1]))  # from axis 1
    X2 = shifted(away, -shape.aside * shape.aside)
    high = highest(X2)
    if high < 0.0:
        return 0
    low = max(lowest(X2), 0.0)
    left = 0
    if low < THIN * high:  # axis 1 is near: its column of the Jacobian is short
        for way in range(WAYS):
            best[way] = near_singular(shape, 0.0, 0.0, 1.0 / (high + shape.aside * shape.aside), 0.0)
            _put(below, way, flat_form(best[way]))
        return alive
    c1 = s1 = over = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    X = root(X2, low, high)
    invX = inverse(X, np.sqrt(low), np.sqrt(high))
    if shape.aside == 0.0:
        c1, s1 = times(w[0], invX), times(w[1], invX)
    else:
        over = inverse(away, max(lowest(away), low), highest(away))
    for first in range(2):
        if not alive >> (2 * first) & 3:
            continue
        sign = 1.0 - 2.0 * first
        if shape.aside != 0.0:
            c1 = times(plus(scaled(times(w[0], X), sign), scaled(w[1], shape.aside)), over)
            s1 = times(minus(scaled(times(w[1], X), sign), scaled(w[0], shape.aside)), over)
            g6 = unturned(c1, s1, h6)
        else:
            g6 = unturned(scaled(c1, sign), scaled(s1, sign), h6)
        lever = scaled(g6[0], shape.along), scaled(g6[1], shape.along), scaled(g6[2], shape.along)
        if shape.bent:
            beside = r
            if shape.aside != 0.0:
                beside = unturned(c1, s1, r)
            else:
                beside = unturned(scaled(c1, sign), scaled(s1, sign), r)
            lever = plus(lever[0], beside[0]), plus(lever[1], beside[1]), plus(lever[2], beside[2])
        left = _elbows(shape, scaled(X, sign), scaled(invX, sign), w[2], g6, lever, alive, 2 * first, left, best, below)
    return left


@bare
def _put(below: Array, k: int, form: Form) -> None:
    for i in range(7):
        below[k, i] = form[i]


@part
def _elbows(
    shape: ArmShape,
    X: Form,
    invX: Form,
    height: Form,
    g6: Vector,
    r: Vector,
    alive: int,
    first: int,
    left: int,
    best: Array,
    below: Array,
) -> int:
    """The two ways of the elbow behind one of axis 1."""
    la2, lb2 = shape.forearm * shape.forearm, shape.upper_arm * shape.upper_arm
    vx, vz = shifted(X, -shape.x2), shifted(height, -shape.z2)
    D = plus(square(vx), square(vz))
    near, far = (shape.forearm - shape.upper_arm) ** 2, (shape.forearm + shape.upper_arm) ** 2
    Dlow, Dhigh = max(lowest(D), near * (1.0 - 1e-12)), min(highest(D), far * (1.0 + 1e-12))
    if Dlow > Dhigh:
        return left
    # (twice) the area of the triangle of shoulder, elbow and wrist, squared: Heron
    half = scaled(shifted(D, lb2 - la2), 0.5)
    G = minus(scaled(D, lb2), square(half))
    Ghigh = min(highest(G), la2 * lb2 * (1.0 + 1e-12))
    if Ghigh <= 0.0:
        return left
    Glow = lowest(G)
    least = (la2 + 0.5 * lb2 + Dlow) / Ghigh + 1.0 / highest(square(X))
    rough = near_singular(shape, np.sqrt(max(lowest(square(X)), 0.0)), np.sqrt(Dlow), least, 0.0)
    if Dlow < THIN * Dhigh:
        best[first] = best[first + 1] = rough
        _put(below, first, flat_form(rough))
        _put(below, first + 1, flat_form(rough))
        return left | (alive & (3 << first))
    one = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    S = root(G, max(Glow, 0.0), Ghigh)
    invD = inverse(D, Dlow, Dhigh)
    alpha = shifted(scaled(invD, 0.5 * (lb2 - la2)), 0.5)
    beta = times(S, invD)
    stretched = Glow < STRETCHED * Ghigh  # nearly: all is multiplied by the area, then
    over = one if stretched else inverse(S, np.sqrt(Glow), np.sqrt(Ghigh))
    triangle = vx, vz, G, S, over, alpha, beta, D
    for elbow in range(2):
        k, sign = first + elbow, 1.0 - 2.0 * elbow
        if alive >> k & 1 and _elbow(shape, X, invX, height, g6, r, triangle, sign, stretched, Ghigh, k, best, below):
            best[k] = min(rough, best[k])
            left |= 1 << k
    return left


@part
def _elbow(
    shape: ArmShape,
    X: Form,
    invX: Form,
    height: Form,
    g6: Vector,
    r: Vector,
    triangle: tuple[Form, Form, Form, Form, Form, Form, Form, Form],
    sign: float,
    stretched: bool,
    Ghigh: float,
    k: int,
    best: Array,
    below: Array,
) -> bool:
    """Way k, the elbow on one side (sign) of the triangle: v, its area squared and signed, one over it, the elbow's share of v
    along and across, v squared. Whether any of it keeps the limits; best[k], below[k] <- its bound and form.
    """
    vx, vz, G, S, over, alpha, beta, D = triangle
    la2, lb2 = shape.forearm * shape.forearm, shape.upper_arm * shape.upper_arm
    one = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    signed = scaled(beta, sign)
    bx, bz = plus(times(alpha, vx), times(signed, vz)), minus(times(alpha, vz), times(signed, vx))
    if _out_of_limits(shape, scaled(shifted(D, -la2 - lb2), 0.5), scaled(S, -sign), bx, bz):
        return False
    fx, fz = minus(vx, bx), minus(vz, bz)
    h4 = (
        plus(scaled(fx, shape.fourth[0]), scaled(fz, shape.fourth[1])),
        shape.fourth[2],
        minus(scaled(fz, shape.fourth[0]), scaled(fx, shape.fourth[1])),
    )
    kappa = plus(plus(times(h4[0], g6[0]), times(h4[2], g6[2])), scaled(g6[1], h4[1]))
    if _wrist_misses(shape, kappa):
        return False
    area = (G, scaled(S, -sign)) if stretched else (one, one)
    invg = one if stretched else scaled(over, -sign)
    most = np.sqrt(Ghigh) if stretched else 1.0
    v, b, f = (vx, vz), (bx, bz), (fx, fz)
    value, form = bound_of_way(shape, X, invX, height, D, invg, area, most, v, b, f, h4, g6, r, kappa)
    best[k] = value
    _put(below, k, form)
    return True


@part
def _out_of_limits(shape: ArmShape, cosine: Form, sine: Form, bx: Form, bz: Form) -> bool:
    """Whether axes 2 and 3 miss their limits: the elbow's cosine and sine, and the upper arm."""
    if _angle_misses(cosine, sine, shape.third[0], shape.third[1], shape.third[2]):
        return True
    zx, zz = shape.zero_upper[0], shape.zero_upper[1]
    across = minus(scaled(bx, zz), scaled(bz, zx))
    return bool(_angle_misses(plus(scaled(bx, zx), scaled(bz, zz)), across, 0.0, shape.q_lower[1], shape.q_upper[1]))


@part
def _wrist_misses(shape: ArmShape, kappa: Form) -> bool:
    """Whether neither flip of the wrist with this cosine of its bend keeps the fifth joint's limits."""
    most, least = np.arccos(max(-1.0, min(1.0, lowest(kappa)))), np.arccos(max(-1.0, min(1.0, highest(kappa))))
    middle, half = 0.5 * (most + least), 0.5 * (most - least)
    low, high = shape.q_lower[4], shape.q_upper[4]
    return bool(
        _misses(shape.wrist_zero + middle, half, low, high) and _misses(shape.wrist_zero - middle, half, low, high)
    )
