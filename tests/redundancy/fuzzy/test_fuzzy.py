"""Fuzzy engines: scikit-fuzzy as the judge of grids and surfaces, and .fis files that must be refused with their line."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import skfuzzy
from follower_twins import CELL, FOLDER, bilinear
from skfuzzy import control

from camrob.cell.read_cell import read_cell
from camrob.cell.redundancy_settings import FuzzyEngine
from camrob.errors import CellError
from camrob.redundancy.fuzzy.fis import Membership, read_fis
from camrob.redundancy.fuzzy.kept import kept
from camrob.redundancy.fuzzy.surfaces import compile_surface, weights_and_slopes, weights_at

ENGINES = [CELL.resolve.joint_engine, CELL.resolve.condition_engine]
FILES = [FOLDER / engine.file for engine in ENGINES]


def points_of(system, count: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform([v.lower for v in system.inputs], [v.upper for v in system.inputs], (count, len(system.inputs)))


# ---- against scikit-fuzzy


def by_control_system(file: Path, points: np.ndarray) -> np.ndarray:
    """The engine built once more with scikit-fuzzy's control API, from the file's text."""
    text = file.read_text()
    sections = dict(re.findall(r"\[(\w+)\]\n(.*?)(?=\n\[|\Z)", text, re.S))
    variables = []
    for name, kind in [(s, control.Antecedent) for s in ("Input1", "Input2")] + [
        (f"Output{k}", control.Consequent) for k in range(1, 5)
    ]:
        body = sections[name]
        label = re.search(r"Name='(\w+)'", body)[1]
        lower, upper = map(float, re.search(r"Range=\[(\S+) (\S+)\]", body).groups())
        variable = kind(np.linspace(lower, upper, 201 if kind is control.Consequent else 2001), label)
        for term, shape, numbers in re.findall(r"MF\d='(\w+)':'(\w+)',\[([^\]]*)\]", body):
            variable[term] = getattr(skfuzzy, shape)(variable.universe, [float(v) for v in numbers.split()])
        variables.append((variable, list(variable.terms)))
    rules = []
    for row in sections["Rules"].strip().splitlines():
        ins, outs = row.split("(")[0].split(",")
        condition = None
        for (variable, terms), n in zip(variables[:2], map(int, ins.split()), strict=True):
            if n:
                part = ~variable[terms[-n - 1]] if n < 0 else variable[terms[n - 1]]
                condition = part if condition is None else condition & part
        for (variable, terms), n in zip(variables[2:], map(int, outs.split()), strict=True):
            if n:
                rules.append(control.Rule(condition, variable[terms[n - 1]]))
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules))
    out = []
    for x in points:
        for (variable, _), value in zip(variables[:2], x, strict=True):
            simulation.input[variable.label] = value
        simulation.compute()
        out.append([simulation.output[variable.label] for variable, _ in variables[2:]])
    return np.array(out)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_the_engine_is_scikit_fuzzys(file: Path) -> None:
    system = read_fis(file)
    points = points_of(system, 25)
    expected = by_control_system(file, points)
    ours = np.array([system.evaluate(x) for x in points])
    np.testing.assert_allclose(ours, expected, atol=3e-4)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_the_grid_is_the_engine(file: Path) -> None:
    system = read_fis(file)
    points = points_of(system, 200)
    np.testing.assert_allclose(system.evaluate_grid(points), [system.evaluate(x) for x in points], atol=1e-12)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("engine", ENGINES, ids=lambda e: Path(e.file).stem)
def test_the_surface_is_the_engine(engine: FuzzyEngine) -> None:
    """At its nodes exactly, between them to a few thousandths on the mean; joints not named keep the default."""
    system, surface = read_fis(FOLDER / engine.file), compile_surface(CELL, engine)
    places = [CELL.axis_names.index(v.name) for v in system.inputs]
    names = [o.name for o in system.outputs]
    rng = np.random.default_rng(2)
    off = []
    for x in points_of(system, 120):
        for on_node in (True, False):
            axes = rng.uniform(-50, 50, 8)
            for k, variable in enumerate(system.inputs):
                node = np.linspace(variable.lower, variable.upper, surface.table.shape[k])
                axes[places[k]] = node[np.argmin(np.abs(node - x[k]))] if on_node else x[k]
            q = CELL.to_q(axes)
            out = np.empty(len(CELL))
            weights_at(surface, q, out)
            np.testing.assert_allclose(out, bilinear(surface, q), atol=1e-14)
            expected = np.full(len(CELL), engine.default_weight)
            for joint, output in engine.weights.items():
                expected[CELL.index(joint)] = system.evaluate(axes[places])[names.index(output)]
            if on_node:
                np.testing.assert_allclose(out, expected, atol=1e-9)
            else:
                off.append(np.abs(out - expected).max())
    assert max(off) < 0.03 and np.mean(off) < 0.003  # of weights up to 0.5
    assert np.all(surface.table[..., CELL.index("roll")] == 0.01)  # Table 2


@pytest.mark.parametrize("engine", ENGINES, ids=lambda e: Path(e.file).stem)
def test_slopes_by_differences(engine: FuzzyEngine) -> None:
    surface = compile_surface(CELL, engine)
    rng = np.random.default_rng(3)
    n, step = len(CELL), 1e-7
    (out, low, high), slopes = (np.empty(n) for _ in range(3)), np.empty((3, n))
    for _ in range(50):
        q = CELL.to_q(np.append(rng.uniform([-10, -90, -115, -50, -130, -90], [10, 0, 155, 50, 130, 90]), [0.0, 0.0]))
        weights_and_slopes(surface, q, out, slopes)
        for axis, slope in zip(surface.axis[:2], slopes[:2], strict=True):
            dq = np.zeros(n)
            dq[axis] = step
            weights_at(surface, q - dq, low)
            weights_at(surface, q + dq, high)
            np.testing.assert_allclose(slope, (high - low) / (2 * step), atol=1e-6)


def test_beyond_the_grid_the_border_holds() -> None:
    surface = compile_surface(CELL, ENGINES[0])
    n = len(CELL)
    inside, beyond, slopes = np.empty(n), np.empty(n), np.empty((3, n))
    weights_at(surface, CELL.to_q(np.array([0, -90, 160.0, 0, 135.0, 0, 0, 0])), inside)
    weights_and_slopes(surface, CELL.to_q(np.array([0, -90, 200.0, 0, 170.0, 0, 0, 0])), beyond, slopes)
    np.testing.assert_allclose(beyond, inside, atol=1e-12)
    assert not slopes.any()


def test_what_the_technician_meant() -> None:
    """The rules' sense, at postures where it is plain."""
    joint, condition = (compile_surface(CELL, e) for e in ENGINES)

    def at(surface, a3: float, a5: float) -> dict[str, float]:
        out = np.empty(len(CELL))
        weights_at(surface, CELL.to_q(np.array([0, -90, a3, 0, a5, 0, 0, 0])), out)
        return dict(zip(CELL.names, out, strict=True))

    good, stretched, singular = at(joint, 90, 80), at(joint, 14.48, 80), at(joint, 90, 0)
    assert stretched["A3"] > 2 * good["A3"] and singular["A5"] > 1.5 * good["A5"]
    assert stretched["E2"] < good["E2"] and stretched["E1"] < good["E1"]  # the table and the track are let go
    gross, fine = at(condition, 14.48, 80), at(condition, 90, 0)
    assert gross["A1"] == gross["A2"] == gross["A3"] > 0.2 and gross["A4"] < 0.1
    assert fine["A4"] == fine["A5"] == fine["A6"] > 0.2


@pytest.mark.parametrize(
    ("kind", "parameters", "x", "expected"),
    [
        ("trimf", (0, 1, 3), [0, 0.5, 1, 2, 3], [0, 0.5, 1, 0.5, 0]),
        ("trapmf", (0, 1, 2, 4), [0, 0.5, 1.5, 3], [0, 0.5, 1, 0.5]),
        ("gaussmf", (2, 5), [5, 7], [1, np.exp(-0.5)]),
        ("gauss2mf", (1, 2, 3, 6), [1, 4, 9], [np.exp(-0.5), 1, np.exp(-0.5)]),
        ("gbellmf", (2, 4, 6), [6, 8, 4], [1, 0.5, 0.5]),
        ("sigmf", (2, 4), [4, 5], [0.5, 1 / (1 + np.exp(-2))]),
        ("zmf", (3, 7), [3, 5, 7], [1, 0.5, 0]),
        ("smf", (1, 8), [1, 4.5, 8], [0, 0.5, 1]),
    ],
)
def test_membership_functions_are_the_toolboxs(kind, parameters, x, expected) -> None:
    np.testing.assert_allclose(Membership("m", kind, parameters)(np.array(x, float)), expected, atol=1e-12)


# ---- files that are wrong

GOOD = (FOLDER / "weights_jnt.fis").read_text()


def refused(tmp_path: Path, text: str | bytes) -> CellError:
    file = tmp_path / "engine.fis"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CellError) as error:
        read_fis(file)
    assert str(error.value).isprintable() and "engine.fis" in str(error.value) and error.value.hint
    return error.value


def line_of(text: str, begin: str) -> int:
    return next(k for k, line in enumerate(text.splitlines(), start=1) if line.startswith(begin))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Type='mamdani'", "Type='tsukamoto'", "mamdani or sugeno"),
        ("Type='mamdani'", "Type='sugeno'", "wtaver"),
        ("AndMethod='min'", "AndMethod='exec'", "exec"),
        ("DefuzzMethod='centroid'", "DefuzzMethod='mom'", "centroid"),
        ("NumRules=9", "NumRules=8", "there are 9"),
        ("NumInputs=2", "NumInputs=two", "two"),
        ("NumInputs=2", "NumInputs=²", "whole number"),
        ("NumInputs=2", "NumInputs=0", "NumInputs"),
        ("NumInputs=2", "NumInputs=99999999999", "whole number"),
        ("Range=[-120 160]", "Range=[160 -120]", "rising"),
        ("Range=[-120 160]", "Range=[-120 NaN]", "finite"),
        ("Range=[-120 160]", "Range=[-120 1e999]", "finite"),
        ("Range=[-120 160]", "Range=[-120]", "lower upper"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'trapmf',[-120 -120 -70]", "takes 4"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'__import__',[0 0 0 0]", "not a term"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'trapmf',[-20 -70 -120 -120]", "falling"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'gaussmf',[0 5]", "MF1"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'gbellmf',[0 2 5]", "MF1"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'zmf',[7 3]", "MF1"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1='back':'gauss2mf',[1 6 1 2]", "MF1"),
        ("MF1='back':'trapmf',[-120 -120 -70 -20]", "MF1 is back", "key=value"),
        ("2 0, 1 2 2 0 (1) : 1", "2 0, 1 2 2 0 (1) : 3", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "9 0, 1 2 2 0 (1) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "2 0, 1 2 7 0 (1) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "0 0, 1 2 2 0 (1) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "2 - 0, 1 2 2 0 (1) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "2 0, 1 2 2 0 (1.1.1) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "2 0, 1 2 2 0 (5) : 1", "not a rule"),
        ("2 0, 1 2 2 0 (1) : 1", "2 0, 1 2 2 (1) : 1", "not a rule"),
    ],
)
def test_a_wrong_line_is_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in GOOD
    error = refused(tmp_path, GOOD.replace(old, new, 1))
    assert said in str(error)
    named = old if said != "wtaver" else "DefuzzMethod="
    assert error.line == line_of(GOOD, named.split("=")[0] + "=" if "=" in named and "MF" not in named else named)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "[System]"),
        ("Name='x'\n", "first section"),
        (b"\xff\xfe\x00\x01" * 100, "read"),
        (b"\x00" * 1000, "first section"),
        (GOOD[: len(GOOD) // 2], "Input1"),
        (GOOD.replace("3 0, 0 0 1 0 (1) : 1\n", "").replace("NumRules=9", "NumRules=8"), "no rule gives w_3"),
        (GOOD.replace("MF1='low':'trimf',[0 0.01 0.04]", "MF1='low':'trimf',[7 8 9]"), "low"),
        (re.sub(r"NumMFs=4\n(MF.*\n)+", "NumMFs=0\n", GOOD), "NumMFs is '0'"),
    ],
    ids=["empty", "headless", "not text", "zeros", "half", "a gap in the rules", "a term out of range", "no terms"],
)
def test_a_wrong_file_is_refused(tmp_path: Path, text: str | bytes, said: str) -> None:
    assert said in str(refused(tmp_path, text))


def test_hostile_names_stay_one_line(tmp_path: Path) -> None:
    refused(tmp_path, GOOD.replace("Range=[-120 160]", "Range=[\x1b[2J\x07 160]", 1))


def test_an_engine_that_does_not_fit_its_cell(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(FOLDER, folder)
    engine = CELL.resolve.joint_engine
    for old, new, said in (
        ("Name='A3'", "Name='A9'", "'A9' is not an axis"),
        ("Name='w_3'", "Name='w_4'", "no output 'w_3' for A3"),
    ):
        (folder / engine.file).write_text(GOOD.replace(old, new))
        with pytest.raises(CellError, match=said):
            compile_surface(read_cell(folder), engine)
    (folder / engine.file).unlink()
    with pytest.raises(CellError, match="can't be read"):
        compile_surface(CELL.__class__(**{**{f: getattr(CELL, f) for f in CELL.__slots__}, "folder": folder}), engine)


def test_one_input_is_enough(tmp_path: Path) -> None:
    """An engine over the track alone: mm at the file, metres inside."""
    text = """[System]
Name='one'
Type='mamdani'
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='E1'
Range=[-1000 1000]
NumMFs=2
MF1='left':'trapmf',[-1000 -1000 -500 500]
MF2='right':'trapmf',[-500 500 1000 1000]

[Output1]
Name='w'
Range=[0 1]
NumMFs=2
MF1='low':'trimf',[0 0.2 0.4]
MF2='high':'trimf',[0.6 0.8 1]

[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
"""
    (tmp_path / "one.fis").write_text(text)
    from dataclasses import replace

    cell = replace(CELL, folder=tmp_path)
    surface = compile_surface(cell, FuzzyEngine("one.fis", {"A5": "w"}))
    for mm, expected in ((-900.0, 0.2), (0.0, 0.5), (900.0, 0.8), (5000.0, 0.8)):
        out = np.empty(len(CELL))
        weights_at(surface, CELL.to_q(np.array([0, -90, 90, 0, 90, 0, mm, 0.0])), out)
        assert out[CELL.index("A5")] == pytest.approx(expected, abs=1e-6)


def test_what_the_engines_judge_said_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For the same system and question, until the file is damaged; where nothing can be written it is asked each time."""
    monkeypatch.setattr("camrob.redundancy.fuzzy.kept.cache_folder", lambda: tmp_path)
    asked = []

    def make() -> tuple[np.ndarray, ...]:
        asked.append(1)
        return np.arange(3.0), np.full((2, 2), float(len(asked)))

    def ask(what: str = "table", system: object = "engine") -> float:
        first, second = kept(what, system, make)
        assert first.tolist() == [0.0, 1.0, 2.0] and second.shape == (2, 2)
        return float(second[0, 0])

    assert [ask(), ask(), ask("other"), ask(system="second"), ask()] == [1.0, 1.0, 2.0, 3.0, 1.0]
    for file in (tmp_path / "fuzzy").glob("*.npz"):
        file.write_bytes(file.read_bytes()[:40])
    assert [ask(), ask()] == [4.0, 4.0] and not list(tmp_path.rglob("*.part"))
    monkeypatch.setattr("camrob.redundancy.fuzzy.kept.cache_folder", lambda: Path(os.devnull))
    assert [ask(), ask()] == [5.0, 6.0]


def test_an_engine_with_a_gap_is_refused_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camrob.redundancy.fuzzy.kept.cache_folder", lambda: tmp_path)
    text = FILES[0].read_text(encoding="utf-8")
    count = int(re.search(r"NumRules=(\d+)", text)[1])
    gap = text.replace(f"NumRules={count}", "NumRules=1")
    head, rules = gap.split("[Rules]")
    file = tmp_path / "gap.fis"
    file.write_text(
        head + "[Rules]\n" + next(line for line in rules.splitlines() if ":" in line) + "\n", encoding="utf-8"
    )
    for _ in range(2):
        with pytest.raises(CellError, match="no rule gives"):
            read_fis(file)


def test_a_kept_table_is_the_one_that_was_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camrob.redundancy.fuzzy.kept.cache_folder", lambda: tmp_path)
    made, read = (compile_surface(CELL, ENGINES[0]) for _ in range(2))
    assert len(list((tmp_path / "fuzzy").iterdir())) == 2  # that it is covered, and its table
    for a, b in zip(made, read, strict=True):
        np.testing.assert_array_equal(a, b)
