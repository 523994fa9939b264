"""A feed held to the set-up's tolerance: what the machine's speed does stays within it, on a machine that other code runs.

The drives that lag are `gap_generator`'s world with scipy's filter before its joints, which share no code with camrob.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from gap_cases import KR15, closed_loop
from scipy.signal import lfilter

from camrob import post
from camrob.errors import InputError
from camrob.jobs.diagnose import diagnose
from camrob.jobs.solving.feed_within import held_feed
from camrob.jobs.verify import verify
from camrob.measurement.write_log import write_log
from camrob.prediction.speed_errors import beside_way
from camrob.redundancy.path import ToolPathInBase
from camrob.toolpath.region import Move

LAGS = {0: 0.016, 1: 0.010, 2: 0.006}  # s of A1, A2, A3
CYCLE = 0.004


def late(world) -> None:
    """Drives that follow their set-points as a resistor charges a capacitor, each at its own pace."""
    for axis, tau in LAGS.items():
        keep = np.exp(-CYCLE / tau)
        u = world.command[:, axis]
        world.drive[:, axis] = lfilter([0.0, 1.0 - keep], [1.0, -keep], u - u[0]) + u[0] - u


def circles(folder: Path, feed: float = 3000.0) -> Path:
    """Two circles of 40 mm and a straight line, cut at a feed in mm/min."""
    turn = np.linspace(0.0, 4.0 * np.pi, 241)
    rows = [f"GOTO/{40 * np.cos(u):.4f},{40 * np.sin(u):.4f},20.0000,0,0,1" for u in turn]
    rows += [f"GOTO/{40 - x:.4f},0.0000,20.0000,0,0,1" for x in np.linspace(1, 80, 40)]
    text = ["TOOL PATH/CIRCLES,TOOL,T1", "TLDATA/MILL,10.0,5.0,80.0,0.0,0.0", "LOADTL/1", "SPINDL/RPM,12000,CLW"]
    text += ["RAPID", "GOTO/40.0000,0.0000,80.0000,0,0,1", f"FEDRAT/MMPM,{feed:.4f}", *rows]
    text += ["RAPID", "GOTO/-40.0000,0.0000,80.0000", "END-OF-PATH"]
    folder.mkdir(exist_ok=True)
    file = folder / "circles.cls"
    file.write_text("\n".join(text) + "\n")
    return file


def set_up(folder: Path, tolerance: float | None) -> Path:
    said = "part_in_base = [0, 0, 200, 0, 0, 0]\nclearance_mm = 60\nrapid_feed_mm_min = 12000\n"
    file = folder / "setup.toml"
    file.write_text(said + ("" if tolerance is None else f"tolerance_mm = {tolerance}\n"))
    return file


@pytest.fixture(scope="module")
def machine(tmp_path_factory) -> tuple[Path, Path, Path]:
    """The CL file, the program at its own feed, and the diagnosis of its run."""
    folder = tmp_path_factory.mktemp("machine")
    file = circles(folder)
    set_up(folder, None)
    post(file, cell=KR15, out=folder / "plain", report=False)
    program = folder / "plain" / "circles.src"
    write_log(closed_loop.run_on_cell(program, late, 1), folder / "run.csv")
    diagnose(cell=KR15, log=[folder / "run.csv"], out=folder / "diagnosis")
    return file, program, folder / "diagnosis"


def off(program: Path) -> np.ndarray:
    """(N,) mm that the true machine is off the program's path while it cuts; the last line is the retract."""
    log = closed_loop.run_on_cell(program, late, 2, sigma_mm=0.0)
    cuts = [n for n, text in enumerate(program.read_text().splitlines(), 1) if "C_DIS" in text and "LIN" in text][:-1]
    return closed_loop.off_path(log, program)[np.isin(log.columns["line"], cuts)]


@pytest.mark.slow
@pytest.mark.parametrize("feed", ["program", "optimal"])
def test_the_true_machine_stays_within_the_tolerance(feed: str, machine, tmp_path: Path) -> None:
    file, plain, diagnosis = machine
    before = off(plain)
    setup = set_up(tmp_path, 0.1)
    out = tmp_path / "held"
    said = post(file, cell=KR15, out=out, setup=setup, diagnosis=diagnosis, feed=feed, report=False).summary.feed
    after = off(out / "circles.src")
    assert said.tolerance is not None and said.tolerance.off_mm <= 0.1
    assert said.tolerance.off_before_mm == pytest.approx(before.max(), rel=0.1)
    # what is diagnosed is not exact, corners are rounded, and the first rows still settle from the rapid move
    assert before.max() > 0.4 and np.quantile(after, 0.99) < 0.11
    assert np.quantile(after, 0.5) > 0.06  # no slower than it has to be
    assert {loss.cause for loss in said.losses} >= {"tolerance"}
    assert verify(out / "circles.src", cell=KR15, against=file, setup=setup).summary.ok


@pytest.mark.slow
def test_a_tolerance_that_is_kept_changes_nothing(machine, tmp_path: Path) -> None:
    file, plain, diagnosis = machine
    made = post(file, cell=KR15, out=tmp_path, setup=set_up(tmp_path, 5.0), diagnosis=diagnosis, report=False)
    assert made.summary.feed.tolerance.slowest_mm_min is None
    assert (tmp_path / "circles.src").read_bytes() == plain.read_bytes()


def test_without_a_diagnosis_it_is_said(tmp_path: Path) -> None:
    file = circles(tmp_path)
    made = post(file, cell=KR15, out=tmp_path / "out", setup=set_up(tmp_path, 0.1), report=False)
    assert [f.text for f in made.findings if f.code == "tolerance"] == [
        "tolerance_mm holds the feed where a diagnosis says what the machine's speed does: give --diagnosis"
    ]
    assert made.summary.feed.tolerance is None
    setup = set_up(tmp_path, None)
    with pytest.raises(InputError, match="--diagnosis is for plans") as error:
        post(file, cell=KR15, out=tmp_path / "out", setup=setup, diagnosis=tmp_path, report=False)
    assert error.value.hint == "add --for-accuracy, or tolerance_mm to setup.toml"


def straight(count: int = 101, length: float = 0.1) -> ToolPathInBase:
    """A straight cut of `length` m along x."""
    frames = np.tile(np.eye(4), (count, 1, 1))
    frames[:, 0, 3] = np.linspace(0.0, length, count)
    n = np.arange(count)
    move, feed = np.where(n > 0, Move.CUT, Move.RAPID), np.full(count, 0.05)
    return ToolPathInBase(frames, move, feed, n + 1, np.zeros(count), n, n == 0)


def test_what_grows_with_the_speed_is_slowed_where_it_is_and_no_more() -> None:
    """Off by 8 ms of way in the middle third, by 3 ms elsewhere: 0.2 mm asks for 25 mm/s there and for 66 elsewhere."""
    path, programmed = straight(), np.full(101, 0.05)
    late = np.where((np.arange(101) > 33) & (np.arange(101) <= 66), 0.008, 0.003)

    def timed(speed):
        return SimpleNamespace(at=np.concatenate([[0.0], np.cumsum(1e-3 / speed[1:])]), speed=speed)

    def off_at(at):
        return np.concatenate([[0.0], late[1:] * 1e-3 / np.diff(at)])

    held, last = held_feed(path, programmed, 2e-4, timed, off_at)
    assert np.array_equal(last.speed, held.speed), "what is handed back is the run at the speed that is held"
    assert held.before.max() == pytest.approx(4e-4)
    assert 0.94 * 2e-4 < held.after.max() <= 2e-4
    slow = np.flatnonzero(held.slowed)
    assert set(range(34, 67)) <= set(slow.tolist()) <= set(range(30, 71))  # and what is within 50 ms of it
    assert np.all(held.speed[~held.slowed] == 0.05)


def test_a_late_tool_round_a_corner_is_on_its_way_still() -> None:
    """Late by 0.8 mm round a right angle and back again: on the way. 0.3 mm aside: off by that, late or not."""
    done = np.linspace(0.0, 0.03, 301)
    corners = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.01, 0.01, 0.0], [0.0, 0.01, 0.0]])

    def place(at):
        return np.stack([np.interp(at, [0.0, 0.01, 0.02, 0.03], axis) for axis in corners.T], axis=1)

    late = place(np.maximum(done - 8e-4, 0.0)) - place(done)
    # a corner between two of the places that are looked at is cut off
    assert np.linalg.norm(beside_way(place(done), late), axis=1).max() < 0.05 * 8e-4
    aside = np.tile([0.0, 0.0, 3e-4], (301, 1))
    assert beside_way(place(done), aside) == pytest.approx(aside)
    assert beside_way(place(done), late + aside) == pytest.approx(aside, abs=0.05 * 8e-4)
    assert not beside_way(place(done), 0.0 * late).any()
