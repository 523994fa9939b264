"""Statements of Heidenhain's language that post-processors write: circles across the working plane, datum shifts that end within
a plane, blocks behind a slash, probing. Ends are worked out by hand: DR+ turns from Y to Z, and from Z to X (TNC 640, 6.5).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S5000\n2 L Z+50 R0 FMAX M3\n3 L X+0 Y+0 FMAX\n"
END = "L Z+50 FMAX\nM30\nEND PGM A MM\n"


def cuts(folder: Path, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Tips, mm, and lines of all points that are cut."""
    file = folder / "a.h"
    file.write_text(HEAD + body + END, encoding="utf-8")
    found = [(r.position[r.move == Move.CUT] * 1e3, r.line[r.move == Move.CUT]) for r in read_toolpath(file).regions]
    return np.concatenate([tips for tips, _ in found]), np.concatenate([lines for _, lines in found])


@pytest.mark.parametrize(
    ("start", "circle", "center", "middle", "end"),
    [
        ("L Y-10 Z+0", "CC Y+0 Z+0\nCP IPA+90 DR+", (0, 0, 0), (0, -1, -1), (0, 0, -10)),
        ("L Y-10 Z+0", "CC Y+0 Z+0\nCP IPA-90 DR-", (0, 0, 0), (0, -1, 1), (0, 0, 10)),
        ("L X+10 Z+0", "CC X+0 Z+0\nCP IPA+90 DR+", (0, 0, 0), (1, 0, -1), (0, 0, -10)),
        ("L X+0 Z+10", "CC Z+0 X+0\nCP IPA+90 DR+", (0, 0, 0), (1, 0, 1), (10, 0, 0)),
        ("L X+0 Z+10", "CC Z+0 X+0\nC X-10 Z+0 DR-", (0, 0, 0), (-1, 0, 1), (-10, 0, 0)),
        ("L Y+0 Z+10", "CC Y+0 Z+0\nCP PA+180 DR+", (0, 0, 0), (0, -1, 1), (0, -10, 0)),
        ("L X+0 Y+10 Z+0", "CC Y+0 Z+5\nCC X+0 Y+0\nCP IPA+90 DR+", (0, 0, 0), (-1, 1, 0), (-10, 0, 0)),
        ("L Y+0 Z+0", "CC Y+3 Z+4\nCC Z+0\nCP IPA+180 DR+", (0, 3, 0), (0, 0, -1), (0, 6, 0)),
    ],
)
def test_circles_run_in_the_plane_that_their_centre_names(
    tmp_path: Path,
    start: str,
    circle: str,
    center: tuple[float, ...],
    middle: tuple[float, ...],
    end: tuple[float, ...],
) -> None:
    tips, lines = cuts(tmp_path, f"{start} F500\n{circle}\nL X+99\n")
    round_ = tips[lines == lines[-1] - 1]
    arms = np.vstack([tips[lines == 5][-1:], round_]) - center
    radius = np.linalg.norm(arms[0])
    np.testing.assert_allclose(round_[-1], end, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(arms, axis=1), radius, atol=1e-9)
    way = np.asarray(middle) / np.linalg.norm(middle)
    assert (arms @ way).max() > radius * np.cos(np.radians(3.0)), "by the middle that is meant"


@pytest.mark.parametrize("centre", ["CC A+3", "CC X+0 Y+0 Z+0", "CC Y+3 Z+4\nCC X+3"])
def test_centres_of_no_plane(tmp_path: Path, centre: str) -> None:
    with pytest.raises(ToolpathError, match=r"centre \(CC\)"):
        cuts(tmp_path, f"L Z+0 F500\n{centre}\nCP IPA+90 DR+\n")


PLANE = (
    "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Z-5\nPLANE SPATIAL SPA+90 SPB+0 SPC+0 TURN FMAX\n"
    "L X+1 Y+2 Z+30 FMAX\nL Z+3 F500\nL Z+30 FMAX\n"
)
ENDED = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X0\nCYCL DEF 7.2 Y0\nCYCL DEF 7.3 Z0\n"


def test_a_datum_shift_that_ends_before_its_plane(tmp_path: Path) -> None:
    """Nothing moves between the two ends, so that which of them is first doesn't matter: behind both, X is the part's again.

    In the plane Y points up and Z to -Y: (10, 0, -5) and 1 along X, 2 along its Y, 3 along its Z.
    """
    tips, _ = cuts(tmp_path, f"{PLANE}{ENDED}PLANE RESET TURN FMAX\nL X+1 Y+2 Z+30 FMAX\nL Z+3 F500\n")
    np.testing.assert_allclose(tips, [[11, -3, -3], [1, 2, 3]], atol=1e-9)


@pytest.mark.parametrize("motion", ["L X+4 FMAX", "L Z+3 F500", "CC X+0 Y+0\nCP IPA+9 DR+"])
def test_a_motion_between_the_two_ends_is_refused(tmp_path: Path, motion: str) -> None:
    with pytest.raises(ToolpathError, match="datum shift has ended") as caught:
        cuts(tmp_path, f"{PLANE}{ENDED}{motion}\nPLANE RESET TURN FMAX\nL Z+3 F500\n")
    assert "PLANE RESET" in str(caught.value.hint)


def test_another_shift_in_a_plane_stays_refused(tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match="datum shift in a tilted plane"):
        cuts(tmp_path, PLANE + "CYCL DEF 7.1 X+3\nL Z+3 F500\n")


@pytest.mark.parametrize("slash", ["/6 L X+20", "/ 6 L X+20", "6 / L X+20", "/L X+20"])
def test_blocks_behind_a_slash_are_taken_as_switched_on(tmp_path: Path, slash: str) -> None:
    tips, _ = cuts(tmp_path, f"5 L Z+0 F500\n{slash}\n")
    np.testing.assert_allclose(tips, [[0, 0, 0], [20, 0, 0]], atol=1e-9)


def test_probing_is_refused_for_what_it_is(tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match="touch probe") as caught:
        cuts(tmp_path, "TCH PROBE 412 DATUM INSIDE CIRCLE ~\n Q321=+0 ;CENTER ~\n Q262=+40\nL Z+0 F500\n")
    assert caught.value.line == 5
