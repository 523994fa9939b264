"""The real CL files of the corpus, where it is at hand: every one is read or refused for the right reason."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.toolpath.toolpath import Toolpath

CORPUS = Path(__file__).resolve().parents[4] / "shared" / "corpus" / "cldata"

# file: dialect, GOTO (as the corpus' index counts them), CIRCLE, regions
READ = {
    "camworks_basemach.apt": ("camworks-apt", 2090, 369, 12),
    "camworks_interface_glue.clt": ("camworks-clt", 2036, 30, 4),
    "camworks_leg_holder_thick.apt": ("camworks-apt", 213, 62, 5),
    "camworks_manufacture3_top.apt": ("camworks-apt", 360, 42, 14),
    "camworks_rotate_thick.apt": ("camworks-apt", 482, 108, 5),
    "camworks_sacrifice_board.apt": ("camworks-apt", 494, 70, 8),
    "camworks_shimemcunha.apt": ("camworks-apt", 86, 28, 8),
    "camworks_teflon_gasket.apt": ("camworks-apt", 252, 99, 5),
    "camworks_top_light_cover.apt": ("camworks-apt", 1390, 708, 10),
    "camworks_wall_holes.apt": ("camworks-apt", 1864, 336, 16),
    "creo_bohren.ncl": ("creo-ncl", 4, 0, 1),
    "creo_schruppen.ncl": ("creo-ncl", 5590, 419, 1),
    "makino_plane_1.cldata": ("makino-cldata", 205, 29, 1),
    "nx_coremill.cls": ("nx-clsf", 3130, 614, 1),
    "nx_simple_block.cls": ("nx-clsf", 104, 33, 1),
}


def corpus_file(name: str) -> Path:
    if not CORPUS.is_dir():
        pytest.skip("../shared is not here: the real CL files can't be read")
    return CORPUS / name


@pytest.fixture(scope="module", params=sorted(READ))
def read(request: pytest.FixtureRequest) -> tuple[str, Path, Toolpath]:
    path = corpus_file(request.param)
    return request.param, path, read_toolpath(path)


def test_every_goto_has_its_points_and_every_circle_its_arc(read: tuple[str, Path, Toolpath]) -> None:
    name, path, t = read
    dialect, gotos, circles, regions = READ[name]
    text = path.read_text().splitlines()
    lines = [n for n, s in enumerate(text, 1) if re.match(r"\s*GOTO", s)]
    assert len(lines) == gotos and t.dialect == dialect and len(t.regions) == regions and t.units == "mm"
    assert set(np.concatenate([r.line for r in t.regions]).tolist()) == set(lines)
    assert sum(1 for s in text if re.match(r"\s*CIRCLE", s)) == circles
    flat = sum(len(r.arcs) for r in t.regions)
    assert flat == circles


def test_arcs_leave_and_meet_their_neighbours_smoothly(read: tuple[str, Path, Toolpath]) -> None:
    """A wrong sense of the arcs would turn nearly all of these round; the few that do turn are sharp corners."""
    smooth = sharp = 0
    for r in read[2].regions:
        for a in r.arcs:
            for at, other, sign in ((a.first, a.first - 1, 1.0), (a.last, a.last + 1, -1.0)):
                if not 0 <= other < len(r) or r.move[max(at, other)] == Move.RAPID:
                    continue
                step = (r.position[at] - r.position[other]) * sign
                length = float(np.linalg.norm(step))
                if length < 1e-7:
                    continue
                along = float(np.cross(a.axis, r.position[at] - a.center) @ step) / (a.radius * length)
                smooth += along > 0.95
                sharp += along < -0.95
    assert smooth + sharp > 0 or not READ[read[0]][2]
    assert sharp <= 0.05 * (smooth + sharp)


def test_arcs_lie_on_their_circles(read: tuple[str, Path, Toolpath]) -> None:
    for r in read[2].regions:
        for a in r.arcs:
            off = r.position[a.first : a.last + 1] - a.center
            assert np.max(np.abs(off @ a.axis)) < 2e-6
            assert np.max(np.abs(np.linalg.norm(off, axis=1) - a.radius)) < 2e-6  # files round to 0.0001 mm


def test_cuts_have_a_feed_and_axes_are_unit_vectors(read: tuple[str, Path, Toolpath]) -> None:
    for r in read[2].regions:
        assert np.all(r.feed[r.move == Move.CUT] > 0.0)
        assert np.all(np.isnan(r.feed[r.move == Move.RAPID]))
        np.testing.assert_allclose(np.linalg.norm(r.axis, axis=1), 1.0, rtol=1e-12)


def test_known_numbers_of_known_files() -> None:
    t = read_toolpath(corpus_file("nx_coremill.cls"))
    first = t.regions[0]
    np.testing.assert_allclose(first.position[0] * 1000, [150.0, -17.6975, 143.0])
    assert first.name == "ZLEVEL_FOLLOW_CORE" and t.tools[0].diameter == pytest.approx(0.030)
    assert np.count_nonzero(first.move == Move.RAPID) == 356
    cuts = first.feed[first.move == Move.CUT] * 60_000
    np.testing.assert_allclose(cuts, 250.0)
    drill = read_toolpath(corpus_file("creo_bohren.ncl")).regions[0]
    low = drill.position[drill.position[:, 2] < 0.0] * 1000
    assert np.min(low[:, 2]) == pytest.approx(-3.0)  # 3.5 deep from z 0.5
    assert sorted(set(np.round(drill.position[:, 0] * 1000, 4))) == [-16.7804, -7.2291]
    glue = read_toolpath(corpus_file("camworks_interface_glue.clt"))
    assert all(np.allclose(r.axis, [0, -1, 0], atol=1e-6) for r in glue.regions)
    holes = glue.regions[0]
    assert np.max(holes.position[:, 1]) * 1000 == pytest.approx(21.927686 + 12.3733, abs=1e-4)
    tilted = read_toolpath(corpus_file("camworks_shimemcunha.apt"))
    np.testing.assert_allclose(tilted.regions[0].axis[0], [0.005061, 0, 0.999987], atol=1e-6)
    np.testing.assert_allclose(tilted.regions[1].axis[0], [0, 0, 1], atol=0)


def test_the_hand_made_file_is_refused_for_its_cycle() -> None:
    with pytest.raises(ToolpathError, match="CYCLE81") as error:
        read_toolpath(corpus_file("handmade_words.apt"))
    assert error.value.line == 16


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(
    "name", ["nx_coremill.cls", "creo_schruppen.ncl", "camworks_wall_holes.apt", "camworks_interface_glue.clt"]
)
def test_cut_off_anywhere_they_are_refused_or_said(name: str, tmp_path: Path) -> None:
    data = corpus_file(name).read_bytes()
    for share in (0.2, 0.5, 0.77, 0.9, 0.999):
        cut = tmp_path / name
        cut.write_bytes(data[: int(len(data) * share) - 3])
        try:
            t = read_toolpath(cut)
        except ToolpathError:
            continue
        assert any(f.code == "no-end" for f in t.findings)
