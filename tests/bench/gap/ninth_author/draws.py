"""How the keys of causes are drawn, and which keys span what somebody could explain by a name.

A draw takes (rng, arm, kind of log) and gives a key and the axes that the cause sits on; a `keys` takes (arm, kind).
"""

from __future__ import annotations

import numpy as np

__all__ = [
    "axes",
    "compliance",
    "drift",
    "drift_keys",
    "friction",
    "friction_keys",
    "hand",
    "hand_keys",
    "lag",
    "name",
    "nothing",
    "one",
    "payload",
    "payload_keys",
    "poles",
    "rail",
    "rail_keys",
    "ripple",
    "row_keys",
    "rows",
    "six",
    "six_keys",
    "unit",
    "warm",
    "warm_keys",
    "wobble",
    "wobble_keys",
    "zeros",
]


def axes(arm):
    return list(range(arm.first, arm.n))


def each(arm, make):
    return [make(i) for i in axes(arm)]


def unit(n, i, v=1.0):
    out = [0.0] * n
    out[i] = v
    return tuple(out)


def name(arm, *indices):
    return [arm.names[i] for i in indices]


def moving(rng, arm, low=0, high=None):
    """An axis that the work moves: of the arm's first ones."""
    return int(rng.choice(axes(arm)[low : high or min(4, len(axes(arm)) - 1)]))


def lag(rng, arm, kind):
    way = ["follower", "late feed-forward"][int(rng.integers(2))]
    odd = moving(rng, arm)
    factors = [0.0] * arm.n
    for i in axes(arm):
        factors[i] = 1.7 if i == odd else 1.0
    return (way, tuple(factors)), name(arm, *axes(arm))


def one(make, low=0, high=None):
    def draw(rng, arm, kind):
        i = moving(rng, arm, low, high)
        return make(rng, arm, i), name(arm, i)

    return draw


def friction(rng, arm, i):
    return i, ["lugre", "stribeck"][int(rng.integers(2))], float(rng.uniform(1e-4, 6e-4)), float(rng.uniform(0.2, 0.7))


def friction_keys(arm, kind):
    return [(i, way, 3e-4, c) for i in axes(arm) for way, c in (("lugre", 0.2), ("lugre", 0.7), ("stribeck", 1.0))]


def compliance(rng, arm, kind):
    loaded = np.abs(arm.loads(arm.middle[None])[0]) * arm.soft > 1e-6
    factors = np.where(loaded, rng.uniform(0.6, 1.4, arm.n), 0.3)
    factors[: arm.first] = 0
    return (tuple(map(float, factors)), float(rng.uniform(0.3, 0.9))), [arm.names[i] for i in np.flatnonzero(loaded)]


def payload(rng, arm, kind):
    return tuple(map(float, rng.uniform(-1, 1, 3) * [0.12, 0.12, 0.2] + [0, 0, 0.12])), []


def payload_keys(arm, kind):
    return [(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2)]


def zeros(rng, arm, kind):
    turning = [i for i in axes(arm)[:-1] if not arm.slides[i]]
    hit = rng.choice(turning, size=min(int(rng.integers(1, 4)), len(turning)), replace=False)
    key = np.zeros(arm.n)
    key[hit] = rng.choice([-1, 1], len(hit)) * rng.uniform(0.5, 1.5, len(hit))
    return tuple(map(float, key)), name(arm, *sorted(map(int, hit)))


def rows(rng, arm, kind):
    rows = sorted(map(int, rng.choice(axes(arm)[:-1], size=min(3, len(axes(arm)) - 1), replace=False)))
    size = [1e-3 * (0.3 + np.hypot(*arm.rows[i][[1, 3]])) for i in rows]
    return (
        tuple(
            (i, tuple(map(float, g * rng.normal(size=6) * [1, 0, 1, 0.4, 0.4, 0])))
            for i, g in zip(rows, size, strict=True)
        ),
        name(arm, *rows),
    )


def row_keys(arm, kind):
    return [((i, unit(6, k)),) for i in axes(arm)[:-1] for k in (0, 2, 3, 4)]


def six(shares):
    def draw(rng, arm, kind):
        return tuple(map(float, rng.normal(size=6) * shares)), []

    return draw


def six_keys(shares):
    return lambda arm, kind: [unit(6, k) for k in range(6) if shares[k]]


def wobble(rng, arm, kind):
    w = rng.normal(size=(4, 6)) * [1, 1, 0.5, 0.5, 0.5, 0.6]
    w[2:, :5] *= 0.2
    w[:2, 5] *= 0.3
    return tuple(map(tuple, w.tolist())), ["E2"]


def wobble_keys(arm, kind):
    return [tuple(unit(6, k) if r == m else (0.0,) * 6 for m in range(4)) for r in range(4) for k in range(6)]


def rail(rng, arm, kind):
    shape = rng.normal(size=(2, 9)) * [[1.0], [0.7]]
    return (*map(tuple, shape.tolist()), float(rng.normal())), ["E1"]


def rail_keys(arm, kind):
    none = (0.0,) * 9
    return (
        [(unit(9, k), none, 0.0) for k in range(9)] + [(none, unit(9, k), 0.0) for k in range(9)] + [(none, none, 1.0)]
    )


def warm(rng, arm, kind):
    taus = [0.0] * arm.n
    for i in axes(arm):
        taus[i] = float(rng.uniform(120, 700))
    return (tuple(taus), arm.first + 1, float(rng.normal() * 0.6)), []


def warm_keys(arm, kind):
    out = []
    for tau in (150.0, 600.0):
        taus = [0.0] * arm.n
        taus[arm.first :] = [tau] * (arm.n - arm.first)
        out += [(tuple(taus), arm.first + 1, bow) for bow in (0.0, 1.0)]
    return out


def hand(rng, arm, kind):
    j, i = [(3, 4), (3, 5), (4, 5)][int(rng.integers(3))]
    return (arm.first + j, arm.first + i), name(arm, arm.first + i)


def hand_keys(arm, kind):
    return [(arm.first + j, arm.first + i) for j, i in ((3, 4), (3, 5), (4, 5))] if arm.n - arm.first == 6 else []


def ripple(rng, arm, i):
    return i, int(rng.integers(24, 60)), float(rng.uniform(0, 6))


def poles(rng, arm, i):
    return (
        i,
        float(rng.integers(81, 141) * rng.integers(1, 3) * (0.5 if arm.slides[i] else 1.0)),
        float(rng.uniform(0, 6)),
    )


def drift(rng, arm, kind):
    to, turn = rng.normal(size=3), rng.normal(size=3) * 0.3
    return (float(rng.uniform(60, 300)), tuple(map(float, to)), tuple(map(float, turn))), []


def drift_keys(arm, kind):
    return [(tau, unit(3, k), (0.0,) * 3) for tau in (80.0, 250.0) for k in range(3)] + [
        (150.0, (0.0,) * 3, unit(3, k)) for k in range(3)
    ]


def nothing(rng, arm, kind):
    return (), []
