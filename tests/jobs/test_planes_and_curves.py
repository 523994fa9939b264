"""Programs of tilted planes and of NURBS: verified whole where they are right, and refused with a fault in their text."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from cl_stories import NX
from process_story import KR15, posted
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from camrob.jobs.post import PostResult
from camrob.witness.judge import Verdict, judge

PLACE = "part_in_base = [0, 0, 200, 0, 0, 0]\nchord_tolerance_mm = 0.02\n"
TILTED = (
    "G21 G90 G94 G17\nT1 M6\nS6000 M3\nG0 X0 Y0 Z60\nG1 Z40 F500\nX8\nG0 Z60\nG68.2 X20 Y0 Z30 I90 J20 K0\nG53.1\n"
    "G0 X0 Y0 Z30\nG1 Z0 F300\nX10\nG2 X15 Y5 I0 J5\nG0 Z30\nG81 X0 Y10 Z-3 R2 F100\nG80\nG0 Z40\nG69\nM5\nM30\n"
)
TURN = Rotation.from_euler("ZX", [90, 20], degrees=True)
CONTROL = np.array([[0, 0, 0], [5, 10, 0], [15, 10, -2], [20, 0, -1]], float)
CURVE = (
    NX
    + "SPINDL/RPM,6000,CLW\nRAPID\nGOTO/0,0,30,0,0,1\nFEDRAT/MMPM,450\nGOTO/0,0,0\nNURBS/\nKNOT/0,0,0,0,1,1,1,1\n"
    + "".join(f"CNTRL/{x},{y},{z}\n" for x, y, z in CONTROL.tolist())
    + "RAPID\nGOTO/20,0,30\nSPINDL/OFF\nEND-OF-PATH\n"
)
LIN = re.compile(r"(?<=\{E6POS: )X (\S+?),Y (\S+?),Z (\S+?)(?=,)")


@pytest.fixture(scope="module")
def tilted(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    return posted(tmp_path_factory.mktemp("tilted"), "plane.nc", TILTED, setup=PLACE)


@pytest.fixture(scope="module")
def curve(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    return posted(tmp_path_factory.mktemp("curve"), "curve.cls", CURVE, setup=PLACE)


def again(made: PostResult, folder: Path, change) -> Verdict:
    """The verdict on its program with the text changed; `change` makes another text of the text."""
    program = next(made.out.glob("*.src"))
    text = program.read_text()
    changed = change(text)
    (folder / program.name).write_text(changed)
    (folder / program.with_suffix(".dat").name).write_text(program.with_suffix(".dat").read_text())
    source = next(p for p in (made.out.parent / "in").iterdir() if p.suffix in (".nc", ".cls"))
    return judge(folder / program.name, KR15, clfile=source, setup=source.parent / "setup.toml")


def points(text: str) -> np.ndarray:
    return np.array([[float(v) for v in found.groups()] for found in LIN.finditer(text)])


def moved(text: str, point, by) -> str:
    """The statements that lead to a point (base, mm), moved."""
    near = [m for m in LIN.finditer(text) if np.linalg.norm(np.array(m.groups(), float) - point) < 0.002]
    assert near
    for m in reversed(near):
        x, y, z = np.array(m.groups(), float) + by
        text = f"{text[: m.start()]}X {x:.3f},Y {y:.3f},Z {z:.3f}{text[m.end() :]}"
    return text


def in_plane(*point: float) -> np.ndarray:
    return TURN.apply(point) + np.array([20.0, 0.0, 230.0])


def test_a_tilted_plane_is_verified_whole(tilted: PostResult, tmp_path: Path) -> None:
    verdict = again(tilted, tmp_path, lambda text: text)
    assert verdict.complete and verdict.objections == () and verdict.judged["path"] is True
    ends = points(next(tilted.out.glob("*.src")).read_text())
    for point in ([0, 0, 0], [10, 0, 0], [15, 5, 0], [0, 10, 2], [0, 10, -3]):
        assert np.linalg.norm(ends - in_plane(*point), axis=1).min() < 0.001


@pytest.mark.parametrize("point", [(10, 0, 0), (15, 5, 0), (0, 10, -3)], ids=["cut", "arc's end", "hole's bottom"])
def test_a_point_of_the_plane_0_03_mm_off_is_found(tilted: PostResult, point, tmp_path: Path) -> None:
    for by in (TURN.apply([0.0, 0.0, -0.03]), TURN.apply([0.0, 0.03, 0.0])):
        verdict = again(tilted, tmp_path, lambda text, by=by: moved(text, in_plane(*point), by))
        assert verdict.judged["path"] is False


@pytest.mark.parametrize("fault", ["axis", "lost", "feed", "other way round"])
def test_other_faults_in_the_plane_are_found(tilted: PostResult, fault: str, tmp_path: Path) -> None:
    x, y, z = (f"{v:.3f}" for v in in_plane(10, 0, 0))
    place = rf"LIN \{{E6POS: X {re.escape(x)},Y {re.escape(y)},Z {re.escape(z)},A (\S+?),B (\S+?),C "

    def change(text: str) -> str:
        if fault == "axis":
            changed = re.sub(place, lambda m: m[0].replace(f"B {m[2]}", f"B {float(m[2]) + 0.05:.4f}"), text)
        elif fault == "lost":
            changed = re.sub(place + r".*\n", "", text)
        elif fault == "feed":
            changed = text.replace("$VEL.CP = 0.005000", "$VEL.CP = 0.006000")
        else:  # the arc the short way round, by a straight motion
            changed = re.sub(r"CIRC \{[^}]*\},\{", "LIN {", text)
        assert changed != text
        return changed

    assert again(tilted, tmp_path, change).errors


def test_a_curve_is_verified_whole(curve: PostResult, tmp_path: Path) -> None:
    verdict = again(curve, tmp_path, lambda text: text)
    assert verdict.complete and verdict.objections == () and verdict.judged["path"] is True


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_point_of_the_curve_0_03_mm_off_is_found(curve: PostResult, share: float, tmp_path: Path) -> None:
    wanted = BSpline([0, 0, 0, 0, 1, 1, 1, 1], CONTROL, 3)(share) + np.array([0.0, 0.0, 200.0])
    ends = points(next(curve.out.glob("*.src")).read_text())
    point = ends[np.argmin(np.linalg.norm(ends - wanted, axis=1))]
    for by in ([0.0, 0.0, 0.03], [0.0, 0.0, -0.03]):
        assert again(curve, tmp_path, lambda text, by=by: moved(text, point, by)).judged["path"] is False


COPIED = (
    "PARTNO A\nUNITS/MM\nLOADTL/1\nSPINDL/5000,RPM,CLW\nFEDRAT/300,MMPM\nRAPID\nGOTO/0,0,30\nINDEX/1\nRAPID\nGOTO/25,0,30\n"
    "GOTO/25,0,0\nCIRCLE/15,0,0,0,0,1,10\nGOTO/15,10,0\nRAPID\nGOTO/15,10,30\nCOPY/1,XYROT,120,2\n"
    "TRACUT/0,-1,0,4,1,0,0,5,0,0,1,0\nRAPID\nGOTO/0,0,30\nGOTO/1,2,0,0,0,1,1,0,0\nRAPID\nGOTO/1,2,30\nTRACUT/NOMORE\nFINI\n"
)
AUTODESK = (
    "PARTNO/'1'\nPPRINT/'1'\nUNITS/MM\nMULTAX/OFF\nLOADTL/1, 0, 60.000000, 1\nSPINDL/5000., RPM, CLW\nRAPID\nGOTO/10., 0., 30.\n"
    "FEDRAT/500., MMPM\nGOTO/10., 0., 0.\nMOVARC/0., 0., 0., 0., 0., -1., 10., ANGLE, 180.\nGOTO/-10., 0., 0.\n"
    "RAPID\nGOTO/-10., 0., 30.\nEND\nFINI\n"
)


@pytest.mark.parametrize("text", [COPIED, AUTODESK])
def test_copies_and_autodesks_arcs_are_verified_whole(tmp_path: Path, text: str) -> None:
    made = posted(tmp_path, "a.apt", text, setup=PLACE)
    assert made.summary.witness.complete and not [f for f in made.findings if f.code == "verified-in-part"]
