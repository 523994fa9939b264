from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from camrob.errors import KrlError
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import FrameKind, ProgramText

SHARED = Path(__file__).resolve().parents[3] / "shared"
ROOT = Path(__file__).resolve().parents[2]
P0 = "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6,E1 7,E2 8}\n"


def read(folder: Path, body: str, data: str | None = None, **others: str) -> ProgramText:
    (folder / "P.src").write_text(f"DEF P ( )\n$VEL.CP = 0.01\n{body}\nEND\n", newline="", encoding="utf-8")
    if data is not None:
        (folder / "p.dat").write_text(f"DEFDAT P\n{data}\nENDDAT\n", newline="")
    for name, text in others.items():
        (folder / f"{name}.SRC").write_text(text, newline="")
    return read_krl(folder / "P.src")


def codes(program: ProgramText) -> list[str]:
    return [f.code for f in program.findings]


# --- files of other posts


@pytest.mark.parametrize(
    ("name", "statements", "external"),
    [
        ("rdk_krc2_camrob", 2, ("E1", "E2")),
        ("rdk_krc2_dat", 251, ()),
        ("rdk_krc4_config", 401, ("E1",)),
        ("rdk_krc4_dat", 251, ("E1", "E2")),
        ("rdk_krc4_rail_table", 1201, ("E1", "E2")),
    ],
)
def test_corpus(name, statements, external):
    path = SHARED / "corpus" / "krl" / f"{name}.src"
    if not path.exists():
        pytest.skip("../shared is not here: the KRL files of other posts are not read")
    program = read_krl(path)
    assert sum(program.statements.get(word, 0) for word in ("PTP", "LIN", "CIRC")) == statements
    # one PTP goes to where the robot is; a CIRC has two rows
    assert len(program) == statements - 1 + program.statements.get("CIRC", 0)
    assert program.external_names == external
    assert "null-motion" in codes(program) and "not-understood" not in codes(program)
    assert [t.kind for t in program.tools] == [FrameKind.LITERAL]
    assert program.tools[0].xyzabc.tolist() == [0, 0, 212.4, 0, 0, 0]
    assert program.bases[0].xyzabc.tolist() == [850, -420, 65.5, 0, 0, 0]
    assert (program.bases[0].kind is FrameKind.MECHANISM) == ("rail_table" in name)
    lin = program.kind == Motion.LIN
    assert np.all(program.speed[lin] > 0.001)
    if name == "rdk_krc4_rail_table":
        assert program.pose[1].tolist() == [9.116, 15.222, 89.025, -0.315, 3.266, 174.497]
        assert program.external[1].tolist() == [1203.33326, -179.7] and program.line[1] == 51
        assert program.wait[1] == 1.5 and np.all(program.blend[1:] == Blend.DISTANCE)
    if name == "rdk_krc4_config":
        assert program.status[5] == 2 and program.turn[5] == 2 and program.status[0] == -1
    if name == "rdk_krc4_dat":
        assert program.pose[1].tolist() == [-55.448, -56.592, 60.943, -11.861, -21.479, -150.163]


# --- the compiled scan and the general reader agree

NUMBER = st.one_of(
    st.floats(-1e6, 1e6).map(lambda v: f"{v:.4f}"),
    st.floats(allow_nan=False, allow_infinity=False, width=64).map(repr),
    st.from_regex(r"\A[-+]?([0-9]{1,12}\.?[0-9]{0,12}|\.[0-9]{1,9})\Z"),
)


EXTERNAL = st.lists(st.tuples(st.integers(1, 6), NUMBER), max_size=3, unique_by=lambda e: e[0])
TAILS = ["", " C_DIS", " C_VEL ; x", "C_ORI", " ; LIN {X 1}"]
ROW = st.tuples(
    st.lists(NUMBER, min_size=6, max_size=6),
    EXTERNAL,
    st.sampled_from(["", "E6POS:", "E6POS: "]),
    st.sampled_from(TAILS),
    st.sampled_from([",", ", ", " ,\t"]),
    st.floats(1e-6, 3).map(lambda v: f"{v:.6f}"),
    st.permutations(range(6)),
)


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=st.lists(ROW, min_size=1, max_size=8))
def test_bulk_and_general_lines_give_the_same(rows, tmp_path):
    body = []
    for numbers, external, kind, tail, comma, speed, order in rows:
        parts = [f"{'XYZABC'[k]} {numbers[k]}" for k in order] + [f"E{k} {v}" for k, v in external]
        body.append(f"$VEL.CP = {speed}\n  LIN {{{kind}{comma.join(parts)}}}{tail}")
    text = "\n".join(body)
    bulk = read(tmp_path, text)
    general = read(tmp_path, text.replace("LIN {", "lin {").replace("$VEL.CP", "$vel.cp"))
    for name in ("pose", "external", "speed", "blend", "line", "kind"):
        a, b = getattr(bulk, name), getattr(general, name)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
        assert np.array_equal(np.signbit(a), np.signbit(b)), name
    for row, (numbers, *_) in enumerate(rows):
        assert bulk.pose[row].tolist() == [float(t) for t in numbers]


# --- what statements mean


def test_targets_of_all_kinds(tmp_path):
    program = read(
        tmp_path,
        """PTP {E6AXIS: A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0,E1 1,E2 2} C_PTP
ptp {Axis: A1 1,A2 -91,A3 91,A4 1,A5 31,A6 1}
PTP {A5 40}
PTP {POS: X 1,Y 2,Z 3,A 4,B 5,C 6,S 'B110',T 'H23'} C_PTP C_DIS
LIN {FRAME: X 10,Y 20,Z 30,A 40,B 50,C 60}
LIN {E2 -7.5}
LIN {Z +31} C_VEL
CIRC {X 1,Y 1,Z 1,A 0,B 0,C 0},{X 2,Y 2,Z 2,A 0,B 0,C 0,E1 9},CA -360.5 C_ORI""",
    )
    k = Motion
    assert program.kind.tolist() == [k.PTP_AXES] * 3 + [k.PTP_POSE] + [k.LIN] * 3 + [k.CIRC_VIA, k.CIRC_END]
    assert program.axes[2].tolist() == [1, -91, 91, 1, 40, 1]
    assert program.external.tolist() == [[1, 2]] * 5 + [[1, -7.5]] * 3 + [[9, -7.5]]
    assert (program.status[3], program.turn[3]) == (6, 35) and set(program.status[4:]) == {-1}
    assert program.pose[5].tolist() == [10, 20, 30, 40, 50, 60] and program.pose[6, 2] == 31
    assert program.blend.tolist() == [1, 0, 0, 1, 0, 0, 3, 0, 4]
    assert math.isnan(program.circular_angle_deg[7]) and program.circular_angle_deg[8] == -360.5
    assert program.line.tolist() == [3, 4, 5, 6, 7, 8, 9, 10, 10]


def test_points_frames_and_speeds_from_the_data_list(tmp_path):
    program = read(
        tmp_path,
        """BASE_DATA[1] = {X 1,Y 2,Z 3,A 0,B 0,C 0}
$BASE = BASE_DATA[1]
$TOOL = TOOLS[N]
$ACC = {CP 1.5,ORI1 100,ORI2 100}
FDAT_ACT = FP1
LDAT_ACT = LP1
BAS (#CP_PARAMS, 0.25 )
LIN XP1 C_DIS
XP1.Z = XP1.Z + 2 * (3 - 1)
FOR I = 2 TO 3
  $VEL.CP = I / 10.0
  LIN XP[I]
ENDFOR
BAS(#BASE,4)
LIN XP[3]""",
        """DECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35,E1 0.0}
DECL FRAME TOOLS[2]
TOOLS[2]={X 9,Y 0,Z 0,A 0,B 0,C 0}
INT N=2
DECL INT I
DECL E6POS XP[3]
XP[2]={X 2,Y 2,Z 2,A 0,B 0,C 0}
XP[3]={X 3,Y 3,Z 3,A 0,B 0,C 0}
DECL FDAT FP1={TOOL_NO 0,BASE_NO 1,POINT2[] " ; no comment"}
DECL LDAT LP1={VEL 2.0,ACC 100,APO_DIST 12.5}""",
    )
    assert program.pose[:, 0].tolist() == [1, 2, 3, 3] and program.pose[0, 2] == 3
    assert program.speed.tolist() == [0.25, 0.2, 0.3, 0.3]
    assert set(program.acceleration) == {1.5} and set(program.blend_mm) == {12.5}
    assert [program.bases[k].xyzabc[0] for k in program.base[:3]] == [1, 1, 1]
    assert program.bases[program.base[3]].kind is FrameKind.UNKNOWN and "BASE_DATA[4]" in program.bases[1].text
    assert program.tools[0].xyzabc.tolist() == [0] * 6 and "base-unknown" in codes(program)


def test_what_a_public_data_list_shares(tmp_path):
    """GLOBAL in a .dat holds for all files (as Robots for Grasshopper writes it); a $config.dat beside them counts, too."""
    shared = "DECL GLOBAL FRAME Spindle={X 1,Y 2,Z 3,A 0,B 0,C 0}\nDECL GLOBAL REAL Slow=0.02\nDECL GLOBAL E6POS Q[2]\n"
    shared += "Q[1]={X 9,Y 8,Z 7,A 0,B 0,C 0}\nDECL REAL Own=5"
    part = "DEF PART ( )\n$TOOL=Spindle\n$BASE=Board\n$VEL.CP=Slow\nLIN Q[1]\n$VEL.CP=Own\nLIN {X 1}\nEND\n"
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG\nDECL FRAME Board={X 4,Y 5,Z 6,A 0,B 0,C 0}\nENDDAT\n")
    program = read(tmp_path, "PART()", shared, PART=part)
    assert program.pose[0].tolist() == [9, 8, 7, 0, 0, 0] and program.speed[0] == 0.02
    assert program.tools[program.tool[0]].xyzabc[:3].tolist() == [1, 2, 3]
    assert program.bases[program.base[0]].xyzabc[:3].tolist() == [4, 5, 6]
    assert np.isnan(program.speed[1]), "what is not GLOBAL stays its own file's"


def test_steps_from_the_last_target(tmp_path):
    """Along the axes of $BASE; E by so much; a step of axes behind axes."""
    steps = "LIN_REL {X 10,E1 1} C_DIS\nLIN_REL {Z -2.5} #BASE\nPTP_REL {Y 1}\n"
    steps += "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nPTP_REL {A6 -7}"
    program = read(tmp_path, P0 + steps)
    assert program.pose[:4].tolist() == [
        [1, 2, 3, 4, 5, 6],
        [11, 2, 3, 4, 5, 6],
        [11, 2, 0.5, 4, 5, 6],
        [11, 3, 0.5, 4, 5, 6],
    ]
    assert program.external[:4, 0].tolist() == [7, 8, 8, 8] and program.axes[5].tolist() == [1, 2, 3, 4, 5, -1]
    assert [int(k) for k in program.kind[[1, 3, 5]]] == [Motion.LIN, Motion.PTP_POSE, Motion.PTP_AXES]
    assert program.blend[1] == Blend.DISTANCE and not program.blend[2]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (P0 + "LIN_REL {A 1} #TOOL", "turns the tool"),
        (P0 + "LIN_REL {X 1,E1 2} #TOOL", "of axes along the tool"),
        (P0 + "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nE6=$POS_ACT\nLIN E6", "stands .* not in the program"),
        (P0 + "$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}\nQ=$POS_ACT\nLIN Q", "stands .* not in the program"),
        (P0 + "LIN_REL {A 1}", "turns the tool"),
        (P0 + "$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}\nLIN_REL {X 1}", "doesn't hold"),
        (P0 + "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nLIN_REL {X 1}", "doesn't hold"),
        (P0 + "LIN_REL {E3 1}", "external axis"),
        (P0 + "PTP_REL {A1 1}", "doesn't hold"),
        (P0 + "LIN {X 1} #BASE", "behind a motion"),
        (P0 + "LIN {X 1,Y 0,Z 0}:{X 0,Y 0,Z -4,A 0,B 0,C 0}", "geometric operator"),
        (P0 + "CIRC {X 2,Y 3},{X 3,Y 2},CA 90\nLIN_REL {X 1}", "doesn't hold"),
    ],
)
def test_steps_that_lead_nobody_knows_where(tmp_path, body, message):
    with pytest.raises(KrlError, match=message):
        read(tmp_path, body)


def test_steps_along_the_tool(tmp_path):
    """By SciPy's rotations."""
    at, step = [10.0, 20.0, 30.0, 25.0, -40.0, 160.0], [3.0, -2.0, 50.0]
    pose = ",".join(f"{n} {v}" for n, v in zip("XYZABC", at, strict=True))
    program = read(tmp_path, f"LIN {{{pose}}}\nLIN_REL {{X 3,Y -2,Z 50}} C_DIS #TOOL\nPTP_REL {{Z -50}} #TOOL")
    turn = Rotation.from_euler("ZYX", at[3:], degrees=True)
    assert program.pose[1].tolist() == pytest.approx([*(at[:3] + turn.apply(step)), *at[3:]], abs=1e-9)
    assert program.pose[2].tolist() == pytest.approx([*(at[:3] + turn.apply([3, -2, 0])), *at[3:]], abs=1e-9)
    assert program.blend[1] == Blend.DISTANCE and int(program.kind[2]) == Motion.PTP_POSE


def test_from_where_the_robot_stands(tmp_path):
    """A program that asks waits until the robot is there: nothing is rounded off before it."""
    body = P0 + "LIN {X 5} C_DIS\nQ=$POS_ACT\nQ.Z=Q.Z+100\nLIN Q C_DIS\nLIN {X 9} C_DIS\nR=$POS_ACT.X+1\nLIN {X R}\n"
    program = read(
        tmp_path, body + "PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nA=$AXIS_ACT\nA.A6=A.A6-7\nPTP A\nPTP $AXIS_ACT"
    )
    assert program.pose[:5, 0].tolist() == [1, 5, 5, 9, 10] and program.pose[:5, 2].tolist() == [3, 3, 103, 103, 103]
    assert program.blend[:5].tolist() == [0, 0, Blend.DISTANCE, 0, 0]
    assert program.axes[-1].tolist() == [1, 2, 3, 4, 5, -1] and program.external[:, 0].tolist() == [7] * len(program)
    assert codes(program) == ["null-motion"]


def test_messages_of_the_controller_move_nothing(tmp_path):
    body = f'{P0}MsgNotify("hello")\nA=1\nIF $IN[7]==TRUE THEN\nmsgdialog(A,"gone?")\nWAIT FOR $IN[7]==FALSE\nHALT\nENDIF\n'
    program = read(tmp_path, body + "LIN {X 4}")
    assert codes(program) == ["block-skipped"] and len(program) == 2
    with pytest.raises(KrlError, match="X has no number"):
        read(tmp_path, body + "LIN {X A}")  # what the operator answers
    with pytest.raises(KrlError, match="IF whose course"):
        read(tmp_path, body + "END\nDEF MSGDIALOG (A:OUT, B:IN)\nLIN {X 50}")  # a routine of the program's own


def test_inline_forms_of_the_spline_kind(tmp_path):
    data = (
        'DECL FDAT FP1={TOOL_NO 2,BASE_NO 3,IPO_FRAME #BASE,POINT2[] " "}\nDECL LDAT LCPDAT1={VEL 2,ACC 100,APO_DIST 7,'
        "ORI_TYP #VAR}\nDECL PDAT PDEFAULT={VEL 100,ACC 100,APO_DIST 100}\n"
        "DECL FRAME TOOL_DATA[2]\nTOOL_DATA[2]={X 1,Y 2,Z 3,A 0,B 0,C 0}\nDECL FRAME BASE_DATA[3]\n"
        "BASE_DATA[3]={X 4,Y 5,Z 6,A 0,B 0,C 0}"
    )
    form = "$TOOL = STOOL2(FP1), $BASE = SBASE(FP1.BASE_NO), $IPO_MODE = SIPO_MODE(FP1.IPO_FRAME), $LOAD = SLOAD(FP1.TOOL_NO), "
    ptp = f"WITH $VEL_AXIS[1] = SVEL_JOINT(50.0), {form}$ACC_AXIS[1] = SACC_JOINT(PDEFAULT), $APO = SAPO_PTP(PDEFAULT)"
    line = f"WITH $VEL = SVEL_CP(0.5, , LCPDAT1), {form}$ACC = SACC_CP(LCPDAT1), $ORI_TYPE = SORI_TYP(LCPDAT1), "
    line += "$APO = SAPO(LCPDAT1), $JERK = SJERK(LCPDAT1), $COLLMON_TOL_PRO[1] = USE_CM_PRO_VALUES(0) C_SPL"
    program = read(
        tmp_path,
        f"$VEL.CP=0.1\nSPTP {{A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}} {ptp}\nSLIN {{X 1,Y 2,Z 3,A 4,B 5,C 6}} {line}\n"
        "LIN {X 3,Y 2,Z 3,A 4,B 5,C 6}",
        data,
    )
    assert program.speed.tolist() == [0, 0.5, 0.1] and program.blend_mm[1] == 7 and np.isnan(program.blend_mm[2])
    tools, bases = (
        [f.xyzabc[:3].tolist() for f in frames]
        for frames in ([program.tools[k] for k in program.tool], [program.bases[k] for k in program.base])
    )
    assert tools[:2] == [[1, 2, 3]] * 2 and bases[:2] == [[4, 5, 6]] * 2 and np.isnan([*tools[2], *bases[2]]).all()
    assert set(codes(program)) == {"with-left-out"}
    home = "SPTP XHOME WITH $TOOL = STOOL2(FHOME), $BASE = SBASE(FHOME.BASE_NO)\n"  # which only the controller knows
    chain = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {X 7,Y 8,Z 9,A 0,B 0,C 0})"
    moving = f"SLIN {{X 1,Y 2,Z 3,A 4,B 5,C 6}} WITH $BASE = {chain}"
    program = read(tmp_path, home + moving, data)
    assert "home-unknown" in codes(program) and len(program) == 1  # no motion that is read uses FHOME's tool
    frame = program.bases[program.base[0]]
    assert frame.kind is FrameKind.MECHANISM and frame.xyzabc[:3].tolist() == [7, 8, 9]


def test_a_config_that_can_not_be_read_is_left_out(tmp_path):
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG\nDECL INT ?\nENDDAT\n")
    assert "config-unread" in codes(read(tmp_path, P0))


def test_called_parts_and_waits(tmp_path):
    program = read(
        tmp_path,
        f"EXT PART_1 ( )\nWAIT SEC 0.5\n PART_1 ( )\nWAIT SEC 2\nINNER(5)\nRETURN\n{P0}",
        PART_1=f"DEF PART_1 ( )\nWAIT SEC 1\n{P0}$VEL.CP = 0.5\nEND\n",
        other="not read",
    )
    assert len(program) == 1 and program.wait.tolist() == [1.5] and program.final_wait == 2.0
    assert program.files == ("P.src", "PART_1.SRC") and program.file.tolist() == [1] and program.line.tolist() == [3]
    assert program.speed.tolist() == [0.01] and codes(program) == ["call-unknown"]


def test_local_routine_with_a_parameter(tmp_path):
    program = read(tmp_path, f"{P0}UP (12.5)\nEND\nDEF UP (H:IN)\nLIN {{Z H}}")
    assert program.pose[1].tolist() == [1, 2, 12.5, 4, 5, 6]


def test_branches_whose_course_is_known_or_harmless(tmp_path):
    program = read(
        tmp_path,
        f"IF 1 > 2 THEN\nLIN {{X 99}}\nELSE\n{P0}ENDIF\n"
        f"IF $IN[3] THEN\n$OUT[1]=TRUE\nHALT\nENDIF\nWHILE FALSE\n{P0}ENDWHILE",
    )
    assert len(program) == 1 and codes(program) == ["block-skipped"]


def test_missing_external_axis_keeps_its_value_and_is_unknown_before(tmp_path):
    program = read(
        tmp_path, "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\nLIN {E6POS: X 1,Y 2,Z 3,A 4,B 5,C 6,E2 5}\n" + "LIN {X 5}\n" * 3
    )
    assert program.external_names == ("E2",)
    assert np.array_equal(program.external[:, 0], [np.nan, 5, 5, 5, 5], equal_nan=True)
    assert program.pose[:, 0].tolist() == [1, 1, 5, 5, 5]


def test_a_lone_carriage_return_ends_a_comment(tmp_path):
    program = read(tmp_path, "; remark\rLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}")
    assert len(program) == 1


def test_relative_motions_of_the_spline_kind_go_where_their_twins_go(tmp_path):
    steps = "LIN_REL {X 10,E1 1} C_DIS\nLIN_REL {X 3,Y -2,Z 50} #TOOL\nPTP_REL {Y 1}\n"
    twin = read(tmp_path, P0 + steps)
    program = read(tmp_path, P0 + steps.replace("LIN_", "SLIN_").replace("PTP_", "SPTP_").replace("C_DIS", "C_SPL"))
    np.testing.assert_array_equal(program.pose, twin.pose)
    np.testing.assert_array_equal(program.kind, twin.kind)


def test_numbers_are_those_of_float(tmp_path):
    text = "0.1 123456789012345678901234567890 1e-3 .5 7. -0.000".split()
    program = read(tmp_path, "LIN {" + ",".join(f"{n} {v}" for n, v in zip("XYZABC", text, strict=True)) + "}")
    assert program.pose[0].tolist() == [float(v) for v in text] and np.signbit(program.pose[0, 5])


# --- what is refused, and where


@pytest.mark.parametrize(
    ("body", "line", "message"),
    [
        ("LIN XP7", 3, "XP7.*dat file"),
        ("LIN {X 1,Y 2,Z 3}", 3, "no A and none is known"),
        ("PTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\nLIN {X 1}", 4, "no Y and none is known"),
        (P0 + "PTP {A1 3}", 4, "gives no A2"),
        ("LIN {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}", 3, "axis values"),
        ("LIN {X 1,X 2,Y 2,Z 3,A 4,B 5,C 6}", 3, "twice"),
        ("LIN {X 1,Y 2,Z 3,A 4,B 5,C 6,E7 1}", 3, "component E7"),
        ("LIN {X 1,Y Q,Z 3,A 4,B 5,C 6}", 3, "Y has no number"),
        ("LIN {X 1,Y 1e999,Z 3,A 4,B 5,C 6}", 3, "Y has no number"),
        ("LIN {X 1,Y 2,Z 3,A 4,B 5,C 6} C_DIX", 3, "C_DIX"),
        ("LIN {X 1 Y 2}", 3, "missing"),
        ("LIN_REL {X 1}", 3, "from a place that the program doesn't hold"),
        ("CIRC_REL {X 1},{Y 1}", 3, "CIRC_REL is not read"),
        ("PTP_SPLINE\nSPTP XP1\nENDSPLINE", 3, "PTP_SPLINE is not read"),
        ("SLIN XP1 WITH $VEL = 1", 3, "WITH .VEL without a speed"),
        ("GOTO A", 3, "GOTO"),
        ("IF $IN[1] THEN\n" + P0 + "ENDIF", 3, "IF whose course"),
        ("IF $IN[1] THEN\n$BASE = $NULLFRAME\nENDIF\n", 3, "IF whose course"),
        ("LOOP\nUNKNOWN_CALL ( )\nENDLOOP", 3, "LOOP without EXIT"),
        ("FOR I = 1 TO N\n" + P0 + "ENDFOR", 3, "FOR whose course"),
        ("FOR I = 1 TO 99999999\nHALT\nENDFOR", 4, "runs away|calls and passes"),
        ("P ( )", 3, "deep"),
        ("$VEL.CP = 0", 3, "VEL.CP"),
        ("$vel.cp = -1", 3, "VEL.CP"),
        ("X = 1 / 0", 3, "zero"),
        ("X = " + "(" * 300 + "1", 3, "deeply"),
        ("X = @1", 3, "not KRL"),
        ("ENDIF", 3, "beginning"),
        ("IF TRUE THEN", 3, "no end"),
        ("END\n" + P0 + "DEF Q ( )", 4, "outside of DEF"),
        ("END\nX = 1\nDEF Q ( )", 4, "outside of DEF"),
    ],
)
def test_refusals_name_file_and_line(tmp_path, body, line, message):
    with pytest.raises(KrlError, match=message) as caught:
        read(tmp_path, body)
    assert caught.value.path == tmp_path / "P.src" and abs(caught.value.line - line) <= (message.startswith("runs"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no DEF"),
        (b"DEF P ( )\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\nLIN {X 1,Y", "END"),
        (b"\x7fELF\x00\x01", "binary"),
        (b"GOTO/1,2,3\n", "no DEF"),
        (b"DEF P ( )\nEND\nEND\n", "without a DEF"),
        (b"DEF P ( )\nDEF Q ( )\nEND\n", "no END"),
    ],
)
def test_files_that_are_no_programs(tmp_path, content, message):
    (tmp_path / "P.src").write_bytes(content)
    with pytest.raises(KrlError, match=message):
        read_krl(tmp_path / "P.src")
    with pytest.raises(KrlError, match="can't be read"):
        read_krl(tmp_path / "absent.src")


def test_a_cut_off_data_list(tmp_path):
    (tmp_path / "P.src").write_text("DEF P ( )\nEND\n")
    (tmp_path / "P.dat").write_text("DEFDAT P\nDECL E6POS XP1={X 1")
    with pytest.raises(KrlError, match=r"P\.dat:2"):
        read_krl(tmp_path / "P.src")


def test_calls_stay_in_the_folder(tmp_path):
    inside, outside = tmp_path / "in", tmp_path / "out"
    inside.mkdir(), outside.mkdir()
    (outside / "EVIL.src").write_text(f"DEF EVIL ( )\n{P0}END\n")
    (inside / "EVIL.src").symlink_to(outside / "EVIL.src")
    program = read(inside, "EVIL ( )")
    assert len(program) == 0 and codes(program) == ["call-unknown"]
    program = read(inside, "../out/EVIL ( )")
    assert len(program) == 0 and codes(program) == ["not-understood"]


def test_calls_that_multiply_end(tmp_path):
    body = "".join(f"DEF R{k} ( )\nR{k + 1} ( )\nR{k + 1} ( )\nR{k + 1} ( )\nEND\n" for k in range(17))
    with pytest.raises(KrlError, match=r"runs away|calls and passes"):
        read(tmp_path, "R0 ( )\nEND\n" + body + "DEF R17 ( )\nHALT")


def test_home_and_unset_speed_are_findings(tmp_path):
    (tmp_path / "P.src").write_text(f"DEF P ( )\nPTP XHOME\n{P0}SOMETHING ODD HERE\nEND\n")
    program = read_krl(tmp_path / "P.src")
    assert codes(program) == ["home-unknown", "speed-unknown", "not-understood"]
    assert len(program) == 1 and math.isnan(program.speed[0]) and program.bases[0].text == "never set"


# --- independence


ROOMS = ("camrob.program.", "camrob.languages.")


def reached(name: str) -> set[str]:
    """Modules of programs and languages that a module imports, through others too."""
    seen, left = set(), [name]
    while left:
        module = left.pop()
        if module in seen:
            continue
        seen.add(module)
        for node in ast.walk(ast.parse((ROOT / (module.replace(".", "/") + ".py")).read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(ROOMS):
                left.append(node.module or "")
    return seen


def test_reader_and_writer_share_nothing():
    reader, writer = reached("camrob.languages.krl.reader.read_krl"), reached("camrob.languages.krl.writer.write_krl")
    assert reader & writer == {"camrob.program.motion"}  # what kinds of motion there are is the protocol's
    assert "camrob.languages.krl.writer.body" in writer and "camrob.languages.krl.reader.machine" in reader


# --- motions of the spline kind, GOTO


def test_spline_motions_are_read_as_their_plain_twins(tmp_path):
    plain = f"PTP {{X 1,Y 2,Z 3,A 4,B 5,C 6}}\n{P0}CIRC {{X 9,Y 9,Z 3}},{{X 9,Y 2,Z 3}} C_DIS\nLIN {{X 3}}\nLIN {{X 4}}"
    first = read(tmp_path, plain)
    text = plain.replace("PTP", "SPTP").replace("CIRC", "SCIRC").replace("LIN {X 1", "SLIN {X 1")
    second = read(tmp_path, text.replace("LIN {X 3}\nLIN {X 4}", "SPLINE\nSLIN {X 3}\nSPL {X 4}\nENDSPLINE"))
    assert np.array_equal(first.pose, second.pose, equal_nan=True) and np.array_equal(first.kind, second.kind)
    assert codes(first) == [] and codes(second) == ["spline-as-line"]


def test_with_sets_what_is_read_and_for_one_motion(tmp_path):
    cut = "SLIN {X 3} WITH $VEL.CP = 0.2 C_SPL\nSLIN {X 4} C_SPL\nSLIN {X 5} WITH $VEL = {CP 0.3}\nLIN {X 6} C_DIS"
    made = read(tmp_path, f"$VEL.CP = 0.1\n{P0}SPLINE WITH $VEL.CP = 1\nSLIN {{X 3}}\nENDSPLINE\n{cut}")
    assert made.speed.tolist()[-5:] == [1, 0.2, 0.1, 0.3, 0.1] and made.blend.tolist()[-5:] == [0, 2, 2, 0, 2]
    for line, word in (
        ("SPLINE WITH $CIRC_MODE = 1\nSLIN {X 3}\nENDSPLINE", "WITH"),
        ("SPLINE WITH $VEL.CP = $VEL_ACT\nSLIN {X 3}\nENDSPLINE", "WITH"),
        ("SPLINE\nSLIN {X 3}\nENDSPLINE C_SPL", "rounding behind ENDSPLINE"),
        ("SPLINE #X\nSLIN {X 3}\nENDSPLINE", "SPLINE #X"),
        ("SLIN {X 3} WITH $VEL.CP = 1, $IPO_MODE = #TCP", "stands by itself"),
        ("SLIN {X 3} WITH $VEL = SVEL_CP(V, , LCPDAT1)", "without a speed"),
        ("SLIN {X 3} WITH $VEL.CP = 1, $ORI_TYPE = #CONSTANT", "only #VAR"),
        ("SLIN {X 3} WITH $VEL.CP = 0", "WITH"),
        ("SLIN {X 3} C_VEL", "C_VEL"),
        ("LIN {X 3} C_SPL", "C_SPL"),
    ):
        with pytest.raises(KrlError, match=word):
            read(tmp_path, P0 + line)


def test_usual_lines_of_splines_are_read_like_those_one_by_one(tmp_path):
    lines = [
        f"SLIN {{E6POS: X {x}.5,Y 2,Z -3.25,A 4,B 5,C 6,E1 {x}}} {word}"
        for x in (1, 2)
        for word in ("", "C_SPL", "C_DIS")
    ]
    bulk = read(tmp_path, P0 + "\n".join(lines))
    single = read(tmp_path, P0 + "\n".join(line.replace("E6POS", "E6POS ").replace("X ", "X  +") for line in lines))
    assert np.array_equal(bulk.pose, single.pose) and bulk.blend.tolist() == single.blend.tolist() == [
        0,
        *[0, 2, 2] * 2,
    ]


def test_the_initialisation_of_a_program_on_its_path(tmp_path):
    begin = "CONTINUE\nIF NOT $ON_PATH THEN\n{}BAS (#INITMOV,0 )\nENDIF\n"
    made = read(tmp_path, begin.format("INTERRUPT ON 3\n") + P0)
    assert len(made) == 1 and [a.text.partition(" ")[0] for a in made.actions][:3] == ["CONTINUE", "INTERRUPT", "BAS"]
    with pytest.raises(KrlError, match="course is not known"):
        read(tmp_path, begin.format("LIN {X 3}\n") + P0)


def test_goto_goes_on_at_its_mark(tmp_path):
    over = read(tmp_path, f"{P0}GOTO THERE\nLIN {{X 2}}\nTHERE:\nLIN {{X 3}}\nGOTO ENDS\nLIN {{X 4}}\nENDS :")
    assert over.pose[:, 0].tolist() == [1, 3]
    out = read(tmp_path, f"{P0}IF TRUE THEN\nLIN {{X 2}}\nGOTO THERE\nENDIF\nLIN {{X 3}}\nTHERE:\nLIN {{X 4}}")
    assert out.pose[:, 0].tolist() == [1, 2, 4]
    back = f"DECL INT I\nI = 0\nAGAIN:\nI = I + 1\n{P0}IF I < 3 THEN\nGOTO AGAIN\nENDIF"
    assert len(read(tmp_path, back)) == 3


@pytest.mark.parametrize(
    "body",
    [
        "AGAIN:\nHALT\nGOTO AGAIN",
        f"GOTO IN\nIF TRUE THEN\nIN:\n{P0}ENDIF",
        f"GOTO A\n{P0}A:\nA:",
        f"GOTO A\n{P0}END\nDEF Q ( )\nA:",
    ],
)
def test_a_goto_that_leads_nowhere_or_back_without_end_is_refused(tmp_path, body):
    with pytest.raises(KrlError, match="GOTO"):
        read(tmp_path, body)
