"""The seventh author's generator: apart from what it judges, right by a second formula, its labels what its files hold."""

from __future__ import annotations

import csv
import json
import sys
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from imported_names import imported_names
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "seventh_author"

from gap.seventh_author import run as driver  # noqa: E402
from gap.seventh_author.case import COUNT, SEED, label, made, planned, write  # noqa: E402
from gap.seventh_author.figures import figures  # noqa: E402
from gap.seventh_author.foreign import FOREIGN  # noqa: E402
from gap.seventh_author.machines import MACHINES  # noqa: E402
from gap.seventh_author.named import NAMED  # noqa: E402

TRIED = 501  # a family of the same kind that is not sealed


def test_it_imports_nothing_of_what_it_judges_and_of_no_other_author() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in FOLDER.glob("*.py"):
        names = {n for n in imported_names(path) if n.split(".")[0] not in allowed}
        if path.stem == "figures":
            names = {n for n in names if not n.startswith("gap.score")}
        # what is taken relatively is of the folder itself
        own = {"case", "design", "foreign", "machines", "motions", "named", "shift"}
        assert all(n.startswith("gap.seventh_author") or n.split(".")[0] in own for n in names), (path, names)


def _by_turns(text: str):
    """Tip in m and its turn by axis values as printed, of a cell.toml: a turn about z, a step, a turn about x, row by row."""
    cell = tomllib.loads(text)

    def placed(v):
        return Rotation.from_euler("ZYX", v[3:], degrees=True), np.array(v[:3])

    def tip(values):
        turn, at = placed(cell["kinematics"]["base_to_first"])
        for joint, value in zip(cell["joint"], values, strict=True):
            slides, dh, axis = joint["type"] == "prismatic", joint["dh"], joint["axis"]
            q = (value - axis["offset_mm" if slides else "offset_deg"]) / axis["sign"]
            turn = turn * Rotation.from_rotvec([0, 0, np.radians(dh["theta_deg"] + (0 if slides else q))])
            at = at + turn.apply([dh["a_mm"], 0, dh["d_mm"] + (q if slides else 0)])
            turn = turn * Rotation.from_rotvec([np.radians(dh["alpha_deg"]), 0, 0])
        hand, step = placed(cell["tool"]["flange_to_tool"])
        return at + turn.apply(step), turn * hand

    return tip


@pytest.mark.parametrize("make", MACHINES, ids=lambda m: m.__name__)
def test_a_chain_is_that_of_its_file_and_its_load_the_slope_of_its_potential(make) -> None:
    machine = make()
    q = machine.middle + np.random.default_rng(4).uniform(-1, 1, (4, machine.n)) * machine.swing * machine.units
    by_file = _by_turns(machine.cell())
    for tip, values in zip(machine.tip(q), machine.axes(q), strict=True):
        at, turn = by_file(values)
        assert np.abs(1e3 * tip[:3, 3] - at).max() < 1e-9
        assert np.abs(tip[:3, :3] - turn.as_matrix()).max() < 1e-12

    def height(q):
        return sum(9.81 * kg * p[:, 2] for _, kg, p in machine.centres(machine.chain(q)))

    slope = np.stack([(height(q + e) - height(q - e)) / 2e-6 for e in 1e-6 * np.eye(machine.n)], 1)
    assert np.abs(machine.load(q) + slope).max() < 1e-6 * (1 + np.abs(slope).max())


@pytest.mark.parametrize("seed", [SEED, TRIED])
def test_a_family_holds_what_its_page_says(seed) -> None:
    plan = planned(seed)
    assert len(plan) == 30
    assert Counter(kind for kind, *_ in plan) == COUNT
    assert sum(share is not None for *_, share in plan) == 15
    assert all(1 <= share <= 30.001 for *_, share in plan if share is not None)
    assert {n for kind, names, *_ in plan for n in names} == set(NAMED) | set(FOREIGN)
    assert [p[1:3] for p in planned(seed)] == [p[1:3] for p in plan]


def _read(path: Path):
    """Columns, of 90 rows or a few more."""
    with path.open() as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows[:: max(1, len(rows) // 90)], float).T, strict=True))


def _rms(off):
    return float(np.sqrt((off**2).sum(-1).mean()))


@pytest.mark.parametrize("number", [26, 4, 5])
def test_files_hold_what_the_label_says(number, tmp_path) -> None:
    case = made(TRIED, number)
    case.how |= {
        "frame": "world",
        "target": None,
        "lacks": "",
        "gross": 0.0,
    }  # so that differences are seen as they are
    case.runs = case.runs[-1:]
    told = label(case, look=False)
    apart = {"quiet": [], "wrong": None, "left": case.left} | {c.name: [(c, s)] for c, s in case.causes}
    tips = {}
    for name, parts in apart.items():
        write(case, tmp_path / name, parts)
        log = _read(tmp_path / name / "withheld.csv")
        names = case.runs[0].machine.names
        tip = _by_turns((tmp_path / name / "cell" / "cell.toml").read_text())
        nominal, reported = (np.array([tip(v)[0] for v in np.stack([log[p + n] for n in names], 1)]) for p in ("c", ""))
        tips[name] = (np.stack([log[k] for k in "xyz"], 1) if "x" in log else reported) - nominal
    exact = 2e-3 if len(case.runs[-1].pick) < 90 else 0.12  # of some of the rows
    assert _rms(tips["quiet"]) == pytest.approx(told["noise_mm"], rel=0.2)
    assert _rms(tips["wrong"]) == pytest.approx(told["perfect"]["rms_before_mm"], rel=0.1)
    assert _rms(tips["left"] - tips["quiet"]) == pytest.approx(told["left_mm"], rel=exact, abs=1e-4)
    for name, effect in told["effects"].items():
        assert _rms(tips[name] - tips["quiet"]) == pytest.approx(effect["rms_mm"], rel=exact)
        assert effect["rms_mm"] > 0.99 * told["noise_mm"]


def test_labels_that_were_changed_are_not_scored(tmp_path) -> None:
    driver.write_all(tmp_path, TRIED, [3])
    sealed = tmp_path / "sealed" / "labels.jsonl"
    assert not list((tmp_path / "cases").rglob("*label*"))
    driver.score_all(tmp_path)
    sealed.write_text(sealed.read_text().replace('"none"', '"one"'))
    with pytest.raises(SystemExit, match="not those that were sealed"):
        driver.score_all(tmp_path)


def _said(*names, unknown=0.1):
    return {
        "diagnosis": {
            "status": "unexplained" if unknown > 0.5 else "explained",
            "effects": [{"effect": n, "probability": 0.9, "axes": ["A2"], "class": []} for n in names],
            "alternatives": [{"effects": list(names), "probability": 1.0}],
            "unknown": {"probability": unknown, "where": {"rung": "", "axes": ["A3"], "regimes": ["time"]}},
            "together": {"shrink": 0.5, "predicted_shrink": 0.53},
        }
    }


def test_figures_tell_right_from_wrong_answers() -> None:
    def told(kind, name, **more):
        effect = {"size": 4.0, "rms_mm": 0.2, "axes": ["A2"], "stage": "", "follows": "time", "alike": ["lean"]} | more
        return {
            "kind": kind,
            "log": "path",
            "noise_mm": 0.05,
            "left_mm": 0.0,
            "effects": {name: effect},
            "perfect": {"rms_before_mm": 0.2, "rms_after_mm": 0.1},
        }

    labels = {i: told("one", "backlash") for i in range(4)} | {
        4: told("outside", "draught", axes=[]),
        5: told("outside", "draught", axes=[]),
    }
    answers = {
        0: _said("backlash"),
        1: _said("lean"),
        2: _said("friction"),
        3: _said(),
        4: _said(unknown=0.9),
        5: _said("backlash"),
    }
    got = figures(labels, answers)
    assert [r["outcome"] for r in got["outcomes"]] == ["right", "alike", "wrong", "missed"]
    assert got["foreign: said to be unknown"]["hits"] == 1
    assert got["foreign: a name above 0.8 that doesn't look the same"]["hits"] == 1
    assert got["precision by name"]["share"] == pytest.approx(1 / 3)
    assert got["claimed right at twice the floor"]["hits"] == 2
    assert got["claims above 0.8 that are wrong"]["hits"] == 2
    assert got["foreign: the place right in stage, axis and what it follows"]["hits"] == 2
    assert got["predicted within 5 points of reached, where anything is claimed"]["hits"] == 4
    json.dumps(got)
