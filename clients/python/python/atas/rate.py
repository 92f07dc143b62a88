"""A loop at a steady rate."""

import time
from collections.abc import Iterator


class Rate:
    """Wakes up `hz` times a second, by the clock and not by the time that the loop takes.

    ``for tick in Rate(1000): ...`` runs for ever, with `seconds` for so long. `late` counts the times that a wake-up had already
    passed; those are not made up for by haste, except by the one that follows at once.
    """

    def __init__(self, hz: float, seconds: float | None = None) -> None:
        if not 0 < hz <= 100_000:
            raise ValueError(f"a rate was {hz} Hz, needs more than 0 and at most 100000")
        self._period_ns = round(1e9 / hz)
        self._ticks = None if seconds is None else round(seconds * hz)
        self.late = 0

    def __iter__(self) -> Iterator[int]:
        clock, sleep, period_ns = time.monotonic_ns, time.sleep, self._period_ns
        due_ns = clock()
        tick = 0
        while tick != self._ticks:
            left_ns = due_ns - clock()
            if left_ns > 0:
                sleep(left_ns * 1e-9)
            elif tick > 0:
                self.late += 1
                if left_ns < -100_000_000:
                    due_ns = clock()
            yield tick
            due_ns += period_ns
            tick += 1
