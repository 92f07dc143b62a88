"""Execution of action chunks, with a watchdog.

A chunk is an array (steps, values): the poses of the next steps, one per period. The executor asks
for the next chunk while it executes the present one. Rows whose time has passed are left out.

| case | reaction |
|---|---|
| late: the chunk has ended, the next one is not there | sends nothing: the last pose expires and the hand holds; continues with the next chunk |
| silent: no answer for `silence_s` | holds, raises PolicySilentError |
| wrong in shape, not finite, malformed | holds, raises PolicyChunkError; nothing of the chunk is executed |
| connection lost, error of the server | holds, raises PolicyConnectionError |
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _native
from ..features import HandFeatures
from .errors import PolicyChunkError, PolicyError, PolicySilentError

logger = logging.getLogger(__name__)

Chunk = NDArray[np.float64]

STEPS_MAX = 10_000
"""Longest chunk, steps. Design choice: far beyond any policy; bounds memory."""


class Hand(Protocol):
    """A hand: `atas.hands.BusHand` or `atas.hands.SimulatedHand`."""

    features: HandFeatures

    def now_s(self) -> float: ...
    def wait(self, until_s: float) -> None: ...
    def observe(self) -> dict[str, float]: ...
    def send(self, target: Mapping[str, float]) -> None: ...
    def hold(self) -> None: ...


class Client(Protocol):
    """A connection: `PolicyClient`."""

    @property
    def is_waiting(self) -> bool: ...
    def request(self, observation: Mapping[str, Any]) -> None: ...
    def poll(self) -> Mapping[str, Any] | None: ...


class ChunkExecutor:
    """Executes the chunks of a policy on a hand.

    `rate_hz` is the rate of the steps in a chunk. The executor asks for the next chunk after
    `replan` steps. `prompt` is the task text. `more` adds to each observation, for example pictures.
    `convert` makes poses from a chunk of `width` values per step, for policies with another action
    space; default: x, y, z, yaw, opening.
    """

    def __init__(
        self,
        hand: Hand,
        client: Client,
        *,
        rate_hz: float = 20.0,
        replan: int = 10,
        silence_s: float = 2.0,
        prompt: str = "",
        more: Callable[[], Mapping[str, Any]] | None = None,
        width: int | None = None,
        convert: Callable[[Chunk], Chunk] | None = None,
    ) -> None:
        if not (1.0 <= rate_hz <= 1000.0):
            raise ValueError(f"rate rejected: {rate_hz} Hz; needs 1 to 1000, the range of teleoperation")
        if replan < 1:
            raise ValueError(f"replan rejected: {replan} steps; needs at least 1")
        if not (0.0 < silence_s < math.inf):
            raise ValueError(f"silence rejected: {silence_s} s; needs a positive number")
        self.hand, self.client = hand, client
        self.period_s, self.replan, self.silence_s = 1.0 / rate_hz, replan, silence_s
        self.prompt, self.more, self.convert = prompt, more, convert
        self.names = hand.features.action_names()
        self.width = width or len(self.names)
        self.late_steps = 0
        """Steps without a valid row so far: the chunk had ended before the next one arrived."""
        self.steps = 0
        """Executed steps so far."""
        self.chunks = 0
        """Accepted chunks so far."""
        self._chunk: Chunk | None = None
        self._begun_s = 0.0
        self._asked_s: float | None = None

    def __repr__(self) -> str:
        return (
            f"<ChunkExecutor at {1.0 / self.period_s:g} Hz: {self.chunks} chunks, {self.steps} steps, "
            f"{self.late_steps} late; {self.hand!r}>"
        )

    def observation(self) -> dict[str, Any]:
        """The observation in openpi's form: `observation/state`, `observation/environment`, prompt."""
        seen = self.hand.observe()
        groups = {
            "observation/state": self.hand.features.state_names(),
            "observation/environment": [name for name in seen if name.startswith(("object.", "place."))],
            "observation/taxels": [name for name in seen if ".element" in name],
        }
        values: dict[str, Any] = {
            key: np.array([seen[name] for name in names], np.float32) for key, names in groups.items() if names
        }
        return values | {"prompt": self.prompt} | dict(self.more() if self.more else {})

    def step(self) -> bool:
        """Runs one step; returns whether a pose was sent. Raises PolicyError; the hand then holds."""
        try:
            return self._step()
        except BaseException:
            self._chunk = None
            self._hold()
            raise

    def _hold(self) -> None:
        """Holds after a failure, which must stay the one that is raised."""
        try:
            self.hand.hold()
        except (_native.AtasError, TimeoutError) as cause:
            # The daemon is gone or has ended the teleoperation; both keep the grip.
            logger.warning("the teleoperation ended: %s", cause)

    def _step(self) -> bool:
        now_s = self.hand.now_s()
        answer = self.client.poll()
        if answer is not None:
            assert self._asked_s is not None
            # A chunk begins at the time of its observation.
            self._chunk, self._begun_s = self._checked(answer), self._asked_s
            self._asked_s = None
            self.chunks += 1
        row = self._row(now_s)
        is_due = self._chunk is None or row is None or row >= self.replan
        if is_due and not self.client.is_waiting:
            self.client.request(self.observation())
            self._asked_s = now_s
        if self._asked_s is not None and now_s - self._asked_s > self.silence_s:
            raise PolicySilentError(
                f"the policy server did not answer for {now_s - self._asked_s:.1f} s (limit {self.silence_s} s); "
                "the hand holds; see the server's log, or raise the limit"
            )
        if row is None:
            self.late_steps += self.chunks > 0
            return False
        assert self._chunk is not None
        values = dict(zip(self.names, self._chunk[row], strict=True))
        try:
            self.hand.send(self.hand.features.target(values))
        except _native.BusError:
            raise
        except (_native.AtasError, TimeoutError) as ended:
            # A daemon that is gone raises an error with the next observation.
            logger.warning("the teleoperation ended: %s; the next step starts it again", ended)
            return False
        self.steps += 1
        return True

    def _row(self, now_s: float) -> int | None:
        """The row of the chunk for this time; None without one."""
        if self._chunk is None:
            return None
        row = math.floor((now_s - self._begun_s) / self.period_s + 1e-6)
        return row if row < len(self._chunk) else None

    def _checked(self, answer: Mapping[str, Any]) -> Chunk:
        """The poses of an answer. Raises PolicyChunkError."""
        actions = answer.get("actions")
        if not isinstance(actions, np.ndarray):
            raise PolicyChunkError(
                f"chunk rejected: no array `actions`, but {', '.join(map(str, answer)) or 'nothing'}; the hand holds"
            )
        if actions.ndim != 2 or actions.shape[1] != self.width or not 1 <= actions.shape[0] <= STEPS_MAX:
            raise PolicyChunkError(
                f"chunk rejected: shape {actions.shape}; needs (steps, {self.width}) with 1 to {STEPS_MAX} steps; "
                "the hand holds"
            )
        chunk = actions.astype(np.float64)
        self._require_finite(chunk, [str(column) for column in range(self.width)])
        if self.convert is not None:
            chunk = np.asarray(self.convert(chunk), np.float64)
            if chunk.ndim != 2 or chunk.shape != (len(actions), len(self.names)):
                raise PolicyChunkError(
                    f"chunk rejected: `convert` made the shape {chunk.shape}; needs {(len(actions), len(self.names))}; "
                    "the hand holds"
                )
            self._require_finite(chunk, self.names)
        elif self.width != len(self.names):
            raise PolicyChunkError(f"chunk rejected: {self.width} values per step; set `convert`; the hand holds")
        return chunk

    def _require_finite(self, chunk: Chunk, names: list[str]) -> None:
        bad = np.argwhere(~np.isfinite(chunk))
        if len(bad):
            row, column = bad[0]
            raise PolicyChunkError(
                f"chunk rejected: {names[column]} of step {row} is {chunk[row, column]}; needs finite numbers; "
                "the hand holds"
            )


def run(executor: ChunkExecutor, seconds: float) -> None:
    """Runs a policy for a time, then holds. Raises PolicyError; the hand then holds."""
    hand = executor.hand
    begin_s = hand.now_s()
    count = 0
    while hand.now_s() - begin_s < seconds:
        executor.step()
        # After a delay, the next step comes one period later, not several at once.
        count = max(count + 1, math.floor((hand.now_s() - begin_s) / executor.period_s + 1e-6))
        hand.wait(begin_s + count * executor.period_s)
    hand.hold()


__all__ = ["Chunk", "ChunkExecutor", "Client", "Hand", "PolicyError", "run"]
