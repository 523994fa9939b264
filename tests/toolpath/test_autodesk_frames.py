"""Autodesk's posts for CAMplete, MANUSpost and MfgSuite, whose operations each have a frame: against SciPy's rotations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import PLACE, posted
from scipy.spatial.transform import Rotation

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

TURN = Rotation.from_euler("ZX", [30, 20], degrees=True)
ORIGIN = np.array([4.0, -3.0, 25.0])
TRUEPATH = "MACHIN/\nMODE/MILL\nPARTNO/'1001'\nPPRINT/''\n"
MFGSUITE = "PARTNO/ '1001'\nPPRINT/ ''\nBEGIN\nUNITS/ MM\nMATERL/ TYPE, 5, COND, 6, XDIM, 90, YDIM, 80, ZDIM, 30\n"
TOOL = "CUTTER/10, 0, 0, 0, 0, 0, 60\nLOADTL/1, 0, 60, 1\nSPINDL/RPM,5000,CLW\nCOOLNT/FLOOD\n"
CUT = "RAPID\nGOTO/10, 0, 30\nFEDRAT/600, MMPM\nGOTO/10, 0, 0\n{arc}\nGOTO/0, 10, 0\nRAPID\nGOTO/0, 10, 30\n"
LEFT = "CIRCLE/0, 0, 0, 0, 0, -1, 10, 90, 0.0, 0.0, 0.0"


def printed(values: np.ndarray) -> str:
    return ", ".join(f"{v:.9f}" for v in values)


def mcs(turn: Rotation, origin: np.ndarray) -> str:
    x, y, z = turn.as_matrix().T
    return f"MCS/{printed(x)}, $\n{printed(y)}, $\n{printed(z)}, $\n{printed(origin)}\n"


def mcsys(turn: Rotation, origin: np.ndarray, offset: int = 1) -> str:
    x, y, _ = turn.as_matrix().T
    return f"MCSYS/ NUM, {offset}, POINT, {printed(origin)}, VECTOR, {printed(x)}, VECTOR, {printed(y)}\n"


def truepath(body: str, turn: Rotation = TURN, origin: np.ndarray = ORIGIN) -> str:
    return (
        f"{TRUEPATH}CSI_TOOL_PATH/2D Pocket, 3, 4, 5\nUNITS/MM\nMULTAX/OFF\n{mcs(turn, origin)}{TOOL}{body}END\nFINI\n"
    )


def mfgsuite(body: str, turn: Rotation = TURN, origin: np.ndarray = ORIGIN) -> str:
    head = (
        f"OPNAME/ 'Pocket'\nAPPLY/ MILL\n{mcsys(turn, origin)}CLAMP/ TABLE, ALL, AUTO\nTOOLNO/ 1, MILL, OSETNO, 1, 1\n"
    )
    start = "LOAD/ TOOL, 1, 'flat', NEXTTL, 1\nSPINDL/ RPM, 5000, CLW\nCUTCOM/ ON, LENGTH, 1\n"
    return f"{MFGSUITE}\n{head}{start}{body}\nGOHOME/\nEND/\n"


def read(folder: Path, text: str):
    (folder / "a.apt").write_text(text)
    return read_toolpath(folder / "a.apt", chord_tolerance=1e-7)


def points(folder: Path, text: str, move: Move | None = Move.CUT) -> np.ndarray:
    """Tip, mm, and axis of every point that comes by this move."""
    regions = [r for r in read(folder, text).regions if len(r.move)]
    rows = [
        np.hstack([r.position * 1e3, r.axis])[np.full(len(r.move), True) if move is None else r.move == move]
        for r in regions
    ]
    return np.concatenate(rows)


@pytest.mark.parametrize("write", [truepath, mfgsuite])
def test_points_lie_in_the_operations_frame(tmp_path: Path, write) -> None:
    arc = LEFT if write is truepath else "MOVARC/ CENTER, 0, 0, 0, AXIS, 0, 0, 1, RADIUS, 10"
    found = points(tmp_path, write(CUT.format(arc=arc)))
    local = TURN.inv().apply(found[:, :3] - ORIGIN)
    np.testing.assert_allclose(found[:, 3:], np.tile(TURN.as_matrix()[:, 2], (len(found), 1)), atol=1e-8)
    np.testing.assert_allclose(local[0], [10, 0, 0], atol=1e-6)
    np.testing.assert_allclose(local[-1], [0, 10, 0], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(local[1:], axis=1), 10.0, atol=1e-5)  # the quarter, not the three
    assert local[:, :2].min() > -1e-6


def test_an_operation_without_tilt_follows_one_with_it(tmp_path: Path) -> None:
    """The axis of a tilted GOTO is not taken along, nor is the frame."""
    tilted = "MULTAX/ON\nFEDRAT/600, MMPM\nRAPID\nGOTO/0, 0, 30, 0.6, 0, 0.8\nGOTO/0, 0, 0, 0.6, 0, 0.8\n"
    text = truepath(
        tilted + "MULTAX/OFF\n" + mcs(Rotation.identity(), np.zeros(3)) + "RAPID\nGOTO/1, 2, 30\nGOTO/1, 2, 3\n"
    )
    found = points(tmp_path, text)
    np.testing.assert_allclose(found[-1], [1, 2, 3, 0, 0, 1], atol=1e-9)
    np.testing.assert_allclose(found[0, :3], ORIGIN, atol=1e-6)
    np.testing.assert_allclose(found[0, 3:], TURN.apply([0.6, 0, 0.8]), atol=1e-8)


@pytest.mark.parametrize(
    ("cycle", "top", "bottom", "clear", "out"),
    [
        ("DRILL, FEDTO, 5, MMPM, 300, CLEAR, 15, RTRCTO, 15, RAPTO, 4", 0, -5, 4, 15),
        ("DRILL, FEDTO, 5, MMPM, 300, CLEAR, 18, RTRCTO, 15, RAPTO, 4", 3, -2, 7, 18),
        ("REAM, FEDTO, 5, MMPM, 300, CLEAR, 18, RETURN, 15, RAPTO, 4", 3, -2, 7, 18),  # CLEAR is a height, no distance
        ("BRKCHP, FEDTO, 5, INCR, 9, MMPM, 300, CLEAR, 18", 3, -2, 3, 18),
        ("RIGID, DEPTH, 5, PITCH, 1, CLEAR, 15, RETURN, 15, RAPTO, 4", 0, -5, 4, 15),
    ],
)
def test_heights_of_truepaths_cycles(tmp_path: Path, cycle: str, top, bottom, clear, out) -> None:
    body = f"RAPID\nGOTO/7, 8, 40\nCYCLE/{cycle}\nGOTO/7, 8, {top}\nCYCLE/OFF\n"
    rows = points(tmp_path, truepath(body), None)
    heights = TURN.inv().apply(rows[:, :3] - ORIGIN)[:, 2]
    np.testing.assert_allclose(heights.min(), bottom, atol=1e-6)
    np.testing.assert_allclose(heights[-1], out, atol=1e-6)
    assert np.min(np.abs(heights[: np.argmin(heights)] - clear)) < 1e-6  # where the feed begins


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (truepath(CUT.format(arc=LEFT.replace(" 90,", " 270,"))), "sweep of 270"),
        (truepath(CUT.format(arc="CIRCLE/0, 0, 0, 0, 0, -1, 10")), "sweep"),
        (truepath("ZERO/1\nRAPID\nGOTO/0, 0, 30\nZERO/2\n"), "another work offset"),
        (truepath("MCS2/1, 0, 0, 0, 1, 0, 0, 0, 1\n"), "other axes"),
        (truepath("RAPID\nGOTO/0, 0, 30\n").replace("MCS/", "MCS/0, "), "12"),
        (truepath("CUTCOM/ON\nCUTCOM/LEFT, 1\n"), "cutter radius compensation"),
        (truepath("CSI_INSERT_CUSTOM_GCODE/G0 X0 Y0 Z0\n"), "moves the tool"),
        (truepath("MODE/ TURN\n"), "turning"),
        (truepath("CYCLE/DRILL, FEDTO, 5, MMPM, 300, RAPTO, 4\n"), "height"),
        (mfgsuite("CYCLE/ DRILL, DEPTH, 5, PERMIN, 300, CLEAR, 15, RETURN, 15, RAPTO, 10\n"), "Autodesk"),
        (mfgsuite(mcsys(TURN, ORIGIN, 2)), "another work offset"),
        (mfgsuite("MCSYS/ NUM, 1, POINT, 0, 0, 0, VECTOR, 1, 0, 0\n"), "another form"),
        (mfgsuite("APPLY/ TURN\n"), "turning"),
        (mfgsuite("CUTCOM/ LEFT, XYPLAN, OSETNO, 1\n"), "cutter radius compensation"),
        (
            mfgsuite("RAPID\nGOTO/ 10, 0, 0\nFEDRAT/ PERMIN, 500\nMOVARC/ 0, 0, 0, 0, 0, 1, 10\nGOTO/ 0, 10, 0\n"),
            "form",
        ),
        ("PARTNO/'1'\nPPRINT/'1'\nUNITS/MM\nLOADTL/1, 0, 60.0, 1\nCUTCOM/LEFT, 1\n", "cutter radius compensation"),
    ],
)
def test_what_they_leave_open_is_refused(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(ToolpathError, match=match):
        read(tmp_path, text)


@pytest.mark.parametrize("write", [truepath, mfgsuite])
def test_their_programs_are_verified_whole(tmp_path: Path, write) -> None:
    arc = LEFT if write is truepath else "MOVARC/ CENTER, 0, 0, 0, AXIS, 0, 0, 1, RADIUS, 10"
    body = CUT.format(arc=arc)
    if write is truepath:
        body += (
            "CYCLE/REAM, FEDTO, 5, MMPM, 300, CLEAR, 18, RETURN, 15, RAPTO, 4\nGOTO/7, 8, 3\nGOTO/9, 18, 3\nCYCLE/OFF\n"
        )
    made = posted(tmp_path, "a.apt", write(body), setup=PLACE)
    assert made.summary.witness.complete and not [f for f in made.findings if f.code == "verified-in-part"]
