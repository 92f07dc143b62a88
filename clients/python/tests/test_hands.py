"""Tests of kinematics, teleoperated simulation and hands for policies."""

import math
from collections.abc import Callable
from typing import Any

import atas
import numpy as np
import pytest
from atas.features import POSE, HandFeatures
from atas.hands import BusHand, SimulatedHand


def test_pinch_pose_is_the_teleoperated_pose() -> None:
    kinematics, simulation = atas.Kinematics(), atas.Simulation("wood", seed=1)
    assert kinematics.joint_names == atas.JOINT_NAMES and kinematics.joint_range("right") == (11, 22)
    simulation.teleoperate()
    for _ in range(30):
        simulation.send((0.33, -0.16, 0.12), 0.06, yaw=1.4)
        simulation.step(100)
    at, yaw, opening = kinematics.pinch_pose(simulation.joint_state["position"][: atas.JOINTS], "right")
    assert at == pytest.approx([0.33, -0.16, 0.12], abs=1e-3)
    assert (yaw, opening) == pytest.approx((1.4, 0.06), abs=1e-3)


def test_bounds_are_those_of_the_controller() -> None:
    bounds = atas.Kinematics().teleop_bounds("left")
    assert bounds["x"] == (0.22, 0.40) and bounds["y"] == (0.11, 0.30) and bounds["opening"] == (0.0, 0.11)
    simulation = atas.Simulation("wood", seed=1)
    simulation.teleoperate()
    for x, warnings in ((0.399, 0), (0.401, 1)):
        simulation.send((x, -0.15, 0.12), 0.06)
        simulation.step(5)
        kinds = [event["kind"] for event in simulation.events]
        assert kinds.count(atas.EventKind.WARNING) == warnings, x


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: atas.Kinematics("no-robot"), "no-robot"),
        (lambda: atas.Kinematics().pinch_pose(np.zeros(11), "right"), "11 numbers, the robot two-hand-arm needs 22"),
        (lambda: atas.Kinematics().pinch_pose(np.full(22, math.nan), "right"), "joint right_shoulder_yaw is not finite"),
        (lambda: atas.Kinematics("arm7-gripper").fingertips("left"), "has no such hand"),
        (lambda: atas.Kinematics().joint_range("middle"), "unknown hand"),
        (lambda: atas.Simulation("wood").send((0.3, -0.15, 0.1), 0.06), "call `teleoperate` first"),
        (lambda: HandFeatures(None, "right", "summary", "pose").target({}), "missing"),
    ],
)
def test_invalid_argument_raises(call: Callable[[], Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()


def test_teleoperation_starts_once_and_rejects_not_finite_targets() -> None:
    simulation = atas.Simulation("wood", seed=1)
    simulation.teleoperate()
    with pytest.raises(ValueError, match="runs already"):
        simulation.teleoperate()
    with pytest.raises(ValueError, match="not finite"):
        simulation.send((0.3, math.nan, 0.1), 0.06)
    with pytest.raises(ValueError, match="invalid time"):
        simulation.send((0.3, -0.15, 0.1), 0.06, valid=-1.0)
    simulation.send((0.3, -0.15, 0.1), 0.06)
    simulation.step(10)
    assert simulation.result["state"] in (atas.GoalState.ACCEPTED, atas.GoalState.RUNNING)


def test_every_robot_has_features() -> None:
    for robot, hand in (("two-hand-arm", "left"), ("arm7-gripper", "right"), ("three-finger", "right")):
        features = HandFeatures(robot, hand, "taxels", "pose")
        names = [*features.state_names(), *features.taxel_names(5)]
        assert len(set(names)) == len(names) and names[:5] == list(POSE)
        assert len(features.joints) == features.range.stop - features.range.start
        assert f"finger{features.fingers}.normal_n" in names


def test_simulated_hand_waits_in_virtual_time() -> None:
    hand = SimulatedHand("wood", seed=1)
    begin_s = hand.now_s()
    hand.wait(begin_s + 0.25)
    assert hand.now_s() - begin_s == pytest.approx(0.25)
    hand.wait(begin_s)
    assert hand.now_s() - begin_s == pytest.approx(0.25), "the past is no wait"


def test_missing_daemon_raises() -> None:
    with pytest.raises(atas.BusError):
        BusHand("no-such-bus")
