"""The page of a judgement says first what stands against the program, and shows the place."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from camrob.jobs.verify import verify

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
ENGRAVING = ROOT / "toolpaths" / "engraving"


def program(folder: Path, spoil: bool) -> Path:
    """The golden engraving, one target of it 60 mm too deep, or as it is."""
    folder.mkdir()
    for name in ("engraving.src", "engraving.dat"):
        (folder / name).write_bytes((ENGRAVING / "golden" / name).read_bytes())
    file = folder / "engraving.src"
    if spoil:
        lines = file.read_text().splitlines()
        k = [i for i, text in enumerate(lines) if text.startswith("LIN")][60]
        lines[k] = re.sub(r"Z (-?[\d.]+)", lambda m: f"Z {float(m[1]) - 60:.3f}", lines[k])
        file.write_text("\n".join(lines) + "\n")
    return file


@pytest.mark.parametrize("spoil", [True, False])
def test_the_verdict_comes_first_and_then_the_place(spoil: bool, tmp_path: Path) -> None:
    file = program(tmp_path / "p", spoil)
    out = tmp_path / "out"
    result = verify(file, cell=KR15, against=ENGRAVING / "engraving.cls", manifest=False, out=out)
    assert sorted(f.name for f in out.iterdir()) == ["verify.html", "verify.json"]
    assert json.loads((out / "verify.json").read_text())["ok"] is not spoil
    page = (out / "verify.html").read_text(encoding="utf-8")
    text = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"https?://", text)
    headings = re.findall(r"<h2>(.*?)</h2>", text)
    if not spoil:
        assert result.ok and 'class="verdict good"' in text and "Against it" not in headings
        return
    assert 'class="verdict bad"' in text and headings[:2] == ["Against it", "Where"]
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', text)
    assert 1 <= len(pictures) <= 4
    first = tmp_path / "first.png"
    first.write_bytes(base64.b64decode(pictures[0]))
    r, g, b = np.moveaxis(imread(first)[..., :3], -1, 0)
    red = np.sum((r > 0.6) & (g < 0.3) & (b < 0.3))
    assert red > 200  # pixels of the ball at the tip
    line = next(e.line for e in result.summary.errors if e.line)
    assert f"line {line}" in text


def test_a_program_that_cannot_be_replayed_has_a_page_without_pictures(tmp_path: Path) -> None:
    file = tmp_path / "empty.src"
    file.write_text("DEF EMPTY ( )\nEND\n")
    result = verify(file, cell=KR15, out=tmp_path / "out")
    page = (tmp_path / "out" / "verify.html").read_text(encoding="utf-8")
    assert result.ok is not True and "<img style" not in page
