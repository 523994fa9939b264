"""Sugeno engines, engines over three axes, engines written out, and how far off a compiled table is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from follower_twins import CELL, FOLDER, bilinear

from camrob.cell.redundancy_settings import EVEN, FuzzyEngine
from camrob.errors import CellError
from camrob.redundancy.fuzzy.fis import read_fis
from camrob.redundancy.fuzzy.surfaces import compile_surface, table_error, weights_and_slopes, weights_at
from camrob.redundancy.fuzzy.write_fis import fis_text

FILES = [FOLDER / engine.file for engine in (CELL.resolve.joint_engine, CELL.resolve.condition_engine)]

SUGENO = """[System]
Name='s'
Type='sugeno'
Version=2.0
NumInputs=2
NumOutputs=1
NumRules=3
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'

[Input1]
Name='A3'
Range=[0 100]
NumMFs=2
MF1='bent':'trapmf',[0 0 20 60]
MF2='folded':'trapmf',[20 60 100 100]

[Input2]
Name='A5'
Range=[-100 100]
NumMFs=2
MF1='down':'trapmf',[-100 -100 -50 50]
MF2='up':'trapmf',[-50 50 100 100]

[Output1]
Name='w'
Range=[0 1]
NumMFs=3
MF1='low':'constant',[0.1]
MF2='high':'constant',0.7
MF3='slope':'linear',[0.002 0.001 0.3]

[Rules]
1 1, 1 (1) : 1
2 1, 2 (0.5) : 1
1 2, 3 (1) : 2
"""

CUBE = """[System]
Name='cube'
Type='sugeno'
NumInputs=3
NumOutputs=1
NumRules=8
AndMethod='prod'
OrMethod='max'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'

[Input1]
Name='A3'
Range=[-120 160]
NumMFs=2
MF1='a':'trapmf',[-120 -120 -20 60]
MF2='b':'trapmf',[-20 60 160 160]

[Input2]
Name='A5'
Range=[-135 135]
NumMFs=2
MF1='a':'trapmf',[-135 -135 -40 50]
MF2='b':'trapmf',[-40 50 135 135]

[Input3]
Name='E1'
Range=[-1000 1000]
NumMFs=2
MF1='a':'trapmf',[-1000 -1000 -500 300]
MF2='b':'trapmf',[-500 300 1000 1000]

[Output1]
Name='w'
Range=[0 1]
NumMFs=8
{terms}

[Rules]
{rules}
"""


def cube(tmp_path: Path) -> Path:
    """An engine over three axes, every corner with a weight of its own."""
    corners = [(a, b, c) for a in (1, 2) for b in (1, 2) for c in (1, 2)]
    terms = "\n".join(f"MF{k}='t{k}':'constant',[{0.05 + 0.1 * k:g}]" for k in range(1, 9))
    rules = "\n".join(f"{a} {b} {c}, {k} (1) : 1" for k, (a, b, c) in enumerate(corners, start=1))
    file = tmp_path / "cube.fis"
    file.write_text(CUBE.format(terms=terms, rules=rules))
    return file


def ramp(x: float, low: float, high: float) -> float:
    return float(np.clip((x - low) / (high - low), 0.0, 1.0))


def test_a_sugeno_engine_by_hand(tmp_path: Path) -> None:
    """Weighted average of constants and of a line, product for and, probabilistic or, a rule at half its weight."""
    file = tmp_path / "s.fis"
    file.write_text(SUGENO)
    system = read_fis(file)
    for a3, a5 in ((10.0, -80.0), (30.0, -20.0), (45.0, 10.0), (90.0, 70.0)):
        folded, up = ramp(a3, 20, 60), ramp(a5, -50, 50)
        bent, down = 1.0 - folded, 1.0 - up
        strength = np.array([bent * down, 0.5 * folded * down, bent + up - bent * up])
        expected = strength @ [0.1, 0.7, 0.002 * a3 + 0.001 * a5 + 0.3] / strength.sum()
        np.testing.assert_allclose(system.evaluate(np.array([a3, a5])), [expected], rtol=1e-12)
        np.testing.assert_allclose(system.evaluate_grid(np.array([[a3, a5]])), [[expected]], rtol=1e-12)
    summed = replace(system, defuzzification="wtsum")
    assert summed.evaluate(np.array([10.0, -80.0]))[0] == pytest.approx(0.1 + 0.002 * 10.0 + 0.001 * -80.0 + 0.3)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("DefuzzMethod='wtaver'", "DefuzzMethod='centroid'", "wtaver or wtsum"),
        ("'linear',[0.002 0.001 0.3]", "'linear',[0.002 0.3]", "takes 3"),
        ("'constant',[0.1]", "'trimf',[0 1 2]", "constant, linear"),
        ("'constant',[0.1]", "'constant',[-0.9]", "a weight is above 0"),
        ("'linear',[0.002 0.001 0.3]", "'linear',[0.002 0.01 0.3]", "a weight is above 0"),
    ],
)
def test_a_wrong_sugeno_engine_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in SUGENO
    file = tmp_path / "s.fis"
    file.write_text(SUGENO.replace(old, new, 1))
    with pytest.raises(CellError) as error:
        read_fis(file)
    assert said in str(error.value)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_what_is_written_is_what_was_read(file: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.fis"
    system = read_fis(file)
    again.write_text(fis_text(system, ["a remark", "% and another"]))
    assert read_fis(again) == system
    sugeno = tmp_path / "s.fis"
    sugeno.write_text(SUGENO)
    again.write_text(fis_text(read_fis(sugeno)))
    assert read_fis(again) == read_fis(sugeno)


def test_three_axes_are_met_exactly(tmp_path: Path) -> None:
    """Products of terms that add up to one are trilinear between the corners: the table is the engine, slopes too."""
    cube(tmp_path)
    cell = replace(CELL, folder=tmp_path)
    surface = compile_surface(cell, FuzzyEngine("cube.fis", {"A5": "w"}))
    system, n, at = read_fis(tmp_path / "cube.fis"), len(CELL), CELL.index("A5")
    rng = np.random.default_rng(1)
    out, low, high, slopes = np.empty(n), np.empty(n), np.empty(n), np.empty((3, n))
    for a3, a5, e1 in rng.uniform([-130, -140, -1100], [170, 140, 1100], (60, 3)):
        q = CELL.to_q(np.array([0, -90, a3, 0, a5, 0, e1, 0.0]))
        weights_and_slopes(surface, q, out, slopes)
        inside = np.clip([a3, a5, e1], [-120, -135, -1000], [160, 135, 1000])
        assert out[at] == pytest.approx(float(system.evaluate(inside)[0]), abs=1e-12)
        np.testing.assert_allclose(out, bilinear(surface, q), atol=1e-12)
        for k, axis in enumerate(surface.axis):
            dq = np.zeros(n)
            dq[axis] = 1e-7
            weights_at(surface, q - dq, low)
            weights_at(surface, q + dq, high)
            assert slopes[k, at] == pytest.approx((high[at] - low[at]) / 2e-7, abs=1e-6)
    assert table_error(system)[0] < 1e-12


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_where_the_table_is_coarse(file: Path) -> None:
    """Evenly spread nodes miss weights by half and more at the engine's bends; nodes at its corners by less than a tenth."""
    system = read_fis(file)
    even, where = table_error(system, even=True)
    assert even > 0.5
    near = [min(abs(x - c) for t in v.terms for c in t.parameters) for x, v in zip(where, system.inputs, strict=True)]
    assert min(near) < 3.5  # degrees: a step of the even grid
    assert table_error(system)[0] < 0.1


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_the_compiled_table_is_scikit_fuzzys_engine(file: Path) -> None:
    """What the follower reads, beside `FuzzySystem.evaluate`, at drawn postures."""
    own = CELL.resolve.joint_engine if "jnt" in file.stem else CELL.resolve.condition_engine
    system, surface = read_fis(file), compile_surface(CELL, replace(own, table="corners"))
    coarse = compile_surface(CELL, replace(own, table=EVEN))
    rng, out, off, off_even = np.random.default_rng(5), np.empty(len(CELL)), [], []
    joint, output = list(own.weights.items())[-1]
    k = [o.name for o in system.outputs].index(output)
    for a3, a5 in rng.uniform([-120, -135], [160, 135], (150, 2)):
        q = CELL.to_q(np.array([0, -90, a3, 0, a5, 0, 0, 0.0]))
        expected = system.evaluate(np.array([a3, a5]))[k]
        for s, into in ((surface, off), (coarse, off_even)):
            weights_at(s, q, out)
            into.append(abs(out[CELL.index(joint)] / expected - 1.0))
    assert max(off) < 0.1 and np.mean(off) < 0.002
    assert np.mean(off) < 0.5 * np.mean(off_even)
