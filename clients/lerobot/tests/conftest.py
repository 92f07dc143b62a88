"""Fixtures: LeRobot's recorded interface where LeRobot is missing, private buses, programs."""

import gc
import itertools
import json
import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import atas
import contract
import pytest

_numbers = itertools.count()
PROGRAMS = Path(os.environ.get("ATAS_PROGRAMS", Path(__file__).parents[3] / "target" / "debug"))
if not contract.INSTALLED:
    contract.replay(json.loads(contract.FILE.read_text()))


@pytest.fixture
def options(tmp_path: Path) -> dict[str, Any]:
    """Options of every device: a name, and a folder that LeRobot may write."""
    return {"id": "test", "calibration_dir": tmp_path}


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts programs of the workspace on a private bus (`start.bus`); they end with the test."""
    bus = f"flr-{os.getpid()}-{next(_numbers)}"
    started: list[subprocess.Popen[bytes]] = []

    def start(name: str, *arguments: str) -> subprocess.Popen[bytes]:
        with (tmp_path / f"{name}.log").open("wb") as log:
            process = subprocess.Popen(
                [PROGRAMS / name, *arguments], env=os.environ | {"ATAS_BUS": bus}, stdout=log, stderr=log
            )
        started.append(process)
        start.named[name] = process  # type: ignore[attr-defined]
        return process

    start.bus, start.named = bus, {}  # type: ignore[attr-defined]
    yield start
    for process in reversed(started):
        process.terminate()
    for process in reversed(started):
        process.wait(60)
    gc.collect()  # Objects of a failed test may still use the bus.
    atas.wipe(bus)
