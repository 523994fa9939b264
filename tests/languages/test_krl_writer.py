from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from krl_sample import CONTROLLER, OWN, assert_same, make_program, read_back, small_program, written

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import CellError, JobError
from camrob.findings import Finding
from camrob.languages.krl import LANGUAGE, rounding
from camrob.languages.krl.krl_text import comment_text, krl_name
from camrob.languages.krl.writer import body
from camrob.languages.krl.writer.lines import LineBlock, format_lines
from camrob.languages.krl.writer.write_krl import iter_krl
from camrob.program.motion import Motion
from camrob.program.printed import fixed_decimals
from camrob.program.program import ProgramEvent, ProgramEventKind

GOLDEN = Path(__file__).parents[1] / "golden"
LIN = Motion.LIN


def motions(content: bytes) -> list[str]:
    return [t for t in content.decode("ascii").split("\r\n") if t.startswith(("PTP", "LIN", "CIRC"))]


def test_small_program_is_the_golden_text():
    files = written(small_program())
    assert list(files) == ["Fluegel_3.src", "Fluegel_3.dat"]
    for name, content in files.items():
        assert content.decode("ascii") == (GOLDEN / name).read_bytes().decode("ascii"), name


def test_every_number_comes_back(tmp_path):
    program = small_program()
    read = read_back(written(program), tmp_path)
    assert_same(program, read)
    assert read.wait.tolist() == [0, 0, 0, 0, 0, 1.25, 0, 0, 0, 0]
    assert [t.xyzabc.tolist() for t in read.tools] == [program.tool.tolist()]
    assert [(b.kind.value, b.xyzabc.tolist()) for b in read.bases] == [("mechanism", program.base.tolist())]
    assert set(read.acceleration) == {2.0} and set(read.blend_mm) == {0.5}
    assert read.settings["advance"].value == 3 and read.settings["turning"].value == "#VAR"
    assert read.settings["turn_speed"].value == 200.0 and read.settings["roll_acceleration"].value == 400.0


def test_no_sign_on_zero_and_plain_lines():
    for content in written(small_program()).values():
        assert not re.search(rb"-0\.0+(?![0-9])", content)
        assert content.endswith(b"\r\n") and content.count(b"\r") == content.count(b"\n") == content.count(b"\r\n")
        assert max(map(len, content.split(b"\r\n"))) <= CONTROLLER.max_line_length


def test_one_mm_per_minute_stays_apart():
    speeds = np.array([0.0, *(np.arange(1, 60) / 60000)])
    program = make_program([Motion.PTP_AXES] + [LIN] * 59, speed=speeds)
    printed = re.findall(rb"\$VEL\.CP = (\S+)", written(program)["Fluegel_3.src"])
    assert len(set(printed)) == 59
    assert max(abs(float(t) - v) for t, v in zip(printed, speeds[1:], strict=True)) * 60000 <= 0.031


def test_speed_is_printed_only_when_it_changes():
    text = written(make_program([Motion.PTP_AXES] + [LIN] * 11))["Fluegel_3.src"].decode()
    assert len(re.findall(r"\$VEL\.CP", text)) == 4


def test_compiled_lines_are_the_formatted_ones():
    rng = np.random.default_rng(5)
    values = np.concatenate([rng.integers(-(10**9), 10**9, (200, 3)), rng.integers(-12, 12, (200, 3))], axis=1)
    kind = np.full(200, int(LIN), dtype=np.int8)
    approximate = rng.random(200) < 0.5
    speak = rng.random(200) < 0.3
    speed = rng.integers(1, 10**6, 200)
    block = LineBlock(kind, values, tuple("XYZABC"), (3, 3, 3, 4, 4, 4), speed, 6, speak, approximate)
    text, ends, longest = format_lines(block)
    expected, sizes = "", []
    for row in range(200):
        numbers = zip("XYZABC", values[row], [3] * 3 + [4] * 3, strict=True)
        parts = [f"{n} {fixed_decimals(v / 10.0**d, d)}" for n, v, d in numbers]
        line = f"LIN {{E6POS: {','.join(parts)}}}{' C_DIS' if approximate[row] else ''}\r\n"
        expected += (f"$VEL.CP = {speed[row] / 1e6:.6f}\r\n" if speak[row] else "") + line
        sizes.append(len(expected))
    assert text.decode() == expected
    assert ends.tolist() == sizes and longest == max(map(len, expected.split("\r\n")))


# --- rounding


def test_round_pose_keeps_rotations_and_the_sign_of_a_half_turn():
    pose = np.zeros((6, 6))
    pose[:, 3] = [179.99991, 179.99999, -179.99998, 179.9999, 180.00004, 540.0]
    pose[:, 5] = [-180.0, 180.0, 179.9999, 180.0, -0.00001, -359.99999]
    rounded, external = rounding.pose(pose, [[-0.00001, 370.12346]] * 6)
    assert rounded[:, 3].tolist() == [179.9999, 180.0, 180.0, 179.9999, 180.0, 180.0]
    assert rounded[:, 5].tolist() == [180.0, 180.0, 179.9999, 180.0, 0.0, 0.0]
    assert not np.signbit(rounded[:, 5]).any() and not np.signbit(external[:, 0]).any()
    assert external[0].tolist() == [0.0, 370.1235]


def test_unrounded_and_senseless_programs_are_refused():
    program = small_program()
    pose = program.pose.copy()
    pose[3, 0] += 1e-6
    with pytest.raises(ValueError, match=r"motion 3.*3 decimals"):
        written(dataclasses.replace(program, pose=pose))
    pose[3, 0] = np.nan
    with pytest.raises(ValueError, match="finite"):
        written(dataclasses.replace(program, pose=pose))
    with pytest.raises(ValueError, match="CIRC"):
        written(make_program([Motion.PTP_AXES, Motion.CIRC_VIA, LIN]))
    with pytest.raises(ValueError, match="speed"):
        written(make_program([LIN, LIN], speed=np.zeros(2)))
    with pytest.raises(ValueError, match="unknown"):
        written(make_program([LIN], events=(ProgramEvent(0, ProgramEventKind.HOOK, "$OUT[1] = TRUE"),)))
    with pytest.raises(ValueError, match="external"):
        written(dataclasses.replace(program, external_names=("E1", "E9")))
    for seconds in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="dwell before motion 1 is not a time"):
            written(make_program([LIN, LIN], events=(ProgramEvent(1, ProgramEventKind.DWELL, value=seconds),)))
    with pytest.raises(JobError, match="characters"):
        written(program, dataclasses.replace(CONTROLLER, max_line_length=150))


@pytest.mark.parametrize("chunk", [2, 3, 4, 5])
def test_motions_are_printed_and_measured_the_same_in_chunks_of_any_length(monkeypatch, chunk: int):
    """No chunk ends between the auxiliary point of a CIRC and its end: the line of both would look shorter than it is."""
    arc = [Motion.CIRC_VIA, Motion.CIRC_END]
    expected = written(make_program([Motion.PTP_AXES, *[LIN, *arc, *arc, LIN] * 3]))
    monkeypatch.setattr(body, "_CHUNK", chunk)
    assert written(make_program([Motion.PTP_AXES, *[LIN, *arc, *arc, LIN] * 3])) == expected
    for before in range(1, 6):
        program = make_program([Motion.PTP_AXES, *[LIN] * before, *arc, LIN])
        (longest,) = [len(line) for line in motions(written(program)["Fluegel_3.src"]) if line.startswith("CIRC")]
        with pytest.raises(JobError, match=f"gets {longest} characters"):
            written(program, dataclasses.replace(CONTROLLER, max_line_length=longest - 1))


# --- splitting


def cut(count: int, safe: list[int], max_lines: int, **changes):
    program = make_program([Motion.PTP_AXES, Motion.PTP_POSE] + [LIN] * (count - 2), safe=safe)
    return program, written(program, dataclasses.replace(CONTROLLER, **changes), max_lines=max_lines)


def test_split_at_safe_retracts(tmp_path):
    safe = [20, 31, 40, 55, 70, 88]
    program, files = cut(100, safe, 30)
    assert list(files)[:3] == ["Fluegel_3.src", "Fluegel_3.dat", "Fluegel_3_001.src"]
    main, parts = files["Fluegel_3.src"].decode(), [c for n, c in files.items() if "_00" in n]
    assert len(motions(main.encode())) == 2
    ends = 2 + np.cumsum([len(motions(c)) for c in parts])
    assert ends[-1] == 100 and set(ends[:-1] - 1) <= set(safe)
    assert max(len(motions(c)) for c in parts) <= 30
    lines = main.split("\r\n")
    at = lines.index("DEF Fluegel_3 ( )")
    names = [n.removesuffix(".src") for n in files if "_00" in n]
    assert lines[at + 1 : at + 1 + len(parts)] == [f"EXT {n} ( )" for n in names]
    assert [t for t in lines if t in [f"{n} ( )" for n in names]] == [f"{n} ( )" for n in names]
    for content in parts:
        assert not re.search(rb"BAS|PTP|\$ADVANCE|\$BASE|\$TOOL|\$ACC|\$APO|INI", content)
    read = read_back(files, tmp_path)
    assert_same(program, read)
    assert read.files == ("Fluegel_3.src", *(f"{n}.src" for n in names))


def test_split_by_bytes(tmp_path):
    program, files = cut(400, list(range(5, 400, 9)), 10_000, max_bytes=8000)
    assert len(files) > 5 and max(map(len, files.values())) <= 8000
    assert_same(program, read_back(files, tmp_path))


def test_folds_stay_paired_over_parts(tmp_path):
    events = (ProgramEvent(3, ProgramEventKind.REGION, "one"), ProgramEvent(60, ProgramEventKind.REGION, "two"))
    program = make_program([Motion.PTP_AXES] + [LIN] * 99, safe=[30, 59, 80], events=events)
    files = written(program, max_lines=35)
    for content in files.values():
        assert content.count(b"\r\n;FOLD") == content.count(b"\r\n;ENDFOLD")
    assert b";FOLD one (continued)" in files["Fluegel_3_002.src"]
    assert b";FOLD two\r\n" in files["Fluegel_3_003.src"] and b"one" not in files["Fluegel_3_003.src"]


def test_without_a_safe_retract_a_part_ends_after_a_whole_motion_and_that_is_said():
    program, files = cut(80, [20, 50], 25)
    findings: list[Finding] = []
    again = dict(iter_krl(program, CONTROLLER, max_lines=25, findings=findings))
    assert again == files
    assert {f.code for f in findings} == {"split-in-cut"} and findings[0].line == program.line[findings[0].point]


def test_a_motion_larger_than_a_file_is_an_error_that_says_where():
    with pytest.raises(JobError, match=r"can't be split.*motion"):
        cut(80, [], 25, max_bytes=2000, max_line_length=800)


def test_names_of_parts_never_clash():
    program = make_program([LIN] * 30, safe=list(range(30)), name="ABCDEFGHIJKLMNOPQRST_001")
    files = written(program, max_lines=10)
    names = [n for n in files if n.endswith(".src")]
    assert len(names) == 4 and all(len(n.removesuffix(".src")) <= 24 for n in names)


# --- hostile text

NASTY = st.lists(
    st.one_of(
        st.text(max_size=12),
        st.sampled_from(
            [
                *("\r\n", "\n", "\r", "\x0b", "\x0c", "\x85", "\u2028", "\u2029", "\x00", "\u202e", "x" * 300),
                *(";", "FOLD", "ENDFOLD", ";ENDFOLD", "%{PE}%MKUKATPBASIS", "&ACCESS", "ＥＮＤＦＯＬＤ", '"', "{", "}"),
                *("LIN {X 0,Y 0,Z 0}", "END", "DEF X ( )", "ﬁ", "é"),
            ]
        ),
    ),
    max_size=6,
).map("".join)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(texts=st.tuples(NASTY, NASTY, NASTY, NASTY.filter(bool)))
def test_text_never_becomes_a_statement(texts, tmp_path):
    plain = written(small_program())
    expected = read_back(plain, tmp_path)
    files = written(small_program(texts))
    (source, content), (_, data) = files.items()
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,23}\.src", source)
    for raw in (content, data):
        assert all(32 <= b < 127 or b in (10, 13) for b in raw)
        assert b"%{" not in raw and not re.search(rb"(?<!\r)\n|\r(?!\n)", raw)
    lines, wanted = content.decode().split("\r\n"), plain["Fluegel_3.src"].decode().split("\r\n")
    assert len(lines) == len(wanted) and max(map(len, lines)) <= CONTROLLER.max_line_length
    for line, want in zip(lines, wanted, strict=True):
        if want.startswith((";FOLD", "; ")):
            head = ";FOLD " if want.startswith(";FOLD") else "; "
            assert (
                line.startswith(head)
                and ";" not in line[1:]
                and not re.match(r"; *(END)?FOLD", line[len(head) :], re.I)
            )
        elif not want.startswith("DEF "):
            assert line == want
    read = read_back(files, tmp_path)
    assert read.statements == expected.statements and len(read) == len(expected)
    assert np.array_equal(read.pose, expected.pose, equal_nan=True)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Flügel 3", "Fluegel_3"),
        ("3d-part", "P_3d_part"),
        ("", "P"),
        ("../../etc/passwd", "etc_passwd"),
        ("lin", "P_lin"),
        ("con", "P_con"),
        ("Cell", "P_Cell"),
        ("home", "P_home"),
        ("sin", "P_sin"),
        ("x" * 300, "x" * 24),
        ("日本", "P"),
    ],
)
def test_names(text, name):
    assert krl_name(text) == name


def test_names_are_unique_after_cleaning():
    taken: set[str] = set()
    for text in ["a b", "a-b", "a.b", "y" * 40, "y" * 41]:
        taken.add(krl_name(text, taken))
    assert taken == {"a_b", "a_b_2", "a_b_3", "y" * 24, "y" * 22 + "_2"}


def test_comments_lose_what_acts():
    assert comment_text("50 % {PE} ;ENDFOLD\n& µm ±0,1°", 80) == "50 pct (PE) ,ENDF-OLD + um +-0,1 deg"
    assert comment_text("y" * 300, 50) == "y" * 48 + ".."


# --- the cell's settings


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hooks": {"spindle_on": ("$OUT[1] = {name}",)}}, "placeholder"),
        ({"hooks": {"stop": ("HALT\r\nLIN",)}}, "7-bit"),
        ({"hooks": {"dance": ()}}, "unknown"),
        ({"hooks": {"stop": "HALT"}}, "list"),
        ({"acc_cp": float("nan")}, "acc_cp"),
        ({"advance": 9}, "advance"),
        ({"max_lines": True}, "max_lines"),
    ],
)
def test_settings_are_checked(change, message):
    with pytest.raises(CellError, match=message):
        dataclasses.replace(CONTROLLER, **change)


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ({"base_template": "EK(1, 2)"}, "base"),
        ({"base_template": 7}, "base_template"),
        ({"ori_type": "#VAR\n"}, "ori_type"),
        ({"ori_type": None}, "ori_type is missing"),
        ({"act_ex_ax": 7}, "act_ex_ax is 7"),
        ({"tool_number": True}, "tool_number is True"),
        ({"stop_message": 1}, "stop_message is 1"),
        ({"mechanical_unit": "STN1"}, "mechanical_unit is not a key"),
    ],
)
def test_settings_of_the_language_are_checked_before_a_line_is_written(own, message):
    controller = dataclasses.replace(CONTROLLER, own={**OWN, **own})
    with pytest.raises(CellError, match=message):
        list(LANGUAGE.write(small_program(), controller, max_lines=None))
    with pytest.raises(CellError, match=message):
        LANGUAGE.settings(controller, follows_table=True)


def test_a_hook_that_moves_is_refused_before_a_line_is_written():
    controller = dataclasses.replace(CONTROLLER, hooks={"header": ("PTP HOME",)})
    with pytest.raises(CellError, match="moves the robot"):
        list(LANGUAGE.write(small_program(), controller, max_lines=None))


def test_hooks_print_numbers_only():
    settings_: ControllerSettings = CONTROLLER
    assert settings_.hook_lines("spindle_on", 12000.0) == ("$ANOUT[1] = 12000 / 24000.0", "$OUT[5] = TRUE")
    assert settings_.hook_lines("tool_change", 7) == ("TOOL_CHANGE (7)",)
    with pytest.raises(ValueError, match="nan"):
        settings_.hook_lines("spindle_on", float("nan"))


def test_a_hundred_thousand_motions_are_all_written():
    program = make_program([Motion.PTP_AXES] + [LIN] * 100_000, safe=list(range(5000, 100_000, 5000)))
    files = written(program)
    assert sum(len(motions(content)) for content in files.values()) == 100_001
