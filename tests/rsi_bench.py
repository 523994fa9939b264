"""A session under test: no sockets, a clock of the test's own, and an instrument that can be made to lie."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from rsi_world import HOST, Plant, kuka_rotation, line, rob, sen

from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.link import LinkSettings
from camrob.loop.rsi.session import TrackerSession

POSE = (1000.0, 200.0, 300.0, 10.0, 20.0, 30.0)
CONTROLLER, TRACKER, STRANGER = (HOST, 50001), (HOST, 50002), (HOST, 50003)
LAW = CorrectionLaw(gain=0.1, limit_m=1e-3, limit_rad=1e-2, stale_after_cycles=2, stop_after_cycles=5, cycle_s=0.004)


class Bench:
    """A session with a plant: frames every cycle, measurements just before them."""

    def __init__(self, law=LAW, plant=None, **settings) -> None:
        self.session = TrackerSession(LinkSettings(law, **settings))
        self.plant = plant or Plant(law.mode)
        self.now, self.ipoc, self.t_s = 50.0, 1000, 1.0

    def measure(self, setpoint=POSE, sender=TRACKER) -> None:
        self.t_s += 0.004
        self.session.measure(line(self.t_s, *self.plant.actual(setpoint)), sender, self.now)

    def frame(self, shown=POSE, *, waited=1e-4, ticks=4, data=None, sender=CONTROLLER):
        self.now += self.session.settings.law.cycle_s
        self.ipoc += ticks
        answer = self.session.answer(
            rob(self.ipoc, shown) if data is None else data, sender, self.now, self.now + waited
        )
        if answer is not None:
            ipoc, rkorr = sen(answer.data)
            assert ipoc == str(self.ipoc)
            self.plant.receive(rkorr)
        return answer

    def cycle(self, setpoint=POSE):
        answer = self.frame(setpoint)
        self.measure(setpoint)
        return answer


@dataclass
class Robot(Plant):
    """A plant that takes its time: corrections come through 3 cycles and a lag of 70 ms later, and turned by `frame`, as a
    controller does that takes them in axes of another frame. `noise_mm`, `noise_deg` are the instrument's, drawn from `seed`.
    """

    frame: np.ndarray = field(default_factory=lambda: np.eye(3))
    lag_s: float = 0.07
    noise_mm: float = 0.025
    noise_deg: float = 0.003
    seed: int = 4

    def __post_init__(self) -> None:
        self.waiting = deque([np.zeros(6)] * 3)
        self.rng = np.random.default_rng(self.seed)

    def receive(self, rkorr: np.ndarray) -> None:
        self.waiting.append(rkorr)
        asked = self.waiting.popleft()
        share = 1.0 - np.exp(-0.004 / self.lag_s) if self.lag_s else 1.0
        turned = np.concatenate(
            [self.frame @ asked[:3], (self.frame @ asked[:2:-1])[::-1]]
        )  # A, B, C turn about Z, Y, X
        self.correction = self.correction + share * (turned - self.correction)

    def actual(self, setpoint) -> tuple[np.ndarray, np.ndarray]:
        p, R = super().actual(setpoint)
        noise = self.rng.standard_normal(6)
        return p + self.noise_mm * noise[:3], kuka_rotation(*(self.noise_deg * noise[3:])) @ R


class Telling(Bench):
    """A bench whose program moves and whose instrument's lines go through the test's hands before they are sent.

    `program(t)` is the set-point, mm and degrees, at a time since the start, `lie(k, t, p, R)` what is sent in cycle k of a
    measurement true at t: a line, several, or None. `late(k)`: by how much the line arrives later than it was true, `behind_s`:
    by how much the robot is later than its program, s; its other errors are the plant's.
    """

    behind_s = 0.0

    def __init__(
        self, law=LAW, *, program=lambda t: POSE, lie=lambda k, t, p, R: line(t, p, R), late=lambda k: 0.001, **more
    ):
        super().__init__(law, **more)
        self.program, self.lie, self.late = program, lie, late
        self.start, self.k = self.now, 0

    def turn(self):
        """A line, then a frame one cycle after the last one: the answer."""
        arrives = self.now + 0.003
        true = arrives - self.late(self.k)
        p, R = self.plant.actual(self.program(true - self.start - self.behind_s))
        sent = self.lie(self.k, true + 1000.0, p, R)
        for data in [] if sent is None else sent if isinstance(sent, list) else [sent]:
            self.session.measure(data, TRACKER, arrives, arrives + 1000.0)
        self.k += 1
        return self.frame(self.program(self.now + self.session.settings.law.cycle_s - self.start))

    def turns(self, count: int) -> list[int]:
        """What the answers of so many cycles were made from, up to the first frame without one."""
        sources = []
        for _ in range(count):
            answer = self.turn()
            if answer is None:
                break
            sources.append(answer.source)
        return sources

    @property
    def why(self) -> tuple[str, str]:
        """Code and text of the stop."""
        assert self.session.stopped is not None
        return self.session.stopped
