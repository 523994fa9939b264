"""A point that repeats the one before it is no motion: a law for every file, wherever feed, kind of move or frame changes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from process_story import KR15, ROOT, posted, story, text_of

from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs

MOTION = re.compile(r"^(PTP|LIN|CIRC|\$VEL)")

# operations that share their retract points, with everything between them that may happen between two motions
RICH = """PARTNO X
UNIT/MM
CUTTER/8.,0,4.,0,0,0,64.
LOAD/TOOL,17
SPINDL/4208,RPM,CLW
TRNTYP/WORLD,0,0,0
CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0
RAPID/
GOTO/0,0,25.
FEDRAT/288.,MMPM
GOTO/0,0,-2.
DELAY/1
FEDRAT/600.,MMPM
GOTO/20.,0,-2.
COOLNT/ON
GOTO/20.,10.,-2.
RAPID/
GOTO/20.,10.,25.
SPINDL/5000,RPM,CLW
TRNTYP/WORLD,0,0,0
CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0
RAPID/
GOTO/5.,10.,25.
FEDRAT/288.,MMPM
GOTO/5.,10.,-3.
COOLNT/OFF
FEDRAT/144.,MMPM
GOTO/0,10.,-3.
STOP
RAPID/
GOTO/0,10.,25.
FINI
"""
GOTO = re.compile(r"(?m)^(?:RAPID/?\n)?GOTO/.*\n")


def motions(text: str) -> list[str]:
    return [line for line in text.splitlines() if MOTION.match(line)]


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> str:
    return text_of(posted(tmp_path_factory.mktemp("rich"), "part.apt", RICH))


POINTS = len(GOTO.findall(RICH))
WAYS = ("as it is", "behind what follows it", "twice")


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("which", range(POINTS))
def test_repeating_a_point_changes_no_motion(tmp_path: Path, rich: str, which: int, way: str) -> None:
    """Right behind itself, with its RAPID or without; or behind the events and changes that follow it."""
    match = list(GOTO.finditer(RICH))[which]
    again = match[0] * (2 if way == "twice" else 1)
    at = match.end()
    if way == "behind what follows it":
        again = again.replace("RAPID/\n", "") if "RAPID" not in match[0] else again
        later = list(GOTO.finditer(RICH))[which + 1 : which + 2]
        at = later[0].start() if later else RICH.index("FINI")
    made = posted(tmp_path, "part.apt", RICH[:at] + again + RICH[at:])
    text = text_of(made)
    assert motions(text) == motions(rich)
    assert [s for s in story(text) if s[0].isalpha()] == [s for s in story(rich) if s[0].isalpha()]


def test_what_happens_at_a_repeated_point_happens_there(tmp_path: Path) -> None:
    """The file says: go there, start the coolant, be there, wait, be there, go on."""
    at = RICH.index("GOTO/20.,0,-2.\n")
    line = "GOTO/20.,0,-2.\n"
    content = RICH[:at] + line + "DELAY/2\n" + line + "STOP\n" + line + RICH[at + len(line) :]
    lines = story(text_of(posted(tmp_path, "part.apt", content)))
    assert lines[lines.index("20 -2") :][:5] == ["20 -2", "wait 2", "stop", "wet", "20 -2"]


def test_two_operations_that_share_a_retract_point(tmp_path: Path) -> None:
    content = RICH.replace("GOTO/5.,10.,25.", "GOTO/20.,10.,25.").replace("GOTO/5.,10.,-3.", "GOTO/20.,10.,-3.")
    made = posted(tmp_path, "part.apt", content)
    lines = story(text_of(made))
    assert lines[lines.index("wet") :][1:6] == ["20 -2", "20 25", "speed 5000", "on", "20 -3"]
    assert [r.points for r in made.summary.regions] == [5, 4]


def test_a_region_of_repeated_points_alone(tmp_path: Path) -> None:
    """An operation that never leaves the place where the one before it ended: nothing moves, and its spindle starts."""
    content = RICH.replace(
        "STOP\nRAPID/\nGOTO/0,10.,25.\n", "RAPID/\nGOTO/0,10.,25.\nLOAD/TOOL,17\nSPINDL/6000,RPM,CLW\nGOTO/0,10.,25.\n"
    )
    made = posted(tmp_path, "part.apt", content)
    assert [r.points for r in made.summary.regions] == [5, 4, 1]
    assert story(text_of(made))[-7:] == ["0 25", "speed 6000", "on", "0 75", "home", "off", "dry"]


def _repeated(text: str, rng: np.random.Generator, share: float) -> str:
    """A CLSF with some of its points repeated: those of a drilling cycle are holes, and are left alone."""
    out: list[str] = []
    rapid, cycle, stated = False, False, False
    for line in text.splitlines(keepends=True):
        out.append(line)
        if line.startswith("CYCLE"):
            cycle = not line.startswith("CYCLE/OFF")
        stated = stated or line.startswith("FEDRAT") or ",MMPM" in line
        if line.startswith("GOTO") and not cycle and rng.random() < share:
            out += ["RAPID\n", line] if rapid and (not stated or rng.random() < 0.5) else [line]
        rapid = line.startswith("RAPID")
    return "".join(out)


@pytest.mark.parametrize("share", [1.0, 0.2])
@pytest.mark.parametrize("name", ["engraving", "carving", "relief", "globe"])
def test_the_samples_paths_do_not_change(tmp_path: Path, name: str, share: float) -> None:
    folder = ROOT / "toolpaths" / name
    content = (folder / f"{name}.cls").read_text()
    for file in folder.iterdir():
        if file.is_file() and file.suffix in (".toml", ".stl"):
            (tmp_path / file.name).write_bytes(file.read_bytes())
    clfile = tmp_path / f"{name}.cls"
    clfile.write_text(_repeated(content, np.random.default_rng(7), share))
    assert clfile.read_text() != content
    before, after = (
        read_inputs(folder / f"{name}.cls", cell_for("post", KR15), None),
        read_inputs(clfile, cell_for("post", KR15), None),
    )
    assert after.toolpath.points > before.toolpath.points
    for column in ("base_T_tip", "move", "feed", "region", "safe", "stretch"):
        np.testing.assert_array_equal(getattr(after.path, column), getattr(before.path, column), err_msg=column)


def test_a_sample_with_every_point_repeated_is_the_same_program(tmp_path: Path) -> None:
    folder = ROOT / "toolpaths" / "engraving"
    content = (folder / "engraving.cls").read_text()
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "stock.stl").write_bytes((folder / "stock.stl").read_bytes())
    content = _repeated(content, np.random.default_rng(7), 1.0)
    made = posted(tmp_path, "engraving.cls", content, setup=(folder / "setup.toml").read_text())
    golden = (folder / "golden" / "engraving.src").read_text().splitlines()
    differ = [(a, b) for a, b in zip(text_of(made).splitlines(), golden, strict=True) if a != b]
    assert all(a.startswith("; ") for a, _ in differ) and len(differ) <= 2  # the file's hash, and the count of points
