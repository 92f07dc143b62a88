"""Tests of arrays over a real bus."""

import gc
import subprocess
import sys
import textwrap
import threading
import zlib
from pathlib import Path
from typing import Any

import atas
import numpy as np
import pytest


def sealed(row: Any) -> bool:
    content = row.tobytes()
    return zlib.crc32(content[:-4]) == int(row["crc32"])


def test_array_types_match_payloads() -> None:
    frame = atas.dtype("HandFrame")
    assert frame.itemsize == 3152
    assert frame["force_n"].shape == (4, 64, 3) and frame["force_n"].base == np.float32
    assert frame["stamp"].names == ("sequence", "captured_ns", "writer_epoch")
    assert atas.dtype("TickReport")["hands"].base["fingers"].shape == (4,)
    with pytest.raises(KeyError):
        atas.dtype("Frame")


def test_frames_arrive_sealed_without_loss(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    reader = bus.frames("left")
    force_n = np.arange(2 * 41 * 3, dtype=np.float32).reshape(2, 41, 3)
    with bus.sensor("left") as sensor:
        for k in range(100):
            assert sensor.publish(force_n * k, captured_ns=1000 + k) == k
        rows = reader.receive()
    assert len(rows) == 100 and reader.lost == 0
    assert (np.diff(rows["stamp"]["sequence"]) == 1).all()
    assert len(set(rows["stamp"]["writer_epoch"])) == 1 and rows["stamp"]["writer_epoch"][0] != 0
    assert (rows["force_n"][7, :2, :41] == force_n * 7).all()
    assert (rows["force_n"][:, 2:] == 0).all() and (rows["valid_mask"][0] == [2**41 - 1, 2**41 - 1, 0, 0]).all()
    assert all(sealed(row) for row in rows)


def test_array_is_a_copy(bus_name: str) -> None:
    """The array is a copy, not a view of shared memory."""
    bus = atas.Bus(bus_name, create=True)
    reader, sensor = bus.frames("right"), bus.sensor("right", layout="dome-1", fingers=1)
    sensor.publish([[[1.0, 0.0, 0.0]]])
    first = reader.receive()
    before = first.tobytes()
    for k in range(2000):
        sensor.publish([[[k, 0.0, 0.0]]])
        reader.receive()
    assert first.tobytes() == before
    first["force_n"] = 0


def test_lost_payloads_are_counted(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    reader, sensor = bus.frames("right"), bus.sensor("right", layout="dome-1", fingers=1)
    sensor.publish([[[0.0, 0.0, 0.0]]])
    assert len(reader.receive()) == 1
    for _ in range(300):
        sensor.publish([[[0.0, 0.0, 0.0]]])
    assert len(reader.receive()) == 128 and reader.lost == 172
    sensor.publish([[[0.0, 0.0, 0.0]]], lost=5)
    newest = reader.newest()
    assert newest is not None and newest["stamp"]["sequence"] == 306 and reader.lost == 177
    assert reader.newest() is None and len(reader.wait(0.01)) == 0


@pytest.mark.parametrize(
    ("force_n", "valid", "says"),
    [
        (np.zeros((2, 40, 3)), None, "shape"),
        (np.zeros((1, 41, 3)), None, "shape"),
        (np.full((2, 41, 3), np.nan), None, "finite"),
        (np.full((2, 41, 3), np.inf), None, "finite"),
        (np.zeros((2, 41, 3)), np.ones((2, 40), np.bool_), "shape"),
    ],
)
def test_invalid_frame_is_rejected(
    bus_name: str, force_n: np.ndarray[Any, Any], valid: np.ndarray[Any, Any] | None, says: str
) -> None:
    bus = atas.Bus(bus_name, create=True)
    reader, sensor = bus.frames("left"), bus.sensor("left")
    with pytest.raises(ValueError, match=says):
        sensor.publish(force_n, valid=valid)
    assert len(reader.receive()) == 0
    assert sensor.publish(np.zeros((2, 41, 3))) == 0, "the sequence number is unchanged"


def test_invalid_taxel_may_have_any_value(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    reader, sensor = bus.frames("left"), bus.sensor("left")
    force_n, valid = np.ones((2, 41, 3)), np.ones((2, 41), np.bool_)
    force_n[1, 3], valid[1, 3] = np.nan, False
    sensor.publish(force_n, valid=valid)
    row = reader.receive()[0]
    assert row["valid_mask"][1] == 2**41 - 1 - 8 and (row["force_n"][1, 3] == 0).all() and sealed(row)


def test_capture_time_must_increase(bus_name: str) -> None:
    sensor = atas.Bus(bus_name, create=True).sensor("left", layout="pad-4", fingers=1)
    sensor.publish(np.zeros((1, 4, 3)), captured_ns=1000)
    with pytest.raises(ValueError, match="captured"):
        sensor.publish(np.zeros((1, 4, 3)), captured_ns=1000)


def test_one_sensor_per_hand(bus_name: str) -> None:
    bus = atas.Bus(bus_name, role="first", create=True)
    first = bus.sensor("left")
    with pytest.raises(atas.BusError, match="first"):
        atas.Bus(bus_name).sensor("left")
    del first
    atas.Bus(bus_name).sensor("left")


def test_robot_reports_held_positions(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    reader, robot = bus.joint_states(), bus.robot()
    position = np.linspace(-0.1, 0.1, atas.JOINTS)
    robot.publish(position, captured_ns=5)
    row = reader.receive()[0]
    assert row["joint_count"] == 22 == row["commanded_count"] and sealed(row)
    assert (row["commanded_position"][:22] == position).all(), "the measured position is held"
    orders = robot.command(now_ns=6)
    assert not orders["in_force"] and (orders["velocity"] == 0).all()
    with pytest.raises(ValueError, match="finite"):
        robot.publish(np.full(22, np.nan))
    with pytest.raises(ValueError, match="22"):
        robot.publish(np.zeros(21))
    with pytest.raises(TimeoutError, match="lockstep"):
        robot.answer(7, timeout=0.05)


def test_observer_does_not_create_a_bus() -> None:
    with pytest.raises(atas.BusError, match="fpy-nobody"):
        atas.Bus("fpy-nobody")
    assert atas.wipe("fpy-nobody") == 0
    with pytest.raises(ValueError, match="name"):
        atas.Bus("Not a name")


def test_a_bus_stays_in_its_thread(bus_name: str) -> None:
    bus = atas.Bus(bus_name, create=True)
    sensor, robot = bus.sensor("left"), bus.robot()
    uses = [bus.peers, bus.frames("left").newest, sensor.connect_readers, robot.connect_readers]
    refused: list[str] = []

    def use() -> None:
        for call in uses:
            with pytest.raises(atas.BusError) as error:
                call()
            refused.append(str(error.value))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert len(refused) == len(uses) and all("another thread" in why for why in refused), refused
    assert [role for role, _, alive in bus.peers() if alive] == ["python"]
    # The tracebacks reference the frames, which reference the bus.
    gc.collect()


DROPPED = """
    import sys, threading
    import atas

    handles = [atas.Bus(sys.argv[1], create=True)]
    thread = threading.Thread(target=handles.clear)
    thread.start()
    thread.join()
    with atas.Bus(sys.argv[1]).sensor("left") as sensor:
        sensor.connect_readers()
"""


def test_bus_dropped_by_another_thread_harms_nothing(bus_name: str) -> None:
    script = [sys.executable, "-c", textwrap.dedent(DROPPED), bus_name]
    assert subprocess.run(script, timeout=60, check=False).returncode == 0


FORKED = """
    import multiprocessing, os, sys
    import atas

    name, method = sys.argv[1:]
    force_n = [[[1.0, 0.0, 0.0]]]

    def own_bus() -> None:
        bus = atas.Bus(name)
        reader, sensor = bus.frames("left"), bus.sensor("left", layout="dome-1", fingers=1)
        sensor.publish(force_n)
        assert len(reader.receive()) == 1

    if __name__ == "__main__":
        bus = atas.Bus(name, create=True)
        reader = bus.frames("right")
        sensor = bus.sensor("right", layout="dome-1", fingers=1)
        sensor.publish(force_n)
        if method == "os.fork":
            if os.fork() == 0:
                for use in (lambda: sensor.publish(force_n), reader.receive, lambda: bus.frames("left"), bus.recover):
                    try:
                        use()
                    except atas.BusError as error:
                        assert "after a fork" in str(error), error
                    else:
                        raise AssertionError("a handle of the parent was used")
                # Ends the interpreter, which drops all objects.
                sys.exit(0)
            _, status = os.wait()
            assert status == 0, status
        else:
            child = multiprocessing.get_context(method).Process(target=own_bus)
            child.start()
            child.join()
            assert child.exitcode == 0, child.exitcode
        sensor.publish(force_n)
        assert len(reader.receive()) == 2, "the parent's memory is kept"
        assert len(atas.Bus(name).frames("right").receive()) >= 0
        print("done")
"""


@pytest.mark.parametrize("method", ["os.fork", "fork", "spawn", "forkserver"])
def test_forked_child_leaves_the_bus_to_its_parent(bus_name: str, method: str, tmp_path: Path) -> None:
    script = tmp_path / "forked.py"
    script.write_text(textwrap.dedent(FORKED))
    ended = subprocess.run([sys.executable, script, bus_name, method], capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr
