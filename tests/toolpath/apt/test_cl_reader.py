"""CL statements to points: the traps of real files, each with numbers worked out by hand (mm and degrees)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.apt.read_apt import read_cl
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath

Z = (0.0, 0.0, 1.0)


def read(text: str, dialect: str | None = "apt", units: str | None = None, **more: float) -> Toolpath:
    return read_cl(Path("part.cls"), text.encode(), dialect=dialect, units=units, **more)  # type: ignore[arg-type]


def nx(body: str) -> Toolpath:
    return read("TOOL PATH/OP,TOOL,T1\n" + body + "END-OF-PATH\n", "nx-clsf")


def mm(toolpath: Toolpath) -> np.ndarray:
    return np.concatenate([r.position for r in toolpath.regions]) * 1000.0


def axes(toolpath: Toolpath) -> np.ndarray:
    return np.concatenate([r.axis for r in toolpath.regions])


def moves(toolpath: Toolpath) -> list[int]:
    return np.concatenate([r.move for r in toolpath.regions]).tolist()


def feeds(toolpath: Toolpath) -> np.ndarray:
    return np.concatenate([r.feed for r in toolpath.regions]) * 60_000.0


def codes(toolpath: Toolpath) -> dict[str, int]:
    return {f.code: f.count for f in toolpath.findings}


def events(toolpath: Toolpath) -> list[tuple[str, float, str, int]]:
    return [(e.kind.value, round(e.value, 6), e.text, e.point) for r in toolpath.regions for e in r.events]


HEAD = "UNITS/MM\nFEDRAT/MMPM,600.\n"


def test_axis_is_modal_and_rapid_is_one_shot() -> None:
    t = read(HEAD + "RAPID\nGOTO/0,0,9,0,0.6,0.8\nGOTO/0,0,1\nGOTO/1,0,1\nRAPID\nGOTO/1,0,9,1,0,0\nGOTO/1,0,1\nFINI\n")
    assert moves(t) == [0, 1, 1, 0, 1]
    a = axes(t)
    np.testing.assert_allclose(a[:3], [[0, 0.6, 0.8]] * 3, atol=1e-15)
    np.testing.assert_allclose(a[3:], [[1, 0, 0]] * 2, atol=0)
    f = feeds(t)
    assert np.isnan(f[0]) and np.isnan(f[3]) and f[1] == pytest.approx(600.0) and f[4] == pytest.approx(600.0)
    assert np.concatenate([r.line for r in t.regions]).tolist() == [4, 5, 6, 8, 9]


def test_default_axis_is_z() -> None:
    np.testing.assert_array_equal(axes(read(HEAD + "GOTO/1,2,3\n")), [Z])


@pytest.mark.parametrize(
    ("fedrat", "want"),
    [
        ("FEDRAT/MMPM,250.", 250.0),
        ("FEDRAT/PERMIN,141", 141.0),
        ("FEDRAT / 411.48,  MMPM", 411.48),
        ("FEDRAT/10.,IPM", 254.0),
        ("FEDRAT/200", 200.0),
        ("SPINDL/RPM,1000,CLW\nFEDRAT/MMPR,0.25", 250.0),
        ("SPINDL/1000, CLW\nFEDRAT/0.01,IPR", 254.0),
        ("FEDRAT/PERREV,0.5\nSPINDL/500.,RPM,CCLW", 250.0),
    ],
)
def test_feed_in_all_its_spellings(fedrat: str, want: float) -> None:
    t = read(f"UNITS/MM\n{fedrat}\nGOTO/1,2,3\nGOTO/2,2,3\n")
    np.testing.assert_allclose(feeds(t), want, rtol=1e-12)


def test_feed_per_minute_follows_the_units() -> None:
    t = read("UNITS / INCHES\nFEDRAT/10\nGOTO/1,0,0\n")
    np.testing.assert_allclose(feeds(t), 254.0)
    np.testing.assert_allclose(mm(t), [[25.4, 0, 0]])
    assert t.units == "inch"


@pytest.mark.parametrize("feed", ["", "FEDRAT/0.", "FEDRAT/MMPM,-5", "FEDRAT/MMPR,0.1"])
def test_a_cut_without_an_honest_feed_is_refused(feed: str) -> None:
    with pytest.raises(ToolpathError, match="feed") as error:
        read(f"UNITS/MM\n{feed}\nRAPID\nGOTO/0,0,9\nGOTO/0,0,1\n")
    assert error.value.line == 5


def test_inverse_time_in_cl_data_is_refused() -> None:
    with pytest.raises(ToolpathError, match="no feed"):
        read("FEDRAT/INVERS,2.0\nGOTO/1,2,3\n")


def test_an_axis_kept_over_operations_is_said() -> None:
    one = "TOOL PATH/A,TOOL,T\nFEDRAT/MMPM,9\nRAPID\nGOTO/0,0,9,0,0.6,0.8\nGOTO/0,0,0\nEND-OF-PATH\n"
    t = read(one + one.replace(",0,0.6,0.8", ""), "nx-clsf")
    np.testing.assert_allclose(axes(t)[-1], [0, 0.6, 0.8])
    assert codes(t)["axis-inherited"] == 1
    assert "axis-inherited" not in codes(read(one + one, "nx-clsf"))


def test_units_by_feed_by_caller_and_by_assumption() -> None:
    assert read("RAPID\nGOTO/1,0,0\nFEDRAT/IPM,5\nGOTO/2,0,0\n").regions[0].position[0, 0] == pytest.approx(0.0254)
    t = read("UNITS/INCHES\nFEDRAT/1193.,IPM\nGOTO/211,0,0\nGOTO/0,0,0\n", units="mm")
    np.testing.assert_allclose(mm(t)[0], [211, 0, 0])
    np.testing.assert_allclose(feeds(t), 1193.0)
    assert "units-odd" in codes(t)
    odd = read("UNITS/INCHES\nFEDRAT/1193.,IPM\nGOTO/211,0,0\nGOTO/0,0,0\n")
    assert "units-odd" in codes(odd)
    assert "units-assumed" in codes(read("FEDRAT/5\nGOTO/1,2,3\n"))
    with pytest.raises(ToolpathError, match="unit"):
        read("GOTO/1,2,3\n", units="furlong")


def test_msys_takes_points_and_axis_into_the_part() -> None:
    # origin (10, 20, 30), X of the frame along the part's Y, Y of it along the part's Z: so Z of it is the part's X
    t = nx("MSYS/10,20,30,0,1,0,0,0,1\nFEDRAT/MMPM,100\nGOTO/1,2,3,0,0,1\nGOTO/1,2,3,0,0.6,0.8\n")
    np.testing.assert_allclose(mm(t), [[13, 21, 32]] * 2, atol=1e-12)
    np.testing.assert_allclose(axes(t), [[1, 0, 0], [0.8, 0, 0.6]], atol=1e-15)


def test_a_mirrored_looking_msys_turns_z_over() -> None:
    t = nx("MSYS/0,0,0,0,1,0,1,0,0\nFEDRAT/MMPM,100\nGOTO/1,2,3\n")
    np.testing.assert_allclose(mm(t), [[2, 1, -3]], atol=1e-12)
    np.testing.assert_allclose(axes(t), [[0, 0, -1]], atol=1e-15)


def test_msys_holds_for_its_operation_and_arcs_turn_with_it() -> None:
    t = read(
        "TOOL PATH/A,TOOL,T\nMSYS/0,0,0,1,0,0,0,1,0\nFEDRAT/MMPM,100\nRAPID\nGOTO/1,0,5,0,0,1\n"
        "GOTO/1,0,0\nRAPID\nGOTO/1,0,5\n"
        "END-OF-PATH\nTOOL PATH/B,TOOL,T\nMSYS/0,0,0,1,0,0,0,0,1\nRAPID\nGOTO/1,0,5,0,0,1\nGOTO/1,0,0\n"
        "CIRCLE/0,0,0,0,0,-1,1\nGOTO/0,1,0\nEND-OF-PATH\n",
        "nx-clsf",
    )
    a, b = t.regions
    assert (a.name, b.name) == ("A", "B")
    np.testing.assert_allclose(b.position[0] * 1000, [1, -5, 0], atol=1e-12)  # the frame's z is the part's -y
    np.testing.assert_allclose(b.axis[0], [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(b.position[-1] * 1000, [0, 0, 1], atol=1e-12)
    (arc,) = b.arcs
    np.testing.assert_allclose(arc.axis, [0, -1, 0], atol=1e-15)
    assert arc.angle == pytest.approx(math.pi / 2)


def test_a_tilted_axis_does_not_survive_a_new_frame_unsaid() -> None:
    with pytest.raises(ToolpathError, match="axis is not stated"):
        nx("FEDRAT/MMPM,9\nGOTO/0,0,0,1,0,0\nMSYS/0,0,0,0,1,0,1,0,0\nGOTO/1,1,1\n")


@pytest.mark.parametrize("frame", ["0,0,0,1,0,0", "0,0,0,1,0,0,1,0,0", "0,0,0,2,0,0,0,2,0", "0,0,0,0,0,0,0,0,0"])
def test_a_broken_msys_is_refused(frame: str) -> None:
    with pytest.raises(ToolpathError):
        nx(f"MSYS/{frame}\nFEDRAT/MMPM,9\nGOTO/0,0,0\n")


def test_csys_is_not_applied_again_but_gives_the_axis() -> None:
    head = "PARTNO/1\nUNIT/MM\nFEDRAT/100.,MMPM\nTRNTYP/WORLD,0,0,0\nCSYS/0,0,-1.,7,-1.,0,0,8,0,1.,0,9\n"
    body = "RAPID/\nGOTO/1,2,3,-1.,0,0\nGOTO/1,2,3\nTRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\n"
    t = read(head + body + "RAPID/\nGOTO/4,5,6\nFINI\n", "camworks-apt")
    np.testing.assert_allclose(mm(t), [[1, 2, 3], [1, 2, 3], [4, 5, 6]])
    np.testing.assert_allclose(axes(t), [[-1, 0, 0], [-1, 0, 0], [0, 0, 1]])
    assert len(t.regions) == 2
    with pytest.raises(ToolpathError, match="TRNTYP"):
        read(head.replace("TRNTYP/WORLD,0,0,0\n", "") + "GOTO/1,2,3\nFINI\n", "camworks-apt")


def test_catia_matrix_tlaxis_and_arc() -> None:
    text = (
        "$$     CATIA APT VERSION 1.0\n$$*CATIA0\n$$ Part Operation.1\n"
        "$$     1.00000     0.00000     0.00000     5.00000\n"
        "$$     0.00000    -1.00000     0.00000     0.00000\n"
        "$$     0.00000     0.00000    -1.00000     0.00000\n"
        "PARTNO PART TO BE MACHINED\nPPRINT OPERATION NAME : Facing.1\nTLAXIS/ 0.000000, 0.000000, 1.000000\n"
        "FEDRAT/  300.0000,MMPM\nGOTO/10.00000, 0$\n.00000, 0.00000\nAUTOPS\nINDIRV/ 0.00000, 1.00000, 0.00000\n"
        "TLON,GOFWD/ (CIRCLE/ 0.00000, 0.00000, 0.00000,$\n  10.00000),ON,(LINE/ 0.00000, 0.00000, 0.00000,$\n"
        " 0.00000, 10.00000, 0.00000)\nROTABL/ 0.0,,TABLE,CLW\nFINI\nrandom\n"
    )
    t = read(text, None)
    assert t.dialect == "catia-apt" and t.regions[0].name == "Facing.1" and "catia-frame" in codes(t)
    p = mm(t)
    np.testing.assert_allclose(p[0], [15, 0, 0], atol=1e-12)
    np.testing.assert_allclose(p[-1], [5, -10, 0], atol=1e-12)
    np.testing.assert_allclose(axes(t)[0], [0, 0, -1], atol=1e-15)
    (arc,) = t.regions[0].arcs
    assert arc.angle == pytest.approx(math.pi / 2)  # INDIRV says the short way
    back = read(text.replace("INDIRV/ 0.00000, 1.00000", "INDIRV/ 0.00000,-1.00000"), None)
    assert back.regions[0].arcs[0].angle == pytest.approx(1.5 * math.pi)


def test_clt_table_turns_become_a_tilted_tool() -> None:
    op = (
        "TLAXIS/ 0.000000,-1.000000,0.000000 \nOPFEATSTART/Drill1 [Sub2]\nROTABL/ 1.570796,AAXIS,TABLE,CCLW \n"
        "ROTABL/ -0.000000,BAXIS,TABLE,CCLW \nRAPID/ \nGOTO/ 1.0,2.0,25.0 \nFEDRAT/ MMPM,100\nGOTO/ 1.0,2.0,3.0 \n"
        "CIRCLE/ 0.0,2.0,3.0,0.0,0.0,1.0,1.0,CLOCKWISE \nGOTO/ 0.0,1.0,3.0 \nOPFEATEND/Drill1 [Sub2]\n"
    )
    head = "UNITS/ MM \nCUTTER/ 6.0,0.0,3.0,1.8,31.0,0.0,102.0,\n"
    t = read(head + op + op, None)
    assert t.dialect == "camworks-clt" and "indexed-table" in codes(t) and len(t.regions) == 2
    np.testing.assert_allclose(axes(t), [[0, -1, 0]] * len(axes(t)), atol=1e-6)
    np.testing.assert_allclose(mm(t)[:2], [[1, -25, 2], [1, -3, 2]], atol=1e-4)
    arc = t.regions[0].arcs[0]
    assert arc.angle == pytest.approx(math.pi / 2, abs=1e-6)
    np.testing.assert_allclose(arc.axis, [0, 1, 0], atol=1e-6)  # clockwise seen from the tool
    assert t.tools[0].diameter == pytest.approx(0.006) and t.tools[0].length == pytest.approx(0.102)
    with pytest.raises(ToolpathError, match="do not fit"):
        read(head + op.replace("1.570796", "0.7"), None)
    with pytest.raises(ToolpathError, match="centre"):
        other = op.replace("0.000000,-1.000000,0.000000", "0.0,1.0,0.0").replace("1.570796", "-1.570796")
        read(head + op + other, None)


def test_a_table_turn_elsewhere_is_refused() -> None:
    with pytest.raises(ToolpathError, match="ROTABL"):
        read(HEAD + "ROTABL/90.,AAXIS,TABLE,CLW\nGOTO/1,2,3\n")


@pytest.mark.parametrize(
    ("dialect", "head", "sense"),
    [
        ("nx-clsf", "TOOL PATH/A,TOOL,T\n", -1),
        ("makino-cldata", "", -1),
        ("creo-ncl", "", 1),
        ("camworks-apt", "", 1),
        ("apt", "", -1),  # eleven numbers, as NX and Makino write them
    ],
)
def test_arcs_turn_as_the_system_means_them(dialect: str, head: str, sense: int) -> None:
    text = f"{head}{HEAD}GOTO/10,0,0\nCIRCLE/0,0,0,0,0,{sense},10.,0.06,0.5,20.,0.\nGOTO/0,10,0\nEND-OF-PATH\nFINI\n"
    t = read(text.replace("END-OF-PATH\n", "") if not head else text, dialect)
    (arc,) = t.regions[0].arcs
    assert arc.angle == pytest.approx(math.pi / 2) and arc.radius == pytest.approx(0.01)
    np.testing.assert_allclose(arc.axis, Z, atol=0)
    p = mm(t)[arc.first : arc.last + 1]
    np.testing.assert_allclose(np.linalg.norm(p, axis=1), 10.0, rtol=1e-12)
    assert p[len(p) // 2] @ [1, 1, 0] > 0


def test_an_arc_of_no_known_system_turns_as_its_form_says_and_that_is_said() -> None:
    t = read(HEAD + "GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\n", "apt")
    assert t.regions[0].arcs[0].angle == pytest.approx(math.pi / 2)
    assert [f.code for f in t.findings].count("arc-sense") == 1


def test_small_letters_are_known_as_capitals_are() -> None:
    text = HEAD + "GOTO/10,0,0\nGOTO/0,10,0\n"
    assert mm(read(text.lower())).tolist() == mm(read(text)).tolist()


@pytest.mark.parametrize(("sense", "goes"), [(1, True), (-1, False)])
def test_an_arc_of_no_known_system_that_would_turn_straight_back_is_refused(sense: int, goes: bool) -> None:
    """Behind a cut along X the arc about (10, 5) goes on smoothly right-handedly about +Z alone."""
    text = HEAD + f"GOTO/0,0,0\nGOTO/10,0,0\nCIRCLE/10,5,0,0,0,{sense},5\nGOTO/15,5,0\n"
    if goes:
        assert read(text, "apt").regions[0].arcs[0].angle == pytest.approx(math.pi / 2)
        return
    with pytest.raises(ToolpathError, match="straight back"):
        read(text, "apt")


@pytest.mark.parametrize("sense", [-1, 1])
def test_an_arc_of_a_known_system_that_turns_straight_back_is_cut_as_the_system_means_it_and_said(sense: int) -> None:
    """NX's axis points against the turn: with +Z a corner's quarter becomes three quarters through the part."""
    t = nx(f"FEDRAT/MMPM,9\nGOTO/0,0,0\nGOTO/10,0,0\nCIRCLE/10,5,0,0,0,{sense},5,0.06,0.5,20,0\nGOTO/15,5,0\n")
    assert abs(t.regions[0].arcs[0].angle) == pytest.approx(math.pi * (0.5 if sense < 0 else 1.5))
    said = [f for f in t.findings if f.code == "arc-turns-back"]
    assert [f.text.count("clockwise about the axis") for f in said] == [1] * (sense > 0)


def test_full_circle_helix_and_other_planes() -> None:
    t = read(HEAD + "GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/10,0,0\n")
    assert t.regions[0].arcs[0].angle == pytest.approx(2 * math.pi)
    t = nx("FEDRAT/MMPM,9\nGOTO/10,0,6\nCIRCLE/0,0,6,0,0,-1,10,0.06,0.5,20,0,TIMES,2\nGOTO/10,0,0\n")
    assert t.regions[0].arcs == ()  # it rises: a helix of three turns
    p = mm(t)
    turned = np.unwrap(np.arctan2(p[:, 1], p[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(6 * math.pi)
    np.testing.assert_allclose(p[:, 2], 6.0 - (turned - turned[0]) / math.pi, atol=1e-9)
    t = read(HEAD + "GOTO/0,5,0\nCIRCLE/0,0,0,1,0,0,5\nGOTO/0,0,5\n")
    np.testing.assert_allclose(t.regions[0].arcs[0].axis, [1, 0, 0])


def test_chord_and_angle_tolerance_hold() -> None:
    text = HEAD + "GOTO/100,0,0\nCIRCLE/0,0,0,0,0,1,100\nGOTO/0,100,0\n"
    for chord, angle in ((1e-6, 1.0), (1e-4, 1.0), (1.0, math.radians(3))):
        p = mm(read(text, chord_tolerance=chord, angle_tolerance=angle))
        middle = 0.5 * (p[1:] + p[:-1])
        assert 100.0 - np.min(np.linalg.norm(middle, axis=1)) <= chord * 1000 * (1 + 1e-6)
        d = np.diff(p, axis=0)
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        assert np.max(np.arccos(np.clip(np.sum(d[1:] * d[:-1], axis=1), -1, 1))) <= angle * (1 + 1e-6)


@pytest.mark.parametrize(
    "body",
    [
        "GOTO/1,0,0\nCIRCLE/0,0,0,0,0,1,1\n",
        "GOTO/1,0,0\nCIRCLE/0,0,0,0,0,1,1\nCIRCLE/0,0,0,0,0,1,1\nGOTO/0,1,0\n",
        "CIRCLE/0,0,0,0,0,1,1\nGOTO/0,1,0\n",
        "GOTO/1,0,0\nCIRCLE/0,0,0,0,0,1,1\nGOTO/0,2,0\n",
        "GOTO/1,0,0\nCIRCLE/0,0,0,0,0,0.5,1\nGOTO/0,1,0\n",
        "GOTO/1,0,0\nCIRCLE/0,0,0,0,0,1,1,0,0,0,0,TIMES,1000000\nGOTO/0,1,0\n",
        "GOTO/0,0,0\nCIRCLE/0,0,0,0,0,1,0\nGOTO/0,0,0\n",
        "GOTO/1,0,0\nCIRCLE/0,0,0\nGOTO/0,1,0\n",
    ],
)
def test_arcs_that_are_none_are_refused(body: str) -> None:
    with pytest.raises(ToolpathError):
        read(HEAD + body)


def test_nurbs_of_a_straight_line_and_of_a_known_cubic() -> None:
    head = "FEDRAT/MMPM,9\nGOTO/0,0,0,0,0,1\nNURBS/4\n"
    straight = nx(head + "KNOT/0.5\nCNTRL/0,0,0\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0\nCNTRL/4,0,0\nGOTO/9,0,0\n")
    p = mm(straight)
    np.testing.assert_allclose(p[-2], [4, 0, 0])
    assert np.all(np.diff(p[:, 0]) > 0) and np.all(p[:, 1:] == 0)
    # one Bezier piece (no interior knot), start left out: at its middle (b0 + 3 b1 + 3 b2 + b3) / 8
    bezier = nx(head + "CNTRL/0,8,0\nCNTRL/8,8,0\nCNTRL/8,0,0\n")
    p = mm(bezier)
    np.testing.assert_allclose(p[-1], [8, 0, 0])
    assert np.min(np.linalg.norm(p - np.array([4.0, 6.0, 0.0]), axis=1)) < 0.5
    u = np.linspace(0, 1, 5001)[:, None]
    curve = 3 * u * (1 - u) ** 2 * [0, 8, 0] + 3 * u**2 * (1 - u) * [8, 8, 0] + u**3 * [8, 0, 0]
    a, b = p[:-1], p[1:]
    for c in curve[::100]:
        s = np.clip(np.sum((c - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0, 1)
        assert np.min(np.linalg.norm(a + s[:, None] * (b - a) - c, axis=1)) < 0.011
    with pytest.raises(ToolpathError, match="knots"):
        nx(head + "KNOT/0.5,0.4\nCNTRL/0,8,0\nCNTRL/8,8,0\nCNTRL/8,0,0\n")


def test_gohome_godlta_and_from() -> None:
    t = read(HEAD + "FROM/0,0,50,0,0.6,0.8\nRAPID\nGOTO/0,0,10\nGODLTA/0,0,-5\nGODLTA/5\nGOHOME/0,0,50\nFINI\n")
    np.testing.assert_allclose(mm(t), [[0, 0, 10], [0, 0, 5], [0, 3, 9], [0, 0, 50]], atol=1e-12)
    assert moves(t) == [0, 1, 1, 0]
    t = read(HEAD + "FROM/0,0,50\nGOTO/0,0,10\nGOHOME / Z\n")  # the cut starts at FROM
    assert moves(t) == [0, 1] and mm(t)[0, 2] == 50.0 and "home" in codes(t)


def test_the_axis_is_checked() -> None:
    t = read(HEAD + "GOTO/0,0,0,0,0,1.0004\n")
    np.testing.assert_array_equal(axes(t), [Z])
    for text in (
        "GOTO/0,0,0,0,0,1.01\n",
        "GOTO/0,0,0,0,0,0\n",
        "GOTO/1,1,1\nGOTO/0,0,0,1,1,0\n",
        "TLAXIS/1,1,0\nGOTO/1,1,1\n",
    ):
        with pytest.raises(ToolpathError, match="length"):
            read(HEAD + text)


def test_operations_tools_and_events() -> None:
    t = read(
        "TOOL PATH/ROUGH,TOOL,MILL-20\nTLDATA/MILL,20.,1.,75.,0.,0.\nSPINDL/RPM,1000,CLW \nCOOLNT/FLOOD\nRAPID\n"
        "GOTO/0,0,9,0,0,1\nFEDRAT/MMPM,100.\nGOTO/0,0,0\nDELAY/2.5\nGOTO/1,0,0\n"
        "RAPID\nGOTO/1,0,9\nSPINDL/OFF\nEND-OF-PATH\n"
        "TOOL PATH/FINISH,TOOL,BALL-6\nTLDATA/MILL,6.,3.,75.,0.,0.\nLOAD/TOOL,7\nOPSTOP\n"
        "PPRINT check\x1b[2J the part\nRAPID\n"
        "GOTO/5,0,9,0,0,1\nGOTO/5,0,0\nEND-OF-PATH\n",
        None,
    )
    assert t.dialect == "nx-clsf"
    assert [(r.name, r.tool, len(r)) for r in t.regions] == [("ROUGH", 0, 4), ("FINISH", 7, 2)]
    assert events(t) == [
        ("tool_change", 0.0, "MILL-20", 0),
        ("spindle_on", 1000.0, "CLW", 0),
        ("coolant_on", 0.0, "FLOOD", 0),
        ("dwell", 2.5, "", 2),
        ("spindle_off", 0.0, "", 4),
        ("tool_change", 7.0, "BALL-6", 0),
        ("stop", 0.0, "OPSTOP", 0),
        ("message", 0.0, "check [2J the part", 0),
    ]
    assert [(x.number, x.name, round(x.diameter, 6), round(x.corner_radius, 6)) for x in t.tools] == [
        (0, "MILL-20", 0.02, 0.001),
        (7, "BALL-6", 0.006, 0.003),
    ]


def test_what_is_said_between_two_operations_belongs_to_the_second() -> None:
    frame = "TRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\n"
    op = "INSERT/MILL {0}\nCUTTER/{0}.,0,1.\nLOAD/TOOL,{0}\nCOOLNT/FLOOD\n" + frame
    op += "RAPID/\nGOTO/0,0,9\nGOTO/0,0,{0}\nRAPID/\nGOTO/0,0,9\n"
    t = read("UNIT/MM\nFEDRAT/100.,MMPM\n" + op.format(4) + op.format(6) + "FINI\n", "camworks-apt")
    a, b = t.regions
    assert [(e.kind.value, e.value, e.point) for e in b.events] == [("tool_change", 6.0, 0), ("coolant_on", 0.0, 0)]
    assert [(e.kind.value, e.value, e.point) for e in a.events] == [("tool_change", 4.0, 0), ("coolant_on", 0.0, 0)]
    assert (a.tool, b.tool) == (4, 6) and (a.name, b.name) == ("MILL 4", "MILL 6")
    assert [(x.number, round(x.diameter * 1000, 6)) for x in t.tools] == [(4, 4.0), (6, 6.0)]


def test_the_same_tool_loaded_twice_is_one_change() -> None:
    t = read(HEAD + "LOADTL/1\nLOADTL/1,1\nRAPID\nGOTO/0,0,9\nLOADTL/1\nGOTO/0,0,1\nSELECT/TOOL,9\nGOTO/1,0,1\n")
    assert [e for e in events(t) if e[0] == "tool_change"] == [("tool_change", 1.0, "", 0)]


def test_a_rapid_inside_an_operation_makes_no_region_but_a_turn_of_the_tool_does() -> None:
    body = "".join(f"RAPID\nGOTO/{n},0,9\nGOTO/{n},0,0\n" for n in range(50))
    assert len(read(HEAD + body).regions) == 1
    t = read(
        HEAD
        + "RAPID\nGOTO/0,0,9,0,0,1\nGOTO/0,0,0\nRAPID\nGOTO/0,0,9\nRAPID\nGOTO/9,0,0,1,0,0\nGOTO/0,0,0\nGOTO/0,1,0\n"
    )
    assert [len(r) for r in t.regions] == [3, 3]
    assert t.regions[1].move[0] == Move.RAPID
    small = read(HEAD + "RAPID\nGOTO/0,0,9,0,0,1\nGOTO/0,0,0\nRAPID\nGOTO/0,0,9,0.1,0,0.9949874\nGOTO/0,0,0\n")
    assert len(small.regions) == 1


def test_an_operation_that_changes_while_cutting_waits_for_the_air() -> None:
    t = read(
        HEAD + "$$-> FEATNO / 1\nGOTO/0,0,0\n$$-> FEATNO / 2\nGOTO/1,0,0\nGOTO/2,0,0\nRAPID\nGOTO/2,0,9\nGOTO/3,0,0\n"
    )
    assert [len(r) for r in t.regions] == [3, 2] and [r.name for r in t.regions] == ["feature 1", "feature 2"]


def test_cutcom_is_said_once_an_operation() -> None:
    op = "RAPID\nGOTO/0,0,9\nGOTO/0,0,0\nCUTCOM/LEFT\nGOTO/1,0,0\n"
    op += "CUTCOM/OFF\nGOTO/2,0,0\nCUTCOM/RIGHT,XYPLAN\nGOTO/3,0,0\nRAPID\nGOTO/3,0,9\n"
    t = read(HEAD + "".join(f"TOOL PATH/{n},TOOL,T\n{op}END-OF-PATH\n" for n in "AB"), "nx-clsf")
    found = [f for f in t.findings if f.code == "cutcom"]
    assert [(f.line, f.count) for f in found] == [(7, 1), (20, 1)]
    assert "operation A" in found[0].text


def test_unknown_words_are_counted_and_those_with_coordinates_refused() -> None:
    t = read(HEAD + "WIBBLE/ON\nGOTO/1,2,3\nWIBBLE/OFF\nFOO/1,2\n")
    found = {f.text.split()[0]: (f.line, f.count) for f in t.findings if f.code == "unknown-word"}
    assert found == {"WIBBLE": (3, 2), "FOO": (6, 1)}
    for line in ("WIBBLE/1,2,3", "CYCLE81/10,0,2,-25,0", "ORIGIN/1,0,0", "1.0,2.0,3.0", "CALLSUB/1001"):
        with pytest.raises(ToolpathError, match="may mean motion") as error:
            read(HEAD + f"GOTO/1,2,3\n{line}\n")
        assert error.value.line == 4
    read(HEAD + "ORIGIN/0,0,0\nTRACUT/NOMORE\nGOTO/1,2,3\n")


@pytest.mark.parametrize(
    "line",
    ["pl1=plane/0,0,1,5", "goto/pt3", "GOTO/SETPT", "tllft,gofwd/l1,past,l2", "go/to,c1", "M1 = MACRO/A,B", "LOOPST"],
)
def test_part_programs_are_refused(line: str) -> None:
    with pytest.raises(ToolpathError, match="part program"):
        read(HEAD + f"GOTO/1,2,3\n{line}\n")


@pytest.mark.parametrize(
    "bad",
    [
        "GOTO/NAN,0,0",
        "GOTO/1,inf,0",
        "GOTO/1e999,0,0",
        "GOTO/1,2",
        "GOTO/1,2,3,4",
        "GOTO/1,?,3",
        "GOTO/99999999999,0,0",
        "FEDRAT/1e999,MMPM",
        "DELAY/1e300",
        "LOADTL/1e400",
        "GOTO/",
    ],
)
def test_damaged_points_are_refused_with_their_line(bad: str) -> None:
    with pytest.raises(ToolpathError) as error:
        read(HEAD + f"GOTO/1,2,3\n{bad}\n")
    assert error.value.line == 4 and "part.cls:4:" in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("nx-clsf", "TOOL PATH/A,TOOL,T\nFEDRAT/MMPM,9\nGOTO/1,2,3\nGOTO/2,2,3\n"),
        ("creo-ncl", HEAD + "GOTO / 1,2,3\nGOTO / 1,2\n"),
        ("creo-ncl", HEAD + "GOTO / 1,2,3\nGOTO / 1,2,9"),
        ("creo-ncl", HEAD + "GOTO / 1,2,3,  $\n"),
        ("camworks-apt", HEAD + "GOTO/1,2,3\n"),
        ("makino-cldata", "PPRINT/BEGIN-SECTION,PATH\n" + HEAD + "GOTO/1,2,3\n"),
        ("camworks-clt", "OPFEATSTART/x\n" + HEAD + "GOTO/1,2,3\n"),
        ("catia-apt", "$$*CATIA0\n$$ 1 0 0 0\n$$ 0 1 0 0\n" + HEAD + "GOTO/1,2,3\nFINI\n"),
    ],
)
def test_files_that_were_cut_off_are_refused(dialect: str, text: str) -> None:
    with pytest.raises(ToolpathError):
        read(text, dialect)


def test_motion_after_the_end_is_refused_and_junk_is_not() -> None:
    read(HEAD + "GOTO/1,2,3\nFINI\nxkcd 42\n")
    with pytest.raises(ToolpathError, match="after the program's end"):
        read(HEAD + "GOTO/1,2,3\nFINI\nGOTO/1,2,3\n")


@pytest.mark.parametrize(
    "data", [b"", b"hello\n", b"\x7fELF\x00\x01", b"FINI\n" * 9, b"PARTNO X\nFINI\n", b"%PDF-1.4\n"]
)
def test_what_is_no_cl_data_is_refused(data: bytes) -> None:
    with pytest.raises(ToolpathError) as error:
        read_cl(Path("x.bin"), data)
    assert "\n" not in str(error.value)


def test_an_unknown_dialect_is_refused() -> None:
    with pytest.raises(ToolpathError, match="dialect"):
        read("GOTO/1,2,3\n", "mastercam")


def test_text_from_the_file_stays_one_line() -> None:
    t = read("PARTNO a\x07b\x1b\u2028c\n" + HEAD + "PPRINT ;HALT\rEND\nGOTO/1,2,3\n")
    assert t.regions[0].name == "a b c"
    assert all(e.text.isprintable() for r in t.regions for e in r.events if e.kind == EventKind.MESSAGE)


def test_a_synonym_can_silence_a_word() -> None:
    t = read(HEAD + "SYN/'TLAXIS','$$*TLAXIS'\nTLAXIS/1,0,0\nGOTO/1,2,3\n")
    np.testing.assert_array_equal(axes(t), [Z])


def test_progress_is_reported_and_grows() -> None:
    calls: list[float] = []
    text = HEAD + "GOTO/1,2,3\nPAINT/PATH\n" * 3000
    read_cl(Path("x.apt"), text.encode(), dialect="apt", progress=calls.append)
    assert calls == sorted(calls) and calls[-1] == 1.0 and 50 <= len(calls) <= 110


def test_fast_and_slow_reading_give_the_same_toolpath() -> None:
    rng = np.random.default_rng(3)
    fast, slow = [], []
    for n in range(400):
        x = ",".join(f"{v:.4f}" for v in rng.uniform(-100, 100, 3))
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        tail = "," + ",".join(f"{v:.9f}" for v in axis) if n % 7 == 0 else ""
        if n % 11 == 0:
            fast.append("RAPID")
            slow.append("RAPID")
        fast.append(f"GOTO/{x}{tail}")
        slow.append(f"GOTO/{x}{tail},")  # a trailing comma sends it the slow way
    a, b = (read(HEAD + "\n".join(lines) + "\n") for lines in (fast, slow))
    assert a.digest == b.digest and a.points == b.points >= 400


def test_a_million_points_are_all_read() -> None:
    assert read(HEAD + "GOTO/12.3456,-65.4321,0.1000\n" * 1_000_000).points == 1_000_000
