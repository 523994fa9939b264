"""What 1/k_F is made of, enclosed: the squared norms of the homogeneous Jacobian and of its inverse, seen from the shoulder."""

from __future__ import annotations

import numpy as np

from camrob.compiled import bare, part
from camrob.redundancy.proving.affine import (
    SLACK,
    Form,
    highest,
    inverse,
    lowest,
    minus,
    plus,
    scaled,
    shifted,
    square,
    times,
)
from camrob.redundancy.proving.arm_shape import ArmShape

__all__ = ["THIN", "bound_of_way", "flat_form", "near_singular"]

Vector = tuple[Form, Form, Form]

PAD = 1e-8  # relative: what it comes to in 1/k_F that axes within 1e-9 rad count as square and levers within 1e-9 m as none
THIN = 1e-3  # share of the most of what is divided by: below, only what is left near a singular posture is asked


@part
def _dot(a: Vector, b: Vector) -> Form:
    whole: Form = plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))
    return whole


@part
def _norm(a: Vector) -> Form:
    whole: Form = plus(plus(square(a[0]), square(a[1])), square(a[2]))
    return whole


@part
def near_singular(shape: ArmShape, axis1: float, axis2: float, rows: float, wrist: float) -> float:
    """The bound that is left near a singular posture: the inverse's squared norm is at least one part of it, L^2 rows or `wrist`.

    axis1, axis2: m that the wrist keeps from these axes at least; the plate may be nearer by the wrist's distance from it.
    """
    L2, back = shape.length * shape.length, np.sqrt(shape.reach2)
    one = max(0.0, axis1 - back) ** 2 + max(0.0, axis2 - back) ** 2 + max(0.0, shape.forearm - back) ** 2
    return float(min(1.0, 6.0 / np.sqrt((6.0 + one / L2) * max(L2 * rows, wrist, 1e-12)) * (1.0 + PAD)))


@bare
def flat_form(bound: float) -> Form:
    """The form that k_F^2 is nowhere below where 1/k_F is nowhere above a bound."""
    return (1.0 - SLACK) / (bound * bound), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@part
def bound_of_way(
    shape: ArmShape,
    X: Form,
    invX: Form,
    height: Form,
    D: Form,
    invg: Form,
    area: tuple[Form, Form],
    most: float,
    v: tuple[Form, Form],
    b: tuple[Form, Form],
    f: tuple[Form, Form],
    h4: tuple[Form, float, Form],
    g6: Vector,
    r: Vector,
    kappa: Form,
) -> tuple[float, Form]:
    """The bound of a way whose first three axes are regular all over the box, and a form that k_F^2 is nowhere below.

    invg: one over the triangle's (signed) area, twice; area, most: all ones. Where the area may be none: one, the area squared
    and signed, and the most that it can be; the inverse is then reckoned times the area.
    """
    L2, r2 = shape.length * shape.length, shape.reach2
    bend = shifted(scaled(square(kappa), -1.0), 1.0)  # sine squared
    low = lowest(bend)
    flat = max(-highest(kappa), lowest(kappa), 0.0)
    if low < THIN:
        straight = max(2.0 - 2.0 * flat, 1e-12)
        bound = float(near_singular(shape, 0.0, 0.0, 0.0, 2.0 / (straight * (1.0 + r2 / L2))))
        return bound, flat_form(bound)
    over = inverse(bend, low, min(1.0, highest(bend)))
    one = _square_of_jacobian(shape, X, height, f, h4, g6, r, over)
    two = _square_of_inverse(shape, invX, D, invg, area, v, b, f, h4, g6, r, kappa, over)
    product = times(one, two)
    least = max(lowest(product), max(lowest(one), 6.0) * max(lowest(two), 0.0))
    bound = 1.0
    if least > 0.0:
        bound = float(min(1.0, 6.0 * most / np.sqrt(least) * (1.0 + PAD)))
    return bound, scaled(product, (1.0 - 2.0 * PAD) / (36.0 * most * most))


@part
def _square_of_jacobian(
    shape: ArmShape,
    X: Form,
    height: Form,
    f: tuple[Form, Form],
    h4: tuple[Form, float, Form],
    g6: Vector,
    r: Vector,
    over: Form,
) -> Form:
    """The squared norm of the homogeneous Jacobian at the plate; over: one over the squared sine of the wrist's bend."""
    L2, r2 = shape.length * shape.length, shape.reach2
    px, py, pz = plus(X, r[0]), shifted(r[1], shape.aside), plus(height, r[2])
    first = plus(square(px), square(py))
    second = plus(square(shifted(px, -shape.x2)), square(shifted(pz, -shape.z2)))
    third = plus(square(plus(f[0], r[0])), square(plus(f[1], r[2])))
    across = plus(plus(times(h4[0], r[0]), times(h4[2], r[2])), scaled(r[1], h4[1]))
    wrist = shifted(scaled(square(across), -1.0), 3.0 * r2 - shape.along * shape.along)
    if shape.bent:  # the fifth axis along h4 x h6
        n = (
            minus(scaled(g6[2], h4[1]), times(h4[2], g6[1])),
            minus(times(h4[2], g6[0]), times(h4[0], g6[2])),
            minus(times(h4[0], g6[1]), scaled(g6[0], h4[1])),
        )
        wrist = minus(wrist, times(square(_dot(n, r)), over))
    whole: Form = shifted(scaled(plus(plus(first, second), plus(third, wrist)), 1.0 / L2), 6.0)
    return whole


@part
def _square_of_inverse(
    shape: ArmShape,
    invX: Form,
    D: Form,
    invg: Form,
    area: tuple[Form, Form],
    v: tuple[Form, Form],
    b: tuple[Form, Form],
    f: tuple[Form, Form],
    h4: tuple[Form, float, Form],
    g6: Vector,
    r: Vector,
    kappa: Form,
    over: Form,
) -> Form:
    """The squared norm of the Jacobian's inverse, times the squared area."""
    L2, r2, la2 = shape.length * shape.length, shape.reach2, shape.forearm * shape.forearm
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    # the inverse: rows of the first three axes' block
    G, g = area
    invX2, invG = times(square(invX), G), square(invg)
    size = shifted(D, la2)
    fr, vr = plus(times(f[0], r[0]), times(f[1], r[2])), plus(times(v[0], r[0]), times(v[1], r[2]))
    qx, qz = scaled(times(b[0], invg), -1.0), scaled(times(b[1], invg), -1.0)
    qy = none
    if shape.aside != 0.0:
        y = scaled(invX, shape.aside)
        size = plus(size, times(square(y), plus(square(f[0]), square(v[0]))))
        fr, vr = plus(fr, times(times(f[0], y), r[1])), plus(vr, times(times(v[0], y), r[1]))
        qy = times(qx, y)
    N = plus(invX2, times(size, invG))
    two = minus(scaled(N, L2 + r2), plus(times(invX2, square(r[1])), times(invG, plus(square(fr), square(vr)))))
    # and of the wrist's: columns of the inverse's lower half before the wrist's own block is taken off
    tx, ty, tz = (
        minus(times(qy, r[2]), times(qz, r[1])),
        minus(times(qz, r[0]), times(qx, r[2])),
        minus(times(qx, r[1]), times(qy, r[0])),
    )
    invX = times(invX, g)
    ux, uz = times(r[2], invX), scaled(times(r[0], invX), -1.0)
    L = shape.length
    columns = (
        (none, scaled(qx, L), none),
        (none, scaled(qy, L), scaled(invX, L)),
        (none, scaled(qz, L), none),
        (g, scaled(tx, -1.0), scaled(ux, -1.0)),
        (none, minus(g, ty), none),
        (none, scaled(tz, -1.0), minus(g, uz)),
    )
    A4 = A6 = A46 = whole = none
    for y3 in columns:
        p4 = plus(plus(times(h4[0], y3[0]), times(h4[2], y3[2])), scaled(y3[1], h4[1]))
        p6 = _dot(g6, y3)
        whole = plus(whole, _norm(y3))
        A4, A6, A46 = plus(A4, square(p4)), plus(A6, square(p6)), plus(A46, times(p4, p6))
    skew = minus(times(kappa, plus(A4, A6)), times(shifted(square(kappa), 1.0), A46))
    total: Form = plus(two, plus(whole, scaled(times(times(kappa, skew), square(over)), 2.0)))
    return total
