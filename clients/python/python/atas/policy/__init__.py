"""A policy over the network: client for openpi's websocket protocol, above the tactile reflex.

```text
 hand.observe ─▶ PolicyClient ─ msgpack over websocket ─▶ policy server
 hand.send ◀─ ChunkExecutor ◀─ action chunk, checked ◀───┘
```

* `PolicyClient`: connection with its own thread; a request never delays the hand.
* `ChunkExecutor`: executes chunks step by step. Watchdog: no step is sent without a valid chunk,
  so the hand brakes and keeps its grip.
* `ReplayServer`: a test server with recorded chunks and injected faults.

Needs `pip install 'atas[policy]'`. `python -m atas.policy --help` runs a policy.
"""

from .client import PolicyClient
from .errors import PolicyChunkError, PolicyConnectionError, PolicyError, PolicySilentError
from .executor import ChunkExecutor, Hand, run
from .server import ReplayServer

__all__ = [
    "ChunkExecutor",
    "Hand",
    "PolicyChunkError",
    "PolicyClient",
    "PolicyConnectionError",
    "PolicyError",
    "PolicySilentError",
    "ReplayServer",
    "run",
]
