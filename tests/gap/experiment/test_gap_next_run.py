"""What to run next where no motion of an axis can show it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from camrob.gap import next_run as asked


class Run:
    """A run of a tracker's, of no rows."""

    poses, tracked = False, True

    def __len__(self) -> int:
        return 0


def verdict(regimes: tuple[str, ...]) -> Any:
    """Nothing claimed; something unknown that follows `regimes`."""
    where = SimpleNamespace(regimes=regimes, comes_back="")
    stays = SimpleNamespace(probability=0.99, where=where, rms_mm=1.0)
    return SimpleNamespace(unknown=stays, claimed=(), effects=(), panels=None, status="unexplained")


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
