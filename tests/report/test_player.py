"""The player shows the program as it is: the chain as numbers, the run, and the page in a real browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from page_data import array_of, block_of, lines_of

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.kinematics import frames as kinematics
from camrob.redundancy.solution import Revision, Solution
from camrob.report.page.timeline import Run, chain_data, timeline_data
from camrob.report.page.triangles import world_T_frames

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def _four(rows):
    return np.vstack([np.reshape(rows, (3, 4)), [0.0, 0.0, 0.0, 1.0]])


def _walk(chain, q):
    """world_T_frame of every frame, mm, from the page's numbers alone, by the page's rule."""
    T = _four(chain["first"])
    frames = {}
    if chain["arm"][0] == 0:
        frames["root"] = T @ _four(chain["root"])
    for k, joint in enumerate(chain["joints"]):
        move = np.eye(4)
        if joint["prismatic"]:
            move[2, 3] = q[k]
        else:
            c, s = np.cos(q[k]), np.sin(q[k])
            move[:2, :2] = [[c, -s], [s, c]]
        T = T @ _four(joint["before"]) @ move @ _four(joint["after"])
        frames[joint["name"]] = T
        if k == chain["arm"][0] - 1:
            frames["root"] = T @ _four(chain["root"])
        if k == chain["arm"][1]:
            frames["flange"] = T @ _four(chain["flange"])
            hung = frames["flange"] @ _four(chain["tool"])
            if chain["roll"]:
                T = hung
            else:
                frames["tool"] = hung
    if chain["roll"]:
        frames["tool"] = T
    base = np.eye(4)
    if chain["workpiece"] >= 0:
        floor = frames[chain["joints"][chain["workpiece"]]["name"]]
        base = _four(chain["floor"]) @ np.linalg.inv(floor)
    return {"base": base, **{name: base @ T for name, T in frames.items()}}


@pytest.mark.parametrize("name", ["kr15_track_table", "irb6700_table", "ta1400_weld", "rx160_tracker", "kr500_afp"])
def test_the_chain_as_numbers_stands_where_the_cell_stands(name):
    cell = read_cell(ROOT / "cells" / name)
    chain = json.loads(json.dumps(chain_data(cell)))
    rng = np.random.default_rng(3)
    low, high = np.maximum(cell.q_lower, -2.0), np.minimum(cell.q_upper, 2.0)
    for q in rng.uniform(low, high, (20, len(low))):
        scale = np.where([j.prismatic for j in cell.joints], 1000.0, 1.0)
        found, true = _walk(chain, q * scale), world_T_frames(cell, q[None])
        assert set(found) | {"world"} == set(true)
        for frame, T in found.items():
            np.testing.assert_allclose(T[:3, :3], true[frame][0, :3, :3], atol=1e-12)
            np.testing.assert_allclose(T[:3, 3], 1000.0 * true[frame][0, :3, 3], atol=1e-8)


@pytest.fixture(scope="module")
def posted(tmp_path_factory):
    out = tmp_path_factory.mktemp("player")
    sample = ROOT / "toolpaths" / "engraving"
    return post(sample / "engraving.cls", cell=ROOT / "cells" / "kr15_track_table", out=out)


def test_the_run_has_every_point_its_time_its_axes_and_the_programs_own_line(posted):
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    page = (posted.out / "engraving.html").read_text(encoding="utf-8")
    run = block_of(page, "scene")["run"]
    n = len(posted.path)
    assert run["count"] == run["points"] == n and run["off"] == 0.0
    time, q, lines = run["t"], run["q"].reshape(n, -1), lines_of(run["said"])
    assert np.all(np.diff(time) >= 0.0) and time[-1] == pytest.approx(posted.summary.time_s.program, abs=1e-4)
    for k, axis in enumerate(run["axes"]):
        printed = axis["factor"] * q[:, axis["joint"]] + axis["offset"]
        wanted = cell.to_axis_values(np.asarray(posted.solution.q))[:, k]
        np.testing.assert_allclose(printed, wanted, atol=2e-4)
    program = (posted.out / "engraving.src").read_text().splitlines()
    said = [text for text in lines if text]
    assert len(said) == posted.summary.points
    for text in said[::50]:
        line, statement = re.fullmatch(r"engraving\.src (\d+): (.*)", text).groups()
        assert program[int(line) - 1].strip() == statement
    point = next(k for k, text in enumerate(lines) if "LIN" in text)
    x, y, z = map(float, re.search(r"X (\S+?),Y (\S+?),Z (\S+?),", lines[point]).groups())
    base = kinematics.base_T_tool(cell, np.asarray(posted.solution.q)[point])[:3, 3] * 1000.0
    seen = kinematics.world_T_base(cell, np.asarray(posted.solution.q)[point])
    np.testing.assert_allclose([x, y, z], base if cell.base_follows_table else (seen[:3, :3] @ base), atol=1e-3)


def test_a_revision_is_gone_through_with_the_tool_held_and_a_long_run_is_thinned(monkeypatch, posted):
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    path, q = posted.path, np.asarray(posted.solution.q)
    n = len(path)
    at = np.linspace(0.0, 90.0, n)
    through = np.linspace(q[400] - 0.1, q[400], 30)
    revised = Solution(
        "vjm", q, posted.solution.inv_kf, cell.digest, path.digest, (Revision(0, 400, through, True, 0.4, 0.6),)
    )
    run = timeline_data(cell, path, revised, {0: "top"}, Run(at))
    time, sent = array_of(run["t"]), array_of(run["q"]).reshape(run["count"], -1)
    rows = sorted(map(int, run["remarks"]))
    assert run["said"] is None and len(rows) == 12 and set(run["remarks"].values()) == {"posture revision before top"}
    assert at[399] < time[rows[0]] and time[rows[-1]] < at[400] and np.all(np.diff(time) >= 0.0)
    arm = [k for k, j in enumerate(cell.joints) if not j.prismatic]
    np.testing.assert_allclose(sent[rows[0]][arm], through[0][arm], atol=3e-6)
    np.testing.assert_allclose(sent[rows[-1]][arm], through[-1][arm], atol=3e-6)
    monkeypatch.setattr("camrob.report.page.timeline.SAMPLES", 902)
    short = timeline_data(cell, path, posted.solution, {}, Run(at))
    assert short["count"] <= 902 and short["points"] == n and 0.0 <= short["off"] <= 0.021
    monkeypatch.setattr("camrob.report.page.timeline.SAMPLES", 250)  # coarser than one would like, and said
    coarse = timeline_data(cell, path, posted.solution, {}, Run(at))
    assert coarse["count"] <= 260 and short["off"] < coarse["off"] < 1.0


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
def test_paper_shows_the_robot(posted, tmp_path):
    """The picture of WebGL is empty on paper, unless the page hands the printer a copy."""
    sheet = tmp_path / "page.pdf"
    flags = ["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--virtual-time-budget=15000"]
    page = (posted.out / "engraving.html").as_uri()
    subprocess.run([CHROMIUM, *flags, f"--print-to-pdf={sheet}", page], capture_output=True, timeout=300, check=True)
    objects = re.findall(
        rb"<<([^<>]*/Subtype /Image[^<>]*)>>\s*stream\r?\n(.*?)endstream", sheet.read_bytes(), re.DOTALL
    )
    large = [
        data for head, data in objects if int(re.search(rb"/Width (\d+)", head)[1]) > 400 and b"/FlateDecode" in head
    ]
    assert large and all(len(set(zlib.decompress(data))) > 1 for data in large)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
def test_a_browser_draws_the_page_and_walks_the_chain_to_the_first_point(posted):
    flags = ["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--virtual-time-budget=15000", "--dump-dom"]
    page = (posted.out / "engraving.html").as_uri()
    done = subprocess.run([CHROMIUM, *flags, page], capture_output=True, text=True, timeout=300, check=True)
    assert 'data-ready="1"' in done.stdout and "<canvas" in done.stdout
    tip = re.search(r'data-tip="([^"]+)"', done.stdout)
    np.testing.assert_allclose(
        [float(v) for v in tip[1].split()], 1000.0 * np.asarray(posted.path.base_T_tip)[0, :3, 3], atol=2e-3
    )
    nearest = re.search(r'id="nearest">(.+?): <span class="">(\d+) mm', done.stdout)
    assert nearest is not None, "the nearest bodies are said"
    assert int(nearest[2]) >= posted.summary.collisions.clearance_min_mm
    values = re.findall(r'<span class="v">([^<]+)</span>', done.stdout)
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    shown = [float(v.replace("−", "-").rstrip("°m ")) for v in values]
    np.testing.assert_allclose(shown, cell.to_axis_values(np.asarray(posted.solution.q)[0]), atol=0.051)
    assert done.stdout.count('class="cursor"') >= 5


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
@pytest.mark.parametrize("what", [pytest.param("cl-line", marks=pytest.mark.slow), "program-line"])
def test_an_address_leads_to_the_player_at_a_line(posted, what):
    point = int(np.flatnonzero(np.asarray(posted.path.line) == 333)[0])
    text = (posted.out / "engraving.src").read_text().splitlines()
    run = block_of((posted.out / "engraving.html").read_text(encoding="utf-8"), "scene")["run"]
    said = lines_of(run["said"])[point]
    number = 333 if what == "cl-line" else int(re.match(r"engraving\.src (\d+): ", said)[1])
    assert what == "cl-line" or text[number - 1].strip() == said.partition(": ")[2]
    flags = ["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--virtual-time-budget=8000", "--dump-dom"]
    page = f"{(posted.out / 'engraving.html').as_uri()}#{what}={number}"
    done = subprocess.run([CHROMIUM, *flags, page], capture_output=True, text=True, timeout=300, check=True)
    tip = [float(v) for v in re.search(r'data-tip="([^"]+)"', done.stdout)[1].split()]
    first = int(np.flatnonzero([s == said for s in lines_of(run["said"])])[0]) if what == "program-line" else point
    np.testing.assert_allclose(tip, 1000.0 * np.asarray(posted.path.base_T_tip)[first, :3, 3], atol=2e-3)
