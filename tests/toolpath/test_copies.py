"""APT's COPY and TRACUT, second vectors of GOTO, and the arcs of Autodesk's APT posts, against places worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

HEAD = "PARTNO A\nUNITS/MM\nLOADTL/1\nSPINDL/2000,RPM,CLW\nFEDRAT/300,MMPM\nRAPID\nGOTO/0,0,20\n"
GROOVE = "RAPID\nGOTO/5,0,5\nGOTO/5,0,-1\nGOTO/10,0,-1\nRAPID\nGOTO/10,0,5\n"
FUSION = "PARTNO/'1001'\nPPRINT/'1001'\nUNITS/MM\nMULTAX/OFF\nLOADTL/1, 0, 60.000000, 1\nSPINDL/5000., RPM, CLW\n"


def read(folder: Path, text: str):
    (folder / "a.apt").write_text(text)
    return read_toolpath(folder / "a.apt", chord_tolerance=1e-7)


def cuts(folder: Path, text: str) -> np.ndarray:
    """Tip, mm, and axis of every cut."""
    path = read(folder, text)
    return np.concatenate(
        [np.hstack([r.position * 1e3, r.axis])[r.move == Move.CUT] for r in path.regions if len(r.move)]
    )


@pytest.mark.parametrize(
    ("copy", "turn", "shift", "count"),
    [
        ("SAME,2", 0.0, (0, 0, 0), 2),
        ("TRANSL,20,3,-1,3", 0.0, (20, 3, -1), 3),
        ("XYROT,60,5", 60.0, (0, 0, 0), 5),
        ("XYROT,-90,1", -90.0, (0, 0, 0), 1),
        ("MODIFY,0,-1,0,7,1,0,0,2,0,0,1,0,2", 90.0, (7, 2, 0), 2),
    ],
)
def test_a_copy_is_transformed_once_more_each_time(tmp_path: Path, copy: str, turn: float, shift, count: int) -> None:
    """APT-IV's CL editor (APT335): m passes beside the first, the matrix multiplied on in each."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    stretch = np.array([[5, 0, -1], [10, 0, -1]], float)
    want = [stretch]
    for _ in range(count):
        want.append(want[-1] @ R.T + shift)
    found = cuts(tmp_path, HEAD + f"INDEX/1\n{GROOVE}COPY/1,{copy}\nRAPID\nGOTO/0,0,20\nGOTO/1,2,3\nFINI\n")
    np.testing.assert_allclose(found[:, :3], [*np.concatenate(want), [1, 2, 3]], atol=1e-9)


def test_arcs_and_axes_turn_with_a_copy(tmp_path: Path) -> None:
    body = "INDEX/3\nRAPID\nGOTO/10,0,0,0.6,0,0.8\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0,0.6,0,0.8\nRAPID\nGOTO/0,10,9\n"
    found = cuts(tmp_path, HEAD + body + "COPY/3,XYROT,90,1\nFINI\n")
    half = len(found) // 2
    np.testing.assert_allclose(found[half:, 0], -found[:half, 1], atol=1e-9)
    np.testing.assert_allclose(found[half:, 3:], [[0.0, 0.6, 0.8]] * half, atol=1e-9)
    np.testing.assert_allclose(found[-1, :3], [-10, 0, 0], atol=1e-9)


def test_tracut_transforms_till_it_is_called_off(tmp_path: Path) -> None:
    body = (
        "TRACUT/0,-1,0,4,1,0,0,5,0,0,1,6\nRAPID\nGOTO/0,0,9\nGOTO/1,2,0\nTRACUT/NOMORE\nRAPID\nGOTO/0,0,9\nGOTO/1,2,0\n"
    )
    found = cuts(tmp_path, HEAD + body + "FINI\n")
    np.testing.assert_allclose(found[:, :3], [[2, 6, 6], [1, 2, 0]], atol=1e-9)


MIRRORS = {"x": (-1, 1, 1), "y": (1, -1, 1), "both": (-1, -1, 1)}


@pytest.mark.parametrize("signs", MIRRORS.values(), ids=MIRRORS)
@pytest.mark.parametrize("word", ["TRACUT", "COPY"])
def test_a_mirror_by_matrix_is_the_mirrored_path(tmp_path: Path, word: str, signs) -> None:
    """APT-IV's CL editor multiplies points by any matrix (APT303), and axes by it (APT304): arcs go the other way round."""
    body = "RAPID\nGOTO/10,0,5,0.6,0,0.8\nGOTO/10,0,0,0.6,0,0.8\n"
    body += "CIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0,0.6,0,0.8\nGOTO/3,12,-1,0,0.28,0.96\n"
    up = "RAPID\nGOTO/3,12,9,0,0.28,0.96\n"
    rows = [[signs[0], 0, 0, 40], [0, signs[1], 0, 7], [0, 0, signs[2], 0]]
    matrix = ",".join(f"{v:g}" for row in rows for v in row)
    text = (
        f"INDEX/1\n{body}{up}COPY/1,MODIFY,{matrix},1\n"
        if word == "COPY"
        else body + up + f"TRACUT/{matrix}\n{body}{up}"
    )
    found = cuts(tmp_path, HEAD + "MULTAX\n" + text + "FINI\n")
    plain, image = np.split(found, 2)
    np.testing.assert_allclose(image[:, :3], plain[:, :3] * signs + [40, 7, 0], atol=1e-9)
    np.testing.assert_allclose(image[:, 3:], plain[:, 3:] * signs, atol=1e-9)
    on_arc = plain[(plain[:, 1] > 1) & (plain[:, 1] < 9)]  # a quarter, the short way: in the first quadrant
    assert len(on_arc) > 20
    np.testing.assert_allclose(np.hypot(on_arc[:, 0], on_arc[:, 1]), 10.0, atol=1e-6)
    assert (on_arc[:, 0] > 0.0).all()


def test_a_mirrored_path_is_said(tmp_path: Path) -> None:
    body = "TRACUT/-1,0,0,0,0,1,0,0,0,0,1,0\nRAPID\nGOTO/1,2,9\nGOTO/1,2,0\n"
    assert "mirrored" in [f.code for f in read(tmp_path, HEAD + body + "FINI\n").findings]


def test_points_tilted_by_a_matrix_keep_the_axis_that_they_print(tmp_path: Path) -> None:
    """Rx(90): z goes to -y, y to z. What prints no axis stays upright in APT, and is refused here."""
    body = "MULTAX\nTRACUT/1,0,0,0,0,0,-1,0,0,1,0,0\nRAPID\nGOTO/1,2,9,0,0,1\nGOTO/1,2,0\nTRACUT/NOMORE\nGOTO/5,5,5,0,0,1\n"
    found = cuts(tmp_path, HEAD + body + "FINI\n")
    np.testing.assert_allclose(found, [[1, 0, 2, 0, -1, 0], [5, 5, 5, 0, 0, 1]], atol=1e-9)


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("COPY/1,SAME,2\n", "without its INDEX"),
        (f"INDEX/1\n{GROOVE}COPY/1,MIRROR,YZPLAN,1\n", "CL editor refuses"),
        (f"INDEX/1\n{GROOVE}COPY/1,TRANSL,1,2,3\n", "is not read"),
        (f"INDEX/1\n{GROOVE}COPY/1,SAME,1.5\n", "1.5 copies"),
        (f"INDEX/1\n{GROOVE}COPY/1,MODIFY,-1,0,0,0,0,1,0,0,0,0,2,0,1\n", "not unit vectors"),
        (f"INDEX/1\n{GROOVE}COPY/1,MODIFY,1,0,0,0,0,0,-1,0,0,1,0,0,1\n", "axis is not stated"),
        ("TRACUT/1,0,0,0,0,1,0,0,0,0,-1,0\nGOTO/1,2,3\n", "axis is not stated"),
        (f"INDEX/1\nTRACUT/1,0,0,1,0,1,0,0,0,0,1,0\n{GROOVE}COPY/1,SAME,1\n", "TRACUT in it"),
        (f"INDEX/1\n{GROOVE}FINI\nCOPY/1,SAME,1\n", "after the program's end"),
        (f"INDEX/1\n{GROOVE}COPY/1,SAME,1\nCOPY/1,TRANSL,0,9,0,1\n", "a second time"),
        ("INDEX/1,NOMORE\n", "another form"),
        ("TRACUT/1,0,0\n", "not 12"),
        ("CUTCOM/NORMDS\n", "compensation in space"),
    ],
)
def test_what_is_no_copy_is_refused(tmp_path: Path, body: str, match: str) -> None:
    with pytest.raises(ToolpathError, match=match):
        read(tmp_path, HEAD + body + "FINI\n")


def test_a_second_vector_of_goto_is_not_used(tmp_path: Path) -> None:
    path = read(tmp_path, HEAD + "MULTAX\nGOTO/1,2,3,0,0.6,0.8,1,0,0\nRAPID\nGOTO/1,2,30\nFINI\n")
    region = path.regions[-1]
    np.testing.assert_allclose(region.axis[region.move == Move.CUT], [[0, 0.6, 0.8]])
    assert "second-vector" in [f.code for f in path.findings]


@pytest.mark.parametrize(
    ("arc", "end", "middle"),
    [
        ("MOVARC/0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 10.0, ANGLE, 90.0", "0., 10., 0.", (1, 1)),
        ("MOVARC/0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 10.0, ANGLE, 90.0", "0., -10., 0.", (1, -1)),
        ("MOVARC/0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 10.0, ANGLE, 180.0", "-10., 0., 0.", (0, -1)),
        ("MOVARC/0, 0, 0, 0, 0, 1, 10, ANGLE, 90", "0, 10, 0", (1, 1)),
        ("MOVARC/0, 0, 0, 0, 0, 1, 10, ANGLE, 90", "0, -10, 0", (1, -1)),  # clockwise, as the old edition has it
        ("MOVARC/0, 0, 0, 0, 0, 1, 10, ANGLE, 270", "0, -10, 0", (-1, 1)),
    ],
)
def test_movarc_goes_the_way_that_its_angle_says(tmp_path: Path, arc: str, end: str, middle) -> None:
    text = FUSION + f"RAPID\nGOTO/10., 0., 9.\nFEDRAT/500., MMPM\nGOTO/10., 0., 0.\n{arc}\nGOTO/{end}\nEND\nFINI\n"
    found = cuts(tmp_path, text)[1:, :2]
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 10.0, atol=1e-6)
    half = found[len(found) // 2 - 1] / 10.0
    np.testing.assert_allclose(half, np.array(middle) / np.linalg.norm(middle), atol=0.02)


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("MOVARC/0, 0, 0, 0, 0, 1, 10, ANGLE, 180\nGOTO/-10, 0, 0\n", "which way round"),
        ("MOVARC/0., 0., 0., 0., 0., 1., 10., ANGLE, 270.\nGOTO/0., 10., 0.\n", "which way round"),
        ("CYCLE/DRILL, 12., MMPM, 200., 15., RAPTO, 3.\nFEDRAT/200., MMPM\nGOTO/0., 0., -12.\nCYCLE/OFF\n", "bottom"),
        ("MODE/TURN\n", "turning"),
    ],
)
def test_what_autodesks_files_leave_open_is_refused(tmp_path: Path, body: str, match: str) -> None:
    with pytest.raises(ToolpathError, match=match):
        read(tmp_path, FUSION + f"RAPID\nGOTO/10., 0., 9.\nFEDRAT/500., MMPM\nGOTO/10., 0., 0.\n{body}END\nFINI\n")
