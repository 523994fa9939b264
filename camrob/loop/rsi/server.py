"""The tracker loop as a UDP server: it answers a KUKA controller's RSI frames from an instrument's stream.

On the controller's side: an RSI context with ETHERNET -> POSCORR (RefCorrSys = Base), POSCORRMON, and an Ethernet
configuration whose IP_NUMBER and PORT are this server's, SENTYPE its `sen_type`, ONLYSEND FALSE; SEND holds DEF_RIst and
DEF_RSol (INDX INTERNAL), RECEIVE holds RKorr.X, .Y, .Z, .A, .B, .C (DOUBLE, INDX 1 to 6). For a server in mode `absolute`,
RSI_ON is given #ABSOLUTE and HOLDON is "1" (a late answer keeps the last total; with "0" it would jump back to zero). In mode
`relative`, #RELATIVE and HOLDON "0" (with "1" a late answer would add the last step again). ETHERNET's Timeout, in cycles, is
what ends RSI after this server stopped answering; the limits of POSCORR and POSCORRMON stand a little above the law's. The
cycle is 4 ms (#IPO_FAST) or 12 ms (#IPO), as RSI_ON says. Whether RSol already holds the correction has to be tried on the
controller once: with the instrument covered, move by a known correction and look at RSol.

On the instrument's side: stamps of the measured instant. Where they are said to share this machine's clock, they are compared
with the kernel's time of arrival on the system clock, which PTP or NTP has to keep true; if it is set while the loop runs, all
ages change at once, and the loop stops. UDP has no passwords: the list of allowed senders keeps out mistakes, not somebody who
forges addresses, so that the three belong on a network of their own.

An answer goes to the address and port that the frame came from. One thread waits on both sockets; the instrument's datagrams
are taken in first, so that an answer is made from the newest. Where the kernel stamps datagrams, latency counts from there.
"""

from __future__ import annotations

import contextlib
import gc
import os
import select
import socket
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from camrob.errors import InputError
from camrob.loop.rsi.cycle_log import CycleLog
from camrob.loop.rsi.link import Address, LinkSettings
from camrob.loop.rsi.session import TrackerSession
from camrob.loop.rsi.xml_frames import LONGEST_FRAME

__all__ = ["RsiServer"]

_STAMP = getattr(socket, "SO_TIMESTAMPNS", 35)  # Linux; Python doesn't name it everywhere
_TIMESPEC = struct.Struct("@ll")
_PRIORITY = 50  # of 1 to 99: before all ordinary threads, after the kernel's own
_AT_ONCE = 64  # datagrams of one socket, before the other one has its turn
_WARM = 40  # frames
_PATIENCE_S = 0.02  # the longest wait before duration, silence and `should_stop` are looked at
_LONGEST_STAMP_S = 10.0  # a stamp that is older comes from a clock that was set


class RsiServer:
    """Binds both ports at once and keeps them until closed; a context manager.

    `listen` and `instrument` are IPv4 addresses and ports; port 0 takes a free one. Raises InputError for one that can't be
    bound.
    """

    def __init__(self, settings: LinkSettings, *, listen: Address, instrument: Address) -> None:
        self.session = TrackerSession(settings)
        self.log = CycleLog()
        self.kernel_stamps = False
        _warm(settings)
        gc.collect()
        self._frames = _bound(listen)
        try:
            self._measurements = _bound(instrument)
        except InputError:
            self._frames.close()
            raise
        for s in (self._frames, self._measurements):
            with contextlib.suppress(OSError):
                s.setsockopt(socket.SOL_SOCKET, _STAMP, 1)

    def __enter__(self) -> RsiServer:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    @property
    def controller_address(self) -> Address:
        """Where the controller's frames are awaited."""
        return _address(self._frames.getsockname())

    @property
    def instrument_address(self) -> Address:
        """Where the instrument's datagrams are awaited."""
        return _address(self._measurements.getsockname())

    def close(self) -> None:
        """Give both ports back."""
        self._frames.close()
        self._measurements.close()

    def serve(
        self,
        *,
        duration_s: float | None = None,
        should_stop: Callable[[], bool] = lambda: False,
        realtime: bool = False,
    ) -> TrackerSession:
        """Answer until a fault, the end of `duration_s`, an interruption or `should_stop`; the session says which it was.

        Every fault ends it, and with it the answers: the controller stops the robot. `realtime` asks the system to run this
        thread before all ordinary ones (SCHED_FIFO). Raises InputError where the system doesn't allow that.
        """
        end = float("inf") if duration_s is None else time.monotonic() + duration_s
        session = self.session
        with _no_pauses(), _first_in_line(realtime):
            try:
                while session.stopped is None:
                    self._turn(session)
                    if time.monotonic() >= end:
                        session.stop("duration", "the time asked for is over")
                    elif should_stop():
                        session.stop("operator", "stopped by the operator")
            except KeyboardInterrupt:
                session.stop("operator", "stopped by the operator")
            except OSError as error:
                session.stop("socket", f"a socket failed ({error.strerror or type(error).__name__})")
            except Exception as error:  # whatever it is, the robot has to stop and the reason has to be known
                session.stop("internal", f"internal error ({type(error).__name__}: {error})")
        return session

    def _turn(self, session: TrackerSession) -> None:
        """Wait for datagrams and deal with those that came."""
        ready = select.select([self._frames, self._measurements], [], [], _PATIENCE_S)[0]
        for data, sender, at_s, stamp_s in self._received(self._measurements) if self._measurements in ready else ():
            session.measure(data, sender, at_s, stamp_s)
        if self._frames not in ready:
            session.silent(time.monotonic())
            return
        for data, sender, at_s, stamp_s in self._received(self._frames):
            answer = session.answer(data, sender, at_s, time.monotonic())
            if answer is not None:
                self._frames.sendto(answer.data, sender)
                self.log.add(answer, at_s, time.time() - stamp_s)

    def _received(self, source: socket.socket) -> Iterator[tuple[bytes, Address, float, float]]:
        """Datagrams that wait: bytes, sender, arrival on the monotonic clock, and on the wall clock."""
        for _ in range(_AT_ONCE):
            try:
                data, ancillary, _, sender = source.recvmsg(LONGEST_FRAME + 1, 64)
            except BlockingIOError:
                return
            now, wall = time.monotonic(), time.time()
            stamp = _stamp(ancillary)
            if stamp is None or not 0.0 <= wall - stamp <= _LONGEST_STAMP_S:
                stamp = wall
            else:
                self.kernel_stamps = True
            yield data, _address(sender), now - (wall - stamp), stamp


def _warm(settings: LinkSettings) -> None:
    """Answer made-up frames in a session of their own, so that the first real answer doesn't wait for what is set up once."""
    law = replace(settings.law, gain=1.0)  # so that all that is looked at now and then is looked at here
    session = TrackerSession(replace(settings, law=law, base_T_tracker=np.eye(4), allow=()))
    nobody, pose = ("", 0), 'X="1" Y="2" Z="3" A="0" B="0" C="0"'
    for k in range(1, _WARM + 1):
        at_s = k * law.cycle_s
        session.measure(f"{at_s} 1 2 3.{k} 1 0 0 0".encode("ascii"), nobody, at_s)
        frame = f'<Rob Type="KUKA"><RIst {pose}/><RSol {pose}/><IPOC>{k}</IPOC></Rob>'
        session.answer(frame.encode("ascii"), nobody, at_s, at_s)


def _stamp(ancillary: list[tuple[int, int, bytes]]) -> float | None:
    """When the kernel received a datagram, s on the wall clock."""
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == _STAMP and len(data) >= _TIMESPEC.size:
            seconds, nanoseconds = _TIMESPEC.unpack_from(data)
            return float(seconds + nanoseconds * 1e-9)
    return None


def _bound(address: Address) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.setblocking(False)
        made.bind(address)
    except (OSError, OverflowError) as error:
        made.close()
        what = getattr(error, "strerror", None) or "no such port"
        raise InputError(
            f"{address[0]}:{address[1]} can't be listened on ({what})",
            hint="choose an address of this machine, a free port",
        ) from None
    return made


def _address(name: Any) -> Address:
    return str(name[0]), int(name[1])


@contextlib.contextmanager
def _no_pauses() -> Iterator[None]:
    """While it lasts, memory isn't collected: a collection takes milliseconds, and the loop makes no cycles."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


@contextlib.contextmanager
def _first_in_line(asked: bool) -> Iterator[None]:
    """While it lasts, this thread runs as soon as it can, whatever ordinary threads do."""
    if not asked:
        yield
        return
    hint = "run as root or with CAP_SYS_NICE on Linux, or leave the option out"
    if not hasattr(os, "sched_setscheduler"):
        raise InputError("this system has no real-time threads", hint=hint)
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except OSError as error:
        raise InputError(f"real-time priority isn't given ({error.strerror})", hint=hint) from None
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)
