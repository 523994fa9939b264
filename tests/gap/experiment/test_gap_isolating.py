"""What to do about something unknown: what takes minutes and opens nothing comes before axes are run for a day."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest
from gap_cases import kr15, simulated

from camrob.gap.experiment.isolating import run_for_unknown
from camrob.gap.observation.scene import make_scene

SCENES = {poses: make_scene(simulated(poses=poses), kr15()) for poses in (True, False)}


def asked(regimes: tuple[str, ...], axes: tuple[str, ...], *, poses: bool) -> str:
    stays: Any = SimpleNamespace(where=SimpleNamespace(regimes=regimes, comes_back=""), rms_mm=0.035, shapes=())
    return run_for_unknown(stays, axes, ("A2", "A3"), SCENES[poses])


@pytest.mark.parametrize(
    ("regimes", "axes", "poses", "begins"),
    [
        (("load",), ("A5", "A4"), True, "pull at the tool by hand, a dial gauge between it and the plate"),
        (("load",), (), False, "pull at the tool by hand"),
        (
            ("direction",),
            ("A1",),
            True,
            "measure five of the poses again from both sides, at once and after five seconds",
        ),
        ((), (), True, "drive to one pose ten times and measure it each time: if that scatters by 0.035 mm too"),
        ((), (), False, "hold the arm at rest in one posture for a minute and log it"),
        (("time",), ("A1",), False, "drive A1 to one and the same pose before, half-way through and after the run"),
        (("time",), (), False, "ask what went on around the cell meanwhile"),
        (("position",), ("A2",), True, "measure ten of the poses twice"),
        (("position",), ("A2",), False, "run A2 alone through its range"),
    ],
)
def test_the_look_of_minutes_comes_first(
    regimes: tuple[str, ...], axes: tuple[str, ...], poses: bool, begins: str
) -> None:
    said = asked(regimes, axes, poses=poses)
    assert said.startswith(begins)
    quick = said.partition(". Then ")[0]
    assert said == quick or said.partition(". Then ")[2].startswith(("run ", "hold "))


def test_where_an_axis_was_off_from_a_moment_on_its_marks_come_first() -> None:
    where = SimpleNamespace(regimes=("time",), comes_back="")
    shapes = (SimpleNamespace(follows="from 75.42 s of run_1.csv on", moves="A5"),)
    said = run_for_unknown(
        cast(Any, SimpleNamespace(where=where, rms_mm=0.4, shapes=shapes)), ("A5",), ("A5",), SCENES[False]
    )
    assert said.startswith("drive A5 to its marks and look whether they still meet")
    assert "from 75.42 s of run_1.csv on" in said.partition(". Then ")[0]
