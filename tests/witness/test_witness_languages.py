"""Siemens' and Heidenhain's plain programs as the second opinion reads them, held to paths by hand; and where it ends."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.witness.cl.offsets import OFFSET
from camrob.witness.cl.teller import UNREAD
from camrob.witness.happenings import Kind, Story, Way

SIEMENS = "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\nN10 G90 G17 G710 G94\nN20 T1 D1 M6\nN30 S5000 M3 (no comment\n"
SIEMENS = SIEMENS.replace(" (no comment", " ; a comment")
UP = "G0 X0 Y0 Z50\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 3 Z S5000\n2 L X+0 Y+0 Z+50 R0 FMAX M3\n"


def _mm(story: Story) -> np.ndarray:
    return np.asarray(story.path.tip) * 1e3


def _siemens(tell, body: str, **options) -> Story:
    return tell(SIEMENS + UP + body + "M30\n", "a.mpf", **options)


def _klartext(tell, body: str, **options) -> Story:
    return tell(KLARTEXT + body + "20 M30\n21 END PGM A MM\n", "a.h", **options)


def test_siemens_words(tell) -> None:
    story = _siemens(
        tell,
        'MSG("Z1=5; X")\nSOFT FFWON G642\nG1 X=10 Z=-1.5 F600\nX20 M8\nG2 X30 Y10 CR=10\nG3 X30 Y10 I10 J0 TURN=1\nG4 F0.5\n'
        "TRANS X5\nG0 X0 Y=0\nATRANS Y2 X1\nG1 X0 Y0 M9\nTRANS\nG0 Z50\nSUPA G0 Z300 D0\n",
    )
    assert story.complete and story.dialect == "gcode"
    wanted = [
        [0, 0, 50],
        [10, 0, -1.5],
        [20, 0, -1.5],
        [30, 10, -1.5],
        [30, 10, -1.5],
        [5, 0, -1.5],
        [6, 2, -1.5],
        [6, 2, 50],
    ]
    np.testing.assert_allclose(_mm(story), wanted, atol=1e-9)
    np.testing.assert_allclose(story.path.center[3] * 1e3, [30, 0, -1.5], atol=1e-9)
    assert story.path.angle[3:5] == pytest.approx([np.pi / 2, 4 * np.pi])
    assert story.way.tolist() == [Way.RAPID, *[Way.FEED] * 4, Way.RAPID, Way.FEED, Way.RAPID]
    assert [(e.kind, e.before, e.value) for e in story.events if e.kind is not Kind.COOLANT_OFF] == [
        (Kind.TOOL, 0, 1),
        (Kind.SPINDLE_ON, 0, 5000),
        (Kind.COOLANT_ON, 2, 0),
        (Kind.DWELL, 5, 0.5),
    ]


def test_siemens_vectors(tell) -> None:
    story = _siemens(
        tell,
        "TRAORI\nG1 X10 A3=3 B3=0 C3=4 F600\nA3=0 B3=-3 C3=4\nX20\nG0 Z60\nTRAFOOF\nSUPA Z0\n".replace(
            "SUPA", "G0 SUPA"
        ),
    )
    assert story.complete
    np.testing.assert_allclose(_mm(story), [[0, 0, 50], [10, 0, 50], [10, 0, 50], [20, 0, 50], [20, 0, 60]], atol=1e-9)
    lean = [0, -0.6, 0.8]
    np.testing.assert_allclose(story.path.axis, [[0, 0, 1], [0.6, 0, 0.8], lean, lean, lean], atol=1e-12)


def test_klartext_lines_and_arcs(tell) -> None:
    story = _klartext(
        tell,
        "3 BLK FORM 0.1 Z X+0 Y+0 Z-9\n4 L Z-1 F200 M8\n5 L IX+10 F MAX\n6 CC X+10 Y+5\n7 C X+15 Y+5 DR+ F300\n"
        "8 CR X+20 Y+10 R+5 DR-\n9 CC IX-20 Y+10\n".replace("CC IX-20", "CC X+0")
        + "10 CP IPA+405 IZ-2 DR+\n11 LP PR+30 PA+90\n12 CYCL DEF 9.0 DWELL TIME\n13 CYCL DEF 9.1 DWELL 1.5\n"
        "14 CYCL DEF 7.0 DATUM SHIFT\n15 CYCL DEF 7.1 X+100\n16 L X+1 Y+2 M9\n17 STOP M5\n",
    )
    assert story.complete
    half = 20 / np.sqrt(2)
    wanted = [
        [0, 0, 50],
        [0, 0, -1],
        [10, 0, -1],
        [15, 5, -1],
        [20, 10, -1],
        [half, 10 + half, -3],
        [0, 40, -3],
        [101, 2, -3],
    ]
    np.testing.assert_allclose(_mm(story), wanted, atol=1e-6)
    np.testing.assert_allclose(story.path.center[3:6, :2] * 1e3, [[10, 5], [20, 5], [0, 10]], atol=1e-6)
    assert story.path.angle[3:6] == pytest.approx(np.radians([90, 90, 405]))
    assert story.path.normal[3:6, 2].tolist() == [1, -1, 1]
    assert story.way.tolist()[:3] == [Way.RAPID, Way.FEED, Way.RAPID]
    assert story.feed[[1, 3, 6]] * 60_000 == pytest.approx([200, 300, 300])
    assert [(e.kind, e.value) for e in story.events if e.kind in (Kind.TOOL, Kind.DWELL)] == [
        (Kind.TOOL, 3),
        (Kind.DWELL, 1.5),
    ]


def test_klartext_vectors(tell) -> None:
    story = _klartext(
        tell,
        "3 M128\n4 L X+0 Y+0 Z+20 FMAX\n5 LN X+5 Y+0 Z+0 NX0 NY0 NZ1 TX+0.6 TY0 TZ0.8 F500\n6 LN X+9 Y+1 Z+0 TX0 TY0 TZ1\n"
        "7 L Z+50 FMAX\n8 M129\n",
    )
    assert story.complete
    np.testing.assert_allclose(_mm(story)[1:], [[0, 0, 20], [5, 0, 0], [9, 1, 0], [9, 1, 50]], atol=1e-9)
    np.testing.assert_allclose(story.path.axis[2:4], [[0.6, 0, 0.8], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize(
    "row",
    [
        "G1 X=R1 F9",
        "IF R1>2 GOTOF OUT",
        "CYCLE83(5,0,2,-9,,-3,,0,0.5,0,1,1)",
        'CYCLE800(0,"T",0,192,0,0,0,9,0,0)',
        "CYCLE800(0,,1,57)",
        "MCALL HOLES1(0)",
        "CYCLE82(5,0,2,-9,,-3)",
        "CYCLE81(5,0,2,R1)",
        "CYCLE81(5,1,2,-9)",
        "ROT X30",
        "G1 X3 C=DC(180)",
        "G3 X1 I=AC(5) J0",
        "CIP X1 Y1 K1=5 I1=2 J1=3",
        "POCKET",
        "G33 Z-5 K1",
        "TRANS X=R1",
        "G4 S3",
        "A3=1 B3=0 C3=1 G1 X1 F9",
        "G500",
        "MIRROR Z0",
        "AROT Z5 X1",
        "SCALE X2",
    ],
)
def test_what_ends_the_reading_of_siemens(tell, row: str) -> None:
    story = _siemens(tell, f"G1 Z0 F600\n{row}\nG1 X99 F9\n")
    assert [(gap.first_line, gap.last_line) for gap in story.gaps] == [(8, 10)] and story.gaps[0].text.startswith(
        UNREAD
    )
    assert _mm(story)[-1].tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    "row",
    [
        "4 L X+Q1",
        "4 CALL LBL 1",
        "4 PLANE POINTS P1X+0",
        "4 CYCL DEF 203 DRILLING",
        "4 CYCL DEF 11.1 SCL 0.5",
        "4 CYCL DEF 8.1 Z",
        "4 CYCL CALL",
        "4 LN X+5 NX0 NY0 NZ1",
        '4 TOOL CALL "MILL" Z S9',
        "4 TOOL CALL 2 Z S9 DR+0.1",
        "4 TOOL CALL 2 Y S9",
        "4 APPR LCT X+1 Y+1 R2",
        "4 L X+5 R+",
        "4 L X+5 M97",
        "4 CC X+3",
        "4 L X+5 F AUTO",
        "4 CALL PGM B",
    ],
)
def test_what_ends_the_reading_of_heidenhain(tell, row: str) -> None:
    story = _klartext(tell, f"3 L Z+0 F600\n{row}\n5 L X+99\n")
    assert [(gap.first_line, gap.last_line) for gap in story.gaps] == [(5, 8)] and story.gaps[0].text.startswith(UNREAD)
    assert _mm(story)[-1].tolist() == [0, 0, 0]


@pytest.mark.parametrize(("read", "body"), [(_siemens, "G41 G1 X5 F9\n"), (_klartext, "3 L X+5 RL F9\n")])
def test_an_offset_path_is_one_that_nobody_reads(tell, read, body: str) -> None:
    assert OFFSET in read(tell, body).gaps[0].text
    assert read(tell, body, wear=True).complete
    plain = body.replace("G41", "G40").replace("RL", "R0")
    assert read(tell, plain).complete


def _turned(order: str, *degrees: float) -> np.ndarray:
    return Rotation.from_euler(order, degrees, degrees=True).as_matrix()


@pytest.mark.parametrize(("mode", "order"), [(57, "XYZ"), (27, "ZYX"), (39, "ZXY")])
def test_siemens_planes_against_scipy(tell, mode: int, order: str) -> None:
    story = _siemens(
        tell,
        f'CYCLE800(1,"TC1",0,{mode},10,20,30,12,-8,25,1,2,3,-1)\nG0 X0 Y0 Z9\nG1 Z0 F600\nX5 Y6\n'
        "G0 Z40\nCYCLE800()\nG0 A0 C0\nG0 X0 Y0 Z80\n",
    )
    turned = _turned(order, 12, -8, 25)
    origin = np.array([10, 20, 30]) + turned @ [1, 2, 3]
    wanted = [origin + turned @ p for p in ([0, 0, 9], [0, 0, 0], [5, 6, 0], [5, 6, 40])]
    assert story.complete
    np.testing.assert_allclose(_mm(story)[1:], [*wanted, [0, 0, 80]], atol=1e-9)
    np.testing.assert_allclose(story.path.axis[1:5], np.tile(turned[:, 2], (4, 1)), atol=1e-12)
    assert story.path.axis[5].tolist() == [0, 0, 1]


def test_klartext_planes_against_scipy(tell) -> None:
    story = _klartext(
        tell,
        "3 CYCL DEF 7.1 X+10\n4 CYCL DEF 7.2 Z+5\n5 PLANE SPATIAL SPA+12 SPB-8 SPC+25 MOVE DIST50 FMAX\n6 L X+0 Y+0 Z+9 FMAX\n"
        "7 L Z+0 F100\n8 PLANE RESET TURN FMAX\n9 L X+0 Y+0 Z+80 FMAX\n",
    )
    turned = Rotation.from_euler("xyz", [12, -8, 25], degrees=True).as_matrix()  # about fixed axes
    assert story.complete
    np.testing.assert_allclose(_mm(story)[1:], [turned @ [0, 0, 9] + [10, 0, 5], [10, 0, 5], [10, 0, 85]], atol=1e-9)
    np.testing.assert_allclose(story.path.axis[1:3], [turned[:, 2]] * 2, atol=1e-12)


def test_siemens_relative_and_absolute_words(tell) -> None:
    story = _siemens(
        tell,
        "G1 X10 F600\nX=IC(5) Y=IC(2)\nG91 X=AC(4) Y=AC(2)\nX1\nG90 G3 X4 Y3 I=AC(4) J=AC(2)\nG1 X=AC(9)\n".replace(
            "G3 X4 Y3", "G3 X=AC(4) Y=AC(3)"
        ),
    )
    assert story.complete
    np.testing.assert_allclose(_mm(story)[1:, :2], [[10, 0], [15, 2], [4, 2], [5, 2], [4, 3], [9, 3]], atol=1e-9)


def test_siemens_holes(tell) -> None:
    story = _siemens(
        tell,
        "F120\nMCALL CYCLE82(20,1,2,-5,,0.5)\nX10 Y5\nX20\nMCALL\nCYCLE85(20,0,2,,3,0,60,90)\nCYCLE81(20,0,2,-4)\nX0\n",
    )
    assert story.complete
    one = [[10, 5, 50], [10, 5, 3], [10, 5, -5], [10, 5, 20], [20, 5, 20], [20, 5, 3], [20, 5, -5], [20, 5, 20]]
    two = [[20, 5, 2], [20, 5, -3], [20, 5, 2], [20, 5, 20], [20, 5, 2], [20, 5, -4], [20, 5, 20], [0, 5, 20]]
    np.testing.assert_allclose(_mm(story)[1:], [*one, *two], atol=1e-9)
    feeds = story.feed[np.isfinite(story.feed)] * 60_000
    assert feeds == pytest.approx([120, 120, 60, 90, 120])
    assert [(e.before, e.value) for e in story.events if e.kind is Kind.DWELL] == [(4, 0.5), (8, 0.5)]


def test_klartext_holes(tell) -> None:
    base = "Q200=2 Q201=-6 Q206=120 Q203=+1 Q204=20"
    story = _klartext(
        tell,
        f"3 CYCL DEF 200 DRILLING {base} Q202=4 Q210=0 Q211=0.2\n4 L X+5 FMAX M99\n5 CYCL DEF 201 REAM {base} Q208=0 Q211=0\n"
        f"6 L X+9 FMAX\n7 CYCL CALL M8\n8 CYCL DEF 240 C {base} Q343=0 Q211=0\n9 L X+11 FMAX M99\n",
    )
    assert story.complete
    rows = [
        [5, 50],
        [5, 3],
        [5, -5],
        [5, 21],
        [9, 21],
        [9, 3],
        [9, -5],
        [9, 3],
        [9, 21],
        [11, 21],
        [11, 3],
        [11, -5],
        [11, 21],
    ]
    np.testing.assert_allclose(_mm(story)[1:][:, [0, 2]], rows, atol=1e-9)
    (most,) = story.pecks.values()
    assert (most.first * 1e3, most.others * 1e3, most.out) == pytest.approx((6, 4, True))


def _tips(story: Story) -> list[list[float]]:
    return [[round(float(v) * 1e3, 6) + 0.0 for v in tip] for tip in story.path.tip]


def test_siemens_values_without_jumps(tell) -> None:
    """Named and computed values, the ends worked out by hand; a jump to nowhere ends the reading."""
    body = (
        "R1=12 R2=20\nDEF REAL W=3, V\nV=W*2+R1\nG0 X=R2 Y0 Z20\nG1 Z=-W F=R1*10+80\nX=R2*COS(60) Y=R2*SIN(30) - 1\n"
        "X=IC(R1/4) Y=IC(-V)\n"
    )
    story = _siemens(tell, body)
    assert _tips(story)[-4:] == [[20, 0, 20], [20, 0, -3], [10, 9, -3], [13, -9, -3]]
    assert not story.gaps and story.feed[-2] == pytest.approx(0.2 / 60)
    for last in ("IF R1>3 GOTOF E1", "X=R7", "X=$AA_IM[X]", "X=R1/0", "WHILE R1<3"):
        assert _siemens(tell, body + last + "\nX99\n").gaps


def test_klartext_values_without_jumps(tell) -> None:
    body = "1 FN 0: Q1 = +20\n2 Q2 = Q1 / 2 + 1\n3 Q3 = Q1 * COS 60\n3 L Z+0 F600\n4 L X+Q1 Y-Q3\n5 L X-Q2 IY+Q2 FQ1\n"
    story = _klartext(tell, body)
    assert (
        _tips(story)[-2:] == [[20, -10, 0], [-11, 1, 0]]
        and not story.gaps
        and story.feed[-1] == pytest.approx(0.02 / 60)
    )
    for last in (
        "6 FN 9: IF +Q1 EQU +3 GOTO LBL Q4",
        "6 L X+Q9",
        "6 Q4 = Q1 % 3",
        "6 Q101 = 5",
        "6 FN 18: SYSREAD Q1 = ID1",
    ):
        assert _klartext(tell, body + last + "\n7 L X+99\n").gaps
