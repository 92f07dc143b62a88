"""Loop with a fixed rate."""

import time
from collections.abc import Iterator


class Rate:
    """Iterates at `hz`, independent of the duration of the loop body.

    ``for tick in Rate(1000): ...`` runs without end, or for `seconds`. `late` counts missed wake-up times. After a missed time
    the next iteration starts at once; delays over 0.1 s are not caught up.
    """

    def __init__(self, hz: float, seconds: float | None = None) -> None:
        if not 0 < hz <= 100_000:
            raise ValueError(f"invalid rate {hz} Hz; needs more than 0 and at most 100000 Hz")
        self._hz, self._period_ns = hz, round(1e9 / hz)
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

    def __repr__(self) -> str:
        length = "without end" if self._ticks is None else f"{self._ticks} iterations"
        return f"<atas.Rate {self._hz:g} Hz, {length}: {self.late} late>"
