"""Fixtures: private buses and the programs of the workspace."""

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import atas
import pytest

ROOT = Path(__file__).resolve().parents[3]
PROGRAMS = Path(os.environ.get("ATAS_PROGRAMS", ROOT / "target" / "debug"))
_count = 0

# A shell starts background jobs with SIGINT ignored, and children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def bus_name() -> Iterator[str]:
    """A private bus, wiped afterwards."""
    global _count
    _count += 1
    name = f"fpy-{os.getpid()}-{_count}"
    yield name
    atas.wipe(name)


class Programs:
    """Processes that end with the test."""

    def __init__(self, bus: str, folder: Path) -> None:
        self.bus, self.folder = bus, folder
        self.started: list[subprocess.Popen[bytes]] = []

    def start(self, name: str, *arguments: str) -> subprocess.Popen[bytes]:
        log = (self.folder / f"{name}.log").open("wb")
        process = subprocess.Popen(
            [PROGRAMS / name, *arguments],
            env=os.environ | {"ATAS_BUS": self.bus},
            stdout=log,
            stderr=log,
        )
        log.close()
        self.started.append(process)
        return process

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text()


@pytest.fixture
def programs(bus_name: str, tmp_path: Path) -> Iterator[Programs]:
    programs = Programs(bus_name, tmp_path)
    yield programs
    for process in reversed(programs.started):
        process.terminate()
    for process in reversed(programs.started):
        process.wait(60)
