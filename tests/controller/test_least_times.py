"""No motion takes less than the controller's block time: the ideal controller against times worked out by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from test_simulate import A, V, cell, lin, program, run

from camrob.cli import app as cli
from camrob.controller.replay import replay
from camrob.controller.simulate import blocks_of

HEAD = "\n".join(
    [
        "$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}",
        "$TOOL={X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}",
        f"$VEL.CP={V}",
        f"$ACC.CP={A}",
        "$ADVANCE=5",
        "$APO.CDIS=0.1",
    ]
)
COUNT, STEP = 200, 0.5  # motions, mm
BLOCK = 0.012  # s


def machine(block_ms):
    return replace(cell(), controller_section=replace(cell().controller, block_ms=block_ms))


def lines(count=COUNT):
    return [lin(), *(lin(x=97.0 + STEP * k, after="C_DIS") for k in range(1, count)), lin(x=97.0 + STEP * count)]


def test_short_motions_take_the_block_time_each_and_long_ones_what_they_took(tmp_path):
    free, held = (run(tmp_path, *lines(), head=HEAD, machine=machine(ms)) for ms in (0.0, 12.0))
    way, slow = 1e-3 * STEP * COUNT, 1e-3 * STEP / BLOCK
    # five motions are known ahead: what can be braked for within them is faster than either
    assert slow < V < (2.0 * A * 5e-3 * STEP) ** 0.5 * 1.5
    assert held.duration == pytest.approx(way / slow + slow / A, rel=2e-3)
    assert free.duration < 0.6 * held.duration
    lost = held.feed_lost.by_cause["block time"]
    assert lost == pytest.approx(way / slow - way / V, rel=0.02)
    assert "block time" not in free.feed_lost.by_cause
    assert free.blocks is None
    assert (held.blocks.count, held.blocks.short) == (COUNT, COUNT)
    assert held.blocks.shortest == pytest.approx(1e-3 * STEP / V)
    long = lin(), lin(x=197.0), lin(x=297.0)
    one, other = (run(tmp_path, *long, head=HEAD, machine=machine(ms)) for ms in (0.0, 12.0))
    assert one.duration == other.duration
    assert other.blocks.short == 0


def test_verify_and_simulate_say_how_many_motions_are_too_short(tmp_path, capsys):
    text = program(tmp_path, *lines(20), head=HEAD)
    found = blocks_of(text, replay(text, machine(12.0)))
    assert (found.count, found.short) == (20, 20)
    assert blocks_of(text, replay(text, machine(0.0))) is None
    kr15 = str(cell().folder)
    out = str(tmp_path / "log.csv")
    assert cli.run(["simulate", str(tmp_path / "p.src"), "--cell", kr15, "--out", out, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["blocks"]
    assert said == {"block_ms": 12.0, "motions": 20, "short": 20, "shortest_ms": 5.0}
    cli.run(["verify", str(tmp_path / "p.src"), "--cell", kr15, "--json", "--no-collisions"])
    assert json.loads(capsys.readouterr().out)["blocks"] == said
    cli.run(["verify", str(tmp_path / "p.src"), "--cell", kr15, "--no-collisions"])
    assert "20 of 20" in capsys.readouterr().out
    cli.run(["simulate", str(tmp_path / "p.src"), "--cell", kr15, "--out", out])
    assert "20 of 20" in capsys.readouterr().out
