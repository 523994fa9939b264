"""The second opinion as a whole, on the sample programs; and the manifest."""

from __future__ import annotations

import gzip
import re
import shutil
from pathlib import Path

import pytest

from camrob.witness.judge import Verdict, judge
from camrob.witness.manifest import check_manifest, make_manifest

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
SAMPLES = ("engraving", "carving", "relief", "globe")


def golden(name: str, folder: Path) -> Path:
    """A sample's program, unpacked."""
    for path in (ROOT / "toolpaths" / name / "golden").iterdir():
        if path.name.endswith(".gz"):
            (folder / path.stem).write_bytes(gzip.decompress(path.read_bytes()))
        elif path.suffix in (".src", ".dat"):
            shutil.copy(path, folder)
    return folder / f"{name}.src"


def judged(program: Path, name: str, **options) -> Verdict:
    sample = ROOT / "toolpaths" / name
    return judge(program, CELL, clfile=sample / f"{name}.cls", setup=sample / "setup.toml", **options)


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_are_right_and_judged_completely(name: str, tmp_path: Path) -> None:
    verdict = judged(golden(name, tmp_path), name)
    assert verdict.objections == () and verdict.unjudged == () and verdict.complete
    assert verdict.judged == {"path": True, "frames": True, "process": True, "limits": True}
    assert verdict.judged_points > 100 and verdict.judged_events == verdict.process["events_in_file"]


def test_the_set_up_beside_the_cl_file_is_the_one_where_none_is_named(tmp_path: Path) -> None:
    """The witness looks for it itself: one that its caller has overlooked would place the part elsewhere."""
    program = golden("engraving", tmp_path)
    (tmp_path / "job").mkdir()
    sample = ROOT / "toolpaths" / "engraving"
    for file in (sample / "engraving.cls", sample / "setup.toml", *sample.glob("*.stl")):
        shutil.copy(file, tmp_path / "job")
    found = judge(program, CELL, clfile=tmp_path / "job" / "engraving.cls")
    assert found.objections == () and found.complete
    (tmp_path / "job" / "setup.toml").unlink()
    assert "path" in {
        area for area, ok in judge(program, CELL, clfile=tmp_path / "job" / "engraving.cls").judged.items() if not ok
    }


# what is done to the engraving's text, and the area that it is judged in
FAULTS = {
    "a point 0.02 mm off": (r"Z 214\.000", "Z 213.980", "path"),
    "a point lost": (r"LIN \{E6POS: X 108\.000,Y -43\.000,Z 214\.000.*\n", "", "path"),
    "the axis tilted": (r"(Z 214\.000,A \S+?,)B 0\.0000", r"\1B 0.0200", "path"),
    "faster": (r"\$VEL\.CP = 0\.025000", "$VEL.CP = 0.026000", "process"),
    "spindle slower": (r"\$ANOUT\[1\] = 18000", "$ANOUT[1] = 17000", "process"),
    "spindle never on": (r"\$OUT\[1\] = TRUE", "$OUT[1] = FALSE", "process"),
    "spindle left on": (r"\n\$OUT\[1\] = FALSE ;spindle off.*", "", "process"),
    "another tool's frame": (r"Z 415\.57793", "Z 415.59793", "frames"),
    "a base that is turned": (r"C 0\.00000\}\)", "C 0.02000})", None),
    "a speed of none": (r"\$VEL\.CP = 0\.025000", "$VEL.CP = 0", "process"),
    "another world": (r"(\$BASE *=)", r"$WORLD = {X 1,Y 0,Z 0,A 0,B 0,C 0}\n\1", "frames"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_in_the_text_are_found(fault: str, tmp_path: Path) -> None:
    old, new, area = FAULTS[fault]
    program = golden("engraving", tmp_path)
    text = program.read_text()
    changed = re.sub(old, new, text, count=1)
    assert changed != text
    program.write_text(changed)
    verdict = judged(program, "engraving")
    assert verdict.errors and False in verdict.judged.values()
    assert area is None or verdict.judged[area] is False
    assert area in (None, "path") or verdict.judged["limits"] is not False  # nothing of this is beyond an axis's limit


def test_a_program_alone_is_judged_for_frames_and_limits(tmp_path: Path) -> None:
    program = golden("engraving", tmp_path)
    verdict = judge(program, CELL)
    assert verdict.objections == () and verdict.complete and verdict.judged_points == 0
    assert verdict.judged == {"path": None, "frames": True, "process": None, "limits": True}


def test_what_is_not_understood_makes_a_verdict_incomplete(tmp_path: Path) -> None:
    program = golden("engraving", tmp_path)
    program.write_text(program.read_text().replace(";FOLD ENGRAVE", "STRANGE_WORD(1)\n;FOLD ENGRAVE"))
    verdict = judged(program, "engraving")
    assert not verdict.complete and verdict.judged["path"] is None
    assert "STRANGE_WORD" in "".join(verdict.unjudged)


def test_slower_cuts_need_a_reason(tmp_path: Path) -> None:
    program = golden("engraving", tmp_path)
    program.write_text(program.read_text().replace("$VEL.CP = 0.025000", "$VEL.CP = 0.020000"))
    assert [o.code for o in judged(program, "engraving").objections] == ["feed-lower"]
    assert judged(program, "engraving", slower_allowed="--feed optimal").objections == ()


# --- the manifest -----------------------------------------------------------------------------------------------------


def job(folder: Path) -> dict:
    """A job's files: CL file, set-up with a mesh, cell, program."""
    (folder / "cell").mkdir()
    for name in ("cell/cell.toml", "cell/poses.csv", "part.cls", "part.stl", "part.src", "part.dat"):
        (folder / name).write_text(name)
    (folder / "setup.toml").write_text('[part]\nmesh = "part.stl"\n')
    return {
        "program": [folder / "part.src", folder / "part.dat"],
        "cell": folder / "cell",
        "clfile": folder / "part.cls",
        "setup": folder / "setup.toml",
    }


def test_a_manifest_names_every_file_and_nothing_differs(tmp_path: Path) -> None:
    files = job(tmp_path)
    manifest = make_manifest(**files)
    assert manifest["cl_file"] == {
        "part.cls": "5a81027ff943a0e974a0780ee950bbe14bf2aed17980f3ebca29da6a1ceca579"
    }  # sha256sum says the same
    assert set(manifest["setup"]) == {"setup.toml", "part.stl"} and set(manifest["cell"]) == {"cell.toml", "poses.csv"}
    assert set(manifest["program"]) == {"part.src", "part.dat"} and manifest["camrob"]
    assert check_manifest(manifest, **files) == []


@pytest.mark.parametrize(
    "name", ["part.cls", "setup.toml", "part.stl", "cell/cell.toml", "cell/poses.csv", "part.src", "part.dat"]
)
def test_a_file_that_differs_or_is_gone_is_named(name: str, tmp_path: Path) -> None:
    files = job(tmp_path)
    manifest = make_manifest(**files)
    with (tmp_path / name).open("a") as file:
        file.write("\n")
    found = check_manifest(manifest, **files)
    assert [o.code for o in found] == ["manifest-differs"] and Path(name).name in found[0].text
    (tmp_path / name).unlink()
    assert {o.code for o in check_manifest(manifest, **files)} <= {"manifest-differs", "manifest-missing"}
    assert check_manifest(manifest, **files)


def test_further_files_other_versions_and_broken_manifests(tmp_path: Path) -> None:
    files = job(tmp_path)
    manifest = make_manifest(**files)
    (tmp_path / "cell" / "weights.fis").write_text("")
    assert [o.code for o in check_manifest(manifest, **files)] == ["manifest-further"]
    (tmp_path / "cell" / "weights.fis").unlink()
    assert [(o.code, o.severity) for o in check_manifest({**manifest, "camrob": "0.0"}, **files)] == [
        ("manifest-version", "warning")
    ]
    assert [o.code for o in check_manifest({**manifest, "cell": None}, **files)] == ["manifest-broken"]
    assert {o.code for o in check_manifest({}, **files)} == {"manifest-broken", "manifest-version"}


def test_files_that_are_not_at_hand_are_not_compared(tmp_path: Path) -> None:
    """`verify` without the CL file still holds program and cell to the manifest."""
    files = job(tmp_path)
    manifest = make_manifest(**files)
    assert check_manifest(manifest, files["program"], files["cell"]) == []
    assert [o.code for o in check_manifest(manifest, files["program"][:1], files["cell"])] == ["manifest-missing"]


def test_without_the_cl_file_loads_are_held_to_the_set_up_and_nothing_else_waits_for_them(tmp_path: Path) -> None:
    """The set-up was left aside there, and a `$LOAD` turned limits and frames to "not judged" although it moves neither."""
    program = golden("engraving", tmp_path)
    text = program.read_text()
    load = "$LOAD = {M 30.000,CM {X 20.000,Y 0.000,Z 150.000,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}\n"
    at = text.index("\n", text.index("$TOOL = ")) + 1
    program.write_text(text[:at] + load + text[at:])
    setup = tmp_path / "job.toml"

    def alone(masses: str) -> Verdict:
        setup.write_text(f"part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\n{masses}\n")
        return judge(program, CELL, setup=setup)

    nobody = judge(program, CELL)
    assert nobody.judged == {"path": None, "frames": True, "process": None, "limits": True}
    assert "isn't judged without a set-up" in " ".join(nobody.unjudged)
    right = alone("mass_kg = 30\ncenter_of_mass_mm = [20, 0, 150]")
    assert right.objections == () and right.unjudged == () and right.complete
    wrong = alone("mass_kg = 12\ncenter_of_mass_mm = [20, 0, 150]")
    assert [o.code for o in wrong.errors] == ["load-differs"] and wrong.judged["process"] is False
    other = alone("mass_kg = 30\ncenter_of_mass_mm = [20, 0, 150]\nflange_to_tool = [0, 0, 100, 0, 0, 0]")
    assert "is no tool's of the set-up" in " ".join(other.unjudged) and other.judged["limits"] is None
    program.write_text(text)
    assert [o.code for o in alone("mass_kg = 30\ncenter_of_mass_mm = [20, 0, 150]").errors] == ["load-differs"]
