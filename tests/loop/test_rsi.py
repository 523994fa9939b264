"""The tracker loop as an interface: KUKA's frames, the correction law, and the server over loopback."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rsi_bench import CONTROLLER, LAW, POSE, STRANGER, TRACKER, Bench
from rsi_world import Plant, kuka_angles, kuka_rotation, line, rob, sen

from camrob.errors import InputError
from camrob.loop.law import CorrectionLaw, LawState, step
from camrob.loop.rsi.instrument import read_instrument
from camrob.loop.rsi.setpoints import SetpointHistory, rkorr_error
from camrob.loop.rsi.xml_frames import LONGEST_FRAME, read_rob, write_sen

# ---- the law ----


def test_the_law_sums_once_in_either_mode() -> None:
    """Against a sum kept here: absolute sends it, relative sends what it grew by, so that a receiver's own sum is the same."""
    rng = np.random.default_rng(3)
    errors = rng.normal(scale=1e-4, size=(200, 6))
    absolute, relative = LawState(), LawState()
    law_r = CorrectionLaw(0.1, 1e-3, 1e-2, mode="relative")
    mine, receiver = np.zeros(6), np.zeros(6)
    for e in errors:
        a, r = step(LAW, absolute, e), step(law_r, relative, e)
        absolute, relative = a.state, r.state
        mine = mine + 0.1 * e
        receiver = receiver + r.sent
        assert a.sent == pytest.approx(mine, abs=1e-15)
        assert r.sent == pytest.approx(0.1 * e, abs=1e-15)
        assert receiver == pytest.approx(a.sent, abs=1e-15)


def test_the_law_bounds_step_and_total_and_winds_nothing_up() -> None:
    law = CorrectionLaw(0.5, limit_m=1e-3, limit_rad=1e-2, step_m=4e-4, step_rad=1.0)
    state, sent = LawState(), []
    for _ in range(5):
        out = step(law, state, [1e-2, -1e-2, 0, 1e-2, 0, 0])
        state = out.state
        sent.append(out.sent[0])
        assert list(out.saturated[:3]) == [True, True, False]
    assert sent == pytest.approx([4e-4, 8e-4, 1e-3, 1e-3, 1e-3])
    assert step(law, state, [-2e-4, 0, 0, 0, 0, 0]).sent[0] == pytest.approx(9e-4)  # it leaves the bound at once


@pytest.mark.parametrize("mode", ["absolute", "relative"])
def test_without_a_measurement_the_law_holds_and_then_stops_for_good(mode) -> None:
    law = CorrectionLaw(0.1, 1e-3, 1e-2, mode=mode, stop_after_cycles=3)
    state = step(law, LawState(), [1e-3] * 6).state
    held = [1e-4] * 6 if mode == "absolute" else [0.0] * 6
    for _ in range(3):
        out = step(law, state, None)
        state = out.state
        assert out.answers and out.sent == pytest.approx(held)
    for error in (None, [1e-3] * 6, None):
        out = step(law, state, error)
        state = out.state
        assert not out.answers and not out.sent.any()


def test_the_law_refuses_what_is_no_error_and_no_law() -> None:
    for bad in ([np.nan] + [0.0] * 5, [np.inf] * 6, [0.0] * 5):
        with pytest.raises(InputError, match="six finite"):
            step(LAW, LawState(), bad)
    for wrong in (
        {"gain": 0.0},
        {"gain": np.nan},
        {"gain": 1.5},
        {"limit_m": np.inf},
        {"limit_rad": -1.0},
        {"cycle_s": 0.0},
    ):
        with pytest.raises(InputError):
            CorrectionLaw(**{"gain": 0.1, "limit_m": 1e-3, "limit_rad": 1e-2, **wrong})
    with pytest.raises(InputError, match="mode"):
        CorrectionLaw(0.1, 1e-3, 1e-2, mode="sum")
    assert LAW.is_stale(float("nan")) and LAW.is_stale(0.0081) and not LAW.is_stale(0.0079)


# ---- frames ----


def test_a_frame_is_read_and_answered_in_kuka_s_units() -> None:
    frame = read_rob(rob("0004208163634", POSE, (1, -2, 3, -4, 5, -6), extra='<AIPos A1="1" A2="-90.0"/><DiL>0</DiL>'))
    assert (frame.ipoc, frame.ticks) == ("0004208163634", 4208163634)
    assert frame.setpoint == pytest.approx([1.0, 0.2, 0.3, *np.radians([10, 20, 30])])
    assert frame.actual == pytest.approx([1e-3, -2e-3, 3e-3, *np.radians([-4, 5, -6])])
    ipoc, rkorr = sen(write_sen(frame.ipoc, [1e-3, -2e-3, -1e-13, 0.01, 0, -0.002], "Camrob"))
    assert ipoc == "0004208163634"
    assert rkorr == pytest.approx([1.0, -2.0, 0.0, np.degrees(0.01), 0.0, -np.degrees(0.002)], abs=1e-6)
    assert b"-0.000000" not in write_sen("1", [-1e-13] * 6) and b'X="0.000000"' in write_sen("1", [-1e-13] * 6)


GOOD = rob("123456", POSE).decode()
PUT = ["", "<", ">", '"', "&", "<!", "é", "9", "\x00", " ", "/>", "NaN"]
NO_MEASUREMENT = [
    b"1 2 3 4 1 0 0",
    b"1 2 3 nan 1 0 0 0",
    b"1 2 3 4 inf 0 0 0",
    b"1 2 3 4 1 0 0 1",
    b"1 2 3 4 0 0 0 0",
    b"1  2 3 4 1 0 0 0",
    b"1 2 3 4 1 0 0 0 9",
    b"1,2,3,4,1,0,0,0",
    b"1 2 3 1e300 1 0 0 0",
    b"",
    b"1 2 3 4 1 0 0 0\n\n",
    b"1 2 3 4 1 0 0 \xd9\xa0",
]
HOSTILE = {
    "entities": '<!DOCTYPE Rob [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>' + GOOD,
    "outside": '<!DOCTYPE Rob [<!ENTITY x SYSTEM "file:///etc/hostname">]>' + GOOD.replace("123456", "&x;"),
    "comment": GOOD.replace("<IPOC>", "<!-- --><IPOC>"),
    "cdata": GOOD.replace("123456", "<![CDATA[123456]]>"),
    "reference": GOOD.replace("123456", "12345&#54;"),
    "instruction": GOOD.replace("<IPOC>", "<?php ?><IPOC>"),
    "no ipoc": GOOD.replace("<IPOC>123456</IPOC>", ""),
    "two ipocs": GOOD.replace("<IPOC>123456</IPOC>", "<IPOC>123456</IPOC>" * 2),
    "empty ipoc": GOOD.replace("123456", ""),
    "ipoc with a child": GOOD.replace("123456", "1<a/>2"),
    "ipoc deeper": GOOD.replace("<IPOC>123456</IPOC>", "<x><IPOC>123456</IPOC></x>"),
    "negative ipoc": GOOD.replace("123456", "-5"),
    "long ipoc": GOOD.replace("123456", "1" * 19),
    "nan": GOOD.replace("200.0000", "NaN"),
    "inf": GOOD.replace("200.0000", "inf"),
    "overflow": GOOD.replace("200.0000", "1e999"),
    "far": GOOD.replace("200.0000", "1e6"),
    "comma": GOOD.replace("200.0000", "200,0"),
    "underscore": GOOD.replace("200.0000", "2_00"),
    "arabic digits": GOOD.replace("200.0000", "٢٠٠"),
    "empty number": GOOD.replace("200.0000", ""),
    "attribute twice": GOOD.replace('X="1000.0000"', 'X="1" X="2"'),
    "attribute missing": GOOD.replace('X="1000.0000"', ""),
    "attribute more": GOOD.replace('X="1000.0000"', 'X="1" Q="2"'),
    "no set-point": GOOD.replace("RSol", "RSal"),
    "two set-points": GOOD.replace("RIst", "RSol"),
    "another root": GOOD.replace("Rob", "Bob"),
    "another type": GOOD.replace("KUKA", "KUKO"),
    "two roots": GOOD + GOOD,
    "text after": GOOD + "x",
    "cut": GOOD[:-3],
    "not closed": GOOD.replace("</IPOC>", ""),
    "crossed": GOOD.replace("<IPOC>123456</IPOC></Rob>", "<IPOC>123456</Rob></IPOC>"),
    "nul": GOOD.replace("123456", "12\x003456"),
    "deep": GOOD.replace("<IPOC>", "<a>" * 20 + "</a>" * 20 + "<IPOC>"),
    "many": GOOD.replace("<IPOC>", "<a/>" * 300 + "<IPOC>"),
    "nothing": "",
    "sen": '<Sen Type="KUKA"><RKorr X="1"/><IPOC>1</IPOC></Sen>',
}


LONG_AND_FOREIGN = [
    b"\xff\xfe" + GOOD.encode(),
    GOOD.encode("utf-16"),
    GOOD.replace("KUKA", "KÜKA").encode("latin-1"),
    GOOD.replace("<IPOC>", " " * LONGEST_FRAME + "<IPOC>").encode(),
    b"<" * 70000,
    *(
        (GOOD[:-6] + part * (15000 // len(part))).encode()
        for part in ('a="1" ', "<a ", "<a>", " ", 'a = "', "<a b='", "&lt;", "</a>")
    ),
]


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_frame_is_refused(what) -> None:
    assert read_rob(GOOD.encode()).ticks == 123456
    with pytest.raises(InputError) as caught:
        read_rob(HOSTILE[what].encode())
    assert len(str(caught.value)) < 200 and str(caught.value).isprintable()


@pytest.mark.parametrize("data", LONG_AND_FOREIGN, ids=range(len(LONG_AND_FOREIGN)))
def test_bytes_that_are_no_text_and_frames_that_are_long_are_refused(data) -> None:
    """tests/bench/bench_rsi.py says how long that takes, and that nothing in the reader goes quadratic."""
    with pytest.raises(InputError):
        read_rob(data)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=400) | st.text(alphabet="<>/=\"'&!?ROBIPOCKUKA ers.XYZ0123", max_size=300).map(str.encode))
def test_any_bytes_are_read_or_refused(data) -> None:
    for read in (read_rob, read_instrument):
        try:
            read(data)
        except InputError:
            pass


@settings(max_examples=300, deadline=None)
@given(
    st.integers(0, len(GOOD) - 1),
    st.sampled_from(PUT),
    st.integers(0, 9),
)
def test_a_damaged_frame_is_read_or_refused_and_never_gives_what_is_no_number(at, put, cut) -> None:
    try:
        frame = read_rob((GOOD[:at] + put + GOOD[at + cut :]).encode())
    except InputError:
        return
    assert np.isfinite(frame.setpoint).all() and frame.ipoc.isdigit() and frame.ipoc.isascii()


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-0.01, 0.01), min_size=6, max_size=6), st.integers(0, 10**18 - 1))
def test_an_answer_says_what_was_meant(correction, ipoc) -> None:
    got, rkorr = sen(write_sen(str(ipoc), correction))
    assert got == str(ipoc)
    assert rkorr[:3] == pytest.approx(np.array(correction[:3]) * 1000, abs=1e-6)
    assert rkorr[3:] == pytest.approx(np.degrees(correction[3:]), abs=1e-6)


def test_what_is_no_correction_is_not_written() -> None:
    for bad in ([np.nan] * 6, [np.inf] + [0] * 5, [0.0] * 5, [1.0] + [0.0] * 5):
        with pytest.raises(InputError, match="correction"):
            write_sen("1", bad)
    for sen_type in ("", 'a"b', "<x>", "a" * 40):
        with pytest.raises(InputError, match="SENTYPE"):
            write_sen("1", [0.0] * 6, sen_type)
    with pytest.raises(InputError, match="IPOC"):
        write_sen("1</IPOC>", [0.0] * 6)


def test_the_instrument_s_line() -> None:
    R = kuka_rotation(*POSE[3:])
    pose = read_instrument(line(7.25, POSE[:3], R))
    assert pose.t_s == 7.25
    assert pose.tracker_T_tcp[:3, 3] == pytest.approx([1.0, 0.2, 0.3])
    assert pose.tracker_T_tcp[:3, :3] == pytest.approx(R, abs=1e-8)
    for bad in NO_MEASUREMENT:
        with pytest.raises(InputError):
            read_instrument(bad)


# ---- the error in RKorr's terms ----


@pytest.mark.parametrize(
    "abc", [(0, 0, 0), (90, 0, 0), (90, 30, 180), (-120, 80, 45), (0, 0, 180), (179.9, -20, -179.9)]
)
def test_rkorr_turns_about_the_base_s_axes_and_eq_3_does_not(abc) -> None:
    """A robot that is turned by a small R0 about the base's axes needs R0's inverse as RKorr, whatever the tool's attitude."""
    wanted = kuka_rotation(*abc)
    off = kuka_rotation(0.05, -0.08, 0.1)
    measured = np.eye(4)
    measured[:3, :3] = off @ wanted
    error, eq3 = rkorr_error(np.array([0, 0, 0, *np.radians(abc)]), measured)
    assert np.degrees(error[3:]) == pytest.approx(kuka_angles(off.T), abs=1e-9)
    assert kuka_rotation(*(np.array(kuka_angles(measured[:3, :3])) + np.degrees(eq3[3:]))) == pytest.approx(
        wanted, abs=1e-9
    )
    assert np.abs(np.degrees(eq3[3:])).max() < 1.0  # no jump by a whole turn
    parallel = abc[0] == 0 and abc[1] == 0
    assert np.allclose(error[3:], eq3[3:], atol=1e-5) == parallel


def test_the_set_point_is_that_of_the_measurement_s_time() -> None:
    history = SetpointHistory()
    for k in range(4):
        history.add(0.004 * k, np.array([0.1 * k, 0, 0, np.radians(175 + 2 * k), 0.1, 0.2]))
    got = history.at(0.009)
    assert got[0] == pytest.approx(0.225)
    a = kuka_rotation(179, np.degrees(0.1), np.degrees(0.2)).T @ kuka_rotation(*np.degrees(got[3:]))
    assert np.degrees(np.arccos((np.trace(a) - 1) / 2)) == pytest.approx(0.5, abs=1e-6)
    assert history.at(-1.0)[0] == 0.0 and history.at(1.0)[0] == pytest.approx(0.3)


# ---- the session: no sockets, a clock of the test's own ----


@pytest.mark.parametrize("setpoint", [POSE, (500, -300, 800, 90, 10, 180), (500, -300, 800, -90, 80, 179.95)])
def test_both_modes_close_the_loop_alike(setpoint) -> None:
    """Number by number the same robot, in either mode: were anything summed twice, one of them would run away."""
    wide = {"gain": 0.05, "limit_m": 2e-3, "limit_rad": 2e-2}
    benches = [Bench(CorrectionLaw(mode=mode, **wide)) for mode in ("absolute", "relative")]
    errors = []
    for _ in range(300):
        for bench in benches:
            bench.cycle(setpoint)
        errors.append([b.plant.error(setpoint) for b in benches])
        assert benches[0].plant.correction == pytest.approx(benches[1].plant.correction, abs=1e-4)
    errors = np.array(errors)
    assert errors[-1].max() < 1e-4 < errors[0].min()
    k = 40  # a proportional gain of 0.05 each cycle takes the rest times 0.95, whatever the attitude
    assert errors[k + 20, 0, 0] / errors[k, 0, 0] == pytest.approx(0.95**20, rel=0.01)
    assert errors[k + 20, 0, 1] / errors[k, 0, 1] == pytest.approx(0.95**20, rel=0.05)


def test_eq_3_s_angles_sent_as_they_are_would_not_close_the_loop() -> None:
    """What the conversion is there for: at A = 90 degrees the angles as printed in eq. 3 turn the tool the wrong way."""
    setpoint, plant = (0, 0, 0, 90.0, 10.0, 180.0), Plant("relative")
    before = plant.error(setpoint)[1]
    for _ in range(200):
        _, R = plant.actual(setpoint)
        difference = np.array(setpoint[3:]) - kuka_angles(R)
        plant.receive(np.concatenate([np.zeros(3), 0.05 * ((difference + 180) % 360 - 180)]))
    assert plant.error(setpoint)[1] > before


@pytest.mark.parametrize("mode", ["absolute", "relative"])
def test_a_set_point_that_holds_the_correction_is_taken_back(mode) -> None:
    def shown(bench):
        R = kuka_rotation(*bench.plant.correction[3:]) @ kuka_rotation(*POSE[3:])
        return (*(np.array(POSE[:3]) + bench.plant.correction[:3]), *kuka_angles(R))

    law = CorrectionLaw(0.05, 2e-3, 2e-2, mode=mode)
    for corrected in (True, False):
        bench = Bench(law, corrected=corrected)
        for _ in range(300):
            bench.frame(shown(bench))
            bench.measure()
        # believed to be the program's, the set-point runs away with the correction until the bound
        assert (bench.plant.error(POSE)[0] < 2e-3) == corrected
    assert np.abs(bench.plant.correction[:3]).max() == pytest.approx(2.0, abs=1e-3)


def test_the_correction_is_saturated_and_said() -> None:
    bench = Bench(CorrectionLaw(0.5, limit_m=1e-4, limit_rad=1e-3, step_m=3e-5))
    sent = [bench.cycle().sent for _ in range(12)]
    assert np.abs(np.array(sent))[:, :3].max() == pytest.approx(1e-4)
    assert np.abs(np.diff(np.array(sent)[:, :3], axis=0)).max() < 3.0001e-5
    assert bench.session.counts.saturated >= 10


@pytest.mark.parametrize("mode", ["absolute", "relative"])
def test_a_stale_measurement_is_held_and_then_the_robot_is_stopped(mode) -> None:
    bench = Bench(CorrectionLaw(0.1, 1e-3, 1e-2, mode=mode, stale_after_cycles=2, stop_after_cycles=5))
    for _ in range(10):
        bench.cycle()
    total = bench.session.state.total
    seen = [bench.frame() for _ in range(12)]  # the beam is lost: no measurement any more
    sources = [a.source for a in seen if a]
    # the last measurement is good for two cycles more or less its age, then five cycles are held, then there is silence
    assert sources == [0, 0, *[1] * 5] or sources == [0, *[1] * 5]
    held = [sen(a.data)[1] for a in seen if a and a.source == 1]
    if mode == "relative":
        assert not np.any(held)
    else:
        last = next(a for a in reversed(seen) if a and a.source == 0)
        assert np.array(held) == pytest.approx(np.tile(sen(last.data)[1], (5, 1)))
        assert np.abs(held[0][:3]).max() >= np.abs(total[:3] * 1000).max() > 0.1
    assert bench.session.stopped.code == "stale" and "fresh measurement" in bench.session.stopped.text
    bench.measure()
    assert bench.frame() is None  # for good, though the beam is back
    assert bench.session.counts.unanswered_after_stop == 12 - len(sources) - 1 + 1


def test_an_instrument_that_never_comes_or_talks_nonsense_stops_the_robot_too() -> None:
    bench = Bench()
    assert [bench.frame() is not None for _ in range(7)] == [True] * 5 + [False] * 2
    assert "no measurement has come" in bench.session.stopped.text
    bench = Bench()
    for k in range(7):
        bench.session.measure(b"%d 1 2 3 nan 0 0 0" % k, TRACKER, bench.now)
        bench.frame()
    assert bench.session.stopped.code == "stale"
    assert sum(bench.session.counts.measurements_refused.values()) == 7
    assert not bench.session.state.total.any()


def test_a_wrong_frame_is_not_followed() -> None:
    """A tracker whose frame is 20 mm off, or turned: nothing is corrected, and the reason says so."""
    for frame in (np.array([[1, 0, 0, 0.02], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]), np.diag([-1.0, -1, 1, 1])):
        bench = Bench(base_T_tracker=frame)
        answers = [bench.cycle() for _ in range(10)]
        assert answers[5] is None or not answers[5].sent.any()
        assert bench.session.stopped.code == "stale" and "wrong frame" in bench.session.stopped.text
        assert bench.session.counts.held_implausible >= 4 and not bench.session.state.total.any()


def test_the_tracker_s_frame_is_applied_in_the_order_that_cancels() -> None:
    base_T_tracker = np.eye(4)
    base_T_tracker[:3, :3], base_T_tracker[:3, 3] = kuka_rotation(70, 5, -8), [2.0, -1.0, 0.5]
    bench = Bench(base_T_tracker=base_T_tracker)
    bench.frame()
    p, R = bench.plant.actual(POSE)
    inverse = base_T_tracker[:3, :3].T
    bench.session.measure(
        line(9.0, 1000 * inverse @ (p / 1000 - base_T_tracker[:3, 3]), inverse @ R), TRACKER, bench.now
    )
    answer = bench.frame()
    assert 1000 * answer.error[:3] == pytest.approx(-bench.plant.off_mm, abs=1e-6)


def test_a_measurement_is_held_against_the_set_point_of_its_own_time() -> None:
    """A robot that follows its program exactly at 12 mm/s shows no error, though the instrument reports 9 ms late."""

    def program(time_s: float):
        return (500 + 12 * time_s, -6 * time_s, 300, 10 + 2 * time_s, 20, 30)

    errors = []
    for latency in (0.009, 0.0):
        bench = Bench(latency_s=latency)
        for k in range(40):
            true = bench.now + 0.0025 - 0.009  # what the datagram that arrives 2.5 ms after this frame has seen
            p, R = np.array(program(true)[:3]), kuka_rotation(*program(true)[3:])
            bench.session.measure(line(100 + 0.004 * k, p, R), TRACKER, bench.now + 0.0025)
            answer = bench.frame(program(bench.now + 0.004))
        errors.append(np.abs(answer.error[:3]).max() * 1000)
    assert errors[0] < 2e-4
    assert errors[1] == pytest.approx(12 * 0.009, rel=0.01)


def test_only_one_instrument_and_only_a_clock_that_grows() -> None:
    bench = Bench()
    bench.measure()
    bench.measure(sender=STRANGER)
    bench.session.measure(line(bench.t_s - 0.004, *bench.plant.actual(POSE)), TRACKER, bench.now)
    bench.session.measure(line(0.5, *bench.plant.actual(POSE)), TRACKER, bench.now)
    counts = bench.session.counts
    assert (counts.measurements_kept, counts.measurements_other_sender) == (1, 1)
    assert counts.measurements_refused == {"a measurement's time doesn't grow": 2}


def test_repeated_and_older_frames_are_counted_and_not_answered() -> None:
    bench = Bench()
    for _ in range(3):
        bench.cycle()
    before = bench.session.state.total
    for ticks, data in ((0, None), (-8, None)):
        assert bench.frame(ticks=ticks, data=data) is None
    bench.ipoc += 8
    assert (bench.session.state.total == before).all()
    bench.frame(ticks=16)  # three frames of 4 ms never came
    counts = bench.session.counts
    assert (counts.duplicate, counts.out_of_order, counts.missed) == (1, 1, 3)


def test_a_frame_that_waited_longer_than_a_cycle_is_answered_by_holding() -> None:
    for mode in ("absolute", "relative"):
        bench = Bench(CorrectionLaw(0.1, 1e-3, 1e-2, mode=mode), late_stop_cycles=4)
        for _ in range(5):
            bench.cycle()
        total = bench.session.state.total
        answers = []
        for _ in range(6):
            bench.measure()
            answers.append(bench.frame(waited=0.005))
        assert [a is not None for a in answers] == [True] * 4 + [False] * 2
        expected = total if mode == "absolute" else np.zeros(6)
        assert all((a.sent == expected).all() for a in answers[:4]) and (bench.session.state.total == total).all()
        assert bench.session.stopped.code == "late" and bench.session.counts.answered_late == 5


def test_silence_stops_for_good() -> None:
    bench = Bench(late_stop_cycles=10)
    bench.cycle()
    assert not bench.session.silent(bench.now + 0.039)
    assert bench.session.silent(bench.now + 0.041) and bench.session.stopped.code == "silent"
    assert bench.cycle() is None
    bench = Bench(late_stop_cycles=10)  # the server itself slept: the gap between arrivals counts
    bench.cycle()
    bench.now += 0.1
    assert bench.frame() is None and bench.session.stopped.code == "silent"


def test_a_stranger_s_noise_does_not_hide_the_controller_s_silence() -> None:
    bench = Bench(late_stop_cycles=10)
    bench.cycle()
    for _ in range(12):
        assert bench.frame(sender=STRANGER) is None
    assert bench.session.stopped.code == "silent"
    assert bench.session.counts.other_sender >= 9 and not bench.session.counts.refused


@settings(max_examples=25, deadline=None)
@given(st.lists(st.binary(max_size=120) | st.sampled_from([v.encode("utf-8") for v in HOSTILE.values()]), max_size=12))
def test_hostile_frames_change_nothing(noise) -> None:
    quiet, loud = Bench(), Bench()
    for bench, junk in ((quiet, []), (loud, noise)):
        for k in range(20):
            for data in junk[k : k + 1]:
                assert bench.session.answer(data, CONTROLLER, bench.now + 0.001, bench.now + 0.001) is None
                bench.session.measure(data, TRACKER, bench.now)
            bench.cycle()
    assert (quiet.session.state.total == loud.session.state.total).all()
    assert sum(loud.session.counts.refused.values()) == min(len(noise), 20)
