"""Tests of keyboard and leader arm."""

import math
from typing import Any

import atas
import numpy as np
import pytest
from lerobot.teleoperators import Teleoperator
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot_robot_atas import (
    AtasKeyboard,
    AtasKeyboardConfig,
    AtasLeader,
    AtasLeaderConfig,
    AtasSimulation,
    AtasSimulationConfig,
)

START = [0.32, -0.15, 0.10, math.pi / 2, 0.07]


class Keys:
    """Pressed keys and a clock, set by a test."""

    def __init__(self) -> None:
        self.pressed: list[Any] = []
        self.now_s = 0.0


def keyboard(options: dict[str, Any], **more: Any) -> tuple[AtasKeyboard, Keys]:
    keys = Keys()
    config = AtasKeyboardConfig(**options, start=START, **more)
    made = AtasKeyboard(config, pressed=lambda: keys.pressed, clock=lambda: keys.now_s)
    made.connect()
    return made, keys


def test_keys_move_at_their_speed(options: dict[str, Any]) -> None:
    made, keys = keyboard(options)
    assert list(made.get_action().values()) == START
    keys.pressed, keys.now_s = ["w", "o", "q", "unknown"], 0.1
    moved = made.get_action()
    assert moved["hand.x"] == pytest.approx(0.32 + 0.005) and moved["hand.y"] == START[1]
    assert moved["hand.opening"] == pytest.approx(0.07 + 0.002)
    assert moved["hand.yaw"] == pytest.approx(START[3] + 0.05)
    keys.pressed, keys.now_s = [], 0.2
    assert made.get_action() == moved


def test_keys_stay_within_the_bounds_and_do_not_jump(options: dict[str, Any]) -> None:
    made, keys = keyboard(options, speed_m_s=1.0)
    keys.pressed, keys.now_s = ["w"], 60.0
    # A pause of a minute counts as a tenth of a second: 0.1 m, limited to the bound.
    assert made.get_action()["hand.x"] == pytest.approx(0.40)
    keys.pressed, keys.now_s = ["s"], 59.0
    assert made.get_action()["hand.x"] == pytest.approx(0.40), "the clock stepped back"


class Arm(Teleoperator):
    """Leader arm with given joint positions, degrees."""

    name = "arm"
    action_features = feedback_features = {}  # type: ignore[assignment]
    is_calibrated = True

    def __init__(self, config: Any) -> None:
        super().__init__(config)
        self.config = config
        self.values: dict[str, float] = {}
        self.is_open = False

    @property
    def is_connected(self) -> bool:
        return self.is_open

    def connect(self, calibrate: bool = True) -> None:
        self.is_open = True

    def calibrate(self) -> None: ...

    def configure(self) -> None: ...

    def get_action(self) -> dict[str, Any]:
        return dict(self.values)

    def send_feedback(self, feedback: dict[str, Any]) -> None: ...

    def disconnect(self) -> None:
        self.is_open = False


def posture(options: dict[str, Any], up: float) -> dict[str, float]:
    """Joint positions of the simulated hand 60 mm + `up` above the object, degrees."""
    one = AtasSimulation(AtasSimulationConfig(**options))
    one.connect()
    hint = one.simulation.hint
    x, y, z = hint["at"]
    target = dict(zip(one.action_features, (x, y, z + 0.06 + up, hint["yaw"], 0.07), strict=True))
    for _ in range(150):
        one.send_action(target)
    seen = one.get_observation()
    return {name: math.degrees(seen[name]) for name in one.features.joints}


def leader(options: dict[str, Any], **more: Any) -> tuple[AtasLeader, Arm]:
    arm = Arm(AtasKeyboardConfig(**options))
    made = AtasLeader(AtasLeaderConfig(**options, leader="arm", start=START, **more), leader=arm)
    return made, arm


def test_leader_moves_the_hand_by_its_displacement(options: dict[str, Any]) -> None:
    made, arm = leader(options)
    arm.values = posture(options, 0.0)
    made.connect()
    still = made.get_action()
    assert list(still.values())[:4] == pytest.approx(START[:4])
    arm.values = posture(options, 0.03)
    raised = made.get_action()
    assert raised["hand.z"] - still["hand.z"] == pytest.approx(0.03, abs=1e-3)
    assert raised["hand.x"] == pytest.approx(still["hand.x"], abs=1e-3)
    made.disconnect()
    assert not arm.is_open


def test_absolute_leader_and_gripper_set_the_pose(options: dict[str, Any]) -> None:
    made, arm = leader(options, relative=False, gripper="gripper.pos")
    arm.values = posture(options, 0.0) | {"gripper.pos": 25.0}
    made.connect()
    pose = made.get_action()
    kinematics = atas.Kinematics()
    position = np.zeros(len(kinematics.joint_names))
    position[slice(*kinematics.joint_range("right"))] = [math.radians(v) for n, v in arm.values.items() if n != "gripper.pos"]
    (x, y, z), _yaw, _opening = kinematics.pinch_pose(position, "right")
    assert [pose["hand.x"], pose["hand.y"], pose["hand.z"]] == pytest.approx([x, y, z])
    assert pose["hand.opening"] == pytest.approx(0.025)
    arm.values["gripper.pos"] = 900.0
    assert made.get_action()["hand.opening"] == pytest.approx(0.1)


def test_leader_without_known_joints_is_refused(options: dict[str, Any]) -> None:
    made, arm = leader(options)
    arm.values = {"shoulder_pan.pos": 1.0}
    with pytest.raises(ValueError, match="set `joints`"):
        made.connect()
    assert not arm.is_open and not made.is_connected
    with pytest.raises(ValueError, match="no joint elbow"):
        leader(options, joints={"shoulder_pan.pos": "elbow"})
    made, arm = leader(options, joints={"shoulder_pan.pos": "right_shoulder_yaw"})
    arm.values = {"shoulder_pan.pos": 1.0}
    made.connect()


def test_proposed_poses_pass_through_the_reflex(options: dict[str, Any]) -> None:
    """An operator who closes the keys fully does not crush the object."""
    one = AtasSimulation(AtasSimulationConfig(**options, item="paper-box", seed=1))
    one.connect()
    hint = one.simulation.hint
    made, keys = keyboard(options)
    made.pose = dict(zip(one.action_features, (*hint["at"], hint["yaw"], 0.07), strict=True))
    for _ in range(150):
        one.send_action(made.get_action())
    keys.pressed = ["c"]
    for _ in range(300):
        keys.now_s += 0.02
        one.send_action(made.get_action())
    held = one.simulation.truth["objects"][0]
    assert made.pose["hand.opening"] == 0.0, "the operator closed the hand completely"
    assert not held["crushed"] and one.get_observation()["finger1.in_contact"] == 1.0


def test_states_of_the_connection_raise_lerobots_errors(options: dict[str, Any]) -> None:
    made, _keys = keyboard(options)
    with pytest.raises(DeviceAlreadyConnectedError):
        made.connect()
    made.disconnect()
    for call in (made.get_action, made.disconnect):
        with pytest.raises(DeviceNotConnectedError):
            call()
    lost = AtasKeyboard(AtasKeyboardConfig(**options, bus="no-such-bus"), pressed=list)
    with pytest.raises(DeviceNotConnectedError, match="could not read the pose"):
        lost.connect()


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"start": [1.0]}, "5 finite numbers"),
        ({"leader": ""}, "needs the type of a leader arm"),
        ({"leader": "atas_leader"}, "needs the type of a leader arm"),
        ({"scale": 0.0}, "other than 0"),
        ({"gripper_range": [1.0, 1.0]}, "two different values"),
        ({"motion_scale": math.nan}, "motion_scale is nan"),
    ],
)
def test_invalid_option_is_refused(options: dict[str, Any], option: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        AtasLeaderConfig(**options, **{"leader": "arm", **option})
