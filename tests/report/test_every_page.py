"""What holds for every page: a verdict first, nothing beyond its edge, letters that can be read, pictures that have names."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.report.page.cloud import Cloud
from camrob.report.page.html import page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_pair
from camrob.report.page.parts import chooser, section, table, verdict_bar

ROOT = Path(__file__).resolve().parents[2]
REPORT = ROOT / "camrob" / "report"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
READABLE = 4.5  # contrast of text that WCAG 2.1 AA asks for

PROBE = Path(__file__).with_name("page_probe.js").read_text(encoding="utf-8")


def _faults(html: str, folder: Path, *, dark: bool, sideways: bool = False) -> list[str]:
    """What a browser of 800 pixels finds wrong with a page. sideways: its tables may be scrolled to either side."""
    policy = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')
    assert policy.search(html)
    file = folder / "page.html"
    probe = PROBE.replace("READABLE", f"{READABLE}").replace("SIDEWAYS", "true" if sideways else "false")
    file.write_text(policy.sub("", html).replace("</body>", f"<script>{probe}</script></body>"), encoding="utf-8")
    flags = [
        "--headless",
        "--no-sandbox",
        "--enable-unsafe-swiftshader",
        "--window-size=800,900",
        "--virtual-time-budget=30000",
    ]
    flags += ["--blink-settings=preferredColorScheme=0"] if dark else []
    told = subprocess.run(
        [str(CHROMIUM), *flags, "--dump-dom", file.as_uri()], capture_output=True, timeout=300, check=True
    )
    found = re.search(r'data-faults="([^"]*)"', told.stdout.decode())
    assert found is not None, "the page was never drawn"
    return list(json.loads(found[1].replace("&quot;", '"').replace("&amp;", "&")))


def _sampler(*, faint: bool = False, wide: bool = False) -> str:
    """A page with every part that pages share; with faults of its own, where asked for."""
    x = np.linspace(0.0, 1.0, 50)
    charts = [LineChart(f"c{k}", "a chart", "", "s [rad]", "q [rad]", (Curve("q", x, x**k),)) for k in (1, 2)]
    cloud = Cloud(
        "cloud",
        "points",
        np.column_stack([x, x**2, x**3]),
        x,
        0.0,
        1.0,
        ((0.0, "#2166ac"), (1.0, "#b2182b")),
        "error",
        (1, 1, 1),
    )
    rows = [[f"row {k}", *(f"{k},{n:03d}.123 mm" for n in range(14))] for k in range(60)]
    body = "".join(
        [
            "<main><h1>all parts</h1>",
            verdict_bar("warn", "Look at it.", 'There is <a href="#x">much</a> of it.'),
            section("Wide and long", table(["what", *(f"column {n}" for n in range(14))], rows)),
            section("In space", cloud.html()),
            chooser(
                "Chosen", {"axis": ["A1", "A2"]}, {("A1",): chart_pair(charts[:1]), ("A2",): chart_pair(charts[1:])}
            ),
            '<section style="width:1200px">cut</section>' if wide else "",
            '<p class="caption" style="color:#999">faint <svg width="9" height="9"></svg></p>' if faint else "",
            "</main>",
        ]
    )
    return page("all parts", body, {"names": {}, "charts": chart_data(charts), "clouds": [cloud.data()]})


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
@pytest.mark.parametrize("dark", [False, True])
def test_what_pages_share_stays_within_800_pixels_and_can_be_read(tmp_path: Path, dark: bool) -> None:
    assert not _faults(_sampler(), tmp_path, dark=dark, sideways=True)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
def test_the_probe_sees_what_is_cut_faint_or_nameless(tmp_path: Path) -> None:
    found = _faults(_sampler(faint=True, wide=True), tmp_path, dark=False)
    assert {text.split(":")[0] for text in found} == {"beyond the edge", "faint", "no name", "only by scrolling"}


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
def test_a_posted_page_stays_within_800_pixels_and_says_its_own_figures(tmp_path: Path) -> None:
    sample = ROOT / "toolpaths" / "globe"
    made = post(sample / "globe.cls", cell=ROOT / "cells" / "kr15_track_table", out=tmp_path / "out")
    html = (tmp_path / "out" / "globe.html").read_text(encoding="utf-8")
    assert not _faults(html, tmp_path, dark=True)
    # one lowest and one mean on card, chart, table of regions and beside the paper, those of the JSON
    figures = json.loads((tmp_path / "out" / "globe.json").read_text())["conditioning"]
    lowest, mean = f"{figures['inv_kf_min']:.3f}", f"{figures['inv_kf_mean']:.3f}"
    assert made.summary.conditioning.inv_kf_min == figures["inv_kf_min"]
    assert f'<div class="value">{lowest}</div>' in html and f"mean {mean}" in html
    assert f"is {mean} in the mean, {lowest} at the lowest" in html
    assert f">{lowest}</td>" in html


def _palettes() -> list[dict[str, str]]:
    """The colours of a page by their names: light, and dark."""
    css = (REPORT / "page" / "page.css").read_text(encoding="utf-8")
    light, dark = re.findall(r":root[^{]*\{(.*?)\}", css, re.DOTALL)[:2]
    first = dict(re.findall(r"--([\w-]+): (#\w{6})", light))
    return [first, first | dict(re.findall(r"--([\w-]+): (#\w{6})", dark))]


def _contrast(a: str, b: str) -> float:
    def light(color: str) -> float:
        parts = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [v / 12.92 if v <= 0.03928 else ((v + 0.055) / 1.055) ** 2.4 for v in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    high, low = sorted((light(a), light(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("colors", _palettes(), ids=["light", "dark"])
def test_every_colour_of_words_can_be_read_on_every_ground_that_it_stands_on(colors: dict[str, str]) -> None:
    pairs = [(text, ground) for text in ("text", "soft", "info", "bad") for ground in ("bg", "panel")]
    pairs += [(kind, f"{kind}-bg") for kind in ("good", "warn", "bad", "info")]
    pairs += [("text", f"{kind}-bg") for kind in ("good", "warn", "bad", "info")]
    faint = {pair: round(_contrast(*(colors[name] for name in pair)), 2) for pair in pairs}
    assert not {pair: ratio for pair, ratio in faint.items() if ratio < READABLE}


@pytest.mark.parametrize("file", sorted(REPORT.glob("*/page.py")), ids=lambda file: file.parent.name)
def test_every_report_s_page_has_a_verdict(file: Path) -> None:
    assert re.search(r"verdict_bar|statements_verdict|[. ]verdict\(|class=\"verdict", file.read_text(encoding="utf-8"))


def test_every_table_scrolls_by_itself_where_it_is_wider_than_the_page() -> None:
    bare = [
        f"{file.relative_to(ROOT)}: {line.strip()[:60]}"
        for file in REPORT.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if "<table" in line and not re.search(r"scroll|framed\(|TABLE", line)
    ]
    assert not bare
