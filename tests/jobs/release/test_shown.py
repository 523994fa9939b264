"""What a post's page says of a stock that it shows uncut: the one reason that holds."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from camrob.cell.setup import Setup, ToolSetup
from camrob.jobs.release.shown import stock_shown

PLAIN = np.eye(4)


def stock_of_a_pass(z: float = -0.002, count: int = 5, tools: int = 1, open_mesh: bool = False, **shape: float):
    block = trimesh.creation.box((0.1, 0.06, 0.02))
    block.apply_translation((0.0, 0.0, -0.01))
    poses = np.tile(PLAIN, (count, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = np.linspace(-0.06, 0.06, count), z
    path = SimpleNamespace(base_T_tip=poses)
    tool = ToolSetup(1, "mill", PLAIN, **({"diameter": 0.01, "length": 0.05, "corner": 0.0} | shape))
    inputs = SimpleNamespace(
        stock=np.array(block.triangles)[: -1 if open_mesh else None],
        path=type("Path", (), {"__len__": lambda self: count, "base_T_tip": path.base_T_tip})(),
        mounted=[None] * tools,
        tool=tool,
        setup=Setup(None, PLAIN, (tool,)),
    )
    return stock_shown(inputs, np.linspace(0.0, 1.0, count)).data(PLAIN)


def test_a_stock_that_is_cut_has_no_excuse() -> None:
    data = stock_of_a_pass()
    assert data["sides"]
    assert "uncut" not in data


@pytest.mark.parametrize(
    ("case", "why"),
    [
        ({"z": 0.01}, "the program cuts none of it"),
        ({"tools": 2}, "the program changes its tool"),
        ({"corner": None}, "the set-up does not give the cutter's diameter, length and corner"),
        ({"corner": 0.02}, "no cutter has the shape that the set-up gives, a corner above half the diameter"),
        ({"open_mesh": True}, "its mesh is not closed"),
        ({"count": 60_001}, "the path has more than 60,000 points"),
    ],
)
def test_a_stock_that_is_not_cut_says_why(case: dict, why: str) -> None:
    data = stock_of_a_pass(**case)
    assert data["uncut"] == why
    assert "sides" not in data
