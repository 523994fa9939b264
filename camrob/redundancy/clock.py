"""Until when a plan is bettered."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

__all__ = ["Clock"]


@dataclass(frozen=True, slots=True)
class Clock:
    """Runs from when it is made. seconds: how long a plan may be bettered, None for as long as there is something to do."""

    seconds: float | None = None
    begun: float = field(default_factory=time.monotonic)

    @property
    def taken(self) -> float:
        """Seconds since it was made."""
        return time.monotonic() - self.begun

    @property
    def left(self) -> float | None:
        """Seconds that are left, None without an end."""
        return None if self.seconds is None else max(0.0, self.seconds - self.taken)

    @property
    def up(self) -> bool:
        """Whether the time is over."""
        return self.seconds is not None and self.taken >= self.seconds
