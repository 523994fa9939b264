"""What a name takes of what it moves: planted causes and likenesses, as vectors of a made-up instrument."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.verdict import delivers
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.delivers import held_to_delivery, taken

ROWS = 4000


def directions(seed: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A cause (N, 3), a pattern that has nothing of it and is as large, and white noise a third as large."""
    draw = np.random.default_rng(seed)
    cause, other, noise = draw.normal(0.0, 1.0, (3, ROWS, 3))
    other -= cause * np.sum(cause * other) / np.sum(cause**2)
    return cause, other * np.linalg.norm(cause) / np.linalg.norm(other), noise / 3.0


def last(gap: np.ndarray, moved: np.ndarray) -> Shrinkage:
    """A name that moves the tool by `moved`, taken away from a gap last."""
    return Shrinkage(gap, gap - moved, np.arange(ROWS) // 400)


@pytest.mark.parametrize("alike", [1.0, 0.9, 0.75, 0.5, 0.0])
def test_a_likeness_takes_twice_what_it_shows_less_one(alike: float) -> None:
    """Cosine of the angle between what is at work and a name of the same size: 1 for the cause itself."""
    cause, other, noise = directions()
    moved = alike * cause + np.sqrt(1.0 - alike**2) * other
    assert taken(last(cause + noise, moved)) == pytest.approx(2.0 * alike - 1.0, abs=0.02)


@pytest.mark.parametrize(("size", "share"), [(0.5, 3.0), (1.0, 1.0), (2.0, 0.0)])
def test_a_cause_that_is_fitted_too_small_takes_more_than_it_moves_and_one_too_large_less(
    size: float, share: float
) -> None:
    cause, _, noise = directions()
    assert taken(last(cause + noise, size * cause)) == pytest.approx(share, abs=0.04)


class Sized:
    """A model whose names move the tool by so much, in noises."""

    noise = 1.0
    panels = ()


def held(monkeypatch: pytest.MonkeyPatch, near: float, far: float, size: float = 2.0) -> dict[str, float]:
    """What is believed of a name at 0.97 that takes a share on blocks and another on a withheld log."""
    said = {"blocks": {"name": near}, "log": {"name": far}}
    monkeypatch.setattr(delivers, "settled_rms", lambda *_: size)
    monkeypatch.setattr(
        delivers, "delivered", lambda _, trial, names, *__: {n: s for n, s in said[trial].items() if n in names}
    )
    return held_to_delivery(Sized, ("blocks", "log"), {"name": 0.97, "unasked": 0.3})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("near", "far", "most"),
    [
        (1.0, 1.05, BELIEF.surest),  # a cause
        (1.0, 0.3, BELIEF.takes_less),  # carries over to neighbourhoods, and not to the withheld log
        (0.98, 1.4, BELIEF.takes_else),  # as a tripod that sinks does of links that warm up
        (0.7, 1.0, BELIEF.takes_else),
        (-2.0, 1.0, BELIEF.takes_less),
        (1.0, 3.0, BELIEF.takes_more),
    ],
)
def test_a_name_is_believed_as_far_as_it_delivers_on_all_that_was_withheld(
    monkeypatch: pytest.MonkeyPatch, near: float, far: float, most: float
) -> None:
    assert held(monkeypatch, near, far) == pytest.approx({"name": min(0.97, most), "unasked": 0.3})


def test_a_claim_that_moves_the_tool_by_next_to_nothing_is_in_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    assert held(monkeypatch, 1.0, 1.0, size=0.1)["name"] < 0.5
    assert held(monkeypatch, 1.0, 1.0, size=0.4)["name"] == pytest.approx(0.97)


def test_only_a_name_that_delivers_is_nearly_sure() -> None:
    shares = np.linspace(-3.0, 6.0, 400)
    most = np.array([BELIEF.delivers(s) for s in shares])
    assert (most[np.abs(shares - 1.0) > 0.3] <= 0.8).all()
    assert (most[np.abs(shares - 1.0) < 0.1] == BELIEF.surest).all()


class Planted:
    """A model whose best set is two names, one of which the evidence's sets hold beside a shape of the unknown alone."""

    def __init__(self) -> None:
        self.sets = {frozenset({"seen", "unknown"}): 0.9, frozenset({"unknown"}): 0.1}
        self.best = type("Best", (), {"members": frozenset({0, 1})})
        self.evidence = type("Evidence", (), {"effects_of": staticmethod(lambda _: frozenset({"seen", "unknown"}))})


class Withheld:
    """Logs that took no part."""

    named = True


@pytest.mark.parametrize(
    ("share", "ruled_out", "said"),
    [(1.02, (), BELIEF.likely), (0.6, (), 0.0), (1.9, (), 0.0), (1.02, ("seen",), 0.0)],
)
def test_a_name_beside_a_shape_is_likely_again_where_it_takes_what_a_cause_does(
    monkeypatch: pytest.MonkeyPatch, share: float, ruled_out: tuple[str, ...], said: float
) -> None:
    monkeypatch.setattr(delivers, "delivered", lambda *_: {"seen": share})
    told = delivers.restored(Planted(), (Withheld(),), {"seen": 0.0, "absent": 0.0}, ruled_out)  # type: ignore[arg-type]
    assert told["seen"] == pytest.approx(min(said, BELIEF.effect(0.9)))
    assert told["absent"] == 0.0
