"""Arrays and lines of a page's data: read again as pack.py says they stand, by a reader of its own and by the page's script."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from page_data import array_of, block_of, lines_of

from camrob.report.page.html import data_block
from camrob.report.page.pack import packed_floats, packed_integers, packed_lines

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
LINES = [
    "part.src 12: LIN {E6POS: X -73.812,Y 20.800,Z 307.804,A -143.0643,B 0.0000} C_DIS",
    "part.src 13: LIN {E6POS: X 0.001,Y -20.800,Z 7.000,A 180.0000,B 12.5000} C_DIS",
    "",
    "X -0.000 N007 1.2.3 5-3 .5 12. 00 0 -0 +4 1e-5 12345678901234567890",
    "&lt;b&gt; 50 &#x27;%&#x27; 1.10",
    "A1",
    "A2",
]


def test_a_number_comes_back_to_the_nearest_step_and_a_gap_as_a_gap() -> None:
    rng = np.random.default_rng(2)
    for scale in (1e-6, 1.0, 3e5):
        values = scale * rng.normal(size=(400, 3)).cumsum(axis=0)
        values[rng.random(values.shape) < 0.1] = np.nan
        values[0, 0], values[-1, 2] = np.inf, np.nan
        packed = packed_floats(values)
        wanted = np.where(np.isfinite(values), values, np.nan).ravel()
        assert packed.step <= np.nanmax(np.abs(wanted)) * 2.0 / 5_000
        np.testing.assert_allclose(array_of(packed), wanted, atol=0.5001 * packed.step)
        np.testing.assert_allclose(array_of(packed_floats(values, 1e-3 * scale)), wanted, atol=0.5001e-3 * scale)
    assert array_of(packed_floats(np.full(7, 3000.0))).tolist() == [3000.0] * 7
    assert array_of(packed_floats([])).tolist() == [] and np.isnan(array_of(packed_floats([np.nan]))).all()


def test_integers_come_back_as_they_are() -> None:
    values = np.array([[0, -1], [65_535, 2**31 - 1], [-(2**31), 7], [1, 0]])
    assert array_of(packed_integers(values)).tolist() == values.ravel().tolist()
    assert array_of(packed_integers([True, False])).tolist() == [1, 0]


def _page() -> str:
    numbers = np.array([[1.5, np.nan], [-2.25, 1e4], [0.0, -1e-3]])
    data = {
        "lines": packed_lines(LINES),
        "numbers": packed_floats(numbers, 1e-3),
        "whole": packed_integers([5, -70_000]),
    }
    return data_block("scene", data)


def test_lines_come_back_letter_by_letter() -> None:
    found = block_of(_page(), "scene")
    assert lines_of(found["lines"]) == LINES
    assert len(found["lines"]["forms"]) == 5  # the two motions have one, and the two axes
    assert found["whole"].tolist() == [5, -70_000]


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not at hand")
def test_the_page_s_own_script_reads_the_same(tmp_path: Path) -> None:
    scripts = "\n".join((ROOT / f"camrob/report/page/{name}").read_text() for name in ("page.js", "start.js"))
    shown = """
    function camrobPlayer(scene) {
      const said = { lines: camrobLines(scene.lines), numbers: Array.from(scene.numbers), whole: Array.from(scene.whole) };
      document.getElementById("out").textContent = JSON.stringify(said);
      return { recolor() {} };
    }"""
    page = tmp_path / "page.html"
    page.write_text(f"<main></main><pre id='out'></pre>{_page()}<script>{shown}\n{scripts}</script>", encoding="utf-8")
    flags = ["--headless", "--no-sandbox", "--virtual-time-budget=5000", "--dump-dom"]
    done = subprocess.run([CHROMIUM, *flags, page.as_uri()], capture_output=True, text=True, timeout=300, check=True)
    text = re.search(r'<pre id="out">(.*?)</pre>', done.stdout, re.S)[1]
    found = json.loads(text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
    assert found["lines"] == LINES
    assert found["numbers"] == [1.5, None, -2.25, 10_000.0, 0.0, -0.001] and found["whole"] == [5, -70_000]
