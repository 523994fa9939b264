"""The eighth author's generator: apart from what it judges, right by a second formula, its labels what its files hold."""

from __future__ import annotations

import csv
import json
import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from imported_names import imported_names
from scipy.linalg import expm

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "eighth_author"

from gap.eighth_author import run as driver  # noqa: E402
from gap.eighth_author.asked import DEEDS, SHARES, chosen, hand_out, scoring  # noqa: E402
from gap.eighth_author.bodies import MACHINES  # noqa: E402
from gap.eighth_author.case import ALL, CORRELATED, COUNT, LEFT, SEED, label, made, planned, write  # noqa: E402
from gap.eighth_author.figures import figures  # noqa: E402
from gap.eighth_author.strange import FOREIGN  # noqa: E402

TRIED = 903  # a family of the same kind that is not sealed


def test_it_imports_nothing_of_what_it_judges_and_of_no_other_author() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in FOLDER.glob("*.py"):
        names = {n for n in imported_names(path) if n.split(".")[0] not in allowed}
        if path.stem == "figures":
            names = {n for n in names if not n.startswith("gap.score")}
        assert all(n.startswith("gap.eighth_author") for n in names), (path, names)


def _spun(axis, place, slides):
    """4x4 generator of a screw: a turn about an axis through a place, or a slide along it."""
    out = np.zeros((4, 4))
    if slides:
        out[:3, 3] = axis
    else:
        out[:3, :3] = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        out[:3, 3] = np.cross(place, axis)
    return out


def _frame(v):
    a, b, c = np.radians(v[3:])
    z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    x = np.array([[1, 0, 0], [0, np.cos(c), -np.sin(c)], [0, np.sin(c), np.cos(c)]])
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = z @ y @ x, v[:3]
    return out


def _by_screws(text: str):
    """Tip in mm (4x4) on the base by axis values as printed, of a cell.toml: a product of exponentials about where its
    axes lie at q = 0."""
    cell = tomllib.loads(text)
    arm = cell["arm"]
    rows = [
        (
            *(j["dh"][k] for k in ("alpha_deg", "a_mm", "theta_deg", "d_mm")),
            j["type"] == "prismatic",
            *j["axis"].values(),
        )
        for j in cell.get("joint", [])
    ]
    rows += [
        (*d, k == "P", s, o)
        for d, k, s, o in zip(arm["dh"], arm["kinds"], arm["signs"], arm["offsets_deg"], strict=True)
    ]
    home, screws = _frame(cell["kinematics"]["base_to_first"]), []
    for alpha, a, theta, d, slides, sign, offset in rows:
        screws.append((_spun(home[:3, 2], home[:3, 3], slides), slides, sign, offset))
        home = home @ _frame([0, 0, d, theta, 0, 0]) @ _frame([a, 0, 0, 0, 0, alpha])
    home = home @ _frame(cell["tool"]["flange_to_tool"])

    def tip(values):
        out = np.eye(4)
        for (screw, slides, sign, offset), value in zip(screws, values, strict=True):
            q = (value - offset) / sign
            out = out @ expm(screw * (q if slides else np.radians(q)))
        return out @ home

    return tip


@pytest.mark.parametrize("make", MACHINES, ids=lambda m: m.__name__)
def test_a_chain_is_that_of_its_file_and_its_load_the_slope_of_its_potential(make) -> None:
    machine = make()
    q = machine.middle + np.random.default_rng(4).uniform(-1, 1, (3, machine.n)) * machine.spread
    by_screws = _by_screws(machine.cell())
    base, values = machine.base(q), machine.values(q)
    for k, tip in enumerate(machine.tip(q)):
        told = by_screws(values[k])  # on the base; at a table's 0 it is in world
        if machine.table:
            zero = values[k].copy()
            zero[0] = 0
            assert np.abs(1e3 * tip[:3, 3] - by_screws(zero)[:3, 3]).max() < 1e-9
        mine = np.linalg.inv(base[k]) @ tip
        assert np.abs(1e3 * mine[:3, 3] - told[:3, 3]).max() < 1e-9
        assert np.abs(mine[:3, :3] - told[:3, :3]).max() < 1e-12

    def height(q):
        chain = machine.frames(q)
        ends = {n: chain[machine.names.index(n) + 1] for n, *_ in machine.masses}
        return sum(9.81 * kg * (ends[n] @ [*(np.array(c) / 1e3), 1.0])[:, 2] for n, kg, c in machine.masses)

    slope = np.stack([(height(q + e) - height(q - e)) / 2e-6 for e in 1e-6 * np.eye(machine.n)], 1)
    slope[:, : machine.first] = 0  # a table carries none of it
    assert np.abs(machine.loads(q) + slope).max() < 1e-6 * (1 + np.abs(slope).max())


@pytest.mark.parametrize("seed", [SEED, TRIED])
def test_a_family_holds_what_its_page_says(seed) -> None:
    plan = planned(seed)
    assert len(plan) == 36
    assert Counter(p["kind"] for p in plan) == COUNT
    assert set(Counter(p["machine"] for p in plan)) == {m.__name__ for m in MACHINES}
    shares = sorted(p["left"] for p in plan if p["left"])
    assert len(shares) == LEFT
    assert 1 <= shares[0] < 1.3
    assert 25 < shares[-1] <= 30
    assert sum(p["correlated"] for p in plan) == CORRELATED == len(plan) / 4
    assert all(p["log"] == "path" for p in plan if p["correlated"])
    assert {n for p in plan for n in p["names"]} == set(ALL) | {f.__name__ for f in FOREIGN}
    assert planned(seed) == plan


def _read(path: Path):
    """Columns, of 60 rows or a few more."""
    with path.open() as file:
        head, *rows = csv.reader(file)
    rows = rows[:: max(1, len(rows) // 60)]
    return {n: np.array([float(r[i]) for r in rows]) for i, n in enumerate(head)}


def _rms(off):
    return float(np.sqrt((off**2).sum(-1).mean()))


@pytest.mark.parametrize("number", [3, 10, 11, 18])
def test_files_hold_what_the_label_says(number, tmp_path) -> None:
    case = made(TRIED, number)
    case.how |= {
        "frame": case.how["frame"].replace("unknown", "world"),
        "target": "tool",
        "reflector": np.zeros(3),
        "lacks": "",
        "gross": 0.0,
        "broken": False,
    }
    case.runs = case.runs[-1:]
    told = label(case, look=False)
    apart = {"quiet": [], "wrong": None, "left": case.left} | {c.name: [(c, s)] for c, s in case.causes}
    tips = {}
    for name, parts in apart.items():
        write(case, tmp_path / name, parts)
        log = _read(tmp_path / name / "withheld.csv")
        names = case.runs[0].machine.names
        tip = _by_screws((tmp_path / name / "cell" / "cell.toml").read_text())

        def seen(prefix, log=log, names=names, tip=tip):
            values = np.stack([log[prefix + n] for n in names], 1)
            if names[0] == "E2" and case.how["frame"] != "base":
                values[:, 0] = 0
            return np.array([tip(v)[:3, 3] for v in values])

        tips[name] = (np.stack([log[k] for k in "xyz"], 1) if "x" in log else seen("")) - seen("c")
    exact = 2e-3 if len(case.runs[-1].pick) < 60 else 0.15  # of some of the rows
    assert _rms(tips["quiet"]) == pytest.approx(told["noise_mm"], rel=0.25)
    assert _rms(tips["left"] - tips["quiet"]) == pytest.approx(told["left_mm"], rel=exact, abs=1e-4)
    whole = _rms(tips["wrong"])
    assert whole == pytest.approx(told["perfect"]["rms_before_mm"], rel=0.15)
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


def test_what_was_sealed_comes_out_again_and_stands_on_the_page() -> None:
    told = dict(line.split() for line in driver.SEALED.read_text().splitlines())
    assert [*told] == ["all", *map(str, range(36))]
    assert told["all"] in (FOLDER / "README.md").read_text()
    asked = sorted(chosen(planned(SEED), SEED).values())
    assert ", ".join(map(str, asked)) in (FOLDER / "README.md").read_text()
    assert driver.other_than_sealed([driver.labelled(n, made(SEED, n)) for n in asked[:2]], asked[:2]) == []


def test_what_is_handed_out_says_nothing_of_the_labels(tmp_path) -> None:
    number = next(i for i, p in enumerate(planned(TRIED)) if p["names"] == ["lift_clamp"])
    case = made(TRIED, number)
    write(case, tmp_path / "cases" / f"{number:02d}")
    page = tmp_path / "answers" / f"{number:02d}" / "diagnosis" / "diagnosis.html"
    with pytest.raises(SystemExit, match="no such page"):
        hand_out(tmp_path, {"A": number})
    page.parent.mkdir(parents=True)
    page.write_text("<p>as it was</p>")
    hand_out(tmp_path, {"A": number})
    given = {p.name: p.read_text() for p in (tmp_path / "asked").iterdir()}
    assert sorted(given) == ["A.html", "A.md"]
    assert given["A.html"] == "<p>as it was</p>"
    assert "What would you do at the machine" in given["A.md"]
    assert not {*ALL, *DEEDS, "clamp", f"{number:02d}"} & set(re.findall(r"\w+", given["A.md"]))
    assert not any(f"{e['rms_mm']:.3g}" in given["A.md"] for e in label(case, look=False)["effects"].values())
    sheet = scoring({"A": number}, {number: label(case, look=False)})
    assert "lift_clamp, E1" in sheet
    assert DEEDS["lift_clamp"] in sheet


def test_the_ten_are_spread_over_kinds_and_each_cause_has_its_deed() -> None:
    for seed in (SEED, TRIED):
        plan = planned(seed)
        assert Counter(plan[n]["kind"] for n in chosen(plan, seed).values()) == SHARES
    assert set(DEEDS) == set(ALL) | {f.__name__ for f in FOREIGN}


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
        effect = {
            "size": 4.0,
            "rms_mm": 0.2,
            "axes": ["A2"],
            "stage": "",
            "follows": ["time"],
            "alike": ["lean"],
        } | more
        return {
            "kind": kind,
            "log": "path",
            "noise_mm": 0.05,
            "left_mm": 0.0,
            "correlated_s": 1.0,
            "effects": {name: effect},
            "perfect": {"rms_before_mm": 0.2, "rms_after_mm": 0.1},
        }

    labels = {i: told("one", "backlash") for i in range(4)} | {i: told("outside", "tow", axes=[]) for i in (4, 5)}
    said = [_said("backlash"), _said("lean"), _said("friction"), _said(), _said(unknown=0.9), _said("backlash")]
    got = figures(labels, dict(enumerate(said)))
    assert [r["outcome"] for r in got["outcomes"]] == ["right", "alike", "wrong", "missed"]
    assert got["foreign: said to be unknown"]["hits"] == 1
    assert got["foreign: a name above 0.8 that isn't like it"]["hits"] == 1
    assert got["foreign: place right in all"]["hits"] == 2
    assert got["foreign: axis right"]["count"] == 0
    assert got["named: right up to its like, at twice the floor"]["hits"] == 2
    assert got["claims that are wrong"] == got["claims above 0.8 that are wrong"] | {"count": 4}
    assert got["named: right up to its like, correlated noise, logs with a tracker's path"]["count"] == 4
    json.dumps(got)
