"""Measurement logs: what is read, what is refused, and how fast."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob.calibration.measurements import measurements_of
from camrob.cell.read_cell import read_cell
from camrob.errors import LogError
from camrob.measurement.csv_numbers import format_table, parse_table
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame, Target, read_info
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log

SHARED = Path(__file__).resolve().parents[3] / "shared"
HEADER = "t,x,y,z,a,b,c,A1,A2,A3,A4,A5,A6,E1,E2"
ROWS = [
    "0.000,97.0,-41.764,619.422,180.0,0.0,20.42,0.0,-90.0,90.0,0.0,90.0,0.0,0.0,0.0",
    "0.012,197.5,-41.764,619.422,,,,10.0,-95.5,91.0,0.0,90.0,0.0,0.0,0.0",
    "0.024,297.5,-141.764,619.422,180.0,0.0,2.042e1,20.0,-95.5,91.0,0.0,90.0,0.0,0.0,0.0",
]


def written(folder: Path, rows=ROWS, header=HEADER, ending="\n", name="log.csv") -> Path:
    path = folder / name
    path.write_bytes((ending.join([header, *rows]) + ending).encode())
    return path


def made(n: int, seed: int = 0, torque: bool = False) -> MeasurementLog:
    rng = np.random.default_rng(seed)
    names = HEADER.split(",")[1:] + ([f"T{i}" for i in range(1, 7)] if torque else [])
    columns = {name: rng.uniform(-170.0, 170.0, n) for name in names}
    return MeasurementLog({"t": np.arange(n) * 0.012, **columns, "line": np.arange(n) // 7})


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_a_small_log(tmp_path: Path, ending: str) -> None:
    log = read_log(written(tmp_path, ending=ending))
    assert len(log) == 3
    assert np.allclose(log.t, [0.0, 0.012, 0.024])
    assert np.allclose(log.position[0], [0.097, -0.041764, 0.619422], atol=1e-15)
    assert np.isnan(log.rotation[1]).all()
    assert np.allclose(log.rotation[0] @ [0, 0, 1], [0, np.sin(np.deg2rad(20.42)), np.cos(np.deg2rad(20.42))])
    assert log.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    assert np.array_equal(log.axes(("A1", "A2"))[1], [10.0, -95.5])
    assert log.complete(("a", "x")).tolist() == [True, False, True]
    assert not log.has("temp") and log.has_orientation
    with pytest.raises(LogError, match=r"log\.csv:1: has no column cA1"):
        log.setpoints(("A1",))
    assert log.info == LogInfo()
    assert len(log.select(np.array([0, 2]))) == 2
    with pytest.raises(ValueError, match="read-only"):
        log.columns["x"][0] = 1.0


def test_numbers_are_those_of_python(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    texts = [f"{v:.{k % 12}f}" for k, v in enumerate(rng.normal(0, 50, 4000))]
    texts += ["1e-3", "-2.5E+1", "+4.", ".5", "-0", "0.1234567890123456789", "12.345678901234567", " 7.5 "]
    rows = [f"{i},{v}" + f",0,0,{i % 90},-90,90,0,0,0" for i, v in enumerate(texts)]
    log = read_log(written(tmp_path, rows, "t,x,y,z,A1,A2,A3,A4,A5,A6"))
    assert log.columns["x"].tolist() == [float(v) for v in texts]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: [], r"log\.csv:1: holds no samples"),
        (lambda r: [r[0], r[2], r[1]], r"log\.csv:4: t is 0\.012 after 0\.024; time has to advance .*split the log$"),
        (lambda r: [r[0], r[0]], r"log\.csv:3: t is 0 after 0.*, or write \[table\]"),
        (
            lambda r: [r[0], r[1].replace("197.5", "nan")],
            r"log\.csv:3: x is 'nan'; leave a cell empty.*; \[table\] in its",
        ),
        (lambda r: [r[0], r[1].replace("197.5", "inf")], r"log\.csv:3: x is 'inf'.*with a decimal point$"),
        (lambda r: [r[0], r[1].replace("197.5", "1_0")], r"log\.csv:3: x is '1_0'"),
        (lambda r: [r[0], r[1].replace("197.5", "1e999")], r"log\.csv:3: x is '1e999'"),
        (lambda r: [r[0], r[1].replace("197.5", "\x1b[31m")], r"log\.csv:3: x is '\\x1b"),
        (lambda r: [r[0], r[1] + ",1"], r"log\.csv:3: has more or fewer cells"),
        (lambda r: [r[0], "0.012,1"], r"log\.csv:3: has more or fewer cells"),
        (lambda r: [r[0], "", r[1]], r"log\.csv:3: there is an empty line"),
        (lambda r: [r[0], r[1].replace("0.012", "")], r"log\.csv:3: t is empty"),
        (lambda r: [r[0], r[1].replace("197.5", "1e7")], r"log\.csv:3: x is 1e\+07; the format's units are mm"),
    ],
)
def test_rows_that_are_refused(tmp_path: Path, change, message: str) -> None:
    with pytest.raises(LogError, match=message) as caught:
        read_log(written(tmp_path, change(ROWS)))
    assert "\n" not in str(caught.value) and caught.value.hint


def test_set_points_may_stand_alone(tmp_path: Path) -> None:
    log = read_log(written(tmp_path, ["0,1,2,3,10,20", "0.012,1,2,3,11,21"], "t,x,y,z,cA1,cA2"))
    assert log.setpoints(["A1", "A2"]).tolist() == [[10.0, 20.0], [11.0, 21.0]]


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (HEADER.replace("t,", "time,"), "has a column 'time'"),
        (HEADER.replace("z,", "zz,"), "has a column 'zz'"),
        (HEADER.replace(",x,", ",x_mm,"), "name it x, in the format's unit"),
        (HEADER.replace(",A1,", ",a1,"), "name it A1"),
        (HEADER.replace("A6", "A8"), "has an axis 'A8'"),
        (HEADER.replace("A6", "A7"), "has a column A7 but no column A6"),
        (HEADER + ",I2", "has a column I2 but no column I1"),
        (HEADER + ",cA1,cE3", "has a column cE3 but no column E3"),
        (HEADER.replace("E2", "E1"), "has the column E1 twice"),
        (HEADER.replace("c,", "temp,"), "has a column a but no column c"),
        (HEADER.replace(",", ";"), "separates columns by semicolons"),
        ("", "is empty"),
        ("t,x,y,z", "has no axis values"),
        ("x,y,z", "has no column t"),
    ],
)
def test_headers_that_are_refused(tmp_path: Path, header: str, message: str) -> None:
    with pytest.raises(LogError, match=message) as caught:
        read_log(written(tmp_path, [], header))
    assert caught.value.line == 1


def test_other_units_are_seen(tmp_path: Path) -> None:
    n = 50
    q = np.linspace(0.0, 60.0, n)
    plain = {
        "t": np.arange(n),
        "x": 1000 * np.cos(np.deg2rad(q)),
        "y": 1000 * np.sin(np.deg2rad(q)),
        "z": np.full(n, 500.0),
    }
    axes = {"A1": q, "A2": np.full(n, -90.0), "A3": np.full(n, 90.0), **{f"A{i}": np.zeros(n) for i in (4, 5, 6)}}
    write_log(MeasurementLog({**plain, **axes}), tmp_path / "good.csv")
    assert len(read_log(tmp_path / "good.csv")) == n
    write_log(MeasurementLog({**plain, **{k: np.deg2rad(v) for k, v in axes.items()}}), tmp_path / "radians.csv")
    with pytest.raises(LogError, match="in radians"):
        read_log(tmp_path / "radians.csv")
    write_log(MeasurementLog({**plain, **{k: plain[k] / 1000 for k in "xyz"}, **axes}), tmp_path / "metres.csv")
    with pytest.raises(LogError, match="in metres"):
        read_log(tmp_path / "metres.csv")


def test_any_number_of_axes_and_what_their_drives_tell(tmp_path: Path) -> None:
    """One axis, a seventh, a column alone; motor-side encoders and currents beside them, through a file and back."""
    n = 40
    for names in (("A1",), tuple(f"A{i}" for i in range(1, 8)), ("E1",)):
        columns = {"t": 0.01 * np.arange(n)}
        for k, name in enumerate(names):
            short = name.removeprefix("A")
            columns |= {name: np.linspace(0.0, 9.0 + k, n), f"c{name}": np.linspace(0.0, 9.5 + k, n)}
            columns |= {
                f"M{short}": np.linspace(0.1, 9.0, n),
                f"I{short}": np.full(n, 1.5 + k),
                f"T{short}": np.full(n, 20.0 + k),
            }
        write_log(MeasurementLog(columns), tmp_path / "drives.csv")
        log = read_log(tmp_path / "drives.csv")
        assert log.axis_names == names
        assert not log.has_position
        for kind, value in (("I", 1.5), ("T", 20.0)):
            beside = log.beside(kind, names)
            assert beside is not None
            assert beside[0].tolist() == [value + k for k in range(len(names))]
        assert log.beside("M", (*names, "E6")) is None


def test_facts_of_sets_and_drives_go_through_a_file(tmp_path: Path) -> None:
    info = LogInfo(
        sigma_axis=np.deg2rad(1e-3),
        sigma_axis_length=2e-6,
        tolerance=1e-4,
        same_poses_as="a.csv",
        same_frame_as="b.csv",
        same_target_as="c.csv",
        poses=True,
    )
    write_log(MeasurementLog({"t": np.arange(3.0), "A1": np.arange(3.0)}, info), tmp_path / "one.csv")
    found = read_log(tmp_path / "one.csv").info
    assert found.sigma_axis == pytest.approx(info.sigma_axis)
    assert found.sigma_axis_length == pytest.approx(2e-6)
    assert found.tolerance == pytest.approx(1e-4)
    assert (found.same_poses_as, found.same_frame_as, found.same_target_as) == ("a.csv", "b.csv", "c.csv")


def test_round_trip_and_facts(tmp_path: Path) -> None:
    info = LogInfo(MeasuredFrame.BASE, Target.UNKNOWN, 2e-5, 1e-5, 12.0, 0.1, "a.src", 'a "tracker"\\', "note", True)
    log = made(500, torque=True)
    gaps = np.array(log.columns["x"])
    gaps[3] = np.nan
    log = MeasurementLog({**log.columns, "x": gaps}, info)
    write_log(log, tmp_path / "l.csv")
    back = read_log(tmp_path / "l.csv")
    assert back.info.sigma_angle == pytest.approx(info.sigma_angle, rel=1e-12)  # written in degrees
    assert replace(back.info, sigma_angle=info.sigma_angle) == info
    assert set(back.columns) == set(log.columns)
    for name, values in log.columns.items():
        assert np.allclose(
            values, back.columns[name], rtol=0, atol=5.1e-5 if name[0] == "T" else 5.1e-7, equal_nan=True
        )
    assert np.array_equal(back.line, log.line)


def test_parquet(tmp_path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    log = made(200)
    write_log(log, tmp_path / "l.parquet")
    back = read_log(tmp_path / "l.parquet")
    assert back.digest == log.digest
    parquet.write_table(pyarrow.table({"t": ["a"]}), tmp_path / "bad.parquet")
    with pytest.raises(LogError, match="no axis values"):
        read_log(tmp_path / "bad.parquet")
    (tmp_path / "no.parquet").write_text("t,x")
    with pytest.raises(LogError, match="not a Parquet"):
        read_log(tmp_path / "no.parquet")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('measured_frame = "table"', "measured_frame: is 'table'; use one of world, base, unknown"),
        ("sigma_mm = -1", "sigma_mm: is -1"),
        ('sigma_mm = "a"', "sigma_mm: is a"),
        ("sigma_m = 1", "is sigma_mm meant"),
        ("poses = 1", "poses: is neither true nor false"),
        ("a = [1,,]", r"l\.toml:3: is not valid TOML"),
    ],
)
def test_facts_that_are_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "l.toml").write_text(f"# of the cell in the hall\n\n{text}")
    with pytest.raises(LogError, match=message) as refused:
        read_info(tmp_path / "l.toml")
    assert str(refused.value).startswith(f"{tmp_path}/l.toml:3: ")


def test_what_is_wrong_with_a_sample_is_named_by_its_line(tmp_path: Path) -> None:
    """Also of a part of a log; one that was never in a file has no lines."""
    log = read_log(written(tmp_path)).select(np.array([0, 2]))
    assert [str(log.error("it is odd", hint="look", at=at)) for at in (0, 1, None)] == [
        f"{tmp_path}/log.csv:{line}: it is odd; look" for line in (2, 4, 1)
    ]
    assert str(made(3).error("it is odd", hint="look", at=1)) == "it is odd; look"


def test_kernels_match_python() -> None:
    table = np.array([[1.5, -0.00004, np.nan], [123456.789, 0.99995, -7.0]])
    out = np.empty(200, np.uint8)
    text = out[: format_table(table, np.array([3, 4, 0]), out)].tobytes()
    assert text == b"1.500,0.0000,\n123456.789,1.0000,-7\n"
    back = np.empty((2, 3))
    rows, code, _, left = parse_table(np.frombuffer(text, np.uint8), 0, back, np.empty((9, 4), np.int64))
    assert (rows, code, left) == (2, 0, 0)
    assert np.allclose(back, [[1.5, 0, np.nan], [123456.789, 1.0, -7.0]], equal_nan=True)


def test_a_long_log_is_read_whole(tmp_path: Path) -> None:
    log = made(300_000)
    write_log(log, tmp_path / "l.csv")
    back = read_log(tmp_path / "l.csv")
    assert len(back) == 300_000
    np.testing.assert_allclose(back.columns["x"], log.columns["x"], rtol=0, atol=5.1e-7)


@pytest.mark.parametrize("series", ["real/ur10_tmac/A.csv", "gap_samples/cases/a_nothing/dome0.csv"])
def test_real_logs(series: str) -> None:
    if not (SHARED / series).is_file():
        pytest.skip(f"../shared is not here: {series}")
    log = read_log(SHARED / series)
    assert len(log) > 5000 and log.has_position and log.has_orientation


def test_an_axis_that_slides_is_in_mm_and_one_that_turns_in_degrees(tmp_path: Path) -> None:
    folder = tmp_path / "gantry"
    folder.mkdir()
    (folder / "cell.toml").write_text(
        'schema = 1\nname = "gantry"\nstanding = "datasheet"\n[arm]\nkinds = "PPPRR"\n'
        "dh = [[-90, 0, 0, 0], [-90, 0, -90, 0], [0, 0, 0, 0], [90, 0, 0, 0], [0, 0, 0, 150]]\n"
    )
    cell = read_cell(folder)
    row = "0.00,7500.0,-2400.0,1800.0,7500.0,2400.0,-1800.0,{},90.0"
    for value, fault in (("30.0", None), ("1800.0", r"log\.csv:2: A4 is 1800 degrees")):
        path = written(
            tmp_path, [row.format(value), row.format(value).replace("0.00", "0.02")], "t,x,y,z,A1,A2,A3,A4,A5"
        )
        if fault is None:
            assert measurements_of(read_log(path), cell).q[0, :3] == pytest.approx([7.5, 2.4, -1.8])
        else:
            with pytest.raises(LogError, match=fault):
                measurements_of(read_log(path), cell)
