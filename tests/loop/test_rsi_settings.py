"""Who is heard, and what a cell's tracker.toml and the command line say of instrument and link."""

from __future__ import annotations

import shutil
import time
from functools import partial
from pathlib import Path

import pytest
from rsi_bench import CONTROLLER, LAW, STRANGER, TRACKER, Bench
from rsi_world import HOST, Controller, Served, line

from camrob.errors import CellError, InputError
from camrob.jobs.files.track_options import live_options
from camrob.jobs.track_live import LiveOptions, track_live
from camrob.loop.case import read_tracker_case
from camrob.loop.rsi.link import LinkSettings, read_sender
from camrob.summaries.live_summary import InstrumentClock

CELL = Path(__file__).resolve().parents[2] / "cells" / "rx160_tracker"

# ---- senders ----


def test_only_allowed_senders_are_heard_whoever_is_first() -> None:
    bench = Bench(allow=(CONTROLLER, TRACKER))
    for _ in range(3):
        assert bench.frame(sender=STRANGER) is None
        bench.measure(sender=STRANGER)
    session, counts = bench.session, bench.session.counts
    assert session.controller is None and session.instrument is None
    assert bench.cycle() is not None and session.controller == CONTROLLER and session.instrument == TRACKER
    assert (counts.not_allowed, counts.measurements_not_allowed, counts.other_sender) == (3, 3, 0)
    assert counts.strangers == {"127.0.0.1:50003": 6} and counts.measurements_kept == 1


def test_without_a_list_the_first_good_sender_has_the_place() -> None:
    bench = Bench()
    assert bench.frame(sender=STRANGER) is not None
    assert bench.frame(sender=CONTROLLER) is None
    assert (bench.session.counts.other_sender, bench.session.counts.not_allowed) == (1, 0)
    assert bench.session.counts.strangers == {"127.0.0.1:50001": 1}


def test_the_list_names_a_port_or_any() -> None:
    settings = LinkSettings(LAW, allow=(read_sender("127.0.0.1:50001"), read_sender("10.0.0.7:*")))
    heard = [settings.hears(a) for a in (CONTROLLER, TRACKER, ("10.0.0.7", 1), ("10.0.0.7", 65535), ("10.0.0.71", 1))]
    assert heard == [True, False, True, True, False]


def test_a_list_that_keeps_the_instrument_out_says_so() -> None:
    bench = Bench(allow=(CONTROLLER,))
    for _ in range(8):
        bench.measure()
        bench.frame()
    assert (
        bench.session.stopped.code == "stale" and "6 of them not from an allowed sender" in bench.session.stopped.text
    )


def test_a_flood_of_strangers_is_counted_in_few_words() -> None:
    bench = Bench(allow=(CONTROLLER,))
    for port in range(1000):
        bench.session.measure(b"", (HOST, port), bench.now)
    assert len(bench.session.counts.strangers) == 33 and bench.session.counts.strangers.total() == 1000


@pytest.mark.parametrize(
    "text",
    [
        "",
        "localhost:5",
        "127.0.0.1",
        "127.0.0.1:",
        "127.0.0.1:0",
        "127.0.0.1:65536",
        "256.0.0.1:5",
        "1.2.3:5",
        "1.2.3.4:**",
        " 1.2.3.4:5",
        "::1:5",
        "1.2.3.4:٥",
    ],
)
def test_what_is_no_address_in_numbers_is_refused(text) -> None:
    with pytest.raises(InputError, match="not a sender's address"):
        read_sender(text)


def test_over_the_wire_a_stranger_that_is_first_gets_nothing() -> None:
    controller = Controller((HOST, 0), (HOST, 0))
    allow = tuple("{}:{}".format(*s.getsockname()) for s in (controller.socket, controller.tracker))
    stranger = Controller((HOST, 0), (HOST, 0))
    options = LiveOptions(allow=allow, cycle_ms=12.0, late_stop=500, stop_after=500, stale_after=25, gain=0.05)
    served = Served(partial(track_live, listen=f"{HOST}:0", instrument=f"{HOST}:0", options=options))
    for each in (stranger, controller):
        each.server, each.instrument = served.listen, served.instrument
    assert not stranger.run(3, 0.012).answers
    heard = controller.run(10, 0.012)
    result = served.end()
    controller.close()
    stranger.close()
    assert [a[0] for a in heard.answers] == heard.sent
    summary = result.summary
    assert (summary.frames.not_allowed, summary.measurements.not_allowed) == (3, 3)
    assert sorted(summary.strangers.values()) == [3, 3]
    assert [w.code for w in summary.warnings] == ["own-clock"]


@pytest.mark.slow
@pytest.mark.parametrize(("offset_s", "code"), [(0.0, "operator"), (-20.0, "stale")])
def test_over_the_wire_a_shared_clock_is_the_system_s(offset_s, code) -> None:
    class Stamped(Controller):
        def measure(self, setpoint) -> None:
            self.tracker.sendto(line(time.time() + offset_s, *self.plant.actual(setpoint)), self.instrument)

    options = LiveOptions(clock="shared", cycle_ms=12.0, late_stop=500, stop_after=20, stale_after=250, gain=0.05)
    served = Served(partial(track_live, listen=f"{HOST}:0", instrument=f"{HOST}:0", options=options))
    controller = Stamped(served.listen, served.instrument)
    controller.run(40, 0.012)
    result = served.end(ask=code == "operator")
    controller.close()
    assert result.summary.stopped.code == code
    assert result.session.state.total.any() == (code == "operator")
    assert result.summary.instrument_clock == InstrumentClock(kind="shared", drift_forgiven_ms=0.0)
    if code == "stale":
        assert "the clocks aren't the same one" in result.summary.stopped.text


# ---- tracker.toml and the command line ----


@pytest.fixture
def cell_of(tmp_path):
    """The cell with other [instrument] and [rsi] tables."""

    def make(instrument: str = "", rsi: str = "") -> Path:
        folder = tmp_path / "cell"
        shutil.copytree(CELL, folder)
        file = folder / "tracker.toml"
        before, _, rest = file.read_text(encoding="utf-8").partition("[instrument]")
        tables = "".join(
            f'[{name}]\nstanding = "assumed"\n{text}\n\n'
            for name, text in (("instrument", instrument), ("rsi", rsi))
            if text
        )
        file.write_text(before + tables + "[motion]" + rest.partition("[motion]")[2], encoding="utf-8")
        return folder

    return make


def test_the_cell_s_tables_reach_the_session(cell_of) -> None:
    folder = cell_of(
        'clock = "shared"\ndrift_ppm = 20\nfar_mm = 4\nfar_deg = 2\njump_mm = 0.3\njump_deg = 0.2',
        'allow = ["127.0.0.1:50001", "10.0.0.7:*"]\nstale_after = 3\nstop_after = 7\nlate_stop = 9\nsaturated_cycles = 11\n'
        'mode = "relative"\ncorrected = true\nsen_type = "Robot"',
    )
    settings = live_options(None, folder, {}).settings()
    assert (settings.clock, settings.corrected, settings.sen_type, settings.noisy) == ("shared", True, "Robot", True)
    assert settings.allow == (("127.0.0.1", 50001), ("10.0.0.7", None))
    assert [settings.drift, settings.error_m, settings.jump_m] == pytest.approx([2e-5, 4e-3, 3e-4])
    assert [settings.error_rad, settings.jump_rad] == pytest.approx([0.034906585, 0.0034906585])
    law = settings.law
    assert (law.stale_after_cycles, law.stop_after_cycles, settings.late_stop_cycles) == (3, 7, 9)
    assert settings.saturated_cycles == 11 and law.mode == "relative"
    said = {"bounds": ["saturated_cycles=12", "clock=own", "allow=1.2.3.4:5,1.2.3.4:*", "drift_ppm=30", "noise_mm=0"]}
    over = live_options(None, folder, said).settings()
    assert (over.saturated_cycles, over.clock, over.noisy) == (12, "own", False)
    assert over.allow == (("1.2.3.4", 5), ("1.2.3.4", None)) and over.drift == pytest.approx(3e-5)


def test_the_cell_as_shipped_says_what_the_loop_does_anyway() -> None:
    shipped = live_options(None, CELL, {})
    usual = LiveOptions()
    for name in read_tracker_case(CELL).link:
        assert getattr(shipped, name) == getattr(usual, name)
    assert shipped.noise_mm == pytest.approx(0.025) and shipped.allow == ()


def test_a_cell_without_the_tables_is_a_cell(cell_of) -> None:
    folder = cell_of()
    assert read_tracker_case(folder).link == {}
    assert live_options(None, folder, {}).saturated_cycles == 250


@pytest.mark.parametrize(
    ("instrument", "rsi", "word"),
    [
        ('clock = "gps"', "", "instrument.clock"),
        ("drift_ppm = -1", "", "instrument.drift_ppm"),
        ("latency_ms = nan", "", "instrument.latency_ms"),
        ("jump_mm = 0", "", "instrument.jump_mm"),
        ("speed = 3", "", "instrument.speed"),
        ("", "saturated_cycles = 0", "rsi.saturated_cycles"),
        ("", "saturated_cycles = 2.5", "rsi.saturated_cycles"),
        ("", "allow = []", "rsi.allow"),
        ("", 'allow = ["robot:5"]', "rsi.allow"),
        ("", 'allow = "1.2.3.4:5"', "rsi.allow"),
        ("", 'mode = "both"', "rsi.mode"),
        ("", "corrected = 1", "rsi.corrected"),
    ],
)
def test_a_table_that_makes_no_sense_names_file_and_key(cell_of, instrument, rsi, word) -> None:
    with pytest.raises(CellError) as caught:
        read_tracker_case(cell_of(instrument, rsi))
    assert word in str(caught.value) and "tracker.toml" in str(caught.value) and "\n" not in str(caught.value)


def test_a_latency_and_a_shared_clock_contradict_each_other(cell_of) -> None:
    folder = cell_of('clock = "shared"')
    with pytest.raises(InputError, match="latency"):
        track_live(cell=folder, said={"latency_ms": 5.0}, listen=f"{HOST}:0", instrument=f"{HOST}:0", duration_s=0.05)


@pytest.mark.slow
def test_what_cannot_be_seen_is_said() -> None:
    """No list, no shared clock: two warnings, each with the key that cures it; both given, none."""
    ends = {"listen": f"{HOST}:0", "instrument": f"{HOST}:0", "duration_s": 0.05}
    warnings = track_live(**ends).summary.warnings
    assert [w.code for w in warnings] == ["any-sender", "own-clock"]
    assert "[rsi] allow" in warnings[0].text and "constant part can't be seen" in warnings[1].text
    assert '[instrument] clock = "shared"' in warnings[1].text
    quiet = LiveOptions(clock="shared", allow=("127.0.0.1:5", "127.0.0.1:6"))
    assert track_live(options=quiet, **ends).summary.warnings == ()
    heard = []
    track_live(options=quiet, progress=lambda text, _share: heard.append(text), **ends)
    assert heard[0].endswith("for 127.0.0.1:5, 127.0.0.1:6")
