"""What to run next where no motion of an axis can show it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from camrob.gap import next_run as asked
from camrob.summaries.diagnosis_summary import Unknown, UnknownPlace


class Run:
    """A run of a tracker's, of no rows."""

    poses, tracked = False, True

    def __len__(self) -> int:
        return 0


def verdict(regimes: tuple[str, ...]) -> Any:
    """Nothing claimed; something unknown that follows `regimes`."""
    where = UnknownPlace(stage=None, axes=(), regimes=regimes, comes_back="")
    stays = Unknown(probability=0.99, rms_mm=1.0, share=1.0, where=where, text="", shapes=(), implausible={})
    none = SimpleNamespace(effects=(), probability=1.0)
    return SimpleNamespace(
        unknown=stays, claimed=(), effects=(), panels=None, status="unexplained", alternatives=(none,)
    )


@pytest.mark.parametrize(("regimes", "reckoned"), [(("force", "position"), False), (("load", "force"), True)])
def test_what_follows_the_force_is_asked_in_air_and_not_of_an_axis_alone(
    monkeypatch: pytest.MonkeyPatch, regimes: tuple[str, ...], reckoned: bool
) -> None:
    motions: list[object] = []
    monkeypatch.setattr(asked, "suspects", lambda model, stays: ())
    monkeypatch.setattr(asked, "axes_of", lambda panels: {})
    monkeypatch.setattr(asked, "_planned", lambda *given: motions.append(given))
    run = asked.next_run(SimpleNamespace(scenes=[Run()]), verdict(regimes), [])  # type: ignore[arg-type]
    assert bool(motions) == reckoned
    assert ("in air" in run.text and run.about == ("unknown",)) != reckoned


def effect(name: str, follows: str) -> Any:
    return SimpleNamespace(name=name, regimes=(follows, "position"), experiment=f"isolate {name}")


LIBRARY = [effect("payload", "load"), effect("joint_compliance", "load"), effect("geometry", "position")]


@pytest.mark.parametrize(
    ("chances", "nothing", "words"),
    [
        (
            {"payload": 0.4, "joint_compliance": 0.25, "geometry": 0.2},
            0.1,
            "run the same path with and without the load",
        ),
        ({"payload": 0.4, "geometry": 0.25}, 0.1, "To tell payload from geometry: isolate payload."),
        ({"payload": 0.4, "joint_compliance": 0.25}, 0.6, "Isolate what is unexplained"),
        ({"payload": 0.3, "joint_compliance": 0.1}, 0.1, "Isolate what is unexplained"),
    ],
)
def test_two_names_that_may_be_it_are_told_apart_before_the_rest_is_isolated(
    monkeypatch: pytest.MonkeyPatch, chances: dict[str, float], nothing: float, words: str
) -> None:
    """Payload or compliance is asked by the load, though what stays follows the time on these logs."""
    monkeypatch.setattr(asked, "suspects", lambda model, stays: ())
    monkeypatch.setattr(asked, "axes_of", lambda panels: {})
    monkeypatch.setattr(asked, "_planned", lambda *given: None)
    said = verdict(("time", "load"))
    said.effects = tuple(
        SimpleNamespace(effect=n, probability=p, implausible="", claimed=False) for n, p in chances.items()
    )
    for e in said.effects:
        e.like_others = False
    said.alternatives = (SimpleNamespace(effects=(), probability=nothing),)
    run = asked.next_run(SimpleNamespace(scenes=[Run()]), said, LIBRARY)  # type: ignore[arg-type]
    assert words in run.text
    assert run.about == (("unknown",) if words.startswith("Isolate") else tuple(chances)[:2])
