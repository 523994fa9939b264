"""`camrob post` and `camrob verify` end to end on the engraving: contract, planted faults, hostile input."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import camrob.languages.krl.writer.write_krl as krl_writer
from camrob import post
from camrob.cli import app as cli
from camrob.errors import VerificationError
from camrob.jobs.verify import verify

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"


@pytest.fixture(scope="module")
def posted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("posted") / "out"
    assert cli.run(["post", str(SAMPLE), "--cell", str(CELL), "--out", str(out), "--quiet"]) == 0
    return out


def summary_of(posted: Path) -> dict:
    return json.loads((posted / "engraving.json").read_text())


# ---- the contract


def test_files(posted: Path) -> None:
    assert {f.name for f in posted.iterdir()} == {f"engraving.{x}" for x in ("src", "dat", "json", "path.npz", "html")}
    data = (posted / "engraving.src").read_bytes()
    assert data.count(b"\n") == data.count(b"\r\n") and data.isascii()
    assert b"-0.000," not in data and b"-0.0000," not in data
    assert max(map(len, data.split(b"\r\n"))) <= 255


def kind_of(value: object) -> str:
    if value is None:
        return "null"
    return {bool: "bool", int: "int", float: "float", str: "str", list: "list", dict: "dict"}[type(value)]


CONTRACT = {
    "program": "str",
    "cell": "str",
    "method": "str",
    "source.file": "str",
    "source.sha256": "str",
    "source.dialect": "str",
    "source.units": "str",
    "points": "int",
    "regions": "list",
    "tracking.position_error_mm_max": "float",
    "tracking.axis_error_deg_max": "float",
    "conditioning.inv_kf_min": "float",
    "conditioning.inv_kf_mean": "float",
    "conditioning.inv_kf_bound_mean": "float|null",
    "limits.margin_min": "dict",
    "limits.violations": "int",
    "singular": "int",
    "collisions.checked": "bool",
    "collisions.count": "int",
    "collisions.clearance_min_mm": "float|null",
    "external_travel.E1_mm": "float",
    "external_travel.E2_deg": "float",
    "time_s.program": "float",
    "time_s.optimal": "float|null",
    "verified.by": "str",
    "verified.position_error_mm_max": "float",
    "verified.points": "int",
    "warnings": "list",
    "seconds": "dict",
}


@pytest.mark.parametrize("dotted", CONTRACT)
def test_every_field_of_the_contract(posted: Path, dotted: str) -> None:
    value: object = summary_of(posted)
    for key in dotted.split("."):
        assert isinstance(value, dict)
        value = value[key]
    assert kind_of(value) in CONTRACT[dotted].split("|")


def test_what_the_summary_says(posted: Path) -> None:
    s = summary_of(posted)
    assert (s["program"], s["cell"], s["method"]) == ("engraving", "kr15_track_table", "vjm")
    assert s["source"]["file"] == "engraving.cls" and s["source"]["dialect"] == "nx-clsf"
    import hashlib

    assert s["source"]["sha256"] == hashlib.sha256(SAMPLE.read_bytes()).hexdigest()
    assert sum(r["points"] for r in s["regions"]) == s["points"] == s["verified"]["points"]
    for k, region in enumerate(s["regions"]):
        types = {"index": int, "name": str, "first_line": int, "last_line": int, "points": int, "revised": bool}
        assert region["index"] == k and all(type(region[key]) is t for key, t in types.items())
        assert 0.0 < region["inv_kf_before"] <= 1.0 and 0.0 < region["inv_kf_after"] <= 1.0
        assert region["revised"] or region["inv_kf_before"] == region["inv_kf_after"]
    assert s["tracking"]["position_error_mm_max"] <= 1e-6 and s["tracking"]["axis_error_deg_max"] <= 6e-5
    assert s["verified"]["position_error_mm_max"] <= 2e-3  # rounding stays under 2 micrometres
    assert set(s["limits"]["margin_min"]) == {"A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2"}
    assert s["limits"]["margin_min"]["E2"] is None and s["limits"]["violations"] == 0
    assert min(v for v in s["limits"]["margin_min"].values() if v is not None) > 0.0
    assert s["singular"] == 0 and s["collisions"]["checked"] and s["collisions"]["count"] == 0
    assert any(w["code"] == "assumed-limits" and {"line", "code", "text"} <= set(w) for w in s["warnings"])
    assert all(isinstance(v, float) for v in s["seconds"].values())


def dh(alpha: float, a: float, theta: float, d: float) -> np.ndarray:
    """A Denavit-Hartenberg row of the paper's Table 1, m and rad."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array([[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1.0]])


def table_1(q: np.ndarray) -> np.ndarray:
    """The tool in `base`, from the paper's Table 1 alone: nothing of camrob's kinematics takes part."""
    h = np.pi / 2
    rows = [
        (h, 0.803, q[0], -0.305),
        (h, 0, 0, q[1]),
        (h, 0.3, q[2], -0.675),
        (0, 0.65, q[3], 0),
        (h, 0.155, q[4], 0),
        (h, 0, q[5], -0.6),
        (h, 0, q[6], 0),
        (0.3564, 0, q[7], -0.4434),
        (0, 0, q[8], -0.1197),
    ]
    T = np.eye(4)
    for row in rows:
        T = T @ dh(*row)
    return T


def cl_points() -> dict[int, np.ndarray]:
    """CL points by line, straight from the file's text: position in the part (below its MSYS), axis. Of a hole, its bottom."""
    points = {}
    axis, depth = np.array([0.0, 0.0, 1.0]), 0.0
    for number, line in enumerate(SAMPLE.read_text().splitlines(), start=1):
        if line.startswith("CYCLE/"):
            depth = float(line.split("FEDTO,")[1].split(",")[0]) if "FEDTO" in line else 0.0
        if line.startswith("GOTO/"):
            values = [float(v) for v in line[5:].split(",")]
            axis = np.array(values[3:6]) if len(values) == 6 else axis
            points[number] = np.concatenate([values[:3] + depth * axis, axis])
    return points


def test_the_arrays_meet_the_cl_points(posted: Path) -> None:
    path = np.load(posted / "engraving.path.npz")
    N = summary_of(posted)["points"]
    assert path["q"].shape == (N, 9) and path["axis_values"].shape == (N, 8)
    assert list(path["axes"]) == ["E2", "E1", "A1", "A2", "A3", "A4", "A5", "A6", "roll"]
    for name in ("line", "region", "inv_kf", "s"):
        assert path[name].shape == (N,)
    points = cl_points()
    assert set(points) <= set(path["line"].tolist())
    part_in_base = np.array([0.0, 0.0, 220.0])  # set-up and MSYS
    for line, point in points.items():
        poses = np.array([table_1(path["q"][k]) for k in np.flatnonzero(path["line"] == line)])  # a cycle makes several
        far = np.abs(1e3 * poses[:, :3, 3] - point[:3] - part_in_base).max(axis=1)
        assert far.min() < 1e-5, line
        np.testing.assert_allclose(poses[np.argmin(far), :3, 2], point[3:], atol=1e-8)
    # axis values as KRL prints them, by the cell's page
    q = path["q"]
    A = np.degrees(np.stack([q[:, 2] - np.pi, q[:, 3], q[:, 4] + np.pi / 2, q[:, 5], np.pi - q[:, 6], q[:, 7]], axis=1))
    np.testing.assert_allclose(path["axis_values"][:, :6], A, atol=1e-9)
    np.testing.assert_allclose(path["axis_values"][:, 6], 1e3 * q[:, 1], atol=1e-9)
    np.testing.assert_allclose(path["axis_values"][:, 7], np.degrees(q[:, 0]) - 180.0, atol=1e-9)
    assert np.all(np.diff(path["s"]) >= 0.0) and np.all((path["inv_kf"] > 0.0) & (path["inv_kf"] <= 1.0))


def test_the_json_on_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["post", str(SAMPLE), "--cell", str(CELL), "--out", str(tmp_path), "--no-report", "--json"]
    assert cli.run(command) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert json.loads(shown.out) == json.loads((tmp_path / "engraving.json").read_text())


def test_split_programs_are_released_too(tmp_path: Path) -> None:
    result = post(SAMPLE, cell=CELL, out=tmp_path, max_lines=40, report=False)
    parts = [f for f in result.files if f.endswith(".src")]
    assert len(parts) > 3 and all((tmp_path / f).is_file() for f in result.files)
    assert verify(tmp_path / "engraving.src", cell=CELL, against=SAMPLE).ok
    again = post(SAMPLE, cell=CELL, out=tmp_path, report=False)  # parts of the longer program go
    assert {f.name for f in tmp_path.iterdir()} == set(again.files)


def test_posting_twice_says_the_same(posted: Path, tmp_path: Path) -> None:
    post(SAMPLE, cell=CELL, out=tmp_path, report=False)
    assert (tmp_path / "engraving.src").read_bytes() == (posted / "engraving.src").read_bytes()


def test_another_name(tmp_path: Path) -> None:
    result = post(SAMPLE, cell=CELL, out=tmp_path, name="job_7", report=False)
    assert "job_7.src" in result.files and (tmp_path / "job_7.src").read_text().count("DEF job_7 ( )") == 1


# ---- planted faults

Fault = Callable[[list[str]], list[str]]


def at(rows: list[str], k: int, pattern: str, replacement: str | Callable[[re.Match[str]], str]) -> list[str]:
    changed, count = re.subn(pattern, replacement, rows[k])
    assert count == 1, rows[k]
    return [*rows[:k], changed, *rows[k + 1 :]]


def a_cut(rows: list[str]) -> int:
    """A LIN in the middle of the frame's outline, between two arcs."""
    for k, row in enumerate(rows):
        if row == "$VEL.CP = 0.025000" and all(r.startswith(("LIN", "CIRC")) for r in rows[k + 1 : k + 10]):
            return next(j for j in range(k + 2, k + 10) if rows[j].startswith("LIN"))
    raise AssertionError("the engraving has another outline now")


def number(name: str, change: Callable[[float], float]) -> Fault:
    def plant(rows: list[str]) -> list[str]:
        return at(rows, a_cut(rows), rf"\b{name} (-?[\d.]+)", lambda m: f"{name} {change(float(m[1])):.4f}")

    return plant


def everywhere(pattern: str, replacement: str | Callable[[re.Match[str]], str]) -> Fault:
    def plant(rows: list[str]) -> list[str]:
        changed = [re.sub(pattern, replacement, row) if "$" not in row else row for row in rows]
        assert changed != rows
        return changed

    return plant


def statement(pattern: str, replacement: str | Callable[[re.Match[str]], str]) -> Fault:
    def plant(rows: list[str]) -> list[str]:
        changed = re.sub(pattern, replacement, "\n".join(rows)).split("\n")
        assert changed != rows
        return changed

    return plant


def dropped(rows: list[str]) -> list[str]:
    k = a_cut(rows)
    return rows[:k] + rows[k + 1 :]


def repeated_later(rows: list[str]) -> list[str]:
    k = a_cut(rows)
    return [*rows[: k + 2], rows[k], *rows[k + 2 :]]


def two_swapped(rows: list[str]) -> list[str]:
    k = a_cut(rows)
    return [*rows[:k], rows[k + 1], rows[k], *rows[k + 2 :]]


def truncated(rows: list[str]) -> list[str]:
    return [*rows[: a_cut(rows)], "END", ""]


def arc_to_line(rows: list[str]) -> list[str]:
    k = next(k for k, row in enumerate(rows) if row.startswith("CIRC"))
    return at(rows, k, r"CIRC \{[^}]*\},", "LIN ")


def arc_other_way(rows: list[str]) -> list[str]:
    k = next(k for k, row in enumerate(rows) if row.startswith("CIRC"))
    return at(rows, k, r"CIRC (\{[^}]*\}),(\{[^}]*\})", r"CIRC \2,\1")


VERIFIED_FAULTS: dict[str, Fault] = {
    "a coordinate's sign": number("X", lambda v: -v),
    "a hundredth of a millimetre and more": number("Z", lambda v: v - 0.012),
    "a tilt of two hundredths of a degree": number("B", lambda v: v + 0.02),
    "X and Y swapped": everywhere(r"X (-?[\d.]+),Y (-?[\d.]+)", r"X \2,Y \1"),
    "inches": everywhere(r"\b([XYZ]) (-?[\d.]+)", lambda m: f"{m[1]} {float(m[2]) / 25.4:.4f}"),
    "A, B, C in another order": everywhere(r"A (-?[\d.]+),B (-?[\d.]+),C (-?[\d.]+)", r"A \3,B \1,C \2"),
    "a dropped line": dropped,
    "a point passed twice": repeated_later,
    "two points swapped": two_swapped,
    "a lost end": truncated,
    "a stale base": statement(r"\{X 0\.00000,Y 0\.00000,Z 0\.00000,A", "{X 5.00000,Y 0.00000,Z 0.00000,A"),
    "a base turned by half a degree": statement(r"(\$BASE[^\n]*A )0\.00000", r"\g<1>0.50000"),
    "no base": statement(r"\$BASE = [^\n]*\n", ""),
    "another tool": statement(r"(\$TOOL = \{[^}]*Z )415", r"\g<1>405"),
    "a tool turned about its axis": statement(r"(\$TOOL = \{[^}]*A )0\.00000", r"\g<1>3.00000"),
    "no tool": statement(r"\$TOOL = [^\n]*\n", ""),
    "E2 a turn on": number("E2", lambda v: v + 360.0),
    "E2 a turn on, from there": lambda rows: [
        row if k < a_cut(rows) else re.sub(r"\bE2 (-?[\d.]+)", lambda m: f"E2 {float(m[1]) + 360:.4f}", row)
        for k, row in enumerate(rows)
    ],
    "E1 beyond its limit": number("E1", lambda v: 1600.0),
    "the wrong S": statement(r",S 2,", ",S 6,"),
    "S of the stretched arm": statement(r",S 2,", ",S 0,"),
    "sixty times the speed": statement(r"\$VEL\.CP = 0\.025000", "$VEL.CP = 1.500000"),
    "a thousandth more speed in the wrong place": statement(r"\$VEL\.CP = 0\.005000", "$VEL.CP = 0.025000"),
    "no speed": statement(r"\$VEL\.CP = [^\n]*\n", ""),
    "a PTP through the cut": lambda rows: at(rows, a_cut(rows), r"^LIN ", "PTP "),
    "an arc cut straight": arc_to_line,
    "an arc the other way": arc_other_way,
    "a call of what is not there": statement(r";FOLD ENGRAVE", "warm_up ( )\n;FOLD ENGRAVE"),
}


def planted(posted: Path, folder: Path, fault: Fault) -> Path:
    folder.mkdir(exist_ok=True)
    shutil.copy(posted / "engraving.dat", folder / "engraving.dat")
    rows = (posted / "engraving.src").read_bytes().decode().split("\r\n")
    program = folder / "engraving.src"
    program.write_bytes("\r\n".join(fault(rows)).encode())
    assert program.read_bytes() != (posted / "engraving.src").read_bytes()
    return program


def test_the_program_itself_is_verified(posted: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["verify", str(posted / "engraving.src"), "--cell", str(CELL)]
    assert cli.run(command) == 0
    capsys.readouterr()
    assert cli.run([*command, "--against", str(SAMPLE), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["ok"] and summary["errors"] == [] and summary["against"]["met"] == summary["against"]["points"]


@pytest.mark.parametrize("name", VERIFIED_FAULTS)
def test_verify_refuses(posted: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    program = planted(posted, tmp_path, VERIFIED_FAULTS[name])
    assert cli.run(["verify", str(program), "--cell", str(CELL), "--against", str(SAMPLE), "--json"]) == 1
    shown = capsys.readouterr()
    summary = json.loads(shown.out)
    assert not summary["ok"] and (summary["errors"] or summary["not_judged"]) and shown.err == ""


MEANT_FAULTS: dict[str, Fault] = {
    "the track astray": number("E1", lambda v: v + 200.0),
    "a point doubled": lambda rows: [*rows[: a_cut(rows)], rows[a_cut(rows)], *rows[a_cut(rows) :]],
    "the track's sign": everywhere(r"\bE1 (-?[\d.]+)", lambda m: f"E1 {-float(m[1]):.4f}"),
    "the table's sign": everywhere(r"\bE2 (-?[\d.]+)", lambda m: f"E2 {-float(m[1]):.4f}"),
    "A4 on another turn": statement(r",T (\d+),", lambda m: f",T {int(m[1]) ^ 8},"),
    "A6 on another turn": statement(r",T (\d+),", lambda m: f",T {int(m[1]) ^ 32},"),
    "a slower cut": statement(r"\$VEL\.CP = 0\.025000", "$VEL.CP = 0.020000"),
    "a faster rapid": statement(r"\$VEL\.CP = 0\.200000", "$VEL.CP = 0.900000"),
    "a last digit": number("Y", lambda v: v + 0.001),
}
"""Programs that bring the tool to every point, safely as far as anyone can tell, but are not what was meant."""


@pytest.mark.parametrize("name", [*MEANT_FAULTS, *VERIFIED_FAULTS])
def test_post_does_not_release(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """The same faults in what the writer writes: VerificationError (or what can't be read), and nothing is left."""
    fault = {**MEANT_FAULTS, **VERIFIED_FAULTS}[name]
    written = krl_writer.iter_krl

    def faulty(*arguments, **options):
        for file, data in written(*arguments, **options):
            if file.endswith(".src"):
                data = "\r\n".join(fault(data.decode().split("\r\n"))).encode()
            yield file, data

    monkeypatch.setattr(krl_writer, "iter_krl", faulty)
    out = tmp_path / "new" / "out"
    with pytest.raises(VerificationError, match="not released"):
        post(SAMPLE, cell=CELL, out=out, report=False)
    assert list(tmp_path.iterdir()) == []


def test_an_older_program_survives_a_failure(posted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = Path(shutil.copytree(posted, tmp_path / "out"))
    before = {f.name: f.read_bytes() for f in out.iterdir()}
    monkeypatch.setattr(
        krl_writer, "iter_krl", lambda *a, **o: iter([("engraving.src", b"DEF engraving ( )\r\nEND\r\n")])
    )
    with pytest.raises(VerificationError, match="not released"):
        post(SAMPLE, cell=CELL, out=out, report=False)
    assert {f.name: f.read_bytes() for f in out.iterdir()} == before


# ---- hostile input

HEAD = "TOOL PATH/CUT,TOOL,MILL\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\n"
TAIL = "END-OF-PATH\n"
GOOD = HEAD + "RAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/40,0,0\nRAPID\nGOTO/40,0,50\n" + TAIL

HOSTILE: dict[str, tuple[bytes, int]] = {
    "empty": (b"", 2),
    "blank": (b"\n" * 50, 2),
    "binary": (bytes(range(256)) * 40, 2),
    "a zip": (b"PK\x03\x04" + b"\x00\xff" * 300, 2),
    "truncated in a number": (GOOD[: GOOD.index("GOTO/40,0,0") + 7].encode(), 2),
    "truncated after a comma": ((HEAD + "GOTO/1,2,").encode(), 2),
    "one line of 5 MB": (b"GOTO/" + b"1.0," * 1_250_000, 2),
    "5 MB without a line": (b"A" * 5_000_000, 2),
    "NaN": (GOOD.replace("GOTO/40,0,0", "GOTO/40,NaN,0").encode(), 2),
    "infinity": (GOOD.replace("GOTO/40,0,0", "GOTO/40,1e400,0").encode(), 2),
    "a zero feed": (GOOD.replace("MMPM,500", "MMPM,0").encode(), 2),
    "a negative feed": (GOOD.replace("MMPM,500", "MMPM,-500").encode(), 2),
    "no feed before the cut": (GOOD.replace("FEDRAT/MMPM,500\n", "").encode(), 2),
    "no unit axis": (GOOD.replace("0,0,1\n", "0,0,3\n").encode(), 2),
    "no axis at all": (GOOD.replace("50,0,0,1", "50,0,0,0").encode(), 2),
    "an APT source program": (b"PARTNO X\nP1=POINT/0,0,0\nGOFWD/L1,TO,L2\nFINI\n", 2),
    "only comments": (b"$$ nothing\n$$ at all\n", 2),
    "nested quotes and control characters": ((HEAD + 'PPRINT "\x00\x1b[2J\n' + "GOTO/1\n").encode(), 2),
    "a part out of reach": (GOOD.replace("GOTO/40,0,0", "GOTO/40,0,9000").encode(), 3),
    "a tool from below": (GOOD.replace("0,0,1\n", "0,0,-1\n").encode(), 3),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files(tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """One line that says what is wrong, the right status, no traceback, no file."""
    data, status = HOSTILE[name]
    cl = tmp_path / "in" / "hostile.cls"
    cl.parent.mkdir()
    cl.write_bytes(data)
    assert cli.run(["post", str(cl), "--cell", str(CELL), "--out", str(tmp_path / "out")]) == status
    shown = capfd.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1 and shown.err.strip() and len(shown.err) < 1500
    assert "Traceback" not in shown.err and "internal error" not in shown.err
    assert shown.err.isprintable() or shown.err[:-1].isprintable()
    assert [f.name for f in tmp_path.iterdir()] == ["in"]
    if status == 2:
        assert "hostile.cls" in shown.err
    else:
        assert re.search(r"line \d+", shown.err)


def test_the_good_file_beside_the_hostile_ones_is_posted(tmp_path: Path) -> None:
    cl = tmp_path / "good.cls"
    cl.write_text(GOOD)
    setup = tmp_path / "setup.toml"
    setup.write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    assert post(cl, cell=CELL, out=tmp_path / "out", report=False).summary.points == 4


def test_inches_are_inches(tmp_path: Path) -> None:
    """The same part in inches makes the same poses; taken for millimetres it makes another part, which verify refuses."""
    inches = re.sub(
        r"GOTO/([-\d.]+),([-\d.]+),([-\d.]+)",
        lambda m: "GOTO/" + ",".join(f"{float(v) / 25.4:.9f}" for v in m.groups()),
        GOOD,
    )
    inches = inches.replace("FEDRAT/MMPM,500", f"FEDRAT/IPM,{500 / 25.4:.9f}")
    for name, text in (("mm", GOOD), ("inch", inches)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "part.cls").write_text(text)
        (folder / "setup.toml").write_text(f'part_in_base = [0, 0, 200, 0, 0, 0]\nunits = "{name}"\n')
        post(folder / "part.cls", cell=CELL, out=folder / "out", report=False)
    programs = [
        re.sub(r";[^\r]*", "", (tmp_path / name / "out" / "part.src").read_bytes().decode()) for name in ("mm", "inch")
    ]
    assert programs[0] == programs[1]
    (tmp_path / "inch" / "setup.toml").write_text('part_in_base = [0, 0, 200, 0, 0, 0]\nunits = "mm"\n')
    result = verify(tmp_path / "mm" / "out" / "part.src", cell=CELL, against=tmp_path / "inch" / "part.cls")
    assert not result.ok


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["post", "none.cls", "--cell", "CELL", "--out", "out"], 2),
        (["post", "SAMPLE", "--cell", "nowhere", "--out", "out"], 2),
        (["post", "SAMPLE", "--cell", "CELL", "--out", "out", "--setup", "none.toml"], 2),
        (["post", "SAMPLE", "--cell", "CELL", "--out", "out", "--name", "END"], 2),
        (["post", "SAMPLE", "--cell", "CELL", "--out", "out", "--name", "a b"], 2),
        (["post", "SAMPLE", "--cell", "CELL", "--out", "out", "--dialect", "klingon"], 2),
        (["post", ".", "--cell", "CELL", "--out", "out"], 2),
        (["verify", "none.src", "--cell", "CELL"], 2),
        (["verify", "SAMPLE", "--cell", "CELL"], 2),
    ],
)
def test_wrong_command_lines(tmp_path: Path, monkeypatch, arguments, status, capfd) -> None:
    monkeypatch.chdir(tmp_path)
    places = {"CELL": str(CELL), "SAMPLE": str(SAMPLE)}
    assert cli.run([places.get(a, a) for a in arguments]) == status
    shown = capfd.readouterr()
    assert shown.out == "" and shown.err.count("\n") == 1 and "Traceback" not in shown.err
    assert "internal error" not in shown.err
    assert list(tmp_path.iterdir()) == []
