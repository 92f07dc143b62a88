"""Tests of the robot `atas` with simulator and daemon in real time.

No assertion depends on the speed of the machine: each waits for a state.
"""

import time
from collections.abc import Callable
from typing import Any

import atas
import pytest
from lerobot.utils.errors import DeviceNotConnectedError
from lerobot_robot_atas import Atas, AtasConfig, AtasKeyboard, AtasKeyboardConfig

TIMEOUT_S = 300.0
ITEM = [0.32, -0.15, 0.0345, 1.5708, 0.05]


def wait_for(what: str, step: Callable[[], Any]) -> Any:
    """Calls `step` 50 times per second until it returns something true."""
    begin = time.monotonic()
    while time.monotonic() - begin < TIMEOUT_S:
        if answer := step():
            return answer
        time.sleep(0.02)
    raise AssertionError(f"timed out waiting for {what}")


def connected(start: Any, options: dict[str, Any], **more: Any) -> Atas:
    start("atas-sim", "run", "--object", "wood")
    start("atasd", "--config", "/dev/null", "--set", "realtime.mode=off", "--set", "safety.stall_s=1")
    reports = atas.Bus(start.bus, create=True).reports()
    wait_for("the daemon", lambda: reports.newest() is not None)
    robot = Atas(AtasConfig(**options, bus=start.bus, object=ITEM, **more))
    robot.connect()
    return robot


def test_robot_moves_observes_and_ends_its_teleoperation(start: Any, options: dict[str, Any]) -> None:
    robot = connected(start, options, tactile="taxels")
    seen = robot.get_observation()
    assert list(seen) == list(robot.observation_features)
    assert [seen[f"object.{name}"] for name in ("x", "y", "z", "yaw", "width")] == ITEM
    begin = seen["hand.opening"]
    wanted = begin - 0.01 if begin > 0.03 else begin + 0.01
    action = {name: seen[name] for name in robot.action_features} | {"hand.opening": wanted}
    assert robot.send_action(action) == pytest.approx(action)

    def closer() -> bool:
        robot.send_action(action)
        return abs(robot.get_observation()["hand.opening"] - begin) > 2e-3

    wait_for("a motion", closer)
    robot.disconnect()
    assert not robot.is_connected
    statuses = atas.Bus(start.bus).statuses()

    def ended() -> bool:
        status = statuses.newest()
        return status is not None and status["goal_state"] in (atas.GoalState.CANCELLED, atas.GoalState.FAILED)

    wait_for("the end of the teleoperation", ended)


def test_sensors_are_zeroed_and_the_keyboard_starts_at_the_measured_pose(start: Any, options: dict[str, Any]) -> None:
    robot = connected(start, options)
    wait_for("the mode READY", lambda: _try(robot.calibrate))
    keyboard = AtasKeyboard(AtasKeyboardConfig(**options, bus=start.bus), pressed=list)
    keyboard.connect()
    pose, seen = keyboard.get_action(), robot.get_observation()
    for name in ("hand.x", "hand.y", "hand.yaw"):
        assert pose[name] == pytest.approx(seen[name], abs=5e-3), name
    robot.disconnect()


def _try(call: Callable[[], None]) -> bool:
    try:
        call()
    except RuntimeError:
        return False
    return True


def test_loss_of_the_daemon_raises(start: Any, options: dict[str, Any]) -> None:
    robot = connected(start, options)

    def lost() -> bool:
        try:
            robot.get_observation()
        except DeviceNotConnectedError as error:
            assert "received no " in str(error), error
            return True
        return False

    assert not lost()
    daemon = start.named["atasd"]
    daemon.terminate()
    daemon.wait(60)
    wait_for("the error", lost)
    with pytest.raises(DeviceNotConnectedError):
        robot.send_action(dict(zip(robot.action_features, (0.32, -0.15, 0.1, 1.57, 0.07), strict=True)))
    robot.disconnect()
    assert not robot.is_connected


def test_missing_daemon_raises(options: dict[str, Any]) -> None:
    robot = Atas(AtasConfig(**options, bus="no-such-bus"))
    with pytest.raises(DeviceNotConnectedError, match="start the robot and `atasd` first"):
        robot.connect()
    assert not robot.is_connected
