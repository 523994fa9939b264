"""Drilling cycles of every dialect, move by move, and the verb that reads a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.apt.cycles import peck_depths
from camrob.toolpath.apt.read_apt import read_cl
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.toolpath import Toolpath

R, C = 0, 1  # rapid, cut


def heights(t: Toolpath) -> list[tuple[int, float]]:
    return [(int(m), round(float(p[2]) * 1000, 6)) for r in t.regions for m, p in zip(r.move, r.position, strict=True)]


def read(dialect: str, text: str) -> Toolpath:
    if dialect == "nx-clsf":
        text = "TOOL PATH/A,TOOL,T\n" + text + "END-OF-PATH\n"
    return read_cl(Path("holes.apt"), ("UNITS/MM\nSPINDL/RPM,500,CLW\n" + text + "FINI\n").encode(), dialect=dialect)


@pytest.mark.parametrize(
    ("dialect", "cycle"),
    [
        ("nx-clsf", "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,250.,RTRCTO,10."),
        ("creo-ncl", "CYCLE / DRILL, DEPTH, 20., MMPM, 250., CLEAR,$\n 3.0, RETURN, 10."),
        ("camworks-apt", "CYCLE/INIT\nCYCLE/DRILL,FEDTO,20.,MMPM,250.,RAPTO,3.,RTRCTO,10.,DWELL,0"),
        ("camworks-clt", "CYCLE/ ON \nCYCLE/ DRILL,G98,20.0,MMPM,250.0,3.0,10.0 10.0 DWELL,0.0 "),
    ],
)
def test_a_drilled_hole(dialect: str, cycle: str) -> None:
    t = read(dialect, f"RAPID\nGOTO/0,0,30\n{cycle}\nGOTO/5,0,1\nGOTO/9,0,1\nCYCLE/OFF\nRAPID\nGOTO/9,0,30\n")
    assert heights(t) == [
        (R, 30),
        (R, 30),
        (R, 11),
        (R, 4),
        (C, -19),
        (R, 11),
        (R, 11),
        (R, 4),
        (C, -19),
        (R, 11),
        (R, 30),
    ]
    feed = t.regions[0].feed[t.regions[0].move == C] * 60_000
    np.testing.assert_allclose(feed, 250.0)


def test_deep_holes_peck_by_peck() -> None:
    t = read(
        "camworks-apt",
        "GOTO/0,0,30\n".replace("GOTO", "RAPID\nGOTO")
        + "CYCLE/DEEP2,FEDTO,12.5,1STPECK,5.,SUBPECK,2.,MMPM,100.,RAPTO,3.,RTRCTO,25.\nGOTO/0,0,0\nCYCLE/OFF\n",
    )
    cuts = [z for m, z in heights(t) if m == C]
    assert cuts == [-5, -7, -9, -11, -12.5]
    assert [z for m, z in heights(t) if m == R][-3:] == [3.0, -10.5, 25.0]
    t = read(
        "creo-ncl",
        "RAPID\nGOTO/0,0,2\nCYCLE / DEEP, DEPTH, 3.5, STEP, 1.0, MMPM, 50., CLEAR, 1.0\nGOTO/0,0,0.5\nCYCLE / OFF\n",
    )
    assert [z for m, z in heights(t) if m == C] == [-0.5, -1.5, -2.5, -3.0]
    t = read(
        "camworks-clt",
        "RAPID\nGOTO/0,0,30\nCYCLE/ DRILL,G98,12.0,PECKING,5.0,2.0,MMPM,187.0,3.0,46.9 46.9 DWELL,0.5 \n"
        "GOTO/0,0,-20\nCYCLE/ OFF\n",
    )
    assert [z for m, z in heights(t) if m == C] == [-25, -27, -29, -31, -32]
    assert heights(t)[-1] == (R, 26.9)
    assert sum(e.kind == "dwell" for e in t.regions[0].events) == 1  # the bottom's, as in G83 with P
    t = read(
        "nx-clsf", "RAPID\nGOTO/0,0,30\nCYCLE/DRILL,DEEP,RAPTO,3.,FEDTO,-6.,STEP,4.,MMPM,9.\nGOTO/0,0,0\nCYCLE/OFF\n"
    )
    assert [z for m, z in heights(t) if m == C] == [-4, -6]


@pytest.mark.parametrize(
    ("dialect", "cycle", "reached"),
    [
        ("nx-clsf", "CYCLE/DRILL,RAPTO,3.,FEDTO,-6.,STEP,4.,MMPM,9.", [-4, -6]),
        ("nx-clsf", "CYCLE/DRILL,RAPTO,3.,FEDTO,-6.,STEP1,4.,STEP2,2.,MMPM,9.", [-2, -4, -6]),
        ("nx-clsf", "CYCLE/DRILL,RAPTO,3.,FEDTO,-6.,STEP,0.,MMPM,9.", [-6]),
        ("creo-ncl", "CYCLE/DRILL,DEPTH,3.5,STEP,1.0,MMPM,50.,CLEAR,1.0", [-1, -2, -3, -3.5]),
        ("catia-apt", "CYCLE/DRILL,6.,100.,MMPM,2.,INCR,2.5", [-2.5, -5, -6]),
        ("camworks-apt", "CYCLE/DRILL,FEDTO,9.,1STPECK,5.,SUBPECK,2.,MMPM,100.,RAPTO,3.,RTRCTO,25.", [-5, -7, -9]),
        ("camworks-apt", "CYCLE/DRILL,FEDTO,9.,1STPECK,4.,MMPM,100.,RAPTO,3.,RTRCTO,25.", [-4, -8, -9]),
    ],
)
def test_a_file_that_names_a_peck_wants_pecks(dialect: str, cycle: str, reached: list[float]) -> None:
    t = read(dialect, f"RAPID\nGOTO/0,0,30\n{cycle}\nGOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,30\n")
    assert [z for m, z in heights(t) if m == C] == reached


def test_holes_along_a_tilted_axis() -> None:
    t = read("nx-clsf", "RAPID\nGOTO/50,0,0,1,0,0\nCYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,250.\nGOTO/10,7,8\nCYCLE/OFF\n")
    np.testing.assert_allclose(
        t.regions[0].position * 1000,
        [[50, 0, 0], [50, 7, 8], [13, 7, 8], [-10, 7, 8], [13, 7, 8]],
        atol=1e-9,
    )


def test_tapping_turns_the_spindle_and_is_said() -> None:
    t = read(
        "catia-apt", "FEDRAT/100,MMPM\nRAPID\nGOTO/0,0,9\nCYCLE/TAP,8,2\nGOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,30\n"
    )
    assert heights(t)[-4:] == [(R, 2), (C, -8), (C, 2), (R, 30)]
    assert [(e.kind.value, e.text) for e in t.regions[0].events][-2:] == [("spindle_on", "CCLW"), ("spindle_on", "CLW")]
    assert any(f.code == "tap-cycle" for f in t.findings)


def test_threads_an_inch_are_a_taps_feed() -> None:
    body = "SPINDL / RPM, 300, CLW\nRAPID\nGOTO / 0, 0, 9\nCYCLE / {}, DEPTH, 8, TPI, 20, CLEAR, 2\nGOTO / 0, 0, 0\nCYCLE / OFF\n"
    tapped = read("creo-ncl", body.format("TAP"))
    assert np.nanmax(tapped.regions[0].feed) * 60_000 == pytest.approx(300 * 25.4 / 20)
    with pytest.raises(ToolpathError, match="a thread's pitch"):
        read("creo-ncl", body.format("DRILL"))


def test_a_dragged_bore_comes_out_in_rapid_with_the_spindle_off() -> None:
    t = read("nx-clsf", "RAPID\nGOTO/0,0,9\nCYCLE/BORE,DRAG,RAPTO,3.,FEDTO,-8.,MMPM,90.\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert heights(t)[-3:] == [(R, 3), (C, -8), (R, 3)]
    (region,) = t.regions
    assert [(e.kind.value, e.point) for e in region.events][-2:] == [
        ("spindle_off", len(region) - 1),
        ("spindle_on", len(region)),
    ]


def test_a_catia_cycle_whose_words_own_their_numbers() -> None:
    t = read("catia-apt", "RAPID\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,20.,CLEAR,2.,MMPM,250.\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert heights(t)[-3:] == [(R, 2), (C, -20), (R, 2)] and np.nanmax(t.regions[0].feed) * 60_000 == pytest.approx(
        250.0
    )


def test_a_catia_cycle_with_the_feed_before_its_unit() -> None:
    t = read("catia-apt", "RAPID\nGOTO/0,0,9\nCYCLE/DRILL,25.,300.,MMPM,5.\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert (C, -25.0) in heights(t) and t.regions[0].feed[2] * 60_000 == pytest.approx(300.0)
    assert heights(t)[-1] == (R, 5.0)


@pytest.mark.parametrize(
    "cycle",
    [
        "CYCLE/DRILL,RAPTO,3.,FEDTO,20.,MMPM,250.",  # NX: upwards
        "CYCLE/WHIRL,RAPTO,3.,FEDTO,-20.,MMPM,250.",
        "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.,MMPM,0.",
        "CYCLE/DRILL,RAPTO,3.,FEDTO,-20.",  # no feed at all
        "CYCLE/BORE,RAPTO,3.,FEDTO,-20.,STEP,4.,MMPM,9.",
        "CYCLE/DRILL,DEEP,RAPTO,3.,FEDTO,-2000.,STEP,0.0001,MMPM,3.",
    ],
)
def test_cycles_that_are_refused(cycle: str) -> None:
    with pytest.raises(ToolpathError) as error:
        read("nx-clsf", f"RAPID\nGOTO/0,0,9\n{cycle}\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert error.value.line > 0


@pytest.mark.parametrize(
    ("dialect", "cycle", "match"),
    [
        (
            "nx-clsf",
            "CYCLE/DRILL,DEPTH,20.,MMPM,250.,CLEAR,3.",
            "names no depth",
        ),  # Creo's words mean nothing certain in NX
        ("nx-clsf", "CYCLE/DRILL,RAPTO,3.,WIBBLE,7.,FEDTO,-20.,MMPM,250.", "WIBBLE,7"),
        ("nx-clsf", "CYCLE/DRILL,20.,3.,MMPM,250.,4.", "what 3 means"),
        ("creo-ncl", "CYCLE/DRILL,FEDTO,-20.,MMPM,250.,RAPTO,3.", "names no depth"),
        ("camworks-apt", "CYCLE/DRILL,FEDTO,20.,MMPM,250.,RAPTO,3.,LEVEL,9.", "LEVEL,9"),
        ("apt", "CYCLE/DRILL,G98,12.0,PECKING,5.0,2.0,MMPM,187.0,3.0,46.9", "what"),  # CAMWorks' .clt, without its head
        ("catia-apt", "CYCLE/DRILL,25.,5.,3.,MMPM,300.", "is not known in this dialect"),
    ],
)
def test_a_number_whose_meaning_is_not_known_is_refused(dialect: str, cycle: str, match: str) -> None:
    with pytest.raises(ToolpathError, match=match) as error:
        read(dialect, f"RAPID\nGOTO/0,0,9\n{cycle}\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert error.value.line > 0 and "GOTO" in str(error.value)


def test_a_hole_without_depth_is_said() -> None:
    t = read("nx-clsf", "RAPID\nGOTO/0,0,9\nCYCLE/DRILL,RAPTO,3.,FEDTO,0.,MMPM,9.\nGOTO/0,0,0\nCYCLE/OFF\n")
    assert any(f.code == "cycle-depth" for f in t.findings)


def test_peck_depths() -> None:
    assert peck_depths(3.5, 0.0, 1.0).tolist() == [1.0, 2.0, 3.0, 3.5]
    assert peck_depths(3.0, 0.0, 1.0).tolist() == [1.0, 2.0, 3.0]
    assert peck_depths(3.0, 5.0, 1.0).tolist() == [3.0]
    with pytest.raises(ToolpathError):
        peck_depths(3.0, 1.0, 0.0)


def test_the_verb_names_the_file_and_takes_a_dialect(tmp_path: Path) -> None:
    path = tmp_path / "part.apt"
    path.write_text("UNITS/MM\nFEDRAT/100\nGOTO/0,0,0\nCIRCLE/5,0,0,0,0,1,5\nGOTO/10,0,0\n")
    right, left = read_toolpath(path), read_toolpath(path, dialect="makino-cldata")
    assert right.dialect == "apt" and left.dialect == "makino-cldata" and right.source == "part.apt"
    assert right.regions[0].position[5, 1] < 0.0 < left.regions[0].position[5, 1]
    with pytest.raises(ToolpathError, match="no such file"):
        read_toolpath(tmp_path / "absent.apt")
    with pytest.raises(ToolpathError, match=r"part\.apt.*nci"):
        read_toolpath(path, dialect="nci")
    with pytest.raises(ToolpathError):
        read_toolpath(tmp_path)


def test_what_rounding_leaves_of_a_peck_is_none_of_its_own() -> None:
    """12.003 mm in pecks of 4 mm, as a CAM system writes 0.4726 inch: three pecks, not four."""
    assert peck_depths(12.003, 4.0, 4.0).tolist() == [4.0, 8.0, 12.003]
    assert peck_depths(12.05, 4.0, 4.0).tolist() == [4.0, 8.0, 12.0, 12.05]
    assert peck_depths(8.0, 4.0, 4.0).tolist() == [4.0, 8.0]
