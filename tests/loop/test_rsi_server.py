"""The tracker loop's server over loopback, against a controller of the test's own, and as a command."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rsi_world import HOST, Controller, Plant, Served, line, rob

from camrob.errors import InputError
from camrob.jobs.track_live import LiveOptions, track_live
from camrob.summaries.live_summary import Stopped

POSE = (1000.0, 200.0, 300.0, 10.0, 20.0, 30.0)
BOMB = b'<!DOCTYPE Rob [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><Rob Type="KUKA"><IPOC>&b;</IPOC></Rob>'


def serve(**options):
    generous = {"late_stop": 500, "stop_after": 500, "stale_after": 25, "gain": 0.05, **options}
    return Served(partial(track_live, listen=f"{HOST}:0", instrument=f"{HOST}:0", options=LiveOptions(**generous)))


@pytest.mark.parametrize(
    ("cycle_ms", "cycles", "mode"), [(4.0, 500, "absolute"), (4.0, 250, "relative"), (12.0, 120, "relative")]
)
def test_every_frame_is_answered_with_its_ipoc_at_the_sender_s_port(cycle_ms, cycles, mode, record_property) -> None:
    served = serve(cycle_ms=cycle_ms, mode=mode)
    controller = Controller(served.listen, served.instrument, Plant(mode))
    heard = controller.run(cycles, cycle_ms / 1000)
    result = served.end()
    controller.close()
    assert [a[0] for a in heard.answers] == heard.sent and len(heard.sent) == cycles
    frames = result.summary.frames
    assert frames.answered == frames.received == cycles == len(result.log)
    assert frames.missed == frames.duplicate == frames.out_of_order == 0 and not frames.refused
    assert list(result.log.ticks) == [int(i) for i in heard.sent]
    assert result.summary.stopped == Stopped(code="operator", text="stopped by the operator", fault=False)
    latency = result.summary.latency_ms
    record_property("latency_ms", latency.to_json())
    record_property("round_trip_ms", [float(v) for v in np.percentile(heard.latencies_ms, [50, 95, 99, 100])])
    assert 0.0 < latency.p50 <= latency.p95 <= latency.p99 <= latency.max
    assert 0.0 <= result.summary.within_cycle <= 1.0
    assert controller.plant.error(POSE)[0] < 0.05 < 0.5


def test_over_the_wire_a_lost_instrument_holds_then_silences_the_server(tmp_path) -> None:
    options = LiveOptions(gain=0.05, cycle_ms=12.0, stale_after=3, stop_after=10, late_stop=500)
    served = Served(
        partial(track_live, listen=f"{HOST}:0", instrument=f"{HOST}:0", options=options, out=tmp_path / "run")
    )
    controller = Controller(served.listen, served.instrument)
    heard = controller.run(60, 0.012, measured=lambda k: k < 20)
    result = served.end(ask=False)
    controller.close()
    answered = len(heard.answers)
    assert 30 <= answered < 60 and [a[0] for a in heard.answers] == heard.sent[:answered]
    assert (np.array([a[1] for a in heard.answers[-8:]]) == heard.answers[-1][1]).all() and heard.answers[-1][1].any()
    assert result.fault and result.summary.stopped.code == "stale"
    assert json.loads((tmp_path / "run" / "tracker.json").read_text())["stopped"]["code"] == "stale"
    rows = (tmp_path / "run" / "tracker.csv").read_text().splitlines()
    assert len(rows) == answered + 1 and rows[1].split(",")[1] == heard.sent[0]
    sent = np.array([float(v) for v in rows[-1].split(",")[-6:]])
    assert sent == pytest.approx(heard.answers[-1][1], abs=1e-6)


def test_over_the_wire_a_second_sender_and_hostile_packets_get_no_answer() -> None:
    served = serve(cycle_ms=12.0)
    stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    stranger.bind((HOST, 0))
    stranger.sendto(b"<Rob", served.listen)  # before anyone else: refused, and the place stays free
    controller = Controller(served.listen, served.instrument)
    first = controller.run(10, 0.012)
    for k in range(5):
        stranger.sendto(rob(controller.ipoc + 100 + k, POSE), served.listen)
        stranger.sendto(line(1e6 + k, *controller.plant.actual(POSE)), served.instrument)
        controller.socket.sendto(BOMB, served.listen)
        controller.socket.sendto(b"\xff" * 20000, served.listen)
    second = controller.run(10, 0.012)
    result = served.end()
    stranger.setblocking(False)
    with pytest.raises(BlockingIOError):
        stranger.recv(100)
    stranger.close()
    controller.close()
    assert [a[0] for a in first.answers + second.answers] == first.sent + second.sent
    assert result.summary.frames.other_sender == 5 and result.summary.measurements.other_sender == 5
    assert sum(result.summary.frames.refused.values()) == 11
    assert result.summary.stopped.code == "operator"


def test_over_the_wire_silence_is_a_fault_and_ends_it() -> None:
    served = serve(cycle_ms=4.0, late_stop=100)
    controller = Controller(served.listen, served.instrument)
    controller.run(5, 0.004)
    result = served.end(ask=False)
    controller.close()
    assert result.fault and result.summary.stopped.code == "silent" and "ms" in result.summary.stopped.text


def test_wrong_options_and_taken_ports_are_said() -> None:
    for bad in ("nowhere", "127.0.0.1", "127.0.0.1:70000", "a b:1", "[::1]:5"):
        with pytest.raises(InputError, match="not an address"):
            track_live(listen=bad)
    with pytest.raises(InputError, match="12"):
        track_live(options=LiveOptions(cycle_ms=8.0))
    with pytest.raises(InputError, match="six numbers"):
        track_live(options=LiveOptions(tracker_in_base=(1.0, float("nan"), 0, 0, 0, 0)))
    with pytest.raises(InputError, match="duration"):
        track_live(duration_s=0.0)
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    taken.bind((HOST, 0))
    with pytest.raises(InputError, match="can't be listened on"):
        track_live(listen="{}:{}".format(*taken.getsockname()), instrument=f"{HOST}:0")
    taken.close()


def test_a_time_that_is_over_ends_it_without_a_fault() -> None:
    result = track_live(listen=f"{HOST}:0", instrument=f"{HOST}:0", duration_s=0.1)
    assert result.summary.stopped.code == "duration" and not result.fault
    assert result.summary.latency_ms.p50 is None and result.summary.within_cycle is None


@pytest.mark.slow
def test_the_cell_s_loop_and_what_is_said_make_the_options() -> None:
    cell = Path(__file__).resolve().parents[2] / "cells" / "rx160_tracker"
    said = {"gain": 0.02, "tracker_in_base": "1,2,3,4,5,6", "bounds": ["far_mm=7", "late_stop=9"]}
    kept = track_live(listen=f"{HOST}:0", instrument=f"{HOST}:0", cell=cell, duration_s=0.05).summary
    changed = track_live(listen=f"{HOST}:0", instrument=f"{HOST}:0", cell=cell, said=said, duration_s=0.05).summary
    assert (kept.gain, kept.cycle_ms) == (0.01, 4.0) and changed.gain == 0.02
    for wrong in (
        {"bounds": ["far_mm"]},
        {"bounds": ["gain=1"]},
        {"bounds": ["late_stop=x"]},
        {"tracker_in_base": "1,2,x"},
    ):
        with pytest.raises(InputError):
            track_live(listen=f"{HOST}:0", said=wrong)


def cli(*arguments: str) -> subprocess.Popen:
    """The command, with an interrupt that reaches it however the tests were started."""
    return subprocess.Popen(
        [sys.executable, "-m", "camrob.cli", "tracker", "--json", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).resolve().parents[2],
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def free_port() -> tuple[str, int]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind((HOST, 0))
        return s.getsockname()


@pytest.mark.parametrize(("ending", "status", "code"), [("interrupt", 0, "operator"), ("no instrument", 3, "stale")])
def test_the_command_serves_and_says_what_ended_it(ending, status, code, tmp_path) -> None:
    listen, instrument = free_port(), free_port()
    at = ["--listen", "{}:{}".format(*listen), "--instrument", "{}:{}".format(*instrument)]
    rest = [
        "--cycle-ms",
        "12",
        "--gain",
        "0.05",
        "--set",
        "late_stop=800",
        "--set",
        "stale_after=25",
        "--set",
        "stop_after=20",
    ]
    process = cli(*at, *rest, "--out", str(tmp_path))
    controller = Controller(listen, instrument)
    try:
        deadline = time.monotonic() + 60
        while not controller.run(1, 0.012).answers:  # until it is up
            assert process.poll() is None and time.monotonic() < deadline
        heard = controller.run(40, 0.012)
        assert [a[0] for a in heard.answers] == heard.sent
        if ending == "interrupt":
            process.send_signal(signal.SIGINT)
        else:
            gone = controller.run(80, 0.012, measured=lambda k: False)
            assert 20 <= len(gone.answers) < 80
        printed, complaint = process.communicate(timeout=60)
    finally:
        process.kill()
        controller.close()
    summary = json.loads(printed)
    assert (process.returncode, complaint) == (status, "")
    assert summary["stopped"]["code"] == code and summary["stopped"]["fault"] == (status == 3)
    assert summary == json.loads((tmp_path / "tracker.json").read_text())


def test_the_command_says_what_is_wrong() -> None:
    for arguments, word in ((["--listen", "here"], "HOST:PORT"), (["--duration", "5"], "--listen")):
        process = cli(*arguments)
        printed, complaint = process.communicate(timeout=60)
        assert process.returncode == 2 and not printed
        assert word in complaint and complaint.count("\n") == 1
