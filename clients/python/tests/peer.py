"""A peer implemented only from clients/protocol.md: layouts, service settings, folder, prefix, locks.

It uses iceoryx2's Python binding, as a client in another language would use its own.
"""

import ctypes
import fcntl
import os
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import iceoryx2 as iox2

PAGE = (Path(__file__).resolve().parents[2] / "protocol.md").read_text()
NUMBERS = {"f32": ctypes.c_float, "f64": ctypes.c_double, "u32": ctypes.c_uint32, "u64": ctypes.c_uint64}


def table(name: str) -> list[dict[str, str]]:
    """Returns the rows of a table of the page, by column."""
    part = PAGE.split(f"<!-- {name}:", 1)[1].split(f"<!-- end of {name}", 1)[0]
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in part.splitlines() if line[:1] == "|"]
    return [dict(zip(rows[0], row, strict=False)) for row in rows[2:]]


def _type_of(text: str, known: dict[str, Any]) -> Any:
    base, *dimensions = text.replace("]", "").split("[")
    if base == "char":
        made: Any = ctypes.c_char * int(dimensions.pop(0))
    else:
        made = NUMBERS.get(base.split(" ")[0]) or known[base]
    for dimension in reversed(dimensions):
        made = made * int(dimension)
    return made


def payloads() -> dict[str, Any]:
    """Returns the structures of the page; checks them against the printed offsets and sizes."""
    known: dict[str, Any] = {}
    part = PAGE.split("<!-- payloads:", 1)[1].split("<!-- end of payloads", 1)[0]
    waiting = re.findall(r"\*\*`(atas\.(\w+)\.v\d+)`\*\*, (\d+) bytes\n\n\|.*\n\|.*\n((?:\|.*\n)+)", part)
    while waiting:
        wire, name, size, text = waiting.pop(0)
        rows = [line.split("|") for line in text.splitlines()]
        fields = [(int(row[1]), row[2].strip(" `"), row[3].strip()) for row in rows]
        try:
            made = [(field, _type_of(kind, known)) for _, field, kind in fields]
        except KeyError:
            if any(other[1] in text for other in waiting):
                waiting.append((wire, name, size, text))
            continue  # Its parts are only in the C header.
        structure = type(name, (ctypes.Structure,), {"_fields_": made, "type_name": staticmethod(lambda wire=wire: wire)})
        assert ctypes.sizeof(structure) == int(size), name
        for offset, field, _ in fields:
            assert getattr(structure, field).offset == offset, f"{name}.{field}"
        known[name] = structure
    return known


PAYLOADS = payloads()


def seal(payload: Any) -> None:
    """Writes the checksum of all preceding bytes."""
    payload.crc32 = zlib.crc32(bytes(payload)[: type(payload).crc32.offset])


class Peer:
    """A node that joins a bus by the page's rules."""

    def __init__(self, folder: str, role: str) -> None:
        self.folder = Path(folder)
        config = iox2.config.default()
        config.global_cfg.root_path = iox2.Path.new(folder)
        config.global_cfg.prefix = iox2.FileName.new((self.folder / "prefix").read_text())
        config.global_cfg.node.cleanup_dead_nodes_on_creation = False
        config.global_cfg.node.cleanup_dead_nodes_on_destruction = False
        config.global_cfg.service.cleanup_dead_nodes_on_open = False
        builder = iox2.NodeBuilder.new().name(iox2.NodeName.new(role)).config(config)
        with self.setting_up():
            self.node = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled).create(iox2.ServiceType.Ipc)

    @contextmanager
    def setting_up(self) -> Iterator[None]:
        with (self.folder / "startup.lock").open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def _stream(self, service: str) -> Any:
        row = next(row for row in table("streams") if row["service"] == service)
        payload = PAYLOADS[row["payload"].split(".")[1]]
        return (
            self.node.service_builder(iox2.ServiceName.new(service))
            .publish_subscribe(payload)
            .enable_safe_overflow(True)
            .subscriber_max_borrowed_samples(2)
            .subscriber_max_buffer_size(int(row["buffer"]))
            .history_size(int(row["history"]))
            .max_publishers(int(row["publishers"]))
            .max_subscribers(int(row["subscribers"]))
            .max_nodes(int(row["nodes"]))
            .open_or_create()
        )

    def publisher(self, service: str) -> Any:
        with self.setting_up():
            builder = self._stream(service).publisher_builder().max_loaned_samples(1)
            return builder.backpressure_strategy(iox2.BackpressureStrategy.DiscardData).create()

    def subscriber(self, service: str) -> Any:
        with self.setting_up():
            return self._stream(service).subscriber_builder().create()

    def client(self, service: str) -> Any:
        row = next(row for row in table("exchanges") if row["service"] == service)
        request, response = (PAYLOADS[row[key].split(".")[1]] for key in ("request", "response"))
        with self.setting_up():
            return (
                self.node.service_builder(iox2.ServiceName.new(service))
                .request_response(request, response)
                .enable_safe_overflow_for_requests(True)
                .enable_safe_overflow_for_responses(True)
                .enable_fire_and_forget_requests(False)
                .max_active_requests_per_client(int(row["open requests"]))
                .max_response_buffer_size(int(row["responses"]))
                .max_servers(1)
                .max_clients(int(row["clients"]))
                .max_nodes(int(row["nodes"]))
                .open_or_create()
                .client_builder()
                .create()
            )


def send(publisher: Any, payload: Any) -> None:
    sample = publisher.loan_uninit()
    ctypes.memmove(ctypes.addressof(sample.payload().contents), ctypes.addressof(payload), ctypes.sizeof(payload))
    sample.assume_init().send()


def newest(receiver: Any, kind: Any) -> Any:
    """Returns a copy of the newest queued payload, or None."""
    found = None
    while (sample := receiver.receive()) is not None:
        found = kind.from_buffer_copy(bytes(sample.payload().contents))
        sample.delete()
    return found


def epoch() -> int:
    return int.from_bytes(os.urandom(8), "little") | 1
