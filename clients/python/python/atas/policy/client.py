"""Connection to a policy server, with its own thread."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any, Self

import websockets.exceptions
import websockets.sync.client

from . import wire
from .errors import PolicyChunkError, PolicyConnectionError, PolicyError

CONNECT_S = 10.0
"""Time limit for connection and metadata, s. Design choice: a server may still load its model."""


class PolicyClient:
    """A connection to a policy server.

    `request` sends an observation and returns at once; `poll` returns the answer once it is there.
    Neither waits: the network has a thread of its own. One request is open at a
    time. `metadata` is what the server announces on connection.
    """

    def __init__(self, url: str, *, api_key: str | None = None, connect_s: float = CONNECT_S) -> None:
        self.url = url
        self._stack = contextlib.ExitStack()
        headers = {"Authorization": f"Api-Key {api_key}"} if api_key else None
        try:
            connection = websockets.sync.client.connect(
                url,
                compression=None,
                max_size=wire.MESSAGE_MAX_BYTES,
                open_timeout=connect_s,
                close_timeout=1.0,
                additional_headers=headers,
            )
            self._socket = self._stack.enter_context(connection)
        except (OSError, ValueError, websockets.exceptions.WebSocketException) as cause:
            raise PolicyConnectionError(
                f"could not connect to the policy server {url}: {cause}; start the server, or correct the address"
            ) from cause
        try:
            self.metadata = self._mapping(self._socket.recv(timeout=connect_s))
        except TimeoutError as cause:
            self._stack.close()
            raise PolicyConnectionError(
                f"the policy server {url} announced nothing for {connect_s} s; is it a server of openpi's protocol?"
            ) from cause
        except websockets.exceptions.WebSocketException as cause:
            raise self._closed(cause) from cause
        except PolicyError:
            self._stack.close()
            raise
        self._wake = threading.Condition()
        self._pending: Mapping[str, Any] | None = None
        self._is_open = False
        self._answer: Mapping[str, Any] | PolicyError | None = None
        self._ended = False
        self._thread = threading.Thread(target=self._serve, name="policy", daemon=True)
        self._thread.start()

    @property
    def is_waiting(self) -> bool:
        """Whether a request has no answer yet."""
        return self._is_open

    def request(self, observation: Mapping[str, Any]) -> None:
        """Sends an observation. Raises RuntimeError while another request is open."""
        with self._wake:
            if self._is_open:
                raise RuntimeError("request rejected: the last one has no answer yet; call `poll`")
            self._pending, self._is_open, self._answer = observation, True, None
            self._wake.notify()

    def poll(self) -> Mapping[str, Any] | None:
        """The answer of the open request, once. Raises its PolicyError."""
        with self._wake:
            answer, self._answer = self._answer, None
            if answer is not None:
                self._is_open = False
        if isinstance(answer, PolicyError):
            raise answer
        return answer

    def infer(self, observation: Mapping[str, Any], timeout: float = 10.0) -> Mapping[str, Any]:
        """Sends an observation and waits for the answer; for programs without a hand."""
        self.request(observation)
        begin = time.monotonic()
        while (answer := self.poll()) is None:
            if time.monotonic() - begin > timeout:
                raise PolicyConnectionError(f"the policy server {self.url} did not answer within {timeout} s")
            time.sleep(0.001)
        return answer

    def __repr__(self) -> str:
        state = "closed" if self._ended else "waits for an answer" if self._is_open else "ready"
        return f"<PolicyClient of {self.url}: {state}>"

    def close(self) -> None:
        """Closes the connection."""
        with self._wake:
            self._ended = True
            self._wake.notify()
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

    def _serve(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._ended or self._pending is not None)
                observation, self._pending = self._pending, None
                if self._ended or observation is None:
                    return
            answer = self._guarded(lambda seen=observation: self._exchange(seen))  # type: ignore[misc]
            with self._wake:
                self._answer = answer

    def _exchange(self, observation: Mapping[str, Any]) -> Mapping[str, Any]:
        self._socket.send(wire.pack(dict(observation)))
        return self._mapping(self._socket.recv())

    def _guarded(self, exchange: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any] | PolicyError:
        try:
            return exchange()
        except PolicyError as error:
            return error
        except websockets.exceptions.WebSocketException as cause:
            return self._closed(cause)
        except (OSError, ValueError) as cause:
            return PolicyConnectionError(f"could not ask the policy server {self.url}: {cause}")

    def _closed(self, cause: Exception) -> PolicyConnectionError:
        return PolicyConnectionError(
            f"the policy server {self.url} closed the connection: {cause}; see its log"
        )

    def _mapping(self, message: str | bytes) -> Mapping[str, Any]:
        if isinstance(message, str):
            # openpi's servers send an error as text.
            raise PolicyConnectionError(f"the policy server {self.url} reports an error: {message.strip()[-500:]}")
        value = wire.unpack(message)
        if not isinstance(value, dict):
            raise PolicyChunkError(f"answer rejected: a {type(value).__name__}; needs a map")
        return value
