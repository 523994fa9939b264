"""The witness's reader on real files (../shared/corpus, ../shared/repro) and on the samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.witness.cl import read_story
from camrob.witness.happenings import Story

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared"

# motions, arcs, holes, least and greatest corner in mm
CORPUS = {
    "cldata/camworks_basemach.apt": (2137, 369, 16, (12.5, 12.5, -10.5), (335.5, 133.5, 25)),
    "cldata/camworks_interface_glue.clt": (2053, 30, 6, (11.388, -25, -2.408), (123.613, 34.301, 123.615)),
    "cldata/camworks_leg_holder_thick.apt": (220, 62, 3, (15.96, -57.176, -12.502), (157.222, 57.176, 103)),
    "cldata/camworks_manufacture3_top.apt": (446, 42, 31, (-5.544, 134.934, -9.002), (462.936, 497.999, 25)),
    "cldata/camworks_rotate_thick.apt": (508, 108, 10, (-1.14, -17.511, -15.604), (314.22, 117.511, 103)),
    "cldata/camworks_sacrifice_board.apt": (574, 70, 28, (-52.5, 19.896, -55), (492.5, 150, 25)),
    "cldata/camworks_shimemcunha.apt": (92, 28, 3, (-52.494, 3.223, -3.193), (88.89, 34.672, 25.449)),
    "cldata/camworks_teflon_gasket.apt": (254, 99, 2, (9.25, -6.693, -41.003), (20.597, 19.626, 25)),
    "cldata/camworks_top_light_cover.apt": (1399, 708, 4, (-15.5, -15.5, -31.801), (204.5, 204.5, 25)),
    "cldata/camworks_wall_holes.apt": (1872, 336, 6, (-25, -10, -65.382), (60, 110, 25)),
    "cldata/creo_bohren.ncl": (8, 0, 2, (-16.78, -23, -3), (-7.229, -23, 2)),
    "cldata/creo_schruppen.ncl": (5590, 419, 0, (-17.625, -23.834, -6.84), (-6.384, -2.974, 2)),
    "cldata/makino_plane_1.cldata": (205, 29, 0, (0, -5, 28), (55, 30, 50)),
    "cldata/nx_coremill.cls": (3130, 614, 0, (-20.444, -20.442, 30), (320.444, 220.444, 146)),
    "cldata/nx_simple_block.cls": (104, 33, 0, (-12.997, -14.026, 15), (112.7, 112.7, 40)),
    "gcode/freecad_platteyz-pass-3-helix.nc": (210, 160, 0, (61, 20, -3), (163.2, 80, 6)),
    "gcode/linuxcnc_boat-xyzac.ngc": (1824, 4, 0, (-49.969, -26.323, -13.25), (46.264, 22.345, 10)),
    "gcode/linuxcnc_impeller-7bl-xyzac.ngc": (4492, 0, 0, (-45.381, -44.995, -2.653), (42.87, 44.219, 40)),
}


def shared(name: str) -> Path:
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"{path} is not here")
    return path


def sound(story: Story) -> None:
    """What holds of every story: unit axes, arcs that close, columns of one length, feeds above 0, events in order."""
    path, n = story.path, len(story)
    assert np.isfinite(path.tip).all() and np.abs(np.linalg.norm(path.axis, axis=1) - 1.0).max() < 1e-12
    assert all(
        len(column) == n for column in (story.way, story.feed, story.joined, story.operation, path.angle, path.line)
    )
    assert (np.diff(path.line) >= 0).all() and (np.diff(story.operation) >= 0).all() and story.operation[0] == 0
    assert [e.before for e in story.events] == sorted(e.before for e in story.events)
    assert (story.feed[story.way > 0] > 0.0).all() and np.isnan(story.feed[story.way == 0]).all()
    arcs = np.flatnonzero(np.isfinite(path.angle))
    assert story.joined[arcs].all() and (path.angle[arcs] > 0.0).all()
    for i in arcs:
        normal, center, angle = path.normal[i], path.center[i], path.angle[i]
        ends = [path.tip[i - 1] - center, path.tip[i] - center]
        start, end = (v - (v @ normal) * normal for v in ends)
        assert abs(np.linalg.norm(start) - np.linalg.norm(end)) < 1e-6
        turned = start * np.cos(angle) + np.cross(normal, start) * np.sin(
            angle
        )  # Rodrigues, start is across the normal
        assert np.linalg.norm(turned - end) < 1.5e-6


def ends(story):
    """Which motions end where the file says so, not on the way of a block that turns axes."""
    same = np.diff(story.path.line) == 0
    return np.append(~(same & (np.abs(np.diff(story.path.axis, axis=0)).max(axis=1) > 1e-9)), True)


@pytest.mark.parametrize("name", CORPUS)
def test_real_files_read_whole(name):
    story = read_story(shared(f"corpus/{name}"))
    motions, arcs, holes, least, greatest = CORPUS[name]
    assert story.complete and (
        int(ends(story).sum()),
        int(np.isfinite(story.path.angle).sum()),
        int((story.way == 2).sum()),
    ) == (
        motions,
        arcs,
        holes,
    )
    assert story.path.tip.min(0) * 1000 == pytest.approx(least, abs=1e-3)
    assert story.path.tip.max(0) * 1000 == pytest.approx(greatest, abs=1e-3)
    sound(story)


@pytest.mark.parametrize(
    ("name", "motions", "gaps"),
    [("cldata/handmade_words.apt", 3, [16, 17, 19]), ("gcode/linuxcnc_simple_example.ngc", 2, [9])],
)
def test_real_files_with_gaps(name, motions, gaps):
    story = read_story(shared(f"corpus/{name}"))
    assert len(story) == motions and [g.first_line for g in story.gaps] == gaps


@pytest.mark.parametrize("name", ["linuxcnc_circular_pocket.ngc", "upm_spiral_xzc.nc"])
def test_no_motion_of_a_subprogram_that_nothing_calls_nor_of_a_lathe(name):
    with pytest.raises(ToolpathError, match="no motion"):
        read_story(shared(f"corpus/gcode/{name}"))


def test_arcs_run_on_smoothly_from_what_is_before_them():
    """Tangents at arcs in NX and Creo files meet those of their neighbours: the wrong direction would turn them round."""
    for name, least in (
        ("nx_coremill.cls", 0.99),
        ("creo_schruppen.ncl", 0.99),
        ("camworks_basemach.apt", 0.95),
        ("makino_plane_1.cldata", 0.95),
    ):
        path = read_story(shared(f"corpus/cldata/{name}")).path
        cosines = []
        for i in np.flatnonzero(np.isfinite(path.angle)):
            before = path.tip[i - 1] - path.tip[i - 2]
            if i < 2 or np.isfinite(path.angle[i - 1]) or np.linalg.norm(before) < 1e-9:
                continue
            tangent = np.cross(path.normal[i], path.tip[i - 1] - path.center[i])
            cosines.append(before @ tangent / np.linalg.norm(before) / np.linalg.norm(tangent))
        smooth = np.abs(cosines) > 0.9
        assert smooth.sum() > 3 and np.mean(np.array(cosines)[smooth] > 0.0) >= least, name


def test_the_impellers_axis_looks_outwards():
    story = read_story(shared("corpus/gcode/linuxcnc_impeller-7bl-xyzac.ngc"))
    tip, axis = story.path.tip[ends(story), :2], story.path.axis[ends(story), :2]
    radial = tip / np.linalg.norm(tip, axis=1, keepdims=True).clip(1e-9)
    assert np.mean((radial * axis).sum(axis=1)) > 0.4  # the spec's own figure is +0.46


@pytest.mark.parametrize("name", ["carving/carving.cls", "engraving/engraving.cls", "relief/relief.cls"])
def test_the_samples_read_whole(name):
    story = read_story(ROOT / "toolpaths" / name)
    assert story.complete and story.dialect == "nx-clsf"
    sound(story)


def test_two_tools_keep_their_order():
    for name in ("g3.nc", "t1n.cls", "t1.apt"):
        story = read_story(shared(f"repro/{name}"))
        tools = [e for e in story.events if e.kind == "tool"]
        assert [(e.before, e.value) for e in tools] == [(0, 1), (4, 2)]
        assert (story.path.tip[3] * 1000).tolist() in ([20, 0, 25], [20, 0, 50])  # retracted before the change


def test_repeating_any_point_changes_no_motion(tmp_path):
    """A law: each GOTO of the samples twice (but an arc's, which would be a full circle) is the same story."""
    lines = (ROOT / "toolpaths/engraving/engraving.cls").read_text().splitlines()
    cycle, twice = False, []
    for before, line in zip(["", *lines], lines, strict=False):
        cycle = (line.startswith("CYCLE/") and not line.startswith("CYCLE/OFF")) or (
            cycle and not line.startswith("CYCLE/OFF")
        )
        twice += [line, line] if line.startswith("GOTO") and not cycle and before != "RAPID" else [line]
    assert len(twice) > len(lines) + 20
    (tmp_path / "a.cls").write_text("\n".join(twice))
    one, two = read_story(ROOT / "toolpaths/engraving/engraving.cls"), read_story(tmp_path / "a.cls")
    assert np.array_equal(one.path.tip, two.path.tip) and np.array_equal(one.way, two.way)
    assert [(e.before, e.kind) for e in one.events] == [(e.before, e.kind) for e in two.events]
