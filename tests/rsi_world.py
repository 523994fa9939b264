"""A controller, a robot and an instrument for the tracker server's tests: XML and geometry of their own, not camrob's."""

from __future__ import annotations

import math
import select
import socket
import threading
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

import numpy as np

HOST = "127.0.0.1"


def turn(axis: str, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    rows = {"z": [[c, -s, 0], [s, c, 0], [0, 0, 1]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]]}
    return np.array(rows.get(axis, [[1, 0, 0], [0, c, -s], [0, s, c]]))


def kuka_rotation(a: float, b: float, c: float) -> np.ndarray:
    return turn("z", a) @ turn("y", b) @ turn("x", c)


def kuka_angles(R: np.ndarray) -> list[float]:
    cb = math.hypot(R[0, 0], R[1, 0])
    return [
        math.degrees(v) for v in (math.atan2(R[1, 0], R[0, 0]), math.atan2(-R[2, 0], cb), math.atan2(R[2, 1], R[2, 2]))
    ]


def quaternion(R: np.ndarray) -> list[float]:
    """Through the eigenvector of eigenvalue 1 and the trace; not near half a turn."""
    w = math.sqrt(max(1.0 + R[0, 0] + R[1, 1] + R[2, 2], 0.0)) / 2.0
    return [w, (R[2, 1] - R[1, 2]) / (4 * w), (R[0, 2] - R[2, 0]) / (4 * w), (R[1, 0] - R[0, 1]) / (4 * w)]


def pose_text(tag: str, pose) -> str:
    return f"<{tag} " + " ".join(f'{n}="{v:.4f}"' for n, v in zip("XYZABC", pose, strict=True)) + "/>"


def rob(ipoc: int | str, setpoint, actual=None, extra: str = "") -> bytes:
    actual = setpoint if actual is None else actual
    return (
        f'<Rob Type="KUKA">{pose_text("RIst", actual)}{pose_text("RSol", setpoint)}{extra}'
        f'<Delay D="0"/><Tech C11="0.000000" C12="0.000000"/><IPOC>{ipoc}</IPOC></Rob>'
    ).encode()


def sen(data: bytes) -> tuple[str, np.ndarray]:
    """IPOC and RKorr, mm and degrees, of an answer, by the standard library's parser."""
    root = ElementTree.fromstring(data.decode("ascii"))
    assert root.tag == "Sen" and root.get("Type")
    assert [child.tag for child in root] == ["RKorr", "IPOC"]
    return root[1].text, np.array([float(root[0].attrib[n]) for n in "XYZABC"])


def line(t_s: float, p_mm, R: np.ndarray) -> bytes:
    return " ".join(f"{v:.9f}" for v in [t_s, *p_mm, *quaternion(R)]).encode() + b"\n"


@dataclass
class Plant:
    """A robot that stands `off_mm` and `off_deg` (in the base's axes) away from where it is sent; POSCORR in `$BASE`."""

    mode: str
    off_mm: np.ndarray = field(default_factory=lambda: np.array([0.3, -0.2, 0.4]))
    off_deg: tuple[float, float, float] = (0.1, -0.12, 0.15)
    correction: np.ndarray = field(default_factory=lambda: np.zeros(6))

    def receive(self, rkorr: np.ndarray) -> None:
        """#ABSOLUTE replaces the correction, #RELATIVE adds to it: what the controller's own sum does."""
        self.correction = rkorr.copy() if self.mode == "absolute" else self.correction + rkorr

    def actual(self, setpoint) -> tuple[np.ndarray, np.ndarray]:
        R = kuka_rotation(*self.off_deg) @ kuka_rotation(*self.correction[3:]) @ kuka_rotation(*setpoint[3:])
        return np.asarray(setpoint[:3]) + self.correction[:3] + self.off_mm, R

    def error(self, setpoint) -> tuple[float, float]:
        """Distance, mm, and angle, degrees, between where the robot is and where the program wants it."""
        p, R = self.actual(setpoint)
        E = R @ kuka_rotation(*setpoint[3:]).T
        skew = np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]) / 2
        return float(np.linalg.norm(p - setpoint[:3])), math.degrees(math.asin(min(float(np.linalg.norm(skew)), 1.0)))


@dataclass
class Heard:
    """What the controller got: IPOC sent, and for each answer its IPOC, RKorr, and the time since the frame was sent."""

    sent: list[str] = field(default_factory=list)
    answers: list[tuple[str, np.ndarray, float]] = field(default_factory=list)

    @property
    def latencies_ms(self) -> np.ndarray:
        return np.array([a[2] for a in self.answers]) * 1e3


class Controller:
    """Sends frames on a schedule and takes answers, in the thread that calls `run`."""

    def __init__(self, server: tuple[str, int], instrument: tuple[str, int], plant: Plant | None = None) -> None:
        self.server, self.instrument = server, instrument
        self.plant = plant or Plant("absolute")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((HOST, 0))
        self.tracker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.tracker.bind((HOST, 0))
        self.ipoc = 4208163634

    def close(self) -> None:
        self.socket.close()
        self.tracker.close()

    def measure(self, setpoint) -> None:
        """A clock of the instrument's own, 100 s off, but as true as this machine's."""
        self.tracker.sendto(line(time.monotonic() + 100.0, *self.plant.actual(setpoint)), self.instrument)

    def run(
        self,
        cycles: int,
        cycle_s: float,
        *,
        path=lambda k: (1000.0, 200.0, 300.0, 10.0, 20.0, 30.0),
        measured=lambda k: True,
    ) -> Heard:
        heard, times = Heard(), {}
        start = time.monotonic()
        for k in range(cycles):
            setpoint = path(k)
            if measured(k):
                self.measure(setpoint)
            self.ipoc += round(cycle_s * 1000)
            times[str(self.ipoc)] = time.monotonic()
            self.socket.sendto(rob(self.ipoc, setpoint), self.server)
            heard.sent.append(str(self.ipoc))
            self._listen(heard, times, start + (k + 1) * cycle_s)
        deadline = time.monotonic() + 0.5
        while len(heard.answers) < cycles and time.monotonic() < deadline:
            self._listen(heard, times, min(deadline, time.monotonic() + 0.02))
        return heard

    def _listen(self, heard: Heard, times: dict[str, float], until: float) -> None:
        while (left := until - time.monotonic()) > 0:
            if not select.select([self.socket], [], [], left)[0]:
                return
            data, sender = self.socket.recvfrom(65536)
            now = time.monotonic()
            assert sender == self.server
            ipoc, rkorr = sen(data)
            heard.answers.append((ipoc, rkorr, now - times[ipoc]))
            self.plant.receive(rkorr)


class Served:
    """A server in a thread of its own, from a factory of its result; stops and joins at the end."""

    def __init__(self, job) -> None:
        self.ready, self.halt, self.result, self.error = threading.Event(), threading.Event(), None, None
        self.server = None

        def note(server) -> None:
            self.server = server
            self.ready.set()

        def work() -> None:
            try:
                self.result = job(ready=note, should_stop=self.halt.is_set)
            except BaseException as error:
                self.error = error
                self.ready.set()

        self.thread = threading.Thread(target=work, daemon=True)
        self.thread.start()
        assert self.ready.wait(120.0) and self.error is None, self.error  # it starts late on a busy machine
        self.listen, self.instrument = self.server.controller_address, self.server.instrument_address

    def end(self, ask: bool = True):
        if ask:
            self.halt.set()
        self.thread.join(60.0)
        assert not self.thread.is_alive()
        if self.error is not None:
            raise self.error
        return self.result
