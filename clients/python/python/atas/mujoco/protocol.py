"""Messages between the simulator and an engine, over standard input and output.

A message has a header of two little-endian 32-bit numbers (kind, length in bytes) and a payload. The
Rust module `sim_backend::engine` documents kinds and payloads.
"""

from __future__ import annotations

import json
import struct
import sys
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

VERSION = 1
"""Version of messages and scene description."""
BEGIN, TICK, READY, STATE, FAILED = 1, 2, 3, 4, 5
HEADER = struct.Struct("<II")


class Channel:
    """Messages from and to the simulator."""

    def __init__(self, source: BinaryIO, sink: BinaryIO) -> None:
        self._source, self._sink = source, sink

    @classmethod
    def standard(cls) -> Channel:
        """Takes standard input and output; prints of other code go to standard error from now on."""
        channel = cls(sys.stdin.buffer, sys.stdout.buffer)
        sys.stdout = sys.stderr
        return channel

    def receive(self) -> tuple[int, bytes] | None:
        """Waits for a message: its kind and payload; None at the end of the input."""
        header = self._source.read(HEADER.size)
        if len(header) < HEADER.size:
            return None
        kind, length = HEADER.unpack(header)
        payload = self._source.read(length)
        return (kind, payload) if len(payload) == length else None

    def ready(self, name: str) -> None:
        """Reports that the scene is built."""
        self._send(READY, name.encode())

    def state(self, values: NDArray[np.float64]) -> None:
        """Reports the end of a tick."""
        self._send(STATE, values.astype("<f8", copy=False).tobytes())

    def failed(self, reason: str) -> None:
        """Reports that the scene or the tick is discarded."""
        self._send(FAILED, reason.encode())

    def _send(self, kind: int, payload: bytes) -> None:
        self._sink.write(HEADER.pack(kind, len(payload)) + payload)
        self._sink.flush()


def parse_scene(payload: bytes) -> dict[str, Any]:
    """Parses a scene description. Raises ValueError for another version."""
    scene: dict[str, Any] = json.loads(payload)
    if scene["protocol"] != VERSION:
        raise ValueError(
            f"the simulator uses version {scene['protocol']} of the engine protocol, this package version {VERSION}; "
            "install the same version of both"
        )
    return scene
