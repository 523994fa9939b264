"""A ray through a cutter, and how far a point lies off its envelope. Compiled parts; lengths in m.

A ray runs along the third of its coordinates (u, v, w). The cutter stands with its tip at the origin, its axis (nu, nv, nw)
from the tip to the holder. It is convex, so that a ray has one stretch inside.
"""

from __future__ import annotations

import math

from camrob.compiled import part

__all__ = ["RIM", "off_envelope", "outward", "outward_at_rim", "stretch_inside"]

_FLAT = 1e-12  # of a unit: a ray that is as good as parallel
_NEAR = 1e-9  # m: a nanometre off the envelope is on it
RIM = 2e-6
"""m off a sharp rim within which a point is on it: a floor that a flat cutter swept is found under the rim as well as inside."""
_STEPS = 60  # towards a rounded corner: Newton's, five or so but for rays that graze


@part
def off_envelope(x: float, y: float, z: float, nu: float, nv: float, nw: float, R: float, c: float, L: float) -> float:
    """Distance from the envelope, below 0 inside."""
    h = x * nu + y * nv + z * nw
    rho = math.sqrt(max(x * x + y * y + z * z - h * h, 0.0))
    if h < c and rho > R - c:
        return math.sqrt((rho - (R - c)) ** 2 + (h - c) ** 2) - c
    side = rho - R
    end = max(-h, h - L)
    if side > 0.0 and end > 0.0:
        return math.sqrt(side * side + end * end)
    return max(side, end)


@part
def outward(
    x: float, y: float, z: float, nu: float, nv: float, nw: float, R: float, c: float, L: float
) -> tuple[float, float, float]:
    """The envelope's outward normal at a point on it."""
    h = x * nu + y * nv + z * nw
    ru, rv, rw = x - h * nu, y - h * nv, z - h * nw
    rho = math.sqrt(ru * ru + rv * rv + rw * rw)
    across = 1.0 / max(rho, 1e-15)
    if h < c and rho > R - c:
        out, along = rho - (R - c), h - c
        size = 1.0 / max(math.sqrt(out * out + along * along), 1e-15)
        a, b = out * size * across, along * size
    elif rho - R >= max(-h, h - L):
        a, b = across, 0.0
    else:
        a, b = 0.0, (1.0 if h - L > -h else -1.0)
    return a * ru + b * nu, a * rv + b * nv, a * rw + b * nw


@part
def outward_at_rim(
    ru: float, rv: float, rw: float, nu: float, nv: float, nw: float, vu: float, vv: float, vw: float
) -> tuple[float, float, float]:
    """The normal of what a flat cutter's rim sweeps, out of the cutter: across its way v, between the bottom's and the wall's.

    (ru, rv, rw): from the axis to the rim, (nu, nv, nw): the axis. Where the way leaves the rim no such side (it dives,
    or goes along the rim), it is the bottom's.
    """
    size = 1.0 / max(math.sqrt(ru * ru + rv * rv + rw * rw), 1e-15)
    out = size * (ru * vu + rv * vv + rw * vw)
    up = nu * vu + nv * vv + nw * vw
    if out * up <= 0.0:
        return -nu, -nv, -nw
    one = 1.0 / math.sqrt(out * out + up * up)
    a, b = one * abs(up) * size, -one * abs(out)
    return a * ru + b * nu, a * rv + b * nv, a * rw + b * nw


@part
def _cylinder(
    ou: float, ov: float, ow: float, nu: float, nv: float, nw: float, R: float, low: float, high: float
) -> tuple[float, float]:
    """Where a ray is inside a cylinder of heights low to high; the first beyond the second where nowhere."""
    on = ou * nu + ov * nv + ow * nw
    a = 1.0 - nw * nw
    c = ou * ou + ov * ov + ow * ow - on * on - R * R
    if a < _FLAT:
        if c > 0.0:
            return 1.0, -1.0
        first, last = -math.inf, math.inf
    else:
        b = ow - on * nw
        disc = b * b - a * c
        if disc <= 0.0:
            return 1.0, -1.0
        root = math.sqrt(disc)
        first, last = (-b - root) / a, (-b + root) / a
    if abs(nw) < _FLAT:
        return (first, last) if low <= on <= high else (1.0, -1.0)
    s0, s1 = (low - on) / nw, (high - on) / nw
    return max(first, min(s0, s1)), min(last, max(s0, s1))


@part
def _to_corner(
    ou: float, ov: float, ow: float, s: float, way: float, nu: float, nv: float, nw: float, R: float, c: float
) -> float:
    """From where a ray enters the cylinder about a cutter (way 1) or leaves it (-1): where it is at the cutter itself.

    The distance from a convex body is a convex function along a ray, so that Newton's steps from outside never go too far.
    Infinite, with the sign of the way, for a ray that goes past the rounded corner.
    """
    for _ in range(_STEPS):
        w = ow + s
        h = ou * nu + ov * nv + w * nw
        rho = math.sqrt(max(ou * ou + ov * ov + w * w - h * h, 0.0))
        if h >= c or rho <= R - c:
            return s
        out, along = rho - (R - c), h - c
        away = math.sqrt(out * out + along * along)
        if away - c < _NEAR:
            return s
        slope = way * (out * (w - h * nw) / rho + along * nw) / away
        if slope >= -_FLAT:
            break
        s -= way * (away - c) / slope
    return way * math.inf


@part
def stretch_inside(
    ou: float, ov: float, ow: float, nu: float, nv: float, nw: float, R: float, c: float, L: float
) -> tuple[float, float]:
    """The ray (ou, ov, ow + s) inside the cutter: s from first to last; the first beyond the second where nowhere."""
    if c >= R:
        first, last = _cylinder(ou, ov, ow, nu, nv, nw, R, c, L)
        bu, bv, bw = ou - c * nu, ov - c * nv, ow - c * nw
        disc = c * c - bu * bu - bv * bv
        if disc > 0.0:
            root = math.sqrt(disc)
            if first > last:
                return -bw - root, -bw + root
            return min(first, -bw - root), max(last, -bw + root)
        return first, last
    first, last = _cylinder(ou, ov, ow, nu, nv, nw, R, 0.0, L)
    if c <= 0.0 or first > last:
        return first, last
    first = _to_corner(ou, ov, ow, first, 1.0, nu, nv, nw, R, c)
    last = _to_corner(ou, ov, ow, last, -1.0, nu, nv, nw, R, c)
    return (first, last) if first < math.inf > -last else (1.0, -1.0)
