"""The post script for FreeCAD: its CL data against the path that was asked for, by itself and in the real FreeCAD."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move
from camrob.witness.cl import read_story

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "freecad" / "camrob_post.py"
FREECAD = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
F = 500.0 / 60.0  # mm/s, as FreeCAD has feeds


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("camrob_post", SCRIPT)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def operation(label: str, *commands: tuple) -> SimpleNamespace:
    made = [SimpleNamespace(Name=name, Parameters=words) for name, words in commands]
    return SimpleNamespace(Label=label, Path=SimpleNamespace(Commands=made))


TOOL = operation("TC: 5 mm", ("M6", {"T": 3.0}), ("M3", {"S": 4000.0}))
UP = ("G0", {"Z": 20.0})


def read(folder: Path, *objects: SimpleNamespace):
    file = folder / "part.apt"
    script().export(list(objects), str(file))
    path, story = read_toolpath(file, chord_tolerance=1e-7), read_story(file)
    odd = [finding.code for finding in path.findings if finding.code != "arc-turns-back"]  # as an arc of this path does
    assert not story.gaps and path.dialect == "freecad-apt" and not odd
    return path, story


def test_lines_arcs_and_process_of_a_job(tmp_path: Path) -> None:
    mill = operation(
        "Profile $(x)",
        ("(a remark)", {}),
        ("M8", {}),
        UP,
        ("G0", {"X": 10.0, "Y": 0.0}),
        ("G1", {"Z": -1.0, "F": F}),
        ("G2", {"X": 0.0, "Y": -10.0, "I": -10.0, "J": 0.0, "F": 2 * F}),
        ("G03", {"X": -10.0, "Y": 0.0, "I": 0.0, "J": 10.0, "Z": -2.0}),
        UP,
        ("M9", {}),
    )
    path, _ = read(tmp_path, TOOL, mill)
    (region,) = path.regions
    cut = region.move == Move.CUT
    points = region.position[cut] * 1e3
    assert region.tool == 3 and region.axis.tolist() == [[0, 0, 1]] * len(region)
    np.testing.assert_allclose(points[[0, -1]], [[10, 0, -1], [-10, 0, -2]], atol=1e-9)
    first = points[np.isclose(points[:, 2], -1)]
    np.testing.assert_allclose(np.linalg.norm(first[:, :2], axis=1), 10, atol=1e-6)
    assert first[:, 1].max() < 1e-9  # clockwise: below
    second = points[len(first) :]
    np.testing.assert_allclose(np.linalg.norm(second[:, :2], axis=1), 10, atol=1e-6)
    assert region.feed[cut][0] * 6e4 == pytest.approx(500) and region.feed[cut][-1] * 6e4 == pytest.approx(1000)
    kinds = [e.kind for e in region.events if e.kind is not EventKind.MESSAGE]
    assert kinds == [
        EventKind.TOOL_CHANGE,
        EventKind.SPINDLE_ON,
        EventKind.COOLANT_ON,
        EventKind.COOLANT_OFF,
        EventKind.SPINDLE_OFF,
    ]


def test_holes_are_written_out_and_axes_are_those_of_iso_841(tmp_path: Path) -> None:
    holes = operation(
        "Drilling",
        UP,
        ("G0", {"X": 0.0, "Y": 0.0}),
        ("G98", {}),
        ("G83", {"X": 5.0, "Y": 6.0, "Z": -5.0, "R": 2.0, "Q": 4.0, "F": F}),
        ("G80", {}),
    )
    path, story = read(tmp_path, TOOL, holes)
    (region,) = path.regions
    np.testing.assert_allclose(region.position[region.move == Move.CUT][:, 2] * 1e3, [-2, -5])
    assert region.position[-1].tolist() == [0.005, 0.006, 0.02] and len(story) == len(region)
    turned = operation("Tilted", UP, ("G0", {"X": 0.0, "Y": 0.0, "B": 30.0, "C": 90.0}), ("G1", {"Z": 0.0, "F": F}), UP)
    path, _ = read(tmp_path, TOOL, turned)
    np.testing.assert_allclose(path.regions[-1].axis[-1], [0, 0.5, np.sqrt(0.75)], atol=1e-9)


@pytest.mark.parametrize(
    "command",
    [
        ("G41", {}),
        ("G20", {}),
        ("G91", {}),
        ("G84", {"Z": -1.0}),
        ("G38.2", {"Z": 0.0}),
        ("G18", {}),
        ("G1", {"X": 1.0}),
        ("G2", {"X": 1.0, "R": 5.0}),
        ("M3", {"S": 0.0}),
        ("G59", {}),
    ],
)
def test_what_has_no_meaning_writes_no_file(tmp_path: Path, command: tuple) -> None:
    file = tmp_path / "a.apt"
    with pytest.raises(ValueError, match=r"CL data|cut|speed|arc|feed|G84"):
        script().export([operation("Odd", UP, ("G0", {"X": 0.0, "Y": 0.0}), command)], str(file))
    assert not file.exists()


IN_FREECAD = """
import sys
import FreeCAD, Part, Path
sys.path.insert(0, {folder!r})
import camrob_post
doc = FreeCAD.newDocument("part")
wire = Part.Wire([Part.makeLine((0, 0, 0), (30, 0, 0)), Part.makeLine((30, 0, 0), (30, 20, 0)),
                  Part.makeCircle(10, FreeCAD.Vector(20, 20, 0), FreeCAD.Vector(0, 0, 1), 0, 90)])
op = doc.addObject("Path::Feature", "Contour")
path = Path.fromShapes([wire], feedrate=8.0, feedrate_v=5.0, retraction=25.0, resume_height=25.0)
lead = [Path.Command("M6", {{"T": 1}}), Path.Command("M3", {{"S": 4000}}), Path.Command("G0", {{"X": 0, "Y": 0, "Z": 25}})]
op.Path = Path.Path(lead + list(path.Commands) + [Path.Command("G0", {{"Z": 25}})])
camrob_post.export([op], {out!r}, "")
print("WRITTEN")
"""


@pytest.mark.slow
@pytest.mark.skipif(FREECAD is None, reason="FreeCAD is not installed")
def test_in_the_real_freecad(tmp_path: Path) -> None:
    """A contour of two lines and a quarter circle that FreeCAD itself makes a path of."""
    out = tmp_path / "part.apt"
    macro = tmp_path / "run.py"
    macro.write_text(IN_FREECAD.format(folder=str(SCRIPT.parent), out=str(out)))
    ran = subprocess.run(
        [str(FREECAD), str(macro)], capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL
    )
    assert "WRITTEN" in ran.stdout, ran.stdout[-2000:] + ran.stderr[-2000:]
    path = read_toolpath(out, chord_tolerance=1e-6)
    cut = np.concatenate([r.position[r.move == Move.CUT] for r in path.regions]) * 1e3
    assert path.dialect == "freecad-apt" and len(cut) > 20
    on_lines = (np.abs(cut[:, 1]) < 1e-4) | ((np.abs(cut[:, 0] - 30) < 1e-4) & (cut[:, 1] < 20 + 1e-4))
    on_arc = np.abs(np.hypot(cut[:, 0] - 20, cut[:, 1] - 20) - 10) < 1e-3
    assert (on_lines | on_arc).all() and on_arc.sum() > 10
