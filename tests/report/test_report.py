"""The report page: nothing runs that came from a file, nothing is loaded, the same input gives the same page."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import trimesh
from page_data import data_of, library_of
from summary_samples import POST, post_summary, region

from camrob.cell.read_cell import read_cell
from camrob.cell.shape import Shape, ShapeKind
from camrob.findings import Finding, Severity
from camrob.kinematics.kernels import chain_arrays, forward_many, inverse_kf_many
from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.redundancy.solution import Revision, Solution
from camrob.report.page.figures import figure_conditioning, figure_overview
from camrob.report.page.html import data_block, escape, number, plot_text
from camrob.report.page.render import fill
from camrob.report.page.thinning import curve_indices, path_indices
from camrob.report.page.timeline import Run
from camrob.report.page.triangles import joined, shape_mesh, thinned, world_T_frames
from camrob.report.post.page import post_report

CELL = read_cell(Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table")
BALL = Shape("ball", "ball", "world", ShapeKind.SPHERE, np.array([0.1]), np.eye(4))
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'\u2028\u2029\u202e%{x}\ud800"


def _made(n=400, *, feed=0.05):
    """A path of two regions with travel between, made from postures round HOME, so that it is exactly tracked."""
    t = np.linspace(0.0, 1.0, n)
    q = np.tile(CELL.q_home, (n, 1))
    q[:, 0] += 0.6 * np.sin(3.0 * t)
    q[:, 1] += 0.2 * np.sin(5.0 * t)
    q[:, 3] += 0.15 * np.sin(9.0 * t)
    q[:, 4] -= 0.10 * np.cos(7.0 * t)
    region = np.where(t < 0.45, 0, np.where(t > 0.6, 1, TRANSIT)).astype(np.int32)
    cut = region >= 0
    chain = chain_arrays(CELL)
    path = ToolPathInBase(
        forward_many(chain, q),
        np.where(cut, 1, 2),
        np.where(cut, feed, np.nan),
        np.where(cut, np.arange(n) + 10, 0),
        region,
        np.where(cut, np.arange(n), -1),
        ~cut,
    )
    back = np.linspace(q[n // 2], q[n // 2], 9)
    revisions = (Revision(1, n // 2, back, True, 0.41, 0.58),) if n > 2 else ()
    return path, Solution("vjm", q, inverse_kf_many(chain, q), CELL.digest, path.digest, revisions)


def _summary(path, name="carving", **changes):
    regions = [
        region(
            k,
            f"{name} {k}",
            points=int(np.sum(path.region == k)),
            revised=k == 1,
            inv_kf_before=0.41,
            inv_kf_after=0.58,
        )
        for k in sorted(set(path.region[path.region >= 0].tolist()))
    ]
    plain = {
        "program": name,
        "source": {"file": f"{name}.cls", "dialect": name},
        "points": int(np.sum(path.source >= 0)),
        "regions": regions,
        "time_s": {"optimal": None},
        "verified": {"by": f"replay {name}", "points": len(path)},
        "feed": {"losses": [POST["feed"]["losses"][0] | {"cause": name}], "lost_by_axis_s": {name: 1.0}},
        "torques": {"masses": [name], "axes": {name: POST["torques"]["axes"]["A2"]}},
        "warnings": [],
    }
    return post_summary(**plain | changes)


def _page(path, solution, name="carving", **more):
    return post_report(_summary(path, name), CELL, path, solution, **{"findings": [], "run": _run(path), **more})


def _run(path):
    return Run(np.linspace(0.0, 60.0, len(path)), [f"carving.src {k}: LIN" for k in range(len(path))])


DATA = ("application/json", "application/gzip")


def _block(attrs, text):
    """A block of data as the page reads it."""
    return data_of(text, packed=attrs["type"] == "application/gzip")


class _Reader(HTMLParser):
    """What a browser sees: scripts with their types, attributes, and text outside scripts."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.scripts, self.tags, self.text, self.inside = [], [], [], None

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self.inside = tag
            self.scripts.append((dict(attrs), "")) if tag == "script" else None

    def handle_endtag(self, tag):
        self.inside = None if tag == self.inside else self.inside

    def handle_data(self, data):
        if self.inside == "script":
            attrs, before = self.scripts.pop()
            self.scripts.append((attrs, before + data))
        elif self.inside is None:
            self.text.append(data)


def _read(page):
    reader = _Reader()
    reader.feed(page)
    reader.close()
    return reader


@pytest.fixture(scope="module")
def made():
    return _made()


def test_nothing_is_loaded_and_only_its_own_scripts_may_run(made):
    page = _page(*made, part_mesh=trimesh.creation.box((0.1, 0.1, 0.1)).triangles, base_T_part=np.eye(4))
    reader = _read(page)
    for tag, attrs in reader.tags:
        assert tag not in {"link", "iframe", "img", "object", "embed", "base", "form", "video", "audio"}
        assert tag != "a" or re.fullmatch(r"#(part-|cl-line=)\d+", attrs.pop("href"))  # of the page itself
        assert not {"src", "href", "srcset", "data", "action"} & set(attrs)
        assert not any(name.startswith("on") for name in attrs)
    style = re.search(r"<style>(.*?)</style>", page, re.S).group(1)
    assert "url(" not in style and "@import" not in style
    policy = next(a["content"] for t, a in reader.tags if t == "meta" and "http-equiv" in a)
    assert "default-src 'none'" in policy and "connect-src 'none'" in policy
    rules = next(rule for rule in policy.split(";") if rule.strip().startswith("script-src"))
    assert "unsafe" not in rules
    running = [text for attrs, text in reader.scripts if "type" not in attrs]
    assert len(running) == 5
    libraries = [library_of(text) for attrs, text in reader.scripts if attrs.get("class") == "library"]
    assert len(libraries) == 2 and {a["type"] for a, _ in reader.scripts if "type" in a} <= set(DATA)
    for text in [*running, *libraries]:
        assert base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() in rules


def test_hostile_names_stay_text(made):
    path, solution = made
    finding = Finding(HOSTILE, HOSTILE, Severity.ERROR, line=3, axis=HOSTILE, unit=HOSTILE, value=1.0, limit=2.0)
    plain = _read(_page(path, solution))
    page = _page(path, solution, HOSTILE, findings=[finding], comparison={HOSTILE: solution.inv_kf})
    page.encode("utf-8")
    reader = _read(page)
    assert len(reader.scripts) == len(plain.scripts)
    assert [a for a, _ in reader.scripts] == [a for a, _ in plain.scripts]
    extra = [tag for tag, _ in reader.tags if tag not in {tag for tag, _ in plain.tags}]
    assert set(extra) <= {"tr", "td", "table", "thead", "th", "tbody", "span", "div", "code"}
    assert any("alert(1)" in text for text in reader.text)
    assert "\u202e" not in page and "\u2028" not in page and "\ud800" not in page
    for attrs, text in reader.scripts:
        if attrs.get("type") in DATA and "class" not in attrs:
            assert "<" not in text
            for value in _strings(_block(attrs, text)):
                assert "<script" not in value and "<img" not in value and "%{x}" not in value


def _strings(data):
    if isinstance(data, dict):
        data = [*data, *data.values()]
    if isinstance(data, list):
        for item in data:
            yield from _strings(item)
    elif isinstance(data, str):
        yield data


def test_block_of_data_cannot_be_ended_from_inside():
    data = {"a": HOSTILE, "n": [float("nan"), float("inf"), 1.5]}
    block = data_block('x"', data)
    assert block.count("</script") == 1 and block.startswith('<script type="application/json" id="x&quot;">')
    back = json.loads(block[block.index(">") + 1 : block.rindex("</script>")])
    assert back == {"a": HOSTILE, "n": [None, None, 1.5]}
    assert escape("\x00<'\">&") == " &lt;&#x27;&quot;&gt;&amp;"
    assert plot_text("<a>%{y}") == "&lt;a&gt;% {y}"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1234.56, "1,234.6 mm"),
        (None, "–"),
        (float("nan"), "–"),
        (-3.0, "−3.0 mm"),
        (3e-10, "3.0 × 10⁻¹⁰ mm"),
    ],
)
def test_numbers_as_they_are_read(value, text):
    assert number(value, 1, "mm") == text


def test_same_input_same_page(made):
    assert _page(*made, findings=[Finding("a", "b")]) == _page(*made, findings=[Finding("a", "b")])


def test_order_of_the_page_and_what_it_says(made):
    findings = [
        Finding("low", "a remark", Severity.INFO),
        Finding("cut", "left out", line=34),
        Finding("cut", "left out", line=50),
    ]
    page = _page(*made, findings=findings)
    wanted = [
        "<h1>",
        'class="verdict',
        "<h2>Warnings",
        'class="cards"',
        'id="view"',
        'id="conditioning"',
        'id="axes"',
        'id="external"',
        'id="feed"',
        "<h2>Regions",
    ]
    places = [page.index(text) for text in wanted]
    assert places == sorted(places)
    assert page.index("left out") < page.index("a remark")
    row = re.search(r"<tr><td><span class=\"tag warning\">.*?</tr>", page).group(0)
    assert "line 34" in row and '<td class="n">2</td>' in row
    assert "Verified, with warnings" in page and "5 min 10 s" in page and "0.410 → 0.580" in page


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"limits": {"margin_min": {"A1": -1.0}, "violations": 2}}, "2 axis limit violations"),
        ({"collisions": {"checked": True, "count": 1, "clearance_min_mm": 0.0}}, "1 collision"),
        ({"singular": 3}, "3 singular points"),
    ],
)
def test_verdict_never_calls_a_fault_good(made, change, words):
    path, solution = made
    page = post_report(_summary(path, **change), CELL, path, solution, findings=[], run=_run(path))
    line = re.search(r'<div class="verdict (\w+)">(.*?)</div>', page)
    assert line.group(1) == "bad" and words in line.group(2)


def test_what_the_witness_could_not_judge_is_said_in_the_verdict(made):
    path, solution = made
    page = post_report(_summary(path, witness={"complete": False}), CELL, path, solution, findings=[], run=_run(path))
    line = re.search(r'<div class="verdict (\w+)">(.*?)</div>', page)
    assert line.group(1) == "warn" and "Verified in part" in line.group(2)


def test_a_single_point_and_a_path_without_feed():
    for n in (1, 2):
        path, solution = _made(n)
        page = _page(path, solution)
        assert 'id="conditioning"' in page and "<h2>Regions" in page
    path, solution = _made(60, feed=np.nan)
    page = _page(path, solution)
    assert 'id="feed"' not in page
    charts = next(_block(a, t) for a, t in _read(page).scripts if a.get("id") == "charts")
    assert [c["id"] for c in charts] == ["conditioning", "axes", "external", "weights"]
    assert {t["name"] for t in charts[-1]["traces"]} >= {"E2", "E1", "A3", "A5"}  # what the cell's engine weighs
    assert "the posture lag" in page and "pulls each axis to its reference posture" in page


def test_gaps_in_a_comparison_and_wrong_lengths(made):
    path, solution = made
    holes = np.where(path.region == 1, np.nan, solution.inv_kf)
    page = _page(path, solution, comparison={"without revision": holes}, bound=solution.inv_kf + 0.05)
    charts = next(_block(a, t) for a, t in _read(page).scripts if a.get("id") == "charts")
    assert {"without revision", "upper bound (best posture at each point)"} <= {t["name"] for t in charts[0]["traces"]}
    page = _page(path, solution, comparison={"without revision": solution.inv_kf.copy()})
    charts = next(_block(a, t) for a, t in _read(page).scripts if a.get("id") == "charts")
    names = [t["name"] for t in charts[0]["traces"]]
    assert "this program; the same without revision" in names and "without revision" not in names
    with pytest.raises(ValueError, match="has shape"):
        _page(path, solution, comparison={"x": holes[:-1]})
    with pytest.raises(ValueError, match="bound"):
        _page(path, solution, bound=holes[:-1])


def test_long_program_stays_small():
    path, solution = _made(2000)
    k = 100
    long = ToolPathInBase(
        np.tile(path.base_T_tip, (k, 1, 1)),
        *(np.tile(getattr(path, name), k) for name in ("move", "feed", "line", "region", "source", "safe")),
    )
    many = Solution("vjm", np.tile(solution.q, (k, 1)), np.tile(solution.inv_kf, k), CELL.digest, long.digest)
    findings = [Finding("a", "the same thing", line=i) for i in range(10_000)]
    part = trimesh.creation.icosphere(subdivisions=6, radius=0.1).triangles
    page = _page(long, many, findings=findings, part_mesh=part, comparison={"x": many.inv_kf}, bound=many.inv_kf)
    assert len(page) < 4e6
    assert "10,000" in page and "too many regions to tint" in page


def test_curves_keep_their_extremes_and_gaps():
    rng = np.random.default_rng(0)
    y = rng.normal(size=100_003)
    y[777], y[50_001] = 40.0, -40.0
    y[20_000:30_000] = np.nan
    picked = curve_indices(y, 4000)
    assert len(picked) <= 4002 and np.all(np.diff(picked) > 0)
    assert {0, 777, 50_001, len(y) - 1} <= set(picked.tolist())
    assert np.isnan(y[picked]).any()
    inside = (picked > 19_950) & (picked < 30_050)
    runs = np.flatnonzero(np.diff(np.isnan(y[picked][inside])))
    assert len(runs) == 2
    assert np.array_equal(curve_indices(y[:10], 4000), np.arange(10))


def test_thinned_path_keeps_corners():
    x = np.linspace(0.0, 1.0, 10_001)
    p = np.stack([x, np.abs(x - 0.61234), np.zeros_like(x)], axis=1)
    keep = np.zeros(len(x), dtype=bool)
    keep[4321] = True
    picked = path_indices(p, keep, 200)
    assert len(picked) < 210 and 4321 in picked and picked[0] == 0 and picked[-1] == 10_000
    assert p[picked, 1].min() == pytest.approx(p[:, 1].min(), abs=1e-9)


def test_thinned_mesh_has_the_same_bounds():
    mesh = joined(trimesh.creation.icosphere(subdivisions=6, radius=0.2).triangles)
    small = thinned(mesh, 4000)
    assert len(small.faces) <= 4000
    np.testing.assert_allclose(small.bounds, mesh.bounds, atol=0.01)
    assert thinned(small, 4000) is small


def test_frames_hold_the_tool_on_the_path(made):
    """Tool seen from the table, both taken from `world`, is the path's own: the picture can't leave the program."""
    path, solution = made
    frames = world_T_frames(CELL, solution.q)
    base_T_tool = np.linalg.inv(frames["base"]) @ frames["tool"]
    np.testing.assert_allclose(base_T_tool[:, :3, 3], path.base_T_tip[:, :3, 3], atol=1e-12)
    still = frames["root"][:, :3, 3]
    assert np.ptp(still[:, 2]) < 1e-12 and np.ptp(still[:, 1]) > 0.05  # the foot moves along the track alone
    assert np.ptp(still[:, 0]) < 1e-12


SIZES = {
    ShapeKind.BOX: lambda s: (s, np.prod(s)),
    ShapeKind.CYLINDER: lambda s: ((2 * s[0], 2 * s[0], s[1]), np.pi * s[0] ** 2 * s[1]),
    ShapeKind.CAPSULE: lambda s: ((2 * s[0], 2 * s[0], s[1] + 2 * s[0]), np.pi * s[0] ** 2 * (s[1] + 4 / 3 * s[0])),
    ShapeKind.SPHERE: lambda s: (3 * [2 * s[0]], 4 / 3 * np.pi * s[0] ** 3),
}


@pytest.mark.parametrize("shape", [*CELL.shapes, BALL], ids=lambda s: s.name)
def test_shapes_are_closed_face_outwards_and_are_of_their_size(shape):
    mesh = trimesh.Trimesh(*shape_mesh(replace(shape, frame_T_shape=np.eye(4)), CELL.folder), process=False)
    sizes, volume = SIZES[shape.kind](shape.size)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=0.02)  # below zero where it faces inwards
    np.testing.assert_allclose(mesh.extents, sizes, rtol=0.01)
    np.testing.assert_allclose(mesh.bounds.mean(axis=0), 0.0, atol=1e-9)


def test_depth_buffer_equals_its_plain_twin():
    rng = np.random.default_rng(1)
    corners = rng.uniform(-4.0, 34.0, size=(40, 3, 3))
    depth, owner = np.full((30, 32), -np.inf), np.full((30, 32), -1, np.int32)
    fill(corners, depth, owner)
    x, y = np.meshgrid(np.arange(32) + 0.5, np.arange(30) + 0.5)
    best, who = np.full((30, 32), -np.inf), np.full((30, 32), -1)
    for k, corner in enumerate(corners):
        (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = corner
        w1, w2 = np.linalg.solve([[x1 - x0, x2 - x0], [y1 - y0, y2 - y0]], [(x - x0).ravel(), (y - y0).ravel()])
        w1, w2 = w1.reshape(x.shape), w2.reshape(x.shape)
        z = z0 + w1 * (z1 - z0) + w2 * (z2 - z0)
        wins = (w1 >= 0) & (w2 >= 0) & (w1 + w2 <= 1) & (z > best)
        best, who = np.where(wins, z, best), np.where(wins, k, who)
    assert np.array_equal(owner, who)
    np.testing.assert_allclose(depth[owner >= 0], best[owner >= 0], rtol=1e-12)


@pytest.mark.slow
def test_figures_are_written(made, tmp_path):
    path, solution = made
    curve, picture = tmp_path / "curve.png", tmp_path / "cell.png"
    names = {0: "top $x_1", 1: "side"}
    others = {"without $fuzzy$ weights": solution.inv_kf - 0.05}
    figure_conditioning(
        path, solution, file=curve, threshold=0.5, names=names, comparison=others, bound=solution.inv_kf
    )
    part = trimesh.creation.box((0.2, 0.2, 0.1)).triangles
    figure_overview(CELL, path, solution, file=picture, point=50, part_mesh=part, base_T_part=np.eye(4))
    for file in (curve, picture):
        assert file.read_bytes().startswith(b"\x89PNG") and file.stat().st_size > 20_000
