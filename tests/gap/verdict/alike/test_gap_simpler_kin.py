"""Names that a simpler one of their kind nearly shows: a carriage with a play and a spring that slips, moved by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from camrob.gap.verdict.alike.simpler_kin import shown_by_simpler

KINDS = {
    "play": (("direction",), 1),
    "springs": (("direction",), 2),
    "bend": (("position",), 1),
    "links": (("position",), 2),
}
LIBRARY = tuple(
    SimpleNamespace(name=n, regimes=r, stages=("encoder_to_tcp",), parameters=k) for n, (r, k) in KINDS.items()
)


def slipping(position: np.ndarray, width: float) -> np.ndarray:
    """How far a spring is wound that slips from `width` on, in widths (-1 to 1)."""
    out, wound = np.zeros(len(position)), 0.0
    for k in range(1, len(position)):
        wound = float(np.clip(wound + (position[k] - position[k - 1]) / width, -1.0, 1.0))
        out[k] = wound
    return out


def model(narrow: float, wide: float, name: str = "springs", *, poses: bool = False) -> SimpleNamespace:
    """A carriage that goes to and fro by 100 mm, of which one name is fitted with some values; a constant is always fitted."""
    x = 50.0 * np.sin(np.linspace(0.0, 40.0, 4000)) * np.linspace(1.0, 0.6, 4000)
    springs = np.stack([slipping(x, 0.1), slipping(x, 60.0)], axis=1)
    places = np.stack([x / 50.0, (x / 50.0) ** 3], axis=1)
    columns = np.c_[np.ones_like(x), np.sign(np.gradient(x)), springs, places[:, :1], places]
    owner = np.array([0, 1, 2, 2, 3, 4, 4])
    units = [SimpleNamespace(effect=n) for n in ("frame", "play", "springs", "bend", "links")]
    values = np.zeros(7)
    values[owner == [u.effect for u in units].index(name)] = narrow, wide
    return SimpleNamespace(
        scenes=(SimpleNamespace(poses=poses),),
        units=units,
        design=SimpleNamespace(owner=owner, A=(columns.T @ columns)[None]),
        evidence=SimpleNamespace(always=frozenset({0})),
        best=SimpleNamespace(members=frozenset({[u.effect for u in units].index(name)})),
        values=lambda _members, _fitted: values,
    )


@pytest.mark.parametrize(("narrow", "wide", "shown"), [(1.0, 0.1, True), (0.2, 1.0, False)])
def test_springs_that_slip_at_once_are_one_class_with_a_play_and_those_that_wind_far_are_not(
    narrow: float, wide: float, *, shown: bool
) -> None:
    found = shown_by_simpler(model(narrow, wide), LIBRARY, ["springs"])  # type: ignore[arg-type]
    assert found == ({"springs": ["play"]} if shown else {})


def test_what_follows_posture_is_told_apart_by_posture() -> None:
    assert shown_by_simpler(model(1.0, 0.0, "links"), LIBRARY, ["links"]) == {}  # type: ignore[arg-type]


def test_a_simpler_name_is_not_doubted_for_the_wider_one() -> None:
    sure = model(1.0, 0.0)
    sure.best.members = frozenset({1})
    assert shown_by_simpler(sure, LIBRARY, ["play"]) == {}  # type: ignore[arg-type]


@pytest.mark.parametrize("poses", [True, False])
def test_of_single_poses_a_kind_that_cannot_be_described_is_one_class_with_the_one_that_can(*, poses: bool) -> None:
    """A spring that slips has no parameters there, so that a play was never held to it; of a path none is found where none is."""
    log = model(1.0, 0.0, poses=poses)
    log.best.members = frozenset({1})
    log.design.owner = np.where(log.design.owner == 2, 0, log.design.owner)
    found = shown_by_simpler(log, LIBRARY, ["play"])  # type: ignore[arg-type]
    assert found == ({"play": ["springs"]} if poses else {})
    assert shown_by_simpler(log, LIBRARY, ["bend"]) == {}  # type: ignore[arg-type]
