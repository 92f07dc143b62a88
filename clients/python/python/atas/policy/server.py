"""A test server of openpi's protocol: answers with recorded chunks, with faults on demand."""

from __future__ import annotations

import contextlib
import threading
from types import TracebackType
from typing import Any, Self

import numpy as np
import websockets.exceptions
import websockets.sync.server
from numpy.typing import NDArray

from . import wire

FAULTS = ("late", "silent", "shape", "nan", "malformed", "error", "close")
"""Faults: answers after `delay_s`; never; with a column too many; with NaN; with bytes that are no
MessagePack; with an error text; closes the connection."""


class ReplayServer:
    """A policy server on the loopback interface.

    Request k gets chunk k; after the last, the last chunk again. `faults` names the fault of a
    request by its number. `port` 0 chooses a free port; `url` has the address. `observations`
    contains all requests.
    """

    def __init__(
        self,
        chunks: NDArray[Any],
        *,
        port: int = 0,
        faults: dict[int, str] | None = None,
        delay_s: float = 1.0,
        metadata: dict[str, Any] | None = None,
    ) -> None:
        chunks = np.asarray(chunks, np.float32)
        if chunks.ndim != 3 or 0 in chunks.shape:
            raise ValueError(f"chunks rejected: shape {chunks.shape}; needs (chunks, steps, values)")
        unknown = sorted(set((faults or {}).values()) - set(FAULTS))
        if unknown:
            raise ValueError(f"faults rejected: {', '.join(unknown)}; known are {', '.join(FAULTS)}")
        self.chunks, self.faults, self.delay_s = chunks, faults or {}, delay_s
        self.metadata = metadata or {"server": "atas.policy.ReplayServer"}
        self.observations: list[dict[str, Any]] = []
        self._ended = threading.Event()
        self._stack = contextlib.ExitStack()
        server = websockets.sync.server.serve(
            self._handle, "127.0.0.1", port, compression=None, max_size=wire.MESSAGE_MAX_BYTES
        )
        self._server = self._stack.enter_context(server)
        self.url = f"ws://127.0.0.1:{self._server.socket.getsockname()[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, name="policy server", daemon=True)
        self._thread.start()

    def __repr__(self) -> str:
        count, steps, width = self.chunks.shape
        return f"<ReplayServer at {self.url}: {count} chunks of {steps} x {width}, {len(self.observations)} requests>"

    def close(self) -> None:
        """Ends the server and its connections."""
        self._ended.set()
        self._stack.close()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()

    def _handle(self, socket: websockets.sync.server.ServerConnection) -> None:
        try:
            socket.send(wire.pack(self.metadata))
            while True:
                message = socket.recv()
                assert isinstance(message, bytes)
                number = len(self.observations)
                self.observations.append(wire.unpack(message))
                answer = self._answer(number, self.faults.get(number, ""))
                if answer is None:
                    return
                socket.send(answer)
        except websockets.exceptions.ConnectionClosed:
            pass

    def _answer(self, number: int, fault: str) -> bytes | str | None:
        chunk = self.chunks[min(number, len(self.chunks) - 1)].copy()
        if fault == "late":
            self._ended.wait(self.delay_s)
        if fault == "silent":
            self._ended.wait()
            return None
        if fault == "close":
            return None
        if fault == "malformed":
            return b"\xc1" * 8
        if fault == "error":
            return "Traceback: the model has no weights"
        if fault == "nan":
            chunk[-1, 2] = np.nan
        if fault == "shape":
            chunk = np.concatenate([chunk, chunk[:, :1]], axis=1)
        return wire.pack({"actions": chunk, "server_timing": {"infer_ms": 0.0}})
